//! What does not change in time.

use super::coordinates::{memory_of, memory_of_brake};
use super::laws::Laws;
use super::{FINGERS, GripperMode, HELD, MEMORY, QUADRATURES, TIME};
use crate::analytic::finger::FingerModel;
use crate::fivebar::carried::Carried;
use crate::integrator::State;
use crate::law::{Bristle, ContactLaw, FrictionLaw, NormalLaw};
use crate::numeric::Dual;
use crate::numeric::plane::Vector;
use crate::scene::{
    Actuation, Brake, DiscMotion, DrivenFinger, HalfPlane, Motor, PalmMotion, Place, Side, System, next_corner, torque,
};

/// The model of a scene with N = 7 coordinates, 8 where the palm moves, or 4 where the object is fixed; [`HELD`] where friction holds.
#[derive(Clone, Debug)]
pub struct GripperModel<const N: usize> {
    pub(super) fingers: [FingerModel; 2],
    pub(super) carried: [Carried; 2],
    pub(super) palm_motion: Option<PalmMotion>,
    pub(super) drives: Vec<Drive>,
    /// Beside the fingers' own mass matrices: inertias on (q11, q11), and what couples both driven links.
    pub(super) rotor_inertia: [f64; 2],
    pub(super) coupling: f64,
    half_palm: f64,
    pub(super) object: Object,
    pub(super) palm: Option<Plane>,
    pub(super) table: Option<Plane>,
}

/// A motor: which of the driven links (right, left) it turns, and by how much of its torque.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    actuation: Actuation,
    pub weights: [f64; 2],
    no_load_speed: Option<f64>,
    brake: Option<Brake>,
}

/// What a drive gives at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pull {
    /// Rate of its shaft, rad/s.
    pub rate: f64,
    /// Torque, N·m, and its derivatives by rate and time.
    pub torque: f64,
    pub by_rate: f64,
    pub by_time: f64,
}

/// What a brake gives at one instant, and what that does to the memory of its bristle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hold {
    pub pull: Pull,
    /// Derivative of its torque by the memory.
    pub by_memory: f64,
    /// What it adds to the memory's rate: `gain` times its torque.
    pub driven: f64,
    pub gain: f64,
}

impl Drive {
    fn new(motor: &Motor, weights: [f64; 2]) -> Self {
        let Motor { actuation, no_load_speed_rad_s, brake, .. } = motor;
        Self { actuation: actuation.clone(), weights, no_load_speed: *no_load_speed_rad_s, brake: *brake }
    }

    #[inline(always)]
    fn rate(&self, driven: [f64; 2]) -> f64 {
        self.weights[0] * driven[0] + self.weights[1] * driven[1]
    }

    /// What the brake holds it with, if it has one.
    #[inline(always)]
    pub fn hold(&self, t: f64, driven: [f64; 2], memory: Option<f64>) -> Option<Hold> {
        let (brake, rate) = (self.brake.as_ref()?, self.rate(driven));
        let Some((bristle, memory)) = brake.bristle.as_ref().zip(memory) else {
            let [torque, by_rate, by_time] = brake.torque(t, rate);
            let pull = Pull { rate, torque, by_rate, by_time };
            return Some(Hold { pull, by_memory: 0.0, driven: 0.0, gain: 0.0 });
        };
        let [torque, by_rate, by_time] = brake.held(t, rate + memory, bristle);
        // On the memory it acts the other way than on the shaft.
        let gain = -bristle.driven();
        Some(Hold { pull: Pull { rate, torque, by_rate, by_time }, by_memory: by_rate, driven: gain * torque, gain })
    }

    /// τ − |τ| q̇/q̇0, whichever way it turns.
    #[inline(always)]
    pub fn pull(&self, t: f64, driven: [f64; 2]) -> Pull {
        let rate = self.rate(driven);
        let (full, slope) = torque(&self.actuation, t);
        let Some(speed) = self.no_load_speed else { return Pull { rate, torque: full, by_rate: 0.0, by_time: slope } };
        let by_rate = -full.abs() / speed;
        let by_time = slope - slope * full.signum() * rate / speed;
        Pull { rate, torque: full + by_rate * rate, by_rate, by_time }
    }
}

/// The object: inverses are 0 where it is fixed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Object {
    pub radius: f64,
    pub mass: f64,
    pub inertia: f64,
    /// Where a fixed one is.
    pub pose: [f64; 3],
    pub gravity: [f64; 2],
}

/// A half plane that only the object meets: `normal` points to the object, and `offset` is its distance from the origin against that.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub normal: [f64; 2],
    pub offset: f64,
    pub law: ContactLaw,
}

/// A plane whose solid is below it, or above where `up` is negative.
fn plane(of: HalfPlane, up: f64) -> Option<Plane> {
    of.contact.map(|law| Plane { normal: [0.0, up], offset: of.level_m, law })
}

