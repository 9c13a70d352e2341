//! Contact laws of the contacts with the object, and the law of the joint limit.

use super::super::section_input::SectionInput;
use super::super::settings::{FrictionSettings, LawSettings, LimitSettings, SurfaceSettings};
use crate::law::{Bristle, ContactLaw, FrictionLaw, Material, NormalLaw, hertz_stiffness};

/// Damping of a bristle if the normal law has no damper.
const BRISTLE_DAMPING_N_S_PER_M: f64 = 1e6;

/// A section that determines laws: [contact], or the section that overrides its keys for one contact.
pub struct Level<'a> {
    input: SectionInput<'a>,
    /// The normal law after this section is applied.
    normal: LawSettings,
    object_radius_m: f64,
}

impl<'a> Level<'a> {
    /// Reads [contact]; the radius of the object is for materials.
    pub fn common(input: SectionInput<'a>, object_radius_m: f64) -> Self {
        let normal = normal(&input, input.read(), object_radius_m);
        Level { input, normal, object_radius_m }
    }

    /// The law of all contacts; `None` if it is invalid.
    pub fn law(&self) -> Option<ContactLaw> {
        law(&[self])
    }

    /// The law of one contact, whose section overrides single keys; `None` if it is invalid.
    pub(crate) fn law_of(&self, contact: &str) -> Option<ContactLaw> {
        let input = self.input.subsection(contact);
        let normal = normal(&input, input.read_over(&self.normal), self.object_radius_m);
        law(&[self, &Level { input, normal, object_radius_m: self.object_radius_m }])
    }

    /// Reports the section of a contact that does not exist.
    pub(crate) fn report_unused(&self, contact: &str) {
        self.input.report_unused(contact, &format!("without a {contact}"));
    }
}

