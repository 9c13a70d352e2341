//! `phalanx sweep`: every run of a study, and a table of them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;

use super::interrupt::Interrupt;
use super::output::{note, print, show};
use super::progress::Count;
use super::sweep_store::{Found, Store, open};
use super::volume_args::threads_or_all;
use super::words::ModelArg;
use super::{Failure, Status};
use crate::report::{SweepReport, SweepWork, sweep_json, sweep_list, sweep_text};
use crate::study::sweep::{self, Ran, Row, Study, StudyError, Summary, run_while, summary};
use crate::table::Table;

/// Rows that `--list` shows.
const LISTED: u64 = 12;

/// Simulate every run of a study, on all cores, and write a table of them.
///
/// A study file (TOML) names a base scene and the fields of it that vary; scenes/studies has some to copy. Rows are added to
/// OUT.partial.csv as they are found; in the end all are in OUT, in order, and OUT.study.json says of which study. The same
/// command again goes on where an earlier one was ended, however it was. A scene that is not valid and a simulation that does
/// not end are rows too, with their reasons.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx sweep scenes/studies/thesis.toml --out thesis.csv\n  phalanx sweep scenes/studies/sample.toml \
                  --out sample.parquet --threads 1 --json\n  phalanx sweep scenes/studies/sample.toml --list\n  phalanx sweep --schema \
                  > study.schema.json\n\nExit status: 0 all runs are in the table; 2 bad input; 3 interrupted (the same command \
                  goes on), or not one run could be simulated."
)]
pub struct SweepArgs {
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

    /// Begin anew, whatever is there of an earlier sweep
    #[arg(long)]
    restart: bool,

    /// Show what would be run, and run nothing
    #[arg(long)]
    list: bool,

    /// Print the JSON Schema of study files, for editors
    #[arg(long, conflicts_with_all = ["study", "out", "list"])]
    schema: bool,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long, conflicts_with = "list")]
    json: bool,
}

impl From<StudyError> for Failure {
    /// The message shows the place in the file, and begins with `error:` itself.
    fn from(error: StudyError) -> Self {
        Failure { message: error.to_string(), status: Status::BadInput }
    }
}

/// Runs the command.
pub fn run(args: &SweepArgs) -> Result<Status, Failure> {
    let Some(file) = &args.study else {
        print(&sweep::schema())?;
        return Ok(Status::Done);
    };
    let mut study = sweep::load(file)?;
    if let Some(model) = args.model {
        study.model = model.into();
    }
    study.checked = args.check;
    let (Some(out), false) = (&args.out, args.list) else {
        show(&sweep_list(&study, args.limit.unwrap_or(LISTED)))?;
        return Ok(Status::Done);
    };
    let most = args.limit.unwrap_or(u64::MAX);
    match open(&study, out, most, args.restart)? {
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
    let report = SweepReport {
        study: study.name.clone(),
        model: study.model.name().to_string(),
        out: out.display().to_string(),
        runs: study.runs(),
        designs: study.designs(),
        found,
        now,
    };
    match args.json {
        true => print(&sweep_json(&report)),
        false => show(&sweep_text(&report)),
    }?;
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

/// How far a sweep has come.
struct SoFar {
    count: Count,
    total: u64,
    done: u64,
    simulations: u64,
    failed: u64,
    refused: u64,
    start: Instant,
    next: Duration,
}

impl SoFar {
    /// With so many done before this sweep.
    fn new(total: u64, done: u64) -> Self {
        let (mut count, start) = (Count::new(), Instant::now());
        count.show(done as usize, total as usize, "");
        SoFar { count, total, done, simulations: 0, failed: 0, refused: 0, start, next: Duration::ZERO }
    }

    fn take(&mut self, row: &Row) {
        self.done += 1;
        match row.status {
            sweep::Status::Completed => self.simulations += 1,
            sweep::Status::Failed => (self.simulations, self.failed) = (self.simulations + 1, self.failed + 1),
            sweep::Status::Refused => self.refused += 1,
            sweep::Status::Filtered => {}
        }
        let elapsed = self.start.elapsed();
        // Texts are made only as often as somebody can read them.
        if elapsed >= self.next {
            self.next = elapsed + Duration::from_millis(100);
            let text = format!("{} failed, {} refused", self.failed, self.refused);
            self.count.show(self.done as usize, self.total as usize, &text);
        }
    }
}
