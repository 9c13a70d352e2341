//! All limits on inputs and results in one place, [with their reasons](crate::docs::limits).

pub use crate::check::MAX_CHECKED_STEPS;
pub use crate::log::MAX_RECORD_BYTES;
pub use crate::study::sweep::{MAX_RUNS, MAX_SHARDED_RUNS};
pub use crate::thesis::volume::MAX_POINTS;
pub use crate::units::MAX_TIME_S;
pub use phalanx_core::limits::{
    MAX_BODIES, MAX_CONTACTS, MAX_CORNERS, MAX_DISCS, MAX_JOINTS, MAX_OUTLINES, MAX_PICTURES, MAX_PLACES, MAX_PROBLEMS,
    MAX_SAMPLES, MAX_SHOWN_PROBLEMS, MAX_TABLE_POINTS, MAX_TENDONS,
};

/// Largest size of a scene or study file, bytes.
pub const MAX_SCENE_BYTES: u64 = 1 << 20;
/// Largest size of the packed module of the explorer, bytes: ten times its actual size.
pub const MAX_MODULE_BYTES: u64 = 16 << 20;
/// Maximum number of grid samples of a validated run. Several such runs are in memory at once, with 1,600 bytes per
/// sample.
pub const MAX_VALIDATED_SAMPLES: f64 = 2e5;
/// Largest size of an input table, bytes. In memory it takes ten times as much.
pub const MAX_TABLE_BYTES: u64 = 256 << 20;
/// Maximum number of values read from each of two compared logs.
pub const MAX_COMPARED_VALUES: usize = 20_000_000;
/// Maximum number of threads. More threads slow each other down, and each one takes memory.
pub use phalanx_parallel::MAX_THREADS;
