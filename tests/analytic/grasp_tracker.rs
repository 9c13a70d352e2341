//! The tracker of a grasp on samples and events that are made by hand: fates, times, losses and travel of the object of a
//! five-bar gripper.

use phalanx::criteria::{Fate, HoldState, Margin, ObjectCriteria, ObjectTracker, PairCriteria, firmness};
use phalanx::gripper::FingerContact;
use phalanx::scene::{Brake, HandContact, Profile, Scene, Side, Thresholds, parse_any};
use phalanx::trace::{BodyState, ContactSample, Event, EventKind, Sample, Schema, Sink};

const RADIUS_M: f64 = 0.02;
const RIGHT: HandContact = HandContact::Finger(Side::Right, FingerContact::Proximal);
const LEFT: HandContact = HandContact::Finger(Side::Left, FingerContact::Proximal);
const RIGHT_TIP: HandContact = HandContact::Finger(Side::Right, FingerContact::Distal);

/// Contacts that are active from a time to another one.
type Active = (HandContact, f64, f64);

fn scene(mu: f64) -> Scene {
    scene_with(mu, "table.level = \"40 mm\"")
}

fn scene_with(mu: f64, more: &str) -> Scene {
    let text = format!(
        r#"
        kind = "gripper"
        duration = "1 s"
        palm_width = "31 mm"
        lengths = {{ l11 = "15 mm", l21 = "24.43 mm", l22 = "7.5 mm", t22 = "12.86 mm", phi22 = "120 deg" }}
        object.radius = "20 mm"
        object.height = "20 mm"
        motor = {{ torque = "480 N*mm" }}
        spring = {{ torque = "132.6 N*mm" }}
        contact.friction = {{ mu_static = {mu}, mu_dynamic = {mu} }}
        {more}
        "#
    );
    let scene = parse_any(&text, "tracker.toml").unwrap_or_else(|error| panic!("{error}"));
    Scene { thresholds: Thresholds::NONE, ..scene }
}

/// State of the object over time, at rest.
fn at_rest(x: f64) -> BodyState {
    BodyState { centre_m: [x, RADIUS_M], ..BodyState::default() }
}

/// A run of 1 s with a sample every 0.1 s.
struct Run {
    scene: Scene,
    active: Vec<Active>,
    object: fn(f64) -> BodyState,
    /// Normal directions from the object to the phalanges of the right finger; those of the left one are mirrored.
    normal: [f64; 2],
    /// Normal force of the palm over time, N; the other contacts press with 5 N.
    palm_n: fn(f64) -> f64,
    /// Slip rate of all contacts, m/s.
    slip_m_s: f64,
}

impl Run {
    fn new(active: &[Active]) -> Self {
        Run {
            scene: scene(0.0),
            active: active.to_vec(),
            object: |_| at_rest(0.0),
            normal: [1.0, 0.0],
            palm_n: |_| 5.0,
            slip_m_s: 0.0,
        }
    }

    fn with_thresholds(mut self, thresholds: Thresholds) -> Self {
        self.scene.thresholds = thresholds;
        self
    }

    fn sample(&self, time_s: f64) -> Sample {
        let mut sample = Sample::new(time_s, Schema::from_scene(&self.scene).counts());
        let object = (self.object)(time_s);
        (0..sample.counts().bodies).for_each(|body| sample.set_body(body, &object));
        for (index, id) in self.scene.hand.contacts().enumerate() {
            let [x, y] = self.normal;
            let normal = match id {
                HandContact::Finger(Side::Right, _) => [x, y],
                HandContact::Finger(Side::Left, _) => [-x, y],
                HandContact::Palm => [0.0, -1.0],
                HandContact::Table => [0.0, 1.0],
            };
            let is_active = |&(other, from, to): &Active| other == id && from < time_s && time_s < to;
            let force = if id == HandContact::Palm { (self.palm_n)(time_s) } else { 5.0 };
            let normal_n = if self.active.iter().any(is_active) { force } else { 0.0 };
            let [cx, cy] = object.centre_m;
            let point_m = [cx + RADIUS_M * normal[0], cy + RADIUS_M * normal[1]];
            let (gap_m, slip_m_s) = (1e-3 * (1.0 - normal_n), self.slip_m_s);
            sample.set_contact(
                index,
                &ContactSample { gap_m, normal_n, normal, point_m, slip_m_s, ..ContactSample::NONE },
            );
        }
        sample
    }

