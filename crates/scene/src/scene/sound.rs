//! Systems that a program has put together: what neither model takes is said, and not simulated as something else.

use super::{Disc, DiscMotion, System, Touching};

impl System {
    /// Why neither model takes it, and what to do; `None` of every system that a scene file gives.
    pub fn objection(&self) -> Option<&'static str> {
        let (fingers, moves) = (self.fingers.len(), self.palm_motion.is_some());
        let is_free = |disc: &Disc| matches!(disc.motion, DiscMotion::Free { .. });
        let lawless = |touching: &Touching| matches!(touching, Touching::Discs(..)) && self.between_discs.is_none();
        let why = [
            (fingers > 2, "there are more than two fingers: take out all but a right and a left one"),
            (
                fingers < 2 && self.differential.is_some(),
                "a differential drives two fingers: take it out, or add the other finger",
            ),
            (fingers == 0 && moves, "a palm that moves carries fingers: take its motion out, or add a finger"),
            (
                moves && !self.discs.iter().all(is_free),
                "the palm moves, but a disc is fixed or driven: take the motion of the palm out, or let the disc go",
            ),
            (
                fingers == 0 && self.between_discs.is_none() || fingers < 3 && self.touching().iter().any(lawless),
                "discs have no law by which they touch: give between_discs",
            ),
        ];
        why.iter().find(|(is_so, _)| *is_so).map(|(_, why)| *why)
    }
}
