//! The table as Markdown, for the documentation.

use serde_json::Value;

use super::bounds::{DiscBounds, FingerBounds, GripperBounds};
use super::disc::DiscKeys;
use super::drive::{BoughtMotor, Motor, Springs};
use super::engine::Engine;
use super::finger::{Material, Object, Start};
use super::gripper::{Grasped, Seesaw, Support};
use super::half_plane::Ground;
use super::integrator::Integrator;
use super::law::{Contact, Elastic, Limit};
use super::log::LogRates;
use super::motion::{MoveKeys, PathKeys, VibrationKeys};
use super::top::{BodiesKeys, FingerKeys, GripperKeys};
use super::{Field, Table, default, range};
use crate::gripper::{BodyOverride, Design, Lengths};
use crate::law::FrictionLaw;
use crate::scene::check::ANY;
use crate::units::Dimension;

/// Every section of the table with its keys.
pub fn markdown() -> String {
    [
        section::<FingerKeys>("Before the sections of a finger"),
        section::<BodiesKeys>("Before the sections of a scene of discs"),
        section::<GripperKeys>(
            "Before the sections of a gripper, besides `half_width`, `assembly`, `sizing` and `closing_time`",
        ),
        section::<Design>("`[design]`"),
        section::<Lengths>("`[lengths]`"),
        section::<Material>("`[material]`"),
        section::<BodyOverride>("`[bodies.NAME]`, of `l11`, `l12`, `l21` and `l22`"),
        section::<Object>("`[object]`"),
        section::<Motor>("`[motor]`"),
        section::<Springs>("`[spring]`"),
        section::<Start>("`[initial]`"),
        section::<DiscKeys>("`[discs.NAME]` of a scene of discs"),
        section::<Ground>("`[half_plane]` of a scene of discs"),
        section::<Grasped>("`[object]` of a gripper"),
        section::<Support>("`[table]` of a gripper"),
        section::<Seesaw>("`[differential]` of a gripper"),
        section::<BoughtMotor>("`[motor]` of a gripper"),
        section::<MoveKeys>("`[moves.NAME]` of a gripper"),
        section::<VibrationKeys>("`[vibrations.NAME]` of a gripper"),
        section::<PathKeys>("`[path]` of a gripper"),
        section::<Integrator>("`[integrator]`"),
        section::<Engine>("`[engine]`"),
        section::<FingerBounds>("`[validate]`"),
        section::<DiscBounds>("`[validate]` of a scene of discs"),
        section::<GripperBounds>("`[validate]` of a gripper"),
        section::<LogRates>("`[log]`"),
        section::<Contact>("`[contact]`"),
        section::<FrictionLaw>("`[contact.friction]`"),
        section::<Elastic>("`[contact.materials.object]` and `.phalanx`"),
        section::<Limit>("`[limit]`"),
    ]
    .join("\n")
}

fn section<T: Table>(title: &str) -> String {
    let rows: String = T::LINES.iter().map(|line| row(*line)).collect();
    let doc = escaped(T::DOC);
    format!("{title}: {doc}\n\n| key | default | allowed | what it is |\n|---|---|---|---|\n{rows}")
}

fn row<T: Table>(line: &dyn Field<T>) -> String {
    let about = line.about();
    let default = match default(line) {
        Some(Value::String(text)) => text,
        Some(value) => value.to_string(),
        None => about.needed.map_or("", |_| "required").to_string(),
    };
    // Quantities are said by their unit.
    let kind = line.kind();
    let quantity = kind["items"].get("x-units").or(kind.get("x-units")).and_then(|units| units[0].as_str());
    let dimension = Dimension::ALL.into_iter().find(|dimension| Some(dimension.units()[0].name) == quantity);
    let allowed = match dimension {
        Some(dimension) if about.allowed.text == ANY.text => dimension.name().to_string(),
        Some(dimension) => format!("{} {}", dimension.name(), about.allowed.text),
        None => range(line),
    };
    format!("| `{}` | {default} | {allowed} | {} |\n", about.key, escaped(about.doc))
}

/// Sections are no links.
fn escaped(doc: &str) -> String {
    doc.trim_start().replace('[', "\\[")
}
