//! How well a gripper holds: by simulation, the acceleration of its palm at which the object slips in the hand or is dropped.
//!
//! The scene is run up to where its object is at rest; from there on a load moves the palm, ever the same one but for its peak
//! acceleration: pulses in some directions, vibrations, or a pick-and-place move in another time. A run goes on [`AFTER_S`] after the load
//! is over. A load *slips* the object where it is not held at the end, or got further in the hand than the bound since the load began
//! (`grasp.cycle.carried` of a run); it *drops* it where it is not held at the end.
//!
//! More is not always worse: contacts rattle, and what one load throws out of the hand another one throws back into it. So a scan over
//! the whole range comes first, the first failure in it is narrowed by bisection, and loads beyond it that hold all the same are said. A
//! resonance narrower than the scan can be missed. Runs that cannot be finished neither hold nor fail.
//!
//! | file | job |
//! |---|---|
//! | `plan` | what is asked |
//! | `error` | why there is no answer |
//! | `prepared`, `prepare` | the scene up to where loads begin, and how it comes there |
//! | `rest` | since when the object is at rest |
//! | `motion` | motions at another pace, later, or fading |
//! | `load` | what moves the palm at a peak acceleration |
//! | `clearance` | what the object would be pressed against |
//! | `attempt` | one run under one load |
//! | `balance` | what contact forces can balance at rest |
//! | `search` | limits between what holds and what fails |

mod attempt;
mod balance;
mod clearance;
mod error;
mod load;
mod motion;
mod plan;
mod prepare;
mod prepared;
mod rest;
mod search;

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;

use crate::criteria::{Fate, GraspTracker};
use crate::grasp::run;
use crate::numeric::elementary::{ln, log2};
use crate::scene::{Axis, Scene};
use crate::study::pool;
use crate::trace::Sample;
use crate::units::LONGEST_S;

use prepared::Prepared;

pub use attempt::{Found, Tried};
pub use balance::AtRest;
pub use error::HoldError;
pub use load::{Case, Load, Stage};
pub use plan::{AFTER_S, GoOn, Loads, Plan, REST_M_S};
pub use prepared::Since;
pub use search::{Answer, Limit};

/// How well a gripper holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    pub scene: String,
    pub plan: Plan,
    pub stage: Stage,
    pub since: Since,
    /// What becomes of the object with no load at all in the same time.
    pub unloaded: Found,
    pub held: Vec<Held>,
}

/// What holds under one kind of load.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    pub case: Case,
    /// The largest load of its scan: that of the plan, or the one that still keeps clear of the table.
    pub to_m_s2: f64,
    /// What is balanced at rest when loads begin; `None` of what has no such limit.
    pub at_rest: Option<AtRest>,
    /// By their loads, from small to large.
    pub tried: Vec<Tried>,
    pub slips: Limit,
    pub drops: Limit,
}

impl Held {
    /// The run at a load that was tried.
    pub fn at(&self, peak_m_s2: f64) -> Option<&Tried> {
        self.tried.iter().find(|tried| tried.peak_m_s2 == peak_m_s2)
    }

    /// With what was tried besides.
    fn and(mut self, tried: impl IntoIterator<Item = Tried>, slip_m: f64) -> Self {
        self.tried.extend(tried);
        let Held { case, to_m_s2, at_rest, mut tried, .. } = self;
        tried.sort_by(|a, b| a.peak_m_s2.total_cmp(&b.peak_m_s2));
        let slips = Limit::of(tried.iter().map(|tried| (tried.peak_m_s2, tried.slips(slip_m))));
        let drops = Limit::of(tried.iter().map(|tried| (tried.peak_m_s2, tried.drops())));
        Held { case, to_m_s2, at_rest, tried, slips, drops }
    }
}

