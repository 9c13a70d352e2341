//! The figures of a sample in columns, every one with its SI unit: what `replay --csv` writes and what a
//! [`Recording`](super::Recording) keeps.

use super::{BodyState, ContactSample, Energy, FingerState, Layout, Sample};

/// A figure of a sample.
#[derive(Clone, Debug)]
pub struct Column {
    /// With its unit, such as `distal_normal_n`.
    pub name: String,
    get: Get,
}

/// How a figure is read off a sample; the number is that of the finger, body or contact.
#[derive(Clone, Copy, Debug)]
enum Get {
    Time,
    Finger(usize, fn(&FingerState) -> f64),
    Body(usize, fn(&BodyState) -> f64),
    Contact(usize, fn(&ContactSample) -> f64),
    Energy(fn(&Energy) -> f64),
}

/// The figures of one kind of part, by name and unit.
type Figures<T> = [(&'static str, fn(&T) -> f64)];

const TIME: &str = "time_s";
const FINGER: &Figures<FingerState> = &[
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
const BODY: &Figures<BodyState> = &[
    ("x_m", |body| body.centre_m[0]),
    ("y_m", |body| body.centre_m[1]),
    ("angle_rad", |body| body.angle_rad),
    ("vx_m_s", |body| body.velocity_m_s[0]),
    ("vy_m_s", |body| body.velocity_m_s[1]),
    ("spin_rad_s", |body| body.spin_rad_s),
];
const SURFACE: &Figures<ContactSample> = &[
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
/// Of a contact whose gap is an angle.
const STOP: &Figures<ContactSample> = &[
    ("gap_rad", |contact| contact.gap_m),
    ("gap_rate_rad_s", |contact| contact.gap_rate_m_s),
    ("torque_n_m", |contact| contact.normal_n),
    ("impulse_n_m_s", |contact| contact.impulse_n_s),
];
const ENERGY: &Figures<Energy> = &[
    ("kinetic_j", |energy| energy.kinetic_j),
    ("gravity_j", |energy| energy.gravity_j),
    ("spring_j", |energy| energy.spring_j),
    ("elastic_j", |energy| energy.elastic_j),
    ("dissipated_j", |energy| energy.dissipated_j),
    ("motor_work_j", |energy| energy.motor_work_j),
    ("balance_j", |energy| energy.balance_j),
];

impl Column {
    /// Where there is nothing to touch a gap is infinite, and no figure of the contact is a number.
    pub fn value(&self, sample: &Sample) -> f64 {
        match self.get {
            Get::Time => sample.time_s,
            Get::Finger(index, of) => of(&sample.fingers[index]),
            Get::Body(index, of) => of(&sample.bodies[index]),
            Get::Contact(index, of) => {
                let contact = &sample.contacts[index];
                if contact.gap_m.is_finite() { of(contact) } else { f64::NAN }
            }
            Get::Energy(of) => of(&sample.energy),
        }
    }
}

/// The columns of samples of this layout: the time, the fingers, the bodies, the contacts, the energies.
pub fn columns(layout: &Layout) -> Vec<Column> {
    let mut columns = vec![Column { name: TIME.to_string(), get: Get::Time }];
    for (index, name) in layout.fingers.iter().enumerate() {
        part(&mut columns, name, FINGER, |of| Get::Finger(index, of));
    }
    for (index, name) in layout.bodies.iter().enumerate() {
        part(&mut columns, name, BODY, |of| Get::Body(index, of));
    }
    for (index, place) in layout.contacts.iter().enumerate() {
        part(&mut columns, &place.name, if place.angular { STOP } else { SURFACE }, |of| Get::Contact(index, of));
    }
    part(&mut columns, "", ENERGY, Get::Energy);
    columns
}

fn part<T>(columns: &mut Vec<Column>, name: &str, figures: &Figures<T>, get: impl Fn(fn(&T) -> f64) -> Get) {
    for &(figure, of) in figures {
        let name = if name.is_empty() { figure.to_string() } else { format!("{name}_{figure}") };
        columns.push(Column { name, get: get(of) });
    }
}

/// Whether these are the columns of samples: time first, the energies last, whatever is between.
pub fn are_of_samples(columns: &[&str]) -> bool {
    let energies = ENERGY.iter().map(|(name, _)| name);
    columns.first() == Some(&TIME)
        && columns.len() > ENERGY.len()
        && columns[columns.len() - ENERGY.len()..].iter().eq(energies)
}
