//! The analytic model of a gripper against an independent program, against the model of one finger, and against
//! conservation laws.

use phalanx::analytic::multibody::{Multibody, event_function_count, quadratures};
use phalanx::analytic::{self, ContactState};
use phalanx::gripper::FingerContact;
use phalanx::integrator::{
    End, Linearised, Method, Observer, Options, RadauOrRodas, Rates, Rodas5p, State, Step, StepTools,
    System as Equations, Tolerances, integrate,
};
use phalanx::scene::{Disc, DiscMotion, GripperContact, Integrator, Preset, Scene, System};
use phalanx::shape::{PlacedShape, max_radius};

use crate::support::reference_cases::{ReferenceCase, cases_at_rest, reference_case};

/// The model of a gripper: two fingers and an object.
pub type GripperModel<const N: usize> = Multibody<N, CONTACTS>;
pub type GripperMode = analytic::Mode<CONTACTS>;

pub const CONTACTS: usize = GripperContact::ALL.len();
pub const QUADRATURES: usize = quadratures(CONTACTS);
const EVENT_FUNCTIONS: usize = event_function_count(CONTACTS);

pub fn initial_state<const N: usize>(system: &System) -> State<N, QUADRATURES> {
    GripperModel::<N>::new(system).start(system)
}

/// Records the states at given times, and of every event the time, the contact, and whether the contact has a force
/// afterwards.
pub struct StateRecorder<const N: usize> {
    sample_times: Vec<f64>,
    pub states: Vec<State<N, QUADRATURES>>,
    pub events: Vec<(f64, usize, bool)>,
}

impl<const N: usize> Observer<N, QUADRATURES, GripperMode> for StateRecorder<N> {
    fn step(
        &mut self,
        step: &Step<N, QUADRATURES>,
        _: &GripperMode,
        tools: &mut dyn StepTools<N, QUADRATURES>,
    ) -> bool {
        while let Some(time) = self.sample_times.get(self.states.len()).filter(|time| **time <= step.t1 + 1e-15) {
            let is_first_phase = *time < step.t1;
            self.states.push(if is_first_phase { tools.resolve((time - step.t0) / step.h) } else { *step.end });
        }
        true
    }

    fn event(&mut self, t: f64, _: &State<N, QUADRATURES>, contact: usize, mode: &GripperMode) {
        self.events.push((t, contact, mode[contact].has_force()));
    }
}

fn run_with_method<const N: usize, K: Method<N, QUADRATURES>>(
    scene: &Scene,
    settings: &Integrator,
    sample_times: Vec<f64>,
) -> (StateRecorder<N>, End<N, QUADRATURES>) {
    let mut recorder = StateRecorder { sample_times, states: Vec::new(), events: Vec::new() };
    let Integrator { atol_angle_rad, atol_rate_rad_s, rtol, max_steps, .. } = *settings;
    let tolerances = Tolerances { atol_q: atol_angle_rad, atol_v: atol_rate_rad_s, rtol_v: rtol };
    let options = Options { tolerances, max_steps };
    let model = GripperModel::<N>::new(&scene.system);
    let start = initial_state::<N>(&scene.system);
    let end = integrate::<N, QUADRATURES, EVENT_FUNCTIONS, _, K, _>(
        &model,
        &options,
        0.0,
        start,
        scene.duration_s,
        &mut recorder,
    );
    assert!(end.result.is_ok(), "{:?}", end.result);
    (recorder, end)
}

pub fn run_reference<const N: usize>(scene: &Scene, sample_times: Vec<f64>) -> (StateRecorder<N>, End<N, QUADRATURES>) {
    run_with_method::<N, RadauOrRodas<N, QUADRATURES>>(scene, &Integrator::preset(Preset::Reference), sample_times)
}

pub fn run_engineering<const N: usize>(
    scene: &Scene,
    sample_times: Vec<f64>,
) -> (StateRecorder<N>, End<N, QUADRATURES>) {
    run_with_method::<N, Rodas5p<N, QUADRATURES>>(scene, &Integrator::preset(Preset::Engineering), sample_times)
}

