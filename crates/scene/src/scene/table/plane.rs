//! `[half_plane]` below discs, and `[table]` above the palm of a gripper.

use super::lines;
use crate::scene::kinds::{Flag, Length};

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

/// A table or none.
#[derive(Clone, Copy, Debug)]
pub struct Support {
    pub present: bool,
    pub level_m: f64,
}

lines! {
    /// A table on which the object lies with its side away from the palm: everything above a level is solid and fixed. The section
    /// alone puts one there.
    Support = Self { present: true, level_m: f64::NAN }, t;
    /// Whether it is there.
    "present": Flag = Some(&mut t.present);
    /// Height of its surface above the palm. Default: the object's diameter, so that a centred object touches it.
    "level": Length = t.present.then_some(&mut t.level_m), beside("present", "with present = false");
}
