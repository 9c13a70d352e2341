//! Reports of logs: summary, verification by a new simulation, and comparison of two logs.

mod comparison;
mod observer;

pub(crate) use comparison::{LogComparisonReport, TrajectoryDifference, compare_summaries};
pub use observer::{LogObserver, scene_in_log};

use std::path::Path;

use serde::{Serialize, Serializer};

use super::contacts::Contacts;
use super::document::{Failure, serialize_settings, settings_text};
use super::object::ObjectReport;
use super::states::States;
use super::tables;
use crate::criteria::{CableEvent, Criteria, Fate, RunCriteria};
use crate::format::format_duration;
use crate::format::numbers::{format_number, or_dash, row};
use crate::format::report::{Report, ToReport, table};
use crate::log::{
    ChannelContent, Difference, EntryDifference, LogSummary, QuantityTally, Solver, Verification, settings,
};
use crate::page::PlayedGrasp;
use crate::scene::{Engine, Integrator, one_line};
use crate::trace::{Energy, FingerState};

/// Maximum number of rows of the table of a verification; the JSON document contains all.
const MAX_ROWS: usize = 15;

/// Report of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayReport {
    /// Path of the log, as given by the user.
    pub log: String,
    /// Path of the page, as given by the user; null if no page was requested.
    pub page: Option<String>,
    /// Path of the table of samples, as given by the user; null if no table was requested.
    pub csv: Option<String>,
    /// Contents of the log, and its lost and missing parts.
    #[serde(flatten)]
    pub reading: LogSummary,
    /// Whether the log is complete: no part of it is lost.
    #[serde(rename = "whole")]
    pub is_complete: bool,
    /// Name of the scene; null if the log does not contain it.
    pub scene: Option<String>,
    /// Kind of scene: `finger`, `gripper`, `bodies` or `mechanism`; null if the log does not contain it.
    pub kind: Option<String>,
    /// Whether the log has joints.
    #[serde(skip)]
    pub has_joints: bool,
    pub model: Option<String>,
    /// Version of phalanx that wrote the log.
    pub phalanx_version: Option<String>,
    /// Requested duration of the run, s.
    pub duration_s: Option<f64>,
    /// Number of samples on the grid per second.
    pub log_numeric_hz: Option<f64>,
    /// Settings of the analytic model, as in the report of the run. Null for a run of the engine, or if they cannot be
    /// read.
    #[serde(serialize_with = "serialize_settings")]
    pub integrator: Option<Integrator>,
    /// Settings of the engine. Null for a run of the analytic model, or if they cannot be read.
    #[serde(serialize_with = "serialize_settings")]
    pub engine: Option<Engine>,
    /// Whether the run was completed; null if the log does not contain the end of the run.
    pub completed: Option<bool>,
    /// Reason why the run was not completed; null for a completed run.
    pub error: Option<Failure>,
    /// States of fingers and bodies in the last sample.
    #[serde(flatten, serialize_with = "serialize_states")]
    pub states: Option<States>,
    /// Contacts; those whose topics are missing are omitted. Peaks are taken from the samples, which include the peaks
    /// of the run.
    pub contacts: Option<Contacts>,
    /// Lift-offs of cables from pulleys, and their returns; omitted without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cable_events: Vec<CableEvent>,
    /// Criteria of a finger. Null without an object or without a scene, if the log does not reach the end of a
    /// completed run, or if a required topic is missing.
    pub criteria: Option<Criteria>,
    /// Criteria of the object of a hand; omitted under the conditions under which `criteria` is null.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<Box<ObjectReport>>,
    pub energy: Option<Energy>,
    /// Reasons to doubt the results; empty for a valid run.
    pub warnings: Vec<String>,
    /// Whether the log is inconsistent: it marks a run as completed although the run is shorter than the duration in its
    /// settings.
    #[serde(skip)]
    pub is_inconsistent: bool,
    /// Comparison with a new simulation; null unless it was requested.
    pub verification: Option<VerificationReport>,
}

/// The key `final` is always present, null where there is no such state or no sample.
fn serialize_states<S: Serializer>(states: &Option<States>, serializer: S) -> Result<S::Ok, S::Error> {
    let mut entries = states.as_ref().map(States::entries).unwrap_or_default();
    if !entries.iter().any(|(known, _)| *known == "final") {
        entries.push(("final", None));
    }
    serializer.collect_map(entries)
}

