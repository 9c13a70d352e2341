//! Form closure: counts of the thesis, agreement of signs, linear programmes and statics, and certificates of both kinds.

use crate::support::designs::{THIRDS, design_95, sweep_designs};
use crate::support::statics::{Grasp, Random, check_certificate, grasp};
use phalanx::gripper::{FinalPosture, Finger, FingerContact, Posture, close_loop, joint_positions};
use phalanx::shape::max_radius;
use phalanx::statics::{
    BOUNDARY, Certificate, Decision, FingerGrip, FormClosure, Hand, Row, Side, Unilateral, Unknown,
    decide_by_linear_program, decide_form_closure, equilibrium, form_closure, unilateral,
};

const RANDOM: usize = 10_000;

fn grid(fractions: [f64; 4]) -> Vec<Grasp> {
    sweep_designs(fractions).iter().map(|design| grasp(design).expect("a design of the thesis")).collect()
}

fn random() -> impl Iterator<Item = Grasp> {
    let mut random = Random(1);
    std::iter::repeat_with(move || random.grasp()).take(RANDOM)
}

fn closure(Grasp { finger, end, .. }: &Grasp) -> FormClosure {
    form_closure(finger, end).expect("a decision")
}

fn constraints(Grasp { finger, end, .. }: &Grasp) -> Unilateral {
    unilateral(&Hand::symmetric(finger, end)).expect("a posture that is not singular")
}

#[test]
fn errata_15_counts_of_form_closed_designs() {
    let count = |fractions| grid(fractions).iter().filter(|grasp| closure(grasp).closed).count();
    assert_eq!(count(THIRDS), 22);
    assert_eq!(count([0.0, 0.25, 0.5, 0.75]), 13);
    assert!(closure(&grasp(&design_95()).unwrap()).closed);
}

#[test]
fn errata_12_printed_sign_closes_no_design() {
    // The printed row of T is (1, R_t), that of T⁻¹ is (1, −R_t).
    let is_closed_as_printed = |grasp: &Grasp| {
        let mut u = constraints(grasp);
        let width = u.unknowns.len();
        for (i, row) in u.rows.iter().enumerate() {
            if let Row::Motor { finger } = row {
                let tip = u.unknowns.iter().position(|k| *k == Unknown::Distal { finger: *finger }).unwrap();
                assert!(u.matrix[i * width + tip] > 0.0);
                u.matrix[i * width + tip] *= -1.0;
            }
        }
        decide_form_closure(&u).unwrap().closed
    };
    assert_eq!(grid(THIRDS).iter().filter(|grasp| is_closed_as_printed(grasp)).count(), 0);
}

/// Returns whether a motor torque, without spring and friction, loads both contacts and the palm.
fn has_positive_forces(Grasp { finger, end, .. }: &Grasp) -> bool {
    let forces = equilibrium(finger, end, [1.0, 0.0], 0.0).unwrap();
    forces.f21_n > 0.0 && forces.f22_n > 0.0 && forces.pfp_n > 0.0
}

#[test]
fn closure_equals_positive_forces_without_spring_and_friction() {
    let mut nearest = f64::INFINITY;
    let mut closed = 0;
    for grasp in grid(THIRDS).into_iter().chain(random()) {
        let form_closure = closure(&grasp);
        assert_eq!(form_closure.closed, has_positive_forces(&grasp), "{grasp:?}");
        nearest = nearest.min(form_closure.margin.expect("unique multipliers").abs());
        closed += usize::from(form_closure.closed);
    }
    println!("{closed} of {} closed, smallest margin {nearest:.2e}", RANDOM + 192);
    // Margins below the width of the boundary would be decided by rounding. All margins are at least a thousand times larger.
    assert!(nearest > 1e3 * BOUNDARY, "{nearest:e}");
    assert!(closed > 500 && closed < RANDOM / 2, "{closed} closed grasps of {RANDOM}: both results must occur");
}

#[test]
fn linear_programmes_agree_with_signs() {
    for grasp in grid(THIRDS).iter().chain(random().collect::<Vec<_>>().iter()) {
        let u = constraints(grasp);
        let (by_signs, by_program) = (decide_form_closure(&u).unwrap(), decide_by_linear_program(&u).unwrap());
        assert_eq!((by_signs.decision, by_program.decision), (Decision::Signs, Decision::Programme));
        assert_eq!(by_signs.closed, by_program.closed, "{grasp:?}");
        check_certificate(&u, &by_signs);
        check_certificate(&u, &by_program);
        if let (Certificate::Multipliers { values: a, .. }, Certificate::Multipliers { values: b, .. }) =
            (&by_signs.certificate, &by_program.certificate)
        {
            // The multipliers are unique.
            let difference = a.iter().zip(b).map(|(a, b)| (a - b).abs() / a.abs()).fold(0.0, f64::max);
            assert!(difference < 1e-6, "{a:?}\n{b:?}");
        }
    }
}

