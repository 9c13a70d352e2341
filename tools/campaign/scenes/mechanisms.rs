//! Texts of random mechanisms: jaws, tendon fingers, linkages, sliders, thrown and falling bodies. Masses, stiffness,
//! damping and friction span decades. Lengths are in mm.

use std::f64::consts::PI;

use super::law::any_law;
use super::parts::{
    ANY, FACES, SLIDE, Shapes, Start, TURN, Task, bulk, contact, drive, free_body, joint_losses, outline, started,
    table,
};
use super::random::{Random, key, pair, quantity};

/// Returns the settings of a mechanism and the law `pad`; the duration is in ms.
fn base(rng: &mut Random, duration_ms: f64) -> String {
    let mut text = format!("kind = \"mechanism\"\nduration = {}\n", quantity(duration_ms, "ms"));
    if rng.chance(0.6) {
        key(&mut text, "gravity", pair([0.0, rng.choose(&[-9.81, 9.81])], "m/s^2"));
    }
    text + &any_law(rng, "pad", "m")
}

/// Two parallel jaws on sliders grip a body, free or on a floor.
pub fn jaws(rng: &mut Random) -> String {
    let (duration_ms, width) = (rng.log_within(15.0, 80.0), rng.log_within(10.0, 60.0));
    let mut text = base(rng, duration_ms);
    let mass_g = rng.log_within(10.0, 500.0);
    let gap = 0.5 * width + rng.log_within(0.2, 10.0);
    let travel = 1.5e-3 * gap;
    let effort = mass_g * 1e-3 * 2.0 * travel / (duration_ms * 1e-3).powi(2) * rng.log_within(1.0, 50.0);
    let angle = rng.within(-90.0, 90.0) * rng.choose(&[0.0, 0.0, 1.0]);
    let start = Start { at: [rng.within(-0.2, 0.2), 0.0], angle, ..Start::default() };
    text += &free_body(rng, "object", width, ANY, start);
    let is_mirrored = rng.chance(0.4);
    let is_coupled = !is_mirrored && rng.chance(0.4);
    let sides: &[_] = if is_mirrored { &[("right", 1.0)] } else { &[("right", 1.0), ("left", -1.0)] };
    for &(side, sign) in sides {
        let size = pair([10.0, width * rng.within(0.3, 1.5)], "mm");
        let rounding = quantity(rng.log_within(0.2, 2.0), "mm");
        text += &format!("[bodies.{side}]\nguess = {{ at = {} }}\n", pair([sign * gap, 0.0], "mm"));
        text += &bulk(rng, mass_g, width);
        text += &format!("[bodies.{side}.outlines.skin]\ntype = \"box\"\nsize = {size}\nrounding = {rounding}\n");
        key(&mut text, "center", pair([5.0 * sign, 0.0], "mm"));
        text += &format!("[joints.{side}]\ntype = \"prismatic\"\nbodies = [\"ground\", \"{side}\"]\n");
        text += &format!("points = [{0}, {0}]\n", pair([0.0; 2], "mm"));
        let losses = joint_losses(rng, effort, SLIDE);
        if is_coupled && side == "left" {
            text += &losses;
            continue;
        }
        let (start, travel) = (sign * gap * 1e-3, -sign * travel);
        let task = Task { effort, inertia: mass_g * 1e-3, start, travel, duration_ms };
        key(&mut text, "start", quantity(start, "m"));
        text += &format!("{losses}[actuators.{side}]\njoint = \"{side}\"\n{}", drive(rng, task, SLIDE));
    }
    if is_mirrored {
        text += "[mirror]\nfrom = \"right\"\nto = \"left\"\n";
    } else if is_coupled {
        text += "[couplings.mimic]\njoints = [\"left\", \"right\"]\nfactors = [1, 1]\n";
    }
    if !is_coupled && rng.chance(0.3) {
        let inertia = quantity(mass_g * rng.log_within(0.1, 3.0), "g");
        text +=
            &format!("[rotors.seesaw]\njoints = [\"left\", \"right\"]\nfactors = [0.5, 0.5]\ninertia = {inertia}\n");
    }
    if rng.chance(0.4) {
        let point = pair([0.0, -0.55 * width], "mm");
        text += &format!("[ground.outlines.floor]\ntype = \"half_plane\"\npoint = {point}\nnormal = [0, 1]\n");
        text += &any_law(rng, "floor", "m");
        text += &contact(rng, "object", "ground.floor", "floor");
    }
    for (side, _) in sides {
        text += &contact(rng, &format!("{side}.skin"), "object", "pad");
    }
    text
}

