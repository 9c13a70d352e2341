//! Acceleration that a grasp can balance: comparison with the closed-form forces of the thesis, with all vertices of the feasible set of
//! forces (columns from displaced bodies), with mirror images, and monotonicity.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use nalgebra::{SMatrix, SVector};
use phalanx::drive::{Brake, Profile};
use phalanx::grasp::{DriveMode, GraspState, GripperAtRest, gripper_at_rest};
use phalanx::gripper::{Bodies, Body, Finger, Spring};
use phalanx::law::ContactLaw;
use phalanx::numeric::plane::{add, cross, dot, scale, sub};
use phalanx::scene::{self, Differential, Hand, Motor, Object, ObjectMotion};
use phalanx::statics::{
    BodyMotion, ContactMotion, GraspConfiguration, MechanismBalance, MechanismLimit, PerContact, StaticsError,
    drive_loads, equilibrium, mechanism_balance, mechanism_balance_towards,
};

use crate::support::designs::{THIRDS, design_95, sweep_designs};
use crate::support::statics::{
    Grasp, Random, constant_spring, frames, grasp, mirrored_configuration, rates, symmetric_configuration,
};

const WEIGHT: [f64; 2] = [0.0, 9.81];
const MASS: f64 = 0.053784;

/// Brake torque range of a motor without a brake.
const NO_BRAKE: [f64; 2] = [0.0; 2];

/// A gripper with its active contacts.
#[derive(Clone, Debug)]
struct HandAtRest<'a> {
    configuration: GraspConfiguration<'a>,
    /// Friction coefficients of the active contacts.
    friction: PerContact<Option<f64>>,
    springs: [Option<Spring>; 2],
    drives: Vec<Drive>,
    mass_kg: f64,
    gravity_m_s2: [f64; 2],
}

/// A motor, the fractions of its torque on the driven links (right, left), and the range of torques of its brake.
#[derive(Clone, Copy, Debug)]
struct Drive {
    weights: [f64; 2],
    torque_n_m: f64,
    brake_n_m: [f64; 2],
}

impl Drive {
    fn motor(&self) -> Motor {
        let [least, most] = self.brake_n_m;
        let brake = Brake {
            torque_n_m: most,
            start_s: 1.0,
            rise_s: 1e-3,
            release_s: Some(2.0),
            one_way: least == 0.0,
            v_static_rad_s: 0.01,
            bristle: None,
        };
        let brake = (self.brake_n_m != NO_BRAKE).then_some(brake);
        Motor { brake, ..Motor::from_actuation(Profile::Constant { value: self.torque_n_m }) }
    }
}

impl HandAtRest<'_> {
    fn gripper(&self) -> Result<GripperAtRest, StaticsError> {
        static TEMPLATE: LazyLock<Hand> =
            LazyLock::new(|| scene::load_any("scenes/gripper/design-95.toml").expect("a scene").hand);
        let GraspConfiguration { fingers, palm_width_m, object, .. } = self.configuration;
        let mut hand = Hand { palm_width_m, gravity_m_s2: self.gravity_m_s2, ..TEMPLATE.clone() };
        let set_friction = |law: &mut ContactLaw, mu: Option<f64>| {
            law.friction.as_mut().expect("friction").mu_static = mu.unwrap_or_default();
        };
        for (side, finger) in hand.fingers.iter_mut().enumerate() {
            (finger.linkage, finger.spring) = (*fingers[side], self.springs[side]);
            let driven = self.drives.iter().find(|drive| drive.weights[side] == 1.0);
            finger.motor = driven.map_or(Motor::NONE, Drive::motor);
            let mu = self.friction.phalanges[side];
            finger.contact.both_mut().into_iter().zip(mu).for_each(|(law, mu)| set_friction(law, mu));
        }
        set_friction(hand.palm.as_mut().expect("a palm").contact.as_mut().expect("a law"), self.friction.palm);
        let input = self.drives.iter().find(|drive| drive.weights == [0.5; 2]);
        hand.differential = input.map(|drive| Differential { motor: drive.motor(), seesaw_inertia_kg_m2: 0.0 });
        let motion =
            ObjectMotion::Free { mass_kg: self.mass_kg, inertia_kg_m2: 1e-5, velocity_m_s: [0.0; 2], spin_rad_s: 0.0 };
        hand.object = Some(Object { motion, ..Object::fixed(object) });
        let has_brake = self.drives.iter().any(|drive| drive.brake_n_m != NO_BRAKE);
        let mode = if has_brake { DriveMode::Blocked } else { DriveMode::AtTorque };
        let active = self.friction.map(|mu| mu.is_some());
        let configuration = self.configuration;
        gripper_at_rest(&hand, &GraspState { configuration, active, at_limit: [false; 2], time_s: 0.0 }, mode)
    }
}

