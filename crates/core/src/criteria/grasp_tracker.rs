//! Criteria of a run of a gripper.

use super::configuration::{friction_coefficients, selected_force_closure};
use super::segments::{Hermite, Segment, SegmentObserver, SegmentSplitter};
use crate::drawing::FramePose;
use crate::gripper::FingerContact;
use crate::numeric::elementary::hypot;
use crate::scene::{Cycle, HandContact, Scene, Thresholds};
use crate::shape;
use crate::statics::PerContact;
use crate::trace::{BodyState, Event, Reach, RequiredData, Sample, Sink, SinkError};
use serde::Serialize;

/// The criteria of one run of a gripper (6-gripper §6.8). Poses are in the palm frame.
///
/// A contact is *active* while its normal force exceeds the force threshold of the scene. Losses shorter than the time
/// threshold are ignored ([`Thresholds`](crate::scene::Thresholds)).
///
/// The object *has contacts on both sides* while two phalanges have active contacts whose normals have x components
/// (along the palm) of opposite sign. Palm and table do not count. A single finger bent around the object can have
/// contacts on both sides. The object is *force-closed* if the active contacts of phalanges and palm balance any force
/// and moment by normal forces and friction. It is *held* while either condition is met.
#[derive(Clone, Debug, PartialEq)]
pub struct GraspCriteria {
    /// Criteria of the phalanges, palm and table (no joint limits), in the order of samples.
    pub contacts: Vec<ContactCriteria>,
    /// Time to stability of the whole grasp: start of the interval up to the end of the run in which all contacts that
    /// are active at the end are active, including palm and table. It is the largest of their
    /// [`ContactCriteria::active_since_s`]. `None` if the object is not held at the end.
    pub tts_s: Option<f64>,
    /// Time at which the object was first held; `None` if it was never held for the required time.
    pub grasped_s: Option<f64>,
    /// Time since which the object is held at the end, even if shorter than required; `None` if the object is not held.
    pub held_since_s: Option<f64>,
    pub fate: Fate,
    /// State of the object at the start of the run.
    pub start: BodyState,
    /// State of the object at the end of the run.
    pub end: BodyState,
    /// Travel of the object since the start.
    pub travel: Travel,
    /// Slip in the hand: travel of the object since [`GraspCriteria::tts_s`].
    pub slip: Option<Travel>,
    /// Criteria of a cycle. For the criteria above, the end is the release, if there is one.
    pub cycle: CycleCriteria,
}

/// Criteria of a cycle: palm motion and release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CycleCriteria {
    /// Time at which the palm begins to move.
    pub motion_start_s: Option<f64>,
    /// Time at which the drives stop closing the fingers.
    pub release_s: Option<f64>,
    /// Travel of the object in the hand from `motion_start_s` to `release_s`, or to the end of the run.
    pub motion_travel: Option<Travel>,
    /// Time after the release since which no phalanx is active; `None` if one is at the end, or without a release.
    pub opened_s: Option<f64>,
    /// Largest rotation of the driven links, right and left, from the engagement of their brakes to the release, rad.
    pub brake_slip_rad: [Option<f64>; 2],
}

/// Returns the reason for a fate, as a sentence without a full stop.
pub fn fate_reason(criteria: &GraspCriteria, held_time_s: f64) -> String {
    let ms = |time_s: f64| format!("{:.6} ms", time_s * 1e3);
    match (criteria.fate, criteria.held_since_s) {
        (Fate::Held, since_s) => format!("held from {} on", ms(since_s.unwrap_or_default())),
        (Fate::Dropped { since_s }, None) => format!("no longer held from {} on", ms(since_s)),
        (Fate::Dropped { since_s }, Some(again_s)) => {
            let (lost, again, required) = (ms(since_s), ms(again_s), ms(held_time_s));
            format!("no longer held from {lost} on; held again only from {again} on, less than {required}")
        }
        (Fate::Ejected { at_s }, _) => format!("out of the reach of both fingers at {}", ms(at_s)),
        (Fate::NotGrasped, None) => format!("never held for {}", ms(held_time_s)),
        (Fate::NotGrasped, Some(since_s)) => {
            format!("held only from {} on, less than {}", ms(since_s), ms(held_time_s))
        }
        // Fates of mechanisms.
        (Fate::Carried | Fate::Placed { .. } | Fate::Escaped { .. }, _) => criteria.fate.name().to_string(),
    }
}

/// Largest offset from the middle at which an object counts as centred, m: far below any positioning accuracy.
const CENTRED_TOLERANCE_M: f64 = 1e-9;

impl GraspCriteria {
    /// Returns |x| at the end over that at the start: below 1 the grasp centres its object. `None` for a centred start.
    pub fn offset_ratio(&self) -> Option<f64> {
        let [start, end] = [self.start, self.end].map(|body| body.centre_m[0].abs());
        (start > CENTRED_TOLERANCE_M).then(|| end / start)
    }

    /// Returns the speed of the object's centre at the end, m/s.
    pub fn end_speed_m_s(&self) -> f64 {
        let [x, y] = self.end.velocity_m_s;
        hypot(x, y)
    }
}

