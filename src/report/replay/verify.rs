//! Report of the comparison of a log with a new simulation of its run: JSON and text.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use crate::format::format_duration;
use crate::format::numbers::{format_number, row};
use crate::format::report::{Report, Table};
use crate::log::{Difference, FieldTally, FieldValue, LogSummary, Verification};

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
    pub channels: u64,
    pub messages_compared: u64,
    pub messages_differing: u64,
    pub messages_only_in_log: u64,
    pub messages_only_in_new_run: u64,
    /// Identical messages in a different order within the same log time. The order is not compared.
    pub messages_reordered: u64,
    /// Messages without a sequence number in the log; the number is not compared.
    pub messages_unnumbered: u64,
    /// Messages at the end of an interrupted run, which are not compared.
    pub messages_not_compared: u64,
    /// Messages of the new run in the gaps of a recovered log.
    pub messages_in_gaps: u64,
    /// Time up to which messages were compared.
    pub compared_to_s: Option<f64>,
    pub first_difference: Option<DifferenceReport>,
    /// The largest difference of every channel and field; entries of a list are combined.
    pub fields: Vec<FieldReport>,
    /// Differences of schemas and channels.
    pub structure: Vec<String>,
    /// Metadata entries that differ.
    pub metadata: Vec<EntryReport>,
}

/// A difference of one field of one message.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferenceReport {
    pub time_s: f64,
    pub channel: String,
    pub field: String,
    /// Value in the log: numbers as numbers (null if not finite), others as text; null if absent.
    pub log: serde_json::Value,
    /// Value in the new run.
    pub new_run: serde_json::Value,
    /// Absolute difference in the unit of the field; null if the values are not numbers.
    pub absolute: Option<f64>,
    /// Difference relative to the larger value.
    pub relative: Option<f64>,
}

/// A field in which messages differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldReport {
    pub messages: u64,
    #[serde(flatten)]
    pub largest: DifferenceReport,
}

/// A metadata entry that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EntryReport {
    pub key: String,
    pub log: Option<String>,
    pub new_run: Option<String>,
}

impl VerificationReport {
    /// Creates the report. `inconsistency` describes why the log cannot contain its whole run, if it is inconsistent.
    pub fn new(found: &Verification, reading: &LogSummary, inconsistency: Option<&str>, wall_s: f64) -> Self {
        let incomplete_reason = incomplete_reason(found, reading, inconsistency);
        VerificationReport {
            is_identical: found.is_same(),
            is_complete: incomplete_reason.is_none(),
            incomplete_reason,
            phalanx_version_log: reading.metadata.get("phalanx_version").cloned(),
            phalanx_version: env!("CARGO_PKG_VERSION"),
            wall_s,
            channels: found.channels,
            messages_compared: found.compared,
            messages_differing: found.differing,
            messages_only_in_log: found.only_in_log,
            messages_only_in_new_run: found.only_in_rerun,
            messages_reordered: found.reordered,
            messages_unnumbered: found.unnumbered,
            messages_not_compared: found.not_compared,
            messages_in_gaps: found.in_gaps,
            compared_to_s: found.last_compared_s,
            first_difference: found.first.as_ref().map(DifferenceReport::from),
            fields: found.fields.iter().map(|((_, field), tally)| FieldReport::new(field, tally)).collect(),
            structure: found.schema_differences.clone(),
            metadata: found
                .metadata
                .iter()
                .map(|(key, log, new_run)| EntryReport { key: key.clone(), log: log.clone(), new_run: new_run.clone() })
                .collect(),
        }
    }

    /// Returns error messages about differences and uncompared parts.
    pub fn error_messages(&self, log: &Path) -> Vec<String> {
        let path = log.display();
        let mut lines = Vec::new();
        if !self.is_identical {
            let first = self.first_difference.as_ref().map(|first| {
                format!(
                    ": the first difference is at {} in {} {}",
                    format_time(first.time_s),
                    first.channel,
                    first.field
                )
            });
            lines.push(format!("error: {path}: the log differs from a new simulation{}", first.unwrap_or_default()));
        }
        if let Some(reason) = &self.incomplete_reason {
            lines.push(format!("error: {path}: only part of the run could be compared: {reason}"));
        }
        lines
    }
}

/// Returns why only a part of a run was compared. A run that a signal interrupted counts as complete.
fn incomplete_reason(found: &Verification, reading: &LogSummary, inconsistency: Option<&str>) -> Option<String> {
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
    if reading.run_end.is_none() {
        return Some(format!("the log does not contain the end of its run; it contains {reach}"));
    }
    if found.in_gaps > 0 {
        return Some(format!("{} messages are missing in the middle of the recovered log", found.in_gaps));
    }
    None
}

impl FieldReport {
    fn new(field: &str, tally: &FieldTally) -> Self {
        let largest = DifferenceReport { field: field.to_string(), ..DifferenceReport::from(&tally.largest) };
        FieldReport { messages: tally.messages, largest }
    }
}

impl From<&Difference> for DifferenceReport {
    fn from(found: &Difference) -> Self {
        DifferenceReport {
            time_s: found.time_s,
            channel: found.channel.clone(),
            field: found.field.clone(),
            log: value(&found.log),
            new_run: value(&found.rerun),
            absolute: found.absolute(),
            relative: found.relative(),
        }
    }
}

