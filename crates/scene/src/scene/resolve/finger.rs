//! The links of a finger: lengths, given or from a design, and bodies from outlines, material and overrides.

use std::fmt::Display;

use super::super::section_input::SectionInput;
use super::super::settings::{BodySettings, DesignSettings, LengthSettings, MaterialSettings};
use crate::gripper::{self, Assembly, BodyOverride, Design, DesignError, Finger, Lengths, MassError, ProximalLength};
use crate::numeric::elementary::{cos, hypot, sin};
use crate::scene::quantity::{Length, Positive, Time, Word};
use crate::sizing::Rule;

/// The lengths of a finger without bodies, and its settings at the top level.
pub(crate) struct FingerLengths {
    pub half_width_m: f64,
    pub assembly: Assembly,
    /// Sizing of motor and spring; `None` if their torques are given.
    pub rule: Option<Rule>,
    /// Duration of the test trajectory; unused without sizing.
    pub closing_s: f64,
    pub lengths: Option<Lengths>,
    /// Base of [design] or [lengths].
    pub base_m: Option<f64>,
}

/// Keys of a finger at the top level.
#[derive(serde::Deserialize)]
struct TopSettings {
    half_width: Positive<Length>,
    assembly: Word<Assembly>,
    sizing: Option<Word<Rule>>,
    closing_time: Positive<Time>,
}

/// Resolves the lengths from [design] or [lengths].
pub(crate) fn resolve_lengths(input: &SectionInput<'_>, object_radius_m: f64) -> FingerLengths {
    let TopSettings { half_width, assembly, sizing, closing_time } = input.read();
    let (half_width_m, rule) = (*half_width, sizing.map(|rule| rule.0));
    let (design_input, lengths_input) = (input.subsection("design"), input.subsection("lengths"));
    let (mut lengths, mut base_m) = (None, None);
    match (design_input.is_present(), lengths_input.is_present()) {
        (true, true) => {
            let message = "the finger is given twice, by [design] and by [lengths]";
            let help = "keep one of them: [design] for design variables, [lengths] for all lengths";
            lengths_input.report("", message, "second definition", help);
        }
        (false, false) => input.checker.report_missing_at(
            "[design] or [lengths]",
            None,
            "give the finger: [design] with base, l21_fraction, phi22 and arm_ratio, or [lengths] with l21, l22, t22 and phi22",
        ),
        (true, false) => {
            let design = design(&design_input, half_width_m, object_radius_m);
            base_m = design.map(|design| design.base_m);
            lengths = design.and_then(|design| {
                let lengths = gripper::lengths(&design);
                let key = lengths.as_ref().map_or_else(|error| wrong_key(&design_input, error), |_| "");
                geometry(&design_input, key, "no finger has this design", lengths)
            });
        }
        (false, true) => {
            let settings: LengthSettings = lengths_input.read();
            base_m = settings.base.map(|base| *base);
            lengths = complete_lengths(&lengths_input, &settings, half_width_m);
        }
    }
    FingerLengths { half_width_m, assembly: assembly.0, rule, closing_s: *closing_time, lengths, base_m }
}

/// Reads the design variables; `None` if they are incomplete.
pub fn design(input: &SectionInput<'_>, half_width_m: f64, object_radius_m: f64) -> Option<Design> {
    let settings: DesignSettings = input.read();
    let DesignSettings { base, l21, l21_fraction, phi22, arm_ratio, l11, height_ratio, tip_contact_min } = settings;
    if input.has("l21") && input.has("l21_fraction") {
        let message = "the proximal phalanx is given twice, by `l21` and by `l21_fraction`";
        input.report("l21_fraction", message, "second definition", "keep one of them");
        return None;
    }
    let l21 = l21.map(|l21_m| ProximalLength::Length(*l21_m));
    Some(Design {
        base_m: *base?,
        l21: l21.or(l21_fraction.map(|fraction| ProximalLength::Fraction(*fraction)))?,
        phi22_rad: *phi22?,
        arm_ratio: *arm_ratio?,
        l11_m: *l11,
        half_width_m,
        object_radius_m,
        height_ratio: *height_ratio,
        tip_contact_min_rad: *tip_contact_min,
    })
}

