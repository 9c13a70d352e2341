//! All settings as Markdown tables for the documentation.

use serde_json::Value;

use super::bounds::Bounds;
use super::criteria::Thresholds;
use super::describe_range;
use super::differential::DifferentialSettings;
use super::disc::DiscSettings;
use super::drive::{MotorSettings, ShaftSettings, SpringSettings};
use super::engine::Engine;
use super::finger::{FingerSettings, InitialSettings, LengthSettings, MaterialSettings};
use super::integrator::Integrator;
use super::law::{ContactSettings, LimitSettings, SurfaceSettings};
use super::log::LogRates;
use super::motion::{MoveSettings, PathSettings, VibrationSettings};
use super::object::ObjectSettings;
use super::plane::{HalfPlaneSettings, TableSettings};
use super::scene::SceneSettings;
use super::section::{DynSection, FieldInfo, SettingsSection, default_value, fields_for};
use crate::gripper::{BodyOverride, Design};
use crate::law::FrictionLaw;
use crate::scene::check::ANY;
use crate::scene::keywords::SceneKind::{self, Bodies, Finger, Gripper};
use crate::shape::Shape;
use crate::units::Dimension;

/// Returns a table for every section, with a row for each of its keys.
pub fn markdown() -> String {
    [
        section::<SceneSettings>("Top level of a scene of a finger", Finger) + &rows::<FingerSettings>(Finger),
        section::<SceneSettings>("Top level of a scene of discs", Bodies),
        section::<SceneSettings>(
            "Top level of a scene of a gripper, in addition to `half_width`, `assembly`, `sizing` and `closing_time`",
            Gripper,
        ),
        section::<Design>("`[design]`", Finger),
        section::<LengthSettings>("`[lengths]`", Finger),
        section::<MaterialSettings>("`[material]`", Finger),
        section::<BodyOverride>("`[bodies.NAME]`, with `NAME` = `l11`, `l12`, `l21` or `l22`", Finger),
        section_with_shape::<ObjectSettings>("`[object]`", Finger),
        section::<MotorSettings>("`[motor]`", Finger),
        section::<SpringSettings>("`[spring]`", Finger),
        section::<InitialSettings>("`[initial]`", Finger),
        section_with_shape::<DiscSettings>("`[discs.NAME]` of a scene of discs", Bodies),
        section::<HalfPlaneSettings>("`[half_plane]` of a scene of discs", Bodies),
        section_with_shape::<ObjectSettings>("`[object]` of a gripper", Gripper),
        section::<TableSettings>("`[table]` of a gripper", Gripper),
        section::<DifferentialSettings>("`[differential]` of a gripper", Gripper),
        section::<MotorSettings>("`[motor]` of a gripper", Gripper) + &rows::<ShaftSettings>(Gripper),
        section::<MoveSettings>("`[moves.NAME]` of a gripper", Gripper),
        section::<VibrationSettings>("`[vibrations.NAME]` of a gripper", Gripper),
        section::<PathSettings>("`[path]` of a gripper", Gripper),
        section::<Integrator>("`[integrator]`", Finger),
        section::<Engine>("`[engine]`", Finger),
        section::<Bounds>("`[validate]`", Finger),
        section::<Bounds>("`[validate]` of a scene of discs", Bodies),
        section::<Bounds>("`[validate]` of a gripper", Gripper),
        section::<Thresholds>("`[criteria]` of a gripper", Gripper),
        section::<LogRates>("`[log]`", Finger),
        section::<ContactSettings>("`[contact]`", Finger),
        section::<FrictionLaw>("`[contact.friction]`", Finger),
        section::<SurfaceSettings>("`[contact.materials.object]` and `.phalanx`", Finger),
        section::<LimitSettings>("`[limit]`", Finger),
    ]
    .join("\n")
}

fn section<T: SettingsSection>(title: &str, kind: SceneKind) -> String {
    head::<T>(title, kind) + &rows::<T>(kind)
}

/// Formats a section that also has the keys of a shape.
fn section_with_shape<T: SettingsSection>(title: &str, kind: SceneKind) -> String {
    head::<T>(title, kind) + &rows::<Shape>(kind) + &rows::<T>(kind)
}

fn head<T: SettingsSection>(title: &str, kind: SceneKind) -> String {
    let doc = escape(T::doc(kind));
    format!("{title}: {doc}\n\n| key | default | allowed | description |\n|---|---|---|---|\n")
}

fn rows<T: SettingsSection>(kind: SceneKind) -> String {
    let mut defaults = T::defaults_for(kind);
    fields_for(&defaults, kind).into_iter().map(|field| row(&mut defaults, field)).collect()
}

fn row(defaults: &mut dyn DynSection, (index, field): (usize, &dyn FieldInfo)) -> String {
    let metadata = field.metadata();
    let default = match default_value(defaults, (index, field)) {
        Some(Value::String(text)) => text,
        Some(value) => value.to_string(),
        None => metadata.required.map_or("", |_| "required").to_string(),
    };
    // The unit identifies the dimension.
    let schema = field.value_schema();
    let unit = schema["items"].get("x-units").or(schema.get("x-units")).and_then(|units| units[0].as_str());
    let dimension = Dimension::ALL.into_iter().find(|dimension| Some(dimension.units()[0].name) == unit);
    let allowed = match dimension {
        Some(dimension) if metadata.allowed.text == ANY.text => dimension.name().to_string(),
        Some(dimension) => format!("{} {}", dimension.name(), metadata.allowed.text),
        None => describe_range(field),
    };
    format!("| `{}` | {default} | {allowed} | {} |\n", metadata.key, escape(metadata.doc))
}

/// Escapes brackets: names of sections are not links.
fn escape(doc: &str) -> String {
    doc.trim_start().replace('[', "\\[")
}