fn value(field_value: &FieldValue) -> serde_json::Value {
    match field_value {
        FieldValue::Number(value) => serde_json::Value::from(*value),
        FieldValue::Integer(value) => i64::try_from(*value)
            .map(serde_json::Value::from)
            .or_else(|_| u64::try_from(*value).map(serde_json::Value::from))
            .unwrap_or(serde_json::Value::Null),
        FieldValue::Bool(value) => serde_json::Value::from(*value),
        FieldValue::Text(text) => serde_json::Value::from(text.as_str()),
        FieldValue::Bytes(bytes) => serde_json::Value::from(format!("{} bytes", bytes.len())),
        FieldValue::Missing => serde_json::Value::Null,
    }
}

/// Formats a time with nanosecond resolution.
fn format_time(time_s: f64) -> String {
    format!("{:.6} ms", time_s * 1e3)
}

/// Returns the text report of a verification.
pub(super) fn verification_report(report: &VerificationReport) -> Report {
    let mut text = Report::default();
    let reach =
        report.compared_to_s.map_or("nothing was compared".to_string(), |to_s| format!("up to {}", format_time(to_s)));
    // Writing to a report cannot fail.
    let _ = match report.is_identical {
        true if report.messages_compared == 0 => writeln!(text, "NOTHING COMPARED: the log contains no messages"),
        true => writeln!(
            text,
            "VERIFIED: simulated again in {}; {} messages on {} channels are bit-identical, {reach}; compared: {}",
            format_duration(report.wall_s),
            report.messages_compared,
            report.channels,
            compared_parts(report)
        ),
        false => writeln!(
            text,
            "DIFFERENT: simulated again in {}; {} of {} messages differ, {reach}; {} are only in the log, {} only in the new run",
            format_duration(report.wall_s),
            report.messages_differing,
            report.messages_compared,
            report.messages_only_in_log,
            report.messages_only_in_new_run
        ),
    };
    if report.phalanx_version_log.as_deref() != Some(report.phalanx_version) {
        let log = report.phalanx_version_log.as_deref().unwrap_or("unknown");
        let _ = writeln!(text, "the log was written by phalanx {log}; this is phalanx {}", report.phalanx_version);
    }
    if report.messages_reordered > 0 {
        let _ = writeln!(
            text,
            "not compared: the order of messages with equal log times, which differs for {} messages",
            report.messages_reordered
        );
    }
    if report.messages_unnumbered > 0 {
        let _ = writeln!(
            text,
            "not compared: sequence numbers, which {} messages of the log lack",
            report.messages_unnumbered
        );
    }
    if report.messages_not_compared > 0 {
        let _ = writeln!(
            text,
            "not compared: the last {} messages, because a new simulation cannot reproduce the time of the interruption",
            report.messages_not_compared
        );
    }
    if let Some(reason) = &report.incomplete_reason {
        let _ = writeln!(text, "INCOMPLETE: {reason}");
    }
    if let Some(first) = &report.first_difference {
        text.push_str(&first_difference(first));
    }
    for line in &report.structure {
        let _ = writeln!(text, "{line}");
    }
    for EntryReport { key, log, new_run } in &report.metadata {
        let or_absent = |entry: &Option<String>| entry.clone().unwrap_or_else(|| "absent".to_string());
        let _ = writeln!(text, "metadata {key}: {} in the log, {} in the new run", or_absent(log), or_absent(new_run));
    }
    if !report.fields.is_empty() {
        text.push('\n');
        text.push(fields(&report.fields));
    }
    text
}

/// Lists the compared parts of a message.
fn compared_parts(report: &VerificationReport) -> &'static str {
    match report.messages_unnumbered {
        0 => "topic, schema, log and publish time, sequence number and payload",
        _ => "topic, schema, log and publish time, payload, and the sequence number if the log has one",
    }
}

fn first_difference(first: &DifferenceReport) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "first difference at {} in {} {}:", format_time(first.time_s), first.channel, first.field);
    let _ = writeln!(text, "  log       {}", format_value(&first.log));
    let _ = writeln!(text, "  new run   {}", format_value(&first.new_run));
    if let Some(absolute) = first.absolute {
        let relative =
            first.relative.map(|relative| format!(", relative {}", format_number(relative, 3))).unwrap_or_default();
        let _ = writeln!(text, "  differ by {}{relative}", format_number(absolute, 3));
    }
    text
}

fn format_value(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Null => "absent".to_string(),
        serde_json::Value::String(text) if text.chars().count() > MAX_TEXT_CHARS => {
            text.chars().take(MAX_TEXT_CHARS).chain(['…']).collect()
        }
        serde_json::Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn fields(fields: &[FieldReport]) -> Report {
    let mut rows = vec![row(["channel", "field", "messages", "largest difference", "relative", "at, ms"])];
    for FieldReport { messages, largest } in fields.iter().take(MAX_ROWS) {
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
        let _ = writeln!(text, "and {} more fields (--json lists all)", fields.len() - MAX_ROWS);
    }
    text
}
