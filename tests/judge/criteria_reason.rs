//! What is said to decide a class decides it, whatever the run.

use crate::dice::Dice;
use crate::support::collect::Collect;
use crate::support::synthetic::{lift_off, posture, touch_down};
use phalanx::criteria::{
    AtEnd, Class, ClassReason, Condition, Criteria, EPSILON_RAD, FinalAngles, Judge, RESOLUTION_S, Tracker,
};
use phalanx::scene::{self, Scene};
use phalanx::trace::{Event, EventKind, Model, Sample, Sink, SinkError, Site, run};

const TARGET: FinalAngles = FinalAngles { q11_rad: 0.036, q21_rad: 1.134 };

/// A made-up closing of up to 30 ms: angles in and out of the band, contacts that come and go, mostly as a finger does.
fn made_up(dice: &mut Dice) -> (Tracker, f64) {
    let (end_s, steps) = (dice.within(2e-3, 30e-3), 40);
    let arrival = [0, 1, 2, 3].map(|_| dice.within(0.0, 0.9));
    let mut tracker = Tracker::new(TARGET);
    let (mut closed, mut from_s) = ([false; 2], 0.0);
    for step in 0..=steps {
        let part = f64::from(step) / f64::from(steps);
        let time_s = end_s * part;
        for site in [Site::Proximal, Site::Distal] {
            let index = site as usize;
            let wanted = part > arrival[index] && !dice.chance(0.05);
            if wanted != closed[index] && step > 0 {
                let at_s = dice.within(from_s, time_s);
                let event: Event = if wanted { touch_down(at_s, site, 1.0) } else { lift_off(at_s, site, 0.1) };
                tracker.event(&event).expect("never fails");
                closed[index] = wanted;
            }
        }
        let [q11, q21] = [2, 3].map(|index| match part > arrival[index] && !dice.chance(0.03) {
            true => dice.within(-0.9, 0.9) * EPSILON_RAD,
            false => dice.within(1.1, 5.0) * EPSILON_RAD,
        });
        let forces_n = closed.map(|closed| if closed { 8.0 } else { 0.0 });
        let sample = posture(time_s, (TARGET.q11_rad + q11, 0.0), (TARGET.q21_rad + q21, 0.0), forces_n);
        tracker.sample(&sample).expect("never fails");
        from_s = time_s;
    }
    (tracker, end_s)
}

/// Asserts that class, figures and reason of a run say the same.
fn consistent(criteria: &Criteria, static_forces_n: Option<[f64; 2]>, end_s: f64) {
    let Criteria { tts_s, rebound_percent, class, t_geo_s, lost_s, statically_stable, class_reason } = *criteria;
    assert_eq!(class, Class::of(tts_s, rebound_percent, statically_stable), "{criteria:?}");
    assert_eq!(class, class_reason.class(), "{criteria:?}");
    let pulls = static_forces_n.is_some_and(|forces_n| forces_n.iter().any(|force_n| *force_n < 0.0));
    assert_eq!(statically_stable, !pulls, "{criteria:?}");
    let sentence = class_reason.to_string();
    match class_reason {
        ClassReason::StaticForces { forces_n } => {
            assert_eq!(Some(forces_n), static_forces_n);
            assert!(pulls && sentence.contains("negative"), "{criteria:?}");
        }
        ClassReason::OutOfPosition { off_rad } => {
            assert_eq!((tts_s, pulls), (None, false), "{criteria:?}");
            assert!(off_rad.iter().any(|off_rad| *off_rad > EPSILON_RAD), "{criteria:?}");
            assert!(sentence.contains("at most 0.2°"), "{sentence}");
        }
        ClassReason::NotPressing { phalanges } => {
            assert_eq!((tts_s, pulls), (None, false), "{criteria:?}");
            assert!(t_geo_s.is_some() && phalanges.iter().any(|at_end| *at_end != AtEnd::Presses), "{criteria:?}");
            let since_s = phalanges.map(|at_end| if let AtEnd::LiftedOff { at_s } = at_end { at_s } else { 0.0 });
            assert!(since_s.iter().all(|at_s| (0.0..end_s).contains(at_s)), "{criteria:?}");
        }
        ClassReason::Settled { tts_s: tts, rebound_percent: rebound, loss } => {
            assert_eq!((Some(tts), Some(rebound), pulls), (tts_s, rebound_percent, false), "{criteria:?}");
            assert_eq!(loss.is_some(), lost_s >= RESOLUTION_S && rebound > 0.0, "{criteria:?}");
            let limit = match class {
                Class::Stable => "less than 15 ms",
                Class::SemiStable => "at most 5 %",
                Class::SemiUnstable if tts < 15e-3 => "more than 5 %",
                Class::SemiUnstable | Class::Unstable => "limit is 20 ms",
            };
            assert!(sentence.contains(limit), "{sentence} for {criteria:?}");
            if let Some(loss) = loss {
                // The last loss ends where the finger is stable, unless something came into its place for the first time then.
                assert!(loss.from_s < loss.until_s && loss.until_s <= tts, "{criteria:?}");
                assert!(t_geo_s.is_some_and(|t_geo_s| loss.until_s > t_geo_s), "{criteria:?}");
            }
        }
    }
}

