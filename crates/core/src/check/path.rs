//! A run sampled on an even grid.

use crate::criteria::{Rebound, Rebounds};
use crate::integrator::Reason;
use crate::invariants::EnergyAudit;
use crate::numeric::elementary::hypot;
use crate::numeric::plane::nearest_equivalent_angle;
use crate::trace::{BodyState, Channels, Energy, Event, RequiredData, Sample, Sink, SinkError};

/// Number of grid intervals. Errors can appear and vanish within a hundredth of a run.
pub const GRID_INTERVALS: f64 = 256.0;
/// Relative tolerance for equal end times of runs that end early.
const END_TIME_TOLERANCE: f64 = 1e-4;

/// Number of compared angles per finger.
pub const FINGER_ANGLES: usize = 3;

/// The compared quantities of a run.
#[derive(Clone, Debug, Default)]
pub struct Path {
    /// Coordinates at the grid points.
    pub points: Vec<Vec<f64>>,
    /// Energies at the grid points; empty if not recorded.
    pub energies: Vec<Energy>,
    /// Coordinates at the end.
    pub last: Vec<f64>,
    /// First touch-downs of the contacts.
    pub first_s: Vec<Option<f64>>,
    /// Normal forces at the end.
    pub normal_n: Vec<f64>,
    pub end_s: f64,
    pub failure: Option<Reason>,
    /// Whether the object left the gripper, which ended the run.
    pub ejected: bool,
    /// Energies at the end.
    pub energy: Energy,
    /// Rebounds of the pairs of discs; empty in scenes with fingers.
    pub rebounds: Vec<Rebound>,
    /// Largest speed of a body, m/s.
    pub speed_m_s: f64,
    /// Largest opening of a joint.
    pub loop_gap_m: f64,
    pub audit: Option<EnergyAudit>,
    /// Units of the coordinates, which differences are divided by.
    pub units: Vec<f64>,
    pub steps: u64,
    pub events: u64,
}

/// Records the grid points of a run and passes its samples and events on; the run stops when `keep_running` returns
/// false.
pub struct PathRecorder<'a> {
    pub interval_s: f64,
    /// Path with an audit if energies are recorded.
    pub path: Path,
    pub rebounds: Option<Rebounds>,
    pub sink: &'a mut dyn Sink,
    pub keep_running: &'a dyn Fn() -> bool,
}

/// Returns the compared coordinates: angles of fingers and centres of bodies. Passive angles can jump by a turn; each
/// angle is shifted by turns to the value nearest to the previous point's angle.
pub fn coordinates(sample: &Sample, previous: Option<&Vec<f64>>) -> Vec<f64> {
    let angles = sample
        .fingers
        .iter()
        .flat_map(|finger| -> [f64; FINGER_ANGLES] { [finger.q11_rad, finger.q21_rad, finger.q22_rad] });
    let unwrap = |(index, angle)| previous.map_or(angle, |previous| nearest_equivalent_angle(angle, previous[index]));
    let centres = sample.bodies.iter().flat_map(|body| body.centre_m);
    angles.enumerate().map(unwrap).chain(centres).collect()
}

impl Sink for PathRecorder<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let Path { points, energies, speed_m_s, audit, .. } = &mut self.path;
        let next = points.len() as f64 * self.interval_s;
        let is_on_grid = (sample.time_s - next).abs() <= 1e-9 * self.interval_s;
        if is_on_grid && points.len() <= GRID_INTERVALS as usize {
            points.push(coordinates(sample, points.last()));
            energies.extend(audit.map(|_| sample.energy));
        }
        let speeds = sample.bodies.iter().map(|BodyState { velocity_m_s: [x, y], .. }| hypot(*x, *y));
        *speed_m_s = speeds.fold(*speed_m_s, f64::max);
        audit.iter_mut().for_each(|audit| audit.record(sample.time_s, &sample.energy));
        self.rebounds.sample(sample)?;
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.rebounds.event(event)?;
        self.sink.event(event)
    }

    /// Requires passive angles because grid points contain them.
    fn required_data(&self) -> RequiredData {
        RequiredData { energies: self.path.audit.is_some(), passive: true, peaks: false }
    }

    fn should_continue(&self) -> bool {
        (self.keep_running)() && self.sink.should_continue()
    }
}

impl Path {
    /// Largest difference between two points, in the units of the coordinates.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let differences = a.iter().zip(b).zip(&self.units).map(|((x, y), unit)| (x - y).abs() / unit);
        let largest = differences.fold(0.0, |m: f64, d| if d.is_nan() { d } else { m.max(d) });
        if largest.is_nan() { f64::INFINITY } else { largest }
    }
}

