//! Random loops whose joints make several turns, with a component on one of their joints.

use phalanx::drive::{Interpolation, Profile};
use phalanx::law::{Damping, NormalLaw};
use phalanx::mechanism::tendon::length_in;
use phalanx::mechanism::{
    Actuator, Body, Command, Coupling, Joint, JointCombination, JointKind, Mechanism, PathElement, Powertrain,
    PrescribedMotion, Spring, SpringKind, Tendon, assemble,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::random::Random;

/// A loop that is assembled at its start.
pub struct RandomLoop {
    pub mechanism: Mechanism,
    /// Kind of the loop, component, its joint, and the joint with the start.
    pub description: String,
    pub duration_s: f64,
}

/// A body with the centre of mass on its axis.
fn body(name: &str, random: &mut Random, length_m: f64, pose: [f64; 3]) -> Body {
    let mass_kg = random.within(0.02, 0.1);
    let inertia_kg_m2 = mass_kg * length_m * length_m * random.within(0.08, 0.3);
    let com_m = [random.within(0.2, 0.6) * length_m, 0.0];
    Body { com_m, pose, ..Body::new(name, mass_kg, inertia_kg_m2) }
}

fn polar(length: f64, angle: f64) -> [f64; 2] {
    [length * angle.cos(), length * angle.sin()]
}

/// The point at distances from two others, on the left or the right of the line from the first to the second.
fn apex([from, to]: [[f64; 2]; 2], [a, b]: [f64; 2], side: f64) -> [f64; 2] {
    let d = [to[0] - from[0], to[1] - from[1]];
    let squared = d[0] * d[0] + d[1] * d[1];
    let along = 0.5 + 0.5 * (a * a - b * b) / squared;
    let across = side * (a * a / squared - along * along).sqrt();
    [from[0] + along * d[0] - across * d[1], from[1] + along * d[1] + across * d[0]]
}

fn angle(from: [f64; 2], to: [f64; 2]) -> f64 {
    (to[1] - from[1]).atan2(to[0] - from[0])
}

/// A crank with a rod and a slider.
fn slider_crank(random: &mut Random, crank: f64) -> Mechanism {
    let r = random.within(0.02, 0.04);
    let l = r * random.within(1.6, 4.0);
    let (axis_rad, height) = (random.within(-PI, PI), random.within(-0.3, 0.3) * r);
    let tip = polar(r, crank);
    // In the frame of the slide.
    let local = |[x, y]: [f64; 2]| [x * axis_rad.cos() + y * axis_rad.sin(), y * axis_rad.cos() - x * axis_rad.sin()];
    let [x, y] = local(tip);
    let along = x + (l * l - (y - height).powi(2)).sqrt();
    let world = |[x, y]: [f64; 2]| [x * axis_rad.cos() - y * axis_rad.sin(), x * axis_rad.sin() + y * axis_rad.cos()];
    let (origin, slider) = (world([0.0, height]), world([along, height]));
    let turned = random.within(-PI, PI);
    let bodies = vec![
        body("crank", random, r, [0.0, 0.0, crank]),
        body("rod", random, l, [tip[0], tip[1], angle(tip, slider)]),
        Body { com_m: [0.0; 2], ..body("slider", random, 0.02, [slider[0], slider[1], turned]) },
    ];
    let slide = Joint {
        offset_rad: turned,
        ..Joint::new("slide", JointKind::Prismatic { axis_rad }, [None, Some(2)], [origin, [0.0; 2]])
    };
    let pin = JointKind::Revolute;
    let joints = vec![
        Joint::new("crank", pin, [None, Some(0)], [[0.0; 2]; 2]),
        Joint::new("pin", pin, [Some(0), Some(1)], [[r, 0.0], [0.0; 2]]),
        Joint::new("wrist", pin, [Some(1), Some(2)], [[l, 0.0], [0.0; 2]]),
        slide,
    ];
    Mechanism { bodies, joints, ..Mechanism::default() }
}

/// A four-bar with a crank that turns, or with two; the lengths satisfy Grashof's condition.
fn four_bar(random: &mut Random, crank: f64) -> Mechanism {
    let shortest = random.within(0.02, 0.03);
    let [mut a, mut b, mut c] = [0; 3].map(|_| shortest * random.within(1.3, 3.0));
    // Shortest plus longest is at most 0.95 of the others.
    let longest = a.max(b).max(c);
    let excess = shortest + longest - 0.95 * (a + b + c - longest);
    if excess > 0.0 {
        [a, b, c] = [a, b, c].map(|length| if length < longest { length + 0.55 * excess } else { length });
    }
    let is_drag_link = random.chance(0.4);
    let (ground, r) = if is_drag_link { (shortest, a) } else { (a, shortest) };
    let (tip, pivot) = (polar(r, crank), polar(ground, random.within(-PI, PI)));
    let side = random.choose(&[1.0, -1.0]);
    let end = apex([tip, pivot], [b, c], side);
    let bodies = vec![
        body("crank", random, r, [0.0, 0.0, crank]),
        body("coupler", random, b, [tip[0], tip[1], angle(tip, end)]),
        body("rocker", random, c, [pivot[0], pivot[1], angle(pivot, end)]),
    ];
    let pin = JointKind::Revolute;
    let joints = vec![
        Joint::new("crank", pin, [None, Some(0)], [[0.0; 2]; 2]),
        Joint::new("a", pin, [Some(0), Some(1)], [[r, 0.0], [0.0; 2]]),
        Joint::new("b", pin, [Some(1), Some(2)], [[b, 0.0], [c, 0.0]]),
        Joint::new("rocker", pin, [None, Some(2)], [pivot, [0.0; 2]]),
    ];
    Mechanism { bodies, joints, ..Mechanism::default() }
}

/// A crank whose block slides on a guide that swings, or turns with it.
fn swinging_guide(random: &mut Random, crank: f64) -> Mechanism {
    let r = random.within(0.02, 0.04);
    let distance = r * if random.chance(0.5) { random.within(1.4, 3.0) } else { random.within(0.3, 0.7) };
    let (tip, pivot) = (polar(r, crank), polar(distance, random.within(-PI, PI)));
    let guide = angle(pivot, tip);
    let bodies = vec![
        body("crank", random, r, [0.0, 0.0, crank]),
        body("guide", random, distance + r, [pivot[0], pivot[1], guide]),
        Body { com_m: [0.0; 2], ..body("block", random, 0.02, [tip[0], tip[1], guide]) },
    ];
    let pin = JointKind::Revolute;
    let joints = vec![
        Joint::new("crank", pin, [None, Some(0)], [[0.0; 2]; 2]),
        Joint::new("pin", pin, [Some(0), Some(2)], [[r, 0.0], [0.0; 2]]),
        Joint::new("slide", JointKind::Prismatic { axis_rad: 0.0 }, [Some(1), Some(2)], [[0.0; 2]; 2]),
        Joint::new("pivot", pin, [None, Some(1)], [pivot, [0.0; 2]]),
    ];
    Mechanism { bodies, joints, ..Mechanism::default() }
}

/// Two cranks with couplers between their ends: the line between them turns as the cranks do.
fn five_bar(random: &mut Random, crank: f64) -> Mechanism {
    let (long, short, ground) = (random.within(0.03, 0.04), random.within(0.005, 0.01), random.within(0.005, 0.01));
    let difference = random.within(-0.6, 0.6) * (long - short - ground);
    let mean = 0.6 * (long + short + ground);
    let [l, m] = [mean + 0.5 * difference, mean - 0.5 * difference];
    let other = random.within(-PI, PI);
    let (tip, pivot) = (polar(long, crank), polar(ground, random.within(-PI, PI)));
    let [x, y] = polar(short, other);
    let other_tip = [pivot[0] + x, pivot[1] + y];
    let end = apex([tip, other_tip], [l, m], random.choose(&[1.0, -1.0]));
    let bodies = vec![
        body("crank", random, long, [0.0, 0.0, crank]),
        body("other", random, short, [pivot[0], pivot[1], other]),
        body("first", random, l, [tip[0], tip[1], angle(tip, end)]),
        body("second", random, m, [other_tip[0], other_tip[1], angle(other_tip, end)]),
    ];
    let pin = JointKind::Revolute;
    let other_start = Joint {
        start: Some(other),
        start_rate: random.within(-40.0, 40.0),
        ..Joint::new("other", pin, [None, Some(1)], [pivot, [0.0; 2]])
    };
    let joints = vec![
        Joint::new("crank", pin, [None, Some(0)], [[0.0; 2]; 2]),
        Joint::new("a", pin, [Some(0), Some(2)], [[long, 0.0], [0.0; 2]]),
        Joint::new("b", pin, [Some(1), Some(3)], [[short, 0.0], [0.0; 2]]),
        Joint::new("tip", pin, [Some(2), Some(3)], [[l, 0.0], [m, 0.0]]),
        other_start,
    ];
    Mechanism { bodies, joints, ..Mechanism::default() }
}

/// A four-bar with two more bodies between the ground and its rocker (Watt's six-bar) or its coupler (Stephenson's), the
/// second one a link or a slider. Where both come into line, the crank may turn back.
fn six_bar(random: &mut Random, crank: f64) -> (&'static str, Mechanism) {
    let mut mechanism = four_bar(random, crank);
    let is_watt = random.chance(0.5);
    let base = if is_watt { 2 } else { 1 };
    let [x, y, turn] = mechanism.bodies[base].pose;
    let point = [random.within(0.02, 0.05), random.within(-0.02, 0.02)];
    let from = [x + point[0] * turn.cos() - point[1] * turn.sin(), y + point[0] * turn.sin() + point[1] * turn.cos()];
    let (a, b) = (random.within(0.06, 0.1), random.within(0.06, 0.1));
    let distance = random.within(0.4, 0.8) * (a + b);
    let [dx, dy] = polar(distance, random.within(-PI, PI));
    let pivot = [from[0] + dx, from[1] + dy];
    let end = apex([from, pivot], [a, b], random.choose(&[1.0, -1.0]));
    let link = mechanism.bodies.len();
    mechanism.bodies.push(body("link", random, a, [from[0], from[1], angle(from, end)]));
    let pin = JointKind::Revolute;
    mechanism.joints.push(Joint::new("knee", pin, [Some(base), Some(link)], [point, [0.0; 2]]));
    if random.chance(0.3) {
        // The axis is at least 60° off the link.
        let axis_rad = angle(from, end) + random.within(-PI, PI) / 3.0;
        mechanism.bodies.push(Body { com_m: [0.0; 2], ..body("output", random, 0.02, [end[0], end[1], 0.0]) });
        mechanism.joints.push(Joint::new("wrist", pin, [Some(link), Some(link + 1)], [[a, 0.0], [0.0; 2]]));
        let slide = JointKind::Prismatic { axis_rad };
        mechanism.joints.push(Joint::new("output", slide, [None, Some(link + 1)], [end, [0.0; 2]]));
    } else {
        mechanism.bodies.push(body("output", random, b, [pivot[0], pivot[1], angle(pivot, end)]));
        mechanism.joints.push(Joint::new("wrist", pin, [Some(link), Some(link + 1)], [[a, 0.0], [b, 0.0]]));
        mechanism.joints.push(Joint::new("output", pin, [None, Some(link + 1)], [pivot, [0.0; 2]]));
    }
    (if is_watt { "six-bar of Watt" } else { "six-bar of Stephenson" }, mechanism)
}

/// Returns a slider-crank, a four-bar or a six-bar, assembled, without a start, and the rate of its crank.
pub fn random_linkage(seed: u64) -> (&'static str, Mechanism, f64) {
    let mut random = Random::for_seed(seed ^ 0x5eed);
    let crank = random.within(-PI, PI);
    let (kind, mut mechanism) = match seed % 3 {
        0 => ("slider-crank", slider_crank(&mut random, crank)),
        1 => ("four-bar", four_bar(&mut random, crank)),
        _ => six_bar(&mut random, crank),
    };
    let rate = random.within(20.0, 60.0) * random.choose(&[1.0, -1.0]);
    let started = with_start(&mechanism, 0, crank, rate);
    let start = assemble(&started).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    for (body, pose) in mechanism.bodies.iter_mut().zip(&start.poses) {
        body.pose = *pose;
    }
    (kind, mechanism, rate)
}

/// The same mechanism with one of its bodies as the ground, which becomes a body in its place.
fn inverted(mechanism: &Mechanism, ground: usize) -> Mechanism {
    let mut inverted = mechanism.clone();
    let [x, y, turn] = mechanism.bodies[ground].pose;
    let (sin, cos) = turn.sin_cos();
    for body in &mut inverted.bodies {
        let [dx, dy] = [body.pose[0] - x, body.pose[1] - y];
        body.pose = [cos * dx + sin * dy, cos * dy - sin * dx, body.pose[2] - turn];
    }
    let frame = &mut inverted.bodies[ground];
    (frame.name, frame.com_m, frame.pose) =
        ("frame".to_string(), [0.01, 0.0], [-cos * x - sin * y, sin * x - cos * y, -turn]);
    for body in inverted.joints.iter_mut().flat_map(|joint| &mut joint.bodies) {
        *body = match *body {
            None => Some(ground),
            Some(body) if body == ground => None,
            other => other,
        };
    }
    inverted
}

/// Returns a six-bar of Stephenson on one of the two links of its long side, assembled: whatever its coordinate, four bodies
/// without a dyad among them are left. With it the coordinate of the joint `crank`, and a rate of it.
pub fn random_assur(seed: u64) -> (Mechanism, f64, f64) {
    let six_bars = (0..).map(|k| random_linkage(3 * (64 * seed + k) + 2));
    let mut stephenson = six_bars.filter(|(kind, ..)| *kind == "six-bar of Stephenson");
    let (_, mechanism, rate) = stephenson.next().expect("every second one");
    (inverted(&mechanism, 3 + (seed % 2) as usize), mechanism.bodies[0].pose[2], rate)
}

/// The same mechanism on a body that turns and accelerates in place of the ground.
pub fn on_moving_base(mechanism: &Mechanism) -> Mechanism {
    let mut moving = mechanism.clone();
    let base = moving.bodies.len();
    let motion = Some(PrescribedMotion::ConstantAcceleration { acceleration_m_s2: [4.0, -7.0] });
    moving.bodies.push(Body { motion, rate: [0.2, 0.3, 6.0], ..Body::new("base", 1.0, 1e-3) });
    moving.joints.iter_mut().flat_map(|joint| &mut joint.bodies).for_each(|body| *body = body.or(Some(base)));
    moving
}

/// Returns a six-bar of [`random_assur`] in motion, with a component on one of its joints.
pub fn random_assur_loop(seed: u64) -> RandomLoop {
    let (mechanism, crank, rate) = random_assur(seed);
    let mut mechanism = with_start(&mechanism, 0, crank, rate);
    let start = assemble(&mechanism).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    let component = COMPONENTS[seed as usize % COMPONENTS.len()];
    let on = (seed as usize / COMPONENTS.len()) % mechanism.joints.len();
    let (q, _) = start.joint(&mechanism.joints[on]);
    add_component(&mut mechanism, &mut Random::for_seed(seed), component, (on, q));
    let name = &mechanism.joints[on].name;
    RandomLoop { description: format!("six-bar on its long side, {component} on {name}"), mechanism, duration_s: 0.1 }
}

/// A mechanism with a start of a joint.
pub fn with_start(mechanism: &Mechanism, joint: usize, value: f64, rate: f64) -> Mechanism {
    let mut mechanism = mechanism.clone();
    (mechanism.joints[joint].start, mechanism.joints[joint].start_rate) = (Some(value), rate);
    mechanism
}

/// Number of joints on which the loops of [`random_loop`] can have their start and their component.
const JOINTS: usize = 4;

/// Components of [`random_loop`].
const COMPONENTS: [&str; 6] = ["stop", "spring", "coupling", "spool", "servo", "sum"];

/// Returns a loop whose crank starts at 40 to 80 rad/s. Any 24 successive multiples of 8 have all components on all joints.
pub fn random_loop(seed: u64) -> RandomLoop {
    let mut random = Random::for_seed(seed);
    let crank = random.within(-PI, PI);
    let (kind, mut mechanism) = match seed % 8 {
        0 | 3 | 6 => ("slider-crank", slider_crank(&mut random, crank)),
        1 | 4 | 5 => ("four-bar", four_bar(&mut random, crank)),
        2 => ("swinging guide", swinging_guide(&mut random, crank)),
        _ => ("five-bar", five_bar(&mut random, crank)),
    };
    (mechanism.joints[0].start, mechanism.joints[0].start_rate) =
        (Some(crank), random.within(40.0, 80.0) * random.choose(&[1.0, -1.0]));
    let start = assemble(&mechanism).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    for (body, pose) in mechanism.bodies.iter_mut().zip(&start.poses) {
        body.pose = *pose;
    }
    // The same start, given by another joint; a crank keeps it if the other joint is nearly at rest.
    let index = seed / 8;
    let started = (index as usize / COMPONENTS.len() + seed as usize) % JOINTS;
    let (value, rate) = start.joint(&mechanism.joints[started]);
    let scale = if mechanism.joints[started].kind == JointKind::Revolute { 1.0 } else { 0.03 };
    let started = if rate.abs() > 5.0 * scale && kind != "five-bar" { started } else { 0 };
    if started != 0 {
        (mechanism.joints[0].start, mechanism.joints[0].start_rate) = (None, 0.0);
        (mechanism.joints[started].start, mechanism.joints[started].start_rate) = (Some(value), rate);
    }
    let component = COMPONENTS[index as usize % COMPONENTS.len()];
    let on = (index as usize / COMPONENTS.len()) % JOINTS;
    let (q, _) = start.joint(&mechanism.joints[on]);
    add_component(&mut mechanism, &mut random, component, (on, q));
    let names = [on, started].map(|joint| mechanism.joints[joint].name.clone());
    RandomLoop {
        description: format!("{kind}, {component} on {}, start of {}", names[0], names[1]),
        mechanism,
        duration_s: 0.25,
    }
}

/// Adds a component on a joint with a coordinate at the start.
fn add_component(mechanism: &mut Mechanism, random: &mut Random, component: &str, (on, q): (usize, f64)) {
    let is_pin = mechanism.joints[on].kind == JointKind::Revolute;
    let pick = |pin: f64, slide: f64| if is_pin { pin } else { slide };
    let alone = JointCombination::of_joint(on);
    match component {
        "stop" => {
            let distance = pick(random.log_within(0.3, 14.0), random.log_within(0.003, 0.03));
            let joint = &mut mechanism.joints[on];
            match random.chance(0.5) {
                true => joint.lower = Some(q - distance),
                false => joint.upper = Some(q + distance),
            }
            let damping = Damping::HuntCrossley { factor_s_per_m: pick(0.3, 1.0) };
            joint.limit = Some(NormalLaw { stiffness_n_per_m_e: pick(2e3, 1e7), exponent: 1.5, damping });
        }
        "spring" => add_spring(mechanism, alone, [pick(2e-3, 10.0), q]),
        "sum" => {
            let pins: Vec<usize> =
                (0..JOINTS).filter(|joint| mechanism.joints[*joint].kind == JointKind::Revolute).collect();
            let other = pins[(on + 1) % pins.len()];
            let factor = random.within(0.5, 1.5) * random.choose(&[1.0, -1.0]);
            let terms = if other == on { vec![(on, 1.0)] } else { vec![(on, 1.0), (other, factor * pick(1.0, 0.02))] };
            add_spring(mechanism, JointCombination { terms, offset: 0.0 }, [pick(2e-3, 10.0), q]);
        }
        "coupling" => {
            let gear = mechanism.bodies.len();
            mechanism.bodies.push(Body { com_m: [0.0; 2], ..body("gear", random, 0.02, [-0.1, 0.0, 0.0]) });
            mechanism.joints.push(Joint::new("gear", JointKind::Revolute, [None, Some(gear)], [[-0.1, 0.0], [0.0; 2]]));
            let ratio = random.within(0.4, 1.5) * random.choose(&[1.0, -1.0]) * pick(1.0, 0.02);
            let terms = vec![(on, 1.0), (mechanism.joints.len() - 1, ratio)];
            mechanism.couplings.push(Coupling { name: "c".to_string(), on: JointCombination { terms, offset: q } });
            let gear = JointCombination::of_joint(mechanism.joints.len() - 1);
            add_spring(mechanism, gear, [2e-3, 0.0]);
        }
        "spool" => {
            // A slide has no spool.
            let on = if is_pin { on } else { 1 };
            let eyelet =
                |body: Option<usize>, point_m| PathElement { body, point_m, radius_m: 0.0, side: 1.0, friction: None };
            let mut tendon = Tendon {
                name: "cable".to_string(),
                path: vec![eyelet(None, polar(0.3, random.within(0.0, TAU))), eyelet(Some(2), [0.01, 0.005])],
                joints: vec![(on, random.choose(&[4e-3, -4e-3]))],
                far_joints: Vec::new(),
                is_reversed: false,
                stiffness_n_per_m: 20.0,
                damping_n_s_per_m: 0.01,
                rest_m: 0.0,
                actuator: None,
            };
            let poses: Vec<_> = mechanism.bodies.iter().map(|body| body.pose).collect();
            tendon.rest_m = length_in(mechanism, &tendon, &poses) - 0.01;
            mechanism.tendons.push(tendon);
        }
        _ => mechanism.actuators.push(Actuator {
            name: "servo".to_string(),
            on: alone,
            command: Command::Servo {
                kp: pick(3e-3, 20.0),
                kd: pick(1e-5, 0.05),
                target: Profile::Table {
                    points: vec![(0.0, q), (0.25, q + pick(random.within(-12.0, 12.0), random.within(-0.01, 0.01)))],
                    interpolation: Interpolation::Linear,
                },
                target_rate: None,
                rate_hz: None,
            },
            limit: None,
            no_load_speed: None,
            brake: None,
            powertrain: Powertrain::default(),
        }),
    }
}

fn add_spring(mechanism: &mut Mechanism, on: JointCombination, [stiffness, rest]: [f64; 2]) {
    mechanism.springs.push(Spring {
        name: "spring".to_string(),
        kind: SpringKind::Torsional { on, preload: 0.0 },
        stiffness,
        damping: 0.0,
        rest,
    });
}

/// A heavy crank whose end passes the pivot of a rocker at a small distance: the line between both turns by 260° while the
/// crank makes half a turn, most of it within a small motion. The other bodies are too light to limit steps.
pub fn quick_line(gap_m: f64) -> Mechanism {
    let mut random = Random::for_seed(1);
    let (r, crank) = (0.03, -FRAC_PI_2);
    let (l, m) = (0.03, 0.03 + 0.5 * gap_m);
    let (tip, pivot) = (polar(r, crank), [r - gap_m, 0.0]);
    let end = apex([tip, pivot], [l, m], 1.0);
    let light = |body: Body| Body { mass_kg: 1e-12, inertia_kg_m2: 1e-18, ..body };
    let bodies = vec![
        Body { inertia_kg_m2: 1e-3, ..body("crank", &mut random, r, [0.0, 0.0, crank]) },
        light(body("coupler", &mut random, l, [tip[0], tip[1], angle(tip, end)])),
        light(body("rocker", &mut random, m, [pivot[0], pivot[1], angle(pivot, end)])),
    ];
    let pin = JointKind::Revolute;
    let joints = vec![
        Joint { start: Some(crank), start_rate: 10.0, ..Joint::new("crank", pin, [None, Some(0)], [[0.0; 2]; 2]) },
        Joint::new("a", pin, [Some(0), Some(1)], [[r, 0.0], [0.0; 2]]),
        Joint::new("b", pin, [Some(1), Some(2)], [[l, 0.0], [m, 0.0]]),
        Joint::new("rocker", pin, [None, Some(2)], [pivot, [0.0; 2]]),
    ];
    Mechanism { bodies, joints, ..Mechanism::default() }
}
