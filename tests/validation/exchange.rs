//! Exchange of coordinates: where the coordinates of the analytic model fail although the mechanism is regular, others take
//! over, so that the motion does not depend on the joint with the start.

use crate::support::laws::mechanism_scene;
use crate::support::runs::{CollectSink, run_engine, run_to_end, seeds};
use crate::support::scenes::loops::{on_moving_base, random_assur, random_linkage, with_start};
use phalanx::law::{Bristle, ContactLaw, Damping, FrictionKind, FrictionLaw, NormalLaw};
use phalanx::mechanism::structure::{Group, find_groups};
use phalanx::mechanism::{ContactPair, ForcePoint, JointKind, Mechanism, Outline, OutlineId, OutlineShape, assemble};
use phalanx::scene::{ENGINE_MAX_STEP_S, Integrator, Method, Preset, Scene, Stepping, parse_any};
use phalanx::trace::{self, BodyState, EventKind, Model, Sample, Simulation};

/// A crank that is driven from its slider, at 40 rad/s; it passes its dead centres every 79 ms.
const DRIVEN_FROM_SLIDER: &str = r#"
kind = "mechanism"
duration = "400 ms"
gravity = ["0 m/s^2", "0 m/s^2"]
bodies.crank = { mass = "50 g", inertia = "2e-5 kg*m^2", com = ["12 mm", "0 mm"], guess = { angle = "0.3 rad" } }
bodies.rod = { mass = "40 g", inertia = "5e-5 kg*m^2", com = ["50 mm", "0 mm"], guess = { at = ["28.660094673768177 mm", "8.865606199840186 mm"], angle = "-0.08877261262917731 rad" } }
bodies.slider = { mass = "100 g", inertia = "1e-5 kg*m^2", guess = { at = ["128.26632453269496 mm", "0 mm"] } }
joints.pin = { bodies = ["crank", "rod"], points = [["30 mm", "0 mm"], ["0 mm", "0 mm"]] }
joints.wrist = { bodies = ["rod", "slider"], points = [["100 mm", "0 mm"], ["0 mm", "0 mm"]] }
log = { numeric_rate = "400 Hz" }
[joints.crank]
bodies = ["ground", "crank"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
[joints.slide]
type = "prismatic"
bodies = ["ground", "slider"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "128.26632453269496 mm"
start_rate = "-0.4566616861689646 m/s"
[actuators.motor]
joint = "crank"
torque = "0 N*mm"
"#;

/// A piston that pushes its crank, with a start of the piston.
const PISTON: &str = r#"
kind = "mechanism"
duration = "400 ms"
bodies.crank = { mass = "50 g", inertia = "2e-5 kg*m^2", com = ["12 mm", "0 mm"], guess = { angle = "1.2 rad" } }
bodies.rod = { mass = "40 g", inertia = "5e-5 kg*m^2", com = ["50 mm", "0 mm"], guess = { at = ["10.870733 mm", "27.961173 mm"], angle = "-0.283390 rad" } }
bodies.slider = { mass = "100 g", inertia = "1e-5 kg*m^2", guess = { at = ["106.882049 mm", "0 mm"] } }
joints.crank = { bodies = ["ground", "crank"], points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]] }
joints.pin = { bodies = ["crank", "rod"], points = [["30 mm", "0 mm"], ["0 mm", "0 mm"]] }
joints.wrist = { bodies = ["rod", "slider"], points = [["100 mm", "0 mm"], ["0 mm", "0 mm"]] }
actuators.p = { joint = "slide", force = "-5 N" }
[joints.slide]
type = "prismatic"
bodies = ["ground", "slider"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "106.882048780 mm"
start_rate = "-0.622540661145 m/s"
"#;

fn parse(text: &str) -> Scene {
    parse_any(text, "scene.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn mechanism(scene: &Scene) -> &Mechanism {
    scene.mechanism.as_ref().expect("a mechanism")
}

/// Coordinates of all joints, rad or 30 mm.
fn coordinates(mechanism: &Mechanism, sample: &Sample) -> Vec<f64> {
    let unit = |kind: JointKind| if kind == JointKind::Revolute { 1.0 } else { 0.03 };
    let joints = mechanism.joints.iter().enumerate();
    joints.map(|(index, joint)| sample.joint_state(index).angle_rad / unit(joint.kind)).collect()
}

/// Largest difference of the coordinates of all joints at the samples that both runs have.
fn difference(mechanism: &Mechanism, [samples, others]: [&[Sample]; 2]) -> f64 {
    let mut largest = 0.0f64;
    for sample in samples {
        let index = others.partition_point(|other| other.time_s < sample.time_s);
        let Some(other) = others.get(index).filter(|other| other.time_s == sample.time_s) else { continue };
        let both = coordinates(mechanism, sample).into_iter().zip(coordinates(mechanism, other));
        largest = both.map(|(a, b)| (a - b).abs()).fold(largest, f64::max);
    }
    largest
}

fn crank_at_end(scene: &Scene) -> f64 {
    let index = mechanism(scene).joints.iter().position(|joint| joint.name == "crank").expect("a crank");
    run_to_end(scene).0.last.joint_state(index).angle_rad
}

#[test]
fn a_piston_turns_its_crank_past_the_dead_centres() {
    let scene = parse(PISTON);
    for integrator in [scene.integrator, Integrator { method: Method::RadauIIa5, ..scene.integrator }] {
        let crank = crank_at_end(&Scene { integrator, ..scene.clone() });
        assert!((crank - 2.888_732_0).abs() < 1e-6, "{crank}");
    }
}

#[test]
fn a_crank_that_is_driven_from_its_slider_turns_as_one_with_its_own_start() {
    let scene = parse(DRIVEN_FROM_SLIDER);
    let mut own = scene.clone();
    let joints = &mut own.mechanism.as_mut().expect("a mechanism").joints;
    for joint in joints.iter_mut() {
        let is_crank = joint.name == "crank";
        (joint.start, joint.start_rate) = (is_crank.then_some(0.3), if is_crank { 40.0 } else { 0.0 });
    }
    let ends = [&scene, &own].map(crank_at_end);
    // The rate of the slider in the scene has 16 digits, its angle to the crank 1e-14.
    assert!((ends[0] - ends[1]).abs() < 1e-6, "{ends:?}");
    let engine = run_engine(&scene).0.last.joint_state(0).angle_rad;
    assert!((run_to_end(&scene).0.last.joint_state(0).angle_rad - engine).abs() < 1e-5, "{ends:?}, {engine}");
}

/// Friction with bristles in the joints: their states are carried over, and energy is balanced.
#[test]
fn bristles_and_energies_are_carried_over() {
    let with_friction = |mut scene: Scene| {
        for joint in scene.mechanism.as_mut().expect("a mechanism").joints.iter_mut().take(2) {
            joint.friction = Some(FrictionLaw {
                mu_static: 4e-3,
                mu_dynamic: 3e-3,
                v_static_m_s: 0.1,
                v_dynamic_m_s: 1.0,
                kind: FrictionKind::Bristle(Bristle { damping_n_s_per_m: 1e-3, relaxation_s: 1e-3 }),
            });
        }
        Scene { integrator: scene.integrator.with_rtol(1e-9), ..scene }
    };
    let scene = with_friction(parse(DRIVEN_FROM_SLIDER));
    let own = {
        let text = DRIVEN_FROM_SLIDER
            .replace("start = \"128.26632453269496 mm\"\nstart_rate = \"-0.4566616861689646 m/s\"\n", "");
        let crank = "[joints.crank]\nstart = \"0.3 rad\"\nstart_rate = \"40 rad/s\"\n";
        with_friction(parse(&text.replace("[joints.crank]\n", crank)))
    };
    let [with_slider, with_crank] = [&scene, &own].map(run_to_end);
    let found = difference(mechanism(&scene), [&with_slider.1.samples, &with_crank.1.samples]);
    assert!(found < 1e-6, "{found:e}");
    let energy = |of: &Sample| of.energy();
    let [a, b] = [&with_slider.0.last, &with_crank.0.last].map(energy);
    assert!((a.dissipated_j - b.dissipated_j).abs() < 1e-8, "{a:?}, {b:?}");
    assert!(a.dissipated_j > 0.02, "{a:?}");
}

/// Pieces and copies of a simulation, before and after exchanges, give the samples of the run.
#[test]
fn simulations_and_their_copies_exchange_coordinates() {
    assert_pieces_give_the_run(&parse(DRIVEN_FROM_SLIDER));
}

/// The coordinates near which Newton's method starts belong to the state of a simulation.
#[test]
fn simulations_of_assur_groups_and_their_copies_give_the_run() {
    let (_, (mechanism, crank, rate), _) = assur(0);
    let scene = mechanism_scene(with_start(&mechanism, 0, crank, rate), 0.4);
    let mut scene = Scene { integrator: Integrator::preset(Preset::Engineering), ..scene };
    scene.log.numeric_hz = 400.0;
    assert_pieces_give_the_run(&scene);
}

/// Compares a simulation over 0.4 s, in pieces and from a copy, with a run.
fn assert_pieces_give_the_run(scene: &Scene) {
    let (_, run) = run_to_end(scene);
    let last = run.samples.last().expect("a sample");
    let mut simulation = Simulation::new(scene, Model::Analytic).unwrap_or_else(|error| panic!("{error}"));
    let mut saved = simulation.clone();
    for piece in 1..=200 {
        simulation.advance_to(0.4 * f64::from(piece) / 200.0).unwrap_or_else(|error| panic!("{error}"));
        if piece == 70 {
            saved = simulation.clone();
        }
    }
    assert_eq!(simulation.sample(), last);
    simulation.restore(&saved).unwrap_or_else(|error| panic!("{error}"));
    assert!(simulation.time_s() < 0.15);
    simulation.advance_to(0.4).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(simulation.sample(), last);
}

/// A parallelogram is flat at a fold; the sentence names its joints and the remedies.
#[test]
fn a_fold_ends_a_run_with_its_joints_and_remedies() {
    let scene = parse(
        r#"
kind = "mechanism"
duration = "200 ms"
bodies.crank = { mass = "50 g", inertia = "2e-5 kg*m^2", guess = { angle = "1 rad" } }
bodies.rod = { mass = "40 g", inertia = "5e-5 kg*m^2", guess = { at = ["16.2 mm", "25.2 mm"] } }
bodies.rocker = { mass = "50 g", inertia = "2e-5 kg*m^2", guess = { at = ["50 mm", "0 mm"], angle = "1 rad" } }
joints.a = { bodies = ["ground", "crank"], points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]], start = "1 rad", start_rate = "-20 rad/s" }
joints.b = { bodies = ["crank", "rod"], points = [["30 mm", "0 mm"], ["0 mm", "0 mm"]] }
joints.c = { bodies = ["rod", "rocker"], points = [["50 mm", "0 mm"], ["30 mm", "0 mm"]] }
joints.d = { bodies = ["ground", "rocker"], points = [["50 mm", "0 mm"], ["0 mm", "0 mm"]] }
"#,
    );
    let end = trace::run(Model::Analytic, &scene, &mut CollectSink::default()).expect_err("a fold").to_string();
    let expected = [
        "singular configuration: the joints a, b, c and d are in line",
        "can go on in two ways",
        "a stop (`lower` or `upper`)",
        "`--model engine`",
    ];
    assert!(expected.iter().all(|part| end.contains(part)), "{end}");
}

