//! Discs among each other: radii, momentum, rolling, symmetry, and the order of the engine in free motion.

use std::f64::consts::TAU;

use crate::support::laws::{
    BOTH, FRICTION, THESIS, complete, disc, driven, on_plane, relative, scene, sliding, spring, stepped,
};
use phalanx::law::NormalLaw;
use phalanx::scene::{DiscMotion, Integrator, Preset, Response, Scene};
use phalanx::trace::{Model, RunError, run};

/// Free, turning, of 1 kg, a homogeneous disc.
fn free(radius: f64, velocity_m_s: [f64; 2], spin_rad_s: f64) -> DiscMotion {
    DiscMotion::Free { mass_kg: 1.0, inertia_kg_m2: Some(0.5 * radius * radius), velocity_m_s, spin_rad_s }
}

const REBOUND: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 200.0, transition_m: 1e-4 };

/// Thesis Figs. B.4–B.6: discs of 0.05, 5 and 10 cm of one mass hit one of 10 cm at one speed.
fn three_radii() -> Scene {
    let mut discs = vec![disc("anvil", 0.1, [0.0; 2], DiscMotion::Fixed)];
    for (index, radius) in [0.0005, 0.05, 0.1].into_iter().enumerate() {
        let angle = TAU * index as f64 / 3.0 + 0.3;
        let direction = [angle.cos(), angle.sin()];
        let centre = direction.map(|x| x * (0.1 + radius + 1e-3));
        discs.push(disc(&format!("disc-{index}"), radius, centre, sliding(direction.map(|x| -x))));
    }
    scene(discs, REBOUND, None, 15e-3)
}

/// Force and position over time do not know of the radius: to rounding in the analytic model, and in the engine, whose steps
/// are common to all three discs.
#[test]
fn forces_do_not_depend_on_the_radius() {
    for (model, bound) in [(Model::Analytic, 1e-9), (Model::Engine, 1e-9)] {
        let (outcome, log) = complete(model, &three_radii());
        let hits = |pair: &usize| outcome.contacts[*pair].touchdowns > 0;
        let pairs: Vec<usize> = (0..6).filter(hits).collect();
        assert_eq!(pairs.len(), 3, "{}", model.name());
        let peak = outcome.contacts[pairs[0]].peak_normal_n;
        let (mut worst, mut pressing): (f64, u32) = (0.0, 0);
        for sample in &log.samples {
            let force = |pair: usize| sample.contacts[pair].normal_n;
            pressing += u32::from(force(pairs[0]) > 0.1 * peak);
            for other in &pairs[1..] {
                worst = worst.max((force(*other) - force(pairs[0])).abs() / peak);
            }
        }
        let summaries = pairs.iter().map(|pair| relative(outcome.contacts[*pair].peak_normal_n, peak));
        let worst = summaries.fold(worst, f64::max);
        println!("{}: {worst:.1e}, {pressing} samples", model.name());
        assert!(pressing > 10);
        assert!(worst < bound, "{}: {worst:e}", model.name());
    }
}

/// Two free discs, off centre, with friction and spin: what one gets the other loses, and energy is accounted for.
#[test]
fn momentum_is_kept_when_free_discs_collide() {
    let discs = vec![
        disc("a", 0.05, [-0.0515, 0.0], free(0.05, [1.0, 0.1], 8.0)),
        disc("b", 0.04, [0.03, 0.04], free(0.04, [-0.5, 0.0], -3.0)),
    ];
    let scene = scene(discs, REBOUND, Some(FRICTION), 40e-3);
    for (model, bound) in [(Model::Analytic, 1e-10), (Model::Engine, 2e-4)] {
        let (outcome, log) = complete(model, &scene);
        assert_eq!(outcome.contacts[0].touchdowns, 1, "{}", model.name());
        let momentum = |axis: usize, discs: &[phalanx::trace::BodyState]| {
            discs.iter().map(|disc| disc.velocity_m_s[axis]).sum::<f64>()
        };
        let mut worst: f64 = 0.0;
        for sample in &log.samples {
            worst = worst.max((momentum(0, &sample.bodies) - 0.5).abs()).max((momentum(1, &sample.bodies) - 0.1).abs());
        }
        assert!(worst < 1e-12, "{}: momentum is off by {worst:e}", model.name());
        // Friction turns both discs against the slip of their surfaces: by its impulse times each one's radius.
        let [a, b] = [&outcome.last.bodies[0], &outcome.last.bodies[1]];
        let impulse = |disc: &phalanx::trace::BodyState, spin: f64, r: f64| 0.5 * r * (disc.spin_rad_s - spin);
        let both = [impulse(a, 8.0, 0.05), impulse(b, -3.0, 0.04)];
        assert!(both[0].abs() > 1e-2 && (both[0] - both[1]).abs() < 1e-9, "{}: {both:?}", model.name());
        let energy = &outcome.last.energy;
        println!("{}: balance {:.1e}, lost {:.3}", model.name(), energy.balance_j, energy.dissipated_j);
        assert!(energy.dissipated_j > 0.05 && energy.balance_j.abs() < bound, "{energy:?}");
    }
}

