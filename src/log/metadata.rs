//! What a log says about its run beside the samples: the metadata record and the name of the scene attachment.

use std::collections::BTreeMap;

use crate::scene::{Method, Preset, Scene};

/// Name of the metadata record.
pub const METADATA_NAME: &str = "phalanx";

/// Media type of the scene attachment.
pub const ATTACHMENT_MEDIA_TYPE: &str = "application/toml";

/// Which run a log is of.
#[derive(Clone, Copy, Debug)]
pub struct RunInfo<'a> {
    pub scene: &'a Scene,
    /// File name of the scene, without directories: the name of the attachment.
    pub scene_file: &'a str,
    /// `analytic` or `engine`.
    pub model: &'a str,
}

/// The entries of the metadata record: versions, model, and the settings in force.
///
/// The attached scene is the file as written; where the command line overrode it, these settings are the ones that
/// held. Numbers are printed in the shortest form that reads back to the same double.
pub fn metadata(run: &RunInfo<'_>) -> BTreeMap<String, String> {
    let Scene { name, duration_s, integrator, log, .. } = run.scene;
    [
        ("phalanx_version", env!("CARGO_PKG_VERSION").to_string()),
        ("mcap_version", mcap::VERSION.to_string()),
        ("model", run.model.to_string()),
        ("scene", name.clone()),
        ("scene_file", run.scene_file.to_string()),
        ("duration_s", format!("{duration_s:?}")),
        ("integrator_preset", preset_name(integrator.preset).to_string()),
        ("integrator_method", method_name(integrator.method).to_string()),
        ("integrator_rtol", format!("{:?}", integrator.rtol)),
        ("integrator_atol_angle_rad", format!("{:?}", integrator.atol_angle_rad)),
        ("integrator_atol_rate_rad_s", format!("{:?}", integrator.atol_rate_rad_s)),
        ("integrator_max_steps", integrator.max_steps.to_string()),
        ("log_numeric_hz", format!("{:?}", log.numeric_hz)),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_string(), value))
    .collect()
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
    match method {
        Method::Rodas5p => "rodas5p",
        Method::RadauIIa5 => "radau5",
    }
}
