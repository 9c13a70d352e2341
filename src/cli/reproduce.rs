//! `phalanx reproduce`: the thesis's figures again, with reasons where ours differ.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::interrupt::{self, Interrupt};
use super::output::{answer, note};
use super::progress::Count;
use super::saved::{broken, save};
use super::targets::reserve;
use super::volume_args::threads_or_all;
use super::{Failure, Status};
use crate::page::report_page;
use crate::report::reproduce::ReproductionReport;
use crate::report::select::ranking_table;
use crate::study::reproduce::reproduce;
use crate::table;
use crate::wording::{Reported, duration};

/// Reproduce the thesis: sizing, statics, volumes, 384 simulations, selection, design 95 and its CAD model.
///
/// Every figure that the thesis prints is computed again and set beside it, beside what the corrected equations are expected
/// to give, and beside the reason for the difference. Simulations whose class changes with the tolerances are found and
/// named.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx reproduce\n  phalanx reproduce --out report\n  phalanx reproduce --quick --json > \
                  report.json\n\nExit status: 0 every figure is as expected; 1 one is outside of its bounds; 3 something could \
                  not be computed or written."
)]
pub struct ReproduceArgs {
    /// Write report.md with figures/, report.html (self-contained), report.json, results.csv and ranking.csv there; the
    /// directory is made if need be
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Volumes of 10³ points instead of 20³ (they are shown, but not judged)
    #[arg(long)]
    quick: bool,

    /// Threads; as many as there are cores if it is not given
    #[arg(long, value_name = "NUMBER", default_value_t = 0, hide_default_value = true, value_parser = threads_or_all)]
    threads: usize,

    /// Print one JSON document with SI values instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &ReproduceArgs) -> Result<Status, Failure> {
    let folder = reserve(&[], &[], ("--out", args.out.as_deref(), &FILES))?;
    let start = Instant::now();
    let mut count = Count::new();
    let interrupt = Interrupt::listen()?;
    let mut reached = (0, 0);
    let mut tell = |done, total, next: &str| {
        reached = (done, total);
        count.show(done, total, next);
    };
    let result = reproduce(args.quick, args.threads, &mut tell, &|| interrupt.signal().is_none());
    count.clear();
    let found = result.map_err(|error| match interrupt.signal() {
        Some(signal) => interrupt::broken_off("the reproduction", signal, reached, args.out.is_some()),
        None => Failure::incomplete(error),
    })?;
    let wall_s = start.elapsed().as_secs_f64();
    let report = ReproductionReport::new(&found);
    if let Some(folder) = folder {
        folder.fill(|out| write(out, &report))?;
    }
    answer(&report, args.json)?;
    if !args.json {
        note(&format!("computed in {}", duration(wall_s)));
    }
    Ok(if report.outside > 0 { Status::CheckFailed } else { Status::Done })
}

/// Everything that is in the directory in the end, and pictures in figures/.
const FILES: [&str; 5] = ["report.md", "report.html", "report.json", "results.csv", "ranking.csv"];

/// The files of `--out`; the report comes last.
fn write(out: &Path, report: &ReproductionReport<'_>) -> Result<(), Failure> {
    let paper = report.paper();
    let figures = out.join("figures");
    fs::create_dir_all(&figures).map_err(|error| broken(&figures, error))?;
    for figure in paper.figures() {
        save(&figures.join(&figure.file), &figure.svg)?;
    }
    let found = report.found;
    for (file, of) in
        [("results.csv", &found.results), ("ranking.csv", &ranking_table(&found.results, &found.selection))]
    {
        table::write(&out.join(file), of).map_err(Failure::incomplete)?;
    }
    save(&out.join("report.json"), &report.json())?;
    save(&out.join("report.html"), &report_page(&paper))?;
    save(&out.join("report.md"), &paper.markdown())
}
