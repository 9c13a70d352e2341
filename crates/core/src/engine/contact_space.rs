//! Contact space: the rows in which contact is solved, and their response to impulses; and the correction of the rates
//! of active contacts to the solution of their equations, by impulses along normals and tangents.
//!
//! A stiff damper determines the rate of its contact: within the next step it would remove the fraction h λ/(1 + h λ),
//! λ = W (∂F/∂δ̇ + h ∂F/∂δ), of any rate error. The correction removes that fraction from all rows at once; soft
//! contacts keep their rates, and the scheme its order.

use super::cable;
use super::cancellation::Cancellation;
use super::candidates::{CablePass, ContactCandidate, Element, ZERO_RATE, gap_and_rows_at};
use super::coordinate::{BodyPose, Row, Twist};
use super::linkage::Linkage;
use super::lists::{refill, reset};
use super::plan::Plan;
use super::powertrain::{PlannedPowertrain, PowertrainState};
use super::support::supports;
use super::world::World;
use crate::law::friction_coefficient;
use crate::numeric::dense;
use crate::numeric::elementary::exp;

/// A contact that can become active within the step.
#[derive(Clone, Debug)]
pub struct ActiveContact {
    pub candidate: ContactCandidate,
    /// Index of the normal row.
    pub normal: usize,
    /// Index of the tangent row.
    pub tangent: Option<usize>,
    /// Index of the row of rolling resistance.
    pub rolling: Option<usize>,
    /// Internal state of friction at the start of the step.
    pub friction_state: f64,
    /// Current of the motor of a powertrain at the start of the step.
    pub current: f64,
    /// Place among the friction of its cable.
    pub cable: Option<CablePlace>,
}

/// Place of the friction of a cable on a circle.
#[derive(Clone, Copy, Debug)]
pub struct CablePlace {
    /// Whether it is the first one of the cable.
    is_first: bool,
    /// Normal row of the spring of the cable.
    spring: Option<usize>,
}

impl ActiveContact {
    /// Indices of all rows.
    pub(crate) fn rows(&self) -> impl Iterator<Item = usize> {
        std::iter::once(self.normal).chain(self.tangent).chain(self.rolling)
    }
}

/// Inverse inertia W, free acceleration and rate of every row, frozen at the start of one step.
#[derive(Clone, Debug, Default)]
pub struct ContactSpace {
    pub active_contacts: Vec<ActiveContact>,
    pub rows: Vec<Row>,
    /// Number of rows that impulses act on. Rows with a prescribed normal force follow them and are not part of `w`.
    pub coupled: usize,
    /// Inverse inertia in contact space, including the joints, for the coupled rows. Row by row, it is the rate of row
    /// i per unit impulse along row j.
    pub w: Vec<f64>,
    /// Acceleration of every row in the absence of contact forces.
    pub free: Vec<f64>,
    /// Rate of every row at the start of the step.
    pub rate: Vec<f64>,
    /// For each row, the rate that changes the gap by its rounding error within the step. Smaller rates are rounding
    /// errors.
    pub rate_resolution: Vec<f64>,
    /// Velocity response M⁻¹ (c + Jᵀ λ) to a unit impulse along each coupled row, body by body.
    response: Vec<Twist>,
    /// Impulse on each support per unit impulse along each coupled row, acting directly and through joints; row by row.
    pub on_supports: Vec<Twist>,
    poses: Vec<BodyPose>,
}

