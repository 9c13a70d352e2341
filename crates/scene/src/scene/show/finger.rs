//! Writes the sections of a finger; their names begin with `path`.

use super::super::table::drive::{MotorSettings, ShaftSettings, SpringSettings};
use super::super::table::finger::{FingerSettings, InitialSettings, LengthSettings};
use super::super::table::law::LimitSettings;
use super::super::table::object::ObjectSettings;
use super::super::table::{SettingsSection, show as show_table, show_keys};
use super::super::{self as scene, DrivenFinger};
use super::law::write_contact;
use super::toml_writer::TomlWriter;
use crate::gripper::{Body, BodyOverride, Finger};

/// Writes the keys of a finger at the top level; the results of a sizing replace the sizing.
pub fn write_links(out: &mut TomlWriter, finger: &Finger) {
    let half_width_m = finger.lengths.half_width_m;
    let settings =
        FingerSettings { half_width_m, assembly: finger.assembly, closing_s: f64::NAN, ..FingerSettings::defaults() };
    show_keys(out, &settings, |_| true);
}

/// Writes all sections of a finger, with the object for a single finger.
pub fn write_finger(
    out: &mut TomlWriter,
    path: &str,
    finger: &DrivenFinger,
    object: Option<ObjectSettings>,
    has_motor: bool,
) {
    write_bodies(out, path, &finger.linkage);
    object.iter().for_each(|object| write_object(out, object));
    if has_motor {
        write_motor(out, path, &finger.motor, finger.motor.inertia_kg_m2);
    }
    show_table(out, &format!("{path}spring"), &SpringSettings::from_spring(finger.spring));
    let limit = finger.limit.map_or(LimitSettings::OFF, |law| LimitSettings { enabled: true, law });
    show_table(out, &format!("{path}limit"), &limit);
    write_contact(out, &format!("{path}contact.proximal"), &finger.contact.proximal);
    write_contact(out, &format!("{path}contact.distal"), &finger.contact.distal);
    show_table(out, &format!("{path}initial"), &InitialSettings { offset_rad: None, joints: finger.initial });
}

/// Writes the grasped object.
pub fn write_object(out: &mut TomlWriter, object: &ObjectSettings) {
    out.section("object");
    show_keys(out, object, |key| ObjectSettings::HEADING.contains(&key));
    show_keys(out, &object.shape, |_| true);
    show_keys(out, object, |key| !ObjectSettings::HEADING.contains(&key));
}

fn write_bodies(out: &mut TomlWriter, path: &str, finger: &Finger) {
    show_table(out, &format!("{path}lengths"), &LengthSettings { links: finger.lengths, ..LengthSettings::defaults() });
    let bodies = &finger.bodies;
    for (key, body) in [("l11", &bodies.l11), ("l12", &bodies.l12), ("l21", &bodies.l21), ("l22", &bodies.l22)] {
        let Body { mass_kg, com_m, inertia_kg_m2 } = *body;
        let settings = BodyOverride { mass_kg: Some(mass_kg), com_m: Some(com_m), inertia_kg_m2: Some(inertia_kg_m2) };
        show_table(out, &format!("{path}bodies.{key}"), &settings);
    }
}

/// Writes a motor with another inertia.
pub fn write_motor(out: &mut TomlWriter, path: &str, motor: &scene::Motor, inertia_kg_m2: f64) {
    show_table(out, &format!("{path}motor"), &MotorSettings::from_actuation(&motor.actuation));
    show_keys(out, &ShaftSettings::from_motor(motor, inertia_kg_m2), |_| true);
}
