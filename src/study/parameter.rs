//! Numeric fields of a scene as parameters of its derivatives.

use toml::{Table, Value};

use crate::gradient::Parameter;
use crate::scene::{Layer, Scene, parse_any, parse_layers, setting_from_parts, show_written};
use crate::units::{self, Dimension};

/// Origin of a changed field in messages.
const ORIGIN: &str = "gradient";

/// Returns numeric fields of a scene as parameters. `layers` and `settings` are the texts from which the scene was read;
/// `finish` applies what was changed after that.
///
/// # Errors
/// Returns a message for a field that is not a number or a quantity of the scene.
pub fn parameters<'a>(
    scene: &Scene,
    (layers, settings): (&'a [Layer], &'a [Layer]),
    fields: &[String],
    finish: &'a dyn Fn(&mut Scene),
) -> Result<Vec<Parameter<'a>>, String> {
    let table: Table = show_written(scene).parse().map_err(|error: toml::de::Error| error.to_string())?;
    let parameter = |field: &String| {
        let (value, unit) = find(&table, field).and_then(number).ok_or_else(|| {
            format!(
                "`{field}` is not a number or a quantity of the scene; `phalanx scene show` (in Python: `scene.toml`) shows \
                 all fields, such as design.base"
            )
        })?;
        let (name, field) = (field.clone(), field.clone());
        let scene_at = move |value: f64| {
            let text = if unit.is_empty() { format!("{value:?}") } else { format!("{value:?} {unit}") };
            let mut settings = settings.to_vec();
            settings.push(setting_from_parts(ORIGIN, &field, &text)?);
            let mut scene = parse_layers(layers, &settings, parse_any).map_err(|error| error.to_string())?;
            finish(&mut scene);
            Ok(scene)
        };
        Ok(Parameter { name, unit, value, scene_at: Box::new(scene_at) })
    };
    fields.iter().map(parameter).collect()
}

/// The value of a field; `object.centre[0]` is an element of a list.
fn find<'a>(table: &'a Table, field: &str) -> Option<&'a Value> {
    let (path, key) = field.rsplit_once('.').map_or(("", field), |(path, key)| (path, key));
    let mut sections = path.split('.').filter(|section| !section.is_empty());
    let table = sections.try_fold(table, |table, section| table.get(section)?.as_table())?;
    match key.strip_suffix(']').and_then(|key| key.split_once('[')) {
        Some((list, index)) => table.get(list)?.as_array()?.get(index.parse::<usize>().ok()?),
        None => table.get(key),
    }
}

/// The SI value of a number or a quantity, and its SI unit.
fn number(value: &Value) -> Option<(f64, &'static str)> {
    match value {
        Value::Float(number) => Some((*number, "")),
        Value::Integer(number) => Some((*number as f64, "")),
        Value::String(text) => Dimension::ALL
            .into_iter()
            .find_map(|dimension| Some((units::parse(text, dimension).ok()?, dimension.units()[0].name))),
        _ => None,
    }
}
