//! The criteria of a gripper found while a run streams by.

use super::grasp::{ContactCriteria, CycleCriteria, Fate, GraspCriteria};
use super::hermite::Hermite;
use super::history::{History, Onset, Pose};
use super::pieces::{Judge, Piece, Pieces};
use crate::gripper::Site;
use crate::numeric::elementary::hypot;
use crate::scene::{Cycle, Place, Scene};
use crate::shape::reach;
use crate::trace::{BodyState, EJECTED_RADII, Event, Sample, Sink, SinkError, Wants};

const PLACES: usize = Place::ALL.len();

/// A [`Sink`] that finds the [`GraspCriteria`] of the run of a gripper, in constant memory.
///
/// Contacts change at the times of their events. Between two samples the object follows the cubic Hermite interpolant of poses and
/// rates, and so does its distance from a point; the times at which it passes a limit are found to 1e-9 s.
#[derive(Clone, Debug)]
pub struct GraspTracker {
    pieces: Pieces<PLACES>,
    found: Found,
}

/// What the pieces so far have said.
#[derive(Clone, Debug)]
struct Found {
    reach_m: f64,
    /// The object in the first sample, and how far it has got since.
    start: Option<(BodyState, Onset)>,
    contacts: [History; PLACES],
    grasped: Option<Onset>,
    /// Whether it is held from both sides in the last piece.
    both_sides: bool,
    /// Since when it is not held.
    dropped_s: Option<f64>,
    ejected_s: Option<f64>,
    cycle: Cycle,
    carried: Option<Onset>,
    opened_s: Option<f64>,
    /// q11 of both fingers when their brakes had gripped, and how far they turned since.
    braked: [Option<(f64, f64)>; 2],
}

impl Found {
    /// What the brakes let through, and how far the object gets while it is carried.
    fn carry(&mut self, piece: &Piece<PLACES>, [from, to]: &[Pose; 2]) {
        if self.cycle.carries_s.is_some_and(|start| piece.from_s >= start) {
            self.carried.get_or_insert(Onset::new(piece.from_s, *from)).reach(to);
        }
        for (side, braked) in self.braked.iter_mut().enumerate() {
            if self.cycle.blocked_s[side].is_some_and(|start| piece.to_s >= start) {
                let angle = piece.next.fingers.get(side).map_or(0.0, |finger| finger.q11_rad);
                let (first, most) = braked.get_or_insert((angle, 0.0));
                *most = most.max((angle - *first).abs());
            }
        }
    }

    fn fate(&self) -> Fate {
        match (self.ejected_s, self.grasped, self.dropped_s) {
            (Some(at_s), _, _) => Fate::Ejected { at_s },
            (None, None, _) => Fate::NotGrasped,
            (None, Some(_), Some(since_s)) => Fate::Dropped { since_s },
            (None, Some(_), None) => Fate::Held,
        }
    }
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

/// The distance of the object's centre from a point, with its rate.
fn distance(time_s: f64, object: &BodyState, [x, y]: [f64; 2]) -> (f64, f64, f64) {
    let ([cx, cy], [vx, vy]) = (object.centre_m, object.velocity_m_s);
    let (dx, dy) = (cx - x, cy - y);
    let distance = hypot(dx, dy);
    // Where it starts from the point itself, its distance grows as fast as it moves.
    let rate = if distance > 0.0 { (dx * vx + dy * vy) / distance } else { hypot(vx, vy) };
    (time_s, distance, rate)
}

/// Whether the phalanges that press do so from both sides, by their normals at the end of a piece.
fn holds_from_both_sides(piece: &Piece<PLACES>) -> bool {
    let from = |sign: f64| {
        Place::ALL.iter().enumerate().any(|(index, place)| {
            matches!(place, Place::Finger(_, Site::Proximal | Site::Distal))
                && piece.pressing[index]
                && sign * piece.next.contacts[index].normal[0] > 0.0
        })
    };
    from(1.0) && from(-1.0)
}

/// Whether a phalanx presses on the object.
fn any_phalanx(piece: &Piece<PLACES>) -> bool {
    let is_phalanx = |place: &Place| matches!(place, Place::Finger(_, Site::Proximal | Site::Distal));
    Place::ALL.iter().zip(piece.pressing).any(|(place, pressing)| pressing && is_phalanx(place))
}

impl Judge<PLACES> for Found {
    type Path = Path;

    fn begin(&mut self, first: &Sample) {
        let object = first.bodies[0];
        let pose = Pose { centre_m: object.centre_m, angle_rad: object.angle_rad };
        self.start = Some((object, Onset::new(first.time_s, pose)));
    }

