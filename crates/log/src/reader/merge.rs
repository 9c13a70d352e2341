//! Merges the messages of a log by log time; messages of one log time stay in file order. Only segments that overlap in
//! time are in memory: one or two chunks of a log in order, one per topic of a log sorted by topic.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::io::{Read, Seek};

use mcap::records::op;

use super::bytes::{self, Cursor, MalformedData};
use super::summary::ReadError;
use super::survey::Segment;

/// Maximum bytes of segments in memory.
const MAX_OPEN_BYTES: usize = 1 << 29;

/// A segment in memory.
#[derive(Default)]
struct OpenSegment {
    segment: usize,
    records: Vec<u8>,
    /// Log time, start and end of every message, in order.
    messages: Vec<(u64, usize, usize)>,
    next: usize,
}

/// How to continue after a message.
pub enum MergeControl {
    Continue,
    /// The rest of the segment is not usable.
    SkipSegment,
    Stop,
}

/// Calls `handle` with the body of every message, in order of log time.
///
/// # Errors
/// Returns [`ReadError::OutOfOrder`] if too many segments overlap in time, or an error of `handle`.
pub fn merge(
    source: &mut (impl Read + Seek),
    segments: &[Segment],
    mut handle: impl FnMut(&Segment, &[u8]) -> Result<MergeControl, ReadError>,
) -> Result<(), ReadError> {
    let mut order: Vec<usize> = (0..segments.len()).collect();
    order.sort_by_key(|&index| (segments[index].start_ns, segments[index].offset));
    let mut pending = order.into_iter().peekable();
    let (mut open, mut free_slots, mut open_bytes): (Vec<OpenSegment>, Vec<usize>, usize) = (Vec::new(), Vec::new(), 0);
    let mut file_bytes = Vec::new();
    // Ordered by log time, then by position in the file.
    let mut queue: BinaryHeap<Reverse<(u64, u64, usize)>> = BinaryHeap::new();
    loop {
        let now_ns = queue.peek().map(|Reverse((time_ns, ..))| *time_ns);
        if let Some(index) = pending.next_if(|&index| now_ns.is_none_or(|now_ns| segments[index].start_ns <= now_ns)) {
            let slot = free_slots.pop().unwrap_or_else(|| {
                open.push(OpenSegment::default());
                open.len() - 1
            });
            let open_segment = &mut open[slot];
            open_segment.load(source, segments, index, &mut file_bytes)?;
            open_bytes += open_segment.records.len();
            if open_bytes > MAX_OPEN_BYTES {
                return Err(ReadError::OutOfOrder { limit_mib: MAX_OPEN_BYTES >> 20 });
            }
            queue.push(Reverse((open_segment.messages[0].0, segments[index].offset, slot)));
            continue;
        }
        let Some(Reverse((_, offset, slot))) = queue.pop() else { return Ok(()) };
        let current = &mut open[slot];
        let (_, from, to) = current.messages[current.next];
        match handle(&segments[current.segment], &current.records[from..to])? {
            MergeControl::Continue => current.next += 1,
            MergeControl::SkipSegment => current.next = current.messages.len(),
            MergeControl::Stop => return Ok(()),
        }
        match current.messages.get(current.next) {
            Some(message) => queue.push(Reverse((message.0, offset, slot))),
            None => {
                open_bytes -= current.records.len();
                free_slots.push(slot);
            }
        }
    }
}

impl OpenSegment {
    fn load(
        &mut self,
        source: &mut (impl Read + Seek),
        segments: &[Segment],
        index: usize,
        file_bytes: &mut Vec<u8>,
    ) -> Result<(), ReadError> {
        segments[index].load(source, file_bytes, &mut self.records)?;
        (self.segment, self.next) = (index, 0);
        self.messages.clear();
        let mut cursor = Cursor::new(&self.records);
        while !cursor.is_empty() {
            let (opcode, data) = cursor.record().map_err(file_changed_error)?;
            if opcode == op::MESSAGE {
                let end = self.records.len() - cursor.remaining().len();
                let log_time_ns = bytes::message(data).map_err(file_changed_error)?.log_time_ns;
                self.messages.push((log_time_ns, end - data.len(), end));
            }
        }
        if !self.messages.is_sorted_by_key(|message| message.0) {
            self.messages.sort_by_key(|message| message.0);
        }
        match self.messages.is_empty() {
            true => Err(file_changed_error(MalformedData("no message"))),
            false => Ok(()),
        }
    }
}

/// Error for data that was valid in the first pass.
fn file_changed_error(_: MalformedData) -> ReadError {
    ReadError::Io(std::io::Error::other("the log changes while it is read"))
}
