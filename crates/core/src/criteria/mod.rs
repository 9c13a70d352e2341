//! Dynamic criteria of a closing motion: time to stability and rebound (thesis §4.1.1).
//!
//! * **In position**: |q11 − q11,f| ≤ ε and |q21 − q21,f| ≤ ε, with ε = 0.2° and (q11,f, q21,f) the geometric final
//!   configuration, in which both phalanges touch the object.
//! * **t_geo**: the first time the finger is in position.
//! * **tts**, time to stability: start of the interval up to the end of the run in which the finger is in position and
//!   both normal forces are positive. None: the finger is not stable.
//! * **rebound** = 100 |(t_geo + T)/(tts + T) − 1| percent (4.1), with T the duration of the run; see
//!   [`rebound_percent`] for when it counts as 0.
//! * **class**: [`Class::classify`], which also depends on static stability ([`static_grasp`]); [`ClassReason`] gives
//!   the deciding figure.
//!
//! [`Tracker`] computes these criteria during a run and stores only the last sample.
//!
//! [`Rebounds`] computes the restitution of free discs, [`CableEvents`] lists when cables leave pulleys and return.
//!
//! The criteria of an object that a hand grasps are [`ObjectCriteria`], computed by [`ObjectTracker`]. [`is_form_closed`]
//! decides form closure by a five-bar hand in a sample ([`gripper_closure`](crate::statics::gripper_closure)).

mod cable_events;
mod class;
mod configuration;
mod grasp;
mod link_overlap;
mod rebounds;
mod segments;

use crate::scene::Scene;
use crate::trace::{Event, RequiredData, Sample, Sink, SinkError};
use class::{is_in_position, is_positive};
use segments::{Hermite, Segment, SegmentObserver, SegmentSplitter};
use serde::Serialize;

pub use cable_events::{CableEvent, CableEventKind, CableEvents};
pub use class::{Class, ClassReason, Condition, EPSILON_RAD, FinalContact, Loss, RESOLUTION_S, rebound_percent};
pub use configuration::{
    FinalAngles, StaticGrasp, grasp_configuration, is_form_closed, normal_forces, sample_force_closure,
    scene_static_grasp, static_grasp,
};
pub(crate) use grasp::contact_at_rest;
pub use grasp::{
    ActuatorCriteria, ActuatorTracker, CycleCriteria, DIRECTIONS, Failure, Fate, Firmness, HoldState, Margin,
    ObjectCriteria, ObjectTracker, PairCriteria, Slip, Travel, balanced_acceleration, firmness,
};
pub use link_overlap::{Link, LinkOverlap, LinkOverlaps, Obstacle};
pub use rebounds::{Rebound, Rebounds};

/// The dynamic criteria of one run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Criteria {
    /// Time to stability, s; `None` if the run does not end in a stable state.
    pub tts_s: Option<f64>,
    /// Rebound (4.1), percent; `None` if the finger is not stable.
    pub rebound_percent: Option<f64>,
    pub class: Class,
    /// Reason for the class; serialised as a sentence.
    pub class_reason: ClassReason,
    /// First time at which the finger is in position, s; `None` if it never is.
    pub t_geo_s: Option<f64>,
    /// Time after t_geo that was lost to rebounds, s: the finger was out of position, or a phalanx had lifted off the
    /// object.
    pub lost_s: f64,
    /// Whether the static grasp is force-positive. Otherwise the class is unstable, regardless of the run.
    pub statically_stable: bool,
}

impl Criteria {
    /// Returns the class and its reason as a sentence.
    pub fn verdict(&self) -> String {
        format!("{}: {}", self.class.name(), self.class_reason)
    }
}

/// A [`Sink`] that computes the [`Criteria`] of a run in constant memory.
///
/// Between two samples, the angles follow the cubic Hermite interpolant of values and rates. The times at which they
/// cross ±ε are found to 1e-9 s. Contacts change at the times of their events. Between two samples of a closed contact,
/// the normal force counts as positive if it is positive in both; the zero at the touch-down is ignored.
#[derive(Clone, Debug)]
pub struct Tracker {
    segments: SegmentSplitter,
    state: TrackerState,
}

