//! Mechanisms with joints on bodies with prescribed motion, and on bodies that do not rotate: closed forms, both models,
//! and grippers on a moving palm against their closed form.

use phalanx::mechanism::structure::find_groups;
use phalanx::mechanism::{Body, Joint, JointKind, Mechanism, PrescribedMotion, Spring, SpringKind};
use phalanx::scene::{self, Axis, Integrator, Move, PalmMotion, Preset, Ramp, Scene, Vibration};
use phalanx::trace::{self, Model, Sample};
use std::f64::consts::FRAC_PI_2;

use crate::support::laws::mechanism_scene;
use crate::support::runs::CollectSink;

/// Last sample of a run.
fn end_of(model: Model, scene: &Scene) -> Sample {
    let mut run = CollectSink::default();
    trace::run(model, scene, &mut run).unwrap_or_else(|error| panic!("{error}"));
    run.samples.pop().expect("a sample")
}

/// Last sample of a mechanism at reference tolerances. No energy is created.
fn end_of_mechanism(model: Model, mechanism: &Mechanism, duration_s: f64) -> Sample {
    let scene = mechanism_scene(mechanism.clone(), duration_s);
    let sample = end_of(model, &scene);
    let (energy, allowed) = (sample.energy(), if model == Model::Analytic { 1e-11 } else { 2e-5 });
    let exchanged_j = energy.kinetic_j + energy.motor_work_j.abs();
    assert!(energy.balance_j.abs() < allowed * exchanged_j, "{model:?}: {energy:?}");
    sample
}

fn body(name: &str, com_m: [f64; 2], motion: Option<PrescribedMotion>) -> Body {
    Body { com_m, motion, ..Body::new(name, 0.1, 2e-5) }
}

fn pin(name: &str, bodies: [Option<usize>; 2], points_m: [[f64; 2]; 2], start: Option<f64>) -> Joint {
    Joint { start, ..Joint::new(name, JointKind::Revolute, bodies, points_m) }
}

const GRAVITY: [f64; 2] = [0.0, -9.81];

/// A double pendulum on a body that accelerates swings as on the ground with gravity less the acceleration.
#[test]
fn a_pendulum_on_an_accelerating_pivot_swings_as_in_tilted_gravity() {
    let acceleration_m_s2 = [3.0, 1.5];
    let pendulum = |base: Option<usize>, pivot_m: [f64; 2]| {
        let mut joints = vec![
            pin("first", [base, Some(0)], [pivot_m, [0.0; 2]], Some(0.4)),
            pin("second", [Some(0), Some(1)], [[0.05, 0.0], [0.0; 2]], Some(0.2)),
        ];
        joints[1].armature = 3e-5;
        joints[1].start_rate = 2.0;
        let spring = SpringKind::Linear { bodies: [base, Some(1)], points_m: [pivot_m, [0.03, 0.0]] };
        Mechanism {
            bodies: [0, 1].map(|_| body("link", [0.03, 0.01], None)).to_vec(),
            joints,
            springs: vec![Spring { name: "coil".into(), kind: spring, stiffness: 5.0, damping: 0.01, rest: 0.04 }],
            ..Mechanism::default()
        }
    };
    let mut fixed = pendulum(None, [0.0; 2]);
    fixed.gravity_m_s2 = [0, 1].map(|k| GRAVITY[k] - acceleration_m_s2[k]);
    let mut moving = pendulum(Some(2), [0.02, 0.0]);
    moving.gravity_m_s2 = GRAVITY;
    let motion = Some(PrescribedMotion::ConstantAcceleration { acceleration_m_s2 });
    // The centre of mass of a body with prescribed motion has no effect.
    moving.bodies.push(Body { rate: [-0.4, 0.3, 0.0], ..body("cart", [0.01, 0.02], motion) });
    let duration_s = 0.3;
    let expected = end_of_mechanism(Model::Analytic, &fixed, duration_s);
    for (model, allowed) in [(Model::Analytic, [1e-10, 1e-9, 1e-9]), (Model::Engine, [5e-6, 1e-4, 1e-4])] {
        let found = end_of_mechanism(model, &moving, duration_s);
        for joint in 0..2 {
            let (found, expected) = (found.joint_state(joint), expected.joint_state(joint));
            let differences = [
                found.angle_rad - expected.angle_rad,
                found.rate_rad_s - expected.rate_rad_s,
                (0..2).map(|k| (found.force_n[k] - expected.force_n[k]).abs()).sum(),
            ];
            let is_close = (0..3).all(|k| differences[k].abs() < allowed[k]);
            assert!(is_close, "{model:?}, joint {joint}: {differences:?}");
        }
        let cart = found.body(2);
        let moved = [0.0, 1.0].map(|k| if k == 0.0 { -0.4 } else { 0.3 });
        for k in 0..2 {
            let expected = duration_s * (moved[k] + 0.5 * duration_s * acceleration_m_s2[k]);
            assert!((cart.centre_m[k] - expected).abs() < 1e-12, "{model:?}: {cart:?}");
        }
    }
}

