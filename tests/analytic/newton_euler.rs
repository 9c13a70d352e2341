//! The equations of motion against an independent formulation: Newton–Euler equations of four free bodies (x, y, θ
//! each) with the ten constraint equations of five revolute joints.
//!
//! With constraints Φ(r) = 0 and G = ∂Φ/∂r, every motion is ṙ = N q̇_a, where the columns of N span the null space of G
//! (found here by elimination, with one column for each ground link), and r̈ = N q̈_a + b, where G b = −Ġ ṙ. Projected
//! on N, Newton–Euler gives M = Nᵀ 𝓜 N and c = Nᵀ (𝓜 b − F). It uses no Lagrangian, no cut loop and no relative angles.

// Loops over matrix indices follow the formulas.
#![allow(clippy::needless_range_loop)]

use crate::support::runs::{Random, experiment_95, reference_settings, run_to_end};
use phalanx::fivebar::dynamics::{Dynamics, Terms, absolute_rates, bias, inverse_dynamics, solve_mass, terms};
use phalanx::fivebar::kinematics::{Directions, directions, passive_bias, passive_rates, reference_gamma};
use phalanx::gripper::{Assembly, Body, Finger, Lengths};

const BODIES: usize = 4;
const COORDINATES: usize = 3 * BODIES;
const CONSTRAINTS: usize = 10;

/// Absolute angles of l11, l21, l12, l22, by the law of cosines and Newton's method on the loop closure; `None` if the
/// loop cannot close.
fn angles(lengths: &Lengths, gamma: f64, q: [f64; 2]) -> Option<[f64; 4]> {
    let a12 = [lengths.l11_m * q[0].cos(), lengths.l11_m * q[0].sin()];
    let a22 = [lengths.l21_m * q[1].cos(), lengths.l21_m * q[1].sin()];
    let d = [a22[0] - a12[0], a22[1] - a12[1]];
    let distance = d[0].hypot(d[1]);
    let cosine = (distance.powi(2) + lengths.l12_m.powi(2) - lengths.l22_m.powi(2)) / (2.0 * distance * lengths.l12_m);
    if cosine.abs() >= 1.0 {
        return None;
    }
    let mut theta3 = d[1].atan2(d[0]) + gamma * cosine.acos();
    let a13 = [a12[0] + lengths.l12_m * theta3.cos(), a12[1] + lengths.l12_m * theta3.sin()];
    let mut theta4 = (a13[1] - a22[1]).atan2(a13[0] - a22[0]);
    for _ in 0..3 {
        let ((s3, c3), (s4, c4)) = (theta3.sin_cos(), theta4.sin_cos());
        let (l, r) = (lengths.l12_m, lengths.l22_m);
        let residual = [l * c3 - r * c4 - d[0], l * s3 - r * s4 - d[1]];
        // [−l s3, r s4; l c3, −r c4] Δ = −residual.
        let determinant = l * r * (s3 * c4 - c3 * s4);
        theta3 += (r * c4 * residual[0] + r * s4 * residual[1]) / determinant;
        theta4 += (l * c3 * residual[0] + l * s3 * residual[1]) / determinant;
    }
    Some([q[0], q[1], theta3, theta4])
}

/// Solves A X = B by Gaussian elimination with full pivoting.
fn solve<const M: usize>(
    mut a: [[f64; CONSTRAINTS]; CONSTRAINTS],
    mut b: [[f64; M]; CONSTRAINTS],
) -> [[f64; M]; CONSTRAINTS] {
    let mut columns: [usize; CONSTRAINTS] = std::array::from_fn(|i| i);
    for k in 0..CONSTRAINTS {
        let remaining = (k..CONSTRAINTS).flat_map(|i| (k..CONSTRAINTS).map(move |j| (i, j)));
        let (row, column) = remaining.max_by(|x, y| a[x.0][x.1].abs().total_cmp(&a[y.0][y.1].abs())).expect("a pivot");
        a.swap(k, row);
        b.swap(k, row);
        for line in &mut a {
            line.swap(k, column);
        }
        columns.swap(k, column);
        let (pivot, pivot_b) = (a[k], b[k]);
        for i in k + 1..CONSTRAINTS {
            let factor = a[i][k] / pivot[k];
            for j in k..CONSTRAINTS {
                a[i][j] -= factor * pivot[j];
            }
            for j in 0..M {
                b[i][j] -= factor * pivot_b[j];
            }
        }
    }
    let mut x = [[0.0; M]; CONSTRAINTS];
    for k in (0..CONSTRAINTS).rev() {
        for m in 0..M {
            let solved: f64 = (k + 1..CONSTRAINTS).map(|j| a[k][j] * x[columns[j]][m]).sum();
            x[columns[k]][m] = (b[k][m] - solved) / a[k][k];
        }
    }
    x
}

