//! The Jacobian of the analytic model against Richardson-extrapolated central differences of its right-hand side, on
//! every branch of every law.

use crate::support::runs::experiment_95;
use phalanx::analytic::{ContactState, FingerMode, Model, QUADRATURES};
use phalanx::gripper::{self, FingerContact};
use phalanx::integrator::{Rates, System};
use phalanx::law::unclamped_normal_force;
use phalanx::scene::{Actuation, Interpolation, Placement, Scene, Spring, SpringKind};

use ContactState::{Active, Clamped, Free, Released};

type Outputs = [f64; 2 + QUADRATURES];

/// A state at which the Jacobian is compared.
struct Case {
    name: &'static str,
    scene: Scene,
    mode: FingerMode,
    t: f64,
    q: [f64; 2],
    v: [f64; 2],
    /// Largest difference steps in t, q and v; small enough to stay on one branch of each law.
    steps: [f64; 3],
}

fn outputs(rates: &Rates<2, QUADRATURES>) -> Outputs {
    std::array::from_fn(|i| if i < 2 { rates.a[i] } else { rates.g[i - 2] })
}

/// f′(0) from central differences with steps h, h/2, h/4 and h/8, extrapolated to order 8.
fn extrapolated_derivative(f: impl Fn(f64) -> Outputs, h: f64) -> Outputs {
    let central = |h: f64| -> Outputs {
        let (up, down) = (f(h), f(-h));
        std::array::from_fn(|i| (up[i] - down[i]) / (2.0 * h))
    };
    let mut row: Vec<Outputs> = (0..4).map(|k| central(h / f64::from(1 << k))).collect();
    for order in 1..4 {
        let factor = f64::from(1 << (2 * order));
        row = row
            .windows(2)
            .map(|pair| std::array::from_fn(|i| (factor * pair[1][i] - pair[0][i]) / (factor - 1.0)))
            .collect();
    }
    row[0]
}

/// Largest difference of the Jacobian, relative to the largest entry of the same output in the same block.
fn max_error(case: &Case) -> f64 {
    let model = Model::new(&case.scene.system);
    let f = |t: f64, q: [f64; 2], v: [f64; 2]| outputs(&model.rates(t, &q, &v, &case.mode));
    let exact = model.linearise(case.t, &case.q, &case.v, &case.mode);

    let (rates, direct_rates) = (outputs(&exact.rates), f(case.t, case.q, case.v));
    for i in 0..rates.len() {
        let scale = if i < 2 { direct_rates[0].abs().max(direct_rates[1].abs()) } else { direct_rates[i].abs() };
        assert!((rates[i] - direct_rates[i]).abs() <= 1e-14 * scale, "{}: rates {rates:?} {direct_rates:?}", case.name);
    }

    let shifted = |x: [f64; 2], k: usize, s: f64| std::array::from_fn(|i| if i == k { x[i] + s } else { x[i] });
    let by_t = extrapolated_derivative(|s| f(case.t + s, case.q, case.v), case.steps[0]);
    let by_q = [0, 1].map(|k| extrapolated_derivative(|s| f(case.t, shifted(case.q, k, s), case.v), case.steps[1]));
    let by_v = [0, 1].map(|k| extrapolated_derivative(|s| f(case.t, case.q, shifted(case.v, k, s)), case.steps[2]));
    let mut max_error = 0.0f64;
    for i in 0..rates.len() {
        let (e_t, e_q, e_v) = if i < 2 {
            (exact.a_t[i], exact.a_q[i], exact.a_v[i])
        } else {
            (exact.g_t[i - 2], exact.g_q[i - 2], exact.g_v[i - 2])
        };
        // The scale of an output that does not depend on a variable is the output divided by the step in that variable.
        let noise = |h: f64| 1e-7 * direct_rates[i].abs() / h + 1e-9;
        let relative_error = |actual: [f64; 2], expected: [f64; 2], noise: f64| {
            let size = expected[0].abs().max(expected[1].abs()) + noise;
            (actual[0] - expected[0]).abs().max((actual[1] - expected[1]).abs()) / size
        };
        let errors = [
            relative_error([e_t, 0.0], [by_t[i], 0.0], noise(case.steps[0])),
            relative_error(e_q, [by_q[0][i], by_q[1][i]], noise(case.steps[1])),
            relative_error(e_v, [by_v[0][i], by_v[1][i]], noise(case.steps[2])),
        ];
        max_error = errors.into_iter().fold(max_error, f64::max);
        assert!(errors.iter().all(|p| *p < 1e-6), "{}: output {i}: t, q, v {errors:?}", case.name);
    }
    max_error
}

