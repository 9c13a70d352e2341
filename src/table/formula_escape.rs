//! Escapes texts that spreadsheets would evaluate as formulas.

/// First characters of cells that spreadsheets evaluate.
pub(super) const FORMULA_PREFIXES: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];

/// Returns the original text of a cell.
pub(super) fn unescape(cell: &str) -> &str {
    if is_escaped(cell) { &cell[1..] } else { cell }
}

/// Whether a cell begins with an escaping apostrophe.
pub(super) fn is_escaped(cell: &str) -> bool {
    cell.strip_prefix('\'').is_some_and(|rest| rest.starts_with(FORMULA_PREFIXES) || rest.starts_with('\''))
}
