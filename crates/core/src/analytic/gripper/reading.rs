//! One contact, and the energies, in one state.

use super::inertia::{Inertia, Inverse};
use super::model::GripperModel;
use super::{FINGERS, branch};
use crate::analytic::SiteState;
use crate::analytic::contact::Geometry;
use crate::analytic::finger::Passive;
use crate::analytic::mode::along;
use crate::analytic::model::{Energies, SiteReading};
use crate::fivebar::dynamics::Terms;
use crate::law::{elastic_energy, friction_with_memory};
use crate::numeric::plane::dot;
use crate::scene::{Place, Side};

impl<const N: usize> GripperModel<N> {
    /// Coordinates of a finger, of all.
    #[inline(always)]
    pub(super) fn own(side: Side, all: &[f64; N]) -> [f64; 2] {
        let first = 2 * side as usize;
        [all[first], all[first + 1]]
    }

    fn terms(&self, side: Side, q: &[f64; N]) -> Terms<f64> {
        self.fingers[side as usize].terms(Self::own(side, q))
    }

    /// What solves the mass matrix in a posture.
    pub(super) fn inverse(&self, q: &[f64; N]) -> Inverse {
        Inertia::new(self, Side::BOTH.map(|side| self.terms(side, q).mass)).inverse()
    }

    /// Everything there is to know of one contact, point and normal in the palm's frame; `None` where the scene has no such contact.
    ///
    /// The normal points away from the object: forces are those on phalanx, palm and table. Slip and friction are along the normal turned counter-clockwise, of a left phalanx too: of two that do the same in their mirror,
    /// signs differ.
    pub fn reading(&self, q: &[f64; N], v: &[f64; N], place: Place, state: SiteState) -> Option<SiteReading> {
        let touch = self.touch(q, |side| self.posture(side, q), place)?;
        let law = self.normal_law(place)?;
        let (delta, delta_rate, slip) = (-touch.gap, -along(&touch.normal_row, v), along(&touch.tangent_row, v));
        let normal = branch(law, state, delta, delta_rate).force.max(0.0);
        let friction = |law| friction_with_memory(law, slip, self.memory(v, place), normal);
        let tangential = self.friction_law(place).map_or(0.0, friction);
        let none = [0.0; 2];
        let turned = if let Place::Finger(side, _) = place { side.mirror() } else { 1.0 };
        let (point, direction) = match place {
            Place::Finger(side, _) => {
                let [x, y] = touch.normal;
                let point = if touch.normal == none { none } else { self.in_palm(side, touch.point) };
                (point, [side.mirror() * x, y])
            }
            Place::Palm | Place::Table => (touch.point, touch.normal.map(|part| -part)),
        };
        let geometry = Geometry { gap: touch.gap, normal_row: none, tangent_row: none, normal: direction, point };
        Some(SiteReading { geometry, delta, delta_rate, slip: turned * slip, normal, tangential: turned * tangential })
    }

    /// Passive joints of a finger and their rates.
    pub fn passive(&self, side: Side, q: &[f64; N], v: &[f64; N]) -> Passive {
        let finger = &self.fingers[side as usize];
        let (q, v) = (Self::own(side, q), Self::own(side, v));
        let (pose, rates) = finger.place(q);
        finger.passive(&pose, &rates, q, v)
    }

    /// Energies of a state.
    pub fn energies(&self, q: &[f64; N], v: &[f64; N]) -> Energies {
        let fingers = Side::BOTH.map(|side| self.terms(side, q));
        let mut energies = Energies {
            elastic: self.bristle_energy(v),
            kinetic: Inertia::new(self, [fingers[0].mass, fingers[1].mass]).kinetic(v),
            ..Energies::default()
        };
        for (finger, terms) in self.fingers.iter().zip(&fingers) {
            let [gravity, spring] = finger.potential(&terms.pose);
            energies.gravity += gravity;
            energies.spring += spring;
        }
        if N > FINGERS {
            energies.gravity -= self.object.mass * dot(self.object.gravity, [q[FINGERS], q[FINGERS + 1]]);
        }
        let posture = |side: Side| (fingers[side as usize].pose, fingers[side as usize].rates);
        for place in Place::ALL {
            let Some((touch, law)) = self.touch(q, posture, place).zip(self.normal_law(place)) else { continue };
            energies.elastic += elastic_energy(law, -touch.gap);
        }
        energies
    }
}
