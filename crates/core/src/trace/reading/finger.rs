//! A finger in a state of the analytic model.

use super::{Reader, contact_sample, refill, stored};
use crate::analytic::{FingerMode, FingerMotion, QUADRATURES};
use crate::integrator::State;
use crate::trace::{ContactSample, Energy, FingerState, Sample, Site, Wants};

impl<const N: usize, const W: usize> Reader<N, QUADRATURES> for FingerMotion<N, W> {
    type Mode = FingerMode;

    fn read(
        &self,
        t: f64,
        state: &State<N, QUADRATURES>,
        mode: &FingerMode,
        start: &Energy,
        wants: Wants,
        sample: &mut Sample,
    ) {
        let snapshot = self.snapshot_of(state.q, state.v, mode, (wants.passive, wants.energies));
        let (passive, energies) = (&snapshot.passive, &snapshot.energies);
        let at = |site: Site| contact_sample(snapshot.sites[site as usize], state.z[site as usize]);
        let [.., contact_work, motor_work] = state.z;
        let finger = FingerState {
            q11_rad: state.q[0],
            q21_rad: state.q[1],
            q12_rad: passive.q12,
            q22_rad: passive.q22,
            q13_rad: passive.q13,
            qd11_rad_s: state.v[0],
            qd21_rad_s: state.v[1],
            qd12_rad_s: passive.qd12,
            qd22_rad_s: passive.qd22,
            motor_torque_n_m: if wants.passive { self.motor_torque(t) } else { 0.0 },
        };
        sample.time_s = t;
        refill(&mut sample.fingers, std::iter::once(finger));
        refill(&mut sample.contacts, Site::ALL.into_iter().map(at));
        sample.energy =
            if wants.energies { stored(energies).since(start, contact_work, motor_work) } else { Energy::default() };
    }

    fn slips(&self, index: usize, mode: &FingerMode) -> Option<bool> {
        mode.slips_at(index).filter(|_| self.bristle(Site::ALL[index]).is_some())
    }

    fn contact(&self, state: &State<N, QUADRATURES>, index: usize, mode: &FingerMode) -> ContactSample {
        contact_sample(self.reading(state.q, state.v, Site::ALL[index], mode[index]), state.z[index])
    }
}
