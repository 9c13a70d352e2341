//! Presets against references over many designs.

use std::hint::black_box;
use std::time::Instant;

use phalanx::scene::{Method, Preset};
use serde::Serialize;

use super::sample::{Draw, Drive, next};
use crate::support::Contestant;
use crate::support::ours::Ours;
use crate::support::precision::{RIGHT_RAD, median, reference_settings, sorted, worst};
use crate::support::problem::{NUDGE, Problem, design_95};
use crate::support::table::scientific;
use crate::support::track::{Ended, GRID_S, Track, angle_distance, largest};

/// Every drive has the same designs.
const SEED: u64 = 95;

/// A design whose trajectory moves further than this when its motor torque changes by 1e-9 is chaotic: no integrator can
/// be right on it to six digits.
const CHAOTIC_RAD: f64 = 1e-5;

/// Presets over a set of designs.
#[derive(Clone, Debug, Serialize)]
pub struct Sweep {
    pub drive: &'static str,
    pub designs: usize,
    /// Designs that are not chaotic: only these are judged.
    pub judged: usize,
    /// Designs, of those judged, that run into the singularity of their loop.
    pub singular: usize,
    /// Largest distance of the two references over the designs judged.
    pub floor_rad: f64,
    /// Designs whose reference could not be completed for any other reason; they are not judged.
    pub without_reference: usize,
    pub presets: Vec<Verdict>,
}

/// One preset.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    pub name: String,
    /// Judged designs within 1e-3 rad along the trajectory; those that are singular up to the singularity.
    pub right: usize,
    /// Singular designs that end at the singularity, within one grid interval.
    pub singular_right: usize,
    pub angle_median_rad: f64,
    pub angle_p99_rad: f64,
    pub angle_worst_rad: f64,
    /// The design it is of, and whether that is a singular one.
    pub worst_design: usize,
    pub worst_is_singular: bool,
    /// Mean over all designs, without observer.
    pub mean_s: f64,
    pub mean_steps: u64,
    pub max_steps: u64,
    /// Judged designs that are not right: index, error.
    pub wrong: Vec<(usize, f64)>,
}

struct Case {
    problem: Problem,
    /// Radau IIA 5 at 1e-11 and Rodas5P at 1e-12.
    references: [Track; 2],
    judged: bool,
}

impl Case {
    /// The first reference, where one is enough.
    fn reference(&self) -> &Track {
        &self.references[0]
    }

    /// Angle error against the further one of the two references.
    fn error(&self, track: &Track) -> f64 {
        largest(self.references.iter().map(|reference| angle_distance(track, reference)))
    }
}

/// Runs both presets, and Radau at the tolerances of the everyday one, over `count` designs.
pub fn sweep(drive: Drive, count: usize) -> Sweep {
    let (template, mut draw) = (design_95().scene, Draw::new(SEED));
    let settings = reference_settings();
    let scenes = std::iter::repeat_with(|| next(&mut draw, &template, drive)).flatten().take(count);
    let cases: Vec<Case> = scenes.map(|scene| case(Problem::new(scene), &settings)).collect();
    let presets = [
        ("engineering", Ours::preset(Preset::Engineering)),
        ("reference", Ours::preset(Preset::Reference)),
        ("engineering tolerances, Radau", Ours::at(Method::RadauIIa5, 1e-5)),
    ];
    let judged = || cases.iter().filter(|case| case.judged);
    let failed = |case: &&Case| matches!(case.reference().ended, Ended::Failed(_));
    Sweep {
        drive: match drive {
            Drive::Random => "random",
            Drive::Sized => "sized",
        },
        designs: count,
        judged: judged().count(),
        singular: judged().filter(|case| singular_at(case.reference()).is_some()).count(),
        floor_rad: largest(judged().map(|case| angle_distance(&case.references[0], &case.references[1]))),
        without_reference: cases.iter().filter(failed).count(),
        presets: presets.iter().map(|(name, ours)| verdict(name, ours, &cases)).collect(),
    }
}

