//! Texts of random scenes of grippers: designs, palms, offsets, masses over decades, tables, differentials, motors as bought; one half
//! under the usual laws, the other under laws over decades.

use std::fmt::Write;

use super::dice::{Dice, pair, quantity};

/// A scene text; a few are refused because no finger has the design.
pub fn text(dice: &mut Dice) -> String {
    let duration_s = dice.decades(1e-2, 4e-2);
    let mut text = format!("kind = \"gripper\"\nduration = {}\n", quantity(duration_s, "s"));
    let base = dice.within(12.0, 22.5);
    let palm = 2.0 * base + dice.pick(&[0.0, 0.0, 1.0, 3.0, 8.0]);
    let room = (palm / 2.0 - 10.4).clamp(0.0, 3.5);
    let offset = if dice.chance(0.25) { 0.0 } else { dice.within(-room, room) };
    let _ = writeln!(text, "palm_width = {}", quantity(palm, "mm"));
    if dice.chance(0.3) {
        let error = offset.abs() + dice.within(0.0, room - offset.abs());
        let _ = writeln!(text, "positioning_error = {}", quantity(error, "mm"));
    }
    if dice.chance(0.2) {
        let gravity = [dice.within(-40.0, 40.0), dice.within(-40.0, 40.0)];
        let _ = writeln!(text, "gravity = {}", pair(gravity, "m/s^2"));
    }
    if dice.chance(0.1) {
        text.push_str("palm = false\n");
    }
    design(dice, &mut text, "design", base);
    let table = dice.chance(0.6);
    object(dice, &mut text, offset, table);
    drives(dice, &mut text);
    if dice.chance(0.2) {
        design(dice, &mut text, "left.design", base);
    }
    laws(dice, &mut text, table);
    text
}

fn design(dice: &mut Dice, text: &mut String, section: &str, base: f64) {
    let _ = writeln!(text, "[{section}]\nbase = {}", quantity(base, "mm"));
    let _ = writeln!(text, "l21_fraction = {:e}", dice.within(0.0, 1.0));
    let _ = writeln!(text, "phi22 = {}", quantity(dice.within(90.0, 130.0), "deg"));
    let _ = writeln!(text, "arm_ratio = {:e}", dice.within(0.3, 0.75));
}

fn object(dice: &mut Dice, text: &mut String, offset: f64, table: bool) {
    let _ = writeln!(text, "[object]\noffset = {}", quantity(offset, "mm"));
    if dice.chance(0.07) {
        text.push_str("motion = \"fixed\"\n");
    } else {
        let mass = 53.784 * if dice.chance(0.3) { 1.0 } else { dice.decades(0.05, 20.0) };
        let _ = writeln!(text, "mass = {}", quantity(mass, "g"));
        if dice.chance(0.3) {
            let inertia = 0.5 * mass * 400.0 * dice.within(0.5, 1.8);
            let _ = writeln!(text, "inertia = {}", quantity(inertia, "g*mm^2"));
        }
        if dice.chance(0.15) {
            let velocity = [dice.within(-1.0, 1.0), dice.within(-2.0, 0.5)];
            let _ = writeln!(text, "velocity = {}", pair(velocity, "m/s"));
            let _ = writeln!(text, "spin = {}", quantity(dice.within(-50.0, 50.0), "rad/s"));
        }
    }
    if table {
        let clearance = if dice.chance(0.3) { 0.0 } else { dice.within(0.0, 2.0) };
        let _ = writeln!(text, "[table]\nlevel = {}", quantity(40.0 + clearance, "mm"));
    }
}

fn drives(dice: &mut Dice, text: &mut String) {
    let torque = dice.within(100.0, 700.0);
    let seesaw = dice.chance(0.25);
    let _ = writeln!(text, "[motor]\ntorque = {}", quantity(if seesaw { 2.0 * torque } else { torque }, "N*mm"));
    if dice.chance(0.3) {
        let _ = writeln!(text, "inertia = {}", quantity(dice.decades(1e-7, 1e-5), "kg*m^2"));
    }
    if dice.chance(0.3) {
        let _ = writeln!(text, "no_load_speed = {}", quantity(dice.within(200.0, 1000.0), "rad/s"));
    }
    if seesaw {
        text.push_str("[differential]\n");
        if dice.chance(0.6) {
            let _ = writeln!(text, "input_inertia = {}", quantity(dice.decades(1e-6, 5e-5), "kg*m^2"));
            let _ = writeln!(text, "seesaw_inertia = {}", quantity(dice.decades(1e-7, 1e-5), "kg*m^2"));
        }
    } else if dice.chance(0.2) {
        let _ = writeln!(text, "[left.motor]\ntorque = {}", quantity(torque * dice.within(0.6, 1.4), "N*mm"));
    }
    let _ = writeln!(text, "[spring]\ntorque = {}", quantity(torque * dice.within(0.1, 0.4), "N*mm"));
}

fn laws(dice: &mut Dice, text: &mut String, table: bool) {
    let wild = dice.chance(0.5);
    if !wild {
        text.push_str("[contact.friction]\nmu_static = 0.8\n");
        return;
    }
    let mut sections = vec!["contact"];
    if dice.chance(0.2) {
        sections.push("contact.distal");
    }
    if table && dice.chance(0.3) {
        sections.push("contact.table");
    }
    for section in sections {
        let exponent = dice.pick(&[1.0, 1.5, 2.2, 2.2]);
        let stiffness = if exponent < 1.4 { dice.decades(1e5, 1e8) } else { dice.decades(1e6, 1e10) };
        let damping = if dice.chance(0.1) { 0.0 } else { dice.decades(1e2, 1e6) };
        let _ = writeln!(text, "[{section}]\nstiffness_si = {stiffness:e}\nexponent = {exponent:e}");
        let _ = writeln!(text, "damping = {}", quantity(damping, "N*s/m"));
        let _ = writeln!(text, "transition = {}", quantity(dice.decades(1e-6, 1e-4), "m"));
        if dice.chance(0.9) {
            let v_static = dice.decades(1e-3, 0.3);
            let v_dynamic = v_static * dice.within(1.5, 5.0);
            let _ = writeln!(text, "[{section}.friction]\nmu_static = {:e}", dice.within(0.0, 1.2));
            let _ =
                writeln!(text, "v_static = {}\nv_dynamic = {}", quantity(v_static, "m/s"), quantity(v_dynamic, "m/s"));
        }
    }
}
