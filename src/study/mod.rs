//! Studies: how results depend on settings and on designs.
//!
//! | module | content |
//! |---|---|
//! | `bisect` | bisection |
//! | `capture` | positioning errors that a gripper captures |
//! | `posture` | text form of a gripper's posture |
//! | `hold` | largest acceleration under which a gripper holds its object |
//! | `kind` | check of the scene kind for gripper studies |
//! | `parts` | sweeps distributed over several machines: parts of a study and their merge |
//! | `optimize` | optimal designs over ranges of scene fields |
//! | `pool` | thread pool of the studies |
//! | `provenance` | provenance file of sweep results |
//! | `quantity` | short names and common units of columns and keys |
//! | `random` | reproducible random numbers |
//! | `reproduce` | figures of the thesis, recomputed and compared with the printed ones |
//! | `select` | selection and ranking of the designs of a sweep |
//! | `size` | sizing of spring and motor for the finger of a scene |
//! | `stability` | stability and accuracy of the engine model |
//! | `step_size` | impact force as a function of step size |
//! | `store` | incremental storage of sweep results |
//! | `sweep` | parameter sweeps over fields of a scene |
//! | `volume` | grasp-state volumes: designs that hold the object |

mod bisect;
pub mod capture;
pub mod hold;
mod kind;
pub mod optimize;
pub mod parts;
mod pool;
pub mod posture;
pub mod provenance;
pub mod quantity;
mod random;
pub mod reproduce;
pub mod select;
pub mod size;
pub mod stability;
pub mod step_size;
pub mod store;
pub mod sweep;
pub mod volume;

use bisect::bisect;
pub use kind::require_gripper;
