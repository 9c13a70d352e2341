//! The criteria of a gripper found while a run streams by.

use super::grasp::{ContactCriteria, CycleCriteria, Fate, GraspCriteria};
use super::hermite::Hermite;
use super::history::{History, Onset, Pose};
use super::pieces::{Judge, Piece, Pieces};
use super::stance::{closure_with, friction};
use crate::gripper::Site;
use crate::scene::{Cycle, Place, Scene, Thresholds};
use crate::shape;
use crate::statics::PerContact;
use crate::trace::{BodyState, Event, Reach, Sample, Sink, SinkError, Wants};

const PLACES: usize = Place::ALL.len();

/// A [`Sink`] that finds the [`GraspCriteria`] of the run of a gripper, in constant memory.
///
/// Contacts change at the times of their events, and where their force passes the threshold. Between two samples the object follows the
/// cubic Hermite interpolant of poses and rates.
#[derive(Clone, Debug)]
pub struct GraspTracker {
    pieces: Pieces<PLACES>,
    found: Found,
}

/// What a scene says of its grasp.
#[derive(Clone, Debug)]
struct Grasp {
    thresholds: Thresholds,
    cycle: Cycle,
    /// Where the object can be ejected.
    reach: Option<Reach>,
    friction: PerContact<f64>,
    /// Distance of the object's outermost point from its centre.
    object_m: f64,
    /// Least time between two evaluations of force closure.
    closure_every_s: f64,
}

/// Part of a run between two evaluations of force closure at least: a hundred of them take less than a run does.
const CLOSURE_PART: f64 = 0.01;

/// Force closure of contacts that stay the same.
#[derive(Clone, Copy, Debug, Default)]
struct Closure {
    /// Active contacts, and since when.
    active: [bool; PLACES],
    since_s: f64,
    /// When it was evaluated last, and whether it held.
    evaluated_s: Option<f64>,
    closed: bool,
}

/// What the pieces so far have said.
#[derive(Clone, Debug)]
struct Found {
    grasp: Grasp,
    /// The object in the first sample, and how far it has got since.
    start: Option<(BodyState, Onset)>,
    contacts: [History; PLACES],
    closure: Closure,
    /// When the object was first pressed from both sides or force-closed, and whether it has been held for long enough since.
    grasped_s: Option<f64>,
    was_held: bool,
    /// Since when it is held.
    held_since_s: Option<f64>,
    /// When it ceased to be held after it had been for long enough.
    dropped_s: Option<f64>,
    /// Whether a finger can reach the object in the latest sample.
    in_reach: bool,
    ejected_s: Option<f64>,
    /// End of the last piece before the fingers let go.
    judged_s: f64,
    carried: Option<Onset>,
    opened_s: Option<f64>,
    /// q11 of both fingers when their brakes had gripped, and how far they turned since.
    braked: [Option<(f64, f64)>; 2],
}

impl Found {
    fn new(grasp: Grasp) -> Self {
        Found {
            grasp,
            start: None,
            contacts: [History::default(); PLACES],
            closure: Closure::default(),
            grasped_s: None,
            was_held: false,
            held_since_s: None,
            dropped_s: None,
            in_reach: false,
            ejected_s: None,
            judged_s: 0.0,
            carried: None,
            opened_s: None,
            braked: [None; 2],
        }
    }

    /// What the brakes let through, and how far the object gets while it is carried.
    fn carry(&mut self, piece: &Piece<PLACES>, [from, to]: &[Pose; 2]) {
        if self.grasp.cycle.carries_s.is_some_and(|start| piece.from_s >= start) {
            self.carried.get_or_insert(Onset::new(piece.from_s, *from)).reach(to);
        }
        for (side, braked) in self.braked.iter_mut().enumerate() {
            if self.grasp.cycle.blocked_s[side].is_some_and(|start| piece.to_s >= start) {
                let angle = piece.next.fingers.get(side).map_or(0.0, |finger| finger.q11_rad);
                let (first, most) = braked.get_or_insert((angle, 0.0));
                *most = most.max((angle - *first).abs());
            }
        }
    }

    /// Whether phalanges press from both sides, by their normals at the end of a piece.
    fn holds_from_both_sides(&self, next: &Sample) -> bool {
        let from = |sign: f64| {
            let mut contacts = Place::ALL.iter().zip(&self.contacts).zip(&next.contacts);
            contacts.any(|((place, contact), now)| {
                is_phalanx(*place) && contact.presses.is_some() && sign * now.normal[0] > 0.0
            })
        };
        from(1.0) && from(-1.0)
    }