/// A revolute joint between point `outer.1` of body `outer.0` and point `inner.1` of body `inner.0`, in body frames.
/// Without an inner body the joint is on the ground, at the origin.
struct Joint {
    outer: (usize, [f64; 2]),
    inner: Option<(usize, [f64; 2])>,
}

/// Projected equations of motion and passive kinematics.
struct ProjectedDynamics {
    mass: [[f64; 2]; 2],
    bias: [f64; 2],
    /// Sum of the magnitudes of all terms of `bias`, the scale of its rounding errors.
    bias_scale: f64,
    /// θ̈3 and θ̈4 at q̈_a = 0.
    passive_bias: [f64; 2],
    /// Derivatives of θ̇3 and θ̇4 by q̇11 and q̇21.
    passive_rates: [[f64; 2]; 2],
}

fn newton_euler(finger: &Finger, gamma: f64, gravity: [f64; 2], q: [f64; 2], v: [f64; 2]) -> Option<ProjectedDynamics> {
    let lengths = &finger.lengths;
    let theta = angles(lengths, gamma, q)?;
    let bodies: [&Body; BODIES] = [&finger.bodies.l11, &finger.bodies.l21, &finger.bodies.l12, &finger.bodies.l22];
    // Joint points of a body relative to its centre of mass, in the body frame.
    let root = |i: usize| (i, bodies[i].com_m.map(|x| -x));
    let end = |i: usize, length: f64| (i, [length - bodies[i].com_m[0], -bodies[i].com_m[1]]);
    let joints = [
        Joint { outer: root(0), inner: None },
        Joint { outer: root(1), inner: None },
        Joint { outer: root(2), inner: Some(end(0, lengths.l11_m)) },
        Joint { outer: root(3), inner: Some(end(1, lengths.l21_m)) },
        Joint { outer: end(2, lengths.l12_m), inner: Some(end(3, lengths.l22_m)) },
    ];
    let rotated = |i: usize, p: [f64; 2]| {
        let (s, c) = theta[i].sin_cos();
        [c * p[0] - s * p[1], s * p[0] + c * p[1]]
    };
    let mut g = [[0.0; COORDINATES]; CONSTRAINTS];
    for (k, joint) in joints.iter().enumerate() {
        for (sign, end) in [(1.0, Some(joint.outer)), (-1.0, joint.inner)] {
            let Some((i, point)) = end else { continue };
            let arm = rotated(i, point);
            g[2 * k][3 * i] = sign;
            g[2 * k + 1][3 * i + 1] = sign;
            g[2 * k][3 * i + 2] = -sign * arm[1];
            g[2 * k + 1][3 * i + 2] = sign * arm[0];
        }
    }
    // Independent coordinates: the angles of bodies 0 and 1.
    let independent = [2, 5];
    let dependent: Vec<usize> = (0..COORDINATES).filter(|i| !independent.contains(i)).collect();
    let square = g.map(|row| std::array::from_fn(|j| row[dependent[j]]));
    let right: [[f64; 2]; CONSTRAINTS] = g.map(|row| independent.map(|i| -row[i]));
    let null = solve(square, right);
    let mut n = [[0.0; 2]; COORDINATES];
    for (j, row) in dependent.iter().zip(&null) {
        n[*j] = *row;
    }
    (n[2], n[5]) = ([1.0, 0.0], [0.0, 1.0]);

    let rates = n.map(|row| row[0] * v[0] + row[1] * v[1]);
    // −Ġ ṙ: a point at `arm` from the centre of mass has the centripetal acceleration −ω² arm.
    let mut gamma_terms = [[0.0; 1]; CONSTRAINTS];
    for (k, joint) in joints.iter().enumerate() {
        for (sign, end) in [(1.0, Some(joint.outer)), (-1.0, joint.inner)] {
            let Some((i, point)) = end else { continue };
            let (arm, omega) = (rotated(i, point), rates[3 * i + 2]);
            gamma_terms[2 * k][0] += sign * omega * omega * arm[0];
            gamma_terms[2 * k + 1][0] += sign * omega * omega * arm[1];
        }
    }
    let particular = solve(square, gamma_terms);
    let mut b = [0.0; COORDINATES];
    for (j, row) in dependent.iter().zip(&particular) {
        b[*j] = row[0];
    }

    let inertia: [f64; COORDINATES] =
        std::array::from_fn(|i| if i % 3 == 2 { bodies[i / 3].inertia_kg_m2 } else { bodies[i / 3].mass_kg });
    let force: [f64; COORDINATES] =
        std::array::from_fn(|i| if i % 3 == 2 { 0.0 } else { bodies[i / 3].mass_kg * gravity[i % 3] });
    let mut projected = ProjectedDynamics {
        mass: [[0.0; 2]; 2],
        bias: [0.0; 2],
        bias_scale: 0.0,
        passive_bias: [b[8], b[11]],
        passive_rates: [n[8], n[11]],
    };
    for i in 0..COORDINATES {
        for r in 0..2 {
            for c in 0..2 {
                projected.mass[r][c] += n[i][r] * inertia[i] * n[i][c];
            }
            let term = n[i][r] * (inertia[i] * b[i] - force[i]);
            projected.bias[r] += term;
            projected.bias_scale += n[i][r].abs() * (inertia[i] * b[i].abs() + force[i].abs());
        }
    }
    Some(projected)
}

