//! Mechanisms in the engine model, against reference solutions of an independent program.

use crate::support::laws::THESIS_FRICTION;
use crate::support::mechanism_cases::{MechanismCase, all_cases, cable_cases, drive_cases, mechanism_case};
use crate::support::runs::{CollectSink, experiment_95, seeds};
use crate::support::scenes::scene_text;
use crate::support::scenes::trees::{random_mechanism, random_moving_mechanism, random_variant};
use phalanx::drive::{Interpolation, Profile};
use phalanx::law::{
    Bristle, Damping, FrictionKind, FrictionLaw, NormalLaw, damping_from_restitution, friction_coefficient,
    stopping_depth,
};
use phalanx::mechanism::{
    Actuator, Body, Command, Coupling, ForcePoint, Joint, JointCombination, JointKind, Mechanism, OutlineShape,
    Powertrain, Spring, SpringKind,
};
use phalanx::scene::{ENGINE_MAX_STEP_S, Integrator, Preset, Response, Scene, Stepping, parse_any};
use phalanx::trace::{self, BodyState, EventKind, Model, Sample};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A scene of a mechanism with the default tolerance of its kind and a sample at every multiple of an interval.
fn scene(mechanism: &Mechanism, duration_s: f64, interval_s: f64) -> Scene {
    let mut scene = experiment_95();
    scene.hand.fingers.clear();
    scene.hand.object = None;
    scene.mechanism = Some(mechanism.clone());
    scene.duration_s = duration_s;
    scene.engine.stepping = Stepping::Adaptive { tolerance_m: 3e-8, max_step_s: ENGINE_MAX_STEP_S };
    scene.log.numeric_hz = 1.0 / interval_s;
    scene
}

fn run(model: Model, scene: &Scene) -> CollectSink {
    let mut run = CollectSink::default();
    trace::run(model, scene, &mut run).unwrap_or_else(|error| panic!("{error}"));
    run
}

/// Largest difference of a run from the samples of a case: angles, rad, and positions, m.
fn difference(case: &MechanismCase, run: &CollectSink) -> [f64; 2] {
    let [mut angle, mut position] = [0.0f64; 2];
    for expected in &case.samples {
        let is_at = |sample: &&Sample| (sample.time_s - expected.time_s).abs() < 1e-9;
        let found = run.samples.iter().rfind(is_at).unwrap_or_else(|| panic!("no sample at {} s", expected.time_s));
        for (body, [x, y, theta]) in found.bodies().zip(&expected.poses) {
            angle = angle.max((body.angle_rad - theta).abs());
            position = position.max((body.centre_m[0] - x).abs()).max((body.centre_m[1] - y).abs());
        }
        for (index, (joint, [q, _])) in case.mechanism.joints.iter().zip(&expected.joints).enumerate() {
            let difference = (found.joint_state(index).angle_rad - q).abs();
            let largest = if joint.kind == JointKind::Revolute { &mut angle } else { &mut position };
            *largest = largest.max(difference);
        }
    }
    [angle, position]
}

