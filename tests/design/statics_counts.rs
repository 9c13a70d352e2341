//! Number of the 192 designs that hold their object, with motor and spring sized for the rigid phase (2-design §2.6).

use crate::support::designs::{THIRDS, sweep_designs};
use crate::support::statics::{constant_spring, grasp};
use phalanx::sizing::{Rule, Sizing, Task, size};
use phalanx::statics::{drive_loads, equilibrium, form_closure};

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
    // No design is decided by rounding.
    println!("the smallest force of all designs is {nearest:.3} N");
    assert!(nearest > 1e-3, "{nearest}");
}
