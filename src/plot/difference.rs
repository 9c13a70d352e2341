//! The difference of two runs over time, with the touch-downs.

use super::axis::Axis;
use super::canvas::{Entry, Mark, THIN, chart, level, line, upright};
use super::curve::thin;
use super::theme::{INK, SERIES, SOFT};
use crate::scene::Scene;
use crate::trace::{EventKind, Layout};
use crate::validate::{Angle, Recording, Validation, off};

const HEIGHT: f64 = 560.0;
/// Decades shown: what is smaller than the largest by more lies on the foot of the picture.
const DECADES: f64 = 8.0;
/// More touch-downs than this would hide the curves.
const MOST_TOUCHES: usize = 60;

/// A curve of differences: its name, and (time in s, difference).
pub struct Apart {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// Touch-downs at one place.
pub struct Touches {
    pub name: String,
    pub times_s: Vec<f64>,
}

/// What is on a picture of differences.
pub struct Differences<'a> {
    pub title: String,
    /// What is drawn, with its unit.
    pub label: &'a str,
    pub curves: Vec<Apart>,
    pub touches: Vec<Touches>,
    pub bound: Option<f64>,
    pub until_s: f64,
}

/// The picture of a validation of a scene with fingers, of the run with its own torque.
pub fn difference(scene: &Scene, found: &Validation) -> String {
    let (layout, until_s, name) = (Layout::of(&scene.system), found.until_s, &scene.name);
    let (what, label) = match layout.bodies.is_empty() {
        true => ("the joint angles", "|engine − analytic|, rad"),
        false => ("the joint angles and the object", "|engine − analytic|, rad or m"),
    };
    difference_of(&Differences {
        title: format!("{name}: difference of {what} over time"),
        label,
        curves: paths_apart(&layout, &found.engine, &found.reference, until_s),
        touches: touches(&layout, &found.reference, until_s),
        bound: Some(found.path_bound),
        until_s,
    })
}

/// How far the angles of fingers and the centres of bodies of a run are from those of another.
pub fn paths_apart(layout: &Layout, run: &Recording, reference: &Recording, until_s: f64) -> Vec<Apart> {
    let angles = layout
        .fingers
        .iter()
        .flat_map(|finger| Angle::ALL.map(|angle| [finger.as_str(), angle.name()].join(" ").trim_start().to_string()));
    let names = angles.chain(layout.bodies.iter().cloned());
    let mut curves: Vec<Apart> = names.map(|name| Apart { name, points: Vec::new() }).collect();
    let mut cursor = 0;
    for sample in run.samples.iter().filter(|sample| sample.time_s <= until_s) {
        let Some(expected) = reference.at(sample.time_s, &mut cursor) else { continue };
        for (curve, off) in curves.iter_mut().zip(off(sample, &expected)) {
            curve.points.push((sample.time_s, off.abs()));
        }
    }
    curves
}

/// Touch-downs of all contacts between surfaces.
pub fn touches(layout: &Layout, run: &Recording, until_s: f64) -> Vec<Touches> {
    let at = |contact: usize| Touches {
        name: layout.contacts[contact].name.clone(),
        times_s: run
            .events
            .iter()
            .filter(|event| event.contact == contact && event.kind == EventKind::TouchDown && event.time_s <= until_s)
            .map(|event| event.time_s)
            .collect(),
    };
    layout.surfaces().map(at).collect()
}

/// The picture: differences on a logarithmic axis over time.
pub fn difference_of(found: &Differences<'_>) -> String {
    let all = found.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1));
    let y = Axis::decades(found.label, all.chain(found.bound), DECADES);
    let x = Axis::linear("time, ms", [0.0, found.until_s * 1e3]);
    chart(&found.title, HEIGHT, &x, &y, |svg, on| {
        let mut entries = Vec::new();
        for (place, colour) in found.touches.iter().zip([SOFT, INK].into_iter().cycle()) {
            for t in place.times_s.iter().take(MOST_TOUCHES).map(|time_s| time_s * 1e3) {
                upright(svg, on, t, colour);
            }
            if !place.times_s.is_empty() {
                entries.push(Entry::new(THIN, colour, &format!("touch-down {}", place.name)));
            }
        }
        if let Some(bound) = found.bound {
            let mark = Mark::Pale { width: 4.0 };
            level(svg, on, y.place(bound), mark, INK);
            entries.push(Entry::new(mark, INK, "bound of the scene"));
        }
        for (curve, colour) in found.curves.iter().zip(SERIES.into_iter().cycle()) {
            let points = curve.points.iter().map(|&(time_s, value)| (time_s * 1e3, y.place(value)));
            let mark = Mark::Line { width: 2.0 };
            line(svg, on, thin(points.collect()), mark, colour);
            entries.push(Entry::new(mark, colour, &curve.name));
        }
        entries
    })
}
