//! Texts of random disc scenes: up to three moving discs, fixed discs and a half plane, with one contact law.

use std::fmt::Write;

use super::random::{Random, pair, quantity, write_friction_law, write_normal_law};

pub fn scene_text(rng: &mut Random) -> String {
    let mut text = write_discs(rng, false);
    let damping = if rng.chance(0.1) { 0.0 } else { rng.log_within(1.0, 1e6) };
    let (exponent, stiffness) = (rng.choose(&[1.0, 1.5, 2.2, 2.2, 3.0]), rng.log_within(1e5, 1e10));
    write_normal_law(&mut text, "contact", [stiffness, exponent, damping, rng.log_within(1e-6, 1e-4)]);
    if rng.chance(0.8) {
        write_friction_law(rng, &mut text, "contact", [1e-4, 1e-1], [0.05, 1.4], 1.2);
    }
    text
}

/// Returns everything but laws and settings; with `extreme` ranges, discs may also overlap, and differ by decades.
pub fn write_discs(rng: &mut Random, extreme: bool) -> String {
    let duration_s = if extreme { rng.log_within(3e-4, 5e-2) } else { rng.log_within(1e-3, 3e-2) };
    let mut text = format!("kind = \"bodies\"\nduration = {}\n", quantity(duration_s, "s"));
    let moving = rng.choose(&[1, 1, 2, 2, 3]);
    let fixed = rng.choose(if extreme { &[0, 0, 1, 2] } else { &[0, 1, 1] });
    let mut discs = String::new();
    let mut free = 0;
    let mut x = 0.0;
    for index in 0..moving + fixed {
        let radius = if extreme { rng.log_within(2.0, 100.0) } else { rng.log_within(5.0, 60.0) };
        // Neighbours are separated; if extreme, some are in contact or overlap by up to 0.1 mm.
        let gap = match extreme {
            true if rng.chance(0.7) => rng.log_within(1e-3, 20.0),
            true => rng.choose(&[0.0, -1e-6, -1e-4, -1e-2, -0.1]),
            false => rng.log_within(1e-2, 10.0),
        };
        x += gap + radius;
        let heights = if extreme { &[0.0, 1e-3, -1e-3, 1.0, 10.0][..] } else { &[0.0, 0.1, 1.0, 5.0] };
        let centre = [x, radius + rng.choose(heights)];
        x += radius;
        let _ = writeln!(discs, "[discs.d{index}]\nradius = {}", quantity(radius, "mm"));
        let _ = writeln!(discs, "centre = {}", pair(centre, "mm"));
        if index >= moving {
            discs.push_str("motion = \"fixed\"\n");
            continue;
        }
        // In any direction, or towards the next discs and down.
        let velocity = match extreme {
            true => [0; 2].map(|_| if rng.chance(0.3) { 0.0 } else { rng.within(-5.0, 5.0) }),
            false => [rng.within(-1.0, 4.0), rng.within(-3.0, 1.0)],
        };
        let _ = writeln!(discs, "velocity = {}", pair(velocity, "m/s"));
        if (extreme || index > 0) && rng.chance(if extreme { 0.2 } else { 0.1 }) {
            let acceleration = [rng.within(-100.0, 100.0), rng.within(-100.0, 100.0)];
            let _ = writeln!(discs, "motion = \"driven\"\nacceleration = {}", pair(acceleration, "m/s^2"));
        } else {
            free += 1;
            let mass = if extreme { rng.log_within(1e-2, 1e4) } else { rng.log_within(1.0, 1e3) };
            let _ = writeln!(discs, "mass = {}", quantity(mass, "g"));
            if rng.chance(if extreme { 0.2 } else { 0.15 }) {
                discs.push_str("rotates = false\n");
                continue;
            }
        }
        if rng.chance(0.5) {
            let max_spin = if extreme { 200.0 } else { 100.0 };
            let _ = writeln!(discs, "spin = {}", quantity(rng.within(-max_spin, max_spin), "rad/s"));
        }
    }
    if free > 0 && rng.chance(if extreme { 0.5 } else { 0.7 }) {
        let [max_lateral, max_fall] = if extreme { [50.0, 981.0] } else { [20.0, 100.0] };
        let gravity = [rng.within(-max_lateral, max_lateral), -rng.within(0.0, max_fall)];
        let _ = writeln!(text, "gravity = {}", pair(gravity, "m/s^2"));
    }
    text.push_str(&discs);
    if rng.chance(0.6) {
        text.push_str("[half_plane]\n");
    }
    text
}
