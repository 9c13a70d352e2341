//! Two runs over time, one panel above the other: the curve of the first wide and pale, that of the second thin upon it.

use super::axis::Axis;
use super::canvas::{Area, Entry, HEAD, LEGEND, Mark, THIN, WIDTH, frame, legend, line, picture};
use super::curve::over_time;
use super::svg::Svg;
use super::theme::{INK, SERIES};
use crate::scene::Scene;
use crate::trace::{ContactSample, FingerState, Layout, Sample};
use crate::validate::{Recording, Validation, turned};

const PANEL: f64 = 230.0;
const FOOT: f64 = 40.0;
const FIRST: Mark = Mark::Pale { width: 6.0 };
const SECOND: Mark = THIN;

/// A curve: its name, and its value in a sample.
type Quantity = (String, Box<dyn Fn(&Sample) -> f64>);

/// A quantity of a finger: its name and value.
type OfFinger = (&'static str, fn(&FingerState) -> f64);

/// One panel; its curves have their colours in turn.
struct Panel {
    label: &'static str,
    log: bool,
    quantities: Vec<Quantity>,
}

/// The picture of a validation, of the scene itself.
pub fn overlay(scene: &Scene, found: &Validation) -> String {
    let title = format!("{}: analytic model and engine", scene.name);
    let end_s = found.reference.outcome.last.time_s;
    let labels = ["analytic (reference)", "engine"];
    overlay_of(title, labels, &Layout::of(&scene.system), [&found.reference, &found.engine], end_s)
}

/// The picture of any two runs of this layout; what never touches is left out of it where something else does.
pub fn overlay_of(title: String, labels: [&str; 2], layout: &Layout, runs: [&Recording; 2], end_s: f64) -> String {
    let panels = panels(layout, runs);
    let x = Axis::linear("time, ms", [0.0, end_s * 1e3]);
    picture(&title, HEAD + PANEL * panels.len() as f64 + FOOT, |svg| {
        let mut entries = vec![Entry::new(FIRST, INK, labels[0]), Entry::new(SECOND, INK, labels[1])];
        for (index, panel) in panels.iter().enumerate() {
            let foot = index + 1 == panels.len();
            svg.moved([0.0, PANEL * index as f64], |svg| {
                draw(svg, panel, runs, &x, foot, std::mem::take(&mut entries))
            });
        }
    })
}

fn draw(svg: &mut Svg, panel: &Panel, runs: [&Recording; 2], x: &Axis, foot: bool, mut entries: Vec<Entry>) {
    let both = || runs.into_iter().flat_map(|run| &run.samples);
    let values = panel.quantities.iter().flat_map(|(_, value)| both().map(value));
    let y = match panel.log {
        true => Axis::decades(panel.label, values, 7.0),
        false => Axis::linear(panel.label, values),
    };
    let height = if foot { PANEL + FOOT } else { PANEL };
    let on = frame(svg, Area { left: 0.0, top: 0.0, width: WIDTH - LEGEND, height }, x, &y, foot);
    let coloured = || panel.quantities.iter().zip(SERIES.into_iter().cycle());
    for (run, mark) in runs.into_iter().zip([FIRST, SECOND]) {
        for ((_, value), colour) in coloured() {
            let points = run.samples.iter().map(|sample| (sample.time_s, value(sample)));
            line(svg, &on, over_time(points, &y), mark, colour);
        }
    }
    entries.extend(coloured().map(|((name, _), colour)| Entry::new(Mark::Line { width: 2.0 }, colour, name)));
    legend(svg, [WIDTH - LEGEND, 0.0], LEGEND, &entries);
}

/// Joints of fingers, what they grasp, forces and gaps, energies: as far as there are any.
fn panels(layout: &Layout, runs: [&Recording; 2]) -> Vec<Panel> {
    let discs = layout.fingers.is_empty();
    let mut panels = Vec::new();
    if !discs {
        panels.push(joints(
            layout,
            "joint angle, deg",
            [
                ("q11", |finger| turned(finger.q11_rad).to_degrees()),
                ("q21", |finger| turned(finger.q21_rad).to_degrees()),
                ("q22", |finger| turned(finger.q22_rad).to_degrees()),
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
        panels.push(of_samples("object, mm", ["x", "y"], object));
    }
    let shown = shown(layout, runs);
    let contacts = |label, log, value: fn(&ContactSample) -> f64| {
        let of = |&index: &usize| -> Quantity {
            let name = &layout.contacts[index].name;
            let name = if discs { name.clone() } else { name.replace('_', " ") };
            (name, Box::new(move |sample| value(&sample.contacts[index])))
        };
        Panel { label, log, quantities: shown.iter().map(of).collect() }
    };
    if !shown.is_empty() {
        panels.push(contacts("normal force, N", !discs, |contact| contact.normal_n));
        panels.push(contacts("gap, mm", false, |contact| contact.gap_m * 1e3));
        let rubs = |sample: &Sample| sample.contacts.iter().any(|contact| contact.tangential_n != 0.0);
        if discs && runs.iter().any(|run| run.samples.iter().any(rubs)) {
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
    let mut energies = of_samples("energy, mJ", names, energies);
    if discs {
        energies.quantities.push(("contact".to_string(), Box::new(|sample| sample.energy.elastic_j * 1e3)));
    }
    panels.push(energies);
    panels
}

/// Surfaces that touch, or all that may if none does; of one finger always all, if it has an object.
fn shown(layout: &Layout, runs: [&Recording; 2]) -> Vec<usize> {
    let any = |of: &dyn Fn(&Recording) -> Option<bool>| runs.into_iter().any(|run| of(run) == Some(true));
    let there = |index: &usize| any(&|run| Some(run.outcome.last.contacts.get(*index)?.gap_m.is_finite()));
    let touches = |index: &usize| any(&|run| Some(run.outcome.contacts.get(*index)?.first_s.is_some()));
    let all: Vec<usize> = layout.surfaces().filter(there).collect();
    let touching: Vec<usize> = all.iter().copied().filter(touches).collect();
    if touching.is_empty() || layout.fingers.len() == 1 { all } else { touching }
}

fn of_samples<const N: usize>(label: &'static str, names: [&str; N], of: [fn(&Sample) -> f64; N]) -> Panel {
    let quantity = |(name, value): (&str, fn(&Sample) -> f64)| -> Quantity { (name.to_string(), Box::new(value)) };
    Panel { label, log: false, quantities: names.into_iter().zip(of).map(quantity).collect() }
}

/// The joints of every finger.
fn joints(layout: &Layout, label: &'static str, of: [OfFinger; 3]) -> Panel {
    let fingers = layout.fingers.iter().enumerate();
    let quantity = |(index, finger): (usize, &String)| {
        of.map(|(joint, value)| -> Quantity {
            let name = [finger, joint].join(" ").trim_start().to_string();
            (name, Box::new(move |sample| value(&sample.fingers[index])))
        })
    };
    Panel { label, log: false, quantities: fingers.flat_map(quantity).collect() }
}
