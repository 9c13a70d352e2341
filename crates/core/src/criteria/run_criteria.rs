//! Criteria of a run of any kind of scene.

use super::{
    Criteria, GraspCriteria, GraspTracker, LinkOverlap, LinkOverlaps, Rebound, Rebounds, StaticGrasp, Tracker,
    static_grasp,
};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::trace::{Event, Sample, Sink, SinkError};

/// A [`Sink`] with the trackers that apply to a scene.
#[derive(Debug)]
pub struct RunCriteriaTracker {
    finger: Option<Tracker>,
    static_grasp: Option<StaticGrasp>,
    gripper: Option<GraspTracker>,
    rebounds: Option<Rebounds>,
    overlaps: Option<LinkOverlaps>,
}

/// All criteria of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunCriteria {
    /// Criteria of a finger; `None` if it cannot grasp its object or the run was not completed.
    pub criteria: Option<Criteria>,
    /// Criteria of a gripper; `None` if the run was not completed.
    pub grasp: Option<GraspCriteria>,
    /// Rebounds of all pairs of discs; empty in scenes with fingers.
    pub rebounds: Vec<Rebound>,
    /// Overlaps of links of a gripper with obstacles that they have no contact with.
    pub overlaps: Vec<LinkOverlap>,
}

impl RunCriteriaTracker {
    /// Creates the trackers for runs of a scene.
    pub fn for_scene(scene: &Scene) -> Self {
        let kind = scene.kind();
        let object = scene.object().filter(|_| kind == SceneKind::Finger);
        let static_grasp = object.and_then(|object| static_grasp(scene, object).ok());
        RunCriteriaTracker {
            finger: static_grasp.as_ref().map(|grasp| Tracker::new(grasp.final_angles())),
            static_grasp,
            gripper: (kind == SceneKind::Gripper).then(|| GraspTracker::for_scene(scene)),
            rebounds: (kind == SceneKind::Bodies).then(|| Rebounds::for_system(&scene.system)),
            overlaps: LinkOverlaps::for_scene(scene),
        }
    }

    /// Returns the criteria at the end of a run; `completed` is false for an interrupted or failed run.
    pub fn finish(self, completed: bool) -> RunCriteria {
        let finger = self.finger.filter(|_| completed).zip(self.static_grasp);
        RunCriteria {
            criteria: finger.and_then(|(tracker, grasp)| tracker.criteria(grasp.static_forces_n())),
            grasp: self.gripper.filter(|_| completed).and_then(|tracker| tracker.criteria()),
            rebounds: self.rebounds.map(|found| found.pairs().to_vec()).unwrap_or_default(),
            overlaps: self.overlaps.as_ref().map(LinkOverlaps::overlaps).unwrap_or_default(),
        }
    }
}

impl Sink for RunCriteriaTracker {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.finger.sample(sample)?;
        self.gripper.sample(sample)?;
        self.overlaps.sample(sample)?;
        self.rebounds.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.finger.event(event)?;
        self.gripper.event(event)?;
        self.rebounds.event(event)
    }
}
