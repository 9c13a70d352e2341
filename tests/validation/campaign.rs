//! A small campaign in every test run: random scenes over the whole space of contact laws. It compares the default
//! preset and the engine with the reference, the reference with another family of methods, and error estimates with
//! errors.
//!
//! A failing scene is printed with its seed. `cargo run --release --example campaign -- --family NAME --seed SEED -v
//! --save DIR` runs and saves it; more scenes can be run in the same way.

#[path = "../../tools/campaign/record.rs"]
#[allow(dead_code)]
mod record;
#[path = "../../tools/campaign/trial.rs"]
#[allow(dead_code)]
pub mod trial;

use crate::support::scenes::scene_text;
use phalanx::scene::parse_any;
use record::{Setting, difference, record};
use trial::{Verdict, run_trial};

/// Verdicts that no scene may have.
const FORBIDDEN_VERDICTS: [Verdict; 5] = [
    Verdict::ReferenceSlow,
    Verdict::ReferenceFailed,
    Verdict::PresetFailed,
    Verdict::PresetErrorUnreported,
    Verdict::EngineErrorUnreported,
];

/// Runs scenes of a family and limits the number of rare verdicts.
fn run_campaign(family: &str, first: u64, count: u64, engine: bool) {
    let (mut results, mut failures) = (Vec::new(), Vec::new());
    for seed in first..first + count {
        let text = scene_text(family, seed);
        let Ok(scene) = parse_any(&text, "random.toml") else { continue };
        let result = run_trial(&scene, engine);
        if FORBIDDEN_VERDICTS.iter().any(|verdict| result.verdicts.contains(verdict)) {
            let reasons: Vec<&str> = result.verdicts.iter().map(|verdict| verdict.text()).collect();
            failures.push(format!("---- seed {seed}: {}\n{text}", reasons.join("; ")));
        }
        results.push(result.verdicts);
    }
    let ran = results.len();
    assert!(failures.is_empty(), "{} of {ran} scenes\n{}", failures.len(), failures.join("\n"));
    // A useful campaign: most scenes run, few are chaotic, and few warnings are false.
    assert!(ran as u64 * 10 > count * 7, "{ran} of {count} scenes ran");
    for (verdicts, share) in [
        (&[Verdict::Chaotic][..], 20),
        (&[Verdict::PresetInaccurate], 20),
        (&[Verdict::PresetFalseAlarm, Verdict::EngineFalseAlarm], 50),
    ] {
        let has = |found: &&Vec<Verdict>| verdicts.iter().any(|verdict| found.contains(verdict));
        let found = results.iter().filter(has).count();
        assert!(found <= (ran / share).max(1), "{found} of {ran} scenes: {verdicts:?}");
    }
}

/// Defines one test per family and seed range, so that they run in parallel: first seed, number of scenes, and whether the
/// engine runs, too.
macro_rules! campaign_tests {
    ($($test:ident: $family:literal, $first:literal, $count:literal, $engine:literal;)*) => {
        $(#[test]
        fn $test() {
            run_campaign($family, $first, $count, $engine);
        })*
    };
}

campaign_tests! {
    mixed_fingers: "mixed", 20_000, 60, false;
    soft_fingers: "soft", 20_000, 60, false;
    sticking_fingers: "stick", 20_000, 60, false;
    discs_in_the_analytic_model: "discs", 20_000, 80, false;
    drives_in_the_analytic_model: "drives", 20_000, 60, false;
    mixed_fingers_in_both_models: "mixed", 30_000, 15, true;
    sticking_fingers_in_both_models: "stick", 30_000, 15, true;
    discs_in_both_models: "discs", 30_000, 20, true;
    drives_in_both_models: "drives", 30_000, 20, true;
}

/// Returns the median error of random scenes at each setting.
fn medians<const N: usize>(family: &str, seeds: impl Iterator<Item = u64>, settings: [Setting; N]) -> [f64; N] {
    let mut errors: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
    for seed in seeds {
        let Ok(scene) = parse_any(&scene_text(family, seed), "random.toml") else { continue };
        let reference = record(&scene, Setting::Reference, 0.0);
        for (list, setting) in errors.iter_mut().zip(settings) {
            list.push(difference(&reference, &record(&scene, setting, 0.0)));
        }
    }
    errors.map(|mut list| {
        list.sort_by(f64::total_cmp);
        list[list.len() / 2]
    })
}

/// The median error of random scenes decreases by more than one decade per two decades of tolerance.
#[test]
fn errors_decrease_with_the_tolerance() {
    let medians = medians("stick", 40_000..40_040, [1e-4, 1e-6, 1e-8].map(Setting::Rtol));
    assert!(medians[1] < 0.1 * medians[0] && medians[2] < 0.1 * medians[1], "{medians:?}");
    assert!(medians[0] < 1e-5, "{medians:?}");
}

/// A decade of the engine's tolerance at least halves the error. Its steps are of second order.
#[test]
fn engine_errors_decrease_with_the_tolerance() {
    // The joint limits of scene 40013 have 2.6e10 N·m/rad, so the engine takes millions of steps: half a minute at ten
    // times the default tolerance, and more than the time limit of a run at the default.
    for (family, skipped) in [("mixed", Some(40_013)), ("stick", None)] {
        let seeds = (40_000..40_020).filter(|seed| Some(*seed) != skipped);
        let medians = medians(family, seeds, [10.0, 1.0, 0.1].map(Setting::EngineTolerance));
        assert!(medians[1] < 0.5 * medians[0] && medians[2] < 0.5 * medians[1], "{medians:?}");
        assert!(medians[1] < 1e-4, "{medians:?}");
    }
}
