//! The analytic model of a gripper against an independent program (with stiction and a moving palm too), against the
//! model of one finger, and against conservation laws.

use phalanx::analytic::multibody::{CONTACTS, GraspMode, Multibody, QUADRATURES};
use phalanx::analytic::{ContactReading, ContactState};
use phalanx::integrator::{
    End, Fixed, Method, Observer, RadauOrRodas, Rates, Rodas5p, State, Step, StepTools, System as Equations, integrate,
};
use phalanx::scene::{HandContact, Integrator, Object, ObjectMotion, Scene, Side};
use phalanx::shape::{PlacedShape, max_radius};
use phalanx::trace::{Model, Outcome, run};

use crate::support::reference_cases::{ReferenceCase, cases_at_rest, reference_case};
use crate::support::runs::{
    CollectSink, PHALANGES, assert_below, engineering_settings, experiment_95_with, options, reference_settings,
    run_to_end,
};

/// Capacity of the model for coordinates: with a palm at rest, with a moving palm, and with internal states of bristles.
const AT_REST: usize = 7;
const MOVING: usize = 8;
const STICTION: usize = 16;

/// Contacts with a reference impulse, in the order of the reference cases.
const REFERENCE_CONTACTS: [usize; 6] = [0, 1, 3, 4, 6, 7];

type Layout<const N: usize> = Fixed<N, QUADRATURES>;
type GripperState<const N: usize> = State<Layout<N>>;

/// Records the states at given times, and of every event the time, the contact, and whether the contact has a force
/// afterwards.
struct StateRecorder<const N: usize> {
    times_s: Vec<f64>,
    states: Vec<GripperState<N>>,
    events: Vec<(f64, usize, bool)>,
}

impl<const N: usize> Observer<Layout<N>, GraspMode> for StateRecorder<N> {
    fn step(&mut self, step: &Step<Layout<N>>, _: &GraspMode, tools: &mut dyn StepTools<Layout<N>>) -> bool {
        while let Some(time) = self.times_s.get(self.states.len()).filter(|time| **time <= step.t1 + 1e-15) {
            let is_inside = *time < step.t1;
            self.states.push(if is_inside {
                tools.resolve((time - step.t0) / step.h).clone()
            } else {
                step.end.clone()
            });
        }
        true
    }

    fn event(&mut self, t: f64, _: &GripperState<N>, contact: usize, mode: &GraspMode) {
        self.events.push((t, contact, mode[contact].has_force()));
    }
}

/// Integrates a gripper from its start to the end of its scene.
fn integrate_scene<const N: usize, K: Method<Layout<N>>>(
    scene: &Scene,
    settings: &Integrator,
    observer: &mut impl Observer<Layout<N>, GraspMode>,
) -> End<Layout<N>> {
    let model = Multibody::<N>::new(&scene.hand);
    let (start, duration_s) = (model.start(&scene.hand), scene.duration_s);
    let end = integrate::<_, K, _>(&model, &options(settings), 0.0, start, duration_s, observer);
    assert!(end.result.is_ok(), "{}: {:?}", scene.name, end.result);
    end
}

fn run_recorded<const N: usize, K: Method<Layout<N>>>(
    case: &ReferenceCase,
    settings: Integrator,
) -> (StateRecorder<N>, End<Layout<N>>) {
    let times_s = case.states.iter().map(|state| state.time_s).collect();
    let mut recorder = StateRecorder { times_s, states: Vec::new(), events: Vec::new() };
    let end = integrate_scene::<N, K>(&case.scene, &settings, &mut recorder);
    (recorder, end)
}

fn run_reference<const N: usize>(case: &ReferenceCase) -> (StateRecorder<N>, End<Layout<N>>) {
    run_recorded::<N, RadauOrRodas<Layout<N>>>(case, reference_settings())
}

