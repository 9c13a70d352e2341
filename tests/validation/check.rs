//! The error estimate of a run, compared with the known error. The check reports no more than it compared: regression
//! tests of runs whose error was once reported as 0 m, and of similar runs.

use crate::hard_scenes::load;
use crate::support::checked_run::record_run;
use phalanx::check::{
    ANALYTIC_LIMITS, CHAOS_THRESHOLD, Check, ENGINE_LIMITS, MOTION_FRACTION, PERTURBATION, Verdict, check, perturbed,
    units,
};
use phalanx::log::run_into;
use phalanx::report::check::{RunCheckReport, summary_line};
use phalanx::scene::{PalmMotion, Scene, Stepping, parse_any};
use phalanx::trace::Model;
use phalanx::validate::{compare, reference_scene, sampled_scene};

fn scene(text: &str) -> Scene {
    parse_any(text, "scene.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn run_check(model: Model, scene: &Scene) -> Check {
    check(model, scene, &|| true)
}

/// Returns the largest difference of an angle from the reference, rad.
fn reference_error(model: Model, scene: &Scene) -> f64 {
    let reference = record_run(Model::Analytic, &reference_scene(scene));
    compare(&record_run(model, &sampled_scene(model, scene)), &reference, scene.bounds.until_s).path_max()
}

/// Returns the effect of a tiny perturbation on the angles, rad.
fn perturbation_effect(scene: &Scene) -> f64 {
    let [reference, perturbed_run] =
        [scene, &perturbed(scene, PERTURBATION)].map(|scene| record_run(Model::Analytic, &reference_scene(scene)));
    compare(&perturbed_run, &reference, scene.bounds.until_s).path_max()
}

#[test]
fn the_error_of_a_run_is_estimated_within_a_factor_of_two() {
    let with_rtol = |name: &str, rtol: f64| {
        let scene = load(name);
        Scene { integrator: scene.integrator.with_rtol(rtol), ..scene }
    };
    let mut coarse = load("experiment-95");
    coarse.engine.stepping = Stepping::Fixed { step_s: 1e-4 };
    for (model, scene, verdict) in [
        (Model::Analytic, with_rtol("experiment-95", 1e-5), Verdict::Accurate),
        (Model::Analytic, with_rtol("experiment-95", 1e-3), Verdict::Accurate),
        (Model::Analytic, with_rtol("hard/friction-2", 1e-5), Verdict::Accurate),
        (Model::Engine, with_rtol("experiment-95", 1e-5), Verdict::Accurate),
        (Model::Engine, coarse, Verdict::Uncertain),
    ] {
        let (result, error) = (run_check(model, &scene), reference_error(model, &scene));
        let (name, estimate) = (&scene.name, result.errors.path);
        assert_eq!(result.verdict, verdict, "{name}");
        let ratio = estimate / error;
        assert!(ratio > 0.5 && ratio < 2.0, "{name}, {model:?}: {estimate:e} for {error:e}");
    }
}

/// A run with a log records more samples than one without.
#[test]
fn the_check_of_a_run_does_not_depend_on_its_log() {
    for name in ["experiment-95", "gripper/design-95", "hard/gripper-thrown", "laws/two-free", "mechanisms/jaws"] {
        for model in [Model::Analytic, Model::Engine] {
            let scene = load(name);
            let (run, _) = run_into(&scene, model, Vec::new()).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(run.check, Some(run_check(model, &scene)), "{name}, {model:?}");
        }
    }
}

/// Undamped rebounds with a stronger drive.
#[test]
fn a_run_sensitive_to_a_tiny_perturbation_is_chaotic() {
    let text = load("hard/chaos").source.replace("480 N*mm", "600 N*mm").replace("132.6 N*mm", "600 N*mm");
    let scene = scene(&text);
    for model in [Model::Analytic, Model::Engine] {
        let result = run_check(model, &scene);
        assert_eq!(result.verdict, Verdict::Chaotic, "{model:?}");
        assert!(result.sensitivity > CHAOS_THRESHOLD, "{:e}", result.sensitivity);
    }
    // Up to 15 ms, the end of the comparison of trajectories, the run is not chaotic.
    let effect = perturbation_effect(&scene);
    assert!(effect < CHAOS_THRESHOLD, "{effect:e}");
}

/// The reported sensitivity is the effect of the perturbation, also if it is small.
#[test]
fn sensitivity_is_the_effect_of_the_perturbation() {
    let scene = load("experiment-95");
    let (estimate, effect) = (run_check(Model::Analytic, &scene).sensitivity, perturbation_effect(&scene));
    assert!(estimate > 0.5 * effect && estimate < 2.0 * effect, "{estimate:e} for {effect:e}");
}

/// Quasi-static projection removes a rate. A check that projects in the same way would not detect this error.
#[test]
fn a_rattling_joint_limit_is_resolved_or_uncertain() {
    for name in ["hard/limit-rattles", "hard/limit-rings-on"] {
        let shipped = load(name);
        let (result, error) = (run_check(Model::Analytic, &shipped), reference_error(Model::Analytic, &shipped));
        assert!(result.verdict == Verdict::Uncertain || error < 1e-5, "{name}: {result:?}, {error:e} rad off");
        assert!(result.errors.path > 0.5 * error, "{name}: estimated {:e}, actual {error:e}", result.errors.path);
        let finer = Scene { integrator: shipped.integrator.with_rtol(1e-7), ..shipped };
        let error = reference_error(Model::Analytic, &finer);
        assert!(error < 1e-6, "{name} at rtol 1e-7: {error:e} rad off");
    }
}

/// A single sample estimates how thousands of events amplify the last digits, so such a run needs a margin to be sure.
#[test]
fn a_run_with_thousands_of_events_has_a_lower_error_limit() {
    for (name, limit) in [("experiment-95", 1e-5), ("hard/limit-trembles", 1e-6)] {
        let scene = load(name);
        let events = record_run(Model::Analytic, &scene).outcome.work.events;
        let result = run_check(Model::Analytic, &scene);
        assert_eq!(events > 1000, limit < 1e-5, "{name}: {events} events");
        assert!((result.max_path_error - limit).abs() < 1e-12, "{name}: {}", result.max_path_error);
        let is_accurate = result.verdict == Verdict::Accurate;
        assert_eq!(is_accurate, result.errors.path <= limit, "{name}: {result:?}");
    }
}

/// Returns the sections of a disc of `radius` (mm) above a half plane, at the given height and vertical velocity.
fn disc(name: &str, radius: f64, height: f64, mass: &str, velocity: f64) -> String {
    format!(
        "[discs.{name}]\nradius = \"{radius} mm\"\ncentre = [\"0 mm\", \"{height} mm\"]\nmass = \"{mass}\"\n\
         velocity = [\"0 m/s\", \"{velocity} m/s\"]\n"
    )
}

/// Returns the text of a scene of discs above a half plane; `end` follows the contact law.
fn discs_above_plane(duration: &str, discs: &[String], damping: &str, end: &str) -> String {
    format!(
        "kind = \"bodies\"\nduration = \"{duration}\"\n{}[half_plane]\n[contact]\nstiffness_si = 1e8\nexponent = 1.5\n\
         damping = \"{damping} N*s/m\"\n{end}",
        discs.concat()
    )
}

fn disc_above_plane(duration: &str, radius: f64, height: f64, velocity: f64) -> String {
    discs_above_plane(duration, &[disc("ball", radius, height, "0.1 kg", velocity)], "0", "")
}

/// Returns the text of a gripper of design 95 with scaled lengths, without friction.
fn scaled_gripper(scale: f64, motor: &str, spring: &str) -> String {
    let [half_width, base, l11, radius] = [2.5, 15.5, 15.0, 20.0].map(|length| format!("\"{} mm\"", length * scale));
    format!(
        "kind = \"gripper\"\nduration = \"1 ms\"\nhalf_width = {half_width}\n[design]\nbase = {base}\nl21_fraction = 1.0\n\
         phi22 = \"120 deg\"\narm_ratio = 0.5\nl11 = {l11}\n[object]\nradius = {radius}\n[motor]\ntorque = \"{motor}\"\n\
         [spring]\ntorque = \"{spring}\"\n"
    )
}

const GRAVITY: &str = "gravity = [\"0 m/s^2\", \"-9.81 m/s^2\"]\n";

/// A heavy disc at rest on a light one.
fn heavy_on_light(end: &str) -> String {
    let discs = [disc("light", 50.0, 50.0, "0.1 kg", 0.0), disc("heavy", 50.0, 150.0, "100 kg", 0.0)];
    let friction = "transition = \"10 um\"\n[contact.friction]\nmu_static = 0.5\n";
    GRAVITY.to_string() + &discs_above_plane("1 s", &discs, "1e4", &format!("{friction}{end}"))
}

/// Two discs that fall one above the other.
fn falling_discs(end: &str) -> String {
    let discs = [disc("big", 50.0, 550.0, "1 kg", 0.0), disc("small", 10.0, 611.0, "0.01 kg", 0.0)];
    let end = format!("[engine]\nlaw = \"rapier\"\nrestitution = 1.0\n{end}");
    GRAVITY.to_string() + &discs_above_plane("460 ms", &discs, "0", &end)
}

#[test]
fn discs_with_rapiers_law_are_compared_with_shorter_steps() {
    let result = run_check(Model::Engine, &scene(&falling_discs("")));
    assert_eq!(result.verdict, Verdict::Uncertain, "{result:?}");
    assert!(result.errors.path > 1e-6, "quarter steps give other contact times: {:e} m", result.errors.path);
    for step in ["60 us", "10 us"] {
        let fixed = falling_discs(&format!("stepping = \"fixed\"\nstep = \"{step}\"\n"));
        let result = run_check(Model::Engine, &scene(&fixed));
        assert!(result.errors.path > 0.0 && result.verdict != Verdict::Unknown, "{step}: {result:?}");
    }
}

#[test]
fn created_energy_makes_a_run_uncertain_and_is_a_warning() {
    let heavy = scene(&heavy_on_light("[engine]\nlaw = \"rapier\"\n"));
    let result = run_check(Model::Engine, &heavy);
    assert_eq!(result.verdict, Verdict::Uncertain);
    let reason = result.reason.expect("a reason");
    assert!(reason.contains("contacts created energy"), "{reason}");
    let (run, _) = run_into(&heavy, Model::Engine, Vec::new()).expect("a run");
    assert!(run.outcome.last.energy().dissipated_j < -1.0, "{:?}", run.outcome.last.energy());
    let [warning] = &run.warnings[..] else { panic!("{:?}", run.warnings) };
    assert!(warning.starts_with("contacts created energy"), "{warning}");
    // With the contact laws of the scene the energy balance holds.
    let (run, _) = run_into(&scene(&heavy_on_light("")), Model::Engine, Vec::new()).expect("a run");
    assert_eq!(run.warnings, [""; 0]);
}

/// Two different resolutions that agree to the last digit are a valid check: free flight and rest.
#[test]
fn free_flight_and_rest_are_accurate() {
    for velocity in [0.3, 0.0] {
        let text = disc_above_plane("100 ms", 20.0, 70.0, velocity);
        for (model, end) in
            [(Model::Analytic, ""), (Model::Engine, ""), (Model::Engine, "[engine]\nlaw = \"rapier\"\n")]
        {
            let result = run_check(model, &scene(&format!("{text}{end}")));
            assert_eq!((result.verdict, result.reason), (Verdict::Accurate, None), "{model:?} {velocity}");
            assert!(result.errors.path < 1e-13 && result.errors.energy < 1e-10);
        }
    }
}

/// At 10 nm/s the default preset has an error of 0.9 % in the restitution and of 8e-11 m in the path, a hundredth of
/// the displacement.
#[test]
fn error_limit_of_a_slow_rebound_follows_its_displacement() {
    let mut slow = scene(&disc_above_plane("1 s", 20.0, 20.000001, -1e-8));
    let check_with_verdict = |model: Model, scene: &Scene, verdict: Verdict| {
        let result = run_check(model, scene);
        assert_eq!(result.verdict, verdict, "{result:?}");
        let line = summary_line(Some(&RunCheckReport::new(&result, false)), None).expect("a line").to_string();
        (result, line)
    };
    let (result, line) = check_with_verdict(Model::Analytic, &slow, Verdict::Uncertain);
    assert!(result.errors.restitution[0].is_some_and(|error| error > 5e-3), "{:?}", result.errors);
    let motion = result.largest_displacement.expect("a small motion");
    let limit_error = result.max_path_error - MOTION_FRACTION * motion;
    assert!(motion > 5e-9 && motion < 1e-8 && limit_error.abs() < 1e-20, "{motion:e} {limit_error:e}");
    assert!(line.contains("a restitution differs by"), "{line}");
    let (_, line) = check_with_verdict(Model::Engine, &slow, Verdict::Accurate);
    assert!(line.contains("of the largest displacement, compared with"), "{line}");
    slow.apply_preset(phalanx::scene::Preset::Reference);
    let (result, _) = check_with_verdict(Model::Analytic, &slow, Verdict::Accurate);
    assert!(result.errors.restitution[0].is_some_and(|error| error < 1e-3), "{:?}", result.errors);
}

/// Copies of a scene with scaled lengths and velocities have scaled error limits, and a good run is sure in all of
/// them.
#[test]
fn error_limits_are_proportional_to_the_size_of_discs() {
    let path_limit = |scale: f64| {
        let text = disc_above_plane("20 ms", 50.0 * scale, 60.0 * scale, -2.0 * scale);
        let result = run_check(Model::Analytic, &scene(&text));
        assert_eq!(result.verdict, Verdict::Accurate, "{scale}: {result:?}");
        result.max_path_error
    };
    assert!((path_limit(1.0) - ANALYTIC_LIMITS.path).abs() < 1e-12, "{:e}", path_limit(1.0));
    for scale in [1e-2, 1e-1, 10.0, 100.0] {
        let relative = path_limit(scale) / (scale * ANALYTIC_LIMITS.path);
        assert!((relative - 1.0).abs() < 1e-9, "{scale}: {relative:e}");
    }
}

/// The error of an object in a gripper is relative to its radius. Fingers and grippers with ordinary motions have fixed
/// error limits.
#[test]
fn fingers_and_grippers_have_fixed_error_limits() {
    for (name, basis) in
        [("experiment-95", "1e-5 of a radian"), ("gripper/design-95", "1e-5 of a radian and of the object's radius")]
    {
        let scene = load(name);
        for (model, limits, basis) in [
            (Model::Analytic, ANALYTIC_LIMITS, basis.to_string()),
            (Model::Engine, ENGINE_LIMITS, basis.replace("1e-5", "1e-4")),
        ] {
            let result = run_check(model, &scene);
            assert_eq!((result.verdict, result.largest_displacement), (Verdict::Accurate, None), "{name} {model:?}");
            assert_eq!((result.max_path_error, result.max_path_error_basis), (limits.path, basis), "{name} {model:?}");
        }
    }
    for scale in [1e-3, 1.0, 20.0] {
        let units = units(&scene(&scaled_gripper(scale, "480 N*mm", "132.6 N*mm")));
        assert_eq!(units[..6], [1.0; 6]);
        assert!((units[6] / (0.02 * scale) - 1.0).abs() < 1e-12, "{units:?}");
    }
}

/// Formerly the analytic model took eleven discs that may all touch.
#[test]
fn a_run_of_twelve_discs_is_checked() {
    let heights: [f64; 12] = std::array::from_fn(|index| 25.0 * (index + 1) as f64);
    let discs = heights.map(|height| disc(&format!("at{height}"), 10.0, height, "0.1 kg", 0.0));
    let result = run_check(Model::Analytic, &scene(&discs_above_plane("1 ms", &discs, "1e3", "")));
    assert_eq!(result.verdict, Verdict::Accurate, "{result:?}");
}

#[test]
fn a_rejected_or_failed_run_has_no_verdict() {
    let mut rejected = load("experiment-95");
    rejected.hand.palm_motion = Some(PalmMotion::default());
    let failed = scene(&(load("experiment-95").source + "\n[integrator]\nmax_steps = 20\n"));
    for (scene, start, cause) in [
        (rejected, "the run ended at 0.000000 ms because: ", "the palm moves"),
        (failed, "the run ended at ", "the budget of 20 steps"),
    ] {
        let result = run_check(Model::Analytic, &scene);
        assert_eq!(result.verdict, Verdict::Unknown);
        let reason = result.reason.clone().expect("a reason");
        assert!(reason.starts_with(start) && reason.contains(cause), "{reason}");
        let report = RunCheckReport::new(&result, true);
        let printed = summary_line(Some(&report), Some(0)).expect("a line").to_string();
        assert!(printed.starts_with("NOT CHECKED: the run ended at "), "{printed}");
        let json = serde_json::to_value(&report).expect("JSON");
        assert_eq!(json["verdict"], "unknown");
        let numbers = ["error_rad", "energy_error", "sensitivity_rad"];
        assert!(numbers.iter().all(|key| json[key].is_null()), "{json}");
    }
}

/// The joints open by millimetres, and the object is "ejected" after three steps.
#[test]
fn a_diverging_engine_run_is_never_accurate() {
    for spring in ["132.6 N*mm", "20 N*mm", "1 N*m"] {
        let text = scaled_gripper(0.01, "0 N*mm", spring) + "[engine]\nmax_steps = 2000\n";
        let result = run_check(Model::Engine, &scene(&text));
        assert!(result.verdict != Verdict::Accurate && result.reason.is_some(), "{spring}: {result:?}");
    }
}
