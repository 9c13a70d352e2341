//! Reproduction of the figures of the thesis: sizing, designs, statics, volumes, the 384 simulations, selection, design
//! 95 and its CAD model, each compared with the printed value.
//!
//! | file | job |
//! |---|---|
//! | `figures` | figures as printed, with sources, expected values and reasons for differences (`thesis.csv`, `reasons.toml`), and their comparison with computed values |
//! | `designs` | sizing, masses and statics of the designs, also with other torques and other grid points; design 95 as printed, and its CAD model |
//! | `chaos` | checks of the simulations, and runs whose class depends on method, tolerance or torque |
//! | `paper`, `sections` | the paper, its sections, and text tables |

mod chaos;
mod designs;
mod figures;
mod paper;
mod sections;

use std::fmt::Display;

use serde::Serialize;

pub use chaos::{Chaos, Checks, ClassChange, StableRuns};
pub use designs::{Closing, Grid, OtherSizing, SizingFound};
pub use figures::{Comparison, Figure, Reason, Verdict, computed_values, figures, reasons};

use crate::check::Check;
use crate::criteria::Class;
use crate::scene::Scene;
use crate::statics::NecessaryCount;
use crate::volume::{Axes, Volume, VolumeRequest, volumes as compute_volumes};
use phalanx_parallel::{ComputeError, Monitor};

/// Number of the design that the thesis chooses.
const CHOSEN_DESIGN: i64 = 95;

/// Number of steps of a reproduction, for progress reports. The simulations are the first step.
pub const STEPS: usize = 6;

/// All results of the reproduction. Its JSON document contains the comparisons and the near-chaotic runs.
#[derive(Clone, Debug, Serialize)]
pub struct Reproduction {
    /// Whether the volumes have a coarser resolution.
    pub quick: bool,
    /// Number of computed values that are compared with an expected value.
    pub judged: usize,
    /// Number of these values that are outside their tolerance.
    pub outside: usize,
    #[serde(rename = "figures")]
    pub comparisons: Vec<Comparison>,
    /// Numbers of statically stable designs with other torques.
    pub other_sizings: Vec<OtherSizing>,
    pub checks: Checks,
    pub near_chaotic: Chaos,
    /// Index of each completed simulation, and its check.
    #[serde(skip)]
    pub checked_runs: Vec<(usize, Check)>,
    #[serde(skip)]
    pub simulations: Simulations,
    #[serde(skip)]
    pub sizing: SizingFound,
    /// Necessary condition (1.19) for form closure of design 95.
    #[serde(skip)]
    pub necessary_count: NecessaryCount,
    /// Number of form-closed designs if l21 takes values at quarters of its range, as printed (errata 15).
    #[serde(skip)]
    pub form_closed_quarters: usize,
    #[serde(skip)]
    pub volumes: Vec<Volume>,
    #[serde(skip)]
    pub grids: Vec<Grid>,
    /// Closing of design 95 with the printed torques.
    #[serde(skip)]
    pub chosen: Closing,
    /// Closing of the CAD model of design 95.
    #[serde(skip)]
    pub cad: Closing,
    /// Errata of the thesis as a Markdown table.
    #[serde(skip)]
    pub errata: &'static str,
}

/// Results of the study of the thesis. The caller computes them with a sweep and a selection.
#[derive(Clone, Debug)]
pub struct Simulations {
    /// All runs: first all designs without friction, then all designs with friction in the same order.
    pub runs: Vec<Run>,
    /// Names of the two conditions.
    pub conditions: Vec<String>,
    /// Smallest and largest mass of the designs.
    pub mass_kg: [f64; 2],
    /// Smallest and largest trajectory of the designs, rad.
    pub trajectory_rad: [f64; 2],
    /// Selection criteria in the order of application. Each has a name and four numbers of runs: those that meet it,
    /// those that do not, those that remain after it, and those that only it removes.
    pub criteria: Vec<(String, [usize; 4])>,
    /// Labels of the axes that define a design.
    pub axes: Vec<String>,
    /// Selected runs, best first.
    pub ranking: Vec<RankedRun>,
    /// Five pictures of the selection as SVG: criteria, dynamic classes, static stability, final forces, designs.
    pub pictures: [String; 5],
}

impl Simulations {
    /// Counts the runs of a condition that have a property.
    pub fn count(&self, condition: usize, property: impl Fn(&Run) -> bool) -> usize {
        self.runs.iter().filter(|run| run.condition == condition && property(run)).count()
    }

    /// Returns the run without friction of the design that the thesis chooses.
    pub fn chosen(&self) -> Option<&Run> {
        self.runs.iter().find(|run| run.design == CHOSEN_DESIGN)
    }

    /// Number of designs; both conditions contain all of them.
    pub fn designs(&self) -> usize {
        self.count(0, |_| true)
    }
}

