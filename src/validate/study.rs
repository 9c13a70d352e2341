//! The whole validation of a scene: references, the scene's own engine run, the ladder.

use super::{
    Comparison, Cost, Differences, MEMBERS, Recording, Rung, Verdict, compare, cost, ladder, member, own, record,
    reference, sampled, verdicts,
};
use crate::invariants::{Finding, Invariants};
use crate::scene::{Bounds, Scene};
use crate::trace::{Model, RunError, Sink, run};

/// A setting and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub rung: Rung,
    pub tried: Tried,
}

/// What came of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Tried {
    /// Worst differences of its ensemble; `None` for the reference itself.
    Done {
        differences: Option<Box<Differences>>,
        cost: Cost,
    },
    Failed {
        reason: String,
    },
    /// Left out, for it would have taken so many steps.
    TooLong {
        steps: f64,
    },
}

/// Everything that is known after a validation.
#[derive(Clone, Debug, PartialEq)]
pub struct Validation {
    pub bounds: Bounds,
    /// The analytic model at its reference preset, on a dense grid, and the engine as the scene says, both with the
    /// scene's own torque.
    pub reference: Recording,
    pub engine: Recording,
    /// Of the engine as the scene says: worst of the ensemble.
    pub differences: Differences,
    /// How near the two runs above came to breaking an invariant.
    pub reference_invariants: [Finding; 8],
    pub engine_invariants: [Finding; 8],
    pub rows: Vec<Row>,
    pub verdict: Verdict,
}

/// Why a scene could not be validated: one of the two runs that must complete did not.
#[derive(Debug, thiserror::Error)]
#[error("the {} model of this scene has nothing to compare: {error}", model.name())]
pub struct StudyError {
    pub model: Model,
    #[source]
    pub error: RunError,
}

/// How far a validation has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress<'a> {
    pub done: usize,
    pub total: usize,
    /// What comes next.
    pub next: &'a str,
}

/// Validates a scene; `quick` leaves out the settings that take long.
///
/// # Errors A reference, or the engine at the scene's own settings, could not be completed. Other settings may fail:
/// their row says so.
pub fn validate(scene: &Scene, quick: bool, tell: &mut dyn FnMut(Progress)) -> Result<Validation, StudyError> {
    let rungs = ladder(scene, quick);
    let total = rungs.len() + 1;
    tell(Progress { done: 0, total, next: "references" });
    let broken = |model: Model| move |error: RunError| StudyError { model, error };
    let scenes: Vec<Scene> = (0..MEMBERS).map(|index| member(scene, index)).collect();
    let references: Vec<Recording> = scenes
        .iter()
        .map(|scene| record(Model::Analytic, &reference(scene)))
        .collect::<Result<_, _>>()
        .map_err(broken(Model::Analytic))?;
    let engine = record(Model::Engine, &sampled(Model::Engine, scene)).map_err(broken(Model::Engine))?;
    let own = own(scene);
    let rest = against(&own, &scenes[1..], &references[1..]).map_err(broken(Model::Engine))?;
    let first = compare(&engine, &references[0], &scene.bounds);
    let differences = rest.map_or(first, |rest| first.worst(&rest));

    let mut rows = Vec::with_capacity(rungs.len());
    for (index, rung) in rungs.into_iter().enumerate() {
        tell(Progress { done: index + 1, total, next: rung.family.name() });
        let tried = match rung.own {
            true => {
                let cost = cost(Model::Engine, scene, quick).map_err(broken(Model::Engine))?;
                Tried::Done { differences: Some(Box::new(differences)), cost }
            }
            false => attempt(&rung, &scenes, &references, engine.outcome.work.steps, quick),
        };
        rows.push(Row { rung, tried });
    }
    let reference_invariants = held(Model::Analytic, &reference(scene), &references[0]);
    let engine_invariants = held(Model::Engine, scene, &engine);
    Ok(Validation {
        bounds: scene.bounds,
        verdict: verdicts(&differences, &scene.bounds)
            .and_invariants("analytic_invariants", &reference_invariants)
            .and_invariants("engine_invariants", &engine_invariants),
        reference_invariants,
        engine_invariants,
        reference: references.into_iter().next().unwrap_or_default(),
        engine,
        differences,
        rows,
    })
}

/// How near a kept run came to breaking an invariant.
fn held(model: Model, scene: &Scene, run: &Recording) -> [Finding; 8] {
    let mut invariants = Invariants::new(model, scene);
    for sample in &run.samples {
        invariants.sample(sample).expect("measuring writes nothing");
    }
    invariants.findings(&run.outcome)
}

/// Compares and times one setting.
fn attempt(rung: &Rung, scenes: &[Scene], references: &[Recording], own_steps: u64, quick: bool) -> Tried {
    if let Some(steps) = rung.predicted_steps(&scenes[0], own_steps).filter(|&steps| steps > super::LONGEST_STEPS) {
        return Tried::TooLong { steps };
    }
    let members = if rung.is_reference() { 0 } else { rung.members };
    let compared = against(rung, &scenes[..members], &references[..members]);
    let timed = compared.and_then(|found| Ok((found, cost(rung.model(), &rung.apply(&scenes[0]), quick)?)));
    match timed {
        Ok((differences, cost)) => Tried::Done { differences: differences.map(Box::new), cost },
        Err(error) => Tried::Failed { reason: error.to_string() },
    }
}

/// Worst differences of a setting over some members; `None` without members.
fn against(rung: &Rung, scenes: &[Scene], references: &[Recording]) -> Result<Option<Differences>, RunError> {
    let mut worst: Option<Differences> = None;
    for (scene, reference) in scenes.iter().zip(references) {
        let mut comparison = Comparison::new(reference, &scene.bounds);
        let outcome = run(rung.model(), &sampled(rung.model(), &rung.apply(scene)), &mut comparison)?;
        let found = comparison.finish(&outcome);
        worst = Some(worst.map_or(found, |worst| worst.worst(&found)));
    }
    Ok(worst)
}
