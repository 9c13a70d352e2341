//! Any bytes as a log: refused with a reason, or read as far as they go, in order of time.

use std::io::Cursor;

use phalanx::criteria::{FinalAngles, Tracker};
use phalanx::log;
use phalanx::trace::{Event, Sample, Sink, SinkError};

/// The consumers that `phalanx replay` has, and a check of what they are given.
struct Listener {
    tracker: Tracker,
    latest_s: f64,
    samples: u64,
    events: u64,
}

impl Sink for Listener {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        assert!(sample.time_s >= self.latest_s);
        self.latest_s = sample.time_s;
        self.samples += 1;
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        assert!(event.time_s.is_finite());
        self.events += 1;
        self.tracker.event(event)
    }
}

pub fn log(bytes: &[u8]) {
    let tracker = Tracker::new(FinalAngles { q11_rad: 0.03, q21_rad: 1.13 });
    let mut listener = Listener { tracker, latest_s: 0.0, samples: 0, events: 0 };
    match log::read(Cursor::new(bytes), &mut listener) {
        Ok(reading) => {
            assert_eq!((reading.samples, reading.events), (listener.samples, listener.events));
            for loss in &reading.losses {
                assert!(!loss.to_string().is_empty());
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    let _ = listener.tracker.criteria(true);
}
