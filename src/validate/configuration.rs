//! Solver configurations of both models, from coarse to fine, and their results.

use serde::Serialize;

use super::Differences;
use super::scenes::{contact_static_friction, ensemble_size, is_single_finger, modify, reference_scene};
use crate::log::Solver;
use crate::scene::ENGINE_MAX_STEP_S;
use crate::scene::{Engine, Integrator, Method, Preset, Response, Scene, Stepping};
use crate::trace::Model;

/// Configurations with more predicted steps than this are skipped.
pub(crate) const MAX_PREDICTED_STEPS: f64 = 2e6;
/// Finer configurations are run after a failed verdict only up to this number of predicted steps.
const MAX_FINER_STEPS: f64 = 2e5;
/// Configurations with more fixed steps than this are run once instead of with the whole ensemble.
const MAX_ENSEMBLE_STEPS: f64 = 15e3;
/// Shortest fixed step of a quick ladder, s; slightly less than 1e-5 s to allow for rounding.
const MIN_QUICK_STEP_S: f64 = 0.999e-5;

/// A family of configurations, which differ only in numerical parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Contact laws of the scene, adaptive steps.
    EngineAdaptive,
    /// Contact laws of the scene, fixed steps.
    EngineFixed,
    /// Contact model of rapier.
    Native,
    Analytic,
}

impl Family {
    pub const ALL: [Family; 4] = [Family::EngineAdaptive, Family::EngineFixed, Family::Native, Family::Analytic];

    /// Name in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Family::EngineAdaptive => "engine, adaptive steps",
            Family::EngineFixed => "engine, fixed steps",
            Family::Native => "engine, native contact",
            Family::Analytic => "analytic",
        }
    }

    fn from_engine(engine: &Engine) -> Family {
        match (engine.response, engine.stepping) {
            (Response::Rapier { .. }, _) => Family::Native,
            (_, Stepping::Adaptive { .. }) => Family::EngineAdaptive,
            (_, Stepping::Fixed { .. }) => Family::EngineFixed,
        }
    }
}

/// One configuration of the solver of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverConfiguration {
    pub family: Family,
    pub settings: Solver,
    /// Whether the scene requests this configuration. Only such a configuration is judged.
    pub is_from_scene: bool,
    /// Number of runs in the ensemble. The worst run determines the result.
    pub members: usize,
}

impl SolverConfiguration {
    fn engine(engine: Engine, scene: &Scene) -> Self {
        let is_from_scene = engine == scene.engine;
        let is_long =
            matches!(engine.stepping, Stepping::Fixed { step_s } if scene.duration_s / step_s > MAX_ENSEMBLE_STEPS);
        let members = if is_long && !is_from_scene { 1 } else { ensemble_size(scene) };
        let (family, settings) = (Family::from_engine(&engine), Solver::Engine(engine));
        SolverConfiguration { family, settings, is_from_scene, members }
    }

    fn analytic(integrator: Integrator, scene: &Scene) -> Self {
        let settings = Solver::Analytic(integrator);
        SolverConfiguration { family: Family::Analytic, settings, is_from_scene: false, members: ensemble_size(scene) }
    }

    pub fn model(&self) -> Model {
        match self.settings {
            Solver::Analytic(_) => Model::Analytic,
            Solver::Engine(_) => Model::Engine,
        }
    }

    /// Returns the scene, changed to this configuration.
    pub fn apply(&self, scene: &Scene) -> Scene {
        modify(scene, |scene| match self.settings {
            Solver::Analytic(integrator) => scene.integrator = integrator,
            Solver::Engine(engine) => scene.engine = engine,
        })
    }

    /// Whether this is the reference configuration. By definition, it has no error.
    pub fn is_reference(&self) -> bool {
        matches!(self.settings, Solver::Analytic(integrator) if integrator.preset == Preset::Reference)
    }

    /// Predicts the number of steps of a run; `None` if it cannot be predicted. `scene_steps` is the number of steps of
    /// the engine at the scene's own settings.
    pub(crate) fn predicted_steps(&self, scene: &Scene, scene_steps: u64) -> Option<f64> {
        let Solver::Engine(Engine { stepping, .. }) = self.settings else { return None };
        match (stepping, scene.engine.stepping) {
            (Stepping::Fixed { step_s }, _) => Some(scene.duration_s / step_s),
            (Stepping::Adaptive { tolerance_m, .. }, Stepping::Adaptive { tolerance_m: of_scene_m, .. }) => {
                Some(scene_steps as f64 * (of_scene_m / tolerance_m).sqrt())
            }
            _ => None,
        }
    }
}

/// Returns the configuration that the scene requests.
pub(crate) fn scene_configuration(scene: &Scene) -> SolverConfiguration {
    SolverConfiguration::engine(scene.engine, scene)
}

