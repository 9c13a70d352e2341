//! One finger whose friction holds: against a gripper on a disc that is held, which is other code; its Jacobian; what rests and what it stores.

use phalanx::analytic::{FingerMode, GUARDS, HoldingModel, Model, QUADRATURES, SiteState};
use phalanx::gripper::Site;
use phalanx::integrator::{Options, RadauOrRodas, State, System, Tolerances, integrate};
use phalanx::law::bristle_pull;
use phalanx::scene::{self, Contacts, Scene};
use phalanx::trace::{self, Sample};

use super::jacobian::{rates_with, touching};
use crate::support::runs::{Collect, complete, reference, worst_angle};
use crate::support::scenes::{hold, holding};

const PHALANGES: [Site; 2] = [Site::Proximal, Site::Distal];

fn gripper(contacts: Contacts) -> Scene {
    let mut scene = scene::load_any("scenes/gripper/fixed.toml").expect("a scene");
    scene.system.fingers.iter_mut().for_each(|finger| finger.contact = contacts);
    (scene.duration_s, scene.integrator) = (0.06, reference());
    scene
}

fn on_grid(samples: &[Sample], hz: f64) -> Vec<&Sample> {
    let whole = |sample: &&Sample| ((sample.time_s * hz).round() / hz - sample.time_s).abs() < 1e-13;
    samples.iter().filter(whole).collect()
}

/// A gripper has sixteen coordinates, rows and a Jacobian of its own: on a disc that does not move each of its fingers does what one does
/// by itself, with both bristles, with those of one phalanx, and with soft ones, which slip more.
#[test]
fn each_finger_of_a_gripper_on_a_fixed_disc_is_a_finger() {
    let both = holding("experiment-95").finger().contact;
    let mut one = both;
    one.distal.friction.as_mut().expect("friction").bristle = None;
    let mut soft = both;
    for law in [&mut soft.proximal, &mut soft.distal] {
        let bristle = law.friction.as_mut().and_then(|law| law.bristle.as_mut()).expect("a bristle");
        (bristle.damping_n_s_per_m, bristle.relaxation_s) = (200.0, 2e-4);
    }
    for contacts in [both, one, soft] {
        let mut alone = holding("experiment-95");
        (alone.finger_mut().contact, alone.duration_s, alone.integrator) = (contacts, 0.06, reference());
        let (outcome, path) = complete(&alone);
        let whole = gripper(contacts);
        let mut found = Collect::default();
        trace::run_analytic(&whole, &mut found).expect("a run");
        let (path, found) = (on_grid(&path.samples, 1e4), on_grid(&found.samples, 1e4));
        assert_eq!((path.len(), found.len()), (601, 601));
        let mut most = 0.0f64;
        for (alone, both) in path.iter().zip(&found) {
            for finger in &both.fingers {
                let own = alone.finger();
                let off = [finger.q11_rad - own.q11_rad, finger.q21_rad - own.q21_rad, finger.q22_rad - own.q22_rad];
                most = off.iter().fold(most, |most, off| most.max(off.abs()));
            }
        }
        assert!(most < 1e-8, "{most:.1e} rad");
        for (index, site) in PHALANGES.into_iter().enumerate() {
            let (own, whole) = (outcome.last.contact(site), &found[600].contacts[index]);
            let off = (own.tangential_n - whole.tangential_n).abs();
            assert!(off < 1e-6 && own.tangential_n.abs() > 1e-3, "{site:?}: {off:.1e} N of {}", own.tangential_n);
        }
        if contacts == both {
            let apart = apart_from_regularised(&path);
            assert!(apart > 1e-6, "the law makes a difference: {apart:.1e} rad");
        }
    }
}

/// How far a path is from that of the regularised law.
fn apart_from_regularised(path: &[&Sample]) -> f64 {
    let mut scene = holding("experiment-95");
    for law in scene.finger_mut().contact.both_mut() {
        law.friction.as_mut().expect("friction").bristle = None;
    }
    (scene.duration_s, scene.integrator) = (0.06, reference());
    let (_, usual) = complete(&scene);
    let usual = on_grid(&usual.samples, 1e4);
    let off = |(a, b): (&&Sample, &&Sample)| (a.finger().q11_rad - b.finger().q11_rad).abs();
    path.iter().zip(&usual).map(off).fold(0.0, f64::max)
}

/// The state of a finger after so long.
fn after(scene: &Scene, time_s: f64) -> (HoldingModel, State<4, QUADRATURES>, FingerMode) {
    let settings = reference();
    let tolerances =
        Tolerances { atol_q: settings.atol_angle_rad, atol_v: settings.atol_rate_rad_s, rtol_v: settings.rtol };
    let options = Options { tolerances, max_steps: settings.max_steps };
    let (model, start) = (HoldingModel::new(&scene.system), HoldingModel::start(&scene.system));
    let end = integrate::<4, QUADRATURES, GUARDS, _, RadauOrRodas<4, QUADRATURES>, _>(
        &model,
        &options,
        0.0,
        start,
        time_s,
        &mut (),
    );
    assert!(end.result.is_ok(), "{:?}", end.result);
    (model, end.state, [SiteState::Active, SiteState::Active, SiteState::Free].into())
}

