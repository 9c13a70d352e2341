//! Limits of vibrations, by their frequencies.

use std::f64::consts::TAU;

use crate::plot::axis::Axis;
use crate::plot::canvas::{Entry, Mark, chart, line, point};
use crate::plot::theme::{SERIES, SOFT};
use crate::scene;
use crate::study::hold::{Case, Hold};

const HEIGHT: f64 = 560.0;

/// The picture: the amplitude of the object's way that is held, over the frequency, both in logarithms.
pub fn frequency(found: &Hold) -> String {
    let curves: Vec<Curve> = AXES.into_iter().filter_map(|(axis, name)| Curve::new(found, axis, name)).collect();
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let x = Axis::decades("frequency, Hz", points().map(|point| point.frequency_hz), 6.0);
    let y = Axis::decades("amplitude at the object, mm", points().map(|point| point.amplitude_mm), 12.0);
    chart(&format!("{}: the vibration it holds", found.scene), HEIGHT, &x, &y, |svg, on| {
        let mut entries = Vec::new();
        for (index, curve) in curves.iter().enumerate() {
            let colour = SERIES[index % SERIES.len()];
            let places: Vec<_> =
                curve.points.iter().map(|point| (x.place(point.frequency_hz), y.place(point.amplitude_mm))).collect();
            let width = if curve.dropped { 1.0 } else { 3.0 };
            line(svg, on, places.clone(), Mark::Line { width }, colour);
            for (place, of) in places.into_iter().zip(&curve.points) {
                point(svg, on, place, if of.failed { Mark::Circle } else { Mark::Triangle }, colour);
                if !of.monotone {
                    point(svg, on, place, Mark::Ring, SOFT);
                }
            }
            let what = match curve.dropped {
                true => format!("{}: is not dropped", curve.name),
                false => format!("{}: slips < {} mm", curve.name, found.plan.slip_m * 1e3),
            };
            entries.push(Entry::new(Mark::Line { width }, colour, &what));
        }
        if points().any(|point| !point.failed) {
            entries.push(Entry::new(Mark::Triangle, SOFT, "at least"));
        }
        if points().any(|point| !point.monotone) {
            entries.push(Entry::new(Mark::Ring, SOFT, "not monotone"));
        }
        entries
    })
}

/// Axes, each with what a vibration along it is called, and whether it is about slip or about loss.
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
    /// `None` where nothing is held along the axis, or was not asked.
    fn new(found: &Hold, (along, dropped): (scene::Axis, bool), name: &'static str) -> Option<Self> {
        let point = |held: &crate::study::hold::Held| {
            let Case::Vibration { axis, frequency_hz } = held.case else { return None };
            let limit = if dropped { held.drops } else { held.slips };
            let peak_m_s2 = limit.held.filter(|_| axis == along)?;
            let amplitude_mm = 1e3 * peak_m_s2 / (TAU * frequency_hz).powi(2);
            let (failed, monotone) = (limit.failed.is_some(), limit.held_above.is_none());
            Some(Point { frequency_hz, amplitude_mm, failed, monotone })
        };
        let points: Vec<Point> = found.held.iter().filter_map(point).collect();
        (!points.is_empty()).then_some(Curve { name, dropped, points })
    }
}
