//! Accelerations, and their exact Jacobian: every finger and every contact in the few variables it depends on, put together.

use super::inertia::Inertia;
use super::model::{GripperModel, variables};
use super::touch::{self, Press, Touch};
use super::{FINGERS, GripperMode, PLACES, QUADRATURES};
use crate::analytic::finger::FingerModel;
use crate::fivebar::kinematics::{Directions, PassiveRates};
use crate::gripper::Site;
use crate::integrator::{Linearised, Rates, System};
use crate::numeric::plane::Vector;
use crate::numeric::{Dual, Real};
use crate::scene::{Place, Side};

/// A coordinate of the gripper and the sign with which a part has it; one that is not there (of a fixed object) is beyond the last.
type Where = (usize, f64);

/// Coordinates of a finger.
fn of_finger(side: Side) -> [Where; 2] {
    let first = 2 * side as usize;
    [(first, 1.0), (first + 1, 1.0)]
}

/// Coordinates of the object as a finger's frame has them.
fn of_object(mirror: f64) -> [Where; 3] {
    [(FINGERS, mirror), (FINGERS + 1, 1.0), (FINGERS + 2, mirror)]
}

/// Coordinates of a phalanx's contact.
pub(super) fn of_phalanx(side: Side) -> [Where; 5] {
    let ([a, b], [x, y, angle]) = (of_finger(side), of_object(side.mirror()));
    [a, b, x, y, angle]
}

/// Values of coordinates or rates where a part has them.
#[inline(always)]
pub(super) fn gather<const N: usize, const K: usize>(all: &[f64; N], at: &[Where; K]) -> [f64; K] {
    at.map(|(index, sign)| if index < N { sign * all[index] } else { 0.0 })
}

/// Loads on all coordinates and rates of all quadratures, with their derivatives.
struct Sums<const N: usize> {
    load: [f64; N],
    load_q: [[f64; N]; N],
    load_v: [[f64; N]; N],
    g: [f64; QUADRATURES],
    g_q: [[f64; N]; QUADRATURES],
    g_v: [[f64; N]; QUADRATURES],
}

impl<const N: usize> Sums<N> {
    const ZERO: Self = Self {
        load: [0.0; N],
        load_q: [[0.0; N]; N],
        load_v: [[0.0; N]; N],
        g: [0.0; QUADRATURES],
        g_q: [[0.0; N]; QUADRATURES],
        g_v: [[0.0; N]; QUADRATURES],
    };

    /// Adds loads that depend on positions first and rates then, in the order of `positions` and `rates`.
    #[inline(always)]
    fn add_load<const K: usize, const D: usize>(
        &mut self,
        load: &[Dual<D>; K],
        at: &[Where; K],
        (positions, rates): (&[Where], &[Where]),
    ) {
        for (part, (row, sign)) in load.iter().zip(at) {
            if *row < N {
                self.load[*row] += sign * part.value;
                let slopes = part.grad.map(|slope| sign * slope);
                scatter(&mut self.load_q[*row], positions, &slopes);
                scatter(&mut self.load_v[*row], rates, &slopes[positions.len()..]);
            }
        }
    }

    #[inline(always)]
    fn add_quadrature<const D: usize>(&mut self, index: usize, g: &Dual<D>, (positions, rates): (&[Where], &[Where])) {
        self.g[index] += g.value;
        scatter(&mut self.g_q[index], positions, &g.grad);
        scatter(&mut self.g_v[index], rates, &g.grad[positions.len()..]);
    }

    #[inline(always)]
    fn add_press<const K: usize, const D: usize>(
        &mut self,
        place: usize,
        press: &Press<Dual<D>, K>,
        at: &[Where; K],
        variables: (&[Where], &[Where]),
    ) {
        self.add_load(&press.load, at, variables);
        self.add_quadrature(place, &press.normal, variables);
        self.add_quadrature(PLACES, &press.power, variables);
    }
}

#[inline(always)]
fn scatter<const N: usize>(row: &mut [f64; N], at: &[Where], slopes: &[f64]) {
    for ((index, sign), slope) in at.iter().zip(slopes) {
        if *index < N {
            row[*index] += sign * slope;
        }
    }
}

impl<const N: usize> GripperModel<N> {
    /// Where a phalanx touches the object, whose centre is given in the finger's frame.
    #[inline(always)]
    fn phalanx<T: Real>(
        &self,
        finger: &FingerModel,
        (pose, rates): (&Directions<T>, &PassiveRates<T>),
        site: Site,
        centre: Vector<T>,
    ) -> Touch<T, 5> {
        let radius = self.object.radius;
        touch::phalanx(&finger.phalanx(pose, rates, site, (centre, radius)), radius)
    }

