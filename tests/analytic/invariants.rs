//! Each invariant detects samples that violate it, and valid samples violate none.

use crate::support::laws::{THESIS_FRICTION, THESIS_NORMAL, disc, free_translation, with_half_plane};
use crate::support::reference_cases::reference_case;
use phalanx::invariants::{Finding, Invariant, Invariants};
use phalanx::law::ContactLaw;
use phalanx::scene::{DiscMotion, LogRates, Response, Scene, Stepping};
use phalanx::trace::{self, BodyState, ContactSample, Energy, Event, FingerContact, Model, Sample, Sink, SinkError};

const SPEED_M_S: f64 = 1.0;
const START: Energy = Energy {
    kinetic_j: 1e-3,
    gravity_j: 0.0,
    spring_j: 0.0,
    elastic_j: 0.0,
    dissipated_j: 0.0,
    motor_work_j: 0.0,
    balance_j: 0.0,
};

fn scene() -> Scene {
    let mut scene = crate::support::synthetic::scene();
    let law = ContactLaw { friction: Some(THESIS_FRICTION), ..scene.finger().contact.proximal };
    (scene.finger_mut().contact.proximal, scene.finger_mut().contact.distal) = (law, law);
    scene
}

/// Contact of a proximal phalanx that slides along the object faster than v_dynamic, so that μ is μ_d.
fn sliding_contact(impulse_n_s: f64) -> ContactSample {
    ContactSample {
        gap_m: -1e-6,
        slip_m_s: SPEED_M_S,
        normal_n: 10.0,
        tangential_n: -10.0 * THESIS_FRICTION.mu_dynamic,
        impulse_n_s,
        normal: [1.0, 0.0],
        ..ContactSample::default()
    }
}

/// Five samples that violate no invariant; friction gradually dissipates part of the energy.
fn valid_samples() -> Vec<Sample> {
    let at = |k: u32| {
        let loss_j = 1e-4 * f64::from(k);
        Sample {
            time_s: 1e-3 * f64::from(k),
            contacts: vec![
                sliding_contact(1e-2 * f64::from(k)),
                ContactSample { gap_m: 1e-3, ..ContactSample::default() },
                ContactSample { gap_m: 0.1, ..ContactSample::default() },
            ],
            energy: Energy { kinetic_j: START.kinetic_j - loss_j, dissipated_j: loss_j, ..START },
            ..Sample::with_one_finger()
        }
    };
    (0..5).map(at).collect()
}

fn violations(model: Model, scene: &Scene, samples: &[Sample], loop_gap_m: f64) -> Vec<Finding> {
    let mut invariants = Invariants::new(model, scene);
    for sample in samples {
        Sink::sample(&mut invariants, sample).expect("a sink that cannot fail");
    }
    assert_eq!(invariants.samples(), samples.len() as u64);
    let findings = invariants.findings(loop_gap_m);
    assert!(findings.iter().map(|finding| finding.invariant).eq(Invariant::ALL));
    findings.into_iter().filter(Finding::is_violated).collect()
}

/// Corrupts the sample at 3 ms and asserts that exactly the given invariant is violated there, in both models.
#[track_caller]
fn assert_violates(invariant: Invariant, contact: Option<&str>, corrupt: impl Fn(&mut Sample)) {
    let mut samples = valid_samples();
    corrupt(&mut samples[3]);
    for model in [Model::Analytic, Model::Engine] {
        let actual = violations(model, &scene(), &samples, 0.0);
        assert_eq!(actual.iter().map(|finding| finding.invariant).collect::<Vec<_>>(), [invariant], "{}", model.name());
        let finding = &actual[0];
        assert_eq!((finding.contact.as_deref(), finding.time_s), (contact, 3e-3), "{finding}");
        let line = finding.to_string();
        assert!(line.starts_with(invariant.name()) && line.contains("3.000000 ms"), "{line}");
    }
}

#[test]
fn valid_samples_violate_nothing() {
    for model in [Model::Analytic, Model::Engine] {
        assert_eq!(violations(model, &scene(), &valid_samples(), 0.0), []);
    }
}

