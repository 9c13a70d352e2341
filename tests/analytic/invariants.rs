//! The invariants can be broken: doctored samples are each reported as what they break, and clean ones are not.

use crate::support::grippers::anchor;
use crate::support::laws::{FRICTION, THESIS, disc, on_plane, sliding};
use phalanx::invariants::{Finding, Invariant, Invariants};
use phalanx::law::ContactLaw;
use phalanx::scene::{DiscMotion, LogRates, Response, Scene, Stepping};
use phalanx::trace::{self, BodyState, ContactSample, Energy, Event, Model, Sample, Sink, SinkError, Site};

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
    let law = ContactLaw { friction: Some(FRICTION), ..scene.finger().contact.proximal };
    (scene.finger_mut().contact.proximal, scene.finger_mut().contact.distal) = (law, law);
    scene
}

/// A proximal phalanx that slides along the object beyond v_dynamic: μ is the dynamic one.
fn pressed(impulse_n_s: f64) -> ContactSample {
    ContactSample {
        gap_m: -1e-6,
        slip_m_s: SPEED_M_S,
        normal_n: 10.0,
        tangential_n: -10.0 * FRICTION.mu_dynamic,
        impulse_n_s,
        normal: [1.0, 0.0],
        ..ContactSample::default()
    }
}

/// A run of five samples in which nothing is wrong: half of the energy is lost to friction by and by.
fn clean() -> Vec<Sample> {
    let at = |k: u32| {
        let lost_j = 1e-4 * f64::from(k);
        Sample {
            time_s: 1e-3 * f64::from(k),
            contacts: vec![
                pressed(1e-2 * f64::from(k)),
                ContactSample { gap_m: 1e-3, ..ContactSample::default() },
                ContactSample { gap_m: 0.1, ..ContactSample::default() },
            ],
            energy: Energy { kinetic_j: START.kinetic_j - lost_j, dissipated_j: lost_j, ..START },
            ..Sample::of_finger()
        }
    };
    (0..5).map(at).collect()
}

fn broken(model: Model, scene: &Scene, samples: &[Sample], loop_gap_m: f64) -> Vec<Finding> {
    let mut invariants = Invariants::new(model, scene);
    for sample in samples {
        Sink::sample(&mut invariants, sample).expect("measuring writes nothing");
    }
    assert_eq!(invariants.samples(), samples.len() as u64);
    let findings = invariants.findings(loop_gap_m);
    assert!(findings.iter().map(|one| one.invariant).eq(Invariant::ALL));
    findings.into_iter().filter(Finding::is_broken).collect()
}

/// Doctors the third sample; exactly the named invariant breaks, in both models, there and then.
#[track_caller]
fn breaks(invariant: Invariant, place: Option<&str>, doctor: impl Fn(&mut Sample)) {
    let mut samples = clean();
    doctor(&mut samples[3]);
    for model in [Model::Analytic, Model::Engine] {
        let found = broken(model, &scene(), &samples, 0.0);
        assert_eq!(found.iter().map(|one| one.invariant).collect::<Vec<_>>(), [invariant], "{}", model.name());
        let finding = &found[0];
        assert_eq!((finding.place.as_deref(), finding.time_s), (place, 3e-3), "{finding}");
        let line = finding.to_string();
        assert!(line.starts_with(invariant.name()) && line.contains("3.000000 ms"), "{line}");
    }
}

#[test]
fn a_clean_run_breaks_nothing() {
    for model in [Model::Analytic, Model::Engine] {
        assert_eq!(broken(model, &scene(), &clean(), 0.0), []);
    }
}

#[test]
fn numbers_that_are_none() {
    for strange in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        breaks(Invariant::Finite, None, |sample| sample.finger_mut().qd22_rad_s = strange);
        breaks(Invariant::Finite, None, |sample| sample.contact_mut(Site::Proximal).normal_n = strange);
        breaks(Invariant::Finite, None, |sample| sample.contact_mut(Site::Proximal).point_m[1] = strange);
        breaks(Invariant::Finite, None, |sample| sample.contact_mut(Site::Limit).normal_n = strange);
        breaks(Invariant::Finite, None, |sample| sample.energy.spring_j = strange);
    }
    // A gap to nothing is infinite and breaks nothing, one that is no number does.
    breaks(Invariant::Finite, None, |sample| sample.contact_mut(Site::Limit).gap_m = f64::NAN);
    let mut samples = clean();
    samples.iter_mut().for_each(|sample| sample.contacts[1..].fill(ContactSample::NONE));
    assert_eq!(broken(Model::Analytic, &scene(), &samples, 0.0), []);
}

#[test]
fn contacts_that_pull_or_push_from_afar() {
    breaks(Invariant::NoAdhesion, Some("proximal"), |sample| {
        let proximal = sample.contact_mut(Site::Proximal);
        (proximal.normal_n, proximal.tangential_n) = (-1e-3, 0.0);
    });
    breaks(Invariant::NoAdhesion, Some("limit"), |sample| sample.contact_mut(Site::Limit).normal_n = -1e-6);
    breaks(Invariant::NoAdhesion, Some("distal"), |sample| sample.contact_mut(Site::Distal).normal_n = 1.0);
    breaks(Invariant::NoAdhesion, Some("limit"), |sample| sample.contact_mut(Site::Limit).normal_n = 1e-3);
}

