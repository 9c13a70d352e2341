//! Angles of closings over time, one style a closing (thesis Fig. 4.8).

use plotters::style::RGBColor;

use super::axis::Axis;
use super::canvas::{BLUE, DrawError, Entry, GREEN, LEGEND, Mark, ORANGE, WIDTH, frame, legend, line, picture, titled};
use super::curve::over_time;
use crate::study::reproduce::{Closing, ClosingPoint};

const HEIGHT: u32 = 460;

type Angle = (&'static str, RGBColor, fn(&ClosingPoint) -> f64);

/// The picture: the first closing with full lines, others pale.
pub fn closings(title: &str, closings: &[&Closing]) -> Result<String, DrawError> {
    let angles: [Angle; 3] = [
        ("q11", BLUE, |point| point.q11_rad.to_degrees()),
        ("q21", ORANGE, |point| point.q21_rad.to_degrees()),
        ("q22", GREEN, |point| point.q22_rad.to_degrees()),
    ];
    let points = || closings.iter().flat_map(|closing| &closing.points);
    let end = points().map(|point| point.time_s * 1e3).fold(0.0, f64::max);
    let x = Axis::over("time, ms", 0.0, end.max(1e-9));
    let values = points().flat_map(|point| angles.iter().map(move |(.., angle)| angle(point)));
    let y = Axis::linear("angle, deg", values);
    picture(HEIGHT, |area| {
        let rest = titled(area, title)?;
        let (left, right) = rest.split_horizontally(WIDTH - LEGEND - 10);
        let mut chart = frame(&left, &x, &y, true)?;
        let mut entries = Vec::new();
        for (place, closing) in closings.iter().enumerate() {
            let mark = if place == 0 { Mark::Line { width: 2 } } else { Mark::Pale { width: 3 } };
            for (name, colour, angle) in angles {
                let curve = closing.points.iter().map(|point| (point.time_s, angle(point)));
                line(&mut chart, over_time(curve, &y), mark, colour)?;
                entries.push(Entry::new(mark, colour, &format!("{name}, {}", closing.name)));
            }
        }
        legend(&right, &entries)
    })
}
