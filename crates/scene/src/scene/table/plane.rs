//! `[half_plane]` below discs, and `[table]` above the palm of a gripper.

use super::settings;
use crate::scene::value_kinds::{Flag, Length};

/// Settings of the ground.
#[derive(Clone, Copy, Debug)]
pub struct HalfPlaneSettings {
    pub level_m: f64,
}

settings! {
    /// A solid, fixed half plane below a level. An empty section suffices to add it.
    HalfPlaneSettings = Self { level_m: 0.0 }, p;
    /// Height y of the surface.
    "level": Length = Some(&mut p.level_m), default_text("0 mm");
}

/// Settings of the table, which may be absent.
#[derive(Clone, Copy, Debug)]
pub struct TableSettings {
    pub present: bool,
    pub level_m: f64,
}

settings! {
    /// A table that supports the object on the side away from the palm: a solid, fixed half plane above a level. An
    /// empty section suffices to add it.
    TableSettings = Self { present: true, level_m: f64::NAN }, t;
    /// Whether there is a table.
    "present": Flag = Some(&mut t.present);
    /// Height of the surface above the palm. Default: the top of the object, so that the object touches the table.
    "level": Length = t.present.then_some(&mut t.level_m), depends_on("present", "with present = false");
}
