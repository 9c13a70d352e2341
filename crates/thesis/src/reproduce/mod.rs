//! Reproduction of the figures of the thesis: sizing, designs, statics, volumes, the 384 simulations, selection, design
//! 95 and its CAD model, each compared with the printed value.
//!
//! | file | job |
//! |---|---|
//! | `figures` | figures as printed, with sources, expected values and reasons for differences (`thesis.csv`, `reasons.toml`), and their comparison |
//! | `simulations` | results of the 384 simulations and their selection, which the caller computes |
//! | `designs` | sizing, masses and statics of the designs, also with other torques and other grid points |
//! | `chaos` | checks of the simulations, and runs whose class depends on method, tolerance or torque |
//! | `closing` | design 95 as printed, and its CAD model |
//! | `values` | computed values by figure key |
//! | `paper`, `runs`, `volumes` | the paper: its sections |
//! | `text` | text tables |

mod chaos;
mod closing;
mod designs;
mod figures;
mod paper;
mod runs;
mod simulations;
mod text;
mod values;
mod volumes;

use std::fmt::Display;

use serde::Serialize;

pub use chaos::{Chaos, Checks, ClassChange, StableRuns};

pub(crate) use chaos::{MAX_TTS_DIFFERENCE_S, VARIATIONS};
pub use closing::Closing;
pub use designs::{Grid, OtherSizing, SizingFound};
pub use figures::{Comparison, Figure, Reason, Verdict, figures, reasons};
pub(crate) use simulations::CHOSEN_DESIGN;
pub use simulations::{RankedRun, Run, Simulations};
pub use values::computed_values;

use crate::check::Check;
use crate::monitor::{Monitor, StudyError};
use crate::scene::Scene;
use crate::statics::NecessaryCount;
use crate::volume::{Axes, Volume, VolumeRequest, volumes as compute_volumes};

/// Number of points of a volume along each axis.
pub(crate) const RESOLUTION: usize = 20;
/// Number of points along each axis in a quick reproduction.
pub(crate) const QUICK_RESOLUTION: usize = 10;

/// Number of steps of a reproduction, for progress reports. The first one is the simulations.
pub const STEPS: usize = 6;

/// All results of the reproduction. Its JSON document contains the comparisons and the near-chaotic runs.
#[derive(Clone, Debug, Serialize)]
pub struct Reproduction {
    /// Whether the volumes are coarser.
    pub quick: bool,
    /// Number of computed values that are compared with an expected value.
    pub judged: usize,
    /// Number of these values outside their tolerance.
    pub outside: usize,
    #[serde(rename = "figures")]
    pub comparisons: Vec<Comparison>,
    /// Statically stable designs with other torques.
    pub other_sizings: Vec<OtherSizing>,
    pub checks: Checks,
    pub near_chaotic: Chaos,
    /// Index and check of each completed simulation.
    #[serde(skip)]
    pub checked_runs: Vec<(usize, Check)>,
    #[serde(skip)]
    pub simulations: Simulations,
    #[serde(skip)]
    pub sizing: SizingFound,
    /// Necessary condition (1.19) for form closure of design 95.
    #[serde(skip)]
    pub necessary_count: NecessaryCount,
    /// Number of form-closed designs if l21 takes quarters of its range, as printed (errata 15).
    #[serde(skip)]
    pub form_closed_quarters: usize,
    #[serde(skip)]
    pub volumes: Vec<Volume>,
    #[serde(skip)]
    pub grids: Vec<Grid>,
    /// Design 95 with the printed torques.
    #[serde(skip)]
    pub chosen: Closing,
    /// CAD model of design 95.
    #[serde(skip)]
    pub cad: Closing,
    /// Errata of the thesis as a Markdown table.
    #[serde(skip)]
    pub errata: &'static str,
}

/// Data that the caller of [`reproduce`] provides.
#[derive(Clone, Debug)]
pub struct Input {
    pub simulations: Simulations,
    /// Design 95 with the printed torques.
    pub chosen: Scene,
    /// CAD model of design 95.
    pub cad: Scene,
    /// Errata of the thesis as a Markdown table.
    pub errata: &'static str,
}

/// Returns a function that converts the error of a step.
fn step_error<E: Display>(step: &'static str) -> impl Fn(E) -> StudyError {
    move |reason| StudyError::Failed(format!("{step} could not be computed: {reason}"))
}

/// Computes all results on the given number of threads (0: one per core). The monitor has counted the simulations as the
/// first of [`STEPS`] steps.
///
/// # Errors
/// Returns an error if a step fails, which is a bug because all inputs are shipped, or if the monitor stops the
/// computation.
pub fn reproduce(input: Input, quick: bool, threads: usize, monitor: &Monitor) -> Result<Reproduction, StudyError> {
    let Input { simulations, chosen, cad, errata } = input;
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
    let points = if quick { QUICK_RESOLUTION } else { RESOLUTION };
    let request = VolumeRequest { axes: Axes::thesis([points; 3]), ..VolumeRequest::thesis() };
    // The designs are not parts of the reproduction.
    let silent = Monitor::silent(monitor.keep_running());
    let volumes = compute_volumes(&request, threads, &silent).map_err(|error| match error {
        StudyError::Stopped { .. } => monitor.stopped(),
        error => error,
    })?;
    let grids = designs::grids(&sizing, monitor)?;
    start_step("runs that are near-chaotic")?;
    let (checked_runs, near_chaotic) = chaos::chaos(&simulations, threads, monitor)?;
    let mut checks = Checks::default();
    checked_runs.iter().for_each(|(index, check)| checks.add(simulations.runs[*index].run, check));
    start_step("design 95")?;
    let (chosen, cad) = (closing::closing("design 95", &chosen)?, closing::closing("CAD model", &cad)?);
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
