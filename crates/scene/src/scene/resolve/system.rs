//! The simulated system.

use super::super::section_input::{SceneInput, SectionInput};
use super::super::settings::{DifferentialSettings, SceneSettings};
use super::super::{Differential, DiscMotion, DrivenFinger, HalfPlane, Side, System};
use super::contact::Level;
use super::drive::{self, SizingResult};
use super::finger::{FingerEnvironment, driven_finger, resolve_lengths};
use super::{disc, motion, object};
use crate::shape;

/// Resolves the system; `None` if any part is invalid.
pub fn system(input: &SceneInput, root: &SectionInput<'_>, settings: &SceneSettings) -> Option<System> {
    let gravity_m_s2 = settings.gravity.map(|component| *component);
    let given = object::object(root);
    let object = &given.disc;
    let fingers_input: Vec<_> = input.sides().iter().map(|side| input.finger(*side, root.checker)).collect();
    let reach_m = shape::max_radius(&object.shape);
    let finger_lengths: Vec<_> = fingers_input.iter().map(|finger| resolve_lengths(finger, reach_m)).collect();
    let discs = match &finger_lengths[..] {
        [] => disc::discs(input, root, gravity_m_s2),
        [finger] => object::single_object(root, &given, finger),
        _ => Some(vec![object.clone()]),
    };
    let palm_width_m = object::palm_width(root, settings, &finger_lengths, object);
    let levels = object::levels(root, settings, object);
    let positions = (discs.as_deref(), palm_width_m, levels);
    let targets = object::targets(root, input, settings, &finger_lengths, object, positions);

    let section = root.subsection("differential");
    let differential_settings = section.is_present().then(|| section.read::<DifferentialSettings>());
    let differential_settings = differential_settings.filter(|settings| settings.present);
    let curvature_m = shape::curvature_radius(&object.shape);
    let (mut sizings, mut fingers): (Vec<SizingResult>, Vec<Option<DrivenFinger>>) = Default::default();
    for (index, target) in targets.into_iter().enumerate().take(finger_lengths.len()) {
        let has_motor = differential_settings.is_none();
        let environment =
            FingerEnvironment { side: input.sides()[index], gravity_m_s2, has_motor, curvature_m, target };
        let (sizing, finger) = driven_finger(&fingers_input[index], &finger_lengths[index], environment);
        sizings.push(sizing);
        fingers.push(finger);
    }
    let differential = match (differential_settings, &sizings[..]) {
        (Some(settings), [right, left]) => {
            let sized = right.combine(*left, |right, left| right + left);
            differential(root, &settings, sized).map(Some)
        }
        _ => Some(None),
    };

    let is_fixed = discs.iter().flatten().any(|disc| disc.motion == DiscMotion::Fixed);
    let palm_motion = motion::palm_motion(root, is_fixed);
    let [between_discs, palm_law, table_law] = match input.sides().len() {
        0 => [Level::common(root.subsection("contact"), 0.0).law(); 3],
        // The object is fixed, so nothing can reach the palm.
        1 => [None; 3],
        _ => {
            let common = Level::common(root.subsection("contact"), curvature_m);
            let mut laws = [None; 3];
            for (index, (plane, level)) in ["palm", "table"].into_iter().zip(levels).enumerate() {
                match level {
                    Some(_) => laws[index + 1] = Some(common.law_of(plane)?),
                    None => common.report_unused(plane),
                }
            }
            laws
        }
    };
    let [palm, table] = [(levels[0], palm_law), (levels[1], table_law)]
        .map(|(level, contact)| level.map(|level_m| HalfPlane { level_m, contact }));
    Some(System {
        fingers: fingers.into_iter().collect::<Option<_>>()?,
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

/// Resolves the differential: the motor at the input, sized for both fingers, and the seesaw.
fn differential(root: &SectionInput<'_>, settings: &DifferentialSettings, sized: SizingResult) -> Option<Differential> {
    for side in Side::BOTH.map(Side::name) {
        let reason = "with a [differential], which is driven by the motor in [motor]";
        root.subsection(side).report_unused("motor", reason);
    }
    let mut motor = drive::motor(&root.subsection("motor"), sized)?;
    motor.inertia_kg_m2 += *settings.input_inertia;
    Some(Differential { motor, seesaw_inertia_kg_m2: *settings.seesaw_inertia })
}

/// Static friction of the proximal contact of the first finger, or between discs; 0 without friction.
pub fn mu_static(system: &System) -> Option<f64> {
    let proximal = system.fingers.first().map(|finger| finger.contact.proximal);
    proximal.or(system.between_discs).map(|law| law.friction.map_or(0.0, |friction| friction.mu_static))
}