/// Finds q near `start` at which both phalanges penetrate by the given depths, by Newton's method on the gaps.
pub fn penetrating_posture(model: &Model, start: [f64; 2], depth: [f64; 2]) -> [f64; 2] {
    let mut q = start;
    for _ in 0..30 {
        let reading = |contact| model.contact_reading(q, [0.0; 2], contact, Active).expect("an object");
        let (p, d) = (reading(FingerContact::Proximal), reading(FingerContact::Distal));
        let residual = [-p.delta + depth[0], -d.delta + depth[1]];
        let (a, b) = (p.geometry.normal_row, d.geometry.normal_row);
        let determinant = a[0] * b[1] - a[1] * b[0];
        q[0] -= (residual[0] * b[1] - residual[1] * a[1]) / determinant;
        q[1] -= (a[0] * residual[1] - b[0] * residual[0]) / determinant;
    }
    q
}

/// Solves for the q̇_a at which two rows (linear forms of q̇_a) have the given values.
pub fn rates_with_row_values(rows: [[f64; 2]; 2], values: [f64; 2]) -> [f64; 2] {
    let [a, b] = rows;
    let determinant = a[0] * b[1] - a[1] * b[0];
    [(values[0] * b[1] - values[1] * a[1]) / determinant, (a[0] * values[1] - b[0] * values[0]) / determinant]
}

/// Final posture of experiment 95, near which both phalanges are in contact.
const GRASP_POSTURE: [f64; 2] = [0.036456, 1.134813];
const SWING_POSTURE: [f64; 2] = [-0.5, 1.2];
const FREE_STEPS: [f64; 3] = [1e-4, 2e-3, 0.5];
const CONTACT_STEPS: [f64; 3] = [1e-4, 4e-6, 0.01];

fn free_swing(name: &'static str, scene: Scene) -> Case {
    Case { name, scene, mode: [Free; 3].into(), t: 1e-3, q: [-0.45, 0.9], v: [120.0, 60.0], steps: FREE_STEPS }
}

/// Checks a family of cases and prints the largest difference.
fn check_cases(family: &str, cases: &[Case]) {
    let max_error = cases.iter().map(max_error).fold(0.0f64, f64::max);
    println!("{family}: {} cases, largest relative difference {max_error:e}", cases.len());
}

#[test]
fn free_swing_with_every_kind_and_placement_of_the_spring() {
    let mut cases = Vec::new();
    for placement in [Placement::GroundLinks, Placement::DrivenCoupler, Placement::Phalanges, Placement::CouplerDistal]
    {
        for kind in [
            SpringKind::Constant { torque_n_m: 0.1326 },
            SpringKind::Torsional { stiffness_n_m_per_rad: 0.06, preload_rad: 1.9 },
        ] {
            let mut scene = experiment_95();
            scene.finger_mut().spring = Some(Spring { kind, placement });
            cases.push(free_swing("spring", scene.clone()));
            scene.system.discs.clear();
            cases.push(Case { v: [-700.0, 300.0], ..free_swing("fast, no object", scene) });
        }
    }
    let mut without_spring_and_limit = experiment_95();
    (
        without_spring_and_limit.finger_mut().spring,
        without_spring_and_limit.finger_mut().limit,
        without_spring_and_limit.system.gravity_m_s2,
    ) = (None, None, [3.0, -4.0]);
    cases.push(free_swing("no spring, no limit, other gravity", without_spring_and_limit));
    check_cases("springs", &cases);
}