#[test]
fn an_impulse_that_falls() {
    let mut samples = clean();
    samples[3].contact_mut(Site::Proximal).impulse_n_s = 0.5 * samples[2].contact(Site::Proximal).impulse_n_s;
    for model in [Model::Analytic, Model::Engine] {
        let found = broken(model, &scene(), &samples, 0.0);
        assert!(
            matches!(&found[..], [one] if one.invariant == Invariant::NoAdhesion && one.time_s == 3e-3),
            "{found:?}"
        );
    }
}

#[test]
fn energy_from_nowhere() {
    for energy_j in [1e-4, -1e-4] {
        breaks(Invariant::Energy, None, |sample| sample.energy.balance_j = energy_j);
    }
}

#[test]
fn losses_that_are_given_back() {
    breaks(Invariant::Passivity, None, |sample| sample.energy.dissipated_j = 1e-4);
}

#[test]
fn friction_that_has_no_law() {
    let friction =
        |tangential_n: f64| move |sample: &mut Sample| sample.contact_mut(Site::Proximal).tangential_n = tangential_n;
    // With the slip, too large, too small, and without a normal force.
    for ratio in [FRICTION.mu_dynamic, -FRICTION.mu_dynamic - 0.1, 0.1 - FRICTION.mu_dynamic, -2.0] {
        breaks(Invariant::Friction, Some("proximal"), friction(10.0 * ratio));
    }
    breaks(Invariant::Friction, Some("distal"), |sample| sample.contact_mut(Site::Distal).tangential_n = 1e-6);
    // Where there is no friction there is no force.
    let smooth = crate::support::synthetic::scene();
    let found = broken(Model::Analytic, &smooth, &clean(), 0.0);
    assert!(matches!(&found[..], [one] if one.invariant == Invariant::Friction), "{found:?}");
}

/// A slip that turns round in a step of the engine takes every value in between; what its force cannot be is outside.
#[test]
fn friction_of_the_engine_belongs_to_a_step() {
    let turning = |ratio: f64| {
        let mut samples = clean();
        samples[3].contact_mut(Site::Proximal).slip_m_s = -SPEED_M_S;
        samples[3].contact_mut(Site::Proximal).tangential_n = 10.0 * ratio;
        samples[4].contact_mut(Site::Proximal).slip_m_s = -SPEED_M_S;
        samples[4].contact_mut(Site::Proximal).tangential_n = 10.0 * FRICTION.mu_dynamic;
        samples
    };
    let judged = |model, ratio| broken(model, &scene(), &turning(ratio), 0.0).len();
    for ratio in [0.0, 0.3, -0.3, FRICTION.mu_static] {
        assert_eq!((judged(Model::Engine, ratio), judged(Model::Analytic, ratio)), (0, 1), "{ratio}");
    }
    assert_eq!(judged(Model::Engine, 1.01 * FRICTION.mu_static), 1);
}

#[test]
fn surfaces_deeper_in_than_their_energy_allows() {
    // 1 mJ is k δ^3.2 / 3.2: δ = 0.52 mm.
    breaks(Invariant::Penetration, Some("proximal"), |sample| sample.contact_mut(Site::Proximal).gap_m = -0.6e-3);
    let mut samples = clean();
    samples[3].contact_mut(Site::Proximal).gap_m = -0.5e-3;
    assert_eq!(broken(Model::Analytic, &scene(), &samples, 0.0), []);
}

#[test]
fn a_joint_past_its_limit() {
    let law = scene().finger().limit.expect("a limit");
    let e = law.exponent;
    let deepest = ((e + 1.0) * START.kinetic_j / law.stiffness_n_per_m_e).powf((e + 1.0).recip());
    breaks(Invariant::JointLimit, Some("limit"), |sample| sample.contact_mut(Site::Limit).gap_m = -1.1 * deepest);
    let mut samples = clean();
    samples[3].contact_mut(Site::Limit).gap_m = -0.9 * deepest;
    assert_eq!(broken(Model::Analytic, &scene(), &samples, 0.0), []);
}

#[test]
fn joints_that_open() {
    let scene = scene();
    let allowed = scene.bounds.loop_gap_m;
    assert_eq!(broken(Model::Engine, &scene, &clean(), allowed), []);
    for gap_m in [1.01 * allowed, f64::NAN] {
        let found = broken(Model::Engine, &scene, &clean(), gap_m);
        assert!(matches!(&found[..], [one] if one.invariant == Invariant::LoopGap), "{found:?}");
    }
}

