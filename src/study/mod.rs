//! Studies: how results depend on settings and on designs.
//!
//! | module | content |
//! |---|---|
//! | `capture` | positioning errors that a gripper captures |
//! | `posture` | text form of a gripper's posture |
//! | `hold` | largest acceleration under which a gripper holds its object |
//! | `kind` | check of the scene kind for gripper studies |
//! | `parts` | sweeps distributed over several machines: parts of a study and their merge |
//! | `optimize` | optimal designs over ranges of scene fields |
//! | `pool` | thread pool of the studies |
//! | `provenance` | provenance file of sweep results |
//! | `random` | reproducible random numbers |
//! | `select` | selection and ranking of the designs of a sweep |
//! | `size` | sizing of spring and motor for the finger of a scene |
//! | `store` | incremental storage of sweep results |
//! | `sweep` | parameter sweeps over fields of a scene |

pub mod capture;
pub mod hold;
mod kind;
pub mod optimize;
pub mod parts;
mod pool;
pub mod posture;
pub mod provenance;
mod random;
pub mod select;
pub mod size;
pub mod store;
pub mod sweep;

pub use kind::require_gripper;
