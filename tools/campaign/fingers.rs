//! Texts of random scenes of a finger that a user might write: every field that enters physics, over decades, in three families.

use std::fmt::Write;

use super::dice::{Dice, pair, quantity};

/// What a family stresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stress {
    /// Everything at once.
    Mixed,
    /// Linear and Hertzian springs of contacts and limit, soft, with weak dampers.
    Soft,
    /// Friction whose sticking range is as narrow as 0.1 mm/s.
    Stick,
}

pub fn mixed(dice: &mut Dice) -> String {
    text(dice, Stress::Mixed)
}

pub fn soft(dice: &mut Dice) -> String {
    text(dice, Stress::Soft)
}

pub fn stick(dice: &mut Dice) -> String {
    text(dice, Stress::Stick)
}

fn text(dice: &mut Dice, stress: Stress) -> String {
    let mixed = stress == Stress::Mixed;
    let mut text = String::new();
    let duration_s = dice.decades(4e-3, 3.2e-2);
    let _ = writeln!(text, "duration = {}", quantity(duration_s, "s"));
    if dice.chance(0.4) {
        let gravity = [dice.within(-40.0, 40.0), dice.within(-40.0, 40.0)];
        let _ = writeln!(text, "gravity = {}", pair(gravity, "m/s^2"));
    }
    if dice.chance(0.3) {
        let _ = writeln!(text, "half_width = {}", quantity(dice.within(0.5, 4.0), "mm"));
    }
    let other = mixed && dice.chance(0.12);
    if other {
        text.push_str("assembly = \"other\"\n");
    }
    let object = finger(dice, &mut text, mixed);
    if mixed {
        bodies(dice, &mut text);
    }
    motor(dice, &mut text, duration_s);
    spring(dice, &mut text);
    limit(dice, &mut text, stress);
    contact(dice, &mut text, stress);
    start(dice, &mut text, other || !object);
    text
}

/// Lengths and object; whether there is one.
fn finger(dice: &mut Dice, text: &mut String, mixed: bool) -> bool {
    let designed = !mixed || dice.chance(0.6);
    let base = dice.within(11.0, 22.5);
    if designed {
        let _ = writeln!(text, "[design]\nbase = {}", quantity(base, "mm"));
        let _ = writeln!(text, "l21_fraction = {:e}", dice.within(0.0, 1.0));
        let _ = writeln!(text, "phi22 = {}", quantity(dice.within(88.0, 135.0), "deg"));
        let _ = writeln!(text, "arm_ratio = {:e}", dice.within(0.3, 0.8));
    } else {
        let _ = writeln!(text, "[lengths]\nl11 = {}", quantity(dice.within(12.0, 18.0), "mm"));
        let _ = writeln!(text, "l21 = {}", quantity(dice.within(20.0, 32.0), "mm"));
        let _ = writeln!(text, "l22 = {}", quantity(dice.within(5.0, 11.0), "mm"));
        let _ = writeln!(text, "t22 = {}", quantity(dice.within(9.0, 18.0), "mm"));
        let _ = writeln!(text, "phi22 = {}", quantity(dice.within(85.0, 135.0), "deg"));
    }
    text.push_str("[object]\n");
    if mixed && dice.chance(0.08) {
        text.push_str("present = false\n");
        return false;
    }
    if !designed {
        let radius = dice.within(15.0, 24.0);
        let centre = [-dice.within(11.0, 27.0), radius + dice.pick(&[0.0, 1.0, 4.0, 9.0])];
        let _ = writeln!(text, "radius = {}\ncentre = {}", quantity(radius, "mm"), pair(centre, "mm"));
    }
    true
}

/// Masses of a few bodies, alone or with the rest of their properties.
fn bodies(dice: &mut Dice, text: &mut String) {
    if dice.chance(0.2) {
        let _ = writeln!(text, "[material]\ndensity = {}", quantity(dice.decades(500.0, 8e3), "kg/m^3"));
    }
    for name in ["l11", "l12", "l21", "l22"] {
        if !dice.chance(0.2) {
            continue;
        }
        let _ = writeln!(text, "[bodies.{name}]\nmass = {}", quantity(dice.decades(1.0, 100.0), "g"));
        if dice.chance(0.6) {
            let com = [dice.within(0.0, 22.0), dice.within(-7.0, 7.0)];
            let inertia = quantity(dice.decades(2e-8, 5e-6), "kg*m^2");
            let _ = writeln!(text, "com = {}\ninertia = {inertia}", pair(com, "mm"));
        }
    }
}

