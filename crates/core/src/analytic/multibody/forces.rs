//! Accelerations: every finger and every contact in the few coordinates it depends on, put together.

use super::coordinates::{Where, of_disc, of_disc_in_time, of_discs, of_finger, of_phalanx};
use super::frame::{self, disc_feels};
use super::inertia::Inertia;
use super::model::Multibody;
use super::parts::{FingerPart, Joined, Meet};
use super::touch::{self, Press};
use super::{FINGERS, mode, quadratures};
use crate::fivebar::carried::Field;
use crate::fivebar::dynamics::{Terms, absolute_rates};
use crate::gripper::Site;
use crate::integrator::{Linearised, Rates, System};
use crate::scene::Place;

/// Loads on all coordinates, and rates of all quadratures.
struct Sums<const N: usize, const Z: usize> {
    load: [f64; N],
    g: [f64; Z],
}

impl<const N: usize, const Z: usize> Sums<N, Z> {
    #[inline(always)]
    fn add<const K: usize>(&mut self, (index, contact): (usize, &Joined), press: &Press<f64, K>, at: &[Where; K]) {
        for (part, (row, sign)) in press.load.iter().zip(at) {
            if *row < N {
                self.load[*row] += sign * part;
            }
        }
        self.g[index] += press.normal;
        self.g[Z - 2] += press.power;
        if let Some(memory) = contact.memory {
            self.load[memory] += press.driven;
        }
    }
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Where the work of all contacts is among the quadratures, and that of what moves motors, palm and driven discs.
    pub(super) const LOST: usize = C;
    pub(super) const WORK: usize = C + 1;

    /// Adds what acts on a finger, and gives its mass matrix.
    #[inline(always)]
    fn add_finger<const Z: usize>(
        &self,
        (finger, part): (usize, &FingerPart),
        (q, v): (&[f64; N], &[f64; N]),
        (mode, field): (&mode::Mode<C>, &Field),
        sums: &mut Sums<N, Z>,
    ) -> [f64; 3] {
        let own = Self::own(finger, v);
        let terms = part.model.terms(Self::own(finger, q));
        let load = part.model.load(0.0, &terms, own);
        (0..2).for_each(|i| sums.load[2 * finger + i] += load[i]);
        if self.moves() {
            let rates = absolute_rates(&terms.rates, own);
            let field = field.mirrored(part.side.mirror());
            let felt = part.carried.forces(&terms.pose, &terms.rates, rates, &field);
            (0..2).for_each(|i| sums.load[2 * finger + i] += felt[i]);
            sums.g[Self::WORK] += felt[0] * own[0] + felt[1] * own[1];
        }
        if Self::GRASP {
            let first = Site::ALL.len() * finger;
            self.add_to_finger(first, (finger, part, &terms), (q, v), mode, sums);
            self.add_to_finger(first + 1, (finger, part, &terms), (q, v), mode, sums);
            self.add_to_finger(first + 2, (finger, part, &terms), (q, v), mode, sums);
        } else {
            for index in &part.contacts {
                self.add_to_finger(*index, (finger, part, &terms), (q, v), mode, sums);
            }
        }
        terms.mass
    }

    /// Adds a contact of a finger.
    #[inline(always)]
    fn add_to_finger<const Z: usize>(
        &self,
        index: usize,
        (finger, part, terms): (usize, &FingerPart, &Terms<f64>),
        (q, v): (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut Sums<N, Z>,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        let ([first, second], mirror) = (Self::own(finger, v), part.side.mirror());
        match self.meet_of(finger, index, contact) {
            Meet::Phalanx { site, disc, .. } => {
                let [vx, vy, spin] = self.rates_of(disc, v);
                let object = self.in_finger(part.side, disc, q);
                let geometry = part.model.phalanx(&terms.pose, &terms.rates, site, &object);
                let rates = [first, second, mirror * vx, vy, mirror * spin];
                let touch = touch::phalanx(&geometry);
                let press = touch::press(&touch, &rates, self.remembered(contact, v), laws);
                sums.add((index, contact), &press, &of_phalanx(finger, self.first_of(disc), mirror));
            }
            _ => {
                let touch = touch::limit(&part.model.limit_geometry(&terms.pose, &terms.rates));
                sums.add((index, contact), &touch::press(&touch, &[first, second], None, laws), &of_finger(finger));
            }
        }
    }

    /// Adds a contact that no finger has.
    #[inline(always)]
    fn add_between<const Z: usize>(
        &self,
        index: usize,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut Sums<N, Z>,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        let memory = self.remembered(contact, v);
        let at = |disc: usize| (self.placed(disc, q), self.rates_of(disc, v));
        match contact.meet {
            Meet::Discs { disc, other } if !Self::GRASP => {
                let ((one, [vx, vy, spin]), (two, [wx, wy, turn])) = (at(disc), at(other));
                let touch = touch::discs([&one, &two]);
                let press = touch::press(&touch, &[vx, vy, wx, wy, spin, turn], memory, laws);
                sums.add((index, contact), &press, &of_discs([self.first_of(disc), self.first_of(other)]));
            }
            Meet::PassingPlane { disc, plane } if self.moves() => {
                let ((one, [vx, vy, spin]), time) = (at(disc), self.time.unwrap_or(N));
                let touch = frame::table(&plane, &self.pose(q), 0.0, &one);
                let press = touch::press(&touch, &[vx, vy, v[time], spin], memory, laws);
                sums.add((index, contact), &press, &of_disc_in_time(self.first_of(disc), time));
            }
            Meet::Plane { disc, plane } => {
                let (one, rates) = at(disc);
                let touch = touch::plane(&plane, &one, self.meets_in_one_point());
                sums.add((index, contact), &touch::press(&touch, &rates, memory, laws), &of_disc(self.first_of(disc)));
            }
            _ => {}
        }
    }
}

impl<const N: usize, const C: usize, const Z: usize> System<N, Z> for Multibody<N, C> {
    type Mode = mode::Mode<C>;

