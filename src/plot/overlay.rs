//! Two runs over time, one panel above the other: the curve of the first wide and pale, that of the second thin upon it.

use super::axis::Axis;
use super::canvas::{Area, Entry, HEAD, LEGEND, Mark, THIN, WIDTH, frame, legend, line, picture};
use super::curve::over_time;
use super::overlay_gripper::of_gripper;
use super::overlay_panel::{Panel, Quantity, energies, quantity};
use super::svg::Svg;
use super::theme::{AMBER, BLUE, GREEN, INK, ORANGE, PURPLE, SERIES};
use crate::scene::Scene;
use crate::trace::{ContactSample, Layout, Place, Sample, Site};
use crate::validate::{Recording, Validation, turned};

const PANEL: f64 = 230.0;
const FOOT: f64 = 40.0;
const FIRST: Mark = Mark::Pale { width: 6.0 };
const SECOND: Mark = THIN;

/// Two runs: what they are called, and their samples.
struct Runs<'a> {
    title: String,
    labels: [&'a str; 2],
    first: &'a [Sample],
    second: &'a [Sample],
    end_s: f64,
}

/// The picture of a validation, of the scene itself.
pub fn overlay(scene: &Scene, found: &Validation) -> String {
    let title = format!("{}: analytic model and engine", scene.name);
    let end_s = found.reference.outcome.last.time_s;
    let labels = ["analytic (reference)", "engine"];
    overlay_of(title, labels, &Layout::of(&scene.system), [&found.reference, &found.engine], end_s)
}

/// The picture of any two runs of this layout; pairs of bodies that never touch are left out of it where others do.
pub fn overlay_of(
    title: String,
    labels: [&str; 2],
    layout: &Layout,
    [first, second]: [&Recording; 2],
    end_s: f64,
) -> String {
    let panels = match layout.fingers.len() {
        0 => of_pairs(&layout.contacts, [first, second]),
        2.. => of_gripper(layout, [first, second]),
        1 => {
            let object =
                |run: &Recording| run.outcome.last.contacts.first().is_some_and(|proximal| proximal.gap_m.is_finite());
            of_finger(object(first) || object(second))
        }
    };
    draw_all(&panels, &Runs { title, labels, first: &first.samples, second: &second.samples, end_s })
}

/// All panels of a picture.
fn draw_all(panels: &[Panel], runs: &Runs<'_>) -> String {
    let x = Axis::linear("time, ms", [0.0, runs.end_s * 1e3]);
    picture(&runs.title, HEAD + PANEL * panels.len() as f64 + FOOT, |svg| {
        for (index, panel) in panels.iter().enumerate() {
            let mut entries = Vec::new();
            if index == 0 {
                entries.push(Entry::new(FIRST, INK, runs.labels[0]));
                entries.push(Entry::new(SECOND, INK, runs.labels[1]));
            }
            let foot = index + 1 == panels.len();
            svg.moved([0.0, PANEL * index as f64], |svg| draw(svg, panel, runs, &x, foot, entries));
        }
    })
}

fn draw(svg: &mut Svg, panel: &Panel, runs: &Runs<'_>, x: &Axis, foot: bool, mut entries: Vec<Entry>) {
    let both = || runs.first.iter().chain(runs.second);
    let values = panel.quantities.iter().flat_map(|quantity| both().map(&quantity.value));
    let y = match panel.log {
        true => Axis::decades(panel.label, values, 7.0),
        false => Axis::linear(panel.label, values),
    };
    let height = if foot { PANEL + FOOT } else { PANEL };
    let on = frame(svg, Area { left: 0.0, top: 0.0, width: WIDTH - LEGEND, height }, x, &y, foot);
    for (samples, mark) in [(runs.first, FIRST), (runs.second, SECOND)] {
        for Quantity { colour, value, .. } in &panel.quantities {
            let points = samples.iter().map(|sample| (sample.time_s, value(sample)));
            line(svg, &on, over_time(points, &y), mark, *colour);
        }
    }
    entries.extend(panel.quantities.iter().map(|of| Entry::new(Mark::Line { width: 2.0 }, of.colour, &of.name)));
    legend(svg, [WIDTH - LEGEND, 0.0], LEGEND, &entries);
}

