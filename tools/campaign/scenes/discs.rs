//! Texts of random disc scenes: up to three moving discs, fixed discs and a half plane, with one contact law.

use std::fmt::Write;

use super::law::{CONTACT, write_friction_law, write_normal_law};
use super::random::{Random, key, pair, quantity};

pub fn scene_text(rng: &mut Random) -> String {
    let mut text = format!("kind = \"bodies\"\nduration = {}\n", quantity(rng.log_within(1e-3, 3e-2), "s"));
    let moving = rng.choose(&[1, 1, 2, 2, 3]);
    let fixed = rng.choose(&[0, 1, 1]);
    let mut discs = String::new();
    let mut free = 0;
    let mut x = 0.0;
    for index in 0..moving + fixed {
        let radius = rng.log_within(5.0, 60.0);
        x += rng.log_within(1e-2, 10.0) + radius;
        let centre = [x, radius + rng.choose(&[0.0, 0.1, 1.0, 5.0])];
        x += radius;
        let _ = writeln!(discs, "[discs.d{index}]\nradius = {}", quantity(radius, "mm"));
        key(&mut discs, "centre", pair(centre, "mm"));
        if index >= moving {
            discs.push_str("motion = \"fixed\"\n");
            continue;
        }
        // Towards the next discs and down.
        key(&mut discs, "velocity", pair([rng.within(-1.0, 4.0), rng.within(-3.0, 1.0)], "m/s"));
        if index > 0 && rng.chance(0.1) {
            let acceleration = [rng.within(-100.0, 100.0), rng.within(-100.0, 100.0)];
            let _ = writeln!(discs, "motion = \"driven\"\nacceleration = {}", pair(acceleration, "m/s^2"));
        } else {
            free += 1;
            key(&mut discs, "mass", quantity(rng.log_within(1.0, 1e3), "g"));
            if rng.chance(0.15) {
                discs.push_str("rotates = false\n");
                continue;
            }
        }
        if rng.chance(0.5) {
            key(&mut discs, "spin", quantity(rng.within(-100.0, 100.0), "rad/s"));
        }
    }
    if free > 0 && rng.chance(0.7) {
        key(&mut text, "gravity", pair([rng.within(-20.0, 20.0), -rng.within(0.0, 100.0)], "m/s^2"));
    }
    text.push_str(&discs);
    if rng.chance(0.6) {
        text.push_str("[half_plane]\n");
    }
    let damping = if rng.chance(0.1) { 0.0 } else { rng.log_within(1.0, 1e6) };
    let (exponent, stiffness) = (rng.choose(&[1.0, 1.5, 2.2, 2.2, 3.0]), rng.log_within(1e5, 1e10));
    write_normal_law(&mut text, "contact", CONTACT, [stiffness, exponent, damping, rng.log_within(1e-6, 1e-4)]);
    if rng.chance(0.8) {
        write_friction_law(rng, &mut text, "contact", [1e-4, 1e-1], [0.05, 1.4], 1.2);
    }
    text
}
