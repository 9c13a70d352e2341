//! Simulations advanced by their user: pieces, copies, inputs.

use crate::support::mechanism_cases::mechanism_case;
use crate::support::runs::{Random, assert_below, experiment_95, run_engine, run_to_end, with_reference_settings};
use phalanx::drive::{Interpolation, Profile};
use phalanx::mechanism::Command;
use phalanx::scene::{self, Scene};
use phalanx::trace::{Model, Sample, Simulation, SimulationError};

/// A finger, grippers with and without bristles, discs, and mechanisms with dyads, limits and servos.
fn scenes() -> Vec<Scene> {
    let file = |name: &str| scene::load_any(format!("scenes/{name}.toml")).unwrap_or_else(|error| panic!("{error}"));
    let mut scenes = [
        "experiment-95",
        "experiment-95-bristle",
        "hard/torque-steps",
        "gripper/bought",
        "gripper/seesaw",
        "mechanisms/f85-finger",
        "mechanisms/slider-crank",
    ]
    .map(file)
    .to_vec();
    scenes.extend(["h_pd_saturated", "b_swinging_slider"].map(|name| mechanism_case(name).scene()));
    scenes
}

fn start(scene: &Scene) -> Simulation {
    Simulation::new(scene, Model::Analytic).unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

fn advance_to(simulation: &mut Simulation, time_s: f64) {
    simulation.advance_to(time_s).unwrap_or_else(|error| panic!("{error}"));
}

/// Largest difference of two samples, relative to 1 or to their numbers.
fn difference(a: &Sample, b: &Sample) -> f64 {
    let relative = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a - b).abs() / a.abs().max(1.0) };
    a.values().iter().zip(b.values()).map(relative).fold(0.0, f64::max)
}

#[test]
fn pieces_and_readings_do_not_change_a_run() {
    for mut scene in scenes() {
        scene.duration_s = scene.duration_s.min(0.1);
        let (outcome, run) = run_to_end(&scene);
        let mut simulation = start(&scene);
        for piece in 1..=300 {
            advance_to(&mut simulation, scene.duration_s * f64::from(piece) / 300.0);
            assert_eq!(simulation.sample().time_s, simulation.time_s());
        }
        assert_eq!(simulation.sample(), &outcome.last, "{}", scene.name);
        assert_eq!(simulation.events(), run.events, "{}", scene.name);
    }
}

#[test]
fn readings_inside_a_step_agree_with_the_run() {
    let mut scene = with_reference_settings(&experiment_95());
    scene.log.numeric_hz = 1e5;
    let (_, run) = run_to_end(&scene);
    let mut simulation = start(&scene);
    for expected in run.samples.iter().step_by(7).filter(|sample| sample.time_s > 0.0) {
        advance_to(&mut simulation, expected.time_s);
        // The force of the damper at the joint limit, 1e9 N·m·s/rad, multiplies the rounding of rates.
        assert_below(difference(expected, simulation.sample()), 1e-5, format!("{} s", expected.time_s));
        for column in ["q11_rad", "q21_rad", "qd11_rad_s", "qd21_rad_s", "kinetic_j", "spring_j"] {
            let channel = simulation.channels().iter().find(|channel| channel.name == column).expect("a column");
            let [a, b] = [expected, simulation.sample()].map(|sample| channel.value(sample));
            assert_below((a - b).abs(), 1e-10 * a.abs().max(1.0), format!("{column}, {} s", expected.time_s));
        }
    }
}

#[test]
fn a_copy_continues_with_the_same_bits() {
    let mut random = Random::for_seed(42);
    for mut scene in scenes() {
        scene.duration_s = scene.duration_s.min(0.05);
        let mut times: Vec<f64> = (0..50).map(|_| scene.duration_s * random.unit()).collect();
        times.sort_by(f64::total_cmp);
        let torques: Vec<f64> = times.iter().map(|_| random.within(0.5, 1.0)).collect();
        let mut simulation = start(&scene);
        let input = simulation.torque_inputs().next().map(str::to_string);
        let scale = input.as_ref().map_or(0.0, |_| 0.3);
        let continue_from = |simulation: &mut Simulation, first: usize| {
            for (time_s, torque) in times.iter().zip(&torques).skip(first) {
                advance_to(simulation, *time_s);
                input.iter().for_each(|input| simulation.set_torque(input, scale * torque).expect("an input"));
            }
            advance_to(simulation, scene.duration_s);
        };
        let mut copies = Vec::new();
        for (index, (time_s, torque)) in times.iter().zip(&torques).enumerate() {
            advance_to(&mut simulation, *time_s);
            copies.push((index, simulation.clone()));
            input.iter().for_each(|input| simulation.set_torque(input, scale * torque).expect("an input"));
        }
        advance_to(&mut simulation, scene.duration_s);
        for (index, mut copy) in copies {
            continue_from(&mut copy, index);
            assert_eq!(copy.sample(), simulation.sample(), "{}, copy {index}", scene.name);
            assert_eq!(copy.events(), simulation.events(), "{}, copy {index}", scene.name);
        }
    }
}

