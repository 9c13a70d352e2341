//! The engine model: a scene as rapier bodies and joints, with the contact laws in place of rapier's own response.
//!
//! `src/docs/engine.md` describes how it drives rapier and the limits of rapier. The engine is independent of the
//! analytic model: both share only the scene, lengths, masses and scalar laws.

mod build_plan;
mod candidates;
mod closest_points;
mod contact_space;
mod dense;
mod forces;
mod implicit;
mod linkage;
mod motion;
mod plan;
mod rate_correction;
mod stepper;
mod substeps;
mod world;

pub use build_plan::{L11, L12, L21, L22, LINKS, build_plan, driven_link_brake_torque, first_link};
pub use candidates::{ContactCandidate, Row, ZERO_RATE};
pub use contact_space::{ActiveContact, ContactSpace};
pub use forces::{PalmFrame, kinetic_energy, potential_energies};
pub use linkage::{BodyPose, Inertia, Linkage, SingularConstraints, Twist};
pub use motion::{Motion, RapierContact, StepError};
pub use plan::{
    Capsule, ContactPartner, ContactPointConvention, Plan, PlannedBody, PlannedBrake, PlannedContact, PlannedDrive,
    PlannedFixedSurface, PlannedGear, PlannedMotor, PlannedPin, PlannedRotor, PlannedSpring, PlannedStop,
    PrescribedMotion, Shape,
};
pub use stepper::next_step;
pub use substeps::{Change, ChangeKind, ContactExtremum, ContactSolveError, ContactSolver, Tolerance};
pub use world::{World, build_world};
