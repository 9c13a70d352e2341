//! The finger: lengths from a design or as given, and bodies from outlines, material and overrides.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use super::super::check::{Bound, Checker, POSITIVE};
use super::super::defaults;
use super::super::entry::Section;
use super::super::raw::{RawBody, RawDesign, RawScene};
use super::super::table::finger::{Material, PHI22};
use super::super::table::keys::Keys;
use super::super::table::{Table, read};
use crate::gripper::{
    self, Assembly, BodyOverride, Design, DesignError, Finger, HEIGHT_RATIO, Lengths, MassError, ProximalLength,
    TIP_CONTACT_MIN_RAD,
};
use crate::numeric::elementary::{cos, hypot, sin};

const FRACTION: Bound = Bound { allowed: |x| (0.0..=1.0).contains(&x), text: "from 0 to 1" };
const TIP_CONTACT: Bound = Bound { allowed: |x| x.abs() < FRAC_PI_2, text: "between -90 and 90 deg, both excluded" };

/// The finger as far as its lengths.
pub struct Plan {
    pub lengths: Option<Lengths>,
    pub assembly: Assembly,
    /// Base of the design; `None` for a finger given by its lengths.
    pub base_m: Option<f64>,
}

/// Half width w of every link.
pub fn half_width(c: &mut Checker<'_>, raw: &RawScene) -> f64 {
    c.number_or("half_width", &raw.half_width, POSITIVE, defaults::HALF_WIDTH_M)
}

/// Lengths from [design] or [lengths].
pub fn plan(c: &mut Checker<'_>, raw: &RawScene, object_radius_m: f64) -> Plan {
    let half_width_m = half_width(c, raw);
    let assembly = c.or("assembly", &raw.assembly, Assembly::Reference);
    let (mut lengths, mut base_m) = (None, None);
    match (raw.design.is_given(), raw.lengths.is_given()) {
        (true, true) => c.push(
            raw.lengths.span.clone(),
            "the finger is given twice, by [design] and by [lengths]",
            "and here again",
            "keep one of them: [design] for the few free numbers, [lengths] for all lengths",
        ),
        (false, false) => c.missing(
            "[design] or [lengths]",
            &raw.design,
            "give the finger: [design] with base, l21_fraction, phi22 and arm_ratio, or [lengths] with l21, l22, t22 and \
             phi22",
        ),
        (true, false) => {
            let design = design(c, &raw.design, half_width_m, object_radius_m);
            base_m = design.map(|d| d.base_m);
            lengths = design.and_then(|d| {
                let solved = gripper::lengths(&d);
                solved.map_err(|e| refuse_design(c, &raw.design, &e)).ok()
            });
        }
        (false, true) => lengths = given_lengths(c, &raw.lengths, half_width_m),
    }
    Plan { lengths, assembly, base_m }
}

pub fn design(
    c: &mut Checker<'_>,
    raw: &Section<RawDesign>,
    half_width_m: f64,
    object_radius_m: f64,
) -> Option<Design> {
    let base_m =
        c.required("design.base", &raw.base, POSITIVE, raw, "add the distance to the object: base = \"15.5 mm\"");
    let l21 = match (raw.l21.is_given(), raw.l21_fraction.is_given()) {
        (true, true) => {
            c.push(
                raw.l21_fraction.span(),
                "the proximal phalanx is given twice, by `l21` and by `l21_fraction`",
                "and here again",
                "keep one of them",
            );
            None
        }
        (false, false) => {
            let help = "give the proximal phalanx: l21_fraction = 1.0, or a length l21 = \"24 mm\"";
            c.missing("design.l21_fraction", raw, help);
            None
        }
        (true, false) => c.number("design.l21", &raw.l21, POSITIVE).map(ProximalLength::Length),
        (false, true) => c.number("design.l21_fraction", &raw.l21_fraction, FRACTION).map(ProximalLength::Fraction),
    };
    let phi22_rad =
        c.required("design.phi22", &raw.phi22, PHI22, raw, "add the angle of the distal phalanx: phi22 = \"120 deg\"");
    let arm_ratio = c.required("design.arm_ratio", &raw.arm_ratio, POSITIVE, raw, "add l22 / l11: arm_ratio = 0.5");
    let l11_m = c.number_or("design.l11", &raw.l11, POSITIVE, defaults::L11_M);
    let height_ratio = c.number_or("design.height_ratio", &raw.height_ratio, POSITIVE, HEIGHT_RATIO);
    let tip_contact_min_rad =
        c.number_or("design.tip_contact_min", &raw.tip_contact_min, TIP_CONTACT, TIP_CONTACT_MIN_RAD);
    Some(Design {
        base_m: base_m?,
        l21: l21?,
        phi22_rad: phi22_rad?,
        arm_ratio: arm_ratio?,
        l11_m,
        half_width_m,
        object_radius_m,
        height_ratio,
        tip_contact_min_rad,
    })
}