/// With T = c (σ + v) the slider's speed is v − ṡ = 0. Phalanges of steel creep for a minute, and slip as they do; those that stand on a spring
/// of 1e10 N/m are at rest in a millisecond, and stay where they are.
#[test]
fn sliders_of_contacts_that_stick_are_at_rest() {
    for name in ["experiment-95", "experiment-95-cad", "long-fingers", "torsional-spring"] {
        let mut scene = holding(name);
        for law in scene.finger_mut().contact.both_mut() {
            (law.normal.stiffness_n_per_m_e, law.normal.exponent) = (1e10, 1.0);
        }
        let (model, State { q, v, .. }, mode) = after(&scene, 0.2);
        for (index, site) in PHALANGES.into_iter().enumerate() {
            let at = model.reading(q, v, site, mode[site as usize]).expect("a contact");
            let law =
                [scene.finger().contact.proximal, scene.finger().contact.distal][index].friction.expect("friction");
            let (bristle, memory) = (law.bristle.expect("a bristle"), v[2 + index]);
            let pull = bristle_pull(&law, &bristle, at.slip, memory, at.normal);
            let slider = at.slip - (pull / bristle.damping_n_s_per_m - memory);
            assert!(
                slider.abs() < 1e-15 && at.slip.abs() < 1e-12,
                "{name} {site:?}: {slider:.1e}, {:.1e} m/s",
                at.slip
            );
            let cone = law.mu_static * at.normal;
            println!("{name} {site:?}: {pull} of {cone} N");
            assert!(at.normal > 1.0 && pull.abs() < 0.999 * cone, "{name} {site:?}: {pull} of {cone} N");
            assert!((at.tangential + pull).abs() < 1e-12 && pull.abs() > 1e-3);
        }
    }
}

/// Beside what the invariants ask at every sample: bristles store ½ k s², and what is stored and lost is what the motor gave.
#[test]
fn energies_count_what_bristles_store() {
    let scene = Scene { integrator: reference(), ..holding("experiment-95") };
    let (outcome, _) = complete(&scene);
    let (model, State { q, v, .. }, mode) = after(&scene, scene.duration_s);
    let stored: f64 = PHALANGES
        .into_iter()
        .enumerate()
        .map(|(index, site)| {
            let law = [scene.finger().contact.proximal, scene.finger().contact.distal][index];
            let bristle = law.bristle().expect("a bristle");
            let stretch_m = bristle.relaxation_s * v[2 + index];
            let stiffness = bristle.damping_n_s_per_m / bristle.relaxation_s;
            let depth = model.reading(q, v, site, mode[site as usize]).expect("a contact").delta;
            0.5 * stiffness * stretch_m * stretch_m + phalanx::law::elastic_energy(&law.normal, depth)
        })
        .sum();
    let energy = outcome.last.energy;
    assert!((energy.elastic_j - stored).abs() < 1e-6 * stored, "{} {stored}", energy.elastic_j);
    assert!(energy.balance_j.abs() < 1e-9 && energy.dissipated_j > 0.1, "{energy:?}");
}

#[test]
fn the_everyday_preset_is_near_the_reference() {
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
        let scene = holding(name);
        let (_, usual) = complete(&scene);
        let (_, exact) = crate::support::runs::dense_reference(&scene);
        let off = worst_angle(&usual, &exact);
        println!("{name}: {off:.1e}");
        assert!(off < bound, "{name}: {off:.1e} rad");
    }
}

/// Exact derivatives against central differences, where bristles hold and where they slip, by both angles and all four rates.
#[test]
fn the_jacobian_is_that_of_the_rates() {
    let scene = hold(crate::support::runs::anchor());
    let (model, plain) = (HoldingModel::new(&scene.system), Model::new(&crate::support::runs::anchor().system));
    let q = touching(&plain, [0.036456, 1.134813], [2e-6; 2]);
    let rows = PHALANGES.map(|site| plain.reading(q, [0.0; 2], site, SiteState::Active).expect("a contact"));
    let [a, b] = rates_with(rows.map(|row| row.geometry.normal_row), [-1e-3; 2]);
    let mode: FingerMode = [SiteState::Active, SiteState::Active, SiteState::Free].into();
    let slips = rows.map(|row| row.geometry.tangent_row[0] * a + row.geometry.tangent_row[1] * b);
    let mut clamped = 0;
    for beyond in [[1e-5, -2e-5], [1.0, 1e-5], [2e-5, -1.0], [1.0, 1.0]] {
        let memories = [beyond[0] - slips[0], beyond[1] - slips[1]];
        let (q, v) = ([q[0], q[1], 0.3, -0.7], [a, b, memories[0], memories[1]]);
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
                let moved = |by: f64| {
                    let shifted = |x: [f64; 4]| std::array::from_fn(|i| if i == k { x[i] + by } else { x[i] });
                    if by_q { outputs(shifted(q), v) } else { outputs(q, shifted(v)) }
                };
                let (up, down) = (moved(h), moved(-h));
                for i in 0..9 {
                    let found = (up[i] - down[i]) / (2.0 * h);
                    let noise = 1e-9 * (up[i].abs() + 1.0) / h;
                    let size = row(i, by_q).into_iter().map(f64::abs).fold(0.0, f64::max);
                    let off = (row(i, by_q)[k] - found).abs();
                    assert!(off < 1e-5 * size + noise, "{memories:?}: {i} by {k}: {} {found}", row(i, by_q)[k]);
                }
            }
        }
        clamped += PHALANGES.iter().filter(|site| exact.a_v[2 + **site as usize][2 + **site as usize] < -999.0).count();
        // A coordinate of a memory moves nothing.
        assert!((0..4).all(|i| exact.a_q[i][2] == 0.0 && exact.a_q[i][3] == 0.0));
    }
    assert_eq!(clamped, 4, "of eight bristles four slip: they relax at 1/ms whatever they are");
}
