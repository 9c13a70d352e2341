//! Axes of a study file: which fields, which values.

use std::ops::Range as Span;

use toml::Spanned;

use super::axis::{Axis, Points, Range, Spacing};
use super::field::{Field, Point};
use super::raw::{Anything, RawAxis};
use crate::scene::any::Any;
use crate::scene::check::Checker;
use crate::scene::entry::{Entry, Section};
use crate::scene::kinds::Choice;
use crate::scene::schema::schema_of;
use crate::scene::words::SceneKind;
use crate::table::Value;

/// All axes that can be made out; what is wrong is noted. A study without axes runs its scene once.
pub(in crate::study) fn axes(c: &mut Checker<'_>, raw: &[Section<RawAxis>], kind: SceneKind) -> Vec<Axis> {
    let mut found: Vec<Axis> = Vec::new();
    for axis in raw {
        let span = axis.field.span().or(axis.fields.span());
        let Some(axis) = one(c, axis, kind) else { continue };
        for field in &axis.fields {
            let twice = found.iter().flat_map(|other| &other.fields).any(|other| other.path == field.path);
            if twice {
                let message = format!("`{}` is varied by two axes", field.path);
                c.push(span.clone(), message, "and here again", "keep one of the axes, with all values of the field");
            }
        }
        found.push(axis);
    }
    found
}

fn one(c: &mut Checker<'_>, raw: &Section<RawAxis>, kind: SceneKind) -> Option<Axis> {
    let again = c.or("again", &raw.again, false);
    match (raw.field.is_given(), raw.fields.is_given()) {
        (true, false) => single(c, raw, again, kind),
        (false, true) => together(c, raw, again, kind),
        (true, true) => {
            c.push(raw.fields.span(), "an axis has both `field` and `fields`", "and here again", "keep one of them");
            None
        }
        (false, false) => {
            c.missing("field", raw, "say which field of the scene varies: field = \"design.base\"");
            None
        }
    }
}

/// An axis of one field: values, or a range.
fn single(c: &mut Checker<'_>, raw: &Section<RawAxis>, again: bool, kind: SceneKind) -> Option<Axis> {
    c.unused("rows", &raw.rows, "in an axis of one field: its values are `values`");
    let path = c.get("field", &raw.field)?;
    let field = field(c, &path, raw.field.span(), kind)?;
    let ranged = raw.from.is_given() || raw.to.is_given();
    if raw.values.is_given() {
        for (key, given) in [("from", raw.from.is_given()), ("to", raw.to.is_given())] {
            if given {
                let message = format!("the axis of `{path}` has `values` and `{key}`");
                c.push(
                    raw.values.span(),
                    message,
                    "and values here",
                    "keep one of them: values, or from, to and count",
                );
                return None;
            }
        }
        c.unused("count", &raw.count, "beside `values`");
        c.unused("spacing", &raw.spacing, "beside `values`");
        let values = c.get("values", &raw.values)?;
        let points: Vec<Vec<Point>> =
            values.iter().map(|value| read(c, &field, value).map(|point| vec![point])).collect::<Option<_>>()?;
        if let Some(index) = (0..points.len()).find(|&index| points[..index].contains(&points[index])) {
            let message = format!("`{path}` has the value {} twice", points[index][0].text);
            c.push(raw.values.item_span(index), message, "and here again", "remove one of them");
            return None;
        }
        return Some(Axis { fields: vec![field], points: Points::Given(points), again });
    }
    if !ranged {
        c.missing("values", raw, "give values = [..], or a range: from, to and count");
        return None;
    }
    range(c, raw, field, again)
}

fn range(c: &mut Checker<'_>, raw: &Section<RawAxis>, field: Field, again: bool) -> Option<Axis> {
    let range = between(c, raw, &field, [&raw.from, &raw.to], &raw.spacing)?;
    if !raw.count.is_given() {
        if again {
            let message = format!("the sample of `{}` cannot run the same designs again", field.path);
            c.push(raw.again.span(), message, "a sampled axis", "remove `again`, or give `count` or `values`");
            return None;
        }
        return Some(Axis { fields: vec![field], points: Points::Range(range), again });
    }
    match c.get("count", &raw.count)? {
        count @ 2..=1_000_000 => Some(Axis { fields: vec![field], points: Points::Given(range.grid(count)), again }),
        count => {
            let message = format!("the range of `{}` has {count} values, but must have from 2 to 1000000", field.path);
            c.push(raw.count.span(), message, "from 2 to 1000000", "give another count");
            None
        }
    }
}