impl ContactSpace {
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Selects the candidates that can become active within `dt`, according to gap, rate and acceleration with a
    /// margin. Returns false if `keep_running` returns false; the space is then incomplete.
    #[allow(clippy::too_many_arguments)]
    pub fn assemble(
        &mut self,
        world: &World,
        plan: &Plan,
        linkage: &mut Linkage,
        (candidates, friction_states, currents): (&[ContactCandidate], &[f64], &[f64]),
        velocities: &[Twist],
        accelerations: &[Twist],
        dt: f64,
        keep_running: &dyn Fn() -> bool,
    ) -> bool {
        self.active_contacts.clear();
        self.rows.clear();
        for candidate in candidates.iter().filter(|candidate| candidate.uses_contact_law) {
            let (rate, free) = (candidate.normal_row.rate(velocities), candidate.normal_row.rate(accelerations));
            if candidate.has_gap() && candidate.gap > CLOSING_MARGIN * dt * (rate.abs() + dt * free.abs()) {
                continue;
            }
            let mut push = |row: &Row| {
                self.rows.push(row.clone());
                self.rows.len() - 1
            };
            let normal = if candidate.has_prescribed_normal() { PENDING } else { push(&candidate.normal_row) };
            let tangent = candidate.has_tangent().then(|| push(&candidate.slip_row));
            let rolling = candidate.rolling.map(|_| push(&candidate.roll_row));
            let friction_state = friction_states.get(candidate.index).copied().unwrap_or(0.0);
            let current = match candidate.element {
                Element::Powertrain(index) => currents[index],
                _ => 0.0,
            };
            let cable = match candidate.element {
                Element::Cable(index) => Some(self.cable_place(plan, index)),
                _ => None,
            };
            self.active_contacts.push(ActiveContact {
                candidate: candidate.clone(),
                normal,
                tangent,
                rolling,
                friction_state,
                current,
                cable,
            });
        }
        self.coupled = self.rows.len();
        for contact in self.active_contacts.iter_mut().filter(|contact| contact.normal == PENDING) {
            contact.normal = self.rows.len();
            self.rows.push(contact.candidate.normal_row.clone());
        }
        if self.rows.is_empty() {
            return true;
        }
        reset(&mut self.rate_resolution, self.rows.len(), 0.0);
        for contact in &self.active_contacts {
            contact.rows().for_each(|row| self.rate_resolution[row] = contact.candidate.rounding / dt);
        }
        refill(&mut self.rate, self.rows.iter().map(|row| row.rate(velocities)));
        refill(&mut self.free, self.rows.iter().map(|row| row.rate(accelerations)));
        for contact in self.active_contacts.iter().filter(|contact| !contact.candidate.has_gap()) {
            let ([rate, acceleration], n) = (contact.candidate.prescribed_gap_motion, contact.normal);
            (self.rate[n], self.free[n]) = match contact.candidate.element {
                Element::Servo(_) => (self.rate[n] - rate, self.free[n] - acceleration),
                Element::Powertrain(_) if !contact.candidate.has_prescribed_normal() => {
                    (self.rate[n] - rate, self.free[n] - acceleration)
                }
                _ => (rate, acceleration),
            };
        }
        self.add_curvature(world, plan, linkage, velocities, dt);
        let on_supports = &mut self.on_supports;
        on_supports.clear();
        respond(
            self.rows[..self.coupled].iter(),
            linkage,
            velocities.len(),
            &mut self.response,
            &mut self.w,
            &Cancellation::new(keep_running),
            |row, linkage| {
                on_supports.extend(supports(plan).map(|support| support.reaction(linkage, row.sides().copied())));
            },
        )
    }

    /// Place of the friction of a cable among the contacts so far.
    fn cable_place(&self, plan: &Plan, index: usize) -> CablePlace {
        let tendon = plan.cable_frictions[index].tendon;
        let is_first = self.active_contacts.last().is_none_or(|last| match last.candidate.element {
            Element::Cable(before) => plan.cable_frictions[before].tendon != tendon,
            _ => true,
        });
        let spring = plan.tendons[tendon].stop.and_then(|stop| Some(self.find(stop)?.1.normal));
        CablePlace { is_first, spring }
    }

