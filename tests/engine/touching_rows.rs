//! Rows of discs that just touch: at rest they stay at rest, wherever the row lies; hit at one end, they hand the momentum on.

use std::fmt::Write;

use crate::support::runs::engine;
use phalanx::scene::parse_any;
use phalanx::trace::{BodyState, Outcome};

/// A row of equal discs, the first of which moves along the row.
#[derive(Clone, Copy)]
struct Row {
    discs: usize,
    first_m: [f64; 2],
    turn_rad: f64,
    radius_m: f64,
    mass_kg: f64,
    stiffness: f64,
    exponent: f64,
    damping: f64,
    speed_m_s: f64,
    on_plane: bool,
}

const ROW: Row = Row {
    discs: 4,
    first_m: [0.0; 2],
    turn_rad: 0.0,
    radius_m: 0.01,
    mass_kg: 0.1,
    stiffness: 1e9,
    exponent: 1.5,
    damping: 1e3,
    speed_m_s: 0.0,
    on_plane: false,
};

impl Row {
    fn run(&self) -> Outcome {
        let mut text = "kind = \"bodies\"\nduration = \"0.5 ms\"\n".to_string();
        let (sin, cos) = self.turn_rad.sin_cos();
        for disc in 0..self.discs {
            let along = 2.0 * self.radius_m * disc as f64;
            let [x, y] = [self.first_m[0] + along * cos, self.first_m[1] + along * sin];
            let _ =
                writeln!(text, "[discs.d{disc}]\nradius = \"{:e} m\"\nmass = \"{:e} kg\"", self.radius_m, self.mass_kg);
            let _ = writeln!(text, "centre = [\"{x:e} m\", \"{y:e} m\"]");
            if disc == 0 {
                let [u, v] = [self.speed_m_s * cos, self.speed_m_s * sin];
                let _ = writeln!(text, "velocity = [\"{u:e} m/s\", \"{v:e} m/s\"]");
            }
        }
        if self.on_plane {
            text.push_str("[half_plane]\n");
        }
        let _ = writeln!(text, "[contact]\nstiffness_si = {:e}\nexponent = {:e}", self.stiffness, self.exponent);
        let _ = writeln!(text, "damping = \"{:e} N*s/m\"", self.damping);
        let scene = parse_any(&text, "row.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        engine(&scene).0
    }

    /// Nothing moves, nothing presses, and nothing is dissipated.
    #[track_caller]
    fn rests(&self) {
        let outcome = self.run();
        let still = |body: &BodyState| body.velocity_m_s == [0.0; 2] && body.spin_rad_s == 0.0;
        assert!(outcome.last.bodies.iter().all(still), "{:?}", outcome.last.bodies);
        for contact in &outcome.contacts {
            assert_eq!((contact.touchdowns, contact.peak_normal_n, contact.impulse_n_s), (0, 0.0, 0.0));
        }
        assert_eq!(outcome.last.energy.balance_j, 0.0);
        assert!(outcome.work.steps < 100, "{} steps", outcome.work.steps);
    }

    /// The momentum stays, and the energy balances to a thousandth.
    #[track_caller]
    fn hands_on(&self) {
        let outcome = self.run();
        let (sin, cos) = self.turn_rad.sin_cos();
        let along = |body: &BodyState| body.velocity_m_s[0] * cos + body.velocity_m_s[1] * sin;
        let sum: f64 = outcome.last.bodies.iter().map(along).sum();
        assert!((sum / self.speed_m_s - 1.0).abs() < 1e-9, "{sum:e} of {:e} m/s", self.speed_m_s);
        let brought_j = 0.5 * self.mass_kg * self.speed_m_s * self.speed_m_s;
        let energy = &outcome.last.energy;
        assert!(energy.balance_j.abs() < 2e-3 * brought_j, "{energy:?}");
        assert!(energy.kinetic_j < (1.0 + 1e-3) * brought_j, "{energy:?}");
        assert!(outcome.last.bodies[1].velocity_m_s != [0.0; 2]);
    }
}

#[test]
fn rows_at_rest_stay_at_rest_wherever_they_lie() {
    for discs in 2..=8 {
        for first_m in [[0.0; 2], [0.1, 0.2], [-3.0, 7.0], [100.0, -50.0], [900.0, 900.0]] {
            Row { discs, first_m, ..ROW }.rests();
        }
        for turn_rad in [0.1, 0.7, 2.3, 3.0] {
            Row { discs, turn_rad, ..ROW }.rests();
            Row { discs, turn_rad, first_m: [5.0, 5.0], ..ROW }.rests();
        }
        Row { discs, on_plane: true, first_m: [0.0, 0.01], ..ROW }.rests();
    }
}

#[test]
fn rows_at_rest_stay_at_rest_whatever_they_are_made_of() {
    for discs in [4, 7] {
        for radius_m in [1e-4, 1e-3, 0.1, 1.0, 10.0] {
            Row { discs, radius_m, ..ROW }.rests();
        }
        for mass_kg in [1e-6, 1e-3, 10.0, 1e3] {
            Row { discs, mass_kg, ..ROW }.rests();
        }
        for stiffness in [1e3, 1e6, 1e12] {
            for exponent in [1.0, 1.5, 2.2, 3.0] {
                Row { discs, stiffness, exponent, ..ROW }.rests();
            }
        }
        for damping in [0.0, 1.0, 1e6] {
            Row { discs, damping, ..ROW }.rests();
        }
    }
}

#[test]
fn a_row_that_is_hit_hands_the_momentum_on() {
    for speed_m_s in [1e-6, 1e-4, 1e-2, 1.0] {
        for discs in [2, 4, 6, 8] {
            for exponent in [1.0, 1.5, 2.2] {
                Row { discs, exponent, speed_m_s, ..ROW }.hands_on();
            }
        }
        Row { discs: 5, speed_m_s, damping: 0.0, ..ROW }.hands_on();
        Row { discs: 6, speed_m_s, turn_rad: 0.7, first_m: [1.0, 2.0], ..ROW }.hands_on();
        Row { discs: 6, speed_m_s, on_plane: true, first_m: [0.0, 0.01], ..ROW }.hands_on();
        Row { discs: 8, speed_m_s, exponent: 3.0, mass_kg: 1e-3, ..ROW }.hands_on();
    }
}
