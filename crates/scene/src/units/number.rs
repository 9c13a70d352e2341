//! Numbers as text.

/// Returns the shortest decimal that parses back to the number, plain or with an exponent.
pub fn number(value: f64) -> String {
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if plain.len() <= exponent.len() + 2 { plain } else { exponent }
}
