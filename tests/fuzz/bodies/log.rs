//! Arbitrary bytes as a log: rejected with a reason, or read up to the first error, in order of time.

use std::io::Cursor;

use phalanx::criteria::{FinalAngles, Tracker};
use phalanx::log::{self, ComparisonOptions, LogComparison, LogSink};
use phalanx::report::replay::Summary;
use phalanx::scene::keywords::SceneKind;
use phalanx::trace::{Event, Layout, Sample, Sink, SinkError};

/// The consumer of `phalanx replay`, with checks of its input.
struct CheckingSink {
    tracker: Tracker,
    latest_s: f64,
    samples: u64,
    events: u64,
}

impl Sink for CheckingSink {
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
    let mut sink = CheckingSink { tracker, latest_s: 0.0, samples: 0, events: 0 };
    match log::read(Cursor::new(bytes), &mut sink) {
        Ok(reading) => {
            // A sink for a single finger receives nothing from discs and grippers.
            let received = (sink.samples, sink.events);
            let expected = match reading.kind() {
                SceneKind::Finger => (reading.samples, reading.events),
                _ => (0, 0),
            };
            assert_eq!(received, expected);
            for loss in &reading.losses {
                assert!(!loss.to_string().is_empty());
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    let _ = sink.tracker.criteria(None);
    read_any_kind(bytes);
    check_recovery(bytes);
}

/// A sink for logs of any kind of scene.
#[derive(Default)]
struct AnyKindSink {
    layout: Layout,
    summary: Summary,
    latest_s: f64,
}

impl LogSink for AnyKindSink {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.layout = layout.clone();
        self.summary = Summary::new(layout.clone(), None);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        assert!(sample.time_s >= self.latest_s);
        self.latest_s = sample.time_s;
        let Layout { fingers, bodies, contacts } = &self.layout;
        assert_eq!((sample.bodies.len(), sample.contacts.len()), (bodies.len(), contacts.len()));
        assert_eq!(sample.fingers.len(), fingers.len());
        self.summary.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        assert!(event.contact < self.layout.contacts.len());
        self.summary.event(event)
    }
}

fn read_any_kind(bytes: &[u8]) {
    let _ = log::read_any(Cursor::new(bytes), &mut AnyKindSink::default());
    let _ = log::read_past_damage(Cursor::new(bytes), &mut AnyKindSink::default());
}

/// A recovered log is complete, a second recovery loses nothing, and it has no more messages than recovered.
fn check_recovery(bytes: &[u8]) {
    let recover = |bytes: &[u8]| {
        let mut out = Vec::new();
        log::recover(&mut Cursor::new(bytes), "fuzz.mcap", &mut out, "the log", &|_| Ok(()))
            .map(|recovery| (out, recovery))
    };
    let Ok((out, recovery)) = recover(bytes) else { return };
    let reading = log::read_any(Cursor::new(&out), &mut AnyKindSink::default()).expect("a log");
    assert!(reading.is_complete(), "{:?}", reading.losses);
    assert_eq!(reading.messages, recovery.messages);
    let (_, second) = recover(&out).expect("a log");
    assert_eq!((second.messages, second.gaps), (recovery.messages, recovery.gaps));
    let mut comparison =
        LogComparison::new(Cursor::new(&out), ComparisonOptions::default(), &|_| Ok(())).expect("a valid log");
    let _ = log::read_any(Cursor::new(bytes), &mut comparison);
    let compared = comparison.finish().expect("readable");
    assert!(compared.compared <= recovery.messages);
}
