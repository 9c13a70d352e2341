//! The settings that are tried: both models, from coarse to fine.

use super::members;
use super::subject::{is_jointed, reference, touching_friction, with};
use crate::scene::ENGINE_MAX_STEP_S;
use crate::scene::{Construction, Engine, Integrator, Method, Preset, Response, Scene, Stepping};
use crate::trace::Model;

/// A setting that is predicted to need more steps than this is left out.
pub const LONGEST_STEPS: f64 = 2e6;
/// A finer setting is tried, unasked, if it takes no more steps than this.
const FINER_STEPS: f64 = 2e5;
/// A fixed step that makes more steps than this is run once, not with the whole ensemble.
const ONCE_STEPS: f64 = 15e3;
/// Shortest fixed step where there is no time for shorter ones, a little less than 1e-5 s for the sake of the last bit.
const QUICK_STEP_S: f64 = 0.999e-5;

/// Settings that differ in a number only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Maximal construction, scene's laws: steps as long as a tolerance lets them be, or all the same.
    EngineAdaptive,
    EngineFixed,
    /// Reduced construction, scene's laws.
    Reduced,
    /// rapier's own contact.
    Native,
    Analytic,
}

impl Family {
    pub const ALL: [Family; 5] =
        [Family::EngineAdaptive, Family::EngineFixed, Family::Reduced, Family::Native, Family::Analytic];

    /// In tables and pictures.
    pub fn name(self) -> &'static str {
        match self {
            Family::EngineAdaptive => "engine, adaptive steps",
            Family::EngineFixed => "engine, fixed steps",
            Family::Reduced => "engine, reduced coordinates",
            Family::Native => "engine, native contact",
            Family::Analytic => "analytic",
        }
    }

    fn of(engine: &Engine) -> Family {
        match (engine.response, engine.construction, engine.stepping) {
            (Response::Rapier { .. }, ..) => Family::Native,
            (_, Construction::Reduced, _) => Family::Reduced,
            (.., Stepping::Adaptive { .. }) => Family::EngineAdaptive,
            (.., Stepping::Fixed { .. }) => Family::EngineFixed,
        }
    }
}

/// What a setting sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Settings {
    Analytic(Integrator),
    Engine(Engine),
}

/// One setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rung {
    pub family: Family,
    pub settings: Settings,
    /// Whether this is what the scene asks for: the setting that is judged.
    pub own: bool,
    /// Runs of which the worst counts.
    pub members: usize,
}

impl Rung {
    fn engine(engine: Engine, scene: &Scene) -> Self {
        let own = engine == scene.engine;
        let long = matches!(engine.stepping, Stepping::Fixed { step_s } if scene.duration_s / step_s > ONCE_STEPS);
        let members = if long && !own { 1 } else { members(scene) };
        Rung { family: Family::of(&engine), settings: Settings::Engine(engine), own, members }
    }

    fn analytic(integrator: Integrator, scene: &Scene) -> Self {
        let settings = Settings::Analytic(integrator);
        Rung { family: Family::Analytic, settings, own: false, members: members(scene) }
    }

    pub fn model(&self) -> Model {
        match self.settings {
            Settings::Analytic(_) => Model::Analytic,
            Settings::Engine(_) => Model::Engine,
        }
    }

    /// The scene with this setting.
    pub fn apply(&self, scene: &Scene) -> Scene {
        with(scene, |scene| match self.settings {
            Settings::Analytic(integrator) => scene.integrator = integrator,
            Settings::Engine(engine) => scene.engine = engine,
        })
    }

    /// Whether this is the reference: it has no error to speak of.
    pub fn is_reference(&self) -> bool {
        matches!(self.settings, Settings::Analytic(integrator) if integrator.preset == Preset::Reference)
    }

    /// Steps a run will take, as far as that can be told; `own` is what the scene's own engine run took.
    pub fn predicted_steps(&self, scene: &Scene, own: u64) -> Option<f64> {
        match (self.settings, scene.engine.stepping) {
            (Settings::Engine(Engine { stepping: Stepping::Fixed { step_s }, .. }), _) => {
                Some(scene.duration_s / step_s)
            }
            (
                Settings::Engine(Engine { stepping: Stepping::Adaptive { tolerance_m, .. }, .. }),
                Stepping::Adaptive { tolerance_m: usual_m, .. },
            ) => Some(own as f64 * (usual_m / tolerance_m).sqrt()),
            _ => None,
        }
    }
}

/// The setting the scene asks for.
pub fn own(scene: &Scene) -> Rung {
    Rung::engine(scene.engine, scene)
}

/// The setting of the reference.
pub fn of_reference(scene: &Scene) -> Rung {
    Rung::analytic(reference(scene).integrator, scene)
}

