//! Loads scenes from files. The core defines scenes and parses their text.

pub(crate) mod file;

pub use file::{
    load, load_any, load_any_with, load_extended, load_layers, load_template, load_template_with, load_with,
};
pub use phalanx_core::scene::*;
