//! The messages of a log in order of their log time; those of one log time in the order of the file. Held is what overlaps in time: of
//! a log in order a chunk or two, of one that is sorted by topic one for each topic.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::io::{Read, Seek};

use mcap::records::op;

use super::bytes::{self, Cursor, Malformed};
use super::reading::ReadError;
use super::survey::Segment;

/// Bytes of segments that are held at once.
const MOST_HELD: usize = 1 << 29;

/// A segment that is being read.
#[derive(Default)]
struct Open {
    segment: usize,
    records: Vec<u8>,
    /// Log time and place of every message, in order.
    places: Vec<(u64, usize, usize)>,
    next: usize,
}

/// What became of a message.
pub enum Taken {
    Next,
    /// It, and what follows in its segment, is of no use.
    LeaveSegment,
    Stop,
}

/// Hands the body of every message to `take`.
pub fn merge(
    source: &mut (impl Read + Seek),
    segments: &[Segment],
    mut take: impl FnMut(&Segment, &[u8]) -> Result<Taken, ReadError>,
) -> Result<(), ReadError> {
    let mut order: Vec<usize> = (0..segments.len()).collect();
    order.sort_by_key(|&index| (segments[index].start_ns, segments[index].at));
    let mut waiting = order.into_iter().peekable();
    let (mut open, mut free, mut held): (Vec<Open>, Vec<usize>, usize) = (Vec::new(), Vec::new(), 0);
    let mut raw = Vec::new();
    // By log time, then by place in the file.
    let mut due: BinaryHeap<Reverse<(u64, u64, usize)>> = BinaryHeap::new();
    loop {
        let now_ns = due.peek().map(|Reverse((time_ns, ..))| *time_ns);
        if let Some(index) = waiting.next_if(|&index| now_ns.is_none_or(|now_ns| segments[index].start_ns <= now_ns)) {
            let slot = free.pop().unwrap_or_else(|| {
                open.push(Open::default());
                open.len() - 1
            });
            let begun = &mut open[slot];
            begun.load(source, segments, index, &mut raw)?;
            held += begun.records.len();
            if held > MOST_HELD {
                return Err(ReadError::OutOfOrder { most_mib: MOST_HELD >> 20 });
            }
            due.push(Reverse((begun.places[0].0, segments[index].at, slot)));
            continue;
        }
        let Some(Reverse((_, at, slot))) = due.pop() else { return Ok(()) };
        let reading = &mut open[slot];
        let (_, from, to) = reading.places[reading.next];
        match take(&segments[reading.segment], &reading.records[from..to])? {
            Taken::Next => reading.next += 1,
            Taken::LeaveSegment => reading.next = reading.places.len(),
            Taken::Stop => return Ok(()),
        }
        match reading.places.get(reading.next) {
            Some(place) => due.push(Reverse((place.0, at, slot))),
            None => {
                held -= reading.records.len();
                free.push(slot);
            }
        }
    }
}

impl Open {
    fn load(
        &mut self,
        source: &mut (impl Read + Seek),
        segments: &[Segment],
        index: usize,
        raw: &mut Vec<u8>,
    ) -> Result<(), ReadError> {
        segments[index].load(source, raw, &mut self.records)?;
        (self.segment, self.next) = (index, 0);
        self.places.clear();
        let mut cursor = Cursor::new(&self.records);
        while !cursor.is_empty() {
            let (opcode, data) = cursor.record().map_err(changed)?;
            if opcode == op::MESSAGE {
                let end = self.records.len() - cursor.rest().len();
                let log_time_ns = bytes::message(data).map_err(changed)?.log_time_ns;
                self.places.push((log_time_ns, end - data.len(), end));
            }
        }
        if !self.places.is_sorted_by_key(|place| place.0) {
            self.places.sort_by_key(|place| place.0);
        }
        match self.places.is_empty() {
            true => Err(changed(Malformed("no message"))),
            false => Ok(()),
        }
    }
}

/// The first pass has found no fault with it.
fn changed(_: Malformed) -> ReadError {
    ReadError::Io(std::io::Error::other("the log changes while it is read"))
}