/// Kapitza's pendulum on a palm that vibrates and turns: θ̈ = ((g − p̈) × e)/l about the turning palm, by Runge and Kutta.
#[test]
fn a_pendulum_on_a_vibrating_palm_follows_its_scalar_equation() {
    let vibration = |axis, amplitude, frequency_hz| Vibration {
        axis,
        amplitude,
        frequency_hz,
        phase_rad: 0.3,
        start_s: 0.01,
        ramp_periods: 2.0,
        ramp: Ramp::Quintic,
    };
    let motion = PalmMotion {
        moves: vec![
            Move { axis: Axis::X, distance: 0.2, start_s: 0.05, length_s: 0.2 },
            Move { axis: Axis::Angle, distance: 0.5, start_s: 0.02, length_s: 0.25 },
        ],
        vibrations: vec![vibration(Axis::Y, 4e-3, 60.0), vibration(Axis::Angle, 0.02, 25.0)],
        ..PalmMotion::default()
    };
    let (pivot, length, start) = ([0.03, -0.02], 0.06, FRAC_PI_2 + 0.1);
    let mut palm = body("palm", [0.0; 2], Some(PrescribedMotion::Palm(motion.clone())));
    palm.mass_kg = 0.0;
    let mut rod = body("rod", [length, 0.0], None);
    rod.inertia_kg_m2 = 1e-12;
    let mut mechanism = Mechanism {
        gravity_m_s2: GRAVITY,
        bodies: vec![rod, palm],
        joints: vec![pin("pivot", [Some(1), Some(0)], [pivot, [0.0; 2]], Some(start))],
        ..Mechanism::default()
    };
    // Acceleration of the angle in the world.
    let inertia = 0.1 * length * length + 1e-12;
    let acceleration = |t: f64, angle: f64| {
        let pose = motion.pose(t);
        let ([_, _, turn], [.., omega], [ax, ay, alpha]) = (pose.position, pose.rate, pose.acceleration);
        let arm = [turn.cos() * pivot[0] - turn.sin() * pivot[1], turn.sin() * pivot[0] + turn.cos() * pivot[1]];
        let of_pivot = [ax - alpha * arm[1] - omega * omega * arm[0], ay + alpha * arm[0] - omega * omega * arm[1]];
        let pull = [0, 1].map(|k| GRAVITY[k] - of_pivot[k]);
        0.1 * length * (angle.cos() * pull[1] - angle.sin() * pull[0]) / inertia
    };
    let (mut angle, mut rate, steps, duration_s) = (start, 0.0, 200_000, 0.3);
    let h = duration_s / f64::from(steps);
    for step in 0..steps {
        let t = h * f64::from(step);
        let [k1, l1] = [rate, acceleration(t, angle)];
        let [k2, l2] = [rate + 0.5 * h * l1, acceleration(t + 0.5 * h, angle + 0.5 * h * k1)];
        let [k3, l3] = [rate + 0.5 * h * l2, acceleration(t + 0.5 * h, angle + 0.5 * h * k2)];
        let [k4, l4] = [rate + h * l3, acceleration(t + h, angle + h * k3)];
        angle += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        rate += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
    }
    let pose = motion.pose(duration_s);
    let expected = [angle - pose.position[2], rate - pose.rate[2]];
    for (model, allowed) in [(Model::Analytic, [1e-9, 1e-7]), (Model::Engine, [2e-5, 2e-3])] {
        let found = end_of_mechanism(model, &mechanism, duration_s);
        let (joint, rod, palm) = (found.joint_state(0), found.body(0), found.body(1));
        for [angle_rad, rate_rad_s] in [[joint.angle_rad, joint.rate_rad_s], [rod.angle_rad, rod.spin_rad_s]] {
            let differences = [angle_rad - expected[0], rate_rad_s - expected[1]];
            assert!((0..2).all(|k| differences[k].abs() < allowed[k]), "{model:?}: {differences:?}");
        }
        let differences = [0, 1].map(|k| (rod.centre_m[k] - pivot[k]).abs() + palm.centre_m[k].abs());
        assert!(differences.iter().all(|difference| *difference < 1e-9), "{model:?}: {rod:?}, {palm:?}");
    }
    // The rotor of an armature turns with the joint, relative to the palm.
    mechanism.joints[0].armature = 1e-4;
    let [analytic, engine] =
        [Model::Analytic, Model::Engine].map(|model| end_of_mechanism(model, &mechanism, duration_s).joint_state(0));
    assert!((analytic.angle_rad - engine.angle_rad).abs() < 2e-5, "{analytic:?} {engine:?}");
}

