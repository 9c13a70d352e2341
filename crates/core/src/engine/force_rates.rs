//! Rates of the forces on bodies, with which the leapfrog scheme is of third order where forces are smooth.
//!
//! The mean velocity of a step of length h after a node is v + h/2 a + h²/6 ȧ + h³/24 ä, with the values at the node, and
//! that of an equal step before it is v − h/2 a + h²/6 ȧ − h³/24 ä. Leapfrog takes h a for their difference and omits
//! h³/12 ä. The scheme adds h²/6 ȧ, with ȧ at the node, after the node, and subtracts h²/6 ȧ, with ȧ in the middle of the
//! step, before it. The difference between both is the omitted term.
//!
//! With smooth forces f, joint reactions Jᵀ λ and contact forces Cᵀ p, the rate of M a is ḟ + J̇ᵀ λ + Jᵀ λ̇ + Ċᵀ p + Cᵀ ṗ.
//! The contact solver integrates p, and the constraints of both nodes determine the impulse along Jᵀ. That leaves
//! ḟ + J̇ᵀ λ + Ċᵀ p here. In the middle of a step the rates contain λ and p from its start: the impulse along Jᵀ acts
//! with J of the node, half a step later, for which J̇ᵀ (λ − h/2 λ̇) compensates. In a step with an impact the impulses at
//! both nodes are opposite, whatever the forces within the step.

use super::candidates::{self, ContactCandidate};
use super::contact_space::ContactSpace;
use super::coordinate::{BodyPose, Row, Twist};
use super::forces::smooth_forces;
use super::linkage::Linkage;
use super::lists::refill;
use super::plan::Plan;
use super::world::World;
use crate::numeric::elementary::hypot;

/// Interval over which the rates at a node are differences, s.
const INTERVAL_S: f64 = 1e-7;
/// Change of a normal in this interval above which the contact is between other points of its surfaces.
const MAX_NORMAL_CHANGE: f64 = 0.05;

/// Rates of the forces at a node or in the middle of the last step, and what they need of the last node.
#[derive(Clone)]
pub(super) struct ForceRates {
    /// Rates of the forces and moments on each body, without Jᵀ λ̇ and Cᵀ ṗ.
    rates: Vec<Twist>,
    /// Smooth forces at the node.
    forces: Vec<Twist>,
    loaded: Vec<LoadedContact>,
    /// Working array: poses after the interval.
    poses: Vec<BodyPose>,
}

/// A contact with a force at a node.
#[derive(Clone)]
struct LoadedContact {
    /// Element index of its candidate.
    index: usize,
    /// Normal and slip row, and the forces along them.
    rows: [Row; 2],
    forces: [f64; 2],
}

impl ForceRates {
    pub fn new(bodies: usize) -> Self {
        let zero = vec![[0.0; 3]; bodies];
        Self { rates: zero.clone(), forces: zero, loaded: Vec::new(), poses: Vec::new() }
    }

    /// Extrapolates `forces` by an interval with their rates; `out` receives the result.
    pub fn extrapolate(&self, forces: &[Twist], interval_s: f64, out: &mut [Twist]) {
        for (after, (force, rate)) in out.iter_mut().zip(forces.iter().zip(&self.rates)) {
            *after = std::array::from_fn(|axis| force[axis] + interval_s * rate[axis]);
        }
    }

    /// Updates the rates at a node; `forces` are the smooth forces there. [`Linkage::accelerations`] must have been
    /// called with them. Contacts have the forces at the end of the last step, row by row of its contact space.
    pub fn update_at_node(
        &mut self,
        (world, plan, linkage): (&World, &Plan, &mut Linkage),
        (forces, velocities, t): (&[Twist], &[Twist], f64),
        (space, contact_forces, candidates): (&ContactSpace, &[f64], &[ContactCandidate]),
    ) {
        let Self { rates, forces: at_node, loaded, poses } = self;
        at_node.copy_from_slice(forces);
        linkage.save_reactions();
        refill(poses, linkage.poses.iter().zip(velocities).map(|(pose, v)| pose.after(INTERVAL_S, v)));
        std::mem::swap(poses, &mut linkage.poses);
        smooth_forces(plan, linkage, t + INTERVAL_S, rates);
        std::mem::swap(poses, &mut linkage.poses);
        for (rate, force) in rates.iter_mut().zip(forces) {
            *rate = std::array::from_fn(|axis| (rate[axis] - force[axis]) / INTERVAL_S);
        }
        loaded.clear();
        for active in &space.active_contacts {
            let Some(candidate) = candidates::find(candidates, active.candidate.index) else { continue };
            let force_along = |row: Option<usize>| row.map_or(0.0, |row| contact_forces[row]);
            let forces = [Some(active.normal), active.tangent].map(force_along);
            let rows = [&candidate.normal_row, &candidate.slip_row];
            let rolling = (&candidate.roll_row, force_along(active.rolling));
            for (row, force) in rows.into_iter().zip(forces).chain([rolling]).filter(|(_, force)| *force != 0.0) {
                linkage.add_reactions(row, force);
            }
            if forces == [0.0; 2] {
                continue;
            }
            let contact = LoadedContact { index: candidate.index, rows: rows.map(Row::clone), forces };
            let after = candidates::gap_and_rows_at(candidate, world, plan, poses);
            if let Some((_, [normal, slip])) = after.filter(|(_, rows)| contact.is_near(rows)) {
                contact.add_rates([&normal, &slip], INTERVAL_S, rates);
                loaded.push(contact);
            }
        }
        linkage.add_reaction_rates(velocities, (poses, INTERVAL_S), rates);
    }

    /// Updates the rates to those in the middle of the last step; `forces` are the smooth forces at its end, and
    /// `candidates` those at its end.
    pub fn update_in_step(&mut self, linkage: &Linkage, forces: &[Twist], candidates: &[ContactCandidate], dt: f64) {
        for ((rate, now), before) in self.rates.iter_mut().zip(forces).zip(&self.forces) {
            *rate = std::array::from_fn(|axis| (now[axis] - before[axis]) / dt);
        }
        linkage.add_mean_reaction_rates(dt, &mut self.rates);
        for contact in &self.loaded {
            if let Some(candidate) = candidates::find(candidates, contact.index) {
                contact.add_rates([&candidate.normal_row, &candidate.slip_row], dt, &mut self.rates);
            }
        }
    }
}

impl LoadedContact {
    /// Whether rows after the interval are between the same points of the surfaces.
    fn is_near(&self, rows: &[Row; 2]) -> bool {
        let [x, y] = std::array::from_fn(|axis| rows[0].on.1[axis] - self.rows[0].on.1[axis]);
        hypot(x, y) < MAX_NORMAL_CHANGE
    }

    /// Adds the rates of the forces on bodies whose rows change to `after` in an interval.
    fn add_rates(&self, after: [&Row; 2], interval_s: f64, rates: &mut [Twist]) {
        for ((before, after), force) in self.rows.iter().zip(after).zip(self.forces) {
            after.add_to(rates, force / interval_s);
            before.add_to(rates, -force / interval_s);
        }
    }
}
