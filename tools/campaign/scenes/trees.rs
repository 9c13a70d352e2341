//! Random mechanisms of bodies with joints, dyads, springs, limits, actuators and contacts, as values.

use phalanx::drive::{Brake, Interpolation, Profile};
use phalanx::law::{Bristle, ContactLaw, Damping, FrictionKind, FrictionLaw, NormalLaw};
use phalanx::mechanism::tendon::{Bend, center_in, length_in, wraps};
use phalanx::mechanism::{
    Actuator, Body, Command, ContactPair, Coupling, ForcePoint, Joint, JointCombination, JointKind, Mechanism, Outline,
    OutlineId, OutlineShape, PathElement, Powertrain, PrescribedMotion, Rotor, Spring, SpringKind, Tendon,
    TendonActuator,
};
use phalanx::scene::{Axis, Move, PalmMotion, Ramp, Vibration};
use std::f64::consts::PI;

use super::random::Random;

/// Level of the ground, m.
const GROUND_M: f64 = -0.15;

/// Returns a mechanism of 2 to 8 bodies: joints and dyads on random bodies, and some free bodies. It is assembled in its
/// guessed poses.
pub fn random_mechanism(seed: u64) -> Mechanism {
    let mut random = Random::for_seed(seed);
    let mut mechanism = Mechanism {
        gravity_m_s2: [random.within(-2.0, 2.0), random.within(-10.0, 2.0)],
        ground_outlines: vec![Outline {
            name: "floor".to_string(),
            shape: OutlineShape::HalfPlane { point_m: [0.0, GROUND_M], normal: [0.0, 1.0] },
        }],
        ..Mechanism::default()
    };
    let count = 2 + (random.unit() * 7.0) as usize;
    while mechanism.bodies.len() < count {
        let left = count - mechanism.bodies.len();
        // The first body has a coordinate of its own.
        match if mechanism.bodies.is_empty() { 1.0 } else { random.unit() } {
            part if part < 0.1 => add_body(&mut mechanism, &mut random, true),
            part if part < 0.5 && left > 1 => add_dyad(&mut mechanism, &mut random),
            _ => {
                let base = random_base(&mechanism, &mut random);
                add_body(&mut mechanism, &mut random, false);
                let body = mechanism.bodies.len() - 1;
                let point = near(&mechanism, base, &mut random);
                let is_sliding = random.chance(0.25);
                add_joint(&mut mechanism, &mut random, [base, Some(body)], point, is_sliding);
                let index = mechanism.joints.len() - 1;
                drive(&mut mechanism, &mut random, index);
            }
        }
    }
    if random.chance(0.6) {
        add_linear_spring(&mut mechanism, &mut random);
    }
    add_contacts(&mut mechanism, &mut random);
    add_tendon(&mut mechanism, &mut Random::for_seed(seed + 1_000_000));
    add_friction(&mut mechanism, &mut Random::for_seed(seed + 2_000_000));
    mechanism
}

fn random_base(mechanism: &Mechanism, random: &mut Random) -> Option<usize> {
    let index = (random.unit() * (mechanism.bodies.len() + 1) as f64) as usize;
    index.checked_sub(1)
}

