//! Invariants that no run may violate at any accuracy. They are measured at every sample while a run progresses.
//!
//! | invariant | measured value | limit |
//! |---|---|---|
//! | finite | number of values that are not finite | 0 |
//! | energy | largest \|balance\| | [`Tolerances::energy`] of the energy throughput of the run |
//! | passivity | largest decrease of the dissipated energy | the limit of the energy |
//! | no adhesion | largest gap with a contact force | [`Tolerances::gap_m`] plus the opening during a step |
//! | | most negative force; largest decrease of an impulse | 0; [`Tolerances::energy`] of the largest impulse |
//! | friction | \|F_t + μ(v) F_n\| / F_n, which includes the cone and the direction; in the engine, a force acts for a whole step, so the smallest value for any slip of the step counts | [`Tolerances::friction`] |
//! | penetration, limit | depth δ of a contact or joint limit | depth at which the spring alone stores all available energy: (e + 1) E = k δᵉ⁺¹ |
//! | loop gap | opening of a joint | [`Tolerances::loop_gap_m`] |
//! | momentum, angular momentum | momentum of a gripper's free object minus the impulses of contacts and weight | [`Tolerances::energy`] of the exchanged momentum, plus the change of friction and directions between samples |
//!
//! [`Invariants`] is a sink of runs; [`Invariants::findings`] returns how close each invariant came to its limit.

mod audit;
mod finding;
mod measure;
mod momentum;
mod tolerance;

pub use audit::{EnergyAudit, EnergyViolation};
pub use finding::{Finding, Invariant};
pub use measure::Invariants;
pub use tolerance::Tolerances;
