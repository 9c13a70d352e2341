//! The analytic model of mechanisms: reference solutions, Jacobians, the five-bar as a mechanism against its
//! closed-form kernel, and random mechanisms.

use phalanx::analytic::mechanism::{DriveReading, MechanismMode, MechanismModel};
use phalanx::analytic::{ContactState, Energies, FingerMode, Model as FingerKernel, QUADRATURES};
use phalanx::drive::{Brake, Interpolation, Profile};
use phalanx::gripper::{Finger, FingerContact, Posture, close_loop};
use phalanx::integrator::{
    Dynamic, Fixed, Hybrid, Linearised, Method, Observer, Options, Radau5, Rates, State, Step, StepTools,
    SwitchedMethod, System, Tolerances, integrate_by,
};
use phalanx::law::{Bristle, FrictionKind, FrictionLaw};
use phalanx::mechanism::structure::{Closures, Group, Placement, find_groups, regroup};
use phalanx::mechanism::{
    self, ContactPair, ForcePoint, GearLoss, JointCombination, JointKind, Mechanism, OutlineId, PathElement,
    PrescribedMotion, Spring, SpringKind, Start, Tendon, TendonActuator, assemble,
};
use phalanx::scene::{Axis, Move, PalmMotion, Ramp, Scene, Vibration};

use super::jacobian::{Entry, Equations, Variable};
use crate::support::mechanism_cases::{MechanismCase, all_cases, cable_cases, drive_cases, mechanism_case};
use crate::support::random::Random;
use crate::support::runs::experiment_95;
use crate::support::scenes::loops::{on_moving_base, random_assur, with_start};
use crate::support::scenes::trees::random_mechanism;

/// Largest differences from a reference solution along all its samples, and the touch-downs.
#[derive(Debug, Default)]
pub(super) struct Difference {
    pub position_m: f64,
    pub angle_rad: f64,
    pub energy_j: f64,
    /// Of the efforts of actuators, N·m or N, and of their motor torques, currents, voltages and distances.
    pub effort: f64,
    pub drives: [f64; 4],
    /// Of the work that gears have lost.
    pub loss_j: f64,
    pub touches_s: Vec<f64>,
}

/// Work of contacts and of drives since the start.
fn work(model: &MechanismModel, state: &State<Dynamic>) -> f64 {
    let contacts = model.contact_count();
    state.z[contacts] + state.z[contacts + 1]
}

/// Compares every step of a run with a reference solution.
struct Comparison<'a> {
    model: &'a MechanismModel,
    case: &'a MechanismCase,
    next: usize,
    balance_j: Option<f64>,
    found: Difference,
}

impl Comparison<'_> {
    fn compare(&mut self, state: &State<Dynamic>, mode: &MechanismMode) {
        let sample = &self.case.samples[self.next];
        let (q, v) = (&state.q, &state.v);
        self.model.count_turns_as(mode);
        for (body, pose) in sample.poses.iter().enumerate() {
            let ([x, y, angle], _) = self.model.body((q, v), body);
            self.found.position_m = self.found.position_m.max((x - pose[0]).abs()).max((y - pose[1]).abs());
            self.found.angle_rad = self.found.angle_rad.max((angle - pose[2]).abs());
        }
        let energies = self.model.energies((q, v));
        let balance = energies.kinetic + energies.gravity + energies.spring - work(self.model, state);
        let start = *self.balance_j.get_or_insert(balance);
        self.found.energy_j = self.found.energy_j.max((balance - start).abs());
        let t = sample.time_s;
        // The effort jumps where the slope of a target does.
        if self.model.next_discontinuity(t - 1e-9) < t + 1e-9 {
            self.next += 1;
            return;
        }
        self.model.read_actuators(t, (q, v), mode, |index, effort| {
            if let Some(expected) = sample.actuators.get(index) {
                self.found.effort = self.found.effort.max((effort - expected).abs());
            }
        });
        let expected = sample.drives.iter().zip(&self.case.mechanism.actuators);
        let mut expected = expected.filter(|(_, actuator)| !actuator.powertrain.is_direct()).map(|(drive, _)| drive);
        let mut lost_j = 0.0;
        self.model.read_drives(t, (q, v), mode, |drives| {
            for (_, found) in drives {
                let DriveReading { torque_n_m, current_a, voltage_v, distance_m, loss_work, .. } = found;
                lost_j += loss_work.map_or(0.0, |work| state.z[work]);
                let numbers = [torque_n_m, current_a, voltage_v, distance_m];
                for (k, expected) in expected.next().expect("a drive").iter().enumerate() {
                    if !expected.is_nan() {
                        self.found.drives[k] = self.found.drives[k].max((numbers[k] - expected).abs());
                    }
                }
            }
        });
        let expected_j = sample.energies.get("gear_loss_work").copied().unwrap_or(0.0);
        self.found.loss_j = self.found.loss_j.max((lost_j + expected_j).abs());
        self.next += 1;
    }
}

