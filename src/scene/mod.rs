//! Scenes from files; what a scene is, and how its text is read, is the core's.

pub(crate) mod file;

pub use file::{load, load_any, load_template};
pub use phalanx_core::scene::*;