    /// Adds the effect of curved surfaces and rotating normals, which the row accelerations do not contain, to the
    /// second derivative of the gap and the first of the slip. It is evaluated from the gap and the slip at the poses
    /// that the current velocities lead to. Accelerations are left out, because an active contact prevents its bodies
    /// from reaching those poses.
    fn add_curvature(&mut self, world: &World, plan: &Plan, linkage: &Linkage, velocities: &[Twist], dt: f64) {
        // The interval is long enough to avoid rounding errors and short enough to be local.
        let interval_s = dt.max(MIN_CURVATURE_STEP_S);
        refill(&mut self.poses, linkage.poses.iter().zip(velocities).map(|(pose, v)| pose.after(interval_s, v)));
        for contact in &self.active_contacts {
            if let Element::Powertrain(index) = contact.candidate.element {
                let PlannedPowertrain { shaft, measured, .. } = &plan.powertrains[index];
                let rows = [(Some(contact.normal), measured.as_ref()), (contact.tangent, Some(shaft))];
                for (row, coordinate) in rows.into_iter().filter_map(|(row, coordinate)| row.zip(coordinate)) {
                    self.free[row] += coordinate.second_rate(&linkage.poses, velocities);
                }
                continue;
            }
            let (row, coordinate) = match (contact.candidate.element, contact.tangent) {
                (Element::Stop(index), _) => (contact.normal, &plan.stops[index].gap),
                (Element::Servo(index), _) => (contact.normal, &plan.servos[index].coordinate),
                (Element::Motor(index), Some(tangent)) => (tangent, &plan.motors[index].shaft),
                (Element::Brake(index), Some(tangent)) => (tangent, &plan.brakes[index].shaft),
                (Element::Cable(index), Some(tangent)) => {
                    let friction = &plan.cable_frictions[index];
                    let tendon = &plan.tendons[friction.tendon];
                    let state = (&linkage.poses[..], velocities);
                    self.free[tangent] += cable::slip_rate(&tendon.circles, friction.circle, &tendon.far, state);
                    continue;
                }
                _ => continue,
            };
            self.free[row] += coordinate.second_rate(&linkage.poses, velocities);
        }
        for contact in self.active_contacts.iter().filter(|contact| contact.candidate.is_between_surfaces()) {
            let candidate = &contact.candidate;
            let (gap, [_, slip_row]) = gap_and_rows_at(candidate, world, plan, &self.poses)
                .unwrap_or_else(|| (candidate.gap, [candidate.normal_row.clone(), candidate.slip_row.clone()]));
            let linear_gap = candidate.gap + interval_s * self.rate[contact.normal];
            let curvature = gap - linear_gap;
            // For surfaces in persistent contact at zero gap, the predicted gap is rounding error.
            if candidate.gap != 0.0 || curvature.abs() > candidate.rounding {
                self.free[contact.normal] += 2.0 * curvature / (interval_s * interval_s);
            }
            if let Some(tangent) = contact.tangent {
                self.free[tangent] += (slip_row.rate(velocities) - self.rate[tangent]) / interval_s;
            }
        }
    }

    /// Returns the contact whose candidate has this element index, preceded by its position in the list of contacts.
    pub fn find(&self, index: usize) -> Option<(usize, &ActiveContact)> {
        self.active_contacts.iter().enumerate().find(|(_, contact)| contact.candidate.index == index)
    }

    /// Whether the surfaces of a contact approach at the start of the step, or are at rest there and about to approach.
    pub fn is_closing(&self, contact: &ActiveContact) -> bool {
        let rate = self.rate[contact.normal];
        rate < -ZERO_RATE || (rate <= ZERO_RATE && self.free[contact.normal] < 0.0)
    }

    /// Inverse of the effective mass for a coupled row.
    pub fn inverse_mass(&self, row: usize) -> f64 {
        self.w[row * (self.coupled + 1)]
    }

    /// Acceleration of a coupled row due to the forces along all rows.
    pub(crate) fn contact_acceleration(&self, row: usize, force: &[f64]) -> f64 {
        self.w[row * self.coupled..(row + 1) * self.coupled].iter().zip(force).map(|(w, force)| w * force).sum()
    }

    /// Adds the velocities of all bodies due to impulses along the rows.
    pub(crate) fn add_responses(&self, impulses: impl Iterator<Item = f64>, velocities: &mut [Twist]) {
        for (response, impulse) in self.response.chunks_exact(velocities.len()).zip(impulses) {
            add_scaled(response, impulse, velocities);
        }
    }

    /// Adds the generalised impulses on every body due to impulses along all rows, including joint reactions.
    pub(crate) fn add_impulses(&self, linkage: &Linkage, impulses: &[f64], out: &mut [Twist]) {
        let responses = self.response.chunks_exact(out.len()).zip(impulses);
        for (response, size) in responses.filter(|(_, size)| **size != 0.0) {
            for ((impulse, v), inertia) in out.iter_mut().zip(response).zip(&linkage.inertias) {
                impulse[0] += size * inertia.mass * v[0];
                impulse[1] += size * inertia.mass * v[1];
                impulse[2] += size * inertia.inertia * v[2];
            }
        }
    }
}

