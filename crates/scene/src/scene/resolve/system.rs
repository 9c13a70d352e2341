//! The simulated system.

use super::super::section_input::{SceneInput, SectionInput};
use super::super::settings::{DifferentialSettings, SceneSettings};
use super::super::{Differential, DiscMotion, DrivenFinger, FingerContactLaws, HalfPlane, Motor, Side, System};
use super::contact::Level;
use super::drive::{self, SizingResult};
use super::finger::{self, FingerLengths, resolve_lengths};
use super::object::Target;
use super::{contact, disc, motion, object, start};
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
    for ((side, finger), (lengths, target)) in
        input.sides().iter().zip(&fingers_input).zip(finger_lengths.iter().zip(&targets))
    {
        let [x, y] = gravity_m_s2;
        let (gravity, has_motor) = ([side.mirror() * x, y], differential_settings.is_none());
        let (sizing, finger) = driven_finger(finger, lengths, gravity, has_motor, curvature_m, target.as_ref());
        sizings.push(sizing);
        fingers.push(finger);
    }
    let differential = match (differential_settings, &sizings[..]) {
        (Some(settings), [right, left]) => {
            let sized = match (*right, *left) {
                (Some(Some(right)), Some(Some(left))) => {
                    Some(Some(drive::combine(right, left, |right, left| right + left)))
                }
                (Some(None), Some(None)) => Some(None),
                _ => None,
            };
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

/// Resolves a finger with its drive and initial configuration; also returns its sizing. `gravity_m_s2` is in the frame
/// of the finger, `curvature_m` the radius of curvature of the object, and `target` `None` if it is invalid.
fn driven_finger(
    input: &SectionInput<'_>,
    lengths: &FingerLengths,
    gravity_m_s2: [f64; 2],
    has_motor: bool,
    curvature_m: f64,
    target: Option<&Target>,
) -> (SizingResult, Option<DrivenFinger>) {
    let linkage = finger::linkage(input, lengths);
    let finger_and_target = linkage.as_ref().zip(target);
    let sized = drive::size(input, lengths, finger_and_target, gravity_m_s2);
    let motor = if has_motor { drive::motor(&input.subsection("motor"), sized) } else { Some(Motor::NONE) };
    let spring = drive::spring(&input.subsection("spring"), sized);
    let limit = contact::limit(&input.subsection("limit"));
    let contact = Level::common(input.subsection("contact"), curvature_m);
    let (proximal, distal) = (contact.law_of("proximal"), contact.law_of("distal"));
    let initial = start::initial(input, lengths, finger_and_target, limit);
    let finger = || {
        Some(DrivenFinger {
            linkage: linkage?,
            motor: motor?,
            spring: spring?,
            limit,
            contact: FingerContactLaws { proximal: proximal?, distal: distal? },
            initial: initial?,
        })
    };
    (sized, finger())
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