/// Tendon of a finger.
#[derive(Clone, Copy)]
struct Cable {
    is_elastic: bool,
    /// Whether it has a spool on the joint `shaft`.
    has_winch: bool,
    /// Whether it rubs, and passes under rings from which it lifts off where the finger is straight.
    rubs: bool,
}

/// Writes the path of a cable that rubs: a pulley or an eyelet at the foot, rings or eyelets on both phalanges, in either
/// direction. Then writes its friction.
fn rubbing_path(rng: &mut Random, text: &mut String, (side, sign): (&str, f64), [foot, lower, upper, inner]: [f64; 4]) {
    let is_reversed = rng.chance(0.3);
    let eyelet =
        |body: &str, at: [f64; 2], more: &str| format!("{{ eyelet = \"{body}\", at = {}{more} }}", pair(at, "mm"));
    let pulley = |body: &str, at: [f64; 2], radius: f64, is_left: bool, more: &str| {
        let turn = if is_left != is_reversed { "ccw" } else { "cw" };
        let radius = quantity(radius, "mm");
        format!("{{ pulley = \"{body}\", at = {}, radius = {radius}, turn = \"{turn}\"{more} }}", pair(at, "mm"))
    };
    let (proximal, distal) = (format!("{side}_proximal"), format!("{side}_distal"));
    let more = rng.choose(&["", "", ", roller = true"]);
    let guide = pulley("ground", [foot, 0.0], rng.within(4.0, 8.0), sign < 0.0, more);
    let mut path = vec![eyelet("ground", [foot + 25.0 * sign, -10.0], ""), guide];
    for (body, length, parts) in
        [(&proximal, lower, &[(0.3, 0.45), (0.6, 0.9)][..]), (&distal, upper, &[(0.1, 0.25)][..])]
    {
        for (low, high) in parts {
            let at = length * rng.within(*low, *high);
            let own = format!(", friction = {{ mu_static = {:e} }}", rng.log_within(0.02, 0.5));
            let more = if rng.chance(0.2) { own.as_str() } else { "" };
            if rng.chance(0.6) {
                let radius = rng.within(1.0, 4.0);
                path.push(pulley(body, [at, inner + sign * radius], radius, sign > 0.0, more));
            } else {
                path.push(eyelet(body, [at, inner], more));
            }
        }
    }
    path.push(eyelet(&distal, [upper * rng.within(0.4, 0.6), inner * rng.within(0.8, 1.2)], ""));
    if is_reversed {
        path.reverse();
    }
    *text += &format!("[tendons.{side}_flexor]\npath = [{}]\n", path.join(", "));
    if is_reversed {
        key(text, "from", "\"last\"");
    }
    let (mu, v_static) = (rng.log_within(0.03, 0.5), rng.log_within(1.0, 30.0));
    let mut law = format!("mu_static = {mu:e}, mu_dynamic = {:e}", mu * rng.within(0.5, 1.0));
    let rates = [v_static, v_static * rng.within(1.5, 4.0)].map(|rate| quantity(rate, "mm/s"));
    law += &format!(", v_static = {}, v_dynamic = {}", rates[0], rates[1]);
    if rng.chance(0.5) {
        law += &format!(", presliding = {}", quantity(rng.log_within(10.0, 300.0), "um"));
    }
    key(text, "friction", format_args!("{{ {law} }}"));
}