impl Observer<Dynamic, MechanismMode> for Comparison<'_> {
    fn step(&mut self, step: &Step<Dynamic>, mode: &MechanismMode, tools: &mut dyn StepTools<Dynamic>) -> bool {
        while let Some(sample) = self.case.samples.get(self.next) {
            let theta = (sample.time_s - step.t0) / step.h;
            if theta > 1.0 + 1e-9 {
                break;
            }
            let state = if theta < 1.0 { tools.resolve(theta).clone() } else { step.end.clone() };
            self.compare(&state, mode);
        }
        true
    }

    fn event(&mut self, t: f64, _: &State<Dynamic>, index: usize, mode: &MechanismMode) {
        if mode[index].has_force() {
            self.found.touches_s.push(t);
        }
    }
}

pub(super) fn compare(
    case: &MechanismCase,
    method: fn(Dynamic) -> SwitchedMethod<Dynamic>,
    tolerances: Tolerances,
) -> Difference {
    let model = MechanismModel::new(&case.mechanism, (&case.start.poses, &case.start.rates)).expect("dyads");
    let mut comparison = Comparison { model: &model, case, next: 0, balance_j: None, found: Difference::default() };
    let options = Options { tolerances, max_steps: 1_000_000 };
    let (method, start) = (method(model.sizes()), model.start());
    let end = integrate_by(method, &model, &options, 0.0, start, case.duration_s, &mut comparison);
    end.result.unwrap_or_else(|failure| panic!("{}: {failure}", case.name));
    assert_eq!(comparison.next, case.samples.len(), "{}", case.name);
    comparison.found
}

pub(super) fn first_touches(case: &MechanismCase) -> impl Iterator<Item = f64> + '_ {
    case.events.iter().filter(|(_, name, rises)| name.ends_with("touch") && *rises).map(|(time, ..)| *time)
}

#[test]
fn reference_solutions_are_met_at_reference_tolerances() {
    let tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-9, rtol_v: 1e-11 };
    for case in all_cases().into_iter().chain(cable_cases()) {
        let found = compare(&case, Method::new, tolerances);
        let name = &case.name;
        assert!(found.position_m < 1e-8 && found.angle_rad < 1e-7, "{name}: {found:?}");
        for touch in first_touches(&case) {
            let nearest = found.touches_s.iter().map(|time| (time - touch).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9, "{name}: touch at {touch} s missed by {nearest:e} s");
        }
        assert!(found.energy_j < 1e-9, "{name}: {found:?}");
    }
}

#[test]
fn everyday_tolerances_are_accurate_to_1e_5() {
    let tolerances = Tolerances { atol_q: 3e-11, atol_v: 3e-7, rtol_v: 3e-7 };
    for case in all_cases().into_iter().chain(cable_cases()) {
        let found = compare(&case, SwitchedMethod::rodas, tolerances);
        assert!(found.position_m < 1e-6 && found.angle_rad < 1e-5, "{}: {found:?}", case.name);
    }
}

