//! The tables of a study file with the values of fields: lists, rows and ranges.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::IgnoredAny;
use toml::Spanned;
use toml::de::DeValue;

use super::axis::{Axis, AxisValue, AxisValues, Field, Range, Spacing};
use super::base_scene::Base;
use super::document::{Document, any_list, any_value};
use crate::scene::parameters::Parameters;
use crate::scene::written::type_name;
use crate::scene::{PARAMETERS, Problem};

/// Values or a range of one field, or rows of values of several fields. Only the keys are deserialised here; the values
/// are read from the document itself.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default)]
pub struct AxisTable {
    /// Scene field, such as "design.base" or "contact.friction.mu_static".
    pub field: String,
    /// Fields that vary together; requires `rows`.
    #[schemars(length(min = 1))]
    pub fields: Vec<String>,
    /// Values, written as in a scene.
    #[schemars(schema_with = "any_list")]
    values: Vec<IgnoredAny>,
    /// Rows of values, one value for each of `fields`.
    #[schemars(schema_with = "any_list")]
    rows: Vec<IgnoredAny>,
    /// First value of a range.
    #[schemars(schema_with = "any_value")]
    from: Option<IgnoredAny>,
    /// Last value of a range.
    #[schemars(schema_with = "any_value")]
    to: Option<IgnoredAny>,
    /// Number of values of the range including both ends.
    #[schemars(with = "u64", range(min = 1))]
    count: Option<u64>,
    /// Spacing of the values of a range.
    #[schemars(extend("default" = "linear"))]
    spacing: Spacing,
}

impl AxisTable {
    /// Whether the axis is a range without a number of values.
    pub fn is_range(&self) -> bool {
        self.from.is_some() && self.to.is_some() && self.count.is_none()
    }

    /// Returns the key that contains the names of the fields: `field` or `fields`.
    pub fn key(&self) -> &'static str {
        if self.field.is_empty() { "fields" } else { "field" }
    }
}

