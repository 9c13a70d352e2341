//! Studies built in memory: fields of a scene and rows of their values.

use toml::Spanned;

use super::axis::{Axis, AxisValues};
use super::base_scene::{Template, base_from_layers};
use super::field::{AxisValue, Field, FieldType};
use super::{Filter, MAX_RUNS, Study};
use crate::scene::schema::schema_for;
use crate::scene::toml_value::TomlValue;
use crate::scene::{Layer, SceneError};
use crate::table::Value;
use crate::trace::Model;

/// Error in a study built in memory.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InMemoryStudyError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An unknown or duplicate field.
    #[error("error: {message}\n  = help: {help}")]
    Field { message: String, help: String },
}

/// Builds a study of these scene fields without rows; each row that [`Study::with_rows`] adds is a design.
///
/// `layers` are the texts of the scene and the scenes it extends, `settings` additional fields, as for
/// `scene::parse_layers`. The scene may lack the fields of the rows.
///
/// # Errors
/// Returns an error if the scene is invalid, or a path is not a field of it.
pub fn in_memory_study(
    layers: &[Layer],
    settings: &[Layer],
    paths: &[&str],
    model: Model,
) -> Result<Study, InMemoryStudyError> {
    let base = base_from_layers(layers, settings)?;
    let invalid = |message: String, help: String| InMemoryStudyError::Field { message, help };
    let mut fields: Vec<Field> = Vec::new();
    for path in paths {
        let field = Field::find(path, schema_for(base.kind))
            .map_err(|(message, label, help)| invalid(message, format!("{label}; {help}")))?;
        if fields.iter().any(|other| other.path == field.path) {
            return Err(invalid(format!("the field `{path}` is given twice"), "remove one of them".to_string()));
        }
        fields.push(field);
    }
    let template =
        Template::new(base.table, paths).map_err(|reason| invalid(reason, "give other fields".to_string()))?;
    Ok(Study {
        kind: base.kind,
        name: String::new(),
        description: String::new(),
        model,
        checked: false,
        filter: Filter::default(),
        axes: vec![Axis { fields, values: AxisValues::Rows(Vec::new()), repeats_designs: false }],
        sequence: None,
        template,
        runs: 0,
        source: String::new(),
        base: base.text,
    })
}

impl Study {
    /// Fields of the first axis, in the order of a row.
    pub fn row_fields(&self) -> &[Field] {
        self.axes.first().map_or(&[], |axis| &axis.fields)
    }

    /// Copies the study with these rows of values of its first axis. Each row is a design.
    ///
    /// # Panics
    /// Panics if the length of a row differs from the number of fields, or if there are more than [`MAX_RUNS`] runs.
    pub fn with_rows(&self, rows: Vec<Vec<AxisValue>>) -> Study {
        assert!(rows.iter().all(|row| row.len() == self.row_fields().len()), "one value for each field");
        let mut study = self.clone();
        if let Some(first) = study.axes.first_mut() {
            first.values = AxisValues::Rows(rows);
        }
        study.runs = study.designs();
        assert!(study.runs <= MAX_RUNS, "at most {MAX_RUNS} runs");
        study
    }
}

impl Field {
    /// Value of the field for a number in SI units; `None` if the field does not accept it.
    pub fn value_of_si(&self, si: f64) -> Option<AxisValue> {
        if !si.is_finite() {
            return None;
        }
        match &self.field_type {
            FieldType::Quantity(dimension) => {
                let unit = dimension.units()[0].name;
                Some(AxisValue { text: format!("\"{si:?} {unit}\""), value: Value::Number(si) })
            }
            FieldType::Number => Some(AxisValue { text: format!("{si:?}"), value: Value::Number(si) }),
            FieldType::Integer(min, max) => {
                let integer = si as i64;
                let fits = integer as f64 == si && (min..=max).contains(&&integer);
                fits.then(|| AxisValue { text: integer.to_string(), value: Value::Integer(integer) })
            }
            FieldType::Flag | FieldType::Choice(_) | FieldType::Text | FieldType::List(..) => None,
        }
    }

    /// Parses a value as it is written in a scene file: `"12 mm"` with quotes, `0.8`, `true`.
    ///
    /// # Errors
    /// Returns an error if the value is invalid; the message is a single line.
    pub fn parse_toml(&self, toml: &str) -> Result<AxisValue, String> {
        use serde::Deserialize;
        let deserializer = toml::de::ValueDeserializer::parse(toml).map_err(|error| error.to_string())?;
        let value: Spanned<TomlValue> = Spanned::deserialize(deserializer).map_err(|error| error.to_string())?;
        self.read(&value).map_err(|problems| {
            problems.iter().map(|p| format!("{}; {}", p.message, p.help)).collect::<Vec<_>>().join("; ")
        })
    }
}
