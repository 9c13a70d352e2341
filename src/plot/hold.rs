//! Largest loads at which a gripper holds its object: by direction of a pulse, by frequency of a vibration, or the slip
//! over the load.

use std::f64::consts::TAU;

use super::axis::Axis;
use super::canvas::{Marker, PlotPoint, THIN_LINE};
use super::series::{Series, series_chart};
use super::theme::{BLUE, Colour, GREEN, ORANGE, SERIES, SOFT};
use crate::scene;
use crate::statics::AccelerationLimit;
use crate::study::hold::{Evaluation, Hold, Limit, LoadCase, LoadResult, Loads, Verdict};

/// Minimum number of directions or frequencies of a curve.
const MIN_CURVE_POINTS: usize = 3;
const HEIGHT: f64 = 560.0;
/// Height at which the frame of the polar plot is square.
const POLAR_HEIGHT: f64 = 710.0;

/// Draws the plot that suits the loads: limits by direction for pulses, by frequency for vibrations, or the slip over
/// the load if there are too few of them.
pub fn hold(found: &Hold) -> String {
    match &found.plan.loads {
        Loads::Pulses { directions, .. } if *directions >= MIN_CURVE_POINTS => polar(found),
        Loads::Vibrations { frequencies_hz, .. } if frequencies_hz.len() >= MIN_CURVE_POINTS => frequency(found),
        _ => slip(found),
    }
}

/// A limit of a load.
type LimitOf = fn(&LoadResult) -> Limit;

/// Draws the largest acceleration held in each direction as a polar plot.
fn polar(found: &Hold) -> String {
    let limits: [(Colour, LimitOf); 3] =
        [(GREEN, at_rest), (ORANGE, |result| result.drops), (BLUE, |result| result.slips)];
    let all = || limits.iter().flat_map(|(_, limit)| found.results.iter().map(limit));
    let reach = 1.08 * all().filter_map(|limit| limit.held.or(limit.failed)).fold(found.plan.from_m_s2, f64::max);
    let x = Axis::from_range("acceleration along the palm, m/s²", -reach, reach);
    let y = Axis::from_range("acceleration out of the palm, m/s²", -reach, reach);
    let mut series: Vec<Series> = x.ticks.iter().filter(|tick| **tick > 0.0).map(|ring| circle(*ring)).collect();
    series.extend(limits.iter().flat_map(|(colour, limit)| polar_curve(found, *colour, *limit)));
    series.push(Series::key(Marker::Circle, BLUE, format!("slips less than {} mm", found.plan.slip_m * 1e3)));
    series.push(Series::key(Marker::Circle, ORANGE, "is not dropped"));
    let simulated: Vec<Limit> = found.results.iter().flat_map(|result| [result.slips, result.drops]).collect();
    let any = |condition: fn(&Limit) -> bool| simulated.iter().any(condition);
    for (is_shown, marker, colour, name) in [
        (
            found.results.iter().any(|result| at_rest(result).held.is_some()),
            Marker::Circle,
            GREEN,
            "is balanced at rest",
        ),
        (any(|limit| limit.failed.is_none()), Marker::Triangle, SOFT, "at least"),
        (any(|limit| limit.held.is_none()), Marker::Cross, SOFT, "less than"),
        (any(|limit| limit.held_above.is_some()), Marker::Ring, SOFT, "not monotone"),
    ] {
        series.extend(is_shown.then(|| Series::key(marker, colour, name)));
    }
    series_chart(&format!("{}: acceleration held, by direction", found.scene), POLAR_HEIGHT, &x, &y, &series)
}

fn circle(radius: f64) -> Series {
    let angles = (0..=180).map(|index| TAU * f64::from(index) / 180.0);
    let points = angles.map(|angle| (radius * angle.cos(), radius * angle.sin()));
    Series::new(Marker::FaintLine { width: 1.0 }, SOFT, points)
}

/// Balanced acceleration at rest, as a limit; without values unless it is finite.
fn at_rest(result: &LoadResult) -> Limit {
    let balanced = result.static_limit.as_ref().and_then(AccelerationLimit::acceleration_m_s2);
    Limit { held: balanced, failed: balanced, ..Limit::default() }
}

