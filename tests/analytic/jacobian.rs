//! Jacobians of the equations of motion against extrapolated central differences of their right-hand sides: of a finger
//! on every branch of every law, with bristles, of grippers, and of hands beyond scene files.

use phalanx::analytic::mechanism::MechanismModel;
use phalanx::analytic::{ContactReading, ContactState, FingerMode, Model, QUADRATURES, StictionModel};
use phalanx::gripper::{self, FingerContact};
use phalanx::integrator::{Fixed, Hybrid, Layout, Linearised, Rates, State, System, VectorOf};
use phalanx::law::unclamped_normal_force;
use phalanx::scene::{
    Axis, Hand, HandContact, Initial, Interpolation, Move, Object, ObjectMotion, Placement, Profile, Scene, Spring,
    SpringKind,
};
use phalanx::trace::{BodyState, Sample};

use super::gripper::kernel;
use super::hands_in_code;
use crate::support::reference_cases::reference_case;
use crate::support::runs::{
    PHALANGES, experiment_95, experiment_95_with, load_with_stiction, run_to_end, with_reference_settings,
};

use ContactState::{Active, Clamped, Free, Released};

/// Variable by which the equations of motion are differentiated.
#[derive(Clone, Copy, Debug)]
pub(super) enum Variable {
    Time,
    Coordinate(usize),
    Rate(usize),
}

impl Variable {
    /// Index of time, coordinates or rates.
    pub fn kind(self) -> usize {
        match self {
            Variable::Time => 0,
            Variable::Coordinate(_) => 1,
            Variable::Rate(_) => 2,
        }
    }
}

/// Entry of a Jacobian: an output of the equations of motion differentiated by a variable.
pub(super) struct Entry {
    /// Value of the output.
    pub value: f64,
    /// Kind of the variable.
    pub kind: usize,
    /// Largest derivatives of the output by time, coordinates and rates, and by variables of the same kind.
    pub largest: [f64; 3],
    pub row_size: f64,
    /// Largest step of the differences.
    pub h: f64,
}

/// Equations of motion in one state.
pub(super) struct Equations<'a, S: System> {
    pub hand: &'a S,
    pub mode: S::Mode,
    pub t: f64,
    pub q: VectorOf<S::Layout>,
    pub v: VectorOf<S::Layout>,
}

impl<S: System> Equations<'_, S> {
    fn linearise(&self) -> Linearised<S::Layout> {
        let mut linearised = Linearised::zero(self.hand.layout());
        self.hand.linearise(self.t, &self.q, &self.v, &self.mode, &mut linearised);
        linearised
    }

    /// Accelerations and integrands of the quadratures, with a variable changed.
    fn outputs(&self, variable: Variable, by: f64) -> Vec<f64> {
        let (mut t, mut q, mut v) = (self.t, self.q.clone(), self.v.clone());
        match variable {
            Variable::Time => t += by,
            Variable::Coordinate(i) => q[i] += by,
            Variable::Rate(i) => v[i] += by,
        }
        let mut rates = Rates::zero(self.hand.layout());
        self.hand.rates(t, &q, &v, &self.mode, &mut rates);
        [rates.a.as_ref(), rates.g.as_ref()].concat()
    }

    /// Derivatives of all outputs from central differences with steps h, h/2, …, extrapolated to order 2 × `levels`.
    fn difference_quotients(&self, variable: Variable, h: f64, levels: u32) -> Vec<f64> {
        let central = |h: f64| -> Vec<f64> {
            let (up, down) = (self.outputs(variable, h), self.outputs(variable, -h));
            up.iter().zip(&down).map(|(up, down)| (up - down) / (2.0 * h)).collect()
        };
        let mut row: Vec<Vec<f64>> = (0..levels).map(|k| central(h / f64::from(1 << k))).collect();
        for order in 1..levels {
            let factor = f64::from(1 << (2 * order));
            let extrapolated = |pair: &[Vec<f64>]| {
                let entries = pair[0].iter().zip(&pair[1]);
                entries.map(|(coarse, fine)| (factor * fine - coarse) / (factor - 1.0)).collect()
            };
            row = row.windows(2).map(extrapolated).collect();
        }
        row.swap_remove(0)
    }

    /// Compares every entry with differences of a step `h` that depends on the variable; a variable with a step of 0 is
    /// not compared.
    pub fn check(&self, name: &str, levels: u32, h: impl Fn(Variable) -> f64, allowed: impl Fn(&Entry) -> f64) {
        let exact = self.linearise();
        let values = self.outputs(Variable::Time, 0.0);
        let count = self.hand.layout().coordinates();
        let variables = (0..count).flat_map(|i| [Variable::Coordinate(i), Variable::Rate(i)]).chain([Variable::Time]);
        for (variable, h) in variables.map(|variable| (variable, h(variable))).filter(|(_, h)| *h > 0.0) {
            for (i, difference) in self.difference_quotients(variable, h, levels).into_iter().enumerate() {
                let (by_t, by_q, by_v) = match i.checked_sub(count) {
                    None => (exact.a_t[i], &exact.a_q[i], &exact.a_v[i]),
                    Some(i) => (exact.g_t[i], &exact.g_q[i], &exact.g_v[i]),
                };
                let largest = |row: &[f64]| row.iter().fold(0.0f64, |largest, entry| largest.max(entry.abs()));
                let exact = match variable {
                    Variable::Time => by_t,
                    Variable::Coordinate(j) => by_q[j],
                    Variable::Rate(j) => by_v[j],
                };
                let largest = [largest(&[by_t]), largest(by_q), largest(by_v)];
                let (value, kind) = (values[i], variable.kind());
                let allowed = allowed(&Entry { value, kind, largest, row_size: largest[kind], h });
                assert!(
                    (exact - difference).abs() <= allowed,
                    "{name}: output {i} by {variable:?}: {exact:e}, by differences {difference:e} ± {allowed:e}"
                );
            }
        }
    }
}

