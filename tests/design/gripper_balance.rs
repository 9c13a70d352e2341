//! What acceleration a grasp can bear: against the forces of the thesis in closed form, against every corner of what forces can do with
//! columns found by moving bodies, against mirror images, and with what it must grow.

use std::f64::consts::TAU;

use nalgebra::{SMatrix, SVector};
use phalanx::gripper::{Bodies, Body, Finger, Joints, Posture, Site, close, joints};
use phalanx::statics::{
    Balance, Balanced, Drive, HandAtRest, Limit, PerContact, Side, Spot, Stance, Yields, balance_polar,
    balanced_acceleration, drive_loads, equilibrium,
};

use crate::support::gripper::{THIRDS, design_95, sweep};
use crate::support::statics::{Grasp, Random, constant_spring, grasp};

const WEIGHT: [f64; 2] = [0.0, 9.81];
const MASS: f64 = 0.053784;

const FREE: [f64; 2] = [0.0; 2];

fn drives(torque_n_m: f64, brake_n_m: [f64; 2]) -> Vec<Drive> {
    [[1.0, 0.0], [0.0, 1.0]].map(|weights| Drive { weights, torque_n_m, brake_n_m }).to_vec()
}

/// A finger and its mirror image around an object on the palm.
fn symmetric(Grasp { finger, disc, end }: &Grasp, mu: f64, drives: Vec<Drive>) -> HandAtRest<'_> {
    HandAtRest {
        stance: Stance {
            fingers: [finger; 2],
            angles_rad: [[end.posture.q11_rad, end.posture.q21_rad]; 2],
            palm_width_m: -2.0 * disc.centre_m[0],
            object: disc.at([0.0, disc.centre_m[1]]),
        },
        friction: PerContact { phalanges: [[Some(mu); 2]; 2], palm: Some(mu) },
        limits: [false; 2],
        springs: [Some(constant_spring(0.1326)); 2],
        drives,
        mass_kg: MASS,
        gravity_m_s2: WEIGHT,
    }
}

fn massless(finger: &Finger) -> Finger {
    let none = Body { mass_kg: 0.0, inertia_kg_m2: 0.0, ..finger.bodies.l11 };
    Finger { bodies: Bodies { l11: none, l12: none, l21: none, l22: none }, ..*finger }
}

#[track_caller]
fn of(hand: &HandAtRest<'_>, direction: [f64; 2]) -> Balanced {
    balanced_acceleration(hand, direction).expect("an answer").largest
}

/// Infinite where there is no limit, negative where nothing is balanced: so that they can be compared.
fn reach(balanced: &Balanced) -> f64 {
    match balanced {
        Balanced::Nothing => -1.0,
        Balanced::UpTo(limit) => limit.acceleration_m_s2,
        Balanced::Any => f64::INFINITY,
    }
}

/// Without friction and with fingers that weigh nothing, forces are those of (2.32), and the palm's is what is left: the object can be
/// carried away from it until that is none, towards it however fast, and not at all along it.
#[test]
fn without_friction_the_palm_has_what_the_fingers_leave() {
    let (mut carried, mut refused) = (0, 0);
    for design in sweep(THIRDS) {
        let mut grasp = grasp(&design).expect("a design of the thesis");
        grasp.finger = massless(&grasp.finger);
        for torque in [0.3, 0.48, 3.0] {
            let loads = drive_loads(&grasp.finger, &grasp.end, torque, Some(&constant_spring(0.1326))).expect("loads");
            let rest = equilibrium(&grasp.finger, &grasp.end, loads, 0.0).expect("forces");
            let left = 2.0 * rest.pfp_n - MASS * WEIGHT[1];
            let hand = symmetric(&grasp, 0.0, drives(torque, FREE));
            if !rest.is_force_positive() || left < 0.0 {
                assert_eq!(of(&hand, [0.0, -1.0]), Balanced::Nothing, "{design:?} {rest:?}");
                refused += 1;
                continue;
            }
            carried += 1;
            let Balanced::UpTo(up) = of(&hand, [0.0, -1.0]) else { panic!("{design:?}") };
            assert!((up.acceleration_m_s2 - left / MASS).abs() < 1e-8 * (1.0 + left / MASS), "{up:?} {left}");
            let at = |spot: Spot| *up.contacts.iter().find(|held| held.spot == spot).expect("a contact");
            assert_eq!(at(Spot::Palm).yields, Yields::Leaves, "{design:?} {torque} {left}: {up:?}");
            for side in Side::BOTH {
                let [proximal, distal] =
                    [Site::Proximal, Site::Distal].map(|site| at(Spot::Finger(side, site)).normal_n);
                assert!((proximal - rest.f21_n).abs() < 1e-7 && (distal - rest.f22_n).abs() < 1e-7, "{up:?} {rest:?}");
            }
            assert_eq!(of(&hand, [0.0, 1.0]), Balanced::Any);
            for direction in [[1.0, 0.0], [-1.0, 0.0]] {
                assert!(reach(&of(&hand, direction)).abs() < 1e-6, "{design:?}");
            }
        }
    }
    assert!(carried > 50 && refused > 50, "{carried} {refused}");
}

