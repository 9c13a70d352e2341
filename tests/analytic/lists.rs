//! Lists of fingers and discs that no kind of scene file has: put together by a program, in both models.

use phalanx::analytic::multibody::{Multibody, ROOM, quadratures};
use phalanx::analytic::{Mode, SiteState};
use phalanx::integrator::{Linearised, Rates, State, System as Equations};
use phalanx::invariants::Invariants;
use phalanx::law::{Bristle, ContactLaw};
use phalanx::scene::{
    Axis, Brake, Disc, DiscMotion, HalfPlane, Integrator, Move, PalmMotion, Preset, Scene, Side, System, Touching,
    load_any,
};
use phalanx::shape::{Placed, reach};
use phalanx::trace::{Layout, Model, Outcome, RunError, run};

use crate::support::laws::{Collect, FRICTION, THESIS, at_steps};

const FINGER: &str = "scenes/experiment-95.toml";
const GRIPPER: &str = "scenes/gripper/design-95.toml";

const LAW: ContactLaw = ContactLaw { normal: THESIS, friction: Some(FRICTION) };

fn load(path: &str) -> Scene {
    load_any(path).unwrap_or_else(|error| panic!("{error}"))
}

fn free(mass_kg: f64, inertia_kg_m2: Option<f64>) -> DiscMotion {
    DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s: [0.0; 2], spin_rad_s: 0.0 }
}

fn disc(name: &str, radius_m: f64, centre_m: [f64; 2], motion: DiscMotion) -> Disc {
    Disc { name: name.to_string(), motion, ..Disc::object(Placed::disc(radius_m, centre_m)) }
}

/// A disc that nothing reaches.
fn far(motion: DiscMotion) -> Disc {
    disc("far", 0.01, [0.5, 0.4], motion)
}

/// A finger that pushes a free object along its palm.
fn pushing() -> Scene {
    let mut scene = load(FINGER);
    scene.system.grasped_mut().motion = free(0.05, Some(1e-5));
    scene.system.palm = Some(HalfPlane { level_m: 0.0, contact: Some(LAW) });
    scene.system.gravity_m_s2 = [0.0, -9.81];
    scene.duration_s = 0.01;
    scene
}

/// The same with a second disc that the object is pushed against, and a wall behind it.
fn pushing_two() -> Scene {
    let mut scene = pushing();
    let [x, y] = scene.system.grasped().centre_m;
    scene.system.discs.push(disc("ball", 0.01, [x - 0.0305, y - 0.0095], free(0.02, Some(1e-6))));
    scene.system.discs.push(disc("wall", 0.01, [x - 0.0555, y - 0.0095], DiscMotion::Fixed));
    scene.system.between_discs = Some(LAW);
    scene
}

/// Two fingers with two objects, one on the other.
fn two_objects() -> Scene {
    let mut scene = load(GRIPPER);
    scene.system.gravity_m_s2 = [0.0, -9.81];
    let Placed { shape, centre_m: [x, y], .. } = scene.system.grasped().placed();
    let radius_m = reach(&shape);
    scene.system.discs.push(disc("ball", 0.008, [x + 1e-3, y + radius_m + 0.00795], free(0.015, Some(5e-7))));
    scene.system.between_discs = Some(LAW);
    scene.duration_s = 0.01;
    scene
}

fn with_bristles(mut scene: Scene) -> Scene {
    let bristle = Bristle { damping_n_s_per_m: 1e6, relaxation_s: 1e-3 };
    let hold = |law: &mut ContactLaw| law.friction.iter_mut().for_each(|friction| friction.bristle = Some(bristle));
    scene.system.between_discs.iter_mut().for_each(hold);
    scene.system.palm.iter_mut().filter_map(|palm| palm.contact.as_mut()).for_each(hold);
    scene.system.fingers.iter_mut().flat_map(|finger| finger.contact.both_mut()).for_each(hold);
    scene
}

/// The same where the ball falls off the object, slowly, while the fingers hit that.
fn parting() -> Scene {
    let mut scene = with_bristles(two_objects());
    scene.system.gravity_m_s2 = load(GRIPPER).system.gravity_m_s2;
    scene
}

