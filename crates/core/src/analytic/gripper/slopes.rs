//! Accelerations with their exact Jacobian: that of every finger and every contact in the few coordinates it depends on, put together.

use super::coordinates::{Where, of_finger, of_object, of_phalanx, scatter};
use super::forces::PLANES;
use super::inertia::Inertia;
use super::model::{GripperModel, variables};
use super::touch::{self, Press, Slope};
use super::{FINGERS, GripperMode, PLACES, QUADRATURES};
use crate::fivebar::dynamics::Terms;
use crate::gripper::Site;
use crate::integrator::{Linearised, Rates};
use crate::numeric::Dual;
use crate::scene::{Place, Side};

/// Loads on all coordinates and rates of all quadratures, with their derivatives.
struct Sums<const N: usize> {
    load: [f64; N],
    load_q: [[f64; N]; N],
    load_v: [[f64; N]; N],
    load_t: [f64; N],
    g: [f64; QUADRATURES],
    g_q: [[f64; N]; QUADRATURES],
    g_v: [[f64; N]; QUADRATURES],
    g_t: [f64; QUADRATURES],
}

impl<const N: usize> Sums<N> {
    const ZERO: Self = Self {
        load: [0.0; N],
        load_q: [[0.0; N]; N],
        load_v: [[0.0; N]; N],
        load_t: [0.0; N],
        g: [0.0; QUADRATURES],
        g_q: [[0.0; N]; QUADRATURES],
        g_v: [[0.0; N]; QUADRATURES],
        g_t: [0.0; QUADRATURES],
    };

    /// Adds a contact whose rates are those of `at`, and whose place depends on the first P of them.
    #[inline(always)]
    fn add<const P: usize, const K: usize>(&mut self, place: usize, press: &Press<Slope<P, K>, K>, at: &[Where; K]) {
        for (part, (row, sign)) in press.load.iter().zip(at) {
            if *row < N {
                self.load[*row] += sign * part.value;
                scatter(&mut self.load_q[*row], at, &part.by_q.map(|slope| sign * slope));
                scatter(&mut self.load_v[*row], at, &part.by_v.map(|slope| sign * slope));
            }
        }
        for (index, part) in [(place, &press.normal), (PLACES, &press.power)] {
            self.g[index] += part.value;
            scatter(&mut self.g_q[index], at, &part.by_q);
            scatter(&mut self.g_v[index], at, &part.by_v);
        }
    }
}

impl<const N: usize> GripperModel<N> {
    /// Accelerations, and their derivatives by coordinates, rates and time.
    pub(super) fn with_slopes(
        &self,
        t: f64,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &GripperMode,
    ) -> Linearised<N, QUADRATURES> {
        let mut sums = Sums::<N>::ZERO;
        let right = self.add_finger_slopes(Side::Right, (q, v), mode, &mut sums);
        let left = self.add_finger_slopes(Side::Left, (q, v), mode, &mut sums);
        self.add_drive_slopes(t, v, &mut sums);
        for (index, place) in PLANES {
            let Some(plane) = self.plane(place).filter(|_| mode[index].presses()) else { continue };
            let [x, y, _] = self.object_of(q);
            let touch = touch::plane(plane, variables([x, y]), self.object.radius);
            let laws = (&plane.law.normal, plane.law.friction.as_ref());
            let press = touch::press_with_slopes(&touch, &self.object_rates(v), laws, mode[index]);
            sums.add(index, &press, &of_object(1.0));
        }
        if N > FINGERS {
            (0..2).for_each(|i| sums.load[FINGERS + i] += self.object.mass * self.object.gravity[i]);
        }
        let masses = [right, left];
        let inverse = Inertia::new(self, masses.map(|mass| mass.map(|m| m.value))).inverse();
        let a = inverse.solve(&sums.load);
        // M a = load: where an angle changes M too, M ∂a = ∂load − ∂M a.
        for (side, mass) in masses.iter().enumerate() {
            let (first, second) = (2 * side, 2 * side + 1);
            for (k, j) in [first, second].into_iter().enumerate() {
                let [m, c, n] = mass.map(|m| m.grad[k]);
                sums.load_q[first][j] -= m * a[first] + c * a[second];
                sums.load_q[second][j] -= c * a[first] + n * a[second];
            }
        }
        Linearised {
            rates: Rates { a, g: sums.g },
            a_q: inverse.solve_columns(&sums.load_q),
            a_v: inverse.solve_columns(&sums.load_v),
            a_t: inverse.solve(&sums.load_t),
            g_q: sums.g_q,
            g_v: sums.g_v,
            g_t: sums.g_t,
        }
    }

