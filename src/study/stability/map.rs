//! What is gone through, and what is found: plain data.

use crate::scene::WrongKind;
use serde::Serialize;

/// What is gone through: steps from long to short, factors from small to large.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Grid {
    pub steps_s: Vec<f64>,
    pub stiffness_factors: Vec<f64>,
    pub damping_factors: Vec<f64>,
}

impl Grid {
    /// The usual one; `quick` leaves out the two shortest steps.
    pub fn usual(quick: bool) -> Self {
        let mut steps_s = vec![1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6];
        steps_s.truncate(if quick { 5 } else { 7 });
        Grid { steps_s, stiffness_factors: vec![1e-2, 1.0, 1e2, 1e4], damping_factors: vec![0.0, 1e-3, 1.0, 10.0] }
    }

    pub fn cells(&self) -> usize {
        self.steps_s.len() * self.columns().len()
    }

    /// Pairs of factors, stiffness and damping: all stiffnesses of the first damping, and so on.
    pub(super) fn columns(&self) -> Vec<(f64, f64)> {
        let of = |&damping: &f64| self.stiffness_factors.iter().map(move |&stiffness| (stiffness, damping));
        self.damping_factors.iter().flat_map(of).collect()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    Accurate,
    Inaccurate,
    Failed,
    NotJudged,
}

impl Verdict {
    pub const ALL: [Verdict; 4] = [Verdict::Accurate, Verdict::Inaccurate, Verdict::Failed, Verdict::NotJudged];

    /// In tables and pictures.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Accurate => "stable, accurate",
            Verdict::Inaccurate => "stable, inaccurate",
            Verdict::Failed => "failed",
            Verdict::NotJudged => "not judged",
        }
    }

    /// In files for programs.
    pub fn key(self) -> &'static str {
        match self {
            Verdict::Accurate => "accurate",
            Verdict::Inaccurate => "inaccurate",
            Verdict::Failed => "failed",
            Verdict::NotJudged => "not-judged",
        }
    }
}

/// One run of the engine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    pub step_s: f64,
    pub stiffness_factor: f64,
    pub damping_factor: f64,
    pub verdict: Verdict,
    /// Largest difference of any joint angle, as far as the run came; `None` where it is not finite or unknown.
    pub angle_error_rad: Option<f64>,
    /// Mechanical energy from nowhere, in J and as part of the reference's throughput; the largest |balance| as part of it.
    pub energy_created_j: f64,
    pub energy_created: f64,
    pub energy_balance: f64,
    pub loop_gap_m: f64,
    pub steps: u64,
    pub contact_substeps: u64,
    pub wall_s: f64,
    /// Why it failed or was not judged.
    pub reason: Option<String>,
}

/// One run of the analytic model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceRun {
    pub stiffness_factor: f64,
    pub damping_factor: f64,
    pub steps: u64,
    pub touchdowns: [u32; 2],
    /// Most energy that was ever about.
    pub throughput_j: f64,
    /// Largest change of any joint angle when the motor torque is larger by 1e-9 of itself; `None` if unknown.
    pub sensitivity_rad: Option<f64>,
    pub wall_s: f64,
    /// Why it could not be completed.
    pub reason: Option<String>,
}

/// The whole map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stability {
    pub scene: String,
    pub accuracy_rad: f64,
    pub duration_s: f64,
    pub until_s: f64,
    /// Of the scene, proximal and distal; the unit of k is N/m^e.
    pub stiffness_si: [f64; 2],
    pub damping_max_n_s_per_m: [f64; 2],
    pub grid: Grid,
    pub references: Vec<ReferenceRun>,
    /// Dampings in order, in each the stiffnesses, in each the steps.
    pub cells: Vec<Cell>,
    pub wall_s: f64,
}

impl Stability {
    pub fn cell(&self, step: usize, stiffness: usize, damping: usize) -> &Cell {
        let Grid { steps_s, stiffness_factors, .. } = &self.grid;
        &self.cells[(damping * stiffness_factors.len() + stiffness) * steps_s.len() + step]
    }

    pub fn reference(&self, stiffness: usize, damping: usize) -> &ReferenceRun {
        &self.references[damping * self.grid.stiffness_factors.len() + stiffness]
    }

    pub fn count(&self, verdict: Verdict) -> usize {
        self.cells.iter().filter(|cell| cell.verdict == verdict).count()
    }
}

/// Why there is no map.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "nothing can touch in this scene, and factors of contact stiffness and damping would change nothing; give it an \
         object: [object] radius and centre"
    )]
    NoObject,
    #[error(
        "the engine of this scene answers with rapier's own contact, which knows neither stiffness nor damping; leave out \
         `law = \"rapier\"` under [engine]"
    )]
    Rigid,
    #[error(
        "the step of {step_s:e} s is not shorter than the run of {duration_s:e} s; give shorter steps or a longer `duration`"
    )]
    LongStep { step_s: f64, duration_s: f64 },
    #[error(
        "with steps of {step_s:e} s the run of {duration_s:e} s takes more than {most} steps; give longer steps or a shorter `duration`, or \
         raise max_steps under [engine]"
    )]
    ShortStep { step_s: f64, duration_s: f64, most: u64 },
    #[error(
        "the stiffness factor {stiffness:e} with the damping factor {damping:e} leaves a contact with k = {k:e} and c_max = \
         {c:e}: both must be finite and one of them above 0; give other factors"
    )]
    Law { stiffness: f64, damping: f64, k: f64, c: f64 },
    /// `go_on` said no.
    #[error("stopped after {done} of {total} parts")]
    Stopped { done: usize, total: usize },
}
