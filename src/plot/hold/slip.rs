//! The slip of every run over its load.

use crate::plot::axis::Axis;
use crate::plot::canvas::{LegendEntry, Marker, THIN_LINE, chart, horizontal_line, line, point};
use crate::plot::theme::{SERIES, SOFT};
use crate::scene;
use crate::study::hold::{Evaluation, Hold, LoadCase, Verdict};

const HEIGHT: f64 = 560.0;

/// Draws the slip over the load, with logarithmic axes.
pub fn slip(found: &Hold) -> String {
    let all = || found.results.iter().flat_map(|load_result| &load_result.evaluations);
    let slip_mm =
        |evaluation: &Evaluation| evaluation.outcome.as_ref().ok().map(|outcome| outcome.slip.displacement_m * 1e3);
    let bound_mm = found.plan.slip_m * 1e3;
    let x = Axis::logarithmic("peak acceleration, m/s²", all().map(|evaluation| evaluation.peak_m_s2), 8.0);
    let y = Axis::logarithmic("slip in the hand, mm", all().filter_map(slip_mm).chain([bound_mm]), 8.0);
    chart(&format!("{}: slip of the object", found.scene), HEIGHT, &x, &y, |svg, frame| {
        horizontal_line(svg, frame, y.coordinate(bound_mm), THIN_LINE, SOFT);
        let mut entries = Vec::new();
        for (index, load_result) in found.results.iter().enumerate() {
            let colour = SERIES[index % SERIES.len()];
            let finished =
                load_result.evaluations.iter().filter_map(|evaluation| Some((evaluation, slip_mm(evaluation)?)));
            let positions: Vec<_> = finished
                .map(|(evaluation, slip)| {
                    ((x.coordinate(evaluation.peak_m_s2), y.coordinate(slip)), evaluation.drops())
                })
                .collect();
            line(svg, frame, positions.iter().map(|(position, _)| *position), THIN_LINE, colour);
            for (position, drops) in positions {
                point(
                    svg,
                    frame,
                    position,
                    if drops == Verdict::Held { Marker::Circle } else { Marker::Cross },
                    colour,
                );
            }
            entries.push(LegendEntry::new(Marker::Circle, colour, &name(&load_result.case)));
        }
        entries.push(LegendEntry::new(Marker::Cross, SOFT, "not held at the end"));
        entries.push(LegendEntry::new(THIN_LINE, SOFT, "bound"));
        entries
    })
}

fn name(case: &LoadCase) -> String {
    match case {
        LoadCase::Pulse { direction_rad, .. } => format!("pulse to {:.0}°", direction_rad.to_degrees()),
        LoadCase::Vibration { axis, frequency_hz } => {
            let axis = match axis {
                scene::Axis::X => "x",
                scene::Axis::Y => "y",
                scene::Axis::Angle => "angle",
            };
            format!("{axis}, {frequency_hz} Hz")
        }
        LoadCase::Move => "move".to_string(),
    }
}