    fn evaluate(&self) -> ObjectCriteria {
        let mut events = Vec::new();
        for &(id, from, to) in &self.active {
            let contact = self.scene.hand.contact_index(id).expect("a contact of the scene");
            let event = |time_s, kind| Event { time_s, contact, kind, approach_speed: 0.0, impulse: 0.0 };
            events.extend([event(from, EventKind::TouchDown), event(to, EventKind::LiftOff)]);
        }
        events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let mut events = events.iter().peekable();
        let mut tracker = ObjectTracker::for_scene(&self.scene).expect("a grasp");
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

fn pair(criteria: &ObjectCriteria, id: HandContact) -> &PairCriteria {
    criteria.pairs.iter().find(|pair| pair.name == id.name()).expect("a pair of the object")
}

#[test]
fn time_to_stability_is_the_onset_of_the_last_active_contact() {
    let found =
        Run::new(&[(RIGHT, 0.22, 2.0), (LEFT, 0.33, 0.47), (LEFT, 0.52, 2.0), (RIGHT_TIP, 0.61, 0.83)]).evaluate();
    assert_eq!((found.fate, found.grasped_s, found.tts_s), (Fate::Held, Some(0.33), Some(0.52)));
    let left = pair(&found, LEFT);
    assert_eq!((left.first_s, left.active_since_s, left.times_lost), (Some(0.33), Some(0.52), 1));
    assert!((left.lost_s - 0.05).abs() < 1e-12, "{left:?}");
    let tip = pair(&found, RIGHT_TIP);
    assert_eq!((tip.first_s, tip.active_since_s, tip.times_lost), (Some(0.61), None, 1));
    assert!((tip.lost_s - 0.17).abs() < 1e-12, "lost until the end: {tip:?}");
    let table = pair(&found, HandContact::Table);
    assert_eq!((table.first_s, table.active_since_s, table.times_lost, table.lost_s), (None, None, 0, 0.0));
}

#[test]
fn an_active_table_contact_counts_for_time_to_stability() {
    let found = Run::new(&[(RIGHT, 0.22, 2.0), (LEFT, 0.33, 2.0), (HandContact::Table, 0.71, 2.0)]).evaluate();
    assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.71)));
}

/// Contacts on one side do not grip. Neither does the palm against the table, which is no part of the hand.
#[test]
fn contacts_on_one_side_or_above_and_below_are_no_grasp() {
    let one_side =
        [(RIGHT, 0.2, 2.0), (RIGHT_TIP, 0.3, 2.0), (HandContact::Palm, 0.0, 2.0), (HandContact::Table, 0.0, 2.0)];
    for active in [&one_side[..], &one_side[2..], &[]] {
        let found = Run::new(active).evaluate();
        assert_eq!((found.fate, found.grasped_s, found.tts_s, found.slip), (Fate::NotGrasped, None, None, None));
    }
}

/// Normals of both fingers with components along the palm of opposite sign grip only if they balance.
#[test]
fn normals_on_both_sides_that_do_not_balance_are_no_grip() {
    let active = [(RIGHT, 0.2, 2.0), (LEFT, 0.3, 2.0), (HandContact::Table, 0.0, 2.0)];
    let fate = |mu: f64| Run { normal: [0.8, 0.6], scene: scene(mu), ..Run::new(&active) }.evaluate().fate;
    // The friction cones contain the line between the contacts from a coefficient of 0.75 on.
    assert_eq!((fate(0.0), fate(0.74)), (Fate::NotGrasped, Fate::NotGrasped));
    assert_eq!(fate(0.76), Fate::Held);
    // The palm from below closes the triangle of normals.
    let with_palm = [&active[..], &[(HandContact::Palm, 0.0, 2.0)]].concat();
    assert_eq!(Run { normal: [0.8, 0.6], ..Run::new(&with_palm) }.evaluate().fate, Fate::Held);
}

