//! Form closure of a whole gripper in any posture: against that of one finger and its mirror image, against its own mirror image, against
//! bodies that are really moved, and by both ways to decide.

use crate::support::gripper::{THIRDS, design_95, sweep};
use crate::support::statics::{Grasp, Random, check, grasp};
use phalanx::gripper::{Site, close};
use phalanx::statics::{
    Blocked, Certificate, Decision, FormClosure, GripperRow, Kind, PerContact, Row, Stance, Unilateral, Unknown,
    decide, decide_by_program, form_closure, gripper_closure, gripper_unilateral,
};

const ALL: PerContact<bool> = PerContact { phalanges: [[true; 2]; 2], palm: true };

/// The final posture of a finger and its mirror image, with the object on the palm between them.
fn symmetric(Grasp { finger, disc, end }: &Grasp) -> Stance<'_> {
    Stance {
        fingers: [finger; 2],
        angles_rad: [[end.posture.q11_rad, end.posture.q21_rad]; 2],
        palm_width_m: -2.0 * disc.centre_m[0],
        object: disc.at([0.0, disc.centre_m[1]]),
    }
}

/// Fingers of different designs in postures of their own near an object that is off the middle. The phalanges that touch do so with the
/// normals they have, wherever they are.
fn disturbed<'a>(random: &mut Random, [right, left]: [&'a Grasp; 2]) -> Stance<'a> {
    loop {
        let mut angles = |Grasp { end, .. }: &Grasp| {
            [end.posture.q11_rad, end.posture.q21_rad].map(|angle| angle + random.within(-0.15, 0.15))
        };
        let angles_rad = [angles(right), angles(left)];
        let stance = Stance {
            fingers: [&right.finger, &left.finger],
            angles_rad,
            palm_width_m: -right.disc.centre_m[0] - left.disc.centre_m[0],
            object: right.disc.at([random.within(-4e-3, 4e-3), right.disc.centre_m[1] + random.within(-2e-3, 2e-3)]),
        };
        // Not every pair of angles closes the loop, and some are too near to where it folds.
        if gripper_unilateral(&stance, &ALL, Blocked::Outputs).is_ok() {
            return stance;
        }
    }
}

/// The same seen in a mirror that stands on the palm's middle.
fn mirrored<'a>(stance: &Stance<'a>) -> Stance<'a> {
    let ([right, left], [of_right, of_left]) = (stance.fingers, stance.angles_rad);
    let [x, y] = stance.object.centre_m;
    Stance { fingers: [left, right], angles_rad: [of_left, of_right], object: stance.object.at([-x, y]), ..*stance }
}

fn certified(u: &Unilateral<GripperRow>) -> FormClosure<GripperRow> {
    let found = decide(u).expect("a decision");
    check(u, &found);
    found
}

fn multipliers<R>(found: &FormClosure<R>) -> Option<&[f64]> {
    match &found.certificate {
        Certificate::Multipliers { values, .. } => Some(values),
        Certificate::Motion { .. } => None,
    }
}

#[test]
fn a_symmetric_grasp_is_closed_where_that_of_one_finger_and_its_mirror_image_is() {
    let mut closed = 0;
    for design in sweep(THIRDS) {
        let grasp = grasp(&design).expect("a design of the thesis");
        let one = form_closure(&grasp.finger, &grasp.end).expect("a decision");
        let u = gripper_unilateral(&symmetric(&grasp), &ALL, Blocked::Outputs).expect("a posture");
        let whole = certified(&u);
        assert_eq!(whole.closed, one.closed, "{design:?}");
        assert_eq!(whole.necessary, one.necessary);
        assert!((whole.margin.expect("signs") - one.margin.expect("signs")).abs() < 1e-6, "{design:?}");
        let rows: Vec<GripperRow> = one.rows.iter().map(|row| GripperRow::Hand(*row)).collect();
        assert_eq!(whole.rows, rows);
        for (a, b) in multipliers(&whole).into_iter().flatten().zip(multipliers(&one).into_iter().flatten()) {
            assert!((a - b).abs() < 1e-5 * b, "{a} is not {b}");
        }
        closed += usize::from(whole.closed);
    }
    assert_eq!(closed, 22);
}

#[test]
fn gaps_say_which_contacts_there_are() {
    let grasp = grasp(&design_95()).unwrap();
    let stance = symmetric(&grasp);
    let gaps = stance.gaps().expect("a posture");
    assert_eq!(gaps.map(|gap| gap <= 1e-9), ALL, "{gaps:?}");
    let lifted = Stance { object: stance.object.at([0.0, stance.object.centre_m[1] + 1e-4]), ..stance };
    let gaps = lifted.gaps().expect("a posture");
    assert!((gaps.palm - 1e-4).abs() < 1e-12, "{gaps:?}");
    // Tips are above it and get in its way; the proximal phalanges lean away.
    assert_eq!(gaps.map(|gap| gap <= 1e-9).phalanges, [[false, true]; 2], "{gaps:?}");
}

