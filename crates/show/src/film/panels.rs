//! The plots of discs, and what all plots have.

use super::develop::{Curve, Plan, Scale, plan};
use crate::scene::System;
use crate::trace::{BodyState, ContactSample, Sample};

/// A quantity of a part of a sample, by its name, and its rate.
pub(super) type Quantity<T> = (&'static str, fn(&T) -> f64, Option<fn(&T) -> f64>);

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
pub(super) fn of_discs(system: &System, contacts: &[(String, usize)]) -> Vec<Plan<'static>> {
    let moving = system.discs.iter().enumerate().filter(|(_, disc)| disc.motion.moves());
    let moving: Vec<(usize, String)> = moving.map(|(index, disc)| (index, disc.name.clone())).collect();
    let discs = |quantities: &[Quantity<BodyState>]| curves(&moving, quantities, |sample| &sample.bodies);
    let friction = match system.between_discs.and_then(|law| law.friction) {
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

/// The same quantities of several parts of a sample, of which each has an index and a name; one that is alone needs none.
pub(super) fn curves<T: 'static>(
    parts: &[(usize, String)],
    quantities: &[Quantity<T>],
    of: fn(&Sample) -> &[T],
) -> Vec<Curve<'static>> {
    let mut curves = Vec::with_capacity(parts.len() * quantities.len());
    for (index, part) in parts {
        let index = *index;
        for &(quantity, value, rate) in quantities {
            let curve = Curve::new(named(part, quantity), move |sample: &Sample| value(&of(sample)[index]));
            curves.push(match rate {
                Some(rate) => curve.with_rate(move |sample| rate(&of(sample)[index])),
                None => curve,
            });
        }
    }
    curves
}

/// A quantity of a part of a sample; one without a name needs none.
pub(super) fn named(part: &str, quantity: &str) -> String {
    if part.is_empty() { quantity.to_string() } else { format!("{part} {quantity}") }
}

fn curve(name: &str, value: fn(&Sample) -> f64) -> Curve<'static> {
    Curve::new(name, value)
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
