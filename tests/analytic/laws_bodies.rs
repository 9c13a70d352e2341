//! Contacts between discs: momentum, rolling, symmetry, drives; and the order of the engine in free motion.

use crate::support::laws::{
    BOTH_MODELS, THESIS_FRICTION, THESIS_NORMAL, disc, driven, free_translation, mechanism, relative_error, run_to_end,
    scene, scene_on_plane, spring, with_fixed_step,
};
use crate::support::runs::assert_below;
use phalanx::law::NormalLaw;
use phalanx::scene::{DiscMotion, Response, Scene};
use phalanx::trace::{BodyState, Model};

/// A free homogeneous disc of 1 kg.
fn homogeneous(radius: f64, velocity_m_s: [f64; 2], spin_rad_s: f64) -> DiscMotion {
    DiscMotion::Free { mass_kg: 1.0, inertia_kg_m2: Some(0.5 * radius * radius), velocity_m_s, spin_rad_s }
}

const DAMPED_IMPACT: NormalLaw = NormalLaw::step(1e8, 2.2, 200.0, 1e-4);

/// An oblique collision of two free discs with friction and spin conserves momentum and balances energy.
#[test]
fn free_discs_conserve_momentum_in_a_collision() {
    let discs = vec![
        disc("a", 0.05, [-0.0515, 0.0], homogeneous(0.05, [1.0, 0.1], 8.0)),
        disc("b", 0.04, [0.03, 0.04], homogeneous(0.04, [-0.5, 0.0], -3.0)),
    ];
    let scene = scene(discs, DAMPED_IMPACT, Some(THESIS_FRICTION), 40e-3);
    for (model, bound) in [(Model::Analytic, 1e-10), (Model::Engine, 2e-4)] {
        let (outcome, log) = run_to_end(model, &scene);
        assert_eq!(outcome.contacts[0].touchdowns, 1, "{model:?}");
        for sample in &log.samples {
            for (axis, momentum) in [0.5, 0.1].into_iter().enumerate() {
                let sum: f64 = sample.bodies().map(|disc| disc.velocity_m_s[axis]).sum();
                assert_below((sum - momentum).abs(), 1e-12, format!("{model:?}: momentum"));
            }
        }
        // The tangential impulse times the radius changes the spin of each disc; it is the same for both.
        let [a, b] = [outcome.last.body(0), outcome.last.body(1)];
        let impulse = |disc: &BodyState, spin: f64, r: f64| 0.5 * r * (disc.spin_rad_s - spin);
        let impulses = [impulse(&a, 8.0, 0.05), impulse(&b, -3.0, 0.04)];
        assert!(impulses[0].abs() > 1e-2 && (impulses[0] - impulses[1]).abs() < 1e-9, "{model:?}: {impulses:?}");
        let energy = &outcome.last.energy();
        assert!(energy.dissipated_j > 0.05 && energy.balance_j.abs() < bound, "{model:?}: {energy:?}");
    }
}

/// A disc that slides on the half plane under its weight ends up rolling at 1/(1 + I/(m r²)) of its initial speed,
/// because friction conserves the angular momentum m v r + I ω about the contact. The remaining slip is the creep of
/// the law.
#[test]
fn a_sliding_disc_ends_up_rolling() {
    let (radius, weight): (f64, f64) = (0.05, 9.81);
    let rest_depth = (weight / THESIS_NORMAL.stiffness_n_per_m_e).powf(1.0 / THESIS_NORMAL.exponent);
    for (spin, expected) in [(0.0, 2.0 / 3.0), (40.0, 2.0 / 3.0 - 40.0 * 0.05 / 3.0)] {
        let discs = vec![disc("wheel", radius, [0.0, radius - rest_depth], homogeneous(radius, [1.0, 0.0], spin))];
        let mut scene = scene_on_plane(discs, THESIS_NORMAL, Some(THESIS_FRICTION), 0.3);
        mechanism(&mut scene).gravity_m_s2 = [0.0, -weight];
        for (model, bound) in [(Model::Analytic, 1e-9), (Model::Engine, 1e-6)] {
            let last = run_to_end(model, &scene).0.last;
            let wheel = last.body(0);
            assert_below((wheel.velocity_m_s[0] + wheel.spin_rad_s * radius).abs(), bound, "slip");
            assert_below((wheel.velocity_m_s[0] - expected).abs(), bound, "speed");
            assert_below(relative_error(last.contact(0).normal_n, weight), 1e-6, "normal force");
            let expected_loss = 0.5 * (1.0 + 0.5 * (spin * radius).powi(2)) - 0.75 * expected * expected;
            assert_below(relative_error(last.energy().dissipated_j, expected_loss), 1e-4, "dissipated energy");
        }
    }
}

