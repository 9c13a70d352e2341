//! The difference of the joint angles over time, with the touch-downs.

use super::axis::Axis;
use super::canvas::{
    BLACK, BLUE, DrawError, Entry, GREEN, GREY, LEGEND, Mark, ORANGE, WIDTH, frame, legend, line, picture, titled,
};
use super::curve::thin;
use crate::trace::{EventKind, Sample, Site};
use crate::validate::{Angle, Validation};
use plotters::style::RGBColor;

const HEIGHT: u32 = 560;
/// Decades shown: what is smaller than the largest by more lies on the foot of the picture.
const DECADES: f64 = 8.0;
/// More touch-downs than this would hide the curves.
const MOST_TOUCHES: usize = 60;

/// The picture, of the run with the scene's own torque.
pub fn difference(scene: &str, found: &Validation) -> Result<String, DrawError> {
    let mut cursor = 0;
    let compared = found.engine.samples.iter().filter(|sample| sample.time_s <= found.bounds.until_s);
    let pairs: Vec<(Sample, Sample)> = compared
        .filter_map(|sample| found.reference.at(sample.time_s, &mut cursor).map(|expected| (*sample, expected)))
        .collect();
    let distance = |angle: Angle, (engine, analytic): &(Sample, Sample)| angle.difference(engine, analytic).abs();
    let all = pairs.iter().flat_map(|pair| Angle::ALL.map(|angle| distance(angle, pair)));
    let y = Axis::decades("|engine − analytic|, rad", all.chain([found.bounds.angle_rad]), DECADES);
    let x = Axis::linear("time, ms", [0.0, found.bounds.until_s * 1e3]);
    picture(HEIGHT, |area| {
        let rest = titled(area, &format!("{scene}: difference of the joint angles over time"))?;
        let (left, right) = rest.split_horizontally(WIDTH - LEGEND - 10);
        let mut chart = frame(&left, &x, &y, true)?;
        let mut entries = Vec::new();
        for (site, colour) in [(Site::Proximal, GREY), (Site::Distal, BLACK)] {
            let touches: Vec<f64> = found
                .reference
                .events
                .iter()
                .filter(|event| event.site == site && event.kind == EventKind::TouchDown)
                .map(|event| event.time_s)
                .filter(|&time_s| time_s <= found.bounds.until_s)
                .take(MOST_TOUCHES)
                .collect();
            for t in touches.iter().map(|time_s| time_s * 1e3) {
                line(&mut chart, vec![(t, y.from), (t, y.to)], Mark::Line { width: 1 }, colour)?;
            }
            if !touches.is_empty() {
                entries.push(Entry::new(Mark::Line { width: 1 }, colour, &format!("touch-down {}", site.name())));
            }
        }
        let at_bound = y.place(found.bounds.angle_rad);
        line(&mut chart, vec![(x.from, at_bound), (x.to, at_bound)], Mark::Pale { width: 4 }, BLACK)?;
        entries.push(Entry::new(Mark::Pale { width: 4 }, BLACK, "bound of the scene"));
        for (angle, colour) in Angle::ALL.into_iter().zip(COLOURS) {
            let points = pairs.iter().map(|pair| (pair.0.time_s * 1e3, y.place(distance(angle, pair))));
            line(&mut chart, thin(points.collect()), Mark::Line { width: 2 }, colour)?;
            entries.push(Entry::new(Mark::Line { width: 2 }, colour, angle.name()));
        }
        legend(&right, &entries)
    })
}

const COLOURS: [RGBColor; 3] = [BLUE, ORANGE, GREEN];
