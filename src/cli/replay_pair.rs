//! Common parts of two logs, and notes on their differences.

use super::replay_loaded_log::LoadedLog;
use crate::format::format_duration;
use crate::scene::keywords::SceneKind;
use crate::trace::{FingerContact, Layout, Sample};

/// Returns notes on different durations, losses and scenes, and on parts that only one of the logs contains.
pub(super) fn comparison_notes(logs: &[LoadedLog<'_>; 2], labels: &[String; 2]) -> Vec<String> {
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
        if summary.recovered.is_some() {
            notes.push(format!("{label} is a recovered log: missing messages are interpolated"));
        }
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
        let objects = last.map(|sample| sample.contact(FingerContact::Proximal).gap_m.is_finite());
        let limits = last.map(|sample| sample.contact(FingerContact::Limit).gap_m.is_finite());
        for (part, is_present) in [("an object", objects), ("a joint limit", limits)] {
            if is_present[0] != is_present[1] {
                notes.push(format!("only {} has {part}", labels[usize::from(is_present[1])]));
            }
        }
    }
    notes
}

/// Retains only the discs and pairs that both logs contain, in the same order. Returns notes on the removed ones.
pub(super) fn retain_common(logs: &mut [LoadedLog<'_>; 2], labels: &[String; 2]) -> Vec<String> {
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
    let layout = Layout {
        bodies: intersection(&first.bodies, &second.bodies),
        contacts: intersection(&first.contacts, &second.contacts),
        ..first
    };
    for log in logs {
        let bodies = indices_of(&layout.bodies, &log.layout.bodies);
        let contacts = indices_of(&layout.contacts, &log.layout.contacts);
        let retain = |sample: &mut Sample| {
            sample.bodies = bodies.iter().filter_map(|&k| sample.bodies.get(k).copied()).collect();
            sample.contacts = contacts.iter().filter_map(|&k| sample.contacts.get(k).copied()).collect();
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
