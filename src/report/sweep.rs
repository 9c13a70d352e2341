//! Report of a sweep: tables and JSON.

use std::path::Path;

use serde::Serialize;

use crate::format::numbers::format_number;
use crate::format::report::{Report, ToReport, list, table, to_json_document};
use crate::study::sweep::{Reason, Shard, Study, Summary};
use crate::table::Value;

/// Report of a finished sweep or shard.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SweepReport {
    pub study: String,
    pub model: String,
    /// File of the results.
    pub out: String,
    pub runs: u64,
    pub designs: u64,
    /// The shard, if the results are a part of the study.
    #[serde(flatten)]
    pub shard: Option<Shard>,
    /// Number of parts that the results were merged from, if they were merged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<u64>,
    #[serde(flatten)]
    pub summary: Summary,
    /// Work of this invocation; the other results existed already.
    #[serde(rename = "now")]
    pub work: SweepWork,
}

impl SweepReport {
    /// Creates the report of a whole study with results in `out`.
    pub fn new(study: &Study, out: &Path, summary: Summary, work: SweepWork) -> Self {
        SweepReport {
            study: study.name.clone(),
            model: study.model.name().to_string(),
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
    /// Number of simulated runs: neither filtered nor rejected.
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
        let SweepReport { study, model, out, runs, designs, shard, parts, summary, work } = self;
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
        let mut text = Report::from(format!("{study}: {model} model, {scope}, {designs} designs; in {out}\n\n"));
        let line = |(name, count): &(String, u64)| vec![name.clone(), count.to_string()];
        text.push(list(&summary.by_status.iter().map(line).collect::<Vec<_>>()));
        if summary.no_class > 0 || summary.by_class.iter().any(|(_, count)| *count > 0) {
            text.push_str("\nclasses of completed runs\n");
            let no_class = (summary.no_class > 0).then(|| ("no class".to_string(), summary.no_class));
            text.push(list(&summary.by_class.iter().chain(&no_class).map(line).collect::<Vec<_>>()));
        }
        text.push_str(&reasons("reasons", &summary.reasons));
        let mut done = String::new();
        if let Some(parts) = parts {
            done.push_str(&format!("Merged from {parts} {}.", if *parts == 1 { "shard" } else { "shards" }));
        } else if work.runs < summary.runs {
            done.push_str(&format!("{} runs existed already. ", summary.runs - work.runs));
        }
        if work.simulations > 0 {
            let threads = if work.threads == 1 { "1 thread".to_string() } else { format!("{} threads", work.threads) };
            done.push_str(&format!(
                "{} simulations in {} s on {threads}: {} per second, {} per second and thread",
                work.simulations,
                format_number(work.wall_s, 3),
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
pub(super) fn reasons(heading: &str, reasons: &[Reason]) -> String {
    let line = |Reason { status, reason, runs, first_run }: &Reason| {
        format!("{runs:>7} {status}, first run {first_run}: {reason}\n")
    };
    let lines: String = reasons.iter().map(line).collect();
    if lines.is_empty() { lines } else { format!("\n{heading} (numbers from the first run)\n{lines}") }
}

/// Lists the axes of a study and its first `max_runs` runs.
pub(crate) fn sweep_list(study: &Study, max_runs: u64) -> Report {
    let runs = study.runs();
    let (name, model, designs) = (&study.name, study.model.name(), study.designs());
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
    text.push('\n');
    text.push(table(&rows));
    if runs > max_runs {
        text.push_str(&format!("and {} more\n", runs - max_runs));
    }
    text
}