/// Writes a finger of two phalanges, to the right (`sign` is 1) or to the left of the object, and its tendon.
fn finger(rng: &mut Random, text: &mut String, (side, sign): (&str, f64), effort: f64, cable: Cable) {
    let (lower, upper) = (rng.within(35.0, 60.0), rng.within(25.0, 45.0));
    let (foot, lean) = (sign * rng.within(28.0, 45.0), rng.within(60.0, 85.0).to_radians());
    let turn = if sign > 0.0 { lean } else { PI - lean };
    let (width, mass_g) = (rng.within(4.0, 8.0), rng.log_within(10.0, 100.0));
    let (proximal, distal) = (format!("{side}_proximal"), format!("{side}_distal"));
    let knee = [foot + lower * turn.cos(), lower * turn.sin()];
    for (name, at, length, share) in [(&proximal, [foot, 0.0], lower, 1.0), (&distal, knee, upper, 0.6)] {
        let guess = format!("{{ at = {}, angle = {} }}", pair(at, "mm"), quantity(turn, "rad"));
        *text += &format!("[bodies.{name}]\nguess = {guess}\n{}", bulk(rng, mass_g * share, length));
        key(text, "com", pair([0.5 * length, 0.0], "mm"));
        *text += &if rng.chance(0.4) {
            let [center, size] = [[0.5 * length, 0.0], [length - 4.0, 2.0 * width]].map(|point| pair(point, "mm"));
            let rounding = quantity(rng.log_within(0.3, 3.0), "mm");
            format!("outlines.pad = {{ type = \"box\", center = {center}, size = {size}, rounding = {rounding} }}\n")
        } else {
            let [from, to] = [6.0, length - 6.0].map(|x| pair([x, 0.0], "mm"));
            let radius = quantity(width, "mm");
            format!("outlines.pad = {{ type = \"capsule\", from = {from}, to = {to}, radius = {radius} }}\n")
        };
    }
    let (limit, opening) = if sign > 0.0 { ("lower", -2.0) } else { ("upper", 2.0) };
    for (name, bodies, point, offset) in [
        ("base", ["ground", proximal.as_str()], [foot, 0.0], turn),
        ("middle", [&proximal, &distal], [lower, 0.0], 0.0),
    ] {
        let name = format!("{side}_{name}");
        *text += &format!("[joints.{name}]\nbodies = {bodies:?}\nstart = \"0 deg\"\nstop = \"stop\"\n");
        *text += &format!("points = [{}, {}]\n", pair(point, "mm"), pair([0.0; 2], "mm"));
        key(text, "offset", quantity(offset, "rad"));
        key(text, limit, quantity(rng.choose(&[opening, 0.0]), "deg"));
        *text += &joint_losses(rng, effort, TURN);
        *text += &format!("[springs.{name}]\njoint = \"{name}\"\n");
        key(text, "stiffness", quantity(effort * rng.log_within(0.05, 1.0), "N*m/rad"));
        key(text, "rest", quantity(-sign * rng.within(0.0, 1.0), "rad"));
        key(text, "damping", quantity(effort * rng.log_within(1e-4, 1e-2), "N*m*s/rad"));
    }
    let inner = sign * width * rng.within(0.5, 0.9);
    let eyelet = |body: &str, at| format!("{{ eyelet = \"{body}\", at = {} }}", pair(at, "mm"));
    let guide = if rng.chance(0.7) {
        let (radius, way) = (quantity(rng.within(4.0, 8.0), "mm"), if sign > 0.0 { "cw" } else { "ccw" });
        format!("{{ pulley = \"ground\", at = {}, radius = {radius}, turn = \"{way}\" }}", pair([foot, 0.0], "mm"))
    } else {
        eyelet("ground", [foot - 8.0 * sign, 0.0])
    };
    let path = [
        eyelet("ground", [foot + 25.0 * sign, -10.0]),
        guide,
        eyelet(&proximal, [lower * rng.within(0.5, 0.9), inner]),
        eyelet(&distal, [upper * rng.within(0.3, 0.6), inner]),
    ];
    if cable.rubs {
        rubbing_path(rng, text, (side, sign), [foot, lower, upper, inner]);
    } else {
        *text += &format!("[tendons.{side}_flexor]\npath = [{}]\n", path.join(", "));
    }
    if cable.is_elastic {
        key(text, "stiffness", quantity(rng.log_within(3e3, 3e5), "N/m"));
        key(text, "damping", quantity(rng.log_within(0.1, 30.0), "N*s/m"));
        if rng.chance(0.6) {
            key(text, "pretension", quantity(rng.log_within(0.1, 5.0), "N"));
        }
    }
    if cable.has_winch {
        let radius = quantity(rng.within(4.0, 10.0), "mm");
        key(text, "spools", format_args!("[{{ joint = \"shaft\", radius = {radius} }}]"));
    }
}

