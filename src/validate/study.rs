//! The validation of a scene: the verdict first, then, where it is wanted, the ladder of other settings.

use std::time::Instant;

use super::ensemble::member;
use super::subject::{reference_bound, with};
use super::verdict::REFERENCE_BOUNDS;
use super::{
    Comparison, Cost, Criterion, Differences, LONGEST_STEPS, Recording, Rung, Statistics, Verdict, compare, compared,
    cost, criteria, finer_settings, invariants, ladder, members, own, path_bound, record_while, reference, sampled,
    statistics, verdicts,
};
use crate::check;
use crate::invariants::Finding;
use crate::scene::Scene;
use crate::scene::words::SceneKind;
use crate::trace::{Model, RunError, While, run};

/// Whether the validation is still wanted, asked from several threads.
pub type Wanted<'a> = &'a (dyn Fn() -> bool + Sync);

/// Time that a ladder takes, s, unless another is given: enough for every setting of a finger but the shortest fixed steps.
pub const LADDER_TIME_S: f64 = 10.0;

/// Which settings a ladder takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Climb {
    /// Leaves out settings that take long, whatever the time.
    pub quick: bool,
    /// Settings are begun while the time of all of them is expected to stay below this, s.
    pub time_s: f64,
}

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
    /// Left out, for the ladder's time was over, or would have been.
    NoTime,
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
    /// The other members of the ensemble with their references.
    others: Vec<(Scene, Recording)>,
    /// Of the engine as the scene says: worst of the ensemble.
    pub differences: Differences,
    /// What both runs are judged by.
    pub criteria: Vec<Criterion>,
    /// Why the criteria are not judged; `None` where they are.
    pub unjudged: Option<&'static str>,
    /// How near the two runs above came to breaking an invariant.
    pub reference_invariants: Vec<Finding>,
    pub engine_invariants: Vec<Finding>,
    /// Where the scene compares trajectories only up to some time: means over many runs beyond it.
    pub statistics: Option<Statistics>,
    /// The ladder, as far as it was climbed.
    pub rows: Vec<Row>,
    pub verdict: Verdict,
    /// The check of the reference by another method.
    pub checked: check::Check,
    /// Finer settings of the engine, run because the verdict failed, coarse to fine, and whether each passes. The first that
    /// passes is the last.
    pub finer: Vec<(Rung, bool)>,
}

impl Validation {
    /// Estimated error of the reference, in the unit of a check; `None` where it could not be estimated.
    pub fn reference_error(&self) -> Option<f64> {
        (self.checked.verdict != check::Verdict::Unknown).then_some(self.checked.errors.path)
    }

    /// The model to trust where the models differ by more than a bound: the analytic one, if its own two methods agree and it breaks
    /// no invariant.
    pub fn trusted(&self) -> Option<Model> {
        (!self.verdict.passed() && !self.verdict.fails(&REFERENCE_BOUNDS)).then_some(Model::Analytic)
    }
}

/// Why a scene could not be validated: one of the two runs that must complete did not.
#[derive(Debug, thiserror::Error)]
#[error("the {} model of this scene has nothing to compare: {error}", model.name())]
pub struct StudyError {
    pub model: Model,
    #[source]
    pub error: RunError,
}

/// How far a ladder has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress<'a> {
    pub done: usize,
    pub total: usize,
    /// What comes next.
    pub next: &'a str,
}

/// One member of the ensemble: its scene, its reference, and the engine's run as it is compared, the whole of it for the first.
struct Member {
    scene: Scene,
    reference: Recording,
    engine: Option<Recording>,
    differences: Differences,
}

