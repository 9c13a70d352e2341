//! `[contact]` with its parts, and `[limit]`: the laws of contacts.

use super::lines;
use crate::law::{Bristle, FrictionLaw, NormalLaw};
use crate::scene::check::{Bound, NOT_NEGATIVE, POSITIVE};
use crate::scene::kinds::{
    Angle, AngularDamping, Choice, Flag, Length, LinearDamping, Number, Pressure, Speed, Time, Words,
};
use crate::scene::words::{ANY, FINGERS, SceneKind, TWO_FINGERS};

const EXPONENT: Bound = Bound { allowed: |x| x >= 1.0, text: "at least 1" };
const POISSON: Bound = Bound { allowed: |x| x > -1.0 && x <= 0.5, text: "above -1 and up to 0.5" };

/// Law of the object's contacts.
const CONTACT: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };

/// Law of the joint limit, in rad for m.
const LIMIT: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e11, exponent: 2.2, damping_max_n_s_per_m: 1e9, transition_m: 1e-5 };

/// Where a law replaces single keys of another one, none of its own is usual.
const NONE: NormalLaw = NormalLaw {
    stiffness_n_per_m_e: f64::NAN,
    exponent: f64::NAN,
    damping_max_n_s_per_m: f64::NAN,
    transition_m: f64::NAN,
};

/// A section that has the keys of a normal law.
macro_rules! law {
    ($(#[doc = $doc:literal])+ $section:ident = $usual:expr $(, $inner:literal in $of:ident: $table:ty)* $(, where { $($other:tt)* })?) => {
        /// The normal law of one section.
        #[derive(Clone, Copy, Debug)]
        pub struct $section(pub NormalLaw);

        impl From<$section> for NormalLaw {
            fn from(law: $section) -> Self {
                law.0
            }
        }

        lines! {
            $(#[doc = $doc])+
            $section = Self($usual), l $(, $inner in $of: $table)* $(, where { $($other)* })?;
            /// Stiffness k in N/m^e, a plain number because its unit depends on the exponent e; 0 leaves the damper alone.
            "stiffness_si": Number = Some(&mut l.0.stiffness_n_per_m_e), allowed(NOT_NEGATIVE);
            /// Exponent e, at least 1; give it together with stiffness_si.
            "exponent": Number = Some(&mut l.0.exponent), allowed(EXPONENT);
            /// Damping c_max, fully engaged beyond the transition; 0 leaves the spring alone.
            "damping": LinearDamping = Some(&mut l.0.damping_max_n_s_per_m), allowed(NOT_NEGATIVE);
            /// Penetration over which the damper engages.
            "transition": Length = Some(&mut l.0.transition_m), allowed(POSITIVE);
        }
    };
}

law! {
    /// Laws of both contacts with the object; [contact.proximal] and [contact.distal] replace single keys for one of them.
    Contact = CONTACT, "materials" in FINGERS: Materials, "friction" in ANY: FrictionLaw, "proximal" in FINGERS: Side,
        "distal" in FINGERS: Side, "palm" in TWO_FINGERS: Side, "table" in TWO_FINGERS: Side, where {
        const DOCS: &'static [(SceneKind, &'static str)] = &[
            (SceneKind::Bodies, "Law of every contact."),
            (
                SceneKind::Gripper,
                "Laws of all contacts with the object; [contact.proximal] and [contact.distal] replace single keys for those \
                 phalanges, of either finger, [contact.palm] and [contact.table] for those.",
            ),
        ];
    }
}

law! {
    /// Law of one contact where it differs from [contact].
    Side = NONE, "materials" in FINGERS: Materials, "friction" in FINGERS: FrictionLaw
}

