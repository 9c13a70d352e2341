//! The links of a finger: lengths, given or from a design, and bodies from outlines, material and overrides.

use super::super::section_input::SectionInput;
use super::super::settings::{BodySettings, DesignSettings, LengthSettings, MaterialSettings};
use super::super::{DrivenFinger, Motor, Side, defaults};
use super::drive::SizingResult;
use super::object::Target;
use super::{contact, drive, start};
use crate::gripper::{self, Assembly, BodyOverride, Design, DesignError, Finger, Lengths, MassError, ProximalLength};
use crate::numeric::elementary::{cos, hypot, sin};
use crate::scene::quantity::{Length, Positive, Time, Word};
use crate::sizing::Rule;

/// The lengths of a finger without bodies, and its settings at the top level.
pub struct FingerLengths {
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
pub fn resolve_lengths(input: &SectionInput<'_>, object_radius_m: f64) -> FingerLengths {
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
                gripper::lengths(&design).map_err(|error| reject_design(&design_input, &error)).ok()
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

fn reject_design(input: &SectionInput<'_>, error: &DesignError) {
    let key = match error {
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
    };
    geometry(input, key, "no finger has this design", &error.to_string());
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
    match gripper::gamma(&lengths, Assembly::Reference) {
        Ok(_) => Some(lengths),
        Err(error) => {
            geometry(input, "l12", "not a finger", &error.to_string());
            None
        }
    }
}

/// Material, and overrides of the mass properties of l11, l12, l21 and l22.
pub fn mass_settings(input: &SectionInput<'_>) -> (MaterialSettings, [BodyOverride; 4]) {
    let bodies = input.subsection("bodies");
    let overrides = ["l11", "l12", "l21", "l22"].map(|name| bodies.subsection(name).read::<BodySettings>().into());
    (input.subsection("material").read(), overrides)
}

/// Resolves the bodies from outlines, material and overrides.
fn linkage(input: &SectionInput<'_>, lengths: &FingerLengths) -> Option<Finger> {
    let (material, overrides) = mass_settings(input);
    let (assembly, lengths) = (lengths.assembly, lengths.lengths?);
    match gripper::bodies_with_overrides(&lengths, *material.density, *material.depth, &overrides) {
        Ok(bodies) => Some(Finger { lengths, bodies, assembly }),
        Err(error) => {
            let section = match error {
                MassError::DegenerateTriangle { .. } if input.has("lengths") => "lengths",
                MassError::DegenerateTriangle { .. } => "design",
                _ => "material",
            };
            geometry(&input.subsection(section), "phi22", "invalid mass", &error.to_string());
            None
        }
    }
}

/// Data a finger depends on.
pub struct FingerEnvironment {
    pub side: Side,
    pub gravity_m_s2: [f64; 2],
    /// Whether the finger has a motor of its own.
    pub has_motor: bool,
    /// Radius of curvature of the object.
    pub curvature_m: f64,
    /// The object it closes on; `None` if that is invalid.
    pub target: Option<Target>,
}

/// Resolves a finger with its drive and initial configuration; also returns its sizing.
pub fn driven_finger(
    input: &SectionInput<'_>,
    lengths: &FingerLengths,
    environment: FingerEnvironment,
) -> (SizingResult, Option<DrivenFinger>) {
    let FingerEnvironment { side, gravity_m_s2: [x, y], has_motor, curvature_m, target } = environment;
    let linkage = linkage(input, lengths);
    let finger_and_target = linkage.as_ref().zip(target.as_ref());
    let sized = drive::size(input, lengths, finger_and_target, [side.mirror() * x, y]);
    let motor = if has_motor { drive::motor(&input.subsection("motor"), sized) } else { Some(Motor::NONE) };
    let spring = drive::spring(&input.subsection("spring"), sized);
    let limit = contact::limit(&input.subsection("limit"));
    let contact = contact::finger_laws(&input.subsection("contact"), curvature_m);
    let initial = start::initial(input, lengths, finger_and_target, limit);
    let finger = || {
        Some(DrivenFinger {
            linkage: linkage?,
            motor: motor?,
            spring: spring?,
            limit,
            contact: contact?,
            initial: initial?,
        })
    };
    (sized, finger())
}

/// Example of a base for messages, with three digits. As in the example of the thesis, it exceeds the smallest base of
/// a design (D > R, see `gripper::proximal_range`).
pub fn example_base_m(lengths: Option<&FingerLengths>, reach_m: f64) -> f64 {
    let half_width_m = lengths.map_or(defaults::HALF_WIDTH_M, |lengths| lengths.half_width_m);
    let base_m = (half_width_m * (2.0 * reach_m + half_width_m)).sqrt() + 0.25 * reach_m;
    format!("{base_m:.2e}").parse().unwrap_or(base_m)
}

/// Reports an error of the geometry; the help is the part of its message after the last colon.
pub fn geometry(input: &SectionInput<'_>, key: &str, label: &str, error: &str) {
    let (message, help) = error.rsplit_once(": ").unwrap_or((error, "change these lengths or angles"));
    input.report(key, message, label, help);
}