fn balance_towards(hand: &HandAtRest<'_>, direction: [f64; 2]) -> Result<MechanismBalance, StaticsError> {
    mechanism_balance_towards(&hand.gripper()?.at_rest(), direction)
}

fn drives(torque_n_m: f64, brake_n_m: [f64; 2]) -> Vec<Drive> {
    [[1.0, 0.0], [0.0, 1.0]].map(|weights| Drive { weights, torque_n_m, brake_n_m }).to_vec()
}

/// Returns a finger and its mirror image around an object on the palm.
fn symmetric(grasp: &Grasp, mu: f64, drives: Vec<Drive>) -> HandAtRest<'_> {
    HandAtRest {
        configuration: symmetric_configuration(grasp),
        friction: PerContact { phalanges: [[Some(mu); 2]; 2], palm: Some(mu) },
        springs: [Some(constant_spring(0.1326)); 2],
        drives,
        mass_kg: MASS,
        gravity_m_s2: WEIGHT,
    }
}

fn without_mass(finger: &Finger) -> Finger {
    let body = Body { mass_kg: 0.0, inertia_kg_m2: 0.0, ..finger.bodies.l11 };
    Finger { bodies: Bodies { l11: body, l12: body, l21: body, l22: body }, ..*finger }
}

#[track_caller]
fn acceleration_limit(hand: &HandAtRest<'_>, direction: [f64; 2]) -> MechanismLimit {
    balance_towards(hand, direction).expect("a solution").largest
}

/// Maps a limit to a comparable number: infinite if unlimited, negative if infeasible.
fn limit_value(balanced: &MechanismLimit) -> f64 {
    match balanced {
        MechanismLimit::Infeasible { .. } => -1.0,
        MechanismLimit::Limited { acceleration_m_s2, .. } => *acceleration_m_s2,
        MechanismLimit::Unlimited => f64::INFINITY,
    }
}

/// Without friction and with massless fingers, the contact forces equal (2.32) and the palm force is the remainder. The object can be
/// accelerated away from the palm until the palm force vanishes, towards it without limit, and not along it.
#[test]
fn without_friction_the_palm_force_limits_the_acceleration() {
    let (mut feasible, mut infeasible) = (0, 0);
    for design in sweep_designs(THIRDS) {
        let mut grasp = grasp(&design).expect("a design of the thesis");
        grasp.finger = without_mass(&grasp.finger);
        for torque in [0.3, 0.48, 3.0] {
            let loads = drive_loads(&grasp.finger, &grasp.end, torque, Some(&constant_spring(0.1326))).expect("loads");
            let static_forces = equilibrium(&grasp.finger, &grasp.end, loads, 0.0).expect("forces");
            let palm_n = 2.0 * static_forces.pfp_n - MASS * WEIGHT[1];
            let hand = symmetric(&grasp, 0.0, drives(torque, NO_BRAKE));
            let up = acceleration_limit(&hand, [0.0, -1.0]);
            if !static_forces.is_force_positive() || palm_n < 0.0 {
                assert!(matches!(up, MechanismLimit::Infeasible { .. }), "{design:?} {static_forces:?}");
                infeasible += 1;
                continue;
            }
            feasible += 1;
            let MechanismLimit::Limited { acceleration_m_s2, contacts, .. } = &up else { panic!("{design:?}") };
            assert!((acceleration_m_s2 - palm_n / MASS).abs() < 1e-8 * (1.0 + palm_n / MASS), "{up:?} {palm_n}");
            let [right, left, palm] = [&contacts[..2], &contacts[2..4], &contacts[4..]];
            assert_eq!(palm[0].2, ContactMotion::Separates, "{design:?} {torque} {palm_n}: {up:?}");
            for finger in [right, left] {
                let errors = [finger[0].0 - static_forces.f21_n, finger[1].0 - static_forces.f22_n];
                assert!(errors.iter().all(|error| error.abs() < 1e-7), "{up:?} {static_forces:?}");
            }
            assert_eq!(acceleration_limit(&hand, [0.0, 1.0]), MechanismLimit::Unlimited);
            for direction in [[1.0, 0.0], [-1.0, 0.0]] {
                assert!(limit_value(&acceleration_limit(&hand, direction)).abs() < 1e-6, "{design:?}");
            }
        }
    }
    assert!(feasible > 50 && infeasible > 50, "{feasible} {infeasible}");
}