/// Criteria of one contact over a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContactCriteria {
    #[serde(skip)]
    pub id: HandContact,
    /// Time of the first contact; `None` if there was none.
    #[serde(rename = "first_touch_s")]
    pub first_contact_s: Option<f64>,
    /// Start of the interval up to the end of the run in which it is active; `None` if it is not active then.
    #[serde(rename = "presses_since_s")]
    pub active_since_s: Option<f64>,
    /// Number of losses after the contact was first active.
    pub times_lost: u32,
    /// Total duration of all losses up to the end of the run, s.
    pub lost_s: f64,
}

/// Fate of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// The object is held at the end, or at the release, and has been held for at least the required time of the scene.
    Held,
    /// The hand carries the object without a grip (mechanisms).
    Carried,
    /// The hand lifted the object and released it at `until_s`, and it rests outside the hand (mechanisms).
    Placed { until_s: f64 },
    /// The object was held for the required time and is no longer held since `since_s`. An object that is lost, caught
    /// again and held at the end is not dropped. The travel does not matter.
    Dropped { since_s: f64 },
    /// At `at_s` the object left the region that the fingers can reach ([`Reach`](crate::trace::Reach)), after a
    /// contact. The run ends there.
    Ejected { at_s: f64 },
    /// At `at_s` an object that was never held for the required time left the hand after a contact (mechanisms).
    Escaped { at_s: f64 },
    /// The object was never held for the required time.
    NotGrasped,
}

impl Fate {
    /// Names of all fates, from best to worst.
    pub const NAMES: [&str; 7] = ["held", "carried", "placed", "dropped", "ejected", "escaped", "not grasped"];

    /// Names of the fates of a gripper's object.
    pub const OF_GRIPPERS: [&str; 4] = ["held", "dropped", "ejected", "not grasped"];

    /// Returns the name in results and reports.
    pub fn name(self) -> &'static str {
        Self::NAMES[match self {
            Fate::Held => 0,
            Fate::Carried => 1,
            Fate::Placed { .. } => 2,
            Fate::Dropped { .. } => 3,
            Fate::Ejected { .. } => 4,
            Fate::Escaped { .. } => 5,
            Fate::NotGrasped => 6,
        }]
    }

    /// Returns the time since which the object is not held, or at which it left the hand; `None` for other fates.
    pub fn lost_at_s(self) -> Option<f64> {
        match self {
            Fate::Dropped { since_s } => Some(since_s),
            Fate::Placed { until_s } => Some(until_s),
            Fate::Ejected { at_s } | Fate::Escaped { at_s } => Some(at_s),
            Fate::Held | Fate::Carried | Fate::NotGrasped => None,
        }
    }
}

/// Largest travel of the object from a pose, evaluated at samples and contact changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Travel {
    /// Largest displacement of its centre, m.
    pub displacement_m: f64,
    /// Largest rotation in either direction, rad.
    pub rotation_rad: f64,
}

const CONTACT_COUNT: usize = HandContact::ALL.len();

/// A [`Sink`] that computes the [`GraspCriteria`] of a run of a gripper in constant memory.
///
/// Contacts change at the times of their events and when their force crosses the threshold. Between two samples the
/// object follows the cubic Hermite interpolant of poses and rates.
#[derive(Clone, Debug)]
pub struct GraspTracker {
    segments: SegmentSplitter,
    state: TrackerState,
}

/// Settings of the scene that the criteria depend on.
#[derive(Clone, Debug)]
struct Setup {
    /// Contacts of the samples.
    contacts: Vec<HandContact>,
    /// The object, if it is fixed.
    fixed_object: Option<BodyState>,
    thresholds: Thresholds,
    cycle: Cycle,
    /// Region that the fingers can reach; `None` if the object cannot be ejected.
    reach: Option<Reach>,
    friction: PerContact<f64>,
    /// Distance of the object's outermost point from its centre, m.
    object_m: f64,
    /// Minimum time between two evaluations of force closure, s.
    closure_interval_s: f64,
    /// Time between two evaluations of the travel, s.
    travel_interval_s: f64,
}

/// Minimum time between two evaluations of force closure, per run time: a hundred evaluations cost less than the run.
const CLOSURE_INTERVAL_FRACTION: f64 = 0.01;
/// Approximate number of evaluations of the travel per run, and maximum number between two samples.
const TRAVELS_PER_RUN: f64 = 256.0;
const MAX_TRAVELS_PER_SEGMENT: f64 = 7.0;

/// Force closure of an unchanged set of active contacts.
#[derive(Clone, Copy, Debug, Default)]
struct Closure {
    /// Active contacts, and the time since which they are unchanged.
    active: [bool; CONTACT_COUNT],
    since_s: f64,
    last_evaluation_s: Option<f64>,
    /// Result of the last evaluation.
    closed: bool,
}

/// Settings of the scene, and the history of object, contacts and brakes up to the last segment.
#[derive(Clone, Debug)]
struct TrackerState {
    setup: Setup,
    history: History,
}

