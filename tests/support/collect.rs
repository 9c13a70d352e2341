//! A sink that stores all samples and events of a run.

use phalanx::trace::{Event, EventKind, Sample, Sink, SinkError};

#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollectSink {
    pub samples: Vec<Sample>,
    pub events: Vec<Event>,
}

impl Sink for CollectSink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.samples.push(sample.clone());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        Ok(())
    }
}

impl CollectSink {
    /// Returns the sample whose time is nearest to `t`, s.
    pub fn nearest_sample(&self, t: f64) -> &Sample {
        let distance = |s: &&Sample| (s.time_s - t).abs();
        self.samples.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("samples")
    }

    /// Time of the first event of the given kind at a contact, s.
    pub fn first_event_s(&self, contact: usize, kind: EventKind) -> Option<f64> {
        self.events.iter().find(|event| event.contact == contact && event.kind == kind).map(|event| event.time_s)
    }

    /// Time of the first event of the given kind at a contact, s; panics if there is none.
    #[track_caller]
    pub fn event_time_s(&self, contact: usize, kind: EventKind) -> f64 {
        self.first_event_s(contact, kind).unwrap_or_else(|| panic!("no {kind:?} at contact {contact}"))
    }

    /// Time of the first touch-down at a contact, s.
    pub fn first_contact_s(&self, contact: usize) -> Option<f64> {
        self.first_event_s(contact, EventKind::TouchDown)
    }
}
