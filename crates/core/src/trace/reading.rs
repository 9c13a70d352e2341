//! Turns a state of the analytic model into a sample.

use std::ops::Index;

use super::{ContactSample, Energy, Instant, Sample, Site};
use crate::analytic::{Mode, Model, QUADRATURES, SiteReading, SiteState};
use crate::integrator::State;

/// Reads the states of a model.
pub(super) trait Reader<const N: usize, const Z: usize> {
    type Sample: Instant;
    /// Branches of the laws of all contacts.
    type Mode: Copy + Index<usize, Output = SiteState>;

    /// Everything about one state; `start` has the energies at the start of the run, from which works and losses count.
    fn sample(&self, t: f64, state: &State<N, Z>, mode: &Self::Mode, start: &Energy) -> Self::Sample;

    /// One contact of it.
    fn contact(&self, state: &State<N, Z>, place: usize, mode: &Self::Mode) -> ContactSample;
}

impl Reader<2, QUADRATURES> for Model {
    type Sample = Sample;
    type Mode = Mode;

    fn sample(&self, t: f64, state: &State<2, QUADRATURES>, mode: &Mode, start: &Energy) -> Sample {
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
        Sample {
            time_s: t,
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
            proximal: at(Site::Proximal),
            distal: at(Site::Distal),
            limit: at(Site::Limit),
            energy: stored.since(start, contact_work, motor_work),
        }
    }

    fn contact(&self, state: &State<2, QUADRATURES>, place: usize, mode: &Mode) -> ContactSample {
        contact(&self.reading(state.q, state.v, Site::ALL[place], mode[place]), state.z[place])
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
