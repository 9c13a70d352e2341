//! What a log says of its run, in the order and under the keys of the JSON document.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use super::super::contacts::Contacts;
use super::super::document::{Failure, Used};
use super::super::grasp::GraspReport;
use super::super::states::States;
use super::summary::Summary;
use super::verify::VerificationReport;
use crate::criteria::{Criteria, Fate, GraspCriteria};
use crate::log::{Concerns, Loss, Missing, Reading, Solver, settings};
use crate::scene::words::SceneKind;
use crate::scene::{Engine, Integrator, Scene, Words};
use crate::trace::{Energy, Layout, Outcome};
use crate::wording::duration;

/// One log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayReport {
    /// Path of the log as given.
    pub log: String,
    /// Path of the page as given; null if none was asked for.
    pub page: Option<String>,
    /// Path of the table of samples as given; null if none was asked for.
    pub csv: Option<String>,
    pub bytes: u64,
    /// Whether nothing of it is lost.
    pub whole: bool,
    /// What is lost, one sentence each.
    pub losses: Vec<Lost>,
    /// Topics that the log of such a run has and this one has not, or not all of. Figures that need them are left out.
    pub missing: Vec<MissingReport>,
    /// Name of the scene; null where the log does not say.
    pub scene: Option<String>,
    /// `finger`, `bodies` or `gripper`; null where the log does not say.
    pub kind: Option<String>,
    pub model: Option<String>,
    /// Version of phalanx that wrote it.
    pub phalanx_version: Option<String>,
    /// Length that was asked for.
    pub duration_s: Option<f64>,
    /// Samples on the grid, per second.
    pub log_numeric_hz: Option<f64>,
    /// Settings of the model that ran, as in the run's own report; null for the other, and where they cannot be read.
    pub integrator: Option<Used<Integrator>>,
    pub engine: Option<Used<Engine>>,
    /// Everything that the log records of itself, as it stands there: versions, model, settings in SI.
    pub settings: BTreeMap<String, String>,
    /// What a log recovered from a damaged one says of that; null for any other.
    pub recovered: Option<BTreeMap<String, String>>,
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
    #[serde(flatten)]
    pub states: Last,
    /// Peaks are those of the samples, among which the run's own are.
    pub contacts: Option<Contacts>,
    /// Null without an object or a scene, if the log does not reach the end of a completed run, or if a topic that it needs is missing.
    pub criteria: Option<Criteria>,
    /// Of a log of a gripper; left out under the same conditions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<GraspReport>,
    pub energy: Option<Energy>,
    /// Sentences on what makes the results doubtful; empty for a sound run.
    pub warnings: Vec<String>,
    /// Whether the log calls a run completed that is shorter than its settings.
    #[serde(skip)]
    pub contradicts_itself: bool,
    /// Whether simulating again gives the same; null unless that was asked for.
    pub verification: Option<VerificationReport>,
}

/// What moved, as it is in the last sample; `final` and `discs` are keys of every log, null where it has none or no sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Last(pub Option<States>);

impl Serialize for Last {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut entries = self.0.as_ref().map(States::entries).unwrap_or_default();
        let has = |entries: &[(&str, _)], key: &str| entries.iter().any(|(known, _)| *known == key);
        if !has(&entries, "final") {
            entries.insert(0, ("final", None));
        }
        if !has(&entries, "discs") {
            entries.push(("discs", None));
        }
        serializer.collect_map(entries)
    }
}

/// Something that is lost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lost {
    pub at_byte: u64,
    pub what: String,
    /// Messages behind the damage that are whole but were not used.
    pub readable_behind: u64,
}

/// A topic that is missing, or a part of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissingReport {
    pub topic: String,
    /// In words that follow the topic.
    pub what: String,
    /// Whether no class, and nothing of a grasp, is told because of it.
    pub withholds_criteria: bool,
}

impl From<&Missing> for MissingReport {
    fn from(missing: &Missing) -> Self {
        let Missing { topic, what, is_judged_by, .. } = missing;
        MissingReport { topic: topic.clone(), what: what.clone(), withholds_criteria: *is_judged_by }
    }
}

impl From<&Loss> for Lost {
    fn from(loss: &Loss) -> Self {
        let (at_byte, readable_behind) = match loss {
            Loss::Truncated { at_byte, .. } | Loss::Scene { at_byte, .. } => (*at_byte, 0),
            Loss::Damaged { at_byte, behind, .. } | Loss::Compressed { at_byte, behind, .. } => {
                (*at_byte, behind.messages)
            }
        };
        Lost { at_byte, what: loss.to_string(), readable_behind }
    }
}

