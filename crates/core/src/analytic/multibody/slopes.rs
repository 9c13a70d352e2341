//! Accelerations with their exact Jacobian: that of every finger and every contact in the few coordinates it depends on, put together.

use super::coordinates::{Where, of_disc, of_disc_in_time, of_discs, of_finger, of_phalanx, scatter};
use super::drive::Pull;
use super::frame::{Felt, disc_feels};
use super::inertia::Inertia;
use super::laws::Laws;
use super::model::Multibody;
use super::parts::{FingerPart, Joined, Meet};
use super::pressing;
use super::touch::{Press, Slope};
use super::{FINGERS, mode};
use crate::fivebar::carried::Field;
use crate::fivebar::dynamics::{Terms, absolute_rates};
use crate::integrator::{Linearised, Rates};
use crate::numeric::{Dual, Real, changed, each, from_each};

/// Loads on all coordinates and rates of all quadratures, with their derivatives.
struct Sums<const N: usize, const Z: usize> {
    load: [f64; N],
    load_q: [[f64; N]; N],
    load_v: [[f64; N]; N],
    load_t: [f64; N],
    g: [f64; Z],
    g_q: [[f64; N]; Z],
    g_v: [[f64; N]; Z],
    g_t: [f64; Z],
}

impl<const N: usize, const Z: usize> Sums<N, Z> {
    const ZERO: Self = Self {
        load: [0.0; N],
        load_q: [[0.0; N]; N],
        load_v: [[0.0; N]; N],
        load_t: [0.0; N],
        g: [0.0; Z],
        g_q: [[0.0; N]; Z],
        g_v: [[0.0; N]; Z],
        g_t: [0.0; Z],
    };

    /// Adds a contact whose rates are those of `at`, and whose place depends on the first P of them.
    #[inline(always)]
    fn add<const P: usize, const K: usize>(
        &mut self,
        (index, contact): (usize, &Joined),
        press: &Press<Slope<P, K>, K>,
        at: &[Where; K],
    ) {
        let (memory, lost) = (contact.memory, Z - 2);
        for (part, (row, sign)) in press.load.iter().zip(at) {
            if *row < N {
                self.load[*row] += sign * part.value;
                scatter(&mut self.load_q[*row], at, &changed(part.by_q, |slope| sign * slope));
                scatter(&mut self.load_v[*row], at, &changed(part.by_v, |slope| sign * slope));
                memory.into_iter().for_each(|memory| self.load_v[*row][memory] += sign * part.by_memory);
            }
        }
        if let Some(memory) = memory {
            self.load[memory] += press.driven.value;
            scatter(&mut self.load_q[memory], at, &press.driven.by_q);
            scatter(&mut self.load_v[memory], at, &press.driven.by_v);
            self.load_v[memory][memory] += press.driven.by_memory;
            self.g_v[lost][memory] += press.power.by_memory;
        }
        for (index, part) in [(index, &press.normal), (lost, &press.power)] {
            self.g[index] += part.value;
            scatter(&mut self.g_q[index], at, &part.by_q);
            scatter(&mut self.g_v[index], at, &part.by_v);
        }
    }

    /// Adds what turns the driven links of so many fingers by these parts of it.
    #[inline(always)]
    fn add_pull(&mut self, pull: &Pull, (weights, fingers): ([f64; FINGERS], usize), work: usize) {
        self.g[work] += pull.torque * pull.rate;
        self.g_t[work] += pull.by_time * pull.rate;
        for (i, weight) in weights.into_iter().enumerate().take(fingers) {
            self.load[2 * i] += weight * pull.torque;
            self.load_t[2 * i] += weight * pull.by_time;
            self.g_v[work][2 * i] += weight * (pull.torque + pull.by_rate * pull.rate);
            (0..fingers).for_each(|j| self.load_v[2 * i][2 * j] += weight * weights[j] * pull.by_rate);
        }
    }

