//! The sizes of a scene and of its motion, by which errors are measured.

use super::path::{ANGLES, Path};
use crate::scene::{Disc, System};
use crate::shape::reach;

/// A run is chaotic if the push moves its path by more than this, in the unit of [`BAR`](super::BAR), or by a tenth of the largest displacement.
pub const CHAOTIC: f64 = 1e-3;
/// An error counts as large, however small it is, if it is more than this part of the largest displacement.
pub const MOTION_PART: f64 = 1e-2;
/// The same for what a push does.
const CHAOTIC_PART: f64 = 0.1;
/// The length of discs alone that counts as much as a radian, in radii of the smallest that moves.
const DISC_RADII: f64 = 20.0;
/// Displacements below this part of a radian, or of that length, are rest: rounding of coordinates is a part of them.
const REST: f64 = 1e-10;

/// What differences of the coordinates of a sample are divided by to be compared with each other: 1 of angles; of a body beside
/// fingers its reach (radius of a disc) in m, of discs alone 1 m.
pub fn units(system: &System) -> Vec<f64> {
    let unit = |disc: &Disc| if system.fingers.is_empty() { 1.0 } else { reach(&disc.shape) };
    let angles = std::iter::repeat_n(1.0, ANGLES * system.fingers.len());
    angles.chain(system.told_discs().iter().flat_map(|disc| [unit(disc); 2])).collect()
}

/// The length that counts as much as a radian beside fingers: the reach of what they grasp, m.
pub fn length_m(system: &System) -> f64 {
    system.object().map_or(1.0, |object| reach(&object.shape))
}

/// The error from which on a run is uncertain, and what it is a part of.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// In the unit of errors: rad, of discs alone m.
    pub error: f64,
    /// The effect of a push from which on it is chaotic.
    pub chaotic: f64,
    pub of: String,
    /// The largest displacement, where the bar is a part of that.
    pub motion: Option<f64>,
}

/// The bar of a run, where `ordinary` is that of a motion by a radian.
pub fn bar(system: &System, run: &Path, ordinary: f64) -> Bar {
    let is_discs = system.fingers.is_empty();
    let size = if is_discs { DISC_RADII * smallest(system) } else { 1.0 };
    let motion = motion(run).max(REST * size);
    let (usual, least) = (ordinary * size, MOTION_PART * motion);
    let chaotic = (CHAOTIC * size).min(CHAOTIC_PART * motion);
    if least < usual {
        let unit = if is_discs { "m" } else { "rad" };
        let of = format!("{MOTION_PART} of the largest displacement, {motion:.1e} {unit}");
        return Bar { error: least, chaotic, of, motion: Some(motion) };
    }
    let of = match (is_discs, system.told_discs().is_empty()) {
        (true, _) => format!("{:e} of the radius of the smallest disc that moves", DISC_RADII * ordinary),
        (false, true) => format!("{ordinary:e} of a radian"),
        (false, false) => format!("{ordinary:e} of a radian and of the object's radius"),
    };
    Bar { error: usual, chaotic, of, motion: None }
}

/// Reach of the smallest body that moves, m; where none does, of the smallest.
fn smallest(system: &System) -> f64 {
    let least = |moving: bool| {
        let discs = system.discs.iter().filter(|disc| !moving || disc.motion.moves());
        discs.map(|disc| reach(&disc.shape)).min_by(f64::total_cmp)
    };
    least(true).or(least(false)).unwrap_or(1.0 / DISC_RADII)
}

/// Largest distance of a coordinate from its start along a path, in its unit.
fn motion(path: &Path) -> f64 {
    let Some(first) = path.points.first() else { return 0.0 };
    path.points.iter().map(|point| path.apart(first, point)).fold(0.0, f64::max)
}
