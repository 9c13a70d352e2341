//! One contact, and the energies, in one state.

use super::inertia::{Inertia, Inverse};
use super::model::Multibody;
use super::parts::Meet;
use super::{FINGERS, branch};
use crate::analytic::SiteState;
use crate::analytic::contact::Geometry;
use crate::analytic::finger::Passive;
use crate::analytic::mode::along;
use crate::analytic::model::{Energies, SiteReading};
use crate::fivebar::dynamics::Terms;
use crate::law::{elastic_energy, friction_with_memory};
use crate::numeric::plane::dot;
use crate::numeric::{changed, from_each};
use crate::shape::Support;

impl<const N: usize, const C: usize> Multibody<N, C> {
    fn terms(&self, q: &[f64; N]) -> [Option<Terms<f64>>; FINGERS] {
        let mut all = [None; FINGERS];
        for (finger, terms) in all.iter_mut().enumerate().take(self.count()) {
            *terms = Some(self.fingers[finger].model.terms(Self::own(finger, q)));
        }
        all
    }

    fn inertia(&self, terms: &[Option<Terms<f64>>; FINGERS]) -> Inertia<'_, N, C> {
        Inertia::new(self, from_each(*terms, |terms| terms.map_or([0.0; 3], |terms| terms.mass)))
    }

    /// What solves the mass matrix in a posture.
    pub(super) fn inverse(&self, q: &[f64; N]) -> Inverse<'_, N, C> {
        self.inertia(&self.terms(q)).inverse()
    }

    /// Everything there is to know of one contact, point and normal in the palm's frame; `None` where the scene has no such contact.
    ///
    /// The normal of a phalanx points away from what it touches, that of two discs to the first; where there are fingers, those of palm and
    /// table point out of the disc, and into it where there are none. Slip and friction are along the normal turned counter-clockwise, of a
    /// left phalanx too: of two that do the same in their mirror, signs differ.
    pub fn reading(&self, q: &[f64; N], v: &[f64; N], index: usize, state: SiteState) -> Option<SiteReading> {
        let contact = self.contacts.get(index)?.as_ref()?;
        let touch = self.touch_apart(q, &|finger| self.posture(finger, q), contact);
        let (delta, delta_rate, slip) = (-touch.gap, -along(&touch.normal_row, v), along(&touch.tangent_row, v));
        let normal = branch(&contact.normal, state, delta, delta_rate).force.max(0.0);
        let friction = |law| friction_with_memory(law, slip, self.remembered(contact, v), normal);
        let tangential = contact.friction.as_ref().map_or(0.0, friction);
        let none = [0.0; 2];
        let (mut turned, [x, y]) = (1.0, touch.normal);
        let (point, direction) = match contact.meet {
            Meet::Phalanx { finger, .. } => {
                let side = self.fingers[finger].side;
                turned = side.mirror();
                (self.in_palm(side, touch.point), [turned * x, y])
            }
            Meet::Stop { finger } => {
                turned = self.fingers[finger].side.mirror();
                (none, [turned * x, y])
            }
            Meet::Discs { .. } => (touch.point, touch.normal),
            Meet::Plane { .. } if !self.meets_in_one_point() => (touch.point, touch.normal),
            Meet::Plane { .. } | Meet::PassingPlane { .. } => (touch.point, changed(touch.normal, |part| -part)),
        };
        let geometry = Geometry {
            gap: touch.gap,
            normal_row: none,
            tangent_row: none,
            normal: direction,
            point,
            support: Support::none(),
        };
        Some(SiteReading { geometry, delta, delta_rate, slip: turned * slip, normal, tangential: turned * tangential })
    }

    /// Passive joints of a finger and their rates.
    pub fn passive(&self, finger: usize, q: &[f64; N], v: &[f64; N]) -> Passive {
        let part = &self.fingers[finger].model;
        let (q, v) = (Self::own(finger, q), Self::own(finger, v));
        let (pose, rates) = part.place(q);
        part.passive(&pose, &rates, q, v)
    }

    /// Energies of a state.
    pub fn energies(&self, q: &[f64; N], v: &[f64; N]) -> Energies {
        let terms = self.terms(q);
        let kinetic = self.inertia(&terms).kinetic(v);
        let mut energies = Energies { elastic: self.bristle_energy(v), kinetic, ..Energies::default() };
        for (part, terms) in self.fingers.iter().zip(terms.iter().flatten()) {
            let [gravity, spring] = part.model.potential(&terms.pose);
            energies.gravity += gravity;
            energies.spring += spring;
        }
        for (index, disc) in self.discs.iter().enumerate().filter(|(_, disc)| disc.first < N) {
            let [x, y, _] = self.place_of(index, q);
            energies.gravity -= disc.mass * dot(self.gravity, [x, y]);
        }
        let posture = |finger: usize| match &terms[finger] {
            Some(terms) => (terms.pose, terms.rates),
            None => self.posture(finger, q),
        };
        for contact in self.contacts.iter().flatten() {
            energies.elastic += elastic_energy(&contact.normal, -self.touch_apart(q, &posture, contact).gap);
        }
        energies
    }
}
