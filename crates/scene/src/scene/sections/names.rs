//! Names by which the sections of a mechanism refer to each other.

use std::ops::Range;

use crate::scene::Problem;
use crate::scene::keys::closest_match;
use crate::scene::section_input::SectionInput;

/// Name of the fixed body.
pub(super) const GROUND: &str = "ground";

/// Finds a name among those of a kind, or reports it at a key.
pub(super) fn find(input: &SectionInput<'_>, key: &str, name: &str, what: &str, known: &[&str]) -> Option<usize> {
    find_at(input, input.span(key), key, name, what, known)
}

pub(super) fn find_at(
    input: &SectionInput<'_>,
    span: Option<Range<usize>>,
    key: &str,
    name: &str,
    what: &str,
    known: &[&str],
) -> Option<usize> {
    let found = known.iter().position(|other| *other == name);
    if found.is_none() {
        let message = format!("`{}` names no {what}: there is no {what} `{}`", input.path(key), name.escape_debug());
        let label = closest_match(name, known).map_or("unknown name".into(), |near| format!("did you mean `{near}`?"));
        let help = match known {
            [] => format!("there is no {what} yet: add one"),
            _ => format!("the scene has: {}", known.join(", ")),
        };
        input.checker.push(Problem::new(span, message, label, help));
    }
    found
}
