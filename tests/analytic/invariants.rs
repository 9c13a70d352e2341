//! Each invariant detects samples that violate it, and valid samples violate none.

use FingerContact::{Distal, Limit, Proximal};

use crate::support::laws::{self, BOTH_MODELS, THESIS_FRICTION, THESIS_NORMAL, disc, free_translation};
use crate::support::reference_cases::reference_case;
use crate::support::synthetic;
use phalanx::invariants::{EnergyAudit, Finding, Invariant, Invariants};
use phalanx::law::ContactLaw;
use phalanx::scene::{LogSettings, ObjectMotion, Response, Scene, Stepping, parse_any};
use phalanx::trace::{
    self, BodyState, ContactSample, Energy, FingerContact, FingerState, Model, Sample, Sink, SinkError,
};

const SPEED_M_S: f64 = 1.0;
const START: Energy = Energy {
    kinetic_j: 1e-3,
    gravity_j: 0.0,
    spring_j: 0.0,
    elastic_j: 0.0,
    dissipated_j: 0.0,
    motor_work_j: 0.0,
    balance_j: 0.0,
    cable_friction_j: 0.0,
};

fn scene() -> Scene {
    let mut scene = synthetic::scene();
    let law = ContactLaw { friction: Some(THESIS_FRICTION), ..scene.finger().contact.proximal };
    (scene.finger_mut().contact.proximal, scene.finger_mut().contact.distal) = (law, law);
    scene
}

/// Five samples that violate no invariant. The proximal phalanx slides along the object faster than v_dynamic, so that μ
/// is μ_d, and friction gradually dissipates part of the energy.
fn valid_samples() -> Vec<Sample> {
    let at = |k: u32| {
        let loss_j = 1e-4 * f64::from(k);
        let sliding_contact = ContactSample {
            gap_m: -1e-6,
            slip_m_s: SPEED_M_S,
            normal_n: 10.0,
            tangential_n: -10.0 * THESIS_FRICTION.mu_dynamic,
            impulse_n_s: 1e-2 * f64::from(k),
            normal: [1.0, 0.0],
            ..ContactSample::default()
        };
        let separated = |gap_m| ContactSample { gap_m, ..ContactSample::default() };
        let contacts = [sliding_contact, separated(1e-3), separated(0.1)];
        let mut sample = Sample::of(1e-3 * f64::from(k), &[FingerState::default()], &[], &contacts);
        sample.set_energy(&Energy { kinetic_j: START.kinetic_j - loss_j, dissipated_j: loss_j, ..START });
        sample
    };
    (0..5).map(at).collect()
}

type Change<T> = fn(&mut T);

/// Changes a contact of a sample.
fn change_contact(sample: &mut Sample, contact: FingerContact, change: impl FnOnce(&mut ContactSample)) {
    let mut changed = sample.contact(contact as usize);
    change(&mut changed);
    sample.set_contact(contact as usize, &changed);
}

/// Changes the energies of a sample.
fn change_energy(sample: &mut Sample, change: impl FnOnce(&mut Energy)) {
    let mut changed = sample.energy();
    change(&mut changed);
    sample.set_energy(&changed);
}

