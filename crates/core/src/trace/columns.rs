//! Columns of a sample, each with its SI unit: written by `replay --csv` and stored by a
//! [`Recording`](super::Recording).

use super::{BodyState, Channels, ContactSample, Energy, FingerState, Layout, Sample};

/// One value of a sample.
#[derive(Clone, Debug)]
pub struct Column {
    /// Name with unit, such as `distal_normal_n`.
    pub name: String,
    part: Part,
    /// Index of the value among those of its part.
    value: usize,
}

/// Part of a sample; the number is the index of the finger, body or contact.
#[derive(Clone, Copy, Debug)]
enum Part {
    Time,
    Finger(usize),
    Body(usize),
    Contact(usize),
    Energy,
}

const TIME: &str = "time_s";
/// Columns of a contact whose gap is an angle, with the indices of their values.
const STOP: [(usize, &str); 4] = [(0, "gap_rad"), (1, "gap_rate_rad_s"), (3, "torque_n_m"), (5, "impulse_n_m_s")];

impl Column {
    /// Returns the value in a sample; NaN for contacts that do not exist, whose gap is infinite.
    pub fn value(&self, sample: &Sample) -> f64 {
        match self.part {
            Part::Time => sample.time_s,
            Part::Finger(index) => sample.fingers[index].values()[self.value],
            Part::Body(index) => sample.bodies[index].values()[self.value],
            Part::Contact(index) if !sample.contacts[index].gap_m.is_finite() => f64::NAN,
            Part::Contact(index) => sample.contacts[index].values()[self.value],
            Part::Energy => sample.energy.values()[self.value],
        }
    }
}

/// Returns the columns of samples of this layout: time, fingers, bodies, contacts, energies.
pub fn columns(layout: &Layout) -> Vec<Column> {
    let mut columns = vec![Column { name: TIME.to_string(), part: Part::Time, value: 0 }];
    let mut add = |owner: &str, part: Part, values: &mut dyn Iterator<Item = (usize, &str)>| {
        columns.extend(values.map(|(value, name)| {
            let name = if owner.is_empty() { name.to_string() } else { format!("{owner}_{name}") };
            Column { name, part, value }
        }));
    };
    for (index, name) in layout.fingers.iter().enumerate() {
        add(name, Part::Finger(index), &mut FingerState::NAMES.into_iter().enumerate());
    }
    for (index, name) in layout.bodies.iter().enumerate() {
        add(name, Part::Body(index), &mut BodyState::NAMES.into_iter().enumerate());
    }
    for (index, contact) in layout.contacts.iter().enumerate() {
        match contact.is_angular {
            true => add(&contact.name, Part::Contact(index), &mut STOP.into_iter()),
            false => add(&contact.name, Part::Contact(index), &mut ContactSample::NAMES.into_iter().enumerate()),
        }
    }
    add("", Part::Energy, &mut Energy::NAMES.into_iter().enumerate());
    columns
}

/// Whether these are columns of samples: time first and the energies last.
pub fn are_sample_columns(columns: &[&str]) -> bool {
    columns.len() > Energy::NAMES.len() && columns[0] == TIME && columns.ends_with(&Energy::NAMES)
}
