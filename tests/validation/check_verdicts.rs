//! The check reports no more than it compared. Regression tests of runs whose error was once reported as 0 m, and of
//! similar runs.

use phalanx::check::{ANALYTIC_LIMITS, Check, ENGINE_LIMITS, MOTION_FRACTION, Verdict, check};
use phalanx::log::run_into;
use phalanx::report::check::{RunCheckReport, summary_line};
use phalanx::scene::{Scene, parse_any};
use phalanx::trace::Model;

const BOTH_MODELS: [Model; 2] = [Model::Analytic, Model::Engine];

fn scene(text: &str) -> Scene {
    parse_any(text, "scene.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn run_check(model: Model, scene: &Scene) -> Check {
    check(model, scene, &|| true)
}

/// Returns the scene text of a disc above a plane.
fn disc_above_plane(duration: &str, radius: &str, height: &str, velocity: &str) -> String {
    format!(
        "kind = \"bodies\"\nduration = \"{duration}\"\n[discs.ball]\nradius = \"{radius}\"\ncentre = [\"0 mm\", \"{height}\"]\n\
         velocity = [\"0 m/s\", \"{velocity}\"]\nmass = \"0.1 kg\"\n[half_plane]\n[contact]\nstiffness_si = 1e8\nexponent = 1.5\n\
         damping = \"0 N*s/m\"\n"
    )
}

/// A heavy disc at rest on a light one.
const HEAVY_ON_LIGHT: &str = r#"
kind = "bodies"
duration = "1 s"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[discs.light]
radius = "50 mm"
centre = ["0 mm", "50 mm"]
mass = "0.1 kg"
[discs.heavy]
radius = "50 mm"
centre = ["0 mm", "150 mm"]
mass = "100 kg"
[half_plane]
[contact]
stiffness_si = 1e8
exponent = 1.5
damping = "1e4 N*s/m"
transition = "10 um"
[contact.friction]
mu_static = 0.5
[engine]
law = "rapier"
"#;
/// Two discs that fall one above the other.
const FALLING: &str = r#"
kind = "bodies"
duration = "460 ms"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[discs.big]
radius = "50 mm"
centre = ["0 mm", "550 mm"]
mass = "1 kg"
[discs.small]
radius = "10 mm"
centre = ["0 mm", "611 mm"]
mass = "0.01 kg"
[half_plane]
[contact]
stiffness_si = 1e8
exponent = 1.5
damping = "0 N*s/m"
[engine]
law = "rapier"
restitution = 1.0
"#;

#[test]
fn discs_with_rapiers_law_are_compared_with_shorter_steps() {
    let result = run_check(Model::Engine, &scene(FALLING));
    assert_eq!(result.verdict, Verdict::Uncertain, "{result:?}");
    assert!(result.errors.path > 1e-6, "quarter steps give other contact times: {:e} m", result.errors.path);
    for step in ["60 us", "10 us"] {
        let fixed = format!("{FALLING}stepping = \"fixed\"\nstep = \"{step}\"\n");
        let result = run_check(Model::Engine, &scene(&fixed));
        assert!(result.errors.path > 0.0 && result.verdict != Verdict::Unknown, "{step}: {result:?}");
    }
}

#[test]
fn created_energy_makes_a_run_uncertain_and_is_a_warning() {
    let heavy = scene(HEAVY_ON_LIGHT);
    let result = run_check(Model::Engine, &heavy);
    assert_eq!(result.verdict, Verdict::Uncertain);
    let reason = result.reason.expect("a reason");
    assert!(reason.contains("contacts created energy"), "{reason}");
    let (run, _) = run_into(&heavy, Model::Engine, Vec::new()).expect("a run");
    assert!(run.outcome.last.energy().dissipated_j < -1.0, "{:?}", run.outcome.last.energy());
    let [warning] = &run.warnings[..] else { panic!("{:?}", run.warnings) };
    assert!(warning.starts_with("contacts created energy"), "{warning}");
    // With the contact laws of the scene the energy balance holds.
    let text = HEAVY_ON_LIGHT.replace("[engine]\nlaw = \"rapier\"\n", "");
    let (run, _) = run_into(&scene(&text), Model::Engine, Vec::new()).expect("a run");
    assert_eq!(run.warnings, [""; 0]);
}

/// Two different resolutions that agree to the last digit are a valid check: free flight and rest.
#[test]
fn free_flight_and_rest_are_accurate() {
    for velocity in ["0.3 m/s", "0 m/s"] {
        let scene_law = disc_above_plane("100 ms", "20 mm", "70 mm", velocity);
        for (model, text) in BOTH_MODELS
            .map(|model| (model, scene_law.clone()))
            .into_iter()
            .chain([(Model::Engine, format!("{scene_law}[engine]\nlaw = \"rapier\"\n"))])
        {
            let result = run_check(model, &scene(&text));
            assert_eq!((result.verdict, result.reason), (Verdict::Accurate, None), "{model:?} {velocity}");
            assert!(result.errors.path < 1e-13 && result.errors.energy < 1e-10);
        }
    }
}

/// At 10 nm/s the default preset has an error of 0.9 % in the restitution and of 8e-11 m in the path, a hundredth of
/// the displacement.
#[test]
fn error_limit_of_a_slow_rebound_follows_its_displacement() {
    let mut slow = scene(&disc_above_plane("1 s", "20 mm", "20.000001 mm", "-1e-8 m/s"));
    let result = run_check(Model::Analytic, &slow);
    assert_eq!(result.verdict, Verdict::Uncertain, "{result:?}");
    assert!(result.errors.restitution[0].is_some_and(|error| error > 5e-3), "{:?}", result.errors);
    let motion = result.largest_displacement.expect("a small motion");
    assert!(
        motion > 5e-9 && motion < 1e-8 && (result.max_path_error - MOTION_FRACTION * motion).abs() < 1e-20,
        "{motion:e} {:e}",
        result.max_path_error
    );
    let text = summary_line(Some(&RunCheckReport::new(&result, false)), None).expect("a line").to_string();
    assert!(text.contains("a restitution differs by"), "{text}");
    let result = run_check(Model::Engine, &slow);
    assert_eq!(result.verdict, Verdict::Accurate, "{result:?}");
    let text = summary_line(Some(&RunCheckReport::new(&result, false)), None).expect("a line").to_string();
    assert!(text.contains("of the largest displacement, compared with"), "{text}");
    slow.apply_preset(phalanx::scene::Preset::Reference);
    let result = run_check(Model::Analytic, &slow);
    assert_eq!(result.verdict, Verdict::Accurate, "{result:?}");
    assert!(result.errors.restitution[0].is_some_and(|error| error < 1e-3), "{:?}", result.errors);
}

/// Copies of a scene with scaled lengths and velocities have scaled error limits, and a good run is sure in all of
/// them.
#[test]
fn error_limits_are_proportional_to_the_size_of_discs() {
    let path_limit = |scale: f64| {
        let length = |mm: f64| format!("{} mm", mm * scale);
        let text = disc_above_plane("20 ms", &length(50.0), &length(60.0), &format!("{} m/s", -2.0 * scale));
        let result = run_check(Model::Analytic, &scene(&text));
        assert_eq!(result.verdict, Verdict::Accurate, "{scale}: {result:?}");
        result.max_path_error
    };
    assert!((path_limit(1.0) - ANALYTIC_LIMITS.path).abs() < 1e-12, "{:e}", path_limit(1.0));
    for scale in [1e-2, 1e-1, 10.0, 100.0] {
        assert!(
            (path_limit(scale) / (scale * ANALYTIC_LIMITS.path) - 1.0).abs() < 1e-9,
            "{scale}: {:e}",
            path_limit(scale)
        );
    }
}

/// The error of an object in a gripper is relative to its radius. Fingers and grippers with ordinary motions have fixed
/// error limits.
#[test]
fn fingers_and_grippers_have_fixed_error_limits() {
    for (name, basis) in
        [("experiment-95", "1e-5 of a radian"), ("gripper/design-95", "1e-5 of a radian and of the object's radius")]
    {
        let scene = scene(&std::fs::read_to_string(format!("scenes/{name}.toml")).expect("a scene"));
        for model in BOTH_MODELS {
            let result = run_check(model, &scene);
            let (path_limit, expected_basis) = match model {
                Model::Analytic => (ANALYTIC_LIMITS.path, basis.to_string()),
                Model::Engine => (ENGINE_LIMITS.path, basis.replace("1e-5", "1e-4")),
            };
            assert_eq!(
                (result.verdict, result.max_path_error, result.max_path_error_basis, result.largest_displacement),
                (Verdict::Accurate, path_limit, expected_basis, None),
                "{name} {model:?}"
            );
        }
    }
    let text = |scale: f64| {
        let mm = |length: f64| format!("\"{} mm\"", length * scale);
        format!(
            "kind = \"gripper\"\nduration = \"1 ms\"\nhalf_width = {}\n[design]\nbase = {}\nl21_fraction = 1.0\nphi22 = \"120 deg\"\n\
             arm_ratio = 0.5\nl11 = {}\n[object]\nradius = {}\n[motor]\ntorque = \"480 N*mm\"\n[spring]\ntorque = \"132.6 N*mm\"\n\
             [contact.friction]\nmu_static = 0.8\n",
            mm(2.5),
            mm(15.5),
            mm(15.0),
            mm(20.0)
        )
    };
    for scale in [1e-3, 1.0, 20.0] {
        let units = phalanx::check::units(&scene(&text(scale)).system);
        assert_eq!(units[..6], [1.0; 6]);
        assert!((units[6] / (0.02 * scale) - 1.0).abs() < 1e-12, "{units:?}");
    }
}

#[test]
fn a_rejected_or_failed_run_has_no_verdict() {
    let mut four_discs = String::from("kind = \"bodies\"\nduration = \"1 ms\"\n");
    for (index, x) in [0, 25, 50, 75].into_iter().enumerate() {
        four_discs +=
            &format!("[discs.d{index}]\nradius = \"10 mm\"\ncentre = [\"{x} mm\", \"0 mm\"]\nmass = \"0.1 kg\"\n");
    }
    four_discs += "[contact]\nstiffness_si = 1e9\nexponent = 1.5\ndamping = \"1e3 N*s/m\"\n";
    let finger =
        std::fs::read_to_string("scenes/experiment-95.toml").expect("a scene") + "\n[integrator]\nmax_steps = 20\n";
    for (text, start, cause) in [
        (four_discs, "the run ended at 0.000000 ms because: 4 discs move", "takes up to 3"),
        (finger, "the run ended at ", "the budget of 20 steps"),
    ] {
        let result = run_check(Model::Analytic, &scene(&text));
        assert_eq!(result.verdict, Verdict::Unknown);
        let reason = result.reason.clone().expect("a reason");
        assert!(reason.starts_with(start) && reason.contains(cause), "{reason}");
        let report = RunCheckReport::new(&result, true);
        let printed = summary_line(Some(&report), Some(0)).expect("a line").to_string();
        assert!(printed.starts_with("NOT CHECKED: the run ended at "), "{printed}");
        let json = serde_json::to_value(&report).expect("JSON");
        assert_eq!(json["verdict"], "unknown");
        assert!(
            json["error_rad"].is_null() && json["energy_error"].is_null() && json["sensitivity_rad"].is_null(),
            "{json}"
        );
    }
}

/// The joints open by millimetres, and the object is "ejected" after three steps.
#[test]
fn a_diverging_engine_run_is_never_accurate() {
    for spring in ["132.6 N*mm", "20 N*mm", "1 N*m"] {
        let text = format!(
            "kind = \"gripper\"\nduration = \"1 ms\"\nhalf_width = \"0.025 mm\"\n[design]\nbase = \"0.155 mm\"\nl21_fraction = 1.0\n\
             phi22 = \"120 deg\"\narm_ratio = 0.5\nl11 = \"0.15 mm\"\n[object]\nradius = \"0.2 mm\"\n[motor]\ntorque = \"0 N*mm\"\n[spring]\n\
             torque = \"{spring}\"\n[engine]\nmax_steps = 2000\n"
        );
        let result = run_check(Model::Engine, &scene(&text));
        assert!(result.verdict != Verdict::Accurate && result.reason.is_some(), "{spring}: {result:?}");
    }
}
