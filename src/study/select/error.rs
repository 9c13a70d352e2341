//! Errors while selecting runs.

use crate::table::TableError;

/// Error while selecting runs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SelectError {
    #[error("{0}; a selection requires the results of `phalanx sweep`")]
    Table(#[from] TableError),
    #[error(
        "the column `l12_m` is before `design`: the axes of the study are the columns between `design` and `l12_m`, \
         in that order, as `phalanx sweep` writes them"
    )]
    ColumnOrder,
    #[error("the results have no rows: run `phalanx sweep` first")]
    Empty,
    #[error("row {row} has no `{column}`: the row is not finished; let `phalanx sweep` resume and write it again")]
    MissingValue { row: usize, column: &'static str },
    #[error("run {run}: `{column}` is `{found}`, expected {allowed}")]
    UnknownName { run: i64, column: &'static str, found: String, allowed: &'static str },
    #[error("run {run}: `{column}` is {value}, expected a finite number or an empty cell")]
    NotFinite { run: i64, column: &'static str, value: f64 },
    #[error(
        "row {row} (run {run}) is completed, but has neither `{column}` nor a `reason`: the row is not finished; repeat the sweep \
         (`phalanx sweep --restart`)"
    )]
    Unfinished { row: usize, run: i64, column: &'static str },
    #[error("run {run} occurs twice, in rows {first} and {second}: remove one of them")]
    DuplicateRun { run: i64, first: usize, second: usize },
    #[error(
        "design {design} occurs twice with the same value of every axis, as runs {first} and {second}: use the results of one study, \
         which contain each design once per condition"
    )]
    DuplicateDesign { design: i64, first: i64, second: i64 },
    #[error("the weight of {name} is {value}, but weights must be finite and not negative")]
    Weight { name: &'static str, value: f64 },
    #[error("all weights are 0: at least one weight must be positive")]
    NoWeight,
}
