//! Fields of a scene, and the axes of a study: fields with lists of values or with ranges.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value as Json;
use toml::de::DeValue;
use toml::{Spanned, Table};

use crate::numeric::elementary::{ln, pow};
use crate::scene::Problem;
use crate::scene::keys::{child_schema, has_tables, is_table, join, unknown_key};
use crate::scene::keywords::SceneKind;
use crate::scene::parameters::{Parameters, unknown};
use crate::scene::schema::schema_for;
pub use crate::scene::value::ValueType as FieldType;
use crate::scene::value::dimension_of;
use crate::scene::written::{number, problem_at};
use crate::scene::{PARAMETERS, Part, no_such_entry, parse_field};
use crate::table::{Kind, Value};
use crate::units::{self, Dimension, is_expression};

/// A scene field that a study varies.
#[derive(Clone, Debug)]
pub struct Field {
    /// Path in a scene, such as `contact.friction.mu_static`.
    pub path: String,
    pub field_type: FieldType,
}

#[derive(Clone, Debug, PartialEq)]
pub struct AxisValue {
    /// Value as TOML text in a scene file.
    pub text: String,
    /// Value in the results, in SI units.
    pub value: Value,
}

impl AxisValue {
    /// The value as written in a scene file.
    pub fn toml(&self) -> Option<toml::Value> {
        format!("value = {}", self.text).parse::<Table>().ok()?.remove("value")
    }
}

impl Field {
    /// Finds a field of a base scene of this kind by its path; the problem of an unknown path has no position.
    pub(super) fn find(path: &str, kind: SceneKind, base: &Table, parameters: &Parameters) -> Result<Self, Problem> {
        let parts = parse_path(path)?;
        if let [section, name] = &parts[..]
            && section.key() == PARAMETERS
        {
            return Field::of_parameter(name, parameters);
        }
        let field = Field::find_in(path, schema_for(kind))?;
        let (mut table, mut written) = (Some(base), None);
        for (index, part) in parts.iter().enumerate() {
            let (list, mut value) =
                (path_of(&parts[..index], &part.name), table.and_then(|table| table.get(&part.name)));
            for entry in &part.entries {
                let Some(items) = value.map(|list| list.as_array().map_or(&[][..], |items| items)) else { break };
                if *entry >= items.len() {
                    return Err(missing_entry(&list, *entry, items.len()));
                }
                value = Some(&items[*entry]);
            }
            (table, written) = (value.and_then(toml::Value::as_table), value.and_then(toml::Value::as_str));
        }
        Ok(field.narrowed(written, parameters))
    }

    /// The field with a single dimension, if its type has several: that of a text written for it.
    pub(super) fn narrowed(mut self, written: Option<&str>, parameters: &Parameters) -> Self {
        if let (FieldType::OneOf(dimensions), Some(text)) = (&self.field_type, written)
            && let Some(dimension) = dimension_of(text, dimensions, parameters)
        {
            self.field_type = FieldType::Quantity(dimension);
        }
        self
    }

    /// The field of a parameter, with the dimension of its value in the base scene.
    fn of_parameter(name: &Part, parameters: &Parameters) -> Result<Self, Problem> {
        let (name, path) = (name.key(), format!("{PARAMETERS}.{}", name.key()));
        let Some(value) = parameters.get(&name) else {
            let (label, help) = unknown(&name, &parameters.names());
            return Err(Problem::new(None, format!("unknown parameter `{name}`"), label, help));
        };
        let field_type = match value.dimension() {
            Some(dimension) => FieldType::Quantity(dimension),
            None if value.is_number() => FieldType::Number,
            None => {
                let message = format!("`{path}` is {}, for which there is no unit", value.name());
                return Err(Problem::new(None, message, "no unit", "vary the parameters of its expression"));
            }
        };
        Ok(Field { path, field_type })
    }

    /// Finds a field by its path in scenes with this schema; the problem of an unknown path has no position.
    fn find_in(path: &str, schema: &Json) -> Result<Self, Problem> {
        let (mut node, mut parent) = (schema, String::new());
        for part in parse_path(path)? {
            let name = &part.key();
            if !is_table(node) {
                let message = format!("`{path}` is not a field of a scene: `{parent}` is a single value");
                return Err(Problem::new(
                    None,
                    message,
                    "too many parts",
                    format!("name the field itself: \"{parent}\""),
                ));
            }
            let unknown = || Problem { span: None, ..unknown_key(name, &parent, 0..0, node, schema) };
            let list = child_schema(node, &part.name).ok_or_else(unknown)?;
            if let (Some(entry), Some(count)) =
                (part.entries.first(), list["maxItems"].as_u64().map(|count| count as usize))
                && *entry >= count
            {
                return Err(missing_entry(&join(&parent, &part.name), *entry, count));
            }
            node = child_schema(node, name).ok_or_else(unknown)?;
            parent = join(&parent, name);
        }
        if has_tables(node) {
            let message = format!("`{path}` is a list of tables of a scene, but a field is a single value");
            return Err(Problem::new(
                None,
                message,
                "a list of tables",
                format!("name a key of one of them: \"{path}[0].KEY\""),
            ));
        }
        if is_table(node) {
            let keys = node["properties"].as_object().into_iter().flat_map(|keys| keys.keys());
            let fields: Vec<String> = keys.map(|key| format!("\"{path}.{key}\"")).collect();
            let message = format!("`{path}` is a table of a scene, but a field is a single value");
            return Err(Problem::new(
                None,
                message,
                "a table",
                format!("name one of its fields: {}", fields.join(", ")),
            ));
        }
        Ok(Field { path: path.to_string(), field_type: FieldType::from_schema(node) })
    }