/// A finger and a state at which the formulations are compared.
struct Case {
    finger: Finger,
    gamma: f64,
    gravity: [f64; 2],
    q: [f64; 2],
    v: [f64; 2],
}

fn assembly_sign(finger: &Finger) -> f64 {
    let reference = reference_gamma(&finger.lengths);
    if finger.assembly == Assembly::Reference { reference } else { -reference }
}

/// Random fingers in random states, at least 12° from a singular configuration.
fn random_cases(count: usize) -> Vec<Case> {
    let mut random = Random(7);
    let mut cases = Vec::new();
    while cases.len() < count {
        let finger = random.finger();
        let gamma = if random.within(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 };
        let q = [random.within(-3.0, 3.0), random.within(-3.0, 3.0)];
        let v = [random.within(-400.0, 400.0), random.within(-400.0, 400.0)];
        let gravity = [random.within(-10.0, 10.0), random.within(-10.0, 10.0)];
        let Some(theta) = angles(&finger.lengths, gamma, q) else { continue };
        if (theta[3] - theta[2]).sin().abs() > 0.2 {
            cases.push(Case { finger, gamma, gravity, q, v });
        }
    }
    cases
}

/// All samples of the closing of design 95, through both impacts to the grasp.
fn closing_cases() -> Vec<Case> {
    let mut scene = experiment_95();
    scene.integrator = reference_settings();
    let (_, log) = run_to_end(&scene);
    let finger = scene.finger().linkage;
    let state = |s: &phalanx::trace::Sample| Case {
        finger,
        gamma: assembly_sign(&finger),
        gravity: scene.system.gravity_m_s2,
        q: [s.finger(0).q11_rad, s.finger(0).q21_rad],
        v: [s.finger(0).qd11_rad_s, s.finger(0).qd21_rad_s],
    };
    log.samples.iter().map(state).collect()
}

fn closed_form(case: &Case) -> Terms<f64> {
    let dynamics = Dynamics::new(&case.finger, case.gamma, case.gravity);
    terms(&dynamics, directions(&case.finger.lengths, case.gamma, case.q))
}

