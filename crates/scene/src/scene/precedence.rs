//! Precedence when one part of a scene overrides another: a scene over the one it extends, the settings of one finger
//! over the common ones.

/// Keys that select the kind of a section: a section of another kind does not inherit the other keys.
pub(crate) const KIND_KEYS: [&str; 2] = ["type", "profile"];
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

/// Keys replaced by the alternatives of an overriding table; `has` returns whether that table has a key.
pub fn replaced_keys(has: impl Fn(&str) -> bool) -> impl Iterator<Item = &'static str> {
    let pairs = ALTERNATIVES.into_iter().flat_map(|[first, second]| [(first, second), (second, first)]);
    pairs.filter(move |(first, second)| has(first) && !has(second)).map(|(_, second)| second)
}
