//! Contact within one step of the engine: ġ = u_n, u̇ = b + W F(g, u), integrated with W and b frozen.
//!
//! SDIRK2 (Alexander 1977, γ = 1 − 1/√2: two stages, second order, L-stable) with step sizes from its embedded
//! first-order solution; free flight up to the next touch-down is in closed form. The results are impulses along the
//! rows, split so that the engine's leapfrog is centred: the *early* part moves the bodies within this step, the *late*
//! part from the next step on. With Q = ∫₀ᵈᵗ (dt − s) F ds: early = Q/dt, late = ∫F ds − Q/dt.

use super::cancellation::Cancellation;
use super::candidates::{Element, GAP_ROUNDING};
use super::contact_space::{ActiveContact, ContactSpace, Diverged, Stage, Workspace};
use super::lists::{refill, reset};
use crate::law::FrictionPoint;
use crate::numeric::elementary::hypot;
use crate::scene::Stepping;

/// Error of a sub-step's first-order solution relative to the speed at each contact. At 3e-3, undamped rebounds had
/// errors of 4e-3 rad at any step tolerance; 2e-4 makes a run of design 95 a tenth slower.
const RELATIVE_TOLERANCE: f64 = 2e-4;
/// Relative tolerance per second of step length: a long step freezes the geometry, with errors of hundreds of radians
/// per second, so a finer tolerance has no benefit.
const RELATIVE_TOLERANCE_PER_S: f64 = 20.0;
/// Largest relative tolerance.
const MAX_RELATIVE_TOLERANCE: f64 = 0.03;
/// Absolute tolerance of rates, m/s or rad/s.
const ABSOLUTE_TOLERANCE: f64 = 1e-5;
/// Tolerance of slip, as a fraction of the narrowest range of the friction law, over which μ changes fully.
const SLIP_TOLERANCE: f64 = 0.03;
/// Tolerances for fixed steps. The error of the frozen geometry is larger, so finer tolerances have no benefit.
const FIXED: Tolerance = Tolerance { relative: 3e-3, relative_per_s: 300.0, absolute: 1e-5, slip: SLIP_TOLERANCE };
/// Default step tolerance, m, to which these tolerances refer.
const DEFAULT_TOLERANCE_M: f64 = 1e-7;
/// Largest value to which [`SLIP_TOLERANCE`] is scaled for coarse steps.
const MAX_SLIP_TOLERANCE: f64 = 0.1;
/// Fraction of the narrowest range by which a sub-step may exceed the end of a range: μ has then changed by three
/// hundredths, with a slope that starts at zero.
const RANGE_MARGIN: f64 = 0.1;
/// Fraction of the damper's transition that a first sub-step may cross.
const FIRST_CROSSING: f64 = 0.05;
/// Smallest friction limit, N, in the error scale of friction with stiction.
const MIN_STICTION_N: f64 = 1e-3;
/// Largest ratio of successive sub-steps.
const MAX_GROWTH: f64 = 4.0;
/// Largest number of sub-steps per step.
const MAX_SUBSTEPS: u32 = 100_000;
/// Smallest sub-step as a fraction of the step.
const MIN_STEP_FRACTION: f64 = 1e-14;

/// Coefficient γ of SDIRK2.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Weights of the stage forces in the double integral over a sub-step: Σᵢ bᵢ aᵢⱼ with b = (1 − γ, γ).
const DOUBLE_INTEGRAL_WEIGHTS: [f64; 2] = [2.0 * GAMMA * (1.0 - GAMMA), GAMMA * GAMMA];

/// A change of one contact within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Time of the change, from the start of the step.
    pub after_s: f64,
    /// Index of the contact in the contact space.
    pub contact: usize,
    pub kind: ChangeKind,
    pub closing: f64,
    /// Normal impulse from the start of the step to this change.
    pub impulse: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeKind {
    Closes,
    Opens,
    /// The contact force starts.
    Loads,
    /// The contact force ends.
    Unloads,
    /// The friction of an active contact with stiction reaches its limit.
    Slips,
    /// The friction is below its limit again.
    Sticks,
}

