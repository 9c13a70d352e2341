//! `phalanx run`: one simulation, its summary, its log.

use crate::scene::Scene;
use std::path::{Path, PathBuf};

use clap::Args;

use super::interrupt::Interrupt;
use super::live::{Live, LiveArgs};
use super::output::answer;
use super::overrides::Overrides;
use super::own::Form;
use super::run_page::PageArgs;
use super::samples::{self, tabulated};
use super::set::{SetArgs, files};
use super::simulate::{Checking, Limits, simulate};
use super::targets::{Kind, NONE, reserve};
use super::words::ModelArg;
use super::{Failure, Status, run_page, watch};
use crate::log::{self, FileWriter, LogError, LogFile, RunInfo};
use crate::page::Reel;
use crate::report::document;
use crate::trace::columns::columns;
use crate::trace::{Layout, Model, SinkError};
use crate::wording::{Reported, duration};

/// Simulate a scene and print a summary: final state, contacts, energies, dynamic criteria or restitution.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx run scenes/experiment-95.toml\n  phalanx run scenes/experiment-95.toml --open\n  phalanx run scenes/experiment-95.toml --log run.mcap\n  \
                  phalanx run scenes/experiment-95.toml --duration \"30 ms\" --preset reference --json > run.json\n  \
                  phalanx run scenes/experiment-95.toml --model engine --step \"1 us\"\n\nThe log \
                  opens in Foxglove, Rerun and PlotJuggler. Exit status: 0 done; 2 bad input; 3 the simulation could not be \
                  completed (the log up to there is kept)."
)]
pub struct RunArgs {
    /// Scene file (TOML); `phalanx scene schema` describes it
    pub(super) scene: PathBuf,

    #[command(flatten)]
    pub(super) set: SetArgs,

    /// Which of the two independent models simulates the scene
    #[arg(long, value_enum, default_value_t = ModelArg::Analytic)]
    pub(super) model: ModelArg,

    /// Write a log (MCAP, readable while it grows as FILE.mcap.partial); an older log of that name is replaced only
    /// when the new one is whole
    #[arg(long, value_name = "FILE.mcap")]
    pub(super) log: Option<PathBuf>,

    /// Write all samples to a file of comma-separated values, as `phalanx replay --csv` does of the log; - is standard output, in
    /// place of the summary
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    #[command(flatten)]
    pub(super) page: PageArgs,

    /// Run again whenever the scene file is saved, until Ctrl-C; the log and the page are written anew each time
    #[arg(long, conflicts_with = "json")]
    watch: bool,

    /// Print one JSON document with SI units in its keys instead of the summary
    #[arg(long)]
    pub(super) json: bool,

    /// Estimate the error by a second, independent resolution, and say whether the outcome is chaotic; without the flag this is
    /// done for runs of up to 20,000 steps
    #[arg(long, overrides_with = "no_check")]
    check: bool,

    /// Do not check the run
    #[arg(long, overrides_with = "check")]
    no_check: bool,

    #[command(flatten)]
    pub(super) overrides: Overrides,

    #[command(flatten)]
    pub(super) live: LiveArgs,
}

impl RunArgs {
    pub(super) fn model(&self) -> Model {
        self.model.into()
    }

    /// Whether the run is to be checked.
    pub(super) fn checking(&self) -> Checking {
        match (self.check, self.no_check) {
            (true, _) => Checking::Always,
            (_, true) => Checking::Never,
            _ => Checking::Cheap,
        }
    }
}

/// Runs the command.
pub fn run(args: &RunArgs) -> Result<Status, Failure> {
    match args.watch {
        true => {
            args.page.can_be_watched()?;
            watch::watch(&args.scene, |first| once(args, first))
        }
        false => once(args, true),
    }
}

