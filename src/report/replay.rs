//! What a log says of its run, in the order and under the keys of the JSON document, and as text.

use std::fmt::Write;

use serde::Serialize;

use super::document::{Contacts, Dynamics, Energies, Failure, Final};
use super::text::{contacts, duration, dynamics, energies, final_state};
use crate::criteria::Criteria;
use crate::log::{Loss, Reading};
use crate::trace::{Event, EventKind, Outcome, Sample, Sink, SinkError};

/// One log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayReport {
    /// Path of the log as given.
    pub log: String,
    pub bytes: u64,
    /// Whether nothing of it is lost.
    pub whole: bool,
    /// What is lost, one sentence each.
    pub losses: Vec<Lost>,
    /// Name of the scene; null where the log does not say.
    pub scene: Option<String>,
    pub model: Option<String>,
    /// Version of phalanx that wrote it.
    pub phalanx_version: Option<String>,
    /// Length that was asked for.
    pub duration_s: Option<f64>,
    /// Whether the run was completed; null if the log does not get that far.
    pub completed: Option<bool>,
    /// Why it was not.
    pub error: Option<Failure>,
    /// Times of the first and last sample.
    pub first_s: Option<f64>,
    pub end_s: Option<f64>,
    pub samples: u64,
    pub events: u64,
    pub messages: u64,
    /// Of channels that phalanx does not know.
    pub unknown_messages: u64,
    pub unknown_channels: u64,
    #[serde(rename = "final")]
    pub last: Option<Final>,
    /// Peaks are those of the samples, which may miss those between them.
    pub contacts: Option<Contacts>,
    /// Null without an object or a scene, or if the log does not reach the end of a completed run.
    pub criteria: Option<Dynamics>,
    pub energy: Option<Energies>,
}

/// Something that is lost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lost {
    pub at_byte: u64,
    pub what: String,
    /// Messages behind the damage that are whole but were not used.
    pub readable_behind: u64,
}

impl From<&Loss> for Lost {
    fn from(loss: &Loss) -> Self {
        let (at_byte, readable_behind) = match loss {
            Loss::Truncated { at_byte, .. } | Loss::Scene { at_byte, .. } => (*at_byte, 0),
            Loss::Damaged { at_byte, behind, .. } => (*at_byte, behind.messages),
        };
        Lost { at_byte, what: loss.to_string(), readable_behind }
    }
}

/// A [`Sink`] that keeps of a run what its samples and events say in sum.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    outcome: Outcome,
    any: bool,
}

impl Summary {
    /// The summary, unless there was no sample. What a run costs is not known from its samples.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.any.then_some(&self.outcome)
    }
}

impl Sink for Summary {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.any = true;
        self.outcome.last = *sample;
        let (proximal, distal, limit) = (&sample.proximal, &sample.distal, &sample.limit);
        let now = [
            (proximal.normal_n, proximal.gap_m, proximal.impulse_n_s),
            (distal.normal_n, distal.gap_m, distal.impulse_n_s),
            (limit.torque_n_m, limit.gap_rad, limit.impulse_n_m_s),
        ];
        for (site, (force, gap, impulse)) in self.outcome.sites.iter_mut().zip(now) {
            site.peak_normal_n = site.peak_normal_n.max(force);
            site.max_penetration_m = site.max_penetration_m.max(-gap);
            site.impulse_n_s = impulse;
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if event.kind == EventKind::TouchDown {
            let site = &mut self.outcome.sites[event.site as usize];
            site.first_s.get_or_insert(event.time_s);
            site.touchdowns = site.touchdowns.saturating_add(1);
        }
        Ok(())
    }
}

impl ReplayReport {
    /// What was read, in sum. `criteria` are those of the whole run.
    pub fn new(log: String, reading: &Reading, summary: &Summary, criteria: Option<Criteria>) -> Self {
        let entry = |key: &str| reading.metadata.get(key).cloned();
        let outcome = summary.outcome();
        let stopped = reading.ended.as_ref().and_then(|ended| Some((ended.time_s, ended.stopped.clone()?)));
        ReplayReport {
            log,
            bytes: reading.bytes,
            whole: reading.is_whole(),
            losses: reading.losses.iter().map(Lost::from).collect(),
            scene: entry("scene"),
            model: entry("model"),
            phalanx_version: entry("phalanx_version"),
            duration_s: entry("duration_s").and_then(|text| text.parse().ok()),
            completed: reading.ended.as_ref().map(|ended| ended.stopped.is_none()),
            error: stopped.map(|(time_s, reason)| Failure { time_s, reason }),
            first_s: reading.first_s,
            end_s: reading.last_s,
            samples: reading.samples,
            events: reading.events,
            messages: reading.messages,
            unknown_messages: reading.unknown_messages,
            unknown_channels: reading.unknown_channels,
            last: outcome.map(|outcome| Final::from(&outcome.last)),
            contacts: outcome.map(Contacts::from),
            criteria: criteria.map(Dynamics::from),
            energy: outcome.map(|outcome| Energies::from(&outcome.last.energy)),
        }
    }
}

/// The report as one JSON document with a line end.
pub fn replay_json(report: &ReplayReport) -> String {
    super::document_text(report)
}

/// The whole summary, with a line end.
pub fn replay_text(report: &ReplayReport) -> String {
    let mut sections = vec![heading(report)];
    if let (Some(last), Some(end_s)) = (&report.last, report.end_s) {
        sections.push(final_state(last, end_s));
    }
    if let Some(all) = &report.contacts {
        sections.push(contacts(all));
        sections.push("peaks and depths are those of the samples\n".to_string());
    }
    if let Some(energy) = &report.energy {
        sections.push(energies(energy));
    }
    if let Some(criteria) = &report.criteria {
        sections.push(dynamics(criteria));
    }
    sections.join("\n")
}

fn heading(report: &ReplayReport) -> String {
    let known = |entry: &Option<String>| entry.clone().unwrap_or_else(|| "unknown".to_string());
    let asked = report.duration_s.map_or("an unknown time".to_string(), duration);
    let mut text = format!("{}: {} model, read from {}\n", known(&report.scene), known(&report.model), report.log);
    // Writing to a string cannot fail.
    let _ = match (&report.error, report.completed) {
        (Some(error), _) => {
            writeln!(text, "NOT COMPLETED: stopped at {} of {asked}: {}", duration(error.time_s), error.reason)
        }
        (None, Some(_)) => writeln!(text, "completed, {asked}"),
        (None, None) => match report.end_s {
            Some(end_s) => writeln!(text, "NOT COMPLETE: the log reaches {} of {asked}", duration(end_s)),
            None => writeln!(text, "NOT COMPLETE: no sample of {asked}"),
        },
    };
    let plural = |count: u64| if count == 1 { "" } else { "s" };
    let _ = write!(
        text,
        "{} sample{}, {} event{}",
        report.samples,
        plural(report.samples),
        report.events,
        plural(report.events)
    );
    if report.unknown_messages > 0 {
        let _ = write!(text, ", {} messages of channels that this phalanx does not know", report.unknown_messages);
    }
    text.push('\n');
    for lost in &report.losses {
        let _ = writeln!(text, "LOST: {}", lost.what);
    }
    text
}
