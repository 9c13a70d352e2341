//! How exactly the finger's events are landed on, read off what a run says at the instant of each.

use std::path::Path;

use phalanx::gripper::Site;
use phalanx::scene::{Integrator, Scene, load};
use phalanx::trace::{ContactSample, Event, EventKind, Model, Sample, Sink, SinkError, run};

/// Gap and force of every touch-down and lift-off of a phalanx, in δ_max and N.
#[derive(Default)]
struct Landings {
    last: Sample,
    gaps: Vec<f64>,
    forces: Vec<f64>,
    transition_m: f64,
}

impl Landings {
    fn take(&mut self, event: &Event, contact: &ContactSample) {
        match event.kind {
            EventKind::TouchDown => self.gaps.push(contact.gap_m.abs() / self.transition_m),
            EventKind::LiftOff => self.forces.push(contact.normal_n),
            _ => {}
        }
    }
}

impl Sink for Landings {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last.clone_from(sample);
        Ok(())
    }

    /// Comes after the sample of its instant.
    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        assert_eq!(event.time_s, self.last.time_s, "an event without a sample");
        match event.site() {
            Site::Proximal => self.take(event, &self.last.contact(Site::Proximal).clone()),
            Site::Distal => self.take(event, &self.last.contact(Site::Distal).clone()),
            Site::Limit => {}
        }
        Ok(())
    }
}

fn landings(scene: &Scene, rtol: f64) -> Landings {
    let integrator: Integrator = scene.integrator.with_rtol(rtol);
    let scene = Scene { integrator, ..scene.clone() };
    let mut found =
        Landings { transition_m: scene.finger().contact.proximal.normal.transition_m, ..Landings::default() };
    run(Model::Analytic, &scene, &mut found).expect("a whole run");
    found
}

/// Touch-downs to 1e-5 of δ_max and lift-offs to 1e-6 N, however coarse the steps are that lead there.
#[test]
fn events_are_landed_on_as_exactly_as_is_said() {
    let (mut touches, mut lifts) = (0, 0);
    for name in ["experiment-95", "hard/limit-hammered", "hard/v-static-1e-4", "hard/exponent-1.5", "hard/damper-none"]
    {
        let scene = load(Path::new(&format!("scenes/{name}.toml"))).expect("a scene");
        for rtol in [1e-2, 1e-3, 1e-5] {
            let found = landings(&scene, rtol);
            for gap in &found.gaps {
                assert!(*gap <= 1.01e-5, "{name}, rtol {rtol:e}: touches {gap:e} δ_max from the surface");
            }
            for force in &found.forces {
                assert!(*force <= 1.01e-6, "{name}, rtol {rtol:e}: lets go with {force:e} N");
            }
            (touches, lifts) = (touches + found.gaps.len(), lifts + found.forces.len());
        }
    }
    assert!(touches >= 40 && lifts >= 20, "{touches} touch-downs and {lifts} lift-offs were seen");
}

/// Depths of both phalanges at every step, in δ_max; not a number where nothing presses, as in a contact that has let go.
#[derive(Default)]
struct Depths {
    of_sites: [Vec<f64>; 2],
    transitions_m: [f64; 2],
}

impl Sink for Depths {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        for (site, contact) in [sample.contact(Site::Proximal), sample.contact(Site::Distal)].into_iter().enumerate() {
            let depth = -contact.gap_m / self.transitions_m[site];
            self.of_sites[site].push(if contact.normal_n > 0.0 { depth } else { f64::NAN });
        }
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

/// A damper that engages bends its force at δ_max, a hundredth of it late on the way in and on the way out: a step ends there, to a
/// third of that hundredth, and none goes over it.
#[test]
fn no_step_goes_over_where_a_damper_engages() {
    let mut ends = 0;
    for name in ["hard/missed-reload", "hard/friction-well"] {
        let scene = load(Path::new(&format!("scenes/{name}.toml"))).expect("a scene");
        for rtol in [1e-3, 1e-4, 1e-5] {
            let scene = Scene { integrator: scene.integrator.with_rtol(rtol), ..scene.clone() };
            let transitions_m = [&scene.finger().contact.proximal, &scene.finger().contact.distal]
                .map(|contact| contact.normal.transition_m);
            let mut found = Depths { transitions_m, ..Depths::default() };
            run(Model::Analytic, &scene, &mut found).expect("a whole run");
            for depths in &found.of_sites {
                for pair in depths.windows(2) {
                    let over = pair[0] < 1.006 && pair[1] > 1.014 || pair[0] > 0.994 && pair[1] < 0.986;
                    assert!(!over, "{name}, rtol {rtol:e}: a step from {} to {} δ_max", pair[0], pair[1]);
                }
                let lands = |depth: f64| (depth - 1.01).abs() < 3.1e-3 || (depth - 0.99).abs() < 3.1e-3;
                ends += depths.iter().filter(|depth| lands(**depth)).count();
            }
        }
    }
    assert!(ends >= 9, "{ends} steps end where a damper engages");
}