/// One or two tendon fingers close on a body or an outline of the ground, pulled over time or by a winch.
pub fn tendon_fingers(rng: &mut Random) -> String {
    fingers(rng, false)
}

/// Tendon fingers whose cables rub, lift off rings and return to them.
pub fn rubbing_fingers(rng: &mut Random) -> String {
    fingers(rng, true)
}

fn fingers(rng: &mut Random, rubs: bool) -> String {
    let (duration_ms, effort) = (rng.log_within(20.0, 60.0), rng.log_within(0.03, 1.0));
    let mut text = base(rng, duration_ms) + &any_law(rng, "stop", "rad");
    let hands = rng.choose(&["one", "mirror", "two"]);
    let sides: &[_] = if hands == "two" { &[("right", 1.0), ("left", -1.0)] } else { &[("right", 1.0)] };
    let elastic: Vec<bool> = sides.iter().map(|_| rng.chance(0.7)).collect();
    let has_winch = hands != "mirror" && elastic.iter().all(|is| *is) && rng.chance(0.7);
    for (side, is_elastic) in sides.iter().zip(elastic) {
        finger(rng, &mut text, *side, effort, Cable { is_elastic, has_winch, rubs });
    }
    if has_winch {
        let at = pair([0.0, -40.0], "mm");
        text += &format!("[bodies.winch]\nguess = {{ at = {at} }}\n{}", bulk(rng, 20.0, 15.0));
        text += "[joints.shaft]\nbodies = [\"ground\", \"winch\"]\nstart = \"0 deg\"\n";
        key(&mut text, "points", format_args!("[{at}, {}]", pair([0.0; 2], "mm")));
        let losses = joint_losses(rng, effort, TURN);
        if !losses.contains("armature") {
            key(&mut text, "armature", quantity(rng.log_within(1e-6, 1e-5), "kg*m^2"));
        }
        let task = Task { effort, inertia: 1e-5, start: 0.0, travel: 3.0, duration_ms };
        text += &format!("{losses}[actuators.motor]\njoint = \"shaft\"\n{}", drive(rng, task, TURN));
    } else {
        let pull = effort / 0.006;
        for (side, _) in sides {
            text += &format!("[actuators.{side}_flexor]\ntendon = \"{side}_flexor\"\n");
            if rng.chance(0.5) {
                key(&mut text, "tension", quantity(pull, "N"));
            } else {
                let (times, tensions) = table(rng, duration_ms, "N", |rng| pull * rng.unit());
                text += &format!("times = {times}\ntensions = {tensions}\n");
            }
        }
    }
    if hands == "mirror" {
        text += "[mirror]\nfrom = \"right\"\nto = \"left\"\n";
    }
    let size = rng.within(20.0, 34.0);
    let target = if rng.chance(0.3) {
        text += &format!("[ground.outlines]\nobject = {}\n", outline(rng, size, [0.0, 45.0], ANY));
        "ground.object"
    } else {
        let at = [rng.within(-2.0, 2.0), rng.within(30.0, 50.0)];
        let start = Start { at, angle: rng.within(-90.0, 90.0), ..Start::default() };
        text += &free_body(rng, "object", size, ANY, start);
        if rng.chance(0.5) {
            text += "[ground.outlines.palm]\ntype = \"half_plane\"\nnormal = [0, 1]\n";
            text += &contact(rng, "object", "ground.palm", "pad");
        }
        "object"
    };
    for (side, _) in sides {
        text += &contact(rng, &format!("{side}_*.pad"), target, "pad");
    }
    text
}

