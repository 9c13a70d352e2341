//! Parameter sweeps over fields of a scene (thesis §4.2).
//!
//! A study file names the base scene and the axes; an axis varies one field, or several fields together. Every
//! combination of the axes' values is simulated; axes that are ranges share a sample of points. Each run parses the
//! text of its own scene. Invalid scenes and failed simulations are rows too, with a reason.
//!
//! Runs are numbered from 1 with the last axis fastest, and the points of the sample faster still. **Designs** are
//! numbered in the same way over the axes without `again`. A row depends on its run alone, bit for bit, and not on the
//! order of execution or the number of threads.

mod axis;
mod axis_table;
mod base_scene;
mod document;
mod figures;
mod hands;
mod results;
mod run;
mod sequence;
mod shard;
mod study_file;

pub(in crate::study) use axis::{AxisValues, Range, Spacing, column_kind};
pub(in crate::study) use axis_table::AxisTable;
pub(in crate::study) use base_scene::Base;
pub(in crate::study) use document::{
    Document, any_value, default_name, list_first, read_study, schema as file_schema, similar,
};
pub(in crate::study) use figures::Results;
pub(in crate::study) use results::group_reasons;
pub(in crate::study) use run::problem_messages;
pub(in crate::study) use shard::{find_gaps, list_message, missing_message, run_range_text};

pub use axis::{AxisValue, Field, FieldType};
pub use document::StudyError;
pub use results::{Reason, Row, Status, Summary, column_type, columns, result_type, sorted_table, summary, table};
pub use run::{RunStats, run_while};
pub use shard::{Shard, check_unsharded, shard, shard_range};
pub use study_file::{in_memory_study, load, parse, schema, source_files};

use schemars::JsonSchema;
use serde::Deserialize;

use axis::Axis;
use base_scene::Template;
use figures::Figures;

use sequence::Sequence;

use crate::scene::{Keyword as _, Preset};
use crate::trace::Model;
use crate::trace::overrides::Overrides;

/// Maximum number of runs of an undivided sweep, or of one part. The rows are sorted in memory, and each takes one
/// kilobyte.
pub const MAX_RUNS: u64 = 1_000_000;

/// Maximum number of runs of a study that is divided into parts. On 100,000 cores, at 1 ms per run, it takes about
/// three hours. Tables, scripts and JSON represent these run numbers exactly.
pub const MAX_SHARDED_RUNS: u64 = 1_000_000_000_000;

/// Static criteria of the designs to simulate. Other designs are in the results as "filtered".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Filter {
    /// Whether both contact forces at rest are compressive.
    #[schemars(with = "bool")]
    pub force_positive: Option<bool>,
    /// Whether the palm force at rest is compressive.
    #[schemars(with = "bool")]
    pub palm_force_positive: Option<bool>,
    /// Whether the grasp by two such fingers and the palm is form-closed.
    #[schemars(with = "bool")]
    pub form_closed: Option<bool>,
}

#[derive(Clone, Debug)]
pub struct Study {
    pub name: String,
    pub description: String,
    pub model: Model,
    /// Preset that replaces method and tolerances of the scenes in all runs; `None` without one.
    pub preset: Option<Preset>,
    /// Whether every run is checked, which takes three more simulations for each run.
    pub checked: bool,
    pub filter: Filter,
    axes: Vec<Axis>,
    results: Results,
    /// Sample points of all ranges.
    sequence: Option<Sequence>,
    template: Template,
    runs: u64,
    /// The exact text of the study.
    pub source: String,
    /// The exact text of the file of the base scene; empty if the scene is part of the study file.
    pub base: String,
}

impl Study {
    /// Number of five-bar fingers of the scenes; 0 for other kinds of scene.
    pub fn fingers(&self) -> usize {
        if let Figures::Hand(fingers) = self.results.figures { fingers } else { 0 }
    }

