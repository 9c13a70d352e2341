//! The exact Jacobian of the analytic model against Richardson-extrapolated central differences of its right-hand side, on
//! every branch of every law.

use crate::support::runs::anchor;
use phalanx::analytic::{FingerMode, Model, QUADRATURES, SiteState};
use phalanx::gripper::{self, Site};
use phalanx::integrator::{Rates, System};
use phalanx::law::unclamped_normal_force;
use phalanx::scene::{Actuation, Interpolation, Placement, Scene, Spring, SpringKind};

use SiteState::{Active, Free, Natural, Released};

type Outputs = [f64; 2 + QUADRATURES];

/// A place to differentiate at.
struct Case {
    name: &'static str,
    scene: Scene,
    mode: FingerMode,
    t: f64,
    q: [f64; 2],
    v: [f64; 2],
    /// Largest steps in t, q, v: far inside the branch.
    steps: [f64; 3],
}

fn outputs(rates: &Rates<2, QUADRATURES>) -> Outputs {
    std::array::from_fn(|i| if i < 2 { rates.a[i] } else { rates.g[i - 2] })
}

/// f′(0) from central differences with h, h/2, h/4, h/8, extrapolated to order 8.
fn derivative(f: impl Fn(f64) -> Outputs, h: f64) -> Outputs {
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
fn worst(case: &Case) -> f64 {
    let model = Model::new(&case.scene.system);
    let f = |t: f64, q: [f64; 2], v: [f64; 2]| outputs(&model.rates(t, &q, &v, &case.mode));
    let exact = model.linearise(case.t, &case.q, &case.v, &case.mode);

    let (rates, again) = (outputs(&exact.rates), f(case.t, case.q, case.v));
    for i in 0..rates.len() {
        let scale = if i < 2 { again[0].abs().max(again[1].abs()) } else { again[i].abs() };
        assert!((rates[i] - again[i]).abs() <= 1e-14 * scale, "{}: rates {rates:?} {again:?}", case.name);
    }

    let shifted = |x: [f64; 2], k: usize, s: f64| std::array::from_fn(|i| if i == k { x[i] + s } else { x[i] });
    let by_t = derivative(|s| f(case.t + s, case.q, case.v), case.steps[0]);
    let by_q = [0, 1].map(|k| derivative(|s| f(case.t, shifted(case.q, k, s), case.v), case.steps[1]));
    let by_v = [0, 1].map(|k| derivative(|s| f(case.t, case.q, shifted(case.v, k, s)), case.steps[2]));
    let mut worst = 0.0f64;
    for i in 0..rates.len() {
        let (e_t, e_q, e_v) = if i < 2 {
            (exact.a_t[i], exact.a_q[i], exact.a_v[i])
        } else {
            (exact.g_t[i - 2], exact.g_q[i - 2], exact.g_v[i - 2])
        };
        // Where an output does not depend on a variable at all, its own size over that variable's step is the scale.
        let noise = |h: f64| 1e-7 * again[i].abs() / h + 1e-9;
        let against = |got: [f64; 2], want: [f64; 2], noise: f64| {
            let size = want[0].abs().max(want[1].abs()) + noise;
            (got[0] - want[0]).abs().max((got[1] - want[1]).abs()) / size
        };
        let parts = [
            against([e_t, 0.0], [by_t[i], 0.0], noise(case.steps[0])),
            against(e_q, [by_q[0][i], by_q[1][i]], noise(case.steps[1])),
            against(e_v, [by_v[0][i], by_v[1][i]], noise(case.steps[2])),
        ];
        worst = parts.into_iter().fold(worst, f64::max);
        assert!(parts.iter().all(|p| *p < 1e-6), "{}: output {i}: t, q, v {parts:?}", case.name);
    }
    worst
}

/// q near `start` at which both phalanges penetrate by the given depths, by Newton on the gaps.
pub fn touching(model: &Model, start: [f64; 2], depth: [f64; 2]) -> [f64; 2] {
    let mut q = start;
    for _ in 0..30 {
        let read = |site| model.reading(q, [0.0; 2], site, Active).expect("an object");
        let (p, d) = (read(Site::Proximal), read(Site::Distal));
        let miss = [-p.delta + depth[0], -d.delta + depth[1]];
        let (a, b) = (p.geometry.normal_row, d.geometry.normal_row);
        let determinant = a[0] * b[1] - a[1] * b[0];
        q[0] -= (miss[0] * b[1] - miss[1] * a[1]) / determinant;
        q[1] -= (a[0] * miss[1] - b[0] * miss[0]) / determinant;
    }
    q
}

/// q̇_a with the given values of two of its linear forms.
pub fn rates_with(rows: [[f64; 2]; 2], values: [f64; 2]) -> [f64; 2] {
    let [a, b] = rows;
    let determinant = a[0] * b[1] - a[1] * b[0];
    [(values[0] * b[1] - values[1] * a[1]) / determinant, (a[0] * values[1] - b[0] * values[0]) / determinant]
}

/// The final grasp of the anchor, about where both contacts are.
const GRASP: [f64; 2] = [0.036456, 1.134813];
const SWING: [f64; 2] = [-0.5, 1.2];
const SMOOTH: [f64; 3] = [1e-4, 2e-3, 0.5];
const CONTACT: [f64; 3] = [1e-4, 4e-6, 0.01];

fn swing(name: &'static str, scene: Scene) -> Case {
    Case { name, scene, mode: [Free; 3].into(), t: 1e-3, q: [-0.45, 0.9], v: [120.0, 60.0], steps: SMOOTH }
}

/// Sums up a family of cases: all must hold, and the largest difference is printed.
fn check(family: &str, cases: &[Case]) {
    let worst = cases.iter().map(worst).fold(0.0f64, f64::max);
    println!("{family}: {} cases, largest relative difference {worst:e}", cases.len());
}

#[test]
fn free_swing_in_every_placement_of_every_spring() {
    let mut cases = Vec::new();
    for placement in [Placement::GroundLinks, Placement::DrivenCoupler, Placement::Phalanges, Placement::CouplerDistal]
    {
        for kind in [
            SpringKind::Constant { torque_n_m: 0.1326 },
            SpringKind::Torsional { stiffness_n_m_per_rad: 0.06, preload_rad: 1.9 },
        ] {
            let mut scene = anchor();
            scene.finger_mut().spring = Some(Spring { kind, placement });
            cases.push(swing("spring", scene.clone()));
            scene.system.discs.clear();
            cases.push(Case { v: [-700.0, 300.0], ..swing("fast, no object", scene) });
        }
    }
    let mut bare = anchor();
    (bare.finger_mut().spring, bare.finger_mut().limit, bare.system.gravity_m_s2) = (None, None, [3.0, -4.0]);
    cases.push(swing("no spring, no limit, other gravity", bare));
    check("springs", &cases);
}

#[test]
fn joint_limit_in_its_damper_beyond_it_and_released() {
    let mut cases = Vec::new();
    let scene = anchor();
    let model = Model::new(&scene.system);
    for (name, delta, rate) in
        [("creeping", 3e-7, 1e-3), ("engaging", 4e-6, 0.2), ("beyond", 3e-5, -0.1), ("returning", 6e-6, -0.02)]
    {
        // From the straight line, q22 falls with q11 behind q21: a Newton step or two finds δ.
        let mut q = [SWING[1] - std::f64::consts::FRAC_PI_2, SWING[1]];
        for _ in 0..20 {
            let limit = model.reading(q, [0.0; 2], Site::Limit, Active).expect("a limit");
            q[0] -= (delta - limit.delta) / limit.geometry.normal_row[0];
        }
        let limit = model.reading(q, [0.0; 2], Site::Limit, Active).expect("a limit");
        assert!((limit.delta - delta).abs() < 1e-14, "{:e}", limit.delta);
        let v = rates_with([limit.geometry.normal_row, [0.0, 1.0]], [-rate, 80.0]);
        for state in [Active, Natural, Released] {
            let steps = [1e-4, 0.05 * delta, 0.1 * f64::abs(rate)];
            cases.push(Case { name, scene: scene.clone(), mode: [Free, Free, state].into(), t: 0.0, q, v, steps });
        }
    }
    check("limit", &cases);
}

/// Whether a step in the rates could take the law over the kink of its clamp.
fn near_the_clamp(model: &Model, q: [f64; 2], v: [f64; 2], site: Site) -> bool {
    let reading = model.reading(q, v, site, Active).expect("an object");
    let law = anchor().finger().contact.proximal.normal;
    let force = unclamped_normal_force(&law, reading.delta, reading.delta_rate);
    let [a, b] = reading.geometry.normal_row;
    force.force.abs() < 2.0 * force.d_rate * (a.abs() + b.abs()) * CONTACT[2]
}

#[test]
fn one_and_two_contacts_on_every_branch_of_friction() {
    let mut cases = Vec::new();
    let mut natural = 0;
    let scene = anchor();
    let model = Model::new(&scene.system);
    for depth in [[2e-6, 3e-6], [8e-6, 6e-6], [1.5e-5, 3e-5]] {
        let q = touching(&model, GRASP, depth);
        let rows = |site| {
            let reading = model.reading(q, [0.0; 2], site, Active).expect("an object");
            assert!(reading.delta > 1e-6, "{}", reading.delta);
            (reading.geometry.normal_row, reading.geometry.tangent_row)
        };
        let ((normal_p, slip_p), (normal_d, slip_d)) = (rows(Site::Proximal), rows(Site::Distal));
        // Slip speeds on each of the branches: |v| < v_s = 0.1 m/s, up to v_d = 0.2 m/s, beyond; both signs; at rest.
        for slip in [0.0, 0.03, -0.06, 0.13, -0.17, 0.3, -2.0] {
            let both = rates_with([slip_p, slip_d], [slip, -0.8 * slip]);
            let pressing = rates_with([slip_d, normal_d], [slip, -2e-3]);
            let hitting = rates_with([normal_p, slip_d], [-1.5, slip]);
            for (name, v) in [("slip of both", both), ("tip in creep", pressing), ("in an impact", hitting)] {
                for states in
                    [[Active, Active, Free], [Active, Free, Free], [Free, Active, Free], [Natural, Natural, Free]]
                {
                    let mode = FingerMode::from(states);
                    if mode[0] == Natural && Site::ALL[..2].iter().any(|s| near_the_clamp(&model, q, v, *s)) {
                        continue;
                    }
                    natural += usize::from(mode[0] == Natural);
                    cases.push(Case { name, scene: scene.clone(), mode, t: 0.0, q, v, steps: CONTACT });
                }
            }
        }
    }
    assert!(natural >= 30, "only {natural} cases on natural branches");
    let mut frictionless = anchor();
    frictionless.finger_mut().contact.proximal.friction = None;
    frictionless.finger_mut().contact.distal.friction = None;
    let q = touching(&model, GRASP, [5e-6, 4e-6]);
    let mode = FingerMode::from([Active; 3]);
    cases.push(Case { name: "frictionless", scene: frictionless, mode, t: 0.0, q, v: [3.0, -1.0], steps: CONTACT });
    check("contacts", &cases);
}

#[test]
fn tip_contact_on_its_end() {
    let mut cases = Vec::new();
    let mut scene = anchor();
    // A disc off the end of the tip: the normal turns with the motion.
    let model = Model::new(&scene.system);
    let reading = model.reading(GRASP, [0.0; 2], Site::Distal, Active).expect("an object");
    let face = reading.geometry.tangent_row;
    let (lengths, [q11, q21]) = (&scene.finger().linkage.lengths, GRASP);
    let posture =
        gripper::close(lengths, scene.finger().linkage.assembly, q11, q21).expect("the grasp closes the loop");
    let tip = gripper::joints(lengths, &posture).tip_m;
    let reach = scene.finger().linkage.lengths.half_width_m + 20e-3 - 4e-6;
    let along = reading.geometry.normal.map(|n| -n);
    let out = [along[0] * 0.8 + along[1] * 0.6, along[1] * 0.8 - along[0] * 0.6];
    for direction in [out, [out[0] * 0.6 + out[1] * 0.8, out[1] * 0.6 - out[0] * 0.8]] {
        scene.system.grasped_mut().centre_m = [tip[0] + reach * direction[0], tip[1] + reach * direction[1]];
        let model = Model::new(&scene.system);
        let end = model.reading(GRASP, [0.0; 2], Site::Distal, Active).expect("an object");
        assert!((end.delta - 4e-6).abs() < 1e-12, "{:e}", end.delta);
        assert!((end.geometry.tangent_row[0] - face[0]).abs() > 1e-5);
        for v in [[2.0, 1.0], [-30.0, 5.0], [0.1, -0.1]] {
            let mode = FingerMode::from([Free, Active, Free]);
            cases.push(Case { name: "end", scene: scene.clone(), mode, t: 0.0, q: GRASP, v, steps: CONTACT });
        }
    }
    check("end of the tip", &cases);
}

#[test]
fn torque_profiles_with_a_slope() {
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
            let mut scene = anchor();
            scene.finger_mut().motor.actuation = profile.clone();
            cases.push(Case { t, ..swing("profile", scene) });
        }
    }
    // The slope is there at all.
    let sloped =
        Model::new(&cases[3].scene.system).linearise(1e-3, &cases[3].q, &cases[3].v, &FingerMode::from([Free; 3]));
    assert!(sloped.a_t[0].abs() > 1e5 && (sloped.g_t[4] - 200.0 * 120.0).abs() < 1e-9, "{sloped:?}");
    check("profiles", &cases);
}