/// The verdict on a scene: the engine as the scene says against the reference. Members of the ensemble run on threads of their own.
///
/// # Errors A reference, or the engine at the scene's own settings, could not be completed. When `go_on` says no, the runs at hand
/// end as stopped, and the validation with them.
pub fn validate(whole: &Scene, go_on: Wanted) -> Result<Validation, StudyError> {
    let scene = &compared(whole);
    let (until_s, path_bound) = (whole.bounds.until_s, path_bound(whole));
    let (all, checked) = std::thread::scope(|scope| {
        let checked = scope.spawn(|| check_reference(scene, until_s, go_on));
        let runs = (0..members(scene)).map(|index| scope.spawn(move || run_member(scene, index, go_on)));
        let runs: Vec<_> = runs.collect();
        let all: Result<Vec<Member>, StudyError> = runs.into_iter().map(joined).collect();
        (all, joined(checked))
    });
    let all = all?;
    let differences = all[1..].iter().fold(all[0].differences.clone(), |worst, found| worst.worst(&found.differences));
    let mut all = all.into_iter();
    let (reference_run, engine) =
        all.next().map(|first| (first.reference, first.engine.unwrap_or_default())).unwrap_or_default();
    let others: Vec<_> = all.map(|member| (member.scene, member.reference)).collect();

    let broken = |error: RunError| StudyError { model: Model::Engine, error };
    let statistics = sensitive(scene, go_on).map_err(broken)?;
    let reference_invariants = invariants(&reference(scene), Model::Analytic, &reference_run);
    let unjudged = criteria::unjudged(scene, &checked);
    let judged = |engine: &Recording, differences: &Differences| {
        let criteria = criteria::criteria(scene, &reference_run, engine);
        let engine_invariants = invariants(scene, Model::Engine, engine);
        let verdict = verdicts(differences, &scene.bounds)
            .and_criteria(if unjudged.is_none() { criteria::checks(&criteria) } else { Vec::new() })
            .and_reference(&checked, reference_bound(whole))
            .and_invariants("analytic_invariants", &reference_invariants)
            .and_invariants("engine_invariants", &engine_invariants)
            .and_statistics(statistics.as_ref());
        (verdict, criteria, engine_invariants)
    };
    let (verdict, criteria, engine_invariants) = judged(&engine, &differences);
    let mut finer = Vec::new();
    // Statistics take many runs of the engine, so a setting is not tried against them.
    if !verdict.passed() && !verdict.fails(&REFERENCE_BOUNDS) && !verdict.fails(&["statistics"]) {
        for rung in finer_settings(scene, engine.outcome.work.steps) {
            let run = recorded(&rung, scene, &reference_run, go_on)
                .and_then(|(engine, first)| Ok((engine, worst(first, &rung, &others, go_on)?)));
            let passed = match run {
                Ok((engine, differences)) => judged(&engine, &differences).0.passed(),
                Err(error) if error.is_stop() => return Err(broken(error)),
                Err(_) => false,
            };
            finer.push((rung, passed));
            if passed {
                break;
            }
        }
    }
    Ok(Validation {
        until_s,
        path_bound,
        verdict,
        unjudged,
        checked,
        finer,
        statistics,
        reference_invariants,
        engine_invariants,
        reference: reference_run,
        engine,
        others,
        differences,
        criteria,
        rows: Vec::new(),
    })
}