/// Angles q11, q12, q21 and q22 of both fingers, and the position of the object, at the end of a run.
struct GripperEnd {
    name: &'static str,
    fingers_rad: [[f64; 4]; 2],
    object_m: [f64; 2],
}

/// Ends after 100 ms by the closed form of a gripper, a kernel that the model had until November 2026.
const GRIPPERS_BY_CLOSED_FORM: [GripperEnd; 2] = [
    GripperEnd {
        name: "lift",
        fingers_rad: [[0.03633040722879805, 1.409413636229334, 1.1355431203838837, -1.058323148235351]; 2],
        object_m: [0.0, 0.020012750335567132],
    },
    GripperEnd {
        name: "cycle-fast",
        fingers_rad: [
            [0.03645783838131098, 1.408994211542445, 1.1352389814686343, -1.057453446855748],
            [0.036451544504188686, 1.4086568860683601, 1.134885495856049, -1.0567537166948686],
        ],
        object_m: [-2.1375526838851304e-06, 0.020000751444204917],
    },
];

/// Grippers on a moving palm end as the closed form of a gripper does.
#[test]
fn grippers_on_a_moving_palm_end_as_by_their_closed_form() {
    for GripperEnd { name, fingers_rad, object_m } in GRIPPERS_BY_CLOSED_FORM {
        let mut scene =
            scene::load_any(format!("scenes/gripper/{name}.toml")).unwrap_or_else(|error| panic!("{error}"));
        (scene.integrator, scene.duration_s) = (Integrator::preset(Preset::Reference), 0.1);
        let found = end_of(Model::Analytic, &scene);
        for (finger, expected) in found.fingers().zip(fingers_rad) {
            let angles = [finger.q11_rad, finger.q12_rad, finger.q21_rad, finger.q22_rad];
            for (found, expected) in angles.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-8, "{name}: {angles:?}");
            }
        }
        let [x, y] = [0, 1].map(|k| (found.body(0).centre_m[k] - object_m[k]).abs());
        assert!(x < 1e-9 && y < 1e-9, "{name}: {:?}", found.body(0));
    }
}

