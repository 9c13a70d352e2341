//! Objectives and constraints: figures of a run, which are columns of its results.

use toml::de::DeValue;

use super::tables::{ConstraintTable, ObjectiveTable};
use super::{Constraint, Objective, Variable};
use crate::criteria::Class;
use crate::scene::written::{number, type_name};
use crate::study::sweep::{Document, Field, column_kind, list_first, result_type, similar};
use crate::table::{Kind, Value};

/// Reports the unknown column at a path.
fn check_column(document: &Document<'_>, path: &str, name: &str, names: &[String]) -> Option<()> {
    if names.iter().any(|known| known == name) {
        return Some(());
    }
    let known: Vec<String> = names.iter().filter(|known| !known.starts_with("check")).cloned().collect();
    let help = format!("{}the columns of a run are {}", similar(name, &known), list_first(&known));
    document.refuse(path, format!("the results have no column `{name}`"), "unknown column", help)
}

pub(super) fn read_objectives(document: &Document<'_>, tables: &[ObjectiveTable], names: &[String]) -> Vec<Objective> {
    let read = |(index, table): (usize, &ObjectiveTable)| {
        read_objective(document, &format!("objectives.{index}"), table, names)
    };
    tables.iter().enumerate().filter_map(read).collect()
}

fn read_objective(document: &Document<'_>, path: &str, table: &ObjectiveTable, names: &[String]) -> Option<Objective> {
    let is_single = !table.column.is_empty();
    if is_single && !table.columns.is_empty() {
        let message = "an objective has both `column` and `columns`";
        return document.refuse(&format!("{path}.columns"), message, "repeated here", "keep one of them");
    }
    let columns = if is_single { vec![table.column.clone()] } else { table.columns.clone() };
    if columns.is_empty() {
        return document.missing("column", path, "name a column of the results: column = \"tts_s\"");
    }
    for (index, name) in columns.iter().enumerate() {
        let at = if is_single { format!("{path}.column") } else { format!("{path}.columns.{index}") };
        check_column(document, &at, name, names)?;
        if !is_numeric(name) {
            let message = format!("`{name}` is not numeric, so it cannot be an objective");
            let help = "use it as a constraint: [[constraints]] with column and equals or at_least";
            return document.refuse(&at, message, "not a number", help);
        }
    }
    let ObjectiveTable { of, goal, over, .. } = *table;
    let aggregation = serde_json::to_value(of).ok()?;
    let name = match (&columns[..], &table.name) {
        (_, name) if !name.is_empty() => name.clone(),
        ([column], _) => column.clone(),
        _ => format!("{}_{}", aggregation.as_str()?, columns.join("_")),
    };
    Some(Objective { name, columns, of, goal, over })
}

fn is_numeric(column: &str) -> bool {
    matches!(column_kind(&result_type(column)), Kind::Number | Kind::Integer)
}

pub(super) fn read_constraints(
    document: &Document<'_>,
    tables: &[ConstraintTable],
    names: &[String],
) -> Vec<Constraint> {
    let read = |(index, table): (usize, &ConstraintTable)| {
        let path = format!("constraints.{index}");
        if table.column.is_empty() {
            return document.missing("column", &path, "name a column of the results: column = \"class\"");
        }
        check_column(document, &format!("{path}.column"), &table.column, names)?;
        read_constraint(document, &path, &table.column)
    };
    tables.iter().enumerate().filter_map(read).collect()
}

