//! Form closure: the counts of the thesis, the linear programmes against the signs, certificates.

mod gripper_support;

use gripper_support::{THIRDS, sweep};
use phalanx::gripper::*;
use phalanx::statics::*;

fn finger(design: &Design) -> Option<(Finger, FinalPosture)> {
    let lengths = lengths(design).ok()?;
    let finger = Finger { lengths, bodies: bodies(&lengths, 1070.0, 0.04).ok()?, assembly: Assembly::Reference };
    let end = final_posture(&lengths, Assembly::Reference, disc(design)).ok()?;
    Some((finger, end))
}

#[test]
fn scratch() {
    let all = sweep(THIRDS);
    let t = std::time::Instant::now();
    let n = all
        .iter()
        .filter(|d| {
            let (f, e) = finger(d).unwrap();
            form_closure(&f, &e).unwrap().closed
        })
        .count();
    println!("{n} closed {:?}", t.elapsed() / 192);
    let us: Vec<_> = all.iter().map(|d| finger(d).unwrap()).collect();
    let t = std::time::Instant::now();
    for (f, e) in &us {
        std::hint::black_box(form_closure(f, e).unwrap());
    }
    println!("direct {:?}", t.elapsed() / 192);
    let t = std::time::Instant::now();
    let n = us
        .iter()
        .filter(|(f, e)| decide_by_program(&unilateral(&Hand::symmetric(f, e)).unwrap()).unwrap().closed)
        .count();
    println!("programme {:?} {n}", t.elapsed() / 192);
    let (f, e) = &us[94];
    for mu in [0.0, 0.8] {
        println!(
            "{:?}",
            equilibrium(
                f,
                e,
                drive_loads(
                    f,
                    e,
                    0.48,
                    Some(&Spring {
                        kind: SpringKind::Constant { torque_n_m: 0.1326 },
                        placement: Placement::Phalanges
                    })
                )
                .unwrap(),
                mu
            )
        );
        println!(
            "sized {:?}",
            equilibrium(
                f,
                e,
                drive_loads(
                    f,
                    e,
                    0.5165,
                    Some(&Spring {
                        kind: SpringKind::Constant { torque_n_m: 0.11772 },
                        placement: Placement::Phalanges
                    })
                )
                .unwrap(),
                mu
            )
        );
        println!("{}", palm_force(e, 23.609, 8.2573, mu));
    }
    println!("{:?}", birglen(f, e, [0.48 - 0.1326, 0.1326], 0.0));
    println!("{:#?}", form_closure(f, e));
    println!("{:#?}", decide_by_program(&unilateral(&Hand::symmetric(f, e)).unwrap()));
    println!("{:#?}", form_closure(&us[0].0, &us[0].1));
    println!("{:#?}", decide_by_program(&unilateral(&Hand::symmetric(&us[0].0, &us[0].1)).unwrap()));
    println!("{:?}", us[94].1);
}
