//! `phalanx reproduce`: recomputes the figures of the thesis, with reasons for differences.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::interrupt::{self, Interrupt};
use super::output::{print_note, print_result};
use super::progress::RunCounter;
use super::targets::{reserve, save, write_failure};
use super::volume_args::parse_threads_or_all;
use super::{Failure, Status};
use crate::format::{ToReport, format_duration};
use crate::page::report_page;
use crate::report::reproduce::ReproductionReport;
use crate::report::select::ranking_table;
use crate::study::reproduce::reproduce;
use crate::table;

/// Reproduce the thesis: sizing, statics, volumes, 384 simulations, selection, design 95 and its CAD model.
///
/// Every number printed in the thesis is recomputed and compared with the thesis and with the value expected from the
/// corrected equations; the reason for each difference is given. Simulations whose class depends on the tolerances
/// are listed.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx reproduce\n  phalanx reproduce --out report\n  phalanx reproduce --quick --json > \
                  report.json\n\nExit status: 0 every value is as expected; 1 a value is outside its bounds; 3 something \
                  could not be computed or written."
)]
pub struct ReproduceArgs {
    /// Write report.md with figures/, report.html (self-contained), report.json, results.csv and ranking.csv to this
    /// directory, which is created if needed
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Compute volumes of 10³ instead of 20³ points; they are shown but not checked
    #[arg(long)]
    quick: bool,

    /// Number of threads [default: all cores]
    #[arg(long, value_name = "NUMBER", default_value_t = 0, hide_default_value = true, value_parser = parse_threads_or_all)]
    threads: usize,

    /// Print one JSON document with SI values instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs `phalanx reproduce`.
pub fn run(args: &ReproduceArgs) -> Result<Status, Failure> {
    let directory = reserve(&[], &[], ("--out", args.out.as_deref(), &FILES))?;
    let start = Instant::now();
    let mut counter = RunCounter::new();
    let interrupt = Interrupt::listen()?;
    let mut done_and_total = (0, 0);
    let mut report_progress = |done, total, next: &str| {
        done_and_total = (done, total);
        counter.update(done, total, next);
    };
    let result = reproduce(args.quick, args.threads, &mut report_progress, &|| interrupt.signal().is_none());
    counter.clear();
    let reproduction = result.map_err(|error| match interrupt.signal() {
        Some(signal) => interrupt::interrupted_failure("the reproduction", signal, done_and_total, args.out.is_some()),
        None => Failure::incomplete(error),
    })?;
    let wall_s = start.elapsed().as_secs_f64();
    let report = ReproductionReport::new(&reproduction);
    if let Some(directory) = directory {
        directory.write_with(|out| write(out, &report))?;
    }
    print_result(&report, args.json)?;
    if !args.json {
        print_note(&format!("computed in {}", format_duration(wall_s)));
    }
    Ok(if report.outside > 0 { Status::CheckFailed } else { Status::Done })
}

/// Files in the output directory, without the pictures in figures/.
const FILES: [&str; 6] = ["report.md", "report.html", "report.json", "results.csv", "ranking.csv", "figures/*.svg"];

/// Writes the files of `--out`; the report is written last.
fn write(out: &Path, report: &ReproductionReport<'_>) -> Result<(), Failure> {
    let paper = report.paper();
    let figures = out.join("figures");
    fs::create_dir_all(&figures).map_err(|error| write_failure(&figures, error))?;
    for figure in paper.figures() {
        save(&figures.join(&figure.file), &figure.svg)?;
    }
    let reproduction = report.reproduction;
    for (file, of) in [
        ("results.csv", &reproduction.results),
        ("ranking.csv", &ranking_table(&reproduction.results, &reproduction.selection)),
    ] {
        table::write(&out.join(file), of).map_err(Failure::incomplete)?;
    }
    save(&out.join("report.json"), &report.json())?;
    save(&out.join("report.html"), &report_page(&paper))?;
    save(&out.join("report.md"), &paper.markdown())
}
