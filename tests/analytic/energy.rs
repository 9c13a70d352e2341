//! Energy: what the motor puts in is found again as motion, height, springs and loss, along whole closings with impacts.

use crate::support::runs::{Collect, anchor, complete, engineering, reference};
use phalanx::law::ContactLaw;
use phalanx::scene::{Actuation, Integrator, Method, Placement, Scene, Spring, SpringKind};
use phalanx::trace::{Outcome, Sample};

fn with_spring(kind: SpringKind, placement: Placement) -> Scene {
    let mut scene = anchor();
    scene.name = format!("{placement:?}, {kind:?}");
    scene.finger_mut().spring = Some(Spring { kind, placement });
    scene
}

/// Closings that differ in everything that stores or eats energy.
fn scenes() -> Vec<Scene> {
    let mut scenes = vec![anchor()];
    let mut add = |name: &str, change: &dyn Fn(&mut Scene)| {
        let mut scene = anchor();
        scene.name = name.to_string();
        change(&mut scene);
        scenes.push(scene);
    };
    let without_friction = |law: &mut ContactLaw| law.friction = None;
    add("frictionless", &|scene| {
        without_friction(&mut scene.finger_mut().contact.proximal);
        without_friction(&mut scene.finger_mut().contact.distal);
    });
    add("no object", &|scene| {
        scene.system.discs.clear();
        scene.duration_s = 8e-3;
    });
    add("gravity only", &|scene| {
        scene.finger_mut().motor.actuation = Actuation::Constant { torque_n_m: 0.0 };
        scene.finger_mut().spring = None;
        scene.system.gravity_m_s2 = [-9.81, 0.0];
        scene.duration_s = 60e-3;
    });
    add("torque table", &|scene| {
        let points = vec![(0.0, 0.1), (2e-3, 0.5), (9e-3, 0.2)];
        scene.finger_mut().motor.actuation =
            Actuation::Table { points, interpolation: phalanx::scene::Interpolation::Linear };
    });
    let torsional = SpringKind::Torsional { stiffness_n_m_per_rad: 0.06, preload_rad: 1.92 };
    let constant = SpringKind::Constant { torque_n_m: 0.1326 };
    for placement in [Placement::GroundLinks, Placement::DrivenCoupler, Placement::Phalanges, Placement::CouplerDistal]
    {
        for kind in [constant, torsional] {
            scenes.push(with_spring(kind, placement));
        }
    }
    scenes
}

/// What the motor moved at most, or where it did nothing, the largest kinetic energy: the scale of a run's energy.
fn turnover(log: &Collect) -> f64 {
    let largest = |f: fn(&Sample) -> f64| log.samples.iter().map(f).fold(0.0, f64::max);
    largest(|s| s.energy.motor_work_j.abs()).max(largest(|s| s.energy.kinetic_j))
}

/// Largest imbalance and largest drop of the dissipated energy, relative to the turnover.
fn imbalance(log: &Collect) -> [f64; 2] {
    let turnover = turnover(log);
    let balance = log.samples.iter().map(|s| s.energy.balance_j.abs()).fold(0.0, f64::max);
    let mut highest = 0.0f64;
    let mut drop = 0.0f64;
    for sample in &log.samples {
        highest = highest.max(sample.energy.dissipated_j);
        drop = drop.max(highest - sample.energy.dissipated_j);
    }
    [balance / turnover, drop / turnover]
}

fn run_all(settings: Integrator) -> Vec<(Scene, Outcome, Collect)> {
    let run = |mut scene: Scene| {
        scene.integrator = settings;
        let (outcome, log) = complete(&scene);
        (scene, outcome, log)
    };
    scenes().into_iter().map(run).collect()
}

fn assert_balanced(settings: Integrator, tolerance: f64, drop_tolerance: f64) {
    for (scene, outcome, log) in run_all(settings) {
        let [balance, drop] = imbalance(&log);
        println!(
            "{:?} {}: balance {balance:.1e}, drop {drop:.1e}, contacts {:?}",
            settings.method,
            scene.name,
            outcome.contacts.iter().map(|s| s.touchdowns).collect::<Vec<_>>()
        );
        assert!(balance < tolerance, "{}: {balance:e}", scene.name);
        assert!(drop < drop_tolerance, "{}: {drop:e}", scene.name);
    }
}

#[test]
fn reference_settings_balance_to_a_billionth() {
    assert_balanced(reference(), 1e-9, 1e-9);
}