/// Two fingers around a disc that comes at them as told.
fn driven() -> Scene {
    let mut scene = load(GRIPPER);
    scene.system.palm = None;
    scene.system.grasped_mut().motion =
        DiscMotion::Driven { velocity_m_s: [0.05, 0.1], acceleration_m_s2: [5.0, 8.0], spin_rad_s: 4.0 };
    scene.duration_s = 0.01;
    scene
}

/// Two fingers that close on nothing, up to their stops.
fn empty() -> Scene {
    let mut scene = load(GRIPPER);
    scene.system.discs.clear();
    scene.duration_s = 0.006;
    scene
}

/// The scene on a palm that moves.
fn carried(mut scene: Scene) -> Scene {
    let one = |axis, distance| Move { axis, distance, start_s: 1e-3, length_s: 8e-3 };
    let moves = vec![one(Axis::X, 2e-3), one(Axis::Y, -3e-3), one(Axis::Angle, 0.05)];
    scene.system.palm_motion = Some(PalmMotion { moves, ..PalmMotion::default() });
    scene
}

fn cases() -> Vec<(&'static str, Scene)> {
    vec![
        ("pushing", pushing()),
        ("pushing two", pushing_two()),
        ("two objects", two_objects()),
        ("bristles", with_bristles(two_objects())),
        ("parting bristles", parting()),
        ("driven", driven()),
        ("empty", empty()),
        ("carried", carried(pushing())),
        ("carried empty", carried(empty())),
    ]
}

#[track_caller]
fn ran(model: Model, preset: Preset, scene: &Scene) -> (Outcome, Collect) {
    let mut scene = scene.clone();
    scene.integrator = Integrator::preset(preset);
    let mut log = Collect::default();
    let outcome = run(model, &scene, &mut log).unwrap_or_else(|error| panic!("{}: {error}", model.name()));
    (outcome, log)
}

