//! Axes of a study: values one by one, or ranges.

use super::field::{Field, Holds, Point};
use crate::numeric::elementary::{ln, pow};
use crate::table::Value;
use crate::units;

/// What varies together: one field, or several by rows of values.
#[derive(Clone, Debug)]
pub struct Axis {
    pub fields: Vec<Field>,
    pub points: Points,
    /// The same designs again, under other conditions: does not count in the number of a design.
    pub again: bool,
}

/// The values of an axis.
#[derive(Clone, Debug)]
pub enum Points {
    /// One value for each field, row by row.
    Given(Vec<Vec<Point>>),
    /// A range of the only field, from which a sample takes its values.
    Range(Range),
}

impl Axis {
    /// How many values; `None` for a range.
    pub fn len(&self) -> Option<usize> {
        match &self.points {
            Points::Given(rows) => Some(rows.len()),
            Points::Range(_) => None,
        }
    }
}

/// How values lie between the ends of a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    Linear,
    Log,
}

/// Numbers or quantities from one to another, both included, in the unit they are given in.
#[derive(Clone, Debug)]
pub struct Range {
    pub from: f64,
    pub to: f64,
    /// Empty for plain numbers.
    pub unit: String,
    pub holds: Holds,
    pub spacing: Spacing,
}

impl Range {
    /// A range of a field between two of its values; `None` if the field has no numbers to be between.
    pub fn between(field: &Field, from: &Point, to: &Point, spacing: Spacing) -> Option<Self> {
        let range =
            |from, to, unit: &str| Range { from, to, unit: unit.to_string(), holds: field.holds.clone(), spacing };
        let (Value::Number(from_si), Value::Number(to_si)) = (&from.value, &to.value) else { return None };
        let Holds::Quantity(dimension) = field.holds else { return Some(range(*from_si, *to_si, "")) };
        // In the unit of the user a third of the way is the number that he would write.
        let ends = [from, to].map(|point| units::split(point.text.trim_matches(['"', '\''])));
        match ends.map(|(number, unit)| (number.parse::<f64>(), unit)) {
            [(Ok(from), unit), (Ok(to), other)] if unit == other => Some(range(from, to, unit)),
            _ => Some(range(*from_si, *to_si, dimension.units()[0].name)),
        }
    }

    /// The value at a part `x` of the way. Of a grid, decimals that are an error of rounding are left out.
    pub fn at(&self, x: f64, grid: bool) -> Point {
        let exact = match self.spacing {
            _ if x == 0.0 => self.from,
            _ if x == 1.0 => self.to,
            Spacing::Linear => self.from + (self.to - self.from) * x,
            Spacing::Log => self.from * pow(self.to / self.from, x),
        };
        let number = if grid { without_noise(exact) } else { exact };
        match self.holds {
            Holds::Quantity(dimension) => {
                let text = format!("{number:?} {}", self.unit);
                let value = units::parse(&text, dimension).map_or(Value::Missing, Value::Number);
                Point { text: format!("\"{text}\""), value }
            }
            _ => Point { text: format!("{number:?}"), value: Value::Number(number) },
        }
    }

    /// Which part of the way a value in SI is.
    pub fn share(&self, si: f64) -> f64 {
        let ends = [self.at(0.0, false), self.at(1.0, false)].map(|point| match point.value {
            Value::Number(number) => number,
            _ => f64::NAN,
        });
        match self.spacing {
            _ if si == ends[0] => 0.0,
            _ if si == ends[1] => 1.0,
            Spacing::Linear => (si - ends[0]) / (ends[1] - ends[0]),
            Spacing::Log => ln(si / ends[0]) / ln(ends[1] / ends[0]),
        }
    }

    /// So many values from end to end.
    pub fn grid(&self, count: u64) -> Vec<Vec<Point>> {
        (0..count).map(|index| vec![self.at(index as f64 / (count - 1) as f64, true)]).collect()
    }
}

/// The short decimal that a number misses by an error of rounding; the number itself if there is none.
fn without_noise(exact: f64) -> f64 {
    let rounded = format!("{exact:.14e}").parse().unwrap_or(exact);
    let digits = format!("{rounded:e}").chars().take_while(|c| *c != 'e').filter(char::is_ascii_digit).count();
    if digits <= 12 { rounded } else { exact }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Dimension;

    fn range(from: (&str, f64), to: (&str, f64), holds: Holds, spacing: Spacing) -> Range {
        let field = Field { path: "x".into(), holds };
        let point = |(text, value): (&str, f64)| Point { text: text.into(), value: value.into() };
        Range::between(&field, &point(from), &point(to), spacing).expect("numbers")
    }

    fn texts(rows: Vec<Vec<Point>>) -> Vec<String> {
        rows.into_iter().flatten().map(|point| point.text).collect()
    }

    #[test]
    fn a_grid_has_the_values_one_would_write() {
        let length = || Holds::Quantity(Dimension::Length);
        let grid = range(("\"12 mm\"", 0.012), ("\"22.5 mm\"", 0.0225), length(), Spacing::Linear).grid(4);
        assert_eq!(grid[1][0].value, Value::Number(0.0155));
        assert_eq!(texts(grid), ["\"12.0 mm\"", "\"15.5 mm\"", "\"19.0 mm\"", "\"22.5 mm\""]);
        let mixed = range(("\"12 mm\"", 0.012), ("\"2 cm\"", 0.02), length(), Spacing::Linear).grid(3);
        assert_eq!(texts(mixed), ["\"0.012 m\"", "\"0.016 m\"", "\"0.02 m\""]);
        let log = range(("1e6", 1e6), ("1e9", 1e9), Holds::Number, Spacing::Log).grid(4);
        assert_eq!(texts(log), ["1000000.0", "10000000.0", "100000000.0", "1000000000.0"]);
        let tenths = range(("0", 0.0), ("1", 1.0), Holds::Number, Spacing::Linear).grid(11);
        assert_eq!(texts(tenths)[3], "0.3");
        let thirds = range(("0", 0.0), ("1", 1.0), Holds::Number, Spacing::Linear).grid(4);
        assert_eq!(thirds[1][0].value, Value::Number(1.0 / 3.0));
    }
}
