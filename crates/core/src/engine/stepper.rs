//! Step size control, from the state at the start of the step.
//!
//! * Motion between events: rapier moves bodies straight on, by up to ½ dt² |J̇ v| off the arcs of their joints; this
//!   distance is limited to the tolerance. The error of an uncorrected leapfrog scheme under a changing acceleration is
//!   limited to 100 tolerances per second. Both limits are larger while no contact exerts a force and no body is driven,
//!   because the corrected scheme is of third order then.
//! * Touch-down: a step ends where a gap is predicted to close, and the last steps before it are halved successively.
//! * Impact: a step moves a surface by at most a fraction of the depth at which its law stops it.
//! * Rotation: the direction of a contact is frozen in a step; its rotation under the contact force counts as drift.
//! * Cost: a step after a contact solution with many sub-steps is not longer than the one before.
//! * Steps at most double; they end at discontinuities of the motor torque and at the end of the run.

use super::motion::Motion;
use super::substeps::time_to_zero;
use crate::law::stopping_depth;
use crate::scene::Stepping;

/// Fraction of its stopping depth that an impact may cross in one step.
const CROSSING_FRACTION: f64 = 0.08;
/// Stopping depth, m or rad, up to which [`CROSSING_FRACTION`] applies. For larger depths the fraction is inversely
/// proportional to the square root of the depth, because the error of the frozen geometry grows with the distance that
/// the surfaces travel. Design 95 stops within 4e-6 m, soft contacts within up to 6e-4 m.
const SHALLOW_DEPTH: f64 = 5e-6;
/// Smallest factor by which [`CROSSING_FRACTION`] is reduced at large depths.
const MIN_CROSSING_FACTOR: f64 = 0.25;
/// Fraction of the damper's transition that an impact may cross in one step while its effective mass is unknown.
const FIRST_CROSSING_FRACTION: f64 = 0.05;
/// Number of sub-steps above which steps do not grow.
const MAX_GROWTH_SUBSTEPS: u32 = 60;
/// Drift of an uncorrected leapfrog scheme, in tolerances per second: two tolerances in a closing motion of 20 ms.
const DRIFT_PER_S: f64 = 100.0;
/// Factors of the limits of drift and distance from the arcs of joints while the scheme is of third order. They halve the
/// steps of a four-bar linkage in free motion, whose error is a hundredth of that of an uncorrected scheme. The work of
/// actuators is integrated by the trapezoidal rule; larger factors would show in the energy balance.
const FREE_DRIFT_FACTOR: f64 = 4.0;
const FREE_ARC_FACTOR: f64 = 4.0;
/// Length of the first step, s.
const FIRST_STEP_S: f64 = 1e-6;
/// Shortest step that touch-downs and drift can request, s.
const MIN_STEP_S: f64 = 1e-10;

/// Returns the length of the next step, which ends at `end_s` at the latest.
pub fn next_step(motion: &Motion, stepping: Stepping, end_s: f64) -> f64 {
    let remaining = motion.clock.until(latest_end(motion, end_s));
    match stepping {
        Stepping::Fixed { step_s } if remaining < 1.000_001 * step_s => remaining,
        Stepping::Fixed { step_s } => step_s,
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            let requested = adaptive_step(motion, tolerance_m, max_step_s);
            match remaining <= requested {
                true => remaining,
                // Two equal steps instead of a full one and a short rest.
                false => requested.min(if remaining < 2.0 * requested { 0.5 * remaining } else { remaining }),
            }
        }
    }
}

/// Returns the latest end of the next step: the next discontinuity of a drive, or the end of the run.
///
/// Equal times of a scene can differ by rounding here, such as the end of a move (start plus duration) and the start of
/// the next. A step of 3e-17 s between them would turn rounding errors into speeds of driven bodies, so discontinuities
/// this close are merged.
fn latest_end(motion: &Motion, end_s: f64) -> f64 {
    let mut end = end_s.min(motion.plan.next_discontinuity(motion.clock.now() + MIN_STEP_S));
    loop {
        let next_end = end_s.min(motion.plan.next_discontinuity(end));
        if end >= end_s || next_end - end > MIN_STEP_S {
            return end;
        }
        end = next_end;
    }
}