/// State of one contact at an extremum within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactExtremum {
    /// Time of the extremum, from the start of the step.
    pub after_s: f64,
    pub gap: f64,
    pub gap_rate: f64,
    pub slip: f64,
    pub normal: f64,
    pub tangential: f64,
    /// Normal impulse from the start of the step to this extremum.
    pub impulse: f64,
}

/// Solver of the contact forces over one step, with its results.
#[derive(Clone, Debug, Default)]
pub struct ContactSolver {
    /// Early impulse along each row; see the module documentation.
    pub early_impulse: Vec<f64>,
    /// Late impulse along each row.
    pub late_impulse: Vec<f64>,
    /// Force along each row at the end of the step.
    pub force: Vec<f64>,
    /// Gap of each contact at the end of the step.
    pub gap: Vec<f64>,
    /// Rate along each row at the end of the step.
    pub rate: Vec<f64>,
    /// Internal state of friction of each contact at the end of the step.
    pub friction_state: Vec<f64>,
    /// Current of the motor of each powertrain at the end of the step, one per contact.
    pub current: Vec<f64>,
    /// Work that each powertrain has lost in its gear, J, one per contact.
    pub loss_work: Vec<f64>,
    /// For each contact, its state at the largest normal force.
    pub peak: Vec<ContactExtremum>,
    /// For each contact, its state at the largest penetration.
    pub deepest: Vec<ContactExtremum>,
    /// Work of contacts, brakes and dampers on the bodies, J.
    pub work: f64,
    /// Work of motors and their servos on the bodies, J.
    pub motor_work: f64,
    /// Part of `work` of the friction of cables, J.
    pub cable_work: f64,
    /// Derivative of the force of each row by its own rate at the end of the step, for the friction of cables.
    pub(crate) cable_slope: Vec<f64>,
    pub changes: Vec<Change>,
    /// ∫F ds and ∬F ds² along each row up to each change, change by change.
    integrals_at_changes: Vec<[f64; 2]>,
    pub substeps: u32,
    pub iterations: u32,
    /// Number of sub-steps that were repeated: with too large an error, beyond a range of a law, or not converged.
    pub repeated: u32,
    /// Tolerances of sub-steps.
    pub tolerance: Tolerance,
    work_space: Workspace,
    buffers: Buffers,
}

/// Working arrays: integrals of force, stages and error per row, and states per contact.
#[derive(Clone, Debug, Default)]
struct Buffers {
    impulse: Vec<f64>,
    double_integral: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    first_force: Vec<f64>,
    base_rate: Vec<f64>,
    base_gap: Vec<f64>,
    base_friction_state: Vec<f64>,
    base_current: Vec<f64>,
    first_loss: Vec<f64>,
    error: Vec<f64>,
    is_touching: Vec<bool>,
    is_loaded: Vec<bool>,
    is_slipping: Vec<bool>,
    /// Length of the step.
    dt: f64,
}

/// Error tolerances of the rates in one sub-step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    relative: f64,
    relative_per_s: f64,
    absolute: f64,
    slip: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        FIXED
    }
}

impl Tolerance {
    /// Returns the tolerances of a run. Sub-step errors are proportional to the step tolerance of the run.
    pub fn from_stepping(stepping: Stepping) -> Self {
        let Stepping::Adaptive { tolerance_m, .. } = stepping else { return FIXED };
        let factor = tolerance_m / DEFAULT_TOLERANCE_M;
        Self {
            relative: RELATIVE_TOLERANCE * factor,
            relative_per_s: RELATIVE_TOLERANCE_PER_S * factor,
            absolute: ABSOLUTE_TOLERANCE * factor.min(1.0),
            slip: (SLIP_TOLERANCE * factor).min(MAX_SLIP_TOLERANCE),
        }
    }

