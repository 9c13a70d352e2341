//! Keywords of scene files and their values.

use super::quantity::{keyword_enum, keywords};
use crate::gripper::Assembly;
use crate::sizing::Rule;

keyword_enum! {
    /// Kind of scene.
    pub enum SceneKind { Finger = "finger", Bodies = "bodies", Gripper = "gripper", Mechanism = "mechanism" }
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

keyword_enum! {
    /// Motion of a disc.
    pub enum Motion { Free = "free", Driven = "driven", Fixed = "fixed" }
}

keywords! { Assembly { "reference" => Assembly::Reference, "other" => Assembly::Other } }

keywords! { Rule { Rule::Rigid.name() => Rule::Rigid, Rule::Whole.name() => Rule::Whole } }
