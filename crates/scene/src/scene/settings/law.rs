//! Contact laws, and the law of the joint limit.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;

use super::{FINGERS, GRIPPER, table};
use crate::law::{Bristle, ContactLaw, NormalLaw};
use crate::scene::quantity::{
    Angle, AngularDamping, Keyword, Length, LinearDamping, NotNegative, Plain, Positive, Pressure, Quantity, Speed,
    Time, Word,
};

/// Laws of both contacts with the object; [contact.proximal] and [contact.distal] override single keys for one
/// contact.
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
fn normal(law: NormalLaw) -> Table {
    table([
        ("stiffness_si", law.stiffness_n_per_m_e.into()),
        ("exponent", law.exponent.into()),
        ("damping", law.damping_max_n_s_per_m.into()),
        ("transition", law.transition_m.into()),
    ])
}

/// Settings of a given law.
pub fn contact(law: &ContactLaw) -> Table {
    let friction = match &law.friction {
        None => table([("mu_static", 0.0.into()), ("mu_dynamic", 0.0.into())]),
        Some(law) => {
            let bristle = |value: fn(Bristle) -> f64| law.bristle.map_or(f64::NAN, value).into();
            table([
                ("mu_static", law.mu_static.into()),
                ("mu_dynamic", law.mu_dynamic.into()),
                ("v_static", law.v_static_m_s.into()),
                ("v_dynamic", law.v_dynamic_m_s.into()),
                ("law", law.bristle.keyword().into()),
                ("bristle_damping", bristle(|bristle| bristle.damping_n_s_per_m)),
                ("bristle_relaxation", bristle(|bristle| bristle.relaxation_s)),
            ])
        }
    };
    let mut settings = normal(law.normal);
    settings.insert("friction".to_string(), friction.into());
    settings
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

impl From<&LawSettings> for NormalLaw {
    fn from(law: &LawSettings) -> Self {
        NormalLaw {
            stiffness_n_per_m_e: *law.stiffness_si,
            exponent: *law.exponent,
            damping_max_n_s_per_m: *law.damping,
            transition_m: *law.transition,
        }
    }
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
    pub law: Option<Word<Option<Bristle>>>,
    /// Damping of the bristle. Default: that of the normal law, or 1e6 N*s/m if the normal law has none.
    #[schemars(extend("x-with" = "law = bristle"))]
    pub bristle_damping: Option<Positive<LinearDamping>>,
    /// Relaxation time of the bristle: its damping over its stiffness.
    #[schemars(extend("x-with" = "law = bristle", "default" = "1 ms"))]
    pub bristle_relaxation: Option<Positive<Time>>,
}

impl Keyword for Option<Bristle> {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("regularised", None), ("bristle", Some(Bristle { damping_n_s_per_m: f64::NAN, relaxation_s: f64::NAN }))];

    fn keyword(&self) -> &'static str {
        if self.is_some() { "bristle" } else { "regularised" }
    }
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

impl LimitSettings {
    /// Law of the torque in N·m over the angle in rad; `None` if the limit is disabled.
    pub fn law(&self) -> Option<NormalLaw> {
        self.enabled.then(|| NormalLaw {
            stiffness_n_per_m_e: *self.stiffness_si,
            exponent: *self.exponent,
            damping_max_n_s_per_m: *self.damping,
            transition_m: *self.transition,
        })
    }
}

/// Settings of a given limit.
pub fn limit(law: Option<NormalLaw>) -> Table {
    let mut settings = law.map_or_else(Table::new, normal);
    settings.insert("enabled".to_string(), law.is_some().into());
    settings
}
