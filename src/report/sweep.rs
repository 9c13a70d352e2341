//! Reports of a sweep and of a selection from its results: tables and JSON, and the ranking as a typed table.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Serialize, Serializer};

use super::named::Object;
use crate::criteria::Class;
use crate::format::numbers::{format_number, or_dash, row, zero_below_resolution};
use crate::format::percent_of;
use crate::format::quantity::ColumnFormat;
use crate::format::report::{Report, ToReport, list, table, to_json_document};
use crate::scene::{Keyword as _, one_line};
use crate::study::select::{ClassCounts, Condition, Ranked, Selection, TERMS, Term};
use crate::study::sweep::{Reason, Shard, Status, Study, Summary};
use crate::table::{Column, Kind, Table, Value};
use crate::units::Dimension;

/// Report of a finished sweep or shard.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SweepReport {
    pub study: String,
    pub model: String,
    /// Preset that replaces the integrator settings of the scene; `None` without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<&'static str>,
    /// Path of the results.
    pub out: String,
    pub runs: u64,
    pub designs: u64,
    /// The shard, if the results are only part of the study; otherwise `None`.
    #[serde(flatten)]
    pub shard: Option<Shard>,
    /// Number of parts that were merged into the results; `None` if there was no merge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<u64>,
    #[serde(flatten)]
    pub summary: Summary,
    /// Work of this invocation. The other results already existed.
    #[serde(rename = "now")]
    pub work: SweepWork,
}

impl SweepReport {
    /// Creates the report of a whole study whose results are in the file `out`.
    pub fn new(study: &Study, out: &Path, summary: Summary, work: SweepWork) -> Self {
        SweepReport {
            study: study.name.clone(),
            model: study.model.name().to_string(),
            preset: study.preset.map(|preset| preset.keyword()),
            out: out.display().to_string(),
            runs: study.runs(),
            designs: study.designs(),
            shard: None,
            parts: None,
            summary,
            work,
        }
    }
}

/// Computational cost of one invocation of `phalanx sweep`.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct SweepWork {
    pub runs: u64,
    /// Number of simulated runs: those that were neither filtered nor rejected.
    pub simulations: u64,
    pub threads: usize,
    pub wall_s: f64,
    pub simulations_per_s: f64,
    pub simulations_per_s_per_thread: f64,
}

impl SweepWork {
    pub fn new(runs: u64, simulations: u64, threads: usize, wall_s: f64) -> Self {
        let rate = if wall_s > 0.0 { simulations as f64 / wall_s } else { 0.0 };
        SweepWork {
            runs,
            simulations,
            threads,
            wall_s,
            simulations_per_s: rate,
            simulations_per_s_per_thread: rate / threads.max(1) as f64,
        }
    }
}

impl ToReport for SweepReport {
    /// Keys are in alphabetical order.
    fn json(&self) -> String {
        to_json_document(&serde_json::to_value(self).unwrap_or_default())
    }

