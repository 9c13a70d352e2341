//! What does not change in time, and where everything is among the coordinates.

use super::drive::Drive;
use super::parts::{DiscPart, FingerPart, Joined, Meet, Plane};
use super::size::{PAIRS, averaged};
use super::{FINGERS, Size, quadratures};
use crate::analytic::finger::FingerModel;
use crate::analytic::mode::Landing;
use crate::fivebar::carried::Carried;
use crate::gripper::Site;
use crate::integrator::State;
use crate::law::Bristle;
use crate::numeric::plane::Vector;
use crate::numeric::{Dual, Real, each};
use crate::scene::{DiscMotion, DrivenFinger, PalmMotion, Place, Side, System, Touching};
use crate::shape::{Placed, round};

/// The model of a system with at most N coordinates and C contacts.
#[derive(Clone, Debug)]
pub struct Multibody<const N: usize, const C: usize> {
    pub(super) fingers: Vec<FingerPart>,
    pub(super) discs: Vec<DiscPart>,
    /// In the order of [`System::touching`]; `None` where nothing is there to touch.
    pub(super) contacts: Vec<Option<Joined>>,
    /// Those of no finger.
    pub(super) between: Vec<usize>,
    pub(super) drives: Vec<Drive>,
    /// Where the memories of their brakes are.
    pub(super) brakes: Vec<Option<usize>>,
    /// All bristles, with the places of their memories.
    pub(super) bristles: Vec<(usize, Bristle)>,
    /// Beside the fingers' own mass matrices: inertias on (q11, q11), and what couples both driven links.
    pub(super) rotor_inertia: [f64; FINGERS],
    pub(super) coupling: f64,
    pub(super) palm_motion: Option<PalmMotion>,
    /// Where time is among the coordinates of a palm that moves.
    pub(super) time: Option<usize>,
    /// Where the memories begin.
    pub(super) memories: usize,
    /// How many coordinates errors are averaged over, and matrices have.
    used: usize,
    half_palm: f64,
    pub(super) gravity: [f64; 2],
    pub(super) landing: Landing,
}

/// Touch-downs of fingers and what they grasp are landed on to within a part of δ_max, lift-off and reload to within a force far below
/// anything that is felt; those of discs alone as far as positions have digits, for their contact times are measured.
const GRASPS: Landing = Landing { depth_share: 1e-5, force: 1e-6 };
const COLLISIONS: Landing = Landing { depth_share: 1e-8, force: 1e-9 };

/// The discs of a system, the coordinates of those that move from `first` on, and the first coordinate behind them.
fn discs(system: &System, first: usize, beyond: usize) -> (Vec<DiscPart>, usize) {
    let mut next = first;
    let part = |disc| {
        let part = DiscPart::new(disc, if disc.motion.moves() { next } else { beyond });
        next += if disc.motion.moves() { 3 } else { 0 };
        part
    };
    let discs = system.discs.iter().map(part).collect();
    (discs, next)
}

