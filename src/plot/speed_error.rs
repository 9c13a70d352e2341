//! Wall time against error: one point per setting, one line per family of settings.

use super::axis::Axis;
use super::canvas::{Marker, PlotPoint, THIN_LINE};
use super::series::{Series, series_chart};
use super::theme::{AMBER, BLUE, Colour, GREEN, INK, ORANGE, PURPLE, SOFT};
use crate::validate::{Family, LadderRow, Validation};

const HEIGHT: f64 = 600.0;

/// Draws speed over error; settings without a finite error are omitted.
pub fn speed_error(scene: &str, found: &Validation) -> String {
    let last = &found.reference.outcome.last;
    let label = match (last.counts().fingers == 0, last.counts().bodies == 0) {
        (false, true) => "largest difference of a joint angle from the reference, rad",
        (false, false) => "largest difference of a joint angle from the reference, rad (of the object in 20 mm)",
        (true, _) => "largest distance of a disc from its position in the reference, m",
    };
    let bound = found.path_bound;
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
        let (marker, colour) = style(family);
        series.push(points(THIN_LINE, colour, |_| true));
        let named = points(marker, colour, |_| true).named(family.name());
        series.extend(Some(named).filter(|named| !named.points.is_empty()));
        series.push(points(Marker::Ring, INK, |row| row.configuration.is_from_scene));
    }
    series.push(Series::key(Marker::Ring, INK, "the scene's settings"));
    series.push(Series::key(THIN_LINE, SOFT, "bound of the scene"));
    series_chart(&format!("{scene}: speed against error"), HEIGHT, &x, &y, &series)
}

/// Error and wall time in ms of a setting with a finite error.
fn error_and_time(row: &LadderRow) -> Option<PlotPoint> {
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