/// Largest distance between two ends: angles of fingers in rad, places of discs in radii of the first.
fn apart(system: &System, one: &Outcome, other: &Outcome) -> f64 {
    assert_eq!(one.last.bodies.len(), other.last.bodies.len());
    let radius_m = system.discs.first().map_or(1.0, |disc| reach(&disc.shape));
    let fingers = one.last.fingers.iter().zip(&other.last.fingers);
    let angles = fingers.flat_map(|(a, b)| [a.q11_rad - b.q11_rad, a.q21_rad - b.q21_rad]);
    let bodies = one.last.bodies.iter().zip(&other.last.bodies);
    let places = bodies.flat_map(|(a, b)| [0, 1].map(|i| (a.centre_m[i] - b.centre_m[i]) / radius_m));
    angles.chain(places).map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn both_models_agree() {
    for (name, scene) in cases() {
        assert_eq!(scene.system.objection(), None, "{name}");
        let (fine, _) = ran(Model::Analytic, Preset::Reference, &scene);
        let (everyday, _) = ran(Model::Analytic, Preset::Engineering, &scene);
        let (engine, _) = ran(Model::Engine, Preset::Reference, &at_steps(Model::Engine, scene.clone()));
        let [off, engine_off] = [&everyday, &engine].map(|other| apart(&scene.system, &fine, other));
        // As everyday runs are meant to be, to their relative tolerance; the engine comes as near.
        assert!(off < 1e-5, "{name}: everyday {off:.1e}");
        assert!(engine_off < 3e-5, "{name}: engine {engine_off:.1e}");
        let touched =
            |outcome: &Outcome| outcome.contacts.iter().map(|contact| contact.first_s.is_some()).collect::<Vec<_>>();
        assert_eq!(touched(&fine), touched(&engine), "{name}: {:?}", Layout::of(&scene.system).contacts);
    }
}

/// Nothing is gained in contacts, nothing is lost elsewhere, and in either model no bound of a sound run is broken.
#[test]
fn energy_balances() {
    for (name, scene) in cases() {
        let (outcome, log) = ran(Model::Analytic, Preset::Reference, &scene);
        let sizes = |of: &phalanx::trace::Energy| of.motor_work_j.abs().max(of.dissipated_j.abs()).max(of.kinetic_j);
        let size = log.samples.iter().map(|sample| sizes(&sample.energy)).fold(0.0, f64::max);
        let balance = outcome.last.energy.balance_j.abs();
        assert!(balance < 1e-7 * size, "{name}: {balance:.1e} of {size:.1e} J");
        assert!(outcome.last.energy.dissipated_j > 0.0, "{name}: something is lost");
        for model in [Model::Analytic, Model::Engine] {
            let scene = at_steps(model, scene.clone());
            let mut watch = Invariants::new(model, &scene);
            let outcome = run(model, &scene, &mut watch).unwrap_or_else(|error| panic!("{name}: {error}"));
            let broken = watch.findings(outcome.loop_gap_m).into_iter().find(|finding| finding.is_broken());
            assert!(broken.is_none(), "{name}, {}: {broken:?}", model.name());
        }
    }
}

/// What is far away changes nothing: another kernel then simulates a finger, and room of another size a gripper.
#[test]
fn a_disc_far_away_changes_nothing() {
    for (path, motion) in [(FINGER, DiscMotion::Fixed), (GRIPPER, free(0.01, Some(1e-6)))] {
        let scene = load(path);
        let mut with = scene.clone();
        with.system.discs.push(far(motion));
        with.system.between_discs = Some(LAW);
        let (alone, _) = ran(Model::Analytic, Preset::Reference, &scene);
        let (other, _) = ran(Model::Analytic, Preset::Reference, &with);
        for (a, b) in alone.last.fingers.iter().zip(&other.last.fingers) {
            let off = (a.q11_rad - b.q11_rad).abs().max((a.q21_rad - b.q21_rad).abs());
            assert!(off < 1e-9, "{path}: {off:.1e} rad");
        }
        let mut pressed = 0;
        for (a, b) in alone.contacts.iter().zip(&other.contacts) {
            let off = (a.impulse_n_s - b.impulse_n_s).abs();
            assert!(off < 1e-7 * a.impulse_n_s.max(1e-3), "{path}: {off:.1e} of {:.1e} N s", a.impulse_n_s);
            pressed += usize::from(a.impulse_n_s > 0.0);
        }
        assert!(pressed >= 2, "{path}: {pressed}");
    }
}

/// A brake, a rotor and a speed at which nothing is left of the torque are no business of the kernel of one finger, but they are felt.
#[test]
fn one_finger_has_all_that_a_motor_has() {
    let mut scene = load(FINGER);
    let plain = ran(Model::Analytic, Preset::Reference, &scene).0;
    let motor = &mut scene.system.fingers[0].motor;
    motor.inertia_kg_m2 = 2e-6;
    motor.no_load_speed_rad_s = Some(600.0);
    motor.brake = Some(Brake { start_s: 0.004, ..brake() });
    let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| ran(model, Preset::Reference, &scene).0);
    let off = apart(&scene.system, &analytic, &engine);
    assert!(off < 1e-3, "{off:.1e}");
    assert!(apart(&scene.system, &analytic, &plain) > 0.05, "the brake holds it");
}

fn brake() -> Brake {
    let scene = load("scenes/gripper/lift.toml");
    let brakes = scene.system.fingers.iter().filter_map(|finger| finger.motor.brake);
    brakes.chain(scene.system.differential.and_then(|input| input.motor.brake)).next().expect("a brake")
}

/// What is made of a list is told by name, each contact once.
#[test]
fn contacts_have_names() {
    let names = |scene: &Scene| {
        Layout::of(&scene.system).contacts.into_iter().map(|place| place.name).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(
        names(&pushing_two()),
        "proximal distal limit ball-proximal ball-distal wall-proximal wall-distal object-ball object-wall object-palm \
         ball-wall ball-palm"
    );
    assert_eq!(
        names(&two_objects()),
        "right_proximal right_distal right_limit left_proximal left_distal left_limit palm table ball-right_proximal \
         ball-right_distal ball-left_proximal ball-left_distal object-ball ball-palm"
    );
    for (name, scene) in cases() {
        let mut names: Vec<_> = Layout::of(&scene.system).contacts.into_iter().map(|place| place.name).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count, "{name}");
    }
}