/// Largest relative differences of M, of c, and of the torques at random accelerations.
fn max_errors(cases: &[Case]) -> [f64; 3] {
    let mut random = Random(11);
    let mut max_errors = [0.0f64; 3];
    for case in cases {
        let expected = newton_euler(&case.finger, case.gamma, case.gravity, case.q, case.v).expect("in reach");
        let actual = closed_form(case);
        let c = bias(&actual, absolute_rates(&actual.rates, case.v));
        let mass = [[actual.mass[0], actual.mass[1]], [actual.mass[1], actual.mass[2]]];
        let size = expected.mass.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs()));
        let acceleration = [random.within(-1e5, 1e5), random.within(-1e5, 1e5)];
        let dynamics = Dynamics::new(&case.finger, case.gamma, case.gravity);
        let torque = inverse_dynamics(&dynamics, case.q, case.v, acceleration);
        let recovered = solve_mass(&actual.mass, [torque[0] - c[0], torque[1] - c[1]]);
        for i in 0..2 {
            for j in 0..2 {
                max_errors[0] = max_errors[0].max((mass[i][j] - expected.mass[i][j]).abs() / size);
            }
            max_errors[1] = max_errors[1].max((c[i] - expected.bias[i]).abs() / expected.bias_scale);
            let expected_torque =
                expected.mass[i][0] * acceleration[0] + expected.mass[i][1] * acceleration[1] + expected.bias[i];
            let scale = size * acceleration[0].abs().max(acceleration[1].abs()) + expected.bias_scale;
            max_errors[2] = max_errors[2].max((torque[i] - expected_torque).abs() / scale);
            let condition = size * size / (mass[0][0] * mass[1][1] - mass[0][1] * mass[1][0]);
            let recovery_error =
                (recovered[i] - acceleration[i]).abs() / (acceleration[0].abs() + acceleration[1].abs());
            assert!(
                recovery_error < 1e-13 * (1.0 + condition) * (1.0 + expected.bias_scale / scale),
                "{recovery_error:e}"
            );
        }
    }
    max_errors
}

#[test]
fn closing_of_design_95_agrees_with_newton_euler() {
    let cases = closing_cases();
    assert!(cases.len() > 500, "{}", cases.len());
    let max_errors = max_errors(&cases);
    println!("closing: mass, bias, torque {max_errors:?}");
    assert!(max_errors.iter().all(|w| *w < 1e-12), "{max_errors:?}");
}

#[test]
fn random_fingers_in_both_assembly_modes_agree_with_newton_euler() {
    let max_errors = max_errors(&random_cases(4000));
    println!("random: mass, bias, torque {max_errors:?}");
    assert!(max_errors.iter().all(|w| *w < 1e-12), "{max_errors:?}");
}

#[test]
fn passive_rates_and_accelerations_agree_with_the_null_space() {
    let mut max_errors = [0.0f64; 2];
    for case in random_cases(4000).iter().chain(&closing_cases()) {
        let expected = newton_euler(&case.finger, case.gamma, case.gravity, case.q, case.v).expect("in reach");
        let pose = directions(&case.finger.lengths, case.gamma, case.q);
        let rates = passive_rates(&case.finger.lengths, &pose);
        let curvature = passive_bias(&case.finger.lengths, &pose, &rates);
        let squares = absolute_rates(&rates, case.v).map(|r| r * r);
        for (i, (row, curvature_row)) in [(rates.a3, curvature.b3), (rates.a4, curvature.b4)].into_iter().enumerate() {
            let size = expected.passive_rates.iter().flatten().fold(1.0f64, |a, b| a.max(b.abs()));
            for j in 0..2 {
                max_errors[0] = max_errors[0].max((row[j] - expected.passive_rates[i][j]).abs() / size);
            }
            let terms: Vec<f64> = curvature_row.iter().zip(squares).map(|(b, s)| b * s).collect();
            let scale: f64 = terms.iter().map(|x| x.abs()).sum::<f64>() + 1e-300;
            max_errors[1] = max_errors[1].max((terms.iter().sum::<f64>() - expected.passive_bias[i]).abs() / scale);
        }
    }
    println!("largest errors of passive rates and accelerations: {max_errors:?}");
    assert!(max_errors.iter().all(|w| *w < 1e-12), "{max_errors:?}");
}