    #[inline(always)]
    fn add_fingers(&self, q: &[f64; N], v: &[f64; N], mode: &GripperMode, sums: &mut Totals<N>) -> [[f64; 3]; 2] {
        let [x, y, _] = self.object_of(q);
        let [vx, vy, spin] = self.object_rates(v);
        Side::BOTH.map(|side| {
            let (finger, at, mirror) = (&self.fingers[side as usize], of_phalanx(side), side.mirror());
            let own = [v[at[0].0], v[at[1].0]];
            let terms = finger.terms([q[at[0].0], q[at[1].0]]);
            let [first, second] = finger.load(0.0, &terms, own);
            (sums.load[at[0].0], sums.load[at[1].0]) = (sums.load[at[0].0] + first, sums.load[at[1].0] + second);
            let centre = self.in_finger(side, [x, y]);
            for site in Site::ALL {
                let index = Site::ALL.len() * side as usize + site as usize;
                if !mode[index].presses() {
                    continue;
                }
                let place = Place::Finger(side, site);
                let Some(law) = self.normal_law(place) else { continue };
                let laws = (law, self.friction_law(place));
                if site == Site::Limit {
                    let touch = touch::limit(&finger.limit_geometry(&terms.pose, &terms.rates));
                    sums.add(index, &touch::press(&touch, &own, laws, mode[index]), &[at[0], at[1]]);
                } else {
                    let rates = [own[0], own[1], mirror * vx, vy, mirror * spin];
                    let touch = self.phalanx(finger, (&terms.pose, &terms.rates), site, centre);
                    sums.add(index, &touch::press(&touch, &rates, laws, mode[index]), &at);
                }
            }
            terms.mass
        })
    }
}

/// Loads and rates of quadratures without derivatives.
struct Totals<const N: usize> {
    load: [f64; N],
    g: [f64; QUADRATURES],
}

impl<const N: usize> Totals<N> {
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
const PLANES: [(usize, Place); 2] = [(PLACES - 2, Place::Palm), (PLACES - 1, Place::Table)];

impl<const N: usize> System<N, QUADRATURES> for GripperModel<N> {
    type Mode = GripperMode;

    #[inline(always)]
    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &GripperMode) -> Rates<N, QUADRATURES> {
        let mut sums = Totals { load: [0.0; N], g: [0.0; QUADRATURES] };
        let mass = self.add_fingers(q, v, mode, &mut sums);
        for drive in &self.drives {
            let pull = drive.pull(t, [v[0], v[2]]);
            (0..2).for_each(|side| sums.load[2 * side] += drive.weights[side] * pull.torque);
            sums.g[PLACES + 1] += pull.torque * pull.rate;
        }
        let object = self.object_rates(v);
        for (index, place) in PLANES {
            let Some(plane) = self.plane(place).filter(|_| mode[index].presses()) else { continue };
            let [x, y, _] = self.object_of(q);
            let touch = touch::plane(plane, [x, y], self.object.radius);
            let laws = (&plane.law.normal, plane.law.friction.as_ref());
            sums.add(index, &touch::press(&touch, &object, laws, mode[index]), &of_object(1.0));
        }
        if N > FINGERS {
            (0..2).for_each(|i| sums.load[FINGERS + i] += self.object.mass * self.object.gravity[i]);
        }
        Rates { a: Inertia::new(self, mass).inverse().solve(&sums.load), g: sums.g }
    }

    fn linearise(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &GripperMode) -> Linearised<N, QUADRATURES> {
        let mut sums = Sums::<N>::ZERO;
        let (mut a_t, mut g_t) = ([0.0; N], [0.0; QUADRATURES]);
        let [x, y, _] = self.object_of(q);
        let masses = Side::BOTH.map(|side| {
            let (finger, at) = (&self.fingers[side as usize], of_phalanx(side));
            let (first, second) = (at[0].0, at[1].0);
            let narrow = finger.terms(variables([q[first], q[second]]));
            let wide = narrow.widen();
            let own: [Dual<4>; 2] = [Dual::variable(v[first], 2), Dual::variable(v[second], 3)];
            let within = (&at[..2], &at[..2]);
            sums.add_load(&finger.load(Dual::zero(), &wide, own), &[at[0], at[1]], within);
            let centre = self.in_finger(side, [x, y]);
            for site in Site::ALL {
                let index = Site::ALL.len() * side as usize + site as usize;
                if !mode[index].presses() {
                    continue;
                }
                let place = Place::Finger(side, site);
                let Some(law) = self.normal_law(place) else { continue };
                let laws = (law, self.friction_law(place));
                if site == Site::Limit {
                    let touch = touch::limit(&finger.limit_geometry(&wide.pose, &wide.rates));
                    let press = touch::press(&touch, &own, laws, mode[index]);
                    sums.add_press(index, &press, &[at[0], at[1]], within);
                } else {
                    // Where surfaces are depends on the finger's angles and the centre, not on how the object is turned.
                    let centre: [Dual<4>; 2] = [Dual::variable(centre[0], 2), Dual::variable(centre[1], 3)];
                    let touch = self.phalanx(finger, (&wide.pose, &wide.rates), site, centre).among::<9>();
                    let rates = gather(v, &at);
                    let rates: [Dual<9>; 5] = std::array::from_fn(|k| Dual::variable(rates[k], 4 + k));
                    let press = touch::press(&touch, &rates, laws, mode[index]);
                    sums.add_press(index, &press, &at, (&at[..4], &at));
                }
            }
            narrow.mass
        });
        for drive in &self.drives {
            let pull = drive.pull(t, [v[0], v[2]]);
            sums.g[PLACES + 1] += pull.torque * pull.rate;
            g_t[PLACES + 1] += pull.by_time * pull.rate;
            for (i, weight) in drive.weights.into_iter().enumerate() {
                sums.load[2 * i] += weight * pull.torque;
                a_t[2 * i] += weight * pull.by_time;
                sums.g_v[PLACES + 1][2 * i] += weight * (pull.torque + pull.by_rate * pull.rate);
                (0..2).for_each(|j| sums.load_v[2 * i][2 * j] += weight * drive.weights[j] * pull.by_rate);
            }
        }
        let at = of_object(1.0);
        let object = self.object_rates(v);
        for (index, place) in PLANES {
            let Some(plane) = self.plane(place).filter(|_| mode[index].presses()) else { continue };
            let centre: [Dual<5>; 2] = [Dual::variable(x, 0), Dual::variable(y, 1)];
            let rates: [Dual<5>; 3] = std::array::from_fn(|k| Dual::variable(object[k], 2 + k));
            let touch = touch::plane(plane, centre, self.object.radius);
            let laws = (&plane.law.normal, plane.law.friction.as_ref());
            let press = touch::press(&touch, &rates, laws, mode[index]);
            sums.add_press(index, &press, &at, (&at[..2], &at));
        }
        if N > FINGERS {
            (0..2).for_each(|i| sums.load[FINGERS + i] += self.object.mass * self.object.gravity[i]);
        }
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
            a_q: by_columns(&sums.load_q, |column| inverse.solve(column)),
            a_v: by_columns(&sums.load_v, |column| inverse.solve(column)),
            a_t: inverse.solve(&a_t),
            g_q: sums.g_q,
            g_v: sums.g_v,
            g_t,
        }
    }
}

