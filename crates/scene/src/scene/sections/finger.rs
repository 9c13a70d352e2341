//! The links of a finger: lengths, given or from a design, and bodies from outlines, material and overrides.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Display;

use schemars::JsonSchema;
use serde::Deserialize;

use super::FINGERS;
use crate::gripper::{self, Assembly, BodyOverride, Design, DesignError, Finger, Lengths, MassError, ProximalLength};
use crate::numeric::elementary::{cos, hypot, sin};
use crate::scene::quantity::{Angle, Density, Inertia, Length, Mass, Plain, Positive, Quantity, Time, Word};
use crate::scene::section_input::SectionInput;
use crate::sizing::Rule;

/// Keys of a finger at the top level.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct FingerKeys {
    /// Half width w of every link; a phalanx is a capsule of this radius.
    #[schemars(extend("default" = "2.5 mm", "x-kinds" = FINGERS))]
    pub half_width: Positive<Length>,
    /// Assembly mode of the five-bar: "reference": that of the straight configuration; "other": its mirror image.
    #[schemars(extend("default" = "reference", "x-kinds" = FINGERS))]
    pub assembly: Word<Assembly>,
    /// Computes the torques of motor and spring (or the stiffness of a torsional spring with a preload), which must
    /// then be omitted. On a test trajectory up to the object, the spring keeps the finger straight. The motor has the
    /// RMS torque of this "rigid" phase, or of the "whole" trajectory.
    #[schemars(extend("x-kinds" = FINGERS))]
    pub sizing: Option<Word<Rule>>,
    /// Duration of the test trajectory of `sizing`.
    #[schemars(extend("default" = "10 ms", "x-kinds" = FINGERS))]
    pub closing_time: Positive<Time>,
}

/// The finger by its design variables, adapted to the object. Alternative to [lengths].
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct DesignSettings {
    /// Distance along the palm from the ground joints to the object's centre. Required.
    #[schemars(extend("x-required" = "add the distance to the object: base = \"15.5 mm\""))]
    pub base: Option<Positive<Length>>,
    /// Length of the proximal phalanx l21. Alternative to l21_fraction.
    pub l21: Option<Positive<Length>>,
    /// Length of the proximal phalanx as a fraction, 0 to 1, of the range of l21 that the base allows.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0, "x-alternative" = "l21",
        "x-required" = "give the proximal phalanx: l21_fraction = 1.0, or a length l21 = \"24 mm\""))]
    pub l21_fraction: Option<Quantity<Plain>>,
    /// Angle from the arm l22 to the distal phalanx. Required.
    #[schemars(extend("x-exclusiveMinimum" = 0.0, "x-exclusiveMaximum" = PI,
        "x-required" = "add the angle of the distal phalanx: phi22 = \"120 deg\""))]
    pub phi22: Option<Quantity<Angle>>,
    /// Ratio l22 / l11. Required.
    #[schemars(extend("x-required" = "add l22 / l11: arm_ratio = 0.5"))]
    pub arm_ratio: Option<Positive<Plain>>,
    /// Length of the driven link l11.
    #[schemars(extend("default" = "15 mm"))]
    pub l11: Positive<Length>,
    /// Height of the closed finger divided by the object's diameter.
    #[schemars(extend("default" = crate::gripper::HEIGHT_RATIO))]
    pub height_ratio: Positive<Plain>,
    /// Smallest contact angle of the distal phalanx; determines the shortest l21.
    #[schemars(extend("default" = "5 deg", "x-exclusiveMinimum" = -FRAC_PI_2, "x-exclusiveMaximum" = FRAC_PI_2))]
    pub tip_contact_min: Quantity<Angle>,
}

