//! Who follows an engine run.

use super::SinkError;
use crate::engine::Motion;

/// Who follows an engine run.
pub(super) trait Follow {
    fn step(&mut self, motion: &Motion) -> Result<(), SinkError>;
    /// Time after which the next step ends at the latest, so that it lands on where the object leaves the reach of the fingers, s.
    fn exit_in_s(&self) -> f64;
    /// Why the last step was none, if so.
    fn broken(&self) -> Option<&str>;
    /// Whether the run may go on: asked after every step, and at every sub-step of the contacts in it.
    fn proceed(&self) -> bool;
}
