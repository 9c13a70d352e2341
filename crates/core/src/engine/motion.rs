//! Motion of the engine: one rapier step at a time in a centred leapfrog scheme, with contact from the contact solver.
//!
//! Between nodes n and n + 1 rapier moves every body with one velocity, the mean over the step. It starts from the mean
//! velocity of the preceding step. The difference between both means is applied as a force over the step: the second
//! half of the last step's smooth forces and its late contact impulses, and the first half of this step's smooth forces
//! and its early contact impulses. This leapfrog is of second order, even with a variable step size, and with the rates of
//! the forces (see `force_rates`) of third order where they are smooth. The velocity *at* a node is the last mean plus the
//! second halves, including joint reactions.

use rapier2d_f64::prelude::*;

use super::cable::{CableReading, PlannedCableFriction, read_circle, turn, update_path};
use super::cancellation::Cancellation;
use super::candidates::{self, ContactCandidate, Element};
use super::contact_space::{ActiveContact, ContactSpace, CorrectedRow, RateCorrection};
use super::coordinate::{Row, Twist};
use super::force_rates::ForceRates;
use super::forces;
use super::joint::anchor_shift;
use super::linkage::{Linkage, SingularConstraints};
use super::lists::refill;
use super::plan::{Plan, PlannedActuator, PlannedTendon};
use super::powertrain::{PowertrainLaw, PowertrainState, PowertrainStep};
use super::rapier_contact::{RapierContact, read_rapier_impulses};
use super::substeps::{ContactExtremum, ContactSolveError, ContactSolver};
use super::support;
use super::world::{LawContactHook, World};
use crate::drive::Profile;
use crate::integrator::Clock;
use crate::law::{FrictionRange, friction_coefficient};
use crate::mechanism::MIN_DISTANCE_M;
use crate::mechanism::tendon::CableFault;
use crate::numeric::elementary::{exp, hypot};
use crate::numeric::plane::{add, dot, scale, sub};

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    #[error(transparent)]
    SingularConstraints(#[from] SingularConstraints),
    #[error(transparent)]
    Contact(#[from] ContactSolveError),
    #[error("the position of a body is not finite: rapier's joints are not accurate at this step size")]
    NotFinite,
    /// The motion is unchanged, and accepts a shorter step.
    #[error(
        "a step of {dt_s:.1e} s would open a joint by {opening_m:.1e} m: the mechanism is in or near a singular configuration"
    )]
    TooLong { dt_s: f64, opening_m: f64 },
}

/// Largest joint opening of a step before the anchor correction, in step tolerances.
const MAX_OPENING_PER_TOLERANCE: f64 = 100.0;
/// Largest number of iterations of the anchor correction, each with better mean velocities.
const MAX_ANCHOR_ITERATIONS: u32 = 4;
/// Error of the anchor correction, in step tolerances, below which its iteration stops.
const ANCHOR_TOLERANCE: f64 = 0.1;

/// Forces (x, y) and moments of the joints on their second bodies at a node, in the world frame. They depend linearly
/// on the contact forces.
#[derive(Clone, Debug, Default)]
pub struct JointReactions {
    /// Forces without contacts.
    pub free: Vec<Twist>,
    /// Channels of the contacts near the node.
    pub channels: Vec<usize>,
    /// For each of these contacts, forces of all joints per unit of its normal force, then of its tangential force.
    responses: Vec<Twist>,
}

impl JointReactions {
    /// Forces of a joint per unit of the normal force and per unit of the tangential force of a contact; `contact` is
    /// its index in `channels`.
    pub fn response(&self, contact: usize, joint: usize) -> [Twist; 2] {
        let (joints, first) = (self.free.len(), 2 * contact * self.free.len());
        [self.responses[first + joint], self.responses[first + joints + joint]]
    }
}

