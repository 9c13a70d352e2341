//! The panels of two runs of a gripper.

use super::overlay_panel::{Panel, Quantity, energies, quantity};
use super::theme::{AMBER, BLUE, Colour, GREEN, ORANGE, PURPLE, SERIES, SOFT};
use crate::trace::{ContactSample, FingerState, Layout};
use crate::validate::{Recording, turned};

/// Colours of the angles of the right finger, then of the left one.
const OF_FINGERS: [[Colour; 3]; 2] = [[BLUE, ORANGE, GREEN], [PURPLE, AMBER, SOFT]];

/// A quantity of a finger: its name and value.
type OfFinger = (&'static str, fn(&FingerState) -> f64);

/// Joints of both fingers, the object's place, forces and gaps of the contacts that touch, energies.
pub(super) fn of_gripper(layout: &Layout, runs: [&Recording; 2]) -> Vec<Panel> {
    let touched =
        |index: usize| runs.iter().any(|run| run.outcome.contacts.get(index).is_some_and(|of| of.first_s.is_some()));
    let shown: Vec<usize> = layout.surfaces().filter(|index| touched(*index)).collect();
    let mut panels = vec![
        Panel { label: "joint angle, deg", log: false, quantities: angles(layout) },
        Panel { label: "object, mm", log: false, quantities: object() },
    ];
    if !shown.is_empty() {
        panels.push(Panel {
            label: "normal force, N",
            log: true,
            quantities: contacts(layout, &shown, |contact| contact.normal_n),
        });
        panels.push(Panel {
            label: "gap, mm",
            log: false,
            quantities: contacts(layout, &shown, |contact| contact.gap_m * 1e3),
        });
    }
    panels.push(energies());
    panels
}

fn angles(layout: &Layout) -> Vec<Quantity> {
    let of: [OfFinger; 3] =
        [("q11", |finger| finger.q11_rad), ("q21", |finger| finger.q21_rad), ("q22", |finger| finger.q22_rad)];
    let finger = |(index, name): (usize, &String)| {
        of.iter()
            .zip(OF_FINGERS[index % OF_FINGERS.len()])
            .map(move |((angle, value), colour)| {
                let value = *value;
                quantity(&format!("{name} {angle}"), colour, move |s| turned(value(&s.fingers[index])).to_degrees())
            })
            .collect::<Vec<_>>()
    };
    layout.fingers.iter().enumerate().flat_map(finger).collect()
}

fn object() -> Vec<Quantity> {
    vec![
        quantity("x", BLUE, |s| s.bodies[0].centre_m[0] * 1e3),
        quantity("y", ORANGE, |s| s.bodies[0].centre_m[1] * 1e3),
    ]
}

fn contacts(layout: &Layout, shown: &[usize], value: fn(&ContactSample) -> f64) -> Vec<Quantity> {
    let of = |(place, &index): (usize, &usize)| {
        let name = layout.contacts[index].name.replace('_', " ");
        quantity(&name, SERIES[place % SERIES.len()], move |s| value(&s.contacts[index]))
    };
    shown.iter().enumerate().map(of).collect()
}