/// A setting in few words, without its family.
pub fn name(rung: &Rung) -> String {
    match rung.settings {
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

/// Keys of `[engine]` with which the engine is stepped like this, for a scene of the same kind of stepping.
pub fn keys(rung: &Rung) -> String {
    match rung.settings {
        Settings::Engine(Engine { stepping: Stepping::Fixed { step_s }, .. }) => format!("step = \"{step_s:e} s\""),
        Settings::Engine(Engine { stepping: Stepping::Adaptive { tolerance_m, max_step_s }, .. }) => {
            let longest = match max_step_s == ENGINE_MAX_STEP_S {
                true => String::new(),
                false => format!(", max_step = \"{max_step_s:e} s\""),
            };
            format!("tolerance = \"{tolerance_m:e} m\"{longest}")
        }
        Settings::Analytic(_) => name(rung),
    }
}

/// All settings for a scene, family by family; `quick` leaves out those that take long. The scene's own is among them.
pub fn ladder(scene: &Scene, quick: bool) -> Vec<Rung> {
    let (maximal, reduced) = (Construction::Maximal, Construction::Reduced);
    let mut engines = adaptive(scene);
    engines.extend(fixed(scene, maximal, Response::Laws, &[1e-4, 1e-5, 1e-6, 1e-7], quick));
    if is_jointed(scene) && !quick {
        engines.extend(fixed(scene, reduced, Response::Laws, &[1e-4, 1e-5, 1e-6], quick));
    }
    if let Some(friction) = touching_friction(scene) {
        let native = Response::Rapier { friction, restitution: 0.0 };
        engines.extend(fixed(scene, maximal, native, &[1e-4, 1e-5, 1e-6], quick));
    }
    let own = scene.engine;
    if !engines.contains(&own) {
        let family = Family::of(&own);
        let place = engines.iter().rposition(|engine| Family::of(engine) == family);
        engines.insert(place.map_or(engines.len(), |place| place + 1), own);
    }
    let engines = engines.into_iter().map(|engine| Rung::engine(engine, scene));
    engines.chain(analytic(scene).into_iter().map(|integrator| Rung::analytic(integrator, scene))).collect()
}

/// Settings of the engine finer than the scene's, each by a factor of ten, coarse to fine, as long as they take few steps; none for
/// rapier's own contact, since no step makes it follow the scene's law.
pub fn finer_settings(scene: &Scene, own_steps: u64) -> Vec<Rung> {
    if matches!(scene.engine.response, Response::Rapier { .. }) {
        return Vec::new();
    }
    let finer = |factor: f64| match scene.engine.stepping {
        Stepping::Fixed { step_s } => Stepping::Fixed { step_s: scaled(step_s, factor) },
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            // Without joints the longest step decides, not the tolerance.
            let longer = if is_jointed(scene) { 1.0 } else { factor.sqrt() };
            Stepping::Adaptive { tolerance_m: scaled(tolerance_m, factor), max_step_s: scaled(max_step_s, longer) }
        }
    };
    let rungs =
        [0.1, 0.01, 1e-3, 1e-4].map(|factor| Rung::engine(Engine { stepping: finer(factor), ..scene.engine }, scene));
    let is_short = |rung: &Rung| rung.predicted_steps(scene, own_steps).is_none_or(|steps| steps <= FINER_STEPS);
    rungs.into_iter().filter(is_short).collect()
}

/// Tolerances around the scene's own, or around the usual one where its steps are fixed. Bodies without joints are rarely
/// held back by the tolerance: there the longest step goes with it, as its square root.
fn adaptive(scene: &Scene) -> Vec<Engine> {
    let stepping = match scene.engine.stepping {
        Stepping::Fixed { .. } => Engine::DEFAULT.stepping,
        adaptive @ Stepping::Adaptive { .. } => adaptive,
    };
    let Stepping::Adaptive { tolerance_m, max_step_s } = stepping else { return Vec::new() };
    let at = |[factor, longer]: [f64; 2]| {
        let (tolerance_m, max_step_s) = (scaled(tolerance_m, factor), scaled(max_step_s, longer));
        engine(scene, Construction::Maximal, Response::Laws, Stepping::Adaptive { tolerance_m, max_step_s })
    };
    match is_jointed(scene) {
        true => [100.0, 10.0, 1.0, 0.1].map(|factor| at([factor, 1.0])).to_vec(),
        false => [[100.0, 10.0], [1.0, 1.0], [0.01, 0.1]].map(at).to_vec(),
    }
}

fn fixed(scene: &Scene, construction: Construction, response: Response, steps_s: &[f64], quick: bool) -> Vec<Engine> {
    let coarse = steps_s.iter().filter(|&&step_s| !quick || step_s >= QUICK_STEP_S);
    coarse.map(|&step_s| engine(scene, construction, response, Stepping::Fixed { step_s })).collect()
}

/// The engine of the scene built and stepped in another way; sweeps are the scene's where its contact is of the same
/// kind.
fn engine(scene: &Scene, construction: Construction, response: Response, stepping: Stepping) -> Engine {
    let own = scene.engine;
    let same = matches!(response, Response::Laws) == matches!(own.response, Response::Laws);
    let iterations = if same { own.iterations } else { Engine::usual_iterations(response) };
    Engine { construction, response, stepping, iterations, ..own }
}

/// The everyday preset loosened and tightened as a whole, and two of the method of the reference.
fn analytic(scene: &Scene) -> Vec<Integrator> {
    let (usual, reference) = (Integrator::preset(Preset::Engineering), reference(scene).integrator);
    let at = |preset: Integrator, rtol: f64| {
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
    let rodas = [1e-3, 1e-4, 1e-5, 1e-6, 1e-8].map(|rtol| at(usual, rtol));
    let radau = [1e-8, reference.rtol].map(|rtol| at(reference, rtol));
    rodas.into_iter().chain(radau).collect()
}

/// A value times a power of ten, without the last bit's dust in tables.
fn scaled(value: f64, factor: f64) -> f64 {
    if factor == 1.0 { value } else { format!("{:.9e}", value * factor).parse().unwrap_or(value * factor) }
}
