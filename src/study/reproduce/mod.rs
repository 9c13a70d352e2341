//! Reproduction of the figures of the thesis: sizing, designs, statics, volumes, the 384 simulations, selection, design
//! 95 and its CAD model, each compared with the printed value.
//!
//! | file | job |
//! |---|---|
//! | `thesis` | figures of the thesis with their sources, expected values, and reasons for differences (`thesis.csv`, `reasons.toml`) |
//! | `sizing` | spring and motor of design 95; placement and type of the spring for all designs |
//! | `designs` | masses, trajectories and statics of the 192 designs, also with other sizings |
//! | `grids` | volumes with points at cell centres and with other torques |
//! | `chaos` | repeated simulations: their checks, and runs whose class depends on method, tolerance or torque |
//! | `checks` | results of the checks |
//! | `chosen` | design 95 as printed, and its CAD model |
//! | `computed_values` | computed values by figure key |
//!
//! Everything is computed from the shipped study and scenes, which are embedded in the program.

mod chaos;
mod checks;
mod chosen;
mod computed_values;
mod designs;
mod grids;
mod sizing;
mod thesis;

use std::collections::HashSet;

pub use chaos::{Chaos, ClassChange, MAX_TTS_DIFFERENCE_S, Variation};
pub use checks::Checks;
pub use chosen::{Closing, ClosingPoint};
pub use computed_values::{CHOSEN_DESIGN, computed_values};
pub use designs::{Designs, OtherSizing};
pub use grids::{CELLS_PER_AXIS, Grid};
pub use sizing::SizingFound;
pub use thesis::{Figure, Reason, UNITS, figures, reasons};

use super::select::{Selection, SelectionCriteria, select};
use super::sweep::{self, Study};
use super::volume::{self, Volume, VolumeRequest};
use crate::scene::{self, Scene};
use crate::table::Table;

/// Study of the thesis.
const STUDY: &str = include_str!("../../../scenes/studies/thesis.toml");

/// Number of points of a volume along each axis.
pub const RESOLUTION: usize = 20;
/// Number of points along each axis in a quick reproduction.
pub const QUICK_RESOLUTION: usize = 10;

/// All results of the reproduction.
#[derive(Clone, Debug)]
pub struct Reproduction {
    /// Whether the volumes are coarser.
    pub quick: bool,
    pub sizing: SizingFound,
    pub designs: Designs,
    pub volumes: Vec<Volume>,
    pub grids: Vec<Grid>,
    /// Results of the 384 simulations, with checks.
    pub results: Table,
    pub checks: Checks,
    pub selection: Selection,
    pub chaos: Chaos,
    /// Design 95 with the printed torques.
    pub chosen: Closing,
    /// CAD model of design 95.
    pub cad: Closing,
}

/// Error during the reproduction. All inputs are embedded in the program, so every error except an interruption is a bug.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{step} could not be computed: {reason}")]
pub struct ReproduceError {
    pub step: &'static str,
    pub reason: String,
}

impl ReproduceError {
    /// Returns a function that converts an error of a step.
    fn in_step(step: &'static str) -> impl Fn(&dyn std::fmt::Display) -> ReproduceError {
        move |reason| ReproduceError { step, reason: reason.to_string() }
    }
}

/// Reason for an interrupted reproduction.
const INTERRUPTED: &str = "interrupted";

/// Number of steps of a reproduction, for progress reports.
pub const STEPS: usize = 6;

/// Computes all results on the given number of threads (0: one per core). `progress` receives the number and the name
/// of each step.
///
/// # Errors
/// Returns an error if a step fails, or `keep_running` returned `false`.
pub fn reproduce(
    quick: bool,
    threads: usize,
    progress: &mut dyn FnMut(usize, usize, &str),
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<Reproduction, ReproduceError> {
    let mut step = 0;
    let mut start_step = |name: &'static str| {
        progress(step, STEPS, name);
        step += 1;
        if keep_running() { Ok(()) } else { Err(ReproduceError::in_step(name)(&INTERRUPTED)) }
    };
    let mut study = sweep::parse(STUDY, "thesis.toml").map_err(|error| ReproduceError::in_step("the study")(&error))?;
    // `chaos` checks the runs later, because its variations include the runs that the checks need.
    study.checked = false;
    start_step("the 384 simulations")?;
    let mut results = run_sweep(&study, threads, keep_running)?;
    let scenes = scenes(&study)?;
    let selection = select(&results, &SelectionCriteria::default())
        .map_err(|error| ReproduceError::in_step("the selection")(&error))?;
    start_step("sizing")?;
    let chosen_run = (computed_values::CHOSEN_DESIGN - 1) as usize;
    let sizing = sizing::sizing(&scenes[..scenes.len() / 2], &scenes[chosen_run])?;
    start_step("statics")?;
    let designs = designs::designs(&scenes, &results, &selection, chosen_run, &sizing)?;
    start_step("grasp-state volumes")?;
    let volumes = volumes(quick, threads, keep_running)?;
    let grids = grids::grids(&sizing, keep_running)?;
    start_step("runs that are near-chaotic")?;
    let (checks, chaos) = chaos::chaos(&scenes, &mut results, &selection, threads, keep_running)?;
    start_step("design 95")?;
    let (chosen, cad) = (chosen::chosen()?, chosen::cad()?);
    Ok(Reproduction { quick, sizing, designs, volumes, grids, results, checks, selection, chaos, chosen, cad })
}

/// Returns the scene of every run.
fn scenes(study: &Study) -> Result<Vec<Scene>, ReproduceError> {
    let parsed = (1..=study.runs()).map(|run| scene::parse(&study.scene_text(run), "run.toml"));
    parsed.collect::<Result<_, _>>().map_err(|error| ReproduceError::in_step("a scene of the study")(&error))
}

fn run_sweep(study: &Study, threads: usize, keep_running: &(dyn Fn() -> bool + Sync)) -> Result<Table, ReproduceError> {
    let mut rows = Vec::new();
    let collect = |row| {
        rows.push(row);
        true
    };
    let ran = sweep::run_while(study, threads, study.runs(), &HashSet::new(), keep_running, collect);
    if !ran.complete {
        return Err(ReproduceError::in_step("the sweep")(&INTERRUPTED));
    }
    Ok(sweep::table(study, &rows))
}

fn volumes(quick: bool, threads: usize, keep_running: &dyn Fn() -> bool) -> Result<Vec<Volume>, ReproduceError> {
    let points = if quick { QUICK_RESOLUTION } else { RESOLUTION };
    let request = VolumeRequest { axes: volume::Axes::thesis([points; 3]), ..VolumeRequest::thesis() };
    volume::volumes_with(&request, threads, &mut |_, _| (), keep_running)
        .map_err(|error| ReproduceError::in_step("the volumes")(&error))
}