#[test]
fn a_symmetric_collision_remains_symmetric() {
    let discs = vec![
        disc("left", 0.05, [-0.051, 0.0], homogeneous(0.05, [1.0, 0.0], 0.0)),
        disc("right", 0.05, [0.051, 0.0], homogeneous(0.05, [-1.0, 0.0], 0.0)),
    ];
    let scene = scene(discs, DAMPED_IMPACT, Some(THESIS_FRICTION), 20e-3);
    for model in BOTH_MODELS {
        let (outcome, log) = run_to_end(model, &scene);
        assert_eq!(outcome.contacts[0].touchdowns, 1);
        for sample in &log.samples {
            let [left, right] = [sample.body(0), sample.body(1)];
            assert!((left.centre_m[0] + right.centre_m[0]).abs() < 1e-15, "{model:?}: {sample:?}");
            assert!((left.velocity_m_s[0] + right.velocity_m_s[0]).abs() < 1e-13, "{model:?}: {sample:?}");
            for disc in [left, right] {
                assert!(disc.centre_m[1].abs() < 1e-15 && disc.spin_rad_s.abs() < 1e-12, "{model:?}: {sample:?}");
            }
        }
        assert!(outcome.last.body(0).velocity_m_s[0] < -0.1);
    }
}

/// In free motion the parabola and the rotation are exact for any step; rapier alone turns a body by atan(ω dt).
#[test]
fn the_engine_is_exact_in_free_motion() {
    let discs = vec![disc("ball", 0.05, [0.0; 2], homogeneous(0.05, [1.0, 2.0], 100.0))];
    let mut scene = scene(discs, THESIS_NORMAL, None, 0.02);
    mechanism(&mut scene).gravity_m_s2 = [0.0, -9.81];
    for step in [1e-3, 2e-4, 5e-5] {
        let ball = run_to_end(Model::Engine, &with_fixed_step(&scene, step)).0.last.body(0);
        assert!((ball.centre_m[0] - 0.02).abs() < 1e-14, "{ball:?}");
        assert!((ball.centre_m[1] - (0.04 - 0.5 * 9.81 * 4e-4)).abs() < 1e-14, "{ball:?}");
        assert!((ball.angle_rad - 2.0).abs() < 1e-13, "{step}: {ball:?}");
    }
    let ball = run_to_end(Model::Analytic, &scene).0.last.body(0);
    assert!((ball.angle_rad - 2.0).abs() < 1e-13);
}

/// Twelve equal discs in a row, with contacts between all pairs: elastic impacts pass the speed of the first to the last.
#[test]
fn twelve_discs_pass_on_their_speed() {
    let speed = |i: i32| if i == 0 { 1.0 } else { 0.0 };
    let discs = (0..12)
        .map(|i| disc(&format!("d{i:02}"), 0.05, [0.11 * f64::from(i), 0.0], free_translation([speed(i), 0.0])))
        .collect();
    let scene = scene(discs, spring(1e8, 2.2), None, 0.2);
    for (model, bound) in [(Model::Analytic, 1e-8), (Model::Engine, 1e-3)] {
        let last = run_to_end(model, &scene).0.last;
        assert_eq!(last.counts().contacts, 66);
        for (index, body) in last.bodies().enumerate() {
            let expected = if index == 11 { 1.0 } else { 0.0 };
            assert_below((body.velocity_m_s[0] - expected).abs(), bound, format!("{model:?}: disc {index}"));
        }
    }
}

