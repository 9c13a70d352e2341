//! Accelerations: every finger and every contact in the few coordinates it depends on, put together.

use super::coordinates::{Where, of_finger, of_object, of_phalanx};
use super::inertia::Inertia;
use super::model::GripperModel;
use super::touch::{self, Press};
use super::{FINGERS, GripperMode, PLACES, QUADRATURES};
use crate::fivebar::dynamics::Terms;
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
        self.g[PLACES] += press.power;
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
        mode: &GripperMode,
        sums: &mut Sums<N>,
    ) -> [f64; 3] {
        let finger = &self.fingers[side as usize];
        let own = Self::own(side, v);
        let terms = finger.terms(Self::own(side, q));
        let load = finger.load(0.0, &terms, own);
        (0..2).for_each(|i| sums.load[2 * side as usize + i] += load[i]);
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
        let right = self.add_finger(Side::Right, (q, v), mode, &mut sums);
        let left = self.add_finger(Side::Left, (q, v), mode, &mut sums);
        for drive in &self.drives {
            let pull = drive.pull(t, [v[0], v[2]]);
            (0..2).for_each(|side| sums.load[2 * side] += drive.weights[side] * pull.torque);
            sums.g[PLACES + 1] += pull.torque * pull.rate;
        }
        for (index, place) in PLANES {
            let Some(plane) = self.plane(place).filter(|_| mode[index].presses()) else { continue };
            let [x, y, _] = self.object_of(q);
            let touch = touch::plane(plane, [x, y], self.object.radius);
            let laws = (&plane.law.normal, plane.law.friction.as_ref());
            sums.add(index, &touch::press(&touch, &self.object_rates(v), laws, mode[index]), &of_object(1.0));
        }
        if N > FINGERS {
            (0..2).for_each(|i| sums.load[FINGERS + i] += self.object.mass * self.object.gravity[i]);
        }
        Rates { a: Inertia::new(self, [right, left]).inverse().solve(&sums.load), g: sums.g }
    }

    fn linearise(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &GripperMode) -> Linearised<N, QUADRATURES> {
        self.with_slopes(t, (q, v), mode)
    }
}