#[test]
fn reason_and_class_never_contradict() {
    let mut dice = Dice::new(9);
    let mut kinds = [0; 4];
    let mut classes = [0; 4];
    for _ in 0..4000 {
        let (tracker, end_s) = made_up(&mut dice);
        let forces_n = [dice.within(-1.0, 9.0), dice.within(-1.0, 9.0)];
        for static_forces_n in [None, Some(forces_n)] {
            let criteria = tracker.criteria(static_forces_n).expect("a run");
            consistent(&criteria, static_forces_n, end_s);
            classes[criteria.class as usize] += 1;
            kinds[match criteria.class_reason {
                ClassReason::StaticForces { .. } => 0,
                ClassReason::OutOfPosition { .. } => 1,
                ClassReason::NotPressing { .. } => 2,
                ClassReason::Settled { .. } => 3,
            }] += 1;
        }
    }
    assert!(kinds.iter().chain(&classes).all(|count| *count > 20), "{kinds:?} {classes:?}");
}

#[test]
fn a_run_without_duration_has_no_class() {
    let mut tracker = Tracker::new(TARGET);
    assert_eq!(tracker.criteria(None), None);
    tracker.sample(&posture(0.0, (0.0, 0.0), (0.0, 0.0), [0.0; 2])).expect("never fails");
    assert_eq!(tracker.criteria(None), None);
}

fn shipped(file: &str) -> Scene {
    scene::load(format!("scenes/{file}")).unwrap_or_else(|error| panic!("{error}"))
}

struct Both(Judge, Collect);

impl Sink for Both {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.sample(sample)?;
        self.1.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.0.event(event)?;
        self.1.event(event)
    }
}

/// The criteria of a run, and the run.
fn judged(scene: &Scene) -> (Criteria, Collect) {
    let mut sinks = Both(Judge::of(scene), Collect::default());
    run(Model::Analytic, scene, &mut sinks).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
    (sinks.0.judged(true).criteria.expect("a grasp"), sinks.1)
}

fn verdict(scene: &Scene) -> String {
    judged(scene).0.verdict()
}

#[test]
fn a_finger_that_ends_out_of_position_says_how_far() {
    let mut scene = shipped("experiment-95.toml");
    let contact = &mut scene.system.fingers[0].contact;
    for law in [&mut contact.proximal.normal, &mut contact.distal.normal] {
        law.damping_max_n_s_per_m = 1e4;
    }
    assert_eq!(verdict(&scene), "unstable: q21 ends 0.249° from the grasp; at most 0.2° count as in position");
}

#[test]
fn a_run_that_ends_too_soon_says_what_is_missing() {
    let mut scene = shipped("experiment-95.toml");
    // In position from 6.870 ms on; the tip touches at 6.884 ms.
    scene.duration_s = 6.875e-3;
    assert_eq!(verdict(&scene), "unstable: the tip has not touched the object; both phalanges must press at the end");
    scene.duration_s = 6e-3;
    let said = verdict(&scene);
    assert!(said.starts_with("unstable: q11 ends 12.2° from the grasp; "), "{said}");
}

#[test]
fn a_late_or_pulling_grasp_says_so() {
    assert_eq!(
        verdict(&shipped("hard/mass-crank-heavy.toml")),
        "unstable: stable only after 32.7 ms; the limit is 20 ms"
    );
    assert_eq!(
        verdict(&shipped("hard/end-cap.toml")),
        "unstable: the static force on the tip is -20.3 N; it must not be negative"
    );
}

/// The lift-off and the touch-down that the reason names are events of the run. The force may be zero a moment before the lift-off.
#[test]
fn a_rebound_says_which_phalanx_lifted_off_and_when() {
    let (criteria, run) = judged(&shipped("hard/torque-steps.toml"));
    let ClassReason::Settled { loss: Some(loss), .. } = criteria.class_reason else { panic!("{criteria:?}") };
    assert_eq!((loss.of, loss.touched_first, loss.times), (Condition::Tip, false, 1));
    let at = |kind: EventKind, time_s: f64| {
        run.events.iter().any(|event| event.contact == 1 && event.kind == kind && (event.time_s - time_s).abs() < 2e-7)
    };
    assert!(at(EventKind::LiftOff, loss.from_s), "{loss}: {:?}", run.events);
    assert!(at(EventKind::TouchDown, loss.until_s) || at(EventKind::Reload, loss.until_s), "{loss}: {:?}", run.events);
    assert_eq!(Some(loss.until_s), criteria.tts_s);
    assert_eq!(
        criteria.verdict(),
        "semi-unstable: rebound 12 %, more than 5 %; the tip lifted off at 8 ms, until 10.9 ms"
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
fn a_tip_that_touches_first_and_lifts_off_makes_a_finger_semi_stable() {
    let scene = scene::parse(TIP_FIRST, "tip-first.toml").unwrap_or_else(|error| panic!("{error}"));
    let (criteria, run) = judged(&scene);
    assert_eq!(criteria.class, Class::SemiStable);
    let [proximal_s, tip_s] = [0, 1].map(|contact| run.first_touch(contact).expect("both touch"));
    assert!(tip_s < proximal_s, "{tip_s} {proximal_s}");
    let lift_off_s = run.time(1, EventKind::LiftOff);
    let said = criteria.verdict();
    let expected = format!("; the tip touched first and lifted off at {:.2} ms, until ", lift_off_s * 1e3);
    assert!(said.starts_with("semi-stable: rebound 0.26 %, at most 5 %; ") && said.contains(&expected), "{said}");
}
