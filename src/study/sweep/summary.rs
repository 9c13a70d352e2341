//! Summary of the results of a sweep.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use super::Status;
use crate::criteria::{Class, Fate};
use crate::table::{Table, TableError};

/// Counts of the rows of a sweep.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Summary {
    pub runs: u64,
    /// Runs by status, in the order of [`Status::ALL`].
    #[serde(serialize_with = "by_name")]
    pub by_status: Vec<(String, u64)>,
    /// Completed runs of fingers by dynamic class from best to worst; of grippers by the fate of the grasp.
    #[serde(serialize_with = "by_name")]
    pub by_class: Vec<(String, u64)>,
    /// Completed runs without a class, because the finger cannot grasp its object. `reasons` contains the reasons.
    pub no_class: u64,
    /// Reasons of runs that were not completed or have no class, grouped by status and text without numbers.
    pub reasons: Vec<Reason>,
}

/// Serialises counts as a map.
fn by_name<S: Serializer>(counts: &[(String, u64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(counts.iter().map(|(name, count)| (name, count)))
}

/// Runs with the same reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Reason {
    pub status: String,
    /// Text of the first of these runs; the others differ in numbers only.
    pub reason: String,
    pub runs: u64,
    pub first_run: u64,
}

impl Summary {
    /// Number of runs with this status.
    pub fn count_with_status(&self, status: Status) -> u64 {
        self.by_status.iter().find(|(name, _)| name == status.name()).map_or(0, |(_, count)| *count)
    }

    /// Adds the counts of later rows of the same study.
    pub fn add(&mut self, other: Summary) {
        self.runs += other.runs;
        self.no_class += other.no_class;
        for (counts, other_counts) in [(&mut self.by_status, other.by_status), (&mut self.by_class, other.by_class)] {
            for ((_, count), (_, other)) in counts.iter_mut().zip(other_counts) {
                *count += other;
            }
        }
        for reason in other.reasons {
            let is_same = |known: &&mut Reason| {
                known.status == reason.status && without_numbers(&known.reason) == without_numbers(&reason.reason)
            };
            match self.reasons.iter_mut().find(is_same) {
                Some(known) => known.runs += reason.runs,
                None => self.reasons.push(reason),
            }
        }
        sort_reasons(&mut self.reasons);
    }
}

/// Summarises the results of a sweep.
///
/// # Errors
/// Returns an error if the table is not the result of a sweep.
pub fn summary(table: &Table) -> Result<Summary, TableError> {
    let (runs, status) = (table.integers("run")?, table.texts("status")?);
    let grasp = table.texts("grasp");
    let (class, classes) = match grasp {
        Ok(fates) => (fates, Fate::NAMES.to_vec()),
        Err(_) => (table.texts("class")?, Class::ALL.map(Class::name).to_vec()),
    };
    let reason = table.texts("reason")?;
    let count = |column: &[Option<&str>], name: &str| column.iter().filter(|cell| **cell == Some(name)).count() as u64;
    let rows = runs.iter().zip(&status).zip(&reason);
    let mut reasons = group_reasons(
        rows.filter_map(|((run, status), reason)| Some(((*run)?.unsigned_abs(), (*status)?, (*reason)?))),
    );
    sort_reasons(&mut reasons);
    let has_no_class = |(status, class): &(&Option<&str>, &Option<&str>)| {
        **status == Some(Status::Completed.name()) && class.is_none()
    };
    Ok(Summary {
        no_class: status.iter().zip(&class).filter(has_no_class).count() as u64,
        runs: table.rows.len() as u64,
        by_status: Status::ALL.map(|kind| (kind.name().to_string(), count(&status, kind.name()))).to_vec(),
        by_class: classes.into_iter().map(|name| (name.to_string(), count(&class, name))).collect(),
        reasons,
    })
}

/// Groups runs, given as (run, status, reason), by status and reason without numbers. Statuses are in alphabetical
/// order.
pub(in crate::study) fn group_reasons<'a>(runs: impl Iterator<Item = (u64, &'a str, &'a str)>) -> Vec<Reason> {
    let mut groups: BTreeMap<(&str, String), Reason> = BTreeMap::new();
    for (first_run, status, reason) in runs {
        let new = || Reason { status: status.to_string(), reason: reason.to_string(), runs: 0, first_run };
        groups.entry((status, without_numbers(reason))).or_insert_with(new).runs += 1;
    }
    groups.into_values().collect()
}

/// Sorts by status, then by frequency.
fn sort_reasons(reasons: &mut [Reason]) {
    reasons.sort_by_key(|reason| {
        let rank = Status::ALL.iter().position(|status| status.name() == reason.status);
        (rank, std::cmp::Reverse(reason.runs), reason.first_run)
    });
}

/// Replaces words with digits by `#`, so that reasons that differ only in numbers are equal.
fn without_numbers(reason: &str) -> String {
    let numeric = |word: &str| word.contains(|checker: char| checker.is_ascii_digit()) && !word.starts_with('`');
    reason.split_whitespace().map(|word| if numeric(word) { "#" } else { word }).collect::<Vec<_>>().join(" ")
}