#[test]
fn free_motion_opens_the_gaps_as_predicted() {
    // Comparison with the geometry of displaced bodies: capsules, a disc, and a closed loop.
    for grasp in grid(THIRDS).iter().filter(|grasp| !closure(grasp).closed) {
        let FormClosure { certificate: Certificate::Motion { values, rates, .. }, rows, .. } = closure(grasp) else {
            unreachable!()
        };
        for (row, rate) in rows.iter().zip(&rates) {
            let [x, y, right_1, right_2, left_1, left_2] = values[..] else { unreachable!() };
            let displaced = |finger: usize, dt: f64| match finger {
                0 => gaps(grasp, [x, y], [right_1, right_2], dt),
                // The left finger is the mirror image of a right finger with the mirrored object motion.
                _ => gaps(grasp, [-x, y], [left_1, left_2], dt),
            };
            let rate_of = |finger: usize, select: fn(&DisplacedFinger) -> f64| {
                let dt = 1e-3;
                (select(&displaced(finger, dt)) - select(&displaced(finger, -dt))) / (2.0 * dt)
            };
            let actual = match *row {
                Row::Palm => y,
                Row::Motor { finger } => rate_of(finger, |displaced| displaced.q11_rad),
                Row::Contact { finger, site: FingerContact::Proximal } => {
                    rate_of(finger, |displaced| displaced.gaps_m[0])
                }
                Row::Contact { finger, .. } => rate_of(finger, |displaced| displaced.gaps_m[1]),
                Row::Input => unreachable!("each finger has its own motor"),
            };
            let scale = values[2..].iter().fold(1e-3, |largest: f64, v| largest.max(0.03 * v.abs()));
            assert!((actual - rate).abs() < 1e-5 * scale.max(rate.abs()), "{row:?}: {actual:e}, not {rate:e}");
        }
    }
}

struct DisplacedFinger {
    q11_rad: f64,
    gaps_m: [f64; 2],
}

/// Moves a right finger and its disc for a time and returns the motor angle and the gaps of both phalanges.
fn gaps(Grasp { finger, disc, end }: &Grasp, object: [f64; 2], joint_rates: [f64; 2], dt: f64) -> DisplacedFinger {
    let Finger { lengths, assembly, .. } = finger;
    let FinalPosture { posture, .. } = end;
    let (q21, q22) = (posture.q21_rad + joint_rates[0] * dt, posture.q22_rad + joint_rates[1] * dt);
    // Bisection for the q11 that closes the loop at these angles.
    let tip_angle = |q11: f64| close_loop(lengths, *assembly, q11, q21).expect("near the final posture").q22_rad;
    let (mut low, mut high) = (posture.q11_rad - 0.02, posture.q11_rad + 0.02);
    for _ in 0..60 {
        let mean = 0.5 * (low + high);
        if tip_angle(mean) < q22 { low = mean } else { high = mean }
    }
    let q11_rad = 0.5 * (low + high);
    let joints = joint_positions(lengths, &Posture { q11_rad, q21_rad: q21, q22_rad: q22, ..*posture });
    let centre = [disc.centre_m[0] + object[0] * dt, disc.centre_m[1] + object[1] * dt];
    let gap = |from: [f64; 2], to: [f64; 2]| {
        let (along, offset) = ([to[0] - from[0], to[1] - from[1]], [centre[0] - from[0], centre[1] - from[1]]);
        let length = along[0].hypot(along[1]);
        (along[0] * offset[1] - along[1] * offset[0]) / length - max_radius(&disc.shape) - lengths.half_width_m
    };
    DisplacedFinger { q11_rad, gaps_m: [gap([0.0; 2], joints.a22_m), gap(joints.a22_m, joints.tip_m)] }
}

/// Returns the constraints of fixed fingertips on a disc that cannot rotate: each prevents motion against its normal.
fn fixed_tips(directions_deg: &[f64]) -> Unilateral {
    let mut u = Unilateral::new(vec![Unknown::ObjectX, Unknown::ObjectY], vec![1.0; 2]);
    for (finger, angle) in directions_deg.iter().enumerate() {
        let (sin, cos) = angle.to_radians().sin_cos();
        u.push(Row::Contact { finger, site: FingerContact::Distal }, |unknown| match unknown {
            Unknown::ObjectX => cos,
            _ => sin,
        });
    }
    u
}

