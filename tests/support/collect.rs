//! A sink that keeps a whole run.

use phalanx::trace::{Event, EventKind, Sample, Sink, SinkError};

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Collect {
    pub samples: Vec<Sample>,
    pub events: Vec<Event>,
}

impl Sink for Collect {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.samples.push(sample.clone());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        Ok(())
    }
}

impl Collect {
    /// The sample nearest to `t`.
    pub fn at(&self, t: f64) -> &Sample {
        let distance = |s: &&Sample| (s.time_s - t).abs();
        self.samples.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("samples")
    }

    /// Time of the first event of a kind at a contact.
    pub fn first(&self, contact: usize, kind: EventKind) -> Option<f64> {
        self.events.iter().find(|event| event.contact == contact && event.kind == kind).map(|event| event.time_s)
    }

    /// The same of one that there has to be.
    #[track_caller]
    pub fn time(&self, contact: usize, kind: EventKind) -> f64 {
        self.first(contact, kind).unwrap_or_else(|| panic!("no {kind:?} at contact {contact}"))
    }

    /// Time of the first touch-down at a contact.
    pub fn first_touch(&self, contact: usize) -> Option<f64> {
        self.first(contact, EventKind::TouchDown)
    }
}
