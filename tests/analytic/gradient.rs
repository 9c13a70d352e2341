//! Derivatives of runs with respect to parameters of their scenes: closed forms, and differences of whole runs.

use std::f64::consts::{PI, TAU};

use crate::support::laws::{disc, free, free_translation, mechanism_scene, scene, scene_on_plane, spring};
use crate::support::mechanism_cases::{cable_cases, mechanism_case};
use crate::support::random::Random;
use crate::support::runs::{assert_below, assert_near, assert_relative, experiment_95, run_to_end, seeds};
use crate::support::scenes::loops::{random_assur, random_linkage, random_loop, with_start};
use crate::support::scenes::trees::random_mechanism;
use phalanx::drive::{Interpolation, Profile};
use phalanx::gradient::{Gradient, Parameter, gradient};
use phalanx::law::NormalLaw;
use phalanx::mechanism::{Mechanism, assemble};
use phalanx::scene::{DiscMotion, Layer, Scene, parse_any};
use phalanx::study::parameter::parameters;
use phalanx::trace::{Event, Model, Recording, Schema, run};

pub fn parameter<'a>(value: f64, scene_at: impl Fn(f64) -> Scene + 'a) -> Parameter<'a> {
    Parameter { name: "p".to_string(), unit: "", value, scene_at: Box::new(move |value| Ok(scene_at(value))) }
}

fn gradient_of(parameter: &Parameter<'_>) -> Gradient {
    let scene = (parameter.scene_at)(parameter.value).expect("a scene");
    let found = gradient(&scene, std::slice::from_ref(parameter), &|| true);
    found.unwrap_or_else(|error| panic!("{}: {error}", scene.name)).remove(0)
}

fn end(gradient: &Gradient, column: &str) -> f64 {
    let end = &gradient.end;
    *end.values.get(column).unwrap_or_else(|| panic!("{column}: {:?}, {:?}", end.reason, end.values.keys()))
}

/// Time derivatives of the events.
fn times(gradient: &Gradient) -> Vec<f64> {
    let time = |event: &phalanx::gradient::EventGradient| {
        event.time.value.unwrap_or_else(|| panic!("{}: {:?}", event.time_s, event.time.reason))
    };
    gradient.events.iter().map(time).collect()
}

/// Last sample and events of a run.
fn run_at(parameter: &Parameter<'_>, value: f64) -> (Vec<f64>, Vec<Event>) {
    let mut scene = (parameter.scene_at)(value).expect("a scene");
    scene.integrator = scene.integrator.with_rtol(1e-11);
    let mut recording = Recording::new(&Schema::from_scene(&scene));
    let outcome = run(Model::Analytic, &scene, &mut recording).unwrap_or_else(|error| panic!("{error}"));
    let channels = recording.channels().to_vec();
    (channels.iter().map(|channel| channel.value(&outcome.last)).collect(), recording.into_parts().1)
}

/// Derivatives of numbers by central differences of whole runs, extrapolated from three steps, with their estimated
/// errors.
pub fn differences(
    parameter: &Parameter<'_>,
    change: f64,
    numbers: impl Fn(&(Vec<f64>, Vec<Event>)) -> Vec<f64>,
) -> Vec<[f64; 2]> {
    let h = change * parameter.value.abs();
    let quotient = |h: f64| -> Vec<f64> {
        let [below, above] = [-h, h].map(|h| numbers(&run_at(parameter, parameter.value + h)));
        below.iter().zip(&above).map(|(below, above)| (above - below) / (2.0 * h)).collect()
    };
    let [a, b, c] = [h, 0.5 * h, 0.25 * h].map(quotient);
    let extrapolated = |i: usize| {
        let [ab, bc] = [b[i] + (b[i] - a[i]) / 3.0, c[i] + (c[i] - b[i]) / 3.0];
        let best = bc + (bc - ab) / 15.0;
        [best, (best - bc).abs()]
    };
    (0..a.len()).map(extrapolated).collect()
}

pub fn mechanism(text: &str) -> Scene {
    parse_any(&format!("kind = \"mechanism\"\n{text}"), "test.toml").unwrap_or_else(|error| panic!("{error}"))
}

type Multiply = fn(&mut Mechanism, f64);

const PULL: Multiply = |m, x| {
    let actuator = m.tendons[0].actuator.as_mut().expect("an actuator");
    actuator.tension = actuator.tension.scaled(x);
};
const FRICTION: Multiply = |m, x| {
    for law in m.tendons[0].path.iter_mut().filter_map(|element| element.friction.as_mut()) {
        (law.mu_static, law.mu_dynamic) = (law.mu_static * x, law.mu_dynamic * x);
    }
};
const RADIUS: Multiply = |m, x| m.tendons[0].path[1].radius_m *= x;

