//! Number of coordinates and contacts of a system. Sizes are compile-time constants of the model.

use crate::scene::System;

/// Size of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Number of coordinates, including time and the bristle states.
    pub coordinates: usize,
    pub contacts: usize,
}

/// Largest sizes of a system that has fingers and is no grasp of two fingers: without and with bristles.
pub const MAX_SIZES: [Size; 2] = [Size { coordinates: 14, contacts: 24 }, Size { coordinates: 32, contacts: 24 }];

/// Error for a system too large for the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TooLarge {
    #[error(
        "{moving} discs move and {pairs} pairs of surfaces may come into contact; the analytic model takes up to {MAX_MOVING_DISCS} moving discs and \
         {limit} pairs: fix or remove some"
    )]
    Discs { moving: usize, pairs: usize, limit: usize },
    #[error(
        "fingers, discs and bristles have {} coordinates and {} contacts; the analytic model takes up to {} and {}: fix or remove \
         some discs",
        .size.coordinates, .size.contacts, .limit.coordinates, .limit.contacts
    )]
    Components { size: Size, limit: Size },
}

impl Size {
    /// Size of a system.
    pub(crate) fn of_system(system: &System) -> Self {
        let moving_discs = count_moving(system);
        let contacts = system.contact_ids();
        let bristles = contacts.iter().filter_map(|contact| system.contact_laws(*contact)?.1?.bristle).count();
        let input = system.differential.iter().map(|differential| &differential.motor);
        let motors = system.fingers.iter().map(|finger| &finger.motor).chain(input);
        let brakes = motors.filter(|motor| motor.brake.is_some_and(|brake| brake.bristle.is_some())).count();
        let time = usize::from(system.palm_motion.is_some());
        Self {
            coordinates: 2 * system.fingers.len() + 3 * moving_discs + time + bristles + brakes,
            contacts: contacts.len(),
        }
    }

    /// Whether this size is within `capacity`.
    pub fn fits(&self, capacity: &Self) -> bool {
        self.coordinates <= capacity.coordinates && self.contacts <= capacity.contacts
    }
}

/// Largest number of moving discs in a system without fingers.
const MAX_MOVING_DISCS: usize = 3;

/// How many discs of a system move.
fn count_moving(system: &System) -> usize {
    system.discs.iter().filter(|disc| disc.motion.moves()).count()
}

/// Largest number of contact pairs in a system without fingers.
pub(super) const MAX_DISC_PAIRS: usize = 12;

/// Largest number of contact pairs with bristles in a system without fingers, by its number of moving discs.
const MAX_BRISTLE_PAIRS: [usize; MAX_MOVING_DISCS + 1] = [0, 4, 6, 9];

/// Number of coordinates over which errors are averaged in systems without fingers: all positions, and the largest
/// number of bristles allowed for this number of discs. If only existing bristles counted, a wheel that starts to roll
/// would take 333 steps instead of 33 (scenes/laws/bristle-rolls).
pub(super) fn error_coordinates(system: &System) -> usize {
    let moving_discs = count_moving(system);
    3 * moving_discs + if system.has_stiction() { MAX_BRISTLE_PAIRS[moving_discs.min(MAX_MOVING_DISCS)] } else { 0 }
}

/// Number of moving discs in a system without fingers.
///
/// # Errors
///
/// Returns an error if the system is too large for the model.
pub(crate) fn count_moving_discs(system: &System) -> Result<usize, TooLarge> {
    let moving_discs = count_moving(system);
    let pairs = system.contact_ids().len();
    let limit =
        if system.has_stiction() { MAX_BRISTLE_PAIRS[moving_discs.min(MAX_MOVING_DISCS)] } else { MAX_DISC_PAIRS };
    if moving_discs > MAX_MOVING_DISCS || pairs > limit {
        Err(TooLarge::Discs { moving: moving_discs, pairs, limit })
    } else {
        Ok(moving_discs)
    }
}
