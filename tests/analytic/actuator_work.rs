//! Work of actuators in the criteria of a grasp, against closed forms and the work of the run.

use phalanx::criteria::{ActuatorCriteria, ObjectTracker};
use phalanx::scene::{Scene, load_any, parse_any};
use phalanx::trace::{Decimated, Model, OffGrid, run};

use crate::support::laws::BOTH_MODELS;
use crate::support::runs::assert_near;

/// A jaw of 2 kg on a slider, far from its object, with an actuator.
fn jaw(actuator: &str) -> Scene {
    let text = format!(
        r#"
        kind = "mechanism"
        duration = "100 ms"
        gravity = ["0 m/s^2", "0 m/s^2"]
        [bodies.jaw]
        mass = "2 kg"
        inertia = "1e6 g*mm^2"
        [bodies.jaw.outlines.pad]
        type = "disc"
        radius = "5 mm"
        [joints.slide]
        type = "prismatic"
        bodies = ["ground", "jaw"]
        at = ["0 mm", "0 mm"]
        start = "0 mm"
        [actuators.push]
        joint = "slide"
        {actuator}
        [bodies.object]
        mass = "1 kg"
        inertia = "1e6 g*mm^2"
        start = {{ at = ["0 m", "5 m"] }}
        [bodies.object.outlines.skin]
        type = "disc"
        radius = "10 mm"
        [laws.pad]
        stiffness = 1e6
        [[contacts]]
        between = ["jaw.pad", "object.skin"]
        law = "pad"
        "#
    );
    parse_any(&text, "jaw.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Figures of the actuators on the samples that criteria receive in a run with a log, and the work of the run, J.
fn run_decimated(scene: &Scene, model: Model) -> (Vec<ActuatorCriteria>, f64) {
    let hz = scene.log.numeric_hz;
    let tracker = OffGrid::new(hz, ObjectTracker::for_scene(scene).expect("a grasp"));
    let mut decimated = Decimated::new(hz, tracker);
    let outcome = run(model, scene, &mut decimated).expect("a completed run");
    decimated.end().and_then(|()| decimated.sink.end()).expect("accepted");
    (decimated.sink.sink.criteria().expect("a run").actuators, outcome.last.energy().motor_work_j)
}

/// A force of 10 N up to 40 ms, which falls to -30 N at 100 ms: the work is the kinetic energy.
#[test]
fn the_work_of_a_force_is_the_kinetic_energy() {
    let scene = jaw("times = [\"0 ms\", \"40 ms\", \"100 ms\"]\nforces = [\"10 N\", \"10 N\", \"-30 N\"]");
    let speed = (10.0 * 0.1 - 0.5 * 40.0 * 0.06) / 2.0;
    let expected = 0.5 * 2.0 * speed * speed;
    for (model, error_j) in [(Model::Analytic, 1e-12), (Model::Engine, 1e-7)] {
        let (found, work_j) = run_decimated(&scene, model);
        assert_near(found[0].energy_j, expected, error_j, format!("{model:?}"));
        assert_near(found[0].energy_j, work_j, 1e-15, format!("{model:?}: the run"));
        assert_eq!((found[0].saturated, found[0].command), (false, -30.0));
    }
}

/// A servo without damping is a spring with a moving end, whose target has kinks: the work is that of the run.
#[test]
fn the_work_of_a_servo_is_that_of_the_run() {
    let targets =
        "times = [\"0 ms\", \"10 ms\", \"30 ms\", \"50 ms\"]\ntargets = [\"0 mm\", \"0 mm\", \"20 mm\", \"-5 mm\"]";
    for gains in ["kp = \"2e4 N/m\"", "kp = \"2e4 N/m\"\nkd = \"600 N*s/m\"", "kp = \"1e3 N/m\"\nkd = \"2e3 N*s/m\""] {
        let scene = jaw(&format!("{targets}\n{gains}"));
        for model in BOTH_MODELS {
            let (found, work_j) = run_decimated(&scene, model);
            assert_near(found[0].energy_j, work_j, 1e-12, format!("{model:?}, {gains}"));
        }
    }
}

/// A servo with a rate holds its force between two instants: each moves the jaw on a parabola.
#[test]
fn the_work_of_a_servo_with_a_rate_is_a_sum_over_its_instants() {
    let (m, kp, kd, limit, rate_hz) = (2.0, 3e3, 60.0, 25.0, 400.0);
    let (mut x, mut v, mut expected, mut saturated) = (0.0f64, 0.0f64, 0.0, false);
    for _ in 0..40 {
        let command: f64 = kp * (0.01 - x) - kd * v;
        saturated |= command.abs() >= limit;
        let (force, period) = (command.clamp(-limit, limit), 1.0 / rate_hz);
        let moved = v * period + 0.5 * force / m * period * period;
        (x, v, expected) = (x + moved, v + force / m * period, expected + force * moved);
    }
    assert!(saturated);
    for (limit, is_saturated) in [("25 N", true), ("31 N", false)] {
        let scene = jaw(&format!(
            "targets = [\"10 mm\"]\ntimes = [\"0 ms\"]\nkp = \"3e3 N/m\"\nkd = \"60 N*s/m\"\nrate = \"400 Hz\"\nlimit = \"{limit}\""
        ));
        for model in BOTH_MODELS {
            let (found, work_j) = run_decimated(&scene, model);
            assert_near(found[0].energy_j, work_j, 1e-12, format!("{model:?}, {limit}"));
            if is_saturated {
                assert_near(found[0].energy_j, expected, 1e-7, format!("{model:?}"));
            }
            assert_eq!(found[0].saturated, is_saturated, "{model:?}, {limit}");
        }
    }
}

/// Two jaws that do not know of each other, with kinks of their targets at different times: the work of each is that of a run
/// of its own.
#[test]
fn the_run_is_divided_among_its_actuators() {
    let first = "times = [\"0 ms\", \"10 ms\", \"30 ms\"]\ntargets = [\"0 mm\", \"0 mm\", \"20 mm\"]\nkp = \"1e5 N/m\"\nkd = \"1e3 N*s/m\"";
    let second = "times = [\"0 ms\", \"20 ms\", \"50 ms\"]\ntargets = [\"0 mm\", \"5 mm\", \"-9 mm\"]\nkp = \"4e4 N/m\"\nkd = \"300 N*s/m\"";
    let alone = [first, second].map(|actuator| run_decimated(&jaw(actuator), Model::Analytic).0[0].energy_j);
    let other = "[bodies.other]\nmass = \"2 kg\"\ninertia = \"1e6 g*mm^2\"\n[joints.other]\ntype = \"prismatic\"\n\
                 bodies = [\"ground\", \"other\"]\nat = [\"0 mm\", \"0 mm\"]\nstart = \"0 mm\"\n[actuators.second]\njoint = \"other\"\n";
    let both = jaw(&format!("{first}\n{other}{second}"));
    let (found, work_j) = run_decimated(&both, Model::Analytic);
    assert_near(found[0].energy_j + found[1].energy_j, work_j, 1e-12, "sum");
    for (index, (found, alone)) in found.iter().zip(alone).enumerate() {
        // Each accelerates and brakes its jaw, with up to 1 J and 0.2 J.
        assert_near(found.energy_j, alone, 1e-6, index.to_string());
    }
}

/// Several actuators: their works add up to that of the run, also where a servo saturates and cables pull.
#[test]
fn works_of_all_actuators_add_up_to_that_of_the_run() {
    for name in ["2f85-lift", "2f85-pinch", "franka-lift", "t42-grasp"] {
        let scene = load_any(format!("scenes/real/{name}.toml")).unwrap_or_else(|error| panic!("{error}"));
        let (found, work_j) = run_decimated(&scene, Model::Analytic);
        let total: f64 = found.iter().map(|actuator| actuator.energy_j).sum();
        assert_near(total, work_j, 1e-12, name);
    }
}
