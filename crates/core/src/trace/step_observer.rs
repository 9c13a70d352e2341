//! Observer of the steps of an engine run.

use super::SinkError;
use crate::engine::Motion;

/// Observer of the steps of an engine run.
pub(super) trait StepObserver {
    /// Processes one completed step.
    fn step(&mut self, motion: &Motion) -> Result<(), SinkError>;
    /// Upper bound of the next step, s, so that it ends where the object leaves the reach of the fingers.
    fn time_to_exit_s(&self) -> f64;
    /// Reason why the last step is not a valid motion, if any.
    fn failure(&self) -> Option<&str>;
    /// Whether the run may continue; called after every step and after every contact sub-step.
    fn should_continue(&self) -> bool;
}
