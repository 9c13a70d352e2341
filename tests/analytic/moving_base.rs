//! Scenes of mechanisms whose base moves: closed forms, and the same gripper as fingers and as a mechanism.

use phalanx::numeric::elementary::{exp, sin};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{self, Hand, Layer, Scene};
use phalanx::trace::schema::SubjectKind;
use phalanx::trace::{self, Model, Sample, Schema};
use std::f64::consts::FRAC_PI_6;

use crate::support::runs::CollectSink;

fn parse(text: &str) -> Scene {
    scene::parse_any(text, "moving.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn samples_of(model: Model, scene: &Scene) -> Vec<Sample> {
    let mut run = CollectSink::default();
    trace::run(model, scene, &mut run).unwrap_or_else(|error| panic!("{error}"));
    let energy = run.samples.last().expect("a sample").energy();
    let stored_j = energy.kinetic_j + energy.gravity_j.abs() + energy.elastic_j;
    let allowed = if model == Model::Analytic { 1e-6 } else { 1e-4 };
    let exchanged_j = stored_j + energy.motor_work_j.abs() + energy.dissipated_j.abs();
    assert!(energy.balance_j.abs() < allowed * exchanged_j, "{model:?}: {energy:?}");
    run.samples
}

/// A mass on a spring and damper on a base that moves and vibrates: the convolution of the acceleration of the base with the
/// impulse response.
#[test]
fn a_mass_on_a_spring_on_a_vibrating_base_follows_its_convolution() {
    let scene = parse(
        r#"
        kind = "mechanism"
        duration = "200 ms"
        bodies.mass = { mass = "100 g", inertia = "100 g*mm^2" }
        joints.slide = { type = "prismatic", bodies = ["ground", "mass"], points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]], axis = "30 deg", start = "0 mm" }
        springs.coil = { joint = "slide", stiffness = "900 N/m", damping = "2 N*s/m", rest = "0 mm" }
        vibrations.shake = { x = "1 mm", y = "-0.5 mm", frequency = "20 Hz", start = "10 ms" }
        moves.away = { x = "40 mm", start = "30 ms", time = "90 ms" }
        integrator.preset = "reference"
        "#,
    );
    let motion = scene.mechanism.as_ref().and_then(|of| of.palm()).expect("a motion").1.clone();
    let (omega, decay) = (9000f64.sqrt(), 10.0);
    let damped = (omega * omega - decay * decay).sqrt();
    let acceleration = |t: f64| {
        let [x, y, _] = motion.pose(t).acceleration;
        x * FRAC_PI_6.cos() + y * FRAC_PI_6.sin()
    };
    // Simpson's rule between corners of the motion.
    let response = |end: f64| {
        let mut corners = vec![0.0];
        while let Some(next) = Some(motion.next_discontinuity(corners[corners.len() - 1])).filter(|next| *next < end) {
            corners.push(next);
        }
        corners.push(end);
        let integrand = |t: f64| -acceleration(t) * exp(-decay * (end - t)) * sin(damped * (end - t)) / damped;
        let part = |ends: &[f64]| {
            let (count, from) = (4000, ends[0]);
            let h = (ends[1] - from) / f64::from(count);
            // The acceleration at a corner is that within the part.
            let at = |k: i32| integrand((from + h * f64::from(k)).clamp(from + 1e-15, ends[1] - 1e-15));
            let weight = |k: i32| if k == 0 || k == count { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
            (0..=count).map(|k| weight(k) * at(k)).sum::<f64>() * h / 3.0
        };
        corners.windows(2).map(part).sum::<f64>()
    };
    for (model, allowed_m) in [(Model::Analytic, 1e-11), (Model::Engine, 2e-7)] {
        let samples = samples_of(model, &scene);
        let mut largest_m = 0f64;
        for sample in samples.iter().step_by(samples.len() / 20).skip(1) {
            let (found_m, expected_m) = (sample.joint_state(0).angle_rad, response(sample.time_s));
            assert!((found_m - expected_m).abs() < allowed_m, "{model:?} {}: {found_m} {expected_m}", sample.time_s);
            largest_m = largest_m.max(found_m.abs());
        }
        assert!(largest_m > 1e-3, "{largest_m}");
    }
}