/// Compares the derivatives of a reference case of cables by a factor with differences.
fn compare_cable((name, duration_s, change): (&str, f64, Multiply)) {
    let case = cable_cases().into_iter().find(|case| case.name == name).expect("a case");
    let scene_at = |x: f64| {
        let mut mechanism = case.mechanism.clone();
        change(&mut mechanism, x);
        mechanism_scene(mechanism, duration_s)
    };
    let parameter = parameter(1.0, scene_at);
    let found = gradient_of(&parameter);
    let expected = differences(&parameter, 1e-4, |(last, _)| last.clone());
    let channels = Schema::from_scene(&scene_at(1.0)).channels();
    let mut count = 0;
    for (channel, [value, error]) in channels.iter().zip(expected) {
        if !["rad", "m", "rad/s", "m/s"].contains(&channel.unit) || channel.name.contains('[') {
            continue;
        }
        let derivative = end(&found, &channel.name);
        let allowed = 1e-4 * value.abs() + 10.0 * error + 1e-9;
        assert!((derivative - value).abs() < allowed, "{name}, {}: {derivative}, {value}", channel.name);
        count += 1;
    }
    assert!(count > 3, "{name}: {count}");
}

/// Cables that lift off and return, and that rub: derivatives by pulls, coefficients and radii.
#[test]
fn cables_have_the_derivatives_of_differences() {
    [
        ("k_bowstring", 0.03, PULL),
        ("k_bowstring", 0.03, RADIUS),
        ("k_capstan_load", 0.05, FRICTION),
        ("k_capstan_load", 0.05, RADIUS),
    ]
    .into_iter()
    .for_each(compare_cable);
}

/// The same over hysteresis, with and without presliding, and over eyelets.
#[test]
fn long_runs_with_cables_have_the_derivatives_of_differences() {
    [
        ("k_hysteresis", 0.4, FRICTION),
        ("k_hysteresis_bristle", 0.4, FRICTION),
        ("k_eyelets_reverse", 0.1, FRICTION),
        ("k_eyelets_reverse", 0.1, PULL),
    ]
    .into_iter()
    .for_each(compare_cable);
}

/// x = x₀ cos ωt with ω = √(k/m).
#[test]
fn a_spring_and_a_mass_have_the_derivatives_of_a_cosine() {
    let (k, x0, t) = (300.0_f64, 0.01, 0.08);
    let by_mass = parameter(0.2, |mass| {
        mechanism(&format!(
            "duration = \"{t} s\"\n[bodies.mass]\nmass = \"{mass:?} kg\"\ninertia = \"1e-5 kg*m^2\"\nguess = {{ at = [\"10 mm\", \"0 mm\"] }}\n\
             [joints.slide]\ntype = \"prismatic\"\nbodies = [\"ground\", \"mass\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
             axis = \"0 deg\"\nstart = \"{x0} m\"\n[springs.coil]\njoint = \"slide\"\nstiffness = \"{k} N/m\"\nrest = \"0 mm\"\n"
        ))
    });
    let found = gradient_of(&by_mass);
    let (m, omega) = (0.2, (k / 0.2_f64).sqrt());
    let slope = -omega / (2.0 * m);
    assert_relative(end(&found, "slide_position_m"), -x0 * t * slope * (omega * t).sin(), 1e-9, "position");
    let rate = -x0 * slope * ((omega * t).sin() + omega * t * (omega * t).cos());
    assert_relative(end(&found, "slide_rate_m_s"), rate, 1e-9, "rate");
    assert!(found.end.errors["slide_position_m"] < 1e-9, "{:?}", found.end.errors);
}

/// A pendulum that starts at rest depends on time and gravity only through t √g: ∂q/∂g = q̇ t/(2 g).
#[test]
fn a_pendulum_has_the_derivative_of_its_time_scale() {
    let t = 0.9;
    let by_gravity = parameter(9.81, |gravity| {
        mechanism(&format!(
            "duration = \"{t} s\"\ngravity = [\"0 m/s^2\", \"-{gravity:?} m/s^2\"]\n[bodies.bob]\nmass = \"100 g\"\n\
             inertia = \"1e-5 kg*m^2\"\ncom = [\"0 mm\", \"-150 mm\"]\nguess = {{ angle = \"1 rad\" }}\n[joints.pin]\n\
             bodies = [\"ground\", \"bob\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"1 rad\"\n"
        ))
    });
    let found = gradient_of(&by_gravity);
    let scene = (by_gravity.scene_at)(9.81).expect("a scene");
    let (last, _) = run_at(&by_gravity, 9.81);
    let channels = Recording::for_scene(&scene).channels().to_vec();
    let rate = last[channels.iter().position(|channel| channel.name == "pin_rate_rad_s").expect("a rate")];
    assert_relative(end(&found, "pin_rad"), rate * t / (2.0 * 9.81), 1e-9, "angle");
}

