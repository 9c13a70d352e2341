//! The tracker: from samples and events to points, pairs and poses in parts of the run in which nothing changes.

use std::collections::VecDeque;
use std::ops::Range;

use super::actuators::ActuatorCriteria;
use super::cycle::CycleHistory;
use super::fate::{Evidence, Fate};
use super::grip::{Edges, GripSearch};
use super::hold::{HoldHistory, Part};
use super::object::{ObjectCriteria, Slip};
use super::pairs::{PairHistory, PairPoint, pair_at_end};
use super::pose::{BodyMotion, Frame, RelativePose, pose_of, relative};
use super::recent::{Instant, Recent, RecentRates};
use crate::criteria::segments::{Hermite, Segment, SegmentObserver, SegmentSplitter};
use crate::mechanism::Mechanism;
use crate::numeric::elementary::hypot;
use crate::numeric::plane::{add, rotate};
use crate::scene::{Scene, Thresholds};
use crate::statics::{GraspRoles, WrenchHull};
use crate::trace::{
    BOUNDARY_TOLERANCE, BodyState, ContactSample, Event, Reach, RequiredData, Sample, Sink, SinkError, interpolate,
};

/// A gap below this part of the extent of the object is near; motion by it within `held_time` is slow.
const SMALL: f64 = 1e-3;

/// A [`Sink`] that computes the [`ObjectCriteria`] of a run. Its memory grows only with the number of changes.
#[derive(Clone, Debug)]
pub struct ObjectTracker {
    segments: SegmentSplitter,
    state: State,
}

/// Settings of the criteria.
#[derive(Clone, Debug)]
struct Setup {
    mechanism: Mechanism,
    roles: GraspRoles,
    thresholds: Thresholds,
    release_s: Option<f64>,
    /// Region that the fingers of a five-bar hand can reach; `None` if the object cannot be ejected.
    reach: Option<Reach>,
    object: Frame,
    base: Frame,
    ground: Frame,
    com_m: [f64; 2],
    /// Points of all pairs: those of one pair follow each other.
    points: Vec<PairPoint>,
    /// Pair of each point, and the points of each pair.
    pair_of: Vec<usize>,
    points_of: Vec<Range<usize>>,
}

#[derive(Clone, Debug)]
struct State {
    setup: Setup,
    hold: HoldHistory,
    grip: GripSearch,
    /// Parts whose active points are not known yet: a loss at their time may prove short.
    queue: VecDeque<Slice>,
    /// Memory for the active points of a part, and for the edges of the next parts.
    active: Vec<bool>,
    spare: Vec<Vec<Option<Edges>>>,
    points: Vec<PointState>,
    pairs: Vec<PairHistory>,
    recent: Recent,
    actuators: Vec<ActuatorCriteria>,
    cycle: CycleHistory,
    /// The object in the first sample.
    start: BodyState,
    /// Whether the fingers can reach the object in the last sample, and the time at which it left their reach.
    is_in_reach: bool,
    ejected_s: Option<f64>,
    /// Whether the hand has touched the object, and the time at which the object left it, also after the release.
    has_touched: bool,
    left_s: Option<f64>,
    /// The sample at the release.
    released: Option<Sample>,
}

/// A point at the start of the queue.
#[derive(Clone, Copy, Debug, Default)]
struct PointState {
    is_active: bool,
    lost_since_s: Option<f64>,
    /// Its edges when it last pressed.
    edges: Option<Edges>,
}

/// A part of a run.
#[derive(Clone, Debug)]
struct Slice {
    from_s: f64,
    to_s: f64,
    poses: [RelativePose; 2],
    /// Whether each point presses, and its edges then.
    presses: Vec<Option<Edges>>,
    is_hand_near: bool,
    are_surroundings_near: bool,
    are_surroundings_active: bool,
}

/// Motions of object and base between two samples.
struct Motions {
    object: BodyMotion,
    base: BodyMotion,
}

impl Motions {
    fn pose(&self, com_m: [f64; 2], time_s: f64) -> RelativePose {
        relative(self.object.at(time_s), com_m, self.base.at(time_s))
    }
}

