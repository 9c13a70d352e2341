//! How many coordinates and contacts a system has: sizes are constants of the model.

use crate::scene::System;

/// What a system asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// With time and the memories of bristles.
    pub coordinates: usize,
    pub contacts: usize,
}

/// The most that the model takes where there are fingers and more than what two of them grasp: without bristles, and with them.
pub const ROOM: [Size; 2] = [Size { coordinates: 14, contacts: 24 }, Size { coordinates: 32, contacts: 24 }];

/// A system too large for the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TooMany {
    #[error(
        "{moving} discs move and {pairs} pairs of surfaces may meet; the analytic model takes up to {MOVING} moving discs and \
         {most} pairs: fix or remove some"
    )]
    Discs { moving: usize, pairs: usize, most: usize },
    #[error(
        "fingers, discs and bristles have {} coordinates and {} contacts; the analytic model takes up to {} and {}: fix or remove \
         some discs",
        .of.coordinates, .of.contacts, .most.coordinates, .most.contacts
    )]
    Parts { of: Size, most: Size },
}

impl Size {
    /// That of a system.
    pub fn of(system: &System) -> Self {
        let moving = moving(system);
        let touching = system.touching();
        let holding = touching.iter().filter_map(|touching| system.laws(*touching)?.1?.bristle).count();
        let input = system.differential.iter().map(|differential| &differential.motor);
        let motors = system.fingers.iter().map(|finger| &finger.motor).chain(input);
        let brakes = motors.filter(|motor| motor.brake.is_some_and(|brake| brake.bristle.is_some())).count();
        let time = usize::from(system.palm_motion.is_some());
        Self { coordinates: 2 * system.fingers.len() + 3 * moving + time + holding + brakes, contacts: touching.len() }
    }

    /// Whether it is no larger than there is room for.
    pub fn fits(&self, room: &Self) -> bool {
        self.coordinates <= room.coordinates && self.contacts <= room.contacts
    }
}

/// Discs alone that may move.
const MOVING: usize = 3;

/// How many discs of a system move.
fn moving(system: &System) -> usize {
    system.discs.iter().filter(|disc| disc.motion.moves()).count()
}

/// Pairs of discs alone.
pub(super) const PAIRS: usize = 12;

/// Pairs that may hold where so many discs move: as many memories are there.
const HOLDING: [usize; MOVING + 1] = [0, 4, 6, 9];

/// Coordinates over which errors of discs alone are averaged: with every memory that so many may have. Over those alone that there are,
/// a wheel that comes to roll takes 333 steps instead of 33 (scenes/laws/bristle-rolls).
pub(super) fn averaged(system: &System) -> usize {
    let moving = moving(system);
    3 * moving + if system.holds() { HOLDING[moving.min(MOVING)] } else { 0 }
}

/// How many of some discs alone move, where the model takes as many.
pub fn of_discs(system: &System) -> Result<usize, TooMany> {
    let moving = moving(system);
    let pairs = system.touching().len();
    let most = if system.holds() { HOLDING[moving.min(MOVING)] } else { PAIRS };
    if moving > MOVING || pairs > most { Err(TooMany::Discs { moving, pairs, most }) } else { Ok(moving) }
}
