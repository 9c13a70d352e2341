//! Studies that no file describes: some fields of a scene, and rows of their values that a program has.

use toml::Spanned;

use super::axis::Points;
use super::base;
use super::designs::{Designs, of_designs};
use super::field::{Field, Holds, Point};
use super::{Filter, MOST_RUNS, Study};
use crate::scene::any::Any;
use crate::scene::schema::schema_of;
use crate::scene::{Layer, SceneError};
use crate::table::Value;
use crate::trace::Model;

/// Why there is no study of these fields.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GivenError {
    Scene(SceneError),
    /// A field that scenes of this kind do not have, or that is there twice: what is wrong, and what to do.
    Field {
        message: String,
        help: String,
    },
}

impl std::error::Error for GivenError {}

impl std::fmt::Display for GivenError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            GivenError::Scene(error) => error.fmt(f),
            GivenError::Field { message, help } => write!(f, "error: {message}\n  = help: {help}"),
        }
    }
}

/// A study of these fields of a scene, one row of whose values is one design; it has no rows yet, see [`Study::with_rows`].
///
/// `layers` are the scene's texts and those it extends, `settings` fields set besides, as for `scene::parse_layers`. What the
/// rows give may be missing in the scene.
///
/// # Errors
/// What is wrong with the scene, or a path that names no field of it.
pub fn given(layers: &[Layer], settings: &[Layer], fields: &[&str], model: Model) -> Result<Study, GivenError> {
    let base = base::of_layers(layers, settings).map_err(GivenError::Scene)?;
    let mut found: Vec<Field> = Vec::new();
    for path in fields {
        let field = Field::find(path, schema_of(base.kind))
            .map_err(|(message, label, help)| GivenError::Field { message, help: format!("{label}; {help}") })?;
        if found.iter().any(|other| other.path == field.path) {
            let message = format!("the field `{path}` is there twice");
            return Err(GivenError::Field { message, help: "leave one of them out".to_string() });
        }
        found.push(field);
    }
    let broken = |message| GivenError::Field { message, help: "give other fields".to_string() };
    of_designs(Designs {
        kind: base.kind,
        name: String::new(),
        description: String::new(),
        model,
        filter: Filter::default(),
        fields: found,
        conditions: Vec::new(),
        scene: base.table,
        base: base.text,
        source: String::new(),
    })
    .map_err(broken)
}

impl Study {
    /// The fields of the first axis, in the order of a row.
    pub fn row_fields(&self) -> &[Field] {
        self.axes.first().map_or(&[], |axis| &axis.fields)
    }

    /// The same study with other rows of values of its first axis: a design each, one value for each of its fields.
    ///
    /// # Panics
    /// If a row has not as many values as there are fields, or if these are more runs than [`MOST_RUNS`].
    pub fn with_rows(&self, rows: Vec<Vec<Point>>) -> Study {
        assert!(rows.iter().all(|row| row.len() == self.row_fields().len()), "a value for each field");
        let mut study = self.clone();
        if let Some(first) = study.axes.first_mut() {
            first.points = Points::Given(rows);
        }
        study.runs = study.loops().iter().map(|of| of.len).product();
        assert!(study.runs <= MOST_RUNS, "at most {MOST_RUNS} runs");
        study
    }
}

impl Field {
    /// The value of a number in SI; `None` if the field does not hold numbers, or not this one.
    pub fn at(&self, si: f64) -> Option<Point> {
        if !si.is_finite() {
            return None;
        }
        match &self.holds {
            Holds::Quantity(dimension) => {
                let unit = dimension.units()[0].name;
                Some(Point { text: format!("\"{si:?} {unit}\""), value: Value::Number(si) })
            }
            Holds::Number | Holds::Percent => Some(Point { text: format!("{si:?}"), value: Value::Number(si) }),
            Holds::Whole(least, most) => {
                let whole = si as i64;
                let fits = whole as f64 == si && (least..=most).contains(&&whole);
                fits.then(|| Point { text: whole.to_string(), value: Value::Integer(whole) })
            }
            Holds::Flag | Holds::Word(_) | Holds::Text | Holds::List(_) => None,
        }
    }

    /// The value that a text means where it stands as a value in a scene file: `"12 mm"` with its quotes, `0.8`, `true`.
    ///
    /// # Errors
    /// What is wrong with it, in one line.
    pub fn parsed(&self, toml: &str) -> Result<Point, String> {
        use serde::Deserialize;
        let read = toml::de::ValueDeserializer::parse(toml).map_err(|error| error.to_string())?;
        let value: Spanned<Any> = Spanned::deserialize(read).map_err(|error| error.to_string())?;
        self.read(&value).map_err(|problems| {
            problems.iter().map(|p| format!("{}; {}", p.message, p.help)).collect::<Vec<_>>().join("; ")
        })
    }
}
