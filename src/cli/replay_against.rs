//! `phalanx replay --against`: compares two logs, with differences and plots.

use std::io;
use std::path::Path;

use super::interrupt::Interrupt;
use super::output::print_result;
use super::replay_read::{
    LogPlaybackRecorder, ReplayArgs, SummarySink, Tee, ensure_drawable, print_defects, read_failure, read_head,
};
use super::targets::{FileKind, PAGE_FILE, TargetKind, reserve, save};
use super::{Failure, Status};
use crate::format::{ToReport, format_duration};
use crate::limits::MAX_COMPARED_VALUES;
use crate::log::{LogSink, LogSummary, read_file};
use crate::page::{Note, Page, render_page};
use crate::plot::{self, DifferencePlot};
use crate::report::replay::{LogComparisonReport, ReplayReport, TrajectoryDifference, compare_summaries};
use crate::scene::Keyword;
use crate::scene::keywords::SceneKind;
use crate::trace::{Event, FingerContact, Sample, Schema, Sink, SinkError};
use crate::validate::{Angle, Recording, compare};

/// Files in the output directory.
const FILES: [&str; 5] = ["report.txt", "report.json", PAGE_FILE, "overlay.svg", "difference.svg"];

/// Runs `phalanx replay --against`.
pub(super) fn run(args: &ReplayArgs, other: &Path, interrupt: &Interrupt) -> Result<Status, Failure> {
    let paths = [args.log.as_path(), other];
    let heads = [read_head(paths[0])?, read_head(paths[1])?];
    let kinds = heads.each_ref().map(LogSummary::kind);
    if kinds[0] != kinds[1] {
        let kind = |kind: SceneKind| match kind {
            SceneKind::Finger => "a finger",
            SceneKind::Bodies => "discs",
            SceneKind::Gripper => "a gripper",
        };
        return Err(Failure::bad_input(format!(
            "{} is a log of {}, but {} is a log of {}; these cannot be compared; give two logs of one kind",
            paths[0].display(),
            kind(kinds[0]),
            paths[1].display(),
            kind(kinds[1])
        )));
    }
    let html = ("--html", args.html.as_deref(), TargetKind::File(FileKind::Page));
    let logs = paths.map(Path::to_path_buf);
    let directory = reserve(&[("the log", &logs)], &[html], ("--out", args.out.as_deref(), &FILES))?;
    // If the page of --html is impossible, this is an error; the page of --out is only omitted.
    let mut recorders = match (&args.html, &args.out) {
        (Some(_), _) => {
            Some([LogPlaybackRecorder::new(paths[0], &heads[0])?, LogPlaybackRecorder::new(paths[1], &heads[1])?])
        }
        (None, Some(_)) => match heads.each_ref().map(|head| LogPlaybackRecorder::new(paths[0], head)) {
            [Ok(first), Ok(second)] => Some([first, second]),
            _ => None,
        },
        (None, None) => None,
    };
    let mut loaded = match &mut recorders {
        Some([first, second]) => {
            [LoadedLog::read(paths[0], interrupt, first)?, LoadedLog::read(paths[1], interrupt, second)?]
        }
        None => [LoadedLog::read(paths[0], interrupt, &mut ())?, LoadedLog::read(paths[1], interrupt, &mut ())?],
    };
    let drawable = [0, 1].map(|k| ensure_drawable(paths[k], &loaded[k].summary));
    if let Some(missing) = drawable.into_iter().find_map(Result::err) {
        recorders = match &args.html {
            Some(_) => return Err(missing),
            None => None,
        };
    }
    let logs = [0, 1].map(|k| loaded[k].report(paths[k]));
    let labels = choose_labels(paths, &logs);
    let mut notes = comparison_notes(&loaded, &labels);
    let compared_to_s = loaded.iter().filter_map(|log| log.summary.last_s).fold(f64::INFINITY, f64::min);
    let compared_to_s = if compared_to_s.is_finite() { compared_to_s } else { 0.0 };
    notes.extend(retain_common(&mut loaded, &labels));
    let (differences, plots) = compute_differences(&loaded, &labels, &logs, compared_to_s);
    let (numbers, texts) = compare_summaries(&logs);
    let kind = kinds[0].keyword();
    let mut report = LogComparisonReport {
        kind,
        labels,
        logs,
        compared_to_s,
        notes,
        numbers,
        texts,
        trajectory_differences: differences,
        directory: None,
        files: None,
        page: None,
    };
    let page_text = recorders.map(|recorders| build_page(recorders, paths, &report)).transpose()?;
    if let Some(out) = &args.out {
        report.directory = Some(out.display().to_string());
        report.files = Some(
            FILES.into_iter().filter(|file| *file != PAGE_FILE || page_text.is_some()).map(String::from).collect(),
        );
        directory.write_with(|out| {
            for (file, plot) in ["overlay.svg", "difference.svg"].iter().zip(&plots) {
                save(&out.join(file), plot)?;
            }
            if let Some(page) = &page_text {
                save(&out.join(PAGE_FILE), page)?;
            }
            save(&out.join("report.txt"), &report.report().to_string())?;
            save(&out.join("report.json"), &report.json())
        })?;
    }
    if let (Some(target), Some(page)) = (&args.html, &page_text) {
        save(target, page)?;
        report.page = Some(target.display().to_string());
    }
    print_result(&report, args.json)?;
    let statuses = [0, 1].map(|k| print_defects(paths[k], &report.logs[k]));
    Ok(if statuses == [Status::Done; 2] { Status::Done } else { Status::CheckFailed })
}