fn run_engineering<const N: usize>(case: &ReferenceCase) -> (StateRecorder<N>, End<Layout<N>>) {
    run_recorded::<N, Rodas5p<Layout<N>>>(case, engineering_settings())
}

/// Largest difference between the found states and the reference states: angles in rad, positions in object radii.
fn max_error<const N: usize>(case: &ReferenceCase, actual: &[GripperState<N>]) -> f64 {
    assert_eq!(actual.len(), case.states.len(), "{}", case.name);
    let radius = max_radius(&case.scene.hand.grasped().shape);
    let scale = |coordinate: usize| if coordinate == 4 || coordinate == 5 { 1.0 / radius } else { 1.0 };
    let state_error = |(actual, expected): (&GripperState<N>, &[f64; 7])| {
        (0..7).map(|i| scale(i) * (actual.q[i] - expected[i]).abs()).fold(0.0, f64::max)
    };
    actual.iter().zip(case.states.iter().map(|state| &state.q)).map(state_error).fold(0.0, f64::max)
}

/// Compares both presets with the independent program: states, normal impulses of phalanges, palm and table, bristles,
/// and times of first contact. Returns the run with the reference preset.
fn assert_agrees_with_program<const N: usize>(
    case: &ReferenceCase,
    engineering_bound: f64,
) -> (StateRecorder<N>, End<Layout<N>>) {
    let name = &case.name;
    let (samples, end) = run_reference::<N>(case);
    assert_below(max_error(case, &samples.states), 2e-9, name);
    assert_below(max_error(case, &run_engineering::<N>(case).0.states), engineering_bound, name);
    for (contact, expected) in REFERENCE_CONTACTS.into_iter().zip(case.impulse) {
        let error = (end.state.z[contact] - expected).abs();
        assert_below(error, 1e-6 * expected.max(1e-3), format!("{name}: impulse of contact {contact}"));
    }
    (samples, end)
}

#[test]
fn presets_agree_with_an_independent_program() {
    for (letter, engineering_bound) in [("a", 2e-7), ("b", 2e-7), ("c", 2e-5), ("f", 3e-6), ("i", 2e-7)] {
        let case = reference_case(letter);
        let (samples, _) = assert_agrees_with_program::<AT_REST>(&case, engineering_bound);
        for (contact, expected) in REFERENCE_CONTACTS.into_iter().zip(case.first_contact_s) {
            let first = samples.events.iter().find(|(_, at, has_force)| *at == contact && *has_force);
            let first_s = first.expect("a first contact").0;
            assert_below((first_s - expected).abs(), 1e-10, format!("{}: contact {contact} at {first_s} s", case.name));
        }
    }
    for letter in ["d", "e"] {
        let case = reference_case(letter);
        let (_, end) = assert_agrees_with_program::<MOVING>(&case, 2e-7);
        assert!((end.state.q[7] - case.scene.duration_s).abs() < 1e-14, "the last coordinate is the time");
    }
    for letter in ["g", "h"] {
        let case = reference_case(letter);
        let (_, end) = assert_agrees_with_program::<STICTION>(&case, 5e-7);
        let (model, hand) = (Multibody::<STICTION>::new(&case.scene.hand), &case.scene.hand);
        // The reference cases list the two brakes after the contacts; the second brake has an entry even if one motor
        // drives both fingers.
        let brakes = if hand.differential.is_some() { [0, 2] } else { [0, 1] };
        let bristles = REFERENCE_CONTACTS.map(|contact| model.bristle_index(contact)).into_iter();
        let bristles = bristles.chain(brakes.map(|drive| model.brake_bristle_index(drive)));
        // The deflection is σ times the relaxation time.
        let relaxation_s = [1e-3; 6].into_iter().chain([2e-4; 2]);
        for ((expected, relaxation_s), bristle) in case.bristle_deflection.into_iter().zip(relaxation_s).zip(bristles) {
            let deflection = relaxation_s * bristle.map_or(0.0, |bristle| end.state.v[bristle]);
            assert_below((deflection - expected).abs(), 1e-6 * expected.abs() + 1e-14, &case.name);
        }
    }
}

