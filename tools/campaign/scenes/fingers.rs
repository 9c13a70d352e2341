//! Texts of random finger scenes: all physical fields over decades, in three families.

use std::fmt::Write;

use super::law::{CONTACT, LIMIT, write_friction_law, write_normal_law};
use super::random::{Random, key, pair, quantity};

/// What the families differ in.
#[derive(Clone, Copy)]
struct Focus {
    /// Whether all fields vary.
    is_mixed: bool,
    limit_exponents: &'static [f64],
    exponents: &'static [f64],
    stiffness: [f64; 2],
    damping: [f64; 2],
    v_static: [f64; 2],
    /// Probabilities of a normal and a friction law in the section `contact`.
    laws: [f64; 2],
}

const MIXED: Focus = Focus {
    is_mixed: true,
    limit_exponents: &[1.0, 1.5, 2.2, 3.0],
    exponents: &[1.0, 1.5, 2.2, 2.2, 3.0],
    stiffness: [1e6, 1e10],
    damping: [10.0, 1e7],
    v_static: [1e-3, 0.3],
    laws: [0.9, 0.8],
};
const SOFT: Focus = Focus {
    is_mixed: false,
    limit_exponents: &[1.0, 1.5],
    exponents: &[1.0, 1.5],
    stiffness: [1e5, 1e8],
    damping: [10.0, 1e5],
    laws: [0.9, 0.5],
    ..MIXED
};
const STICK: Focus = Focus { is_mixed: false, v_static: [1e-4, 1e-2], laws: [0.5, 1.0], ..MIXED };

/// All fields.
pub fn mixed(rng: &mut Random) -> String {
    scene_text(rng, MIXED)
}

/// Soft linear and Hertzian springs of contacts and joint limit, with weak dampers.
pub fn soft(rng: &mut Random) -> String {
    scene_text(rng, SOFT)
}

/// Friction with sticking ranges down to 0.1 mm/s.
pub fn stick(rng: &mut Random) -> String {
    scene_text(rng, STICK)
}

fn scene_text(rng: &mut Random, focus: Focus) -> String {
    let is_mixed = focus.is_mixed;
    let mut text = String::new();
    let duration_s = rng.log_within(4e-3, 3.2e-2);
    key(&mut text, "duration", quantity(duration_s, "s"));
    if rng.chance(0.4) {
        let gravity = [rng.within(-40.0, 40.0), rng.within(-40.0, 40.0)];
        key(&mut text, "gravity", pair(gravity, "m/s^2"));
    }
    if rng.chance(0.3) {
        key(&mut text, "half_width", quantity(rng.within(0.5, 4.0), "mm"));
    }
    let is_other_assembly = is_mixed && rng.chance(0.12);
    if is_other_assembly {
        text.push_str("assembly = \"other\"\n");
    }
    let has_object = write_finger(rng, &mut text, is_mixed);
    if is_mixed {
        write_bodies(rng, &mut text);
    }
    write_motor(rng, &mut text, duration_s);
    write_spring(rng, &mut text);
    write_limit(rng, &mut text, focus);
    write_contacts(rng, &mut text, focus);
    write_initial(rng, &mut text, is_other_assembly || !has_object);
    text
}

/// Writes lengths and object; returns whether there is an object.
fn write_finger(rng: &mut Random, text: &mut String, is_mixed: bool) -> bool {
    let is_designed = !is_mixed || rng.chance(0.6);
    let base = rng.within(11.0, 22.5);
    if is_designed {
        let _ = writeln!(text, "[design]\nbase = {}", quantity(base, "mm"));
        let _ = writeln!(text, "l21_fraction = {:e}", rng.within(0.0, 1.0));
        key(text, "phi22", quantity(rng.within(88.0, 135.0), "deg"));
        let _ = writeln!(text, "arm_ratio = {:e}", rng.within(0.3, 0.8));
    } else {
        let _ = writeln!(text, "[lengths]\nl11 = {}", quantity(rng.within(12.0, 18.0), "mm"));
        key(text, "l21", quantity(rng.within(20.0, 32.0), "mm"));
        key(text, "l22", quantity(rng.within(5.0, 11.0), "mm"));
        key(text, "t22", quantity(rng.within(9.0, 18.0), "mm"));
        key(text, "phi22", quantity(rng.within(85.0, 135.0), "deg"));
    }
    text.push_str("[object]\n");
    if is_mixed && rng.chance(0.08) {
        text.push_str("present = false\n");
        return false;
    }
    if !is_designed {
        let radius = rng.within(15.0, 24.0);
        let centre = [-rng.within(11.0, 27.0), radius + rng.choose(&[0.0, 1.0, 4.0, 9.0])];
        let _ = writeln!(text, "radius = {}\ncentre = {}", quantity(radius, "mm"), pair(centre, "mm"));
    }
    true
}