    /// Returns the tolerances for a step of `dt`: a long step freezes the geometry, so finer ones have no benefit.
    fn for_step(self, dt: f64) -> Self {
        let relative = (self.relative_per_s * dt).max(self.relative).min(MAX_RELATIVE_TOLERANCE);
        Self { relative, ..self }
    }
}

/// Error reported by the contact solver.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ContactSolveError {
    #[error("the contact solve did not converge (relative residual {residual:.1e} at sub-steps of {h_s:.1e} s)")]
    NotConverged { residual: f64, h_s: f64 },
    #[error("contact needs more than {MAX_SUBSTEPS} sub-steps within one step of {dt_s:.1e} s: use smaller steps")]
    SubstepBudget { dt_s: f64 },
    #[error("the contact solve was interrupted")]
    Stopped,
}

impl ContactSolver {
    /// Integrates the contacts over `dt`. Stops with an error once `keep_running` returns false. It is called often,
    /// because a step with many contacts can take minutes.
    pub fn solve(
        &mut self,
        space: &ContactSpace,
        dt: f64,
        keep_running: &dyn Fn() -> bool,
    ) -> Result<(), ContactSolveError> {
        self.begin(space);
        self.buffers.dt = dt;
        let (mut now, mut h) = (0.0, dt);
        let tolerance = self.tolerance.for_step(dt);
        let cancellation = &Cancellation::new(keep_running);
        while now < dt {
            let remaining = dt - now;
            if remaining <= MIN_STEP_FRACTION * dt {
                break;
            }
            let flight_time = self.time_to_touch_down(space, remaining);
            if !self.buffers.is_touching.contains(&true) && flight_time > 0.0 {
                self.fly(space, flight_time);
                now += flight_time;
                self.record_touch_downs(space, now);
                h = self.first_crossing(space, dt);
                continue;
            }
            // Another contact may close within the sub-step: end the sub-step there.
            let max_length = if flight_time > MIN_STEP_FRACTION * dt { flight_time } else { remaining };
            h = h.min(max_length).min(remaining);
            match self.substep(space, h, remaining, tolerance, cancellation) {
                Ok(error) => {
                    let ratio = (1.0 / error.max(1e-300)).sqrt();
                    if error > 1.0 && h > MIN_STEP_FRACTION * dt {
                        self.repeated += 1;
                        h *= (0.9 * ratio).clamp(0.1, 0.7);
                        continue;
                    }
                    if let Some(fraction) = self.fraction_to_range_end(space).filter(|_| h > MIN_STEP_FRACTION * dt) {
                        self.repeated += 1;
                        h *= fraction;
                        continue;
                    }
                    self.accept(space, now, h, remaining);
                    now += h;
                    if self.record_changes(space, now) {
                        h = h.min(self.first_crossing(space, dt));
                    } else {
                        h *= (0.9 * ratio).clamp(0.3, MAX_GROWTH);
                    }
                }
                Err(_) if !keep_running() => return Err(ContactSolveError::Stopped),
                Err(error) => {
                    self.repeated += 1;
                    h *= 0.25;
                    if h < MIN_STEP_FRACTION * dt {
                        return Err(ContactSolveError::NotConverged { residual: error.residual, h_s: h });
                    }
                }
            }
            if self.substeps > MAX_SUBSTEPS {
                return Err(ContactSolveError::SubstepBudget { dt_s: dt });
            }
            if !keep_running() {
                return Err(ContactSolveError::Stopped);
            }
        }
        let buffers = &self.buffers;
        for i in 0..space.len() {
            self.early_impulse[i] = buffers.double_integral[i] / dt;
            self.late_impulse[i] = buffers.impulse[i] - self.early_impulse[i];
        }
        Ok(())
    }

    /// Returns ∫F ds and ∬F ds² along each row, from the start of the step to a change.
    pub(crate) fn integrals_at(&self, change: usize) -> impl Iterator<Item = [f64; 2]> {
        let rows = self.integrals_at_changes.len() / self.changes.len();
        self.integrals_at_changes[change * rows..(change + 1) * rows].iter().copied()
    }

