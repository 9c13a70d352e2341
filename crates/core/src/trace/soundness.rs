//! Whether the steps of the engine still are a motion: joints that have come apart, and energy from nowhere, end a run.

use super::Energy;
use crate::scene::{Stepping, System};

/// What ends a run: joints open by this part of the shortest link, and energy from nowhere by this much of what was put in.
///
/// Adaptive steps: over the shipped scenes joints open by up to 4.2e-7 of the shortest link, and up to 1e-4 of the energy comes from
/// nowhere (0.09 where only 4e-10 J were put in). Where joints tear, they open by a link within a few steps, and 1e5 times the energy is
/// there.
const ADAPTIVE: [f64; 2] = [1e-2, 10.0];
/// Steps of a given length may be as coarse as they like: those of 1e-4 s open joints by up to 1.3e-2, those of 1e-3 s by 0.2, and 12 times
/// the energy is there in the first 1e-4 s of a joint that rings against its stop.
const FIXED: [f64; 2] = [1.0, 1e3];
/// Energies below this, J, and below this part of those at hand, are rounding.
const ROUNDING_J: f64 = 1e-15;
const ROUNDING: f64 = 1e-12;

/// What is known of a run up to a step.
#[derive(Clone, Debug)]
pub(super) struct Soundness {
    limits: [f64; 2],
    shortest_link_m: f64,
    start: Energy,
    /// Largest energy put in so far, J: by the start, motors and what is driven, gravity and springs.
    put_in_j: f64,
}

impl Soundness {
    pub fn new(system: &System, stepping: Stepping, start: Energy) -> Self {
        let limits = if let Stepping::Adaptive { .. } = stepping { ADAPTIVE } else { FIXED };
        Self { limits, shortest_link_m: system.shortest_link_m(), start, put_in_j: 0.0 }
    }

    /// Takes the energies after a step of `dt_s`, and the largest opening of a joint; why they are none of a motion, if so.
    pub fn take(&mut self, energy: &Energy, gap_m: f64, dt_s: f64) -> Option<String> {
        let (start, shortest_link_m) = (&self.start, self.shortest_link_m);
        let fallen_j = (energy.gravity_j - start.gravity_j).abs() + (energy.spring_j - start.spring_j).abs();
        let put_in_j = start.kinetic_j + start.elastic_j + fallen_j + energy.motor_work_j.abs();
        self.put_in_j = self.put_in_j.max(put_in_j);
        // Contacts that dissipate less than nothing create energy that the balance does not miss.
        let created_j = energy.balance_j.abs().max(-energy.dissipated_j);
        let at_hand_j: f64 = energy.values_j().iter().map(|part| part.abs()).sum();
        let [most_open, most_created] = self.limits;
        let what = if gap_m > most_open * shortest_link_m {
            format!("a joint is open by {gap_m:.1e} m, where the shortest link has {shortest_link_m:.1e} m")
        } else if created_j > most_created * self.put_in_j + ROUNDING_J + ROUNDING * at_hand_j {
            format!("{created_j:.1e} J came from nowhere, where {:.1e} J were put in", self.put_in_j)
        } else {
            return None;
        };
        Some(format!(
            "{what}, after a step of {dt_s:.1e} s: rapier's joints do not hold at these steps; give [engine] a smaller `tolerance` or \
             `max_step`, or take the analytic model"
        ))
    }
}