#[test]
fn the_other_method_balances_at_the_same_tolerances() {
    assert_balanced(Integrator { method: Method::Rodas5p, ..reference() }, 1e-9, 1e-9);
}

#[test]
fn engineering_settings_balance_to_a_hundred_thousandth() {
    assert_balanced(engineering(), 1e-5, 1e-8);
}

#[test]
fn work_of_a_constant_torque_is_torque_times_angle() {
    for settings in [engineering(), reference()] {
        let mut scene = anchor();
        scene.integrator = settings;
        let (_, log) = complete(&scene);
        let mut worst = 0.0f64;
        for s in &log.samples {
            let work = 0.48 * (s.finger().q11_rad - scene.finger().initial.q11_rad);
            worst = worst.max((s.energy.motor_work_j - work).abs());
        }
        println!("{:?}: work off by {worst:e} J", settings.method);
        assert!(worst < 1e-13, "{worst:e}");
    }
}

/// Kinetic, gravity and spring energy recomputed from the logged angles and rates by other means.
#[test]
fn logged_energies_are_those_of_the_logged_state() {
    let mut scene = anchor();
    scene.integrator = reference();
    let (_, log) = complete(&scene);
    let (l, b) = (scene.finger().linkage.lengths, scene.finger().linkage.bodies);
    let dip = |[x, y]: [f64; 2], angle: f64| x * angle.sin() + y * angle.cos();
    let mut height_energy = Vec::new();
    for s in &log.samples {
        let theta3 = s.finger().q11_rad + s.finger().q12_rad;
        let theta4 = s.finger().q13_rad;
        let heights = [
            (b.l11, dip(b.l11.com_m, s.finger().q11_rad)),
            (b.l21, dip(b.l21.com_m, s.finger().q21_rad)),
            (b.l12, l.l11_m * s.finger().q11_rad.sin() + dip(b.l12.com_m, theta3)),
            (b.l22, l.l21_m * s.finger().q21_rad.sin() + dip(b.l22.com_m, theta4)),
        ];
        // Gravity pulls along +y.
        let gravity: f64 = heights.iter().map(|(body, y)| -9.81 * body.mass_kg * y).sum();
        height_energy.push(gravity - s.energy.gravity_j);
        let velocity = |base: [f64; 2], com: [f64; 2], angle: f64, rate: f64| {
            let (sin, cos) = angle.sin_cos();
            [base[0] - rate * (sin * com[0] + cos * com[1]), base[1] + rate * (cos * com[0] - sin * com[1])]
        };
        let joint = |length: f64, angle: f64, rate: f64| [-length * rate * angle.sin(), length * rate * angle.cos()];
        let (rate3, rate4) =
            (s.finger().qd11_rad_s + s.finger().qd12_rad_s, s.finger().qd21_rad_s + s.finger().qd22_rad_s);
        let none = [0.0; 2];
        let moving = [
            (b.l11, velocity(none, b.l11.com_m, s.finger().q11_rad, s.finger().qd11_rad_s), s.finger().qd11_rad_s),
            (b.l21, velocity(none, b.l21.com_m, s.finger().q21_rad, s.finger().qd21_rad_s), s.finger().qd21_rad_s),
            (
                b.l12,
                velocity(joint(l.l11_m, s.finger().q11_rad, s.finger().qd11_rad_s), b.l12.com_m, theta3, rate3),
                rate3,
            ),
            (
                b.l22,
                velocity(joint(l.l21_m, s.finger().q21_rad, s.finger().qd21_rad_s), b.l22.com_m, theta4, rate4),
                rate4,
            ),
        ];
        let kinetic: f64 = moving
            .iter()
            .map(|(body, v, w)| 0.5 * (body.mass_kg * (v[0] * v[0] + v[1] * v[1]) + body.inertia_kg_m2 * w * w))
            .sum();
        assert!((kinetic - s.energy.kinetic_j).abs() < 1e-13 * (1.0 + kinetic), "{kinetic} {}", s.energy.kinetic_j);
        // Constant spring torque on q22, from the straight line on.
        let spring = 0.1326 * (s.finger().q22_rad + l.phi22_rad);
        assert!((spring - s.energy.spring_j).abs() < 1e-14, "{spring} {}", s.energy.spring_j);
    }
    let spread = height_energy.iter().map(|e| (e - height_energy[0]).abs()).fold(0.0, f64::max);
    assert!(spread < 1e-16, "{spread:e}");
}