/// Prints the rows of the table in `src/docs/engine.md`.
#[test]
fn reference_solutions_are_met_at_default_settings() {
    for case in all_cases().into_iter().chain(drive_cases()).chain(cable_cases()) {
        let found = run(Model::Engine, &scene(&case.mechanism, case.duration_s, case.samples[1].time_s));
        let ([angle_rad, position_m], name) = (difference(&case, &found), &case.name);
        println!("| {name} | {angle_rad:.1e} | {position_m:.1e} |");
        assert!(angle_rad < 1e-4 && position_m < 1e-5, "{name}: {angle_rad:e} rad, {position_m:e} m");
        let created_j = found.samples.iter().map(|sample| sample.energy().balance_j.abs()).fold(0.0, f64::max);
        assert!(created_j < 2e-5, "{name}: {created_j:e} J of energy are created");
        for (time_s, event, _) in case.events.iter().filter(|(_, event, rises)| *rises && event.ends_with(" touch")) {
            let touches = found.events.iter().filter(|event| event.kind == EventKind::TouchDown);
            let nearest = touches.map(|event| (event.time_s - time_s).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 2e-5, "{name}: {event} at {time_s} s is missed by {nearest:e} s");
        }
        let last = (case.samples.last().expect("a sample"), found.samples.last().expect("a sample"));
        for (index, effort) in last.0.actuators.iter().enumerate() {
            let found = last.1.actuator(index);
            assert!((found - effort).abs() < 1e-3 * effort.abs().max(0.1), "{name}: effort {found}, {effort}");
        }
        for (index, [length_m, tension_n]) in last.0.tendons.iter().enumerate() {
            let found = last.1.tendon(index);
            assert!((found.length_m - length_m).abs() < 1e-6, "{name}: {found:?}, length {length_m}");
            assert!((found.tension_n - tension_n).abs() < 1e-2 * tension_n, "{name}: {found:?}, tension {tension_n}");
        }
        for (index, contact) in case.mechanism.point_contacts().iter().enumerate() {
            let Some(expected) = last.0.contacts.get(&contact.name) else { continue };
            let found = last.1.contact(index);
            let scale = 1e-2 * expected.normal_force_n.max(0.1);
            assert!((found.normal_n - expected.normal_force_n).abs() < scale, "{name}: {found:?}");
            assert!((found.tangential_n - expected.friction_force_n).abs() < scale, "{name}: {found:?}");
            assert!((found.slip_m_s - expected.slip_m_s).abs() < 1e-3, "{name}: {found:?}");
        }
    }
}

/// Forces of all joints, N, and moments of guides, N·m, against the analytic model, which computes them from the
/// balance of each body. Contact forces change within microseconds: in c_f85_step, 16 µs after the pad begins to stick,
/// they differ by 0.6 %, and at five times the tolerance by 1 to 3 %, depending on where the instant lies in its step.
#[test]
fn joint_forces_agree_in_both_models() {
    for case in all_cases().into_iter().chain(drive_cases()).chain(cable_cases()) {
        let mut scene = scene(&case.mechanism, case.duration_s, case.samples[1].time_s);
        // Forces are second derivatives: in an impact they need smaller steps than positions.
        scene.engine.stepping = Stepping::Adaptive { tolerance_m: 2e-9, max_step_s: ENGINE_MAX_STEP_S };
        let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| run(model, &scene));
        let tolerance = if case.mechanism.contacts.is_empty() { 5e-3 } else { 1e-2 };
        for joint in 0..case.mechanism.joints.len() {
            let forces = |run: &CollectSink| {
                let at = |time_s: f64| run.samples.iter().rfind(|sample| (sample.time_s - time_s).abs() < 1e-9);
                let state = |sample: &Sample| sample.joint_state(joint);
                let states = case.samples.iter().filter_map(|sample| at(sample.time_s)).map(state);
                states.map(|state| [state.force_n[0], state.force_n[1], state.moment_n_m]).collect::<Vec<_>>()
            };
            let (analytic, engine) = (forces(&analytic), forces(&engine));
            let largest = |k: &[usize]| {
                let values = analytic.iter().flat_map(|force| k.iter().map(|k| force[*k].abs()));
                values.fold(1e-3, f64::max)
            };
            let scales = [largest(&[0, 1]), largest(&[0, 1]), largest(&[2])];
            for (sample, (a, b)) in case.samples.iter().zip(analytic.iter().zip(&engine)) {
                for k in 0..3 {
                    let error = (a[k] - b[k]).abs() / scales[k];
                    assert!(error < tolerance, "{} at {} s: joint {joint}: {a:?}, {b:?}", case.name, sample.time_s);
                }
            }
        }
    }
}

