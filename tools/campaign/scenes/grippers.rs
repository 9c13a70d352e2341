//! Texts of random scenes of grippers: designs, palms, offsets, masses over decades, tables, differentials, real
//! motors. Half of the scenes have the default contact laws, the others laws over decades. And of fingers and grippers whose
//! object is no disc.

use std::fmt::Write;

use super::law::{CONTACT, bristle, write_friction_law, write_normal_law};
use super::parts::{ANY, outline};
use super::random::{Random, key, pair, quantity};

/// Returns a scene text. A few are rejected because no finger with the design exists.
pub fn scene_text(rng: &mut Random) -> String {
    let duration_s = rng.log_within(1e-2, 4e-2);
    let mut text = format!("kind = \"gripper\"\nduration = {}\n", quantity(duration_s, "s"));
    let base = rng.within(12.0, 22.5);
    let palm = 2.0 * base + rng.choose(&[0.0, 0.0, 1.0, 3.0, 8.0]);
    let max_offset = (palm / 2.0 - 10.4).clamp(0.0, 3.5);
    let offset = if rng.chance(0.25) { 0.0 } else { rng.within(-max_offset, max_offset) };
    key(&mut text, "palm_width", quantity(palm, "mm"));
    if rng.chance(0.3) {
        let error = offset.abs() + rng.within(0.0, max_offset - offset.abs());
        key(&mut text, "positioning_error", quantity(error, "mm"));
    }
    if rng.chance(0.2) {
        let gravity = [rng.within(-40.0, 40.0), rng.within(-40.0, 40.0)];
        key(&mut text, "gravity", pair(gravity, "m/s^2"));
    }
    if rng.chance(0.1) {
        text.push_str("palm = false\n");
    }
    design(rng, &mut text, "design", base);
    let table = rng.chance(0.6);
    object(rng, &mut text, offset, table);
    drives(rng, &mut text);
    if rng.chance(0.2) {
        design(rng, &mut text, "left.design", base);
    }
    laws(rng, &mut text, table);
    text
}

fn design(rng: &mut Random, text: &mut String, section: &str, base: f64) {
    let _ = writeln!(text, "[{section}]\nbase = {}", quantity(base, "mm"));
    let _ = writeln!(text, "l21_fraction = {:e}", rng.within(0.0, 1.0));
    key(text, "phi22", quantity(rng.within(90.0, 130.0), "deg"));
    let _ = writeln!(text, "arm_ratio = {:e}", rng.within(0.3, 0.75));
}

fn object(rng: &mut Random, text: &mut String, offset: f64, table: bool) {
    let _ = writeln!(text, "[object]\noffset = {}", quantity(offset, "mm"));
    if rng.chance(0.07) {
        text.push_str("motion = \"fixed\"\n");
    } else {
        let mass = 53.784 * if rng.chance(0.3) { 1.0 } else { rng.log_within(0.05, 20.0) };
        key(text, "mass", quantity(mass, "g"));
        if rng.chance(0.3) {
            let inertia = 0.5 * mass * 400.0 * rng.within(0.5, 1.8);
            key(text, "inertia", quantity(inertia, "g*mm^2"));
        }
        if rng.chance(0.15) {
            let velocity = [rng.within(-1.0, 1.0), rng.within(-2.0, 0.5)];
            key(text, "velocity", pair(velocity, "m/s"));
            key(text, "spin", quantity(rng.within(-50.0, 50.0), "rad/s"));
        }
    }
    if table {
        let clearance = if rng.chance(0.3) { 0.0 } else { rng.within(0.0, 2.0) };
        let _ = writeln!(text, "[table]\nlevel = {}", quantity(40.0 + clearance, "mm"));
    }
}

fn drives(rng: &mut Random, text: &mut String) {
    let torque = rng.within(100.0, 700.0);
    let seesaw = rng.chance(0.25);
    let _ = writeln!(text, "[motor]\ntorque = {}", quantity(if seesaw { 2.0 * torque } else { torque }, "N*mm"));
    if rng.chance(0.3) {
        key(text, "inertia", quantity(rng.log_within(1e-7, 1e-5), "kg*m^2"));
    }
    if rng.chance(0.3) {
        key(text, "no_load_speed", quantity(rng.within(200.0, 1000.0), "rad/s"));
    }
    if seesaw {
        text.push_str("[differential]\n");
        if rng.chance(0.6) {
            key(text, "input_inertia", quantity(rng.log_within(1e-6, 5e-5), "kg*m^2"));
            key(text, "seesaw_inertia", quantity(rng.log_within(1e-7, 1e-5), "kg*m^2"));
        }
    } else if rng.chance(0.2) {
        let _ = writeln!(text, "[left.motor]\ntorque = {}", quantity(torque * rng.within(0.6, 1.4), "N*mm"));
    }
    let _ = writeln!(text, "[spring]\ntorque = {}", quantity(torque * rng.within(0.1, 0.4), "N*mm"));
}

