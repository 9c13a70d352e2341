//! Scenes of mechanisms: reading, showing, and their samples.

use std::f64::consts::FRAC_PI_4;
use std::fs;

use phalanx::drawing::{self, BodyRole, Drawing};
use phalanx::law::{Bristle, FrictionKind, FrictionLaw, NormalLaw};
use phalanx::mechanism::tendon::length_in;
use phalanx::mechanism::{
    Command, ForcePoint, JointCombination, JointKind, Mechanism, OutlineShape, PathElement, SpringKind, Tendon,
    assemble,
};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{self, Hand, Scene};
use phalanx::trace::schema::{JointState, SubjectKind};
use phalanx::trace::{self, BodyState, ContactSample, Model, Sample, Schema, interpolate};

use crate::support::mechanism_cases::mechanism_case;
use crate::support::runs::CollectSink;
use crate::{assert_round_trip, parse};

/// Names of the channels of a case.
fn columns(name: &str) -> Vec<String> {
    let schema = Schema::from_scene(&mechanism_case(name).scene());
    schema.channels().into_iter().map(|channel| channel.name).collect()
}

#[test]
fn channels_follow_from_joints_actuators_bodies_and_contacts() {
    let slider = columns("b_swinging_slider");
    let expected = "time_s arm_rad arm_rate_rad_s arm_force_x_n arm_force_y_n \
        slide_position_m slide_rate_m_s slide_force_x_n slide_force_y_n slide_moment_n_m push_force_n \
        arm_x_m arm_y_m arm_angle_rad arm_vx_m_s arm_vy_m_s arm_spin_rad_s";
    assert_eq!(slider[..17].join(" "), expected);
    assert_eq!(slider[17], "block_x_m");

    let finger = columns("c_f85_link_pad");
    for name in
        ["r_coupler_rate_rad_s", "motor_torque_n_m", "ground.disc/r_link.face_normal_n", "r_coupler_upper_gap_rad"]
    {
        assert!(finger.iter().any(|column| column == name), "{name} is not among {finger:?}");
    }
}

#[test]
fn samples_hold_the_states_of_a_mechanism() {
    let schema = Schema::from_scene(&mechanism_case("c_f85_two_disc").scene());
    let counts = schema.counts();
    assert_eq!((counts.joints, counts.actuators, counts.bodies, counts.contacts, counts.limits), (10, 2, 9, 6, 2));
    let sample_at = |time_s: f64| {
        let mut sample = Sample::new(time_s, counts);
        for index in 0..counts.joints {
            let rate = 0.125 * (1 + index) as f64;
            let force_n = [rate * time_s, 2.0];
            let joint = JointState { angle_rad: rate * time_s, rate_rad_s: rate, force_n, moment_n_m: -time_s };
            sample.set_joint(index, &joint);
        }
        sample.set_actuator(1, 0.25);
        sample.set_contact(5, &ContactSample { gap_m: 0.3, normal_n: time_s, ..ContactSample::default() });
        sample
    };
    let middle = interpolate(&sample_at(0.0), &sample_at(1.0), 0.5);
    let joint = middle.joint_state(9);
    assert_eq!((joint.angle_rad, joint.rate_rad_s, joint.force_n, joint.moment_n_m), (0.625, 1.25, [0.625, 2.0], -0.5));
    assert_eq!((middle.actuator(0), middle.actuator(1), middle.contact(5).normal_n), (0.0, 0.25, 0.5));
    assert!(middle.is_stop(4) && middle.is_stop(5) && !middle.is_stop(3));
    assert_eq!(middle.surfaces().count(), 4);
    let channel = |subject: &str, key: &str| {
        let channels =
            schema.subjects().into_iter().filter(|found| found.name == subject).flat_map(|found| {
                found.channels().map(|(quantity, channel)| (quantity.key, channel)).collect::<Vec<_>>()
            });
        channels.into_iter().find(|(found, _)| *found == key).expect("a channel").1
    };
    assert_eq!(channel("l_coupler_lower", "torque_n_m").value(&middle), 0.5);
    assert_eq!(channel("l_motor", "torque_n_m").value(&middle), 0.25);
    // The contacts of another order keep the joints, and know their limits.
    let selected = middle.select(&[8], &[0, 5]);
    assert_eq!((selected.joint_state(9), selected.contact(1)), (middle.joint_state(9), middle.contact(5)));
    assert!(selected.is_stop(1) && !selected.is_stop(0));
}

/// The shipped scene of a mechanism.
fn shipped(name: &str) -> Scene {
    let text = fs::read_to_string(format!("scenes/mechanisms/{name}.toml")).expect("a scene");
    parse(&text)
}

