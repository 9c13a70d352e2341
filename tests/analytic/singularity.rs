//! Runs that cannot be completed end by name, in time, and with everything up to there.

use crate::support::runs::{Collect, anchor, engineering, reference, run};
use phalanx::gripper::Assembly;
use phalanx::integrator::{Failure, Reason};
use phalanx::scene::{Actuation, Initial, Integrator, Method, Scene};
use phalanx::shape::Shape;
use phalanx::trace::{RunError, Sample, Site, run_analytic};

fn settings() -> [Integrator; 4] {
    [
        engineering(),
        Integrator { method: Method::RadauIIa5, ..engineering() },
        reference(),
        Integrator { method: Method::Rodas5p, ..reference() },
    ]
}

fn numbers(s: &Sample) -> [f64; 14] {
    [
        s.time_s,
        s.finger().q11_rad,
        s.finger().q21_rad,
        s.finger().q12_rad,
        s.finger().q22_rad,
        s.finger().q13_rad,
        s.finger().qd11_rad_s,
        s.finger().qd21_rad_s,
        s.finger().qd12_rad_s,
        s.finger().qd22_rad_s,
        s.contact(Site::Limit).normal_n,
        s.energy.kinetic_j,
        s.energy.balance_j,
        s.contact(Site::Proximal).normal_n
            + s.contact(Site::Distal).normal_n
            + s.contact(Site::Proximal).tangential_n
            + s.contact(Site::Distal).tangential_n,
    ]
}

#[track_caller]
fn assert_sound(log: &Collect, name: &str) {
    for sample in &log.samples {
        assert!(numbers(sample).iter().all(|x| x.is_finite()), "{name}: {sample:?}");
    }
    assert!(log.samples.windows(2).all(|pair| pair[0].time_s <= pair[1].time_s), "{name}: samples out of order");
}

/// The failure a scene must end with, and its log.
#[track_caller]
fn failure(scene: &Scene) -> (Failure, Collect) {
    let (result, log) = run(scene);
    assert_sound(&log, &scene.name);
    match result {
        Err(RunError::Simulation { failure, so_far }) => {
            let last = log.samples.last().unwrap_or_else(|| panic!("{}: no samples", scene.name));
            assert!(so_far.last.time_s <= failure.time_s && last.time_s <= failure.time_s);
            assert!(numbers(&so_far.last).iter().all(|x| x.is_finite()));
            (failure, log)
        }
        other => panic!("{}: did not fail: {:?}", scene.name, other.map(|o| o.last.time_s)),
    }
}

/// Both ground links swung apart or together, without object, spring and limit.
fn pulled(assembly: Assembly, q: [f64; 2], v: [f64; 2], torque_n_m: f64) -> Scene {
    let mut scene = anchor();
    scene.name = format!("{assembly:?} from {q:?} with {torque_n_m}");
    scene.system.discs.clear();
    (scene.finger_mut().limit, scene.finger_mut().spring) = (None, None);
    scene.finger_mut().linkage.assembly = assembly;
    scene.finger_mut().initial = Initial { q11_rad: q[0], q21_rad: q[1], qd11_rad_s: v[0], qd21_rad_s: v[1] };
    scene.finger_mut().motor.actuation = Actuation::Constant { torque_n_m };
    scene
}

/// One word of the obstacle, and when every method must meet it, to a relative 1e-4 of the reference run.
fn assert_ends_with(scene: &Scene, word: &str) {
    let mut times = Vec::new();
    for integrator in settings() {
        let scene = Scene { integrator, ..scene.clone() };
        let (failure, _) = failure(&scene);
        let Reason::Obstacle(text) = &failure.reason else { panic!("{}: {failure}", scene.name) };
        assert!(text.contains("singular configuration") && text.contains(word), "{}: {text}", scene.name);
        times.push(failure.time_s);
    }
    let exact = times[2];
    println!("{}: {word} at {times:?}", scene.name);
    assert!(times.iter().all(|t| (t / exact - 1.0).abs() < 1e-4), "{}: {times:?}", scene.name);
}

#[test]
fn a_loop_that_stretches_is_named_with_its_time() {
    assert_ends_with(&pulled(Assembly::Reference, [-0.7, 0.9], [-100.0, 100.0], -0.48), "stretched");
    assert_ends_with(&pulled(Assembly::Other, [-0.26, 1.05], [0.0; 2], -0.48), "stretched");
}

#[test]
fn a_loop_that_folds_is_named_with_its_time() {
    assert_ends_with(&pulled(Assembly::Reference, [0.1, 1.0], [0.0; 2], 0.48), "folded");
    assert_ends_with(&pulled(Assembly::Other, [0.1, 1.0], [0.0; 2], 0.48), "folded");
}

