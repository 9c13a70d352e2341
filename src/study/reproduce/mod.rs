//! The thesis's figures again: sizing, designs, statics, volumes, the 384 simulations, selection, design 95 and its CAD
//! model, each beside what the thesis prints.
//!
//! | file | job |
//! |---|---|
//! | `thesis` | the thesis's figures with their sources, what is expected, and the reasons for differences (`thesis.csv`, `reasons.toml`) |
//! | `sizing` | spring and motor of design 95; places and types of the spring over all designs |
//! | `designs` | masses, trajectories and statics of the 192 designs, also by other sizings |
//! | `grids` | volumes with points elsewhere and by other torques |
//! | `chaos` | the simulations again: their checks, and which of them change their class with method, tolerance or torque |
//! | `checks` | what the checks found |
//! | `chosen` | design 95 as printed, and its CAD model |
//! | `measured` | everything found, by the keys of the figures |
//!
//! Everything is computed from the shipped study and scenes, which are part of the program.

mod chaos;
mod checks;
mod chosen;
mod designs;
mod grids;
mod measured;
mod sizing;
mod thesis;

use std::collections::HashSet;

pub use chaos::{Chaos, DRIFT_S, Flip, Variation};
pub use checks::Checks;
pub use chosen::{Closing, ClosingPoint};
pub use designs::{Designs, OtherSizing};
pub use grids::{CELLS, Grid};
pub use measured::{CHOSEN, measured};
pub use sizing::SizingFound;
pub use thesis::{Figure, Reason, UNITS, figures, reasons};

use super::select::{Selection, SelectionCriteria, select};
use super::sweep::{self, Study};
use super::volume::{self, Volume, VolumeRequest};
use crate::scene::{self, Scene};
use crate::table::Table;

/// The study of the thesis and the scenes of its chosen design.
const STUDY: &str = include_str!("../../../scenes/studies/thesis.toml");

/// Points of a volume along each axis, and in a quick reproduction.
pub const RESOLUTION: usize = 20;
pub const QUICK_RESOLUTION: usize = 10;

/// Everything that was found.
#[derive(Clone, Debug)]
pub struct Reproduction {
    /// Coarser volumes.
    pub quick: bool,
    pub sizing: SizingFound,
    pub designs: Designs,
    pub volumes: Vec<Volume>,
    pub grids: Vec<Grid>,
    /// Results of the 384 simulations, each checked.
    pub results: Table,
    pub checks: Checks,
    pub selection: Selection,
    pub chaos: Chaos,
    /// Design 95 with the printed torques, and its CAD model.
    pub chosen: Closing,
    pub cad: Closing,
}

/// Why there is no reproduction. All of it is shipped with the program, so that any of these is a mistake in the program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what} could not be computed: {reason}")]
pub struct ReproduceError {
    pub what: &'static str,
    pub reason: String,
}

impl ReproduceError {
    fn of(what: &'static str) -> impl Fn(&dyn std::fmt::Display) -> ReproduceError {
        move |reason| ReproduceError { what, reason: reason.to_string() }
    }
}

/// The reason of a reproduction that was told to stop.
const STOPPED: &str = "it was told to stop";

/// The parts of a reproduction, for whoever waits.
pub const PARTS: usize = 6;

/// Computes everything on so many threads (0: one for each core) while it may `go_on`, and `show`s which part comes next.
///
/// # Errors
/// What could not be computed, or that it was told to stop.
pub fn reproduce(
    quick: bool,
    threads: usize,
    show: &mut dyn FnMut(usize, usize, &str),
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Reproduction, ReproduceError> {
    let mut part = 0;
    let mut next = |name: &'static str| {
        show(part, PARTS, name);
        part += 1;
        if go_on() { Ok(()) } else { Err(ReproduceError::of(name)(&STOPPED)) }
    };
    let mut study = sweep::parse(STUDY, "thesis.toml").map_err(|error| ReproduceError::of("the study")(&error))?;
    // Their checks come with the variations, which are runs of the checks.
    study.checked = false;
    next("the 384 simulations")?;
    let mut results = swept(&study, threads, go_on)?;
    let scenes = scenes(&study)?;
    let selection =
        select(&results, &SelectionCriteria::default()).map_err(|error| ReproduceError::of("the selection")(&error))?;
    next("sizing")?;
    let chosen_run = (measured::CHOSEN - 1) as usize;
    let sizing = sizing::sizing(&scenes[..scenes.len() / 2], &scenes[chosen_run])?;
    next("statics")?;
    let designs = designs::designs(&scenes, &results, &selection, chosen_run, &sizing)?;
    next("grasp-state volumes")?;
    let volumes = volumes(quick, threads, go_on)?;
    let grids = grids::grids(&sizing, go_on)?;
    next("runs that are near-chaotic")?;
    let (checks, chaos) = chaos::chaos(&scenes, &mut results, &selection, threads, go_on)?;
    next("design 95")?;
    let (chosen, cad) = (chosen::chosen()?, chosen::cad()?);
    Ok(Reproduction { quick, sizing, designs, volumes, grids, results, checks, selection, chaos, chosen, cad })
}

/// The scene of every run.
fn scenes(study: &Study) -> Result<Vec<Scene>, ReproduceError> {
    let parsed = (1..=study.runs()).map(|run| scene::parse(&study.scene_text(run), "run.toml"));
    parsed.collect::<Result<_, _>>().map_err(|error| ReproduceError::of("a scene of the study")(&error))
}

fn swept(study: &Study, threads: usize, go_on: &(dyn Fn() -> bool + Sync)) -> Result<Table, ReproduceError> {
    let mut rows = Vec::new();
    let take = |row| {
        rows.push(row);
        true
    };
    let ran = sweep::run_while(study, threads, study.runs(), &HashSet::new(), go_on, take);
    if !ran.complete {
        return Err(ReproduceError::of("the sweep")(&STOPPED));
    }
    Ok(sweep::table(study, &rows))
}

fn volumes(quick: bool, threads: usize, go_on: &dyn Fn() -> bool) -> Result<Vec<Volume>, ReproduceError> {
    let points = if quick { QUICK_RESOLUTION } else { RESOLUTION };
    let request = VolumeRequest { axes: volume::Axes::thesis([points; 3]), ..VolumeRequest::thesis() };
    volume::volumes_with(&request, threads, &mut |_, _| (), go_on)
        .map_err(|error| ReproduceError::of("the volumes")(&error))
}
