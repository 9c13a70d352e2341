//! Energy balance: the motor work equals the change of kinetic, gravitational, spring and contact energy plus
//! dissipation, over whole closings with impacts.

use crate::support::runs::{CollectSink, engineering_settings, experiment_95, reference_settings, run_to_end};
use phalanx::law::ContactLaw;
use phalanx::scene::{Actuation, Integrator, Method, Placement, Scene, Spring, SpringKind};
use phalanx::trace::{Outcome, Sample};

fn with_spring(kind: SpringKind, placement: Placement) -> Scene {
    let mut scene = experiment_95();
    scene.name = format!("{placement:?}, {kind:?}");
    scene.finger_mut().spring = Some(Spring { kind, placement });
    scene
}

/// Closings that differ in the elements that store or dissipate energy.
fn scenes() -> Vec<Scene> {
    let mut scenes = vec![experiment_95()];
    let mut add_variant = |name: &str, change: &dyn Fn(&mut Scene)| {
        let mut scene = experiment_95();
        scene.name = name.to_string();
        change(&mut scene);
        scenes.push(scene);
    };
    let without_friction = |law: &mut ContactLaw| law.friction = None;
    add_variant("frictionless", &|scene| {
        without_friction(&mut scene.finger_mut().contact.proximal);
        without_friction(&mut scene.finger_mut().contact.distal);
    });
    add_variant("no object", &|scene| {
        scene.system.discs.clear();
        scene.duration_s = 8e-3;
    });
    add_variant("gravity only", &|scene| {
        scene.finger_mut().motor.actuation = Actuation::Constant { torque_n_m: 0.0 };
        scene.finger_mut().spring = None;
        scene.system.gravity_m_s2 = [-9.81, 0.0];
        scene.duration_s = 60e-3;
    });
    add_variant("torque table", &|scene| {
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

/// Energy scale of a run: the larger of the largest motor work and the largest kinetic energy, J.
fn energy_scale(log: &CollectSink) -> f64 {
    let largest = |f: fn(&Sample) -> f64| log.samples.iter().map(f).fold(0.0, f64::max);
    largest(|s| s.energy().motor_work_j.abs()).max(largest(|s| s.energy().kinetic_j))
}

/// Largest imbalance and largest decrease of the dissipated energy, relative to the energy scale.
fn relative_imbalance(log: &CollectSink) -> [f64; 2] {
    let energy_scale = energy_scale(log);
    let balance = log.samples.iter().map(|s| s.energy().balance_j.abs()).fold(0.0, f64::max);
    let mut highest = 0.0f64;
    let mut dissipation_drop = 0.0f64;
    for sample in &log.samples {
        highest = highest.max(sample.energy().dissipated_j);
        dissipation_drop = dissipation_drop.max(highest - sample.energy().dissipated_j);
    }
    [balance / energy_scale, dissipation_drop / energy_scale]
}

fn run_all(settings: Integrator) -> Vec<(Scene, Outcome, CollectSink)> {
    let run = |mut scene: Scene| {
        scene.integrator = settings;
        let (outcome, log) = run_to_end(&scene);
        (scene, outcome, log)
    };
    scenes().into_iter().map(run).collect()
}

fn assert_balanced(settings: Integrator, tolerance: f64, dissipation_tolerance: f64) {
    for (scene, outcome, log) in run_all(settings) {
        let [balance, dissipation_drop] = relative_imbalance(&log);
        println!(
            "{:?} {}: balance {balance:.1e}, decrease of dissipation {dissipation_drop:.1e}, contacts {:?}",
            settings.method,
            scene.name,
            outcome.contacts.iter().map(|s| s.touchdowns).collect::<Vec<_>>()
        );
        assert!(balance < tolerance, "{}: {balance:e}", scene.name);
        assert!(dissipation_drop < dissipation_tolerance, "{}: {dissipation_drop:e}", scene.name);
    }
}

#[test]
fn reference_settings_balance_energy_to_1e_9() {
    assert_balanced(reference_settings(), 1e-9, 1e-9);
}

#[test]
fn rodas5p_balances_at_reference_tolerances() {
    assert_balanced(Integrator { method: Method::Rodas5p, ..reference_settings() }, 1e-9, 1e-9);
}

#[test]
fn engineering_settings_balance_energy_to_1e_5() {
    assert_balanced(engineering_settings(), 1e-5, 1e-8);
}

#[test]
fn work_of_a_constant_torque_is_torque_times_angle() {
    for settings in [engineering_settings(), reference_settings()] {
        let mut scene = experiment_95();
        scene.integrator = settings;
        let (_, log) = run_to_end(&scene);
        let mut max_error = 0.0f64;
        for s in &log.samples {
            let work = 0.48 * (s.finger(0).q11_rad - scene.finger().initial.q11_rad);
            max_error = max_error.max((s.energy().motor_work_j - work).abs());
        }
        println!("{:?}: error of the work {max_error:e} J", settings.method);
        assert!(max_error < 1e-13, "{max_error:e}");
    }
}

/// Recomputes kinetic, gravitational and spring energy from the logged angles and rates.
#[test]
fn logged_energies_match_the_logged_state() {
    let mut scene = experiment_95();
    scene.integrator = reference_settings();
    let (_, log) = run_to_end(&scene);
    let (l, b) = (scene.finger().linkage.lengths, scene.finger().linkage.bodies);
    let y_offset = |[x, y]: [f64; 2], angle: f64| x * angle.sin() + y * angle.cos();
    let mut gravity_differences = Vec::new();
    for s in &log.samples {
        let theta3 = s.finger(0).q11_rad + s.finger(0).q12_rad;
        let theta4 = s.finger(0).q13_rad;
        let y_coordinates = [
            (b.l11, y_offset(b.l11.com_m, s.finger(0).q11_rad)),
            (b.l21, y_offset(b.l21.com_m, s.finger(0).q21_rad)),
            (b.l12, l.l11_m * s.finger(0).q11_rad.sin() + y_offset(b.l12.com_m, theta3)),
            (b.l22, l.l21_m * s.finger(0).q21_rad.sin() + y_offset(b.l22.com_m, theta4)),
        ];
        // Gravity acts along +y.
        let gravity: f64 = y_coordinates.iter().map(|(body, y)| -9.81 * body.mass_kg * y).sum();
        gravity_differences.push(gravity - s.energy().gravity_j);
        let velocity = |base: [f64; 2], com: [f64; 2], angle: f64, rate: f64| {
            let (sin, cos) = angle.sin_cos();
            [base[0] - rate * (sin * com[0] + cos * com[1]), base[1] + rate * (cos * com[0] - sin * com[1])]
        };
        let joint = |length: f64, angle: f64, rate: f64| [-length * rate * angle.sin(), length * rate * angle.cos()];
        let (rate3, rate4) =
            (s.finger(0).qd11_rad_s + s.finger(0).qd12_rad_s, s.finger(0).qd21_rad_s + s.finger(0).qd22_rad_s);
        let zero = [0.0; 2];
        let moving_bodies = [
            (b.l11, velocity(zero, b.l11.com_m, s.finger(0).q11_rad, s.finger(0).qd11_rad_s), s.finger(0).qd11_rad_s),
            (b.l21, velocity(zero, b.l21.com_m, s.finger(0).q21_rad, s.finger(0).qd21_rad_s), s.finger(0).qd21_rad_s),
            (
                b.l12,
                velocity(joint(l.l11_m, s.finger(0).q11_rad, s.finger(0).qd11_rad_s), b.l12.com_m, theta3, rate3),
                rate3,
            ),
            (
                b.l22,
                velocity(joint(l.l21_m, s.finger(0).q21_rad, s.finger(0).qd21_rad_s), b.l22.com_m, theta4, rate4),
                rate4,
            ),
        ];
        let kinetic: f64 = moving_bodies
            .iter()
            .map(|(body, v, w)| 0.5 * (body.mass_kg * (v[0] * v[0] + v[1] * v[1]) + body.inertia_kg_m2 * w * w))
            .sum();
        assert!((kinetic - s.energy().kinetic_j).abs() < 1e-13 * (1.0 + kinetic), "{kinetic} {}", s.energy().kinetic_j);
        // Constant spring torque on q22, with zero energy at the straight configuration.
        let spring = 0.1326 * (s.finger(0).q22_rad + l.phi22_rad);
        assert!((spring - s.energy().spring_j).abs() < 1e-14, "{spring} {}", s.energy().spring_j);
    }
    let spread = gravity_differences.iter().map(|e| (e - gravity_differences[0]).abs()).fold(0.0, f64::max);
    assert!(spread < 1e-16, "{spread:e}");
}
