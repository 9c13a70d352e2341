//! What a run of any scene is judged by, while it streams by.

use super::{
    AtRest, Criteria, GraspCriteria, GraspTracker, LinkOverlap, LinkOverlaps, Rebound, Rebounds, Tracker, at_rest,
};
use crate::scene::Scene;
use crate::scene::words::SceneKind;
use crate::trace::{Event, Sample, Sink, SinkError};

/// Whoever of the trackers a scene has a use for.
#[derive(Debug)]
pub struct Judge {
    finger: Option<(Tracker, AtRest)>,
    gripper: Option<GraspTracker>,
    rebounds: Option<Rebounds>,
    overlaps: Option<LinkOverlaps>,
}

/// What they found.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Of a finger, if it can grasp its object and the run was completed.
    pub criteria: Option<Criteria>,
    /// Of a gripper, if the run was completed.
    pub grasp: Option<GraspCriteria>,
    /// Of every pair of discs; empty where there is a finger.
    pub rebounds: Vec<Rebound>,
    /// Links of a gripper that overlap what they have no contact with.
    pub overlaps: Vec<LinkOverlap>,
}

impl Judge {
    /// For runs of a scene.
    pub fn of(scene: &Scene) -> Self {
        let mut judge = Judge { finger: None, gripper: None, rebounds: None, overlaps: LinkOverlaps::of(scene) };
        match scene.kind() {
            SceneKind::Finger => {
                let rest = scene.object().and_then(|object| at_rest(scene, object).ok());
                judge.finger = rest.map(|rest| (Tracker::new(rest.angles()), rest));
            }
            SceneKind::Bodies => judge.rebounds = Some(Rebounds::of(&scene.system)),
            SceneKind::Gripper => judge.gripper = Some(GraspTracker::of(scene)),
        }
        judge
    }

    /// What is known when a run is over, `completed` or not.
    pub fn judged(self, completed: bool) -> Judged {
        let finger = self.finger.filter(|_| completed);
        Judged {
            criteria: finger.and_then(|(tracker, rest)| tracker.criteria(rest.static_forces_n())),
            grasp: self.gripper.filter(|_| completed).and_then(|tracker| tracker.criteria()),
            rebounds: self.rebounds.map(|found| found.pairs().to_vec()).unwrap_or_default(),
            overlaps: self.overlaps.as_ref().map(LinkOverlaps::found).unwrap_or_default(),
        }
    }
}

impl Sink for Judge {
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
