//! Contact laws, and the law of the joint limit.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{FINGERS, GRIPPER};
use crate::law::{Bristle, ContactLaw, FrictionKind, FrictionLaw, Material, NormalLaw, hertz_stiffness};
use crate::scene::quantity::{
    Angle, AngularDamping, Length, LinearDamping, NotNegative, Plain, Positive, Pressure, Quantity, Speed, Time,
    keyword_enum,
};
use crate::scene::section_input::SectionInput;

/// Laws of the contacts of both phalanges with the object. [contact.proximal] and [contact.distal] override single keys
/// for one contact.
#[derive(JsonSchema)]
#[schemars(extend("x-bodies" = { "description": "Law of every contact." }, "x-gripper" = {
    "description": "Laws of all contacts with the object; [contact.proximal] and [contact.distal] override single keys for \
        these phalanges of both fingers, [contact.palm] and [contact.table] for palm and table."
}))]
pub struct ContactSettings {
    #[serde(flatten)]
    pub law: LawSettings,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub materials: HertzSettings,
    pub friction: FrictionSettings,
    #[schemars(extend("x-kinds" = FINGERS, "x-overrides" = true))]
    pub proximal: ContactOverride,
    #[schemars(extend("x-kinds" = FINGERS, "x-overrides" = true))]
    pub distal: ContactOverride,
    #[schemars(extend("x-kinds" = GRIPPER, "x-overrides" = true))]
    pub palm: ContactOverride,
    #[schemars(extend("x-kinds" = GRIPPER, "x-overrides" = true))]
    pub table: ContactOverride,
}

/// Overrides of [contact] for one contact.
#[derive(JsonSchema)]
pub struct ContactOverride {
    #[serde(flatten)]
    pub law: LawSettings,
    pub materials: HertzSettings,
    pub friction: FrictionSettings,
}

/// Settings of a given normal law, of a contact or of the joint limit.
fn normal_settings(law: NormalLaw) -> Value {
    json!({
        "stiffness_si": law.stiffness_n_per_m_e,
        "exponent": law.exponent,
        "damping": law.damping_max(),
        "transition": law.depth_scale_m(),
    })
}

/// Settings that describe a given law.
pub fn contact_settings(law: &ContactLaw) -> Value {
    let mut settings = normal_settings(law.normal);
    settings["friction"] = friction_settings(law.friction);
    settings
}

/// Settings of a given friction law.
pub(crate) fn friction_settings(law: Option<FrictionLaw>) -> Value {
    let Some(law) = law else { return json!({ "mu_static": 0.0, "mu_dynamic": 0.0 }) };
    let (kind, bristle) = match law.kind {
        FrictionKind::Regularised => (FrictionType::Regularised, None),
        FrictionKind::Bristle(bristle) => (FrictionType::Bristle, Some(bristle)),
    };
    json!({
        "mu_static": law.mu_static,
        "mu_dynamic": law.mu_dynamic,
        "v_static": law.v_static_m_s,
        "v_dynamic": law.v_dynamic_m_s,
        "law": kind,
        "bristle_damping": bristle.map(|bristle| bristle.damping_n_s_per_m),
        "bristle_relaxation": bristle.map(|bristle| bristle.relaxation_s),
    })
}

/// Normal law of one or several contacts.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct LawSettings {
    /// Stiffness k in N/m^e, a plain number because its unit depends on the exponent e; 0 for a damper only.
    #[schemars(extend("default" = 1e8))]
    pub stiffness_si: NotNegative<Plain>,
    /// Exponent e, at least 1; requires stiffness_si.
    #[schemars(extend("default" = 2.2, "minimum" = 1.0))]
    pub exponent: Quantity<Plain>,
    /// Damping c_max, fully engaged beyond the transition; 0 for a spring only.
    #[schemars(extend("default" = "1e6 N*s/m"))]
    pub damping: NotNegative<LinearDamping>,
    /// Penetration over which the damper engages.
    #[schemars(extend("default" = "10 um"))]
    pub transition: Positive<Length>,
}

/// Coulomb friction. Without this section the contact is frictionless.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct FrictionSettings {
    /// Static coefficient, reached at v_static; 0 is frictionless.
    #[schemars(extend("default" = 0.0))]
    pub mu_static: NotNegative<Plain>,
    /// Dynamic coefficient, beyond v_dynamic. Default: 0.7 mu_static.
    pub mu_dynamic: Option<NotNegative<Plain>>,
    /// Slip rate at which the static coefficient is reached.
    #[schemars(extend("default" = "0.1 m/s"))]
    pub v_static: Option<Positive<Speed>>,
    /// Slip rate from which the dynamic coefficient applies.
    #[schemars(extend("default" = "0.2 m/s"))]
    pub v_dynamic: Option<Positive<Speed>>,
    /// "regularised": the law of the thesis, which creeps; "bristle": spring and damper in series with a Coulomb
    /// slider, which holds without creep.
    #[schemars(extend("default" = "regularised"))]
    pub law: Option<FrictionType>,
    /// Damping of the bristle. Default: that of the normal law, or 1e6 N*s/m if the normal law has none.
    #[schemars(extend("x-with" = "law = bristle"))]
    pub bristle_damping: Option<Positive<LinearDamping>>,
    /// Relaxation time of the bristle: its damping over its stiffness.
    #[schemars(extend("x-with" = "law = bristle", "default" = "1 ms"))]
    pub bristle_relaxation: Option<Positive<Time>>,
}

