//! Studies of grippers: final position of a captured object over its initial position, and the largest loads at which
//! the gripper holds its object, by direction of a pulse, by frequency of a vibration, or as slip over load.

use std::f64::consts::TAU;

use super::canvas::{Marker, THIN_LINE};
use super::chart::{Axis, PlotPoint, Series, series_chart};
use super::theme::{BLUE, Colour, GREEN, ORANGE, SERIES, SOFT};
use crate::format::{axis_unit, in_axis_unit};
use crate::scene;
use crate::statics::MechanismLimit;
use crate::study::capture::{Capture, ObjectPlacement};
use crate::study::hold::{Evaluation, Hold, LoadBracket, LoadCase, LoadResult, Loads, axis_name};
use crate::study::offsets::{OffsetPlacement, Offsets};

/// Minimum number of directions or frequencies of a curve.
const MIN_CURVE_POINTS: usize = 3;
const HEIGHT: f64 = 560.0;

/// Draws the results of a capture study. Objects that do not move are on the grey line.
pub fn capture(found: &Capture) -> String {
    let ended = |placement: &ObjectPlacement| placement.x_m.map(|x_m| x_m * 1e3);
    let reach = found.plan.error_m * 1e3;
    let captured = found.placements.iter().filter(|placement| placement.is_captured());
    let x = Axis::from_range("object at the start, mm from the middle", -1.1 * reach, 1.1 * reach);
    let y = Axis::linear("object at the end, mm from the middle", captured.filter_map(ended).chain([-reach, reach]));
    let mut series = vec![Series::new(THIN_LINE, SOFT, [(-reach, -reach), (reach, reach)])];
    let edges = found.captured_range.iter().flatten().filter_map(|edge| edge.lost_m);
    series.extend(edges.map(|lost_m| Series::vertical(ORANGE, lost_m * 1e3)));
    let has_edges = series.len() > 1;
    series.extend(found.placements.iter().map(|placement| {
        let (marker, colour, text) = match placement.form_closed {
            Some(true) => (Marker::Circle, GREEN, "held, form-closed"),
            _ if placement.is_captured() => (Marker::Circle, BLUE, "held"),
            _ if placement.fate.is_some() => (Marker::Cross, ORANGE, "not held"),
            _ => (Marker::Cross, SOFT, "simulation not completed"),
        };
        // Positions outside of the picture are clamped to its edge.
        Series::new(marker, colour, [(placement.offset_m * 1e3, ended(placement).unwrap_or(0.0))]).named(text)
    }));
    series.push(Series::key(THIN_LINE, SOFT, "does not move"));
    series.extend(has_edges.then(|| Series::key(THIN_LINE, ORANGE, "edge of the captured range")));
    series_chart(&format!("{}: captured objects", found.scene), HEIGHT, &x, &y, &series)
}

/// Draws the offsets of the object of a mechanism, and which of them are captured. For offsets along two axes, the plot
/// is a map; for one axis, it shows the final offset over the initial offset.
pub fn offsets(found: &Offsets) -> String {
    let label = |axis: scene::Axis| format!("{} at the start, {}", axis_name(axis), axis_unit(axis));
    let range = |(axis, largest): (scene::Axis, f64)| {
        let reach = 1.1 * in_axis_unit(axis, largest);
        Axis::from_range(&label(axis), -reach, reach)
    };
    let (first, second) = (found.plan.axes[0], found.plan.axes.get(1).copied());
    let across = first.0;
    let start = |axis: scene::Axis, placement: &OffsetPlacement| in_axis_unit(axis, placement.offset[axis as usize]);
    let height = |placement: &OffsetPlacement| match second {
        Some((axis, _)) => start(axis, placement),
        None => placement.end.map_or(0.0, |end| in_axis_unit(across, end[across as usize])),
    };
    let y = match second {
        Some(axis) => range(axis),
        None => Axis::linear(
            &format!("{} at the end, {}", axis_name(across), axis_unit(across)),
            found.placements.iter().filter(|placement| placement.is_captured()).map(height),
        ),
    };
    let points = found.placements.iter().map(|placement| {
        let (marker, colour, text) = match placement.fate {
            Some(_) if placement.is_captured() => (Marker::Circle, BLUE, "held"),
            Some(_) => (Marker::Cross, ORANGE, "not held"),
            None => (Marker::Cross, SOFT, "not run"),
        };
        Series::new(marker, colour, [(start(across, placement), height(placement))]).named(text)
    });
    let edges = found.captured_range.iter().flatten().filter_map(|edge| edge.lost);
    let edges = edges.map(|lost| Series::vertical(ORANGE, in_axis_unit(across, lost)));
    let series: Vec<Series> = points.chain(edges).collect();
    series_chart(&format!("{}: captured offsets", found.scene), HEIGHT, &range(first), &y, &series)
}

