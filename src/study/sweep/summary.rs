//! What came out of a sweep, from its results.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use super::Status;
use super::one_finger::CLASSES;
use crate::criteria::{Class, Fate};
use crate::table::{Table, TableError};

/// Counts of a sweep's rows.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Summary {
    pub runs: u64,
    /// Runs by how they ended, in the order of [`Status::ALL`].
    #[serde(serialize_with = "by_name")]
    pub by_status: Vec<(String, u64)>,
    /// Completed runs by dynamic class, from good to bad; of grippers by what became of the grasp.
    #[serde(serialize_with = "by_name")]
    pub by_class: Vec<(String, u64)>,
    /// Completed runs without a class: the finger cannot grasp its object. `reasons` says why.
    pub no_class: u64,
    /// Why runs were not completed, or have no class: status, reason without its numbers, how many, and the first run of them.
    pub reasons: Vec<Reason>,
}

/// Counts by what is counted.
fn by_name<S: Serializer>(counts: &[(String, u64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(counts.iter().map(|(name, count)| (name, count)))
}

/// Runs that ended for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Reason {
    pub status: String,
    /// As it is in the first of these runs; others differ in their numbers.
    pub reason: String,
    pub runs: u64,
    pub first_run: u64,
}

impl Summary {
    /// How many runs ended so.
    pub fn with(&self, status: Status) -> u64 {
        self.by_status.iter().find(|(name, _)| name == status.name()).map_or(0, |(_, count)| *count)
    }

    /// Counts the rows of another table of the same study, which stand behind those of this one.
    pub fn add(&mut self, more: Summary) {
        self.runs += more.runs;
        self.no_class += more.no_class;
        for (counts, others) in [(&mut self.by_status, more.by_status), (&mut self.by_class, more.by_class)] {
            for ((_, count), (_, other)) in counts.iter_mut().zip(others) {
                *count += other;
            }
        }
        for reason in more.reasons {
            let same = |known: &&mut Reason| {
                known.status == reason.status && without_numbers(&known.reason) == without_numbers(&reason.reason)
            };
            match self.reasons.iter_mut().find(same) {
                Some(known) => known.runs += reason.runs,
                None => self.reasons.push(reason),
            }
        }
        in_order(&mut self.reasons);
    }
}

/// Counts the rows of a sweep's results.
///
/// # Errors
/// The table is no sweep's.
pub fn summary(table: &Table) -> Result<Summary, TableError> {
    let (runs, status) = (table.integers("run")?, table.texts("status")?);
    let of_grippers = table.texts("grasp");
    let (class, classes) = match of_grippers {
        Ok(fates) => (fates, Fate::NAMES.to_vec()),
        Err(_) => (table.texts("class")?, CLASSES.map(Class::name).to_vec()),
    };
    let reason = table.texts("reason")?;
    let count = |column: &[Option<&str>], name: &str| column.iter().filter(|cell| **cell == Some(name)).count() as u64;
    let rows = runs.iter().zip(&status).zip(&reason);
    let mut reasons =
        grouped(rows.filter_map(|((run, status), reason)| Some(((*run)?.unsigned_abs(), (*status)?, (*reason)?))));
    in_order(&mut reasons);
    let unjudged = |(status, class): &(&Option<&str>, &Option<&str>)| {
        **status == Some(Status::Completed.name()) && class.is_none()
    };
    Ok(Summary {
        no_class: status.iter().zip(&class).filter(unjudged).count() as u64,
        runs: table.rows.len() as u64,
        by_status: Status::ALL.map(|of| (of.name().to_string(), count(&status, of.name()))).to_vec(),
        by_class: classes.into_iter().map(|of| (of.to_string(), count(&class, of))).collect(),
        reasons,
    })
}

/// Runs by status and reason without its numbers: run, status and reason of each. Statuses are in the order of the alphabet.
pub(in crate::study) fn grouped<'a>(runs: impl Iterator<Item = (u64, &'a str, &'a str)>) -> Vec<Reason> {
    let mut found: BTreeMap<(&str, String), Reason> = BTreeMap::new();
    for (first_run, status, reason) in runs {
        let new = || Reason { status: status.to_string(), reason: reason.to_string(), runs: 0, first_run };
        found.entry((status, without_numbers(reason))).or_insert_with(new).runs += 1;
    }
    found.into_values().collect()
}

/// By status, the most frequent first.
fn in_order(reasons: &mut [Reason]) {
    reasons.sort_by_key(|reason| {
        let rank = Status::ALL.iter().position(|status| status.name() == reason.status);
        (rank, std::cmp::Reverse(reason.runs), reason.first_run)
    });
}

/// A reason by its words: the same thing happens at other times and lengths.
fn without_numbers(reason: &str) -> String {
    let numeric = |word: &str| word.contains(|c: char| c.is_ascii_digit()) && !word.starts_with('`');
    reason.split_whitespace().map(|word| if numeric(word) { "#" } else { word }).collect::<Vec<_>>().join(" ")
}
