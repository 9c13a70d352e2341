//! Contact laws: both contacts with the object, and the joint limit.

use super::super::check::{Bound, Checker, NOT_NEGATIVE, POSITIVE};
use super::super::entry::{Entry, Section};
use super::super::kinds::{Length, LinearDamping, Number};
use super::super::raw::{RawContact, RawElastic, RawFriction, RawLimit, RawMaterials, RawSide};
use super::super::raw_bodies::RawBodiesContact;
use super::super::{Contacts, defaults};
use crate::law::{ContactLaw, FrictionLaw, Material, NormalLaw, hertz_stiffness};

const EXPONENT: Bound = Bound { allowed: |x| x >= 1.0, text: "at least 1" };
const POISSON: Bound = Bound { allowed: |x| x > -1.0 && x <= 0.5, text: "above -1 and up to 0.5" };
const HERTZ_EXPONENT: f64 = 1.5;

/// The keys of one law: those of [contact], or those that replace them for one contact.
struct Keys<'a> {
    path: &'static str,
    stiffness_si: &'a Entry<Number>,
    exponent: &'a Entry<Number>,
    damping: &'a Entry<LinearDamping>,
    transition: &'a Entry<Length>,
    /// `None` where the law cannot come from materials.
    materials: Option<&'a Section<RawMaterials>>,
    friction: &'a Section<RawFriction>,
}

/// Laws of both contacts.
pub fn contacts(c: &mut Checker<'_>, raw: &Section<RawContact>, object_radius_m: f64) -> Option<Contacts> {
    let common = Keys {
        path: "contact",
        stiffness_si: &raw.stiffness_si,
        exponent: &raw.exponent,
        damping: &raw.damping,
        transition: &raw.transition,
        materials: Some(&raw.materials),
        friction: &raw.friction,
    };
    let proximal = law(c, &[&common, &side("contact.proximal", &raw.proximal)], object_radius_m);
    let distal = law(c, &[&common, &side("contact.distal", &raw.distal)], object_radius_m);
    Some(Contacts { proximal: proximal?, distal: distal? })
}

fn side<'a>(path: &'static str, raw: &'a Section<RawSide>) -> Keys<'a> {
    Keys {
        path,
        stiffness_si: &raw.stiffness_si,
        exponent: &raw.exponent,
        damping: &raw.damping,
        transition: &raw.transition,
        materials: Some(&raw.materials),
        friction: &raw.friction,
    }
}

/// Law of every contact of a scene of discs.
pub fn contact(c: &mut Checker<'_>, raw: &RawBodiesContact) -> Option<ContactLaw> {
    let keys = Keys {
        path: "contact",
        stiffness_si: &raw.stiffness_si,
        exponent: &raw.exponent,
        damping: &raw.damping,
        transition: &raw.transition,
        materials: None,
        friction: &raw.friction,
    };
    law(c, &[&keys], 0.0)
}

/// The law of one contact, from the common keys and those that replace them; the radius is for materials.
fn law(c: &mut Checker<'_>, levels: &[&Keys<'_>], object_radius_m: f64) -> Option<ContactLaw> {
    let mut normal = defaults::CONTACT;
    for keys in levels {
        let path = keys.path;
        if let Some((k, e)) = spring(c, path, keys.stiffness_si, keys.exponent, NOT_NEGATIVE, normal.exponent) {
            (normal.stiffness_n_per_m_e, normal.exponent) = (k, e);
        }
        if let Some(materials) = keys.materials.filter(|materials| materials.is_given()) {
            for (key, entry) in [("stiffness_si", keys.stiffness_si), ("exponent", keys.exponent)] {
                c.unused(&format!("{path}.{key}"), entry, &format!("beside [{path}.materials], which give it"));
            }
            if let Some(k) = hertz(c, path, materials, object_radius_m) {
                (normal.stiffness_n_per_m_e, normal.exponent) = (k, HERTZ_EXPONENT);
            }
        }
        let damping = c.number(&format!("{path}.damping"), keys.damping, NOT_NEGATIVE);
        normal.damping_max_n_s_per_m = damping.unwrap_or(normal.damping_max_n_s_per_m);
        let transition = c.number(&format!("{path}.transition"), keys.transition, POSITIVE);
        normal.transition_m = transition.unwrap_or(normal.transition_m);
    }
    if normal.stiffness_n_per_m_e == 0.0 && normal.damping_max_n_s_per_m == 0.0 {
        refuse_nothing(c, levels);
    }
    let friction = friction(c, levels)?;
    Some(ContactLaw { normal, friction })
}