/// Where a point of a body is, by both angles of its finger.
type Place<'a> = Box<dyn Fn(&Posture, &Joints) -> [f64; 2] + 'a>;

fn turned(by: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = by.sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}

fn from(base: [f64; 2], by: f64, local: [f64; 2]) -> [f64; 2] {
    let [x, y] = turned(by, local);
    [base[0] + x, base[1] + y]
}

/// What a point of a finger moves by with q11 and q21: by central differences of the closed loop.
fn rates(finger: &Finger, q: [f64; 2], place: &Place<'_>) -> [[f64; 2]; 2] {
    const H: f64 = 1e-6;
    [0, 1].map(|j| {
        let at = |by: f64| {
            let q: [f64; 2] = std::array::from_fn(|k| if k == j { q[k] + by } else { q[k] });
            let posture = close(&finger.lengths, finger.assembly, q[0], q[1]).expect("near a posture");
            place(&posture, &joints(&finger.lengths, &posture))
        };
        let (up, down) = (at(H), at(-H));
        [0, 1].map(|i| (up[i] - down[i]) / (2.0 * H))
    })
}

type Column = SVector<f64, 7>;

/// Columns of all that acts, by moving bodies: edges of friction cones in the order of contacts, drives, what is fixed, and inertia along
/// x and y.
struct Moved {
    edges: Vec<Column>,
    drives: Vec<Column>,
    fixed: Column,
    inertia: [Column; 2],
}

