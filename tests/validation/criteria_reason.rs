//! The reason for a class agrees with the class and the figures of the run.

use crate::rng::Rng;
use crate::support::runs::CollectSink;
use crate::support::synthetic::{lift_off, posture, touch_down};
use phalanx::criteria::{
    Class, ClassReason, Condition, Criteria, EPSILON_RAD, FinalAngles, FinalContact, RESOLUTION_S, RunCriteriaTracker,
    Tracker,
};
use phalanx::scene::{self, Scene};
use phalanx::trace::{Event, EventKind, FingerContact, Model, Sample, Sink, SinkError, run};

const TARGET: FinalAngles = FinalAngles { q11_rad: 0.036, q21_rad: 1.134 };

/// Random synthetic closing of up to 30 ms: angles enter and leave the band, contacts close and open, mostly as those
/// of a finger do. Also returns the end of the run.
fn synthetic_closing(rng: &mut Rng) -> (Tracker, f64) {
    let (end_s, steps) = (rng.uniform(2e-3, 30e-3), 40);
    let arrival = [0, 1, 2, 3].map(|_| rng.uniform(0.0, 0.9));
    let mut tracker = Tracker::new(TARGET);
    let (mut closed, mut previous_s) = ([false; 2], 0.0);
    for step in 0..=steps {
        let fraction = f64::from(step) / f64::from(steps);
        let time_s = end_s * fraction;
        for contact in [FingerContact::Proximal, FingerContact::Distal] {
            let index = contact as usize;
            let in_contact = fraction > arrival[index] && !rng.chance(0.05);
            if in_contact != closed[index] && step > 0 {
                let event_s = rng.uniform(previous_s, time_s);
                let event: Event =
                    if in_contact { touch_down(event_s, contact, 1.0) } else { lift_off(event_s, contact, 0.1) };
                tracker.event(&event).expect("never fails");
                closed[index] = in_contact;
            }
        }
        let [q11, q21] = [2, 3].map(|index| match fraction > arrival[index] && !rng.chance(0.03) {
            true => rng.uniform(-0.9, 0.9) * EPSILON_RAD,
            false => rng.uniform(1.1, 5.0) * EPSILON_RAD,
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
    let mut rng = Rng::new(9);
    let mut reason_counts = [0; 4];
    let mut class_counts = [0; 4];
    for _ in 0..4000 {
        let (tracker, end_s) = synthetic_closing(&mut rng);
        let forces_n = [rng.uniform(-1.0, 9.0), rng.uniform(-1.0, 9.0)];
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

fn load_scene(file: &str) -> Scene {
    scene::load(format!("scenes/{file}")).unwrap_or_else(|error| panic!("{error}"))
}

struct TwoSinks(RunCriteriaTracker, CollectSink);

impl Sink for TwoSinks {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.sample(sample)?;
        self.1.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.0.event(event)?;
        self.1.event(event)
    }
}

/// Returns the criteria of a run and the run.
fn run_with_criteria(scene: &Scene) -> (Criteria, CollectSink) {
    let mut sinks = TwoSinks(RunCriteriaTracker::for_scene(scene), CollectSink::default());
    run(Model::Analytic, scene, &mut sinks).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
    (sinks.0.finish(true).criteria.expect("a grasp"), sinks.1)
}

fn verdict(scene: &Scene) -> String {
    run_with_criteria(scene).0.verdict()
}

#[test]
fn verdict_out_of_position_gives_the_deviation() {
    let mut scene = load_scene("experiment-95.toml");
    let contact = &mut scene.system.fingers[0].contact;
    for law in [&mut contact.proximal.normal, &mut contact.distal.normal] {
        law.damping_max_n_s_per_m = 1e4;
    }
    assert_eq!(verdict(&scene), "unstable: q21 ends 0.249° from the grasp; at most 0.2° count as in position");
}

#[test]
fn verdict_of_a_short_run_names_the_unmet_condition() {
    let mut scene = load_scene("experiment-95.toml");
    // In position from 6.870 ms on; the tip touches at 6.884 ms.
    scene.duration_s = 6.875e-3;
    assert_eq!(
        verdict(&scene),
        "unstable: the distal phalanx has not touched the object; both phalanges must be in contact at the end"
    );
    scene.duration_s = 6e-3;
    let sentence = verdict(&scene);
    assert!(sentence.starts_with("unstable: q11 ends 12.2° from the grasp; "), "{sentence}");
}

#[test]
fn verdict_of_a_late_or_statically_unstable_grasp_gives_the_limit() {
    assert_eq!(
        verdict(&load_scene("hard/mass-crank-heavy.toml")),
        "unstable: stable only after 32.7 ms; the limit is 20 ms"
    );
    assert_eq!(
        verdict(&load_scene("hard/end-cap.toml")),
        "unstable: the static force on the distal phalanx is -20.3 N; it must not be negative"
    );
}

/// The lift-off and the touch-down in the reason are events of the run. The force may be zero a moment before the
/// lift-off.
#[test]
fn verdict_of_a_rebound_names_the_phalanx_and_the_time() {
    let (criteria, run) = run_with_criteria(&load_scene("hard/torque-steps.toml"));
    let ClassReason::Settled { loss: Some(loss), .. } = criteria.class_reason else { panic!("{criteria:?}") };
    assert_eq!((loss.condition, loss.touched_first, loss.times), (Condition::Tip, false, 1));
    let has_tip_event = |kind: EventKind, time_s: f64| {
        run.events.iter().any(|event| event.contact == 1 && event.kind == kind && (event.time_s - time_s).abs() < 2e-7)
    };
    assert!(has_tip_event(EventKind::LiftOff, loss.from_s), "{loss}: {:?}", run.events);
    assert!(
        has_tip_event(EventKind::TouchDown, loss.until_s) || has_tip_event(EventKind::Reload, loss.until_s),
        "{loss}: {:?}",
        run.events
    );
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
    let [proximal_s, tip_s] = [0, 1].map(|contact| run.first_contact_s(contact).expect("both touch"));
    assert!(tip_s < proximal_s, "{tip_s} {proximal_s}");
    let lift_off_s = run.event_time_s(1, EventKind::LiftOff);
    let sentence = criteria.verdict();
    let expected = format!("; the distal phalanx touched first and lifted off from {:.2} ms to ", lift_off_s * 1e3);
    assert!(
        sentence.starts_with("semi-stable: rebound 0.26 %, at most 5 %; ") && sentence.contains(&expected),
        "{sentence}"
    );
}
