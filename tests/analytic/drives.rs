//! Actuators with gears, motors and feedback, and limits of sums: reference solutions, and closed forms.

use phalanx::analytic::mechanism::MechanismModel;
use phalanx::drive::Profile;
use phalanx::integrator::{Hybrid, Method, Options, SwitchedMethod, Tolerances, integrate_by};
use phalanx::mechanism::{
    Actuator, Body, Command, GearLoss, Joint, JointCombination, JointKind, Mechanism, Motor, Powertrain, assemble,
};
use phalanx::trace::{self, Model};

use super::mechanism::{compare, first_touches};
use crate::support::mechanism_cases::drive_cases;
use crate::support::runs::CollectSink;

#[test]
fn drives_meet_the_reference_solutions() {
    let tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-9, rtol_v: 1e-11 };
    for case in drive_cases() {
        let found = compare(&case, Method::new, tolerances);
        let name = &case.name;
        assert!(found.position_m < 1e-8 && found.angle_rad < 1e-7, "{name}: {found:?}");
        for touch in first_touches(&case) {
            let nearest = found.touches_s.iter().map(|time| (time - touch).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9, "{name}: touch at {touch} s missed by {nearest:e} s");
        }
        println!("{name}: {found:?}");
        assert!(found.energy_j < 1e-9 && found.loss_j < 1e-9, "{name}: {found:?}");
        assert!(found.effort < 1e-5 && found.drives.iter().all(|difference| *difference < 1e-6), "{name}: {found:?}");
    }
}

#[test]
fn drives_are_accurate_to_1e_5_at_everyday_tolerances() {
    let tolerances = Tolerances { atol_q: 3e-11, atol_v: 3e-7, rtol_v: 3e-7 };
    for case in drive_cases() {
        let found = compare(&case, SwitchedMethod::rodas, tolerances);
        assert!(found.position_m < 1e-6 && found.angle_rad < 1e-5, "{}: {found:?}", case.name);
    }
}

/// An arm about its centre of mass, without gravity, with this actuator.
fn arm(inertia_kg_m2: f64, rate: f64, command: Profile, powertrain: Powertrain) -> Mechanism {
    let body = Body::new("arm", 0.1, inertia_kg_m2);
    let joint = Joint::new("q", JointKind::Revolute, [None, Some(0)], [[0.0; 2]; 2]);
    Mechanism {
        bodies: vec![body],
        joints: vec![Joint { start: Some(0.0), start_rate: rate, ..joint }],
        actuators: vec![Actuator {
            name: "m".to_string(),
            on: JointCombination::of_joint(0),
            command: Command::Effort(command),
            limit: None,
            no_load_speed: None,
            brake: None,
            powertrain,
        }],
        ..Mechanism::default()
    }
}

/// Angle, rate and current at the end of a run.
fn run(mechanism: &Mechanism, duration_s: f64) -> [f64; 3] {
    let start = assemble(mechanism).expect("an assembled start");
    let model = MechanismModel::new(mechanism, (&start.poses, &start.rates)).expect("coordinates");
    let tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-11, rtol_v: 1e-12 };
    let options = Options { tolerances, max_steps: 1_000_000 };
    let method = SwitchedMethod::new(model.sizes());
    let end = integrate_by(method, &model, &options, 0.0, model.start(), duration_s, &mut ());
    end.result.unwrap_or_else(|failure| panic!("{failure}"));
    let (qv, mut found) = ((&end.state.q, &end.state.v), [0.0; 3]);
    let mode = model.mode_at(duration_s, qv.0, qv.1);
    model.read_joints(qv, |_, (angle, rate)| (found[0], found[1]) = (angle, rate));
    model.read_drives(duration_s, qv, &mode, |drives| drives.for_each(|(_, drive)| found[2] = drive.current_a));
    found
}

fn assert_close(found: f64, expected: f64, scale: f64, what: &str) {
    assert!((found - expected).abs() < 1e-9 * scale, "{what}: {found}, not {expected}");
}

const MOTOR: Motor =
    Motor { torque_constant: 0.01, resistance: 2.0, current_limit: None, back_emf: 0.01, inductance: None };

/// ω = ω∞ (1 − e^(−t/τ)) with τ = I R/(n² k_t k_e), after a start at constant current until V − k_e n ω = R i.
#[test]
fn a_motor_runs_up_to_its_no_load_speed_as_its_closed_form_does() {
    for (gear, rotor, limit) in
        [(30.0, 1e-7, None), (-7.0, 0.0, Some(0.8)), (400.0, 1e-8, Some(2.5)), (0.5, 3e-5, Some(0.1))]
    {
        let (voltage, own) = (6.0, 2e-4);
        let motor = Motor { current_limit: limit, back_emf: 0.012, ..MOTOR };
        let powertrain = Powertrain { gear, rotor_kg_m2: rotor, motor: Some(motor), ..Powertrain::default() };
        let inertia = own + powertrain.reflected_inertia();
        let (top, force) = (voltage / (motor.back_emf * gear), gear * motor.torque_constant);
        let tau = inertia * motor.resistance / (force * motor.back_emf * gear);
        let held = limit.filter(|limit| limit * motor.resistance < voltage);
        let (switch, at_switch) = held.map_or((0.0, 0.0), |limit| {
            let rate = (voltage - limit * motor.resistance) / (motor.back_emf * gear);
            (rate * inertia / (force * limit), rate)
        });
        let t = switch + 1.3 * tau;
        let decay = (-1.3f64).exp();
        let rate = top + (at_switch - top) * decay;
        let angle = 0.5 * at_switch * switch + top * (t - switch) + (at_switch - top) * tau * (1.0 - decay);
        let found = run(&arm(own, 0.0, Profile::Constant { value: voltage }, powertrain), t);
        let name = format!("gear {gear}, limit {limit:?}");
        assert_close(found[1], rate, top.abs(), &name);
        assert_close(found[0], angle, top.abs() * t, &name);
        assert_close(found[2], (voltage - motor.back_emf * gear * rate) / motor.resistance, 3.0, &name);
    }
}

