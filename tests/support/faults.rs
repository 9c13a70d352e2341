//! Fault injection for logs. Invariant: the items read from a damaged log are a prefix of the items written.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use phalanx::log::{self, LogSink, LogSummary, ReadError};
use phalanx::trace::{Event, Sample, SinkError};

/// An item read from a log.
#[derive(Clone, Debug, PartialEq)]
pub enum LogItem {
    Sample(Box<Sample>),
    Event(Event),
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogItems(pub Vec<LogItem>);

impl LogSink for LogItems {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.push(LogItem::Sample(Box::new(sample.clone())));
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.0.push(LogItem::Event(*event));
        Ok(())
    }
}

impl LogItems {
    pub fn sample_count(&self) -> usize {
        self.0.iter().filter(|item| matches!(item, LogItem::Sample(_))).count()
    }

    /// Asserts that these items equal the first items of `whole`, bit for bit.
    #[track_caller]
    pub fn assert_prefix_of(&self, whole: &LogItems, context: &str) {
        assert!(self.0.len() <= whole.0.len(), "{context}: {} items of {}", self.0.len(), whole.0.len());
        for (index, (actual, written)) in self.0.iter().zip(&whole.0).enumerate() {
            assert_eq!(actual, written, "{context}: item {index}");
        }
    }
}

pub fn read_bytes(bytes: &[u8]) -> (Result<LogSummary, ReadError>, LogItems) {
    let mut items = LogItems::default();
    (log::read(Cursor::new(bytes), &mut items), items)
}

pub fn read_path(path: &Path) -> (LogSummary, LogItems) {
    let mut items = LogItems::default();
    let summary = log::read_file(path, &mut items).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    (summary, items)
}

/// Reproducible pseudo-random numbers (xorshift64*).
pub struct XorShift(u64);

impl XorShift {
    pub fn new(seed: u64) -> Self {
        XorShift(seed | 1)
    }

    pub fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % limit
    }
}

/// Writes a scene with a long hold and a fine log grid, whose run is slow and fills many chunks; returns its path.
pub fn write_long_hold_scene(directory: &Path, duration: &str, rate: &str) -> String {
    let text = fs::read_to_string("scenes/experiment-95.toml").expect("the scene of experiment 95");
    let path = directory.join("hold.toml");
    let text = format!("duration = \"{duration}\"\n{text}\n[log]\nnumeric_rate = \"{rate}\"\n");
    fs::write(&path, text).expect("written");
    path.to_str().expect("a path of plain text").to_string()
}
