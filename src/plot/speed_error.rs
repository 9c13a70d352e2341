//! Wall time against error: one point per setting, one line per family of settings.

use super::axis::Axis;
use super::canvas::{LegendEntry, Marker, THIN_LINE, chart, line, points, vertical_line};
use super::theme::{AMBER, BLUE, Colour, GREEN, INK, ORANGE, PURPLE, SOFT};
use crate::validate::{Family, LadderRow, Validation};

const HEIGHT: f64 = 600.0;

/// Draws speed over error; settings without a finite error are omitted.
pub fn speed_error(scene: &str, found: &Validation) -> String {
    let last = &found.reference.outcome.last;
    let label = match (last.fingers.is_empty(), last.bodies.is_empty()) {
        (false, true) => "largest difference of a joint angle from the reference, rad",
        (false, false) => "largest difference of a joint angle from the reference, rad (of the object in 20 mm)",
        (true, _) => "largest distance of a disc from its position in the reference, m",
    };
    let bound = found.path_bound;
    let all: Vec<(&LadderRow, f64, f64)> =
        found.ladder.iter().filter_map(|row| error_and_time(row).map(|(x, y)| (row, x, y))).collect();
    let x = Axis::logarithmic(label, all.iter().map(|point| point.1).chain([bound]), 16.0);
    let y = Axis::logarithmic("wall time of a run, ms", all.iter().map(|point| point.2), 16.0);
    chart(&format!("{scene}: speed against error"), HEIGHT, &x, &y, |svg, frame| {
        vertical_line(svg, frame, x.coordinate(bound), SOFT);
        let point_of = |(_, error, wall_ms): &(&LadderRow, f64, f64)| (x.coordinate(*error), y.coordinate(*wall_ms));
        let mut entries = Vec::new();
        for family in Family::ALL {
            let family_points = || all.iter().filter(move |point| point.0.configuration.family == family);
            if family_points().next().is_none() {
                continue;
            }
            let (marker, colour) = style(family);
            line(svg, frame, family_points().map(point_of), THIN_LINE, colour);
            points(svg, frame, family_points().map(point_of), marker, colour);
            points(
                svg,
                frame,
                family_points().filter(|point| point.0.configuration.is_from_scene).map(point_of),
                Marker::Ring,
                INK,
            );
            entries.push(LegendEntry::new(marker, colour, family.name()));
        }
        entries.push(LegendEntry::new(Marker::Ring, INK, "the scene's settings"));
        entries.push(LegendEntry::new(THIN_LINE, SOFT, "bound of the scene"));
        entries
    })
}

fn error_and_time(row: &LadderRow) -> Option<(f64, f64)> {
    let (differences, wall_s) = row.differences.as_ref().zip(row.cost.wall_s)?;
    let error = differences.path_max();
    (error.is_finite() && error > 0.0).then_some((error, wall_s * 1e3))
}

fn style(family: Family) -> (Marker, Colour) {
    match family {
        Family::EngineAdaptive => (Marker::Circle, BLUE),
        Family::EngineFixed => (Marker::Square, GREEN),
        Family::Reduced => (Marker::Triangle, PURPLE),
        Family::Native => (Marker::Cross, AMBER),
        Family::Analytic => (Marker::Circle, ORANGE),
    }
}
