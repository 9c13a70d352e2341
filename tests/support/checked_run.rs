//! Runs of either model that check the invariants at every sample. A test fails with the list of violated invariants.

use phalanx::integrator::{Failure, Reason};
use phalanx::invariants::{Finding, Invariant, Invariants, Tolerances};
use phalanx::scene::{Engine, Scene, Stepping};
use phalanx::trace::{self, Event, Model, Outcome, RunError, Sample, Sink, SinkError};
use phalanx::validate::{Recording, record, scene_sampled_at_steps};

/// Allowed relative energy error of a run that ends in a folded configuration. With the sine s of the angle between the
/// links, which falls to 1e-3, an angle error of 1e-10 rad changes s by 1e-10/s and the energy by a fraction of
/// 1e-10/s².
const FOLDED_ENERGY_FRACTION: f64 = 1e-2;

/// Passes all samples and events on to `sink`, and measures the invariants at every sample.
struct InvariantSink<'a, S> {
    invariants: Invariants,
    sink: &'a mut S,
}

impl<S: Sink> Sink for InvariantSink<'_, S> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        Sink::sample(&mut self.invariants, sample)?;
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.sink.event(event)
    }

    fn should_continue(&self) -> bool {
        self.sink.should_continue()
    }
}

/// Runs a scene to its end or its failure; also returns the violated invariants. If the engine violates some, only the
/// samples at its steps decide: between steps it interpolates forces and slips independently, so they may be
/// inconsistent there; they must still be finite.
pub fn run_and_check(model: Model, scene: &Scene, sink: &mut impl Sink) -> (Result<Outcome, RunError>, Vec<Finding>) {
    let (result, violations) = run_with_invariants(model, scene, sink);
    let is_finite = violations.iter().all(|finding| finding.invariant != Invariant::Finite);
    if model == Model::Engine && !violations.is_empty() && is_finite {
        return (result, run_with_invariants(model, &scene_sampled_at_steps(scene), &mut ()).1);
    }
    (result, violations)
}

/// Runs a scene to its end or its failure; panics if an invariant is violated.
#[track_caller]
pub fn run(model: Model, scene: &Scene, sink: &mut impl Sink) -> Result<Outcome, RunError> {
    let (result, violations) = run_and_check(model, scene, sink);
    assert!(violations.is_empty(), "{}, {} model: {}", scene.name, model.name(), format_findings(&violations));
    result
}

/// Formats the findings, one per line.
pub fn format_findings(findings: &[Finding]) -> String {
    findings.iter().map(Finding::to_string).collect::<Vec<_>>().join("\n")
}

fn run_with_invariants(model: Model, scene: &Scene, sink: &mut impl Sink) -> (Result<Outcome, RunError>, Vec<Finding>) {
    let mut checked_sink = InvariantSink { invariants: Invariants::new(model, scene), sink };
    let result = trace::run(model, scene, &mut checked_sink);
    let loop_gap_m = match &result {
        Ok(outcome) => outcome.loop_gap_m,
        Err(RunError::Simulation { partial_outcome, .. }) => partial_outcome.loop_gap_m,
        Err(RunError::Sink(error)) => panic!("{error}"),
    };
    let mut violations = checked_sink.invariants.findings(loop_gap_m);
    violations.retain(Finding::is_violated);
    if scene.finger_count() != 1 {
        return (result, violations);
    }
    violations.retain(|finding| finding.invariant != Invariant::LoopGap || is_at_most_default_tolerance(&scene.engine));
    if let Err(RunError::Simulation { failure: Failure { reason: Reason::Obstacle(_), .. }, .. }) = &result {
        let energy = Tolerances::for_settings(model, &scene.integrator, &scene.engine, loop_gap_m).energy;
        let factor = FOLDED_ENERGY_FRACTION.max(energy) / energy;
        let is_energy = |finding: &Finding| matches!(finding.invariant, Invariant::Energy | Invariant::Passivity);
        violations.retain(|finding| !is_energy(finding) || finding.measured > factor * finding.allowed);
    }
    (result, violations)
}

/// Whether the tolerance is the default or finer. The scene's bound on the loop gap applies only to these settings.
fn is_at_most_default_tolerance(engine: &Engine) -> bool {
    let defaults = Engine { iterations: engine.iterations, max_steps: engine.max_steps, ..Engine::DEFAULT };
    match (engine.stepping, defaults.stepping) {
        (Stepping::Adaptive { tolerance_m, .. }, Stepping::Adaptive { tolerance_m: default_tolerance_m, .. }) => {
            tolerance_m <= default_tolerance_m && Engine { stepping: defaults.stepping, ..*engine } == defaults
        }
        _ => false,
    }
}

/// Records a run of either model, which must reach its end.
#[track_caller]
pub fn record_run(model: Model, scene: &Scene) -> Recording {
    record(model, scene).unwrap_or_else(|error| panic!("{}: {} model: {error}", scene.name, model.name()))
}

#[track_caller]
pub fn assert_no_violations(findings: &[Finding], context: &str) {
    let violations: Vec<Finding> = findings.iter().filter(|finding| finding.is_violated()).cloned().collect();
    assert!(violations.is_empty(), "{context}: {}", format_findings(&violations));
}