/// A state of a finger. The steps in t, q and v are small enough to stay on one branch of each law.
#[derive(Clone)]
struct Case {
    name: &'static str,
    scene: Scene,
    mode: FingerMode,
    t: f64,
    q: [f64; 2],
    v: [f64; 2],
    steps: [f64; 3],
}

/// Compares to 1e-6 of the largest entry of the same output in the same block. The scale of an output that does not
/// depend on a variable is the output divided by the step in that variable.
fn check_case(case: &Case) {
    let Case { name, scene, mode, t, q, v, steps } = case;
    let model = Model::new(&scene.hand);
    let equations = Equations { hand: &model, mode: *mode, t: *t, q: *q, v: *v };
    let allowed = |entry: &Entry| 1e-6 * (entry.row_size + 1e-7 * entry.value.abs() / entry.h + 1e-9);
    equations.check(name, 4, |variable| steps[variable.kind()], allowed);
    // The right-hand side is the same with and without derivatives.
    let (Rates { a, g }, direct) = (equations.linearise().rates, equations.outputs(Variable::Time, 0.0));
    for (i, rate) in a.into_iter().chain(g).enumerate() {
        let scale = if i < 2 { direct[0].abs().max(direct[1].abs()) } else { direct[i].abs() };
        assert!((rate - direct[i]).abs() <= 1e-14 * scale, "{name}: rate {i}: {rate} {direct:?}");
    }
}

fn reading(model: &Model, q: [f64; 2], contact: FingerContact) -> ContactReading {
    model.contact_reading(q, [0.0; 2], contact, Active).expect("a contact")
}

/// Solves for the x at which two linear forms have the given values.
fn solve([a, b]: [[f64; 2]; 2], values: [f64; 2]) -> [f64; 2] {
    let determinant = a[0] * b[1] - a[1] * b[0];
    [(values[0] * b[1] - values[1] * a[1]) / determinant, (a[0] * values[1] - b[0] * values[0]) / determinant]
}

/// Finds q near the grasp at which both phalanges penetrate by the given depths, by Newton's method on the gaps.
fn penetrating_posture(model: &Model, depth: [f64; 2]) -> [f64; 2] {
    let mut q = GRASP_POSTURE;
    for _ in 0..30 {
        let [p, d] = PHALANGES.map(|contact| reading(model, q, contact));
        let step = solve([p.geometry.normal_row, d.geometry.normal_row], [depth[0] - p.delta, depth[1] - d.delta]);
        q = [q[0] - step[0], q[1] - step[1]];
    }
    q
}

/// Final posture of experiment 95, near which both phalanges are in contact.
const GRASP_POSTURE: [f64; 2] = [0.036456, 1.134813];
const CONTACT_STEPS: [f64; 3] = [1e-4, 4e-6, 0.01];