    /// Whether friction with stiction slips at the end of the step; `None` if the contact has no stiction or is not loaded.
    pub(crate) fn is_slipping(&self, index: usize, space: &ContactSpace) -> Option<bool> {
        let contact = &space.active_contacts[index];
        let is_loaded = contact.candidate.has_gap()
            && contact.candidate.law_with_state().is_some()
            && self.force[contact.normal] > 0.0;
        is_loaded.then(|| self.buffers.is_slipping.get(index).copied()).flatten()
    }

    /// Initialises all arrays at the start of a step.
    fn begin(&mut self, space: &ContactSpace) {
        let (rows, contacts) = (space.len(), space.active_contacts.len());
        let Buffers { impulse, double_integral, first, second, first_force, base_rate, error, .. } = &mut self.buffers;
        let own = [&mut self.early_impulse, &mut self.late_impulse, &mut self.force];
        for list in own.into_iter().chain([impulse, double_integral, first, second, first_force, base_rate, error]) {
            reset(list, rows, 0.0);
        }
        self.work_space.resize(rows, contacts);
        refill(&mut self.friction_state, space.active_contacts.iter().map(|contact| contact.friction_state));
        refill(&mut self.rate, space.rate.iter().copied());
        refill(&mut self.gap, space.active_contacts.iter().map(|contact| contact.candidate.gap));
        refill(&mut self.current, space.active_contacts.iter().map(|contact| contact.current));
        reset(&mut self.loss_work, contacts, 0.0);
        for list in
            [&mut self.buffers.base_friction_state, &mut self.buffers.base_current, &mut self.buffers.first_loss]
        {
            reset(list, contacts, 0.0);
        }
        reset(&mut self.buffers.base_gap, contacts, 0.0);
        reset(&mut self.peak, contacts, ContactExtremum::default());
        reset(&mut self.deepest, contacts, ContactExtremum::default());
        self.changes.clear();
        self.integrals_at_changes.clear();
        (self.work, self.motor_work, self.cable_work) = (0.0, 0.0, 0.0);
        reset(&mut self.cable_slope, rows, 0.0);
        (self.substeps, self.iterations, self.repeated) = (0, 0, 0);
        let is_touching = |contact: &ActiveContact| contact.candidate.gap <= 0.0 || contact.candidate.is_servo();
        refill(&mut self.buffers.is_touching, space.active_contacts.iter().map(is_touching));
        self.buffers.is_loaded.clear();
        self.buffers.is_slipping.clear();
        for contact in &space.active_contacts {
            let force = contact.candidate.normal_force(contact.candidate.gap, space.rate[contact.normal]).force;
            self.force[contact.normal] = force;
            self.buffers.is_loaded.push(force > 0.0);
            self.buffers.is_slipping.push(force > 0.0 && is_slipping(contact, space, force));
        }
    }

    /// Returns the time until the first open gap closes at its current rate and acceleration; `remaining` if none does.
    fn time_to_touch_down(&self, space: &ContactSpace, remaining: f64) -> f64 {
        let mut time_to_event = remaining;
        for (index, contact) in space.active_contacts.iter().enumerate() {
            if self.buffers.is_touching[index] {
                continue;
            }
            let n = contact.normal;
            let acceleration = space.free[n] + space.contact_acceleration(n, &self.force);
            time_to_event = time_to_event.min(time_to_zero(self.gap[index], self.rate[n], acceleration));
        }
        time_to_event
    }

    /// Advances the motion without contact.
    fn fly(&mut self, space: &ContactSpace, time: f64) {
        for (gap, contact) in self.gap.iter_mut().zip(&space.active_contacts) {
            *gap += time * (self.rate[contact.normal] + 0.5 * time * space.free[contact.normal]);
        }
        for (rate, free) in self.rate.iter_mut().zip(&space.free) {
            *rate += time * free;
        }
        for (state, contact) in self.friction_state.iter_mut().zip(&space.active_contacts) {
            *state = contact.candidate.law_with_state().map_or(*state, |law| law.kind.relaxed(*state, time));
        }
    }