fn moved(hand: &HandAtRest<'_>) -> Moved {
    let Stance { fingers, angles_rad, palm_width_m, object } = hand.stance;
    let [cx, cy] = object.centre_m;
    let mut found =
        Moved { edges: Vec::new(), drives: Vec::new(), fixed: Column::zeros(), inertia: [Column::zeros(); 2] };
    for (side, mirror) in [(0, 1.0), (1, -1.0)] {
        let (finger, q, row) = (fingers[side], angles_rad[side], 2 * side);
        let posture = close(&finger.lengths, finger.assembly, q[0], q[1]).expect("a posture");
        let at = joints(&finger.lengths, &posture);
        let centre = [mirror * cx - 0.5 * palm_width_m, cy];
        // Spring on q22, by how that turns.
        let q22 = rates(finger, q, &(Box::new(|posture: &Posture, _: &Joints| [posture.q22_rad, 0.0]) as Place<'_>));
        (0..2).for_each(|j| found.fixed[row + j] -= 0.1326 * q22[j][0]);
        // Weight and inertia of each body at its centre of mass.
        let Bodies { l11, l12, l21, l22 } = finger.bodies;
        let bodies: [(Body, Place<'_>); 4] = [
            (l11, Box::new(move |p, _| turned(p.q11_rad, l11.com_m))),
            (l12, Box::new(move |p, at| from(at.a12_m, p.q11_rad + p.q12_rad, l12.com_m))),
            (l21, Box::new(move |p, _| turned(p.q21_rad, l21.com_m))),
            (l22, Box::new(move |p, at| from(at.a22_m, p.q21_rad + p.q22_rad, l22.com_m))),
        ];
        for (body, place) in &bodies {
            let moves = rates(finger, q, place);
            for (j, [x, y]) in moves.into_iter().enumerate() {
                for (axis, along) in [mirror * x, y].into_iter().enumerate() {
                    found.fixed[row + j] += body.mass_kg * hand.gravity_m_s2[axis] * along;
                    found.inertia[axis][row + j] -= body.mass_kg * along;
                }
            }
        }
        // Where each phalanx is nearest to the centre.
        let lines = [([0.0; 2], at.a22_m), (at.a22_m, at.tip_m)];
        for (site, (base, end)) in lines.into_iter().enumerate() {
            let Some(mu) = hand.friction.phalanges[side][site] else { continue };
            let along = [end[0] - base[0], end[1] - base[1]];
            let part = ((centre[0] - base[0]) * along[0] + (centre[1] - base[1]) * along[1])
                / (along[0] * along[0] + along[1] * along[1]);
            let part = part.clamp(0.0, 1.0);
            let foot = [base[0] + part * along[0], base[1] + part * along[1]];
            let to = [centre[0] - foot[0], centre[1] - foot[1]];
            let distance = to[0].hypot(to[1]);
            let normal = [to[0] / distance, to[1] / distance];
            let w = finger.lengths.half_width_m;
            let point = [foot[0] + w * normal[0], foot[1] + w * normal[1]];
            let angle = if site == 0 { posture.q21_rad } else { posture.q21_rad + posture.q22_rad };
            let joint = if site == 0 { [0.0; 2] } else { at.a22_m };
            let local = turned(-angle, [point[0] - joint[0], point[1] - joint[1]]);
            let place: Place<'_> = match site {
                0 => Box::new(move |p, _| turned(p.q21_rad, local)),
                _ => Box::new(move |p, at| from(at.a22_m, p.q21_rad + p.q22_rad, local)),
            };
            let moves = rates(finger, q, &place);
            for mu in [mu, -mu] {
                // On the phalanx −n and friction; on the object the opposite, at the same point.
                let on = [-normal[0] + mu * normal[1], -normal[1] - mu * normal[0]];
                let mut column = Column::zeros();
                (0..2).for_each(|j| column[row + j] = moves[j][0] * on[0] + moves[j][1] * on[1]);
                (column[4], column[5]) = (-mirror * on[0], -on[1]);
                column[6] = mirror * ((point[0] - centre[0]) * -on[1] - (point[1] - centre[1]) * -on[0]);
                found.edges.push(column);
            }
        }
    }
    if let Some(mu) = hand.friction.palm {
        for mu in [mu, -mu] {
            found.edges.push(Column::from([0.0, 0.0, 0.0, 0.0, -mu, 1.0, -mu * cy]));
        }
    }
    for drive in &hand.drives {
        let mut column = Column::zeros();
        (column[0], column[2]) = (drive.weights[0], drive.weights[1]);
        found.fixed += column * drive.torque_n_m;
        found.drives.push(column);
    }
    for axis in 0..2 {
        found.fixed[4 + axis] += hand.mass_kg * hand.gravity_m_s2[axis];
        found.inertia[axis][4 + axis] -= hand.mass_kg;
    }
    found
}

/// The largest last of the variables, all of which are 0 or more and the first `bounded` of them at most these, that solves the equations:
/// by looking at every corner. `None` if no corner solves them.
fn by_corners(columns: &[Column], most: &[f64], right: &Column) -> Option<f64> {
    // Moments over a length, so that determinants compare.
    let weigh = |column: &Column| {
        let mut column = *column;
        [0, 1, 2, 3, 6].into_iter().for_each(|row| column[row] /= 0.02);
        column
    };
    let columns: Vec<Column> = columns.iter().map(weigh).collect();
    let (right, count, last) = (weigh(right), columns.len(), columns.len() - 1);
    let mut best: Option<f64> = None;
    for chosen in 0u32..1 << count {
        if chosen.count_ones() != 7 {
            continue;
        }
        let basic: Vec<usize> = (0..count).filter(|i| chosen >> i & 1 == 1).collect();
        let matrix = SMatrix::<f64, 7, 7>::from_fn(|i, j| columns[basic[j]][i]);
        let Some(inverse) = matrix.try_inverse().filter(|inverse| inverse.amax() < 1e7) else { continue };
        // Those that are bounded and not among them are on either bound.
        let others: Vec<usize> = (0..most.len()).filter(|i| !basic.contains(i)).collect();
        for high in 0u32..1 << others.len() {
            let at = others.iter().enumerate().filter(|(k, _)| high >> k & 1 == 1).map(|(_, &i)| columns[i] * most[i]);
            let values = inverse * (right - at.fold(Column::zeros(), |sum, column| sum + column));
            let within = basic
                .iter()
                .zip(values.iter())
                .all(|(&i, &value)| value > -1e-8 && most.get(i).is_none_or(|most| value < most + 1e-8));
            if within {
                let value = basic.iter().position(|&i| i == last).map_or(0.0, |at| values[at]);
                best = Some(best.map_or(value, |best: f64| best.max(value)));
            }
        }
    }
    best
}

/// The same in one direction of a hand.
fn expected(hand: &HandAtRest<'_>, moved: &Moved, direction: [f64; 2]) -> Corners {
    let driving = moved.inertia[0] * direction[0] + moved.inertia[1] * direction[1];
    let span: Vec<f64> = hand.drives.iter().map(|drive| drive.brake_n_m[1] - drive.brake_n_m[0]).collect();
    let braked = span.iter().any(|span| *span > 0.0);
    let lowest = hand.drives.iter().zip(&moved.drives).map(|(drive, column)| column * drive.brake_n_m[0]);
    let fixed = lowest.fold(moved.fixed, |sum, column| sum + column);
    let brakes: Vec<Column> = moved.drives.iter().copied().filter(|_| braked).collect();
    let most = if braked { span } else { Vec::new() };
    let all: Vec<Column> = brakes.iter().chain(&moved.edges).copied().collect();
    // A corner at rest: the last variable is none that drives.
    let still: Vec<Column> = all.iter().copied().chain([Column::zeros()]).collect();
    if by_corners(&still, &most, &-fixed).is_none() {
        return Corners::Nothing;
    }
    let ray: Vec<Column> = moved.edges.iter().copied().chain([Column::zeros()]).collect();
    if by_corners(&ray, &[], &-driving).is_some() {
        return Corners::Any;
    }
    let driven: Vec<Column> = all.into_iter().chain([driving]).collect();
    Corners::UpTo(by_corners(&driven, &most, &-fixed).expect("it is balanced at rest"))
}

enum Corners {
    Nothing,
    UpTo(f64),
    Any,
}

/// A bound on the acceleration that the motion of a limit gives, and the worst that a force on an edge takes away in it.
fn bound(hand: &HandAtRest<'_>, moved: &Moved, direction: [f64; 2], limit: &Limit) -> (f64, f64) {
    let ([right, left], [x, y]) = (limit.motion.fingers_rad_s, limit.motion.object_m_s);
    let motion = Column::from([right[0], right[1], left[0], left[1], x, y, limit.motion.spin_rad_s]);
    let driving = motion.dot(&(moved.inertia[0] * direction[0] + moved.inertia[1] * direction[1]));
    let braked = hand.drives.iter().zip(&moved.drives).map(|(drive, column)| {
        drive.brake_n_m.map(|torque| -torque * motion.dot(column)).into_iter().fold(f64::NEG_INFINITY, f64::max)
    });
    let taken = moved.edges.iter().map(|edge| motion.dot(edge)).fold(0.0, f64::min);
    ((braked.sum::<f64>() - motion.dot(&moved.fixed)) / driving, taken / motion.amax())
}

/// Fingers of different designs, in postures and around an object of their own.
fn disturbed<'a>(random: &mut Random, [right, left]: [&'a Grasp; 2]) -> HandAtRest<'a> {
    loop {
        let mut angles = |Grasp { end, .. }: &Grasp| {
            [end.posture.q11_rad, end.posture.q21_rad].map(|angle| angle + random.within(-0.03, 0.03))
        };
        let angles_rad = [angles(right), angles(left)];
        let mut hand = symmetric(right, 0.0, Vec::new());
        hand.stance = Stance {
            fingers: [&right.finger, &left.finger],
            angles_rad,
            palm_width_m: -right.disc.centre_m[0] - left.disc.centre_m[0],
            object: right.disc.at([random.within(-1e-3, 1e-3), right.disc.centre_m[1]]),
        };
        let mut mu = || Some(random.within(0.2, 0.9));
        hand.friction = PerContact { phalanges: [[mu(), mu()], [mu(), mu()]], palm: mu() };
        if balanced_acceleration(&hand, [1.0, 0.0]).is_ok() {
            return hand;
        }
    }
}