/// A slider-crank whose lengths, masses and start follow from the length of its crank and an angle.
const SLIDER_CRANK: &str = r#"kind = "mechanism"
duration = "60 ms"
[parameters]
crank = "30 mm"
tilt = "0.3 rad"
rod = "= 10 * crank / 3"
[bodies.crank]
mass = "= 50 g * crank / 30 mm"
inertia = "= 50 g * crank^2 / 2"
com = ["= 0.4 * crank", "0 mm"]
guess = { angle = "= tilt" }
[bodies.rod]
mass = "40 g"
inertia = "5e-5 kg*m^2"
com = ["= rod / 2", "0 mm"]
guess = { at = ["= crank * cos(tilt)", "= crank * sin(tilt)"], angle = "-5 deg" }
[bodies.slider]
mass = "100 g"
inertia = "1e-5 kg*m^2"
guess = { at = ["= crank + rod", "0 mm"] }
[joints.crank]
bodies = ["ground", "crank"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "= tilt"
start_rate = "20 rad/s"
[joints.pin]
bodies = ["crank", "rod"]
points = [["= crank", "0 mm"], ["0 mm", "0 mm"]]
[joints.wrist]
bodies = ["rod", "slider"]
points = [["= rod", "0 mm"], ["0 mm", "0 mm"]]
[joints.slide]
type = "prismatic"
bodies = ["ground", "slider"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
axis = "0 deg"
[actuators.motor]
joint = "crank"
times = ["0 ms", "30 ms", "60 ms"]
torques = ["0 N*mm", "= 40 N*m/rad * tilt / 240", "0 N*mm"]
"#;

/// A parameter acts through all expressions that use it; an entry of a list acts by itself.
#[test]
fn derivatives_by_fields_of_a_scene_agree_with_differences_of_runs() {
    let layers = [Layer { file: "test.toml".to_string(), text: SLIDER_CRANK.to_string() }];
    let scene = parse_any(SLIDER_CRANK, "test.toml").unwrap_or_else(|error| panic!("{error}"));
    let fields = [
        "parameters.crank",
        "parameters.tilt",
        "parameters.rod",
        "joints.pin.points[0][0]",
        "actuators.motor.torques[1]",
    ];
    let fields = fields.map(str::to_string);
    let finish = |_: &mut Scene| {};
    let all = parameters((&layers, &[]), &fields, &finish).unwrap_or_else(|error| panic!("{error}"));
    let found: Vec<(f64, &str)> = all.iter().map(|parameter| (parameter.value, parameter.unit)).collect();
    let crank = 0.03;
    let torque = 40.0 * 0.3 / 240.0;
    assert_eq!(found, [(crank, "m"), (0.3, "rad"), (10.0 * crank / 3.0, "m"), (crank, "m"), (torque, "N*m")]);
    let gradients = gradient(&scene, &all, &|| true).unwrap_or_else(|error| panic!("{error}"));
    let channels = Recording::for_scene(&scene).channels().to_vec();
    let mut ends = Vec::new();
    for (parameter, gradient) in all.iter().zip(&gradients) {
        let expected = differences(parameter, 1e-3, |(state, _)| state.clone());
        let mut compared = 0;
        for (channel, [value, error]) in channels.iter().zip(&expected) {
            let Some(found) = gradient.end.values.get(&channel.name) else { continue };
            let within = 1e-5 * value.abs() + 20.0 * error + 1e-7;
            assert!(
                (found - value).abs() <= within,
                "{} by {}: {found}, {value} ± {error}",
                channel.name,
                parameter.name
            );
            compared += 1;
        }
        assert!(compared > 10, "{compared}");
        ends.push(end(gradient, "crank_rad"));
    }
    // The crank acts through other values than the pin alone.
    assert!(ends.iter().all(|end| end.abs() > 1e-3) && (ends[0] - ends[3]).abs() > 0.1 * ends[3].abs(), "{ends:?}");
    // Entries of pairs that are not written.
    for (field, value) in [("gravity[1]", 0.0), ("bodies.slider.com[0]", 0.0)] {
        let found = parameters((&layers, &[]), &[field.to_string()], &finish).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((found[0].name.as_str(), found[0].value), (field, value));
        assert!((found[0].scene_at)(0.5).expect("a scene").mechanism != scene.mechanism, "{field}");
    }
    for (field, message) in [
        (
            "parameters.crnk",
            "unknown parameter `crnk`: did you mean `crank`?; parameters of this scene: crank, rod, tilt",
        ),
        ("joints.pin.points[0][2]", "`points` has 2 entries, numbered from 0, so there is no `points[2]`"),
        ("joints.pin.points", "`joints.pin.points` is not a number or a quantity of the scene"),
        ("joints pin", "`joints pin` is not a field: write its sections and its key"),
    ] {
        let error = study_error(&layers, field);
        assert!(error.contains(message), "{field}: {error}");
    }
}

fn study_error(layers: &[Layer], field: &str) -> String {
    let found = parameters((layers, &[]), &[field.to_string()], &|_: &mut Scene| {});
    found.err().unwrap_or_else(|| panic!("{field} is accepted"))
}

/// A disc of mass `m` at speed `v` that a linear spring `k` turns back.
fn bounce(m: f64, k: f64, v: f64) -> Scene {
    let disc = disc("ball", 0.01, [0.0, 0.015], free(m, None, [0.0, -v]));
    scene_on_plane(vec![disc], spring(k, 1.0), None, 0.03)
}

/// Touch-down at t₁ = s/v, lift-off at t₂ = t₁ + π √(m/k), and y = r + v (t − t₂) afterwards.
#[test]
fn a_bounce_has_the_derivatives_of_half_a_period() {
    let (m, k, v, gap, t) = (0.05_f64, 2e4_f64, 0.4, 0.005, 0.03);
    let half_period = PI * (m / k).sqrt();
    let lift_off = gap / v + half_period;
    let derivatives = |by_t1: f64, by_t2: f64, by_v: f64| [by_t1, by_t2, by_v * (t - lift_off) - v * by_t2, by_v];
    let cases = [
        ("m", parameter(m, |m| bounce(m, k, v)), derivatives(0.0, half_period / (2.0 * m), 0.0)),
        ("k", parameter(k, |k| bounce(m, k, v)), derivatives(0.0, -half_period / (2.0 * k), 0.0)),
        ("v", parameter(v, |v| bounce(m, k, v)), derivatives(-gap / (v * v), -gap / (v * v), 1.0)),
    ];
    for (name, parameter, [touch_down, released, y, speed]) in cases {
        let found = gradient_of(&parameter);
        let times = times(&found);
        assert_eq!(times.len(), 2, "{name}");
        let scale = parameter.value.recip();
        assert_near(times[0], touch_down, 1e-9 * lift_off * scale, format!("{name}: touch-down"));
        assert_near(times[1], released, 1e-8 * lift_off * scale, format!("{name}: lift-off"));
        assert_near(end(&found, "ball_y_m"), y, 1e-8 * gap * scale, format!("{name}: height"));
        assert_near(end(&found, "ball_vy_m_s"), speed, 1e-8 * v * scale, format!("{name}: speed"));
        // The rate of an event's sample is that of its moving time.
        let at_touch_down = &found.events[0].state.values;
        assert_near(at_touch_down["ball_y_m"], 0.0, 1e-9 * gap * scale, format!("{name}: height at touch-down"));
    }
}

/// A ball thrown to a ceiling that it reaches with a millionth of its speed.
#[test]
fn a_grazing_contact_has_no_derivative() {
    let thrown = |speed: f64| {
        let height = 0.01 + (0.4 * 0.4) / (2.0 * 9.81) * (1.0 - 1e-12);
        let discs = vec![
            disc("ball", 0.01, [0.0, 0.0], free_translation([0.0, speed])),
            disc("ceiling", 0.01, [0.0, height + 0.01], DiscMotion::Fixed),
        ];
        let mut scene = scene(discs, spring(1e6, 1.5), None, 0.1);
        scene.mechanism.as_mut().expect("discs").gravity_m_s2 = [0.0, -9.81];
        scene
    };
    let found = gradient_of(&parameter(0.4, thrown));
    let reason = found.events[0].time.reason.as_ref().expect("a reason");
    assert!(reason.contains("grazes at 0.0407") && found.events[0].time.value.is_none(), "{reason}");
    let reason = found.end.reason.expect("a reason");
    assert!(
        reason
            .contains("the events change: the contact ball-ceiling has 1 events of kind touch-down, but 0 at 0.39999"),
        "{reason}"
    );
    assert!(found.end.values.is_empty());
}

fn with_actuation(actuation: Profile) -> Scene {
    let mut scene = experiment_95();
    scene.finger_mut().motor.actuation = actuation;
    scene
}

/// Asserts that derivatives at the end and of event times agree with differences of whole runs.
#[track_caller]
fn assert_differences(name: &str, parameter: &Parameter<'_>, change: f64, tolerance: f64) {
    let found = gradient_of(parameter);
    let scene = (parameter.scene_at)(parameter.value).expect("a scene");
    let schema = Schema::from_scene(&scene);
    let (values, events) = run_at(parameter, parameter.value);
    let start = events.len() - found.events.len();
    let of_runs = differences(parameter, change, |(end, events)| {
        end.iter().copied().chain(events.iter().skip(start).map(|event| event.time_s)).collect()
    });
    let (ends, of_events) = of_runs.split_at(values.len());
    for ((event, derivative), [difference, error]) in found.events.iter().zip(times(&found)).zip(of_events) {
        let allowed = tolerance * (difference.abs() + event.time_s / parameter.value.abs()) + 3.0 * error;
        assert_near(derivative, *difference, allowed, format!("{name}: {} {}", event.contact, event.kind));
    }
    for (index, channel) in schema.channels().iter().enumerate() {
        let Some(derivative) = found.end.values.get(&channel.name) else { continue };
        // Balances and the forces of dampers multiply rounding.
        let scale = largest_of_unit(&schema, ends, &values, parameter.value, channel.unit);
        let allowed = tolerance * scale + 3.0 * ends[index][1];
        assert_near(*derivative, ends[index][0], allowed, format!("{name}: {}", channel.name));
    }
}

/// Largest derivative of the quantities of a unit, or the derivative that changes the largest of them by itself.
fn largest_of_unit(schema: &Schema, ends: &[[f64; 2]], values: &[f64], parameter: f64, unit: &str) -> f64 {
    let of_unit = schema.channels().into_iter().enumerate().filter(|(_, channel)| channel.unit == unit);
    let of_unit = of_unit.map(|(index, _)| ends[index][0].abs().max((values[index] / parameter).abs()));
    of_unit.filter(|x| x.is_finite()).fold(0.0, f64::max)
}

/// A stiff joint limit with a damper of 1e9 N·m·s/rad, impacts, and the criteria of a grasp.
#[test]
fn derivatives_of_a_closing_finger_agree_with_differences() {
    let torque = parameter(0.48, |value| with_actuation(Profile::Constant { value }));
    assert_differences("torque", &torque, 1e-3, 1e-6);
    let found = gradient_of(&torque);
    let touch_down = found.events.iter().rfind(|event| event.kind == "touch-down").expect("a touch-down");
    let tts = found.tts_s.expect("a time to stability");
    assert_eq!((touch_down.contact.as_str(), tts.value), ("distal", touch_down.time.value));
}

/// The time of a step of the torque, and of a corner of a ramp.
#[test]
fn derivatives_by_the_times_of_a_table_agree_with_differences() {
    for interpolation in [Interpolation::Step, Interpolation::Linear] {
        let table = |time: f64| {
            let points = vec![(0.0, 0.3), (time, 0.5), (2.0 * time, 0.48)];
            with_actuation(Profile::Table { points, interpolation })
        };
        // Forces at rest are rounding times the stiffness of the limit.
        assert_differences(&format!("{interpolation:?}"), &parameter(2e-3, table), 1e-3, 3e-6);
    }
}

/// A four-bar whose joints make a turn: its counts change the mode without an event.
#[test]
fn derivatives_continue_while_turns_are_counted() {
    let of = random_loop(57);
    let with_stiffness = |stiffness: f64| {
        let mut mechanism = of.mechanism.clone();
        mechanism.springs[0].stiffness = stiffness;
        // Velocities of pivots are rounding.
        mechanism.bodies.iter_mut().for_each(|body| body.is_reported = false);
        mechanism_scene(mechanism, 0.1)
    };
    let stiffness = parameter(of.mechanism.springs[0].stiffness, with_stiffness);
    assert!(end(&gradient_of(&stiffness), "a_rad") != 0.0, "{}", of.description);
    assert_differences(&of.description, &stiffness, 1e-3, 1e-6);
}

/// The command of a servo jumps at a kink of its set point, out of the range of its limit.
#[test]
fn derivatives_pass_kinks_of_set_points() {
    let servo = |[kink, limit, kd]: [f64; 3]| {
        mechanism(&format!(
            "duration = \"60 ms\"\n[bodies.crank]\nmass = \"0.1 kg\"\ninertia = \"0.0001 kg*m^2\"\n[joints.q]\n\
             bodies = [\"ground\", \"crank\"]\npoints = [[\"0 m\", \"0 m\"], [\"0 m\", \"0 m\"]]\nstart = \"0 rad\"\n\
             [actuators.motor]\njoint = \"q\"\ntimes = [\"0 s\", \"{kink:?} s\", \"0.032123 s\"]\n\
             targets = [\"0 rad\", \"1.8540 rad\", \"1.0833 rad\"]\nkp = \"1.9639 N*m/rad\"\nkd = \"{kd:?} N*m*s/rad\"\n\
             limit = \"{limit:?} N*m\"\n"
        ))
    };
    let [kink, limit, kd] = [0.023237, 0.4441, 0.02943];
    assert_differences("limit", &parameter(limit, |limit| servo([kink, limit, kd])), 1e-3, 1e-6);
    assert_differences("gain", &parameter(kd, |kd| servo([kink, limit, kd])), 1e-3, 1e-6);
    assert_differences("kink", &parameter(kink, |kink| servo([kink, limit, kd])), 1e-3, 1e-6);
}

/// A parameter of a random mechanism.
fn random_parameter(mechanism: &Mechanism, random: &mut Random) -> (f64, impl Fn(f64) -> Mechanism) {
    let pick = |count: usize, random: &mut Random| (random.unit() * count as f64) as usize;
    let (kind, body) = (pick(5, random), pick(mechanism.bodies.len(), random));
    let spring = pick(mechanism.springs.len().max(1), random);
    let base = mechanism.clone();
    fn access(mechanism: &mut Mechanism, kind: usize, body: usize, spring: usize) -> &mut f64 {
        match kind {
            1 if !mechanism.springs.is_empty() => &mut mechanism.springs[spring].stiffness,
            2 => &mut mechanism.gravity_m_s2[1],
            3 if !mechanism.contacts.is_empty() => &mut mechanism.contacts[0].law.normal.stiffness_n_per_m_e,
            4 => &mut mechanism.bodies[body].com_m[0],
            _ => &mut mechanism.bodies[body].mass_kg,
        }
    }
    let value = *access(&mut mechanism.clone(), kind, body, spring);
    let at = move |value: f64| {
        let mut changed = base.clone();
        *access(&mut changed, kind, body, spring) = value;
        changed
    };
    (value, at)
}

/// Six-bars that Newton's method places: by a mass, by a length, and by the height of gravity.
#[test]
fn derivatives_of_assur_groups_agree_with_differences() {
    for seed in [0, 1] {
        let (mechanism, crank, rate) = random_assur(seed);
        let base = Mechanism { gravity_m_s2: [0.0, -9.0], ..with_start(&mechanism, 0, crank, 0.3 * rate) };
        type Access = fn(&mut Mechanism) -> &mut f64;
        let accesses: [Access; 3] = [
            |mechanism| &mut mechanism.bodies[1].mass_kg,
            |mechanism| &mut mechanism.joints[1].points_m[0][0],
            |mechanism| &mut mechanism.gravity_m_s2[1],
        ];
        for (index, access) in accesses.into_iter().enumerate() {
            let at = |value: f64| {
                let mut changed = base.clone();
                *access(&mut changed) = value;
                mechanism_scene(changed, 0.02)
            };
            let parameter = parameter(*access(&mut base.clone()), at);
            assert_eq!(gradient_of(&parameter).end.reason, None, "seed {seed}, parameter {index}");
            assert_differences(&format!("seed {seed}, parameter {index}"), &parameter, 1e-3, 1e-6);
        }
    }
}

/// Derivatives of a loop with the start on the joint that the crank drives, by a mass and by a length, agree with differences:
/// at its dead centres other coordinates take over. Returns the turns of the crank.
fn turns_with_derivatives(seed: u64) -> f64 {
    let (kind, of, rate) = random_linkage(seed);
    let start = assemble(&with_start(&of, 0, of.bodies[0].pose[2], rate)).unwrap_or_else(|error| panic!("{error}"));
    let driven = of.joints.len() - 1;
    let (value, driven_rate) = start.joint(&of.joints[driven]);
    let base = Mechanism { gravity_m_s2: [0.0, -9.0], ..with_start(&of, driven, value, driven_rate) };
    let duration_s = 8.0 / rate.abs();
    type Access = fn(&mut Mechanism) -> &mut f64;
    let accesses: [Access; 2] =
        [|mechanism| &mut mechanism.bodies[1].mass_kg, |mechanism| &mut mechanism.joints[1].points_m[0][0]];
    for (index, access) in accesses.into_iter().enumerate() {
        let at = |value: f64| {
            let mut changed = base.clone();
            *access(&mut changed) = value;
            mechanism_scene(changed, duration_s)
        };
        let (name, parameter) =
            (format!("{kind} {seed}, parameter {index}"), parameter(*access(&mut base.clone()), at));
        assert_eq!(gradient_of(&parameter).end.reason, None, "{name}");
        assert_differences(&name, &parameter, 1e-4, 1e-6);
    }
    run_to_end(&mechanism_scene(base, duration_s)).0.last.joint_state(0).angle_rad / TAU
}

#[test]
fn derivatives_continue_where_coordinates_are_exchanged() {
    for seed in [0, 1] {
        let turns = turns_with_derivatives(seed);
        assert!(turns.abs() > 0.5, "{seed}: {turns} turns");
    }
}

/// `PHALANX_SEEDS` is the range of seeds.
#[test]
#[ignore = "takes minutes"]
fn derivatives_of_many_loops_continue_where_coordinates_are_exchanged() {
    for seed in seeds("2..14") {
        println!("{seed}: {:.2} turns", turns_with_derivatives(seed));
    }
}

/// Relative error of the derivatives of a random mechanism at its end; `None` if there are none.
fn random_error(seed: u64) -> Option<f64> {
    let mechanism = random_mechanism(seed);
    let mut random = Random::for_seed(seed + 3_000_000);
    let (value, at) = random_parameter(&mechanism, &mut random);
    let parameter = parameter(value, |value| mechanism_scene(at(value), 0.02));
    let scene = (parameter.scene_at)(value).expect("a scene");
    let found = gradient(&scene, std::slice::from_ref(&parameter), &|| true).ok()?.remove(0);
    if let Some(reason) = &found.end.reason {
        println!("{seed}: {reason}");
        return None;
    }
    let schema = Schema::from_scene(&scene);
    let ends = differences(&parameter, 1e-3, |(end, _)| end.clone());
    let (values, _) = run_at(&parameter, value);
    let mut largest = (0.0, String::new());
    for (index, channel) in schema.channels().iter().enumerate() {
        let Some(derivative) = found.end.values.get(&channel.name) else { continue };
        let scale = largest_of_unit(&schema, &ends, &values, value, channel.unit);
        let error = ((derivative - ends[index][0]).abs() - 3.0 * ends[index][1]).max(0.0) / scale;
        if error > largest.0 {
            largest = (error, format!("{} {derivative:e} {:?}", channel.name, ends[index]));
        }
    }
    println!("{seed}: {} events, {:e} {}", found.events.len(), largest.0, largest.1);
    Some(largest.0)
}

#[test]
fn derivatives_of_random_mechanisms_agree_with_differences() {
    let seeds = seeds("0..4");
    let errors: Vec<f64> = seeds.clone().filter_map(random_error).collect();
    println!("{} of {seeds:?} have derivatives", errors.len());
    assert!(errors.len() > seeds.count() / 2, "{} have derivatives", errors.len());
    errors.iter().for_each(|error| assert_below(*error, 1e-6, "derivatives of a random mechanism"));
}

#[test]
fn refusals_name_their_reasons() {
    let case = mechanism_case("h_pd_step");
    let sampled = parameter(1.0, |_| {
        let mut scene = case.scene();
        let actuators = &mut scene.mechanism.as_mut().expect("a mechanism").actuators;
        if let phalanx::mechanism::Command::Servo { rate_hz, .. } = &mut actuators[0].command {
            *rate_hz = Some(1e3);
        }
        scene
    });
    let scene = (sampled.scene_at)(1.0).expect("a scene");
    let error = gradient(&scene, &[sampled], &|| true).expect_err("no derivatives").to_string();
    assert!(error.contains("servos with a `rate`"), "{error}");
    // The parameter separates surfaces that touch at the start.
    let touching = parameter(0.01, |radius| {
        let disc = disc("ball", radius, [0.0, 0.01], free(0.05, None, [0.0, -0.1]));
        scene_on_plane(vec![disc], NormalLaw::step(1e6, 1.5, 0.0, 1e-5), None, 0.01)
    });
    let found = gradient_of(&touching);
    let reason = found.end.reason.expect("a reason");
    assert!(reason.contains("at the start") || reason.contains("the events change"), "{reason}");
}

/// A jaw on a spindle with a loss, whose motor presses it against a bumper and whose controller measures its distance from
/// the ground.
fn spindle(key: &str, value: f64, changed: &[(&str, &str)]) -> Scene {
    let mut motor = vec![
        ("torque_constant", "0.02"),
        ("resistance", "2.0"),
        ("voltage", "6.0"),
        ("inductance", "1e-3"),
        ("kp", "4e3"),
        ("kd", "2.0"),
        ("lead", "8e-3"),
        ("rotor", "2e-6"),
        ("efficiency", "0.7"),
        ("loss_rate", "5e-3"),
        ("back_emf", "0.021"),
        ("target", "4.5e-2"),
        ("current_limit", "50.0"),
        ("offset", "3e-2"),
    ];
    for (name, text) in changed {
        motor.iter_mut().find(|(found, _)| found == name).expect("a key").1 = text;
    }
    let text = |name: &str| {
        let found = motor.iter().find(|(found, _)| *found == name).expect("a key").1.to_string();
        if name == key { format!("{value:?}") } else { found }
    };
    let [kt, r, v, l, kp, kd] = ["torque_constant", "resistance", "voltage", "inductance", "kp", "kd"].map(text);
    let [lead, rotor, efficiency, rate] = ["lead", "rotor", "efficiency", "loss_rate"].map(text);
    let [ke, target, limit, offset] = ["back_emf", "target", "current_limit", "offset"].map(text);
    mechanism(&format!(
        r#"duration = "60 ms"
[bodies.jaw]
mass = "0.2 kg"
inertia = "1e-4 kg*m^2"
guess = {{ at = ["{offset} m", "0 mm"] }}
[bodies.jaw.points.tip]
at = ["1 mm", "7 mm"]
[ground.points.origin]
at = ["0 mm", "0 mm"]
[bodies.jaw.outlines.pad]
type = "disc"
center = ["0 mm", "0 mm"]
radius = "5 mm"
[ground.outlines.wall]
type = "disc"
center = ["52 mm", "0 mm"]
radius = "10 mm"
[laws.pad]
stiffness = 1e6
damping = "0.1 s/m"
[[contacts]]
points = "jaw.pad"
faces = ["ground.wall"]
law = "pad"
[joints.slide]
type = "prismatic"
bodies = ["ground", "jaw"]
points = [["0 mm", "0 mm"], ["0 mm", "0 mm"]]
start = "{offset} m"
[actuators.grip]
joint = "slide"
lead = "{lead} m"
rotor = "{rotor} kg*m^2"
efficiency = {efficiency}
loss_rate = "{rate} m/s"
target = "{target} m"
kp = "{kp} V/m"
kd = "{kd} V*s/m"
motor = {{ torque_constant = "{kt} N*m/A", resistance = "{r} ohm", voltage = "{v} V", current_limit = "{limit} A", back_emf = "{ke} V*s/rad", inductance = "{l} H" }}
feedback = {{ distance = ["ground.origin", "jaw.tip"] }}
"#
    ))
}

#[test]
fn derivatives_of_drives_agree_with_differences() {
    let keys = [
        ("torque_constant", 0.02),
        ("resistance", 2.0),
        ("voltage", 6.0),
        ("inductance", 1e-3),
        ("kp", 4e3),
        ("kd", 2.0),
        ("lead", 8e-3),
        ("rotor", 2e-6),
        ("efficiency", 0.7),
        ("loss_rate", 5e-3),
        ("back_emf", 0.021),
        ("target", 4.5e-2),
        ("offset", 3e-2),
    ];
    for (key, value) in keys {
        assert_differences(key, &parameter(value, |value| spindle(key, value, &[])), 1e-3, 1e-5);
    }
}

/// The current reaches its limit, and leaves it. Without an inductance its rate jumps there, but not the force. With one, the rate
/// of a state jumps, and the derivatives are refused.
#[test]
fn derivatives_across_a_current_limit_agree_with_differences_or_are_refused() {
    let limits = ["0.7", "1.0", "2.0"];
    for limit in limits {
        let own = limit.parse().expect("a number");
        for (key, value) in [("current_limit", own), ("voltage", 6.0), ("kp", 4e3), ("target", 4.5e-2), ("lead", 8e-3)]
        {
            let limited = |inductance: Option<f64>| {
                parameter(value, move |value| {
                    let mut scene = spindle(key, value, &[("current_limit", limit)]);
                    let actuators = &mut scene.mechanism.as_mut().expect("a mechanism").actuators;
                    actuators[0].powertrain.motor.as_mut().expect("a motor").inductance = inductance;
                    scene
                })
            };
            let resistive = limited(None);
            let found = gradient_of(&resistive);
            assert_eq!(found.end.reason, None, "{key} {limit}");
            assert_differences(key, &resistive, 1e-3, 1e-5);
            let inductive = gradient_of(&limited(Some(1e-3)));
            let reason = inductive.end.reason.unwrap_or_default();
            assert!(reason.contains("the accelerations jump at"), "{key} {limit}: {reason}");
        }
    }
}
