//! Rows of discs at zero gaps: at rest they stay at rest at any position; hit at one end, they transmit the momentum.

use crate::support::laws::{disc, free, run_to_end, scene, scene_on_plane};
use phalanx::law::NormalLaw;
use phalanx::trace::{BodyState, Model, Outcome};

/// A row of equal discs; the first disc starts with a speed along the row.
#[derive(Clone, Copy)]
struct Row {
    discs: usize,
    first_m: [f64; 2],
    direction_rad: f64,
    radius_m: f64,
    mass_kg: f64,
    stiffness: f64,
    exponent: f64,
    damping: f64,
    speed_m_s: f64,
    with_half_plane: bool,
}

const ROW: Row = Row {
    discs: 4,
    first_m: [0.0; 2],
    direction_rad: 0.0,
    radius_m: 0.01,
    mass_kg: 0.1,
    stiffness: 1e9,
    exponent: 1.5,
    damping: 1e3,
    speed_m_s: 0.0,
    with_half_plane: false,
};

impl Row {
    fn run(&self) -> Outcome {
        let (sin, cos) = self.direction_rad.sin_cos();
        let row = (0..self.discs).map(|index| {
            let along = 2.0 * self.radius_m * index as f64;
            let centre_m = [self.first_m[0] + along * cos, self.first_m[1] + along * sin];
            let speed = if index == 0 { self.speed_m_s } else { 0.0 };
            let inertia_kg_m2 = 0.5 * self.mass_kg * self.radius_m * self.radius_m;
            let motion = free(self.mass_kg, Some(inertia_kg_m2), [speed * cos, speed * sin]);
            disc(&format!("d{index}"), self.radius_m, centre_m, motion)
        });
        let normal = NormalLaw::step(self.stiffness, self.exponent, self.damping, 1e-5);
        let of_discs = if self.with_half_plane { scene_on_plane } else { scene };
        run_to_end(Model::Engine, &of_discs(row.collect(), normal, None, 0.5e-3)).0
    }

    /// Asserts that there is no motion, no contact force and no dissipation.
    #[track_caller]
    fn assert_stays_at_rest(&self) {
        let outcome = self.run();
        let is_at_rest = |body: BodyState| body.velocity_m_s == [0.0; 2] && body.spin_rad_s == 0.0;
        assert!(outcome.last.bodies().all(is_at_rest), "{:?}", outcome.last);
        for contact in &outcome.contacts {
            assert_eq!((contact.touchdowns, contact.peak_normal_n, contact.impulse_n_s), (0, 0.0, 0.0));
        }
        assert_eq!(outcome.last.energy().balance_j, 0.0);
        assert!(outcome.work.steps < 100, "{} steps", outcome.work.steps);
    }

    /// Asserts that momentum is conserved and that the energy balances to 0.2 %.
    #[track_caller]
    fn assert_transmits_momentum(&self) {
        let outcome = self.run();
        let (sin, cos) = self.direction_rad.sin_cos();
        let along = |body: BodyState| body.velocity_m_s[0] * cos + body.velocity_m_s[1] * sin;
        let sum: f64 = outcome.last.bodies().map(along).sum();
        assert!((sum / self.speed_m_s - 1.0).abs() < 1e-9, "{sum:e} of {:e} m/s", self.speed_m_s);
        let initial_j = 0.5 * self.mass_kg * self.speed_m_s * self.speed_m_s;
        let energy = &outcome.last.energy();
        assert!(energy.balance_j.abs() < 2e-3 * initial_j, "{energy:?}");
        assert!(energy.kinetic_j < (1.0 + 1e-3) * initial_j, "{energy:?}");
        assert!(outcome.last.body(1).velocity_m_s != [0.0; 2]);
    }
}

#[test]
fn rows_stay_at_rest_at_all_positions() {
    for discs in 2..=8 {
        for first_m in [[0.0; 2], [0.1, 0.2], [-3.0, 7.0], [100.0, -50.0], [900.0, 900.0]] {
            Row { discs, first_m, ..ROW }.assert_stays_at_rest();
        }
        for direction_rad in [0.1, 0.7, 2.3, 3.0] {
            Row { discs, direction_rad, ..ROW }.assert_stays_at_rest();
            Row { discs, direction_rad, first_m: [5.0, 5.0], ..ROW }.assert_stays_at_rest();
        }
        Row { discs, with_half_plane: true, first_m: [0.0, 0.01], ..ROW }.assert_stays_at_rest();
    }
}

#[test]
fn rows_stay_at_rest_with_all_parameters() {
    for discs in [4, 7] {
        for radius_m in [1e-4, 1e-3, 0.1, 1.0, 10.0] {
            Row { discs, radius_m, ..ROW }.assert_stays_at_rest();
        }
        for mass_kg in [1e-6, 1e-3, 10.0, 1e3] {
            Row { discs, mass_kg, ..ROW }.assert_stays_at_rest();
        }
        for stiffness in [1e3, 1e6, 1e12] {
            for exponent in [1.0, 1.5, 2.2, 3.0] {
                Row { discs, stiffness, exponent, ..ROW }.assert_stays_at_rest();
            }
        }
        for damping in [0.0, 1.0, 1e6] {
            Row { discs, damping, ..ROW }.assert_stays_at_rest();
        }
    }
}

#[test]
fn a_row_hit_at_one_end_transmits_the_momentum() {
    for speed_m_s in [1e-6, 1e-4, 1e-2, 1.0] {
        for discs in [2, 4, 6, 8] {
            for exponent in [1.0, 1.5, 2.2] {
                Row { discs, exponent, speed_m_s, ..ROW }.assert_transmits_momentum();
            }
        }
        Row { discs: 5, speed_m_s, damping: 0.0, ..ROW }.assert_transmits_momentum();
        Row { discs: 6, speed_m_s, direction_rad: 0.7, first_m: [1.0, 2.0], ..ROW }.assert_transmits_momentum();
        Row { discs: 6, speed_m_s, with_half_plane: true, first_m: [0.0, 0.01], ..ROW }.assert_transmits_momentum();
        Row { discs: 8, speed_m_s, exponent: 3.0, mass_kg: 1e-3, ..ROW }.assert_transmits_momentum();
    }
}
