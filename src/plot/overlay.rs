//! Two runs over time, one panel above the other: the curve of the first wide and pale, that of the second thin upon it.

use super::axis::Axis;
use super::canvas::{
    Area, BLACK, BLUE, DrawError, Entry, GREEN, LEGEND, Mark, ORANGE, PURPLE, WIDTH, frame, legend, line, picture,
    titled,
};
use super::curve::over_time;
use crate::trace::{Sample, Site};
use crate::validate::{Recording, Validation, turned};
use plotters::style::RGBColor;

const PANEL: u32 = 230;
const FOOT: u32 = 40;
const FIRST: Mark = Mark::Pale { width: 6 };
const SECOND: Mark = Mark::Line { width: 1 };

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

/// Two runs: what they are called, their samples, and where a sample has its time.
pub(super) struct Runs<'a, S> {
    pub title: String,
    pub labels: [&'a str; 2],
    pub first: &'a [S],
    pub second: &'a [S],
    pub time_s: fn(&S) -> f64,
    pub end_s: f64,
}

/// What the two models of a validation are called.
pub(super) const MODELS: [&str; 2] = ["analytic (reference)", "engine"];

/// The picture of a validation, of the runs with the scene's own torque.
pub fn overlay(scene: &str, found: &Validation) -> Result<String, DrawError> {
    let title = format!("{scene}: analytic model and engine");
    let end_s = found.reference.outcome.last.time_s;
    overlay_of(title, MODELS, [&found.reference, &found.engine], end_s)
}

/// The picture of any two runs of fingers.
pub fn overlay_of(
    title: String,
    labels: [&str; 2],
    [first, second]: [&Recording; 2],
    end_s: f64,
) -> Result<String, DrawError> {
    let touches = |run: &Recording| run.outcome.last.contact(Site::Proximal).gap_m.is_finite();
    let panels = panels(touches(first) || touches(second));
    let (first, second) = (&first.samples, &second.samples);
    draw_all(&panels, &Runs { title, labels, first, second, time_s: |sample: &Sample| sample.time_s, end_s })
}

/// All panels of a picture.
pub(super) fn draw_all<S>(panels: &[Panel<'_, S>], runs: &Runs<'_, S>) -> Result<String, DrawError> {
    let x = Axis::linear("time, ms", [0.0, runs.end_s * 1e3]);
    picture(PANEL * panels.len() as u32 + FOOT + 40, |area| {
        let mut rest = titled(area, &runs.title)?;
        let last = panels.len() - 1;
        for (index, panel) in panels.iter().enumerate() {
            let (own, below) = rest.split_vertically(if index == last { PANEL + FOOT } else { PANEL });
            let mut entries = Vec::new();
            if index == 0 {
                entries.push(Entry::new(FIRST, BLACK, runs.labels[0]));
                entries.push(Entry::new(SECOND, BLACK, runs.labels[1]));
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
    let both = || runs.first.iter().chain(runs.second);
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
        line(&mut chart, points(runs.first, value), FIRST, *colour)?;
        entries.push(Entry::new(Mark::Line { width: 2 }, *colour, name));
    }
    for Quantity { colour, value, .. } in &panel.quantities {
        line(&mut chart, points(runs.second, value), SECOND, dark(*colour))?;
    }
    legend(&right, &entries)
}

/// Dark enough to be seen on its own pale self.
fn dark(colour: RGBColor) -> RGBColor {
    let part = |value: u8| (f64::from(value) * 0.6) as u8;
    RGBColor(part(colour.0), part(colour.1), part(colour.2))
}

/// Joints and energies always; contacts where the scene has an object.
fn panels(object: bool) -> Vec<Panel<'static, Sample>> {
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