/// Returns a mechanism of [`random_mechanism`] with components that these do not have: couplings, brakes, springs,
/// actuators and rotors on several joints, bristles, bodies that do not rotate, and prescribed motion of the bodies that
/// carry joints.
pub fn random_variant(seed: u64) -> Mechanism {
    let mut mechanism = random_mechanism(seed);
    let mut random = Random::for_seed(seed + 3_000_000);
    if random.chance(0.4) {
        add_base(&mut mechanism, &mut random);
    }
    let is_free = |index: &usize| !mechanism.joints.iter().any(|joint| joint.bodies.contains(&Some(*index)));
    let free: Vec<usize> = (0..mechanism.bodies.len()).filter(is_free).collect();
    for index in free.into_iter().filter(|index| mechanism.bodies[*index].motion.is_none()).collect::<Vec<_>>() {
        let body = &mut mechanism.bodies[index];
        match random.unit() {
            part if part < 0.3 => (body.inertia_kg_m2, body.rate[2]) = (f64::INFINITY, 0.0),
            part if part < 0.6 => {
                let acceleration_m_s2 = [random.within(-5.0, 5.0), random.within(-5.0, 5.0)];
                body.motion = Some(PrescribedMotion::ConstantAcceleration { acceleration_m_s2 });
            }
            _ => {}
        }
    }
    if random.chance(0.4) {
        add_coupling(&mut mechanism, &mut random);
    }
    if random.chance(0.4) {
        add_combinations(&mut mechanism, &mut random);
    }
    let bristle = Bristle { damping_n_s_per_m: 0.02, relaxation_s: 1e-3 };
    for actuator in &mut mechanism.actuators {
        if random.chance(0.4) {
            actuator.brake = Some(Brake {
                torque_n_m: random.log_within(1e-3, 0.1),
                start_s: random.within(0.0, 0.01),
                rise_s: random.log_within(1e-3, 1e-2),
                release_s: random.chance(0.5).then_some(0.015),
                one_way: random.chance(0.3),
                v_static_rad_s: random.log_within(0.1, 1.0),
                bristle: random.chance(0.5).then_some(bristle),
            });
        }
    }
    for joint in mechanism.joints.iter_mut().filter(|joint| joint.kind == JointKind::Revolute) {
        if let Some(friction) = joint.friction.as_mut().filter(|_| random.chance(0.4)) {
            friction.kind = FrictionKind::Bristle(bristle);
        }
    }
    mechanism
}

/// Puts joints, springs and eyelets of the ground on a body that moves: a palm, or one of constant acceleration.
fn add_base(mechanism: &mut Mechanism, random: &mut Random) {
    let base = Some(mechanism.bodies.len());
    let motion = if random.chance(0.5) {
        PrescribedMotion::Palm(random_palm_motion(random))
    } else {
        PrescribedMotion::ConstantAcceleration {
            acceleration_m_s2: [random.within(-20.0, 20.0), random.within(-20.0, 20.0)],
        }
    };
    let is_palm = matches!(motion, PrescribedMotion::Palm(_));
    add_body(mechanism, random, false);
    let body = mechanism.bodies.last_mut().expect("a body");
    (body.name, body.pose, body.motion) = ("base".to_string(), [0.0; 3], Some(motion));
    if !is_palm {
        body.rate = [random.within(-0.5, 0.5), random.within(-0.5, 0.5), random.within(-3.0, 3.0)];
    }
    let Mechanism { joints, springs, tendons, .. } = mechanism;
    let linear = springs.iter_mut().filter_map(|spring| match &mut spring.kind {
        SpringKind::Linear { bodies, .. } => Some(bodies),
        SpringKind::Torsional { .. } => None,
    });
    let pairs = joints.iter_mut().map(|joint| &mut joint.bodies).chain(linear).flatten();
    let eyelets = tendons.iter_mut().flat_map(|tendon| &mut tendon.path).map(|element| &mut element.body);
    // Some stay on the ground.
    let stay = random.chance(0.3);
    for (index, body) in pairs.chain(eyelets).filter(|body| body.is_none()).enumerate() {
        if !stay || index % 2 == 0 {
            *body = base;
        }
    }
}

/// Returns a mechanism of [`random_mechanism`] in another pose, whose ground moves, with or without its outlines.
pub fn random_moving_mechanism(seed: u64) -> Mechanism {
    let mut mechanism = random_mechanism(seed);
    let mut random = Random::for_seed(seed + 4_000_000);
    let initial_pose = [random.within(-0.2, 0.2), random.within(-0.2, 0.2), random.within(-3.0, 3.0)];
    let [x, y, turn] = initial_pose;
    let (sin, cos) = turn.sin_cos();
    let turned = |[u, v]: [f64; 2]| [cos * u - sin * v, sin * u + cos * v];
    for Body { pose, rate, .. } in &mut mechanism.bodies {
        let ([u, v], [vx, vy]) = (turned([pose[0], pose[1]]), turned([rate[0], rate[1]]));
        (*pose, *rate) = ([x + u, y + v, turn + pose[2]], [vx, vy, rate[2]]);
    }
    let motion = random_palm_motion(&mut random);
    let stays = random.chance(0.3);
    mechanism.move_frame(PalmMotion { initial_pose, ..motion }, |_| stays);
    for outline in &mut mechanism.ground_outlines {
        outline.shape = outline.shape.moved([x, y], turn);
    }
    mechanism
}