/// One run; `first` of those that are to be made.
fn once(args: &RunArgs, first: bool) -> Result<Status, Failure> {
    let mut scene = args.set.load_any(&args.scene)?;
    args.overrides.apply(args.model(), &mut scene)?;
    let scene = &scene;
    let (name, duration_s) = (scene.name.as_str(), scene.duration_s);
    let csv = samples::file(args.csv.as_deref(), args.json)?;
    let targets = [
        ("--log", args.log.as_deref(), Kind::Log),
        ("--csv", csv, Kind::File(Form::Samples)),
        ("--html", args.page.html.as_deref(), Kind::File(Form::Page)),
    ];
    reserve(&[("the scene", &files(&args.scene))], &targets, NONE)?;
    let page = args.page.start(first)?;
    let mut reel = page.as_ref().map(|_| Reel::default());
    let interrupt = Interrupt::listen()?;
    let live = args.live.start(name, duration_s, &interrupt)?;
    let log = started(args, scene, live.as_ref(), &interrupt)?;
    let limits = Limits { interrupt: &interrupt, until_s: f64::INFINITY, checking: args.checking() };
    let (run, table) = match &args.csv {
        None => (simulate(args.model(), scene, log, &limits, &mut reel), Ok(true)),
        Some(path) => {
            let columns = columns(&Layout::of(&scene.system));
            let model = args.model();
            let (run, table) =
                tabulated(path, columns, &mut reel, |table| Ok(simulate(model, scene, log, &limits, table)));
            (run?, table)
        }
    };
    let mut report = run.report(args.model(), scene);
    // A page is given to others: it does not say where the files are.
    let made = page.as_ref().zip(reel).map(|(page, reel)| {
        let film = reel.film(args.model().name(), scene, report.report());
        page.write(name, &scene.description, film)
    });
    report.page = made.as_ref().and_then(|made| made.as_ref().ok().cloned());
    report.log = args.log.as_ref().map(|path| path.display().to_string());
    report.csv = csv.filter(|_| table.is_ok()).map(|path| path.display().to_string());
    let kept = run.log.and_then(|log| log.map_or(Ok(()), LogFile::keep));
    if csv.is_some() || args.csv.is_none() {
        answer(&report, args.json)?;
    }
    if let Some(live) = live {
        live.end();
    }
    let ended = match table {
        Ok(true) => ended(args, duration_s, report.error.as_ref(), kept),
        // The reader of the table has seen enough.
        Ok(false) => Ok(Status::Done),
        Err(failure) => ended(args, duration_s, report.error.as_ref(), kept).and(Err(failure)),
    };
    run_page::ended(page.as_ref(), made, ended)
}

/// The log of a run, if there is to be one or the run is watched.
fn started(
    args: &RunArgs,
    scene: &Scene,
    live: Option<&Live>,
    interrupt: &Interrupt,
) -> Result<Option<FileWriter>, Failure> {
    if args.log.is_none() && live.is_none() {
        return Ok(None);
    }
    let feed = live.map(|live| live.feed(interrupt));
    let info = info(scene, &args.scene, args.model().name());
    let log = log::create_with_feed(args.log.as_deref(), &info, feed).map_err(unstarted)?;
    if let Some(live) = live {
        live.begin();
    }
    Ok(Some(log))
}

/// How the command ends, by how the run and its log did.
fn ended(
    args: &RunArgs,
    duration_s: f64,
    error: Option<&document::Failure>,
    kept: Result<(), SinkError>,
) -> Result<Status, Failure> {
    match (error, kept) {
        (Some(error), kept) => Err(Failure::incomplete(stopped(error, duration_s) + &place_of(args, kept.is_ok()))),
        (None, Err(error)) => Err(Failure::incomplete(format!("{error}{}", place_of(args, false)))),
        (None, Ok(())) => Ok(Status::Done),
    }
}

/// What the log says about the run.
pub(super) fn info<'a>(scene: &'a Scene, path: &'a Path, model: &'a str) -> RunInfo<'a> {
    RunInfo { scene, scene_file: path.file_name().and_then(|name| name.to_str()).unwrap_or("scene.toml"), model }
}

/// A log that could not be started: the path is wrong, or the disk is full already.
pub(super) fn unstarted(error: LogError) -> Failure {
    match error {
        LogError::Start(_) => Failure::incomplete(error),
        _ => Failure::bad_input(error),
    }
}

/// How far a run came, and why not further.
fn stopped(failure: &document::Failure, duration_s: f64) -> String {
    let (at, of) = (duration(failure.time_s), duration(duration_s));
    format!("the simulation stopped at {at} of {of}: {}", failure.reason)
}

/// Where what there is of a run can be found; `finished`: whether its log is.
fn place_of(args: &RunArgs, finished: bool) -> String {
    let Some(path) = &args.log else {
        return "; with --log FILE.mcap the run up to there is kept".to_string();
    };
    let partial = log::partial_name(path);
    match finished {
        true => format!("; the log up to there is in {}", path.display()),
        false if partial.exists() => format!(
            "; the log up to there is in {} (phalanx replay reads it), and {} is as it was before",
            partial.display(),
            path.display()
        ),
        false => "; what could be written of the log has gone where it was sent".to_string(),
    }
}