/// A four-bar with springs, friction, brake and rotor whose coupler hits a body; some have a second drive on a sum of
/// coordinates.
pub fn linkage(rng: &mut Random) -> String {
    let duration_ms = rng.log_within(10.0, 60.0);
    let mut text = base(rng, duration_ms);
    // Lengths that close, away from singular configurations: coupler and rocker meet above the line of their other ends.
    let ([crank, coupler, rocker, span], start, along, distance) = loop {
        let lengths = [(20.0, 40.0), (50.0, 80.0), (40.0, 70.0), (50.0, 70.0)].map(|(low, high)| rng.within(low, high));
        let ([crank, coupler, rocker, span], start) = (lengths, rng.within(0.6, 1.6));
        let distance = (span - crank * start.cos()).hypot(crank * start.sin());
        if (coupler - rocker).abs() + 5.0 < distance && distance < coupler + rocker - 5.0 {
            let along = (coupler * coupler - rocker * rocker + distance * distance) / (2.0 * distance);
            break (lengths, start, along, distance);
        }
    };
    let [x, y] = [crank * start.cos(), crank * start.sin()];
    let ([dx, dy], across) = ([span - x, -y], (coupler * coupler - along * along).sqrt());
    let tip = [x + (along * dx - across * dy) / distance, y + (along * dy + across * dx) / distance];
    let (slope, lift) = ((tip[1] - y).atan2(tip[0] - x), tip[1].atan2(tip[0] - span));
    let mass_g = rng.log_within(5.0, 200.0);
    let inertia = 1e-9 * mass_g * (crank * crank / 3.0 + coupler * coupler);
    let effort = inertia * 2.0 / (duration_ms * 1e-3).powi(2) * rng.log_within(1.0, 30.0);
    for (name, length, at, angle) in
        [("crank", crank, [0.0; 2], start), ("coupler", coupler, [x, y], slope), ("rocker", rocker, [span, 0.0], lift)]
    {
        let guess = format!("{{ at = {}, angle = {} }}", pair(at, "mm"), quantity(angle, "rad"));
        let mass_g = mass_g * rng.within(0.5, 2.0);
        text += &format!("[bodies.{name}]\nguess = {guess}\n{}", bulk(rng, mass_g, length));
        key(&mut text, "com", pair([0.5 * length, 0.0], "mm"));
        if name == "coupler" {
            let pad = outline(rng, coupler / 3.0, [coupler / 2.0, coupler / 5.0], FACES);
            key(&mut text, "outlines.pad", pad);
        }
    }
    for (name, bodies, [first, second]) in [
        ("a", ["ground", "crank"], [0.0, 0.0]),
        ("b", ["crank", "coupler"], [crank, 0.0]),
        ("c", ["coupler", "rocker"], [coupler, rocker]),
        ("d", ["ground", "rocker"], [span, 0.0]),
    ] {
        let points = [first, second].map(|x| pair([x, 0.0], "mm")).join(", ");
        text += &format!("[joints.{name}]\nbodies = {bodies:?}\npoints = [{points}]\n");
        if name == "a" {
            key(&mut text, "start", quantity(start, "rad"));
        }
        text += &joint_losses(rng, effort, TURN);
    }
    let travel = rng.choose(&[-1.0, 1.0]) * rng.within(0.3, 1.5);
    let task = Task { effort, inertia, start, travel, duration_ms };
    text += &format!("[actuators.motor]\njoint = \"a\"\n{}", drive(rng, task, TURN));
    if rng.chance(0.3) {
        text += "[springs.sum]\njoints = [\"a\", \"d\"]\nfactors = [1, -1]\n";
        key(&mut text, "offset", quantity(start - lift, "rad"));
        key(&mut text, "stiffness", quantity(effort * rng.log_within(0.1, 3.0), "N*m/rad"));
        key(&mut text, "damping", quantity(effort * rng.log_within(1e-4, 1e-2), "N*m*s/rad"));
    } else if rng.chance(0.5) {
        let points = [[span / 2.0, -20.0], [coupler / 2.0, 5.0]].map(|point| pair(point, "mm")).join(", ");
        text += "[springs.linear]\ntype = \"linear\"\nbodies = [\"ground\", \"coupler\"]\nrest = \"30 mm\"\n";
        key(&mut text, "points", format_args!("[{points}]"));
        key(&mut text, "stiffness", quantity(rng.log_within(10.0, 1000.0), "N/m"));
        key(&mut text, "damping", quantity(rng.log_within(0.01, 1.0), "N*s/m"));
    }
    if rng.chance(0.3) {
        text += "[rotors.gear]\njoints = [\"a\", \"d\"]\nfactors = [0.5, 0.5]\n";
        key(&mut text, "inertia", quantity(inertia * rng.log_within(0.1, 3.0), "kg*m^2"));
    }
    if rng.chance(0.3) {
        let task = Task { start: 0.5 * (start + lift), travel: rng.within(-0.5, 0.5), ..task };
        let mean = drive(rng, task, TURN);
        text += &format!("[actuators.mean]\njoints = [\"a\", \"d\"]\nfactors = [0.5, 0.5]\n{mean}");
    }
    // The object is on either side of the coupler, whose outline is on one of them.
    let (side, clearance) = (rng.choose(&[-1.0, 1.0]), rng.log_within(0.2, 3.0));
    let beyond = side * coupler / 5.0 + coupler / 6.0 + 10.0 + clearance;
    let normal = [-side * slope.sin(), side * slope.cos()];
    let at =
        [x + coupler / 2.0 * slope.cos() + beyond * normal[0], y + coupler / 2.0 * slope.sin() + beyond * normal[1]];
    let speed = rng.log_within(0.1, 3.0);
    let velocity = normal.map(|axis| -speed * axis + rng.within(-0.1, 0.1));
    let start = Start { at, velocity, spin: rng.within(-20.0, 20.0), ..Start::default() };
    text += &free_body(rng, "object", 20.0, ANY, start);
    text + &contact(rng, "coupler.pad", "object", "pad")
}

