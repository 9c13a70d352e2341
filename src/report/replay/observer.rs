//! Processes the messages of a log: summary, criteria and invariants of its run.

use super::document::ReplayReport;
use super::summary::Summary;
use crate::criteria::{Criteria, GraspCriteria, GraspTracker, LinkOverlaps, StaticGrasp, Tracker, static_grasp};
use crate::invariants::EnergyAudit;
use crate::limits::MAX_SCENE_BYTES;
use crate::log::{LogSink, LogSummary, Solver, settings};
use crate::scene::keywords::SceneKind;
use crate::scene::{self, Scene, SceneError};
use crate::trace::{Event, Layout, Model, Sample, Sink, SinkError};

/// A sink for the messages of a log that collects the data of its report.
#[derive(Debug, Default)]
pub struct LogObserver {
    summary: Summary,
    grasp: Option<StaticGrasp>,
    tracker: Option<Tracker>,
    /// Criteria of a gripper.
    gripper: Option<GraspTracker>,
    /// The scene of a log of bodies or of a gripper, if this version can read it; it defines prescribed motions.
    bodies_scene: Option<Scene>,
    /// Check of the energy balance.
    audit: Option<EnergyAudit>,
    /// Links of a gripper that overlap bodies without a contact.
    overlaps: Option<LinkOverlaps>,
}

impl LogObserver {
    /// Creates an observer from the head of the log, because the criteria need the scene before the first sample. Also
    /// returns a warning if there are no criteria.
    pub fn new(head: &LogSummary) -> (Self, Option<String>) {
        let mut observer = LogObserver::default();
        let mut warning = None;
        let scene = scene_in_log(head);
        if let Some(Ok(scene)) = &scene {
            observer.audit = audit(head, scene);
            observer.overlaps = LinkOverlaps::for_scene(scene);
        }
        match scene {
            Some(Ok(scene)) if scene.kind() == SceneKind::Finger => {
                let found = scene.object().map(|object| static_grasp(&scene, object)).transpose();
                observer.grasp = found.unwrap_or_else(|error| {
                    warning =
                        Some(format!("no dynamic criteria, because the finger cannot grasp this object: {error}"));
                    None
                });
                observer.tracker = observer.grasp.as_ref().map(|grasp| Tracker::new(grasp.final_angles()));
            }
            Some(Ok(scene)) => {
                observer.gripper = (scene.kind() == SceneKind::Gripper).then(|| GraspTracker::for_scene(&scene));
                observer.bodies_scene = Some(scene);
            }
            Some(Err(error)) => {
                let missing = match head.kind() {
                    SceneKind::Finger => "no dynamic criteria",
                    SceneKind::Bodies => "the prescribed motion of the discs is unknown",
                    SceneKind::Gripper => "no grasp criteria",
                };
                warning = Some(format!(
                    "{missing}, because this version of phalanx cannot read the scene in the log: {error}"
                ));
            }
            None => {}
        }
        (observer, warning)
    }

    /// Returns the summary of the run and the layout of its samples.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Creates the report of the log.
    pub fn report(&self, name: String, reading: &LogSummary) -> ReplayReport {
        let (criteria, grasp) = (self.criteria(reading), self.grasp(reading));
        let report =
            ReplayReport::new(name, reading, &self.summary, criteria, grasp.as_ref(), self.bodies_scene.as_ref());
        ReplayReport { warnings: self.warnings(), ..report }
    }

    /// Returns reasons to doubt the results.
    fn warnings(&self) -> Vec<String> {
        let energy_violation =
            self.audit.and_then(|audit| audit.violation()).map(|energy_violation| energy_violation.to_string());
        let overlaps = self.overlaps.iter().flat_map(LinkOverlaps::overlaps);
        energy_violation.into_iter().chain(overlaps.map(|overlap| overlap.sentence())).collect()
    }

    /// Returns the criteria of the grasp of a gripper, if the run was completed and no required data is missing.
    fn grasp(&self, reading: &LogSummary) -> Option<GraspCriteria> {
        self.gripper.as_ref().filter(|_| is_complete_run(reading))?.criteria()
    }

    /// Returns the criteria of a finger, if the run was completed and no required data is missing.
    fn criteria(&self, reading: &LogSummary) -> Option<Criteria> {
        let criteria_tracker = self.tracker.as_ref().zip(self.grasp.as_ref()).filter(|_| is_complete_run(reading));
        criteria_tracker.and_then(|(tracker, grasp)| tracker.criteria(grasp.static_forces_n()))
    }
}

/// Whether the run was completed and its log contains all data for the criteria.
fn is_complete_run(reading: &LogSummary) -> bool {
    let is_completed = reading.run_end.as_ref().is_some_and(|ended| ended.stopped.is_none());
    is_completed && reading.supports_verdict() && reading.recovered.is_none()
}

/// Creates a check of the energy balance with the settings of the run.
fn audit(head: &LogSummary, scene: &Scene) -> Option<EnergyAudit> {
    let mut scene_with_settings = scene.clone();
    let model = match settings(&head.metadata).ok()?.solver {
        Solver::Analytic(integrator) => {
            scene_with_settings.integrator = integrator;
            Model::Analytic
        }
        Solver::Engine(engine) => {
            scene_with_settings.engine = engine;
            Model::Engine
        }
    };
    Some(EnergyAudit::new(model, &scene_with_settings))
}

/// Returns the scene that is stored in a log; `None` if there is none or it exceeds the size limit of scenes.
pub fn scene_in_log(head: &LogSummary) -> Option<Result<Scene, SceneError>> {
    let (name, text) = head.scene.as_ref().filter(|(_, text)| text.len() as u64 <= MAX_SCENE_BYTES)?;
    Some(scene::parse_any(text, name))
}

impl LogSink for LogObserver {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.summary = Summary::new(layout.clone(), self.bodies_scene.as_ref());
        // The kind of the scene can differ from the kind of the log.
        self.tracker = self.tracker.take().filter(|_| layout.fingers.len() == 1);
        self.gripper = self.gripper.take().filter(|_| layout.fingers.len() == 2);
        self.overlaps = self.overlaps.take().filter(|_| layout.fingers.len() == 2);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.summary.sample(sample)?;
        self.gripper.sample(sample)?;
        self.overlaps.sample(sample)?;
        // Samples have no energies if the energy topic is missing.
        self.audit = self.audit.filter(|_| !sample.energy.kinetic_j.is_nan());
        self.audit.sample(sample)?;
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.summary.event(event)?;
        self.gripper.event(event)?;
        self.tracker.event(event)
    }
}
