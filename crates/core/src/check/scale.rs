//! Length scales of a scene and of its motion, which errors are measured by.

use super::path::Path;
use crate::scene::System;
use crate::shape::max_radius;
use crate::trace::Model;

/// A run is chaotic if the perturbation changes its path by more than this, in the unit of
/// [`ErrorLimits::path`], or by a tenth of the largest displacement.
pub const CHAOS_THRESHOLD: f64 = 1e-3;
/// A path error is too large if it exceeds this fraction of the largest displacement.
pub const MOTION_FRACTION: f64 = 1e-2;
/// The effect of the perturbation is too large if it exceeds this fraction of the largest displacement.
const CHAOS_MOTION_FRACTION: f64 = 0.1;
/// Length that corresponds to a radian in scenes without fingers, in radii of the smallest moving disc.
const DISC_LENGTH_RADII: f64 = 20.0;
/// Displacements below this fraction of a radian, or of the corresponding length, are rounding errors and count as
/// rest.
const REST_FRACTION: f64 = 1e-10;

/// Largest errors of a run with the verdict "sure".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorLimits {
    /// Estimated path error: in rad for joint angles, in radii for a gripper's object, and in 20 radii of the smallest
    /// moving disc in scenes of discs. The limit is at most [`MOTION_FRACTION`] of the largest displacement.
    pub path: f64,
    /// Energy error, as a fraction of the energy exchanged in the run. In 560 random scenes of fingers, grippers and
    /// discs, the largest error of an accurate path was 3e-4; in the engine it was 6e-3, apart from one of 1.3e-2.
    pub energy: f64,
    /// Restitution error of discs that collide at the largest speed of a run.
    pub restitution: f64,
}

/// Limits of the analytic model.
pub const ANALYTIC_LIMITS: ErrorLimits = ErrorLimits { path: 1e-5, energy: 1e-3, restitution: 1e-3 };
/// Limits of the engine.
pub const ENGINE_LIMITS: ErrorLimits = ErrorLimits { path: 1e-4, energy: 1e-2, restitution: 1e-2 };
/// Number of events above which an error estimate of the analytic model depends on rounding errors. Among 9,542 random
/// scenes, four runs had errors beyond the limit (1.1e-5 to 2.6e-5 rad) but the verdict "sure"; they had 2,769 to 7,436
/// events and estimates of 1.9e-6 to 9.7e-6.
const MANY_EVENTS: u64 = 1000;
/// Limit of the path error of analytic runs with more than [`MANY_EVENTS`] events.
const MAX_PATH_ERROR_MANY_EVENTS: f64 = 1e-6;

/// Limits of a run of a model with this number of events.
pub(crate) fn error_limits(model: Model, events: u64) -> ErrorLimits {
    match model {
        Model::Engine => ENGINE_LIMITS,
        Model::Analytic if events > MANY_EVENTS => ErrorLimits { path: MAX_PATH_ERROR_MANY_EVENTS, ..ANALYTIC_LIMITS },
        Model::Analytic => ANALYTIC_LIMITS,
    }
}

/// Length that corresponds to a radian in scenes with fingers: the reach of the object, m.
pub fn reference_length_m(system: &System) -> f64 {
    system.object().map_or(1.0, |object| max_radius(&object.shape))
}

/// The path error above which a run is uncertain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ErrorLimit {
    /// Limit in the unit of errors: rad, or m in scenes without fingers.
    pub error: f64,
    /// Effect of the perturbation above which the run is chaotic.
    pub chaos_threshold: f64,
    /// Length scale of the limit, in words.
    pub basis: String,
    /// Largest displacement, if the limit is a fraction of it.
    pub largest_displacement: Option<f64>,
}

/// Returns the error limit of a run; `ordinary_limit` is the limit for a motion of a radian.
pub(crate) fn path_error_limit(system: &System, run: &Path, ordinary_limit: f64) -> ErrorLimit {
    let is_discs = system.fingers.is_empty();
    let size = if is_discs { DISC_LENGTH_RADII * smallest_reach(system) } else { 1.0 };
    let largest_displacement = largest_displacement(run).max(REST_FRACTION * size);
    let (ordinary, small_motion) = (ordinary_limit * size, MOTION_FRACTION * largest_displacement);
    let chaos_threshold = (CHAOS_THRESHOLD * size).min(CHAOS_MOTION_FRACTION * largest_displacement);
    if small_motion < ordinary {
        let unit = if is_discs { "m" } else { "rad" };
        let basis = format!("{MOTION_FRACTION} of the largest displacement, {largest_displacement:.1e} {unit}");
        return ErrorLimit {
            error: small_motion,
            chaos_threshold,
            basis,
            largest_displacement: Some(largest_displacement),
        };
    }
    let basis = match (is_discs, system.reported_discs().is_empty()) {
        (true, _) => format!("{:e} of the radius of the smallest disc that moves", DISC_LENGTH_RADII * ordinary_limit),
        (false, true) => format!("{ordinary_limit:e} of a radian"),
        (false, false) => format!("{ordinary_limit:e} of a radian and of the object's radius"),
    };
    ErrorLimit { error: ordinary, chaos_threshold, basis, largest_displacement: None }
}

/// Reach of the smallest moving body, m; of the smallest body if none moves.
fn smallest_reach(system: &System) -> f64 {
    let smallest = |moving: bool| {
        let discs = system.discs.iter().filter(|disc| !moving || disc.motion.moves());
        discs.map(|disc| max_radius(&disc.shape)).min_by(f64::total_cmp)
    };
    smallest(true).or(smallest(false)).unwrap_or(1.0 / DISC_LENGTH_RADII)
}

/// Largest distance of a coordinate from its start along a path, in its unit.
fn largest_displacement(path: &Path) -> f64 {
    let Some(first) = path.points.first() else { return 0.0 };
    path.points.iter().map(|point| path.distance(first, point)).fold(0.0, f64::max)
}
