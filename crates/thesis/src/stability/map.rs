//! Grid and results of the stability map.

use serde::Serialize;

/// Grid of the map: steps from long to short, factors from small to large.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Grid {
    pub steps_s: Vec<f64>,
    pub stiffness_factors: Vec<f64>,
    pub damping_factors: Vec<f64>,
}

impl Grid {
    /// Returns the standard grid; `quick` omits the two shortest steps.
    pub fn standard(quick: bool) -> Self {
        let mut steps_s = vec![1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6];
        steps_s.truncate(if quick { 5 } else { 7 });
        Grid { steps_s, stiffness_factors: vec![1e-2, 1.0, 1e2, 1e4], damping_factors: vec![0.0, 1e-3, 1.0, 10.0] }
    }

    /// Returns pairs of stiffness and damping factors; stiffness varies fastest.
    pub(super) fn columns(&self) -> Vec<(f64, f64)> {
        let pairs = |&damping: &f64| self.stiffness_factors.iter().map(move |&stiffness| (stiffness, damping));
        self.damping_factors.iter().flat_map(pairs).collect()
    }
}

/// Verdict on a run of the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    Accurate,
    Inaccurate,
    Failed,
    #[default]
    NotJudged,
}

impl Verdict {
    pub const ALL: [Verdict; 4] = [Verdict::Accurate, Verdict::Inaccurate, Verdict::Failed, Verdict::NotJudged];

    /// Returns the label in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Accurate => "stable, accurate",
            Verdict::Inaccurate => "stable, inaccurate",
            Verdict::Failed => "failed",
            Verdict::NotJudged => "not judged",
        }
    }
}

/// One run of the engine; a row of the CSV file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Cell {
    pub step_s: f64,
    pub stiffness_factor: f64,
    pub damping_factor: f64,
    pub verdict: Verdict,
    /// Largest difference of any joint angle up to the end of the run; `None` if it is not finite or unknown.
    pub angle_error_rad: Option<f64>,
    /// Spurious mechanical energy, J.
    pub energy_created_j: f64,
    /// Spurious mechanical energy relative to the energy exchanged in the reference run.
    pub energy_created: f64,
    /// Largest magnitude of the energy balance relative to the energy exchanged in the reference run.
    pub energy_balance: f64,
    pub loop_gap_m: f64,
    pub steps: u64,
    pub contact_substeps: u64,
    pub wall_s: f64,
    /// Reason why the run failed or was not judged.
    pub reason: Option<String>,
}

/// One run of the analytic model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReferenceRun {
    pub stiffness_factor: f64,
    pub damping_factor: f64,
    pub steps: u64,
    pub touchdowns: [u32; 2],
    /// Energy throughput: largest mechanical energy in the system at any time.
    pub throughput_j: f64,
    /// Largest change of any joint angle for a relative increase of the motor torque by 1e-9; `None` if unknown.
    pub sensitivity_rad: Option<f64>,
    pub wall_s: f64,
    /// Reason why the run was not completed.
    pub reason: Option<String>,
}

/// Stability map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stability {
    pub scene: String,
    pub accuracy_rad: f64,
    pub duration_s: f64,
    pub until_s: f64,
    /// Contact stiffness k of the scene, proximal and distal, N/m^e.
    pub stiffness_si: [f64; 2],
    /// Largest contact damping c_max of the scene, proximal and distal.
    pub damping_max_n_s_per_m: [f64; 2],
    pub grid: Grid,
    pub references: Vec<ReferenceRun>,
    /// Cells; the step varies fastest, then stiffness, then damping.
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