/// History of the stability conditions up to the last segment.
#[derive(Clone, Debug, Default)]
struct TrackerState {
    target: FinalAngles,
    t_geo_s: Option<f64>,
    stable_since_s: Option<f64>,
    lost_s: f64,
    /// Histories in the order of [`Condition::ALL`].
    conditions: [ConditionHistory; 4],
    /// |q11 − q11,f| and |q21 − q21,f| in the middle of the last segment, rad; `None` before the first segment.
    deviation_rad: Option<[f64; 2]>,
}

#[derive(Clone, Copy, Debug, Default)]
struct ConditionHistory {
    /// Time at which the angle was first within its tolerance, or the phalanx first touched the object.
    first_s: Option<f64>,
    is_met: bool,
    times_lost: u32,
    /// Start and end of the last loss; during a loss the end of the last segment.
    lost_s: Option<[f64; 2]>,
}

impl ConditionHistory {
    /// Adds a segment. `has_started`: the angle has been within its tolerance, or the phalanx has touched the object.
    fn update(&mut self, [from_s, to_s]: [f64; 2], has_started: bool, is_met: bool) {
        if has_started {
            self.first_s.get_or_insert(from_s);
        }
        if !is_met && self.first_s.is_some() {
            match &mut self.lost_s {
                Some([_, until_s]) if !self.is_met => *until_s = to_s,
                lost_s => {
                    *lost_s = Some([from_s, to_s]);
                    self.times_lost = self.times_lost.saturating_add(1);
                }
            }
        }
        self.is_met = is_met;
    }

    fn final_contact(&self) -> FinalContact {
        match (self.is_met, self.lost_s) {
            (true, _) => FinalContact::Active,
            (false, Some([at_s, _])) => FinalContact::LiftedOff { at_s },
            (false, None) => FinalContact::NeverTouched,
        }
    }
}

impl Tracker {
    /// Creates a tracker for a finger with these final angles.
    pub fn new(target: FinalAngles) -> Self {
        Tracker {
            segments: SegmentSplitter::new([0, 1], None),
            state: TrackerState { target, ..TrackerState::default() },
        }
    }

    /// Returns the criteria of the run up to the last sample; `None` for a run without duration. `static_forces_n` are
    /// the normal forces of both phalanges in the static grasp (thesis (2.32)), N; `None` if unknown.
    pub fn criteria(&self, static_forces_n: Option<[f64; 2]>) -> Option<Criteria> {
        let TrackerState { t_geo_s, stable_since_s, lost_s, deviation_rad, .. } = self.state;
        let (last, evaluated_rad) = (self.segments.last()?, deviation_rad?);
        let deviation_rad = self.state.deviation_rad(last.finger(0).q11_rad, last.finger(0).q21_rad);
        // A crossing of the limit at the end must not contradict the evaluation of the last segment.
        let deviation_rad =
            [0, 1].map(|joint| match is_in_position(deviation_rad[joint]) == is_in_position(evaluated_rad[joint]) {
                true => deviation_rad[joint],
                false => evaluated_rad[joint],
            });
        let rebound_percent =
            t_geo_s.zip(stable_since_s).map(|(t_geo_s, tts_s)| rebound_percent(t_geo_s, tts_s, last.time_s, lost_s));
        let negative_forces_n = static_forces_n.filter(|forces_n| !is_positive(forces_n));
        let class_reason = match (negative_forces_n, stable_since_s.zip(rebound_percent)) {
            (Some(forces_n), _) => ClassReason::StaticForces { forces_n },
            (None, Some((tts_s, rebound_percent))) => {
                ClassReason::Settled { tts_s, rebound_percent, loss: self.state.last_loss() }
            }
            (None, None) if deviation_rad.into_iter().all(is_in_position) => {
                let [_, _, proximal, tip] = &self.state.conditions;
                ClassReason::NotInContact { phalanges: [proximal, tip].map(ConditionHistory::final_contact) }
            }
            (None, None) => ClassReason::OutOfPosition { deviation_rad },
        };
        Some(Criteria {
            t_geo_s,
            tts_s: stable_since_s,
            lost_s,
            rebound_percent,
            statically_stable: negative_forces_n.is_none(),
            class: class_reason.class(),
            class_reason,
        })
    }
}