/// Largest difference along the common part of two paths.
pub fn difference(a: &Path, b: &Path) -> f64 {
    a.points.iter().zip(&b.points).map(|(p, q)| a.distance(p, q)).fold(0.0, f64::max)
}

/// Whether both runs reach their end, or end early at about the same time.
pub fn have_same_end(a: &Path, b: &Path) -> bool {
    (a.failure.is_some(), a.ejected) == (b.failure.is_some(), b.ejected)
        && (a.end_s - b.end_s).abs() <= END_TIME_TOLERANCE * a.end_s.max(b.end_s)
}

/// Errors of a run relative to a reference.
pub fn errors(run: &Path, reference: &Path) -> Errors {
    let differences = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).collect::<Vec<f64>>();
    let both_end = run.failure.is_none() && reference.failure.is_none();
    let last = if both_end { differences(&run.last, &reference.last) } else { Vec::new() };
    let at_end = if both_end { run.distance(&run.last, &reference.last) } else { 0.0 };
    let first = run.first_s.iter().zip(&reference.first_s).map(|(a, b)| a.zip(*b).map(|(a, b)| (a - b).abs()));
    let restitution = run.rebounds.iter().zip(&reference.rebounds);
    Errors {
        path: difference(run, reference).max(at_end),
        last,
        first_s: first.collect(),
        normal_n: if both_end { differences(&run.normal_n, &reference.normal_n) } else { Vec::new() },
        restitution: restitution.clone().map(|(a, b)| restitution_error(a, b)).collect(),
        rebound: restitution.map(|(a, b)| rebound_error(a, b, run.speed_m_s)).fold(0.0, f64::max),
        energy: energy_error(run, reference),
    }
}

/// Error of a restitution; infinite if only one of the runs has it.
fn restitution_error(a: &Rebound, b: &Rebound) -> Option<f64> {
    match (a.restitution(), b.restitution()) {
        (Some(a), Some(b)) => Some((a - b).abs()),
        (None, None) => None,
        _ => Some(f64::INFINITY),
    }
}

/// Error of a restitution, weighted with the approach speed relative to the largest speed in the run. It is 0 if the
/// run has no restitution; a missing restitution of the reference counts as 0.
fn rebound_error(a: &Rebound, b: &Rebound, speed_m_s: f64) -> f64 {
    let approach_m_s = a.approach_m_s.into_iter().chain(b.approach_m_s).fold(0.0, f64::max);
    let error = a.restitution().map_or(0.0, |a| (a - b.restitution().unwrap_or_default()).abs());
    if error == 0.0 { 0.0 } else { error * (approach_m_s / speed_m_s).min(1.0) }
}

/// Largest difference of an energy or a work, as a fraction of the energy exchanged: at the end, and along the path if
/// the difference persists from one grid point to the next. Impacts are shorter than a grid interval, and a small shift
/// of an impact in time makes a large difference of kinetic energy within it.
fn energy_error(run: &Path, reference: &Path) -> f64 {
    let scale_j =
        [run, reference].into_iter().filter_map(|path| path.audit).map(|audit| audit.scale_j()).fold(0.0, f64::max);
    let difference = |(a, b): (&Energy, &Energy)| {
        let pairs = a.values().into_iter().zip(b.values());
        pairs
            .map(|(x, y)| (x - y).abs())
            .fold(0.0, |largest: f64, value| if value.is_nan() { f64::INFINITY } else { largest.max(value) })
    };
    let along: Vec<f64> = run.energies.iter().zip(&reference.energies).map(difference).collect();
    let persistent = along.windows(2).map(|pair| pair[0].min(pair[1])).fold(0.0, f64::max);
    let both_end = run.failure.is_none() && reference.failure.is_none();
    let at_end = if both_end { difference((&run.energy, &reference.energy)) } else { 0.0 };
    let error_j = persistent.max(at_end);
    if error_j == 0.0 { 0.0 } else { error_j / scale_j }
}

/// Estimated errors of the main results of a run; `None` if one or both runs do not have the quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Largest error of any coordinate along the path, rad (discs: m; a gripper's object: in its radii). Infinite
    /// without a comparison.
    pub path: f64,
    /// Errors of the coordinates at the end: q11, q21, q22 of every finger, then x and y of every body.
    pub last: Vec<f64>,
    /// Errors of the contacts' first touch-downs, s.
    pub first_s: Vec<Option<f64>>,
    /// Errors of their normal forces at the end, N.
    pub normal_n: Vec<f64>,
    /// Errors of the restitution of every pair of discs; infinite if only one of the runs has it.
    pub restitution: Vec<Option<f64>>,
    /// Largest error of a restitution, times the ratio (at most 1) of the pair's approach speed to the largest speed in
    /// the run.
    pub rebound: f64,
    /// Largest error of any energy or work, as a fraction of the energy exchanged in the run.
    pub energy: f64,
}
