//! `phalanx sweep`: performs all runs of a study or one part of them, writes a table of them, and joins parts.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::output::{
    FileKind, NO_DIRECTORY, picture_target, print_note, print_report, print_result, reserve, save_picture,
};
use super::parsers::{PICTURE, model, number, picture, preset};
use super::progress::{Interrupt, Progress};
use super::{Failure, Status};
use crate::plot::map;
use crate::report::sweep::{SweepReport, SweepWork, sweep_list};
use crate::scene::Preset;
use crate::study::parts::{merge, part_files, write_part};
use crate::study::results::{OpenedResults, Store, open};
use crate::study::sweep::{self, Row, Study, StudyError, run_while, shard, summary};
use crate::trace::Model;

/// Accepted values in messages.
const RUN_LIMIT: &str = "a number of runs, 1 or more; omit the flag to perform all runs";

/// Number of rows that `--list` shows by default.
const DEFAULT_LISTED_RUNS: u64 = 12;

/// Simulate all runs of a study on all cores and write a table of them.
///
/// A study file (TOML) names a base scene of any kind and the fields to vary; scenes/studies contains examples to copy.
/// Each row is appended to OUT.partial.csv as soon as it is available. At the end, OUT contains all rows in order and
/// OUT.study.json identifies the study. Repeating an interrupted command resumes the sweep. Invalid scenes and incomplete simulations have rows too, which state the reason.
///
/// To use several machines, run one shard of the study on each machine (--shard) and join the shards with `phalanx sweep
/// merge`; the result has the same bytes.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  phalanx sweep scenes/studies/thesis.toml --out thesis.csv\n  phalanx sweep scenes/studies/sample.toml \
                  --out sample.parquet --threads 1 --json\n  phalanx sweep scenes/studies/sample.toml --list\n  phalanx sweep scenes/studies/capture.toml --out capture.csv\n  phalanx sweep \
                  scenes/studies/thesis.toml --shard 2/3 --out part-2.parquet\n\nExit status: 0 all runs are in the table; 2 bad input; 3 interrupted (the same command \
                  resumes), or no run could be simulated."
)]
pub(crate) struct SweepArgs {
    #[command(subcommand)]
    command: Option<SweepCommand>,

    /// Study file (TOML); `phalanx schema study` describes it
    #[arg(required = true)]
    study: Option<PathBuf>,

    /// Write the results to this file, as CSV or Parquet according to its extension
    #[arg(long, value_name = "FILE", required_unless_present = "list")]
    out: Option<PathBuf>,

    /// Draw a map of the verdicts over two axes, and of the margin or the time to stability; a third axis gives panels
    #[arg(long, value_name = "FILE.svg|png|html", value_parser = picture(PICTURE), requires = "out", conflicts_with_all = ["shard", "list"])]
    plot: Option<PathBuf>,

    /// Simulation model, instead of the one in the study
    #[arg(long, value_parser = model())]
    model: Option<Model>,

    /// Preset of integrator method and tolerances of the analytic model, instead of those of the scene
    #[arg(long, value_parser = preset())]
    preset: Option<Preset>,

    /// Check every run, with three additional runs for each; adds the columns `check` (sure, uncertain, chaotic or
    /// unknown) and `check_error_rad`
    #[arg(long)]
    check: bool,

    /// Simulate only the first N runs; later commands can add more
    #[arg(long, value_name = "N", value_parser = number(|runs: &u64| *runs > 0, RUN_LIMIT))]
    limit: Option<u64>,

    /// Simulate only shard K of N and write it atomically to one Parquet file; an existing shard is not replaced
    #[arg(long, value_name = "K/N", value_parser = parse_shard, conflicts_with_all = ["limit", "list"])]
    shard: Option<(u64, u64)>,

    /// Discard the results of earlier commands and start again
    #[arg(long)]
    restart: bool,

    /// List the planned runs without running them
    #[arg(long)]
    list: bool,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long, conflicts_with = "list")]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum SweepCommand {
    Merge(MergeArgs),
}

