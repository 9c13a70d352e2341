//! The JSON document of a log.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use super::super::contacts::Contacts;
use super::super::document::{EffectiveSettings, Failure};
use super::super::grasp::GraspReport;
use super::super::states::States;
use super::summary::Summary;
use super::verify::VerificationReport;
use crate::criteria::{Criteria, Fate, GraspCriteria};
use crate::format::format_duration;
use crate::log::{LogSummary, Loss, MissingData, Solver, TopicSubject, settings};
use crate::scene::keywords::SceneKind;
use crate::scene::{Engine, Integrator, Keyword, Scene};
use crate::trace::{Energy, Layout, Outcome};

/// Report of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayReport {
    /// Path of the log as given.
    pub log: String,
    /// Path of the page as given; null if none was requested.
    pub page: Option<String>,
    /// Path of the table of samples as given; null if none was requested.
    pub csv: Option<String>,
    pub bytes: u64,
    /// Whether no part of the log is lost.
    #[serde(rename = "whole")]
    pub is_complete: bool,
    /// Lost parts.
    pub losses: Vec<LossReport>,
    /// Expected topics that are missing or incomplete. Results that depend on them are omitted.
    pub missing: Vec<MissingTopicReport>,
    /// Name of the scene; null if the log does not contain it.
    pub scene: Option<String>,
    /// `finger`, `bodies` or `gripper`; null if the log does not contain it.
    pub kind: Option<String>,
    pub model: Option<String>,
    /// Version of phalanx that wrote the log.
    pub phalanx_version: Option<String>,
    /// Requested duration.
    pub duration_s: Option<f64>,
    /// Samples on the grid, per second.
    pub log_numeric_hz: Option<f64>,
    /// Settings of the analytic model, as in the report of the run; null for the engine, and where they cannot be read.
    pub integrator: Option<EffectiveSettings<Integrator>>,
    /// Settings of the engine, likewise.
    pub engine: Option<EffectiveSettings<Engine>>,
    /// Metadata of the log, unchanged: versions, model, settings in SI units.
    pub settings: BTreeMap<String, String>,
    /// Metadata about the recovery; null unless the log was recovered from a damaged one.
    pub recovered: Option<BTreeMap<String, String>>,
    /// Whether the run was completed; null if the log does not contain the end of the run.
    pub completed: Option<bool>,
    /// Reason why the run was not completed.
    pub error: Option<Failure>,
    /// Time of the first sample.
    pub first_s: Option<f64>,
    /// Time of the last sample.
    pub end_s: Option<f64>,
    pub samples: u64,
    pub events: u64,
    pub messages: u64,
    /// Messages of channels that phalanx does not know.
    pub unknown_messages: u64,
    /// Channels that phalanx does not know.
    pub unknown_channels: u64,
    #[serde(flatten)]
    pub states: FinalStates,
    /// Contacts. Peaks are taken from the samples, which include the peaks of the run.
    pub contacts: Option<Contacts>,
    /// Criteria of a finger; null without an object or a scene, if the log does not reach the end of a completed run,
    /// or if a required topic is missing.
    pub criteria: Option<Criteria>,
    /// Criteria of a gripper; omitted under the same conditions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<GraspReport>,
    pub energy: Option<Energy>,
    /// Reasons to doubt the results; empty for a valid run.
    pub warnings: Vec<String>,
    /// Whether the log marks a run as completed that is shorter than its settings.
    #[serde(skip)]
    pub is_inconsistent: bool,
    /// Comparison with a new simulation; null unless requested.
    pub verification: Option<VerificationReport>,
}

/// States of fingers and bodies in the last sample. The keys `final` and `discs` are always present, null where there
/// are no such states or no sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FinalStates(pub Option<States>);

impl Serialize for FinalStates {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut entries = self.0.as_ref().map(States::entries).unwrap_or_default();
        let has_key = |entries: &[(&str, _)], key: &str| entries.iter().any(|(known, _)| *known == key);
        if !has_key(&entries, "final") {
            entries.insert(0, ("final", None));
        }
        if !has_key(&entries, "discs") {
            entries.push(("discs", None));
        }
        serializer.collect_map(entries)
    }
}