/// History of object, contacts and brakes up to the last segment.
#[derive(Clone, Debug, Default)]
struct History {
    /// The object in the first sample, and its travel since.
    start: Option<(BodyState, TravelSince)>,
    contacts: [ContactHistory; CONTACT_COUNT],
    closure: Closure,
    /// Time at which the object was first held.
    grasped_s: Option<f64>,
    /// Whether the object has been held for the required time since `grasped_s`.
    was_held: bool,
    /// Time since which the object is held.
    held_since_s: Option<f64>,
    /// Time at which the object was dropped after having been held for the required time.
    dropped_s: Option<f64>,
    /// Whether the fingers can reach the object in the last sample.
    is_in_reach: bool,
    ejected_s: Option<f64>,
    /// End of the last segment before the release.
    evaluated_until_s: f64,
    motion_travel: Option<TravelSince>,
    opened_s: Option<f64>,
    /// q11 of each finger when its brake engaged, and the largest rotation since, rad.
    brake_slip: [Option<(f64, f64)>; 2],
}

impl Setup {
    fn object(&self, sample: &Sample) -> BodyState {
        self.fixed_object.unwrap_or_else(|| sample.body(0))
    }
}

impl History {
    /// Extends all travels to a later pose.
    fn update_travel(&mut self, pose: &FramePose) {
        let start = self.start.iter_mut().map(|(_, since_start)| since_start);
        let contacts = self.contacts.iter_mut().filter_map(|contact| contact.active_since.as_mut());
        start.chain(&mut self.motion_travel).chain(contacts).for_each(|since| since.update_travel(pose));
    }
}

impl TrackerState {
    /// Updates the slip of the brakes and the travel of the object since the palm began to move.
    fn update_motion(&mut self, segment: &Segment<'_>, [from, to]: &[FramePose; 2]) {
        if self.setup.cycle.motion_start_s.is_some_and(|start| segment.from_s >= start) {
            self.history.motion_travel.get_or_insert(TravelSince::new(segment.from_s, *from)).update_travel(to);
        }
        for (side, brake_slip) in self.history.brake_slip.iter_mut().enumerate() {
            if self.setup.cycle.blocked_s[side].is_some_and(|start| segment.to_s >= start) {
                let angle = segment.next.fingers().nth(side).map_or(0.0, |finger| finger.q11_rad);
                let (first, largest) = brake_slip.get_or_insert((angle, 0.0));
                *largest = largest.max((angle - *first).abs());
            }
        }
    }

    /// Returns whether active phalanges are on both sides, by their normals at the end of a segment.
    fn has_contacts_on_both_sides(&self, next: &Sample) -> bool {
        let has_contact_from = |sign: f64| {
            let mut contacts = self.setup.contacts.iter().zip(&self.history.contacts).zip(next.contacts());
            contacts.any(|((id, history), contact)| {
                is_phalanx(*id) && history.active_since.is_some() && sign * contact.normal[0] > 0.0
            })
        };
        has_contact_from(1.0) && has_contact_from(-1.0)
    }

    /// Returns since when an unchanged set of active contacts force-closes the object; `None` if not, or too shortly.
    fn force_closed_since(&mut self, segment: &Segment<'_>) -> Option<f64> {
        let active = self.history.contacts.map(|contact| contact.active_since.is_some());
        if active != self.history.closure.active {
            self.history.closure = Closure { active, since_s: segment.from_s, last_evaluation_s: None, closed: false };
        }
        let Setup { contacts, thresholds, friction, object_m, closure_interval_s, .. } = &self.setup;
        let of_hand = contacts.iter().zip(active);
        let of_hand = of_hand.filter(|(id, active)| *active && (is_phalanx(**id) || **id == HandContact::Palm));
        let closure = &mut self.history.closure;
        if of_hand.count() < 2 || segment.to_s - closure.since_s < thresholds.held_time_s {
            return None;
        }
        if closure.last_evaluation_s.is_none_or(|last_s| segment.to_s - last_s >= *closure_interval_s) {
            let object = (self.setup.object(segment.next).centre_m, *object_m);
            let sampled = contacts.iter().copied().zip(segment.next.contacts()).zip(active);
            let sampled = sampled.filter(|(_, active)| *active).map(|(contact, _)| contact);
            closure.closed = selected_force_closure(friction, object, sampled).closed;
            closure.last_evaluation_s = Some(segment.to_s);
        }
        closure.closed.then_some(closure.since_s)
    }

    /// Updates whether the object is held at the end of a segment. `lost_s` is the time at which the contacts were lost
    /// whose loss has just become long enough to count.
    fn update_held(&mut self, segment: &Segment<'_>, lost_s: Option<f64>) {
        let held_time_s = self.setup.thresholds.held_time_s;
        let since_s = match self.has_contacts_on_both_sides(segment.next) {
            true => Some(segment.from_s),
            false => self.force_closed_since(segment),
        };
        match (since_s, self.history.held_since_s) {
            (Some(since_s), held_since_s) => {
                let held_since_s = held_since_s.unwrap_or(since_s);
                self.history.held_since_s = Some(held_since_s);
                self.history.grasped_s.get_or_insert(held_since_s);
                if segment.to_s - held_since_s >= held_time_s {
                    (self.history.was_held, self.history.dropped_s) = (true, None);
                }
            }
            (None, Some(held_since_s)) => {
                let ended_s = lost_s.unwrap_or(segment.from_s).max(held_since_s);
                self.history.held_since_s = None;
                if ended_s - held_since_s >= held_time_s {
                    self.history.dropped_s = Some(ended_s);
                }
            }
            (None, None) => {}
        }
    }

