//! The dynamic criteria of synthetic closings whose results are known in closed form. The reason for a class agrees with
//! the class and the figures of the run.

use crate::hard_scenes::load;
use crate::support::checked_run::record_run;
use crate::support::random::Random;
use crate::support::synthetic::{lift_off, posture, reload, touch_down};
use phalanx::criteria::{
    Class, ClassReason, Condition, Criteria, EPSILON_RAD, FinalAngles, FinalContact, RESOLUTION_S, Tracker,
};
use phalanx::scene::{self, Scene};
use phalanx::trace::FingerContact::{Distal, Proximal};
use phalanx::trace::{Event, EventKind, Model, Sink};
use phalanx::validate::Recording;

const TARGET: FinalAngles = FinalAngles { q11_rad: 0.036, q21_rad: 1.134 };
const END_S: f64 = 20e-3;

/// A synthetic closing with its expected criteria. q21 is at its final value.
struct Closing {
    name: &'static str,
    /// q11 relative to its final value, and its rate, rad and rad/s.
    angle: fn(f64) -> (f64, f64),
    /// Whether the proximal phalanx and the tip have a force.
    is_active: fn(f64) -> [bool; 2],
    events: Vec<Event>,
    /// Intervals of the samples.
    intervals_s: &'static [f64],
    t_geo_s: Option<f64>,
    /// Time to stability with its tolerance.
    tts_s: Option<(f64, f64)>,
    /// Lost time with its tolerance.
    lost_s: (f64, f64),
    class: Class,
}

/// An angle that approaches its final value at a constant rate.
fn approach(time_s: f64, arrival_s: f64, rate_rad_s: f64) -> (f64, f64) {
    if time_s <= arrival_s { (rate_rad_s * (time_s - arrival_s), rate_rad_s) } else { (0.0, 0.0) }
}

/// A finger that arrives at 5 ms at 20 rad/s and stays. The proximal phalanx touches the object from 3 ms on. The 0.17 ms
/// through the ε band are part of the approach, not of a rebound.
fn arrival() -> Closing {
    Closing {
        name: "arrival",
        angle: |t| approach(t, 5e-3, 20.0),
        is_active: |t| [t > 3e-3, t > 5e-3],
        events: vec![touch_down(3e-3, Proximal, 1.0), touch_down(5e-3, Distal, 1.0)],
        intervals_s: &[1e-3, 1e-4, 1e-5],
        t_geo_s: Some(5e-3 - EPSILON_RAD / 20.0),
        tts_s: Some((5e-3, 2e-9)),
        lost_s: (0.0, 0.0),
        class: Class::Stable,
    }
}

impl Closing {
    fn with_events(mut self, events: &[Event]) -> Closing {
        self.events.extend_from_slice(events);
        self
    }

    /// Returns a tracker of the run with samples every `interval_s`, and at all jumps.
    fn track(&self, interval_s: f64) -> Tracker {
        let steps = (END_S / interval_s).round() as usize;
        let mut times: Vec<f64> = (0..=steps).map(|i| END_S * i as f64 / steps as f64).collect();
        times.extend([3e-3, 5e-3, 7e-3, 9e-3, 16e-3].map(|jump_s| jump_s + 1e-9));
        times.extend([8e-3 - 1e-9, 10e-3 + 1e-9]);
        times.sort_by(f64::total_cmp);
        let mut tracker = Tracker::new(TARGET);
        let mut events = self.events.iter().peekable();
        for time in times {
            while let Some(event) = events.next_if(|event| event.time_s <= time) {
                tracker.event(event).expect("never fails");
            }
            let ((angle, rate), [proximal, distal]) = ((self.angle)(time), (self.is_active)(time));
            let forces_n = [if proximal { 20.0 } else { 0.0 }, if distal { 8.0 } else { 0.0 }];
            let sample = posture(time, (TARGET.q11_rad + angle, rate), (TARGET.q21_rad, 0.0), forces_n);
            tracker.sample(&sample).expect("never fails");
        }
        tracker
    }
}