fn adaptive_step(motion: &Motion, tolerance_m: f64, max_step_s: f64) -> f64 {
    let growth = match motion.last_dt_s {
        0.0 => FIRST_STEP_S,
        last if motion.contact.substeps > MAX_GROWTH_SUBSTEPS => last,
        last => 2.0 * last,
    };
    // The leapfrog error per step is dt³/12 times the rate of the acceleration: an error that grows at this speed.
    let drift_m_s = motion.last_dt_s
        * (motion.acceleration_change + motion.last_dt_s * contact_acceleration_rotation(motion))
        / 12.0;
    let [drift_factor, arc_factor] = if motion.is_smooth() { [FREE_DRIFT_FACTOR, FREE_ARC_FACTOR] } else { [1.0, 1.0] };
    let mut dt = growth.min(max_step_s).min((2.0 * arc_factor * tolerance_m / motion.opening_acceleration).sqrt());
    let shortest = MIN_STEP_S.min(dt);
    if drift_m_s > 0.0 {
        dt = dt.min(motion.last_dt_s * (drift_factor * DRIFT_PER_S * tolerance_m / drift_m_s).sqrt());
    }
    for candidate in motion.candidates.iter().filter(|candidate| candidate.has_gap()) {
        let rate = candidate.normal_row.rate(&motion.velocities);
        // Longest step for which the drift of an acceleration with a rotating direction is allowed.
        let rotation_limit = |acceleration: f64| {
            (12.0 * DRIFT_PER_S * tolerance_m / (acceleration * candidate.normal_rotation_rate)).sqrt()
        };
        let (crossing, force) = match motion.space.find(candidate.index) {
            Some((_, active)) => {
                let inverse_mass = motion.space.inverse_mass(active.normal);
                let depth = stopping_depth(&candidate.law, rate.abs(), inverse_mass).max(-candidate.gap);
                let fraction = CROSSING_FRACTION * (SHALLOW_DEPTH / depth).sqrt().clamp(MIN_CROSSING_FACTOR, 1.0);
                let crossing = (fraction * depth / rate.abs()).min(rotation_limit(0.5 * rate * rate / depth));
                (crossing, motion.contact.force[active.normal])
            }
            // The effective mass is unknown: an impact may stop the whole rate in one step.
            None => {
                let crossing = FIRST_CROSSING_FRACTION * candidate.law.depth_scale_m() / rate.abs();
                let rotation_limit = 12.0 * DRIFT_PER_S * tolerance_m / (rate.abs() * candidate.normal_rotation_rate);
                (crossing.min(rotation_limit), 0.0)
            }
        };
        if candidate.gap <= 0.0 {
            // A receding surface limits the step only under a force; one that moves by less than rounding never does.
            if (rate < 0.0 || force > 0.0) && rate.abs() * dt > candidate.rounding {
                dt = dt.min(crossing);
            }
            continue;
        }
        let time_to_touch_down = time_to_zero(candidate.gap, rate, candidate.normal_row.rate(&motion.accelerations));
        if time_to_touch_down < 2.0 * dt {
            // Approach the touch-down by halved steps, and cross it with the step required by an impact.
            dt = dt.min(if time_to_touch_down > 2.0 * crossing {
                0.5 * time_to_touch_down
            } else {
                time_to_touch_down.max(crossing)
            });
        }
    }
    dt.max(shortest)
}

/// Returns the rate at which contact accelerations rotate with their normals, m/s³.
fn contact_acceleration_rotation(motion: &Motion) -> f64 {
    let rotation = |active: &super::contact_space::ActiveContact| {
        let candidate = motion.candidate(active.candidate.index);
        let acceleration = motion.space.inverse_mass(active.normal) * motion.contact.force[active.normal];
        acceleration * candidate.map_or(0.0, |candidate| candidate.normal_rotation_rate)
    };
    let contacts = motion.space.active_contacts.iter().filter(|active| !active.candidate.has_prescribed_normal());
    contacts.map(rotation).fold(0.0, f64::max)
}
