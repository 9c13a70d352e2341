//! Results of the checks of the 384 simulations.

use serde::Serialize;

use crate::check::{Check, Verdict};
use crate::table::{Table, Value};

/// Checked runs by verdict.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Checks {
    /// Number of completed runs; all of them are checked.
    pub runs: usize,
    /// Runs whose outcome depends on the tolerance.
    #[serde(rename = "uncertain_runs")]
    pub uncertain: Vec<i64>,
    /// Runs whose outcome depends on the last digits of the input.
    #[serde(rename = "chaotic_runs")]
    pub chaotic: Vec<i64>,
    /// Runs that could not be checked.
    #[serde(rename = "unknown_runs")]
    pub unknown: Vec<i64>,
    /// Largest angle error of all other runs, rad.
    #[serde(rename = "worst_error_rad")]
    pub worst_rad: f64,
}

impl Checks {
    /// Adds the check of a run.
    pub fn add(&mut self, run: i64, check: &Check) {
        self.runs += 1;
        match check.verdict {
            Verdict::Uncertain => self.uncertain.push(run),
            Verdict::Chaotic => self.chaotic.push(run),
            Verdict::Unknown => self.unknown.push(run),
            Verdict::Accurate => self.worst_rad = self.worst_rad.max(check.errors.path),
        }
    }
}

/// Writes the check of a run into its row, as a sweep with `--check` does.
pub fn write_check(results: &mut Table, row: usize, check: &Check) {
    let cells = [("check", Value::from(check.verdict.name())), ("check_error_rad", Value::Number(check.errors.path))];
    for (name, value) in cells {
        if let Some(column) = results.columns.iter().position(|column| column.name == name) {
            results.rows[row][column] =
                if matches!(value, Value::Number(x) if !x.is_finite()) { Value::Missing } else { value };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Column, Kind};

    #[test]
    fn runs_are_grouped_by_verdict() {
        let check = |verdict, path| Check {
            verdict,
            errors: crate::check::Errors { path, ..Default::default() },
            sensitivity: 0.0,
            max_path_error: 1e-5,
            max_path_error_basis: String::new(),
            largest_displacement: None,
            max_energy_error: 1e-3,
            reference: String::new(),
            reason: None,
        };
        let all = [
            (1, Verdict::Accurate, 2e-9),
            (2, Verdict::Accurate, 7e-8),
            (3, Verdict::Uncertain, 1e-3),
            (4, Verdict::Chaotic, f64::INFINITY),
            (5, Verdict::Unknown, 0.0),
        ];
        let columns = [("run", Kind::Integer), ("check", Kind::Text), ("check_error_rad", Kind::Number)];
        let rows = (1..=6).map(|run: i64| vec![run.into(), Value::Missing, Value::Missing]).collect();
        let mut table = Table::new(columns.map(|(name, kind)| Column::new(name, kind)).to_vec(), rows);
        let mut checks = Checks::default();
        for (run, verdict, error) in all {
            checks.add(run, &check(verdict, error));
            write_check(&mut table, run as usize - 1, &check(verdict, error));
        }
        let expected = Checks { runs: 5, uncertain: vec![3], chaotic: vec![4], unknown: vec![5], worst_rad: 7e-8 };
        assert_eq!(checks, expected);
        assert_eq!(table.rows[1], [2.into(), "sure".into(), 7e-8.into()]);
        assert_eq!(
            table.rows[3],
            [4.into(), "chaotic".into(), Value::Missing],
            "an infinite error is written as a missing value"
        );
        assert_eq!(table.rows[5], [6.into(), Value::Missing, Value::Missing], "not checked");
    }
}
