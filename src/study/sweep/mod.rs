//! Parameter sweeps over fields of a scene (thesis §4.2).
//!
//! A study file names the base scene and the axes; an axis varies one field, or several fields together. Every
//! combination of the axes' values is simulated; axes that are ranges share a sample of points. Each run parses the
//! text of its own scene. Invalid scenes and failed simulations are rows too, with a reason.
//!
//! Runs are numbered from 1 with the last axis fastest, and the points of the sample faster still. **Designs** are
//! numbered in the same way over the axes without `again`. A row depends on its run alone, bit for bit, and not on the
//! order of execution or the number of threads.
//!
//! | file | content |
//! |---|---|
//! | `raw`, `document`, `read`, `read_axis`, `base`, `error` | study files and base scenes |
//! | `files` | files that a study requires |
//! | `field` | fields of a scene: types and columns |
//! | `axis`, `sequence` | values of an axis, points of a sample |
//! | `in_memory` | studies built in memory |
//! | `template` | texts of the scenes |
//! | `single_run`, `finger_run`, `gripper_run`, `simulate`, `row` | a single run of a finger or a gripper, and its row |
//! | `run` | parallel execution of the runs |
//! | `shard` | division of the runs into parts |
//! | `summary` | summary of the results |
//! | `fingerprint` | identification of the study of stored results |

mod axis;
mod base;
mod document;
mod error;
mod field;
mod files;
mod finger_run;
mod fingerprint;
mod gripper_run;
mod in_memory;
mod problem;
mod raw;
mod read;
mod read_axis;
mod row;
mod run;
mod sequence;
mod shard;
mod simulate;
mod single_run;
mod summary;
mod template;

pub(in crate::study) use summary::group_reasons;

pub use error::StudyError;
pub use field::{AxisValue, Field, FieldType};
pub use files::{files, source_files};
pub use in_memory::{InMemoryStudyError, in_memory_study};
pub use raw::schema;
pub use read::{load, parse};
pub use row::{Row, Status, column_type, columns, sorted_table, table};
pub use run::{RunStats, run, run_range, run_while};
pub use shard::{Shard, ShardError, check_unsharded, shard, shard_range};
pub use summary::{Reason, Summary, summary};

use axis::{Axis, AxisValues};
use sequence::Sequence;
use template::Template;

use crate::scene::keywords::SceneKind;
use crate::trace::Model;

/// Maximum number of runs of a sweep that is not divided, or of one part. Their rows are sorted in memory, one kilobyte
/// each.
pub const MAX_RUNS: u64 = 1_000_000;

/// Maximum number of runs of a study that is made in parts: about three hours on 100,000 cores at 1 ms per run. Tables,
/// scripts and JSON represent these run numbers exactly.
pub const MAX_SHARDED_RUNS: u64 = 1_000_000_000_000;

/// Static criteria of the designs to simulate; `None` accepts both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    pub force_positive: Option<bool>,
    pub palm_force_positive: Option<bool>,
    pub form_closed: Option<bool>,
}

/// A study that can be run.
#[derive(Clone, Debug)]
pub struct Study {
    /// Kind of the base scene: finger or gripper.
    pub kind: SceneKind,
    pub name: String,
    pub description: String,
    pub model: Model,
    /// Whether every run is checked, which takes three more simulations each.
    pub checked: bool,
    pub filter: Filter,
    axes: Vec<Axis>,
    /// Sample points of all ranges.
    sequence: Option<Sequence>,
    template: Template,
    runs: u64,
    /// The exact text of the study.
    pub source: String,
    /// The exact text of the base scene's file; empty if the scene is part of the study file.
    pub base: String,
}

/// One of the nested loops of a study: an axis with values, or the points of the sample.
struct Loop {
    len: u64,
    repeats_designs: bool,
}

impl Study {
    /// Number of runs.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// Number of designs.
    pub fn designs(&self) -> u64 {
        self.loops().iter().filter(|level| !level.repeats_designs).map(|level| level.len).product()
    }

    /// Design number of a run.
    pub fn design(&self, run: u64) -> u64 {
        let loops = self.loops();
        let indices = loop_indices(&loops, run);
        let design_loops = loops.iter().zip(indices).filter(|(level, _)| !level.repeats_designs);
        1 + design_loops.fold(0, |design, (level, index)| design * level.len + index)
    }

    /// Values of all fields in a run, in the order of their columns.
    pub fn field_values(&self, run: u64) -> Vec<AxisValue> {
        let indices = loop_indices(&self.loops(), run);
        let point = self.sequence.as_ref().and(indices.last().copied()).unwrap_or(0);
        let (mut row_indices, mut sampled) = (indices.into_iter(), 0);
        let mut values = Vec::new();
        for axis in &self.axes {
            match (&axis.values, &self.sequence) {
                (AxisValues::Rows(rows), _) => {
                    let index = row_indices.next().unwrap_or(0) as usize;
                    values.extend(rows.get(index).into_iter().flatten().cloned());
                }
                (AxisValues::Range(range), Some(sequence)) => {
                    values.push(range.value_at(sequence.coordinate(point, sampled), false));
                    sampled += 1;
                }
                // Unreachable: a range without a sample is rejected when the study is read.
                (AxisValues::Range(_), None) => {}
            }
        }
        values
    }

    /// Scene text of a run.
    pub fn scene_text(&self, run: u64) -> String {
        self.fill(&self.field_values(run))
    }

    fn fill(&self, values: &[AxisValue]) -> String {
        let texts: Vec<&str> = values.iter().map(|value| value.text.as_str()).collect();
        self.template.fill(&texts)
    }

    /// Columns of the fields that vary, with the number of values of each.
    pub fn fields(&self) -> impl Iterator<Item = (String, u64)> + '_ {
        let sample_count = self.sequence.as_ref().map_or(0, Sequence::count);
        self.axes.iter().flat_map(move |axis| {
            let count = axis.len().map_or(sample_count, |len| len as u64);
            axis.fields.iter().map(move |field| (field.column(), count))
        })
    }

    /// Loops from the outermost to the innermost.
    fn loops(&self) -> Vec<Loop> {
        let listed = self
            .axes
            .iter()
            .filter_map(|axis| axis.len().map(|len| Loop { len: len as u64, repeats_designs: axis.repeats_designs }));
        let sampled = self.sequence.as_ref().map(|sequence| Loop { len: sequence.count(), repeats_designs: false });
        listed.chain(sampled).collect()
    }
}

/// Index of each loop in a run.
fn loop_indices(loops: &[Loop], run: u64) -> Vec<u64> {
    let mut remainder = run.saturating_sub(1);
    let mut indices: Vec<u64> = loops
        .iter()
        .rev()
        .map(|level| {
            let index = remainder % level.len;
            remainder /= level.len;
            index
        })
        .collect();
    indices.reverse();
    indices
}