/// A lost part of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LossReport {
    pub at_byte: u64,
    #[serde(rename = "what")]
    pub description: String,
    /// Intact messages after the damage, which were not used.
    #[serde(rename = "readable_behind")]
    pub readable_messages: u64,
}

/// A missing or incomplete topic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissingTopicReport {
    pub topic: String,
    /// Description of the defect, which follows the name of the topic.
    #[serde(rename = "what")]
    pub defect: String,
    /// Whether class and criteria are omitted because of it.
    pub withholds_criteria: bool,
}

impl From<&MissingData> for MissingTopicReport {
    fn from(missing: &MissingData) -> Self {
        let MissingData { topic, defect, is_required_for_verdict, .. } = missing;
        MissingTopicReport {
            topic: topic.clone(),
            defect: defect.clone(),
            withholds_criteria: *is_required_for_verdict,
        }
    }
}

impl From<&Loss> for LossReport {
    fn from(loss: &Loss) -> Self {
        let (at_byte, readable_messages) = match loss {
            Loss::Truncated { at_byte, .. } | Loss::Scene { at_byte, .. } => (*at_byte, 0),
            Loss::Damaged { at_byte, intact, .. } | Loss::UnsupportedCompression { at_byte, intact, .. } => {
                (*at_byte, intact.messages)
            }
        };
        LossReport { at_byte, description: loss.to_string(), readable_messages }
    }
}

impl ReplayReport {
    /// Creates the report of a log. `criteria` are those of a completed run of a finger. `scene` contains the motion of
    /// discs, which is not in the log itself.
    pub fn new(
        log: String,
        reading: &LogSummary,
        summary: &Summary,
        criteria: Option<Criteria>,
        grasp: Option<&GraspCriteria>,
        scene: Option<&Scene>,
    ) -> Self {
        let (layout, outcome) = (&summary.layout, summary.outcome());
        let grasp = grasp.zip(outcome).map(|(criteria, outcome)| GraspReport::new(criteria, scene, &outcome.last));
        // The run of a gripper ends when the object is ejected. Without its fate, an early end is not an error.
        let may_end_early = reading.kind() == SceneKind::Gripper
            && grasp.as_ref().is_none_or(|grasp| matches!(grasp.criteria.fate, Fate::Ejected { .. }));
        let mut report = ReplayReport {
            states: FinalStates(outcome.map(|outcome| states(layout, outcome, scene))),
            contacts: outcome.map(|outcome| contacts(layout, outcome, summary, reading)),
            criteria,
            grasp,
            energy: outcome.map(|outcome| outcome.last.energy).filter(|energy| !energy.kinetic_j.is_nan()),
            ..ReplayReport::from_log_only(log, reading)
        };
        if let Some(time_s) = ends_early(reading).filter(|_| !may_end_early) {
            let requested = report.duration_s.map_or("an unknown time".to_string(), format_duration);
            let reason =
                format!("the log marks its run as completed, but {requested} were requested: the log is inconsistent");
            (report.completed, report.error, report.is_inconsistent) =
                (Some(false), Some(Failure { time_s, reason }), true);
            (report.criteria, report.grasp) = (None, None);
        }
        report
    }

    /// Returns error messages about missing topics and inconsistencies.
    pub fn error_messages(&self) -> Vec<String> {
        let withheld_results = self.withheld_results();
        let mut lines: Vec<String> = self
            .missing
            .iter()
            .map(|MissingTopicReport { topic, defect, withholds_criteria }| {
                let withheld_results = withheld_results
                    .filter(|_| *withholds_criteria)
                    .map_or(String::new(), |results| format!("; {results}"));
                format!("error: {}: missing data: {topic} {defect}{withheld_results}", self.log)
            })
            .collect();
        let inconsistency = self.error.as_ref().filter(|_| self.is_inconsistent);
        lines.extend(inconsistency.map(|error| format!("error: {}: {}", self.log, error.reason)));
        lines
    }