/// A gondola that does not rotate is a point mass for the wheel that carries it, and the block of a slider-crank does not
/// rotate anyhow.
#[test]
fn bodies_that_do_not_rotate_move_as_point_masses() {
    let wheel = |with_gondola: bool| {
        let mut mechanism = Mechanism {
            gravity_m_s2: GRAVITY,
            bodies: vec![body("wheel", [0.0; 2], None)],
            joints: vec![pin("axle", [None, Some(0)], [[0.0; 2]; 2], Some(0.5))],
            ..Mechanism::default()
        };
        match with_gondola {
            true => {
                let mut gondola = body("gondola", [0.0, -0.02], None);
                (gondola.inertia_kg_m2, gondola.pose) = (f64::INFINITY, [0.05, 0.0, 0.0]);
                mechanism.bodies.push(gondola);
                mechanism.joints.push(pin("hinge", [Some(0), Some(1)], [[0.05, 0.0], [0.0; 2]], None));
            }
            false => {
                let wheel = &mut mechanism.bodies[0];
                wheel.com_m = [0.025, 0.0];
                wheel.mass_kg = 0.2;
                // The masses of 0.1 kg at 0 and 50 mm.
                wheel.inertia_kg_m2 += 0.2 * 0.025 * 0.025;
            }
        }
        mechanism
    };
    let expected = end_of_mechanism(Model::Analytic, &wheel(false), 0.3).joint_state(0);
    for (model, allowed) in [(Model::Analytic, 1e-10), (Model::Engine, 1e-6)] {
        let found = end_of_mechanism(model, &wheel(true), 0.3);
        let axle = found.joint_state(0);
        assert!((axle.angle_rad - expected.angle_rad).abs() < allowed, "{model:?}: {axle:?} {expected:?}");
        assert!(found.body(1).angle_rad.abs() < 1e-12, "{model:?}: {:?}", found.body(1));
    }
    let slider_crank = |inertia_kg_m2: f64| {
        let mut block = body("block", [0.0; 2], None);
        (block.inertia_kg_m2, block.pose) = (inertia_kg_m2, [0.11, 0.0, 0.0]);
        let mut slide = pin("slide", [None, Some(2)], [[0.0; 2]; 2], None);
        slide.kind = JointKind::Prismatic { axis_rad: 0.0 };
        Mechanism {
            gravity_m_s2: GRAVITY,
            bodies: vec![body("crank", [0.02, 0.0], None), body("rod", [0.04, 0.0], None), block],
            joints: vec![
                pin("crank", [None, Some(0)], [[0.0; 2]; 2], Some(0.9)),
                pin("rod", [Some(0), Some(1)], [[0.04, 0.0], [0.0; 2]], None),
                pin("wrist", [Some(1), Some(2)], [[0.08, 0.0], [0.0; 2]], None),
                slide,
            ],
            ..Mechanism::default()
        }
    };
    for (model, allowed) in [(Model::Analytic, 1e-12), (Model::Engine, 1e-6)] {
        let [turning, still] = [1e-5, f64::INFINITY].map(|inertia| {
            let sample = end_of_mechanism(model, &slider_crank(inertia), 0.2);
            (0..3).map(|joint| sample.joint_state(joint).angle_rad).collect::<Vec<_>>()
        });
        let difference = turning.iter().zip(&still).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference < allowed, "{model:?}: {turning:?} {still:?}");
    }
}

/// A body that does not rotate cannot slide on one that does: the engine model stops the latter.
#[test]
fn a_slider_that_does_not_rotate_on_a_turning_body_is_refused_by_name() {
    let mut slider = body("slider", [0.0; 2], None);
    slider.inertia_kg_m2 = f64::INFINITY;
    let mut slide = pin("slide", [Some(0), Some(1)], [[0.0; 2]; 2], Some(0.01));
    slide.kind = JointKind::Prismatic { axis_rad: 0.0 };
    let mechanism = Mechanism {
        bodies: vec![body("arm", [0.0; 2], None), slider],
        joints: vec![pin("axle", [None, Some(0)], [[0.0; 2]; 2], Some(0.0)), slide],
        ..Mechanism::default()
    };
    let error = find_groups(&mechanism).expect_err("a refusal").to_string();
    assert!(error.starts_with("the joint of the body `slider`, which does not rotate,"), "{error}");
    assert!(error.contains("--model engine"), "{error}");
}
