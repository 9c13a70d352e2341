//! Form closure: counts of the thesis; agreement of signs, linear programmes and statics; certificates of both kinds;
//! comparison with mirror images and with gaps and drives of displaced bodies.

use crate::support::designs::{THIRDS, design_95, sweep_designs};
use crate::support::statics::{
    Grasp, Random, check_certificate, frames, grasp, mirrored_configuration as mirrored, rates,
    symmetric_configuration as symmetric,
};
use phalanx::gripper::FingerContact;
use phalanx::numeric::plane::{add, dot, scale};
use phalanx::statics::{
    BOUNDARY, Blocked, Certificate, Decision, FingerGrip, FormClosure, GraspConfiguration, Hand, NecessaryCount,
    PerContact, Row, RowKind, Side, Unilateral, Unknown, decide_by_linear_program, decide_form_closure, equilibrium,
    form_closure, gripper_closure, gripper_unilateral, unilateral,
};

const RANDOM: usize = 10_000;
const ALL: PerContact<bool> = PerContact { phalanges: [[true; 2]; 2], palm: true };

fn grid(fractions: [f64; 4]) -> Vec<Grasp> {
    sweep_designs(fractions).iter().map(|design| grasp(design).expect("a design of the thesis")).collect()
}

/// Returns the designs of the sweep and random ones.
fn grid_and_random() -> impl Iterator<Item = Grasp> {
    let mut random = Random(1);
    grid(THIRDS).into_iter().chain(std::iter::repeat_with(move || random.grasp()).take(RANDOM))
}

fn closure(Grasp { finger, end, .. }: &Grasp) -> FormClosure {
    form_closure(finger, end).expect("a decision")
}

fn constraints(Grasp { finger, end, .. }: &Grasp) -> Unilateral {
    unilateral(&Hand::symmetric(finger, end)).expect("a posture that is not singular")
}

/// Returns fingers of different designs in perturbed postures around an object away from the centre. Contacts use the
/// actual normals, regardless of the gaps.
fn disturbed<'a>(random: &mut Random, [right, left]: [&'a Grasp; 2]) -> GraspConfiguration<'a> {
    let mut configurations = std::iter::repeat_with(|| random.configuration([right, left], 0.15, [4e-3, 2e-3]));
    // Some pairs of angles do not close the loop, and some are too close to a fold.
    configurations.find(|next| gripper_unilateral(next, &ALL, Blocked::Outputs).is_ok()).expect("endless")
}

fn decide_with_certificate(u: &Unilateral) -> FormClosure {
    let closure = decide_form_closure(u).expect("a decision");
    check_certificate(u, &closure);
    closure
}

fn multipliers(closure: &FormClosure) -> Option<&[f64]> {
    match &closure.certificate {
        Certificate::Multipliers { values, .. } => Some(values),
        Certificate::Motion { .. } => None,
    }
}