fn refuse_design(c: &mut Checker<'_>, raw: &Section<RawDesign>, error: &DesignError) {
    let place = match error {
        DesignError::BaseTooSmall { .. } | DesignError::BaseTooLarge { .. } | DesignError::NoProximalRange { .. } => {
            raw.base.span()
        }
        DesignError::ProximalOutOfRange { .. } | DesignError::TipNotPositive { .. } | DesignError::Fraction { .. } => {
            raw.l21.span().or(raw.l21_fraction.span())
        }
        DesignError::Phi22 { .. } => raw.phi22.span(),
        DesignError::TipContactMin { .. } => raw.tip_contact_min.span(),
        _ => None,
    };
    geometry(c, place.or(raw.span.clone()), "no finger has this design", &error.to_string());
}

fn given_lengths(c: &mut Checker<'_>, raw: &Section<Keys<Lengths>>, half_width_m: f64) -> Option<Lengths> {
    let mut lengths = read(c, "lengths", raw, Lengths { half_width_m, ..Lengths::usual() });
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
pub fn finger(c: &mut Checker<'_>, raw: &RawScene, plan: &Plan) -> Option<Finger> {
    let Matter { material: Material { density_kg_m3, depth_m }, overrides } = matter(c, raw);
    let lengths = plan.lengths?;
    match gripper::bodies_with(&lengths, density_kg_m3, depth_m, &overrides) {
        Ok(bodies) => Some(Finger { lengths, bodies, assembly: plan.assembly }),
        Err(e) => {
            let place = match e {
                MassError::DegenerateTriangle { .. } => raw.lengths.span("phi22").or(raw.design.phi22.span()),
                _ => raw.material.span.clone(),
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

pub fn matter(c: &mut Checker<'_>, raw: &RawScene) -> Matter {
    Matter {
        material: read(c, "material", &raw.material, Material::usual()),
        overrides: [
            body(c, "bodies.l11", &raw.bodies.l11),
            body(c, "bodies.l12", &raw.bodies.l12),
            body(c, "bodies.l21", &raw.bodies.l21),
            body(c, "bodies.l22", &raw.bodies.l22),
        ],
    }
}

fn body(c: &mut Checker<'_>, path: &str, raw: &Section<RawBody>) -> BodyOverride {
    BodyOverride {
        mass_kg: c.number(&format!("{path}.mass"), &raw.mass, POSITIVE),
        com_m: c.get(&format!("{path}.com"), &raw.com),
        inertia_kg_m2: c.number(&format!("{path}.inertia"), &raw.inertia, POSITIVE),
    }
}

/// A refusal of the geometry; its own message says the way out after its last colon.
pub fn geometry(c: &mut Checker<'_>, span: Option<Range<usize>>, label: &str, error: &str) {
    match error.rsplit_once(": ") {
        Some((message, help)) => c.push(span, message, label, help),
        None => c.push(span, error, label, "change the lengths or angles it names"),
    }
}
