//! Plausibility check of engine steps: open joints or unexplained energy end a run.

use super::Energy;
use super::schema::State;
use crate::scene::{Scene, Stepping};

/// Limits for adaptive steps: joint opening relative to the shortest link, and created energy relative to the supplied
/// energy.
///
/// In the shipped scenes joints open by up to 4.2e-7 of the shortest link, and up to 1e-4 of the supplied energy is
/// created (0.09 where only 4e-10 J are supplied). Joints that fail open by a link length within a few steps, and the
/// energy grows by a factor of 1e5.
const ADAPTIVE: [f64; 2] = [1e-2, 10.0];
/// Limits for fixed steps, which may be arbitrarily coarse: steps of 1e-4 s open joints by up to 1.3e-2, steps of 1e-3
/// s by 0.2, and a joint that oscillates against its stop has 12 times the energy in its first 1e-4 s.
const FIXED: [f64; 2] = [1.0, 1e3];
/// Energies below this value, J, are rounding errors.
const ROUNDING_J: f64 = 1e-15;
/// Energies below this fraction of the total energy are rounding errors.
const ROUNDING: f64 = 1e-12;

/// State of the check up to the current step.
#[derive(Clone, Debug)]
pub(super) struct ConsistencyCheck {
    limits: [f64; 2],
    shortest_link_m: f64,
    start: Energy,
    /// Largest supplied energy so far, J: initial energy, work of motors and driven bodies, and changes of the energies
    /// of gravity and springs.
    input_j: f64,
}

impl ConsistencyCheck {
    pub fn new(scene: &Scene, start: Energy) -> Self {
        let limits = if let Stepping::Adaptive { .. } = scene.engine.stepping { ADAPTIVE } else { FIXED };
        Self { limits, shortest_link_m: scene.shortest_link_m(), start, input_j: 0.0 }
    }

    /// Checks the energies and the largest joint opening after a step of `dt_s`. Returns the reason if the motion is
    /// not valid.
    pub fn check(&mut self, energy: &Energy, gap_m: f64, dt_s: f64) -> Option<String> {
        let (start, shortest_link_m) = (&self.start, self.shortest_link_m);
        let potential_change_j = (energy.gravity_j - start.gravity_j).abs() + (energy.spring_j - start.spring_j).abs();
        let input_j = start.kinetic_j + start.elastic_j + potential_change_j + energy.motor_work_j.abs();
        self.input_j = self.input_j.max(input_j);
        // Contacts with negative dissipation create energy that does not appear in the balance.
        let created_j = energy.balance_j.abs().max(-energy.dissipated_j);
        let total_j: f64 = energy.values().iter().map(|value| value.abs()).sum();
        let [max_opening, max_created] = self.limits;
        let reason = if gap_m > max_opening * shortest_link_m {
            format!("a joint is open by {gap_m:.1e} m, but the shortest link has {shortest_link_m:.1e} m")
        } else if created_j > max_created * self.input_j + ROUNDING_J + ROUNDING * total_j {
            format!("{created_j:.1e} J of energy were created, with {:.1e} J put in", self.input_j)
        } else {
            return None;
        };
        Some(format!(
            "{reason}, after a step of {dt_s:.1e} s: rapier's joints are not accurate at this step size; set a \
             smaller `tolerance` or `max_step` in [engine], or use the analytic model"
        ))
    }
}
