//! Two runs over time in stacked panels: the first run as wide faint curves, the second as thin curves on top.

use super::axis::Axis;
use super::canvas::{Marker, THIN_LINE, TITLE_HEIGHT, picture};
use super::series::{Panel, Series, Stack};
use super::theme::{INK, SERIES};
use crate::scene::Scene;
use crate::trace::{ContactSample, FingerState, Layout, Sample};
use crate::validate::{Recording, Validation, wrap_angle};

const PANEL_HEIGHT: f64 = 230.0;
const FIRST: Marker = Marker::FaintLine { width: 6.0 };
const SECOND: Marker = THIN_LINE;

/// Name of a curve, and its value in a sample.
type Quantity = (String, Box<dyn Fn(&Sample) -> f64>);

/// Name and value of a quantity of a finger.
type FingerQuantity = (&'static str, fn(&FingerState) -> f64);

/// Quantities of one panel; their curves have successive colours.
struct PanelQuantities {
    label: &'static str,
    is_logarithmic: bool,
    quantities: Vec<Quantity>,
}

/// Draws the two models of a validation.
pub fn overlay(scene: &Scene, found: &Validation) -> String {
    let title = format!("{}: analytic model and engine", scene.name);
    let end_s = found.reference.outcome.last.time_s;
    let labels = ["analytic (reference)", "engine"];
    overlay_runs(title, labels, &Layout::from_system(&scene.system), [&found.reference, &found.engine], end_s)
}

/// Draws two runs of this layout. Surfaces without contact are omitted if others have contact.
pub fn overlay_runs(title: String, labels: [&str; 2], layout: &Layout, runs: [&Recording; 2], end_s: f64) -> String {
    let x = Axis::linear("time, ms", [0.0, end_s * 1e3]);
    let mut panels: Vec<Panel> = panels(layout, runs).iter().map(|quantities| panel(quantities, runs)).collect();
    if let Some(first) = panels.first_mut() {
        first.series.splice(..0, [Series::key(FIRST, INK, labels[0]), Series::key(SECOND, INK, labels[1])]);
    }
    let stack = Stack { top: 0.0, heading: 0.0, panel: PANEL_HEIGHT, has_legends: true };
    picture(&title, TITLE_HEIGHT + stack.height(panels.len()), |svg| stack.draw(svg, &x, &panels))
}

fn panel(PanelQuantities { label, is_logarithmic, quantities }: &PanelQuantities, runs: [&Recording; 2]) -> Panel {
    let both = || runs.into_iter().flat_map(|run| &run.samples);
    let values = quantities.iter().flat_map(|(_, value)| both().map(value));
    let y = if *is_logarithmic { Axis::logarithmic(label, values, 7.0) } else { Axis::linear(label, values) };
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
fn panels(layout: &Layout, runs: [&Recording; 2]) -> Vec<PanelQuantities> {
    let discs = layout.fingers.is_empty();
    let mut panels = Vec::new();
    if !discs {
        panels.push(joints(
            layout,
            "joint angle, deg",
            [
                ("q11", |finger| wrap_angle(finger.q11_rad).to_degrees()),
                ("q21", |finger| wrap_angle(finger.q21_rad).to_degrees()),
                ("q22", |finger| wrap_angle(finger.q22_rad).to_degrees()),
            ],
        ));
    }
    if layout.fingers.len() == 1 {
        panels.push(joints(
            layout,
            "joint rate, rad/s",
            [
                ("qd11", |finger| finger.qd11_rad_s),
                ("qd21", |finger| finger.qd21_rad_s),
                ("qd22", |finger| finger.qd22_rad_s),
            ],
        ));
    } else if !discs {
        let object: [fn(&Sample) -> f64; 2] = [|s| s.bodies[0].centre_m[0] * 1e3, |s| s.bodies[0].centre_m[1] * 1e3];
        panels.push(sample_panel("object, mm", ["x", "y"], object));
    }
    let shown_contacts = shown_contacts(layout, runs);
    let contacts = |label, is_logarithmic, value: fn(&ContactSample) -> f64| {
        let quantity = |&index: &usize| -> Quantity {
            let name = &layout.contacts[index].name;
            let name = if discs { name.clone() } else { name.replace('_', " ") };
            (name, Box::new(move |sample| value(&sample.contacts[index])))
        };
        PanelQuantities { label, is_logarithmic, quantities: shown_contacts.iter().map(quantity).collect() }
    };
    if !shown_contacts.is_empty() {
        panels.push(contacts("normal force, N", !discs, |contact| contact.normal_n));
        panels.push(contacts("gap, mm", false, |contact| contact.gap_m * 1e3));
        let has_friction = |sample: &Sample| sample.contacts.iter().any(|contact| contact.tangential_n != 0.0);
        if discs && runs.iter().any(|run| run.samples.iter().any(has_friction)) {
            panels.push(contacts("friction force, N", false, |contact| contact.tangential_n));
        }
    }
    let names = ["kinetic", if discs { "drive work" } else { "motor work" }, "dissipated", "balance"];
    let energies: [fn(&Sample) -> f64; 4] = [
        |s| s.energy.kinetic_j * 1e3,
        |s| s.energy.motor_work_j * 1e3,
        |s| s.energy.dissipated_j * 1e3,
        |s| s.energy.balance_j * 1e3,
    ];
    let mut energies = sample_panel("energy, mJ", names, energies);
    if discs {
        energies.quantities.push(("contact".to_string(), Box::new(|sample| sample.energy.elastic_j * 1e3)));
    }
    panels.push(energies);
    panels
}

/// Surfaces that have contact in a run, or all surfaces if none has; always all surfaces for a single finger with an
/// object.
fn shown_contacts(layout: &Layout, runs: [&Recording; 2]) -> Vec<usize> {
    let any = |of: &dyn Fn(&Recording) -> Option<bool>| runs.into_iter().any(|run| of(run) == Some(true));
    let exists = |index: &usize| any(&|run| Some(run.outcome.last.contacts.get(*index)?.gap_m.is_finite()));
    let has_contact = |index: &usize| any(&|run| Some(run.outcome.contacts.get(*index)?.first_s.is_some()));
    let all: Vec<usize> = layout.surfaces().filter(exists).collect();
    let in_contact: Vec<usize> = all.iter().copied().filter(has_contact).collect();
    if in_contact.is_empty() || layout.fingers.len() == 1 { all } else { in_contact }
}

fn sample_panel<const N: usize>(
    label: &'static str,
    names: [&str; N],
    values: [fn(&Sample) -> f64; N],
) -> PanelQuantities {
    let quantity = |(name, value): (&str, fn(&Sample) -> f64)| -> Quantity { (name.to_string(), Box::new(value)) };
    PanelQuantities { label, is_logarithmic: false, quantities: names.into_iter().zip(values).map(quantity).collect() }
}

/// Panel of the joints of every finger.
fn joints(layout: &Layout, label: &'static str, values: [FingerQuantity; 3]) -> PanelQuantities {
    let fingers = layout.fingers.iter().enumerate();
    let quantity = |(index, finger): (usize, &String)| {
        values.map(|(joint, value)| -> Quantity {
            let name = [finger, joint].join(" ").trim_start().to_string();
            (name, Box::new(move |sample| value(&sample.fingers[index])))
        })
    };
    PanelQuantities { label, is_logarithmic: false, quantities: fingers.flat_map(quantity).collect() }
}
