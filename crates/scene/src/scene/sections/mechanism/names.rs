//! Names by which the sections of a mechanism refer to each other, and checks that they share.

use std::ops::Range;

use crate::law::ContactLaw;
use crate::mechanism::JointKind;
use crate::scene::Problem;
use crate::scene::keys::{closest_match, is_name};
use crate::scene::section_input::SectionInput;

pub(super) use crate::mechanism::GROUND;

/// Checks the name of a section: names are used in topics, keys and columns.
pub(super) fn check_name(section: &SectionInput<'_>, key: &str, name: &str) {
    if !is_name(name) || name == GROUND && key == "bodies" {
        let span = section.name_span.clone().or(section.span.clone());
        report_name(section, span, (&format!("[{key}]"), &format!("[{key}.link_2]")), name);
    }
}

/// Reports a name that is not allowed in a place, with an example of one that is.
pub(super) fn report_name(
    section: &SectionInput<'_>,
    span: Option<Range<usize>>,
    (place, example): (&str, &str),
    name: &str,
) {
    let message = match name {
        GROUND => {
            format!("`{GROUND}` cannot be the name of a body: it is the fixed body, with outlines in [ground.outlines]")
        }
        _ => format!("`{}` cannot be a name in {place}", name.escape_debug()),
    };
    let help = format!("use a letter followed by letters, digits and _, as in {example}");
    section.checker.push(Problem::new(span, message, "invalid name", help));
}

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

/// What the sections of a mechanism refer to by name.
pub(super) struct Known<'a> {
    pub bodies: Vec<&'a str>,
    pub joints: Vec<&'a str>,
    /// Kinds of the joints; `None` for a joint whose type is invalid.
    pub kinds: Vec<Option<JointKind>>,
    pub laws: Vec<(&'a str, Option<NamedLaw>)>,
}

impl Known<'_> {
    /// Finds a joint and its kind.
    pub fn joint(&self, input: &SectionInput<'_>, key: &str, name: &str) -> Option<(usize, JointKind)> {
        let index = find(input, key, name, "joint", &self.joints)?;
        Some((index, self.kinds[index]?))
    }
}

/// A law with the units of its damper.
pub(super) struct NamedLaw {
    pub law: ContactLaw,
    /// Whether damping and transition have the units of contacts, rather than of angles; `None` if they are not given.
    pub linear: Option<bool>,
}

/// Finds the two bodies of a joint or a spring.
pub(super) fn two_bodies(
    input: &SectionInput<'_>,
    bodies: [String; 2],
    names: &[&str],
    what: &str,
) -> Option<[Option<usize>; 2]> {
    let known: Vec<&str> = [GROUND].into_iter().chain(names.iter().copied()).collect();
    let found: Vec<Option<usize>> = bodies
        .iter()
        .enumerate()
        .map(|(k, name)| find_at(input, input.item_span("bodies", k), "bodies", name, "body", &known))
        .collect();
    let [a, b] = [found[0]?, found[1]?];
    if a == b {
        let message = format!("`{}` names `{}` twice, but {what} connects two bodies", input.path("bodies"), bodies[0]);
        return input.refuse("bodies", message, "the same body", "name two bodies; `ground` is the fixed one");
    }
    Some([a, b].map(|body| body.checked_sub(1)))
}

/// Checks that the given values whose units depend on a joint have those of a joint that slides or turns.
pub(super) fn check_units(input: &SectionInput<'_>, linear: bool, of: &str) -> bool {
    let mut is_valid = true;
    for key in input.keys() {
        let wrong = input.dimensions(key).into_iter().find(|dimension| dimension.is_linear() != linear);
        let Some(wrong) = wrong else { continue };
        let right = input.alternatives(key).into_iter().find(|dimension| dimension.is_linear() == linear);
        let Some(right) = right else { continue };
        let message = format!("`{}` is {}, but {of} needs {}", input.path(key), wrong.name(), right.name());
        input.report(key, message, right.name(), format!("write it as in \"{}\"", right.example()));
        is_valid = false;
    }
    is_valid
}