/// Largest difference between the found states and the reference states: angles in rad, positions in object radii.
pub fn max_error<const N: usize>(case: &ReferenceCase, actual: &[State<N, QUADRATURES>]) -> f64 {
    assert_eq!(actual.len(), case.states.len(), "{}", case.name);
    let radius = max_radius(&case.scene.system.grasped().shape);
    let scale = |coordinate: usize| if coordinate == 4 || coordinate == 5 { 1.0 / radius } else { 1.0 };
    let state_error = |(actual, expected): (&State<N, QUADRATURES>, &[f64; 7])| {
        (0..N.min(7)).map(|i| scale(i) * (actual.q[i] - expected[i]).abs()).fold(0.0, f64::max)
    };
    actual.iter().zip(case.states.iter().map(|state| &state.q)).map(state_error).fold(0.0, f64::max)
}

/// Asserts that the normal impulses of phalanges, palm and table agree with the reference.
#[track_caller]
pub fn assert_impulses<const N: usize>(case: &ReferenceCase, end: &End<N, QUADRATURES>) {
    for (contact, expected) in [0, 1, 3, 4, 6, 7].into_iter().zip(case.impulse) {
        let impulse = end.state.z[contact];
        assert!(
            (impulse - expected).abs() < 1e-6 * expected.max(1e-3),
            "{}: contact {contact}: impulse {impulse}, expected {expected}",
            case.name
        );
    }
}

pub fn sample_times(case: &ReferenceCase) -> Vec<f64> {
    case.states.iter().map(|state| state.time_s).collect()
}

#[test]
fn reference_preset_agrees_with_an_independent_program() {
    for case in cases_at_rest() {
        let (samples, end) = run_reference::<7>(&case.scene, sample_times(&case));
        let max_error = max_error(&case, &samples.states);
        assert!(max_error < 2e-9, "{}: {max_error:.1e}", case.name);
        for (contact, expected) in [0, 1, 3, 4].into_iter().zip(case.first_contact_s) {
            let first = samples
                .events
                .iter()
                .find(|(_, at, is_active)| *at == contact && *is_active)
                .expect("a first contact")
                .0;
            assert!(
                (first - expected).abs() < 1e-10,
                "{}: contact {contact} at {first} s, expected {expected} s",
                case.name
            );
        }
        assert_impulses(&case, &end);
    }
}

#[test]
fn engineering_preset_is_close_to_the_independent_program() {
    for (letter, bound) in [("a", 2e-7), ("b", 2e-7), ("c", 2e-5), ("f", 3e-6), ("i", 2e-7)] {
        let case = reference_case(letter);
        let (samples, _) = run_engineering::<7>(&case.scene, sample_times(&case));
        let max_error = max_error(&case, &samples.states);
        assert!(max_error < bound, "{}: {max_error:.1e}", case.name);
    }
}

/// Symmetry of the fingers is only limited by rounding of the object position.
#[test]
fn a_symmetric_gripper_stays_symmetric() {
    for letter in ["a", "b", "i"] {
        let (samples, end) = run_engineering::<7>(&reference_case(letter).scene, Vec::new());
        let q = end.state.q;
        let asymmetry = (q[0] - q[2]).abs().max((q[1] - q[3]).abs()).max(q[6].abs());
        assert!(
            asymmetry < 1e-10 && q[4].abs() < 1e-12,
            "{letter}: asymmetry {asymmetry:.1e} rad, lateral offset {:.1e} m",
            q[4]
        );
        assert!(
            samples.events.iter().any(|(_, contact, _)| *contact == 1),
            "{letter}: no contact at the distal phalanx"
        );
    }
}

fn with_fixed_object(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.system.grasped_mut().motion = DiscMotion::Fixed;
    scene
}

