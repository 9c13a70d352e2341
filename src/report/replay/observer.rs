//! Processes the messages of a log: summary, criteria and invariants of its run.

use super::document::ReplayReport;
use super::summary::Summary;
use crate::criteria::{LinkOverlap, RunCriteriaTracker, static_grasp};
use crate::invariants::EnergyAudit;
use crate::limits::MAX_SCENE_BYTES;
use crate::log::{LogSink, LogSummary, settings};
use crate::scene::keywords::SceneKind;
use crate::scene::{self, Scene, SceneError};
use crate::trace::{Event, Sample, Schema, Sink, SinkError};

/// A sink for the contents of a log that collects the data of its report.
#[derive(Debug, Default)]
pub struct LogObserver {
    summary: Summary,
    /// Criteria of a finger or a gripper.
    tracker: Option<RunCriteriaTracker>,
    /// The scene of the log, if this version can read it; it defines prescribed motions.
    scene: Option<Scene>,
    /// Check of the energy balance.
    audit: Option<EnergyAudit>,
}

impl LogObserver {
    /// Creates an observer from the head of the log, because the criteria need the scene before the first sample. Also
    /// returns a warning if there are no criteria.
    pub fn new(head: &LogSummary) -> (Self, Option<String>) {
        match scene_in_log(head) {
            None => (LogObserver::default(), None),
            Some(Ok(scene)) => {
                let is_finger = scene.kind() == SceneKind::Finger;
                let object = scene.object().filter(|_| is_finger);
                let ungraspable = object.and_then(|object| static_grasp(&scene, object).err());
                let warning = ungraspable
                    .map(|error| format!("no dynamic criteria, because the finger cannot grasp this object: {error}"));
                let tracker = (scene.kind() != SceneKind::Bodies).then(|| RunCriteriaTracker::for_scene(&scene));
                let audit = audit(head, &scene);
                (LogObserver { summary: Summary::default(), tracker, scene: Some(scene), audit }, warning)
            }
            Some(Err(error)) => {
                let missing = match head.kind() {
                    SceneKind::Finger => "no dynamic criteria",
                    SceneKind::Bodies => "the prescribed motion of the discs is unknown",
                    SceneKind::Gripper => "no grasp criteria",
                };
                let reason = "because this version of phalanx cannot read the scene in the log";
                (LogObserver::default(), Some(format!("{missing}, {reason}: {error}")))
            }
        }
    }

    /// Returns the summary of the run and the layout of its samples.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Creates the report of the log, after it was read.
    pub fn report(&mut self, name: String, reading: &LogSummary) -> ReplayReport {
        let found = self.tracker.take().map(|tracker| tracker.finish(is_complete_run(reading)));
        let overlaps = found.iter().flat_map(|found| &found.overlaps).map(LinkOverlap::sentence);
        let energy_violation = self.audit.and_then(|audit| audit.violation()).map(|violation| violation.to_string());
        let warnings = energy_violation.into_iter().chain(overlaps).collect();
        let (criteria, grasp) = found.map_or((None, None), |found| (found.criteria, found.grasp));
        let bodies_scene = self.scene.as_ref().filter(|scene| scene.kind() != SceneKind::Finger);
        ReplayReport::new(name, reading, &self.summary, criteria, grasp.as_ref(), bodies_scene, warnings)
    }
}

/// Whether the run was completed and its log contains all data for the criteria.
fn is_complete_run(reading: &LogSummary) -> bool {
    let is_completed = reading.run_end.as_ref().is_some_and(|ended| ended.stopped.is_none());
    is_completed && reading.supports_verdict()
}

/// Creates a check of the energy balance with the settings of the run.
fn audit(head: &LogSummary, scene: &Scene) -> Option<EnergyAudit> {
    let (settings, mut scene) = (settings(&head.metadata).ok()?, scene.clone());
    settings.apply_to(&mut scene);
    Some(EnergyAudit::new(settings.model(), &scene))
}

/// Returns the scene that is stored in a log; `None` if there is none or it exceeds the size limit of scenes.
pub fn scene_in_log(head: &LogSummary) -> Option<Result<Scene, SceneError>> {
    let (name, text) = head.scene.as_ref().filter(|(_, text)| text.len() as u64 <= MAX_SCENE_BYTES)?;
    Some(scene::parse_any(text, name))
}

impl LogSink for LogObserver {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        let scene = self.scene.as_ref().filter(|scene| scene.kind() != SceneKind::Finger);
        self.summary = Summary::new(schema.clone(), scene);
        // The kind of the scene can differ from the kind of the log.
        let finger_count = self.scene.as_ref().map_or(0, |scene| scene.system.fingers.len());
        self.tracker = self.tracker.take().filter(|_| schema.fingers.len() == finger_count);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.summary.sample(sample)?;
        // Samples have no energies if the energy topic is missing.
        self.audit = self.audit.filter(|_| !sample.energy().kinetic_j.is_nan());
        self.audit.sample(sample)?;
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.summary.event(event)?;
        self.tracker.event(event)
    }
}