impl Setup {
    /// Largest extent of the object.
    fn extent_m(&self) -> f64 {
        2.0 * self.roles.radius_m
    }

    /// Largest slow speed of the object; infinite without a `held_time`.
    fn slow_m_s(&self) -> f64 {
        let held_time_s = self.thresholds.held_time_s;
        if held_time_s > 0.0 { SMALL * self.extent_m() / held_time_s } else { f64::INFINITY }
    }

    fn is_hand(&self, point: usize) -> bool {
        self.roles.pairs[self.pair_of[point]].is_hand
    }

    /// The body of a point that is not the object; `None` is the ground.
    fn other(&self, point: usize) -> Option<usize> {
        self.roles.pairs[self.pair_of[point]].other.body
    }

    fn states(&self, sample: &Sample) -> [BodyState; 3] {
        let [object, base] = [self.object, self.base].map(|frame| frame.state(&self.mechanism, sample));
        let ground = if self.ground == self.base { base } else { self.ground.state(&self.mechanism, sample) };
        [object, base, ground]
    }
}

impl ObjectTracker {
    /// Creates a tracker for runs of a scene; `None` if the scene has no grasp.
    pub fn for_scene(scene: &Scene) -> Option<Self> {
        let roles = scene.grasp_roles().ok()?;
        let mechanism = &*scene.judged_mechanism();
        let all = mechanism.point_contacts();
        let indices = roles.pairs.iter().enumerate().flat_map(|(pair, of)| of.points.iter().map(move |k| (pair, *k)));
        let (pair_of, contacts): (Vec<usize>, Vec<usize>) = indices.unzip();
        let point = |index: &usize| PairPoint::new(roles.object, *index, &mechanism.contacts[all[*index].pair]);
        let laws = contacts.iter().map(|index| mechanism.contacts[all[*index].pair].law.normal).collect();
        let setup = Setup {
            thresholds: scene.thresholds,
            release_s: scene.grasp_keys().and_then(|keys| keys.release_s),
            reach: Reach::from_hand(&scene.hand),
            object: Frame::of_object(scene, mechanism, roles.object),
            base: Frame::of(mechanism, roles.base),
            ground: Frame::of(mechanism, None),
            com_m: mechanism.bodies[roles.object].com_m,
            points: contacts.iter().map(point).collect(),
            points_of: (0..roles.pairs.len())
                .map(|pair| {
                    let first = pair_of.partition_point(|other| *other < pair);
                    first..first + roles.pairs[pair].points.len()
                })
                .collect(),
            pair_of,
            mechanism: mechanism.clone(),
            roles,
        };
        let Thresholds { loss_time_s, loss_force_n, held_time_s } = setup.thresholds;
        Some(ObjectTracker {
            segments: SegmentSplitter::new(contacts, Some(loss_force_n)).with_laws(laws),
            state: State {
                hold: HoldHistory::new(loss_time_s, held_time_s),
                grip: GripSearch::default(),
                queue: VecDeque::new(),
                active: Vec::new(),
                spare: Vec::new(),
                points: vec![PointState::default(); setup.points.len()],
                pairs: vec![PairHistory::default(); setup.roles.pairs.len()],
                recent: Recent::default(),
                actuators: ActuatorCriteria::of(mechanism),
                cycle: CycleHistory::new(mechanism, setup.release_s, scene.duration_s),
                start: BodyState::default(),
                is_in_reach: false,
                ejected_s: None,
                has_touched: false,
                left_s: None,
                released: None,
                setup,
            },
        })
    }

    /// Sets the time from which on the travel during the motion of the palm is measured. Earlier motion counts as
    /// preparation.
    #[must_use]
    pub fn with_motion_start(mut self, start_s: f64) -> Self {
        self.state.cycle.set_motion_start(start_s);
        self
    }

    /// Returns the criteria of the run up to the last sample, or up to the release; `None` for a run without duration.
    pub fn criteria(&self) -> Option<ObjectCriteria> {
        let last = self.segments.last()?;
        let mut state = self.state.clone();
        state.process(true);
        state.finish(last)
    }
}