#[test]
fn joint_limit_in_all_contact_states() {
    let mut cases = Vec::new();
    let scene = experiment_95();
    let model = Model::new(&scene.system);
    for (name, delta, rate) in
        [("creeping", 3e-7, 1e-3), ("engaging", 4e-6, 0.2), ("beyond", 3e-5, -0.1), ("returning", 6e-6, -0.02)]
    {
        // Newton's method on q11 from the straight configuration finds the penetration δ of the limit.
        let mut q = [SWING_POSTURE[1] - std::f64::consts::FRAC_PI_2, SWING_POSTURE[1]];
        for _ in 0..20 {
            let limit = model.contact_reading(q, [0.0; 2], FingerContact::Limit, Active).expect("a limit");
            q[0] -= (delta - limit.delta) / limit.geometry.normal_row[0];
        }
        let limit = model.contact_reading(q, [0.0; 2], FingerContact::Limit, Active).expect("a limit");
        assert!((limit.delta - delta).abs() < 1e-14, "{:e}", limit.delta);
        let v = rates_with_row_values([limit.geometry.normal_row, [0.0, 1.0]], [-rate, 80.0]);
        for state in [Active, Clamped, Released] {
            let steps = [1e-4, 0.05 * delta, 0.1 * f64::abs(rate)];
            cases.push(Case { name, scene: scene.clone(), mode: [Free, Free, state].into(), t: 0.0, q, v, steps });
        }
    }
    check_cases("limit", &cases);
}

/// Whether a difference step in the rates could cross the kink at which the clamp sets in.
fn is_near_clamp_limit(model: &Model, q: [f64; 2], v: [f64; 2], contact: FingerContact) -> bool {
    let reading = model.contact_reading(q, v, contact, Active).expect("an object");
    let law = experiment_95().finger().contact.proximal.normal;
    let force = unclamped_normal_force(&law, reading.delta, reading.delta_rate);
    let [a, b] = reading.geometry.normal_row;
    force.force.abs() < 2.0 * force.d_rate * (a.abs() + b.abs()) * CONTACT_STEPS[2]
}

#[test]
fn one_and_two_contacts_on_all_friction_branches() {
    let mut cases = Vec::new();
    let mut clamped_cases = 0;
    let scene = experiment_95();
    let model = Model::new(&scene.system);
    for depth in [[2e-6, 3e-6], [8e-6, 6e-6], [1.5e-5, 3e-5]] {
        let q = penetrating_posture(&model, GRASP_POSTURE, depth);
        let rows = |contact| {
            let reading = model.contact_reading(q, [0.0; 2], contact, Active).expect("an object");
            assert!(reading.delta > 1e-6, "{}", reading.delta);
            (reading.geometry.normal_row, reading.geometry.tangent_row)
        };
        let ((normal_p, slip_p), (normal_d, slip_d)) = (rows(FingerContact::Proximal), rows(FingerContact::Distal));
        // Slip speeds on each branch: |v| < v_s = 0.1 m/s, v_s to v_d = 0.2 m/s, and beyond; both signs; at rest.
        for slip in [0.0, 0.03, -0.06, 0.13, -0.17, 0.3, -2.0] {
            let both_slipping = rates_with_row_values([slip_p, slip_d], [slip, -0.8 * slip]);
            let creeping = rates_with_row_values([slip_d, normal_d], [slip, -2e-3]);
            let impacting = rates_with_row_values([normal_p, slip_d], [-1.5, slip]);
            for (name, v) in [("slip of both", both_slipping), ("tip in creep", creeping), ("in an impact", impacting)]
            {
                for states in
                    [[Active, Active, Free], [Active, Free, Free], [Free, Active, Free], [Clamped, Clamped, Free]]
                {
                    let mode = FingerMode::from(states);
                    if mode[0] == Clamped
                        && FingerContact::ALL[..2].iter().any(|s| is_near_clamp_limit(&model, q, v, *s))
                    {
                        continue;
                    }
                    clamped_cases += usize::from(mode[0] == Clamped);
                    cases.push(Case { name, scene: scene.clone(), mode, t: 0.0, q, v, steps: CONTACT_STEPS });
                }
            }
        }
    }
    assert!(clamped_cases >= 30, "only {clamped_cases} cases on clamped branches");
    let mut frictionless = experiment_95();
    frictionless.finger_mut().contact.proximal.friction = None;
    frictionless.finger_mut().contact.distal.friction = None;
    let q = penetrating_posture(&model, GRASP_POSTURE, [5e-6, 4e-6]);
    let mode = FingerMode::from([Active; 3]);
    cases.push(Case {
        name: "frictionless",
        scene: frictionless,
        mode,
        t: 0.0,
        q,
        v: [3.0, -1.0],
        steps: CONTACT_STEPS,
    });
    check_cases("contacts", &cases);
}

