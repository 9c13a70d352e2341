//! The ranking as a typed table, for CSV and Parquet.

use crate::study::select::{Ranked, Selection};
use crate::table::{Column, Kind, Table, Value};

/// Columns of the ranking that precede the columns of the results.
const RANKING_COLUMNS: [(&str, Kind); 6] = [
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
    names.starts_with(&RANKING_COLUMNS.map(|(name, _)| name))
}

/// Returns one row for each selected run, best first: rank, r_WC and its terms, then all columns of the results.
pub fn ranking_table(results: &Table, selection: &Selection) -> Table {
    // If the results are already a ranking, the new ranking columns replace the old ones.
    let other_columns: Vec<usize> = (0..results.columns.len())
        .filter(|&column| RANKING_COLUMNS.iter().all(|(name, _)| *name != results.columns[column].name))
        .collect();
    let ranking = RANKING_COLUMNS.iter().map(|&(name, kind)| Column::new(name, kind));
    let columns = ranking.chain(other_columns.iter().map(|&column| results.columns[column].clone())).collect();
    let line = |ranked: &Ranked| {
        let terms = ranked.terms;
        let values = [ranked.r_wc, terms.pfp, terms.tts, terms.f21, terms.f22];
        let values = values.map(|value| if value.is_nan() { Value::Missing } else { Value::Number(value) });
        let row = &results.rows[selection.runs[ranked.run_index].row];
        std::iter::once(Value::Integer(ranked.rank as i64))
            .chain(values)
            .chain(other_columns.iter().map(|&column| row[column].clone()))
            .collect()
    };
    Table::new(columns, selection.ranking.iter().map(line).collect())
}
