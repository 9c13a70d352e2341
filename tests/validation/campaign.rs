//! A small campaign in every test run: random scenes over the whole space of contact laws. It compares the default
//! preset and the engine with the reference, the reference with another family of methods, and error estimates with
//! errors.
//!
//! A failing scene is printed with its seed. `cargo run --release --example campaign -- --family NAME --seed SEED
//! --scenes 1 -v --save DIR` runs and saves it; more scenes can be run in the same way.

#[path = "../../tools/campaign/discs.rs"]
mod discs;
#[path = "../../tools/campaign/fingers.rs"]
mod fingers;
#[path = "../../tools/campaign/record.rs"]
#[allow(dead_code)]
mod record;
#[path = "../../tools/campaign/trial.rs"]
#[allow(dead_code)]
mod trial;

use crate::rng::{self, Rng};
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
fn run_campaign(family: fn(&mut Rng) -> String, first: u64, count: u64, engine: bool) {
    let (mut ran, mut chaotic, mut inaccurate, mut false_alarms, mut failures) = (0, 0, 0, 0, Vec::new());
    for seed in first..first + count {
        let text = family(&mut Rng::new(seed));
        let Ok(scene) = parse_any(&text, "random.toml") else { continue };
        let result = run_trial(&scene, engine);
        let has = |verdict: Verdict| result.verdicts.contains(&verdict);
        ran += 1;
        chaotic += u32::from(has(Verdict::Chaotic));
        inaccurate += u32::from(has(Verdict::PresetInaccurate));
        false_alarms += u32::from(has(Verdict::PresetFalseAlarm) || has(Verdict::EngineFalseAlarm));
        if FORBIDDEN_VERDICTS.into_iter().any(has) {
            let reasons: Vec<String> = result.verdicts.iter().map(Verdict::to_string).collect();
            failures.push(format!("---- seed {seed}: {}\n{text}", reasons.join("; ")));
        }
    }
    assert!(failures.is_empty(), "{} of {ran} scenes\n{}", failures.len(), failures.join("\n"));
    // A useful campaign: most scenes run, few are chaotic, and few warnings are false.
    assert!(ran * 10 > count * 7, "{ran} of {count} scenes ran");
    let max_count = |share: u32| (ran as u32 / share).max(1);
    assert!(chaotic <= max_count(20), "{chaotic} of {ran} scenes are chaotic");
    assert!(inaccurate <= max_count(20), "the default preset is wrong in {inaccurate} of {ran} scenes");
    assert!(false_alarms <= max_count(50), "{false_alarms} false alarms in {ran} scenes");
}

#[test]
fn mixed_fingers() {
    run_campaign(fingers::mixed, 20_000, 60, false);
}

#[test]
fn soft_fingers() {
    run_campaign(fingers::soft, 20_000, 60, false);
}

#[test]
fn sticking_fingers() {
    run_campaign(fingers::stick, 20_000, 60, false);
}

#[test]
fn discs_in_the_analytic_model() {
    run_campaign(discs::scene_text, 20_000, 80, false);
}

#[test]
fn fingers_in_both_models() {
    run_campaign(fingers::mixed, 30_000, 15, true);
    run_campaign(fingers::stick, 30_000, 15, true);
}

#[test]
fn discs_in_both_models() {
    run_campaign(discs::scene_text, 30_000, 20, true);
}

/// Returns the median error of random scenes at each setting.
fn medians<const N: usize>(
    family: fn(&mut Rng) -> String,
    seeds: impl Iterator<Item = u64>,
    settings: [Setting; N],
) -> [f64; N] {
    let mut errors: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
    for seed in seeds {
        let Ok(scene) = parse_any(&family(&mut Rng::new(seed)), "random.toml") else { continue };
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
    let medians = medians(fingers::stick, 40_000..40_040, [1e-4, 1e-6, 1e-8].map(Setting::Rtol));
    assert!(medians[1] < 0.1 * medians[0] && medians[2] < 0.1 * medians[1], "{medians:?}");
    assert!(medians[0] < 1e-5, "{medians:?}");
}

/// Asserts that a decade of the engine's tolerance at least halves the error. Its steps are of second order.
fn assert_engine_errors_decrease(family: fn(&mut Rng) -> String, seeds: impl Iterator<Item = u64>) {
    let medians = medians(family, seeds, [10.0, 1.0, 0.1].map(Setting::EngineTolerance));
    assert!(medians[1] < 0.5 * medians[0] && medians[2] < 0.5 * medians[1], "{medians:?}");
    assert!(medians[1] < 1e-4, "{medians:?}");
}

#[test]
fn engine_errors_decrease_with_the_tolerance() {
    // The joint limits of scene 40013 have 2.6e10 N·m/rad, so the engine takes millions of steps: half a minute at ten
    // times the default tolerance, and more than the time limit of a run at the default.
    assert_engine_errors_decrease(fingers::mixed, (40_000..40_020).filter(|seed| *seed != 40_013));
}

#[test]
fn engine_errors_decrease_for_sticking_fingers() {
    assert_engine_errors_decrease(fingers::stick, 40_000..40_020);
}
