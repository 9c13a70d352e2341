//! Texts of random scenes of a finger and of discs, realistic and unrealistic ones.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

use super::random::{Random, pair, quantity, write_friction_law, write_normal_law};
use crate::campaign::discs::write_discs;
use crate::campaign::fingers::{write_bodies, write_motor, write_spring};

/// Returns the text of a scene of a finger. Most are valid; some are rejected, because the sections are independent of
/// each other.
pub fn finger(rng: &mut Random) -> String {
    let mut text = String::new();
    let duration_s = rng.log_within(3e-4, 8e-3);
    let _ = writeln!(text, "duration = {}", quantity(duration_s, "s"));
    if rng.chance(0.5) {
        let (size, turn) = (rng.within(0.0, 981.0), rng.within(0.0, 4.0) * FRAC_PI_2);
        let _ = writeln!(text, "gravity = {}", pair([size * turn.cos(), size * turn.sin()], "m/s^2"));
    }
    let other_assembly = rng.chance(0.15);
    if other_assembly {
        text.push_str("assembly = \"other\"\n");
    }
    let has_object = lengths_and_object(rng, &mut text);
    write_bodies(rng, &mut text, true);
    write_motor(rng, &mut text, duration_s, true);
    write_spring(rng, &mut text, true);
    limit(rng, &mut text);
    contact(rng, &mut text);
    start(rng, &mut text, other_assembly || !has_object);
    integrator(rng, &mut text, 0.15);
    engine(rng, &mut text, true);
    text
}

/// Returns the text of a scene of discs. A few are rejected because of too deep initial overlaps.
pub fn discs(rng: &mut Random) -> String {
    let mut text = write_discs(rng, true);
    normal_law(rng, &mut text, "contact", true);
    if rng.chance(0.7) {
        friction_law(rng, &mut text, "contact");
    }
    integrator(rng, &mut text, 0.1);
    engine(rng, &mut text, false);
    text
}

/// Writes lengths and object. Returns whether there is an object.
fn lengths_and_object(rng: &mut Random, text: &mut String) -> bool {
    let scale = if rng.chance(0.2) { rng.log_within(0.1, 10.0) } else { 1.0 };
    let length = |rng: &mut Random, low: f64, high: f64| quantity(scale * rng.within(low, high), "mm");
    let designed = rng.chance(0.6);
    let base = scale * rng.within(9.0, 22.0);
    if designed {
        let _ = writeln!(text, "[design]\nbase = {}", quantity(base, "mm"));
        let _ = writeln!(text, "l21_fraction = {:e}", rng.within(0.0, 1.0));
        let _ = writeln!(text, "phi22 = {}", quantity(rng.within(85.0, 140.0), "deg"));
        let _ = writeln!(text, "arm_ratio = {:e}", rng.within(0.3, 0.9));
        let _ = writeln!(text, "l11 = {}", length(rng, 12.0, 18.0));
    } else {
        let _ = writeln!(text, "[lengths]\nl11 = {}", length(rng, 10.0, 22.0));
        let _ = writeln!(text, "l21 = {}", length(rng, 18.0, 34.0));
        let _ = writeln!(text, "l22 = {}", length(rng, 5.0, 12.0));
        let _ = writeln!(text, "t22 = {}", length(rng, 8.0, 20.0));
        let _ = writeln!(text, "phi22 = {}", quantity(rng.within(70.0, 150.0), "deg"));
    }
    text.push_str("[object]\n");
    if rng.chance(0.15) {
        text.push_str("present = false\n");
        return false;
    }
    let _ = writeln!(text, "radius = {}", quantity(scale * 20.0, "mm"));
    let is_far = rng.chance(0.1);
    if is_far || !designed {
        let distance = if is_far { scale * rng.log_within(10.0, 1e4) } else { 0.0 };
        let _ = writeln!(text, "centre = {}", pair([-base - distance, scale * 20.0], "mm"));
    }
    true
}

fn limit(rng: &mut Random, text: &mut String) {
    if rng.chance(0.2) {
        text.push_str("[limit]\nenabled = false\n");
    } else if rng.chance(0.6) {
        let _ = writeln!(text, "[limit]\nstiffness_si = {:e}", rng.log_within(1e3, 1e12));
        let _ = writeln!(text, "exponent = {:e}", rng.choose(&[1.0, 1.5, 2.2, 3.0]));
        let damping = if rng.chance(0.2) { 0.0 } else { rng.log_within(1e-2, 1e10) };
        let _ = writeln!(text, "damping = {}", quantity(damping, "N*m*s/rad"));
        let _ = writeln!(text, "transition = {}", quantity(rng.log_within(1e-6, 1e-2), "rad"));
    }
}