type Column = SVector<f64, 7>;

/// Generalised forces from displaced bodies: edges of the friction cones in the order of the contacts, drives, constant forces, and
/// inertia along x and y.
struct ForceColumns {
    edges: Vec<Column>,
    drives: Vec<Column>,
    fixed: Column,
    inertia: [Column; 2],
}

fn force_columns(hand: &HandAtRest<'_>) -> ForceColumns {
    let GraspConfiguration { fingers, angles_rad, palm_width_m, object } = hand.configuration;
    let [cx, cy] = object.centre_m;
    let mut columns =
        ForceColumns { edges: Vec::new(), drives: Vec::new(), fixed: Column::zeros(), inertia: [Column::zeros(); 2] };
    for (side, mirror) in [(0, 1.0), (1, -1.0)] {
        let (finger, q, row) = (fingers[side], angles_rad[side], 2 * side);
        let frames = frames(finger, q);
        let centre = [mirror * cx - 0.5 * palm_width_m, cy];
        // Spring on q22.
        let q22 = rates(finger, q, |[_, _, l21, l22]| [l22.angle_rad - l21.angle_rad]);
        (0..2).for_each(|j| columns.fixed[row + j] -= 0.1326 * q22[j][0]);
        // Weight and inertia of each body, at its centre of mass.
        let Bodies { l11, l12, l21, l22 } = finger.bodies;
        for (link, body) in [l11, l12, l21, l22].into_iter().enumerate() {
            let derivatives = rates(finger, q, |frames| frames[link].point(body.com_m));
            for (j, [x, y]) in derivatives.into_iter().enumerate() {
                for (axis, along) in [mirror * x, y].into_iter().enumerate() {
                    columns.fixed[row + j] += body.mass_kg * hand.gravity_m_s2[axis] * along;
                    columns.inertia[axis][row + j] -= body.mass_kg * along;
                }
            }
        }
        // Contact point of each phalanx: the point nearest to the centre of the object.
        let (sin, cos) = finger.lengths.phi22_rad.sin_cos();
        let tip = frames[3].point(scale([cos, sin], finger.lengths.t22_m));
        for (phalanx, (link, end)) in [(2, frames[3].origin_m), (3, tip)].into_iter().enumerate() {
            let Some(mu) = hand.friction.phalanges[side][phalanx] else { continue };
            let base = frames[link].origin_m;
            let along = sub(end, base);
            let fraction = (dot(sub(centre, base), along) / dot(along, along)).clamp(0.0, 1.0);
            let foot = add(base, scale(along, fraction));
            let to = sub(centre, foot);
            let normal = scale(to, 1.0 / to[0].hypot(to[1]));
            let point = add(foot, scale(normal, finger.lengths.half_width_m));
            let local = frames[link].local(point);
            let derivatives = rates(finger, q, |frames| frames[link].point(local));
            for mu in [mu, -mu] {
                // The force on the phalanx is −n plus friction; the force on the object is opposite, at the same point.
                let force = [-normal[0] + mu * normal[1], -normal[1] - mu * normal[0]];
                let mut column = Column::zeros();
                (0..2).for_each(|j| column[row + j] = dot(derivatives[j], force));
                (column[4], column[5]) = (-mirror * force[0], -force[1]);
                column[6] = -mirror * cross(sub(point, centre), force);
                columns.edges.push(column);
            }
        }
    }
    if let Some(mu) = hand.friction.palm {
        for mu in [mu, -mu] {
            columns.edges.push(Column::from([0.0, 0.0, 0.0, 0.0, -mu, 1.0, -mu * cy]));
        }
    }
    for drive in &hand.drives {
        let mut column = Column::zeros();
        (column[0], column[2]) = (drive.weights[0], drive.weights[1]);
        columns.fixed += column * drive.torque_n_m;
        columns.drives.push(column);
    }
    for axis in 0..2 {
        columns.fixed[4 + axis] += hand.mass_kg * hand.gravity_m_s2[axis];
        columns.inertia[axis][4 + axis] -= hand.mass_kg;
    }
    columns
}