#[inline(always)]
fn by_columns<const N: usize>(matrix: &[[f64; N]; N], solve: impl Fn(&[f64; N]) -> [f64; N]) -> [[f64; N]; N] {
    let mut solved = [[0.0; N]; N];
    for j in 0..N {
        let column = solve(&std::array::from_fn(|i| matrix[i][j]));
        (0..N).for_each(|i| solved[i][j] = column[i]);
    }
    solved
}

impl Touch<Dual<4>, 5> {
    /// The same with rates among the variables.
    #[inline(always)]
    fn among<const M: usize>(&self) -> Touch<Dual<M>, 5> {
        Touch {
            gap: self.gap.among(),
            normal_row: self.normal_row.map(Dual::among),
            tangent_row: self.tangent_row.map(Dual::among),
            normal: self.normal.map(Dual::among),
            point: self.point.map(Dual::among),
        }
    }
}

impl<const N: usize> GripperModel<N> {
    /// Pose of a finger with its passive rates.
    #[inline(always)]
    pub(super) fn posture(&self, side: Side, q: &[f64; N]) -> Posture {
        self.fingers[side as usize].place(Self::own(side, q))
    }

    /// Those of both.
    #[inline(always)]
    pub(super) fn postures(&self, q: &[f64; N]) -> [Posture; 2] {
        Side::BOTH.map(|side| self.posture(side, q))
    }

    /// A contact at any place with plain numbers, its rows among all coordinates; `None` where the scene has no such contact.
    #[inline(always)]
    pub(super) fn touch(
        &self,
        q: &[f64; N],
        posture: impl FnOnce(Side) -> Posture,
        place: Place,
    ) -> Option<Touch<f64, N>> {
        self.normal_law(place)?;
        let [x, y, _] = self.object_of(q);
        match place {
            Place::Finger(side, site) => {
                let (finger, (pose, rates)) = (&self.fingers[side as usize], posture(side));
                if site == Site::Limit {
                    return Some(spread(&touch::limit(&finger.limit_geometry(&pose, &rates)), &of_finger(side)));
                }
                let centre = self.in_finger(side, [x, y]);
                Some(spread(&self.phalanx(finger, (&pose, &rates), site, centre), &of_phalanx(side)))
            }
            Place::Palm | Place::Table => {
                let touch = touch::plane(self.plane(place)?, [x, y], self.object.radius);
                Some(spread(&touch, &of_object(1.0)))
            }
        }
    }
}

/// Pose of a finger with its passive rates.
pub(super) type Posture = (Directions<f64>, PassiveRates<f64>);

/// Rows of a part as rows of all coordinates.
#[inline(always)]
fn spread<const N: usize, const K: usize>(touch: &Touch<f64, K>, at: &[Where; K]) -> Touch<f64, N> {
    let row = |part: &[f64; K]| {
        let mut row = [0.0; N];
        scatter(&mut row, at, part);
        row
    };
    let (normal_row, tangent_row) = (row(&touch.normal_row), row(&touch.tangent_row));
    Touch { gap: touch.gap, normal_row, tangent_row, normal: touch.normal, point: touch.point }
}
