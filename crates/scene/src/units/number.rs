//! Numbers as text.

/// The shortest decimal of a number that parses back to it: plain or with exponent.
pub fn number(value: f64) -> String {
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if plain.len() <= exponent.len() + 2 { plain } else { exponent }
}
