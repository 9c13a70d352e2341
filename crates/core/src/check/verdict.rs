//! The verdict on a run, from the runs that it is compared with.

use super::path;
use super::path::{Errors, Path};
use crate::integrator::Reason;
use crate::mechanism::{Body, Mechanism};
use crate::scene::{Hand, Scene};
use crate::shape::max_radius;
use crate::trace::Model;

/// Verdict on the accuracy of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Two independent resolutions agree.
    Accurate,
    /// The resolutions disagree, the energy does not balance, or a joint opens: the outcome depends on the tolerance.
    /// Also if a contact is so deep that the direction of its force jumps.
    Uncertain,
    /// The outcome depends on the last digits of the input.
    Chaotic,
    /// No runs were compared.
    Unknown,
}

impl Verdict {
    /// Name in results, logs and reports.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Accurate => "sure",
            Verdict::Uncertain => "uncertain",
            Verdict::Chaotic => "chaotic",
            Verdict::Unknown => "unknown",
        }
    }
}

/// A completed run, its reference run, the perturbed reference run, and the differences between them.
pub struct Comparison<'a> {
    pub run: &'a Path,
    pub reference_run: &'a Path,
    pub perturbed_run: &'a Path,
    pub errors: &'a Errors,
    pub sensitivity: f64,
    /// Effect of the perturbation above which the run is chaotic.
    pub chaos_threshold: f64,
    /// Errors above which the run is uncertain.
    pub limits: ErrorLimits,
    /// Opening of a joint above which the run is uncertain, m.
    pub max_loop_gap_m: f64,
    /// Whether the two runs use the same model and method, so that only their steps can differ.
    pub same_method: bool,
}

/// Returns the verdict, and the reason if the path error alone does not explain it.
pub fn verdict(comparison: &Comparison<'_>) -> (Verdict, Option<String>) {
    let Comparison { run, reference_run, perturbed_run, .. } = comparison;
    let defects_found = defects(comparison);
    let with_defects = |reason: String| Some([vec![reason], defects_found.clone()].concat().join("; "));
    if let Some(reason) = nothing_compared(comparison) {
        return if defects_found.is_empty() {
            (Verdict::Unknown, Some(reason))
        } else {
            (Verdict::Uncertain, with_defects(reason))
        };
    }
    if comparison.sensitivity > comparison.chaos_threshold || !path::have_same_end(reference_run, perturbed_run) {
        return (Verdict::Chaotic, (!defects_found.is_empty()).then(|| defects_found.join("; ")));
    }
    if !path::have_same_end(run, reference_run) {
        let end = match (&reference_run.failure, reference_run.ejected) {
            (Some(reason), _) => reason.to_string(),
            (None, true) => "the object has left the gripper".to_string(),
            (None, false) => "completed".to_string(),
        };
        let reason = format!("the reference run ends at {:.6} ms: {end}", reference_run.end_s * 1e3);
        return (Verdict::Uncertain, with_defects(reason));
    }
    let found = [defects_found, differences(comparison)].concat();
    let exceeds_limit = comparison.errors.path > comparison.limits.path || !found.is_empty();
    let verdict = if exceeds_limit { Verdict::Uncertain } else { Verdict::Accurate };
    (verdict, (!found.is_empty()).then(|| found.join("; ")))
}

/// Reason why the runs cannot be compared, if there is one.
fn nothing_compared(comparison: &Comparison<'_>) -> Option<String> {
    let Comparison { run, reference_run, perturbed_run, .. } = comparison;
    let is_interruption =
        |reason: &&Reason| matches!(reason, Reason::Budget(_) | Reason::SubstepBudget { .. } | Reason::Stopped);
    let mut failures = [reference_run, perturbed_run].into_iter().filter_map(|path| path.failure.as_ref());
    if let Some(reason) = failures.find(is_interruption) {
        return Some(format!("the reference run was not completed: {reason}"));
    }
    // The start is the same in every run.
    if run.points.len().min(reference_run.points.len()) < 2 && path::have_same_end(run, reference_run) {
        return Some(format!("the run ended after {:.1e} s, so there is nothing to compare", run.end_s));
    }
    let is_same = comparison.same_method && run.steps == reference_run.steps && run.points == reference_run.points;
    is_same.then(|| {
        let steps = run.steps;
        format!("the reference run is the same run: {steps} steps with the same digits")
    })
}

