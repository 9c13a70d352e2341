//! Limits of vibrations by frequency.

use std::f64::consts::TAU;

use crate::plot::axis::Axis;
use crate::plot::canvas::{LegendEntry, Marker, chart, line, point};
use crate::plot::theme::{SERIES, SOFT};
use crate::scene;
use crate::study::hold::{Hold, LoadCase};

const HEIGHT: f64 = 560.0;

/// Draws the largest displacement amplitude held over the frequency, with logarithmic axes.
pub fn frequency(found: &Hold) -> String {
    let curves: Vec<Curve> = AXES.into_iter().filter_map(|(axis, name)| Curve::new(found, axis, name)).collect();
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let x = Axis::logarithmic("frequency, Hz", points().map(|point| point.frequency_hz), 6.0);
    let y = Axis::logarithmic("amplitude at the object, mm", points().map(|point| point.amplitude_mm), 12.0);
    chart(&format!("{}: vibration held, by frequency", found.scene), HEIGHT, &x, &y, |svg, frame| {
        let mut entries = Vec::new();
        for (index, curve) in curves.iter().enumerate() {
            let colour = SERIES[index % SERIES.len()];
            let positions: Vec<_> = curve
                .points
                .iter()
                .map(|point| (x.coordinate(point.frequency_hz), y.coordinate(point.amplitude_mm)))
                .collect();
            let width = if curve.dropped { 1.0 } else { 3.0 };
            line(svg, frame, positions.clone(), Marker::Line { width }, colour);
            for (position, curve_point) in positions.into_iter().zip(&curve.points) {
                point(svg, frame, position, if curve_point.failed { Marker::Circle } else { Marker::Triangle }, colour);
                if !curve_point.monotone {
                    point(svg, frame, position, Marker::Ring, SOFT);
                }
            }
            let what = match curve.dropped {
                true => format!("{}: is not dropped", curve.name),
                false => format!("{}: slips < {} mm", curve.name, found.plan.slip_m * 1e3),
            };
            entries.push(LegendEntry::new(Marker::Line { width }, colour, &what));
        }
        if points().any(|point| !point.failed) {
            entries.push(LegendEntry::new(Marker::Triangle, SOFT, "at least"));
        }
        if points().any(|point| !point.monotone) {
            entries.push(LegendEntry::new(Marker::Ring, SOFT, "not monotone"));
        }
        entries
    })
}

/// Axes of vibration, whether the limit refers to dropping instead of slip, and names of the axes.
const AXES: [((scene::Axis, bool), &str); 6] = [
    ((scene::Axis::X, false), "x"),
    ((scene::Axis::X, true), "x"),
    ((scene::Axis::Y, false), "y"),
    ((scene::Axis::Y, true), "y"),
    ((scene::Axis::Angle, false), "angle"),
    ((scene::Axis::Angle, true), "angle"),
];

struct Curve {
    name: &'static str,
    dropped: bool,
    points: Vec<Point>,
}

struct Point {
    frequency_hz: f64,
    amplitude_mm: f64,
    failed: bool,
    monotone: bool,
}

impl Curve {
    /// Returns `None` if nothing is held along the axis, or if it was not studied.
    fn new(found: &Hold, (along, dropped): (scene::Axis, bool), name: &'static str) -> Option<Self> {
        let point = |load_result: &crate::study::hold::LoadResult| {
            let LoadCase::Vibration { axis, frequency_hz } = load_result.case else { return None };
            let limit = if dropped { load_result.drops } else { load_result.slips };
            let peak_m_s2 = limit.held.filter(|_| axis == along)?;
            let amplitude_mm = 1e3 * peak_m_s2 / (TAU * frequency_hz).powi(2);
            let (failed, monotone) = (limit.failed.is_some(), limit.held_above.is_none());
            Some(Point { frequency_hz, amplitude_mm, failed, monotone })
        };
        let points: Vec<Point> = found.results.iter().filter_map(point).collect();
        (!points.is_empty()).then_some(Curve { name, dropped, points })
    }
}
