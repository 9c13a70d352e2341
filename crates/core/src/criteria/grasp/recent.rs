//! The last part of the run, of the length `held_time`: travel of the object and sliding of its contacts.

use std::collections::VecDeque;

use super::pose::{BodyMotion, RelativePose, relative};
use crate::trace::BodyState;

/// Instants per `held_time` that are kept: within them, positions are interpolated.
const INSTANTS: f64 = 128.0;

/// States at the ends of the latest steps.
#[derive(Clone, Debug, Default)]
pub(super) struct Recent {
    instants: VecDeque<Instant>,
}

#[derive(Clone, Debug)]
pub(super) struct Instant {
    pub time_s: f64,
    pub object: BodyState,
    pub base: BodyState,
    pub ground: BodyState,
    /// Distance that each point of the hand has slid since the start, m. Sliding to and fro in a vibration is not added
    /// up.
    pub slid_m: Vec<f64>,
}

/// Rates over the last part of the run.
#[derive(Clone, Debug, Default)]
pub(super) struct RecentRates {
    /// Velocity of the centre of mass, m/s, and spin, rad/s, in the frame of the base.
    pub in_base: RelativePose,
    /// Velocity of the centre of mass, m/s, and spin, rad/s, in the world.
    pub in_world: RelativePose,
    /// Mean sliding speed of each point of the hand, m/s.
    pub sliding_m_s: Vec<f64>,
}

impl Recent {
    pub fn last(&self) -> Option<&Instant> {
        self.instants.back()
    }

    /// Adds an instant, and removes those that are no longer needed.
    pub fn add(&mut self, instant: Instant, held_time_s: f64) {
        let count = self.instants.len();
        // The last instant but one may stay out if those around it are close together.
        if count >= 2 && instant.time_s - self.instants[count - 2].time_s < held_time_s / INSTANTS {
            self.instants.pop_back();
        }
        let start_s = instant.time_s - held_time_s;
        self.instants.push_back(instant);
        while self.instants.len() > 2 && self.instants[1].time_s <= start_s {
            self.instants.pop_front();
        }
    }

    /// Rates over the last `held_time_s`, or since the start of a run that is shorter; `None` for a run without
    /// duration.
    pub fn rates(&self, com_m: [f64; 2], held_time_s: f64) -> Option<RecentRates> {
        let end = self.instants.back()?;
        let start_s = (end.time_s - held_time_s).max(self.instants.front()?.time_s);
        let after = self.instants.iter().position(|instant| instant.time_s > start_s)?;
        let [from, to] = [&self.instants[after.saturating_sub(1)], &self.instants[after]];
        let length_s = end.time_s - start_s;
        if length_s <= 0.0 || from.time_s >= to.time_s {
            return None;
        }
        let at_start = |of: &dyn Fn(&Instant) -> BodyState| {
            BodyMotion::between((from.time_s, &of(from)), (to.time_s, &of(to))).at(start_s)
        };
        let rates = |frame: &dyn Fn(&Instant) -> BodyState| {
            let pose = |state: BodyState| super::pose::pose_of(&state);
            let before = relative(at_start(&|instant| instant.object), com_m, at_start(frame));
            let after = relative(pose(end.object), com_m, pose(frame(end)));
            std::array::from_fn(|k| (after[k] - before[k]) / length_s)
        };
        let fraction = (start_s - from.time_s) / (to.time_s - from.time_s);
        let slid = |k: usize| end.slid_m[k] - (from.slid_m[k] + fraction * (to.slid_m[k] - from.slid_m[k]));
        Some(RecentRates {
            in_base: rates(&|instant| instant.base),
            in_world: rates(&|instant| instant.ground),
            sliding_m_s: (0..end.slid_m.len()).map(|k| slid(k).abs() / length_s).collect(),
        })
    }
}
