//! What was recovered of a damaged log, in the keys of the JSON document and as text.

use std::fmt::Write;

use serde::Serialize;

use super::document::{Lost, MissingReport};
use crate::log::{Gap, Recovery};
use crate::wording::{Report, Reported, duration};

/// One recovery.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecoveryReport {
    /// Paths of the damaged log and of the new one, as given.
    pub log: String,
    pub recovered: String,
    pub bytes: u64,
    /// Whether nothing of the log is lost.
    pub whole: bool,
    pub losses: Vec<Lost>,
    /// Topics that the log of such a run has and this one has not, or not all of.
    pub missing: Vec<MissingReport>,
    /// Length that was asked for.
    pub duration_s: Option<f64>,
    pub messages: u64,
    pub samples: u64,
    pub events: u64,
    /// Log time of the last message.
    pub end_s: Option<f64>,
    /// Messages missing before others of their channels.
    pub missing_messages: u64,
    /// Messages left out because the part that named their channels is lost.
    pub nameless_messages: u64,
    /// Places where messages are missing, not counting the end.
    pub gaps: Vec<GapReport>,
}

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
            whole: reading.is_whole(),
            losses: reading.losses.iter().map(Lost::from).collect(),
            missing: reading.missing.iter().map(MissingReport::from).collect(),
            duration_s: reading.metadata.get("duration_s").and_then(|text| text.parse().ok()),
            messages: found.messages,
            samples: reading.samples,
            events: reading.events,
            end_s: found.to_s,
            missing_messages: found.missing,
            nameless_messages: found.nameless,
            gaps: found.gaps.iter().map(GapReport::from).collect(),
        }
    }
}

/// The report for people, with a line end.
impl Reported for RecoveryReport {
    fn report(&self) -> Report {
        let mut text = Report::default();
        let asked = self.duration_s.map_or("an unknown time".to_string(), duration);
        let reach = self.end_s.map_or("no time".to_string(), duration);
        // Writing to a report cannot fail.
        let _ = writeln!(
            text,
            "{} is what can be read of {}: {} messages, {} samples and {} events, up to {reach} of {asked}",
            self.recovered, self.log, self.messages, self.samples, self.events
        );
        for gap in &self.gaps {
            let _ =
                writeln!(text, "GAP: messages are missing between {} and {}", duration(gap.from_s), duration(gap.to_s));
        }
        if self.missing_messages > 0 {
            let _ = writeln!(text, "{} messages are missing before others that are there", self.missing_messages);
        }
        if self.nameless_messages > 0 {
            let _ =
                writeln!(text, "{} messages are left out, for what their channels are is lost", self.nameless_messages);
        }
        for MissingReport { topic, what, .. } in &self.missing {
            let _ = writeln!(text, "MISSING: {topic} {what}");
        }
        if self.whole {
            text.push_str("nothing of the log was lost\n");
        }
        text
    }
}
