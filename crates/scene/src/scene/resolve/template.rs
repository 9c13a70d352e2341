//! A valid scene as the template of many designs.

use super::super::check::Checker;
use super::super::error::Problem;
use super::super::section_input::{SceneInput, SectionInput};
use super::super::settings::InitialSettings;
use super::super::{Scene, Side, Template};
use super::{finger, object};
use crate::shape;

/// Builds the template, with the settings that the resolved `scene` does not contain.
///
/// # Errors
/// Returns a problem for each key that ties the scene to one design.
pub fn template(input: &SceneInput, checker: Checker<'_>, scene: &Scene) -> Result<Template, Vec<Problem>> {
    match resolve(&input.finger(Side::Right, &checker), scene) {
        Some(template) if checker.is_clean() => Ok(template),
        _ => Err(checker.into_problems()),
    }
}

fn resolve(input: &SectionInput<'_>, scene: &Scene) -> Option<Template> {
    if input.has("lengths") {
        let message = "this scene gives the lengths of one finger, but a template requires design variables";
        let help =
            "replace [lengths] by [design] with base, l21_fraction, phi22 and arm_ratio; see scenes/experiment-95.toml";
        input.report("lengths", message, "one finger", help);
    }
    let (object, initial) = (input.subsection("object"), input.subsection("initial"));
    if object.has("centre") {
        let message = "in a template the base determines the position of the object, but this scene gives it";
        object.report("centre", message, "one position for all bases", "remove the centre");
    }
    for key in ["q11", "q21"].into_iter().filter(|key| initial.has(key)) {
        let message =
            format!("`initial.{key}` is the start of one finger, but the contact angle depends on the design");
        let help = "give the angle before the contact instead: [initial] offset = \"25 deg\"";
        initial.report(key, message, "one start for all designs", help);
    }
    if !input.checker.is_clean() {
        return None;
    }
    let radius_m = shape::max_radius(&object::shape(input));
    let settings = finger::resolve_lengths(input, radius_m);
    let (material, overrides) = finger::mass_settings(input);
    Some(Template {
        name: scene.name.clone(),
        design: finger::design(&input.subsection("design"), settings.half_width_m, radius_m)?,
        density_kg_m3: *material.density,
        depth_m: *material.depth,
        overrides,
        assembly: settings.assembly,
        opening_rad: *initial.read::<InitialSettings>().offset?,
        gravity_m_s2: scene.system.gravity_m_s2,
        closing_s: settings.closing_s,
        rule: settings.rule,
        mu_static: scene.finger().contact.mu_static(),
    })
}
