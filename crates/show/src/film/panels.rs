//! The plots of a scene.

use super::develop::{Curve, Plan, Scale, plan};
use crate::numeric::plane::turned;
use crate::scene::{BodiesScene, Scene};
use crate::trace::{BodyState, ContactSample, FingerState, Sample, Site};

/// A quantity of a disc, by its name, and its rate.
type OfDisc = (&'static str, fn(&BodyState) -> f64, Option<fn(&BodyState) -> f64>);

/// Of a finger; `contacts` are those that are shown, by their names and indices.
pub(super) fn of_finger(scene: &Scene, contacts: &[(String, usize)]) -> Vec<Plan<'static>> {
    let law = &scene.contact;
    let friction = match (law.proximal.friction, law.distal.friction) {
        (None, None) => Vec::new(),
        _ => of_contacts(contacts, |contact| contact.tangential_n),
    };
    let mut angles = vec![
        joint("q11", |finger| turned(finger.q11_rad)).with_rate(|sample| sample.finger().qd11_rad_s),
        joint("q21", |finger| turned(finger.q21_rad)).with_rate(|sample| sample.finger().qd21_rad_s),
        joint("q22", |finger| turned(finger.q22_rad)).with_rate(|sample| sample.finger().qd22_rad_s),
    ];
    let mut torques = vec![joint("motor", |finger| finger.motor_torque_n_m)];
    if scene.limit.is_some() {
        let to_limit = Curve::new("to limit", |sample: &Sample| sample.contact(Site::Limit).gap_m);
        angles.push(to_limit.with_rate(|sample| sample.contact(Site::Limit).gap_rate_m_s));
        torques.push(Curve::new("limit", |sample: &Sample| sample.contact(Site::Limit).normal_n));
    }
    vec![
        plan("Normal force", "N", Scale::Logarithmic, of_contacts(contacts, |contact| contact.normal_n)),
        plan("Friction force", "N", Scale::Logarithmic, friction),
        plan("Gap", "m", Scale::Logarithmic, gaps(contacts)),
        plan("Joint angle", "rad", Scale::Linear, angles),
        plan(
            "Joint rate",
            "rad/s",
            Scale::Linear,
            vec![
                joint("qd11", |finger| finger.qd11_rad_s),
                joint("qd21", |finger| finger.qd21_rad_s),
                joint("qd22", |finger| finger.qd22_rad_s),
            ],
        ),
        energies(),
        plan("Torque", "N·m", Scale::Linear, torques),
    ]
}

/// Energies of a scene with fingers.
pub(super) fn energies() -> Plan<'static> {
    let curves = vec![
        curve("kinetic", |s| s.energy.kinetic_j),
        curve("motor work", |s| s.energy.motor_work_j),
        curve("dissipated", |s| s.energy.dissipated_j),
        curve("spring", |s| s.energy.spring_j),
        curve("contact", |s| s.energy.elastic_j),
        curve("gravity", |s| s.energy.gravity_j),
        curve("balance", |s| s.energy.balance_j),
    ];
    plan("Energy", "J", Scale::Linear, curves)
}

/// Of discs.
pub(super) fn of_discs(scene: &BodiesScene, contacts: &[(String, usize)]) -> Vec<Plan<'static>> {
    let discs = |quantities: &[OfDisc]| -> Vec<Curve<'static>> {
        let moving = scene.discs.iter().enumerate().filter(|(_, disc)| disc.motion.moves());
        let mut curves: Vec<Curve<'static>> = Vec::new();
        for (index, disc) in moving {
            for &(quantity, value, rate) in quantities {
                let name = format!("{} {quantity}", disc.name);
                let curve = Curve::new(name, move |sample: &Sample| value(&sample.bodies[index]));
                curves.push(match rate {
                    Some(rate) => curve.with_rate(move |sample| rate(&sample.bodies[index])),
                    None => curve,
                });
            }
        }
        curves
    };
    let friction = match scene.contact.friction {
        Some(_) => of_contacts(contacts, |contact| contact.tangential_n),
        None => Vec::new(),
    };
    vec![
        plan("Normal force", "N", Scale::Linear, of_contacts(contacts, |contact| contact.normal_n)),
        plan("Friction force", "N", Scale::Linear, friction),
        plan("Gap", "m", Scale::Linear, gaps(contacts)),
        plan(
            "Place",
            "m",
            Scale::Linear,
            discs(&[
                ("x", |disc| disc.centre_m[0], Some(|disc| disc.velocity_m_s[0])),
                ("y", |disc| disc.centre_m[1], Some(|disc| disc.velocity_m_s[1])),
            ]),
        ),
        plan(
            "Velocity",
            "m/s",
            Scale::Linear,
            discs(&[("vx", |disc| disc.velocity_m_s[0], None), ("vy", |disc| disc.velocity_m_s[1], None)]),
        ),
        plan("Spin", "rad/s", Scale::Linear, discs(&[("spin", |disc| disc.spin_rad_s, None)])),
        plan(
            "Energy",
            "J",
            Scale::Linear,
            vec![
                curve("kinetic", |s| s.energy.kinetic_j),
                curve("drive work", |s| s.energy.motor_work_j),
                curve("dissipated", |s| s.energy.dissipated_j),
                curve("contact", |s| s.energy.elastic_j),
                curve("gravity", |s| s.energy.gravity_j),
                curve("balance", |s| s.energy.balance_j),
            ],
        ),
    ]
}

fn curve(name: &str, value: fn(&Sample) -> f64) -> Curve<'static> {
    Curve::new(name, value)
}

fn joint(name: &str, value: fn(&FingerState) -> f64) -> Curve<'static> {
    Curve::new(name, move |sample: &Sample| value(sample.finger()))
}

pub(super) fn of_contacts(contacts: &[(String, usize)], value: fn(&ContactSample) -> f64) -> Vec<Curve<'static>> {
    let of = |(name, index): &(String, usize)| {
        let index = *index;
        Curve::new(name, move |sample: &Sample| value(&sample.contacts[index]))
    };
    contacts.iter().map(of).collect()
}

pub(super) fn gaps(contacts: &[(String, usize)]) -> Vec<Curve<'static>> {
    let of = |(gap, (_, index)): (Curve<'static>, &(String, usize))| {
        let index = *index;
        gap.with_rate(move |sample: &Sample| sample.contacts[index].gap_rate_m_s)
    };
    of_contacts(contacts, |contact| contact.gap_m).into_iter().zip(contacts).map(of).collect()
}
