//! Statics of mechanisms: against closed forms, and against the statics of the gripper that the mechanism is.

use crate::support::cli::{assert_contains, assert_rejected, succeed};
use phalanx::grasp::gripper::{GripperGraspRequest, PostureRequest, gripper_grasp};
use phalanx::grasp::mechanism::{MechanismGrasp, MechanismGraspRequest, mechanism_grasp};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{self, Hand, Scene};
use phalanx::statics::{AccelerationLimit, Balance, ContactMotion, MechanismBalance, MechanismLimit};

fn grasp(scene: &Scene, request: &MechanismGraspRequest) -> MechanismGrasp {
    mechanism_grasp(scene, request, &|| true).unwrap_or_else(|error| panic!("{error}"))
}

fn request(directions: usize) -> MechanismGraspRequest {
    MechanismGraspRequest { directions, ..MechanismGraspRequest::default() }
}

/// Largest acceleration; infinite without a limit, and negative if not even rest is balanced.
fn of_mechanism(balance: &MechanismBalance) -> f64 {
    match balance.largest {
        MechanismLimit::Infeasible => -1.0,
        MechanismLimit::Unlimited => f64::INFINITY,
        MechanismLimit::Limited { acceleration_m_s2, .. } => acceleration_m_s2,
    }
}

fn of_gripper(balance: &Balance) -> f64 {
    match balance.largest {
        AccelerationLimit::Infeasible => -1.0,
        AccelerationLimit::Unlimited => f64::INFINITY,
        AccelerationLimit::Limited(ref limit) => limit.acceleration_m_s2,
    }
}

