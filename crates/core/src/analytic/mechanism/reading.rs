//! Readings of a state: poses, joints, actuators, contacts and energies.

use super::actuator::effort;
use super::contacts::Surfaces;
use super::model::{MechanismMode, MechanismModel};
use super::motion::Motions;
use crate::analytic::ContactState;
use crate::analytic::contact::{ContactReading, Energies, Geometry, StateRef, normal_force_on_branch, row_dot};
use crate::integrator::Dynamic;
use crate::law::{FrictionKind, FrictionLaw, FrictionRange, elastic_energy};
use crate::mechanism::Pose;
use crate::numeric::plane::dot;
use crate::shape::Support;

use super::pairs;

impl MechanismModel {
    /// Pose and rate of a body, relative to a moving palm.
    pub fn body(&self, state: StateRef<'_, Dynamic>, body: usize) -> (Pose, Pose) {
        self.with_angles(state, |motions| self.body_relative_to_palm(motions, body))
    }

    /// Reads pose and rate, as given by [`MechanismModel::body`], of each body that samples report, in their order.
    pub fn read_bodies(&self, state: StateRef<'_, Dynamic>, mut read: impl FnMut(usize, (Pose, Pose))) {
        self.with_angles(state, |motions| {
            let reported = self.mechanism.reported_bodies().enumerate();
            reported.for_each(|(index, body)| read(index, self.body_relative_to_palm(motions, body)));
        });
    }

    fn body_relative_to_palm(&self, motions: &Motions<f64>, body: usize) -> (Pose, Pose) {
        if self.world.as_ref().is_some_and(|(world, _)| *world == body) {
            // In the frame of the palm, the palm itself is at rest.
            return Default::default();
        }
        let (palm, motion) = (motions.body(self.palm), motions.body(Some(body)));
        let origin = motion.point(self.reported_origins[body]);
        let [x, y] = palm.point_in_frame(origin.position);
        let [vx, vy] = palm.velocity_in_frame(origin.position, origin.rate);
        ([x, y, motion.angle - palm.angle], [vx, vy, motion.rate[2] - palm.rate[2]])
    }

