//! The engine in motion: one rapier step at a time, centred by half kicks, with contact from the hook.
//!
//! Between nodes n and n + 1 rapier moves every body with one velocity, which is the mean over the step. It starts from
//! the mean of the step before; what lies between the two centres is applied as a force over the step: the second half of
//! the last step's smooth forces and its late contact impulses, and the first half of this step's with its early ones.
//! That is leapfrog, second order also where the step size changes. The velocity *at* a node is the last mean plus the
//! second halves, with the joints' reactions.

use rapier2d_f64::prelude::*;

use super::hook::Governed;
use super::linkage::{Linkage, Locked, Twist};
use super::native::{self, Native};
use super::plan::Plan;
use super::settle::Settled;
use super::space::Space;
use super::substeps::{Contact, Moment, Unsolved};
use super::touch::{self, Source, Touch};
use super::world::World;
use super::{drive, forces, frame};
use crate::integrator::Clock;
use crate::law::normal_force;
use crate::numeric::elementary::{exp, hypot};
use crate::scene::Construction;

/// Why a step could not be taken.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    #[error(transparent)]
    Locked(#[from] Locked),
    #[error(transparent)]
    Contact(#[from] Unsolved),
    #[error("a body's position is not finite: rapier's joints did not hold at this step size")]
    NotFinite,
    /// The motion is where it was, and takes a shorter step.
    #[error("a step of {dt_s:.1e} s would open a joint by {opening_m:.1e} m")]
    TooLong { dt_s: f64, opening_m: f64 },
}

/// Tolerances by which a step may open a joint, before the anchors make up for it: a hundred times what steps are made for.
const TORN: f64 = 100.0;
/// How often the anchors of a step are moved, each time for better mean velocities.
const MOST_AIMS: u32 = 4;
/// Part of a tolerance by which anchors may be moved for other velocities than bodies then have.
const WELL_AIMED: f64 = 0.1;

/// A world at a node in time.
pub struct Motion<'a> {
    pub plan: &'a Plan,
    pub world: World,
    pub linkage: Linkage,
    pub clock: Clock,
    /// Velocities and accelerations (contact not counted) at the node, and what may touch there.
    pub velocities: Vec<Twist>,
    pub accelerations: Vec<Twist>,
    /// Largest change of a body's acceleration over the last step, in m/s².
    pub acceleration_change: f64,
    pub touches: Vec<Touch>,
    /// Contact in the last step: its space as it was at the step's start.
    pub space: Space,
    pub contact: Contact,
    /// What rapier's own contact did in the last step, where the scene asks for it.
    pub native: Vec<Native>,
    pub last_dt_s: f64,
    /// Work of the motor, and of whatever drives bodies.
    pub motor_work_j: f64,
    pub contact_work_j: f64,
    forces: Vec<Twist>,
    means: Vec<Twist>,
    /// Those that the last step started with, as rapier's joints made them.
    pub step_accelerations: Vec<Twist>,
    impulse: Vec<Twist>,
    middle: Vec<Twist>,
    /// σ of the bristle of every stop, contact and hold.
    pub memories: Vec<f64>,
    /// Accelerations of driven bodies.
    driven: Vec<(usize, Twist)>,
    open: Vec<[f64; 2]>,
    overshoot: Vec<[f64; 2]>,
    /// Largest rate of rate at which a pin would open at the node, see [`Linkage::opening`].
    pub opening: f64,
    /// How far a step may leave a pin open because its bodies do not go as expected, m.
    pub tolerance_m: f64,
    settled: Settled,
    /// Normals of the touches before the step.
    normals: Vec<[f64; 2]>,
    /// Places before the step, from which a multibody's mean velocity is read.
    before: Vec<[f64; 3]>,
    /// Torques of the motors there.
    torques_before: Vec<f64>,
}

