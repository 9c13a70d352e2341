//! Every scene of scenes/hard: both models complete the run, satisfy every invariant, and agree within the bounds of
//! the scene.

use std::collections::BTreeSet;
use std::fs;

use phalanx::integrator::Reason;
use phalanx::scene::{self, Scene};
use phalanx::trace::{FingerContact, Model, RunError, run};
use phalanx::validate::{
    MAX_STANDARD_ERRORS, Recording, check_bounds, check_invariants, compare, compare_statistics, reference_scene,
    sampled_scene,
};

use crate::support::checked_run::{assert_no_violations, record_run};

fn load(name: &str) -> Scene {
    scene::load(format!("scenes/hard/{name}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

/// Largest difference of the default preset from the reference along the whole path, rad.
const MAX_DEFAULT_ERROR: f64 = 1e-5;
/// Scenes whose undamped rebounds amplify errors, with their largest difference, rad.
const AMPLIFYING_SCENES: &[(&str, f64)] = &[("chaos", 1e-2), ("damper-nowhere", 1e-3)];

/// Runs a scene in both models and checks their agreement. Returns the scene, the reference run and the engine's run.
fn assert_models_agree(name: &str) -> (Scene, Recording, Recording) {
    let scene = load(name);
    assert_eq!(scene.name, name);
    let reference = reference_scene(&scene);
    let expected = record_run(Model::Analytic, &reference);
    assert_no_violations(
        &check_invariants(&reference, Model::Analytic, &expected),
        &format!("{name}, analytic reference"),
    );
    let default_scene = sampled_scene(Model::Analytic, &scene);
    let run = record_run(Model::Analytic, &default_scene);
    assert_no_violations(&check_invariants(&default_scene, Model::Analytic, &run), &format!("{name}, analytic"));
    let error = compare(&run, &expected, scene.bounds.until_s).path_max();
    let allowed =
        AMPLIFYING_SCENES.iter().find(|(scene, _)| *scene == name).map_or(MAX_DEFAULT_ERROR, |(_, allowed)| *allowed);
    assert!(error < allowed, "{name}: the default preset has an error of {error:.1e} rad");
    let run = record_run(Model::Engine, &sampled_scene(Model::Engine, &scene));
    assert_no_violations(&check_invariants(&scene, Model::Engine, &run), &format!("{name}, engine"));
    let verdict = check_bounds(&compare(&run, &expected, scene.bounds.until_s), &scene.bounds);
    let failed_checks: Vec<_> = verdict.checks.iter().filter(|check| !check.passed).collect();
    assert!(failed_checks.is_empty(), "{name}: {failed_checks:?}");
    (scene, expected, run)
}

/// Defines one test per scene, so that they run in parallel.
macro_rules! agreement_tests {
    ($($test:ident = $name:literal),* $(,)?) => {
        $(#[test]
        fn $test() {
            assert_models_agree($name);
        })*
        const SCENES_TESTED_BY_MACRO: &[&str] = &[$($name),*];
    };
}

agreement_tests! {
    a_turn_apart = "a-turn-apart",
    limit_lets_go = "limit-lets-go",
    limit_pulls = "limit-pulls",
    sticks_at_once = "sticks-at-once",
    damper_none = "damper-none",
    damper_nowhere = "damper-nowhere",
    damper_stiff = "damper-stiff",
    end_cap = "end-cap",
    exponent_1 = "exponent-1",
    exponent_1_5 = "exponent-1.5",
    exponent_3 = "exponent-3",
    friction_2 = "friction-2",
    gravity_100g = "gravity-100g",
    gravity_none = "gravity-none",
    grazing = "grazing",
    grazing_held = "grazing-held",
    hold_10s = "hold-10s",
    large = "large",
    limit_hammered = "limit-hammered",
    mass_crank_heavy = "mass-crank-heavy",
    mass_links_light = "mass-links-light",
    mass_tip_heavy = "mass-tip-heavy",
    mass_tip_light = "mass-tip-light",
    near_singular = "near-singular",
    near_singular_start = "near-singular-start",
    other_assembly = "other-assembly",
    spring_off = "spring-off",
    start_in_penetration = "start-in-penetration",
    step_1ms = "step-1ms",
    stiffness_1e12 = "stiffness-1e12",
    stiffness_1e6 = "stiffness-1e6",
    tiny = "tiny",
    torque_steps = "torque-steps",
    torque_x0_1 = "torque-x0.1",
    torque_x10 = "torque-x10",
    v_static_1e_2 = "v-static-1e-2",
    v_static_1e_3 = "v-static-1e-3",
    v_static_1e_4 = "v-static-1e-4",
}

/// Scenes with a separate test, below or (limit-rattles, limit-rings-on) in `check`.
const SCENES_WITH_OWN_TEST: &[&str] = &[
    "limit-rattles",
    "limit-rings",
    "limit-rings-on",
    "limit-touches",
    "limit-trembles",
    "friction-well",
    "missed-reload",
    "both-at-once",
    "chaos",
    "friction-none",
    "misses",
    "start-in-contact",
    "slip-reversal",
    "through-the-fold",
    "torque-reversal",
];

#[test]
fn every_hard_scene_is_tested() {
    let files = fs::read_dir("scenes/hard").expect("the scenes").map(|entry| {
        let path = entry.expect("an entry").path();
        path.file_stem().expect("a name").to_string_lossy().into_owned()
    });
    // `hard_grippers` tests the grippers.
    let files = files.filter(|name| !name.starts_with("gripper-"));
    let tested: BTreeSet<String> =
        SCENES_TESTED_BY_MACRO.iter().chain(SCENES_WITH_OWN_TEST).map(ToString::to_string).collect();
    assert_eq!(files.collect::<BTreeSet<_>>(), tested);
}

#[test]
fn both_phalanges_touch_within_a_quarter_of_a_microsecond() {
    let (_, expected, engine) = assert_models_agree("both-at-once");
    for run in [expected, engine] {
        let first_touch_s =
            |phalanx_contact: FingerContact| run.outcome.finger_contact(phalanx_contact).first_s.expect("a touch");
        assert!((first_touch_s(FingerContact::Distal) - first_touch_s(FingerContact::Proximal)).abs() < 0.25e-6);
    }
}

/// Trajectories agree up to `until`; beyond it, the energy and the statistics of many runs do.
#[test]
fn chaotic_rebounds_have_the_same_statistics() {
    let (scene, expected, engine) = assert_models_agree("chaos");
    // Nothing dissipates: the remaining energy error is that of the integrators.
    for run in [&expected, &engine] {
        let energy = run.outcome.last.energy();
        assert!(energy.dissipated_j.abs() < 1e-3 * energy.motor_work_j.abs(), "{energy:?}");
    }
    // The run is chaotic: the default preset, accurate to 1e-9 rad for a closing, has a large final error here.
    let default_end = record_run(Model::Analytic, &scene).outcome.last;
    assert!((default_end.finger(0).q11_rad - expected.outcome.last.finger(0).q11_rad).abs() > 1e-5);
    let statistics = compare_statistics(&scene, &|| true).expect("runs");
    assert!(statistics.runs >= 16, "{} runs", statistics.runs);
    assert!(statistics.worst() < MAX_STANDARD_ERRORS, "{statistics:?}");
}

#[test]
fn frictionless_contacts_have_no_tangential_force() {
    let (_, expected, engine) = assert_models_agree("friction-none");
    for sample in expected.samples.iter().chain(&engine.samples) {
        assert_eq!(
            (
                sample.finger_contact(FingerContact::Proximal).tangential_n,
                sample.finger_contact(FingerContact::Distal).tangential_n
            ),
            (0.0, 0.0)
        );
    }
}

#[test]
fn an_object_out_of_reach_is_never_touched() {
    let (_, expected, engine) = assert_models_agree("misses");
    for run in [expected, engine] {
        assert!(run.samples.iter().all(|sample| sample.finger_contact(FingerContact::Proximal).gap_m > 0.0
            && sample.finger_contact(FingerContact::Distal).gap_m > 0.0));
        assert_eq!(
            run.outcome.finger_contact(FingerContact::Proximal).touchdowns
                + run.outcome.finger_contact(FingerContact::Distal).touchdowns,
            0
        );
    }
}

#[test]
fn a_start_in_contact_is_a_touch_down_at_time_zero() {
    let (_, expected, engine) = assert_models_agree("start-in-contact");
    for run in [expected, engine] {
        assert!(run.outcome.finger_contact(FingerContact::Proximal).first_s.expect("a touch") < 0.5e-6);
        assert_eq!(run.outcome.finger_contact(FingerContact::Proximal).touchdowns, 1);
    }
}

/// A step must not skip the sticking range of the slip: the other well is 0.34 rad away.
#[test]
fn friction_ends_in_the_correct_potential_well() {
    let (_, expected, engine) = assert_models_agree("friction-well");
    for run in [expected, engine] {
        assert!((run.outcome.last.finger(0).q21_rad - 0.98887).abs() < 1e-4, "{}", run.outcome.last.finger(0).q21_rad);
    }
}

/// A contact in quasi-static projection returns its impulse with a rounding error (5e-12 N·m·s), so the invariants are
/// not checked here. The default preset is compared with the reference, which must not take steps to follow rounding
/// errors.
#[test]
fn joint_limits_moved_by_rounding_do_not_stall_the_reference() {
    for name in ["limit-trembles", "limit-rings", "limit-touches"] {
        let scene = load(name);
        let expected = record_run(Model::Analytic, &reference_scene(&scene));
        assert!(expected.outcome.work.steps < 100_000, "{name}: {} steps", expected.outcome.work.steps);
        let error = compare(&record_run(Model::Analytic, &scene), &expected, scene.bounds.until_s).path_max();
        assert!(error < MAX_DEFAULT_ERROR, "{name}: {error:.1e} rad off");
    }
}

/// Reloads that last microseconds are detected: six events, not four.
#[test]
fn reloads_within_a_step_are_detected() {
    let (scene, expected, _) = assert_models_agree("missed-reload");
    assert_eq!(expected.outcome.work.events, 6);
    assert_eq!(record_run(Model::Analytic, &scene).outcome.work.events, 6);
}

/// In both models the tip slides outwards, sticks, and slides back.
#[test]
fn the_tip_slides_out_and_back() {
    let (_, expected, engine) = assert_models_agree("slip-reversal");
    for run in [expected, engine] {
        let in_contact = run
            .samples
            .iter()
            .filter(|sample| sample.time_s > 9e-3 && sample.finger_contact(FingerContact::Distal).normal_n > 0.0);
        let slips: Vec<f64> = in_contact.map(|sample| sample.finger_contact(FingerContact::Distal).slip_m_s).collect();
        let (forth, back) = (slips.iter().copied().fold(0.0, f64::max), slips.iter().copied().fold(0.0, f64::min));
        assert!(forth > 1.2 && back < -1.2, "{forth} {back}");
    }
}

/// The analytic model reports the time and the reason of its end, with the run up to it. The engine continues.
#[test]
fn a_fold_stops_only_the_analytic_model() {
    let scene = load("through-the-fold");
    let Err(RunError::Simulation { failure, partial_outcome }) = run(Model::Analytic, &scene, &mut ()) else {
        panic!("the fold was not noticed")
    };
    assert!((failure.time_s - 6.4011e-3).abs() < 1e-6, "{failure}");
    assert!(matches!(&failure.reason, Reason::Obstacle(text) if text.contains("l12 and l22 are in line")), "{failure}");
    assert_eq!(partial_outcome.last.time_s, failure.time_s);
    let actual = record_run(Model::Engine, &sampled_scene(Model::Engine, &scene));
    assert_eq!(actual.outcome.last.time_s, scene.duration_s);
    assert_no_violations(&check_invariants(&scene, Model::Engine, &actual), "through the fold, engine");
}

#[test]
fn a_reversed_torque_opens_the_grasp_for_good() {
    let (_, expected, engine) = assert_models_agree("torque-reversal");
    for run in [expected, engine] {
        assert_eq!(
            (
                run.outcome.last.finger_contact(FingerContact::Proximal).normal_n,
                run.outcome.last.finger_contact(FingerContact::Distal).normal_n
            ),
            (0.0, 0.0)
        );
        assert!(
            run.outcome.last.finger_contact(FingerContact::Proximal).gap_m > 1e-3
                && run.outcome.last.energy().kinetic_j > 1.0
        );
    }
}
