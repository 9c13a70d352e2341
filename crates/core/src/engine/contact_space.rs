//! Contact space: the rows in which contact is solved, and their response to impulses; and the correction of the rates of
//! active contacts to the solution of their equations, by impulses along normals and tangents.
//!
//! A stiff damper determines the rate of its contact: within the next step it would remove the fraction h λ/(1 + h λ),
//! λ = W (∂F/∂δ̇ + h ∂F/∂δ), of any rate error. The correction removes that fraction from all rows at once; soft
//! contacts keep their rates, and the scheme its order.

use super::candidates::{ContactCandidate, Row, ZERO_RATE, gap_and_slip_row_at};
use super::dense::{self, refill, reset};
use super::linkage::{BodyPose, Linkage, Twist};
use super::plan::Plan;
use super::world::World;
use crate::numeric::elementary::sin_cos;

/// A contact that can become active within the step.
#[derive(Clone, Copy, Debug)]
pub struct ActiveContact {
    pub candidate: ContactCandidate,
    /// Index of the normal row.
    pub normal: usize,
    /// Index of the tangent row, which follows the normal row.
    pub tangent: Option<usize>,
    /// Bristle state σ at the start of the step.
    pub bristle_state: f64,
}

/// W and the free motion of every row, frozen at the start of one step.
#[derive(Clone, Debug, Default)]
pub struct ContactSpace {
    pub active_contacts: Vec<ActiveContact>,
    pub rows: Vec<Row>,
    /// Contact-space inverse inertia including joints, row by row: rate of row i per unit impulse along row j.
    pub w: Vec<f64>,
    /// Acceleration of every row without contact.
    pub free: Vec<f64>,
    /// Rate of every row at the start of the step.
    pub rate: Vec<f64>,
    /// Rates that change a gap by its rounding error within the step; smaller rates are rounding.
    pub rate_resolution: Vec<f64>,
    /// Velocity response M⁻¹ (c + Jᵀ λ) to a unit impulse along each row, body by body.
    response: Vec<Twist>,
    poses: Vec<BodyPose>,
}

impl ContactSpace {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Selects the candidates that can become active within `dt`, from gap, rate and acceleration with a margin.
    #[allow(clippy::too_many_arguments)]
    pub fn assemble(
        &mut self,
        world: &World,
        plan: &Plan,
        linkage: &mut Linkage,
        (candidates, bristle_states): (&[ContactCandidate], &[f64]),
        velocities: &[Twist],
        accelerations: &[Twist],
        dt: f64,
    ) {
        self.active_contacts.clear();
        self.rows.clear();
        for candidate in candidates.iter().filter(|candidate| candidate.uses_contact_law) {
            let (rate, free) = (candidate.normal_row.rate(velocities), candidate.normal_row.rate(accelerations));
            if candidate.gap > CLOSING_MARGIN * dt * (rate.abs() + dt * free.abs()) {
                continue;
            }
            let normal = self.rows.len();
            self.rows.push(candidate.normal_row);
            let tangent = candidate.has_tangent().then(|| {
                self.rows.push(candidate.slip_row);
                normal + 1
            });
            let bristle_state = bristle_states.get(candidate.index).copied().unwrap_or(0.0);
            self.active_contacts.push(ActiveContact { candidate: *candidate, normal, tangent, bristle_state });
        }
        if self.rows.is_empty() {
            return;
        }
        let rows_with_rounding = self.active_contacts.iter().flat_map(|contact| {
            std::iter::once(contact.normal).chain(contact.tangent).map(|_| contact.candidate.rounding / dt)
        });
        refill(&mut self.rate_resolution, rows_with_rounding);
        refill(&mut self.rate, self.rows.iter().map(|row| row.rate(velocities)));
        refill(&mut self.free, self.rows.iter().map(|row| row.rate(accelerations)));
        for contact in self.active_contacts.iter().filter(|contact| !contact.candidate.has_gap()) {
            let [rate, acceleration] = contact.candidate.prescribed_gap_motion;
            (self.rate[contact.normal], self.free[contact.normal]) = (rate, acceleration);
        }
        self.add_curvature(world, plan, linkage, velocities, dt);
        respond(self.rows.iter(), linkage, velocities.len(), &mut self.response, &mut self.w);
    }

