//! A finger in a state of the analytic model.

use super::{Reader, refill};
use crate::analytic::{Mode, Model, QUADRATURES, SiteReading};
use crate::integrator::State;
use crate::trace::{ContactSample, Energy, FingerState, Sample, Site};

impl Reader<2, QUADRATURES> for Model {
    type Mode = Mode;

    fn read(&self, t: f64, state: &State<2, QUADRATURES>, mode: &Mode, start: &Energy, sample: &mut Sample) {
        let snapshot = self.snapshot(state.q, state.v, mode);
        let (passive, energies) = (&snapshot.passive, &snapshot.energies);
        let at = |site: Site| contact(&snapshot.sites[site as usize], state.z[site as usize]);
        let stored = Energy {
            kinetic_j: energies.kinetic,
            gravity_j: energies.gravity,
            spring_j: energies.spring,
            elastic_j: energies.elastic,
            ..Energy::default()
        };
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
            motor_torque_n_m: self.motor_torque(t),
        };
        sample.time_s = t;
        refill(&mut sample.fingers, std::iter::once(finger));
        refill(&mut sample.contacts, Site::ALL.into_iter().map(at));
        sample.energy = stored.since(start, contact_work, motor_work);
    }

    fn contact(&self, state: &State<2, QUADRATURES>, index: usize, mode: &Mode) -> ContactSample {
        contact(&self.reading(state.q, state.v, Site::ALL[index], mode[index]), state.z[index])
    }
}

fn contact(reading: &Option<SiteReading>, impulse_n_s: f64) -> ContactSample {
    reading.map_or(ContactSample::NONE, |r| ContactSample {
        gap_m: -r.delta,
        gap_rate_m_s: -r.delta_rate,
        slip_m_s: r.slip,
        normal_n: r.normal,
        tangential_n: r.tangential,
        impulse_n_s,
        point_m: r.geometry.point,
        normal: r.geometry.normal,
    })
}
