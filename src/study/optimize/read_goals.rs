//! Reads objectives and constraints: columns and bounds.

use std::ops::Range as Span;

use super::problem::{ColumnAggregation, ConditionAggregation, Constraint, Figure, Goal, Limit, Objective};
use super::raw::{RawConstraint, RawObjective};
use crate::criteria::Class;
use crate::scene::check::Checker;
use crate::scene::closest_match;
use crate::scene::entry::{Entry, Section};
use crate::scene::keywords::SceneKind;
use crate::scene::toml_value::TomlValue;
use crate::study::select::CLASSES;
use crate::study::sweep::{AnyValue, FieldType, result_columns};
use crate::table::Kind;
use crate::units;

/// Reads the objectives and reports problems to the checker. `leading_columns` is the number of cells before the
/// results in a row.
pub fn objectives(
    checker: &mut Checker<'_>,
    raw: &[Section<RawObjective>],
    kind: SceneKind,
    leading_columns: usize,
) -> Vec<Objective> {
    if raw.is_empty() && checker.is_clean() {
        let help = "add a figure to minimise or maximise: [[objectives]] with column = \"tts_s\"";
        checker.push(None, "there are no [[objectives]]", "", help);
    }
    raw.iter().filter_map(|raw| objective(checker, raw, kind, leading_columns)).collect()
}

fn objective(
    checker: &mut Checker<'_>,
    raw: &Section<RawObjective>,
    kind: SceneKind,
    leading_columns: usize,
) -> Option<Objective> {
    let (goal, condition_aggregation) =
        (checker.get_or("goal", &raw.goal, Goal::Min), checker.get_or("over", &raw.over, ConditionAggregation::Worst));
    let aggregation = checker.get_or("of", &raw.of, ColumnAggregation::Largest);
    let name = checker.get("name", &raw.name);
    let columns: Vec<(String, Option<Span<usize>>)> = match (raw.column.is_present(), raw.columns.is_present()) {
        (true, false) => {
            checker.report_unused("of", &raw.of, "with one column");
            vec![(checker.get("column", &raw.column)?, raw.column.span())]
        }
        (false, true) => read_columns(checker, raw)?,
        (true, true) => {
            let message = "an objective has both `column` and `columns`";
            checker.push(raw.columns.span(), message, "repeated here", "keep one of them");
            return None;
        }
        (false, false) => {
            checker.report_missing("column", raw, "name a column of the results: column = \"tts_s\"");
            return None;
        }
    };
    let (mut cells, mut types) = (Vec::new(), Vec::new());
    for (column, span) in &columns {
        let (cell, column_type) = find_column(checker, column, span.clone(), kind, leading_columns)?;
        if !matches!(column_type.column_kind(), Kind::Number | Kind::Integer) {
            let message = format!("`{column}` is not numeric, so it cannot be an objective");
            let help = "use it as a constraint: [[constraints]] with column and equals or at_least";
            checker.push(span.clone(), message, "not numeric", help);
            return None;
        }
        cells.push(cell);
        types.push(column_type);
    }
    let column_type = match &types[..] {
        [first, others @ ..] if others.iter().all(|other| other == first) => (*first).clone(),
        _ => FieldType::Number,
    };
    let columns: Vec<String> = columns.into_iter().map(|(column, _)| column).collect();
    let name = name.unwrap_or_else(|| match (&columns[..], aggregation) {
        ([column], _) => column.clone(),
        (names, ColumnAggregation::Largest) => format!("largest_{}", names.join("_")),
        (names, ColumnAggregation::Smallest) => format!("smallest_{}", names.join("_")),
        (names, ColumnAggregation::Sum) => format!("sum_{}", names.join("_")),
    });
    Some(Objective { figure: Figure { name, columns, aggregation, column_type, cells }, goal, condition_aggregation })
}

/// Reads the names of several columns.
fn read_columns(checker: &mut Checker<'_>, raw: &RawObjective) -> Option<Vec<(String, Option<Span<usize>>)>> {
    let mut columns = Vec::new();
    for item in checker.get("columns", &raw.columns)? {
        let TomlValue::Text(name) = item.get_ref() else {
            let message = format!("`columns` contains {}, but must contain column names", item.get_ref().name());
            let help = "write columns = [\"peak_f21_n\", \"peak_f22_n\"]";
            checker.push(Some(item.span()), message, "a string", help);
            return None;
        };
        columns.push((name.clone(), Some(item.span())));
    }
    Some(columns)
}

/// Returns the index of a column in a row, and its type.
fn find_column(
    checker: &mut Checker<'_>,
    column: &str,
    span: Option<Span<usize>>,
    kind: SceneKind,
    leading_columns: usize,
) -> Option<(usize, &'static FieldType)> {
    let columns = result_columns(kind);
    if let Some(index) = columns.iter().position(|(name, _)| *name == column) {
        return Some((leading_columns + index, &columns[index].1));
    }
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).filter(|name| !name.starts_with("check")).collect();
    let label = closest_match(column, &names).map_or("not a column".into(), |near| format!("did you mean \"{near}\"?"));
    let message = format!("the results have no column `{}`", column.escape_debug());
    checker.push(span, message, label, format!("columns of a run: {}", names.join(", ")));
    None
}

/// Reads the constraints and reports problems to the checker.
pub fn constraints(
    checker: &mut Checker<'_>,
    raw: &[Section<RawConstraint>],
    kind: SceneKind,
    leading_columns: usize,
) -> Vec<Constraint> {
    raw.iter().filter_map(|raw| constraint(checker, raw, kind, leading_columns)).collect()
}

