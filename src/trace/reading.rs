//! Turns a state of the analytic model into a sample.

use super::{ContactSample, Energy, LimitSample, Sample, Site};
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
        proximal: contact_sample(&sites[Site::Proximal as usize]),
        distal: contact_sample(&sites[Site::Distal as usize]),
        limit: sites[Site::Limit as usize].map_or(
            LimitSample { gap_rad: f64::INFINITY, gap_rate_rad_s: 0.0, torque_n_m: 0.0 },
            |r| LimitSample { gap_rad: -r.delta, gap_rate_rad_s: -r.delta_rate, torque_n_m: r.normal },
        ),
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

fn contact_sample(reading: &Option<SiteReading>) -> ContactSample {
    match reading {
        None => ContactSample {
            gap_m: f64::INFINITY,
            gap_rate_m_s: 0.0,
            slip_m_s: 0.0,
            normal_n: 0.0,
            tangential_n: 0.0,
            point_m: [0.0; 2],
            normal: [0.0; 2],
        },
        Some(r) => ContactSample {
            gap_m: -r.delta,
            gap_rate_m_s: -r.delta_rate,
            slip_m_s: r.slip,
            normal_n: r.normal,
            tangential_n: r.tangential,
            point_m: r.geometry.point,
            normal: r.geometry.normal,
        },
    }
}
