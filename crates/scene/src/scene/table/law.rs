//! `[contact]` with its subsections, and `[limit]`: contact laws.

use super::settings;
use crate::law::{Bristle, FrictionLaw, NormalLaw};
use crate::scene::check::{Bound, NOT_NEGATIVE, POSITIVE};
use crate::scene::keywords::{ANY, FINGERS, SceneKind, TWO_FINGERS};
use crate::scene::value_kinds::{
    Angle, AngularDamping, Choice, Flag, Keyword, Length, LinearDamping, Number, Pressure, Speed, Time,
};

const EXPONENT: Bound = Bound { allowed: |x| x >= 1.0, text: "at least 1" };
const POISSON: Bound = Bound { allowed: |x| x > -1.0 && x <= 0.5, text: "above -1 and up to 0.5" };

/// Default law of the contacts with the object.
const CONTACT: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };

/// Default law of the joint limit, with rad in place of m.
const LIMIT: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e11, exponent: 2.2, damping_max_n_s_per_m: 1e9, transition_m: 1e-5 };

/// A law without defaults, for sections that override single keys of another law.
const NONE: NormalLaw = NormalLaw {
    stiffness_n_per_m_e: f64::NAN,
    exponent: f64::NAN,
    damping_max_n_s_per_m: f64::NAN,
    transition_m: f64::NAN,
};

/// Defines a section with the keys of a normal law.
macro_rules! normal_law_section {
    ($(#[doc = $doc:literal])+ $section:ident = $defaults:expr $(, $inner:literal in $of:ident: $table:ty)* $(, where { $($other:tt)* })?) => {
        /// Normal law defined by one section of a scene file.
        #[derive(Clone, Copy, Debug)]
        pub struct $section(pub NormalLaw);

        impl From<$section> for NormalLaw {
            fn from(law: $section) -> Self {
                law.0
            }
        }

        settings! {
            $(#[doc = $doc])+
            $section = Self($defaults), l $(, $inner in $of: $table)* $(, where { $($other)* })?;
            /// Stiffness k in N/m^e, a plain number because its unit depends on the exponent e; 0 for a damper only.
            "stiffness_si": Number = Some(&mut l.0.stiffness_n_per_m_e), allowed(NOT_NEGATIVE);
            /// Exponent e, at least 1; requires stiffness_si.
            "exponent": Number = Some(&mut l.0.exponent), allowed(EXPONENT);
            /// Damping c_max, fully engaged beyond the transition; 0 for a spring only.
            "damping": LinearDamping = Some(&mut l.0.damping_max_n_s_per_m), allowed(NOT_NEGATIVE);
            /// Penetration over which the damper engages.
            "transition": Length = Some(&mut l.0.transition_m), allowed(POSITIVE);
        }
    };
}

normal_law_section! {
    /// Laws of both contacts with the object; [contact.proximal] and [contact.distal] override single keys for one
    /// contact.
    ContactSettings = CONTACT, "materials" in FINGERS: HertzSettings, "friction" in ANY: FrictionLaw, "proximal" in FINGERS: ContactOverride,
        "distal" in FINGERS: ContactOverride, "palm" in TWO_FINGERS: ContactOverride, "table" in TWO_FINGERS: ContactOverride, where {
        const DOC_OVERRIDES: &'static [(SceneKind, &'static str)] = &[
            (SceneKind::Bodies, "Law of every contact."),
            (
                SceneKind::Gripper,
                "Laws of all contacts with the object; [contact.proximal] and [contact.distal] override single keys for these \
                 phalanges of both fingers, [contact.palm] and [contact.table] for palm and table.",
            ),
        ];
    }
}

normal_law_section! {
    /// Overrides of [contact] for one contact.
    ContactOverride = NONE, "materials" in FINGERS: HertzSettings, "friction" in FINGERS: FrictionLaw
}