/// With a fixed object, each finger moves as in a scene of one finger; the left finger as its mirror image.
#[test]
fn each_finger_on_a_fixed_object_matches_its_single_finger_scene() {
    let case = reference_case("c");
    let (_, end) = run_reference::<4>(&with_fixed_object(&case.scene), Vec::new());
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        let finger = &case.scene.system.fingers[side];
        let mut scene = crate::support::runs::experiment_95();
        (scene.finger_mut().linkage, scene.finger_mut().spring, scene.finger_mut().limit) =
            (finger.linkage, finger.spring, finger.limit);
        (scene.finger_mut().contact, scene.finger_mut().initial, scene.finger_mut().motor.actuation) =
            (finger.contact, finger.initial, finger.motor.actuation.clone());
        scene.duration_s = case.scene.duration_s;
        scene.system.gravity_m_s2 = case.scene.system.gravity_m_s2;
        let [x, y] = case.scene.system.grasped().centre_m;
        scene.system.discs = vec![Disc::fixed_object(PlacedShape::disc(
            max_radius(&case.scene.system.grasped().shape),
            [sign * x - 0.5 * case.scene.system.palm_width_m, y],
        ))];
        scene.integrator = Integrator::preset(Preset::Reference);
        let single = phalanx::trace::run_analytic(&scene, &mut ()).expect("a run").last;
        let error = (end.state.q[2 * side] - single.finger(0).q11_rad)
            .abs()
            .max((end.state.q[2 * side + 1] - single.finger(0).q21_rad).abs());
        assert!(error < 1e-10, "finger {side}: {error:.1e} rad");
    }
}

#[test]
fn a_heavy_object_converges_to_a_fixed_object() {
    let case = reference_case("c");
    let mut scene = case.scene.clone();
    scene.system.gravity_m_s2 = [0.0; 2];
    let fixed = run_reference::<4>(&with_fixed_object(&scene), Vec::new()).1.state.q;
    let mut last = f64::INFINITY;
    for factor in [1e3, 1e6] {
        let DiscMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut scene.system.grasped_mut().motion else {
            panic!("the object is fixed")
        };
        (*mass_kg, *inertia_kg_m2) = (0.0537840662 * factor, Some(1.0756813e-5 * factor));
        let heavy = run_reference::<7>(&scene, Vec::new()).1.state.q;
        let error = (0..4).map(|i| (heavy[i] - fixed[i]).abs()).fold(0.0, f64::max);
        assert!(error < 0.02 * last, "mass times {factor:e}: error {error:.1e} rad");
        last = error;
    }
    assert!(last < 1e-4, "{last:.1e}");
}

/// Energy is dissipated only by dampers and friction.
#[test]
fn energy_balances_in_contacts_and_motors() {
    for case in cases_at_rest() {
        let model = GripperModel::<7>::new(&case.scene.system);
        let before = initial_state::<7>(&case.scene.system);
        let (_, end) = run_reference::<7>(&case.scene, Vec::new());
        let stored = |state: &State<7, QUADRATURES>| {
            let energies = model.energies(&state.q, &state.v);
            energies.kinetic + energies.gravity + energies.spring
        };
        let (contact, motors) = (end.state.z[CONTACTS], end.state.z[CONTACTS + 1]);
        let balance = stored(&end.state) - stored(&before) - contact - motors;
        assert!(balance.abs() < 1e-9, "{}: {balance:.1e} J", case.name);
        assert!(contact < 0.0 && motors > 0.1, "{}: {contact} J in contacts, {motors} J of motors", case.name);
    }
}

