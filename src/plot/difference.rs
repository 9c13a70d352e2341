//! The difference of two runs over time, with touch-downs.

use super::axis::Axis;
use super::canvas::{Marker, PlotPoint};
use super::series::{Series, series_chart};
use super::theme::{INK, SERIES, SOFT};
use crate::scene::Scene;
use crate::trace::{EventKind, Schema};
use crate::validate::{Angle, Recording, Validation, coordinate_errors};

/// Maximum number of decades shown; smaller values are clamped to the lower edge.
const MAX_DECADES: f64 = 8.0;
/// Maximum number of touch-downs drawn per contact; more would hide the curves.
const MAX_TOUCHDOWNS: usize = 60;

/// A curve of differences: its name, and points (time in s, difference).
pub(crate) type DifferenceCurve = (String, Vec<PlotPoint>);

/// Content of a plot of differences.
pub(crate) struct DifferencePlot<'a> {
    pub title: String,
    /// Label of the vertical axis, with its unit.
    pub label: &'a str,
    pub curves: Vec<DifferenceCurve>,
    pub touchdowns: Vec<Series>,
    pub bound: Option<f64>,
    pub until_s: f64,
}

/// Draws the difference between the two models in a validation of a scene with fingers.
pub fn difference(scene: &Scene, found: &Validation) -> String {
    let (layout, until_s, name) = (Schema::from_system(&scene.system), found.until_s, &scene.name);
    let (quantity, label) = match layout.bodies.is_empty() {
        true => ("the joint angles", "|engine − analytic|, rad"),
        false => ("the joint angles and the object", "|engine − analytic|, rad or m"),
    };
    plot_differences(DifferencePlot {
        title: format!("{name}: difference of {quantity} over time"),
        label,
        curves: path_differences(&layout, &found.engine, &found.reference, until_s),
        touchdowns: touchdowns(&layout, &found.reference, until_s),
        bound: Some(found.path_bound),
        until_s,
    })
}

/// Differences of the angles of fingers and of the centres of bodies between a run and a reference.
pub(crate) fn path_differences(
    layout: &Schema,
    run: &Recording,
    reference: &Recording,
    until_s: f64,
) -> Vec<DifferenceCurve> {
    let angles = layout
        .fingers
        .iter()
        .flat_map(|finger| Angle::ALL.map(|angle| [finger.as_str(), angle.name()].join(" ").trim_start().to_string()));
    let names = angles.chain(layout.bodies.iter().cloned());
    let mut curves: Vec<DifferenceCurve> = names.map(|name| (name, Vec::new())).collect();
    let mut cursor = 0;
    for sample in run.samples.iter().filter(|sample| sample.time_s <= until_s) {
        let Some(expected) = reference.interpolate(sample.time_s, &mut cursor) else { continue };
        for ((_, points), error) in curves.iter_mut().zip(coordinate_errors(sample, &expected)) {
            points.push((sample.time_s, error.abs()));
        }
    }
    curves
}

/// Vertical lines at the touch-downs of all contacts between surfaces.
pub fn touchdowns(layout: &Schema, run: &Recording, until_s: f64) -> Vec<Series> {
    let mut lines = Vec::new();
    for (contact, colour) in layout.surfaces().zip([SOFT, INK].into_iter().cycle()) {
        let name = format!("touch-down {}", layout.contacts[contact].name);
        let events = run.events.iter().filter(|event| event.contact == contact && event.kind == EventKind::TouchDown);
        let shown = events.filter(|event| event.time_s <= until_s).take(MAX_TOUCHDOWNS);
        lines.extend(shown.map(|event| Series::vertical(colour, event.time_s * 1e3).named(&name)));
    }
    lines
}

/// Draws differences on a logarithmic axis over time.
pub(crate) fn plot_differences(found: DifferencePlot<'_>) -> String {
    let all = found.curves.iter().flat_map(|(_, points)| points.iter().map(|point| point.1));
    let y = Axis::logarithmic(found.label, all.chain(found.bound), MAX_DECADES);
    let x = Axis::linear("time, ms", [0.0, found.until_s * 1e3]);
    let mut series = found.touchdowns;
    let bound = |bound| Series::horizontal(Marker::FaintLine { width: 4.0 }, INK, bound).named("bound of the scene");
    series.extend(found.bound.map(bound));
    series.extend(found.curves.into_iter().zip(SERIES.into_iter().cycle()).map(|((name, points), colour)| {
        Series::over_time(Marker::Line { width: 2.0 }, colour, points.into_iter()).named(name)
    }));
    series_chart(&found.title, 560.0, &x, &y, &series)
}
