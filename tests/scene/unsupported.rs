//! Systems from the API that no model supports are rejected by both models, not simulated as another system.

use std::fmt::Display;

use phalanx::grasp::finger::{GraspOverrides, grasp};
use phalanx::grasp::gripper::{GripperGraspRequest, PostureRequest, gripper_grasp};
use phalanx::parallel::Monitor;
use phalanx::scene::{ObjectMotion, PalmMotion, Scene, load_any};
use phalanx::study::size::{SizingOptions, size_finger};
use phalanx::thesis::stability::{Grid, stability};
use phalanx::thesis::step_size::step_size;
use phalanx::trace::{Model, RunError, run};

const FINGER: &str = "scenes/experiment-95.toml";
const GRIPPER: &str = "scenes/gripper/design-95.toml";
const SEESAW: &str = "scenes/gripper/seesaw.toml";
const DISCS: &str = "scenes/laws/impact.toml";

/// A shipped scene, a change of it, and a part of the message.
type Case<'a> = (&'a str, &'a dyn Fn(&mut Scene), &'a str);

fn load(path: &str) -> Scene {
    load_any(path).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn unsupported_systems_are_rejected_by_both_models() {
    let moving = |scene: &mut Scene| scene.hand.palm_motion = Some(PalmMotion::default());
    let cases: [Case<'_>; 5] = [
        (FINGER, &|scene| scene.hand.fingers.clear(), "no fingers"),
        (GRIPPER, &|scene| scene.hand.fingers.push(scene.finger().clone()), "more than two fingers"),
        (FINGER, &|scene| scene.hand.differential = load(SEESAW).hand.differential, "requires two fingers"),
        (FINGER, &moving, "the palm moves"),
        (
            GRIPPER,
            &|scene| {
                scene.hand.grasped_mut().motion = ObjectMotion::Fixed;
                moving(scene);
            },
            "the palm moves",
        ),
    ];
    for (path, change, message) in cases {
        let mut scene = load(path);
        assert_eq!(scene.hand.unsupported(), None, "{path}");
        change(&mut scene);
        for model in [Model::Analytic, Model::Engine] {
            let Err(RunError::Simulation { failure, .. }) = run(model, &scene, &mut ()) else {
                panic!("{path}, {message}: {} runs", model.name())
            };
            let reason = failure.reason.to_string();
            assert!(reason.contains(message) && reason.contains(": "), "{path}: {reason}");
            assert_eq!(failure.time_s, 0.0, "{path}");
        }
    }
}

/// A disc starts at its own angle in either model.
#[test]
fn discs_start_at_their_angle() {
    let mut scene = load(DISCS);
    scene.duration_s = 1e-4;
    scene.mechanism.as_mut().expect("discs").bodies[0].pose[2] = 0.25;
    for model in [Model::Analytic, Model::Engine] {
        let body = run(model, &scene, &mut ()).expect("a run").last.body(0);
        assert!((body.angle_rad - 0.25).abs() < 1e-6, "{}: {body:?}", model.name());
    }
}

/// Asserts that a function for one kind of scene rejects another kind.
#[track_caller]
fn assert_rejected<T>(result: Result<T, impl Display>, required: &str) {
    let error = result.map(drop).map_err(|error| error.to_string()).expect_err(required);
    let message = format!("a scene of kind \"{required}\" is required");
    assert!(error.contains("is a scene of kind") && error.contains(&message), "{error}");
}

#[test]
fn other_scene_kinds_are_rejected() {
    let [finger, gripper, discs] = [FINGER, GRIPPER, DISCS].map(load);
    let keep_running = &|| true;
    let grid = Grid { steps_s: vec![1e-5], stiffness_factors: vec![1.0], damping_factors: vec![1.0] };
    for other in [&gripper, &discs] {
        assert_rejected(grasp(other, &GraspOverrides::default()), "finger");
        assert_rejected(size_finger(other, SizingOptions::default()), "finger");
        assert_rejected(stability(other, &grid, 1e-3, &Monitor::silent(keep_running)), "finger");
    }
    let posture = PostureRequest::Geometric;
    let request = GripperGraspRequest { posture, mu_static: Vec::new(), motor_n_m: None, directions: 8 };
    for other in [&finger, &discs] {
        assert_rejected(gripper_grasp(other, &request, keep_running), "gripper");
    }
    for other in [&finger, &gripper] {
        assert_rejected(step_size(other, true, &Monitor::silent(keep_running)), "mechanism");
    }
}
