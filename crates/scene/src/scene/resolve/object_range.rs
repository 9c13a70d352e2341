//! Positions of the object within the positioning error, in the frame of each finger.

use std::ops::Range;

use super::super::check::Checker;
use super::super::scene_input::SceneInput;
use super::super::table::finger::FingerSettings;
use super::super::table::input::SectionInput;
use super::super::table::object::ObjectSettings;
use super::super::table::scene::SceneSettings;
use super::super::{Disc, Side};
use super::finger::FingerLengths;
use super::object::example_base_m;
use super::sizing::SizingResult;
use super::target::Target;
use super::{plane, sizing};
use crate::gripper::Finger;
use crate::numeric::elementary::hypot;
use crate::shape::{PlacedShape, tangent};
use crate::units::{Dimension, format};

/// Resolves the palm width of a gripper: as given, or twice the base of both fingers. 0 in other kinds of scene.
pub fn palm_width(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    scene_settings: &SceneSettings,
    finger_lengths: &[FingerLengths],
    object: &ObjectSettings,
) -> Option<f64> {
    let [right, left] = finger_lengths else { return Some(0.0) };
    if input.has("palm_width") {
        for section in [input.clone(), input.subsection("right"), input.subsection("left")] {
            checker.report_unused_at("lengths.base", section.subsection("lengths").span("base"), "with palm_width");
        }
        return Some(scene_settings.palm_width_m).filter(|width_m| !width_m.is_nan());
    }
    let (right, left) = (right.base_m, left.base_m);
    // An invalid base has been reported.
    let lacks_base = !input.subsection("lengths").has("base")
        && finger_lengths
            .iter()
            .any(|finger_lengths| finger_lengths.lengths.is_some() && finger_lengths.base_m.is_none());
    let length = |metres| format(metres, Dimension::Length);
    if lacks_base {
        let base_m = right.or(left).unwrap_or_else(|| example_base_m(input, &object.shape));
        let (base, width) = (length(base_m), length(2.0 * base_m));
        let help = format!("add it, such as palm_width = \"{width}\", or half of it: [lengths] base = \"{base}\"");
        checker.report_missing_at("palm_width", None, &help);
    } else if let (Some(first), Some(second)) = (right, left)
        && first != second
    {
        let width = length(first + second);
        let help = format!("add it, because the bases of both fingers differ: palm_width = \"{width}\"");
        checker.report_missing_at("palm_width", None, &help);
    }
    right.filter(|_| right == left).map(|base_m| 2.0 * base_m)
}

/// Returns the target of each finger; `None` if it is invalid.
pub fn targets(
    checker: &mut Checker<'_>,
    input: &SceneInput,
    scene_settings: &SceneSettings,
    finger_lengths: &[FingerLengths],
    object: ObjectSettings,
    (discs, palm_width_m, levels): (Option<&[Disc]>, Option<f64>, [Option<f64>; 2]),
) -> Vec<Option<Target>> {
    if finger_lengths.len() < 2 {
        return vec![discs.map(Target::from_discs)];
    }
    let (top_level, problem_count) = (input.top_level(), checker.count());
    plane::check_object(checker, &top_level, object, levels);
    let mut object_range =
        palm_width_m.and_then(|palm_width_m| object_range(checker, &top_level, scene_settings, object, palm_width_m));
    object_range = object_range.filter(|_| checker.count() == problem_count);
    let object_input = top_level.subsection("object");
    let object_span = object_input.span("offset").or(top_level.span("palm_width")).or(object_input.span);
    let mut targets = Vec::new();
    for (side, finger_lengths) in Side::BOTH.into_iter().zip(finger_lengths) {
        let half_width_m = finger_lengths.lengths.map(|lengths| lengths.half_width_m);
        let mut target = object_range.map(|object_range| object_range.target(side, object));
        if let (Some(candidate), Some(half_width_m)) = (&target, half_width_m)
            && !is_ground_joint_clear(checker, object_span.clone(), side, candidate, half_width_m)
        {
            target = None;
            // Report the problem for one finger only.
            object_range = None;
        }
        targets.push(target.filter(|_| half_width_m.is_some()));
    }
    targets
}

/// Range of positions of the object for the sizing and the initial configuration of the fingers.
#[derive(Clone, Copy)]
struct ObjectRange {
    half_palm_m: f64,
    error_m: f64,
}