/// Asserts the numbers of contacts, motors and degrees of freedom of the hand in (1.19), with two of the object.
#[track_caller]
fn assert_count(count: NecessaryCount, expected: [usize; 3], is_met: bool) {
    assert_eq!([count.contacts, count.motors, count.hand], expected);
    assert_eq!((count.object, count.is_met()), (2, is_met));
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

#[test]
fn signs_agree_with_linear_programmes_and_positive_forces_without_spring_and_friction() {
    let (mut nearest, mut closed) = (f64::INFINITY, 0);
    for grasp in grid_and_random() {
        let u = constraints(&grasp);
        let (by_signs, by_program) = (decide_with_certificate(&u), decide_by_linear_program(&u).unwrap());
        assert_eq!((by_signs.decision, by_program.decision), (Decision::Signs, Decision::Programme));
        check_certificate(&u, &by_program);
        // A motor torque loads both contacts and the palm.
        let forces = equilibrium(&grasp.finger, &grasp.end, [1.0, 0.0], 0.0).unwrap();
        let is_positive = forces.f21_n > 0.0 && forces.f22_n > 0.0 && forces.pfp_n > 0.0;
        let decisions = [closure(&grasp).closed, by_signs.closed, by_program.closed];
        assert_eq!(decisions, [is_positive; 3], "{grasp:?}");
        // The multipliers are unique.
        if let Some((a, b)) = multipliers(&by_signs).zip(multipliers(&by_program)) {
            let difference = a.iter().zip(b).map(|(a, b)| (a - b).abs() / a.abs()).fold(0.0, f64::max);
            assert!(difference < 1e-6, "{a:?}\n{b:?}");
        }
        nearest = nearest.min(by_signs.margin.expect("unique multipliers").abs());
        closed += usize::from(by_signs.closed);
    }
    // Margins below the width of the boundary would be decided by rounding. All margins are at least a thousand times larger.
    assert!(nearest > 1e3 * BOUNDARY, "{nearest:e}");
    assert!(closed > 500 && closed < RANDOM / 2, "{closed} closed grasps of {RANDOM}: both results must occur");
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
    let [right, left] = &Hand::symmetric(&finger, &end).fingers[..] else { panic!("two fingers") };
    let tips = [right, left].map(|grip| FingerGrip { proximal: None, ..*grip });
    let backdrivable = FingerGrip { backdrivable: true, ..*left };
    for (name, fingers, palm, count) in [
        ("one finger", &[*right][..], true, [3, 1, 2]),
        ("one finger, no palm", &[*right], false, [2, 1, 2]),
        ("no palm", &[*right, *left], false, [4, 2, 4]),
        ("tips only", &tips, true, [3, 2, 4]),
        ("one backdrivable motor", &[*right, backdrivable], true, [5, 1, 4]),
        ("palm only", &[], true, [1, 0, 0]),
    ] {
        let closure = decide_with_certificate(&unilateral(&Hand { fingers: fingers.to_vec(), palm }).unwrap());
        assert!(!closure.closed, "{name}");
        assert_count(closure.necessary, count, false);
    }
    let both = unilateral(&Hand { fingers: vec![*right, *left], palm: true }).unwrap();
    assert_count(decide_form_closure(&both).unwrap().necessary, [5, 2, 4], true);

    // A redundant third finger requires the linear programmes.
    let third = FingerGrip::with_both_contacts(&finger, &end, Side::Right);
    let u = unilateral(&Hand { fingers: vec![*right, *left, third], palm: true }).unwrap();
    let closure = decide_with_certificate(&u);
    assert_eq!((closure.closed, closure.decision), (true, Decision::Programme));
    assert_eq!((u.rows.len(), u.unknowns.len()), (10, 8));
}

#[test]
fn necessary_count_is_not_sufficient() {
    let open = grid(THIRDS).into_iter().find(|grasp| !closure(grasp).closed).unwrap();
    let form_closure = closure(&open);
    assert!(form_closure.necessary.is_met() && form_closure.rank == 6 && form_closure.margin.unwrap() < 0.0);
}

#[test]
fn symmetric_grasp_agrees_with_one_finger_and_its_mirror_image() {
    for grasp in grid(THIRDS) {
        let finger = closure(&grasp);
        let u = gripper_unilateral(&symmetric(&grasp), &ALL, Blocked::Outputs).expect("a posture");
        let gripper = decide_with_certificate(&u);
        assert_eq!((gripper.closed, gripper.necessary), (finger.closed, finger.necessary), "{grasp:?}");
        assert!((gripper.margin.expect("signs") - finger.margin.expect("signs")).abs() < 1e-6, "{grasp:?}");
        assert_eq!(gripper.rows, finger.rows);
        for (a, b) in multipliers(&gripper).into_iter().flatten().zip(multipliers(&finger).into_iter().flatten()) {
            assert!((a - b).abs() < 1e-5 * b, "{a} is not {b}");
        }
    }
}

#[test]
fn gaps_identify_the_contacts() {
    let grasp = grasp(&design_95()).unwrap();
    let configuration = symmetric(&grasp);
    let gaps = configuration.contact_points().expect("a posture").map(|point| point.gap_m);
    assert_eq!(gaps.map(|gap| gap <= 1e-9), ALL, "{gaps:?}");
    let lifted = GraspConfiguration {
        object: configuration.object.at([0.0, configuration.object.centre_m[1] + 1e-4]),
        ..configuration
    };
    let gaps = lifted.contact_points().expect("a posture").map(|point| point.gap_m);
    assert!((gaps.palm - 1e-4).abs() < 1e-12, "{gaps:?}");
    // The tips are above the object and stay in contact; the proximal phalanges lean away.
    assert_eq!(gaps.map(|gap| gap <= 1e-9).phalanges, [[false, true]; 2], "{gaps:?}");
}

/// A blocked input provides only one non-backdrivable drive: 4 + 1 + 1 = 6 < 7 in (1.19).
#[test]
fn differential_with_only_the_input_blocked_is_not_form_closed() {
    let grasp = grasp(&design_95()).unwrap();
    let configuration = symmetric(&grasp);
    let outputs = gripper_closure(&configuration, &ALL, Blocked::Outputs).expect("a decision");
    assert_count(outputs.necessary, [5, 2, 4], true);
    let input = decide_with_certificate(&gripper_unilateral(&configuration, &ALL, Blocked::Input).expect("a posture"));
    assert_count(input.necessary, [5, 1, 4], false);
    assert!(outputs.closed && !input.closed);
    let Certificate::Motion { values, rates, .. } = &input.certificate else { panic!("{input:?}") };
    let input_row = input.rows.iter().position(|row| *row == Row::Input).expect("an input");
    assert!(rates[input_row] >= 0.0);
    // In the free motion one finger opens, which the blocked input does not prevent.
    let two_motors = gripper_unilateral(&configuration, &ALL, Blocked::Outputs).expect("a posture");
    let motors = (0..two_motors.rows.len()).filter(|&i| RowKind::from(two_motors.rows[i]) == RowKind::Motor);
    let rates = motors.map(|index| row_rate(&two_motors, index, values));
    assert!(rates.fold(f64::INFINITY, f64::min) < -1e-3, "one motor is backdriven");
}

/// Returns the rate of a row in a motion.
fn row_rate(u: &Unilateral, index: usize, motion: &[f64]) -> f64 {
    u.row(index).iter().zip(motion).map(|(entry, w)| entry * w).sum()
}

#[test]
fn mirrored_grasps_have_equal_closure() {
    let mut random = Random(7);
    let mut closed = 0;
    for _ in 0..2000 {
        let grasps = [random.grasp(), random.grasp()];
        let configuration = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        for blocked in [Blocked::Outputs, Blocked::Input] {
            let [original, image] = [configuration, mirrored(&configuration)].map(|configuration| {
                decide_with_certificate(&gripper_unilateral(&configuration, &ALL, blocked).expect("a posture"))
            });
            assert_eq!((original.closed, original.rank), (image.closed, image.rank), "{configuration:?}");
            closed += usize::from(original.closed);
            let Some((original_values, image_values)) = multipliers(&original).zip(multipliers(&image)) else {
                continue;
            };
            let mirror_row = |row: Row| match row {
                Row::Contact { finger, site } => Row::Contact { finger: 1 - finger, site },
                Row::Motor { finger } => Row::Motor { finger: 1 - finger },
                same => same,
            };
            let index_in = |closure: &FormClosure, row: Row| {
                closure.rows.iter().position(|candidate| *candidate == row).expect("the row")
            };
            // Multipliers relative to the palm's, because each set is scaled by its own right motor.
            let palms = [original_values[index_in(&original, Row::Palm)], image_values[index_in(&image, Row::Palm)]];
            for (row, value) in original.rows.iter().zip(original_values) {
                let (a, b) = (value / palms[0], image_values[index_in(&image, mirror_row(*row))] / palms[1]);
                assert!((a - b).abs() < 1e-6 * b, "{row:?}: {a} is not {b}");
            }
        }
    }
    assert!(closed > 20, "only {closed} closed grasps");
}

/// For any contacts and both blocking modes, linear programmes agree with signs and ranks, and every certificate is valid.
#[test]
fn linear_programmes_agree_with_signs_and_ranks() {
    let mut random = Random(11);
    let (mut closed, mut decisions) = (0, Vec::new());
    for _ in 0..8000 {
        let grasps = [random.grasp(), random.grasp()];
        let configuration = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        let mut flag = || random.within(0.0, 1.0) < 0.9;
        let contacts = PerContact { phalanges: [[flag(), flag()], [flag(), flag()]], palm: flag() };
        for blocked in [Blocked::Outputs, Blocked::Input] {
            let u = gripper_unilateral(&configuration, &contacts, blocked).expect("a posture");
            let closure = decide_with_certificate(&u);
            let by_program = decide_by_linear_program(&u).expect("a decision");
            check_certificate(&u, &by_program);
            assert_eq!(closure.closed, by_program.closed, "{configuration:?} {contacts:?} {blocked:?}");
            assert!(closure.necessary.is_met() || !closure.closed, "(1.19) is necessary");
            closed += usize::from(closure.closed);
            if !decisions.contains(&closure.decision) {
                decisions.push(closure.decision);
            }
        }
    }
    assert!(closed > 50, "only {closed} closed grasps");
    assert!(decisions.contains(&Decision::Signs) && decisions.contains(&Decision::Rank), "{decisions:?}");
}

/// Rows equal central differences of the gaps of displaced bodies, at faces and at ends of phalanges, in the grasps of
/// the sweep and in disturbed ones. With the certificates, which are motions with these rates, this covers free motions.
#[test]
fn rows_are_the_rates_of_gaps_and_drives() {
    let mut random = Random(3);
    let disturbed_grasps: Vec<[Grasp; 2]> = (0..200).map(|_| [random.grasp(), random.grasp()]).collect();
    let grid = grid(THIRDS);
    let disturbed: Vec<_> = disturbed_grasps.iter().map(|[a, b]| disturbed(&mut random, [a, b])).collect();
    let mut at_ends = 0;
    for configuration in grid.iter().map(symmetric).chain(disturbed) {
        let u = gripper_unilateral(&configuration, &ALL, Blocked::Outputs).expect("a posture");
        let input = gripper_unilateral(&configuration, &ALL, Blocked::Input).expect("a posture");
        let qd = [0, 1].map(|_| [random.within(-1.0, 1.0), random.within(-1.0, 1.0)]);
        let v = [random.within(-0.03, 0.03), random.within(-0.03, 0.03)];
        let gaps = |dt: f64| {
            let object = configuration.object.at(add(configuration.object.centre_m, scale(v, dt)));
            let angles_rad = [0, 1].map(|side| add(configuration.angles_rad[side], scale(qd[side], dt)));
            let displaced = GraspConfiguration { angles_rad, object, ..configuration };
            displaced.contact_points().expect("closed").phalanges.map(|finger| finger.map(|point| point.gap_m))
        };
        const DT: f64 = 1e-6;
        let (before, after) = (gaps(-DT), gaps(DT));
        let tip_rate = |finger: usize| {
            let by_angle =
                rates(configuration.fingers[finger], configuration.angles_rad[finger], |[_, _, l21, l22]| {
                    [l22.angle_rad - l21.angle_rad]
                });
            by_angle[0][0] * qd[finger][0] + by_angle[1][0] * qd[finger][1]
        };
        let motion = u.unknowns.iter().map(|unknown| match *unknown {
            Unknown::ObjectX => v[0],
            Unknown::ObjectY => v[1],
            Unknown::Proximal { finger } => qd[finger][1],
            Unknown::Distal { finger } => tip_rate(finger),
            Unknown::Coordinate { .. } => unreachable!("a gripper"),
        });
        let motion: Vec<f64> = motion.collect();
        for (index, row) in u.rows.iter().enumerate() {
            let (actual, tolerance) = match *row {
                Row::Contact { finger, site } => {
                    let tip = usize::from(site == FingerContact::Distal);
                    // The contact point moves along a face, but is fixed at an end.
                    at_ends += usize::from(at_end(&configuration, finger, tip));
                    ((after[finger][tip] - before[finger][tip]) / (2.0 * DT), 1e-6)
                }
                Row::Palm => (v[1], 1e-6),
                Row::Motor { finger } => (qd[finger][0], 1e-4),
                Row::Input | Row::Constraint { .. } => unreachable!("outputs are blocked"),
            };
            let error = (row_rate(&u, index, &motion) - actual).abs();
            assert!(error < tolerance, "{row:?}: error {error:e}");
        }
        let last = input.rows.len() - 1;
        assert_eq!(input.rows[last], Row::Input);
        assert!((row_rate(&input, last, &motion) - 0.5 * (qd[0][0] + qd[1][0])).abs() < 1e-4);
    }
    assert!(at_ends > 20, "{at_ends} contacts at ends of phalanges: both kinds must occur");
}

/// Returns whether the contact is at an end of a phalanx: the normal is then not perpendicular to it.
fn at_end(configuration: &GraspConfiguration<'_>, side: usize, tip: usize) -> bool {
    let hand = configuration.hand(&ALL).expect("a posture");
    let finger = configuration.fingers[side];
    let [_, _, l21, l22] = frames(finger, configuration.angles_rad[side]);
    let (contact, angle) = match tip {
        0 => (hand.fingers[side].proximal, l21.angle_rad),
        _ => (hand.fingers[side].distal, l22.angle_rad + finger.lengths.phi22_rad),
    };
    dot(contact.expect("all contacts are closed").normal, [angle.cos(), angle.sin()]).abs() > 1e-9
}