keyword_enum! {
    /// Type of a friction law in a file.
    pub enum FrictionType { Regularised = "regularised", Bristle = "bristle" }
}

/// Materials and radii of the two surfaces, in place of stiffness and exponent: Hertz contact, k = 4/3 E* √R and e
/// = 3/2.
#[derive(JsonSchema)]
pub struct HertzSettings {
    pub object: SurfaceSettings,
    pub phalanx: SurfaceSettings,
}

/// One surface of a Hertz contact.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct SurfaceSettings {
    /// Young's modulus. Required.
    #[schemars(extend("x-required" = "add modulus = \"2.3 GPa\""))]
    pub modulus: Option<Positive<Pressure>>,
    /// Poisson's ratio, above −1 and up to 0.5. Required.
    #[schemars(extend("exclusiveMinimum" = -1.0, "maximum" = 0.5, "x-required" = "add poisson = 0.35"))]
    pub poisson: Option<Quantity<Plain>>,
    /// Radius of curvature. Default: the object's radius; a phalanx is flat.
    pub radius: Option<Positive<Length>>,
}

/// The stop that prevents the distal phalanx from bending backwards, q22 ≥ −phi22: a contact law on the angle.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct LimitSettings {
    /// Whether there is a joint limit.
    #[schemars(extend("default" = true))]
    pub enabled: bool,
    /// Stiffness k in N·m/rad^e, a plain number because its unit depends on the exponent e.
    #[schemars(extend("default" = 1e11, "x-with" = "enabled = true"))]
    pub stiffness_si: Positive<Plain>,
    /// Exponent e, at least 1; requires stiffness_si.
    #[schemars(extend("default" = 2.2, "minimum" = 1.0, "x-with" = "enabled = true"))]
    pub exponent: Quantity<Plain>,
    /// Damping c_max, fully engaged beyond the transition.
    #[schemars(extend("default" = "1e9 N*m*s/rad", "x-with" = "enabled = true"))]
    pub damping: NotNegative<AngularDamping>,
    /// Penetration over which the damper engages.
    #[schemars(extend("default" = "1e-5 rad", "x-with" = "enabled = true"))]
    pub transition: Positive<Angle>,
}

/// Settings that describe a given limit.
pub fn limit_settings(law: Option<NormalLaw>) -> Value {
    let mut settings = law.map_or(json!({}), normal_settings);
    settings["enabled"] = law.is_some().into();
    settings
}

/// Damping of a bristle if the normal law has no damper.
const BRISTLE_DAMPING_N_S_PER_M: f64 = 1e6;

/// The section [contact], read with its normal law. Sections of single contacts override it.
pub struct CommonLaw<'a> {
    input: SectionInput<'a>,
    normal: LawSettings,
    object_radius_m: f64,
}

impl<'a> CommonLaw<'a> {
    /// Reads [contact]. The object radius is used for Hertz contact of given materials.
    pub fn read(input: SectionInput<'a>, object_radius_m: f64) -> Self {
        let normal = normal(&input, input.read(), object_radius_m);
        CommonLaw { input, normal, object_radius_m }
    }

    /// The law of all contacts; `None` if it is invalid.
    pub fn law(&self) -> Option<ContactLaw> {
        law(&[&self.input], &self.normal)
    }

    /// The law of one contact, whose section overrides single keys; `None` if it is invalid.
    pub(crate) fn law_of(&self, contact: &str) -> Option<ContactLaw> {
        let input = self.input.subsection(contact);
        let normal = normal(&input, input.read_over(&self.normal), self.object_radius_m);
        law(&[&self.input, &input], &normal)
    }

    /// Reports the section of a contact that does not exist.
    pub(crate) fn report_unused(&self, contact: &str) {
        self.input.report_unused([contact], &format!("without a {contact}"));
    }
}

