//! The equations of motion against an independent formulation: Newton–Euler equations of four free bodies (x, y, θ
//! each) with the ten constraint equations of five revolute joints.
//!
//! With constraints Φ(r) = 0 and G = ∂Φ/∂r, every motion is ṙ = N q̇_a, where the columns of N span the null space of G
//! (found here by elimination in another library, with one column for each ground link), and r̈ = N q̈_a + b, where G b =
//! −Ġ ṙ. Projected on N, Newton–Euler gives M = Nᵀ 𝓜 N and c = Nᵀ (𝓜 b − F). It uses no Lagrangian, no cut loop and no
//! relative angles.

// Loops over matrix indices follow the formulas.
#![allow(clippy::needless_range_loop)]

use crate::support::runs::{Random, assert_below, experiment_95, run_to_end, with_reference_settings};
use nalgebra::{SMatrix, SVector, Vector2};
use phalanx::fivebar::dynamics::{Dynamics, absolute_rates, bias, inverse_dynamics, solve_mass, terms};
use phalanx::fivebar::kinematics::{
    Directions, PassiveBias, PassiveRates, directions, passive_bias, passive_rates, reference_gamma,
};
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

fn newton_euler(&Case { ref finger, gamma, gravity, q, v }: &Case) -> ProjectedDynamics {
    let lengths = &finger.lengths;
    let theta = angles(lengths, gamma, q).expect("in reach");
    let bodies: [&Body; BODIES] = [&finger.bodies.l11, &finger.bodies.l21, &finger.bodies.l12, &finger.bodies.l22];
    // Both ends of every revolute joint: joint, sign, body, and arm from its centre of mass to the joint. The first two
    // joints are on the ground, at the origin.
    let root = |joint: usize, i: usize| (joint, 1.0, i, bodies[i].com_m.map(|x| -x));
    let end = |joint: usize, sign: f64, i: usize, length: f64| {
        let [x, y] = bodies[i].com_m;
        (joint, sign, i, [length - x, -y])
    };
    let joint_ends = [
        root(0, 0),
        root(1, 1),
        root(2, 2),
        end(2, -1.0, 0, lengths.l11_m),
        root(3, 3),
        end(3, -1.0, 1, lengths.l21_m),
        end(4, 1.0, 2, lengths.l12_m),
        end(4, -1.0, 3, lengths.l22_m),
    ]
    .map(|(joint, sign, i, [x, y])| {
        let (s, c) = theta[i].sin_cos();
        (joint, sign, i, [c * x - s * y, s * x + c * y])
    });
    let mut g = SMatrix::<f64, CONSTRAINTS, COORDINATES>::zeros();
    for (k, sign, i, arm) in joint_ends {
        g[(2 * k, 3 * i)] = sign;
        g[(2 * k + 1, 3 * i + 1)] = sign;
        g[(2 * k, 3 * i + 2)] = -sign * arm[1];
        g[(2 * k + 1, 3 * i + 2)] = sign * arm[0];
    }
    // Independent coordinates: the angles of bodies 0 and 1.
    let dependent: Vec<usize> = (0..COORDINATES).filter(|i| ![2, 5].contains(i)).collect();
    let square = SMatrix::<f64, CONSTRAINTS, CONSTRAINTS>::from_fn(|row, j| g[(row, dependent[j])]).full_piv_lu();
    let right = SMatrix::<f64, CONSTRAINTS, 2>::from_fn(|row, j| -g[(row, [2, 5][j])]);
    let null = square.solve(&right).expect("independent joints");
    let mut n = SMatrix::<f64, COORDINATES, 2>::zeros();
    (n[(2, 0)], n[(5, 1)]) = (1.0, 1.0);
    dependent.iter().enumerate().for_each(|(row, i)| n.set_row(*i, &null.row(row)));

    let rates = n * Vector2::from(v);
    // −Ġ ṙ: a point at `arm` from the centre of mass has the centripetal acceleration −ω² arm.
    let mut centripetal = SVector::<f64, CONSTRAINTS>::zeros();
    for (k, sign, i, arm) in joint_ends {
        (0..2).for_each(|axis| centripetal[2 * k + axis] += sign * rates[3 * i + 2].powi(2) * arm[axis]);
    }
    let particular = square.solve(&centripetal).expect("independent joints");
    let mut b = SVector::<f64, COORDINATES>::zeros();
    dependent.iter().enumerate().for_each(|(row, i)| b[*i] = particular[row]);

    let inertia = SVector::<f64, COORDINATES>::from_fn(|i, _| {
        if i % 3 == 2 { bodies[i / 3].inertia_kg_m2 } else { bodies[i / 3].mass_kg }
    });
    let force = SVector::<f64, COORDINATES>::from_fn(|i, _| if i % 3 == 2 { 0.0 } else { inertia[i] * gravity[i % 3] });
    let mass = n.transpose() * SMatrix::<f64, COORDINATES, COORDINATES>::from_diagonal(&inertia) * n;
    let scale = n.abs().transpose() * (inertia.component_mul(&b.abs()) + force.abs());
    ProjectedDynamics {
        mass: [[mass[(0, 0)], mass[(0, 1)]], [mass[(1, 0)], mass[(1, 1)]]],
        bias: (n.transpose() * (inertia.component_mul(&b) - force)).into(),
        bias_scale: scale.sum(),
        passive_bias: [b[8], b[11]],
        passive_rates: [[n[(8, 0)], n[(8, 1)]], [n[(11, 0)], n[(11, 1)]]],
    }
}

