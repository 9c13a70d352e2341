//! Systems of fingers and discs beyond the kinds of scene files, built in code and run in both models.

use phalanx::analytic::multibody::{MAX_SIZES, Multibody, quadratures};
use phalanx::analytic::{ContactState, Mode};
use phalanx::integrator::{Linearised, Rates, State, System as Equations};
use phalanx::invariants::Invariants;
use phalanx::law::{Bristle, ContactLaw};
use phalanx::scene::{
    Axis, Brake, ContactId, Disc, DiscMotion, HalfPlane, Integrator, Move, PalmMotion, Preset, Scene, Side, System,
    load_any,
};
use phalanx::shape::{PlacedShape, max_radius};
use phalanx::trace::{Model, Outcome, RunError, Schema, run};

use crate::support::laws::{CollectSink, THESIS_FRICTION, THESIS_NORMAL, sampled_at_steps};

const FINGER: &str = "scenes/experiment-95.toml";
const GRIPPER: &str = "scenes/gripper/design-95.toml";

const LAW: ContactLaw = ContactLaw { normal: THESIS_NORMAL, friction: Some(THESIS_FRICTION) };

fn load(path: &str) -> Scene {
    load_any(path).unwrap_or_else(|error| panic!("{error}"))
}

fn free(mass_kg: f64, inertia_kg_m2: Option<f64>) -> DiscMotion {
    DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s: [0.0; 2], spin_rad_s: 0.0 }
}

fn disc(name: &str, radius_m: f64, centre_m: [f64; 2], motion: DiscMotion) -> Disc {
    Disc { name: name.to_string(), motion, ..Disc::fixed_object(PlacedShape::disc(radius_m, centre_m)) }
}

/// A disc out of reach of all other bodies.
fn distant_disc(motion: DiscMotion) -> Disc {
    disc("far", 0.01, [0.5, 0.4], motion)
}

/// A finger that pushes a free object along its palm.
fn finger_pushing_object() -> Scene {
    let mut scene = load(FINGER);
    scene.system.grasped_mut().motion = free(0.05, Some(1e-5));
    scene.system.palm = Some(HalfPlane { level_m: 0.0, contact: Some(LAW) });
    scene.system.gravity_m_s2 = [0.0, -9.81];
    scene.duration_s = 0.01;
    scene
}

/// The scene of [`finger_pushing_object`] with a second disc that the object is pushed against, and a wall behind it.
fn finger_pushing_two_discs() -> Scene {
    let mut scene = finger_pushing_object();
    let [x, y] = scene.system.grasped().centre_m;
    scene.system.discs.push(disc("ball", 0.01, [x - 0.0305, y - 0.0095], free(0.02, Some(1e-6))));
    scene.system.discs.push(disc("wall", 0.01, [x - 0.0555, y - 0.0095], DiscMotion::Fixed));
    scene.system.between_discs = Some(LAW);
    scene
}

/// Two fingers with two objects, one on the other.
fn gripper_with_two_objects() -> Scene {
    let mut scene = load(GRIPPER);
    scene.system.gravity_m_s2 = [0.0, -9.81];
    let PlacedShape { shape, centre_m: [x, y], .. } = scene.system.grasped().placed();
    let radius_m = max_radius(&shape);
    scene.system.discs.push(disc("ball", 0.008, [x + 1e-3, y + radius_m + 0.00795], free(0.015, Some(5e-7))));
    scene.system.between_discs = Some(LAW);
    scene.duration_s = 0.01;
    scene
}

fn with_bristles(mut scene: Scene) -> Scene {
    let bristle = Bristle { damping_n_s_per_m: 1e6, relaxation_s: 1e-3 };
    let add_bristle =
        |law: &mut ContactLaw| law.friction.iter_mut().for_each(|friction| friction.bristle = Some(bristle));
    scene.system.between_discs.iter_mut().for_each(add_bristle);
    scene.system.palm.iter_mut().filter_map(|palm| palm.contact.as_mut()).for_each(add_bristle);
    scene.system.fingers.iter_mut().flat_map(|finger| finger.contact.both_mut()).for_each(add_bristle);
    scene
}

/// The scene with bristles in which the ball slowly separates from the object while the fingers hit the object.
fn separating_bristles() -> Scene {
    let mut scene = with_bristles(gripper_with_two_objects());
    scene.system.gravity_m_s2 = load(GRIPPER).system.gravity_m_s2;
    scene
}

/// Two fingers around a disc with prescribed motion.
fn gripper_with_driven_disc() -> Scene {
    let mut scene = load(GRIPPER);
    scene.system.palm = None;
    scene.system.grasped_mut().motion =
        DiscMotion::Driven { velocity_m_s: [0.05, 0.1], acceleration_m_s2: [5.0, 8.0], spin_rad_s: 4.0 };
    scene.duration_s = 0.01;
    scene
}