/// What the reference solutions do not contain: other force points, capsules as points, limits of a slider on a moving
/// body, a coupling of two fingers, dampers, and a servo with a no-load speed.
#[test]
fn variants_of_the_reference_cases_agree_in_both_models() {
    let stop =
        NormalLaw { stiffness_n_per_m_e: 1e6, exponent: 1.5, damping: Damping::HuntCrossley { factor_s_per_m: 0.3 } };
    let force_point = |m: &mut Mechanism, point| m.contacts.iter_mut().for_each(|contact| contact.force_point = point);
    type Change<'a> = &'a dyn Fn(&mut Mechanism);
    let variants: [(&str, &str, Change<'_>); 9] = [
        ("c_f85_two_disc", "force on the points", &|m| force_point(m, ForcePoint::Points)),
        ("c_f85_two_disc", "force in the middle", &|m| force_point(m, ForcePoint::Middle)),
        ("c_f85_two_disc", "coupled drivers, one motor", &|m| {
            let drivers: Vec<_> = m.actuators.iter().map(|actuator| actuator.on.terms[0]).collect();
            m.joints[drivers[1].0].start = None;
            m.couplings.push(Coupling { name: "gear".into(), on: JointCombination { terms: drivers, offset: 0.0 } });
            m.actuators.truncate(1);
        }),
        ("g_ball", "capsule with friction", &|m| {
            m.bodies[0].outlines[0].shape =
                OutlineShape::Capsule { from_m: [-0.01, 0.0], to_m: [0.012, 0.002], radius_m: 0.02 };
            m.contacts[0].law.friction = Some(THESIS_FRICTION);
        }),
        ("b_swinging_slider", "limits", &|m| {
            (m.joints[1].lower, m.joints[1].upper, m.joints[1].limit) = (Some(0.035), Some(0.06), Some(stop));
        }),
        ("b_four_bar", "dampers", &|m| {
            m.joints[1].damping = 1e-4;
            m.springs[0].damping = 0.5;
        }),
        ("d_tendon2", "stiff cable, taut after a slack start, with an actuator", &|m| {
            let flexor = &mut m.tendons[0];
            (flexor.stiffness_n_per_m, flexor.damping_n_s_per_m, flexor.rest_m) = (2e4, 5.0, 0.132);
        }),
        ("e_tendon3", "undamped cable, slack at the start", &|m| {
            let flexor = &mut m.tendons[0];
            (flexor.damping_n_s_per_m, flexor.rest_m) = (0.0, flexor.rest_m + 3e-4);
        }),
        ("h_pd_saturated", "no-load speed", &|m| m.actuators[0].no_load_speed = Some(20.0)),
    ];
    for (name, variant, change) in variants {
        let mut case = mechanism_case(name);
        change(&mut case.mechanism);
        let scene = scene(&case.mechanism, case.duration_s, case.samples[1].time_s);
        let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| {
            let last = run(model, &scene).samples.pop().expect("a sample");
            assert!(last.energy().balance_j.abs() < 2e-5, "{name}, {variant}: {:?}", last.energy());
            last
        });
        for (a, b) in analytic.bodies().zip(engine.bodies()) {
            let angle = (a.angle_rad - b.angle_rad).abs();
            let position = (a.centre_m[0] - b.centre_m[0]).abs().max((a.centre_m[1] - b.centre_m[1]).abs());
            assert!(angle < 1e-4 && position < 1e-5, "{name}, {variant}: {angle:e} rad, {position:e} m");
        }
    }
}

/// Halving fixed steps divides the difference by eight, with contact by four.
#[test]
fn mechanisms_are_simulated_with_third_order_and_contact_with_second() {
    for (name, least_ratio) in [("b_slider_crank", 7.5), ("c_f85_link_pad", 3.5)] {
        let case = mechanism_case(name);
        let angle = |step_s: f64| {
            let mut scene = scene(&case.mechanism, case.duration_s, case.samples[1].time_s);
            scene.engine.stepping = Stepping::Fixed { step_s };
            difference(&case, &run(Model::Engine, &scene))[0]
        };
        let [coarse, fine] = [2e-5, 1e-5].map(angle);
        assert!(coarse > least_ratio * fine, "{name}: {coarse:e} rad, {fine:e} rad");
    }
}

