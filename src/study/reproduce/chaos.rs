//! Which of the simulations are near-chaotic: their class depends on tolerances and on torques a billionth apart.
//!
//! A rebound multiplies small differences. After a few of them two runs that began alike can come to rest at other times, or
//! one of them not at all; then the class is not a property of the design alone.

use super::{ReproduceError, STOPPED};
use crate::check::pushed;
use crate::criteria::{Class, Tracker, at_rest};
use crate::scene::{Preset, Scene};
use crate::study::pool;
use crate::study::select::{Candidate, Selection};
use crate::trace::{self, RunError};

/// How far torques are nudged, relative.
const NUDGE: f64 = 1e-9;

/// Two times to stability further apart than this are not the same: an impact lasts a microsecond.
pub const DRIFT_S: f64 = 1e-5;

/// A run that should be the same as the study's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Variation {
    /// All tolerances a tenth.
    Tighter,
    /// The reference preset: another method, and the tightest tolerances.
    Reference,
    /// The motor torque a billionth larger, and smaller.
    Stronger,
    Weaker,
}

impl Variation {
    pub const ALL: [Variation; 4] = [Variation::Tighter, Variation::Reference, Variation::Stronger, Variation::Weaker];

    pub fn name(self) -> &'static str {
        match self {
            Variation::Tighter => "tolerances a tenth",
            Variation::Reference => "reference preset",
            Variation::Stronger => "torque + 1e-9",
            Variation::Weaker => "torque − 1e-9",
        }
    }

    fn apply(self, scene: &Scene) -> Scene {
        let own = &scene.integrator;
        match self {
            Variation::Tighter => Scene { integrator: own.with_rtol(0.1 * own.rtol), ..scene.clone() },
            Variation::Reference => Scene { integrator: own.with_preset(Preset::Reference), ..scene.clone() },
            Variation::Stronger => pushed(scene, NUDGE),
            Variation::Weaker => pushed(scene, -NUDGE),
        }
    }
}

/// Classes by variation.
#[derive(Clone, Debug, PartialEq)]
pub struct Chaos {
    /// Which were tried.
    pub variations: Vec<Variation>,
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
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    pub run: i64,
    pub design: i64,
    pub condition: usize,
    pub class: Class,
    /// In the order of the variations.
    pub classes: Vec<Class>,
}

/// Runs every statically stable run of the study again, in each variation; others are unstable whatever they do.
pub fn chaos(
    scenes: &[Scene],
    selection: &Selection,
    quick: bool,
    threads: usize,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Chaos, ReproduceError> {
    let variations: Vec<Variation> =
        Variation::ALL.into_iter().filter(|&of| !(quick && of == Variation::Reference)).collect();
    let jobs: Vec<(usize, usize)> = (0..variations.len())
        .flat_map(|variation| (0..selection.runs.len()).map(move |run| (variation, run)))
        .filter(|&(_, run)| selection.runs[run].force_positive == Some(true))
        .collect();
    let found = ends(scenes, &jobs, &variations, threads, go_on)?;
    let class = |run: &Candidate| run.class.unwrap_or(Class::Unstable);
    let mut drifting: Vec<i64> = jobs
        .iter()
        .zip(&found)
        .filter(|((_, run), end)| match (selection.runs[*run].tts_s, end.1) {
            (Some(tts_s), Some(other_s)) => (tts_s - other_s).abs() > DRIFT_S,
            (None, None) => false,
            _ => true,
        })
        .map(|((_, run), _)| selection.runs[*run].run)
        .collect();
    drifting.sort_unstable();
    drifting.dedup();
    let mut all: Vec<Vec<Class>> = selection.runs.iter().map(|run| vec![class(run); variations.len()]).collect();
    for (&(variation, run), (of, _)) in jobs.iter().zip(found) {
        all[run][variation] = of;
    }
    let flips = selection.runs.iter().zip(&all).filter(|(run, of)| of.iter().any(|of| *of != class(run)));
    let flips = flips
        .map(|(run, of)| Flip {
            run: run.run,
            design: run.design,
            condition: run.condition,
            class: class(run),
            classes: of.clone(),
        })
        .collect();
    let good = |class: Class| matches!(class, Class::Stable | Class::SemiStable);
    let count = |condition: usize, test: &dyn Fn(Class, &[Class]) -> bool| {
        let runs = selection.runs.iter().zip(&all).filter(|(run, _)| run.condition == condition);
        runs.filter(|(run, of)| test(class(run), of)).count()
    };
    let conditions = 0..selection.conditions.len();
    let by_variation = |condition: usize| {
        let own = count(condition, &|class, _| good(class));
        let others = (0..variations.len()).map(|index| count(condition, &|_, of| good(of[index])));
        std::iter::once(own).chain(others).collect()
    };
    Ok(Chaos {
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
        variations,
    })
}

/// How a run ends: its class and its time to stability.
type End = (Class, Option<f64>);

/// The end of every job (variation, run), on many threads.
fn ends(
    scenes: &[Scene],
    jobs: &[(usize, usize)],
    variations: &[Variation],
    threads: usize,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<End>, ReproduceError> {
    let work = |&(variation, run): &(usize, usize), _: &_| match go_on() {
        true => end(&variations[variation].apply(&scenes[run])),
        false => Err(ReproduceError::of("a variation")(&STOPPED)),
    };
    pool::map(threads, jobs, work, |()| ()).into_iter().collect()
}

/// The end of one run. One that breaks off is unstable.
fn end(scene: &Scene) -> Result<End, ReproduceError> {
    let error = ReproduceError::of("a variation");
    let object = scene.object.ok_or_else(|| error(&"there is no object"))?;
    let rest = at_rest(scene, object).map_err(|reason| error(&reason))?;
    let mut tracker = Tracker::new(rest.angles());
    match trace::run_analytic(scene, &mut tracker) {
        Ok(_) => {
            let criteria = tracker.criteria(rest.is_stable());
            Ok((criteria.class, criteria.tts_s))
        }
        Err(RunError::Simulation { .. }) => Ok((Class::Unstable, None)),
        Err(RunError::Sink(reason)) => Err(error(&reason)),
    }
}
