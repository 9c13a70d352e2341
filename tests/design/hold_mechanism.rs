//! Accelerations that the hands of mechanisms withstand: a closed form, bases of every kind, both models, shipped grippers, and
//! rejected scenes.

use std::f64::consts::FRAC_PI_2;

use phalanx::law::{Bristle, FrictionKind};
use phalanx::parallel::Monitor;
use phalanx::scene::{self, Axis, Scene};
use phalanx::statics::MechanismLimit;
use phalanx::study::hold::{Hold, HoldError, LoadCase, LoadResult, Loads, Plan, StartReason, hold};
use phalanx::trace::Model;

use crate::support::cli::assert_contains;
use crate::support::designs::assert_near;

/// Two pads that press with 20 N each on a box of 100 g, with a friction of 0.5: along them they hold up to 2 μ F/m = 200 m/s².
fn pads(base: &str, more: &str) -> Scene {
    let text = format!(
        r#"
        kind = "mechanism"
        duration = "30 ms"
        [bodies.left]
        mass = "20 g"
        inertia = "3000 g*mm^2"
        guess = {{ at = ["-19 mm", "0 mm"] }}
        outlines.pad = {{ type = "box", size = ["8 mm", "20 mm"], rounding = "1 mm" }}
        [bodies.right]
        mass = "20 g"
        inertia = "3000 g*mm^2"
        guess = {{ at = ["19 mm", "0 mm"] }}
        outlines.pad = {{ type = "box", size = ["8 mm", "20 mm"], rounding = "1 mm" }}
        [bodies.object]
        mass = "100 g"
        inertia = "15000 g*mm^2"
        start = {{ at = ["0 mm", "0 mm"] }}
        outlines.skin = {{ type = "box", size = ["30 mm", "30 mm"], rounding = "1 mm" }}
        [joints.left]
        type = "prismatic"
        bodies = ["{base}", "left"]
        points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
        start = "-19 mm"
        [joints.right]
        type = "prismatic"
        bodies = ["{base}", "right"]
        points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
        [couplings.synchronised]
        joints = ["left", "right"]
        factors = [1, 1]
        [actuators.grip]
        joint = "left"
        force = "40 N"
        [laws.pad]
        stiffness = 1e7
        exponent = 1.0
        damping = "1 s/m"
        friction = {{ mu_static = 0.5, law = "bristle", bristle_damping = "2000 N*s/m" }}
        [[contacts]]
        between = ["*.pad", "object"]
        law = "pad"
        {more}
        "#
    );
    scene::parse_any(&text, "pads.toml").unwrap_or_else(|error| panic!("{error}"))
}

const PALM: &str = r#"
    [bodies.palm]
    mass = "300 g"
    inertia = "100000 g*mm^2"
"#;

const LIFT: &str = r#"
    [joints.lift]
    type = "prismatic"
    bodies = ["ground", "palm"]
    points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
    axis = "90 deg"
    start = "0 mm"
    [actuators.lift]
    joint = "lift"
    target = "0 mm"
    kp = "1e5 N/m"
    kd = "1e3 N*s/m"
"#;

/// A table under the box, which it just touches, and gravity.
const TABLE: &str = r#"
    [ground.outlines.table]
    type = "half_plane"
    point = ["0 mm", "-15.01 mm"]
    normal = [0, 1]
    [[contacts]]
    between = ["object", "ground.table"]
    law = "pad"
"#;

fn load(path: &str) -> Scene {
    scene::load_any(path).unwrap_or_else(|error| panic!("{error}"))
}

fn plan() -> Plan {
    Plan {
        loads: Loads::Pulses { directions: 4, length_s: 40e-3 },
        slip_m: 20e-6,
        from_m_s2: 50.0,
        to_m_s2: 800.0,
        scan: 5,
        tolerance: 0.01,
        threads: 1,
        ..Plan::default()
    }
}

