//! Contact forces at rest: virtual work, balance of the object, Birglen's frame, refusals.

use crate::support::gripper::design_95;
use crate::support::statics::{Grasp, Random, constant_spring, grasp, without_width};
use phalanx::fivebar::kinematics::{directions, passive_rates, reference_gamma};
use phalanx::gripper::{Lengths, Placement, Site, Spring, SpringKind};
use phalanx::shape::reach;
use phalanx::statics::{
    Ejection, StaticsError, at_rest, birglen, contact_jacobian, drive_loads, equilibrium, equilibrium_each, palm_force,
};

fn near(got: f64, want: f64, relative: f64) -> bool {
    (got - want).abs() <= relative * (got.abs() + want.abs())
}

/// n and t of both contacts and their points on the phalanges: n from the object into the phalanx, t from its joint to its end.
fn contacts(Grasp { disc, end, .. }: &Grasp) -> [([f64; 2], [f64; 2], [f64; 2]); 2] {
    let e = |angle: f64| [angle.cos(), angle.sin()];
    let at = |angle: f64| {
        let (n, t) = (e(angle), e(angle + 0.5 * std::f64::consts::PI));
        let point = [disc.centre_m[0] + reach(&disc.shape) * n[0], disc.centre_m[1] + reach(&disc.shape) * n[1]];
        (n, t, point)
    };
    [at(end.posture.q21_rad - 0.5 * std::f64::consts::PI), at(end.phi_c_rad)]
}

#[test]
fn errata_09_the_jacobian_is_virtual_work_with_friction_along_the_tangent() {
    let mut random = Random(9);
    for _ in 0..200 {
        let grasp = random.grasp();
        let mu = [random.within(0.0, 1.0), random.within(0.0, 1.0)];
        let jacobian = contact_jacobian(&grasp.finger, &grasp.end, mu).unwrap();
        let lengths = &grasp.finger.lengths;
        let posture = &grasp.end.posture;
        // A point of l21 or l22, carried along by central differences of the loop closure.
        let gamma = reference_gamma(lengths);
        let carried = |site: usize, point: [f64; 2], q: [f64; 2]| -> [f64; 2] {
            let body = |q: [f64; 2]| {
                let pose = directions(lengths, gamma, q);
                match site {
                    0 => ([0.0; 2], pose.e2),
                    _ => ([lengths.l21_m * pose.e2[0], lengths.l21_m * pose.e2[1]], pose.e4),
                }
            };
            let (from, x) = body([posture.q11_rad, posture.q21_rad]);
            let off = [point[0] - from[0], point[1] - from[1]];
            let local = [x[0] * off[0] + x[1] * off[1], x[0] * off[1] - x[1] * off[0]];
            let (to, x) = body(q);
            [to[0] + x[0] * local[0] - x[1] * local[1], to[1] + x[1] * local[0] + x[0] * local[1]]
        };
        for (site, (n, t, point)) in contacts(&grasp).into_iter().enumerate() {
            for coordinate in 0..2 {
                let at = |step: f64| {
                    let mut q = [posture.q11_rad, posture.q21_rad];
                    q[coordinate] += step;
                    carried(site, point, q)
                };
                let (a, b) = (at(1e-6), at(-1e-6));
                let force = [n[0] + mu[site] * t[0], n[1] + mu[site] * t[1]];
                let work = ((a[0] - b[0]) * force[0] + (a[1] - b[1]) * force[1]) / 2e-6;
                let found = jacobian[coordinate][site];
                assert!((found - work).abs() < 1e-9, "contact {site}, q{coordinate}: {found:e}, not {work:e}");
            }
        }
    }
}

#[test]
fn errata_09_without_mu_on_the_tangent_friction_could_not_matter() {
    // As printed the tangential unit vector has weight 1 whatever μ is.
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let loads = drive_loads(&finger, &end, 0.48, Some(&constant_spring(0.1326))).unwrap();
    let forces = [0.0, 0.4, 0.8].map(|mu| equilibrium(&finger, &end, loads, mu).unwrap().f21_n);
    assert!(forces[0] < forces[1] && forces[1] < forces[2], "{forces:?}");
}

