//! Discs and their initial positions.

use std::ops::Range;

use super::super::check::Checker;
use super::super::keywords::Motion;
use super::super::scene_input::SceneInput;
use super::super::table::disc::DiscSettings;
use super::super::table::input::SectionInput;
use super::super::table::scene::SceneSettings;
use super::super::table::{SettingsSection, read};
use super::super::value_kinds::Choice;
use super::super::{Disc, DiscMotion, System};
use crate::limits::MAX_DISCS;
use crate::numeric::elementary::hypot;
use crate::shape::{self, Shape};
use crate::units::{Dimension, format};

/// Name of the half plane in pairs.
const PLANE: &str = "plane";

/// Resolves all discs in the order of their names; `None` if any is invalid.
pub fn discs(checker: &mut Checker<'_>, input: &SceneInput, gravity_m_s2: [f64; 2]) -> Option<Vec<Disc>> {
    let section = input.top_level().subsection("discs");
    let count = section.subsections().count();
    if count == 0 {
        let help = "add at least one disc that moves: [discs.hammer] with radius, centre and mass";
        checker.report_missing_at("[discs.NAME]", section.span, help);
        return None;
    }
    if count > MAX_DISCS {
        checker.push(
            section.span,
            format!("there are {count} discs, but at most {MAX_DISCS} are allowed"),
            "",
            format!("remove {} of them", count - MAX_DISCS),
        );
        return None;
    }
    let all: Vec<Option<Disc>> =
        section.subsections().map(|(name, keys)| disc(checker, name, input.name_span(name), &keys)).collect();
    let all: Vec<Disc> = all.into_iter().collect::<Option<_>>()?;
    if !all.iter().any(|disc| disc.motion.moves()) {
        checker.push(
            section.span,
            "all discs are fixed: nothing would move",
            "",
            "make one of them move: motion = \"free\" with mass, or motion = \"driven\" with velocity",
        );
    }
    let free = |disc: &Disc| matches!(disc.motion, DiscMotion::Free { .. });
    if gravity_m_s2 != SceneSettings::default_gravity_m_s2(input.kind) && !all.iter().any(free) {
        checker.report_unused_at("gravity", input.top_level().span("gravity"), "without a disc with motion = \"free\"");
    }
    Some(all)
}

/// Resolves one disc; `None` if it is invalid.
fn disc(
    checker: &mut Checker<'_>,
    name: &str,
    name_span: Option<Range<usize>>,
    input: &SectionInput<'_>,
) -> Option<Disc> {
    let checked_name = check_name(checker, name, name_span);
    let path = format!("discs.{name}");
    let (shape, settings) = (
        read(checker, &path, input, Shape::defaults_for(input.kind)),
        read(checker, &path, input, DiscSettings::defaults()),
    );
    // If the motion is invalid, the required keys are unknown.
    if !input.is_valid::<Choice<Motion>>("motion") {
        return None;
    }
    let DiscSettings { centre_m, velocity_m_s, acceleration_m_s2, mass_kg, spin_rad_s, .. } = settings;
    let motion = match settings.motion {
        Motion::Fixed => DiscMotion::Fixed,
        Motion::Driven => DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s },
        Motion::Free => {
            let inertia_kg_m2 = inertia(checker, name, input, &settings, &shape)?;
            if mass_kg.is_nan() {
                return None;
            }
            DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s }
        }
    };
    if shape::dimensions(&shape).any(|(_, size_m)| size_m.is_nan()) || centre_m[0].is_nan() {
        return None;
    }
    Some(Disc { name: checked_name?, shape, centre_m, angle_rad: 0.0, motion })
}

/// Checks a name: names are used in topics, keys and columns, joined by `-` for pairs.
fn check_name(checker: &mut Checker<'_>, text: &str, name_span: Option<Range<usize>>) -> Option<String> {
    let fit = text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    let problem = if text.is_empty() {
        "the name of a disc is empty".to_string()
    } else if text == PLANE {
        format!("`{PLANE}` cannot be the name of a disc: it is the name of the half plane")
    } else if !fit {
        format!("`{}` cannot be the name of a disc", text.escape_debug())
    } else {
        return Some(text.to_string());
    };
    let help =
        "use a letter followed by letters, digits and _, as in [discs.hammer_2]: the name is part of topics and keys";
    checker.push(name_span, problem, "invalid name", help);
    None
}

/// Inertia of a free disc: `Some(None)` if it does not rotate, `None` if invalid.
fn inertia(
    checker: &mut Checker<'_>,
    name: &str,
    input: &SectionInput<'_>,
    settings: &DiscSettings,
    shape: &Shape,
) -> Option<Option<f64>> {
    if !settings.rotates {
        for key in ["inertia", "spin"] {
            checker.report_unused_at(&format!("discs.{name}.{key}"), input.span(key), "with rotates = false");
        }
        return Some(None);
    }
    if input.has("inertia") {
        return Some(settings.inertia_kg_m2).filter(|inertia| !inertia.is_nan()).map(Some);
    }
    let homogeneous = settings.mass_kg * shape::inertia(shape, 1.0);
    if homogeneous.is_nan() {
        return None;
    }
    if homogeneous.is_normal() {
        return Some(Some(homogeneous));
    }
    checker.push(
        input.span("mass"),
        format!("the mass and radius of `discs.{name}` give an inertia of {homogeneous:e} kg m^2"),
        "not a finite number above 0",
        "check mass and radius, give `inertia`, or write rotates = false",
    );
    None
}

/// Rejects initial positions in which the centre of a disc is inside another disc or the half plane: contact laws do
/// not cover such deep penetrations.
pub fn check_initial_positions(checker: &mut Checker<'_>, input: &SceneInput, system: &System) {
    let section = input.top_level().subsection("discs");
    for (index, b) in system.discs.iter().enumerate() {
        let centre_span = section.subsection(&b.name).span("centre");
        for a in &system.discs[..index] {
            let distance_m = hypot(a.centre_m[0] - b.centre_m[0], a.centre_m[1] - b.centre_m[1]);
            let [radius_a, radius_b] = [a, b].map(|disc| shape::max_radius(&disc.shape));
            let moves = a.motion.moves() || b.motion.moves();
            if !moves || distance_m > radius_a.max(radius_b) {
                continue;
            }
            let length = |metres| format(metres, Dimension::Length);
            checker.push(
                centre_span.clone(),
                format!(
                    "discs `{}` and `{}` overlap too deeply at the start: the distance of their centres is {}, but must exceed \
                     the radii {} and {}",
                    a.name,
                    b.name,
                    length(distance_m),
                    length(radius_a),
                    length(radius_b)
                ),
                "too deep",
                "move them apart: discs may overlap at the start, but the centre of each must be outside the other",
            );
        }
        if let Some(plane) = system.palm
            && b.motion.moves()
            && b.centre_m[1] <= plane.level_m
        {
            let (height, level) = (b.centre_m[1], plane.level_m);
            checker.push(
                centre_span.clone(),
                format!(
                    "the centre of `{}` is inside the half plane at the start: y = {}, but must be above its level of {}",
                    b.name,
                    format(height, Dimension::Length),
                    format(level, Dimension::Length)
                ),
                "too deep",
                "raise the disc, or lower `half_plane.level`: the disc may overlap the half plane at the start, but not its centre",
            );
        }
    }
}
