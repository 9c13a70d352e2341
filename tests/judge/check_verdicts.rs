//! The check never says more than it compared: runs that were once called right to 0 m, and their siblings.

use phalanx::check::{BAR, Check, ENGINE_BAR, MOTION_PART, Verdict, check};
use phalanx::log::run_into;
use phalanx::report::check::{RunCheckReport, line};
use phalanx::scene::{Scene, parse_any};
use phalanx::trace::Model;

const BOTH: [Model; 2] = [Model::Analytic, Model::Engine];

fn scene(text: &str) -> Scene {
    parse_any(text, "scene.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn checked(model: Model, scene: &Scene) -> Check {
    check(model, scene, &|| true)
}

/// A disc above a plane.
fn ball(duration: &str, radius: &str, height: &str, velocity: &str) -> String {
    format!(
        "kind = \"bodies\"\nduration = \"{duration}\"\n[discs.ball]\nradius = \"{radius}\"\ncentre = [\"0 mm\", \"{height}\"]\n\
         velocity = [\"0 m/s\", \"{velocity}\"]\nmass = \"0.1 kg\"\n[half_plane]\n[contact]\nstiffness_si = 1e8\nexponent = 1.5\n\
         damping = \"0 N*s/m\"\n"
    )
}

/// A heavy disc at rest on a light one, and two that fall one above the other.
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
fn discs_under_rapiers_law_are_compared_with_shorter_steps() {
    let said = checked(Model::Engine, &scene(FALLING));
    assert_eq!(said.verdict, Verdict::Uncertain, "{said:?}");
    assert!(said.errors.path > 1e-6, "steps of a quarter meet at other times: {:e} m", said.errors.path);
    for step in ["60 us", "10 us"] {
        let fixed = format!("{FALLING}stepping = \"fixed\"\nstep = \"{step}\"\n");
        let said = checked(Model::Engine, &scene(&fixed));
        assert!(said.errors.path > 0.0 && said.verdict != Verdict::Unknown, "{step}: {said:?}");
    }
}

#[test]
fn energy_from_nothing_makes_a_run_uncertain_and_is_a_warning() {
    let heavy = scene(HEAVY_ON_LIGHT);
    let said = checked(Model::Engine, &heavy);
    assert_eq!(said.verdict, Verdict::Uncertain);
    let reason = said.reason.expect("a reason");
    assert!(reason.contains("contacts created energy from nothing"), "{reason}");
    let (run, _) = run_into(&heavy, Model::Engine, Vec::new()).expect("a run");
    assert!(run.outcome.last.energy.dissipated_j < -1.0, "{:?}", run.outcome.last.energy);
    let [warning] = &run.warnings[..] else { panic!("{:?}", run.warnings) };
    assert!(warning.starts_with("contacts created energy from nothing"), "{warning}");
    // The same under the scene's laws is sound.
    let text = HEAVY_ON_LIGHT.replace("[engine]\nlaw = \"rapier\"\n", "");
    let (run, _) = run_into(&scene(&text), Model::Engine, Vec::new()).expect("a run");
    assert_eq!(run.warnings, [""; 0]);
}

/// Two resolutions that differ and agree to the last digit are a check: of free flight, and of rest.
#[test]
fn flight_and_rest_are_sure() {
    for velocity in ["0.3 m/s", "0 m/s"] {
        let laws = ball("100 ms", "20 mm", "70 mm", velocity);
        for (model, text) in BOTH
            .map(|model| (model, laws.clone()))
            .into_iter()
            .chain([(Model::Engine, format!("{laws}[engine]\nlaw = \"rapier\"\n"))])
        {
            let said = checked(model, &scene(&text));
            assert_eq!((said.verdict, said.reason), (Verdict::Sure, None), "{model:?} {velocity}");
            assert!(said.errors.path < 1e-13 && said.errors.energy < 1e-10);
        }
    }
}

/// At 10 nm/s the restitution of the everyday preset is off by 0.9 %, and its path by 8e-11 m: a hundredth of its motion.
#[test]
fn a_slow_rebound_is_measured_by_its_own_motion() {
    let mut slow = scene(&ball("1 s", "20 mm", "20.000001 mm", "-1e-8 m/s"));
    let said = checked(Model::Analytic, &slow);
    assert_eq!(said.verdict, Verdict::Uncertain, "{said:?}");
    assert!(said.errors.restitution[0].is_some_and(|error| error > 5e-3), "{:?}", said.errors);
    let motion = said.motion.expect("a small motion");
    assert!(
        motion > 5e-9 && motion < 1e-8 && (said.bar - MOTION_PART * motion).abs() < 1e-20,
        "{motion:e} {:e}",
        said.bar
    );
    let text = line(Some(&RunCheckReport::new(&said, false)), None).expect("a line").to_string();
    assert!(text.contains("a restitution is off by"), "{text}");
    let said = checked(Model::Engine, &slow);
    assert_eq!(said.verdict, Verdict::Sure, "{said:?}");
    let text = line(Some(&RunCheckReport::new(&said, false)), None).expect("a line").to_string();
    assert!(text.contains("of the largest displacement, against"), "{text}");
    slow.integrate_by(phalanx::scene::Preset::Reference);
    let said = checked(Model::Analytic, &slow);
    assert_eq!(said.verdict, Verdict::Sure, "{said:?}");
    assert!(said.errors.restitution[0].is_some_and(|error| error < 1e-3), "{:?}", said.errors);
}

/// A scene and its copies of other sizes, moved faster in proportion, have bars in proportion, and a good run is sure in all.
#[test]
fn bars_follow_the_size_of_discs() {
    let bar = |of: f64| {
        let length = |mm: f64| format!("{} mm", mm * of);
        let text = ball("20 ms", &length(50.0), &length(60.0), &format!("{} m/s", -2.0 * of));
        let said = checked(Model::Analytic, &scene(&text));
        assert_eq!(said.verdict, Verdict::Sure, "{of}: {said:?}");
        said.bar
    };
    assert!((bar(1.0) - BAR).abs() < 1e-12, "{:e}", bar(1.0));
    for of in [1e-2, 1e-1, 10.0, 100.0] {
        assert!((bar(of) / (of * BAR) - 1.0).abs() < 1e-9, "{of}: {:e}", bar(of));
    }
}

/// The object of a gripper counts in its radii, whatever its size; fingers and grippers of ordinary motions have the bars they always had.
#[test]
fn fingers_and_grippers_keep_their_bars() {
    for (name, of) in
        [("experiment-95", "1e-5 of a radian"), ("gripper/design-95", "1e-5 of a radian and of the object's radius")]
    {
        let scene = scene(&std::fs::read_to_string(format!("scenes/{name}.toml")).expect("a scene"));
        for model in BOTH {
            let said = checked(model, &scene);
            let (bar, words) = match model {
                Model::Analytic => (BAR, of.to_string()),
                Model::Engine => (ENGINE_BAR, of.replace("1e-5", "1e-4")),
            };
            assert_eq!(
                (said.verdict, said.bar, said.bar_of, said.motion),
                (Verdict::Sure, bar, words, None),
                "{name} {model:?}"
            );
        }
    }
    let text = |of: f64| {
        let mm = |length: f64| format!("\"{} mm\"", length * of);
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
    for of in [1e-3, 1.0, 20.0] {
        let units = phalanx::check::units(&scene(&text(of)).system);
        assert_eq!(units[..6], [1.0; 6]);
        assert!((units[6] / (0.02 * of) - 1.0).abs() < 1e-12, "{units:?}");
    }
}

#[test]
fn a_run_that_was_refused_or_broke_off_has_no_verdict() {
    let mut four = String::from("kind = \"bodies\"\nduration = \"1 ms\"\n");
    for (index, x) in [0, 25, 50, 75].into_iter().enumerate() {
        four += &format!("[discs.d{index}]\nradius = \"10 mm\"\ncentre = [\"{x} mm\", \"0 mm\"]\nmass = \"0.1 kg\"\n");
    }
    four += "[contact]\nstiffness_si = 1e9\nexponent = 1.5\ndamping = \"1e3 N*s/m\"\n";
    let finger =
        std::fs::read_to_string("scenes/experiment-95.toml").expect("a scene") + "\n[integrator]\nmax_steps = 20\n";
    for (text, at, why) in [
        (four, "the run ended at 0.000000 ms because: 4 discs move", "takes up to 3"),
        (finger, "the run ended at ", "the budget of 20 steps"),
    ] {
        let said = checked(Model::Analytic, &scene(&text));
        assert_eq!(said.verdict, Verdict::Unknown);
        let reason = said.reason.clone().expect("a reason");
        assert!(reason.starts_with(at) && reason.contains(why), "{reason}");
        let report = RunCheckReport::new(&said, true);
        let printed = line(Some(&report), Some(0)).expect("a line").to_string();
        assert!(printed.starts_with("NOT CHECKED: the run ended at "), "{printed}");
        let json = serde_json::to_value(&report).expect("JSON");
        assert_eq!(json["verdict"], "unknown");
        assert!(
            json["error_rad"].is_null() && json["energy_error"].is_null() && json["sensitivity_rad"].is_null(),
            "{json}"
        );
    }
}

/// Joints that open by millimetres, and an "ejection" after three steps.
#[test]
fn an_engine_that_blows_up_is_never_sure() {
    for spring in ["132.6 N*mm", "20 N*mm", "1 N*m"] {
        let text = format!(
            "kind = \"gripper\"\nduration = \"1 ms\"\nhalf_width = \"0.025 mm\"\n[design]\nbase = \"0.155 mm\"\nl21_fraction = 1.0\n\
             phi22 = \"120 deg\"\narm_ratio = 0.5\nl11 = \"0.15 mm\"\n[object]\nradius = \"0.2 mm\"\n[motor]\ntorque = \"0 N*mm\"\n[spring]\n\
             torque = \"{spring}\"\n[engine]\nmax_steps = 2000\n"
        );
        let said = checked(Model::Engine, &scene(&text));
        assert!(said.verdict != Verdict::Sure && said.reason.is_some(), "{spring}: {said:?}");
    }
}
