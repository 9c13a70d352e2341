//! A log that is written beside the simulation, on a thread of its own: encoding and compressing takes a good part of the
//! time of a run. What is written, and in which order, does not depend on either thread's pace.
//!
//! The thread makes the writer itself, and hands batches back empty: what one thread allocates and the other frees makes
//! both wait for the allocator.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant as Clock};

use super::core::{Feed, Severity};
use super::metadata::RunInfo;
use super::writer::Writer;
use phalanx_core::trace::{Event, Sample, Sink, SinkError};

/// Entries that are handed over at once…
const BATCH: usize = 64;
/// …or after this time: a log can be read while it grows.
const PATIENCE: Duration = Duration::from_millis(100);
/// Batches that may wait; then the simulation does.
const WAITING: usize = 32;

/// A log that is written on a thread of its own.
///
/// An error comes out of a later call, or of [`Beside::finish`]. Dropping one finishes the log too, but swallows errors.
pub struct Beside<W: Write + Send + 'static> {
    /// `None` once the thread has been told to end.
    sender: Option<SyncSender<Batch>>,
    thread: Option<JoinHandle<Result<W, SinkError>>>,
    batch: Batch,
    /// Batches that have been written, to be filled again.
    empty: Receiver<Batch>,
    handed_over: Clock,
}

/// What is handed over at once. Samples stand apart, so that a batch that comes back has the room that they take.
#[derive(Default)]
struct Batch {
    entries: Vec<Entry>,
    samples: Vec<Sample>,
    /// How many of the samples are of this batch.
    filled: usize,
}

enum Entry {
    /// The next of the samples.
    Sample,
    Event(Event),
    Note {
        time_s: f64,
        severity: Severity,
        source: &'static str,
        text: String,
    },
    Record {
        name: &'static str,
        entries: BTreeMap<String, String>,
    },
}

impl Batch {
    fn put(&mut self, sample: &Sample) {
        match self.samples.get_mut(self.filled) {
            Some(room) => room.clone_from(sample),
            None => self.samples.push(sample.clone()),
        }
        self.filled += 1;
    }

    /// Writes everything, and is empty then.
    fn write<W: Write>(&mut self, writer: &mut Writer<W>) -> Result<(), SinkError> {
        let mut samples = self.samples.iter();
        for entry in self.entries.drain(..) {
            match entry {
                Entry::Sample => samples.next().map_or(Ok(()), |sample| writer.sample(sample))?,
                Entry::Event(event) => writer.event(&event)?,
                Entry::Note { time_s, severity, source, text } => writer.note(time_s, severity, source, &text)?,
                Entry::Record { name, entries } => writer.record(name, entries)?,
            }
        }
        self.filled = 0;
        Ok(())
    }
}

impl<W: Write + Send + 'static> Beside<W> {
    /// Starts a log on a thread of its own; `name` is what errors call it. `unstarted` is called if not even its beginning can
    /// be written.
    ///
    /// # Errors
    /// If there is no thread to be had.
    pub fn start(
        out: W,
        name: &str,
        run: &RunInfo<'_>,
        feed: Option<Box<dyn Feed>>,
        unstarted: impl FnOnce() + Send + 'static,
    ) -> Result<Self, SinkError> {
        let (sender, receiver) = sync_channel::<Batch>(WAITING);
        let (written, empty) = channel();
        let (scene, scene_file, model) = (run.scene.clone(), run.scene_file.to_string(), run.model.to_string());
        let called = name.to_string();
        let work = move || {
            let run = RunInfo { scene: &scene, scene_file: &scene_file, model: &model };
            let mut writer = Writer::with_feed(out, &called, &run, feed).inspect_err(|_| unstarted())?;
            for mut batch in receiver {
                batch.write(&mut writer)?;
                // Nobody waits for it once the run is over.
                let _ = written.send(batch);
            }
            writer.finish()
        };
        let thread = Builder::new().name("log".to_string()).spawn(work);
        let thread = thread.map_err(|source| SinkError { what: name.to_string(), source })?;
        Ok(Beside {
            sender: Some(sender),
            thread: Some(thread),
            batch: Batch::default(),
            empty,
            handed_over: Clock::now(),
        })
    }

    /// Writes a line to `/events`, for instance how the run ended; `source` is what it is about.
    pub fn note(&mut self, time_s: f64, severity: Severity, source: &'static str, text: &str) -> Result<(), SinkError> {
        self.take(Entry::Note { time_s, severity, source, text: text.to_string() })
    }

    /// Writes a metadata record: what is known of the run as a whole.
    pub fn record(&mut self, name: &'static str, entries: BTreeMap<String, String>) -> Result<(), SinkError> {
        self.take(Entry::Record { name, entries })
    }

    /// Finishes the log (last chunk, index, footer), flushes it, and hands back what it was written to.
    pub fn finish(mut self) -> Result<W, SinkError> {
        self.end()
    }

    fn take(&mut self, entry: Entry) -> Result<(), SinkError> {
        self.batch.entries.push(entry);
        if self.batch.entries.len() >= BATCH || self.handed_over.elapsed() >= PATIENCE {
            self.hand_over()?;
        }
        Ok(())
    }

    fn hand_over(&mut self) -> Result<(), SinkError> {
        self.handed_over = Clock::now();
        let next = self.empty.try_recv().unwrap_or_default();
        let batch = std::mem::replace(&mut self.batch, next);
        match &self.sender {
            Some(sender) if sender.send(batch).is_ok() => Ok(()),
            // The thread has ended before its time: it says why.
            _ => self.end().map(drop),
        }
    }

    /// Waits until everything is written.
    fn end(&mut self) -> Result<W, SinkError> {
        if let Some(sender) = self.sender.take() {
            let _ = sender.send(std::mem::take(&mut self.batch));
        }
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Err(SinkError {
                what: "the log".to_string(),
                source: io::Error::other("an earlier part of it could not be written"),
            }),
        }
    }
}

impl<W: Write + Send + 'static> Drop for Beside<W> {
    fn drop(&mut self) {
        if self.thread.is_some() {
            let _ = self.end();
        }
    }
}

impl<W: Write + Send + 'static> Sink for Beside<W> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.batch.put(sample);
        self.take(Entry::Sample)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.take(Entry::Event(*event))
    }
}
