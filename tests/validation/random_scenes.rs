//! Random scene texts in both models. A valid scene runs to its end or to an error with a reason, violates no
//! invariant, and leaves a log that reads back to the last state of the run. An invalid scene is rejected with reasons.
//!
//! A failing scene is printed with its seed, from which the generator of its kind reproduces it.

#[path = "random_scenes/texts.rs"]
mod texts;
#[path = "random_scenes/trial.rs"]
mod trial;

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::grippers;
use crate::support::random::{self, Random};
use phalanx::trace::Model;
use trial::{Counts, run_trial};

/// Step budget of every run.
const MAX_STEPS: u64 = 20_000;
/// Largest number of failures that are printed.
const MAX_PRINTED_FAILURES: usize = 5;

/// Runs the scenes of the seeds `first`…`first + count` in one model.
fn run_scenes(model: Model, generate_text: fn(&mut Random) -> String, first: u64, count: u64) {
    let mut counts = Counts::default();
    let mut failures = Vec::new();
    for seed in first..first + count {
        let text = generate_text(&mut Random::for_seed(seed));
        let result = catch_unwind(AssertUnwindSafe(|| run_trial(model, &text, &mut counts)));
        let problem = match result {
            Ok(Ok(())) => continue,
            Ok(Err(problem)) => problem,
            Err(_) => "a panic".to_string(),
        };
        failures.push(format!("---- seed {seed}, {} model: {problem}\n{text}", model.name()));
    }
    println!("{count} scenes in the {} model: {counts:#?}", model.name());
    let printed = failures.iter().take(MAX_PRINTED_FAILURES).cloned().collect::<Vec<_>>().join("\n");
    assert!(failures.is_empty(), "{} of {count} scenes failed\n{printed}", failures.len());
    // The scenes are useful: most of them run, and most runs are completed.
    let [rejected, ended] = [&counts.rejected, &counts.ended].map(|reasons| reasons.values().sum::<u64>());
    assert!(rejected * 2 < count && counts.completed > ended, "{counts:?}");
}

/// Defines one test per model, family and seed range, so that they run in parallel: first seed and number of scenes.
macro_rules! random_scene_tests {
    ($($test:ident: $model:ident, $family:path, $first:literal, $count:literal;)*) => {
        $(#[test]
        fn $test() {
            run_scenes(Model::$model, $family, $first, $count);
        })*
    };
}

random_scene_tests! {
    fingers_in_the_analytic_model: Analytic, texts::finger, 0, 1000;
    more_fingers_in_the_analytic_model: Analytic, texts::finger, 1000, 500;
    fingers_in_the_engine: Engine, texts::finger, 0, 400;
    more_fingers_in_the_engine: Engine, texts::finger, 1000, 200;
    discs_in_the_analytic_model: Analytic, texts::discs, 0, 250;
    discs_in_the_engine: Engine, texts::discs, 0, 200;
    grippers_in_the_analytic_model: Analytic, grippers::scene_text, 0, 120;
    grippers_in_the_engine: Engine, grippers::scene_text, 0, 80;
}

/// 16 to 50 times as many scenes: `cargo nextest run --test validation random_scenes --run-ignored only --no-capture`.
#[test]
#[ignore = "takes minutes"]
fn large_random_campaign_agrees() {
    for (model, fingers) in [(Model::Analytic, 20_000), (Model::Engine, 8_000)] {
        run_scenes(model, texts::finger, 100_000, fingers);
        run_scenes(model, texts::discs, 100_000, 4_000);
        run_scenes(model, grippers::scene_text, 100_000, 4_000);
    }
}
