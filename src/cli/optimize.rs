//! `phalanx optimize`: searches ranges of fields for the best designs.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;

use super::choice_args::ModelArg;
use super::interrupt::Interrupt;
use super::output::{print, print_note, print_report, print_result};
use super::output_directory::OutputDirectory;
use super::ownership::FileKind;
use super::progress::RunCounter;
use super::save::save;
use super::study_args::StudyArgs;
use super::targets::{TargetKind, reserve};
use super::value_lists::parse_threads_or_all;
use super::{Failure, Status};
use crate::page::report_page;
use crate::plot;
use crate::report::optimize::{OptimisationReport, optimisation_list, scene_file};
use crate::report::sweep::SweepWork;
use crate::study::optimize::{self, Design, Listener, Optimisation, OptimisationResult, OptimisationRun};
use crate::study::store::{OpenedResults, Store, open};
use crate::study::sweep::{Row, source_files, summary};
use crate::table::{self, Table};

/// Search for the best designs by varying fields within bounds; objectives and constraints are results of simulations.
///
/// The study file (TOML) names a base scene, the variable fields with their bounds, the conditions under which every
/// design runs (friction, offsets, tolerances), the objectives to minimise or maximise, and the constraints;
/// scenes/studies/optimize-95.toml is an example to copy. NSGA-II finds the Pareto front of several objectives, CMA-ES
/// the best design for one objective. The search starts at the base scene and compares all designs with it.
///
/// Each design is a row of OUT, with its generation and whether it is on the front. Its runs are rows of a second table
/// (OUT with `.runs` before its extension), with the columns of `phalanx sweep`. Each run is written as soon as it
/// ends. Repeating an interrupted command resumes the search and gives the same bytes. The result depends on the seed,
/// but not on the number of threads.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx optimize scenes/studies/optimize-95.toml --out front.csv --html front.html\n  phalanx optimize \
                  my-study.toml --out front.parquet --scenes front --json\n  phalanx optimize my-study.toml --list\n  phalanx optimize \
                  --schema > optimisation.schema.json\n\nExit status: 0 done; 1 no design meets all constraints; 2 bad input; 3 interrupted \
                  (the same command resumes), or files could not be written."
)]
pub struct OptimizeArgs {
    /// Study file (TOML); `phalanx optimize --schema` describes it
    #[arg(required_unless_present = "schema")]
    study: Option<PathBuf>,

    /// Write all designs to this file, as CSV or Parquet according to its extension
    #[arg(long, value_name = "FILE", required_unless_present_any = ["schema", "list"])]
    out: Option<PathBuf>,

    /// Simulation model, instead of the one in the study
    #[arg(long, value_enum)]
    model: Option<ModelArg>,

    /// Number of threads; 0 uses all cores
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads_or_all)]
    threads: usize,

    /// Write a plot of the designs and the front
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,

    /// Write a page with the plot and the tables; a click on a point of the front shows its scene
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,

    /// Write each design of the front as a scene to this directory, which is created if needed: design-N.toml with
    /// leading zeros, and start.toml; the table names the file of each design that it compares, such as the compromise
    #[arg(long, value_name = "DIR")]
    scenes: Option<PathBuf>,

    /// Number of designs to print, spread over the whole front
    #[arg(long, value_name = "NUMBER", default_value_t = 10, value_parser = parse_count)]
    best: usize,

    #[command(flatten)]
    study_args: StudyArgs,
}