/// The valid samples with a change of the one at 3 ms.
fn changed(change: impl FnOnce(&mut Sample)) -> Vec<Sample> {
    let mut samples = valid_samples();
    change(&mut samples[3]);
    samples
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

/// Asserts that exactly the given invariant is violated at 3 ms, in both models.
#[track_caller]
fn assert_violates(invariant: Invariant, contact: Option<&str>, change: impl FnOnce(&mut Sample)) {
    let samples = changed(change);
    for model in BOTH_MODELS {
        let actual = violations(model, &scene(), &samples, 0.0);
        assert_eq!(actual.iter().map(|finding| finding.invariant).collect::<Vec<_>>(), [invariant], "{}", model.name());
        let finding = &actual[0];
        assert_eq!((finding.contact.as_deref(), finding.time_s), (contact, 3e-3), "{finding}");
        let line = finding.to_string();
        assert!(line.starts_with(invariant.name()) && line.contains("3.000000 ms"), "{line}");
    }
}

/// Asserts that the samples violate nothing in the analytic model.
#[track_caller]
fn assert_valid(samples: &[Sample]) {
    assert_eq!(violations(Model::Analytic, &scene(), samples, 0.0), []);
}

#[test]
fn valid_samples_violate_nothing() {
    assert_valid(&valid_samples());
    assert_eq!(violations(Model::Engine, &scene(), &valid_samples(), 0.0), []);
}

#[test]
fn non_finite_numbers_are_violations() {
    let changes: [fn(&mut Sample, f64); 5] = [
        |sample, value| sample.set_finger(0, &FingerState { qd22_rad_s: value, ..sample.finger(0) }),
        |sample, value| change_contact(sample, Proximal, |contact| contact.normal_n = value),
        |sample, value| change_contact(sample, Proximal, |contact| contact.point_m[1] = value),
        |sample, value| change_contact(sample, Limit, |contact| contact.normal_n = value),
        |sample, value| change_energy(sample, |energy| energy.spring_j = value),
    ];
    for change in changes {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_violates(Invariant::Finite, None, |sample| change(sample, value));
        }
    }
    // An infinite gap means that there is no other surface and is valid; NaN is not.
    assert_violates(Invariant::Finite, None, |sample| {
        change_contact(sample, Limit, |contact| contact.gap_m = f64::NAN)
    });
    let mut samples = valid_samples();
    for sample in &mut samples {
        (1..3).for_each(|index| sample.set_contact(index, &ContactSample::NONE));
    }
    assert_valid(&samples);
}

/// Adhesion, forces at a gap, friction in the direction of slip, friction that is too large, too small or larger than the
/// normal force, friction without a force, and penetration beyond the available energy: 1 mJ is k δ^3.2 / 3.2 at δ =
/// 0.52 mm.
#[test]
fn forces_outside_their_laws_are_violations() {
    let changes: [(Invariant, FingerContact, Change<ContactSample>); 10] = [
        (Invariant::NoAdhesion, Proximal, |c| (c.normal_n, c.tangential_n) = (-1e-3, 0.0)),
        (Invariant::NoAdhesion, Limit, |c| c.normal_n = -1e-6),
        (Invariant::NoAdhesion, Distal, |c| c.normal_n = 1.0),
        (Invariant::NoAdhesion, Limit, |c| c.normal_n = 1e-3),
        (Invariant::Friction, Proximal, |c| c.tangential_n = 10.0 * THESIS_FRICTION.mu_dynamic),
        (Invariant::Friction, Proximal, |c| c.tangential_n = -10.0 * (THESIS_FRICTION.mu_dynamic + 0.1)),
        (Invariant::Friction, Proximal, |c| c.tangential_n = -10.0 * (THESIS_FRICTION.mu_dynamic - 0.1)),
        (Invariant::Friction, Proximal, |c| c.tangential_n = -20.0),
        (Invariant::Friction, Distal, |c| c.tangential_n = 1e-6),
        (Invariant::Penetration, Proximal, |c| c.gap_m = -0.6e-3),
    ];
    for (invariant, contact, change) in changes {
        assert_violates(invariant, Some(contact.name()), |sample| change_contact(sample, contact, change));
    }
    assert_valid(&changed(|sample| change_contact(sample, Proximal, |contact| contact.gap_m = -0.5e-3)));
    // A frictionless contact has no tangential force.
    let actual = violations(Model::Analytic, &synthetic::scene(), &valid_samples(), 0.0);
    assert!(matches!(&actual[..], [finding] if finding.invariant == Invariant::Friction), "{actual:?}");
}

#[test]
fn decreasing_impulse_is_a_violation() {
    let half_n_s = 0.5 * valid_samples()[2].finger_contact(Proximal).impulse_n_s;
    let samples = changed(|sample| change_contact(sample, Proximal, |contact| contact.impulse_n_s = half_n_s));
    for model in BOTH_MODELS {
        let actual = violations(model, &scene(), &samples, 0.0);
        assert!(
            matches!(&actual[..], [finding] if finding.invariant == Invariant::NoAdhesion && finding.time_s == 3e-3),
            "{actual:?}"
        );
    }
}