    /// Records touch-downs at the end of a free flight: contacts whose gap is zero within rounding.
    fn record_touch_downs(&mut self, space: &ContactSpace, now: f64) {
        for (index, contact) in space.active_contacts.iter().enumerate() {
            let scale = contact.candidate.gap.abs().max(contact.candidate.law.depth_scale_m() * 1e-9);
            if !self.buffers.is_touching[index] && self.gap[index] <= 1e-9 * scale && self.rate[contact.normal] < 0.0 {
                self.gap[index] = self.gap[index].min(0.0);
                self.push_change(space, index, now, ChangeKind::Closes);
                self.buffers.is_touching[index] = true;
            }
        }
    }

    /// Returns the time in which the fastest closing contact crosses the first fraction of its damper's transition.
    fn first_crossing(&self, space: &ContactSpace, dt: f64) -> f64 {
        let mut shortest = dt;
        for (index, contact) in space.active_contacts.iter().enumerate() {
            let closing = -self.rate[contact.normal];
            if self.buffers.is_touching[index] && closing > 0.0 && !contact.candidate.is_servo() {
                shortest = shortest.min(FIRST_CROSSING * contact.candidate.law.depth_scale_m() / closing);
            }
        }
        shortest
    }

    /// Computes both stages of a sub-step of length h; returns the error of the rates relative to the tolerance.
    fn substep(
        &mut self,
        space: &ContactSpace,
        h: f64,
        remaining: f64,
        tolerance: Tolerance,
        cancellation: &Cancellation,
    ) -> Result<f64, Diverged> {
        self.substeps += 1;
        let Buffers {
            first,
            second,
            first_force,
            first_loss,
            base_rate,
            base_gap,
            base_friction_state,
            base_current,
            error,
            ..
        } = &mut self.buffers;
        let implicit = GAMMA * h;

        first.copy_from_slice(&self.rate);
        let (friction_state, current) = (&self.friction_state, &self.current);
        let stage = Stage { rate: &self.rate, gap: &self.gap, friction_state, current, h: implicit };
        self.iterations += self.work_space.solve(space, &stage, first, cancellation)?;
        first_force.copy_from_slice(&self.work_space.force);
        first_loss.copy_from_slice(&self.work_space.loss);

        let ratio = (1.0 - GAMMA) / GAMMA;
        for i in 0..space.len() {
            base_rate[i] = self.rate[i] + ratio * (first[i] - self.rate[i]);
        }
        for (index, contact) in space.active_contacts.iter().enumerate() {
            base_gap[index] = self.gap[index] + (1.0 - GAMMA) * h * first[contact.normal];
            base_friction_state[index] = self.friction_state[index]
                + ratio * (self.work_space.friction_state[index] - self.friction_state[index]);
            base_current[index] = self.current[index] + ratio * (self.work_space.current[index] - self.current[index]);
        }
        // A better start than the solution of the first stage: its change, from the initial rates of the second.
        for i in 0..space.len() {
            second[i] = base_rate[i] + first[i] - self.rate[i];
        }
        let (friction_state, current) = (base_friction_state, base_current);
        let stage = Stage { rate: base_rate, gap: base_gap, friction_state, current, h: implicit };
        self.iterations += self.work_space.solve(space, &stage, second, cancellation)?;

        // γ h (a₂ − a₁), with the stage accelerations aᵢ; the filter removes components that decay within the sub-step.
        for i in 0..space.len() {
            let (a1, a2) = (first[i] - self.rate[i], second[i] - base_rate[i]);
            error[i] = a2 - a1;
        }
        let relative = relative_error(space, [&self.rate, second, &self.work_space.force], error, tolerance);
        if relative <= 1.0 && h >= remaining {
            return Ok(relative);
        }
        self.work_space.filter(space, implicit, error, cancellation);
        Ok(relative_error(space, [&self.rate, second, &self.work_space.force], error, tolerance))
    }

