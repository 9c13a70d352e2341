//! The engine with the thesis parameters at several fixed steps: finite samples, no artificial rebound, no created
//! energy.

use crate::support::runs::{CollectSink, experiment_95, run_engine};
use phalanx::scene::{Construction, Scene, Stepping};
use phalanx::trace::{FingerContact, Sample};

fn mechanical_energy_j(sample: &Sample) -> f64 {
    let e = &sample.energy();
    e.kinetic_j + e.gravity_j + e.spring_j + e.elastic_j
}

/// Largest rise of mechanical energy minus motor work above its earlier minimum, J.
fn energy_created_j(run: &CollectSink) -> f64 {
    let mut lowest = f64::INFINITY;
    let mut largest_rise: f64 = 0.0;
    for sample in &run.samples {
        let excess = mechanical_energy_j(sample) - sample.energy().motor_work_j;
        lowest = lowest.min(excess);
        largest_rise = largest_rise.max(excess - lowest);
    }
    largest_rise
}

/// Largest gap of a phalanx after its first contact, m. The contact law of experiment 95 allows no rebound.
fn rebound_gap_m(run: &CollectSink, contact: FingerContact) -> f64 {
    let contact_s = run.first_contact_s(contact as usize).expect("a touch-down");
    let gap = |sample: &Sample| match contact {
        FingerContact::Proximal => sample.finger_contact(FingerContact::Proximal).gap_m,
        _ => sample.finger_contact(FingerContact::Distal).gap_m,
    };
    run.samples.iter().filter(|sample| sample.time_s > contact_s).map(gap).fold(0.0, f64::max)
}

fn is_finite_sample(sample: &Sample) -> bool {
    let contacts = [sample.finger_contact(FingerContact::Proximal), sample.finger_contact(FingerContact::Distal)];
    mechanical_energy_j(sample).is_finite()
        && [
            sample.finger(0).q11_rad,
            sample.finger(0).q21_rad,
            sample.finger(0).q22_rad,
            sample.finger(0).qd11_rad_s,
            sample.finger_contact(FingerContact::Limit).normal_n,
        ]
        .iter()
        .chain(contacts.iter().flat_map(|c| [&c.normal_n, &c.tangential_n, &c.gap_m, &c.slip_m_s]))
        .all(|x| x.is_finite())
}

/// Asserts that a run is stable. The geometry is constant over a step, so the tolerances are of second order in the
/// step.
fn assert_stable(scene: &Scene, step_s: f64, energy_tolerance_j: f64, rebound_tolerance_m: f64) {
    let (outcome, run) = run_engine(scene);
    assert!(run.samples.iter().all(is_finite_sample), "non-finite sample at steps of {step_s:e} s");
    let created_j = energy_created_j(&run);
    assert!(created_j <= energy_tolerance_j, "{created_j:e} J created at steps of {step_s:e} s");
    for contact in [FingerContact::Proximal, FingerContact::Distal] {
        let gap_m = rebound_gap_m(&run, contact);
        assert!(gap_m <= rebound_tolerance_m, "{contact:?} reopens by {gap_m:e} m at steps of {step_s:e} s");
        let friction = |s: &Sample| match contact {
            FingerContact::Proximal => (
                s.finger_contact(FingerContact::Proximal).normal_n,
                s.finger_contact(FingerContact::Proximal).tangential_n,
            ),
            _ => {
                (s.finger_contact(FingerContact::Distal).normal_n, s.finger_contact(FingerContact::Distal).tangential_n)
            }
        };
        for (normal, tangential) in run.samples.iter().map(friction) {
            assert!(normal >= 0.0 && tangential.abs() <= 0.8 * normal * (1.0 + 1e-12));
        }
    }
    assert!(
        outcome.last.finger(0).qd11_rad_s.abs() < 1e-2 && outcome.last.finger(0).qd21_rad_s.abs() < 1e-2,
        "still moving at the end"
    );
}

fn scene_with_fixed_step(step_s: f64, construction: Construction) -> Scene {
    let mut scene = experiment_95();
    scene.engine.stepping = Stepping::Fixed { step_s };
    scene.engine.construction = construction;
    scene
}

#[test]
fn stable_at_1e_4() {
    assert_stable(&scene_with_fixed_step(1e-4, Construction::Maximal), 1e-4, 1e-3, 2e-5);
}

#[test]
fn stable_at_1e_5() {
    assert_stable(&scene_with_fixed_step(1e-5, Construction::Maximal), 1e-5, 1e-5, 2e-7);
}

#[test]
fn stable_at_1e_6() {
    assert_stable(&scene_with_fixed_step(1e-6, Construction::Maximal), 1e-6, 1e-7, 0.0);
}

/// A run of 10 ms, 100,000 steps, includes both impacts.
#[test]
fn stable_at_1e_7() {
    let scene = Scene { duration_s: 10e-3, ..scene_with_fixed_step(1e-7, Construction::Maximal) };
    assert_stable(&scene, 1e-7, 1e-8, 0.0);
}

#[test]
fn adaptive_steps_are_stable() {
    assert_stable(&experiment_95(), 0.0, 1e-7, 0.0);
}
