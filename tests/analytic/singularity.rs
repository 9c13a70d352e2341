//! Runs that cannot be completed end with a reason, at the right time, and keep all samples up to there.

use crate::support::runs::{CollectSink, engineering_settings, experiment_95, reference_settings, run};
use phalanx::gripper::Assembly;
use phalanx::integrator::{Failure, Reason};
use phalanx::scene::{Actuation, Initial, Integrator, Method, Scene};
use phalanx::shape::Shape;
use phalanx::trace::{FingerContact, RunError, Sample, run_analytic};

fn all_settings() -> [Integrator; 4] {
    [
        engineering_settings(),
        Integrator { method: Method::RadauIIa5, ..engineering_settings() },
        reference_settings(),
        Integrator { method: Method::Rodas5p, ..reference_settings() },
    ]
}

fn logged_numbers(s: &Sample) -> [f64; 14] {
    [
        s.time_s,
        s.finger(0).q11_rad,
        s.finger(0).q21_rad,
        s.finger(0).q12_rad,
        s.finger(0).q22_rad,
        s.finger(0).q13_rad,
        s.finger(0).qd11_rad_s,
        s.finger(0).qd21_rad_s,
        s.finger(0).qd12_rad_s,
        s.finger(0).qd22_rad_s,
        s.finger_contact(FingerContact::Limit).normal_n,
        s.energy().kinetic_j,
        s.energy().balance_j,
        s.finger_contact(FingerContact::Proximal).normal_n
            + s.finger_contact(FingerContact::Distal).normal_n
            + s.finger_contact(FingerContact::Proximal).tangential_n
            + s.finger_contact(FingerContact::Distal).tangential_n,
    ]
}

#[track_caller]
fn assert_finite_and_ordered(log: &CollectSink, name: &str) {
    for sample in &log.samples {
        assert!(logged_numbers(sample).iter().all(|x| x.is_finite()), "{name}: {sample:?}");
    }
    assert!(log.samples.windows(2).all(|pair| pair[0].time_s <= pair[1].time_s), "{name}: samples out of order");
}

/// Runs a scene, which must fail; returns the failure and the log.
#[track_caller]
fn failure(scene: &Scene) -> (Failure, CollectSink) {
    let (result, log) = run(scene);
    assert_finite_and_ordered(&log, &scene.name);
    match result {
        Err(RunError::Simulation { failure, partial_outcome }) => {
            let last = log.samples.last().unwrap_or_else(|| panic!("{}: no samples", scene.name));
            assert!(partial_outcome.last.time_s <= failure.time_s && last.time_s <= failure.time_s);
            assert!(logged_numbers(&partial_outcome.last).iter().all(|x| x.is_finite()));
            (failure, log)
        }
        other => panic!("{}: did not fail: {:?}", scene.name, other.map(|o| o.last.time_s)),
    }
}

/// A finger without object, spring and limit, whose ground links are driven apart or together.
fn loop_without_object(assembly: Assembly, q: [f64; 2], v: [f64; 2], torque_n_m: f64) -> Scene {
    let mut scene = experiment_95();
    scene.name = format!("{assembly:?} from {q:?} with {torque_n_m}");
    scene.system.discs.clear();
    (scene.finger_mut().limit, scene.finger_mut().spring) = (None, None);
    scene.finger_mut().linkage.assembly = assembly;
    scene.finger_mut().initial = Initial { q11_rad: q[0], q21_rad: q[1], qd11_rad_s: v[0], qd21_rad_s: v[1] };
    scene.finger_mut().motor.actuation = Actuation::Constant { torque_n_m };
    scene
}