    fn report(&self) -> Report {
        let SweepReport { study, model, preset, out, runs, designs, shard, parts, summary, work } = self;
        let scope = match shard {
            Some(Shard { number, count, .. }) if summary.runs == 0 => {
                format!("shard {number}/{count}: none of {runs} runs")
            }
            Some(Shard { number, count, first, last }) => {
                format!("shard {number}/{count}: runs {first} to {last} of {runs}")
            }
            None if summary.runs == *runs => format!("{runs} runs"),
            None => format!("{} of {runs} runs", summary.runs),
        };
        let preset = preset.map_or(String::new(), |preset| format!(" ({preset} preset)"));
        let mut text = Report::from(format!(
            "{}: {model} model{preset}, {scope}, {designs} designs; in {}\n\n",
            one_line(study),
            one_line(out)
        ));
        let line = |(name, count): &(String, u64)| vec![name.clone(), count.to_string()];
        text.push(list(&summary.by_status.iter().map(line).collect::<Vec<_>>()));
        if summary.no_class > 0 || summary.by_class.iter().any(|(_, count)| *count > 0) {
            let no_class = (summary.no_class > 0).then(|| ("no class".to_string(), summary.no_class));
            let classes = summary.by_class.iter().chain(&no_class).map(line).collect::<Vec<_>>();
            text = text.with("\nclasses of completed runs\n").with(list(&classes));
        }
        text.push(reasons("reasons", &summary.reasons));
        let mut done = match parts {
            Some(parts) => format!("Merged from {}.", counted(*parts, "shard")),
            None if work.runs < summary.runs => format!("{} runs existed already. ", summary.runs - work.runs),
            None => String::new(),
        };
        if work.simulations > 0 {
            done.push_str(&format!(
                "{} simulations in {} s on {}: {} per second, {} per second and thread",
                work.simulations,
                format_number(work.wall_s, 3),
                counted(work.threads as u64, "thread"),
                format_number(work.simulations_per_s, 3),
                format_number(work.simulations_per_s_per_thread, 3)
            ));
        }
        if !done.is_empty() {
            text.push(format!("\n{}\n", done.trim_end()));
        }
        text
    }
}

/// Returns a heading and the reasons for the status of runs, one per line; empty if there are none.
fn reasons(heading: &str, reasons: &[Reason]) -> String {
    let line = |Reason { status, reason, runs, first_run }: &Reason| {
        format!("{runs:>7} {status}, first run {first_run}: {reason}\n")
    };
    let lines: String = reasons.iter().map(line).collect();
    if lines.is_empty() { lines } else { format!("\n{heading} (numbers from the first run)\n{lines}") }
}

/// Lists the axes of a study and its first `max_runs` runs.
pub(crate) fn sweep_list(study: &Study, max_runs: u64) -> Report {
    let runs = study.runs();
    let (name, model, designs) = (one_line(&study.name), study.model.name(), study.designs());
    let mut text = Report::from(format!("{name}: {model} model, {runs} runs, {designs} designs\n\n"));
    let axes: Vec<Vec<String>> =
        study.fields().map(|(column, count)| vec![column, format!("{count} values")]).collect();
    text.push(list(&axes));
    let names = study.fields().map(|(column, _)| column);
    let header = ["run", "design"].map(String::from).into_iter().chain(names).collect();
    let line = |run: u64| {
        let values = study.field_values(run).into_iter().map(|field| match field.value {
            Value::Number(number) => format_number(number, 6),
            other => other.text(),
        });
        [run.to_string(), study.design(run).to_string()].into_iter().chain(values).collect()
    };
    let rows: Vec<Vec<String>> = std::iter::once(header).chain((1..=runs.min(max_runs)).map(line)).collect();
    text.push("\n");
    text.push(table(&rows));
    if runs > max_runs {
        text.push_str(&format!("and {} more\n", runs - max_runs));
    }
    text
}

/// Report of a selection; values are in SI.
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
        let [runs, designs] = [(selection.runs.len(), "run"), (selection.designs(), "design")]
            .map(|(count, noun)| counted(count as u64, noun));
        let missing = selection.missing_runs.first().map(|first| {
            let count = counted(selection.missing_runs.len() as u64, "run");
            format!(
                "{count} before the last are missing (first: run {first}): the sweep is not finished, and they cannot be selected\n"
            )
        });
        let head = Report::from(format!("{source}: {runs} of {designs}\n")).with(missing);
        let classes = classes(selection).with(class_reasons(selection));
        Report::join([head, classes, criteria(selection), ranking(selection, *max_ranked)])
    }
}

fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Returns a table of static and dynamic classes with a column for each condition.
fn classes(selection: &Selection) -> Report {
    let header = std::iter::once("class".to_string()).chain(selection.conditions.iter().map(Condition::name));
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
    line("stable or semi-stable", &|counts| counts.dynamic[0] + counts.dynamic[1]);
    table(&rows)
}

