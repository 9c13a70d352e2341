//! What a log says about its run beside the samples: the metadata record and the name of the scene attachment.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::bodies::BodiesChannels;
use super::finger::FingerChannels;
use super::writer::Channels;
use crate::check::{Check, PUSH};
use crate::scene::{
    AnyScene, BodiesScene, Construction, Engine, Integrator, LogRates, Method, Preset, Response, Scene, Stepping,
    Words, parse, parse_any, show, show_bodies,
};

/// Name of the metadata record.
pub const METADATA_NAME: &str = "phalanx";

/// Media type of the scene attachment.
pub const ATTACHMENT_MEDIA_TYPE: &str = "application/toml";

/// The name of the engine model.
const ENGINE: &str = "engine";

/// The version of rapier that is pinned in the manifest.
const RAPIER_VERSION: &str = "0.36.1";

/// A kind of scene as far as a log has to know it.
pub trait Logged: Sized {
    /// Its channels.
    type Channels: Channels<Scene = Self>;

    fn about(&self) -> About<'_>;

    /// The text of a scene file that says what is simulated, but for the settings that the metadata record has: the file as it was
    /// written, or, of a scene that was changed since, one made of it.
    fn text(&self) -> Cow<'_, str>;
}

/// What the log of any scene says about it.
#[derive(Clone, Copy, Debug)]
pub struct About<'a> {
    /// In the words of scene files.
    pub kind: &'static str,
    pub name: &'a str,
    pub duration_s: f64,
    pub rates: LogRates,
    pub integrator: &'a Integrator,
    pub engine: &'a Engine,
}

impl Logged for Scene {
    type Channels = FingerChannels;

    fn about(&self) -> About<'_> {
        About {
            kind: "finger",
            name: &self.name,
            duration_s: self.duration_s,
            rates: self.log,
            integrator: &self.integrator,
            engine: &self.engine,
        }
    }

    fn text(&self) -> Cow<'_, str> {
        let recorded = |read: Scene| Scene {
            name: self.name.clone(),
            source: self.source.clone(),
            duration_s: self.duration_s,
            integrator: self.integrator,
            engine: self.engine,
            bounds: self.bounds,
            log: self.log,
            ..read
        };
        match parse(&self.source, "scene.toml").map(recorded) {
            Ok(written) if written == *self => Cow::Borrowed(&self.source),
            _ => Cow::Owned(show(self)),
        }
    }
}

impl Logged for BodiesScene {
    type Channels = BodiesChannels;

    fn about(&self) -> About<'_> {
        About {
            kind: "bodies",
            name: &self.name,
            duration_s: self.duration_s,
            rates: self.log,
            integrator: &self.integrator,
            engine: &self.engine,
        }
    }

    fn text(&self) -> Cow<'_, str> {
        let recorded = |read: BodiesScene| BodiesScene {
            name: self.name.clone(),
            source: self.source.clone(),
            duration_s: self.duration_s,
            integrator: self.integrator,
            engine: self.engine,
            bounds: self.bounds,
            log: self.log,
            ..read
        };
        match parse_any(&self.source, "scene.toml") {
            Ok(AnyScene::Bodies(written)) if recorded((*written).clone()) == *self => Cow::Borrowed(&self.source),
            _ => Cow::Owned(show_bodies(self)),
        }
    }
}

/// Name of the metadata record that says what a check of the run found; it is there if one was made.
pub const CHECK_NAME: &str = "phalanx-check";

/// The entries of that record; errors in rad, of discs in m.
pub fn check_entries(check: &Check) -> BTreeMap<String, String> {
    let entries = [
        ("verdict", check.verdict.name().to_string()),
        ("error", format!("{:?}", check.errors.path)),
        ("bar", format!("{:?}", check.bar)),
        ("push", format!("{PUSH:?}")),
        ("sensitivity", format!("{:?}", check.sensitivity)),
        ("against", check.against.clone()),
        ("reason", check.reason.clone().unwrap_or_default()),
    ];
    entries.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
}