impl State {
    /// Passes on the parts whose active points are known; at the end of the run, a loss that is unfinished and short is none.
    fn process(&mut self, is_end: bool) {
        let Some(now_s) = self.queue.back().map(|slice| slice.to_s) else { return };
        while self.find_active_points(now_s, is_end) {
            let Some(slice) = self.queue.pop_front() else { return };
            let active = std::mem::take(&mut self.active);
            for (point, (presses, is_active)) in self.points.iter_mut().zip(slice.presses.iter().zip(&active)) {
                point.lost_since_s = match (is_active, presses) {
                    (true, None) => point.lost_since_s.or(Some(slice.from_s)),
                    _ => None,
                };
                point.is_active = *is_active;
                point.edges = presses.or(point.edges);
            }
            self.add(&slice, &active);
            self.active = active;
            self.spare.push(slice.presses);
        }
    }

    /// Finds whether each point of the hand is active in the first part of the queue; returns whether this is known.
    fn find_active_points(&mut self, now_s: f64, is_end: bool) -> bool {
        let Some(first) = self.queue.front() else { return false };
        let loss_time_s = self.setup.thresholds.loss_time_s;
        let is_active = |(index, point): (usize, &PointState)| {
            if first.presses[index].is_some() || !point.is_active {
                return Some(first.presses[index].is_some());
            }
            let lost_since_s = point.lost_since_s.unwrap_or(first.from_s);
            let again = self.queue.iter().find(|slice| slice.presses[index].is_some());
            match again {
                Some(slice) => Some(slice.from_s - lost_since_s < loss_time_s),
                None if now_s - lost_since_s >= loss_time_s => Some(false),
                None => is_end.then_some(true),
            }
        };
        self.active.clear();
        for of_point in self.points.iter().enumerate() {
            let Some(is_active) = is_active(of_point) else { return false };
            self.active.push(is_active);
        }
        true
    }

    fn add(&mut self, slice: &Slice, active: &[bool]) {
        let Self { points, setup, grip, .. } = self;
        let edges = |(index, is_active): (usize, &bool)| {
            let edges = points[index].edges.filter(|_| *is_active && setup.is_hand(index))?;
            Some((index, edges))
        };
        let (is_gripped, changed_s) = grip.evaluate(slice.to_s, active.iter().enumerate().filter_map(edges));
        let changed_s = changed_s.map(|changed_s| changed_s.clamp(slice.from_s, slice.to_s));
        let pose_at = |time_s: f64| {
            let fraction = (time_s - slice.from_s) / (slice.to_s - slice.from_s);
            let [from, to] = slice.poses;
            std::array::from_fn(|k| from[k] + fraction * (to[k] - from[k]))
        };
        let parts = match changed_s {
            Some(changed_s) => {
                [Some((slice.from_s, changed_s, !is_gripped)), Some((changed_s, slice.to_s, is_gripped))]
            }
            None => [Some((slice.from_s, slice.to_s, is_gripped)), None],
        };
        for (from_s, to_s, is_gripped) in parts.into_iter().flatten() {
            if to_s > from_s {
                self.hold.add(&Part {
                    from_s,
                    to_s,
                    is_gripped,
                    is_hand_near: slice.is_hand_near,
                    are_surroundings_near: slice.are_surroundings_near,
                    are_surroundings_active: slice.are_surroundings_active,
                    pose: pose_at(from_s),
                });
            }
        }
    }

    /// The contact of a point between two samples.
    fn edges(&self, point: usize, last: &Sample, next: &Sample, object: &BodyState) -> Option<Edges> {
        let found = self.setup.points[point];
        let [before, after] = [last, next].map(|sample| sample.contact(found.contact));
        let contact = if is_located(&after) { after } else { before };
        if !is_located(&contact) {
            return self.points[point].edges;
        }
        let (sin, cos) = crate::numeric::elementary::sin_cos(object.angle_rad);
        let centre_m = add(object.centre_m, rotate(self.setup.com_m, [cos, sin]));
        Some(WrenchHull::edges_of(&found.friction_contact(&contact), centre_m, self.setup.roles.radius_m))
    }

