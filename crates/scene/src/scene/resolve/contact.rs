//! Contact laws of the contacts with the object, and the law of the joint limit.

use std::ops::Range;

use super::super::FingerContactLaws;
use super::super::check::Checker;
use super::super::defaults;
use super::super::table::input::SectionInput;
use super::super::table::law::{ContactOverride, ContactSettings, LimitSettings, SurfaceSettings};
use super::super::table::{SettingsSection, read};
use crate::law::{ContactLaw, FrictionLaw, Material, NormalLaw, hertz_stiffness};

const HERTZ_EXPONENT: f64 = 1.5;

/// One of the sections that determine a law: [contact], or the section that overrides its keys for one contact.
#[derive(Clone, Copy)]
struct Level<'a> {
    path: &'static str,
    /// The normal law after this section is applied.
    normal: NormalLaw,
    /// Position of its stiffness or damping.
    position: &'a Option<Range<usize>>,
    friction: &'a SectionInput<'a>,
}

/// Laws of both contacts.
pub fn contacts(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    object_radius_m: f64,
) -> Option<FingerContactLaws> {
    let (friction, position) = (input.subsection("friction"), position(input));
    let normal = normal(checker, "contact", input, ContactSettings::defaults(), object_radius_m);
    let common_law = Level { path: "contact", normal, position: &position, friction: &friction };
    let proximal = side(checker, "contact.proximal", &input.subsection("proximal"), common_law, object_radius_m);
    let distal = side(checker, "contact.distal", &input.subsection("distal"), common_law, object_radius_m);
    Some(FingerContactLaws { proximal: proximal?, distal: distal? })
}

fn side(
    checker: &mut Checker<'_>,
    path: &'static str,
    input: &SectionInput<'_>,
    common_law: Level<'_>,
    object_radius_m: f64,
) -> Option<ContactLaw> {
    let (friction, position) = (input.subsection("friction"), position(input));
    let normal = normal(checker, path, input, ContactOverride(common_law.normal), object_radius_m);
    law(checker, &[common_law, Level { path, normal, position: &position, friction: &friction }])
}

/// Laws of the contacts of the object with palm and table, if present.
pub fn planes(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    present: [bool; 2],
    object_radius_m: f64,
) -> Option<[Option<ContactLaw>; 2]> {
    let (friction, position) = (input.subsection("friction"), position(input));
    let normal = normal(checker, "contact", input, ContactSettings::defaults(), object_radius_m);
    let common_law = Level { path: "contact", normal, position: &position, friction: &friction };
    let mut laws = [None; 2];
    for (index, (key, path)) in [("palm", "contact.palm"), ("table", "contact.table")].into_iter().enumerate() {
        match present[index] {
            true => laws[index] = Some(side(checker, path, &input.subsection(key), common_law, object_radius_m)?),
            false => checker.report_unused_at(path, input.span(key), &format!("without a {key}")),
        }
    }
    Some(laws)
}

/// Reads the common law of all contacts.
pub fn common_law(checker: &mut Checker<'_>, input: &SectionInput<'_>) -> Option<ContactLaw> {
    let (friction, position) = (input.subsection("friction"), position(input));
    let normal = normal(checker, "contact", input, ContactSettings::defaults(), 0.0);
    law(checker, &[Level { path: "contact", normal, position: &position, friction: &friction }])
}

fn position(input: &SectionInput<'_>) -> Option<Range<usize>> {
    input.span("stiffness_si").or(input.span("damping"))
}

/// Reads the law of one contact, from the common section and its overrides.
fn law(checker: &mut Checker<'_>, levels: &[Level<'_>]) -> Option<ContactLaw> {
    let normal = levels.last()?.normal;
    if normal.stiffness_n_per_m_e == 0.0 && normal.damping_max_n_s_per_m == 0.0 {
        let last = levels.iter().rev().find(|level| level.position.is_some()).or(levels.first())?;
        checker.push(
            last.position.clone(),
            format!("[{}] has neither stiffness nor damping: there would be no contact force", last.path),
            "both are 0",
            "give one of them a value above 0: stiffness_si = 1e8 or damping = \"1e6 N*s/m\"",
        );
    }
    let friction = friction(checker, levels)?;
    Some(ContactLaw { normal, friction })
}

/// Reads the normal law of a section over `base`; the radius is for materials.
fn normal<T: SettingsSection + Into<NormalLaw>>(
    checker: &mut Checker<'_>,
    path: &str,
    input: &SectionInput<'_>,
    base: T,
    object_radius_m: f64,
) -> NormalLaw {
    let normal = read(checker, path, input, base).into();
    check_exponent(checker, path, input);
    let materials = input.subsection("materials");
    if !materials.is_present() {
        return normal;
    }
    for key in ["stiffness_si", "exponent"].into_iter().filter(|key| input.has(key)) {
        let reason = format!("with [{path}.materials], which determine it");
        checker.report_unused_at(&format!("{path}.{key}"), input.span(key), &reason);
    }
    match hertz(checker, &format!("{path}.materials"), &materials, object_radius_m) {
        Some(k) => NormalLaw { stiffness_n_per_m_e: k, exponent: HERTZ_EXPONENT, ..normal },
        None => normal,
    }
}

