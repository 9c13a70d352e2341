//! Writes the sections of the simulated system.

use std::collections::BTreeMap;

use super::super::table::differential::DifferentialSettings;
use super::super::table::disc::DiscSettings;
use super::super::table::motion::{MoveSettings, PathSettings, VibrationSettings};
use super::super::table::object::ObjectSettings;
use super::super::table::plane::{HalfPlaneSettings, TableSettings};
use super::super::table::scene::{HEADING, SceneSettings};
use super::super::table::{SettingsSection, show as show_table, show_keys};
use super::super::{Differential, PalmMotion, System};
use super::finger::{write_finger, write_links, write_motor, write_object};
use super::law::write_contact;
use super::toml_writer::TomlWriter;

pub fn write_system(out: &mut TomlWriter, top: &SceneSettings, system: &System) {
    let are_fingers_equal = system.fingers.windows(2).all(|pair| pair[0] == pair[1]);
    let common_finger = system.fingers.first().filter(|_| are_fingers_equal);
    show_keys(out, top, |key| HEADING.contains(&key));
    common_finger.iter().for_each(|finger| write_links(out, &finger.linkage));
    show_keys(out, top, |key| !HEADING.contains(&key));
    match system.fingers.len() {
        0 => write_discs(out, system),
        1 => {}
        _ => write_gripper_sections(out, system),
    }
    let object = system.object().map_or(ObjectSettings::NONE, ObjectSettings::from_disc);
    let single_object = (system.fingers.len() == 1).then_some(object);
    let has_motor = system.differential.is_none();
    match common_finger {
        Some(finger) => write_finger(out, "", finger, single_object, has_motor),
        None => system.fingers_by_side().for_each(|(side, finger)| {
            out.section(side.name());
            write_links(out, &finger.linkage);
            write_finger(out, &format!("{}.", side.name()), finger, None, has_motor);
        }),
    }
    if system.fingers.len() > 1 {
        for (path, plane) in [("contact.palm", system.palm), ("contact.table", system.table)] {
            plane.and_then(|plane| plane.contact).iter().for_each(|law| write_contact(out, path, law));
        }
    }
    system.palm_motion.iter().for_each(|motion| write_palm_motion(out, motion));
}

fn write_discs(out: &mut TomlWriter, system: &System) {
    for disc in &system.discs {
        out.section(&format!("discs.{}", disc.name));
        show_keys(out, &disc.shape, |_| true);
        show_keys(out, &DiscSettings::from_disc(disc), |_| true);
    }
    if let Some(ground) = system.palm {
        show_table(out, "half_plane", &HalfPlaneSettings { level_m: ground.level_m });
    }
    system.between_discs.iter().for_each(|law| write_contact(out, "contact", law));
}

/// Writes object, table and differential of a gripper.
fn write_gripper_sections(out: &mut TomlWriter, system: &System) {
    system.object().iter().for_each(|object| write_object(out, &ObjectSettings::from_disc(object)));
    let level_m = system.table.map_or(f64::NAN, |table| table.level_m);
    show_table(out, "table", &TableSettings { present: system.table.is_some(), level_m });
    write_differential(out, system.differential.as_ref());
}

fn write_differential(out: &mut TomlWriter, differential: Option<&Differential>) {
    let Some(differential) = differential else {
        return show_table(
            out,
            "differential",
            &DifferentialSettings { present: false, ..DifferentialSettings::defaults() },
        );
    };
    let seesaw_inertia_kg_m2 = differential.seesaw_inertia_kg_m2;
    let input_inertia_kg_m2 = differential.motor.inertia_kg_m2;
    show_table(out, "differential", &DifferentialSettings { present: true, input_inertia_kg_m2, seesaw_inertia_kg_m2 });
    write_motor(out, "", &differential.motor, 0.0);
}

/// Writes moves, vibrations and path; those without a name are numbered.
fn write_palm_motion(out: &mut TomlWriter, motion: &PalmMotion) {
    let [moves, vibrations] = &motion.names;
    for (name, moves) in group_by_name(&motion.moves, moves, "m") {
        show_table(out, &format!("moves.{name}"), &MoveSettings::from_moves(&moves));
    }
    for (name, vibrations) in group_by_name(&motion.vibrations, vibrations, "v") {
        show_table(out, &format!("vibrations.{name}"), &VibrationSettings::from_vibrations(&vibrations));
    }
    motion.path.iter().for_each(|path| show_table(out, "path", &PathSettings::from_path(path)));
}

/// Groups items by name; items without a name that is valid in a header are numbered.
fn group_by_name<'a, T>(items: &'a [T], names: &[String], prefix: &str) -> BTreeMap<String, Vec<&'a T>> {
    let is_valid_in_header = |name: &&String| {
        name.starts_with(|first: char| first.is_ascii_alphabetic())
            && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
    };
    let mut groups: BTreeMap<String, Vec<&T>> = BTreeMap::new();
    for (index, item) in items.iter().enumerate() {
        let name = names.get(index).filter(is_valid_in_header).cloned();
        groups.entry(name.unwrap_or_else(|| format!("{prefix}{}", index + 1))).or_default().push(item);
    }
    groups
}