#[test]
fn a_start_beyond_the_reach_of_the_loop_is_refused_at_once() {
    for integrator in settings() {
        let mut scene = pulled(Assembly::Reference, [0.0, 3.1], [0.0; 2], 0.48);
        scene.integrator = integrator;
        // A12 and A22 on opposite sides: 39 mm apart, with 30 mm of links between them.
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
fn the_budget_of_steps_ends_a_run_with_its_samples() {
    for integrator in settings() {
        for budget in [1, 7, 50] {
            let mut scene = anchor();
            scene.integrator = Integrator { max_steps: budget, ..integrator };
            let (failure, log) = failure(&scene);
            assert_eq!(failure.reason, Reason::Budget(budget));
            assert!(failure.to_string().contains("max_steps"), "{failure}");
            assert!(failure.time_s > 0.0 && failure.time_s < scene.duration_s);
            assert_eq!(log.samples.last().map(|s| s.time_s), log.samples.iter().map(|s| s.time_s).reduce(f64::max));
        }
    }
}

/// Random pushes from random starts, most of which meet a fold: all end well or by name, the same way and
/// at the same time with every method and tolerance, and none with a number that is none.
#[test]
fn random_swings_into_folds_are_sound() {
    let mut random = crate::support::runs::Random(21);
    let (mut ended, mut worst) = ([0; 2], 0.0f64);
    for i in 0..150 {
        let assembly = if i % 2 == 0 { Assembly::Reference } else { Assembly::Other };
        let q21 = random.within(0.2, 2.5);
        let q = [q21 - random.within(0.7, 1.6), q21];
        let v = [random.within(-300.0, 300.0), random.within(-300.0, 300.0)];
        let mut scene = pulled(assembly, q, v, random.within(-2.0, 2.0));
        scene.log.numeric_hz = 1e5;
        let mut times = Vec::new();
        for integrator in settings() {
            scene.integrator = integrator;
            let (result, log) = run(&scene);
            assert_sound(&log, &scene.name);
            match result {
                Ok(_) => times.push(None),
                Err(RunError::Simulation { failure: Failure { time_s, reason: Reason::Obstacle(_) }, .. }) => {
                    times.push(Some(time_s));
                }
                Err(other) => panic!("{} {integrator:?}: {other}", scene.name),
            }
        }
        let exact = times[2];
        ended[usize::from(exact.is_some())] += 1;
        for time in &times {
            let off = time.unwrap_or(scene.duration_s) / exact.unwrap_or(scene.duration_s) - 1.0;
            assert!(time.is_some() == exact.is_some() && off.abs() < 1e-3, "{}: {times:?}", scene.name);
            worst = worst.max(off.abs());
        }
    }
    println!("completed {}, met a fold {}, times within {worst:.1e}", ended[0], ended[1]);
    assert!(ended[1] > 100, "{ended:?}");
}

/// Whatever is asked for: a run ends, well or by name, and never with a panic or a number that is none.
#[test]
fn extremes_do_not_panic() {
    let mut scenes = Vec::new();
    let mut add = |name: &str, change: &dyn Fn(&mut Scene)| {
        let mut scene = anchor();
        scene.name = name.to_string();
        change(&mut scene);
        scene.integrator.max_steps = 20_000;
        scenes.push(scene);
    };
    for torque_n_m in [0.0, -0.48, 1e-9, 48.0, -48.0, 1e6, 1e30, f64::MAX] {
        add(&format!("torque {torque_n_m:e}"), &|s| {
            s.finger_mut().motor.actuation = Actuation::Constant { torque_n_m }
        });
    }
    add("fast start", &|s| s.finger_mut().initial.qd11_rad_s = 1e6);
    add("fast start the other way", &|s| s.finger_mut().initial.qd21_rad_s = -1e6);
    add("no gravity", &|s| s.system.gravity_m_s2 = [0.0; 2]);
    add("much gravity", &|s| s.system.gravity_m_s2 = [1e8, -1e8]);
    add("soft object", &|s| {
        for law in s.finger_mut().contact.both_mut().map(|law| &mut law.normal) {
            (law.stiffness_n_per_m_e, law.damping_max_n_s_per_m) = (1.0, 1e-3);
        }
    });
    add("elastic object", &|s| {
        for law in s.finger_mut().contact.both_mut().map(|law| &mut law.normal) {
            law.damping_max_n_s_per_m = 0.0;
        }
    });
    add("diamond object", &|s| {
        for law in s.finger_mut().contact.both_mut().map(|law| &mut law.normal) {
            (law.stiffness_n_per_m_e, law.damping_max_n_s_per_m) = (1e14, 1e12);
        }
    });
    add("start out of reach", &|s| s.finger_mut().initial.q21_rad = 1.3);
    add("start inside the object", &|s| {
        (s.finger_mut().initial.q11_rad, s.finger_mut().initial.q21_rad) = (-0.4, 1.17)
    });
    add("tiny object", &|s| s.system.grasped_mut().shape = Shape::Disc { radius_m: 1e-6 });
    add("huge friction", &|s| {
        for law in s.finger_mut().contact.both_mut() {
            let friction = law.friction.as_mut().expect("friction");
            (friction.mu_static, friction.mu_dynamic) = (100.0, 70.0);
        }
    });
    for scene in scenes {
        for integrator in settings() {
            let scene = Scene {
                integrator: Integrator { max_steps: scene.integrator.max_steps, ..integrator },
                ..scene.clone()
            };
            // Not held to the invariants: at 1e30 N·m energies have no digits left.
            let mut log = Collect::default();
            let result = run_analytic(&scene, &mut log);
            let outcome = match &result {
                Ok(outcome) => format!("done in {} steps", outcome.work.steps),
                Err(error) => error.to_string(),
            };
            println!("{}, {:?} {:e}: {outcome}", scene.name, integrator.method, integrator.rtol);
            assert_sound(&log, &scene.name);
        }
    }
}