/// Published end values of Andrews' squeezer (IVP test set, 16 digits printed).
#[test]
fn andrews_squeezer_agrees_with_the_published_solution() {
    let case = mechanism_case("a_andrews");
    let model = MechanismModel::new(&case.mechanism, (&case.start.poses, &case.start.rates)).expect("dyads");
    let tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-9, rtol_v: 1e-12 };
    let options = Options { tolerances, max_steps: 1_000_000 };
    let method = Radau5::new(model.sizes());
    let end = integrate_by(method, &model, &options, 0.0, model.start(), 0.03, &mut ());
    let published: [(_, f64); 7] = [
        ("beta", 15.81077119629904),
        ("theta", -15.75637105984298),
        ("gamma", 0.04082224013073101),
        ("phi", -0.5347301163226948),
        ("delta", 0.5244099658805304),
        ("omega", 0.5347301163226948),
        ("epsilon", 1.048080741042263),
    ];
    let mut angles = Vec::new();
    model.read_joints((&end.state.q, &end.state.v), |_, (angle_rad, _)| angles.push(angle_rad));
    for (name, value) in published {
        let joint = case.mechanism.joints.iter().position(|joint| joint.name == name).expect("a joint");
        let found: f64 = angles[joint];
        assert!((found - value).abs() < 1e-9 * value.abs().max(1.0), "{name}: {found}, {value}");
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

/// States of a run, for tests of single states.
#[derive(Default)]
struct States(Vec<(f64, State<Dynamic>, MechanismMode)>);

impl Observer<Dynamic, MechanismMode> for States {
    fn step(&mut self, step: &Step<Dynamic>, mode: &MechanismMode, _: &mut dyn StepTools<Dynamic>) -> bool {
        self.0.push((step.t1, step.end.clone(), mode.clone()));
        true
    }

    fn event(&mut self, _: f64, _: &State<Dynamic>, _: usize, _: &MechanismMode) {}
}

#[test]
fn jacobians_match_differences_along_the_reference_cases() {
    let on_palm = ["c_f85_link_pad", "c_f85_two_disc", "d_tendon2", "b_swinging_slider"].map(on_a_moving_palm);
    // Within the steps of the differences, the laws of cables do not change their ranges.
    let wide = |mut case: MechanismCase| {
        let elements = case.mechanism.tendons.iter_mut().flat_map(|tendon| &mut tendon.path);
        for law in elements.filter_map(|element| element.friction.as_mut()) {
            (law.v_static_m_s, law.v_dynamic_m_s) = (3.0, 6.0);
            // The rate of a state that relaxes faster amplifies the rounding errors of speeds.
            if let FrictionKind::Bristle(bristle) = &mut law.kind {
                bristle.relaxation_s = 0.1;
            }
        }
        case
    };
    let cases = all_cases()
        .into_iter()
        .chain(drive_cases())
        .chain(cable_cases().into_iter().map(wide))
        .chain([with_all_components(), with_cable_friction()]);
    for case in cases.chain(on_palm) {
        check_jacobians(&case.name, (&case.mechanism, &case.start), case.duration_s);
    }
}

/// Four bodies without a dyad, with forces on the joints that Newton's method places, on the ground and on a moving body.
#[test]
fn jacobians_of_assur_groups_match_differences() {
    for seed in 0..8 {
        let (mut mechanism, crank, rate) = random_assur(seed);
        mechanism.gravity_m_s2 = [3.0, -8.0];
        for joint in &mut mechanism.joints {
            (joint.damping, joint.armature) = (1e-5, 1e-6);
        }
        let pins = mechanism.joints.iter().enumerate().filter(|(_, joint)| joint.kind == JointKind::Revolute);
        let terms = pins.map(|(index, _)| (index, 0.3 + 0.1 * index as f64)).collect();
        mechanism.springs.push(Spring {
            name: "torsion".to_string(),
            kind: SpringKind::Torsional { on: JointCombination { terms, offset: 0.0 }, preload: 0.0 },
            stiffness: 1e-3,
            damping: 1e-6,
            rest: 0.2,
        });
        mechanism.springs.push(Spring {
            name: "spring".to_string(),
            kind: SpringKind::Linear { bodies: [None, Some(1)], points_m: [[0.1, 0.3], [0.02, 0.01]] },
            stiffness: 5.0,
            damping: 0.01,
            rest: 0.1,
        });
        let fixed = with_start(&mechanism, 0, crank, 0.3 * rate);
        for mechanism in [on_moving_base(&fixed), fixed] {
            let start = assemble(&mechanism).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            check_jacobians(&format!("seed {seed}"), (&mechanism, &start), 0.02);
        }
    }
}

/// Compares the Jacobians of a mechanism with differences along its motion.
fn check_jacobians(name: &str, (mechanism, start): (&Mechanism, &Start), duration_s: f64) {
    let model = MechanismModel::new(mechanism, (&start.poses, &start.rates)).expect("coordinates");
    let mut states = States::default();
    let options = Options { tolerances: Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: 1e-5 }, max_steps: 1_000_000 };
    let (method, start) = (SwitchedMethod::rodas(model.sizes()), model.start());
    let end = integrate_by(method, &model, &options, 0.0, start, duration_s, &mut states);
    end.result.unwrap_or_else(|failure| panic!("{name}: {failure}"));
    let stride = states.0.len().div_ceil(40);
    for (t, state, mode) in states.0.into_iter().step_by(stride) {
        // Penetrations limit the differences of positions, slips those of rates.
        let active = (0..model.contact_count()).filter(|index| mode[*index].has_force());
        let depths = active.map(|index| model.contact_reading((&state.q, &state.v), index, mode[index]).delta);
        let depth = depths.fold(1e-2, f64::min);
        if depth < 1e-8 {
            continue;
        }
        let next = model.next_discontinuity(t - 2e-5);
        let time_step = if next < t + 2e-5 { 0.0 } else { 1e-5 };
        // The friction law changes over 1e-2 m/s.
        let rate_step = if depth < 1e-2 { 2e-5 } else { 1e-3 * (1.0 + largest(&state.v)) };
        let mut rates = vec![0.0; mechanism.joints.len()];
        model.count_turns_as(&mode);
        model.read_joints((&state.q, &state.v), |joint, (_, rate)| rates[joint] = rate);
        // The slope of the loss of a gear has a kink where it becomes constant.
        let at_kink = mechanism.actuators.iter().any(|actuator| {
            let from_kink = |loss: &GearLoss| actuator.on.sum(|joint| rates[joint]).abs() - loss.rate;
            actuator.powertrain.loss.is_some_and(|loss| from_kink(&loss).abs() < 2.0 * rate_step)
        });
        if at_kink {
            continue;
        }
        let steps = [time_step, 2e-3 * depth, rate_step];
        let equations = Equations { hand: &model, mode, t, q: state.q.clone(), v: state.v.clone() };
        let allowed = |entry: &Entry| {
            2e-5 * (entry.row_size + 1e-6 * entry.value.abs() / entry.h) + 1e-7 * entry.largest[1] * entry.h + 1e-7
        };
        let step = |variable: Variable| match variable {
            // Time as a coordinate moves surfaces at up to 1 m/s, with up to 100 m/s².
            Variable::Coordinate(index) if state.v[index] == 1.0 => (0.1 * time_step).min(steps[1]),
            _ => steps[variable.kind()],
        };
        equations.check(name, 4, step, allowed);
    }
}

