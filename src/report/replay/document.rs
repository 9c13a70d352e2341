//! Report of a log: JSON and text.

use std::fmt::Write;

use serde::{Serialize, Serializer};

use super::super::contacts::Contacts;
use super::super::document::{EffectiveSettings, Failure};
use super::super::grasp::GraspReport;
use super::super::states::States;
use super::super::tables::{contacts, criteria_table, energies, grasp, states};
use super::super::text::{engine, integrator};
use super::summary::Summary;
use super::verify::VerificationReport;
use crate::criteria::{Criteria, Fate, GraspCriteria};
use crate::format::{Report, ToReport, format_duration};
use crate::log::{LogSummary, Solver, settings};
use crate::scene::keywords::SceneKind;
use crate::scene::{Engine, Integrator, Keyword, Scene};
use crate::trace::Energy;

/// Report of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayReport {
    /// Path of the log as given.
    pub log: String,
    /// Path of the page as given; null if none was requested.
    pub page: Option<String>,
    /// Path of the table of samples as given; null if none was requested.
    pub csv: Option<String>,
    /// Contents, lost and missing parts.
    #[serde(flatten)]
    pub reading: LogSummary,
    /// Whether no part of the log is lost.
    #[serde(rename = "whole")]
    pub is_complete: bool,
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
    /// Whether the run was completed; null if the log does not contain the end of the run.
    pub completed: Option<bool>,
    /// Reason why the run was not completed.
    pub error: Option<Failure>,
    #[serde(flatten)]
    pub states: FinalStates,
    /// Contacts without missing topics. Peaks are taken from the samples, which include the peaks of the run.
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
        for key in ["final", "discs"] {
            if !entries.iter().any(|(known, _)| *known == key) {
                entries.push((key, None));
            }
        }
        serializer.collect_map(entries)
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
        warnings: Vec<String>,
    ) -> Self {
        let (layout, outcome) = (&summary.layout, summary.outcome());
        let entry = |key: &str| reading.metadata.get(key).cloned();
        let number = |key: &str| entry(key).and_then(|text| text.parse().ok());
        let (integrator, engine) = match settings(&reading.metadata).map(|settings| settings.solver) {
            Ok(Solver::Analytic(integrator)) => (Some(EffectiveSettings(integrator)), None),
            Ok(Solver::Engine(engine)) => (None, Some(EffectiveSettings(engine))),
            Err(_) => (None, None),
        };
        let ended = reading.run_end.as_ref();
        let failure = ended.and_then(|ended| Some((ended.time_s, ended.stopped.clone()?)));
        let states = outcome.map(|outcome| {
            let mut states = States::new(layout, Some(outcome), scene);
            states.fingers.0.retain(|(_, finger)| !finger.q11_rad.is_nan());
            states.bodies.0.retain(|(_, body)| !body.state.centre_m[0].is_nan());
            states
        });
        let contacts = outcome.map(|outcome| {
            let mut contacts = Contacts::new(layout, outcome, summary.rebounds());
            let incomplete =
                reading.missing.iter().filter_map(|missing| layout.contacts.get(missing.content.contact()?));
            for contact in incomplete {
                contacts.all.0.retain(|(name, _)| *name != contact.name);
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
            model: entry("model"),
            phalanx_version: entry("phalanx_version"),
            duration_s: number("duration_s"),
            log_numeric_hz: number("log_numeric_hz"),
            integrator,
            engine,
            completed: ended.map(|ended| ended.stopped.is_none()),
            error: failure.map(|(time_s, reason)| Failure { time_s, reason }),
            states: FinalStates(states),
            contacts,
            criteria,
            grasp: grasp.zip(outcome).map(|(criteria, outcome)| GraspReport::new(criteria, scene, &outcome.last)),
            energy: outcome.map(|outcome| outcome.last.energy()).filter(|energy| !energy.kinetic_j.is_nan()),
            warnings,
            is_inconsistent: false,
            verification: None,
            reading: reading.clone(),
        };
        // The run of a gripper ends when the object is ejected. Without its fate, an early end is not an error.
        let may_end_early = reading.kind() == SceneKind::Gripper
            && report.grasp.as_ref().is_none_or(|grasp| matches!(grasp.criteria.fate, Fate::Ejected { .. }));
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
        (withholds && self.kind.is_some() && self.has_joints()).then_some("class and criteria are omitted")
    }

    /// Whether the scene has fingers or a grasped object, rather than discs only.
    fn has_joints(&self) -> bool {
        self.kind.as_deref() != Some(SceneKind::Bodies.keyword())
    }

    fn heading(&self) -> String {
        let or_unknown = |entry: &Option<String>| entry.clone().unwrap_or_else(|| "unknown".to_string());
        let requested = self.duration_s.map_or("an unknown time".to_string(), format_duration);
        let of_engine = || self.engine.as_ref().map(|used| engine(used, self.has_joints()));
        let settings = self.integrator.as_ref().map(integrator).or_else(of_engine).unwrap_or_default();
        let (scene, model) = (or_unknown(&self.scene), or_unknown(&self.model));
        let mut text = format!("{scene}: {model} model{settings}\nread from {}\n", self.log);
        text += &match (&self.error, self.completed, self.reading.last_s.map(format_duration)) {
            (Some(Failure { time_s, reason }), ..) => {
                format!("NOT COMPLETED: stopped at {} of {requested}: {reason}\n", format_duration(*time_s))
            }
            (None, Some(_), _) => format!("completed, {requested}\n"),
            (None, None, Some(end)) => format!("NOT COMPLETE: the log reaches {end} of {requested}\n"),
            (None, None, None) => format!("NOT COMPLETE: the log contains no sample of the {requested} run\n"),
        };
        let LogSummary { samples, events, unknown_messages, .. } = self.reading;
        let plural = |count: u64| if count == 1 { "" } else { "s" };
        text += &format!("{samples} sample{}, {events} event{}", plural(samples), plural(events));
        if unknown_messages > 0 {
            text += &format!(", {unknown_messages} messages of channels unknown to this version of phalanx");
        }
        text.push('\n');
        let mut line = |head: &str, content: &str| text += &format!("{head}: {content}\n");
        self.csv.iter().for_each(|csv| line("samples", csv));
        self.page.iter().for_each(|page| line("page", page));
        self.reading.losses.iter().for_each(|loss| line("LOST", &loss.description));
        for missing in &self.reading.missing {
            line("MISSING", &format!("{} {}", missing.topic, missing.defect));
        }
        if let Some(withheld_results) = self.withheld_results() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{withheld_results}, because they depend on missing data");
        }
        let mut line = |head: &str, content: &str| text += &format!("{head}: {content}\n");
        self.warnings.iter().for_each(|warning| line("Warning", warning));
        text
    }
}

impl ToReport for ReplayReport {
    fn report(&self) -> Report {
        let mut sections = vec![Report::from(self.heading())];
        let last = self.states.0.as_ref().zip(self.reading.last_s);
        sections.extend(last.into_iter().flat_map(|(last, end_s)| states(last, end_s)));
        sections.extend(self.contacts.as_ref().and_then(contacts));
        sections.extend(self.energy.as_ref().map(|energy| energies(energy, self.has_joints())));
        sections.extend(self.criteria.as_ref().map(criteria_table));
        sections.extend(self.grasp.as_ref().map(grasp));
        sections.extend(self.verification.as_ref().map(VerificationReport::section));
        Report::join(sections)
    }
}

/// Returns the end time of a run that is marked as completed but ended before the requested time.
fn ends_early(reading: &LogSummary, duration_s: Option<f64>) -> Option<f64> {
    let ended = reading.run_end.as_ref().filter(|ended| ended.stopped.is_none())?;
    // Log times are whole nanoseconds.
    (duration_s? - ended.time_s > 1e-9 + 1e-12 * ended.time_s).then_some(ended.time_s)
}