    /// Adds the effect of curved surfaces and rotating normals, which the row accelerations do not contain, to the
    /// second derivative of the gap and the first of the slip. It is evaluated from the gap and the slip at the poses
    /// that the current velocities lead to. Accelerations are left out, because an active contact prevents its bodies
    /// from reaching those poses.
    fn add_curvature(&mut self, world: &World, plan: &Plan, linkage: &Linkage, velocities: &[Twist], dt: f64) {
        // The interval is long enough to avoid rounding errors and short enough to be local.
        let interval_s = dt.max(MIN_CURVATURE_STEP_S);
        let pose_after_interval = |(pose, v): (&BodyPose, &Twist)| {
            let angle = pose.angle + interval_s * v[2];
            let (sin, cos) = sin_cos(angle);
            let com = [pose.com[0] + interval_s * v[0], pose.com[1] + interval_s * v[1]];
            BodyPose { com, direction: [cos, sin], angle }
        };
        refill(&mut self.poses, linkage.poses.iter().zip(velocities).map(pose_after_interval));
        for contact in self.active_contacts.iter().filter(|contact| contact.candidate.is_between_surfaces()) {
            let (gap, slip_row) = gap_and_slip_row_at(&contact.candidate, world, plan, &self.poses);
            let linear_gap = contact.candidate.gap + interval_s * self.rate[contact.normal];
            let curvature = gap - linear_gap;
            // For surfaces in persistent contact at zero gap, the predicted gap is rounding error.
            if contact.candidate.gap != 0.0 || curvature.abs() > contact.candidate.rounding {
                self.free[contact.normal] += 2.0 * curvature / (interval_s * interval_s);
            }
            if let Some(tangent) = contact.tangent {
                self.free[tangent] += (slip_row.rate(velocities) - self.rate[tangent]) / interval_s;
            }
        }
    }

    /// Returns a contact by the element index of its candidate, and its position in the list of contacts.
    pub fn find(&self, index: usize) -> Option<(usize, &ActiveContact)> {
        self.active_contacts.iter().enumerate().find(|(_, contact)| contact.candidate.index == index)
    }

    /// Whether the surfaces of a contact close at the start of the step, or are at rest there and about to close.
    pub fn is_closing(&self, contact: &ActiveContact) -> bool {
        let rate = self.rate[contact.normal];
        rate < -ZERO_RATE || (rate <= ZERO_RATE && self.free[contact.normal] < 0.0)
    }

    /// Adds the generalised impulses on every body due to impulses along all rows, including joint reactions.
    pub(crate) fn add_impulses(&self, linkage: &Linkage, impulses: &[f64], out: &mut [Twist]) {
        let bodies = out.len();
        for (j, size) in impulses.iter().enumerate().filter(|(_, size)| **size != 0.0) {
            let response = &self.response[j * bodies..(j + 1) * bodies];
            for ((impulse, v), inertia) in out.iter_mut().zip(response).zip(&linkage.inertias) {
                impulse[0] += size * inertia.mass * v[0];
                impulse[1] += size * inertia.mass * v[1];
                impulse[2] += size * inertia.inertia * v[2];
            }
        }
    }
}

/// Computes the velocity response to a unit impulse along each row, body by body, and from it W row by row.
fn respond<'a>(
    rows: impl ExactSizeIterator<Item = &'a Row> + Clone,
    linkage: &mut Linkage,
    bodies: usize,
    response: &mut Vec<Twist>,
    w: &mut Vec<f64>,
) {
    let count = rows.len();
    reset(response, count * bodies, [0.0; 3]);
    reset(w, count * count, 0.0);
    for (j, (response, row)) in response.chunks_exact_mut(bodies).zip(rows.clone()).enumerate() {
        row.add_to(response, 1.0);
        linkage.respond(response);
        for (i, row) in rows.clone().enumerate() {
            w[i * count + j] = row.rate(response);
        }
    }
}

/// A candidate is included if its gap is below this many times its free closing distance in a step.
const CLOSING_MARGIN: f64 = 1.5;
/// Shortest interval for the evaluation of curvature, s.
const MIN_CURVATURE_STEP_S: f64 = 1e-7;

/// A row to correct.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CorrectedRow {
    /// Index of the row in the contact space.
    pub index: usize,
    pub row: Row,
    pub target: f64,
    /// Impulse along the row that may be removed.
    pub removable: f64,
    /// h (∂F/∂δ̇ + h ∂F/∂δ) of a normal row, h F ∂μ/∂v of a tangent row.
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

    /// Solves for the impulses and applies them to the velocities.
    pub fn solve(&mut self, linkage: &mut Linkage, velocities: &mut [Twist]) {
        let (count, bodies) = (self.rows.len(), velocities.len());
        self.impulses.clear();
        if count == 0 {
            return;
        }
        respond(self.rows.iter().map(|row| &row.row), linkage, bodies, &mut self.response, &mut self.w);
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
        if !dense::solve(&mut self.w, &mut self.impulses, count) {
            self.impulses.fill(0.0);
            return;
        }
        for j in 0..count {
            let impulse = self.impulses[j].max(-self.rows[j].removable);
            let clamped = impulse - self.impulses[j];
            self.impulses[j] = impulse;
            // If the normal impulse is clamped, its friction is reduced accordingly.
            if let Some(row) = self.rows.get(j + 1).filter(|row| row.friction_coupling != 0.0) {
                self.impulses[j + 1] -= row.friction_coupling * clamped;
            }
            let response = &self.response[j * bodies..(j + 1) * bodies];
            for (v, change) in velocities.iter_mut().zip(response) {
                for axis in 0..3 {
                    v[axis] += impulse * change[axis];
                }
            }
        }
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