/// Coordinates and rates at the start of a scene with N coordinates.
pub fn start<const N: usize>(system: &System) -> State<N, QUADRATURES> {
    let mut state = State { q: [0.0; N], v: [0.0; N], z: [0.0; QUADRATURES] };
    for (index, finger) in system.fingers.iter().enumerate() {
        let initial = &finger.initial;
        (state.q[2 * index], state.q[2 * index + 1]) = (initial.q11_rad, initial.q21_rad);
        (state.v[2 * index], state.v[2 * index + 1]) = (initial.qd11_rad_s, initial.qd21_rad_s);
    }
    if N > FINGERS {
        let object = system.grasped();
        let ([x, y], angle) = (object.centre_m, object.angle_rad);
        state.q[FINGERS..TIME].copy_from_slice(&[x, y, angle]);
        if let DiscMotion::Free { velocity_m_s: [vx, vy], spin_rad_s, .. } = object.motion {
            state.v[FINGERS..TIME].copy_from_slice(&[vx, vy, spin_rad_s]);
        }
    }
    if N > TIME {
        state.v[TIME] = 1.0;
    }
    state
}

impl<const N: usize> GripperModel<N> {
    /// Builds the model; N is 7 for an object that moves, 8 where the palm does too, and 4 for an object that does not.
    pub fn new(system: &System) -> Self {
        let [x, y] = system.gravity_m_s2;
        let finger = |side: Side| {
            let DrivenFinger { linkage, spring, limit, contact, initial, .. } = system.finger(side);
            FingerModel::new(linkage, (*spring, *limit), *contact, initial, [side.mirror() * x, y])
        };
        let mut drives = Vec::from(Side::BOTH.map(|side| {
            let weights = if side == Side::Right { [1.0, 0.0] } else { [0.0, 1.0] };
            Drive::new(&system.finger(side).motor, weights)
        }));
        let mut rotor_inertia = Side::BOTH.map(|side| system.finger(side).motor.inertia_kg_m2);
        let mut coupling = 0.0;
        if let Some(differential) = &system.differential {
            drives.push(Drive::new(&differential.motor, [0.5, 0.5]));
            let (input, seesaw) = (differential.motor.inertia_kg_m2, differential.seesaw_inertia_kg_m2);
            rotor_inertia.iter_mut().for_each(|own| *own += (input + seesaw) / 4.0);
            coupling = (input - seesaw) / 4.0;
        }
        let disc = system.grasped();
        let (mass, inertia) = match disc.motion {
            DiscMotion::Free { mass_kg, inertia_kg_m2, .. } => (mass_kg, inertia_kg_m2.unwrap_or(f64::INFINITY)),
            DiscMotion::Fixed | DiscMotion::Driven { .. } => (0.0, 0.0),
        };
        let coordinates = match (system.holds(), mass > 0.0, system.palm_motion.is_some()) {
            (true, ..) => HELD,
            (_, true, true) => MEMORY,
            (_, true, false) => TIME,
            (_, false, _) => FINGERS,
        };
        assert_eq!(N, coordinates, "the object's coordinates, time, and memories");
        let half_palm = 0.5 * system.palm_width_m;
        let [cx, cy] = disc.centre_m;
        Self {
            fingers: Side::BOTH.map(finger),
            carried: Side::BOTH.map(|side| Carried::new(&system.finger(side).linkage, [half_palm, 0.0])),
            palm_motion: system.palm_motion.clone(),
            drives,
            rotor_inertia,
            coupling,
            half_palm,
            object: Object {
                radius: disc.radius_m,
                mass,
                inertia,
                pose: [cx, cy, disc.angle_rad],
                gravity: system.gravity_m_s2,
            },
            palm: system.palm.and_then(|palm| plane(palm, 1.0)),
            table: system.table.and_then(|table| plane(table, -1.0)),
        }
    }

    /// Whether there are memories of bristles.
    pub(super) const HOLDS: bool = N > MEMORY;

