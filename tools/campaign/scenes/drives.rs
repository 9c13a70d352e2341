//! Texts of random actuators with gears, motors and feedback, and of play between two bodies. Gear ratios, time constants
//! and losses span decades. Lengths are in mm.

use super::law::any_law;
use super::parts::{ANY, FACES, SLIDE, Start, TURN, Units, bulk, contact, free_body, joint_losses, outline, table};
use super::random::{Random, key, pair, quantity};

/// What an actuator must do: largest effort on a joint, inertia, start and travel of what its controller measures, and time.
#[derive(Clone, Copy)]
struct Task {
    effort: f64,
    inertia: f64,
    start: f64,
    travel: f64,
    duration_ms: f64,
}

/// Writes gear, motor and command of an actuator. A controller measures a length if `is_distance`.
fn powertrain(rng: &mut Random, task: Task, [force, angle, _]: Units, is_distance: bool) -> String {
    let Task { effort, inertia, start, travel, duration_ms } = task;
    let (is_slide, sign) = (angle == "m", rng.choose(&[1.0, 1.0, -1.0]));
    let (mut text, has_motor) = (String::new(), rng.chance(0.5));
    let has_gear = has_motor || rng.chance(0.7);
    let mut gear = 1.0;
    if is_slide && has_gear && rng.chance(0.5) {
        let lead = rng.log_within(1e-3, 2e-2);
        gear = std::f64::consts::TAU / lead;
        key(&mut text, "lead", quantity(lead, "m"));
    } else if has_gear {
        gear = if is_slide { rng.log_within(100.0, 5e3) } else { sign * rng.log_within(0.5, 300.0) };
        key(&mut text, "gear", format_args!("{gear:e}"));
    }
    if has_gear && rng.chance(0.7) {
        let reflected = inertia * rng.log_within(1e-2, 10.0);
        key(&mut text, "rotor", quantity(reflected / (gear * gear), "kg*m^2"));
    }
    if rng.chance(0.6) {
        key(&mut text, "efficiency", rng.within(0.2, 1.0));
        let rate = if is_slide { 1e-3 } else { 1e-2 };
        if rng.chance(0.4) {
            let unit = format!("{force}/{angle}");
            key(&mut text, "loss_stiffness", quantity(effort / (rate * rng.log_within(0.01, 1.0)), unit));
        } else {
            key(&mut text, "loss_rate", quantity(rate * rng.log_within(0.1, 100.0), format_args!("{angle}/s")));
        }
    }
    let torque = effort / gear.abs();
    let shaft = if is_slide && !has_gear { "N" } else { "N*m" };
    let measured = if is_distance { "m" } else { angle };
    let is_servo = is_distance || rng.chance(0.4);
    let (voltage, constant) = (rng.log_within(3.0, 48.0), rng.log_within(1e-3, 0.1));
    let command = if has_motor { "V" } else { shaft };
    let size = if has_motor { voltage } else { torque };
    if is_servo {
        let kp = size / (travel.abs() * rng.log_within(0.05, 2.0));
        key(&mut text, "kp", quantity(kp, format_args!("{command}/{measured}")));
        if rng.chance(0.8) {
            let kd = kp * duration_ms * 1e-3 * rng.log_within(1e-3, 0.3);
            key(&mut text, "kd", quantity(kd, format_args!("{command}*s/{measured}")));
        }
        if rng.chance(0.5) {
            key(&mut text, "target", quantity(start + travel, measured));
            if rng.chance(0.4) {
                let rate = travel.abs() / (duration_ms * 1e-3) * rng.log_within(1.0, 10.0);
                key(&mut text, "target_rate", quantity(rate, format_args!("{measured}/s")));
            }
        } else {
            let (times, targets) = table(rng, duration_ms, measured, |rng| start + travel * rng.within(0.0, 1.3));
            text += &format!("times = {times}\ntargets = {targets}\n");
        }
    } else if !has_motor {
        let name = if shaft == "N" { "force" } else { "torque" };
        if rng.chance(0.5) {
            key(&mut text, name, quantity(torque.copysign(travel * gear), shaft));
        } else {
            let (times, values) = table(rng, duration_ms, shaft, |rng| torque * rng.within(-1.0, 1.0));
            text += &format!("times = {times}\n{name}s = {values}\n");
        }
    }
    if !has_motor {
        if rng.chance(0.4) {
            key(&mut text, "limit", quantity(torque * rng.log_within(0.3, 2.0), shaft));
        }
        if rng.chance(0.4) {
            let speed = gear.abs() * travel.abs() / (duration_ms * 1e-3) * rng.log_within(1.0, 20.0);
            let unit = if shaft == "N" { "m/s" } else { "rad/s" };
            key(&mut text, "no_load_speed", quantity(speed, unit));
        }
        return text;
    }
    let stall = torque * rng.log_within(0.5, 5.0);
    let resistance = voltage * constant / stall;
    let mut motor = vec![
        format!("torque_constant = {}", quantity(constant, "N*m/A")),
        format!("resistance = {}", quantity(resistance, "ohm")),
    ];
    if is_servo || rng.chance(0.5) {
        let direction = if is_servo { 1.0 } else { (travel * gear).signum() };
        motor.push(format!("voltage = {}", quantity(direction * voltage, "V")));
    } else {
        let (times, voltages) = table(rng, duration_ms, "V", |rng| voltage * rng.within(-1.0, 1.0));
        text += &format!("times = {times}\n");
        motor.push(format!("voltages = {voltages}"));
    }
    if rng.chance(0.6) {
        let limit = quantity(stall / constant * rng.log_within(0.2, 1.5), "A");
        motor.push(format!("current_limit = {limit}"));
    }
    if rng.chance(0.4) {
        motor.push(format!("back_emf = {}", quantity(constant * rng.log_within(0.3, 3.0), "V*s/rad")));
    }
    if rng.chance(0.5) {
        motor.push(format!("inductance = {}", quantity(resistance * rng.log_within(1e-6, 1e-2), "H")));
    }
    text + &format!("motor = {{ {} }}\n", motor.join(", "))
}