#[test]
fn an_object_released_at_the_end_is_dropped() {
    let found = Run::new(&[(RIGHT, 0.2, 0.85), (LEFT, 0.3, 0.44), (LEFT, 0.51, 0.77)]).evaluate();
    assert_eq!((found.fate, found.tts_s), (Fate::Dropped { since_s: 0.77 }, None));
    assert_eq!(found.reason, "no longer gripped from 770 ms on");
    // One finger that still presses carries it.
    let found = Run::new(&[(RIGHT, 0.2, 2.0), (LEFT, 0.3, 0.77)]).evaluate();
    assert_eq!((found.fate, found.end_state()), (Fate::Carried, HoldState::Carried));
}

#[test]
fn an_object_that_moves_far_with_the_contacts_is_held() {
    let moves = |t: f64| BodyState { velocity_m_s: [0.0, -0.05], centre_m: [0.0, 0.07 - 0.05 * t], ..at_rest(0.0) };
    let thresholds = Thresholds { held_time_s: 0.1, ..Thresholds::NONE };
    let run = Run { object: moves, ..Run::new(&[(RIGHT, 0.2, 2.0), (LEFT, 0.3, 2.0)]) }.with_thresholds(thresholds);
    let found = run.evaluate();
    assert_eq!((found.fate, found.tts_s, found.held_since_s), (Fate::Held, Some(0.3), Some(0.3)));
    assert!((found.travel.displacement_m - 0.05).abs() < 1e-12);
    // It is lost where every contact slides.
    let found = Run { slip_m_s: 0.05, ..run }.evaluate();
    assert!(matches!(found.fate, Fate::Dropped { since_s } if since_s == found.end.time_s), "{:?}", found.fate);
}

/// Leaves the reach of the fingers at a height of 57.76 mm, at 0.3776 s.
fn thrown_object(t: f64) -> BodyState {
    BodyState { velocity_m_s: [0.0, 0.1], centre_m: [0.0, 0.02 + 0.1 * t], ..at_rest(0.0) }
}

#[test]
fn an_object_that_leaves_the_reach_after_a_contact_is_ejected() {
    let fate = |active: &[Active]| Run { object: thrown_object, ..Run::new(active) }.evaluate().fate;
    let found = Run { object: thrown_object, ..Run::new(&[(RIGHT, 0.02, 0.18), (LEFT, 0.02, 0.18)]) }.evaluate();
    assert_eq!((found.fate, found.grasped_s, found.until_s), (Fate::Ejected { at_s: 0.4 }, Some(0.02), Some(0.4)));
    assert_eq!(found.reason, "out of the reach of both fingers at 400 ms");
    // Without a contact, or with a contact out of reach, it is not ejected.
    assert_eq!(fate(&[]), Fate::NotGrasped);
    assert_eq!(fate(&[(HandContact::Table, 0.71, 0.83)]), Fate::NotGrasped);
}

#[test]
fn an_object_that_starts_out_of_reach_is_not_ejected() {
    let object = |t: f64| BodyState { centre_m: [0.0, 0.3 + 0.1 * t], velocity_m_s: [0.0, 0.1], ..at_rest(0.0) };
    let run = Run { object, ..Run::new(&[(HandContact::Table, 0.0, 2.0)]) };
    assert_eq!(run.evaluate().fate, Fate::NotGrasped);
}

#[test]
fn losses_shorter_than_the_threshold_do_not_count() {
    let thresholds = Thresholds { loss_time_s: 0.06, ..Thresholds::NONE };
    let active = [(RIGHT, 0.22, 2.0), (LEFT, 0.33, 0.47), (LEFT, 0.52, 0.71), (LEFT, 0.78, 2.0)];
    let found = Run::new(&active).with_thresholds(thresholds).evaluate();
    let left = pair(&found, LEFT);
    let expected = (1, Some(0.78));
    assert_eq!((left.times_lost, left.active_since_s), expected, "a loss of 0.05 s does not count, one of 0.07 s does");
    assert!((left.lost_s - 0.07).abs() < 1e-12, "{left:?}");
    assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.78)));
    // A short loss at the end does not end the grasp.
    let found = Run::new(&[(RIGHT, 0.22, 2.0), (LEFT, 0.33, 0.97)]).with_thresholds(thresholds).evaluate();
    assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.33)));
}