/// Holding an object for a minute costs little more than the closing. With the regularised friction of the thesis the
/// object creeps by more than 0.5 mm; with bristles only the creep of the normal law remains, less than a fifth of
/// that.
#[test]
fn holding_for_a_minute_takes_few_steps_and_samples() {
    let run_one_minute = |letter: &str| {
        let mut log = CollectSink::default();
        let scene = Scene { duration_s: 60.0, ..reference_case(letter).scene };
        (run(Model::Analytic, &scene, &mut log).unwrap_or_else(|error| panic!("{letter}: {error}")), log.samples.len())
    };
    let displacement_m = |outcome: &Outcome| (outcome.last.body(0).centre_m[1] - 0.02).abs();
    let [(regularised, _), (bristle, samples)] = ["a", "g"].map(run_one_minute);
    assert!(displacement_m(&regularised) > 0.5e-3, "{:?}", regularised.last.body(0));
    assert!(displacement_m(&bristle) < 0.1e-3, "{:?}", bristle.last.body(0));
    assert!(bristle.last.body(0).velocity_m_s[1].abs() < 1e-6, "{:?}", bristle.last.body(0));
    assert!(bristle.work.steps < 1000 && samples < 2000, "{} steps, {samples} samples", bristle.work.steps);
}

/// Symmetry of the fingers is only limited by rounding of the object position. Readings of the left phalanges are in the
/// palm frame: mirrored, with the opposite normal direction.
#[test]
fn a_symmetric_gripper_stays_symmetric() {
    for letter in ["a", "b", "i"] {
        let case = reference_case(letter);
        let (samples, End { state: State { q, v, .. }, .. }) = run_engineering::<AT_REST>(&case);
        assert_below((q[0] - q[2]).abs().max((q[1] - q[3]).abs()).max(q[6].abs()), 1e-10, letter);
        assert_below(q[4].abs(), 1e-12, letter);
        assert!(samples.events.iter().any(|(_, contact, _)| *contact == 1), "{letter}: no distal contact");
        let model = Multibody::<AT_REST>::new(&case.scene.hand);
        let reading = |side, contact| {
            let index = HandContact::Finger(side, contact).index();
            model.contact_reading(&q, &v, index, ContactState::Active).expect("a contact")
        };
        for contact in PHALANGES {
            let [right, left] = Side::BOTH.map(|side| reading(side, contact));
            let ([r, l], context) = ([&right.geometry, &left.geometry], format!("{letter} {contact:?}"));
            assert!(right.normal > 1.0, "{context} has no force");
            assert_below((r.point[0] + l.point[0]).abs(), 1e-9, &context);
            assert_below((r.normal[0] + l.normal[0]).abs(), 1e-7, &context);
            for ContactReading { geometry, .. } in [&right, &left] {
                // The normal points from the object to the phalanx.
                let [x, y] = geometry.point;
                let distance = geometry.normal[0] * (x - q[4]) + geometry.normal[1] * (y - q[5]);
                assert_below((distance - 0.02).abs(), 1e-5, &context);
            }
        }
    }
}

fn with_fixed_object(mut scene: Scene) -> Scene {
    scene.hand.grasped_mut().motion = ObjectMotion::Fixed;
    scene
}

/// Final coordinates of a run with the reference preset.
fn end_coordinates<const N: usize>(scene: &Scene) -> [f64; N] {
    integrate_scene::<N, RadauOrRodas<Layout<N>>>(scene, &reference_settings(), &mut ()).state.q
}