#[track_caller]
fn run_hold(scene: &Scene, plan: Plan) -> Hold {
    hold(scene, plan, &Monitor::silent(&|| true)).unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

fn static_m_s2(result: &LoadResult) -> f64 {
    result.static_limit.as_ref().and_then(MechanismLimit::acceleration_m_s2).expect("a limit at rest")
}

/// The closed form along the pads, with every kind of base: the ground, a body that floats, one that moves, one on a lift.
#[test]
fn two_pads_hold_up_to_twice_the_friction_over_the_mass() {
    let moved = format!("{PALM}\n[moves.away]\ny = \"1 mm\"\nstart = \"5 ms\"\ntime = \"10 ms\"\n");
    for (base, more, name, reason) in [
        ("ground", "", "ground", StartReason::AtRest),
        ("palm", PALM, "palm", StartReason::AtRest),
        ("palm", &moved, "palm", StartReason::MoveCompleted),
        ("palm", &format!("{PALM}{LIFT}"), "palm", StartReason::AtRest),
    ] {
        let study = run_hold(&pads(base, more), Plan { from_m_s2: 170.0, to_m_s2: 250.0, scan: 2, ..plan() });
        assert_eq!((study.base.as_deref(), study.start_reason), (Some(name), reason), "{more}");
        assert!(study.removed.is_empty(), "{:?}", study.removed);
        let along = study.results.iter().filter(|result| {
            matches!(result.case, LoadCase::Pulse { direction_rad, .. } if (direction_rad / FRAC_PI_2).round() % 2.0 == 1.0)
        });
        for result in along {
            assert_near(static_m_s2(result), 200.0, 0.2);
            let (held, failed) = result.slips.held.zip(result.slips.failed).expect("limits within the scan");
            // A load that is exceeded for an instant moves the box less than the bound.
            assert!(held > 0.99 * 200.0 && failed < 1.05 * 200.0, "{more}: {held} {failed}");
        }
        // Across, one pad carries the whole load with both forces.
        assert_near(static_m_s2(&study.results[0]), 400.0, 0.4);
    }
}

#[test]
fn both_models_hold_a_vibrating_box_alike() {
    let loads = Loads::Vibrations { axes: vec![Axis::Y], frequencies_hz: vec![100.0] };
    let of_model = |model: Model| {
        let study = run_hold(&pads("palm", &format!("{PALM}{LIFT}")), Plan { loads: loads.clone(), model, ..plan() });
        study.results[0].slips.held.expect("something is held")
    };
    let [analytic, engine] = [Model::Analytic, Model::Engine].map(of_model);
    assert_near(engine, analytic, 0.03 * analytic);
    assert!(analytic > 150.0 && analytic < 260.0, "{analytic}");
}

/// A table that a load would hit no longer supports the box or stops the hand: the limits are those without it.
#[test]
fn surroundings_that_a_load_would_hit_are_removed() {
    let on_lift = format!("{PALM}{LIFT}");
    for model in [Model::Analytic, Model::Engine] {
        let plan = Plan { model, scan: 2, tolerance: 0.2, ..plan() };
        let [with, without] =
            [TABLE, ""].map(|table| run_hold(&pads("palm", &format!("{on_lift}{table}")), plan.clone()));
        assert_eq!(with.removed, ["ground.table"]);
        for (a, b) in with.results.iter().zip(&without.results) {
            let (a, b) = (a.slips.held.expect("something is held"), b.slips.held.expect("something is held"));
            assert_near(a, b, 0.05 * b);
        }
    }
    // It is kept where no load reaches it.
    let far = TABLE.replace("-15.01 mm", "-800 mm");
    let study = run_hold(&pads("palm", &format!("{on_lift}{far}")), Plan { scan: 2, tolerance: 0.9, ..plan() });
    assert!(study.removed.is_empty(), "{:?}", study.removed);
}

/// Shipped grippers: a palm and a hand on a lift, with a cube from a table, and a hand whose base is the ground.
#[test]
fn shipped_grippers_hold_in_the_frame_of_their_base() {
    for (name, base, removed) in [
        ("2f85-lift", "palm", &["ground.table"][..]),
        ("franka-lift", "hand", &["ground.table"]),
        ("t42-grasp", "ground", &[]),
    ] {
        let scene = load(&format!("scenes/real/{name}.toml"));
        let loads = Loads::Pulses { directions: 4, length_s: 40e-3 };
        let plan =
            Plan { loads, from_m_s2: 2.0, to_m_s2: 500.0, scan: 2, tolerance: 0.9, threads: 1, ..Plan::default() };
        let study = run_hold(&scene, plan);
        assert_eq!(study.base.as_deref(), Some(base), "{name}");
        assert_eq!(study.removed, removed, "{name}");
        assert!(study.results.iter().all(|result| result.drops.held.is_some()), "{name}: {:?}", study.results);
    }
}

/// Friction of the cables helps to hold; in simulations as at rest.
#[test]
fn a_hand_with_rubbing_cables_holds_up_to_the_limit_at_rest() {
    let mut scene = load("scenes/mechanisms/tendon-hand.toml");
    for contact in &mut scene.mechanism.as_mut().expect("a mechanism").contacts {
        let friction = contact.law.friction.as_mut().expect("friction");
        friction.kind = FrictionKind::Bristle(Bristle { damping_n_s_per_m: 200.0, relaxation_s: 1e-3 });
    }
    let loads = Loads::Pulses { directions: 2, length_s: 100e-3 };
    let plan = Plan { loads, slip_m: 0.5e-3, from_m_s2: 6.0, to_m_s2: 24.0, scan: 2, tolerance: 0.05, ..plan() };
    for result in run_hold(&scene, plan).results {
        let (held, failed) = result.slips.held.zip(result.slips.failed).expect("limits within the scan");
        let at_rest = static_m_s2(&result);
        assert!(held > 0.85 * at_rest && failed < 1.1 * at_rest, "{held} {failed} {at_rest}");
    }
}

#[test]
fn errors_name_the_cause_and_a_remedy() {
    let tied = format!(
        "{PALM}{LIFT}[tendons.cable]\nstiffness = \"1 N/m\"\nrest = \"10 mm\"\npath = [{{ eyelet = \"ground\", at = [\"0 mm\", \"50 mm\"] }}, \
         {{ eyelet = \"left\", at = [\"0 mm\", \"0 mm\"] }}]\n"
    );
    let requested = |start_s: f64| Plan { start_s: Some(start_s), ..plan() };
    for (scene, plan, words) in [
        (load("scenes/real/2f85-lift.toml"), requested(0.13), &["`palm` still moves at 130.000 ms", "--at"][..]),
        (pads("palm", &tied), requested(0.02), &["the tendon `cable`", "carries its base `palm`"]),
        (load("scenes/mechanisms/four-bar.toml"), plan(), &["no grasp", "[[contacts]]"]),
    ] {
        let error = hold(&scene, plan, &Monitor::silent(&|| true)).expect_err("an error");
        assert_contains(&error.to_string(), words);
    }
    let mut loose = pads("ground", "");
    for actuator in &mut loose.mechanism.as_mut().expect("a mechanism").actuators {
        *actuator.command.profile_mut() = phalanx::drive::Profile::Constant { value: -1.0 };
    }
    let error = hold(&loose, plan(), &Monitor::silent(&|| true)).expect_err("an error");
    assert!(matches!(error, HoldError::NotGrasped { .. }), "{error}");
}