#[test]
fn criteria_of_closings_have_their_closed_forms() {
    use Class::{SemiUnstable, Unstable};
    let half_width = (1e-6 - EPSILON_RAD / 1e4).sqrt();
    let slow_s = 9e-3 - EPSILON_RAD / 2.0;
    for closing in [
        arrival(),
        Closing {
            name: "in position from the start",
            angle: |_| (0.0, 0.0),
            is_active: |_| [true; 2],
            events: Vec::new(),
            t_geo_s: Some(0.0),
            tts_s: Some((0.0, 0.0)),
            ..arrival()
        },
        Closing {
            name: "loses a contact at the end",
            is_active: |t| [t > 3e-3 && t < 19.95e-3, t > 5e-3],
            tts_s: None,
            lost_s: (0.05e-3, 1e-9),
            class: Unstable,
            ..arrival().with_events(&[lift_off(19.95e-3, Proximal, 0.3)])
        },
        // A parabola of 2 ms that leaves the band.
        Closing {
            name: "bounce",
            angle: |t| match t <= 5e-3 || t > 7e-3 {
                true => approach(t, 5e-3, 20.0),
                false => (1e4 * (t - 5e-3) * (t - 7e-3), 1e4 * (2.0 * t - 12e-3)),
            },
            is_active: |t| [true, t > 7e-3],
            events: vec![
                touch_down(5e-3, Distal, 1.0),
                lift_off(5e-3 + 5e-10, Distal, 1e-3),
                touch_down(7e-3, Distal, 0.5),
            ],
            tts_s: Some((7e-3, 2e-9)),
            lost_s: (2e-3, 5e-9),
            class: SemiUnstable,
            ..arrival()
        },
        // q11 deviates between 8 and 10 ms, and is out of the band while 1e4 x (2 ms − x) > ε.
        Closing {
            name: "leaves the band",
            angle: |t| match (8e-3..=10e-3).contains(&t) {
                true => (1e4 * (t - 8e-3) * (10e-3 - t), 1e4 * (18e-3 - 2.0 * t)),
                false => approach(t, 5e-3, 20.0),
            },
            tts_s: Some((9e-3 + half_width, 1e-9)),
            lost_s: (2.0 * half_width, 1e-8),
            class: SemiUnstable,
            ..arrival()
        },
        Closing {
            name: "reaches the band last",
            angle: |t| approach(t, 9e-3, 2.0),
            is_active: |t| [t > 3e-3; 2],
            events: [Proximal, Distal].map(|contact| touch_down(3e-3, contact, 1.0)).to_vec(),
            t_geo_s: Some(slow_s),
            tts_s: Some((slow_s, 1e-9)),
            ..arrival()
        },
        // A force clamped to zero counts as a lost contact.
        Closing {
            name: "clamped force",
            is_active: |t| [t > 3e-3, t > 5e-3 && !(10e-3..=12e-3).contains(&t)],
            intervals_s: &[1e-5],
            tts_s: Some((12e-3, 2e-5)),
            lost_s: (2e-3, 3e-5),
            class: SemiUnstable,
            ..arrival()
        },
        // A loss shorter than an impact is no rebound.
        Closing {
            name: "short loss",
            intervals_s: &[1e-4],
            tts_s: Some((5.15e-3 + 4e-7, 1e-12)),
            lost_s: (4e-7, 1e-12),
            ..arrival().with_events(&[lift_off(5.15e-3, Proximal, 0.3), touch_down(5.15e-3 + 4e-7, Proximal, 0.01)])
        },
        Closing {
            name: "late",
            angle: |t| approach(t, 16e-3, 20.0),
            is_active: |t| [t > 3e-3, t > 16e-3],
            events: vec![touch_down(3e-3, Proximal, 1.0), touch_down(16e-3, Distal, 1.0)],
            t_geo_s: Some(16e-3 - EPSILON_RAD / 20.0),
            tts_s: Some((16e-3, 2e-9)),
            class: SemiUnstable,
            ..arrival()
        },
        // An unloaded contact is not stable until reloaded.
        Closing {
            name: "unloaded",
            intervals_s: &[1e-4],
            is_active: |t| [t > 3e-3, t > 5e-3 && !(10.05e-3..=11.05e-3).contains(&t)],
            tts_s: Some((11.05e-3, 1e-12)),
            lost_s: (1e-3, 1e-9),
            class: SemiUnstable,
            ..arrival().with_events(&[lift_off(10.05e-3, Distal, 0.3), reload(11.05e-3, Distal)])
        },
        Closing {
            name: "never in position",
            angle: |_| (-0.1, 0.0),
            t_geo_s: None,
            tts_s: None,
            class: Unstable,
            ..arrival()
        },
        Closing {
            name: "one contact",
            is_active: |t| [t > 3e-3, false],
            events: vec![touch_down(3e-3, Proximal, 1.0)],
            tts_s: None,
            class: Unstable,
            ..arrival()
        },
    ] {
        for interval_s in closing.intervals_s {
            let criteria = closing.track(*interval_s).criteria(None).expect("a run");
            let (t_geo_s, tts_s) = (criteria.t_geo_s, criteria.tts_s);
            let context = format!("{}: {criteria:?}", closing.name);
            assert!(is_near(t_geo_s, closing.t_geo_s.map(|t_geo_s| (t_geo_s, 1e-9))), "{context}");
            assert!(is_near(tts_s, closing.tts_s), "{context}");
            assert!(is_near(Some(criteria.lost_s), Some(closing.lost_s)), "{context}");
            assert_eq!(criteria.class, closing.class, "{context}");
            let rebound = t_geo_s.zip(tts_s).map(|(geo_s, tts_s)| match closing.lost_s.0 >= RESOLUTION_S {
                true => (100.0 * ((geo_s + END_S) / (tts_s + END_S) - 1.0).abs(), 1e-12),
                false => (0.0, 0.0),
            });
            assert!(is_near(criteria.rebound_percent, rebound), "{context}");
            assert!(closing.name != "reaches the band last" || tts_s == t_geo_s, "{context}");
        }
    }
}

