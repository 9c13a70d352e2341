//! What a sweep came to, as tables and JSON.

use std::path::Path;

use serde::Serialize;

use crate::study::sweep::{Reason, Shard, Study, Summary};
use crate::table::Value;
use crate::wording::figures::figure;
use crate::wording::report::{Report, Reported, document, list, table};

/// A finished sweep, or a part of one.
#[derive(Clone, Debug, Serialize)]
pub struct SweepReport {
    pub study: String,
    pub model: String,
    /// File of the results.
    pub out: String,
    pub runs: u64,
    pub designs: u64,
    /// The part of the study that the results are, if they are one.
    #[serde(flatten)]
    pub shard: Option<Shard>,
    /// How many parts the results were joined from, if they were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<u64>,
    #[serde(flatten)]
    pub found: Summary,
    /// What was done now; all else was there already.
    pub now: SweepWork,
}

impl SweepReport {
    /// Of the whole of a study, written to `out`.
    pub fn new(study: &Study, out: &Path, found: Summary, now: SweepWork) -> Self {
        SweepReport {
            study: study.name.clone(),
            model: study.model.name().to_string(),
            out: out.display().to_string(),
            runs: study.runs(),
            designs: study.designs(),
            shard: None,
            parts: None,
            found,
            now,
        }
    }
}

/// What this sweep itself did.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SweepWork {
    pub runs: u64,
    /// Runs that were simulated: neither filtered nor refused.
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

/// Tables for people.
impl Reported for SweepReport {
    /// Keys stand by the alphabet.
    fn json(&self) -> String {
        document(&serde_json::to_value(self).unwrap_or_default())
    }

    fn report(&self) -> Report {
        let SweepReport { study, model, out, runs, designs, shard, parts, found, now } = self;
        let of = match shard {
            Some(Shard { number, of, .. }) if found.runs == 0 => format!("shard {number}/{of}: none of {runs} runs"),
            Some(Shard { number, of, first, last }) => format!("shard {number}/{of}: runs {first} to {last} of {runs}"),
            None if found.runs == *runs => format!("{runs} runs"),
            None => format!("{} of {runs} runs", found.runs),
        };
        let mut text = Report::from(format!("{study}: {model} model, {of}, {designs} designs; in {out}\n\n"));
        let line = |(name, count): &(String, u64)| vec![name.clone(), count.to_string()];
        text.push(list(&found.by_status.iter().map(line).collect::<Vec<_>>()));
        if found.no_class > 0 || found.by_class.iter().any(|(_, count)| *count > 0) {
            text.push_str("\nof the completed ones\n");
            let no_class = (found.no_class > 0).then(|| ("no class".to_string(), found.no_class));
            text.push(list(&found.by_class.iter().chain(&no_class).map(line).collect::<Vec<_>>()));
        }
        text.push_str(&reasons(&found.reasons));
        let mut done = String::new();
        if let Some(parts) = parts {
            done.push_str(&format!("Joined from {parts} {}.", if *parts == 1 { "part" } else { "parts" }));
        } else if now.runs < found.runs {
            done.push_str(&format!("{} runs were there already. ", found.runs - now.runs));
        }
        if now.simulations > 0 {
            let threads = if now.threads == 1 { "1 thread".to_string() } else { format!("{} threads", now.threads) };
            done.push_str(&format!(
                "{} simulations in {} s on {threads}: {} a second, {} on each",
                now.simulations,
                figure(now.wall_s, 3),
                figure(now.simulations_per_s, 3),
                figure(now.simulations_per_s_per_thread, 3)
            ));
        }
        if !done.is_empty() {
            text.push(format!("\n{}\n", done.trim_end()));
        }
        text
    }
}

/// Why runs were not completed, or have no class, a line each; nothing if all were and have.
pub(super) fn reasons(of: &[Reason]) -> String {
    if of.is_empty() {
        return String::new();
    }
    let mut text = "\nreasons (numbers are those of the first run)\n".to_string();
    for reason in of {
        text.push_str(&format!(
            "{:>7} {}, first run {}: {}\n",
            reason.runs, reason.status, reason.first_run, reason.reason
        ));
    }
    text
}

/// What a study would run: its axes and its first runs.
pub fn sweep_list(study: &Study, most: u64) -> Report {
    let runs = study.runs();
    let (name, model, designs) = (&study.name, study.model.name(), study.designs());
    let mut text = Report::from(format!("{name}: {model} model, {runs} runs, {designs} designs\n\n"));
    let axes: Vec<Vec<String>> =
        study.fields().map(|(column, count)| vec![column, format!("{count} values")]).collect();
    text.push(list(&axes));
    let names = study.fields().map(|(column, _)| column);
    let head = ["run", "design"].map(String::from).into_iter().chain(names).collect();
    let line = |run: u64| {
        let values = study.points(run).into_iter().map(|point| match point.value {
            Value::Number(number) => figure(number, 6),
            other => other.text(),
        });
        [run.to_string(), study.design(run).to_string()].into_iter().chain(values).collect()
    };
    let rows: Vec<Vec<String>> = std::iter::once(head).chain((1..=runs.min(most)).map(line)).collect();
    text.push('\n');
    text.push(table(&rows));
    if runs > most {
        text.push_str(&format!("and {} more\n", runs - most));
    }
    text
}
