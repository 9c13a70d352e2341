//! Scene templates: the base scene, serialised once with gaps for the values of the axes.

use toml::{Table, Value};

use crate::scene::keys::pair_element;
use crate::scene::precedence::replaced_keys;

/// A scene text with gaps.
#[derive(Clone, Debug)]
pub struct Template {
    /// Text before, between and after the gaps.
    pieces: Vec<String>,
    /// Index of the field of each gap.
    gaps: Vec<usize>,
}

impl Template {
    /// Creates a template with a gap for each field. Missing tables on the path of a field are added.
    pub fn new(mut base: Table, fields: &[&str]) -> Result<Self, String> {
        for (index, path) in fields.iter().enumerate() {
            insert_at_path(&mut base, path, Value::from(placeholder(index)));
        }
        let text = toml::to_string(&base).map_err(|error| error.to_string())?;
        let locate = |index: usize| {
            let quoted = format!("\"{}\"", placeholder(index));
            text.find(&quoted).map(|start| (start, quoted.len(), index))
        };
        let mut gaps_in_text: Vec<_> = (0..fields.len()).filter_map(locate).collect();
        gaps_in_text.sort_unstable();
        let (mut pieces, mut position) = (Vec::new(), 0);
        for &(start, length, _) in &gaps_in_text {
            pieces.push(text[position..start].to_string());
            position = start + length;
        }
        pieces.push(text[position..].to_string());
        Ok(Template { pieces, gaps: gaps_in_text.into_iter().map(|(_, _, index)| index).collect() })
    }

    /// Returns the scene text with the TOML values of all fields, in the order of the fields.
    pub fn fill(&self, values: &[&str]) -> String {
        let mut text = String::with_capacity(self.pieces.iter().map(String::len).sum::<usize>() + 24 * self.gaps.len());
        for (index, piece) in self.pieces.iter().enumerate() {
            text.push_str(piece);
            text.push_str(self.gaps.get(index).and_then(|gap| values.get(*gap)).unwrap_or(&""));
        }
        text
    }
}

/// Text that occurs in no scene and needs no escaping in TOML.
fn placeholder(index: usize) -> String {
    format!("@@phalanx sweep axis {index}@@")
}

/// Inserts a value at a path and removes the fields that it replaces.
fn insert_at_path(table: &mut Table, path: &str, value: Value) {
    match path.split_once('.') {
        None => {
            replaced_keys(|key| key == path).for_each(|other| _ = table.remove(other));
            table.retain(|known, _| pair_element(known).is_none_or(|(pair, _)| pair != path));
            table.insert(path.to_string(), value);
        }
        Some((key, rest)) => {
            let inner = table.entry(key).or_insert_with(|| Value::Table(Table::new()));
            // The base scene has been checked, so this is a table.
            if let Value::Table(inner) = inner {
                insert_at_path(inner, rest, value);
            }
        }
    }
}

/// Merges the fields of `over` into `base`.
pub fn merge(base: &mut Table, over: Table) {
    replaced_keys(|key| over.contains_key(key)).for_each(|other| _ = base.remove(other));
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(inner)), Value::Table(more)) => merge(inner, more),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fills_values_at_the_paths_of_the_fields() {
        let base: Table =
            "duration = \"20 ms\"\n[design]\nbase = \"1 mm\"\nl21_fraction = 1\n[motor]\ntorque = \"1 N*m\"\n"
                .parse()
                .expect("TOML");
        let fields = ["motor.torque", "contact.friction.mu_static", "design.base", "palm", "design.l21"];
        let template = Template::new(base, &fields).expect("a template");
        let text = template.fill(&["\"2 N*m\"", "0.8", "\"12 mm\"", "false", "\"24 mm\""]);
        let expected: Table = "duration = \"20 ms\"\npalm = false\ndesign.base = \"12 mm\"\ndesign.l21 = \"24 mm\"\nmotor.torque = \"2 N*m\"\n\
                               contact.friction.mu_static = 0.8\n"
            .parse()
            .expect("TOML");
        assert_eq!(text.parse::<Table>().expect("TOML"), expected, "{text}");
    }

    #[test]
    fn merge_replaces_single_fields() {
        let mut base: Table = "a = 1\nt.x = 1\nt.y = 2\n".parse().expect("TOML");
        merge(&mut base, "b = 2\nt.y = 3\nu.z = 4\n".parse().expect("TOML"));
        assert_eq!(base, "a = 1\nb = 2\nt.x = 1\nt.y = 3\nu.z = 4\n".parse().expect("TOML"));
    }
}