/// A slider carries a pendulum, with brake, friction, stop and a tendon; a body lies on the slider or hits the pendulum.
pub fn sliders(rng: &mut Random) -> String {
    let duration_ms = rng.log_within(15.0, 80.0);
    let mut text = base(rng, duration_ms) + &any_law(rng, "stop", "rad");
    text += "[laws.end]\nstiffness = 1e6\ndamping = \"1 s/m\"\n";
    let (mass_g, length) = (rng.log_within(20.0, 500.0), rng.within(25.0, 60.0));
    let travel = rng.choose(&[-1.0, 1.0]) * rng.log_within(1.0, 20.0) * 1e-3;
    let squared_s = (duration_ms * 1e-3).powi(2);
    let force = mass_g * 1e-3 * 2.0 * travel.abs() / squared_s * rng.log_within(1.0, 30.0);
    let inertia = 1e-9 * mass_g * 0.3 * length * length / 3.0;
    let torque = inertia * 2.0 / squared_s * rng.log_within(1.0, 50.0);
    text += &format!("[bodies.slider]\n{}", bulk(rng, mass_g, 40.0));
    let (center, size) = (pair([0.0; 2], "mm"), pair([60.0, 10.0], "mm"));
    let plate = format!("{{ type = \"box\", center = {center}, size = {size}, rounding = \"1 mm\" }}");
    key(&mut text, "outlines.plate", plate);
    let pin = pair([-40.0, 0.0], "mm");
    text += &format!("[bodies.arm]\n{}", bulk(rng, 0.3 * mass_g, length));
    key(&mut text, "com", pair([0.5 * length, 0.0], "mm"));
    key(&mut text, "guess", format_args!("{{ at = {pin}, angle = \"90 deg\" }}"));
    key(&mut text, "outlines.tip", outline(rng, length / 3.0, [0.8 * length, 0.0], FACES));
    text += "[joints.rail]\ntype = \"prismatic\"\nbodies = [\"ground\", \"slider\"]\nstart = \"0 mm\"\n";
    key(&mut text, "points", format_args!("[{center}, {center}]"));
    key(&mut text, "axis", quantity(rng.choose(&[0.0, 0.0, 1.0]) * rng.within(-30.0, 30.0), "deg"));
    text += &joint_losses(rng, force, SLIDE);
    if rng.chance(0.5) {
        text += "lower = \"-15 mm\"\nupper = \"15 mm\"\nstop = \"end\"\n";
    }
    text += "[joints.pin]\nbodies = [\"slider\", \"arm\"]\noffset = \"90 deg\"\nstart = \"0 rad\"\n";
    key(&mut text, "points", format_args!("[{pin}, {center}]"));
    key(&mut text, "start_rate", quantity(rng.within(-5.0, 5.0), "rad/s"));
    text += &joint_losses(rng, torque, TURN);
    if rng.chance(0.5) {
        text += "lower = \"-60 deg\"\nupper = \"60 deg\"\nstop = \"stop\"\n";
    }
    let task = Task { effort: force, inertia: mass_g * 1e-3, start: 0.0, travel, duration_ms };
    text += &format!("[actuators.rail]\njoint = \"rail\"\n{}", drive(rng, task, SLIDE));
    match rng.choose(&["drive", "tendon", "spring", "none"]) {
        "drive" => {
            let task = Task { effort: torque, inertia, start: 0.0, travel: rng.within(-1.0, 1.0), duration_ms };
            text += &format!("[actuators.pin]\njoint = \"pin\"\n{}", drive(rng, task, TURN));
        }
        "tendon" => {
            let points = [("ground", [-70.0, 30.0]), ("slider", [-52.0, 5.0])];
            let arm = ("arm", [0.5 * length, rng.choose(&[-4.0, 4.0])]);
            let eyelet = |(body, at)| format!("{{ eyelet = \"{body}\", at = {} }}", pair(at, "mm"));
            let path: Vec<String> = points.into_iter().chain([arm]).map(eyelet).collect();
            text += &format!("[tendons.cord]\npath = [{}]\n", path.join(", "));
            key(&mut text, "stiffness", quantity(rng.log_within(1e3, 1e5), "N/m"));
            key(&mut text, "damping", quantity(rng.log_within(0.1, 30.0), "N*s/m"));
            key(&mut text, "pretension", quantity(rng.log_within(0.1, 5.0), "N"));
        }
        "spring" => {
            text += "[springs.pin]\njoint = \"pin\"\n";
            key(&mut text, "stiffness", quantity(torque, "N*m/rad"));
            key(&mut text, "rest", quantity(rng.within(-1.0, 1.0), "rad"));
        }
        _ => {}
    }
    if rng.chance(0.6) {
        let at = [rng.within(-10.0, 15.0), 17.0 + rng.log_within(0.02, 5.0)];
        let velocity = [rng.within(-0.3, 0.3), -rng.log_within(0.01, 1.0)];
        text += &free_body(rng, "object", 24.0, ANY, Start { at, velocity, ..Start::default() });
        text += &contact(rng, "object", "slider.plate", "pad");
        text + &contact(rng, "object", "arm.tip", "pad")
    } else {
        let wall = outline(rng, 20.0, [length / 6.0 - 22.0, 0.8 * length], ANY);
        text += &format!("[ground.outlines]\nwall = {wall}\n");
        text + &contact(rng, "arm.tip", "ground.wall", "pad")
    }
}