#[test]
fn rapiers_own_contact_is_refused_for_mechanisms_with_joints() {
    let case = mechanism_case("b_four_bar");
    let mut scene = scene(&case.mechanism, case.duration_s, case.duration_s);
    scene.engine.response = Response::Rapier { friction: 0.5, restitution: 0.0 };
    let reason = trace::run(Model::Engine, &scene, &mut ()).expect_err("a refusal").to_string();
    assert!(reason.contains("law \"rapier\""), "{reason}");
}

/// A body of 1 g and 1e-7 kg·m² at the origin.
fn body() -> Body {
    Body::new("body", 1e-3, 1e-7)
}

/// A joint between the ground and a body.
fn joint(kind: JointKind, body: usize, start: f64, start_rate: f64) -> Joint {
    Joint { start: Some(start), start_rate, ..Joint::new("joint", kind, [None, Some(body)], [[0.0; 2]; 2]) }
}

fn spring(joint: usize, stiffness: f64) -> Spring {
    let kind = SpringKind::Torsional { on: JointCombination::of_joint(joint), preload: 0.0 };
    Spring { name: "spring".into(), kind, stiffness, damping: 0.0, rest: 0.0 }
}

/// Coordinates and rates of all joints after `time_s`, and the energy that the run creates.
fn joints_after(mechanism: &Mechanism, time_s: f64) -> (Vec<[f64; 2]>, f64) {
    let run = run(Model::Engine, &scene(mechanism, time_s, time_s));
    let last = run.samples.last().expect("a sample");
    let state = |index: usize| last.joint_state(index);
    let joints = (0..mechanism.joints.len()).map(state).map(|joint| [joint.angle_rad, joint.rate_rad_s]);
    (joints.collect(), last.energy().balance_j)
}

/// A rolling disc of mass m, radius r and inertia J with the arm ρ of rolling resistance slows down by ρ g/(r (1 + J/(m r²))).
#[test]
fn rolling_resistance_slows_a_disc_as_in_closed_form() {
    let (radius, arm, speed, time_s): (f64, f64, f64, f64) = (0.02, 5e-4, 0.5, 0.3);
    let mut mechanism = mechanism_case("g_ball").mechanism;
    let friction = FrictionLaw {
        mu_static: 0.8,
        mu_dynamic: 0.8,
        v_static_m_s: 1e-3,
        v_dynamic_m_s: 2e-3,
        kind: FrictionKind::Regularised,
    };
    mechanism.gravity_m_s2 = [0.0, -9.81];
    mechanism.contacts[0].law.friction = Some(friction);
    mechanism.contacts[0].rolling = Some(FrictionLaw {
        mu_static: arm,
        mu_dynamic: arm,
        v_static_m_s: 0.1,
        v_dynamic_m_s: 0.2,
        kind: FrictionKind::Regularised,
    });
    let law = mechanism.contacts[0].law.normal;
    let ball = &mut mechanism.bodies[0];
    let depth = (ball.mass_kg * 9.81 / law.stiffness_n_per_m_e).powf(law.exponent.recip());
    (ball.pose, ball.rate) = ([0.0, radius - depth, 0.0], [speed, 0.0, -speed / radius]);
    let deceleration = arm * 9.81 / (radius * (1.0 + ball.inertia_kg_m2 / (ball.mass_kg * radius * radius)));
    let expected = -(speed - deceleration * time_s) / radius;
    for model in [Model::Analytic, Model::Engine] {
        let last = run(model, &scene(&mechanism, time_s, time_s)).samples.pop().expect("a sample");
        let spin = last.body(0).spin_rad_s;
        assert!((spin - expected).abs() < 2e-3 * expected.abs(), "{model:?}: {spin}, {expected}");
        assert!(last.energy().balance_j.abs() < 1e-6, "{model:?}: {:?}", last.energy());
    }
}