impl ReplayReport {
    /// What was read, in sum. `criteria` are those of the whole run of a finger; how discs are moved is in the `scene` alone.
    pub fn new(
        log: String,
        reading: &Reading,
        summary: &Summary,
        criteria: Option<Criteria>,
        grasp: Option<&GraspCriteria>,
        scene: Option<&Scene>,
    ) -> Self {
        let (layout, outcome) = (&summary.layout, summary.outcome());
        let grasp = grasp.zip(outcome).map(|(found, of)| GraspReport::new(found, scene, &of.last));
        // Of a gripper an ejection ends the run; without its fate nothing is known of that.
        let may_end_early =
            reading.kind() == SceneKind::Gripper && grasp.as_ref().is_none_or(|grasp| grasp.fate == Fate::NAMES[2]);
        let mut report = ReplayReport {
            states: Last(outcome.map(|outcome| states(layout, outcome, scene))),
            contacts: outcome.map(|outcome| contacts(layout, outcome, summary, reading)),
            criteria,
            grasp,
            energy: outcome.map(|outcome| outcome.last.energy).filter(|energy| !energy.kinetic_j.is_nan()),
            ..ReplayReport::of_log(log, reading)
        };
        if let Some(time_s) = ends_early(reading).filter(|_| !may_end_early) {
            let of = report.duration_s.map_or("an unknown time".to_string(), duration);
            let reason = format!("the log calls its run completed, but {of} were requested: it contradicts itself");
            (report.completed, report.error, report.contradicts_itself) =
                (Some(false), Some(Failure { time_s, reason }), true);
            (report.criteria, report.grasp) = (None, None);
        }
        report
    }

    /// What to print on stderr of what the log lacks, or contradicts.
    pub fn complaints(&self) -> Vec<String> {
        let withheld = self.withheld();
        let mut lines: Vec<String> = self
            .missing
            .iter()
            .map(|MissingReport { topic, what, withholds_criteria }| {
                let withheld =
                    withheld.filter(|_| *withholds_criteria).map_or(String::new(), |words| format!("; {words}"));
                format!("error: {}: missing topic: {topic} {what}{withheld}", self.log)
            })
            .collect();
        let reason = self.error.as_ref().filter(|_| self.contradicts_itself);
        lines.extend(reason.map(|error| format!("error: {}: {}", self.log, error.reason)));
        lines
    }

    /// What is not said because a topic is missing.
    pub(super) fn withheld(&self) -> Option<&'static str> {
        let withholds = self.missing.iter().any(|missing| missing.withholds_criteria);
        let kind = self.kind.as_deref().filter(|_| withholds)?;
        (kind != SceneKind::Bodies.word()).then_some("no class and no criterion is given")
    }

    /// Whether the scene has joints to speak of.
    pub(super) fn has_joints(&self) -> bool {
        self.kind.as_deref() != Some(SceneKind::Bodies.word())
    }

    /// What is said of any log.
    fn of_log(log: String, reading: &Reading) -> Self {
        let entry = |key: &str| reading.metadata.get(key).cloned();
        let number = |key: &str| entry(key).and_then(|text| text.parse().ok());
        let stopped = reading.ended.as_ref().and_then(|ended| Some((ended.time_s, ended.stopped.clone()?)));
        let (integrator, engine) = match settings(&reading.metadata).map(|settings| settings.solver) {
            Ok(Solver::Analytic(integrator)) => (Some(Used(integrator)), None),
            Ok(Solver::Engine(engine)) => (None, Some(Used(engine))),
            Err(_) => (None, None),
        };
        ReplayReport {
            log,
            page: None,
            csv: None,
            bytes: reading.bytes,
            whole: reading.is_whole(),
            losses: reading.losses.iter().map(Lost::from).collect(),
            missing: reading.missing.iter().map(MissingReport::from).collect(),
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
            completed: reading.ended.as_ref().map(|ended| ended.stopped.is_none()),
            error: stopped.map(|(time_s, reason)| Failure { time_s, reason }),
            first_s: reading.first_s,
            end_s: reading.last_s,
            samples: reading.samples,
            events: reading.events,
            messages: reading.messages,
            unknown_messages: reading.unknown_messages,
            unknown_channels: reading.unknown_channels,
            states: Last::default(),
            contacts: None,
            criteria: None,
            grasp: None,
            energy: None,
            warnings: Vec::new(),
            contradicts_itself: false,
            verification: None,
        }
    }
}

/// What moves, as far as the last sample has it.
fn states(layout: &Layout, outcome: &Outcome, scene: Option<&Scene>) -> States {
    let mut states = States::new(layout, Some(outcome), scene);
    states.fingers.0.retain(|(_, finger)| !finger.q11_rad.is_nan());
    states.bodies.0.retain(|(_, body)| !body.x_m.is_nan());
    states
}

/// The contacts of which no topic is missing.
fn contacts(layout: &Layout, outcome: &Outcome, summary: &Summary, reading: &Reading) -> Contacts {
    let mut contacts = Contacts::new(layout, outcome, summary.rebounds());
    for missing in &reading.missing {
        if let Concerns::Contact(index) = missing.concerns
            && let Some(place) = layout.contacts.get(index)
        {
            contacts.all.0.retain(|(name, _)| *name != place.name);
        }
    }
    contacts
}

/// When a run ended that is called completed, if that is before the time that was requested.
fn ends_early(reading: &Reading) -> Option<f64> {
    let ended = reading.ended.as_ref().filter(|ended| ended.stopped.is_none())?;
    let duration_s: f64 = reading.metadata.get("duration_s")?.parse().ok()?;
    // Log times are whole nanoseconds.
    (duration_s - ended.time_s > 1e-9 + 1e-12 * ended.time_s).then_some(ended.time_s)
}
