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
        self.last = *sample;
        Ok(())
    }

    /// Comes after the sample of its instant.
    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        assert_eq!(event.time_s, self.last.time_s, "an event without a sample");
        match event.site {
            Site::Proximal => self.take(event, &self.last.proximal.clone()),
            Site::Distal => self.take(event, &self.last.distal.clone()),
            Site::Limit => {}
        }
        Ok(())
    }
}

fn landings(scene: &Scene, rtol: f64) -> Landings {
    let integrator: Integrator = scene.integrator.with_rtol(rtol);
    let scene = Scene { integrator, ..scene.clone() };
    let mut found = Landings { transition_m: scene.contact.proximal.normal.transition_m, ..Landings::default() };
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