    /// Finds the time at which the object leaves the hand in the step between two samples.
    fn search_leaving(&mut self, last: &Sample, next: &Sample) {
        if self.left_s.is_some() || !self.has_touched {
            return;
        }
        let hand = || (0..self.setup.points.len()).filter(|point| self.setup.is_hand(*point));
        let nearest = |sample: &Sample| {
            let gaps = hand().map(|point| sample.gap(self.setup.points[point].contact));
            gaps.min_by(|[a, _], [b, _]| a.total_cmp(b))
        };
        // Within the tolerance with which a run ends there.
        let extent_m = (1.0 - BOUNDARY_TOLERANCE) * self.setup.extent_m();
        // Most often a point of the hand is near.
        if hand().any(|point| next.gap(self.setup.points[point].contact)[0] < extent_m) {
            return;
        }
        let Some(after @ [gap_m, rate_m_s]) = nearest(next) else { return };
        let mut others = (0..self.setup.points.len()).filter(|point| !self.setup.is_hand(*point));
        if gap_m < extent_m
            || rate_m_s < 0.0
            || others.any(|point| next.normal_n(self.setup.points[point].contact) > 0.0)
        {
            return;
        }
        let mut times = Vec::new();
        if let Some(before) = nearest(last).filter(|[gap_m, _]| *gap_m < extent_m && after[0].is_finite()) {
            let gap = Hermite::new((last.time_s, before[0], before[1]), (next.time_s, after[0], after[1]));
            gap.crossings(extent_m, &mut times);
        }
        self.left_s = Some(times.last().copied().unwrap_or(next.time_s));
    }

    /// Updates whether the object has left the reach of the fingers after a contact, at the end of a step.
    fn update_reach(&mut self, next: &Sample, has_touched: bool) {
        let Some(reach) = self.setup.reach else { return };
        let is_in_reach = !reach.is_outside(&self.setup.object.state(&self.setup.mechanism, next));
        if self.is_in_reach && !is_in_reach && has_touched {
            self.ejected_s.get_or_insert(next.time_s);
        }
        self.is_in_reach = is_in_reach;
    }

    /// Adds the state at the end of a step.
    fn add_instant(&mut self, last: Option<&Sample>, next: &Sample) {
        let [object, base, ground] = self.setup.states(next);
        let mut slid_m =
            self.recent.last().map_or_else(|| vec![0.0; self.setup.points.len()], |last| last.slid_m.clone());
        if let Some(last) = last {
            for (slid_m, point) in slid_m.iter_mut().zip(&self.setup.points) {
                let speed = |sample: &Sample| sample.slip_m_s(point.contact);
                *slid_m += 0.5 * (speed(last) + speed(next)) * (next.time_s - last.time_s);
            }
        }
        let instant = Instant { time_s: next.time_s, object, base, ground, slid_m };
        self.recent.add(instant, self.setup.thresholds.held_time_s);
        ActuatorCriteria::add(&mut self.actuators, &self.setup.mechanism, last, next);
    }

