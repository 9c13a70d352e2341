//! Log writer on a separate thread, because encoding and compression take a large part of the run time. The content and
//! order of the log do not depend on the speed of either thread.
//!
//! The thread creates the writer itself and returns emptied batches: memory that one thread allocates and the other
//! frees causes contention in the allocator.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use super::mcap_writer::{MessageFeed, Severity};
use super::metadata::RunInfo;
use super::writer::Writer;
use phalanx_core::trace::{Event, Sample, Sink, SinkError};

/// A batch is sent when it has this many entries.
const MAX_BATCH_ENTRIES: usize = 64;
/// A smaller batch is sent when it reaches this age, so that a growing log can be read.
const MAX_BATCH_AGE: Duration = Duration::from_millis(100);
/// Capacity of the queue; the simulation blocks when it is full.
const MAX_QUEUED_BATCHES: usize = 32;

/// Log writer that encodes and writes on a separate thread.
///
/// A write error is returned by a later call or by [`ThreadedWriter::finish`]. Dropping the writer also finishes the
/// log but discards errors.
pub struct ThreadedWriter<W: Write + Send + 'static> {
    /// Queue to the writing thread; `None` after shutdown has begun.
    sender: Option<SyncSender<Batch>>,
    thread: Option<JoinHandle<Result<W, SinkError>>>,
    batch: Batch,
    /// Written batches, returned for reuse.
    recycled: Receiver<Batch>,
    last_sent: Instant,
}

/// Entries sent together. Samples are stored separately so that a recycled batch keeps their allocations.
#[derive(Default)]
struct Batch {
    entries: Vec<Entry>,
    samples: Vec<Sample>,
    /// Number of `samples` in use by this batch.
    sample_count: usize,
}

enum Entry {
    /// The next element of `samples`.
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
    fn push_sample(&mut self, sample: &Sample) {
        match self.samples.get_mut(self.sample_count) {
            Some(slot) => slot.clone_from(sample),
            None => self.samples.push(sample.clone()),
        }
        self.sample_count += 1;
    }

    /// Writes and removes all entries.
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
        self.sample_count = 0;
        Ok(())
    }
}

impl<W: Write + Send + 'static> ThreadedWriter<W> {
    /// Starts the writer thread. `name` identifies the log in errors. `on_start_failure` is called if the head of the
    /// log cannot be written.
    ///
    /// # Errors
    /// Returns an error if the thread cannot be created.
    pub fn start(
        out: W,
        name: &str,
        run: &RunInfo<'_>,
        feed: Option<Box<dyn MessageFeed>>,
        on_start_failure: impl FnOnce() + Send + 'static,
    ) -> Result<Self, SinkError> {
        let (sender, receiver) = sync_channel::<Batch>(MAX_QUEUED_BATCHES);
        let (recycle, recycled) = channel();
        let (scene, scene_file, model) = (run.scene.clone(), run.scene_file.to_string(), run.model.to_string());
        let log_name = name.to_string();
        let write_log = move || {
            let run = RunInfo { scene: &scene, scene_file: &scene_file, model: &model };
            let mut writer = Writer::with_feed(out, &log_name, &run, feed).inspect_err(|_| on_start_failure())?;
            for mut batch in receiver {
                batch.write(&mut writer)?;
                // Fails only after the run is over, when no batch is needed.
                let _ = recycle.send(batch);
            }
            writer.finish()
        };
        let thread = Builder::new().name("log".to_string()).spawn(write_log);
        let thread = thread.map_err(|source| SinkError { target: name.to_string(), source })?;
        Ok(ThreadedWriter {
            sender: Some(sender),
            thread: Some(thread),
            batch: Batch::default(),
            recycled,
            last_sent: Instant::now(),
        })
    }

    /// Writes a line to `/events`, for example how the run ended; `source` names its subject.
    pub fn note(&mut self, time_s: f64, severity: Severity, source: &'static str, text: &str) -> Result<(), SinkError> {
        self.enqueue(Entry::Note { time_s, severity, source, text: text.to_string() })
    }

    /// Writes a metadata record about the whole run.
    pub fn record(&mut self, name: &'static str, entries: BTreeMap<String, String>) -> Result<(), SinkError> {
        self.enqueue(Entry::Record { name, entries })
    }

    /// Finishes the log (last chunk, index, footer), flushes it and returns the underlying output.
    pub fn finish(mut self) -> Result<W, SinkError> {
        self.shut_down()
    }

    fn enqueue(&mut self, entry: Entry) -> Result<(), SinkError> {
        self.batch.entries.push(entry);
        if self.batch.entries.len() >= MAX_BATCH_ENTRIES || self.last_sent.elapsed() >= MAX_BATCH_AGE {
            self.send_batch()?;
        }
        Ok(())
    }

    fn send_batch(&mut self) -> Result<(), SinkError> {
        self.last_sent = Instant::now();
        let next = self.recycled.try_recv().unwrap_or_default();
        let batch = std::mem::replace(&mut self.batch, next);
        match &self.sender {
            Some(sender) if sender.send(batch).is_ok() => Ok(()),
            // The thread has ended early; joining it returns its error.
            _ => self.shut_down().map(drop),
        }
    }

    /// Sends the last batch and waits until everything is written.
    fn shut_down(&mut self) -> Result<W, SinkError> {
        if let Some(sender) = self.sender.take() {
            let _ = sender.send(std::mem::take(&mut self.batch));
        }
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => {
                Err(SinkError { target: "the log".to_string(), source: io::Error::other("an earlier write failed") })
            }
        }
    }
}

impl<W: Write + Send + 'static> Drop for ThreadedWriter<W> {
    fn drop(&mut self) {
        if self.thread.is_some() {
            let _ = self.shut_down();
        }
    }
}

impl<W: Write + Send + 'static> Sink for ThreadedWriter<W> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.batch.push_sample(sample);
        self.enqueue(Entry::Sample)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.enqueue(Entry::Event(*event))
    }
}