/// A law without spring and damper.
fn refuse_nothing(c: &mut Checker<'_>, levels: &[&Keys<'_>]) {
    let last = levels.iter().rev().find_map(|keys| {
        let span = keys.stiffness_si.span().or(keys.damping.span())?;
        Some((keys.path, span))
    });
    let (path, span) = last.map_or(("contact", None), |(path, span)| (path, Some(span)));
    c.push(
        span,
        format!("[{path}] has neither stiffness nor damping: nothing would hold the surfaces apart"),
        "both are 0",
        "give one of them a value above 0: stiffness_si = 1e8 or damping = \"1e6 N*s/m\"",
    );
}

/// Stiffness and exponent, which only mean something together.
fn spring(
    c: &mut Checker<'_>,
    path: &str,
    stiffness: &Entry<Number>,
    exponent: &Entry<Number>,
    allowed: Bound,
    exponent_before: f64,
) -> Option<(f64, f64)> {
    let k = c.number(&format!("{path}.stiffness_si"), stiffness, allowed);
    let e = c.number(&format!("{path}.exponent"), exponent, EXPONENT);
    if exponent.is_given() && !stiffness.is_given() {
        c.push(
            exponent.span(),
            format!("`{path}.exponent` is given without `stiffness_si`, whose unit depends on it"),
            "stiffness missing",
            "give both: stiffness_si = 1e8 and exponent = 2.2",
        );
    }
    Some((k?, if exponent.is_given() { e? } else { exponent_before }))
}

/// Hertz: k = 4/3 E* √R (thesis (2.33), (2.34), errata 6).
fn hertz(c: &mut Checker<'_>, path: &str, raw: &Section<RawMaterials>, object_radius_m: f64) -> Option<f64> {
    let path = format!("{path}.materials");
    let object = elastic(c, &format!("{path}.object"), &raw.object, raw);
    let phalanx = elastic(c, &format!("{path}.phalanx"), &raw.phalanx, raw);
    let radius = |c: &mut Checker<'_>, which: &str, raw: &RawElastic, default| {
        c.number_or(&format!("{path}.{which}.radius"), &raw.radius, POSITIVE, default)
    };
    let object_radius = radius(c, "object", &raw.object, object_radius_m);
    let phalanx_radius = radius(c, "phalanx", &raw.phalanx, f64::INFINITY);
    let k = hertz_stiffness([object?, phalanx?], [object_radius, phalanx_radius]);
    if k.is_finite() && k > 0.0 {
        return Some(k);
    }
    let message = format!("these materials give a stiffness of {k}, but it must be finite and above 0");
    c.push(raw.span.clone(), message, "", "check the moduli and radii");
    None
}

fn elastic(
    c: &mut Checker<'_>,
    path: &str,
    raw: &Section<RawElastic>,
    parent: &Section<RawMaterials>,
) -> Option<Material> {
    if !raw.is_given() {
        c.missing(path, parent, "give both surfaces: object and phalanx = { modulus = \"2.3 GPa\", poisson = 0.35 }");
        return None;
    }
    let modulus = c.required(&format!("{path}.modulus"), &raw.modulus, POSITIVE, raw, "add modulus = \"2.3 GPa\"");
    let poisson = c.required(&format!("{path}.poisson"), &raw.poisson, POISSON, raw, "add poisson = 0.35");
    Some(Material { youngs_modulus_pa: modulus?, poisson_ratio: poisson? })
}

