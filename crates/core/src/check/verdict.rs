//! What is said of a run, by the runs that it is compared with.

use super::path::{self, Errors, Path};
use crate::integrator::Reason;

/// What is to be said of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Two independent resolutions agree.
    Sure,
    /// They do not, or energy is not accounted for, or a joint opens: the outcome depends on the tolerance.
    Uncertain,
    /// The outcome depends on the last digits of the input.
    Chaotic,
    /// Nothing was compared.
    Unknown,
}

impl Verdict {
    /// In results, logs and reports.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Sure => "sure",
            Verdict::Uncertain => "uncertain",
            Verdict::Chaotic => "chaotic",
            Verdict::Unknown => "unknown",
        }
    }
}

/// A completed run, the finer one, the same with a push, and how they compare.
pub struct Compared<'a> {
    pub run: &'a Path,
    pub second: &'a Path,
    pub pushed: &'a Path,
    pub errors: &'a Errors,
    pub sensitivity: f64,
    /// The effect of a push from which on the run is chaotic.
    pub chaotic: f64,
    /// The error of the path, the error of energies and the opening of a joint (m) from which on the run is uncertain.
    pub bar: f64,
    pub energy_bar: f64,
    pub restitution_bar: f64,
    pub gap_bar_m: f64,
    /// Whether model and method of both runs are the same, so that only steps can differ.
    pub same_method: bool,
}

/// The verdict, and what decided it where the figures of the path do not say it.
pub fn verdict(of: &Compared<'_>) -> (Verdict, Option<String>) {
    let Compared { run, second, pushed, .. } = of;
    let broken = defects(of);
    let with = |reason: String| Some([vec![reason], broken.clone()].concat().join("; "));
    if let Some(reason) = nothing_compared(of) {
        return if broken.is_empty() { (Verdict::Unknown, Some(reason)) } else { (Verdict::Uncertain, with(reason)) };
    }
    if of.sensitivity > of.chaotic || !path::end_alike(second, pushed) {
        return (Verdict::Chaotic, (!broken.is_empty()).then(|| broken.join("; ")));
    }
    if !path::end_alike(run, second) {
        let ends = match (&second.failure, second.ejected) {
            (Some(reason), _) => reason.to_string(),
            (None, true) => "the object has left the gripper".to_string(),
            (None, false) => "completed".to_string(),
        };
        let reason = format!("the run that checks it ends at {:.6} ms: {ends}", second.end_s * 1e3);
        return (Verdict::Uncertain, with(reason));
    }
    let found = [broken, differences(of)].concat();
    let is_off = of.errors.path > of.bar || !found.is_empty();
    let verdict = if is_off { Verdict::Uncertain } else { Verdict::Sure };
    (verdict, (!found.is_empty()).then(|| found.join("; ")))
}

/// Why nothing was compared, if so.
fn nothing_compared(of: &Compared<'_>) -> Option<String> {
    let Compared { run, second, pushed, .. } = of;
    let early = |reason: &&Reason| matches!(reason, Reason::Budget(_) | Reason::SubstepBudget { .. } | Reason::Stopped);
    let mut failures = [second, pushed].into_iter().filter_map(|path| path.failure.as_ref());
    if let Some(reason) = failures.find(early) {
        return Some(format!("the run that was to check it did not get to its end: {reason}"));
    }
    // The start alone is the same in every run.
    if run.points.len().min(second.points.len()) < 2 && path::end_alike(run, second) {
        return Some(format!("it ended after {:.1e} s, and there is nothing to compare", run.end_s));
    }
    let is_same = of.same_method && run.steps == second.steps && run.points == second.points;
    is_same.then(|| {
        let steps = run.steps;
        format!("the run that was to check it is the same run: {steps} equal steps, to the last digit")
    })
}

/// What makes a run uncertain by itself.
fn defects(of: &Compared<'_>) -> Vec<String> {
    let gap_m = of.run.loop_gap_m;
    let within = gap_m <= of.gap_bar_m;
    let gap = (!within).then(|| format!("a joint opens by {gap_m:.1e} m, where {:.1e} m are allowed", of.gap_bar_m));
    let breach = of.run.audit.and_then(|audit| audit.breach()).map(|breach| breach.to_string());
    gap.into_iter().chain(breach).collect()
}

