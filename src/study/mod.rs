//! Studies: what a choice of settings does to a result, and what a choice of design does.
//!
//! | file | job |
//! |---|---|
//! | `beside` | what stands beside the results of a sweep |
//! | `capture` | which positioning errors a gripper captures |
//! | `posture` | a gripper's posture in words |
//! | `hold` | how much acceleration a gripper holds its object against |
//! | `kind` | studies that are about grippers |
//! | `parts` | sweeps beyond one machine: parts of a study, and such parts joined |
//! | `optimize` | the best designs over ranges of fields |
//! | `pool` | the threads that the others work on |
//! | `random` | random numbers that stay the same |
//! | `reproduce` | the thesis's figures again, beside what it prints |
//! | `select` | which designs of a sweep meet the criteria, and which is best |
//! | `size` | spring and motor for the finger of a scene |
//! | `stability` | where the engine is stable, and where it is right |
//! | `step_size` | the force of an impact against the step |
//! | `store` | results of a sweep that grow on the disk |
//! | `sweep` | a scene again and again, with other values in some of its fields |
//! | `volume` | grasp-state volumes: which designs hold the object |

pub mod beside;
pub mod capture;
pub mod hold;
mod kind;
pub mod optimize;
pub mod parts;
mod pool;
pub mod posture;
mod random;
pub mod reproduce;
pub mod select;
pub mod size;
pub mod stability;
pub mod step_size;
pub mod store;
pub mod sweep;
pub mod volume;

pub use kind::only_gripper;