/// State of the engine at the end of its last step. This instant is called a node.
#[derive(Clone)]
pub struct Motion {
    pub plan: Plan,
    pub world: World,
    pub linkage: Linkage,
    pub clock: Clock,
    pub velocities: Vec<Twist>,
    /// Bodies that move by forces and whose rotation is completed after rapier's step.
    dynamic_bodies: Vec<RigidBodyHandle>,
    /// Accelerations at the node without contact forces.
    pub accelerations: Vec<Twist>,
    /// Largest change of the acceleration of a body over the last step, m/s².
    pub acceleration_change: f64,
    pub candidates: Vec<ContactCandidate>,
    /// Contact space of the last step, as assembled at its start.
    pub space: ContactSpace,
    /// Solution of the contact forces in the last step.
    pub contact: ContactSolver,
    /// Impulses of rapier's own contacts in the last step, if the scene selects them.
    pub rapier_contacts: Vec<RapierContact>,
    pub last_dt_s: f64,
    /// Work of motors, of servos that act as motors, and of prescribed motions, J.
    pub motor_work_j: f64,
    /// Work of contacts, cables, brakes and dampers, J.
    pub contact_work_j: f64,
    /// Part of it of the friction of cables, J.
    pub cable_work_j: f64,
    /// A cable that cannot go on, by its index, and why.
    pub cable_fault: Option<(usize, CableFault)>,
    /// Smooth forces at the node.
    forces: Vec<Twist>,
    /// Mean velocities of the last step.
    mean_velocities: Vec<Twist>,
    /// Accelerations at the start of the last step, as rapier's joints produced them.
    pub step_accelerations: Vec<Twist>,
    /// Working array: impulses on the bodies.
    impulse: Vec<Twist>,
    /// Working array: predicted mean velocities of the next step.
    predicted_mean_velocities: Vec<Twist>,
    /// Internal state of friction of every stop, contact, brake, motor and servo.
    pub friction_states: Vec<f64>,
    /// Current of every powertrain, A.
    pub currents: Vec<f64>,
    /// Work that every powertrain has lost in its gear, J; it is part of the work of contacts.
    pub loss_work_j: Vec<f64>,
    /// Vectors between the points whose distances powertrains measure, before the last step.
    previous_offsets: Vec<[f64; 2]>,
    /// Accelerations of driven bodies, with the body indices.
    driven: Vec<(usize, Twist)>,
    /// Openings with the anchor correction, and the corrections.
    open: Vec<[f64; 2]>,
    overshoot: Vec<[f64; 2]>,
    /// Largest opening acceleration of a joint at the node; see `Linkage::max_opening_acceleration`.
    pub opening_acceleration: f64,
    force_rates: ForceRates,
    /// Power of supports against joints and smooth forces at the node, W.
    support_power: f64,
    /// Largest joint opening that a step may leave, m. It arises because the mean velocities differ from the predicted
    /// ones.
    pub tolerance_m: f64,
    rate_correction: RateCorrection,
    /// Normals of the candidates before the step.
    previous_normals: Vec<([f64; 2], Row)>,
    /// Poses before the step, from which the rotations of shafts are computed.
    previous_poses: Vec<[f64; 3]>,
    /// Motor torques before the step.
    previous_torques: Vec<f64>,
}

impl Motion {
    /// Creates the motion of a world at t = 0. Fails if the joint constraints are singular.
    pub fn new(plan: Plan, world: World) -> Result<Self, StepError> {
        let linkage = Linkage::new(&world, &plan);
        let (bodies, drives, elements) = (plan.bodies.len(), plan.powertrains.len(), plan.element_count());
        let is_driven = |body: usize| plan.drives.iter().any(|drive| drive.body == body);
        let dynamic = (0..bodies).filter(|body| !is_driven(*body));
        let dynamic_bodies = dynamic.map(|body| world.bodies[body]).collect();
        let mut motion = Self {
            dynamic_bodies,
            plan,
            world,
            linkage,
            clock: Clock::at(0.0),
            velocities: vec![[0.0; 3]; bodies],
            accelerations: vec![[0.0; 3]; bodies],
            acceleration_change: 0.0,
            candidates: Vec::new(),
            space: ContactSpace::default(),
            contact: ContactSolver::default(),
            rapier_contacts: Vec::new(),
            last_dt_s: 0.0,
            motor_work_j: 0.0,
            contact_work_j: 0.0,
            cable_work_j: 0.0,
            cable_fault: None,
            forces: vec![[0.0; 3]; bodies],
            force_rates: ForceRates::new(bodies),
            mean_velocities: vec![[0.0; 3]; bodies],
            step_accelerations: vec![[0.0; 3]; bodies],
            impulse: vec![[0.0; 3]; bodies],
            predicted_mean_velocities: vec![[0.0; 3]; bodies],
            driven: Vec::new(),
            friction_states: vec![0.0; elements],
            currents: vec![0.0; drives],
            loss_work_j: vec![0.0; drives],
            previous_offsets: Vec::new(),
            open: Vec::new(),
            overshoot: Vec::new(),
            opening_acceleration: 0.0,
            support_power: 0.0,
            tolerance_m: f64::INFINITY,
            rate_correction: RateCorrection::default(),
            previous_normals: Vec::new(),
            previous_poses: vec![[0.0; 3]; bodies],
            previous_torques: Vec::new(),
        };
        motion.update_paths(true);
        motion.linkage.factorise()?;
        motion.read_mean_velocities();
        motion.velocities.copy_from_slice(&motion.mean_velocities);
        forces::set_driven_velocities(&motion.plan, 0.0, &mut motion.velocities);
        motion.linkage.project(&mut motion.velocities);
        candidates::collect(&motion.world, &motion.plan, &motion.linkage, &mut motion.candidates);
        motion.update_node();
        motion.keep_offsets();
        Ok(motion)
    }

    /// Replaces the input of an actuator as a function of time, from this node on.
    pub fn set_input(&mut self, actuator: usize, input: Profile) {
        self.plan.set_input(actuator, input);
        self.update_node();
    }

    /// Removes contacts between surfaces, from this node on; `channels` are their contact channels in samples.
    pub fn remove_contacts(&mut self, channels: &[usize]) {
        self.plan.remove_contacts(channels);
        candidates::collect(&self.world, &self.plan, &self.linkage, &mut self.candidates);
        self.update_node();
    }

