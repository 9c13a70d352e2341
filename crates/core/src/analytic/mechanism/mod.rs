//! The analytic model of any planar mechanism: Lagrange equations in independent joint coordinates, with loops closed in
//! closed form. The model is independent of the engine model, which it checks: both share the description of the
//! mechanism and the scalar laws.

mod actuator;
mod assur;
mod assur_bounds;
mod body_bounds;
mod bounds;
mod cable;
mod conditioning;
mod contacts;
mod drive_model;
mod dyad;
mod dynamics;
mod events;
mod exchange;
mod factor;
mod free;
mod gaps;
mod group;
mod inertia;
mod inertial_field;
mod joint;
mod joint_forces;
mod model;
mod motion;
mod nearest;
mod pairs;
mod palm_frame;
mod powertrain;
mod quasi_static;
mod reading;
mod removal;
mod strands;
mod tendon;

pub(crate) use conditioning::EXCHANGE_SINE;
pub use joint_forces::{JointForce, JointForces};
pub use model::{MechanismMode, MechanismModel};
pub use powertrain::DriveReading;
pub use strands::ElementReading;
