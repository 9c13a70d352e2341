//! The ranking as a typed table, for CSV and Parquet.

use crate::study::select::{Ranked, Selection};
use crate::table::{Column, Kind, Table, Value};

/// Columns of the ranking before those of the results.
const PLACES: [(&str, Kind); 6] = [
    ("place", Kind::Integer),
    ("r_wc", Kind::Number),
    ("part_pfp", Kind::Number),
    ("part_tts", Kind::Number),
    ("part_f21", Kind::Number),
    ("part_f22", Kind::Number),
];

/// Whether a table is a ranking.
pub fn is_ranking(table: &Table) -> bool {
    let names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
    names.starts_with(&PLACES.map(|(name, _)| name))
}

/// One row for each selected run, best first: its place, r_WC and its parts, then all columns of the results.
pub fn ranking_table(results: &Table, selection: &Selection) -> Table {
    // Results that are a ranking themselves have such columns already; the new ones are in their place.
    let kept: Vec<usize> = (0..results.columns.len())
        .filter(|&column| PLACES.iter().all(|(name, _)| *name != results.columns[column].name))
        .collect();
    let own = PLACES.iter().map(|&(name, kind)| Column::new(name, kind));
    let columns = own.chain(kept.iter().map(|&column| results.columns[column].clone())).collect();
    let line = |ranked: &Ranked| {
        let parts = ranked.parts;
        let figures = [ranked.r_wc, parts.pfp, parts.tts, parts.f21, parts.f22];
        let own = figures.map(|value| if value.is_nan() { Value::Missing } else { Value::Number(value) });
        let row = &results.rows[selection.runs[ranked.run_index].row];
        std::iter::once(Value::Integer(ranked.place as i64))
            .chain(own)
            .chain(kept.iter().map(|&column| row[column].clone()))
            .collect()
    };
    Table::new(columns, selection.ranking.iter().map(line).collect())
}
