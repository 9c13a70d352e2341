//! Loads scenes from files. The core defines scenes and parses their text.

pub(crate) mod file;

pub use file::{load, load_any, load_any_with, load_extended, load_layers};
pub use phalanx_core::scene::*;
