//! How much is taken at most, in one place: [what each limit is for](crate::docs::limits).

pub use crate::check::MOST_STEPS as MOST_CHECKED_STEPS;
pub use crate::log::LARGEST_RECORD;
pub use crate::study::sweep::{MOST_RUNS, MOST_SHARDED_RUNS};
pub use crate::study::volume::MOST_POINTS;
pub use crate::units::LONGEST_S;
pub use phalanx_core::limits::{MOST_DISCS, MOST_PICTURES, MOST_PROBLEMS, MOST_SAMPLES, SHOWN_PROBLEMS};

/// Bytes of a scene or study file.
pub const LARGEST_SCENE_BYTES: u64 = 1 << 20;
/// Bytes of the explorer's packed module: twelve times what it has.
pub const LARGEST_MODULE_BYTES: u64 = 16 << 20;
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