/// Number of coordinates of the largest group of connected bodies.
fn largest_group(mechanism: &Mechanism) -> usize {
    let groups = find_groups(mechanism).expect("dyads");
    let is_free = |group: &Group| matches!(group.placements[..], [Placement::Free { .. }]);
    groups.iter().filter(|group| !is_free(group)).map(|group| group.coordinates.len()).max().unwrap_or(0)
}

#[test]
fn sizes_and_structure_of_the_reference_cases() {
    // Coordinates with a place for time, which a new input of an actuator may need; the model has them in units of 4.
    let sizes = [
        ("e_tendon3", 5, 3),
        ("a_andrews", 2, 1),
        ("b_swinging_slider", 3, 2),
        ("c_f85_link_pad", 3, 2),
        ("c_f85_two_disc", 8, 2),
    ];
    for (name, coordinates, group) in sizes {
        let case = mechanism_case(name);
        let model = MechanismModel::new(&case.mechanism, (&case.start.poses, &case.start.rates)).expect("dyads");
        let found = (model.sizes().coordinates, largest_group(&case.mechanism));
        assert_eq!(found, (usize::next_multiple_of(coordinates, 4), group), "{name}");
    }
}

#[test]
fn loops_beyond_dyads_are_refused_by_name() {
    let mut case = mechanism_case("b_four_bar");
    // A brace from the ground to the coupler makes the four-bar rigid.
    let mut brace = case.mechanism.joints[0].clone();
    (brace.name, brace.bodies) = ("brace".to_string(), [None, Some(1)]);
    case.mechanism.joints.push(brace);
    let start = (&case.start.poses[..], &case.start.rates[..]);
    let error = MechanismModel::new(&case.mechanism, start).unwrap_err().to_string();
    assert!(error.contains("no row of dyads") || error.contains("can move"), "{error}");
}