fn contact_case(name: &'static str, scene: &Scene, states: [ContactState; 3], q: [f64; 2], v: [f64; 2]) -> Case {
    Case { name, scene: scene.clone(), mode: states.into(), t: 0.0, q, v, steps: CONTACT_STEPS }
}

fn free_swing(scene: Scene) -> Case {
    let (mode, steps) = ([Free; 3].into(), [1e-4, 2e-3, 0.5]);
    Case { name: "free swing", scene, mode, t: 1e-3, q: [-0.45, 0.9], v: [120.0, 60.0], steps }
}

#[test]
fn free_swing_with_every_kind_and_placement_of_the_spring() {
    for placement in Placement::ALL {
        for kind in [
            SpringKind::Constant { torque_n_m: 0.1326 },
            SpringKind::Torsional { stiffness_n_m_per_rad: 0.06, preload_rad: 1.9 },
        ] {
            let mut case = free_swing(experiment_95());
            case.scene.finger_mut().spring = Some(Spring { kind, placement });
            check_case(&case);
            case.scene.hand.object = None;
            check_case(&Case { name: "fast, no object", v: [-700.0, 300.0], ..case });
        }
    }
    let without_spring_and_limit = experiment_95_with(|scene| {
        (scene.finger_mut().spring, scene.finger_mut().limit, scene.hand.gravity_m_s2) = (None, None, [3.0, -4.0]);
    });
    check_case(&free_swing(without_spring_and_limit));
}

#[test]
fn joint_limit_in_all_contact_states() {
    let scene = experiment_95();
    let model = Model::new(&scene.hand);
    for (name, delta, rate) in
        [("creeping", 3e-7, 1e-3), ("engaging", 4e-6, 0.2), ("beyond", 3e-5, -0.1), ("returning", 6e-6, -0.02)]
    {
        // Newton's method on q11 from the straight configuration finds the penetration δ of the limit.
        let mut q = [1.2 - std::f64::consts::FRAC_PI_2, 1.2];
        let limit = |q| reading(&model, q, FingerContact::Limit);
        for _ in 0..20 {
            q[0] -= (delta - limit(q).delta) / limit(q).geometry.normal_row[0];
        }
        assert!((limit(q).delta - delta).abs() < 1e-14, "{:e}", limit(q).delta);
        let v = solve([limit(q).geometry.normal_row, [0.0, 1.0]], [-rate, 80.0]);
        for state in [Active, Clamped, Released] {
            let steps = [1e-4, 0.05 * delta, 0.1 * f64::abs(rate)];
            check_case(&Case { steps, ..contact_case(name, &scene, [Free, Free, state], q, v) });
        }
    }
}

/// Whether a difference step in the rates could cross the kink at which the clamp sets in.
fn is_near_clamp_limit(model: &Model, q: [f64; 2], v: [f64; 2], contact: FingerContact) -> bool {
    let reading = model.contact_reading(q, v, contact, Active).expect("an object");
    let law = experiment_95().finger().contact.proximal.normal;
    let force = unclamped_normal_force(&law, reading.delta, reading.delta_rate);
    let [a, b] = reading.geometry.normal_row;
    force.force.abs() < 2.0 * force.d_rate * (a.abs() + b.abs()) * CONTACT_STEPS[2]
}

