//! Stiction of discs, compared with closed-form motions.

use phalanx::check::check;
use phalanx::law::{Bristle, FrictionLaw};
use phalanx::scene::{self, DiscMotion, Integrator, Preset, Scene};
use phalanx::shape::max_radius;
use phalanx::trace::{EventKind, Model, Outcome, Sample};
use phalanx::validate::{Settings, SolverConfiguration, ladder_configurations};

use crate::support::checked_run;
use crate::support::laws::{
    self, BOTH_MODELS, CollectSink, THESIS_FRICTION, THESIS_NORMAL, change_contact_law, run_to_end,
};

const G: f64 = 9.81;

fn load(name: &str) -> Scene {
    scene::load_any(format!("scenes/laws/bristle-{name}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

fn run(model: Model, scene: &Scene) -> (Outcome, Vec<Sample>) {
    let mut scene = scene.clone();
    scene.apply_preset(Preset::Reference);
    let mut sink = CollectSink::default();
    let outcome = checked_run::run(model, &scene, &mut sink).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
    (outcome, sink.samples)
}

/// Relative tolerance of a model.
fn tolerance(model: Model) -> f64 {
    if model == Model::Analytic { 1e-9 } else { 1e-4 }
}

#[test]
fn a_block_on_an_incline_sticks_within_the_friction_cone_and_slides_beyond_it() {
    for model in BOTH_MODELS {
        let scene = load("holds");
        let (outcome, _) = run(model, &scene);
        let [x, _] = outcome.last.body(0).centre_m;
        // The mass deflects a bristle of 1e9 N/m.
        let stretch = 0.1 * scene.system.gravity_m_s2[0] / 1e9;
        let start = scene.system.discs[0].centre_m[0];
        assert!((x - start - stretch).abs() < tolerance(model) * 1e-6, "{}: {x:e} {stretch:e}", model.name());
        assert!(
            outcome.last.contact(0).slip_m_s.abs() < 1e-15,
            "{}: {:e}",
            model.name(),
            outcome.last.contact(0).slip_m_s
        );

        let (outcome, _) = run(model, &load("slides"));
        let [gx, gy] = load("slides").system.gravity_m_s2;
        let expected = 1.0 + 0.1 * (gx + 0.7 * 0.5 * gy);
        let [speed, _] = outcome.last.body(0).velocity_m_s;
        assert!((speed - expected).abs() < tolerance(model), "{}: {speed} {expected}", model.name());
    }
}

#[test]
fn a_sliding_disc_ends_up_rolling_without_creep() {
    for model in BOTH_MODELS {
        let (outcome, samples) = run(model, &load("rolls"));
        let wheel = outcome.last.body(0);
        assert!((wheel.velocity_m_s[0] - 2.0 / 3.0).abs() < tolerance(model), "{}", wheel.velocity_m_s[0]);
        assert!((wheel.spin_rad_s + 40.0 / 3.0).abs() < 20.0 * tolerance(model), "{}", wheel.spin_rad_s);
        assert!(outcome.last.contact(0).slip_m_s.abs() < 1e-12, "{:e}", outcome.last.contact(0).slip_m_s);
        // Slip decreases linearly until then.
        let sliding_time_s = 1.0 / (3.0 * 0.3 * G);
        for sample in samples.iter().filter(|sample| sample.time_s < sliding_time_s) {
            let expected = 1.0 - 0.3 * G * sample.time_s;
            assert!((sample.body(0).velocity_m_s[0] - expected).abs() < 10.0 * tolerance(model), "{}", sample.time_s);
        }
        let stuck_position =
            samples.iter().find(|sample| sample.contacts[0].slip_m_s.abs() < 1e-6).expect("a sticking contact").time_s;
        assert!((stuck_position - sliding_time_s).abs() < 2e-4, "{stuck_position} {sliding_time_s}");
    }
}

/// The wedge jams up to the friction angle, found to a hundredth of a degree.
#[test]
fn a_wedge_jams_up_to_the_friction_angle() {
    let wedge_at = |degrees: f64| {
        let mut scene = load("jams");
        let (sin, cos) = degrees.to_radians().sin_cos();
        let distance = 10.0 + 0.02 - 1e-4;
        for disc in &mut scene.system.discs {
            let [x, _] = disc.centre_m;
            if max_radius(&disc.shape) == 10.0 {
                disc.centre_m = [x.signum() * distance * cos, -distance * sin];
            }
        }
        scene
    };
    let limit = 0.4f64.atan().to_degrees();
    for model in BOTH_MODELS {
        let max_speed = |degrees: f64| {
            let (outcome, _) = run(model, &wedge_at(degrees));
            outcome.last.bodies().map(|body| body.velocity_m_s[0].hypot(body.velocity_m_s[1])).fold(0.0, f64::max)
        };
        let (below_limit, beyond_limit) = (max_speed(limit - 0.01), max_speed(limit + 0.01));
        assert!(below_limit < 1e-9, "{}: {below_limit:e} m/s", model.name());
        assert!(beyond_limit > 1e-4, "{}: {beyond_limit:e} m/s", model.name());
    }
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
    let (force_drop, omega, pull) = (0.15 * G, 100.0f64, 100.0);
    let dry_period =
        2.0 * force_drop / pull + (std::f64::consts::TAU - 2.0 * (force_drop * omega / pull).atan()) / omega;
    for model in BOTH_MODELS {
        let mut errors = Vec::new();
        for v_static in [1e-4, 1e-5, 1e-6] {
            let mut scene = load("stick-slip");
            scene.log.numeric_hz = 1e5;
            change_contact_law(&mut scene, |law| {
                let friction = law.friction.as_mut().expect("friction");
                (friction.v_static_m_s, friction.v_dynamic_m_s) = (v_static, 2.0 * v_static);
            });
            let (_, samples) = run(model, &scene);
            let (slips, sticks) = slip_and_stick_times(&samples);
            assert!(slips.len() >= 4 && sticks.len() >= 3, "{}: {slips:?} {sticks:?}", model.name());
            let last = slips.len() - 1;
            let period = (slips[last] - slips[1]) / (last - 1) as f64;
            errors.push((period - dry_period).abs() / dry_period);
        }
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
        let scene = Scene { integrator, ..scene.clone() };
        checked_run::run(Model::Analytic, &scene, &mut ()).expect("a run").last.body(0).centre_m[0]
    });
    assert!((positions[0] - positions[1]).abs() < 1e-9, "{positions:?}");
    let checked = check(Model::Analytic, &scene, &|| true);
    assert!(checked.errors.path < 2e-8, "{} m of difference from the other method", checked.errors.path);
    // `validate` uses the same settings for its reference.
    let reference_configuration = ladder_configurations(&load("stick-slip"), true)
        .into_iter()
        .find(SolverConfiguration::is_reference)
        .expect("the reference");
    assert_eq!(reference_configuration.settings, Settings::Analytic(scene.integrator));
}

/// Below half of v_static there is no stick-slip, because friction does not fall with speed there.
#[test]
fn a_mass_pulled_below_v_static_creeps_without_stick_slip() {
    let mut scene = load("stick-slip");
    change_contact_law(&mut scene, |law| {
        let friction = law.friction.as_mut().expect("friction");
        (friction.v_static_m_s, friction.v_dynamic_m_s) = (0.03, 0.06);
    });
    for model in BOTH_MODELS {
        let (_, samples) = run(model, &scene);
        let late_samples = samples.iter().filter(|sample| sample.time_s > 0.1);
        let fastest =
            late_samples.flat_map(|sample| sample.bodies()).map(|body| body.velocity_m_s[0]).fold(0.0, f64::max);
        assert!(fastest < 0.0201, "{}: {fastest}", model.name());
    }
}

/// A disc is pinched between two vertical surfaces. With regularised friction it sinks at W/(1.5 μ_s/v_s · ΣF_n); with
/// bristles it does not sink, even in a minute.
#[test]
fn a_pinched_disc_sinks_with_regularised_friction_and_stays_with_stiction() {
    let mut scene = load("jams");
    scene.system.gravity_m_s2 = [0.0, -G];
    let overlap_m = 1e-4;
    for disc in scene.system.discs.iter_mut().filter(|disc| max_radius(&disc.shape) == 10.0) {
        disc.centre_m = [disc.centre_m[0].signum() * (10.0 + 0.02 - overlap_m), 0.0];
    }
    let pinched = scene.system.discs.iter().position(|disc| disc.motion.moves()).expect("a moving disc");
    let (weight, normal) = (0.05 * G, 1e6 * overlap_m);
    let friction = laws::contact_law(&scene).friction.expect("friction");
    let bristle = friction.bristle.expect("a bristle");
    // The bristles deflect measurably under the weight.
    let stretch = 0.5 * weight * bristle.relaxation_s / bristle.damping_n_s_per_m;
    for (model, duration_s) in [(Model::Analytic, 60.0), (Model::Engine, 0.2)] {
        scene.duration_s = duration_s;
        change_contact_law(&mut scene, |law| law.friction = Some(friction));
        let (outcome, _) = run(model, &scene);
        let (height, slip_m_s) = (outcome.last.body(pinched).centre_m[1], outcome.last.contact(0).slip_m_s.abs());
        assert!((height + stretch).abs() < 1e-12, "{}: {height:e} m", model.name());
        assert!(slip_m_s < 1e-15, "{}: {slip_m_s:e} m/s", model.name());

        scene.duration_s = 0.1;
        change_contact_law(&mut scene, |law| {
            law.friction = Some(phalanx::law::FrictionLaw { bristle: None, ..friction })
        });
        let (outcome, _) = run(model, &scene);
        let sinking_speed = -outcome.last.body(pinched).velocity_m_s[1];
        let expected = weight * friction.v_static_m_s / (1.5 * friction.mu_static * 2.0 * normal);
        assert!(
            (sinking_speed / expected - 1.0).abs() < 5e-3,
            "{}: {sinking_speed:e}, expected {expected:e} m/s",
            model.name()
        );
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
        let name = model.name();
        let transient_s = if model == Model::Analytic { 0.0 } else { 1e-5 };
        let block_events = friction_events(model, &load("holds"), 0);
        let last = block_events.last().map_or(EventKind::Sticks, |(_, kind)| *kind);
        assert!(
            last == EventKind::Sticks && block_events.iter().all(|(t, _)| *t < transient_s),
            "{name}: {block_events:?}"
        );
        let sliding_events = friction_events(model, &load("slides"), 0);
        assert!(matches!(sliding_events[..], [(t, EventKind::Slips)] if t < 1e-5), "{name}: {sliding_events:?}");
        let rolling_events = friction_events(model, &load("rolls"), 0);
        let [(slip_s, EventKind::Slips), (stick_s, EventKind::Sticks)] = rolling_events[..] else {
            panic!("{name}: {rolling_events:?}")
        };
        let (sliding_time_s, within_s) = (1.0 / (3.0 * 0.3 * G), if model == Model::Analytic { 1e-6 } else { 1e-4 });
        assert!(slip_s < 1e-5 && (stick_s - sliding_time_s).abs() < within_s, "{name}: {stick_s} {sliding_time_s}");
    }
}

/// A block pulled by a spring sticks until the spring force is μ_s m g, then slips and sticks for the durations of dry
/// friction.
#[test]
fn stick_slip_events_have_the_durations_of_dry_friction() {
    let (force_drop, omega, pull) = (0.15 * G, 100.0f64, 100.0);
    let sticking = 2.0 * force_drop / pull;
    let slipping = (std::f64::consts::TAU - 2.0 * (force_drop * omega / pull).atan()) / omega;
    for model in BOTH_MODELS {
        let scene = load("stick-slip");
        let events = friction_events(model, &scene, 1);
        let (first_s, kind) = events[0];
        assert!(kind == EventKind::Slips && (first_s - 0.4 * G / pull).abs() < 1e-4, "{}: {events:?}", model.name());
        assert!(events.len() >= 8, "{}: {events:?}", model.name());
        for pair in events.windows(2) {
            let ((from_s, kind), (to_s, next_kind)) = (pair[0], pair[1]);
            assert_ne!(kind, next_kind, "{}: {events:?}", model.name());
            let expected_s = if kind == EventKind::Slips { slipping } else { sticking };
            let error = ((to_s - from_s) / expected_s - 1.0).abs();
            assert!(error < 0.02, "{}: {kind:?} for {} s, expected {expected_s} s", model.name(), to_s - from_s);
        }
    }
}

/// Separated contacts, and contacts without penetration, have no stiction; the engine with fixed steps agrees.
#[test]
fn separated_contacts_have_no_stiction() {
    let (object, ball) = ([0.0, 0.02], [1e-3, 0.04795]);
    let mass = |mass_kg: f64, radius_m: f64| DiscMotion::Free {
        mass_kg,
        inertia_kg_m2: Some(0.5 * mass_kg * radius_m * radius_m),
        velocity_m_s: [0.0; 2],
        spin_rad_s: 0.0,
    };
    let discs = vec![
        laws::disc("object", 0.02, object, mass(0.053784, 0.02)),
        laws::disc("ball", 8e-3, ball, mass(0.015, 8e-3)),
    ];
    let friction =
        FrictionLaw { bristle: Some(Bristle { damping_n_s_per_m: 1e6, relaxation_s: 1e-3 }), ..THESIS_FRICTION };
    let mut scene = laws::with_half_plane(laws::scene(discs, THESIS_NORMAL, Some(friction), 1e-3));
    scene.system.gravity_m_s2 = [0.0, G];
    let (analytic, _) = run(Model::Analytic, &scene);
    for step_s in [1e-6, 2.5e-7] {
        let (engine, _) = run(Model::Engine, &laws::with_fixed_step(&scene, step_s));
        for (a, b) in analytic.last.bodies().zip(engine.last.bodies()) {
            let error = (0..2).map(|i| (a.centre_m[i] - b.centre_m[i]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-9, "{step_s:e} s: {error:.1e} m");
            assert!((b.velocity_m_s[1] - G * 1e-3).abs() < 1e-6, "the discs do not fall freely");
        }
    }
}
