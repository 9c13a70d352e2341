//! Discs and their initial positions.

use std::ops::Range;

use super::super::error::Problem;
use super::super::keywords::Motion;
use super::super::section_input::{SceneInput, SectionInput};
use super::super::settings::DiscSettings;
use super::super::{Disc, DiscMotion, System};
use crate::limits::MAX_DISCS;
use crate::numeric::elementary::hypot;
use crate::shape::{self, Shape};
use crate::units::{Dimension, format};

/// Name of the half plane in pairs.
const PLANE: &str = "plane";

/// Resolves all discs in the order of their names; `None` if any is invalid.
pub fn discs(input: &SceneInput, root: &SectionInput<'_>, gravity_m_s2: [f64; 2]) -> Option<Vec<Disc>> {
    let section = root.subsection("discs");
    let sections = section.subsections();
    let count = sections.len();
    if count == 0 {
        let help = "add at least one disc that moves: [discs.hammer] with radius, centre and mass";
        root.checker.report_missing_at("[discs.NAME]", section.span, help);
        return None;
    }
    if count > MAX_DISCS {
        let message = format!("there are {count} discs, but at most {MAX_DISCS} are allowed");
        section.report("", message, "", format!("remove {} of them", count - MAX_DISCS));
        return None;
    }
    let all: Vec<Option<Disc>> = sections.iter().map(|(name, keys)| disc(name, input.name_span(name), keys)).collect();
    let all: Vec<Disc> = all.into_iter().collect::<Option<_>>()?;
    if !all.iter().any(|disc| disc.motion.moves()) {
        let help = "make one of them move: motion = \"free\" with mass, or motion = \"driven\" with velocity";
        section.report("", "all discs are fixed: nothing would move", "", help);
    }
    let is_free = |disc: &Disc| matches!(disc.motion, DiscMotion::Free { .. });
    if gravity_m_s2 != [0.0; 2] && !all.iter().any(is_free) {
        root.report_unused("gravity", "without a disc with motion = \"free\"");
    }
    Some(all)
}

/// Resolves one disc; `None` if it is invalid.
fn disc(name: &str, name_span: Option<Range<usize>>, input: &SectionInput<'_>) -> Option<Disc> {
    let checked_name = check_name(input, name, name_span);
    let settings: DiscSettings = input.read();
    // If the motion is invalid, the required keys are unknown.
    input.is_valid("motion").then_some(())?;
    let shape = settings.radius.map(|radius| Shape::Disc { radius_m: *radius });
    let velocity_m_s = settings.velocity.map(|rate| *rate);
    let spin_rad_s = settings.spin.map_or(0.0, |spin| *spin);
    let motion = match settings.motion.0 {
        Motion::Fixed => DiscMotion::Fixed,
        Motion::Driven => {
            let acceleration_m_s2 = settings.acceleration.map(|acceleration| *acceleration);
            DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s }
        }
        Motion::Free => {
            let inertia_kg_m2 = inertia(input, name, &settings, shape)?;
            DiscMotion::Free { mass_kg: *settings.mass?, inertia_kg_m2, velocity_m_s, spin_rad_s }
        }
    };
    let centre_m = settings.centre?.map(|coordinate| *coordinate);
    Some(Disc { name: checked_name?, shape: shape?, centre_m, angle_rad: 0.0, motion })
}

/// Checks a name: names are used in topics, keys and columns, joined by `-` for pairs.
fn check_name(input: &SectionInput<'_>, text: &str, name_span: Option<Range<usize>>) -> Option<String> {
    let is_valid = text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let problem = match text {
        "" => "the name of a disc is empty".to_string(),
        PLANE => format!("`{PLANE}` cannot be the name of a disc: it is the name of the half plane"),
        _ if is_valid => return Some(text.to_string()),
        _ => format!("`{}` cannot be the name of a disc", text.escape_debug()),
    };
    let help =
        "use a letter followed by letters, digits and _, as in [discs.hammer_2]: the name is part of topics and keys";
    input.checker.push(Problem::new(name_span, problem, "invalid name", help));
    None
}

/// Inertia of a free disc: `Some(None)` if it does not rotate, `None` if invalid.
fn inertia(input: &SectionInput<'_>, name: &str, settings: &DiscSettings, shape: Option<Shape>) -> Option<Option<f64>> {
    if !settings.rotates {
        ["inertia", "spin"].iter().for_each(|key| input.report_unused(key, "with rotates = false"));
        return Some(None);
    }
    if input.has("inertia") {
        return settings.inertia.map(|inertia| Some(*inertia));
    }
    let homogeneous = *settings.mass? * shape::inertia(&shape?, 1.0);
    if homogeneous.is_normal() {
        return Some(Some(homogeneous));
    }
    let message = format!("the mass and radius of `discs.{name}` give an inertia of {homogeneous:e} kg m^2");
    let help = "check mass and radius, give `inertia`, or write rotates = false";
    input.report("mass", message, "not a finite number above 0", help);
    None
}

/// Rejects initial positions in which the centre of a disc is inside another disc or the half plane: contact laws do
/// not cover such deep penetrations.
pub(crate) fn check_initial_positions(input: &SectionInput<'_>, system: &System) {
    let (section, length) = (input.subsection("discs"), |metres| format(metres, Dimension::Length));
    for (index, b) in system.discs.iter().enumerate() {
        let keys = section.subsection(&b.name);
        for a in &system.discs[..index] {
            let distance_m = hypot(a.centre_m[0] - b.centre_m[0], a.centre_m[1] - b.centre_m[1]);
            let [radius_a, radius_b] = [a, b].map(|disc| shape::max_radius(&disc.shape));
            let moves = a.motion.moves() || b.motion.moves();
            if moves && distance_m <= radius_a.max(radius_b) {
                let message = format!(
                    "discs `{}` and `{}` overlap too deeply at the start: the distance of their centres is {}, but must exceed \
                     the radii {} and {}",
                    a.name,
                    b.name,
                    length(distance_m),
                    length(radius_a),
                    length(radius_b)
                );
                let help =
                    "move them apart: discs may overlap at the start, but the centre of each must be outside the other";
                keys.report("centre", message, "too deep", help);
            }
        }
        if let Some(plane) = system.palm
            && b.motion.moves()
            && b.centre_m[1] <= plane.level_m
        {
            let message = format!(
                "the centre of `{}` is inside the half plane at the start: y = {}, but must be above its level of {}",
                b.name,
                length(b.centre_m[1]),
                length(plane.level_m)
            );
            let help = "raise the disc, or lower `half_plane.level`: the disc may overlap the half plane at the start, but not its centre";
            keys.report("centre", message, "too deep", help);
        }
    }
}