fn laws(rng: &mut Random, text: &mut String, table: bool) {
    let random_laws = rng.chance(0.5);
    if !random_laws {
        text.push_str("[contact.friction]\nmu_static = 0.8\n");
        return;
    }
    let mut sections = vec!["contact"];
    if rng.chance(0.2) {
        sections.push("contact.distal");
    }
    if table && rng.chance(0.3) {
        sections.push("contact.table");
    }
    for section in sections {
        let exponent = rng.choose(&[1.0, 1.5, 2.2, 2.2]);
        let stiffness = if exponent < 1.4 { rng.log_within(1e5, 1e8) } else { rng.log_within(1e6, 1e10) };
        let damping = if rng.chance(0.1) { 0.0 } else { rng.log_within(1e2, 1e6) };
        write_normal_law(text, section, CONTACT, [stiffness, exponent, damping, rng.log_within(1e-6, 1e-4)]);
        if rng.chance(0.9) {
            write_friction_law(rng, text, section, [1e-3, 0.3], [0.0, 1.2], 1.5);
        }
    }
}

/// Returns the text of a finger or a gripper whose object is no disc.
pub fn with_other_object(rng: &mut Random) -> String {
    let kind = rng.choose(&["finger", "gripper"]);
    let duration = quantity(rng.log_within(10.0, 30.0), "ms");
    let mut text = format!("kind = \"{kind}\"\nduration = {duration}\n[object]\nradius = \"20 mm\"\n");
    let size = rng.within(30.0, 40.0);
    key(&mut text, "outline", outline(rng, size, [0.0; 2], ANY));
    if kind == "finger" {
        key(&mut text, "centre", pair([rng.within(-16.5, -14.5), rng.within(19.5, 22.0)], "mm"));
    } else {
        key(&mut text, "height", quantity(rng.within(20.5, 23.0), "mm"));
        key(&mut text, "angle", quantity(rng.within(-90.0, 90.0), "deg"));
        key(&mut text, "mass", quantity(rng.log_within(10.0, 200.0), "g"));
    }
    let _ = writeln!(text, "[design]\nbase = \"15.5 mm\"\nl21_fraction = {:e}", rng.within(0.3, 1.0));
    key(&mut text, "phi22", quantity(rng.within(90.0, 130.0), "deg"));
    key(&mut text, "arm_ratio", rng.within(0.4, 0.7));
    let _ = writeln!(text, "[spring]\ntorque = {}", quantity(rng.log_within(30.0, 130.0), "N*mm"));
    let _ = writeln!(text, "[contact]\nstiffness_si = {:e}", rng.log_within(1e7, 1e9));
    key(&mut text, "damping", quantity(rng.log_within(1e4, 1e6), "N*s/m"));
    let mu = rng.within(0.0, 1.2);
    let friction = if rng.chance(0.4) { bristle(rng, mu, false) } else { format!("{{ mu_static = {mu:e} }}") };
    key(&mut text, "friction", friction);
    let _ = writeln!(text, "[motor]\ntorque = {}", quantity(rng.log_within(100.0, 600.0), "N*mm"));
    if kind == "finger" {
        return text;
    }
    if rng.chance(0.4) {
        text.push_str("brake = \"two-way\"\n");
        key(&mut text, "brake_torque", quantity(rng.log_within(50.0, 2000.0), "N*mm"));
        key(&mut text, "brake_at", quantity(rng.within(2.0, 10.0), "ms"));
        if rng.chance(0.5) {
            text.push_str("brake_law = \"bristle\"\n");
        }
    }
    if rng.chance(0.3) {
        let inertia = quantity(rng.log_within(1e-7, 1e-5), "kg*m^2");
        let _ = writeln!(text, "[differential]\nseesaw_inertia = {inertia}");
    }
    if rng.chance(0.3) {
        text.push_str("[table]\nlevel = \"46 mm\"\n");
    }
    text
}