    #[inline(always)]
    fn coordinates(&self) -> usize {
        self.used()
    }

    #[inline(always)]
    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>) -> Rates<N, Z> {
        if Self::GRASP { self.rates_here(t, (q, v), mode) } else { self.rates_apart(t, (q, v), mode) }
    }

    fn linearise(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>) -> Linearised<N, Z> {
        self.with_slopes(t, (q, v), mode)
    }
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Called, not written out wherever an integrator asks for it: what is simulated by the thousand is a grasp, and to compile takes time.
    #[inline(never)]
    fn rates_apart<const Z: usize>(&self, t: f64, state: (&[f64; N], &[f64; N]), mode: &mode::Mode<C>) -> Rates<N, Z> {
        self.rates_here(t, state, mode)
    }

    #[inline(always)]
    fn rates_here<const Z: usize>(&self, t: f64, (q, v): (&[f64; N], &[f64; N]), mode: &mode::Mode<C>) -> Rates<N, Z> {
        const { assert!(Z == quadratures(C)) };
        let mut sums = Sums { load: [0.0; N], g: [0.0; Z] };
        let field = self.felt(t).field;
        let mut masses = [[0.0; 3]; FINGERS];
        // Written out for both fingers, every index is a constant.
        if let Some(right) = self.fingers.first().filter(|_| !Self::DISCS) {
            masses[0] = self.add_finger((0, right), (q, v), (mode, &field), &mut sums);
        }
        if let Some(left) = self.fingers.get(1).filter(|_| !Self::DISCS) {
            masses[1] = self.add_finger((1, left), (q, v), (mode, &field), &mut sums);
        }
        let driven = self.driven(v);
        for (index, drive) in self.drives.iter().enumerate().filter(|_| !Self::DISCS) {
            let (pull, memory) = (drive.pull(t, driven), self.brake_of(index));
            (0..self.count()).for_each(|finger| sums.load[2 * finger] += drive.weights[finger] * pull.torque);
            sums.g[Self::WORK] += pull.torque * pull.rate;
            let Some(hold) = drive.hold(t, driven, memory.map(|memory| v[memory])) else { continue };
            let turned = hold.pull.torque;
            (0..self.count()).for_each(|finger| sums.load[2 * finger] += drive.weights[finger] * turned);
            sums.g[Self::LOST] += hold.pull.torque * hold.pull.rate;
            memory.iter().for_each(|memory| sums.load[*memory] += hold.driven);
        }
        if Self::GRASP {
            self.add_between(Place::Palm.index(), (q, v), mode, &mut sums);
            self.add_between(Place::Table.index(), (q, v), mode, &mut sums);
        } else {
            for index in &self.between {
                self.add_between(*index, (q, v), mode, &mut sums);
            }
        }
        if let Some(time) = self.time.filter(|_| self.moves()) {
            // What the table does to all in the frame, by coming along.
            sums.g[Self::WORK] -= sums.load[time];
        }
        for &(memory, bristle) in &self.bristles {
            sums.load[memory] -= bristle.rate() * v[memory];
        }
        for index in (0..self.count_of_discs()).filter(|index| self.first_of(*index) < N) {
            let (disc, first, rates) = (&self.discs[index], self.first_of(index), self.rates_of(index, v));
            if disc.driven.is_some() {
                // Against all contacts, of which nothing else is felt.
                (0..3).for_each(|i| sums.g[Self::WORK] -= sums.load[first + i] * rates[i]);
                continue;
            }
            (0..2).for_each(|i| sums.load[first + i] += disc.mass * self.gravity[i]);
            if self.moves() {
                let felt = disc_feels(disc, &field, self.place_of(index, q), rates);
                (0..3).for_each(|i| sums.load[first + i] += felt[i]);
                sums.g[Self::WORK] += (0..3).map(|i| felt[i] * rates[i]).sum::<f64>();
            }
        }
        let mut a = Inertia::new(self, masses).inverse().solve(&sums.load);
        self.drive_discs(&mut a);
        Rates { a, g: sums.g }
    }

    /// Accelerations of discs that move as told.
    #[inline(always)]
    pub(super) fn drive_discs(&self, a: &mut [f64; N]) {
        for (first, told) in self.discs.iter().filter_map(|disc| Some((disc.first, disc.driven?))) {
            a[first..first + 2].copy_from_slice(&told);
        }
    }
}