impl<'a> Motion<'a> {
    /// A world at t = 0.
    pub fn new(plan: &'a Plan, world: World) -> Result<Self, StepError> {
        let linkage = Linkage::new(&world, plan);
        let bodies = plan.bodies.len();
        let mut motion = Self {
            plan,
            world,
            linkage,
            clock: Clock::at(0.0),
            velocities: vec![[0.0; 3]; bodies],
            accelerations: vec![[0.0; 3]; bodies],
            acceleration_change: 0.0,
            touches: Vec::new(),
            space: Space::default(),
            contact: Contact::default(),
            native: Vec::new(),
            last_dt_s: 0.0,
            motor_work_j: 0.0,
            contact_work_j: 0.0,
            forces: vec![[0.0; 3]; bodies],
            means: vec![[0.0; 3]; bodies],
            step_accelerations: vec![[0.0; 3]; bodies],
            impulse: vec![[0.0; 3]; bodies],
            middle: vec![[0.0; 3]; bodies],
            driven: Vec::new(),
            memories: vec![0.0; plan.first_motor() + plan.motors.len()],
            open: Vec::new(),
            overshoot: Vec::new(),
            opening: 0.0,
            tolerance_m: f64::INFINITY,
            settled: Settled::default(),
            normals: Vec::new(),
            before: vec![[0.0; 3]; bodies],
            torques_before: Vec::new(),
        };
        motion.linkage.factorise()?;
        motion.read_means();
        motion.velocities.copy_from_slice(&motion.means);
        drive::set_velocities(plan, 0.0, &mut motion.velocities);
        motion.linkage.project(&mut motion.velocities);
        touch::measure(&motion.world, plan, &motion.linkage, &mut motion.touches);
        motion.look();
        Ok(motion)
    }

    /// One step of rapier, with everything that acts in it.
    pub fn advance(&mut self, dt: f64) -> Result<(), StepError> {
        self.advance_while(dt, &|| true)
    }

    /// The same, unless it may not `go_on`; then the motion is of no more use, nor is it after an error but [`StepError::TooLong`].
    pub fn advance_while(&mut self, dt: f64, go_on: &dyn Fn() -> bool) -> Result<(), StepError> {
        let power_before = frame::power(self.plan, &self.linkage, &self.velocities, self.clock.now());
        touch::grip(self.plan, self.clock.now(), dt, &mut self.touches);
        // Mean velocities of the step, as far as they are known before it.
        for (v, a) in self.middle.iter_mut().zip(self.velocities.iter().zip(&self.accelerations)) {
            *v = std::array::from_fn(|axis| a.0[axis] + 0.5 * dt * a.1[axis]);
        }
        let mut aims = 0;
        loop {
            self.aim(dt);
            let Self { world, plan, linkage, .. } = self;
            let touches = (&self.touches[..], &self.memories[..]);
            self.space.assemble(world, plan, linkage, touches, &self.velocities, &self.step_accelerations, dt);
            self.contact.solve_while(&self.space, dt, go_on)?;
            self.load(dt);
            aims += 1;
            let [opening_m, missed_m] = self.opens(dt);
            if opening_m > TORN * self.tolerance_m || (missed_m > self.tolerance_m && aims == MOST_AIMS) {
                return Err(StepError::TooLong { dt_s: dt, opening_m });
            }
            if missed_m <= WELL_AIMED * self.tolerance_m || aims == MOST_AIMS {
                break;
            }
        }
        self.remember(dt);
        self.contact_work_j += self.contact.work;
        self.motor_work_j += self.contact.motor_work;
        self.motor_work_j -= drive::contact_work(self.plan, &self.space, &self.contact, &self.velocities, dt);
        self.motor_work_j -=
            frame::table_work(self.plan, &self.space, &self.contact, &self.linkage, self.clock.now() + 0.5 * dt);

        for (place, before) in self.linkage.places.iter().zip(&mut self.before) {
            *before = [place.com[0], place.com[1], place.angle];
        }
        self.torques_before.clear();
        let now = self.clock.now();
        self.torques_before.extend(self.plan.motors.iter().map(|motor| motor.characteristic(now).0));
        self.push(dt);
        self.clock.advance(dt);
        self.last_dt_s = dt;

        self.linkage.read_places(&self.world);
        if self.linkage.places.iter().any(|place| !(place.angle + place.com[0] + place.com[1]).is_finite()) {
            return Err(StepError::NotFinite);
        }
        self.linkage.factorise()?;
        self.read_means();
        // Where rapier answers contact, its impulses meet the bodies at the rates of before the step.
        let (work, on_driven) =
            native::read(&self.world, self.plan, &self.touches, &self.velocities, &self.means, &mut self.native);
        self.contact_work_j += work;
        self.motor_work_j -= on_driven;
        self.normals.clear();
        self.normals.extend(self.touches.iter().map(|touch| touch.normal));
        touch::measure(&self.world, self.plan, &self.linkage, &mut self.touches);
        touch::note_turning(&mut self.touches, &self.normals, dt);
        // A jump of the torque at the node belongs to the next step.
        let before_node = self.clock.now() - 1e-9 * dt;
        forces::smooth(self.plan, &self.linkage, before_node, &mut self.forces);
        self.kick(0.5 * dt);
        self.settle();

        // The work of a motor that slows down with its rate was integrated with its torque, along its row.
        for (motor, before) in self.plan.motors.iter().zip(&self.torques_before) {
            if motor.no_load_speed_rad_s.is_none() {
                let turned = motor.shaft(|body| self.linkage.places[body].angle - self.before[body][2]);
                self.motor_work_j += 0.5 * (before + motor.characteristic(before_node).0) * turned;
            }
        }
        let power_after = frame::power(self.plan, &self.linkage, &self.velocities, self.clock.now());
        self.motor_work_j += 0.5 * dt * (power_before + power_after);
        self.look();
        Ok(())
    }