#[test]
fn one_and_two_contacts_on_all_friction_branches() {
    let mut clamped_cases = 0;
    let scene = experiment_95();
    let model = Model::new(&scene.hand);
    let case = |name, states, q, v| contact_case(name, &scene, states, q, v);
    for depth in [[2e-6, 3e-6], [8e-6, 6e-6], [1.5e-5, 3e-5]] {
        let q = penetrating_posture(&model, depth);
        let [p, d] = PHALANGES.map(|contact| reading(&model, q, contact));
        assert!(p.delta > 1e-6 && d.delta > 1e-6, "{} {}", p.delta, d.delta);
        let [(normal_p, slip_p), (normal_d, slip_d)] =
            [p, d].map(|reading| (reading.geometry.normal_row, reading.geometry.tangent_row));
        // Slip speeds on each branch: |v| < v_s = 0.1 m/s, v_s to v_d = 0.2 m/s, and beyond; both signs; at rest.
        for slip in [0.0, 0.03, -0.06, 0.13, -0.17, 0.3, -2.0] {
            for (name, v) in [
                ("slip of both", solve([slip_p, slip_d], [slip, -0.8 * slip])),
                ("tip in creep", solve([slip_d, normal_d], [slip, -2e-3])),
                ("in an impact", solve([normal_p, slip_d], [-1.5, slip])),
            ] {
                for states in [[Active, Active, Free], [Active, Free, Free], [Free, Active, Free]] {
                    check_case(&case(name, states, q, v));
                }
                if !PHALANGES.iter().any(|contact| is_near_clamp_limit(&model, q, v, *contact)) {
                    clamped_cases += 1;
                    check_case(&case(name, [Clamped, Clamped, Free], q, v));
                }
            }
        }
    }
    assert!(clamped_cases >= 30, "only {clamped_cases} cases on clamped branches");
    let mut frictionless = case("frictionless", [Active; 3], penetrating_posture(&model, [5e-6, 4e-6]), [3.0, -1.0]);
    frictionless.scene.finger_mut().contact.both_mut().into_iter().for_each(|law| law.friction = None);
    check_case(&frictionless);
}

/// A disc at the end of the distal phalanx, where the normal turns with the motion.
#[test]
fn contact_at_the_end_of_the_distal_phalanx() {
    let mut scene = experiment_95();
    let distal = |scene: &Scene| reading(&Model::new(&scene.hand), GRASP_POSTURE, FingerContact::Distal);
    let face = distal(&scene).geometry;
    let (linkage, [q11, q21]) = (scene.finger().linkage, GRASP_POSTURE);
    let posture = gripper::close_loop(&linkage.lengths, linkage.assembly, q11, q21).expect("the grasp closes the loop");
    let tip = gripper::joint_positions(&linkage.lengths, &posture).tip_m;
    let reach = linkage.lengths.half_width_m + 20e-3 - 4e-6;
    let rotated = |[x, y]: [f64; 2], [c, s]: [f64; 2]| [x * c + y * s, y * c - x * s];
    let first = rotated(face.normal.map(|n| -n), [0.8, 0.6]);
    for direction in [first, rotated(first, [0.6, 0.8])] {
        scene.hand.grasped_mut().centre_m = [tip[0] + reach * direction[0], tip[1] + reach * direction[1]];
        let end = distal(&scene);
        assert!((end.delta - 4e-6).abs() < 1e-12, "{:e}", end.delta);
        assert!((end.geometry.tangent_row[0] - face.tangent_row[0]).abs() > 1e-5);
        for v in [[2.0, 1.0], [-30.0, 5.0], [0.1, -0.1]] {
            check_case(&contact_case("end", &scene, [Free, Active, Free], GRASP_POSTURE, v));
        }
    }
}

#[test]
fn time_dependent_torque_profiles() {
    let table = |interpolation| Profile::Table { points: vec![(0.0, 0.1), (2e-3, 0.5), (9e-3, -0.2)], interpolation };
    for profile in [
        Profile::Constant { value: 0.48 },
        table(Interpolation::Linear),
        table(Interpolation::Step),
        Profile::Ramp { value: 0.48, rise_s: 5e-3 },
        Profile::HalfSine { value: 0.48, length_s: 5e-3 },
        Profile::Reversal { value: 0.48, at_s: 4e-3 },
    ] {
        let case = free_swing(experiment_95_with(|scene| scene.finger_mut().motor.actuation = profile));
        for t in [1e-3, 3e-3, 8e-3] {
            check_case(&Case { t, ..case.clone() });
        }
    }
    // The derivative by time is not zero.
    let Case { scene, mode, t, q, v, .. } = free_swing(experiment_95_with(|scene| {
        scene.finger_mut().motor.actuation = table(Interpolation::Linear);
    }));
    let mut exact = Linearised::zero(Fixed);
    Model::new(&scene.hand).linearise(t, &q, &v, &mode, &mut exact);
    assert!(exact.a_t[0].abs() > 1e5 && (exact.g_t[4] - 200.0 * v[0]).abs() < 1e-9, "{exact:?}");
}