/// Whether two values agree within a tolerance, or neither exists.
fn is_near(value: Option<f64>, expected: Option<(f64, f64)>) -> bool {
    match (value, expected) {
        (Some(value), Some((expected, tolerance))) => (value - expected).abs() <= tolerance,
        (value, expected) => value.is_none() && expected.is_none(),
    }
}

#[test]
fn a_statically_unstable_grasp_is_unstable_for_any_dynamics() {
    let tracker = arrival().track(1e-3);
    assert_eq!(tracker.criteria(Some([3.0, 0.0])).expect("a run").class, Class::Stable);
    let unstable = tracker.criteria(Some([-1.2, 3.0])).expect("a run");
    assert_eq!((unstable.class, unstable.statically_stable), (Class::Unstable, false));
    let verdict = "unstable: the static force on the proximal phalanx is -1.2 N; it must not be negative";
    assert_eq!(unstable.verdict(), verdict);
}

/// Random synthetic closing of up to 30 ms: angles enter and leave the band, contacts close and open, mostly as those
/// of a finger do. Also returns the end of the run.
fn synthetic_closing(rng: &mut Random) -> (Tracker, f64) {
    let (end_s, steps) = (rng.within(2e-3, 30e-3), 40);
    let arrival = [0, 1, 2, 3].map(|_| rng.within(0.0, 0.9));
    let mut tracker = Tracker::new(TARGET);
    let (mut closed, mut previous_s) = ([false; 2], 0.0);
    for step in 0..=steps {
        let fraction = f64::from(step) / f64::from(steps);
        let time_s = end_s * fraction;
        for contact in [Proximal, Distal] {
            let index = contact as usize;
            let in_contact = fraction > arrival[index] && !rng.chance(0.05);
            if in_contact != closed[index] && step > 0 {
                let event_s = rng.within(previous_s, time_s);
                let event =
                    if in_contact { touch_down(event_s, contact, 1.0) } else { lift_off(event_s, contact, 0.1) };
                tracker.event(&event).expect("never fails");
                closed[index] = in_contact;
            }
        }
        let [q11, q21] = [2, 3].map(|index| match fraction > arrival[index] && !rng.chance(0.03) {
            true => rng.within(-0.9, 0.9) * EPSILON_RAD,
            false => rng.within(1.1, 5.0) * EPSILON_RAD,
        });
        let forces_n = closed.map(|closed| if closed { 8.0 } else { 0.0 });
        let sample = posture(time_s, (TARGET.q11_rad + q11, 0.0), (TARGET.q21_rad + q21, 0.0), forces_n);
        tracker.sample(&sample).expect("never fails");
        previous_s = time_s;
    }
    (tracker, end_s)
}

