//! Contact laws: both contacts with the object, and the joint limit.

use std::ops::Range;

use super::super::Contacts;
use super::super::check::Checker;
use super::super::defaults;
use super::super::table::keys::Keys;
use super::super::table::law::{Contact, Elastic, Limit, Side};
use super::super::table::{Table, read};
use crate::law::{ContactLaw, FrictionLaw, Material, NormalLaw, hertz_stiffness};

const HERTZ_EXPONENT: f64 = 1.5;

/// What one section says of a law: [contact], or what replaces its keys for one contact.
#[derive(Clone, Copy)]
struct Level<'a> {
    path: &'static str,
    /// The law with what this section and those before it say.
    normal: NormalLaw,
    /// Where its stiffness or its damping is given.
    place: &'a Option<Range<usize>>,
    friction: &'a Keys<'a>,
}

/// Laws of both contacts.
pub fn contacts(c: &mut Checker<'_>, raw: &Keys<'_>, object_radius_m: f64) -> Option<Contacts> {
    let (friction, place) = (raw.inner("friction"), place(raw));
    let normal = normal(c, "contact", raw, Contact::usual(), object_radius_m);
    let common = Level { path: "contact", normal, place: &place, friction: &friction };
    let proximal = side(c, "contact.proximal", &raw.inner("proximal"), common, object_radius_m);
    let distal = side(c, "contact.distal", &raw.inner("distal"), common, object_radius_m);
    Some(Contacts { proximal: proximal?, distal: distal? })
}

fn side(
    c: &mut Checker<'_>,
    path: &'static str,
    raw: &Keys<'_>,
    common: Level<'_>,
    object_radius_m: f64,
) -> Option<ContactLaw> {
    let (friction, place) = (raw.inner("friction"), place(raw));
    let normal = normal(c, path, raw, Side(common.normal), object_radius_m);
    law(c, &[common, Level { path, normal, place: &place, friction: &friction }])
}

/// Laws of the object on palm and table, as far as they are there.
pub fn planes(
    c: &mut Checker<'_>,
    raw: &Keys<'_>,
    present: [bool; 2],
    object_radius_m: f64,
) -> Option<[Option<ContactLaw>; 2]> {
    let (friction, place) = (raw.inner("friction"), place(raw));
    let normal = normal(c, "contact", raw, Contact::usual(), object_radius_m);
    let common = Level { path: "contact", normal, place: &place, friction: &friction };
    let mut laws = [None; 2];
    for (index, (key, path)) in [("palm", "contact.palm"), ("table", "contact.table")].into_iter().enumerate() {
        match present[index] {
            true => laws[index] = Some(side(c, path, &raw.inner(key), common, object_radius_m)?),
            false => c.unused_at(path, raw.span(key), &format!("without a {key}")),
        }
    }
    Some(laws)
}

/// The one law of all contacts.
pub fn common(c: &mut Checker<'_>, raw: &Keys<'_>) -> Option<ContactLaw> {
    let (friction, place) = (raw.inner("friction"), place(raw));
    let normal = normal(c, "contact", raw, Contact::usual(), 0.0);
    law(c, &[Level { path: "contact", normal, place: &place, friction: &friction }])
}

fn place(raw: &Keys<'_>) -> Option<Range<usize>> {
    raw.span("stiffness_si").or(raw.span("damping"))
}

/// The law of one contact, from the common section and what replaces it.
fn law(c: &mut Checker<'_>, levels: &[Level<'_>]) -> Option<ContactLaw> {
    let normal = levels.last()?.normal;
    if normal.stiffness_n_per_m_e == 0.0 && normal.damping_max_n_s_per_m == 0.0 {
        let last = levels.iter().rev().find(|level| level.place.is_some()).or(levels.first())?;
        c.push(
            last.place.clone(),
            format!("[{}] has neither stiffness nor damping: nothing would hold the surfaces apart", last.path),
            "both are 0",
            "give one of them a value above 0: stiffness_si = 1e8 or damping = \"1e6 N*s/m\"",
        );
    }
    let friction = friction(c, levels)?;
    Some(ContactLaw { normal, friction })
}

/// The normal law with what a section says of it; the radius is for materials.
fn normal<T: Table + Into<NormalLaw>>(
    c: &mut Checker<'_>,
    path: &str,
    raw: &Keys<'_>,
    base: T,
    object_radius_m: f64,
) -> NormalLaw {
    let normal = read(c, path, raw, base).into();
    judge_exponent(c, path, raw);
    let materials = raw.inner("materials");
    if !materials.is_given() {
        return normal;
    }
    for key in ["stiffness_si", "exponent"].into_iter().filter(|key| raw.has(key)) {
        let why = format!("beside [{path}.materials], which give it");
        c.unused_at(&format!("{path}.{key}"), raw.span(key), &why);
    }
    match hertz(c, &format!("{path}.materials"), &materials, object_radius_m) {
        Some(k) => NormalLaw { stiffness_n_per_m_e: k, exponent: HERTZ_EXPONENT, ..normal },
        None => normal,
    }
}

