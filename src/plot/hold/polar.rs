//! Limits of pulses by direction.

use std::f64::consts::TAU;

use crate::plot::axis::Axis;
use crate::plot::canvas::{Frame, LegendEntry, Marker, chart, line, point};
use crate::plot::svg::Svg;
use crate::plot::theme::{BLUE, Colour, GREEN, ORANGE, SOFT};
use crate::study::hold::{Hold, Limit, LoadCase, LoadResult, StaticLimit};

/// Height of the picture at which the frame is square.
const HEIGHT: f64 = 710.0;

/// Draws the largest acceleration held in each direction as a polar plot.
pub fn polar(found: &Hold) -> String {
    let limits = found.results.iter().flat_map(|load_result| [load_result.slips, load_result.drops]);
    let balanced = found.results.iter().filter_map(at_rest);
    let axis_limit =
        1.08 * limits.filter_map(|limit| radius(&limit)).chain(balanced).fold(found.plan.from_m_s2, f64::max);
    let x = Axis::from_range("acceleration along the palm, m/s²", -axis_limit, axis_limit);
    let y = Axis::from_range("acceleration out of the palm, m/s²", -axis_limit, axis_limit);
    chart(&format!("{}: acceleration held, by direction", found.scene), HEIGHT, &x, &y, |svg, frame| {
        for ring in x.ticks.iter().filter(|tick| **tick > 0.0) {
            let point_at = |index: usize| {
                let angle = TAU * index as f64 / 180.0;
                (ring * angle.cos(), ring * angle.sin())
            };
            line(svg, frame, (0..=180).map(point_at), Marker::FaintLine { width: 1.0 }, SOFT);
        }
        curve(svg, frame, found, GREEN, |load_result| Limit {
            held: at_rest(load_result),
            failed: at_rest(load_result),
            ..Limit::default()
        });
        curve(svg, frame, found, ORANGE, |load_result| load_result.drops);
        curve(svg, frame, found, BLUE, |load_result| load_result.slips);
        let slips = format!("slips less than {} mm", found.plan.slip_m * 1e3);
        let mut entries = vec![
            LegendEntry::new(Marker::Circle, BLUE, &slips),
            LegendEntry::new(Marker::Circle, ORANGE, "is not dropped"),
        ];
        if found.results.iter().any(|load_result| at_rest(load_result).is_some()) {
            entries.push(LegendEntry::new(Marker::Circle, GREEN, "is balanced at rest"));
        }
        let all = || found.results.iter().flat_map(|load_result| [load_result.slips, load_result.drops]);
        if all().any(|limit| limit.failed.is_none()) {
            entries.push(LegendEntry::new(Marker::Triangle, SOFT, "at least"));
        }
        if all().any(|limit| limit.held.is_none()) {
            entries.push(LegendEntry::new(Marker::Cross, SOFT, "less than"));
        }
        if all().any(|limit| limit.held_above.is_some()) {
            entries.push(LegendEntry::new(Marker::Ring, SOFT, "not monotone"));
        }
        entries
    })
}

/// Balanced acceleration at rest; `None` unless it is finite.
fn at_rest(load_result: &LoadResult) -> Option<f64> {
    match load_result.static_limit {
        Some(StaticLimit::UpTo { acceleration_m_s2 }) => Some(acceleration_m_s2),
        _ => None,
    }
}

fn radius(limit: &Limit) -> Option<f64> {
    limit.held.or(limit.failed)
}

/// Draws a closed curve, interrupted at directions without a limit.
fn curve(svg: &mut Svg, frame: &Frame, found: &Hold, colour: Colour, limit_of: impl Fn(&LoadResult) -> Limit) {
    let point_at = |load_result: &LoadResult| {
        let LoadCase::Pulse { direction_rad, .. } = load_result.case else { return None };
        let limit = limit_of(load_result);
        let (sin, cos) = direction_rad.sin_cos();
        radius(&limit).map(|radius| ((radius * cos, radius * sin), limit))
    };
    let all: Vec<_> = found.results.iter().map(point_at).collect();
    for (index, position) in all.iter().enumerate() {
        let next = &all[(index + 1) % all.len()];
        if let Some(((from, _), (to, _))) = position.as_ref().zip(next.as_ref()) {
            line(svg, frame, [*from, *to], Marker::Line { width: 2.0 }, colour);
        }
    }
    for (position, limit) in all.into_iter().flatten() {
        let marker = match (limit.held, limit.failed) {
            (Some(_), Some(_)) => Marker::Circle,
            (Some(_), None) => Marker::Triangle,
            _ => Marker::Cross,
        };
        point(svg, frame, position, marker, colour);
        if limit.held_above.is_some() {
            point(svg, frame, position, Marker::Ring, SOFT);
        }
    }
}