    /// Returns the fraction of the sub-step after which friction leaves the polynomial range it starts in; `None` if it
    /// stays there, or exceeds the end only within the margin.
    fn fraction_to_range_end(&self, space: &ContactSpace) -> Option<f64> {
        let Buffers { second, .. } = &self.buffers;
        let mut fraction: Option<f64> = None;
        for contact in &space.active_contacts {
            let Some((t, law)) = contact.tangent.zip(contact.candidate.slip_law()) else { continue };
            let of_law = |force: &[f64]| contact.candidate.law_normal(force[contact.normal]);
            let (force_before, force_after) = (of_law(&self.force), of_law(&self.work_space.force));
            if force_before <= 0.0 && force_after <= 0.0 && contact.candidate.powertrain.is_none() {
                continue;
            }
            let (before, after) = (self.rate[t], second[t]);
            let at = |slip: f64| FrictionPoint { slip, state: 0.0, normal: force_after.max(force_before) };
            let range = law.range(at(before));
            let margin = RANGE_MARGIN * law.min_slip_scale_m_s();
            let distance_to_end = law.nominal_margin(range, at(after));
            if distance_to_end < -margin {
                // Target the middle of the margin, assuming constant slip acceleration.
                let distance_before = law.nominal_margin(range, at(before)).max(0.0);
                let candidate =
                    ((distance_before + 0.5 * margin) / (distance_before - distance_to_end)).clamp(0.02, 0.9);
                fraction = Some(fraction.map_or(candidate, |fraction| fraction.min(candidate)));
            }
        }
        fraction
    }

    /// Accepts a sub-step: updates state, impulses, work and extrema.
    fn accept(&mut self, space: &ContactSpace, now: f64, h: f64, remaining: f64) {
        let Buffers {
            impulse: total_impulse, double_integral, first, second, first_force, first_loss, base_gap, ..
        } = &mut self.buffers;
        let second_force = &self.work_space.force;
        // ∫ (end − s) F ds over the whole step: contributions of this sub-step and of the remaining time.
        let remaining_after = remaining - h;
        for i in 0..space.len() {
            let impulse = h * ((1.0 - GAMMA) * first_force[i] + GAMMA * second_force[i]);
            double_integral[i] +=
                h * h * (DOUBLE_INTEGRAL_WEIGHTS[0] * first_force[i] + DOUBLE_INTEGRAL_WEIGHTS[1] * second_force[i])
                    + remaining_after * impulse;
            total_impulse[i] += impulse;
        }
        let work = |i: usize| h * ((1.0 - GAMMA) * first_force[i] * first[i] + GAMMA * second_force[i] * second[i]);
        for (index, contact) in space.active_contacts.iter().enumerate() {
            if let (Some(_), Some(t)) = (&contact.candidate.powertrain, contact.tangent) {
                let losses = [first_loss[index] * first[t], self.work_space.loss[index] * second[t]];
                let loss = h * ((1.0 - GAMMA) * losses[0] + GAMMA * losses[1]);
                self.motor_work += work(t) + loss;
                self.work -= loss;
                self.loss_work[index] += loss;
                continue;
            }
            let total_work = if contact.candidate.is_motor { &mut self.motor_work } else { &mut self.work };
            let n = contact.normal;
            match contact.candidate.element {
                Element::Stop(_) | Element::Contact(_) => *total_work += work(n),
                Element::Servo(_) => {
                    let target_rate = contact.candidate.servo.map_or(0.0, |law| law.target_rate);
                    let impulse = h * ((1.0 - GAMMA) * first_force[n] + GAMMA * second_force[n]);
                    *total_work += work(n) + target_rate * impulse;
                }
                // The normal row of a brake, a motor, a powertrain or a cable does no work.
                Element::Brake(_) | Element::Motor(_) | Element::Powertrain(_) | Element::Cable(_) => {}
            }
            if let (Element::Cable(_), Some(tangent)) = (contact.candidate.element, contact.tangent) {
                self.cable_work += work(tangent);
                self.cable_slope[tangent] = self.work_space.slope(tangent);
            }
            contact.tangent.into_iter().chain(contact.rolling).for_each(|row| *total_work += work(row));
        }
        for (index, contact) in space.active_contacts.iter().enumerate() {
            let n = contact.normal;
            let gap_before = std::mem::replace(&mut self.gap[index], base_gap[index] + GAMMA * h * second[n]);
            let extremum = |after_s, gap, rate: &[f64], force: &[f64], impulse| ContactExtremum {
                after_s,
                gap,
                gap_rate: rate[n],
                slip: contact.tangent.map_or(0.0, |t| rate[t]),
                normal: force[n],
                tangential: contact.tangent.map_or(0.0, |t| force[t]),
                impulse,
            };
            let impulse = h * ((1.0 - GAMMA) * first_force[n] + GAMMA * second_force[n]);
            let (peak, deepest) = (&mut self.peak[index], &mut self.deepest[index]);
            if first_force[n] > peak.normal {
                let (implicit, impulse_at_stage) = (GAMMA * h, total_impulse[n] - impulse + GAMMA * h * first_force[n]);
                *peak =
                    extremum(now + implicit, gap_before + implicit * first[n], first, first_force, impulse_at_stage);
            }
            let end = extremum(now + h, self.gap[index], second, second_force, total_impulse[n]);
            if end.normal > peak.normal {
                *peak = end;
            }
            if end.gap < deepest.gap {
                *deepest = end;
            }
        }
        self.friction_state.copy_from_slice(&self.work_space.friction_state);
        self.current.copy_from_slice(&self.work_space.current);
        self.rate.copy_from_slice(second);
        self.force.copy_from_slice(second_force);
    }