lines! {
    /// Coulomb friction; left out, the contact is frictionless.
    FrictionLaw = Self { mu_static: 0.0, mu_dynamic: f64::NAN, v_static_m_s: 0.1, v_dynamic_m_s: 0.2, bristle: None }, f;
    /// Static coefficient, reached at v_static; 0 is frictionless.
    "mu_static": Number = Some(&mut f.mu_static), allowed(NOT_NEGATIVE),
        put(|f, mu_static| (f.mu_static, f.mu_dynamic) = (mu_static, f64::NAN));
    /// Dynamic coefficient, beyond v_dynamic. Default: 0.7 mu_static.
    "mu_dynamic": Number = Some(&mut f.mu_dynamic), allowed(NOT_NEGATIVE);
    "v_static": Speed = Some(&mut f.v_static_m_s), allowed(POSITIVE);
    "v_dynamic": Speed = Some(&mut f.v_dynamic_m_s), allowed(POSITIVE);
    /// "regularised": the thesis' law, which creeps; "bristle": a spring and damper before a Coulomb slider, which holds.
    "law": Choice<Option<Bristle>> = Some(&mut f.bristle);
    /// Damping of the bristle. Default: that of the normal law, or 1e6 N*s/m where that has none.
    "bristle_damping": LinearDamping = f.bristle.as_mut().map(|bristle| &mut bristle.damping_n_s_per_m),
        allowed(POSITIVE), beside("law", "without law = \"bristle\"");
    /// Time in which the bristle relaxes: its damping over its stiffness.
    "bristle_relaxation": Time = f.bristle.as_mut().map(|bristle| &mut bristle.relaxation_s),
        allowed(POSITIVE), beside("law", "without law = \"bristle\"");
}

impl Words for Option<Bristle> {
    const WORDS: &'static [(&'static str, Self)] =
        &[("regularised", None), ("bristle", Some(Bristle { damping_n_s_per_m: f64::NAN, relaxation_s: 1e-3 }))];

    fn word(&self) -> &'static str {
        if self.is_some() { "bristle" } else { "regularised" }
    }
}

/// The two surfaces of a Hertz contact.
#[derive(Clone, Copy, Debug)]
pub struct Materials;

lines! {
    /// Materials and radii of the two surfaces instead of stiffness and exponent: Hertz, k = 4/3 E* √R and e = 3/2.
    Materials = Self, _m, "object" in FINGERS: Elastic, "phalanx" in FINGERS: Elastic;
}

/// One surface; not a number what is not given.
#[derive(Clone, Copy, Debug)]
pub struct Elastic {
    pub modulus_pa: f64,
    pub poisson: f64,
    pub radius_m: f64,
}

lines! {
    /// One surface of a Hertz contact.
    Elastic = Self { modulus_pa: f64::NAN, poisson: f64::NAN, radius_m: f64::NAN }, s;
    /// Young's modulus. Required.
    "modulus": Pressure = Some(&mut s.modulus_pa), allowed(POSITIVE), needed("add modulus = \"2.3 GPa\"");
    /// Poisson's ratio, above −1 and up to 0.5. Required.
    "poisson": Number = Some(&mut s.poisson), allowed(POISSON), needed("add poisson = 0.35");
    /// Radius of curvature. Default: the object's radius; a phalanx is flat.
    "radius": Length = Some(&mut s.radius_m), allowed(POSITIVE);
}

/// The joint limit.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    pub enabled: bool,
    /// In rad for m.
    pub law: NormalLaw,
}

impl Limit {
    /// What a scene without a limit would have.
    pub const OFF: Self = Self { enabled: false, law: LIMIT };

    fn law(&mut self) -> Option<&mut NormalLaw> {
        self.enabled.then_some(&mut self.law)
    }
}

lines! {
    /// The stop that keeps the distal phalanx from bending backwards: q22 ≥ −phi22. A contact law on the angle.
    Limit = Self { enabled: true, law: LIMIT }, l;
    "enabled": Flag = Some(&mut l.enabled);
    /// Stiffness k in N·m/rad^e, a plain number because its unit depends on the exponent e.
    "stiffness_si": Number = l.law().map(|law| &mut law.stiffness_n_per_m_e),
        allowed(POSITIVE), beside("enabled", "with enabled = false");
    /// Exponent e, at least 1; give it together with stiffness_si.
    "exponent": Number = l.law().map(|law| &mut law.exponent),
        allowed(EXPONENT), beside("enabled", "with enabled = false");
    /// Damping c_max, fully engaged beyond the transition.
    "damping": AngularDamping = l.law().map(|law| &mut law.damping_max_n_s_per_m),
        allowed(NOT_NEGATIVE), beside("enabled", "with enabled = false");
    /// Penetration over which the damper engages.
    "transition": Angle = l.law().map(|law| &mut law.transition_m),
        allowed(POSITIVE), beside("enabled", "with enabled = false");
}