fn motor(dice: &mut Dice, text: &mut String, duration_s: f64) {
    let torque = |dice: &mut Dice| {
        let sign = if dice.chance(0.1) { -1.0 } else { 1.0 };
        quantity(sign * dice.decades(100.0, 1500.0), "N*mm")
    };
    let profile = dice.pick(&["constant", "constant", "constant", "ramp", "half-sine", "reversal", "table"]);
    let _ = writeln!(text, "[motor]\nprofile = \"{profile}\"");
    if profile == "table" {
        let count = dice.pick(&[2, 3, 6]);
        let mut time = 0.0;
        let times: Vec<String> = (0..count)
            .map(|_| {
                time += duration_s * dice.decades(0.02, 0.5);
                quantity(time, "s")
            })
            .collect();
        let torques: Vec<String> = (0..count).map(|_| torque(dice)).collect();
        let (times, torques) = (times.join(", "), torques.join(", "));
        let between = dice.pick(&["linear", "step"]);
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
    let _ = writeln!(text, "{key} = {}", quantity(duration_s * dice.decades(0.1, 1.0), "s"));
}

fn spring(dice: &mut Dice, text: &mut String) {
    let kind = dice.pick(&["none", "constant", "constant", "constant", "torsional"]);
    let _ = writeln!(text, "[spring]\ntype = \"{kind}\"");
    if kind == "none" {
        return;
    }
    let placement = dice.pick(&["q22", "q22", "q22", "q12", "q21-q11", "q11+q12-(q21+q22)"]);
    let _ = writeln!(text, "placement = \"{placement}\"");
    if kind == "constant" {
        let _ = writeln!(text, "torque = {}", quantity(dice.decades(20.0, 300.0), "N*mm"));
    } else {
        let stiffness = quantity(dice.decades(10.0, 500.0), "N*mm/rad");
        let _ = writeln!(text, "stiffness = {stiffness}\npreload = {}", quantity(dice.within(0.0, 90.0), "deg"));
    }
}

fn limit(dice: &mut Dice, text: &mut String, stress: Stress) {
    if dice.chance(0.1) {
        text.push_str("[limit]\nenabled = false\n");
    } else if dice.chance(0.5) {
        let exponent = match stress {
            Stress::Soft => dice.pick(&[1.0, 1.5]),
            _ => dice.pick(&[1.0, 1.5, 2.2, 3.0]),
        };
        let _ = writeln!(text, "[limit]\nstiffness_si = {:e}\nexponent = {exponent:e}", dice.decades(1e4, 1e12));
        let damping = if dice.chance(0.1) { 0.0 } else { dice.decades(1.0, 1e10) };
        let _ = writeln!(text, "damping = {}", quantity(damping, "N*m*s/rad"));
        let _ = writeln!(text, "transition = {}", quantity(dice.decades(1e-6, 1e-3), "rad"));
    }
}

fn contact(dice: &mut Dice, text: &mut String, stress: Stress) {
    for section in ["contact", "contact.proximal", "contact.distal"] {
        let whole = section == "contact";
        let share = match stress {
            Stress::Stick if whole => 0.5,
            _ if whole => 0.9,
            _ => 0.15,
        };
        if dice.chance(share) {
            let (exponent, stiffness) = match stress {
                Stress::Soft => (dice.pick(&[1.0, 1.5]), dice.decades(1e5, 1e8)),
                _ => (dice.pick(&[1.0, 1.5, 2.2, 2.2, 3.0]), dice.decades(1e6, 1e10)),
            };
            let damping = match stress {
                _ if dice.chance(0.07) => 0.0,
                Stress::Soft => dice.decades(10.0, 1e5),
                _ => dice.decades(10.0, 1e7),
            };
            let _ = writeln!(text, "[{section}]\nstiffness_si = {stiffness:e}\nexponent = {exponent:e}");
            let _ = writeln!(text, "damping = {}", quantity(damping, "N*s/m"));
            let _ = writeln!(text, "transition = {}", quantity(dice.decades(1e-6, 1e-4), "m"));
        }
        let share = match stress {
            Stress::Stick if whole => 1.0,
            Stress::Soft if whole => 0.5,
            _ if whole => 0.8,
            _ => 0.15,
        };
        if dice.chance(share) {
            let v_static = match stress {
                Stress::Stick => dice.decades(1e-4, 1e-2),
                _ => dice.decades(1e-3, 0.3),
            };
            let _ = writeln!(text, "[{section}.friction]\nmu_static = {:e}", dice.within(0.05, 1.4));
            let v_dynamic = v_static * dice.within(1.2, 5.0);
            let _ =
                writeln!(text, "v_static = {}\nv_dynamic = {}", quantity(v_static, "m/s"), quantity(v_dynamic, "m/s"));
        }
    }
}

/// At rest where the design says, or at angles of its own.
fn start(dice: &mut Dice, text: &mut String, angles: bool) {
    if angles || dice.chance(0.15) {
        let q21 = dice.within(15.0, 70.0);
        let _ = writeln!(text, "[initial]\nq21 = {}", quantity(q21, "deg"));
        if angles || dice.chance(0.3) {
            let _ = writeln!(text, "q11 = {}", quantity(q21 - dice.within(60.0, 95.0), "deg"));
        }
    } else if dice.chance(0.2) {
        let _ = writeln!(text, "[initial]\noffset = {}", quantity(dice.decades(0.1, 30.0), "deg"));
    } else {
        return;
    }
    if dice.chance(0.3) {
        for rate in ["qd11", "qd21"] {
            let _ = writeln!(text, "{rate} = {}", quantity(dice.within(-100.0, 200.0), "rad/s"));
        }
    }
}
