//! Two fingers and what they grasp.

use super::super::table::drive::BoughtMotor;
use super::super::table::gripper::{Grasped, Seesaw, Support};
use super::super::table::motion;
use super::super::table::top::{GripperKeys, HEADING, Heading};
use super::super::table::{Table as _, show as show_table, show_keys};
use super::super::{Differential, DrivenFinger, PalmMotion, Side, System};
use super::finger::{bodies, laws, show_links, spring_and_limit, start};
use super::out::Out;
use super::parts::contact;

pub fn system(to: &mut Out, heading: Heading, system: &System) {
    let keys =
        GripperKeys { heading, palm: system.palm.is_some(), palm_width_m: system.palm_width_m, ..GripperKeys::usual() };
    show_keys(to, &keys, |key| HEADING.contains(&key));
    let [right, left] = Side::BOTH.map(|side| system.finger(side));
    if right == left {
        show_links(to, &right.linkage);
    }
    show_keys(to, &keys, |key| !HEADING.contains(&key));
    system.object().iter().for_each(|object| show_table(to, "object", &Grasped::of(object)));
    let level_m = system.table.map_or(f64::NAN, |table| table.level_m);
    show_table(to, "table", &Support { present: system.table.is_some(), level_m });
    differential(to, system.differential.as_ref());
    let has_motor = system.differential.is_none();
    match right == left {
        true => finger(to, "", right, has_motor),
        false => Side::BOTH.into_iter().for_each(|side| {
            to.section(side.word());
            let of = system.finger(side);
            show_links(to, &of.linkage);
            finger(to, &format!("{}.", side.word()), of, has_motor);
        }),
    }
    for (path, plane) in [("contact.palm", system.palm), ("contact.table", system.table)] {
        plane.and_then(|plane| plane.contact).iter().for_each(|law| contact(to, path, law));
    }
    system.palm_motion.iter().for_each(|motion| palm_motion(to, motion));
}

fn differential(out: &mut Out, differential: Option<&Differential>) {
    let Some(differential) = differential else {
        let none = Seesaw { present: false, input_inertia_kg_m2: 0.0, seesaw_inertia_kg_m2: 0.0 };
        return show_table(out, "differential", &none);
    };
    let seesaw_inertia_kg_m2 = differential.seesaw_inertia_kg_m2;
    let input_inertia_kg_m2 = differential.motor.inertia_kg_m2;
    show_table(out, "differential", &Seesaw { present: true, input_inertia_kg_m2, seesaw_inertia_kg_m2 });
    show_table(out, "motor", &BoughtMotor::of(&differential.motor, 0.0));
}

fn finger(out: &mut Out, path: &str, finger: &DrivenFinger, has_motor: bool) {
    bodies(out, path, &finger.linkage);
    if has_motor {
        let motor = BoughtMotor::of(&finger.motor, finger.motor.inertia_kg_m2);
        show_table(out, &format!("{path}motor"), &motor);
    }
    spring_and_limit(out, path, finger.spring, finger.limit);
    laws(out, path, &finger.contact);
    start(out, path, finger.initial);
}

/// Every part by a name of its own.
fn palm_motion(out: &mut Out, motion: &PalmMotion) {
    for (index, one) in motion.moves.iter().enumerate() {
        show_table(out, &format!("moves.m{}", index + 1), &motion::MoveKeys::of(one));
    }
    for (index, one) in motion.vibrations.iter().enumerate() {
        show_table(out, &format!("vibrations.v{}", index + 1), &motion::VibrationKeys::of(one));
    }
    motion.path.iter().for_each(|path| show_table(out, "path", &motion::PathKeys::of(path)));
}