/// Builds the page of both logs.
fn build_page(
    recorders: [LogPlaybackRecorder; 2],
    paths: [&Path; 2],
    report: &LogComparisonReport,
) -> Result<String, Failure> {
    let [(first, description), (second, _)] = recorders.each_ref().map(LogPlaybackRecorder::name_and_description);
    let title = if first == second { first } else { format!("{first} and {second}") };
    let mut runs = Vec::new();
    for (((recorder, path), label), log) in recorders.into_iter().zip(paths).zip(&report.labels).zip(&report.logs) {
        runs.push(recorder.into_playback(path, label, log.report())?);
    }
    let notes = vec![Note { title: "Side by side".to_string(), text: report.report() }];
    Ok(render_page(&Page { title, description, runs, notes, pictures: Vec::new() }))
}

/// Labels of the logs: their models if these differ, else their file names if these differ and are short, else "first"
/// and "second".
fn choose_labels(paths: [&Path; 2], logs: &[ReplayReport; 2]) -> [String; 2] {
    let models = logs.each_ref().map(|log| log.model.clone());
    let names = paths.map(|path| path.file_name().map(|name| name.to_string_lossy().into_owned()));
    match (models, names) {
        ([Some(a), Some(b)], _) if a != b && a.len().max(b.len()) < 20 => [a, b],
        (_, [Some(a), Some(b)]) if a != b && a.chars().count().max(b.chars().count()) <= 24 => [a, b],
        _ => ["first".to_string(), "second".to_string()],
    }
}

/// Title of the plots.
fn build_title(logs: &[ReplayReport; 2], labels: &[String; 2]) -> String {
    let scene = |log: &ReplayReport| log.scene.clone().unwrap_or_else(|| "unknown scene".to_string());
    let [first, second] = [scene(&logs[0]), scene(&logs[1])];
    let [a, b] = labels;
    if first == second { format!("{first}: {a} and {b}") } else { format!("{first} ({a}) and {second} ({b})") }
}

