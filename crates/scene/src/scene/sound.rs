//! Systems that a program has put together: what neither model takes is said, and not simulated as something else.

use super::{DiscMotion, System};

impl System {
    /// Why neither model takes it, and what to do; `None` of every system that a scene file gives.
    pub fn objection(&self) -> Option<&'static str> {
        let object = self.object().map(|object| object.motion);
        let held = [self.differential.is_some(), self.table.is_some(), self.palm_motion.is_some()];
        let why = [
            (self.fingers.len() > 2, "there are more than two fingers: take out all but a right and a left one"),
            (!self.fingers.is_empty() && self.discs.len() > 1, "fingers grasp one disc: take out the others"),
            (
                self.fingers.len() == 1 && object.is_some_and(|motion| motion != DiscMotion::Fixed),
                "one finger alone grasps what does not move: fix its object, or add the other finger",
            ),
            (self.fingers.len() == 2 && object.is_none(), "two fingers have nothing to grasp: add a disc"),
            (
                matches!(object, Some(DiscMotion::Driven { .. } | DiscMotion::Free { inertia_kg_m2: None, .. })),
                "what two fingers grasp is fixed, or free to move and to turn: give it another motion",
            ),
            (
                self.fingers.len() < 2 && held.contains(&true),
                "a differential, a table and a palm that moves are parts of two fingers: take them out",
            ),
            (
                self.palm_motion.is_some() && object == Some(DiscMotion::Fixed),
                "the palm moves, but what it grasps is fixed: take its motion out, or let the object go",
            ),
            (
                self.fingers.is_empty() && self.between_discs.is_none(),
                "discs have no law by which they touch: give between_discs",
            ),
        ];
        why.iter().find(|(is_so, _)| *is_so).map(|(_, why)| *why)
    }
}