/// Defects that make a run uncertain without a comparison.
fn defects(comparison: &Comparison<'_>) -> Vec<String> {
    let gap_m = comparison.run.loop_gap_m;
    let is_within_limit = gap_m <= comparison.max_loop_gap_m;
    let gap = (!is_within_limit)
        .then(|| format!("a joint opens by {gap_m:.1e} m; {:.1e} m are allowed", comparison.max_loop_gap_m));
    let violation = comparison.run.audit.and_then(|audit| audit.violation()).map(|violation| violation.to_string());
    let overlap = unseen_overlap(comparison.run);
    gap.into_iter().chain(violation).chain(comparison.run.deep_contact.clone()).chain(overlap).collect()
}

/// Describes surfaces that overlap although they are not in touch: the run has missed their contact.
fn unseen_overlap(run: &Path) -> Option<String> {
    let (contact, time_s, depth) = run.unseen_overlap?;
    let name = run.contact_names.get(contact).map_or("of the run", String::as_str);
    Some(format!(
        "the surfaces of the contact {name} overlap by {depth:.1e} up to {:.6} ms without a touch-down; choose smaller steps or \
         a smaller tolerance",
        time_s * 1e3
    ))
}

/// Overlap above which a contact is more than a grazing touch, m (limit: rad).
const MIN_COMPARED_DEPTH: f64 = 1e-8;

/// Describes the first contact that one of the runs makes and the other one does not.
fn missed_touch(run: &Path, reference_run: &Path) -> Option<String> {
    let pairs = run.depths.iter().zip(&reference_run.depths).enumerate();
    let (contact, (depth, reference_depth)) = pairs.into_iter().find(|(_, (a, b))| {
        let (less, more) = (a.min(**b), a.max(**b));
        less <= 0.0 && more > MIN_COMPARED_DEPTH
    })?;
    let name = run.contact_names.get(contact).map_or("of the run", String::as_str);
    let (depth, which) = if depth > reference_depth { (depth, "run") } else { (reference_depth, "reference run") };
    Some(format!("only the {which} makes the contact {name}, to a depth of {depth:.1e}"))
}

/// Differences beyond their limits, except for the path.
fn differences(comparison: &Comparison<'_>) -> Vec<String> {
    let Errors { energy, rebound, .. } = comparison.errors;
    let ErrorLimits { energy: max_energy, restitution: max, .. } = comparison.limits;
    let energy = (*energy > max_energy).then(|| {
        format!("an energy or a work differs by {energy:.1e} of the exchanged energy; {max_energy:e} is allowed")
    });
    let restitution = (*rebound > max).then(|| format!("a restitution differs by {rebound:.1e}; {max:e} is allowed"));
    let touch = missed_touch(comparison.run, comparison.reference_run);
    energy.into_iter().chain(restitution).chain(touch).collect()
}

/// Largest effect of the perturbation on the path of a run that is not chaotic, in the unit of [`ErrorLimits::path`]. A
/// run is also chaotic if the path changes by a tenth of the largest displacement.
pub const CHAOS_THRESHOLD: f64 = 1e-3;
/// A path error is too large if it exceeds this fraction of the largest displacement.
pub const MOTION_FRACTION: f64 = 1e-2;
/// The effect of the perturbation is too large if it exceeds this fraction of the largest displacement.
const CHAOS_MOTION_FRACTION: f64 = 0.1;
/// Length that corresponds to a radian in scenes without joints, in reaches of the smallest moving body.
const FREE_BODY_LENGTH: f64 = 20.0;
/// Displacements below this fraction of a radian, or of the corresponding length, are rounding and count as rest.
const REST_FRACTION: f64 = 1e-10;

