//! What is simulated, part by part.

use std::collections::BTreeMap;

use super::super::table::differential::Seesaw;
use super::super::table::disc::DiscKeys;
use super::super::table::motion::{MoveKeys, PathKeys, VibrationKeys};
use super::super::table::object::Object;
use super::super::table::plane::{Ground, Support};
use super::super::table::top::{HEADING, Top};
use super::super::table::{Table, show as show_table, show_keys};
use super::super::{Differential, PalmMotion, System};
use super::finger::{finger, links, motor, object as show_object};
use super::law::contact;
use super::out::Out;

pub fn system(out: &mut Out, top: &Top, system: &System) {
    let is_of_finger = system.fingers.windows(2).all(|pair| pair[0] == pair[1]);
    let of_both = system.fingers.first().filter(|_| is_of_finger);
    show_keys(out, top, |key| HEADING.contains(&key));
    of_both.iter().for_each(|finger| links(out, &finger.linkage));
    show_keys(out, top, |key| !HEADING.contains(&key));
    match system.fingers.len() {
        0 => discs(out, system),
        1 => {}
        _ => around_fingers(out, system),
    }
    let object = system.object().map_or(Object::NONE, Object::of);
    let alone = (system.fingers.len() == 1).then_some(object);
    let has_motor = system.differential.is_none();
    match of_both {
        Some(of) => finger(out, "", of, alone, has_motor),
        None => system.sided().for_each(|(side, of)| {
            out.section(side.word());
            links(out, &of.linkage);
            finger(out, &format!("{}.", side.word()), of, None, has_motor);
        }),
    }
    if system.fingers.len() > 1 {
        for (path, plane) in [("contact.palm", system.palm), ("contact.table", system.table)] {
            plane.and_then(|plane| plane.contact).iter().for_each(|law| contact(out, path, law));
        }
    }
    system.palm_motion.iter().for_each(|motion| palm_motion(out, motion));
}

fn discs(out: &mut Out, system: &System) {
    for disc in &system.discs {
        out.section(&format!("discs.{}", disc.name));
        show_keys(out, &disc.shape, |_| true);
        show_keys(out, &DiscKeys::of(disc), |_| true);
    }
    if let Some(ground) = system.palm {
        show_table(out, "half_plane", &Ground { level_m: ground.level_m });
    }
    system.between_discs.iter().for_each(|law| contact(out, "contact", law));
}

/// What both fingers grasp, and what else is there.
fn around_fingers(out: &mut Out, system: &System) {
    system.object().iter().for_each(|object| show_object(out, &Object::of(object)));
    let level_m = system.table.map_or(f64::NAN, |table| table.level_m);
    show_table(out, "table", &Support { present: system.table.is_some(), level_m });
    differential(out, system.differential.as_ref());
}

fn differential(out: &mut Out, differential: Option<&Differential>) {
    let Some(differential) = differential else {
        return show_table(out, "differential", &Seesaw { present: false, ..Seesaw::usual() });
    };
    let seesaw_inertia_kg_m2 = differential.seesaw_inertia_kg_m2;
    let input_inertia_kg_m2 = differential.motor.inertia_kg_m2;
    show_table(out, "differential", &Seesaw { present: true, input_inertia_kg_m2, seesaw_inertia_kg_m2 });
    motor(out, "", &differential.motor, 0.0);
}

/// Every part by its name, or by one of its own.
fn palm_motion(out: &mut Out, motion: &PalmMotion) {
    let [moves, vibrations] = &motion.names;
    for (name, parts) in named(&motion.moves, moves, "m") {
        show_table(out, &format!("moves.{name}"), &MoveKeys::of(&parts));
    }
    for (name, parts) in named(&motion.vibrations, vibrations, "v") {
        show_table(out, &format!("vibrations.{name}"), &VibrationKeys::of(&parts));
    }
    motion.path.iter().for_each(|path| show_table(out, "path", &PathKeys::of(path)));
}

/// Parts by their names; those without one that a header can have are numbered.
fn named<'a, T>(parts: &'a [T], names: &[String], letter: &str) -> BTreeMap<String, Vec<&'a T>> {
    let is_plain = |name: &&String| {
        name.starts_with(|first: char| first.is_ascii_alphabetic())
            && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
    };
    let mut all: BTreeMap<String, Vec<&T>> = BTreeMap::new();
    for (index, part) in parts.iter().enumerate() {
        let name = names.get(index).filter(is_plain).cloned();
        all.entry(name.unwrap_or_else(|| format!("{letter}{}", index + 1))).or_default().push(part);
    }
    all
}
