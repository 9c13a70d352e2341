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
    finger: Option<(Tracker, StaticGrasp)>,
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
        let mut tracker = RunCriteriaTracker {
            finger: None,
            gripper: None,
            rebounds: None,
            overlaps: LinkOverlaps::for_scene(scene),
        };
        match scene.kind() {
            SceneKind::Finger => {
                let grasp = scene.object().and_then(|object| static_grasp(scene, object).ok());
                tracker.finger = grasp.map(|grasp| (Tracker::new(grasp.final_angles()), grasp));
            }
            SceneKind::Bodies => tracker.rebounds = Some(Rebounds::for_system(&scene.system)),
            SceneKind::Gripper => tracker.gripper = Some(GraspTracker::for_scene(scene)),
        }
        tracker
    }

    /// Returns the criteria at the end of a run; `completed` is false for an interrupted or failed run.
    pub fn finish(self, completed: bool) -> RunCriteria {
        let finger = self.finger.filter(|_| completed);
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
        if let Some((tracker, _)) = &mut self.finger {
            tracker.sample(sample)?;
        }
        self.gripper.sample(sample)?;
        self.overlaps.sample(sample)?;
        self.rebounds.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if let Some((tracker, _)) = &mut self.finger {
            tracker.event(event)?;
        }
        self.gripper.event(event)?;
        self.rebounds.event(event)
    }
}