    /// Updates whether the object has left the reach of the fingers after a contact.
    fn update_ejection(&mut self, segment: &Segment<'_>) {
        let (Some(reach), true) = (self.setup.reach, segment.to_s == segment.next.time_s) else { return };
        let is_surface = |contact: &HandContact| !matches!(contact, HandContact::Finger(_, FingerContact::Limit));
        let contacts = self.setup.contacts.iter();
        let has_touched = contacts.zip(segment.has_touched).any(|(id, has_touched)| *has_touched && is_surface(id));
        let is_in_reach = !reach.is_outside(&self.setup.object(segment.next));
        if self.history.is_in_reach && !is_in_reach && has_touched {
            self.history.ejected_s.get_or_insert(segment.to_s);
        }
        self.history.is_in_reach = is_in_reach;
    }

    /// Returns the time since which the object is held at the end, if it is held for the required time.
    fn steadily_held_since_s(&self) -> Option<f64> {
        self.history
            .held_since_s
            .filter(|since_s| self.history.evaluated_until_s - since_s >= self.setup.thresholds.held_time_s)
    }

    fn fate(&self) -> Fate {
        match (self.history.ejected_s, self.steadily_held_since_s(), self.history.dropped_s) {
            (Some(at_s), _, _) => Fate::Ejected { at_s },
            (None, Some(_), _) => Fate::Held,
            (None, None, Some(since_s)) => Fate::Dropped { since_s },
            (None, None, None) => Fate::NotGrasped,
        }
    }
}

fn is_phalanx(id: HandContact) -> bool {
    matches!(id, HandContact::Finger(_, FingerContact::Proximal | FingerContact::Distal))
}

fn has_active_phalanx(contacts: &[HandContact], segment: &Segment<'_>) -> bool {
    contacts.iter().zip(segment.is_active).any(|(id, is_active)| *is_active && is_phalanx(*id))
}

impl SegmentObserver for TrackerState {
    /// Interpolants of x, y and the angle of the object.
    type Interpolant = [Hermite; 3];

    fn begin(&mut self, first: &Sample) {
        let object = self.setup.object(first);
        let pose = FramePose { position_m: object.centre_m, angle_rad: object.angle_rad };
        self.history.start = Some((object, TravelSince::new(first.time_s, pose)));
        self.history.is_in_reach = self.setup.reach.is_some_and(|reach| !reach.is_outside(&object));
    }

    fn interpolate(&mut self, last: &Sample, next: &Sample, cuts_s: &mut Vec<f64>) -> [Hermite; 3] {
        let ([from, to], [t0, t1]) = ([last, next].map(|sample| self.setup.object(sample)), [last.time_s, next.time_s]);
        let within = |time: &f64| *time > t0 && *time < t1;
        cuts_s
            .extend([self.setup.cycle.motion_start_s, self.setup.cycle.release_s].into_iter().flatten().filter(within));
        let along = |axis: usize| {
            Hermite::new(
                (t0, from.centre_m[axis], from.velocity_m_s[axis]),
                (t1, to.centre_m[axis], to.velocity_m_s[axis]),
            )
        };
        let angle = Hermite::new((t0, from.angle_rad, from.spin_rad_s), (t1, to.angle_rad, to.spin_rad_s));
        [along(0), along(1), angle]
    }

    fn observe(&mut self, [x, y, angle]: &[Hermite; 3], segment: &Segment<'_>) {
        let times = [segment.from_s, segment.to_s];
        let pose = |time| FramePose { position_m: [x.value(time), y.value(time)], angle_rad: angle.value(time) };
        let poses = times.map(pose);
        self.history.start.iter_mut().for_each(|(_, since_start)| since_start.update_travel(&poses[1]));
        self.update_ejection(segment);
        if self.setup.cycle.release_s.is_some_and(|end| segment.from_s >= end) {
            match has_active_phalanx(&self.setup.contacts, segment) {
                true => self.history.opened_s = None,
                false => _ = self.history.opened_s.get_or_insert(segment.from_s),
            }
            return;
        }
        self.history.evaluated_until_s = segment.to_s;
        self.update_motion(segment, &poses);
        let loss_time_s = self.setup.thresholds.loss_time_s;
        let mut lost_s: Option<f64> = None;
        for (index, contact) in self.history.contacts.iter_mut().enumerate() {
            let was_active = contact.active_since.is_some();
            contact.update((segment.has_touched[index], segment.is_active[index]), times, &poses, loss_time_s);
            if was_active && contact.active_since.is_none() {
                lost_s = [lost_s, contact.inactive_since_s].into_iter().flatten().reduce(f64::min);
            }
        }
        self.update_held(segment, lost_s);
        // Steps of a smooth motion are long.
        let length_s = segment.to_s - segment.from_s;
        let inner = (length_s / self.setup.travel_interval_s).min(MAX_TRAVELS_PER_SEGMENT) as u32;
        for k in 1..=inner {
            self.history.update_travel(&pose(segment.from_s + length_s * f64::from(k) / f64::from(inner + 1)));
        }
    }
}

/// Pose of the object at an instant, and its largest travel since.
#[derive(Clone, Copy, Debug)]
struct TravelSince {
    time_s: f64,
    pose: FramePose,
    travel: Travel,
}