settings! {
    /// Coulomb friction. Without this section the contact is frictionless.
    FrictionLaw = Self { mu_static: 0.0, mu_dynamic: f64::NAN, v_static_m_s: 0.1, v_dynamic_m_s: 0.2, bristle: None }, f;
    /// Static coefficient, reached at v_static; 0 is frictionless.
    "mu_static": Number = Some(&mut f.mu_static), allowed(NOT_NEGATIVE),
        set_with(|f, mu_static| (f.mu_static, f.mu_dynamic) = (mu_static, f64::NAN));
    /// Dynamic coefficient, beyond v_dynamic. Default: 0.7 mu_static.
    "mu_dynamic": Number = Some(&mut f.mu_dynamic), allowed(NOT_NEGATIVE);
    /// Slip rate at which the static coefficient is reached.
    "v_static": Speed = Some(&mut f.v_static_m_s), allowed(POSITIVE);
    /// Slip rate from which the dynamic coefficient applies.
    "v_dynamic": Speed = Some(&mut f.v_dynamic_m_s), allowed(POSITIVE);
    /// "regularised": the law of the thesis, which creeps; "bristle": spring and damper in series with a Coulomb
    /// slider, which holds without creep.
    "law": Choice<Option<Bristle>> = Some(&mut f.bristle);
    /// Damping of the bristle. Default: that of the normal law, or 1e6 N*s/m if the normal law has none.
    "bristle_damping": LinearDamping = f.bristle.as_mut().map(|bristle| &mut bristle.damping_n_s_per_m),
        allowed(POSITIVE), depends_on("law", "without law = \"bristle\"");
    /// Relaxation time of the bristle: its damping over its stiffness.
    "bristle_relaxation": Time = f.bristle.as_mut().map(|bristle| &mut bristle.relaxation_s),
        allowed(POSITIVE), depends_on("law", "without law = \"bristle\"");
}

impl Keyword for Option<Bristle> {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("regularised", None), ("bristle", Some(Bristle { damping_n_s_per_m: f64::NAN, relaxation_s: 1e-3 }))];

    fn keyword(&self) -> &'static str {
        if self.is_some() { "bristle" } else { "regularised" }
    }
}

/// The section `[contact.materials]`, which contains the two surfaces of a Hertz contact.
#[derive(Clone, Copy, Debug)]
pub struct HertzSettings;

settings! {
    /// Materials and radii of the two surfaces, in place of stiffness and exponent: Hertz contact, k = 4/3 E* √R and e
    /// = 3/2.
    HertzSettings = Self, _m, "object" in FINGERS: SurfaceSettings, "phalanx" in FINGERS: SurfaceSettings;
}

/// One surface; NaN for values that are not given.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceSettings {
    pub modulus_pa: f64,
    pub poisson: f64,
    pub radius_m: f64,
}

settings! {
    /// One surface of a Hertz contact.
    SurfaceSettings = Self { modulus_pa: f64::NAN, poisson: f64::NAN, radius_m: f64::NAN }, s;
    /// Young's modulus. Required.
    "modulus": Pressure = Some(&mut s.modulus_pa), allowed(POSITIVE), required("add modulus = \"2.3 GPa\"");
    /// Poisson's ratio, above −1 and up to 0.5. Required.
    "poisson": Number = Some(&mut s.poisson), allowed(POISSON), required("add poisson = 0.35");
    /// Radius of curvature. Default: the object's radius; a phalanx is flat.
    "radius": Length = Some(&mut s.radius_m), allowed(POSITIVE);
}

/// Settings of the joint limit.
#[derive(Clone, Copy, Debug)]
pub struct LimitSettings {
    pub enabled: bool,
    /// Law of the torque in N·m over the angle in rad.
    pub law: NormalLaw,
}

impl LimitSettings {
    /// Settings of a disabled limit.
    pub const OFF: Self = Self { enabled: false, law: LIMIT };

    fn law(&mut self) -> Option<&mut NormalLaw> {
        self.enabled.then_some(&mut self.law)
    }
}

settings! {
    /// The stop that prevents the distal phalanx from bending backwards, q22 ≥ −phi22: a contact law on the angle.
    LimitSettings = Self { enabled: true, law: LIMIT }, l;
    /// Whether there is a joint limit.
    "enabled": Flag = Some(&mut l.enabled);
    /// Stiffness k in N·m/rad^e, a plain number because its unit depends on the exponent e.
    "stiffness_si": Number = l.law().map(|law| &mut law.stiffness_n_per_m_e),
        allowed(POSITIVE), depends_on("enabled", "with enabled = false");
    /// Exponent e, at least 1; requires stiffness_si.
    "exponent": Number = l.law().map(|law| &mut law.exponent),
        allowed(EXPONENT), depends_on("enabled", "with enabled = false");
    /// Damping c_max, fully engaged beyond the transition.
    "damping": AngularDamping = l.law().map(|law| &mut law.damping_max_n_s_per_m),
        allowed(NOT_NEGATIVE), depends_on("enabled", "with enabled = false");
    /// Penetration over which the damper engages.
    "transition": Angle = l.law().map(|law| &mut law.transition_m),
        allowed(POSITIVE), depends_on("enabled", "with enabled = false");
}