fn random_palm_motion(random: &mut Random) -> PalmMotion {
    let axes = [Axis::X, Axis::Y, Axis::Angle];
    let size = |axis: Axis| if matches!(axis, Axis::Angle) { 1.0 } else { 0.1 };
    let moves = axes.map(|axis| Move {
        axis,
        distance: size(axis) * random.within(-0.3, 0.3),
        start_s: random.within(0.0, 5e-3),
        length_s: random.within(0.01, 0.05),
    });
    let axis = random.choose(&axes);
    let shake = Vibration {
        axis,
        amplitude: size(axis) * random.log_within(1e-4, 1e-2),
        frequency_hz: random.log_within(20.0, 200.0),
        phase_rad: random.within(-PI, PI),
        start_s: random.within(0.0, 5e-3),
        ramp_periods: 1.0,
        ramp: Ramp::Quintic,
    };
    PalmMotion { moves: moves.to_vec(), vibrations: vec![shake], ..PalmMotion::default() }
}

/// Joints that have a start, and are thus independent, with their start.
fn independent(mechanism: &Mechanism) -> Vec<(usize, f64)> {
    mechanism.joints.iter().enumerate().filter_map(|(index, joint)| Some((index, joint.start?))).collect()
}

/// Couples two independent joints.
fn add_coupling(mechanism: &mut Mechanism, random: &mut Random) {
    let joints = independent(mechanism);
    let [(first, a), .., (second, b)] = joints[..] else { return };
    let ratio = random.within(0.3, 2.0) * random.choose(&[1.0, -1.0]);
    mechanism.joints[second].start = None;
    mechanism.joints[second].start_rate = 0.0;
    let on = JointCombination { terms: vec![(first, 1.0), (second, ratio)], offset: a + ratio * b };
    mechanism.couplings.push(Coupling { name: "gear".to_string(), on });
}

/// Adds a spring, an actuator and a rotor on two pins.
fn add_combinations(mechanism: &mut Mechanism, random: &mut Random) {
    let is_pin = |(joint, _): &(usize, f64)| mechanism.joints[*joint].kind == JointKind::Revolute;
    let joints: Vec<(usize, f64)> = independent(mechanism).into_iter().filter(is_pin).collect();
    let [(first, a), .., (second, b)] = joints[..] else { return };
    let on = |factor: f64| JointCombination { terms: vec![(first, 1.0), (second, factor)], offset: a + factor * b };
    let sign = random.choose(&[1.0, -1.0]);
    mechanism.springs.push(Spring {
        name: "both".to_string(),
        kind: SpringKind::Torsional { on: on(sign), preload: random.within(-0.02, 0.02) },
        stiffness: random.log_within(1e-2, 1.0),
        damping: random.log_within(1e-6, 1e-4),
        rest: random.within(-0.3, 0.3),
    });
    mechanism.rotors.push(Rotor { name: "both".to_string(), on: on(sign), inertia: random.log_within(1e-7, 1e-5) });
    if mechanism.actuators.len() < 8 {
        mechanism.actuators.push(Actuator {
            name: "both".to_string(),
            on: on(sign),
            command: Command::Effort(Profile::Constant { value: random.within(-0.05, 0.05) }),
            limit: None,
            no_load_speed: random.chance(0.5).then(|| random.log_within(20.0, 200.0)),
            brake: None,
            powertrain: Powertrain::default(),
        });
    }
}

/// A point of the world near a body.
fn near(mechanism: &Mechanism, body: Option<usize>, random: &mut Random) -> [f64; 2] {
    let [x, y, _] = body.map_or([0.0; 3], |body| mechanism.bodies[body].pose);
    [x + random.within(-0.05, 0.05), y + random.within(-0.05, 0.05)]
}

fn add_body(mechanism: &mut Mechanism, random: &mut Random, is_free: bool) {
    let velocity = if is_free { 0.5 } else { 0.0 };
    let name = format!("body{}", mechanism.bodies.len());
    let body = Body::new(name, random.log_within(0.01, 0.1), random.log_within(3e-6, 1e-4));
    mechanism.bodies.push(Body {
        com_m: [random.within(-0.02, 0.02), random.within(-0.02, 0.02)],
        pose: [random.within(-0.1, 0.1), random.within(-0.05, 0.15), random.within(-PI, PI)],
        rate: [(); 3].map(|()| velocity * random.within(-1.0, 1.0)),
        ..body
    });
}

