//! The engine model: a scene as rapier bodies and joints, with the contact laws in place of rapier's own response.
//!
//! `src/docs/engine.md` describes how it drives rapier and the limits of rapier. The engine is independent of the
//! analytic model: both share only the scene, lengths, masses and scalar laws.

mod candidates;
mod contact_space;
mod dense;
mod forces;
mod linkage;
mod motion;
mod plan;
mod stepper;
mod substeps;
mod world;

pub(crate) use candidates::ZERO_RATE;
pub use candidates::{ContactCandidate, Row};
pub use contact_space::{ActiveContact, ContactSpace};
pub(crate) use forces::potential_energies;
pub use forces::{PalmFrame, kinetic_energy};
pub use linkage::{BodyPose, Inertia, Linkage, SingularConstraints, Twist};
pub use motion::{Motion, PinForces, RapierContact, StepError};
pub use plan::{
    Capsule, ContactPartner, ContactPointConvention, L21, L22, Plan, PlannedBody, PlannedBrake, PlannedContact,
    PlannedDrive, PlannedFixedSurface, PlannedGear, PlannedMotor, PlannedPin, PlannedRotor, PlannedSpring, PlannedStop,
    PrescribedMotion, Shape, build_plan,
};
pub(crate) use plan::{L11, L12, LINKS, driven_link_brake_torque, first_link};
pub use stepper::next_step;
pub use substeps::{Change, ChangeKind, ContactExtremum, ContactSolveError, ContactSolver, Tolerance};
pub use world::{World, build_world};
