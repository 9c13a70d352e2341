//! Whether a log is what simulating again gives, in the keys of the JSON document and as text.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use crate::log::{Difference, FieldTally, Leaf, Reading, Verification};
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::report::{Report, Table};

/// Rows of the table for people; the JSON document has them all.
const MOST_ROWS: usize = 15;
/// Characters of a text that are shown.
const MOST_TEXT: usize = 120;

/// One verification.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VerificationReport {
    /// Whether everything that was compared is the same, bit for bit.
    pub same: bool,
    /// Whether that was all of the run: nothing is lost, and the log says how it ended.
    pub complete: bool,
    /// Why it was not, in words.
    pub incomplete_because: Option<String>,
    pub phalanx_version_log: Option<String>,
    pub phalanx_version: &'static str,
    /// Wall time of simulating again.
    pub wall_s: f64,
    pub channels: u64,
    pub messages_compared: u64,
    pub messages_differing: u64,
    pub messages_only_in_log: u64,
    pub messages_only_in_new_run: u64,
    /// Messages that are the same and come in another order within their log time; the order is not compared.
    pub messages_reordered: u64,
    /// Messages to which the log gives no sequence number: the number is not compared.
    pub messages_unnumbered: u64,
    /// Of a run that was interrupted: what the interrupt left at the end.
    pub messages_not_compared: u64,
    /// Of a recovered log: what the new run has in its gaps.
    pub messages_in_gaps: u64,
    /// Time up to which messages were compared.
    pub compared_to_s: Option<f64>,
    pub first_difference: Option<DifferenceReport>,
    /// The largest difference of every channel and field; entries of lists together.
    pub fields: Vec<FieldReport>,
    /// What differs in schemas and channels.
    pub structure: Vec<String>,
    /// Entries of the metadata that differ.
    pub metadata: Vec<EntryReport>,
}

/// A difference of one field of one message.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferenceReport {
    pub time_s: f64,
    pub channel: String,
    pub field: String,
    /// Numbers as numbers (null if not finite), all else as text; null where there is nothing.
    pub log: serde_json::Value,
    pub new_run: serde_json::Value,
    /// In the unit of the field; null where they are no numbers.
    pub absolute: Option<f64>,
    /// Relative to the larger of the two.
    pub relative: Option<f64>,
}

/// A field in which messages differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldReport {
    pub messages: u64,
    #[serde(flatten)]
    pub largest: DifferenceReport,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EntryReport {
    pub key: String,
    pub log: Option<String>,
    pub new_run: Option<String>,
}

impl VerificationReport {
    /// `contradiction`: why the log cannot be all of its run, if it contradicts itself.
    pub fn new(found: &Verification, reading: &Reading, contradiction: Option<&str>, wall_s: f64) -> Self {
        let incomplete_because = incomplete(found, reading, contradiction);
        VerificationReport {
            same: found.is_same(),
            complete: incomplete_because.is_none(),
            incomplete_because,
            phalanx_version_log: reading.metadata.get("phalanx_version").cloned(),
            phalanx_version: env!("CARGO_PKG_VERSION"),
            wall_s,
            channels: found.channels,
            messages_compared: found.compared,
            messages_differing: found.differing,
            messages_only_in_log: found.only_in_log,
            messages_only_in_new_run: found.only_again,
            messages_reordered: found.reordered,
            messages_unnumbered: found.unnumbered,
            messages_not_compared: found.not_compared,
            messages_in_gaps: found.in_gaps,
            compared_to_s: found.up_to_s,
            first_difference: found.first.as_ref().map(DifferenceReport::from),
            fields: found.fields.iter().map(|((_, field), tally)| FieldReport::new(field, tally)).collect(),
            structure: found.structure.clone(),
            metadata: found
                .metadata
                .iter()
                .map(|(key, log, new_run)| EntryReport { key: key.clone(), log: log.clone(), new_run: new_run.clone() })
                .collect(),
        }
    }

    /// What to say on stderr.
    pub fn complaints(&self, log: &Path) -> Vec<String> {
        let place = log.display();
        let mut lines = Vec::new();
        if !self.same {
            let at = self.first_difference.as_ref().map(|first| {
                format!(": the first difference is at {} in {} {}", time(first.time_s), first.channel, first.field)
            });
            lines.push(format!("error: {place}: the log is not what simulating again gives{}", at.unwrap_or_default()));
        }
        if let Some(reason) = &self.incomplete_because {
            lines.push(format!("error: {place}: only a part of the run could be compared: {reason}"));
        }
        lines
    }
}

/// Why not all of a run was compared. A run that a signal ended is all there is of it.
fn incomplete(found: &Verification, reading: &Reading, contradiction: Option<&str>) -> Option<String> {
    let reach = reading.last_s.map_or("no sample".to_string(), |last_s| format!("samples up to {}", time(last_s)));
    if !reading.is_whole() {
        return Some(format!("a part of the log is lost; it has {reach}"));
    }
    if let Some(reason) = contradiction {
        return Some(format!("{reason}; it has {reach}"));
    }
    if !reading.missing.is_empty() {
        let topics: Vec<&str> = reading.missing.iter().map(|missing| missing.topic.as_str()).collect();
        return Some(format!("missing in the log: {}", topics.join(", ")));
    }
    if reading.ended.is_none() {
        return Some(format!("the log does not say how its run ended; it has {reach}"));
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
            new_run: value(&found.again),
            absolute: found.absolute(),
            relative: found.relative(),
        }
    }
}

