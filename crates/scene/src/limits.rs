//! Limits of scenes.

/// Maximum number of problems of a file that are collected.
pub const MAX_PROBLEMS: usize = 100;
/// Maximum number of problems that are shown.
pub const MAX_SHOWN_PROBLEMS: usize = 20;
/// Maximum number of discs of a scene. All pairs may be in contact, and all contacts are solved together.
pub const MAX_DISCS: usize = 100;
/// Maximum number of parameters of a scene.
pub const MAX_PARAMETERS: usize = 1000;
/// Maximum number of bodies of a mechanism.
pub const MAX_BODIES: usize = 100;
/// Maximum number of joints of a mechanism. The same limit applies to the number of springs, of couplings, of actuators
/// and of rotors.
pub const MAX_JOINTS: usize = 300;
/// Maximum number of tendons of a mechanism.
pub const MAX_TENDONS: usize = 100;
/// Maximum number of eyelets and pulleys of a tendon. The same limit applies to its spools.
pub const MAX_PLACES: usize = 100;
/// Maximum number of outlines of a mechanism.
pub const MAX_OUTLINES: usize = 1000;
/// Maximum number of points of a table over time, such as that of a motor or an actuator, or the path of a palm.
pub const MAX_TABLE_POINTS: usize = 10_000;
/// Maximum number of corners of an outline.
pub const MAX_CORNERS: usize = 32;
/// Maximum number of contacts of a mechanism: points of outlines against others.
pub const MAX_CONTACTS: usize = 1000;
/// Maximum number of grid samples of a run. Each takes 300 to 700 bytes in a log.
pub const MAX_SAMPLES: f64 = 1e7;
/// Maximum number of pictures of a run. Each takes 2,000 bytes in a log.
pub const MAX_PICTURES: f64 = 1e6;
/// Largest overlap of two outlines at the start of a run, m.
pub const MAX_START_OVERLAP_M: f64 = 1e-3;
/// Largest angle of a joint beyond its limit at the start, rad. Rounded lengths of a loop may cause such an excess.
pub const MAX_START_EXCESS_RAD: f64 = 1e-3;
/// Largest distance of a prismatic joint beyond its limit at the start, m.
pub const MAX_START_EXCESS_M: f64 = 1e-4;