#[test]
fn every_corner_of_what_forces_can_do_says_the_same() {
    let mut random = Random(17);
    let (mut nothing, mut limited, mut any) = (0, 0, 0);
    for round in 0..40 {
        let mut grasps = [random.grasp(), random.grasp()];
        if round % 5 == 2 {
            // Whatever pushes the palm against the object, no finger is in its way.
            grasps.iter_mut().for_each(|grasp| grasp.finger = massless(&grasp.finger));
        }
        let mut hand = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        hand.gravity_m_s2 = [random.within(-3.0, 3.0), 9.0];
        let torque = random.within(0.3, 0.9);
        let brake = [FREE, [-0.4, 0.4], [0.0, 0.7]][round % 3];
        hand.drives = drives(torque, brake);
        if round % 4 == 3 {
            // One input and half of its torque for each.
            hand.drives = vec![Drive { weights: [0.5; 2], torque_n_m: 2.0 * torque, brake_n_m: brake }];
        }
        if round % 5 == 4 {
            hand.friction.palm = None;
        }
        let columns = moved(&hand);
        for angle in [0.25 * TAU, random.within(0.0, TAU), random.within(0.0, TAU)] {
            let (sin, cos) = angle.sin_cos();
            let found = of(&hand, [cos, sin]);
            match (&found, expected(&hand, &columns, [cos, sin])) {
                (Balanced::Nothing, Corners::Nothing) => nothing += 1,
                (Balanced::Any, Corners::Any) => any += 1,
                (Balanced::UpTo(limit), Corners::UpTo(most)) => {
                    limited += 1;
                    let (a, near) = (limit.acceleration_m_s2, 1e-6 * (10.0 + most));
                    assert!((a - most).abs() < near, "{round}: {a}, not {most}");
                    let (bound, taken) = bound(&hand, &columns, [cos, sin], limit);
                    assert!((bound - a).abs() < near && taken > -1e-8, "{round}: {bound} {a} {taken}");
                    assert!(limit.gap < 1e-9, "{}", limit.gap);
                }
                (found, _) => panic!("{round}: {found:?} is not what corners say"),
            }
        }
    }
    assert!(nothing > 10 && limited > 30 && any > 2, "{nothing} {limited} {any}");
}

