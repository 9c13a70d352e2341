//! How much of a scene is taken at most.

/// Problems of a file that are looked for, and of these shown.
pub const MOST_PROBLEMS: usize = 100;
pub const SHOWN_PROBLEMS: usize = 20;
/// Discs of a scene: all pairs of them may touch, and the contact of all is solved at once.
pub const MOST_DISCS: usize = 100;
/// Samples on the grid of a run, 300 to 700 bytes each in a log, and pictures of it, 2,000 each.
pub const MOST_SAMPLES: f64 = 1e7;
pub const MOST_PICTURES: f64 = 1e6;
