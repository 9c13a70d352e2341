//! Joint angles over time in several closing motions, with one line style per motion (thesis Fig. 4.8).

use super::axis::Axis;
use super::canvas::{LegendEntry, Marker, chart, line};
use super::curve::time_series;
use super::theme::{BLUE, Colour, GREEN, ORANGE};
use crate::study::reproduce::{Closing, ClosingPoint};

const HEIGHT: f64 = 460.0;

type Angle = (&'static str, Colour, fn(&ClosingPoint) -> f64);

/// Draws the joint angles: the first closing motion with solid lines, others with faint lines.
pub fn closings(title: &str, closings: &[&Closing]) -> String {
    let angles: [Angle; 3] = [
        ("q11", BLUE, |point| point.q11_rad.to_degrees()),
        ("q21", ORANGE, |point| point.q21_rad.to_degrees()),
        ("q22", GREEN, |point| point.q22_rad.to_degrees()),
    ];
    let points = || closings.iter().flat_map(|closing| &closing.points);
    let end = points().map(|point| point.time_s * 1e3).fold(0.0, f64::max);
    let x = Axis::from_range("time, ms", 0.0, end.max(1e-9));
    let values = points().flat_map(|point| angles.iter().map(move |(.., angle)| angle(point)));
    let y = Axis::linear("angle, deg", values);
    chart(title, HEIGHT, &x, &y, |svg, frame| {
        let mut entries = Vec::new();
        for (index, closing) in closings.iter().enumerate() {
            let marker = if index == 0 { Marker::Line { width: 2.0 } } else { Marker::FaintLine { width: 3.0 } };
            for (name, colour, angle) in angles {
                let curve = closing.points.iter().map(|point| (point.time_s, angle(point)));
                line(svg, frame, time_series(curve, &y), marker, colour);
                entries.push(LegendEntry::new(marker, colour, &format!("{name}, {}", closing.name)));
            }
        }
        entries
    })
}