/// Writes masses of some bodies, with or without their other properties.
fn write_bodies(rng: &mut Random, text: &mut String) {
    if rng.chance(0.2) {
        let _ = writeln!(text, "[material]\ndensity = {}", quantity(rng.log_within(500.0, 8e3), "kg/m^3"));
    }
    for name in ["l11", "l12", "l21", "l22"] {
        if !rng.chance(0.2) {
            continue;
        }
        let _ = writeln!(text, "[bodies.{name}]\nmass = {}", quantity(rng.log_within(1.0, 100.0), "g"));
        if rng.chance(0.6) {
            key(text, "com", pair([rng.within(0.0, 22.0), rng.within(-7.0, 7.0)], "mm"));
            key(text, "inertia", quantity(rng.log_within(2e-8, 5e-6), "kg*m^2"));
        }
    }
}

fn write_motor(rng: &mut Random, text: &mut String, duration_s: f64) {
    let torque = |rng: &mut Random| {
        let sign = if rng.chance(0.1) { -1.0 } else { 1.0 };
        quantity(sign * rng.log_within(100.0, 1500.0), "N*mm")
    };
    let profile = rng.choose(&["constant", "constant", "constant", "ramp", "half-sine", "reversal", "table"]);
    let _ = writeln!(text, "[motor]\nprofile = \"{profile}\"");
    if profile == "table" {
        let count = rng.choose(&[2, 3, 6]);
        let mut time = 0.0;
        let next_time = |_| {
            time += duration_s * rng.log_within(0.02, 0.5);
            quantity(time, "s")
        };
        let times: Vec<String> = (0..count).map(next_time).collect();
        let torques: Vec<String> = (0..count).map(|_| torque(rng)).collect();
        let (times, torques) = (times.join(", "), torques.join(", "));
        let interpolation = rng.choose(&["linear", "step"]);
        let _ = writeln!(text, "times = [{times}]\ntorques = [{torques}]\ninterpolation = \"{interpolation}\"");
        return;
    }
    key(text, "torque", torque(rng));
    let name = match profile {
        "ramp" => "rise",
        "half-sine" => "pulse",
        "reversal" => "reverse_at",
        _ => return,
    };
    key(text, name, quantity(duration_s * rng.log_within(0.1, 1.0), "s"));
}

fn write_spring(rng: &mut Random, text: &mut String) {
    let kind = rng.choose(&["none", "constant", "constant", "constant", "torsional"]);
    let _ = writeln!(text, "[spring]\ntype = \"{kind}\"");
    if kind == "none" {
        return;
    }
    let placement = rng.choose(&["q22", "q22", "q22", "q12", "q21-q11", "q11+q12-(q21+q22)"]);
    let _ = writeln!(text, "placement = \"{placement}\"");
    if kind == "constant" {
        key(text, "torque", quantity(rng.log_within(20.0, 300.0), "N*mm"));
    } else {
        let stiffness = quantity(rng.log_within(10.0, 500.0), "N*mm/rad");
        let _ = writeln!(text, "stiffness = {stiffness}\npreload = {}", quantity(rng.within(0.0, 90.0), "deg"));
    }
}

fn write_limit(rng: &mut Random, text: &mut String, focus: Focus) {
    if rng.chance(0.1) {
        text.push_str("[limit]\nenabled = false\n");
    } else if rng.chance(0.5) {
        let exponent = rng.choose(focus.limit_exponents);
        let stiffness = rng.log_within(1e4, 1e12);
        let damping = if rng.chance(0.1) { 0.0 } else { rng.log_within(1.0, 1e10) };
        write_normal_law(text, "limit", LIMIT, [stiffness, exponent, damping, rng.log_within(1e-6, 1e-3)]);
    }
}

fn write_contacts(rng: &mut Random, text: &mut String, focus: Focus) {
    for section in ["contact", "contact.proximal", "contact.distal"] {
        let [normal, friction] = if section == "contact" { focus.laws } else { [0.15; 2] };
        if rng.chance(normal) {
            let (exponent, stiffness) =
                (rng.choose(focus.exponents), rng.log_within(focus.stiffness[0], focus.stiffness[1]));
            let damping = if rng.chance(0.07) { 0.0 } else { rng.log_within(focus.damping[0], focus.damping[1]) };
            write_normal_law(text, section, CONTACT, [stiffness, exponent, damping, rng.log_within(1e-6, 1e-4)]);
        }
        if rng.chance(friction) {
            write_friction_law(rng, text, section, focus.v_static, [0.05, 1.4], 1.2);
        }
    }
}

/// Writes the initial state: the start posture of the design, or random angles.
fn write_initial(rng: &mut Random, text: &mut String, needs_angles: bool) {
    if needs_angles || rng.chance(0.15) {
        let q21 = rng.within(15.0, 70.0);
        let _ = writeln!(text, "[initial]\nq21 = {}", quantity(q21, "deg"));
        if needs_angles || rng.chance(0.3) {
            key(text, "q11", quantity(q21 - rng.within(60.0, 95.0), "deg"));
        }
    } else if rng.chance(0.2) {
        let _ = writeln!(text, "[initial]\noffset = {}", quantity(rng.log_within(0.1, 30.0), "deg"));
    } else {
        return;
    }
    if rng.chance(0.3) {
        for rate in ["qd11", "qd21"] {
            let _ = writeln!(text, "{rate} = {}", quantity(rng.within(-100.0, 200.0), "rad/s"));
        }
    }
}
