//! Grippers whose motors are blocked and whose palm moves, against an independent program.

use phalanx::analytic::SiteState;
use phalanx::integrator::{Linearised, Rates, System};
use phalanx::scene::{Axis, Move};

use super::gripper::{
    GripperMode, GripperModel, PLACES, QUADRATURES, assert_impulses, everyday, off, reference, start, times,
};
use crate::support::grippers::{anchor, carried};

#[test]
fn the_reference_agrees_with_an_independent_program() {
    for anchor in carried() {
        let (found, end) = reference::<8>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        assert!(off < 2e-9, "{}: {off:.1e}", anchor.name);
        assert_impulses(&anchor, &end);
        assert!((end.state.q[7] - anchor.scene.duration_s).abs() < 1e-14, "time is a coordinate");
    }
}

#[test]
fn the_everyday_preset_is_near_it() {
    for (letter, bound) in [("d", 2e-7), ("e", 2e-7)] {
        let anchor = anchor(letter);
        let (found, _) = everyday::<8>(&anchor.scene, times(&anchor));
        let off = off(&anchor, &found.states);
        assert!(off < bound, "{}: {off:.1e}", anchor.name);
    }
}

/// What the palm and its motors gave is what is there, or was lost in contacts and brakes.
#[test]
fn energy_balances_in_the_frame_of_the_palm() {
    for anchor in carried() {
        let model = GripperModel::<8>::new(&anchor.scene.system);
        let (found, _) = reference::<8>(&anchor.scene, times(&anchor));
        let start = start::<8>(&anchor.scene.system);
        let all = |q: &[f64; 8], v: &[f64; 8]| {
            let energies = model.energies(q, v);
            energies.kinetic + energies.gravity + energies.spring + energies.elastic
        };
        for state in &found.states {
            let gained = all(&state.q, &state.v) - all(&start.q, &start.v);
            let given = state.z[PLACES + 1] + state.z[PLACES];
            assert!((gained - given).abs() < 1e-8, "{}: {gained} {given}", anchor.name);
        }
    }
}

/// Every entry of the Jacobian against central differences, with everything in contact, the palm turning, and brakes that creep.
#[test]
fn the_jacobian_is_that_of_the_accelerations() {
    let mut scene = anchor("e").scene;
    let motion = scene.system.palm_motion.as_mut().expect("it moves");
    motion.moves.push(Move { axis: Axis::Angle, distance: 0.3, start_s: 0.05, length_s: 0.06 });
    // Where the palm is at that time, the table is in reach.
    let (t, [x, y, angle]) = (0.073, motion.pose(0.073).place);
    let q = [0.08, 1.22, 0.11, 1.31, 1e-3, 0.01998, 0.02, t];
    scene.system.table.as_mut().expect("a table").level_m = y + angle.sin() * q[4] + angle.cos() * q[5] + 0.01998;
    assert!(x != 0.0);
    let v = [4e-3, -7.0, -6e-3, 5.0, 0.3, 0.2, 4.0, 1.0];
    let model = GripperModel::<8>::new(&scene.system);
    let mut mode = GripperMode::FREE;
    mode.sites = [SiteState::Active; PLACES];
    let exact: Linearised<8, QUADRATURES> = model.linearise(t, &q, &v, &mode);
    let outputs = |t: f64, q: &[f64; 8], v: &[f64; 8]| {
        let rates: Rates<8, QUADRATURES> = model.rates(t, q, v, &mode);
        let mut all = [0.0; 8 + QUADRATURES];
        all[..8].copy_from_slice(&rates.a);
        all[8..].copy_from_slice(&rates.g);
        all
    };
    assert!(outputs(t, &q, &v)[8 + 7] > 0.0, "the table is pressed on");
    let column = |kind: usize, j: usize| -> Vec<f64> {
        let rows = |a: &[[f64; 8]; 8], g: &[[f64; 8]; QUADRATURES]| {
            a.iter().map(|row| row[j]).chain(g.iter().map(|row| row[j])).collect()
        };
        match kind {
            0 => rows(&exact.a_q, &exact.g_q),
            1 => rows(&exact.a_v, &exact.g_v),
            _ => exact.a_t.iter().chain(&exact.g_t).copied().collect(),
        }
    };
    let all = (0..8).map(|j| (0, j)).chain((0..8).map(|j| (1, j))).chain([(2, 0)]);
    let mut scales = [0.0f64; 8 + QUADRATURES];
    let mut found = Vec::new();
    for (kind, j) in all {
        let at = |h: f64| {
            let (mut t, mut q, mut v) = (t, q, v);
            match kind {
                0 => q[j] += h,
                1 => v[j] += h,
                _ => t += h,
            }
            outputs(t, &q, &v)
        };
        let h = match (kind, j) {
            (0, 4 | 5) => 2e-7,
            (0, 7) | (2, _) => 1e-7,
            (0, _) => 5e-6,
            // Brakes creep within a hundredth.
            (_, 0 | 2) => 1e-4,
            _ => 1e-3,
        };
        let (near, far): ([_; 2], [_; 2]) = ([at(h), at(-h)], [at(2.0 * h), at(-2.0 * h)]);
        for (i, entry) in column(kind, j).into_iter().enumerate() {
            let difference = (8.0 * (near[0][i] - near[1][i]) - (far[0][i] - far[1][i])) / (12.0 * h);
            scales[i] = scales[i].max(entry.abs() * if kind == 0 { 1.0 } else { 1e3 });
            found.push((kind, i, j, entry, difference));
        }
    }
    for (kind, i, j, entry, difference) in found {
        let scale = scales[i] / if kind == 0 { 1.0 } else { 1e3 };
        assert!(
            (entry - difference).abs() <= 2e-6 * scale,
            "{kind}: {i} by {j}: {entry:e}, by differences {difference:e}"
        );
    }
}