/// One to three free bodies fall on a floor or hit each other.
pub fn thrown(rng: &mut Random) -> String {
    let duration_ms = rng.log_within(10.0, 100.0);
    let mut text = base(rng, duration_ms);
    let (count, size) = (rng.choose(&[1, 2, 3]), rng.log_within(10.0, 50.0));
    let mut height = -0.5 * size;
    for index in 0..count {
        height += size + rng.log_within(0.05, 5.0);
        let start = Start {
            at: [rng.within(-0.2, 0.2) * size, height],
            velocity: [rng.within(-1.0, 1.0), -rng.log_within(0.05, 3.0)],
            angle: rng.choose(&[0.0, 1.0]) * rng.within(-180.0, 180.0),
            spin: rng.choose(&[0.0, 1.0]) * rng.within(-30.0, 30.0),
        };
        // Two ellipses cannot touch.
        let shapes = if index % 2 == 1 { FACES } else { ANY };
        text += &free_body(rng, &format!("part_{index}"), size, shapes, start);
    }
    text += &any_law(rng, "floor", "m");
    text += "[ground.outlines]\n";
    let floor = if rng.chance(0.6) {
        format!("{{ type = \"half_plane\", normal = [{:e}, 1] }}", rng.within(-0.3, 0.3))
    } else {
        let (center, size) = (pair([0.0, -5.0], "mm"), pair([5.0 * size, 10.0], "mm"));
        format!("{{ type = \"box\", center = {center}, size = {size}, rounding = \"1 mm\" }}")
    };
    key(&mut text, "floor", floor);
    text += &contact(rng, "part_*", "ground.floor", "floor");
    for index in 1..count {
        text += &contact(rng, &format!("part_{}", index - 1), &format!("part_{index}"), "pad");
    }
    text
}

