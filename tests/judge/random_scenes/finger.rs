//! Texts of random scenes of a finger: what a user could write, and much that none would.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

use super::dice::{Dice, pair, quantity};

/// A scene text. Most are sound, some are refused: their parts are drawn each by itself.
pub fn text(dice: &mut Dice) -> String {
    let mut text = String::new();
    let duration_s = dice.decades(3e-4, 8e-3);
    let _ = writeln!(text, "duration = {}", quantity(duration_s, "s"));
    if dice.chance(0.5) {
        let (size, turn) = (dice.within(0.0, 981.0), dice.within(0.0, 4.0) * FRAC_PI_2);
        let _ = writeln!(text, "gravity = {}", pair([size * turn.cos(), size * turn.sin()], "m/s^2"));
    }
    let other = dice.chance(0.15);
    if other {
        text.push_str("assembly = \"other\"\n");
    }
    let object = finger(dice, &mut text);
    bodies(dice, &mut text);
    motor(dice, &mut text, duration_s);
    spring(dice, &mut text);
    limit(dice, &mut text);
    contact(dice, &mut text);
    start(dice, &mut text, other || !object);
    integrator(dice, &mut text, 0.15);
    engine(dice, &mut text, true);
    text
}

/// Lengths and object; whether there is one.
fn finger(dice: &mut Dice, text: &mut String) -> bool {
    let scale = if dice.chance(0.2) { dice.decades(0.1, 10.0) } else { 1.0 };
    let length = |dice: &mut Dice, low: f64, high: f64| quantity(scale * dice.within(low, high), "mm");
    let designed = dice.chance(0.6);
    let base = scale * dice.within(9.0, 22.0);
    if designed {
        let _ = writeln!(text, "[design]\nbase = {}", quantity(base, "mm"));
        let _ = writeln!(text, "l21_fraction = {:e}", dice.within(0.0, 1.0));
        let _ = writeln!(text, "phi22 = {}", quantity(dice.within(85.0, 140.0), "deg"));
        let _ = writeln!(text, "arm_ratio = {:e}", dice.within(0.3, 0.9));
        let _ = writeln!(text, "l11 = {}", length(dice, 12.0, 18.0));
    } else {
        let _ = writeln!(text, "[lengths]\nl11 = {}", length(dice, 10.0, 22.0));
        let _ = writeln!(text, "l21 = {}", length(dice, 18.0, 34.0));
        let _ = writeln!(text, "l22 = {}", length(dice, 5.0, 12.0));
        let _ = writeln!(text, "t22 = {}", length(dice, 8.0, 20.0));
        let _ = writeln!(text, "phi22 = {}", quantity(dice.within(70.0, 150.0), "deg"));
    }
    text.push_str("[object]\n");
    if dice.chance(0.15) {
        text.push_str("present = false\n");
        return false;
    }
    let _ = writeln!(text, "radius = {}", quantity(scale * 20.0, "mm"));
    let far = dice.chance(0.1);
    if far || !designed {
        let away = if far { scale * dice.decades(10.0, 1e4) } else { 0.0 };
        let _ = writeln!(text, "centre = {}", pair([-base - away, scale * 20.0], "mm"));
    }
    true
}

/// Masses of a few bodies over decades, alone or with the rest of their properties.
fn bodies(dice: &mut Dice, text: &mut String) {
    if dice.chance(0.2) {
        let _ = writeln!(text, "[material]\ndensity = {}", quantity(dice.decades(100.0, 2e4), "kg/m^3"));
    }
    for name in ["l11", "l12", "l21", "l22"] {
        if !dice.chance(0.15) {
            continue;
        }
        let _ = writeln!(text, "[bodies.{name}]\nmass = {}", quantity(dice.decades(1e-2, 1e3), "g"));
        if dice.chance(0.5) {
            let com = [dice.within(-5.0, 25.0), dice.within(-10.0, 10.0)];
            let inertia = quantity(dice.decades(1e-10, 1e-4), "kg*m^2");
            let _ = writeln!(text, "com = {}\ninertia = {inertia}", pair(com, "mm"));
        }
    }
}