    fn path(&self, last: &Sample, next: &Sample, cuts_s: &mut Vec<f64>) -> Path {
        let ([from, to], [t0, t1]) = ([&last.bodies[0], &next.bodies[0]], [last.time_s, next.time_s]);
        let limits = [
            Some(([0.0; 2], EJECTED_RADII * self.reach_m)),
            self.grasped.map(|onset| (onset.pose.centre_m, self.reach_m)),
        ];
        for (point, limit) in limits.into_iter().flatten() {
            Hermite::new(distance(t0, from, point), distance(t1, to, point)).crossings(limit, cuts_s);
        }
        let within = |time: &f64| *time > t0 && *time < t1;
        cuts_s.extend([self.cycle.carries_s, self.cycle.releases_s].into_iter().flatten().filter(within));
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
        let middle = path.pose(0.5 * (piece.from_s + piece.to_s));
        self.start.iter_mut().for_each(|(_, travelled)| travelled.reach(&poses[1]));
        if middle.distance([0.0; 2]) > EJECTED_RADII * self.reach_m {
            self.ejected_s.get_or_insert(piece.from_s);
        }
        if self.cycle.releases_s.is_some_and(|end| piece.from_s >= end) {
            match any_phalanx(piece) {
                true => self.opened_s = None,
                false => _ = self.opened_s.get_or_insert(piece.from_s),
            }
            return;
        }
        self.carry(piece, &poses);
        for (index, contact) in self.contacts.iter_mut().enumerate() {
            contact.judge((piece.touched[index], piece.pressing[index]), times, &poses);
        }
        self.both_sides = holds_from_both_sides(piece);
        if self.both_sides {
            self.grasped.get_or_insert(Onset::new(piece.from_s, poses[0]));
        }
        let Some(grasped) = self.grasped else { return };
        if self.both_sides && middle.distance(grasped.pose.centre_m) <= self.reach_m {
            self.dropped_s = None;
        } else {
            self.dropped_s.get_or_insert(piece.from_s);
        }
    }
}

impl GraspTracker {
    /// Of a scene, with the times of its cycle.
    pub fn of(scene: &Scene) -> Self {
        let mut tracker = Self::new(reach(&scene.system.grasped().shape));
        tracker.found.cycle = scene.cycle();
        tracker
    }

    /// The same, but what is carried counts from this time on: what goes before prepares it.
    #[must_use]
    pub fn carrying_from(mut self, start_s: f64) -> Self {
        self.found.cycle.carries_s = Some(start_s);
        self
    }

    /// For an object that reaches so far from its centre (its radius), that is to be held to the end.
    pub fn new(reach_m: f64) -> Self {
        let found = Found {
            reach_m,
            start: None,
            contacts: [History::default(); PLACES],
            grasped: None,
            both_sides: false,
            dropped_s: None,
            ejected_s: None,
            cycle: Cycle::default(),
            carried: None,
            opened_s: None,
            braked: [None; 2],
        };
        GraspTracker { pieces: Pieces::default(), found }
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
        let stable = last.filter(|_| found.both_sides);
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
            grasped_s: found.grasped.map(|onset| onset.time_s),
            fate: found.fate(),
            start: *start,
            end: end.bodies[0],
            travel: travelled.travel,
            slip: stable.map(|onset| onset.travel),
            cycle: CycleCriteria {
                carries_s: found.cycle.carries_s.filter(reached),
                releases_s: found.cycle.releases_s.filter(reached),
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

    /// A run of one second, a sample every tenth of one, in which contacts press in these intervals.
    struct Run {
        presses: Vec<(Place, f64, f64)>,
        object: fn(f64) -> BodyState,
    }

    impl Run {
        fn sample(&self, time_s: f64) -> Sample {
            let contact = |place: Place| {
                let normal = match place {
                    Place::Finger(Side::Right, _) => [0.8, -0.6],
                    Place::Finger(Side::Left, _) => [-0.8, -0.6],
                    Place::Palm => [0.0, 1.0],
                    Place::Table => [0.0, -1.0],
                };
                let holds = |&(at, from, to): &(Place, f64, f64)| at == place && from < time_s && time_s < to;
                let normal_n = if self.presses.iter().any(holds) { 5.0 } else { 0.0 };
                ContactSample { gap_m: 1e-3 * (1.0 - normal_n), normal_n, normal, ..ContactSample::NONE }
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
            let mut tracker = GraspTracker::new(RADIUS_M);
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
        Run { presses: presses.to_vec(), object }.watch()
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
    fn what_slides_out_between_fingers_is_dropped_where_it_is_a_radius_away() {
        let slides = |t: f64| BodyState { velocity_m_s: [0.0, 0.03], centre_m: [0.0, 0.02 + 0.03 * t], ..at_rest(0.0) };
        let found = run(&[(RIGHT, 0.2, 2.0), (LEFT, 0.3, 2.0)], slides);
        let Fate::Dropped { since_s } = found.fate else { panic!("{:?}", found.fate) };
        assert!((since_s - (0.3 + 0.02 / 0.03)).abs() < 1e-8, "{since_s}");
        assert_eq!(found.tts_s, Some(0.3), "the contacts hold all the same");
    }

    #[test]
    fn what_is_three_radii_away_has_been_ejected_even_if_it_comes_back() {
        let thrown = |t: f64| {
            let y = 0.02 + 0.4 * t * (1.0 - t);
            BodyState { velocity_m_s: [0.0, 0.4 - 0.8 * t], centre_m: [0.0, y], ..at_rest(0.0) }
        };
        let found = run(&[(RIGHT, 0.02, 0.08), (LEFT, 0.02, 0.08), (LEFT, 0.95, 2.0), (RIGHT, 0.95, 2.0)], thrown);
        let Fate::Ejected { at_s } = found.fate else { panic!("{:?}", found.fate) };
        let exact = 0.5 - (0.25 - 0.1f64).sqrt();
        assert!((at_s - exact).abs() < 1e-3, "{at_s}, not {exact}");
        assert_eq!(found.grasped_s, Some(0.02));
        assert!((found.travel.displacement_m - 0.1).abs() < 1e-12);
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