/// With a fixed object, each finger moves as in a scene of one finger; the left finger as its mirror image.
#[test]
fn each_finger_on_a_fixed_object_matches_its_single_finger_scene() {
    let scene = reference_case("c").scene;
    let q = end_coordinates::<4>(&with_fixed_object(scene.clone()));
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        let single = experiment_95_with(|single| {
            *single.finger_mut() = scene.hand.fingers[side].clone();
            (single.duration_s, single.integrator) = (scene.duration_s, reference_settings());
            single.hand.gravity_m_s2 = scene.hand.gravity_m_s2;
            let Object { shape, centre_m: [x, y], .. } = scene.hand.grasped();
            let centre_m = [sign * x - 0.5 * scene.hand.palm_width_m, *y];
            single.hand.object = Some(Object::fixed(PlacedShape::disc(max_radius(shape), centre_m)));
        });
        let finger = run_to_end(&single).0.last.finger(0);
        let error = (q[2 * side] - finger.q11_rad).abs().max((q[2 * side + 1] - finger.q21_rad).abs());
        assert_below(error, 1e-10, format!("finger {side}"));
    }
}

#[test]
fn a_heavy_object_converges_to_a_fixed_object() {
    let mut scene = reference_case("c").scene;
    scene.hand.gravity_m_s2 = [0.0; 2];
    let fixed = end_coordinates::<4>(&with_fixed_object(scene.clone()));
    let mut last = f64::INFINITY;
    for factor in [1e3, 1e6] {
        let (mass_kg, inertia_kg_m2) = (0.0537840662 * factor, 1.0756813e-5 * factor);
        scene.hand.grasped_mut().motion =
            ObjectMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s: [0.0; 2], spin_rad_s: 0.0 };
        let heavy = end_coordinates::<AT_REST>(&scene);
        let error = (0..4).map(|i| (heavy[i] - fixed[i]).abs()).fold(0.0, f64::max);
        assert_below(error, 0.02 * last, format!("mass times {factor:e}"));
        last = error;
    }
    assert_below(last, 1e-4, "mass times 1e6");
}

/// The energy supplied by motors and palm equals the change of mechanical energy plus the losses in contacts and
/// brakes.
#[test]
fn energy_balances() {
    fn check<const N: usize>(case: &ReferenceCase, tolerance: f64) {
        let model = Multibody::<N>::new(&case.scene.hand);
        let stored = |state: &GripperState<N>| {
            let energies = model.energies(&state.q, &state.v);
            energies.kinetic + energies.gravity + energies.spring
        };
        let initial = stored(&model.start(&case.scene.hand));
        let (samples, end) = run_reference::<N>(case);
        for state in samples.states.iter().chain([&end.state]) {
            let supplied = state.z[CONTACTS] + state.z[CONTACTS + 1];
            assert_below((stored(state) - initial - supplied).abs(), tolerance, &case.name);
        }
        let (contact, motors) = (end.state.z[CONTACTS], end.state.z[CONTACTS + 1]);
        assert!(contact < 0.0 && motors > 0.1, "{}: {contact} J in contacts, {motors} J of motors", case.name);
    }
    cases_at_rest().iter().for_each(|case| check::<AT_REST>(case, 1e-9));
    ["d", "e"].iter().for_each(|letter| check::<MOVING>(&reference_case(letter), 1e-8));
}

/// Force on the object and moment about its centre, summed over all contacts, and the sum of the magnitudes of all
/// contact forces. The contact readings give the opposite forces.
fn contact_wrench(model: &Multibody<AT_REST>, state: &GripperState<AT_REST>, mode: &GraspMode) -> ([f64; 3], f64) {
    let (mut sum, mut force_sum) = ([0.0; 3], 0.0);
    for index in (0..CONTACTS).filter(|contact| !HandContact::ALL[*contact].is_stop()) {
        let Some(reading) = model.contact_reading(&state.q, &state.v, index, mode[index]) else { continue };
        let ([nx, ny], [px, py]) = (reading.geometry.normal, reading.geometry.point);
        let force = [-reading.normal * nx + reading.tangential * ny, -reading.normal * ny - reading.tangential * nx];
        let lever = [px - state.q[4], py - state.q[5]];
        sum[0] += force[0];
        sum[1] += force[1];
        sum[2] += lever[0] * force[1] - lever[1] * force[0];
        force_sum += force[0].hypot(force[1]);
    }
    (sum, force_sum)
}