/// Maximises the last variable by enumerating all vertices. All variables are at least 0; the first ones have the upper bounds
/// `upper_bounds`. `None` if no vertex is feasible.
fn maximise_by_vertices(columns: &[Column], upper_bounds: &[f64], right: &Column) -> Option<f64> {
    // Moments are divided by a length to balance the determinants.
    let scaled = |column: &Column| {
        let mut column = *column;
        [0, 1, 2, 3, 6].into_iter().for_each(|row| column[row] /= 0.02);
        column
    };
    let columns: Vec<Column> = columns.iter().map(scaled).collect();
    let (right, count, last) = (scaled(right), columns.len(), columns.len() - 1);
    let mut largest: Option<f64> = None;
    for subset in 0u32..1 << count {
        if subset.count_ones() != 7 {
            continue;
        }
        let basic: Vec<usize> = (0..count).filter(|i| subset >> i & 1 == 1).collect();
        let matrix = SMatrix::<f64, 7, 7>::from_fn(|i, j| columns[basic[j]][i]);
        let Some(inverse) = matrix.try_inverse().filter(|inverse| inverse.amax() < 1e7) else { continue };
        // Bounded variables outside the basis are at one of their bounds.
        let remaining: Vec<usize> = (0..upper_bounds.len()).filter(|i| !basic.contains(i)).collect();
        for high in 0u32..1 << remaining.len() {
            let at_bounds = remaining
                .iter()
                .enumerate()
                .filter(|(k, _)| high >> k & 1 == 1)
                .map(|(_, &i)| columns[i] * upper_bounds[i]);
            let values = inverse * (right - at_bounds.fold(Column::zeros(), |sum, column| sum + column));
            let is_feasible = basic
                .iter()
                .zip(values.iter())
                .all(|(&i, &value)| value > -1e-8 && upper_bounds.get(i).is_none_or(|bound| value < bound + 1e-8));
            if is_feasible {
                let value = basic.iter().position(|&i| i == last).map_or(0.0, |position| values[position]);
                largest = Some(largest.map_or(value, |largest: f64| largest.max(value)));
            }
        }
    }
    largest
}

/// Returns the limit of a hand in one direction by vertex enumeration, as `limit_value` does.
fn limit_by_vertices(hand: &HandAtRest<'_>, columns: &ForceColumns, direction: [f64; 2]) -> f64 {
    let driving_force = columns.inertia[0] * direction[0] + columns.inertia[1] * direction[1];
    let span: Vec<f64> = hand.drives.iter().map(|drive| drive.brake_n_m[1] - drive.brake_n_m[0]).collect();
    let has_brake = span.iter().any(|span| *span > 0.0);
    let lowest = hand.drives.iter().zip(&columns.drives).map(|(drive, column)| column * drive.brake_n_m[0]);
    let fixed = lowest.fold(columns.fixed, |sum, column| sum + column);
    let brakes = if has_brake { &columns.drives[..] } else { &[] };
    let upper_bounds = if has_brake { &span[..] } else { &[] };
    // At rest and along a ray, the last variable has no effect.
    let at_rest = [brakes, &columns.edges, &[Column::zeros()]].concat();
    let ray = [&columns.edges[..], &[Column::zeros()]].concat();
    if maximise_by_vertices(&at_rest, upper_bounds, &-fixed).is_none() {
        -1.0
    } else if maximise_by_vertices(&ray, &[], &-driving_force).is_some() {
        f64::INFINITY
    } else {
        let driven = [brakes, &columns.edges, &[driving_force]].concat();
        maximise_by_vertices(&driven, upper_bounds, &-fixed).expect("feasible at rest")
    }
}