    /// Since when the same contacts hold the object by force closure; `None` if they do not, or not for long enough.
    fn force_closed_since(&mut self, piece: &Piece<PLACES>) -> Option<f64> {
        let active = self.contacts.map(|contact| contact.presses.is_some());
        if active != self.closure.active {
            self.closure = Closure { active, since_s: piece.from_s, evaluated_s: None, closed: false };
        }
        let Grasp { thresholds, friction, object_m, closure_every_s, .. } = &self.grasp;
        let hand = Place::ALL
            .iter()
            .zip(active)
            .filter(|(place, active)| *active && (is_phalanx(**place) || **place == Place::Palm));
        let closure = &mut self.closure;
        if hand.count() < 2 || piece.to_s - closure.since_s < thresholds.held_time_s {
            return None;
        }
        if closure.evaluated_s.is_none_or(|last_s| piece.to_s - last_s >= *closure_every_s) {
            closure.closed = closure_with(friction, *object_m, piece.next, |index, _| active[index]).closed;
            closure.evaluated_s = Some(piece.to_s);
        }
        closure.closed.then_some(closure.since_s)
    }

    /// Updates whether the object is held at the end of a piece; `lost_s` is when the contacts were lost that count as lost from here on.
    fn hold(&mut self, piece: &Piece<PLACES>, lost_s: Option<f64>) {
        let least_s = self.grasp.thresholds.held_time_s;
        let since_s = match self.holds_from_both_sides(piece.next) {
            true => Some(piece.from_s),
            false => self.force_closed_since(piece),
        };
        match (since_s, self.held_since_s) {
            (Some(since_s), held_since_s) => {
                let held_since_s = held_since_s.unwrap_or(since_s);
                self.held_since_s = Some(held_since_s);
                self.grasped_s.get_or_insert(held_since_s);
                if piece.to_s - held_since_s >= least_s {
                    (self.was_held, self.dropped_s) = (true, None);
                }
            }
            (None, Some(held_since_s)) => {
                let ended_s = lost_s.unwrap_or(piece.from_s).max(held_since_s);
                self.held_since_s = None;
                if ended_s - held_since_s >= least_s {
                    self.dropped_s = Some(ended_s);
                }
            }
            (None, None) => {}
        }
    }

    /// Whether the object leaves the reach of the fingers at the end of a piece, after something touched it.
    fn eject(&mut self, piece: &Piece<PLACES>) {
        let (Some(reach), true) = (self.grasp.reach, piece.to_s == piece.next.time_s) else { return };
        let is_surface = |place: &Place| !matches!(place, Place::Finger(_, Site::Limit));
        let touched = Place::ALL.iter().zip(piece.touched).any(|(place, touched)| touched && is_surface(place));
        let is_in_reach = !reach.is_outside(&piece.next.bodies[0]);
        if self.in_reach && !is_in_reach && touched {
            self.ejected_s.get_or_insert(piece.to_s);
        }
        self.in_reach = is_in_reach;
    }

    /// Since when the object is held at the end, if for long enough.
    fn held_s(&self) -> Option<f64> {
        self.held_since_s.filter(|since_s| self.judged_s - since_s >= self.grasp.thresholds.held_time_s)
    }

    fn fate(&self) -> Fate {
        match (self.ejected_s, self.held_s(), self.dropped_s) {
            (Some(at_s), _, _) => Fate::Ejected { at_s },
            (None, Some(_), _) => Fate::Held,
            (None, None, Some(since_s)) => Fate::Dropped { since_s },
            (None, None, None) => Fate::NotGrasped,
        }
    }
}

fn is_phalanx(place: Place) -> bool {
    matches!(place, Place::Finger(_, Site::Proximal | Site::Distal))
}

/// How the object goes from one sample to the next.
struct Path {
    x: Hermite,
    y: Hermite,
    angle: Hermite,
}

impl Path {
    fn pose(&self, time_s: f64) -> Pose {
        Pose { centre_m: [self.x.value(time_s), self.y.value(time_s)], angle_rad: self.angle.value(time_s) }
    }
}

/// Whether a phalanx presses on the object.
fn any_phalanx(piece: &Piece<PLACES>) -> bool {
    Place::ALL.iter().zip(piece.pressing).any(|(place, pressing)| pressing && is_phalanx(*place))
}

