//! Random faults, and what must hold of a log after them: what is read is a prefix of what was written.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use phalanx::log::{self, ReadError, Reading};
use phalanx::trace::{Event, Sample, Sink, SinkError};

/// Everything a log gives.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    Sample(Box<Sample>),
    Event(Event),
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Items(pub Vec<Item>);

impl Sink for Items {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.push(Item::Sample(Box::new(sample.clone())));
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.0.push(Item::Event(*event));
        Ok(())
    }
}

impl Items {
    pub fn samples(&self) -> usize {
        self.0.iter().filter(|item| matches!(item, Item::Sample(_))).count()
    }

    /// Whether this is the beginning of `whole`, figure by figure.
    #[track_caller]
    pub fn assert_prefix_of(&self, whole: &Items, what: &str) {
        assert!(self.0.len() <= whole.0.len(), "{what}: {} items of {}", self.0.len(), whole.0.len());
        for (index, (found, written)) in self.0.iter().zip(&whole.0).enumerate() {
            assert_eq!(found, written, "{what}: item {index}");
        }
    }
}

pub fn read_bytes(bytes: &[u8]) -> (Result<Reading, ReadError>, Items) {
    let mut items = Items::default();
    (log::read(Cursor::new(bytes), &mut items), items)
}

pub fn read_path(path: &Path) -> (Reading, Items) {
    let mut items = Items::default();
    let reading = log::read_file(path, &mut items).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    (reading, items)
}

/// Numbers without a pattern, the same every time (xorshift64*).
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Dice(seed | 1)
    }

    pub fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % limit
    }
}

/// A scene whose run takes a while and fills chunk after chunk: a long hold on a fine grid.
pub fn long_hold(directory: &Path, duration: &str, rate: &str) -> String {
    let text = fs::read_to_string("scenes/experiment-95.toml").expect("the anchor scene");
    let path = directory.join("hold.toml");
    let text = format!("duration = \"{duration}\"\n{text}\n[log]\nnumeric_rate = \"{rate}\"\n");
    fs::write(&path, text).expect("written");
    path.to_str().expect("a path of plain text").to_string()
}