fn contact(rng: &mut Random, text: &mut String) {
    for section in ["contact", "contact.proximal", "contact.distal"] {
        if rng.chance(if section == "contact" { 0.8 } else { 0.15 }) {
            normal_law(rng, text, section, false);
        }
        if rng.chance(if section == "contact" { 0.7 } else { 0.1 }) {
            friction_law(rng, text, section);
        }
    }
}

/// Writes a normal law over decades; without a spring only if `allow_no_spring` is set.
fn normal_law(rng: &mut Random, text: &mut String, section: &str, allow_no_spring: bool) {
    let damping = if rng.chance(0.2) { 0.0 } else { rng.log_within(1e-2, 1e7) };
    let stiffness = if allow_no_spring && damping > 0.0 && rng.chance(0.15) { 0.0 } else { rng.log_within(1e4, 1e11) };
    let exponent = rng.choose(&[1.0, 1.5, 2.2, 2.2, 3.0]);
    write_normal_law(text, section, [stiffness, exponent, damping, rng.log_within(1e-7, 1e-3)]);
}

fn friction_law(rng: &mut Random, text: &mut String, section: &str) {
    write_friction_law(rng, text, section, [1e-4, 1e-1], [0.0, 2.0], 1.1);
}

/// Writes the initial state: at given angles, or straight before, at or slightly in the object.
fn start(rng: &mut Random, text: &mut String, needs_angles: bool) {
    text.push_str("[initial]\n");
    if needs_angles || rng.chance(0.1) {
        let q21 = rng.within(20.0, 75.0);
        let _ = writeln!(text, "q21 = {}", quantity(q21, "deg"));
        let _ = writeln!(text, "q11 = {}", quantity(q21 - rng.within(60.0, 95.0), "deg"));
    } else if rng.chance(0.15) {
        // In contact, with a penetration of up to a few tenths of a millimetre.
        let _ = writeln!(text, "offset = {}", quantity(-rng.log_within(1e-6, 0.5), "deg"));
    } else {
        let _ = writeln!(text, "offset = {}", quantity(rng.log_within(1e-3, 25.0), "deg"));
    }
    if rng.chance(0.3) {
        for rate in ["qd11", "qd21"] {
            let _ = writeln!(text, "{rate} = {}", quantity(rng.within(-200.0, 400.0), "rad/s"));
        }
    }
}

/// Writes settings of the analytic model. The share `reference_share` of all scenes has the reference preset, which
/// takes ten times as long.
fn integrator(rng: &mut Random, text: &mut String, reference_share: f64) {
    let _ = writeln!(text, "[integrator]\nmax_steps = {}", super::MAX_STEPS);
    if rng.chance(reference_share) {
        text.push_str("preset = \"reference\"\n");
    } else if rng.chance(0.3) {
        let _ = writeln!(text, "method = \"{}\"", rng.choose(&["rodas5p", "radau5"]));
        let _ = writeln!(text, "rtol = {:e}", rng.log_within(1e-8, 1e-3));
    }
}

/// Writes settings of the engine.
fn engine(rng: &mut Random, text: &mut String, has_joints: bool) {
    let _ = writeln!(text, "[engine]\nmax_steps = {}", super::MAX_STEPS);
    // Joints open further if steps are longer than the adaptive ones.
    let mut coarse = false;
    if rng.chance(0.3) {
        coarse = true;
        let _ = writeln!(text, "stepping = \"fixed\"\nstep = {}", quantity(rng.log_within(1e-6, 2e-4), "s"));
    } else if rng.chance(0.3) {
        let _ = writeln!(text, "tolerance = {}", quantity(rng.log_within(1e-8, 1e-5), "m"));
    }
    if rng.chance(0.1) {
        coarse = true;
        let _ = writeln!(text, "law = \"rapier\"\nfriction = {:e}", rng.within(0.0, 1.0));
        let _ = writeln!(text, "restitution = {:e}", rng.choose(&[0.0, 0.5, 1.0]));
    }
    if has_joints && coarse {
        text.push_str("[validate]\nloop_gap = \"10 um\"\n");
    }
}
