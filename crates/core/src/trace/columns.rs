//! The figures of a sample in columns, every one with its SI unit: what `replay --csv` writes and what a
//! [`Recording`](super::Recording) keeps.

use super::bodies::BodiesSample;
use super::{ContactSample, Sample};

const STATE: [&str; 11] = [
    "time_s",
    "q11_rad",
    "q21_rad",
    "q12_rad",
    "q22_rad",
    "q13_rad",
    "qd11_rad_s",
    "qd21_rad_s",
    "qd12_rad_s",
    "qd22_rad_s",
    "motor_torque_n_m",
];
const CONTACT: [&str; 10] = [
    "gap_m",
    "gap_rate_m_s",
    "slip_m_s",
    "normal_n",
    "tangential_n",
    "impulse_n_s",
    "point_x_m",
    "point_y_m",
    "normal_x",
    "normal_y",
];
const LIMIT: [&str; 4] = ["gap_rad", "gap_rate_rad_s", "torque_n_m", "impulse_n_m_s"];
const DISC: [&str; 6] = ["x_m", "y_m", "angle_rad", "vx_m_s", "vy_m_s", "spin_rad_s"];
const ENERGY: [&str; 7] =
    ["kinetic_j", "gravity_j", "spring_j", "elastic_j", "dissipated_j", "motor_work_j", "balance_j"];

/// The columns of a finger.
pub fn of_finger() -> Vec<String> {
    let mut columns = STATE.map(String::from).to_vec();
    for (name, quantities) in [("proximal", &CONTACT[..]), ("distal", &CONTACT), ("limit", &LIMIT)] {
        part(&mut columns, name, quantities);
    }
    columns.extend(ENERGY.map(String::from));
    columns
}

/// The columns of discs and pairs of these names.
pub fn of_discs(discs: &[String], pairs: &[String]) -> Vec<String> {
    let mut columns = vec![STATE[0].to_string()];
    discs.iter().for_each(|name| part(&mut columns, name, &DISC));
    pairs.iter().for_each(|name| part(&mut columns, name, &CONTACT));
    columns.extend(ENERGY.map(String::from));
    columns
}

fn part(columns: &mut Vec<String>, name: &str, quantities: &[&str]) {
    columns.extend(quantities.iter().map(|quantity| format!("{name}_{quantity}")));
}

/// Whether these are the columns of samples: time first, the energies last, whatever is between.
pub fn are_of_samples(columns: &[&str]) -> bool {
    columns.first() == Some(&STATE[0]) && columns.ends_with(&ENERGY)
}

/// The figures of a finger, in the order of [`of_finger`]. Without an object or a joint limit their gaps are infinite, and
/// no figure of theirs is a number.
pub fn finger_values(sample: &Sample) -> impl Iterator<Item = f64> {
    let state = [
        sample.time_s,
        sample.q11_rad,
        sample.q21_rad,
        sample.q12_rad,
        sample.q22_rad,
        sample.q13_rad,
        sample.qd11_rad_s,
        sample.qd21_rad_s,
        sample.qd12_rad_s,
        sample.qd22_rad_s,
        sample.motor_torque_n_m,
    ];
    let limit = &sample.limit;
    let limit = [limit.gap_m, limit.gap_rate_m_s, limit.normal_n, limit.impulse_n_s];
    let contacts = contact(&sample.proximal).into_iter().chain(contact(&sample.distal));
    state.into_iter().chain(contacts).chain(where_there(limit)).chain(sample.energy.values_j())
}

/// The figures of discs, in the order of [`of_discs`].
pub fn discs_values(sample: &BodiesSample) -> impl Iterator<Item = f64> {
    let discs = sample.discs.iter().flat_map(|disc| {
        let ([x, y], [vx, vy]) = (disc.centre_m, disc.velocity_m_s);
        [x, y, disc.angle_rad, vx, vy, disc.spin_rad_s]
    });
    let contacts = sample.contacts.iter().flat_map(contact);
    [sample.time_s].into_iter().chain(discs).chain(contacts).chain(sample.energy.values_j())
}

fn contact(contact: &ContactSample) -> [f64; 10] {
    where_there([
        contact.gap_m,
        contact.gap_rate_m_s,
        contact.slip_m_s,
        contact.normal_n,
        contact.tangential_n,
        contact.impulse_n_s,
        contact.point_m[0],
        contact.point_m[1],
        contact.normal[0],
        contact.normal[1],
    ])
}

/// Figures of which the first is a gap; where it is infinite there is nothing to touch, and no figure is one.
fn where_there<const N: usize>(figures: [f64; N]) -> [f64; N] {
    if figures[0].is_finite() { figures } else { [f64::NAN; N] }
}
