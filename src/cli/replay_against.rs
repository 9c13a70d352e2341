//! `phalanx replay --against`: compares two logs, with differences and plots.

use std::path::Path;

use super::output::{FileKind, print_result, reserve, save};
use super::progress::Interrupt;
use super::replay_read::{LogReader, ReplayArgs, print_defects};
use super::{Failure, Status};
use crate::format::{ToReport, format_duration};
use crate::page::{Note, Page, render_page};
use crate::plot;
use crate::report::replay::{LogComparisonReport, ReplayReport, TrajectoryDifference, compare_summaries};
use crate::trace::{FingerContact, Sample, Schema};
use crate::validate::{Angle, Recording, compare};

/// Files in the output directory.
const FILES: [&str; 5] = ["report.txt", "report.json", "page.html", "overlay.svg", "difference.svg"];

pub(super) fn run(args: &ReplayArgs, other: &Path, interrupt: &Interrupt) -> Result<Status, Failure> {
    let paths = [args.log.as_path(), other];
    let mut logs = [LogReader::new(paths[0], interrupt)?, LogReader::new(paths[1], interrupt)?];
    let counts = logs.each_ref().map(|log| log.summary.finger_count());
    if counts[0] != counts[1] {
        let [first, second] = counts.map(|count| ["a mechanism", "a finger", "a gripper"][count]);
        return Err(Failure::bad_input(format!(
            "{} is a log of {first}, but {} is a log of {second}; these cannot be compared; give two logs of one kind",
            paths[0].display(),
            paths[1].display(),
        )));
    }
    let html = ("--plot", args.plot.as_deref(), FileKind::Page);
    let inputs = paths.map(Path::to_path_buf);
    let directory = reserve(&[("the log", &inputs)], &[html], (args.out.as_deref(), &FILES))?;
    let mut has_page = args.plot.is_some() || args.out.is_some();
    // If the page of --plot is impossible, this is an error; the page of --out is only omitted.
    let mut require_page = |result: Result<(), Failure>| {
        has_page &= result.is_ok();
        if args.plot.is_some() { result } else { Ok(()) }
    };
    if args.plot.is_some() || args.out.is_some() {
        logs.iter_mut().try_for_each(|log| require_page(log.record_page()))?;
    }
    for log in &mut logs {
        log.recording = Some(Recording::default());
        log.read()?;
    }
    logs.iter().try_for_each(|log| require_page(log.ensure_drawable()))?;
    let reports = logs.each_mut().map(LogReader::report);
    let labels = choose_labels(paths, &reports);
    let compared_to_s = logs.iter().filter_map(|log| log.summary.last_s).min_by(f64::total_cmp).unwrap_or(0.0);
    let mut runs = logs.each_mut().map(|log| (log.schema.clone(), log.recording.take().unwrap_or_default()));
    let mut notes = comparison_notes(&logs, &runs, &labels);
    notes.extend(retain_common(&mut runs, &labels));
    let (trajectory_differences, plots) = compute_differences(&runs, &labels, &reports, compared_to_s);
    let (numbers, texts) = compare_summaries(&reports);
    let mut report = LogComparisonReport {
        kind: ["mechanism", "finger", "gripper"][counts[0]],
        labels,
        logs: reports,
        compared_to_s,
        notes,
        numbers,
        texts,
        trajectory_differences,
        directory: None,
        files: None,
        page: None,
    };
    let page_text = has_page.then(|| build_page(logs, &report)).transpose()?;
    if let Some(out) = &args.out {
        report.directory = Some(out.display().to_string());
        let written = FILES.into_iter().filter(|file| *file != "page.html" || page_text.is_some());
        report.files = Some(written.map(String::from).collect());
        directory.write_with(|out| {
            save(&out.join("overlay.svg"), &plots[0])?;
            save(&out.join("difference.svg"), &plots[1])?;
            page_text.iter().try_for_each(|page| save(&out.join("page.html"), page))?;
            save(&out.join("report.txt"), &report.report().to_string())?;
            save(&out.join("report.json"), &report.json())
        })?;
    }
    if let (Some(target), Some(page)) = (&args.plot, &page_text) {
        save(target, page)?;
        report.page = Some(target.display().to_string());
    }
    print_result(&report, args.json)?;
    let statuses = [0, 1].map(|k| print_defects(paths[k], &report.logs[k]));
    Ok(if statuses == [Status::Done; 2] { Status::Done } else { Status::CheckFailed })
}

