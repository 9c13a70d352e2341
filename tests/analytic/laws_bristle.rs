//! Friction that holds, by itself: discs whose motion has a closed form.

use phalanx::check::check;
use phalanx::law::{Bristle, FrictionLaw};
use phalanx::scene::{self, DiscMotion, Integrator, Preset, Scene};
use phalanx::shape::reach;
use phalanx::trace::{EventKind, Model, Outcome, Sample};
use phalanx::validate::{Rung, Settings, ladder};

use crate::support::held;
use crate::support::laws::{self, BOTH, Collect, FRICTION, THESIS, complete, with_law};

const G: f64 = 9.81;

fn load(name: &str) -> Scene {
    scene::load_any(format!("scenes/laws/bristle-{name}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

fn run(model: Model, scene: &Scene) -> (Outcome, Vec<Sample>) {
    let mut scene = scene.clone();
    scene.integrate_by(Preset::Reference);
    let mut kept = Collect::default();
    let outcome = held::run(model, &scene, &mut kept).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
    (outcome, kept.samples)
}

/// What both models are held to.
fn within(model: Model) -> f64 {
    if model == Model::Analytic { 1e-9 } else { 1e-4 }
}

#[test]
fn a_block_stays_on_an_incline_within_the_cone_and_slides_beyond_it() {
    for model in BOTH {
        let scene = load("holds");
        let (outcome, _) = run(model, &scene);
        let [x, _] = outcome.last.bodies[0].centre_m;
        // The mass hangs on a bristle of 1e9 N/m.
        let stretch = 0.1 * scene.system.gravity_m_s2[0] / 1e9;
        let start = scene.system.discs[0].centre_m[0];
        assert!((x - start - stretch).abs() < within(model) * 1e-6, "{}: {x:e} {stretch:e}", model.name());
        assert!(
            outcome.last.contacts[0].slip_m_s.abs() < 1e-15,
            "{}: {:e}",
            model.name(),
            outcome.last.contacts[0].slip_m_s
        );

        let (outcome, _) = run(model, &load("slides"));
        let [gx, gy] = load("slides").system.gravity_m_s2;
        let expected = 1.0 + 0.1 * (gx + 0.7 * 0.5 * gy);
        let [found, _] = outcome.last.bodies[0].velocity_m_s;
        assert!((found - expected).abs() < within(model), "{}: {found} {expected}", model.name());
    }
}

#[test]
fn a_sliding_disc_comes_to_roll_and_does_not_creep() {
    for model in BOTH {
        let (outcome, samples) = run(model, &load("rolls"));
        let wheel = &outcome.last.bodies[0];
        assert!((wheel.velocity_m_s[0] - 2.0 / 3.0).abs() < within(model), "{}", wheel.velocity_m_s[0]);
        assert!((wheel.spin_rad_s + 40.0 / 3.0).abs() < 20.0 * within(model), "{}", wheel.spin_rad_s);
        assert!(outcome.last.contacts[0].slip_m_s.abs() < 1e-12, "{:e}", outcome.last.contacts[0].slip_m_s);
        // Slip goes down evenly until then.
        let slid_s = 1.0 / (3.0 * 0.3 * G);
        for sample in samples.iter().filter(|sample| sample.time_s < slid_s) {
            let expected = 1.0 - 0.3 * G * sample.time_s;
            assert!((sample.bodies[0].velocity_m_s[0] - expected).abs() < 10.0 * within(model), "{}", sample.time_s);
        }
        let stuck = samples.iter().find(|sample| sample.contacts[0].slip_m_s.abs() < 1e-6).expect("it sticks").time_s;
        assert!((stuck - slid_s).abs() < 2e-4, "{stuck} {slid_s}");
    }
}

/// The wedge at its limit angle, within a hundredth of a degree.
#[test]
fn a_wedge_jams_up_to_the_angle_of_friction() {
    let at = |degrees: f64| {
        let mut scene = load("jams");
        let (sin, cos) = degrees.to_radians().sin_cos();
        let middle = 10.0 + 0.02 - 1e-4;
        for disc in &mut scene.system.discs {
            let [x, _] = disc.centre_m;
            if reach(&disc.shape) == 10.0 {
                disc.centre_m = [x.signum() * middle * cos, -middle * sin];
            }
        }
        scene
    };
    let limit = 0.4f64.atan().to_degrees();
    for model in BOTH {
        let speed = |degrees: f64| {
            let (outcome, _) = run(model, &at(degrees));
            outcome.last.bodies.iter().map(|body| body.velocity_m_s[0].hypot(body.velocity_m_s[1])).fold(0.0, f64::max)
        };
        let (jammed, squeezed) = (speed(limit - 0.01), speed(limit + 0.01));
        assert!(jammed < 1e-9, "{}: {jammed:e} m/s", model.name());
        assert!(squeezed > 1e-4, "{}: {squeezed:e} m/s", model.name());
    }
}

/// Times at which the block begins to slip, and to stick.
fn changes(samples: &[Sample]) -> (Vec<f64>, Vec<f64>) {
    let moving =
        |sample: &Sample| sample.bodies.iter().any(|body| body.velocity_m_s[0] > 2e-3 && body.velocity_m_s[0] != 0.01);
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

/// A mass on a spring that is pulled sticks and slips: in the limit of dry friction a period of 72.78 ms, which is approached as the root
/// of v_static.
#[test]
fn a_mass_on_a_spring_sticks_and_slips() {
    let (drop, omega, pull) = (0.15 * G, 100.0f64, 100.0);
    let dry = 2.0 * drop / pull + (std::f64::consts::TAU - 2.0 * (drop * omega / pull).atan()) / omega;
    for model in BOTH {
        let mut off = Vec::new();
        for v_static in [1e-4, 1e-5, 1e-6] {
            let mut scene = load("stick-slip");
            scene.log.numeric_hz = 1e5;
            with_law(&mut scene, |law| {
                let friction = law.friction.as_mut().expect("friction");
                (friction.v_static_m_s, friction.v_dynamic_m_s) = (v_static, 2.0 * v_static);
            });
            let (_, samples) = run(model, &scene);
            let (slips, sticks) = changes(&samples);
            assert!(slips.len() >= 4 && sticks.len() >= 3, "{}: {slips:?} {sticks:?}", model.name());
            let last = slips.len() - 1;
            let period = (slips[last] - slips[1]) / (last - 1) as f64;
            off.push((period - dry).abs() / dry);
        }
        assert!(off[2] < 0.005 && off[1] < 0.5 * off[0] && off[2] < 0.5 * off[1], "{off:?}");
    }
}

/// Slip begins within a range of 1 µm/s: with rates resolved to 1e-9 m/s two methods are 1.2e-7 m apart.
#[test]
fn a_reference_resolves_the_range_in_which_slip_begins() {
    let mut scene = load("stick-slip");
    scene.integrate_by(Preset::Reference);
    let places = [scene.integrator.atol_rate_rad_s, 1e-13].map(|atol_rate_rad_s| {
        let integrator = Integrator { atol_rate_rad_s, ..scene.integrator };
        let scene = Scene { integrator, ..scene.clone() };
        held::run(Model::Analytic, &scene, &mut ()).expect("a run").last.bodies[0].centre_m[0]
    });
    assert!((places[0] - places[1]).abs() < 1e-9, "{places:?}");
    let found = check(Model::Analytic, &scene, &|| true);
    assert!(found.errors.path < 2e-8, "{} m from another method", found.errors.path);
    // It is what `validate` tells the steps and the time of.
    let told = ladder(&load("stick-slip"), true).into_iter().find(Rung::is_reference).expect("the reference");
    assert_eq!(told.settings, Settings::Analytic(scene.integrator));
}

/// Below half of v_static nothing sticks and slips: at those speeds friction does not fall.
#[test]
fn a_mass_that_is_pulled_slowly_creeps_along() {
    let mut scene = load("stick-slip");
    with_law(&mut scene, |law| {
        let friction = law.friction.as_mut().expect("friction");
        (friction.v_static_m_s, friction.v_dynamic_m_s) = (0.03, 0.06);
    });
    for model in BOTH {
        let (_, samples) = run(model, &scene);
        let late = samples.iter().filter(|sample| sample.time_s > 0.1);
        let fastest = late.flat_map(|sample| &sample.bodies).map(|body| body.velocity_m_s[0]).fold(0.0, f64::max);
        assert!(fastest < 0.0201, "{}: {fastest}", model.name());
    }
}

/// A disc pinched between two upright flats: regularised friction lets it sink at W/(1.5 μ_s/v_s · ΣF_n), a bristle does not, in a minute
/// either.
#[test]
fn what_is_pinched_sinks_under_the_regularised_law_and_stays_where_friction_holds() {
    let mut scene = load("jams");
    scene.system.gravity_m_s2 = [0.0, -G];
    let press = 1e-4;
    for disc in scene.system.discs.iter_mut().filter(|disc| reach(&disc.shape) == 10.0) {
        disc.centre_m = [disc.centre_m[0].signum() * (10.0 + 0.02 - press), 0.0];
    }
    let pinched = scene.system.discs.iter().position(|disc| disc.motion.moves()).expect("a disc that moves");
    let (weight, normal) = (0.05 * G, 1e6 * press);
    let friction = laws::law(&scene).friction.expect("friction");
    let bristle = friction.bristle.expect("a bristle");
    // Softer than the flats are: what it gives way by can be seen.
    let stretch = 0.5 * weight * bristle.relaxation_s / bristle.damping_n_s_per_m;
    for (model, duration_s) in [(Model::Analytic, 60.0), (Model::Engine, 0.2)] {
        scene.duration_s = duration_s;
        with_law(&mut scene, |law| law.friction = Some(friction));
        let (outcome, _) = run(model, &scene);
        let (height, slip_m_s) = (outcome.last.bodies[pinched].centre_m[1], outcome.last.contacts[0].slip_m_s.abs());
        assert!((height + stretch).abs() < 1e-12, "{}: {height:e} m", model.name());
        assert!(slip_m_s < 1e-15, "{}: {slip_m_s:e} m/s", model.name());

        scene.duration_s = 0.1;
        with_law(&mut scene, |law| law.friction = Some(phalanx::law::FrictionLaw { bristle: None, ..friction }));
        let (outcome, _) = run(model, &scene);
        let sinks = -outcome.last.bodies[pinched].velocity_m_s[1];
        let expected = weight * friction.v_static_m_s / (1.5 * friction.mu_static * 2.0 * normal);
        assert!((sinks / expected - 1.0).abs() < 5e-3, "{}: {sinks:e}, expected {expected:e} m/s", model.name());
    }
}

/// When the friction of a pair begins to slip and when it sticks again, in order.
fn changes_told(model: Model, scene: &Scene, pair: usize) -> Vec<(f64, EventKind)> {
    let (_, kept) = complete(model, scene);
    let told = kept.events.iter().filter(|event| event.contact == pair && event.kind.is_of_friction());
    told.map(|event| (event.time_s, event.kind)).collect()
}

/// The clamp's onset and end are events: none within the cone, one for a block that slides from the start, two for a disc that comes to
/// roll. The engine's first steps overshoot the 98 % of the cone that hold the block, for some microseconds.
#[test]
fn slipping_and_sticking_are_events_at_their_times() {
    for model in BOTH {
        let name = model.name();
        let settled_s = if model == Model::Analytic { 0.0 } else { 1e-5 };
        let holds = changes_told(model, &load("holds"), 0);
        let last = holds.last().map_or(EventKind::Sticks, |(_, kind)| *kind);
        assert!(last == EventKind::Sticks && holds.iter().all(|(t, _)| *t < settled_s), "{name}: {holds:?}");
        let slides = changes_told(model, &load("slides"), 0);
        assert!(matches!(slides[..], [(t, EventKind::Slips)] if t < 1e-5), "{name}: {slides:?}");
        let rolls = changes_told(model, &load("rolls"), 0);
        let [(from_s, EventKind::Slips), (to_s, EventKind::Sticks)] = rolls[..] else { panic!("{name}: {rolls:?}") };
        let (slid_s, within_s) = (1.0 / (3.0 * 0.3 * G), if model == Model::Analytic { 1e-6 } else { 1e-4 });
        assert!(from_s < 1e-5 && (to_s - slid_s).abs() < within_s, "{name}: {to_s} {slid_s}");
    }
}

/// A block on a spring that is pulled sticks until the spring has μ_s m g, then slips and sticks in the times of the dry limit.
#[test]
fn a_mass_that_sticks_and_slips_says_when() {
    let (drop, omega, pull) = (0.15 * G, 100.0f64, 100.0);
    let sticking = 2.0 * drop / pull;
    let slipping = (std::f64::consts::TAU - 2.0 * (drop * omega / pull).atan()) / omega;
    for model in BOTH {
        let scene = load("stick-slip");
        let told = changes_told(model, &scene, 1);
        let (first_s, kind) = told[0];
        assert!(kind == EventKind::Slips && (first_s - 0.4 * G / pull).abs() < 1e-4, "{}: {told:?}", model.name());
        assert!(told.len() >= 8, "{}: {told:?}", model.name());
        for pair in told.windows(2) {
            let ((from_s, kind), (to_s, then)) = (pair[0], pair[1]);
            assert_ne!(kind, then, "{}: {told:?}", model.name());
            let dry = if kind == EventKind::Slips { slipping } else { sticking };
            let off = ((to_s - from_s) / dry - 1.0).abs();
            assert!(off < 0.02, "{}: {kind:?} for {} s, not {dry}", model.name(), to_s - from_s);
        }
    }
}

/// Where a contact has been left, or only just touches, nothing is held: the engine's steps of a given length get past that.
#[test]
fn what_has_parted_is_not_held() {
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
    let friction = FrictionLaw { bristle: Some(Bristle { damping_n_s_per_m: 1e6, relaxation_s: 1e-3 }), ..FRICTION };
    let mut scene = laws::on_plane(laws::scene(discs, THESIS, Some(friction), 1e-3));
    scene.system.gravity_m_s2 = [0.0, G];
    let (analytic, _) = run(Model::Analytic, &scene);
    for step_s in [1e-6, 2.5e-7] {
        let (engine, _) = run(Model::Engine, &laws::stepped(&scene, step_s));
        for (a, b) in analytic.last.bodies.iter().zip(&engine.last.bodies) {
            let off = (0..2).map(|i| (a.centre_m[i] - b.centre_m[i]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{step_s:e} s: {off:.1e} m");
            assert!((b.velocity_m_s[1] - G * 1e-3).abs() < 1e-6, "they fall");
        }
    }
}
