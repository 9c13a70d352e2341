//! One finger: experiment 95 (design 95 of the thesis closing on its object) against reference values, energy, torque
//! jumps, time reversal, and event location. With stiction: against a gripper on a fixed disc, which uses another model;
//! sticking contacts; and the energy of bristles.

use crate::support::runs::{
    CollectSink, PHALANGES, assert_below, assert_near, engineering_settings, experiment_95, experiment_95_with,
    finger_difference, load, load_with_stiction, max_angle_error, options, reference_settings, run_dense_reference,
    run_to_end, with_reference_settings,
};
use phalanx::analytic::{ContactReading, ContactState, FingerMode, Model, QUADRATURES, StictionModel};
use phalanx::gripper::FingerContact;
use phalanx::integrator::{self, Fixed, Radau5, Rodas5p, State, SwitchedMethod, integrate};
use phalanx::law::{Bristle, ContactLaw, FrictionKind, FrictionRange, elastic_energy};
use phalanx::scene::{
    self, FingerContactLaws, Integrator, Interpolation, Method, Placement, Profile, Scene, Spring, SpringKind,
};
use phalanx::trace::{self, ContactSample, EventKind, FingerState, Outcome, Sample};

fn run_with_settings(integrator: Integrator) -> (Outcome, CollectSink) {
    run_to_end(&Scene { integrator, ..experiment_95() })
}

/// The reference values come from an independent integration of high accuracy, in another language and another
/// formulation of the same equations. They are printed to 1 ns, 1e-6 degrees and 1e-4 N, so they are exact only to half
/// of their last digit. Tolerances are absolute for times (s) and angles (rad) and relative for forces; `digits` times
/// half of the last printed digit is added to each.
#[test]
fn presets_match_the_reference_values() {
    for (settings, time_s, angle_rad, force, digits) in
        [(engineering_settings(), 1e-6, 1e-5, 1e-3, 0.0), (reference_settings(), 1e-9, 1e-8, 1e-5, 1.0)]
    {
        let (Outcome { last, .. }, log) = run_with_settings(settings);
        assert_eq!(last.time_s, 20e-3);
        let [time_s, angle_rad] = [time_s + digits * 0.5e-9, angle_rad + digits * 0.5e-6f64.to_radians()];
        let contacts = [(4.501315e-3, 23.6092), (6.883746e-3, 8.2573)];
        for (contact, (first_s, normal_n)) in PHALANGES.into_iter().zip(contacts) {
            assert_near(log.first_contact_s(contact as usize).expect("a contact"), first_s, time_s, "first contact");
            assert_near(last.finger_contact(contact).normal_n, normal_n, force * normal_n + digits * 0.5e-4, "force");
        }
        assert_near(last.finger(0).q11_rad, 2.088778f64.to_radians(), angle_rad, "q11");
        assert_near(last.finger(0).q21_rad, 65.019991f64.to_radians(), angle_rad, "q21");
    }
}

/// At tolerances below the reference settings, the methods agree to their last digits.
#[test]
fn both_methods_agree_along_the_trajectory() {
    let grid_s = 0.25e-3;
    let [(rodas, rodas_log), (radau, radau_log)] = [Method::Rodas5p, Method::RadauIIa5].map(|method| {
        let (rtol, atol_angle_rad, atol_rate_rad_s) = (1e-12, 1e-14, 1e-10);
        let integrator = Integrator { method, rtol, atol_angle_rad, atol_rate_rad_s, ..reference_settings() };
        let mut scene = Scene { integrator, ..experiment_95() };
        scene.log.numeric_hz = 1.0 / grid_s;
        run_to_end(&scene)
    });
    for i in 0..=80 {
        let t = f64::from(i) * grid_s;
        let (a, b) = (rodas_log.nearest_sample(t), radau_log.nearest_sample(t));
        assert!((a.time_s - t).abs() < 1e-15 && (b.time_s - t).abs() < 1e-15, "no sample at {t}");
        assert_near(a.finger(0).q11_rad, b.finger(0).q11_rad, 1e-9, format!("q11 at {t}"));
        assert_near(a.finger(0).q21_rad, b.finger(0).q21_rad, 1e-9, format!("q21 at {t}"));
    }
    for (a, b) in rodas.contacts.iter().zip(&radau.contacts) {
        assert_near(a.impulse_n_s, b.impulse_n_s, 1e-7 * b.impulse_n_s.abs(), "impulse");
        assert_near(a.first_s.unwrap_or(0.0), b.first_s.unwrap_or(0.0), 1e-12, "contact time");
    }
}