    /// Takes one step. Stops with an error once `keep_running` returns false. The motion is usable after
    /// [`StepError::TooLong`], but not after any other error.
    pub fn advance(&mut self, dt: f64, keep_running: &dyn Fn() -> bool) -> Result<(), StepError> {
        let power_before =
            self.support_power + forces::palm_power(&self.plan, &self.linkage, &self.velocities, self.clock.now());
        candidates::set_shaft_torques(&self.plan, &self.linkage.poses, self.clock.now(), dt, &mut self.candidates);
        let state = (&self.linkage.poses[..], &self.velocities[..]);
        candidates::set_cables(&self.plan, state, (self.clock.now(), dt), &mut self.candidates);
        // Predicted mean velocities of the step.
        for (v, a) in self.predicted_mean_velocities.iter_mut().zip(self.velocities.iter().zip(&self.accelerations)) {
            *v = std::array::from_fn(|axis| a.0[axis] + 0.5 * dt * a.1[axis]);
        }
        let mut iterations = 0;
        loop {
            self.shift_anchors(dt);
            let Self { world, plan, linkage, .. } = self;
            let candidates = (&self.candidates[..], &self.friction_states[..], &self.currents[..]);
            let (velocities, accelerations) = (&self.velocities, &self.step_accelerations);
            if !self.space.assemble(world, plan, linkage, candidates, velocities, accelerations, dt, keep_running) {
                return Err(ContactSolveError::Stopped.into());
            }
            self.contact.solve(&self.space, dt, keep_running)?;
            self.compute_impulses(dt);
            iterations += 1;
            let [opening_m, error_m] = self.opening_errors(dt);
            if opening_m > MAX_OPENING_PER_TOLERANCE * self.tolerance_m
                || (error_m > self.tolerance_m && iterations == MAX_ANCHOR_ITERATIONS)
            {
                return Err(StepError::TooLong { dt_s: dt, opening_m });
            }
            if error_m <= ANCHOR_TOLERANCE * self.tolerance_m || iterations == MAX_ANCHOR_ITERATIONS {
                break;
            }
        }
        self.update_friction_states(dt);
        self.contact_work_j += self.contact.work;
        self.cable_work_j += self.contact.cable_work;
        self.motor_work_j += self.contact.motor_work;
        let step = (self.clock.now(), dt);
        let impulses = [&self.contact.early_impulse[..], &self.contact.late_impulse[..]];
        self.motor_work_j -= support::contact_work(&self.plan, &self.space.on_supports, impulses, step);

        self.keep_offsets();
        for (pose, before) in self.linkage.poses.iter().zip(&mut self.previous_poses) {
            *before = [pose.com[0], pose.com[1], pose.angle];
        }
        let now = self.clock.now();
        refill(&mut self.previous_torques, self.plan.motors.iter().map(|motor| motor.stall_torque(now)));
        self.step_rapier(dt);
        self.clock.advance(dt);
        self.last_dt_s = dt;

        self.linkage.read_poses(&self.world, dt);
        if self.linkage.poses.iter().any(|pose| !(pose.angle + pose.com[0] + pose.com[1]).is_finite()) {
            return Err(StepError::NotFinite);
        }
        self.update_paths(false);
        self.linkage.factorise()?;
        self.read_mean_velocities();
        // With rapier's own contact, impulses act on the rates before the step.
        let (work, on_driven) = read_rapier_impulses(
            &self.world,
            &self.plan,
            &self.candidates,
            &self.velocities,
            &self.mean_velocities,
            &mut self.rapier_contacts,
        );
        self.contact_work_j += work;
        self.motor_work_j -= on_driven;
        let normals = self.candidates.iter().map(|candidate| (candidate.normal, candidate.normal_row.clone()));
        refill(&mut self.previous_normals, normals);
        candidates::collect(&self.world, &self.plan, &self.linkage, &mut self.candidates);
        candidates::set_normal_rotation_rates(&mut self.candidates, &self.plan.bodies, &self.previous_normals, dt);
        // A torque discontinuity at the node belongs to the next step.
        let before_node = self.clock.now() - 1e-9 * dt;
        forces::smooth_forces(&self.plan, &self.linkage, before_node, &mut self.forces);
        self.force_rates.update_in_step(&self.linkage, &self.forces, &self.candidates, dt);
        self.kick(0.5 * dt);
        if !self.correct_contact_rates(keep_running) {
            return Err(ContactSolveError::Stopped.into());
        }

        // The work of a motor with a no-load speed is integrated with its torque, along its row.
        for (motor, before) in self.plan.motors.iter().zip(&self.previous_torques) {
            if motor.no_load_speed_rad_s.is_none() {
                let shaft_rotation = motor.shaft.change(&self.previous_poses, &self.linkage.poses);
                self.motor_work_j += 0.5 * (before + motor.stall_torque(before_node)) * shaft_rotation;
            }
        }
        let power_after = forces::palm_power(&self.plan, &self.linkage, &self.velocities, self.clock.now());
        let support_power = self.support_power(before_node);
        self.motor_work_j += 0.5 * dt * (power_before + power_after + support_power);
        self.update_node();
        Ok(())
    }

    /// Finds the circles that cables are on at the node.
    fn update_paths(&mut self, is_first: bool) {
        let Self { plan: Plan { tendons, stops, motors, .. }, linkage, cable_fault, .. } = self;
        for (index, tendon) in tendons.iter_mut().enumerate() {
            let PlannedTendon { length, stop, motor, circles, .. } = tendon;
            let before = circles.iter().filter(|circle| circle.is_on).count();
            *cable_fault = cable_fault.or_else(|| Some((index, update_path(circles, &linkage.poses, is_first)?)));
            if is_first || circles.iter().filter(|circle| circle.is_on).count() != before {
                length.set_path(circles);
                stop.iter().for_each(|stop| stops[*stop].gap.set_path(circles));
                motor.iter().for_each(|motor| motors[*motor].shaft.set_path(circles));
            }
        }
    }