    /// What has to work against all loads on a coordinate that nothing else moves: as a table does that comes along with time.
    fn let_work(&mut self, row: usize, rate: f64) {
        let work = Z - 1;
        self.g[work] -= self.load[row] * rate;
        for j in 0..N {
            self.g_q[work][j] -= self.load_q[row][j] * rate;
            self.g_v[work][j] -= self.load_v[row][j] * rate;
        }
    }
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Accelerations, and their derivatives by coordinates, rates and time.
    pub(super) fn with_slopes<const Z: usize>(
        &self,
        t: f64,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
    ) -> Linearised<N, Z> {
        let mut sums = Sums::<N, Z>::ZERO;
        let felt = self.felt(t);
        let mut masses = [[Dual::zero(); 3]; FINGERS];
        for (index, finger) in self.fingers.iter().enumerate().filter(|_| !Self::DISCS) {
            masses[index] = self.add_finger_slopes((index, finger), (q, v), (mode, &felt), &mut sums);
        }
        self.add_drive_slopes(t, v, &mut sums);
        for index in &self.between {
            self.add_slopes_between(*index, (q, v), mode, &mut sums);
        }
        if let Some(time) = self.time.filter(|_| self.moves()) {
            sums.let_work(time, 1.0);
        }
        for &(memory, bristle) in &self.bristles {
            sums.load[memory] -= bristle.rate() * v[memory];
            sums.load_v[memory][memory] -= bristle.rate();
        }
        for index in (0..self.count_of_discs()).filter(|index| self.first_of(*index) < N) {
            let (disc, first) = (&self.discs[index], self.first_of(index));
            if disc.driven.is_some() {
                for (i, rate) in self.rates_of(index, v).into_iter().enumerate() {
                    sums.let_work(first + i, rate);
                    sums.g_v[Self::WORK][first + i] -= sums.load[first + i];
                }
                continue;
            }
            (0..2).for_each(|i| sums.load[first + i] += disc.mass * self.gravity[i]);
            if self.moves() {
                self.add_disc_slopes(index, (q, v), &felt, &mut sums);
            }
        }
        let inverse = Inertia::new(self, from_each(masses, |mass| from_each(mass, |m| m.value))).inverse();
        let mut a = inverse.solve(&sums.load);
        // M a = load: where an angle changes M too, M ∂a = ∂load − ∂M a.
        for (finger, mass) in masses.iter().enumerate().take(self.fingers.len()) {
            let (first, second) = (2 * finger, 2 * finger + 1);
            for (k, j) in [first, second].into_iter().enumerate() {
                let [m, c, n] = [mass[0].grad[k], mass[1].grad[k], mass[2].grad[k]];
                sums.load_q[first][j] -= m * a[first] + c * a[second];
                sums.load_q[second][j] -= c * a[first] + n * a[second];
            }
        }
        self.drive_discs(&mut a);
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

    /// Adds what acts on a finger, and gives its mass matrix, with derivatives.
    #[inline(never)]
    fn add_finger_slopes<const Z: usize>(
        &self,
        (index, part): (usize, &FingerPart),
        (q, v): (&[f64; N], &[f64; N]),
        (mode, felt): (&mode::Mode<C>, &Felt),
        sums: &mut Sums<N, Z>,
    ) -> [Dual<2>; 3] {
        let own = Self::own(index, v);
        let (terms, load, by_rates) = pressing::turning(&part.model, (Self::own(index, q), own));
        for (i, (load, by_rates)) in load.iter().zip(by_rates).enumerate() {
            let row = 2 * index + i;
            sums.load[row] += load.value;
            scatter(&mut sums.load_q[row], &of_finger(index), &load.grad);
            scatter(&mut sums.load_v[row], &of_finger(index), &by_rates);
        }
        if self.moves() {
            self.add_felt_slopes((index, part), own, &terms, felt, sums);
        }
        for contact in &part.contacts {
            self.add_slopes_to_finger(*contact, (index, part, &terms), (q, v), mode, sums);
        }
        terms.mass
    }

    /// Adds a contact of a finger: of what the finger's two angles and the centre of a disc say, and also how that is turned unless it is round.
    #[inline(always)]
    fn add_slopes_to_finger<const Z: usize>(
        &self,
        index: usize,
        part: (usize, &FingerPart, &Terms<Dual<2>>),
        state: (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut Sums<N, Z>,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        match self.turns(self.meet_of(part.0, index, contact)) {
            false => self.add_finger_contact::<Z, 4>((index, contact, laws), part, state, sums),
            true => self.add_finger_contact::<Z, 5>((index, contact, laws), part, state, sums),
        }
    }

    #[inline(never)]
    fn add_finger_contact<const Z: usize, const P: usize>(
        &self,
        (index, contact, laws): (usize, &Joined, Laws<'_>),
        (finger, part, terms): (usize, &FingerPart, &Terms<Dual<2>>),
        (q, v): (&[f64; N], &[f64; N]),
        sums: &mut Sums<N, Z>,
    ) {
        let (own, mirror) = (Self::own(finger, v), part.side.mirror());
        match self.meet_of(finger, index, contact) {
            Meet::Phalanx { site, disc, .. } => {
                let [vx, vy, spin] = self.rates_of(disc, v);
                let object = self.in_finger(part.side, disc, q);
                let rates = [own[0], own[1], mirror * vx, vy, mirror * spin];
                let at = (terms, site, &object);
                let press =
                    pressing::phalanx_on_object::<P>(&part.model, at, &rates, self.remembered(contact, v), laws);
                sums.add((index, contact), &press, &of_phalanx(finger, self.first_of(disc), mirror));
            }
            _ => {
                let press = pressing::limit(&part.model, terms, &own, laws);
                sums.add((index, contact), &press, &of_finger(finger));
            }
        }
    }

    /// Adds a contact that no finger has.
    #[inline(always)]
    fn add_slopes_between<const Z: usize>(
        &self,
        index: usize,
        state: (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut Sums<N, Z>,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        match self.turns(contact.meet) {
            false => self.add_contact_between::<Z, 4, 3, 2>((index, contact, laws), state, sums),
            true => self.add_contact_between::<Z, 6, 4, 3>((index, contact, laws), state, sums),
        }
    }

    /// By so many positions of two discs, of a disc and time, and of a disc.
    #[inline(never)]
    fn add_contact_between<const Z: usize, const TWO: usize, const TIMED: usize, const ONE: usize>(
        &self,
        (index, contact, laws): (usize, &Joined, Laws<'_>),
        (q, v): (&[f64; N], &[f64; N]),
        sums: &mut Sums<N, Z>,
    ) {
        let memory = self.remembered(contact, v);
        let at = |disc: usize| (self.placed(disc, q), self.rates_of(disc, v));
        match contact.meet {
            Meet::Discs { disc, other } if !Self::GRASP => {
                let ((one, [vx, vy, spin]), (two, [wx, wy, turn])) = (at(disc), at(other));
                let rates = [vx, vy, wx, wy, spin, turn];
                let press = pressing::discs::<TWO>([&one, &two], &rates, memory, laws);
                sums.add((index, contact), &press, &of_discs([self.first_of(disc), self.first_of(other)]));
            }
            Meet::PassingPlane { disc, plane } if self.moves() => {
                let ((one, [vx, vy, spin]), time) = (at(disc), self.time.unwrap_or(N));
                let (rates, pose) = ([vx, vy, v[time], spin], self.pose(q));
                let press = pressing::table::<TIMED>((&plane, &pose, &one), &rates, memory, laws);
                sums.add((index, contact), &press, &of_disc_in_time(self.first_of(disc), time));
            }
            Meet::Plane { disc, plane } => {
                let (one, rates) = at(disc);
                let on_plane = self.meets_in_one_point();
                let press = pressing::plane::<ONE>((&plane, &one, on_plane), &rates, memory, laws);
                sums.add((index, contact), &press, &of_disc(self.first_of(disc)));
            }
            _ => {}
        }
    }

    /// What a finger's links feel in a frame that moves.
    fn add_felt_slopes<const Z: usize>(
        &self,
        (finger, part): (usize, &FingerPart),
        own: [f64; 2],
        terms: &Terms<Dual<2>>,
        felt: &Felt,
        sums: &mut Sums<N, Z>,
    ) {
        let (carried, first) = (&part.carried, 2 * finger);
        let [field, rate] = [felt.field, felt.rate].map(|field| field.mirrored(part.side.mirror()));
        let forces = |v: [f64; 2], field: &Field| {
            let rates = absolute_rates(&terms.rates, from_each(v, Dual::constant));
            carried.forces(&terms.pose, &terms.rates, rates, field)
        };
        let (now, soon) = (forces(own, &field), forces(own, &rate));
        let swept = Field { coriolis: field.coriolis, ..Field::default() };
        let by_rates = from_each([[1.0, 0.0], [0.0, 1.0]], |unit| from_each(forces(unit, &swept), |force| force.value));
        for i in 0..2 {
            let row = first + i;
            sums.load[row] += now[i].value;
            sums.load_t[row] += soon[i].value;
            sums.g[Self::WORK] += now[i].value * own[i];
            sums.g_t[Self::WORK] += soon[i].value * own[i];
            sums.g_v[Self::WORK][row] += now[i].value;
            for (j, by_rate) in by_rates.iter().enumerate() {
                sums.load_q[row][first + j] += now[i].grad[j];
                sums.load_v[row][first + j] += by_rate[i];
                sums.g_q[Self::WORK][first + j] += now[i].grad[j] * own[i];
                sums.g_v[Self::WORK][first + j] += by_rate[i] * own[i];
            }
        }
    }

    /// What a disc feels there: linear in where it is and how it moves.
    fn add_disc_slopes<const Z: usize>(
        &self,
        index: usize,
        (q, v): (&[f64; N], &[f64; N]),
        felt: &Felt,
        sums: &mut Sums<N, Z>,
    ) {
        let (disc, place, rates) = (&self.discs[index], self.place_of(index, q), self.rates_of(index, v));
        let first = self.first_of(index);
        let now = disc_feels(disc, &felt.field, place, rates);
        let soon = disc_feels(disc, &felt.rate, place, rates);
        let linear = Field { uniform: [0.0; 2], euler: felt.field.euler, ..felt.field };
        let unit = |j: usize| each(|k| if k == j { 1.0 } else { 0.0 });
        let (mut by_q, mut by_v) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for j in 0..2 {
            by_q[j] = disc_feels(disc, &linear, unit(j), [0.0; 3]);
            by_v[j] = disc_feels(disc, &linear, [0.0; 3], unit(j));
            // The couple depends on neither.
            (by_q[j][2], by_v[j][2]) = (0.0, 0.0);
        }
        for i in 0..3 {
            let row = first + i;
            sums.load[row] += now[i];
            sums.load_t[row] += soon[i];
            sums.g[Self::WORK] += now[i] * rates[i];
            sums.g_t[Self::WORK] += soon[i] * rates[i];
            sums.g_v[Self::WORK][row] += now[i];
            for j in 0..3 {
                sums.load_q[row][first + j] += by_q[j][i];
                sums.load_v[row][first + j] += by_v[j][i];
                sums.g_q[Self::WORK][first + j] += by_q[j][i] * rates[i];
                sums.g_v[Self::WORK][first + j] += by_v[j][i] * rates[i];
            }
        }
    }

    #[inline(always)]
    fn add_drive_slopes<const Z: usize>(&self, t: f64, v: &[f64; N], sums: &mut Sums<N, Z>) {
        let (driven, fingers) = (self.driven(v), self.count());
        for (index, drive) in self.drives.iter().enumerate().filter(|_| !Self::DISCS) {
            let memory = self.brake_of(index);
            sums.add_pull(&drive.pull(t, driven), (drive.weights, fingers), Self::WORK);
            let Some(hold) = drive.hold(t, driven, memory.map(|memory| v[memory])) else { continue };
            sums.add_pull(&hold.pull, (drive.weights, fingers), Self::LOST);
            let Some(memory) = memory else { continue };
            sums.load[memory] += hold.driven;
            sums.load_t[memory] += hold.gain * hold.pull.by_time;
            sums.load_v[memory][memory] += hold.gain * hold.by_memory;
            sums.g_v[Self::LOST][memory] += hold.by_memory * hold.pull.rate;
            for (i, weight) in drive.weights.into_iter().enumerate().take(fingers) {
                sums.load_v[2 * i][memory] += weight * hold.by_memory;
                sums.load_v[memory][2 * i] += weight * hold.gain * hold.pull.by_rate;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::multibody::model::angles;
    use crate::analytic::multibody::quadratures;
    use crate::analytic::{Mode, SiteState};
    use crate::numeric::plane::{Vector, add, perp, scale};
    use crate::scene::{Scene, parse_any};

    const CONTACTS: usize = 10;
    type Model = Multibody<12, CONTACTS>;
    type All = Sums<12, { quadratures(CONTACTS) }>;

    const LISTS: [&str; 2] = [
        include_str!("../../../../../scenes/gripper/lift.toml"),
        include_str!("../../../../../scenes/laws/two-free.toml"),
    ];

    fn scene(text: &str) -> Scene {
        parse_any(text, "scene.toml").unwrap_or_else(|error| panic!("{error}"))
    }

    /// A disc is pressed, whether it is asked how that changes as it turns or not: it does not.
    #[test]
    fn round_shapes_do_not_change_as_they_turn() {
        let mut pressed = 0;
        for scene in LISTS.map(scene) {
            let model = Model::new(&scene.system);
            let start = model.start::<{ quadratures(CONTACTS) }>(&scene.system);
            let mode = Mode::from([SiteState::Active; CONTACTS]);
            for (index, contact) in model.contacts.iter().enumerate() {
                let Some(contact) = contact else { continue };
                let (mut q, mut v) = (start.q, start.v);
                (0..8).for_each(|i| v[i] += 0.1 * (i as f64 - 3.3));
                // Just so near that it presses, and turned.
                let Some((disc, at)) = touching(&model, contact, &q) else { continue };
                let first = model.first_of(disc);
                (q[first], q[first + 1], q[first + 2]) = (at[0], at[1], 0.3);
                let laws = contact.laws(mode[index]).expect("a branch that presses");
                let (mut without, mut with) = (All::ZERO, All::ZERO);
                let contact = (index, contact, laws);
                if let Meet::Phalanx { finger, .. } = contact.1.meet {
                    let terms = model.fingers[finger].model.terms(angles(Model::own(finger, &q)));
                    let part = (finger, &model.fingers[finger], &terms);
                    model.add_finger_contact::<_, 4>(contact, part, (&q, &v), &mut without);
                    model.add_finger_contact::<_, 5>(contact, part, (&q, &v), &mut with);
                } else {
                    model.add_contact_between::<_, 4, 3, 2>(contact, (&q, &v), &mut without);
                    model.add_contact_between::<_, 6, 4, 3>(contact, (&q, &v), &mut with);
                }
                assert!(without.g[index] != 0.0, "{:?} does not press", contact.1.meet);
                assert_eq!((without.load, without.g), (with.load, with.g));
                assert_eq!((without.load_q, without.load_v), (with.load_q, with.load_v));
                assert_eq!((without.g_q, without.g_v), (with.g_q, with.g_v));
                pressed += 1;
            }
        }
        assert_eq!(pressed, 7);
    }

    /// A disc that moves, and a centre at which it is 1 µm within what it meets.
    fn touching(model: &Model, contact: &Joined, q: &[f64; 12]) -> Option<(usize, Vector<f64>)> {
        let radius = |disc: usize| crate::shape::reach(&model.discs[disc].shape) - 1e-6;
        match contact.meet {
            Meet::Stop { .. } => None,
            Meet::Phalanx { finger, site, disc } => {
                let part = &model.fingers[finger];
                let object = model.in_finger(part.side, disc, q);
                let (pose, rates) = part.model.place(Model::own(finger, q));
                let found = part.model.phalanx(&pose, &rates, site, &object);
                let away = scale(found.normal, found.gap + 1e-6);
                Some((disc, model.in_palm(part.side, add(object.centre_m, away))))
            }
            Meet::Discs { disc, other } => {
                let [x, y, _] = model.place_of(other, q);
                Some((disc, [x + radius(disc) + radius(other) + 1e-6, y]))
            }
            Meet::Plane { disc, plane } | Meet::PassingPlane { disc, plane } => {
                let level = scale(plane.normal, radius(disc) - plane.offset);
                Some((disc, add(level, scale(perp(plane.normal), 0.01))))
            }
        }
    }
}