#[test]
fn non_finite_numbers_are_violations() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_violates(Invariant::Finite, None, |sample| sample.finger_mut().qd22_rad_s = value);
        assert_violates(Invariant::Finite, None, |sample| sample.contact_mut(FingerContact::Proximal).normal_n = value);
        assert_violates(Invariant::Finite, None, |sample| {
            sample.contact_mut(FingerContact::Proximal).point_m[1] = value
        });
        assert_violates(Invariant::Finite, None, |sample| sample.contact_mut(FingerContact::Limit).normal_n = value);
        assert_violates(Invariant::Finite, None, |sample| sample.energy().spring_j = value);
    }
    // An infinite gap means that there is no other surface and is valid; NaN is not.
    assert_violates(Invariant::Finite, None, |sample| sample.contact_mut(FingerContact::Limit).gap_m = f64::NAN);
    let mut samples = valid_samples();
    samples.iter_mut().for_each(|sample| sample.contact(1..).fill(ContactSample::NONE));
    assert_eq!(violations(Model::Analytic, &scene(), &samples, 0.0), []);
}

#[test]
fn adhesion_and_forces_at_a_gap_are_violations() {
    assert_violates(Invariant::NoAdhesion, Some("proximal"), |sample| {
        let proximal = sample.contact_mut(FingerContact::Proximal);
        (proximal.normal_n, proximal.tangential_n) = (-1e-3, 0.0);
    });
    assert_violates(Invariant::NoAdhesion, Some("limit"), |sample| {
        sample.contact_mut(FingerContact::Limit).normal_n = -1e-6
    });
    assert_violates(Invariant::NoAdhesion, Some("distal"), |sample| {
        sample.contact_mut(FingerContact::Distal).normal_n = 1.0
    });
    assert_violates(Invariant::NoAdhesion, Some("limit"), |sample| {
        sample.contact_mut(FingerContact::Limit).normal_n = 1e-3
    });
}

#[test]
fn decreasing_impulse_is_a_violation() {
    let mut samples = valid_samples();
    samples[3].contact_mut(FingerContact::Proximal).impulse_n_s =
        0.5 * samples[2].finger_contact(FingerContact::Proximal).impulse_n_s;
    for model in [Model::Analytic, Model::Engine] {
        let actual = violations(model, &scene(), &samples, 0.0);
        assert!(
            matches!(&actual[..], [finding] if finding.invariant == Invariant::NoAdhesion && finding.time_s == 3e-3),
            "{actual:?}"
        );
    }
}

#[test]
fn energy_imbalance_is_a_violation() {
    for energy_j in [1e-4, -1e-4] {
        assert_violates(Invariant::Energy, None, |sample| sample.energy().balance_j = energy_j);
    }
}

#[test]
fn decreasing_dissipation_is_a_violation() {
    assert_violates(Invariant::Passivity, None, |sample| sample.energy().dissipated_j = 1e-4);
}

#[test]
fn friction_outside_its_law_is_a_violation() {
    let friction = |tangential_n: f64| {
        move |sample: &mut Sample| sample.contact_mut(FingerContact::Proximal).tangential_n = tangential_n
    };
    // In the direction of slip, too large, too small, and larger than the normal force.
    for ratio in [THESIS_FRICTION.mu_dynamic, -THESIS_FRICTION.mu_dynamic - 0.1, 0.1 - THESIS_FRICTION.mu_dynamic, -2.0]
    {
        assert_violates(Invariant::Friction, Some("proximal"), friction(10.0 * ratio));
    }
    assert_violates(Invariant::Friction, Some("distal"), |sample| {
        sample.contact_mut(FingerContact::Distal).tangential_n = 1e-6
    });
    // A frictionless contact has no tangential force.
    let frictionless = crate::support::synthetic::scene();
    let actual = violations(Model::Analytic, &frictionless, &valid_samples(), 0.0);
    assert!(matches!(&actual[..], [finding] if finding.invariant == Invariant::Friction), "{actual:?}");
}