/// What a thread found; a panic of it goes on.
fn joined<T>(thread: std::thread::ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

fn run_member(scene: &Scene, index: usize, go_on: Wanted) -> Result<Member, StudyError> {
    let broken = |model: Model| move |error: RunError| StudyError { model, error };
    let scene = member(scene, index);
    let expected = record_while(Model::Analytic, &reference(&scene), go_on).map_err(broken(Model::Analytic))?;
    if index > 0 {
        let differences = against(&own(&scene), &scene, &expected, go_on).map_err(broken(Model::Engine))?;
        return Ok(Member { scene, reference: expected, engine: None, differences });
    }
    let (engine, differences) = recorded(&own(&scene), &scene, &expected, go_on).map_err(broken(Model::Engine))?;
    Ok(Member { scene, reference: expected, engine: Some(engine), differences })
}

/// The run of the engine at a setting, whole, and its differences from the reference.
fn recorded(
    rung: &Rung,
    scene: &Scene,
    reference: &Recording,
    go_on: Wanted,
) -> Result<(Recording, Differences), RunError> {
    let engine = record_while(Model::Engine, &sampled(Model::Engine, &rung.apply(scene)), go_on)?;
    let differences = compare(&engine, reference, scene.bounds.until_s);
    Ok((engine, differences))
}

/// Adds the ladder to a validation: other settings of both models, compared with the same references and timed, not judged. They run one
/// after the other, those expected to be short first, for their times are measured.
///
/// # Errors
/// When `go_on` says no, the run at hand ends as stopped, and the ladder with it. Other settings may fail: their row says so.
pub fn climb(
    found: &mut Validation,
    whole: &Scene,
    plan: Climb,
    tell: &mut dyn FnMut(Progress),
    go_on: Wanted,
) -> Result<(), StudyError> {
    let scene = &compared(whole);
    let rungs = ladder(scene, plan.quick);
    let (total, start) = (rungs.len(), Instant::now());
    let own_steps = found.engine.outcome.work.steps;
    let mut order: Vec<usize> = (0..total).collect();
    let steps = |rung: &Rung| match rung.own || rung.is_reference() {
        // The two that are judged come first: their times are always wanted.
        true => -1.0,
        false => rung.predicted_steps(scene, own_steps).map_or(0.0, |steps| steps * rung.members as f64),
    };
    order.sort_by(|a, b| steps(&rungs[*a]).total_cmp(&steps(&rungs[*b])));
    let mut rows: Vec<Option<Tried>> = vec![None; total];
    // Wall time of a step of the engine as the scene says.
    let mut step_wall_s = 0.0;
    for (done, index) in order.into_iter().enumerate() {
        let rung = &rungs[index];
        tell(Progress { done, total, next: rung.family.name() });
        let left_s = plan.time_s - start.elapsed().as_secs_f64();
        let wanted = rung.own || rung.is_reference() || (left_s > 0.0 && steps(rung) * step_wall_s < left_s);
        let tried = match wanted {
            true => attempt(rung, scene, found, plan.quick, go_on)?,
            false => Tried::NoTime,
        };
        if let (true, Tried::Done { cost, .. }) = (rung.own, &tried) {
            step_wall_s = cost.wall_s / cost.steps.max(1) as f64;
        }
        rows[index] = Some(tried);
    }
    let rows = rungs.into_iter().zip(rows);
    found.rows = rows.filter_map(|(rung, tried)| Some(Row { rung, tried: tried? })).collect();
    Ok(())
}

/// Means over many runs beyond the time up to which trajectories are compared, if there is such a time.
fn sensitive(scene: &Scene, go_on: Wanted) -> Result<Option<Statistics>, RunError> {
    let is_cut = scene.kind() == SceneKind::Finger && scene.bounds.until_s < scene.duration_s;
    is_cut.then(|| statistics(scene, go_on)).transpose()
}

/// What a check of the reference says, as far as trajectories are compared.
fn check_reference(scene: &Scene, until_s: f64, go_on: Wanted) -> check::Check {
    let compared = with(scene, |scene| scene.duration_s = until_s.min(scene.duration_s));
    check::check(Model::Analytic, &reference(&compared), go_on)
}

/// Compares and times one setting.
fn attempt(rung: &Rung, scene: &Scene, found: &Validation, quick: bool, go_on: Wanted) -> Result<Tried, StudyError> {
    let broken = |error: RunError| StudyError { model: rung.model(), error };
    if rung.own {
        let cost = cost(Model::Engine, scene, quick, go_on).map_err(broken)?;
        return Ok(Tried::Done { differences: Some(Box::new(found.differences.clone())), cost });
    }
    let predicted = rung.predicted_steps(scene, found.engine.outcome.work.steps);
    if let Some(steps) = predicted.filter(|&steps| steps > LONGEST_STEPS) {
        return Ok(Tried::TooLong { steps });
    }
    let compared = match rung.is_reference() {
        true => Ok(None),
        false => against(rung, scene, &found.reference, go_on)
            .and_then(|first| worst(first, rung, &found.others, go_on))
            .map(Some),
    };
    let timed = compared.and_then(|found| Ok((found, cost(rung.model(), &rung.apply(scene), quick, go_on)?)));
    match timed {
        Ok((differences, cost)) => Ok(Tried::Done { differences: differences.map(Box::new), cost }),
        Err(error) if error.is_stop() => Err(broken(error)),
        Err(error) => Ok(Tried::Failed { reason: error.to_string() }),
    }
}

/// Worst differences of a setting over its members: `first`, those of the scene itself, and the others.
fn worst(
    first: Differences,
    rung: &Rung,
    others: &[(Scene, Recording)],
    go_on: Wanted,
) -> Result<Differences, RunError> {
    others
        .iter()
        .take(rung.members.saturating_sub(1))
        .try_fold(first, |worst, (scene, reference)| Ok(worst.worst(&against(rung, scene, reference, go_on)?)))
}

/// Differences of a setting from the reference of one member.
fn against(rung: &Rung, scene: &Scene, reference: &Recording, go_on: Wanted) -> Result<Differences, RunError> {
    let mut comparison = Comparison::new(reference, scene.bounds.until_s);
    let sampled = sampled(rung.model(), &rung.apply(scene));
    let outcome = run(rung.model(), &sampled, &mut While { sink: &mut comparison, go_on })?;
    Ok(comparison.finish(&outcome))
}
