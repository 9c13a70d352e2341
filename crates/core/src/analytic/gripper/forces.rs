//! Accelerations: every finger and every contact in the few coordinates it depends on, put together.

use super::coordinates::{Where, of_finger, of_object, of_object_in_time, of_phalanx};
use super::frame;
use super::inertia::Inertia;
use super::model::GripperModel;
use super::touch::{self, Press};
use super::{FINGERS, GripperMode, LOST, PLACES, QUADRATURES, TIME, WORK};
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
    fn add<const K: usize>(&mut self, place: usize, press: &Press<f64, K>, at: &[Where; K]) {
        for (part, (row, sign)) in press.load.iter().zip(at) {
            if *row < N {
                self.load[*row] += sign * part;
            }
        }
        self.g[place] += press.normal;
        self.g[LOST] += press.power;
    }
}

/// The palm, then the table, with their indices among all places.
pub(super) const PLANES: [(usize, Place); 2] = [(PLACES - 2, Place::Palm), (PLACES - 1, Place::Table)];

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
        let index = Place::Finger(side, Site::Limit).index();
        if let Some(law) = finger.normal_law(Site::Limit).filter(|_| mode[index].presses()) {
            let touch = touch::limit(&finger.limit_geometry(&terms.pose, &terms.rates));
            sums.add(index, &touch::press(&touch, &own, (law, None), mode[index]), &of_finger(side));
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
        let (finger, index) = (&self.fingers[side as usize], Place::Finger(side, site).index());
        let Some(law) = finger.normal_law(site).filter(|_| mode[index].presses()) else { return };
        let touch = self.phalanx(finger, (&terms.pose, &terms.rates), site, self.centre_in_finger(side, q));
        let press = touch::press(&touch, &self.rates_in_finger(side, v), (law, finger.friction_law(site)), mode[index]);
        sums.add(index, &press, &of_phalanx(side));
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
        for drive in &self.drives {
            let pulls = [(Some(drive.pull(t, [v[0], v[2]])), WORK), (drive.hold(t, [v[0], v[2]]), LOST)];
            for (pull, work) in pulls.into_iter().filter_map(|(pull, work)| Some((pull?, work))) {
                (0..2).for_each(|side| sums.load[2 * side] += drive.weights[side] * pull.torque);
                sums.g[work] += pull.torque * pull.rate;
            }
        }
        let ([x, y, _], rates) = (self.object_of(q), self.object_rates(v));
        for (index, place) in PLANES {
            let Some(plane) = self.plane(place).filter(|_| mode[index].presses()) else { continue };
            let laws = (&plane.law.normal, plane.law.friction.as_ref());
            if Self::MOVES && place == Place::Table {
                let touch = frame::table(plane, &self.pose(q), 0.0, [x, y], self.object.radius);
                let rates = [rates[0], rates[1], v[TIME], rates[2]];
                sums.add(index, &touch::press(&touch, &rates, laws, mode[index]), &of_object_in_time());
                // What the table does to all in the frame, by coming along.
                sums.g[WORK] -= sums.load[TIME];
                continue;
            }
            let touch = touch::plane(plane, [x, y], self.object.radius);
            sums.add(index, &touch::press(&touch, &rates, laws, mode[index]), &of_object(1.0));
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