    /// Takes over what bristles have become; those that are out of reach relax.
    fn remember(&mut self, dt: f64) {
        for touch in &self.touches {
            if let Some(bristle) = touch.bristle() {
                self.memories[touch.index] *= exp(-dt * bristle.rate());
            }
        }
        for (site, memory) in self.space.sites.iter().zip(&self.contact.memory) {
            self.memories[site.touch.index] = *memory;
        }
    }

    /// Energy in bristles, J.
    pub fn bristle_energy(&self) -> f64 {
        let of = |touch: &Touch| touch.bristle().map_or(0.0, |bristle| bristle.energy(self.memories[touch.index]));
        self.touches.iter().map(of).sum()
    }

    /// Torque with which a hold answers on its shaft, N·m.
    pub fn hold_torque(&self, hold: usize) -> f64 {
        self.forces(self.plan.first_hold() + hold).1
    }

    /// Normal and tangential force of a stop or contact at the end of the last step, whoever answers there.
    pub fn forces(&self, index: usize) -> (f64, f64) {
        if let Some(at) = self.space.sites.iter().find(|at| at.touch.index == index) {
            let force = &self.contact.force;
            // Before the first step there is none.
            return (force.get(at.normal).copied().unwrap_or(0.0), at.tangent.map_or(0.0, |t| force[t]));
        }
        let native = self.native.iter().find(|native| native.index == index);
        native.map_or((0.0, 0.0), |native| (native.normal / self.last_dt_s, native.tangential / self.last_dt_s))
    }

    /// Whether the bristle of a contact slips at the end of the last step; `None` where it has none, and where nothing presses.
    pub fn slips(&self, index: usize) -> Option<bool> {
        let at = self.space.sites.iter().position(|at| at.touch.index == index)?;
        self.contact.slips(at, &self.space)
    }

    /// Where in the last step a stop or contact pressed hardest, and where it was deepest, if its law was asked in it.
    pub fn contact_extremes(&self, index: usize) -> Option<[Moment; 2]> {
        let at = self.space.sites.iter().position(|at| at.touch.index == index)?;
        Some([*self.contact.peak.get(at)?, *self.contact.deepest.get(at)?])
    }

    /// Normal impulse of a stop or contact in the last step, whoever answers there.
    pub fn normal_impulse(&self, index: usize) -> f64 {
        match self.space.sites.iter().find(|at| at.touch.index == index) {
            Some(at) => self.contact.early[at.normal] + self.contact.late[at.normal],
            None => self.native.iter().find(|native| native.index == index).map_or(0.0, |native| native.normal),
        }
    }

    /// From the mean velocities of the last step to those at its end: the second half of the smooth forces, and the late
    /// impulses of contact along the rows as they are now.
    fn kick(&mut self, half: f64) {
        self.velocities.copy_from_slice(&self.means);
        self.impulse.copy_from_slice(&self.forces);
        self.impulse.iter_mut().flatten().for_each(|force| *force *= half);
        for site in &self.space.sites {
            let touch = self.touches.iter().find(|touch| touch.index == site.touch.index).unwrap_or(&site.touch);
            touch.normal_row.add_to(&mut self.impulse, self.contact.late[site.normal]);
            if let Some(tangent) = site.tangent {
                touch.slip_row.add_to(&mut self.impulse, self.contact.late[tangent]);
            }
        }
        for ((v, impulse), inertia) in self.velocities.iter_mut().zip(&self.impulse).zip(&self.linkage.inertias) {
            v[0] += inertia.inverse_mass * impulse[0];
            v[1] += inertia.inverse_mass * impulse[1];
            v[2] += inertia.inverse_inertia * impulse[2];
        }
        drive::set_velocities(self.plan, self.clock.now(), &mut self.velocities);
        self.linkage.project(&mut self.velocities);
    }