/// Two or three free bodies fall on a floor and on each other within 30 ms. All roundings exceed the penetrations.
pub fn falling(rng: &mut Random) -> String {
    let mut text = "kind = \"mechanism\"\nduration = \"30 ms\"\ngravity = [\"0 m/s^2\", \"-9.81 m/s^2\"]\n".to_string();
    let count = rng.choose(&[2, 3]);
    for body in 0..count {
        // Two ellipses cannot touch.
        let shapes = Shapes { rounding: [0.2, 0.4], ..if body == 0 { ANY } else { FACES } };
        let (size, center) = (rng.within(20.0, 32.0), [(); 2].map(|()| rng.within(-4.0, 4.0)));
        let skin = outline(rng, size, center, shapes);
        // Bodies side by side move towards the middle and down.
        let x = 55.0 * (f64::from(body) - 0.5 * f64::from(count - 1));
        let start = Start {
            at: [x, rng.within(34.0, 45.0)],
            velocity: [-0.02 * x + rng.within(-0.2, 0.2), rng.within(-1.5, -0.6)],
            angle: rng.within(-180.0, 180.0),
            spin: rng.within(-20.0, 20.0),
        };
        text += &format!("{}outlines.skin = {skin}\n", started(&format!("body{body}"), start));
        key(&mut text, "mass", quantity(rng.log_within(0.02, 0.1), "kg"));
        key(&mut text, "inertia", quantity(rng.log_within(2e-6, 1e-5), "kg*m^2"));
        key(&mut text, "com", pair([(); 2].map(|()| rng.within(-2.0, 2.0)), "mm"));
    }
    text += "[ground.outlines.floor]\ntype = \"half_plane\"\nnormal = [0, 1]\n[laws.hard]\nstiffness = 3e7\n";
    key(&mut text, "damping", quantity(rng.log_within(0.1, 1.0), "s/m"));
    if rng.chance(0.7) {
        text += "friction = { mu_static = 0.5, v_static = \"0.02 m/s\", v_dynamic = \"0.04 m/s\" }\n";
    }
    let at = rng.choose(&["face", "points", "middle"]);
    text + &format!("[[contacts]]\nbetween = [\"*\", \"*\"]\nlaw = \"hard\"\nat = \"{at}\"\n")
}