fn constraint(
    checker: &mut Checker<'_>,
    raw: &Section<RawConstraint>,
    kind: SceneKind,
    leading_columns: usize,
) -> Option<Constraint> {
    if !raw.column.is_present() {
        checker.report_missing("column", raw, "name a column of the results: column = \"class\"");
        return None;
    }
    let column = checker.get("column", &raw.column)?;
    let (cell, column_type) = find_column(checker, &column, raw.column.span(), kind, leading_columns)?;
    if !(raw.at_least.is_present() || raw.at_most.is_present() || raw.equals.is_present()) {
        let help = match column_type.column_kind() {
            Kind::Number | Kind::Integer => "give a bound: at_least = .. or at_most = ..",
            Kind::Flag => "give the required value: equals = true",
            Kind::Text if column == "class" => "give the worst class allowed: at_least = \"semi-stable\"",
            Kind::Text => "give the required value: equals = \"..\"",
        };
        checker.report_missing("at_least", raw, help);
        return None;
    }
    let limit = match column_type.column_kind() {
        Kind::Number | Kind::Integer => {
            checker.report_unused("equals", &raw.equals, "on a numeric column: give at_least and at_most");
            let at_least = bound(checker, "at_least", &raw.at_least, &column, column_type)?;
            let at_most = bound(checker, "at_most", &raw.at_most, &column, column_type)?;
            if let (Some(lower), Some(upper)) = (at_least, at_most)
                && lower > upper
            {
                let message = format!("no value is at least {lower} and at most {upper}");
                checker.push(raw.at_most.span(), message, "below at_least", "swap the bounds, or give other bounds");
                return None;
            }
            Limit::Between { at_least, at_most }
        }
        Kind::Flag | Kind::Text => {
            checker.report_unused("at_most", &raw.at_most, "on a column that is not numeric");
            return text_limit(checker, raw, &column, column_type.column_kind()).map(|limit| Constraint {
                column,
                limit,
                cell,
            });
        }
    };
    Some(Constraint { column, limit, cell })
}

/// Reads the limit of a text or boolean column.
fn text_limit(checker: &mut Checker<'_>, raw: &RawConstraint, column: &str, column_kind: Kind) -> Option<Limit> {
    let is_class = column == "class";
    if !is_class {
        checker.report_unused("at_least", &raw.at_least, "on a column without an order: give equals");
    }
    let (key, entry) =
        if is_class && raw.at_least.is_present() { ("at_least", &raw.at_least) } else { ("equals", &raw.equals) };
    let value = checker.get(key, entry)?;
    let span = Some(value.span());
    match (column_kind, value.get_ref()) {
        (Kind::Flag, TomlValue::Flag(flag)) => Some(Limit::Flag(*flag)),
        (Kind::Flag, other) => {
            let message = format!("`{key}` is {}, but `{column}` contains true or false", other.name());
            checker.push(span, message, "true or false", "write true or false, without quotes");
            None
        }
        (_, TomlValue::Text(text)) if is_class => {
            let names = CLASSES.map(Class::name);
            let Some(rank) = names.iter().position(|name| name == text) else {
                let label = closest_match(text, &names)
                    .map_or("not a class".into(), |near| format!("did you mean \"{near}\"?"));
                let message = format!("there is no class \"{}\"", text.escape_debug());
                checker.push(span, message, label, format!("classes, from good to bad: {}", names.join(", ")));
                return None;
            };
            Some(if key == "equals" { Limit::Equals(text.clone()) } else { Limit::Class(rank) })
        }
        (_, TomlValue::Text(text)) => Some(Limit::Equals(text.clone())),
        (_, other) => {
            let message = format!("`{key}` is {}, but `{column}` contains text", other.name());
            checker.push(span, message, "a string in quotes", "write the value as in the results, in quotes");
            None
        }
    }
}

/// Reads a bound: a number in the unit of the column, or a quantity. `None` if it is invalid, `Some(None)` if it is not
/// given.
#[expect(clippy::option_option)]
fn bound(
    checker: &mut Checker<'_>,
    key: &str,
    entry: &Entry<AnyValue>,
    column: &str,
    column_type: &FieldType,
) -> Option<Option<f64>> {
    if !entry.is_present() {
        return Some(None);
    }
    let value = checker.get(key, entry)?;
    let span = Some(value.span());
    match value.get_ref() {
        TomlValue::Integer(integer) => Some(Some(*integer as f64)),
        TomlValue::Float(number) if number.is_finite() => Some(Some(*number)),
        TomlValue::Text(text) => match column_type {
            FieldType::Quantity(dimension) => match units::parse(text, *dimension) {
                Ok(si) => Some(Some(si)),
                Err(error) => {
                    let help = format!("write a number and its unit, as in \"{}\"", dimension.example());
                    checker.push(span, format!("`{key}`: {error}"), dimension.name(), help);
                    None
                }
            },
            _ => {
                let message = format!("`{key}` is a string, but a bound of `{column}` must be a plain number");
                checker.push(
                    span,
                    message,
                    "a number",
                    "write it without quotes, in the unit at the end of the column name",
                );
                None
            }
        },
        other => {
            let message = format!("`{key}` is {}, but must be a number", other.name());
            checker.push(span, message, "a number", "write a number in the unit at the end of the column name");
            None
        }
    }
}