    /// Indices of the bodies that samples report.
    pub fn reported_bodies(&self) -> impl Iterator<Item = usize> + '_ {
        self.mechanism.reported_bodies()
    }

    /// Reads the coordinates and rates of all joints.
    pub fn read_joints(&self, state: StateRef<'_, Dynamic>, mut read: impl FnMut(usize, (f64, f64))) {
        self.with_angles(state, |motions| {
            motions.joints.iter().enumerate().for_each(|(index, joint)| read(index, (joint.coordinate, joint.rate)));
        });
    }

    /// Reads the efforts of all actuators including their brakes: torques or forces of joints first, then tensions of
    /// tendons.
    pub fn read_actuators(
        &self,
        t: f64,
        state: StateRef<'_, Dynamic>,
        mode: &MechanismMode,
        mut read: impl FnMut(usize, f64),
    ) {
        let of_joints = self.mechanism.actuators.len();
        self.with_motions(state, |motions| {
            (0..of_joints).for_each(|index| read(index, self.actuator_effort(t, (mode, state.1), motions, index)));
        });
        let pulls = self.cables.iter().filter(|cable| cable.tendon.actuator.is_some());
        pulls.enumerate().for_each(|(index, cable)| read(of_joints + index, cable.pull(t).0));
    }

    pub(super) fn actuator_effort(
        &self,
        t: f64,
        (mode, v): (&MechanismMode, &[f64]),
        motions: &Motions<f64>,
        index: usize,
    ) -> f64 {
        let actuator = &self.mechanism.actuators[index];
        let motion = motions.combination(&actuator.on);
        let brake = self.brake_effort(t, v, index, motion.rate).map_or(0.0, |brake| brake.effort.value);
        if let Some(drive) = self.drive_of(index) {
            return self.drive_effort(drive, t, (mode, v), motions) + brake;
        }
        let range = self.range_at(t, mode, index, motion.coordinate, motion.rate);
        effort(actuator, range, t, motion.coordinate, motion.rate).value + brake
    }

    /// Geometry and forces of a contact, as in samples: relative to a moving palm. For a limit they are an angle and a
    /// torque, or a distance and a force.
    pub fn contact_reading(&self, state: StateRef<'_, Dynamic>, index: usize, branch: ContactState) -> ContactReading {
        let read = |motions: &Motions<f64>| self.reading_relative_to_palm(motions, state.1, index, branch);
        match self.palm {
            Some(_) => self.with_motions(state, read),
            None => self.with_contact(state, index, read),
        }
    }

    /// Reads the first `count` contacts in a mode, each as [`MechanismModel::contact_reading`].
    pub fn read_contacts(
        &self,
        state: StateRef<'_, Dynamic>,
        mode: &MechanismMode,
        count: usize,
        mut read: impl FnMut(usize, ContactReading),
    ) {
        self.with_motions(state, |motions| {
            (0..count).for_each(|k| read(k, self.reading_relative_to_palm(motions, state.1, k, mode[k])));
        });
    }

    fn reading_relative_to_palm(
        &self,
        motions: &Motions<f64>,
        v: &[f64],
        index: usize,
        branch: ContactState,
    ) -> ContactReading {
        let mut reading = self.world_reading(motions, v, index, branch);
        if self.palm.is_some() {
            let palm = motions.body(self.palm);
            reading.geometry.point = palm.point_in_frame(reading.geometry.point);
            reading.geometry.normal = palm.in_frame(reading.geometry.normal);
        }
        if self.contacts[index].is_reported_on_face {
            reading.geometry.normal = reading.geometry.normal.map(|component| -component);
        }
        reading
    }

    /// [`MechanismModel::contact_reading`] in the world.
    pub(super) fn world_reading(
        &self,
        motions: &Motions<f64>,
        v: &[f64],
        index: usize,
        branch: ContactState,
    ) -> ContactReading {
        let (contact, none) = (&self.contacts[index], [0.0; 2]);
        let (gap, gap_rate, slip, normal, point) = match &contact.surfaces {
            Surfaces::Point(pair) => {
                let (kinematics, rates) = self.point_kinematics(motions, pair, None);
                let [gap_rate, slip] = [kinematics.normal_row, kinematics.tangent_row].map(|row| row_dot(&row, &rates));
                (kinematics.gap, gap_rate, slip, kinematics.normal, kinematics.point)
            }
            Surfaces::Limit(limit) => {
                let [coordinate, rate] = self.limited(motions, limit);
                (limit.side * (limit.value - coordinate), -limit.side * rate, 0.0, none, none)
            }
            Surfaces::Friction(joint) => (-1.0, 0.0, motions.joints[*joint].rate, none, none),
            Surfaces::Cable(cable, element) => {
                (-1.0, 0.0, self.slip_on(motions, &self.cables[*cable], *element), none, none)
            }
            Surfaces::Tendon(index) => {
                let elongation = self.elongation(motions, &self.cables[*index]);
                (-elongation.value, -elongation.rate, 0.0, none, none)
            }
        };
        let force = normal_force_on_branch(&contact.normal, branch, -gap, -gap_rate).force.max(0.0);
        let state = contact.state.map(|state| v[state]);
        let friction = |law: &FrictionLaw| law.force(slip, state, force, FrictionRange::Any);
        let tangential = contact.friction.as_ref().map_or(0.0, friction);
        let geometry = Geometry { gap, normal_row: none, tangent_row: none, normal, point, support: Support::none() };
        ContactReading { geometry, delta: -gap, delta_rate: -gap_rate, slip, normal: force, tangential }
    }

    /// Kinetic energy of the bodies and their energy in gravity, in the frame of a moving palm or of the equations (`None`),
    /// with gravity in the axes of this frame at the start.
    fn body_energies(&self, motions: &Motions<f64>, frame: Option<usize>) -> [f64; 2] {
        let gravity = match self.mechanism.palm().filter(|_| frame.is_some()) {
            Some((_, motion)) => motion.in_initial_axes(self.mechanism.gravity_m_s2),
            None => self.mechanism.gravity_m_s2,
        };
        let frame = motions.body(frame);
        self.mechanism.bodies.iter().zip(&motions.bodies).fold([0.0; 2], |[kinetic, potential], (body, motion)| {
            let [x, y, spin] = motion.rate;
            let (rate, spin) = (frame.velocity_in_frame(motion.origin, [x, y]), spin - frame.rate[2]);
            [
                kinetic + 0.5 * (body.mass_kg * dot(rate, rate) + body.inertia_kg_m2 * spin * spin),
                potential - body.mass_kg * dot(gravity, frame.point_in_frame(motion.origin)),
            ]
        })
    }

    /// Work of a moving palm in its own frame minus its work in the world since the start, where it is at rest.
    pub fn frame_work(&self, state: StateRef<'_, Dynamic>) -> f64 {
        if self.palm.is_none() {
            return 0.0;
        }
        self.with_motions(state, |motions| {
            let [in_frame, in_world] = [self.palm, None].map(|frame| self.body_energies(motions, frame));
            in_frame[0] + in_frame[1] - in_world[0] - in_world[1]
        })
    }

    /// Energies stored in a state, in the frame of a moving palm.
    pub fn energies(&self, state: StateRef<'_, Dynamic>) -> Energies {
        self.energies_at_gaps(state, |_| None)
    }

    /// [`MechanismModel::energies`] with the gaps of contacts, if they are known.
    pub(crate) fn energies_at_gaps(
        &self,
        state: StateRef<'_, Dynamic>,
        gap_of: impl Fn(usize) -> Option<f64>,
    ) -> Energies {
        let mut energies = Energies::default();
        self.with_angles(state, |motions| {
            [energies.kinetic, energies.gravity] = self.body_energies(motions, self.palm);
            for element in self.groups.iter().flat_map(|group| &group.elements) {
                let motion = motions.combination(&element.on);
                let stretch = motion.coordinate - element.rest;
                energies.kinetic += 0.5 * element.inertia * motion.rate * motion.rate;
                energies.spring += 0.5 * element.stiffness * stretch * stretch - element.preload * motion.coordinate;
            }
            for (index, bodies, points_m) in self.linear_springs() {
                let spring = &self.mechanism.springs[index];
                let stretch = pairs::spring(points_m, &Self::frames(motions, bodies)).length - spring.rest;
                energies.spring += 0.5 * spring.stiffness * stretch * stretch;
            }
            for (index, contact) in self.contacts.iter().enumerate() {
                if !matches!(contact.surfaces, Surfaces::Friction(_) | Surfaces::Cable(..)) {
                    let depth = || self.world_reading(motions, state.1, index, ContactState::Free).delta;
                    energies.elastic += elastic_energy(&contact.normal, gap_of(index).map_or_else(depth, |gap| -gap));
                }
            }
        });
        // The friction of a cable is proportional to its tension, and has no stored energy.
        let stores = |(index, _): &&(usize, FrictionKind)| {
            let of_cable = self.contacts.iter().rev().take_while(|of| matches!(of.surfaces, Surfaces::Cable(..)));
            !of_cable.into_iter().any(|contact| contact.state == Some(*index))
        };
        let stored = self.friction_states.iter().filter(stores);
        energies.elastic += stored.map(|(index, kind)| kind.energy(state.1[*index])).sum::<f64>();
        energies
    }
}