/// A free mass rebounds with the coefficient of restitution of its law, whatever its mass, stiffness and speed.
#[test]
fn laws_given_by_restitution_rebound_accordingly() {
    for (mass_kg, stiffness, exponent, speed, restitution) in [
        (1e-3, 1e6, 1.5, 1e-2, 0.2),
        (1.0, 1e6, 1.5, 0.1, 0.5),
        (50.0, 1e8, 1.5, 1.0, 0.7),
        (0.1, 1e4, 1.0, 10.0, 0.9),
        (1e-2, 1e9, 2.2, 0.3, 0.98),
    ] {
        let damping = damping_from_restitution(restitution, speed);
        let mut mechanism = mechanism_case("g_ball").mechanism;
        let ball = &mut mechanism.bodies[0];
        (ball.mass_kg, ball.pose, ball.rate) = (mass_kg, [0.0, 0.02 + 1e-3 * speed, 0.0], [0.0, -speed, 0.0]);
        mechanism.contacts[0].law.normal = NormalLaw { stiffness_n_per_m_e: stiffness, exponent, damping };
        let depth = stopping_depth(&mechanism.contacts[0].law.normal, speed, 1.0 / mass_kg);
        let mut scene = scene(&mechanism, 2e-3 + 40.0 * depth / (restitution * speed), 1e-3);
        scene.integrator = scene.integrator.with_rtol(1e-9);
        for (model, tolerance) in [(Model::Analytic, 1e-6), (Model::Engine, 2e-3)] {
            let last = run(model, &scene).samples.pop().expect("a sample");
            let (rebound, expected) = (last.body(0).velocity_m_s[1], restitution * speed);
            assert!((rebound - expected).abs() < tolerance * speed, "{model:?}: {rebound}, {expected} of {mass_kg} kg");
        }
    }
}