/// If slip reverses within a step of the engine, any force between the limits of friction is valid.
#[test]
fn friction_of_the_engine_may_vary_within_a_step() {
    let samples_with_slip_reversal = |ratio: f64| {
        let mut samples = valid_samples();
        samples[3].contact_mut(FingerContact::Proximal).slip_m_s = -SPEED_M_S;
        samples[3].contact_mut(FingerContact::Proximal).tangential_n = 10.0 * ratio;
        samples[4].contact_mut(FingerContact::Proximal).slip_m_s = -SPEED_M_S;
        samples[4].contact_mut(FingerContact::Proximal).tangential_n = 10.0 * THESIS_FRICTION.mu_dynamic;
        samples
    };
    let violation_count = |model, ratio| violations(model, &scene(), &samples_with_slip_reversal(ratio), 0.0).len();
    for ratio in [0.0, 0.3, -0.3, THESIS_FRICTION.mu_static] {
        assert_eq!((violation_count(Model::Engine, ratio), violation_count(Model::Analytic, ratio)), (0, 1), "{ratio}");
    }
    assert_eq!(violation_count(Model::Engine, 1.01 * THESIS_FRICTION.mu_static), 1);
}

#[test]
fn penetration_beyond_the_available_energy_is_a_violation() {
    // 1 mJ is k δ^3.2 / 3.2: δ = 0.52 mm.
    assert_violates(Invariant::Penetration, Some("proximal"), |sample| {
        sample.contact_mut(FingerContact::Proximal).gap_m = -0.6e-3
    });
    let mut samples = valid_samples();
    samples[3].contact_mut(FingerContact::Proximal).gap_m = -0.5e-3;
    assert_eq!(violations(Model::Analytic, &scene(), &samples, 0.0), []);
}

#[test]
fn joint_limit_penetration_beyond_the_available_energy_is_a_violation() {
    let law = scene().finger().limit.expect("a limit");
    let e = law.exponent;
    let deepest = ((e + 1.0) * START.kinetic_j / law.stiffness_n_per_m_e).powf((e + 1.0).recip());
    assert_violates(Invariant::JointLimit, Some("limit"), |sample| {
        sample.contact_mut(FingerContact::Limit).gap_m = -1.1 * deepest
    });
    let mut samples = valid_samples();
    samples[3].contact_mut(FingerContact::Limit).gap_m = -0.9 * deepest;
    assert_eq!(violations(Model::Analytic, &scene(), &samples, 0.0), []);
}

#[test]
fn open_joints_are_violations() {
    let scene = scene();
    let allowed = scene.bounds.loop_gap_m;
    assert_eq!(violations(Model::Engine, &scene, &valid_samples(), allowed), []);
    for gap_m in [1.01 * allowed, f64::NAN] {
        let actual = violations(Model::Engine, &scene, &valid_samples(), gap_m);
        assert!(matches!(&actual[..], [finding] if finding.invariant == Invariant::LoopGap), "{actual:?}");
    }
}

/// After a long step the surfaces of an active contact may be separated by their travel within the step, and the
/// contact model of rapier has other laws.
#[test]
fn tolerances_depend_on_engine_settings() {
    let mut separated = valid_samples();
    let ContactSample { gap_m, gap_rate_m_s, .. } = separated[3].contact_mut(FingerContact::Proximal);
    (gap_m, gap_rate_m_s) = (0.9e-4, 1.0);
    let mut scene = scene();
    assert_eq!(violations(Model::Engine, &scene, &separated, 0.0).len(), 1);
    scene.engine.stepping = Stepping::Fixed { step_s: 1e-4 };
    assert_eq!(violations(Model::Engine, &scene, &separated, 0.0), []);
    separated[3].contact_mut(FingerContact::Proximal).gap_m = 2e-4;
    assert_eq!(violations(Model::Engine, &scene, &separated, 0.0).len(), 1);

    let mut rigid = valid_samples();
    let proximal = rigid[3].contact_mut(FingerContact::Proximal);
    (proximal.tangential_n, proximal.gap_m) = (8.0, -1e-3);
    scene.engine.response = Response::Rapier { friction: 0.8, restitution: 0.0 };
    assert_eq!(violations(Model::Engine, &scene, &rigid, 0.0), []);
    rigid[3].contact_mut(FingerContact::Proximal).normal_n = -1.0;
    assert_eq!(violations(Model::Engine, &scene, &rigid, 0.0).len(), 1);
}