/// What runs of one linkage with different starts have in common.
#[derive(Default)]
struct Found {
    runs: usize,
    ended: usize,
    largest: f64,
    failures: Vec<String>,
}

/// Runs a linkage, in motion or released under gravity, with the start on each joint in turn and on none. The first joint has
/// a coordinate and a rate.
fn compare_starts(
    what: &str,
    (mut mechanism, crank, rate): (Mechanism, f64, f64),
    rtol: f64,
    is_released: bool,
    found: &mut Found,
) {
    if is_released {
        mechanism.gravity_m_s2 = [0.0, -30.0];
    }
    let start = assemble(&with_start(&mechanism, 0, crank, if is_released { 0.0 } else { rate }))
        .unwrap_or_else(|error| panic!("{what}: {error}"));
    let mut starts: Vec<Option<(usize, f64, f64)>> = Vec::new();
    for (index, joint) in mechanism.joints.iter().enumerate() {
        let (value, rate) = start.joint(joint);
        // A joint that is nearly at rest does not determine the rates of others.
        let scale = if joint.kind == JointKind::Revolute { 1.0 } else { 0.03 };
        if is_released || rate.abs() > 2.0 * scale {
            starts.push(Some((index, value, rate)));
        }
    }
    if is_released {
        starts.push(None);
    }
    let mut first: Option<Vec<Sample>> = None;
    for started in starts {
        let with = started.map_or(mechanism.clone(), |(joint, value, rate)| with_start(&mechanism, joint, value, rate));
        let integrator = Integrator::preset(Preset::Engineering).with_rtol(rtol);
        let mut scene = Scene { integrator, ..mechanism_scene(with, 0.25) };
        scene.log.numeric_hz = 400.0;
        let mut sink = CollectSink::default();
        let end = trace::run(Model::Analytic, &scene, &mut sink).err().map(|error| error.to_string());
        let name = started.map_or("no joint", |(joint, ..)| &mechanism.joints[joint].name);
        let what = format!("{what}, start on {name}");
        found.runs += 1;
        if let Some(end) = end {
            found.ended += 1;
            // A fold is the end of the motion itself.
            if !end.contains("can go on in two ways") {
                found.failures.push(format!("{what}: {end}"));
            }
        }
        match &first {
            None => first = Some(sink.samples),
            Some(first) => {
                let difference = difference(&mechanism, [first, &sink.samples]);
                found.largest = found.largest.max(difference);
                if difference > LARGEST_DIFFERENCE {
                    found.failures.push(format!("{what}: differs by {difference:e}"));
                }
            }
        }
    }
}

