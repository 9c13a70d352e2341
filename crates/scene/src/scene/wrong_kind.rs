//! A sound scene of a kind that will not do.

use super::words::SceneKind;
use super::{Scene, Words};

/// What was asked of a scene is for those of another kind.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{scene}\" is a scene of kind \"{}\", but only one of kind \"{}\" will do here: give another scene",
    .found.word(), .wanted.word()
)]
pub struct WrongKind {
    pub scene: String,
    pub found: SceneKind,
    pub wanted: SceneKind,
}

impl Scene {
    /// The scene, if it is of this kind.
    ///
    /// # Errors
    /// Of which kind it is instead.
    pub fn only(&self, wanted: SceneKind) -> Result<&Self, WrongKind> {
        match self.kind() {
            found if found == wanted => Ok(self),
            found => Err(WrongKind { scene: self.name.clone(), found, wanted }),
        }
    }
}
