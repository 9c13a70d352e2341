//! `phalanx sweep merge`: joins the parts of a study.

use std::path::{Path, PathBuf};

use clap::Args;

use super::choice_args::ModelArg;
use super::interrupt::Interrupt;
use super::output::print_result;
use super::progress::RunCounter;
use super::targets::{NO_DIRECTORY, TargetKind, reserve};
use super::{Failure, Status};
use crate::report::sweep::{SweepReport, SweepWork};
use crate::study::parts::{Gap, PartError, merge};
use crate::study::sweep;

/// Largest number of commands shown for missing parts.
const MAX_SHOWN_COMMANDS: usize = 10;

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
pub struct MergeArgs {
    /// Study file (TOML) of the shards
    study: PathBuf,

    /// Files written by `phalanx sweep STUDY --shard K/N`, or directories of such files
    #[arg(value_name = "SHARD", required = true)]
    parts: Vec<PathBuf>,

    /// Write the results to this file, as CSV or Parquet according to its extension
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// Simulation model of the shards, if it is not the one in the study
    #[arg(long, value_enum)]
    model: Option<ModelArg>,

    /// The shards were written with --check
    #[arg(long)]
    check: bool,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs `phalanx sweep merge`.
pub fn run(args: &MergeArgs) -> Result<Status, Failure> {
    let mut study = sweep::load(&args.study)?;
    if let Some(model) = args.model {
        study.model = model.into();
    }
    study.checked = args.check;
    let inputs = [("the study", &sweep::source_files(&args.study)[..]), ("a shard", &args.parts)];
    reserve(&inputs, &[("--out", Some(&args.out), TargetKind::Results)], NO_DIRECTORY)?;
    let interrupt = Interrupt::listen()?;
    let mut counter = RunCounter::new();
    let mut report_progress = |rows: u64| counter.update(rows as usize, study.runs() as usize, "rows joined");
    let merged = merge(&study, &args.parts, &args.out, &|| interrupt.signal().is_none(), &mut report_progress);
    counter.clear();
    let merged = merged.map_err(|error| match (error, interrupt.signal()) {
        (PartError::Missing { gaps, runs }, _) => {
            let commands = missing_part_commands(args, &gaps);
            Failure::bad_input(format!("{}\n{commands}", PartError::Missing { gaps, runs }))
        }
        (PartError::Stopped { done, total }, Some(signal)) => Failure::incomplete(format!(
            "the merge was interrupted by {signal} after {done} of {total} runs; {} is unchanged; run the same command again to join the shards",
            args.out.display()
        )),
        (error, _) => error.into(),
    })?;
    let report = SweepReport {
        parts: Some(merged.parts),
        ..SweepReport::new(&study, &args.out, merged.summary, SweepWork::new(0, 0, 0, 0.0))
    };
    print_result(&report, args.json)?;
    Ok(Status::Done)
}

/// Returns the commands that write the missing parts to the directory of the first part.
fn missing_part_commands(args: &MergeArgs, gaps: &[Gap]) -> String {
    let directory = args.parts.first().map_or(Path::new(""), |part| match part.is_dir() {
        true => part,
        false => part.parent().unwrap_or(Path::new("")),
    });
    let model =
        args.model.map_or(String::new(), |model| format!(" --model {}", crate::trace::Model::from(model).name()));
    let check = if args.check { " --check" } else { "" };
    let missing_count: u128 = gaps.iter().map(|gap| u128::from(gap.last_shard - gap.first_shard) + 1).sum();
    let missing =
        gaps.iter().flat_map(|gap| (gap.first_shard..=gap.last_shard).map(move |number| (number, gap.shard_count)));
    let line = |(number, shard_count): (u64, u64)| {
        let part = directory.join(format!("part-{number}-of-{shard_count}.parquet"));
        format!(
            "  phalanx sweep {}{model}{check} --shard {number}/{shard_count} --out {}",
            args.study.display(),
            part.display()
        )
    };
    let lines: Vec<String> = missing.take(MAX_SHOWN_COMMANDS).map(line).collect();
    let remaining = missing_count.saturating_sub(lines.len() as u128);
    let remaining = if remaining > 0 { format!("\n  and {remaining} more like these") } else { String::new() };
    format!("these commands write the missing shards:\n{}{remaining}", lines.join("\n"))
}
