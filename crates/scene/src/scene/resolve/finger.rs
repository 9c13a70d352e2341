//! The links of a finger: lengths, given or from a design, and bodies from outlines, material and overrides.

use std::ops::Range;

use super::super::check::Checker;
use super::super::table::finger::{BodySettings, FingerSettings, LengthSettings, MaterialSettings};
use super::super::table::input::SectionInput;
use super::super::table::{SettingsSection, read};
use crate::gripper::{self, Assembly, BodyOverride, Design, DesignError, Finger, Lengths, MassError, ProximalLength};
use crate::numeric::elementary::{cos, hypot, sin};

/// The lengths of a finger, without bodies.
pub struct FingerLengths {
    /// Settings at the top level.
    pub settings: FingerSettings,
    pub lengths: Option<Lengths>,
    /// Base of [design] or [lengths].
    pub base_m: Option<f64>,
}

/// Resolves the lengths from [design] or [lengths].
pub fn resolve_lengths(checker: &mut Checker<'_>, input: &SectionInput<'_>, object_radius_m: f64) -> FingerLengths {
    let settings = read(checker, "", input, FingerSettings::defaults());
    let (design_input, lengths_input) = (input.subsection("design"), input.subsection("lengths"));
    let (mut lengths, mut base_m) = (None, None);
    match (design_input.is_present(), lengths_input.is_present()) {
        (true, true) => checker.push(
            lengths_input.span,
            "the finger is given twice, by [design] and by [lengths]",
            "second definition",
            "keep one of them: [design] for design variables, [lengths] for all lengths",
        ),
        (false, false) => checker.report_missing_at(
            "[design] or [lengths]",
            None,
            "give the finger: [design] with base, l21_fraction, phi22 and arm_ratio, or [lengths] with l21, l22, t22 and \
             phi22",
        ),
        (true, false) => {
            let design = design(checker, &design_input, settings.half_width_m, object_radius_m);
            base_m = design.map(|d| d.base_m);
            lengths = design.and_then(|d| {
                let solved = gripper::lengths(&d);
                solved.map_err(|e| reject_design(checker, &design_input, &e)).ok()
            });
        }
        (false, true) => {
            let keys = read(checker, "lengths", &lengths_input, LengthSettings::defaults());
            base_m = Some(keys.base_m).filter(|base_m| base_m.is_finite());
            lengths = complete_lengths(checker, &lengths_input, Lengths { half_width_m: settings.half_width_m, ..keys.links });
        }
    }
    FingerLengths { settings, lengths, base_m }
}

pub fn design(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    half_width_m: f64,
    object_radius_m: f64,
) -> Option<Design> {
    let mut defaults = Design { half_width_m, object_radius_m, ..Design::defaults() };
    if input.has("l21") {
        defaults.l21 = ProximalLength::Length(f64::NAN);
        if input.has("l21_fraction") {
            checker.push(
                input.span("l21_fraction"),
                "the proximal phalanx is given twice, by `l21` and by `l21_fraction`",
                "second definition",
                "keep one of them",
            );
        }
    }
    let design = read(checker, "design", input, defaults);
    let (ProximalLength::Length(l21) | ProximalLength::Fraction(l21)) = design.l21;
    let values = [design.base_m, l21, design.phi22_rad, design.arm_ratio];
    let is_complete = values.iter().all(|value| value.is_finite()) && !(input.has("l21") && input.has("l21_fraction"));
    is_complete.then_some(design)
}

fn reject_design(checker: &mut Checker<'_>, input: &SectionInput<'_>, error: &DesignError) {
    let error_span = match error {
        DesignError::BaseTooSmall { .. } | DesignError::BaseTooLarge { .. } | DesignError::NoProximalRange { .. } => {
            input.span("base")
        }
        DesignError::ProximalOutOfRange { .. } | DesignError::TipNotPositive { .. } | DesignError::Fraction { .. } => {
            input.span("l21").or(input.span("l21_fraction"))
        }
        DesignError::Phi22 { .. } => input.span("phi22"),
        DesignError::TipContactMin { .. } => input.span("tip_contact_min"),
        _ => None,
    };
    geometry(checker, error_span.or(input.span.clone()), "no finger has this design", &error.to_string());
}

fn complete_lengths(checker: &mut Checker<'_>, input: &SectionInput<'_>, mut lengths: Lengths) -> Option<Lengths> {
    let Lengths { l11_m, l21_m, l22_m, t22_m, phi22_rad, .. } = lengths;
    if !input.has("l12") {
        // Thesis (B.7): straight with l11 on the palm and l21 upright.
        lengths.l12_m = hypot(l11_m - l22_m * sin(phi22_rad), l21_m + l22_m * cos(phi22_rad));
    }
    if [lengths.l12_m, l21_m, l22_m, t22_m, phi22_rad].iter().any(|length| length.is_nan()) {
        return None;
    }
    // Both assembly modes exist if one of them does.
    match gripper::gamma(&lengths, Assembly::Reference) {
        Ok(_) => Some(lengths),
        Err(e) => {
            let error_span = input.span("l12").or(input.span.clone());
            geometry(checker, error_span, "not a finger", &e.to_string());
            None
        }
    }
}

/// Resolves the bodies from outlines, material and overrides.
pub fn finger(checker: &mut Checker<'_>, input: &SectionInput<'_>, finger_lengths: &FingerLengths) -> Option<Finger> {
    let MassSettings { material: MaterialSettings { density_kg_m3, depth_m }, overrides } =
        mass_settings(checker, input);
    let lengths = finger_lengths.lengths?;
    match gripper::bodies_with_overrides(&lengths, density_kg_m3, depth_m, &overrides) {
        Ok(bodies) => Some(Finger { lengths, bodies, assembly: finger_lengths.settings.assembly }),
        Err(e) => {
            let error_span = match e {
                MassError::DegenerateTriangle { .. } => {
                    input.subsection("lengths").span("phi22").or(input.subsection("design").span("phi22"))
                }
                _ => input.subsection("material").span,
            };
            geometry(checker, error_span, "invalid mass", &e.to_string());
            None
        }
    }
}

/// Material, and overrides of the mass properties of l11, l12, l21 and l22.
pub struct MassSettings {
    pub material: MaterialSettings,
    pub overrides: [BodyOverride; 4],
}

pub fn mass_settings(checker: &mut Checker<'_>, input: &SectionInput<'_>) -> MassSettings {
    let bodies = input.subsection("bodies");
    MassSettings {
        material: read(checker, "material", &input.subsection("material"), MaterialSettings::defaults()),
        overrides: BodySettings::NAMES
            .map(|name| read(checker, &format!("bodies.{name}"), &bodies.subsection(name), BodyOverride::default())),
    }
}

/// Reports an error of the geometry; the help is the part of its message after the last colon.
pub fn geometry(checker: &mut Checker<'_>, span: Option<Range<usize>>, label: &str, error: &str) {
    match error.rsplit_once(": ") {
        Some((message, help)) => checker.push(span, message, label, help),
        None => checker.push(span, error, label, "change these lengths or angles"),
    }
}