#[test]
fn energy_imbalance_and_decreasing_dissipation_are_violations() {
    for energy_j in [1e-4, -1e-4] {
        assert_violates(Invariant::Energy, None, |sample| change_energy(sample, |energy| energy.balance_j = energy_j));
    }
    assert_violates(Invariant::Passivity, None, |sample| change_energy(sample, |energy| energy.dissipated_j = 1e-4));
}

/// If slip reverses within a step of the engine, any force between the limits of friction is valid.
#[test]
fn friction_of_the_engine_may_vary_within_a_step() {
    let violation_count = |model, ratio: f64| {
        let mut samples = valid_samples();
        for (index, ratio) in [(3, ratio), (4, THESIS_FRICTION.mu_dynamic)] {
            change_contact(&mut samples[index], Proximal, |contact| {
                (contact.slip_m_s, contact.tangential_n) = (-SPEED_M_S, 10.0 * ratio);
            });
        }
        violations(model, &scene(), &samples, 0.0).len()
    };
    for ratio in [0.0, 0.3, -0.3, THESIS_FRICTION.mu_static] {
        assert_eq!((violation_count(Model::Engine, ratio), violation_count(Model::Analytic, ratio)), (0, 1), "{ratio}");
    }
    assert_eq!(violation_count(Model::Engine, 1.01 * THESIS_FRICTION.mu_static), 1);
}

#[test]
fn joint_limit_penetration_beyond_the_available_energy_is_a_violation() {
    let law = scene().finger().limit.expect("a limit");
    let e = law.exponent;
    let deepest = ((e + 1.0) * START.kinetic_j / law.stiffness_n_per_m_e).powf((e + 1.0).recip());
    assert_violates(Invariant::JointLimit, Some("limit"), |sample| {
        change_contact(sample, Limit, |contact| contact.gap_m = -1.1 * deepest)
    });
    assert_valid(&changed(|sample| change_contact(sample, Limit, |contact| contact.gap_m = -0.9 * deepest)));
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
    let mut scene = scene();
    let count = |scene: &Scene, change: Change<ContactSample>| {
        violations(Model::Engine, scene, &changed(|sample| change_contact(sample, Proximal, change)), 0.0).len()
    };
    let separated: Change<ContactSample> = |c| (c.gap_m, c.gap_rate_m_s) = (0.9e-4, 1.0);
    assert_eq!(count(&scene, separated), 1);
    scene.engine.stepping = Stepping::Fixed { step_s: 1e-4 };
    assert_eq!(count(&scene, separated), 0);
    assert_eq!(count(&scene, |c| (c.gap_m, c.gap_rate_m_s) = (2e-4, 1.0)), 1);

    scene.engine.response = Response::Rapier { friction: 0.8, restitution: 0.0 };
    assert_eq!(count(&scene, |c| (c.tangential_n, c.gap_m) = (8.0, -1e-3)), 0);
    assert_eq!(count(&scene, |c| (c.tangential_n, c.gap_m, c.normal_n) = (8.0, -1e-3, -1.0)), 1);
}

#[test]
fn invariants_apply_to_discs() {
    let discs = vec![disc("puck", 0.1, [0.0, 0.1], free_translation([1.0, 0.0]))];
    let scene = laws::scene_on_plane(discs, THESIS_NORMAL, Some(THESIS_FRICTION), 5e-3);
    let changes: [(Change<Sample>, &[Invariant], Option<&str>); 7] = [
        (|_| {}, &[], None),
        (
            |sample| sample.set_body(0, &BodyState { spin_rad_s: f64::NAN, ..BodyState::default() }),
            &[Invariant::Finite],
            None,
        ),
        (|sample| change_energy(sample, |energy| energy.balance_j = 1e-4), &[Invariant::Energy], None),
        (|sample| change_energy(sample, |energy| energy.dissipated_j = 1e-4), &[Invariant::Passivity], None),
        (
            |sample| change_contact(sample, Proximal, |contact| contact.gap_m = 1e-9),
            &[Invariant::NoAdhesion],
            Some("puck-plane"),
        ),
        (
            |sample| change_contact(sample, Proximal, |contact| contact.tangential_n *= -1.0),
            &[Invariant::Friction],
            Some("puck-plane"),
        ),
        (
            |sample| change_contact(sample, Proximal, |contact| contact.gap_m = -1e-3),
            &[Invariant::Penetration],
            Some("puck-plane"),
        ),
    ];
    for (change, expected, contact) in changes {
        let mut samples = valid_samples();
        for sample in &mut samples {
            let energy = sample.energy();
            *sample = Sample::of(sample.time_s, &[], &[BodyState::default()], &[sample.contact(0)]);
            sample.set_energy(&energy);
        }
        change(&mut samples[3]);
        let actual = violations(Model::Analytic, &scene, &samples, 0.0);
        assert!(actual.iter().map(|finding| &finding.invariant).eq(expected), "{actual:?}");
        assert!(actual.iter().all(|finding| finding.contact.as_deref() == contact), "{actual:?}");
    }
}