/// Returns a motion of all bodies as rates of the rows.
fn row_rates(hand: &HandAtRest<'_>, motion: &[BodyMotion]) -> Column {
    let bodies = hand.gripper().expect("a posture").mechanism.bodies;
    let of = |name: &str| motion[bodies.iter().position(|body| body.name == name).expect("a body")];
    let [x, y, spin] = of("object");
    let [right, left] = ["right", "left"].map(|side| ["l11", "l21"].map(|link| of(&format!("{side}_{link}"))[2]));
    Column::from([right[0], right[1], -left[0], -left[1], x, y, spin])
}

/// Returns the upper bound on the acceleration from a motion, and the smallest relative power of an edge force in it.
fn bound(hand: &HandAtRest<'_>, columns: &ForceColumns, direction: [f64; 2], motion: &[BodyMotion]) -> (f64, f64) {
    let ([x, y], motion) = (direction, row_rates(hand, motion));
    let driving = motion.dot(&(columns.inertia[0] * x + columns.inertia[1] * y));
    let braked = hand.drives.iter().zip(&columns.drives).map(|(drive, column)| {
        drive.brake_n_m.map(|torque| -torque * motion.dot(column)).into_iter().fold(f64::NEG_INFINITY, f64::max)
    });
    let min_power = columns.edges.iter().map(|edge| motion.dot(edge)).fold(0.0, f64::min);
    ((braked.sum::<f64>() - motion.dot(&columns.fixed)) / driving, min_power / motion.amax())
}

/// Returns fingers of different designs in perturbed postures around an object away from the centre.
fn disturbed<'a>(random: &mut Random, [right, left]: [&'a Grasp; 2]) -> HandAtRest<'a> {
    loop {
        let configuration = random.configuration([right, left], 0.03, [1e-3, 0.0]);
        let mut mu = || Some(random.within(0.2, 0.9));
        let friction = PerContact { phalanges: [[mu(), mu()], [mu(), mu()]], palm: mu() };
        let hand = HandAtRest { configuration, friction, ..symmetric(right, 0.0, Vec::new()) };
        if balance_towards(&hand, [1.0, 0.0]).is_ok() {
            return hand;
        }
    }
}

#[test]
fn limits_agree_with_vertex_enumeration() {
    let mut random = Random(17);
    let (mut infeasible, mut limited, mut unlimited) = (0, 0, 0);
    for round in 0..40 {
        let mut grasps = [random.grasp(), random.grasp()];
        if round % 5 == 2 {
            // Massless fingers do not oppose an acceleration of the palm towards the object.
            grasps.iter_mut().for_each(|grasp| grasp.finger = without_mass(&grasp.finger));
        }
        let mut hand = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        hand.gravity_m_s2 = [random.within(-3.0, 3.0), 9.0];
        let torque = random.within(0.3, 0.9);
        let brake = [NO_BRAKE, [-0.4, 0.4], [0.0, 0.7]][round % 3];
        hand.drives = drives(torque, brake);
        if round % 4 == 3 {
            // A differential: each finger receives half of the input torque.
            hand.drives = vec![Drive { weights: [0.5; 2], torque_n_m: 2.0 * torque, brake_n_m: brake }];
        }
        if round % 5 == 4 {
            hand.friction.palm = None;
        }
        let columns = force_columns(&hand);
        for angle in [0.25 * TAU, random.within(0.0, TAU), random.within(0.0, TAU)] {
            let (sin, cos) = angle.sin_cos();
            let actual = acceleration_limit(&hand, [cos, sin]);
            let expected = limit_by_vertices(&hand, &columns, [cos, sin]);
            let a = limit_value(&actual);
            match &actual {
                MechanismLimit::Infeasible { .. } => infeasible += 1,
                MechanismLimit::Unlimited => unlimited += 1,
                MechanismLimit::Limited { motion, gap, .. } => {
                    limited += 1;
                    let tolerance = 1e-6 * (10.0 + expected);
                    assert!(expected >= 0.0 && (a - expected).abs() < tolerance, "{round}: {a}, not {expected}");
                    let (bound, min_power) = bound(&hand, &columns, [cos, sin], motion);
                    assert!((bound - a).abs() < tolerance && min_power > -1e-8, "{round}: {bound} {a} {min_power}");
                    assert!(*gap < 1e-9, "{gap}");
                    continue;
                }
            }
            assert_eq!(a, expected, "{round}");
        }
    }
    assert!(infeasible > 10 && limited > 30 && unlimited > 2, "{infeasible} {limited} {unlimited}");
}