/// Two fingers that close up to their stops, without an object.
fn gripper_without_object() -> Scene {
    let mut scene = load(GRIPPER);
    scene.system.discs.clear();
    scene.duration_s = 0.006;
    scene
}

/// The scene with a moving palm.
fn with_moving_palm(mut scene: Scene) -> Scene {
    let displacement = |axis, distance| Move { axis, distance, start_s: 1e-3, length_s: 8e-3 };
    let moves = vec![displacement(Axis::X, 2e-3), displacement(Axis::Y, -3e-3), displacement(Axis::Angle, 0.05)];
    scene.system.palm_motion = Some(PalmMotion { moves, ..PalmMotion::default() });
    scene
}

fn cases() -> Vec<(&'static str, Scene)> {
    vec![
        ("pushing", finger_pushing_object()),
        ("pushing two", finger_pushing_two_discs()),
        ("two objects", gripper_with_two_objects()),
        ("bristles", with_bristles(gripper_with_two_objects())),
        ("separating bristles", separating_bristles()),
        ("driven", gripper_with_driven_disc()),
        ("no object", gripper_without_object()),
        ("moving palm", with_moving_palm(finger_pushing_object())),
        ("moving palm, no object", with_moving_palm(gripper_without_object())),
    ]
}

#[track_caller]
fn run_with_preset(model: Model, preset: Preset, scene: &Scene) -> (Outcome, CollectSink) {
    let mut scene = scene.clone();
    scene.integrator = Integrator::preset(preset);
    let mut log = CollectSink::default();
    let outcome = run(model, &scene, &mut log).unwrap_or_else(|error| panic!("{}: {error}", model.name()));
    (outcome, log)
}