/// A finger and a state at which the formulations are compared.
struct Case {
    finger: Finger,
    gamma: f64,
    gravity: [f64; 2],
    q: [f64; 2],
    v: [f64; 2],
}

impl Case {
    fn dynamics(&self) -> Dynamics {
        Dynamics::new(&self.finger, self.gamma, self.gravity)
    }

    fn pose(&self) -> Directions<f64> {
        directions(&self.finger.lengths, self.gamma, self.q)
    }

    /// Rates and accelerations of the passive links, and the rates of all links.
    fn kinematics(&self) -> (PassiveRates<f64>, PassiveBias<f64>, [f64; 4]) {
        let (lengths, pose) = (&self.finger.lengths, self.pose());
        let rates = passive_rates(lengths, &pose);
        let link_rates = absolute_rates(&rates, self.v);
        let bias = passive_bias(lengths, &pose, &rates);
        (rates, bias, link_rates)
    }
}

/// Largest magnitude of the entries of a matrix.
fn largest(matrix: &[[f64; 2]; 2]) -> f64 {
    matrix.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs()))
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
    let scene = with_reference_settings(&experiment_95());
    let (finger, gravity) = (scene.finger().linkage, scene.hand.gravity_m_s2);
    let reference = reference_gamma(&finger.lengths);
    let gamma = if finger.assembly == Assembly::Reference { reference } else { -reference };
    let samples = run_to_end(&scene).1.samples.into_iter();
    let cases: Vec<Case> = samples
        .map(|sample| sample.finger(0))
        .map(|f| Case { finger, gamma, gravity, q: [f.q11_rad, f.q21_rad], v: [f.qd11_rad_s, f.qd21_rad_s] })
        .collect();
    assert!(cases.len() > 500, "{}", cases.len());
    cases
}

/// Compares M, c, and the torques at random accelerations.
#[test]
fn random_fingers_and_the_closing_of_design_95_agree_with_newton_euler() {
    let mut random = Random(11);
    for case in random_cases(4000).iter().chain(&closing_cases()) {
        let (expected, dynamics) = (newton_euler(case), case.dynamics());
        let actual = terms(&dynamics, case.pose());
        let c = bias(&actual, absolute_rates(&actual.rates, case.v));
        let [m11, m12, m22] = actual.mass;
        let mass = [[m11, m12], [m12, m22]];
        let size = largest(&expected.mass);
        let acceleration = [random.within(-1e5, 1e5), random.within(-1e5, 1e5)];
        let torque = inverse_dynamics(&dynamics, case.q, case.v, acceleration);
        let recovered = solve_mass(&actual.mass, [torque[0] - c[0], torque[1] - c[1]]);
        for i in 0..2 {
            for j in 0..2 {
                assert_below((mass[i][j] - expected.mass[i][j]).abs() / size, 1e-12, "mass");
            }
            assert_below((c[i] - expected.bias[i]).abs() / expected.bias_scale, 1e-12, "bias");
            let expected_torque =
                expected.mass[i][0] * acceleration[0] + expected.mass[i][1] * acceleration[1] + expected.bias[i];
            let scale = size * acceleration[0].abs().max(acceleration[1].abs()) + expected.bias_scale;
            assert_below((torque[i] - expected_torque).abs() / scale, 1e-12, "torque");
            let condition = size * size / (m11 * m22 - m12 * m12);
            let error = (recovered[i] - acceleration[i]).abs() / (acceleration[0].abs() + acceleration[1].abs());
            assert_below(error, 1e-13 * (1.0 + condition) * (1.0 + expected.bias_scale / scale), "acceleration");
        }
    }
}