/// Finds the limits of all kinds of load, on all cores; `tell` hears how many runs are done, and of how many.
///
/// # Errors
/// The scene holds nothing that could be loaded, or `go_on` said no.
///
/// # Panics
/// If the plan's scan has fewer than 2 loads.
pub fn hold(
    scene: &Scene,
    plan: Plan,
    tell: &mut (dyn FnMut(u64, u64) + Send),
    go_on: GoOn<'_>,
) -> Result<Hold, HoldError> {
    let done = AtomicU64::new(0);
    let stopped = || HoldError::Stopped { done: done.load(Ordering::Relaxed) };
    let prepared = prepare::prepare(scene, &plan, go_on)?.ok_or_else(stopped)?;
    let cases = cases(&plan.loads);
    // The scene's own move takes longest under the smallest load.
    let over = |case: &Case| case.load(&prepared.stage, plan.from_m_s2).over_s + AFTER_S;
    let over_s = cases.iter().map(over).fold(0.0, f64::max);
    if over_s > LONGEST_S {
        return Err(HoldError::TooLong { over_s });
    }
    let highest = clearance::highest(&prepared, &plan, &cases)?;
    let unloaded = unloaded(&prepared, &plan, &cases, go_on)?.ok_or_else(stopped)?;
    let sample = beginning(&prepared, &plan, go_on)?.ok_or_else(stopped)?;
    let ready = &prepared;
    let asked: Vec<Held> = cases
        .iter()
        .zip(highest)
        .map(|(case, to_m_s2)| Held {
            case: *case,
            to_m_s2,
            at_rest: balance::at_rest(ready, &sample, case),
            tried: Vec::new(),
            slips: Limit::default(),
            drops: Limit::default(),
        })
        .collect();

    let scan = |held: &Held| search::ladder(plan.from_m_s2, held.to_m_s2, plan.scan);
    let jobs: Vec<(Case, f64)> =
        asked.iter().flat_map(|held| scan(held).into_iter().map(|load| (held.case, load))).collect();
    let mut total = jobs.len() as u64;
    let tried = pool::map(
        plan.threads,
        &jobs,
        |(case, load), notes: &Sender<u64>| {
            let tried = attempt::attempt(plan.model, ready, case, *load, go_on);
            // Whoever asked may be gone.
            let _ = notes.send(done.fetch_add(1, Ordering::Relaxed) + 1);
            tried
        },
        |now| tell(now, total),
    );
    let mut tried = tried.into_iter().collect::<Option<Vec<Tried>>>().ok_or_else(stopped)?.into_iter();
    let scanned: Vec<Held> =
        asked.into_iter().map(|held| held.and(tried.by_ref().take(plan.scan), plan.slip_m)).collect();
    total += scanned.iter().map(|held| most_halvings(held, plan.tolerance)).sum::<u64>();
    let narrowed = pool::map(
        plan.threads,
        &scanned,
        |held, notes: &Sender<u64>| {
            narrow(held, &plan, ready, go_on, &|| {
                let _ = notes.send(done.fetch_add(1, Ordering::Relaxed) + 1);
            })
        },
        |now| tell(now, total.max(now)),
    );
    let held = narrowed.into_iter().collect::<Option<_>>().ok_or_else(stopped)?;
    let Prepared { stage, since, .. } = prepared;
    Ok(Hold { scene: scene.name.clone(), plan, stage, since, unloaded, held })
}

fn cases(loads: &Loads) -> Vec<Case> {
    match loads {
        Loads::Pulses { directions, length_s } => {
            let direction = |index: usize| TAU * index as f64 / *directions as f64;
            (0..*directions).map(|index| Case::Pulse { direction_rad: direction(index), length_s: *length_s }).collect()
        }
        Loads::Vibrations { axes, frequencies_hz } => {
            let of = |axis: &Axis| {
                let axis = *axis;
                frequencies_hz.iter().map(move |frequency_hz| Case::Vibration { axis, frequency_hz: *frequency_hz })
            };
            axes.iter().flat_map(of).collect()
        }
        Loads::Move => vec![Case::Move],
    }
}

/// Halves both limits until they are as fine as was asked; `None` if it was told to stop.
fn narrow(held: &Held, plan: &Plan, prepared: &Prepared, go_on: GoOn<'_>, tell: &dyn Fn()) -> Option<Held> {
    let mut held = held.clone();
    while let Some(load) = held.slips.next(plan.tolerance).or(held.drops.next(plan.tolerance)) {
        let tried = attempt::attempt(plan.model, prepared, &held.case, load, go_on)?;
        tell();
        held = held.and([tried], plan.slip_m);
    }
    Some(held)
}

/// How many runs narrowing takes at most.
fn most_halvings(held: &Held, tolerance: f64) -> u64 {
    let halvings = |limit: &Limit| {
        limit.held.zip(limit.failed).map_or(0.0, |(held, failed)| log2(ln(failed / held) / tolerance).ceil().max(0.0))
    };
    (halvings(&held.slips) + halvings(&held.drops)) as u64
}

/// The same time with no load at all; `None` if it was told to stop.
fn unloaded(prepared: &Prepared, plan: &Plan, cases: &[Case], go_on: GoOn<'_>) -> Result<Option<Found>, HoldError> {
    let longest_s = cases.iter().map(|case| case.load(&prepared.stage, plan.to_m_s2).over_s).fold(0.0, f64::max);
    let load = Load { motion: prepared.stage.before.clone(), over_s: longest_s };
    match attempt::under(plan.model, prepared, load, go_on) {
        None => Ok(None),
        Some(Err(reason)) => Err(HoldError::Scene { reason }),
        Some(Ok(found)) if found.fate != Fate::Held || found.slip.displacement_m > plan.slip_m => {
            Err(HoldError::Unloaded { begins_s: prepared.stage.begins_s, bound_m: plan.slip_m, found })
        }
        Some(Ok(found)) => Ok(Some(found)),
    }
}

/// The last sample before loads begin; `None` if it was told to stop.
fn beginning(prepared: &Prepared, plan: &Plan, go_on: GoOn<'_>) -> Result<Option<Sample>, HoldError> {
    let (motion, duration_s) = (prepared.stage.before.clone(), prepared.stage.begins_s);
    let scene = prepared.scene.moved_by(Some(motion), duration_s);
    match run(plan.model, &scene, &mut GraspTracker::of(&scene), go_on) {
        None => Ok(None),
        Some(Err(reason)) => Err(HoldError::Scene { reason }),
        Some(Ok(outcome)) => Ok(Some(outcome.last)),
    }
}