#[test]
fn errata_10_the_palm_force_balances_the_object() {
    let mut random = Random(10);
    for _ in 0..200 {
        let grasp = random.grasp();
        let mu = random.within(0.0, 1.0);
        let forces = [random.within(0.0, 50.0), random.within(0.0, 50.0)];
        let mut on_object = [0.0; 2];
        for ((n, t, _), force) in contacts(&grasp).into_iter().zip(forces) {
            on_object[0] -= force * (n[0] + mu * t[0]);
            on_object[1] -= force * (n[1] + mu * t[1]);
        }
        let pfp = palm_force(&grasp.end, forces[0], forces[1], mu);
        assert!((pfp + on_object[1]).abs() < 1e-12 * (forces[0] + forces[1]));
    }
}

#[test]
fn errata_10_the_printed_palm_force_would_lift_design_95_off() {
    let Grasp { end, .. } = grasp(&design_95()).unwrap();
    // Final forces of its simulation (1-model §1.8); the thesis has 16.3 N, and 17.3 N follows from its definition.
    let (f21, f22, mu) = (23.6092, 8.2573, 0.8);
    let found = palm_force(&end, f21, f22, mu);
    assert!((found - 17.3).abs() < 0.05, "{found}");
    let (q21, phi_c) = (end.posture.q21_rad, end.phi_c_rad);
    let printed =
        f22 * (phi_c.sin() + mu * phi_c.cos()) - f21 * ((q21 - 0.5 * std::f64::consts::PI).cos() + mu * q21.sin());
    assert!(printed < -20.0, "{printed}");
}

#[test]
fn errata_04_the_spring_pulls_back_and_the_motor_must_hold_it() {
    // F22 ≥ 0 ⇔ τ11 ≥ k_s ∂q22/∂q11, whatever the friction.
    let mut random = Random(4);
    for _ in 0..500 {
        let Grasp { finger, end, .. } = random.grasp();
        let spring = random.within(0.05, 0.3);
        let needed = spring * at_rest(&finger, &end).unwrap().tip_slope[0];
        assert!(needed > 0.0);
        for mu in [0.0, 0.8] {
            for (factor, holds) in [(1.0 - 1e-9, false), (1.0 + 1e-9, true)] {
                let loads = drive_loads(&finger, &end, needed * factor, Some(&constant_spring(spring))).unwrap();
                let forces = equilibrium(&finger, &end, loads, mu).unwrap();
                assert_eq!(forces.f22_n >= 0.0, holds);
                assert_eq!(forces.ejects(Site::Distal), !holds);
            }
        }
    }
}

#[test]
fn every_spring_loads_the_joints_by_its_virtual_work() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let (lengths, posture) = (&finger.lengths, &end.posture);
    let gamma = reference_gamma(lengths);
    let angle = |a: [f64; 2], b: [f64; 2]| (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
    for placement in [Placement::GroundLinks, Placement::DrivenCoupler, Placement::Phalanges, Placement::CouplerDistal]
    {
        let coordinate = |q: [f64; 2]| {
            let pose = directions(lengths, gamma, q);
            match placement {
                Placement::GroundLinks => angle(pose.e1, pose.e2),
                Placement::DrivenCoupler => angle(pose.e1, pose.e3),
                Placement::Phalanges => angle(pose.e2, pose.e4),
                Placement::CouplerDistal => angle(pose.e4, pose.e3),
            }
        };
        let (q11, q21) = (posture.q11_rad, posture.q21_rad);
        // From the straight configuration, with l11 on the palm and l21 upright, to the final posture.
        let turned = coordinate([q11, q21]) - coordinate([0.0, 0.5 * std::f64::consts::PI]);
        for (kind, torque) in [
            (SpringKind::Constant { torque_n_m: 0.13 }, 0.13),
            (SpringKind::Torsional { stiffness_n_m_per_rad: 0.05, preload_rad: 1.5 }, 0.05 * (1.5 + turned.abs())),
        ] {
            let loads = drive_loads(&finger, &end, 0.48, Some(&Spring { kind, placement })).unwrap();
            let slope = [[1.0, 0.0], [0.0, 1.0]].map(|d: [f64; 2]| {
                let at = |step: f64| coordinate([q11 + step * d[0], q21 + step * d[1]]);
                (at(1e-6) - at(-1e-6)) / 2e-6
            });
            for i in 0..2 {
                let want = [0.48, 0.0][i] - turned.signum() * torque * slope[i];
                assert!((loads[i] - want).abs() < 1e-8, "{placement:?} {kind:?}: {loads:?}, not {want}");
            }
        }
    }
    assert_eq!(drive_loads(&finger, &end, 0.48, None).unwrap(), [0.48, 0.0]);
}

