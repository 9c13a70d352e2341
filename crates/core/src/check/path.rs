//! A run kept as its path on an even grid.

use crate::criteria::{Rebound, Rebounds};
use crate::integrator::Reason;
use crate::invariants::EnergyAudit;
use crate::numeric::elementary::hypot;
use crate::numeric::plane::near_turn;
use crate::trace::{BodyState, Energy, Event, Sample, Sink, SinkError, Wants};

/// Points of the grid: errors come and go within a hundredth of a run.
pub const POINTS: f64 = 256.0;
/// Runs that end early do so alike if they do at times as near to each other, in parts of these.
const SAME_END: f64 = 1e-4;

/// Angles of a finger that are compared.
pub const ANGLES: usize = 3;

/// What is kept of a run.
#[derive(Clone, Debug, Default)]
pub struct Path {
    pub points: Vec<Vec<f64>>,
    /// Energies at the points, where they were recorded.
    pub energies: Vec<Energy>,
    pub last: Vec<f64>,
    pub first_s: Vec<Option<f64>>,
    pub normal_n: Vec<f64>,
    pub end_s: f64,
    pub failure: Option<Reason>,
    /// Whether the object left the gripper, which ended the run.
    pub ejected: bool,
    /// Energies at the end.
    pub energy: Energy,
    /// Of the pairs of discs; empty with a finger.
    pub rebounds: Vec<Rebound>,
    /// Largest speed of a body, m/s.
    pub speed_m_s: f64,
    /// Largest opening of a joint.
    pub loop_gap_m: f64,
    pub audit: Option<EnergyAudit>,
    /// What differences of each coordinate are divided by.
    pub units: Vec<f64>,
    pub steps: u64,
    pub events: u64,
}

/// Keeps the points of the grid, while `go_on` says so.
pub struct Keep<'a> {
    interval_s: f64,
    pub points: Vec<Vec<f64>>,
    pub energies: Vec<Energy>,
    pub rebounds: Option<Rebounds>,
    pub audit: Option<EnergyAudit>,
    pub speed_m_s: f64,
    go_on: &'a dyn Fn() -> bool,
}

impl<'a> Keep<'a> {
    /// Points over a length of time; `pairs` of discs whose rebounds are recorded, and an audit of the energies, if any.
    pub fn new(
        span_s: f64,
        rebounds: Option<Rebounds>,
        audit: Option<EnergyAudit>,
        go_on: &'a dyn Fn() -> bool,
    ) -> Self {
        Self {
            interval_s: span_s / POINTS,
            points: Vec::new(),
            energies: Vec::new(),
            rebounds,
            audit,
            speed_m_s: 0.0,
            go_on,
        }
    }

