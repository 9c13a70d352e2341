//! `phalanx sweep --shard`: one part of a study, for a sweep on several machines.

use std::path::Path;

use super::interrupt::Interrupt;
use super::output::{answer, note};
use super::sweep_progress::SoFar;
use super::{Failure, Status};
use crate::report::sweep::{SweepReport, SweepWork};
use crate::study::parts::{PartError, Work, write_part};
use crate::study::sweep::{Study, shard};

/// Which part is wanted.
#[derive(Clone, Copy, Debug)]
pub struct ShardOf {
    number: u64,
    of: u64,
}

/// Where it goes, and how it is made.
pub struct Place<'a> {
    pub out: &'a Path,
    pub threads: usize,
    pub restart: bool,
    pub json: bool,
}

/// Reads `3/7`: digits alone, as scripts count, so that one part has one name.
pub fn shard_of(text: &str) -> Result<ShardOf, String> {
    let plain = |digits: &str| digits.parse().ok().filter(|number: &u64| number.to_string() == digits);
    let numbers = text.split_once('/').and_then(|(k, n)| Some((plain(k)?, plain(n)?)));
    match numbers {
        Some((number, of)) if 0 < number && number <= of => Ok(ShardOf { number, of }),
        _ => Err("expected K/N with K from 1 to N, both in digits without signs, spaces or leading zeros: 1/8 is the first of \
                  eight parts"
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

/// Runs the command.
pub fn run(study: &Study, of: ShardOf, place: &Place<'_>) -> Result<Status, Failure> {
    let shard = shard(study, of.number, of.of).map_err(Failure::bad_input)?;
    let interrupt = Interrupt::listen()?;
    let mut so_far = SoFar::new(shard.runs(), 0);
    let work = Work { threads: place.threads, restart: place.restart };
    let made = write_part(study, shard, place.out, work, &|| interrupt.signal().is_none(), |row| so_far.take(row));
    so_far.count.clear();
    let name = format!("shard {}/{}", of.number, of.of);
    let made = made.map_err(|error| match (error, interrupt.signal()) {
        (PartError::Stopped { done, of }, Some(signal)) => Failure::incomplete(format!(
            "{name} was interrupted by {signal} after {done} of its {of} runs: a part is whole or not there, so no file was \
             written; the same command makes it"
        )),
        (error, _) => error.into(),
    })?;
    let now = match &made.ran {
        Some(ran) => SweepWork::new(ran.runs, so_far.simulations, ran.threads, ran.wall_s),
        None => {
            let out = place.out.display();
            note(&format!("{out} is {name} of this study already: nothing was run. --restart runs it again."));
            SweepWork::new(0, 0, 0, 0.0)
        }
    };
    let report = SweepReport { shard: Some(shard), ..SweepReport::new(study, place.out, made.found, now) };
    answer(&report, place.json)?;
    Ok(Status::Done)
}