/// Join the shards of a study (`phalanx sweep --shard`) into its complete results.
///
/// OUT and OUT.study.json have the same bytes as those of a single sweep. Shards can be given in any order and may be of
/// different counts N, if each run is in exactly one of them. If a shard is missing, duplicate, damaged or from another
/// study, it is named and nothing is written. Memory use does not grow with the study.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx sweep merge scenes/studies/thesis.toml part-*.parquet --out thesis.csv\n  phalanx sweep \
                  merge scenes/studies/thesis.toml parts/ --out thesis.parquet --json\n\nExit status: 0 all runs are in \
                  the table; 2 bad input, or a shard is missing; 3 interrupted, or the table could not be written."
)]
struct MergeArgs {
    /// Study file (TOML) of the shards
    study: PathBuf,

    /// Files written by `phalanx sweep STUDY --shard K/N`, or directories of such files
    #[arg(value_name = "SHARD", required = true)]
    parts: Vec<PathBuf>,

    /// Write the results to this file, as CSV or Parquet according to its extension
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// Simulation model of the shards, if it is not the one in the study
    #[arg(long, value_parser = model())]
    model: Option<Model>,

    /// Preset of the shards, if they were written with --preset
    #[arg(long, value_parser = preset())]
    preset: Option<Preset>,