/// Returns the hand mirrored about the centre of the palm.
fn mirrored<'a>(hand: &HandAtRest<'a>) -> HandAtRest<'a> {
    let [mu_right, mu_left] = hand.friction.phalanges;
    HandAtRest {
        configuration: mirrored_configuration(&hand.configuration),
        friction: PerContact { phalanges: [mu_left, mu_right], ..hand.friction },
        gravity_m_s2: [-hand.gravity_m_s2[0], hand.gravity_m_s2[1]],
        ..hand.clone()
    }
}

fn polar_limits(hand: &HandAtRest<'_>, count: usize) -> Vec<f64> {
    let balances = mechanism_balance(&hand.gripper().expect("a posture").at_rest(), count).expect("a solution");
    assert!(balances.iter().enumerate().all(|(index, MechanismBalance { direction: [x, y], .. })| {
        let (sin, cos) = (TAU * index as f64 / count as f64).sin_cos();
        (x - cos).abs() < 1e-15 && (y - sin).abs() < 1e-15
    }));
    balances.iter().map(|balance| limit_value(&balance.largest)).collect()
}

#[track_caller]
fn assert_near(here: f64, there: f64) {
    assert!(here == there || (here - there).abs() < 1e-9 * (1.0 + there.abs()), "{here} {there}");
}

#[test]
fn mirrored_hands_have_mirrored_limits() {
    let mut random = Random(3);
    let mut asymmetric = 0;
    for _ in 0..20 {
        let grasps = [random.grasp(), random.grasp()];
        let mut hand = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        hand.gravity_m_s2 = [2.0, 9.0];
        hand.drives = drives(0.48, [-0.5, 0.5]);
        let (original_limits, mirrored_limits) = (polar_limits(&hand, 12), polar_limits(&mirrored(&hand), 12));
        (0..12).for_each(|index| assert_near(original_limits[index], mirrored_limits[(18 - index) % 12]));
        asymmetric += usize::from((1..12).any(|index| {
            original_limits[index].is_finite() && original_limits[index] != original_limits[(18 - index) % 12]
        }));
    }
    assert!(asymmetric > 5, "{asymmetric}");
    let grasp_95 = grasp(&design_95()).expect("a grasp");
    let bidirectional = polar_limits(&symmetric(&grasp_95, 0.8, drives(0.48, [-2.0, 2.0])), 24);
    (0..24).for_each(|index| assert_near(bidirectional[index], bidirectional[(36 - index) % 24]));
    assert!(bidirectional.iter().all(|a| *a > 10.0), "{bidirectional:?}");
}