/// Draws the plot that suits the loads. For pulses, it shows the limits by direction; for vibrations, by frequency. If
/// there are too few loads, it shows the slip over the load.
pub fn hold(found: &Hold) -> String {
    match &found.plan.loads {
        Loads::Pulses { directions, .. } if *directions >= MIN_CURVE_POINTS => polar(found),
        Loads::Vibrations { frequencies_hz, .. } if frequencies_hz.len() >= MIN_CURVE_POINTS => frequency(found),
        _ => slip(found),
    }
}

type LimitOf = fn(&LoadResult) -> LoadBracket;

/// Draws the largest acceleration held in each direction as a polar plot.
fn polar(found: &Hold) -> String {
    let limits: [(Colour, LimitOf); 3] =
        [(GREEN, at_rest), (ORANGE, |result| result.drops), (BLUE, |result| result.slips)];
    let all = || limits.iter().flat_map(|(_, limit)| found.results.iter().map(limit));
    let reach = 1.08 * all().filter_map(|limit| limit.held.or(limit.failed)).fold(found.plan.from_m_s2, f64::max);
    let [along, out] = match found.base {
        None => ["acceleration along the palm, m/s²", "acceleration out of the palm, m/s²"],
        Some(_) => ["acceleration along x, m/s²", "acceleration along y, m/s²"],
    };
    let (x, y) = (Axis::from_range(along, -reach, reach), Axis::from_range(out, -reach, reach));
    let circle = |radius: f64| {
        let angles = (0..=180).map(|index| TAU * f64::from(index) / 180.0);
        let points = angles.map(|angle| (radius * angle.cos(), radius * angle.sin()));
        Series::new(Marker::FaintLine { width: 1.0 }, SOFT, points)
    };
    let mut series: Vec<Series> = x.ticks.iter().filter(|tick| **tick > 0.0).map(|ring| circle(*ring)).collect();
    series.extend(limits.iter().flat_map(|(colour, limit)| polar_curve(found, *colour, *limit)));
    series.push(Series::key(Marker::Circle, BLUE, format!("slips less than {} mm", found.plan.slip_m * 1e3)));
    series.push(Series::key(Marker::Circle, ORANGE, "is not dropped"));
    let is_balanced = found.results.iter().any(|result| at_rest(result).held.is_some());
    series.extend(is_balanced.then(|| Series::key(Marker::Circle, GREEN, "is balanced at rest")));
    let simulated: Vec<LoadBracket> = found.results.iter().flat_map(|result| [result.slips, result.drops]).collect();
    series.extend(limit_keys(&simulated));
    // At this height, the frame is square.
    series_chart(&format!("{}: acceleration held, by direction", found.scene), 710.0, &x, &y, &series)
}

/// Balanced acceleration at rest, as a limit; without values unless it is finite.
fn at_rest(result: &LoadResult) -> LoadBracket {
    let balanced = result.static_limit.as_ref().and_then(MechanismLimit::acceleration_m_s2);
    LoadBracket { held: balanced, failed: balanced, ..LoadBracket::default() }
}

/// A closed curve of limits with their markers, interrupted at directions without a limit.
fn polar_curve(found: &Hold, colour: Colour, limit: LimitOf) -> Vec<Series> {
    let point_at = |result: &LoadResult| {
        let LoadCase::Pulse { direction_rad, .. } = result.case else { return None };
        let limit = limit(result);
        let (sin, cos) = direction_rad.sin_cos();
        limit.held.or(limit.failed).map(|radius| ((radius * cos, radius * sin), limit))
    };
    let all: Vec<Option<(PlotPoint, LoadBracket)>> = found.results.iter().map(point_at).collect();
    let pairs = all.iter().zip(all.iter().cycle().skip(1));
    let lines = pairs.filter_map(|(from, to)| Some([from.as_ref()?.0, to.as_ref()?.0]));
    let mut series: Vec<Series> = lines.map(|ends| Series::new(Marker::Line { width: 2.0 }, colour, ends)).collect();
    series.extend(all.into_iter().flatten().flat_map(|(position, limit)| limit_markers(colour, position, limit)));
    series
}

/// Markers of a limit: whether it is bracketed by loads that are held and that fail, and whether it is not monotone.
fn limit_markers(colour: Colour, position: PlotPoint, limit: LoadBracket) -> impl Iterator<Item = Series> {
    let marker = match (limit.held, limit.failed) {
        (Some(_), Some(_)) => Marker::Circle,
        (Some(_), None) => Marker::Triangle,
        _ => Marker::Cross,
    };
    let ring = limit.held_above.map(|_| Series::new(Marker::Ring, SOFT, [position]));
    std::iter::once(Series::new(marker, colour, [position])).chain(ring)
}