/// Key of [design] that an error is about.
fn wrong_key(input: &SectionInput<'_>, error: &DesignError) -> &'static str {
    match error {
        DesignError::BaseTooSmall { .. } | DesignError::BaseTooLarge { .. } | DesignError::NoProximalRange { .. } => {
            "base"
        }
        DesignError::ProximalOutOfRange { .. } | DesignError::TipNotPositive { .. } | DesignError::Fraction { .. } => {
            if input.has("l21") {
                "l21"
            } else {
                "l21_fraction"
            }
        }
        DesignError::Phi22 { .. } => "phi22",
        DesignError::TipContactMin { .. } => "tip_contact_min",
        _ => "",
    }
}

fn complete_lengths(input: &SectionInput<'_>, settings: &LengthSettings, half_width_m: f64) -> Option<Lengths> {
    let (l11_m, l21_m, l22_m, t22_m) = (*settings.l11, *settings.l21?, *settings.l22?, *settings.t22?);
    let phi22_rad = *settings.phi22?;
    // Thesis (B.7): straight with l11 on the palm and l21 upright.
    let straight_m = || hypot(l11_m - l22_m * sin(phi22_rad), l21_m + l22_m * cos(phi22_rad));
    input.is_valid("l12").then_some(())?;
    let l12_m = settings.l12.map_or_else(straight_m, |l12_m| *l12_m);
    let lengths = Lengths { l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad, half_width_m };
    // Both assembly modes exist if one of them does.
    geometry(input, "l12", "not a finger", gripper::gamma(&lengths, Assembly::Reference)).map(|_| lengths)
}

/// Material, and overrides of the mass properties of l11, l12, l21 and l22.
pub(crate) fn mass_settings(input: &SectionInput<'_>) -> (MaterialSettings, [BodyOverride; 4]) {
    let bodies = input.subsection("bodies");
    let overrides = ["l11", "l12", "l21", "l22"].map(|name| bodies.subsection(name).read::<BodySettings>().into());
    (input.subsection("material").read(), overrides)
}

/// Resolves the bodies from outlines, material and overrides.
pub fn linkage(input: &SectionInput<'_>, lengths: &FingerLengths) -> Option<Finger> {
    let (material, overrides) = mass_settings(input);
    let (assembly, lengths) = (lengths.assembly, lengths.lengths?);
    let bodies = gripper::bodies_with_overrides(&lengths, *material.density, *material.depth, &overrides);
    let section = match bodies {
        Err(MassError::DegenerateTriangle { .. }) if input.has("lengths") => "lengths",
        Err(MassError::DegenerateTriangle { .. }) => "design",
        _ => "material",
    };
    let bodies = geometry(&input.subsection(section), "phi22", "invalid mass", bodies)?;
    Some(Finger { lengths, bodies, assembly })
}

/// Example of a base for messages, with three digits. As in the example of the thesis, it exceeds the smallest base of
/// a design (D > R, see `gripper::proximal_range`).
pub(crate) fn example_base_m(half_width_m: f64, reach_m: f64) -> f64 {
    let base_m = (half_width_m * (2.0 * reach_m + half_width_m)).sqrt() + 0.25 * reach_m;
    format!("{base_m:.2e}").parse().unwrap_or(base_m)
}

/// Returns a result of the geometry, or reports its error; the help is the part of its message after the last colon.
pub fn geometry<T, E: Display>(input: &SectionInput<'_>, key: &str, label: &str, result: Result<T, E>) -> Option<T> {
    let report = |error: E| {
        let error = error.to_string();
        let (message, help) = error.rsplit_once(": ").unwrap_or((&error, "change these lengths or angles"));
        input.report(key, message, label, help);
    };
    result.map_err(report).ok()
}