impl TravelSince {
    fn new(time_s: f64, pose: FramePose) -> Self {
        TravelSince { time_s, pose, travel: Travel::default() }
    }

    /// Extends the travel to a later pose.
    fn update_travel(&mut self, pose: &FramePose) {
        let Travel { displacement_m, rotation_rad } = &mut self.travel;
        let [dx, dy] = [0, 1].map(|axis| pose.position_m[axis] - self.pose.position_m[axis]);
        *displacement_m = displacement_m.max(hypot(dx, dy));
        *rotation_rad = rotation_rad.max((pose.angle_rad - self.pose.angle_rad).abs());
    }
}

/// History of one contact up to the present.
#[derive(Clone, Copy, Debug, Default)]
struct ContactHistory {
    first_contact_s: Option<f64>,
    /// Start of the current active interval, and the travel since; short losses do not end the interval. Each contact
    /// records its own travel, because the contact that became active last is known only at the end of the run.
    active_since: Option<TravelSince>,
    was_active: bool,
    /// Start of the current loss. A loss shorter than the threshold keeps [`ContactHistory::active_since`].
    inactive_since_s: Option<f64>,
    times_lost: u32,
    lost_s: f64,
}

impl ContactHistory {
    /// Adds a segment of the run. A loss shorter than `loss_time_s` does not count.
    fn update(
        &mut self,
        (has_touched, is_active): (bool, bool),
        [from_s, to_s]: [f64; 2],
        [from, to]: &[FramePose; 2],
        loss_time_s: f64,
    ) {
        if has_touched {
            self.first_contact_s.get_or_insert(from_s);
        }
        if is_active {
            (self.was_active, self.inactive_since_s) = (true, None);
            self.active_since.get_or_insert(TravelSince::new(from_s, *from)).update_travel(to);
        } else if self.was_active {
            let inactive_since_s = *self.inactive_since_s.get_or_insert(from_s);
            match &mut self.active_since {
                Some(since) if to_s - inactive_since_s < loss_time_s => since.update_travel(to),
                Some(_) => {
                    self.active_since = None;
                    self.times_lost += 1;
                    self.lost_s += to_s - inactive_since_s;
                }
                None => self.lost_s += to_s - from_s,
            }
        }
    }
}

impl GraspTracker {
    /// Creates a tracker for runs of a gripper's scene.
    pub fn for_scene(scene: &Scene) -> Self {
        let thresholds = scene.thresholds;
        let (hand, object) = (&scene.hand, scene.hand.grasped());
        let fixed = BodyState { centre_m: object.centre_m, angle_rad: object.angle_rad, ..BodyState::default() };
        Self::new(Setup {
            contacts: hand.contacts().collect(),
            fixed_object: hand.moving_object().is_none().then_some(fixed),
            thresholds,
            cycle: scene.cycle(),
            reach: Reach::from_hand(hand),
            friction: friction_coefficients(scene),
            object_m: shape::max_radius(&object.shape),
            closure_interval_s: thresholds.held_time_s.max(CLOSURE_INTERVAL_FRACTION * scene.duration_s),
            travel_interval_s: scene.duration_s / TRAVELS_PER_RUN,
        })
    }

    /// Sets the time from which the travel during the palm motion counts; motion before it is preparation.
    #[must_use]
    pub fn with_motion_start(mut self, start_s: f64) -> Self {
        self.state.setup.cycle.motion_start_s = Some(start_s);
        self
    }

    fn new(setup: Setup) -> Self {
        let segments = SegmentSplitter::new(0..CONTACT_COUNT, Some(setup.thresholds.loss_force_n));
        GraspTracker { segments, state: TrackerState { setup, history: History::default() } }
    }

    /// Returns the criteria of the run up to the last sample; `None` without samples.
    pub fn criteria(&self) -> Option<GraspCriteria> {
        let (state, history) = (&self.state, &self.state.history);
        let (start, since_start) = history.start.as_ref()?;
        let surfaces = || {
            let all = state.setup.contacts.iter().copied().zip(&history.contacts);
            all.filter(|(id, _)| !matches!(id, HandContact::Finger(_, FingerContact::Limit)))
        };
        let last =
            surfaces().filter_map(|(_, contact)| contact.active_since).max_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let stable = last.filter(|_| state.steadily_held_since_s().is_some());
        let end = self.segments.last()?;
        // A run can end before these times, for example when the object is ejected.
        let reached = |time_s: &f64| *time_s <= end.time_s;
        let criteria = |(id, contact): (HandContact, &ContactHistory)| ContactCriteria {
            id,
            first_contact_s: contact.first_contact_s,
            active_since_s: contact.active_since.map(|since| since.time_s),
            times_lost: contact.times_lost,
            lost_s: contact.lost_s,
        };
        Some(GraspCriteria {
            contacts: surfaces().map(criteria).collect(),
            tts_s: stable.map(|since| since.time_s),
            grasped_s: history.grasped_s.filter(|_| history.was_held),
            held_since_s: history.held_since_s,
            fate: state.fate(),
            start: *start,
            end: state.setup.object(end),
            travel: since_start.travel,
            slip: stable.map(|since| since.travel),
            cycle: CycleCriteria {
                motion_start_s: state.setup.cycle.motion_start_s.filter(reached),
                release_s: state.setup.cycle.release_s.filter(reached),
                motion_travel: history.motion_travel.map(|since| since.travel),
                opened_s: history.opened_s,
                brake_slip_rad: history.brake_slip.map(|brake_slip| brake_slip.map(|(_, largest)| largest)),
            },
        })
    }
}