/// Adds a multiple of the velocity response of all bodies.
fn add_scaled(response: &[Twist], impulse: f64, velocities: &mut [Twist]) {
    for (v, change) in velocities.iter_mut().zip(response) {
        for axis in 0..3 {
            v[axis] += impulse * change[axis];
        }
    }
}

/// Computes the velocity response to a unit impulse along each row, body by body, and from it W row by row. Returns false
/// if the computation is cancelled.
fn respond<'a>(
    rows: impl ExactSizeIterator<Item = &'a Row> + Clone,
    linkage: &mut Linkage,
    bodies: usize,
    response: &mut Vec<Twist>,
    w: &mut Vec<f64>,
    cancellation: &Cancellation,
    mut after: impl FnMut(&Row, &Linkage),
) -> bool {
    let count = rows.len();
    reset(response, count * bodies, [0.0; 3]);
    reset(w, count * count, 0.0);
    for (j, (response, row)) in response.chunks_exact_mut(bodies).zip(rows.clone()).enumerate() {
        linkage.respond_to_unit(row, response);
        after(row, linkage);
        for (i, row) in rows.clone().enumerate() {
            w[i * count + j] = row.rate(response);
        }
        if !cancellation.add_work(ROW_WORK * count) {
            return false;
        }
    }
    true
}

/// Work of one entry of W, in multiplications: the rate of a row between two bodies, and the search for its response.
const ROW_WORK: usize = 12;

/// Index of a normal row before it is known how many rows are coupled.
const PENDING: usize = usize::MAX;
/// A candidate is included if its gap is below this many times its free closing distance in a step.
const CLOSING_MARGIN: f64 = 1.5;
/// Shortest interval for the evaluation of curvature, s.
const MIN_CURVATURE_STEP_S: f64 = 1e-7;

#[derive(Clone, Debug)]
pub(crate) struct CorrectedRow {
    /// Index of the row in the contact space.
    pub index: usize,
    pub row: Row,
    pub target: f64,
    /// Impulse along the row that may be removed.
    pub removable: f64,
    /// Derivative of the force times h: h (∂F/∂δ̇ + h ∂F/∂δ) for a normal row, h F ∂μ/∂v for a tangent row.
    pub stiffness: f64,
    /// Coupling of a tangent row to the impulse along the preceding normal row: the friction coefficient μ.
    pub friction_coupling: f64,
}

/// Rows to correct, and the impulses along them.
#[derive(Clone, Debug, Default)]
pub(crate) struct RateCorrection {
    pub rows: Vec<CorrectedRow>,
    response: Vec<Twist>,
    w: Vec<f64>,
    /// Rates before the correction.
    rates: Vec<f64>,
    impulses: Vec<f64>,
}

impl RateCorrection {
    /// Returns the correction impulses, each with its row of the contact space.
    pub fn impulses(&self) -> impl Iterator<Item = (usize, f64)> {
        self.rows.iter().map(|row| row.index).zip(self.impulses.iter().copied())
    }

    /// Solves for the impulses and applies them to the velocities. Returns false if the computation is cancelled.
    pub fn solve(&mut self, linkage: &mut Linkage, velocities: &mut [Twist], cancellation: &Cancellation) -> bool {
        let (count, bodies) = (self.rows.len(), velocities.len());
        self.impulses.clear();
        if count == 0 {
            return true;
        }
        let rows = self.rows.iter().map(|row| &row.row);
        if !respond(rows, linkage, bodies, &mut self.response, &mut self.w, cancellation, |_, _| ()) {
            return false;
        }
        // (1 + D W) p = D (target − u), with the stiffness D of each row; tangent rows add −μ times the normal impulse.
        refill(&mut self.rates, self.rows.iter().map(|row| row.row.rate(velocities)));
        self.impulses.extend(self.rates.iter().zip(&self.rows).map(|(rate, row)| row.target - rate));
        for (i, (matrix_row, row)) in self.w.chunks_exact_mut(count).zip(&self.rows).enumerate() {
            self.impulses[i] *= row.stiffness;
            matrix_row.iter_mut().for_each(|w| *w *= row.stiffness);
            matrix_row[i] += 1.0;
            if row.friction_coupling != 0.0 {
                matrix_row[i - 1] += row.friction_coupling;
            }
        }
        if !dense::solve(&mut self.w, &mut self.impulses, count, |work| cancellation.add_work(work)) {
            self.impulses.fill(0.0);
            return cancellation.add_work(0);
        }
        for j in 0..count {
            let impulse = self.impulses[j].max(-self.rows[j].removable);
            let clamped = impulse - self.impulses[j];
            self.impulses[j] = impulse;
            // If the normal impulse is clamped, its friction is reduced accordingly.
            if let Some(row) = self.rows.get(j + 1).filter(|row| row.friction_coupling != 0.0) {
                self.impulses[j + 1] -= row.friction_coupling * clamped;
            }
            add_scaled(&self.response[j * bodies..(j + 1) * bodies], impulse, velocities);
        }
        true
    }