/// The shortest decimal form of a number identifies all its bits.
#[test]
fn runs_are_deterministic() {
    for settings in [engineering_settings(), reference_settings()] {
        let [first, second] = [settings; 2].map(|settings| format!("{:?}", run_with_settings(settings)));
        assert!(first == second, "two runs differ");
    }
}

/// Closings that differ in the elements that store or dissipate energy.
fn closings() -> Vec<(String, Scene)> {
    let mut closings = vec![("experiment 95".to_string(), experiment_95())];
    let mut add = |name: &str, change: &dyn Fn(&mut Scene)| {
        closings.push((name.to_string(), experiment_95_with(change)));
    };
    add("frictionless", &|scene| {
        scene.finger_mut().contact.both_mut().into_iter().for_each(|law| law.friction = None);
    });
    add("no object", &|scene| {
        scene.hand.object = None;
        scene.duration_s = 8e-3;
    });
    add("gravity only", &|scene| {
        scene.finger_mut().motor.actuation = Profile::Constant { value: 0.0 };
        scene.finger_mut().spring = None;
        scene.hand.gravity_m_s2 = [-9.81, 0.0];
        scene.duration_s = 60e-3;
    });
    add("torque table", &|scene| {
        let (points, interpolation) = (vec![(0.0, 0.1), (2e-3, 0.5), (9e-3, 0.2)], Interpolation::Linear);
        scene.finger_mut().motor.actuation = Profile::Table { points, interpolation };
    });
    let torsional = SpringKind::Torsional { stiffness_n_m_per_rad: 0.06, preload_rad: 1.92 };
    for placement in Placement::ALL {
        for kind in [SpringKind::Constant { torque_n_m: 0.1326 }, torsional] {
            add(&format!("{placement:?}, {kind:?}"), &|scene| {
                scene.finger_mut().spring = Some(Spring { kind, placement });
            });
        }
    }
    closings
}

/// The motor work equals the change of kinetic, gravitational, spring and contact energy plus dissipation, over whole
/// closings with impacts. The energy scale is the larger of the largest motor work and the largest kinetic energy.
#[test]
fn energy_balances() {
    let reference_rodas = Integrator { method: Method::Rodas5p, ..reference_settings() };
    for (integrator, balance, decrease) in
        [(reference_settings(), 1e-9, 1e-9), (reference_rodas, 1e-9, 1e-9), (engineering_settings(), 1e-5, 1e-8)]
    {
        for (name, scene) in closings() {
            let (_, log) = run_to_end(&Scene { integrator, ..scene });
            let largest = |f: fn(&Sample) -> f64| log.samples.iter().map(f).fold(0.0, f64::max);
            let scale_j = largest(|s| s.energy().motor_work_j.abs()).max(largest(|s| s.energy().kinetic_j));
            assert_below(largest(|s| s.energy().balance_j.abs()), balance * scale_j, &name);
            let mut dissipated_j = 0.0f64;
            for sample in &log.samples {
                dissipated_j = dissipated_j.max(sample.energy().dissipated_j);
                assert_below(dissipated_j - sample.energy().dissipated_j, decrease * scale_j, &name);
            }
        }
    }
}

#[test]
fn work_of_a_constant_torque_is_torque_times_angle() {
    let initial_rad = experiment_95().finger().initial.q11_rad;
    for settings in [engineering_settings(), reference_settings()] {
        for sample in run_with_settings(settings).1.samples {
            let work = 0.48 * (sample.finger(0).q11_rad - initial_rad);
            assert_below((sample.energy().motor_work_j - work).abs(), 1e-13, "motor work");
        }
    }
}