impl TrackerState {
    fn deviation_rad(&self, q11_rad: f64, q21_rad: f64) -> [f64; 2] {
        [(q11_rad - self.target.q11_rad).abs(), (q21_rad - self.target.q21_rad).abs()]
    }

    /// Returns the loss that ended last, if it counts as a rebound.
    fn last_loss(&self) -> Option<Loss> {
        let t_geo_s = self.t_geo_s.filter(|_| self.lost_s >= RESOLUTION_S)?;
        let [_, _, proximal, tip] = &self.conditions;
        let tip_first = tip.first_s.zip(proximal.first_s).is_some_and(|(tip_s, proximal_s)| tip_s < proximal_s);
        let losses = Condition::ALL.into_iter().zip(&self.conditions).filter_map(|(condition, history)| {
            let [from_s, until_s] = history.lost_s?;
            let touched_first = condition == Condition::Tip && tip_first;
            Some(Loss {
                condition,
                from_s,
                until_s,
                times: history.times_lost,
                touched_first,
                total_lost_s: self.lost_s,
            })
        });
        losses.filter(|loss| loss.until_s > t_geo_s).max_by(|a, b| a.until_s.total_cmp(&b.until_s))
    }
}

/// Observes the contacts of the proximal and the distal phalanx, the first two of a finger.
impl SegmentObserver for TrackerState {
    /// Interpolants of q11 and q21.
    type Interpolant = [Hermite; 2];

    fn interpolate(&mut self, last: &Sample, next: &Sample, cuts_s: &mut Vec<f64>) -> [Hermite; 2] {
        let ([from, to], [t0, t1]) = ([last.finger(0), next.finger(0)], [last.time_s, next.time_s]);
        let q11 = Hermite::new((t0, from.q11_rad, from.qd11_rad_s), (t1, to.q11_rad, to.qd11_rad_s));
        let q21 = Hermite::new((t0, from.q21_rad, from.qd21_rad_s), (t1, to.q21_rad, to.qd21_rad_s));
        for (angle, target) in [(&q11, self.target.q11_rad), (&q21, self.target.q21_rad)] {
            angle.crossings(target - EPSILON_RAD, cuts_s);
            angle.crossings(target + EPSILON_RAD, cuts_s);
        }
        [q11, q21]
    }

    fn observe(&mut self, [q11, q21]: &[Hermite; 2], segment: &Segment<'_>) {
        let middle = 0.5 * (segment.from_s + segment.to_s);
        let deviation_rad = self.deviation_rad(q11.value(middle), q21.value(middle));
        self.deviation_rad = Some(deviation_rad);
        let ([q11_in, q21_in], [proximal, tip]) =
            (deviation_rad.map(is_in_position), [0, 1].map(|k: usize| segment.is_active[k]));
        let in_position = q11_in && q21_in;
        let has_started = [q11_in, q21_in, segment.has_touched[0], segment.has_touched[1]];
        for ((history, has_started), is_met) in
            self.conditions.iter_mut().zip(has_started).zip([q11_in, q21_in, proximal, tip])
        {
            history.update([segment.from_s, segment.to_s], has_started, is_met);
        }
        if in_position {
            self.t_geo_s.get_or_insert(segment.from_s);
        }
        if in_position && proximal && tip {
            self.stable_since_s.get_or_insert(segment.from_s);
            return;
        }
        self.stable_since_s = None;
        let has_lifted_off = segment
            .has_touched
            .iter()
            .zip(segment.is_active)
            .any(|(has_touched, is_active)| *has_touched && !is_active);
        if self.t_geo_s.is_some() && (!in_position || has_lifted_off) {
            self.lost_s += segment.to_s - segment.from_s;
        }
    }
}