impl ReplayReport {
    /// Creates the report of a log. `found` are the criteria of the run.
    fn new(
        log: String,
        reading: &LogSummary,
        observer: &LogObserver,
        found: Option<RunCriteria>,
        warnings: Vec<String>,
    ) -> Self {
        let (schema, outcome, scene) = (&observer.schema, observer.outcome(), observer.bodies_scene());
        let (criteria, grasp, cable_events) =
            found.map_or((None, None, Vec::new()), |found| (found.criteria, found.grasp, found.cable_events));
        let entry = |key: &str| reading.metadata.get(key).cloned();
        let number = |key: &str| entry(key).and_then(|text| text.parse().ok());
        let (integrator, engine) = match settings(&reading.metadata).map(|settings| settings.solver) {
            Ok(Solver::Analytic(integrator)) => (Some(integrator), None),
            Ok(Solver::Engine(engine)) => (None, Some(engine)),
            Err(_) => (None, None),
        };
        let ended = reading.run_end.as_ref();
        let states = outcome.map(|outcome| {
            let mut states = States::new(schema, Some(outcome), scene);
            // A topic of a joint may be missing.
            let is_known = |finger: &FingerState| {
                let rates = finger.qd11_rad_s + finger.qd21_rad_s;
                !(finger.q11_rad + finger.q21_rad + finger.q12_rad + finger.q22_rad + finger.q13_rad + rates).is_nan()
            };
            states.fingers.0.retain(|(_, finger)| is_known(finger));
            states.bodies.0.retain(|(_, body)| !body.state.centre_m[0].is_nan());
            states
        });
        let contacts = outcome.map(|outcome| {
            let mut contacts = Contacts::new(schema, outcome, observer.rebounds());
            for missing in &reading.missing {
                let incomplete = missing.content.contact().and_then(|index| schema.contacts.get(index));
                let lacks_events = missing.content == ChannelContent::Events;
                contacts
                    .all
                    .0
                    .retain(|(name, _)| !lacks_events && incomplete.is_none_or(|contact| contact.name != *name));
            }
            contacts
        });
        let mut report = ReplayReport {
            log,
            page: None,
            csv: None,
            is_complete: reading.is_complete(),
            scene: entry("scene"),
            kind: entry("kind"),
            has_joints: !schema.joints.is_empty(),
            model: entry("model"),
            phalanx_version: entry("phalanx_version"),
            duration_s: number("duration_s"),
            log_numeric_hz: number("log_numeric_hz"),
            integrator,
            engine,
            completed: ended.map(|ended| ended.stopped.is_none()),
            error: ended.and_then(|ended| Some(Failure { time_s: ended.time_s, reason: ended.stopped.clone()? })),
            states,
            contacts,
            cable_events,
            criteria,
            grasp: grasp.map(|found| Box::new(ObjectReport::new(&found, scene))),
            energy: outcome.map(|outcome| outcome.last.energy()).filter(|energy| !energy.kinetic_j.is_nan()),
            warnings,
            is_inconsistent: false,
            verification: None,
            reading: reading.clone(),
        };
        // The run of a hand ends when the object leaves it. Without its fate, an early end is not an error.
        let ends_at_exit = reading.finger_count() == 2 || scene.is_some_and(|scene| scene.grasp.is_some());
        let may_end_early = ends_at_exit
            && report.grasp.as_ref().is_none_or(|grasp| {
                grasp.criteria.left_s.is_some() || matches!(grasp.criteria.fate, Fate::Ejected { .. })
            });
        if let Some(time_s) = ends_early(reading, report.duration_s).filter(|_| !may_end_early) {
            let requested = report.duration_s.map_or("an unknown time".to_string(), format_duration);
            let reason =
                format!("the log marks its run as completed, but {requested} were requested: the log is inconsistent");
            (report.completed, report.error, report.is_inconsistent) =
                (Some(false), Some(Failure { time_s, reason }), true);
            (report.criteria, report.grasp) = (None, None);
        }
        report
    }

    /// The grasp in the form in which a page shows it.
    pub fn played_grasp(&self) -> Option<PlayedGrasp> {
        self.grasp.as_deref().map(ObjectReport::played)
    }

    /// Returns error messages about missing topics and inconsistencies.
    pub(crate) fn error_messages(&self) -> Vec<String> {
        let (log, withheld_results) = (&self.log, self.withheld_results());
        let mut lines: Vec<String> = Vec::new();
        for missing in &self.reading.missing {
            let withheld = withheld_results.filter(|_| missing.is_required_for_verdict);
            let withheld = withheld.map_or(String::new(), |results| format!("; {results}"));
            lines.push(format!("error: {log}: missing data: {} {}{withheld}", missing.topic, missing.defect));
        }
        let inconsistency = self.error.as_ref().filter(|_| self.is_inconsistent);
        lines.extend(inconsistency.map(|error| format!("error: {log}: {}", error.reason)));
        lines
    }