/// A contact, where something is there to touch.
fn joined(system: &System, touching: Touching) -> Option<Joined> {
    let plane = |level_m: Option<f64>, up| Plane::at(level_m.unwrap_or(f64::NAN), up);
    let meet = match touching {
        Touching::Phalanx(side, site, disc) => Meet::Phalanx { finger: side as usize, site, disc },
        Touching::Stop(side) => Meet::Stop { finger: side as usize },
        Touching::Discs(disc, other) => Meet::Discs { disc, other },
        Touching::Palm(disc) => Meet::Plane { disc, plane: plane(system.palm.map(|palm| palm.level_m), 1.0) },
        Touching::Table(disc) => {
            let plane = plane(system.table.map(|table| table.level_m), -1.0);
            if system.palm_motion.is_some() { Meet::PassingPlane { disc, plane } } else { Meet::Plane { disc, plane } }
        }
    };
    system.laws(touching).map(|laws| Joined::new(meet, laws))
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Builds the model; a system must be no larger than there is room for.
    pub fn new(system: &System) -> Self {
        let size = Size::of(system);
        assert!(size.fits(&Size { coordinates: N, contacts: C }), "{size:?} in {N}, {C}");
        let is_grasp = system.fingers.len() == FINGERS && system.discs.len() < 2 && size.coordinates == N;
        assert!(is_grasp || !Self::GRASP, "two fingers and at most one disc, of {N} coordinates");
        assert!(system.fingers.is_empty() || !Self::DISCS, "discs alone");
        let [x, y] = system.gravity_m_s2;
        let half_palm = 0.5 * system.palm_width_m;
        let (discs, time) = discs(system, 2 * system.fingers.len(), N);
        let memories = time + usize::from(system.palm_motion.is_some());
        let mut contacts: Vec<_> = system.touching().into_iter().map(|touching| joined(system, touching)).collect();
        let mut bristles = Vec::new();
        let mut remembered = |bristle: Option<Bristle>| {
            let memory = memories + bristles.len();
            bristles.extend(bristle.map(|bristle| (memory, bristle)));
            bristle.map(|_| memory)
        };
        for contact in contacts.iter_mut().flatten() {
            contact.memory = remembered(contact.bristle());
        }
        let of = |finger: usize| {
            let is_its = |meet: Meet| match meet {
                Meet::Phalanx { finger: of, .. } | Meet::Stop { finger: of } => of == finger,
                Meet::Discs { .. } | Meet::Plane { .. } | Meet::PassingPlane { .. } => finger == FINGERS,
            };
            let indices = contacts.iter().enumerate();
            let its = indices.filter(|(_, contact)| contact.is_some_and(|contact| is_its(contact.meet)));
            its.map(|(index, _)| index).collect::<Vec<_>>()
        };
        let finger = |(side, finger): (Side, &DrivenFinger)| {
            let DrivenFinger { linkage, spring, limit, contact, initial, .. } = finger;
            FingerPart {
                side,
                model: FingerModel::new(linkage, (*spring, *limit), *contact, initial, [side.mirror() * x, y]),
                carried: Carried::new(linkage, [half_palm, 0.0]),
                contacts: of(side as usize),
            }
        };
        let (fingers, between) = (system.sided().map(finger).collect(), of(FINGERS));
        let mut rotor_inertia = [0.0; FINGERS];
        let mut drives = Vec::new();
        for (side, finger) in system.sided() {
            let weights = if side == Side::Right { [1.0, 0.0] } else { [0.0, 1.0] };
            drives.push(Drive::new(&finger.motor, weights));
            rotor_inertia[side as usize] = finger.motor.inertia_kg_m2;
        }
        let mut coupling = 0.0;
        if let Some(differential) = &system.differential {
            drives.push(Drive::new(&differential.motor, [0.5, 0.5]));
            let (input, seesaw) = (differential.motor.inertia_kg_m2, differential.seesaw_inertia_kg_m2);
            rotor_inertia.iter_mut().for_each(|own| *own += (input + seesaw) / 4.0);
            coupling = (input - seesaw) / 4.0;
        }
        let brakes = drives.iter().map(|drive| remembered(drive.bristle())).collect();
        Self {
            fingers,
            discs,
            contacts,
            between,
            brakes,
            bristles,
            drives,
            rotor_inertia,
            coupling,
            palm_motion: system.palm_motion.clone(),
            time: system.palm_motion.is_some().then_some(time),
            memories,
            used: if Self::DISCS { averaged(system) } else { N },
            half_palm,
            gravity: system.gravity_m_s2,
            landing: if system.fingers.is_empty() { COLLISIONS } else { GRASPS },
        }
    }

    /// Coordinates and rates at the start.
    pub fn start<const Z: usize>(&self, system: &System) -> State<N, Z> {
        const { assert!(Z == quadratures(C)) };
        let mut state = State { q: [0.0; N], v: [0.0; N], z: [0.0; Z] };
        for (index, finger) in system.fingers.iter().enumerate() {
            let initial = &finger.initial;
            (state.q[2 * index], state.q[2 * index + 1]) = (initial.q11_rad, initial.q21_rad);
            (state.v[2 * index], state.v[2 * index + 1]) = (initial.qd11_rad_s, initial.qd21_rad_s);
        }
        for (disc, part) in system.discs.iter().zip(&self.discs) {
            let (([vx, vy], spin), at) = match disc.motion {
                DiscMotion::Fixed => continue,
                DiscMotion::Driven { velocity_m_s, spin_rad_s, .. } => ((velocity_m_s, spin_rad_s), part.first),
                DiscMotion::Free { velocity_m_s, spin_rad_s, .. } => ((velocity_m_s, spin_rad_s), part.first),
            };
            state.q[at..at + 3].copy_from_slice(&part.pose);
            state.v[at..at + 3].copy_from_slice(&[vx, vy, spin]);
        }
        self.time.into_iter().for_each(|time| state.v[time] = 1.0);
        state
    }

    /// Whether surfaces meet in one point of both, so that they exchange angular momentum exactly; discs alone each in its own, as in the
    /// thesis.
    #[inline(always)]
    pub(super) fn meets_in_one_point(&self) -> bool {
        !self.fingers.is_empty()
    }

    /// How many contacts there are, with those where nothing is there to touch.
    pub fn contacts(&self) -> usize {
        self.contacts.len()
    }

    /// Where the memory of a contact's bristle is among the rates, if it has one.
    pub fn memory(&self, contact: usize) -> Option<usize> {
        self.contacts[contact].and_then(|contact| contact.memory)
    }

    /// Where that of a drive's brake is: of each finger's in their order, then of what drives both.
    pub fn memory_of_brake(&self, drive: usize) -> Option<usize> {
        self.brakes[drive]
    }

    /// Whether friction holds in a contact.
    pub(crate) fn holds(&self, contact: usize) -> bool {
        self.memory(contact).is_some()
    }

    /// Energy in bristles, J.
    pub(super) fn bristle_energy(&self, v: &[f64; N]) -> f64 {
        self.bristles.iter().map(|(memory, bristle)| bristle.energy(v[*memory])).sum()
    }

    /// Rates of the driven links: of both fingers, 0 of one that is not there.
    #[inline(always)]
    pub(super) fn driven(&self, v: &[f64; N]) -> [f64; FINGERS] {
        each(|finger| if finger < self.count() { v[2 * finger] } else { 0.0 })
    }

    /// Torques of all motors and brakes on the driven links, N·m.
    pub fn motor_torques(&self, t: f64, v: &[f64; N]) -> [f64; FINGERS] {
        let (mut torques, driven) = ([0.0; FINGERS], self.driven(v));
        for (index, drive) in self.drives.iter().enumerate() {
            let hold = drive.hold(t, driven, self.brake_of(index).map(|memory| v[memory]));
            let torque = drive.pull(t, driven).torque + hold.map_or(0.0, |hold| hold.pull.torque);
            (0..FINGERS).for_each(|i| torques[i] += drive.weights[i] * torque);
        }
        torques
    }

    /// The next time at which some torque, or a derivative of the palm's pose, jumps.
    pub(super) fn next_corner_in_time(&self, t: f64) -> f64 {
        let drives = self.drives.iter().map(|drive| drive.next_corner(t));
        let palm = self.palm_motion.iter().map(|motion| motion.next_corner(t));
        drives.chain(palm).fold(f64::INFINITY, f64::min)
    }

    /// Whether two fingers and one object are all that there is, without bristles. Then the compiler knows where everything is: it takes
    /// a tenth of the instructions of a closing.
    pub(super) const GRASP: bool = C == Place::ALL.len() && N <= 2 * FINGERS + 4;

    /// Whether discs alone are all that there is room for: nothing of a finger is compiled then.
    pub(super) const DISCS: bool = C == PAIRS;

    /// How many coordinates errors are averaged over, and matrices have.
    #[inline(always)]
    pub(super) fn used(&self) -> usize {
        if Self::DISCS { self.used } else { N }
    }

    /// How many fingers there are.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        match (Self::GRASP, Self::DISCS) {
            (true, _) => FINGERS,
            (_, true) => 0,
            _ => self.fingers.len(),
        }
    }

    /// How many discs.
    #[inline(always)]
    pub(super) fn count_of_discs(&self) -> usize {
        if Self::GRASP { 1 } else { self.discs.len() }
    }

    /// The memory of a drive's brake.
    #[inline(always)]
    pub(super) fn brake_of(&self, drive: usize) -> Option<usize> {
        if Self::GRASP { None } else { self.brakes[drive] }
    }

    /// The first coordinate of a disc, beyond the last if it is fixed.
    #[inline(always)]
    pub(super) fn first_of(&self, disc: usize) -> usize {
        if Self::GRASP { 2 * FINGERS } else { self.discs[disc].first }
    }

    /// Whether the palm moves, and with it the frame.
    #[inline(always)]
    pub(super) fn moves(&self) -> bool {
        if Self::GRASP { N > 2 * FINGERS + 3 } else { !Self::DISCS && self.time.is_some() }
    }

    /// The memory of a contact's bristle.
    #[inline(always)]
    pub(super) fn remembered(&self, contact: &Joined, v: &[f64; N]) -> Option<f64> {
        if Self::GRASP { None } else { contact.memory.map(|memory| v[memory]) }
    }

    /// What meets in a contact of a finger.
    #[inline(always)]
    pub(super) fn meet_of(&self, finger: usize, index: usize, contact: &Joined) -> Meet {
        match index.wrapping_sub(Site::ALL.len() * finger) {
            0 if Self::GRASP => Meet::Phalanx { finger, site: Site::Proximal, disc: 0 },
            1 if Self::GRASP => Meet::Phalanx { finger, site: Site::Distal, disc: 0 },
            2 if Self::GRASP => Meet::Stop { finger },
            _ => contact.meet,
        }
    }

    /// (x, y, θ) of a disc.
    #[inline(always)]
    pub fn place_of(&self, disc: usize, q: &[f64; N]) -> [f64; 3] {
        let first = self.first_of(disc);
        if first < N { [q[first], q[first + 1], q[first + 2]] } else { self.discs[disc].pose }
    }

    /// Its rates.
    #[inline(always)]
    pub fn rates_of(&self, disc: usize, v: &[f64; N]) -> [f64; 3] {
        let first = self.first_of(disc);
        if first < N { [v[first], v[first + 1], v[first + 2]] } else { [0.0; 3] }
    }

    /// Whether a contact changes as its discs turn where they are.
    #[inline(always)]
    pub(super) fn turns(&self, meet: Meet) -> bool {
        let turns = |disc: usize| round(&self.discs[disc].shape).is_none();
        match meet {
            Meet::Stop { .. } => false,
            Meet::Discs { disc, other } => turns(disc) || turns(other),
            Meet::Phalanx { disc, .. } | Meet::Plane { disc, .. } | Meet::PassingPlane { disc, .. } => turns(disc),
        }
    }

    /// The same with its shape.
    #[inline(always)]
    pub(super) fn placed(&self, disc: usize, q: &[f64; N]) -> Placed {
        let [x, y, angle_rad] = self.place_of(disc, q);
        Placed { shape: self.discs[disc].shape, centre_m: [x, y], angle_rad }
    }

    /// A disc as a finger's frame has it.
    #[inline(always)]
    pub(super) fn in_finger(&self, side: Side, disc: usize, q: &[f64; N]) -> Placed {
        self.placed(disc, q).in_finger(side.mirror(), self.half_palm)
    }

    /// A point of a finger's frame as that of all has it.
    pub(super) fn in_palm(&self, side: Side, [x, y]: [f64; 2]) -> [f64; 2] {
        [side.mirror() * (x + self.half_palm), y]
    }

    /// Coordinates of a finger, of all.
    #[inline(always)]
    pub(super) fn own(finger: usize, all: &[f64; N]) -> [f64; 2] {
        [all[2 * finger], all[2 * finger + 1]]
    }
}

/// A disc of which place and angle are these variables, as far as there are so many.
#[inline(always)]
pub(super) fn variables<const P: usize>(placed: &Placed, [x, y, turn]: [usize; 3]) -> Placed<Dual<P>> {
    let Placed { shape, centre_m, angle_rad } = *placed;
    let angle_rad = if turn < P { Dual::variable(angle_rad, turn) } else { Dual::constant(angle_rad) };
    Placed { shape, centre_m: [Dual::variable(centre_m[0], x), Dual::variable(centre_m[1], y)], angle_rad }
}

/// Coordinates of a finger, each a variable of its own.
#[inline(always)]
pub(super) fn angles(q: [f64; 2]) -> Vector<Dual<2>> {
    [Dual::variable(q[0], 0), Dual::variable(q[1], 1)]
}