/// Torques that are set while a simulation proceeds act as a table of the same torques does.
#[test]
fn inputs_act_as_a_table_does() {
    let points: Vec<(f64, f64)> = (0..40).map(|k| (5e-4 * f64::from(k), 0.48 + 0.05 * f64::from(k % 5))).collect();
    let mut scene = with_reference_settings(&experiment_95());
    scene.finger_mut().motor.actuation = Profile::Table { points: points.clone(), interpolation: Interpolation::Step };
    let (expected, run) = run_to_end(&scene);
    let mut simulation = start(&experiment_95_at_reference());
    for (time_s, torque) in points {
        advance_to(&mut simulation, time_s);
        simulation.set_torque("motor", torque).expect("an input");
        assert_eq!(simulation.get("motor_torque_n_m").expect("a column"), torque);
    }
    advance_to(&mut simulation, scene.duration_s);
    assert_below(difference(&expected.last, simulation.sample()), 1e-8, "the end");
    for (expected, event) in run.events.iter().zip(simulation.take_events()) {
        assert_eq!((expected.contact, expected.kind), (event.contact, event.kind));
        assert_below((expected.time_s - event.time_s).abs(), 1e-11, "an event");
    }
    assert!(simulation.events().is_empty());
}

fn experiment_95_at_reference() -> Scene {
    with_reference_settings(&experiment_95())
}

/// A target that moves at a rate acts as a table does, also at the torque limit of its servo.
#[test]
fn moving_targets_act_as_a_table_does() {
    let mut scene = with_reference_settings(&mechanism_case("h_pd_saturated").scene());
    let duration_s = scene.duration_s;
    let mut simulation = start(&scene);
    let name = simulation.target_inputs().next().expect("a servo").to_string();
    let points = vec![(0.0, 0.2), (0.4 * duration_s, 1.0), (duration_s, 0.4)];
    for pair in points.windows(2) {
        let ((from_s, from), (to_s, to)) = (pair[0], pair[1]);
        advance_to(&mut simulation, from_s);
        simulation.set_target(&name, from, (to - from) / (to_s - from_s)).expect("an input");
    }
    advance_to(&mut simulation, duration_s);
    let actuators = &mut scene.mechanism.as_mut().expect("a mechanism").actuators;
    let Command::Servo { target, .. } = &mut actuators[0].command else { panic!("a servo") };
    *target = Profile::Table { points, interpolation: Interpolation::Linear };
    let (expected, _) = run_to_end(&scene);
    assert_below(difference(&expected.last, simulation.sample()), 1e-8, "the end");
}

/// A servo with a rate equals the same controller outside, in a run and in a simulation of any pieces.
#[test]
fn sampled_servos_equal_a_controller_in_the_loop() {
    let [kp, kd, target, rate_hz] = [2.0, 0.02, 0.5, 1e3];
    let mut scene = mechanism_case("h_pd_saturated").scene();
    // Between two samples of the servo.
    scene.duration_s = 0.0495;
    let command = |command| {
        let mut scene = scene.clone();
        scene.mechanism.as_mut().expect("a mechanism").actuators[0].command = command;
        scene
    };
    let profile = |value| Profile::Constant { value };
    let servo = command(Command::Servo { kp, kd, target: profile(target), target_rate: None, rate_hz: Some(rate_hz) });
    let (outcome, run) = run_to_end(&servo);
    let mut torques: Vec<u64> = run.samples.iter().map(|sample| sample.actuator(0).to_bits()).collect();
    torques.dedup();
    assert!((20..=50).contains(&torques.len()), "{} torques", torques.len());
    let mut pieces = start(&servo);
    (1..=73).for_each(|piece| advance_to(&mut pieces, scene.duration_s * f64::from(piece) / 73.0));
    assert_eq!(pieces.sample(), &outcome.last);
    let mut simulation = start(&command(Command::Effort(profile(0.0))));
    for sample in 0..50 {
        let [angle, rate] = ["q_rad", "qd_rad_s"].map(|column| simulation.get(column).expect("a column"));
        simulation.set_torque("motor", kp * (target - angle) - kd * rate).expect("an input");
        advance_to(&mut simulation, scene.duration_s.min(f64::from(sample + 1) / rate_hz));
    }
    let error = |column: &str| {
        let [a, b] = [&simulation, &pieces].map(|simulation| simulation.get(column).expect("a column"));
        (a - b).abs()
    };
    assert_below(error("q_rad"), 1e-12, "angle");
    // A target that is set acts from the next sample on.
    let mut moved = start(&servo);
    moved.set_target("motor", 0.1, 0.0).expect("an input");
    assert_eq!(moved.get("motor_torque_n_m").expect("a column"), 0.3);
    advance_to(&mut moved, 1.5e-3);
    assert!(moved.get("motor_torque_n_m").expect("a column") < 0.25);
}

