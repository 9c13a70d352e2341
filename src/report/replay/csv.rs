//! All samples of a log as comma-separated values: one line each, every figure a column with its unit, in SI.

use std::io::{self, Write};

use super::super::csv::line;
use crate::log::Names;
use crate::trace::bodies::BodiesSample;
use crate::trace::{ContactSample, Sample};

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

/// What the columns are.
#[derive(Clone, Copy, Debug)]
pub enum CsvHead<'a> {
    Finger,
    Discs(&'a Names),
}

impl CsvHead<'_> {
    /// Writes the names of the columns.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut columns = Vec::new();
        let mut part = |name: &str, quantities: &[&str]| {
            columns.extend(quantities.iter().map(|quantity| format!("{name}_{quantity}")));
        };
        match self {
            CsvHead::Finger => {
                part("proximal", &CONTACT);
                part("distal", &CONTACT);
                part("limit", &LIMIT);
                columns.splice(0..0, STATE.map(String::from));
            }
            CsvHead::Discs(names) => {
                names.discs.iter().for_each(|name| part(name, &DISC));
                names.pairs.iter().for_each(|name| part(name, &CONTACT));
                columns.insert(0, STATE[0].to_string());
            }
        }
        columns.extend(ENERGY.map(String::from));
        writeln!(out, "{}", columns.join(","))
    }
}

/// Whether a line names the columns of a table of samples: time first, the energies last, whatever is between.
pub fn is_samples(head: &str) -> bool {
    let columns: Vec<&str> = head.split(',').collect();
    columns.first() == Some(&STATE[0]) && columns.ends_with(&ENERGY)
}

/// Writes a sample of a finger. Without an object or a joint limit their gaps are infinite, and the cells empty.
pub fn csv_finger(out: &mut dyn Write, sample: &Sample) -> io::Result<()> {
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
    let limit = [limit.gap_rad, limit.gap_rate_rad_s, limit.torque_n_m, limit.impulse_n_m_s];
    let values = state.into_iter().chain(contact(&sample.proximal)).chain(contact(&sample.distal));
    line(out, values.chain(where_there(limit)).chain(sample.energy.values_j()))
}

/// Writes a sample of discs.
pub fn csv_discs(out: &mut dyn Write, sample: &BodiesSample) -> io::Result<()> {
    let discs = sample.discs.iter().flat_map(|disc| {
        let ([x, y], [vx, vy]) = (disc.centre_m, disc.velocity_m_s);
        [x, y, disc.angle_rad, vx, vy, disc.spin_rad_s]
    });
    let values = [sample.time_s].into_iter().chain(discs).chain(sample.contacts.iter().flat_map(contact));
    line(out, values.chain(sample.energy.values_j()))
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
