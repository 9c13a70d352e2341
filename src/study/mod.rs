//! Studies: what a choice of settings does to a result, and what a choice of design does.
//!
//! | file | job |
//! |---|---|
//! | `stability` | where the engine is stable, and where it is right |
//! | `step_size` | the force of an impact against the step |
//! | `volume` | grasp-state volumes: which designs hold the object |

pub mod stability;
pub mod step_size;
pub mod sweep;
pub mod volume;
