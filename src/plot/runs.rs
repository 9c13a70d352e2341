//! Two runs over time: their quantities in stacked panels, and their difference with touch-downs. Wall time against error
//! of all evaluated settings.

use super::canvas::{Marker, THIN_LINE};
use super::chart::{Axis, Panel, PlotPoint, Series, panel_chart, series_chart};
use super::theme::{AMBER, BLUE, GREEN, INK, ORANGE, SERIES, SOFT};
use crate::scene::Scene;
use crate::trace::{ContactSample, EventKind, FingerState, Sample, Schema};
use crate::validate::{Angle, Family, LadderRow, Recording, Validation, coordinate_errors};

/// Maximum number of touch-downs drawn per contact; more would hide the curves.
const MAX_TOUCHDOWNS: usize = 60;
/// In an overlay, the first run has wide faint curves, the second thin curves on top.
const FIRST: Marker = Marker::FaintLine { width: 6.0 };

/// Draws the difference between the two models in a validation of a scene with fingers.
pub fn difference(scene: &Scene, found: &Validation) -> String {
    let schema = Schema::from_scene(scene);
    let (quantity, label) = match schema.bodies.is_empty() {
        true => ("the joint angles", "|engine − analytic|, rad"),
        false => ("the joint angles and the object", "|engine − analytic|, rad or m"),
    };
    let title = format!("{}: difference of {quantity} over time", scene.name);
    let runs = [&found.engine, &found.reference, &found.reference];
    plot_differences(&title, label, &schema, runs, Some(found.path_bound), found.until_s)
}

/// Draws differences of the angles of fingers and of the centres of bodies between a run and a reference over time, with
/// the touch-downs of a third one. Differences below eight decades are on the lower edge.
pub(crate) fn plot_differences(
    title: &str,
    label: &str,
    schema: &Schema,
    [run, reference, with_touchdowns]: [&Recording; 3],
    bound: Option<f64>,
    until_s: f64,
) -> String {
    let angles = schema
        .fingers
        .iter()
        .flat_map(|finger| Angle::ALL.map(|angle| [finger.as_str(), angle.name()].join(" ").trim_start().to_string()));
    let names = angles.chain(schema.bodies.iter().cloned());
    let mut curves: Vec<(String, Vec<PlotPoint>)> = names.map(|name| (name, Vec::new())).collect();
    let mut cursor = 0;
    for sample in run.samples.iter().filter(|sample| sample.time_s <= until_s) {
        let Some(expected) = reference.interpolate(sample.time_s, &mut cursor) else { continue };
        for ((_, points), error) in curves.iter_mut().zip(coordinate_errors(sample, &expected)) {
            points.push((sample.time_s, error.abs()));
        }
    }
    let all = curves.iter().flat_map(|(_, points)| points.iter().map(|point| point.1));
    let y = Axis::logarithmic(label, all.chain(bound), 8.0);
    let x = Axis::linear("time, ms", [0.0, until_s * 1e3]);
    let mut series = Vec::new();
    for (contact, colour) in schema.surfaces().zip([SOFT, INK].into_iter().cycle()) {
        let name = format!("touch-down {}", schema.contacts[contact].name);
        let events = with_touchdowns.events.iter();
        let events = events.filter(|event| event.contact == contact && event.kind == EventKind::TouchDown);
        let shown = events.filter(|event| event.time_s <= until_s).take(MAX_TOUCHDOWNS);
        series.extend(shown.map(|event| Series::vertical(colour, event.time_s * 1e3).named(&name)));
    }
    let bound_line = |bound| Series::horizontal(Marker::FaintLine { width: 4.0 }, INK, bound);
    series.extend(bound.map(|bound| bound_line(bound).named("bound of the scene")));
    series.extend(curves.into_iter().zip(SERIES.into_iter().cycle()).map(|((name, points), colour)| {
        Series::over_time(Marker::Line { width: 2.0 }, colour, points.into_iter()).named(name)
    }));
    series_chart(title, 560.0, &x, &y, &series)
}

/// Draws the wall time over the error for all settings with a finite error: one point per setting, one line per family.
pub fn speed_error(scene: &str, found: &Validation) -> String {
    let last = &found.reference.outcome.last;
    let label = match (last.counts().fingers == 0, last.counts().bodies == 0) {
        (false, true) => "largest difference of a joint angle from the reference, rad",
        (false, false) => "largest difference of a joint angle from the reference, rad (of the object in 20 mm)",
        (true, _) => "largest distance of a disc from its position in the reference, m",
    };
    let bound = found.path_bound;
    let error_and_time = |row: &LadderRow| {
        let (differences, wall_s) = row.differences.as_ref().zip(row.cost.wall_s)?;
        let error = differences.path_max();
        (error.is_finite() && error > 0.0).then_some((error, wall_s * 1e3))
    };
    let all: Vec<(&LadderRow, PlotPoint)> =
        found.ladder.iter().filter_map(|row| Some((row, error_and_time(row)?))).collect();
    let x = Axis::logarithmic(label, all.iter().map(|(_, point)| point.0).chain([bound]), 16.0);
    let y = Axis::logarithmic("wall time of a run, ms", all.iter().map(|(_, point)| point.1), 16.0);
    let mut series = vec![Series::vertical(SOFT, bound)];
    for family in Family::ALL {
        let points = |marker, colour, is_shown: fn(&LadderRow) -> bool| {
            let rows = all.iter().filter(|(row, _)| row.configuration.family == family && is_shown(row));
            Series::new(marker, colour, rows.map(|(_, point)| *point))
        };
        let (marker, colour) = match family {
            Family::EngineAdaptive => (Marker::Circle, BLUE),
            Family::EngineFixed => (Marker::Square, GREEN),
            Family::Native => (Marker::Cross, AMBER),
            Family::Analytic => (Marker::Circle, ORANGE),
        };
        series.push(points(THIN_LINE, colour, |_| true));
        let named = points(marker, colour, |_| true).named(family.name());
        series.extend(Some(named).filter(|named| !named.points.is_empty()));
        series.push(points(Marker::Ring, INK, |row| row.configuration.is_from_scene));
    }
    series.push(Series::key(Marker::Ring, INK, "the scene's settings"));
    series.push(Series::key(THIN_LINE, SOFT, "bound of the scene"));
    series_chart(&format!("{scene}: speed against error"), 600.0, &x, &y, &series)
}

