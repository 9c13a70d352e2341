//! Parts of mechanisms in scene texts: outlines, bodies, losses and drives of joints, contacts.

use std::f64::consts::{PI, TAU};

use super::random::{Random, key, pair, quantity};

/// Types of outlines, and the bounds of the rounding of corners as a fraction of half the size.
#[derive(Clone, Copy)]
pub struct Shapes {
    pub kinds: &'static [&'static str],
    pub rounding: [f64; 2],
}

pub const ANY: Shapes = Shapes { kinds: &["box", "polygon", "capsule", "disc", "ellipse"], rounding: [0.02, 0.2] };
/// Outlines that an ellipse can touch.
pub const FACES: Shapes = Shapes { kinds: &["box", "polygon", "capsule", "disc"], ..ANY };

/// Units of a joint: of its force or torque, its coordinate and its inertia.
pub type Units = [&'static str; 3];
pub const TURN: Units = ["N*m", "rad", "kg*m^2"];
pub const SLIDE: Units = ["N", "m", "kg"];

/// Returns an outline within a circle about `center` whose diameter is `size`, as an inline table; lengths in mm.
pub fn outline(rng: &mut Random, size: f64, [x, y]: [f64; 2], shapes: Shapes) -> String {
    let half = 0.5 * size;
    let length = |value: f64| quantity(value, "mm");
    let (center, kind) = (pair([x, y], "mm"), rng.choose(shapes.kinds));
    let keys = match kind {
        "disc" => format!("center = {center}, radius = {}", length(half)),
        "ellipse" => {
            let axes = pair([half, half * rng.within(0.35, 0.95)], "mm");
            format!("center = {center}, semi_axes = {axes}, angle = {}", quantity(rng.within(0.0, 180.0), "deg"))
        }
        "capsule" => {
            let (radius, turn) = (half * rng.within(0.2, 0.6), rng.within(0.0, PI));
            let [dx, dy] = [turn.cos(), turn.sin()].map(|part| (half - radius) * part);
            let [from, to] = [pair([x - dx, y - dy], "mm"), pair([x + dx, y + dy], "mm")];
            format!("from = {from}, to = {to}, radius = {}", length(radius))
        }
        _ => {
            let rounding = length(half * rng.log_within(shapes.rounding[0], shapes.rounding[1]));
            if kind == "box" {
                let turn = rng.within(0.4, 1.2);
                let sides = pair([turn.cos(), turn.sin()].map(|part| size * part), "mm");
                let angle = if rng.chance(0.4) { rng.within(0.0, 90.0) } else { 0.0 };
                let angle = quantity(angle, "deg");
                format!("center = {center}, size = {sides}, angle = {angle}, rounding = {rounding}")
            } else {
                // Points of a circle are a convex polygon.
                let corners = rng.choose(&[3, 4, 5, 6]);
                let corner = |index: i32| TAU * (f64::from(index) + rng.within(-0.25, 0.25)) / f64::from(corners);
                let angles: Vec<f64> = (0..corners).map(corner).collect();
                let vertex = |angle: &f64| pair([x + half * angle.cos(), y + half * angle.sin()], "mm");
                let vertices: Vec<String> = angles.iter().map(vertex).collect();
                format!("vertices = [{}], rounding = {rounding}", vertices.join(", "))
            }
        }
    };
    format!("{{ type = \"{kind}\", {keys} }}")
}

/// Returns mass and inertia of a body of this size.
pub fn bulk(rng: &mut Random, mass_g: f64, size_mm: f64) -> String {
    let inertia = quantity(mass_g * size_mm * size_mm * rng.within(0.1, 0.3), "g*mm^2");
    format!("mass = {}\ninertia = {inertia}\n", quantity(mass_g, "g"))
}

/// State of a free body at the start: mm, degrees, m/s and rad/s.
#[derive(Clone, Copy, Default)]
pub struct Start {
    pub at: [f64; 2],
    pub angle: f64,
    pub velocity: [f64; 2],
    pub spin: f64,
}

/// Returns the beginning of the section of a free body.
pub fn started(name: &str, start: Start) -> String {
    let ([at, velocity], angle) = ([pair(start.at, "mm"), pair(start.velocity, "m/s")], quantity(start.angle, "deg"));
    let spin = quantity(start.spin, "rad/s");
    format!("[bodies.{name}]\nstart = {{ at = {at}, angle = {angle}, velocity = {velocity}, spin = {spin} }}\n")
}

/// Returns a free body of one or two outlines, with mass properties or a density.
pub fn free_body(rng: &mut Random, name: &str, size_mm: f64, shapes: Shapes, start: Start) -> String {
    let outlines = if rng.chance(0.25) {
        let [left, right] = [-1.0, 1.0].map(|side| outline(rng, 0.475 * size_mm, [side * 0.25 * size_mm, 0.0], shapes));
        format!("a = {left}\nb = {right}\n")
    } else {
        format!("skin = {}\n", outline(rng, size_mm, [0.0; 2], shapes))
    };
    let mut text = started(name, start);
    if rng.chance(0.5) {
        key(&mut text, "density", quantity(rng.log_within(300.0, 8000.0), "kg/m^3"));
        key(&mut text, "depth", quantity(rng.log_within(5.0, 60.0), "mm"));
    } else {
        let mass_g = rng.log_within(5.0, 500.0);
        text.push_str(&bulk(rng, mass_g, size_mm));
        if rng.chance(0.3) {
            key(&mut text, "com", pair([(); 2].map(|()| rng.within(-0.1, 0.1) * size_mm), "mm"));
        }
    }
    text + &format!("[bodies.{name}.outlines]\n{outlines}")
}

/// Returns a contact of two outlines.
pub fn contact(rng: &mut Random, first: &str, second: &str, law: &str) -> String {
    let mut text = format!("[[contacts]]\nbetween = [\"{first}\", \"{second}\"]\nlaw = \"{law}\"\n");
    if rng.chance(0.2) {
        key(&mut text, "rolling_arm", quantity(rng.log_within(0.01, 1.0), "mm"));
        key(&mut text, "rolling_rate", quantity(rng.log_within(0.1, 3.0), "rad/s"));
    }
    if rng.chance(0.2) {
        key(&mut text, "at", format_args!("\"{}\"", rng.choose(&["points", "middle", "each"])));
    }
    text
}

/// Returns damping, friction and armature of a joint whose drive has this torque or force.
pub fn joint_losses(rng: &mut Random, effort: f64, [force, angle, inertia]: Units) -> String {
    let mut text = String::new();
    if rng.chance(0.4) {
        let damping = effort * rng.log_within(1e-4, 1e-2);
        key(&mut text, "damping", quantity(damping, format_args!("{force}*s/{angle}")));
    }
    if rng.chance(0.4) {
        let friction = effort * rng.log_within(0.01, 0.3);
        key(&mut text, "friction", quantity(friction, force));
        if rng.chance(0.4) {
            key(&mut text, "static_friction", quantity(friction * rng.within(1.0, 1.6), force));
        }
        if rng.chance(0.5) {
            let stiffness = friction * rng.log_within(1e2, 1e5);
            key(&mut text, "friction_stiffness", quantity(stiffness, format_args!("{force}/{angle}")));
        } else if rng.chance(0.5) {
            let slow = rng.log_within(1e-3, 0.1);
            key(&mut text, "friction_rates", pair([slow, 2.0 * slow], &format!("{angle}/s")));
        }
    }
    if rng.chance(0.2) {
        key(&mut text, "armature", quantity(effort * rng.log_within(1e-6, 1e-4), inertia));
    }
    text
}

/// Task of a drive, in SI units and ms: it moves an inertia by `travel` from `start`.
#[derive(Clone, Copy)]
pub struct Task {
    pub effort: f64,
    pub inertia: f64,
    pub start: f64,
    pub travel: f64,
    pub duration_ms: f64,
}

/// Returns a drive: a torque or force, constant or over time, a servo, or a servo with a rate; some have a brake.
pub fn drive(rng: &mut Random, task: Task, [force, angle, _]: Units) -> String {
    let Task { effort, inertia, start, travel, duration_ms } = task;
    let name = if angle == "rad" { "torque" } else { "force" };
    let per_angle = |value: f64, unit: &str| quantity(value, format_args!("{unit}/{angle}"));
    let (sign, speed) = (travel.signum(), travel.abs() / (duration_ms * 1e-3));
    let mut text = String::new();
    match rng.choose(&["constant", "table", "target", "targets", "servo"]) {
        "constant" => key(&mut text, name, quantity(sign * effort, force)),
        "table" => {
            let (times, values) = table(rng, duration_ms, force, |rng| sign * effort * rng.within(-0.5, 1.5));
            text.push_str(&format!("times = {times}\n{name}s = {values}\n"));
        }
        how => {
            let omega = rng.log_within(3.0, 30.0) / (duration_ms * 1e-3);
            key(&mut text, "kp", per_angle(inertia * omega * omega, force));
            key(&mut text, "limit", quantity(effort * rng.log_within(0.5, 3.0), force));
            let damping = 2.0 * rng.within(0.3, 1.2) * inertia * omega;
            key(&mut text, "kd", per_angle(damping, &format!("{force}*s")));
            if how == "targets" {
                key(&mut text, "times", pair([0.0, rng.within(0.4, 1.0) * duration_ms], "ms"));
                key(&mut text, "targets", pair([start, start + travel], angle));
            } else {
                key(&mut text, "target", quantity(start + travel, angle));
                if rng.chance(0.6) {
                    let rate = speed * rng.log_within(0.5, 5.0);
                    key(&mut text, "target_rate", quantity(rate, format_args!("{angle}/s")));
                }
            }
            if how == "servo" {
                key(&mut text, "rate", quantity(omega * rng.within(4.0, 20.0), "Hz"));
            }
        }
    }
    if rng.chance(0.25) {
        key(&mut text, "no_load_speed", quantity(speed * rng.log_within(1.0, 10.0), format_args!("{angle}/s")));
    }
    if rng.chance(0.35) {
        let mut brake = vec![
            format!("limit = {}", quantity(effort * rng.log_within(0.3, 10.0), force)),
            format!("at = {}", quantity(rng.within(0.0, 0.8) * duration_ms, "ms")),
        ];
        let others = [
            (0.4, "release", quantity(rng.within(0.85, 1.0) * duration_ms + 1.0, "ms")),
            (0.5, "rise", quantity(rng.log_within(0.1, 3.0), "ms")),
            (0.5, "stiffness", per_angle(effort * rng.log_within(1e2, 1e5), force)),
            (0.3, "one_way", "true".to_string()),
        ];
        for (_, name, value) in others.into_iter().filter(|(probability, ..)| rng.chance(*probability)) {
            brake.push(format!("{name} = {value}"));
        }
        key(&mut text, "brake", format_args!("{{ {} }}", brake.join(", ")));
    }
    text
}

/// Returns three random times and the values at them as arrays.
pub fn table(
    rng: &mut Random,
    duration_ms: f64,
    unit: &str,
    mut value: impl FnMut(&mut Random) -> f64,
) -> (String, String) {
    let mut times = [(); 3].map(|()| rng.within(0.0, duration_ms));
    times.sort_by(f64::total_cmp);
    let array = |values: [String; 3]| format!("[{}]", values.join(", "));
    (array(times.map(|time| quantity(time, "ms"))), array(times.map(|_| quantity(value(rng), unit))))
}