/// Largest difference between two final states: finger angles in rad, positions of discs in radii of the first disc.
fn max_difference(system: &System, first: &Outcome, second: &Outcome) -> f64 {
    assert_eq!(first.last.counts().bodies, second.last.counts().bodies);
    let radius_m = system.discs.first().map_or(1.0, |disc| max_radius(&disc.shape));
    let fingers = first.last.fingers().zip(second.last.fingers());
    let angles = fingers.flat_map(|(a, b)| [a.q11_rad - b.q11_rad, a.q21_rad - b.q21_rad]);
    let bodies = first.last.bodies().zip(second.last.bodies());
    let positions = bodies.flat_map(|(a, b)| [0, 1].map(|i| (a.centre_m[i] - b.centre_m[i]) / radius_m));
    angles.chain(positions).map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn both_models_agree() {
    for (name, scene) in cases() {
        assert_eq!(scene.system.unsupported(), None, "{name}");
        let (reference, _) = run_with_preset(Model::Analytic, Preset::Reference, &scene);
        let (engineering, _) = run_with_preset(Model::Analytic, Preset::Engineering, &scene);
        let (engine, _) =
            run_with_preset(Model::Engine, Preset::Reference, &sampled_at_steps(Model::Engine, scene.clone()));
        let [error, engine_error] =
            [&engineering, &engine].map(|other| max_difference(&scene.system, &reference, other));
        // The engineering preset is accurate to its relative tolerance; the engine is about as accurate.
        assert!(error < 1e-5, "{name}: engineering preset {error:.1e}");
        assert!(engine_error < 3e-5, "{name}: engine {engine_error:.1e}");
        let has_contact =
            |outcome: &Outcome| outcome.contacts.iter().map(|contact| contact.first_s.is_some()).collect::<Vec<_>>();
        assert_eq!(
            has_contact(&reference),
            has_contact(&engine),
            "{name}: {:?}",
            Schema::from_system(&scene.system).contacts
        );
    }
}

/// Only contacts dissipate energy, and neither model violates an invariant.
#[test]
fn energy_balances_and_invariants_hold() {
    for (name, scene) in cases() {
        let (outcome, log) = run_with_preset(Model::Analytic, Preset::Reference, &scene);
        let energy_magnitude = |energy: &phalanx::trace::Energy| {
            energy.motor_work_j.abs().max(energy.dissipated_j.abs()).max(energy.kinetic_j)
        };
        let size = log.samples.iter().map(|sample| energy_magnitude(&sample.energy())).fold(0.0, f64::max);
        let balance = outcome.last.energy().balance_j.abs();
        assert!(balance < 1e-7 * size, "{name}: {balance:.1e} of {size:.1e} J");
        assert!(outcome.last.energy().dissipated_j > 0.0, "{name}: no dissipation");
        for model in [Model::Analytic, Model::Engine] {
            let scene = sampled_at_steps(model, scene.clone());
            let mut invariants = Invariants::new(model, &scene);
            let outcome = run(model, &scene, &mut invariants).unwrap_or_else(|error| panic!("{name}: {error}"));
            let violation = invariants.findings(outcome.loop_gap_m).into_iter().find(|finding| finding.is_violated());
            assert!(violation.is_none(), "{name}, {}: {violation:?}", model.name());
        }
    }
}

/// A distant disc has no effect, although with it another kernel simulates the finger, and a larger one the gripper.
#[test]
fn a_distant_disc_has_no_effect() {
    for (path, motion) in [(FINGER, DiscMotion::Fixed), (GRIPPER, free(0.01, Some(1e-6)))] {
        let scene = load(path);
        let mut with_distant_disc = scene.clone();
        with_distant_disc.system.discs.push(distant_disc(motion));
        with_distant_disc.system.between_discs = Some(LAW);
        let (single_system, _) = run_with_preset(Model::Analytic, Preset::Reference, &scene);
        let (other, _) = run_with_preset(Model::Analytic, Preset::Reference, &with_distant_disc);
        for (a, b) in single_system.last.fingers().zip(other.last.fingers()) {
            let error = (a.q11_rad - b.q11_rad).abs().max((a.q21_rad - b.q21_rad).abs());
            assert!(error < 1e-9, "{path}: {error:.1e} rad");
        }
        let mut active_contacts = 0;
        for (a, b) in single_system.contacts.iter().zip(&other.contacts) {
            let error = (a.impulse_n_s - b.impulse_n_s).abs();
            assert!(error < 1e-7 * a.impulse_n_s.max(1e-3), "{path}: {error:.1e} of {:.1e} N s", a.impulse_n_s);
            active_contacts += usize::from(a.impulse_n_s > 0.0);
        }
        assert!(active_contacts >= 2, "{path}: {active_contacts}");
    }
}

/// The kernel for one finger does not support brake, rotor inertia and no-load speed; the general kernel handles them.
#[test]
fn one_finger_supports_brake_rotor_inertia_and_no_load_speed() {
    let mut scene = load(FINGER);
    let without_distant_disc = run_with_preset(Model::Analytic, Preset::Reference, &scene).0;
    let motor = &mut scene.system.fingers[0].motor;
    motor.inertia_kg_m2 = 2e-6;
    motor.no_load_speed_rad_s = Some(600.0);
    motor.brake = Some(Brake { start_s: 0.004, ..brake() });
    let [analytic, engine] =
        [Model::Analytic, Model::Engine].map(|model| run_with_preset(model, Preset::Reference, &scene).0);
    let error = max_difference(&scene.system, &analytic, &engine);
    assert!(error < 1e-3, "{error:.1e}");
    assert!(
        max_difference(&scene.system, &analytic, &without_distant_disc) > 0.05,
        "the motor settings have no effect"
    );
}

fn brake() -> Brake {
    let scene = load("scenes/gripper/lift.toml");
    let brakes = scene.system.fingers.iter().filter_map(|finger| finger.motor.brake);
    brakes.chain(scene.system.differential.and_then(|input| input.motor.brake)).next().expect("a brake")
}

#[test]
fn contacts_have_unique_names() {
    let names = |scene: &Scene| {
        Schema::from_system(&scene.system)
            .contacts
            .into_iter()
            .map(|contact| contact.name)
            .collect::<Vec<_>>()
            .join(" ")
    };
    assert_eq!(
        names(&finger_pushing_two_discs()),
        "proximal distal limit ball-proximal ball-distal wall-proximal wall-distal object-ball object-wall object-palm \
         ball-wall ball-palm"
    );
    assert_eq!(
        names(&gripper_with_two_objects()),
        "right_proximal right_distal right_limit left_proximal left_distal left_limit palm table ball-right_proximal \
         ball-right_distal ball-left_proximal ball-left_distal object-ball ball-palm"
    );
    for (name, scene) in cases() {
        let mut names: Vec<_> =
            Schema::from_system(&scene.system).contacts.into_iter().map(|contact| contact.name).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count, "{name}");
    }
}

/// A system beyond the capacity of the analytic model is rejected; the message names the limit and the engine.
#[test]
fn too_many_bodies_are_rejected() {
    let mut scene = gripper_with_two_objects();
    for index in 0..3 {
        scene.system.discs.push(disc(&format!("far{index}"), 0.01, [0.5 + 0.1 * index as f64, 0.4], free(0.01, None)));
    }
    let Err(RunError::Simulation { failure, .. }) = run(Model::Analytic, &scene, &mut ()) else {
        panic!("the run completed")
    };
    let reason = failure.reason.to_string();
    assert!(reason.contains("19 coordinates") && reason.contains("up to 14") && reason.contains("engine"), "{reason}");
    scene.duration_s = 1e-3;
    assert!(run(Model::Engine, &scene, &mut ()).is_ok());
}