/// Draws the runs of both models in a validation on top of each other.
pub fn overlay(scene: &Scene, found: &Validation) -> String {
    let title = format!("{}: analytic model and engine", scene.name);
    let end_s = found.reference.outcome.last.time_s;
    let labels = ["analytic (reference)", "engine"];
    overlay_runs(&title, labels, &Schema::from_scene(scene), [&found.reference, &found.engine], end_s)
}

/// Draws two runs of this schema. Surfaces without contact are omitted if others have contact.
pub(crate) fn overlay_runs(
    title: &str,
    labels: [&str; 2],
    schema: &Schema,
    runs: [&Recording; 2],
    end_s: f64,
) -> String {
    let x = Axis::linear("time, ms", [0.0, end_s * 1e3]);
    let mut panels = panels(schema, runs);
    if let Some(first) = panels.first_mut() {
        first.series.splice(..0, [Series::key(FIRST, INK, labels[0]), Series::key(THIN_LINE, INK, labels[1])]);
    }
    panel_chart(title, &x, [0.0, 230.0], &[], &panels)
}

/// Name of a curve, and its value in a sample.
type Quantity = (String, Box<dyn Fn(&Sample) -> f64>);

fn quantity(name: impl Into<String>, value: impl Fn(&Sample) -> f64 + 'static) -> Quantity {
    (name.into(), Box::new(value))
}

/// Panels of joints, object, forces, gaps and energies; those that do not apply to the scene are omitted.
fn panels(schema: &Schema, runs: [&Recording; 2]) -> Vec<Panel> {
    let discs = schema.fingers.is_empty();
    let mut panels = Vec::new();
    // Curves of quantities in both runs, with successive colours.
    let mut add = |label: &str, is_logarithmic: bool, quantities: Vec<Quantity>| {
        let both = || runs.into_iter().flat_map(|run| &run.samples);
        let values = quantities.iter().flat_map(|(_, value)| both().map(value));
        let y = if is_logarithmic { Axis::logarithmic(label, values, 7.0) } else { Axis::linear(label, values) };
        let coloured = || quantities.iter().zip(SERIES.into_iter().cycle());
        let curves = runs.into_iter().zip([FIRST, THIN_LINE]).flat_map(|(run, marker)| {
            coloured().map(move |((_, value), colour)| {
                Series::over_time(marker, colour, run.samples.iter().map(|sample| (sample.time_s, value(sample))))
            })
        });
        let keys = coloured().map(|((name, _), colour)| Series::key(Marker::Line { width: 2.0 }, colour, name));
        panels.push(Panel { heading: None, series: curves.chain(keys).collect(), y });
    };
    if !discs {
        let angles: [JointQuantity; 3] = [
            ("q11", |finger| finger.q11_rad.to_degrees()),
            ("q21", |finger| finger.q21_rad.to_degrees()),
            ("q22", |finger| finger.q22_rad.to_degrees()),
        ];
        add("joint angle, deg", false, joints(schema, angles));
    }
    if schema.fingers.len() == 1 {
        let rates: [JointQuantity; 3] = [
            ("qd11", |finger| finger.qd11_rad_s),
            ("qd21", |finger| finger.qd21_rad_s),
            ("qd22", |finger| finger.qd22_rad_s),
        ];
        add("joint rate, rad/s", false, joints(schema, rates));
    } else if !schema.bodies.is_empty() && !discs {
        let centre = |axis: usize| move |sample: &Sample| sample.body(0).centre_m[axis] * 1e3;
        add("object, mm", false, vec![quantity("x", centre(0)), quantity("y", centre(1))]);
    }
    let shown_contacts = shown_contacts(schema, runs);
    let contacts = |value: fn(&ContactSample) -> f64| -> Vec<Quantity> {
        let contact = |&index: &usize| {
            let name = &schema.contacts[index].name;
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

/// Surfaces that have contact in a run, or all surfaces if none has; always all surfaces for a single finger with an
/// object.
fn shown_contacts(schema: &Schema, runs: [&Recording; 2]) -> Vec<usize> {
    let any = |of: &dyn Fn(&Recording) -> Option<bool>| runs.into_iter().any(|run| of(run) == Some(true));
    let has_contact = |index: &usize| any(&|run| Some(run.outcome.contacts.get(*index)?.first_s.is_some()));
    let all: Vec<usize> = schema.surfaces().collect();
    let in_contact: Vec<usize> = all.iter().copied().filter(has_contact).collect();
    if in_contact.is_empty() || schema.fingers.len() == 1 { all } else { in_contact }
}

/// Name and value of a quantity of a finger's joint.
type JointQuantity = (&'static str, fn(&FingerState) -> f64);

/// Quantities of the joints of every finger.
fn joints(schema: &Schema, values: [JointQuantity; 3]) -> Vec<Quantity> {
    let of_finger = |(index, finger): (usize, &String)| {
        values.map(|(joint, value)| {
            let name = [finger, joint].join(" ");
            quantity(name.trim_start(), move |sample| value(&sample.finger(index)))
        })
    };
    schema.fingers.iter().enumerate().flat_map(of_finger).collect()
}
