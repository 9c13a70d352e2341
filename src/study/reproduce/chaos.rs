//! Which of the simulations are near-chaotic: their class depends on tolerances and on torques a little apart.
//!
//! A rebound multiplies small differences. After a few of them two runs that began alike can come to rest at other times, or
//! one of them not at all; then the class is not a property of the design alone. The runs that a check makes anyway say what
//! another method, finer, and a torque that is pushed make of it.

use serde::Serialize;

use super::checks::{Checks, tell};
use super::{ReproduceError, STOPPED};
use crate::check::{Check, PUSH, check_heard, pushed};
use crate::criteria::{AtRest, Class, Tracker, at_rest};
use crate::scene::Scene;
use crate::study::pool;
use crate::study::select::{Candidate, Selection};
use crate::study::sweep::Status;
use crate::table::Table;
use crate::trace::{self, Model, RunError, Sink};

/// How far torques are nudged, relative.
const NUDGE: f64 = 1e-9;

/// Two times to stability further apart than this are not the same: an impact lasts a microsecond.
pub const DRIFT_S: f64 = 1e-5;

/// A run that should be the same as the study's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Variation {
    /// The run that the study's is checked against: another method, at a hundredth of the tolerance.
    Finer,
    /// The same with a motor torque that is larger by [`PUSH`] of itself.
    Pushed,
    /// As the study runs, with a torque a billionth larger.
    Nudged,
}

impl Variation {
    pub const ALL: [Variation; 3] = [Variation::Finer, Variation::Pushed, Variation::Nudged];

    pub fn name(self) -> &'static str {
        match self {
            Variation::Finer => "another method, finer",
            Variation::Pushed => "the same, torque + 1e-7",
            Variation::Nudged => "torque + 1e-9",
        }
    }
}

const _: () = assert!(PUSH == 1e-7, "as it is named");

/// Classes by variation.
#[derive(Clone, Debug, PartialEq)]
pub struct Chaos {
    /// Runs whose class is not the same in all of them.
    pub flips: Vec<Flip>,
    /// Runs whose time to stability moves by more than [`DRIFT_S`], or which have one in some variations only.
    pub drifting: Vec<i64>,
    /// Dynamically stable runs (stable and semi-stable) of each condition: of the study, then of each variation.
    pub stable: Vec<Vec<usize>>,
    /// Of each condition: stable in every variation, and in at least one.
    pub always: Vec<usize>,
    pub ever: Vec<usize>,
}

/// One run whose class changes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flip {
    pub run: i64,
    pub design: i64,
    #[serde(skip)]
    pub condition: usize,
    pub class: Class,
    /// In the order of the variations.
    #[serde(rename = "by_variation")]
    pub classes: Vec<Class>,
}