/// Returns the configuration of the reference.
pub fn reference_configuration(scene: &Scene) -> SolverConfiguration {
    SolverConfiguration::analytic(reference_scene(scene).integrator, scene)
}

/// Parameters that distinguish a configuration within its family: label, key in `[engine]`, and value.
fn parameters(configuration: &SolverConfiguration) -> Vec<(&'static str, &'static str, String)> {
    match configuration.settings {
        Solver::Analytic(Integrator { method, rtol, .. }) => {
            let label = if method == Method::Rodas5p { "rodas5p rtol" } else { "radau5 rtol" };
            vec![(label, "rtol", format!("{rtol:e}"))]
        }
        Solver::Engine(Engine { stepping: Stepping::Fixed { step_s }, .. }) => {
            vec![("dt", "step", format!("{step_s:e} s"))]
        }
        Solver::Engine(Engine { stepping: Stepping::Adaptive { tolerance_m, max_step_s }, .. }) => {
            let max_step = ("dt to", "max_step", format!("{max_step_s:e} s"));
            let max_step = (max_step_s != ENGINE_MAX_STEP_S).then_some(max_step);
            [Some(("tolerance", "tolerance", format!("{tolerance_m:e} m"))), max_step].into_iter().flatten().collect()
        }
    }
}

/// Returns the name of a configuration without its family.
pub(crate) fn configuration_name(configuration: &SolverConfiguration) -> String {
    let names = parameters(configuration).into_iter().map(|(label, _, value)| format!("{label} {value}"));
    names.collect::<Vec<_>>().join(", ")
}

/// Returns the keys of `[engine]` for this stepping, for a scene with the same kind of stepping.
pub(super) fn engine_keys(configuration: &SolverConfiguration) -> String {
    let keys = parameters(configuration).into_iter().map(|(_, key, value)| format!("{key} = \"{value}\""));
    keys.collect::<Vec<_>>().join(", ")
}

/// Returns all configurations for a scene, grouped by family, including that of the scene itself. With `quick`,
/// configurations that take long are omitted.
pub fn ladder_configurations(scene: &Scene, quick: bool) -> Vec<SolverConfiguration> {
    // The number of solver iterations is the scene's if its contact model is of the same kind.
    let engine = |response: Response, stepping: Stepping| {
        let is_same_contact = matches!(response, Response::Laws) == matches!(scene.engine.response, Response::Laws);
        let iterations = if is_same_contact { scene.engine.iterations } else { Engine::default_iterations(response) };
        Engine { response, stepping, iterations, ..scene.engine }
    };
    let fixed = |response: Response, steps_s: &[f64]| {
        let allowed = steps_s.iter().filter(|&&step_s| !quick || step_s >= MIN_QUICK_STEP_S);
        allowed.map(|&step_s| engine(response, Stepping::Fixed { step_s })).collect::<Vec<_>>()
    };
    // Adaptive steps are coarser and finer than the scene's, or than the default if the scene has fixed steps.
    let adaptive = match scene.engine.stepping {
        Stepping::Fixed { .. } => Engine::DEFAULT.stepping,
        adaptive @ Stepping::Adaptive { .. } => adaptive,
    };
    let factors: &[f64] = if is_single_finger(scene) { &[100.0, 10.0, 1.0, 0.1] } else { &[100.0, 1.0, 0.01] };
    let scaled = factors.iter().map(|&factor| scaled_stepping(scene, adaptive, factor));
    let mut engines: Vec<Engine> = scaled.map(|stepping| engine(Response::Laws, stepping)).collect();
    engines.extend(fixed(Response::Laws, &[1e-4, 1e-5, 1e-6, 1e-7]));
    if let Some(friction) = contact_static_friction(scene) {
        engines.extend(fixed(Response::Rapier { friction, restitution: 0.0 }, &[1e-4, 1e-5, 1e-6]));
    }
    if !engines.contains(&scene.engine) {
        let family = Family::from_engine(&scene.engine);
        let last_of_family = engines.iter().rposition(|engine| Family::from_engine(engine) == family);
        engines.insert(last_of_family.map_or(engines.len(), |index| index + 1), scene.engine);
    }
    // The engineering preset with all tolerances scaled, and two configurations with the method of the reference.
    let (engineering, reference) = (Integrator::preset(Preset::Engineering), reference_scene(scene).integrator);
    let with_rtol = |preset: Integrator, rtol: f64| {
        let factor = rtol / preset.rtol;
        Integrator {
            preset: if factor == 1.0 { preset.preset } else { Preset::Engineering },
            rtol,
            atol_angle_rad: rounded(preset.atol_angle_rad, factor),
            atol_rate_rad_s: rounded(preset.atol_rate_rad_s, factor),
            max_steps: scene.integrator.max_steps,
            ..preset
        }
    };
    let rodas = [1e-3, 1e-4, 1e-5, 1e-6, 1e-8].map(|rtol| with_rtol(engineering, rtol));
    let radau = [1e-8, reference.rtol].map(|rtol| with_rtol(reference, rtol));
    let analytic = rodas.into_iter().chain(radau).map(|integrator| SolverConfiguration::analytic(integrator, scene));
    engines.into_iter().map(|engine| SolverConfiguration::engine(engine, scene)).chain(analytic).collect()
}