/// Resolves the range of positions; the positioning error must be at least the offset of the object.
fn object_range(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    scene_settings: &SceneSettings,
    object: ObjectSettings,
    palm_width_m: f64,
) -> Option<ObjectRange> {
    let offset = object.centre_m[0];
    let error_m = if input.has("positioning_error") { scene_settings.positioning_error_m } else { offset.abs() };
    if error_m.is_nan() {
        return None;
    }
    let object_range = ObjectRange { half_palm_m: 0.5 * palm_width_m, error_m };
    if offset.abs() <= error_m {
        return Some(object_range);
    }
    let [error, offset] = [error_m, offset.abs()].map(|value| format(value, Dimension::Length));
    checker.push(
        input.span("positioning_error"),
        format!("`positioning_error` is {error}, but must be at least the offset of the object, {offset}"),
        "smaller than the offset",
        "raise it, reduce `object.offset`, or remove it (default: the offset of the object)",
    );
    None
}

impl ObjectRange {
    fn target(&self, side: Side, object: ObjectSettings) -> Target {
        let PlacedShape { shape, centre_m: [x, y], angle_rad } = object.placed();
        let angle_rad = side.mirror() * angle_rad;
        let at = |x: f64| PlacedShape { shape, centre_m: [x - self.half_palm_m, y], angle_rad };
        Target { object: Some(at(side.mirror() * x)), ends: vec![at(-self.error_m), at(self.error_m)] }
    }
}

/// Checks that the ground joint of a finger is outside of the object, enlarged by half the width of a link, at all
/// positions.
fn is_ground_joint_clear(
    checker: &mut Checker<'_>,
    span: Option<Range<usize>>,
    side: Side,
    target: &Target,
    half_width_m: f64,
) -> bool {
    let tangent_failure = |placed: &PlacedShape| {
        let reach = tangent(placed, half_width_m).err()?;
        Some((hypot(placed.centre_m[0], placed.centre_m[1]), reach))
    };
    let nearest = target.object.iter().chain(&target.ends).filter_map(tangent_failure);
    let Some((distance, reach)) = nearest.min_by(|nearer, other| nearer.0.total_cmp(&other.0)) else { return true };
    let [distance, reach] = [distance, reach].map(|value| format!("{:.3} mm", value * 1e3));
    checker.push(
        span,
        format!("the ground joint of the {} finger is {distance} from the object's centre, but must be at least {reach} away: the radius and half a link's width", side.name()),
        "inside the object",
        "increase `palm_width`, or reduce `object.offset` or `positioning_error`",
    );
    false
}

/// Sizes motor and spring for both ends of the positioning error (thesis §4.2.1.3). One end may be out of reach of the
/// finger, which then touches the object only after the other finger has moved it.
pub fn size_for_range(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    settings: &FingerSettings,
    finger_and_target: Option<(&Finger, &Target)>,
    gravity_m_s2: [f64; 2],
) -> SizingResult {
    let Some((finger, Target { object: Some(_), ends })) = finger_and_target else {
        return sizing::sizing(
            checker,
            input,
            settings,
            finger_and_target.map(|(finger, _)| (finger, &None)),
            gravity_m_s2,
        );
    };
    let has_range = ends.windows(2).any(|pair| pair[0] != pair[1]);
    let attempts: Vec<_> = ends
        .iter()
        .map(|disc| {
            let mut trial = checker.for_trial();
            let sized = sizing::sizing(&mut trial, input, settings, Some((finger, &Some(*disc))), gravity_m_s2);
            if has_range {
                let base = -disc.centre_m[0] * 1e3;
                let details = format!(
                    " with the object at the end of the positioning error, {base:.3} mm from the ground joint along the palm"
                );
                trial.append_to_messages(sizing::SIZING_LABEL, &details);
            }
            (sized, trial)
        })
        .collect();
    let is_reachable = |sized: SizingResult| matches!(sized, SizingResult::Sized(_));
    let reachable_count = attempts.iter().filter(|(sized, _)| is_reachable(*sized)).count();
    let mut combined = None;
    for (sized, trial) in attempts {
        if reachable_count == 0 || is_reachable(sized) {
            checker.extend(trial.into_problems());
            combined = Some(combined.map_or(sized, |before: SizingResult| before.max_torques(sized)));
        }
    }
    combined.unwrap_or(SizingResult::Failed)
}
