//! `phalanx sweep`: every run of a study, and a table of them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::interrupt::Interrupt;
use super::output::{answer, note, print, show};
use super::study_args::StudyArgs;
use super::sweep_merge::{self, MergeArgs};
use super::sweep_progress::SoFar;
use super::sweep_shard::{self, Place, ShardOf, shard_of};
use super::targets::{Kind, NONE, reserve};
use super::volume_args::threads_or_all;
use super::words::ModelArg;
use super::{Failure, Status};
use crate::report::sweep::{SweepReport, SweepWork, sweep_list};
use crate::study::store::{Found, Store, StoreError, open};
use crate::study::sweep::{self, Ran, Study, StudyError, Summary, run_while, summary};
use crate::table::Table;

/// Rows that `--list` shows.
const LISTED: u64 = 12;

/// Simulate every run of a study, on all cores, and write a table of them.
///
/// A study file (TOML) names a base scene and the fields of it that vary; scenes/studies has some to copy. Rows are added to
/// OUT.partial.csv as they are found; in the end all are in OUT, in order, and OUT.study.json says of which study. The same
/// command again goes on where an earlier one was ended, however it was. A scene that is not valid and a simulation that does
/// not end are rows too, with their reasons.
///
/// On several machines each makes a part (--shard), and `phalanx sweep merge` joins the parts to the same bytes.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  phalanx sweep scenes/studies/thesis.toml --out thesis.csv\n  phalanx sweep scenes/studies/sample.toml \
                  --out sample.parquet --threads 1 --json\n  phalanx sweep scenes/studies/sample.toml --list\n  phalanx sweep \
                  scenes/studies/thesis.toml --shard 2/3 --out part-2.parquet\n  phalanx sweep --schema > \
                  study.schema.json\n\nExit status: 0 all runs are in the table; 2 bad input; 3 interrupted (the same command \
                  goes on), or not one run could be simulated."
)]
pub struct SweepArgs {
    #[command(subcommand)]
    command: Option<SweepCommand>,

    /// Study file (TOML); `phalanx sweep --schema` describes it
    #[arg(required_unless_present = "schema")]
    study: Option<PathBuf>,

    /// Results, as CSV or Parquet by the name
    #[arg(long, value_name = "FILE", required_unless_present_any = ["schema", "list"])]
    out: Option<PathBuf>,

    /// Which of the two models simulates, instead of the study's
    #[arg(long, value_enum)]
    model: Option<ModelArg>,

    /// Check every run: columns `check` (sure, uncertain, chaotic or unknown) and `check_error_rad`; takes three more runs for each
    #[arg(long)]
    check: bool,

    /// Threads, 0 for one on each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads_or_all)]
    threads: usize,

    /// Make only the first N runs; more can be added later
    #[arg(long, value_name = "N", value_parser = runs)]
    limit: Option<u64>,

    /// Make only part K of N, as one Parquet file that appears whole or not at all; a part that is there is left as it is
    #[arg(long, value_name = "K/N", value_parser = shard_of, conflicts_with_all = ["limit", "list", "schema"])]
    shard: Option<ShardOf>,

    #[command(flatten)]
    how: StudyArgs,
}

#[derive(Debug, Subcommand)]
enum SweepCommand {
    Merge(MergeArgs),
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Refused(message) => Failure::bad_input(message),
            StoreError::Broken(message) => Failure::incomplete(message),
        }
    }
}

impl From<StudyError> for Failure {
    /// The message shows the place in the file, and begins with `error:` itself.
    fn from(error: StudyError) -> Self {
        Failure { message: error.to_string(), status: Status::BadInput }
    }
}

/// Runs the command.
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
    let (Some(out), false) = (&args.out, args.how.list) else {
        show(&sweep_list(&study, args.limit.unwrap_or(LISTED)))?;
        return Ok(Status::Done);
    };
    reserve(&[("the study", &sweep::sources(file))], &[("--out", Some(out), Kind::Results)], NONE)?;
    if let Some(of) = args.shard {
        let place = Place { out, threads: args.threads, restart: args.how.restart, json: args.how.json };
        return sweep_shard::run(&study, of, &place);
    }
    let most = args.limit.unwrap_or(u64::MAX);
    match open(&study, out, most, args.how.restart)? {
        Found::Complete(table) => {
            note(&format!(
                "{} has all runs of this study already: nothing was run. --restart runs them again.",
                out.display()
            ));
            tell(args, &study, out, &table, SweepWork::new(0, 0, 0, 0.0))
        }
        Found::Begun(store) => make(args, &study, out, store, most),
    }
}

/// Makes the runs that are not there yet.
fn make(args: &SweepArgs, study: &Study, out: &Path, mut store: Store, most: u64) -> Result<Status, Failure> {
    let done: HashSet<u64> = store.done().collect();
    let interrupt = Interrupt::listen()?;
    let mut so_far = SoFar::new(study.runs().min(most), done.len() as u64);
    let mut broken = None;
    let ran = run_while(study, args.threads, most, &done, &|| interrupt.signal().is_none(), |row| {
        // Nothing may follow what could not be written.
        if broken.is_none() {
            so_far.take(&row);
            broken = store.add(row.cells).err();
        }
        broken.is_none()
    });
    so_far.count.clear();
    let goes_on = format!(
        "{} of {} runs are in {}: the same command goes on from there",
        so_far.done,
        so_far.total,
        store.partial().display()
    );
    if let Some(error) = broken {
        return Err(Failure::incomplete(format!("cannot write {}: {error}; {goes_on}", store.partial().display())));
    }
    if let (false, Some(signal)) = (ran.complete, interrupt.signal()) {
        return Err(Failure::incomplete(format!("the sweep was interrupted by {signal}; {goes_on}")));
    }
    let table = store.finish(study)?;
    let Ran { runs, threads, wall_s, .. } = ran;
    tell(args, study, out, &table, SweepWork::new(runs, so_far.simulations, threads, wall_s))
}

/// Says what is in the results.
fn tell(args: &SweepArgs, study: &Study, out: &Path, table: &Table, now: SweepWork) -> Result<Status, Failure> {
    let found = summary(table).map_err(Failure::incomplete)?;
    let nothing = nothing(&found);
    let report = SweepReport::new(study, out, found, now);
    answer(&report, args.how.json)?;
    match nothing {
        true => Err(Failure::incomplete(format!(
            "not one run could be simulated to its end; {} says why of each",
            out.display()
        ))),
        false => Ok(Status::Done),
    }
}

fn runs(text: &str) -> Result<u64, String> {
    let number = text.parse().ok().filter(|runs| *runs > 0);
    number.ok_or("expected a number of runs from 1; leave it out for all".to_string())
}

/// Whether a sweep found nothing but refusals and failures.
fn nothing(found: &Summary) -> bool {
    use sweep::Status::{Completed, Filtered};
    found.runs > 0 && found.with(Completed) == 0 && found.with(Filtered) == 0
}