    /// Name of the result column: the path, followed by the unit of the SI value.
    pub fn column(&self) -> String {
        match self.field_type {
            FieldType::Quantity(dimension) => format!("{}_{}", self.path, dimension.suffix()),
            _ => self.path.clone(),
        }
    }

    /// Finds the field with this result column in scenes with this schema.
    pub(super) fn from_column(column: &str, schema: &Json) -> Option<Self> {
        let in_unit = |dimension: Dimension| {
            let path = column.strip_suffix(dimension.suffix())?.strip_suffix('_')?;
            let field = Field::find_in(path, schema).ok()?;
            Some(field.narrowed(Some(&format!("1 {}", dimension.units()[0].name)), &Parameters::default()))
        };
        let mut fields = Dimension::ALL.into_iter().filter_map(in_unit).chain(Field::find_in(column, schema).ok());
        fields.find(|field| field.column() == column)
    }

    pub(in crate::study) fn read(&self, value: &Spanned<DeValue<'_>>) -> Result<AxisValue, Vec<Problem>> {
        let text = to_toml(value.get_ref());
        if self.field_type.is_numeric() && value.get_ref().as_str().is_some_and(is_expression) {
            let message = format!("`{}` is varied by values, but {text} is an expression", self.path);
            let help = "write a number or a quantity, or vary the parameters of the expression".to_string();
            return Err(vec![problem_at(value, message, "an expression", help)]);
        }
        let value = match self.field_type.read(&self.path, value, &Parameters::default())? {
            toml::Value::Float(number) => Value::Number(number),
            toml::Value::Integer(integer) => Value::Integer(integer),
            toml::Value::Boolean(flag) => Value::Flag(flag),
            toml::Value::String(text) if text.contains(char::is_control) => {
                let message = format!("`{}` is several lines, but must be a single line of text", self.path);
                let help = "write it in one line".to_string();
                return Err(vec![problem_at(value, message, "a single line of text", help)]);
            }
            toml::Value::String(text) => Value::Text(text),
            _ => Value::Text(text.clone()),
        };
        Ok(AxisValue { text, value })
    }

    /// Parses a value as it is written in a scene file: `"12 mm"` with quotes, `0.8`, `true`. The message of an error
    /// is a single line.
    pub fn parse_toml(&self, toml: &str) -> Result<AxisValue, String> {
        let value = DeValue::parse(toml).map_err(|error| error.to_string())?;
        self.read(&value).map_err(|problems| {
            problems.iter().map(|p| format!("{}; {}", p.message, p.help)).collect::<Vec<_>>().join("; ")
        })
    }

    /// Returns the value of the field for a number in SI units; `None` if the field does not accept the number.
    pub fn value_of_si(&self, si: f64) -> Option<AxisValue> {
        let (text, value) = match &self.field_type {
            _ if !si.is_finite() => return None,
            FieldType::Quantity(dimension) => (format!("\"{si:?} {}\"", dimension.units()[0].name), Value::Number(si)),
            FieldType::Number | FieldType::Percent => (format!("{si:?}"), Value::Number(si)),
            FieldType::Integer(min, max) if si as i64 as f64 == si && (min..=max).contains(&&(si as i64)) => {
                (format!("{}", si as i64), Value::Integer(si as i64))
            }
            _ => return None,
        };
        Some(AxisValue { text, value })
    }
}

/// Splits the path of a field.
fn parse_path(path: &str) -> Result<Vec<Part>, Problem> {
    let help = "`phalanx scene show SCENE` prints all fields of a scene";
    parse_field(path).map_err(|message| Problem::new(None, message, "not a field", help))
}

fn path_of(sections: &[Part], name: &str) -> String {
    sections.iter().map(Part::key).chain([name.to_string()]).collect::<Vec<_>>().join(".")
}

fn missing_entry(list: &str, entry: usize, count: usize) -> Problem {
    let help = "name an entry that the base scene has".to_string();
    Problem::new(None, no_such_entry(list, entry, count), "no such entry", help)
}

/// Kind of a result column with values of this type.
pub(in crate::study) fn column_kind(field_type: &FieldType) -> Kind {
    match field_type {
        FieldType::Quantity(_) | FieldType::Number | FieldType::Percent => Kind::Number,
        FieldType::Integer(..) => Kind::Integer,
        FieldType::Flag => Kind::Flag,
        FieldType::Choice(_) | FieldType::Text | FieldType::List(..) | FieldType::OneOf(_) => Kind::Text,
    }
}