/// With one input blocked there is one mechanism that cannot be turned back: 4 + 1 + 1 = 6 < 7 in (1.19).
#[test]
fn a_differential_whose_input_alone_is_blocked_holds_no_object_fast() {
    let grasp = grasp(&design_95()).unwrap();
    let stance = symmetric(&grasp);
    let outputs = gripper_closure(&stance, &ALL, Blocked::Outputs).expect("a decision");
    let count = outputs.necessary;
    assert_eq!([count.contacts, count.motors, count.hand, count.object], [5, 2, 4, 2]);
    assert!(count.is_met() && outputs.closed);

    let u = gripper_unilateral(&stance, &ALL, Blocked::Input).expect("a posture");
    let input = certified(&u);
    let count = input.necessary;
    assert_eq!([count.contacts, count.motors, count.hand, count.object], [5, 1, 4, 2]);
    assert!(!count.is_met() && !input.closed);
    let Certificate::Motion { rates, .. } = &input.certificate else { panic!("{input:?}") };
    let at = input.rows.iter().position(|row| *row == GripperRow::Input).expect("an input");
    assert!(rates[at] >= 0.0);
    // In what escapes one finger goes back, which the input does not notice.
    let both = gripper_unilateral(&stance, &ALL, Blocked::Outputs).expect("a posture");
    let Certificate::Motion { values, .. } = &input.certificate else { panic!("{input:?}") };
    let motor = |index: usize| values.iter().zip(both.row(index)).map(|(w, u)| w * u).sum::<f64>();
    let motors = (0..both.rows.len()).filter(|&i| Kind::from(both.rows[i]) == Kind::Motor).map(motor);
    assert!(motors.fold(f64::INFINITY, f64::min) < -1e-3, "one gives way");
}

#[test]
fn mirror_images_are_held_alike() {
    let mut random = Random(7);
    let mut closed = 0;
    for _ in 0..2000 {
        let grasps = [random.grasp(), random.grasp()];
        let stance = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        for blocked in [Blocked::Outputs, Blocked::Input] {
            let [here, there] = [stance, mirrored(&stance)]
                .map(|stance| certified(&gripper_unilateral(&stance, &ALL, blocked).expect("a posture")));
            assert_eq!((here.closed, here.rank), (there.closed, there.rank), "{stance:?}");
            closed += usize::from(here.closed);
            let Some((here_values, there_values)) = multipliers(&here).zip(multipliers(&there)) else { continue };
            let other = |row: GripperRow| match row {
                GripperRow::Hand(Row::Contact { finger, site }) => {
                    GripperRow::Hand(Row::Contact { finger: 1 - finger, site })
                }
                GripperRow::Hand(Row::Motor { finger }) => GripperRow::Hand(Row::Motor { finger: 1 - finger }),
                same => same,
            };
            // In units of the palm's, for either is in those of its own right motor.
            let palm = |found: &FormClosure<GripperRow>, values: &[f64]| {
                values[found.rows.iter().position(|row| *row == GripperRow::Hand(Row::Palm)).expect("a palm")]
            };
            for (row, value) in here.rows.iter().zip(here_values) {
                let at = there.rows.iter().position(|found| *found == other(*row)).expect("its image");
                let (a, b) = (value / palm(&here, here_values), there_values[at] / palm(&there, there_values));
                assert!((a - b).abs() < 1e-6 * b, "{row:?}: {a} is not {b}");
            }
        }
    }
    assert!(closed > 20, "{closed} closed: both answers must be tried");
}

/// Any contacts, any of both drives: linear programmes answer as signs and ranks do, and every certificate is one.
#[test]
fn linear_programmes_decide_as_signs_and_ranks_do() {
    let mut random = Random(11);
    let (mut closed, mut ways) = (0, Vec::new());
    for _ in 0..8000 {
        let grasps = [random.grasp(), random.grasp()];
        let stance = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        let mut any = || random.within(0.0, 1.0) < 0.9;
        let touching = PerContact { phalanges: [[any(), any()], [any(), any()]], palm: any() };
        for blocked in [Blocked::Outputs, Blocked::Input] {
            let u = gripper_unilateral(&stance, &touching, blocked).expect("a posture");
            let found = certified(&u);
            let by_program = decide_by_program(&u).expect("a decision");
            check(&u, &by_program);
            assert_eq!(found.closed, by_program.closed, "{stance:?} {touching:?} {blocked:?}");
            assert!(found.necessary.is_met() || !found.closed, "(1.19) is necessary");
            closed += usize::from(found.closed);
            if !ways.contains(&found.decision) {
                ways.push(found.decision);
            }
        }
    }
    assert!(closed > 50, "{closed} closed: both answers must be tried");
    assert!(ways.contains(&Decision::Signs) && ways.contains(&Decision::Rank), "{ways:?}");
}

