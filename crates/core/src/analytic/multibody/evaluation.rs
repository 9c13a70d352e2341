//! Forces and kinematics of one contact, and the energies, in one state.

use super::components::ContactPair;
use super::inertia::{Inertia, Inverse};
use super::model::Multibody;
use super::{FINGERS, normal_force_on_branch};
use crate::analytic::ContactState;
use crate::analytic::contact::Geometry;
use crate::analytic::finger::PassiveJoints;
use crate::analytic::mode::row_dot;
use crate::analytic::model::{ContactReading, Energies};
use crate::fivebar::dynamics::Terms;
use crate::law::{elastic_energy, friction_with_state};
use crate::numeric::plane::dot;
use crate::numeric::{map_array, map_same_type};
use crate::shape::Support;

impl<const N: usize, const C: usize> Multibody<N, C> {
    fn terms(&self, q: &[f64; N]) -> [Option<Terms<f64>>; FINGERS] {
        let mut all = [None; FINGERS];
        for (finger, terms) in all.iter_mut().enumerate().take(self.finger_count()) {
            *terms = Some(self.fingers[finger].model.terms(Self::finger_coordinates(finger, q)));
        }
        all
    }

    fn inertia(&self, terms: &[Option<Terms<f64>>; FINGERS]) -> Inertia<'_, N, C> {
        Inertia::new(self, map_array(*terms, |terms| terms.map_or([0.0; 3], |terms| terms.mass)))
    }

    /// Inverse of the mass matrix at these coordinates.
    pub(super) fn inverse(&self, q: &[f64; N]) -> Inverse<'_, N, C> {
        self.inertia(&self.terms(q)).inverse()
    }

    /// Evaluates one contact, with point and normal in the palm's frame; `None` where the scene has no such contact.
    ///
    /// The normal of a phalanx points from the object to the phalanx; between two discs it points to the first disc.
    /// The normals of palm and table point out of the disc if there are fingers, and into it otherwise. Slip and
    /// friction are positive along the normal turned counter-clockwise, also for a left phalanx; the signs of mirrored
    /// contacts differ.
    pub fn contact_reading(
        &self,
        q: &[f64; N],
        v: &[f64; N],
        index: usize,
        state: ContactState,
    ) -> Option<ContactReading> {
        let contact = self.contacts.get(index)?.as_ref()?;
        let kinematics = self.contact_kinematics_noinline(q, &|finger| self.finger_kinematics(finger, q), contact);
        let (delta, delta_rate, slip) =
            (-kinematics.gap, -row_dot(&kinematics.normal_row, v), row_dot(&kinematics.tangent_row, v));
        let normal = normal_force_on_branch(&contact.normal, state, delta, delta_rate).force.max(0.0);
        let friction = |law| friction_with_state(law, slip, self.bristle_state(contact, v), normal);
        let tangential = contact.friction.as_ref().map_or(0.0, friction);
        let none = [0.0; 2];
        let (mut sign, [x, y]) = (1.0, kinematics.normal);
        let (point, direction) = match contact.pair {
            ContactPair::Phalanx { finger, .. } => {
                let side = self.fingers[finger].side;
                sign = side.mirror();
                (self.point_in_palm_frame(side, kinematics.point), [sign * x, y])
            }
            ContactPair::Stop { finger } => {
                sign = self.fingers[finger].side.mirror();
                (none, [sign * x, y])
            }
            ContactPair::Discs { .. } => (kinematics.point, kinematics.normal),
            ContactPair::Plane { .. } if !self.shares_contact_point() => (kinematics.point, kinematics.normal),
            ContactPair::Plane { .. } | ContactPair::MovingPlane { .. } => {
                (kinematics.point, map_same_type(kinematics.normal, |component| -component))
            }
        };
        let geometry = Geometry {
            gap: kinematics.gap,
            normal_row: none,
            tangent_row: none,
            normal: direction,
            point,
            support: Support::none(),
        };
        Some(ContactReading { geometry, delta, delta_rate, slip: sign * slip, normal, tangential: sign * tangential })
    }

    /// Angles and rates of a finger's passive joints.
    pub fn passive_joints(&self, finger: usize, q: &[f64; N], v: &[f64; N]) -> PassiveJoints {
        let model = &self.fingers[finger].model;
        let (q, v) = (Self::finger_coordinates(finger, q), Self::finger_coordinates(finger, v));
        let (pose, rates) = model.kinematics(q);
        model.passive_joints(&pose, &rates, q, v)
    }

    /// Energies of a state.
    pub fn energies(&self, q: &[f64; N], v: &[f64; N]) -> Energies {
        let terms = self.terms(q);
        let kinetic = self.inertia(&terms).kinetic(v);
        let mut energies = Energies { elastic: self.bristle_energy(v), kinetic, ..Energies::default() };
        for (component, terms) in self.fingers.iter().zip(terms.iter().flatten()) {
            let [gravity, spring] = component.model.potential_energies(&terms.pose);
            energies.gravity += gravity;
            energies.spring += spring;
        }
        for (index, disc) in self.discs.iter().enumerate().filter(|(_, disc)| disc.first_coordinate < N) {
            let [x, y, _] = self.disc_pose(index, q);
            energies.gravity -= disc.mass * dot(self.gravity, [x, y]);
        }
        let finger_kinematics = |finger: usize| match &terms[finger] {
            Some(terms) => (terms.pose, terms.rates),
            None => self.finger_kinematics(finger, q),
        };
        for contact in self.contacts.iter().flatten() {
            energies.elastic +=
                elastic_energy(&contact.normal, -self.contact_kinematics_noinline(q, &finger_kinematics, contact).gap);
        }
        energies
    }
}