#[test]
fn invariants_apply_to_discs() {
    let scene = with_half_plane(crate::support::laws::scene(
        vec![disc("puck", 0.1, [0.0, 0.1], free_translation([1.0, 0.0]))],
        THESIS_NORMAL,
        Some(THESIS_FRICTION),
        5e-3,
    ));
    let samples: Vec<Sample> = valid_samples()
        .iter()
        .map(|sample| Sample {
            time_s: sample.time_s,
            fingers: Vec::new(),
            bodies: vec![BodyState::default()],
            contacts: vec![sample.finger_contact(FingerContact::Proximal)],
            energy: sample.energy(),
        })
        .collect();
    let violations = |corrupt: fn(&mut Sample)| {
        let mut samples = samples.clone();
        corrupt(&mut samples[3]);
        let mut invariants = Invariants::new(Model::Analytic, &scene);
        for sample in &samples {
            Sink::sample(&mut invariants, sample).expect("a sink that cannot fail");
        }
        let violated: Vec<Finding> = invariants.findings(0.0).into_iter().filter(Finding::is_violated).collect();
        violated.into_iter().map(|finding| (finding.invariant, finding.contact)).collect::<Vec<_>>()
    };
    let pair = || Some("puck-plane".to_string());
    assert_eq!(violations(|_| ()), []);
    assert_eq!(violations(|sample| sample.body(0).spin_rad_s = f64::NAN), [(Invariant::Finite, None)]);
    assert_eq!(violations(|sample| sample.energy().balance_j = 1e-4), [(Invariant::Energy, None)]);
    assert_eq!(violations(|sample| sample.energy().dissipated_j = 1e-4), [(Invariant::Passivity, None)]);
    assert_eq!(violations(|sample| sample.contact(0).gap_m = 1e-9), [(Invariant::NoAdhesion, pair())]);
    assert_eq!(violations(|sample| sample.contact(0).tangential_n *= -1.0), [(Invariant::Friction, pair())]);
    assert_eq!(violations(|sample| sample.contact(0).gap_m = -1e-3), [(Invariant::Penetration, pair())]);
}

/// Momentum and angular momentum of a free object balance. The invariants detect a mass that is wrong by 1 %, an
/// inertia that is wrong by 5 %, and wrong gravity.
#[test]
fn momentum_balance_detects_wrong_mass_inertia_and_gravity() {
    let scene = reference_case("c").scene;
    let with_properties = |mass: f64, inertia: f64| {
        let mut other_scene = scene.clone();
        let DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), .. } =
            &mut other_scene.system.grasped_mut().motion
        else {
            panic!("the object is fixed")
        };
        *mass_kg *= mass;
        *inertia_kg_m2 *= inertia;
        other_scene
    };
    let [x, y] = scene.system.gravity_m_s2;
    let mut other_gravity = scene.clone();
    other_gravity.system.gravity_m_s2 = [x, 1.5 * y];
    let fine_scene = Scene { log: LogRates { numeric_hz: 1e6, ..scene.log }, ..scene.clone() };
    let invariants = [&scene, &with_properties(1.01, 1.0), &with_properties(1.0, 1.05), &other_gravity];
    let mut invariants = invariants.map(|scene| Invariants::new(Model::Analytic, scene));
    let outcome = trace::run(Model::Analytic, &fine_scene, &mut AllInvariants(&mut invariants)).unwrap();
    let violations = invariants.map(|invariants| {
        let findings = invariants.findings(outcome.loop_gap_m);
        let momentum_findings =
            [Invariant::Momentum, Invariant::AngularMomentum].map(|finding| findings[finding as usize].clone());
        println!("{} and {}", momentum_findings[0], momentum_findings[1]);
        momentum_findings.map(|finding| finding.is_violated())
    });
    assert_eq!(violations, [[false, false], [true, false], [false, true], [true, false]]);
}

/// Passes the samples of one run to several sets of invariants.
struct AllInvariants<'a>(&'a mut [Invariants]);

impl Sink for AllInvariants<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.iter_mut().try_for_each(|invariants| invariants.sample(sample))
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}
