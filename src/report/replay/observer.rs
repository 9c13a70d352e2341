//! Processes the messages of a log: summary, criteria and invariants of its run.

use super::ReplayReport;
use crate::criteria::{LinkOverlap, Rebound, Rebounds, RunCriteriaTracker, static_grasp};
use crate::invariants::EnergyAudit;
use crate::limits::MAX_SCENE_BYTES;
use crate::log::{LogSink, LogSummary, Settings, settings};
use crate::scene::{self, Scene, SceneError};
use crate::trace::{ContactSummary, Event, EventKind, OffGrid, Outcome, Sample, Schema, Sink, SinkError};

/// A sink that receives the contents of a log and collects the data of the report.
#[derive(Debug, Default)]
pub struct LogObserver {
    pub(super) schema: Schema,
    outcome: Outcome,
    /// Rebounds of the pairs of bodies.
    rebounds: Option<Rebounds>,
    has_sample: bool,
    /// Criteria of a finger or a gripper.
    tracker: Option<OffGrid<RunCriteriaTracker>>,
    /// The scene of the log, if this version can read it; it defines prescribed motions.
    scene: Option<Scene>,
    /// Check of the energy balance.
    audit: Option<OffGrid<EnergyAudit>>,
}

impl LogObserver {
    /// Creates an observer from the head of the log, because the criteria need the scene before the first sample. Also
    /// returns a warning if the finger cannot grasp its object. A scene that cannot be read counts as a loss of the
    /// log.
    pub fn new(head: &LogSummary) -> (Self, Option<String>) {
        match scene_in_log(head) {
            None | Some(Err(_)) => (LogObserver::default(), None),
            Some(Ok(scene)) => {
                let is_finger = scene.finger_count() == 1;
                let object = scene.object().filter(|_| is_finger);
                let ungraspable = object.and_then(|object| static_grasp(&scene, object).err());
                let warning = ungraspable
                    .map(|error| format!("no dynamic criteria, because the finger cannot grasp this object: {error}"));
                let settings = settings(&head.metadata).ok();
                // Logs of other versions have few samples off the grid, so that all are evaluated.
                let numeric_hz = settings.as_ref().map_or(f64::INFINITY, |settings| settings.log.numeric_hz);
                let tracker = Some(OffGrid::new(numeric_hz, RunCriteriaTracker::for_scene(&scene)));
                let audit = settings.map(|settings| OffGrid::new(numeric_hz, audit(&settings, &scene)));
                (LogObserver { tracker, scene: Some(scene), audit, ..LogObserver::default() }, warning)
            }
        }
    }

    /// Returns the outcome of the run; `None` without samples. The computational cost is missing, because samples do
    /// not contain it.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.has_sample.then_some(&self.outcome)
    }

    /// Returns the rebounds of the pairs of bodies; empty for scenes with fingers.
    pub(super) fn rebounds(&self) -> &[Rebound] {
        self.rebounds.as_ref().map_or(&[], Rebounds::pairs)
    }

    /// The scene, except for a finger: it contains the motion of discs, which is not in the log itself.
    pub(super) fn bodies_scene(&self) -> Option<&Scene> {
        self.scene.as_ref().filter(|scene| scene.finger_count() != 1)
    }

    /// Creates the report of the log after the log has been read.
    pub fn report(&mut self, name: String, reading: &LogSummary) -> ReplayReport {
        // Criteria and audit return no errors.
        let _ = (self.tracker.as_mut().map(OffGrid::end), self.audit.as_mut().map(OffGrid::end));
        let found = self.tracker.take().map(|tracker| tracker.sink.finish(is_complete_run(reading)));
        let overlaps = found.iter().flat_map(|found| &found.overlaps).map(LinkOverlap::sentence);
        let violation = self.audit.as_ref().and_then(|audit| audit.sink.violation());
        let energy_violation = violation.map(|violation| violation.to_string());
        let warnings = energy_violation.into_iter().chain(overlaps).collect();
        ReplayReport::new(name, reading, self, found, warnings)
    }
}

/// Whether the run was completed and its log contains all data for the criteria.
fn is_complete_run(reading: &LogSummary) -> bool {
    let is_completed = reading.run_end.as_ref().is_some_and(|ended| ended.stopped.is_none());
    is_completed && reading.supports_verdict()
}

/// Creates a check of the energy balance with the settings of the run.
fn audit(settings: &Settings, scene: &Scene) -> EnergyAudit {
    let mut scene = scene.clone();
    settings.apply_to(&mut scene);
    EnergyAudit::new(settings.model(), &scene)
}

/// Returns the scene that is stored in a log. `None` if there is none, or if it exceeds the size limit of scenes.
pub fn scene_in_log(head: &LogSummary) -> Option<Result<Scene, SceneError>> {
    let (name, text) = head.scene.as_ref().filter(|(_, text)| text.len() as u64 <= MAX_SCENE_BYTES)?;
    Some(scene::parse_any(text, name))
}

impl LogSink for LogObserver {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        let count = schema.contacts.len();
        // Contacts have other indices in another scene.
        if self.scene.as_ref().is_some_and(|scene| !schema.has_subjects_of(scene)) {
            *self = LogObserver::default();
        }
        // The scene provides the masses for the rebounds.
        let of_scene = self.scene.as_ref().and_then(|scene| scene.mechanism.as_ref()).and_then(Rebounds::for_mechanism);
        let of_scene = of_scene.filter(|found| found.pairs().len() == count);
        let is_unknown = self.scene.is_none() && schema.is_mechanism() && schema.joints.is_empty();
        self.rebounds = of_scene.or_else(|| is_unknown.then(|| Rebounds::new(count)));
        self.schema = schema.clone();
        self.outcome = Outcome { contacts: vec![ContactSummary::default(); count], ..Outcome::default() };
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.has_sample = true;
        self.outcome.last.clone_from(sample);
        for (summary, contact) in self.outcome.contacts.iter_mut().zip(sample.contacts()) {
            summary.update(contact.force_and_penetration());
            summary.impulse_n_s = contact.impulse_n_s;
        }
        self.rebounds.sample(sample)?;
        // Samples have no energies if the energy topic is missing.
        self.audit = self.audit.take().filter(|_| !sample.energy().kinetic_j.is_nan());
        self.audit.sample(sample)?;
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let contact = &mut self.outcome.contacts[event.contact];
        if event.kind == EventKind::TouchDown {
            contact.first_s.get_or_insert(event.time_s);
            contact.touchdowns = contact.touchdowns.saturating_add(1);
        }
        contact.slips = contact.slips.saturating_add(u32::from(event.kind == EventKind::Slips));
        self.rebounds.event(event)?;
        self.audit.event(event)?;
        self.tracker.event(event)
    }
}
