//! Report of a selection: JSON document, text tables, and the ranking as a typed table.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use super::named::Object;
use super::sweep;
use crate::criteria::Class;
use crate::format::numbers::{format_number, row, zero_below_resolution};
use crate::format::quantity::Quantity;
use crate::format::report::{Report, ToReport, table};
use crate::format::{condition_name, criterion_name, percent_of};
use crate::study::select::{Candidate, ClassCounts, Condition, Ranked, Selection, TERMS, Term};
use crate::study::sweep::{Reason, Status};
use crate::table::{Column, Kind, Table, Value};
use crate::units::Dimension;

/// Report of a selection, with SI values.
#[derive(Clone, Debug)]
pub struct SelectionReport<'a> {
    /// Source of the results.
    source: String,
    selection: &'a Selection,
    /// Maximum number of ranked runs in the text report.
    max_ranked: usize,
}

impl<'a> SelectionReport<'a> {
    pub fn new(source: &str, selection: &'a Selection, max_ranked: usize) -> Self {
        SelectionReport { source: source.to_string(), selection, max_ranked }
    }
}

impl<'a> Serialize for SelectionReport<'a> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let selection: &'a Selection = self.selection;
        let condition = |(Condition { values }, counts): (&'a Condition, &'a ClassCounts)| ConditionDocument {
            condition: values.iter().map(|(column, value)| (column.as_str(), value)).collect(),
            counts,
        };
        let reason = |Reason { status, reason, runs, first_run }: &'a Reason| {
            Object::default()
                .with("class", status)
                .with("class_reason", reason)
                .with("runs", runs)
                .with("first_run", first_run)
        };
        let ranked = |ranked: &'a Ranked| {
            let run = &selection.runs[ranked.run_index];
            let axes = selection.axes.iter().zip(&run.axes).map(|(axis, value)| (axis.column.as_str(), value));
            Object::default()
                .with("place", ranked.rank)
                .with("run", run.run)
                .with("design", run.design)
                .with("axes", axes.collect::<BTreeMap<&str, &Value>>())
                .with("class", run.class)
                .with("class_reason", &run.class_reason)
                .with("pfp_n", run.pfp_n)
                .with("tts_s", run.tts_s)
                .with("f21_n", run.f21_n)
                .with("f22_n", run.f22_n)
                .with("parts", ranked.terms)
                .with("r_wc", ranked.r_wc)
        };
        Object::default()
            .with("source", &self.source)
            .with("runs", selection.runs.len())
            .with("designs", selection.designs())
            .with("missing_runs", selection.missing_runs.len())
            .with("axes", &selection.axes)
            .with("classes", selection.conditions.iter().zip(&selection.classes).map(condition).collect::<Vec<_>>())
            .with("class_reasons", selection.class_reasons.iter().map(reason).collect::<Vec<_>>())
            .with("cannot_grasp", &selection.cannot_grasp)
            .with("criteria", &selection.tallies)
            .with("selected", selection.ranking.len())
            .with("emptied_by", selection.emptied_by().map(|tally| tally.criterion.key()))
            .with("weights", selection.weights)
            .with("ranking", selection.ranking.iter().map(ranked).collect::<Vec<_>>())
            .serialize(serializer)
    }
}

/// Classes of the runs of one condition.
#[derive(Serialize)]
struct ConditionDocument<'a> {
    /// Values of the axes that define the condition.
    condition: BTreeMap<&'a str, &'a Value>,
    #[serde(flatten)]
    counts: &'a ClassCounts,
}

/// Tables of classes, criteria and the best remaining runs.
impl ToReport for SelectionReport<'_> {
    fn report(&self) -> Report {
        let SelectionReport { source, selection, max_ranked } = self;
        let (runs, designs) = (counted(selection.runs.len(), "run"), counted(selection.designs(), "design"));
        let mut text = Report::from(format!("{source}: {runs} of {designs}\n"));
        text.push_str(&missing_runs(selection));
        text.push('\n');
        text.push(classes(selection));
        text.push_str(&reasons(selection));
        text.push('\n');
        text.push(criteria(selection));
        text.push('\n');
        text.push(ranking(selection, *max_ranked));
        text
    }
}

/// Formats a count with its noun.
fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Returns a warning if runs are missing from the results.
fn missing_runs(selection: &Selection) -> String {
    match selection.missing_runs.len() {
        0 => String::new(),
        missing => format!(
            "{} before the last are missing (first: run {}): the sweep is not finished, and they cannot be selected\n",
            counted(missing, "run"),
            selection.missing_runs[0]
        ),
    }
}

