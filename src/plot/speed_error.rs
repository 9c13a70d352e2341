//! Wall time against error: one point a setting, one line a family of settings.

use super::axis::Axis;
use super::canvas::{Entry, Mark, THIN, chart, line, points, upright};
use super::theme::{AMBER, BLUE, Colour, GREEN, INK, ORANGE, PURPLE, SOFT};
use crate::validate::{Family, Row, Tried, Validation};

const HEIGHT: f64 = 600.0;

/// The picture; settings without a finite error are not in it.
pub fn speed_error(scene: &str, found: &Validation) -> String {
    let last = &found.reference.outcome.last;
    let label = match (last.fingers.is_empty(), last.bodies.is_empty()) {
        (false, true) => "largest difference of a joint angle from the reference, rad",
        (false, false) => "largest difference of a joint angle from the reference, rad (of the object in 20 mm)",
        (true, _) => "largest distance of a disc from its place in the reference, m",
    };
    let bound = found.path_bound;
    let all: Vec<(&Row, f64, f64)> = found.rows.iter().filter_map(|row| place(row).map(|(x, y)| (row, x, y))).collect();
    let x = Axis::decades(label, all.iter().map(|point| point.1).chain([bound]), 16.0);
    let y = Axis::decades("wall time of a run, ms", all.iter().map(|point| point.2), 16.0);
    chart(&format!("{scene}: speed against error"), HEIGHT, &x, &y, |svg, on| {
        upright(svg, on, x.place(bound), SOFT);
        let at = |(_, error, wall_ms): &(&Row, f64, f64)| (x.place(*error), y.place(*wall_ms));
        let mut entries = Vec::new();
        for family in Family::ALL {
            let of = || all.iter().filter(move |point| point.0.rung.family == family);
            if of().next().is_none() {
                continue;
            }
            let (mark, colour) = style(family);
            line(svg, on, of().map(at), THIN, colour);
            points(svg, on, of().map(at), mark, colour);
            points(svg, on, of().filter(|point| point.0.rung.own).map(at), Mark::Ring, INK);
            entries.push(Entry::new(mark, colour, family.name()));
        }
        entries.push(Entry::new(Mark::Ring, INK, "the scene's settings"));
        entries.push(Entry::new(THIN, SOFT, "bound of the scene"));
        entries
    })
}

fn place(row: &Row) -> Option<(f64, f64)> {
    let Tried::Done { differences: Some(differences), cost } = &row.tried else { return None };
    let error = differences.path_max();
    (error.is_finite() && error > 0.0).then_some((error, cost.wall_s * 1e3))
}

fn style(family: Family) -> (Mark, Colour) {
    match family {
        Family::EngineAdaptive => (Mark::Circle, BLUE),
        Family::EngineFixed => (Mark::Square, GREEN),
        Family::Reduced => (Mark::Triangle, PURPLE),
        Family::Native => (Mark::Cross, AMBER),
        Family::Analytic => (Mark::Circle, ORANGE),
    }
}