/// Stiffness and exponent only mean something together.
fn judge_exponent(c: &mut Checker<'_>, path: &str, raw: &Keys<'_>) {
    if raw.has("exponent") && !raw.has("stiffness_si") {
        c.push(
            raw.span("exponent"),
            format!("`{path}.exponent` is given without `stiffness_si`, whose unit depends on it"),
            "stiffness missing",
            "give both: stiffness_si = 1e8 and exponent = 2.2",
        );
    }
}

/// Hertz: k = 4/3 E* √R (thesis (2.33), (2.34), errata 6).
fn hertz(c: &mut Checker<'_>, path: &str, raw: &Keys<'_>, object_radius_m: f64) -> Option<f64> {
    let object = elastic(c, path, "object", raw, object_radius_m);
    let phalanx = elastic(c, path, "phalanx", raw, f64::INFINITY);
    let ((object, object_radius), (phalanx, phalanx_radius)) = (object?, phalanx?);
    let k = hertz_stiffness([object, phalanx], [object_radius, phalanx_radius]);
    if k.is_finite() && k > 0.0 {
        return Some(k);
    }
    let message = format!("these materials give a stiffness of {k}, but it must be finite and above 0");
    c.push(raw.span.clone(), message, "", "check the moduli and radii");
    None
}

/// A surface and its radius, which is `usual_m` unless given.
fn elastic(c: &mut Checker<'_>, path: &str, which: &str, parent: &Keys<'_>, usual_m: f64) -> Option<(Material, f64)> {
    let (path, raw) = (format!("{path}.{which}"), parent.inner(which));
    if !raw.is_given() {
        c.lacks(
            &path,
            parent.span.clone(),
            "give both surfaces: object and phalanx = { modulus = \"2.3 GPa\", poisson = 0.35 }",
        );
        return None;
    }
    let Elastic { modulus_pa, poisson, radius_m } =
        read(c, &path, &raw, Elastic { radius_m: usual_m, ..Elastic::usual() });
    let material = Material { youngs_modulus_pa: modulus_pa, poisson_ratio: poisson };
    (!modulus_pa.is_nan() && !poisson.is_nan()).then_some((material, radius_m))
}

/// Friction: `Some(None)` is frictionless, `None` is wrong. The coefficients of a level go together: a static one
/// replaces the dynamic one of the level before as well.
fn friction(c: &mut Checker<'_>, levels: &[Level<'_>]) -> Option<Option<FrictionLaw>> {
    let before = c.count();
    let mut law = FrictionLaw { mu_static: f64::NAN, ..FrictionLaw::usual() };
    for level in levels {
        law = read(c, &format!("{}.friction", level.path), level.friction, law);
    }
    if c.count() > before {
        return None;
    }
    let Some(Level { path, friction: raw, .. }) = levels.iter().rev().find(|level| level.friction.is_given()) else {
        return Some(None);
    };
    if law.mu_static.is_nan() {
        let help = "add the static coefficient: mu_static = 0.8; 0 is frictionless";
        c.lacks(&format!("{path}.friction.mu_static"), raw.span.clone(), help);
        return None;
    }
    if law.mu_dynamic.is_nan() {
        law.mu_dynamic = defaults::mu_dynamic(law.mu_static);
    }
    let FrictionLaw { mu_static, mu_dynamic, v_static_m_s: v_static, v_dynamic_m_s: v_dynamic, .. } = law;
    if mu_dynamic > mu_static {
        c.push(
            raw.span("mu_dynamic").or(raw.span.clone()),
            format!("`{path}.friction.mu_dynamic` is {mu_dynamic}, but must not exceed mu_static = {mu_static}"),
            format!("from 0 to {mu_static}"),
            "lower mu_dynamic, raise mu_static, or leave mu_dynamic out: it is 0.7 mu_static then",
        );
        return None;
    }
    if v_dynamic <= v_static {
        c.push(
            raw.span("v_dynamic").or(raw.span("v_static")).or(raw.span.clone()),
            format!("`{path}.friction.v_dynamic` is {v_dynamic} m/s, but must be above v_static = {v_static} m/s"),
            "",
            "raise v_dynamic or lower v_static; left out, they are 0.2 m/s and 0.1 m/s",
        );
        return None;
    }
    if let Some(bristle) = law.bristle.as_mut().filter(|bristle| bristle.damping_n_s_per_m.is_nan()) {
        let damping = levels.last().map_or(0.0, |level| level.normal.damping_max_n_s_per_m);
        bristle.damping_n_s_per_m = if damping > 0.0 { damping } else { defaults::BRISTLE_DAMPING_N_S_PER_M };
    }
    Some((mu_static > 0.0).then_some(law))
}

/// The joint limit; `None` where it is switched off.
pub fn limit(c: &mut Checker<'_>, raw: &Keys<'_>) -> Option<NormalLaw> {
    let Limit { enabled, law } = read(c, "limit", raw, Limit::usual());
    judge_exponent(c, "limit", raw);
    enabled.then_some(law)
}