/// Joints and energies always; contacts where the scene has an object.
fn of_finger(object: bool) -> Vec<Panel> {
    let mut panels = vec![
        Panel {
            label: "joint angle, deg",
            log: false,
            quantities: vec![
                quantity("q11", BLUE, |s| turned(s.finger().q11_rad).to_degrees()),
                quantity("q21", ORANGE, |s| turned(s.finger().q21_rad).to_degrees()),
                quantity("q22", GREEN, |s| turned(s.finger().q22_rad).to_degrees()),
            ],
        },
        Panel {
            label: "joint rate, rad/s",
            log: false,
            quantities: vec![
                quantity("qd11", BLUE, |s| s.finger().qd11_rad_s),
                quantity("qd21", ORANGE, |s| s.finger().qd21_rad_s),
                quantity("qd22", GREEN, |s| s.finger().qd22_rad_s),
            ],
        },
    ];
    if object {
        panels.push(Panel {
            label: "normal force, N",
            log: true,
            quantities: vec![
                quantity("proximal", BLUE, |s| s.contact(Site::Proximal).normal_n),
                quantity("distal", ORANGE, |s| s.contact(Site::Distal).normal_n),
            ],
        });
        panels.push(Panel {
            label: "gap, mm",
            log: false,
            quantities: vec![
                quantity("proximal", BLUE, |s| s.contact(Site::Proximal).gap_m * 1e3),
                quantity("distal", ORANGE, |s| s.contact(Site::Distal).gap_m * 1e3),
            ],
        });
    }
    panels.push(energies());
    panels
}

/// Gaps and forces of the pairs that touch, or of all if none does; energies.
fn of_pairs(places: &[Place], runs: [&Recording; 2]) -> Vec<Panel> {
    let mut panels = Vec::new();
    let touching = |&pair: &usize| {
        runs.iter().any(|run| run.outcome.contacts.get(pair).is_some_and(|pair| pair.first_s.is_some()))
    };
    let mut shown: Vec<usize> = (0..places.len()).filter(touching).collect();
    if shown.is_empty() {
        shown = (0..places.len()).collect();
    }
    let rubs = |run: &Recording| {
        run.samples.iter().any(|sample| sample.contacts.iter().any(|contact| contact.tangential_n != 0.0))
    };
    let of_contacts = |label, value: fn(&ContactSample) -> f64| {
        let quantity = |(place, &pair): (usize, &usize)| Quantity {
            name: places[pair].name.clone(),
            colour: SERIES[place % SERIES.len()],
            value: Box::new(move |sample: &Sample| value(&sample.contacts[pair])),
        };
        Panel { label, log: false, quantities: shown.iter().enumerate().map(quantity).collect() }
    };
    if !shown.is_empty() {
        panels.push(of_contacts("gap, mm", |contact| contact.gap_m * 1e3));
        panels.push(of_contacts("normal force, N", |contact| contact.normal_n));
        if runs.into_iter().any(rubs) {
            panels.push(of_contacts("friction force, N", |contact| contact.tangential_n));
        }
    }
    panels.push(Panel {
        label: "energy, mJ",
        log: false,
        quantities: vec![
            quantity("kinetic", BLUE, |s| s.energy.kinetic_j * 1e3),
            quantity("drive work", ORANGE, |s| s.energy.motor_work_j * 1e3),
            quantity("contact", AMBER, |s| s.energy.elastic_j * 1e3),
            quantity("dissipated", GREEN, |s| s.energy.dissipated_j * 1e3),
            quantity("balance", PURPLE, |s| s.energy.balance_j * 1e3),
        ],
    });
    panels
}
