//! The common part of all designs of a study: a scene without the four design variables.

use super::check::Checker;
use super::error::Problem;
use super::section_input::{SceneInput, SectionInput};
use super::sections::{DENSITY_KG_M3, DEPTH_M, InitialSettings, bodies, finger};
use super::{Scene, Side};
use crate::gripper::{Assembly, BodyOverride, Design, ProximalLength, disc};
use crate::shape;
use crate::sizing::{CLOSING_S, Rule, Task};

/// A gripper whose design variables base, l21, φ22 and r_l are left open, and the task for which it is sized.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    pub name: String,
    /// The design of the scene; a study replaces its base, l21, φ22 and r_l.
    pub design: Design,
    pub density_kg_m3: f64,
    pub depth_m: f64,
    /// Overrides of the mass properties of l11, l12, l21 and l22, common to all designs.
    pub overrides: [BodyOverride; 4],
    pub assembly: Assembly,
    /// q_0, the initial angle before the proximal contact.
    pub opening_rad: f64,
    pub gravity_m_s2: [f64; 2],
    /// Duration T of the test trajectory for the sizing of motor and spring.
    pub closing_s: f64,
    /// Sizing rule of the scene; `None` if it has none.
    pub rule: Option<Rule>,
    /// μ_s of the proximal and the distal contact.
    pub mu_static: [f64; 2],
}

impl Template {
    /// Returns the gripper of the thesis (Table 3.2), without friction, with the design variables of design 95.
    pub fn thesis() -> Self {
        Self {
            name: "thesis".to_string(),
            design: Design::thesis(0.0155, ProximalLength::Fraction(1.0), 120f64.to_radians(), 0.5),
            density_kg_m3: DENSITY_KG_M3,
            depth_m: DEPTH_M,
            overrides: [BodyOverride::default(); 4],
            assembly: Assembly::Reference,
            opening_rad: 25f64.to_radians(),
            gravity_m_s2: [0.0, crate::units::G_M_S2],
            closing_s: CLOSING_S,
            rule: None,
            mu_static: [0.0; 2],
        }
    }

    /// Returns the sizing task of a design.
    pub fn task(&self, design: &Design) -> Task {
        let Self { opening_rad, gravity_m_s2, closing_s, .. } = *self;
        Task { object: disc(design), opening_rad, gravity_m_s2, closing_s }
    }
}

/// Builds the template, with the settings that the resolved `scene` does not contain.
///
/// # Errors
/// Returns a problem for each key that ties the scene to one design.
pub fn template(input: &SceneInput<'_>, checker: Checker<'_>, scene: &Scene) -> Result<Template, Vec<Problem>> {
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
    let radius_m = shape::max_radius(&bodies::shape(input));
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
        gravity_m_s2: scene.hand.gravity_m_s2,
        closing_s: settings.closing_s,
        rule: settings.rule,
        mu_static: scene.finger().contact.mu_static(),
    })
}
