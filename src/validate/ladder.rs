//! The solver configurations of the ladder: both models, from coarse to fine.

use super::ensemble_size;
use super::scenes::{contact_static_friction, is_single_finger, modify, reference_scene};
use crate::scene::ENGINE_MAX_STEP_S;
use crate::scene::{Construction, Engine, Integrator, Method, Preset, Response, Scene, Stepping};
use crate::trace::Model;

/// Configurations with more predicted steps than this are skipped.
pub const MAX_PREDICTED_STEPS: f64 = 2e6;
/// Finer configurations are run after a failed verdict only up to this number of predicted steps.
const MAX_FINER_STEPS: f64 = 2e5;
/// Configurations with more fixed steps than this are run once instead of with the whole ensemble.
const MAX_ENSEMBLE_STEPS: f64 = 15e3;
/// Shortest fixed step of a quick ladder, s; slightly less than 1e-5 s to allow for rounding.
const MIN_QUICK_STEP_S: f64 = 0.999e-5;

/// Configurations that differ in numerical parameters only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Maximal coordinates, contact laws of the scene, adaptive steps.
    EngineAdaptive,
    /// Maximal coordinates, contact laws of the scene, fixed steps.
    EngineFixed,
    /// Reduced coordinates, contact laws of the scene.
    Reduced,
    /// Contact model of rapier.
    Native,
    Analytic,
}

impl Family {
    pub const ALL: [Family; 5] =
        [Family::EngineAdaptive, Family::EngineFixed, Family::Reduced, Family::Native, Family::Analytic];

    /// Name in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Family::EngineAdaptive => "engine, adaptive steps",
            Family::EngineFixed => "engine, fixed steps",
            Family::Reduced => "engine, reduced coordinates",
            Family::Native => "engine, native contact",
            Family::Analytic => "analytic",
        }
    }

    fn from_engine(engine: &Engine) -> Family {
        match (engine.response, engine.construction, engine.stepping) {
            (Response::Rapier { .. }, ..) => Family::Native,
            (_, Construction::Reduced, _) => Family::Reduced,
            (.., Stepping::Adaptive { .. }) => Family::EngineAdaptive,
            (.., Stepping::Fixed { .. }) => Family::EngineFixed,
        }
    }
}

/// The parameters of a configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Settings {
    Analytic(Integrator),
    Engine(Engine),
}

/// One configuration of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverConfiguration {
    pub family: Family,
    pub settings: Settings,
    /// Whether the scene requests this configuration. Only that configuration is judged.
    pub is_from_scene: bool,
    /// Number of runs; the worst one determines the result.
    pub members: usize,
}

impl SolverConfiguration {
    fn engine(engine: Engine, scene: &Scene) -> Self {
        let is_from_scene = engine == scene.engine;
        let is_long =
            matches!(engine.stepping, Stepping::Fixed { step_s } if scene.duration_s / step_s > MAX_ENSEMBLE_STEPS);
        let members = if is_long && !is_from_scene { 1 } else { ensemble_size(scene) };
        SolverConfiguration {
            family: Family::from_engine(&engine),
            settings: Settings::Engine(engine),
            is_from_scene,
            members,
        }
    }

    fn analytic(integrator: Integrator, scene: &Scene) -> Self {
        let settings = Settings::Analytic(integrator);
        SolverConfiguration { family: Family::Analytic, settings, is_from_scene: false, members: ensemble_size(scene) }
    }

    pub fn model(&self) -> Model {
        match self.settings {
            Settings::Analytic(_) => Model::Analytic,
            Settings::Engine(_) => Model::Engine,
        }
    }

    /// Returns the scene with this configuration.
    pub fn apply(&self, scene: &Scene) -> Scene {
        modify(scene, |scene| match self.settings {
            Settings::Analytic(integrator) => scene.integrator = integrator,
            Settings::Engine(engine) => scene.engine = engine,
        })
    }

    /// Whether this is the reference configuration, which has no error by definition.
    pub fn is_reference(&self) -> bool {
        matches!(self.settings, Settings::Analytic(integrator) if integrator.preset == Preset::Reference)
    }