/// A random actuator on an arm that hits something, on jaws that grip something, or behind play.
pub fn scene_text(rng: &mut Random) -> String {
    let duration_ms = rng.log_within(15.0, 80.0);
    let mut text = format!("kind = \"mechanism\"\nduration = {}\n", quantity(duration_ms, "ms"));
    if rng.chance(0.6) {
        key(&mut text, "gravity", pair([0.0, rng.choose(&[-9.81, 9.81])], "m/s^2"));
    }
    text += &any_law(rng, "pad", "m");
    match rng.choose(&["arm", "jaws", "play"]) {
        "arm" => arm(rng, text, duration_ms),
        "jaws" => jaws(rng, text, duration_ms),
        _ => play(rng, text, duration_ms),
    }
}

/// An arm that a motor drives against a fixed outline, or against its stops.
fn arm(rng: &mut Random, mut text: String, duration_ms: f64) -> String {
    let (mass_g, length) = (rng.log_within(10.0, 300.0), rng.within(40.0, 90.0));
    let inertia = 1e-9 * mass_g * length * length / 3.0;
    let effort = inertia * 2.0 / (duration_ms * 1e-3).powi(2) * rng.log_within(1.0, 50.0);
    text += &format!("[bodies.arm]\n{}", bulk(rng, mass_g, length));
    key(&mut text, "com", pair([0.4 * length, 0.0], "mm"));
    key(&mut text, "outlines.tip", outline(rng, length / 4.0, [0.8 * length, 0.0], FACES));
    text += "[joints.pin]\nbodies = [\"ground\", \"arm\"]\nstart = \"0 rad\"\n";
    key(&mut text, "points", format_args!("[{0}, {0}]", pair([0.0; 2], "mm")));
    key(&mut text, "start_rate", quantity(rng.choose(&[0.0, 1.0]) * rng.within(-5.0, 5.0), "rad/s"));
    text += &joint_losses(rng, effort, TURN);
    let task = Task { effort, inertia, start: 0.0, travel: rng.choose(&[-1.0, 1.0]), duration_ms };
    if rng.chance(0.4) {
        text += "lower = \"-30 deg\"\nupper = \"30 deg\"\nstop = \"stop\"\n";
        text += &any_law(rng, "stop", "rad");
    }
    text += &format!("[actuators.motor]\njoint = \"pin\"\n{}", powertrain(rng, task, TURN, false));
    for (name, side) in [("high", 1.0), ("low", -1.0)] {
        if rng.chance(0.6) {
            let angle = side * rng.within(0.6, 1.2f64);
            let at = [0.8 * length * angle.cos(), 0.8 * length * angle.sin()];
            let shape = outline(rng, length / 4.0, at, ANY);
            text += &format!("[ground.outlines]\n{name} = {shape}\n");
            text += &contact(rng, "arm.tip", &format!("ground.{name}"), "pad");
            break;
        }
    }
    text
}