impl Judge<PLACES> for Found {
    type Path = Path;

    fn begin(&mut self, first: &Sample) {
        let object = first.bodies[0];
        let pose = Pose { centre_m: object.centre_m, angle_rad: object.angle_rad };
        self.start = Some((object, Onset::new(first.time_s, pose)));
        self.in_reach = self.grasp.reach.is_some_and(|reach| !reach.is_outside(&object));
    }

    fn path(&self, last: &Sample, next: &Sample, cuts_s: &mut Vec<f64>) -> Path {
        let ([from, to], [t0, t1]) = ([&last.bodies[0], &next.bodies[0]], [last.time_s, next.time_s]);
        let within = |time: &f64| *time > t0 && *time < t1;
        cuts_s.extend([self.grasp.cycle.carries_s, self.grasp.cycle.releases_s].into_iter().flatten().filter(within));
        let along = |axis: usize| {
            Hermite::new(
                (t0, from.centre_m[axis], from.velocity_m_s[axis]),
                (t1, to.centre_m[axis], to.velocity_m_s[axis]),
            )
        };
        let angle = Hermite::new((t0, from.angle_rad, from.spin_rad_s), (t1, to.angle_rad, to.spin_rad_s));
        Path { x: along(0), y: along(1), angle }
    }

    fn judge(&mut self, path: &Path, piece: &Piece<PLACES>) {
        let times = [piece.from_s, piece.to_s];
        let poses = times.map(|time| path.pose(time));
        self.start.iter_mut().for_each(|(_, travelled)| travelled.reach(&poses[1]));
        self.eject(piece);
        if self.grasp.cycle.releases_s.is_some_and(|end| piece.from_s >= end) {
            match any_phalanx(piece) {
                true => self.opened_s = None,
                false => _ = self.opened_s.get_or_insert(piece.from_s),
            }
            return;
        }
        self.judged_s = piece.to_s;
        self.carry(piece, &poses);
        let loss_time_s = self.grasp.thresholds.loss_time_s;
        let mut lost_s: Option<f64> = None;
        for (index, contact) in self.contacts.iter_mut().enumerate() {
            let was_active = contact.presses.is_some();
            contact.judge((piece.touched[index], piece.pressing[index]), times, &poses, loss_time_s);
            if was_active && contact.presses.is_none() {
                lost_s = [lost_s, contact.lost_from_s].into_iter().flatten().reduce(f64::min);
            }
        }
        self.hold(piece, lost_s);
    }
}

impl GraspTracker {
    /// Of the runs of a gripper's scene.
    pub fn of(scene: &Scene) -> Self {
        let thresholds = scene.thresholds;
        Self::new(Grasp {
            thresholds,
            cycle: scene.cycle(),
            reach: Reach::of(&scene.system),
            friction: friction(scene),
            object_m: shape::reach(&scene.system.grasped().shape),
            closure_every_s: thresholds.held_time_s.max(CLOSURE_PART * scene.duration_s),
        })
    }

    /// The same, but what is carried counts from this time on: what goes before prepares it.
    #[must_use]
    pub fn carrying_from(mut self, start_s: f64) -> Self {
        self.found.grasp.cycle.carries_s = Some(start_s);
        self
    }

    fn new(grasp: Grasp) -> Self {
        GraspTracker { pieces: Pieces::above(grasp.thresholds.loss_force_n), found: Found::new(grasp) }
    }

    /// The criteria of the run up to the last sample; `None` if there was none.
    pub fn criteria(&self) -> Option<GraspCriteria> {
        let found = &self.found;
        let (start, travelled) = found.start.as_ref()?;
        let surfaces = || {
            let all = Place::ALL.into_iter().zip(&found.contacts);
            all.filter(|(place, _)| !matches!(place, Place::Finger(_, Site::Limit)))
        };
        let last = surfaces().filter_map(|(_, contact)| contact.presses).max_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let stable = last.filter(|_| found.held_s().is_some());
        let end = self.pieces.last()?;
        // A run that ends before, as with an object that is thrown out, has not come to it.
        let reached = |time_s: &f64| *time_s <= end.time_s;
        let contact = |(place, contact): (Place, &History)| ContactCriteria {
            place,
            first_touch_s: contact.first_touch_s,
            presses_since_s: contact.presses.map(|onset| onset.time_s),
            times_lost: contact.times_lost,
            lost_s: contact.lost_s,
        };
        Some(GraspCriteria {
            contacts: surfaces().map(contact).collect(),
            tts_s: stable.map(|onset| onset.time_s),
            grasped_s: found.grasped_s.filter(|_| found.was_held),
            held_since_s: found.held_since_s,
            fate: found.fate(),
            start: *start,
            end: end.bodies[0],
            travel: travelled.travel,
            slip: stable.map(|onset| onset.travel),
            cycle: CycleCriteria {
                carries_s: found.grasp.cycle.carries_s.filter(reached),
                releases_s: found.grasp.cycle.releases_s.filter(reached),
                carried: found.carried.map(|onset| onset.travel),
                opened_s: found.opened_s,
                brake_slip_rad: found.braked.map(|braked| braked.map(|(_, most)| most)),
            },
        })
    }
}