#[test]
fn decides_any_number_of_contacts() {
    for (directions, closed, decision) in [
        // Three contacts that span the plane; four; five.
        (&[90.0, 210.0, 330.0][..], true, Decision::Signs),
        (&[0.0, 100.0, 190.0, 280.0], true, Decision::Programme),
        (&[0.0, 100.0, 190.0, 280.0, 281.0], true, Decision::Programme),
        // Contacts: all on one side, two, two opposite ones, one, none.
        (&[10.0, 60.0, 110.0], false, Decision::Signs),
        (&[10.0, 60.0, 110.0, 185.0], false, Decision::Programme),
        (&[0.0, 120.0], false, Decision::Programme),
        (&[0.0, 180.0], false, Decision::Rank),
        (&[45.0], false, Decision::Rank),
        (&[], false, Decision::Rank),
        // On the boundary: two opposite contacts and others on one side.
        (&[0.0, 180.0, 90.0], false, Decision::Signs),
        (&[0.0, 180.0, 90.0, 80.0], false, Decision::Programme),
        (&[0.0, 180.0, 90.0, 90.0], false, Decision::Programme),
    ] {
        let u = fixed_tips(directions);
        for closure in [decide_form_closure(&u), decide_by_linear_program(&u)] {
            let closure = closure.unwrap_or_else(|error| panic!("{directions:?}: {error}"));
            assert_eq!(closure.closed, closed, "{directions:?}");
            check_certificate(&u, &closure);
        }
        assert_eq!(decide_form_closure(&u).unwrap().decision, decision, "{directions:?}");
    }
}

#[test]
fn subsets_of_the_gripper_are_not_closed_and_a_third_finger_is_allowed() {
    let Grasp { finger, end, .. } = grasp(&design_95()).unwrap();
    let symmetric = Hand::symmetric(&finger, &end);
    let right = FingerGrip::with_both_contacts(&finger, &end, Side::Right);
    let variants = [
        ("one finger", Hand { fingers: vec![right], palm: true }, [3, 1, 2]),
        ("one finger, no palm", Hand { fingers: vec![right], palm: false }, [2, 1, 2]),
        ("no palm", Hand { palm: false, ..symmetric.clone() }, [4, 2, 4]),
        (
            "tips only",
            {
                let tips = symmetric.fingers.iter().map(|grip| FingerGrip { proximal: None, ..*grip });
                Hand { fingers: tips.collect(), palm: true }
            },
            [3, 2, 4],
        ),
        (
            "one backdrivable motor",
            {
                let fingers = vec![symmetric.fingers[0], FingerGrip { backdrivable: true, ..symmetric.fingers[1] }];
                Hand { fingers, palm: true }
            },
            [5, 1, 4],
        ),
        ("palm only", Hand { fingers: Vec::new(), palm: true }, [1, 0, 0]),
    ];
    for (name, hand, [contacts, motors, freedoms]) in variants {
        let u = unilateral(&hand).unwrap();
        let form_closure = decide_form_closure(&u).unwrap();
        assert!(!form_closure.closed, "{name}");
        check_certificate(&u, &form_closure);
        let count = form_closure.necessary;
        assert_eq!([count.contacts, count.motors, count.hand, count.object], [contacts, motors, freedoms, 2], "{name}");
        assert!(!count.is_met(), "{name}");
    }
    let count = decide_form_closure(&unilateral(&symmetric).unwrap()).unwrap().necessary;
    assert_eq!([count.contacts, count.motors, count.hand, count.object], [5, 2, 4, 2]);
    assert!(count.is_met());

    // A redundant third finger requires the linear programmes.
    let mut three = symmetric.clone();
    three.fingers.push(right);
    let u = unilateral(&three).unwrap();
    let form_closure = decide_form_closure(&u).unwrap();
    assert_eq!(
        (form_closure.closed, form_closure.decision, u.rows.len(), u.unknowns.len()),
        (true, Decision::Programme, 10, 8)
    );
    check_certificate(&u, &form_closure);
}

#[test]
fn necessary_count_is_not_sufficient() {
    let open = grid(THIRDS).into_iter().find(|grasp| !closure(grasp).closed).unwrap();
    let form_closure = closure(&open);
    assert!(form_closure.necessary.is_met() && form_closure.rank == 6 && form_closure.margin.unwrap() < 0.0);
}
