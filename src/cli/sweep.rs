//! `phalanx sweep`: performs all runs of a study and writes a table of them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::choice_args::ModelArg;
use super::interrupt::Interrupt;
use super::output::{print, print_note, print_report, print_result};
use super::study_args::StudyArgs;
use super::sweep_merge::{self, MergeArgs};
use super::sweep_progress::SweepProgress;
use super::sweep_shard::{self, ShardArg, ShardOutput, parse_shard};
use super::targets::{NO_DIRECTORY, TargetKind, reserve};
use super::value_lists::parse_threads_or_all;
use super::{Failure, Status};
use crate::report::sweep::{SweepReport, SweepWork, sweep_list};
use crate::study::store::{OpenedResults, Store, StoreError, open};
use crate::study::sweep::{self, RunStats, Study, StudyError, Summary, run_while, summary};
use crate::table::Table;

/// Number of rows that `--list` shows by default.
const DEFAULT_LISTED_RUNS: u64 = 12;

/// Simulate all runs of a study on all cores and write a table of them.
///
/// A study file (TOML) names a base scene and the fields to vary; scenes/studies contains examples to copy. Each row is
/// appended to OUT.partial.csv as soon as it is available. At the end, OUT contains all rows in order and OUT.study.json
/// identifies the study. Repeating an interrupted command resumes the sweep. Invalid scenes and incomplete simulations
/// have rows too, which state the reason.
///
/// To use several machines, run one shard of the study on each machine (--shard) and join the shards with `phalanx sweep
/// merge`; the result has the same bytes.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  phalanx sweep scenes/studies/thesis.toml --out thesis.csv\n  phalanx sweep scenes/studies/sample.toml \
                  --out sample.parquet --threads 1 --json\n  phalanx sweep scenes/studies/sample.toml --list\n  phalanx sweep \
                  scenes/studies/thesis.toml --shard 2/3 --out part-2.parquet\n  phalanx sweep --schema > \
                  study.schema.json\n\nExit status: 0 all runs are in the table; 2 bad input; 3 interrupted (the same command \
                  resumes), or no run could be simulated."
)]
pub struct SweepArgs {
    #[command(subcommand)]
    command: Option<SweepCommand>,

    /// Study file (TOML); `phalanx sweep --schema` describes it
    #[arg(required_unless_present = "schema")]
    study: Option<PathBuf>,

    /// Write the results to this file, as CSV or Parquet according to its extension
    #[arg(long, value_name = "FILE", required_unless_present_any = ["schema", "list"])]
    out: Option<PathBuf>,

    /// Simulation model, instead of the one in the study
    #[arg(long, value_enum)]
    model: Option<ModelArg>,

    /// Check every run, with three additional runs for each; adds the columns `check` (sure, uncertain, chaotic or
    /// unknown) and `check_error_rad`
    #[arg(long)]
    check: bool,

    /// Number of threads; 0 uses all cores
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads_or_all)]
    threads: usize,

    /// Simulate only the first N runs; later commands can add more
    #[arg(long, value_name = "N", value_parser = parse_run_limit)]
    limit: Option<u64>,

    /// Simulate only shard K of N and write it atomically to one Parquet file; an existing shard is not replaced
    #[arg(long, value_name = "K/N", value_parser = parse_shard, conflicts_with_all = ["limit", "list", "schema"])]
    shard: Option<ShardArg>,

    #[command(flatten)]
    study_args: StudyArgs,
}

#[derive(Debug, Subcommand)]
enum SweepCommand {
    Merge(MergeArgs),
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Refused(message) => Failure::bad_input(message),
            StoreError::WriteFailed(message) => Failure::incomplete(message),
        }
    }
}

impl From<StudyError> for Failure {
    /// The message shows the position in the file and already begins with `error:`.
    fn from(error: StudyError) -> Self {
        Failure { message: error.to_string(), status: Status::BadInput }
    }
}