/// Returns a table of static and dynamic classes with a column for each condition.
fn classes(selection: &Selection) -> Report {
    let header = std::iter::once("class".to_string()).chain(selection.conditions.iter().map(condition_name));
    let mut rows = vec![header.collect::<Vec<_>>()];
    let mut line = |name: &str, count: &dyn Fn(&ClassCounts) -> usize| {
        let cell = |counts: &ClassCounts| format!("{} ({})", count(counts), percent_of(count(counts), counts.runs));
        rows.push(std::iter::once(name.to_string()).chain(selection.classes.iter().map(cell)).collect());
    };
    for (index, status) in Status::ALL.into_iter().enumerate() {
        if status == Status::Completed || selection.classes.iter().any(|counts| counts.statuses[index] > 0) {
            line(status.name(), &|counts| counts.statuses[index]);
        }
    }
    if !selection.cannot_grasp.is_empty() {
        line("cannot grasp", &|counts| counts.cannot_grasp);
    }
    line("statically stable", &|counts| counts.statically_stable);
    line("form-closed", &|counts| counts.form_closed);
    for (index, class) in Class::ALL.into_iter().enumerate() {
        line(class.name(), &|counts| counts.dynamic[index]);
    }
    line("stable or semi-stable", &ClassCounts::dynamically_stable);
    table(&rows)
}

/// Returns the reasons for the classes, and why some runs have none.
fn reasons(selection: &Selection) -> String {
    let mut text = sweep::reasons("reasons for the class", &selection.class_reasons);
    if !selection.cannot_grasp.is_empty() {
        text.push_str("\nwithout a class (numbers from the first run)\n");
    }
    for Reason { reason, runs, first_run, .. } in &selection.cannot_grasp {
        let rows = if *runs == 1 { "row" } else { "rows" };
        text.push_str(&format!("{runs:>7} {rows} cannot grasp, first run {first_run}: {reason}\n"));
    }
    text
}

/// Returns a table of the runs that each criterion removed.
fn criteria(selection: &Selection) -> Report {
    let mut rows = vec![row(["criterion", "holds", "fails", "unknown", "left", "removed by it alone"])];
    for tally in &selection.tallies {
        let counts = [tally.holds, tally.fails, tally.unknown, tally.remaining, tally.removed_alone];
        let cells = counts.iter().map(usize::to_string);
        rows.push(std::iter::once(criterion_name(&tally.criterion)).chain(cells).collect());
    }
    let mut text = table(&rows);
    text.push_str(
        "\"left\" counts runs that meet this criterion and all above it; \"removed by it alone\" counts runs that meet all \
         others.\n",
    );
    text
}

/// Returns a table of the best runs with their values and the terms of r_WC.
fn ranking(selection: &Selection, max_ranked: usize) -> Report {
    if selection.ranking.is_empty() {
        return Report::from(no_selection(selection));
    }
    let varied = selection.axes.iter().enumerate().filter(|(_, axis)| axis.values.len() > 1);
    let axes: Vec<(usize, Quantity)> =
        varied.map(|(index, axis)| (index, Quantity::for_column(&axis.column))).collect();
    let mut header = row(["rank", "run", "design"]);
    header.extend(axes.iter().map(|(_, quantity)| quantity.label()));
    header.extend(TERMS.iter().map(|term| format!("{}, {}", term.symbol, term.unit.0)));
    let term_name = |term: &Term| format!("{}r({})", if term.is_larger_better { "" } else { "1−" }, term.symbol);
    header.extend(TERMS.iter().map(term_name).chain(["r_WC".to_string()]));
    let line = |ranked: &Ranked| {
        let run = &selection.runs[ranked.run_index];
        let figure = |Term { figure, unit: (_, scale), .. }: &Term| {
            let shown = |value: f64| format_number(zero_below_resolution(value, Dimension::Force) * scale, 4);
            figure(run).map_or("–".to_string(), shown)
        };
        let fixed = |value: f64| if value.is_nan() { "–".to_string() } else { format!("{value:.3}") };
        let mut cells = vec![ranked.rank.to_string(), run.run.to_string(), run.design.to_string()];
        cells.extend(axes.iter().map(|(axis, quantity)| quantity.value(&run.axes[*axis], 4)));
        cells.extend(TERMS.iter().map(figure));
        cells.extend(ranked.terms.0.into_iter().chain([ranked.r_wc]).map(fixed));
        cells
    };
    let lines = selection.ranking.iter().take(max_ranked).map(line);
    let rows: Vec<Vec<String>> = std::iter::once(header).chain(lines).collect();
    let weights = selection.weights.named().map(|(name, weight)| format!("{name} {weight}")).join(", ");
    let best = format!(
        "{} of {} meet all criteria; best {} by r_WC (weights: {weights})\n",
        selection.ranking.len(),
        counted(selection.runs.len(), "run"),
        max_ranked.min(selection.ranking.len()),
    );
    Report::from(best).with(table(&rows)).with(equal_terms(selection)).with(class_reasons(selection, max_ranked))
}

