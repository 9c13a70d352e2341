//! Detection of systems that neither model supports. Scene files never produce one, but a program may.

use super::{ContactId, Disc, DiscMotion, System};

impl System {
    /// Returns why neither model supports the system and how to change it; `None` for a supported system.
    pub fn unsupported(&self) -> Option<&'static str> {
        let (fingers, moves) = (self.fingers.len(), self.palm_motion.is_some());
        let is_free = |disc: &Disc| matches!(disc.motion, DiscMotion::Free { .. });
        let lacks_law = |contact: &ContactId| matches!(contact, ContactId::Discs(..)) && self.between_discs.is_none();
        let conditions = [
            (fingers > 2, "the system has more than two fingers: remove all except a right and a left one"),
            (
                fingers < 2 && self.differential.is_some(),
                "a differential requires two fingers: remove it, or add the other finger",
            ),
            (fingers == 0 && moves, "a moving palm requires fingers: remove its motion, or add a finger"),
            (
                moves && !self.discs.iter().all(is_free),
                "the palm moves, but a disc is fixed or driven: remove the motion of the palm, or make the disc free",
            ),
            (
                fingers == 0 && self.between_discs.is_none() || fingers < 3 && self.contact_ids().iter().any(lacks_law),
                "the contacts between discs have no law: set between_discs",
            ),
        ];
        conditions.iter().find(|(holds, _)| *holds).map(|(_, reason)| *reason)
    }
}