/// Recomputes kinetic, gravitational and spring energy from the logged angles and rates. Gravity acts along +y.
#[test]
fn logged_energies_match_the_logged_state() {
    let scene = with_reference_settings(&experiment_95());
    let (l, b) = (scene.finger().linkage.lengths, scene.finger().linkage.bodies);
    let mut gravity_differences = Vec::new();
    for sample in run_to_end(&scene).1.samples {
        let (f, energy) = (sample.finger(0), sample.energy());
        let (first, second) = ((f.q11_rad, f.qd11_rad_s), (f.q21_rad, f.qd21_rad_s));
        let third = (f.q11_rad + f.q12_rad, f.qd11_rad_s + f.qd12_rad_s);
        let fourth = (f.q13_rad, f.qd21_rad_s + f.qd22_rad_s);
        let (mut gravity, mut kinetic) = (0.0, 0.0);
        for (body, length, (base_angle, base_rate), (angle, rate)) in [
            (b.l11, 0.0, (0.0, 0.0), first),
            (b.l21, 0.0, (0.0, 0.0), second),
            (b.l12, l.l11_m, first, third),
            (b.l22, l.l21_m, second, fourth),
        ] {
            let ([x, y], (sin, cos), (base_sin, base_cos)) = (body.com_m, angle.sin_cos(), base_angle.sin_cos());
            let height = length * base_sin + (x * sin + y * cos);
            let u = -length * base_rate * base_sin - rate * (sin * x + cos * y);
            let v = length * base_rate * base_cos + rate * (cos * x - sin * y);
            gravity += -9.81 * body.mass_kg * height;
            kinetic += 0.5 * (body.mass_kg * (u * u + v * v) + body.inertia_kg_m2 * rate * rate);
        }
        gravity_differences.push(gravity - energy.gravity_j);
        assert_near(kinetic, energy.kinetic_j, 1e-13 * (1.0 + kinetic), "kinetic energy");
        // Constant spring torque on q22, with zero energy at the straight configuration.
        assert_near(0.1326 * (f.q22_rad + l.phi22_rad), energy.spring_j, 1e-14, "spring energy");
    }
    for difference in &gravity_differences {
        assert_near(*difference, gravity_differences[0], 1e-16, "gravitational energy");
    }
}

/// A step of the integrator ends at every jump of the torque and does not evaluate the torque after it: with up to three
/// jumps before the first contact, engineering settings agree with the reference to 1e-9 rad. The work of a stepped
/// torque is the sum of torque times angle.
#[test]
fn torque_jumps_do_not_reduce_accuracy() {
    let points = vec![(0.0, 0.48), (1.1e-3, 0.1), (2e-3, 0.3), (3e-3, 0.5)];
    let table = Profile::Table { points: points.clone(), interpolation: Interpolation::Step };
    for actuation in [Profile::Reversal { value: 0.48, at_s: 3e-3 }, table.clone()] {
        let runs = [engineering_settings(), reference_settings()].map(|integrator| {
            run_to_end(&experiment_95_with(|scene| {
                scene.finger_mut().motor.actuation = actuation.clone();
                (scene.integrator, scene.duration_s) = (integrator, 4e-3);
            }))
        });
        let [engineering, reference] = runs.each_ref().map(|(outcome, _)| outcome.last.finger(0));
        assert_below(finger_difference(&engineering, &reference), 1e-9, format!("{actuation:?}"));
        for (outcome, log) in runs.iter().filter(|_| actuation == table) {
            // Each jump coincides with a sample.
            let q11_at = |t: f64| {
                let sample = log.nearest_sample(t);
                assert!((sample.time_s - t).abs() < 1e-15, "no sample at {t}");
                sample.finger(0).q11_rad
            };
            let angles: Vec<f64> = points.iter().map(|point| point.0).chain([4e-3]).map(q11_at).collect();
            let work: f64 = points.iter().zip(angles.windows(2)).map(|(point, a)| point.1 * (a[1] - a[0])).sum();
            assert_below((outcome.last.energy().motor_work_j - work).abs(), 1e-12, "work");
        }
    }
}

type Layout = Fixed<2, QUADRATURES>;
type SwingState = State<Layout>;

/// Swings without joint limit and object: spring, constant torque and gravity are conservative. With their starts and
/// durations.
fn conservative_swings() -> Vec<(Scene, SwingState, f64)> {
    let mut scene = experiment_95();
    scene.finger_mut().limit = None;
    scene.hand.object = None;
    let state = |q, v| State { q, v, z: [0.0; QUADRATURES] };
    let mut swings = vec![
        (scene.clone(), state([-0.3, 1.1], [0.0, 0.0]), 3e-3),
        (scene.clone(), state([-0.6, 0.9], [150.0, 100.0]), 2e-3),
    ];
    for placement in [Placement::GroundLinks, Placement::DrivenCoupler, Placement::CouplerDistal] {
        let kind = SpringKind::Torsional { stiffness_n_m_per_rad: 0.1, preload_rad: 1.0 };
        scene.finger_mut().spring = Some(Spring { kind, placement });
        swings.push((scene.clone(), state([-0.3, 1.1], [20.0, 10.0]), 3e-3));
    }
    swings
}