fn value(leaf: &Leaf) -> serde_json::Value {
    match leaf {
        Leaf::Number(value) => serde_json::Value::from(*value),
        Leaf::Whole(value) => i64::try_from(*value)
            .map(serde_json::Value::from)
            .or_else(|_| u64::try_from(*value).map(serde_json::Value::from))
            .unwrap_or(serde_json::Value::Null),
        Leaf::Flag(value) => serde_json::Value::from(*value),
        Leaf::Text(text) => serde_json::Value::from(text.as_str()),
        Leaf::Bytes(bytes) => serde_json::Value::from(format!("{} bytes", bytes.len())),
        Leaf::Absent => serde_json::Value::Null,
    }
}

/// A time with all its digits: what differs may be a nanosecond apart.
fn time(time_s: f64) -> String {
    format!("{:.6} ms", time_s * 1e3)
}

/// The verification for people.
pub(super) fn verification_text(report: &VerificationReport) -> Report {
    let mut text = Report::default();
    let reach = report.compared_to_s.map_or("nothing was compared".to_string(), |to_s| format!("up to {}", time(to_s)));
    // Writing to a report cannot fail.
    let _ = match report.same {
        true if report.messages_compared == 0 => writeln!(text, "NOTHING COMPARED: there is no message in the log"),
        true => writeln!(
            text,
            "VERIFIED: simulated again in {}, {} messages on {} channels are the same bit for bit, {reach}; compared are {}",
            duration(report.wall_s),
            report.messages_compared,
            report.channels,
            compared(report)
        ),
        false => writeln!(
            text,
            "DIFFERENT: simulated again in {}, {} of {} messages differ, {reach}; {} are only in the log, {} only in the new run",
            duration(report.wall_s),
            report.messages_differing,
            report.messages_compared,
            report.messages_only_in_log,
            report.messages_only_in_new_run
        ),
    };
    if report.phalanx_version_log.as_deref() != Some(report.phalanx_version) {
        let log = report.phalanx_version_log.as_deref().unwrap_or("unknown");
        let _ = writeln!(text, "the log is of phalanx {log}, this is phalanx {}", report.phalanx_version);
    }
    if report.messages_reordered > 0 {
        let _ = writeln!(
            text,
            "not compared: the order of messages of one log time, in which {} messages differ",
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
            "not compared: the last {} messages, for simulating again cannot tell when this run was ended",
            report.messages_not_compared
        );
    }
    if let Some(reason) = &report.incomplete_because {
        let _ = writeln!(text, "INCOMPLETE: {reason}");
    }
    if let Some(first) = &report.first_difference {
        text.push_str(&first_difference(first));
    }
    for line in &report.structure {
        let _ = writeln!(text, "{line}");
    }
    for EntryReport { key, log, new_run } in &report.metadata {
        let shown = |entry: &Option<String>| entry.clone().unwrap_or_else(|| "nothing".to_string());
        let _ = writeln!(text, "metadata {key}: {} in the log, {} in the new run", shown(log), shown(new_run));
    }
    if !report.fields.is_empty() {
        text.push('\n');
        text.push(fields(&report.fields));
    }
    text
}

/// What of every message was compared.
fn compared(report: &VerificationReport) -> &'static str {
    match report.messages_unnumbered {
        0 => "topic, schema, log and publish time, sequence number and payload",
        _ => "topic, schema, log and publish time, payload, and the sequence number where the log has one",
    }
}

fn first_difference(first: &DifferenceReport) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "first difference at {} in {} {}:", time(first.time_s), first.channel, first.field);
    let _ = writeln!(text, "  log      {}", shown(&first.log));
    let _ = writeln!(text, "  new run  {}", shown(&first.new_run));
    if let Some(absolute) = first.absolute {
        let relative = first.relative.map(|relative| format!(", {} of it", figure(relative, 3))).unwrap_or_default();
        let _ = writeln!(text, "  apart    {}{relative}", figure(absolute, 3));
    }
    text
}

fn shown(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Null => "nothing".to_string(),
        serde_json::Value::String(text) if text.chars().count() > MOST_TEXT => {
            text.chars().take(MOST_TEXT).chain(['…']).collect()
        }
        serde_json::Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn fields(fields: &[FieldReport]) -> Report {
    let mut rows = vec![row(["channel", "field", "messages", "largest difference", "relative", "at, ms"])];
    for FieldReport { messages, largest } in fields.iter().take(MOST_ROWS) {
        let number = |value: Option<f64>| value.map_or("–".to_string(), |value| figure(value, 3));
        rows.push(row([
            &largest.channel,
            &largest.field,
            &messages.to_string(),
            &number(largest.absolute),
            &number(largest.relative),
            &format!("{:.6}", largest.time_s * 1e3),
        ]));
    }
    let mut text = Report::from(Table::new(&rows).keys(2));
    if fields.len() > MOST_ROWS {
        let _ = writeln!(text, "and {} more fields (--json has them all)", fields.len() - MOST_ROWS);
    }
    text
}