fn motor(dice: &mut Dice, text: &mut String, duration_s: f64) {
    let torque = |dice: &mut Dice| {
        let sign = if dice.chance(0.15) { -1.0 } else { 1.0 };
        quantity(sign * dice.decades(10.0, 3e3), "N*mm")
    };
    let profile = dice.pick(&["constant", "ramp", "half-sine", "reversal", "table"]);
    let _ = writeln!(text, "[motor]\nprofile = \"{profile}\"");
    if profile == "table" {
        let count = dice.pick(&[1, 2, 5, 12]);
        let times: Vec<String> =
            (0..count).map(|k| quantity(duration_s * f64::from(k) / f64::from(count), "s")).collect();
        let torques: Vec<String> = (0..count).map(|_| torque(dice)).collect();
        let between = dice.pick(&["linear", "step"]);
        let (times, torques) = (times.join(", "), torques.join(", "));
        let _ = writeln!(text, "times = [{times}]\ntorques = [{torques}]\ninterpolation = \"{between}\"");
        return;
    }
    let _ = writeln!(text, "torque = {}", torque(dice));
    let key = match profile {
        "ramp" => "rise",
        "half-sine" => "pulse",
        "reversal" => "reverse_at",
        _ => return,
    };
    let _ = writeln!(text, "{key} = {}", quantity(duration_s * dice.decades(0.01, 2.0), "s"));
}

fn spring(dice: &mut Dice, text: &mut String) {
    let kind = dice.pick(&["none", "constant", "constant", "torsional", "torsional"]);
    let _ = writeln!(text, "[spring]\ntype = \"{kind}\"");
    if kind == "none" {
        return;
    }
    let placement = dice.pick(&["q22", "q22", "q12", "q21-q11", "q11+q12-(q21+q22)"]);
    let _ = writeln!(text, "placement = \"{placement}\"");
    if kind == "constant" {
        let _ = writeln!(text, "torque = {}", quantity(dice.decades(1.0, 500.0), "N*mm"));
    } else {
        let stiffness = quantity(dice.decades(1.0, 2e3), "N*mm/rad");
        let _ = writeln!(text, "stiffness = {stiffness}\npreload = {}", quantity(dice.within(0.0, 90.0), "deg"));
    }
}

fn limit(dice: &mut Dice, text: &mut String) {
    if dice.chance(0.2) {
        text.push_str("[limit]\nenabled = false\n");
    } else if dice.chance(0.6) {
        let _ = writeln!(text, "[limit]\nstiffness_si = {:e}", dice.decades(1e3, 1e12));
        let _ = writeln!(text, "exponent = {:e}", dice.pick(&[1.0, 1.5, 2.2, 3.0]));
        let damping = if dice.chance(0.2) { 0.0 } else { dice.decades(1e-2, 1e10) };
        let _ = writeln!(text, "damping = {}", quantity(damping, "N*m*s/rad"));
        let _ = writeln!(text, "transition = {}", quantity(dice.decades(1e-6, 1e-2), "rad"));
    }
}

fn contact(dice: &mut Dice, text: &mut String) {
    for section in ["contact", "contact.proximal", "contact.distal"] {
        if dice.chance(if section == "contact" { 0.8 } else { 0.15 }) {
            law(dice, text, section, false);
        }
        if dice.chance(if section == "contact" { 0.7 } else { 0.1 }) {
            friction_law(dice, text, section);
        }
    }
}

