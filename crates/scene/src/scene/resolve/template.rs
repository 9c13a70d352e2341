//! A sound scene as the template of many designs.

use super::super::check::Checker;
use super::super::error::Problem;
use super::super::raw::Raw;
use super::super::table::finger::Links;
use super::super::table::keys::Keys;
use super::super::table::{Table, read};
use super::super::{Scene, Side, Template};
use super::{finger, object, start};
use crate::gripper::Design;
use crate::law::ContactLaw;
use crate::shape;

/// Reads once more what a resolved scene does not keep; `scene` is the same one, resolved.
pub fn template(raw: &Raw, mut c: Checker<'_>, scene: &Scene) -> Result<Template, Vec<Problem>> {
    let raw = &raw.finger(Side::Right);
    let said = read(&mut c, "", raw, Links::usual());
    let design = design(&mut c, raw, said.half_width_m);
    let (object, initial) = (raw.inner("object"), raw.inner("initial"));
    if object.has("centre") {
        c.push(
            object.span("centre"),
            "designs are made for an object that stands on the palm at their base, but this scene places it",
            "one place for all bases",
            "leave the centre out: the base places the object",
        );
    }
    for key in ["q11", "q21"] {
        if initial.has(key) {
            c.push(
                initial.span(key),
                format!(
                    "`initial.{key}` is the start of one finger, but the contact it closes to moves with the design"
                ),
                "one start for all designs",
                "give how far before the contact all of them start: [initial] offset = \"25 deg\"",
            );
        }
    }
    let finger::Matter { material, overrides } = finger::matter(&mut c, raw);
    let opening_rad = start::start(&mut c, raw).0;
    let mu = |law: &ContactLaw| law.friction.map_or(0.0, |friction| friction.mu_static);
    match design {
        Some(design) if c.is_clean() => Ok(Template {
            name: scene.name.clone(),
            design,
            density_kg_m3: material.density_kg_m3,
            depth_m: material.depth_m,
            overrides,
            assembly: scene.finger().linkage.assembly,
            opening_rad,
            gravity_m_s2: scene.system.gravity_m_s2,
            closing_s: said.closing_s,
            rule: said.sizing,
            mu_static: [mu(&scene.finger().contact.proximal), mu(&scene.finger().contact.distal)],
        }),
        _ => Err(c.into_problems()),
    }
}

fn design(c: &mut Checker<'_>, raw: &Keys<'_>, half_width_m: f64) -> Option<Design> {
    if raw.inner("lengths").is_given() {
        c.push(
            raw.inner("lengths").span,
            "this scene gives the lengths of one finger, but a template gives a design of which some numbers are free",
            "one finger",
            "replace [lengths] by [design] with base, l21_fraction, phi22 and arm_ratio; see scenes/experiment-95.toml",
        );
        return None;
    }
    let object = object::shape(c, raw);
    finger::design(c, &raw.inner("design"), half_width_m, shape::reach(&object))
}
