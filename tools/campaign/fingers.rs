//! Texts of random finger scenes: all physical fields over decades, in three families.

use std::fmt::Write;

use super::random::{Random, pair, quantity, write_friction_law, write_normal_law};

/// Focus of a family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Focus {
    /// All fields.
    Mixed,
    /// Soft linear and Hertzian springs of contacts and joint limit, with weak dampers.
    Soft,
    /// Friction with sticking ranges down to 0.1 mm/s.
    Stick,
}

pub fn mixed(rng: &mut Random) -> String {
    scene_text(rng, Focus::Mixed)
}

pub fn soft(rng: &mut Random) -> String {
    scene_text(rng, Focus::Soft)
}

pub fn stick(rng: &mut Random) -> String {
    scene_text(rng, Focus::Stick)
}

fn scene_text(rng: &mut Random, focus: Focus) -> String {
    let is_mixed = focus == Focus::Mixed;
    let mut text = String::new();
    let duration_s = rng.log_within(4e-3, 3.2e-2);
    let _ = writeln!(text, "duration = {}", quantity(duration_s, "s"));
    if rng.chance(0.4) {
        let gravity = [rng.within(-40.0, 40.0), rng.within(-40.0, 40.0)];
        let _ = writeln!(text, "gravity = {}", pair(gravity, "m/s^2"));
    }
    if rng.chance(0.3) {
        let _ = writeln!(text, "half_width = {}", quantity(rng.within(0.5, 4.0), "mm"));
    }
    let is_other_assembly = is_mixed && rng.chance(0.12);
    if is_other_assembly {
        text.push_str("assembly = \"other\"\n");
    }
    let has_object = write_finger(rng, &mut text, is_mixed);
    if is_mixed {
        write_bodies(rng, &mut text, false);
    }
    write_motor(rng, &mut text, duration_s, false);
    write_spring(rng, &mut text, false);
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
        let _ = writeln!(text, "phi22 = {}", quantity(rng.within(88.0, 135.0), "deg"));
        let _ = writeln!(text, "arm_ratio = {:e}", rng.within(0.3, 0.8));
    } else {
        let _ = writeln!(text, "[lengths]\nl11 = {}", quantity(rng.within(12.0, 18.0), "mm"));
        let _ = writeln!(text, "l21 = {}", quantity(rng.within(20.0, 32.0), "mm"));
        let _ = writeln!(text, "l22 = {}", quantity(rng.within(5.0, 11.0), "mm"));
        let _ = writeln!(text, "t22 = {}", quantity(rng.within(9.0, 18.0), "mm"));
        let _ = writeln!(text, "phi22 = {}", quantity(rng.within(85.0, 135.0), "deg"));
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

/// Writes masses of some bodies, with or without their other properties; with `extreme` ranges, they differ by decades.
pub fn write_bodies(rng: &mut Random, text: &mut String, extreme: bool) {
    if rng.chance(0.2) {
        let density = if extreme { rng.log_within(100.0, 2e4) } else { rng.log_within(500.0, 8e3) };
        let _ = writeln!(text, "[material]\ndensity = {}", quantity(density, "kg/m^3"));
    }
    for name in ["l11", "l12", "l21", "l22"] {
        if !rng.chance(if extreme { 0.15 } else { 0.2 }) {
            continue;
        }
        let mass = if extreme { rng.log_within(1e-2, 1e3) } else { rng.log_within(1.0, 100.0) };
        let _ = writeln!(text, "[bodies.{name}]\nmass = {}", quantity(mass, "g"));
        if rng.chance(if extreme { 0.5 } else { 0.6 }) {
            let (com, inertia) = match extreme {
                true => ([rng.within(-5.0, 25.0), rng.within(-10.0, 10.0)], rng.log_within(1e-10, 1e-4)),
                false => ([rng.within(0.0, 22.0), rng.within(-7.0, 7.0)], rng.log_within(2e-8, 5e-6)),
            };
            let _ = writeln!(text, "com = {}\ninertia = {}", pair(com, "mm"), quantity(inertia, "kg*m^2"));
        }
    }
}

pub fn write_motor(rng: &mut Random, text: &mut String, duration_s: f64, extreme: bool) {
    let torque = |rng: &mut Random| {
        let sign = if rng.chance(if extreme { 0.15 } else { 0.1 }) { -1.0 } else { 1.0 };
        let size = if extreme { rng.log_within(10.0, 3e3) } else { rng.log_within(100.0, 1500.0) };
        quantity(sign * size, "N*mm")
    };
    let profiles = ["constant", "constant", "constant", "ramp", "half-sine", "reversal", "table"];
    let profile = rng.choose(if extreme { &profiles[2..] } else { &profiles });
    let _ = writeln!(text, "[motor]\nprofile = \"{profile}\"");
    if profile == "table" {
        let count = rng.choose(if extreme { &[1, 2, 5, 12][..] } else { &[2, 3, 6] });
        let mut time = 0.0;
        let times: Vec<String> = (0..count)
            .map(|k| match extreme {
                true => quantity(duration_s * f64::from(k) / f64::from(count), "s"),
                false => {
                    time += duration_s * rng.log_within(0.02, 0.5);
                    quantity(time, "s")
                }
            })
            .collect();
        let torques: Vec<String> = (0..count).map(|_| torque(rng)).collect();
        let (times, torques) = (times.join(", "), torques.join(", "));
        let interpolation = rng.choose(&["linear", "step"]);
        let _ = writeln!(text, "times = [{times}]\ntorques = [{torques}]\ninterpolation = \"{interpolation}\"");
        return;
    }
    let _ = writeln!(text, "torque = {}", torque(rng));
    let key = match profile {
        "ramp" => "rise",
        "half-sine" => "pulse",
        "reversal" => "reverse_at",
        _ => return,
    };
    let fraction = if extreme { rng.log_within(0.01, 2.0) } else { rng.log_within(0.1, 1.0) };
    let _ = writeln!(text, "{key} = {}", quantity(duration_s * fraction, "s"));
}

pub fn write_spring(rng: &mut Random, text: &mut String, extreme: bool) {
    let last_kind = if extreme { "torsional" } else { "constant" };
    let kind = rng.choose(&["none", "constant", "constant", last_kind, "torsional"]);
    let _ = writeln!(text, "[spring]\ntype = \"{kind}\"");
    if kind == "none" {
        return;
    }
    let placements = ["q22", "q22", "q22", "q12", "q21-q11", "q11+q12-(q21+q22)"];
    let placement = rng.choose(if extreme { &placements[1..] } else { &placements });
    let _ = writeln!(text, "placement = \"{placement}\"");
    if kind == "constant" {
        let torque = if extreme { rng.log_within(1.0, 500.0) } else { rng.log_within(20.0, 300.0) };
        let _ = writeln!(text, "torque = {}", quantity(torque, "N*mm"));
    } else {
        let stiffness = if extreme { rng.log_within(1.0, 2e3) } else { rng.log_within(10.0, 500.0) };
        let preload = quantity(rng.within(0.0, 90.0), "deg");
        let _ = writeln!(text, "stiffness = {}\npreload = {preload}", quantity(stiffness, "N*mm/rad"));
    }
}

fn write_limit(rng: &mut Random, text: &mut String, focus: Focus) {
    if rng.chance(0.1) {
        text.push_str("[limit]\nenabled = false\n");
    } else if rng.chance(0.5) {
        let exponent = match focus {
            Focus::Soft => rng.choose(&[1.0, 1.5]),
            _ => rng.choose(&[1.0, 1.5, 2.2, 3.0]),
        };
        let _ = writeln!(text, "[limit]\nstiffness_si = {:e}\nexponent = {exponent:e}", rng.log_within(1e4, 1e12));
        let damping = if rng.chance(0.1) { 0.0 } else { rng.log_within(1.0, 1e10) };
        let _ = writeln!(text, "damping = {}", quantity(damping, "N*m*s/rad"));
        let _ = writeln!(text, "transition = {}", quantity(rng.log_within(1e-6, 1e-3), "rad"));
    }
}

fn write_contacts(rng: &mut Random, text: &mut String, focus: Focus) {
    for section in ["contact", "contact.proximal", "contact.distal"] {
        let is_contact_section = section == "contact";
        let probability = match focus {
            Focus::Stick if is_contact_section => 0.5,
            _ if is_contact_section => 0.9,
            _ => 0.15,
        };
        if rng.chance(probability) {
            let (exponent, stiffness) = match focus {
                Focus::Soft => (rng.choose(&[1.0, 1.5]), rng.log_within(1e5, 1e8)),
                _ => (rng.choose(&[1.0, 1.5, 2.2, 2.2, 3.0]), rng.log_within(1e6, 1e10)),
            };
            let damping = match focus {
                _ if rng.chance(0.07) => 0.0,
                Focus::Soft => rng.log_within(10.0, 1e5),
                _ => rng.log_within(10.0, 1e7),
            };
            write_normal_law(text, section, [stiffness, exponent, damping, rng.log_within(1e-6, 1e-4)]);
        }
        let probability = match focus {
            Focus::Stick if is_contact_section => 1.0,
            Focus::Soft if is_contact_section => 0.5,
            _ if is_contact_section => 0.8,
            _ => 0.15,
        };
        if rng.chance(probability) {
            let v_static = if focus == Focus::Stick { [1e-4, 1e-2] } else { [1e-3, 0.3] };
            write_friction_law(rng, text, section, v_static, [0.05, 1.4], 1.2);
        }
    }
}

/// Writes the initial state: the start posture of the design, or random angles.
fn write_initial(rng: &mut Random, text: &mut String, needs_angles: bool) {
    if needs_angles || rng.chance(0.15) {
        let q21 = rng.within(15.0, 70.0);
        let _ = writeln!(text, "[initial]\nq21 = {}", quantity(q21, "deg"));
        if needs_angles || rng.chance(0.3) {
            let _ = writeln!(text, "q11 = {}", quantity(q21 - rng.within(60.0, 95.0), "deg"));
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