/// Relative tolerance of these runs, a tenth of the default one of mechanisms: a start on a slide is in metres, so that
/// angles have errors that are larger by the ratio of a radian to a length.
const RTOL: f64 = 3e-8;
/// Allowed difference of the coordinates of joints, rad or 30 mm.
const LARGEST_DIFFERENCE: f64 = 1e-6;

/// What it is; a linkage, assembled, the coordinate of its first joint, and a rate of it; and the relative tolerance.
type Linkage = (String, (Mechanism, f64, f64), f64);

fn compare_linkages(linkages: impl Iterator<Item = Linkage>) -> Found {
    let mut found = Found::default();
    for (what, linkage, rtol) in linkages {
        for is_released in [false, true] {
            compare_starts(&what, linkage.clone(), rtol, is_released, &mut found);
        }
    }
    assert!(found.failures.is_empty(), "{}", found.failures.join("\n"));
    found
}

fn linkage(seed: u64) -> Linkage {
    let (kind, mechanism, rate) = random_linkage(seed);
    let crank = mechanism.bodies[0].pose[2];
    (format!("seed {seed}, {kind}"), (mechanism, crank, rate), RTOL)
}

/// A six-bar that Newton's method places in all its coordinates.
fn assur(seed: u64) -> Linkage {
    // Near cusps of the coupler's point the motions of some of them differ by 3e-6 at ten times this tolerance.
    (format!("seed {seed}, six-bar on its long side"), random_assur(seed), 0.1 * RTOL)
}

