//! Cost of an integration.

/// Cost of an integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    pub steps: u64,
    /// Attempts rejected by the error estimate, made to locate an event, or shortened before a singularity.
    pub rejected: u64,
    /// Right-hand-side evaluations, without those requested by an observer.
    pub rhs: u64,
    pub jacobians: u64,
    pub events: u64,
}
