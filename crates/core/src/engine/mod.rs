//! The engine model: a scene as rapier bodies and joints, with the contact laws in place of rapier's own response.
//!
//! How it drives rapier, and what rapier limits, is said in `src/docs/engine.md`. Independent of the analytic model: both share the
//! scene, lengths, masses and scalar laws, nothing else.
//!
//! | file | job |
//! |---|---|
//! | `plan` | what a scene needs, as plain lists of bodies, pins, drives, stops and contacts |
//! | `plan_of`, `finger`, `differential` | the plan of a scene's system |
//! | `world`, `hook` | the rapier world of a plan; contact taken out of rapier's hands |
//! | `linkage` | joints' reactions: the saddle-point system of bodies and joints |
//! | `forces`, `drive` | gravity, motor, spring, energies; bodies that move as told |
//! | `frame` | the frame of a palm that moves |
//! | `touch`, `space` | gaps and their rows; the contact space of one step |
//! | `implicit`, `substeps` | one implicit stage; contact integrated through one step |
//! | `settle` | rates of pressing contacts at a node |
//! | `motion`, `stepper` | one step, and how long it may be |
//! | `native` | rapier's own contact, read back |
//! | `dense` | small dense systems in place |

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
mod native;
mod plan;
mod plan_of;
mod settle;
mod space;
mod stepper;
mod substeps;
mod surfaces;
mod touch;
mod world;

pub use differential::brake_torque;
pub use finger::{L11, L12, L21, L22, LINKS, base};
pub use forces::{kinetic, potential};
pub use frame::Frame;
pub use linkage::{Inertia, Linkage, Locked, Place, Twist};
pub use motion::{Motion, StepError};
pub use native::Native;
pub use plan::{
    Against, Capsule, Course, Meet, Plan, PlannedBody, PlannedContact, PlannedDrive, PlannedFixed, PlannedGear,
    PlannedHold, PlannedMotor, PlannedPin, PlannedRotor, PlannedSpring, PlannedStop, Shape,
};
pub use plan_of::plan;
pub use space::{Site, Space};
pub use stepper::next;
pub use substeps::{Change, ChangeKind, Contact, Moment, Tolerance, Unsolved};
pub use touch::{RESTING, Row, Touch};
pub use world::{World, build};