    /// Replaces method and tolerances of all runs by those of a preset; `None` has no effect.
    ///
    /// # Errors
    /// Returns an error if the model has no presets.
    pub fn set_preset(&mut self, preset: Option<Preset>) -> Result<(), String> {
        Overrides { preset, ..Overrides::default() }.reject_unused(self.model)?;
        self.preset = preset;
        Ok(())
    }

    pub fn runs(&self) -> u64 {
        self.runs
    }

    pub fn designs(&self) -> u64 {
        self.loops().filter(|(_, repeats_designs)| !repeats_designs).map(|(len, _)| len).product()
    }

    pub fn design(&self, run: u64) -> u64 {
        let design_loops = self.loops().zip(self.indices(run)).filter(|((_, repeats_designs), _)| !repeats_designs);
        1 + design_loops.fold(0, |design, ((len, _), index)| design * len + index)
    }

    /// Values of all fields in a run, in the order of their columns.
    pub fn field_values(&self, run: u64) -> Vec<AxisValue> {
        let indices = self.indices(run);
        let (point, mut coordinate) = (indices.last().copied().unwrap_or(0), 0);
        let (mut row_indices, mut values) = (indices.iter(), Vec::new());
        for axis in &self.axes {
            match (&axis.values, &self.sequence) {
                (AxisValues::Rows(rows), _) => {
                    let index = row_indices.next().copied().unwrap_or(0) as usize;
                    values.extend(rows.get(index).into_iter().flatten().cloned());
                }
                (AxisValues::Range(range), Some(sequence)) => {
                    values.push(range.value_at(sequence.coordinate(point, coordinate), false));
                    coordinate += 1;
                }
                // Unreachable: a range without a sample is rejected when the study is read.
                (AxisValues::Range(_), None) => {}
            }
        }
        values
    }

    pub fn scene_text(&self, run: u64) -> String {
        self.template.fill(&self.field_values(run))
    }

    /// Whether the points are a sample rather than a grid.
    pub fn is_sampled(&self) -> bool {
        self.sequence.is_some()
    }

    /// Fields that vary, in the order of their columns.
    pub fn axis_fields(&self) -> impl Iterator<Item = &Field> {
        self.axes.iter().flat_map(|axis| &axis.fields)
    }

    /// Columns of the fields that vary, each with the number of its values.
    pub fn fields(&self) -> impl Iterator<Item = (String, u64)> + '_ {
        let sample_count = self.sequence.as_ref().map_or(0, Sequence::count);
        self.axes.iter().flat_map(move |axis| {
            axis.fields.iter().map(move |field| (field.column(), axis.len().unwrap_or(sample_count)))
        })
    }

    /// Lengths of the nested loops from the outermost to the innermost, and whether they repeat the same designs. A loop
    /// is an axis with values, or the points of the sample.
    fn loops(&self) -> impl Iterator<Item = (u64, bool)> {
        let listed = self.axes.iter().filter_map(|axis| Some((axis.len()?, axis.repeats_designs)));
        listed.chain(self.sequence.as_ref().map(|sequence| (sequence.count(), false)))
    }

    fn indices(&self, run: u64) -> Vec<u64> {
        let mut indices: Vec<u64> = self.loops().map(|(len, _)| len).collect();
        let mut remainder = run.saturating_sub(1);
        for index in indices.iter_mut().rev() {
            (remainder, *index) = (remainder / *index, remainder % *index);
        }
        indices
    }

    /// Returns the FNV-1a hash, as 16 hexadecimal digits, of everything that determines the results: text, base scene,
    /// model, checks and version of the program. It protects against mistakes, not against tampering.
    pub fn fingerprint(&self) -> String {
        let checked = if self.checked { "checked" } else { "" };
        let inputs = [env!("CARGO_PKG_VERSION"), self.model.name(), self.source.as_str(), self.base.as_str(), checked];
        let preset = self.preset.map(|preset| preset.keyword());
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for input in inputs.into_iter().chain(preset) {
            // The length is hashed first, so that the boundary between two texts is unique.
            for byte in (input.len() as u64).to_le_bytes().iter().chain(input.as_bytes()) {
                hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
        format!("{hash:016x}")
    }
}