/// A box of 0.2 kg between two jaws on sliders, each pushed with 10 N, μ_s = 0.5, without gravity.
const JAWS: &str = r#"
kind = "mechanism"
duration = "30 ms"
[mirror]
from = "right"
to = "left"
[bodies.right]
mass = "100 g"
inertia = "1e-5 kg*m^2"
guess = { at = ["25 mm", "0 mm"] }
[bodies.right.outlines.pad]
type = "box"
size = ["10 mm", "20 mm"]
rounding = "1 mm"
[joints.right]
type = "prismatic"
bodies = ["ground", "right"]
points = [["25 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "0.2 mm"
damping = "50 N*s/m"
[actuators.right]
joint = "right"
force = "-10 N"
[bodies.box]
mass = "200 g"
inertia = "5e-5 kg*m^2"
[bodies.box.start]
[bodies.box.outlines.skin]
type = "box"
size = ["40 mm", "40 mm"]
rounding = "1 mm"
[laws.pad]
stiffness = 1e6
damping = "3 s/m"
friction = { mu_static = 0.5 }
[[contacts]]
between = ["right.pad", "box.skin"]
law = "pad"
"#;

#[test]
fn a_box_between_jaws_is_held_by_their_friction() {
    let scene = scene::parse_any(JAWS, "jaws.toml").unwrap_or_else(|error| panic!("{error}"));
    let found = grasp(&scene, &request(4));
    assert_eq!((found.object.as_str(), found.contacts.len()), ("box", 4), "{:?}", found.contacts);
    let case = &found.friction_cases[0];
    assert!(case.force_closure.closed && found.closure.as_ref().is_ok_and(|of| !of.closure.closed));
    let [blocked, at_effort] = case.polar.each_ref().map(|polar| polar.iter().map(of_mechanism).collect::<Vec<_>>());
    // Blocked jaws can push with any force. Jaws at 10 N exert friction of at most 2 · 0.5 · 10 N along y; along x they
    // must themselves be at rest, and no force is left for an acceleration.
    assert!(blocked.iter().all(|limit| limit.is_infinite()), "{blocked:?}");
    let along_y = 2.0 * 0.5 * 10.0 / 0.2;
    assert!((at_effort[1] - along_y).abs() < 1e-6 && (at_effort[3] - along_y).abs() < 1e-6, "{at_effort:?}");
    assert!(at_effort[0].abs() < 1e-6 && at_effort[2].abs() < 1e-6, "{at_effort:?}");
    let MechanismLimit::Limited { contacts, motion, gap, .. } = &case.polar[1][1].largest else { panic!("a limit") };
    assert!(contacts.iter().all(|load| load.2 == ContactMotion::Slips) && *gap < 1e-9, "{contacts:?}");
    // The box stays behind.
    let object = found.bodies.iter().position(|name| name == "box").expect("the box");
    assert!((motion[object][1] + 1e-3).abs() < 1e-9 && motion[object][0].abs() < 1e-9, "{motion:?}");
    // Without friction the box slides out along y, which is also the free motion.
    let free = grasp(&scene, &MechanismGraspRequest { mu_static: vec![0.0], ..request(4) });
    assert!(!free.friction_cases[0].force_closure.closed && of_mechanism(&free.friction_cases[0].polar[0][1]) < 1e-9);
    let motion = free.closure.expect("a decision").motion.expect("a free motion");
    assert!(motion[object][1].abs() > 0.9e-3, "{motion:?}");
}

/// Four sides of a box that touch all of its sides: the form closure of a frame.
#[test]
fn a_box_in_a_frame_is_form_closed() {
    let wall = |name: &str, center: [i32; 2], size: [i32; 2]| {
        format!(
            "[ground.outlines.{name}]\ntype = \"box\"\ncenter = [\"{} mm\", \"{} mm\"]\nsize = [\"{} mm\", \"{} mm\"]\n\
             rounding = \"1 mm\"\n",
            center[0], center[1], size[0], size[1]
        )
    };
    let body = JAWS.find("[bodies.box]").expect("a box");
    let frame = |walls: &[(&str, [i32; 2], [i32; 2])]| {
        let walls: String = walls.iter().map(|(name, center, size)| wall(name, *center, *size)).collect();
        let text = format!(
            "kind = \"mechanism\"\nduration = \"0.1 ms\"\n{walls}{}",
            JAWS[body..].replace("\"right.pad\"", "\"ground\"")
        );
        let scene = scene::parse_any(&text, "frame.toml").unwrap_or_else(|error| panic!("{error}"));
        grasp(&scene, &MechanismGraspRequest { within_m: Some(1e-6), ..request(4) })
    };
    let (right, left) = (("right", [25, 0], [10, 20]), ("left", [-25, 0], [10, 20]));
    let (above, below) = (("above", [0, 25], [20, 10]), ("below", [0, -25], [20, 10]));
    let closed = frame(&[right, left, above, below]);
    let closure = closed.closure.expect("a decision");
    assert!(closure.closure.closed && closure.motion.is_none() && closure.coordinates == 3, "{closure:?}");
    assert!(of_mechanism(&closed.friction_cases[0].polar[0][2]).is_infinite());
    // Without a wall the box leaves through the gap.
    let open = frame(&[right, left, below]);
    let motion = open.closure.expect("a decision").motion.expect("a free motion");
    assert!(motion[0][1] > 0.9e-3, "{motion:?}");
}

/// The statics of grippers, from their own equations, and of the mechanisms that they are.
#[test]
fn a_gripper_and_its_mechanism_withstand_the_same_accelerations() {
    for name in ["design-95", "seesaw", "different"] {
        let mut scene = scene::load_any(format!("scenes/gripper/{name}.toml")).expect("a scene");
        // The statics of a gripper leave the table out.
        scene.hand.table = None;
        let mechanism = scene.mechanism().expect("a closed loop").into_owned();
        let written =
            Scene { kind: SceneKind::Mechanism, mechanism: Some(mechanism), hand: Hand::EMPTY, ..scene.clone() };
        let posture = PostureRequest::Run { at_s: Some(scene.duration_s), within_m: None };
        let of_scene = GripperGraspRequest { posture, mu_static: vec![0.3], motor_n_m: None, directions: 16 };
        let expected = gripper_grasp(&scene, &of_scene, &|| true).unwrap_or_else(|error| panic!("{name}: {error}"));
        let found = grasp(&written, &MechanismGraspRequest { mu_static: vec![0.3], ..request(16) });
        assert_eq!(found.contacts.len(), expected.contacts.len(), "{name}");
        let (found, expected) = (&found.friction_cases[0], &expected.friction_cases[0]);
        let (a, b) = (found.force_closure, expected.force_closure);
        assert!((a.q1_l1 - b.q1_l1).abs() < 1e-4 && (a.q1_linf - b.q1_linf).abs() < 1e-4, "{name}: {a:?} {b:?}");
        for (mode, polar) in found.polar.iter().enumerate() {
            for (balance, other) in polar.iter().zip(&expected.polar[mode]) {
                let (a, b) = (of_mechanism(balance), of_gripper(other));
                assert!(
                    a == b || (a - b).abs() < 1e-3 * b.abs().max(1.0),
                    "{name} {mode} {:?}: {a} {b}",
                    other.direction
                );
            }
        }
    }
}

#[test]
fn the_command_reports_the_grasp_of_a_mechanism() {
    let text = succeed(&["statics", "scenes/real/2f85-pinch.toml", "--at", "200 ms", "--mu-static", "0.2,0.6"]);
    let parts = [
        "2f85-pinch: the grasp of `object` at 200 ms of the run",
        "form closure without friction, actuators blocked: not closed",
        "force closure with μ_s 0.6 in all contacts: closed",
    ];
    assert_contains(&text, &parts);
    let rejected: [(&[&str], &[&str]); 4] = [
        (&["--object", "cube"], &["no body `cube`", "--object"]),
        (&["--at", "1 s"], &["before --at", "longer duration"]),
        (&["--motor", "1 N*m"], &["--motor", "--set"]),
        (&["--at", "1 ms"], &["no contact at 1.000000 ms", "--within"]),
    ];
    for (flags, expected) in rejected {
        let arguments: Vec<&str> = ["statics", "scenes/real/2f85-pinch.toml"].iter().chain(flags).copied().collect();
        assert_rejected(&arguments, expected);
    }
}
