//! How long the next step may be, judged by what is known at its start.
//!
//! * Free motion: rapier moves bodies straight on, by up to ½ dt² |J̇ v| off the arcs of their joints: no further than the
//!   tolerance. And what leapfrog misses of a changing acceleration adds up to no more than 100 tolerances a
//!   second.
//! * Touch: a step ends where a gap is predicted to close, and the last steps before it shrink by halves.
//! * Impact: no step may move a surface by more than a part of the depth at which its law stops it.
//! * Turning: a contact's direction is frozen in a step; what it turns meanwhile, under its force, counts as drift.
//! * Effort: a step after a contact solve that needed many sub-steps is not longer than the one before.
//! * Steps at most double, end at jumps of the motor torque and at the end of the run.

use super::motion::Motion;
use super::substeps::time_to_zero;
use crate::law::stopping_depth;
use crate::scene::Stepping;

/// Part of its stopping depth an impact may cross in one step…
const CROSSING: f64 = 0.08;
/// …if that is no deeper than this, in m or rad; else less, by the root of how much deeper: what a step's frozen geometry misses of
/// an impact grows with the way that surfaces go in it. Design 95 stops within 4e-6 m, soft contacts within up to 6e-4 m.
const SHALLOW: f64 = 5e-6;
/// The least that remains of the part.
const DEEPEST_SHARE: f64 = 0.25;
/// …or, where its inertia is not known yet, part of its damper's transition.
const FIRST_CROSSING: f64 = 0.05;
/// Sub-steps from which a contact counts as hard.
const HARD_SUBSTEPS: u32 = 60;
/// Tolerances per second by which the scheme may drift off in free motion: two tolerances in a closing of 20 ms.
const DRIFT_PER_S: f64 = 100.0;
const FIRST_STEP_S: f64 = 1e-6;
/// Touches and drift ask for no shorter steps, s.
const SHORTEST_S: f64 = 1e-10;

/// The next step, ending at `end_s` at the latest.
pub fn next(motion: &Motion, stepping: Stepping, end_s: f64) -> f64 {
    let left = motion.clock.until(stop(motion, end_s));
    match stepping {
        Stepping::Fixed { step_s } => {
            if left < 1.000_001 * step_s {
                left
            } else {
                step_s
            }
        }
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            let wanted = adaptive(motion, tolerance_m, max_step_s);
            // Two even steps rather than one and a rest.
            if left <= wanted { left } else { wanted.min(if left < 2.0 * wanted { 0.5 * left } else { left }) }
        }
    }
}

/// Where the next step ends at the latest: at the next jump of what drives the bodies, or at the end of the run.
///
/// Times that are one in a scene can differ by a last digit here, as a move's end (its start and what it takes) and the start of the
/// next. In a step of 3e-17 s from one to the other, speeds of what is driven would be rounding over that: jumps this near are one.
fn stop(motion: &Motion, end_s: f64) -> f64 {
    let mut stop = end_s.min(motion.plan.next_corner(motion.clock.now() + SHORTEST_S));
    loop {
        let later = end_s.min(motion.plan.next_corner(stop));
        if stop >= end_s || later - stop > SHORTEST_S {
            return stop;
        }
        stop = later;
    }
}

fn adaptive(motion: &Motion, tolerance_m: f64, max_step_s: f64) -> f64 {
    let growth = match motion.last_dt_s {
        0.0 => FIRST_STEP_S,
        last if motion.contact.substeps > HARD_SUBSTEPS => last,
        last => 2.0 * last,
    };
    // Leapfrog misses dt³/12 of the acceleration's rate of change in a step: an error that grows at this speed.
    let drift_m_s = motion.last_dt_s * (motion.acceleration_change + motion.last_dt_s * turning(motion)) / 12.0;
    let mut dt = growth.min(max_step_s).min((2.0 * tolerance_m / motion.opening).sqrt());
    let shortest = SHORTEST_S.min(dt);
    if drift_m_s > 0.0 {
        dt = dt.min(motion.last_dt_s * (DRIFT_PER_S * tolerance_m / drift_m_s).sqrt());
    }
    for touch in motion.touches.iter().filter(|touch| touch.has_gap()) {
        let rate = touch.normal_row.rate(&motion.velocities);
        let at = motion.space.sites.iter().find(|at| at.touch.index == touch.index);
        // Drift of an acceleration whose direction turns, for as long as a step: the longest step that it allows.
        let straight = |acceleration: f64| (12.0 * DRIFT_PER_S * tolerance_m / (acceleration * touch.turning)).sqrt();
        let (crossing, force) = match at {
            Some(at) => {
                let inverse_mass = motion.space.w[at.normal * (motion.space.len() + 1)];
                let stop = stopping_depth(&touch.law, rate.abs(), inverse_mass).max(-touch.gap);
                let crossing = (crossing_part(stop) * stop / rate.abs()).min(straight(0.5 * rate * rate / stop));
                (crossing, motion.contact.force[at.normal])
            }
            // Its inertia is not known yet: an impact may take the whole rate away in one step.
            None => {
                let crossing = FIRST_CROSSING * touch.law.transition_m / rate.abs();
                let turning = 12.0 * DRIFT_PER_S * tolerance_m / (rate.abs() * touch.turning);
                (crossing.min(turning), 0.0)
            }
        };
        if touch.gap <= 0.0 {
            // On its way out a surface matters only while it still pushes; one that a step moves by less than its last digits, never.
            if (rate < 0.0 || force > 0.0) && rate.abs() * dt > touch.rounding {
                dt = dt.min(crossing);
            }
            continue;
        }
        let ahead = time_to_zero(touch.gap, rate, touch.normal_row.rate(&motion.accelerations));
        if ahead < 2.0 * dt {
            // Step onto the touch by halves, and over it with the step an impact asks for.
            dt = dt.min(if ahead > 2.0 * crossing { 0.5 * ahead } else { ahead.max(crossing) });
        }
    }
    dt.max(shortest)
}

/// Rate at which the accelerations that contacts make turn with their normals, in m/s³.
fn turning(motion: &Motion) -> f64 {
    let rows = motion.space.len();
    let of = |at: &super::space::Site| {
        let touch = motion.touches.iter().find(|touch| touch.index == at.touch.index);
        let pushed = motion.space.w[at.normal * (rows + 1)] * motion.contact.force[at.normal];
        pushed * touch.map_or(0.0, |touch| touch.turning)
    };
    motion.space.sites.iter().map(of).fold(0.0, f64::max)
}

/// Part of its stopping depth that an impact may cross in one step.
fn crossing_part(stop: f64) -> f64 {
    CROSSING * (SHALLOW / stop).sqrt().clamp(DEEPEST_SHARE, 1.0)
}
