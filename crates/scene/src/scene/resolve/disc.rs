//! Discs: one by one, all, and whether they can start where they are.

use std::ops::Range;

use super::super::check::Checker;
use super::super::kinds::Choice;
use super::super::raw::Raw;
use super::super::table::disc::DiscKeys;
use super::super::table::keys::Keys;
use super::super::table::top::Top;
use super::super::table::{Table, read};
use super::super::words::Motion;
use super::super::{Disc, DiscMotion, System};
use crate::limits::MOST_DISCS;
use crate::numeric::elementary::hypot;
use crate::shape::{self, Shape};
use crate::units::{Dimension, format};

/// Name of the half plane in pairs.
const PLANE: &str = "plane";

/// All discs in the order of their names; `None` where something is wrong with one, or with all.
pub fn discs(c: &mut Checker<'_>, raw: &Raw, gravity_m_s2: [f64; 2]) -> Option<Vec<Disc>> {
    let section = raw.whole().inner("discs");
    let count = section.named().count();
    if count == 0 {
        let help = "a scene of discs needs one that moves: [discs.hammer] with radius, centre and mass";
        c.lacks("[discs.NAME]", section.span, help);
        return None;
    }
    if count > MOST_DISCS {
        c.push(
            section.span,
            format!("there are {count} discs, but at most {MOST_DISCS} are simulated: any two of them may touch"),
            "",
            format!("leave {} of them out", count - MOST_DISCS),
        );
        return None;
    }
    let all: Vec<Option<Disc>> =
        section.named().map(|(name, keys)| disc(c, name, raw.name_span(name), &keys)).collect();
    let all: Vec<Disc> = all.into_iter().collect::<Option<_>>()?;
    if !all.iter().any(|disc| disc.motion.moves()) {
        c.push(
            section.span,
            "every disc is fixed: nothing would happen",
            "",
            "let one of them move: motion = \"free\" with mass, or motion = \"driven\" with velocity",
        );
    }
    let free = |disc: &Disc| matches!(disc.motion, DiscMotion::Free { .. });
    if gravity_m_s2 != Top::usual_gravity_m_s2(raw.kind) && !all.iter().any(free) {
        c.unused_at("gravity", raw.whole().span("gravity"), "without a disc of motion = \"free\"");
    }
    Some(all)
}

/// One disc; `None` where something is wrong with it.
fn disc(c: &mut Checker<'_>, name: &str, place: Option<Range<usize>>, raw: &Keys<'_>) -> Option<Disc> {
    let named = judge_name(c, name, place);
    let path = format!("discs.{name}");
    let (shape, said) = (read(c, &path, raw, Shape::usual_in(raw.kind)), read(c, &path, raw, DiscKeys::usual()));
    // An unknown motion says nothing about the other keys.
    if !raw.is_known::<Choice<Motion>>("motion") {
        return None;
    }
    let DiscKeys { centre_m, velocity_m_s, acceleration_m_s2, mass_kg, spin_rad_s, .. } = said;
    let motion = match said.motion {
        Motion::Fixed => DiscMotion::Fixed,
        Motion::Driven => DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s },
        Motion::Free => {
            let inertia_kg_m2 = inertia(c, name, raw, &said, &shape)?;
            if mass_kg.is_nan() {
                return None;
            }
            DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s }
        }
    };
    if shape::sizes(&shape).any(|(_, size_m)| size_m.is_nan()) || centre_m[0].is_nan() {
        return None;
    }
    Some(Disc { name: named?, shape, centre_m, angle_rad: 0.0, motion })
}

/// Names stand in topics, keys and columns, joined by `-` in those of pairs.
fn judge_name(c: &mut Checker<'_>, text: &str, place: Option<Range<usize>>) -> Option<String> {
    let fit = text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let problem = if text.is_empty() {
        "the name of a disc is empty".to_string()
    } else if text == PLANE {
        format!("no disc may be called `{PLANE}`: that is the half plane")
    } else if !fit {
        format!("`{}` cannot be the name of a disc", text.escape_debug())
    } else {
        return Some(text.to_string());
    };
    let help =
        "begin with a letter, go on with letters, digits and _ : [discs.hammer_2]; topics and keys are made of it";
    c.push(place, problem, "not a name", help);
    None
}

/// Inertia of a free disc: `Some(None)` if it does not turn, `None` where it is wrong.
fn inertia(c: &mut Checker<'_>, name: &str, raw: &Keys<'_>, said: &DiscKeys, shape: &Shape) -> Option<Option<f64>> {
    if !said.rotates {
        for key in ["inertia", "spin"] {
            c.unused_at(&format!("discs.{name}.{key}"), raw.span(key), "with rotates = false");
        }
        return Some(None);
    }
    if raw.has("inertia") {
        return Some(said.inertia_kg_m2).filter(|inertia| !inertia.is_nan()).map(Some);
    }
    let homogeneous = said.mass_kg * shape::inertia(shape, 1.0);
    if homogeneous.is_nan() {
        return None;
    }
    if homogeneous.is_normal() {
        return Some(Some(homogeneous));
    }
    c.push(
        raw.span("mass"),
        format!("the mass and radius of `discs.{name}` give an inertia of {homogeneous:e} kg m^2"),
        "no finite number above 0",
        "check mass and radius, give `inertia`, or say rotates = false",
    );
    None
}

/// Refuses starts in which the centre of one disc is within the other, or in the half plane: no penetration is so deep.
pub fn judge_starts(c: &mut Checker<'_>, raw: &Raw, system: &System) {
    let section = raw.whole().inner("discs");
    for (index, b) in system.discs.iter().enumerate() {
        let place = section.inner(&b.name).span("centre");
        for a in &system.discs[..index] {
            let distance_m = hypot(a.centre_m[0] - b.centre_m[0], a.centre_m[1] - b.centre_m[1]);
            let [one, other] = [a, b].map(|disc| shape::reach(&disc.shape));
            let moves = a.motion.moves() || b.motion.moves();
            if !moves || distance_m > one.max(other) {
                continue;
            }
            let length = |metres| format(metres, Dimension::Length);
            c.push(
                place.clone(),
                format!(
                    "the centre of one of `{}` and `{}` starts within the other: the centres are {} apart, the radii are \
                     {} and {}",
                    a.name,
                    b.name,
                    length(distance_m),
                    length(one),
                    length(other)
                ),
                "too deep",
                "move them apart: surfaces may overlap at the start, but a centre must be outside of the other disc",
            );
        }
        if let Some(plane) = system.palm
            && b.motion.moves()
            && b.centre_m[1] <= plane.level_m
        {
            let (height, level) = (b.centre_m[1], plane.level_m);
            c.push(
                place.clone(),
                format!(
                    "the centre of `{}` starts in the half plane: y = {}, level {}",
                    b.name,
                    format(height, Dimension::Length),
                    format(level, Dimension::Length)
                ),
                "too deep",
                "raise the disc, or lower `half_plane.level`: its surface may overlap at the start, its centre may not",
            );
        }
    }
}