/// Checks every completed run of the study, writes into its row what that found, and runs every statically stable one again in each
/// variation; others are unstable whatever they do.
pub fn chaos(
    scenes: &[Scene],
    results: &mut Table,
    selection: &Selection,
    threads: usize,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<(Checks, Chaos), ReproduceError> {
    let jobs: Vec<usize> =
        (0..selection.runs.len()).filter(|&run| selection.runs[run].status == Status::Completed).collect();
    let work = |&run: &usize, _: &_| again(&scenes[run], selection.runs[run].force_positive == Some(true), go_on);
    let found: Vec<Again> = pool::map(threads, &jobs, work, |()| ()).into_iter().collect::<Result<_, _>>()?;
    let mut checks = Checks::default();
    for (&run, again) in jobs.iter().zip(&found) {
        checks.add(selection.runs[run].run, &again.check);
        tell(results, selection.runs[run].row, &again.check);
    }
    let class = |run: &Candidate| run.class.unwrap_or(Class::Unstable);
    let moves = |own: Option<f64>, other: Option<f64>| match (own, other) {
        (Some(own_s), Some(other_s)) => (own_s - other_s).abs() > DRIFT_S,
        (None, None) => false,
        _ => true,
    };
    let mut drifting: Vec<i64> = jobs
        .iter()
        .zip(&found)
        .filter(|(run, again)| again.ends.iter().flatten().any(|end| moves(selection.runs[**run].tts_s, end.1)))
        .map(|(run, _)| selection.runs[*run].run)
        .collect();
    drifting.sort_unstable();
    let own = |run: &Candidate| [class(run); Variation::ALL.len()];
    let mut all: Vec<[Class; Variation::ALL.len()]> = selection.runs.iter().map(own).collect();
    for (&run, again) in jobs.iter().zip(found) {
        if let Some(ends) = again.ends {
            all[run] = ends.map(|(class, _)| class);
        }
    }
    let flips = selection.runs.iter().zip(&all).filter(|(run, of)| of.iter().any(|of| *of != class(run)));
    let flips = flips
        .map(|(run, of)| Flip {
            run: run.run,
            design: run.design,
            condition: run.condition,
            class: class(run),
            classes: of.to_vec(),
        })
        .collect();
    let good = |class: Class| matches!(class, Class::Stable | Class::SemiStable);
    let count = |condition: usize, test: &dyn Fn(Class, &[Class]) -> bool| {
        let runs = selection.runs.iter().zip(&all).filter(|(run, _)| run.condition == condition);
        runs.filter(|(run, of)| test(class(run), &of[..])).count()
    };
    let conditions = 0..selection.conditions.len();
    let by_variation = |condition: usize| {
        let own = count(condition, &|class, _| good(class));
        let others = (0..Variation::ALL.len()).map(|index| count(condition, &|_, of| good(of[index])));
        std::iter::once(own).chain(others).collect()
    };
    let chaos = Chaos {
        flips,
        drifting,
        stable: conditions.clone().map(by_variation).collect(),
        always: conditions
            .clone()
            .map(|condition| count(condition, &|class, of| good(class) && of.iter().all(|of| good(*of))))
            .collect(),
        ever: conditions
            .map(|condition| count(condition, &|class, of| good(class) || of.iter().any(|of| good(*of))))
            .collect(),
    };
    Ok((checks, chaos))
}

/// How a run ends: its class and its time to stability.
type End = (Class, Option<f64>);

/// What running a simulation again came to.
struct Again {
    check: Check,
    /// In the order of the variations, where they are asked for.
    ends: Option<[End; Variation::ALL.len()]>,
}

/// Checks a run, and looks how it ends otherwise.
fn again(scene: &Scene, varied: bool, go_on: &(dyn Fn() -> bool + Sync)) -> Result<Again, ReproduceError> {
    let error = ReproduceError::of("a variation");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let rest = at_rest(scene, object).map_err(|reason| error(&reason))?;
    let tracker = || Tracker::new(rest.angles());
    let (mut finer, mut pushed) = (tracker(), tracker());
    let heard: [&mut dyn Sink; 2] = if varied { [&mut finer, &mut pushed] } else { [&mut (), &mut ()] };
    let check = check_heard(Model::Analytic, scene, heard, go_on);
    let ends = match varied {
        true => Some([end(&finer, &rest), end(&pushed, &rest), nudged(scene, &rest)?]),
        false => None,
    };
    // What was broken off says nothing.
    if go_on() { Ok(Again { check, ends }) } else { Err(error(&STOPPED)) }
}

fn end(tracker: &Tracker, rest: &AtRest) -> End {
    let criteria = tracker.criteria(rest.static_forces_n());
    criteria.map_or((Class::Unstable, None), |criteria| (criteria.class, criteria.tts_s))
}

/// The end of the run with another torque. One that breaks off is unstable.
fn nudged(scene: &Scene, rest: &AtRest) -> Result<End, ReproduceError> {
    let scene = Scene { log: scene.log.without_grid(scene.duration_s), ..pushed(scene, NUDGE) };
    let mut tracker = Tracker::new(rest.angles());
    match trace::run_analytic(&scene, &mut tracker) {
        Ok(_) => Ok(end(&tracker, rest)),
        Err(RunError::Simulation { .. }) => Ok((Class::Unstable, None)),
        Err(RunError::Sink(reason)) => Err(ReproduceError::of("a variation")(&reason)),
    }
}
