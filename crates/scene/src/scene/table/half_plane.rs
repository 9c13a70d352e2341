//! `[half_plane]` of a scene of discs.

use super::lines;
use crate::scene::kinds::Length;

/// Where the ground is.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    pub level_m: f64,
}

lines! {
    /// The half plane: everything below a level is solid and fixed. The section alone puts one there.
    Ground = Self { level_m: 0.0 }, p;
    /// Height y of its surface.
    "level": Length = Some(&mut p.level_m), said("0 mm");
}
