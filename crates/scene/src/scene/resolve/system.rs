//! The simulated system.

use super::super::check::Checker;
use super::super::scene_input::SceneInput;
use super::super::table::differential::DifferentialSettings;
use super::super::table::scene::SceneSettings;
use super::super::table::{SettingsSection, read};
use super::super::{DiscMotion, DrivenFinger, HalfPlane, System};
use super::driven_finger::{FingerEnvironment, driven_finger};
use super::sizing::SizingResult;
use super::{contact, differential, disc, finger, motion, object, object_range, plane};
use crate::shape;

/// Resolves the system; `None` if any part is invalid.
pub fn system(checker: &mut Checker<'_>, input: &SceneInput, scene_settings: &SceneSettings) -> Option<System> {
    let (root_input, gravity_m_s2) = (input.top_level(), scene_settings.gravity_m_s2);
    let object_settings = object::object_settings(checker, &root_input);
    let finger_lengths: Vec<_> = input
        .sides()
        .iter()
        .map(|side| finger::resolve_lengths(checker, &input.finger(*side), shape::max_radius(&object_settings.shape)))
        .collect();
    let discs = match input.sides().len() {
        0 => disc::discs(checker, input, gravity_m_s2),
        1 => object::single_object(checker, &root_input, object_settings, finger_lengths[0].base_m),
        _ => Some(vec![object_settings.disc()]),
    };
    let palm_width_m =
        object_range::palm_width(checker, &root_input, scene_settings, &finger_lengths, &object_settings);
    let levels = plane::levels(checker, &root_input, scene_settings, object_settings);
    let targets = object_range::targets(
        checker,
        input,
        scene_settings,
        &finger_lengths,
        object_settings,
        (discs.as_deref(), palm_width_m, levels),
    );

    let section = root_input.subsection("differential");
    let differential_settings =
        section.is_present().then(|| read(checker, "differential", &section, DifferentialSettings::defaults()));
    let differential_settings = differential_settings.filter(|settings| settings.present);
    let (mut sizings, mut fingers): (Vec<SizingResult>, Vec<Option<DrivenFinger>>) = Default::default();
    for ((side, lengths), target) in input.sides().iter().zip(&finger_lengths).zip(targets) {
        let environment = FingerEnvironment {
            side: *side,
            gravity_m_s2,
            has_motor: differential_settings.is_none(),
            curvature_m: shape::curvature_radius(&object_settings.shape),
            target,
        };
        let (sizing, finger) = driven_finger(checker, &input.finger(*side), lengths, environment);
        sizings.push(sizing);
        fingers.push(finger);
    }
    let fingers: Option<Vec<DrivenFinger>> = fingers.into_iter().collect();
    let differential = match (differential_settings, &sizings[..]) {
        (Some(settings), [right, left]) => {
            differential::differential(checker, input, settings, right.sum_motor_torques(*left)).map(Some)
        }
        _ => Some(None),
    };

    let is_fixed = discs.iter().flatten().any(|disc| disc.motion == DiscMotion::Fixed);
    let palm_motion = motion::palm_motion(checker, &root_input, is_fixed);
    let law = root_input.subsection("contact");
    let [between_discs, palm_law, table_law] = match input.sides().len() {
        0 => [contact::common_law(checker, &law); 3],
        // The object is fixed, so nothing can reach the palm.
        1 => [None; 3],
        _ => {
            let [palm, table] = contact::planes(
                checker,
                &law,
                levels.map(|level| level.is_some()),
                shape::curvature_radius(&object_settings.shape),
            )?;
            [None, palm, table]
        }
    };
    let [palm, table] = [(levels[0], palm_law), (levels[1], table_law)]
        .map(|(level, contact)| level.map(|level_m| HalfPlane { level_m, contact }));
    Some(System {
        fingers: fingers?,
        palm_width_m: palm_width_m?,
        differential: differential?,
        discs: discs?,
        between_discs,
        palm,
        table,
        palm_motion,
        gravity_m_s2,
    })
}

/// Static friction of the proximal contact of the first finger, or between discs; 0 without friction.
pub fn mu_static(system: &System) -> Option<f64> {
    let proximal = system.fingers.first().map(|finger| finger.contact.proximal);
    proximal.or(system.between_discs).map(|law| law.friction.map_or(0.0, |friction| friction.mu_static))
}
