//! The whole validation of a scene: references, the scene's own engine run, the ladder.

use super::ensemble::member;
use super::subject::{reference_bound, with};
use super::{
    Comparison, Cost, Differences, MEMBERS, Recording, Rung, Statistics, Verdict, compare, compared, cost, invariants,
    ladder, own, path_bound, record_while, reference, sampled, statistics, verdicts,
};
use crate::check;
use crate::invariants::Finding;
use crate::scene::Scene;
use crate::scene::words::SceneKind;
use crate::trace::{GoOn, Model, RunError, While, run};

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
    /// Trajectories are compared up to here.
    pub until_s: f64,
    /// What the engine may be off by along the way: rad, of discs m.
    pub path_bound: f64,
    /// The analytic model at its reference preset, on a dense grid, and the engine as the scene says, both of the first
    /// member of the ensemble: the scene itself.
    pub reference: Recording,
    pub engine: Recording,
    /// Of the engine as the scene says: worst of the ensemble.
    pub differences: Differences,
    /// How near the two runs above came to breaking an invariant.
    pub reference_invariants: Vec<Finding>,
    pub engine_invariants: Vec<Finding>,
    /// Where the scene compares trajectories only up to some time: means over many runs beyond it.
    pub statistics: Option<Statistics>,
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
/// their row says so. When `go_on` says no, the run at hand ends as stopped, and the validation with it.
pub fn validate(
    whole: &Scene,
    quick: bool,
    tell: &mut dyn FnMut(Progress),
    go_on: GoOn,
) -> Result<Validation, StudyError> {
    let scene = &compared(whole);
    let (until_s, path_bound) = (whole.bounds.until_s, path_bound(whole));
    let rungs = ladder(scene, quick);
    let total = rungs.len() + 1;
    tell(Progress { done: 0, total, next: "references" });
    let broken = |model: Model| move |error: RunError| StudyError { model, error };
    let scenes: Vec<Scene> = (0..MEMBERS).map(|index| member(scene, index)).collect();
    let references: Vec<Recording> = scenes
        .iter()
        .map(|scene| record_while(Model::Analytic, &reference(scene), go_on))
        .collect::<Result<_, _>>()
        .map_err(broken(Model::Analytic))?;
    let engine = record_while(Model::Engine, &sampled(Model::Engine, scene), go_on).map_err(broken(Model::Engine))?;
    let own = own(scene);
    let rest = against(&own, &scenes[1..], &references[1..], go_on).map_err(broken(Model::Engine))?;
    let first = compare(&engine, &references[0], until_s);
    let differences = match rest {
        Some(rest) => first.worst(&rest),
        None => first,
    };

    let own_steps = engine.outcome.work.steps;
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
    let statistics = sensitive(scene, go_on).map_err(broken(Model::Engine))?;
    let checked = check_reference(scene, until_s, go_on);
    let reference_invariants = invariants(&reference(scene), Model::Analytic, &references[0]);
    let engine_invariants = invariants(scene, Model::Engine, &engine);
    Ok(Validation {
        until_s,
        path_bound,
        verdict: verdicts(&differences, &scene.bounds)
            .and_reference(&checked, reference_bound(whole))
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

/// Means over many runs beyond the time up to which trajectories are compared, if there is such a time.
fn sensitive(scene: &Scene, go_on: GoOn) -> Result<Option<Statistics>, RunError> {
    let is_cut = scene.kind() == SceneKind::Finger && scene.bounds.until_s < scene.duration_s;
    is_cut.then(|| statistics(scene, go_on)).transpose()
}

/// What a check of the reference says, as far as trajectories are compared.
fn check_reference(scene: &Scene, until_s: f64, go_on: GoOn) -> check::Check {
    let compared = with(scene, |scene| scene.duration_s = until_s.min(scene.duration_s));
    check::check(Model::Analytic, &reference(&compared), go_on)
}

/// Compares and times one setting.
fn attempt(
    rung: &Rung,
    scenes: &[Scene],
    references: &[Recording],
    own_steps: u64,
    quick: bool,
    go_on: GoOn,
) -> Result<Tried, StudyError> {
    let predicted = rung.predicted_steps(&scenes[0], own_steps);
    if let Some(steps) = predicted.filter(|&steps| steps > super::LONGEST_STEPS) {
        return Ok(Tried::TooLong { steps });
    }
    let members = if rung.is_reference() { 0 } else { rung.members };
    let compared = against(rung, &scenes[..members], &references[..members], go_on);
    let timed = compared.and_then(|found| Ok((found, cost(rung.model(), &rung.apply(&scenes[0]), quick, go_on)?)));
    match timed {
        Ok((differences, cost)) => Ok(Tried::Done { differences: differences.map(Box::new), cost }),
        Err(error) if error.is_stop() => Err(StudyError { model: rung.model(), error }),
        Err(error) => Ok(Tried::Failed { reason: error.to_string() }),
    }
}

/// Worst differences of a setting over some members; `None` without members.
fn against(
    rung: &Rung,
    scenes: &[Scene],
    references: &[Recording],
    go_on: GoOn,
) -> Result<Option<Differences>, RunError> {
    let mut worst: Option<Differences> = None;
    for (scene, reference) in scenes.iter().zip(references) {
        let mut comparison = Comparison::new(reference, scene.bounds.until_s);
        let sampled = sampled(rung.model(), &rung.apply(scene));
        let outcome = run(rung.model(), &sampled, &mut While { sink: &mut comparison, go_on })?;
        let found = comparison.finish(&outcome);
        worst = Some(match worst {
            Some(worst) => worst.worst(&found),
            None => found,
        });
    }
    Ok(worst)
}