/// A ball on a tray that moves: without friction it stays in the world; a disc that rolls moves by −2/3 of the displacement of
/// the tray relative to it; and it presses with m (g + a).
#[test]
fn a_ball_on_an_accelerated_tray_slides_rolls_and_presses_as_in_closed_form() {
    let scene = |friction: &str, motion: &str| {
        parse(&format!(
            r#"
            kind = "mechanism"
            duration = "120 ms"
            gravity = ["0 m/s^2", "-9.81 m/s^2"]
            bodies.ball = {{ density = "7800 kg/m^3", depth = "10 mm", start = {{ at = ["0 mm", "10 mm"] }}, outlines.skin = {{ type = "disc", radius = "10 mm" }} }}
            ground.outlines.tray = {{ type = "half_plane", point = ["0 mm", "0 mm"], normal = [0, 1] }}
            laws.tray = {{ type = "spring_damper", stiffness = 1e6, exponent = 1.0, damping = "200 N*s/m"{friction} }}
            contacts = [{{ between = ["ball", "ground.tray"], law = "tray" }}]
            moves.go = {{ {motion}, start = "20 ms", time = "100 ms" }}
            "#
        ))
    };
    let rolls = r#", friction = { mu_static = 0.9, law = "bristle", bristle_damping = "1000 N*s/m" }"#;
    for model in [Model::Analytic, Model::Engine] {
        for (friction, part) in [("", 1.0), (rolls, 2.0 / 3.0)] {
            let samples = samples_of(model, &scene(friction, r#"x = "20 mm""#));
            let ball = samples.last().expect("a sample").body(0);
            let expected_m = -0.02 * part;
            assert!((ball.centre_m[0] - expected_m).abs() < 2e-5, "{model:?}: {ball:?}");
            let turn_rad = if part < 1.0 { -expected_m / 0.01 } else { 0.0 };
            assert!((ball.angle_rad - turn_rad).abs() < 2e-3, "{model:?}: {ball:?}");
        }
        let lifted = scene("", r#"y = "20 mm""#);
        let (mechanism, samples) = (lifted.mechanism.as_ref().expect("a mechanism"), samples_of(model, &lifted));
        let (mass_kg, (_, motion)) = (mechanism.bodies[0].mass_kg, mechanism.palm().expect("a motion"));
        let peak = samples.iter().map(|sample| {
            let [_, acceleration, _] = motion.pose(sample.time_s).acceleration;
            (sample.contact(0).normal_n, mass_kg * (9.81 + acceleration))
        });
        let (found_n, expected_n) = peak.max_by(|a, b| a.1.total_cmp(&b.1)).expect("a sample");
        assert!((found_n / expected_n - 1.0).abs() < 2e-3, "{model:?}: {found_n} {expected_n}");
        assert!(expected_n > 1.5 * 9.81 * mass_kg);
    }
}

/// A pendulum with a contact on a palm in a tilted pose swings as one on the ground that moves alike.
#[test]
fn the_pose_of_the_palm_at_the_start_has_no_effect_on_the_motion() {
    // A pivot at (50, 20) mm of the world, on a palm at (40, −10) mm that is turned by 0.6 rad.
    let (sin, cos) = 0.6f64.sin_cos();
    let [x, y] = [50.0 - 40.0, 20.0 + 10.0];
    let local = format!("[\"{} mm\", \"{} mm\"]", cos * x + sin * y, cos * y - sin * x);
    let scene = |base: &str, pivot: &str, start_rad: f64, body: &str| {
        parse(&format!(
            r#"
            kind = "mechanism"
            duration = "150 ms"
            gravity = ["1 m/s^2", "-9.81 m/s^2"]
            bodies.palm = {{ mass = "1 kg", inertia = "1 kg*m^2", guess = {{ at = ["40 mm", "-10 mm"], angle = "0.6 rad" }} }}
            bodies.link = {{ mass = "50 g", inertia = "20000 g*mm^2", com = ["30 mm", "0 mm"], guess = {{ at = ["50 mm", "20 mm"] }}, outlines.tip = {{ type = "disc", center = ["60 mm", "0 mm"], radius = "5 mm" }} }}
            bodies.ball = {{ mass = "20 g", inertia = "2000 g*mm^2", start = {{ at = ["88 mm", "54 mm"], velocity = ["0 m/s", "0.2 m/s"], spin = "3 rad/s" }}, outlines.skin = {{ type = "disc", radius = "6 mm" }} }}
            joints.pin = {{ bodies = ["{base}", "link"], points = [{pivot}, ["0 mm", "0 mm"]], start = "{start_rad} rad" }}
            joints.far = {{ bodies = ["palm", "rest"], points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]], start = "0 rad" }}
            bodies.rest = {{ mass = "50 g", inertia = "20000 g*mm^2", guess = {{ at = ["40 mm", "-10 mm"] }} }}
            laws.soft = {{ stiffness = 1e6, damping = "1 s/m" }}
            contacts = [{{ between = ["link.tip", "ball"], law = "soft" }}]
            moves.go = {{ body = "{body}", x = "-30 mm", y = "20 mm", start = "10 ms", time = "80 ms" }}
            vibrations.shake = {{ y = "0.3 mm", frequency = "60 Hz" }}
            integrator.preset = "reference"
            "#
        ))
    };
    for model in [Model::Analytic, Model::Engine] {
        let of_palm = samples_of(model, &scene("palm", &local, 0.3, "palm"));
        let of_ground = samples_of(model, &scene("ground", r#"["50 mm", "20 mm"]"#, 0.9, "ground"));
        let (a, b) = (of_palm.last().expect("a sample"), of_ground.last().expect("a sample"));
        assert!(of_palm.iter().any(|sample| sample.contact(0).normal_n > 0.1), "no contact");
        let allowed = if model == Model::Analytic { 1e-8 } else { 1e-5 };
        let pin = |sample: &Sample| sample.joint_state(1).angle_rad;
        assert!((pin(a) - pin(b) + 0.6).abs() < allowed, "{model:?}: {} {}", pin(a), pin(b));
        // The ball in the axes of the palm, from the origin of the palm.
        let (in_palm, in_frame) = (a.body(0), b.body(0));
        let [u, v] = [in_frame.centre_m[0] - 0.04, in_frame.centre_m[1] + 0.01];
        for (found, expected) in in_palm.centre_m.into_iter().zip([cos * u + sin * v, cos * v - sin * u]) {
            assert!((found - expected).abs() < 0.1 * allowed, "{model:?}: {in_palm:?} {in_frame:?}");
        }
        assert!((in_palm.angle_rad - in_frame.angle_rad + 0.6).abs() < allowed, "{model:?}");
    }
}

/// A gripper that moves, as fingers, as a mechanism with a palm, and as one whose ground moves except the table.
#[test]
fn a_gripper_and_its_mechanism_move_alike() {
    let motion = "moves.across.x=60 mm|moves.across.start=25 ms|moves.across.time=50 ms|moves.turn.angle=20 deg|\
                  moves.turn.start=22 ms|moves.turn.time=55 ms|vibrations.shake.y=0.02 mm|vibrations.shake.frequency=150 Hz";
    let settings: Vec<Layer> =
        motion.split('|').map(|text| scene::parse_setting("--set", text).expect("a setting")).collect();
    let of_fingers =
        scene::load_any_with("scenes/gripper/lift.toml", &settings).unwrap_or_else(|error| panic!("{error}"));
    let as_mechanism = |hand: &Hand| {
        let mut mechanism = hand.mechanism().expect("closed loops");
        for body in mechanism.bodies.iter_mut().filter(|body| body.motion.is_some()) {
            (body.mass_kg, body.inertia_kg_m2) = (1.0, 1.0);
        }
        let written =
            Scene { kind: SceneKind::Mechanism, mechanism: Some(mechanism), hand: Hand::EMPTY, ..of_fingers.clone() };
        scene::show(&written)
    };
    let on_palm = as_mechanism(&of_fingers.hand);
    assert!(on_palm.contains("body = \"palm\""), "{on_palm}");
    let at_rest = as_mechanism(&Hand { palm_motion: None, ..of_fingers.hand.clone() });
    let mut sections = String::from("[grasp]\nsurroundings = [\"ground.table\"]\n");
    let shown = on_palm.replace("body = \"palm\"\n", "");
    let moves = shown.split("\n\n").filter(|text| text.starts_with("[moves.") || text.starts_with("[vibrations."));
    moves.for_each(|text| sections += &format!("\n{text}\n"));
    let scenes = [of_fingers.clone(), parse(&on_palm), parse(&(at_rest + "\n" + &sections))];
    let base = scenes[2].grasp_roles().expect("a grasp").base;
    assert_eq!(base, scenes[2].mechanism.as_ref().expect("a mechanism").frame());
    for scene in &scenes[1..] {
        let shown = parse(&scene::show(scene));
        assert_eq!(Scene { source: scene.source.clone(), ..shown }, *scene);
    }
    for model in [Model::Analytic, Model::Engine] {
        let found = scenes.each_ref().map(|scene| {
            let (samples, schema) = (samples_of(model, scene), Schema::from_scene(scene));
            let of = |kind: SubjectKind, name: &str, key: &str| schema.channel(kind, name, key);
            let channels = [
                of(SubjectKind::Joint, "right_q11", "angle_rad"),
                of(SubjectKind::Joint, "left_q22", "angle_rad"),
                of(SubjectKind::Body, "object", "x_m"),
                of(SubjectKind::Body, "object", "y_m"),
                of(SubjectKind::Body, "object", "angle_rad"),
            ];
            let at = |time_s: f64| {
                let sample = samples.iter().find(|sample| (sample.time_s - time_s).abs() < 1e-9).expect("a sample");
                channels.each_ref().map(|channel| channel.value(sample))
            };
            [0.01, 0.03, 0.05, 0.08].map(at)
        });
        let allowed = if model == Model::Analytic { 1e-6 } else { 1e-5 };
        let [expected, others @ ..] = &found;
        for other in others {
            let pairs = other.iter().flatten().zip(expected.iter().flatten());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < allowed), "{model:?}: {found:?}");
        }
    }
}
