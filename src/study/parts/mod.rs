//! Sweeps distributed over several machines: parts of a study in separate files, and their merge.
//!
//! A job array, a cluster or a shell loop can make parts with the command or with [`write_part`]. A part is one Parquet
//! file that is written atomically and whose metadata identify the study and the runs. An existing part is therefore
//! finished, and resuming a sweep means making the missing parts. [`merge`] writes the same bytes as an undivided sweep
//! and keeps at most two row groups in memory.
//!
//! Parts are Parquet files only: CSV has no metadata, and two files cannot be written atomically.
//!
//! | file | content |
//! |---|---|
//! | `info` | metadata of a part |
//! | `write` | execution and writing of a part |
//! | `coverage` | missing and duplicate runs |
//! | `merge` | merge of parts into results |
//! | `error` | errors |

mod coverage;
mod error;
mod info;
mod merge;
mod write;

pub use coverage::{Gap, Overlap};
pub use error::PartError;
pub use info::PartInfo;
pub use merge::{MergeResult, merge};
pub use write::{PartOptions, WrittenPart, write_part};