#[test]
fn birglens_forces_are_the_same_where_width_or_friction_is_none() {
    let mut random = Random(7);
    for _ in 0..2_000 {
        let wide = random.grasp();
        let thin = without_width(&wide);
        let (motor, spring) = (random.within(0.3, 0.7), random.within(0.05, 0.3));
        let mu = random.within(0.1, 0.8);
        for (grasp, mu) in [(&thin, 0.0), (&thin, mu), (&wide, 0.0)] {
            let Grasp { finger, end, .. } = grasp;
            let loads = drive_loads(finger, end, motor, Some(&constant_spring(spring))).unwrap();
            let ours = equilibrium(finger, end, loads, mu).unwrap();
            let theirs = birglen(finger, end, loads, mu).unwrap();
            assert!(near(theirs.forces_n[0], ours.f21_n, 1e-9), "{theirs:?} {ours:?}");
            assert!(near(theirs.forces_n[1], ours.f22_n, 1e-9), "{theirs:?} {ours:?}");
            // (1.10) as printed: its first entry is 1, for l11 and l21 turn about one joint.
            assert!((theirs.transmission[0][0] - 1.0).abs() < 1e-9);
            // t: the motor on θ_a, and the spring alone on θ2.
            assert!(near(theirs.torques_n_m[0], motor, 1e-9) && near(theirs.torques_n_m[1], -spring, 1e-9));
        }
        // With both, friction has levers of μ w about the joints, which Birglen's lines have not: the same torques on the
        // phalanges, with l_c + μ w for l_c.
        let Grasp { finger, end, .. } = &wide;
        let loads = drive_loads(finger, end, motor, Some(&constant_spring(spring))).unwrap();
        let (ours, theirs) = (equilibrium(finger, end, loads, mu).unwrap(), birglen(finger, end, loads, mu).unwrap());
        let lever = mu * finger.lengths.half_width_m;
        assert!(near(theirs.forces_n[1] * end.l_c22_m, ours.f22_n * (end.l_c22_m + lever), 1e-9));
        let carried = theirs.jacobian_m[1][0] - end.l_c22_m;
        let (a, b) = (theirs.forces_n[0] * end.l_c21_m, theirs.forces_n[1] * carried);
        let (c, d) = (ours.f21_n * (end.l_c21_m + lever), ours.f22_n * carried);
        assert!((a + b - c - d).abs() < 1e-12 * motor.max(b.abs()), "{a} {b} {c} {d}");
        assert!(ours.f22_n.abs() < theirs.forces_n[1].abs());
    }
}

