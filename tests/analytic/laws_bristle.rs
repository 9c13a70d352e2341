//! Stiction of discs, compared with closed-form motions.

use phalanx::check::check;
use phalanx::law::{Bristle, FrictionKind, FrictionLaw};
use phalanx::log::Solver;
use phalanx::mechanism::OutlineShape;
use phalanx::scene::{self, Integrator, Preset, Scene};
use phalanx::trace::{EventKind, Model, Outcome, Sample};
use phalanx::validate::{SolverConfiguration, ladder_configurations};

use crate::support::laws::{
    self, BOTH_MODELS, CollectSink, THESIS_FRICTION, THESIS_NORMAL, change_contact_law, free, mechanism, run_to_end,
};
use crate::support::runs::{self, assert_below, run_model};

const G: f64 = 9.81;

fn load(name: &str) -> Scene {
    scene::load_any(format!("scenes/laws/bristle-{name}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

fn run(model: Model, scene: &Scene) -> (Outcome, CollectSink) {
    let mut scene = scene.clone();
    scene.apply_preset(Preset::Reference);
    run_model(model, &scene)
}

/// Both models with their relative tolerances.
const TOLERANCES: [(Model, f64); 2] = [(Model::Analytic, 1e-9), (Model::Engine, 1e-4)];

/// Sticking: the mass deflects a bristle of 1e9 N/m.
#[test]
fn a_block_on_an_incline_sticks_within_the_friction_cone_and_slides_beyond_it() {
    for (model, tolerance) in TOLERANCES {
        let mut scene = load("holds");
        let last = run(model, &scene).0.last;
        let holds = mechanism(&mut scene);
        let stretch = 0.1 * holds.gravity_m_s2[0] / 1e9;
        let shift = last.body(0).centre_m[0] - holds.bodies[0].pose[0];
        assert_below((shift - stretch).abs(), tolerance * 1e-6, format!("{model:?}: stretch"));
        assert_below(last.contact(0).slip_m_s.abs(), 1e-15, format!("{model:?}: slip"));

        let [gx, gy] = mechanism(&mut load("slides")).gravity_m_s2;
        let speed = run(model, &load("slides")).0.last.body(0).velocity_m_s[0];
        assert_below((speed - (1.0 + 0.1 * (gx + 0.7 * 0.5 * gy))).abs(), tolerance, format!("{model:?}: speed"));
    }
}

/// Time for which the disc of the scene `rolls` slides, s.
const SLIDING_TIME_S: f64 = 1.0 / (3.0 * 0.3 * G);

#[test]
fn a_sliding_disc_ends_up_rolling_without_creep() {
    for (model, tolerance) in TOLERANCES {
        let (outcome, log) = run(model, &load("rolls"));
        let wheel = outcome.last.body(0);
        assert_below((wheel.velocity_m_s[0] - 2.0 / 3.0).abs(), tolerance, format!("{model:?}: speed"));
        assert_below((wheel.spin_rad_s + 40.0 / 3.0).abs(), 20.0 * tolerance, format!("{model:?}: spin"));
        assert_below(outcome.last.contact(0).slip_m_s.abs(), 1e-12, format!("{model:?}: slip"));
        // Slip decreases linearly until then.
        for sample in log.samples.iter().filter(|sample| sample.time_s < SLIDING_TIME_S) {
            let expected = 1.0 - 0.3 * G * sample.time_s;
            assert_below((sample.body(0).velocity_m_s[0] - expected).abs(), 10.0 * tolerance, sample.time_s);
        }
        let sticks = log.samples.iter().find(|sample| sample.contact(0).slip_m_s.abs() < 1e-6).expect("sticking");
        assert_below((sticks.time_s - SLIDING_TIME_S).abs(), 2e-4, format!("{model:?}: time"));
    }
}

/// The scene `jams` with its two large discs at this distance from the centre, turned down by an angle.
fn wedge(distance: f64, angle_rad: f64) -> Scene {
    let mut scene = load("jams");
    let (sin, cos) = angle_rad.sin_cos();
    for outline in &mut mechanism(&mut scene).ground_outlines {
        if let OutlineShape::Disc { center_m, .. } = &mut outline.shape {
            *center_m = [center_m[0].signum() * distance * cos, -distance * sin];
        }
    }
    scene
}

/// Distance at which the discs of [`wedge`] overlap the small one between them by 0.1 mm.
const WEDGE_DISTANCE_M: f64 = 10.0 + 0.02 - 1e-4;

/// The wedge jams up to the friction angle, found to a hundredth of a degree.
#[test]
fn a_wedge_jams_up_to_the_friction_angle() {
    let limit = 0.4f64.atan().to_degrees();
    for model in BOTH_MODELS {
        let max_speed = |degrees: f64| {
            let last = run(model, &wedge(WEDGE_DISTANCE_M, degrees.to_radians())).0.last;
            last.bodies().map(|body| body.velocity_m_s[0].hypot(body.velocity_m_s[1])).fold(0.0, f64::max)
        };
        assert_below(max_speed(limit - 0.01), 1e-9, format!("{model:?}: speed below the limit"));
        assert!(max_speed(limit + 0.01) > 1e-4, "{model:?}: at rest beyond the limit");
    }
}

/// The scene `stick-slip` with v_static, and with v_dynamic of twice as much.
fn stick_slip(v_static_m_s: f64) -> Scene {
    let mut scene = load("stick-slip");
    change_contact_law(&mut scene, |law| {
        let friction = law.friction.as_mut().expect("friction");
        (friction.v_static_m_s, friction.v_dynamic_m_s) = (v_static_m_s, 2.0 * v_static_m_s);
    });
    scene
}

/// Stiffness of the spring of `stick-slip` over its mass and speed: eigenfrequency in rad/s and pull in N/s.
const OMEGA: f64 = 100.0;
const PULL: f64 = 100.0;

/// Durations of sticking and of slipping in the limit of dry friction, s.
fn dry_durations() -> [f64; 2] {
    let force_drop = 0.15 * G;
    let slipping = (std::f64::consts::TAU - 2.0 * (force_drop * OMEGA / PULL).atan()) / OMEGA;
    [2.0 * force_drop / PULL, slipping]
}

/// Times at which the block begins to slip, and times at which it sticks again.
fn slip_and_stick_times(samples: &[Sample]) -> (Vec<f64>, Vec<f64>) {
    let moving =
        |sample: &Sample| sample.bodies().any(|body| body.velocity_m_s[0] > 2e-3 && body.velocity_m_s[0] != 0.01);
    let (mut slips, mut sticks) = (Vec::new(), Vec::new());
    for pair in samples.windows(2) {
        match (moving(&pair[0]), moving(&pair[1])) {
            (false, true) => slips.push(pair[1].time_s),
            (true, false) => sticks.push(pair[1].time_s),
            _ => {}
        }
    }
    (slips, sticks)
}

/// A mass pulled by a spring sticks and slips. The period converges to that of dry friction, 72.78 ms, with the square
/// root of v_static.
#[test]
fn stick_slip_period_converges_to_the_dry_friction_limit() {
    let dry_period: f64 = dry_durations().into_iter().sum();
    for model in BOTH_MODELS {
        let errors = [1e-4, 1e-5, 1e-6].map(|v_static| {
            let mut scene = stick_slip(v_static);
            scene.log.numeric_hz = 1e5;
            let (slips, sticks) = slip_and_stick_times(&run(model, &scene).1.samples);
            assert!(slips.len() >= 4 && sticks.len() >= 3, "{model:?}: {slips:?} {sticks:?}");
            let last = slips.len() - 1;
            let period = (slips[last] - slips[1]) / (last - 1) as f64;
            (period - dry_period).abs() / dry_period
        });
        assert!(errors[2] < 0.005 && errors[1] < 0.5 * errors[0] && errors[2] < 0.5 * errors[1], "{errors:?}");
    }
}

/// Slip begins within a range of 1 µm/s. With rates resolved to only 1e-9 m/s, two methods differ by 1.2e-7 m.
#[test]
fn reference_settings_resolve_the_onset_of_slip() {
    let mut scene = load("stick-slip");
    scene.apply_preset(Preset::Reference);
    let positions = [scene.integrator.atol_rate_rad_s, 1e-13].map(|atol_rate_rad_s| {
        let integrator = Integrator { atol_rate_rad_s, ..scene.integrator };
        runs::run_to_end(&Scene { integrator, ..scene.clone() }).0.last.body(0).centre_m[0]
    });
    assert!((positions[0] - positions[1]).abs() < 1e-9, "{positions:?}");
    assert_below(check(Model::Analytic, &scene, &|| true).errors.path, 2e-8, "difference from the other method in m");
    // `validate` uses the same settings for its reference.
    let configurations = ladder_configurations(&load("stick-slip"), true);
    let reference = configurations.into_iter().find(SolverConfiguration::is_reference).expect("the reference");
    assert_eq!(reference.settings, Solver::Analytic(scene.integrator));
}

/// Below half of v_static there is no stick-slip, because friction does not fall with speed there.
#[test]
fn a_mass_pulled_below_v_static_creeps_without_stick_slip() {
    for model in BOTH_MODELS {
        let (_, log) = run(model, &stick_slip(0.03));
        let late_samples = log.samples.iter().filter(|sample| sample.time_s > 0.1);
        let speeds = late_samples.flat_map(|sample| sample.bodies()).map(|body| body.velocity_m_s[0]);
        assert_below(speeds.fold(0.0, f64::max), 0.0201, format!("{model:?}"));
    }
}

/// A disc is pinched between two vertical surfaces. With regularised friction it sinks at W/(1.5 μ_s/v_s · ΣF_n); with
/// bristles, which deflect measurably under the weight, it does not sink, even in a minute.
#[test]
fn a_pinched_disc_sinks_with_regularised_friction_and_stays_with_stiction() {
    let mut scene = wedge(WEDGE_DISTANCE_M, 0.0);
    mechanism(&mut scene).gravity_m_s2 = [0.0, -G];
    let (weight, normal) = (0.05 * G, 1e6 * 1e-4);
    let friction = laws::contact_law(&scene).friction.expect("friction");
    let FrictionKind::Bristle(bristle) = friction.kind else { panic!("no bristle") };
    let stretch = 0.5 * weight * bristle.relaxation_s / bristle.damping_n_s_per_m;
    let mut regularised = scene.clone();
    regularised.duration_s = 0.1;
    change_contact_law(&mut regularised, |law| {
        law.friction = Some(FrictionLaw { kind: FrictionKind::Regularised, ..friction })
    });
    let sinking_speed = weight * friction.v_static_m_s / (1.5 * friction.mu_static * 2.0 * normal);
    for (model, duration_s) in [(Model::Analytic, 60.0), (Model::Engine, 0.2)] {
        scene.duration_s = duration_s;
        let last = run(model, &scene).0.last;
        assert_below((last.body(0).centre_m[1] + stretch).abs(), 1e-12, format!("{model:?}: height"));
        assert_below(last.contact(0).slip_m_s.abs(), 1e-15, format!("{model:?}: slip"));
        let speed = -run(model, &regularised).0.last.body(0).velocity_m_s[1];
        assert_below((speed / sinking_speed - 1.0).abs(), 5e-3, format!("{model:?}: sinking speed"));
    }
}

/// Times and kinds of the friction events of a pair.
fn friction_events(model: Model, scene: &Scene, pair: usize) -> Vec<(f64, EventKind)> {
    let (_, log) = run_to_end(model, scene);
    let friction = log.events.iter().filter(|event| event.contact == pair && event.kind.is_friction_event());
    friction.map(|event| (event.time_s, event.kind)).collect()
}

/// Slipping and sticking are events: none within the friction cone, one for a block that slides from the start, two for
/// a disc that ends up rolling. The block needs 98 % of the limit of friction, which the first steps of the engine
/// exceed for some microseconds.
#[test]
fn slip_and_stick_events_have_the_expected_times() {
    for model in BOTH_MODELS {
        let transient_s = if model == Model::Analytic { 0.0 } else { 1e-5 };
        let block_events = friction_events(model, &load("holds"), 0);
        let last = block_events.last().map_or(EventKind::Sticks, |(_, kind)| *kind);
        assert!(
            last == EventKind::Sticks && block_events.iter().all(|(t, _)| *t < transient_s),
            "{model:?}: {block_events:?}"
        );
        let sliding_events = friction_events(model, &load("slides"), 0);
        assert!(matches!(sliding_events[..], [(t, EventKind::Slips)] if t < 1e-5), "{model:?}: {sliding_events:?}");
        let rolling_events = friction_events(model, &load("rolls"), 0);
        let [(slip_s, EventKind::Slips), (stick_s, EventKind::Sticks)] = rolling_events[..] else {
            panic!("{model:?}: {rolling_events:?}")
        };
        let within_s = if model == Model::Analytic { 1e-6 } else { 1e-4 };
        assert!(slip_s < 1e-5 && (stick_s - SLIDING_TIME_S).abs() < within_s, "{model:?}: {slip_s} {stick_s}");
    }
}

/// A block pulled by a spring sticks until the spring force is μ_s m g, then slips and sticks for the durations of dry
/// friction.
#[test]
fn stick_slip_events_have_the_durations_of_dry_friction() {
    let [sticking, slipping] = dry_durations();
    for model in BOTH_MODELS {
        let events = friction_events(model, &load("stick-slip"), 1);
        let (first_s, kind) = events[0];
        assert!(kind == EventKind::Slips && (first_s - 0.4 * G / PULL).abs() < 1e-4, "{model:?}: {events:?}");
        assert!(events.len() >= 8, "{model:?}: {events:?}");
        for pair in events.windows(2) {
            let ((from_s, kind), (to_s, next_kind)) = (pair[0], pair[1]);
            assert_ne!(kind, next_kind, "{model:?}: {events:?}");
            let expected_s = if kind == EventKind::Slips { slipping } else { sticking };
            assert_below(
                ((to_s - from_s) / expected_s - 1.0).abs(),
                0.02,
                format!("{model:?}: {kind:?} at {from_s} s"),
            );
        }
    }
}

/// Separated contacts, and contacts without penetration, have no stiction; the engine with fixed steps agrees.
#[test]
fn separated_contacts_have_no_stiction() {
    let at_rest = |mass_kg: f64, radius_m: f64| free(mass_kg, Some(0.5 * mass_kg * radius_m * radius_m), [0.0; 2]);
    let discs = vec![
        laws::disc("object", 0.02, [0.0, 0.02], at_rest(0.053784, 0.02)),
        laws::disc("ball", 8e-3, [1e-3, 0.04795], at_rest(0.015, 8e-3)),
    ];
    let friction = FrictionLaw {
        kind: FrictionKind::Bristle(Bristle { damping_n_s_per_m: 1e6, relaxation_s: 1e-3 }),
        ..THESIS_FRICTION
    };
    let mut scene = laws::scene_on_plane(discs, THESIS_NORMAL, Some(friction), 1e-3);
    mechanism(&mut scene).gravity_m_s2 = [0.0, G];
    let (analytic, _) = run(Model::Analytic, &scene);
    for step_s in [1e-6, 2.5e-7] {
        let (engine, _) = run(Model::Engine, &laws::with_fixed_step(&scene, step_s));
        for (a, b) in analytic.last.bodies().zip(engine.last.bodies()) {
            let error = (0..2).map(|i| (a.centre_m[i] - b.centre_m[i]).abs()).fold(0.0, f64::max);
            assert_below(error, 1e-9, format!("steps of {step_s:e} s"));
            assert!((b.velocity_m_s[1] - G * 1e-3).abs() < 1e-6, "the discs do not fall freely");
        }
    }
}
