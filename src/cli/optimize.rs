//! `phalanx optimize`: the best designs over ranges of fields.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;

use super::folder::Folder;
use super::interrupt::Interrupt;
use super::output::{answer, note, print, show};
use super::own::Form;
use super::progress::Count;
use super::saved::save;
use super::study_args::StudyArgs;
use super::targets::{Kind, reserve};
use super::volume_args::threads_or_all;
use super::words::ModelArg;
use super::{Failure, Status};
use crate::page::report_page;
use crate::plot;
use crate::report::optimize::{OptimisationReport, optimisation_list, scene_file};
use crate::report::sweep::SweepWork;
use crate::study::optimize::{self, Design, Found, Listener, Optimisation, Optimised};
use crate::study::store::{Found as Stored, Store, open};
use crate::study::sweep::{Row, sources, summary};
use crate::table::{self, Table};

/// Search for the best designs: variables within bounds, objectives and constraints on what simulations come to.
///
/// The file (TOML) names a base scene, the fields that may change with their bounds, the conditions under which every design runs (friction,
/// offsets, tolerances), what is to be made small or large, and what has to hold; scenes/studies/optimize-95.toml is one to copy. NSGA-II
/// finds the front of several objectives, CMA-ES the best by one. The start of the search is the base scene, and all is compared with it.
///
/// Every design is a row of OUT, with its generation and whether it is on the front. Its runs are rows of a table beside it (OUT with
/// `.runs` before its ending), in the columns of `phalanx sweep`; they are on the disk as soon as they end, and the same command again goes
/// on where an earlier one was ended, to the same bytes. The seed decides, not the number of threads.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx optimize scenes/studies/optimize-95.toml --out front.csv --html front.html\n  phalanx optimize \
                  my-study.toml --out front.parquet --scenes front --json\n  phalanx optimize my-study.toml --list\n  phalanx optimize \
                  --schema > optimisation.schema.json\n\nExit status: 0 done; 1 no design meets all constraints; 2 bad input; 3 interrupted \
                  (the same command goes on), or files could not be written."
)]
pub struct OptimizeArgs {
    /// What is searched (TOML); `phalanx optimize --schema` describes it
    #[arg(required_unless_present = "schema")]
    study: Option<PathBuf>,

    /// All designs, as CSV or Parquet by the name
    #[arg(long, value_name = "FILE", required_unless_present_any = ["schema", "list"])]
    out: Option<PathBuf>,

    /// Which of the two models simulates, instead of the study's
    #[arg(long, value_enum)]
    model: Option<ModelArg>,

    /// Threads, 0 for one on each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads_or_all)]
    threads: usize,

    /// Write a picture of the designs and the front
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,

    /// Write a page: the picture, the tables, and a scene at a click on a point of the front
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,

    /// Write each design of the front as a scene there, design-N.toml with leading zeros, and start.toml; the table names the file of each
    /// design it compares, such as the compromise; the directory is made if need be
    #[arg(long, value_name = "DIR")]
    scenes: Option<PathBuf>,

    /// How many designs of the front to print, from end to end
    #[arg(long, value_name = "NUMBER", default_value_t = 10, value_parser = count)]
    best: usize,

    #[command(flatten)]
    how: StudyArgs,
}

/// Runs the command.
pub fn run(args: &OptimizeArgs) -> Result<Status, Failure> {
    let Some(file) = &args.study else {
        print(&optimize::schema())?;
        return Ok(Status::Done);
    };
    let mut of = optimize::load(file)?;
    if let Some(model) = args.model {
        of.simulate_with(model.into());
    }
    let (Some(out), false) = (&args.out, args.how.list) else {
        show(&optimisation_list(&of))?;
        return Ok(Status::Done);
    };
    table::format(out).map_err(Failure::bad_input)?;
    let runs = runs_beside(out);
    let targets = [
        ("--out", Some(out.as_path()), Kind::File(Form::Designs)),
        ("the runs of --out", Some(&runs), Kind::Results),
        ("--plot", args.plot.as_deref(), Kind::File(Form::Picture)),
        ("--html", args.html.as_deref(), Kind::File(Form::Page)),
    ];
    let folder = reserve(&[("the study", &sources(file))], &targets, ("--scenes", args.scenes.as_deref(), &FILES))?;
    search(args, &of, out, folder)
}

/// Files of `--scenes`.
const FILES: [&str; 2] = ["start.toml", "design-*.toml"];

