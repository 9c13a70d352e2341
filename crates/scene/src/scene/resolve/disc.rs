//! Discs: one by one, and whether they can start where they are.

use std::ops::Range;

use toml::Spanned;

use super::super::check::Checker;
use super::super::entry::Section;
use super::super::kinds::Choice;
use super::super::table::disc::DiscKeys;
use super::super::table::half_plane::Ground;
use super::super::table::keys::Keys;
use super::super::table::{Table, read};
use super::super::words::Motion;
use super::super::{Disc, DiscMotion};
use crate::numeric::elementary::{hypot, powi};
use crate::units::{Dimension, format};

/// Name of the half plane in pairs.
const PLANE: &str = "plane";

/// A sound disc, and the place of its centre in the file.
pub struct Placed {
    pub disc: Disc,
    pub span: Option<Range<usize>>,
}

/// One disc; `None` where something is wrong with it.
pub fn disc(c: &mut Checker<'_>, name: &Spanned<String>, raw: &Section<Keys<DiscKeys>>) -> Option<Placed> {
    let named = judge_name(c, name);
    let name = name.get_ref();
    let said = read(c, &format!("discs.{name}"), raw, DiscKeys::usual());
    // An unknown motion says nothing about the other keys.
    if !raw.is_known::<Choice<Motion>>("motion") {
        return None;
    }
    let DiscKeys { radius_m, centre_m, velocity_m_s, acceleration_m_s2, mass_kg, spin_rad_s, .. } = said;
    let motion = match said.motion {
        Motion::Fixed => DiscMotion::Fixed,
        Motion::Driven => DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s },
        Motion::Free => {
            let inertia_kg_m2 = inertia(c, name, raw, &said)?;
            if mass_kg.is_nan() {
                return None;
            }
            DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s }
        }
    };
    if radius_m.is_nan() || centre_m[0].is_nan() {
        return None;
    }
    Some(Placed { disc: Disc { name: named?, radius_m, centre_m, angle_rad: 0.0, motion }, span: raw.span("centre") })
}

/// Names stand in topics, keys and columns, joined by `-` in those of pairs.
fn judge_name(c: &mut Checker<'_>, name: &Spanned<String>) -> Option<String> {
    let text = name.get_ref();
    let fit = text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let problem = if text.is_empty() {
        "the name of a disc is empty".to_string()
    } else if text == PLANE {
        format!("no disc may be called `{PLANE}`: that is the half plane")
    } else if !fit {
        format!("`{}` cannot be the name of a disc", text.escape_debug())
    } else {
        return Some(text.clone());
    };
    let help =
        "begin with a letter, go on with letters, digits and _ : [discs.hammer_2]; topics and keys are made of it";
    c.push(Some(name.span()), problem, "not a name", help);
    None
}

/// Inertia of a free disc: `Some(None)` if it does not turn, `None` where it is wrong.
fn inertia(c: &mut Checker<'_>, name: &str, raw: &Keys<DiscKeys>, said: &DiscKeys) -> Option<Option<f64>> {
    if !said.rotates {
        for key in ["inertia", "spin"] {
            c.unused_at(&format!("discs.{name}.{key}"), raw.span(key), "with rotates = false");
        }
        return Some(None);
    }
    if raw.has("inertia") {
        return Some(said.inertia_kg_m2).filter(|inertia| !inertia.is_nan()).map(Some);
    }
    let homogeneous = 0.5 * said.mass_kg * powi(said.radius_m, 2);
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
pub fn judge_starts(c: &mut Checker<'_>, discs: &[Placed], half_plane: Option<Ground>) {
    for (index, second) in discs.iter().enumerate() {
        for first in &discs[..index] {
            let (a, b) = (&first.disc, &second.disc);
            let distance_m = hypot(a.centre_m[0] - b.centre_m[0], a.centre_m[1] - b.centre_m[1]);
            let moves = a.motion.moves() || b.motion.moves();
            if !moves || distance_m > a.radius_m.max(b.radius_m) {
                continue;
            }
            let length = |metres| format(metres, Dimension::Length);
            c.push(
                second.span.clone(),
                format!(
                    "the centre of one of `{}` and `{}` starts within the other: the centres are {} apart, the radii are \
                     {} and {}",
                    a.name,
                    b.name,
                    length(distance_m),
                    length(a.radius_m),
                    length(b.radius_m)
                ),
                "too deep",
                "move them apart: surfaces may overlap at the start, but a centre must be outside of the other disc",
            );
        }
        if let Some(plane) = half_plane
            && second.disc.motion.moves()
            && second.disc.centre_m[1] <= plane.level_m
        {
            let (height, level) = (second.disc.centre_m[1], plane.level_m);
            c.push(
                second.span.clone(),
                format!(
                    "the centre of `{}` starts in the half plane: y = {}, level {}",
                    second.disc.name,
                    format(height, Dimension::Length),
                    format(level, Dimension::Length)
                ),
                "too deep",
                "raise the disc, or lower `half_plane.level`: its surface may overlap at the start, its centre may not",
            );
        }
    }
}
