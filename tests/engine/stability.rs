//! The engine with the thesis parameters at every fixed step: finite, no rebound the laws do not have, no energy from nowhere.

use crate::support::runs::{Collect, anchor, engine};
use phalanx::scene::{Construction, Scene, Stepping};
use phalanx::trace::{Sample, Site};

fn mechanical(sample: &Sample) -> f64 {
    let e = &sample.energy;
    e.kinetic_j + e.gravity_j + e.spring_j + e.elastic_j
}

/// Largest rise of mechanical energy less motor work above any earlier value of it, in J.
fn created(run: &Collect) -> f64 {
    let mut lowest = f64::INFINITY;
    let mut most: f64 = 0.0;
    for sample in &run.samples {
        let own = mechanical(sample) - sample.energy.motor_work_j;
        lowest = lowest.min(own);
        most = most.max(own - lowest);
    }
    most
}

/// Largest gap of a phalanx after its first touch: a rebound, where the law of the anchor allows none.
fn rebound(run: &Collect, site: Site) -> f64 {
    let touch = run.first_touch(site as usize).expect("a touch-down");
    let gap = |sample: &Sample| match site {
        Site::Proximal => sample.contact(Site::Proximal).gap_m,
        _ => sample.contact(Site::Distal).gap_m,
    };
    run.samples.iter().filter(|sample| sample.time_s > touch).map(gap).fold(0.0, f64::max)
}

fn finite(sample: &Sample) -> bool {
    let contacts = [sample.contact(Site::Proximal), sample.contact(Site::Distal)];
    mechanical(sample).is_finite()
        && [
            sample.finger().q11_rad,
            sample.finger().q21_rad,
            sample.finger().q22_rad,
            sample.finger().qd11_rad_s,
            sample.contact(Site::Limit).normal_n,
        ]
        .iter()
        .chain(contacts.iter().flat_map(|c| [&c.normal_n, &c.tangential_n, &c.gap_m, &c.slip_m_s]))
        .all(|x| x.is_finite())
}

/// Checks one run, whose geometry is frozen over each step: what it may gain or open is of second order in the step.
fn check(scene: &Scene, step_s: f64, created_j: f64, rebound_m: f64) {
    let (outcome, run) = engine(scene);
    assert!(run.samples.iter().all(finite), "a sample at {step_s:e} s is not finite");
    let gained = created(&run);
    assert!(gained <= created_j, "{gained:e} J created at {step_s:e} s");
    for site in [Site::Proximal, Site::Distal] {
        let opened = rebound(&run, site);
        assert!(opened <= rebound_m, "{site:?} opens by {opened:e} m again at {step_s:e} s");
        let friction = |s: &Sample| match site {
            Site::Proximal => (s.contact(Site::Proximal).normal_n, s.contact(Site::Proximal).tangential_n),
            _ => (s.contact(Site::Distal).normal_n, s.contact(Site::Distal).tangential_n),
        };
        for (normal, tangential) in run.samples.iter().map(friction) {
            assert!(normal >= 0.0 && tangential.abs() <= 0.8 * normal * (1.0 + 1e-12));
        }
    }
    assert!(
        outcome.last.finger().qd11_rad_s.abs() < 1e-2 && outcome.last.finger().qd21_rad_s.abs() < 1e-2,
        "still moving at the end"
    );
}

fn at(step_s: f64, construction: Construction) -> Scene {
    let mut scene = anchor();
    scene.engine.stepping = Stepping::Fixed { step_s };
    scene.engine.construction = construction;
    scene
}

#[test]
fn stable_at_1e_4() {
    check(&at(1e-4, Construction::Maximal), 1e-4, 1e-3, 2e-5);
}

#[test]
fn stable_at_1e_5() {
    check(&at(1e-5, Construction::Maximal), 1e-5, 1e-5, 2e-7);
}

#[test]
fn stable_at_1e_6() {
    check(&at(1e-6, Construction::Maximal), 1e-6, 1e-7, 0.0);
}

/// Ten milliseconds hold both impacts; 100,000 steps.
#[test]
fn stable_at_1e_7() {
    let scene = Scene { duration_s: 10e-3, ..at(1e-7, Construction::Maximal) };
    check(&scene, 1e-7, 1e-8, 0.0);
}

#[test]
fn adaptive_steps_create_nothing_and_do_not_rebound() {
    check(&anchor(), 0.0, 1e-7, 0.0);
}
