//! Contact laws of scene texts.

use super::random::{Random, key, quantity};

/// Units of damping and depth of a contact and of a limit of a joint.
pub const CONTACT: [&str; 2] = ["N*s/m", "m"];
pub const LIMIT: [&str; 2] = ["N*m*s/rad", "rad"];

/// Writes a normal law with a damper that is turned on over a depth, in SI units, as a section.
pub fn write_normal_law(
    text: &mut String,
    section: &str,
    units: [&str; 2],
    [stiffness, exponent, damping, transition]: [f64; 4],
) {
    text.push_str(&format!("[{section}]\n"));
    key(text, "stiffness_si", format_args!("{stiffness:e}"));
    key(text, "exponent", format_args!("{exponent:e}"));
    key(text, "damping", quantity(damping, units[0]));
    key(text, "transition", quantity(transition, units[1]));
}

/// Writes a friction law with random values within the given bounds as a section; v_dynamic is at most 5 v_static.
pub fn write_friction_law(
    rng: &mut Random,
    text: &mut String,
    section: &str,
    v_static: [f64; 2],
    mu: [f64; 2],
    min_ratio: f64,
) {
    let v_static = rng.log_within(v_static[0], v_static[1]);
    text.push_str(&format!("[{section}.friction]\n"));
    key(text, "mu_static", format_args!("{:e}", rng.within(mu[0], mu[1])));
    let v_dynamic = v_static * rng.within(min_ratio, 5.0);
    key(text, "v_static", quantity(v_static, "m/s"));
    key(text, "v_dynamic", quantity(v_dynamic, "m/s"));
}

/// Returns bristle friction with this coefficient as an inline table.
pub fn bristle(rng: &mut Random, mu: f64, with_relaxation: bool) -> String {
    let damping = quantity(rng.log_within(10.0, 1000.0), "N*s/m");
    let relaxation = if with_relaxation && rng.chance(0.5) {
        format!(", bristle_relaxation = {}", quantity(rng.log_within(0.2, 2.0), "ms"))
    } else {
        String::new()
    };
    format!("{{ mu_static = {mu:e}, law = \"bristle\", bristle_damping = {damping}{relaxation} }}")
}

/// Returns the section of a law of a mechanism, of any type, for contacts (`unit` is m) or stops (rad).
pub fn any_law(rng: &mut Random, name: &str, unit: &str) -> String {
    let is_contact = unit == "m";
    let (exponent, stiffness) =
        rng.choose(&[(1.0, [1e4, 1e7]), (1.5, [1e5, 1e9]), (1.5, [1e5, 1e9]), (2.0, [1e6, 1e10]), (2.2, [1e7, 1e11])]);
    let [low, high] = if is_contact { stiffness } else { [10.0, 20.0].map(|base: f64| base.powf(exponent)) };
    let [low, high] = if is_contact { [low, high] } else { [10.0 * low, 1e3 * high] };
    let kind = rng.choose(&["hunt_crossley", "hunt_crossley", "restitution", "spring_damper", "step"]);
    let mut text = format!("[laws.{name}]\ntype = \"{kind}\"\nexponent = {exponent}\n");
    key(&mut text, "stiffness", format_args!("{:e}", rng.log_within(low, high)));
    // Damping, speed and depth of a stop: one radian is some centimetres.
    let [factor, speed, depth] = if is_contact { [1.0; 3] } else { [0.1, 10.0, 30.0] };
    match kind {
        "hunt_crossley" => {
            key(&mut text, "damping", quantity(factor * rng.log_within(0.05, 10.0), format_args!("s/{unit}")));
        }
        "restitution" => {
            key(&mut text, "restitution", rng.within(0.2, 1.0));
            key(&mut text, "speed", quantity(speed * rng.log_within(0.05, 2.0), format_args!("{unit}/s")));
        }
        _ if is_contact => key(&mut text, "damping", quantity(rng.log_within(1.0, 300.0), "N*s/m")),
        _ => key(&mut text, "damping", quantity(rng.log_within(1e-4, 1e-2), "N*m*s/rad")),
    }
    if kind == "step" {
        key(&mut text, "transition", quantity(depth * rng.log_within(1e-6, 5e-5), unit));
    }
    if is_contact && rng.chance(0.85) {
        let mu = rng.within(0.0, 1.5);
        let friction = if rng.chance(0.4) {
            bristle(rng, mu, true)
        } else {
            let (slow, dynamic) = (rng.log_within(1e-3, 0.1), mu * rng.within(0.5, 1.0));
            let [v_static, v_dynamic] = [slow, 2.0 * slow].map(|speed| quantity(speed, "m/s"));
            format!(
                "{{ mu_static = {mu:e}, mu_dynamic = {dynamic:e}, v_static = {v_static}, v_dynamic = {v_dynamic} }}"
            )
        };
        key(&mut text, "friction", friction);
    }
    text
}