/// The same seen in a mirror that stands on the palm's middle.
fn mirrored<'a>(hand: &HandAtRest<'a>) -> HandAtRest<'a> {
    let Stance { fingers: [right, left], angles_rad: [of_right, of_left], object, .. } = hand.stance;
    let [x, y] = object.centre_m;
    let [mu_right, mu_left] = hand.friction.phalanges;
    HandAtRest {
        stance: Stance {
            fingers: [left, right],
            angles_rad: [of_left, of_right],
            object: object.at([-x, y]),
            ..hand.stance
        },
        friction: PerContact { phalanges: [mu_left, mu_right], ..hand.friction },
        gravity_m_s2: [-hand.gravity_m_s2[0], hand.gravity_m_s2[1]],
        ..hand.clone()
    }
}

fn polar(hand: &HandAtRest<'_>, count: usize) -> Vec<f64> {
    let found = balance_polar(hand, count).expect("an answer");
    assert!(found.iter().enumerate().all(|(index, Balance { direction: [x, y], .. })| {
        let (sin, cos) = (TAU * index as f64 / count as f64).sin_cos();
        (x - cos).abs() < 1e-15 && (y - sin).abs() < 1e-15
    }));
    found.iter().map(|balance| reach(&balance.largest)).collect()
}

#[track_caller]
fn alike(here: f64, there: f64) {
    assert!(here == there || (here - there).abs() < 1e-9 * (1.0 + there.abs()), "{here} {there}");
}

#[test]
fn mirror_images_bear_mirrored_accelerations() {
    let mut random = Random(3);
    let mut uneven = 0;
    for _ in 0..20 {
        let grasps = [random.grasp(), random.grasp()];
        let mut hand = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        hand.gravity_m_s2 = [2.0, 9.0];
        hand.drives = drives(0.48, [-0.5, 0.5]);
        let (here, there) = (polar(&hand, 12), polar(&mirrored(&hand), 12));
        (0..12).for_each(|index| alike(here[index], there[(18 - index) % 12]));
        uneven += usize::from((1..12).any(|index| here[index].is_finite() && here[index] != here[(18 - index) % 12]));
    }
    assert!(uneven > 5, "{uneven}");
    let own = grasp(&design_95()).expect("a grasp");
    let both = polar(&symmetric(&own, 0.8, drives(0.48, [-2.0, 2.0])), 24);
    (0..24).for_each(|index| alike(both[index], both[(36 - index) % 24]));
    assert!(both.iter().all(|a| *a > 10.0), "{both:?}");
}

