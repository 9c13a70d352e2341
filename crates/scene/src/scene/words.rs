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
}

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
