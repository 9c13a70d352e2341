//! Torque profiles with jumps: a step of the integrator ends at every jump and does not evaluate the torque after it.

use crate::support::runs::{CollectSink, engineering_settings, experiment_95, reference_settings, run_to_end};
use phalanx::scene::{Actuation, Integrator, Interpolation};

fn run(profile: &Actuation, settings: Integrator) -> (phalanx::trace::Outcome, CollectSink) {
    let mut scene = experiment_95();
    scene.finger_mut().motor.actuation = profile.clone();
    scene.integrator = settings;
    scene.duration_s = 4e-3;
    run_to_end(&scene)
}

/// With up to three jumps before the first contact, engineering settings agree with the reference to 1e-9 rad.
#[test]
fn torque_jumps_do_not_reduce_accuracy() {
    let step_profile = |points| Actuation::Table { points, interpolation: Interpolation::Step };
    let profiles = [
        Actuation::Reversal { torque_n_m: 0.48, at_s: 3e-3 },
        step_profile(vec![(0.0, 0.48), (1.1e-3, 0.1), (2e-3, 0.3), (3e-3, 0.5)]),
    ];
    for profile in &profiles {
        let (engineering, _) = run(profile, engineering_settings());
        let (reference, _) = run(profile, reference_settings());
        let errors = [
            engineering.last.finger(0).q11_rad - reference.last.finger(0).q11_rad,
            engineering.last.finger(0).q21_rad - reference.last.finger(0).q21_rad,
        ];
        println!("{profile:?}: errors {errors:?} rad, {} and {} steps", engineering.work.steps, reference.work.steps);
        assert!(errors.iter().all(|o| o.abs() < 1e-9), "{profile:?}: {errors:?}");
    }
}

#[test]
fn work_of_a_stepped_torque_is_the_sum_of_torque_times_angle() {
    let points = vec![(0.0, 0.48), (1.1e-3, 0.1), (2e-3, 0.3), (3e-3, 0.5)];
    let profile = Actuation::Table { points: points.clone(), interpolation: Interpolation::Step };
    for settings in [engineering_settings(), reference_settings()] {
        let (outcome, log) = run(&profile, settings);
        // Angles at the jumps; each jump coincides with a sample.
        let ends = points.iter().skip(1).map(|p| p.0).chain([4e-3]);
        let angles: Vec<f64> =
            points.iter().map(|p| p.0).chain([4e-3]).map(|t| log.nearest_sample(t).finger(0).q11_rad).collect();
        assert!(ends.into_iter().all(|t| (log.nearest_sample(t).time_s - t).abs() < 1e-15));
        let work: f64 = points.iter().zip(angles.windows(2)).map(|(p, a)| p.1 * (a[1] - a[0])).sum();
        let logged_work = outcome.last.energy().motor_work_j;
        println!("{:?}: error of the work {:e} J", settings.method, logged_work - work);
        assert!((logged_work - work).abs() < 1e-12, "{logged_work} {work}");
    }
}
