//! Palm, ground and table.

use super::super::check::Checker;
use super::super::table::input::SectionInput;
use super::super::table::object::ObjectSettings;
use super::super::table::plane::{HalfPlaneSettings, TableSettings};
use super::super::table::scene::SceneSettings;
use super::super::table::{SettingsSection, read};
use crate::units::{Dimension, format};

/// Largest allowed initial penetration of the object into palm or table.
const MAX_PENETRATION_M: f64 = 1e-3;

/// Heights of the lower half plane (palm or ground) and of the table, if present.
pub fn levels(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    scene_settings: &SceneSettings,
    object: ObjectSettings,
) -> [Option<f64>; 2] {
    let (ground, table) = (input.subsection("half_plane"), input.subsection("table"));
    let below = match input.kind.fingers() {
        0 => ground.is_present().then(|| read(checker, "half_plane", &ground, HalfPlaneSettings::defaults()).level_m),
        _ => scene_settings.palm.then_some(0.0),
    };
    let table = table.is_present().then(|| read(checker, "table", &table, TableSettings::defaults()));
    let level = |table: TableSettings| match table.level_m.is_nan() {
        true => object.heights_m()[1],
        false => table.level_m,
    };
    [below, table.filter(|table| table.present).map(level)]
}

/// Checks that the object does not penetrate palm or table at the start.
pub fn check_object(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    object: ObjectSettings,
    [palm, table]: [Option<f64>; 2],
) {
    let [lowest, highest] = object.heights_m();
    let object_input = input.subsection("object");
    let planes = [
        ("palm", palm.map(|_| -lowest), object_input.span("height").or(object_input.span)),
        ("table", table.map(|level_m| highest - level_m), input.subsection("table").span("level")),
    ];
    for (plane, depth, place) in planes {
        let Some(depth) = depth.filter(|depth| *depth > MAX_PENETRATION_M) else { continue };
        let message = format!(
            "the object starts {:.3} mm inside the {plane}, but at most {} is allowed",
            depth * 1e3,
            format(MAX_PENETRATION_M, Dimension::Length)
        );
        checker.push(
            place,
            message,
            "starts inside",
            "move the object by `object.height`, or the table by `table.level`",
        );
    }
}
