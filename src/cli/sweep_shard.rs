//! `phalanx sweep --shard`: runs one part of a study, so that several machines can share a sweep.

use std::path::Path;

use super::interrupt::Interrupt;
use super::output::{print_note, print_result};
use super::sweep_progress::SweepProgress;
use super::{Failure, Status};
use crate::report::sweep::{SweepReport, SweepWork};
use crate::study::parts::{PartError, PartOptions, write_part};
use crate::study::sweep::{Study, shard};

/// Part of a study to run: part `number` of `count`.
#[derive(Clone, Copy, Debug)]
pub struct ShardArg {
    number: u64,
    count: u64,
}

/// Output file and options of a part.
pub struct ShardOutput<'a> {
    pub out: &'a Path,
    pub threads: usize,
    pub restart: bool,
    pub json: bool,
}

/// Parses `3/7`. Accepts digits only, without leading zeros, so that each part has exactly one name.
pub fn parse_shard(text: &str) -> Result<ShardArg, String> {
    let parse_digits = |digits: &str| digits.parse().ok().filter(|number: &u64| number.to_string() == digits);
    let numbers = text.split_once('/').and_then(|(k, n)| Some((parse_digits(k)?, parse_digits(n)?)));
    match numbers {
        Some((number, count)) if 0 < number && number <= count => Ok(ShardArg { number, count }),
        _ => Err("expected K/N with K from 1 to N, both as digits without signs, spaces or leading zeros, such as 1/8 for the \
                  first of eight shards"
            .to_string()),
    }
}

impl From<PartError> for Failure {
    fn from(error: PartError) -> Self {
        match error {
            PartError::Write { .. } | PartError::Stopped { .. } => Failure::incomplete(error),
            error => Failure::bad_input(error),
        }
    }
}

/// Runs `phalanx sweep --shard`.
pub fn run(study: &Study, shard_arg: ShardArg, output: &ShardOutput<'_>) -> Result<Status, Failure> {
    let shard = shard(study, shard_arg.number, shard_arg.count).map_err(Failure::bad_input)?;
    let interrupt = Interrupt::listen()?;
    let mut progress = SweepProgress::new(shard.runs(), 0);
    let options = PartOptions { threads: output.threads, restart: output.restart };
    let part =
        write_part(study, shard, output.out, options, &|| interrupt.signal().is_none(), |row| progress.record(row));
    progress.counter.clear();
    let name = format!("shard {}/{}", shard_arg.number, shard_arg.count);
    let part = part.map_err(|error| match (error, interrupt.signal()) {
        (PartError::Stopped { done, total }, Some(signal)) => Failure::incomplete(format!(
            "{name} was interrupted by {signal} after {done} of its {total} runs; shards are written only when complete, so no file was \
             written; run the same command again"
        )),
        (error, _) => error.into(),
    })?;
    let work = match &part.stats {
        Some(stats) => SweepWork::new(stats.runs, progress.simulations, stats.threads, stats.wall_s),
        None => {
            let out = output.out.display();
            print_note(&format!(
                "{out} already contains {name} of this study; nothing was run. --restart runs it again."
            ));
            SweepWork::new(0, 0, 0, 0.0)
        }
    };
    let report = SweepReport { shard: Some(shard), ..SweepReport::new(study, output.out, part.summary, work) };
    print_result(&report, output.json)?;
    Ok(Status::Done)
}
