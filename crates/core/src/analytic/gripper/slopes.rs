//! Accelerations with their exact Jacobian: that of every finger and every contact in the few coordinates it depends on, put together.

use super::coordinates::{
    Where, memory_of, memory_of_brake, of_finger, of_object, of_object_in_time, of_phalanx, scatter,
};
use super::forces::PLANES;
use super::frame::{self, Felt};
use super::inertia::Inertia;
use super::model::{GripperModel, Pull, variables};
use super::touch::{self, Press, Slope};
use super::{FINGERS, GripperMode, LOST, QUADRATURES, TIME, WORK};
use crate::fivebar::carried::Field;
use crate::fivebar::dynamics::{Terms, absolute_rates};
use crate::gripper::Site;
use crate::integrator::{Linearised, Rates};
use crate::numeric::{Dual, Real};
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
    fn add<const P: usize, const K: usize>(&mut self, place: Place, press: &Press<Slope<P, K>, K>, at: &[Where; K]) {
        let memory = memory_of(place).filter(|memory| *memory < N);
        for (part, (row, sign)) in press.load.iter().zip(at) {
            if *row < N {
                self.load[*row] += sign * part.value;
                scatter(&mut self.load_q[*row], at, &part.by_q.map(|slope| sign * slope));
                scatter(&mut self.load_v[*row], at, &part.by_v.map(|slope| sign * slope));
                memory.into_iter().for_each(|memory| self.load_v[*row][memory] += sign * part.by_memory);
            }
        }
        if let Some(memory) = memory {
            self.load[memory] += press.driven.value;
            scatter(&mut self.load_q[memory], at, &press.driven.by_q);
            scatter(&mut self.load_v[memory], at, &press.driven.by_v);
            self.load_v[memory][memory] += press.driven.by_memory;
            self.g_v[LOST][memory] += press.power.by_memory;
        }
        for (index, part) in [(place.index(), &press.normal), (LOST, &press.power)] {
            self.g[index] += part.value;
            scatter(&mut self.g_q[index], at, &part.by_q);
            scatter(&mut self.g_v[index], at, &part.by_v);
        }
    }

    /// Adds what turns both driven links by these parts of it.
    #[inline(always)]
    fn add_pull(&mut self, pull: &Pull, weights: [f64; 2], work: usize) {
        self.g[work] += pull.torque * pull.rate;
        self.g_t[work] += pull.by_time * pull.rate;
        for (i, weight) in weights.into_iter().enumerate() {
            self.load[2 * i] += weight * pull.torque;
            self.load_t[2 * i] += weight * pull.by_time;
            self.g_v[work][2 * i] += weight * (pull.torque + pull.by_rate * pull.rate);
            (0..2).for_each(|j| self.load_v[2 * i][2 * j] += weight * weights[j] * pull.by_rate);
        }
    }

    /// What the table does to all in the frame, by coming along: the power of its force on time.
    fn let_table_work(&mut self) {
        self.g[WORK] -= self.load[TIME];
        for j in 0..N {
            self.g_q[WORK][j] -= self.load_q[TIME][j];
            self.g_v[WORK][j] -= self.load_v[TIME][j];
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
        let felt = self.felt(t);
        let right = self.add_finger_slopes(Side::Right, (q, v), (mode, &felt), &mut sums);
        let left = self.add_finger_slopes(Side::Left, (q, v), (mode, &felt), &mut sums);
        self.add_drive_slopes(t, v, &mut sums);
        let ([x, y, _], rates) = (self.object_of(q), self.object_rates(v));
        for place in PLANES {
            let Some((plane, laws)) = self.plane(place).zip(self.laws(place, mode)) else { continue };
            let memory = self.memory(v, place);
            if Self::MOVES && place == Place::Table {
                let centre = [Dual::<3>::variable(x, 0), Dual::variable(y, 1)];
                let touch = frame::table(plane, &self.pose(q), Dual::variable(0.0, 2), centre, self.object.radius);
                let rates = [rates[0], rates[1], v[TIME], rates[2]];
                let press = touch::press_with_slopes(&touch, &rates, memory, laws);
                sums.add(place, &press, &of_object_in_time());
                sums.let_table_work();
                continue;
            }
            let touch = touch::plane(plane, variables([x, y]), self.object.radius);
            sums.add(place, &touch::press_with_slopes(&touch, &rates, memory, laws), &of_object(1.0));
        }
        if Self::HOLDS {
            for (memory, bristle) in self.bristles() {
                sums.load[memory] -= bristle.rate() * v[memory];
                sums.load_v[memory][memory] -= bristle.rate();
            }
        }
        if N > FINGERS {
            (0..2).for_each(|i| sums.load[FINGERS + i] += self.object.mass * self.object.gravity[i]);
        }
        if Self::MOVES {
            self.add_object_slopes(q, v, &felt, &mut sums);
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
        (mode, felt): (&GripperMode, &Felt),
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
        if Self::MOVES {
            self.add_felt_slopes(side, own, &terms, felt, sums);
        }
        self.add_phalanx_slopes((side, Site::Proximal), (q, v), mode, &terms, sums);
        self.add_phalanx_slopes((side, Site::Distal), (q, v), mode, &terms, sums);
        let limit = Place::Finger(side, Site::Limit);
        if let Some(laws) = self.laws(limit, mode) {
            let touch = touch::limit(&finger.limit_geometry(&terms.pose, &terms.rates));
            sums.add(limit, &touch::press_with_slopes(&touch, &own, None, laws), &of_finger(side));
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
        let (finger, place) = (&self.fingers[side as usize], Place::Finger(side, site));
        let Some(laws) = self.laws(place, mode) else { return };
        // Where surfaces are depends on the finger's angles and the centre, not on how the object is turned.
        let [x, y] = self.centre_in_finger(side, q);
        let centre = [Dual::<4>::variable(x, 2), Dual::variable(y, 3)];
        let touch = self.phalanx(finger, (&terms.pose.widen(), &terms.rates.widen()), site, centre);
        let memory = self.memory(v, place);
        let press = touch::press_with_slopes(&touch, &self.rates_in_finger(side, v), memory, laws);
        sums.add(place, &press, &of_phalanx(side));
    }

    /// What a finger's links feel in a frame that moves.
    fn add_felt_slopes(&self, side: Side, own: [f64; 2], terms: &Terms<Dual<2>>, felt: &Felt, sums: &mut Sums<N>) {
        let (carried, first) = (&self.carried[side as usize], 2 * side as usize);
        let [field, rate] = [felt.field, felt.rate].map(|field| field.mirrored(side.mirror()));
        let forces = |v: [f64; 2], field: &Field| {
            let rates = absolute_rates(&terms.rates, v.map(Dual::constant));
            carried.forces(&terms.pose, &terms.rates, rates, field)
        };
        let (now, soon) = (forces(own, &field), forces(own, &rate));
        let swept = Field { coriolis: field.coriolis, ..Field::default() };
        let by_rates = [[1.0, 0.0], [0.0, 1.0]].map(|unit| forces(unit, &swept).map(|force| force.value));
        for i in 0..2 {
            let row = first + i;
            sums.load[row] += now[i].value;
            sums.load_t[row] += soon[i].value;
            sums.g[WORK] += now[i].value * own[i];
            sums.g_t[WORK] += soon[i].value * own[i];
            sums.g_v[WORK][row] += now[i].value;
            for (j, by_rate) in by_rates.iter().enumerate() {
                sums.load_q[row][first + j] += now[i].grad[j];
                sums.load_v[row][first + j] += by_rate[i];
                sums.g_q[WORK][first + j] += now[i].grad[j] * own[i];
                sums.g_v[WORK][first + j] += by_rate[i] * own[i];
            }
        }
    }

    /// What the object feels there: linear in where it is and how it moves.
    fn add_object_slopes(&self, q: &[f64; N], v: &[f64; N], felt: &Felt, sums: &mut Sums<N>) {
        let (place, rates) = (self.object_of(q), self.object_rates(v));
        let now = self.object_feels(&felt.field, place, rates);
        let soon = self.object_feels(&felt.rate, place, rates);
        let linear = Field { uniform: [0.0; 2], euler: felt.field.euler, ..felt.field };
        let unit = |j: usize| std::array::from_fn(|k| if k == j { 1.0 } else { 0.0 });
        let (mut by_q, mut by_v) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for j in 0..2 {
            by_q[j] = self.object_feels(&linear, unit(j), [0.0; 3]);
            by_v[j] = self.object_feels(&linear, [0.0; 3], unit(j));
            // The couple depends on neither.
            (by_q[j][2], by_v[j][2]) = (0.0, 0.0);
        }
        for i in 0..3 {
            let row = FINGERS + i;
            sums.load[row] += now[i];
            sums.load_t[row] += soon[i];
            sums.g[WORK] += now[i] * rates[i];
            sums.g_t[WORK] += soon[i] * rates[i];
            sums.g_v[WORK][row] += now[i];
            for j in 0..3 {
                sums.load_q[row][FINGERS + j] += by_q[j][i];
                sums.load_v[row][FINGERS + j] += by_v[j][i];
                sums.g_q[WORK][FINGERS + j] += by_q[j][i] * rates[i];
                sums.g_v[WORK][FINGERS + j] += by_v[j][i] * rates[i];
            }
        }
    }

    #[inline(always)]
    fn add_drive_slopes(&self, t: f64, v: &[f64; N], sums: &mut Sums<N>) {
        for (index, drive) in self.drives.iter().enumerate() {
            sums.add_pull(&drive.pull(t, [v[0], v[2]]), drive.weights, WORK);
            let Some(hold) = drive.hold(t, [v[0], v[2]], self.brake_memory(v, index)) else { continue };
            sums.add_pull(&hold.pull, drive.weights, LOST);
            if !Self::HOLDS {
                continue;
            }
            let memory = memory_of_brake(index);
            sums.load[memory] += hold.driven;
            sums.load_t[memory] += hold.gain * hold.pull.by_time;
            sums.load_v[memory][memory] += hold.gain * hold.by_memory;
            sums.g_v[LOST][memory] += hold.by_memory * hold.pull.rate;
            for (i, weight) in drive.weights.into_iter().enumerate() {
                sums.load_v[2 * i][memory] += weight * hold.by_memory;
                sums.load_v[memory][2 * i] += weight * hold.gain * hold.pull.by_rate;
            }
        }
    }
}