    /// Records the changes since the last call; returns true if a gap has just closed.
    fn record_changes(&mut self, space: &ContactSpace, now: f64) -> bool {
        let mut has_closed = false;
        for (index, contact) in space.active_contacts.iter().enumerate() {
            if contact.candidate.is_servo() {
                continue;
            }
            let (is_touching, is_loaded) = (self.gap[index] <= 0.0, self.force[contact.normal] > 0.0);
            let rounding = GAP_ROUNDING * contact.candidate.law.depth_scale_m();
            if !self.buffers.is_touching[index] && self.gap[index] <= rounding && self.rate[contact.normal] < 0.0 {
                self.push_change(space, index, now, ChangeKind::Closes);
                (self.buffers.is_touching[index], has_closed) = (true, true);
                continue;
            }
            if contact.candidate.has_gap() && contact.candidate.law_with_state().is_some() {
                let is_slipping = is_loaded && self.work_space.is_slipping[index];
                if is_slipping != self.buffers.is_slipping[index] && is_loaded {
                    let kind = if is_slipping { ChangeKind::Slips } else { ChangeKind::Sticks };
                    self.push_change(space, index, now, kind);
                }
                self.buffers.is_slipping[index] = is_slipping;
            }
            if is_loaded != self.buffers.is_loaded[index] {
                let kind = if is_loaded { ChangeKind::Loads } else { ChangeKind::Unloads };
                self.push_change(space, index, now, kind);
                self.buffers.is_loaded[index] = is_loaded;
            }
            if self.buffers.is_touching[index] && !is_touching && !is_loaded {
                self.push_change(space, index, now, ChangeKind::Opens);
                self.buffers.is_touching[index] = false;
            }
        }
        has_closed
    }