#[test]
fn limits_increase_with_friction_and_brake_torque() {
    let grasp_95 = grasp(&design_95()).expect("a grasp");
    let limits = |mu: f64, brake: f64| polar_limits(&symmetric(&grasp_95, mu, drives(0.48, [-brake, brake])), 24);
    let is_monotone =
        |lower: &[f64], upper: &[f64]| lower.iter().zip(upper).all(|(lower, upper)| *upper >= lower * (1.0 - 1e-9));
    let by_friction = [0.05, 0.2, 0.4, 0.8, 1.2].map(|mu| limits(mu, 1.0));
    assert!(by_friction.windows(2).all(|pair| is_monotone(&pair[0], &pair[1])), "{by_friction:?}");
    let by_brake = [0.0, 0.3, 1.0, 3.0, f64::INFINITY].map(|brake| limits(0.4, brake));
    assert!(by_brake.windows(2).all(|pair| is_monotone(&pair[0], &pair[1])), "{by_brake:?}");
    // The sum increases considerably.
    let sum = |all: &[f64]| all.iter().filter(|a| a.is_finite()).sum::<f64>();
    assert!(sum(&by_friction[3]) > 1.2 * sum(&by_friction[1]) && sum(&by_brake[2]) > 1.2 * sum(&by_brake[0]));
    // A brake in both directions holds at least as much as a brake in one direction.
    let one_way = polar_limits(&symmetric(&grasp_95, 0.4, drives(0.48, [0.0, 1.0])), 24);
    assert!(is_monotone(&one_way, &by_brake[2]), "{one_way:?}");
}

/// Without weight and springs, twice the motor torque balances twice the acceleration.
#[test]
fn without_weight_and_springs_the_limit_is_proportional_to_the_torque() {
    let grasp_95 = grasp(&design_95()).expect("a grasp");
    let limits = |torque: f64| {
        let hand = symmetric(&grasp_95, 0.5, drives(torque, NO_BRAKE));
        polar_limits(&HandAtRest { springs: [None; 2], gravity_m_s2: [0.0; 2], ..hand }, 24)
    };
    let (single, double) = (limits(0.4), limits(0.8));
    assert!(single.iter().all(|a| *a > 1.0), "{single:?}");
    single.iter().zip(&double).for_each(|(single, double)| assert_near(2.0 * single, *double));
}

/// A disc in contact with the palm only rolls off under any acceleration along the palm. Massless fingers without contacts have no
/// effect.
#[test]
fn disc_on_the_palm_alone_balances_no_lateral_acceleration() {
    let mut grasp_95 = grasp(&design_95()).expect("a grasp");
    grasp_95.finger = without_mass(&grasp_95.finger);
    let mut hand = symmetric(&grasp_95, 0.8, drives(0.0, NO_BRAKE));
    (hand.springs, hand.gravity_m_s2) = ([None; 2], [0.0, -9.81]);
    hand.friction.phalanges = [[None; 2]; 2];
    assert!(limit_value(&acceleration_limit(&hand, [1.0, 0.0])).abs() < 1e-9);
    assert_eq!(acceleration_limit(&hand, [0.0, 1.0]), MechanismLimit::Unlimited);
    let down = acceleration_limit(&hand, [0.0, -1.0]);
    assert!((limit_value(&down) - 9.81).abs() < 1e-9, "{down:?}");
    // The disc falls if the palm is above it.
    hand.gravity_m_s2 = [0.0, 9.81];
    assert!(matches!(acceleration_limit(&hand, [0.0, 1.0]), MechanismLimit::Infeasible { .. }));
}

#[test]
fn errors_name_the_invalid_value() {
    let grasp_95 = grasp(&design_95()).expect("a grasp");
    let hand = symmetric(&grasp_95, 0.8, drives(0.48, NO_BRAKE));
    let error = |hand: &HandAtRest<'_>, direction| balance_towards(hand, direction).expect_err("an error").to_string();
    assert!(error(&hand, [0.0, 0.0]).contains("norm of the direction is 0"));
    assert!(error(&symmetric(&grasp_95, -0.1, Vec::new()), [1.0, 0.0]).contains("mu_static is -0.1"));
    let mut open_loop = hand.clone();
    open_loop.configuration.angles_rad[1] = [3.0, 0.1];
    assert!(error(&open_loop, [1.0, 0.0]).contains("the loop cannot close"), "{}", error(&open_loop, [1.0, 0.0]));
}
