//! The scene of a gripper.

use super::super::table::bounds::GripperBounds;
use super::super::table::drive::BoughtMotor;
use super::super::table::gripper::{Seesaw, Support};
use super::super::table::motion;
use super::super::table::top::{GripperKeys, HEADING};
use super::super::table::{Table as _, show as show_table, show_keys};
use super::super::words::SceneKind;
use super::super::{GripperFinger, GripperScene, PalmMotion, Side};
use super::finger::{bodies, laws, show_links, spring_and_limit, start};
use super::out::Out;
use super::parts::{contact, heading};

/// The scene with everything filled in, as a scene file that parses back to the same scene, bit for bit (its `source`
/// excepted).
pub fn show_gripper(scene: &GripperScene) -> String {
    shown(scene, Out::default())
}

pub(super) fn shown(scene: &GripperScene, mut out: Out) -> String {
    let to = &mut out;
    let heading_of = (scene.name.as_str(), scene.description.as_str(), scene.duration_s, scene.gravity_m_s2);
    let (heading, palm) = (heading(to, SceneKind::Gripper, heading_of), scene.palm.is_some());
    let keys = GripperKeys { heading, palm, palm_width_m: scene.palm_width_m, ..GripperKeys::usual() };
    show_keys(to, &keys, |key| HEADING.contains(&key));
    let [right, left] = &scene.fingers;
    if right == left {
        show_links(to, &right.finger);
    }
    show_keys(to, &keys, |key| !HEADING.contains(&key));
    show_table(to, "object", &scene.object);
    let level_m = scene.table.map_or(f64::NAN, |table| table.level_m);
    show_table(to, "table", &Support { present: scene.table.is_some(), level_m });
    differential(to, scene);
    match right == left {
        true => finger(to, "", right, scene.differential.is_none()),
        false => Side::BOTH.into_iter().for_each(|side| {
            to.section(side.word());
            let of = scene.finger(side);
            show_links(to, &of.finger);
            finger(to, &format!("{}.", side.word()), of, scene.differential.is_none());
        }),
    }
    for (path, law) in [("contact.palm", scene.palm), ("contact.table", scene.table.map(|table| table.contact))] {
        law.iter().for_each(|law| contact(to, path, law));
    }
    scene.palm_motion.iter().for_each(|motion| palm_motion(to, motion));
    show_table(to, "integrator", &scene.integrator);
    show_table(to, "engine", &scene.engine);
    // A program may have shortened the run.
    let until_s = scene.bounds.until_s.min(scene.duration_s);
    show_table(to, "validate", &GripperBounds { until_s, ..scene.bounds });
    show_table(to, "log", &scene.log);
    out.text
}

fn differential(out: &mut Out, scene: &GripperScene) {
    let Some(differential) = &scene.differential else {
        let none = Seesaw { present: false, input_inertia_kg_m2: 0.0, seesaw_inertia_kg_m2: 0.0 };
        return show_table(out, "differential", &none);
    };
    let seesaw_inertia_kg_m2 = differential.seesaw_inertia_kg_m2;
    let input_inertia_kg_m2 = differential.motor.inertia_kg_m2;
    show_table(out, "differential", &Seesaw { present: true, input_inertia_kg_m2, seesaw_inertia_kg_m2 });
    show_table(out, "motor", &BoughtMotor::of(&differential.motor, 0.0));
}

fn finger(out: &mut Out, path: &str, finger: &GripperFinger, has_motor: bool) {
    bodies(out, path, &finger.finger);
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
