//! Texts of random scenes of discs: up to three that move, fixed ones, and a half plane.

use std::fmt::Write;

use super::dice::{Dice, pair, quantity};
use super::finger::{engine, friction_law, integrator, law};

/// A scene text; a few are refused because their discs start too deep in each other.
pub fn text(dice: &mut Dice) -> String {
    let duration_s = dice.decades(3e-4, 5e-2);
    let mut text = format!("kind = \"bodies\"\nduration = {}\n", quantity(duration_s, "s"));
    let moving = dice.pick(&[1, 1, 2, 2, 3]);
    let fixed = dice.pick(&[0, 0, 1, 2]);
    let mut free = 0;
    let mut discs = String::new();
    let mut x = 0.0;
    for index in 0..moving + fixed {
        let radius = dice.decades(2.0, 100.0);
        // Side by side: apart, touching, or in each other by up to a tenth of a millimetre.
        let gap = match dice.chance(0.7) {
            true => dice.decades(1e-3, 20.0),
            false => dice.pick(&[0.0, -1e-6, -1e-4, -1e-2, -0.1]),
        };
        x += gap + radius;
        let centre = [x, radius + dice.pick(&[0.0, 1e-3, -1e-3, 1.0, 10.0])];
        x += radius;
        let _ = writeln!(discs, "[discs.d{index}]\nradius = {}", quantity(radius, "mm"));
        let _ = writeln!(discs, "centre = {}", pair(centre, "mm"));
        if index >= moving {
            discs.push_str("motion = \"fixed\"\n");
            continue;
        }
        let velocity = |dice: &mut Dice| if dice.chance(0.3) { 0.0 } else { dice.within(-5.0, 5.0) };
        let _ = writeln!(discs, "velocity = {}", pair([velocity(dice), velocity(dice)], "m/s"));
        if dice.chance(0.2) {
            let acceleration = [dice.within(-100.0, 100.0), dice.within(-100.0, 100.0)];
            let _ = writeln!(discs, "motion = \"driven\"\nacceleration = {}", pair(acceleration, "m/s^2"));
        } else {
            free += 1;
            let _ = writeln!(discs, "mass = {}", quantity(dice.decades(1e-2, 1e4), "g"));
            if dice.chance(0.2) {
                discs.push_str("rotates = false\n");
                continue;
            }
        }
        if dice.chance(0.5) {
            let _ = writeln!(discs, "spin = {}", quantity(dice.within(-200.0, 200.0), "rad/s"));
        }
    }
    if free > 0 && dice.chance(0.5) {
        let _ = writeln!(text, "gravity = {}", pair([dice.within(-50.0, 50.0), -dice.within(0.0, 981.0)], "m/s^2"));
    }
    text.push_str(&discs);
    if dice.chance(0.6) {
        text.push_str("[half_plane]\n");
    }
    law(dice, &mut text, "contact", true);
    if dice.chance(0.7) {
        friction_law(dice, &mut text, "contact");
    }
    integrator(dice, &mut text, 0.1);
    engine(dice, &mut text, false);
    text
}
