//! The reason for a class agrees with the class and the figures of the run.

use crate::hard_scenes::load;
use crate::support::checked_run::record_run;
use crate::support::random::Random;
use crate::support::synthetic::{lift_off, posture, touch_down};
use phalanx::criteria::{
    Class, ClassReason, Condition, Criteria, EPSILON_RAD, FinalAngles, FinalContact, RESOLUTION_S, Tracker,
};
use phalanx::scene::{self, Scene};
use phalanx::trace::{EventKind, FingerContact, Model, Sink};
use phalanx::validate::Recording;

const TARGET: FinalAngles = FinalAngles { q11_rad: 0.036, q21_rad: 1.134 };

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
        for contact in [FingerContact::Proximal, FingerContact::Distal] {
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
        laws.into_iter().for_each(|law| law.normal.damping_max_n_s_per_m = damping_n_s_per_m);
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
