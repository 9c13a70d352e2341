//! Limits of pulses, by their directions.

use std::f64::consts::TAU;

use plotters::style::RGBColor;

use crate::plot::axis::Axis;
use crate::plot::canvas::{
    BLUE, DrawError, Entry, Frame, GREEN, GREY, LEGEND, Mark, ORANGE, WIDTH, frame, legend, line, picture, point,
    titled,
};
use crate::study::hold::{AtRest, Case, Held, Hold, Limit};

/// So that the frame is a square beside the legend.
const HEIGHT: u32 = 710;

/// The picture: as far from the middle as the acceleration that is held.
pub fn polar(found: &Hold) -> Result<String, DrawError> {
    let limits = found.held.iter().flat_map(|held| [held.slips, held.drops]);
    let balanced = found.held.iter().filter_map(at_rest);
    let reach = 1.08 * limits.filter_map(|limit| radius(&limit)).chain(balanced).fold(found.plan.from_m_s2, f64::max);
    let x = Axis::over("acceleration along the palm, m/s²", -reach, reach);
    let y = Axis::over("acceleration out of the palm, m/s²", -reach, reach);
    picture(HEIGHT, |area| {
        let rest = titled(area, &format!("{}: the acceleration it holds, by direction", found.scene))?;
        let (left, right) = rest.split_horizontally(WIDTH - LEGEND - 30);
        let mut chart = frame(&left, &x, &y, true)?;
        for ring in x.ticks.iter().filter(|tick| **tick > 0.0) {
            let at = |index: usize| {
                let angle = TAU * index as f64 / 180.0;
                (ring * angle.cos(), ring * angle.sin())
            };
            line(&mut chart, (0..=180).map(at).collect(), Mark::Pale { width: 1 }, GREY)?;
        }
        curve(&mut chart, found, GREEN, |held| Limit {
            held: at_rest(held),
            failed: at_rest(held),
            ..Limit::default()
        })?;
        curve(&mut chart, found, ORANGE, |held| held.drops)?;
        curve(&mut chart, found, BLUE, |held| held.slips)?;
        let slips = format!("slips less than {} mm", found.plan.slip_m * 1e3);
        let mut entries =
            vec![Entry::new(Mark::Circle, BLUE, &slips), Entry::new(Mark::Circle, ORANGE, "is not dropped")];
        if found.held.iter().any(|held| at_rest(held).is_some()) {
            entries.push(Entry::new(Mark::Circle, GREEN, "is balanced at rest"));
        }
        let all = || found.held.iter().flat_map(|held| [held.slips, held.drops]);
        if all().any(|limit| limit.failed.is_none()) {
            entries.push(Entry::new(Mark::Triangle, GREY, "at least"));
        }
        if all().any(|limit| limit.held.is_none()) {
            entries.push(Entry::new(Mark::Cross, GREY, "less than"));
        }
        if all().any(|limit| limit.held_above.is_some()) {
            entries.push(Entry::new(Mark::Ring, GREY, "not monotone"));
        }
        legend(&right, &entries)
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
fn curve(chart: &mut Frame, found: &Hold, colour: RGBColor, of: impl Fn(&Held) -> Limit) -> Result<(), DrawError> {
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
            line(chart, vec![*from, *to], Mark::Line { width: 2 }, colour)?;
        }
    }
    for (place, limit) in all.into_iter().flatten() {
        let mark = match (limit.held, limit.failed) {
            (Some(_), Some(_)) => Mark::Circle,
            (Some(_), None) => Mark::Triangle,
            _ => Mark::Cross,
        };
        point(chart, place, mark, colour)?;
        if limit.held_above.is_some() {
            point(chart, place, Mark::Ring, GREY)?;
        }
    }
    Ok(())
}