/// Reads the limits of the constraint on a column.
fn read_constraint(document: &Document<'_>, path: &str, column: &str) -> Option<Constraint> {
    let kind = column_kind(&result_type(column));
    let (allowed, help): (&[&str], _) = match kind {
        _ if column == "class" => (&["at_least", "equals"], "give the worst class allowed: at_least = \"semi-stable\""),
        Kind::Number | Kind::Integer => (&["at_least", "at_most"], "give a bound: at_least = .. or at_most = .."),
        Kind::Flag => (&["equals"], "give the required value: equals = true"),
        Kind::Text => (&["equals"], "give the required value: equals = \"..\""),
    };
    let at = |key: &str| format!("{path}.{key}");
    let given: Vec<&str> =
        ["at_least", "at_most", "equals"].into_iter().filter(|key| document.span(&at(key)).is_some()).collect();
    if let Some(key) = given.iter().find(|key| !allowed.contains(*key)) {
        let message = format!("`{key}` has no effect on the column `{column}`");
        return document.refuse(&at(key), message, "no effect", help);
    }
    let Some(key) = given.first() else {
        let message = format!("the constraint on `{column}` has no limit");
        return document.refuse(path, message, "no limit", help);
    };
    let constraint = Constraint { column: column.to_string(), ..Constraint::default() };
    if is_numeric(column) {
        let [at_least, at_most] = ["at_least", "at_most"].map(|key| read_bound(document, &at(key), key, column));
        let (at_least, at_most) = (at_least?, at_most?);
        if let (Some(least), Some(most)) = (at_least, at_most)
            && least > most
        {
            let message = format!("no value is at least {least} and at most {most}");
            return document.refuse(
                &at("at_most"),
                message,
                "below `at_least`",
                "swap the bounds, or give other bounds",
            );
        }
        return Some(Constraint { at_least, at_most, ..constraint });
    }
    let refuse = |value: &DeValue<'_>, contents: &str, help: &str| {
        let message = format!("`{key}` is {}, but `{column}` contains {contents}", type_name(value));
        document.refuse(&at(key), message, contents, help)
    };
    match (kind, document.value(&at(key))?.get_ref()) {
        (Kind::Flag, DeValue::Boolean(flag)) => Some(Constraint { equals: Some((*flag).into()), ..constraint }),
        (Kind::Flag, value) => refuse(value, "true or false", "write true or false, without quotes"),
        (_, DeValue::String(text)) if column == "class" => {
            let classes = Class::ALL.map(|class| class.name().to_string());
            let Some(index) = classes.iter().position(|class| class == text) else {
                let help =
                    format!("{}the classes are, from good to bad, {}", similar(text, &classes), classes.join(", "));
                return document.refuse(&at(key), format!("there is no class \"{text}\""), "unknown class", help);
            };
            Some(match *key {
                "at_least" => Constraint { worst_class: Some(index), ..constraint },
                _ => Constraint { equals: Some(text.as_ref().into()), ..constraint },
            })
        }
        (_, DeValue::String(text)) => Some(Constraint { equals: Some(text.as_ref().into()), ..constraint }),
        (_, value) => refuse(value, "text", "write the value as in the results, in quotes"),
    }
}

/// Reads an optional bound of a column: a number in the unit of the column, or a quantity. `None` if it is invalid.
fn read_bound(document: &Document<'_>, path: &str, key: &str, column: &str) -> Option<Option<f64>> {
    let Some(value) = document.value(path) else { return Some(None) };
    match number(value.get_ref()) {
        Some(toml::Value::Integer(integer)) => return Some(Some(integer as f64)),
        Some(toml::Value::Float(number)) if number.is_finite() => return Some(Some(number)),
        _ => {}
    }
    let field = Field { path: key.to_string(), field_type: result_type(column) };
    match document.read_value(&field, value)?.value {
        Value::Number(number) => Some(Some(number)),
        Value::Integer(integer) => Some(Some(integer as f64)),
        _ => None,
    }
}

/// Columns of the designs that every search has.
const DESIGN_COLUMNS: [&str; 9] =
    ["design", "generation", "completed", "filtered", "refused", "failed", "violation", "feasible", "front"];

/// Reports columns of the results with equal names.
pub(super) fn check_names(
    document: &Document<'_>,
    variables: &[Variable],
    objectives: &[Objective],
    constraints: &[Constraint],
) {
    let of_variables = variables.iter().map(|variable| variable.field.column());
    let of_constraints = constraints.iter().map(|constraint| format!("worst_{}", constraint.column));
    let mut taken: Vec<String> =
        DESIGN_COLUMNS.iter().map(ToString::to_string).chain(of_variables).chain(of_constraints).collect();
    for (index, Objective { name, .. }) in objectives.iter().enumerate() {
        if taken.contains(name) {
            let message = format!("the results would have two columns `{name}`");
            let help = "give the objective another name: name = ..";
            document.refuse::<()>(&format!("objectives.{index}"), message, "a repeated name", help);
        }
        taken.push(name.clone());
    }
    for (index, Constraint { column, .. }) in constraints.iter().enumerate() {
        if constraints[..index].iter().any(|other| other.column == *column) {
            let message = format!("there are two constraints on `{column}`");
            let help = "combine them in one constraint";
            document.refuse::<()>(&format!("constraints.{index}.column"), message, "repeated here", help);
        }
    }
}
