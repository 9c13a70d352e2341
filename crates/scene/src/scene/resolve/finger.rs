//! The links of a finger: lengths from a design or as given, and bodies from outlines, material and overrides.

use std::ops::Range;

use super::super::check::Checker;
use super::super::table::finger::{Bodies, LengthKeys, Links, Material};
use super::super::table::keys::Keys;
use super::super::table::{Table, read};
use crate::gripper::{self, Assembly, BodyOverride, Design, DesignError, Finger, Lengths, MassError, ProximalLength};
use crate::numeric::elementary::{cos, hypot, sin};

/// The finger as far as its lengths.
pub struct Plan {
    /// What is said of it before all sections.
    pub said: Links,
    pub lengths: Option<Lengths>,
    /// Base of the design, or beside the lengths.
    pub base_m: Option<f64>,
}

/// Lengths from [design] or [lengths].
pub fn plan(c: &mut Checker<'_>, raw: &Keys<'_>, object_radius_m: f64) -> Plan {
    let said = read(c, "", raw, Links::usual());
    let (design_said, lengths_said) = (raw.inner("design"), raw.inner("lengths"));
    let (mut lengths, mut base_m) = (None, None);
    match (design_said.is_given(), lengths_said.is_given()) {
        (true, true) => c.push(
            lengths_said.span,
            "the finger is given twice, by [design] and by [lengths]",
            "and here again",
            "keep one of them: [design] for the few free numbers, [lengths] for all lengths",
        ),
        (false, false) => c.lacks(
            "[design] or [lengths]",
            None,
            "give the finger: [design] with base, l21_fraction, phi22 and arm_ratio, or [lengths] with l21, l22, t22 and \
             phi22",
        ),
        (true, false) => {
            let design = design(c, &design_said, said.half_width_m, object_radius_m);
            base_m = design.map(|d| d.base_m);
            lengths = design.and_then(|d| {
                let solved = gripper::lengths(&d);
                solved.map_err(|e| refuse_design(c, &design_said, &e)).ok()
            });
        }
        (false, true) => {
            let keys = read(c, "lengths", &lengths_said, LengthKeys::usual());
            base_m = Some(keys.base_m).filter(|base_m| base_m.is_finite());
            lengths = whole_lengths(c, &lengths_said, Lengths { half_width_m: said.half_width_m, ..keys.links });
        }
    }
    Plan { said, lengths, base_m }
}

pub fn design(c: &mut Checker<'_>, raw: &Keys<'_>, half_width_m: f64, object_radius_m: f64) -> Option<Design> {
    let mut usual = Design { half_width_m, object_radius_m, ..Design::usual() };
    if raw.has("l21") {
        usual.l21 = ProximalLength::Length(f64::NAN);
        if raw.has("l21_fraction") {
            c.push(
                raw.span("l21_fraction"),
                "the proximal phalanx is given twice, by `l21` and by `l21_fraction`",
                "and here again",
                "keep one of them",
            );
        }
    }
    let design = read(c, "design", raw, usual);
    let (ProximalLength::Length(l21) | ProximalLength::Fraction(l21)) = design.l21;
    let said = [design.base_m, l21, design.phi22_rad, design.arm_ratio];
    let is_whole = said.iter().all(|value| value.is_finite()) && !(raw.has("l21") && raw.has("l21_fraction"));
    is_whole.then_some(design)
}

fn refuse_design(c: &mut Checker<'_>, raw: &Keys<'_>, error: &DesignError) {
    let place = match error {
        DesignError::BaseTooSmall { .. } | DesignError::BaseTooLarge { .. } | DesignError::NoProximalRange { .. } => {
            raw.span("base")
        }
        DesignError::ProximalOutOfRange { .. } | DesignError::TipNotPositive { .. } | DesignError::Fraction { .. } => {
            raw.span("l21").or(raw.span("l21_fraction"))
        }
        DesignError::Phi22 { .. } => raw.span("phi22"),
        DesignError::TipContactMin { .. } => raw.span("tip_contact_min"),
        _ => None,
    };
    geometry(c, place.or(raw.span.clone()), "no finger has this design", &error.to_string());
}

fn whole_lengths(c: &mut Checker<'_>, raw: &Keys<'_>, mut lengths: Lengths) -> Option<Lengths> {
    let Lengths { l11_m, l21_m, l22_m, t22_m, phi22_rad, .. } = lengths;
    if !raw.has("l12") {
        // Thesis (B.7): straight with l11 on the palm and l21 upright.
        lengths.l12_m = hypot(l11_m - l22_m * sin(phi22_rad), l21_m + l22_m * cos(phi22_rad));
    }
    if [lengths.l12_m, l21_m, l22_m, t22_m, phi22_rad].iter().any(|length| length.is_nan()) {
        return None;
    }
    // Either assembly mode: both exist where one does.
    match gripper::gamma(&lengths, Assembly::Reference) {
        Ok(_) => Some(lengths),
        Err(e) => {
            let place = raw.span("l12").or(raw.span.clone());
            geometry(c, place, "these lengths make no finger", &e.to_string());
            None
        }
    }
}

/// Bodies from the outlines, with the scene's overrides.
pub fn finger(c: &mut Checker<'_>, raw: &Keys<'_>, plan: &Plan) -> Option<Finger> {
    let Matter { material: Material { density_kg_m3, depth_m }, overrides } = matter(c, raw);
    let lengths = plan.lengths?;
    match gripper::bodies_with(&lengths, density_kg_m3, depth_m, &overrides) {
        Ok(bodies) => Some(Finger { lengths, bodies, assembly: plan.said.assembly }),
        Err(e) => {
            let place = match e {
                MassError::DegenerateTriangle { .. } => {
                    raw.inner("lengths").span("phi22").or(raw.inner("design").span("phi22"))
                }
                _ => raw.inner("material").span,
            };
            geometry(c, place, "the links have no mass", &e.to_string());
            None
        }
    }
}

/// What the bodies are made of, and what is given of each of l11, l12, l21, l22.
pub struct Matter {
    pub material: Material,
    pub overrides: [BodyOverride; 4],
}

pub fn matter(c: &mut Checker<'_>, raw: &Keys<'_>) -> Matter {
    let bodies = raw.inner("bodies");
    Matter {
        material: read(c, "material", &raw.inner("material"), Material::usual()),
        overrides: Bodies::NAMES
            .map(|name| read(c, &format!("bodies.{name}"), &bodies.inner(name), BodyOverride::default())),
    }
}

/// A refusal of the geometry; its own message says the way out after its last colon.
pub fn geometry(c: &mut Checker<'_>, span: Option<Range<usize>>, label: &str, error: &str) {
    match error.rsplit_once(": ") {
        Some((message, help)) => c.push(span, message, label, help),
        None => c.push(span, error, label, "change the lengths or angles it names"),
    }
}