/// Asserts that class, figures and reason of a run agree.
fn assert_consistent(criteria: &Criteria, static_forces_n: Option<[f64; 2]>, end_s: f64) {
    let Criteria { tts_s, rebound_percent, class, t_geo_s, lost_s, statically_stable, class_reason } = *criteria;
    assert_eq!(class, Class::classify(tts_s, rebound_percent, statically_stable), "{criteria:?}");
    assert_eq!(class, class_reason.class(), "{criteria:?}");
    let has_negative_force = static_forces_n.is_some_and(|forces_n| forces_n.iter().any(|force_n| *force_n < 0.0));
    assert_eq!(statically_stable, !has_negative_force, "{criteria:?}");
    let sentence = class_reason.to_string();
    match class_reason {
        ClassReason::StaticForces { forces_n } => {
            assert_eq!(Some(forces_n), static_forces_n);
            assert!(has_negative_force && sentence.contains("negative"), "{criteria:?}");
        }
        ClassReason::OutOfPosition { deviation_rad } => {
            assert_eq!((tts_s, has_negative_force), (None, false), "{criteria:?}");
            assert!(deviation_rad.iter().any(|deviation_rad| *deviation_rad > EPSILON_RAD), "{criteria:?}");
            assert!(sentence.contains("at most 0.2°"), "{sentence}");
        }
        ClassReason::NotInContact { phalanges } => {
            assert_eq!((tts_s, has_negative_force), (None, false), "{criteria:?}");
            assert!(
                t_geo_s.is_some() && phalanges.iter().any(|at_end| *at_end != FinalContact::Active),
                "{criteria:?}"
            );
            let lift_off_s =
                phalanges.map(|at_end| if let FinalContact::LiftedOff { at_s } = at_end { at_s } else { 0.0 });
            assert!(lift_off_s.iter().all(|at_s| (0.0..end_s).contains(at_s)), "{criteria:?}");
        }
        ClassReason::Settled { tts_s: tts, rebound_percent: rebound, loss } => {
            assert_eq!((Some(tts), Some(rebound), has_negative_force), (tts_s, rebound_percent, false), "{criteria:?}");
            assert_eq!(loss.is_some(), lost_s >= RESOLUTION_S && rebound > 0.0, "{criteria:?}");
            let limit = match class {
                Class::Stable => "less than 15 ms",
                Class::SemiStable => "at most 5 %",
                Class::SemiUnstable if tts < 15e-3 => "more than 5 %",
                Class::SemiUnstable | Class::Unstable => "limit is 20 ms",
            };
            assert!(sentence.contains(limit), "{sentence} for {criteria:?}");
            if let Some(loss) = loss {
                // The last loss ends when the finger becomes stable, or earlier if another condition is met last.
                assert!(loss.from_s < loss.until_s && loss.until_s <= tts, "{criteria:?}");
                assert!(t_geo_s.is_some_and(|t_geo_s| loss.until_s > t_geo_s), "{criteria:?}");
            }
        }
    }
}

#[test]
fn reason_and_class_agree() {
    let mut rng = Random::for_seed(9);
    let mut reason_counts = [0; 4];
    let mut class_counts = [0; 4];
    for _ in 0..4000 {
        let (tracker, end_s) = synthetic_closing(&mut rng);
        let forces_n = [rng.within(-1.0, 9.0), rng.within(-1.0, 9.0)];
        for static_forces_n in [None, Some(forces_n)] {
            let criteria = tracker.criteria(static_forces_n).expect("a run");
            assert_consistent(&criteria, static_forces_n, end_s);
            class_counts[criteria.class as usize] += 1;
            reason_counts[match criteria.class_reason {
                ClassReason::StaticForces { .. } => 0,
                ClassReason::OutOfPosition { .. } => 1,
                ClassReason::NotInContact { .. } => 2,
                ClassReason::Settled { .. } => 3,
            }] += 1;
        }
    }
    assert!(reason_counts.iter().chain(&class_counts).all(|count| *count > 20), "{reason_counts:?} {class_counts:?}");
}

#[test]
fn a_run_without_duration_has_no_class() {
    let mut tracker = Tracker::new(TARGET);
    assert_eq!(tracker.criteria(None), None);
    tracker.sample(&posture(0.0, (0.0, 0.0), (0.0, 0.0), [0.0; 2])).expect("never fails");
    assert_eq!(tracker.criteria(None), None);
}

/// Returns the criteria of a run and the run.
fn run_with_criteria(scene: &Scene) -> (Criteria, Recording) {
    let run = record_run(Model::Analytic, scene);
    (run.run_criteria.as_ref().and_then(|all| all.criteria).expect("a grasp"), run)
}

/// Time of the first event of a kind at a contact, s.
fn first_s(run: &Recording, contact: usize, kind: EventKind) -> f64 {
    let event = run.events.iter().find(|event| event.contact == contact && event.kind == kind);
    event.unwrap_or_else(|| panic!("no {kind:?} at contact {contact}")).time_s
}

/// The anchor case, design 95 of the thesis, at every log rate.
#[test]
fn design_95_is_stable_from_tip_contact_on() {
    let mut scene = load("experiment-95");
    for numeric_hz in [1e3, 1e4, 1e6] {
        scene.log.numeric_hz = numeric_hz;
        let (criteria, run) = run_with_criteria(&scene);
        // 1-model §1.8: the tip touches at 6.883746 ms, and nothing rebounds.
        let tts = criteria.tts_s.expect("stable");
        assert!((tts - 6.883746e-3).abs() < 1e-7, "{tts}");
        assert_eq!(criteria.tts_s, run.outcome.contacts[1].first_s);
        // q11 arrives at about 260 rad/s, so the last 0.2° take 13.5 µs.
        let approach = tts - criteria.t_geo_s.expect("in position");
        assert!((approach - 13.5e-6).abs() < 0.1e-6, "{approach}");
        assert_eq!((criteria.rebound_percent, criteria.class), (Some(0.0), Class::Stable));
    }
}