/// Asserts that the run ends in the given singular configuration with all settings, at times that agree to a relative
/// 1e-4.
fn assert_ends_in(scene: &Scene, configuration: &str) {
    let mut times = Vec::new();
    for integrator in all_settings() {
        let scene = Scene { integrator, ..scene.clone() };
        let (failure, _) = failure(&scene);
        let Reason::Obstacle(text) = &failure.reason else { panic!("{}: {failure}", scene.name) };
        assert!(text.contains("singular configuration") && text.contains(configuration), "{}: {text}", scene.name);
        times.push(failure.time_s);
    }
    let reference_s = times[2];
    println!("{}: {configuration} at {times:?}", scene.name);
    assert!(times.iter().all(|t| (t / reference_s - 1.0).abs() < 1e-4), "{}: {times:?}", scene.name);
}

#[test]
fn a_stretched_loop_is_reported_with_its_time() {
    assert_ends_in(&loop_without_object(Assembly::Reference, [-0.7, 0.9], [-100.0, 100.0], -0.48), "stretched");
    assert_ends_in(&loop_without_object(Assembly::Other, [-0.26, 1.05], [0.0; 2], -0.48), "stretched");
}

#[test]
fn a_folded_loop_is_reported_with_its_time() {
    assert_ends_in(&loop_without_object(Assembly::Reference, [0.1, 1.0], [0.0; 2], 0.48), "folded");
    assert_ends_in(&loop_without_object(Assembly::Other, [0.1, 1.0], [0.0; 2], 0.48), "folded");
}

#[test]
fn a_start_at_which_the_loop_cannot_close_is_rejected() {
    for integrator in all_settings() {
        let mut scene = loop_without_object(Assembly::Reference, [0.0, 3.1], [0.0; 2], 0.48);
        scene.integrator = integrator;
        // A12 and A22 are 39 mm apart; the links between them span 30 mm.
        let (result, log) = run(&scene);
        match result {
            Err(RunError::Simulation { failure, .. }) => {
                assert_eq!(failure.time_s, 0.0);
                assert!(matches!(&failure.reason, Reason::Obstacle(text) if text.contains("stretched")), "{failure}");
            }
            other => panic!("{other:?}"),
        }
        assert_eq!(log.samples, []);
    }
}

#[test]
fn a_run_that_exceeds_max_steps_keeps_its_samples() {
    for integrator in all_settings() {
        for budget in [1, 7, 50] {
            let mut scene = experiment_95();
            scene.integrator = Integrator { max_steps: budget, ..integrator };
            let (failure, log) = failure(&scene);
            assert_eq!(failure.reason, Reason::Budget(budget));
            assert!(failure.to_string().contains("max_steps"), "{failure}");
            assert!(failure.time_s > 0.0 && failure.time_s < scene.duration_s);
            assert_eq!(log.samples.last().map(|s| s.time_s), log.samples.iter().map(|s| s.time_s).reduce(f64::max));
        }
    }
}

/// Swings with random torque from random states. Most of them end in a singular configuration. All settings end in the
/// same way at the same time, and all logged numbers are finite.
#[test]
fn random_swings_end_consistently_with_all_settings() {
    let mut random = crate::support::runs::Random(21);
    let (mut run_counts, mut max_error) = ([0; 2], 0.0f64);
    for i in 0..150 {
        let assembly = if i % 2 == 0 { Assembly::Reference } else { Assembly::Other };
        let q21 = random.within(0.2, 2.5);
        let q = [q21 - random.within(0.7, 1.6), q21];
        let v = [random.within(-300.0, 300.0), random.within(-300.0, 300.0)];
        let mut scene = loop_without_object(assembly, q, v, random.within(-2.0, 2.0));
        scene.log.numeric_hz = 1e5;
        let mut times = Vec::new();
        for integrator in all_settings() {
            scene.integrator = integrator;
            let (result, log) = run(&scene);
            assert_finite_and_ordered(&log, &scene.name);
            match result {
                Ok(_) => times.push(None),
                Err(RunError::Simulation { failure: Failure { time_s, reason: Reason::Obstacle(_) }, .. }) => {
                    times.push(Some(time_s));
                }
                Err(other) => panic!("{} {integrator:?}: {other}", scene.name),
            }
        }
        let reference_s = times[2];
        run_counts[usize::from(reference_s.is_some())] += 1;
        for time in &times {
            let error = time.unwrap_or(scene.duration_s) / reference_s.unwrap_or(scene.duration_s) - 1.0;
            assert!(time.is_some() == reference_s.is_some() && error.abs() < 1e-3, "{}: {times:?}", scene.name);
            max_error = max_error.max(error.abs());
        }
    }
    println!("completed {}, singular {}, times within {max_error:.1e}", run_counts[0], run_counts[1]);
    assert!(run_counts[1] > 100, "{run_counts:?}");
}

