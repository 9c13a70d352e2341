//! Derivatives of a run with respect to parameters of its scene: of its last sample, of its events, and of the time to
//! stability. Where one does not exist, or is not computed, there is a reason.
//!
//! | file | content |
//! |---|---|
//! | `derivatives` | parameters and derivatives |
//! | `neighbours` | models beside a parameter, and difference quotients between them |
//! | `tangent` | the tangent equation |
//! | `steps` | its integration along a step |
//! | `readings` | derivatives of the numbers of a sample |
//! | `jumps` | events and discontinuities |
//! | `run` | a run with its derivatives |
//! | `observed` | runs without derivatives, to compare with |
//! | `reasons` | why a derivative is refused or zero |
//! | `results` | derivatives with errors or reasons |

mod derivatives;
mod jumps;
mod neighbours;
mod observed;
mod readings;
mod reasons;
mod results;
mod run;
mod steps;
mod tangent;

use crate::scene::Scene;
use crate::trace::{KeepRunning, RunError, Schema};
pub use derivatives::{Derivative, Derivatives, EventGradient, Gradient, Parameter};
use neighbours::TangentParameter;
use observed::{Observation, at_tolerance, observe};
use reasons::{Context, samples_beside};
use run::run_tangent;

/// Ratio of the tolerances of the two runs.
const COARSE: f64 = 10.0;

/// Simulates a scene with the analytic model, and returns its derivatives with respect to each parameter.
///
/// # Errors
/// Returns an error if the run does not complete.
pub fn gradient(
    scene: &Scene,
    parameters: &[Parameter<'_>],
    keep_running: KeepRunning<'_>,
) -> Result<Vec<Gradient>, RunError> {
    let fine = at_tolerance(scene, 1.0);
    let base = observe(&fine, keep_running)?;
    let tts_s = base.criteria.as_ref().map(|criteria| criteria.tts_s).unwrap_or_default();
    let times: Vec<f64> = tts_s.into_iter().filter(|tts_s| *tts_s > 0.0).collect();
    let runs = [1.0, COARSE].map(|factor| {
        let scenes = parameters
            .iter()
            .map(|parameter| move |value: f64| (parameter.scene_at)(value).map(|scene| at_tolerance(&scene, factor)));
        let scenes: Vec<_> = scenes.collect();
        let tangents = parameters.iter().zip(&scenes);
        let tangents = tangents.map(|(parameter, scene_at)| TangentParameter {
            scene_at,
            value: parameter.value,
            step: parameter.largest_change(),
        });
        let tangents: Vec<TangentParameter<'_>> = tangents.collect();
        let mut sink = Observation { criteria: None, events: Vec::new(), largest: Vec::new(), keep_running };
        run_tangent(&at_tolerance(scene, factor), &tangents, &times, &mut sink)
    });
    let [run, coarse] = runs;
    let (run, coarse) = (run?, coarse?);
    let schema = Schema::from_scene(scene);
    let context = Context { scene: &fine, schema: &schema, base: &base, run: &run, coarse: &coarse, tts_s };
    let gradients = parameters.iter().enumerate().map(|(index, parameter)| {
        let neighbours = samples_beside(parameter, &base, &schema, keep_running);
        let changed = match &neighbours {
            Ok(samples) => context.contradiction(index, parameter, samples),
            Err(reason) => Some(reason.clone()),
        };
        context.gradient(index, parameter, changed)
    });
    Ok(gradients.collect())
}
