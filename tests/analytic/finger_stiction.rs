//! One finger with stiction: against a gripper on a fixed disc, which uses another model; its Jacobian; sticking
//! contacts; and the energy of bristles.

use phalanx::analytic::{BristleModel, ContactState, EVENT_FUNCTIONS, FingerMode, Model, QUADRATURES};
use phalanx::gripper::FingerContact;
use phalanx::integrator::{Options, RadauOrRodas, State, System, Tolerances, integrate};
use phalanx::law::bristle_force;
use phalanx::scene::{self, FingerContactLaws, Scene};
use phalanx::trace::{self, Sample};

use super::jacobian::{penetrating_posture, rates_with_row_values};
use crate::support::runs::{CollectSink, max_angle_error, reference_settings, run_to_end};
use crate::support::stiction::{load_with_stiction, with_stiction};

const PHALANGES: [FingerContact; 2] = [FingerContact::Proximal, FingerContact::Distal];

fn gripper_scene(contacts: FingerContactLaws) -> Scene {
    let mut scene = scene::load_any("scenes/gripper/fixed.toml").expect("a scene");
    scene.system.fingers.iter_mut().for_each(|finger| finger.contact = contacts);
    (scene.duration_s, scene.integrator) = (0.06, reference_settings());
    scene
}

fn samples_on_grid(samples: &[Sample], hz: f64) -> Vec<&Sample> {
    let is_on_grid = |sample: &&Sample| ((sample.time_s * hz).round() / hz - sample.time_s).abs() < 1e-13;
    samples.iter().filter(is_on_grid).collect()
}

/// The model of a gripper with bristles has 16 coordinates and its own Jacobian. On a fixed disc each of its fingers
/// moves like a single finger: with bristles on both phalanges, on one phalanx, and with soft bristles, which slip
/// more.
#[test]
fn each_finger_of_a_gripper_on_a_fixed_disc_matches_a_single_finger() {
    let all_sticking = load_with_stiction("experiment-95").finger().contact;
    let mut proximal_only = all_sticking;
    proximal_only.distal.friction.as_mut().expect("friction").bristle = None;
    let mut soft = all_sticking;
    for law in [&mut soft.proximal, &mut soft.distal] {
        let bristle = law.friction.as_mut().and_then(|law| law.bristle.as_mut()).expect("a bristle");
        (bristle.damping_n_s_per_m, bristle.relaxation_s) = (200.0, 2e-4);
    }
    for contacts in [all_sticking, proximal_only, soft] {
        let mut scene = load_with_stiction("experiment-95");
        (scene.finger_mut().contact, scene.duration_s, scene.integrator) = (contacts, 0.06, reference_settings());
        let (outcome, finger_log) = run_to_end(&scene);
        let mut gripper_log = CollectSink::default();
        trace::run_analytic(&gripper_scene(contacts), &mut gripper_log).expect("a run");
        let finger_samples = samples_on_grid(&finger_log.samples, 1e4);
        let gripper_samples = samples_on_grid(&gripper_log.samples, 1e4);
        assert_eq!((finger_samples.len(), gripper_samples.len()), (601, 601));
        let mut max_error = 0.0f64;
        for (expected, actual) in finger_samples.iter().zip(&gripper_samples) {
            let expected = expected.finger(0);
            for finger in &actual.fingers {
                let errors = [
                    finger.q11_rad - expected.q11_rad,
                    finger.q21_rad - expected.q21_rad,
                    finger.q22_rad - expected.q22_rad,
                ];
                max_error = errors.iter().fold(max_error, |max_error, error| max_error.max(error.abs()));
            }
        }
        assert!(max_error < 1e-8, "{max_error:.1e} rad");
        for (index, contact) in PHALANGES.into_iter().enumerate() {
            let expected = outcome.last.finger_contact(contact).tangential_n;
            let error = (expected - gripper_samples[600].contact(index).tangential_n).abs();
            assert!(error < 1e-6 && expected.abs() > 1e-3, "{contact:?}: error {error:.1e} N of {expected}");
        }
        if contacts == all_sticking {
            let difference = max_difference_from_regularised(&finger_samples);
            assert!(difference > 1e-6, "stiction has no effect: {difference:.1e} rad");
        }
    }
}