/// Slider-cranks, four-bars and six-bars, with a start on each joint in turn and on none.
#[test]
fn the_joint_with_the_start_does_not_change_the_motion() {
    let found = compare_linkages((0..20).map(|k| linkage(23 * k)));
    assert!(found.runs > 100 && found.ended < found.runs / 10, "{} runs, {} ended", found.runs, found.ended);
}

/// 500 of them; `PHALANX_SEEDS` is the range of seeds.
#[test]
#[ignore = "takes minutes"]
fn the_joint_with_the_start_does_not_change_many_motions() {
    let Found { runs, ended, largest, .. } = compare_linkages(seeds("0..500").map(linkage));
    println!("{runs} runs, {ended} ended, largest difference {largest:e}");
    assert!(ended < runs / 100, "{ended} of {runs} runs ended");
}

/// Six-bars without a row of dyads in any coordinates.
#[test]
fn the_joint_with_the_start_does_not_change_the_motion_of_assur_groups() {
    let found = compare_linkages((0..8).map(assur));
    assert!(found.runs > 40 && found.ended < found.runs / 10, "{} runs, {} ended", found.runs, found.ended);
}

/// 200 of them; `PHALANX_SEEDS` is the range of seeds.
#[test]
#[ignore = "takes minutes"]
fn the_joint_with_the_start_does_not_change_many_motions_of_assur_groups() {
    let Found { runs, ended, largest, .. } = compare_linkages(seeds("0..200").map(assur));
    println!("{runs} runs, {ended} ended, largest difference {largest:e}");
    assert!(ended < runs / 100, "{ended} of {runs} runs ended");
}