#[test]
fn contact_at_the_end_of_the_distal_phalanx() {
    let mut cases = Vec::new();
    let mut scene = experiment_95();
    // A disc at the end of the distal phalanx, where the normal turns with the motion.
    let model = Model::new(&scene.system);
    let reading = model.contact_reading(GRASP_POSTURE, [0.0; 2], FingerContact::Distal, Active).expect("an object");
    let face = reading.geometry.tangent_row;
    let (lengths, [q11, q21]) = (&scene.finger().linkage.lengths, GRASP_POSTURE);
    let posture =
        gripper::close_loop(lengths, scene.finger().linkage.assembly, q11, q21).expect("the grasp closes the loop");
    let tip = gripper::joint_positions(lengths, &posture).tip_m;
    let reach = scene.finger().linkage.lengths.half_width_m + 20e-3 - 4e-6;
    let inward_normal = reading.geometry.normal.map(|n| -n);
    let rotated_normal =
        [inward_normal[0] * 0.8 + inward_normal[1] * 0.6, inward_normal[1] * 0.8 - inward_normal[0] * 0.6];
    for direction in [
        rotated_normal,
        [rotated_normal[0] * 0.6 + rotated_normal[1] * 0.8, rotated_normal[1] * 0.6 - rotated_normal[0] * 0.8],
    ] {
        scene.system.grasped_mut().centre_m = [tip[0] + reach * direction[0], tip[1] + reach * direction[1]];
        let model = Model::new(&scene.system);
        let end_contact =
            model.contact_reading(GRASP_POSTURE, [0.0; 2], FingerContact::Distal, Active).expect("an object");
        assert!((end_contact.delta - 4e-6).abs() < 1e-12, "{:e}", end_contact.delta);
        assert!((end_contact.geometry.tangent_row[0] - face[0]).abs() > 1e-5);
        for v in [[2.0, 1.0], [-30.0, 5.0], [0.1, -0.1]] {
            let mode = FingerMode::from([Free, Active, Free]);
            cases.push(Case {
                name: "end",
                scene: scene.clone(),
                mode,
                t: 0.0,
                q: GRASP_POSTURE,
                v,
                steps: CONTACT_STEPS,
            });
        }
    }
    check_cases("end of the tip", &cases);
}

#[test]
fn time_dependent_torque_profiles() {
    let table = |interpolation| Actuation::Table { points: vec![(0.0, 0.1), (2e-3, 0.5), (9e-3, -0.2)], interpolation };
    let profiles = [
        Actuation::Constant { torque_n_m: 0.48 },
        table(Interpolation::Linear),
        table(Interpolation::Step),
        Actuation::Ramp { torque_n_m: 0.48, rise_s: 5e-3 },
        Actuation::HalfSine { torque_n_m: 0.48, length_s: 5e-3 },
        Actuation::Reversal { torque_n_m: 0.48, at_s: 4e-3 },
    ];
    let mut cases = Vec::new();
    for profile in profiles {
        for t in [1e-3, 3e-3, 8e-3] {
            let mut scene = experiment_95();
            scene.finger_mut().motor.actuation = profile.clone();
            cases.push(Case { t, ..free_swing("profile", scene) });
        }
    }
    // The derivative by time is not zero.
    let ramp_jacobian =
        Model::new(&cases[3].scene.system).linearise(1e-3, &cases[3].q, &cases[3].v, &FingerMode::from([Free; 3]));
    assert!(
        ramp_jacobian.a_t[0].abs() > 1e5 && (ramp_jacobian.g_t[4] - 200.0 * 120.0).abs() < 1e-9,
        "{ramp_jacobian:?}"
    );
    check_cases("profiles", &cases);
}