#[test]
fn passive_rates_and_accelerations_agree_with_the_null_space() {
    for case in random_cases(4000).iter().chain(&closing_cases()) {
        let expected = newton_euler(case);
        let (rates, curvature, link_rates) = case.kinematics();
        for (i, (row, curvature_row)) in [(rates.a3, curvature.b3), (rates.a4, curvature.b4)].into_iter().enumerate() {
            let size = largest(&expected.passive_rates).max(1.0);
            for j in 0..2 {
                assert_below((row[j] - expected.passive_rates[i][j]).abs() / size, 1e-12, "rates");
            }
            let terms = curvature_row.iter().zip(link_rates).map(|(b, rate)| b * rate * rate);
            let scale: f64 = terms.clone().map(f64::abs).sum::<f64>() + 1e-300;
            assert_below((terms.sum::<f64>() - expected.passive_bias[i]).abs() / scale, 1e-12, "accelerations");
        }
    }
}

/// Compares rates and accelerations with central differences of sixth order of θ3(s) and θ4(s) along q(s) = q + s v,
/// where v is scaled so that the fastest link turns by 1 rad per unit of s.
#[test]
fn second_order_kinematics_agree_with_differences_of_the_geometry() {
    for case in random_cases(300) {
        let (lengths, pose) = (&case.finger.lengths, case.pose());
        let (rates, curvature, link_rates) = case.kinematics();
        let fastest = link_rates.into_iter().fold(0.0f64, |a, b| a.max(b.abs()));
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
        let link_rates = absolute_rates(&rates, v);
        for i in 0..2 {
            let f = |k: usize| points[k][i];
            let first = (45.0 * (f(4) - f(2)) - 9.0 * (f(5) - f(1)) + (f(6) - f(0))) / (60.0 * h);
            let second =
                (270.0 * (f(4) + f(2)) - 27.0 * (f(5) + f(1)) + 2.0 * (f(6) + f(0)) - 490.0 * f(3)) / (180.0 * h * h);
            let curvature_row = if i == 0 { curvature.b3 } else { curvature.b4 };
            let expected: f64 = curvature_row.iter().zip(link_rates).map(|(b, w)| b * w * w).sum();
            assert_below((link_rates[2 + i] - first).abs() / (1.0 + first.abs()), 1e-9, "rates");
            assert_below((expected - second).abs() / (1.0 + second.abs()), 1e-7, "accelerations");
        }
    }
}

/// M and c of thesis (2.19)–(2.22) with the closure (2.23), in relative angles and term by term. With
/// `inertia_in_bracket` the inertias are inside the bracket, as printed; `centrifugal_factor` multiplies the
/// centrifugal terms.
fn thesis_form(case: &Case, inertia_in_bracket: bool, centrifugal_factor: f64) -> ([[f64; 2]; 2], [f64; 2]) {
    let (lengths, bodies) = (&case.finger.lengths, &case.finger.bodies);
    let theta = angles(lengths, case.gamma, case.q).expect("in reach");
    let (rates, curvature, link_rates) = case.kinematics();
    let sum = |b: [f64; 4]| -> f64 { b.iter().zip(link_rates).map(|(b, rate)| b * rate * rate).sum() };
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
    let expected = newton_euler(case);
    let (mass, c) = thesis_form(case, inertia_in_bracket, centrifugal_factor);
    let mass_error = [0, 1].map(|i| [0, 1].map(|j| mass[i][j] - expected.mass[i][j]));
    let bias_error = (c[0] - expected.bias[0]).abs().max((c[1] - expected.bias[1]).abs());
    [largest(&mass_error) / largest(&expected.mass), bias_error / expected.bias_scale]
}

/// Asserts that the corrected form agrees with Newton–Euler in every case, and that the printed form differs by more than
/// 1 % in nine of ten.
#[track_caller]
fn assert_printed_form_is_wrong(cases: &[Case], quantity: usize, inertia_in_bracket: bool, centrifugal_factor: f64) {
    for case in cases {
        assert_below(thesis_differences(case, false, 1.0)[quantity], 1e-12, "corrected form");
    }
    let differs = |case: &&Case| thesis_differences(case, inertia_in_bracket, centrifugal_factor)[quantity] > 1e-2;
    let differing = cases.iter().filter(differs).count();
    assert!(differing >= cases.len() - cases.len() / 10, "{differing} of {}", cases.len());
}

/// Errata 1: (2.19) is printed with I_i1 + I_i2 inside the bracket that m_i2 multiplies, which makes the mass matrix
/// wrong.
#[test]
fn errata_01_inertias_are_outside_the_bracket() {
    for cases in [random_cases(1000), closing_cases()] {
        assert_printed_form_is_wrong(&cases, 0, true, 1.0);
    }
}

/// Errata 2: the factor 2 of (2.21) applies only to the Coriolis vector (2.20).
#[test]
fn errata_02_centrifugal_terms_have_no_factor_two() {
    let mut fast_closing_cases = closing_cases();
    fast_closing_cases.retain(|case| case.v[0].abs() + case.v[1].abs() > 50.0);
    for cases in [random_cases(1000), fast_closing_cases] {
        assert_printed_form_is_wrong(&cases, 1, false, 2.0);
    }
}
