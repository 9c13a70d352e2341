//! Variables with their start values, and conditions.

use toml::de::DeTable;

use super::Variable;
use super::tables::{OptimisationFile, VariableTable};
use crate::scene::{
    Layer, LocatedProblem, Problem, Scene, SceneError, locate_problems, parse_field, parse_layers, show_written,
};
use crate::study::parameter::value_in;
use crate::study::sweep::{AxisValue, AxisValues, Base, Document, Field, Range};

/// The field of a variable with its path in the document, its range, and its start value in the study.
pub(super) struct FieldRange {
    path: String,
    field: Field,
    range: Range,
    start: Option<AxisValue>,
}

/// Reads the ranges of all valid variables.
pub(super) fn read_ranges(document: &Document<'_>, tables: &[VariableTable], base: &Base) -> Vec<FieldRange> {
    let mut ranges: Vec<FieldRange> = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        let path = format!("variables.{index}");
        let Some(read) = read_variable(document, path, table, base) else { continue };
        let name = &read.field.path;
        if ranges.iter().any(|other| other.field.path == *name) {
            let message = format!("`{name}` is declared twice");
            document.refuse::<()>(&format!("{}.field", read.path), message, "repeated here", "remove one of them");
            continue;
        }
        ranges.push(read);
    }
    ranges
}

fn read_variable(document: &Document<'_>, path: String, table: &VariableTable, base: &Base) -> Option<FieldRange> {
    if table.field.is_empty() {
        return document.missing("field", &path, "name the scene field to vary: field = \"design.base\"");
    }
    let field = document.read_field(
        &format!("{path}.field"),
        &table.field,
        base,
        ["from", "to"].map(|key| format!("{path}.{key}")),
    )?;
    let range = document.read_range(&path, &field, table.spacing, "vary another field")?;
    let start = match document.value(&format!("{path}.start")) {
        Some(start) => Some(document.read_value(&field, start)?),
        None => None,
    };
    Some(FieldRange { path, field, range, start })
}

/// Returns the base scene with the start values of the study, as texts and as a scene.
///
/// # Errors
/// Returns the problems of variables, or those of the scene at their positions in its files.
pub(super) fn start_scene(
    document: &mut Document<'_>,
    ranges: &[FieldRange],
) -> Result<(Vec<Layer>, Scene), SceneError> {
    let start = |range: &FieldRange| parse_field(&range.field.path).ok().zip(range.start.as_ref()?.toml());
    let layers = document.scene_layers(ranges.iter().filter_map(start).collect());
    let error = match parse_layers(&layers, &[]) {
        Ok(scene) => return Ok((layers, scene)),
        Err(error) => error,
    };
    document.check()?;
    let problems = locate_problems(&error);
    if problems.iter().any(|problem| problem.file != document.file_name) {
        return Err(error);
    }
    // The last text is none of the user's.
    let in_study = |found: LocatedProblem| {
        let field = found.field.unwrap_or_default();
        let start = ranges.iter().find(|range| range.start.is_some() && range.field.path == field);
        let span = match start {
            Some(range) => document.span(&format!("{}.start", range.path)),
            None => document.scene_span(&field),
        };
        Problem::new(span, found.message, "in the base scene", found.help)
    };
    Err(document.invalid(problems.into_iter().map(in_study).collect()))
}

/// Reads the start values, by default those of the base scene.
pub(super) fn read_starts(document: &Document<'_>, ranges: Vec<FieldRange>, scene: &Scene) -> Vec<Variable> {
    let text = show_written(scene);
    let written = DeTable::parse(&text).map_or_else(|_| DeTable::new(), toml::Spanned::into_inner);
    let read = |FieldRange { path, field, range, start }: FieldRange| {
        let name = &field.path;
        let key = format!("{path}.{}", if start.is_some() { "start" } else { "field" });
        let in_scene = || parse_field(name).and_then(|parts| value_in(&written, &parts)).ok().flatten();
        let start = match (start, in_scene()) {
            (Some(start), _) => start,
            (None, Some(value)) => match field.read(value) {
                Ok(start) => start,
                Err(problems) => {
                    let at_key = |problem| Problem { span: document.span(&key), ..problem };
                    document.checker.extend(problems.into_iter().map(at_key).collect());
                    return None;
                }
            },
            (None, None) => {
                let message = format!("the base scene has no start value for `{name}`");
                let help = "give a start value: start = .., or add the field to the scene";
                return document.refuse(&key, message, "no start value", help);
            }
        };
        let start_fraction = start.value.as_number().map_or(f64::NAN, |si| range.fraction_of(si));
        if !(0.0..=1.0).contains(&start_fraction) {
            let message =
                format!("the start value of `{name}`, {}, is outside its range", start.text.trim_matches(['"', '\'']));
            let help = "widen the range, or give a start value within it: start = ..";
            return document.refuse(&key, message, "outside the range", help);
        }
        Some(Variable { field, range, start, start_fraction })
    };
    ranges.into_iter().filter_map(read).collect()
}

/// The fields of conditions with their rows of values.
pub(super) type Conditions = (Vec<Field>, Vec<Vec<AxisValue>>);

pub(super) fn read_conditions(document: &Document<'_>, file: &OptimisationFile, base: &Base) -> Vec<Conditions> {
    let mut conditions: Vec<Conditions> = Vec::new();
    for (index, table) in file.conditions.iter().enumerate() {
        let path = format!("conditions.{index}");
        let Some(axis) = document.read_axis(&path, table, base) else { continue };
        let key = format!("{path}.{}", table.key());
        for Field { path: name, .. } in &axis.fields {
            if file.variables.iter().any(|variable| variable.field == *name) {
                let message = format!("`{name}` is both a variable and a condition");
                let help = "remove one of them: a field can be either varied or prescribed";
                document.refuse::<()>(&key, message, "repeated here", help);
            } else if conditions.iter().flat_map(|(fields, _)| fields).any(|other| other.path == *name) {
                let message = format!("`{name}` is given by two conditions");
                document.refuse::<()>(&key, message, "repeated here", "remove one of them");
            }
        }
        match axis.values {
            AxisValues::Rows(rows) => conditions.push((axis.fields, rows)),
            AxisValues::Range(_) => {
                let help = "give the number of values of the range: count = 3";
                document.missing::<()>("count", &path, help);
            }
        }
    }
    conditions
}

/// All combinations of the conditions, the last one fastest.
pub(super) fn combinations(conditions: &[Conditions]) -> Vec<Vec<(String, AxisValue)>> {
    conditions.iter().fold(vec![Vec::new()], |combined, (fields, rows)| {
        let extended = |given: &Vec<(String, AxisValue)>, row: &Vec<AxisValue>| {
            let more = fields.iter().map(|field| field.path.clone()).zip(row.iter().cloned());
            given.iter().cloned().chain(more).collect()
        };
        combined.iter().flat_map(|given| rows.iter().map(move |row| extended(given, row))).collect()
    })
}