#[test]
fn contacts_below_the_force_threshold_are_not_active() {
    let thresholds = Thresholds { loss_force_n: 1.0, ..Thresholds::NONE };
    let active = [(RIGHT, 0.22, 2.0), (LEFT, 0.33, 2.0), (HandContact::Palm, 0.05, 2.0)];
    // The force of the palm exceeds 1 N from 0.1 s to 0.55 s.
    let palm_n = |t: f64| if t < 0.5 { 10.0 * t } else { 5.5 - 9.0 * (t - 0.05) };
    let found = Run { palm_n, ..Run::new(&active) }.with_thresholds(thresholds).evaluate();
    let palm = pair(&found, HandContact::Palm);
    assert_eq!((palm.times_lost, palm.active_since_s), (1, None), "{palm:?}");
    assert!((palm.lost_s - 0.45).abs() < 0.02, "{palm:?}");
    assert_eq!(found.tts_s, Some(0.33), "inactive contacts do not count");
    let found = Run { palm_n: |_| 1e-9, ..Run::new(&active) }.evaluate();
    assert_eq!(pair(&found, HandContact::Palm).active_since_s, Some(0.05));
}

#[test]
fn an_object_is_held_only_after_the_required_time() {
    let thresholds = Thresholds { held_time_s: 0.3, ..Thresholds::NONE };
    let run = |active: &[Active]| Run::new(active).with_thresholds(thresholds).evaluate();
    let short = run(&[(RIGHT, 0.22, 2.0), (LEFT, 0.81, 2.0)]);
    assert_eq!((short.fate, short.tts_s, short.grasped_s), (Fate::NotGrasped, None, None));
    assert_eq!(short.held_since_s, Some(0.81));
    assert_eq!(run(&[(RIGHT, 0.22, 2.0), (LEFT, 0.69, 2.0)]).fate, Fate::Held);
    let again = run(&[(RIGHT, 0.22, 2.0), (LEFT, 0.23, 0.61), (LEFT, 0.81, 2.0)]);
    assert_eq!((again.fate, again.grasped_s), (Fate::Dropped { since_s: 0.61 }, Some(0.23)));
    let reason = "no longer gripped from 610 ms on; gripped again only from 810 ms on, less than 300 ms";
    assert_eq!(again.reason, reason);
    let twice = run(&[(RIGHT, 0.22, 0.75), (LEFT, 0.22, 0.42), (LEFT, 0.52, 0.72)]);
    assert_eq!(twice.fate, Fate::NotGrasped, "{}", twice.reason);
}

#[test]
fn one_finger_and_the_palm_grip_with_enough_friction() {
    // The angle between the normals is 127°. Both friction cones contain the line between the contacts from a half
    // angle of 26.6°.
    let thresholds = Thresholds { held_time_s: 0.2, ..Thresholds::NONE };
    let run = |mu: f64, active: &[Active]| {
        Run { normal: [0.8, 0.6], scene: scene(mu), ..Run::new(active) }.with_thresholds(thresholds).evaluate()
    };
    let active = [(RIGHT, 0.22, 2.0), (HandContact::Palm, 0.0, 2.0), (HandContact::Table, 0.0, 2.0)];
    assert_eq!((run(0.55, &active).fate, run(0.45, &active).fate), (Fate::Held, Fate::NotGrasped));
    let found = run(0.55, &[(RIGHT, 0.22, 0.75), (HandContact::Palm, 0.0, 2.0), (HandContact::Table, 0.0, 2.0)]);
    assert_eq!((found.fate, found.grasped_s), (Fate::Dropped { since_s: 0.75 }, Some(0.22)));
}

