//! Sizing of spring and motor (2-design §2.2): torques of design 95, convergence, placements, and scenes with sizing.

use std::f64::consts::FRAC_PI_2;

use crate::support::designs::{THIRDS, design_95, sweep_designs};
use crate::support::statics::{Grasp, grasp};
use phalanx::fivebar::dynamics::{Dynamics, inverse_dynamics};
use phalanx::fivebar::kinematics::{directions, passive_rates, reference_gamma};
use phalanx::gripper::{Assembly, Design, Finger, Placement, Spring, SpringKind};
use phalanx::scene::{self, Profile, Scene};
use phalanx::sizing::{INTERVALS, Rule, SizingError, Task, closing, profile, size, size_with};

/// Returns the finger and the task of a design of the thesis.
fn finger_and_task(design: &Design) -> (Finger, Task) {
    let Grasp { finger, disc, .. } = grasp(design).unwrap();
    (finger, Task::thesis(disc))
}

/// Returns the fingers and tasks of the 192 designs of the thesis (§4.2 with errata 15), in its order.
fn thesis_designs() -> impl Iterator<Item = (Finger, Task)> {
    sweep_designs(THIRDS).into_iter().map(|design| finger_and_task(&design))
}

/// 2-design §2.2 gives 117.72, 516.5 and 440.8 N·mm, the latter two as means over several thousand samples.
#[test]
fn design_95_has_the_torques_of_the_specification() {
    let (finger, task) = finger_and_task(&design_95());
    let [rigid, whole] = [Rule::Rigid, Rule::Whole].map(|rule| size(&finger, &task, rule).unwrap());
    assert!((rigid.spring_n_m - 0.11772).abs() < 5e-6, "{rigid:?}");
    assert!((rigid.motor_n_m / 0.5165 - 1.0).abs() < 3e-4, "{rigid:?}");
    assert!((whole.motor_n_m / 0.4408 - 1.0).abs() < 3e-4, "{whole:?}");
    assert_eq!(whole.spring_n_m, rigid.spring_n_m);
}

/// Compares the closed form with its definition: the general inverse dynamic model along the trajectory, averaged over fine samples.
#[test]
fn closed_form_of_the_rigid_phase_matches_its_definition() {
    for (finger, task) in thesis_designs().step_by(17) {
        let closing = closing(&finger, &task).unwrap();
        let gamma = reference_gamma(&finger.lengths);
        let dynamics = Dynamics::new(&finger, gamma, task.gravity_m_s2);
        let samples = 20_000;
        let (mut spring, mut squares, mut slope_of) = (f64::MIN, 0.0, f64::NAN);
        for i in 0..samples {
            // Midpoint rule.
            let x = closing.contact_x * (i as f64 + 0.5) / samples as f64;
            let motion = closing.trajectory.at(x);
            let q = [motion.angle_rad, motion.angle_rad + FRAC_PI_2];
            let r = inverse_dynamics(&dynamics, q, [motion.rate_rad_s; 2], [motion.acceleration_rad_s2; 2]);
            let slope = passive_rates(&finger.lengths, &directions(&finger.lengths, gamma, q)).a4[1] - 1.0;
            slope_of = slope.abs();
            spring = spring.max(r[1] / slope_of);
            squares += (r[0] + r[1]).powi(2) / samples as f64;
        }
        assert!(slope_of > 0.0);
        let sizing = size(&finger, &task, Rule::Rigid).unwrap();
        assert!((sizing.motor_n_m / squares.sqrt() - 1.0).abs() < 1e-7, "{sizing:?} {}", squares.sqrt());
        assert!((sizing.spring_n_m / spring - 1.0).abs() < 2e-4, "{sizing:?} {spring}");
        assert!(sizing.spring_n_m >= spring * (1.0 - 5e-8), "the maximum is at least the largest sample");
    }
}