/// Returns configurations of the engine finer than the scene's, each by a factor of ten, from coarse to fine, up to
/// 200,000 predicted steps. There are none for rapier's own contact model, which does not converge to the scene's
/// contact law.
pub(crate) fn finer_configurations(scene: &Scene, scene_steps: u64) -> Vec<SolverConfiguration> {
    if matches!(scene.engine.response, Response::Rapier { .. }) {
        return Vec::new();
    }
    let refine = |factor: f64| {
        let stepping = scaled_stepping(scene, scene.engine.stepping, factor);
        SolverConfiguration::engine(Engine { stepping, ..scene.engine }, scene)
    };
    let is_short = |configuration: &SolverConfiguration| {
        configuration.predicted_steps(scene, scene_steps).is_none_or(|steps| steps <= MAX_FINER_STEPS)
    };
    [0.1, 0.01, 1e-3, 1e-4].map(refine).into_iter().filter(is_short).collect()
}

/// Returns a stepping with its step or tolerance scaled. Without joints, the tolerance rarely limits a step, so the
/// longest step is scaled with its square root.
fn scaled_stepping(scene: &Scene, stepping: Stepping, factor: f64) -> Stepping {
    let step_factor = if is_single_finger(scene) { 1.0 } else { factor.sqrt() };
    match stepping {
        Stepping::Fixed { step_s } => Stepping::Fixed { step_s: rounded(step_s, factor) },
        Stepping::Adaptive { tolerance_m, max_step_s } => Stepping::Adaptive {
            tolerance_m: rounded(tolerance_m, factor),
            max_step_s: rounded(max_step_s, step_factor),
        },
    }
}

/// Returns a value times a factor, rounded to ten digits so that tables show no rounding errors.
fn rounded(value: f64, factor: f64) -> f64 {
    if factor == 1.0 { value } else { format!("{:.9e}", value * factor).parse().unwrap_or(value * factor) }
}

/// Whether a configuration was evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    Done,
    Failed,
    /// Skipped because it is predicted to take more than `MAX_PREDICTED_STEPS`.
    TooLong,
    /// Skipped because it was expected to exceed the time limit of the ladder.
    NoTime,
}

/// Cost of a configuration, measured without any output. All fields are `None` if it was not evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    pub steps: Option<u64>,
    /// Median wall time of the timed runs, s.
    pub wall_s: Option<f64>,
    /// Number of timed runs.
    pub timed_runs: Option<usize>,
    /// Ratio of simulated time to wall time.
    pub real_time_factor: Option<f64>,
    /// Ratio of the wall time to that of the analytic model with its engineering preset. The latter is measured between
    /// the timed runs.
    pub analytic_factor: Option<f64>,
}

/// A configuration, its cost, and its differences from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LadderRow {
    #[serde(skip)]
    pub configuration: SolverConfiguration,
    pub family: &'static str,
    pub setting: String,
    pub model: &'static str,
    /// Whether the scene requests this configuration.
    #[serde(rename = "own")]
    pub is_from_scene: bool,
    /// Whether this configuration is the reference itself.
    #[serde(rename = "reference")]
    pub is_reference: bool,
    pub status: Status,
    /// Reason why the configuration has no results; `None` if it has results.
    pub reason: Option<String>,
    /// Number of runs in the ensemble; the worst run counts.
    pub ensemble_runs: usize,
    #[serde(flatten)]
    pub cost: Cost,
    /// Worst differences of the ensemble; `None` for the reference, or without results.
    #[serde(skip)]
    pub differences: Option<Differences>,
}

impl LadderRow {
    pub(super) fn new(configuration: SolverConfiguration, status: Status, reason: Option<String>) -> Self {
        LadderRow {
            family: configuration.family.name(),
            setting: configuration_name(&configuration),
            model: configuration.model().name(),
            is_from_scene: configuration.is_from_scene,
            is_reference: configuration.is_reference(),
            status,
            reason,
            ensemble_runs: configuration.members,
            cost: Cost::default(),
            differences: None,
            configuration,
        }
    }
}
