//! The closed form of the thesis for one finger that closes on a fixed object (§2.1): the independent check of the general
//! kernel, and the kernel of studies, which run it by the thousand. Nothing general depends on it.

mod events;
mod finger;
mod model;

pub use finger::{DistalShape, PassiveJoints, distal, proximal};
pub use model::{EVENT_FUNCTIONS, FingerMode, FingerMotion, Model, QUADRATURES, StictionModel};