fn build_page(logs: [LogReader<'_>; 2], report: &LogComparisonReport) -> Result<String, Failure> {
    let [(first, description), (second, _)] = logs.each_ref().map(LogReader::name_and_description);
    let title = if first == second { first } else { format!("{first} and {second}") };
    let summaries = report.labels.iter().zip(&report.logs);
    let runs = logs.into_iter().zip(summaries).map(|(log, (label, summary))| {
        Ok(log.into_playback(label, summary.report())?.with_grasp(summary.played_grasp()))
    });
    let runs = runs.collect::<Result<Vec<_>, Failure>>()?;
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
    runs: &[(Schema, Recording); 2],
    labels: &[String; 2],
    logs: &[ReplayReport; 2],
    until_s: f64,
) -> (Vec<TrajectoryDifference>, [String; 2]) {
    let [(schema, first), (_, second)] = runs;
    let (sparse, dense) = if first.samples.len() > second.samples.len() { (second, first) } else { (first, second) };
    let angles = schema.fingers.iter().flat_map(|finger| {
        let prefix = if finger.is_empty() { String::new() } else { format!("{finger}_") };
        Angle::ALL.map(|angle| format!("{prefix}{}_rad", angle.name()))
    });
    let quantities = angles.chain(schema.bodies.iter().map(|name| format!("{name}_centre_m")));
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
    let title = build_title(logs, labels);
    let overlay = plot::overlay_runs(&title, label_texts, schema, [first, second], end_s);
    let [subject, label] = match (schema.fingers.is_empty(), schema.bodies.is_empty()) {
        (false, true) => ["joint angles", "|difference|, rad"],
        (false, false) => ["joint angles and centre", "|difference|, rad or m"],
        (true, _) => ["centres", "distance, m"],
    };
    let title = format!("{title}: differences of {subject}");
    let difference = plot::plot_differences(&title, label, schema, [sparse, dense, first], None, until_s);
    (differences, [overlay, difference])
}

/// Returns notes on different durations, losses and scenes, and on parts that only one of the logs contains.
fn comparison_notes(logs: &[LogReader<'_>; 2], runs: &[(Schema, Recording); 2], labels: &[String; 2]) -> Vec<String> {
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
    for (((_, recording), summary), label) in runs.iter().zip(summaries).zip(labels) {
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
        if recording.samples.first().is_some_and(|first| first.time_s > 0.0) {
            notes.push(format!("{label} does not begin at 0"));
        }
    }
    // The subjects of a log can contradict its metadata.
    let are_fingers = runs.iter().all(|(schema, _)| schema.fingers.len() == 1);
    if are_fingers && summaries.iter().all(|summary| summary.samples > 0) {
        let last = runs.each_ref().map(|(_, recording)| &recording.outcome.last);
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

/// Retains only the bodies and contacts that both logs contain, in the same order. Returns notes on the removed ones.
fn retain_common(runs: &mut [(Schema, Recording); 2], labels: &[String; 2]) -> Vec<String> {
    let [first, second] = runs.each_ref().map(|(schema, _)| schema.clone());
    if first == second {
        return Vec::new();
    }
    let body = |schema: &Schema, name: &str| schema.bodies.iter().position(|body| body == name);
    let contact = |schema: &Schema, name: &str| schema.contacts.iter().position(|contact| contact.name == name);
    let mut notes = Vec::new();
    for (own, other, label) in [(&first, &second, &labels[0]), (&second, &first, &labels[1])] {
        let bodies = own.bodies.iter().filter(|name| body(other, name).is_none());
        let contacts = own.contacts.iter().map(|contact| &contact.name).filter(|name| contact(other, name).is_none());
        for (part, names) in [("body", bodies.cloned().collect::<Vec<_>>()), ("contact", contacts.cloned().collect())] {
            if !names.is_empty() {
                notes.push(format!("only {label} has the {part} {}", names.join(", ")));
            }
        }
    }
    let mut common = first.clone();
    common.bodies.retain(|name| body(&second, name).is_some());
    common.contacts.retain(|shared| contact(&second, &shared.name).is_some());
    let limits = &first.contacts[first.surfaces().end..];
    common.limits = limits.iter().filter(|shared| contact(&second, &shared.name).is_some()).count();
    for (schema, recording) in runs {
        let bodies: Vec<usize> = common.bodies.iter().filter_map(|name| body(schema, name)).collect();
        let contacts: Vec<usize> = common.contacts.iter().filter_map(|each| contact(schema, &each.name)).collect();
        let retain = |sample: &mut Sample| *sample = sample.select(&bodies, &contacts);
        recording.samples.iter_mut().for_each(retain);
        let outcome = &mut recording.outcome;
        retain(&mut outcome.last);
        outcome.contacts = contacts.iter().filter_map(|&k| outcome.contacts.get(k).copied()).collect();
        recording.events.retain_mut(|event| {
            let index = contacts.iter().position(|&k| k == event.contact);
            event.contact = index.unwrap_or(event.contact);
            index.is_some()
        });
        // Each run keeps its own joints, actuators and tendons.
        let Schema { bodies, contacts, limits, .. } = common.clone();
        *schema = Schema { bodies, contacts, limits, ..schema.clone() };
    }
    notes
}