/// A long step may end with its surfaces parted by what they travel in it, and rapier's own contact has its own laws.
#[test]
fn settings_of_the_engine_say_what_is_allowed() {
    let mut parted = clean();
    let ContactSample { gap_m, gap_rate_m_s, .. } = parted[3].contact_mut(Site::Proximal);
    (*gap_m, *gap_rate_m_s) = (0.9e-4, 1.0);
    let mut scene = scene();
    assert_eq!(broken(Model::Engine, &scene, &parted, 0.0).len(), 1);
    scene.engine.stepping = Stepping::Fixed { step_s: 1e-4 };
    assert_eq!(broken(Model::Engine, &scene, &parted, 0.0), []);
    parted[3].contact_mut(Site::Proximal).gap_m = 2e-4;
    assert_eq!(broken(Model::Engine, &scene, &parted, 0.0).len(), 1);

    let mut rigid = clean();
    let proximal = rigid[3].contact_mut(Site::Proximal);
    (proximal.tangential_n, proximal.gap_m) = (8.0, -1e-3);
    scene.engine.response = Response::Rapier { friction: 0.8, restitution: 0.0 };
    assert_eq!(broken(Model::Engine, &scene, &rigid, 0.0), []);
    rigid[3].contact_mut(Site::Proximal).normal_n = -1.0;
    assert_eq!(broken(Model::Engine, &scene, &rigid, 0.0).len(), 1);
}

#[test]
fn discs_are_held_to_them_too() {
    let scene = on_plane(crate::support::laws::scene(
        vec![disc("puck", 0.1, [0.0, 0.1], sliding([1.0, 0.0]))],
        THESIS,
        Some(FRICTION),
        5e-3,
    ));
    let samples: Vec<Sample> = clean()
        .iter()
        .map(|sample| Sample {
            time_s: sample.time_s,
            fingers: Vec::new(),
            bodies: vec![BodyState::default()],
            contacts: vec![*sample.contact(Site::Proximal)],
            energy: sample.energy,
        })
        .collect();
    let broken = |doctor: fn(&mut Sample)| {
        let mut samples = samples.clone();
        doctor(&mut samples[3]);
        let mut invariants = Invariants::new(Model::Analytic, &scene);
        for sample in &samples {
            Sink::sample(&mut invariants, sample).expect("measuring writes nothing");
        }
        let found: Vec<Finding> = invariants.findings(0.0).into_iter().filter(Finding::is_broken).collect();
        found.into_iter().map(|one| (one.invariant, one.place)).collect::<Vec<_>>()
    };
    let pair = || Some("puck-plane".to_string());
    assert_eq!(broken(|_| ()), []);
    assert_eq!(broken(|sample| sample.bodies[0].spin_rad_s = f64::NAN), [(Invariant::Finite, None)]);
    assert_eq!(broken(|sample| sample.energy.balance_j = 1e-4), [(Invariant::Energy, None)]);
    assert_eq!(broken(|sample| sample.energy.dissipated_j = 1e-4), [(Invariant::Passivity, None)]);
    assert_eq!(broken(|sample| sample.contacts[0].gap_m = 1e-9), [(Invariant::NoAdhesion, pair())]);
    assert_eq!(broken(|sample| sample.contacts[0].tangential_n *= -1.0), [(Invariant::Friction, pair())]);
    assert_eq!(broken(|sample| sample.contacts[0].gap_m = -1e-3), [(Invariant::Penetration, pair())]);
}

/// Momentum and angular momentum of a free object balance; an object of another mass, another inertia or another gravity than
/// that of the run is noticed at a hundredth.
#[test]
fn momentum_of_the_object_balances_and_not_that_of_another() {
    let scene = anchor("c").scene;
    let with = |mass: f64, inertia: f64| {
        let mut other = scene.clone();
        let DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), .. } =
            &mut other.system.grasped_mut().motion
        else {
            panic!("the object is fixed")
        };
        *mass_kg *= mass;
        *inertia_kg_m2 *= inertia;
        other
    };
    let [x, y] = scene.system.gravity_m_s2;
    let mut heavier = scene.clone();
    heavier.system.gravity_m_s2 = [x, 1.5 * y];
    let run_of = Scene { log: LogRates { numeric_hz: 1e6, ..scene.log }, ..scene.clone() };
    let books = [&scene, &with(1.01, 1.0), &with(1.0, 1.05), &heavier];
    let mut books = books.map(|scene| Invariants::new(Model::Analytic, scene));
    let outcome = trace::run(Model::Analytic, &run_of, &mut Each(&mut books)).unwrap();
    let broken = books.map(|books| {
        let findings = books.findings(outcome.loop_gap_m);
        let found = [Invariant::Momentum, Invariant::AngularMomentum].map(|one| findings[one as usize].clone());
        println!("{} and {}", found[0], found[1]);
        found.map(|one| one.is_broken())
    });
    assert_eq!(broken, [[false, false], [true, false], [false, true], [true, false]]);
}

/// Several sets of books on one run.
struct Each<'a>(&'a mut [Invariants]);

impl Sink for Each<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.iter_mut().try_for_each(|books| books.sample(sample))
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}
