//! Keywords of scene files and their values.

use super::value_kinds::Keyword;
use super::{Interpolation, Placement};
use crate::gripper::Assembly;
use crate::sizing::Rule;

/// Kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneKind {
    Finger,
    Bodies,
    Gripper,
}

impl SceneKind {
    pub const ALL: [Self; 3] = [SceneKind::Finger, SceneKind::Bodies, SceneKind::Gripper];

    /// Number of fingers.
    pub const fn fingers(self) -> usize {
        match self {
            SceneKind::Bodies => 0,
            SceneKind::Finger => 1,
            SceneKind::Gripper => 2,
        }
    }
}

/// All kinds of scene.
pub const ANY: &[SceneKind] = &SceneKind::ALL;
/// Kinds of scene without fingers.
pub const NO_FINGER: &[SceneKind] = &[SceneKind::Bodies];
/// Kinds of scene with one finger.
pub const ONE_FINGER: &[SceneKind] = &[SceneKind::Finger];
/// Kinds of scene with two fingers.
pub const TWO_FINGERS: &[SceneKind] = &[SceneKind::Gripper];
/// Kinds of scene with one or two fingers.
pub const FINGERS: &[SceneKind] = &[SceneKind::Finger, SceneKind::Gripper];
/// Kinds of scene with zero or two fingers.
pub const NO_OR_TWO_FINGERS: &[SceneKind] = &[SceneKind::Bodies, SceneKind::Gripper];

/// Motion of a disc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    Free,
    Driven,
    Fixed,
}

impl Keyword for SceneKind {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("finger", SceneKind::Finger), ("bodies", SceneKind::Bodies), ("gripper", SceneKind::Gripper)];
}

impl Keyword for Motion {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("free", Motion::Free), ("driven", Motion::Driven), ("fixed", Motion::Fixed)];
}

impl Keyword for Assembly {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("reference", Assembly::Reference), ("other", Assembly::Other)];
}

impl Keyword for Rule {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[(Rule::Rigid.name(), Rule::Rigid), (Rule::Whole.name(), Rule::Whole)];
}

impl Keyword for Interpolation {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("linear", Interpolation::Linear), ("step", Interpolation::Step)];
}

impl Keyword for Placement {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        (Placement::Phalanges.name(), Placement::Phalanges),
        (Placement::DrivenCoupler.name(), Placement::DrivenCoupler),
        (Placement::GroundLinks.name(), Placement::GroundLinks),
        (Placement::CouplerDistal.name(), Placement::CouplerDistal),
    ];
}