impl Sink for Tracker {
    fn required_data(&self) -> RequiredData {
        RequiredData { peaks: true, ..RequiredData::NONE }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.segments.sample(sample, &mut self.state);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.segments.event(event);
        Ok(())
    }
}

/// A [`Sink`] that consists of all trackers that apply to a scene.
#[derive(Debug)]
pub struct RunCriteriaTracker {
    finger: Option<Tracker>,
    static_grasp: Option<StaticGrasp>,
    grasp: Option<ObjectTracker>,
    rebounds: Option<Rebounds>,
    overlaps: Option<LinkOverlaps>,
    cable_events: Option<CableEvents>,
}

/// All criteria of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunCriteria {
    /// Criteria of a finger; `None` if it cannot grasp its object or the run was not completed.
    pub criteria: Option<Criteria>,
    /// Criteria of the object that a hand grasps; `None` if the scene has no grasp, or if the run was not completed.
    pub grasp: Option<ObjectCriteria>,
    /// Rebounds of all contacts of discs; empty in scenes with joints or other outlines.
    pub rebounds: Vec<Rebound>,
    /// Overlaps of the links of a gripper with obstacles for which the scene defines no contact.
    pub overlaps: Vec<LinkOverlap>,
    /// Lift-offs of cables from pulleys, and their returns.
    pub cable_events: Vec<CableEvent>,
}

impl RunCriteriaTracker {
    /// Creates the trackers for runs of a scene.
    pub fn for_scene(scene: &Scene) -> Self {
        let count = scene.finger_count();
        let object = scene.object().filter(|_| count == 1);
        let static_grasp = object.and_then(|object| static_grasp(scene, object).ok());
        RunCriteriaTracker {
            finger: static_grasp.as_ref().map(|grasp| Tracker::new(grasp.final_angles())),
            static_grasp,
            grasp: ObjectTracker::for_scene(scene),
            rebounds: scene.mechanism.as_ref().and_then(Rebounds::for_mechanism),
            overlaps: LinkOverlaps::for_scene(scene),
            cable_events: scene.mechanism.as_ref().and_then(CableEvents::for_mechanism),
        }
    }

    /// Returns the criteria at the end of a run; `completed` is false for an interrupted or failed run.
    pub fn finish(self, completed: bool) -> RunCriteria {
        let finger = self.finger.filter(|_| completed).zip(self.static_grasp);
        RunCriteria {
            criteria: finger.and_then(|(tracker, grasp)| tracker.criteria(grasp.static_forces_n())),
            grasp: self.grasp.filter(|_| completed).and_then(|tracker| tracker.criteria()),
            rebounds: self.rebounds.map(|found| found.pairs().to_vec()).unwrap_or_default(),
            overlaps: self.overlaps.as_ref().map(LinkOverlaps::overlaps).unwrap_or_default(),
            cable_events: self.cable_events.map(|found| found.events().to_vec()).unwrap_or_default(),
        }
    }
}

impl Sink for RunCriteriaTracker {
    fn required_data(&self) -> RequiredData {
        let of_grasp = self.grasp.required_data().or(self.overlaps.required_data());
        let of_pairs = self.rebounds.required_data().or(self.cable_events.required_data());
        self.finger.required_data().or(of_grasp).or(of_pairs)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.finger.sample(sample)?;
        self.grasp.sample(sample)?;
        self.overlaps.sample(sample)?;
        self.cable_events.sample(sample)?;
        self.rebounds.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.finger.event(event)?;
        self.grasp.event(event)?;
        self.rebounds.event(event)
    }
}
