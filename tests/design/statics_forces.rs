//! Contact forces at rest: virtual work, balance of the object, Birglen's formulation, rejected input.

use crate::support::designs::{THIRDS, design_95, sweep_designs};
use crate::support::statics::{Frame, Grasp, Random, constant_spring, frames, grasp, rates, without_width};
use phalanx::fivebar::kinematics::{directions, passive_rates, reference_gamma};
use phalanx::gripper::{FinalPosture, Placement, Spring, SpringKind};
use phalanx::numeric::plane::{add, dot, perp, scale};
use phalanx::shape::max_radius;
use std::f64::consts::FRAC_PI_2;

/// Angles q11 and q21 of a posture.
fn driven_angles(end: &FinalPosture) -> [f64; 2] {
    [end.posture.q11_rad, end.posture.q21_rad]
}
use phalanx::sizing::{Rule, Sizing, Task, size};
use phalanx::statics::{
    Ejection, birglen, contact_jacobian, drive_loads, equilibrium, equilibrium_with_mu, form_closure, palm_force,
    static_kinematics,
};

fn is_near(actual: f64, expected: f64, relative: f64) -> bool {
    (actual - expected).abs() <= relative * (actual.abs() + expected.abs())
}

/// Returns the unit vectors n and t and the point of both contacts: n points from the object into the phalanx, t from its joint to its
/// end.
fn contacts(Grasp { disc, end, .. }: &Grasp) -> [([f64; 2], [f64; 2], [f64; 2]); 2] {
    [end.posture.q21_rad - FRAC_PI_2, end.phi_c_rad].map(|angle| {
        let n = [angle.cos(), angle.sin()];
        (n, perp(n), add(disc.centre_m, scale(n, max_radius(&disc.shape))))
    })
}

