//! Texts that a spreadsheet would take for formulas, kept as texts.

/// Spreadsheets compute what begins with one of these.
pub(super) const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];

/// The text of a cell.
pub(super) fn meant(cell: &str) -> &str {
    if is_kept(cell) { &cell[1..] } else { cell }
}

/// Whether an apostrophe stands before what has one for this reason.
pub(super) fn is_kept(cell: &str) -> bool {
    cell.strip_prefix('\'').is_some_and(|rest| rest.starts_with(FORMULA) || rest.starts_with('\''))
}