/// A driven disc pushes a free one. The work of the drive equals the energy of the free disc and of the contact.
#[test]
fn a_drive_does_the_work_on_the_disc_it_pushes() {
    let discs = vec![
        disc("ball", 0.05, [0.0, 0.0], homogeneous(0.05, [0.0; 2], 0.0)),
        disc("bat", 0.05, [-0.101, 0.01], driven([1.0, 0.0], [20.0, 0.0])),
    ];
    let scene = scene(discs, DAMPED_IMPACT, Some(THESIS_FRICTION), 10e-3);
    let final_speeds = [(Model::Analytic, 1e-10), (Model::Engine, 1e-4)].map(|(model, bound)| {
        let last = run_to_end(model, &scene).0.last;
        let [ball, bat] = [last.body(0), last.body(1)];
        // The driven disc follows its prescribed motion.
        assert!((bat.centre_m[0] - (-0.101 + 0.01 + 1e-3)).abs() < 1e-14, "{model:?}: {bat:?}");
        assert!((bat.velocity_m_s[0] - 1.2).abs() < 1e-13 && bat.velocity_m_s[1] == 0.0, "{model:?}: {bat:?}");
        let energy = &last.energy();
        assert!(energy.motor_work_j > energy.kinetic_j && energy.kinetic_j > 0.3, "{energy:?}");
        assert!(energy.balance_j.abs() < bound * energy.motor_work_j, "{model:?}: {energy:?}");
        ball.velocity_m_s
    });
    for axis in 0..2 {
        assert!((final_speeds[0][axis] - final_speeds[1][axis]).abs() < 1e-4, "{final_speeds:?}");
    }
}

/// rapier's contact model on discs: Newton's restitution and Coulomb friction, between discs and against the half
/// plane.
#[test]
fn rapier_contact_model_works_for_discs() {
    let run_rapier = |mut scene: Scene, friction: f64, restitution: f64| {
        scene.engine.response = Response::Rapier { friction, restitution };
        scene.engine.iterations = 50;
        run_to_end(Model::Engine, &with_fixed_step(&scene, 1e-5)).0
    };
    for restitution in [0.0, 0.5, 1.0] {
        let discs = vec![
            disc("hammer", 0.05, [-0.0512, 0.0], free_translation([1.0, 0.0])),
            disc("ball", 0.05, [0.05, 0.0], free_translation([0.0; 2])),
        ];
        let outcome = run_rapier(scene(discs, THESIS_NORMAL, None, 5e-3), 0.0, restitution);
        let speeds = [0, 1].map(|disc: usize| outcome.last.body(disc).velocity_m_s[0]);
        assert!((speeds[0] + speeds[1] - 1.0).abs() < 1e-12, "{speeds:?}");
        assert!((speeds[1] - speeds[0] - restitution).abs() < 1e-3, "{restitution}: {speeds:?}");
        assert!((outcome.contacts[0].impulse_n_s - speeds[1]).abs() < 1e-9);
        assert_eq!(outcome.contacts[0].touchdowns, 1);
        let expected_loss = 0.25 * (1.0 - restitution * restitution);
        assert!((outcome.last.energy().dissipated_j - expected_loss).abs() < 1e-3, "{:?}", outcome.last.energy());
    }
    // Friction reduces the speed by μ g t.
    let puck = disc("puck", 0.05, [0.0, 0.05], free_translation([1.0, 0.0]));
    let mut sliding_scene = scene_on_plane(vec![puck], THESIS_NORMAL, None, 0.05);
    mechanism(&mut sliding_scene).gravity_m_s2 = [0.0, -9.81];
    let speed = run_rapier(sliding_scene, 0.5, 0.0).last.body(0).velocity_m_s[0];
    assert!((speed - (1.0 - 0.5 * 9.81 * 0.05)).abs() < 1e-3, "{speed}");
}
