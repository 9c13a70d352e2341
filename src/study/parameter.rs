//! Numeric fields of a scene as parameters of its derivatives.

use toml::de::{DeTable, DeValue};
use toml::{Spanned, Value};

use crate::gradient::Parameter;
use crate::scene::keys::child_schema;
use crate::scene::keywords::SceneKind;
use crate::scene::parameters::{Parameters, unknown};
use crate::scene::parse::document;
use crate::scene::schema::schema_for;
use crate::scene::value::{ValueType, dimension_of};
use crate::scene::{
    Layer, PARAMETERS, Part, Scene, no_such_entry, parse_field, parse_layers, setting_from_parts, show_written,
};
use crate::units::Measured;

/// Origin of a changed field in messages.
const ORIGIN: &str = "gradient";

/// Returns numeric fields of a scene as parameters. `layers` and `settings` are the texts of the scene. `finish`
/// applies the changes that were made after the scene was read.
///
/// # Errors
/// Returns a message for a field that is not a number or a quantity of the scene.
pub fn parameters<'a>(
    (layers, settings): (&'a [Layer], &'a [Layer]),
    fields: &[String],
    finish: &'a dyn Fn(&mut Scene),
) -> Result<Vec<Parameter<'a>>, String> {
    let text = show_written(&parse_layers(layers, settings).map_err(|error| error.to_string())?);
    let (kind, document, _) = document(&text).map_err(|error| error.to_string())?;
    let scene_parameters = Parameters::read(document.get_ref()).0;
    let parameter = |field: &String| {
        let found = find((kind, document.get_ref()), &scene_parameters, field)?;
        let unit = match found.dimension() {
            Some(dimension) => dimension.units()[0].name,
            None if found.is_number() => "",
            None => return Err(format!("`{field}` is {}, for which there is no unit", found.name())),
        };
        let (name, field) = (field.clone(), field.clone());
        let scene_at = move |value: f64| {
            let text = if unit.is_empty() { format!("{value:?}") } else { format!("{value:?} {unit}") };
            let mut settings = settings.to_vec();
            settings.push(setting_from_parts(ORIGIN, &field, &text)?);
            let mut scene = parse_layers(layers, &settings).map_err(|error| error.to_string())?;
            finish(&mut scene);
            Ok(scene)
        };
        Ok(Parameter { name, unit, value: found.si, scene_at: Box::new(scene_at) })
    };
    fields.iter().map(parameter).collect()
}

/// The value of a field of a complete scene with these parameters.
fn find((kind, scene): (SceneKind, &DeTable<'_>), parameters: &Parameters, field: &str) -> Result<Measured, String> {
    let parts = parse_field(field)?;
    if let [section, name] = &parts[..]
        && section.key() == PARAMETERS
    {
        let (label, help) = unknown(&name.key(), &parameters.names());
        let message = || format!("unknown parameter `{}`: {label}; {help}", name.key());
        return parameters.get(&name.key()).ok_or_else(message);
    }
    let error = || {
        format!(
            "`{field}` is not a number or a quantity of the scene; `phalanx scene show` (in Python: `scene.toml`) shows \
             all fields, such as design.base"
        )
    };
    let value = value_in(scene, &parts)?.ok_or_else(error)?;
    let schema = parts.iter().try_fold(schema_for(kind), |schema, part| child_schema(schema, &part.key()));
    let value_type = ValueType::from_schema(schema.ok_or_else(error)?);
    let dimension = match &value_type {
        ValueType::Quantity(dimension) => Some(*dimension),
        ValueType::OneOf(dimensions) => {
            value.get_ref().as_str().and_then(|text| dimension_of(text, dimensions, parameters))
        }
        _ => None,
    };
    let si = match value_type.read(field, value, parameters) {
        Ok(Value::Float(number)) => number,
        Ok(Value::Integer(number)) => number as f64,
        _ => return Err(error()),
    };
    Ok(Measured::new(si, dimension))
}

/// The value at a path of a complete scene; the error names a list that has no such entry.
pub(super) fn value_in<'s, 't>(
    scene: &'s DeTable<'t>,
    path: &[Part],
) -> Result<Option<&'s Spanned<DeValue<'t>>>, String> {
    let (mut table, mut value) = (Some(scene), None);
    for part in path {
        let get = |key: &str| table.and_then(|table| table.get(key));
        // An entry without its list is a key of its own.
        let own = get(&part.key());
        let Some(mut found) = own.or_else(|| get(&part.name)) else { return Ok(None) };
        for entry in part.entries.iter().filter(|_| own.is_none()) {
            let Some(items) = found.get_ref().as_array() else { return Ok(None) };
            found = items.get(*entry).ok_or_else(|| no_such_entry(&part.name, *entry, items.len()))?;
        }
        (table, value) = (found.get_ref().as_table(), Some(found));
    }
    Ok(value)
}