    /// The shards were written with --check
    #[arg(long)]
    check: bool,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

impl From<StudyError> for Failure {
    /// The message shows the position in the file and already begins with `error:`.
    fn from(error: StudyError) -> Self {
        Failure { message: error.to_string(), status: Status::BadInput }
    }
}

pub(super) fn run(args: &SweepArgs) -> Result<Status, Failure> {
    if let Some(SweepCommand::Merge(args)) = &args.command {
        return run_merge(args);
    }
    let file = args.study.as_ref().expect("clap requires the study");
    let study = load(file, (args.model, args.preset), args.check)?;
    let (Some(out), false) = (&args.out, args.list) else {
        return print_report(&sweep_list(&study, args.limit.unwrap_or(DEFAULT_LISTED_RUNS)));
    };
    let outputs = [("--out", Some(&**out), FileKind::Results), picture_target(args.plot.as_deref())];
    reserve(&[("the study", &sweep::source_files(file))], &outputs, NO_DIRECTORY)?;
    if let Some(shard) = args.shard {
        return run_shard(args, &study, shard, out);
    }
    let run_limit = args.limit.unwrap_or(u64::MAX);
    let (table, work) = match open(&study, out, run_limit, args.restart)? {
        OpenedResults::Incomplete(store) => run_missing(&study, store, run_limit)?,
        OpenedResults::Complete(table) => {
            let note = "already contains all runs of this study; nothing was run. --restart runs them again.";
            print_note(&format!("{} {note}", out.display()));
            (table, SweepWork::new(0, 0, 0, 0.0))
        }
    };
    if let Some(plot) = &args.plot {
        let picture = map(&study, &table).map_err(|reason| Failure::bad_input(format!("--plot: {reason}")))?;
        save_picture(plot, &study.name, &picture)?;
    }
    let summary = summary(&table).map_err(Failure::incomplete)?;
    let with_result =
        [sweep::Status::Completed, sweep::Status::Filtered].map(|status| summary.count_with_status(status));
    let is_useless = summary.runs > 0 && with_result == [0, 0];
    let status = print_result(&SweepReport::new(&study, out, summary, work), args.json)?;
    if is_useless {
        let message = format!("no run could be completed; {} contains the reason for each run", out.display());
        return Err(Failure::incomplete(message));
    }
    Ok(status)
}

/// Loads a study with the model, the preset and the checks of the command line.
fn load(file: &Path, (model, preset): (Option<Model>, Option<Preset>), check: bool) -> Result<Study, Failure> {
    let mut study = sweep::load(file)?;
    study.model = model.unwrap_or(study.model);
    study.set_preset(preset).map_err(Failure::bad_input)?;
    study.checked = check;
    Ok(study)
}

fn run_missing(study: &Study, mut store: Store, run_limit: u64) -> Result<(crate::table::Table, SweepWork), Failure> {
    let completed: HashSet<u64> = store.completed_runs().collect();
    let interrupt = Interrupt::listen()?;
    let total = study.runs().min(run_limit);
    let mut counts = RowCounts { done: completed.len(), ..RowCounts::default() };
    let mut progress = Progress::new();
    progress.show_count(completed.len(), total as usize, "");
    let mut write_error = None;
    let stats = run_while(study, 0, 1..=run_limit, &completed, &|| interrupt.keep_running(), |row| {
        // Rows must stay in order, so nothing is written after a failed write.
        if write_error.is_none() {
            counts.add(&row);
            progress.show_count(counts.done, total as usize, &counts.problems());
            write_error = store.append(row.cells).err();
        }
        write_error.is_none()
    });
    progress.clear();
    let partial = store.partial_path().display();
    let resume_hint = format!("{} of {total} runs are in {partial}; the same command resumes from there", counts.done);
    if let Some(error) = write_error {
        return Err(Failure::incomplete(format!("cannot write {partial}: {error}; {resume_hint}")));
    }
    if let (false, Some(signal)) = (stats.complete, interrupt.signal()) {
        return Err(Failure::incomplete(format!("the sweep was interrupted by {signal}; {resume_hint}")));
    }
    let work = SweepWork::new(stats.runs, counts.simulations, stats.threads, stats.wall_s);
    Ok((store.finish(study)?, work))
}

fn run_shard(args: &SweepArgs, study: &Study, (number, count): (u64, u64), out: &Path) -> Result<Status, Failure> {
    let shard = shard(study, number, count).map_err(Failure::bad_input)?;
    let mut counts = RowCounts::default();
    let task = format!("shard {number}/{count}");
    let consequence = "shards are written only when complete, so no file was written; run the same command again";
    let part = Interrupt::listen()?.compute([&task, "runs", consequence], |monitor| {
        monitor.start(shard.runs() as usize, "");
        write_part(study, shard, out, 0, args.restart, monitor.keep_running(), |row| {
            counts.add(row);
            monitor.advance(1, &counts.problems());
        })
    })?;
    if part.stats.is_none() {
        let note = "of this study; nothing was run. --restart runs it again.";
        print_note(&format!("{} already contains shard {number}/{count} {note}", out.display()));
    }
    let work = part.stats.map_or(SweepWork::new(0, 0, 0, 0.0), |stats| {
        SweepWork::new(stats.runs, counts.simulations, stats.threads, stats.wall_s)
    });
    let report = SweepReport { shard: Some(shard), ..SweepReport::new(study, out, part.summary, work) };
    print_result(&report, args.json)
}

fn run_merge(args: &MergeArgs) -> Result<Status, Failure> {
    let study = load(&args.study, (args.model, args.preset), args.check)?;
    let parts = part_files(&args.parts)?;
    let inputs = [("the study", &sweep::source_files(&args.study)[..]), ("a shard", &parts)];
    reserve(&inputs, &[("--out", Some(&args.out), FileKind::Results)], NO_DIRECTORY)?;
    let consequence = format!("{} is unchanged; run the same command again to join the shards", args.out.display());
    let task = ["the merge", "runs", &consequence];
    let merged = Interrupt::listen()?.compute(task, |monitor| merge(&study, &args.parts, &args.out, monitor))?;
    let report = SweepReport {
        parts: Some(merged.parts),
        ..SweepReport::new(&study, &args.out, merged.summary, SweepWork::new(0, 0, 0, 0.0))
    };
    print_result(&report, args.json)
}

/// Counts of the rows of a sweep or of a part of one.
#[derive(Default)]
struct RowCounts {
    done: usize,
    simulations: u64,
    failed: u64,
    refused: u64,
}

impl RowCounts {
    fn add(&mut self, row: &Row) {
        self.done += 1;
        self.failed += u64::from(row.status == sweep::Status::Failed);
        self.refused += u64::from(row.status == sweep::Status::Refused);
        self.simulations += u64::from(matches!(row.status, sweep::Status::Completed | sweep::Status::Failed));
    }

    /// The runs without results, for the progress line.
    fn problems(&self) -> String {
        format!("{} failed, {} refused", self.failed, self.refused)
    }
}

/// Parses `3/7`. Accepts digits only, without leading zeros, so that each part has exactly one name.
fn parse_shard(text: &str) -> Result<(u64, u64), String> {
    let parse_digits = |digits: &str| digits.parse().ok().filter(|number: &u64| number.to_string() == digits);
    let numbers = text.split_once('/').and_then(|(k, n)| Some((parse_digits(k)?, parse_digits(n)?)));
    numbers.filter(|(number, count)| 0 < *number && number <= count).ok_or_else(|| {
        "expected K/N with K from 1 to N, both as digits without signs, spaces or leading zeros, such as 1/8 for the \
         first of eight shards"
            .to_string()
    })
}