impl Sink for GraspTracker {
    fn wants(&self) -> Wants {
        Wants { energies: false, passive: false, peaks: true }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.pieces.sample(sample, &mut self.found);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.pieces.event(event);
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
    const RIGHT: Place = Place::Finger(Side::Right, Site::Proximal);
    const LEFT: Place = Place::Finger(Side::Left, Site::Proximal);
    const RIGHT_TIP: Place = Place::Finger(Side::Right, Site::Distal);
    const RIGHT_LIMIT: Place = Place::Finger(Side::Right, Site::Limit);

    fn index(place: Place) -> usize {
        Place::ALL.iter().position(|other| *other == place).expect("one of all")
    }

    fn at_rest(x: f64) -> BodyState {
        BodyState { centre_m: [x, RADIUS_M], ..BodyState::default() }
    }

    /// A run of one second, a sample every tenth of one, in which contacts press with 5 N in these intervals.
    struct Run {
        presses: Vec<(Place, f64, f64)>,
        object: fn(f64) -> BodyState,
        thresholds: Thresholds,
        mu: f64,
        /// Force of the palm.
        palm_n: fn(f64) -> f64,
    }

    impl Default for Run {
        fn default() -> Self {
            Run {
                presses: Vec::new(),
                object: |_| at_rest(0.0),
                thresholds: Thresholds::NONE,
                mu: 0.0,
                palm_n: |_| 5.0,
            }
        }
    }

    impl Run {
        fn sample(&self, time_s: f64) -> Sample {
            let contact = |place: Place| {
                let normal = match place {
                    Place::Finger(Side::Right, _) => [0.8, 0.6],
                    Place::Finger(Side::Left, _) => [-0.8, 0.6],
                    Place::Palm => [0.0, -1.0],
                    Place::Table => [0.0, 1.0],
                };
                let holds = |&(at, from, to): &(Place, f64, f64)| at == place && from < time_s && time_s < to;
                let force = if place == Place::Palm { (self.palm_n)(time_s) } else { 5.0 };
                let normal_n = if self.presses.iter().any(holds) { force } else { 0.0 };
                // Points on the object's surface, opposite to the normals that point away from it.
                let [cx, cy] = (self.object)(time_s).centre_m;
                let point_m = [cx + RADIUS_M * normal[0], cy + RADIUS_M * normal[1]];
                ContactSample { gap_m: 1e-3 * (1.0 - normal_n), normal_n, normal, point_m, ..ContactSample::NONE }
            };
            let contacts = Place::ALL.map(contact).to_vec();
            Sample { time_s, bodies: vec![(self.object)(time_s)], contacts, ..Sample::default() }
        }

        fn watch(&self) -> GraspCriteria {
            let mut events = Vec::new();
            for &(place, from, to) in &self.presses {
                let event =
                    |time_s, kind| Event { time_s, contact: index(place), kind, approach_speed: 0.0, impulse: 0.0 };
                events.extend([event(from, EventKind::TouchDown), event(to, EventKind::LiftOff)]);
            }
            events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
            let mut events = events.iter().peekable();
            let palm = Reach { joints_m: [[0.0155, 0.0], [-0.0155, 0.0]], radii_m: [0.04; 2], object_m: RADIUS_M };
            let mut tracker = GraspTracker::new(Grasp {
                thresholds: self.thresholds,
                cycle: Cycle::default(),
                reach: Some(palm),
                friction: PerContact { phalanges: [[self.mu; 2]; 2], palm: self.mu },
                object_m: RADIUS_M,
                closure_every_s: 0.1,
            });
            assert_eq!(tracker.criteria(), None, "nothing has been seen");
            for time_s in (0..=10).map(|i| 0.1 * f64::from(i)) {
                while let Some(event) = events.next_if(|event| event.time_s <= time_s) {
                    tracker.event(event).expect("kept");
                }
                tracker.sample(&self.sample(time_s)).expect("kept");
            }
            tracker.criteria().expect("a run")
        }
    }

    fn run(presses: &[(Place, f64, f64)], object: fn(f64) -> BodyState) -> GraspCriteria {
        Run { presses: presses.to_vec(), object, ..Run::default() }.watch()
    }

    fn of(criteria: &GraspCriteria, place: Place) -> ContactCriteria {
        *criteria.contacts.iter().find(|contact| contact.place == place).expect("no joint limit")
    }

    #[test]
    fn the_last_contact_that_holds_at_the_end_makes_the_grasp_stable() {
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
        let places: Vec<Place> = found.contacts.iter().map(|contact| contact.place).collect();
        assert_eq!(places.len(), 6, "no joint limit among {places:?}");
        let left = of(&found, LEFT);
        assert_eq!((left.first_touch_s, left.presses_since_s, left.times_lost), (Some(0.33), Some(0.52), 1));
        assert!((left.lost_s - 0.05).abs() < 1e-12, "{left:?}");
        let tip = of(&found, RIGHT_TIP);
        assert_eq!((tip.first_touch_s, tip.presses_since_s, tip.times_lost), (Some(0.61), None, 1));
        assert!((tip.lost_s - 0.17).abs() < 1e-12, "lost until the end: {tip:?}");
        let table = of(&found, Place::Table);
        assert_eq!((table.first_touch_s, table.presses_since_s, table.times_lost, table.lost_s), (None, None, 0, 0.0));
    }

    #[test]
    fn a_table_that_presses_at_the_end_is_waited_for() {
        let found = run(&[(RIGHT, 0.22, 2.0), (LEFT, 0.33, 2.0), (Place::Table, 0.71, 2.0)], |_| at_rest(0.0));
        assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.71)));
    }

    #[test]
    fn what_is_pressed_from_one_side_or_from_above_and_below_is_not_grasped() {
        for presses in [
            &[(RIGHT, 0.2, 2.0), (RIGHT_TIP, 0.3, 2.0), (Place::Palm, 0.0, 2.0), (Place::Table, 0.0, 2.0)][..],
            &[(RIGHT, 0.2, 0.4), (LEFT, 0.5, 2.0)],
            &[],
        ] {
            let found = run(presses, |_| at_rest(0.0));
            assert_eq!((found.fate, found.grasped_s, found.tts_s, found.slip), (Fate::NotGrasped, None, None, None));
        }
    }

    #[test]
    fn what_is_let_go_at_last_is_dropped_since_then() {
        let found = run(&[(RIGHT, 0.2, 2.0), (LEFT, 0.3, 0.44), (LEFT, 0.51, 0.77)], |_| at_rest(0.0));
        assert_eq!((found.fate, found.tts_s), (Fate::Dropped { since_s: 0.77 }, None));
    }

    #[test]
    fn an_object_that_is_drawn_far_is_held_all_the_same() {
        let slides =
            |t: f64| BodyState { velocity_m_s: [0.0, -0.05], centre_m: [0.0, 0.07 - 0.05 * t], ..at_rest(0.0) };
        let found = run(&[(RIGHT, 0.2, 2.0), (LEFT, 0.3, 2.0)], slides);
        assert_eq!((found.fate, found.tts_s, found.held_since_s), (Fate::Held, Some(0.3), Some(0.3)));
        assert!((found.travel.displacement_m - 0.05).abs() < 1e-12);
    }

    /// Out of reach from a height of 57.96 mm on, at 0.3796 s.
    fn thrown(t: f64) -> BodyState {
        BodyState { velocity_m_s: [0.0, 0.1], centre_m: [0.0, 0.02 + 0.1 * t], ..at_rest(0.0) }
    }

    #[test]
    fn an_object_is_ejected_where_it_leaves_the_reach_of_the_fingers_after_a_touch() {
        let found = run(&[(RIGHT, 0.02, 0.18), (LEFT, 0.02, 0.18)], thrown);
        assert_eq!((found.fate, found.grasped_s), (Fate::Ejected { at_s: 0.4 }, Some(0.02)));
        // Untouched, it passes by; and what touches it out of reach does not eject it.
        assert_eq!(run(&[], thrown).fate, Fate::NotGrasped);
        assert_eq!(run(&[(Place::Table, 0.71, 0.83)], thrown).fate, Fate::NotGrasped);
    }

    #[test]
    fn a_start_out_of_reach_is_no_ejection() {
        let far = |t: f64| BodyState { centre_m: [0.0, 0.3 + 0.1 * t], velocity_m_s: [0.0, 0.1], ..at_rest(0.0) };
        assert_eq!(run(&[(Place::Table, 0.0, 2.0)], far).fate, Fate::NotGrasped);
    }

    #[test]
    fn losses_shorter_than_the_threshold_do_not_count() {
        let thresholds = Thresholds { loss_time_s: 0.06, ..Thresholds::NONE };
        let presses = vec![(RIGHT, 0.22, 2.0), (LEFT, 0.33, 0.47), (LEFT, 0.52, 0.71), (LEFT, 0.78, 2.0)];
        let found = Run { presses, thresholds, ..Run::default() }.watch();
        let left = of(&found, LEFT);
        assert_eq!((left.times_lost, left.presses_since_s), (1, Some(0.78)), "0.05 s do not count, 0.07 s do");
        assert!((left.lost_s - 0.07).abs() < 1e-12, "{left:?}");
        assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.78)));
        // A loss at the very end that is still short does not end the grasp.
        let presses = vec![(RIGHT, 0.22, 2.0), (LEFT, 0.33, 0.97)];
        let found = Run { presses, thresholds, ..Run::default() }.watch();
        assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.33)));
    }

    #[test]
    fn forces_below_the_threshold_do_not_press() {
        let thresholds = Thresholds { loss_force_n: 1.0, ..Thresholds::NONE };
        let presses = vec![(RIGHT, 0.22, 2.0), (LEFT, 0.33, 2.0), (Place::Palm, 0.05, 2.0)];
        // The palm's force grows from 0 to 10 N: it passes 1 N at 0.1 s and falls below it at 0.55 s.
        let palm_n = |t: f64| if t < 0.5 { 10.0 * t } else { 5.5 - 9.0 * (t - 0.05) };
        let found = Run { presses: presses.clone(), thresholds, palm_n, ..Run::default() }.watch();
        let palm = of(&found, Place::Palm);
        assert_eq!((palm.times_lost, palm.presses_since_s), (1, None), "{palm:?}");
        assert!((palm.lost_s - 0.45).abs() < 0.02, "{palm:?}");
        assert_eq!(found.tts_s, Some(0.33), "what does not press is not waited for");
        let found = Run { presses, thresholds: Thresholds::NONE, palm_n: |_| 1e-9, ..Run::default() }.watch();
        assert_eq!(of(&found, Place::Palm).presses_since_s, Some(0.05));
    }

    #[test]
    fn an_object_is_held_only_for_as_long_as_the_scene_states() {
        let thresholds = Thresholds { held_time_s: 0.3, ..Thresholds::NONE };
        let fate =
            |presses: &[(Place, f64, f64)]| Run { presses: presses.to_vec(), thresholds, ..Run::default() }.watch();
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
    fn one_finger_and_the_palm_hold_by_force_closure_if_friction_suffices() {
        // Normals are 127° apart: closed if both cones contain the line between the contacts, from a half angle of 26.6° on.
        let thresholds = Thresholds { held_time_s: 0.2, ..Thresholds::NONE };
        let presses = vec![(RIGHT, 0.2, 2.0), (Place::Palm, 0.0, 2.0)];
        let fate = |mu: f64| Run { presses: presses.clone(), thresholds, mu, ..Run::default() }.watch().fate;
        assert_eq!(fate(0.55), Fate::Held);
        assert_eq!(fate(0.45), Fate::NotGrasped);
        let lost = vec![(RIGHT, 0.2, 0.75), (Place::Palm, 0.0, 2.0)];
        let found = Run { presses: lost, thresholds, mu: 0.55, ..Run::default() }.watch();
        assert_eq!((found.fate, found.grasped_s), (Fate::Dropped { since_s: 0.75 }, Some(0.2)));
    }

    #[test]
    fn slip_counts_from_the_grasp_and_travel_from_the_start() {
        // Pushed by 3 mm until 0.5 s; from there it turns and creeps back by 1 mm.
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
