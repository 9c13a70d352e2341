//! Two runs of discs over time: gaps, forces and energies.

use plotters::style::RGBColor;

use super::canvas::{AMBER, BLUE, DrawError, GREEN, GREY, ORANGE, PURPLE};
use super::overlay::{MODELS, Panel, Quantity, Runs, draw_all};
use crate::scene::BodiesScene;
use crate::trace::{ContactSample, Layout, Place, Sample, Simulated};
use crate::validate::{Recording, Validation};

const COLOURS: [RGBColor; 6] = [BLUE, ORANGE, GREEN, PURPLE, AMBER, GREY];

/// The picture of a validation; pairs that never touch are left out of it where others do.
pub fn bodies_overlay(scene: &BodiesScene, found: &Validation<BodiesScene>) -> Result<String, DrawError> {
    let layout = Simulated::from(scene).layout();
    let title = format!("{}: analytic model and engine", scene.name);
    let end_s = found.reference.outcome.last.time_s;
    bodies_overlay_of(title, MODELS, &layout, [&found.reference, &found.engine], end_s)
}

/// The picture of any two runs of this layout.
pub fn bodies_overlay_of(
    title: String,
    labels: [&str; 2],
    layout: &Layout,
    [first, second]: [&Recording; 2],
    end_s: f64,
) -> Result<String, DrawError> {
    let panels = panels(&layout.contacts, [first, second]);
    let (first, second) = (&first.samples, &second.samples);
    draw_all(&panels, &Runs { title, labels, first, second, time_s: |sample: &Sample| sample.time_s, end_s })
}

fn panels(places: &[Place], runs: [&Recording; 2]) -> Vec<Panel<'static, Sample>> {
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
    let of_pairs = |label, value: fn(&ContactSample) -> f64| {
        let quantity = |(place, &pair): (usize, &usize)| Quantity {
            name: places[pair].name.clone(),
            colour: COLOURS[place % COLOURS.len()],
            value: Box::new(move |sample: &Sample| value(&sample.contacts[pair])),
        };
        Panel { label, log: false, quantities: shown.iter().enumerate().map(quantity).collect() }
    };
    if !shown.is_empty() {
        panels.push(of_pairs("gap, mm", |contact| contact.gap_m * 1e3));
        panels.push(of_pairs("normal force, N", |contact| contact.normal_n));
        if runs.into_iter().any(rubs) {
            panels.push(of_pairs("friction force, N", |contact| contact.tangential_n));
        }
    }
    let quantity = |name: &str, colour, value: fn(&Sample) -> f64| Quantity {
        name: name.to_string(),
        colour,
        value: Box::new(value),
    };
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