    fn push_change(&mut self, space: &ContactSpace, contact: usize, after_s: f64, kind: ChangeKind) {
        let normal = space.active_contacts[contact].normal;
        let (closing, impulse) = (-self.rate[normal], self.buffers.impulse[normal]);
        self.changes.push(Change { after_s, contact, kind, closing, impulse });
        // ∬F ds² up to here, from the one that continues to the end of the step.
        let Buffers { impulse, double_integral, dt, .. } = &self.buffers;
        let integrals = impulse.iter().zip(double_integral);
        let up_to_here = integrals.map(|(impulse, double)| [*impulse, double - (dt - after_s) * impulse]);
        self.integrals_at_changes.extend(up_to_here);
    }
}

/// Whether friction with stiction is at its limit at the start of a step, under this normal force.
fn is_slipping(contact: &ActiveContact, space: &ContactSpace, force: f64) -> bool {
    let tangent = contact.candidate.law_with_state().and(contact.tangent);
    tangent.is_some_and(|t| {
        let force = contact.candidate.law_normal(force);
        contact.candidate.friction_at_step_end([space.rate[t], contact.friction_state, force], 0.0).d_normal != 0.0
    })
}

/// Returns the largest rate error of a contact relative to the tolerance at its speed and to the ranges of its law.
fn relative_error(space: &ContactSpace, [from, rate, force]: [&[f64]; 3], error: &[f64], tolerance: Tolerance) -> f64 {
    let contact_error = |contact: &ActiveContact| {
        let n = contact.normal;
        let Some(t) = contact.tangent else {
            return error[n].abs() / (tolerance.absolute + tolerance.relative * rate[n].abs());
        };
        // A brake or a motor has no gap rate.
        let closing = if contact.candidate.has_gap() { rate[n] } else { 0.0 };
        let allowed = tolerance.absolute + tolerance.relative * hypot(rate[t], closing);
        if let Some(law) = contact.candidate.law_with_state() {
            let max_friction = law.mu_static * contact.candidate.law_normal(force[n]) + MIN_STICTION_N;
            let sticking_tolerance = law.sticking_slip(tolerance.slip * max_friction);
            let is_within = force[t].abs() < max_friction || contact.candidate.cable.is_some();
            let is_sticking = is_within && rate[t].abs() < law.sticking_slip(max_friction);
            let slip_allowed = if is_sticking { sticking_tolerance.min(allowed) } else { allowed };
            return (error[n].abs() / allowed).max(error[t].abs() / slip_allowed);
        }
        let slip = contact.candidate.slip_law().filter(|law| from[t].abs().min(rate[t].abs()) <= law.v_dynamic_m_s);
        let slip_allowed = slip.map_or(allowed, |law| allowed.min(tolerance.slip * law.min_slip_scale_m_s()));
        (error[n].abs() / allowed).max(error[t].abs() / slip_allowed)
    };
    let rolling_error = |contact: &ActiveContact| {
        let row = contact.rolling.zip(contact.candidate.rolling.as_ref());
        row.map_or(0.0, |(row, law)| {
            let allowed = tolerance.absolute + tolerance.relative * rate[row].abs();
            let is_sliding = from[row].abs().min(rate[row].abs()) > law.v_dynamic_m_s;
            let narrow = if is_sliding { f64::INFINITY } else { tolerance.slip * law.min_slip_scale_m_s() };
            error[row].abs() / allowed.min(narrow)
        })
    };
    space.active_contacts.iter().map(|contact| contact_error(contact).max(rolling_error(contact))).fold(0.0, f64::max)
}

/// Returns the smallest positive time at which gap + rate t + ½ acceleration t² is zero; infinite if there is none.
pub(crate) fn time_to_zero(gap: f64, rate: f64, acceleration: f64) -> f64 {
    if gap <= 0.0 {
        return if rate < 0.0 { 0.0 } else { f64::INFINITY };
    }
    let discriminant = rate * rate - 2.0 * acceleration * gap;
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    // Smaller root, without cancellation.
    let time = 2.0 * gap / (-rate + discriminant.sqrt());
    if time > 0.0 { time } else { f64::INFINITY }
}