/// Runs `phalanx sweep`.
pub fn run(args: &SweepArgs) -> Result<Status, Failure> {
    if let Some(SweepCommand::Merge(args)) = &args.command {
        return sweep_merge::run(args);
    }
    let Some(file) = &args.study else {
        print(&sweep::schema())?;
        return Ok(Status::Done);
    };
    let mut study = sweep::load(file)?;
    if let Some(model) = args.model {
        study.model = model.into();
    }
    study.checked = args.check;
    let (Some(out), false) = (&args.out, args.study_args.list) else {
        print_report(&sweep_list(&study, args.limit.unwrap_or(DEFAULT_LISTED_RUNS)))?;
        return Ok(Status::Done);
    };
    reserve(&[("the study", &sweep::source_files(file))], &[("--out", Some(out), TargetKind::Results)], NO_DIRECTORY)?;
    if let Some(shard) = args.shard {
        let output =
            ShardOutput { out, threads: args.threads, restart: args.study_args.restart, json: args.study_args.json };
        return sweep_shard::run(&study, shard, &output);
    }
    let run_limit = args.limit.unwrap_or(u64::MAX);
    match open(&study, out, run_limit, args.study_args.restart)? {
        OpenedResults::Complete(table) => {
            print_note(&format!(
                "{} already contains all runs of this study; nothing was run. --restart runs them again.",
                out.display()
            ));
            print_summary(args, &study, out, &table, SweepWork::new(0, 0, 0, 0.0))
        }
        OpenedResults::Incomplete(store) => run_missing(args, &study, out, store, run_limit),
    }
}

/// Performs the missing runs.
fn run_missing(
    args: &SweepArgs,
    study: &Study,
    out: &Path,
    mut store: Store,
    run_limit: u64,
) -> Result<Status, Failure> {
    let completed: HashSet<u64> = store.completed_runs().collect();
    let interrupt = Interrupt::listen()?;
    let mut progress = SweepProgress::new(study.runs().min(run_limit), completed.len() as u64);
    let mut write_error = None;
    let stats = run_while(study, args.threads, run_limit, &completed, &|| interrupt.signal().is_none(), |row| {
        // Rows must stay in order, so nothing is written after a failed write.
        if write_error.is_none() {
            progress.record(&row);
            write_error = store.append(row.cells).err();
        }
        write_error.is_none()
    });
    progress.counter.clear();
    let resume_hint = format!(
        "{} of {} runs are in {}; the same command resumes from there",
        progress.done,
        progress.total,
        store.partial_path().display()
    );
    if let Some(error) = write_error {
        return Err(Failure::incomplete(format!(
            "cannot write {}: {error}; {resume_hint}",
            store.partial_path().display()
        )));
    }
    if let (false, Some(signal)) = (stats.complete, interrupt.signal()) {
        return Err(Failure::incomplete(format!("the sweep was interrupted by {signal}; {resume_hint}")));
    }
    let table = store.finish(study)?;
    let RunStats { runs, threads, wall_s, .. } = stats;
    print_summary(args, study, out, &table, SweepWork::new(runs, progress.simulations, threads, wall_s))
}

/// Prints a summary of the results.
fn print_summary(
    args: &SweepArgs,
    study: &Study,
    out: &Path,
    table: &Table,
    work: SweepWork,
) -> Result<Status, Failure> {
    let sweep_summary = summary(table).map_err(Failure::incomplete)?;
    let has_no_result = has_no_result(&sweep_summary);
    let report = SweepReport::new(study, out, sweep_summary, work);
    print_result(&report, args.study_args.json)?;
    match has_no_result {
        true => Err(Failure::incomplete(format!(
            "no run could be completed; {} contains the reason for each run",
            out.display()
        ))),
        false => Ok(Status::Done),
    }
}

fn parse_run_limit(text: &str) -> Result<u64, String> {
    let number = text.parse().ok().filter(|runs| *runs > 0);
    number.ok_or("expected a number of runs, 1 or more; omit the flag to perform all runs".to_string())
}

/// Returns whether all runs of a sweep were refused or failed.
fn has_no_result(summary: &Summary) -> bool {
    use sweep::Status::{Completed, Filtered};
    summary.runs > 0 && summary.count_with_status(Completed) == 0 && summary.count_with_status(Filtered) == 0
}
