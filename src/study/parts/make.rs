//! One part: its runs, and its file.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use super::error::PartError;
use super::info::{PartInfo, open, sound};
use crate::files;
use crate::study::sweep::{Ran, Row, Shard, Study, Summary, run_range, sorted, summary};
use crate::table::{self, Format, Groups, Table, TableError};

/// How a part is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// 0 for one on each core.
    pub threads: usize,
    /// Make the part anew, in place of the part that is there, of whatever study.
    pub restart: bool,
}

/// A part that is there.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    pub part: PartInfo,
    /// What came out of its runs.
    pub found: Summary,
    /// What was done now; `None` if the part was there already.
    pub ran: Option<Ran>,
}

/// Makes a part of a study and writes it, whole or not at all. A part that is there already is left as it is: so the same call
/// again is what takes a broken sweep up. Two that make the same part at the same time write the same bytes.
///
/// `go_on` is asked all the time and says whether to; `each` hears of every row, in any order.
///
/// # Errors
/// The place is one for no part, or has something else; the file cannot be written; or it was told to stop.
pub fn write_part(
    study: &Study,
    shard: Shard,
    out: &Path,
    work: Work,
    go_on: &(dyn Fn() -> bool + Sync),
    mut each: impl FnMut(&Row) + Send,
) -> Result<Made, PartError> {
    let part = PartInfo::new(study, shard);
    place(out)?;
    if let Some(found) = there(study, &part, out, work.restart)? {
        return Ok(Made { part, found, ran: None });
    }
    let mut rows = Vec::new();
    let ran = run_range(study, work.threads, shard.first..=shard.last, &HashSet::new(), go_on, |row| {
        each(&row);
        rows.push(row.cells);
        true
    });
    if !ran.complete {
        return Err(PartError::Stopped { done: ran.runs, of: shard.runs() });
    }
    let table = sorted(study, rows);
    let file = || out.display().to_string();
    let broken = |error: TableError| match error {
        TableError::Write { file, reason } => PartError::Write { file, reason },
        error => PartError::Write { file: file(), reason: error.to_string() },
    };
    let found = summary(&table).map_err(broken)?;
    table::write_noted(out, &table, &part.notes()).map_err(broken)?;
    Ok(Made { part, found, ran: Some(ran) })
}

/// Whether a part can be written there.
fn place(out: &Path) -> Result<(), PartError> {
    let refused = |reason: String| Err(PartError::Place { file: out.display().to_string(), reason });
    match table::format(out) {
        Ok(Format::Parquet) => {}
        _ => {
            return refused(
                "a part is a Parquet file (NAME.parquet), for it has to say of which study it is; `phalanx sweep merge` \
                 makes CSV of parts"
                    .to_string(),
            );
        }
    }
    if files::is_special(out) {
        return refused("that is not a file; give the name of one".to_string());
    }
    files::place(out).or_else(refused)
}

/// What came out of the runs of this very part, if it is there. Nothing else is replaced, but another part for `restart`, and an
/// empty file, which is nobody's loss.
fn there(study: &Study, part: &PartInfo, out: &Path, restart: bool) -> Result<Option<Summary>, PartError> {
    if !fs::metadata(out).is_ok_and(|found| found.len() > 0) {
        return Ok(None);
    }
    let taken = |reason: String, help| PartError::Taken { file: out.display().to_string(), reason, help };
    let (found, groups) = match open(out) {
        Ok(found) => found,
        Err(PartError::NotAPart { reason, .. }) => {
            let reason = format!("is no part of a sweep ({reason})");
            return Err(taken(reason, "give another --out, or delete it first"));
        }
        Err(PartError::Damaged { .. }) if restart => return Ok(None),
        Err(error) => return Err(error),
    };
    if restart {
        return Ok(None);
    }
    let help = "give another --out, or replace it with --restart";
    if let Some(why) = found.foreign(study) {
        return Err(taken(format!("is a part of something else: {why}"), help));
    }
    if found.shard != part.shard {
        let Shard { number, of, .. } = found.shard;
        return Err(taken(format!("is another part of this study, shard {number}/{of}"), help));
    }
    sound(out, study, (&found, &groups))?;
    summary_of(out, groups).map(Some)
}

/// What came out of the runs of a part.
fn summary_of(path: &Path, mut groups: Groups) -> Result<Summary, PartError> {
    let columns = groups.columns().to_vec();
    let damaged =
        |error: TableError| PartError::Damaged { file: path.display().to_string(), reason: error.to_string() };
    let of = |rows| summary(&Table::new(columns.clone(), rows)).map_err(damaged);
    let mut found = of(Vec::new())?;
    while let Some(rows) = groups.next_group().map_err(damaged)? {
        found.add(of(rows)?);
    }
    Ok(found)
}