/// A disc that slides on the half plane under its weight rolls in the end, at 1/(1 + I/(m r²)) of its speed; friction acts at
/// its surface, so that m v r + I ω about the contact stays what it was. Slip dies out within the law's creep.
#[test]
fn a_sliding_disc_ends_rolling() {
    let (radius, weight): (f64, f64) = (0.05, 9.81);
    let rest = (weight / THESIS.stiffness_n_per_m_e).powf(1.0 / THESIS.exponent);
    for (spin, wanted) in [(0.0, 2.0 / 3.0), (40.0, 2.0 / 3.0 - 40.0 * 0.05 / 3.0)] {
        let discs = vec![disc("wheel", radius, [0.0, radius - rest], free(radius, [1.0, 0.0], spin))];
        let mut scene = on_plane(scene(discs, THESIS, Some(FRICTION), 0.3));
        scene.system.gravity_m_s2 = [0.0, -weight];
        for (model, bound) in [(Model::Analytic, 1e-9), (Model::Engine, 1e-6)] {
            let (outcome, _) = complete(model, &scene);
            let wheel = &outcome.last.bodies[0];
            let rolling = wheel.velocity_m_s[0] + wheel.spin_rad_s * radius;
            println!("{}: slip {rolling:.1e}, speed off by {:.1e}", model.name(), wheel.velocity_m_s[0] - wanted);
            assert!(rolling.abs() < bound, "{}: slips at {rolling:e} m/s", model.name());
            assert!((wheel.velocity_m_s[0] - wanted).abs() < bound, "{}: {wheel:?}", model.name());
            assert!((outcome.last.contacts[0].normal_n / weight - 1.0).abs() < 1e-6);
            let lost = 0.5 * (1.0 + 0.5 * (spin * radius).powi(2)) - 0.75 * wanted * wanted;
            assert!(relative(outcome.last.energy.dissipated_j, lost) < 1e-4, "{:?} {lost}", outcome.last.energy);
        }
    }
}

#[test]
fn a_symmetric_collision_stays_symmetric() {
    let discs = vec![
        disc("left", 0.05, [-0.051, 0.0], free(0.05, [1.0, 0.0], 0.0)),
        disc("right", 0.05, [0.051, 0.0], free(0.05, [-1.0, 0.0], 0.0)),
    ];
    let scene = scene(discs, REBOUND, Some(FRICTION), 20e-3);
    for model in BOTH {
        let (outcome, log) = complete(model, &scene);
        assert_eq!(outcome.contacts[0].touchdowns, 1);
        for sample in &log.samples {
            let [left, right] = [&sample.bodies[0], &sample.bodies[1]];
            assert!((left.centre_m[0] + right.centre_m[0]).abs() < 1e-15, "{}: {sample:?}", model.name());
            assert!((left.velocity_m_s[0] + right.velocity_m_s[0]).abs() < 1e-13, "{}", model.name());
            for disc in [left, right] {
                assert!(disc.centre_m[1].abs() < 1e-15 && disc.spin_rad_s.abs() < 1e-12, "{}", model.name());
            }
        }
        assert!(outcome.last.bodies[0].velocity_m_s[0] < -0.1);
    }
}

/// Free motion: a parabola exactly, and a turn to second order.
#[test]
fn the_engine_is_of_second_order_in_free_motion() {
    let discs = vec![disc("ball", 0.05, [0.0; 2], free(0.05, [1.0, 2.0], 100.0))];
    let mut scene = scene(discs, THESIS, None, 0.02);
    scene.system.gravity_m_s2 = [0.0, -9.81];
    let mut errors = Vec::new();
    for step in [2e-4, 1e-4, 5e-5] {
        let (outcome, _) = complete(Model::Engine, &stepped(&scene, step));
        let ball = &outcome.last.bodies[0];
        assert!((ball.centre_m[0] - 0.02).abs() < 1e-14);
        assert!((ball.centre_m[1] - (0.04 - 0.5 * 9.81 * 4e-4)).abs() < 1e-14, "{ball:?}");
        errors.push((ball.angle_rad - 2.0).abs());
    }
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.05, "{errors:?}");
    }
    let (outcome, _) = complete(Model::Analytic, &scene);
    assert!((outcome.last.bodies[0].angle_rad - 2.0).abs() < 1e-13);
}