/// Compares rates and accelerations with central differences of sixth order of θ3(s) and θ4(s) along q(s) = q + s v,
/// where v is scaled so that the fastest link turns by 1 rad per unit of s.
#[test]
fn second_order_kinematics_agree_with_differences_of_the_geometry() {
    let mut max_errors = [0.0f64; 2];
    for case in random_cases(300) {
        let lengths = &case.finger.lengths;
        let pose = directions(lengths, case.gamma, case.q);
        let rates = passive_rates(lengths, &pose);
        let fastest = absolute_rates(&rates, case.v).into_iter().fold(0.0f64, |a, b| a.max(b.abs()));
        let v = case.v.map(|x| x / fastest);
        let angles_at = |s: f64| {
            let moved: Directions<f64> = directions(lengths, case.gamma, [case.q[0] + s * v[0], case.q[1] + s * v[1]]);
            let angle = |from: [f64; 2], to: [f64; 2]| {
                (from[0] * to[1] - from[1] * to[0]).atan2(from[0] * to[0] + from[1] * to[1])
            };
            [angle(pose.e3, moved.e3), angle(pose.e4, moved.e4)]
        };
        let h = 2e-3;
        let points: Vec<[f64; 2]> = (-3..=3).map(|i| angles_at(f64::from(i) * h)).collect();
        let curvature = passive_bias(lengths, &pose, &rates);
        let link_rates = absolute_rates(&rates, v);
        for i in 0..2 {
            let f = |k: usize| points[k][i];
            let first = (45.0 * (f(4) - f(2)) - 9.0 * (f(5) - f(1)) + (f(6) - f(0))) / (60.0 * h);
            let second =
                (270.0 * (f(4) + f(2)) - 27.0 * (f(5) + f(1)) + 2.0 * (f(6) + f(0)) - 490.0 * f(3)) / (180.0 * h * h);
            let curvature_row = if i == 0 { curvature.b3 } else { curvature.b4 };
            let expected: f64 = curvature_row.iter().zip(link_rates).map(|(b, w)| b * w * w).sum();
            max_errors[0] = max_errors[0].max((link_rates[2 + i] - first).abs() / (1.0 + first.abs()));
            max_errors[1] = max_errors[1].max((expected - second).abs() / (1.0 + second.abs()));
        }
    }
    println!("differences: rates, accelerations {max_errors:?}");
    assert!(max_errors[0] < 1e-9 && max_errors[1] < 1e-7, "{max_errors:?}");
}

/// M and c of thesis (2.19)–(2.22) with the closure (2.23), in relative angles and term by term. With
/// `inertia_in_bracket` the inertias are inside the bracket, as printed; `centrifugal_factor` multiplies the
/// centrifugal terms.
fn thesis_form(case: &Case, inertia_in_bracket: bool, centrifugal_factor: f64) -> ([[f64; 2]; 2], [f64; 2]) {
    let (lengths, bodies) = (&case.finger.lengths, &case.finger.bodies);
    let theta = angles(lengths, case.gamma, case.q).expect("in reach");
    let pose = directions(lengths, case.gamma, case.q);
    let rates = passive_rates(lengths, &pose);
    let curvature = passive_bias(lengths, &pose, &rates);
    let squares = absolute_rates(&rates, case.v).map(|r| r * r);
    let sum = |b: [f64; 4]| -> f64 { b.iter().zip(squares).map(|(b, s)| b * s).sum() };
    // q̇_d = J_da q̇_a and J_td⁻¹ d_c, for (q12, q22).
    let j_da = [[rates.a3[0] - 1.0, rates.a3[1]], [rates.a4[0], rates.a4[1] - 1.0]];
    let bias_terms = [sum(curvature.b3), sum(curvature.b4)];
    let trees = [
        (lengths.l11_m, &bodies.l11, &bodies.l12, theta[0], theta[2], case.v[0]),
        (lengths.l21_m, &bodies.l21, &bodies.l22, theta[1], theta[3], case.v[1]),
    ];
    let (mut mass, mut c) = ([[0.0; 2]; 2], [0.0; 2]);
    for (i, (l, first, second, angle1, angle2, rate1)) in trees.into_iter().enumerate() {
        let rate2 = j_da[i][0] * case.v[0] + j_da[i][1] * case.v[1];
        let (sin, cos) = (angle2 - angle1).sin_cos();
        let ([a1, b1], [a2, b2]) = (first.com_m, second.com_m);
        let (m1, m2, i1, i2) = (first.mass_kg, second.mass_kg, first.inertia_kg_m2, second.inertia_kg_m2);
        let (d1, d2) = (a1 * a1 + b1 * b1, a2 * a2 + b2 * b2);
        let x = l * (a2 * cos - b2 * sin);
        let h = m2 * l * (a2 * sin + b2 * cos);
        let weight = if inertia_in_bracket { m2 } else { 1.0 };
        let m11 = m1 * d1 + m2 * (l * l + d2 + 2.0 * x) + weight * (i1 + i2);
        let m12 = m2 * (d2 + x) + weight * i2;
        let m22 = m2 * d2 + i2;
        let potential = |u: [f64; 2]| u[1] * case.gravity[0] - u[0] * case.gravity[1];
        let rotated = |angle: f64, [x, y]: [f64; 2]| {
            let (s, c) = angle.sin_cos();
            [c * x - s * y, s * x + c * y]
        };
        let g2 = potential(rotated(angle2, [m2 * a2, m2 * b2]));
        let g1 = potential(rotated(angle1, [m1 * a1 + m2 * l, m1 * b1])) + g2;
        let ct = [
            -2.0 * h * rate1 * rate2 - centrifugal_factor * h * rate2 * rate2 + g1 + m12 * bias_terms[i],
            centrifugal_factor * h * rate1 * rate1 + g2 + m22 * bias_terms[i],
        ];
        // Columns of S [I; J_da] for this tree: (q_i1, q_i2) by (q11, q21).
        let unit_row = [if i == 0 { 1.0 } else { 0.0 }, if i == 1 { 1.0 } else { 0.0 }];
        for r in 0..2 {
            for s in 0..2 {
                mass[r][s] += unit_row[r] * (m11 * unit_row[s] + m12 * j_da[i][s])
                    + j_da[i][r] * (m12 * unit_row[s] + m22 * j_da[i][s]);
            }
            c[r] += unit_row[r] * ct[0] + j_da[i][r] * ct[1];
        }
    }
    (mass, c)
}

