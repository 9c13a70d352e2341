//! Accelerations: every finger and every contact in the few coordinates it depends on, put together.

use super::coordinates::{Where, memory_of, memory_of_brake, of_finger, of_object, of_object_in_time, of_phalanx};
use super::frame;
use super::inertia::Inertia;
use super::model::GripperModel;
use super::touch::{self, Press};
use super::{FINGERS, GripperMode, LOST, QUADRATURES, TIME, WORK};
use crate::fivebar::carried::Field;
use crate::fivebar::dynamics::{Terms, absolute_rates};
use crate::gripper::Site;
use crate::integrator::{Linearised, Rates, System};
use crate::scene::{Place, Side};

/// Loads on all coordinates, and rates of all quadratures.
struct Sums<const N: usize> {
    load: [f64; N],
    g: [f64; QUADRATURES],
}

impl<const N: usize> Sums<N> {
    #[inline(always)]
    fn add<const K: usize>(&mut self, place: Place, press: &Press<f64, K>, at: &[Where; K]) {
        for (part, (row, sign)) in press.load.iter().zip(at) {
            if *row < N {
                self.load[*row] += sign * part;
            }
        }
        self.g[place.index()] += press.normal;
        self.g[LOST] += press.power;
        if let Some(memory) = memory_of(place).filter(|memory| *memory < N) {
            self.load[memory] += press.driven;
        }
    }
}

/// What the object alone meets.
pub(super) const PLANES: [Place; 2] = [Place::Palm, Place::Table];

impl<const N: usize> GripperModel<N> {
    /// Adds what acts on a finger, and gives its mass matrix. The side is known where this is inlined: written out for both of them,
    /// every index is a constant.
    #[inline(always)]
    fn add_finger(
        &self,
        side: Side,
        (q, v): (&[f64; N], &[f64; N]),
        (mode, field): (&GripperMode, &Field),
        sums: &mut Sums<N>,
    ) -> [f64; 3] {
        let finger = &self.fingers[side as usize];
        let own = Self::own(side, v);
        let terms = finger.terms(Self::own(side, q));
        let load = finger.load(0.0, &terms, own);
        (0..2).for_each(|i| sums.load[2 * side as usize + i] += load[i]);
        if Self::MOVES {
            let rates = absolute_rates(&terms.rates, own);
            let field = field.mirrored(side.mirror());
            let felt = self.carried[side as usize].forces(&terms.pose, &terms.rates, rates, &field);
            (0..2).for_each(|i| sums.load[2 * side as usize + i] += felt[i]);
            sums.g[WORK] += felt[0] * own[0] + felt[1] * own[1];
        }
        self.add_phalanx((side, Site::Proximal), (q, v), mode, &terms, sums);
        self.add_phalanx((side, Site::Distal), (q, v), mode, &terms, sums);
        let limit = Place::Finger(side, Site::Limit);
        if let Some(laws) = self.laws(limit, mode) {
            let touch = touch::limit(&finger.limit_geometry(&terms.pose, &terms.rates));
            sums.add(limit, &touch::press(&touch, &own, None, laws), &of_finger(side));
        }
        terms.mass
    }

    #[inline(always)]
    fn add_phalanx(
        &self,
        (side, site): (Side, Site),
        (q, v): (&[f64; N], &[f64; N]),
        mode: &GripperMode,
        terms: &Terms<f64>,
        sums: &mut Sums<N>,
    ) {
        let (finger, place) = (&self.fingers[side as usize], Place::Finger(side, site));
        let Some(laws) = self.laws(place, mode) else { return };
        let touch = self.phalanx(finger, (&terms.pose, &terms.rates), site, self.centre_in_finger(side, q));
        let press = touch::press(&touch, &self.rates_in_finger(side, v), self.memory(v, place), laws);
        sums.add(place, &press, &of_phalanx(side));
    }
}

impl<const N: usize> System<N, QUADRATURES> for GripperModel<N> {
    type Mode = GripperMode;

    #[inline(always)]
    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &GripperMode) -> Rates<N, QUADRATURES> {
        let mut sums = Sums { load: [0.0; N], g: [0.0; QUADRATURES] };
        let field = self.felt(t).field;
        let right = self.add_finger(Side::Right, (q, v), (mode, &field), &mut sums);
        let left = self.add_finger(Side::Left, (q, v), (mode, &field), &mut sums);
        for (index, drive) in self.drives.iter().enumerate() {
            let pull = drive.pull(t, [v[0], v[2]]);
            (0..2).for_each(|side| sums.load[2 * side] += drive.weights[side] * pull.torque);
            sums.g[WORK] += pull.torque * pull.rate;
            let Some(hold) = drive.hold(t, [v[0], v[2]], self.brake_memory(v, index)) else { continue };
            (0..2).for_each(|side| sums.load[2 * side] += drive.weights[side] * hold.pull.torque);
            sums.g[LOST] += hold.pull.torque * hold.pull.rate;
            if Self::HOLDS {
                sums.load[memory_of_brake(index)] += hold.driven;
            }
        }
        let ([x, y, _], rates) = (self.object_of(q), self.object_rates(v));
        for place in PLANES {
            let Some((plane, laws)) = self.plane(place).zip(self.laws(place, mode)) else { continue };
            let memory = self.memory(v, place);
            if Self::MOVES && place == Place::Table {
                let touch = frame::table(plane, &self.pose(q), 0.0, [x, y], self.object.radius);
                let rates = [rates[0], rates[1], v[TIME], rates[2]];
                sums.add(place, &touch::press(&touch, &rates, memory, laws), &of_object_in_time());
                // What the table does to all in the frame, by coming along.
                sums.g[WORK] -= sums.load[TIME];
                continue;
            }
            let touch = touch::plane(plane, [x, y], self.object.radius);
            sums.add(place, &touch::press(&touch, &rates, memory, laws), &of_object(1.0));
        }
        if Self::HOLDS {
            self.bristles().for_each(|(memory, bristle)| sums.load[memory] -= bristle.rate() * v[memory]);
        }
        if N > FINGERS {
            (0..2).for_each(|i| sums.load[FINGERS + i] += self.object.mass * self.object.gravity[i]);
        }
        if Self::MOVES {
            let felt = self.object_feels(&field, self.object_of(q), rates);
            (0..3).for_each(|i| sums.load[FINGERS + i] += felt[i]);
            sums.g[WORK] += (0..3).map(|i| felt[i] * rates[i]).sum::<f64>();
        }
        Rates { a: Inertia::new(self, [right, left]).inverse().solve(&sums.load), g: sums.g }
    }

    fn linearise(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &GripperMode) -> Linearised<N, QUADRATURES> {
        self.with_slopes(t, (q, v), mode)
    }
}
