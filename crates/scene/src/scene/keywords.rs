//! Keywords of scene files and their values.

use super::quantity::Keyword;
use crate::gripper::Assembly;
use crate::sizing::Rule;

/// Kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneKind {
    Finger,
    Bodies,
    Gripper,
    Mechanism,
}

impl SceneKind {
    pub const ALL: [Self; 4] = [SceneKind::Finger, SceneKind::Bodies, SceneKind::Gripper, SceneKind::Mechanism];

    /// Number of fingers.
    pub const fn fingers(self) -> usize {
        match self {
            SceneKind::Bodies | SceneKind::Mechanism => 0,
            SceneKind::Finger => 1,
            SceneKind::Gripper => 2,
        }
    }
}

/// Motion of a disc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    Free,
    Driven,
    Fixed,
}

impl Keyword for SceneKind {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        ("finger", SceneKind::Finger),
        ("bodies", SceneKind::Bodies),
        ("gripper", SceneKind::Gripper),
        ("mechanism", SceneKind::Mechanism),
    ];
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