#[test]
fn slip_counts_from_stability_to_the_end_and_travel_is_the_largest_since_the_start() {
    // Moves by 3.6 mm until 0.6 s, then back by 1.6 mm, and turns.
    let object = |t: f64| BodyState {
        velocity_m_s: [-12e-3 + 20e-3 * t, 0.0],
        spin_rad_s: -0.2 * t,
        angle_rad: -0.1 * t * t,
        ..at_rest(3.5e-3 - 12e-3 * t + 10e-3 * t * t)
    };
    let found = Run { object, ..Run::new(&[(RIGHT, 0.15, 2.0), (LEFT, 0.35, 2.0)]) }.evaluate();
    assert_eq!(found.tts_s, Some(0.35));
    let slip = found.slip.expect("a grasp");
    assert!((slip.displacement_m - 0.975e-3).abs() < 1e-12 && (slip.rotation_rad + 0.08775).abs() < 1e-12, "{slip:?}");
    assert!((found.travel.displacement_m - 3.6e-3).abs() < 1e-12, "{:?}", found.travel);
    assert!((found.travel.rotation_rad - 0.1).abs() < 1e-12, "{:?}", found.travel);
    assert!((found.offset_ratio().expect("it was off centre") - 1.5 / 3.5).abs() < 1e-12);
    assert!((found.end_speed_m_s() - 8e-3).abs() < 1e-15);
    assert_eq!(Run { object: |_| at_rest(1e-10), ..Run::new(&[]) }.evaluate().offset_ratio(), None);
}

/// After the release neither fate nor losses change; the opening of the fingers, the travel and the ejection do. The palm
/// is no finger.
#[test]
fn a_hand_releases_when_its_motors_stop_closing_it() {
    let mut run = Run::new(&[(RIGHT, 0.2, 0.75), (LEFT, 0.3, 0.82), (HandContact::Palm, 0.3, 2.0)]);
    for finger in &mut run.scene.hand.fingers {
        finger.motor.actuation = Profile::Reversal { value: 0.48, at_s: 0.63 };
    }
    let found = run.evaluate();
    assert_eq!((found.fate, found.tts_s), (Fate::Held, Some(0.3)));
    assert_eq!((found.cycle.release_s, found.cycle.opened_s), (Some(0.63), Some(0.82)));
    assert!((found.end.time_s - 0.63).abs() < 1e-15 && found.end.time_s < 0.63, "{}", found.end.time_s);
    assert_eq!(found.contacts_lost(), 0);
    let ejected = Run { object: |t| thrown_object(t - 0.4), ..run }.evaluate();
    assert_eq!(ejected.fate, Fate::Ejected { at_s: 0.8 });
    assert!((ejected.travel.displacement_m - 0.1).abs() < 1e-12, "{:?}", ejected.travel);
}

#[test]
fn slip_of_a_brake_counts_from_its_engagement() {
    let mut run = Run::new(&[(RIGHT, 0.2, 2.0), (LEFT, 0.3, 2.0)]);
    let brake = Brake {
        torque_n_m: 1.0,
        start_s: 0.25,
        rise_s: 0.0,
        release_s: None,
        one_way: false,
        v_static_rad_s: 0.1,
        bristle: None,
    };
    run.scene.hand.fingers[0].motor.brake = Some(brake);
    let found = run.evaluate();
    assert_eq!(found.cycle.brake_slip_rad, [Some(0.0), None]);
}

/// A fixed object is judged like one that moves, except that it balances no acceleration.
#[test]
fn a_fixed_object_is_gripped() {
    let scene = scene_with(0.5, "object.motion = \"fixed\"");
    let run = Run { scene: scene.clone(), ..Run::new(&[(RIGHT, 0.2, 2.0), (LEFT, 0.3, 2.0)]) };
    let found = run.evaluate();
    assert_eq!((found.fate, found.tts_s, found.pairs.len()), (Fate::Held, Some(0.3), 4));
    assert_eq!((found.travel.displacement_m, found.last), (0.0, at_rest(0.0)));
    let firmness = firmness(&scene, &found).expect("held");
    assert!(matches!(firmness.driven, Margin::Undecided { .. }), "{firmness:?}");
    // A force of μ at each contact turns the object: Q1 is below μ.
    let closure = firmness.force_closure;
    assert!(closure.closed && closure.q1_l1 > 0.0 && closure.q1_l1 < 0.5, "{closure:?}");
}