    /// Describes the results that are omitted because a topic is missing.
    pub(super) fn withheld_results(&self) -> Option<&'static str> {
        let withholds = self.missing.iter().any(|missing| missing.withholds_criteria);
        let kind = self.kind.as_deref().filter(|_| withholds)?;
        (kind != SceneKind::Bodies.keyword()).then_some("class and criteria are omitted")
    }

    /// Whether the scene has fingers or a grasped object, rather than discs only.
    pub(super) fn has_joints(&self) -> bool {
        self.kind.as_deref() != Some(SceneKind::Bodies.keyword())
    }

    /// Returns the part of the report that does not depend on the samples.
    fn from_log_only(log: String, reading: &LogSummary) -> Self {
        let entry = |key: &str| reading.metadata.get(key).cloned();
        let number = |key: &str| entry(key).and_then(|text| text.parse().ok());
        let failure = reading.run_end.as_ref().and_then(|ended| Some((ended.time_s, ended.stopped.clone()?)));
        let (integrator, engine) = match settings(&reading.metadata).map(|settings| settings.solver) {
            Ok(Solver::Analytic(integrator)) => (Some(EffectiveSettings(integrator)), None),
            Ok(Solver::Engine(engine)) => (None, Some(EffectiveSettings(engine))),
            Err(_) => (None, None),
        };
        ReplayReport {
            log,
            page: None,
            csv: None,
            bytes: reading.bytes,
            is_complete: reading.is_complete(),
            losses: reading.losses.iter().map(LossReport::from).collect(),
            missing: reading.missing.iter().map(MissingTopicReport::from).collect(),
            scene: entry("scene"),
            kind: entry("kind"),
            model: entry("model"),
            phalanx_version: entry("phalanx_version"),
            duration_s: number("duration_s"),
            log_numeric_hz: number("log_numeric_hz"),
            integrator,
            engine,
            settings: reading.metadata.clone(),
            recovered: reading.recovered.clone(),
            completed: reading.run_end.as_ref().map(|ended| ended.stopped.is_none()),
            error: failure.map(|(time_s, reason)| Failure { time_s, reason }),
            first_s: reading.first_s,
            end_s: reading.last_s,
            samples: reading.samples,
            events: reading.events,
            messages: reading.messages,
            unknown_messages: reading.unknown_messages,
            unknown_channels: reading.unknown_channels,
            states: FinalStates::default(),
            contacts: None,
            criteria: None,
            grasp: None,
            energy: None,
            warnings: Vec::new(),
            is_inconsistent: false,
            verification: None,
        }
    }
}

/// Returns the states of fingers and bodies that the last sample contains.
fn states(layout: &Layout, outcome: &Outcome, scene: Option<&Scene>) -> States {
    let mut states = States::new(layout, Some(outcome), scene);
    states.fingers.0.retain(|(_, finger)| !finger.q11_rad.is_nan());
    states.bodies.0.retain(|(_, body)| !body.x_m.is_nan());
    states
}

/// Returns the contacts without missing topics.
fn contacts(layout: &Layout, outcome: &Outcome, summary: &Summary, reading: &LogSummary) -> Contacts {
    let mut contacts = Contacts::new(layout, outcome, summary.rebounds());
    for missing in &reading.missing {
        if let TopicSubject::Contact(index) = missing.subject
            && let Some(contact) = layout.contacts.get(index)
        {
            contacts.all.0.retain(|(name, _)| *name != contact.name);
        }
    }
    contacts
}

/// Returns the end time of a run that is marked as completed but ended before the requested time.
fn ends_early(reading: &LogSummary) -> Option<f64> {
    let ended = reading.run_end.as_ref().filter(|ended| ended.stopped.is_none())?;
    let duration_s: f64 = reading.metadata.get("duration_s")?.parse().ok()?;
    // Log times are whole nanoseconds.
    (duration_s - ended.time_s > 1e-9 + 1e-12 * ended.time_s).then_some(ended.time_s)
}
