//! Grippers in the analytic model of mechanisms against an independent program (with stiction and a moving palm too),
//! against the model of one finger, and against conservation laws.

use phalanx::analytic::mechanism::{MechanismMode, MechanismModel};
use phalanx::gripper::FingerContact;
use phalanx::integrator::{Dynamic, End, Observer, Rates, State, Step, StepTools, SwitchedMethod, System, integrate};
use phalanx::mechanism::assemble;
use phalanx::scene::{Hand, HandContact, Object, ObjectMotion, Scene, Side};
use phalanx::shape::{PlacedShape, max_radius};
use phalanx::trace::{ContactSample, Model, Outcome, run};

use crate::support::reference_cases::{ReferenceCase, cases_at_rest, reference_case};
use crate::support::runs::{
    CollectSink, PHALANGES, assert_below, engineering_settings, experiment_95_with, options, reference_settings,
    run_to_end, with_reference_settings,
};

/// Contacts with a reference impulse, in the order of the reference cases.
fn surfaces() -> impl Iterator<Item = HandContact> {
    HandContact::ALL.into_iter().filter(|contact| !contact.is_stop())
}

/// Largest difference between a run and the reference states: angles in rad, positions in object radii.
fn max_error(case: &ReferenceCase, log: &CollectSink) -> f64 {
    let radius = max_radius(&case.scene.hand.grasped().shape);
    let errors = case.states.iter().flat_map(|expected| {
        let sample = log.nearest_sample(expected.time_s);
        assert_below((sample.time_s - expected.time_s).abs(), 1e-12, &case.name);
        let ([right, left], body) = ([0, 1].map(|finger| sample.finger(finger)), sample.body(0));
        let [x, y] = body.centre_m;
        let found = [right.q11_rad, right.q21_rad, left.q11_rad, left.q21_rad, x, y, body.angle_rad];
        let scale = |coordinate: usize| if coordinate == 4 || coordinate == 5 { 1.0 / radius } else { 1.0 };
        (0..7).map(move |i| scale(i) * (found[i] - expected.q[i]).abs())
    });
    errors.fold(0.0, f64::max)
}

/// Compares both presets with the independent program: states, and normal impulses of phalanges, palm and table. Returns
/// the run with the reference preset.
fn assert_agrees_with_program(case: &ReferenceCase, engineering_bound: f64) -> CollectSink {
    let [(reference, log), (_, engineering)] = [reference_settings(), engineering_settings()].map(|integrator| {
        let mut scene = Scene { integrator, ..case.scene.clone() };
        // All reference states are at multiples of 1 ms.
        scene.log.numeric_hz = 1e3;
        run_to_end(&scene)
    });
    let name = &case.name;
    assert_below(max_error(case, &log), 2e-9, name);
    assert_below(max_error(case, &engineering), engineering_bound, name);
    for (contact, expected) in surfaces().zip(case.impulse) {
        let error = (reference.last.hand_contact(&case.scene.hand, contact).impulse_n_s - expected).abs();
        assert_below(error, 1e-6 * expected.max(1e-3), format!("{name}: impulse of {contact:?}"));
    }
    log
}

#[test]
fn presets_agree_with_an_independent_program() {
    for (letter, engineering_bound) in [("a", 2e-7), ("b", 2e-7), ("c", 2e-5), ("f", 3e-6), ("i", 2e-7)] {
        let case = reference_case(letter);
        let log = assert_agrees_with_program(&case, engineering_bound);
        for (contact, expected) in case.first_contact_s.into_iter().enumerate() {
            let first_s = log.first_contact_s(contact).expect("a first contact");
            assert_below((first_s - expected).abs(), 1e-10, format!("{}: contact {contact} at {first_s} s", case.name));
        }
    }
    for (letter, engineering_bound) in [("d", 2e-7), ("e", 2e-7), ("g", 5e-7), ("h", 5e-7)] {
        assert_agrees_with_program(&reference_case(letter), engineering_bound);
    }
}

/// The kernel of a hand.
pub(super) fn kernel(hand: &Hand) -> MechanismModel {
    let mechanism = hand.mechanism().expect("closed loops");
    let start = assemble(&mechanism).expect("an assembled hand");
    MechanismModel::new(&mechanism, (&start.poses, &start.rates)).expect("dyads")
}

