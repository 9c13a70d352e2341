//! Both models over time, one panel above the other: the analytic curve wide and pale, the engine's thin upon it.

use super::axis::Axis;
use super::canvas::{
    Area, BLACK, BLUE, DrawError, Entry, GREEN, LEGEND, Mark, ORANGE, PURPLE, WIDTH, frame, legend, line, picture,
    titled,
};
use super::curve::over_time;
use crate::trace::Sample;
use crate::validate::{Validation, turned};
use plotters::style::RGBColor;

const PANEL: u32 = 230;
const FOOT: u32 = 40;
const ANALYTIC: Mark = Mark::Pale { width: 6 };
const ENGINE: Mark = Mark::Line { width: 1 };

/// One quantity of a panel.
pub(super) struct Quantity<'a, S> {
    pub name: String,
    pub colour: RGBColor,
    pub value: Box<dyn Fn(&S) -> f64 + 'a>,
}

/// One panel.
pub(super) struct Panel<'a, S> {
    pub label: &'static str,
    pub log: bool,
    pub quantities: Vec<Quantity<'a, S>>,
}

/// The samples of both models, and where a sample has its time.
pub(super) struct Runs<'a, S> {
    pub analytic: &'a [S],
    pub engine: &'a [S],
    pub time_s: fn(&S) -> f64,
    pub end_s: f64,
}

/// The picture, of the runs with the scene's own torque.
pub fn overlay(scene: &str, found: &Validation) -> Result<String, DrawError> {
    let runs = Runs {
        analytic: &found.reference.samples,
        engine: &found.engine.samples,
        time_s: |sample: &Sample| sample.time_s,
        end_s: found.reference.outcome.last.time_s,
    };
    draw_all(scene, &panels(found), &runs)
}

/// All panels of a picture.
pub(super) fn draw_all<S>(scene: &str, panels: &[Panel<'_, S>], runs: &Runs<'_, S>) -> Result<String, DrawError> {
    let x = Axis::linear("time, ms", [0.0, runs.end_s * 1e3]);
    picture(PANEL * panels.len() as u32 + FOOT + 40, |area| {
        let mut rest = titled(area, &format!("{scene}: analytic model and engine"))?;
        let last = panels.len() - 1;
        for (index, panel) in panels.iter().enumerate() {
            let (own, below) = rest.split_vertically(if index == last { PANEL + FOOT } else { PANEL });
            let mut entries = Vec::new();
            if index == 0 {
                entries.push(Entry::new(ANALYTIC, BLACK, "analytic (reference)"));
                entries.push(Entry::new(ENGINE, BLACK, "engine"));
            }
            draw(&own, panel, runs, &x, index == last, entries)?;
            rest = below;
        }
        Ok(())
    })
}

fn draw<S>(
    area: &Area,
    panel: &Panel<'_, S>,
    runs: &Runs<'_, S>,
    x: &Axis,
    foot: bool,
    mut entries: Vec<Entry>,
) -> Result<(), DrawError> {
    let both = || runs.analytic.iter().chain(runs.engine);
    let values = panel.quantities.iter().flat_map(|quantity| both().map(&quantity.value));
    let y = match panel.log {
        true => Axis::decades(panel.label, values, 7.0),
        false => Axis::linear(panel.label, values),
    };
    let (left, right) = area.split_horizontally(WIDTH - LEGEND);
    let mut chart = frame(&left, x, &y, foot)?;
    let points = |samples: &[S], value: &dyn Fn(&S) -> f64| {
        over_time(samples.iter().map(|sample| ((runs.time_s)(sample), value(sample))), &y)
    };
    for Quantity { name, colour, value } in &panel.quantities {
        line(&mut chart, points(runs.analytic, value), ANALYTIC, *colour)?;
        entries.push(Entry::new(Mark::Line { width: 2 }, *colour, name));
    }
    for Quantity { colour, value, .. } in &panel.quantities {
        line(&mut chart, points(runs.engine, value), ENGINE, dark(*colour))?;
    }
    legend(&right, &entries)
}

/// Dark enough to be seen on its own pale self.
fn dark(colour: RGBColor) -> RGBColor {
    let part = |value: u8| (f64::from(value) * 0.6) as u8;
    RGBColor(part(colour.0), part(colour.1), part(colour.2))
}

/// Joints and energies always; contacts where the scene has an object.
fn panels(found: &Validation) -> Vec<Panel<'static, Sample>> {
    let quantity = |name: &str, colour, value: fn(&Sample) -> f64| Quantity {
        name: name.to_string(),
        colour,
        value: Box::new(value),
    };
    let mut panels = vec![
        Panel {
            label: "joint angle, deg",
            log: false,
            quantities: vec![
                quantity("q11", BLUE, |s| turned(s.q11_rad).to_degrees()),
                quantity("q21", ORANGE, |s| turned(s.q21_rad).to_degrees()),
                quantity("q22", GREEN, |s| turned(s.q22_rad).to_degrees()),
            ],
        },
        Panel {
            label: "joint rate, rad/s",
            log: false,
            quantities: vec![
                quantity("qd11", BLUE, |s| s.qd11_rad_s),
                quantity("qd21", ORANGE, |s| s.qd21_rad_s),
                quantity("qd22", GREEN, |s| s.qd22_rad_s),
            ],
        },
    ];
    if found.reference.outcome.last.proximal.gap_m.is_finite() {
        panels.push(Panel {
            label: "normal force, N",
            log: true,
            quantities: vec![
                quantity("proximal", BLUE, |s| s.proximal.normal_n),
                quantity("distal", ORANGE, |s| s.distal.normal_n),
            ],
        });
        panels.push(Panel {
            label: "gap, mm",
            log: false,
            quantities: vec![
                quantity("proximal", BLUE, |s| s.proximal.gap_m * 1e3),
                quantity("distal", ORANGE, |s| s.distal.gap_m * 1e3),
            ],
        });
    }
    panels.push(Panel {
        label: "energy, mJ",
        log: false,
        quantities: vec![
            quantity("kinetic", BLUE, |s| s.energy.kinetic_j * 1e3),
            quantity("motor work", ORANGE, |s| s.energy.motor_work_j * 1e3),
            quantity("dissipated", GREEN, |s| s.energy.dissipated_j * 1e3),
            quantity("balance", PURPLE, |s| s.energy.balance_j * 1e3),
        ],
    });
    panels
}
