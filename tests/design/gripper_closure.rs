//! Form closure of a gripper in any posture: comparison with one finger and its mirror image, with the mirrored gripper, with gaps of
//! displaced bodies, and between both decision methods.

use crate::support::designs::{THIRDS, design_95, sweep_designs};
use crate::support::statics::{
    Grasp, Random, check_certificate, grasp, mirrored_configuration as mirrored, symmetric_configuration as symmetric,
};
use phalanx::gripper::{FingerContact, close_loop};
use phalanx::statics::{
    Blocked, Certificate, Decision, FormClosure, GraspConfiguration, PerContact, Row, RowKind, Unilateral, Unknown,
    decide_by_linear_program, decide_form_closure, form_closure, gripper_closure, gripper_unilateral,
};

const ALL: PerContact<bool> = PerContact { phalanges: [[true; 2]; 2], palm: true };

/// Returns fingers of different designs in perturbed postures around an object away from the centre. Contacts use the actual normals,
/// regardless of the gaps.
fn disturbed<'a>(random: &mut Random, [right, left]: [&'a Grasp; 2]) -> GraspConfiguration<'a> {
    loop {
        let mut angles = |Grasp { end, .. }: &Grasp| {
            [end.posture.q11_rad, end.posture.q21_rad].map(|angle| angle + random.within(-0.15, 0.15))
        };
        let angles_rad = [angles(right), angles(left)];
        let configuration = GraspConfiguration {
            fingers: [&right.finger, &left.finger],
            angles_rad,
            palm_width_m: -right.disc.centre_m[0] - left.disc.centre_m[0],
            object: right.disc.at([random.within(-4e-3, 4e-3), right.disc.centre_m[1] + random.within(-2e-3, 2e-3)]),
        };
        // Some pairs of angles do not close the loop, and some are too close to a fold.
        if gripper_unilateral(&configuration, &ALL, Blocked::Outputs).is_ok() {
            return configuration;
        }
    }
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

#[test]
fn symmetric_grasp_agrees_with_one_finger_and_its_mirror_image() {
    let mut closed = 0;
    for design in sweep_designs(THIRDS) {
        let grasp = grasp(&design).expect("a design of the thesis");
        let symmetric_finger = form_closure(&grasp.finger, &grasp.end).expect("a decision");
        let u = gripper_unilateral(&symmetric(&grasp), &ALL, Blocked::Outputs).expect("a posture");
        let gripper = decide_with_certificate(&u);
        assert_eq!(gripper.closed, symmetric_finger.closed, "{design:?}");
        assert_eq!(gripper.necessary, symmetric_finger.necessary);
        assert!((gripper.margin.expect("signs") - symmetric_finger.margin.expect("signs")).abs() < 1e-6, "{design:?}");
        let rows: Vec<Row> = symmetric_finger.rows.iter().map(|row| *row).collect();
        assert_eq!(gripper.rows, rows);
        for (a, b) in
            multipliers(&gripper).into_iter().flatten().zip(multipliers(&symmetric_finger).into_iter().flatten())
        {
            assert!((a - b).abs() < 1e-5 * b, "{a} is not {b}");
        }
        closed += usize::from(gripper.closed);
    }
    assert_eq!(closed, 22);
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
    let count = outputs.necessary;
    assert_eq!([count.contacts, count.motors, count.hand, count.object], [5, 2, 4, 2]);
    assert!(count.is_met() && outputs.closed);

    let u = gripper_unilateral(&configuration, &ALL, Blocked::Input).expect("a posture");
    let input = decide_with_certificate(&u);
    let count = input.necessary;
    assert_eq!([count.contacts, count.motors, count.hand, count.object], [5, 1, 4, 2]);
    assert!(!count.is_met() && !input.closed);
    let Certificate::Motion { rates, .. } = &input.certificate else { panic!("{input:?}") };
    let input_row = input.rows.iter().position(|row| *row == Row::Input).expect("an input");
    assert!(rates[input_row] >= 0.0);
    // In the free motion one finger opens, which the blocked input does not prevent.
    let two_motors = gripper_unilateral(&configuration, &ALL, Blocked::Outputs).expect("a posture");
    let Certificate::Motion { values, .. } = &input.certificate else { panic!("{input:?}") };
    let motor = |index: usize| values.iter().zip(two_motors.row(index)).map(|(w, u)| w * u).sum::<f64>();
    let motors = (0..two_motors.rows.len()).filter(|&i| RowKind::from(two_motors.rows[i]) == RowKind::Motor).map(motor);
    assert!(motors.fold(f64::INFINITY, f64::min) < -1e-3, "one motor is backdriven");
}