/// Legend of the markers that occur.
fn limit_keys(limits: &[LoadBracket]) -> impl Iterator<Item = Series> {
    let any = |condition: fn(&LoadBracket) -> bool| limits.iter().any(condition);
    let keys = [
        (any(|limit| limit.failed.is_none()), Marker::Triangle, "at least"),
        (any(|limit| limit.held.is_none()), Marker::Cross, "less than"),
        (any(|limit| limit.held_above.is_some()), Marker::Ring, "not monotone"),
    ];
    keys.into_iter().filter(|(occurs, ..)| *occurs).map(|(_, marker, name)| Series::key(marker, SOFT, name))
}

/// Draws the largest displacement amplitude held over the frequency, with logarithmic axes.
fn frequency(found: &Hold) -> String {
    let (mut series, mut limits, mut curves) = (Vec::new(), Vec::new(), 0);
    let axes = [scene::Axis::X, scene::Axis::Y, scene::Axis::Angle];
    for (along, is_drop) in axes.into_iter().flat_map(|axis| [(axis, false), (axis, true)]) {
        let held = |result: &LoadResult| {
            let LoadCase::Vibration { axis, frequency_hz } = result.case else { return None };
            let limit = if is_drop { result.drops } else { result.slips };
            let peak_m_s2 = limit.held.filter(|_| axis == along)?;
            Some(((frequency_hz, 1e3 * peak_m_s2 / (TAU * frequency_hz).powi(2)), limit))
        };
        let curve: Vec<(PlotPoint, LoadBracket)> = found.results.iter().filter_map(held).collect();
        if curve.is_empty() {
            continue;
        }
        let (colour, name) = (SERIES[curves % SERIES.len()], axis_name(along));
        let (width, name) = match is_drop {
            true => (1.0, format!("{name}: is not dropped")),
            false => (3.0, format!("{name}: slips < {} mm", found.plan.slip_m * 1e3)),
        };
        series.push(Series::new(Marker::Line { width }, colour, curve.iter().map(|point| point.0)).named(name));
        series.extend(curve.iter().flat_map(|(position, limit)| limit_markers(colour, *position, *limit)));
        limits.extend(curve.into_iter().map(|point| point.1));
        curves += 1;
    }
    let points = || series.iter().flat_map(|each: &Series| &each.points);
    let x = Axis::logarithmic("frequency, Hz", points().map(|point| point.0), 6.0);
    let y = Axis::logarithmic("amplitude at the object, mm", points().map(|point| point.1), 12.0);
    series.extend(limit_keys(&limits));
    series_chart(&format!("{}: vibration held, by frequency", found.scene), HEIGHT, &x, &y, &series)
}

/// Draws the slip of every run over its load, with logarithmic axes.
fn slip(found: &Hold) -> String {
    let slip_mm = |evaluation: &Evaluation| Some(evaluation.outcome.as_ref().ok()?.slip.displacement_m * 1e3);
    let all = || found.results.iter().flat_map(|result| &result.evaluations);
    let bound_mm = found.plan.slip_m * 1e3;
    let x = Axis::logarithmic("peak acceleration, m/s²", all().map(|evaluation| evaluation.peak_m_s2), 8.0);
    let y = Axis::logarithmic("slip in the hand, mm", all().filter_map(slip_mm).chain([bound_mm]), 8.0);
    let mut series = vec![Series::horizontal(THIN_LINE, SOFT, bound_mm)];
    for (result, colour) in found.results.iter().zip(SERIES.into_iter().cycle()) {
        let finished =
            |evaluation: &Evaluation| Some(((evaluation.peak_m_s2, slip_mm(evaluation)?), evaluation.is_held()));
        let runs: Vec<(PlotPoint, Option<bool>)> = result.evaluations.iter().filter_map(finished).collect();
        series.push(Series::new(THIN_LINE, colour, runs.iter().map(|run| run.0)));
        series.extend(runs.iter().map(|(position, is_held)| {
            let marker = if *is_held == Some(true) { Marker::Circle } else { Marker::Cross };
            Series::new(marker, colour, [*position])
        }));
        let name = match result.case {
            LoadCase::Pulse { direction_rad, .. } => format!("pulse to {:.0}°", direction_rad.to_degrees()),
            LoadCase::Vibration { axis, frequency_hz } => format!("{}, {frequency_hz} Hz", axis_name(axis)),
            LoadCase::Move => "move".to_string(),
        };
        series.push(Series::key(Marker::Circle, colour, name));
    }
    series.push(Series::key(Marker::Cross, SOFT, "not held at the end"));
    series.push(Series::key(THIN_LINE, SOFT, "bound"));
    series_chart(&format!("{}: slip of the object", found.scene), HEIGHT, &x, &y, &series)
}
