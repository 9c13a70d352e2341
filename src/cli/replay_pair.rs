//! What two logs have in common, and what is to be borne in mind where they do not.

use super::replay_side::Side;
use crate::scene::words::SceneKind;
use crate::trace::{Layout, Sample, Site};
use crate::wording::duration;

/// Notes on lengths, losses, scenes, and what only one of the logs has.
pub(super) fn notes(sides: &[Side<'_>; 2], labels: &[String; 2]) -> Vec<String> {
    let mut notes = Vec::new();
    let readings = sides.each_ref().map(|side| &side.reading);
    let scenes = readings.map(|reading| reading.scene.as_ref().map(|(_, text)| text));
    if let [Some(a), Some(b)] = scenes
        && a != b
    {
        notes.push("the scenes are not the same: two variants".to_string());
    }
    if let [Some(a), Some(b)] = readings.map(|reading| reading.last_s)
        && a != b
    {
        notes.push(format!(
            "{} goes to {}, {} to {}: final figures are each log's own",
            labels[0],
            duration(a),
            labels[1],
            duration(b)
        ));
    }
    for ((side, reading), label) in sides.iter().zip(readings).zip(labels) {
        match &reading.ended {
            _ if !reading.is_whole() => notes.push(format!("a part of {label} is lost")),
            None => notes.push(format!("{label} does not say how its run ended")),
            Some(ended) if ended.stopped.is_some() => notes.push(format!("the run of {label} was not completed")),
            Some(_) => {}
        }
        notes.extend(
            reading.missing.iter().map(|missing| format!("missing in {label}: {} {}", missing.topic, missing.what)),
        );
        if reading.recovered.is_some() {
            notes.push(format!("{label} is a recovered log: where messages are missing it is interpolated"));
        }
        if reading.samples == 0 {
            notes.push(format!("{label} has no sample"));
        }
        if reading.kind() != SceneKind::Bodies && side.recording.samples.first().is_some_and(|first| first.time_s > 0.0)
        {
            notes.push(format!("{label} does not begin at 0"));
        }
    }
    if readings[0].kind() == SceneKind::Finger && readings.iter().all(|reading| reading.samples > 0) {
        let last = sides.each_ref().map(|side| &side.recording.outcome.last);
        let objects = last.map(|sample| sample.contact(Site::Proximal).gap_m.is_finite());
        let limits = last.map(|sample| sample.contact(Site::Limit).gap_m.is_finite());
        for (what, there) in [("an object", objects), ("a joint limit", limits)] {
            if there[0] != there[1] {
                notes.push(format!("only {} has {what}", labels[usize::from(there[1])]));
            }
        }
    }
    notes
}

/// Leaves of both logs only the discs and pairs that both have, in the same order; says what goes.
pub(super) fn common(sides: &mut [Side<'_>; 2], labels: &[String; 2]) -> Vec<String> {
    let [first, second] = sides.each_ref().map(|side| side.layout.clone());
    if first == second {
        return Vec::new();
    }
    let mut notes = Vec::new();
    for ((ours, theirs), label) in [(&first, &second), (&second, &first)].into_iter().zip(labels) {
        let discs = only(&ours.bodies, &theirs.bodies, |name| name);
        let pairs = only(&ours.contacts, &theirs.contacts, |place| &place.name);
        for (what, names) in [("disc", discs), ("pair", pairs)] {
            if !names.is_empty() {
                notes.push(format!("only {label} has the {what} {names}"));
            }
        }
    }
    let layout = Layout {
        bodies: both(&first.bodies, &second.bodies),
        contacts: both(&first.contacts, &second.contacts),
        ..first
    };
    for side in sides {
        let bodies = places(&layout.bodies, &side.layout.bodies);
        let contacts = places(&layout.contacts, &side.layout.contacts);
        let keep = |sample: &mut Sample| {
            sample.bodies = bodies.iter().filter_map(|&k| sample.bodies.get(k).copied()).collect();
            sample.contacts = contacts.iter().filter_map(|&k| sample.contacts.get(k).copied()).collect();
        };
        side.recording.samples.iter_mut().for_each(keep);
        let outcome = &mut side.recording.outcome;
        keep(&mut outcome.last);
        outcome.contacts = contacts.iter().filter_map(|&k| outcome.contacts.get(k).copied()).collect();
        side.recording.events.retain_mut(|event| {
            let place = contacts.iter().position(|&k| k == event.contact);
            event.contact = place.unwrap_or(event.contact);
            place.is_some()
        });
        side.layout = layout.clone();
    }
    notes
}

/// The names of what only `ours` has.
fn only<T: PartialEq>(ours: &[T], theirs: &[T], name: impl Fn(&T) -> &String) -> String {
    let names = ours.iter().filter(|part| !theirs.contains(part)).map(name);
    names.cloned().collect::<Vec<_>>().join(", ")
}

fn both<T: PartialEq + Clone>(ours: &[T], theirs: &[T]) -> Vec<T> {
    ours.iter().filter(|part| theirs.contains(part)).cloned().collect()
}

/// Where the wanted parts are among those that are there.
fn places<T: PartialEq>(wanted: &[T], there: &[T]) -> Vec<usize> {
    wanted.iter().filter_map(|part| there.iter().position(|known| known == part)).collect()
}