/// The finger by its link lengths. Alternative to [design].
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct LengthSettings {
    /// Distance along the palm from the ground joints to the object's centre: the position of the object of one finger,
    /// half the palm width of a gripper. Alternative to `object.centre` and `palm_width`.
    pub base: Option<Positive<Length>>,
    /// Length of the driven link, between ground joint and coupler.
    #[schemars(extend("default" = "15 mm"))]
    pub l11: Positive<Length>,
    /// Length of the coupler. Default: such that the finger is straight with l11 along the palm and l21 perpendicular
    /// to it.
    pub l12: Option<Positive<Length>>,
    /// Length of the proximal phalanx. Required.
    #[schemars(extend("x-required" = "add the proximal phalanx: l21 = \"24 mm\""))]
    pub l21: Option<Positive<Length>>,
    /// Length of the arm of the distal body, to the coupler. Required.
    #[schemars(extend("x-required" = "add the arm of the distal body: l22 = \"7.5 mm\""))]
    pub l22: Option<Positive<Length>>,
    /// Length of the distal phalanx. Required.
    #[schemars(extend("x-required" = "add the distal phalanx: t22 = \"13 mm\""))]
    pub t22: Option<Positive<Length>>,
    /// Angle from the arm l22 to the distal phalanx. Required.
    #[schemars(extend("x-exclusiveMinimum" = 0.0, "x-exclusiveMaximum" = PI,
        "x-required" = "add the angle of the distal phalanx: phi22 = \"120 deg\""))]
    pub phi22: Option<Quantity<Angle>>,
}

/// Density and depth of the links, which determine masses and inertias together with the outlines.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct MaterialSettings {
    #[schemars(extend("default" = "1070 kg/m^3"))]
    pub density: Positive<Density>,
    /// Extent of the links out of the plane.
    #[schemars(extend("default" = "40 mm"))]
    pub depth: Positive<Length>,
}

/// Mass properties of single bodies that replace those from the outlines.
#[derive(JsonSchema)]
pub struct BodiesSettings {
    pub l11: BodySettings,
    pub l12: BodySettings,
    pub l21: BodySettings,
    pub l22: BodySettings,
}

/// Mass properties of one body: `l11`, `l12`, `l21` or `l22`. If only the mass is given, the inertia from the outline is
/// scaled with it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct BodySettings {
    pub mass: Option<Positive<Mass>>,
    /// Centre of mass relative to the preceding joint: along the link, and to its left.
    pub com: Option<[Quantity<Length>; 2]>,
    /// Moment of inertia about the centre of mass.
    pub inertia: Option<Positive<Inertia>>,
}

/// The settings of a finger at the top level, and its lengths; the bodies are not included.
pub struct FingerLengths {
    pub half_width_m: f64,
    pub assembly: Assembly,
    /// Rule for sizing motor and spring; `None` if their torques are given.
    pub rule: Option<Rule>,
    /// Duration of the test trajectory; unused without sizing.
    pub closing_s: f64,
    pub lengths: Option<Lengths>,
    /// Base, m, as given in [design] or [lengths].
    pub base_m: Option<f64>,
}

/// Resolves the lengths from [design] or [lengths].
pub(crate) fn resolve_lengths(input: &SectionInput<'_>, object_radius_m: f64) -> FingerLengths {
    let FingerKeys { half_width, assembly, sizing, closing_time } = input.read();
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
        return input.refuse("l21_fraction", message, "second definition", "keep one of them");
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
    let overrides = ["l11", "l12", "l21", "l22"].map(|name| {
        let BodySettings { mass, com, inertia } = bodies.subsection(name).read();
        BodyOverride {
            mass_kg: mass.map(|mass| *mass),
            com_m: com.map(|com| com.map(|coordinate| *coordinate)),
            inertia_kg_m2: inertia.map(|inertia| *inertia),
        }
    });
    (input.subsection("material").read(), overrides)
}

/// Resolves the linkage: computes its bodies from outlines, material and overrides.
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

/// Returns a result of the geometry, or reports its error. The part of the message after the last colon becomes the
/// help.
pub fn geometry<T, E: Display>(input: &SectionInput<'_>, key: &str, label: &str, result: Result<T, E>) -> Option<T> {
    let report = |error: E| {
        let error = error.to_string();
        let (message, help) = error.rsplit_once(": ").unwrap_or((&error, "change these lengths or angles"));
        input.report(key, message, label, help);
    };
    result.map_err(report).ok()
}