/// Which run a log is of.
#[derive(Clone, Copy, Debug)]
pub struct RunInfo<'a, S = Scene> {
    pub scene: &'a S,
    /// File name of the scene, without directories: the name of the attachment.
    pub scene_file: &'a str,
    /// `analytic` or `engine`.
    pub model: &'a str,
}

/// The entries of the metadata record: versions, model, and the settings in force for it.
///
/// The attached scene is the file as written; where the command line overrode it, these settings are the ones that
/// held. Numbers are printed in the shortest form that reads back to the same double.
pub fn metadata<S: Logged>(run: &RunInfo<'_, S>) -> BTreeMap<String, String> {
    let About { kind, name, duration_s, rates, integrator: integration, engine: stepping, .. } = run.scene.about();
    let mut entries = vec![
        ("phalanx_version", env!("CARGO_PKG_VERSION").to_string()),
        ("mcap_version", mcap::VERSION.to_string()),
        ("model", run.model.to_string()),
        ("kind", kind.to_string()),
        ("scene", name.to_string()),
        ("scene_file", run.scene_file.to_string()),
        ("duration_s", format!("{duration_s:?}")),
        ("log_numeric_hz", format!("{:?}", rates.numeric_hz)),
        ("log_picture_hz", format!("{:?}", rates.picture_hz)),
    ];
    match run.model {
        ENGINE => entries.extend(engine(stepping)),
        _ => entries.extend(integrator(integration)),
    }
    entries.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
}

fn integrator(settings: &Integrator) -> Vec<(&'static str, String)> {
    vec![
        ("integrator_preset", preset_name(settings.preset).to_string()),
        ("integrator_method", method_name(settings.method).to_string()),
        ("integrator_rtol", format!("{:?}", settings.rtol)),
        ("integrator_atol_angle_rad", format!("{:?}", settings.atol_angle_rad)),
        ("integrator_atol_rate_rad_s", format!("{:?}", settings.atol_rate_rad_s)),
        ("integrator_max_steps", settings.max_steps.to_string()),
    ]
}

fn engine(settings: &Engine) -> Vec<(&'static str, String)> {
    let mut entries = vec![
        ("engine_construction", construction_name(settings.construction).to_string()),
        ("engine_law", law_name(settings.response).to_string()),
        ("engine_stepping", stepping_name(settings.stepping).to_string()),
        ("engine_iterations", settings.iterations.to_string()),
        ("engine_max_steps", settings.max_steps.to_string()),
        ("rapier_version", RAPIER_VERSION.to_string()),
    ];
    if let Response::Rapier { friction, restitution } = settings.response {
        entries.push(("engine_friction", format!("{friction:?}")));
        entries.push(("engine_restitution", format!("{restitution:?}")));
    }
    match settings.stepping {
        Stepping::Fixed { step_s } => entries.push(("engine_step_s", format!("{step_s:?}"))),
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            entries.push(("engine_tolerance_m", format!("{tolerance_m:?}")));
            entries.push(("engine_max_step_s", format!("{max_step_s:?}")));
        }
    }
    entries
}

/// The construction in the words of scene files.
pub fn construction_name(construction: Construction) -> &'static str {
    match construction {
        Construction::Maximal => "maximal",
        Construction::Reduced => "reduced",
    }
}

/// What answers to contact, in the words of scene files.
pub fn law_name(response: Response) -> &'static str {
    match response {
        Response::Laws => "scene",
        Response::Rapier { .. } => "rapier",
    }
}

/// The stepping in the words of scene files.
pub fn stepping_name(stepping: Stepping) -> &'static str {
    match stepping {
        Stepping::Fixed { .. } => "fixed",
        Stepping::Adaptive { .. } => "adaptive",
    }
}

/// The preset in the words of scene files.
pub fn preset_name(preset: Preset) -> &'static str {
    match preset {
        Preset::Engineering => "engineering",
        Preset::Reference => "reference",
    }
}

/// The method in the words of scene files.
pub fn method_name(method: Method) -> &'static str {
    method.word()
}
