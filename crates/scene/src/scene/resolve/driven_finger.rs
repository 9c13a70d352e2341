//! A finger with its drive and initial configuration.

use super::super::check::Checker;
use super::super::table::input::SectionInput;
use super::super::{DrivenFinger, Motor, Side};
use super::finger::FingerLengths;
use super::object_range::size_for_range;
use super::sizing::SizingResult;
use super::target::Target;
use super::{contact, drive, finger, start};

/// Data a finger depends on: gravity, motor, target.
pub struct FingerEnvironment {
    pub side: Side,
    pub gravity_m_s2: [f64; 2],
    /// Whether the finger has a motor of its own.
    pub has_motor: bool,
    /// Radius of curvature of the object.
    pub curvature_m: f64,
    /// The object it closes on; `None` if that is invalid.
    pub target: Option<Target>,
}

/// Resolves a finger; also returns its sizing.
pub fn driven_finger(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    finger_lengths: &FingerLengths,
    environment: FingerEnvironment,
) -> (SizingResult, Option<DrivenFinger>) {
    let FingerEnvironment { side, gravity_m_s2: [x, y], has_motor, curvature_m, target } = environment;
    let linkage = finger::finger(checker, input, finger_lengths);
    let finger_and_target = linkage.as_ref().zip(target.as_ref());
    let sizing_result =
        size_for_range(checker, input, &finger_lengths.settings, finger_and_target, [side.mirror() * x, y]);
    let motor = match has_motor {
        true => drive::motor(checker, &input.subsection("motor"), sizing_result),
        false => Some(Motor::NONE),
    };
    let spring = drive::spring(checker, &input.subsection("spring"), sizing_result);
    let limit = contact::limit(checker, &input.subsection("limit"));
    let contact = contact::contacts(checker, &input.subsection("contact"), curvature_m);
    let initial = start::initial(checker, input, finger_lengths, finger_and_target, limit);
    let components = (linkage, motor, spring, contact, initial);
    let (Some(linkage), Some(motor), Some(spring), Some(contact), Some(initial)) = components else {
        return (sizing_result, None);
    };
    (sizing_result, Some(DrivenFinger { linkage, motor, spring, limit, contact, initial }))
}
