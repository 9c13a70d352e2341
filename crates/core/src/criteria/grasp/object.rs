//! The criteria of an object.

use super::actuators::ActuatorCriteria;
use super::cycle::{CycleCriteria, Travel};
use super::fate::Fate;
use super::hold::HoldState;
use super::pairs::PairCriteria;
use crate::numeric::elementary::hypot;
use crate::trace::{BodyState, Sample};

/// Criteria of the grasp of an object (verdicts.md, "Is it held?"). Poses are relative to the base.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectCriteria {
    /// Name of the object.
    pub object: String,
    /// Name of the base.
    pub base: String,
    /// Names of the outlines of the ground that count as part of the hand although no key says so.
    pub assumed_hand: Vec<String>,
    /// Largest distance from the centre of mass of the object to its outlines, m.
    pub radius_m: f64,
    pub fate: Fate,
    /// Reason for the fate: a sentence without a full stop.
    pub reason: String,
    /// Changes of the state of the object with their times; the first entry is the state at the start.
    pub states: Vec<(f64, HoldState)>,
    /// Time at which the object was first gripped, s; `None` if no grip lasted for the required time.
    pub grasped_s: Option<f64>,
    /// Start of the grip that lasts to the end, s, even if it is shorter than required; `None` if the object is not
    /// gripped at the end.
    pub held_since_s: Option<f64>,
    /// Time since which the object has been gripped, and all pairs that are active at the end have been active, s;
    /// `None` unless the object is held.
    pub tts_s: Option<f64>,
    /// End of the last grip of a dropped or placed object.
    pub until_s: Option<f64>,
    /// Time at which the object left the hand, s: from then on, all gaps between them exceed the extent of the object
    /// and grow.
    pub escaped_s: Option<f64>,
    /// Like `escaped_s`, but also set after the release. It ends a run with `[grasp]`; after the release, it does not
    /// change the fate.
    pub left_s: Option<f64>,
    /// Travel of the object from `tts_s` to the end of the run.
    pub slip: Option<Slip>,
    /// Rate of travel of the object over the last `held_time`, m/s; `None` unless the object is held.
    pub creep_m_s: Option<f64>,
    /// All pairs, in the order of the contacts.
    pub pairs: Vec<PairCriteria>,
    pub actuators: Vec<ActuatorCriteria>,
    /// State of the object at the start of the run, in the frame of the samples.
    pub start: BodyState,
    /// State of the object at the end of the run, in the frame of the samples.
    pub last: BodyState,
    /// Largest travel of the object since the start of the run.
    pub travel: Travel,
    pub cycle: CycleCriteria,
    /// Sample at the end of the run, or at the release.
    pub end: Sample,
}

/// Largest offset from the middle at which an object counts as centred, m: far below any positioning accuracy.
const CENTRED_TOLERANCE_M: f64 = 1e-9;

/// Travel from one pose to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Slip {
    /// Displacement of the centre of mass, m.
    pub displacement_m: f64,
    /// Rotation, counter-clockwise, rad.
    pub rotation_rad: f64,
}

impl ObjectCriteria {
    /// Number of losses of all pairs.
    pub fn contacts_lost(&self) -> u32 {
        self.pairs.iter().map(|pair| pair.times_lost).sum()
    }

    /// Returns the ratio of |x| of the object at the end of the run to that at its start. Below 1, the grasp centres
    /// the object. `None` if the object is centred at the start.
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

    /// Largest use of friction among the pairs of the hand at the end; 1 is the limit.
    pub fn friction_used(&self) -> Option<f64> {
        self.pairs.iter().filter(|pair| pair.is_hand).filter_map(|pair| pair.friction_used).reduce(f64::max)
    }

    /// State of the object at the end.
    pub fn end_state(&self) -> HoldState {
        self.states.last().map_or(HoldState::Free, |(_, state)| *state)
    }
}
