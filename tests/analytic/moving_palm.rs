//! Grippers with braked motors on a moving palm, against an independent program.

use phalanx::analytic::ContactState;
use phalanx::integrator::{Linearised, Rates, System};
use phalanx::scene::{Axis, Move};

use super::gripper::{
    CONTACTS, GripperMode, GripperModel, QUADRATURES, assert_impulses, initial_state, max_error, run_engineering,
    run_reference, sample_times,
};
use crate::support::reference_cases::{cases_with_moving_palm, reference_case};

#[test]
fn reference_preset_agrees_with_an_independent_program() {
    for case in cases_with_moving_palm() {
        let (samples, end) = run_reference::<8>(&case.scene, sample_times(&case));
        let max_error = max_error(&case, &samples.states);
        assert!(max_error < 2e-9, "{}: {max_error:.1e}", case.name);
        assert_impulses(&case, &end);
        assert!((end.state.q[7] - case.scene.duration_s).abs() < 1e-14, "the last coordinate is the time");
    }
}

#[test]
fn engineering_preset_is_close_to_the_independent_program() {
    for (letter, bound) in [("d", 2e-7), ("e", 2e-7)] {
        let case = reference_case(letter);
        let (samples, _) = run_engineering::<8>(&case.scene, sample_times(&case));
        let max_error = max_error(&case, &samples.states);
        assert!(max_error < bound, "{}: {max_error:.1e}", case.name);
    }
}

/// The energy supplied by palm and motors equals the change of mechanical energy plus the losses in contacts and
/// brakes.
#[test]
fn energy_balances_in_the_palm_frame() {
    for case in cases_with_moving_palm() {
        let model = GripperModel::<8>::new(&case.scene.system);
        let (samples, _) = run_reference::<8>(&case.scene, sample_times(&case));
        let initial_state = initial_state::<8>(&case.scene.system);
        let mechanical_energy = |q: &[f64; 8], v: &[f64; 8]| {
            let energies = model.energies(q, v);
            energies.kinetic + energies.gravity + energies.spring + energies.elastic
        };
        for state in &samples.states {
            let gained_j =
                mechanical_energy(&state.q, &state.v) - mechanical_energy(&initial_state.q, &initial_state.v);
            let supplied_j = state.z[CONTACTS + 1] + state.z[CONTACTS];
            assert!(
                (gained_j - supplied_j).abs() < 1e-8,
                "{}: energy change {gained_j} J, supplied {supplied_j} J",
                case.name
            );
        }
    }
}

/// Compares every entry of the Jacobian with central differences, with all contacts active, a rotating palm and
/// creeping brakes.
#[test]
fn jacobian_matches_central_differences() {
    let mut scene = reference_case("e").scene;
    let motion = scene.system.palm_motion.as_mut().expect("a palm motion");
    motion.moves.push(Move { axis: Axis::Angle, distance: 0.3, start_s: 0.05, length_s: 0.06 });
    // The palm is at its pose at time t, and the table is within reach.
    let (t, [x, y, angle]) = (0.073, motion.pose(0.073).position);
    let q = [0.08, 1.22, 0.11, 1.31, 1e-3, 0.01998, 0.02, t];
    scene.system.table.as_mut().expect("a table").level_m = y + angle.sin() * q[4] + angle.cos() * q[5] + 0.01998;
    assert!(x != 0.0);
    let v = [4e-3, -7.0, -6e-3, 5.0, 0.3, 0.2, 4.0, 1.0];
    let model = GripperModel::<8>::new(&scene.system);
    let mut mode = GripperMode::FREE;
    mode.contacts = [ContactState::Active; CONTACTS];
    let exact: Linearised<8, QUADRATURES> = model.linearise(t, &q, &v, &mode);
    let outputs = |t: f64, q: &[f64; 8], v: &[f64; 8]| {
        let rates: Rates<8, QUADRATURES> = model.rates(t, q, v, &mode);
        let mut all_outputs = [0.0; 8 + QUADRATURES];
        all_outputs[..8].copy_from_slice(&rates.a);
        all_outputs[8..].copy_from_slice(&rates.g);
        all_outputs
    };
    assert!(outputs(t, &q, &v)[8 + 7] > 0.0, "the table is in contact");
    let column = |variable: usize, j: usize| -> Vec<f64> {
        let rows = |a: &[[f64; 8]; 8], g: &[[f64; 8]; QUADRATURES]| {
            a.iter().map(|row| row[j]).chain(g.iter().map(|row| row[j])).collect()
        };
        match variable {
            0 => rows(&exact.a_q, &exact.g_q),
            1 => rows(&exact.a_v, &exact.g_v),
            _ => exact.a_t.iter().chain(&exact.g_t).copied().collect(),
        }
    };
    let columns = (0..8).map(|j| (0, j)).chain((0..8).map(|j| (1, j))).chain([(2, 0)]);
    let mut scales = [0.0f64; 8 + QUADRATURES];
    let mut entries = Vec::new();
    for (variable, j) in columns {
        let shifted_outputs = |h: f64| {
            let (mut t, mut q, mut v) = (t, q, v);
            match variable {
                0 => q[j] += h,
                1 => v[j] += h,
                _ => t += h,
            }
            outputs(t, &q, &v)
        };
        let h = match (variable, j) {
            (0, 4 | 5) => 2e-7,
            (0, 7) | (2, _) => 1e-7,
            (0, _) => 5e-6,
            // Brakes creep at rates below 0.01 rad/s.
            (_, 0 | 2) => 1e-4,
            _ => 1e-3,
        };
        let (near, far): ([_; 2], [_; 2]) =
            ([shifted_outputs(h), shifted_outputs(-h)], [shifted_outputs(2.0 * h), shifted_outputs(-2.0 * h)]);
        for (i, entry) in column(variable, j).into_iter().enumerate() {
            let difference = (8.0 * (near[0][i] - near[1][i]) - (far[0][i] - far[1][i])) / (12.0 * h);
            scales[i] = scales[i].max(entry.abs() * if variable == 0 { 1.0 } else { 1e3 });
            entries.push((variable, i, j, entry, difference));
        }
    }
    for (variable, i, j, entry, difference) in entries {
        let scale = scales[i] / if variable == 0 { 1.0 } else { 1e3 };
        assert!(
            (entry - difference).abs() <= 2e-6 * scale,
            "derivative of output {i} by variable {variable}, {j}: {entry:e}, by differences {difference:e}"
        );
    }
}