    /// Late impulses were found with the directions and loads of the step's start. Where a contact presses on, what they
    /// miss at its end shows as a rate the contact cannot have: as joints are, such rows are brought back to the rate that
    /// the contact's own equations end with; and where friction creeps, so is the slip. Nothing may pull: a contact whose
    /// late impulse would turn negative is let go.
    fn settle(&mut self) {
        let dt = self.last_dt_s;
        let Self { space, contact, touches, settled, .. } = self;
        settled.begin();
        for (index, site) in space.sites.iter().enumerate() {
            let (normal, force) = (site.normal, contact.force[site.normal]);
            if let (Source::Hold(_) | Source::Motor(_), Some(tangent)) = (site.touch.source, site.tangent) {
                let after = site.touch.friction_after([contact.rate[tangent], contact.memory[index], force], dt);
                settled.take_slip(tangent, site.touch.slip_row, contact.rate[tangent], 0.0, dt * after.by_slip);
                continue;
            }
            // Where every side is fixed or driven there is nothing to settle.
            if force <= 0.0 || space.w[normal * space.len() + normal] == 0.0 {
                continue;
            }
            let Some(touch) = touches.iter().find(|touch| touch.index == site.touch.index) else { continue };
            let law = normal_force(&touch.law, -contact.gap[index], -contact.rate[normal]);
            let stiffness = dt * (law.d_rate + dt * law.d_delta);
            settled.take(normal, touch.normal_row, contact.rate[normal], contact.late[normal], stiffness);
            let Some(tangent) = site.tangent else { continue };
            let after = touch.friction_after([contact.rate[tangent], contact.memory[index], force], dt);
            let creep = (dt * after.by_slip).max(0.0);
            settled.take_slip(tangent, touch.slip_row, contact.rate[tangent], after.by_normal, creep);
        }
        settled.solve(&mut self.linkage, &mut self.velocities);
        let is_driven = |row: usize| space.sites.iter().any(|at| at.tangent == Some(row) && at.touch.drive.is_some());
        let (mut of_contact, mut of_motors) = (0.0, 0.0);
        for (row, work) in settled.works(&self.velocities) {
            *(if is_driven(row) { &mut of_motors } else { &mut of_contact }) += work;
        }
        self.contact_work_j += of_contact;
        self.motor_work_j += of_motors;
        for (index, size) in settled.found() {
            contact.late[index] += size;
        }
    }

    /// Forces and accelerations at the node, for what comes.
    fn look(&mut self) {
        touch::drop_rounding(&mut self.touches, &self.velocities);
        let now = self.clock.now();
        forces::smooth(self.plan, &self.linkage, now, &mut self.forces);
        self.middle.copy_from_slice(&self.accelerations);
        drive::accelerations(self.plan, now, &mut self.driven);
        self.impulse.copy_from_slice(&self.forces);
        forces::add_slowed_motors(self.plan, &self.velocities, now, &mut self.impulse);
        self.linkage.accelerations(&self.impulse, &self.velocities, &self.driven, &mut self.accelerations);
        let changes =
            self.accelerations.iter().zip(&self.middle).map(|(now, then)| hypot(now[0] - then[0], now[1] - then[1]));
        self.acceleration_change = changes.fold(0.0, f64::max);
        self.opening = self.linkage.opening(&self.velocities);
    }