/// Largest errors of a run with the verdict "sure".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorLimits {
    /// Estimated path error. Its unit is rad for joint angles, the radius for the object of a gripper, and 20 reaches
    /// of the smallest moving body in scenes without joints. The limit is at most [`MOTION_FRACTION`] of the largest
    /// displacement.
    pub path: f64,
    /// Energy error, as a fraction of the energy exchanged in the run. In 560 random scenes of fingers, grippers and
    /// discs, the largest energy error of an accurate path was 3e-4 in the analytic model, and 6e-3 in the engine,
    /// apart from a single 1.3e-2.
    pub energy: f64,
    /// Error of the coefficient of restitution for discs that collide at the largest speed of a run.
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
pub fn reference_length_m(hand: &Hand) -> f64 {
    hand.object.as_ref().map_or(1.0, |object| max_radius(&object.shape))
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
pub(crate) fn path_error_limit(scene: &Scene, run: &Path, ordinary_limit: f64) -> ErrorLimit {
    let free_bodies = scene.mechanism.as_ref().filter(|_| !scene.has_joints());
    let size = free_bodies.map_or(1.0, |mechanism| FREE_BODY_LENGTH * smallest_reach(mechanism));
    let largest_displacement = largest_displacement(run).max(REST_FRACTION * size);
    let (ordinary, small_motion) = (ordinary_limit * size, MOTION_FRACTION * largest_displacement);
    let chaos_threshold = (CHAOS_THRESHOLD * size).min(CHAOS_MOTION_FRACTION * largest_displacement);
    if small_motion < ordinary {
        let unit = if free_bodies.is_some() { "m" } else { "rad" };
        let basis = format!("{MOTION_FRACTION} of the largest displacement, {largest_displacement:.1e} {unit}");
        return ErrorLimit {
            error: small_motion,
            chaos_threshold,
            basis,
            largest_displacement: Some(largest_displacement),
        };
    }
    let basis = match (free_bodies.is_some(), scene.hand.moving_object().is_none()) {
        (true, _) => format!("{:e} of the reach of the smallest body that moves", FREE_BODY_LENGTH * ordinary_limit),
        (false, true) => format!("{ordinary_limit:e} of a radian"),
        (false, false) => format!("{ordinary_limit:e} of a radian and of the object's radius"),
    };
    ErrorLimit { error: ordinary, chaos_threshold, basis, largest_displacement: None }
}

/// Reach of the smallest body that forces move, m; of the smallest body if there is none.
fn smallest_reach(mechanism: &Mechanism) -> f64 {
    let smallest = |only_free: bool| {
        let bodies = mechanism.bodies.iter().filter(|body| !only_free || body.motion.is_none());
        bodies.filter_map(Body::reach_m).min_by(f64::total_cmp)
    };
    smallest(true).or(smallest(false)).unwrap_or(1.0 / FREE_BODY_LENGTH)
}

/// Largest distance of a coordinate from its start along a path, in its unit.
fn largest_displacement(path: &Path) -> f64 {
    let Some(first) = path.points.first() else { return 0.0 };
    path.points.iter().map(|point| path.distance(first, point)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::criteria::Rebound;
    use crate::invariants::EnergyAudit;
    use crate::scene::parse_any;
    use crate::trace::{Energy, Model};

    const SCENE: &str = "kind = \"bodies\"\nduration = \"1 s\"\n[discs.ball]\nradius = \"20 mm\"\ncentre = [\"0 mm\", \"0 mm\"]\nmass = \"1 kg\"\n";

    /// Returns a run in which a disc moves 1 m along x, with this number of steps.
    fn path(steps: u64) -> Path {
        let points: Vec<Vec<f64>> = (0..=10).map(|index| vec![0.1 * f64::from(index), 0.0]).collect();
        let last = points[10].clone();
        Path { points, last, end_s: 1.0, units: vec![1.0; 2], steps, ..Path::default() }
    }

    fn verdict_of(run: &Path, reference_run: &Path, same_method: bool) -> (Verdict, String) {
        let errors = path::errors(run, reference_run);
        let comparison = Comparison {
            run,
            reference_run,
            perturbed_run: reference_run,
            errors: &errors,
            sensitivity: 0.0,
            chaos_threshold: 1e-3,
            limits: crate::check::ANALYTIC_LIMITS,
            max_loop_gap_m: 1e-6,
            same_method,
        };
        let (verdict, reason) = verdict(&comparison);
        (verdict, reason.unwrap_or_default())
    }

    /// Adds energies to a run that exchanges 1 J: at its end, `missing_j` is missing from the energy balance, and the
    /// dissipated energy is `created_j` too small.
    fn audited(run: Path, missing_j: f64, created_j: f64) -> Path {
        let scene = parse_any(SCENE, "ball.toml").expect("a scene");
        let mut audit = EnergyAudit::new(Model::Analytic, &scene);
        let moving = |dissipated_j: f64, balance_j: f64| Energy {
            kinetic_j: 1.0 - dissipated_j,
            dissipated_j,
            balance_j,
            ..Energy::default()
        };
        let energies = vec![
            moving(0.0, 0.0),
            moving(0.5, 0.0),
            moving(0.5 - created_j, -missing_j),
            moving(0.5 - created_j, -missing_j),
        ];
        for (index, energy) in energies.iter().enumerate() {
            audit.record(index as f64, energy);
        }
        Path { energy: energies[3], energies, audit: Some(audit), ..run }
    }

    #[test]
    fn the_same_run_twice_has_an_unknown_verdict() {
        let (verdict, reason) = verdict_of(&path(100), &path(100), true);
        assert_eq!(verdict, Verdict::Unknown);
        assert!(reason.contains("is the same run: 100 steps"), "{reason}");
        // Equal digits with another number of steps or another method are a valid comparison (free flight, or rest).
        assert_eq!(verdict_of(&path(100), &path(400), true).0, Verdict::Accurate);
        assert_eq!(verdict_of(&path(100), &path(100), false).0, Verdict::Accurate);
        // Created energy makes the run uncertain even without a comparison.
        let energy_creating_run = audited(path(100), 0.0, 0.1);
        assert_eq!(verdict_of(&energy_creating_run, &energy_creating_run, true).0, Verdict::Uncertain);
    }

    #[test]
    fn a_run_that_ends_at_its_start_has_an_unknown_verdict() {
        let short = |steps: u64| Path {
            points: vec![vec![0.0; 2]],
            last: Vec::new(),
            ejected: true,
            end_s: 1e-6,
            ..path(steps)
        };
        let (verdict, reason) = verdict_of(&short(3), &short(12), true);
        assert_eq!(verdict, Verdict::Unknown);
        assert!(reason.contains("nothing to compare"), "{reason}");
    }

    #[test]
    fn an_open_joint_makes_a_run_uncertain() {
        let (verdict, reason) = verdict_of(&Path { loop_gap_m: 3e-3, ..path(10) }, &path(40), true);
        assert_eq!(verdict, Verdict::Uncertain);
        assert!(reason.contains("a joint opens by 3.0e-3 m"), "{reason}");
        assert_eq!(verdict_of(&Path { loop_gap_m: 9e-7, ..path(10) }, &path(40), true).0, Verdict::Accurate);
        assert_eq!(verdict_of(&Path { loop_gap_m: f64::NAN, ..path(10) }, &path(40), true).0, Verdict::Uncertain);
    }

    #[test]
    fn missing_or_created_energy_makes_a_run_uncertain() {
        let valid_run = || audited(path(40), 0.0, 0.0);
        assert_eq!(verdict_of(&audited(path(10), 0.0, 0.0), &valid_run(), false), (Verdict::Accurate, String::new()));
        for (missing_j, created_j, text) in
            [(0.1, 0.0, "the energy balance is violated"), (0.0, 0.1, "contacts created energy")]
        {
            let (verdict, reason) = verdict_of(&audited(path(10), missing_j, created_j), &valid_run(), false);
            assert_eq!(verdict, Verdict::Uncertain);
            assert!(reason.contains(text), "{reason}");
            assert!(reason.contains("an energy or a work differs by 1.0e-1"), "{reason}");
        }
    }

    /// The run balances although its work is wrong; only the second run shows the error.
    #[test]
    fn a_different_work_makes_a_run_uncertain() {
        let valid_run = audited(path(40), 0.0, 0.0);
        let with_work = |work_j: f64| {
            let mut run = audited(path(10), 0.0, 0.0);
            for energy in run.energies.iter_mut().skip(1).chain(std::iter::once(&mut run.energy)) {
                energy.motor_work_j = work_j;
            }
            run
        };
        assert_eq!(verdict_of(&with_work(1e-4), &valid_run, false).0, Verdict::Accurate);
        assert_eq!(verdict_of(&with_work(1e-2), &valid_run, false).0, Verdict::Uncertain);
        // A difference at a single point, as within an impact, is no error.
        let mut within = audited(path(10), 0.0, 0.0);
        within.energies[1].kinetic_j = 0.9;
        assert_eq!(verdict_of(&within, &valid_run, false).0, Verdict::Accurate);
    }

    #[test]
    fn a_different_restitution_makes_a_run_uncertain() {
        let rebounding = |steps: u64, speed_m_s: f64, separation_m_s: f64| {
            let mut rebound = Rebound::default();
            (rebound.approach_m_s, rebound.separation_m_s) = (Some(1.0), Some(separation_m_s));
            Path { rebounds: vec![rebound], speed_m_s, ..path(steps) }
        };
        let right = rebounding(40, 1.0, 0.5);
        assert_eq!(verdict_of(&rebounding(10, 1.0, 0.5005), &right, false).0, Verdict::Accurate);
        let (verdict, reason) = verdict_of(&rebounding(10, 1.0, 0.505), &right, false);
        assert_eq!(verdict, Verdict::Uncertain);
        assert!(reason.contains("a restitution differs by 5.0e-3"), "{reason}");
        // Relative to a body that is a hundred times faster, the difference is negligible.
        assert_eq!(verdict_of(&rebounding(10, 100.0, 0.505), &right, false).0, Verdict::Accurate);
    }
}