const COORDINATES: usize = MAX_SIZES[1].coordinates;
const CONTACTS: usize = MAX_SIZES[1].contacts;
const QUADRATURES: usize = quadratures(CONTACTS);

type Kernel = Multibody<COORDINATES, CONTACTS>;

/// Compares every entry of the Jacobian with central differences, at the sample with the most active contacts.
#[test]
fn jacobian_matches_central_differences() {
    for (name, scene) in cases() {
        let (_, log) = run_with_preset(Model::Analytic, Preset::Reference, &scene);
        let sample = log
            .samples
            .iter()
            .max_by_key(|sample| sample.contacts.iter().filter(|contact| contact.normal_n > 0.1).count());
        let sample = sample.expect("samples");
        let model = Kernel::new(&scene.system);
        let mut state: State<COORDINATES, QUADRATURES> = model.start(&scene.system);
        for (index, finger) in sample.fingers().enumerate() {
            (state.q[2 * index], state.q[2 * index + 1]) = (finger.q11_rad, finger.q21_rad);
            (state.v[2 * index], state.v[2 * index + 1]) = (finger.qd11_rad_s, finger.qd21_rad_s);
        }
        let mut next = 2 * sample.counts().fingers;
        for (disc, body) in scene.system.discs.iter().zip(sample.bodies()).filter(|(disc, _)| disc.motion.moves()) {
            let ([x, y], [vx, vy]) = (body.centre_m, body.velocity_m_s);
            state.q[next..next + 3].copy_from_slice(&[x, y, body.angle_rad]);
            state.v[next..next + 3].copy_from_slice(&[vx, vy, body.spin_rad_s]);
            assert!(next + 3 <= COORDINATES, "{}", disc.name);
            next += 3;
        }
        if scene.system.palm_motion.is_some() {
            state.q[next] = sample.time_s;
        }
        let mut mode = Mode::<CONTACTS>::FREE;
        let mut active_contacts = 0;
        for index in 0..model.contact_count() {
            if sample.contact(index).normal_n > 0.0 {
                mode[index] = ContactState::Active;
                active_contacts += 1;
            }
        }
        assert!(
            active_contacts > usize::from(!name.ends_with("no object")),
            "{name}: only {active_contacts} active contacts"
        );
        let t = sample.time_s;
        let exact: Linearised<COORDINATES, QUADRATURES> = model.linearise(t, &state.q, &state.v, &mode);
        let coordinate_count = next + usize::from(scene.system.palm_motion.is_some());
        for (by_rate, j) in (0..coordinate_count).map(|j| (false, j)).chain((0..COORDINATES).map(|j| (true, j))) {
            let shifted_outputs = |h: f64| {
                let (mut q, mut v) = (state.q, state.v);
                let varied = if by_rate { &mut v[j] } else { &mut q[j] };
                *varied += h;
                let rates: Rates<COORDINATES, QUADRATURES> = model.rates(t, &q, &v, &mode);
                rates.a.into_iter().chain(rates.g).collect::<Vec<_>>()
            };
            // Central differences of fourth order; the step is a fraction of the penetration.
            let h = match (by_rate, name) {
                (true, "bristles" | "separating bristles") => 1e-8,
                (true, _) => 1e-5,
                (false, _) => 1e-11,
            };
            let ([a, b], [c, d]) =
                ([shifted_outputs(h), shifted_outputs(-h)], [shifted_outputs(2.0 * h), shifted_outputs(-2.0 * h)]);
            for (i, (value, _)) in shifted_outputs(0.0).into_iter().zip(&a).enumerate() {
                let difference = (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h);
                let rows = if i < COORDINATES {
                    [&exact.a_q[i], &exact.a_v[i]]
                } else {
                    [&exact.g_q[i - COORDINATES], &exact.g_v[i - COORDINATES]]
                };
                let row = rows[usize::from(by_rate)];
                let largest = row.iter().fold(0.0f64, |most, entry| most.max(entry.abs()));
                let noise = 1e-15 * value.abs().max(largest) / h;
                assert!(
                    (row[j] - difference).abs() <= 2e-5 * largest + 30.0 * noise,
                    "{name}: output {i} by {} {j}: {:e}, by central differences {difference:e}",
                    if by_rate { "rate" } else { "coordinate" },
                    row[j]
                );
            }
        }
    }
}

/// The contacts that a scene file can name come first: those of the fingers, palm and table with the object.
#[test]
fn gripper_contacts_come_first() {
    let system = gripper_with_two_objects().system;
    let contact_ids = system.contact_ids();
    for contact in system.gripper_contacts() {
        assert_eq!(contact_ids[contact.index()], contact.contact_id(0));
    }
    assert_eq!(
        contact_ids[system.gripper_contacts().len()],
        ContactId::Phalanx(Side::Right, phalanx::gripper::FingerContact::Proximal, 1)
    );
}
