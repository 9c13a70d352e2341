//! Precedence when one part of a scene overrides another: a scene over the one it extends, the settings of one finger
//! over the common ones.

use std::borrow::Borrow;
use std::hash::Hash;

use toml::map::Map;

use super::field::{PARAMETERS, split_entries};

/// Keys that select the kind of a section: a section of another kind does not inherit the other keys.
const KIND_KEYS: [&str; 2] = ["type", "profile"];
/// Alternative sections, or alternative keys of a section, for the same thing: a constant excludes values over time.
const ALTERNATIVES: [[&str; 2]; 11] = [
    ["design", "lengths"],
    ["l21", "l21_fraction"],
    ["time", "acceleration"],
    ["torque", "torques"],
    ["torque", "times"],
    ["force", "forces"],
    ["force", "times"],
    ["target", "targets"],
    ["target", "times"],
    ["tension", "tensions"],
    ["tension", "times"],
];

/// Keys that an overriding table replaces, because it contains an alternative to them; `has` returns whether it
/// contains a key.
pub fn replaced_keys(has: impl Fn(&str) -> bool) -> impl Iterator<Item = &'static str> {
    let pairs = ALTERNATIVES.into_iter().flat_map(|[first, second]| [(first, second), (second, first)]);
    pairs.filter(move |(first, second)| has(first) && !has(second)).map(|(_, second)| second)
}

/// Merges a table over another; `as_table` returns the table that a value is. With `replaces_kinds`, a section that selects
/// its kind replaces the inherited section, and alternative keys replace each other.
pub(crate) fn merge<K: Ord + Hash + Borrow<str>, V>(
    table: &mut Map<K, V>,
    overriding: Map<K, V>,
    replaces_kinds: bool,
    as_table: fn(&mut V) -> Option<&mut Map<K, V>>,
) {
    if replaces_kinds {
        replaced_keys(|key| overriding.contains_key(key)).for_each(|key| _ = table.remove(key));
    }
    // A list replaces its single entries.
    let is_kept = |key: &str| {
        let lists = key.match_indices('[').map(|(end, _)| &key[..end]);
        split_entries(key).is_none() || lists.into_iter().all(|list| !overriding.contains_key(list))
    };
    *table = std::mem::take(table).into_iter().filter(|(key, _)| is_kept(key.borrow())).collect();
    for (key, mut value) in overriding {
        let mut inherited = table.remove(key.borrow());
        if let (Some(inner), Some(more)) = (inherited.as_mut().and_then(as_table), as_table(&mut value))
            && !(replaces_kinds && key.borrow() != PARAMETERS && KIND_KEYS.iter().any(|kind| more.contains_key(*kind)))
        {
            // Parameters have any names.
            merge(inner, std::mem::take(more), replaces_kinds && key.borrow() != PARAMETERS, as_table);
            *more = std::mem::take(inner);
        }
        table.insert(key, value);
    }
}