/// Makes the runs that are not there yet, and says what was found.
fn search(args: &OptimizeArgs, of: &Optimisation, out: &Path, folder: Option<Folder>) -> Result<Status, Failure> {
    let place = runs_beside(out);
    let (store, mut runs_table) = match open(of.study(), &place, u64::MAX, args.how.restart)? {
        Stored::Complete(table) => {
            note(&format!(
                "{} has all runs of this search already: nothing was run. --restart runs them again.",
                place.display()
            ));
            (None, table)
        }
        Stored::Begun(store) => {
            let rows = Table { rows: store.rows().to_vec(), ..Table::default() };
            (Some(store), rows)
        }
    };
    let known = if store.is_some() { std::mem::take(&mut runs_table.rows) } else { runs_table.rows.clone() };
    let interrupt = Interrupt::listen()?;
    let mut heard = Heard::new(of, store, known.len() as u64);
    let run = optimize::run(of, args.threads, known, &|| interrupt.signal().is_none(), &mut heard);
    heard.count.clear();
    let Optimised { found, runs, simulations, threads, wall_s } = run.map_err(|error| {
        Failure::bad_input(format!(
            "{}: {error}; its results are not those of this search, --restart begins anew and gives them up",
            place.display()
        ))
    })?;
    let goes_on = match &heard.store {
        Some(store) => {
            format!("{} runs are in {}: the same command goes on from there", heard.done, store.partial().display())
        }
        None => String::new(),
    };
    if let Some(error) = heard.broken {
        return Err(Failure::incomplete(format!("cannot write the runs: {error}; {goes_on}")));
    }
    let Some(found) = found else {
        let signal = interrupt.signal().unwrap_or("a signal");
        return Err(Failure::incomplete(format!("the search was interrupted by {signal}; {goes_on}")));
    };
    if let Some(store) = heard.store {
        runs_table = store.finish(of.study())?;
    }
    let reasons = summary(&runs_table).map_err(Failure::incomplete)?.reasons;
    table::write(out, &optimize::table(of, &found)).map_err(Failure::incomplete)?;
    let now = SweepWork::new(runs, simulations, threads, wall_s);
    let mut report = OptimisationReport::new((of, &found), reasons, now, args.best);
    report.scenes = args.scenes.is_some();
    write_others(args, of, &found, &report, folder)?;
    answer(&report, args.how.json)?;
    Ok(if found.front.is_empty() { Status::CheckFailed } else { Status::Done })
}

/// Picture, page and scenes.
fn write_others(
    args: &OptimizeArgs,
    of: &Optimisation,
    found: &Found,
    report: &OptimisationReport<'_>,
    folder: Option<Folder>,
) -> Result<(), Failure> {
    let scenes: Vec<(u64, String)> = found
        .front
        .iter()
        .map(|&index| &found.designs[index])
        .map(|design| (design.number, scene(of, found, design)))
        .collect();
    if let Some(path) = &args.plot {
        save(path, &plot::optimisation(of, found, false))?;
    }
    if let Some(path) = &args.html {
        save(path, &report_page(&report.paper(plot::optimisation(of, found, true), &scenes)))?;
    }
    if let Some(folder) = folder {
        let start = ("start.toml".to_string(), scene(of, found, found.start()));
        let names = found.front.iter().map(|&index| scene_file(found, &found.designs[index]));
        let files = names.zip(scenes.into_iter().map(|(_, text)| text));
        let (names, texts): (Vec<String>, Vec<String>) = std::iter::once(start).chain(files).unzip();
        folder.write(&names.iter().map(String::as_str).collect::<Vec<_>>(), &texts)?;
    }
    Ok(())
}

/// A design as a scene file, with what it came to in its head.
fn scene(of: &Optimisation, found: &Found, design: &Design) -> String {
    let is_compromise = found.compromise().is_some_and(|index| found.designs[index].number == design.number);
    let rank = if is_compromise { ", the compromise" } else { "" };
    let mut text = format!("# Design {} of the search \"{}\"{rank}", design.number, of.name().escape_debug());
    let first = if of.conditions() > 1 { ", under the first of its conditions" } else { "" };
    let _ = write!(text, "{first}:");
    for (objective, value) in of.objectives.iter().zip(&design.judged.values) {
        let value = value.map_or("none".to_string(), |value| format!("{value:?}"));
        let _ = write!(text, " {} {value},", objective.figure.name.escape_debug());
    }
    let _ = writeln!(text, " {}.", if design.is_feasible() { "meets all constraints" } else { "misses a constraint" });
    text + &of.scene_text(&design.points)
}

/// Where the runs are: `front.runs.csv` beside `front.csv`.
fn runs_beside(out: &Path) -> PathBuf {
    let ending = out.extension().unwrap_or_default().to_string_lossy().into_owned();
    out.with_extension(format!("runs.{ending}"))
}

fn count(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|count| *count > 0).ok_or("expected a number from 1".to_string())
}

/// Keeps runs, and says how far the search has come.
struct Heard {
    count: Count,
    store: Option<Store>,
    broken: Option<std::io::Error>,
    total: u64,
    done: u64,
    /// Of the last generation.
    words: String,
    start: Instant,
    next: Duration,
}

impl Heard {
    /// With so many runs there before.
    fn new(of: &Optimisation, store: Option<Store>, done: u64) -> Self {
        let (mut count, total) = (Count::new(), of.most_runs());
        count.show(done as usize, total as usize, "");
        let (words, start, next) = (String::new(), Instant::now(), Duration::ZERO);
        Heard { count, store, broken: None, total, done, words, start, next }
    }
}

impl Listener for Heard {
    fn row(&mut self, row: &Row) -> bool {
        // Nothing may follow what could not be written.
        if let (Some(store), None) = (&mut self.store, &self.broken) {
            self.broken = store.add(row.cells.clone()).err();
        }
        self.done += 1;
        let elapsed = self.start.elapsed();
        // Texts are made only as often as somebody can read them.
        if elapsed >= self.next {
            self.next = elapsed + Duration::from_millis(100);
            self.count.show(self.done as usize, self.total as usize, &self.words);
        }
        self.broken.is_none()
    }

    fn generation(&mut self, designs: &[Design]) {
        let feasible = designs.iter().filter(|design| design.is_feasible()).count();
        let generation = designs.last().map_or(0, |design| design.generation);
        self.words = format!("generation {generation}, {feasible} of {} designs meet all", designs.len());
    }
}
