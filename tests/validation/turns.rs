//! Whole turns of joints: angles are continuous in both models, whatever closes the loop and whatever acts on the joint.

use crate::support::laws::mechanism_scene;
use crate::support::runs::{CollectSink, load, run_engine, run_to_end, seeds};
use crate::support::scenes::loops::{RandomLoop, quick_line, random_assur_loop, random_loop};
use phalanx::mechanism::{JointCombination, JointKind, Mechanism, Spring, SpringKind};
use phalanx::scene::{ENGINE_MAX_STEP_S, Integrator, Preset, Scene, Stepping, parse_any};
use phalanx::trace::{self, EventKind, Model, Sample, Simulation};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Length whose change counts as 1 rad.
const LENGTH_M: f64 = 0.03;

fn scene(mechanism: &Mechanism, duration_s: f64) -> Scene {
    let mut scene = mechanism_scene(mechanism.clone(), duration_s);
    scene.integrator = Integrator::preset(Preset::Engineering);
    scene.engine.stepping = Stepping::Adaptive { tolerance_m: 3e-8, max_step_s: ENGINE_MAX_STEP_S };
    scene.log.numeric_hz = 400.0;
    scene
}

fn parse(text: &str) -> Scene {
    parse_any(text, "scene.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Samples of a run that may end early, and the reason.
fn run(model: Model, scene: &Scene) -> (Vec<Sample>, Option<String>) {
    let mut sink = CollectSink::default();
    let end = trace::run(model, scene, &mut sink);
    (sink.samples, end.err().map(|error| error.to_string()))
}

/// Coordinates of all joints, rad or [`LENGTH_M`].
fn coordinates(mechanism: &Mechanism, sample: &Sample) -> Vec<f64> {
    let coordinate = |(index, kind): (usize, JointKind)| {
        let unit = if kind == JointKind::Revolute { 1.0 } else { LENGTH_M };
        sample.joint_state(index).angle_rad / unit
    };
    mechanism.joints.iter().map(|joint| joint.kind).enumerate().map(coordinate).collect()
}

/// Angles of all bodies.
fn angles(sample: &Sample) -> Vec<f64> {
    sample.bodies().map(|body| body.angle_rad).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Largest difference of the change of an angle between two samples from its rates.
fn largest_jump(mechanism: &Mechanism, samples: &[Sample]) -> f64 {
    let jumps = samples.windows(2).flat_map(|pair| {
        let dt = pair[1].time_s - pair[0].time_s;
        let joints = (0..mechanism.joints.len()).filter(|joint| mechanism.joints[*joint].kind == JointKind::Revolute);
        joints.map(move |joint| {
            let [from, to] = [&pair[0], &pair[1]].map(|sample| sample.joint_state(joint));
            (to.angle_rad - from.angle_rad - 0.5 * dt * (from.rate_rad_s + to.rate_rad_s)).abs()
        })
    });
    jumps.fold(0.0, f64::max)
}

/// What a comparison of both models finds.
struct Found {
    /// Largest difference of the joints and of the angles of all bodies.
    difference: f64,
    jump: f64,
    /// Largest number of turns of a joint.
    turns: f64,
}

/// Compares both models of a loop at all samples.
fn compare(of: &RandomLoop) -> Found {
    let scene = scene(&of.mechanism, of.duration_s);
    let (analytic, end) = run(Model::Analytic, &scene);
    let (engine, engine_end) = run(Model::Engine, &scene);
    assert!(end.is_none() && engine_end.is_none(), "{}: {end:?}, engine {engine_end:?}", of.description);
    let mut difference = 0.0f64;
    for sample in &analytic {
        let index = engine.partition_point(|other| other.time_s < sample.time_s - 1e-9);
        let Some(other) = engine.get(index).filter(|other| other.time_s < sample.time_s + 1e-9) else { continue };
        let of_joints = [sample, other].map(|sample| coordinates(&of.mechanism, sample));
        difference = difference.max(largest_difference(&of_joints[0], &of_joints[1]));
        difference = difference.max(largest_difference(&angles(sample), &angles(other)));
    }
    let [first, last] =
        [analytic.first(), analytic.last()].map(|sample| coordinates(&of.mechanism, sample.expect("a sample")));
    Found {
        difference,
        jump: largest_jump(&of.mechanism, &analytic).max(largest_jump(&of.mechanism, &engine)),
        turns: largest_difference(&first, &last) / TAU,
    }
}

/// Compares loops with these seeds; returns the largest difference and turns.
fn compare_all(random_loop: fn(u64) -> RandomLoop, seeds: impl Iterator<Item = u64>) -> (f64, f64) {
    let (mut largest, mut turns) = (0.0f64, 0.0f64);
    let mut failures = Vec::new();
    for seed in seeds {
        let of = random_loop(seed);
        let found = compare(&of);
        if !(found.difference < 2e-3 && found.jump < 1.0) {
            let Found { difference, jump, .. } = found;
            failures.push(format!("seed {seed}, {}: {difference:e}, jump {jump:e}", of.description));
        }
        (largest, turns) = (largest.max(found.difference), turns.max(found.turns));
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    (largest, turns)
}

/// Slider-cranks, four-bars, swinging guides and five-bars, with stops, springs, couplings, spools and servos.
#[test]
fn random_loops_turn_alike_in_both_models() {
    let (_, turns) = compare_all(random_loop, (0..20).map(|k| 29 * k));
    assert!(turns > 2.0, "{turns} turns");
}

/// 500 of them; `PHALANX_SEEDS` is the range of seeds.
#[test]
#[ignore = "a minute"]
fn many_random_loops_turn_alike_in_both_models() {
    let (largest, turns) = compare_all(random_loop, seeds("0..500"));
    println!("largest difference {largest:e}, at most {turns} turns");
}

/// Six-bars without a row of dyads, with the same components on joints that Newton's method places.
#[test]
fn assur_groups_turn_alike_in_both_models() {
    let (_, turns) = compare_all(random_assur_loop, (0..14).map(|k| 5 * k));
    assert!(turns > 0.3, "{turns} turns");
}

/// 200 of them; `PHALANX_SEEDS` is the range of seeds.
#[test]
#[ignore = "a minute"]
fn many_assur_groups_turn_alike_in_both_models() {
    let (largest, turns) = compare_all(random_assur_loop, seeds("0..200"));
    println!("largest difference {largest:e}, at most {turns} turns");
}

/// The line between the pivots turns by more than half a turn between two steps that the equations of motion alone would
/// allow. The angle of the coupler follows from the closed form, unwound in small steps of the crank.
#[test]
fn a_line_that_turns_quickly_is_counted() {
    for (gap_m, with_spring) in [(5e-3, false), (5e-3, true), (1e-3, false), (5e-5, true)] {
        let mut mechanism = quick_line(gap_m);
        if with_spring {
            mechanism.springs.push(Spring {
                name: "spring".to_string(),
                kind: SpringKind::Torsional { on: JointCombination::of_joint(1), preload: 0.0 },
                stiffness: 1e-14,
                damping: 0.0,
                rest: 0.0,
            });
        }
        let (samples, end) = run(Model::Analytic, &scene(&mechanism, 0.3));
        assert!(end.is_none(), "{end:?}");
        let line = |crank: f64| [0.03 - gap_m - 0.03 * crank.cos(), -0.03 * crank.sin()];
        let coupler = |crank: f64| {
            let d = line(crank);
            let (length, l, m) = (d[0].hypot(d[1]), 0.03, 0.03 + 0.5 * gap_m);
            d[1].atan2(d[0]) + ((length * length + l * l - m * m) / (2.0 * l * length)).acos()
        };
        let (mut crank, mut expected) = (-FRAC_PI_2, coupler(-FRAC_PI_2));
        expected += TAU * ((samples[0].joint_state(1).angle_rad + crank - expected) / TAU).round();
        for sample in &samples {
            let [to, pin] = [0, 1].map(|joint| sample.joint_state(joint).angle_rad);
            while crank < to {
                // A hundredth of the length of the line.
                let d = line(crank);
                crank = to.min(crank + 0.3 * d[0].hypot(d[1]));
                let angle = coupler(crank);
                expected = angle + TAU * ((expected - angle) / TAU).round();
            }
            assert!((to + pin - expected).abs() < 1e-6, "gap {gap_m} m: {} instead of {expected}", to + pin);
        }
        assert!(crank > 1.4, "{crank}");
    }
}

/// Pieces, copies and readings inside steps count the turns of a run.
#[test]
fn simulations_and_their_copies_count_turns() {
    for seed in [4, 15, 31] {
        let of = random_loop(seed);
        let scene = scene(&of.mechanism, of.duration_s);
        let (samples, end) = run(Model::Analytic, &scene);
        assert!(end.is_none(), "{}: {end:?}", of.description);
        let last = samples.last().expect("a sample");
        let mut simulation = Simulation::new(&scene, Model::Analytic).unwrap_or_else(|error| panic!("{error}"));
        let mut read = vec![simulation.sample().clone()];
        for piece in 1..=250 {
            if piece % 50 == 0 {
                simulation = simulation.clone();
            }
            let time_s = of.duration_s * f64::from(piece) / 250.0;
            simulation.advance_to(time_s).unwrap_or_else(|error| panic!("{error}"));
            read.push(simulation.sample().clone());
        }
        assert!(largest_jump(&of.mechanism, &read) < 0.5, "{}", of.description);
        assert_eq!(simulation.sample(), last, "{}", of.description);
    }
}

/// A slider-crank that coasts at 60 rad/s.
const SLIDER_CRANK: &str = r#"
kind = "mechanism"
duration = "150 ms"
bodies.crank = { mass = "50 g", inertia = "2e4 g*mm^2", com = ["12 mm", "0 mm"] }
bodies.rod = { mass = "40 g", inertia = "5e4 g*mm^2", com = ["50 mm", "0 mm"], guess = { at = ["29 mm", "9 mm"], angle = "-0.09 rad" } }
bodies.slider = { mass = "100 g", inertia = "1e4 g*mm^2", guess = { at = ["128 mm", "0 mm"] } }
joints.wrist = { bodies = ["rod", "slider"], points = [["100 mm", "0 mm"], ["0 mm", "0 mm"]] }
log = { numeric_rate = "400 Hz" }
[joints.slide]
type = "prismatic"
bodies = ["ground", "slider"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
[joints.crank]
bodies = ["ground", "crank"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "0.3 rad"
start_rate = "60 rad/s"
[joints.pin]
bodies = ["crank", "rod"]
points = [["30 mm", "0 mm"], ["0 mm", "0 mm"]]
"#;

/// Coordinates of the joints `names` at the end of both models, which must agree, in degrees.
fn ends_in_both<const K: usize>(scene: &Scene, names: [&str; K]) -> [f64; K] {
    let mechanism = scene.mechanism.as_ref().expect("a mechanism");
    let index = |name: &str| mechanism.joints.iter().position(|joint| joint.name == name).expect("a joint");
    let [analytic, engine] = [run_to_end(scene), run_engine(scene)]
        .map(|(outcome, _)| names.map(|name| outcome.last.joint_state(index(name)).angle_rad.to_degrees()));
    assert!(largest_difference(&analytic, &engine) < 1e-4, "{analytic:?}, engine {engine:?}");
    analytic
}

/// The pin turns by -286° before it meets its stop at -5 rad.
#[test]
fn a_stop_of_a_pin_is_met_after_most_of_a_turn() {
    let text = SLIDER_CRANK.replace(", com = [\"12 mm\", \"0 mm\"]", "");
    let scene = parse(&format!(
        "{text}lower = \"-5 rad\"\nstop = \"stop\"\n[laws.stop]\nstiffness = 2e4\ndamping = \"0.2 s/rad\"\n"
    ));
    let runs = [run_to_end(&scene).1, run_engine(&scene).1];
    for run in runs {
        assert!((run.event_time_s(0, EventKind::TouchDown) - 0.112_019_26).abs() < 1e-8);
    }
    let [crank, pin] = ends_in_both(&scene, ["crank", "pin"]);
    assert!((crank - 295.4401).abs() < 1e-4 && (pin + 279.7216).abs() < 1e-4, "{crank}, {pin}");
}

/// A coupled gear turns as far as the pin does.
#[test]
fn a_gear_on_a_pin_turns_with_it() {
    let scene = parse(&format!(
        r#"{SLIDER_CRANK}
[bodies.gear]
mass = "20 g"
inertia = "3e3 g*mm^2"
guess = {{ at = ["-100 mm", "0 mm"] }}
[joints.gear]
bodies = ["ground", "gear"]
points = [["-100 mm", "0 mm"], ["0 mm", "0 mm"]]
[couplings.c]
joints = ["pin", "gear"]
factors = [1.0, 1.0]
value = "-0.3887726126291773 rad"
[springs.g]
type = "torsional"
joint = "gear"
stiffness = "0.01 N*m/rad"
"#
    ));
    let [crank, pin, gear] = ends_in_both(&scene, ["crank", "pin", "gear"]);
    assert!((crank - 301.2203).abs() < 1e-3 && (pin + 286.3546).abs() < 1e-3, "{crank}, {pin}");
    assert!((pin + gear + 0.388_772_612_629_177_3_f64.to_degrees()).abs() < 1e-9, "{pin}, {gear}");
}

/// A spool winds up its cable by more than half a turn.
#[test]
fn a_spool_on_a_pin_winds_up_its_cable() {
    let scene = parse(&format!(
        r#"{SLIDER_CRANK}
[tendons.c]
stiffness = "20 N/m"
rest = "0.14328876591782175 m"
damping = "0.01 N*s/m"
path = [{{ eyelet = "ground", at = ["0.3 m", "0 m"] }}, {{ eyelet = "slider", at = ["0.02 m", "0 m"] }}]
spools = [{{ joint = "pin", radius = "4 mm", turn = "cw" }}]
"#
    ));
    let [crank, pin] = ends_in_both(&scene, ["crank", "pin"]);
    assert!((crank - 327.7540).abs() < 1e-3 && (pin + 318.5432).abs() < 1e-3, "{crank}, {pin}");
}

/// A finger without limit and object whose ground links make several turns relative to each other; the first is `l11_mm`.
fn turning_finger(l11_mm: f64, assembly: &str, placement: &str) -> Scene {
    let [l21_mm, l12_mm, l22_mm] = if l11_mm < 20.0 { [30.0, 45.0, 35.0] } else { [10.0, 35.0, 45.0] };
    parse(&format!(
        r#"
duration = "150 ms"
gravity = ["0 m/s^2", "0 m/s^2"]
assembly = "{assembly}"
object = {{ present = false }}
limit = {{ enabled = false }}
lengths = {{ l11 = "{l11_mm} mm", l12 = "{l12_mm} mm", l21 = "{l21_mm} mm", l22 = "{l22_mm} mm", t22 = "20 mm", phi22 = "90 deg" }}
motor = {{ profile = "half-sine", torque = "5 N*mm", pulse = "5 ms" }}
spring = {{ type = "torsional", placement = "{placement}", stiffness = "0.2 N*mm/rad" }}
initial = {{ q11 = "-15 deg", q21 = "60 deg", qd11 = "120 rad/s", qd21 = "-20 rad/s" }}
"#
    ))
}

#[test]
fn fingers_count_turns_in_both_models() {
    let mut scenes: Vec<Scene> = ["other-assembly", "hard/a-turn-apart"].map(load).to_vec();
    for l11_mm in [10.0, 30.0] {
        for assembly in ["reference", "other"] {
            for placement in ["q22", "q12", "q21-q11", "q11+q12-(q21+q22)"] {
                scenes.push(turning_finger(l11_mm, assembly, placement));
            }
        }
    }
    let mut turns = 0.0f64;
    for scene in scenes {
        let angles = |sample: &Sample| -> Vec<f64> {
            (0..5).map(|joint| sample.joint_state(joint).angle_rad).chain([sample.finger(0).q13_rad]).collect()
        };
        let runs = [run_to_end(&scene), run_engine(&scene)];
        for (_, run) in &runs {
            for pair in run.samples.windows(2) {
                let change = largest_difference(&angles(&pair[0]), &angles(&pair[1]));
                assert!(change < 1.0, "{}: {change} at {} s", scene.source, pair[1].time_s);
            }
        }
        let [analytic, engine] = runs.map(|(outcome, _)| outcome.last);
        let difference = largest_difference(&angles(&analytic), &angles(&engine));
        // Errors grow over several turns without damping; a turn is 6.3 rad.
        assert!(difference < 1e-3, "{}: {:?}, engine {:?}", scene.source, angles(&analytic), angles(&engine));
        let spring_j = [&analytic, &engine].map(|sample| sample.energy().spring_j);
        assert!((spring_j[0] - spring_j[1]).abs() < 1e-8 + 1e-3 * spring_j[0], "{}: {spring_j:?}", scene.source);
        turns = turns.max((analytic.joint_state(1).angle_rad / TAU).abs());
    }
    assert!(turns > 1.5, "{turns}");
}

/// A spring on two joints of a loop, whose sum depends on the angles of three bodies.
#[test]
fn springs_on_any_joints_of_a_loop_act_alike() {
    let with_sum = |joints: &str, factors: &str| {
        parse(&format!(
            "{SLIDER_CRANK}[springs.sum]\ntype = \"torsional\"\njoints = {joints}\nfactors = {factors}\nstiffness = \"2 \
             N*mm/rad\"\n"
        ))
    };
    let [both, wrist] = ends_in_both(&with_sum("[\"pin\", \"wrist\"]", "[1.0, 0.7]"), ["pin", "wrist"]);
    assert!(both < -180.0 && wrist.abs() < 30.0, "{both}, {wrist}");
}

/// A free body that turns by several turns in a step of the engine.
#[test]
fn a_fast_spin_is_counted_in_both_models() {
    let scene = parse(
        r#"
kind = "bodies"
duration = "50 ms"
[discs.fast]
mass = "100 g"
radius = "10 mm"
centre = ["0 mm", "0 mm"]
motion = "free"
spin = "100000 rad/s"
"#,
    );
    for (_, run) in [run_to_end(&scene), run_engine(&scene)] {
        let last = run.samples.last().expect("a sample");
        assert!((last.body(0).angle_rad - 5000.0).abs() < 1e-6, "{}", last.body(0).angle_rad);
    }
}
