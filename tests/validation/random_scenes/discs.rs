//! Texts of random scenes of discs: up to three moving discs, fixed discs, and a half plane.

use std::fmt::Write;

use super::finger::{engine, friction_law, integrator, normal_law};
use super::random::{Random, pair, quantity};

/// Returns a scene text. A few are rejected because of too deep initial overlaps.
pub fn scene_text(rng: &mut Random) -> String {
    let duration_s = rng.log_within(3e-4, 5e-2);
    let mut text = format!("kind = \"bodies\"\nduration = {}\n", quantity(duration_s, "s"));
    let moving = rng.choose(&[1, 1, 2, 2, 3]);
    let fixed = rng.choose(&[0, 0, 1, 2]);
    let mut free = 0;
    let mut discs = String::new();
    let mut x = 0.0;
    for index in 0..moving + fixed {
        let radius = rng.log_within(2.0, 100.0);
        // Neighbours are separated, in contact, or overlap by up to 0.1 mm.
        let gap = match rng.chance(0.7) {
            true => rng.log_within(1e-3, 20.0),
            false => rng.choose(&[0.0, -1e-6, -1e-4, -1e-2, -0.1]),
        };
        x += gap + radius;
        let centre = [x, radius + rng.choose(&[0.0, 1e-3, -1e-3, 1.0, 10.0])];
        x += radius;
        let _ = writeln!(discs, "[discs.d{index}]\nradius = {}", quantity(radius, "mm"));
        let _ = writeln!(discs, "centre = {}", pair(centre, "mm"));
        if index >= moving {
            discs.push_str("motion = \"fixed\"\n");
            continue;
        }
        let velocity = |rng: &mut Random| if rng.chance(0.3) { 0.0 } else { rng.within(-5.0, 5.0) };
        let _ = writeln!(discs, "velocity = {}", pair([velocity(rng), velocity(rng)], "m/s"));
        if rng.chance(0.2) {
            let acceleration = [rng.within(-100.0, 100.0), rng.within(-100.0, 100.0)];
            let _ = writeln!(discs, "motion = \"driven\"\nacceleration = {}", pair(acceleration, "m/s^2"));
        } else {
            free += 1;
            let _ = writeln!(discs, "mass = {}", quantity(rng.log_within(1e-2, 1e4), "g"));
            if rng.chance(0.2) {
                discs.push_str("rotates = false\n");
                continue;
            }
        }
        if rng.chance(0.5) {
            let _ = writeln!(discs, "spin = {}", quantity(rng.within(-200.0, 200.0), "rad/s"));
        }
    }
    if free > 0 && rng.chance(0.5) {
        let _ = writeln!(text, "gravity = {}", pair([rng.within(-50.0, 50.0), -rng.within(0.0, 981.0)], "m/s^2"));
    }
    text.push_str(&discs);
    if rng.chance(0.6) {
        text.push_str("[half_plane]\n");
    }
    normal_law(rng, &mut text, "contact", true);
    if rng.chance(0.7) {
        friction_law(rng, &mut text, "contact");
    }
    integrator(rng, &mut text, 0.1);
    engine(rng, &mut text, false);
    text
}
