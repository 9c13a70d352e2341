//! The table as Markdown, for the documentation.

use serde_json::Value;

use super::bounds::Bounds;
use super::criteria::Thresholds;
use super::differential::Seesaw;
use super::disc::DiscKeys;
use super::drive::{Motor, Shaft, Springs};
use super::engine::Engine;
use super::finger::{LengthKeys, Links, Material, Start};
use super::integrator::Integrator;
use super::law::{Contact, Elastic, Limit};
use super::log::LogRates;
use super::motion::{MoveKeys, PathKeys, VibrationKeys};
use super::object::Object;
use super::plane::{Ground, Support};
use super::range;
use super::section::{Said, Section, Table, default, lines_of};
use super::top::Top;
use crate::gripper::{BodyOverride, Design};
use crate::law::FrictionLaw;
use crate::scene::check::ANY;
use crate::scene::words::SceneKind::{self, Bodies, Finger, Gripper};
use crate::shape::Shape;
use crate::units::Dimension;

/// Every section of the table with its keys.
pub fn markdown() -> String {
    [
        section::<Top>("Before the sections of a finger", Finger) + &rows::<Links>(Finger),
        section::<Top>("Before the sections of a scene of discs", Bodies),
        section::<Top>(
            "Before the sections of a gripper, besides `half_width`, `assembly`, `sizing` and `closing_time`",
            Gripper,
        ),
        section::<Design>("`[design]`", Finger),
        section::<LengthKeys>("`[lengths]`", Finger),
        section::<Material>("`[material]`", Finger),
        section::<BodyOverride>("`[bodies.NAME]`, of `l11`, `l12`, `l21` and `l22`", Finger),
        shaped::<Object>("`[object]`", Finger),
        section::<Motor>("`[motor]`", Finger),
        section::<Springs>("`[spring]`", Finger),
        section::<Start>("`[initial]`", Finger),
        shaped::<DiscKeys>("`[discs.NAME]` of a scene of discs", Bodies),
        section::<Ground>("`[half_plane]` of a scene of discs", Bodies),
        shaped::<Object>("`[object]` of a gripper", Gripper),
        section::<Support>("`[table]` of a gripper", Gripper),
        section::<Seesaw>("`[differential]` of a gripper", Gripper),
        section::<Motor>("`[motor]` of a gripper", Gripper) + &rows::<Shaft>(Gripper),
        section::<MoveKeys>("`[moves.NAME]` of a gripper", Gripper),
        section::<VibrationKeys>("`[vibrations.NAME]` of a gripper", Gripper),
        section::<PathKeys>("`[path]` of a gripper", Gripper),
        section::<Integrator>("`[integrator]`", Finger),
        section::<Engine>("`[engine]`", Finger),
        section::<Bounds>("`[validate]`", Finger),
        section::<Bounds>("`[validate]` of a scene of discs", Bodies),
        section::<Bounds>("`[validate]` of a gripper", Gripper),
        section::<Thresholds>("`[criteria]` of a gripper", Gripper),
        section::<LogRates>("`[log]`", Finger),
        section::<Contact>("`[contact]`", Finger),
        section::<FrictionLaw>("`[contact.friction]`", Finger),
        section::<Elastic>("`[contact.materials.object]` and `.phalanx`", Finger),
        section::<Limit>("`[limit]`", Finger),
    ]
    .join("\n")
}

fn section<T: Table>(title: &str, kind: SceneKind) -> String {
    head::<T>(title, kind) + &rows::<T>(kind)
}

/// Of what has a shape besides.
fn shaped<T: Table>(title: &str, kind: SceneKind) -> String {
    head::<T>(title, kind) + &rows::<Shape>(kind) + &rows::<T>(kind)
}

fn head<T: Table>(title: &str, kind: SceneKind) -> String {
    let doc = escaped(T::doc(kind));
    format!("{title}: {doc}\n\n| key | default | allowed | what it is |\n|---|---|---|---|\n")
}

fn rows<T: Table>(kind: SceneKind) -> String {
    let mut usual = T::usual_in(kind);
    lines_of(&usual, kind).into_iter().map(|line| row(&mut usual, line)).collect()
}

fn row(usual: &mut dyn Section, (line, said): (usize, &dyn Said)) -> String {
    let about = said.about();
    let default = match default(usual, (line, said)) {
        Some(Value::String(text)) => text,
        Some(value) => value.to_string(),
        None => about.needed.map_or("", |_| "required").to_string(),
    };
    // Quantities are said by their unit.
    let held = said.kind();
    let quantity = held["items"].get("x-units").or(held.get("x-units")).and_then(|units| units[0].as_str());
    let dimension = Dimension::ALL.into_iter().find(|dimension| Some(dimension.units()[0].name) == quantity);
    let allowed = match dimension {
        Some(dimension) if about.allowed.text == ANY.text => dimension.name().to_string(),
        Some(dimension) => format!("{} {}", dimension.name(), about.allowed.text),
        None => range(said),
    };
    format!("| `{}` | {default} | {allowed} | {} |\n", about.key, escaped(about.doc))
}

/// Sections are no links.
fn escaped(doc: &str) -> String {
    doc.trim_start().replace('[', "\\[")
}
