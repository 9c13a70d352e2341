//! What a finger sees of the object.

use super::super::Disc;
use crate::shape::Placed;

/// What a finger closes on, in its own frame.
#[derive(Clone, Debug)]
pub struct Seen {
    /// `None` where there is nothing.
    pub object: Option<Placed>,
    /// Where it may be: at either end of the positioning error of two fingers.
    pub ends: Vec<Placed>,
}

impl Seen {
    /// Of one finger, whose frame is the scene's.
    pub fn alone(discs: &[Disc]) -> Self {
        let object = discs.first().map(Disc::placed);
        Self { object, ends: object.into_iter().collect() }
    }
}