/// A jaw on a spindle at this place, whose controller measures its distance from a point of the ground.
fn jaw(at_mm: f64, sign: f64, rate: &str) -> Scene {
    let text = format!(
        r#"
        kind = "mechanism"
        duration = "20.5 ms"
        gravity = ["0 m/s^2", "0 m/s^2"]
        [bodies.jaw]
        mass = "80 g"
        inertia = "20 kg*mm^2"
        guess = {{ at = ["{at_mm} mm", "0 mm"] }}
        points.tip.at = ["-5 mm", "1 mm"]
        [ground.points.pivot]
        at = ["0 mm", "3 mm"]
        [joints.slide]
        type = "prismatic"
        bodies = ["ground", "jaw"]
        points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
        start = "{at_mm} mm"
        [actuators.grip]
        joint = "slide"
        lead = "4 mm"
        rotor = "1 g*cm^2"
        efficiency = 0.7
        loss_rate = "2 mm/s"
        target = "30 mm"
        kp = "4 V/mm"
        kd = "20 V*s/m"
        {rate}
        motor = {{ torque_constant = "9 mN*m/A", resistance = "3 ohm", voltage = "12 V", inductance = "0.3 mH" }}
        feedback = {{ distance = ["ground.pivot", "jaw.tip"], sign = {sign} }}
        "#
    );
    scene::parse_any(&text, "jaw.toml").unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn sampled_servos_of_a_distance_equal_a_controller_in_the_loop() {
    let [kp, kd, target, rate_hz] = [4e3, 20.0, 0.03, 1e3];
    for (at_mm, sign) in [(40.0, 1.0), (-40.0, -1.0)] {
        for model in [Model::Analytic, Model::Engine] {
            let start = |scene: &Scene| Simulation::new(scene, model).unwrap_or_else(|error| panic!("{error}"));
            let servo = jaw(at_mm, sign, "rate = \"1 kHz\"");
            let duration_s = servo.duration_s;
            let mut sampled = start(&servo);
            (1..=7).for_each(|piece| advance_to(&mut sampled, duration_s * f64::from(piece) / 7.0));
            let mut held = servo.clone();
            let actuators = &mut held.mechanism.as_mut().expect("a mechanism").actuators;
            actuators[0].command = Command::Effort(Profile::Constant { value: 0.0 });
            let mut simulation = start(&held);
            for sample in 0..21 {
                let [distance, rate] = ["grip_distance_m", "grip_distance_rate_m_s"]
                    .map(|column| simulation.get(column).expect("a column"));
                let voltage = sign * (kp * (target - distance) - kd * rate);
                simulation.set_torque("grip", voltage).expect("an input");
                advance_to(&mut simulation, duration_s.min(f64::from(sample + 1) / rate_hz));
            }
            let what = format!("{model:?} {at_mm}");
            let distance = |simulation: &Simulation| simulation.get("grip_distance_m").expect("a column");
            // It has closed by several millimetres.
            assert!(distance(&sampled) < 0.035, "{what}: {}", distance(&sampled));
            assert_below((distance(&simulation) - distance(&sampled)).abs(), 1e-9, &what);
            // At a high rate it is the continuous controller.
            let ends = ["", "rate = \"50 kHz\""].map(|rate| {
                let mut simulation = start(&jaw(at_mm, sign, rate));
                advance_to(&mut simulation, duration_s);
                distance(&simulation)
            });
            assert_below((ends[0] - ends[1]).abs(), 2e-5, &what);
        }
    }
}

#[test]
fn the_end_of_the_scene_is_not_the_end_of_a_simulation() {
    let mut scene = experiment_95_at_reference();
    let mut simulation = start(&scene);
    advance_to(&mut simulation, 2.5 * scene.duration_s);
    scene.duration_s *= 2.5;
    assert_below(difference(&run_to_end(&scene).0.last, simulation.sample()), 1e-7, "the end");
}

#[test]
fn wrong_names_and_times_are_refused_and_change_nothing() {
    let mut simulation = start(&experiment_95());
    advance_to(&mut simulation, 1e-3);
    let before = simulation.sample().clone();
    let refused = |result: Result<(), SimulationError>, part: &str| match result {
        Err(SimulationError::Input(message)) => assert!(message.contains(part), "{message}"),
        other => panic!("{other:?}"),
    };
    refused(simulation.set_torque("moter", 0.1), "actuators with a torque: `motor`");
    refused(simulation.set_target("motor", 0.1, 0.0), "use `set_torque`");
    refused(simulation.set_torque("motor", f64::NAN), "finite");
    refused(simulation.advance(-1e-3), "not earlier");
    refused(simulation.get("q31_rad").map(|_| ()), "q21_rad");
    assert_eq!(simulation.sample(), &before);
    advance_to(&mut simulation, 2e-3);
    assert!(simulation.contacts().any(|(name, contact)| name == "distal" && contact.gap_m > 0.0));
}

/// A simulation that reaches a singularity stays at its time.
#[test]
fn a_failure_names_its_time() {
    let scene = scene::load("scenes/hard/through-the-fold.toml").expect("a scene");
    let mut simulation = start(&scene);
    let Err(SimulationError::Failed(failure)) = simulation.advance_to(scene.duration_s) else {
        panic!("the finger folds")
    };
    assert_eq!(simulation.time_s(), failure.time_s);
    assert!(failure.time_s > 0.0 && simulation.get("q11_rad").is_ok());
    assert_eq!(simulation.advance(1e-3), Err(SimulationError::Failed(failure)));
    let stopped = start(&experiment_95()).advance_while(1e-2, &|| false);
    assert!(matches!(stopped, Err(SimulationError::Failed(_))), "{stopped:?}");
}

/// The engine model ends a step at each time to which it advances; in one piece it equals a run.
#[test]
fn the_engine_model_is_advanced_too() {
    let mut f85 = scene::load_any("scenes/mechanisms/f85-finger.toml").expect("a scene");
    f85.duration_s = 0.03;
    let mut finger = experiment_95();
    finger.duration_s = 0.01;
    for (scene, angle) in [(finger, "q11_rad"), (f85, "driver_rad")] {
        let (outcome, run) = run_engine(&scene);
        let mut whole = Simulation::new(&scene, Model::Engine).expect("a simulation");
        advance_to(&mut whole, scene.duration_s);
        assert_eq!(whole.sample(), &outcome.last, "{}", scene.name);
        assert_eq!(whole.events(), run.events, "{}", scene.name);
        // Torques that are set, in the engine model from a copy on, and in the analytic model.
        let [mut engine, mut analytic] = [Model::Engine, Model::Analytic]
            .map(|model| Simulation::new(&scene, model).unwrap_or_else(|error| panic!("{error}")));
        let mut copy = None;
        for step in 0..20 {
            let torque = [0.25, 0.3][step % 2];
            for simulation in [Some(&mut engine), Some(&mut analytic), copy.as_mut()].into_iter().flatten() {
                simulation.set_torque("motor", torque).expect("an input");
                assert_eq!(simulation.get("motor_torque_n_m").expect("a column"), torque);
                simulation.advance(scene.duration_s / 20.0).expect("a step");
            }
            if step == 7 {
                copy = Some(engine.clone());
            }
        }
        assert_eq!(copy.expect("a copy").sample(), engine.sample(), "{}", scene.name);
        let [a, b] = [&engine, &analytic].map(|simulation| simulation.get(angle).expect("a column"));
        assert_below((a - b).abs(), 1e-5, format!("{}: {a} and {b} rad", scene.name));
    }
}

/// A servo with a rate limit follows a target that is set as it follows one of its scene.
#[test]
fn a_set_target_keeps_the_rate_of_the_servo() {
    let scene = |target: &str| {
        let text = format!(
            "kind = \"mechanism\"\nduration = \"100 ms\"\n[bodies.arm]\nmass = \"50 g\"\ninertia = \"5e-5 kg*m^2\"\n\
             [joints.pin]\nbodies = [\"ground\", \"arm\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 rad\"\n\
             [actuators.servo]\njoint = \"pin\"\n{target}\nkp = \"5 N*m/rad\"\nkd = \"0.05 N*m*s/rad\"\ntarget_rate = \"10 rad/s\"\n"
        );
        scene::parse_any(&text, "servo.toml").unwrap_or_else(|error| panic!("{error}"))
    };
    let table = scene("times = [\"0 ms\", \"20 ms\", \"20.000001 ms\"]\ntargets = [\"0 rad\", \"0 rad\", \"0.6 rad\"]");
    for model in [Model::Analytic, Model::Engine] {
        let [mut expected, mut simulation] = [&table, &scene("target = \"0 rad\"")]
            .map(|scene| Simulation::new(scene, model).unwrap_or_else(|error| panic!("{error}")));
        advance_to(&mut simulation, 20e-3);
        for time_s in [30e-3, 60e-3, 100e-3] {
            // The set point moves for 60 ms; setting the target again has no effect.
            simulation.set_target("servo", 0.6, 0.0).expect("a target");
            advance_to(&mut simulation, time_s);
            advance_to(&mut expected, time_s);
            let [angle, reference] =
                [&simulation, &expected].map(|simulation| simulation.get("pin_rad").expect("an angle"));
            assert_below((angle - reference).abs(), 1e-5, format!("{} model, {time_s} s: {angle}", model.name()));
        }
        assert!((simulation.get("pin_rad").expect("an angle") - 0.6).abs() < 0.02);
    }
}

/// A motor without a torque in its scene has an input in both models.
#[test]
fn a_motor_at_rest_can_be_driven() {
    let mut scene = experiment_95();
    scene.finger_mut().motor = scene::Motor::NONE;
    for model in [Model::Analytic, Model::Engine] {
        let mut simulation = Simulation::new(&scene, model).unwrap_or_else(|error| panic!("{error}"));
        assert!(simulation.torque_inputs().eq(["motor"]));
        simulation.set_torque("motor", 0.48).expect("an input");
        let mut driven = Simulation::new(&experiment_95(), model).unwrap_or_else(|error| panic!("{error}"));
        for simulation in [&mut simulation, &mut driven] {
            simulation.advance_to(4e-3).unwrap_or_else(|error| panic!("{error}"));
        }
        let [angle, expected] = [&simulation, &driven].map(|simulation| simulation.get("q11_rad").expect("an angle"));
        assert_below((angle - expected).abs(), 1e-6, format!("{} model: {angle}", model.name()));
    }
}

#[test]
fn repeated_actions_give_the_same_bits() {
    let scenes = ["experiment-95", "gripper/cycle", "mechanisms/two-pivot"];
    for (name, model) in scenes.map(|name| (name, Model::Analytic)).into_iter().chain([(scenes[0], Model::Engine)]) {
        let scene = scene::load_any(format!("scenes/{name}.toml")).unwrap_or_else(|error| panic!("{error}"));
        let new = || Simulation::new(&scene, model).unwrap_or_else(|error| panic!("{error}"));
        let mut simulation = new();
        let input = simulation.torque_inputs().next().map(str::to_string);
        for piece in 1..=40 {
            advance_to(&mut simulation, 3e-4 * f64::from(piece));
            if let Some(input) = &input {
                let set = simulation.set_torque(input, 0.1 + 0.01 * f64::from(piece / 4));
                set.unwrap_or_else(|error| panic!("{error}"));
            }
        }
        let actions = simulation.actions().unwrap_or_default();
        assert!(actions.len() > usize::from(input.is_some()) * 20);
        let mut repeated = new();
        repeated.repeat(actions, &|| true).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((repeated.sample(), repeated.events()), (simulation.sample(), simulation.events()), "{name}");
        for simulation in [&mut simulation, &mut repeated] {
            advance_to(simulation, 0.015);
        }
        assert_eq!(repeated.sample(), simulation.sample(), "{name}");
    }
}

#[test]
fn an_unknown_column_has_a_suggestion() {
    let error = start(&experiment_95()).observe(&["q11_rad".into(), "q11_rd".into()]).unwrap_err();
    assert!(error.to_string().contains("`q11_rd` is no column; did you mean `q11_rad`?"), "{error}");
}