    /// Adds what acts on a finger, and gives its mass matrix, with derivatives. The side is known where this is inlined.
    #[inline(always)]
    fn add_finger_slopes(
        &self,
        side: Side,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &GripperMode,
        sums: &mut Sums<N>,
    ) -> [Dual<2>; 3] {
        let finger = &self.fingers[side as usize];
        let own = Self::own(side, v);
        let terms = finger.terms(variables(Self::own(side, q)));
        let (load, by_rates) = finger.load_with_slopes(&terms, own);
        for (i, (load, by_rates)) in load.iter().zip(by_rates).enumerate() {
            let row = 2 * side as usize + i;
            sums.load[row] += load.value;
            scatter(&mut sums.load_q[row], &of_finger(side), &load.grad);
            scatter(&mut sums.load_v[row], &of_finger(side), &by_rates);
        }
        self.add_phalanx_slopes((side, Site::Proximal), (q, v), mode, &terms, sums);
        self.add_phalanx_slopes((side, Site::Distal), (q, v), mode, &terms, sums);
        let index = Place::Finger(side, Site::Limit).index();
        if let Some(law) = finger.normal_law(Site::Limit).filter(|_| mode[index].presses()) {
            let touch = touch::limit(&finger.limit_geometry(&terms.pose, &terms.rates));
            sums.add(index, &touch::press_with_slopes(&touch, &own, (law, None), mode[index]), &of_finger(side));
        }
        terms.mass
    }

    #[inline(always)]
    fn add_phalanx_slopes(
        &self,
        (side, site): (Side, Site),
        (q, v): (&[f64; N], &[f64; N]),
        mode: &GripperMode,
        terms: &Terms<Dual<2>>,
        sums: &mut Sums<N>,
    ) {
        let (finger, index) = (&self.fingers[side as usize], Place::Finger(side, site).index());
        let Some(law) = finger.normal_law(site).filter(|_| mode[index].presses()) else { return };
        // Where surfaces are depends on the finger's angles and the centre, not on how the object is turned.
        let [x, y] = self.centre_in_finger(side, q);
        let centre = [Dual::<4>::variable(x, 2), Dual::variable(y, 3)];
        let touch = self.phalanx(finger, (&terms.pose.widen(), &terms.rates.widen()), site, centre);
        let laws = (law, finger.friction_law(site));
        let press = touch::press_with_slopes(&touch, &self.rates_in_finger(side, v), laws, mode[index]);
        sums.add(index, &press, &of_phalanx(side));
    }

    #[inline(always)]
    fn add_drive_slopes(&self, t: f64, v: &[f64; N], sums: &mut Sums<N>) {
        const WORK: usize = PLACES + 1;
        for drive in &self.drives {
            let pull = drive.pull(t, [v[0], v[2]]);
            sums.g[WORK] += pull.torque * pull.rate;
            sums.g_t[WORK] += pull.by_time * pull.rate;
            for (i, weight) in drive.weights.into_iter().enumerate() {
                sums.load[2 * i] += weight * pull.torque;
                sums.load_t[2 * i] += weight * pull.by_time;
                sums.g_v[WORK][2 * i] += weight * (pull.torque + pull.by_rate * pull.rate);
                (0..2).for_each(|j| sums.load_v[2 * i][2 * j] += weight * drive.weights[j] * pull.by_rate);
            }
        }
    }
}