/// The range of a field between two ends that stand in a section.
pub(in crate::study) fn between<T>(
    c: &mut Checker<'_>,
    section: &Section<T>,
    field: &Field,
    [first, last]: [&Entry<Anything>; 2],
    spacing: &Entry<Choice<Spacing>>,
) -> Option<Range> {
    for (key, given) in [("from", first.is_given()), ("to", last.is_given())] {
        if !given {
            c.missing(key, section, "a range has both ends: from and to");
            return None;
        }
    }
    let ends = [("from", first), ("to", last)].map(|(key, entry)| {
        let value = c.get(key, entry)?;
        read(c, field, &value)
    });
    let [Some(from), Some(to)] = ends else { return None };
    let how = c.or("spacing", spacing, Spacing::Linear);
    let Some(range) = Range::between(field, &from, &to, how) else {
        let message = format!("`{}` has no range: between two of its values there are no others", field.path);
        c.push(first.span(), message, "not a quantity, not a number", "list its values: values = [..]");
        return None;
    };
    if range.from == range.to {
        let message = format!("the range of `{}` ends where it begins", field.path);
        c.push(last.span(), message, "the same again", "give another end, or a single value: values = [..]");
        return None;
    }
    if how == Spacing::Log && !(range.from > 0.0 && range.to > 0.0) {
        let message = format!("the range of `{}` is not above 0, which spacing = \"log\" needs", field.path);
        c.push(spacing.span(), message, "needs values above 0", "change the range, or use spacing = \"linear\"");
        return None;
    }
    Some(range)
}

/// An axis of several fields by rows of values.
fn together(c: &mut Checker<'_>, raw: &Section<RawAxis>, again: bool, kind: SceneKind) -> Option<Axis> {
    let why = "in an axis of several fields: their values are `rows`";
    c.unused("values", &raw.values, why);
    c.unused("from", &raw.from, why);
    c.unused("to", &raw.to, why);
    c.unused("count", &raw.count, why);
    c.unused("spacing", &raw.spacing, why);
    let mut fields: Vec<Field> = Vec::new();
    for name in c.get("fields", &raw.fields)? {
        let Any::Text(path) = name.get_ref() else {
            let message = format!("`fields` has {} in it, but must have names of fields", name.get_ref().name());
            c.push(Some(name.span()), message, "a text", "write fields = [\"motor.torque\", \"spring.torque\"]");
            return None;
        };
        let field = field(c, path, Some(name.span()), kind)?;
        if fields.iter().any(|other| other.path == field.path) {
            c.push(Some(name.span()), format!("`{path}` is there twice"), "and here again", "remove one of them");
            return None;
        }
        fields.push(field);
    }
    if !raw.rows.is_given() {
        c.missing("rows", raw, "give a row of values for each run: rows = [[\"480 N*mm\", \"132.6 N*mm\"], ..]");
        return None;
    }
    let mut points = Vec::new();
    for row in c.get("rows", &raw.rows)? {
        points.push(values(c, &fields, &row)?);
    }
    Some(Axis { fields, points: Points::Given(points), again })
}

fn values(c: &mut Checker<'_>, fields: &[Field], row: &Spanned<Any>) -> Option<Vec<Point>> {
    let wanted = format!("{} values", fields.len());
    let help = "write one value for each of `fields`, in their order";
    match row.get_ref() {
        Any::List(values) if values.len() == fields.len() => {
            fields.iter().zip(values).map(|(field, value)| read(c, field, value)).collect()
        }
        Any::List(values) => {
            let message = format!("a row has {} values, but {} fields are varied", values.len(), fields.len());
            c.push(Some(row.span()), message, wanted, help);
            None
        }
        other => {
            c.push(Some(row.span()), format!("a row is {}, but must be a list", other.name()), wanted, help);
            None
        }
    }
}

/// The field of a path; notes if there is none.
pub(in crate::study) fn field(
    c: &mut Checker<'_>,
    path: &str,
    span: Option<Span<usize>>,
    kind: SceneKind,
) -> Option<Field> {
    let found = Field::find(path, schema_of(kind));
    found.map_err(|(message, label, help)| c.push(span, message, label, help)).ok()
}

/// A value of a field; notes what is wrong with it.
pub(in crate::study) fn read(c: &mut Checker<'_>, field: &Field, value: &Spanned<Any>) -> Option<Point> {
    match field.read(value) {
        Ok(point) if matches!(&point.value, Value::Text(text) if text.contains(['\n', '\r'])) => {
            let message = format!("a value of `{}` has more than one line", field.path);
            c.push(Some(value.span()), message, "one line", "a row of the results is a line: leave the line break out");
            None
        }
        Ok(point) => Some(point),
        Err(problems) => {
            problems.into_iter().for_each(|p| c.push(p.span, p.message, p.label, p.help));
            None
        }
    }
}