/// Relative differences of M and c between Newton–Euler and the form of the thesis.
fn thesis_differences(case: &Case, inertia_in_bracket: bool, centrifugal_factor: f64) -> [f64; 2] {
    let expected = newton_euler(&case.finger, case.gamma, case.gravity, case.q, case.v).expect("in reach");
    let (mass, c) = thesis_form(case, inertia_in_bracket, centrifugal_factor);
    let size = expected.mass.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs()));
    let entry_error = |i: usize, j: usize| (mass[i][j] - expected.mass[i][j]).abs() / size;
    [
        entry_error(0, 0).max(entry_error(0, 1)).max(entry_error(1, 0)).max(entry_error(1, 1)),
        (c[0] - expected.bias[0]).abs().max((c[1] - expected.bias[1]).abs()) / expected.bias_scale,
    ]
}

fn quantiles(cases: &[Case], inertia_in_bracket: bool, centrifugal_factor: f64, quantity: usize) -> [f64; 3] {
    let mut sorted: Vec<f64> =
        cases.iter().map(|case| thesis_differences(case, inertia_in_bracket, centrifugal_factor)[quantity]).collect();
    sorted.sort_by(f64::total_cmp);
    [sorted[sorted.len() / 10], sorted[sorted.len() / 2], sorted[sorted.len() - 1]]
}

/// Errata 1: (2.19) is printed with I_i1 + I_i2 inside the bracket that m_i2 multiplies, which makes the mass matrix
/// wrong.
#[test]
fn errata_01_inertias_are_outside_the_bracket() {
    for cases in [random_cases(1000), closing_cases()] {
        let corrected = quantiles(&cases, false, 1.0, 0);
        let printed = quantiles(&cases, true, 1.0, 0);
        println!("errata 1: corrected {corrected:?}, printed {printed:?}");
        assert!(corrected[2] < 1e-12, "{corrected:?}");
        assert!(printed[0] > 1e-2, "{printed:?}");
    }
}

/// Errata 2: the factor 2 of (2.21) applies only to the Coriolis vector (2.20).
#[test]
fn errata_02_centrifugal_terms_have_no_factor_two() {
    let fast_cases = |mut cases: Vec<Case>| {
        cases.retain(|c| c.v[0].abs() + c.v[1].abs() > 50.0);
        cases
    };
    for cases in [random_cases(1000), fast_cases(closing_cases())] {
        let corrected = quantiles(&cases, false, 1.0, 1);
        let printed = quantiles(&cases, false, 2.0, 1);
        println!("errata 2: corrected {corrected:?}, printed {printed:?} of {}", cases.len());
        assert!(corrected[2] < 1e-12, "{corrected:?}");
        assert!(printed[0] > 1e-2, "{printed:?}");
    }
}