/// Coordinates of a point of the world in the frame of a body.
pub fn local(mechanism: &Mechanism, body: Option<usize>, [x, y]: [f64; 2]) -> [f64; 2] {
    let [bx, by, angle] = body.map_or([0.0; 3], |body| mechanism.bodies[body].pose);
    let ([dx, dy], sin, cos) = ([x - bx, y - by], angle.sin(), angle.cos());
    [cos * dx + sin * dy, cos * dy - sin * dx]
}

fn add_joint(
    mechanism: &mut Mechanism,
    random: &mut Random,
    mut bodies: [Option<usize>; 2],
    point: [f64; 2],
    is_sliding: bool,
) {
    if random.chance(0.3) && bodies[0].is_some() {
        bodies.swap(0, 1);
    }
    let angle = |body: Option<usize>| body.map_or(0.0, |body| mechanism.bodies[body].pose[2]);
    let turned = angle(bodies[1]) - angle(bodies[0]);
    let world_axis = random.within(-PI, PI);
    let slide = if is_sliding { random.within(0.0, 0.02) } else { 0.0 };
    let second = [point[0] + slide * world_axis.cos(), point[1] + slide * world_axis.sin()];
    let kind = match is_sliding {
        true => JointKind::Prismatic { axis_rad: world_axis - angle(bodies[0]) },
        false => JointKind::Revolute,
    };
    let name = format!("joint{}", mechanism.joints.len());
    let points_m = [local(mechanism, bodies[0], point), local(mechanism, bodies[1], second)];
    mechanism.joints.push(Joint {
        offset_rad: if is_sliding { turned } else { 0.0 },
        damping: if random.chance(0.5) { random.log_within(1e-6, 1e-3) } else { 0.0 },
        armature: if random.chance(0.2) { random.log_within(1e-7, 1e-5) } else { 0.0 },
        ..Joint::new(name, kind, bodies, points_m)
    });
}

/// Adds two bodies that close a loop between two others, away from singular configurations.
fn add_dyad(mechanism: &mut Mechanism, random: &mut Random) {
    let bases = [random_base(mechanism, random), random_base(mechanism, random)];
    let sliding = (random.unit() * 5.0) as usize;
    (0..2).for_each(|_| add_body(mechanism, random, false));
    let count = mechanism.bodies.len();
    let (first, second) = (count - 2, count - 1);
    let points = loop {
        let points = [near(mechanism, bases[0], random), near(mechanism, bases[1], random)];
        let inner = [0, 1].map(|k| 0.5 * (points[0][k] + points[1][k]) + random.within(-0.06, 0.06));
        let arms = points.map(|point| [inner[0] - point[0], inner[1] - point[1]]);
        let lengths = arms.map(|[x, y]| x.hypot(y));
        let sine = (arms[0][0] * arms[1][1] - arms[0][1] * arms[1][0]) / (lengths[0] * lengths[1]);
        if sine.abs() > 0.5 && lengths[0].min(lengths[1]) > 0.02 {
            break [points[0], inner, points[1]];
        }
    };
    let pairs = [[bases[0], Some(first)], [Some(first), Some(second)], [bases[1], Some(second)]];
    for (index, (pair, point)) in pairs.into_iter().zip(points).enumerate() {
        add_joint(mechanism, random, pair, point, index == sliding);
    }
}

