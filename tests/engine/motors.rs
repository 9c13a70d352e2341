//! Motors that slow down with their rate, and brakes: impulse and work are those of the motion, however long the steps.

use crate::support::runs::Collect;
use phalanx::scene::parse_any;
use phalanx::trace::{self, Model, Outcome};

fn run(model: Model, text: &str) -> Outcome {
    let scene = parse_any(text, "motor.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    trace::run(model, &scene, &mut Collect::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The engine has the angles of the analytic model, its work of the motors and its losses, to a part of all energies.
#[track_caller]
fn agrees(text: &str, part: f64) {
    let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| run(model, text));
    for (found, wanted) in engine.last.fingers.iter().zip(&analytic.last.fingers) {
        let off = [found.q11_rad - wanted.q11_rad, found.q21_rad - wanted.q21_rad, found.q22_rad - wanted.q22_rad];
        assert!(off.iter().all(|off| off.abs() < 2e-5), "{off:?}\n{text}");
    }
    let (found, wanted) = (&engine.last.energy, &analytic.last.energy);
    let most_j = [wanted.kinetic_j, wanted.gravity_j, wanted.spring_j, wanted.dissipated_j, wanted.motor_work_j];
    let allowed_j = part * most_j.iter().fold(0.0, |most: f64, j| most.max(j.abs()));
    for (found, wanted) in
        [(found.motor_work_j, wanted.motor_work_j), (found.dissipated_j, wanted.dissipated_j), (found.balance_j, 0.0)]
    {
        assert!(
            (found - wanted).abs() < allowed_j,
            "{found:e} instead of {wanted:e} J, {allowed_j:e} J are allowed\n{text}"
        );
    }
}

/// Design 95 as a gripper under a motor.
fn gripper(duration_ms: f64, motor: &str) -> String {
    format!(
        "kind = \"gripper\"\nduration = \"{duration_ms} ms\"\n[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n\
         [spring]\ntorque = \"132.6 N*mm\"\n[motor]\n{motor}"
    )
}

/// At 1e8 N·mm and 0.1 rad/s the rate is there after 1e-11 s.
#[test]
fn the_work_is_right_where_a_step_goes_over_the_relaxation() {
    for torque in [1.0, 1e2, 1e4, 1e6, 1e8] {
        for speed in [0.1, 1.0, 10.0] {
            let motor = format!("torque = \"{torque:e} N*mm\"\nno_load_speed = \"{speed} rad/s\"\n");
            agrees(&gripper(10.0, &motor), 1e-3);
        }
    }
}

#[test]
fn the_work_is_right_where_the_torque_changes() {
    for torque in [1e2, 1e5] {
        for speed in [1.0, 100.0] {
            for profile in
                ["profile = \"reversal\"\nreverse_at = \"0.5 ms\"\n", "profile = \"ramp\"\nrise = \"2 ms\"\n"]
            {
                let motor = format!("{profile}torque = \"{torque:e} N*mm\"\nno_load_speed = \"{speed} rad/s\"\n");
                agrees(&gripper(5.0, &motor), 1e-3);
            }
        }
    }
}

#[test]
fn a_brake_grips_within_a_step() {
    for torque in [1e-3, 1.0, 1e3] {
        for law in ["regularised", "bristle"] {
            let motor = format!(
                "torque = \"480 N*mm\"\nno_load_speed = \"10 rad/s\"\nbrake = \"two-way\"\nbrake_torque = \"{torque:e} N*m\"\nbrake_at = \"3 ms\"\n\
                 brake_law = \"{law}\"\n"
            );
            agrees(&gripper(10.0, &motor), 1e-3);
        }
    }
}

#[test]
fn one_motor_drives_both_fingers() {
    for torque in [1e2, 1e5, 1e8] {
        let motor = format!(
            "torque = \"{torque:e} N*mm\"\nno_load_speed = \"5 rad/s\"\ninertia = \"1e-7 kg*m^2\"\n[differential]\n"
        );
        agrees(&gripper(8.0, &motor), 1e-3);
    }
}

/// Three random scenes whose work was wrong by 10 % to 64 times.
#[test]
fn random_scenes_have_the_work_of_the_analytic_model() {
    agrees(include_str!("motors/reversal.toml"), 1e-3);
    agrees(include_str!("motors/constant.toml"), 1e-3);
    agrees(include_str!("motors/brake.toml"), 1e-3);
}
