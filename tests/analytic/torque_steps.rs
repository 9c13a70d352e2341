//! Torque profiles with jumps: a step of the integrator ends on every jump and sees nothing of what follows it.

use crate::support::runs::{Collect, anchor, complete, engineering, reference};
use phalanx::scene::{Actuation, Integrator, Interpolation};

fn run(profile: &Actuation, settings: Integrator) -> (phalanx::trace::Outcome, Collect) {
    let mut scene = anchor();
    scene.finger_mut().motor.actuation = profile.clone();
    scene.integrator = settings;
    scene.duration_s = 4e-3;
    complete(&scene)
}

/// With up to three jumps before the first contact, everyday settings stay within their tolerance of the reference: 1e-9 rad.
#[test]
fn jumps_cost_no_accuracy() {
    let step = |points| Actuation::Table { points, interpolation: Interpolation::Step };
    let profiles = [
        Actuation::Reversal { torque_n_m: 0.48, at_s: 3e-3 },
        step(vec![(0.0, 0.48), (1.1e-3, 0.1), (2e-3, 0.3), (3e-3, 0.5)]),
    ];
    for profile in &profiles {
        let (everyday, _) = run(profile, engineering());
        let (exact, _) = run(profile, reference());
        let off = [
            everyday.last.finger().q11_rad - exact.last.finger().q11_rad,
            everyday.last.finger().q21_rad - exact.last.finger().q21_rad,
        ];
        println!("{profile:?}: off by {off:?} rad, {} and {} steps", everyday.work.steps, exact.work.steps);
        assert!(off.iter().all(|o| o.abs() < 1e-9), "{profile:?}: {off:?}");
    }
}

/// Work of a stepped torque: the torque of each stretch times its angle.
#[test]
fn work_of_a_stepped_torque_is_a_sum_of_products() {
    let points = vec![(0.0, 0.48), (1.1e-3, 0.1), (2e-3, 0.3), (3e-3, 0.5)];
    let profile = Actuation::Table { points: points.clone(), interpolation: Interpolation::Step };
    for settings in [engineering(), reference()] {
        let (outcome, log) = run(&profile, settings);
        // Where the angle stood at every jump. The grid of samples hits each of them.
        let ends = points.iter().skip(1).map(|p| p.0).chain([4e-3]);
        let angles: Vec<f64> = points.iter().map(|p| p.0).chain([4e-3]).map(|t| log.at(t).finger().q11_rad).collect();
        assert!(ends.into_iter().all(|t| (log.at(t).time_s - t).abs() < 1e-15));
        let work: f64 = points.iter().zip(angles.windows(2)).map(|(p, a)| p.1 * (a[1] - a[0])).sum();
        let got = outcome.last.energy.motor_work_j;
        println!("{:?}: work off by {:e} J", settings.method, got - work);
        assert!((got - work).abs() < 1e-12, "{got} {work}");
    }
}
