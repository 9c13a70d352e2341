//! The slip of every run, over its load.

use crate::plot::axis::Axis;
use crate::plot::canvas::{Entry, Mark, THIN, chart, level, line, point};
use crate::plot::theme::{SERIES, SOFT};
use crate::scene;
use crate::study::hold::{Answer, Case, Hold, Tried};

const HEIGHT: f64 = 560.0;

/// The picture, both in logarithms.
pub fn slip(found: &Hold) -> String {
    let all = || found.held.iter().flat_map(|held| &held.tried);
    let slip_mm = |tried: &Tried| tried.found.as_ref().ok().map(|found| found.slip.displacement_m * 1e3);
    let bound_mm = found.plan.slip_m * 1e3;
    let x = Axis::decades("peak acceleration, m/s²", all().map(|tried| tried.peak_m_s2), 8.0);
    let y = Axis::decades("slip in the hand, mm", all().filter_map(slip_mm).chain([bound_mm]), 8.0);
    chart(&format!("{}: how far its object slips", found.scene), HEIGHT, &x, &y, |svg, on| {
        level(svg, on, y.place(bound_mm), THIN, SOFT);
        let mut entries = Vec::new();
        for (index, held) in found.held.iter().enumerate() {
            let colour = SERIES[index % SERIES.len()];
            let finished = held.tried.iter().filter_map(|tried| Some((tried, slip_mm(tried)?)));
            let places: Vec<_> =
                finished.map(|(tried, slip)| ((x.place(tried.peak_m_s2), y.place(slip)), tried.drops())).collect();
            line(svg, on, places.iter().map(|(place, _)| *place), THIN, colour);
            for (place, drops) in places {
                point(svg, on, place, if drops == Answer::Held { Mark::Circle } else { Mark::Cross }, colour);
            }
            entries.push(Entry::new(Mark::Circle, colour, &name(&held.case)));
        }
        entries.push(Entry::new(Mark::Cross, SOFT, "not held at the end"));
        entries.push(Entry::new(THIN, SOFT, "bound"));
        entries
    })
}

fn name(case: &Case) -> String {
    match case {
        Case::Pulse { direction_rad, .. } => format!("pulse to {:.0}°", direction_rad.to_degrees()),
        Case::Vibration { axis, frequency_hz } => {
            let axis = match axis {
                scene::Axis::X => "x",
                scene::Axis::Y => "y",
                scene::Axis::Angle => "angle",
            };
            format!("{axis}, {frequency_hz} Hz")
        }
        Case::Move => "move".to_string(),
    }
}