#[test]
fn mirrored_grasps_have_equal_closure() {
    let mut random = Random(7);
    let mut closed = 0;
    for _ in 0..2000 {
        let grasps = [random.grasp(), random.grasp()];
        let configuration = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        for blocked in [Blocked::Outputs, Blocked::Input] {
            let [original, mirrored_closure] = [configuration, mirrored(&configuration)].map(|configuration| {
                decide_with_certificate(&gripper_unilateral(&configuration, &ALL, blocked).expect("a posture"))
            });
            let decisions = [&original, &mirrored_closure].map(|closure| (closure.closed, closure.rank));
            assert_eq!(decisions[0], decisions[1], "{configuration:?}");
            closed += usize::from(original.closed);
            let Some((original_values, mirrored_values)) = multipliers(&original).zip(multipliers(&mirrored_closure))
            else {
                continue;
            };
            let mirror_row = |row: Row| match row {
                Row::Contact { finger, site } => Row::Contact { finger: 1 - finger, site },
                Row::Motor { finger } => Row::Motor { finger: 1 - finger },
                same => same,
            };
            // Multipliers relative to the palm's, because each set is scaled by its own right motor.
            let palm = |closure: &FormClosure, values: &[f64]| {
                values[closure.rows.iter().position(|row| *row == Row::Palm).expect("a palm")]
            };
            for (row, value) in original.rows.iter().zip(original_values) {
                let index = mirrored_closure
                    .rows
                    .iter()
                    .position(|candidate| *candidate == mirror_row(*row))
                    .expect("the mirrored row");
                let (a, b) = (
                    value / palm(&original, original_values),
                    mirrored_values[index] / palm(&mirrored_closure, mirrored_values),
                );
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

/// Rows equal central differences of the gaps of displaced bodies, at faces and at ends of phalanges.
#[test]
fn rows_are_the_rates_of_gaps_and_drives() {
    let mut random = Random(3);
    let mut at_ends = 0;
    for _ in 0..200 {
        let grasps = [random.grasp(), random.grasp()];
        let configuration = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        let u = gripper_unilateral(&configuration, &ALL, Blocked::Outputs).expect("a posture");
        let input = gripper_unilateral(&configuration, &ALL, Blocked::Input).expect("a posture");
        let ([qd11, qd21], [vx, vy]) = (
            [0, 1].map(|_| [random.within(-1.0, 1.0), random.within(-1.0, 1.0)]),
            [random.within(-0.03, 0.03), random.within(-0.03, 0.03)],
        );
        let displaced = |dt: f64| {
            let [x, y] = configuration.object.centre_m;
            let angles = |side: usize| {
                let [q11, q21] = configuration.angles_rad[side];
                [q11 + qd11[side] * dt, q21 + qd21[side] * dt]
            };
            GraspConfiguration {
                angles_rad: [angles(0), angles(1)],
                object: configuration.object.at([x + vx * dt, y + vy * dt]),
                ..configuration
            }
        };
        let dt = 1e-6;
        let [before, after] = [displaced(-dt), displaced(dt)];
        let tip_angle = |configuration: &GraspConfiguration<'_>, side: usize| {
            let [q11, q21] = configuration.angles_rad[side];
            close_loop(&configuration.fingers[side].lengths, configuration.fingers[side].assembly, q11, q21)
                .expect("closed")
                .q22_rad
        };
        let rate = |value: &dyn Fn(&GraspConfiguration<'_>) -> f64| (value(&after) - value(&before)) / (2.0 * dt);
        let motion: Vec<f64> = u
            .unknowns
            .iter()
            .map(|unknown| match *unknown {
                Unknown::ObjectX => vx,
                Unknown::ObjectY => vy,
                Unknown::Proximal { finger } => qd21[finger],
                Unknown::Distal { finger } => rate(&|configuration| tip_angle(configuration, finger)),
            })
            .collect();
        let by_row = |u: &Unilateral, index: usize| -> f64 {
            u.row(index).iter().zip(&motion).map(|(entry, w)| entry * w).sum()
        };
        for (index, row) in u.rows.iter().enumerate() {
            let actual = match *row {
                Row::Contact { finger, site } => {
                    let tip = usize::from(site == FingerContact::Distal);
                    // The contact point moves along a face, but is fixed at an end.
                    at_ends += usize::from(at_end(&configuration, finger, tip));
                    rate(&|configuration| configuration.contact_points().expect("closed").phalanges[finger][tip].gap_m)
                }
                Row::Palm => vy,
                Row::Motor { finger } => qd11[finger],
                Row::Input => unreachable!("outputs are blocked"),
            };
            let error = (by_row(&u, index) - actual).abs();
            assert!(
                error < 1e-5 * if RowKind::from(*row) == RowKind::Motor { 10.0 } else { 0.1 },
                "{row:?}: error {error:e}"
            );
        }
        let last = input.rows.len() - 1;
        assert_eq!(input.rows[last], Row::Input);
        assert!((by_row(&input, last) - 0.5 * (qd11[0] + qd11[1])).abs() < 1e-4);
    }
    assert!(at_ends > 20, "{at_ends} contacts at ends of phalanges: both kinds must occur");
}

/// Returns whether the contact is at an end of a phalanx: the normal is then not perpendicular to it.
fn at_end(configuration: &GraspConfiguration<'_>, side: usize, tip: usize) -> bool {
    let hand = configuration.hand(&ALL).expect("a posture");
    let grip = &hand.fingers[side];
    let (contact, angle) = match tip {
        0 => (grip.proximal, grip.posture.q21_rad),
        _ => (grip.distal, grip.posture.q21_rad + grip.posture.q22_rad + grip.finger.lengths.phi22_rad),
    };
    let [x, y] = contact.expect("all contacts are closed").normal;
    (x * angle.cos() + y * angle.sin()).abs() > 1e-9
}
