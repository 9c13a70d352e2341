//! Contact forces at rest: virtual work, balance of the object, Birglen's formulation, rejected input.

use crate::support::designs::design_95;
use crate::support::statics::{Grasp, Random, constant_spring, grasp, without_width};
use phalanx::fivebar::kinematics::{directions, passive_rates, reference_gamma};
use phalanx::gripper::{Lengths, Placement, Spring, SpringKind};
use phalanx::shape::max_radius;
use phalanx::statics::{
    Ejection, StaticsError, birglen, contact_jacobian, drive_loads, equilibrium, equilibrium_with_mu, palm_force,
    static_kinematics,
};

fn is_near(actual: f64, expected: f64, relative: f64) -> bool {
    (actual - expected).abs() <= relative * (actual.abs() + expected.abs())
}

/// Returns the unit vectors n and t and the point of both contacts: n points from the object into the phalanx, t from its joint to its
/// end.
fn contacts(Grasp { disc, end, .. }: &Grasp) -> [([f64; 2], [f64; 2], [f64; 2]); 2] {
    let e = |angle: f64| [angle.cos(), angle.sin()];
    let contact_at = |angle: f64| {
        let (n, t) = (e(angle), e(angle + 0.5 * std::f64::consts::PI));
        let point =
            [disc.centre_m[0] + max_radius(&disc.shape) * n[0], disc.centre_m[1] + max_radius(&disc.shape) * n[1]];
        (n, t, point)
    };
    [contact_at(end.posture.q21_rad - 0.5 * std::f64::consts::PI), contact_at(end.phi_c_rad)]
}

#[test]
fn errata_09_jacobian_equals_virtual_work_with_friction_along_the_tangent() {
    let mut random = Random(9);
    for _ in 0..200 {
        let grasp = random.grasp();
        let mu = [random.within(0.0, 1.0), random.within(0.0, 1.0)];
        let jacobian = contact_jacobian(&grasp.finger, &grasp.end, mu).unwrap();
        let lengths = &grasp.finger.lengths;
        let posture = &grasp.end.posture;
        // Position of a point fixed to l21 or l22, for central differences of the loop closure.
        let gamma = reference_gamma(lengths);
        let transported = |contact: usize, point: [f64; 2], q: [f64; 2]| -> [f64; 2] {
            let body = |q: [f64; 2]| {
                let pose = directions(lengths, gamma, q);
                match contact {
                    0 => ([0.0; 2], pose.e2),
                    _ => ([lengths.l21_m * pose.e2[0], lengths.l21_m * pose.e2[1]], pose.e4),
                }
            };
            let (from, x) = body([posture.q11_rad, posture.q21_rad]);
            let offset = [point[0] - from[0], point[1] - from[1]];
            let local = [x[0] * offset[0] + x[1] * offset[1], x[0] * offset[1] - x[1] * offset[0]];
            let (to, x) = body(q);
            [to[0] + x[0] * local[0] - x[1] * local[1], to[1] + x[1] * local[0] + x[0] * local[1]]
        };
        for (contact, (n, t, point)) in contacts(&grasp).into_iter().enumerate() {
            for coordinate in 0..2 {
                let position = |step: f64| {
                    let mut q = [posture.q11_rad, posture.q21_rad];
                    q[coordinate] += step;
                    transported(contact, point, q)
                };
                let (a, b) = (position(1e-6), position(-1e-6));
                let force = [n[0] + mu[contact] * t[0], n[1] + mu[contact] * t[1]];
                let work = ((a[0] - b[0]) * force[0] + (a[1] - b[1]) * force[1]) / 2e-6;
                let actual = jacobian[coordinate][contact];
                assert!((actual - work).abs() < 1e-9, "contact {contact}, q{coordinate}: {actual:e}, not {work:e}");
            }
        }
    }
}

#[test]
fn errata_09_friction_affects_the_forces() {
    // In the printed equation, the tangential unit vector has weight 1 for every μ.
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let loads = drive_loads(&finger, &end, 0.48, Some(&constant_spring(0.1326))).unwrap();
    let forces = [0.0, 0.4, 0.8].map(|mu| equilibrium(&finger, &end, loads, mu).unwrap().f21_n);
    assert!(forces[0] < forces[1] && forces[1] < forces[2], "{forces:?}");
}