/// Returns the reasons for the class of the displayed runs that are not stable.
fn class_reasons(selection: &Selection, max_ranked: usize) -> String {
    let shown = selection.ranking.iter().take(max_ranked).map(|ranked| &selection.runs[ranked.run_index]);
    let line = |run: &Candidate| {
        let class = run.class.filter(|class| *class != Class::Stable)?;
        Some(format!("run {} is {}: {}\n", run.run, class.name(), run.class_reason.as_ref()?))
    };
    shown.filter_map(line).collect()
}

/// Reports the terms that are equal for all selected runs.
fn equal_terms(selection: &Selection) -> String {
    let is_equal = |term: &&Term| {
        let mut values = selection.ranking.iter().map(|ranked| (term.figure)(&selection.runs[ranked.run_index]));
        let first = values.next().flatten();
        values.all(|value| value == first)
    };
    let equal: Vec<&str> = TERMS.iter().filter(is_equal).map(|term| term.symbol).collect();
    match (equal.is_empty(), selection.ranking.len()) {
        (true, _) => String::new(),
        (false, 1) => "Only one run is left, so its terms cannot be scaled: every term counts as ½.\n".to_string(),
        (false, _) => format!("equal for all selected runs: {}; the term counts as ½ for each\n", equal.join(", ")),
    }
}

/// Reports which criterion removed the last run, and what would be left without a single criterion.
fn no_selection(selection: &Selection) -> String {
    let Some(last) = selection.emptied_by() else { return String::new() };
    let mut text = format!("no run meets all criteria: \"{}\" removed the last run\n", criterion_name(&last.criterion));
    let sole_failures: Vec<String> = selection
        .tallies
        .iter()
        .filter(|tally| tally.removed_alone > 0)
        .map(|tally| format!("{} without \"{}\"", tally.removed_alone, criterion_name(&tally.criterion)))
        .collect();
    text.push_str(&match sole_failures.is_empty() {
        true => "omitting a single criterion does not help: every run fails two or more\n".to_string(),
        false => format!("runs that would be left: {}\n", sole_failures.join(", ")),
    });
    text
}

/// Columns of the ranking that precede the columns of the results.
const RANKING_COLUMNS: [(&str, Kind); 6] = [
    ("place", Kind::Integer),
    ("r_wc", Kind::Number),
    ("part_pfp", Kind::Number),
    ("part_tts", Kind::Number),
    ("part_f21", Kind::Number),
    ("part_f22", Kind::Number),
];

/// Returns one row for each selected run, best first: rank, r_WC and its terms, then all columns of the results.
pub fn ranking_table(results: &Table, selection: &Selection) -> Table {
    // If the results are already a ranking, the new ranking columns replace the old ones.
    let other_columns: Vec<usize> = (0..results.columns.len())
        .filter(|&column| RANKING_COLUMNS.iter().all(|(name, _)| *name != results.columns[column].name))
        .collect();
    let ranking = RANKING_COLUMNS.iter().map(|&(name, kind)| Column::new(name, kind));
    let columns = ranking.chain(other_columns.iter().map(|&column| results.columns[column].clone())).collect();
    let line = |ranked: &Ranked| {
        let or_missing = |value: f64| if value.is_nan() { Value::Missing } else { Value::Number(value) };
        let values = [ranked.r_wc].into_iter().chain(ranked.terms.0).map(or_missing);
        let row = &results.rows[selection.runs[ranked.run_index].row];
        std::iter::once(Value::Integer(ranked.rank as i64))
            .chain(values)
            .chain(other_columns.iter().map(|&column| row[column].clone()))
            .collect()
    };
    Table::new(columns, selection.ranking.iter().map(line).collect())
}
