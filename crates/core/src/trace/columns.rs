//! Columns of a sample, each with its SI unit: written by `replay --csv` and stored by a
//! [`Recording`](super::Recording).

use super::{BodyState, ContactSample, Energy, FingerState, Layout, Sample};

/// One value of a sample.
#[derive(Clone, Debug)]
pub struct Column {
    /// Name with unit, such as `distal_normal_n`.
    pub name: String,
    get: Accessor,
}

/// How a value is read from a sample; the number is the index of the finger, body or contact.
#[derive(Clone, Copy, Debug)]
enum Accessor {
    Time,
    Finger(usize, fn(&FingerState) -> f64),
    Body(usize, fn(&BodyState) -> f64),
    Contact(usize, fn(&ContactSample) -> f64),
    Energy(fn(&Energy) -> f64),
}

/// Names and accessors of the values of one kind of component.
type NamedAccessors<T> = [(&'static str, fn(&T) -> f64)];

const TIME: &str = "time_s";
const FINGER: &NamedAccessors<FingerState> = &[
    ("q11_rad", |finger| finger.q11_rad),
    ("q21_rad", |finger| finger.q21_rad),
    ("q12_rad", |finger| finger.q12_rad),
    ("q22_rad", |finger| finger.q22_rad),
    ("q13_rad", |finger| finger.q13_rad),
    ("qd11_rad_s", |finger| finger.qd11_rad_s),
    ("qd21_rad_s", |finger| finger.qd21_rad_s),
    ("qd12_rad_s", |finger| finger.qd12_rad_s),
    ("qd22_rad_s", |finger| finger.qd22_rad_s),
    ("motor_torque_n_m", |finger| finger.motor_torque_n_m),
];
const BODY: &NamedAccessors<BodyState> = &[
    ("x_m", |body| body.centre_m[0]),
    ("y_m", |body| body.centre_m[1]),
    ("angle_rad", |body| body.angle_rad),
    ("vx_m_s", |body| body.velocity_m_s[0]),
    ("vy_m_s", |body| body.velocity_m_s[1]),
    ("spin_rad_s", |body| body.spin_rad_s),
];
const SURFACE: &NamedAccessors<ContactSample> = &[
    ("gap_m", |contact| contact.gap_m),
    ("gap_rate_m_s", |contact| contact.gap_rate_m_s),
    ("slip_m_s", |contact| contact.slip_m_s),
    ("normal_n", |contact| contact.normal_n),
    ("tangential_n", |contact| contact.tangential_n),
    ("impulse_n_s", |contact| contact.impulse_n_s),
    ("point_x_m", |contact| contact.point_m[0]),
    ("point_y_m", |contact| contact.point_m[1]),
    ("normal_x", |contact| contact.normal[0]),
    ("normal_y", |contact| contact.normal[1]),
];
/// Columns of a contact whose gap is an angle.
const STOP: &NamedAccessors<ContactSample> = &[
    ("gap_rad", |contact| contact.gap_m),
    ("gap_rate_rad_s", |contact| contact.gap_rate_m_s),
    ("torque_n_m", |contact| contact.normal_n),
    ("impulse_n_m_s", |contact| contact.impulse_n_s),
];
const ENERGY: &NamedAccessors<Energy> = &[
    ("kinetic_j", |energy| energy.kinetic_j),
    ("gravity_j", |energy| energy.gravity_j),
    ("spring_j", |energy| energy.spring_j),
    ("elastic_j", |energy| energy.elastic_j),
    ("dissipated_j", |energy| energy.dissipated_j),
    ("motor_work_j", |energy| energy.motor_work_j),
    ("balance_j", |energy| energy.balance_j),
];

impl Column {
    /// Returns the value in a sample; NaN for contacts that do not exist, whose gap is infinite.
    pub fn value(&self, sample: &Sample) -> f64 {
        match self.get {
            Accessor::Time => sample.time_s,
            Accessor::Finger(index, get) => get(&sample.fingers[index]),
            Accessor::Body(index, get) => get(&sample.bodies[index]),
            Accessor::Contact(index, get) => {
                let contact = &sample.contacts[index];
                if contact.gap_m.is_finite() { get(contact) } else { f64::NAN }
            }
            Accessor::Energy(get) => get(&sample.energy),
        }
    }
}

/// Returns the columns of samples of this layout: time, fingers, bodies, contacts, energies.
pub fn columns(layout: &Layout) -> Vec<Column> {
    let mut columns = vec![Column { name: TIME.to_string(), get: Accessor::Time }];
    for (index, name) in layout.fingers.iter().enumerate() {
        add_columns(&mut columns, name, FINGER, |value| Accessor::Finger(index, value));
    }
    for (index, name) in layout.bodies.iter().enumerate() {
        add_columns(&mut columns, name, BODY, |value| Accessor::Body(index, value));
    }
    for (index, contact) in layout.contacts.iter().enumerate() {
        add_columns(&mut columns, &contact.name, if contact.is_angular { STOP } else { SURFACE }, |value| {
            Accessor::Contact(index, value)
        });
    }
    add_columns(&mut columns, "", ENERGY, Accessor::Energy);
    columns
}

fn add_columns<T>(
    columns: &mut Vec<Column>,
    name: &str,
    fields: &NamedAccessors<T>,
    get: impl Fn(fn(&T) -> f64) -> Accessor,
) {
    for &(field, value) in fields {
        let name = if name.is_empty() { field.to_string() } else { format!("{name}_{field}") };
        columns.push(Column { name, get: get(value) });
    }
}

/// Whether these are columns of samples: time first and the energies last.
pub fn are_sample_columns(columns: &[&str]) -> bool {
    let energies = ENERGY.iter().map(|(name, _)| name);
    columns.first() == Some(&TIME)
        && columns.len() > ENERGY.len()
        && columns[columns.len() - ENERGY.len()..].iter().eq(energies)
}