#[test]
fn sizing_has_converged_with_the_default_samples() {
    for (finger, task) in thesis_designs() {
        let sized = |rule, intervals| size_with(&finger, &task, rule, Placement::Phalanges, intervals).unwrap();
        let change = |a: f64, b: f64| (a / b - 1.0).abs();
        let (rigid, finer) = (sized(Rule::Rigid, INTERVALS), sized(Rule::Rigid, 2 * INTERVALS));
        assert!(change(rigid.motor_n_m, finer.motor_n_m) < 1e-9);
        assert!(change(rigid.spring_n_m, finer.spring_n_m) < 5e-8);
        let (whole, finer) = (sized(Rule::Whole, INTERVALS), sized(Rule::Whole, 2 * INTERVALS));
        assert!(change(whole.motor_n_m, finer.motor_n_m) < 1e-5, "{finger:?}");
    }
}

/// §3.3.2.3: the placement on q22 and the last placement need the weakest springs; the net motor torque does not depend on the
/// placement.
#[test]
fn spring_placement_changes_only_the_spring() {
    for (finger, task) in thesis_designs() {
        let sized = |placement| size_with(&finger, &task, Rule::Rigid, placement, INTERVALS).unwrap();
        let [ground, coupler, phalanges, last] = Placement::ALL.map(sized);
        for other in [ground, coupler, last] {
            assert_eq!(other.motor_n_m, phalanges.motor_n_m);
        }
        let weaker_of_others = ground.spring_n_m.min(coupler.spring_n_m);
        assert!(phalanges.spring_n_m < weaker_of_others && last.spring_n_m < weaker_of_others, "{finger:?}");
    }
}

#[test]
fn profile_starts_and_ends_at_rest_and_contains_the_contact() {
    let (finger, task) = finger_and_task(&design_95());
    let profile = profile(&finger, &task, 1.0, 400).unwrap();
    let [first, last] = [profile.points[0], *profile.points.last().unwrap()];
    assert_eq!([first.time_s, last.time_s], [0.0, 0.010]);
    assert_eq!([first.qd11_rad_s, last.qd11_rad_s], [0.0, 0.0]);
    let end = profile.closing.end.posture;
    assert!((last.q11_rad - end.q11_rad).abs() < 1e-12 && (last.q22_rad - end.q22_rad).abs() < 1e-12);
    // Spring and net torques exist up to the contact, which is included once for each phase.
    let free_phase: Vec<_> = profile.points.iter().filter(|point| point.springs_n_m.is_some()).collect();
    let contact = free_phase.last().unwrap();
    assert_eq!(contact.time_s, profile.closing.contact_s());
    let after = profile.points[free_phase.len()];
    assert_eq!(after.time_s, contact.time_s);
    assert!((after.q22_rad - contact.q22_rad).abs() < 1e-12);
    // The largest sample equals the sized torque within the resolution of 400 samples.
    let largest = free_phase.iter().map(|point| point.springs_n_m.unwrap()[2]).fold(f64::MIN, f64::max);
    let ratio = largest / profile.rigid.spring_n_m;
    assert!((ratio - 1.0).abs() < 1e-4 && ratio <= 1.0 + 1e-9, "{ratio}");
    // The torque of a torsional spring grows with the rotation of the tip (Fig. 3.3).
    let closing_points = profile.points.iter().filter(|point| point.q22_rad > first.q22_rad + 1e-3);
    assert!(closing_points.clone().count() > 50);
    for point in closing_points {
        assert!(point.torsional_n_m > point.constant_n_m, "{point:?}");
    }
    assert!((profile.torsional_n_m_per_rad - profile.rigid.spring_n_m).abs() < 1e-15, "c_s q_p = k_s at q_p = 1 rad");
}