/// Everyday settings follow the reference ones.
#[test]
fn the_engineering_preset_follows_the_reference() {
    let reference = three_radii();
    let everyday = Scene { integrator: Integrator::preset(Preset::Engineering), ..reference.clone() };
    let (fine, _) = complete(Model::Analytic, &reference);
    let (coarse, _) = complete(Model::Analytic, &everyday);
    for (a, b) in fine.last.bodies.iter().zip(&coarse.last.bodies) {
        for axis in 0..2 {
            assert!((a.centre_m[axis] - b.centre_m[axis]).abs() < 1e-7, "{a:?} {b:?}");
        }
    }
    assert!(coarse.work.steps < fine.work.steps);
}

/// A scene beyond the closed-form model is refused in words; the engine takes it.
#[test]
fn too_many_discs_are_refused_by_the_analytic_model_alone() {
    let discs = (0..4).map(|i| disc(&format!("d{i}"), 0.05, [0.2 * f64::from(i), 0.0], sliding([0.0; 2]))).collect();
    let scene = scene(discs, spring(1e8, 2.2), None, 1e-3);
    let Err(RunError::Simulation { failure, .. }) = run(Model::Analytic, &scene, &mut ()) else {
        panic!("four moving discs are too many")
    };
    let message = failure.to_string();
    assert!(message.contains("4 discs move and 6 pairs") && message.contains("--model engine"), "{message}");
    complete(Model::Engine, &scene);
}

/// A driven disc pushes a free one: its drive does the work that the free one and the contact take up.
#[test]
fn a_drive_pays_for_what_it_pushes() {
    let discs = vec![
        disc("ball", 0.05, [0.0, 0.0], free(0.05, [0.0; 2], 0.0)),
        disc("bat", 0.05, [-0.101, 0.01], driven([1.0, 0.0], [20.0, 0.0])),
    ];
    let scene = scene(discs, REBOUND, Some(FRICTION), 10e-3);
    let mut final_speeds = Vec::new();
    for (model, bound) in [(Model::Analytic, 1e-10), (Model::Engine, 1e-4)] {
        let (outcome, _) = complete(model, &scene);
        let [ball, bat] = [&outcome.last.bodies[0], &outcome.last.bodies[1]];
        // The bat does not feel it.
        assert!((bat.centre_m[0] - (-0.101 + 0.01 + 1e-3)).abs() < 1e-14, "{}: {bat:?}", model.name());
        assert!((bat.velocity_m_s[0] - 1.2).abs() < 1e-13 && bat.velocity_m_s[1] == 0.0, "{}: {bat:?}", model.name());
        let energy = &outcome.last.energy;
        assert!(energy.motor_work_j > energy.kinetic_j && energy.kinetic_j > 0.3, "{energy:?}");
        assert!(energy.balance_j.abs() < bound * energy.motor_work_j, "{}: {energy:?}", model.name());
        final_speeds.push(ball.velocity_m_s);
    }
    for axis in 0..2 {
        assert!((final_speeds[0][axis] - final_speeds[1][axis]).abs() < 1e-4, "{final_speeds:?}");
    }
}

/// rapier's own contact works on discs too: Newton's restitution and Coulomb's friction, of discs against each other and
/// against the half plane.
#[test]
fn rapiers_own_contact_answers_for_discs() {
    let rapier = |mut scene: Scene, friction: f64, restitution: f64| {
        scene.engine.response = Response::Rapier { friction, restitution };
        scene.engine.iterations = 50;
        stepped(&scene, 1e-5)
    };
    for restitution in [0.0, 0.5, 1.0] {
        let discs = vec![
            disc("hammer", 0.05, [-0.0512, 0.0], sliding([1.0, 0.0])),
            disc("ball", 0.05, [0.05, 0.0], sliding([0.0; 2])),
        ];
        let (outcome, _) = complete(Model::Engine, &rapier(scene(discs, THESIS, None, 5e-3), 0.0, restitution));
        let speeds = [0, 1].map(|disc: usize| outcome.last.bodies[disc].velocity_m_s[0]);
        assert!((speeds[0] + speeds[1] - 1.0).abs() < 1e-12, "{speeds:?}");
        assert!((speeds[1] - speeds[0] - restitution).abs() < 1e-3, "{restitution}: {speeds:?}");
        assert!((outcome.contacts[0].impulse_n_s - speeds[1]).abs() < 1e-9);
        assert_eq!(outcome.contacts[0].touchdowns, 1);
        let lost = 0.25 * (1.0 - restitution * restitution);
        assert!((outcome.last.energy.dissipated_j - lost).abs() < 1e-3, "{:?}", outcome.last.energy);
    }
    // μ g t of the speed is gone after t.
    let mut slide = on_plane(scene(vec![disc("puck", 0.05, [0.0, 0.05], sliding([1.0, 0.0]))], THESIS, None, 0.05));
    slide.system.gravity_m_s2 = [0.0, -9.81];
    let (outcome, _) = complete(Model::Engine, &rapier(slide, 0.5, 0.0));
    let speed = outcome.last.bodies[0].velocity_m_s[0];
    assert!((speed - (1.0 - 0.5 * 9.81 * 0.05)).abs() < 1e-3, "{speed}");
}
