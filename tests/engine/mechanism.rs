//! Mechanisms in the engine model, against reference solutions of an independent program.

use crate::support::mechanism_cases::{MechanismCase, MechanismSample, all_cases};
use phalanx::drive::{Interpolation, Profile};
use phalanx::engine::{
    Linkage, Motion, PalmFrame, Plan, PlannedJoint, StepError, Tolerance, build_mechanism_plan, build_world,
    kinetic_energy, next_step, potential_energies,
};
use phalanx::law::{Damping, NormalLaw};
use phalanx::mechanism::{
    Actuator, Body, Command, Coupling, Joint, JointKind, Mechanism, Spring, SpringKind, assemble,
};
use phalanx::scene::{Engine, Stepping};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Largest differences of angles, rad, and of positions, m.
fn differences(case: &MechanismCase, plan: &Plan, linkage: &Linkage, expected: &MechanismSample) -> [f64; 2] {
    let [mut angle, mut position] = [0.0f64; 2];
    for ((body, pose), expected) in case.mechanism.bodies.iter().zip(&linkage.poses).zip(&expected.poses) {
        let ([x, y], [c, s]) = (body.com_m, pose.direction);
        let origin = [pose.com[0] - (c * x - s * y), pose.com[1] - (s * x + c * y)];
        angle = angle.max((pose.angle - expected[2]).abs());
        position = position.max((origin[0] - expected[0]).abs()).max((origin[1] - expected[1]).abs());
    }
    for (joint, [q, _]) in plan.joints.iter().zip(&expected.joints) {
        let difference = (plan.joint_coordinate(joint).value(&linkage.poses) - q).abs();
        let largest = if joint.kind == JointKind::Revolute { &mut angle } else { &mut position };
        *largest = largest.max(difference);
    }
    [angle, position]
}

/// Energy less the work put in, J.
fn balance(motion: &Motion) -> f64 {
    let frame = PalmFrame::at(motion.plan, motion.clock.now());
    let (gravity, springs) = potential_energies(motion.plan, &motion.linkage, &frame);
    kinetic_energy(&motion.linkage, &motion.velocities, &frame) + gravity + springs
        - motion.motor_work_j
        - motion.contact_work_j
}

/// Motion of a plan at its start, with the default settings of the engine.
fn start(plan: &Plan) -> Motion<'_> {
    let Engine { construction, response, stepping, iterations, .. } = Engine::DEFAULT;
    let Stepping::Adaptive { tolerance_m, .. } = stepping else { panic!("adaptive steps by default") };
    let mut motion = Motion::new(plan, build_world(plan, construction, response, iterations)).expect("a motion");
    motion.tolerance_m = tolerance_m;
    motion.contact.tolerance = Tolerance::from_stepping(stepping);
    motion
}

fn advance_to(motion: &mut Motion, stepping: Stepping, time_s: f64) {
    while motion.clock.now() < time_s {
        let mut dt = next_step(motion, stepping, time_s);
        while let Err(error) = motion.advance(dt, &|| true) {
            assert!(matches!(error, StepError::TooLong { .. }), "{error}");
            dt *= 0.25;
        }
    }
}

#[test]
fn anchors_of_mechanisms_are_met_at_all_samples() {
    for case in all_cases() {
        let plan = build_mechanism_plan(&case.mechanism, &case.start);
        let mut motion = start(&plan);
        let start_j = balance(&motion);
        for sample in &case.samples {
            advance_to(&mut motion, Engine::DEFAULT.stepping, sample.time_s);
            let [angle_rad, position_m] = differences(&case, &plan, &motion.linkage, sample);
            let error_j = (balance(&motion) - start_j).abs();
            let (name, time_s) = (&case.name, sample.time_s);
            assert!(angle_rad < 1e-4 && position_m < 1e-5, "{name} at {time_s} s: {angle_rad:e} rad, {position_m:e} m");
            assert!(error_j < 2e-5, "{name} at {time_s} s: {error_j:e} J of energy are created");
        }
    }
}

/// A body of 1 g and 1e-7 kg·m² at the origin.
fn body() -> Body {
    Body {
        name: "body".into(),
        mass_kg: 1e-3,
        inertia_kg_m2: 1e-7,
        com_m: [0.0; 2],
        pose: [0.0; 3],
        rate: [0.0; 3],
        outlines: Vec::new(),
    }
}

/// A joint between the ground and a body.
fn joint(kind: JointKind, body: usize, start: f64, start_rate: f64) -> Joint {
    Joint {
        name: "joint".into(),
        kind,
        bodies: [None, Some(body)],
        points_m: [[0.0; 2]; 2],
        offset_rad: 0.0,
        start: Some(start),
        start_rate,
        damping: 0.0,
        armature: 0.0,
        lower: None,
        upper: None,
        limit: None,
    }
}

fn spring(joint: usize, stiffness: f64) -> Spring {
    let kind = SpringKind::Torsional { joint, preload: 0.0 };
    Spring { name: "spring".into(), kind, stiffness, damping: 0.0, rest: 0.0 }
}

