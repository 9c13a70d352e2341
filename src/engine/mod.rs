//! The engine model: the gripper as rapier bodies and joints, with the contact laws in place of rapier's own response.

mod dense;
mod forces;
mod hook;
mod implicit;
mod linkage;
mod motion;
mod native;
mod plan;
mod settle;
mod space;
mod stepper;
mod substeps;
mod touch;
mod world;

pub use forces::{kinetic, potential};
pub use motion::{Motion, StepError};
pub use native::Native;
pub use plan::{L11, L12, L21, L22, Plan, plan};
pub use stepper::next;
pub use substeps::{Change, ChangeKind};
pub use world::{World, build};