/// Without a row of dyads, four bodies are left beside the one with the coordinate; all five if the coordinate is that of a
/// joint between two of them.
#[test]
fn six_bars_on_their_long_side_leave_an_assur_group() {
    for seed in 0..4 {
        let (mechanism, ..) = random_assur(seed);
        let [group] = &find_groups(&mechanism).expect("a group")[..] else { panic!("one group") };
        let sizes = |placement: &Placement| match placement {
            Placement::Joint { .. } => [1, 0, 0],
            Placement::Assur { tree, known, closing } => {
                [tree.len(), closing.len(), known.iter().filter(|index| index.is_some()).count()]
            }
            other => panic!("{other:?}"),
        };
        let found = |group: &Group| group.placements.iter().map(sizes).collect::<Vec<_>>();
        assert_eq!((found(group), group.count_of_dyads()), (vec![[1, 0, 0], [4, 2, 0]], 2), "seed {seed}");
        let accepts = |placement: &Placement| match placement {
            Placement::Assur { known, .. } => known.iter().any(Option::is_some),
            _ => true,
        };
        assert_eq!(regroup(&mechanism, group, Closures::Dyads, &|_| true), None, "seed {seed}");
        let inner = regroup(&mechanism, group, Closures::All, &accepts).expect("an inner joint");
        assert_eq!(found(&inner), [[5, 2, 1]], "seed {seed}");
    }
}

#[test]
fn assur_groups_with_bodies_that_do_not_rotate_are_refused_by_name() {
    let (mut mechanism, ..) = random_assur(0);
    mechanism.bodies[0].inertia_kg_m2 = f64::INFINITY;
    let error = find_groups(&mechanism).expect_err("a body that does not rotate").to_string();
    assert!(error.contains("no row of dyads") && error.contains("wrist"), "{error}");
}

/// The five-bar of a finger that closes on a fixed disc, with what the model supports: on a fixed disc, forces act on the
/// surface of the face, and the torque of a constant spring does not depend on the offset of its coordinate.
fn five_bar(scene: &Scene) -> Mechanism {
    let mut mechanism = scene.mechanism().expect("a closed loop").into_owned();
    mechanism.contacts.iter_mut().for_each(|contact| contact.force_point = ForcePoint::Face);
    let mechanism::SpringKind::Torsional { on, .. } = &mut mechanism.springs[0].kind else {
        panic!("a torsional spring")
    };
    on.offset = 0.0;
    mechanism
}

type FingerLayout = Fixed<2, QUADRATURES>;

/// Observer of the kernel of one finger.
#[derive(Default)]
struct Closing(Vec<(f64, State<FingerLayout>, FingerMode)>);

impl Observer<FingerLayout, FingerMode> for Closing {
    fn step(&mut self, step: &Step<FingerLayout>, mode: &FingerMode, _: &mut dyn StepTools<FingerLayout>) -> bool {
        self.0.push((step.t1, step.end.clone(), *mode));
        true
    }

    fn event(&mut self, _: f64, _: &State<FingerLayout>, _: usize, _: &FingerMode) {}
}

