//! What an integration costs.

/// What an integration cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    pub steps: u64,
    /// Attempts refused by the error, made to land on an event, or cut before a fold.
    pub rejected: u64,
    /// Right-hand sides, without those an observer asked for.
    pub rhs: u64,
    pub jacobians: u64,
    pub events: u64,
}
