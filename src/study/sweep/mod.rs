//! Sweeps: a scene again and again, with other values in some of its fields (thesis §4.2).
//!
//! A study file names the base scene, the axes (a field each, or several that vary together), and what is simulated: every
//! combination of the axes' values, and of a sample of points where axes are ranges. Each run is the text of a scene, read
//! as any other; a scene that is not valid and a simulation that does not end are results too, with their reasons.
//!
//! Runs are numbered from 1, the last axis fastest, then the points of the sample. **Designs** are numbered the same way over
//! the axes that are not marked `again`. A row depends on its run alone: neither the order in which rows are found nor the
//! number of threads changes a bit of them.
//!
//! | file | job |
//! |---|---|
//! | `raw`, `document`, `read`, `read_axis`, `base`, `error` | a study file and its scene, checked |
//! | `files` | which files a study needs |
//! | `field` | fields of a scene: what they hold, their columns |
//! | `axis`, `sequence` | values of an axis, points of a sample |
//! | `designs` | studies whose designs are found one after the other |
//! | `given` | studies of rows that a program has |
//! | `template` | scene texts |
//! | `one`, `one_finger`, `one_gripper`, `simulate`, `row` | one run, of a finger or a gripper, and its row |
//! | `run` | all of them, on all cores |
//! | `shard` | which runs a part of them has, for more than one machine |
//! | `summary` | what came out |
//! | `trust` | whether results found on the disk are of this study |

mod axis;
mod base;
mod designs;
mod document;
mod error;
mod field;
mod files;
mod given;
mod one;
mod one_finger;
mod one_gripper;
mod problem;
mod raw;
mod read;
mod read_axis;
mod row;
mod run;
mod sequence;
mod shard;
mod simulate;
mod summary;
mod template;
mod trust;

pub(in crate::study) use axis::{Axis as SweepAxis, Range, Spacing};
pub(in crate::study) use designs::{Designs, of_designs};
pub(in crate::study) use document::{Document, document, refused};
pub(in crate::study) use raw::{Anything, List, RawAxis, RawFilter, schema_of_study, schema_text};
pub(in crate::study) use read::{filter_of, stem, text_of};
pub(in crate::study) use read_axis::{axes, between, field, read};
pub(in crate::study) use row::found;
pub(in crate::study) use summary::grouped;

pub use error::StudyError;
pub use field::{Field, Holds, Point};
pub use files::{files, sources};
pub use given::{GivenError, given};
pub use raw::schema;
pub use read::{load, parse};
pub use row::{Row, Status, columns, held_by, sorted, table};
pub use run::{Ran, run, run_range, run_while};
pub use shard::{Shard, ShardError, in_one_piece, range, shard};
pub use summary::{Reason, Summary, summary};

use axis::{Axis, Points};
use sequence::Sequence;
use template::Template;

use crate::scene::words::SceneKind;
use crate::trace::Model;

/// Most runs that are made in one piece, as a sweep or as a part of one: their rows are sorted in memory in the end, a kilobyte
/// each.
pub const MOST_RUNS: u64 = 1_000_000;

/// Most runs of a study that is made in parts. With a hundred thousand cores and a run in a millisecond these take three hours;
/// and every number of a run stays one that a table, a script and JSON have exactly.
pub const MOST_SHARDED_RUNS: u64 = 1_000_000_000_000;

/// Which designs are simulated: those whose static criteria are as is said here, if anything is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    pub force_positive: Option<bool>,
    pub palm_force_positive: Option<bool>,
    pub form_closed: Option<bool>,
}

/// A study that can be run.
#[derive(Clone, Debug)]
pub struct Study {
    /// Of the base scene: fingers or grippers.
    pub kind: SceneKind,
    pub name: String,
    pub description: String,
    pub model: Model,
    /// Whether every run is checked: three more runs for each.
    pub checked: bool,
    pub filter: Filter,
    axes: Vec<Axis>,
    /// The points of all ranges.
    sequence: Option<Sequence>,
    template: Template,
    runs: u64,
    /// The exact text of the study.
    pub source: String,
    /// The exact text of the base scene's file; empty if the scene stands in the study.
    pub base: String,
}

/// One of the loops of a study: an axis with values, or the points of the sample.
struct Loop {
    len: u64,
    again: bool,
}

impl Study {
    /// How many runs there are.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// How many designs there are.
    pub fn designs(&self) -> u64 {
        self.loops().iter().filter(|of| !of.again).map(|of| of.len).product()
    }

    /// The design of a run.
    pub fn design(&self, run: u64) -> u64 {
        let loops = self.loops();
        let places = places(&loops, run);
        1 + loops.iter().zip(places).filter(|(of, _)| !of.again).fold(0, |design, (of, at)| design * of.len + at)
    }

    /// The values of all fields in a run, in the order of their columns.
    pub fn points(&self, run: u64) -> Vec<Point> {
        let places = places(&self.loops(), run);
        let point = self.sequence.as_ref().and(places.last().copied()).unwrap_or(0);
        let (mut given, mut sampled) = (places.into_iter(), 0);
        let mut points = Vec::new();
        for axis in &self.axes {
            match (&axis.points, &self.sequence) {
                (Points::Given(rows), _) => {
                    let at = given.next().unwrap_or(0) as usize;
                    points.extend(rows.get(at).into_iter().flatten().cloned());
                }
                (Points::Range(range), Some(sequence)) => {
                    points.push(range.at(sequence.at(point, sampled), false));
                    sampled += 1;
                }
                // A range without a sample is refused when the study is read.
                (Points::Range(_), None) => {}
            }
        }
        points
    }

    /// The text of a run's scene.
    pub fn scene_text(&self, run: u64) -> String {
        self.fill(&self.points(run))
    }

    fn fill(&self, points: &[Point]) -> String {
        let texts: Vec<&str> = points.iter().map(|point| point.text.as_str()).collect();
        self.template.fill(&texts)
    }

    /// Columns of the fields that vary, with how many values each takes.
    pub fn fields(&self) -> impl Iterator<Item = (String, u64)> + '_ {
        let points = self.sequence.as_ref().map_or(0, Sequence::count);
        self.axes.iter().flat_map(move |axis| {
            let count = axis.len().map_or(points, |len| len as u64);
            axis.fields.iter().map(move |field| (field.column(), count))
        })
    }

    /// From the outermost to the innermost.
    fn loops(&self) -> Vec<Loop> {
        let given =
            self.axes.iter().filter_map(|axis| axis.len().map(|len| Loop { len: len as u64, again: axis.again }));
        let sampled = self.sequence.as_ref().map(|sequence| Loop { len: sequence.count(), again: false });
        given.chain(sampled).collect()
    }
}

/// Where each loop is in a run.
fn places(loops: &[Loop], run: u64) -> Vec<u64> {
    let mut rest = run.saturating_sub(1);
    let mut places: Vec<u64> = loops
        .iter()
        .rev()
        .map(|of| {
            let at = rest % of.len;
            rest /= of.len;
            at
        })
        .collect();
    places.reverse();
    places
}