#[test]
fn more_friction_and_stronger_brakes_never_bear_less() {
    let own = grasp(&design_95()).expect("a grasp");
    let of = |mu: f64, brake: f64| polar(&symmetric(&own, mu, drives(0.48, [-brake, brake])), 24);
    let no_less = |less: &[f64], more: &[f64]| less.iter().zip(more).all(|(less, more)| *more >= less * (1.0 - 1e-9));
    let by_friction = [0.05, 0.2, 0.4, 0.8, 1.2].map(|mu| of(mu, 1.0));
    assert!(by_friction.windows(2).all(|pair| no_less(&pair[0], &pair[1])), "{by_friction:?}");
    let by_brake = [0.0, 0.3, 1.0, 3.0, f64::INFINITY].map(|brake| of(0.4, brake));
    assert!(by_brake.windows(2).all(|pair| no_less(&pair[0], &pair[1])), "{by_brake:?}");
    // And mostly more.
    let sum = |all: &[f64]| all.iter().filter(|a| a.is_finite()).sum::<f64>();
    assert!(sum(&by_friction[3]) > 1.2 * sum(&by_friction[1]) && sum(&by_brake[2]) > 1.2 * sum(&by_brake[0]));
    // What holds one way holds both ways too.
    let one_way = polar(&symmetric(&own, 0.4, drives(0.48, [0.0, 1.0])), 24);
    assert!(no_less(&one_way, &by_brake[2]), "{one_way:?}");
}

/// With nothing fixed but the motors' torque, twice the torque bears twice the acceleration.
#[test]
fn without_weight_and_springs_it_grows_with_the_torque() {
    let own = grasp(&design_95()).expect("a grasp");
    let of = |torque: f64| {
        let hand = symmetric(&own, 0.5, drives(torque, FREE));
        polar(&HandAtRest { springs: [None; 2], gravity_m_s2: [0.0; 2], ..hand }, 24)
    };
    let (one, two) = (of(0.4), of(0.8));
    assert!(one.iter().all(|a| *a > 1.0), "{one:?}");
    one.iter().zip(&two).for_each(|(one, two)| alike(2.0 * one, *two));
}

/// A disc on the palm alone rolls off as soon as it is moved along; fingers without weight that do nothing are in nobody's way.
#[test]
fn a_disc_that_only_lies_there_rolls_off() {
    let mut own = grasp(&design_95()).expect("a grasp");
    own.finger = massless(&own.finger);
    let mut hand = symmetric(&own, 0.8, drives(0.0, FREE));
    (hand.springs, hand.gravity_m_s2) = ([None; 2], [0.0, -9.81]);
    hand.friction.phalanges = [[None; 2]; 2];
    assert!(reach(&of(&hand, [1.0, 0.0])).abs() < 1e-9);
    assert_eq!(of(&hand, [0.0, 1.0]), Balanced::Any);
    let down = of(&hand, [0.0, -1.0]);
    assert!((reach(&down) - 9.81).abs() < 1e-9, "{down:?}");
    // With the palm above it, it falls.
    hand.gravity_m_s2 = [0.0, 9.81];
    assert_eq!(of(&hand, [0.0, 1.0]), Balanced::Nothing);
}

#[test]
fn what_is_wrong_is_said() {
    let own = grasp(&design_95()).expect("a grasp");
    let hand = symmetric(&own, 0.8, drives(0.48, FREE));
    let error = |hand: &HandAtRest<'_>, direction| {
        balanced_acceleration(hand, direction).expect_err("it is refused").to_string()
    };
    assert!(error(&hand, [0.0, 0.0]).contains("length of the direction is 0"));
    assert!(error(&HandAtRest { mass_kg: 0.0, ..hand.clone() }, [1.0, 0.0]).contains("mass is 0"));
    assert!(error(&symmetric(&own, -0.1, Vec::new()), [1.0, 0.0]).contains("mu_static is -0.1"));
    let mut torn = hand.clone();
    torn.stance.angles_rad[1] = [3.0, 0.1];
    assert!(error(&torn, [1.0, 0.0]).contains("the loop cannot close"), "{}", error(&torn, [1.0, 0.0]));
}
