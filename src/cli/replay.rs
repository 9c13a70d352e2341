//! `phalanx replay`: what a log says of its run; whether simulating again gives the same; two logs side by side; samples as
//! a table; the good part of a damaged log.

use std::slice;

use super::interrupt::Interrupt;
use super::output::answer;
use super::own::Form;
use super::replay_args::{ReplayArgs, defects};
use super::replay_page::{Reels, Tee, undrawable};
use super::replay_read::{Listeners, bad_log, head};
use super::samples::{self, tabulated};
use super::saved::save;
use super::targets::{Kind, NONE, reserve};
use super::{Failure, Status, replay_against, replay_recover, replay_verify};
use crate::log::{LogSink, Reading, read_any_file};
use crate::page::{Page, page};
use crate::wording::Reported;

/// Runs the command.
pub fn run(args: &ReplayArgs) -> Result<Status, Failure> {
    let interrupt = Interrupt::listen()?;
    if args.verify {
        return replay_verify::run(args, &interrupt);
    }
    if let Some(target) = &args.recover {
        return replay_recover::run(args, target, &interrupt);
    }
    match &args.against {
        Some(other) => replay_against::run(args, other, &interrupt),
        None => one(args, &interrupt),
    }
}

/// Reads the log once: for its summary, unless the table goes where that would, its table and its page.
fn one(args: &ReplayArgs, interrupt: &Interrupt) -> Result<Status, Failure> {
    let path = &args.log;
    let csv = samples::file(args.csv.as_deref(), args.json)?;
    let reels = args.html.as_ref().map(|_| Reels::new(path, &head(path)?)).transpose()?;
    let mut listeners = Listeners::new(path, interrupt)?;
    let html = ("--html", args.html.as_deref(), Kind::File(Form::Page));
    let csv_target = ("--csv", csv, Kind::File(Form::Samples));
    reserve(&[("the log", slice::from_ref(path))], &[csv_target, html], NONE)?;
    let (read, reels) = match reels {
        Some(mut reels) => (read(args, &mut Tee(&mut listeners, &mut reels)), Some(reels)),
        None => (read(args, &mut listeners), None),
    };
    listeners.done();
    let Some(reading) = read? else { return Ok(Status::Done) };
    let mut report = listeners.report(path.display().to_string(), &reading);
    report.csv = csv.map(|csv| csv.display().to_string());
    if let (Some(target), Some(reels)) = (&args.html, reels) {
        undrawable(path, &reading)?;
        let (title, description) = reels.about();
        let film = reels.film(path, report.model.as_deref().unwrap_or("run"), report.report())?;
        save(target, &page(&Page { title, description, runs: vec![film], ..Page::default() }))?;
        report.page = Some(target.display().to_string());
    }
    if csv.is_some() || args.csv.is_none() {
        answer(&report, args.json)?;
    }
    Ok(defects(path, &reading, &report))
}

/// Reads the log, and writes its table if there is to be one; `None` if the reader of that takes no more.
fn read<S: LogSink>(args: &ReplayArgs, sink: &mut S) -> Result<Option<Reading>, Failure> {
    let bad = |error| bad_log(&args.log, &error);
    let Some(csv) = &args.csv else { return read_any_file(&args.log, sink).map(Some).map_err(bad) };
    match tabulated(csv, Vec::new(), sink, |table| read_any_file(&args.log, table).map_err(bad)) {
        (_, Ok(false)) => Ok(None),
        (Err(failure), _) | (_, Err(failure)) => Err(failure),
        (Ok(reading), Ok(true)) => Ok(Some(reading)),
    }
}
