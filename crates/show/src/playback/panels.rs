//! Plots of discs, and helpers shared by all plots.

use super::build::{Curve, PanelPlan, Scale, panel_plan};
use crate::scene::System;
use crate::trace::{BodyState, ContactSample, Sample};

/// Name of a quantity of a body or finger, and functions for its value and, optionally, its rate.
pub(super) type Quantity<T> = (&'static str, fn(&T) -> f64, Option<fn(&T) -> f64>);

/// Panel of the energies of a scene with fingers.
pub(super) fn energy_panel() -> PanelPlan<'static> {
    let curves = vec![
        curve("kinetic", |s| s.energy.kinetic_j),
        curve("motor work", |s| s.energy.motor_work_j),
        curve("dissipated", |s| s.energy.dissipated_j),
        curve("spring", |s| s.energy.spring_j),
        curve("contact", |s| s.energy.elastic_j),
        curve("gravity", |s| s.energy.gravity_j),
        curve("balance", |s| s.energy.balance_j),
    ];
    panel_plan("Energy", "J", Scale::Linear, curves)
}

/// Panels of a scene of discs.
pub(super) fn disc_panels(system: &System, contacts: &[(String, usize)]) -> Vec<PanelPlan<'static>> {
    let moving = system.discs.iter().enumerate().filter(|(_, disc)| disc.motion.moves());
    let moving: Vec<(usize, String)> = moving.map(|(index, disc)| (index, disc.name.clone())).collect();
    let discs = |quantities: &[Quantity<BodyState>]| curves(&moving, quantities, |sample| &sample.bodies);
    let friction = match system.between_discs.and_then(|law| law.friction) {
        Some(_) => contact_curves(contacts, |contact| contact.tangential_n),
        None => Vec::new(),
    };
    vec![
        panel_plan("Normal force", "N", Scale::Linear, contact_curves(contacts, |contact| contact.normal_n)),
        panel_plan("Friction force", "N", Scale::Linear, friction),
        panel_plan("Gap", "m", Scale::Linear, gap_curves(contacts)),
        panel_plan(
            "Position",
            "m",
            Scale::Linear,
            discs(&[
                ("x", |disc| disc.centre_m[0], Some(|disc| disc.velocity_m_s[0])),
                ("y", |disc| disc.centre_m[1], Some(|disc| disc.velocity_m_s[1])),
            ]),
        ),
        panel_plan(
            "Velocity",
            "m/s",
            Scale::Linear,
            discs(&[("vx", |disc| disc.velocity_m_s[0], None), ("vy", |disc| disc.velocity_m_s[1], None)]),
        ),
        panel_plan("Spin", "rad/s", Scale::Linear, discs(&[("spin", |disc| disc.spin_rad_s, None)])),
        panel_plan(
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

/// Curves of the same quantities for several bodies or fingers, each given by index and name; a single one has an empty
/// name.
pub(super) fn curves<T: 'static>(
    items: &[(usize, String)],
    quantities: &[Quantity<T>],
    states: fn(&Sample) -> &[T],
) -> Vec<Curve<'static>> {
    let mut curves = Vec::with_capacity(items.len() * quantities.len());
    for (index, part) in items {
        let index = *index;
        for &(quantity, value, rate) in quantities {
            let curve = Curve::new(curve_name(part, quantity), move |sample: &Sample| value(&states(sample)[index]));
            curves.push(match rate {
                Some(rate) => curve.with_rate(move |sample| rate(&states(sample)[index])),
                None => curve,
            });
        }
    }
    curves
}

/// Name of a curve: body or finger, then quantity. An empty name of the former is omitted.
pub(super) fn curve_name(part: &str, quantity: &str) -> String {
    if part.is_empty() { quantity.to_string() } else { format!("{part} {quantity}") }
}

fn curve(name: &str, value: fn(&Sample) -> f64) -> Curve<'static> {
    Curve::new(name, value)
}

pub(super) fn contact_curves(contacts: &[(String, usize)], value: fn(&ContactSample) -> f64) -> Vec<Curve<'static>> {
    let curve = |(name, index): &(String, usize)| {
        let index = *index;
        Curve::new(name, move |sample: &Sample| value(&sample.contacts[index]))
    };
    contacts.iter().map(curve).collect()
}

pub(super) fn gap_curves(contacts: &[(String, usize)]) -> Vec<Curve<'static>> {
    let with_gap_rate = |(gap, (_, index)): (Curve<'static>, &(String, usize))| {
        let index = *index;
        gap.with_rate(move |sample: &Sample| sample.contacts[index].gap_rate_m_s)
    };
    contact_curves(contacts, |contact| contact.gap_m).into_iter().zip(contacts).map(with_gap_rate).collect()
}