#[test]
fn birglens_rates_are_those_of_the_loop() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let found = birglen(&finger, &end, [0.48, 0.0], 0.0).unwrap();
    let (q, h) = ([end.posture.q11_rad, end.posture.q21_rad], 1e-6);
    let tip = |q: [f64; 2]| {
        let pose = directions(&finger.lengths, reference_gamma(&finger.lengths), q);
        (pose.e2[0] * pose.e4[1] - pose.e2[1] * pose.e4[0]).atan2(pose.e2[0] * pose.e4[0] + pose.e2[1] * pose.e4[1])
    };
    // θ̇ = T (θ̇_a, θ̇2) for any motion of the two driven angles.
    for rates in [[1.0, 0.0], [0.3, -0.7], [0.0, 1.0]] {
        let at = |s: f64| tip([q[0] + s * rates[0], q[1] + s * rates[1]]);
        let bend = (at(h) - at(-h)) / (2.0 * h);
        let [[t11, t12], _] = found.transmission;
        assert!((t11 * rates[0] + t12 * bend - rates[1]).abs() < 1e-8);
        let [[i11, i12], _] = found.transmission_inverse;
        assert!((i11 * rates[1] + i12 * bend - rates[0]).abs() < 1e-8);
    }
}

#[test]
fn ejection_names_the_phalanx_that_would_have_to_pull() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let of = |loads| equilibrium(&finger, &end, loads, 0.0).unwrap().ejection();
    assert_eq!(of([0.3474, 0.2]), Ejection::None);
    assert_eq!(of([0.3474, -5.0]), Ejection::Proximal);
    assert_eq!(of([-0.1, 5.0]), Ejection::Distal);
    assert_eq!(of([-0.1, -5.0]), Ejection::Both);
    assert_eq!(of([0.0, 0.0]), Ejection::None);
}

#[test]
fn what_has_no_statics_says_why() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let message =
        |result: Result<_, StaticsError>| result.map(|_: phalanx::statics::Equilibrium| ()).unwrap_err().to_string();
    assert!(message(equilibrium(&finger, &end, [f64::NAN, 0.0], 0.0)).contains("load on q11 is NaN"));
    assert!(message(equilibrium(&finger, &end, [0.1, 0.0], -0.1)).contains("mu_static is -0.1"));
    assert!(message(equilibrium_each(&finger, &end, [0.1, 0.0], [0.1, f64::INFINITY])).contains("mu_static is inf"));
    assert!(drive_loads(&finger, &end, f64::INFINITY, None).is_err());

    let on_joint = phalanx::gripper::FinalPosture { l_c22_m: 0.0, ..end };
    assert!(message(equilibrium(&finger, &on_joint, [0.1, 0.0], 0.0)).contains("0.00e0 mm from its joint"));
    assert!(equilibrium(&finger, &on_joint, [0.1, 0.0], 0.5).is_ok(), "friction on the surface has a lever");

    // l12 and l22 in line; l11 and l12 in line.
    let mut folded = end;
    folded.posture.q12_rad = end.posture.q21_rad + end.posture.q22_rad - end.posture.q11_rad;
    assert!(message(equilibrium(&finger, &folded, [0.1, 0.0], 0.0)).contains("l12 and l22 are in line"));
    let mut dead = end;
    dead.posture.q12_rad = 0.0;
    assert!(message(equilibrium(&finger, &dead, [0.1, 0.0], 0.0)).contains("l11 and l12 are in line"));
}

#[test]
fn the_final_posture_closes_its_loop() {
    // `at_rest` takes directions from the posture's angles; the loop must give the same rates.
    let mut random = Random(3);
    for _ in 0..200 {
        let Grasp { finger, end, .. } = random.grasp();
        let lengths: &Lengths = &finger.lengths;
        let q = [end.posture.q11_rad, end.posture.q21_rad];
        let pose = directions(lengths, reference_gamma(lengths), q);
        let (a, b) = (at_rest(&finger, &end).unwrap().rates, passive_rates(lengths, &pose));
        for (a, b) in a.a4.into_iter().zip(b.a4).chain(a.a3.into_iter().zip(b.a3)) {
            assert!(near(a, b, 1e-9), "{a} {b}");
        }
    }
}