/// A closed curve of limits with their markers, interrupted at directions without a limit.
fn polar_curve(found: &Hold, colour: Colour, limit: LimitOf) -> Vec<Series> {
    let point_at = |result: &LoadResult| {
        let LoadCase::Pulse { direction_rad, .. } = result.case else { return None };
        let limit = limit(result);
        let (sin, cos) = direction_rad.sin_cos();
        limit.held.or(limit.failed).map(|radius| ((radius * cos, radius * sin), limit))
    };
    let all: Vec<Option<(PlotPoint, Limit)>> = found.results.iter().map(point_at).collect();
    let pairs = all.iter().zip(all.iter().cycle().skip(1));
    let lines = pairs.filter_map(|(from, to)| Some([from.as_ref()?.0, to.as_ref()?.0]));
    let mut series: Vec<Series> = lines.map(|ends| Series::new(Marker::Line { width: 2.0 }, colour, ends)).collect();
    for (position, limit) in all.into_iter().flatten() {
        let marker = match (limit.held, limit.failed) {
            (Some(_), Some(_)) => Marker::Circle,
            (Some(_), None) => Marker::Triangle,
            _ => Marker::Cross,
        };
        series.push(Series::new(marker, colour, [position]));
        series.extend(limit.held_above.map(|_| Series::new(Marker::Ring, SOFT, [position])));
    }
    series
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
        let curve: Vec<(PlotPoint, Limit)> = found.results.iter().filter_map(held).collect();
        if curve.is_empty() {
            continue;
        }
        let (colour, name) = (SERIES[curves % SERIES.len()], axis_name(along));
        let (width, name) = match is_drop {
            true => (1.0, format!("{name}: is not dropped")),
            false => (3.0, format!("{name}: slips < {} mm", found.plan.slip_m * 1e3)),
        };
        series.push(Series::new(Marker::Line { width }, colour, curve.iter().map(|point| point.0)).named(name));
        for (position, limit) in &curve {
            let marker = if limit.failed.is_some() { Marker::Circle } else { Marker::Triangle };
            series.push(Series::new(marker, colour, [*position]));
            series.extend(limit.held_above.map(|_| Series::new(Marker::Ring, SOFT, [*position])));
        }
        limits.extend(curve.into_iter().map(|point| point.1));
        curves += 1;
    }
    let points = || series.iter().flat_map(|each: &Series| &each.points);
    let x = Axis::logarithmic("frequency, Hz", points().map(|point| point.0), 6.0);
    let y = Axis::logarithmic("amplitude at the object, mm", points().map(|point| point.1), 12.0);
    let open = limits.iter().any(|limit| limit.failed.is_none());
    series.extend(open.then(|| Series::key(Marker::Triangle, SOFT, "at least")));
    let not_monotone = limits.iter().any(|limit| limit.held_above.is_some());
    series.extend(not_monotone.then(|| Series::key(Marker::Ring, SOFT, "not monotone")));
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
            |evaluation: &Evaluation| Some(((evaluation.peak_m_s2, slip_mm(evaluation)?), evaluation.drops()));
        let runs: Vec<(PlotPoint, Verdict)> = result.evaluations.iter().filter_map(finished).collect();
        series.push(Series::new(THIN_LINE, colour, runs.iter().map(|run| run.0)));
        series.extend(runs.iter().map(|(position, drops)| {
            let marker = if *drops == Verdict::Held { Marker::Circle } else { Marker::Cross };
            Series::new(marker, colour, [*position])
        }));
        series.push(Series::key(Marker::Circle, colour, load_name(&result.case)));
    }
    series.push(Series::key(Marker::Cross, SOFT, "not held at the end"));
    series.push(Series::key(THIN_LINE, SOFT, "bound"));
    series_chart(&format!("{}: slip of the object", found.scene), HEIGHT, &x, &y, &series)
}

fn axis_name(axis: scene::Axis) -> &'static str {
    match axis {
        scene::Axis::X => "x",
        scene::Axis::Y => "y",
        scene::Axis::Angle => "angle",
    }
}

fn load_name(case: &LoadCase) -> String {
    match case {
        LoadCase::Pulse { direction_rad, .. } => format!("pulse to {:.0}°", direction_rad.to_degrees()),
        LoadCase::Vibration { axis, frequency_hz } => format!("{}, {frequency_hz} Hz", axis_name(*axis)),
        LoadCase::Move => "move".to_string(),
    }
}