    /// Returns the index of each corrected row of the contact space and the work of its impulse on the bodies: the
    /// impulse times the mean of the rates before and after the impulse.
    pub(crate) fn impulse_work(&self, velocities: &[Twist]) -> impl Iterator<Item = (usize, f64)> {
        let mean = |(row, before): (&CorrectedRow, &f64)| 0.5 * (before + row.row.rate(velocities));
        let means = self.rows.iter().zip(&self.rates).map(mean);
        let works = means.zip(&self.impulses).map(|(rate, impulse)| rate * impulse);
        self.rows.iter().map(|row| row.index).zip(works)
    }
}

/// Largest relative residual of a solution.
const MAX_RESIDUAL: f64 = 1e-9;
/// Fraction of its terms below which a residual is rounding error.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Smallest force scale of friction with stiction, N. Without it, the residual of a contact with a vanishing normal force
/// would be dominated by rounding errors, such as slip rates of 1e-26 m/s.
const MIN_FORCE_SCALE_N: f64 = 1.0;
/// Fraction of the rate resolution below which a residual is ignored: a row of discs transmits rates of 1e-30 m/s.
const MIN_RATE_SCALE: f64 = 1e-9;
/// Largest number of Newton iterations.
const MAX_ITERATIONS: u32 = 30;
/// Largest number of halvings of a Newton step in the line search.
const MAX_HALVINGS: u32 = 12;
/// Work of an evaluation or a Jacobian per entry of W, in multiplications.
const EVALUATION_WORK: usize = 4;

/// Initial values of a stage of the implicit method.
pub struct Stage<'a> {
    /// Rates ũ for h = 0.
    pub rate: &'a [f64],
    /// Gaps g̃ for h = 0, one per contact.
    pub gap: &'a [f64],
    /// Internal states of friction, one per contact.
    pub friction_state: &'a [f64],
    /// Currents of powertrains, one per contact.
    pub current: &'a [f64],
    pub h: f64,
}

/// Solver of one implicit stage, with arrays sized once per contact space: finds the rates at which the forces of the
/// contact laws agree with the resulting motion, u = ũ + h (b + W F(g̃ + h u_n, u)), with the laws F including clamp
/// and friction. Newton's method uses the exact Jacobian; a step that does not reduce the residual is halved. The
/// residual of every solution, relative to the terms of the equation, is below [`MAX_RESIDUAL`]. If no solution is
/// found, the caller shortens h; for h → 0 the equation becomes u = ũ, so a solution exists for small h.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
    residual: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    jacobian: Vec<f64>,
    /// ∂F/∂u: derivative of each row's force by its own rate.
    diagonal_derivative: Vec<f64>,
    /// Derivative of the force of each tangent row by the normal rate.
    cross_derivative: Vec<f64>,
    /// Force magnitudes that determine the rounding error of the forces.
    force_scale: Vec<f64>,
    /// Derivatives of the force of a tangent row by the rate of another row, for the friction of cables.
    cable_derivatives: Vec<(usize, usize, f64)>,
    pub force: Vec<f64>,
    /// Internal states of friction at the solution, one per contact.
    pub friction_state: Vec<f64>,
    /// Currents and losses of powertrains at the solution, one per contact.
    pub current: Vec<f64>,
    pub loss: Vec<f64>,
    /// For each contact, whether its friction with stiction slips.
    pub is_slipping: Vec<bool>,
}

/// No solution was found within the allowed iterations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Diverged {
    pub residual: f64,
}