fn to_toml(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => toml::Value::from(text.as_ref()).to_string(),
        DeValue::Integer(_) | DeValue::Float(_) => match number(value) {
            Some(toml::Value::Float(number)) => format!("{number:?}"),
            whole => whole.map(|number| number.to_string()).unwrap_or_default(),
        },
        DeValue::Boolean(flag) => flag.to_string(),
        DeValue::Array(items) => {
            let items: Vec<String> = items.iter().map(|item| to_toml(item.get_ref())).collect();
            format!("[{}]", items.join(", "))
        }
        DeValue::Datetime(_) | DeValue::Table(_) => "{}".to_string(),
    }
}

/// One field, or several that vary together.
#[derive(Clone, Debug)]
pub(in crate::study) struct Axis {
    pub fields: Vec<Field>,
    pub values: AxisValues,
    /// Whether the axis repeats the same designs under other conditions. It then does not count for the design number.
    pub repeats_designs: bool,
}

#[derive(Clone, Debug)]
pub(in crate::study) enum AxisValues {
    /// One value for each field, row by row.
    Rows(Vec<Vec<AxisValue>>),
    /// A range of the only field; the sample determines its values.
    Range(Range),
}

impl Axis {
    /// Number of values; `None` for a range.
    pub fn len(&self) -> Option<u64> {
        if let AxisValues::Rows(rows) = &self.values { Some(rows.len() as u64) } else { None }
    }
}

/// Spacing of the values in a range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(in crate::study) enum Spacing {
    #[default]
    Linear,
    Log,
}

/// Closed interval of numbers or quantities, in the unit of the study file.
#[derive(Clone, Debug)]
pub(in crate::study) struct Range {
    pub from: f64,
    pub to: f64,
    /// Unit; empty for plain numbers.
    unit: String,
    field_type: FieldType,
    spacing: Spacing,
}

impl Range {
    /// Returns the range between two values of a field; `None` if the field is not numeric.
    pub fn between(field: &Field, from: &AxisValue, to: &AxisValue, spacing: Spacing) -> Option<Self> {
        let (Value::Number(from_si), Value::Number(to_si)) = (&from.value, &to.value) else { return None };
        let ends = [from, to].map(|end| units::split_quantity(end.text.trim_matches(['"', '\''])));
        let (from, to, unit) = match (&field.field_type, ends.map(|(number, unit)| (number.parse::<f64>(), unit))) {
            // Interpolation in the unit of the file yields the numbers that a user would write.
            (FieldType::Quantity(_), [(Ok(from), unit), (Ok(to), to_unit)]) if unit == to_unit => (from, to, unit),
            (FieldType::Quantity(dimension), _) => (*from_si, *to_si, dimension.units()[0].name),
            _ => (*from_si, *to_si, ""),
        };
        Some(Range { from, to, unit: unit.to_string(), field_type: field.field_type.clone(), spacing })
    }

    /// Returns the value at the fraction `x` of the range. With `is_grid`, rounding errors in the last decimals are
    /// removed.
    pub fn value_at(&self, x: f64, is_grid: bool) -> AxisValue {
        let exact = match self.spacing {
            _ if x == 0.0 => self.from,
            _ if x == 1.0 => self.to,
            Spacing::Linear => self.from + (self.to - self.from) * x,
            Spacing::Log => self.from * pow(self.to / self.from, x),
        };
        let number = if is_grid { strip_rounding_error(exact) } else { exact };
        match self.field_type {
            FieldType::Quantity(dimension) => {
                let text = format!("{number:?} {}", self.unit);
                AxisValue { value: units::parse(&text, dimension).ok().into(), text: format!("\"{text}\"") }
            }
            _ => AxisValue { text: format!("{number:?}"), value: Value::Number(number) },
        }
    }

    /// Returns the value at the fraction `x` of the range, in SI units.
    pub fn si_at(&self, x: f64) -> f64 {
        self.value_at(x, false).value.as_number().unwrap_or(f64::NAN)
    }

    /// Returns the fraction of the range at which an SI value lies. For a value outside the range, it is below 0, above
    /// 1 or NaN.
    pub fn fraction_of(&self, si: f64) -> f64 {
        let [from, to] = [0.0, 1.0].map(|end| self.si_at(end));
        match self.spacing {
            _ if si == from => 0.0,
            _ if si == to => 1.0,
            Spacing::Linear => (si - from) / (to - from),
            Spacing::Log => ln(si / from) / ln(to / from),
        }
    }

    pub fn is_log(&self) -> bool {
        self.spacing == Spacing::Log
    }

    /// Returns a grid of `count` values, including both ends.
    pub fn grid(&self, count: u64) -> Vec<Vec<AxisValue>> {
        (0..count).map(|index| vec![self.value_at(index as f64 / (count - 1) as f64, true)]).collect()
    }
}

/// Rounds to 15 significant digits if that leaves at most 12; otherwise returns the number unchanged.
fn strip_rounding_error(exact: f64) -> f64 {
    let rounded = format!("{exact:.14e}").parse().unwrap_or(exact);
    let digits = format!("{rounded:e}").chars().take_while(|c| *c != 'e').filter(char::is_ascii_digit).count();
    if digits <= 12 { rounded } else { exact }
}