/// Two coupled jaws whose distance, or whose coordinate, a motor controls, and a body between them.
fn jaws(rng: &mut Random, mut text: String, duration_ms: f64) -> String {
    let (width, mass_g) = (rng.log_within(10.0, 60.0), rng.log_within(10.0, 300.0));
    let gap = 0.5 * width + rng.log_within(0.2, 10.0);
    let travel = 1.5e-3 * gap;
    let effort = mass_g * 2e-3 * 2.0 * travel / (duration_ms * 1e-3).powi(2) * rng.log_within(1.0, 50.0);
    text += &free_body(rng, "object", width, ANY, Start::default());
    for (side, sign) in [("right", 1.0), ("left", -1.0)] {
        let size = pair([10.0, width * rng.within(0.3, 1.5)], "mm");
        let rounding = quantity(rng.log_within(0.2, 2.0), "mm");
        text += &format!("[bodies.{side}]\nguess = {{ at = {} }}\n", pair([sign * gap, 0.0], "mm"));
        text += &bulk(rng, mass_g, width);
        text += &format!("[bodies.{side}.outlines.skin]\ntype = \"box\"\nsize = {size}\nrounding = {rounding}\n");
        key(&mut text, "center", pair([5.0 * sign, 0.0], "mm"));
        let at = pair([rng.within(-1.0, 1.0), rng.within(-3.0, 3.0)], "mm");
        text += &format!("[bodies.{side}.points.tip]\nat = {at}\n");
        text += &format!("[joints.{side}]\ntype = \"prismatic\"\nbodies = [\"ground\", \"{side}\"]\n");
        text += &format!("points = [{0}, {0}]\n", pair([0.0; 2], "mm"));
        if side == "right" {
            key(&mut text, "start", quantity(gap * 1e-3, "m"));
        }
        text += &joint_losses(rng, effort, SLIDE);
    }
    text += "[couplings.mimic]\njoints = [\"left\", \"right\"]\nfactors = [1, 1]\n";
    let is_distance = rng.chance(0.6);
    let (start, travel) = if is_distance { (2e-3 * gap, -2.0 * travel) } else { (gap * 1e-3, -travel) };
    let task = Task { effort, inertia: 2e-3 * mass_g, start, travel, duration_ms };
    text += "[actuators.grip]\njoint = \"right\"\n";
    text += &powertrain(rng, task, SLIDE, is_distance);
    if is_distance {
        text += "feedback = { distance = [\"left.tip\", \"right.tip\"] }\n";
    }
    for side in ["right", "left"] {
        text += &contact(rng, &format!("{side}.skin"), "object", "pad");
    }
    text
}

/// A motor that drives an arm through a gear with play, as limits of the sum of both angles.
fn play(rng: &mut Random, mut text: String, duration_ms: f64) -> String {
    let (mass_g, length) = (rng.log_within(10.0, 300.0), rng.within(40.0, 90.0));
    let (inertia, ratio) = (1e-9 * mass_g * length * length / 3.0, rng.log_within(1.0, 20.0));
    let effort = inertia * 2.0 / (duration_ms * 1e-3).powi(2) * rng.log_within(1.0, 30.0) / ratio;
    text += &any_law(rng, "teeth", "rad");
    for (name, at, share) in [("rotor", [-40.0, 0.0], 0.3), ("out", [0.0; 2], 1.0)] {
        let place = pair(at, "mm");
        text += &format!("[bodies.{name}]\nguess = {{ at = {place} }}\n{}", bulk(rng, share * mass_g, share * length));
        text += &format!("[joints.{name}]\nbodies = [\"ground\", \"{name}\"]\nstart = \"0 rad\"\n");
        key(&mut text, "points", format_args!("[{place}, {}]", pair([0.0; 2], "mm")));
        text += &joint_losses(rng, effort, TURN);
    }
    text +=
        &format!("[limits.play]\njoints = [\"out\", \"rotor\"]\nfactors = [1, {:e}]\nstop = \"teeth\"\n", -1.0 / ratio);
    let half = rng.log_within(1e-3, 0.05);
    key(&mut text, "lower", quantity(-half, "rad"));
    if rng.chance(0.9) {
        key(&mut text, "upper", quantity(half, "rad"));
    }
    let task = Task { effort, inertia: inertia * 0.1, start: 0.0, travel: rng.choose(&[-1.0, 1.0]), duration_ms };
    text + &format!("[actuators.motor]\njoint = \"rotor\"\n{}", powertrain(rng, task, TURN, false))
}