/// Friction τ slows a joint down at τ/J. Below the largest friction, a torque T holds it at the rate at which the law is
/// T, or turns it by T over the stiffness of its bristle.
#[test]
fn friction_of_joints_acts_as_in_closed_form() {
    let (torque, dynamic, largest, inertia) = (6e-4, 1e-3, 1.2e-3, 1e-5);
    let law = |bristle: Option<Bristle>| FrictionLaw {
        mu_static: largest,
        mu_dynamic: dynamic,
        v_static_m_s: 0.02,
        v_dynamic_m_s: 0.04,
        kind: bristle.into(),
    };
    let bristle = Bristle { damping_n_s_per_m: 2e-3, relaxation_s: 1e-3 };
    let rotor = |rate: f64, torque: f64, friction| {
        let mut mechanism = Mechanism { bodies: vec![body()], ..Mechanism::default() };
        mechanism.joints = vec![Joint {
            friction: Some(friction),
            armature: inertia - 1e-7,
            ..joint(JointKind::Revolute, 0, 0.0, rate)
        }];
        mechanism.actuators = vec![Actuator {
            name: "motor".into(),
            on: JointCombination::of_joint(0),
            command: Command::Effort(Profile::Constant { value: torque }),
            limit: None,
            no_load_speed: None,
            brake: None,
            powertrain: Powertrain::default(),
        }];
        mechanism
    };
    for model in [Model::Analytic, Model::Engine] {
        let after = |mechanism: &Mechanism, time_s: f64| {
            let last = run(model, &scene(mechanism, time_s, time_s)).samples.pop().expect("a sample");
            assert!(last.energy().balance_j.abs() < 1e-9, "{model:?}: {:?}", last.energy());
            [last.joint_state(0).angle_rad, last.joint_state(0).rate_rad_s]
        };
        let slowing = |rate: f64, t: f64| [rate * t - 0.5 * dynamic / inertia * t * t, rate - dynamic / inertia * t];
        for (friction, name) in [(law(None), "regularised"), (law(Some(bristle)), "bristle")] {
            let [found, expected] = [after(&rotor(5.0, 0.0, friction), 0.03), slowing(5.0, 0.03)];
            for k in 0..2 {
                assert!((found[k] - expected[k]).abs() < 1e-4, "{model:?}, {name}: {found:?}, {expected:?}");
            }
        }
        let [_, creep] = after(&rotor(0.0, torque, law(None)), 0.2);
        let held = friction_coefficient(&law(None), creep).0;
        assert!((held - torque).abs() < 1e-3 * torque && creep > 0.0, "{model:?}: {creep} rad/s, {held} N·m");
        let [held, rate] = after(&rotor(0.0, torque, law(Some(bristle))), 0.2);
        let deflection = torque * bristle.relaxation_s / bristle.damping_n_s_per_m;
        assert!((held - deflection).abs() < 1e-3 * deflection, "{model:?}: {held}, {deflection}");
        assert!(rate.abs() < 1e-6, "{model:?}: {rate}");
    }
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
        couplings: vec![Coupling {
            name: "gear".into(),
            on: JointCombination { terms: vec![(0, 1.0), (1, -2.0)], offset: 0.0 },
        }],
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

/// Gear pairs, and racks on pinions, are couplings: a weight on a rack drives a pinion and a wheel, as one mass of
/// m + J₁/r₁² + J₂/r₂².
#[test]
fn a_rack_and_a_gear_pair_accelerate_as_one_mass() {
    let mut text = "kind = \"mechanism\"\nduration = \"50 ms\"\ngravity = [\"0 m/s^2\", \"-9.81 m/s^2\"]\n\
                    [couplings.rack]\njoints = [\"rack\", \"pinion\"]\nfactors = [1, -0.012]\n\
                    [couplings.gears]\njoints = [\"pinion\", \"wheel\"]\nfactors = [0.012, 0.03]\n"
        .to_string();
    let slides = "type = \"prismatic\"\naxis = \"90 deg\"\nstart = \"0 m\"";
    for (name, mass, inertia, keys) in
        [("rack", "50 g", "1e-5", slides), ("pinion", "20 g", "3e-6", ""), ("wheel", "60 g", "4e-5", "")]
    {
        text += &format!(
            "[bodies.{name}]\nmass = \"{mass}\"\ninertia = \"{inertia} kg*m^2\"\n[joints.{name}]\n{keys}\n\
             bodies = [\"ground\", \"{name}\"]\npoints = [[\"0 m\", \"0 m\"], [\"0 m\", \"0 m\"]]\n"
        );
    }
    let mut scene = parse_any(&text, "gears.toml").unwrap_or_else(|error| panic!("{error}"));
    scene.engine.stepping = Stepping::Adaptive { tolerance_m: 3e-8, max_step_s: ENGINE_MAX_STEP_S };
    let mass = 0.05 + 3e-6 / (0.012 * 0.012) + 4e-5 / (0.03 * 0.03);
    let fallen = -0.5 * 0.05 * 9.81 / mass * 0.05 * 0.05;
    for model in [Model::Analytic, Model::Engine] {
        let end = run(model, &scene).samples.pop().expect("a sample");
        let found = [0, 1, 2].map(|joint| end.joint_state(joint).angle_rad);
        let expected = [fallen / 0.012, fallen, -fallen / 0.03];
        for k in 0..3 {
            assert!((found[k] - expected[k]).abs() < 1e-6 * expected[k].abs(), "{model:?}: {found:?} {expected:?}");
        }
        assert!(end.energy().balance_j.abs() < 1e-9, "{model:?}: {:?}", end.energy());
    }
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
            on: JointCombination::of_joint(0),
            command: Command::Servo { kp: 0.0, kd: 1e3, target, target_rate: None, rate_hz: None },
            limit: None,
            no_load_speed: None,
            brake: None,
            powertrain: Powertrain::default(),
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

/// Largest difference of the bodies at the end of a run, in rad or 0.1 m.
fn end_difference(a: &Sample, b: &Sample) -> f64 {
    let difference = |(a, b): (BodyState, BodyState)| {
        let [x, y] = [0, 1].map(|axis| (a.centre_m[axis] - b.centre_m[axis]).abs());
        (a.angle_rad - b.angle_rad).abs().max(10.0 * x.max(y))
    };
    a.bodies().zip(b.bodies()).map(difference).fold(0.0, f64::max)
}

/// Random mechanisms over 20 ms. The engine passes the singular configurations at which the analytic model ends.
#[test]
fn random_mechanisms_agree_in_both_models() {
    assert_agreement(random_mechanism);
}

/// Random mechanisms in any pose on a ground that moves. The engine writes its equations in the frame of the world, the analytic
/// model in that of the ground.
#[test]
fn random_mechanisms_on_a_moving_ground_agree_in_both_models() {
    assert_agreement(random_moving_mechanism);
}

fn assert_agreement(random: fn(u64) -> Mechanism) {
    let mut differences = Vec::new();
    for seed in 0..100 {
        let scene = scene(&random(seed), 0.02, 0.02);
        let mut engine = CollectSink::default();
        if let Err(error) = trace::run(Model::Engine, &scene, &mut engine) {
            assert!(error.to_string().contains("the cable of the tendon"), "seed {seed}: {error}");
            continue;
        }
        let engine = engine.samples.pop().expect("a sample");
        let energy = engine.energy();
        let scale_j = 1e-3 + energy.kinetic_j + energy.motor_work_j.abs() + energy.dissipated_j.abs();
        assert!(energy.balance_j.abs() < 1e-4 * scale_j, "seed {seed}: {energy:?}");
        let mut analytic = CollectSink::default();
        if trace::run(Model::Analytic, &scene, &mut analytic).is_err() {
            continue;
        }
        let analytic = analytic.samples.pop().expect("a sample");
        let [balance, ..] = balances_and_difference(&[Some(analytic.clone()), None]);
        assert!(balance < 1e-5, "seed {seed}: {:?}", analytic.energy());
        let largest = end_difference(&analytic, &engine);
        assert!(largest < 1e-4, "seed {seed}: {largest:e} rad or 0.1 m");
        differences.push(largest);
    }
    differences.sort_by(f64::total_cmp);
    assert!(differences.len() > 90, "{} comparisons", differences.len());
    let median = differences[differences.len() / 2];
    assert!(median < 1e-6, "median {median:e} rad or 0.1 m");
}

/// Errors of the energy balances of both models, as a part of the energies, and the difference of their ends.
fn balances_and_difference(ends: &[Option<Sample>; 2]) -> [f64; 3] {
    let balance = |sample: &Option<Sample>| {
        let energy = sample.as_ref().map(Sample::energy).unwrap_or_default();
        let stored_j = energy.kinetic_j + energy.gravity_j.abs() + energy.spring_j.abs() + energy.elastic_j;
        energy.balance_j.abs() / (1e-3 + stored_j + energy.motor_work_j.abs() + energy.dissipated_j.abs())
    };
    let difference = match ends {
        [Some(analytic), Some(engine)] => end_difference(analytic, engine),
        _ => 0.0,
    };
    [balance(&ends[0]), balance(&ends[1]), difference]
}

/// 500 mechanisms with all components in both models: no panic, energy balances, agreement, refusals by name. Prints the
/// distribution of the differences; `PHALANX_SEEDS` is the range of seeds.
#[test]
#[ignore = "tens of seconds"]
fn random_variants_agree_in_both_models() {
    const REFUSALS: [&str; 5] = [
        "singular configuration: the joints",
        "in or near a singular configuration",
        "the cable of the tendon",
        "no row of dyads",
        "is redundant",
    ];
    let (mut differences, mut refusals, mut failures) = (Vec::new(), BTreeMap::new(), Vec::new());
    for seed in seeds("10000..10500") {
        let scene = scene(&random_variant(seed), 0.02, 0.02);
        let mut end = |model: Model, scene: &Scene| {
            let run = std::panic::catch_unwind(|| {
                let mut sink = CollectSink::default();
                trace::run(model, scene, &mut sink).map(|_| sink.samples.pop().expect("a sample"))
            });
            let reason = match run {
                Ok(Ok(sample)) => return Some(sample),
                Ok(Err(error)) => error.to_string(),
                Err(_) => "panic".to_string(),
            };
            match REFUSALS.into_iter().find(|refusal| reason.contains(refusal)) {
                Some(refusal) => *refusals.entry((model.name(), refusal)).or_insert(0) += 1,
                None => failures.push(format!("seed {seed}, {model:?}: {reason}")),
            }
            None
        };
        let ends = [Model::Analytic, Model::Engine].map(|model| end(model, &scene));
        let mut errors = balances_and_difference(&ends);
        let allowed = [1e-5, 1e-4, 1e-4];
        let is_large = |errors: &[f64; 3]| (0..3).any(|k| errors[k].is_nan() || errors[k] > allowed[k]);
        if ends.iter().all(Option::is_some) {
            differences.push(errors[2]);
        }
        // Stiff springs, rebounds and friction multiply errors of integration, which vanish at tight tolerances.
        if is_large(&errors) {
            let mut tight = scene.clone();
            tight.integrator = Integrator::preset(Preset::Reference);
            tight.engine.stepping = Stepping::Adaptive { tolerance_m: 1e-10, max_step_s: 1e-5 };
            let before = errors;
            errors = balances_and_difference(&[Model::Analytic, Model::Engine].map(|model| end(model, &tight)));
            println!("seed {seed}: {before:?}, at tight tolerances {errors:?}");
            errors.iter_mut().for_each(|error| *error *= 2.0);
        }
        if is_large(&errors) {
            failures.push(format!("seed {seed}: {errors:?}"));
        }
    }
    differences.sort_by(f64::total_cmp);
    let quantile = |part: f64| differences[(part * (differences.len() - 1) as f64) as usize];
    let [median, most, largest] = [0.5, 0.99, 1.0].map(quantile);
    println!("{} comparisons: {median:.1e}, {most:.1e}, {largest:.1e} rad or 0.1 m; {refusals:?}", differences.len());
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Free bodies with outlines of any kind that fall on a floor and on each other: both models keep their energy and agree.
#[test]
fn falling_bodies_of_any_outline_agree_in_both_models() {
    let (mut differences, mut touches) = (Vec::new(), 0);
    for seed in 0..60 {
        let scene = parse_any(&scene_text("falling", seed), "random.toml").unwrap_or_else(|error| panic!("{error}"));
        let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| {
            let run = run(model, &scene);
            touches += run.events.iter().filter(|event| event.kind == EventKind::TouchDown).count();
            let last = run.samples.into_iter().next_back().expect("a sample");
            let energy = last.energy();
            let scale_j = 1e-3 + energy.kinetic_j + energy.dissipated_j.abs();
            assert!(energy.balance_j.abs() < 1e-4 * scale_j, "seed {seed}, {model:?}: {energy:?}");
            last
        });
        differences.push((end_difference(&analytic, &engine), seed));
    }
    differences.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(touches > 300, "{touches} touches");
    let largest = differences[differences.len() - 1];
    assert!(largest.0 < 1e-3 && differences[30].0 < 1e-5, "{:?}", &differences[50..]);
}
