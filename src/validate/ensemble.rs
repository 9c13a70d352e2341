//! The members of the ensemble: the scene with its motor torque changed by parts in 1e9.

use crate::scene::{Actuation, Scene};

/// Runs of which the worst counts.
pub const MEMBERS: usize = 5;

/// Relative difference of the motor torque from one member to the next: far below any bound in its effect, and enough
/// to shift where steps fall.
pub const TORQUE_STEP: f64 = 1e-9;

/// The scene as the member `index` has it; member 0 is the scene itself.
pub fn member(scene: &Scene, index: usize) -> Scene {
    Scene { actuation: scaled(&scene.actuation, 1.0 + index as f64 * TORQUE_STEP), ..scene.clone() }
}

/// A torque `factor` times as large at every time.
pub(super) fn scaled(actuation: &Actuation, factor: f64) -> Actuation {
    let mut scaled = actuation.clone();
    match &mut scaled {
        Actuation::Constant { torque_n_m }
        | Actuation::Ramp { torque_n_m, .. }
        | Actuation::HalfSine { torque_n_m, .. }
        | Actuation::Reversal { torque_n_m, .. } => *torque_n_m *= factor,
        Actuation::Table { points, .. } => points.iter_mut().for_each(|(_, torque_n_m)| *torque_n_m *= factor),
    }
    scaled
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Interpolation, torque};

    #[test]
    fn every_kind_of_torque_is_scaled_at_every_time() {
        let points = vec![(0.0, 0.1), (1e-3, 0.4), (5e-3, -0.2)];
        for actuation in [
            Actuation::Constant { torque_n_m: 0.48 },
            Actuation::Ramp { torque_n_m: 0.48, rise_s: 2e-3 },
            Actuation::HalfSine { torque_n_m: 0.48, length_s: 8e-3 },
            Actuation::Reversal { torque_n_m: 0.48, at_s: 3e-3 },
            Actuation::Table { points: points.clone(), interpolation: Interpolation::Linear },
            Actuation::Table { points, interpolation: Interpolation::Step },
        ] {
            let twice = scaled(&actuation, 2.0);
            for t in [0.0, 0.7e-3, 2.1e-3, 6e-3] {
                assert_eq!(torque(&twice, t).0, 2.0 * torque(&actuation, t).0, "{actuation:?} at {t}");
            }
        }
    }
}
