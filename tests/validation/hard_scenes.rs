//! Every shipped scene of a finger: both models complete the run, satisfy every invariant, and agree within the bounds
//! of the scene. The default preset is close to the reference.

use std::collections::BTreeSet;
use std::fs;

use phalanx::integrator::Reason;
use phalanx::scene::{self, Scene};
use phalanx::trace::{FingerContact, Model, RunError, Sample, run};
use phalanx::validate::{
    MAX_STANDARD_ERRORS, Recording, check_bounds, check_invariants, compare, compare_statistics, reference_scene,
    sampled_scene,
};

use crate::support::checked_run::{assert_no_violations, record_run};
use FingerContact::{Distal, Proximal};

/// Largest difference of the default preset from the reference along the whole path, in rad or lengths of 20 mm.
const MAX_DEFAULT_ERROR: f64 = 1e-5;
/// Scenes that amplify errors, as undamped rebounds do, with their largest difference.
const AMPLIFYING_SCENES: [(&str, f64); 2] = [("hard/chaos", 1e-2), ("hard/damper-nowhere", 1e-3)];

pub fn load(name: &str) -> Scene {
    scene::load_any(format!("scenes/{name}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs a scene in the analytic model with the settings of the reference.
pub fn run_reference(name: &str) -> Recording {
    record_run(Model::Analytic, &reference_scene(&load(name)))
}

/// Runs a scene in both models and checks their agreement. Returns the scene, the reference run and the engine's run.
pub fn assert_models_agree(name: &str) -> (Scene, [Recording; 2]) {
    let scene = load(name);
    let run_and_check = |label: &str, model: Model, scene: &Scene| {
        let run = record_run(model, scene);
        assert_no_violations(&check_invariants(scene, model, &run), &format!("{name}, {label}"));
        run
    };
    let expected = run_and_check("reference", Model::Analytic, &reference_scene(&scene));
    let run = run_and_check("default", Model::Analytic, &sampled_scene(Model::Analytic, &scene));
    let error = compare(&run, &expected, scene.bounds.until_s).path_max();
    let amplified = AMPLIFYING_SCENES.iter().find(|(scene, _)| *scene == name);
    let allowed = amplified.map_or(MAX_DEFAULT_ERROR, |(_, allowed)| *allowed);
    assert!(error < allowed, "{name}: the default preset has an error of {error:.1e}");
    let run = record_run(Model::Engine, &sampled_scene(Model::Engine, &scene));
    assert_no_violations(&check_invariants(&scene, Model::Engine, &run), &format!("{name}, engine"));
    let verdict = check_bounds(&compare(&run, &expected, scene.bounds.until_s), &scene.bounds);
    let failed_checks: Vec<_> = verdict.checks.iter().filter(|check| !check.passed).collect();
    assert!(failed_checks.is_empty(), "{name}: {failed_checks:?}");
    (scene, [expected, run])
}

/// Names of all scenes in a directory.
pub fn scenes_in(directory: &str) -> BTreeSet<String> {
    let files = fs::read_dir(format!("scenes/{directory}")).expect("the scenes");
    let names = files.map(|entry| entry.expect("an entry").file_name().into_string().expect("text"));
    names.filter_map(|name| name.strip_suffix(".toml").map(String::from)).collect()
}

/// The name of a test of a scene.
pub fn test_name(scene: &str) -> String {
    scene.replace(['-', '.'], "_")
}

/// Defines a test for each scene of a directory, so that they run in parallel, and a list of these tests.
macro_rules! agreement_tests {
    ($list:ident, $directory:literal, $check:path: $($test:ident)*) => {
        $(#[test]
        fn $test() {
            let mut names = $crate::hard_scenes::scenes_in($directory).into_iter();
            let name = names.find(|name| $crate::hard_scenes::test_name(name) == stringify!($test));
            $check(&format!("{}/{}", $directory, name.expect("a scene")));
        })*
        const $list: &[&str] = &[$(stringify!($test)),*];
    };
}
pub(crate) use agreement_tests;

agreement_tests! { HARD, "hard", assert_models_agree:
    a_turn_apart damper_none damper_nowhere damper_stiff end_cap exponent_1 exponent_1_5 exponent_3 friction_2
    gravity_100g gravity_none grazing grazing_held hold_10s large limit_hammered limit_lets_go limit_pulls
    mass_crank_heavy mass_links_light mass_tip_heavy mass_tip_light near_singular near_singular_start other_assembly
    spring_off start_in_penetration step_1ms sticks_at_once stiffness_1e12 stiffness_1e6 tiny torque_steps torque_x0_1
    torque_x10 v_static_1e_2 v_static_1e_3 v_static_1e_4
}

/// Scenes with a separate test, below or (limit-rattles, limit-rings-on) in `check`.
const SCENES_WITH_OWN_TEST: &str = "both_at_once chaos friction_none friction_well limit_rattles limit_rings limit_rings_on limit_touches \
     limit_trembles missed_reload misses slip_reversal start_in_contact through_the_fold torque_reversal";

#[test]
fn every_hard_scene_is_tested() {
    // `hard_grippers` tests the grippers.
    let mut scenes = scenes_in("hard");
    scenes.retain(|name| !name.starts_with("gripper-"));
    let tested: BTreeSet<String> =
        HARD.iter().copied().chain(SCENES_WITH_OWN_TEST.split(' ')).map(String::from).collect();
    assert_eq!(scenes.iter().map(|name| test_name(name)).collect::<BTreeSet<_>>(), tested);
    scenes.iter().for_each(|name| assert_eq!(load(&format!("hard/{name}")).name, *name));
}

#[test]
fn all_shipped_scenes_are_within_their_bounds() {
    let scenes = scenes_in("");
    assert!(scenes.len() >= 8, "only {} scenes found", scenes.len());
    for name in scenes {
        assert_models_agree(&name);
    }
}

#[test]
fn both_phalanges_touch_within_a_quarter_of_a_microsecond() {
    for run in assert_models_agree("hard/both-at-once").1 {
        let [proximal_s, distal_s] =
            [Proximal, Distal].map(|contact| run.outcome.finger_contact(contact).first_s.expect("a touch"));
        assert!((distal_s - proximal_s).abs() < 0.25e-6);
    }
}

/// Trajectories agree up to `until`; beyond it, the energy and the statistics of many runs do.
#[test]
fn chaotic_rebounds_have_the_same_statistics() {
    let (scene, runs) = assert_models_agree("hard/chaos");
    // Nothing dissipates: the remaining energy error is that of the integrators.
    for run in &runs {
        let energy = run.outcome.last.energy();
        assert!(energy.dissipated_j.abs() < 1e-3 * energy.motor_work_j.abs(), "{energy:?}");
    }
    // The run is chaotic: the default preset, accurate to 1e-9 rad for a closing, has a large final error here.
    let default_end = record_run(Model::Analytic, &scene).outcome.last;
    assert!((default_end.finger(0).q11_rad - runs[0].outcome.last.finger(0).q11_rad).abs() > 1e-5);
    let statistics = compare_statistics(&scene, &|| true).expect("runs");
    assert!(statistics.runs >= 16, "{} runs", statistics.runs);
    assert!(statistics.worst() < MAX_STANDARD_ERRORS, "{statistics:?}");
}

/// Asserts a property of every sample of a scene in both models.
fn assert_every_sample(name: &str, property: impl Fn(&Sample) -> bool) -> [Recording; 2] {
    let (_, runs) = assert_models_agree(name);
    let violation = runs.iter().flat_map(|run| &run.samples).find(|sample| !property(sample));
    assert!(violation.is_none(), "{name}: {violation:?}");
    runs
}

#[test]
fn frictionless_contacts_have_no_tangential_force() {
    assert_every_sample("hard/friction-none", |sample| {
        [Proximal, Distal].map(|contact| sample.finger_contact(contact).tangential_n) == [0.0; 2]
    });
}

#[test]
fn an_object_out_of_reach_is_never_touched() {
    let is_apart =
        |sample: &Sample| [Proximal, Distal].into_iter().all(|contact| sample.finger_contact(contact).gap_m > 0.0);
    for run in assert_every_sample("hard/misses", is_apart) {
        assert_eq!([Proximal, Distal].map(|contact| run.outcome.finger_contact(contact).touchdowns), [0, 0]);
    }
}

#[test]
fn a_start_in_contact_is_a_touch_down_at_time_zero() {
    for run in assert_models_agree("hard/start-in-contact").1 {
        let contact = run.outcome.finger_contact(Proximal);
        assert!(contact.first_s.expect("a touch") < 0.5e-6 && contact.touchdowns == 1, "{contact:?}");
    }
}

/// A step must not skip the sticking range of the slip: the other well is 0.34 rad away.
#[test]
fn friction_ends_in_the_correct_potential_well() {
    for run in assert_models_agree("hard/friction-well").1 {
        assert!((run.outcome.last.finger(0).q21_rad - 0.98887).abs() < 1e-4, "{}", run.outcome.last.finger(0).q21_rad);
    }
}

/// A contact in quasi-static projection returns its impulse with a rounding error (5e-12 N·m·s), so the invariants are
/// not checked here. The default preset is compared with the reference, which must not take steps to follow rounding
/// errors.
#[test]
fn joint_limits_moved_by_rounding_do_not_stall_the_reference() {
    for name in ["hard/limit-trembles", "hard/limit-rings", "hard/limit-touches"] {
        let (scene, expected) = (load(name), run_reference(name));
        assert!(expected.outcome.work.steps < 100_000, "{name}: {} steps", expected.outcome.work.steps);
        let error = compare(&record_run(Model::Analytic, &scene), &expected, scene.bounds.until_s).path_max();
        assert!(error < MAX_DEFAULT_ERROR, "{name}: {error:.1e} rad off");
    }
}

/// Reloads that last microseconds are detected: six events, not four.
#[test]
fn reloads_within_a_step_are_detected() {
    let (scene, [expected, _]) = assert_models_agree("hard/missed-reload");
    assert_eq!(expected.outcome.work.events, 6);
    assert_eq!(record_run(Model::Analytic, &scene).outcome.work.events, 6);
}

/// In both models the tip slides outwards, sticks, and slides back.
#[test]
fn the_tip_slides_out_and_back() {
    for run in assert_models_agree("hard/slip-reversal").1 {
        let late = run.samples.iter().filter(|sample| sample.time_s > 9e-3).map(|sample| sample.finger_contact(Distal));
        let slips: Vec<f64> = late.filter(|tip| tip.normal_n > 0.0).map(|tip| tip.slip_m_s).collect();
        let (forth, back) = (slips.iter().copied().fold(0.0, f64::max), slips.iter().copied().fold(0.0, f64::min));
        assert!(forth > 1.2 && back < -1.2, "{forth} {back}");
    }
}

/// The analytic model reports the time and the reason of its end, with the run up to it. The engine continues.
#[test]
fn a_fold_stops_only_the_analytic_model() {
    let scene = load("hard/through-the-fold");
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
    for Recording { outcome, .. } in assert_models_agree("hard/torque-reversal").1 {
        assert_eq!([Proximal, Distal].map(|contact| outcome.last.finger_contact(contact).normal_n), [0.0, 0.0]);
        assert!(outcome.last.finger_contact(Proximal).gap_m > 1e-3 && outcome.last.energy().kinetic_j > 1.0);
    }
}
