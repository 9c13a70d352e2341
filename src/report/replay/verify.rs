//! Report of the comparison of a log with a new simulation of its run: JSON and text.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;
use serde_json::Value;

use crate::format::format_duration;
use crate::format::numbers::{format_number, row};
use crate::format::report::{Report, Table};
use crate::log::{Difference, EntryDifference, FieldTally, LogSummary, Verification};

/// Maximum number of rows of the text table; the JSON document contains all.
const MAX_ROWS: usize = 15;
/// Maximum number of displayed characters of a text value.
const MAX_TEXT_CHARS: usize = 120;

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
    pub fn error_messages(&self, log: &Path) -> Vec<String> {
        let path = log.display();
        let mut lines = Vec::new();
        if !self.is_identical {
            let first = self.found.first_difference.as_ref().map(|Difference { time_s, channel, field, .. }| {
                format!(": the first difference is at {} in {channel} {field}", format_time(*time_s))
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
        let Verification { messages_compared: compared, messages_differing: differing, .. } = self.found;
        let found = &self.found;
        let reach = found
            .compared_to_s
            .map_or("nothing was compared".to_string(), |to_s| format!("up to {}", format_time(to_s)));
        let again = format!("simulated again in {}", format_duration(self.wall_s));
        let mut lines = vec![match self.is_identical {
            true if compared == 0 => "NOTHING COMPARED: the log contains no messages".to_string(),
            true => {
                let parts = match found.messages_unnumbered {
                    0 => "topic, schema, log and publish time, sequence number and payload",
                    _ => "topic, schema, log and publish time, payload, and the sequence number if the log has one",
                };
                let channels = found.channels;
                format!(
                    "VERIFIED: {again}; {compared} messages on {channels} channels are bit-identical, {reach}; compared: {parts}"
                )
            }
            false => format!(
                "DIFFERENT: {again}; {differing} of {compared} messages differ, {reach}; {} are only in the log, {} only in \
                 the new run",
                found.messages_only_in_log, found.messages_only_in_new_run
            ),
        }];
        if self.phalanx_version_log.as_deref() != Some(self.phalanx_version) {
            let log = self.phalanx_version_log.as_deref().unwrap_or("unknown");
            lines.push(format!("the log was written by phalanx {log}; this is phalanx {}", self.phalanx_version));
        }
        for (count, before, after) in [
            (found.messages_reordered, "the order of messages with equal log times, which differs for ", " messages"),
            (found.messages_unnumbered, "sequence numbers, which ", " messages of the log lack"),
            (
                found.messages_not_compared,
                "the last ",
                " messages, because a new simulation cannot reproduce the time of the interruption",
            ),
        ] {
            lines.extend((count > 0).then(|| format!("not compared: {before}{count}{after}")));
        }
        lines.extend(self.incomplete_reason.as_ref().map(|reason| format!("INCOMPLETE: {reason}")));
        lines.extend(found.first_difference.as_ref().map(first_difference));
        lines.extend(found.schema_differences.iter().cloned());
        for EntryDifference { key, log, new_run } in &found.metadata {
            let [log, new_run] = [log, new_run].map(|entry| entry.as_deref().unwrap_or("absent"));
            lines.push(format!("metadata {key}: {log} in the log, {new_run} in the new run"));
        }
        let mut text = Report::from(lines.join("\n") + "\n");
        if !found.fields.is_empty() {
            text.push('\n');
            text.push(field_table(&found.fields));
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
    let Difference { time_s, channel, field, log, new_run, absolute, relative } = first;
    let [log, new_run] = [log, new_run].map(format_value);
    let time = format_time(*time_s);
    let mut text =
        format!("first difference at {time} in {channel} {field}:\n  log       {log}\n  new run   {new_run}");
    if let Some(absolute) = absolute {
        let relative = relative.map(|relative| format!(", relative {}", format_number(relative, 3)));
        text += &format!("\n  differ by {}{}", format_number(*absolute, 3), relative.unwrap_or_default());
    }
    text
}

fn format_value(value: &Value) -> String {
    match value {
        Value::Null => "absent".to_string(),
        Value::String(text) if text.chars().count() > MAX_TEXT_CHARS => {
            text.chars().take(MAX_TEXT_CHARS).chain(['…']).collect()
        }
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn field_table(fields: &[FieldTally]) -> Report {
    let mut rows = vec![row(["channel", "field", "messages", "largest difference", "relative", "at, ms"])];
    for FieldTally { messages, largest } in fields.iter().take(MAX_ROWS) {
        let number = |value: Option<f64>| value.map_or("–".to_string(), |value| format_number(value, 3));
        rows.push(row([
            &largest.channel,
            &largest.field,
            &messages.to_string(),
            &number(largest.absolute),
            &number(largest.relative),
            &format!("{:.6}", largest.time_s * 1e3),
        ]));
    }
    let mut text = Report::from(Table::new(&rows).key_columns(2));
    if fields.len() > MAX_ROWS {
        // Writing to a report cannot fail.
        let _ = writeln!(text, "and {} more fields (--json lists all)", fields.len() - MAX_ROWS);
    }
    text
}
