//! `phalanx reproduce`: recomputes the figures of the thesis, with reasons for differences.

use std::fs;
use std::path::Path;
use std::time::Instant;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::{print_note, print_result};
use super::parsers::parse_threads_or_all;
use super::study::{OutputArgs, compute};
use super::targets::{reserve, save, write_failure};
use super::{Failure, Status};
use crate::format::{ToReport, format_duration};
use crate::page::report_page;
use crate::report::reproduce::{Reproduced, ReproductionReport, reproduce};
use crate::report::sweep::ranking_table;
use crate::table;

/// Reproduce the thesis: sizing, statics, volumes, 384 simulations, selection, design 95 and its CAD model.
///
/// Every number printed in the thesis is recomputed and compared with the thesis and with the value expected from the
/// corrected equations; the reason for each difference is given. Simulations whose class depends on the tolerances
/// are listed.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx reproduce\n  phalanx reproduce --out report\n  phalanx reproduce --quick --json > \
                  report.json\n\n--out writes report.md with figures/, report.html (self-contained), report.json, results.csv and ranking.csv. Exit status: 0 every value is as expected; 1 a value is outside its bounds; 3 something \
                  could not be computed or written."
)]
pub(crate) struct ReproduceArgs {
    #[command(flatten)]
    output: OutputArgs,

    /// Compute volumes of 10³ instead of 20³ points; they are shown but not checked
    #[arg(long)]
    quick: bool,

    /// Number of threads [default: all cores]
    #[arg(long, value_name = "NUMBER", default_value_t = 0, hide_default_value = true, value_parser = parse_threads_or_all)]
    threads: usize,
}

/// Runs `phalanx reproduce`.
pub fn run(args: &ReproduceArgs) -> Result<Status, Failure> {
    let directory = reserve(&[], &[], ("--out", args.output.out.as_deref(), &FILES))?;
    let start = Instant::now();
    let interrupt = Interrupt::listen()?;
    let reproduced =
        compute("the reproduction", &args.output, &interrupt, |monitor| reproduce(args.quick, args.threads, monitor))?;
    let wall_s = start.elapsed().as_secs_f64();
    let report = ReproductionReport::new(&reproduced);
    directory.write_with(|out| write(out, &reproduced, &report))?;
    print_result(&report, args.output.json)?;
    if !args.output.json {
        print_note(&format!("computed in {}", format_duration(wall_s)));
    }
    Ok(if reproduced.reproduction.outside > 0 { Status::CheckFailed } else { Status::Done })
}

/// Files in the output directory, without the pictures in figures/.
const FILES: [&str; 6] = ["report.md", "report.html", "report.json", "results.csv", "ranking.csv", "figures/*.svg"];

/// Writes the files of `--out`; the report is written last.
fn write(out: &Path, found: &Reproduced, report: &ReproductionReport<'_>) -> Result<(), Failure> {
    let paper = found.reproduction.paper();
    let figures = out.join("figures");
    fs::create_dir_all(&figures).map_err(|error| write_failure(&figures, error))?;
    for figure in paper.figures() {
        save(&figures.join(&figure.file), &figure.svg)?;
    }
    let ranking = ranking_table(&found.results, &found.selection);
    for (file, table) in [("results.csv", &found.results), ("ranking.csv", &ranking)] {
        table::write(&out.join(file), table).map_err(Failure::incomplete)?;
    }
    save(&out.join("report.json"), &report.json())?;
    save(&out.join("report.html"), &report_page(&paper))?;
    save(&out.join("report.md"), &paper.markdown())
}