/// Accelerations and joint forces of the five-bar as a mechanism equal those of its closed form, along closings of
/// random designs on a disc.
#[test]
fn the_five_bar_as_a_mechanism_equals_its_closed_form() {
    let mut random = Random::for_seed(40);
    let (mut designs, mut states) = (0, 0);
    while designs < 200 {
        let mut scene = experiment_95();
        let finger = scene.finger_mut();
        let lengths = &mut finger.linkage.lengths;
        for length in [&mut lengths.l11_m, &mut lengths.l12_m, &mut lengths.l21_m, &mut lengths.l22_m] {
            *length *= random.within(0.93, 1.07);
        }
        let bodies = &mut finger.linkage.bodies;
        for body in [&mut bodies.l11, &mut bodies.l12, &mut bodies.l21, &mut bodies.l22] {
            body.mass_kg *= random.log_within(0.3, 3.0);
            body.inertia_kg_m2 *= random.log_within(0.3, 3.0);
            body.com_m = body.com_m.map(|part| part + random.within(-2e-3, 2e-3));
        }
        let Finger { lengths, assembly, .. } = &finger.linkage;
        let posture = close_loop(lengths, *assembly, finger.initial.q11_rad, finger.initial.q21_rad);
        let sine = |posture: Posture| (posture.q11_rad + posture.q12_rad - posture.q21_rad - posture.q22_rad).sin();
        // Rounding errors grow without bound near the fold, where l12 and l22 are in line.
        if posture.map_or(0.0, sine).abs() < 0.2 {
            continue;
        }
        let kernel = FingerKernel::new(&scene.hand);
        let start = FingerKernel::start(&scene.hand);
        let overlaps = |contact: FingerContact| {
            kernel.contact_reading(start.q, start.v, contact, ContactState::Free).is_some_and(|it| it.delta > 0.0)
        };
        if FingerContact::ALL.into_iter().any(overlaps) {
            continue;
        }
        designs += 1;
        let mechanism = five_bar(&scene);
        let assembled = assemble(&mechanism).expect("an assembled five-bar");
        let model = MechanismModel::new(&mechanism, (&assembled.poses, &assembled.rates)).expect("dyads");
        let mut closing = Closing::default();
        let options =
            Options { tolerances: Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: 1e-5 }, max_steps: 100_000 };
        let method: SwitchedMethod<FingerLayout> = SwitchedMethod::rodas(Fixed);
        integrate_by(method, &kernel, &options, 0.0, start, 0.012, &mut closing);
        let mut size = 0.0f64;
        for (t, state, finger_mode) in closing.0.into_iter().step_by(7) {
            let State { mut q, mut v, .. } = State::zero(model.sizes());
            q[..2].copy_from_slice(&state.q);
            v[..2].copy_from_slice(&state.v);
            let angle = |body: usize| model.body((&q, &v), body).0[2];
            // Rounding errors grow without bound near the fold, which some closings reach.
            if (angle(1) - angle(3)).sin().abs() < 0.05 {
                continue;
            }
            let mut mode = model.mode_at(t, &q, &v);
            (0..3).for_each(|index| mode.contacts[index] = finger_mode[index]);
            let mut found = Rates::zero(model.sizes());
            model.rates(t, &q, &v, &mode, &mut found);
            let mut linearised = Linearised::zero(Fixed);
            kernel.linearise(t, &state.q, &state.v, &finger_mode, &mut linearised);
            let Linearised { rates: expected, a_q, a_v, .. } = linearised;
            size = size.max(largest(&expected.a));
            for (i, (found, expected)) in found.a.iter().zip(expected.a).enumerate() {
                // A stiff damper multiplies the rounding errors of coordinates and rates.
                let rounding = 1e-14 * (largest(&a_q[i]) + largest(&a_v[i]) * largest(&state.v));
                let allowed = 1e-10 * size + rounding;
                assert!((found - expected).abs() <= allowed, "design {designs}, {t} s: {found} {expected} {allowed:e}");
            }
            states += 1;
        }
    }
    assert!(states > 2000, "{states}");
}

/// End of a run of a random mechanism: coordinates, and the relative error of the energy balance. `Err` describes the
/// singularity that the run met.
fn run_random(mechanism: &Mechanism, rtol: f64) -> Result<(Vec<f64>, f64), String> {
    let start = assemble(mechanism).expect("an assembled mechanism");
    let model = MechanismModel::new(mechanism, (&start.poses, &start.rates)).expect("dyads");
    let tolerances = Tolerances { atol_q: 1e-4 * rtol, atol_v: rtol, rtol_v: rtol };
    let options = Options { tolerances, max_steps: 200_000 };
    let (method, start) = (SwitchedMethod::rodas(model.sizes()), model.start());
    let before = model.energies((&start.q, &start.v));
    let end = integrate_by(method, &model, &options, 0.0, start, 0.02, &mut ());
    if let Err(failure) = end.result {
        let text = failure.to_string();
        assert!(text.contains("singular configuration: the joints"), "{text}");
        return Err(text);
    }
    let after = model.energies((&end.state.q, &end.state.v));
    let stored = |energies: &Energies| energies.kinetic + energies.gravity + energies.spring;
    let drive_work = end.state.z[model.contact_count() + 1];
    let scale = before.kinetic + after.kinetic + drive_work.abs() + 1e-3;
    let balance = stored(&after) - stored(&before) - work(&model, &end.state);
    Ok((end.state.q, balance / scale))
}

