//! The whole validation of a scene: references, the scene's own engine run, the ladder.

use super::{Cost, GoOn, MEMBERS, Rung, Statistics, Subject, Verdict, cost, ladder, own, reference, sampled};
use crate::invariants::Finding;
use crate::scene::Scene;
use crate::trace::{Model, RunError};

/// A setting and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row<D = super::Differences> {
    pub rung: Rung,
    pub tried: Tried<D>,
}

/// What came of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Tried<D = super::Differences> {
    /// Worst differences of its ensemble; `None` for the reference itself.
    Done {
        differences: Option<Box<D>>,
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
pub struct Validation<S: Subject = Scene> {
    pub bounds: S::Bounds,
    /// The analytic model at its reference preset, on a dense grid, and the engine as the scene says, both of the first
    /// member of the ensemble: the scene itself.
    pub reference: S::Recording,
    pub engine: S::Recording,
    /// Of the engine as the scene says: worst of the ensemble.
    pub differences: S::Differences,
    /// How near the two runs above came to breaking an invariant.
    pub reference_invariants: Vec<Finding>,
    pub engine_invariants: Vec<Finding>,
    /// Where the scene compares trajectories only up to some time: means over many runs beyond it.
    pub statistics: Option<Statistics>,
    pub rows: Vec<Row<S::Differences>>,
    pub verdict: Verdict,
}

/// Why a scene could not be validated: one of the two runs that must complete did not.
#[derive(Debug, thiserror::Error)]
#[error("the {} model of this scene has nothing to compare: {error}", model.name())]
pub struct StudyError<E: std::error::Error + 'static = RunError> {
    pub model: Model,
    #[source]
    pub error: E,
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
/// their row says so. When `go_on` says no, the run at hand ends as stopped, and the validation with it.
pub fn validate<S: Subject>(
    scene: &S,
    quick: bool,
    tell: &mut dyn FnMut(Progress),
    go_on: GoOn,
) -> Result<Validation<S>, StudyError<S::Error>> {
    let scene = &scene.compared();
    let rungs = ladder(scene, quick);
    let total = rungs.len() + 1;
    tell(Progress { done: 0, total, next: "references" });
    let broken = |model: Model| move |error: S::Error| StudyError { model, error };
    let scenes: Vec<S> = (0..MEMBERS).map(|index| scene.member(index)).collect();
    let references: Vec<S::Recording> = scenes
        .iter()
        .map(|scene| reference(scene).record(Model::Analytic, go_on))
        .collect::<Result<_, _>>()
        .map_err(broken(Model::Analytic))?;
    let engine = sampled(Model::Engine, scene).record(Model::Engine, go_on).map_err(broken(Model::Engine))?;
    let own = own(scene);
    let rest = against(&own, &scenes[1..], &references[1..], go_on).map_err(broken(Model::Engine))?;
    let first = scene.compare(&engine, &references[0]);
    let differences = match rest {
        Some(rest) => S::worse(&first, &rest),
        None => first,
    };

    let own_steps = S::recorded_steps(&engine);
    let mut rows = Vec::with_capacity(rungs.len());
    for (index, rung) in rungs.into_iter().enumerate() {
        tell(Progress { done: index + 1, total, next: rung.family.name() });
        let tried = match rung.own {
            true => {
                let cost = cost(Model::Engine, scene, quick, go_on).map_err(broken(Model::Engine))?;
                Tried::Done { differences: Some(Box::new(differences.clone())), cost }
            }
            false => attempt(&rung, &scenes, &references, own_steps, quick, go_on)?,
        };
        rows.push(Row { rung, tried });
    }
    let statistics = scene.statistics(go_on).map_err(broken(Model::Engine))?;
    let checked = scene.check_reference(go_on);
    let reference_invariants = reference(scene).invariants(Model::Analytic, &references[0]);
    let engine_invariants = scene.invariants(Model::Engine, &engine);
    Ok(Validation {
        bounds: scene.bounds(),
        verdict: scene
            .judge(&differences)
            .and_reference(&checked, scene.path_bound())
            .and_invariants("analytic_invariants", &reference_invariants)
            .and_invariants("engine_invariants", &engine_invariants)
            .and_statistics(statistics.as_ref()),
        statistics,
        reference_invariants,
        engine_invariants,
        reference: references.into_iter().next().unwrap_or_default(),
        engine,
        differences,
        rows,
    })
}

/// Compares and times one setting.
fn attempt<S: Subject>(
    rung: &Rung,
    scenes: &[S],
    references: &[S::Recording],
    own_steps: u64,
    quick: bool,
    go_on: GoOn,
) -> Result<Tried<S::Differences>, StudyError<S::Error>> {
    if let Some(steps) = rung.predicted_steps(&scenes[0], own_steps).filter(|&steps| steps > super::LONGEST_STEPS) {
        return Ok(Tried::TooLong { steps });
    }
    let members = if rung.is_reference() { 0 } else { rung.members };
    let compared = against(rung, &scenes[..members], &references[..members], go_on);
    let timed = compared.and_then(|found| Ok((found, cost(rung.model(), &rung.apply(&scenes[0]), quick, go_on)?)));
    match timed {
        Ok((differences, cost)) => Ok(Tried::Done { differences: differences.map(Box::new), cost }),
        Err(error) if S::is_stop(&error) => Err(StudyError { model: rung.model(), error }),
        Err(error) => Ok(Tried::Failed { reason: error.to_string() }),
    }
}

/// Worst differences of a setting over some members; `None` without members.
fn against<S: Subject>(
    rung: &Rung,
    scenes: &[S],
    references: &[S::Recording],
    go_on: GoOn,
) -> Result<Option<S::Differences>, S::Error> {
    let mut worst: Option<S::Differences> = None;
    for (scene, reference) in scenes.iter().zip(references) {
        let found = sampled(rung.model(), &rung.apply(scene)).differences(rung.model(), reference, go_on)?;
        worst = Some(match worst {
            Some(worst) => S::worse(&worst, &found),
            None => found,
        });
    }
    Ok(worst)
}
