//! What a table or a question can have wrong.

use crate::table::TableError;

/// Why nothing could be selected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SelectError {
    #[error("{0}; a selection takes the results that `phalanx sweep` writes")]
    Table(#[from] TableError),
    #[error(
        "the column `l12_m` stands before `design`: the axes of the study are the columns between `design` and `l12_m`, \
         in that order, as `phalanx sweep` writes them"
    )]
    Order,
    #[error("the results have no rows: run `phalanx sweep` first")]
    Empty,
    #[error("row {row} has no `{column}`: the row is not finished; let `phalanx sweep` resume and write it again")]
    Absent { row: usize, column: &'static str },
    #[error("run {run}: `{column}` is `{found}`, expected {allowed}")]
    Word { run: i64, column: &'static str, found: String, allowed: &'static str },
    #[error("run {run}: `{column}` is {value}, expected a finite number, or nothing where there is none")]
    NotFinite { run: i64, column: &'static str, value: f64 },
    #[error(
        "row {row} (run {run}) is completed, but has neither `{column}` nor a `reason`: the row is not finished; make the sweep \
         again (`phalanx sweep --restart`)"
    )]
    Unfinished { row: usize, run: i64, column: &'static str },
    #[error("run {run} is there twice, in rows {first} and {second}: remove one of them, each run may be there once")]
    Twice { run: i64, first: usize, second: usize },
    #[error(
        "design {design} is there twice with the same value of every axis, as runs {first} and {second}: give the results of one study, \
         in which each design is there once in each condition"
    )]
    DesignTwice { design: i64, first: i64, second: i64 },
    #[error("the weight of {name} is {value}, but weights must be finite numbers from 0")]
    Weight { name: &'static str, value: f64 },
    #[error("all weights are 0: at least one part of the ranking must count")]
    NoWeight,
}