#[test]
fn random_mechanisms_keep_their_energy_balance_or_name_their_singularity() {
    let (mut complete, mut singular) = (0, 0);
    for seed in 0..150 {
        let mechanism = random_mechanism(seed);
        match (run_random(&mechanism, 3e-7), run_random(&mechanism, 3e-10)) {
            (Ok((q, balance)), Ok((precise_q, precise_balance))) => {
                complete += 1;
                let difference = q.iter().zip(&precise_q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(difference < 1e-5, "seed {seed}: {difference:e}");
                assert!(
                    balance.abs() < 1e-5 && precise_balance.abs() < 1e-8,
                    "{seed}: {balance:e} {precise_balance:e}"
                );
            }
            (Err(_), Err(_)) => singular += 1,
            (a, b) => panic!("seed {seed}: {a:?} {b:?}"),
        }
    }
    assert!(complete > 120 && singular > 0, "{complete} complete, {singular} singular");
}

/// Two fingers with components on both of them, brakes with and without a bristle, an object that does not rotate, a
/// disc with prescribed motion that hits it, and a tendon of growing tension between both.
fn with_all_components() -> MechanismCase {
    let mut case = mechanism_case("c_f85_two_disc");
    case.name = "components".to_string();
    let Mechanism { bodies, joints, springs, tendons, actuators, rotors, contacts, .. } = &mut case.mechanism;
    let joint = |name: &str| joints.iter().position(|joint| joint.name == name).expect("a joint");
    let on =
        |left: f64| JointCombination { terms: vec![(joint("r_driver"), 0.5), (joint("l_driver"), left)], offset: 0.1 };
    rotors.push(mechanism::Rotor { name: "seesaw".to_string(), on: on(0.5), inertia: 2e-5 });
    springs.push(mechanism::Spring {
        name: "between".to_string(),
        kind: mechanism::SpringKind::Torsional { on: on(-0.5), preload: 0.01 },
        stiffness: 0.05,
        damping: 1e-4,
        rest: 0.2,
    });
    let brake = |bristle| Brake {
        torque_n_m: 0.1,
        start_s: 0.015,
        rise_s: 5e-3,
        release_s: Some(0.03),
        one_way: false,
        v_static_rad_s: 0.5,
        bristle,
    };
    let mut differential = actuators[0].clone();
    (differential.name, differential.on) = ("differential".to_string(), on(-0.5));
    differential.brake = Some(brake(Some(Bristle { damping_n_s_per_m: 0.02, relaxation_s: 1e-3 })));
    actuators.push(differential);
    actuators[0].brake = Some(brake(None));
    contacts[0].force_point = ForcePoint::Each;
    let object = bodies.iter().position(|body| body.name == "object").expect("the object");
    let mut hammer = bodies[object].clone();
    bodies[object].inertia_kg_m2 = f64::INFINITY;
    (hammer.name, hammer.pose, hammer.rate) = ("hammer".to_string(), [0.0, 0.175, 0.0], [0.1, -0.8, 2.0]);
    hammer.motion = Some(PrescribedMotion::ConstantAcceleration { acceleration_m_s2: [0.0, 5.0] });
    let face = OutlineId { body: Some(bodies.len()), outline: 0 };
    contacts.push(ContactPair { face, force_point: ForcePoint::Each, ..contacts[1].clone() });
    let eyelet = |body, point_m| PathElement { body, point_m, radius_m: 0.0, side: 1.0, friction: None };
    let tension = Profile::Table { points: vec![(0.0, 0.5), (0.1, 3.0)], interpolation: Interpolation::Linear };
    tendons.push(Tendon {
        name: "pull".to_string(),
        path: vec![eyelet(None, [0.05, 0.3]), eyelet(Some(bodies.len()), [0.01, 0.0]), eyelet(Some(object), [0.0; 2])],
        joints: Vec::new(),
        far_joints: Vec::new(),
        is_reversed: false,
        stiffness_n_per_m: 0.0,
        damping_n_s_per_m: 0.0,
        rest_m: 0.0,
        actuator: Some(TendonActuator { name: "winch".to_string(), tension }),
    });
    bodies.push(hammer);
    case.start = assemble(&case.mechanism).expect("an assembled mechanism");
    case.samples.clear();
    case
}

/// The tendon finger with a winch, whose cable rubs on a pulley that turns, has an element without friction, and is wound up at
/// both ends.
fn with_cable_friction() -> MechanismCase {
    let mut case = mechanism_case("e_tendon3");
    case.name = "e_tendon3 with friction".to_string();
    let tendon = &mut case.mechanism.tendons[0];
    let law = FrictionLaw {
        mu_static: 0.3,
        mu_dynamic: 0.2,
        v_static_m_s: 3.0,
        v_dynamic_m_s: 6.0,
        kind: FrictionKind::Bristle(Bristle { damping_n_s_per_m: 5.0, relaxation_s: 2e-3 }),
    };
    let last = tendon.path.len() - 1;
    for (index, element) in tendon.path[1..last].iter_mut().enumerate() {
        element.friction = (index != 1)
            .then_some(FrictionLaw { kind: if index % 2 == 0 { law.kind } else { FrictionKind::Regularised }, ..law });
    }
    // A ring about which the cable turns on a moving body.
    (tendon.path[last - 1].radius_m, tendon.path[last - 1].side) = (1e-3, 1.0);
    tendon.far_joints.push((0, 0.003));
    case.start = assemble(&case.mechanism).expect("an assembled mechanism");
    case.samples.clear();
    case
}

/// A case whose joints, springs and tendons on the ground are on a palm that moves, turns and vibrates.
fn on_a_moving_palm(name: &str) -> MechanismCase {
    let mut case = mechanism_case(name);
    case.name = format!("{name} on a palm");
    let Mechanism { bodies, joints, springs, tendons, .. } = &mut case.mechanism;
    let palm = Some(bodies.len());
    let linear = springs.iter_mut().filter_map(|spring| match &mut spring.kind {
        mechanism::SpringKind::Linear { bodies, .. } => Some(bodies),
        mechanism::SpringKind::Torsional { .. } => None,
    });
    let pairs = joints.iter_mut().map(|joint| &mut joint.bodies).chain(linear).flatten();
    let eyelets = tendons.iter_mut().flat_map(|tendon| &mut tendon.path).map(|element| &mut element.body);
    pairs.chain(eyelets).filter(|body| body.is_none()).for_each(|body| *body = palm);
    let moves = [(Axis::X, 0.02), (Axis::Y, 0.01), (Axis::Angle, -0.1)];
    let moves = moves.map(|(axis, distance)| Move { axis, distance, start_s: 1e-3, length_s: case.duration_s });
    let shake = Vibration {
        axis: Axis::Angle,
        amplitude: 1e-3,
        frequency_hz: 100.0,
        phase_rad: 0.4,
        start_s: 2e-3,
        ramp_periods: 1.0,
        ramp: Ramp::Quintic,
    };
    let motion = PalmMotion { moves: moves.to_vec(), vibrations: vec![shake], ..PalmMotion::default() };
    let mut body = bodies[0].clone();
    (body.name, body.pose, body.rate, body.outlines) = ("palm".to_string(), [0.0; 3], [0.0; 3], Vec::new());
    body.motion = Some(PrescribedMotion::Palm(motion));
    bodies.push(body);
    case.start = assemble(&case.mechanism).expect("an assembled mechanism");
    case.samples.clear();
    case
}

#[test]
fn combinations_brakes_and_prescribed_bodies_keep_the_energy_balance() {
    let case = with_all_components();
    let model = MechanismModel::new(&case.mechanism, (&case.start.poses, &case.start.rates)).expect("dyads");
    assert_eq!((model.sizes().coordinates, largest_group(&case.mechanism)), (4 + 2 + 1 + 1, 4));
    let tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-10, rtol_v: 1e-10 };
    let options = Options { tolerances, max_steps: 1_000_000 };
    let (method, start) = (SwitchedMethod::rodas(model.sizes()), model.start());
    let mut states = States::default();
    let end = integrate_by(method, &model, &options, 0.0, start.clone(), case.duration_s, &mut states);
    end.result.unwrap_or_else(|failure| panic!("{failure}"));
    let stored = |state: &State<Dynamic>| {
        let energies = model.energies((&state.q, &state.v));
        energies.kinetic + energies.gravity + energies.spring - work(&model, state)
    };
    let (first, last) = (stored(&start), stored(&end.state));
    assert!((last - first).abs() < 1e-8, "{first} {last}");
    let hammer = model.contact_count() - case.mechanism.limits().len() - 1;
    assert!(end.state.z[hammer] > 1e-3, "the hammer hits the object: {:?}", end.state.z);
    let object = case.mechanism.bodies.len() - 2;
    assert_eq!(model.body((&end.state.q, &end.state.v), object).0[2], 0.0);
}
