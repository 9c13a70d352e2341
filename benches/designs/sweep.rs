//! Accuracy and cost of the presets over many designs.

use std::hint::black_box;
use std::time::Instant;

use phalanx::scene::{Method, Preset};
use serde::Serialize;

use super::sample::{Drive, Rng, random_design};
use crate::support::BenchSolver;
use crate::support::phalanx_solver::PhalanxSolver;
use crate::support::precision::{ACCURATE_RAD, median, reference_settings, sorted, worst};
use crate::support::problem::{Problem, TORQUE_STEP, design_95};
use crate::support::table::scientific;
use crate::support::trajectory::{EndState, GRID_S, Trajectory, angle_distance, largest};

/// Seed of the designs, the same for all drives.
const SEED: u64 = 95;

/// Change of the trajectory above which a design is chaotic if its motor torque changes by 1e-9. No integrator is accurate to
/// six digits on a chaotic design.
const CHAOTIC_RAD: f64 = 1e-5;

/// Results of the presets over a set of designs.
#[derive(Clone, Debug, Serialize)]
pub struct Sweep {
    pub drive: &'static str,
    pub designs: usize,
    /// Designs that are not chaotic; only these are evaluated.
    #[serde(rename = "judged")]
    pub evaluated: usize,
    /// Evaluated designs that reach the singularity of their loop.
    pub singular: usize,
    /// Largest distance of the two references over the evaluated designs.
    pub floor_rad: f64,
    /// Designs whose reference failed for another reason; they are not evaluated.
    pub without_reference: usize,
    pub presets: Vec<PresetResult>,
}

/// Result of one preset.
#[derive(Clone, Debug, Serialize)]
pub struct PresetResult {
    pub name: String,
    /// Evaluated designs with an error of at most 1e-3 rad along the trajectory, up to the singularity.
    #[serde(rename = "right")]
    pub accurate: usize,
    /// Singular designs that end within one grid interval of the singularity.
    #[serde(rename = "singular_right")]
    pub singular_accurate: usize,
    pub angle_median_rad: f64,
    pub angle_p99_rad: f64,
    pub angle_worst_rad: f64,
    /// Design with the largest error, and whether it is singular.
    pub worst_design: usize,
    pub worst_is_singular: bool,
    /// Mean time over all designs, without observer.
    pub mean_s: f64,
    pub mean_steps: u64,
    pub max_steps: u64,
    /// Index and error of evaluated designs that are not accurate.
    #[serde(rename = "wrong")]
    pub inaccurate: Vec<(usize, f64)>,
}

/// A design with its reference trajectories.
struct Case {
    problem: Problem,
    /// Radau IIA 5 at 1e-11 and Rodas5P at 1e-12.
    references: [Trajectory; 2],
    is_evaluated: bool,
}

impl Case {
    /// Returns the first reference.
    fn reference(&self) -> &Trajectory {
        &self.references[0]
    }

    /// Returns the larger of the angle errors relative to the two references.
    fn error(&self, trajectory: &Trajectory) -> f64 {
        largest(self.references.iter().map(|reference| angle_distance(trajectory, reference)))
    }
}

/// Runs both presets, and Radau with the tolerances of the engineering preset, over `count` designs.
pub fn sweep(drive: Drive, count: usize) -> Sweep {
    let (template, mut rng) = (design_95().scene, Rng::new(SEED));
    let settings = reference_settings();
    let scenes = std::iter::repeat_with(|| random_design(&mut rng, &template, drive)).flatten().take(count);
    let cases: Vec<Case> = scenes.map(|scene| case(Problem::new(scene), &settings)).collect();
    let presets = [
        ("engineering", PhalanxSolver::from_preset(Preset::Engineering)),
        ("reference", PhalanxSolver::from_preset(Preset::Reference)),
        ("engineering tolerances, Radau", PhalanxSolver::with_rtol(Method::RadauIIa5, 1e-5)),
    ];
    let evaluated = || cases.iter().filter(|case| case.is_evaluated);
    let failed = |case: &&Case| matches!(case.reference().end_state, EndState::Failed(_));
    Sweep {
        drive: match drive {
            Drive::Random => "random",
            Drive::Sized => "sized",
        },
        designs: count,
        evaluated: evaluated().count(),
        singular: evaluated().filter(|case| singular_at(case.reference()).is_some()).count(),
        floor_rad: largest(evaluated().map(|case| angle_distance(&case.references[0], &case.references[1]))),
        without_reference: cases.iter().filter(failed).count(),
        presets: presets.iter().map(|(name, solver)| evaluate_preset(name, solver, &cases)).collect(),
    }
}