/// A normal law over decades; without spring only where `springless` allows.
pub fn law(dice: &mut Dice, text: &mut String, section: &str, springless: bool) {
    let _ = writeln!(text, "[{section}]");
    let damping = if dice.chance(0.2) { 0.0 } else { dice.decades(1e-2, 1e7) };
    let stiffness = if springless && damping > 0.0 && dice.chance(0.15) { 0.0 } else { dice.decades(1e4, 1e11) };
    let exponent = dice.pick(&[1.0, 1.5, 2.2, 2.2, 3.0]);
    let _ = writeln!(text, "stiffness_si = {stiffness:e}\nexponent = {exponent:e}");
    let _ = writeln!(text, "damping = {}", quantity(damping, "N*s/m"));
    let _ = writeln!(text, "transition = {}", quantity(dice.decades(1e-7, 1e-3), "m"));
}

pub fn friction_law(dice: &mut Dice, text: &mut String, section: &str) {
    let v_static = dice.decades(1e-4, 1e-1);
    let _ = writeln!(text, "[{section}.friction]\nmu_static = {:e}", dice.within(0.0, 2.0));
    let v_dynamic = v_static * dice.within(1.1, 5.0);
    let _ = writeln!(text, "v_static = {}\nv_dynamic = {}", quantity(v_static, "m/s"), quantity(v_dynamic, "m/s"));
}

/// Straight before, at or slightly in the object, or at angles of its own.
fn start(dice: &mut Dice, text: &mut String, angles: bool) {
    text.push_str("[initial]\n");
    if angles || dice.chance(0.1) {
        let q21 = dice.within(20.0, 75.0);
        let _ = writeln!(text, "q21 = {}", quantity(q21, "deg"));
        let _ = writeln!(text, "q11 = {}", quantity(q21 - dice.within(60.0, 95.0), "deg"));
    } else if dice.chance(0.15) {
        // Touching, or in it by up to a few tenths of a millimetre.
        let _ = writeln!(text, "offset = {}", quantity(-dice.decades(1e-6, 0.5), "deg"));
    } else {
        let _ = writeln!(text, "offset = {}", quantity(dice.decades(1e-3, 25.0), "deg"));
    }
    if dice.chance(0.3) {
        for rate in ["qd11", "qd21"] {
            let _ = writeln!(text, "{rate} = {}", quantity(dice.within(-200.0, 400.0), "rad/s"));
        }
    }
}

/// Settings of the analytic model; those of a reference, which costs ten times as much, in a share of all scenes.
pub fn integrator(dice: &mut Dice, text: &mut String, precise: f64) {
    let _ = writeln!(text, "[integrator]\nmax_steps = {}", super::STEPS);
    if dice.chance(precise) {
        text.push_str("preset = \"reference\"\n");
    } else if dice.chance(0.3) {
        let _ = writeln!(text, "method = \"{}\"", dice.pick(&["rodas5p", "radau5"]));
        let _ = writeln!(text, "rtol = {:e}", dice.decades(1e-8, 1e-3));
    }
}

/// Settings of the engine; `jointed` where the bodies have joints.
pub fn engine(dice: &mut Dice, text: &mut String, jointed: bool) {
    let _ = writeln!(text, "[engine]\nmax_steps = {}", super::STEPS);
    // Joints open further where steps are longer than the engine would choose, or of first order.
    let mut coarse = false;
    if jointed && dice.chance(0.15) {
        text.push_str("construction = \"reduced\"\n");
        coarse = true;
    }
    if dice.chance(0.3) {
        coarse = true;
        let _ = writeln!(text, "stepping = \"fixed\"\nstep = {}", quantity(dice.decades(1e-6, 2e-4), "s"));
    } else if dice.chance(0.3) {
        let _ = writeln!(text, "tolerance = {}", quantity(dice.decades(1e-8, 1e-5), "m"));
    }
    if dice.chance(0.1) {
        coarse = true;
        let _ = writeln!(text, "law = \"rapier\"\nfriction = {:e}", dice.within(0.0, 1.0));
        let _ = writeln!(text, "restitution = {:e}", dice.pick(&[0.0, 0.5, 1.0]));
    }
    if jointed && coarse {
        text.push_str("[validate]\nloop_gap = \"10 um\"\n");
    }
}