    /// Samples also come at short steps, between the points.
    fn take(&mut self, sample: &Sample) {
        let next = self.points.len() as f64 * self.interval_s;
        let is_on_grid = (sample.time_s - next).abs() <= 1e-9 * self.interval_s;
        if is_on_grid && self.points.len() <= POINTS as usize {
            self.points.push(coordinates(sample, self.points.last()));
            if self.audit.is_some() {
                self.energies.push(sample.energy);
            }
        }
        let speeds = sample.bodies.iter().map(|BodyState { velocity_m_s: [x, y], .. }| hypot(*x, *y));
        self.speed_m_s = speeds.fold(self.speed_m_s, f64::max);
        if let Some(audit) = &mut self.audit {
            audit.enter(sample.time_s, &sample.energy);
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
        self.keep.rebounds.sample(sample)?;
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.keep.rebounds.event(event)?;
        self.sink.event(event)
    }

    /// Coordinates of points, and how the run ends.
    fn wants(&self) -> Wants {
        Wants { energies: self.keep.audit.is_some(), passive: true, peaks: false }
    }

    fn proceed(&self) -> bool {
        (self.keep.go_on)() && self.sink.proceed()
    }
}

impl Path {
    /// Largest difference of one point from that of another run, in these units.
    pub fn apart(&self, a: &[f64], b: &[f64]) -> f64 {
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
    (a.failure.is_some(), a.ejected) == (b.failure.is_some(), b.ejected)
        && (a.end_s - b.end_s).abs() <= SAME_END * a.end_s.max(b.end_s)
}

/// What a run is off by, if another is right.
pub fn errors(run: &Path, right: &Path) -> Errors {
    let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).collect::<Vec<f64>>();
    let both_end = run.failure.is_none() && right.failure.is_none();
    let last = if both_end { off(&run.last, &right.last) } else { Vec::new() };
    let at_end = if both_end { run.apart(&run.last, &right.last) } else { 0.0 };
    let first = run.first_s.iter().zip(&right.first_s).map(|(a, b)| a.zip(*b).map(|(a, b)| (a - b).abs()));
    let restitution = run.rebounds.iter().zip(&right.rebounds);
    Errors {
        path: difference(run, right).max(at_end),
        last,
        first_s: first.collect(),
        normal_n: if both_end { off(&run.normal_n, &right.normal_n) } else { Vec::new() },
        restitution: restitution.clone().map(|(a, b)| restitution_error(a, b)).collect(),
        rebound: restitution.map(|(a, b)| rebound_error(a, b, run.speed_m_s)).fold(0.0, f64::max),
        energy: energy_error(run, right),
    }
}

/// Error of a restitution; infinite where only one of the runs has it.
fn restitution_error(a: &Rebound, b: &Rebound) -> Option<f64> {
    match (a.restitution(), b.restitution()) {
        (Some(a), Some(b)) => Some((a - b).abs()),
        (None, None) => None,
        _ => Some(f64::INFINITY),
    }
}

/// Error of the restitution that a run shows, as far as the pair meets at a speed that matters beside the largest one of the run. Where the
/// other run has none it counts as 0.
fn rebound_error(a: &Rebound, b: &Rebound, speed_m_s: f64) -> f64 {
    let approach_m_s = a.approach_m_s.into_iter().chain(b.approach_m_s).fold(0.0, f64::max);
    let error = a.restitution().map_or(0.0, |a| (a - b.restitution().unwrap_or_default()).abs());
    if error == 0.0 { 0.0 } else { error * (approach_m_s / speed_m_s).min(1.0) }
}

/// Largest difference of an energy or a work, as a part of the energy exchanged: at the end, and along the path where it lasts from one
/// point to the next. Impacts are shorter than that, and a small shift of one in time makes a large difference of kinetic energy within it.
fn energy_error(run: &Path, right: &Path) -> f64 {
    let scale_j =
        [run, right].into_iter().filter_map(|path| path.audit).map(|audit| audit.scale_j()).fold(0.0, f64::max);
    let off = |(a, b): (&Energy, &Energy)| {
        let pairs = a.values_j().into_iter().zip(b.values_j());
        pairs
            .map(|(x, y)| (x - y).abs())
            .fold(0.0, |most: f64, off| if off.is_nan() { f64::INFINITY } else { most.max(off) })
    };
    let along: Vec<f64> = run.energies.iter().zip(&right.energies).map(off).collect();
    let lasting = along.windows(2).map(|pair| pair[0].min(pair[1])).fold(0.0, f64::max);
    let both_end = run.failure.is_none() && right.failure.is_none();
    let at_end = if both_end { off((&run.energy, &right.energy)) } else { 0.0 };
    let off_j = lasting.max(at_end);
    if off_j == 0.0 { 0.0 } else { off_j / scale_j }
}

/// Estimated errors of the main figures of a run. What only one of the runs has is `None`, as is what neither has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Largest of any coordinate along the path, rad (discs: m; of a gripper's object in its radii). Infinite if nothing was compared.
    pub path: f64,
    /// Of the coordinates at the end: q11, q21, q22 of every finger, then x and y of every body.
    pub last: Vec<f64>,
    /// Of the first touch-downs of the contacts, s.
    pub first_s: Vec<Option<f64>>,
    /// Of their normal forces at the end, N.
    pub normal_n: Vec<f64>,
    /// Of the restitution of every pair of discs; infinite where only one of the runs has it.
    pub restitution: Vec<Option<f64>>,
    /// Largest of a restitution, times the speed at which the pair meets as a part of the largest speed in the run, at most 1.
    pub rebound: f64,
    /// Largest of any energy or work, as a part of the energy exchanged in the run.
    pub energy: f64,
}
