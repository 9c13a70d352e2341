//! What the checks of the 384 simulations found.

use serde::Serialize;

use crate::check::{Check, Verdict};
use crate::table::{Table, Value};

/// Runs by what their check says.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Checks {
    /// That came to their end, and were checked.
    pub runs: usize,
    /// Of which the outcome depends on the tolerance, on the last digits of the input, or that could not be checked.
    #[serde(rename = "uncertain_runs")]
    pub uncertain: Vec<i64>,
    #[serde(rename = "chaotic_runs")]
    pub chaotic: Vec<i64>,
    #[serde(rename = "unknown_runs")]
    pub unknown: Vec<i64>,
    /// Largest error of an angle in all others, rad.
    #[serde(rename = "worst_error_rad")]
    pub worst_rad: f64,
}

impl Checks {
    /// Counts the check of a run.
    pub fn add(&mut self, run: i64, check: &Check) {
        self.runs += 1;
        match check.verdict {
            Verdict::Uncertain => self.uncertain.push(run),
            Verdict::Chaotic => self.chaotic.push(run),
            Verdict::Unknown => self.unknown.push(run),
            Verdict::Sure => self.worst_rad = self.worst_rad.max(check.errors.path),
        }
    }
}

/// Writes what the check of a run found into its row, as a sweep with `--check` does.
pub fn tell(results: &mut Table, row: usize, check: &Check) {
    let cells = [("check", Value::from(check.verdict.name())), ("check_error_rad", Value::Number(check.errors.path))];
    for (name, value) in cells {
        if let Some(at) = results.columns.iter().position(|column| column.name == name) {
            results.rows[row][at] =
                if matches!(value, Value::Number(x) if !x.is_finite()) { Value::Missing } else { value };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Column, Kind};

    #[test]
    fn runs_are_sorted_by_their_verdict() {
        let check = |verdict, path| Check {
            verdict,
            errors: crate::check::Errors { path, ..Default::default() },
            sensitivity: 0.0,
            bar: 1e-5,
            bar_of: String::new(),
            motion: None,
            energy_bar: 1e-3,
            against: String::new(),
            reason: None,
        };
        let all = [
            (1, Verdict::Sure, 2e-9),
            (2, Verdict::Sure, 7e-8),
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
            tell(&mut table, run as usize - 1, &check(verdict, error));
        }
        let expected = Checks { runs: 5, uncertain: vec![3], chaotic: vec![4], unknown: vec![5], worst_rad: 7e-8 };
        assert_eq!(checks, expected);
        assert_eq!(table.rows[1], [2.into(), "sure".into(), 7e-8.into()]);
        assert_eq!(table.rows[3], [4.into(), "chaotic".into(), Value::Missing], "what is no number is not there");
        assert_eq!(table.rows[5], [6.into(), Value::Missing, Value::Missing], "not checked");
    }
}