impl Sink for GraspTracker {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::criteria::fate_reason;
    use crate::scene::Side;
    use crate::trace::{ContactSample, EventKind};

    const RADIUS_M: f64 = 0.02;
    const RIGHT: HandContact = HandContact::Finger(Side::Right, FingerContact::Proximal);
    const LEFT: HandContact = HandContact::Finger(Side::Left, FingerContact::Proximal);
    const RIGHT_TIP: HandContact = HandContact::Finger(Side::Right, FingerContact::Distal);
    const RIGHT_LIMIT: HandContact = HandContact::Finger(Side::Right, FingerContact::Limit);

    fn index(id: HandContact) -> usize {
        HandContact::ALL.iter().position(|other| *other == id).expect("one of all")
    }

    fn at_rest(x: f64) -> BodyState {
        BodyState { centre_m: [x, RADIUS_M], ..BodyState::default() }
    }

    /// A run of 1 s with a sample every 0.1 s. Contacts are active in the given intervals, with 5 N.
    struct Run {
        active: Vec<(HandContact, f64, f64)>,
        object: fn(f64) -> BodyState,
        thresholds: Thresholds,
        mu: f64,
        /// Normal force of the palm over time, N.
        palm_n: fn(f64) -> f64,
    }

    impl Default for Run {
        fn default() -> Self {
            Run { active: Vec::new(), object: |_| at_rest(0.0), thresholds: Thresholds::NONE, mu: 0.0, palm_n: |_| 5.0 }
        }
    }

    impl Run {
        fn sample(&self, time_s: f64) -> Sample {
            let contact = |id: HandContact| {
                let normal = match id {
                    HandContact::Finger(Side::Right, _) => [0.8, 0.6],
                    HandContact::Finger(Side::Left, _) => [-0.8, 0.6],
                    HandContact::Palm => [0.0, -1.0],
                    HandContact::Table => [0.0, 1.0],
                };
                let is_active =
                    |&(other, from, to): &(HandContact, f64, f64)| other == id && from < time_s && time_s < to;
                let force = if id == HandContact::Palm { (self.palm_n)(time_s) } else { 5.0 };
                let normal_n = if self.active.iter().any(is_active) { force } else { 0.0 };
                // Contact points on the surface of the object; normals point away from the object.
                let [cx, cy] = (self.object)(time_s).centre_m;
                let point_m = [cx + RADIUS_M * normal[0], cy + RADIUS_M * normal[1]];
                ContactSample { gap_m: 1e-3 * (1.0 - normal_n), normal_n, normal, point_m, ..ContactSample::NONE }
            };
            let contacts = HandContact::ALL.map(contact).to_vec();
            Sample::of(time_s, &[], &[(self.object)(time_s)], &contacts)
        }

        fn evaluate(&self) -> GraspCriteria {
            let mut events = Vec::new();
            for &(id, from, to) in &self.active {
                let event =
                    |time_s, kind| Event { time_s, contact: index(id), kind, approach_speed: 0.0, impulse: 0.0 };
                events.extend([event(from, EventKind::TouchDown), event(to, EventKind::LiftOff)]);
            }
            events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
            let mut events = events.iter().peekable();
            let reach = Reach { joints_m: [[0.0155, 0.0], [-0.0155, 0.0]], radii_m: [0.04; 2], object_m: RADIUS_M };
            let mut tracker = GraspTracker::new(Setup {
                contacts: HandContact::ALL.to_vec(),
                fixed_object: None,
                thresholds: self.thresholds,
                cycle: Cycle::default(),
                reach: Some(reach),
                friction: PerContact { phalanges: [[self.mu; 2]; 2], palm: self.mu },
                object_m: RADIUS_M,
                closure_interval_s: 0.1,
                travel_interval_s: 0.1,
            });
            assert_eq!(tracker.criteria(), None, "no samples yet");
            for time_s in (0..=10).map(|i| 0.1 * f64::from(i)) {
                while let Some(event) = events.next_if(|event| event.time_s <= time_s) {
                    tracker.event(event).expect("accepted");
                }
                tracker.sample(&self.sample(time_s)).expect("accepted");
            }
            tracker.criteria().expect("a run")
        }
    }

    fn run(active: &[(HandContact, f64, f64)], object: fn(f64) -> BodyState) -> GraspCriteria {
        Run { active: active.to_vec(), object, ..Run::default() }.evaluate()
    }

    fn contact_criteria(criteria: &GraspCriteria, id: HandContact) -> ContactCriteria {
        *criteria.contacts.iter().find(|contact| contact.id == id).expect("no joint limit")
    }

