//! The verdict on a run, from the runs that it is compared with.

use super::path::{self, Errors, Path};
use super::scale::ErrorLimits;
use crate::integrator::Reason;

/// Verdict on the accuracy of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Two independent resolutions agree.
    Accurate,
    /// They disagree, or the energy does not balance, or a joint opens: the outcome depends on the tolerance.
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

/// A completed run, the reference run, the perturbed reference run, and their differences.
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
    /// Whether model and method of both runs are the same, so that only their steps can differ.
    pub same_method: bool,
}

/// Returns the verdict, and its reason beyond the path error.
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
    gap.into_iter().chain(violation).collect()
}

/// Differences beyond their limits, except for the path.
fn differences(comparison: &Comparison<'_>) -> Vec<String> {
    let Errors { energy, rebound, .. } = comparison.errors;
    let ErrorLimits { energy: max_energy, restitution: max, .. } = comparison.limits;
    let energy = (*energy > max_energy).then(|| {
        format!("an energy or a work differs by {energy:.1e} of the exchanged energy; {max_energy:e} is allowed")
    });
    let restitution = (*rebound > max).then(|| format!("a restitution differs by {rebound:.1e}; {max:e} is allowed"));
    energy.into_iter().chain(restitution).collect()
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
