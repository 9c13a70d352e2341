//! The criteria of an object.

use super::actuators::ActuatorCriteria;
use super::cycle::{CycleCriteria, Travel};
use super::fate::Fate;
use super::hold::HoldState;
use super::pairs::PairCriteria;
use crate::numeric::elementary::hypot;
use crate::trace::{BodyState, Sample};

/// Criteria of the grasp of an object (verdicts.md, "Is it held?"). Poses are in the frame of the base.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectCriteria {
    /// Names of the object and the base.
    pub object: String,
    pub base: String,
    /// Names of the outlines of the ground that count as part of the hand although no key says so.
    pub assumed_hand: Vec<String>,
    /// Largest distance of the outlines of the object from its centre of mass, m.
    pub radius_m: f64,
    pub fate: Fate,
    /// Reason for the fate, a sentence without a full stop.
    pub reason: String,
    /// Changes of the state of the object, the first one at the start.
    pub states: Vec<(f64, HoldState)>,
    /// Time at which the object was first gripped; `None` if it was never gripped for the required time.
    pub grasped_s: Option<f64>,
    /// Time since which it is gripped at the end, even if shorter than required.
    pub held_since_s: Option<f64>,
    /// Time since which all pairs that are active at the end are active and the object is gripped; `None` unless it is held.
    pub tts_s: Option<f64>,
    /// End of the last grip of a dropped or placed object.
    pub until_s: Option<f64>,
    /// Time at which the object left the hand: all gaps to it exceed the extent of the object and grow.
    pub escaped_s: Option<f64>,
    /// The same time, also after the release, which does not change the fate: it ends a run with `[grasp]`.
    pub left_s: Option<f64>,
    /// Travel of the object from `tts_s` to the end.
    pub slip: Option<Slip>,
    /// Rate of its travel over the last `held_time`, m/s; `None` unless it is held.
    pub creep_m_s: Option<f64>,
    /// All pairs, in the order of the contacts.
    pub pairs: Vec<PairCriteria>,
    pub actuators: Vec<ActuatorCriteria>,
    /// State of the object at the start and at the end of the run, in the frame of the samples.
    pub start: BodyState,
    pub last: BodyState,
    /// Largest travel of the object since the start of the run.
    pub travel: Travel,
    pub cycle: CycleCriteria,
    /// State of the run at its end, or at the release.
    pub end: Sample,
}

/// Largest offset from the middle at which an object counts as centred, m: far below any positioning accuracy.
const CENTRED_TOLERANCE_M: f64 = 1e-9;

/// Travel between two poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Slip {
    /// Distance of the centre of mass, m.
    pub displacement_m: f64,
    /// Rotation, counter-clockwise, rad.
    pub rotation_rad: f64,
}

impl ObjectCriteria {
    /// Number of losses of all pairs.
    pub fn contacts_lost(&self) -> u32 {
        self.pairs.iter().map(|pair| pair.times_lost).sum()
    }

    /// Returns |x| at the end of the run over that at its start: below 1 the grasp centres its object. `None` for a centred
    /// start.
    pub fn offset_ratio(&self) -> Option<f64> {
        let [start, end] = [self.start, self.last].map(|body| body.centre_m[0].abs());
        (start > CENTRED_TOLERANCE_M).then(|| end / start)
    }

    /// Returns the speed of the origin of the object at the end of the run, m/s.
    pub fn end_speed_m_s(&self) -> f64 {
        let [x, y] = self.last.velocity_m_s;
        hypot(x, y)
    }

    /// Sum of the normal forces of the hand at the end, N.
    pub fn grip_n(&self) -> f64 {
        self.pairs.iter().filter(|pair| pair.is_hand).map(|pair| pair.normal_n).sum()
    }

    /// Largest use of friction of a pair of the hand at the end.
    pub fn friction_used(&self) -> Option<f64> {
        self.pairs.iter().filter(|pair| pair.is_hand).filter_map(|pair| pair.friction_used).reduce(f64::max)
    }

    /// State of the object at the end.
    pub fn end_state(&self) -> HoldState {
        self.states.last().map_or(HoldState::Free, |(_, state)| *state)
    }
}
