//! Wall time against error: one point a setting, one line a family of settings.

use super::axis::Axis;
use super::canvas::{
    AMBER, BLACK, BLUE, DrawError, Entry, GREEN, GREY, LEGEND, Mark, ORANGE, PURPLE, WIDTH, frame, legend, line,
    picture, point, titled,
};
use crate::validate::{Family, Row, Tried, Validation};
use plotters::style::RGBColor;

const HEIGHT: u32 = 600;

/// The picture; settings without a finite error are not in it.
pub fn speed_error(scene: &str, found: &Validation) -> Result<String, DrawError> {
    let last = &found.reference.outcome.last;
    let label = match (last.fingers.is_empty(), last.bodies.is_empty()) {
        (false, true) => "largest difference of a joint angle from the reference, rad",
        (false, false) => "largest difference of a joint angle from the reference, rad (of the object in 20 mm)",
        (true, _) => "largest distance of a disc from its place in the reference, m",
    };
    let bound = found.path_bound;
    let points: Vec<(&Row, f64, f64)> =
        found.rows.iter().filter_map(|row| place(row).map(|(x, y)| (row, x, y))).collect();
    let x = Axis::decades(label, points.iter().map(|point| point.1).chain([bound]), 16.0);
    let y = Axis::decades("wall time of a run, ms", points.iter().map(|point| point.2), 16.0);
    picture(HEIGHT, |area| {
        let rest = titled(area, &format!("{scene}: speed against error"))?;
        let (left, right) = rest.split_horizontally(WIDTH - LEGEND - 40);
        let mut chart = frame(&left, &x, &y, true)?;
        let at_bound = x.place(bound);
        line(&mut chart, vec![(at_bound, y.from), (at_bound, y.to)], Mark::Line { width: 1 }, GREY)?;
        let mut entries = Vec::new();
        for family in Family::ALL {
            let of: Vec<&(&Row, f64, f64)> = points.iter().filter(|point| point.0.rung.family == family).collect();
            if of.is_empty() {
                continue;
            }
            let (mark, colour) = style(family);
            let places: Vec<(f64, f64)> = of.iter().map(|point| (x.place(point.1), y.place(point.2))).collect();
            line(&mut chart, places.clone(), Mark::Line { width: 1 }, colour)?;
            for (&at, point_of) in places.iter().zip(&of) {
                point(&mut chart, at, mark, colour)?;
                if point_of.0.rung.own {
                    point(&mut chart, at, Mark::Ring, BLACK)?;
                }
            }
            entries.push(Entry::new(mark, colour, family.name()));
        }
        entries.push(Entry::new(Mark::Ring, BLACK, "the scene's settings"));
        entries.push(Entry::new(Mark::Line { width: 1 }, GREY, "bound of the scene"));
        legend(&right, &entries)
    })
}

fn place(row: &Row) -> Option<(f64, f64)> {
    let Tried::Done { differences: Some(differences), cost } = &row.tried else { return None };
    let error = differences.path_max();
    (error.is_finite() && error > 0.0).then_some((error, cost.wall_s * 1e3))
}

fn style(family: Family) -> (Mark, RGBColor) {
    match family {
        Family::EngineAdaptive => (Mark::Circle, BLUE),
        Family::EngineFixed => (Mark::Square, GREEN),
        Family::Reduced => (Mark::Triangle, PURPLE),
        Family::Native => (Mark::Cross, AMBER),
        Family::Analytic => (Mark::Circle, ORANGE),
    }
}