/// Computes the differences of the trajectories and the plots for everything that both logs contain. The run with more
/// samples is interpolated.
fn compute_differences(
    loaded: &[LoadedLog<'_>; 2],
    labels: &[String; 2],
    logs: &[ReplayReport; 2],
    until_s: f64,
) -> (Vec<TrajectoryDifference>, [String; 2]) {
    let layout = &loaded[0].layout;
    let [first, second] = loaded.each_ref().map(|log| &log.recording);
    let (sparse, dense) = if first.samples.len() > second.samples.len() { (second, first) } else { (first, second) };
    let angles = layout.fingers.iter().flat_map(|finger| {
        let prefix = if finger.is_empty() { String::new() } else { format!("{finger}_") };
        Angle::ALL.map(|angle| format!("{prefix}{}_rad", angle.name()))
    });
    let quantities = angles.chain(layout.bodies.iter().map(|name| format!("{name}_centre_m")));
    let comparison = compare(sparse, dense, until_s);
    // The difference of a missing topic is infinite.
    let finite = quantities.zip(&comparison.path).filter(|(_, off)| off.max.is_finite());
    let differences = finite.map(|(quantity, off)| TrajectoryDifference {
        quantity,
        max: off.max,
        max_at_s: off.max_at_s,
        rms: off.rms,
        end: off.end,
    });
    let differences = if sparse.samples.is_empty() { Vec::new() } else { differences.collect() };
    let label_texts = labels.each_ref().map(String::as_str);
    let end_s = first.outcome.last.time_s.max(second.outcome.last.time_s);
    let overlay = plot::overlay_runs(build_title(logs, labels), label_texts, layout, [first, second], end_s);
    let [subject, label] = match (layout.fingers.is_empty(), layout.bodies.is_empty()) {
        (false, true) => ["joint angles", "|difference|, rad"],
        (false, false) => ["joint angles and centre", "|difference|, rad or m"],
        (true, _) => ["centres", "distance, m"],
    };
    let difference = plot::plot_differences(DifferencePlot {
        title: format!("{}: differences of {subject}", build_title(logs, labels)),
        label,
        curves: plot::path_differences(layout, sparse, dense, until_s),
        touchdowns: plot::touchdowns(layout, first, until_s),
        bound: None,
        until_s,
    });
    (differences, [overlay, difference])
}

/// A log that is loaded completely into memory.
struct LoadedLog<'a> {
    sink: SummarySink<'a>,
    summary: LogSummary,
    recording: Recording,
    layout: Schema,
    value_count: usize,
    exceeds_limit: bool,
}

impl<'a> LoadedLog<'a> {
    /// Reads a log and also passes it to `recorder`.
    fn read(path: &Path, interrupt: &'a Interrupt, recorder: &mut impl LogSink) -> Result<Self, Failure> {
        let mut loaded = LoadedLog {
            sink: SummarySink::new(path, interrupt)?,
            summary: LogSummary::default(),
            recording: Recording::default(),
            layout: Schema::from_kind(read_head(path)?.kind()),
            value_count: 0,
            exceeds_limit: false,
        };
        let summary = read_file(path, &mut Tee(&mut loaded, recorder));
        loaded.sink.clear_progress();
        loaded.summary = match summary {
            Err(_) if loaded.exceeds_limit => {
                return Err(Failure::bad_input(format!(
                    "{} is too long to be compared: both logs are loaded into memory, with at most {MAX_COMPARED_VALUES} figures each \
                     (476,000 samples of a finger); log at a lower rate, or compare the tables that --csv writes",
                    path.display()
                )));
            }
            summary => summary.map_err(|error| read_failure(path, &error))?,
        };
        if let Some(outcome) = loaded.sink.summary().outcome() {
            loaded.recording.outcome = outcome.clone();
        }
        Ok(loaded)
    }

    fn report(&mut self, path: &Path) -> ReplayReport {
        self.sink.report(path, &self.summary)
    }

    fn count_values(&mut self, values: usize) -> Result<(), SinkError> {
        self.value_count += values;
        self.exceeds_limit = self.value_count > MAX_COMPARED_VALUES;
        match self.exceeds_limit {
            true => Err(SinkError { target: "the log to memory".to_string(), source: io::ErrorKind::Other.into() }),
            false => Ok(()),
        }
    }
}

impl LogSink for LoadedLog<'_> {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        self.layout = schema.clone();
        self.sink.schema(schema)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.count_values(1 + sample.values().len())?;
        self.recording.sample(sample)?;
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.count_values(8)?;
        self.recording.event(event)?;
        self.sink.event(event)
    }
}

