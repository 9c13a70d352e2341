//! Sweeps beyond one machine: a part of a study into a file of its own, and such files into the results of the whole.
//!
//! Whatever can run a command, or call [`write_part`], can make parts: a job array, a cluster of tasks, a loop of a shell. A part
//! is one Parquet file that appears whole or not at all, and says in its metadata of which study it is and which runs it has; so
//! a part that is there is done, and all that a broken sweep needs is its missing parts. [`merge`] joins parts to the very bytes
//! that the undisturbed sweep writes, with no more in memory than two groups of rows.
//!
//! Parts are Parquet alone: a CSV file cannot say what it is a part of, and two files do not appear at once.
//!
//! | file | job |
//! |---|---|
//! | `info` | what a part says of itself |
//! | `make` | the runs of a part, and its file |
//! | `cover` | what is missing of a study, and what is there twice |
//! | `merge` | parts to results |
//! | `error` | what can be wrong |

mod cover;
mod error;
mod info;
mod make;
mod merge;

pub use cover::{Gap, Overlap};
pub use error::PartError;
pub use info::PartInfo;
pub use make::{Made, Work, write_part};
pub use merge::{Merged, merge};