impl Document<'_> {
    /// Reads the axis at a path such as `axes.0`.
    pub fn read_axis(&self, path: &str, table: &AxisTable, base: &Base) -> Option<Axis> {
        let at = |key: &str| format!("{path}.{key}");
        let is_single = !table.field.is_empty();
        if is_single && !table.fields.is_empty() {
            return self.refuse(
                &at("fields"),
                "both `field` and `fields` are given",
                "repeated here",
                "keep one of them",
            );
        }
        let mut fields: Vec<Field> = Vec::new();
        for (index, name) in table.fields.iter().chain(is_single.then_some(&table.field)).enumerate() {
            let path = if is_single { at("field") } else { at(&format!("fields.{index}")) };
            let first = if is_single { at("values.0") } else { at(&format!("rows.0.{index}")) };
            let field = self.read_field(&path, name, base, [first, at("from")])?;
            if fields.iter().any(|other| other.path == field.path) {
                return self.refuse(&path, format!("`{name}` is given twice"), "repeated here", "remove one of them");
            }
            fields.push(field);
        }
        let Some(first) = fields.first() else {
            return self.missing("field", path, "name the field of the scene that varies: field = \"design.base\"");
        };
        let (unused, reason): (&[&str], _) = match (is_single, table.values.is_empty()) {
            (false, _) => {
                (&["values", "from", "to", "count", "spacing"], "together with `fields`, whose values are `rows`")
            }
            (true, true) => (&["rows"], "together with `field`, whose values are `values`"),
            (true, false) => (&["rows", "from", "to", "count", "spacing"], "together with `values`"),
        };
        for key in unused {
            self.checker.report_unused_at(key, self.span(&at(key)), reason);
        }
        let values = match (is_single, table.values.is_empty()) {
            (false, _) => self.read_rows(path, &fields)?,
            (true, true) => self.read_grid(path, first, table)?,
            (true, false) => self.read_values(path, first)?,
        };
        Some(Axis { fields, values, repeats_designs: false })
    }

    /// Finds the field whose name is at a path of the study. If the base scene does not contain the field, its first
    /// value decides its dimension; this value is at one of the paths `first`.
    pub fn read_field(&self, path: &str, name: &str, base: &Base, first: [String; 2]) -> Option<Field> {
        let report = |Problem { message, label, help, .. }: Problem| {
            let is_parameter = name.split_once('.').is_some_and(|(section, _)| section == PARAMETERS);
            let help = if is_parameter { format!("{help}, and a study in [set.parameters]") } else { help };
            self.refuse::<()>(path, message, &label, help);
        };
        let written = first.iter().find_map(|path| self.value(path)).and_then(|value| value.get_ref().as_str());
        base.field(name).map(|field| field.narrowed(written, &Parameters::default())).map_err(report).ok()
    }

    fn read_rows(&self, path: &str, fields: &[Field]) -> Option<AxisValues> {
        let rows = self.items(&format!("{path}.rows"));
        if rows.is_empty() {
            let help = "give a row of values for each run: rows = [[\"480 N*mm\", \"132.6 N*mm\"], ..]";
            return self.missing("rows", path, help);
        }
        let count = fields.len();
        let read_row = |(index, row): (usize, &Spanned<DeValue<'_>>)| {
            let message = match row.get_ref() {
                DeValue::Array(values) if values.len() == count => {
                    return fields.iter().zip(values).map(|(field, value)| self.read_value(field, value)).collect();
                }
                DeValue::Array(values) => format!("a row has {} values, but {count} fields vary", values.len()),
                other => format!("a row is {}, but must be a list", type_name(other)),
            };
            let help = "write one value for each of `fields`, in their order";
            self.refuse(&format!("{path}.rows.{index}"), message, &format!("{count} values"), help)
        };
        rows.iter().enumerate().map(read_row).collect::<Option<_>>().map(AxisValues::Rows)
    }

    fn read_values(&self, path: &str, field: &Field) -> Option<AxisValues> {
        let rows = self
            .items(&format!("{path}.values"))
            .iter()
            .map(|value| self.read_value(field, value).map(|value| vec![value]));
        let rows: Vec<Vec<AxisValue>> = rows.collect::<Option<_>>()?;
        if let Some(index) = (0..rows.len()).find(|&index| rows[..index].contains(&rows[index])) {
            let message = format!("`{}` has the value {} twice", field.path, rows[index][0].text);
            return self.refuse(&format!("{path}.values.{index}"), message, "repeated here", "remove one of them");
        }
        Some(AxisValues::Rows(rows))
    }

    /// Reads the range of an axis of one field: a grid if it has a count.
    fn read_grid(&self, path: &str, field: &Field, table: &AxisTable) -> Option<AxisValues> {
        if table.from.is_none() && table.to.is_none() {
            return self.missing("values", path, "give values = [..], or a range: from, to and count");
        }
        let range = self.read_range(path, field, table.spacing, "list its values: values = [..]")?;
        match table.count {
            None => Some(AxisValues::Range(range)),
            Some(count @ 2..=1_000_000) => Some(AxisValues::Rows(range.grid(count))),
            Some(count) => {
                let name = &field.path;
                let message = format!("the range of `{name}` has {count} values, but must have from 2 to 1000000");
                self.refuse(&format!("{path}.count"), message, "from 2 to 1000000", "give another count")
            }
        }
    }

    /// Reads the ends `from` and `to` of a range. `remedy` is the advice for a field that is not numeric.
    pub fn read_range(&self, path: &str, field: &Field, spacing: Spacing, remedy: &str) -> Option<Range> {
        let refuse = |key: &str, message: &str, label: &str, help: &str| {
            self.refuse(&format!("{path}.{key}"), message, label, help)
        };
        let name = &field.path;
        let [from, to] = ["from", "to"].map(|key| self.value(&format!("{path}.{key}")));
        let (Some(from), Some(to)) = (from, to) else {
            let key = if from.is_none() { "from" } else { "to" };
            return self.missing(key, path, "a range requires both ends: from and to");
        };
        let [Some(from), Some(to)] = [from, to].map(|end| self.read_value(field, end)) else { return None };
        let Some(range) = Range::between(field, &from, &to, spacing) else {
            let message = format!("`{name}` has no range, because it is not numeric");
            return refuse("from", &message, "not a quantity or a number", remedy);
        };
        if range.from == range.to {
            let message = format!("the ends of the range of `{name}` are equal");
            return refuse("to", &message, "equal to `from`", "give another end");
        }
        if spacing == Spacing::Log && !(range.from > 0.0 && range.to > 0.0) {
            let message = format!("the range of `{name}` is not above 0, as spacing = \"log\" requires");
            let help = "change the range, or use spacing = \"linear\"";
            return refuse("spacing", &message, "requires values above 0", help);
        }
        Some(range)
    }

    pub fn read_value(&self, field: &Field, value: &Spanned<DeValue<'_>>) -> Option<AxisValue> {
        field.read(value).map_err(|problems| self.checker.extend(problems)).ok()
    }
}
