//! Error for a valid scene of the wrong kind.

use super::keywords::SceneKind;
use super::{Keyword, Scene};

/// A scene of one kind where another kind is required.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{scene}\" is a scene of kind \"{}\", but a scene of kind \"{}\" is required: give another scene",
    .found.keyword(), .required.keyword()
)]
pub struct WrongKind {
    pub scene: String,
    pub found: SceneKind,
    pub required: SceneKind,
}

impl Scene {
    /// Returns the scene if it is of the required kind.
    ///
    /// # Errors
    /// Returns an error if the scene is of another kind.
    pub fn require_kind(&self, required: SceneKind) -> Result<&Self, WrongKind> {
        match self.kind() {
            found if found == required => Ok(self),
            found => Err(WrongKind { scene: self.name.clone(), found, required }),
        }
    }
}