impl Workspace {
    /// Resizes all arrays for a contact space.
    pub fn resize(&mut self, rows: usize, contacts: usize) {
        for list in [&mut self.friction_state, &mut self.current, &mut self.loss] {
            reset(list, contacts, 0.0);
        }
        reset(&mut self.is_slipping, contacts, false);
        reset(&mut self.jacobian, rows * rows, 0.0);
        let Self { residual, step, trial, diagonal_derivative, cross_derivative, force_scale, force, .. } = self;
        for list in [residual, step, trial, diagonal_derivative, cross_derivative, force_scale, force] {
            reset(list, rows, 0.0);
        }
    }

    /// Solves a stage and returns the number of iterations. On entry, `rate` is the initial guess; on return, it is the
    /// solution, and `self.force` contains the forces there. Fails if the iteration does not converge, or if it is
    /// cancelled.
    pub fn solve(
        &mut self,
        space: &ContactSpace,
        stage: &Stage,
        rate: &mut [f64],
        cancellation: &Cancellation,
    ) -> Result<u32, Diverged> {
        // Prescribed normal forces follow from the time alone.
        let starts = stage.rate.iter().zip(&space.free);
        for (rate, (start, free)) in rate.iter_mut().zip(starts).skip(space.coupled) {
            *rate = start + stage.h * free;
        }
        // Compile-time sizes are faster; contact spaces are small.
        match space.coupled {
            1 => self.iterate(space, stage, rate, 1, None),
            2 => self.iterate(space, stage, rate, 2, None),
            3 => self.iterate(space, stage, rate, 3, None),
            4 => self.iterate(space, stage, rate, 4, None),
            5 => self.iterate(space, stage, rate, 5, None),
            6 => self.iterate(space, stage, rate, 6, None),
            8 => self.iterate(space, stage, rate, 8, None),
            10 => self.iterate(space, stage, rate, 10, None),
            12 => self.iterate(space, stage, rate, 12, None),
            14 => self.iterate(space, stage, rate, 14, None),
            rows => self.iterate(space, stage, rate, rows, Some(cancellation)),
        }
    }

    /// Newton's method with step halving, for the coupled rows.
    #[inline(always)]
    fn iterate(
        &mut self,
        space: &ContactSpace,
        stage: &Stage,
        rate: &mut [f64],
        rows: usize,
        cancellation: Option<&Cancellation>,
    ) -> Result<u32, Diverged> {
        // Of an evaluation or of a Jacobian.
        let is_cancelled =
            || cancellation.is_some_and(|cancellation| !cancellation.add_work(EVALUATION_WORK * rows * rows));
        let mut residual = self.evaluate(space, stage, rate, rows);
        for iteration in 0..MAX_ITERATIONS {
            if residual <= MAX_RESIDUAL {
                return Ok(iteration);
            }
            self.assemble_jacobian(space, stage.h, rows);
            self.step.copy_from_slice(&self.residual);
            let (jacobian, step) = (&mut self.jacobian[..rows * rows], &mut self.step[..rows]);
            let add_work = |work| cancellation.is_none_or(|cancellation| cancellation.add_work(work));
            if is_cancelled() || !dense::eliminate(jacobian, step, rows, add_work) {
                break;
            }
            let before = residual;
            let mut fraction = 1.0;
            for _ in 0..MAX_HALVINGS {
                for ((trial, rate), step) in self.trial.iter_mut().zip(&*rate).zip(&self.step) {
                    *trial = rate - fraction * step;
                }
                let trial = std::mem::take(&mut self.trial);
                residual = self.evaluate(space, stage, &trial, rows);
                self.trial = trial;
                if residual < before || before <= MAX_RESIDUAL || is_cancelled() {
                    break;
                }
                fraction *= 0.5;
            }
            if residual < before {
                rate.copy_from_slice(&self.trial);
                continue;
            }
            // No further progress: rounding, or a kink that Newton's method cannot pass.
            residual = self.evaluate(space, stage, rate, rows);
            if residual <= MAX_RESIDUAL {
                return Ok(iteration);
            }
            break;
        }
        if residual <= MAX_RESIDUAL { Ok(MAX_ITERATIONS) } else { Err(Diverged { residual }) }
    }