/// Integrates a gripper from its start to the end of its scene, with the reference preset.
fn integrate_scene(
    model: &MechanismModel,
    scene: &Scene,
    observer: &mut impl Observer<Dynamic, MechanismMode>,
) -> End<Dynamic> {
    let options = options(&reference_settings());
    let end =
        integrate::<_, SwitchedMethod<Dynamic>, _>(model, &options, 0.0, model.start(), scene.duration_s, observer);
    assert!(end.result.is_ok(), "{}: {:?}", scene.name, end.result);
    end
}

#[test]
fn bristles_agree_with_an_independent_program_and_time_is_exact() {
    for letter in ["d", "e", "g", "h"] {
        let case = reference_case(letter);
        let (hand, name) = (&case.scene.hand, &case.name);
        let model = kernel(hand);
        let State { q, v, .. } = integrate_scene(&model, &case.scene, &mut ()).state;
        // Time is the only coordinate with a rate of 1 at the start.
        let time = model.start().v.iter().position(|rate| *rate == 1.0);
        assert_eq!(time.is_some(), hand.palm_motion.is_some(), "{name}");
        time.into_iter().for_each(|time| assert_below((q[time] - case.scene.duration_s).abs(), 1e-14, name));
        if !hand.has_stiction() {
            continue;
        }
        // Bristle states follow the coordinates: those of the contacts, then those of both brakes. Case g has neither a
        // table nor brakes.
        let states = &v[7 + usize::from(time.is_some())..];
        let bristles = if hand.table.is_some() { 8 } else { 5 };
        // The deflection is σ times the relaxation time.
        let relaxation_s = [1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 2e-4, 2e-4];
        for index in 0..bristles {
            // The program sees the left finger in its mirror image, where the direction of slip is the opposite.
            let sign = if matches!(index, 2 | 3) { -1.0 } else { 1.0 };
            let (deflection, expected) = (sign * relaxation_s[index] * states[index], case.bristle_deflection[index]);
            let error = (deflection - expected).abs();
            assert_below(error, 1e-6 * expected.abs() + 1e-14, format!("{name}: bristle {index}"));
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

/// Symmetry of the fingers is limited by rounding, since the angles of left links are π minus those of right ones. A stiff
/// limit turns the last bit of an angle into 1e-8 of the acceleration, which steps of the engineering preset accumulate;
/// the difference is far below the allowed error of that preset. Readings of the left phalanges are in the palm frame:
/// mirrored, with the opposite normal direction.
#[test]
fn a_symmetric_gripper_stays_symmetric() {
    for letter in ["a", "b", "i"] {
        let scene = reference_case(letter).scene;
        let presets = [(reference_settings(), 1e-12, 1e-14), (engineering_settings(), 5e-8, 5e-10)];
        let [(Outcome { last, .. }, log), _] = presets.map(|(integrator, angle_rad, x_m)| {
            let (outcome, log) = run_to_end(&Scene { integrator, ..scene.clone() });
            for sample in &log.samples {
                let ([right, left], body) = ([0, 1].map(|finger| sample.finger(finger)), sample.body(0));
                let differences = [right.q11_rad - left.q11_rad, right.q21_rad - left.q21_rad, body.angle_rad];
                let context = format!("{letter} at {} s", sample.time_s);
                assert_below(differences.into_iter().map(f64::abs).fold(0.0, f64::max), angle_rad, &context);
                assert_below(body.centre_m[0].abs(), x_m, &context);
            }
            (outcome, log)
        });
        assert!(log.first_contact_s(FingerContact::Distal as usize).is_some(), "{letter}: no distal contact");
        for contact in PHALANGES {
            let context = format!("{letter} {contact:?}");
            let reading = |side| last.hand_contact(&scene.hand, HandContact::Finger(side, contact));
            let [right, left] = Side::BOTH.map(reading);
            assert!(right.normal_n > 1.0, "{context} has no force");
            assert_below((right.point_m[0] + left.point_m[0]).abs(), 1e-9, &context);
            assert_below((right.normal[0] + left.normal[0]).abs(), 1e-7, &context);
            for ContactSample { point_m: [x, y], normal, .. } in [right, left] {
                // The normal points from the object to the phalanx.
                let [object_x, object_y] = last.body(0).centre_m;
                let distance = normal[0] * (x - object_x) + normal[1] * (y - object_y);
                assert_below((distance - 0.02).abs(), 1e-5, &context);
            }
        }
    }
}

fn with_fixed_object(mut scene: Scene) -> Scene {
    scene.hand.grasped_mut().motion = ObjectMotion::Fixed;
    scene
}

/// Final q11 and q21 of both fingers with the reference preset.
fn end_angles(scene: &Scene) -> [[f64; 2]; 2] {
    let last = run_to_end(&with_reference_settings(scene)).0.last;
    [0, 1].map(|index| last.finger(index)).map(|finger| [finger.q11_rad, finger.q21_rad])
}

/// With a fixed object, each finger moves as in a scene of one finger, whose kernel is a closed form; the left finger as
/// its mirror image.
#[test]
fn each_finger_on_a_fixed_object_matches_its_single_finger_scene() {
    let scene = reference_case("c").scene;
    let angles = end_angles(&with_fixed_object(scene.clone()));
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
        let [q11, q21] = angles[side];
        let error = (q11 - finger.q11_rad).abs().max((q21 - finger.q21_rad).abs());
        assert_below(error, 1e-12, format!("finger {side}"));
    }
}

#[test]
fn a_heavy_object_converges_to_a_fixed_object() {
    let mut scene = reference_case("c").scene;
    scene.hand.gravity_m_s2 = [0.0; 2];
    let fixed = end_angles(&with_fixed_object(scene.clone()));
    let mut last = f64::INFINITY;
    for factor in [1e3, 1e6] {
        let (mass_kg, inertia_kg_m2) = (0.0537840662 * factor, 1.0756813e-5 * factor);
        scene.hand.grasped_mut().motion =
            ObjectMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s: [0.0; 2], spin_rad_s: 0.0 };
        let pairs = end_angles(&scene).into_iter().flatten().zip(fixed.into_iter().flatten());
        let error = pairs.map(|(heavy, fixed)| (heavy - fixed).abs()).fold(0.0, f64::max);
        assert_below(error, 0.02 * last, format!("mass times {factor:e}"));
        last = error;
    }
    assert_below(last, 1e-4, "mass times 1e6");
}

/// The energy supplied by motors and palm equals the change of mechanical energy plus the losses in contacts and
/// brakes.
#[test]
fn energy_balances() {
    for case in cases_at_rest().into_iter().chain(["d", "e"].map(reference_case)) {
        let (outcome, log) = run_to_end(&with_reference_settings(&case.scene));
        let errors = log.samples.iter().map(|sample| sample.energy().balance_j.abs());
        assert_below(errors.fold(0.0, f64::max), 1e-10, &case.name);
        let energy = outcome.last.energy();
        assert!(energy.dissipated_j > 0.0 && energy.motor_work_j > 0.1, "{}: {energy:?}", case.name);
    }
}

/// First coordinate of the object, after those of the fingers.
const OBJECT: usize = 4;

/// Unit of the three components of a wrench on the object, relative to a force: 1, and the lever of moments, m.
const WRENCH_SCALE: [f64; 3] = [1.0, 1.0, 0.02];

/// Integrates the contact forces on the object by Simpson's rule over every step, and compares them with its
/// acceleration.
struct MomentumBalance<'a> {
    model: &'a MechanismModel,
    /// Number of contacts between surfaces, which come first.
    surfaces: usize,
    inertia: [f64; 3],
    weight: [f64; 3],
    transferred: [f64; 3],
    /// Time integral of the magnitudes of all contact forces, N·s.
    impulse_scale: f64,
    /// Largest difference between mass times acceleration and the forces at the start and the middle of the steps, N.
    error: f64,
    largest_force: f64,
}