/// One simulation. Figures that are missing are `None`.
#[derive(Clone, Debug)]
pub struct Run {
    pub run: i64,
    pub design: i64,
    /// Index of the condition of the run.
    pub condition: usize,
    pub scene: Scene,
    /// Whether the run was simulated to the end.
    pub is_completed: bool,
    /// Whether the simulation failed.
    pub is_failed: bool,
    pub force_positive: Option<bool>,
    pub form_closed: Option<bool>,
    pub class: Option<Class>,
    pub tts_s: Option<f64>,
    /// Final normal force of the proximal phalanx in the simulation, N.
    pub f21_n: Option<f64>,
    /// Final normal force of the distal phalanx in the simulation, N.
    pub f22_n: Option<f64>,
    /// Palm force computed from these normal forces, N.
    pub pfp_n: Option<f64>,
}

impl Run {
    /// Whether the run is dynamically stable: stable or semi-stable.
    fn is_stable(&self) -> bool {
        is_stable(self.class)
    }

    fn is_statically_stable(&self) -> bool {
        self.force_positive == Some(true)
    }
}

/// A selected run.
#[derive(Clone, Debug)]
pub struct RankedRun {
    /// Index of the run.
    pub run: usize,
    pub rank: usize,
    /// Weighted score r_WC (4.2).
    pub r_wc: f64,
    /// Values of the axes as text.
    pub axes: Vec<String>,
}

fn is_stable(class: Option<Class>) -> bool {
    matches!(class, Some(Class::Stable | Class::SemiStable))
}

/// Returns a function that converts the error of a step.
fn step_error<E: Display>(step: &'static str) -> impl Fn(E) -> ComputeError {
    move |reason| ComputeError::Failed(format!("{step} could not be computed: {reason}"))
}

/// Computes all results on `threads` threads (0: one per core). The inputs are the simulations, design 95 with the
/// printed torques, its CAD model, and the errata as a Markdown table. With `quick`, volumes are coarser. The monitor
/// has already counted the simulations as the first of [`STEPS`] steps.
///
/// # Errors
/// Returns an error if a step fails, which is a bug because all inputs are shipped, or if the monitor stops the
/// computation.
pub fn reproduce(
    simulations: Simulations,
    [chosen, cad]: [Scene; 2],
    errata: &'static str,
    quick: bool,
    threads: usize,
    monitor: &Monitor,
) -> Result<Reproduction, ComputeError> {
    let start_step = |name: &str| {
        monitor.advance(1, name);
        monitor.check()
    };
    start_step("sizing")?;
    let chosen_run = simulations.chosen().ok_or("it is not in the study").map_err(step_error("design 95"))?;
    let without_friction = simulations.runs.iter().filter(|run| run.condition == 0).map(|run| &run.scene);
    let sizing = designs::sizing(without_friction, &chosen_run.scene)?;
    start_step("statics")?;
    let necessary_count = designs::necessary_count(&chosen_run.scene)?;
    let other_sizings = designs::other_sizings(&simulations, &sizing)?;
    start_step("grasp-state volumes")?;
    let request = VolumeRequest { axes: Axes::thesis([if quick { 10 } else { 20 }; 3]), ..VolumeRequest::thesis() };
    // The designs are not parts of the reproduction.
    let silent = Monitor::silent(monitor.keep_running());
    let volumes = compute_volumes(&request, threads, &silent).map_err(|error| match error {
        ComputeError::Stopped { .. } => monitor.stopped(),
        error => error,
    })?;
    let grids = designs::grids(&sizing, monitor)?;
    start_step("runs that are near-chaotic")?;
    let (checked_runs, near_chaotic) = chaos::chaos(&simulations, threads, monitor)?;
    let mut checks = Checks::default();
    checked_runs.iter().for_each(|(index, check)| checks.add(simulations.runs[*index].run, check));
    start_step("design 95")?;
    let (chosen, cad) = (designs::closing("design 95", &chosen)?, designs::closing("CAD model", &cad)?);
    let mut reproduction = Reproduction {
        quick,
        judged: 0,
        outside: 0,
        comparisons: Vec::new(),
        other_sizings,
        checks,
        near_chaotic,
        checked_runs,
        simulations,
        sizing,
        necessary_count,
        form_closed_quarters: designs::form_closed_in_quarters()?,
        volumes,
        grids,
        chosen,
        cad,
        errata,
    };
    reproduction.comparisons = figures::compare(&computed_values(&reproduction), quick);
    let count = |verdict| reproduction.comparisons.iter().filter(|of| of.verdict == verdict).count();
    let [inside, outside] = [count(Verdict::Inside), count(Verdict::Outside)];
    (reproduction.judged, reproduction.outside) = (inside + outside, outside);
    Ok(reproduction)
}