    /// Filters an error: e ← (1 − h W ∂F/∂u)⁻¹ e, evaluated at the last solution.
    pub fn filter(&mut self, space: &ContactSpace, h: f64, error: &mut [f64], cancellation: &Cancellation) {
        self.assemble_jacobian(space, h, space.coupled);
        dense::solve(&mut self.jacobian, error, space.coupled, |work| cancellation.add_work(work));
    }

    /// Evaluates forces and their derivatives; returns the residual relative to the terms of the equation.
    #[inline(always)]
    fn evaluate(&mut self, space: &ContactSpace, stage: &Stage, rate: &[f64], rows: usize) -> f64 {
        let h = stage.h;
        self.cable_derivatives.clear();
        let mut strand = CableStrand::default();
        for (index, contact) in space.active_contacts.iter().enumerate() {
            let n = contact.normal;
            let gap = stage.gap[index] + h * rate[n];
            if let Some((powertrain, t)) = contact.candidate.powertrain.as_ref().zip(contact.tangent) {
                let state = PowertrainState { bristle: stage.friction_state[index], current: stage.current[index] };
                let found = powertrain.step(gap, [rate[n], rate[t]], state, h);
                (self.force[n], self.diagonal_derivative[n], self.force_scale[n]) = (0.0, 0.0, 0.0);
                (self.force[t], self.diagonal_derivative[t]) = (found.effort, found.d_rate);
                self.cross_derivative[t] = found.d_gap_rate;
                self.force_scale[t] = found.effort.abs() + 2.0 * found.loss.abs() + found.d_rate.abs() * rate[t].abs();
                (self.friction_state[index], self.current[index]) = (found.state.bristle, found.state.current);
                self.loss[index] = found.loss;
                continue;
            }
            let law = contact.candidate.normal_force(gap, rate[n]);
            // The law uses penetration, the row uses the gap.
            let slope = -(h * law.d_delta + law.d_rate);
            (self.force[n], self.diagonal_derivative[n]) = (law.force, slope);
            self.force_scale[n] = law.force.abs();
            if let Some((place, pass)) = contact.cable.zip(contact.candidate.cable) {
                self.add_cable_friction(contact, (place, pass), (rate, stage.friction_state[index], h), &mut strand);
                self.friction_state[index] = strand.state;
                self.is_slipping[index] = strand.is_slipping;
                continue;
            }
            if let Some(t) = contact.tangent {
                let state = stage.friction_state[index];
                let friction = contact.candidate.friction_at_step_end([rate[t], state, law.force], h);
                self.force[t] = -friction.force;
                self.force_scale[t] = match contact.candidate.law_with_state() {
                    Some(law) => {
                        self.is_slipping[index] = friction.d_normal != 0.0;
                        friction.force.abs().max(law.state_force(state)).max(MIN_FORCE_SCALE_N)
                    }
                    None => {
                        let slip_scale = contact.candidate.motor.map_or(0.0, |motor| 1.0 + motor.slope * rate[t].abs());
                        law.force.abs() * friction.d_normal.abs().max(1.0).max(slip_scale)
                    }
                };
                self.diagonal_derivative[t] = -friction.d_slip;
                self.cross_derivative[t] = -friction.d_normal * slope;
                self.friction_state[index] = friction.state;
            }
            if let Some((r, rolling)) = contact.rolling.zip(contact.candidate.rolling.as_ref()) {
                let (arm, arm_slope) = friction_coefficient(rolling, rate[r]);
                self.force[r] = -arm * law.force;
                self.force_scale[r] = rolling.mu_static * law.force.abs();
                self.diagonal_derivative[r] = -arm_slope * law.force;
                self.cross_derivative[r] = -arm * slope;
            }
        }
        let mut largest: f64 = 0.0;
        for (i, w) in space.w.chunks_exact(rows).enumerate() {
            let mut contact_acceleration = 0.0;
            for (w, force) in w.iter().zip(&self.force) {
                contact_acceleration += w * force;
            }
            let (final_rate, initial_rate, free) = (rate[i], stage.rate[i], space.free[i]);
            let scale = (final_rate.abs() + initial_rate.abs() + h * (free.abs() + contact_acceleration.abs()))
                .max(MIN_RATE_SCALE * space.rate_resolution.get(i).copied().unwrap_or(0.0));
            self.residual[i] = final_rate - initial_rate - h * (free + contact_acceleration);
            // Opposite forces can cancel, and the friction coefficient has an absolute rounding error: the remainder,
            // or a slip rate of 1e-17 m/s, has no significant digits.
            let (size, terms) = (self.residual[i].abs(), w.iter().zip(&self.force_scale));
            let rounding = |terms: f64| ROUNDING * (final_rate.abs() + initial_rate.abs() + h * (free.abs() + terms));
            if size > largest * scale && size > rounding(terms.map(|(w, force_scale)| w.abs() * force_scale).sum()) {
                largest = size / scale;
            }
        }
        // A NaN force must not pass as a small residual.
        if self.residual.iter().all(|r| r.is_finite()) { largest } else { f64::INFINITY }
    }