#[test]
fn errata_09_jacobian_equals_virtual_work_with_friction_along_the_tangent() {
    let mut random = Random(9);
    for _ in 0..200 {
        let grasp = random.grasp();
        let mu = [random.within(0.0, 1.0), random.within(0.0, 1.0)];
        let jacobian = contact_jacobian(&grasp.finger, &grasp.end, mu).unwrap();
        let q = driven_angles(&grasp.end);
        for (contact, (n, t, point)) in contacts(&grasp).into_iter().enumerate() {
            // The contact point is fixed to l21 or l22.
            let local = frames(&grasp.finger, q)[2 + contact].local(point);
            let displacements = rates(&grasp.finger, q, |frames| frames[2 + contact].point(local));
            for coordinate in 0..2 {
                let work = dot(displacements[coordinate], add(n, scale(t, mu[contact])));
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
        let upwards: f64 = contacts(&grasp).iter().zip(forces).map(|((n, t, _), f)| -f * (n[1] + mu * t[1])).sum();
        let pfp = palm_force(&grasp.end, forces[0], forces[1], mu);
        assert!((pfp + upwards).abs() < 1e-12 * (forces[0] + forces[1]));
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
    let printed = f22 * (phi_c.sin() + mu * phi_c.cos()) - f21 * ((q21 - FRAC_PI_2).cos() + mu * q21.sin());
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
    // Coordinates of the springs.
    type Coordinate = fn([Frame; 4]) -> f64;
    for (placement, coordinate) in [
        (Placement::GroundLinks, (|[l11, _, l21, _]| l21.angle_rad - l11.angle_rad) as Coordinate),
        (Placement::DrivenCoupler, |[l11, l12, ..]| l12.angle_rad - l11.angle_rad),
        (Placement::Phalanges, |[.., l21, l22]| l22.angle_rad - l21.angle_rad),
        (Placement::CouplerDistal, |[_, l12, _, l22]| l12.angle_rad - l22.angle_rad),
    ] {
        let q = driven_angles(&end);
        // From the straight configuration, with l11 on the palm and l21 upright, to the final posture.
        let rotation = coordinate(frames(&finger, q)) - coordinate(frames(&finger, [0.0, FRAC_PI_2]));
        let slope = rates(&finger, q, |frames| [coordinate(frames)]);
        for (kind, torque) in [
            (SpringKind::Constant { torque_n_m: 0.13 }, 0.13),
            (SpringKind::Torsional { stiffness_n_m_per_rad: 0.05, preload_rad: 1.5 }, 0.05 * (1.5 + rotation.abs())),
        ] {
            let loads = drive_loads(&finger, &end, 0.48, Some(&Spring { kind, placement })).unwrap();
            for i in 0..2 {
                let expected = [0.48, 0.0][i] - rotation.signum() * torque * slope[i][0];
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
    let tip = rates(&finger, driven_angles(&end), |[.., l21, l22]| [l22.angle_rad - l21.angle_rad]);
    // θ̇ = T (θ̇_a, θ̇2) for any motion of the two driven angles.
    for driven in [[1.0, 0.0], [0.3, -0.7], [0.0, 1.0]] {
        let tip_rate = dot(driven, [tip[0][0], tip[1][0]]);
        assert!((dot(forces.transmission[0], [driven[0], tip_rate]) - driven[1]).abs() < 1e-8);
        assert!((dot(forces.transmission_inverse[0], [driven[1], tip_rate]) - driven[0]).abs() < 1e-8);
    }
}

#[test]
fn ejection_names_the_phalanx_with_a_tensile_force() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    for (loads, expected) in [
        ([0.3474, 0.2], Ejection::None),
        ([0.3474, -5.0], Ejection::Proximal),
        ([-0.1, 5.0], Ejection::Distal),
        ([-0.1, -5.0], Ejection::Both),
        ([0.0, 0.0], Ejection::None),
    ] {
        assert_eq!(equilibrium(&finger, &end, loads, 0.0).unwrap().ejection(), expected, "{loads:?}");
    }
}

#[test]
fn errors_name_the_reason() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let [mut folded, mut dead_point] = [end, end];
    folded.posture.q12_rad = end.posture.q21_rad + end.posture.q22_rad - end.posture.q11_rad;
    dead_point.posture.q12_rad = 0.0;
    let on_joint = FinalPosture { l_c22_m: 0.0, ..end };
    for (end, load, mu, reason) in [
        (end, f64::NAN, [0.0; 2], "load on q11 is NaN"),
        (end, 0.1, [-0.1; 2], "mu_static is -0.1"),
        (end, 0.1, [0.1, f64::INFINITY], "mu_static is inf"),
        (on_joint, 0.1, [0.0; 2], "0.00e0 mm from its joint"),
        (folded, 0.1, [0.0; 2], "l12 and l22 are in line"),
        (dead_point, 0.1, [0.0; 2], "l11 and l12 are in line"),
    ] {
        let error = equilibrium_with_mu(&finger, &end, [load, 0.0], mu).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
    assert!(drive_loads(&finger, &end, f64::INFINITY, None).is_err());
    assert!(equilibrium(&finger, &on_joint, [0.1, 0.0], 0.5).is_ok(), "friction on the surface has a lever arm");
}

#[test]
fn final_posture_satisfies_loop_closure() {
    // The static transmission uses the angles of the posture; the loop closure must give the same rates.
    let mut random = Random(3);
    for _ in 0..200 {
        let Grasp { finger, end, .. } = random.grasp();
        let pose = directions(&finger.lengths, reference_gamma(&finger.lengths), driven_angles(&end));
        let (a, b) = (static_kinematics(&finger, &end).unwrap().rates, passive_rates(&finger.lengths, &pose));
        for (a, b) in a.a4.into_iter().zip(b.a4).chain(a.a3.into_iter().zip(b.a3)) {
            assert!(is_near(a, b, 1e-9), "{a} {b}");
        }
    }
}

/// Number of the 192 designs that hold their object, with motor and spring sized for the rigid phase (2-design §2.6).
#[test]
fn numbers_of_stable_and_form_closed_designs() {
    let (mut stable, mut closed, mut nearest) = ([0; 2], 0, f64::INFINITY);
    for design in sweep_designs(THIRDS) {
        let grasp = grasp(&design).unwrap();
        let Sizing { motor_n_m, spring_n_m, .. } = size(&grasp.finger, &Task::thesis(grasp.disc), Rule::Rigid).unwrap();
        let loads = drive_loads(&grasp.finger, &grasp.end, motor_n_m, Some(&constant_spring(spring_n_m))).unwrap();
        for (count, mu) in stable.iter_mut().zip([0.0, 0.8]) {
            let forces = equilibrium(&grasp.finger, &grasp.end, loads, mu).unwrap();
            *count += usize::from(forces.is_force_positive());
            nearest = nearest.min(forces.f21_n.abs()).min(forces.f22_n.abs());
        }
        closed += usize::from(form_closure(&grasp.finger, &grasp.end).unwrap().closed);
    }
    assert_eq!((stable, closed), ([136, 160], 22));
    assert!(nearest > 1e-3, "no design is decided by rounding: {nearest} N");
}