/// Runs `phalanx optimize`.
pub fn run(args: &OptimizeArgs) -> Result<Status, Failure> {
    let Some(file) = &args.study else {
        print(&optimize::schema())?;
        return Ok(Status::Done);
    };
    let mut optimisation = optimize::load(file)?;
    if let Some(model) = args.model {
        optimisation.set_model(model.into());
    }
    let (Some(out), false) = (&args.out, args.study_args.list) else {
        print_report(&optimisation_list(&optimisation))?;
        return Ok(Status::Done);
    };
    table::format(out).map_err(Failure::bad_input)?;
    let runs = runs_path(out);
    let targets = [
        ("--out", Some(out.as_path()), TargetKind::File(FileKind::Designs)),
        ("the runs of --out", Some(&runs), TargetKind::Results),
        ("--plot", args.plot.as_deref(), TargetKind::File(FileKind::Picture)),
        ("--html", args.html.as_deref(), TargetKind::File(FileKind::Page)),
    ];
    let directory =
        reserve(&[("the study", &source_files(file))], &targets, ("--scenes", args.scenes.as_deref(), &FILES))?;
    run_search(args, &optimisation, out, directory)
}

/// Files of `--scenes`.
const FILES: [&str; 2] = ["start.toml", "design-*.toml"];

/// Performs the missing runs and reports the result.
fn run_search(
    args: &OptimizeArgs,
    optimisation: &Optimisation,
    out: &Path,
    directory: Option<OutputDirectory>,
) -> Result<Status, Failure> {
    let runs_path = runs_path(out);
    let (store, mut runs_table) = match open(optimisation.study(), &runs_path, u64::MAX, args.study_args.restart)? {
        OpenedResults::Complete(table) => {
            print_note(&format!(
                "{} already contains all runs of this search; nothing was run. --restart runs them again.",
                runs_path.display()
            ));
            (None, table)
        }
        OpenedResults::Incomplete(store) => {
            let rows = Table { rows: store.rows().to_vec(), ..Table::default() };
            (Some(store), rows)
        }
    };
    let known_rows = if store.is_some() { std::mem::take(&mut runs_table.rows) } else { runs_table.rows.clone() };
    let interrupt = Interrupt::listen()?;
    let mut observer = ProgressObserver::new(optimisation, store, known_rows.len() as u64);
    let run = optimize::run(optimisation, args.threads, known_rows, &|| interrupt.signal().is_none(), &mut observer);
    observer.counter.clear();
    let OptimisationRun { result, runs, simulations, threads, wall_s } = run.map_err(|error| {
        Failure::bad_input(format!(
            "{}: {error}; these are results of another search; --restart discards them",
            runs_path.display()
        ))
    })?;
    let resume_hint = match &observer.store {
        Some(store) => {
            format!(
                "{} runs are in {}; the same command resumes from there",
                observer.done,
                store.partial_path().display()
            )
        }
        None => String::new(),
    };
    if let Some(error) = observer.write_error {
        return Err(Failure::incomplete(format!("cannot write the runs: {error}; {resume_hint}")));
    }
    let Some(result) = result else {
        let signal = interrupt.signal().unwrap_or("a signal");
        return Err(Failure::incomplete(format!("the search was interrupted by {signal}; {resume_hint}")));
    };
    if let Some(store) = observer.store {
        runs_table = store.finish(optimisation.study())?;
    }
    let reasons = summary(&runs_table).map_err(Failure::incomplete)?.reasons;
    table::write(out, &optimize::table(optimisation, &result)).map_err(Failure::incomplete)?;
    let work = SweepWork::new(runs, simulations, threads, wall_s);
    let mut report = OptimisationReport::new((optimisation, &result), reasons, work, args.best);
    report.has_scenes = args.scenes.is_some();
    write_outputs(args, optimisation, &result, &report, directory)?;
    print_result(&report, args.study_args.json)?;
    Ok(if result.front.is_empty() { Status::CheckFailed } else { Status::Done })
}