/// The unit of the stiffness depends on the exponent, so both must be given together.
fn check_exponent(checker: &mut Checker<'_>, path: &str, input: &SectionInput<'_>) {
    if input.has("exponent") && !input.has("stiffness_si") {
        checker.push(
            input.span("exponent"),
            format!("`{path}.exponent` is given without `stiffness_si`, whose unit depends on it"),
            "stiffness missing",
            "give both: stiffness_si = 1e8 and exponent = 2.2",
        );
    }
}

/// Hertz: k = 4/3 E* √R (thesis (2.33), (2.34), errata 6).
fn hertz(checker: &mut Checker<'_>, path: &str, input: &SectionInput<'_>, object_radius_m: f64) -> Option<f64> {
    let object = elastic(checker, path, "object", input, object_radius_m);
    let phalanx = elastic(checker, path, "phalanx", input, f64::INFINITY);
    let ((object, object_radius), (phalanx, phalanx_radius)) = (object?, phalanx?);
    let k = hertz_stiffness([object, phalanx], [object_radius, phalanx_radius]);
    if k.is_finite() && k > 0.0 {
        return Some(k);
    }
    let message = format!("these materials give a stiffness of {k}, but it must be finite and above 0");
    checker.push(input.span.clone(), message, "", "check the moduli and radii");
    None
}

/// Reads a surface and its radius.
fn elastic(
    checker: &mut Checker<'_>,
    path: &str,
    surface: &str,
    parent: &SectionInput<'_>,
    default_m: f64,
) -> Option<(Material, f64)> {
    let (path, input) = (format!("{path}.{surface}"), parent.subsection(surface));
    if !input.is_present() {
        checker.report_missing_at(
            &path,
            parent.span.clone(),
            "give both surfaces: object = { modulus = \"2.3 GPa\", poisson = 0.35 }, and phalanx likewise",
        );
        return None;
    }
    let SurfaceSettings { modulus_pa, poisson, radius_m } =
        read(checker, &path, &input, SurfaceSettings { radius_m: default_m, ..SurfaceSettings::defaults() });
    let material = Material { youngs_modulus_pa: modulus_pa, poisson_ratio: poisson };
    (!modulus_pa.is_nan() && !poisson.is_nan()).then_some((material, radius_m))
}

/// Friction law: `Some(None)` without friction, `None` if invalid. A static coefficient also replaces the dynamic
/// coefficient of the preceding level.
fn friction(checker: &mut Checker<'_>, levels: &[Level<'_>]) -> Option<Option<FrictionLaw>> {
    let problem_count = checker.count();
    let mut law = FrictionLaw { mu_static: f64::NAN, ..FrictionLaw::defaults() };
    for level in levels {
        law = read(checker, &format!("{}.friction", level.path), level.friction, law);
    }
    if checker.count() > problem_count {
        return None;
    }
    let Some(Level { path, friction: input, .. }) = levels.iter().rev().find(|level| level.friction.is_present())
    else {
        return Some(None);
    };
    if law.mu_static.is_nan() {
        let help = "add the static coefficient: mu_static = 0.8, or 0 for no friction";
        checker.report_missing_at(&format!("{path}.friction.mu_static"), input.span.clone(), help);
        return None;
    }
    if law.mu_dynamic.is_nan() {
        law.mu_dynamic = defaults::mu_dynamic(law.mu_static);
    }
    let FrictionLaw { mu_static, mu_dynamic, v_static_m_s: v_static, v_dynamic_m_s: v_dynamic, .. } = law;
    if mu_dynamic > mu_static {
        checker.push(
            input.span("mu_dynamic").or(input.span.clone()),
            format!("`{path}.friction.mu_dynamic` is {mu_dynamic}, but must not exceed mu_static = {mu_static}"),
            format!("from 0 to {mu_static}"),
            "lower mu_dynamic, raise mu_static, or remove mu_dynamic (default: 0.7 mu_static)",
        );
        return None;
    }
    if v_dynamic <= v_static {
        checker.push(
            input.span("v_dynamic").or(input.span("v_static")).or(input.span.clone()),
            format!("`{path}.friction.v_dynamic` is {v_dynamic} m/s, but must be above v_static = {v_static} m/s"),
            "",
            "raise v_dynamic, lower v_static, or remove both (defaults: 0.2 m/s and 0.1 m/s)",
        );
        return None;
    }
    if let Some(bristle) = law.bristle.as_mut().filter(|bristle| bristle.damping_n_s_per_m.is_nan()) {
        let damping = levels.last().map_or(0.0, |level| level.normal.damping_max_n_s_per_m);
        bristle.damping_n_s_per_m = if damping > 0.0 { damping } else { defaults::BRISTLE_DAMPING_N_S_PER_M };
    }
    Some((mu_static > 0.0).then_some(law))
}

/// Reads the law of the joint limit; `None` if it is disabled.
pub fn limit(checker: &mut Checker<'_>, input: &SectionInput<'_>) -> Option<NormalLaw> {
    let LimitSettings { enabled, law } = read(checker, "limit", input, LimitSettings::defaults());
    check_exponent(checker, "limit", input);
    enabled.then_some(law)
}
