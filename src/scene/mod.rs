//! Scenes from files; what a scene is, and how its text is read, is the core's.

pub(crate) mod file;

pub use file::{layers, layers_of, load, load_any, load_any_with, load_template, load_template_with, load_with};
pub use phalanx_core::scene::*;