/// Returns the reasons for the classes, and why some runs have none.
fn class_reasons(selection: &Selection) -> String {
    let mut text = reasons("reasons for the class", &selection.class_reasons);
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
        rows.push(std::iter::once(tally.criterion.name()).chain(cells).collect());
    }
    table(&rows).with(
        "\"left\" counts runs that meet this criterion and all above it; \"removed by it alone\" counts runs that meet all \
         others.\n",
    )
}

/// Returns a table of the best runs with their values and the terms of r_WC.
fn ranking(selection: &Selection, max_ranked: usize) -> Report {
    if selection.ranking.is_empty() {
        return Report::from(no_selection(selection));
    }
    let varied = selection.axes.iter().enumerate().filter(|(_, axis)| axis.values.len() > 1);
    let axes: Vec<(usize, ColumnFormat)> =
        varied.map(|(index, axis)| (index, ColumnFormat::for_column(&axis.column))).collect();
    let mut header = row(["rank", "run", "design"]);
    header.extend(axes.iter().map(|(_, quantity)| quantity.label()));
    header.extend(TERMS.iter().map(|term| format!("{}, {}", term.symbol, term.unit.0)));
    let term_name = |term: &Term| format!("{}r({})", if term.is_larger_better { "" } else { "1−" }, term.symbol);
    header.extend(TERMS.iter().map(term_name).chain(["r_WC".to_string()]));
    let line = |ranked: &Ranked| {
        let run = &selection.runs[ranked.run_index];
        let figure = |Term { figure, unit: (_, scale), .. }: &Term| {
            let shown = |value: f64| format_number(zero_below_resolution(value, Dimension::Force) * scale, 4);
            or_dash(figure(run), shown)
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
        counted(selection.runs.len() as u64, "run"),
        max_ranked.min(selection.ranking.len()),
    );
    // Reasons for the class of the displayed runs that are not stable.
    let reasons = selection.ranking.iter().take(max_ranked).filter_map(|ranked| {
        let run = &selection.runs[ranked.run_index];
        let class = run.class.filter(|class| *class != Class::Stable)?;
        Some(format!("run {} is {}: {}\n", run.run, class.name(), run.class_reason.as_ref()?))
    });
    Report::from(best).with(table(&rows)).with(equal_terms(selection)).with(reasons.collect::<String>())
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
    let sole_failures = selection.tallies.iter().filter(|tally| tally.removed_alone > 0);
    let sole_failures: Vec<String> =
        sole_failures.map(|tally| format!("{} without \"{}\"", tally.removed_alone, tally.criterion.name())).collect();
    let hint = match sole_failures.is_empty() {
        true => "omitting a single criterion does not help: every run fails two or more".to_string(),
        false => format!("runs that would be left: {}", sole_failures.join(", ")),
    };
    format!("no run meets all criteria: \"{}\" removed the last run\n{hint}\n", last.criterion.name())
}

/// Columns of the ranking that precede the columns of the results; the first is an integer.
const RANKING_COLUMNS: [&str; 6] = ["place", "r_wc", "part_pfp", "part_tts", "part_f21", "part_f22"];

/// Returns one row for each selected run, best first. Its columns are the rank, r_WC and its terms, then all columns of
/// the results.
pub fn ranking_table(results: &Table, selection: &Selection) -> Table {
    // If the results are already a ranking, the new ranking columns replace the old ones.
    let other_columns: Vec<usize> = (0..results.columns.len())
        .filter(|&column| !RANKING_COLUMNS.contains(&results.columns[column].name.as_str()))
        .collect();
    let kinds = std::iter::once(Kind::Integer).chain(std::iter::repeat(Kind::Number));
    let ranking = RANKING_COLUMNS.into_iter().zip(kinds).map(|(name, kind)| Column::new(name, kind));
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
