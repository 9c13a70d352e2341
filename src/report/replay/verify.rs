//! Report of the comparison of a log with a new simulation of its run: JSON and text.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use crate::format::format_duration;
use crate::format::numbers::{format_number, row};
use crate::format::report::{Report, table};
use crate::log::{Difference, EntryDifference, LogSummary, QuantityTally, Verification};

/// Maximum number of rows of the text table; the JSON document contains all.
const MAX_ROWS: usize = 15;

/// Report of a verification.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VerificationReport {
    /// Whether all compared data are identical, bit for bit.
    #[serde(rename = "same")]
    pub is_identical: bool,
    /// Whether the whole run was compared: no part of the log is lost, and it contains the end of the run.
    #[serde(rename = "complete")]
    pub is_complete: bool,
    /// Reason why only a part of the run was compared.
    #[serde(rename = "incomplete_because")]
    pub incomplete_reason: Option<String>,
    pub phalanx_version_log: Option<String>,
    pub phalanx_version: &'static str,
    /// Wall time of the new simulation.
    pub wall_s: f64,
    #[serde(flatten)]
    pub found: Verification,
}

impl VerificationReport {
    /// Creates the report. `inconsistency` describes why the log cannot contain its whole run, if it is inconsistent.
    pub fn new(found: Verification, reading: &LogSummary, inconsistency: Option<&str>, wall_s: f64) -> Self {
        let incomplete_reason = incomplete_reason(reading, inconsistency);
        VerificationReport {
            is_identical: found.is_same(),
            is_complete: incomplete_reason.is_none(),
            incomplete_reason,
            phalanx_version_log: reading.metadata.get("phalanx_version").cloned(),
            phalanx_version: env!("CARGO_PKG_VERSION"),
            wall_s,
            found,
        }
    }

    /// Returns error messages about differences and uncompared parts.
    pub(crate) fn error_messages(&self, log: &Path) -> Vec<String> {
        let path = log.display();
        let mut lines = Vec::new();
        if !self.is_identical {
            let first = self.found.first_difference.as_ref().map(|Difference { time_s, quantity, .. }| {
                format!(": the first difference is at {} in {quantity}", format_time(*time_s))
            });
            lines.push(format!("error: {path}: the log differs from a new simulation{}", first.unwrap_or_default()));
        }
        let incomplete = self.incomplete_reason.iter();
        lines.extend(
            incomplete.map(|reason| format!("error: {path}: only part of the run could be compared: {reason}")),
        );
        lines
    }

    /// Returns the text.
    pub(super) fn section(&self) -> Report {
        let found = &self.found;
        let Verification { samples_compared: samples, events_compared: events, .. } = *found;
        let reach = found
            .compared_to_s
            .map_or("nothing was compared".to_string(), |to_s| format!("up to {}", format_time(to_s)));
        let again = format!("simulated again in {}", format_duration(self.wall_s));
        let mut lines = vec![match self.is_identical {
            true if samples + events == 0 => "NOTHING COMPARED: the log contains no samples".to_string(),
            true => format!(
                "VERIFIED: {again}; {samples} samples and {events} events are bit-identical, {reach}; compared: every column \
                 of the samples, times, speeds and impulses of the events, and the settings"
            ),
            false => format!(
                "DIFFERENT: {again}; {} of {samples} samples and {} of {events} events differ, {reach}; only in the log: {} \
                 samples and {} events; only in the new run: {} samples and {} events",
                found.samples_differing,
                found.events_differing,
                found.samples_only_in_log,
                found.events_only_in_log,
                found.samples_only_in_new_run,
                found.events_only_in_new_run
            ),
        }];
        if self.phalanx_version_log.as_deref() != Some(self.phalanx_version) {
            let log = self.phalanx_version_log.as_deref().unwrap_or("unknown");
            lines.push(format!("the log was written by phalanx {log}; this is phalanx {}", self.phalanx_version));
        }
        if found.samples_not_compared > 0 {
            lines.push(format!(
                "not compared: the last {} samples, because a new simulation cannot reproduce the time of the interruption",
                found.samples_not_compared
            ));
        }
        lines.extend(self.incomplete_reason.as_ref().map(|reason| format!("INCOMPLETE: {reason}")));
        lines.extend(found.first_difference.as_ref().map(first_difference));
        for EntryDifference { key, log, new_run } in &found.metadata {
            let [log, new_run] = [log, new_run].map(|entry| entry.as_deref().unwrap_or("absent"));
            lines.push(format!("metadata {key}: {log} in the log, {new_run} in the new run"));
        }
        let mut text = Report::from(lines.join("\n") + "\n");
        if !found.quantities.is_empty() {
            text.push('\n');
            text.push(quantity_table(&found.quantities));
        }
        text
    }
}

/// Returns why only a part of a run was compared. A run that a signal interrupted counts as complete.
fn incomplete_reason(reading: &LogSummary, inconsistency: Option<&str>) -> Option<String> {
    let reach =
        reading.last_s.map_or("no sample".to_string(), |last_s| format!("samples up to {}", format_time(last_s)));
    if !reading.is_complete() {
        return Some(format!("a part of the log is lost; it contains {reach}"));
    }
    if let Some(reason) = inconsistency {
        return Some(format!("{reason}; it contains {reach}"));
    }
    if !reading.missing.is_empty() {
        let topics: Vec<&str> = reading.missing.iter().map(|missing| missing.topic.as_str()).collect();
        return Some(format!("missing in the log: {}", topics.join(", ")));
    }
    let has_end = reading.run_end.is_some();
    (!has_end).then(|| format!("the log does not contain the end of its run; it contains {reach}"))
}

/// Formats a time with nanosecond resolution.
fn format_time(time_s: f64) -> String {
    format!("{:.6} ms", time_s * 1e3)
}

fn first_difference(first: &Difference) -> String {
    let Difference { time_s, quantity, log, new_run, absolute, relative } = first;
    let value = |value: &Option<f64>| value.map_or("absent".to_string(), |value| format!("{value:?}"));
    let (time, log, new_run) = (format_time(*time_s), value(log), value(new_run));
    let mut text = format!("first difference at {time} in {quantity}:\n  log       {log}\n  new run   {new_run}");
    if let Some(absolute) = absolute {
        let relative = relative.map(|relative| format!(", relative {}", format_number(relative, 3)));
        text += &format!("\n  differ by {}{}", format_number(*absolute, 3), relative.unwrap_or_default());
    }
    text
}

fn quantity_table(quantities: &[QuantityTally]) -> Report {
    let mut rows = vec![row(["quantity", "samples", "largest difference", "relative", "at, ms"])];
    for QuantityTally { samples, largest } in quantities.iter().take(MAX_ROWS) {
        let number = |value: Option<f64>| value.map_or("–".to_string(), |value| format_number(value, 3));
        let time_ms = format!("{:.6}", largest.time_s * 1e3);
        let [absolute, relative] = [largest.absolute, largest.relative].map(number);
        rows.push(row([&largest.quantity, &samples.to_string(), &absolute, &relative, &time_ms]));
    }
    let mut text = table(&rows);
    if quantities.len() > MAX_ROWS {
        // Writing to a report cannot fail.
        let _ = writeln!(text, "and {} more columns (--json lists all)", quantities.len() - MAX_ROWS);
    }
    text
}