#[test]
fn verdicts_give_the_unmet_condition_and_the_limit() {
    let with_damping = |mut scene: Scene, damping_n_s_per_m: f64| {
        let laws = scene.finger_mut().contact.both_mut();
        laws.into_iter().for_each(|law| law.normal = law.normal.with_damping_max(damping_n_s_per_m));
        scene
    };
    let anchor = load("experiment-95");
    for (scene, verdict) in [
        (
            with_damping(anchor.clone(), 1e4),
            "unstable: q21 ends 0.249° from the grasp; at most 0.2° count as in position",
        ),
        // In position from 6.870 ms on; the tip touches at 6.884 ms.
        (
            Scene { duration_s: 6.875e-3, ..anchor.clone() },
            "unstable: the distal phalanx has not touched the object; both phalanges must be in contact at the end",
        ),
        (
            Scene { duration_s: 6e-3, ..anchor },
            "unstable: q11 ends 12.2° from the grasp; at most 0.2° count as in position",
        ),
        (load("hard/mass-crank-heavy"), "unstable: stable only after 32.7 ms; the limit is 20 ms"),
        (load("hard/end-cap"), "unstable: the static force on the distal phalanx is -20.3 N; it must not be negative"),
    ] {
        assert_eq!(run_with_criteria(&scene).0.verdict(), verdict);
    }
}

/// The lift-off and the touch-down in the reason are events of the run. The force may be zero a moment before the
/// lift-off.
#[test]
fn verdict_of_a_rebound_names_the_phalanx_and_the_time() {
    let (criteria, run) = run_with_criteria(&load("hard/torque-steps"));
    let ClassReason::Settled { loss: Some(loss), .. } = criteria.class_reason else { panic!("{criteria:?}") };
    assert_eq!((loss.condition, loss.touched_first, loss.times), (Condition::Tip, false, 1));
    let has_tip_event = |kinds: &[EventKind], time_s: f64| {
        let mut tip = run.events.iter().filter(|event| event.contact == 1 && kinds.contains(&event.kind));
        tip.any(|event| (event.time_s - time_s).abs() < 2e-7)
    };
    assert!(has_tip_event(&[EventKind::LiftOff], loss.from_s), "{loss}: {:?}", run.events);
    let contact_kinds = [EventKind::TouchDown, EventKind::Reload];
    assert!(has_tip_event(&contact_kinds, loss.until_s), "{loss}: {:?}", run.events);
    assert_eq!(Some(loss.until_s), criteria.tts_s);
    assert_eq!(
        criteria.verdict(),
        "semi-unstable: rebound 12 %, more than 5 %; the distal phalanx lifted off from 8 ms to 10.9 ms"
    );
}

const TIP_FIRST: &str = r#"
duration = "40 ms"
[lengths]
l11 = "20 mm"
l21 = "31 mm"
l22 = "10 mm"
t22 = "17 mm"
phi22 = "115 deg"
[object]
radius = "25 mm"
centre = ["-21 mm", "25 mm"]
[motor]
torque = "600 N*mm"
[spring]
type = "torsional"
preload = "110 deg"
stiffness = "20 N*mm/rad"
[contact.friction]
mu_static = 0.5
"#;

#[test]
fn a_finger_whose_tip_touches_first_and_lifts_off_is_semi_stable() {
    let scene = scene::parse(TIP_FIRST, "tip-first.toml").unwrap_or_else(|error| panic!("{error}"));
    let (criteria, run) = run_with_criteria(&scene);
    assert_eq!(criteria.class, Class::SemiStable);
    let [proximal_s, tip_s] = [0, 1].map(|contact| first_s(&run, contact, EventKind::TouchDown));
    assert!(tip_s < proximal_s, "{tip_s} {proximal_s}");
    let verdict = criteria.verdict();
    let lift_off_ms = first_s(&run, 1, EventKind::LiftOff) * 1e3;
    let expected = format!("; the distal phalanx touched first and lifted off from {lift_off_ms:.2} ms to ");
    assert!(
        verdict.starts_with("semi-stable: rebound 0.26 %, at most 5 %; ") && verdict.contains(&expected),
        "{verdict}"
    );
}
