//! The generator of random scenes, for the campaign, the tests and the tools. Each program uses part of it.
//!
//! A family and a seed determine a scene. Families of [`FAMILIES`] are texts of scene files; [`trees`] and [`loops`] are
//! mechanisms as values, for tests of the models alone.
#![allow(dead_code)]

mod discs;
mod drives;
mod fingers;
mod grippers;
mod law;
pub mod loops;
mod mechanisms;
mod parts;
pub mod random;
pub mod spoil;
pub mod trees;

use random::Random;

/// Name of a family, and its generator of scene texts.
type Family = (&'static str, fn(&mut Random) -> String);

/// All families of scene texts.
pub const FAMILIES: [Family; 14] = [
    ("mixed", fingers::mixed),
    ("soft", fingers::soft),
    ("stick", fingers::stick),
    ("discs", discs::scene_text),
    ("grippers", grippers::scene_text),
    ("objects", grippers::with_other_object),
    ("jaws", mechanisms::jaws),
    ("tendons", mechanisms::tendon_fingers),
    ("cables", mechanisms::rubbing_fingers),
    ("linkages", mechanisms::linkage),
    ("sliders", mechanisms::sliders),
    ("drives", drives::scene_text),
    ("thrown", mechanisms::thrown),
    ("falling", mechanisms::falling),
];

/// Returns the text of a scene.
///
/// # Panics
/// Panics if there is no family of this name.
pub fn scene_text(family: &str, seed: u64) -> String {
    let (_, generate) =
        FAMILIES.iter().find(|(name, _)| *name == family).unwrap_or_else(|| panic!("no family {family}"));
    generate(&mut Random::for_seed(seed))
}