    /// Predicts the number of steps of a run; `None` if it cannot be predicted. `scene_steps` is the number of steps of
    /// the engine at the scene's own settings.
    pub fn predicted_steps(&self, scene: &Scene, scene_steps: u64) -> Option<f64> {
        match (self.settings, scene.engine.stepping) {
            (Settings::Engine(Engine { stepping: Stepping::Fixed { step_s }, .. }), _) => {
                Some(scene.duration_s / step_s)
            }
            (
                Settings::Engine(Engine { stepping: Stepping::Adaptive { tolerance_m, .. }, .. }),
                Stepping::Adaptive { tolerance_m: scene_tolerance_m, .. },
            ) => Some(scene_steps as f64 * (scene_tolerance_m / tolerance_m).sqrt()),
            _ => None,
        }
    }
}

/// Returns the configuration that the scene requests.
pub fn scene_configuration(scene: &Scene) -> SolverConfiguration {
    SolverConfiguration::engine(scene.engine, scene)
}

/// Returns the configuration of the reference.
pub fn reference_configuration(scene: &Scene) -> SolverConfiguration {
    SolverConfiguration::analytic(reference_scene(scene).integrator, scene)
}

/// Returns the name of a configuration without its family.
pub fn configuration_name(configuration: &SolverConfiguration) -> String {
    match configuration.settings {
        Settings::Analytic(Integrator { method: Method::Rodas5p, rtol, .. }) => format!("rodas5p rtol {rtol:e}"),
        Settings::Analytic(Integrator { method: Method::RadauIIa5, rtol, .. }) => format!("radau5 rtol {rtol:e}"),
        Settings::Engine(Engine { stepping: Stepping::Fixed { step_s }, .. }) => format!("dt {step_s:e} s"),
        Settings::Engine(Engine { stepping: Stepping::Adaptive { tolerance_m, max_step_s }, .. }) => {
            let tolerance = format!("tolerance {tolerance_m:e} m");
            match max_step_s == ENGINE_MAX_STEP_S {
                true => tolerance,
                false => format!("{tolerance}, dt to {max_step_s:e} s"),
            }
        }
    }
}

/// Returns the keys of `[engine]` for this stepping, for a scene with the same kind of stepping.
pub fn engine_keys(configuration: &SolverConfiguration) -> String {
    match configuration.settings {
        Settings::Engine(Engine { stepping: Stepping::Fixed { step_s }, .. }) => format!("step = \"{step_s:e} s\""),
        Settings::Engine(Engine { stepping: Stepping::Adaptive { tolerance_m, max_step_s }, .. }) => {
            let max_step = match max_step_s == ENGINE_MAX_STEP_S {
                true => String::new(),
                false => format!(", max_step = \"{max_step_s:e} s\""),
            };
            format!("tolerance = \"{tolerance_m:e} m\"{max_step}")
        }
        Settings::Analytic(_) => configuration_name(configuration),
    }
}

/// Returns all configurations for a scene, grouped by family, including the scene's own. `quick` omits those that take
/// long.
pub fn ladder_configurations(scene: &Scene, quick: bool) -> Vec<SolverConfiguration> {
    let (maximal, reduced) = (Construction::Maximal, Construction::Reduced);
    let mut engines = adaptive_step_engines(scene);
    engines.extend(fixed_step_engines(scene, maximal, Response::Laws, &[1e-4, 1e-5, 1e-6, 1e-7], quick));
    if is_single_finger(scene) && !quick {
        engines.extend(fixed_step_engines(scene, reduced, Response::Laws, &[1e-4, 1e-5, 1e-6], quick));
    }
    if let Some(friction) = contact_static_friction(scene) {
        let native = Response::Rapier { friction, restitution: 0.0 };
        engines.extend(fixed_step_engines(scene, maximal, native, &[1e-4, 1e-5, 1e-6], quick));
    }
    let scene_engine = scene.engine;
    if !engines.contains(&scene_engine) {
        let family = Family::from_engine(&scene_engine);
        let last_of_family = engines.iter().rposition(|engine| Family::from_engine(engine) == family);
        engines.insert(last_of_family.map_or(engines.len(), |index| index + 1), scene_engine);
    }
    let engines = engines.into_iter().map(|engine| SolverConfiguration::engine(engine, scene));
    engines
        .chain(
            analytic_integrators(scene).into_iter().map(|integrator| SolverConfiguration::analytic(integrator, scene)),
        )
        .collect()
}