/// What differs beyond its bar, other than the path.
fn differences(of: &Compared<'_>) -> Vec<String> {
    let Errors { energy, rebound, .. } = of.errors;
    let energy = (*energy > of.energy_bar).then(|| {
        format!(
            "an energy or a work is off by {energy:.1e} of the energy exchanged, where {:e} is allowed",
            of.energy_bar
        )
    });
    let bar = of.restitution_bar;
    let restitution =
        (*rebound > bar).then(|| format!("a restitution is off by {rebound:.1e}, where {bar:e} is allowed"));
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

    /// A run of a disc along x by a metre, in so many steps.
    fn path(steps: u64) -> Path {
        let points: Vec<Vec<f64>> = (0..=10).map(|index| vec![0.1 * f64::from(index), 0.0]).collect();
        let last = points[10].clone();
        Path { points, last, end_s: 1.0, units: vec![1.0; 2], steps, ..Path::default() }
    }

    fn judged(run: &Path, second: &Path, same_method: bool) -> (Verdict, String) {
        let errors = path::errors(run, second);
        let of = Compared {
            run,
            second,
            pushed: second,
            errors: &errors,
            sensitivity: 0.0,
            chaotic: 1e-3,
            bar: 1e-5,
            energy_bar: 1e-3,
            restitution_bar: 1e-3,
            gap_bar_m: 1e-6,
            same_method,
        };
        let (verdict, reason) = verdict(&of);
        (verdict, reason.unwrap_or_default())
    }

    /// Energies of a run that exchanges 1 J, of which at the end so much is missing and so much was created.
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
            audit.enter(index as f64, energy);
        }
        Path { energy: energies[3], energies, audit: Some(audit), ..run }
    }

    #[test]
    fn the_same_run_twice_is_no_check() {
        let (verdict, reason) = judged(&path(100), &path(100), true);
        assert_eq!(verdict, Verdict::Unknown);
        assert!(reason.contains("is the same run: 100 equal steps"), "{reason}");
        // Another number of steps, or another method, that gives the same digits: free flight, or rest.
        assert_eq!(judged(&path(100), &path(400), true).0, Verdict::Sure);
        assert_eq!(judged(&path(100), &path(100), false).0, Verdict::Sure);
        // Energy from nothing makes it uncertain all the same.
        let creates = audited(path(100), 0.0, 0.1);
        assert_eq!(judged(&creates, &creates, true).0, Verdict::Uncertain);
    }

    #[test]
    fn a_start_without_a_path_is_no_check() {
        let short = |steps: u64| Path {
            points: vec![vec![0.0; 2]],
            last: Vec::new(),
            ejected: true,
            end_s: 1e-6,
            ..path(steps)
        };
        let (verdict, reason) = judged(&short(3), &short(12), true);
        assert_eq!(verdict, Verdict::Unknown);
        assert!(reason.contains("nothing to compare"), "{reason}");
    }

    #[test]
    fn a_joint_that_opens_makes_a_run_uncertain() {
        let (verdict, reason) = judged(&Path { loop_gap_m: 3e-3, ..path(10) }, &path(40), true);
        assert_eq!(verdict, Verdict::Uncertain);
        assert!(reason.contains("a joint opens by 3.0e-3 m"), "{reason}");
        assert_eq!(judged(&Path { loop_gap_m: 9e-7, ..path(10) }, &path(40), true).0, Verdict::Sure);
        assert_eq!(judged(&Path { loop_gap_m: f64::NAN, ..path(10) }, &path(40), true).0, Verdict::Uncertain);
    }

    #[test]
    fn energy_that_is_missing_or_created_makes_a_run_uncertain() {
        let sound = || audited(path(40), 0.0, 0.0);
        assert_eq!(judged(&audited(path(10), 0.0, 0.0), &sound(), false), (Verdict::Sure, String::new()));
        for (missing_j, created_j, words) in
            [(0.1, 0.0, "the energy balance is off"), (0.0, 0.1, "contacts created energy from nothing")]
        {
            let (verdict, reason) = judged(&audited(path(10), missing_j, created_j), &sound(), false);
            assert_eq!(verdict, Verdict::Uncertain);
            assert!(reason.contains(words), "{reason}");
            assert!(reason.contains("an energy or a work is off by 1.0e-1"), "{reason}");
        }
    }

    /// A work that is wrong while its run balances: only the second run shows it.
    #[test]
    fn a_work_that_differs_makes_a_run_uncertain() {
        let sound = audited(path(40), 0.0, 0.0);
        let with_work = |work_j: f64| {
            let mut run = audited(path(10), 0.0, 0.0);
            for energy in run.energies.iter_mut().skip(1).chain(std::iter::once(&mut run.energy)) {
                energy.motor_work_j = work_j;
            }
            run
        };
        assert_eq!(judged(&with_work(1e-4), &sound, false).0, Verdict::Sure);
        assert_eq!(judged(&with_work(1e-2), &sound, false).0, Verdict::Uncertain);
        // At one point alone, as within an impact, it is no error.
        let mut within = audited(path(10), 0.0, 0.0);
        within.energies[1].kinetic_j = 0.9;
        assert_eq!(judged(&within, &sound, false).0, Verdict::Sure);
    }

    #[test]
    fn a_restitution_that_differs_makes_a_run_uncertain() {
        let rebounding = |steps: u64, speed_m_s: f64, separation_m_s: f64| {
            let mut rebound = Rebound::default();
            (rebound.approach_m_s, rebound.separation_m_s) = (Some(1.0), Some(separation_m_s));
            Path { rebounds: vec![rebound], speed_m_s, ..path(steps) }
        };
        let right = rebounding(40, 1.0, 0.5);
        assert_eq!(judged(&rebounding(10, 1.0, 0.5005), &right, false).0, Verdict::Sure);
        let (verdict, reason) = judged(&rebounding(10, 1.0, 0.505), &right, false);
        assert_eq!(verdict, Verdict::Uncertain);
        assert!(reason.contains("a restitution is off by 5.0e-3"), "{reason}");
        // Beside a body that is a hundred times faster it is a matter of rounding.
        assert_eq!(judged(&rebounding(10, 100.0, 0.505), &right, false).0, Verdict::Sure);
    }
}