/// Gives a joint a start, and some of them a spring, limits or an actuator.
fn drive(mechanism: &mut Mechanism, random: &mut Random, index: usize) {
    let poses: Vec<[f64; 3]> = mechanism.bodies.iter().map(|body| body.pose).collect();
    let joint = &mut mechanism.joints[index];
    let pose = |body: Option<usize>| body.map_or([0.0; 3], |body| poses[body]);
    let [a, b] = joint.bodies.map(pose);
    let world = |[x, y, angle]: [f64; 3], [px, py]: [f64; 2]| {
        [x + angle.cos() * px - angle.sin() * py, y + angle.sin() * px + angle.cos() * py]
    };
    let (start, size) = match joint.kind {
        JointKind::Revolute => (b[2] - a[2] - joint.offset_rad, 1.0),
        JointKind::Prismatic { axis_rad } => {
            let ([ax, ay], [bx, by]) = (world(a, joint.points_m[0]), world(b, joint.points_m[1]));
            let angle = a[2] + axis_rad;
            (angle.cos() * (bx - ax) + angle.sin() * (by - ay), 0.02)
        }
    };
    joint.start = Some(start);
    joint.start_rate = size * random.within(-5.0, 5.0);
    if random.chance(0.3) {
        let damping = Damping::HuntCrossley { factor_s_per_m: 0.2 };
        joint.limit = Some(NormalLaw { stiffness_n_per_m_e: 2e4, exponent: 1.5, damping });
        joint.lower = Some(start - size * random.within(0.02, 0.3));
        joint.upper = Some(start + size * random.within(0.02, 0.3));
    }
    if random.chance(0.4) {
        mechanism.springs.push(Spring {
            name: format!("spring{index}"),
            kind: SpringKind::Torsional { on: JointCombination::of_joint(index), preload: random.within(-0.05, 0.05) },
            stiffness: random.log_within(1e-2, 1.0) / size,
            damping: random.log_within(1e-6, 1e-4),
            rest: start + size * random.within(-0.5, 0.5),
        });
    }
    if random.chance(0.6) && mechanism.actuators.len() < 8 {
        let table = |values: [f64; 3]| Profile::Table {
            points: vec![(0.0, values[0]), (7e-3, values[1]), (16e-3, values[2])],
            interpolation: Interpolation::Linear,
        };
        let command = if random.chance(0.5) {
            Command::Effort(table([(); 3].map(|()| random.within(-0.05, 0.05) / size)))
        } else {
            let target = table([(); 3].map(|()| start + size * random.within(-0.5, 0.5)));
            Command::Servo {
                kp: random.log_within(0.05, 1.0),
                kd: random.log_within(1e-4, 1e-2),
                target,
                target_rate: None,
                rate_hz: None,
            }
        };
        mechanism.actuators.push(Actuator {
            name: format!("motor{index}"),
            on: JointCombination::of_joint(index),
            command,
            limit: random.chance(0.5).then(|| random.log_within(0.01, 0.1) / size),
            no_load_speed: random.chance(0.3).then(|| size * random.log_within(20.0, 200.0)),
            brake: None,
            powertrain: Powertrain::default(),
        });
    }
}

fn add_linear_spring(mechanism: &mut Mechanism, random: &mut Random) {
    let body = (random.unit() * mechanism.bodies.len() as f64) as usize;
    let bodies = [random_base(mechanism, random).filter(|other| *other != body), Some(body)];
    let points = [[-0.1, 0.2], [random.within(-0.02, 0.02), random.within(-0.02, 0.02)]];
    mechanism.springs.push(Spring {
        name: "coil".to_string(),
        kind: SpringKind::Linear { bodies, points_m: points },
        stiffness: random.log_within(10.0, 500.0),
        damping: random.log_within(1e-3, 1.0),
        rest: random.within(0.05, 0.2),
    });
}

/// Adds Coulomb friction to some joints.
fn add_friction(mechanism: &mut Mechanism, random: &mut Random) {
    for joint in &mut mechanism.joints {
        if !random.chance(0.3) {
            continue;
        }
        let size = if joint.kind == JointKind::Revolute { 1.0 } else { 0.02 };
        let torque = random.log_within(1e-4, 1e-2) / size;
        joint.friction = Some(FrictionLaw {
            mu_static: torque,
            mu_dynamic: torque * random.within(0.6, 1.0),
            v_static_m_s: 0.1 * size,
            v_dynamic_m_s: 0.2 * size,
            kind: FrictionKind::Regularised,
        });
    }
}

