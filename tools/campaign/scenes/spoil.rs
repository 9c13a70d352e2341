//! Spoiled texts of scenes of any family: values off by decades, missing keys and wrong units, and random settings of both
//! models. Most of them still run; the others must be refused with a reason.

use std::fmt::Write;

use toml::{Table, Value};

use super::random::{Random, key, quantity};
use super::scene_text;

/// Returns the spoiled text of a scene; its runs have a step budget.
pub fn spoiled(family: &str, seed: u64, max_steps: u64) -> String {
    let rng = &mut Random::for_seed(!seed);
    let mut scene = Value::Table(scene_text(family, seed).parse::<Table>().expect("TOML"));
    for _ in 0..rng.choose(&[0, 1, 1, 2]) {
        let mut count = 0;
        visit(&mut scene, &mut |_| {
            count += 1;
            true
        });
        let mut left = (rng.unit() * f64::from(count)) as u32;
        visit(&mut scene, &mut |value| {
            let is_chosen = left == 0;
            left = left.wrapping_sub(1);
            !is_chosen || change(rng, value)
        });
    }
    toml::to_string(&scene).expect("TOML") + &settings(rng, max_steps)
}

/// Calls `keep` with all values that are neither tables nor arrays, and removes those for which it returns false.
fn visit(value: &mut Value, keep: &mut impl FnMut(&mut Value) -> bool) -> bool {
    match value {
        Value::Table(table) => table.retain(|_, value| visit(value, keep)),
        Value::Array(array) => array.retain_mut(|value| visit(value, keep)),
        _ => return keep(value),
    }
    true
}

/// Changes a value; returns whether it stays.
fn change(rng: &mut Random, value: &mut Value) -> bool {
    let kind = rng.unit();
    let factor = if kind < 0.7 { rng.log_within(1e-2, 1e2) } else { rng.choose(&[0.0, -1.0]) };
    if kind > 0.9 {
        return false;
    }
    match value {
        Value::Float(number) => *number *= factor,
        Value::Integer(number) => *number = (*number as f64 * factor) as i64,
        Value::String(text) => {
            if let Some((number, unit)) =
                text.split_once(' ').and_then(|(number, unit)| Some((number.parse().ok()?, unit)))
            {
                let (number, unit): (f64, &str) = (number, unit);
                let other = ["mm", "m/s", "g", "N", "N*m", "deg", "s"];
                *text = if kind > 0.8 {
                    format!("{number:e} {}", rng.choose(&other))
                } else {
                    format!("{:e} {unit}", factor * number)
                };
            }
        }
        _ => {}
    }
    true
}

/// Returns settings of both models.
fn settings(rng: &mut Random, max_steps: u64) -> String {
    let mut text = format!("[integrator]\nmax_steps = {max_steps}\n");
    // Ten times as long as the default.
    if rng.chance(0.1) {
        text.push_str("preset = \"reference\"\n");
    } else if rng.chance(0.3) {
        let _ = writeln!(text, "method = \"{}\"", rng.choose(&["rodas5p", "radau5"]));
        key(&mut text, "rtol", format_args!("{:e}", rng.log_within(1e-8, 1e-3)));
    }
    let _ = writeln!(text, "[engine]\nmax_steps = {max_steps}");
    // Joints open further if steps are longer than the adaptive ones.
    let mut is_coarse = false;
    if rng.chance(0.3) {
        is_coarse = true;
        let _ = writeln!(text, "stepping = \"fixed\"\nstep = {}", quantity(rng.log_within(1e-6, 2e-4), "s"));
    } else if rng.chance(0.3) {
        key(&mut text, "tolerance", quantity(rng.log_within(1e-8, 1e-5), "m"));
    }
    if rng.chance(0.1) {
        is_coarse = true;
        let _ = writeln!(text, "law = \"rapier\"\nfriction = {:e}", rng.within(0.0, 1.0));
        key(&mut text, "restitution", format_args!("{:e}", rng.choose(&[0.0, 0.5, 1.0])));
    }
    if is_coarse {
        text.push_str("[validate]\nloop_gap = \"10 um\"\n");
    }
    text
}