/// Runs with extreme parameters complete or fail with a reason; they neither panic nor log non-finite numbers.
#[test]
fn extreme_scenes_do_not_panic() {
    let mut scenes = Vec::new();
    let mut add_variant = |name: &str, change: &dyn Fn(&mut Scene)| {
        let mut scene = experiment_95();
        scene.name = name.to_string();
        change(&mut scene);
        scene.integrator.max_steps = 20_000;
        scenes.push(scene);
    };
    for torque_n_m in [0.0, -0.48, 1e-9, 48.0, -48.0, 1e6, 1e30, f64::MAX] {
        add_variant(&format!("torque {torque_n_m:e}"), &|s| {
            s.finger_mut().motor.actuation = Actuation::Constant { torque_n_m }
        });
    }
    add_variant("fast start", &|s| s.finger_mut().initial.qd11_rad_s = 1e6);
    add_variant("fast start the other way", &|s| s.finger_mut().initial.qd21_rad_s = -1e6);
    add_variant("no gravity", &|s| s.system.gravity_m_s2 = [0.0; 2]);
    add_variant("much gravity", &|s| s.system.gravity_m_s2 = [1e8, -1e8]);
    add_variant("soft object", &|s| {
        for law in s.finger_mut().contact.both_mut().map(|law| &mut law.normal) {
            (law.stiffness_n_per_m_e, law.damping_max_n_s_per_m) = (1.0, 1e-3);
        }
    });
    add_variant("elastic object", &|s| {
        for law in s.finger_mut().contact.both_mut().map(|law| &mut law.normal) {
            law.damping_max_n_s_per_m = 0.0;
        }
    });
    add_variant("diamond object", &|s| {
        for law in s.finger_mut().contact.both_mut().map(|law| &mut law.normal) {
            (law.stiffness_n_per_m_e, law.damping_max_n_s_per_m) = (1e14, 1e12);
        }
    });
    add_variant("start out of reach", &|s| s.finger_mut().initial.q21_rad = 1.3);
    add_variant("start inside the object", &|s| {
        (s.finger_mut().initial.q11_rad, s.finger_mut().initial.q21_rad) = (-0.4, 1.17)
    });
    add_variant("tiny object", &|s| s.system.grasped_mut().shape = Shape::Disc { radius_m: 1e-6 });
    add_variant("huge friction", &|s| {
        for law in s.finger_mut().contact.both_mut() {
            let friction = law.friction.as_mut().expect("friction");
            (friction.mu_static, friction.mu_dynamic) = (100.0, 70.0);
        }
    });
    for scene in scenes {
        for integrator in all_settings() {
            let scene = Scene {
                integrator: Integrator { max_steps: scene.integrator.max_steps, ..integrator },
                ..scene.clone()
            };
            // Invariants are not checked, because energies have no significant digits at 1e30 N·m.
            let mut log = CollectSink::default();
            let result = run_analytic(&scene, &mut log);
            let outcome = match &result {
                Ok(outcome) => format!("done in {} steps", outcome.work.steps),
                Err(error) => error.to_string(),
            };
            println!("{}, {:?} {:e}: {outcome}", scene.name, integrator.method, integrator.rtol);
            assert_finite_and_ordered(&log, &scene.name);
        }
    }
}