/// Coordinates and rates of all joints after `time_s`, and the energy that the run creates.
fn joints_after(mechanism: &Mechanism, time_s: f64) -> (Vec<[f64; 2]>, f64) {
    let plan = build_mechanism_plan(mechanism, &assemble(mechanism).expect("an assembly"));
    let mut motion = start(&plan);
    let start_j = balance(&motion);
    advance_to(&mut motion, Engine::DEFAULT.stepping, time_s);
    let state = |joint: &PlannedJoint| {
        let coordinate = plan.joint_coordinate(joint);
        let poses = &motion.linkage.poses;
        [coordinate.value(poses), coordinate.row(poses).rate(&motion.velocities)]
    };
    (plan.joints.iter().map(state).collect(), balance(&motion) - start_j)
}

/// Two sliders at right angles with q₁ = 2 q₂, rotor inertia, spring and damper: a damped oscillator.
#[test]
fn coupled_sliders_with_armature_oscillate_as_in_closed_form() {
    let axes = [0.3, 0.3 + FRAC_PI_2];
    let mut joints = [0, 1].map(|k| joint(JointKind::Prismatic { axis_rad: axes[k] }, k, 0.02 / (k as f64 + 1.0), 0.0));
    joints[1].start = None;
    joints[1].armature = 2e-3;
    joints[0].damping = 0.05;
    let mechanism = Mechanism {
        bodies: vec![body(), body()],
        joints: joints.to_vec(),
        couplings: vec![Coupling { name: "gear".into(), terms: vec![(0, 1.0), (1, -2.0)], value: 0.0 }],
        springs: vec![spring(0, 40.0)],
        ..Mechanism::default()
    };
    let (mass, time_s): (f64, f64) = (1e-3 + (1e-3 + 2e-3) / 4.0, 0.05);
    let decay = 0.05 / (2.0 * mass);
    let frequency = (40.0 / mass - decay * decay).sqrt();
    let (sin, cos) = (frequency * time_s).sin_cos();
    let expected = 0.02 * (-decay * time_s).exp() * (cos + decay / frequency * sin);
    let (found, created_j) = joints_after(&mechanism, time_s);
    assert!((found[0][0] - expected).abs() < 1e-6, "{found:?}, expected {expected}");
    assert!((found[0][0] - 2.0 * found[1][0]).abs() < 1e-9, "{found:?}");
    assert!(created_j.abs() < 1e-6, "{created_j:e} J");
}

/// A torsional oscillator of 1 kHz whose centre of mass is at rest: step sizes must take its rotation into account.
#[test]
fn rotation_about_the_centre_of_mass_limits_steps() {
    let mechanism = Mechanism {
        bodies: vec![body()],
        joints: vec![joint(JointKind::Revolute, 0, 0.1, 0.0)],
        springs: vec![spring(0, 1e-7 * (TAU * 1e3) * (TAU * 1e3))],
        ..Mechanism::default()
    };
    let (found, created_j) = joints_after(&mechanism, 0.01);
    assert!((found[0][0] - 0.1).abs() < 1e-4, "{found:?}");
    assert!(created_j.abs() < 1e-6, "{created_j:e} J");
}

/// A velocity servo with a time constant of 1e-10 s follows its table at once.
#[test]
fn stiff_velocity_servo_follows_its_target() {
    let points = vec![(0.0, 0.0), (0.005, 0.1), (0.01, 0.0)];
    let target = Profile::Table { points, interpolation: Interpolation::Linear };
    let mechanism = Mechanism {
        bodies: vec![body()],
        joints: vec![joint(JointKind::Revolute, 0, 0.0, 0.0)],
        actuators: vec![Actuator {
            name: "servo".into(),
            joint: 0,
            command: Command::Servo { kp: 0.0, kd: 1e3, target },
            limit: None,
            no_load_speed: None,
        }],
        ..Mechanism::default()
    };
    for (time_s, expected) in [(0.004, [0.08, 20.0]), (0.008, [0.04, -20.0])] {
        let (found, created_j) = joints_after(&mechanism, time_s);
        assert!((found[0][0] - expected[0]).abs() < 1e-6, "{found:?}, expected {expected:?}");
        assert!((found[0][1] - expected[1]).abs() < 1e-4, "{found:?}, expected {expected:?}");
        assert!(created_j.abs() < 1e-6, "{created_j:e} J");
    }
}

/// The closed form of a rebound, at both limits of a slider.
#[test]
fn sliders_rebound_from_their_limits_as_in_closed_form() {
    let damping = Damping::HuntCrossley { factor_s_per_m: 0.3 };
    let law = NormalLaw { stiffness_n_per_m_e: 1e7, exponent: 1.5, damping };
    let limited = |rate: f64| Joint {
        lower: Some(-1e-3),
        upper: Some(1e-3),
        limit: Some(law),
        ..joint(JointKind::Prismatic { axis_rad: 0.4 }, 0, 0.0, rate)
    };
    for rate in [-1.0, 1.0] {
        let mechanism = Mechanism { bodies: vec![body()], joints: vec![limited(rate)], ..Mechanism::default() };
        let (found, created_j) = joints_after(&mechanism, 1.5e-3);
        assert!((found[0][1] + rate * 0.7679997890785).abs() < 1e-4, "{found:?}");
        assert!(created_j.abs() < 1e-6, "{created_j:e} J");
    }
}
