//! How much is taken at most, in one place: [what each limit is for](crate::docs::limits).

pub use crate::check::MOST_STEPS as MOST_CHECKED_STEPS;
pub use crate::log::LARGEST_RECORD;
pub use crate::study::sweep::MOST_RUNS;
pub use crate::study::volume::MOST_POINTS;
pub use crate::units::LONGEST_S;

/// Bytes of a scene or study file.
pub const LARGEST_SCENE_BYTES: u64 = 1 << 20;
/// Problems of a file that are looked for, and of these shown.
pub const MOST_PROBLEMS: usize = 100;
pub const SHOWN_PROBLEMS: usize = 20;
/// Discs of a scene: all pairs of them may touch, and the contact of all is solved at once.
pub const MOST_DISCS: usize = 100;
/// Samples on the grid of a run, 300 to 700 bytes each in a log, and pictures of it, 2,000 each.
pub const MOST_SAMPLES: f64 = 1e7;
pub const MOST_PICTURES: f64 = 1e6;
/// Samples on the grid of a run that is validated: several such runs are held in memory, 1,600 bytes a sample.
pub const MOST_VALIDATED_SAMPLES: f64 = 2e5;
/// Bytes of a table that is read: ten times as many are held in memory.
pub const LARGEST_TABLE_BYTES: u64 = 256 << 20;
/// Figures that are held of each of two logs set side by side.
pub const MOST_COMPARED_FIGURES: usize = 20_000_000;
/// More threads than these only get in each other's way, and each takes memory.
pub const MOST_THREADS: usize = 1024;
/// Clients that watch a run at the same time.
pub const MOST_CLIENTS: usize = 32;