#[test]
fn errata_10_palm_force_balances_the_object() {
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
fn errata_10_printed_palm_force_has_the_wrong_sign() {
    let Grasp { end, .. } = grasp(&design_95()).unwrap();
    // Final forces of the simulation (1-model §1.8); the thesis prints 16.3 N, but its definition gives 17.3 N.
    let (f21, f22, mu) = (23.6092, 8.2573, 0.8);
    let actual = palm_force(&end, f21, f22, mu);
    assert!((actual - 17.3).abs() < 0.05, "{actual}");
    let (q21, phi_c) = (end.posture.q21_rad, end.phi_c_rad);
    let printed =
        f22 * (phi_c.sin() + mu * phi_c.cos()) - f21 * ((q21 - 0.5 * std::f64::consts::PI).cos() + mu * q21.sin());
    assert!(printed < -20.0, "{printed}");
}

#[test]
fn errata_04_motor_torque_must_balance_the_spring() {
    // F22 ≥ 0 ⇔ τ11 ≥ k_s ∂q22/∂q11 for any friction.
    let mut random = Random(4);
    for _ in 0..500 {
        let Grasp { finger, end, .. } = random.grasp();
        let spring = random.within(0.05, 0.3);
        let required = spring * static_kinematics(&finger, &end).unwrap().tip_slope[0];
        assert!(required > 0.0);
        for mu in [0.0, 0.8] {
            for (factor, is_positive) in [(1.0 - 1e-9, false), (1.0 + 1e-9, true)] {
                let loads = drive_loads(&finger, &end, required * factor, Some(&constant_spring(spring))).unwrap();
                let forces = equilibrium(&finger, &end, loads, mu).unwrap();
                assert_eq!(forces.f22_n >= 0.0, is_positive);
                let separates = matches!(forces.ejection(), Ejection::Distal | Ejection::Both);
                assert_eq!(separates, !is_positive);
            }
        }
    }
}

#[test]
fn spring_loads_equal_virtual_work() {
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
        let rotation = coordinate([q11, q21]) - coordinate([0.0, 0.5 * std::f64::consts::PI]);
        for (kind, torque) in [
            (SpringKind::Constant { torque_n_m: 0.13 }, 0.13),
            (SpringKind::Torsional { stiffness_n_m_per_rad: 0.05, preload_rad: 1.5 }, 0.05 * (1.5 + rotation.abs())),
        ] {
            let loads = drive_loads(&finger, &end, 0.48, Some(&Spring { kind, placement })).unwrap();
            let slope = [[1.0, 0.0], [0.0, 1.0]].map(|d: [f64; 2]| {
                let coordinate_at = |step: f64| coordinate([q11 + step * d[0], q21 + step * d[1]]);
                (coordinate_at(1e-6) - coordinate_at(-1e-6)) / 2e-6
            });
            for i in 0..2 {
                let expected = [0.48, 0.0][i] - rotation.signum() * torque * slope[i];
                assert!((loads[i] - expected).abs() < 1e-8, "{placement:?} {kind:?}: {loads:?}, not {expected}");
            }
        }
    }
    assert_eq!(drive_loads(&finger, &end, 0.48, None).unwrap(), [0.48, 0.0]);
}

#[test]
fn birglens_forces_agree_without_width_or_without_friction() {
    let mut random = Random(7);
    for _ in 0..2_000 {
        let with_width = random.grasp();
        let zero_width = without_width(&with_width);
        let (motor, spring) = (random.within(0.3, 0.7), random.within(0.05, 0.3));
        let mu = random.within(0.1, 0.8);
        for (grasp, mu) in [(&zero_width, 0.0), (&zero_width, mu), (&with_width, 0.0)] {
            let Grasp { finger, end, .. } = grasp;
            let loads = drive_loads(finger, end, motor, Some(&constant_spring(spring))).unwrap();
            let forces = equilibrium(finger, end, loads, mu).unwrap();
            let birglen = birglen(finger, end, loads, mu).unwrap();
            assert!(is_near(birglen.forces_n[0], forces.f21_n, 1e-9), "{birglen:?} {forces:?}");
            assert!(is_near(birglen.forces_n[1], forces.f22_n, 1e-9), "{birglen:?} {forces:?}");
            // (1.10) as printed: its first entry is 1, because l11 and l21 rotate about the same joint.
            assert!((birglen.transmission[0][0] - 1.0).abs() < 1e-9);
            // t: the motor acts on θ_a, and only the spring on θ2.
            assert!(is_near(birglen.torques_n_m[0], motor, 1e-9) && is_near(birglen.torques_n_m[1], -spring, 1e-9));
        }
        // With width and friction, friction has lever arms of μ w about the joints, which Birglen's line model lacks. The torques on
        // the phalanges agree if l_c is replaced by l_c + μ w.
        let Grasp { finger, end, .. } = &with_width;
        let loads = drive_loads(finger, end, motor, Some(&constant_spring(spring))).unwrap();
        let forces = equilibrium(finger, end, loads, mu).unwrap();
        let birglen = birglen(finger, end, loads, mu).unwrap();
        let lever = mu * finger.lengths.half_width_m;
        assert!(is_near(birglen.forces_n[1] * end.l_c22_m, forces.f22_n * (end.l_c22_m + lever), 1e-9));
        let coupling_m = birglen.jacobian_m[1][0] - end.l_c22_m;
        let (a, b) = (birglen.forces_n[0] * end.l_c21_m, birglen.forces_n[1] * coupling_m);
        let (c, d) = (forces.f21_n * (end.l_c21_m + lever), forces.f22_n * coupling_m);
        assert!((a + b - c - d).abs() < 1e-12 * motor.max(b.abs()), "{a} {b} {c} {d}");
        assert!(forces.f22_n.abs() < birglen.forces_n[1].abs());
    }
}