/// Bristles that stick and slip, on both phalanges.
#[test]
fn bristles_of_a_finger() {
    let model = StictionModel::new(&load_with_stiction("experiment-95").hand);
    let plain = Model::new(&experiment_95().hand);
    let q = penetrating_posture(&plain, [2e-6; 2]);
    let rows = PHALANGES.map(|contact| reading(&plain, q, contact).geometry);
    let [a, b] = solve(rows.map(|row| row.normal_row), [-1e-3; 2]);
    let slips = rows.map(|row| row.tangent_row[0] * a + row.tangent_row[1] * b);
    let mut slipping = 0;
    for slider_rates in [[1e-5, -2e-5], [1.0, 1e-5], [2e-5, -1.0], [1.0, 1.0]] {
        let bristle_states = [slider_rates[0] - slips[0], slider_rates[1] - slips[1]];
        let (q, v) = ([q[0], q[1], 0.3, -0.7], [a, b, bristle_states[0], bristle_states[1]]);
        let equations = Equations { hand: &model, mode: [Active, Active, Free].into(), t: 1e-3, q, v };
        let h = |variable: Variable| [0.0, 1e-8, 1e-6][variable.kind()];
        let allowed = |entry: &Entry| 1e-5 * entry.row_size + 1e-9 * (entry.value.abs() + 1.0) / entry.h;
        equations.check(&format!("{bristle_states:?}"), 1, h, allowed);
        let exact: Linearised<Fixed<4, QUADRATURES>> = equations.linearise();
        slipping += [2, 3].into_iter().filter(|state| exact.a_v[*state][*state] < -999.0).count();
        // The coordinate that belongs to a bristle state has no effect.
        assert!((0..4).all(|i| exact.a_q[i][2] == 0.0 && exact.a_q[i][3] == 0.0));
    }
    assert_eq!(slipping, 4, "four of the eight bristles slip; slipping bristles relax at 1/ms");
}

/// Lets the fingers and a moving object of a hand start at these coordinates and rates: (q11, q21) of each finger, then
/// (x, y, θ).
fn start_at(hand: &mut Hand, q: &[f64], v: &[f64]) {
    for (finger, (q, v)) in hand.fingers.iter_mut().zip(q.chunks(2).zip(v.chunks(2))) {
        finger.initial = Initial { q11_rad: q[0], q21_rad: q[1], qd11_rad_s: v[0], qd21_rad_s: v[1] };
    }
    let object = 2 * hand.fingers.len();
    if let ([x, y, angle_rad], [vx, vy, spin_rad_s]) = (&q[object..], &v[object..]) {
        let Object { centre_m, angle_rad: angle, motion, .. } = hand.grasped_mut();
        (*centre_m, *angle) = ([*x, *y], *angle_rad);
        let ObjectMotion::Free { velocity_m_s, spin_rad_s: spin, .. } = motion else { panic!("a fixed object") };
        (*velocity_m_s, *spin) = ([*vx, *vy], *spin_rad_s);
    }
}

/// The equations of a hand at its start at time `t`, with all contacts in this state, or in that of the posture.
fn equations_at_start(model: &MechanismModel, t: f64, state: Option<ContactState>) -> Equations<'_, MechanismModel> {
    let State { mut q, v, .. } = model.start();
    // Time is the only coordinate with a rate of 1.
    v.iter().position(|rate| *rate == 1.0).into_iter().for_each(|time| q[time] = t);
    let mut mode = model.mode_at(t, &q, &v);
    state.into_iter().for_each(|state| (0..model.contact_count()).for_each(|index| mode.contacts[index] = state));
    Equations { hand: model, mode, t, q, v }
}

/// Grippers with all contacts active. Both fingers are in contact with an object off centre; contacts with negative gaps
/// have forces.
#[test]
fn grippers_at_rest() {
    for letter in ["c", "f", "i"] {
        let mut hand = reference_case(letter).scene.hand;
        hand.fingers[0].spring.as_mut().expect("a spring").kind =
            SpringKind::Torsional { stiffness_n_m_per_rad: 0.08, preload_rad: 1.0 };
        hand.table.iter_mut().for_each(|table| table.level_m = 0.0399);
        hand.differential.iter_mut().for_each(|input| input.motor.no_load_speed_rad_s = Some(300.0));
        let q = [0.08, 1.22, 0.11, 1.31, 1e-3, 0.01998, 0.02];
        start_at(&mut hand, &q, &[12.0, -7.0, 9.0, 5.0, 0.3, -0.2, 4.0]);
        let model = kernel(&hand);
        assert!(model.contact_count() >= 7);
        let equations = equations_at_start(&model, 1e-3, Some(Active));
        (0..7).for_each(|i| assert!((equations.q[i] - q[i]).abs() < 1e-15, "{letter}: {:?}", equations.q));
        let h = |variable| match variable {
            Variable::Time => 0.0,
            Variable::Coordinate(4 | 5) => 4e-7,
            Variable::Coordinate(_) => 1e-5,
            Variable::Rate(_) => 2e-3,
        };
        equations.check(letter, 2, h, |entry| 1e-6 * entry.row_size);
    }
}