    /// Laws of a place that presses.
    #[inline(always)]
    pub(super) fn laws(&self, place: Place, mode: &GripperMode) -> Option<Laws<'_>> {
        let state = mode[place.index()];
        let normal = self.normal_law(place).filter(|_| state.presses())?;
        Some(Laws { normal, friction: self.friction_law(place), state })
    }

    /// Memory of the bristle of a place, where there are any.
    #[inline(always)]
    pub(super) fn memory(&self, v: &[f64; N], place: Place) -> Option<f64> {
        if Self::HOLDS { memory_of(place).map(|memory| v[memory]) } else { None }
    }

    /// That of a drive's brake.
    #[inline(always)]
    pub(super) fn brake_memory(&self, v: &[f64; N], drive: usize) -> Option<f64> {
        if Self::HOLDS { Some(v[memory_of_brake(drive)]) } else { None }
    }

    /// Whether friction holds at a place.
    pub(crate) fn holds(&self, place: Place) -> bool {
        self.friction_law(place).is_some_and(|friction| friction.bristle.is_some())
    }

    /// All bristles, with the places of their memories.
    pub(super) fn bristles(&self) -> impl Iterator<Item = (usize, Bristle)> {
        let places = Place::ALL.into_iter().filter_map(|place| {
            let bristle = self.friction_law(place).and_then(|friction| friction.bristle)?;
            Some((memory_of(place)?, bristle))
        });
        let brakes =
            self.drives.iter().enumerate().filter_map(|(index, drive)| {
                Some((memory_of_brake(index), drive.brake.and_then(|brake| brake.bristle)?))
            });
        places.chain(brakes)
    }

    /// Energy in bristles, J.
    pub(super) fn bristle_energy(&self, v: &[f64; N]) -> f64 {
        if Self::HOLDS { self.bristles().map(|(memory, bristle)| bristle.energy(v[memory])).sum() } else { 0.0 }
    }

    /// Torques of all motors and brakes on the driven links, N·m.
    pub fn motor_torques(&self, t: f64, v: &[f64; N]) -> [f64; 2] {
        let mut torques = [0.0; 2];
        for (index, drive) in self.drives.iter().enumerate() {
            let driven = [v[0], v[2]];
            let hold = drive.hold(t, driven, self.brake_memory(v, index));
            let torque = drive.pull(t, driven).torque + hold.map_or(0.0, |hold| hold.pull.torque);
            (0..2).for_each(|i| torques[i] += drive.weights[i] * torque);
        }
        torques
    }

    /// The next time at which some torque, or a derivative of the palm's pose, jumps.
    pub(super) fn next_corner_in_time(&self, t: f64) -> f64 {
        let brakes = self.drives.iter().filter_map(|drive| drive.brake.as_ref()).map(|brake| brake.next_corner(t));
        let drives = self.drives.iter().map(|drive| next_corner(&drive.actuation, t));
        let palm = self.palm_motion.iter().map(|motion| motion.next_corner(t));
        drives.chain(brakes).chain(palm).fold(f64::INFINITY, f64::min)
    }

    /// (x, y, θ) of the object.
    #[inline(always)]
    pub fn object_of(&self, q: &[f64; N]) -> [f64; 3] {
        if N > FINGERS { [q[FINGERS], q[FINGERS + 1], q[FINGERS + 2]] } else { self.object.pose }
    }

    /// Its rates.
    #[inline(always)]
    pub fn object_rates(&self, v: &[f64; N]) -> [f64; 3] {
        if N > FINGERS { [v[FINGERS], v[FINGERS + 1], v[FINGERS + 2]] } else { [0.0; 3] }
    }

    /// A point of G as a finger's frame has it.
    #[inline(always)]
    pub(super) fn in_finger(&self, side: Side, [x, y]: [f64; 2]) -> [f64; 2] {
        [side.mirror() * x - self.half_palm, y]
    }

    /// The object's centre as a finger's frame has it.
    #[inline(always)]
    pub(super) fn centre_in_finger(&self, side: Side, q: &[f64; N]) -> [f64; 2] {
        let [x, y, _] = self.object_of(q);
        self.in_finger(side, [x, y])
    }

    /// Rates of a finger and of the object as the finger's frame has them.
    #[inline(always)]
    pub(super) fn rates_in_finger(&self, side: Side, v: &[f64; N]) -> [f64; 5] {
        let ([first, second], [x, y, spin]) = (Self::own(side, v), self.object_rates(v));
        [first, second, side.mirror() * x, y, side.mirror() * spin]
    }

    /// A point of a finger's frame as G has it.
    pub(super) fn in_palm(&self, side: Side, [x, y]: [f64; 2]) -> [f64; 2] {
        [side.mirror() * (x + self.half_palm), y]
    }

    #[inline(always)]
    pub(super) fn plane(&self, place: Place) -> Option<&Plane> {
        if place == Place::Palm { self.palm.as_ref() } else { self.table.as_ref() }
    }

    /// Normal law of a place; `None` where the scene has no such contact.
    #[inline(always)]
    pub(super) fn normal_law(&self, place: Place) -> Option<&NormalLaw> {
        match place {
            Place::Finger(side, site) => self.fingers[side as usize].normal_law(site),
            Place::Palm | Place::Table => self.plane(place).map(|plane| &plane.law.normal),
        }
    }

    #[inline(always)]
    pub(super) fn friction_law(&self, place: Place) -> Option<&FrictionLaw> {
        match place {
            Place::Finger(side, site) => self.fingers[side as usize].friction_law(site),
            Place::Palm | Place::Table => self.plane(place).and_then(|plane| plane.law.friction.as_ref()),
        }
    }
}

/// Coordinates of a finger, each a variable of its own.
#[inline(always)]
pub(super) fn variables(q: [f64; 2]) -> Vector<Dual<2>> {
    [Dual::variable(q[0], 0), Dual::variable(q[1], 1)]
}