fn case(problem: Problem, settings: &[PhalanxSolver; 2]) -> Case {
    let references = [0, 1].map(|i: usize| settings[i].record(&problem));
    let perturbed = settings[0].record(&problem.with_torque(1.0 + TORQUE_STEP));
    let is_evaluated = angle_distance(&references[0], &perturbed) <= CHAOTIC_RAD;
    Case { problem, references, is_evaluated }
}

fn singular_at(trajectory: &Trajectory) -> Option<f64> {
    match trajectory.end_state {
        EndState::Singular(time_s) => Some(time_s),
        _ => None,
    }
}

fn evaluate_preset(name: &str, solver: &PhalanxSolver, cases: &[Case]) -> PresetResult {
    let trajectories: Vec<Trajectory> = cases.iter().map(|case| solver.record(&case.problem)).collect();
    let start = Instant::now();
    for case in cases {
        black_box(solver.run(black_box(&case.problem))).ok();
    }
    let mean_s = start.elapsed().as_secs_f64() / cases.len() as f64;

    let evaluated = || cases.iter().zip(&trajectories).enumerate().filter(|(_, (case, _))| case.is_evaluated);
    let errors = || evaluated().map(|(index, (case, trajectory))| (index, case.error(trajectory)));
    let angles = sorted(errors().map(|(_, error)| error));
    let worst_design = errors().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index);
    let both_end_at_singularity = |case: &Case, trajectory: &Trajectory| {
        let ends = singular_at(case.reference()).zip(singular_at(trajectory));
        ends.is_some_and(|(a, b)| (a - b).abs() <= GRID_S)
    };
    let steps = |trajectory: &Trajectory| trajectory.cost.steps;
    PresetResult {
        name: name.to_string(),
        accurate: angles.iter().filter(|error| **error <= ACCURATE_RAD).count(),
        singular_accurate: evaluated()
            .filter(|(_, (case, trajectory))| both_end_at_singularity(case, trajectory))
            .count(),
        angle_median_rad: median(&angles),
        angle_p99_rad: angles.get(angles.len() * 99 / 100).copied().unwrap_or(f64::NAN),
        angle_worst_rad: worst(&angles),
        worst_design,
        worst_is_singular: cases.get(worst_design).is_some_and(|case| singular_at(case.reference()).is_some()),
        mean_s,
        mean_steps: trajectories.iter().map(steps).sum::<u64>() / trajectories.len().max(1) as u64,
        max_steps: trajectories.iter().map(steps).max().unwrap_or(0),
        inaccurate: errors().filter(|(_, error)| *error > ACCURATE_RAD).collect(),
    }
}

/// Prints the result.
pub fn print(sweep: &Sweep) {
    println!(
        "\n{} random designs, motor and spring {}: {} chaotic, {} without reference, {} evaluated, {} of them singular; the references differ by {} rad.",
        sweep.designs,
        sweep.drive,
        sweep.designs - sweep.evaluated,
        sweep.without_reference,
        sweep.evaluated,
        sweep.singular,
        scientific(sweep.floor_rad)
    );
    println!(
        "{:<30} | {:>11} {:>9} | {:>8} {:>8} {:>8} | {:>8} | {:>6} {:>6}",
        "preset", "accurate", "singular", "median", "p99", "worst", "mean µs", "steps", "max"
    );
    for preset in &sweep.presets {
        println!(
            "{:<30} | {:>11} {:>9} | {:>8} {:>8} {:>8} | {:>8.1} | {:>6} {:>6} | worst is {}{}",
            preset.name,
            format!("{}/{}", preset.accurate, sweep.evaluated),
            format!("{}/{}", preset.singular_accurate, sweep.singular),
            scientific(preset.angle_median_rad),
            scientific(preset.angle_p99_rad),
            scientific(preset.angle_worst_rad),
            preset.mean_s * 1e6,
            preset.mean_steps,
            preset.max_steps,
            preset.worst_design,
            if preset.worst_is_singular { ", singular" } else { "" },
        );
        for (index, error) in preset.inaccurate.iter().take(5) {
            println!("    design {index} has an error of {} rad", scientific(*error));
        }
    }
}