    #[test]
    fn time_to_stability_is_the_onset_of_the_last_active_contact() {
        let found = run(
            &[
                (RIGHT, 0.22, 2.0),
                (LEFT, 0.33, 0.47),
                (LEFT, 0.52, 2.0),
                (RIGHT_TIP, 0.61, 0.83),
                (RIGHT_LIMIT, 0.0, 0.7),
            ],
            |_| at_rest(0.0),
        );
        assert_eq!((found.fate, found.grasped_s, found.tts_s), (Fate::Held, Some(0.33), Some(0.52)));
        let ids: Vec<HandContact> = found.contacts.iter().map(|contact| contact.id).collect();
        assert_eq!(ids.len(), 6, "no joint limits among {ids:?}");
        let left = contact_criteria(&found, LEFT);
        assert_eq!((left.first_contact_s, left.active_since_s, left.times_lost), (Some(0.33), Some(0.52), 1));
        assert!((left.lost_s - 0.05).abs() < 1e-12, "{left:?}");
        let tip = contact_criteria(&found, RIGHT_TIP);
        assert_eq!((tip.first_contact_s, tip.active_since_s, tip.times_lost), (Some(0.61), None, 1));
        assert!((tip.lost_s - 0.17).abs() < 1e-12, "lost until the end: {tip:?}");
        let table = contact_criteria(&found, HandContact::Table);
        assert_eq!((table.first_contact_s, table.active_since_s, table.times_lost, table.lost_s), (None, None, 0, 0.0));
    }

