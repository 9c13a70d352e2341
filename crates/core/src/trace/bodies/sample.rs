//! One instant of a run of discs, the events between instants, and what remains when it is over.

use crate::trace::{ContactSample, Energy, EventKind, SiteSummary, Work};

/// A disc at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiscState {
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub velocity_m_s: [f64; 2],
    pub spin_rad_s: f64,
}

/// All discs and all pairs at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodiesSample {
    pub time_s: f64,
    /// One for each disc of the scene, fixed ones too.
    pub discs: Vec<DiscState>,
    /// One for each of [`BodiesScene::pairs`](crate::scene::BodiesScene::pairs): forces on the pair's disc, normal from
    /// its partner to it.
    pub contacts: Vec<ContactSample>,
    /// `motor_work_j` is the work of whatever drives the driven discs; these have no kinetic energy here. `spring_j` is 0.
    pub energy: Energy,
}

/// A change of one pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodiesEvent {
    pub time_s: f64,
    /// Index of the pair.
    pub pair: usize,
    pub kind: EventKind,
    /// Closing speed −gap rate at a touch-down; 0 otherwise.
    pub approach_m_s: f64,
    /// Normal impulse since the last touch-down of this pair, at a lift-off; 0 otherwise.
    pub impulse_n_s: f64,
}

/// A finished run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodiesOutcome {
    pub last: BodiesSample,
    /// One for each pair.
    pub pairs: Vec<SiteSummary>,
    pub work: Work,
}