#[test]
fn birglens_transmission_matches_the_loop_rates() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let forces = birglen(&finger, &end, [0.48, 0.0], 0.0).unwrap();
    let (q, h) = ([end.posture.q11_rad, end.posture.q21_rad], 1e-6);
    let tip = |q: [f64; 2]| {
        let pose = directions(&finger.lengths, reference_gamma(&finger.lengths), q);
        (pose.e2[0] * pose.e4[1] - pose.e2[1] * pose.e4[0]).atan2(pose.e2[0] * pose.e4[0] + pose.e2[1] * pose.e4[1])
    };
    // θ̇ = T (θ̇_a, θ̇2) for any motion of the two driven angles.
    for rates in [[1.0, 0.0], [0.3, -0.7], [0.0, 1.0]] {
        let tip_at = |s: f64| tip([q[0] + s * rates[0], q[1] + s * rates[1]]);
        let tip_rate = (tip_at(h) - tip_at(-h)) / (2.0 * h);
        let [[t11, t12], _] = forces.transmission;
        assert!((t11 * rates[0] + t12 * tip_rate - rates[1]).abs() < 1e-8);
        let [[i11, i12], _] = forces.transmission_inverse;
        assert!((i11 * rates[1] + i12 * tip_rate - rates[0]).abs() < 1e-8);
    }
}

#[test]
fn ejection_names_the_phalanx_with_a_tensile_force() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let ejection = |loads| equilibrium(&finger, &end, loads, 0.0).unwrap().ejection();
    assert_eq!(ejection([0.3474, 0.2]), Ejection::None);
    assert_eq!(ejection([0.3474, -5.0]), Ejection::Proximal);
    assert_eq!(ejection([-0.1, 5.0]), Ejection::Distal);
    assert_eq!(ejection([-0.1, -5.0]), Ejection::Both);
    assert_eq!(ejection([0.0, 0.0]), Ejection::None);
}

#[test]
fn errors_name_the_reason() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let message =
        |result: Result<_, StaticsError>| result.map(|_: phalanx::statics::Equilibrium| ()).unwrap_err().to_string();
    assert!(message(equilibrium(&finger, &end, [f64::NAN, 0.0], 0.0)).contains("load on q11 is NaN"));
    assert!(message(equilibrium(&finger, &end, [0.1, 0.0], -0.1)).contains("mu_static is -0.1"));
    assert!(message(equilibrium_with_mu(&finger, &end, [0.1, 0.0], [0.1, f64::INFINITY])).contains("mu_static is inf"));
    assert!(drive_loads(&finger, &end, f64::INFINITY, None).is_err());

    let on_joint = phalanx::gripper::FinalPosture { l_c22_m: 0.0, ..end };
    assert!(message(equilibrium(&finger, &on_joint, [0.1, 0.0], 0.0)).contains("0.00e0 mm from its joint"));
    assert!(equilibrium(&finger, &on_joint, [0.1, 0.0], 0.5).is_ok(), "friction on the surface has a lever arm");

    // l12 and l22 in line; l11 and l12 in line.
    let mut folded = end;
    folded.posture.q12_rad = end.posture.q21_rad + end.posture.q22_rad - end.posture.q11_rad;
    assert!(message(equilibrium(&finger, &folded, [0.1, 0.0], 0.0)).contains("l12 and l22 are in line"));
    let mut dead_point = end;
    dead_point.posture.q12_rad = 0.0;
    assert!(message(equilibrium(&finger, &dead_point, [0.1, 0.0], 0.0)).contains("l11 and l12 are in line"));
}

#[test]
fn final_posture_satisfies_loop_closure() {
    // The static transmission uses the angles of the posture; the loop closure must give the same rates.
    let mut random = Random(3);
    for _ in 0..200 {
        let Grasp { finger, end, .. } = random.grasp();
        let lengths: &Lengths = &finger.lengths;
        let q = [end.posture.q11_rad, end.posture.q21_rad];
        let pose = directions(lengths, reference_gamma(lengths), q);
        let (a, b) = (static_kinematics(&finger, &end).unwrap().rates, passive_rates(lengths, &pose));
        for (a, b) in a.a4.into_iter().zip(b.a4).chain(a.a3.into_iter().zip(b.a3)) {
            assert!(is_near(a, b, 1e-9), "{a} {b}");
        }
    }
}