/// Six-bars without a row of dyads, on the ground and on a moving body: both models agree, and energy is balanced.
#[test]
fn assur_groups_move_as_in_the_engine() {
    for seed in 0..6 {
        let (what, (mut mechanism, crank, rate), _) = assur(seed);
        mechanism.gravity_m_s2 = [3.0, -8.0];
        let groups = find_groups(&mechanism).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(groups.iter().any(Group::has_assur), "{what}");
        let fixed = with_start(&mechanism, 0, crank, 0.3 * rate);
        for mechanism in [on_moving_base(&fixed), fixed] {
            let mut scene = mechanism_scene(mechanism, 0.15);
            scene.log.numeric_hz = 400.0;
            let [analytic, engine] = [run_to_end(&scene), run_engine(&scene)];
            let found = difference(self::mechanism(&scene), [&analytic.1.samples, &engine.1.samples]);
            assert!(found < 1e-5, "{what}: {found:e}");
            let energy = analytic.0.last.energy();
            let size_j = energy.kinetic_j + energy.gravity_j.abs() + energy.motor_work_j.abs();
            assert!(energy.balance_j.abs() < 1e-9 * size_j, "{what}: {energy:?}");
        }
    }
}

/// A disc on the coupler of a six-bar without a row of dyads, on the ground or on a moving body, meets a fixed disc.
#[test]
fn assur_groups_touch_as_in_the_engine() {
    const RADIUS_M: f64 = 1e-3;
    for seed in 0..6 {
        let (what, (mechanism, crank, rate), _) = assur(seed);
        let mut mechanism = with_start(&mechanism, 0, crank, rate);
        if seed % 2 == 1 {
            mechanism = on_moving_base(&mechanism);
        }
        let disc =
            |center_m| Outline { name: "disc".to_string(), shape: OutlineShape::Disc { center_m, radius_m: RADIUS_M } };
        let BodyState { centre_m: [x, y], angle_rad, .. } =
            run_to_end(&mechanism_scene(mechanism.clone(), 0.02)).0.last.body(1);
        let coupler = &mut mechanism.bodies[1];
        let [along, _] = coupler.com_m;
        coupler.outlines.push(disc(coupler.com_m));
        mechanism.ground_outlines.push(disc([x + along * angle_rad.cos(), y + along * angle_rad.sin()]));
        let damping = Damping::HuntCrossley { factor_s_per_m: 1.0 };
        mechanism.contacts.push(ContactPair {
            name: None,
            points: OutlineId { body: Some(1), outline: 0 },
            face: OutlineId { body: None, outline: 0 },
            law: ContactLaw { normal: NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 1.5, damping }, friction: None },
            rolling: None,
            force_point: ForcePoint::Face,
            is_reported_on_face: false,
        });
        let mut scene = mechanism_scene(mechanism, 0.025);
        scene.engine.stepping = Stepping::Adaptive { tolerance_m: 1e-9, max_step_s: ENGINE_MAX_STEP_S };
        let [analytic, engine] = [run_to_end(&scene), run_engine(&scene)];
        let touches = [&analytic.1, &engine.1].map(|run| run.event_time_s(0, EventKind::TouchDown));
        assert!(touches[0] < 0.02 && (touches[0] - touches[1]).abs() < 1e-6, "{what}: {touches:?}");
        let found = difference(self::mechanism(&scene), [&analytic.1.samples, &engine.1.samples]);
        assert!(found < 1e-3, "{what}: {found:e}");
        let energy = analytic.0.last.energy();
        assert!(energy.balance_j.abs() < 1e-8 * (energy.kinetic_j + energy.motor_work_j.abs()), "{what}: {energy:?}");
    }
}
