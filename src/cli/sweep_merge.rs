//! `phalanx sweep merge`: the parts of a study to its results.

use std::path::{Path, PathBuf};

use clap::Args;

use super::interrupt::Interrupt;
use super::output::answer;
use super::progress::Count;
use super::targets::{Kind, NONE, reserve};
use super::words::ModelArg;
use super::{Failure, Status};
use crate::report::sweep::{SweepReport, SweepWork};
use crate::study::parts::{Gap, PartError, merge};
use crate::study::sweep;

/// Of many commands as many are shown.
const SHOWN: usize = 10;

/// Join the parts of a study (`phalanx sweep --shard`) to the results of the whole.
///
/// OUT and OUT.study.json get the very bytes that the sweep in one piece writes. Parts are given in any order, and may be of
/// different counts, as long as every run is in one of them; what is missing, there twice, damaged or of something else is
/// named, and nothing is written then. Memory does not grow with the study.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx sweep merge scenes/studies/thesis.toml part-*.parquet --out thesis.csv\n  phalanx sweep \
                  merge scenes/studies/thesis.toml parts/ --out thesis.parquet --json\n\nExit status: 0 all runs are in \
                  the table; 2 bad input, or a part is missing; 3 interrupted, or the table could not be written."
)]
pub struct MergeArgs {
    /// Study file (TOML) that the parts are of
    study: PathBuf,

    /// Files that `phalanx sweep STUDY --shard K/N` wrote, or directories of them
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,

    /// Results, as CSV or Parquet by the name
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// The model that the parts were made with, if not the study's
    #[arg(long, value_enum)]
    model: Option<ModelArg>,

    /// The parts were made with --check
    #[arg(long)]
    check: bool,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &MergeArgs) -> Result<Status, Failure> {
    let mut study = sweep::load(&args.study)?;
    if let Some(model) = args.model {
        study.model = model.into();
    }
    study.checked = args.check;
    let reads = [("the study", &sweep::sources(&args.study)[..]), ("a part", &args.parts)];
    reserve(&reads, &[("--out", Some(&args.out), Kind::Results)], NONE)?;
    let interrupt = Interrupt::listen()?;
    let mut count = Count::new();
    let mut tell = |rows: u64| count.show(rows as usize, study.runs() as usize, "rows joined");
    let merged = merge(&study, &args.parts, &args.out, &|| interrupt.signal().is_none(), &mut tell);
    count.clear();
    let merged = merged.map_err(|error| match (error, interrupt.signal()) {
        (PartError::Missing { gaps, runs }, _) => {
            let commands = commands(args, &gaps);
            Failure::bad_input(format!("{}\n{commands}", PartError::Missing { gaps, runs }))
        }
        (PartError::Stopped { done, of }, Some(signal)) => Failure::incomplete(format!(
            "the merge was interrupted by {signal} after {done} of {of} runs: {} is as it was; the same command joins the parts",
            args.out.display()
        )),
        (error, _) => error.into(),
    })?;
    let report = SweepReport {
        parts: Some(merged.parts),
        ..SweepReport::new(&study, &args.out, merged.found, SweepWork::new(0, 0, 0, 0.0))
    };
    answer(&report, args.json)?;
    Ok(Status::Done)
}

/// Commands that make what is missing, each to a file beside the first part.
fn commands(args: &MergeArgs, gaps: &[Gap]) -> String {
    let beside = args.parts.first().map_or(Path::new(""), |part| match part.is_dir() {
        true => part,
        false => part.parent().unwrap_or(Path::new("")),
    });
    let model =
        args.model.map_or(String::new(), |model| format!(" --model {}", crate::trace::Model::from(model).name()));
    let check = if args.check { " --check" } else { "" };
    let all: u128 = gaps.iter().map(|gap| u128::from(gap.to - gap.from) + 1).sum();
    let missing = gaps.iter().flat_map(|gap| (gap.from..=gap.to).map(move |number| (number, gap.of)));
    let line = |(number, of): (u64, u64)| {
        let part = beside.join(format!("part-{number}-of-{of}.parquet"));
        format!("  phalanx sweep {}{model}{check} --shard {number}/{of} --out {}", args.study.display(), part.display())
    };
    let lines: Vec<String> = missing.take(SHOWN).map(line).collect();
    let more = all.saturating_sub(lines.len() as u128);
    let more = if more > 0 { format!("\n  and {more} more like these") } else { String::new() };
    format!("these make them:\n{}{more}", lines.join("\n"))
}