    /// Updates the internal states of friction; those out of reach relax.
    fn update_friction_states(&mut self, dt: f64) {
        for candidate in &self.candidates {
            if let Some(law) = candidate.law_with_state() {
                let state = &mut self.friction_states[candidate.index];
                *state = law.kind.relaxed(*state, dt);
            }
        }
        for (active, state) in self.space.active_contacts.iter().zip(&self.contact.friction_state) {
            self.friction_states[active.candidate.index] = *state;
        }
        let solved = self.contact.current.iter().zip(&self.contact.loss_work);
        for (active, (current, loss_work)) in self.space.active_contacts.iter().zip(solved) {
            if let Element::Powertrain(index) = active.candidate.element {
                self.currents[index] = *current;
                self.loss_work_j[index] += loss_work;
            }
        }
    }

    /// Returns a powertrain at the node.
    pub(crate) fn powertrain(&self, index: usize) -> PowertrainStep {
        let state = PowertrainState {
            bristle: self.friction_states[self.plan.first_powertrain() + index],
            current: self.currents[index],
        };
        let motion = (&self.linkage.poses[..], &self.velocities[..]);
        self.plan.powertrains[index].at_node(self.clock.now(), motion, state)
    }

    /// Adds the forces of all powertrains at the node to `impulse`.
    fn add_powertrain_forces(&mut self) {
        for index in 0..self.plan.powertrains.len() {
            let effort = self.powertrain(index).effort;
            self.plan.powertrains[index].shaft.row(&self.linkage.poses).add_to(&mut self.impulse, effort);
        }
    }

    /// Keeps the vectors between measured points for the next step.
    fn keep_offsets(&mut self) {
        let offsets = self.plan.powertrains.iter().map(|of| of.offset(&self.linkage.poses).unwrap_or_default());
        refill(&mut self.previous_offsets, offsets);
    }

    /// Returns the first powertrain whose points have met in the last step, which moves them straight on.
    pub(crate) fn met_points(&self) -> Option<usize> {
        let before = self.previous_offsets.iter();
        self.plan.powertrains.iter().zip(before).position(|(powertrain, before)| {
            powertrain.offset(&self.linkage.poses).is_some_and(|now| {
                let moved = sub(now, *before);
                let part = (-dot(*before, moved) / dot(moved, moved)).clamp(0.0, 1.0);
                // The points are at rest relative to each other if the part is not a number.
                let nearest = if part.is_nan() { now } else { add(*before, scale(moved, part)) };
                let least = hypot(nearest[0], nearest[1]);
                least.is_nan() || least < MIN_DISTANCE_M
            })
        })
    }

    /// Returns the energy of the internal states of friction, J.
    pub(crate) fn friction_energy(&self) -> f64 {
        // The friction of a cable is proportional to its tension, and has no stored energy.
        let stores = |candidate: &&ContactCandidate| candidate.cable.is_none();
        let energy = |candidate: &ContactCandidate| {
            let loss = candidate.powertrain.as_ref().and_then(PowertrainLaw::loss_law);
            let law = candidate.law_with_state().or(loss);
            law.map_or(0.0, |law| law.kind.energy(self.friction_states[candidate.index]))
        };
        self.candidates.iter().filter(stores).map(energy).sum()
    }

    /// Returns the torque of a brake on its shaft, N·m.
    pub fn brake_torque(&self, brake: usize) -> f64 {
        self.forces(self.plan.first_brake() + brake).1
    }

    /// Returns the normal and the tangential force of a stop or contact at the end of the last step. They come from the
    /// contact laws or from rapier.
    pub fn forces(&self, index: usize) -> (f64, f64) {
        if let Some((_, contact)) = self.space.find(index) {
            let force = &self.contact.force;
            // There is no force before the first step.
            return (force.get(contact.normal).copied().unwrap_or(0.0), contact.tangent.map_or(0.0, |t| force[t]));
        }
        self.rapier_contact(index)
            .map_or((0.0, 0.0), |contact| (contact.normal / self.last_dt_s, contact.tangential / self.last_dt_s))
    }

    /// Returns the force of a stop or contact under a law at the node; before the first step, that of its law.
    pub(crate) fn normal_force(&self, candidate: &ContactCandidate) -> f64 {
        match self.last_dt_s > 0.0 {
            true => self.forces(candidate.index).0,
            false => candidate.normal_force(candidate.gap, candidate.normal_row.rate(&self.velocities)).force,
        }
    }

    /// Whether the next step is of third order: no body is driven, and no contact or stop exerts a force at the end
    /// of the last step.
    pub(crate) fn is_smooth(&self) -> bool {
        let is_loaded = |active: &ActiveContact| active.candidate.has_gap() && self.contact.force[active.normal] > 0.0;
        self.plan.drives.is_empty()
            && !self.space.active_contacts.iter().any(is_loaded)
            && self.rapier_contacts.iter().all(|contact| contact.normal == 0.0)
    }