/// Writes the plot, the page and the scenes.
fn write_outputs(
    args: &OptimizeArgs,
    optimisation: &Optimisation,
    result: &OptimisationResult,
    report: &OptimisationReport<'_>,
    directory: Option<OutputDirectory>,
) -> Result<(), Failure> {
    let scenes: Vec<(u64, String)> = result
        .front
        .iter()
        .map(|&index| &result.designs[index])
        .map(|design| (design.number, render_scene(optimisation, result, design)))
        .collect();
    if let Some(path) = &args.plot {
        save(path, &plot::optimisation(optimisation, result, false))?;
    }
    if let Some(path) = &args.html {
        save(path, &report_page(&report.paper(plot::optimisation(optimisation, result, true), &scenes)))?;
    }
    if let Some(directory) = directory {
        let start = ("start.toml".to_string(), render_scene(optimisation, result, result.start()));
        let names = result.front.iter().map(|&index| scene_file(result, &result.designs[index]));
        let files = names.zip(scenes.into_iter().map(|(_, text)| text));
        let (names, texts): (Vec<String>, Vec<String>) = std::iter::once(start).chain(files).unzip();
        directory.write(&names.iter().map(String::as_str).collect::<Vec<_>>(), &texts)?;
    }
    Ok(())
}

/// Returns a design as a scene file; the leading comment states its objectives.
fn render_scene(optimisation: &Optimisation, result: &OptimisationResult, design: &Design) -> String {
    let is_compromise = result.compromise().is_some_and(|index| result.designs[index].number == design.number);
    let rank = if is_compromise { ", the compromise" } else { "" };
    let mut text = format!("# Design {} of the search \"{}\"{rank}", design.number, optimisation.name().escape_debug());
    let first = if optimisation.conditions() > 1 { ", under the first of its conditions" } else { "" };
    let _ = write!(text, "{first}:");
    for (objective, value) in optimisation.objectives.iter().zip(&design.evaluation.values) {
        let value = value.map_or("none".to_string(), |value| format!("{value:?}"));
        let _ = write!(text, " {} {value},", objective.figure.name.escape_debug());
    }
    let _ = writeln!(text, " {}.", if design.is_feasible() { "meets all constraints" } else { "misses a constraint" });
    text + &optimisation.scene_text(&design.points)
}

/// Path of the table of runs: `front.runs.csv` for `front.csv`.
fn runs_path(out: &Path) -> PathBuf {
    let extension = out.extension().unwrap_or_default().to_string_lossy().into_owned();
    out.with_extension(format!("runs.{extension}"))
}

fn parse_count(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|count| *count > 0).ok_or("expected a number of at least 1".to_string())
}

/// Stores runs and shows the progress of the search.
struct ProgressObserver {
    counter: RunCounter,
    store: Option<Store>,
    write_error: Option<std::io::Error>,
    total: u64,
    done: u64,
    /// Progress message about the last generation.
    generation_summary: String,
    start: Instant,
    next_update: Duration,
}

impl ProgressObserver {
    /// Creates an observer; `done` runs were stored by earlier commands.
    fn new(optimisation: &Optimisation, store: Option<Store>, done: u64) -> Self {
        let (mut counter, total) = (RunCounter::new(), optimisation.max_runs());
        counter.update(done as usize, total as usize, "");
        let (generation_summary, start, next_update) = (String::new(), Instant::now(), Duration::ZERO);
        ProgressObserver { counter, store, write_error: None, total, done, generation_summary, start, next_update }
    }
}

impl Listener for ProgressObserver {
    fn row(&mut self, row: &Row) -> bool {
        // Rows must stay in order, so nothing is written after a failed write.
        if let (Some(store), None) = (&mut self.store, &self.write_error) {
            self.write_error = store.append(row.cells.clone()).err();
        }
        self.done += 1;
        let elapsed = self.start.elapsed();
        // Updates more frequent than this cannot be read.
        if elapsed >= self.next_update {
            self.next_update = elapsed + Duration::from_millis(100);
            self.counter.update(self.done as usize, self.total as usize, &self.generation_summary);
        }
        self.write_error.is_none()
    }

    fn generation(&mut self, designs: &[Design]) {
        let feasible = designs.iter().filter(|design| design.is_feasible()).count();
        let generation = designs.last().map_or(0, |design| design.generation);
        self.generation_summary =
            format!("generation {generation}, {feasible} of {} designs meet all constraints", designs.len());
    }
}
