//! Runs of either model, held to the invariants at every step: a test whose run breaks one fails and says which.

use phalanx::integrator::{Failure, Reason};
use phalanx::invariants::{Finding, Invariant, Invariants, Tolerances};
use phalanx::scene::words::SceneKind;
use phalanx::scene::{Engine, Scene, Stepping};
use phalanx::trace::{self, Event, Model, Outcome, RunError, Sample, Sink, SinkError};
use phalanx::validate::{Recording, record, steps_only};

/// Part of the energy of a run that may be missing where it ends in a fold: with the sine s of the angle between the links,
/// which goes down to 1e-3, an angle that is off by 1e-10 rad moves s by 1e-10/s and the energy by a part of 1e-10/s².
const FOLDED_ENERGY: f64 = 1e-2;

/// Shows every sample to the invariants, and everything to another sink.
struct Held<'a, S> {
    invariants: Invariants,
    sink: &'a mut S,
}

impl<S: Sink> Sink for Held<'_, S> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        Sink::sample(&mut self.invariants, sample)?;
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.sink.event(event)
    }

    fn proceed(&self) -> bool {
        self.sink.proceed()
    }
}

/// Runs a scene to its end or its failure, and says which invariants it broke on the way.
pub fn judged(model: Model, scene: &Scene, sink: &mut impl Sink) -> (Result<Outcome, RunError>, Vec<Finding>) {
    let (result, found) = watched(model, scene, sink);
    match between_steps(model, &found) {
        true => (result, watched(model, &steps_only(scene), &mut ()).1),
        false => (result, found),
    }
}

/// Runs a scene to its end or its failure; panics if it broke an invariant on the way.
#[track_caller]
pub fn run(model: Model, scene: &Scene, sink: &mut impl Sink) -> Result<Outcome, RunError> {
    let (result, found) = judged(model, scene, sink);
    assert!(found.is_empty(), "{}, {} model: {}", scene.name, model.name(), lines(&found));
    result
}

/// One line for each.
pub fn lines(found: &[Finding]) -> String {
    found.iter().map(Finding::to_string).collect::<Vec<_>>().join("\n")
}

fn watched(model: Model, scene: &Scene, sink: &mut impl Sink) -> (Result<Outcome, RunError>, Vec<Finding>) {
    let mut held = Held { invariants: Invariants::new(model, scene), sink };
    let result = trace::run(model, scene, &mut held);
    let loop_gap_m = match &result {
        Ok(outcome) => outcome.loop_gap_m,
        Err(RunError::Simulation { so_far, .. }) => so_far.loop_gap_m,
        Err(RunError::Sink(error)) => panic!("{error}"),
    };
    let mut found = held.invariants.findings(loop_gap_m);
    found.retain(Finding::is_broken);
    if scene.kind() != SceneKind::Finger {
        return (result, found);
    }
    found.retain(|one| one.invariant != Invariant::LoopGap || is_fine(&scene.engine));
    if let Err(RunError::Simulation { failure: Failure { reason: Reason::Obstacle(_), .. }, .. }) = &result {
        let energy = Tolerances::of(model, &scene.integrator, &scene.engine, loop_gap_m).energy;
        found.retain(|one| !is_energy(one) || one.measured > FOLDED_ENERGY.max(energy) / energy * one.allowed);
    }
    (result, found)
}

/// Whether the scene's bound on opening joints is meant for these settings: it is one for the default and finer ones.
fn is_fine(engine: &Engine) -> bool {
    let usual = Engine { iterations: engine.iterations, max_steps: engine.max_steps, ..Engine::DEFAULT };
    match (engine.stepping, usual.stepping) {
        (Stepping::Adaptive { tolerance_m, .. }, Stepping::Adaptive { tolerance_m: most_m, .. }) => {
            tolerance_m <= most_m && Engine { stepping: usual.stepping, ..*engine } == usual
        }
        _ => false,
    }
}

fn is_energy(finding: &Finding) -> bool {
    matches!(finding.invariant, Invariant::Energy | Invariant::Passivity)
}

/// Whether the run is to be judged by its steps alone: between two steps the engine's samples are interpolated, forces
/// and slips each by themselves, and need not fit each other. Finite they are all the same.
fn between_steps(model: Model, found: &[Finding]) -> bool {
    model == Model::Engine && !found.is_empty() && found.iter().all(|one| one.invariant != Invariant::Finite)
}

/// A run of either model, recorded; it has to get to its end.
#[track_caller]
pub fn recorded(model: Model, scene: &Scene) -> Recording {
    record(model, scene).unwrap_or_else(|error| panic!("{}: {} model: {error}", scene.name, model.name()))
}

#[track_caller]
pub fn assert_held(found: &[Finding], what: &str) {
    let broken: Vec<String> = found.iter().filter(|found| found.is_broken()).map(Finding::to_string).collect();
    assert!(broken.is_empty(), "{what}: {}", broken.join("; "));
}