    /// Returns the impulses of rapier's own contact in the last step.
    pub(crate) fn rapier_contact(&self, index: usize) -> Option<&RapierContact> {
        self.rapier_contacts.iter().find(|contact| contact.index == index)
    }

    /// Reads the circles of cables that samples report.
    pub(crate) fn read_elements(&self) -> impl Iterator<Item = CableReading> + '_ {
        let Self { plan, linkage, velocities, .. } = self;
        plan.reported_circles.iter().map(move |&[tendon, circle]| {
            let of = &plan.tendons[tendon];
            let before =
                self.cable_losses(tendon).filter(|(friction, _)| plan.cable_frictions[*friction].circle <= circle);
            let tension = self.tension(of) - before.map(|(_, loss)| loss).sum::<f64>();
            let rubs = plan.cable_frictions.iter().any(|friction| friction.tendon == tendon);
            CableReading { tension, ..read_circle(&of.circles, circle, (&of.far, rubs), (&linkage.poses, velocities)) }
        })
    }

    /// What the friction of a cable takes from its tension at the node, N, by the indices of the frictions.
    fn cable_losses(&self, tendon: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let Self { plan, linkage, velocities, friction_states, .. } = self;
        let of = &plan.tendons[tendon];
        let mut tension = self.tension(of);
        let frictions = plan.cable_frictions.iter().enumerate();
        let on = frictions.filter(move |(_, friction)| friction.tendon == tendon && of.circles[friction.circle].is_on);
        on.map(move |(index, PlannedCableFriction { circle, law, .. })| {
            let element = plan.first_cable_friction() + index;
            let slip = self.candidate(element).map_or(0.0, |candidate| candidate.slip_row.rate(velocities));
            let state = law.has_state().then(|| friction_states[element]);
            let mu = -law.force(slip, state, 1.0, FrictionRange::Any);
            let loss = tension * (1.0 - exp(-mu * turn(&of.circles, *circle, &linkage.poses)));
            tension -= loss;
            (index, loss)
        })
    }

    /// Tension of the first strand of a cable at the node: that of its spring and of its actuator.
    pub(crate) fn tension(&self, tendon: &PlannedTendon) -> f64 {
        let spring = tendon.stop.and_then(|stop| self.candidate(stop)).map_or(0.0, |stop| self.normal_force(stop));
        let state = (&self.linkage.poses[..], &self.velocities[..]);
        let pull =
            tendon.motor.map_or(0.0, |motor| self.plan.effort(PlannedActuator::Motor(motor), self.clock.now(), state));
        spring + pull
    }

    pub fn candidate(&self, index: usize) -> Option<&ContactCandidate> {
        candidates::find(&self.candidates, index)
    }

    /// Whether friction with stiction slips at the end of the last step; `None` without stiction or a load.
    pub(crate) fn is_slipping(&self, index: usize) -> Option<bool> {
        self.contact.is_slipping(self.space.find(index)?.0, &self.space)
    }

    /// Returns the states of a stop or contact with the largest force and with the largest penetration in the last
    /// step, if it was in the contact space.
    pub(crate) fn contact_extrema(&self, index: usize) -> Option<[ContactExtremum; 2]> {
        let (position, _) = self.space.find(index)?;
        Some([*self.contact.peak.get(position)?, *self.contact.deepest.get(position)?])
    }

    /// Returns mean accelerations of all bodies from the start of the last step to a change in it, `after_s` later: those
    /// that give the displacements, and those that give the changes of velocity.
    pub(crate) fn mean_accelerations(&self, change: usize, after_s: f64) -> [Vec<Twist>; 2] {
        let [mut displacing, mut accelerating] = [(); 2].map(|()| self.step_accelerations.clone());
        let integrals = || self.contact.integrals_at(change);
        let displacement = |[_, double_integral]: [f64; 2]| 2.0 * double_integral / (after_s * after_s);
        self.space.add_responses(integrals().map(displacement), &mut displacing);
        self.space.add_responses(integrals().map(|[impulse, _]| impulse / after_s), &mut accelerating);
        [displacing, accelerating]
    }

    /// Returns the normal impulse of a stop or contact in the last step, from the contact laws or from rapier.
    pub(crate) fn normal_impulse(&self, index: usize) -> f64 {
        match self.space.find(index) {
            Some((_, active)) => self.contact.early_impulse[active.normal] + self.contact.late_impulse[active.normal],
            None => self.rapier_contact(index).map_or(0.0, |contact| contact.normal),
        }
    }

    /// Advances mean velocities to those at the end of the step: second half of smooth forces, less their rates, and late
    /// impulses.
    fn kick(&mut self, half: f64) {
        self.velocities.copy_from_slice(&self.mean_velocities);
        self.force_rates.extrapolate(&self.forces, -2.0 / 3.0 * half, &mut self.impulse);
        self.impulse.iter_mut().flatten().for_each(|force| *force *= half);
        for active in &self.space.active_contacts {
            let candidate = candidates::find(&self.candidates, active.candidate.index).unwrap_or(&active.candidate);
            candidate.normal_row.add_to(&mut self.impulse, self.contact.late_impulse[active.normal]);
            if let Some(tangent) = active.tangent {
                candidate.slip_row.add_to(&mut self.impulse, self.contact.late_impulse[tangent]);
            }
            if let Some(rolling) = active.rolling {
                candidate.roll_row.add_to(&mut self.impulse, self.contact.late_impulse[rolling]);
            }
        }
        for ((v, impulse), inertia) in self.velocities.iter_mut().zip(&self.impulse).zip(&self.linkage.inertias) {
            v[0] += inertia.inverse_mass * impulse[0];
            v[1] += inertia.inverse_mass * impulse[1];
            v[2] += inertia.inverse_inertia * impulse[2];
        }
        forces::set_driven_velocities(&self.plan, self.clock.now(), &mut self.velocities);
        self.linkage.project(&mut self.velocities);
    }

    /// Corrects the rates of active contacts.
    ///
    /// Late impulses are computed with the directions and loads at the start of the step. Their error at its end shows
    /// as a rate that the contact cannot have. Like joints, these rows are corrected to the rate at the end of the
    /// contact's own equations, and so is the slip where friction creeps. No force may pull: late impulses are limited
    /// so that they do not become negative.
    ///
    /// Returns false if `keep_running` does; the rates are then not corrected.
    fn correct_contact_rates(&mut self, keep_running: &dyn Fn() -> bool) -> bool {
        let dt = self.last_dt_s;
        let Self { space, contact, candidates, rate_correction, .. } = self;
        rate_correction.rows.clear();
        for (index, active) in space.active_contacts.iter().enumerate() {
            let (normal, force) = (active.normal, contact.force[active.normal]);
            if let (Element::Cable(_), Some(tangent)) = (active.candidate.element, active.tangent) {
                let at_end = candidates::find(candidates, active.candidate.index);
                rate_correction.rows.push(CorrectedRow {
                    index: tangent,
                    row: at_end.unwrap_or(&active.candidate).slip_row.clone(),
                    target: contact.rate[tangent],
                    removable: f64::INFINITY,
                    stiffness: (-dt * contact.cable_slope[tangent]).max(0.0),
                    friction_coupling: 0.0,
                });
                continue;
            }
            // Friction at the end of the contact's own equations.
            let friction = |candidate: &ContactCandidate, tangent: usize| {
                candidate.friction_at_step_end([contact.rate[tangent], contact.friction_state[index], force], dt)
            };
            let tangent_row = |tangent: usize, row: Row, mu: f64, creep: f64| CorrectedRow {
                index: tangent,
                row,
                target: contact.rate[tangent],
                removable: f64::INFINITY,
                stiffness: creep,
                friction_coupling: mu,
            };
            let at_end = candidates::find(candidates, active.candidate.index);
            if let (Element::Brake(_) | Element::Motor(_), Some(tangent)) = (active.candidate.element, active.tangent) {
                let creep = dt * friction(&active.candidate, tangent).d_slip;
                let slip_row = at_end.unwrap_or(&active.candidate).slip_row.clone();
                rate_correction.rows.push(tangent_row(tangent, slip_row, 0.0, creep));
                continue;
            }
            if let (Some(powertrain), Some(tangent)) = (&active.candidate.powertrain, active.tangent) {
                let state = PowertrainState { bristle: contact.friction_state[index], current: contact.current[index] };
                let found =
                    powertrain.step(contact.gap[index], [contact.rate[normal], contact.rate[tangent]], state, dt);
                let is_own = active.candidate.normal_row == active.candidate.slip_row;
                let by_rate = found.d_rate + if is_own { found.d_gap_rate } else { 0.0 };
                let slip_row = at_end.unwrap_or(&active.candidate).slip_row.clone();
                rate_correction.rows.push(tangent_row(tangent, slip_row, 0.0, (-dt * by_rate).max(0.0)));
                continue;
            }
            if let (Element::Servo(_), Some(at_end)) = (active.candidate.element, at_end) {
                let law = active.candidate.normal_force(contact.gap[index], contact.rate[normal]);
                let [target_rate, target_acceleration] = active.candidate.prescribed_gap_motion;
                rate_correction.rows.push(CorrectedRow {
                    index: normal,
                    row: at_end.normal_row.clone(),
                    target: contact.rate[normal] + target_rate + dt * target_acceleration,
                    removable: f64::INFINITY,
                    stiffness: dt * (law.d_rate + dt * law.d_delta),
                    friction_coupling: 0.0,
                });
                continue;
            }
            // Contacts between fixed or driven bodies need no correction.
            if force <= 0.0 || space.inverse_mass(normal) == 0.0 {
                continue;
            }
            let Some(candidate) = at_end else { continue };
            if let Some((rolling, law)) = active.rolling.zip(candidate.rolling.as_ref()) {
                let creep = dt * friction_coefficient(law, contact.rate[rolling]).1 * force;
                rate_correction.rows.push(tangent_row(rolling, candidate.roll_row.clone(), 0.0, creep.max(0.0)));
            }
            let law = candidate.normal_force(contact.gap[index], contact.rate[normal]);
            rate_correction.rows.push(CorrectedRow {
                index: normal,
                row: candidate.normal_row.clone(),
                target: contact.rate[normal],
                removable: contact.late_impulse[normal],
                stiffness: dt * (law.d_rate + dt * law.d_delta),
                friction_coupling: 0.0,
            });
            let Some(tangent) = active.tangent else { continue };
            let after = friction(candidate, tangent);
            let creep = (dt * after.d_slip).max(0.0);
            rate_correction.rows.push(tangent_row(tangent, candidate.slip_row.clone(), after.d_normal, creep));
        }
        let cancellation = Cancellation::new(keep_running);
        if !rate_correction.solve(&mut self.linkage, &mut self.velocities, &cancellation) {
            return false;
        }
        let is_motor_row = |row: usize| {
            let contacts = &space.active_contacts;
            let is_row = |contact: &ActiveContact| contact.rows().any(|other| other == row);
            contacts.iter().any(|contact| contact.candidate.is_motor && is_row(contact))
        };
        let is_cable_row = |row: usize| {
            let of_cables = space.active_contacts.iter().filter(|contact| contact.candidate.cable.is_some());
            of_cables.into_iter().any(|contact| contact.tangent == Some(row))
        };
        let (mut contact_work, mut motor_work) = (0.0, 0.0);
        for (row, work) in rate_correction.impulse_work(&self.velocities) {
            self.cable_work_j += if is_cable_row(row) { work } else { 0.0 };
            *(if is_motor_row(row) { &mut motor_work } else { &mut contact_work }) += work;
        }
        self.contact_work_j += contact_work;
        self.motor_work_j += motor_work;
        for (row, impulse) in rate_correction.impulses() {
            contact.late_impulse[row] += impulse;
        }
        true
    }

    /// Returns the power of supports against joints and smooth forces at the node, with the accelerations at time `t`.
    fn support_power(&mut self, t: f64) -> f64 {
        forces::driven_accelerations(&self.plan, t, &mut self.driven);
        let Self { plan, linkage, forces, velocities, driven, predicted_mean_velocities: accelerations, .. } = self;
        support::power_of_supports(plan, linkage, (forces, velocities), t, (driven, accelerations))
    }

    /// Updates forces and accelerations at the node for the next step.
    fn update_node(&mut self) {
        candidates::zero_rounding_gaps(&mut self.candidates, &self.velocities);
        let now = self.clock.now();
        forces::smooth_forces(&self.plan, &self.linkage, now, &mut self.forces);
        self.support_power = self.support_power(now);
        // Buffer for the previous accelerations.
        self.predicted_mean_velocities.copy_from_slice(&self.accelerations);
        forces::driven_accelerations(&self.plan, now, &mut self.driven);
        self.impulse.copy_from_slice(&self.forces);
        forces::add_speed_dependent_forces(&self.plan, &self.linkage.poses, &self.velocities, now, &mut self.impulse);
        self.add_powertrain_forces();
        self.linkage.accelerations(&self.impulse, &self.velocities, &self.driven, &mut self.accelerations);
        let bodies = (&self.world, &self.plan, &mut self.linkage);
        let contacts = (&self.space, &self.contact.force[..], &self.candidates[..]);
        self.force_rates.update_at_node(bodies, (&self.forces, &self.velocities, now), contacts);
        let changes = self.accelerations.iter().zip(&self.predicted_mean_velocities).zip(&self.plan.bodies).map(
            |((now, before), body)| {
                let angular = body.gyration_m * (now[2] - before[2]).abs();
                hypot(now[0] - before[0], now[1] - before[1]).max(angular)
            },
        );
        self.acceleration_change = changes.fold(0.0, f64::max);
        self.opening_acceleration = self.linkage.max_opening_acceleration(&self.velocities);
    }

    /// Reads the forces of the joints at the node.
    pub fn read_joint_forces(&mut self, out: &mut JointReactions) {
        let now = self.clock.now();
        self.impulse.copy_from_slice(&self.forces);
        forces::add_speed_dependent_forces(&self.plan, &self.linkage.poses, &self.velocities, now, &mut self.impulse);
        self.add_powertrain_forces();
        forces::driven_accelerations(&self.plan, now, &mut self.driven);
        let mut loads = std::mem::take(&mut self.impulse);
        for (index, loss) in (0..self.plan.tendons.len()).flat_map(|tendon| self.cable_losses(tendon)) {
            let candidate = self.candidate(self.plan.first_cable_friction() + index);
            // The force against the slip is the difference of both tensions.
            candidate.iter().for_each(|candidate| candidate.slip_row.add_to(&mut loads, -loss));
        }
        for candidate in self.candidates.iter().filter(|candidate| matches!(candidate.element, Element::Brake(_))) {
            candidate.slip_row.add_to(&mut loads, self.forces(candidate.index).1);
        }
        for candidate in self.plan.tendons.iter().filter_map(|tendon| self.candidate(tendon.stop?)) {
            candidate.normal_row.add_to(&mut loads, self.normal_force(candidate));
        }
        for (active, rolling) in self.space.active_contacts.iter().filter_map(|active| Some((active, active.rolling?)))
        {
            active.candidate.roll_row.add_to(&mut loads, self.contact.force.get(rolling).copied().unwrap_or(0.0));
        }
        self.impulse = loads;
        let Self { plan, linkage, impulse, velocities, driven, candidates, space, .. } = self;
        linkage.accelerations(impulse, velocities, driven, &mut self.predicted_mean_velocities);
        refill(&mut out.free, linkage.joint_forces());
        out.channels.clear();
        out.responses.clear();
        let is_near = |candidate: &&ContactCandidate| {
            candidate.has_gap() && (candidate.gap <= 0.0 || space.find(candidate.index).is_some())
        };
        for candidate in candidates.iter().filter(is_near) {
            let Some(channel) = plan.contact_channel(candidate.index) else { continue };
            out.channels.push(channel);
            for row in [&candidate.normal_row, &candidate.slip_row] {
                linkage.respond_to_unit(row, impulse);
                out.responses.extend(linkage.joint_forces());
            }
        }
    }

    /// Shifts the joint anchors of rapier. It closes a joint along the tangent at the start of the step, so that the
    /// joint is open by ½ dt² |J̇ v| at the end. Shifting the anchors by that amount beforehand, for the predicted mean
    /// velocities, leaves an error of third order.
    fn shift_anchors(&mut self, dt: f64) {
        let Self { linkage, open, overshoot, predicted_mean_velocities, .. } = self;
        refill(overshoot, linkage.overshoot(predicted_mean_velocities, dt));
        let corrected = linkage.openings().zip(&*overshoot).map(|(open, overshoot)| add(open, *overshoot));
        refill(open, corrected);
        for ((planned, joint), overshoot) in self.plan.joints.iter().zip(&self.world.joints).zip(&self.overshoot) {
            let Some(joint) = self.world.physics.impulse_joints.get_mut(*joint, false) else { continue };
            let [first, _] = planned.bodies;
            let turn = dt * first.map_or(0.0, |body| self.predicted_mean_velocities[body][2]);
            let in_body = |shift| self.linkage.direction_in_body(first, shift);
            let shift = anchor_shift(planned, *overshoot, turn, in_body);
            let [x, y] = planned.anchors_m[0];
            joint.data.set_local_anchor1(Vector::new(x - shift[0], y - shift[1]));
        }
        let (plan, now) = (&self.plan, self.clock.now());
        forces::mean_driven_accelerations(plan, &self.linkage.poses, &self.velocities, now, dt, &mut self.driven);
        let opening = (&self.open[..], dt);
        self.force_rates.extrapolate(&self.forces, dt / 3.0, &mut self.impulse);
        self.linkage.accelerations_closing(&self.impulse, opening, &self.driven, &mut self.step_accelerations);
    }

    /// Computes the impulses from rapier's last mean velocity to the next one (node velocity, half a step of
    /// acceleration, and early contact impulses), and that mean velocity, in `predicted_mean_velocities`. They include
    /// the joint reactions, so that rapier's iterative joint solver starts close to its solution.
    fn compute_impulses(&mut self, dt: f64) {
        for (body, impulse) in self.impulse.iter_mut().enumerate() {
            let inertia = &self.linkage.inertias[body];
            let change: Twist = std::array::from_fn(|axis| {
                self.velocities[body][axis] - self.mean_velocities[body][axis]
                    + 0.5 * dt * self.step_accelerations[body][axis]
            });
            *impulse = [inertia.mass * change[0], inertia.mass * change[1], inertia.inertia * change[2]];
        }
        self.space.add_impulses(&self.linkage, &self.contact.early_impulse, &mut self.impulse);
        let loaded = self.mean_velocities.iter().zip(&self.impulse).zip(&self.linkage.inertias);
        for (predicted, ((mean, impulse), inertia)) in self.predicted_mean_velocities.iter_mut().zip(loaded) {
            let inverse = [inertia.inverse_mass, inertia.inverse_mass, inertia.inverse_inertia];
            *predicted = std::array::from_fn(|axis| mean[axis] + inverse[axis] * impulse[axis]);
        }
    }

    /// Returns the largest joint opening, m, at the predicted mean velocities, and the part not compensated by anchors.
    fn opening_errors(&mut self, dt: f64) -> [f64; 2] {
        let Self { linkage, overshoot, predicted_mean_velocities, .. } = self;
        let openings = linkage.overshoot(predicted_mean_velocities, dt).zip(&*overshoot);
        let squares = openings.fold([0.0_f64; 2], |[largest, error], (opening, corrected)| {
            let rest = sub(opening, *corrected);
            [largest.max(dot(opening, opening)), error.max(dot(rest, rest))]
        });
        squares.map(f64::sqrt)
    }

    /// Takes one step of rapier with the impulses applied as forces over the step.
    fn step_rapier(&mut self, dt: f64) {
        let physics = &mut self.world.physics;
        for (impulse, handle) in self.impulse.iter().zip(&self.world.bodies) {
            let body = &mut physics.bodies[*handle];
            body.reset_forces(false);
            body.reset_torques(false);
            body.add_force(Vector::new(impulse[0] / dt, impulse[1] / dt), false);
            body.add_torque(impulse[2] / dt, false);
        }
        forces::set_rapier_velocities(
            &self.plan,
            &self.linkage.poses,
            &self.world.bodies,
            &mut physics.bodies,
            self.clock.now(),
            dt,
        );
        physics.integration_parameters.dt = dt;
        physics.step_with_events(&LawContactHook, &());
        forces::complete_rotations(&self.dynamic_bodies, &mut physics.bodies, dt);
    }

    /// Reads the mean velocities of the last step from rapier.
    fn read_mean_velocities(&mut self) {
        for (v, handle) in self.mean_velocities.iter_mut().zip(&self.world.bodies) {
            let body = &self.world.physics.bodies[*handle];
            *v = [body.linvel().x, body.linvel().y, body.angvel()];
        }
    }
}