/// The step response of a motor with an inductance, a linear system of second order, over decades of the inductance.
#[test]
fn a_voltage_step_on_an_inductance_follows_its_closed_form() {
    for inductance in [1e-8, 1e-6, 1e-4, 1e-3, 1e-2, 0.1, 10.0] {
        let (gear, own, voltage) = (30.0, 2e-4, 6.0);
        let motor = Motor { inductance: Some(inductance), ..MOTOR };
        let powertrain = Powertrain { gear, rotor_kg_m2: 1e-7, motor: Some(motor), ..Powertrain::default() };
        let inertia = own + powertrain.reflected_inertia();
        let force = gear * motor.torque_constant;
        // i″ + a i′ + b i = 0 with i(0) = 0, i′(0) = V/L.
        let (a, b) = (motor.resistance / inductance, force * force / (inertia * inductance));
        let discriminant = 0.25 * a * a - b;
        let root = discriminant.abs().sqrt();
        let t = match discriminant > 0.0 {
            true => 2.0 / (b / (0.5 * a + root)),
            false => 2.0 / root,
        };
        let t = t.min(5.0);
        let current = match discriminant > 0.0 {
            true => {
                let slow = b / (0.5 * a + root);
                let fast = 0.5 * a + root;
                voltage / inductance * ((-slow * t).exp() - (-fast * t).exp()) / (fast - slow)
            }
            false => voltage / inductance * (-0.5 * a * t).exp() * (root * t).sin() / root,
        };
        // L i + R ∫ i + k n q = V t, and I ω = n k ∫ i.
        let rate_of_current = match discriminant > 0.0 {
            true => {
                let (slow, fast) = (b / (0.5 * a + root), 0.5 * a + root);
                voltage / inductance * (fast * (-fast * t).exp() - slow * (-slow * t).exp()) / (fast - slow)
            }
            false => {
                let decay = (-0.5 * a * t).exp();
                voltage / inductance * decay * ((root * t).cos() - 0.5 * a / root * (root * t).sin())
            }
        };
        let rate = (voltage - motor.resistance * current - inductance * rate_of_current) / force;
        let found = run(&arm(own, 0.0, Profile::Constant { value: voltage }, powertrain), t);
        let name = format!("{inductance} H");
        assert_close(found[1], rate, voltage / force, &name);
        assert_close(found[2], current, voltage / motor.resistance, &name);
    }
}

/// A gear that drives gives η n u, and one that is driven back resists with (2 − η) n u.
#[test]
fn lossy_gears_drive_and_are_driven_back_at_constant_accelerations() {
    for (efficiency, loss_rate) in [(0.9, 0.01), (0.3, 1e-6), (0.02, 1.0), (0.7, 1e-3)] {
        for (gear, torque, rate) in [(25.0, 0.004, 3.0), (25.0, 0.004, -8.0), (-3.0, 0.02, 2.0), (100.0, -0.001, 5.0)] {
            let own = 6e-4;
            let loss = GearLoss { efficiency, rate: loss_rate, bristle: None };
            let powertrain = Powertrain { gear, rotor_kg_m2: 1.5e-7, loss: Some(loss), ..Powertrain::default() };
            let inertia = own + powertrain.reflected_inertia();
            let ideal: f64 = gear * torque;
            let factor = if ideal * rate > 0.0 { efficiency } else { 2.0 - efficiency };
            // While the gear is driven back, it slows down: until half of the speed is left, or for 10 ms.
            let acceleration = factor * ideal / inertia;
            let t = (0.5 * rate.abs() / acceleration.abs()).min(0.01);
            let found = run(&arm(own, rate, Profile::Constant { value: torque }, powertrain), t);
            let name = format!("efficiency {efficiency}, gear {gear}, torque {torque}, rate {rate}");
            assert_close(found[1], rate + acceleration * t, rate.abs(), &name);
            assert_close(found[0], rate * t + 0.5 * acceleration * t * t, rate.abs() * t, &name);
        }
    }
}

/// A distance servo that drives its points together ends the run where they meet.
#[test]
fn a_run_ends_where_measured_points_meet() {
    let mut case = drive_cases().into_iter().find(|case| case.name == "m_aperture_box").expect("the case");
    case.mechanism.contacts.clear();
    case.mechanism.bodies[2].pose[1] = 1.0;
    let Command::Servo { target, .. } = &mut case.mechanism.actuators[0].command else { panic!("a controller") };
    *target = Profile::Constant { value: 0.0 };
    for model in [Model::Analytic, Model::Engine] {
        let failure = trace::run(model, &case.scene(), &mut CollectSink::default()).expect_err("points that meet");
        let message = failure.to_string();
        assert!(message.contains("the points left.tip and right.tip met"), "{model:?}: {message}");
    }
}
