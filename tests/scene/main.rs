//! Tests of scene files: parsing, defaults, messages.
//!
//! They are one test program because most of its cost is linking.

use phalanx::scene::{self, Scene};

#[path = "../support/mod.rs"]
mod support;

mod as_mechanism;
mod bodies;
mod drives;
mod files;
mod finger;
mod fuzz_corpus;
mod gripper;
mod mechanism;
mod names;
mod parameters;
mod settings;
mod start;
mod unsupported;

/// Drive of a finger or a gripper.
const DRIVE: &str = "[motor]\ntorque = \"480 N*mm\"\n[spring]\ntorque = \"132.6 N*mm\"\n";
/// The finger of design 95.
const DESIGN: &str = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";

#[track_caller]
fn parse(text: &str) -> Scene {
    scene::parse_any(text, "some/where/test.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Parses the finger of design 95 with more keys.
#[track_caller]
fn finger_with(rest: &str) -> Scene {
    parse(&format!("{DESIGN}{DRIVE}{rest}"))
}

/// Asserts that the shown scene parses to the same scene, bit for bit (`{:?}` of different `f64` values differs), except
/// for its source.
#[track_caller]
fn assert_round_trip(scene: &Scene) {
    let text = scene::show(scene);
    let mut back = parse(&text);
    assert_eq!(scene::show(&back), text);
    assert_eq!(back.source, text);
    // The file names of tests differ.
    back.source.clone_from(&scene.source);
    assert_eq!(format!("{back:?}"), format!("{scene:?}"), "{text}");
}
