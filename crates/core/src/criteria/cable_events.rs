//! Lift-off and return of cables: when a cable leaves a pulley, and when it is on it again.

use crate::mechanism::Mechanism;
use crate::trace::{RequiredData, Sample, Sink, SinkError};
use serde::Serialize;

/// Largest number of events of a run that are listed; later ones are ignored.
const MAX_EVENTS: usize = 1000;

/// Change of a cable at a pulley.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CableEventKind {
    /// The cable leaves the pulley.
    Leaves,
    /// The cable is on the pulley again.
    Returns,
}

/// Lift-off of a cable from a pulley, or its return.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CableEvent {
    /// Time of the last sample before the change, s: in the analytic model that of the event, in the engine within a step.
    pub time_s: f64,
    /// Name of the place, such as `flexor[2]`.
    pub place: String,
    pub event: CableEventKind,
}

/// A [`Sink`] that lists the events of all cables.
#[derive(Clone, Debug)]
pub struct CableEvents {
    /// Index of each pulley among the places of a sample, with its name.
    pulleys: Vec<(usize, String)>,
    /// Whether the cable is on each pulley in the last sample, and its time.
    last: Vec<bool>,
    last_s: f64,
    events: Vec<CableEvent>,
}

impl CableEvents {
    /// Creates the sink for a mechanism; `None` if no cable passes a pulley.
    pub fn for_mechanism(mechanism: &Mechanism) -> Option<Self> {
        let places = mechanism.reported_elements().enumerate();
        let pulleys = places.filter(|(_, [tendon, element])| mechanism.tendons[*tendon].path[*element].is_pulley());
        let pulleys: Vec<_> =
            pulleys.map(|(index, [tendon, element])| (index, mechanism.element_name(tendon, element))).collect();
        let found = Self { pulleys, last: Vec::new(), last_s: 0.0, events: Vec::new() };
        (!found.pulleys.is_empty()).then_some(found)
    }

    /// Events up to the last sample, in order of time.
    pub fn events(&self) -> &[CableEvent] {
        &self.events
    }
}

impl Sink for CableEvents {
    fn required_data(&self) -> RequiredData {
        RequiredData { passive: true, ..RequiredData::NONE }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let is_first = self.last.is_empty();
        for (k, (index, place)) in self.pulleys.iter().enumerate() {
            let is_on = sample.cable_element(*index).on > 0.5;
            if is_first {
                self.last.push(is_on);
            } else if std::mem::replace(&mut self.last[k], is_on) != is_on && self.events.len() < MAX_EVENTS {
                let event = if is_on { CableEventKind::Returns } else { CableEventKind::Leaves };
                self.events.push(CableEvent { time_s: self.last_s, place: place.clone(), event });
            }
        }
        self.last_s = sample.time_s;
        Ok(())
    }
}