    /// Describes the results that are omitted because a topic is missing.
    fn withheld_results(&self) -> Option<&'static str> {
        let withholds = self.reading.missing.iter().any(|missing| missing.is_required_for_verdict);
        let has_criteria = self.kind.is_some() && self.reading.finger_count() > 0;
        (withholds && has_criteria).then_some("class and criteria are omitted")
    }

    fn heading(&self) -> String {
        let requested = self.duration_s.map_or("an unknown time".to_string(), format_duration);
        let settings = settings_text(self.integrator.as_ref(), self.engine.as_ref(), self.has_joints);
        let [scene, model] = [&self.scene, &self.model].map(or_unknown);
        let end = match (&self.error, self.completed, self.reading.last_s.map(format_duration)) {
            (Some(error), ..) => error.text(&requested),
            (None, Some(_), _) => format!("completed, {requested}"),
            (None, None, Some(end)) => format!("NOT COMPLETE: the log reaches {end} of {requested}"),
            (None, None, None) => format!("NOT COMPLETE: the log contains no sample of the {requested} run"),
        };
        let leaving = self.grasp.as_ref().and_then(|grasp| grasp.leaving());
        let leaving = leaving.filter(|_| ends_early(&self.reading, self.duration_s).is_some());
        let LogSummary { samples, events, unknown_messages, .. } = self.reading;
        let plural = |count: u64| if count == 1 { "" } else { "s" };
        let mut content = format!("{samples} sample{}, {events} event{}", plural(samples), plural(events));
        if unknown_messages > 0 {
            content += &format!(", {unknown_messages} messages of channels unknown to this version of phalanx");
        }
        let mut lines = vec![
            format!("{scene}: {model} model{settings}"),
            format!("read from {}", one_line(&self.log)),
            end,
            content,
        ];
        lines.extend(leaving);
        lines.extend(self.csv.iter().map(|csv| format!("samples: {}", one_line(csv))));
        lines.extend(self.page.iter().map(|page| format!("page: {}", one_line(page))));
        lines.extend(self.reading.losses.iter().map(|loss| format!("LOST: {}", loss.description)));
        let missing = self.reading.missing.iter();
        lines.extend(missing.map(|missing| format!("MISSING: {} {}", missing.topic, missing.defect)));
        let withheld = self.withheld_results();
        lines.extend(withheld.map(|results| format!("{results}, because they depend on missing data")));
        lines.extend(self.warnings.iter().map(|warning| format!("Warning: {warning}")));
        lines.join("\n") + "\n"
    }
}

/// Formats an entry of the metadata.
fn or_unknown(entry: &Option<String>) -> String {
    one_line(entry.as_deref().unwrap_or("unknown"))
}

impl ToReport for ReplayReport {
    fn report(&self) -> Report {
        let object = self.grasp.as_ref();
        let mut sections: Vec<Report> = object.map(|object| object.heading().into()).into_iter().collect();
        sections.push(self.heading().into());
        sections.extend(object.map(|object| object.pairs(self.contacts.as_ref())));
        sections.extend(object.into_iter().flat_map(|object| [object.actuators().into(), object.motion().into()]));
        let last = self.states.as_ref().zip(self.reading.last_s);
        sections.extend(last.into_iter().flat_map(|(last, end_s)| tables::states(last, end_s)));
        sections.extend([
            self.contacts.as_ref().map(tables::contacts).into(),
            tables::cable_events(&self.cable_events).into(),
            self.energy.map(|energy| tables::energies(&energy, self.has_joints)).into(),
            self.criteria.as_ref().map(tables::criteria).into(),
            self.verification.as_ref().map(VerificationReport::section).into(),
        ]);
        Report::join(sections)
    }
}

/// Returns the end time of a run that is marked as completed but ended before the requested time.
fn ends_early(reading: &LogSummary, duration_s: Option<f64>) -> Option<f64> {
    let ended = reading.run_end.as_ref().filter(|ended| ended.stopped.is_none())?;
    // Log times are whole nanoseconds.
    (duration_s? - ended.time_s > 1e-9 + 1e-12 * ended.time_s).then_some(ended.time_s)
}

/// Report of a verification.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VerificationReport {
    /// Whether all compared data are identical, bit for bit.
    #[serde(rename = "same")]
    pub is_identical: bool,
    /// Whether the whole run was compared: no part of the log is lost, and the log contains the end of the run.
    #[serde(rename = "complete")]
    pub is_complete: bool,
    /// Reason why only part of the run was compared; null if the whole run was compared.
    #[serde(rename = "incomplete_because")]
    pub incomplete_reason: Option<String>,
    pub phalanx_version_log: Option<String>,
    pub phalanx_version: &'static str,
    /// Wall time of the new simulation, s.
    pub wall_s: f64,
    #[serde(flatten)]
    pub found: Verification,
}

impl VerificationReport {
    /// Creates the report. `inconsistency` states why the log cannot contain its whole run; `None` if it is consistent.
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
        lines.extend(
            self.incomplete_reason
                .iter()
                .map(|reason| format!("error: {path}: only part of the run could be compared: {reason}")),
        );
        lines
    }

    fn section(&self) -> Report {
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
        Report::join([(lines.join("\n") + "\n").into(), quantity_table(&found.quantities)])
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
    if quantities.is_empty() {
        return Report::default();
    }
    let mut rows = vec![row(["quantity", "samples", "largest difference", "relative", "at, ms"])];
    for QuantityTally { samples, largest } in quantities.iter().take(MAX_ROWS) {
        let time_ms = format!("{:.6}", largest.time_s * 1e3);
        let [absolute, relative] =
            [largest.absolute, largest.relative].map(|value| or_dash(value, |value| format_number(value, 3)));
        rows.push(row([&largest.quantity, &samples.to_string(), &absolute, &relative, &time_ms]));
    }
    let omitted = quantities.len().saturating_sub(MAX_ROWS);
    table(&rows).with((omitted > 0).then(|| format!("and {omitted} more columns (--json lists all)\n")))
}
