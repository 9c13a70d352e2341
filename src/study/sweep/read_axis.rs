//! Reads the axes of a study file.

use std::ops::Range as Span;

use toml::Spanned;

use super::axis::{Axis, AxisValues, Range, Spacing};
use super::field::{AxisValue, Field};
use super::raw::{AnyValue, RawAxis};
use crate::scene::check::Checker;
use crate::scene::entry::{Entry, Section};
use crate::scene::keywords::SceneKind;
use crate::scene::schema::schema_for;
use crate::scene::toml_value::TomlValue;
use crate::scene::value_kinds::Choice;
use crate::table::Value;

/// Reads all valid axes and reports problems of the others. A study without axes runs its scene once.
pub(in crate::study) fn read_axes(checker: &mut Checker<'_>, raw: &[Section<RawAxis>], kind: SceneKind) -> Vec<Axis> {
    let mut axes: Vec<Axis> = Vec::new();
    for axis in raw {
        let span = axis.field.span().or(axis.fields.span());
        let Some(axis) = read_axis(checker, axis, kind) else { continue };
        for field in &axis.fields {
            let is_duplicate = axes.iter().flat_map(|other| &other.fields).any(|other| other.path == field.path);
            if is_duplicate {
                let message = format!("`{}` is varied by two axes", field.path);
                checker.push(
                    span.clone(),
                    message,
                    "repeated here",
                    "keep one of the axes, with all values of the field",
                );
            }
        }
        axes.push(axis);
    }
    axes
}

fn read_axis(checker: &mut Checker<'_>, raw: &Section<RawAxis>, kind: SceneKind) -> Option<Axis> {
    let repeats_designs = checker.get_or("again", &raw.again, false);
    match (raw.field.is_present(), raw.fields.is_present()) {
        (true, false) => read_single_field(checker, raw, repeats_designs, kind),
        (false, true) => read_joint_fields(checker, raw, repeats_designs, kind),
        (true, true) => {
            checker.push(
                raw.fields.span(),
                "an axis has both `field` and `fields`",
                "repeated here",
                "keep one of them",
            );
            None
        }
        (false, false) => {
            checker.report_missing("field", raw, "name the field of the scene that varies: field = \"design.base\"");
            None
        }
    }
}

/// Reads an axis of one field: values, or a range.
fn read_single_field(
    checker: &mut Checker<'_>,
    raw: &Section<RawAxis>,
    repeats_designs: bool,
    kind: SceneKind,
) -> Option<Axis> {
    checker.report_unused("rows", &raw.rows, "in an axis of one field, whose values are `values`");
    let path = checker.get("field", &raw.field)?;
    let field = find_field(checker, &path, raw.field.span(), kind)?;
    let has_range = raw.from.is_present() || raw.to.is_present();
    if raw.values.is_present() {
        for (key, is_present) in [("from", raw.from.is_present()), ("to", raw.to.is_present())] {
            if is_present {
                let message = format!("the axis of `{path}` has `values` and `{key}`");
                checker.push(
                    raw.values.span(),
                    message,
                    "values here",
                    "keep one of them: values, or from, to and count",
                );
                return None;
            }
        }
        checker.report_unused("count", &raw.count, "together with `values`");
        checker.report_unused("spacing", &raw.spacing, "together with `values`");
        let values = checker.get("values", &raw.values)?;
        let rows: Vec<Vec<AxisValue>> = values
            .iter()
            .map(|value| read_value(checker, &field, value).map(|axis_value| vec![axis_value]))
            .collect::<Option<_>>()?;
        if let Some(index) = (0..rows.len()).find(|&index| rows[..index].contains(&rows[index])) {
            let message = format!("`{path}` has the value {} twice", rows[index][0].text);
            checker.push(raw.values.item_span(index), message, "repeated here", "remove one of them");
            return None;
        }
        return Some(Axis { fields: vec![field], values: AxisValues::Rows(rows), repeats_designs });
    }
    if !has_range {
        checker.report_missing("values", raw, "give values = [..], or a range: from, to and count");
        return None;
    }
    read_range_axis(checker, raw, field, repeats_designs)
}

/// Reads an axis of one field over a range.
fn read_range_axis(
    checker: &mut Checker<'_>,
    raw: &Section<RawAxis>,
    field: Field,
    repeats_designs: bool,
) -> Option<Axis> {
    let range = read_range(checker, raw, &field, [&raw.from, &raw.to], &raw.spacing)?;
    if !raw.count.is_present() {
        if repeats_designs {
            let message = format!("the sampled axis `{}` cannot repeat the same designs", field.path);
            checker.push(raw.again.span(), message, "a sampled axis", "remove `again`, or give `count` or `values`");
            return None;
        }
        return Some(Axis { fields: vec![field], values: AxisValues::Range(range), repeats_designs });
    }
    match checker.get("count", &raw.count)? {
        count @ 2..=1_000_000 => {
            Some(Axis { fields: vec![field], values: AxisValues::Rows(range.grid(count)), repeats_designs })
        }
        count => {
            let message = format!("the range of `{}` has {count} values, but must have from 2 to 1000000", field.path);
            checker.push(raw.count.span(), message, "from 2 to 1000000", "give another count");
            None
        }
    }
}

