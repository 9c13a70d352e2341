//! Hands at rest whose cables rub: against the capstan equation, with decades of friction and wrap.

use phalanx::mechanism::{Mechanism, assemble};
use phalanx::scene::{Scene, parse_any};
use phalanx::statics::{
    BalanceAtRest, DriveState, LoadsAtRest, MechanismAtRest, MechanismBalance, MechanismLimit, balance_at_rest,
    mechanism_balance, roles,
};
use phalanx::trace::{Model, run};

const PULL_N: f64 = 30.0;
const MASS_KG: f64 = 0.1;
/// Arms of the cable and of the centre of mass about the hinge.
const ARM_M: f64 = 0.04;
const COM_M: f64 = 0.08;

/// A link on a hinge whose centre of mass is on the x axis, with a torque that turns it back, and these sections.
fn link(torque_n_m: f64, sections: &str) -> Scene {
    let text = format!(
        r#"
        kind = "mechanism"
        duration = "1 ms"
        gravity = ["0 m/s^2", "0 m/s^2"]
        [bodies.link]
        mass = "100 g"
        inertia = "1e-5 kg*m^2"
        com = ["80 mm", "0 mm"]
        [joints.hinge]
        bodies = ["ground", "link"]
        points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
        start = "0 deg"
        [springs.back]
        joint = "hinge"
        stiffness = "1e-9 N*m/rad"
        torque = "{} N*m"
        {sections}
        "#,
        -torque_n_m
    );
    parse_any(&text, "link.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The guide of a cable that leads down along the link's y axis from it, and the eyelet before it, for a wrap; both on the ground.
fn guide(wrap_rad: f64, radius_m: f64) -> [[f64; 2]; 2] {
    let along = -std::f64::consts::FRAC_PI_2 - wrap_rad;
    let (u, center) = ([along.cos(), along.sin()], [ARM_M + radius_m, 0.06]);
    let tangent = [center[0] + radius_m * u[1], center[1] - radius_m * u[0]];
    [[tangent[0] - 0.05 * u[0], tangent[1] - 0.05 * u[1]], center]
}

fn millimetres([x, y]: [f64; 2]) -> String {
    format!("[\"{} mm\", \"{} mm\"]", x * 1e3, y * 1e3)
}

/// A cord over a guide, `element`, to an eyelet of the link.
fn cord(wrap_rad: f64, radius_m: f64, keys: &str, more: &str) -> String {
    let [from, center] = guide(wrap_rad, radius_m).map(millimetres);
    let kind = match radius_m > 0.0 {
        true => format!("pulley = \"ground\", radius = \"{} mm\", turn = \"ccw\"", radius_m * 1e3),
        false => "eyelet = \"ground\"".to_string(),
    };
    format!(
        "[tendons.cord]\npath = [{{ eyelet = \"ground\", at = {from} }}, {{ {kind}, at = {center}{keys} }}, \
         {{ eyelet = \"link\", at = [\"40 mm\", \"0 mm\"] }}]\n{more}\n\
         [actuators.pull]\ntendon = \"cord\"\ntension = \"{PULL_N} N\"\n"
    )
}

/// Largest accelerations of the ground along y and against it, with the tension of a cable, by both ways to give it.
fn limits(scene: &Scene, tension_n: f64) -> [Option<f64>; 2] {
    let mechanism = scene.mechanism.as_ref().expect("a mechanism");
    let commanded = accelerations(mechanism, DriveState::AtEffort, None);
    let at_end = accelerations(mechanism, DriveState::AtEffort, Some(tension_n));
    for (a, b) in commanded.iter().zip(at_end) {
        let (a, b) = (a.unwrap_or(-1.0), b.unwrap_or(-1.0));
        assert!(a == b || (a - b).abs() < 1e-8 * (1.0 + a.abs()), "{a} {b}");
    }
    commanded
}

fn balances(mechanism: &Mechanism, drives: DriveState, tension_n: Option<f64>) -> Option<Vec<MechanismBalance>> {
    let poses = assemble(mechanism).expect("an assembly").poses;
    let roles = roles(mechanism, (0, None), &[], std::iter::empty());
    let at_rest = MechanismAtRest { mechanism, poses: &poses, time_s: 0.0, contacts: &[], drives, roles: &roles };
    let Some(tension_n) = tension_n else {
        return Some(mechanism_balance(&at_rest, 4).unwrap_or_else(|error| panic!("{error}")));
    };
    let loads = LoadsAtRest { tensions_n: vec![tension_n], ..LoadsAtRest::default() };
    match balance_at_rest(&at_rest, &loads, 4).unwrap_or_else(|error| panic!("{error}")) {
        BalanceAtRest::Limits(limits) => Some(limits),
        BalanceAtRest::NotAtRest { .. } => None,
    }
}

fn accelerations(mechanism: &Mechanism, drives: DriveState, tension_n: Option<f64>) -> [Option<f64>; 2] {
    let Some(found) = balances(mechanism, drives, tension_n) else { return [None; 2] };
    [1, 3].map(|index: usize| match &found[index].largest {
        MechanismLimit::Infeasible { .. } => None,
        MechanismLimit::Unlimited => Some(f64::INFINITY),
        MechanismLimit::Limited { acceleration_m_s2, gap, .. } => {
            assert!(*gap < 1e-6, "{gap:e}");
            Some(*acceleration_m_s2)
        }
    })
}

/// Compares the limits along y and against it with those of a torque of the cable on the link in a range.
#[track_caller]
fn assert_range(scene: &Scene, torque_n_m: f64, [least, most]: [f64; 2], what: &str) {
    let expected = [most - torque_n_m, torque_n_m - least].map(|torque| torque / (MASS_KG * COM_M));
    for (found, expected) in limits(scene, PULL_N).iter().zip(expected) {
        let found = found.unwrap_or_else(|| panic!("{what}: not at rest"));
        let size = most.max(torque_n_m) / (MASS_KG * COM_M);
        assert!((found - expected).abs() < 1e-9 * size, "{what}: {found} instead of {expected}");
    }
}

#[test]
fn a_guide_with_friction_balances_the_range_of_the_capstan_equation() {
    let torque = 0.7 * PULL_N * ARM_M;
    for mu in [1e-4, 1e-3, 0.01, 0.1, 0.3, 1.0, 3.0, 3.9] {
        for (wrap, radius) in [(1e-3, 0.0), (0.03, 0.0), (0.5, 0.0), (2.0, 0.0), (3.1, 0.0)].into_iter().chain([
            (1e-3, 0.004),
            (0.1, 0.004),
            (1.5, 0.004),
            (3.5, 0.004),
            (4.6, 0.004),
            (1.0, 1e-4),
        ]) {
            let friction = format!("friction = {{ mu_static = {mu}, mu_dynamic = {} }}", 0.5 * mu);
            let what = format!("mu {mu}, wrap {wrap}, radius {radius}");
            let range = [-1.0, 1.0].map(|sign: f64| PULL_N * ARM_M * (sign * mu * wrap).exp());
            // A load within the range.
            let torque = if range[0] < torque { torque } else { PULL_N * ARM_M };
            let bare = cord(wrap, radius, "", &friction);
            assert_range(&link(torque, &bare), torque, range, &what);
            // The bristle of the law has no effect at rest, and the friction of the place is that of the cable.
            let held = friction.replace(" }", ", presliding = \"50 um\" }");
            assert_range(&link(torque, &cord(wrap, radius, "", &held)), torque, range, &what);
            let own = format!(", {friction}");
            assert_range(&link(torque, &cord(wrap, radius, &own, "")), torque, range, &what);
            // Beyond the range, the link is not at rest.
            for outside in [1.02 * range[1], 0.98 * range[0]] {
                let scene = link(outside, &bare);
                let mechanism = scene.mechanism.as_ref().expect("a mechanism");
                assert_eq!(accelerations(mechanism, DriveState::AtEffort, None), [None; 2], "{what}");
            }
        }
    }
}

/// With μ ψ = 46, the cable holds any load. It still gives no tension of its own.
#[test]
fn a_cable_with_extreme_friction_is_self_locking() {
    let torque = PULL_N * ARM_M;
    let scene = link(torque, &cord(4.6, 0.004, "", "friction = { mu_static = 10 }"));
    let [up, down] = limits(&scene, PULL_N).map(|limit| limit.expect("at rest"));
    assert!(up.is_infinite() && (down - torque / (MASS_KG * COM_M)).abs() < 1e-6 * down, "{up} {down}");
}

#[test]
fn rollers_ends_and_pulleys_off_the_path_do_not_rub() {
    let torque = PULL_N * ARM_M;
    let friction = "friction = { mu_static = 0.3 }";
    let exact = [torque; 2];
    for radius in [0.0, 0.004] {
        assert_range(&link(torque, &cord(1.0, radius, ", roller = true", friction)), torque, exact, "roller");
        // Pulled from the link, the cable has its tension there.
        let last = format!("from = \"last\"\n{friction}");
        assert_range(&link(torque, &cord(1.0, radius, "", &last)), torque, exact, "from the last end");
    }
    // A pulley on the other side of a straight cable.
    let path = |x: f64| {
        format!(
            "[tendons.cord]\npath = [{{ eyelet = \"ground\", at = [\"40 mm\", \"80 mm\"] }}, {{ pulley = \"ground\", \
             radius = \"4 mm\", turn = \"ccw\", at = [\"{x} mm\", \"40 mm\"] }}, {{ eyelet = \"link\", at = [\"40 mm\", \
             \"0 mm\"] }}]\n{friction}\n[actuators.pull]\ntendon = \"cord\"\ntension = \"{PULL_N} N\"\n"
        )
    };
    assert_range(&link(torque, &path(44.5)), torque, exact, "off the path");
    assert!(limits(&link(torque, &path(43.0)), PULL_N)[0].is_some_and(|limit| limit > 1.0), "on the path");
}

#[test]
fn the_friction_of_guides_in_a_row_is_that_of_their_total_wrap() {
    let torque = PULL_N * ARM_M;
    for (mu, roller) in [(0.05, false), (0.3, false), (1.0, false), (0.3, true)] {
        // Two right angles: down to the first guide, along −x to the second one, and down to the link.
        let middle = if roller { ", roller = true" } else { "" };
        let sections = format!(
            "[tendons.cord]\npath = [{{ eyelet = \"ground\", at = [\"80 mm\", \"120 mm\"] }}, {{ eyelet = \"ground\", at = \
             [\"80 mm\", \"60 mm\"]{middle} }}, {{ eyelet = \"ground\", at = [\"40 mm\", \"60 mm\"] }}, {{ eyelet = \
             \"link\", at = [\"40 mm\", \"0 mm\"] }}]\nfriction = {{ mu_static = {mu} }}\n\
             [actuators.pull]\ntendon = \"cord\"\ntension = \"{PULL_N} N\"\n"
        );
        let wrap = std::f64::consts::FRAC_PI_2 * if roller { 1.0 } else { 2.0 };
        let range = [-1.0, 1.0].map(|sign: f64| PULL_N * ARM_M * (sign * mu * wrap).exp());
        assert_range(&link(torque, &sections), torque, range, &format!("{mu} {roller}"));
    }
}

/// A load that grows to 0.9 of the limit at rest moves the link by less than the deflection of the cable before it slips; one of
/// 1.1 moves it away. Both models.
#[test]
fn simulations_hold_up_to_the_limit_at_rest() {
    let torque = PULL_N * ARM_M;
    for (mu, wrap, radius) in [(0.15, 1.2, 0.0), (0.4, 3.0, 0.0), (0.05, 4.0, 0.004)] {
        let friction = format!("friction = {{ mu_static = {mu}, mu_dynamic = {mu}, presliding = \"50 um\" }}");
        let sections = cord(wrap, radius, "", &friction);
        let at_rest = limits(&link(torque, &sections), PULL_N);
        for (limit, sign) in at_rest.into_iter().zip([-1.0, 1.0]) {
            let limit = limit.expect("at rest");
            for (part, holds) in [(0.9, true), (1.1, false)] {
                // The inertial force of the ground's acceleration, as a torque.
                let load = sign * part * limit * MASS_KG * COM_M;
                let ramp = format!(
                    "{sections}\n[actuators.load]\njoint = \"hinge\"\ntimes = [\"0 ms\", \"200 ms\"]\n\
                     torques = [\"0 N*m\", \"{load} N*m\"]\n"
                );
                for model in [Model::Analytic, Model::Engine] {
                    let mut scene = link(torque, &ramp);
                    scene.duration_s = 0.3;
                    let what = format!("{model:?}: {mu} {wrap} {radius}, {part} of {limit} m/s^2, {sign}");
                    let end = run(model, &scene, &mut ()).unwrap_or_else(|_| panic!("{what}: a run"));
                    let state = end.last.joint_state(0);
                    let bound = 1.5 * 50e-6 / ARM_M;
                    assert_eq!(state.angle_rad.abs() < bound, holds, "{what}: {state:?}");
                    assert!(holds || state.angle_rad * sign > 0.1, "{what}: {state:?}");
                }
            }
        }
    }
}

/// A pulley that is fixed to the link, with its centre on the hinge: the friction of the cable turns the link.
#[test]
fn the_friction_on_a_pulley_turns_its_body() {
    let radius = 0.02;
    for mu in [1e-3, 0.02, 0.2, 1.0] {
        for (turn, side) in [("ccw", 1.0), ("cw", -1.0)] {
            for from in ["first", "last"] {
                let sections = format!(
                    "[tendons.cord]\npath = [{{ eyelet = \"ground\", at = [\"50 mm\", \"{} mm\"] }}, {{ pulley = \"link\", \
                     radius = \"20 mm\", turn = \"{turn}\" }}, {{ eyelet = \"ground\", at = [\"50 mm\", \"{} mm\"] }}]\n\
                     from = \"{from}\"\nfriction = {{ mu_static = {mu} }}\n\
                     [actuators.pull]\ntendon = \"cord\"\ntension = \"{PULL_N} N\"\n",
                    side * 20.0,
                    side * -20.0
                );
                // From (50, 20) along −x, half around the pulley, and back along x.
                let turning = if from == "first" { side } else { -side };
                let end = |sign: f64| PULL_N * radius * ((sign * mu * std::f64::consts::PI).exp() - 1.0);
                let [a, b] = [-1.0, 1.0].map(|sign| turning * end(sign));
                let torque = 0.3 * a + 0.3 * b;
                let scene = link(torque, &sections);
                let expected = [a.max(b) - torque, torque - a.min(b)].map(|torque| torque / (MASS_KG * COM_M));
                for (found, expected) in limits(&scene, PULL_N).iter().zip(expected) {
                    let found = found.expect("at rest");
                    assert!((found - expected).abs() < 1e-7 * expected, "{mu} {turn} {from}: {found} {expected}");
                }
            }
        }
    }
}

/// A spool on the hinge winds the cable at its end or behind the guide.
#[test]
fn spools_have_the_tension_of_their_end() {
    let radius = 0.04;
    for mu in [0.01, 0.2, 1.5] {
        for (end, exponent) in [("near", 0.0), ("far", mu * std::f64::consts::FRAC_PI_2)] {
            let key = if end == "far" { ", end = \"far\"" } else { "" };
            let sections = format!(
                "[tendons.cord]\npath = [{{ eyelet = \"ground\", at = [\"0 mm\", \"50 mm\"] }}, {{ eyelet = \"ground\", at = \
                 [\"50 mm\", \"50 mm\"] }}, {{ eyelet = \"ground\", at = [\"50 mm\", \"0 mm\"] }}]\n\
                 spools = [{{ joint = \"hinge\", radius = \"40 mm\", turn = \"cw\"{key} }}]\n\
                 friction = {{ mu_static = {mu} }}\n\
                 [actuators.pull]\ntendon = \"cord\"\ntension = \"{PULL_N} N\"\n"
            );
            let torque = PULL_N * radius;
            let range = [-1.0, 1.0].map(|sign: f64| torque * (sign * exponent).exp());
            assert_range(&link(torque, &sections), torque, range, &format!("{mu} {end}"));
        }
    }
}

/// Two links are pulled by one cable, one of them behind a guide. A blocked actuator gives any tension: the load of one link
/// determines the tension, and the range of the other.
#[test]
fn a_blocked_cable_shares_its_tension_within_the_friction() {
    let (mu, back) = (0.4, 0.5);
    let second = r#"
        [bodies.second]
        mass = "1 g"
        inertia = "1e-6 kg*m^2"
        [joints.second]
        bodies = ["ground", "second"]
        points = [["0 mm", "200 mm"], ["0 mm", "0 mm"]]
        start = "0 deg"
        [springs.second]
        joint = "second"
        stiffness = "1e-9 N*m/rad"
        torque = "-0.5 N*m"
    "#;
    // The cable leads from the ground through the second link, which it turns with T_1 − T_2 along y, to the guide above the
    // first link.
    let sections = format!(
        "{second}\n[tendons.cord]\npath = [{{ eyelet = \"ground\", at = [\"40 mm\", \"300 mm\"] }}, {{ eyelet = \"second\", at = \
         [\"40 mm\", \"0 mm\"], roller = true }}, {{ eyelet = \"ground\", at = [\"80 mm\", \"200 mm\"] }}, {{ eyelet = \
         \"ground\", at = [\"80 mm\", \"60 mm\"], roller = true }}, {{ eyelet = \"ground\", at = [\"40 mm\", \"60 mm\"], \
         roller = true }}, {{ eyelet = \"link\", at = [\"40 mm\", \"0 mm\"] }}]\nfriction = {{ mu_static = {mu} }}\n\
         [actuators.pull]\ntendon = \"cord\"\ntension = \"0 N\"\n"
    );
    // The second link needs T_1 · 40 mm = 0.5 N·m (the strand along x has no arm).
    let first = back / ARM_M;
    let range = [-1.0, 1.0].map(|sign: f64| first * ARM_M * (sign * mu * std::f64::consts::FRAC_PI_2).exp());
    let torque = 0.9 * first * ARM_M;
    let scene = link(torque, &sections);
    let mechanism = scene.mechanism.as_ref().expect("a mechanism");
    let found = balances(mechanism, DriveState::Blocked, None).expect("at rest");
    // The inertia of the second link has no moment.
    for (index, expected) in [(1, range[1] - torque), (3, torque - range[0])] {
        let MechanismLimit::Limited { acceleration_m_s2, tensions_n, motion, rubbing, .. } = &found[index].largest
        else {
            panic!("{found:?}")
        };
        let expected = expected / (MASS_KG * COM_M);
        assert!((acceleration_m_s2 - expected).abs() < 1e-7 * expected, "{acceleration_m_s2} {expected}");
        assert!((tensions_n[0] - first).abs() < 1e-7 * first, "{tensions_n:?}");
        assert_eq!((motion.len(), &rubbing[..]), (2, &["cord[2]".to_string()][..]));
    }
}
