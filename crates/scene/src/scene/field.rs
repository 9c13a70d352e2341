//! Paths of fields, such as `joints.pin.points[0][1]`: sections and key separated by points, entries of lists in brackets. This is
//! the only grammar of fields: of `--set`, of studies, of Python and of derivatives.

use toml::Value;

/// Name of the section that contains the parameters of a scene.
pub const PARAMETERS: &str = "parameters";

/// A section or a key of a path, with the indices of entries of lists below it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    pub name: String,
    /// Indices, counted from 0.
    pub entries: Vec<usize>,
}

impl Part {
    /// Name followed by its indices, such as `points[0][1]`. A file may use this as a quoted key to set one entry.
    pub fn key(&self) -> String {
        let entries = self.entries.iter().map(|entry| format!("[{entry}]"));
        std::iter::once(self.name.clone()).chain(entries).collect()
    }
}

/// Splits the path of a field. Names may be quoted.
///
/// # Errors
/// Returns a message with the grammar if the text is not the path of a field.
pub fn parse_field(field: &str) -> Result<Vec<Part>, String> {
    let error = || {
        format!(
            "`{field}` is not a field: write its sections and its key, separated by points, with the entries of lists in brackets, such \
             as contact.friction.mu_static or joints.pin.points[0][1]"
        )
    };
    let (mut parts, mut rest) = (Vec::new(), field.trim());
    loop {
        let quote = rest.chars().next().filter(|first| ['"', '\''].contains(first));
        let (name, after) = match quote {
            Some(quote) => rest[1..].split_once(quote).ok_or_else(error)?,
            None => rest.split_at(rest.find(|letter| !is_bare(letter)).unwrap_or(rest.len())),
        };
        let end = after.find('.').unwrap_or(after.len());
        let entries = entries(&after[..end]).filter(|_| !name.is_empty() && !name.contains('\n')).ok_or_else(error)?;
        parts.push(Part { name: name.to_string(), entries });
        match after[end..].strip_prefix('.') {
            Some(more) => rest = more,
            None => return Ok(parts),
        }
    }
}

/// Splits a key such as `points[0][1]` into the key of the list and the indices of the entry; `None` for a key without
/// indices.
pub fn split_entries(key: &str) -> Option<(&str, Vec<usize>)> {
    // Most keys have no entries.
    let (name, list) = key.ends_with(']').then(|| key.split_at(key.find('[').unwrap_or(0)))?;
    Some((name, entries(list)?)).filter(|(name, _)| !name.is_empty())
}

/// Reads `[0][1]`.
fn entries(text: &str) -> Option<Vec<usize>> {
    let Some(inner) = text.strip_prefix('[') else { return text.is_empty().then(Vec::new) };
    let indices = inner.strip_suffix(']')?.split("][");
    indices.map(|index| index.bytes().all(|digit| digit.is_ascii_digit()).then(|| index.parse().ok())?).collect()
}

fn is_bare(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || letter == '-' || letter == '_'
}

/// A key as written in a file: quoted if it has other characters than letters, digits, - and _.
pub(crate) fn key_text(key: &str) -> String {
    if !key.is_empty() && key.chars().all(is_bare) { key.to_string() } else { Value::from(key).to_string() }
}

/// Message for an entry beyond the end of a list.
pub fn no_such_entry(list: &str, entry: usize, count: usize) -> String {
    match count {
        0 => format!("`{list}` has no entries, so there is no `{list}[{entry}]`"),
        1 => format!("`{list}` has 1 entry, `{list}[0]`, so there is no `{list}[{entry}]`"),
        _ => format!("`{list}` has {count} entries, numbered from 0, so there is no `{list}[{entry}]`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_sections_keys_and_entries() {
        let path = |field: &str| -> Vec<String> {
            parse_field(field).unwrap_or_else(|error| panic!("{error}")).iter().map(Part::key).collect()
        };
        assert_eq!(path("duration"), ["duration"]);
        assert_eq!(path(" joints.pin.points[0][12] "), ["joints", "pin", "points[0][12]"]);
        assert_eq!(path("tendons.t.spools[3].radius"), ["tendons", "t", "spools[3]", "radius"]);
        assert_eq!(path("discs.\"a.b c\".centre[1]"), ["discs", "a.b c", "centre[1]"]);
        assert_eq!(parse_field("a.b[2][0]").map(|path| path[1].entries.clone()), Ok(vec![2, 0]));
        for wrong in [
            "",
            ".",
            "a.",
            ".a",
            "a..b",
            "a b",
            "[0]",
            "a[",
            "a[]",
            "a[-1]",
            "a[x]",
            "a[0]b",
            "a[0",
            "a]",
            "a[99999999999999999999]",
            "\"a",
            "a\nb",
            "a=b",
        ] {
            let error = parse_field(wrong).expect_err(wrong);
            assert!(error.starts_with(&format!("`{wrong}` is not a field: ")) && error.contains("[0][1]"), "{error}");
        }
    }

    #[test]
    fn keys_of_entries_are_split() {
        assert_eq!(split_entries("points[0][1]"), Some(("points", vec![0, 1])));
        for other in ["points", "[0]", "points[]", "points[a]", "points]", "a[0]b[1]"] {
            assert_eq!(split_entries(other), None, "{other}");
        }
    }
}
