//! Objectives and constraints of a file: which columns, which bounds.

use std::ops::Range as Span;

use super::problem::{Constraint, Figure, Goal, Limit, Objective, Of, Over};
use super::raw::{RawConstraint, RawObjective};
use crate::criteria::Class;
use crate::scene::any::Any;
use crate::scene::check::Checker;
use crate::scene::entry::{Entry, Section};
use crate::scene::nearest;
use crate::scene::words::SceneKind;
use crate::study::select::CLASSES;
use crate::study::sweep::{Anything, Holds, found};
use crate::table::Kind;
use crate::units;

/// All objectives that can be made out; what is wrong is noted. `before`: how many cells of a row stand before the results.
pub fn objectives(
    c: &mut Checker<'_>,
    raw: &[Section<RawObjective>],
    kind: SceneKind,
    before: usize,
) -> Vec<Objective> {
    if raw.is_empty() && c.is_clean() {
        let help = "say what is to be made small or large: [[objectives]] with column = \"tts_s\"";
        c.push(None, "there are no [[objectives]]", "", help);
    }
    raw.iter().filter_map(|raw| objective(c, raw, kind, before)).collect()
}

fn objective(c: &mut Checker<'_>, raw: &Section<RawObjective>, kind: SceneKind, before: usize) -> Option<Objective> {
    let (goal, over) = (c.or("goal", &raw.goal, Goal::Min), c.or("over", &raw.over, Over::Worst));
    let of = c.or("of", &raw.of, Of::Largest);
    let name = c.get("name", &raw.name);
    let columns: Vec<(String, Option<Span<usize>>)> = match (raw.column.is_given(), raw.columns.is_given()) {
        (true, false) => {
            c.unused("of", &raw.of, "on one column");
            vec![(c.get("column", &raw.column)?, raw.column.span())]
        }
        (false, true) => listed(c, raw)?,
        (true, true) => {
            let message = "an objective has both `column` and `columns`";
            c.push(raw.columns.span(), message, "and here again", "keep one of them");
            return None;
        }
        (false, false) => {
            c.missing("column", raw, "say which column of the results: column = \"tts_s\"");
            return None;
        }
    };
    let (mut cells, mut all) = (Vec::new(), Vec::new());
    for (column, span) in &columns {
        let (cell, holds) = column_of(c, column, span.clone(), kind, before)?;
        if !matches!(holds.kind(), Kind::Number | Kind::Integer) {
            let message = format!("`{column}` has no numbers, so it cannot be made small or large");
            let help = "make it a constraint: [[constraints]] with column and equals or at_least";
            c.push(span.clone(), message, "no numbers", help);
            return None;
        }
        cells.push(cell);
        all.push(holds);
    }
    let holds = match &all[..] {
        [first, others @ ..] if others.iter().all(|other| other == first) => (*first).clone(),
        _ => Holds::Number,
    };
    let columns: Vec<String> = columns.into_iter().map(|(column, _)| column).collect();
    let name = name.unwrap_or_else(|| match (&columns[..], of) {
        ([one], _) => one.clone(),
        (all, Of::Largest) => format!("largest_{}", all.join("_")),
        (all, Of::Smallest) => format!("smallest_{}", all.join("_")),
        (all, Of::Sum) => format!("sum_{}", all.join("_")),
    });
    Some(Objective { figure: Figure { name, columns, of, holds, cells }, goal, over })
}

/// The names of several columns.
fn listed(c: &mut Checker<'_>, raw: &RawObjective) -> Option<Vec<(String, Option<Span<usize>>)>> {
    let mut columns = Vec::new();
    for item in c.get("columns", &raw.columns)? {
        let Any::Text(name) = item.get_ref() else {
            let message = format!("`columns` has {} in it, but must have names of columns", item.get_ref().name());
            let help = "write columns = [\"peak_f21_n\", \"peak_f22_n\"]";
            c.push(Some(item.span()), message, "a text", help);
            return None;
        };
        columns.push((name.clone(), Some(item.span())));
    }
    Some(columns)
}

/// Where a column stands in a row, and what it holds.
fn column_of(
    c: &mut Checker<'_>,
    column: &str,
    span: Option<Span<usize>>,
    kind: SceneKind,
    before: usize,
) -> Option<(usize, &'static Holds)> {
    let all = found(kind);
    if let Some(at) = all.iter().position(|(name, _)| *name == column) {
        return Some((before + at, &all[at].1));
    }
    let names: Vec<&str> = all.iter().map(|(name, _)| *name).filter(|name| !name.starts_with("check")).collect();
    let label = nearest(column, &names).map_or("not a column".into(), |near| format!("did you mean \"{near}\"?"));
    let message = format!("the results have no column `{}`", column.escape_debug());
    c.push(span, message, label, format!("columns of a run: {}", names.join(", ")));
    None
}

/// All constraints that can be made out; what is wrong is noted.
pub fn constraints(
    c: &mut Checker<'_>,
    raw: &[Section<RawConstraint>],
    kind: SceneKind,
    before: usize,
) -> Vec<Constraint> {
    raw.iter().filter_map(|raw| constraint(c, raw, kind, before)).collect()
}