    /// Returns the criteria of a run that ends with a sample.
    fn finish(&self, last: &Sample) -> Option<ObjectCriteria> {
        let end = self.released.as_ref().unwrap_or(last);
        let Setup { mechanism, roles, thresholds, com_m, .. } = &self.setup;
        let Thresholds { loss_force_n, held_time_s, .. } = *thresholds;
        self.hold.end_state()?;
        let [object, base, _] = self.setup.states(end);
        let rates = self.recent.rates(*com_m, held_time_s).unwrap_or_else(|| RecentRates {
            sliding_m_s: vec![0.0; self.setup.points.len()],
            ..RecentRates::default()
        });
        let slow_m_s = self.setup.slow_m_s();
        let pair = |(index, pair): (usize, &crate::statics::GraspPair)| {
            let of_pair = self.setup.points_of[index].clone();
            let points: Vec<PairPoint> = of_pair.clone().map(|point| self.setup.points[point]).collect();
            let force_n = |point: usize| end.contact(self.setup.points[point].contact).normal_n;
            let mut active = of_pair.filter(|point| force_n(*point) > loss_force_n);
            let is_sliding = match active.next() {
                Some(first) => std::iter::once(first).chain(active).all(|point| rates.sliding_m_s[point] > slow_m_s),
                None => false,
            };
            pair_at_end((pair, &self.pairs[index]), &points, (end, &object), is_sliding)
        };
        let pairs: Vec<_> = roles.pairs.iter().enumerate().map(pair).collect();
        let is_slow = |[vx, vy, spin]: RelativePose| hypot(vx, vy).max(roles.radius_m * spin.abs()) < slow_m_s;
        let speed = |[vx, vy, _]: RelativePose| hypot(vx, vy);
        // The fate is that at the release.
        let escaped_s = self.left_s.filter(|left_s| *left_s <= end.time_s);
        let (fate, reason) = Evidence {
            hold: &self.hold,
            held_time_s,
            pairs: &pairs,
            is_slow_in_base: is_slow(rates.in_base),
            is_slow_in_world: is_slow(rates.in_world),
            speeds_m_s: [speed(rates.in_base), speed(rates.in_world)],
            escaped_s,
            ejected_s: self.ejected_s,
        }
        .decide();
        let is_held = fate == Fate::Held;
        let was_held = self.hold.past.is_some()
            || self.hold.grip.is_some_and(|grip| self.hold.until_s - grip.since_s >= held_time_s);
        // Start of the last of the intervals in which a pair is active or the object is gripped.
        let active = self.pairs.iter().filter_map(|pair| pair.active_since);
        let stable = self.hold.grip.filter(|_| is_held).map(|grip| {
            active.fold((grip.since_s, grip.pose), |last, since| if since.0 > last.0 { since } else { last })
        });
        let end_pose = relative(pose_of(&object), *com_m, pose_of(&base));
        let slip = stable.map(|(_, pose)| Slip {
            displacement_m: hypot(end_pose[0] - pose[0], end_pose[1] - pose[1]),
            rotation_rad: end_pose[2] - pose[2],
        });
        Some(ObjectCriteria {
            object: mechanism.body_name(Some(roles.object)).to_string(),
            base: mechanism.body_name(roles.base).to_string(),
            assumed_hand: roles.assumed_hand.iter().map(|id| mechanism.outline_name(*id)).collect(),
            radius_m: roles.radius_m,
            fate,
            reason,
            states: self.hold.states.clone(),
            grasped_s: self.hold.first_gripped_s.filter(|_| was_held),
            held_since_s: self.hold.grip.map(|grip| grip.since_s),
            tts_s: stable.map(|(since_s, _)| since_s),
            until_s: fate.lost_at_s().filter(|_| !matches!(fate, Fate::Escaped { .. })),
            escaped_s,
            left_s: self.left_s,
            slip,
            creep_m_s: is_held.then(|| speed(rates.in_base)),
            pairs,
            actuators: self.actuators.clone(),
            start: self.start,
            last: self.setup.object.state(mechanism, last),
            travel: self.cycle.travel(),
            cycle: self.cycle.criteria(last),
            end: end.clone(),
        })
    }
}

/// Whether a contact of a sample has a direction: one without a candidate has none.
fn is_located(contact: &ContactSample) -> bool {
    contact.normal != [0.0; 2]
}

impl SegmentObserver for State {
    type Interpolant = Motions;

    fn begin(&mut self, first: &Sample) {
        self.add_instant(None, first);
        let [object, base, _] = self.setup.states(first);
        self.start = object;
        self.is_in_reach = self.setup.reach.is_some_and(|reach| !reach.is_outside(&object));
        self.cycle.begin(relative(pose_of(&object), self.setup.com_m, pose_of(&base)));
    }

    fn interpolate(&mut self, last: &Sample, next: &Sample, cuts_s: &mut Vec<f64>) -> Motions {
        let times = [last.time_s, next.time_s];
        cuts_s.extend(self.cycle.cuts_s().filter(|time_s| times[0] < *time_s && *time_s < times[1]));
        let near_m = SMALL * self.setup.extent_m();
        for point in &self.setup.points {
            let (from, to) = (last.gap(point.contact), next.gap(point.contact));
            if (from[0] < near_m) != (to[0] < near_m) && from[0].is_finite() && to[0].is_finite() {
                let [from, to] = [(times[0], from), (times[1], to)].map(|(t, [gap_m, rate])| (t, gap_m, rate));
                Hermite::new(from, to).crossings(near_m, cuts_s);
            }
        }
        let ([object, base, _], [next_object, next_base, _]) = (self.setup.states(last), self.setup.states(next));
        Motions {
            object: BodyMotion::between((times[0], &object), (times[1], &next_object)),
            base: BodyMotion::between((times[0], &base), (times[1], &next_base)),
        }
    }