    #[test]
    fn an_active_table_contact_counts_for_time_to_stability() {
        let found = run(&[(RIGHT, 0.22, 2.0), (LEFT, 0.33, 2.0), (HandContact::Table, 0.71, 2.0)], |_| at_rest(0.0));
        assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.71)));
    }

    #[test]
    fn contacts_on_one_side_or_above_and_below_are_no_grasp() {
        for active in [
            &[(RIGHT, 0.2, 2.0), (RIGHT_TIP, 0.3, 2.0), (HandContact::Palm, 0.0, 2.0), (HandContact::Table, 0.0, 2.0)]
                [..],
            &[(RIGHT, 0.2, 0.4), (LEFT, 0.5, 2.0)],
            &[],
        ] {
            let found = run(active, |_| at_rest(0.0));
            assert_eq!((found.fate, found.grasped_s, found.tts_s, found.slip), (Fate::NotGrasped, None, None, None));
        }
    }

    #[test]
    fn an_object_released_at_the_end_is_dropped() {
        let found = run(&[(RIGHT, 0.2, 2.0), (LEFT, 0.3, 0.44), (LEFT, 0.51, 0.77)], |_| at_rest(0.0));
        assert_eq!((found.fate, found.tts_s), (Fate::Dropped { since_s: 0.77 }, None));
    }

    #[test]
    fn an_object_that_moves_far_while_held_is_held() {
        let slides =
            |t: f64| BodyState { velocity_m_s: [0.0, -0.05], centre_m: [0.0, 0.07 - 0.05 * t], ..at_rest(0.0) };
        let found = run(&[(RIGHT, 0.2, 2.0), (LEFT, 0.3, 2.0)], slides);
        assert_eq!((found.fate, found.tts_s, found.held_since_s), (Fate::Held, Some(0.3), Some(0.3)));
        assert!((found.travel.displacement_m - 0.05).abs() < 1e-12);
    }

    /// Leaves the reach at a height of 57.96 mm, at 0.3796 s.
    fn thrown_object(t: f64) -> BodyState {
        BodyState { velocity_m_s: [0.0, 0.1], centre_m: [0.0, 0.02 + 0.1 * t], ..at_rest(0.0) }
    }

    #[test]
    fn an_object_that_leaves_the_reach_after_a_contact_is_ejected() {
        let found = run(&[(RIGHT, 0.02, 0.18), (LEFT, 0.02, 0.18)], thrown_object);
        assert_eq!((found.fate, found.grasped_s), (Fate::Ejected { at_s: 0.4 }, Some(0.02)));
        // Without a contact, or with a contact out of reach, it is not ejected.
        assert_eq!(run(&[], thrown_object).fate, Fate::NotGrasped);
        assert_eq!(run(&[(HandContact::Table, 0.71, 0.83)], thrown_object).fate, Fate::NotGrasped);
    }

    #[test]
    fn an_object_that_starts_out_of_reach_is_not_ejected() {
        let receding_object =
            |t: f64| BodyState { centre_m: [0.0, 0.3 + 0.1 * t], velocity_m_s: [0.0, 0.1], ..at_rest(0.0) };
        assert_eq!(run(&[(HandContact::Table, 0.0, 2.0)], receding_object).fate, Fate::NotGrasped);
    }

    #[test]
    fn losses_shorter_than_the_threshold_do_not_count() {
        let thresholds = Thresholds { loss_time_s: 0.06, ..Thresholds::NONE };
        let active = vec![(RIGHT, 0.22, 2.0), (LEFT, 0.33, 0.47), (LEFT, 0.52, 0.71), (LEFT, 0.78, 2.0)];
        let found = Run { active, thresholds, ..Run::default() }.evaluate();
        let left = contact_criteria(&found, LEFT);
        assert_eq!(
            (left.times_lost, left.active_since_s),
            (1, Some(0.78)),
            "a loss of 0.05 s does not count, one of 0.07 s does"
        );
        assert!((left.lost_s - 0.07).abs() < 1e-12, "{left:?}");
        assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.78)));
        // A short loss at the end does not end the grasp.
        let active = vec![(RIGHT, 0.22, 2.0), (LEFT, 0.33, 0.97)];
        let found = Run { active, thresholds, ..Run::default() }.evaluate();
        assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.33)));
    }

    #[test]
    fn contacts_below_the_force_threshold_are_not_active() {
        let thresholds = Thresholds { loss_force_n: 1.0, ..Thresholds::NONE };
        let active = vec![(RIGHT, 0.22, 2.0), (LEFT, 0.33, 2.0), (HandContact::Palm, 0.05, 2.0)];
        // The force of the palm exceeds 1 N from 0.1 s to 0.55 s.
        let palm_n = |t: f64| if t < 0.5 { 10.0 * t } else { 5.5 - 9.0 * (t - 0.05) };
        let found = Run { active: active.clone(), thresholds, palm_n, ..Run::default() }.evaluate();
        let palm = contact_criteria(&found, HandContact::Palm);
        assert_eq!((palm.times_lost, palm.active_since_s), (1, None), "{palm:?}");
        assert!((palm.lost_s - 0.45).abs() < 0.02, "{palm:?}");
        assert_eq!(found.tts_s, Some(0.33), "inactive contacts do not count");
        let found = Run { active, thresholds: Thresholds::NONE, palm_n: |_| 1e-9, ..Run::default() }.evaluate();
        assert_eq!(contact_criteria(&found, HandContact::Palm).active_since_s, Some(0.05));
    }

    #[test]
    fn an_object_is_held_only_after_the_required_time() {
        let thresholds = Thresholds { held_time_s: 0.3, ..Thresholds::NONE };
        let fate = |active: &[(HandContact, f64, f64)]| {
            Run { active: active.to_vec(), thresholds, ..Run::default() }.evaluate()
        };
        let short = fate(&[(RIGHT, 0.2, 2.0), (LEFT, 0.8, 2.0)]);
        assert_eq!((short.fate, short.tts_s, short.grasped_s), (Fate::NotGrasped, None, None));
        assert_eq!(short.held_since_s, Some(0.8));
        assert_eq!(fate(&[(RIGHT, 0.2, 2.0), (LEFT, 0.7, 2.0)]).fate, Fate::Held);
        let again = fate(&[(RIGHT, 0.2, 2.0), (LEFT, 0.2, 0.6), (LEFT, 0.8, 2.0)]);
        assert_eq!((again.fate, again.grasped_s), (Fate::Dropped { since_s: 0.6 }, Some(0.2)));
        assert_eq!(
            fate_reason(&again, 0.3),
            "no longer held from 600.000000 ms on; held again only from 800.000000 ms on, less than 300.000000 ms"
        );
        assert_eq!(fate(&[(RIGHT, 0.2, 2.0), (LEFT, 0.2, 0.4), (LEFT, 0.5, 0.7)]).fate, Fate::NotGrasped);
    }

    #[test]
    fn one_finger_and_the_palm_hold_by_force_closure_with_enough_friction() {
        // The angle between the normals is 127°. Both friction cones contain the line between the contacts from a half
        // angle of 26.6°.
        let thresholds = Thresholds { held_time_s: 0.2, ..Thresholds::NONE };
        let active = vec![(RIGHT, 0.2, 2.0), (HandContact::Palm, 0.0, 2.0)];
        let fate = |mu: f64| Run { active: active.clone(), thresholds, mu, ..Run::default() }.evaluate().fate;
        assert_eq!(fate(0.55), Fate::Held);
        assert_eq!(fate(0.45), Fate::NotGrasped);
        let lost = vec![(RIGHT, 0.2, 0.75), (HandContact::Palm, 0.0, 2.0)];
        let found = Run { active: lost, thresholds, mu: 0.55, ..Run::default() }.evaluate();
        assert_eq!((found.fate, found.grasped_s), (Fate::Dropped { since_s: 0.75 }, Some(0.2)));
    }

    #[test]
    fn slip_counts_from_stability_and_travel_from_the_start() {
        // Moves by 3 mm until 0.5 s, then turns and moves back by 1 mm.
        let moved = |t: f64| match t < 0.5 {
            true => BodyState { velocity_m_s: [-6e-3, 0.0], ..at_rest(3.5e-3 - 6e-3 * t) },
            false => BodyState {
                velocity_m_s: [2e-3, 0.0],
                spin_rad_s: -0.2,
                angle_rad: -0.2 * (t - 0.5),
                ..at_rest(0.5e-3 + 2e-3 * (t - 0.5))
            },
        };
        let found = run(&[(RIGHT, 0.15, 2.0), (LEFT, 0.5, 2.0)], moved);
        assert_eq!(found.tts_s, Some(0.5));
        let slip = found.slip.expect("a grasp");
        assert!((slip.displacement_m - 1e-3).abs() < 1e-12 && (slip.rotation_rad - 0.1).abs() < 1e-12, "{slip:?}");
        assert!((found.travel.displacement_m - 3e-3).abs() < 1e-12, "{:?}", found.travel);
        assert!((found.travel.rotation_rad - 0.1).abs() < 1e-12, "{:?}", found.travel);
        assert!((found.offset_ratio().expect("it was off centre") - 1.5 / 3.5).abs() < 1e-12);
        assert!((found.end_speed_m_s() - 2e-3).abs() < 1e-15);
        assert_eq!(run(&[], |_| at_rest(1e-10)).offset_ratio(), None);
    }
}
