//! The engine model: a scene as rapier bodies and joints, with the contact laws in place of rapier's own response.
//!
//! `src/docs/engine.md` describes how it drives rapier and the limits of rapier. The engine is independent of the
//! analytic model: both share only the scene, lengths, masses and scalar laws.
//!
//! | file | job |
//! |---|---|
//! | `plan` | the components of a scene as plain lists of bodies, pins, drives, stops and contacts |
//! | `build_plan`, `finger`, `differential` | the plan of a scene's system |
//! | `world`, `hook` | the rapier world of a plan; the hook that disables rapier's contact response |
//! | `linkage` | joint reactions: the saddle-point system of bodies and joints |
//! | `forces`, `drive` | gravity, motor, spring, energies; bodies with prescribed motion |
//! | `frame` | the frame of a moving palm |
//! | `candidates`, `closest_points`, `contact_space` | gaps and their rows; closest points of non-round shapes; the contact space of one step |
//! | `implicit`, `substeps` | one implicit stage; contact integrated through one step |
//! | `rate_correction` | correction of the rates of active contacts at a node |
//! | `motion`, `stepper` | one step; step size control |
//! | `rapier_contact` | impulses of rapier's own contact |
//! | `dense` | small dense linear systems, solved in place |

mod build_plan;
mod candidates;
mod closest_points;
mod contact_space;
mod dense;
mod differential;
mod drive;
mod finger;
mod forces;
mod frame;
mod hook;
mod implicit;
mod linkage;
mod motion;
mod plan;
mod rapier_contact;
mod rate_correction;
mod stepper;
mod substeps;
mod world;

pub use build_plan::build_plan;
pub use candidates::{ContactCandidate, Row, ZERO_RATE};
pub use contact_space::{ActiveContact, ContactSpace};
pub use differential::driven_link_brake_torque;
pub use finger::{L11, L12, L21, L22, LINKS, first_link};
pub use forces::{kinetic_energy, potential_energies};
pub use frame::PalmFrame;
pub use linkage::{BodyPose, Inertia, Linkage, SingularConstraints, Twist};
pub use motion::{Motion, StepError};
pub use plan::{
    Capsule, ContactPartner, ContactPointConvention, Plan, PlannedBody, PlannedBrake, PlannedContact, PlannedDrive,
    PlannedFixedSurface, PlannedGear, PlannedMotor, PlannedPin, PlannedRotor, PlannedSpring, PlannedStop,
    PrescribedMotion, Shape,
};
pub use rapier_contact::RapierContact;
pub use stepper::next_step;
pub use substeps::{Change, ChangeKind, ContactExtremum, ContactSolveError, ContactSolver, Tolerance};
pub use world::{World, build_world};
