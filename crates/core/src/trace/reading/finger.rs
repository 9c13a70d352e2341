//! Samples of the finger kernel of the analytic model.

use super::{Reader, contact_sample, refill, stored_energy};
use crate::analytic::{FingerMode, FingerMotion, QUADRATURES};
use crate::integrator::State;
use crate::trace::{ContactSample, Energy, FingerContact, FingerState, RequiredData, Sample};

impl<const N: usize, const W: usize> Reader<N, QUADRATURES> for FingerMotion<N, W> {
    type Mode = FingerMode;

    fn read(
        &self,
        t: f64,
        state: &State<N, QUADRATURES>,
        mode: &FingerMode,
        start: &Energy,
        required_data: RequiredData,
        sample: &mut Sample,
    ) {
        let snapshot = self.partial_snapshot(state.q, state.v, mode, (required_data.passive, required_data.energies));
        let (passive, energies) = (&snapshot.passive, &snapshot.energies);
        let sample_contact =
            |site: FingerContact| contact_sample(snapshot.contacts[site as usize], state.z[site as usize]);
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
            motor_torque_n_m: if required_data.passive { self.motor_torque(t) } else { 0.0 },
        };
        sample.time_s = t;
        refill(&mut sample.fingers, std::iter::once(finger));
        refill(&mut sample.contacts, FingerContact::ALL.into_iter().map(sample_contact));
        sample.energy = if required_data.energies {
            stored_energy(energies).relative_to(start, contact_work, motor_work)
        } else {
            Energy::default()
        };
    }

    fn is_slipping(&self, index: usize, mode: &FingerMode) -> Option<bool> {
        mode.is_slipping(index).filter(|_| self.bristle(FingerContact::ALL[index]).is_some())
    }

    fn contact(&self, state: &State<N, QUADRATURES>, index: usize, mode: &FingerMode) -> ContactSample {
        contact_sample(self.contact_reading(state.q, state.v, FingerContact::ALL[index], mode[index]), state.z[index])
    }
}