    /// rapier closes a joint along the tangent at the step's start, so that it is open by ½ dt² |J̇ v| at the end. Moving the
    /// anchors by as much beforehand, for the mean velocities in `middle`, leaves a third-order rest.
    fn aim(&mut self, dt: f64) {
        let Self { linkage, open, overshoot, middle, .. } = self;
        overshoot.clear();
        overshoot.extend(linkage.overshoot(middle, dt));
        open.clear();
        open.extend(linkage.open().zip(&*overshoot).map(|(open, more)| [open[0] + more[0], open[1] + more[1]]));
        for ((planned, joint), overshoot) in self.plan.pins.iter().zip(&self.world.joints).zip(&self.overshoot) {
            let Some(joint) = joint.and_then(|handle| self.world.physics.impulse_joints.get_mut(handle, false)) else {
                continue;
            };
            // The moved anchor turns with its body, by ω × shift in the step: what is left is (1 + ω dt ×) shift = overshoot.
            let turn = dt * planned.first.map_or(0.0, |body| self.middle[body][2]);
            let [a, b] = overshoot.map(|x| x / (1.0 + turn * turn));
            let shift = self.linkage.in_frame(planned.first, [a + turn * b, b - turn * a]);
            let [x, y] = planned.anchor_first_m;
            joint.data.set_local_anchor1(Vector::new(x - shift[0], y - shift[1]));
        }
        let (plan, now) = (self.plan, self.clock.now());
        drive::mean_accelerations(plan, &self.linkage.places, &self.velocities, now, dt, &mut self.driven);
        let opening = (&self.open[..], dt);
        self.linkage.accelerations_closing(&self.forces, opening, &self.driven, &mut self.step_accelerations);
    }

    /// Impulses that take rapier from the last mean velocity to the next one: to the node's velocity, half a step of acceleration on,
    /// and what the early impulses of contact add; and that mean velocity, in `middle`. The joints' reactions are in it, so that
    /// rapier's iterative joint solver starts next to its solution.
    fn load(&mut self, dt: f64) {
        for (body, impulse) in self.impulse.iter_mut().enumerate() {
            let inertia = &self.linkage.inertias[body];
            let change: Twist = std::array::from_fn(|axis| {
                self.velocities[body][axis] - self.means[body][axis] + 0.5 * dt * self.step_accelerations[body][axis]
            });
            *impulse = [inertia.mass * change[0], inertia.mass * change[1], inertia.inertia * change[2]];
        }
        self.space.add_impulses(&self.linkage, &self.contact.early, &mut self.impulse);
        let loaded = self.means.iter().zip(&self.impulse).zip(&self.linkage.inertias);
        for (middle, ((mean, impulse), inertia)) in self.middle.iter_mut().zip(loaded) {
            let inverse = [inertia.inverse_mass, inertia.inverse_mass, inertia.inverse_inertia];
            *middle = std::array::from_fn(|axis| mean[axis] + inverse[axis] * impulse[axis]);
        }
    }

    /// How far the mean velocities in `middle` open a pin in a step, and how far that is from what the anchors were moved for, m.
    fn opens(&mut self, dt: f64) -> [f64; 2] {
        let Self { linkage, overshoot, middle, .. } = self;
        let opened = linkage.overshoot(middle, dt).zip(&*overshoot);
        opened.fold([0.0; 2], |[most, missed], (opens, aimed)| {
            [most.max(hypot(opens[0], opens[1])), missed.max(hypot(opens[0] - aimed[0], opens[1] - aimed[1]))]
        })
    }

    /// One step of rapier under these impulses, as forces over the step.
    fn push(&mut self, dt: f64) {
        let physics = &mut self.world.physics;
        for (impulse, handle) in self.impulse.iter().zip(&self.world.bodies) {
            let body = &mut physics.bodies[*handle];
            body.reset_forces(false);
            body.reset_torques(false);
            body.add_force(Vector::new(impulse[0] / dt, impulse[1] / dt), false);
            body.add_torque(impulse[2] / dt, false);
        }
        drive::steer(self.plan, &self.linkage.places, &self.world.bodies, &mut physics.bodies, self.clock.now(), dt);
        physics.integration_parameters.dt = dt;
        physics.step_with_events(&Governed, &());
    }

    /// Mean velocities of the last step.
    fn read_means(&mut self) {
        let dt = self.last_dt_s;
        for (i, v) in self.means.iter_mut().enumerate() {
            let body = &self.world.physics.bodies[self.world.bodies[i]];
            *v = match self.world.construction {
                // The links of a multibody show velocities that are a step old.
                Construction::Reduced if dt > 0.0 => {
                    let (place, before) = (&self.linkage.places[i], &self.before[i]);
                    let mean = |now: f64, then: f64| (now - then) / dt;
                    [mean(place.com[0], before[0]), mean(place.com[1], before[1]), mean(place.angle, before[2])]
                }
                _ => [body.linvel().x, body.linvel().y, body.angvel()],
            };
        }
    }
}
