//! Selects the parts of a scene's samples that are shown.

use super::build::{Playback, PlaybackSource, build, event_marker};
use super::{panels, panels_fingers};
use crate::drawing::{self, Drawing};
use crate::format::Report;
use crate::scene::Scene;
use crate::trace::{Event, Layout, Sample};

/// Maximum number of pairs of discs shown if no pair has contact.
const MAX_IDLE_PAIRS: usize = 6;

/// Builds the playback of a run; `summary` is shown below it.
///
/// Plotted angles of a finger are wrapped to −π to π, as in the series of a validation; angles of poses are not. Pairs
/// of discs without contact are omitted if other pairs have contact.
pub fn build_playback(
    label: &str,
    scene: &Scene,
    samples: &[Sample],
    events: &[Event],
    summary: impl Into<Report>,
) -> Playback {
    let (system, layout) = (&scene.system, Layout::from_system(&scene.system));
    let surfaces: Vec<usize> = layout.surfaces().collect();
    let indices: Vec<usize> = match system.fingers.len() {
        1 if system.object().is_some() => surfaces,
        1 => Vec::new(),
        _ => pairs_in_contact(surfaces, samples, events),
    };
    // Keys become words; names given by the user are unchanged.
    let display_name = |index: usize| match system.fingers.is_empty() {
        true => layout.contacts[index].name.clone(),
        false => layout.contacts[index].name.replace('_', " "),
    };
    let contacts: Vec<(String, usize)> = indices.into_iter().map(|index| (display_name(index), index)).collect();
    let marker =
        |event: &Event| event_marker(event, &display_name(event.contact), layout.contacts[event.contact].is_angular);
    build(PlaybackSource {
        label,
        summary: summary.into(),
        drawing: Drawing::from_scene(scene),
        samples,
        poses: Box::new(move |sample| drawing::poses(scene, sample)),
        motions: Box::new(move |sample| drawing::velocities(scene, sample)),
        panels: match system.fingers.is_empty() {
            true => panels::disc_panels(system, &contacts),
            false => panels_fingers::finger_panels(system, &contacts),
        },
        contacts,
        event_markers: events.iter().map(marker).collect(),
    })
}

/// Indices of the pairs that have contact, or of the first few if none has.
fn pairs_in_contact(mut pairs: Vec<usize>, samples: &[Sample], events: &[Event]) -> Vec<usize> {
    let has_force = |pair: usize| samples.iter().any(|sample| sample.contacts[pair].normal_n > 0.0);
    let has_contact = |pair: &usize| events.iter().any(|event| event.contact == *pair) || has_force(*pair);
    let found: Vec<usize> = pairs.iter().copied().filter(has_contact).collect();
    pairs.truncate(MAX_IDLE_PAIRS);
    if found.is_empty() { pairs } else { found }
}
