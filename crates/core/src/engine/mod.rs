//! The engine model: a scene as rapier bodies and joints, with the contact laws in place of rapier's own response.
//!
//! `src/docs/engine.md` describes how it drives rapier and the limits of rapier. The engine is independent of the
//! analytic model: both share only the scene, lengths, masses and scalar laws.

mod cable;
mod cancellation;
mod candidates;
mod closest;
mod contact_space;
mod coordinate;
mod force_rates;
mod forces;
mod joint;
mod linkage;
mod lists;
mod mechanism;
mod motion;
mod plan;
mod powertrain;
mod rapier_contact;
mod stepper;
mod substeps;
mod support;
mod world;

pub use cable::{CableReading, PlannedCableFriction};
pub use candidates::ContactCandidate;
pub(crate) use candidates::ZERO_RATE;
pub use contact_space::{ActiveContact, CablePlace, ContactSpace};
pub use coordinate::{BodyPoint, BodyPose, Coordinate, Measure, Row, Twist};
pub use forces::{PalmFrame, kinetic_energy, potential_energies};
pub use linkage::{Inertia, Linkage, SingularConstraints};
pub use mechanism::{build_mechanism_plan, build_plan};
pub use motion::{JointReactions, Motion, StepError};
pub use plan::{
    BrakeKind, Capsule, ContactPointConvention, Plan, PlannedActuator, PlannedBody, PlannedBrake, PlannedContact,
    PlannedDrive, PlannedGear, PlannedJoint, PlannedMotor, PlannedRotor, PlannedServo, PlannedSpring, PlannedStop,
    PlannedSurface, PlannedTendon, ServoLaw, Shape, SurfaceId,
};
pub use powertrain::{PlannedPowertrain, PowertrainLaw, PowertrainStep};
pub use rapier_contact::RapierContact;
pub use stepper::next_step;
pub use substeps::{Change, ChangeKind, ContactExtremum, ContactSolveError, ContactSolver, Tolerance};
pub use world::{World, build_world};
