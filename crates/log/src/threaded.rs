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

use foxglove::messages::log::Level;

use super::metadata::RunInfo;
use super::writer::{Writer, required_data};
use phalanx_core::trace::{Event, RequiredData, Sample, Sink, SinkError};

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
    sender: Option<SyncSender<Batch<W>>>,
    thread: Option<JoinHandle<Result<W, SinkError>>>,
    required_data: RequiredData,
    batch: Batch<W>,
    /// Written batches, returned for reuse.
    recycled: Receiver<Batch<W>>,
    last_sent: Instant,
}

/// Entries sent together. A recycled batch keeps its entries, so that samples keep their allocations.
struct Batch<W: Write> {
    entries: Vec<Entry<W>>,
    /// Number of entries in use.
    count: usize,
}

enum Entry<W: Write> {
    Sample(Sample),
    Event(Event),
    /// Any other call of the writer.
    Call(WriterCall<W>),
}

type WriterCall<W> = Box<dyn Fn(&mut Writer<W>) -> Result<(), SinkError> + Send>;

impl<W: Write> Batch<W> {
    fn empty() -> Self {
        Batch { entries: Vec::new(), count: 0 }
    }

    fn push(&mut self, entry: Entry<W>) {
        self.entries.truncate(self.count);
        self.entries.push(entry);
        self.count += 1;
    }

    fn push_sample(&mut self, sample: &Sample) {
        match self.entries.get_mut(self.count) {
            Some(Entry::Sample(slot)) => {
                slot.clone_from(sample);
                self.count += 1;
            }
            _ => self.push(Entry::Sample(sample.clone())),
        }
    }

    fn write(&self, writer: &mut Writer<W>) -> Result<(), SinkError> {
        self.entries[..self.count].iter().try_for_each(|entry| match entry {
            Entry::Sample(sample) => writer.sample(sample),
            Entry::Event(event) => writer.event(event),
            Entry::Call(call) => call(writer),
        })
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
        on_start_failure: impl FnOnce() + Send + 'static,
    ) -> Result<Self, SinkError> {
        let (sender, receiver) = sync_channel::<Batch<W>>(MAX_QUEUED_BATCHES);
        let (recycle, recycled) = channel();
        let (scene, scene_file, model) = (run.scene.clone(), run.scene_file.to_string(), run.model.to_string());
        let log_name = name.to_string();
        let write_log = move || {
            let run = RunInfo { scene: &scene, scene_file: &scene_file, model: &model };
            let mut writer = Writer::new(out, &log_name, &run).inspect_err(|_| on_start_failure())?;
            for mut batch in receiver {
                batch.write(&mut writer)?;
                batch.count = 0;
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
            required_data: required_data(&run.scene.log),
            batch: Batch::empty(),
            recycled,
            last_sent: Instant::now(),
        })
    }

    /// Writes a line to `/events`, for example how the run ended; `source` names its subject.
    pub fn note(&mut self, time_s: f64, severity: Level, source: &'static str, text: &str) -> Result<(), SinkError> {
        let text = text.to_string();
        self.batch.push(Entry::Call(Box::new(move |writer| writer.note(time_s, severity, source, &text))));
        self.send_full_batch()
    }

    /// Writes a metadata record about the whole run.
    pub fn record(&mut self, name: &'static str, entries: BTreeMap<String, String>) -> Result<(), SinkError> {
        self.batch.push(Entry::Call(Box::new(move |writer| writer.record(name, entries.clone()))));
        self.send_full_batch()
    }

    /// Finishes the log (last chunk, index, footer), flushes it and returns the underlying output.
    pub fn finish(mut self) -> Result<W, SinkError> {
        self.shut_down()
    }

    fn send_full_batch(&mut self) -> Result<(), SinkError> {
        if self.batch.count < MAX_BATCH_ENTRIES && self.last_sent.elapsed() < MAX_BATCH_AGE {
            return Ok(());
        }
        self.last_sent = Instant::now();
        let next = self.recycled.try_recv().unwrap_or_else(|_| Batch::empty());
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
            let _ = sender.send(std::mem::replace(&mut self.batch, Batch::empty()));
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
    fn required_data(&self) -> RequiredData {
        self.required_data
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.batch.push_sample(sample);
        self.send_full_batch()
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.batch.push(Entry::Event(*event));
        self.send_full_batch()
    }
}
