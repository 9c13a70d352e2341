//! The 384 simulations of the thesis and their selection, as the caller computes them by a sweep.

use crate::criteria::Class;
use crate::format::report::Report;
use crate::scene::Scene;

/// Number of the design that the thesis chooses.
pub(crate) const CHOSEN_DESIGN: i64 = 95;

/// Results of the study of the thesis.
#[derive(Clone, Debug)]
pub struct Simulations {
    /// All runs: first every design without friction, then every design with friction, in the same order.
    pub runs: Vec<Run>,
    /// Names of the two conditions.
    pub conditions: Vec<String>,
    /// Smallest and largest mass of the designs.
    pub mass_kg: [f64; 2],
    /// Smallest and largest trajectory of the designs.
    pub trajectory_rad: [f64; 2],
    /// Selection criteria in the order of application: their names, and the numbers of runs that meet them, that do not,
    /// that remain after them, and that only they remove.
    pub criteria: Vec<(String, [usize; 4])>,
    /// Labels of the axes that define a design.
    pub axes: Vec<String>,
    /// Selected runs, best first.
    pub ranking: Vec<RankedRun>,
    /// Pictures of the designs and their selection: names of files and SVG.
    pub pictures: Vec<(&'static str, String)>,
}

impl Simulations {
    /// Counts the runs of a condition with a property.
    pub fn count(&self, condition: usize, property: impl Fn(&Run) -> bool) -> usize {
        self.runs.iter().filter(|run| run.condition == condition && property(run)).count()
    }

    /// Adds a picture of the designs or their selection to a section.
    pub(super) fn add_picture(&self, section: Report, file: &str, caption: &str) -> Report {
        let picture = self.pictures.iter().find(|(name, _)| *name == file);
        section.with_figure(file, caption, picture.map_or(String::new(), |(_, svg)| svg.clone()))
    }

    /// Returns the run of the design that the thesis chooses, without friction.
    pub fn chosen(&self) -> Option<&Run> {
        self.runs.iter().find(|run| run.design == CHOSEN_DESIGN)
    }

    /// Number of designs; both conditions contain all of them.
    pub fn designs(&self) -> usize {
        self.count(0, |_| true)
    }
}

/// One simulation. Missing figures are `None`.
#[derive(Clone, Debug)]
pub struct Run {
    pub run: i64,
    pub design: i64,
    /// Index into the conditions.
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
    /// Final simulated normal forces, N.
    pub f21_n: Option<f64>,
    pub f22_n: Option<f64>,
    /// Palm force from these normal forces, N.
    pub pfp_n: Option<f64>,
}

/// A selected run.
#[derive(Clone, Debug)]
pub struct RankedRun {
    /// Index into the runs.
    pub run: usize,
    pub rank: usize,
    /// Weighted score (4.2).
    pub r_wc: f64,
    /// Formatted values of the axes.
    pub axes: Vec<String>,
}

/// Whether a run counts as dynamically stable: stable or semi-stable.
pub fn is_stable(class: Option<Class>) -> bool {
    matches!(class, Some(Class::Stable | Class::SemiStable))
}
