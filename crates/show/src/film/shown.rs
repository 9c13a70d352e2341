//! What of a scene's samples is shown.

use super::develop::{Film, Shown, develop, mark};
use super::{panels, panels_fingers};
use crate::drawing::{self, Drawing};
use crate::scene::Scene;
use crate::trace::{Event, Layout, Sample};
use crate::wording::Report;

/// Pairs that are shown where none touches.
const IDLE_PAIRS: usize = 6;

/// A run as the page shows it; `summary` is what is said of it below.
///
/// Plotted angles of a finger are from −π to π, as in the series of a validation; poses are as they are. Pairs of discs that
/// never touch are left out where others do.
pub fn film(label: &str, scene: &Scene, samples: &[Sample], events: &[Event], summary: impl Into<Report>) -> Film {
    let (system, layout) = (&scene.system, Layout::of(&scene.system));
    let surfaces: Vec<usize> = layout.surfaces().collect();
    let shown: Vec<usize> = match system.fingers.len() {
        1 if system.object().is_some() => surfaces,
        1 => Vec::new(),
        _ => touching(surfaces, samples, events),
    };
    // Words instead of keys; names that users gave stay as they are.
    let called = |index: usize| match system.fingers.is_empty() {
        true => layout.contacts[index].name.clone(),
        false => layout.contacts[index].name.replace('_', " "),
    };
    let contacts: Vec<(String, usize)> = shown.into_iter().map(|index| (called(index), index)).collect();
    let of = |event: &Event| mark(event, &called(event.contact), layout.contacts[event.contact].angular);
    develop(Shown {
        label,
        summary: summary.into(),
        drawing: Drawing::of(scene),
        samples,
        poses: Box::new(move |sample| drawing::poses(scene, sample)),
        motions: Box::new(move |sample| drawing::motions(scene, sample)),
        panels: match system.fingers.is_empty() {
            true => panels::of_discs(system, &contacts),
            false => panels_fingers::of_fingers(system, &contacts),
        },
        contacts,
        marks: events.iter().map(of).collect(),
    })
}

/// Indices of the pairs that touch, or of the first few if none does.
fn touching(mut pairs: Vec<usize>, samples: &[Sample], events: &[Event]) -> Vec<usize> {
    let presses = |pair: usize| samples.iter().any(|sample| sample.contacts[pair].normal_n > 0.0);
    let touches = |pair: &usize| events.iter().any(|event| event.contact == *pair) || presses(*pair);
    let found: Vec<usize> = pairs.iter().copied().filter(touches).collect();
    pairs.truncate(IDLE_PAIRS);
    if found.is_empty() { pairs } else { found }
}