#[test]
fn shipped_mechanisms_are_the_reference_cases() {
    for (name, case) in [
        ("f85-finger", "c_f85_link_pad"),
        ("four-bar", "b_four_bar"),
        ("slider-crank", "b_slider_crank"),
        ("andrews", "a_andrews"),
    ] {
        let (scene, case) = (shipped(name), mechanism_case(case));
        let (found, expected) = (scene.mechanism.as_ref().expect("a mechanism"), &case.mechanism);
        assert_eq!(scene.kind, SceneKind::Mechanism);
        assert_eq!(scene.duration_s, case.duration_s, "{name}");
        assert_eq!(found.gravity_m_s2, expected.gravity_m_s2, "{name}");
        // The names of the reference begin with a side, and lists have another order.
        let plain = |name: &str| name.strip_prefix("r_").unwrap_or(name).to_owned();
        let start = assemble(found).expect("a start");
        for (body, pose) in expected.bodies.iter().zip(&case.start.poses) {
            let index = found.bodies.iter().position(|other| other.name == plain(&body.name)).expect("a body");
            let other = &found.bodies[index];
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-15 * b.abs();
            assert!(near(other.mass_kg, body.mass_kg) && near(other.inertia_kg_m2, body.inertia_kg_m2), "{name}");
            assert!((0..2).all(|k| near(other.com_m[k], body.com_m[k])), "{name}: {}", body.name);
            let error = (0..3).map(|k| (start.poses[index][k] - pose[k]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-13, "{name}: {} by {error}", body.name);
        }
        let counts = |of: &Mechanism| {
            [of.joints.len(), of.springs.len(), of.actuators.len(), of.contacts.len(), of.limits().len()]
        };
        assert_eq!(counts(found), counts(expected), "{name}");
        for joint in &expected.joints {
            let found_joint =
                found.joints.iter().find(|other| plain(&other.name).eq_ignore_ascii_case(&plain(&joint.name)));
            let found_joint = found_joint.expect("a joint");
            assert_eq!(found_joint.kind, joint.kind, "{name}");
            let (a, b) = (found_joint.limit, joint.limit);
            assert_eq!((a, found_joint.damping, found_joint.armature), (b, joint.damping, joint.armature), "{name}");
        }
        if let ([first, ..], [other, ..]) = (&found.contacts[..], &expected.contacts[..]) {
            assert_eq!((first.law, first.force_point), (other.law, other.force_point));
        }
        assert_eq!(found.actuators[0].command, expected.actuators[0].command, "{name}");
    }
}

/// A scene with every kind of part.
const EVERYTHING: &str = r#"
kind = "mechanism"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[bodies.left]
mass = "0.2 kg"
inertia = "1e-4 kg*m^2"
guess = { at = ["-40 mm", "20 mm"] }
[bodies.right]
mass = "0.2 kg"
inertia = "1e-4 kg*m^2"
guess = { at = ["40 mm", "20 mm"] }
[bodies.right.outlines.face]
type = "capsule"
from = ["0 mm", "-15 mm"]
to = ["0 mm", "15 mm"]
radius = "2 mm"
[bodies.arm]
mass = "30 g"
inertia = "2e-5 kg*m^2"
guess = { at = ["0 mm", "100 mm"], angle = "-90 deg" }
[bodies.ball]
mass = "50 g"
inertia = "8e-6 kg*m^2"
start = { at = ["0 mm", "21 mm"], angle = "5 deg", velocity = ["0.1 m/s", "0 m/s"], spin = "2 rad/s" }
[bodies.ball.outlines.rim]
type = "disc"
radius = "20 mm"
[ground.outlines.floor]
type = "half_plane"
normal = [0, 2]
[joints.right]
type = "prismatic"
bodies = ["ground", "right"]
points = [["0 mm", "20 mm"], ["0 mm", "0 mm"]]
start = "40 mm"
start_rate = "-0.1 m/s"
armature = "10 g"
damping = "2 N*s/m"
lower = "10 mm"
stop = "end"
[joints.left]
type = "prismatic"
bodies = ["ground", "left"]
points = [["0 mm", "20 mm"], ["0 mm", "0 mm"]]
axis = "0 deg"
[joints.shoulder]
bodies = ["ground", "arm"]
at = ["0 mm", "100 mm"]
offset = "-90 deg"
upper = "30 deg"
stop = "stop"
[springs.return]
joint = "shoulder"
stiffness = "0.1 N*m/rad"
torque = "20 N*mm"
[springs.coil]
type = "linear"
bodies = ["arm", "ball"]
points = [["30 mm", "0 mm"], ["0 mm", "0 mm"]]
stiffness = "100 N/m"
rest = "30 mm"
damping = "0.3 N*s/m"
[couplings.sync]
joints = ["right", "left"]
factors = [1, 1]
[actuators.jaw]
joint = "right"
times = ["0 ms", "60 ms"]
targets = ["40 mm", "10 mm"]
kp = "2e4 N/m"
kd = "60 N*s/m"
limit = "20 N"
[actuators.motor]
joint = "shoulder"
torque = "20 N*mm"
no_load_speed = "100 rad/s"
[laws.end]
type = "step"
stiffness = 1e8
exponent = 2.2
damping = "2e3 N*s/m"
transition = "0.1 mm"
[laws.stop]
stiffness = 2e4
damping = "0.2 s/rad"
[laws.pad]
stiffness = 1e6
damping = "3 s/m"
friction = { mu_static = 0.6 }
[[contacts]]
points = "ball.rim"
faces = ["right.face", "ground.floor"]
law = "pad"
[[contacts]]
points = "right.face"
face = "ground.floor"
law = "end"
at = "middle"
"#;

#[test]
fn every_part_is_read_and_shown_again() {
    let scene = parse(EVERYTHING);
    let of = scene.mechanism.as_ref().expect("a mechanism");
    // Lists are in the order of the names.
    let names = |all: Vec<&str>| all.join(" ");
    assert_eq!(names(of.bodies.iter().map(|body| body.name.as_str()).collect()), "arm ball left right");
    assert_eq!(names(of.joints.iter().map(|joint| joint.name.as_str()).collect()), "left right shoulder");
    let right = &of.joints[1];
    assert_eq!((right.kind, right.bodies), (JointKind::Prismatic { axis_rad: 0.0 }, [None, Some(3)]));
    assert_eq!((right.start, right.start_rate, right.armature, right.damping), (Some(0.04), -0.1, 0.01, 2.0));
    assert_eq!((right.lower, right.upper, right.limit), (Some(0.01), None, Some(NormalLaw::step(1e8, 2.2, 2e3, 1e-4))));
    // One point of the posture gives the point in each body.
    let shoulder = &of.joints[2];
    assert_eq!((shoulder.points_m, shoulder.start), ([[0.0, 0.1], [0.0, 0.0]], None));
    let ball = &of.bodies[1];
    assert_eq!((ball.pose, ball.rate), ([0.0, 0.021, 5f64.to_radians()], [0.1, 0.0, 2.0]));
    assert_eq!(of.ground_outlines[0].shape, OutlineShape::HalfPlane { point_m: [0.0; 2], normal: [0.0, 1.0] });
    assert_eq!(of.couplings[0].on.terms, [(1, 1.0), (0, 1.0)]);
    assert_eq!(of.springs[1].kind, SpringKind::Torsional { on: JointCombination::of_joint(2), preload: 0.02 });
    let Command::Servo { kp, kd, target, .. } = &of.actuators[0].command else { panic!("a controller") };
    assert_eq!((*kp, *kd, target.at(0.03).0, of.actuators[0].limit), (2e4, 60.0, 0.025, Some(20.0)));
    assert_eq!(of.actuators[1].no_load_speed, Some(100.0));
    let contacts: Vec<String> = of.point_contacts().into_iter().map(|contact| contact.name).collect();
    assert_eq!(
        contacts.join(" "),
        "ball.rim/right.face ball.rim/ground.floor right.face[0]/ground.floor right.face[1]/ground.floor"
    );
    assert_eq!(
        of.contacts[0].law.friction.map(|friction| (friction.mu_static, friction.v_static_m_s)),
        Some((0.6, 0.1))
    );
    assert_eq!(of.contacts[2].force_point, ForcePoint::Middle);
    assert_round_trip(&scene);
    // As written, with its own names of laws.
    let written = scene::show_written(&scene);
    assert!(written.contains("[[contacts]]") && written.contains("[laws.pad]"), "{written}");
    assert_eq!(parse(&written).mechanism, scene.mechanism, "{written}");
    for name in ["f85-finger", "four-bar", "slider-crank", "andrews", "jaws", "tendon-finger"] {
        assert_round_trip(&shipped(name));
    }
}

#[test]
fn tendons_are_read_and_shown_again() {
    let scene = shipped("tendon-finger");
    let of = scene.mechanism.as_ref().expect("a mechanism");
    let flexor = &of.tendons[0];
    assert_eq!(
        (flexor.stiffness_n_per_m, flexor.damping_n_s_per_m, &flexor.joints[..]),
        (2e5, 20.0, &[(2, 0.006)][..])
    );
    let pulley = PathElement { body: None, point_m: [0.0; 2], radius_m: 0.008, side: -1.0, friction: None };
    assert_eq!((flexor.path[1], flexor.path[2].body, flexor.path[3].body), (pulley, Some(1), Some(0)));
    // The spring has the tension of the pretension at the start: 1 N at 2e5 N/m.
    let length_m = length_in(of, flexor, &drawing::poses_at_start(of));
    assert!((length_m - flexor.rest_m - 5e-6).abs() < 1e-15, "{length_m}, {}", flexor.rest_m);
    let text = fs::read_to_string("scenes/mechanisms/tendon-finger.toml").expect("a scene");
    let pulled = text.replace(
        "joint = \"shaft\"\ntorque = \"0.35 N*m\"\nno_load_speed = \"40 rad/s\"",
        "tendon = \"flexor\"\ntimes = [\"0 ms\", \"20 ms\"]\ntensions = [\"0 N\", \"30 N\"]",
    );
    let scene = parse(&pulled);
    let of = scene.mechanism.as_ref().expect("a mechanism");
    let pull = of.tendons[0].actuator.as_ref().expect("an actuator");
    assert_eq!((pull.name.as_str(), pull.tension.at(0.01).0, of.actuators.len()), ("motor", 15.0, 0));
    assert_round_trip(&scene);
    let columns: Vec<String> = Schema::from_scene(&scene).channels().into_iter().map(|channel| channel.name).collect();
    let expected = "motor_force_n flexor_length_m flexor_rate_m_s flexor_tension_n flexor[1]_on";
    assert!(columns.join(" ").contains(expected), "{columns:?}");
}

/// Two fingers with a joint limit, a tendon and its motor, on a slider of the palm; the left one is written only here.
const ONE_SIDE: &str = r#"
kind = "mechanism"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[mirror]
from = "right"
to = "left"
[bodies.right]
mass = "20 g"
inertia = "1e-5 kg*m^2"
com = ["10 mm", "3 mm"]
guess = { at = ["30 mm", "5 mm"], angle = "70 deg" }
[bodies.right.outlines.pad]
type = "polygon"
vertices = [["0 mm", "-4 mm"], ["50 mm", "-4 mm"], ["40 mm", "6 mm"], ["0 mm", "6 mm"]]
rounding = "1 mm"
[bodies.right_tip]
mass = "5 g"
inertia = "1e-6 kg*m^2"
guess = { at = ["47 mm", "52 mm"], angle = "100 deg" }
[bodies.right_tip.outlines.egg]
type = "ellipse"
center = ["8 mm", "1 mm"]
semi_axes = ["12 mm", "5 mm"]
angle = "20 deg"
[bodies.right_winch]
mass = "8 g"
inertia = "4e-7 kg*m^2"
guess = { at = ["20 mm", "-9 mm"] }
[bodies.object]
mass = "30 g"
inertia = "6e-6 kg*m^2"
start = { at = ["0 mm", "60 mm"] }
[bodies.object.outlines.rim]
type = "disc"
radius = "16 mm"
[joints.right]
bodies = ["ground", "right"]
at = ["30 mm", "5 mm"]
offset = "10 deg"
start = "60 deg"
start_rate = "1 rad/s"
[joints.right_knuckle]
bodies = ["right", "right_tip"]
points = [["50 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "30 deg"
lower = "0 deg"
stop = "stop"
[joints.right_shaft]
type = "prismatic"
bodies = ["ground", "right_winch"]
points = [["20 mm", "-9 mm"], ["0 mm", "0 mm"]]
axis = "-30 deg"
start = "0 mm"
[springs.right]
joint = "right_knuckle"
stiffness = "0.02 N*m/rad"
damping = "2e-4 N*m*s/rad"
[springs.right_coil]
type = "linear"
bodies = ["ground", "right"]
points = [["60 mm", "0 mm"], ["30 mm", "0 mm"]]
stiffness = "50 N/m"
rest = "20 mm"
[tendons.right]
stiffness = "2e4 N/m"
damping = "5 N*s/m"
pretension = "1 N"
path = [
  { eyelet = "right_winch" },
  { pulley = "ground", at = ["24 mm", "9 mm"], radius = "3 mm", turn = "cw" },
  { eyelet = "right_tip", at = ["6 mm", "5 mm"] },
]
[actuators.right]
joint = "right_shaft"
force = "6 N"
[laws.stop]
stiffness = 2e4
damping = "0.2 s/rad"
[laws.pad]
stiffness = 1e6
damping = "3 s/m"
friction = { mu_static = 0.4 }
[[contacts]]
points = "object.rim"
face = "right.pad"
law = "pad"
[[contacts]]
points = "right_tip.egg"
face = "object.rim"
law = "pad"
"#;

#[test]
fn mirror_images_move_as_their_originals() {
    let scene = parse(ONE_SIDE);
    assert_round_trip(&scene);
    let of = scene.mechanism.as_ref().expect("a mechanism");
    let names = |all: Vec<&str>| all.join(" ");
    assert_eq!(
        names(of.bodies.iter().map(|body| body.name.as_str()).collect()),
        "left left_tip left_winch object right right_tip right_winch"
    );
    assert_eq!((of.joints.len(), of.springs.len(), of.tendons.len(), of.actuators.len()), (6, 4, 2, 2));
    let contacts: Vec<String> = of.point_contacts().into_iter().map(|contact| contact.name).collect();
    assert_eq!(
        contacts.join(" "),
        "object.rim/right.pad right_tip.egg/object.rim object.rim/left.pad left_tip.egg/object.rim"
    );
    for model in [Model::Analytic, Model::Engine] {
        let mut found = CollectSink::default();
        let outcome = trace::run(model, &scene, &mut found).expect("a run");
        let touches = |side: usize| outcome.contacts[2 * side..][..2].iter().any(|of| of.impulse_n_s > 1e-4);
        assert!(touches(0) && touches(1), "{model:?}: {:?}", outcome.contacts);
        let bounds = if model == Model::Analytic { 1e-9 } else { 1e-6 };
        for sample in &found.samples {
            for joint in 0..3 {
                let [left, right] = [joint, joint + 3].map(|joint| sample.joint_state(joint).angle_rad);
                assert!((left - right).abs() < bounds, "{model:?} at {} s: {left} {right}", sample.time_s);
            }
            let ([x, _], turn) = (sample.body(3).centre_m, sample.body(3).angle_rad);
            assert!(x.abs() < bounds && turn.abs() < 100.0 * bounds, "{model:?} at {} s: {x} {turn}", sample.time_s);
        }
    }
}

/// The worm of two drivers determines the start of the image.
#[test]
fn a_coupling_may_determine_the_start_of_an_image() {
    let coupled = format!("{ONE_SIDE}\n[couplings.worm]\njoints = [\"right\", \"left\"]\nfactors = [1, -1]\n");
    let scene = parse(&coupled);
    let of = scene.mechanism.as_ref().expect("a mechanism");
    let starts: Vec<bool> = of.joints.iter().map(|joint| joint.start.is_some()).collect();
    assert_eq!(starts, [false, true, true, true, true, true]);
    assert_round_trip(&scene);
}

#[test]
fn combinations_rotors_and_brakes_are_read_and_shown_again() {
    let parts = r#"
[springs.mean]
joints = ["right", "left"]
factors = [0.5, 0.5]
offset = "12 deg"
stiffness = "0.3 N*m/rad"
[rotors.seesaw]
joints = ["right", "left"]
factors = [0.5, -0.5]
inertia = "2e-6 kg*m^2"
[actuators.input]
joints = ["right", "left"]
factors = [0.5, 0.5]
torque = "50 N*mm"
brake = { limit = "0.5 N*m", at = "2 ms", rise = "3 ms", release = "15 ms", one_way = true, stiffness = "1e3 N*m/rad" }
[actuators.slow]
joint = "right_knuckle"
torque = "0 N*m"
brake = { limit = "0.1 N*m" }
"#;
    let scene = parse(&format!("{ONE_SIDE}{parts}"));
    assert_round_trip(&scene);
    let of = scene.mechanism.as_ref().expect("a mechanism");
    let mean = JointCombination { terms: vec![(3, 0.5), (0, 0.5)], offset: 0.0 };
    let input = of.actuators.iter().find(|actuator| actuator.name == "input").expect("an actuator");
    assert_eq!((&input.on, input.limit), (&mean, None));
    let brake = input.brake.expect("a brake");
    assert_eq!((brake.torque_n_m, brake.start_s, brake.rise_s, brake.release_s), (0.5, 0.002, 0.003, Some(0.015)));
    let bristle = brake.bristle.expect("a bristle");
    assert_eq!((brake.one_way, bristle.damping_n_s_per_m, bristle.relaxation_s), (true, 1.0, 1e-3));
    let spring = of.springs.iter().find(|spring| spring.name == "mean").and_then(|spring| spring.on());
    assert_eq!(spring, Some(&JointCombination { offset: 12f64.to_radians(), ..mean.clone() }));
    assert_eq!(of.rotors[0].on, JointCombination { terms: vec![(3, 0.5), (0, -0.5)], offset: 0.0 });
}

/// A finger and a gripper with a differential, written out as mechanisms, move as they do.
#[test]
fn the_mechanism_of_a_gripper_is_a_scene_file() {
    for (name, joints) in [("experiment-95", ["q11", "q22"]), ("gripper/seesaw", ["right_q11", "left_q22"])] {
        let of_fingers = scene::load_any(format!("scenes/{name}.toml")).expect("a scene");
        let mechanism = of_fingers.mechanism().expect("a closed loop").into_owned();
        let written =
            Scene { kind: SceneKind::Mechanism, mechanism: Some(mechanism), hand: Hand::EMPTY, ..of_fingers.clone() };
        let of_bodies = parse(&scene::show(&written));
        let ends = [&of_fingers, &of_bodies].map(|scene| {
            let mut samples = CollectSink::default();
            trace::run(Model::Analytic, scene, &mut samples).expect("a run");
            let schema = Schema::from_scene(scene);
            let last = samples.samples.last().expect("a sample").clone();
            joints.map(|joint| schema.channel(SubjectKind::Joint, joint, "angle_rad").value(&last))
        });
        for (a, b) in ends[0].into_iter().zip(ends[1]) {
            assert!((a - b).abs() < 1e-6, "{name}: {ends:?}");
        }
    }
}

/// The object of a finger or a gripper with another outline: a disc moves as the disc of the scene, and boxes and ellipses
/// move in both models alike.
#[test]
fn objects_of_fingers_have_any_outline() {
    let with_object = |file: &str, more: &str| {
        let setting = |text: &str| scene::parse_setting("--set", text).expect("a setting");
        let settings: Vec<scene::Layer> = more.split('|').map(setting).collect();
        scene::load_any_with(format!("scenes/{file}.toml"), &settings).unwrap_or_else(|error| panic!("{error}"))
    };
    let end = |scene: &Scene, model: Model, joint: &str| {
        let outcome = trace::run(model, scene, &mut ()).expect("a run");
        Schema::from_scene(scene).channel(SubjectKind::Joint, joint, "angle_rad").value(&outcome.last)
    };
    let disc = "object.outline.type=disc|object.outline.radius=20 mm";
    for (file, joint) in [("experiment-95", "q22"), ("gripper/offset", "left_q22"), ("gripper/fixed", "right_q11")] {
        let (plain, outlined) = (with_object(file, "name=plain"), with_object(file, disc));
        assert_eq!(outlined.kind, SceneKind::Mechanism);
        assert_round_trip(&outlined);
        let [a, b] = [&plain, &outlined].map(|scene| end(scene, Model::Analytic, joint));
        assert!((a - b).abs() < 1e-6, "{file}: {a} {b}");
    }
    let egg = "object.outline.type=ellipse|object.outline.semi_axes=[\"20 mm\", \"17 mm\"]|object.outline.angle=20 deg";
    let boxed = "object.outline.type=box|object.outline.size=[\"30 mm\", \"28 mm\"]|object.outline.rounding=3 mm|object.radius=19.3 mm|object.height=20 mm|object.angle=3 deg|duration=20 ms";
    let lifted = "object.outline.type=box|object.outline.size=[\"28 mm\", \"26 mm\"]|object.outline.rounding=3 mm|object.radius=18 mm|object.height=20 mm|object.angle=3 deg|duration=60 ms";
    let cases = [
        ("experiment-95", egg, "q22"),
        ("gripper/design-95", boxed, "left_q22"),
        // The palm moves.
        ("gripper/lift", lifted, "right_q22"),
    ];
    for (file, more, joint) in cases {
        let scene = with_object(file, more);
        let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| end(&scene, model, joint));
        assert!((analytic - engine).abs() < 2e-5, "{file}: {analytic} {engine}");
    }
    // Its mass is that of a homogeneous box.
    let of = with_object("gripper/design-95", boxed).mechanism.expect("a mechanism");
    let object = of.bodies.iter().find(|body| body.name == "object").expect("the object");
    let area_m2 = 0.030 * 0.028 - (4.0 - std::f64::consts::PI) * 0.003 * 0.003;
    assert!((object.mass_kg - 1070.0 * 0.040 * area_m2).abs() < 1e-12, "{object:?}");
}

#[test]
fn single_values_replace_those_of_a_mechanism() {
    let file = scene::Layer { file: "own.toml".into(), text: EVERYTHING.into() };
    let setting = scene::parse_setting("--set", "joints.right.start=35 mm").expect("a setting");
    let changed = scene::parse_layers(std::slice::from_ref(&file), &[setting]).expect("a scene");
    let mut expected = parse(EVERYTHING).mechanism.expect("a mechanism");
    expected.joints[1].start = Some(0.035);
    assert_eq!(changed.mechanism, Some(expected));
    // The message about a list of tables is at its header.
    let wrong = scene::parse_setting("--set", "laws.pad.damping=1 s/rad").expect("a setting");
    let error = scene::parse_layers(&[file], &[wrong]).expect_err("a law of limits").to_string();
    assert!(error.contains("`contacts[0].law` has units of s/rad, but a contact needs a law with s/m"), "{error}");
    assert!(error.contains("[[contacts]]"), "{error}");
}

/// Checks that every drawn body has a pose, and that its velocity is the rate of that pose; returns names and poses.
fn drawn_poses(scene: &Scene) -> (Vec<String>, Vec<drawing::FramePose>) {
    let of = scene.mechanism.as_ref().expect("a mechanism");
    let counts = Schema::from_scene(scene).counts();
    let at = |time_s: f64| {
        let mut sample = Sample::new(time_s, counts);
        for (index, [x, y, angle]) in drawing::poses_at_start(of).into_iter().enumerate() {
            let velocity_m_s = [0.1 * index as f64, -0.2];
            let centre_m = [x + velocity_m_s[0] * time_s, y + velocity_m_s[1] * time_s];
            let state = BodyState { centre_m, angle_rad: angle + 3.0 * time_s, velocity_m_s, spin_rad_s: 3.0 };
            sample.set_body(index, &state);
        }
        sample
    };
    let names: Vec<String> = Drawing::from_scene(scene).bodies.into_iter().map(|body| body.name).collect();
    let drawing = Drawing::from_scene(scene);
    let [before, after] = [-1e-6, 1e-6].map(|time_s| drawing.poses(&at(time_s)));
    for (body, velocity) in drawing.velocities(&at(0.0)).iter().enumerate() {
        let rate = |a: f64, b: f64| (b - a) / 2e-6;
        let found = [0, 1].map(|k| rate(before[body].position_m[k], after[body].position_m[k]));
        assert!((0..2).all(|k| (found[k] - velocity.position_m[k]).abs() < 1e-9), "{}: {found:?}", names[body]);
        assert!((rate(before[body].angle_rad, after[body].angle_rad) - velocity.angle_rad).abs() < 1e-8);
    }
    assert_eq!(before.len(), names.len());
    (names, before)
}

#[test]
fn drawings_follow_the_bodies() {
    let text = EVERYTHING.replace(
        "[bodies.ball.outlines.rim]",
        "[bodies.ball.outlines.wall]\ntype = \"half_plane\"\npoint = [\"0 mm\", \"5 mm\"]\nnormal = [1, 1]\n[bodies.ball.outlines.rim]",
    );
    let scene = parse(&text);
    let (names, poses) = drawn_poses(&scene);
    assert_eq!(names, ["floor", "ball.wall", "ground", "arm", "ball", "left", "right"]);
    let drawn = Drawing::from_scene(&scene);
    assert_eq!(drawn.contacts.len(), 4);
    let [[left, bottom], [right, top]] = drawn.extent_m;
    // The arm turns about a pin at y = 100 mm, and is drawn with it.
    assert!(left < -0.04 && right > 0.04 && bottom < 0.02 && top > 0.1, "{:?}", drawn.extent_m);
    assert_eq!(poses[0].angle_rad, 0.0);
    assert!((poses[1].angle_rad + FRAC_PI_4 - 5f64.to_radians()).abs() < 1e-5);
}

/// A drawn body of a scene, by its name.
fn drawn_body(path: &str, name: &str) -> drawing::DrawnBody {
    let scene = scene::load_any(path).expect("a scene");
    let bodies = Drawing::from_scene(&scene).bodies;
    bodies.into_iter().find(|body| body.name == name).expect("a body")
}

#[test]
fn colours_follow_the_parts() {
    for (scene, body, role) in [
        ("real/2f85-encompass", "left_driver", BodyRole::Driver),
        ("real/2f85-encompass", "right_driver", BodyRole::Driver),
        ("real/2f85-encompass", "left_coupler", BodyRole::Coupler),
        ("real/2f85-encompass", "left_spring_link", BodyRole::Proximal),
        ("real/2f85-encompass", "left_follower", BodyRole::Distal),
        ("real/2f85-encompass", "object", BodyRole::Object),
        ("real/franka-lift", "left", BodyRole::Distal),
        ("real/franka-lift", "right", BodyRole::Distal),
        ("real/franka-lift", "table", BodyRole::Palm),
        ("real/barrett-grasp", "right_medial", BodyRole::Proximal),
        ("real/barrett-grasp", "ground", BodyRole::Palm),
        ("mechanisms/f85-finger", "disc", BodyRole::Object),
    ] {
        assert_eq!(drawn_body(&format!("scenes/{scene}.toml"), body).role, role, "{scene}: {body}");
    }
}

#[test]
fn pins_are_marked_and_sliders_are_blocks() {
    // Pins, and neither frames nor points of sliders.
    let jaw = drawn_body("scenes/real/franka-lift.toml", "left");
    assert_eq!((jaw.marks_m.len(), jaw.shapes.len()), (0, 4));
    let slider = drawn_body("scenes/mechanisms/slider-crank.toml", "slider");
    assert_eq!((slider.marks_m, slider.shapes.len()), (vec![[0.0; 2]], 3));
    // Four pins, three of them at one point, on a bar.
    let k2 = drawn_body("scenes/mechanisms/andrews.toml", "k2");
    assert_eq!((k2.marks_m, k2.shapes.len()), (vec![[-0.028, 0.0], [0.0; 2]], 3));
    // The pad of the follower is away from its pins, and a bar leads to it.
    let text = fs::read_to_string("scenes/real/2f85-pinch.toml").expect("a scene");
    let outline = text.find("[bodies.right_follower.outlines.body]").expect("an outline");
    let end = outline + text[outline..].find("[bodies.right_follower.outlines.pad]").expect("the next outline");
    let scene = parse(&format!("{}{}", &text[..outline], &text[end..]));
    let bodies = Drawing::from_scene(&scene).bodies;
    let follower = bodies.iter().find(|body| body.name == "right_follower").expect("a body");
    assert_eq!(follower.shapes.len(), 5, "a bar between two pins, a bar to the pad, the pad, two pins");
}

/// The first segment of the cable leads along y = −8 mm to the pulley, whose lowest point is there.
#[test]
fn cables_are_drawn_along_their_paths() {
    let (names, poses) = drawn_poses(&shipped("tendon-finger"));
    let bar = |name: &str| poses[names.iter().position(|other| other == name).expect("a bar")];
    assert_eq!(names.iter().filter(|name| name.starts_with("flexor[")).count(), 9);
    for (name, x_m) in [("flexor[0]", 0.045), ("flexor[1]", 0.0225), ("flexor[2]", 0.0)] {
        let [x, y] = bar(name).position_m;
        assert!((x - x_m).abs() < 1e-6 && (y + 0.008).abs() < 1e-6, "{name}: {x}, {y}");
    }
}

/// A scene of free bodies with one outline each, and the entries of contacts.
fn with_outlines(outlines: &[&str], contacts: &str) -> String {
    let mut text = "kind = \"mechanism\"\n[laws.pad]\nstiffness = 1e6\n".to_string();
    for (index, outline) in outlines.iter().enumerate() {
        let x = 100 * index;
        text += &format!(
            "[bodies.b{index}]\nmass = \"1 g\"\ninertia = \"1 g*mm^2\"\nstart = {{ at = [\"{x} mm\", \"0 mm\"] }}\n"
        );
        text += &format!("[bodies.b{index}.outlines.skin]\n{outline}\n");
    }
    format!("{text}[[contacts]]\n{contacts}\nlaw = \"pad\"\n")
}

const DISC: &str = "type = \"disc\"\nradius = \"10 mm\"";
const BAR: &str = "type = \"capsule\"\nfrom = [\"0 mm\", \"0 mm\"]\nto = [\"30 mm\", \"0 mm\"]\nradius = \"2 mm\"";
const BOX: &str = "type = \"box\"\nsize = [\"40 mm\", \"30 mm\"]\nrounding = \"1 mm\"";
const SHARP: &str = "type = \"box\"\nsize = [\"40 mm\", \"30 mm\"]";
const EGG: &str = "type = \"ellipse\"\nsemi_axes = [\"20 mm\", \"10 mm\"]\nangle = \"90 deg\"";
const FLOOR: &str = "type = \"half_plane\"\npoint = [\"0 mm\", \"-20 mm\"]\nnormal = [0, 1]";

#[test]
fn outlines_of_any_kind_are_read_and_shown_again() {
    let scene = parse(&with_outlines(&[BOX, EGG, BAR, DISC], "between = [\"*\", \"b*.skin\"]"));
    assert_round_trip(&scene);
    let of = scene.mechanism.as_ref().expect("a mechanism");
    let OutlineShape::Polygon { vertices_m, radius_m } = &of.bodies[0].outlines[0].shape else { panic!("a polygon") };
    let expected = [[-0.019, -0.014], [0.019, -0.014], [0.019, 0.014], [-0.019, 0.014]];
    let error = vertices_m.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
    assert!(error.fold(0.0, f64::max) < 1e-17 && *radius_m == 0.001, "{vertices_m:?}");
    // Bodies with corners touch in both directions, each pair once; discs and ellipses with their points.
    let names: Vec<String> = of.point_contacts().into_iter().map(|contact| contact.name).collect();
    let count = |pair: &str| names.iter().filter(|name| name.split('[').next() == Some(pair) || *name == pair).count();
    assert_eq!(names.len(), 1 + (4 + 2) + 1 + 1 + 1 + 1, "{names:?}");
    assert!(names.contains(&"b0.skin[3]/b2.skin".to_string()) && names.contains(&"b2.skin[1]/b0.skin".to_string()));
    assert!(
        names.contains(&"b1.skin/b0.skin".to_string()) && names.contains(&"b1.skin/b3.skin".to_string()),
        "{names:?}"
    );
    assert_eq!((count("b0.skin"), count("b2.skin")), (4, 2));
    // A sharp outline may touch a half plane.
    let falling = parse(&with_outlines(&[SHARP, FLOOR], "points = \"b0.skin\"\nface = \"b1.skin\""));
    assert_round_trip(&falling);
}

#[test]
fn contacts_that_are_not_defined_are_refused_with_the_remedy() {
    let polygon = |vertices: &str| format!("type = \"polygon\"\nrounding = \"1 mm\"\nvertices = [{vertices}]");
    let corners = |points: &[[i32; 2]]| {
        let corners: Vec<String> = points.iter().map(|[x, y]| format!("[\"{x} mm\", \"{y} mm\"]")).collect();
        polygon(&corners.join(", "))
    };
    let clockwise = corners(&[[0, 0], [0, 20], [20, 0]]);
    let concave = corners(&[[0, 0], [20, 0], [5, 5], [0, 20]]);
    let star = corners(&[[0, 10], [-6, -8], [10, 3], [-10, 3], [6, -8]]);
    let thin = "type = \"box\"\nsize = [\"40 mm\", \"2 mm\"]\nrounding = \"1 mm\"";
    let between = "between = [\"b0\", \"b1\"]";
    let cases: [(&[&str], &str, &str); 12] = [
        (&[SHARP, SHARP], between, "neither `b0.skin` nor `b1.skin` has a radius"),
        (&[EGG, SHARP], between, "give a polygon a rounding"),
        (&[EGG, EGG], between, "is an ellipse, which cannot be a face"),
        (&[BAR, EGG], "points = \"b0.skin\"\nface = \"b1.skin\"", "swap points and face"),
        (&[FLOOR, FLOOR], between, "is a half plane, which has no points"),
        (&[clockwise.as_str(), BOX], between, "write them in the reverse order"),
        (&[concave.as_str(), BOX], between, "is not convex"),
        (&[star.as_str(), BOX], between, "is not convex"),
        (&[thin, BOX], between, "must be below 1 mm: a side vanishes"),
        (&[BOX, BOX], "between = [\"b0\", \"c*\"]", "there is no outline `c*`"),
        (&[BOX, BOX], "between = [\"b0\", \"b0\"]", "belong to one body"),
        (
            &[BOX, DISC],
            "between = [\"b*\", \"*\"]\nlaw = \"pad\"\n[[contacts]]\npoints = \"b1.skin\"\nface = \"b0.skin\"\nat = \"points\"",
            "listed twice",
        ),
    ];
    for (outlines, contacts, expected) in cases {
        let text = with_outlines(outlines, contacts);
        let error = scene::parse_any(&text, "test.toml").expect_err(&text).to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

/// Mass, centre and inertia from density and depth, against a polygon of many corners along the same outline.
#[test]
fn density_and_depth_give_mass_and_inertia() {
    let angled =
        format!("{BOX}\ncenter = [\"3 mm\", \"1 mm\"]\nangle = \"20 deg\"").replace("1 mm\"\ncenter", "6 mm\"\ncenter");
    for outline in [DISC, BAR, EGG, &angled] {
        let text = with_outlines(&[outline, FLOOR], "points = \"b0.skin\"\nface = \"b1.skin\"").replacen(
            "mass = \"1 g\"\ninertia = \"1 g*mm^2\"",
            "density = \"1000 kg/m^3\"\ndepth = \"20 mm\"",
            1,
        );
        let scene = parse(&text);
        assert_round_trip(&scene);
        let body = &scene.mechanism.as_ref().expect("a mechanism").bodies[0];
        let drawn = Drawing::from_scene(&scene);
        let of_body = drawn.bodies.iter().find(|drawn| drawn.name == "b0").expect("a body");
        let vertices_m = match &of_body.shapes[0] {
            drawing::Shape::Polygon { corners_m } => corners_m.clone(),
            drawing::Shape::Disc { .. } | drawing::Shape::Capsule { .. } => continue,
            drawing::Shape::HalfPlane { .. } => panic!("a shape with an area"),
        };
        let area = OutlineShape::Polygon { vertices_m, radius_m: 0.0 }.area().expect("an area");
        // The corners of an arc are within it.
        let ratio = |a: f64, b: f64| a / b - 1.0;
        assert!((0.0..1e-2).contains(&ratio(body.mass_kg, 20.0 * area.area_m2)), "{outline}: {body:?}, {area:?}");
        assert!(
            (0.0..2e-2).contains(&ratio(body.inertia_kg_m2, 20.0 * area.polar_m4)),
            "{outline}: {body:?}, {area:?}"
        );
        assert!((0..2).all(|k| (body.com_m[k] - area.centroid_m[k]).abs() < 1e-9), "{outline}: {body:?}, {area:?}");
    }
}

/// Two fingers, one the mirror image of the other, whose cable has friction, a roller and spools at both ends.
const RUBBING: &str = "kind = \"mechanism\"\nduration = \"10 ms\"\n[parameters]\nmu = 0.2\nreach = \"60 um\"\n\
    [bodies.right_finger]\nmass = \"30 g\"\ninertia = \"3000 g*mm^2\"\nguess = { at = [\"40 mm\", \"0 mm\"], angle = \"90 deg\" }\n\
    [bodies.right_winch]\nmass = \"30 g\"\ninertia = \"3000 g*mm^2\"\nguess = { at = [\"80 mm\", \"-20 mm\"] }\n\
    [joints.right_base]\nbodies = [\"ground\", \"right_finger\"]\nat = [\"40 mm\", \"0 mm\"]\noffset = \"90 deg\"\nstart = \"0 rad\"\n\
    [joints.right_shaft]\nbodies = [\"ground\", \"right_winch\"]\nat = [\"80 mm\", \"-20 mm\"]\nstart = \"0 rad\"\n\
    [tendons.right_flexor]\nstiffness = \"2e4 N/m\"\nfrom = \"first\"\n\
    friction = { mu_static = \"= mu\", presliding = \"= reach\", v_static = \"4 mm/s\", v_dynamic = \"9 mm/s\" }\npath = [\n\
    { eyelet = \"ground\", at = [\"70 mm\", \"-20 mm\"] },\n\
    { pulley = \"ground\", at = [\"32 mm\", \"-16 mm\"], radius = \"4 mm\", turn = \"cw\", roller = true },\n\
    { eyelet = \"right_finger\", at = [\"10 mm\", \"8 mm\"], friction = { mu_static = 0.3, mu_dynamic = \"= mu / 2\" } },\n\
    { pulley = \"right_finger\", at = [\"20 mm\", \"10 mm\"], radius = \"2 mm\", turn = \"ccw\" },\n\
    { eyelet = \"right_finger\", at = [\"35 mm\", \"7 mm\"] } ]\n\
    spools = [{ joint = \"right_shaft\", radius = \"6 mm\" }, { joint = \"right_base\", radius = \"2 mm\", turn = \"cw\", end = \"far\" }]\n\
    [mirror]\nfrom = \"right\"\nto = \"left\"\n";

#[test]
fn friction_rollers_and_ends_of_cables_are_read_and_shown_again() {
    let scene = parse(RUBBING);
    let of = scene.mechanism.as_ref().expect("a mechanism");
    let [right, left] = ["right_flexor", "left_flexor"]
        .map(|name| of.tendons.iter().find(|tendon| tendon.name == name).expect("a tendon"));
    let law = |bristle: Option<Bristle>, mu_static: f64, mu_dynamic: f64, v_static_m_s: f64, v_dynamic_m_s: f64| {
        Some(FrictionLaw { mu_static, mu_dynamic, v_static_m_s, v_dynamic_m_s, kind: FrictionKind::from(bristle) })
    };
    let bristle = Bristle { damping_n_s_per_m: 0.2 / 60e-6 * 1e-3, relaxation_s: 1e-3 };
    let common = law(Some(bristle), 0.2, 7.0 * 0.2 / 10.0, 4e-3, 9e-3);
    let own = law(None, 0.3, 0.1, 5e-3, 10e-3);
    let frictions: Vec<_> = right.path.iter().map(|element| element.friction).collect();
    assert_eq!(frictions, [None, None, own, common, None]);
    let named = |joints: &[(usize, f64)]| -> Vec<(String, f64)> {
        joints.iter().map(|(joint, factor)| (of.joints[*joint].name.clone(), *factor)).collect()
    };
    let [near, far] = [("right_shaft", 0.006), ("right_base", -0.002)].map(|(name, c)| vec![(name.to_string(), c)]);
    assert_eq!((named(&right.joints), named(&right.far_joints)), (near, far));
    let of_image: Vec<_> = left.path.iter().map(|element| (element.friction, element.side)).collect();
    let sides: Vec<_> =
        right.path.iter().map(|element| if element.is_pulley() { -element.side } else { element.side }).collect();
    assert_eq!(of_image, frictions.iter().copied().zip(sides).collect::<Vec<_>>());
    assert_eq!((left.joints.len(), left.far_joints.len(), left.rest_m), (1, 1, right.rest_m));
    assert_round_trip(&scene);
    let columns: Vec<String> = Schema::from_scene(&scene).channels().into_iter().map(|channel| channel.name).collect();
    for column in ["right_flexor[1]_on", "right_flexor[2]_slip_m_s", "left_flexor[3]_tension_n", "cable_friction_j"] {
        assert!(columns.iter().any(|found| found == column), "{column}: {columns:?}");
    }
}

/// A cable that is numbered from its last place is the cable with the opposite path.
#[test]
fn a_cable_from_its_last_place_is_the_cable_with_the_opposite_path() {
    let first = "path = [\n{ eyelet = \"ground\", at = [\"70 mm\", \"-20 mm\"] },\n\
        { pulley = \"ground\", at = [\"32 mm\", \"-16 mm\"], radius = \"4 mm\", turn = \"cw\" },\n\
        { eyelet = \"crank\", at = [\"10 mm\", \"8 mm\"] } ]\n";
    let last = "from = \"last\"\npath = [\n{ eyelet = \"crank\", at = [\"10 mm\", \"8 mm\"] },\n\
        { pulley = \"ground\", at = [\"32 mm\", \"-16 mm\"], radius = \"4 mm\", turn = \"ccw\" },\n\
        { eyelet = \"ground\", at = [\"70 mm\", \"-20 mm\"] } ]\n";
    let [first, last] = [first, last].map(|path| {
        parse(&format!(
            "kind = \"mechanism\"\nduration = \"10 ms\"\n[bodies.crank]\nmass = \"30 g\"\ninertia = \"3000 g*mm^2\"\n\
             guess = {{ at = [\"40 mm\", \"0 mm\"], angle = \"90 deg\" }}\n[joints.crank]\nbodies = [\"ground\", \"crank\"]\n\
             at = [\"40 mm\", \"0 mm\"]\noffset = \"90 deg\"\nstart = \"0 rad\"\n[tendons.flexor]\nfriction = {{ mu_static = 0.2 }}\n\
             {path}[actuators.pull]\ntendon = \"flexor\"\ntension = \"3 N\"\n"
        ))
    });
    let tendon = |scene: &Scene| scene.mechanism.as_ref().expect("a mechanism").tendons[0].clone();
    assert_eq!(Tendon { is_reversed: false, ..tendon(&last) }, tendon(&first));
    assert_round_trip(&last);
    let names = |scene: &Scene| Schema::from_scene(scene).elements;
    assert_eq!((names(&first), names(&last)), (vec!["flexor[1]".to_string()], vec!["flexor[1]".to_string()]));
}