    fn observe(&mut self, motions: &Motions, segment: &Segment<'_>) {
        let Segment { from_s, to_s, last, next, has_touched, is_active } = *segment;
        self.has_touched |= (0..has_touched.len()).any(|point| has_touched[point] && self.setup.is_hand(point));
        if to_s == next.time_s {
            self.search_leaving(last, next);
            self.update_reach(next, has_touched.contains(&true));
        }
        let is_released = self.setup.release_s.is_some_and(|release_s| from_s >= release_s);
        // The palm of a hand is part of its base.
        let is_finger = |point: usize| self.setup.is_hand(point) && self.setup.other(point) != self.setup.roles.base;
        let is_open = is_released && !(0..is_active.len()).any(|point| is_active[point] && is_finger(point));
        self.cycle.add(segment, |time_s| motions.pose(self.setup.com_m, time_s), is_open);
        if is_released {
            return;
        }
        let poses = [from_s, to_s].map(|time_s| motions.pose(self.setup.com_m, time_s));
        let Thresholds { loss_time_s, loss_force_n, .. } = self.setup.thresholds;
        let near_m = SMALL * self.setup.extent_m();
        let fraction = (0.5 * (from_s + to_s) - last.time_s) / (next.time_s - last.time_s);
        let (mut is_hand_near, mut are_surroundings_near, mut are_surroundings_active) = (false, false, false);
        for (index, history) in self.pairs.iter_mut().enumerate() {
            // Points that are not active alone may be together.
            let (mut touched, mut presses, mut is_near, mut weak_n) = (false, false, false, 0.0);
            for point in self.setup.points_of[index].clone() {
                let contact = self.setup.points[point].contact;
                touched |= has_touched[point];
                presses |= is_active[point];
                let between = |[from, to]: [f64; 2]| from + fraction * (to - from);
                let forces_n = [last.normal_n(contact), next.normal_n(contact)];
                if !is_active[point] && forces_n != [0.0; 2] {
                    weak_n += Some(between(forces_n)).filter(|force_n| *force_n <= loss_force_n).unwrap_or_default();
                }
                is_near = is_near || is_active[point] || between([last.gap(contact)[0], next.gap(contact)[0]]) < near_m;
            }
            match self.setup.roles.pairs[index].is_hand {
                true => is_hand_near |= is_near,
                false => {
                    are_surroundings_near |= is_near;
                    are_surroundings_active |= presses;
                }
            }
            history.add((touched, presses || weak_n > loss_force_n), [from_s, to_s], poses[0], loss_time_s);
        }
        let object = self.setup.object.state(&self.setup.mechanism, next);
        let mut presses = self.spare.pop().unwrap_or_default();
        presses.clear();
        presses.extend((0..is_active.len()).map(|point| {
            let presses = is_active[point] && self.setup.is_hand(point);
            if presses { self.edges(point, last, next, &object) } else { None }
        }));
        self.queue.push_back(Slice {
            from_s,
            to_s,
            poses,
            presses,
            is_hand_near,
            are_surroundings_near,
            are_surroundings_active,
        });
        self.process(false);
        let is_release = self.setup.release_s.is_some_and(|release_s| to_s >= release_s);
        if is_release {
            let mut released = if to_s < next.time_s { interpolate(last, next, to_s) } else { next.clone() };
            // Drives and brakes are those that still hold the object.
            released.time_s = to_s.next_down();
            self.add_instant(Some(last), &released);
            self.released = Some(released);
        } else if to_s == next.time_s {
            self.add_instant(Some(last), next);
        }
    }
}

impl Sink for ObjectTracker {
    fn required_data(&self) -> RequiredData {
        RequiredData { peaks: true, passive: true, energies: true, ..RequiredData::NONE }
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
