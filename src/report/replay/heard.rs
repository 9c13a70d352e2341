//! Everything that listens to a log: the summary, and what its run is judged by.

use super::document::ReplayReport;
use super::summary::Summary;
use crate::criteria::{AtRest, Criteria, GraspCriteria, GraspTracker, LinkOverlaps, Tracker, at_rest};
use crate::invariants::EnergyAudit;
use crate::limits::LARGEST_SCENE_BYTES;
use crate::log::{LogSink, Reading, Solver, settings};
use crate::scene::words::SceneKind;
use crate::scene::{self, Scene, SceneError};
use crate::trace::{Event, Layout, Model, Sample, Sink, SinkError};

/// Everything that listens to a log.
#[derive(Debug, Default)]
pub struct Heard {
    summary: Summary,
    grasp: Option<AtRest>,
    tracker: Option<Tracker>,
    /// Of a gripper.
    gripper: Option<GraspTracker>,
    /// The scene of a log of bodies, if there is one that this phalanx reads: how they are moved.
    moved: Option<Scene>,
    /// Energies that are missing or created, and links of a gripper that overlap what they have no contact with.
    audit: Option<EnergyAudit>,
    overlaps: Option<LinkOverlaps>,
}

impl Heard {
    /// By the head of the log, for the criteria need its scene before the first sample; and what is to be said if there are none.
    pub fn new(head: &Reading) -> (Self, Option<String>) {
        let mut heard = Heard::default();
        let mut said = None;
        let scene = attached(head);
        if let Some(Ok(scene)) = &scene {
            heard.audit = audit(head, scene);
            heard.overlaps = LinkOverlaps::of(scene);
        }
        match scene {
            Some(Ok(scene)) if scene.kind() == SceneKind::Finger => {
                let found = scene.object().map(|object| at_rest(&scene, object)).transpose();
                heard.grasp = found.unwrap_or_else(|error| {
                    said = Some(format!("no dynamic criteria, for the finger cannot grasp this object: {error}"));
                    None
                });
                heard.tracker = heard.grasp.as_ref().map(|grasp| Tracker::new(grasp.angles()));
            }
            Some(Ok(scene)) => {
                heard.gripper = (scene.kind() == SceneKind::Gripper).then(|| GraspTracker::of(&scene));
                heard.moved = Some(scene);
            }
            Some(Err(error)) => {
                let missing = match head.kind() {
                    SceneKind::Finger => "no dynamic criteria",
                    SceneKind::Bodies => "what moves the discs is unknown",
                    SceneKind::Gripper => "no criteria of the grasp",
                };
                said = Some(format!("{missing}, for the scene in the log cannot be read by this phalanx: {error}"));
            }
            None => {}
        }
        (heard, said)
    }

    /// What is known of the run, and what its samples consist of.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The summary of what was read.
    pub fn report(&self, name: String, reading: &Reading) -> ReplayReport {
        let (criteria, grasp) = (self.criteria(reading), self.grasp(reading));
        let report = ReplayReport::new(name, reading, &self.summary, criteria, grasp.as_ref(), self.moved.as_ref());
        ReplayReport { warnings: self.warnings(), ..report }
    }

    /// Sentences on what makes the results doubtful.
    fn warnings(&self) -> Vec<String> {
        let breach = self.audit.and_then(|audit| audit.breach()).map(|breach| breach.to_string());
        let overlaps = self.overlaps.iter().flat_map(LinkOverlaps::found);
        breach.into_iter().chain(overlaps.map(|overlap| overlap.sentence())).collect()
    }

    /// What became of the object of a gripper.
    fn grasp(&self, reading: &Reading) -> Option<GraspCriteria> {
        self.gripper.as_ref().filter(|_| is_of_whole_run(reading))?.criteria()
    }

    /// Of a run that was completed, and of which nothing is missing.
    fn criteria(&self, reading: &Reading) -> Option<Criteria> {
        let judged = self.tracker.as_ref().zip(self.grasp.as_ref()).filter(|_| is_of_whole_run(reading));
        judged.and_then(|(tracker, grasp)| tracker.criteria(grasp.static_forces_n()))
    }
}

/// Whether a run was completed, and nothing is missing in its log by which it is judged.
fn is_of_whole_run(reading: &Reading) -> bool {
    let completed = reading.ended.as_ref().is_some_and(|ended| ended.stopped.is_none());
    completed && reading.can_be_judged() && reading.recovered.is_none()
}

/// An audit of the energies by the settings of the run.
fn audit(head: &Reading, scene: &Scene) -> Option<EnergyAudit> {
    let mut used = scene.clone();
    let model = match settings(&head.metadata).ok()?.solver {
        Solver::Analytic(integrator) => {
            used.integrator = integrator;
            Model::Analytic
        }
        Solver::Engine(engine) => {
            used.engine = engine;
            Model::Engine
        }
    };
    Some(EnergyAudit::new(model, &used))
}

/// The scene of a log, if it has one of a size that scenes have.
pub fn attached(head: &Reading) -> Option<Result<Scene, SceneError>> {
    let (name, text) = head.scene.as_ref().filter(|(_, text)| text.len() as u64 <= LARGEST_SCENE_BYTES)?;
    Some(scene::parse_any(text, name))
}

impl LogSink for Heard {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.summary = Summary::new(layout.clone(), self.moved.as_ref());
        // The scene may be of another kind than the log.
        self.tracker = self.tracker.take().filter(|_| layout.fingers.len() == 1);
        self.gripper = self.gripper.take().filter(|_| layout.fingers.len() == 2);
        self.overlaps = self.overlaps.take().filter(|_| layout.fingers.len() == 2);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.summary.sample(sample)?;
        self.gripper.sample(sample)?;
        self.overlaps.sample(sample)?;
        // Without its topic a sample has no energies.
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
