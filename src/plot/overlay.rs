//! Two runs over time in stacked panels: the first run as wide faint curves, the second as thin curves on top.

use super::axis::Axis;
use super::canvas::{Marker, THIN_LINE, TITLE_HEIGHT, picture};
use super::series::{Panel, Series, Stack};
use super::theme::{INK, SERIES};
use crate::scene::Scene;
use crate::trace::{ContactSample, FingerState, Sample, Schema};
use crate::validate::{Recording, Validation, wrap_angle};

const PANEL_HEIGHT: f64 = 230.0;
const FIRST: Marker = Marker::FaintLine { width: 6.0 };
const SECOND: Marker = THIN_LINE;

/// Name of a curve, and its value in a sample.
type Quantity = (String, Box<dyn Fn(&Sample) -> f64>);

/// Name and value of a quantity of a finger.
type FingerQuantity = (&'static str, fn(&FingerState) -> f64);

/// Draws the two models of a validation.
pub fn overlay(scene: &Scene, found: &Validation) -> String {
    let title = format!("{}: analytic model and engine", scene.name);
    let end_s = found.reference.outcome.last.time_s;
    let labels = ["analytic (reference)", "engine"];
    overlay_runs(title, labels, &Schema::from_system(&scene.system), [&found.reference, &found.engine], end_s)
}

/// Draws two runs of this layout. Surfaces without contact are omitted if others have contact.
pub(crate) fn overlay_runs(
    title: String,
    labels: [&str; 2],
    layout: &Schema,
    runs: [&Recording; 2],
    end_s: f64,
) -> String {
    let x = Axis::linear("time, ms", [0.0, end_s * 1e3]);
    let mut panels = panels(layout, runs);
    if let Some(first) = panels.first_mut() {
        first.series.splice(..0, [Series::key(FIRST, INK, labels[0]), Series::key(SECOND, INK, labels[1])]);
    }
    let stack = Stack { top: 0.0, heading: 0.0, panel: PANEL_HEIGHT, has_legends: true };
    picture(&title, TITLE_HEIGHT + stack.height(panels.len()), |svg| stack.draw(svg, &x, &panels))
}

/// Curves of quantities in both runs, with successive colours.
fn panel(label: &str, is_logarithmic: bool, runs: [&Recording; 2], quantities: &[Quantity]) -> Panel {
    let both = || runs.into_iter().flat_map(|run| &run.samples);
    let values = quantities.iter().flat_map(|(_, value)| both().map(value));
    let y = if is_logarithmic { Axis::logarithmic(label, values, 7.0) } else { Axis::linear(label, values) };
    let coloured = || quantities.iter().zip(SERIES.into_iter().cycle());
    let curves = runs.into_iter().zip([FIRST, SECOND]).flat_map(|(run, marker)| {
        coloured().map(move |((_, value), colour)| {
            Series::over_time(marker, colour, run.samples.iter().map(|sample| (sample.time_s, value(sample))))
        })
    });
    let keys = coloured().map(|((name, _), colour)| Series::key(Marker::Line { width: 2.0 }, colour, name));
    Panel { heading: None, series: curves.chain(keys).collect(), y }
}

/// Panels of joints, object, forces, gaps and energies; those that do not apply to the scene are omitted.
fn panels(layout: &Schema, runs: [&Recording; 2]) -> Vec<Panel> {
    let discs = layout.fingers.is_empty();
    let mut panels = Vec::new();
    let mut add = |label: &str, is_logarithmic, quantities: Vec<Quantity>| {
        panels.push(panel(label, is_logarithmic, runs, &quantities));
    };
    if !discs {
        let angles: [FingerQuantity; 3] = [
            ("q11", |finger| wrap_angle(finger.q11_rad).to_degrees()),
            ("q21", |finger| wrap_angle(finger.q21_rad).to_degrees()),
            ("q22", |finger| wrap_angle(finger.q22_rad).to_degrees()),
        ];
        add("joint angle, deg", false, joints(layout, angles));
    }
    if layout.fingers.len() == 1 {
        let rates: [FingerQuantity; 3] = [
            ("qd11", |finger| finger.qd11_rad_s),
            ("qd21", |finger| finger.qd21_rad_s),
            ("qd22", |finger| finger.qd22_rad_s),
        ];
        add("joint rate, rad/s", false, joints(layout, rates));
    } else if !discs {
        let centre = |axis: usize| move |sample: &Sample| sample.body(0).centre_m[axis] * 1e3;
        add("object, mm", false, vec![quantity("x", centre(0)), quantity("y", centre(1))]);
    }
    let shown_contacts = shown_contacts(layout, runs);
    let contacts = |value: fn(&ContactSample) -> f64| -> Vec<Quantity> {
        let contact = |&index: &usize| {
            let name = &layout.contacts[index].name;
            let name = if discs { name.clone() } else { name.replace('_', " ") };
            quantity(name, move |sample| value(&sample.contact(index)))
        };
        shown_contacts.iter().map(contact).collect()
    };
    if !shown_contacts.is_empty() {
        add("normal force, N", !discs, contacts(|contact| contact.normal_n));
        add("gap, mm", false, contacts(|contact| contact.gap_m * 1e3));
        let has_friction = |sample: &Sample| sample.contacts().any(|contact| contact.tangential_n != 0.0);
        if discs && runs.iter().any(|run| run.samples.iter().any(has_friction)) {
            add("friction force, N", false, contacts(|contact| contact.tangential_n));
        }
    }
    let mut energies = vec![
        quantity("kinetic", |sample| sample.energy().kinetic_j * 1e3),
        quantity(if discs { "drive work" } else { "motor work" }, |sample| sample.energy().motor_work_j * 1e3),
        quantity("dissipated", |sample| sample.energy().dissipated_j * 1e3),
        quantity("balance", |sample| sample.energy().balance_j * 1e3),
    ];
    energies.extend(discs.then(|| quantity("contact", |sample| sample.energy().elastic_j * 1e3)));
    add("energy, mJ", false, energies);
    panels
}

fn quantity(name: impl Into<String>, value: impl Fn(&Sample) -> f64 + 'static) -> Quantity {
    (name.into(), Box::new(value))
}

/// Surfaces that have contact in a run, or all surfaces if none has; always all surfaces for a single finger with an
/// object.
fn shown_contacts(layout: &Schema, runs: [&Recording; 2]) -> Vec<usize> {
    let any = |of: &dyn Fn(&Recording) -> Option<bool>| runs.into_iter().any(|run| of(run) == Some(true));
    let exists = |index: &usize| any(&|run| Some(run.outcome.last.contacts().nth(*index)?.gap_m.is_finite()));
    let has_contact = |index: &usize| any(&|run| Some(run.outcome.contacts.get(*index)?.first_s.is_some()));
    let all: Vec<usize> = layout.surfaces().filter(exists).collect();
    let in_contact: Vec<usize> = all.iter().copied().filter(has_contact).collect();
    if in_contact.is_empty() || layout.fingers.len() == 1 { all } else { in_contact }
}

/// Quantities of the joints of every finger.
fn joints(layout: &Schema, values: [FingerQuantity; 3]) -> Vec<Quantity> {
    let of_finger = |(index, finger): (usize, &String)| {
        values.map(|(joint, value)| {
            let name = [finger, joint].join(" ");
            quantity(name.trim_start(), move |sample| value(&sample.finger(index)))
        })
    };
    layout.fingers.iter().enumerate().flat_map(of_finger).collect()
}
