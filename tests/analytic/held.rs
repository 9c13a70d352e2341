//! Grippers whose friction holds, against an independent program.

use phalanx::analytic::gripper::HELD;

use super::gripper::{assert_impulses, everyday, off, reference, times};
use crate::support::grippers::held;

/// Relaxation times of contacts and brakes in the anchors: stretch is σ times that.
const RELAXATION_S: [f64; 8] = [1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 2e-4, 2e-4];

#[test]
fn the_reference_agrees_with_an_independent_program() {
    for anchor in held() {
        let (found, end) = reference::<HELD>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        assert!(off < 2e-9, "{}: {off:.1e}", anchor.name);
        for (slot, (wanted, relaxation)) in anchor.stretch.into_iter().zip(RELAXATION_S).enumerate() {
            let stretch = relaxation * end.state.v[HELD - 8 + slot];
            assert!((stretch - wanted).abs() < 1e-6 * wanted.abs() + 1e-14, "{}: {slot}: {stretch:e}", anchor.name);
        }
        assert_impulses(&anchor, &end);
    }
}

#[test]
fn the_everyday_preset_is_near_it() {
    for anchor in held() {
        let (found, _) = everyday::<HELD>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        assert!(off < 5e-7, "{}: {off:.1e}", anchor.name);
    }
}