/// Combines the law of one contact from its normal law, the common section and the one that overrides it.
fn law(inputs: &[&SectionInput<'_>], normal: &LawSettings) -> Option<ContactLaw> {
    let LawSettings { stiffness_si, exponent, damping, transition } = normal;
    let normal = NormalLaw::step(**stiffness_si, **exponent, **damping, **transition);
    if normal.stiffness_n_per_m_e == 0.0 && normal.damping_max() == 0.0 {
        let is_given = |input: &&&SectionInput<'_>| input.has("stiffness_si") || input.has("damping");
        let input = inputs.iter().rev().find(is_given).unwrap_or(&inputs[0]);
        let key = if input.has("stiffness_si") { "stiffness_si" } else { "damping" };
        let message =
            format!("[{}] has neither stiffness nor damping: there would be no contact force", input.path(""));
        let help = "give one of them a value above 0: stiffness_si = 1e8 or damping = \"1e6 N*s/m\"";
        input.report(key, message, "both are 0", help);
    }
    Some(ContactLaw { normal, friction: friction(inputs, **damping)? })
}

/// Completes the normal law of a section by its materials.
fn normal(input: &SectionInput<'_>, mut law: LawSettings, object_radius_m: f64) -> LawSettings {
    check_exponent(input);
    let materials = input.subsection("materials");
    if !materials.is_present() {
        return law;
    }
    let reason = format!("with [{}], which determine it", input.path("materials"));
    input.report_unused(["stiffness_si", "exponent"], &reason);
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
    input.refuse("", message, "", "check the moduli and radii")
}

/// Reads a surface and its radius.
fn surface(materials: &SectionInput<'_>, key: &str, default_m: f64) -> Option<(Material, f64)> {
    let input = materials.subsection(key);
    if !input.is_present() {
        let help = "give both surfaces: object = { modulus = \"2.3 GPa\", poisson = 0.35 }, and phalanx likewise";
        return materials.refuse_missing(key, help);
    }
    let SurfaceSettings { modulus, poisson, radius } = input.read();
    let material = Material { youngs_modulus_pa: *modulus?, poisson_ratio: *poisson? };
    Some((material, radius.map_or(default_m, |radius| *radius)))
}

/// Reads the friction of a law from its section and those that override it: `Some(None)` without friction, `None` if it is
/// invalid. A static coefficient also replaces the dynamic coefficient of the preceding section. `damping` is that of the
/// normal law.
pub(crate) fn friction(laws: &[&SectionInput<'_>], damping: f64) -> Option<Option<FrictionLaw>> {
    let sections: Vec<SectionInput<'_>> = laws.iter().map(|law| law.subsection("friction")).collect();
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
        let help = "add the static coefficient: mu_static = 0.8, or 0 for no friction";
        return last.refuse_missing("mu_static", help);
    }
    let mu_static = *law.mu_static;
    // 0.7 μ_s; exactly 0.56 for 0.8.
    let mu_dynamic = law.mu_dynamic.map_or(7.0 * mu_static / 10.0, |mu_dynamic| *mu_dynamic);
    let (v_static, v_dynamic) = (*law.v_static?, *law.v_dynamic?);
    if mu_dynamic > mu_static {
        let path = last.path("mu_dynamic");
        let message = format!("`{path}` is {mu_dynamic}, but must not exceed mu_static = {mu_static}");
        let help = "lower mu_dynamic, raise mu_static, or remove mu_dynamic (default: 0.7 mu_static)";
        return last.refuse("mu_dynamic", message, &format!("from 0 to {mu_static}"), help);
    }
    if v_dynamic <= v_static {
        let path = last.path("v_dynamic");
        let message = format!("`{path}` is {v_dynamic} m/s, but must be above v_static = {v_static} m/s");
        let help = "raise v_dynamic, lower v_static, or remove both (defaults: 0.2 m/s and 0.1 m/s)";
        return last.refuse(if last.has("v_dynamic") { "v_dynamic" } else { "v_static" }, message, "", help);
    }
    let kind = match law.law {
        None | Some(FrictionType::Regularised) => FrictionKind::Regularised,
        Some(FrictionType::Bristle) => {
            let default = if damping > 0.0 { damping } else { BRISTLE_DAMPING_N_S_PER_M };
            let damping_n_s_per_m = law.bristle_damping.map_or(default, |damping| *damping);
            FrictionKind::Bristle(Bristle { damping_n_s_per_m, relaxation_s: *law.bristle_relaxation? })
        }
    };
    let law = FrictionLaw { mu_static, mu_dynamic, v_static_m_s: v_static, v_dynamic_m_s: v_dynamic, kind };
    Some((mu_static > 0.0).then_some(law))
}

/// Reads the law of the joint limit: torque in N·m, angle in rad; `None` if it is disabled.
pub fn limit(input: &SectionInput<'_>) -> Option<NormalLaw> {
    check_exponent(input);
    let law: LimitSettings = input.read();
    law.enabled.then(|| NormalLaw::step(*law.stiffness_si, *law.exponent, *law.damping, *law.transition))
}