#[test]
fn errors_name_the_reason() {
    let (finger, task) = finger_and_task(&design_95());
    let mut unreachable = task;
    unreachable.object.centre_m[0] = -0.2;
    for (task, reason) in [
        (Task { closing_s: 0.0, ..task }, "closing_s is 0, but must be"),
        (Task { opening_rad: -0.1, ..task }, "must start more than 0 deg before it"),
        (unreachable, "misses the object"),
    ] {
        let error = size(&finger, &task, Rule::Rigid).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
    let other = Finger { assembly: Assembly::Other, ..finger };
    assert_eq!(size(&other, &task, Rule::Rigid), Err(SizingError::OtherAssembly));
}

const DESIGN: &str = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";

fn scene(head: &str, tail: &str) -> Scene {
    scene::parse(&format!("{head}\n{DESIGN}{tail}"), "sized.toml").unwrap()
}

#[test]
fn scene_sizing_equals_finger_sizing() {
    let (_, task) = finger_and_task(&design_95());
    for (keyword, rule) in [("rigid", Rule::Rigid), ("whole", Rule::Whole)] {
        let scene = scene(&format!("sizing = \"{keyword}\""), "");
        let sizing = size(&scene.finger().linkage, &task, rule).unwrap();
        assert_eq!(scene.finger().motor.actuation, Profile::Constant { value: sizing.motor_n_m });
        let kind = SpringKind::Constant { torque_n_m: sizing.spring_n_m };
        assert_eq!(scene.finger().spring, Some(Spring { kind, placement: Placement::Phalanges }));
        // A completed scene contains the torques instead of the sizing rule.
        let shown = scene::show(&scene);
        assert!(!shown.contains("sizing"));
        let reparsed = scene::parse(&shown, "sized.toml").unwrap();
        assert_eq!(reparsed.finger().motor, scene.finger().motor);
        assert_eq!(reparsed.finger().spring, scene.finger().spring);
    }
}

#[test]
fn scene_sizing_uses_the_scene_parameters() {
    let scene = |head: &str, tail: &str| scene(&format!("sizing = \"rigid\"\n{head}"), tail);
    let (_, task) = finger_and_task(&design_95());
    let expected_sizing = size(&scene("", "").finger().linkage, &task, Rule::Rigid).unwrap();
    let torques = |scene: &Scene| match (&scene.finger().motor.actuation, scene.finger().spring.unwrap().kind) {
        (Profile::Constant { value: torque_n_m } | Profile::Ramp { value: torque_n_m, .. }, kind) => {
            (*torque_n_m, kind)
        }
        other => panic!("{other:?}"),
    };
    // Half the closing time requires about four times the torque.
    let (motor, _) = torques(&scene("closing_time = \"5 ms\"", ""));
    assert!((motor / expected_sizing.motor_n_m - 4.0).abs() < 0.05, "{motor}");
    let weightless = "gravity = [\"0 m/s^2\", \"0 m/s^2\"]";
    let heavy = scene(weightless, "[material]\ndensity = \"2140 kg/m^3\"\n");
    let light = scene(weightless, "");
    assert!((torques(&heavy).0 / torques(&light).0 - 2.0).abs() < 1e-12);
    // The same start specified by an angle.
    let by_angle = scene("", "[initial]\nq21 = \"40 deg\"\n");
    assert!((by_angle.finger().initial.q21_rad.to_degrees() - 40.0).abs() < 1e-12);
    assert!((torques(&by_angle).0 / expected_sizing.motor_n_m - 1.0).abs() < 1e-3);
    // The torsional spring has the torque of the constant spring when the finger is straight.
    let torsional = scene("", "[spring]\ntype = \"torsional\"\npreload = \"90 deg\"\n");
    let SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } = torques(&torsional).1 else { panic!() };
    assert!((stiffness_n_m_per_rad * preload_rad - expected_sizing.spring_n_m).abs() < 1e-15);
    let with_ramp = scene("", "[motor]\nprofile = \"ramp\"\nrise = \"2 ms\"\n");
    assert_eq!(torques(&with_ramp).0, expected_sizing.motor_n_m);
}
