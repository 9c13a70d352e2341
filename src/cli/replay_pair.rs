//! What two logs have in common, and what is to be borne in mind where they do not.

use super::replay_against::Side;
use crate::report::duration;
use crate::trace::SiteSummary;
use crate::trace::bodies::BodiesSample;

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
        if reading.recovered.is_some() {
            notes.push(format!("{label} is a recovered log: where messages are missing it is interpolated"));
        }
        if reading.samples == 0 {
            notes.push(format!("{label} has no sample"));
        }
        if !reading.is_of_discs() && side.finger.samples.first().is_some_and(|first| first.time_s > 0.0) {
            notes.push(format!("{label} does not begin at 0"));
        }
    }
    if !readings[0].is_of_discs() && readings.iter().all(|reading| reading.samples > 0) {
        let last = sides.each_ref().map(|side| &side.finger.outcome.last);
        let objects = last.map(|sample| sample.proximal.gap_m.is_finite());
        let limits = last.map(|sample| sample.limit.gap_m.is_finite());
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
    if sides[0].names == sides[1].names {
        return Vec::new();
    }
    let mut notes = Vec::new();
    let [first, second] = sides.each_ref().map(|side| side.names.clone());
    for ((ours, theirs), label) in [(&first, &second), (&second, &first)].into_iter().zip(labels) {
        let only = |ours: &[String], theirs: &[String]| {
            ours.iter().filter(|name| !theirs.contains(name)).cloned().collect::<Vec<_>>().join(", ")
        };
        for (what, names) in [("disc", only(&ours.discs, &theirs.discs)), ("pair", only(&ours.pairs, &theirs.pairs))] {
            if !names.is_empty() {
                notes.push(format!("only {label} has the {what} {names}"));
            }
        }
    }
    let both = |ours: &[String], theirs: &[String]| -> Vec<String> {
        ours.iter().filter(|name| theirs.contains(name)).cloned().collect()
    };
    let (discs, pairs) = (both(&first.discs, &second.discs), both(&first.pairs, &second.pairs));
    for side in sides {
        let places = |wanted: &[String], names: &[String]| -> Vec<usize> {
            wanted.iter().filter_map(|name| names.iter().position(|known| known == name)).collect()
        };
        let (disc_places, pair_places) = (places(&discs, &side.names.discs), places(&pairs, &side.names.pairs));
        let keep = |sample: &mut BodiesSample| {
            sample.discs = disc_places.iter().filter_map(|&k| sample.discs.get(k).copied()).collect();
            sample.contacts = pair_places.iter().filter_map(|&k| sample.contacts.get(k).copied()).collect();
        };
        side.discs.samples.iter_mut().for_each(keep);
        let outcome = &mut side.discs.outcome;
        keep(&mut outcome.last);
        let kept: Vec<SiteSummary> = pair_places.iter().filter_map(|&k| outcome.pairs.get(k).copied()).collect();
        outcome.pairs = kept;
        side.discs.events.retain_mut(|event| {
            let place = pair_places.iter().position(|&k| k == event.pair);
            event.pair = place.unwrap_or(event.pair);
            place.is_some()
        });
        (side.names.discs, side.names.pairs) = (discs.clone(), pairs.clone());
    }
    notes
}