/// Force on the object and moment about its centre, summed over all contacts, and the sum of the magnitudes of all
/// contact forces. The contact readings give the opposite forces.
fn contact_wrench(model: &GripperModel<7>, state: &State<7, QUADRATURES>, mode: &GripperMode) -> ([f64; 3], f64) {
    let (mut sum, mut force_sum) = ([0.0; 3], 0.0);
    for index in (0..CONTACTS).filter(|contact| !GripperContact::ALL[*contact].is_stop()) {
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

/// Integrates the contact forces on the object by Simpson's rule over every step, and compares them with its
/// acceleration.
struct MomentumBalance<'a> {
    model: &'a GripperModel<7>,
    transferred: [f64; 3],
    /// Time integral of the magnitudes of all contact forces, N·s.
    impulse_scale: f64,
    /// Largest difference between mass times acceleration and the forces, N.
    error: f64,
    largest_force: f64,
    inertia: [f64; 3],
    weight: [f64; 3],
}

impl Observer<7, QUADRATURES, GripperMode> for MomentumBalance<'_> {
    fn step(
        &mut self,
        step: &Step<7, QUADRATURES>,
        mode: &GripperMode,
        tools: &mut dyn StepTools<7, QUADRATURES>,
    ) -> bool {
        let quadrature = [(0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)];
        for (node, weight) in quadrature {
            let state = match node {
                0.0 => *step.start,
                1.0 => *step.end,
                node => tools.resolve(node),
            };
            let (force, force_sum) = contact_wrench(self.model, &state, mode);
            let rates: Rates<7, QUADRATURES> = self.model.rates(step.t0 + node * step.h, &state.q, &state.v, mode);
            self.impulse_scale += weight * step.h * force_sum;
            self.largest_force = self.largest_force.max(force_sum);
            for (i, force) in force.into_iter().enumerate() {
                self.transferred[i] += weight * step.h * force;
                let inertial = self.inertia[i] * rates.a[4 + i] - self.weight[i];
                let lever = if i == 2 { 0.02 } else { 1.0 };
                self.error = self.error.max((inertial - force).abs() / lever);
            }
        }
        true
    }

    fn event(&mut self, _: f64, _: &State<7, QUADRATURES>, _: usize, _: &GripperMode) {}
}

/// The impulse of contacts and gravity equals the change of the momentum and angular momentum of the object.
#[test]
fn momentum_of_the_object_balances() {
    for case in cases_at_rest() {
        let model = GripperModel::<7>::new(&case.scene.system);
        let DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), .. } = case.scene.system.grasped().motion
        else {
            panic!("the object is fixed")
        };
        let [gx, gy] = case.scene.system.gravity_m_s2;
        let (inertia, weight) = ([mass_kg, mass_kg, inertia_kg_m2], [mass_kg * gx, mass_kg * gy, 0.0]);
        let mut balance = MomentumBalance {
            model: &model,
            transferred: [0.0; 3],
            impulse_scale: 0.0,
            error: 0.0,
            largest_force: 0.0,
            inertia,
            weight,
        };
        let Integrator { atol_angle_rad, atol_rate_rad_s, rtol, max_steps, .. } = Integrator::preset(Preset::Reference);
        let tolerances = Tolerances { atol_q: atol_angle_rad, atol_v: atol_rate_rad_s, rtol_v: rtol };
        let options = Options { tolerances, max_steps };
        let (before, duration_s) = (initial_state::<7>(&case.scene.system), case.scene.duration_s);
        let end = integrate::<7, QUADRATURES, EVENT_FUNCTIONS, _, RadauOrRodas<7, QUADRATURES>, _>(
            &model,
            &options,
            0.0,
            before,
            duration_s,
            &mut balance,
        );
        // Instantaneous balance, to rounding.
        assert!(
            balance.error < 1e-12 * balance.largest_force,
            "{}: {:.1e} of {:.1e} N",
            case.name,
            balance.error,
            balance.largest_force
        );
        // Balance over the run, limited by the error of Simpson's rule in impacts.
        for i in 0..3 {
            let momentum_change = inertia[i] * (end.state.v[4 + i] - before.v[4 + i]) - weight[i] * duration_s;
            let error = (momentum_change - balance.transferred[i]).abs();
            let impulse_scale = balance.impulse_scale * if i == 2 { 0.02 } else { 1.0 };
            assert!(
                error < 1e-5 * impulse_scale,
                "{}: {i}: momentum change {momentum_change:e}, impulse {:e}, scale {impulse_scale:e}",
                case.name,
                balance.transferred[i]
            );
        }
    }
}

