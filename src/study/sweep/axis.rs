//! Axes of a study: lists of values, or ranges.

use schemars::JsonSchema;
use serde::Deserialize;

use super::field::{AxisValue, Field, FieldType};
use crate::numeric::elementary::pow;
use crate::table::Value;
use crate::units;

/// One field, or several that vary together.
#[derive(Clone, Debug)]
pub struct Axis {
    pub fields: Vec<Field>,
    pub values: AxisValues,
    /// Whether the axis repeats the same designs under other conditions and is not part of the design number.
    pub repeats_designs: bool,
}

/// The values of an axis.
#[derive(Clone, Debug)]
pub(crate) enum AxisValues {
    /// One value for each field, row by row.
    Rows(Vec<Vec<AxisValue>>),
    /// A range of the only field; the sample determines its values.
    Range(Range),
}

impl Axis {
    /// Number of values; `None` for a range.
    pub fn len(&self) -> Option<usize> {
        match &self.values {
            AxisValues::Rows(rows) => Some(rows.len()),
            AxisValues::Range(_) => None,
        }
    }
}

/// Spacing of the values in a range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Spacing {
    #[default]
    Linear,
    Log,
}

/// Closed interval of numbers or quantities, in the unit of the study file.
#[derive(Clone, Debug)]
pub struct Range {
    pub from: f64,
    pub to: f64,
    /// Unit; empty for plain numbers.
    pub unit: String,
    pub field_type: FieldType,
    pub spacing: Spacing,
}

impl Range {
    /// Range between two values of a field; `None` if the field is not numeric.
    pub fn between(field: &Field, from: &AxisValue, to: &AxisValue, spacing: Spacing) -> Option<Self> {
        let range = |from, to, unit: &str| Range {
            from,
            to,
            unit: unit.to_string(),
            field_type: field.field_type.clone(),
            spacing,
        };
        let (Value::Number(from_si), Value::Number(to_si)) = (&from.value, &to.value) else { return None };
        let FieldType::Quantity(dimension) = field.field_type else { return Some(range(*from_si, *to_si, "")) };
        // Interpolation in the unit of the file yields the numbers that a user would write.
        let ends = [from, to].map(|end| units::split_quantity(end.text.trim_matches(['"', '\''])));
        match ends.map(|(number, unit)| (number.parse::<f64>(), unit)) {
            [(Ok(from), unit), (Ok(to), to_unit)] if unit == to_unit => Some(range(from, to, unit)),
            _ => Some(range(*from_si, *to_si, dimension.units()[0].name)),
        }
    }

    /// Value at fraction `x` of the range. With `is_grid`, rounding errors in the last decimals are removed.
    pub(crate) fn value_at(&self, x: f64, is_grid: bool) -> AxisValue {
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
                let value = units::parse(&text, dimension).map_or(Value::Missing, Value::Number);
                AxisValue { text: format!("\"{text}\""), value }
            }
            _ => AxisValue { text: format!("{number:?}"), value: Value::Number(number) },
        }
    }

    /// Grid of `count` values including both ends.
    pub fn grid(&self, count: u64) -> Vec<Vec<AxisValue>> {
        (0..count).map(|index| vec![self.value_at(index as f64 / (count - 1) as f64, true)]).collect()
    }
}

/// Rounds to 15 significant digits if that leaves at most 12; otherwise returns the number unchanged.
fn strip_rounding_error(exact: f64) -> f64 {
    let rounded = format!("{exact:.14e}").parse().unwrap_or(exact);
    let digits =
        format!("{rounded:e}").chars().take_while(|checker| *checker != 'e').filter(char::is_ascii_digit).count();
    if digits <= 12 { rounded } else { exact }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Dimension;

    fn range(from: (&str, f64), to: (&str, f64), field_type: FieldType, spacing: Spacing) -> Range {
        let field = Field { path: "x".into(), field_type };
        let end = |(text, value): (&str, f64)| AxisValue { text: text.into(), value: value.into() };
        Range::between(&field, &end(from), &end(to), spacing).expect("numbers")
    }

    fn texts(rows: Vec<Vec<AxisValue>>) -> Vec<String> {
        rows.into_iter().flatten().map(|value| value.text).collect()
    }

    #[test]
    fn grid_values_have_no_rounding_noise() {
        let length = || FieldType::Quantity(Dimension::Length);
        let grid = range(("\"12 mm\"", 0.012), ("\"22.5 mm\"", 0.0225), length(), Spacing::Linear).grid(4);
        assert_eq!(grid[1][0].value, Value::Number(0.0155));
        assert_eq!(texts(grid), ["\"12.0 mm\"", "\"15.5 mm\"", "\"19.0 mm\"", "\"22.5 mm\""]);
        let mixed = range(("\"12 mm\"", 0.012), ("\"2 cm\"", 0.02), length(), Spacing::Linear).grid(3);
        assert_eq!(texts(mixed), ["\"0.012 m\"", "\"0.016 m\"", "\"0.02 m\""]);
        let log = range(("1e6", 1e6), ("1e9", 1e9), FieldType::Number, Spacing::Log).grid(4);
        assert_eq!(texts(log), ["1000000.0", "10000000.0", "100000000.0", "1000000000.0"]);
        let tenths = range(("0", 0.0), ("1", 1.0), FieldType::Number, Spacing::Linear).grid(11);
        assert_eq!(texts(tenths)[3], "0.3");
        let thirds = range(("0", 0.0), ("1", 1.0), FieldType::Number, Spacing::Linear).grid(4);
        assert_eq!(thirds[1][0].value, Value::Number(1.0 / 3.0));
    }
}