fn case(problem: Problem, settings: &[Ours; 2]) -> Case {
    let references = [0, 1].map(|i: usize| settings[i].follow(&problem));
    let nudged = settings[0].follow(&problem.with_torque(1.0 + NUDGE));
    let judged = angle_distance(&references[0], &nudged) <= CHAOTIC_RAD;
    Case { problem, references, judged }
}

fn singular_at(track: &Track) -> Option<f64> {
    match track.ended {
        Ended::Singular(time_s) => Some(time_s),
        _ => None,
    }
}

fn verdict(name: &str, ours: &Ours, cases: &[Case]) -> Verdict {
    let tracks: Vec<Track> = cases.iter().map(|case| ours.follow(&case.problem)).collect();
    let start = Instant::now();
    for case in cases {
        black_box(ours.run(black_box(&case.problem))).ok();
    }
    let mean_s = start.elapsed().as_secs_f64() / cases.len() as f64;

    let judged = || cases.iter().zip(&tracks).enumerate().filter(|(_, (case, _))| case.judged);
    let errors = || judged().map(|(index, (case, track))| (index, case.error(track)));
    let angles = sorted(errors().map(|(_, error)| error));
    let worst_design = errors().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index);
    let both_end = |case: &Case, track: &Track| {
        let ends = singular_at(case.reference()).zip(singular_at(track));
        ends.is_some_and(|(a, b)| (a - b).abs() <= GRID_S)
    };
    let steps = |track: &Track| track.cost.steps;
    Verdict {
        name: name.to_string(),
        right: angles.iter().filter(|error| **error <= RIGHT_RAD).count(),
        singular_right: judged().filter(|(_, (case, track))| both_end(case, track)).count(),
        angle_median_rad: median(&angles),
        angle_p99_rad: angles.get(angles.len() * 99 / 100).copied().unwrap_or(f64::NAN),
        angle_worst_rad: worst(&angles),
        worst_design,
        worst_is_singular: cases.get(worst_design).is_some_and(|case| singular_at(case.reference()).is_some()),
        mean_s,
        mean_steps: tracks.iter().map(steps).sum::<u64>() / tracks.len().max(1) as u64,
        max_steps: tracks.iter().map(steps).max().unwrap_or(0),
        wrong: errors().filter(|(_, error)| *error > RIGHT_RAD).collect(),
    }
}

/// Prints the result.
pub fn print(sweep: &Sweep) {
    println!(
        "\n{} random designs, motor and spring {}: {} chaotic, {} without reference, {} judged, {} of them singular; references {} rad apart.",
        sweep.designs,
        sweep.drive,
        sweep.designs - sweep.judged,
        sweep.without_reference,
        sweep.judged,
        sweep.singular,
        scientific(sweep.floor_rad)
    );
    println!(
        "{:<30} | {:>11} {:>9} | {:>8} {:>8} {:>8} | {:>8} | {:>6} {:>6}",
        "preset", "right", "singular", "median", "p99", "worst", "mean µs", "steps", "max"
    );
    for preset in &sweep.presets {
        println!(
            "{:<30} | {:>11} {:>9} | {:>8} {:>8} {:>8} | {:>8.1} | {:>6} {:>6} | worst is {}{}",
            preset.name,
            format!("{}/{}", preset.right, sweep.judged),
            format!("{}/{}", preset.singular_right, sweep.singular),
            scientific(preset.angle_median_rad),
            scientific(preset.angle_p99_rad),
            scientific(preset.angle_worst_rad),
            preset.mean_s * 1e6,
            preset.mean_steps,
            preset.max_steps,
            preset.worst_design,
            if preset.worst_is_singular { ", singular" } else { "" },
        );
        for (index, error) in preset.wrong.iter().take(5) {
            println!("    design {index} is {} rad off", scientific(*error));
        }
    }
}
