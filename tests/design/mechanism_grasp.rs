//! Statics of mechanisms: against closed forms, and against the grasp of the gripper that the mechanism is.

use crate::support::cli::{assert_contains, assert_rejected, succeed};
use phalanx::grasp::gripper::{GripperGraspRequest, PostureRequest, gripper_grasp};
use phalanx::grasp::mechanism::{ActuatorRole, MechanismGrasp, MechanismGraspRequest, mechanism_grasp};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{self, Hand, Scene};
use phalanx::statics::{ContactMotion, MechanismBalance, MechanismLimit};

fn grasp(scene: &Scene, request: &MechanismGraspRequest) -> MechanismGrasp {
    mechanism_grasp(scene, request, &|| true).unwrap_or_else(|error| panic!("{error}"))
}

fn request(directions: usize) -> MechanismGraspRequest {
    MechanismGraspRequest { directions, ..MechanismGraspRequest::default() }
}

/// Largest acceleration; infinite without a limit, and negative if not even rest is balanced.
fn of_mechanism(balance: &MechanismBalance) -> f64 {
    match balance.largest {
        MechanismLimit::Infeasible { .. } => -1.0,
        MechanismLimit::Unlimited => f64::INFINITY,
        MechanismLimit::Limited { acceleration_m_s2, .. } => acceleration_m_s2,
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

/// The statics of grippers, with the nearest points of their posture, and of the mechanisms that they are, with the contacts of
/// a run.
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
                let (a, b) = (of_mechanism(balance), of_mechanism(other));
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
    let rejected: [(&[&str], &[&str]); 6] = [
        (&["--object", "cube"], &["no body `cube`", "--object"]),
        (&["--base", "cube"], &["no body `cube`", "`ground`", "--base"]),
        (&["--base", "right_follower"], &["`right_follower`", "is not the base", "--base"]),
        (&["--at", "1 s"], &["before --at", "longer duration"]),
        (&["--motor", "1 N*m"], &["--motor", "--set"]),
        (&["--at", "1 ms"], &["no contact at 1.000000 ms", "--within"]),
    ];
    for (flags, expected) in rejected {
        let arguments: Vec<&str> = ["statics", "scenes/real/2f85-pinch.toml"].iter().chain(flags).copied().collect();
        assert_rejected(&arguments, expected);
    }
}

fn parsed(text: &str) -> Scene {
    scene::parse_any(text, "scene.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Four fingers on a disc. The programme once found that they balance *any* acceleration.
pub fn four_fingers() -> Scene {
    parsed(include_str!("four_fingers.toml"))
}

fn limits(found: &MechanismGrasp, mode: usize) -> Vec<f64> {
    found.friction_cases[0].polar[mode].iter().map(of_mechanism).collect()
}

/// Two coupled jaws hold a ball of 100 g with 20 N each, μ_s = 0.5. `more` is beside them.
fn coupled_jaws(more: &str) -> String {
    let jaw = |name: &str, start: &str| {
        format!(
            "[bodies.{name}]\nmass = \"80 g\"\ninertia = \"5000 g*mm^2\"\n[bodies.{name}.outlines.pad]\ntype = \"box\"\n\
             size = [\"10 mm\", \"20 mm\"]\nrounding = \"1 mm\"\n[joints.{name}]\ntype = \"prismatic\"\n\
             bodies = [\"ground\", \"{name}\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n{start}"
        )
    };
    let (left, right) = (jaw("left", "start = \"-21 mm\"\n"), jaw("right", ""));
    format!(
        "kind = \"mechanism\"\nduration = \"60 ms\"\n[bodies.ball]\nmass = \"100 g\"\ninertia = \"11250 g*mm^2\"\n\
         [bodies.ball.outlines.skin]\ntype = \"disc\"\nradius = \"15 mm\"\n{left}{right}[couplings.mimic]\n\
         joints = [\"left\", \"right\"]\nfactors = [1, 1]\n[actuators.grip]\njoint = \"left\"\nforce = \"40 N\"\n\
         [laws.pad]\nstiffness = 1e7\ndamping = \"3 s/m\"\n\
         friction = {{ mu_static = 0.5, law = \"bristle\", bristle_damping = \"100 N*s/m\" }}\n\
         [[contacts]]\nbetween = [\"*.pad\", \"ball\"]\nlaw = \"pad\"\n{more}"
    )
}

const SPARE: &str = r#"
[bodies.spare]
mass = "100 g"
inertia = "11250 g*mm^2"
start = { at = ["0 mm", "60 mm"] }
[bodies.spare.outlines.skin]
type = "disc"
radius = "15 mm"
[[contacts]]
between = ["*.pad", "spare"]
law = "pad"
"#;

/// A pendulum that cannot touch the ball.
const PENDULUM: &str = r#"
[bodies.pendulum]
mass = "1 kg"
inertia = "1e-4 kg*m^2"
com = ["30 mm", "0 mm"]
[joints.pendulum]
bodies = ["ground", "pendulum"]
points = [["200 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "0 deg"
"#;

#[test]
fn bodies_that_nothing_connects_with_the_grasp_have_no_effect() {
    let request = MechanismGraspRequest { object: Some("ball".to_string()), ..request(24) };
    for (more, left_out) in [("", vec![]), (SPARE, vec!["spare"]), (PENDULUM, vec!["pendulum"])] {
        let found = grasp(&parsed(&coupled_jaws(more)), &request);
        assert_eq!(found.left_out, left_out);
        assert!(limits(&found, 0).iter().all(|limit| limit.is_infinite()), "{:?}", limits(&found, 0));
        // The sum of both normal forces is 40 N. Along x they differ by m a; friction balances the rest.
        let at_effort = limits(&found, 1);
        let worst = at_effort.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((worst - 20.0 / (0.1 * 1.116)).abs() < 1e-2 * worst, "{worst}");
        for (index, limit) in at_effort.into_iter().enumerate() {
            let (y, x) = (15.0 * index as f64).to_radians().sin_cos();
            // Sticking: friction is shared by both, μ · 40 N, without a moment; each contact then has one half.
            let along_x = if x.abs() > 1e-9 { 40.0 / (0.1 * x.abs()) } else { f64::INFINITY };
            let along_y = 0.5 * 40.0 / (0.1 * (y.abs() + 0.5 * x.abs()));
            assert!((limit - along_x.min(along_y)).abs() < 1e-6 * limit, "{index}: {limit} {along_x} {along_y}");
        }
        let case = &found.friction_cases[0].polar[1][6];
        let MechanismLimit::Limited { yielding, .. } = &case.largest else { panic!("{case:?}") };
        assert_eq!(yielding, &[0], "the force of the grip decides");
    }
}

#[test]
fn any_acceleration_is_certified() {
    let found = grasp(&four_fingers(), &MechanismGraspRequest { object: Some("obj".to_string()), ..request(12) });
    // Two blocked fingers hold the disc at any acceleration. The passive link of another finger leaves it in a half plane
    // of directions, and is pressed against it in the other.
    let (finite, any): (Vec<f64>, Vec<f64>) = limits(&found, 0).into_iter().partition(|limit| limit.is_finite());
    let [least, largest] =
        [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| finite.iter().copied().reduce(of).expect("limits"));
    assert!((least - 53.7).abs() < 0.05 && (largest - 545.0).abs() < 0.5, "{finite:?}");
    assert_eq!((finite.len(), any.len()), (6, 6));
    let names = found.actuators.iter().map(|actuator| (actuator.name.as_str(), actuator.role));
    assert!(names.clone().all(|(_, role)| role == ActuatorRole::Hand) && names.count() == 4);
    // Their efforts, in contrast, do not balance each other in any direction.
    assert!(limits(&found, 1).iter().all(|limit| *limit < 0.0));
    let MechanismLimit::Infeasible { motion, .. } = &found.friction_cases[0].polar[1][0].largest else {
        panic!("rest")
    };
    assert!(motion.iter().any(|rates| *rates != [0.0; 3]));
}

/// An arm that a cord pulls against a ball at a wall.
pub const CORD: &str = r#"
kind = "mechanism"
duration = "1 ms"
[bodies.obj]
mass = "50 g"
inertia = "1e4 g*mm^2"
start = { at = ["0 mm", "0 mm"] }
[bodies.obj.outlines.skin]
type = "disc"
radius = "20 mm"
[bodies.arm]
mass = "20 g"
inertia = "1e4 g*mm^2"
[bodies.arm.outlines.tip]
type = "disc"
radius = "5 mm"
[joints.slide]
type = "prismatic"
bodies = ["ground", "arm"]
points = [["24.99 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "0 mm"
[tendons.cord]
path = [{ eyelet = "ground", at = ["-50 mm", "0 mm"] }, { eyelet = "arm" }]
[actuators.pull]
tendon = "cord"
tension = "5 N"
[ground.outlines.wall]
type = "half_plane"
point = ["-19.99 mm", "0 mm"]
normal = [1, 0]
[laws.pad]
stiffness = 1e6
damping = "1 s/m"
friction = { mu_static = 0.5 }
[[contacts]]
between = ["obj", "arm"]
law = "pad"
[[contacts]]
points = "obj.skin"
face = "ground.wall"
law = "pad"
"#;

#[test]
fn a_cord_only_pulls() {
    let found = grasp(&parsed(CORD), &MechanismGraspRequest { object: Some("obj".to_string()), ..request(4) });
    // Blocked, the tension of the cord grows with the acceleration.
    let [blocked, at_effort] = [0, 1].map(|mode| limits(&found, mode));
    assert!(blocked.iter().all(|limit| limit.is_infinite()), "{blocked:?}");
    // With 5 N: the arm leaves the ball at 5 N/20 g; across, friction of 2 · 0.5 · 5 N holds 50 g.
    assert!(at_effort[0].is_infinite(), "{at_effort:?}");
    for (index, expected) in [(1, 5.0 / 0.05), (2, 5.0 / 0.07), (3, 5.0 / 0.05)] {
        assert!((at_effort[index] - expected).abs() < 1e-3 * expected, "{index}: {at_effort:?}");
    }
    let case = &found.friction_cases[0].polar[1][2];
    let MechanismLimit::Limited { yielding, .. } = &case.largest else { panic!("{case:?}") };
    assert_eq!(yielding.iter().map(|index| found.actuators[*index].name.as_str()).collect::<Vec<_>>(), ["pull"]);
    // A blocked cord that runs the other way cannot push the arm against the ball.
    let pushed = CORD.replace("-50 mm", "80 mm").replace("tension = \"5 N\"", "tension = \"0 N\"");
    let found = grasp(&parsed(&pushed), &MechanismGraspRequest { object: Some("obj".to_string()), ..request(4) });
    let blocked = limits(&found, 0);
    assert!(blocked[2].abs() < 1e-6 && blocked[1].abs() < 1e-6 && blocked[0].is_infinite(), "{blocked:?}");
}

/// Hands on lifts: the base is the hand, and the lift is blocked in both cases.
#[test]
fn hands_on_lifts_have_results() {
    for (name, base, duration_s) in [("2f85-lift", "palm", 0.12), ("franka-lift", "hand", 0.3)] {
        let scene = scene::load_any(format!("scenes/real/{name}.toml")).expect("a scene");
        let found = grasp(&scene, &MechanismGraspRequest { at_s: Some(duration_s), ..request(4) });
        assert_eq!((found.base.as_str(), found.object.as_str()), (base, "object"));
        let role = |actuator: &str| found.actuators.iter().find(|of| of.name == actuator).map(|of| of.role);
        assert_eq!(role("lift"), Some(ActuatorRole::Base), "{name}");
        for mode in [0, 1] {
            let limits = limits(&found, mode);
            assert!(limits.iter().all(|limit| *limit > 0.0 || mode == 1), "{name} {mode}: {limits:?}");
        }
        let other = MechanismGraspRequest { base: Some("ground".to_string()), at_s: Some(duration_s), ..request(1) };
        assert_eq!(grasp(&scene, &other).base, "ground");
    }
}