impl MomentumBalance<'_> {
    /// Force on the object and moment about its centre, summed over all contacts, and the sum of the magnitudes of all
    /// contact forces. The contact readings give the opposite forces.
    fn contact_wrench(&self, state: &State<Dynamic>, mode: &MechanismMode) -> ([f64; 3], f64) {
        let (mut sum, mut force_sum) = ([0.0; 3], 0.0);
        for index in 0..self.surfaces {
            let reading = self.model.contact_reading((&state.q, &state.v), index, mode[index]);
            let ([nx, ny], [px, py]) = (reading.geometry.normal, reading.geometry.point);
            let force =
                [-reading.normal * nx + reading.tangential * ny, -reading.normal * ny - reading.tangential * nx];
            let lever = [px - state.q[OBJECT], py - state.q[OBJECT + 1]];
            sum[0] += force[0];
            sum[1] += force[1];
            sum[2] += lever[0] * force[1] - lever[1] * force[0];
            force_sum += force[0].hypot(force[1]);
        }
        (sum, force_sum)
    }
}

impl Observer<Dynamic, MechanismMode> for MomentumBalance<'_> {
    fn step(&mut self, step: &Step<Dynamic>, mode: &MechanismMode, tools: &mut dyn StepTools<Dynamic>) -> bool {
        let middle = tools.resolve(0.5).clone();
        for (node, state, weight) in [(0.0, step.start, 1.0), (0.5, &middle, 4.0), (1.0, step.end, 1.0)] {
            let (force, force_sum) = self.contact_wrench(state, mode);
            let mut rates = Rates::zero(self.model.sizes());
            self.model.rates(step.t0 + node * step.h, &state.q, &state.v, mode, &mut rates);
            self.impulse_scale += weight / 6.0 * step.h * force_sum;
            self.largest_force = self.largest_force.max(force_sum);
            for i in 0..3 {
                self.transferred[i] += weight / 6.0 * step.h * force[i];
                // At its end, a step can be on a branch or a feature that the readings are already beyond.
                if node < 1.0 {
                    let inertial = self.inertia[i] * rates.a[OBJECT + i] - self.weight[i];
                    self.error = self.error.max((inertial - force[i]).abs() / WRENCH_SCALE[i]);
                }
            }
        }
        true
    }

    fn event(&mut self, _: f64, _: &State<Dynamic>, _: usize, _: &MechanismMode) {}
}

