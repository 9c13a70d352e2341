//! Accuracy of event location for a finger, measured by the samples at the events.

use std::path::Path;

use phalanx::gripper::FingerContact;
use phalanx::scene::{Integrator, Scene, load};
use phalanx::trace::{ContactSample, Event, EventKind, Model, Sample, Sink, SinkError, run};

/// Gaps at the touch-downs of the phalanges, in δ_max, and forces at their lift-offs, N.
#[derive(Default)]
struct EventResiduals {
    last: Sample,
    gaps: Vec<f64>,
    forces: Vec<f64>,
    transition_m: f64,
}

impl EventResiduals {
    fn record(&mut self, event: &Event, contact: &ContactSample) {
        match event.kind {
            EventKind::TouchDown => self.gaps.push(contact.gap_m.abs() / self.transition_m),
            EventKind::LiftOff => self.forces.push(contact.normal_n),
            _ => {}
        }
    }
}

impl Sink for EventResiduals {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last.clone_from(sample);
        Ok(())
    }

    /// An event follows the sample of the same time.
    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        assert_eq!(event.time_s, self.last.time_s, "an event without a sample");
        match event.finger_contact() {
            FingerContact::Proximal => self.record(event, &self.last.finger_contact(FingerContact::Proximal).clone()),
            FingerContact::Distal => self.record(event, &self.last.finger_contact(FingerContact::Distal).clone()),
            FingerContact::Limit => {}
        }
        Ok(())
    }
}

fn event_residuals(scene: &Scene, rtol: f64) -> EventResiduals {
    let integrator: Integrator = scene.integrator.with_rtol(rtol);
    let scene = Scene { integrator, ..scene.clone() };
    let mut residuals = EventResiduals {
        transition_m: scene.finger().contact.proximal.normal.transition_m,
        ..EventResiduals::default()
    };
    run(Model::Analytic, &scene, &mut residuals).expect("a completed run");
    residuals
}

/// Touch-downs are located to 1e-5 of δ_max and lift-offs to 1e-6 N, at any step size.
#[test]
fn events_are_located_within_their_tolerances() {
    let (mut touchdowns, mut liftoffs) = (0, 0);
    for name in ["experiment-95", "hard/limit-hammered", "hard/v-static-1e-4", "hard/exponent-1.5", "hard/damper-none"]
    {
        let scene = load(Path::new(&format!("scenes/{name}.toml"))).expect("a scene");
        for rtol in [1e-2, 1e-3, 1e-5] {
            let residuals = event_residuals(&scene, rtol);
            for gap in &residuals.gaps {
                assert!(*gap <= 1.01e-5, "{name}, rtol {rtol:e}: touch-down at a gap of {gap:e} δ_max");
            }
            for force in &residuals.forces {
                assert!(*force <= 1.01e-6, "{name}, rtol {rtol:e}: lift-off at {force:e} N");
            }
            (touchdowns, liftoffs) = (touchdowns + residuals.gaps.len(), liftoffs + residuals.forces.len());
        }
    }
    assert!(touchdowns >= 40 && liftoffs >= 20, "only {touchdowns} touch-downs and {liftoffs} lift-offs");
}

/// Penetrations of both phalanges at every step, in δ_max; NaN for contacts without a force.
#[derive(Default)]
struct DepthRecorder {
    depths: [Vec<f64>; 2],
    transitions_m: [f64; 2],
}

impl Sink for DepthRecorder {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        for (index, contact) in
            [sample.finger_contact(FingerContact::Proximal), sample.finger_contact(FingerContact::Distal)]
                .into_iter()
                .enumerate()
        {
            let depth = -contact.gap_m / self.transitions_m[index];
            self.depths[index].push(if contact.normal_n > 0.0 { depth } else { f64::NAN });
        }
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

/// The contact force has a kink where the damping reaches its maximum, at δ_max. The event is at 1.01 δ_max on the way
/// in and at 0.99 δ_max on the way out. A step ends there to within 0.0031 δ_max, and no step crosses it.
#[test]
fn no_step_crosses_the_damper_transition() {
    let mut steps_at_transition = 0;
    for name in ["hard/missed-reload", "hard/friction-well"] {
        let scene = load(Path::new(&format!("scenes/{name}.toml"))).expect("a scene");
        for rtol in [1e-3, 1e-4, 1e-5] {
            let scene = Scene { integrator: scene.integrator.with_rtol(rtol), ..scene.clone() };
            let transitions_m = [&scene.finger().contact.proximal, &scene.finger().contact.distal]
                .map(|contact| contact.normal.transition_m);
            let mut recorder = DepthRecorder { transitions_m, ..DepthRecorder::default() };
            run(Model::Analytic, &scene, &mut recorder).expect("a completed run");
            for depths in &recorder.depths {
                for pair in depths.windows(2) {
                    let crosses_transition = pair[0] < 1.006 && pair[1] > 1.014 || pair[0] > 0.994 && pair[1] < 0.986;
                    assert!(!crosses_transition, "{name}, rtol {rtol:e}: a step from {} to {} δ_max", pair[0], pair[1]);
                }
                let is_at_transition = |depth: f64| (depth - 1.01).abs() < 3.1e-3 || (depth - 0.99).abs() < 3.1e-3;
                steps_at_transition += depths.iter().filter(|depth| is_at_transition(**depth)).count();
            }
        }
    }
    assert!(steps_at_transition >= 9, "only {steps_at_transition} steps end at the transition");
}
