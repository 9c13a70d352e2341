//! Grippers whose motors are blocked and whose palm moves, against an independent program.

use phalanx::analytic::gripper::{GripperModel, PLACES};

use super::gripper::{everyday, off, reference, times};
use crate::support::grippers::{anchor, carried};

#[test]
fn the_reference_agrees_with_an_independent_program() {
    for anchor in carried() {
        let (found, end) = reference::<8>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        println!("{}: {off:.1e} in {} steps", anchor.name, end.counters.steps);
        assert!(off < 2e-9, "{}: {off:.1e}", anchor.name);
        for (place, wanted) in [0, 1, 3, 4, 6, 7].into_iter().zip(anchor.impulse) {
            let impulse = end.state.z[place];
            assert!((impulse - wanted).abs() < 1e-6 * wanted.max(1e-3), "{}: {place} {impulse} {wanted}", anchor.name);
        }
        assert_eq!(end.state.q[7], anchor.scene.duration_s, "time is a coordinate");
    }
}

#[test]
fn the_everyday_preset_is_near_it() {
    for (letter, bound) in [("d", 2e-7), ("e", 2e-7)] {
        let anchor = anchor(letter);
        let (found, end) = everyday::<8>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        println!("{}: {off:.1e} in {} steps", anchor.name, end.counters.steps);
        assert!(off < bound, "{}: {off:.1e}", anchor.name);
    }
}

/// What the palm and its motors gave is what is there, or was lost in contacts and brakes.
#[test]
fn energy_balances_in_the_frame_of_the_palm() {
    for anchor in carried() {
        let model = GripperModel::<8>::new(&anchor.scene);
        let (found, _) = reference::<8>(&anchor.scene, times(&anchor));
        let start = phalanx::analytic::gripper::start::<8>(&anchor.scene);
        let all = |q: &[f64; 8], v: &[f64; 8]| {
            let energies = model.energies(q, v);
            energies.kinetic + energies.gravity + energies.spring + energies.elastic
        };
        for state in &found.states {
            let gained = all(&state.q, &state.v) - all(&start.q, &start.v);
            let given = state.z[PLACES + 1] + state.z[PLACES];
            println!("{}: {gained:e} of {given:e}, {:e} by palm and motors", anchor.name, state.z[PLACES + 1]);
            assert!((gained - given).abs() < 1e-8, "{}: {gained} {given}", anchor.name);
        }
    }
}
