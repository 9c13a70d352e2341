//! What the checks of the 384 simulations found.

use super::ReproduceError;
use crate::check::Verdict;
use crate::table::{Table, TableError};

/// Runs by what their check says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checks {
    /// That came to their end, and were checked.
    pub runs: usize,
    /// Of which the outcome depends on the tolerance, on the last digits of the input, or that could not be checked.
    pub uncertain: Vec<i64>,
    pub chaotic: Vec<i64>,
    pub unknown: Vec<i64>,
    /// Largest error of an angle in all others, rad.
    pub worst_rad: f64,
}

/// Reads them off the results of the study.
pub fn checks(results: &Table) -> Result<Checks, ReproduceError> {
    read(results).map_err(|error| ReproduceError::of("the checks")(&error))
}

fn read(results: &Table) -> Result<Checks, TableError> {
    let mut found = Checks::default();
    let columns = (results.integers("run")?, results.texts("check")?, results.numbers("check_error_rad")?);
    for ((run, verdict), error_rad) in columns.0.into_iter().zip(columns.1).zip(columns.2) {
        let (Some(run), Some(verdict)) = (run, verdict) else { continue };
        found.runs += 1;
        let is = |of: Verdict| verdict == of.name();
        if is(Verdict::Uncertain) {
            found.uncertain.push(run);
        } else if is(Verdict::Chaotic) {
            found.chaotic.push(run);
        } else if is(Verdict::Unknown) {
            found.unknown.push(run);
        } else {
            found.worst_rad = found.worst_rad.max(error_rad.unwrap_or(0.0));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Column, Kind, Value};

    #[test]
    fn runs_are_sorted_by_their_verdict() {
        let columns = [("run", Kind::Integer), ("check", Kind::Text), ("check_error_rad", Kind::Number)];
        let line = |run: i64, verdict: &str, error: f64| vec![run.into(), verdict.into(), error.into()];
        let failed = vec![6.into(), Value::Missing, Value::Missing];
        let rows = vec![
            line(1, "sure", 2e-9),
            line(2, "sure", 7e-8),
            line(3, "uncertain", 1e-3),
            line(4, "chaotic", 1.0),
            line(5, "unknown", 0.0),
            failed,
        ];
        let table = Table::new(columns.map(|(name, kind)| Column::new(name, kind)).to_vec(), rows);
        let expected = Checks { runs: 5, uncertain: vec![3], chaotic: vec![4], unknown: vec![5], worst_rad: 7e-8 };
        assert_eq!(checks(&table), Ok(expected));
    }
}
