//! Turns a state of the analytic model into a sample.

use super::{ContactSample, Energy, Sample, Site};
use crate::analytic::{Energies, Model, QUADRATURES, SiteReading, Snapshot};
use crate::integrator::State;

/// Everything about one state.
///
/// `start` has the energies at the start of the run, from which works and losses count.
pub(super) fn sample(
    model: &Model,
    t: f64,
    state: &State<2, QUADRATURES>,
    snapshot: &Snapshot,
    start: &Energies,
) -> Sample {
    let Snapshot { passive, sites, energies } = snapshot;
    let (contact_work, motor_work) = (state.z[3], state.z[4]);
    let gained =
        (energies.kinetic - start.kinetic) + (energies.gravity - start.gravity) + (energies.spring - start.spring);
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
        motor_torque_n_m: model.motor_torque(t),
        proximal: contact_sample(&sites[Site::Proximal as usize], state.z[0]),
        distal: contact_sample(&sites[Site::Distal as usize], state.z[1]),
        limit: contact_sample(&sites[Site::Limit as usize], state.z[2]),
        energy: Energy {
            kinetic_j: energies.kinetic,
            gravity_j: energies.gravity,
            spring_j: energies.spring,
            elastic_j: energies.elastic,
            dissipated_j: start.elastic - energies.elastic - contact_work,
            motor_work_j: motor_work,
            balance_j: gained - contact_work - motor_work,
        },
    }
}

fn contact_sample(reading: &Option<SiteReading>, impulse_n_s: f64) -> ContactSample {
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
