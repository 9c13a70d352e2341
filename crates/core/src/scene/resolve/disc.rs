//! Discs: one by one, and whether they can start where they are.

use std::ops::Range;

use toml::Spanned;

use super::super::check::{Checker, POSITIVE};
use super::super::entry::Section;
use super::super::raw_bodies::RawDisc;
use super::super::words::Motion;
use super::super::{DiscMotion, HalfPlane, NamedDisc};
use crate::numeric::elementary::{hypot, powi};
use crate::units::{Dimension, format};

/// Name of the half plane in pairs.
const PLANE: &str = "plane";

/// A sound disc, and the place of its centre in the file.
pub struct Placed {
    pub disc: NamedDisc,
    pub span: Option<Range<usize>>,
}

/// One disc; `None` where something is wrong with it.
pub fn disc(c: &mut Checker<'_>, name: &Spanned<String>, raw: &Section<RawDisc>) -> Option<Placed> {
    let named = judge_name(c, name);
    let name = name.get_ref();
    let key = |key: &str| format!("discs.{name}.{key}");
    let radius = c.required(&key("radius"), &raw.radius, POSITIVE, raw, "add its size: radius = \"10 mm\"");
    if !raw.centre.is_given() {
        c.missing(&key("centre"), raw, "add where it starts: centre = [\"0 mm\", \"10 mm\"]");
    }
    let centre = c.get(&key("centre"), &raw.centre);
    // An unknown motion says nothing about the other keys.
    let motion = match raw.motion.is_given() {
        true => c.get(&key("motion"), &raw.motion)?,
        false => Motion::Free,
    };
    refuse_unused(c, name, raw, motion);
    let velocity_m_s = c.or(&key("velocity"), &raw.velocity, [0.0; 2]);
    let acceleration_m_s2 = c.or(&key("acceleration"), &raw.acceleration, [0.0; 2]);
    let spin_rad_s = c.or(&key("spin"), &raw.spin, 0.0);
    let motion = match motion {
        Motion::Fixed => Some(DiscMotion::Fixed),
        Motion::Driven => Some(DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s }),
        Motion::Free => {
            let help = "add its mass: mass = \"100 g\"; or drive it: motion = \"driven\" with velocity";
            let mass = c.required(&key("mass"), &raw.mass, POSITIVE, raw, help);
            let inertia = inertia(c, name, raw, mass, radius);
            mass.zip(inertia).map(|(mass_kg, inertia_kg_m2)| DiscMotion::Free {
                mass_kg,
                inertia_kg_m2,
                velocity_m_s,
                spin_rad_s,
            })
        }
    };
    let disc = NamedDisc { name: named?, radius_m: radius?, centre_m: centre?, motion: motion? };
    Some(Placed { disc, span: raw.centre.span() })
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

fn refuse_unused(c: &mut Checker<'_>, name: &str, raw: &RawDisc, motion: Motion) {
    let key = |key: &str| format!("discs.{name}.{key}");
    if motion == Motion::Fixed {
        c.unused(&key("velocity"), &raw.velocity, "with motion = \"fixed\"");
        c.unused(&key("spin"), &raw.spin, "with motion = \"fixed\"");
    }
    if motion != Motion::Driven {
        c.unused(&key("acceleration"), &raw.acceleration, "without motion = \"driven\"");
    }
    if motion != Motion::Free {
        c.unused(&key("mass"), &raw.mass, "without motion = \"free\"");
        c.unused(&key("inertia"), &raw.inertia, "without motion = \"free\"");
        c.unused(&key("rotates"), &raw.rotates, "without motion = \"free\"");
    }
}

/// Inertia of a free disc: `Some(None)` if it does not turn, `None` where it is wrong.
fn inertia(
    c: &mut Checker<'_>,
    name: &str,
    raw: &RawDisc,
    mass: Option<f64>,
    radius: Option<f64>,
) -> Option<Option<f64>> {
    let key = |key: &str| format!("discs.{name}.{key}");
    if !c.or(&key("rotates"), &raw.rotates, true) {
        c.unused(&key("inertia"), &raw.inertia, "with rotates = false");
        c.unused(&key("spin"), &raw.spin, "with rotates = false");
        return Some(None);
    }
    if raw.inertia.is_given() {
        return c.number(&key("inertia"), &raw.inertia, POSITIVE).map(Some);
    }
    let homogeneous = 0.5 * mass? * powi(radius?, 2);
    if homogeneous.is_normal() {
        return Some(Some(homogeneous));
    }
    c.push(
        raw.mass.span(),
        format!("the mass and radius of `discs.{name}` give an inertia of {homogeneous:e} kg m^2"),
        "no finite number above 0",
        "check mass and radius, give `inertia`, or say rotates = false",
    );
    None
}

/// Refuses starts in which the centre of one disc is within the other, or in the half plane: no penetration is so deep.
pub fn judge_starts(c: &mut Checker<'_>, discs: &[Placed], half_plane: Option<HalfPlane>) {
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
