//! Conditioning of the coordinates of a group: how far its dyads are from their singularities, and better coordinates.

use super::assur::Assur;
use super::dyad::transmission;
use super::group::motions_at;
use super::motion::Motions;
use crate::fivebar::kinematics::SINGULAR_SINE;
use crate::mechanism::structure::{Closures, Group, Placement, regroup};
use crate::mechanism::{Mechanism, Pose};

/// Smallest |sine| of the transmission angles of a group below which its coordinates are exchanged. Errors grow with its
/// square. Motions of 60 random loops that differ in the joint with the start agree to 1.3e-2, 3e-4, 7.5e-5, 2.9e-5 and
/// 4.2e-5 rad at 0.05, 0.1, 0.2, 0.3 and 0.5 (rtol 1e-5), with equally many steps and half an exchange in a run.
pub(crate) const EXCHANGE_SINE: f64 = 0.3;
/// Smallest |sine| of a row of dyads below which Newton's method takes over, if no other row of dyads does. It takes several
/// times as long.
const NEWTON_SINE: f64 = 0.5 * EXCHANGE_SINE;
/// Other coordinates take over if their smallest |sine| is larger by this factor, so that two choices do not alternate.
const MIN_GAIN: f64 = 2.0;
/// The largest |sine| that a search asks for first: that of 45°. A search for less follows while there is none.
const FIRST_FLOOR: f64 = 0.7;
/// Ratio of the |sine| of two searches.
const FLOOR_RATIO: f64 = 0.7;

/// |sine| of the transmission angle of a dyad or of an Assur group; 0 if it is not a number. Infinite for other placements.
fn sine_of(mechanism: &Mechanism, placement: &Placement, motions: &Motions<f64>) -> f64 {
    match placement {
        Placement::Dyad { outer, inner } => {
            // The maximum with NaN is the number.
            transmission(mechanism, (outer, *inner), motions).sine.abs().max(0.0)
        }
        Placement::Assur { tree, known, closing } => Assur { mechanism, tree, known, closing }.sine(motions).max(0.0),
        _ => f64::INFINITY,
    }
}

/// Smallest |sine| of the transmission angles of a group.
pub(super) fn smallest_sine(mechanism: &Mechanism, group: &Group, motions: &Motions<f64>) -> f64 {
    group.placements.iter().map(|placement| sine_of(mechanism, placement, motions)).fold(f64::INFINITY, f64::min)
}

/// The group in coordinates that are much better conditioned in the poses of these motions; `None` if there are none, or if
/// its own are good. Coordinates that leave a row of dyads come first.
pub(super) fn better_group(mechanism: &Mechanism, group: &Group, motions: &Motions<f64>) -> Option<Group> {
    let present = smallest_sine(mechanism, group, motions);
    if present >= EXCHANGE_SINE {
        return None;
    }
    let search = |closures: Closures| {
        let floors = std::iter::successors(Some(FIRST_FLOOR), |floor| Some(FLOOR_RATIO * floor));
        let mut floors = floors.take_while(|floor| *floor >= (MIN_GAIN * present).max(SINGULAR_SINE));
        floors.find_map(|floor| {
            regroup(mechanism, group, closures, &|placement| sine_of(mechanism, placement, motions) >= floor)
        })
    };
    let may_use_newton = group.has_assur() || present < NEWTON_SINE;
    search(Closures::Dyads).or_else(|| if may_use_newton { search(Closures::All) } else { None })
}

/// The groups of a mechanism at its start, in other coordinates where those are much better conditioned.
pub(super) fn conditioned_groups(mechanism: &Mechanism, groups: Vec<Group>, poses: &[Pose]) -> Vec<Group> {
    let motions = motions_at(mechanism, poses);
    let better = |group: Group| better_group(mechanism, &group, &motions).unwrap_or(group);
    groups.into_iter().map(better).collect()
}