/// Compares every entry of the Jacobian with central differences, with all contacts active.
#[test]
fn jacobian_matches_central_differences() {
    for letter in ["c", "f", "i"] {
        let mut scene = reference_case(letter).scene;
        scene.system.fingers[0].spring.as_mut().expect("a spring").kind =
            phalanx::gripper::SpringKind::Torsional { stiffness_n_m_per_rad: 0.08, preload_rad: 1.0 };
        scene.system.table.iter_mut().for_each(|table| table.level_m = 0.0399);
        scene
            .system
            .differential
            .iter_mut()
            .for_each(|differential| differential.motor.no_load_speed_rad_s = Some(300.0));
        let model = GripperModel::<7>::new(&scene.system);
        let mut mode = GripperMode::FREE;
        mode.contacts = [ContactState::Active; CONTACTS];
        // Both fingers are in contact with an object off centre; contacts with negative gaps have forces.
        let q = [0.08, 1.22, 0.11, 1.31, 1e-3, 0.01998, 0.02];
        let v = [12.0, -7.0, 9.0, 5.0, 0.3, -0.2, 4.0];
        let exact: Linearised<7, QUADRATURES> = model.linearise(1e-3, &q, &v, &mode);
        let outputs = |q: &[f64; 7], v: &[f64; 7]| {
            let rates: Rates<7, QUADRATURES> = model.rates(1e-3, q, v, &mode);
            let mut all = [0.0; 7 + QUADRATURES];
            all[..7].copy_from_slice(&rates.a);
            all[7..].copy_from_slice(&rates.g);
            all
        };
        let active_contacts =
            (0..CONTACTS).filter(|index| model.contact_reading(&q, &v, *index, ContactState::Active).is_some());
        assert!(active_contacts.count() >= 7);
        for j in 0..7 {
            for (rows, is_rate) in [((&exact.a_q, &exact.g_q), false), ((&exact.a_v, &exact.g_v), true)] {
                let shifted_outputs = |h: f64| {
                    let (mut q, mut v) = (q, v);
                    if is_rate {
                        v[j] += h
                    } else {
                        q[j] += h
                    }
                    outputs(&q, &v)
                };
                // Central differences of fourth order.
                let h = if is_rate { 1e-3 } else { if j == 4 || j == 5 { 2e-7 } else { 5e-6 } };
                let (near, far): ([_; 2], [_; 2]) =
                    ([shifted_outputs(h), shifted_outputs(-h)], [shifted_outputs(2.0 * h), shifted_outputs(-2.0 * h)]);
                for i in 0..7 + QUADRATURES {
                    let difference = (8.0 * (near[0][i] - near[1][i]) - (far[0][i] - far[1][i])) / (12.0 * h);
                    let entry = if i < 7 { rows.0[i][j] } else { rows.1[i - 7][j] };
                    let row = if i < 7 { &rows.0[i] } else { &rows.1[i - 7] };
                    let scale = row.iter().fold(0.0f64, |largest, entry| largest.max(entry.abs()));
                    assert!(
                        (entry - difference).abs() <= 1e-6 * scale,
                        "{letter}: output {i} by {} {j}: {entry:e}, by central differences {difference:e}",
                        if is_rate { "rate" } else { "coordinate" }
                    );
                }
            }
        }
    }
}

/// Readings of the left phalanges are in the palm frame: mirrored, with the opposite normal direction.
#[test]
fn contact_readings_are_in_the_palm_frame() {
    let case = reference_case("a");
    let model = GripperModel::<7>::new(&case.scene.system);
    let (_, end) = run_reference::<7>(&case.scene, Vec::new());
    let reading = |side, contact| {
        let index = GripperContact::Finger(side, contact).index();
        model.contact_reading(&end.state.q, &end.state.v, index, analytic::ContactState::Active).expect("a contact")
    };
    for contact in [FingerContact::Proximal, FingerContact::Distal] {
        let [right, left] = phalanx::scene::Side::BOTH.map(|side| reading(side, contact));
        assert!(right.normal > 1.0, "{contact:?} has no force");
        assert!((right.geometry.point[0] + left.geometry.point[0]).abs() < 1e-9, "{contact:?}: points");
        assert!((right.geometry.normal[0] + left.geometry.normal[0]).abs() < 1e-7, "{contact:?}: normals");
        let towards = |reading: &analytic::ContactReading| {
            let [x, y] = reading.geometry.point;
            let [cx, cy] = [end.state.q[4], end.state.q[5]];
            reading.geometry.normal[0] * (x - cx) + reading.geometry.normal[1] * (y - cy)
        };
        for reading in [&right, &left] {
            assert!(
                (towards(reading) - 0.02).abs() < 1e-5,
                "{contact:?}: the normal points from the object to the phalanx"
            );
        }
    }
}
