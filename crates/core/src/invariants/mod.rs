//! What no run may break, whatever its accuracy: checked at every sample of a run as it goes by.
//!
//! | invariant | what is measured | what is allowed |
//! |---|---|---|
//! | finite | numbers that are none | 0 |
//! | energy | largest \|balance\| | [`Tolerances::energy`] of the energy that went through the run |
//! | passivity | largest fall of what is dissipated | the same |
//! | no adhesion | gap at which a force still acts | [`Tolerances::gap_m`], and the way of a step |
//! | | a force below zero; largest fall of an impulse | 0; [`Tolerances::energy`] of the largest impulse |
//! | friction | \|F_t + μ(v) F_n\| / F_n: the law itself, so the cone and the direction too; of the engine, whose forces are those of steps, for any slip of the step | [`Tolerances::friction`] |
//! | penetration, limit | δ | depth in which the spring alone stores all energy there is: (e + 1) E = k δᵉ⁺¹ |
//! | loop gap | opening of a joint | [`Tolerances::loop_gap_m`] |
//! | momentum, angular momentum | of a gripper's free object: what it has beside what contacts and weight gave it | [`Tolerances::energy`] of all that was exchanged, and what friction and directions change by between samples |
//!
//! [`Invariants`] is a sink of runs;
//! [`Invariants::findings`] says how near each invariant came to being broken.

mod audit;
mod finding;
mod measure;
mod momentum;
mod places;
mod tolerance;

pub use audit::{Breach, EnergyAudit};
pub use finding::{Finding, Invariant};
pub use measure::Invariants;
pub use tolerance::Tolerances;