/// Combines the law of one contact from the common section and its overrides.
fn law(levels: &[&Level<'_>]) -> Option<ContactLaw> {
    let last = levels.last()?;
    let normal = NormalLaw::from(&last.normal);
    if normal.stiffness_n_per_m_e == 0.0 && normal.damping_max_n_s_per_m == 0.0 {
        let is_given = |level: &&&Level<'_>| level.input.has("stiffness_si") || level.input.has("damping");
        let input = &levels.iter().rev().find(is_given).unwrap_or(&levels[0]).input;
        let key = if input.has("stiffness_si") { "stiffness_si" } else { "damping" };
        let message =
            format!("[{}] has neither stiffness nor damping: there would be no contact force", input.path(""));
        let help = "give one of them a value above 0: stiffness_si = 1e8 or damping = \"1e6 N*s/m\"";
        input.report(key, message, "both are 0", help);
    }
    Some(ContactLaw { normal, friction: friction(levels)? })
}

/// Completes the normal law of a section by its materials.
fn normal(input: &SectionInput<'_>, mut law: LawSettings, object_radius_m: f64) -> LawSettings {
    check_exponent(input);
    let materials = input.subsection("materials");
    if !materials.is_present() {
        return law;
    }
    for key in ["stiffness_si", "exponent"] {
        input.report_unused(key, &format!("with [{}], which determine it", input.path("materials")));
    }
    if let Some(k) = hertz(&materials, object_radius_m) {
        (law.stiffness_si, law.exponent) = (k.into(), 1.5.into());
    }
    law
}

/// The unit of the stiffness depends on the exponent, so both must be given together.
fn check_exponent(input: &SectionInput<'_>) {
    if input.has("exponent") && !input.has("stiffness_si") {
        let path = input.path("exponent");
        let message = format!("`{path}` is given without `stiffness_si`, whose unit depends on it");
        input.report("exponent", message, "stiffness missing", "give both: stiffness_si = 1e8 and exponent = 2.2");
    }
}

/// Hertz: k = 4/3 E* √R (thesis (2.33), (2.34), errata 6).
fn hertz(input: &SectionInput<'_>, object_radius_m: f64) -> Option<f64> {
    let [object, phalanx] =
        [("object", object_radius_m), ("phalanx", f64::INFINITY)].map(|(key, radius_m)| surface(input, key, radius_m));
    let ((object, object_radius), (phalanx, phalanx_radius)) = (object?, phalanx?);
    let k = hertz_stiffness([object, phalanx], [object_radius, phalanx_radius]);
    if k.is_finite() && k > 0.0 {
        return Some(k);
    }
    let message = format!("these materials give a stiffness of {k}, but it must be finite and above 0");
    input.report("", message, "", "check the moduli and radii");
    None
}

/// Reads a surface and its radius.
fn surface(materials: &SectionInput<'_>, key: &str, default_m: f64) -> Option<(Material, f64)> {
    let input = materials.subsection(key);
    if !input.is_present() {
        let help = "give both surfaces: object = { modulus = \"2.3 GPa\", poisson = 0.35 }, and phalanx likewise";
        materials.report_missing(key, help);
        return None;
    }
    let SurfaceSettings { modulus, poisson, radius } = input.read();
    let material = Material { youngs_modulus_pa: *modulus?, poisson_ratio: *poisson? };
    Some((material, radius.map_or(default_m, |radius| *radius)))
}

/// Friction law: `Some(None)` without friction, `None` if invalid. A static coefficient also replaces the dynamic
/// coefficient of the preceding level.
fn friction(levels: &[&Level<'_>]) -> Option<Option<FrictionLaw>> {
    let sections: Vec<SectionInput<'_>> = levels.iter().map(|level| level.input.subsection("friction")).collect();
    let problem_count = sections[0].checker.count();
    let mut law: FrictionSettings = sections[0].read();
    for section in &sections[1..] {
        law.mu_dynamic = law.mu_dynamic.filter(|_| !section.has("mu_static"));
        law = section.read_over(&law);
    }
    if sections[0].checker.count() > problem_count {
        return None;
    }
    let Some(last) = sections.iter().rev().find(|section| section.is_present()) else { return Some(None) };
    if !sections.iter().any(|section| section.has("mu_static")) {
        last.report_missing("mu_static", "add the static coefficient: mu_static = 0.8, or 0 for no friction");
        return None;
    }
    let mu_static = *law.mu_static;
    // 0.7 μ_s; exactly 0.56 for 0.8.
    let mu_dynamic = law.mu_dynamic.map_or(7.0 * mu_static / 10.0, |mu_dynamic| *mu_dynamic);
    let (v_static, v_dynamic) = (*law.v_static?, *law.v_dynamic?);
    if mu_dynamic > mu_static {
        let path = last.path("mu_dynamic");
        let message = format!("`{path}` is {mu_dynamic}, but must not exceed mu_static = {mu_static}");
        let help = "lower mu_dynamic, raise mu_static, or remove mu_dynamic (default: 0.7 mu_static)";
        last.report("mu_dynamic", message, &format!("from 0 to {mu_static}"), help);
        return None;
    }
    if v_dynamic <= v_static {
        let path = last.path("v_dynamic");
        let message = format!("`{path}` is {v_dynamic} m/s, but must be above v_static = {v_static} m/s");
        let help = "raise v_dynamic, lower v_static, or remove both (defaults: 0.2 m/s and 0.1 m/s)";
        last.report(if last.has("v_dynamic") { "v_dynamic" } else { "v_static" }, message, "", help);
        return None;
    }
    let bristle = match law.law?.0 {
        None => None,
        Some(_) => {
            let normal = levels.last().map_or(0.0, |level| *level.normal.damping);
            let default = if normal > 0.0 { normal } else { BRISTLE_DAMPING_N_S_PER_M };
            let damping_n_s_per_m = law.bristle_damping.map_or(default, |damping| *damping);
            Some(Bristle { damping_n_s_per_m, relaxation_s: *law.bristle_relaxation? })
        }
    };
    let law = FrictionLaw { mu_static, mu_dynamic, v_static_m_s: v_static, v_dynamic_m_s: v_dynamic, bristle };
    Some((mu_static > 0.0).then_some(law))
}

/// Reads the law of the joint limit; `None` if it is disabled.
pub fn limit(input: &SectionInput<'_>) -> Option<NormalLaw> {
    check_exponent(input);
    input.read::<LimitSettings>().law()
}