/// Rows against gaps of bodies that are moved, at faces and at ends of phalanges, by differences of the second order.
#[test]
fn rows_are_the_rates_of_gaps_and_drives() {
    let mut random = Random(3);
    let mut at_ends = 0;
    for _ in 0..200 {
        let grasps = [random.grasp(), random.grasp()];
        let stance = disturbed(&mut random, [&grasps[0], &grasps[1]]);
        let u = gripper_unilateral(&stance, &ALL, Blocked::Outputs).expect("a posture");
        let input = gripper_unilateral(&stance, &ALL, Blocked::Input).expect("a posture");
        let ([qd11, qd21], [vx, vy]) = (
            [0, 1].map(|_| [random.within(-1.0, 1.0), random.within(-1.0, 1.0)]),
            [random.within(-0.03, 0.03), random.within(-0.03, 0.03)],
        );
        let moved = |dt: f64| {
            let [x, y] = stance.object.centre_m;
            let turned = |side: usize| {
                let [q11, q21] = stance.angles_rad[side];
                [q11 + qd11[side] * dt, q21 + qd21[side] * dt]
            };
            Stance {
                angles_rad: [turned(0), turned(1)],
                object: stance.object.at([x + vx * dt, y + vy * dt]),
                ..stance
            }
        };
        let dt = 1e-6;
        let [before, after] = [moved(-dt), moved(dt)];
        let bend = |stance: &Stance<'_>, side: usize| {
            let [q11, q21] = stance.angles_rad[side];
            close(&stance.fingers[side].lengths, stance.fingers[side].assembly, q11, q21).expect("closed").q22_rad
        };
        let rate = |of: &dyn Fn(&Stance<'_>) -> f64| (of(&after) - of(&before)) / (2.0 * dt);
        let motion: Vec<f64> = u
            .unknowns
            .iter()
            .map(|unknown| match *unknown {
                Unknown::ObjectX => vx,
                Unknown::ObjectY => vy,
                Unknown::Proximal { finger } => qd21[finger],
                Unknown::Distal { finger } => rate(&|stance| bend(stance, finger)),
            })
            .collect();
        let by_row = |u: &Unilateral<GripperRow>, index: usize| -> f64 {
            u.row(index).iter().zip(&motion).map(|(entry, w)| entry * w).sum()
        };
        for (index, row) in u.rows.iter().enumerate() {
            let found = match *row {
                GripperRow::Hand(Row::Contact { finger, site }) => {
                    let tip = usize::from(site == Site::Distal);
                    // The nearest point of a face moves along it; that of an end does not.
                    at_ends += usize::from(at_end(&stance, finger, tip));
                    rate(&|stance| stance.gaps().expect("closed").phalanges[finger][tip])
                }
                GripperRow::Hand(Row::Palm) => vy,
                GripperRow::Hand(Row::Motor { finger }) => qd11[finger],
                GripperRow::Input => unreachable!("outputs are blocked"),
            };
            let off = (by_row(&u, index) - found).abs();
            assert!(off < 1e-5 * if Kind::from(*row) == Kind::Motor { 10.0 } else { 0.1 }, "{row:?}: off by {off:e}");
        }
        let last = input.rows.len() - 1;
        assert_eq!(input.rows[last], GripperRow::Input);
        assert!((by_row(&input, last) - 0.5 * (qd11[0] + qd11[1])).abs() < 1e-4);
    }
    assert!(at_ends > 20, "{at_ends} contacts at ends of phalanges: both kinds must be tried");
}

/// Whether the object is nearest to an end of a phalanx: the normal is not across it.
fn at_end(stance: &Stance<'_>, side: usize, tip: usize) -> bool {
    let hand = stance.hand(&ALL).expect("a posture");
    let grip = &hand.fingers[side];
    let (touch, angle) = match tip {
        0 => (grip.proximal, grip.posture.q21_rad),
        _ => (grip.distal, grip.posture.q21_rad + grip.posture.q22_rad + grip.finger.lengths.phi22_rad),
    };
    let [x, y] = touch.expect("all touch").normal;
    (x * angle.cos() + y * angle.sin()).abs() > 1e-9
}
