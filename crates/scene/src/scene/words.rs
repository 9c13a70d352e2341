//! The words of a scene file and what they stand for.

use super::kinds::Words;
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

    /// How many fingers its scenes have.
    pub const fn fingers(self) -> usize {
        match self {
            SceneKind::Bodies => 0,
            SceneKind::Finger => 1,
            SceneKind::Gripper => 2,
        }
    }
}

/// Kinds of scene by how many fingers they have.
pub const ANY: &[SceneKind] = &SceneKind::ALL;
pub const NO_FINGER: &[SceneKind] = &[SceneKind::Bodies];
pub const ONE_FINGER: &[SceneKind] = &[SceneKind::Finger];
pub const TWO_FINGERS: &[SceneKind] = &[SceneKind::Gripper];
/// One or two.
pub const FINGERS: &[SceneKind] = &[SceneKind::Finger, SceneKind::Gripper];
/// None or two.
pub const NOT_ONE: &[SceneKind] = &[SceneKind::Bodies, SceneKind::Gripper];

/// What moves a disc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    Free,
    Driven,
    Fixed,
}

impl Words for SceneKind {
    const WORDS: &'static [(&'static str, Self)] =
        &[("finger", SceneKind::Finger), ("bodies", SceneKind::Bodies), ("gripper", SceneKind::Gripper)];
}

impl Words for Motion {
    const WORDS: &'static [(&'static str, Self)] =
        &[("free", Motion::Free), ("driven", Motion::Driven), ("fixed", Motion::Fixed)];
}

impl Words for Assembly {
    const WORDS: &'static [(&'static str, Self)] = &[("reference", Assembly::Reference), ("other", Assembly::Other)];
}

impl Words for Rule {
    const WORDS: &'static [(&'static str, Self)] =
        &[(Rule::Rigid.name(), Rule::Rigid), (Rule::Whole.name(), Rule::Whole)];
}

impl Words for Interpolation {
    const WORDS: &'static [(&'static str, Self)] = &[("linear", Interpolation::Linear), ("step", Interpolation::Step)];
}

impl Words for Placement {
    const WORDS: &'static [(&'static str, Self)] = &[
        (Placement::Phalanges.name(), Placement::Phalanges),
        (Placement::DrivenCoupler.name(), Placement::DrivenCoupler),
        (Placement::GroundLinks.name(), Placement::GroundLinks),
        (Placement::CouplerDistal.name(), Placement::CouplerDistal),
    ];
}