/// Friction: `Some(None)` is frictionless, `None` is wrong. The coefficients of a level go together: a static one
/// replaces the dynamic one of the level before as well.
fn friction(c: &mut Checker<'_>, levels: &[&Keys<'_>]) -> Option<Option<FrictionLaw>> {
    let (mut mu_static, mut mu_dynamic) = (None, None);
    let (mut v_static, mut v_dynamic) = (defaults::V_STATIC_M_S, defaults::V_DYNAMIC_M_S);
    let mut place = None;
    let mut sound = true;
    for keys in levels {
        let (path, raw) = (keys.path, keys.friction);
        let key = |name: &str| format!("{path}.friction.{name}");
        if raw.mu_static.is_given() {
            mu_static = c.number(&key("mu_static"), &raw.mu_static, NOT_NEGATIVE);
            sound &= mu_static.is_some();
            mu_dynamic = None;
        }
        if raw.mu_dynamic.is_given() {
            mu_dynamic = c.number(&key("mu_dynamic"), &raw.mu_dynamic, NOT_NEGATIVE);
            sound &= mu_dynamic.is_some();
        }
        if raw.v_static.is_given() {
            let v = c.number(&key("v_static"), &raw.v_static, POSITIVE);
            sound &= v.is_some();
            v_static = v.unwrap_or(v_static);
        }
        if raw.v_dynamic.is_given() {
            let v = c.number(&key("v_dynamic"), &raw.v_dynamic, POSITIVE);
            sound &= v.is_some();
            v_dynamic = v.unwrap_or(v_dynamic);
        }
        if raw.is_given() {
            place = Some((path, raw));
        }
    }
    if !sound {
        return None;
    }
    let Some((path, raw)) = place else { return Some(None) };
    let Some(mu_static) = mu_static else {
        let help = "add the static coefficient: mu_static = 0.8; 0 is frictionless";
        c.missing(&format!("{path}.friction.mu_static"), raw, help);
        return None;
    };
    let mu_dynamic = mu_dynamic.unwrap_or(defaults::mu_dynamic(mu_static));
    if mu_dynamic > mu_static {
        c.push(
            raw.mu_dynamic.span().or(raw.span.clone()),
            format!("`{path}.friction.mu_dynamic` is {mu_dynamic}, but must not exceed mu_static = {mu_static}"),
            format!("from 0 to {mu_static}"),
            "lower mu_dynamic, raise mu_static, or leave mu_dynamic out: it is 0.7 mu_static then",
        );
        return None;
    }
    if v_dynamic <= v_static {
        c.push(
            raw.v_dynamic.span().or(raw.v_static.span()).or(raw.span.clone()),
            format!("`{path}.friction.v_dynamic` is {v_dynamic} m/s, but must be above v_static = {v_static} m/s"),
            "",
            "raise v_dynamic or lower v_static; left out, they are 0.2 m/s and 0.1 m/s",
        );
        return None;
    }
    let law = FrictionLaw { mu_static, mu_dynamic, v_static_m_s: v_static, v_dynamic_m_s: v_dynamic };
    Some((mu_static > 0.0).then_some(law))
}

/// The joint limit: `Some(None)` where it is switched off, `None` where it is wrong.
pub fn limit(c: &mut Checker<'_>, raw: &Section<RawLimit>) -> Option<Option<NormalLaw>> {
    let enabled = c.or("limit.enabled", &raw.enabled, true);
    let mut law = defaults::LIMIT;
    if let Some((k, e)) = spring(c, "limit", &raw.stiffness_si, &raw.exponent, POSITIVE, law.exponent) {
        (law.stiffness_n_per_m_e, law.exponent) = (k, e);
    }
    law.damping_max_n_s_per_m = c.number_or("limit.damping", &raw.damping, NOT_NEGATIVE, law.damping_max_n_s_per_m);
    law.transition_m = c.number_or("limit.transition", &raw.transition, POSITIVE, law.transition_m);
    if !enabled {
        c.unused("limit.stiffness_si", &raw.stiffness_si, "with enabled = false");
        c.unused("limit.exponent", &raw.exponent, "with enabled = false");
        c.unused("limit.damping", &raw.damping, "with enabled = false");
        c.unused("limit.transition", &raw.transition, "with enabled = false");
    }
    Some(enabled.then_some(law))
}