    /// Assembles the Jacobian 1 − h W ∂F/∂u.
    #[inline(always)]
    fn assemble_jacobian(&mut self, space: &ContactSpace, h: f64, rows: usize) {
        let (w, jacobian) = (&space.w[..rows * rows], &mut self.jacobian[..rows * rows]);
        let columns = |column: usize, other: usize| (0..rows).map(move |row| (row * rows + column, row * rows + other));
        for contact in &space.active_contacts {
            let n = contact.normal;
            if n < rows {
                let derivative = self.diagonal_derivative[n];
                columns(n, n).for_each(|(at, _)| jacobian[at] = -h * w[at] * derivative);
            }
            for t in contact.tangent.into_iter().chain(contact.rolling) {
                let (cross, derivative) = (self.cross_derivative[t], self.diagonal_derivative[t]);
                if n < rows {
                    columns(n, t).for_each(|(at, from)| jacobian[at] -= h * w[from] * cross);
                }
                columns(t, t).for_each(|(at, _)| jacobian[at] = -h * w[at] * derivative);
            }
        }
        for &(t, other, derivative) in &self.cable_derivatives {
            columns(other, t).for_each(|(at, from)| jacobian[at] -= h * w[from] * derivative);
        }
        jacobian.iter_mut().step_by(rows + 1).for_each(|diagonal| *diagonal += 1.0);
    }

    /// Adds the friction of a cable on a circle, which reduces the tension of the strand before it: the force against its slip
    /// is the difference of both tensions.
    fn add_cable_friction(
        &mut self,
        contact: &ActiveContact,
        (place, pass): (CablePlace, CablePass),
        (rate, state, h): (&[f64], f64, f64),
        strand: &mut CableStrand,
    ) {
        let Some(t) = contact.tangent else { return };
        if place.is_first {
            let spring = place.spring.map_or(0.0, |spring| self.force[spring]);
            strand.first = (self.force[contact.normal] - pass.offset_n).max(0.0) + spring;
            strand.ratio = 1.0;
            strand.slopes.clear();
        }
        let friction = contact.candidate.friction_at_step_end([rate[t], state, 1.0], h);
        let kept = exp(-friction.force * pass.turn);
        let lost = strand.ratio * (1.0 - kept);
        self.force[t] = -strand.first * lost;
        self.force_scale[t] = strand.first.max(MIN_FORCE_SCALE_N);
        let slope = pass.turn * friction.d_slip;
        self.diagonal_derivative[t] = -strand.first * strand.ratio * kept * slope;
        self.cross_derivative[t] = 0.0;
        if let Some(spring) = place.spring {
            self.cable_derivatives.push((t, spring, -lost * self.diagonal_derivative[spring]));
        }
        let before = strand.slopes.iter().map(|(row, slope)| (t, *row, strand.first * lost * slope));
        self.cable_derivatives.extend(before);
        strand.slopes.push((t, slope));
        strand.ratio *= kept;
        (strand.state, strand.is_slipping) = (friction.state, friction.d_normal != 0.0);
    }

    /// Derivative of the force of a row by its own rate, at the last evaluation.
    pub fn slope(&self, row: usize) -> f64 {
        self.diagonal_derivative[row]
    }
}

/// A strand of a cable with friction, in the order of its circles.
#[derive(Default)]
struct CableStrand {
    /// Tension of the first strand, and the ratio of that of this strand to it.
    first: f64,
    ratio: f64,
    /// Rows of the friction before the strand, and the derivatives of the logarithms of its ratio by their rates, negative.
    slopes: Vec<(usize, f64)>,
    /// Internal state of the last friction, and whether it slips.
    state: f64,
    is_slipping: bool,
}
