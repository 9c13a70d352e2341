//! The object in the frame of a finger.

use super::super::Disc;
use crate::shape::PlacedShape;

/// The object that a finger closes on, in the frame of the finger.
#[derive(Clone, Debug)]
pub struct Target {
    /// The object; `None` without an object.
    pub object: Option<PlacedShape>,
    /// The object at both ends of the positioning error of a gripper.
    pub ends: Vec<PlacedShape>,
}

impl Target {
    /// Returns the target of a single finger, whose frame is that of the scene.
    pub fn from_discs(discs: &[Disc]) -> Self {
        let object = discs.first().map(Disc::placed);
        Self { object, ends: object.into_iter().collect() }
    }
}