/// A conservative swing that continues with reversed rates returns to its initial state.
#[test]
fn both_methods_are_time_reversible() {
    fn check<K: integrator::Method<Layout>>(name: &str) {
        for (scene, start, span) in conservative_swings() {
            let model = Model::new(&scene.hand);
            let swing = |start: SwingState| {
                let options = options(&reference_settings());
                let end = integrate::<_, K, _>(&model, &options, 0.0, start, span, &mut ());
                assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                end.state
            };
            let largest = |f: &dyn Fn(usize) -> f64| f(0).abs().max(f(1).abs());
            let there = swing(start.clone());
            assert!(largest(&|i| there.q[i] - start.q[i]) > 0.1, "{name}: hardly moved");
            let back = swing(State { v: there.v.map(|v| -v), ..there });
            // Over milliseconds, errors of rates are a thousand times those of angles.
            assert_below(largest(&|i| back.q[i] - start.q[i]), 1e-10, name);
            assert_below(1e-3 * largest(&|i| back.v[i] + start.v[i]), 1e-10, name);
        }
    }
    check::<Radau5<Layout>>("Radau IIA");
    check::<Rodas5p<Layout>>("Rodas5P");
}

fn run_with_rtol(name: &str, rtol: f64) -> (Scene, CollectSink) {
    let mut scene = load(name);
    scene.integrator = scene.integrator.with_rtol(rtol);
    let mut log = CollectSink::default();
    trace::run_analytic(&scene, &mut log).expect("a completed run");
    (scene, log)
}

/// Touch-downs are located to 1e-5 of δ_max and lift-offs to 1e-6 N, at any step size.
#[test]
fn events_are_located_within_their_tolerances() {
    let (mut touchdowns, mut liftoffs) = (0, 0);
    for name in ["experiment-95", "hard/limit-hammered", "hard/v-static-1e-4", "hard/exponent-1.5", "hard/damper-none"]
    {
        for rtol in [1e-2, 1e-3, 1e-5] {
            let (scene, log) = run_with_rtol(name, rtol);
            let transition_m = scene.finger().contact.proximal.normal.depth_scale_m();
            for event in &log.events {
                let sample = log.samples.iter().find(|sample| sample.time_s == event.time_s);
                let contact = sample.expect("a sample at the event").contact(event.contact);
                let context = format!("{name}, rtol {rtol:e}: {event:?} at {contact:?}");
                match (log.samples[0].is_stop(event.contact), event.kind) {
                    (true, _) => {}
                    (_, EventKind::TouchDown) => {
                        touchdowns += 1;
                        assert!(contact.gap_m.abs() <= 1.01e-5 * transition_m, "{context}");
                    }
                    (_, EventKind::LiftOff) => {
                        liftoffs += 1;
                        assert!(contact.normal_n <= 1.01e-6, "{context}");
                    }
                    _ => {}
                }
            }
        }
    }
    assert!(touchdowns >= 40 && liftoffs >= 20, "only {touchdowns} touch-downs and {liftoffs} lift-offs");
}