/// The impulse of contacts and gravity equals the change of the momentum and angular momentum of the object.
#[test]
fn momentum_of_the_object_balances() {
    for case in cases_at_rest() {
        let (Scene { hand, duration_s, .. }, name) = (&case.scene, &case.name);
        let model = kernel(hand);
        let ObjectMotion::Free { mass_kg, inertia_kg_m2, .. } = hand.grasped().motion else {
            panic!("the object is fixed")
        };
        let before = model.start();
        let [x, y] = hand.grasped().centre_m;
        assert_eq!(before.q[OBJECT..][..3], [x, y, hand.grasped().angle_rad], "{name}");
        let [gx, gy] = hand.gravity_m_s2;
        let (inertia, weight) = ([mass_kg, mass_kg, inertia_kg_m2], [mass_kg * gx, mass_kg * gy, 0.0]);
        let surfaces = surfaces().filter(|contact| hand.contact_index(*contact).is_some()).count();
        let (transferred, impulse_scale, error, largest_force) = ([0.0; 3], 0.0, 0.0, 0.0);
        let mut balance = MomentumBalance {
            model: &model,
            surfaces,
            inertia,
            weight,
            transferred,
            impulse_scale,
            error,
            largest_force,
        };
        let end = integrate_scene(&model, &case.scene, &mut balance);
        // Instantaneous balance, to rounding.
        assert_below(balance.error, 1e-14 * balance.largest_force, name);
        // Balance over the run, limited by the error of Simpson's rule in impacts.
        for i in 0..3 {
            let change = inertia[i] * (end.state.v[OBJECT + i] - before.v[OBJECT + i]) - weight[i] * duration_s;
            let error = (change - balance.transferred[i]).abs();
            assert_below(error, 1e-5 * balance.impulse_scale * WRENCH_SCALE[i], format!("{name}: component {i}"));
        }
    }
}
