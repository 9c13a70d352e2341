//! Palm or ground, and the table.

use super::super::check::Checker;
use super::super::table::keys::Keys;
use super::super::table::object::Object;
use super::super::table::plane::{Ground, Support};
use super::super::table::top::Top;
use super::super::table::{Table, read};
use crate::units::{Dimension, format};

/// Deepest overlap of the object with palm or table that a scene may start with.
const MAX_PENETRATION_M: f64 = 1e-3;

/// Heights of what is solid below and of what is solid above, as far as they are there.
pub fn levels(c: &mut Checker<'_>, raw: &Keys<'_>, top: &Top, object: Object) -> [Option<f64>; 2] {
    let (ground, table) = (raw.inner("half_plane"), raw.inner("table"));
    let below = match raw.kind.fingers() {
        0 => ground.is_given().then(|| read(c, "half_plane", &ground, Ground::usual()).level_m),
        _ => top.palm.then_some(0.0),
    };
    let table = table.is_given().then(|| read(c, "table", &table, Support::usual()));
    let level = |table: Support| match table.level_m.is_nan() {
        true => object.heights_m()[1],
        false => table.level_m,
    };
    [below, table.filter(|table| table.present).map(level)]
}

/// Palm and table must not be inside the object.
pub fn judge_object(c: &mut Checker<'_>, raw: &Keys<'_>, object: Object, [palm, table]: [Option<f64>; 2]) {
    let [lowest, highest] = object.heights_m();
    let said = raw.inner("object");
    let planes = [
        ("palm", palm.map(|_| -lowest), said.span("height").or(said.span)),
        ("table", table.map(|level_m| highest - level_m), raw.inner("table").span("level")),
    ];
    for (plane, depth, place) in planes {
        let Some(depth) = depth.filter(|depth| *depth > MAX_PENETRATION_M) else { continue };
        let message = format!(
            "the object starts {:.3} mm inside the {plane}, but at most {} is allowed",
            depth * 1e3,
            format(MAX_PENETRATION_M, Dimension::Length)
        );
        c.push(place, message, "starts inside", "move the object by `object.height`, or the table by `table.level`");
    }
}