fn constraint(c: &mut Checker<'_>, raw: &Section<RawConstraint>, kind: SceneKind, before: usize) -> Option<Constraint> {
    if !raw.column.is_given() {
        c.missing("column", raw, "say which column of the results: column = \"class\"");
        return None;
    }
    let column = c.get("column", &raw.column)?;
    let (cell, holds) = column_of(c, &column, raw.column.span(), kind, before)?;
    if !(raw.at_least.is_given() || raw.at_most.is_given() || raw.equals.is_given()) {
        let help = match holds.kind() {
            Kind::Number | Kind::Integer => "give a bound: at_least = .. or at_most = ..",
            Kind::Flag => "say what has to hold: equals = true",
            Kind::Text if column == "class" => "say the worst class allowed: at_least = \"semi-stable\"",
            Kind::Text => "say what has to hold: equals = \"..\"",
        };
        c.missing("at_least", raw, help);
        return None;
    }
    let limit = match holds.kind() {
        Kind::Number | Kind::Integer => {
            c.unused("equals", &raw.equals, "on a column of numbers: give at_least and at_most");
            let at_least = bound(c, "at_least", &raw.at_least, &column, holds)?;
            let at_most = bound(c, "at_most", &raw.at_most, &column, holds)?;
            if let (Some(least), Some(most)) = (at_least, at_most)
                && least > most
            {
                let message = format!("nothing is at least {least} and at most {most}");
                c.push(raw.at_most.span(), message, "below at_least", "exchange them, or give other bounds");
                return None;
            }
            Limit::Between { at_least, at_most }
        }
        Kind::Flag | Kind::Text => {
            c.unused("at_most", &raw.at_most, "on a column without numbers");
            return word(c, raw, &column, holds.kind()).map(|limit| Constraint { column, limit, cell });
        }
    };
    Some(Constraint { column, limit, cell })
}

/// What a column of words or flags has to say.
fn word(c: &mut Checker<'_>, raw: &RawConstraint, column: &str, holds: Kind) -> Option<Limit> {
    let is_class = column == "class";
    if !is_class {
        c.unused("at_least", &raw.at_least, "on a column that has no order: give equals");
    }
    let (key, entry) =
        if is_class && raw.at_least.is_given() { ("at_least", &raw.at_least) } else { ("equals", &raw.equals) };
    let given = c.get(key, entry)?;
    let span = Some(given.span());
    match (holds, given.get_ref()) {
        (Kind::Flag, Any::Flag(flag)) => Some(Limit::Flag(*flag)),
        (Kind::Flag, other) => {
            let message = format!("`{key}` is {}, but `{column}` is true or false", other.name());
            c.push(span, message, "true or false", "write true or false, without quotes");
            None
        }
        (_, Any::Text(text)) if is_class => {
            let names = CLASSES.map(Class::name);
            let Some(rank) = names.iter().position(|name| name == text) else {
                let label = nearest(text, &names).map_or("no class".into(), |near| format!("did you mean \"{near}\"?"));
                let message = format!("there is no class \"{}\"", text.escape_debug());
                c.push(span, message, label, format!("classes, from good to bad: {}", names.join(", ")));
                return None;
            };
            Some(if key == "equals" { Limit::Word(text.clone()) } else { Limit::Class(rank) })
        }
        (_, Any::Text(text)) => Some(Limit::Word(text.clone())),
        (_, other) => {
            let message = format!("`{key}` is {}, but `{column}` is a word", other.name());
            c.push(span, message, "a word in quotes", "write the word as it stands in the results, in quotes");
            None
        }
    }
}

/// A bound in the unit of its column, or a quantity. `None` if it is wrong, `Some(None)` if it is not given.
#[expect(clippy::option_option)]
fn bound(c: &mut Checker<'_>, key: &str, entry: &Entry<Anything>, column: &str, holds: &Holds) -> Option<Option<f64>> {
    if !entry.is_given() {
        return Some(None);
    }
    let given = c.get(key, entry)?;
    let span = Some(given.span());
    match given.get_ref() {
        Any::Integer(integer) => Some(Some(*integer as f64)),
        Any::Float(number) if number.is_finite() => Some(Some(*number)),
        Any::Text(text) => match holds {
            Holds::Quantity(dimension) => match units::parse(text, *dimension) {
                Ok(value) => Some(Some(value)),
                Err(error) => {
                    let help = format!("write a number and its unit, as in \"{}\"", dimension.example());
                    c.push(span, format!("`{key}`: {error}"), dimension.name(), help);
                    None
                }
            },
            _ => {
                let message = format!("`{key}` is a text, but a bound of `{column}` is a plain number");
                c.push(
                    span,
                    message,
                    "a number",
                    "write it without quotes, in the unit that the column's name ends in",
                );
                None
            }
        },
        other => {
            let message = format!("`{key}` is {}, but must be a number", other.name());
            c.push(span, message, "a number", "write a number in the unit that the column's name ends in");
            None
        }
    }
}