/// Momentum and angular momentum of a free object balance. The invariants detect a mass that is wrong by 1 %, an
/// inertia that is wrong by 5 %, and wrong gravity.
#[test]
fn momentum_balance_detects_wrong_mass_inertia_and_gravity() {
    let scene = reference_case("c").scene;
    let with_factors = |mass: f64, inertia: f64, gravity: f64| {
        let mut scene = scene.clone();
        let ObjectMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut scene.hand.grasped_mut().motion else {
            panic!("the object is fixed")
        };
        (*mass_kg, *inertia_kg_m2) = (*mass_kg * mass, *inertia_kg_m2 * inertia);
        scene.hand.gravity_m_s2[1] *= gravity;
        Invariants::new(Model::Analytic, &scene)
    };
    let mut invariants = AllInvariants(vec![
        with_factors(1.0, 1.0, 1.0),
        with_factors(1.01, 1.0, 1.0),
        with_factors(1.0, 1.05, 1.0),
        with_factors(1.0, 1.0, 1.5),
    ]);
    let fine_scene = Scene { log: LogSettings { numeric_hz: 1e6, ..scene.log }, ..scene.clone() };
    let outcome = trace::run(Model::Analytic, &fine_scene, &mut invariants).unwrap();
    let violations = invariants.0.into_iter().map(|invariants| {
        let findings = invariants.findings(outcome.loop_gap_m);
        [Invariant::Momentum, Invariant::AngularMomentum].map(|invariant| findings[invariant as usize].is_violated())
    });
    assert!(violations.eq([[false, false], [true, false], [false, true], [true, false]]));
}

/// Passes the samples of one run to several sets of invariants.
struct AllInvariants(Vec<Invariants>);

impl Sink for AllInvariants {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.iter_mut().try_for_each(|invariants| invariants.sample(sample))
    }
}

/// A body at rest that touches a plane exchanges only rounding errors of its position: no energy is created.
#[test]
fn rounding_errors_of_a_body_at_rest_are_no_energy() {
    let scene = parse_any(
        "kind = \"mechanism\"\nduration = \"50 ms\"\ngravity = [\"0 m/s^2\", \"0 m/s^2\"]\n[bodies.block]\nmass = \"50 g\"\n\
         inertia = \"2e-5 kg*m^2\"\nstart = { at = [\"0 mm\", \"10 mm\"] }\n[bodies.block.outlines.skin]\ntype = \"box\"\n\
         size = [\"20 mm\", \"20 mm\"]\nrounding = \"1 mm\"\n[ground.outlines.floor]\ntype = \"half_plane\"\nnormal = [0, 1]\n\
         [laws.hard]\nstiffness = 1e6\n[[contacts]]\nbetween = [\"block.skin\", \"ground.floor\"]\nlaw = \"hard\"\n",
        "block.toml",
    )
    .expect("a scene");
    for model in [Model::Analytic, Model::Engine] {
        let mut audit = EnergyAudit::new(model, &scene);
        let outcome = trace::run(model, &scene, &mut audit).expect("a run");
        // The engine finds a touch only at the end of a step.
        let touches = outcome.contacts.iter().any(|contact| contact.first_s == Some(0.0));
        assert!(touches || model == Model::Engine, "no touch");
        assert_eq!(audit.violation(), None, "{model:?}");
    }
}
