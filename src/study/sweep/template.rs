//! Scene texts: the base scene, serialised once with gaps where the axes put their values.

use toml::{Table, Value};

use crate::scene::keys::element;
use crate::scene::over::replaced;

/// A scene text with gaps.
#[derive(Clone, Debug)]
pub struct Template {
    /// What stands before, between and behind the gaps.
    pieces: Vec<String>,
    /// Which field goes in each gap.
    gaps: Vec<usize>,
}

impl Template {
    /// The base scene with a gap for each field. Tables on the way to a field that are not there are made.
    pub fn new(mut base: Table, fields: &[&str]) -> Result<Self, String> {
        for (index, path) in fields.iter().enumerate() {
            put(&mut base, path, Value::from(mark(index)));
        }
        let text = toml::to_string(&base).map_err(|error| error.to_string())?;
        let place = |index: usize| {
            let mark = format!("\"{}\"", mark(index));
            text.find(&mark).map(|at| (at, mark.len(), index))
        };
        let mut found: Vec<_> = (0..fields.len()).filter_map(place).collect();
        found.sort_unstable();
        let (mut pieces, mut at) = (Vec::new(), 0);
        for &(start, length, _) in &found {
            pieces.push(text[at..start].to_string());
            at = start + length;
        }
        pieces.push(text[at..].to_string());
        Ok(Template { pieces, gaps: found.into_iter().map(|(_, _, index)| index).collect() })
    }

    /// The scene with the values of all fields, as TOML, in their order.
    pub fn fill(&self, values: &[&str]) -> String {
        let mut text = String::with_capacity(self.pieces.iter().map(String::len).sum::<usize>() + 24 * self.gaps.len());
        for (index, piece) in self.pieces.iter().enumerate() {
            text.push_str(piece);
            text.push_str(self.gaps.get(index).and_then(|gap| values.get(*gap)).unwrap_or(&""));
        }
        text
    }
}

/// Something that is in no scene, and that TOML writes as it is.
fn mark(index: usize) -> String {
    format!("@@phalanx sweep axis {index}@@")
}

/// Puts a value at a path.
fn put(table: &mut Table, path: &str, value: Value) {
    match path.split_once('.') {
        None => {
            replaced(|key| key == path).for_each(|other| _ = table.remove(other));
            table.retain(|known, _| element(known).is_none_or(|(pair, _)| pair != path));
            table.insert(path.to_string(), value);
        }
        Some((key, rest)) => {
            let inner = table.entry(key).or_insert_with(|| Value::Table(Table::new()));
            // The base has been checked: what is a table in a scene is one there.
            if let Value::Table(inner) = inner {
                put(inner, rest, value);
            }
        }
    }
}

/// Puts the fields of one scene into another.
pub fn merge(base: &mut Table, over: Table) {
    replaced(|key| over.contains_key(key)).for_each(|other| _ = base.remove(other));
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
    fn values_stand_where_the_fields_are() {
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
    fn merging_replaces_single_fields() {
        let mut base: Table = "a = 1\nt.x = 1\nt.y = 2\n".parse().expect("TOML");
        merge(&mut base, "b = 2\nt.y = 3\nu.z = 4\n".parse().expect("TOML"));
        assert_eq!(base, "a = 1\nb = 2\nt.x = 1\nt.y = 3\nu.z = 4\n".parse().expect("TOML"));
    }
}
