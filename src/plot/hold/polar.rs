//! Limits of pulses, by their directions.

use std::f64::consts::TAU;

use crate::plot::axis::Axis;
use crate::plot::canvas::{Entry, Frame, Mark, chart, line, point};
use crate::plot::svg::Svg;
use crate::plot::theme::{BLUE, Colour, GREEN, ORANGE, SOFT};
use crate::study::hold::{AtRest, Case, Held, Hold, Limit};

/// So that the frame is a square beside the legend.
const HEIGHT: f64 = 710.0;

/// The picture: as far from the middle as the acceleration that is held.
pub fn polar(found: &Hold) -> String {
    let limits = found.held.iter().flat_map(|held| [held.slips, held.drops]);
    let balanced = found.held.iter().filter_map(at_rest);
    let reach = 1.08 * limits.filter_map(|limit| radius(&limit)).chain(balanced).fold(found.plan.from_m_s2, f64::max);
    let x = Axis::over("acceleration along the palm, m/s²", -reach, reach);
    let y = Axis::over("acceleration out of the palm, m/s²", -reach, reach);
    chart(&format!("{}: the acceleration it holds, by direction", found.scene), HEIGHT, &x, &y, |svg, on| {
        for ring in x.ticks.iter().filter(|tick| **tick > 0.0) {
            let at = |index: usize| {
                let angle = TAU * index as f64 / 180.0;
                (ring * angle.cos(), ring * angle.sin())
            };
            line(svg, on, (0..=180).map(at), Mark::Pale { width: 1.0 }, SOFT);
        }
        curve(svg, on, found, GREEN, |held| Limit { held: at_rest(held), failed: at_rest(held), ..Limit::default() });
        curve(svg, on, found, ORANGE, |held| held.drops);
        curve(svg, on, found, BLUE, |held| held.slips);
        let slips = format!("slips less than {} mm", found.plan.slip_m * 1e3);
        let mut entries =
            vec![Entry::new(Mark::Circle, BLUE, &slips), Entry::new(Mark::Circle, ORANGE, "is not dropped")];
        if found.held.iter().any(|held| at_rest(held).is_some()) {
            entries.push(Entry::new(Mark::Circle, GREEN, "is balanced at rest"));
        }
        let all = || found.held.iter().flat_map(|held| [held.slips, held.drops]);
        if all().any(|limit| limit.failed.is_none()) {
            entries.push(Entry::new(Mark::Triangle, SOFT, "at least"));
        }
        if all().any(|limit| limit.held.is_none()) {
            entries.push(Entry::new(Mark::Cross, SOFT, "less than"));
        }
        if all().any(|limit| limit.held_above.is_some()) {
            entries.push(Entry::new(Mark::Ring, SOFT, "not monotone"));
        }
        entries
    })
}

/// `None` where there is no finite one.
fn at_rest(held: &Held) -> Option<f64> {
    match held.at_rest {
        Some(AtRest::UpTo { acceleration_m_s2 }) => Some(acceleration_m_s2),
        _ => None,
    }
}

fn radius(limit: &Limit) -> Option<f64> {
    limit.held.or(limit.failed)
}

/// A closed curve around the middle, open where there is nothing to be said.
fn curve(svg: &mut Svg, on: &Frame, found: &Hold, colour: Colour, of: impl Fn(&Held) -> Limit) {
    let at = |held: &Held| {
        let Case::Pulse { direction_rad, .. } = held.case else { return None };
        let limit = of(held);
        let (sin, cos) = direction_rad.sin_cos();
        radius(&limit).map(|radius| ((radius * cos, radius * sin), limit))
    };
    let all: Vec<_> = found.held.iter().map(at).collect();
    for (index, place) in all.iter().enumerate() {
        let next = &all[(index + 1) % all.len()];
        if let Some(((from, _), (to, _))) = place.as_ref().zip(next.as_ref()) {
            line(svg, on, [*from, *to], Mark::Line { width: 2.0 }, colour);
        }
    }
    for (place, limit) in all.into_iter().flatten() {
        let mark = match (limit.held, limit.failed) {
            (Some(_), Some(_)) => Mark::Circle,
            (Some(_), None) => Mark::Triangle,
            _ => Mark::Cross,
        };
        point(svg, on, place, mark, colour);
        if limit.held_above.is_some() {
            point(svg, on, place, Mark::Ring, SOFT);
        }
    }
}
