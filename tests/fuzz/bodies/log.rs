//! Any bytes as a log: refused with a reason, or read as far as they go, in order of time.

use std::io::Cursor;

use phalanx::criteria::{FinalAngles, Tracker};
use phalanx::log::{self, Expected, Lockstep, LogSink};
use phalanx::report::replay::Summary;
use phalanx::scene::words::SceneKind;
use phalanx::trace::{Event, Layout, Sample, Sink, SinkError};

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
            // A sink of one finger hears nothing of discs and grippers.
            let heard = (listener.samples, listener.events);
            let expected = match reading.kind() {
                SceneKind::Finger => (reading.samples, reading.events),
                _ => (0, 0),
            };
            assert_eq!(heard, expected);
            for loss in &reading.losses {
                assert!(!loss.to_string().is_empty());
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    let _ = listener.tracker.criteria(None);
    any(bytes);
    recovered(bytes);
}

/// What takes logs of either kind.
#[derive(Default)]
struct Any {
    layout: Layout,
    summary: Summary,
    latest_s: f64,
}

impl LogSink for Any {
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

fn any(bytes: &[u8]) {
    let _ = log::read_any(Cursor::new(bytes), &mut Any::default());
    let _ = log::read_pieces(Cursor::new(bytes), &mut Any::default());
}

/// What is recovered is whole, nothing of it is lost when it is recovered once more, and it is the beginning of what it was
/// recovered from.
fn recovered(bytes: &[u8]) {
    let recover = |bytes: &[u8]| {
        let mut out = Vec::new();
        log::recover(&mut Cursor::new(bytes), "fuzz.mcap", &mut out, "the log", &|_| Ok(())).map(|found| (out, found))
    };
    let Ok((out, found)) = recover(bytes) else { return };
    let reading = log::read_any(Cursor::new(&out), &mut Any::default()).expect("a log");
    assert!(reading.is_whole(), "{:?}", reading.losses);
    assert_eq!(reading.messages, found.messages);
    let (_, again) = recover(&out).expect("a log");
    assert_eq!((again.messages, again.gaps), (found.messages, found.gaps));
    let mut lockstep = Lockstep::new(Cursor::new(&out), Expected::default(), &|_| Ok(())).expect("a log of our own");
    let _ = log::read_any(Cursor::new(bytes), &mut lockstep);
    let compared = lockstep.finish().expect("readable");
    assert!(compared.compared <= found.messages);
}
