//! Arbitrary bytes as a log: rejected with a reason, or read up to the first error, in order of time.

use std::io::Cursor;

use phalanx::criteria::{FinalAngles, Tracker};
use phalanx::log::{self, LogSink};
use phalanx::report::replay::LogObserver;
use phalanx::trace::{Event, Sample, Schema, Sink, SinkError};

/// The consumer of `phalanx replay`, with checks of its input.
#[derive(Default)]
struct CheckingSink {
    schema: Schema,
    observer: LogObserver,
    /// Criteria of a single finger.
    tracker: Option<Tracker>,
    latest_s: f64,
    samples: u64,
    events: u64,
}

impl LogSink for CheckingSink {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        self.schema = schema.clone();
        self.observer.schema(schema)?;
        let angles = FinalAngles { q11_rad: 0.03, q21_rad: 1.13 };
        self.tracker = (schema.fingers.len() == 1).then(|| Tracker::new(angles));
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        assert!(sample.time_s >= self.latest_s);
        self.latest_s = sample.time_s;
        self.samples += 1;
        assert_eq!(sample.counts(), self.schema.counts());
        self.observer.sample(sample)?;
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        assert!(event.time_s.is_finite() && event.contact < self.schema.contacts.len());
        self.events += 1;
        self.observer.event(event)?;
        self.tracker.event(event)
    }
}

pub fn log(bytes: &[u8]) {
    let mut sink = CheckingSink::default();
    match log::read(Cursor::new(bytes), &mut sink) {
        Ok(reading) => {
            assert_eq!((sink.samples, sink.events), (reading.samples, reading.events));
            assert!(reading.losses.iter().all(|loss| !loss.description.is_empty()));
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    let _ = sink.tracker.map(|tracker| tracker.criteria(None));
}