/// Unit of the three components of a wrench on the object, relative to a force: 1, and the lever of moments, m.
const WRENCH_SCALE: [f64; 3] = [1.0, 1.0, 0.02];

/// Integrates the contact forces on the object by Simpson's rule over every step, and compares them with its
/// acceleration.
struct MomentumBalance<'a> {
    model: &'a Multibody<AT_REST>,
    inertia: [f64; 3],
    weight: [f64; 3],
    transferred: [f64; 3],
    /// Time integral of the magnitudes of all contact forces, N·s.
    impulse_scale: f64,
    /// Largest difference between mass times acceleration and the forces, N.
    error: f64,
    largest_force: f64,
}

impl Observer<Layout<AT_REST>, GraspMode> for MomentumBalance<'_> {
    fn step(
        &mut self,
        step: &Step<Layout<AT_REST>>,
        mode: &GraspMode,
        tools: &mut dyn StepTools<Layout<AT_REST>>,
    ) -> bool {
        let middle = tools.resolve(0.5).clone();
        for (node, state, weight) in [(0.0, step.start, 1.0), (0.5, &middle, 4.0), (1.0, step.end, 1.0)] {
            let (force, force_sum) = contact_wrench(self.model, state, mode);
            let mut rates = Rates::zero(Fixed);
            self.model.rates(step.t0 + node * step.h, &state.q, &state.v, mode, &mut rates);
            self.impulse_scale += weight / 6.0 * step.h * force_sum;
            self.largest_force = self.largest_force.max(force_sum);
            for i in 0..3 {
                self.transferred[i] += weight / 6.0 * step.h * force[i];
                let inertial = self.inertia[i] * rates.a[4 + i] - self.weight[i];
                self.error = self.error.max((inertial - force[i]).abs() / WRENCH_SCALE[i]);
            }
        }
        true
    }

    fn event(&mut self, _: f64, _: &GripperState<AT_REST>, _: usize, _: &GraspMode) {}
}

/// The impulse of contacts and gravity equals the change of the momentum and angular momentum of the object.
#[test]
fn momentum_of_the_object_balances() {
    for case in cases_at_rest() {
        let (scene, name) = (&case.scene, &case.name);
        let model = Multibody::<AT_REST>::new(&scene.hand);
        let ObjectMotion::Free { mass_kg, inertia_kg_m2, .. } = scene.hand.grasped().motion else {
            panic!("the object is fixed")
        };
        let [gx, gy] = scene.hand.gravity_m_s2;
        let (inertia, weight) = ([mass_kg, mass_kg, inertia_kg_m2], [mass_kg * gx, mass_kg * gy, 0.0]);
        let (transferred, impulse_scale, error, largest_force) = ([0.0; 3], 0.0, 0.0, 0.0);
        let mut balance =
            MomentumBalance { model: &model, inertia, weight, transferred, impulse_scale, error, largest_force };
        let settings = reference_settings();
        let end = integrate_scene::<AT_REST, RadauOrRodas<Layout<AT_REST>>>(scene, &settings, &mut balance);
        let before: GripperState<AT_REST> = model.start(&scene.hand);
        // Instantaneous balance, to rounding.
        assert_below(balance.error, 1e-12 * balance.largest_force, name);
        // Balance over the run, limited by the error of Simpson's rule in impacts.
        for i in 0..3 {
            let change = inertia[i] * (end.state.v[4 + i] - before.v[4 + i]) - weight[i] * scene.duration_s;
            let error = (change - balance.transferred[i]).abs();
            assert_below(error, 1e-5 * balance.impulse_scale * WRENCH_SCALE[i], format!("{name}: component {i}"));
        }
    }
}