/// More than there is room for is refused, with what to do.
#[test]
fn too_large_a_list_is_refused() {
    let mut scene = two_objects();
    for index in 0..3 {
        scene.system.discs.push(disc(&format!("far{index}"), 0.01, [0.5 + 0.1 * index as f64, 0.4], free(0.01, None)));
    }
    let Err(RunError::Simulation { failure, .. }) = run(Model::Analytic, &scene, &mut ()) else { panic!("it runs") };
    let reason = failure.reason.to_string();
    assert!(reason.contains("19 coordinates") && reason.contains("up to 14") && reason.contains("engine"), "{reason}");
    scene.duration_s = 1e-3;
    assert!(run(Model::Engine, &scene, &mut ()).is_ok());
}

const COORDINATES: usize = ROOM[1].coordinates;
const CONTACTS: usize = ROOM[1].contacts;
const QUADRATURES: usize = quadratures(CONTACTS);

type Kernel = Multibody<COORDINATES, CONTACTS>;

/// Every entry of the Jacobian against differences of the equations, with everything that can press in contact.
#[test]
fn the_jacobian_is_that_of_the_accelerations() {
    for (name, scene) in cases() {
        let (_, log) = ran(Model::Analytic, Preset::Reference, &scene);
        let sample = log
            .samples
            .iter()
            .max_by_key(|sample| sample.contacts.iter().filter(|contact| contact.normal_n > 0.1).count());
        let sample = sample.expect("samples");
        let model = Kernel::new(&scene.system);
        let mut state: State<COORDINATES, QUADRATURES> = model.start(&scene.system);
        for (index, finger) in sample.fingers.iter().enumerate() {
            (state.q[2 * index], state.q[2 * index + 1]) = (finger.q11_rad, finger.q21_rad);
            (state.v[2 * index], state.v[2 * index + 1]) = (finger.qd11_rad_s, finger.qd21_rad_s);
        }
        let mut next = 2 * sample.fingers.len();
        for (disc, body) in scene.system.discs.iter().zip(&sample.bodies).filter(|(disc, _)| disc.motion.moves()) {
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
        let mut pressing = 0;
        for index in 0..model.contacts() {
            if sample.contacts[index].normal_n > 0.0 {
                mode[index] = SiteState::Active;
                pressing += 1;
            }
        }
        assert!(pressing > usize::from(!name.ends_with("empty")), "{name}: {pressing} contacts press");
        let t = sample.time_s;
        let exact: Linearised<COORDINATES, QUADRATURES> = model.linearise(t, &state.q, &state.v, &mode);
        let used = next + usize::from(scene.system.palm_motion.is_some());
        for (by_rate, j) in (0..used).map(|j| (false, j)).chain((0..COORDINATES).map(|j| (true, j))) {
            let at = |h: f64| {
                let (mut q, mut v) = (state.q, state.v);
                let varied = if by_rate { &mut v[j] } else { &mut q[j] };
                *varied += h;
                let rates: Rates<COORDINATES, QUADRATURES> = model.rates(t, &q, &v, &mode);
                rates.a.into_iter().chain(rates.g).collect::<Vec<_>>()
            };
            // Differences of order 4, over a part of the depth at which contacts press.
            let h = match (by_rate, name) {
                (true, "bristles" | "parting bristles") => 1e-8,
                (true, _) => 1e-5,
                (false, _) => 1e-11,
            };
            let ([a, b], [c, d]) = ([at(h), at(-h)], [at(2.0 * h), at(-2.0 * h)]);
            for (i, (value, _)) in at(0.0).into_iter().zip(&a).enumerate() {
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
                    "{name}: output {i} by {} {j}: {:e}, by differences {difference:e}",
                    if by_rate { "rate" } else { "coordinate" },
                    row[j]
                );
            }
        }
    }
}

/// Places of a scene file's contacts stay where they were: the first ones are those of the fingers with their object.
#[test]
fn the_places_of_a_gripper_come_first() {
    let system = two_objects().system;
    let touching = system.touching();
    for place in system.places() {
        assert_eq!(touching[place.index()], place.touching(0));
    }
    assert_eq!(touching[system.places().len()], Touching::Phalanx(Side::Right, phalanx::gripper::Site::Proximal, 1));
}