/// Returns configurations of the engine finer than the scene's, each by a factor of ten, from coarse to fine, up to
/// 200,000 predicted steps. There are none for rapier's own contact model, which does not converge to the scene's
/// contact law.
pub fn finer_configurations(scene: &Scene, scene_steps: u64) -> Vec<SolverConfiguration> {
    if matches!(scene.engine.response, Response::Rapier { .. }) {
        return Vec::new();
    }
    let refine = |factor: f64| match scene.engine.stepping {
        Stepping::Fixed { step_s } => Stepping::Fixed { step_s: scaled(step_s, factor) },
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            // Without joints, the longest step limits the accuracy, not the tolerance.
            let step_factor = if is_single_finger(scene) { 1.0 } else { factor.sqrt() };
            Stepping::Adaptive { tolerance_m: scaled(tolerance_m, factor), max_step_s: scaled(max_step_s, step_factor) }
        }
    };
    let configurations = [0.1, 0.01, 1e-3, 1e-4]
        .map(|factor| SolverConfiguration::engine(Engine { stepping: refine(factor), ..scene.engine }, scene));
    let is_short = |configuration: &SolverConfiguration| {
        configuration.predicted_steps(scene, scene_steps).is_none_or(|steps| steps <= MAX_FINER_STEPS)
    };
    configurations.into_iter().filter(is_short).collect()
}

/// Adaptive stepping with coarser and finer tolerances than the scene's, or than the default if the scene has fixed
/// steps. Without joints, the tolerance rarely limits a step, so the longest step is scaled with its square root.
fn adaptive_step_engines(scene: &Scene) -> Vec<Engine> {
    let stepping = match scene.engine.stepping {
        Stepping::Fixed { .. } => Engine::DEFAULT.stepping,
        adaptive @ Stepping::Adaptive { .. } => adaptive,
    };
    let Stepping::Adaptive { tolerance_m, max_step_s } = stepping else { return Vec::new() };
    let scaled_engine = |[factor, step_factor]: [f64; 2]| {
        let (tolerance_m, max_step_s) = (scaled(tolerance_m, factor), scaled(max_step_s, step_factor));
        engine(scene, Construction::Maximal, Response::Laws, Stepping::Adaptive { tolerance_m, max_step_s })
    };
    match is_single_finger(scene) {
        true => [100.0, 10.0, 1.0, 0.1].map(|factor| scaled_engine([factor, 1.0])).to_vec(),
        false => [[100.0, 10.0], [1.0, 1.0], [0.01, 0.1]].map(scaled_engine).to_vec(),
    }
}

fn fixed_step_engines(
    scene: &Scene,
    construction: Construction,
    response: Response,
    steps_s: &[f64],
    quick: bool,
) -> Vec<Engine> {
    let allowed = steps_s.iter().filter(|&&step_s| !quick || step_s >= MIN_QUICK_STEP_S);
    allowed.map(|&step_s| engine(scene, construction, response, Stepping::Fixed { step_s })).collect()
}

/// Returns the engine of the scene with another construction and stepping. The number of solver iterations is the
/// scene's if its contact model is of the same kind, and the default otherwise.
fn engine(scene: &Scene, construction: Construction, response: Response, stepping: Stepping) -> Engine {
    let scene_engine = scene.engine;
    let is_same_contact = matches!(response, Response::Laws) == matches!(scene_engine.response, Response::Laws);
    let iterations = if is_same_contact { scene_engine.iterations } else { Engine::default_iterations(response) };
    Engine { construction, response, stepping, iterations, ..scene_engine }
}

/// Returns the engineering preset with all tolerances scaled, and two configurations with the method of the reference.
fn analytic_integrators(scene: &Scene) -> Vec<Integrator> {
    let (engineering, reference) = (Integrator::preset(Preset::Engineering), reference_scene(scene).integrator);
    let with_rtol = |preset: Integrator, rtol: f64| {
        let factor = rtol / preset.rtol;
        Integrator {
            preset: if factor == 1.0 { preset.preset } else { Preset::Engineering },
            rtol,
            atol_angle_rad: scaled(preset.atol_angle_rad, factor),
            atol_rate_rad_s: scaled(preset.atol_rate_rad_s, factor),
            max_steps: scene.integrator.max_steps,
            ..preset
        }
    };
    let rodas = [1e-3, 1e-4, 1e-5, 1e-6, 1e-8].map(|rtol| with_rtol(engineering, rtol));
    let radau = [1e-8, reference.rtol].map(|rtol| with_rtol(reference, rtol));
    rodas.into_iter().chain(radau).collect()
}

/// Returns a value times a power of ten, rounded to ten digits so that tables show no rounding errors.
fn scaled(value: f64, factor: f64) -> f64 {
    if factor == 1.0 { value } else { format!("{:.9e}", value * factor).parse().unwrap_or(value * factor) }
}