/// Returns notes on different durations, losses and scenes, and on parts that only one of the logs contains.
fn comparison_notes(logs: &[LoadedLog<'_>; 2], labels: &[String; 2]) -> Vec<String> {
    let mut notes = Vec::new();
    let summaries = logs.each_ref().map(|log| &log.summary);
    let scenes = summaries.map(|summary| summary.scene.as_ref().map(|(_, text)| text));
    if let [Some(a), Some(b)] = scenes
        && a != b
    {
        notes.push("the scenes differ: two variants".to_string());
    }
    if let [Some(a), Some(b)] = summaries.map(|summary| summary.last_s)
        && a != b
    {
        notes.push(format!(
            "{} ends at {}, {} at {}: final values are at the end of each log",
            labels[0],
            format_duration(a),
            labels[1],
            format_duration(b)
        ));
    }
    for ((log, summary), label) in logs.iter().zip(summaries).zip(labels) {
        match &summary.run_end {
            _ if !summary.is_complete() => notes.push(format!("a part of {label} is lost")),
            None => notes.push(format!("{label} does not state how its run ended")),
            Some(ended) if ended.stopped.is_some() => notes.push(format!("the run of {label} was not completed")),
            Some(_) => {}
        }
        notes.extend(
            summary.missing.iter().map(|missing| format!("missing in {label}: {} {}", missing.topic, missing.defect)),
        );
        if summary.samples == 0 {
            notes.push(format!("{label} has no samples"));
        }
        if summary.kind() != SceneKind::Bodies && log.recording.samples.first().is_some_and(|first| first.time_s > 0.0)
        {
            notes.push(format!("{label} does not begin at 0"));
        }
    }
    if summaries[0].kind() == SceneKind::Finger && summaries.iter().all(|summary| summary.samples > 0) {
        let last = logs.each_ref().map(|log| &log.recording.outcome.last);
        let objects = last.map(|sample| sample.finger_contact(FingerContact::Proximal).gap_m.is_finite());
        let limits = last.map(|sample| sample.finger_contact(FingerContact::Limit).gap_m.is_finite());
        for (part, is_present) in [("an object", objects), ("a joint limit", limits)] {
            if is_present[0] != is_present[1] {
                notes.push(format!("only {} has {part}", labels[usize::from(is_present[1])]));
            }
        }
    }
    notes
}

/// Retains only the discs and pairs that both logs contain, in the same order. Returns notes on the removed ones.
fn retain_common(logs: &mut [LoadedLog<'_>; 2], labels: &[String; 2]) -> Vec<String> {
    let [first, second] = logs.each_ref().map(|log| log.layout.clone());
    if first == second {
        return Vec::new();
    }
    let mut notes = Vec::new();
    for ((items, others), label) in [(&first, &second), (&second, &first)].into_iter().zip(labels) {
        let discs = missing_names(&items.bodies, &others.bodies, |name| name);
        let pairs = missing_names(&items.contacts, &others.contacts, |contact| &contact.name);
        for (part, names) in [("disc", discs), ("pair", pairs)] {
            if !names.is_empty() {
                notes.push(format!("only {label} has the {part} {names}"));
            }
        }
    }
    let layout = Schema {
        bodies: intersection(&first.bodies, &second.bodies),
        contacts: intersection(&first.contacts, &second.contacts),
        ..first
    };
    for log in logs {
        let bodies = indices_of(&layout.bodies, &log.layout.bodies);
        let contacts = indices_of(&layout.contacts, &log.layout.contacts);
        let retain = |sample: &mut Sample| {
            *sample = sample.select(&bodies, &contacts);
        };
        log.recording.samples.iter_mut().for_each(retain);
        let outcome = &mut log.recording.outcome;
        retain(&mut outcome.last);
        outcome.contacts = contacts.iter().filter_map(|&k| outcome.contacts.get(k).copied()).collect();
        log.recording.events.retain_mut(|event| {
            let index = contacts.iter().position(|&k| k == event.contact);
            event.contact = index.unwrap_or(event.contact);
            index.is_some()
        });
        log.layout = layout.clone();
    }
    notes
}

/// Names of the items that `others` does not contain.
fn missing_names<T: PartialEq>(items: &[T], others: &[T], name: impl Fn(&T) -> &String) -> String {
    let names = items.iter().filter(|item| !others.contains(item)).map(name);
    names.cloned().collect::<Vec<_>>().join(", ")
}

fn intersection<T: PartialEq + Clone>(items: &[T], others: &[T]) -> Vec<T> {
    items.iter().filter(|item| others.contains(item)).cloned().collect()
}

/// Indices of `items` in `all`.
fn indices_of<T: PartialEq>(items: &[T], all: &[T]) -> Vec<usize> {
    items.iter().filter_map(|item| all.iter().position(|other| other == item)).collect()
}
