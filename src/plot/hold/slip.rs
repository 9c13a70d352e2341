//! The slip of every run, over its load.

use crate::plot::axis::Axis;
use crate::plot::canvas::{
    COLOURS, DrawError, Entry, GREY, LEGEND, Mark, WIDTH, frame, legend, line, picture, point, titled,
};
use crate::scene;
use crate::study::hold::{Answer, Case, Hold, Tried};

const HEIGHT: u32 = 560;

/// The picture, both in logarithms.
pub fn slip(found: &Hold) -> Result<String, DrawError> {
    let all = || found.held.iter().flat_map(|held| &held.tried);
    let slip_mm = |tried: &Tried| tried.found.as_ref().ok().map(|found| found.slip.displacement_m * 1e3);
    let bound_mm = found.plan.slip_m * 1e3;
    let x = Axis::decades("peak acceleration, m/s²", all().map(|tried| tried.peak_m_s2), 8.0);
    let y = Axis::decades("slip in the hand, mm", all().filter_map(slip_mm).chain([bound_mm]), 8.0);
    picture(HEIGHT, |area| {
        let rest = titled(area, &format!("{}: how far its object slips", found.scene))?;
        let (left, right) = rest.split_horizontally(WIDTH - LEGEND - 30);
        let mut chart = frame(&left, &x, &y, true)?;
        let bound = y.place(bound_mm);
        line(&mut chart, vec![(x.from, bound), (x.to, bound)], Mark::Line { width: 1 }, GREY)?;
        let mut entries = Vec::new();
        for (index, held) in found.held.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let finished = held.tried.iter().filter_map(|tried| Some((tried, slip_mm(tried)?)));
            let places: Vec<_> =
                finished.map(|(tried, slip)| ((x.place(tried.peak_m_s2), y.place(slip)), tried.drops())).collect();
            line(&mut chart, places.iter().map(|(place, _)| *place).collect(), Mark::Line { width: 1 }, colour)?;
            for (place, drops) in places {
                point(&mut chart, place, if drops == Answer::Held { Mark::Circle } else { Mark::Cross }, colour)?;
            }
            entries.push(Entry::new(Mark::Circle, colour, &name(&held.case)));
        }
        entries.push(Entry::new(Mark::Cross, GREY, "not held at the end"));
        entries.push(Entry::new(Mark::Line { width: 1 }, GREY, "bound"));
        legend(&right, &entries)
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