/// Largest difference of q11 from a run with regularised friction, rad.
fn max_difference_from_regularised(samples: &[&Sample]) -> f64 {
    let mut scene = load_with_stiction("experiment-95");
    for law in scene.finger_mut().contact.both_mut() {
        law.friction.as_mut().expect("friction").bristle = None;
    }
    (scene.duration_s, scene.integrator) = (0.06, reference_settings());
    let (_, regularised) = run_to_end(&scene);
    let regularised = samples_on_grid(&regularised.samples, 1e4);
    let error = |(a, b): (&&Sample, &&Sample)| (a.finger(0).q11_rad - b.finger(0).q11_rad).abs();
    samples.iter().zip(&regularised).map(error).fold(0.0, f64::max)
}

/// Integrates a finger up to `time_s`; returns its model, its state, and the mode with both phalanges in contact.
fn state_at(scene: &Scene, time_s: f64) -> (BristleModel, State<4, QUADRATURES>, FingerMode) {
    let settings = reference_settings();
    let tolerances =
        Tolerances { atol_q: settings.atol_angle_rad, atol_v: settings.atol_rate_rad_s, rtol_v: settings.rtol };
    let options = Options { tolerances, max_steps: settings.max_steps };
    let (model, start) = (BristleModel::new(&scene.system), BristleModel::start(&scene.system));
    let end = integrate::<4, QUADRATURES, EVENT_FUNCTIONS, _, RadauOrRodas<4, QUADRATURES>, _>(
        &model,
        &options,
        0.0,
        start,
        time_s,
        &mut (),
    );
    assert!(end.result.is_ok(), "{:?}", end.result);
    (model, end.state, [ContactState::Active, ContactState::Active, ContactState::Free].into())
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
        let (model, State { q, v, .. }, mode) = state_at(&scene, 0.2);
        for (index, contact) in PHALANGES.into_iter().enumerate() {
            let reading = model.contact_reading(q, v, contact, mode[contact as usize]).expect("a contact");
            let law =
                [scene.finger().contact.proximal, scene.finger().contact.distal][index].friction.expect("friction");
            let (bristle, bristle_state) = (law.bristle.expect("a bristle"), v[2 + index]);
            let force = bristle_force(&law, &bristle, reading.slip, bristle_state, reading.normal);
            let slider_rate = reading.slip - (force / bristle.damping_n_s_per_m - bristle_state);
            assert!(
                slider_rate.abs() < 1e-15 && reading.slip.abs() < 1e-12,
                "{name} {contact:?}: {slider_rate:.1e}, {:.1e} m/s",
                reading.slip
            );
            let friction_limit = law.mu_static * reading.normal;
            println!("{name} {contact:?}: {force} of {friction_limit} N");
            assert!(
                reading.normal > 1.0 && force.abs() < 0.999 * friction_limit,
                "{name} {contact:?}: {force} of {friction_limit} N"
            );
            assert!((reading.tangential + force).abs() < 1e-12 && force.abs() > 1e-3);
        }
    }
}

/// In addition to the invariants, which are checked at every sample: bristles store ½ k s², and the energy balance
/// closes.
#[test]
fn elastic_energy_includes_bristles() {
    let scene = Scene { integrator: reference_settings(), ..load_with_stiction("experiment-95") };
    let (outcome, _) = run_to_end(&scene);
    let (model, State { q, v, .. }, mode) = state_at(&scene, scene.duration_s);
    let stored: f64 = PHALANGES
        .into_iter()
        .enumerate()
        .map(|(index, contact)| {
            let law = [scene.finger().contact.proximal, scene.finger().contact.distal][index];
            let bristle = law.bristle().expect("a bristle");
            let stretch_m = bristle.relaxation_s * v[2 + index];
            let stiffness = bristle.damping_n_s_per_m / bristle.relaxation_s;
            let depth = model.contact_reading(q, v, contact, mode[contact as usize]).expect("a contact").delta;
            0.5 * stiffness * stretch_m * stretch_m + phalanx::law::elastic_energy(&law.normal, depth)
        })
        .sum();
    let energy = outcome.last.energy();
    assert!((energy.elastic_j - stored).abs() < 1e-6 * stored, "{} {stored}", energy.elastic_j);
    assert!(energy.balance_j.abs() < 1e-9 && energy.dissipated_j > 0.1, "{energy:?}");
}