/// Adds a cable to some mechanisms: over eyelets and a pulley of random bodies, elastic, pulled, or both, on a spool of a
/// joint.
fn add_tendon(mechanism: &mut Mechanism, random: &mut Random) {
    if random.chance(0.5) {
        return;
    }
    let element = |random: &mut Random| PathElement {
        body: random_base(mechanism, random),
        point_m: [random.within(-0.04, 0.04), random.within(-0.04, 0.04)],
        radius_m: 0.0,
        side: random.choose(&[1.0, -1.0]),
        friction: None,
    };
    let mut path: Vec<PathElement> = (0..2 + (random.unit() * 3.0) as usize).map(|_| element(random)).collect();
    let poses: Vec<[f64; 3]> = mechanism.bodies.iter().map(|body| body.pose).collect();
    path.dedup_by(|a, b| {
        let [a, b] = [center_in(a, &poses), center_in(b, &poses)];
        (a[0] - b[0]).hypot(a[1] - b[1]) < 0.02
    });
    if path.len() < 2 {
        return;
    }
    if path.len() > 2 && random.chance(0.6) {
        path[1].radius_m = random.within(0.002, 0.006);
        let all_on = vec![Bend::Left; path.len()];
        let center = |element: &PathElement| center_in(element, &poses);
        let is_wrapped = |path: &[PathElement]| wraps(path, &all_on, center).all(|(_, wrap)| wrap > 0.4);
        if !is_wrapped(&path) {
            path[1].side *= -1.0;
        }
        path[1].radius_m *= f64::from(is_wrapped(&path));
    }
    let is_spool = |joint: &(usize, &Joint)| joint.1.kind == JointKind::Revolute && joint.1.start.is_some();
    let spool = mechanism.joints.iter().enumerate().rfind(is_spool).map(|(joint, _)| joint);
    let pull = random.chance(0.5).then(|| TendonActuator {
        name: "pull".to_string(),
        tension: Profile::Table {
            points: vec![(0.0, random.within(-1.0, 1.0)), (8e-3, random.within(-1.0, 2.0)), (14e-3, 0.3)],
            interpolation: Interpolation::Linear,
        },
    });
    let is_elastic = pull.is_none() || random.chance(0.5);
    let mut tendon = Tendon {
        name: "cable".to_string(),
        path,
        far_joints: Vec::new(),
        is_reversed: false,
        joints: spool.filter(|_| random.chance(0.5)).map(|joint| (joint, 0.005)).into_iter().collect(),
        stiffness_n_per_m: if is_elastic { random.log_within(20.0, 2e4) } else { 0.0 },
        damping_n_s_per_m: if is_elastic && random.chance(0.7) { random.log_within(1e-3, 2.0) } else { 0.0 },
        rest_m: 0.0,
        actuator: pull,
    };
    tendon.rest_m = length_in(mechanism, &tendon, &poses) + random.within(-1e-3, 1e-3);
    mechanism.tendons.push(tendon);
}

/// Adds discs to some bodies, which can touch the floor and bars of other bodies from a distance.
fn add_contacts(mechanism: &mut Mechanism, random: &mut Random) {
    let friction = FrictionLaw {
        mu_static: 0.6,
        mu_dynamic: 0.5,
        v_static_m_s: 0.01,
        v_dynamic_m_s: 0.02,
        kind: FrictionKind::Regularised,
    };
    let rolling = FrictionLaw { mu_static: 1e-4, mu_dynamic: 1e-4, v_static_m_s: 1.0, v_dynamic_m_s: 2.0, ..friction };
    let step = Damping::Step { max_n_s_per_m: 30.0, transition_m: 1e-4 };
    for body in 0..mechanism.bodies.len() {
        let [_, y, _] = mechanism.bodies[body].pose;
        if !random.chance(0.4) || y - GROUND_M < 0.03 {
            continue;
        }
        let radius_m = (0.5 * (y - GROUND_M)).min(0.02);
        let shape = OutlineShape::Disc { center_m: [0.0; 2], radius_m };
        mechanism.bodies[body].outlines.push(Outline { name: "rim".to_string(), shape });
        let damping = if random.chance(0.5) { step } else { Damping::HuntCrossley { factor_s_per_m: 1.0 } };
        let normal = NormalLaw { stiffness_n_per_m_e: 1e6, exponent: 1.5, damping };
        mechanism.contacts.push(ContactPair {
            name: None,
            points: OutlineId { body: Some(body), outline: 0 },
            face: OutlineId { body: None, outline: 0 },
            law: ContactLaw { normal, friction: random.chance(0.7).then_some(friction) },
            rolling: random.chance(0.5).then_some(rolling),
            force_point: random.choose(&[ForcePoint::Face, ForcePoint::Points, ForcePoint::Middle]),
            is_reported_on_face: false,
        });
    }
}
