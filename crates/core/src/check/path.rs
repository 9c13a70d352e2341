//! A run kept as its path on an even grid.

use crate::integrator::Reason;
use crate::numeric::plane::near_turn;
use crate::trace::{Event, Layout, Sample, Sink, SinkError, Wants};

/// Points of the grid: errors come and go within a hundredth of a run.
pub const POINTS: f64 = 256.0;
/// Runs that end early do so alike if they do at times as near to each other, in parts of these.
const SAME_END: f64 = 1e-4;

/// Angles of a finger that are compared.
const ANGLES: usize = 3;
/// The length that counts as much as a radian: the radius of the usual object.
pub const LENGTH_M: f64 = 0.02;

/// What is kept of a run.
#[derive(Clone, Debug, Default)]
pub struct Path {
    pub points: Vec<Vec<f64>>,
    pub last: Vec<f64>,
    pub first_s: Vec<Option<f64>>,
    pub normal_n: Vec<f64>,
    pub end_s: f64,
    pub failure: Option<Reason>,
    /// What differences of each coordinate are divided by.
    pub units: Vec<f64>,
    pub steps: u64,
    pub events: u64,
}

/// Keeps the points of the grid, while `go_on` says so.
pub struct Keep<'a> {
    interval_s: f64,
    pub points: Vec<Vec<f64>>,
    go_on: &'a dyn Fn() -> bool,
}

impl<'a> Keep<'a> {
    pub fn new(duration_s: f64, go_on: &'a dyn Fn() -> bool) -> Self {
        Self { interval_s: duration_s / POINTS, points: Vec::new(), go_on }
    }

    /// Samples also come at short steps, between the points.
    fn take(&mut self, sample: &Sample) {
        let next = self.points.len() as f64 * self.interval_s;
        if (sample.time_s - next).abs() <= 1e-9 * self.interval_s {
            self.points.push(coordinates(sample, self.points.last()));
        }
    }
}

/// The coordinates that are compared: angles of fingers in the turns in which they follow on those before, for readings of
/// passive angles jump by one, and centres of bodies.
pub fn coordinates(sample: &Sample, before: Option<&Vec<f64>>) -> Vec<f64> {
    let angles =
        sample.fingers.iter().flat_map(|finger| -> [f64; ANGLES] { [finger.q11_rad, finger.q21_rad, finger.q22_rad] });
    let follow = |(index, angle)| before.map_or(angle, |before| near_turn(angle, before[index]));
    let centres = sample.bodies.iter().flat_map(|body| body.centre_m);
    angles.enumerate().map(follow).chain(centres).collect()
}

/// Somebody else who hears what is kept.
pub struct Heard<'a, 'b> {
    pub keep: &'a mut Keep<'b>,
    pub sink: &'a mut dyn Sink,
}

impl Sink for Heard<'_, '_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.keep.take(sample);
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.sink.event(event)
    }

    /// Coordinates of points, and how the run ends.
    fn wants(&self) -> Wants {
        Wants { energies: false, passive: true, peaks: false }
    }

    fn proceed(&self) -> bool {
        (self.keep.go_on)() && self.sink.proceed()
    }
}

/// What differences of the coordinates of a sample are divided by to be compared with each other: where angles of fingers and centres of
/// bodies stand side by side, centres count in lengths.
pub fn units(layout: &Layout) -> Vec<f64> {
    let unit = if layout.fingers.is_empty() { 1.0 } else { LENGTH_M };
    let angles = std::iter::repeat_n(1.0, ANGLES * layout.fingers.len());
    angles.chain(std::iter::repeat_n(unit, 2 * layout.bodies.len())).collect()
}

impl Path {
    /// Largest difference of one point from that of another run, in these units.
    fn apart(&self, a: &[f64], b: &[f64]) -> f64 {
        let differences = a.iter().zip(b).zip(&self.units).map(|((x, y), unit)| (x - y).abs() / unit);
        let largest = differences.fold(0.0, |m: f64, d| if d.is_nan() { d } else { m.max(d) });
        if largest.is_nan() { f64::INFINITY } else { largest }
    }
}

/// Largest difference along the path that both have.
pub fn difference(a: &Path, b: &Path) -> f64 {
    a.points.iter().zip(&b.points).map(|(p, q)| a.apart(p, q)).fold(0.0, f64::max)
}

/// Whether both reach their end, or break off at about the same time.
pub fn end_alike(a: &Path, b: &Path) -> bool {
    a.failure.is_some() == b.failure.is_some() && (a.end_s - b.end_s).abs() <= SAME_END * a.end_s.max(b.end_s)
}

/// What a run is off by, if another is right.
pub fn errors(run: &Path, right: &Path) -> Errors {
    let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).collect::<Vec<f64>>();
    let both_end = run.failure.is_none() && right.failure.is_none();
    let last = if both_end { off(&run.last, &right.last) } else { Vec::new() };
    let at_end = if both_end { run.apart(&run.last, &right.last) } else { 0.0 };
    let first = run.first_s.iter().zip(&right.first_s).map(|(a, b)| a.zip(*b).map(|(a, b)| (a - b).abs()));
    Errors {
        path: difference(run, right).max(at_end),
        last,
        first_s: first.collect(),
        normal_n: if both_end { off(&run.normal_n, &right.normal_n) } else { Vec::new() },
    }
}

/// Estimated errors of the main figures of a run. What only one of the runs has is `None`, as is what neither has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Largest of any coordinate along the path, rad (discs: m; of a gripper's object in lengths of 20 mm).
    pub path: f64,
    /// Of the coordinates at the end: q11, q21, q22 of every finger, then x and y of every body.
    pub last: Vec<f64>,
    /// Of the first touch-downs of the contacts, s.
    pub first_s: Vec<Option<f64>>,
    /// Of their normal forces at the end, N.
    pub normal_n: Vec<f64>,
}
