//! A finger, in sections whose names begin with `path`.

use super::super::table::drive::{Motor, Shaft, Springs};
use super::super::table::finger::{LengthKeys, Links, Start};
use super::super::table::law::Limit;
use super::super::table::object::Object;
use super::super::table::{Table, show as show_table, show_keys};
use super::super::{self as scene, DrivenFinger};
use super::law::contact;
use super::out::Out;
use crate::gripper::{Body, BodyOverride, Finger};

/// What stands before the sections of a finger; what a sizing came to is shown in its place.
pub fn links(out: &mut Out, finger: &Finger) {
    let half_width_m = finger.lengths.half_width_m;
    let links = Links { half_width_m, assembly: finger.assembly, closing_s: f64::NAN, ..Links::usual() };
    show_keys(out, &links, |_| true);
}

/// All sections of a finger; of one that is alone with its object.
pub fn finger(out: &mut Out, path: &str, finger: &DrivenFinger, object: Option<Object>, has_motor: bool) {
    bodies(out, path, &finger.linkage);
    object.iter().for_each(|object| self::object(out, object));
    if has_motor {
        motor(out, path, &finger.motor, finger.motor.inertia_kg_m2);
    }
    show_table(out, &format!("{path}spring"), &Springs::of(finger.spring));
    let limit = finger.limit.map_or(Limit::OFF, |law| Limit { enabled: true, law });
    show_table(out, &format!("{path}limit"), &limit);
    contact(out, &format!("{path}contact.proximal"), &finger.contact.proximal);
    contact(out, &format!("{path}contact.distal"), &finger.contact.distal);
    show_table(out, &format!("{path}initial"), &Start { offset_rad: None, joints: finger.initial });
}

/// What fingers grasp.
pub fn object(out: &mut Out, object: &Object) {
    out.section("object");
    show_keys(out, object, |key| Object::HEADING.contains(&key));
    show_keys(out, &object.shape, |_| true);
    show_keys(out, object, |key| !Object::HEADING.contains(&key));
}

fn bodies(out: &mut Out, path: &str, finger: &Finger) {
    show_table(out, &format!("{path}lengths"), &LengthKeys { links: finger.lengths, ..LengthKeys::usual() });
    let bodies = &finger.bodies;
    for (key, body) in [("l11", &bodies.l11), ("l12", &bodies.l12), ("l21", &bodies.l21), ("l22", &bodies.l22)] {
        let Body { mass_kg, com_m, inertia_kg_m2 } = *body;
        let whole = BodyOverride { mass_kg: Some(mass_kg), com_m: Some(com_m), inertia_kg_m2: Some(inertia_kg_m2) };
        show_table(out, &format!("{path}bodies.{key}"), &whole);
    }
}

/// A motor; what turns with it is `inertia_kg_m2`.
pub fn motor(out: &mut Out, path: &str, motor: &scene::Motor, inertia_kg_m2: f64) {
    show_table(out, &format!("{path}motor"), &Motor::of(&motor.actuation));
    show_keys(out, &Shaft::of(motor, inertia_kg_m2), |_| true);
}
