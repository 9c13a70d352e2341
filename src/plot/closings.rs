//! Angles of closings over time, one style a closing (thesis Fig. 4.8).

use super::axis::Axis;
use super::canvas::{Entry, Mark, chart, line};
use super::curve::over_time;
use super::theme::{BLUE, Colour, GREEN, ORANGE};
use crate::study::reproduce::{Closing, ClosingPoint};

const HEIGHT: f64 = 460.0;

type Angle = (&'static str, Colour, fn(&ClosingPoint) -> f64);

/// The picture: the first closing with full lines, others pale.
pub fn closings(title: &str, closings: &[&Closing]) -> String {
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
    chart(title, HEIGHT, &x, &y, |svg, on| {
        let mut entries = Vec::new();
        for (place, closing) in closings.iter().enumerate() {
            let mark = if place == 0 { Mark::Line { width: 2.0 } } else { Mark::Pale { width: 3.0 } };
            for (name, colour, angle) in angles {
                let curve = closing.points.iter().map(|point| (point.time_s, angle(point)));
                line(svg, on, over_time(curve, &y), mark, colour);
                entries.push(Entry::new(mark, colour, &format!("{name}, {}", closing.name)));
            }
        }
        entries
    })
}