#[test]
fn engineering_preset_is_close_to_the_reference() {
    for (name, bound) in [
        ("experiment-95", 1e-5),
        ("experiment-95-cad", 1e-5),
        ("long-fingers", 1e-5),
        ("torsional-spring", 1e-5),
        ("soft-start", 1e-5),
        ("hard/friction-2", 1e-5),
        ("hard/v-static-1e-3", 1e-5),
        ("hard/mass-links-light", 1e-5),
    ] {
        let scene = load_with_stiction(name);
        let (_, engineering_run) = run_to_end(&scene);
        let (_, reference_run) = crate::support::runs::run_dense_reference(&scene);
        let error = max_angle_error(&engineering_run, &reference_run);
        println!("{name}: {error:.1e}");
        assert!(error < bound, "{name}: {error:.1e} rad");
    }
}

/// Compares the Jacobian with central differences for sticking and slipping bristles, by all coordinates and rates.
#[test]
fn jacobian_matches_central_differences() {
    let scene = with_stiction(crate::support::runs::experiment_95());
    let (model, plain) = (BristleModel::new(&scene.system), Model::new(&crate::support::runs::experiment_95().system));
    let q = penetrating_posture(&plain, [0.036456, 1.134813], [2e-6; 2]);
    let rows =
        PHALANGES.map(|contact| plain.contact_reading(q, [0.0; 2], contact, ContactState::Active).expect("a contact"));
    let [a, b] = rates_with_row_values(rows.map(|row| row.geometry.normal_row), [-1e-3; 2]);
    let mode: FingerMode = [ContactState::Active, ContactState::Active, ContactState::Free].into();
    let slips = rows.map(|row| row.geometry.tangent_row[0] * a + row.geometry.tangent_row[1] * b);
    let mut slipping = 0;
    for slider_rates in [[1e-5, -2e-5], [1.0, 1e-5], [2e-5, -1.0], [1.0, 1.0]] {
        let bristle_states = [slider_rates[0] - slips[0], slider_rates[1] - slips[1]];
        let (q, v) = ([q[0], q[1], 0.3, -0.7], [a, b, bristle_states[0], bristle_states[1]]);
        let exact = model.linearise(1e-3, &q, &v, &mode);
        let outputs = |q: [f64; 4], v: [f64; 4]| -> [f64; 9] {
            let rates = model.rates(1e-3, &q, &v, &mode);
            std::array::from_fn(|i| if i < 4 { rates.a[i] } else { rates.g[i - 4] })
        };
        let row = |i: usize, by_q: bool| match (i < 4, by_q) {
            (true, true) => exact.a_q[i],
            (true, false) => exact.a_v[i],
            (false, true) => exact.g_q[i - 4],
            (false, false) => exact.g_v[i - 4],
        };
        for (by_q, h) in [(true, 1e-8), (false, 1e-6)] {
            for k in 0..4 {
                let shifted_outputs = |by: f64| {
                    let shift = |x: [f64; 4]| std::array::from_fn(|i| if i == k { x[i] + by } else { x[i] });
                    if by_q { outputs(shift(q), v) } else { outputs(q, shift(v)) }
                };
                let (up, down) = (shifted_outputs(h), shifted_outputs(-h));
                for i in 0..9 {
                    let difference_quotient = (up[i] - down[i]) / (2.0 * h);
                    let noise = 1e-9 * (up[i].abs() + 1.0) / h;
                    let size = row(i, by_q).into_iter().map(f64::abs).fold(0.0, f64::max);
                    let error = (row(i, by_q)[k] - difference_quotient).abs();
                    assert!(
                        error < 1e-5 * size + noise,
                        "{bristle_states:?}: {i} by {k}: {} {difference_quotient}",
                        row(i, by_q)[k]
                    );
                }
            }
        }
        slipping += PHALANGES
            .iter()
            .filter(|contact| exact.a_v[2 + **contact as usize][2 + **contact as usize] < -999.0)
            .count();
        // The coordinate that belongs to a bristle state has no effect.
        assert!((0..4).all(|i| exact.a_q[i][2] == 0.0 && exact.a_q[i][3] == 0.0));
    }
    assert_eq!(slipping, 4, "four of the eight bristles slip; slipping bristles relax at 1/ms");
}
