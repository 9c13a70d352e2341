//! Random scene texts through both models: whatever parses runs to its end or to an error that says why, breaks no
//! invariant, and leaves a log that reads back to the run's last state. What does not parse is refused with reasons.
//!
//! A scene that breaks something is printed with its seed: `scene(SEED)` of its kind makes it again.

#[path = "random_scenes/discs.rs"]
mod discs;
#[path = "random_scenes/finger.rs"]
mod finger;
#[path = "random_scenes/trial.rs"]
mod trial;

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::dice::{self, Dice};
use crate::grippers;
use phalanx::trace::Model;
use trial::{Counts, trial};

/// Step budget of every run.
const STEPS: u64 = 20_000;
/// Failures that are shown before a test gives up.
const SHOWN: usize = 5;

/// Scenes of the seeds `first`…`first + count`, in one model.
fn through(model: Model, text: fn(&mut Dice) -> String, first: u64, count: u64) {
    let mut counts = Counts::default();
    let mut broken = Vec::new();
    for seed in first..first + count {
        let text = text(&mut Dice::new(seed));
        let result = catch_unwind(AssertUnwindSafe(|| trial(model, &text, &mut counts)));
        let wrong = match result {
            Ok(Ok(())) => continue,
            Ok(Err(wrong)) => wrong,
            Err(_) => "a panic".to_string(),
        };
        broken.push(format!("---- seed {seed}, {} model: {wrong}\n{text}", model.name()));
    }
    println!("{count} scenes in the {} model: {counts}", model.name());
    let shown = broken.iter().take(SHOWN).cloned().collect::<Vec<_>>().join("\n");
    assert!(broken.is_empty(), "{} of {count} scenes went wrong\n{shown}", broken.len());
    // The scenes are worth something: most run, and most of those to their end.
    assert!(counts.refused() * 2 < count, "{counts}");
    assert!(counts.completed() > counts.ended(), "{counts}");
}

#[test]
fn fingers_in_the_analytic_model() {
    through(Model::Analytic, finger::text, 0, 1000);
}

#[test]
fn more_fingers_in_the_analytic_model() {
    through(Model::Analytic, finger::text, 1000, 500);
}

#[test]
fn fingers_in_the_engine() {
    through(Model::Engine, finger::text, 0, 400);
}

#[test]
fn more_fingers_in_the_engine() {
    through(Model::Engine, finger::text, 1000, 200);
}

#[test]
fn discs_in_the_analytic_model() {
    through(Model::Analytic, discs::text, 0, 250);
}

#[test]
fn discs_in_the_engine() {
    through(Model::Engine, discs::text, 0, 200);
}

#[test]
fn grippers_in_the_analytic_model() {
    through(Model::Analytic, grippers::text, 0, 120);
}

#[test]
fn grippers_in_the_engine() {
    through(Model::Engine, grippers::text, 0, 80);
}

/// Sixteen to fifty times as many: `cargo nextest run --test judge random_scenes --run-ignored only --no-capture`.
#[test]
#[ignore = "takes minutes"]
fn ten_times_as_many() {
    for (model, fingers) in [(Model::Analytic, 20_000), (Model::Engine, 8_000)] {
        through(model, finger::text, 100_000, fingers);
        through(model, discs::text, 100_000, 4_000);
        through(model, grippers::text, 100_000, 4_000);
    }
}
