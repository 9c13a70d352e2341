//! Report of the recovery of a damaged log: JSON and text.

use std::fmt::Write;

use serde::Serialize;

use super::document::{LossReport, MissingTopicReport};
use crate::format::{Report, ToReport, format_duration};
use crate::log::{Gap, Recovery};

/// Report of a recovery.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecoveryReport {
    /// Path of the damaged log, as given.
    pub log: String,
    /// Path of the recovered log, as given.
    pub recovered: String,
    pub bytes: u64,
    /// Whether no part of the log is lost.
    #[serde(rename = "whole")]
    pub is_complete: bool,
    pub losses: Vec<LossReport>,
    /// Expected topics that are missing or incomplete.
    pub missing: Vec<MissingTopicReport>,
    /// Requested duration.
    pub duration_s: Option<f64>,
    pub messages: u64,
    pub samples: u64,
    pub events: u64,
    /// Log time of the last message.
    pub end_s: Option<f64>,
    /// Messages that are missing before later messages of the same channel.
    pub missing_messages: u64,
    /// Messages omitted because the definitions of their channels are lost.
    #[serde(rename = "nameless_messages")]
    pub undefined_channel_messages: u64,
    /// Intervals without messages, except the end.
    pub gaps: Vec<GapReport>,
}

/// An interval without messages.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GapReport {
    pub after_messages: u64,
    pub from_s: f64,
    pub to_s: f64,
}

impl From<&Gap> for GapReport {
    fn from(gap: &Gap) -> Self {
        GapReport { after_messages: gap.after_messages, from_s: gap.from_s, to_s: gap.to_s }
    }
}

impl RecoveryReport {
    pub fn new(log: String, recovered: String, found: &Recovery) -> Self {
        let reading = &found.reading;
        RecoveryReport {
            log,
            recovered,
            bytes: reading.bytes,
            is_complete: reading.is_complete(),
            losses: reading.losses.iter().map(LossReport::from).collect(),
            missing: reading.missing.iter().map(MissingTopicReport::from).collect(),
            duration_s: reading.metadata.get("duration_s").and_then(|text| text.parse().ok()),
            messages: found.messages,
            samples: reading.samples,
            events: reading.events,
            end_s: found.to_s,
            missing_messages: found.missing,
            undefined_channel_messages: found.unidentified,
            gaps: found.gaps.iter().map(GapReport::from).collect(),
        }
    }
}

impl ToReport for RecoveryReport {
    fn report(&self) -> Report {
        let mut text = Report::default();
        let requested = self.duration_s.map_or("an unknown time".to_string(), format_duration);
        let reach =
            self.end_s.map_or(String::new(), |end_s| format!(", up to {} of {requested}", format_duration(end_s)));
        // Writing to a report cannot fail.
        let _ = writeln!(
            text,
            "{} contains the readable part of {}: {} messages, {} samples and {} events{reach}",
            self.recovered, self.log, self.messages, self.samples, self.events
        );
        for gap in &self.gaps {
            let _ = writeln!(
                text,
                "GAP: messages are missing between {} and {}",
                format_duration(gap.from_s),
                format_duration(gap.to_s)
            );
        }
        if self.missing_messages > 0 {
            let _ = writeln!(
                text,
                "{} messages are missing before later messages of the same channels",
                self.missing_messages
            );
        }
        if self.undefined_channel_messages > 0 {
            let _ = writeln!(
                text,
                "{} messages are omitted, because the definitions of their channels are lost",
                self.undefined_channel_messages
            );
        }
        for MissingTopicReport { topic, defect, .. } in &self.missing {
            let _ = writeln!(text, "MISSING: {topic} {defect}");
        }
        if self.is_complete {
            text.push_str("no part of the log was lost\n");
        }
        text
    }
}