/// Reads the range of a field between two entries of a section.
pub(in crate::study) fn read_range<T>(
    checker: &mut Checker<'_>,
    section: &Section<T>,
    field: &Field,
    [first, last]: [&Entry<AnyValue>; 2],
    spacing: &Entry<Choice<Spacing>>,
) -> Option<Range> {
    for (key, is_present) in [("from", first.is_present()), ("to", last.is_present())] {
        if !is_present {
            checker.report_missing(key, section, "a range requires both ends: from and to");
            return None;
        }
    }
    let ends = [("from", first), ("to", last)].map(|(key, entry)| {
        let value = checker.get(key, entry)?;
        read_value(checker, field, &value)
    });
    let [Some(from), Some(to)] = ends else { return None };
    let spacing_kind = checker.get_or("spacing", spacing, Spacing::Linear);
    let Some(range) = Range::between(field, &from, &to, spacing_kind) else {
        let message = format!("`{}` has no range, because it is not numeric", field.path);
        checker.push(first.span(), message, "not a quantity or a number", "list its values: values = [..]");
        return None;
    };
    if range.from == range.to {
        let message = format!("the ends of the range of `{}` are equal", field.path);
        checker.push(last.span(), message, "equal to `from`", "give another end, or a single value: values = [..]");
        return None;
    }
    if spacing_kind == Spacing::Log && !(range.from > 0.0 && range.to > 0.0) {
        let message = format!("the range of `{}` is not above 0, as spacing = \"log\" requires", field.path);
        checker.push(
            spacing.span(),
            message,
            "requires values above 0",
            "change the range, or use spacing = \"linear\"",
        );
        return None;
    }
    Some(range)
}

/// Reads an axis of several fields with rows of values.
fn read_joint_fields(
    checker: &mut Checker<'_>,
    raw: &Section<RawAxis>,
    repeats_designs: bool,
    kind: SceneKind,
) -> Option<Axis> {
    let reason = "in an axis of several fields, whose values are `rows`";
    checker.report_unused("values", &raw.values, reason);
    checker.report_unused("from", &raw.from, reason);
    checker.report_unused("to", &raw.to, reason);
    checker.report_unused("count", &raw.count, reason);
    checker.report_unused("spacing", &raw.spacing, reason);
    let mut fields: Vec<Field> = Vec::new();
    for name in checker.get("fields", &raw.fields)? {
        let TomlValue::Text(path) = name.get_ref() else {
            let message = format!("`fields` contains {}, but must contain names of fields", name.get_ref().name());
            checker.push(
                Some(name.span()),
                message,
                "a string",
                "write fields = [\"motor.torque\", \"spring.torque\"]",
            );
            return None;
        };
        let field = find_field(checker, path, Some(name.span()), kind)?;
        if fields.iter().any(|other| other.path == field.path) {
            checker.push(Some(name.span()), format!("`{path}` is given twice"), "repeated here", "remove one of them");
            return None;
        }
        fields.push(field);
    }
    if !raw.rows.is_present() {
        checker.report_missing(
            "rows",
            raw,
            "give a row of values for each run: rows = [[\"480 N*mm\", \"132.6 N*mm\"], ..]",
        );
        return None;
    }
    let mut rows = Vec::new();
    for row in checker.get("rows", &raw.rows)? {
        rows.push(read_row(checker, &fields, &row)?);
    }
    Some(Axis { fields, values: AxisValues::Rows(rows), repeats_designs })
}

/// Reads one row of an axis of several fields.
fn read_row(checker: &mut Checker<'_>, fields: &[Field], row: &Spanned<TomlValue>) -> Option<Vec<AxisValue>> {
    let required = format!("{} values", fields.len());
    let help = "write one value for each of `fields`, in their order";
    match row.get_ref() {
        TomlValue::List(values) if values.len() == fields.len() => {
            fields.iter().zip(values).map(|(field, value)| read_value(checker, field, value)).collect()
        }
        TomlValue::List(values) => {
            let message = format!("a row has {} values, but {} fields vary", values.len(), fields.len());
            checker.push(Some(row.span()), message, required, help);
            None
        }
        other => {
            checker.push(Some(row.span()), format!("a row is {}, but must be a list", other.name()), required, help);
            None
        }
    }
}

/// Finds the field of a path; reports an unknown field.
pub(in crate::study) fn find_field(
    checker: &mut Checker<'_>,
    path: &str,
    span: Option<Span<usize>>,
    kind: SceneKind,
) -> Option<Field> {
    let result = Field::find(path, schema_for(kind));
    result.map_err(|(message, label, help)| checker.push(span, message, label, help)).ok()
}

/// Reads a value of a field; reports an invalid value.
pub(in crate::study) fn read_value(
    checker: &mut Checker<'_>,
    field: &Field,
    value: &Spanned<TomlValue>,
) -> Option<AxisValue> {
    match field.read(value) {
        Ok(axis_value) if matches!(&axis_value.value, Value::Text(text) if text.contains(['\n', '\r'])) => {
            let message = format!("a value of `{}` has more than one line", field.path);
            checker.push(
                Some(value.span()),
                message,
                "one line",
                "remove the line break: a row of the results is one line",
            );
            None
        }
        Ok(axis_value) => Some(axis_value),
        Err(problems) => {
            problems.into_iter().for_each(|p| checker.push(p.span, p.message, p.label, p.help));
            None
        }
    }
}