/// The contact force has a kink where the damping reaches its maximum, at δ_max. The event is at 1.01 δ_max on the way
/// in and at 0.99 δ_max on the way out. A step ends there to within 0.0031 δ_max, and no step crosses it.
#[test]
fn no_step_crosses_the_damper_transition() {
    let mut steps_at_transition = 0;
    for name in ["hard/missed-reload", "hard/friction-well"] {
        for rtol in [1e-3, 1e-4, 1e-5] {
            let (scene, log) = run_with_rtol(name, rtol);
            let laws = scene.finger().contact;
            for (index, law) in [laws.proximal, laws.distal].into_iter().enumerate() {
                // Penetrations in δ_max; NaN for contacts without a force.
                let depth = |ContactSample { gap_m, normal_n, .. }: &ContactSample| {
                    if *normal_n > 0.0 { -gap_m / law.normal.depth_scale_m() } else { f64::NAN }
                };
                let depths: Vec<f64> = log.samples.iter().map(|sample| depth(&sample.contact(index))).collect();
                for pair in depths.windows(2) {
                    let crosses_transition = pair[0] < 1.006 && pair[1] > 1.014 || pair[0] > 0.994 && pair[1] < 0.986;
                    assert!(!crosses_transition, "{name}, rtol {rtol:e}: a step from {} to {} δ_max", pair[0], pair[1]);
                }
                let is_at_transition = |depth: f64| (depth - 1.01).abs() < 3.1e-3 || (depth - 0.99).abs() < 3.1e-3;
                steps_at_transition += depths.iter().filter(|depth| is_at_transition(**depth)).count();
            }
        }
    }
    assert!(steps_at_transition >= 9, "only {steps_at_transition} steps end at the transition");
}

fn samples_on_grid(samples: &[Sample]) -> Vec<&Sample> {
    let is_on_grid = |sample: &&Sample| ((sample.time_s * 1e4).round() / 1e4 - sample.time_s).abs() < 1e-13;
    samples.iter().filter(is_on_grid).collect()
}

/// Runs experiment 95 with these contact laws for 60 ms with reference settings.
fn run_finger(contacts: FingerContactLaws) -> CollectSink {
    let mut scene = Scene { duration_s: 0.06, ..with_reference_settings(&load_with_stiction("experiment-95")) };
    scene.finger_mut().contact = contacts;
    run_to_end(&scene).1
}

/// On a fixed disc each finger of a gripper, a mechanism, moves like the closed form of a single finger: with bristles on
/// both phalanges, on one phalanx, and with soft bristles, which slip more.
#[test]
fn each_finger_of_a_gripper_on_a_fixed_disc_matches_a_single_finger() {
    let all_sticking = load_with_stiction("experiment-95").finger().contact;
    let without_bristle = |mut law: ContactLaw| {
        law.friction.as_mut().expect("friction").kind = FrictionKind::Regularised;
        law
    };
    let proximal_only = FingerContactLaws { distal: without_bristle(all_sticking.distal), ..all_sticking };
    let mut soft = all_sticking;
    for law in soft.both_mut() {
        law.friction.as_mut().expect("friction").kind =
            FrictionKind::Bristle(Bristle { damping_n_s_per_m: 200.0, relaxation_s: 2e-4 });
    }
    for contacts in [all_sticking, proximal_only, soft] {
        let finger_log = run_finger(contacts);
        let mut gripper = with_reference_settings(&scene::load_any("scenes/gripper/fixed.toml").expect("a scene"));
        gripper.hand.fingers.iter_mut().for_each(|finger| finger.contact = contacts);
        gripper.duration_s = 0.06;
        let mut gripper_log = CollectSink::default();
        trace::run_analytic(&gripper, &mut gripper_log).expect("a run");
        let [expected, actual] = [&finger_log, &gripper_log].map(|log| samples_on_grid(&log.samples));
        assert_eq!((expected.len(), actual.len()), (601, 601));
        for (expected, actual) in expected.iter().zip(&actual) {
            let difference = |finger: &FingerState| finger_difference(finger, &expected.finger(0));
            assert!(actual.fingers().all(|finger| difference(&finger) < 1e-8), "at {} s", expected.time_s);
        }
        for contact in PHALANGES {
            let expected = expected[600].finger_contact(contact).tangential_n;
            let error = (expected - actual[600].contact(contact as usize).tangential_n).abs();
            assert!(error < 1e-6 && expected.abs() > 1e-3, "{contact:?}: error {error:.1e} N of {expected}");
        }
    }
    let FingerContactLaws { proximal, distal } = all_sticking;
    let regularised = FingerContactLaws { proximal: without_bristle(proximal), distal: without_bristle(distal) };
    let logs = [all_sticking, regularised].map(run_finger);
    let [sticking, regularised] = logs.each_ref().map(|log| samples_on_grid(&log.samples));
    let has_effect =
        sticking.iter().zip(&regularised).any(|(a, b)| (a.finger(0).q11_rad - b.finger(0).q11_rad).abs() > 1e-6);
    assert!(has_effect, "stiction has no effect");
}