/// A gripper with all contacts active, a rotating palm and creeping brakes.
#[test]
fn a_gripper_on_a_moving_palm() {
    let mut hand = reference_case("e").scene.hand;
    let motion = hand.palm_motion.as_mut().expect("a palm motion");
    motion.moves.push(Move { axis: Axis::Angle, distance: 0.3, start_s: 0.05, length_s: 0.06 });
    // The palm is at its pose at time t, and the table is within reach.
    let (t, [x, y, angle]) = (0.073, motion.pose(0.073).position);
    let q = [0.08, 1.22, 0.11, 1.31, 1e-3, 0.01998, 0.02];
    hand.table.as_mut().expect("a table").level_m = y + angle.sin() * q[4] + angle.cos() * q[5] + 0.01998;
    assert!(x != 0.0);
    start_at(&mut hand, &q, &[4e-3, -7.0, -6e-3, 5.0, 0.3, 0.2, 4.0]);
    let model = kernel(&hand);
    let equations = equations_at_start(&model, t, Some(Active));
    assert!((0..7).all(|i| (equations.q[i] - q[i]).abs() < 1e-15) && equations.q[7] == t, "{:?}", equations.q);
    let table = hand.contact_index(HandContact::Table).expect("a table");
    assert!(equations.outputs(Variable::Time, 0.0)[equations.q.len() + table] > 0.0, "the table is in contact");
    let h = |variable| match variable {
        Variable::Coordinate(4 | 5) => 4e-7,
        Variable::Coordinate(7) | Variable::Time => 2e-7,
        Variable::Coordinate(_) => 1e-5,
        // Brakes creep at rates below 0.01 rad/s.
        Variable::Rate(0 | 2) => 2e-4,
        Variable::Rate(_) => 2e-3,
    };
    let allowed = |Entry { kind, largest: [by_t, by_q, by_v], .. }: &Entry| {
        let scale = by_q.max(1e3 * by_v.max(*by_t));
        2e-6 * if *kind == 1 { scale } else { 1e-3 * scale }
    };
    equations.check("moving palm", 2, h, allowed);
}

/// Hands beyond scene files, at the sample with the most active contacts.
#[test]
fn hands_with_active_contacts() {
    for (name, scene) in hands_in_code::cases() {
        let (_, log) = run_to_end(&with_reference_settings(&scene));
        let strong_contacts = |sample: &&Sample| sample.contacts().filter(|contact| contact.normal_n > 0.1).count();
        let sample = log.samples.iter().max_by_key(strong_contacts).expect("samples");
        let mut hand = scene.hand;
        let (mut q, mut v) = (Vec::new(), Vec::new());
        for finger in sample.fingers() {
            q.extend([finger.q11_rad, finger.q21_rad]);
            v.extend([finger.qd11_rad_s, finger.qd21_rad_s]);
        }
        for BodyState { centre_m, angle_rad, velocity_m_s, spin_rad_s } in sample.bodies() {
            q.extend([centre_m[0], centre_m[1], angle_rad]);
            v.extend([velocity_m_s[0], velocity_m_s[1], spin_rad_s]);
        }
        start_at(&mut hand, &q, &v);
        let model = kernel(&hand);
        let equations = equations_at_start(&model, sample.time_s, None);
        let active_contacts = (0..model.contact_count()).filter(|contact| equations.mode[*contact] == Active).count();
        assert!(active_contacts > 0, "{name}");
        // The steps of coordinates are a fraction of the penetration.
        let allowed = |entry: &Entry| {
            let noise = 2e-15 * entry.value.abs().max(entry.row_size) / entry.h;
            2e-5 * entry.row_size + 30.0 * noise
        };
        equations.check(name, 2, |variable| [0.0, 2e-11, 2e-5][variable.kind()], allowed);
    }
}
