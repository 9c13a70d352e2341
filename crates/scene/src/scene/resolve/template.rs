//! A valid scene as the template of many designs.

use super::super::check::Checker;
use super::super::error::Problem;
use super::super::scene_input::SceneInput;
use super::super::table::finger::FingerSettings;
use super::super::table::input::SectionInput;
use super::super::table::{SettingsSection, read};
use super::super::{Scene, Side, Template};
use super::{finger, object, start};
use crate::gripper::Design;
use crate::law::ContactLaw;
use crate::shape;

/// Builds the template, with the settings that the resolved `scene` does not contain.
///
/// # Errors
/// Returns a problem for each key that ties the scene to one design.
pub fn template(input: &SceneInput, mut checker: Checker<'_>, scene: &Scene) -> Result<Template, Vec<Problem>> {
    let input = &input.finger(Side::Right);
    let settings = read(&mut checker, "", input, FingerSettings::defaults());
    let design = design(&mut checker, input, settings.half_width_m);
    let (object, initial) = (input.subsection("object"), input.subsection("initial"));
    if object.has("centre") {
        checker.push(
            object.span("centre"),
            "in a template the base determines the position of the object, but this scene gives it",
            "one position for all bases",
            "remove the centre",
        );
    }
    for key in ["q11", "q21"] {
        if initial.has(key) {
            checker.push(
                initial.span(key),
                format!("`initial.{key}` is the start of one finger, but the contact angle depends on the design"),
                "one start for all designs",
                "give the angle before the contact instead: [initial] offset = \"25 deg\"",
            );
        }
    }
    let finger::MassSettings { material, overrides } = finger::mass_settings(&mut checker, input);
    let opening_rad = start::start(&mut checker, input).0;
    let mu = |law: &ContactLaw| law.friction.map_or(0.0, |friction| friction.mu_static);
    match design {
        Some(design) if checker.is_clean() => Ok(Template {
            name: scene.name.clone(),
            design,
            density_kg_m3: material.density_kg_m3,
            depth_m: material.depth_m,
            overrides,
            assembly: scene.finger().linkage.assembly,
            opening_rad,
            gravity_m_s2: scene.system.gravity_m_s2,
            closing_s: settings.closing_s,
            rule: settings.sizing,
            mu_static: [mu(&scene.finger().contact.proximal), mu(&scene.finger().contact.distal)],
        }),
        _ => Err(checker.into_problems()),
    }
}

fn design(checker: &mut Checker<'_>, input: &SectionInput<'_>, half_width_m: f64) -> Option<Design> {
    if input.subsection("lengths").is_present() {
        checker.push(
            input.subsection("lengths").span,
            "this scene gives the lengths of one finger, but a template requires design variables",
            "one finger",
            "replace [lengths] by [design] with base, l21_fraction, phi22 and arm_ratio; see scenes/experiment-95.toml",
        );
        return None;
    }
    let object = object::shape(checker, input);
    finger::design(checker, &input.subsection("design"), half_width_m, shape::max_radius(&object))
}