/// Contact of a phalanx at the end of a run: its law, its bristle and the state of the bristle, and its reading.
struct EndContact {
    contact: FingerContact,
    law: ContactLaw,
    bristle: Bristle,
    state: f64,
    reading: ContactReading,
}

/// Runs a finger up to `time_s` and returns the contacts of both phalanges.
fn contacts_at(scene: &Scene, time_s: f64) -> [EndContact; 2] {
    let (model, start) = (StictionModel::new(&scene.hand), StictionModel::start(&scene.hand));
    let end = integrate::<_, SwitchedMethod<Fixed<4, QUADRATURES>>, _>(
        &model,
        &options(&reference_settings()),
        0.0,
        start,
        time_s,
        &mut (),
    );
    assert!(end.result.is_ok(), "{:?}", end.result);
    let State { q, v, .. } = end.state;
    let mode: FingerMode = [ContactState::Active, ContactState::Active, ContactState::Free].into();
    PHALANGES.map(|contact| {
        let FingerContactLaws { proximal, distal } = scene.finger().contact;
        let law = [proximal, distal][contact as usize];
        let FrictionKind::Bristle(bristle) = law.friction.expect("friction").kind else { panic!("no bristle") };
        let reading = model.contact_reading(q, v, contact, mode[contact as usize]).expect("a contact");
        EndContact { contact, law, bristle, state: v[2 + contact as usize], reading }
    })
}

/// With T = c (σ + v) the speed of the slider is v − ṡ, which is zero in a sticking contact. Phalanges of steel creep,
/// and slip as they creep, for a minute; with a contact spring of 1e10 N/m they are at rest within a millisecond.
#[test]
fn sliders_of_sticking_contacts_are_at_rest() {
    for name in ["experiment-95", "experiment-95-cad", "long-fingers", "torsional-spring"] {
        let mut scene = load_with_stiction(name);
        for law in scene.finger_mut().contact.both_mut() {
            (law.normal.stiffness_n_per_m_e, law.normal.exponent) = (1e10, 1.0);
        }
        for EndContact { contact, law, bristle, state, reading } in contacts_at(&scene, 0.2) {
            let (context, friction) = (format!("{name} {contact:?}"), law.friction.expect("friction"));
            let force = -friction.force(reading.slip, Some(state), reading.normal, FrictionRange::Any);
            assert_below((reading.slip - (force / bristle.damping_n_s_per_m - state)).abs(), 1e-15, &context);
            assert_below(reading.slip.abs(), 1e-12, &context);
            assert_below(force.abs(), 0.999 * friction.mu_static * reading.normal, &context);
            assert!(reading.normal > 1.0 && force.abs() > 1e-3, "{context}: {force} of {} N", reading.normal);
            assert_below((reading.tangential + force).abs(), 1e-12, &context);
        }
    }
}

/// In addition to the invariants, which are checked at every sample: bristles store ½ k s², and the energy balance
/// closes.
#[test]
fn elastic_energy_includes_bristles() {
    let scene = with_reference_settings(&load_with_stiction("experiment-95"));
    let energy = run_to_end(&scene).0.last.energy();
    let stored = contacts_at(&scene, scene.duration_s).map(|EndContact { law, bristle, state, reading, .. }| {
        let stretch_m = bristle.relaxation_s * state;
        let stiffness = bristle.damping_n_s_per_m / bristle.relaxation_s;
        0.5 * stiffness * stretch_m * stretch_m + elastic_energy(&law.normal, reading.delta)
    });
    let stored: f64 = stored.into_iter().sum();
    assert_below((energy.elastic_j - stored).abs(), 1e-6 * stored, "elastic energy");
    assert!(energy.balance_j.abs() < 1e-9 && energy.dissipated_j > 0.1, "{energy:?}");
}

#[test]
fn engineering_preset_is_close_to_the_reference() {
    for name in [
        "experiment-95",
        "experiment-95-cad",
        "long-fingers",
        "torsional-spring",
        "soft-start",
        "hard/friction-2",
        "hard/v-static-1e-3",
        "hard/mass-links-light",
    ] {
        let scene = load_with_stiction(name);
        let [engineering, reference] = [run_to_end(&scene).1, run_dense_reference(&scene).1];
        assert_below(max_angle_error(&engineering, &reference), 1e-5, name);
    }
}
