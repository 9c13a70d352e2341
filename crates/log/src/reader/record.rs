//! Records of a log and sinks for its contents.

use std::collections::BTreeMap;

use phalanx_core::trace::{Event, Layout, Recording, Sample, Sink, SinkError};

/// A record of a log, borrowed from the bytes of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Record<'a> {
    Metadata { name: &'a str, entries: &'a BTreeMap<String, String> },
    Attachment(AttachmentRecord<'a>),
    Schema(SchemaRecord<'a>),
    Channel(ChannelRecord<'a>),
    Message(MessageRecord<'a>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AttachmentRecord<'a> {
    pub log_time_ns: u64,
    pub create_time_ns: u64,
    pub name: &'a str,
    pub media_type: &'a str,
    pub data: &'a [u8],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SchemaRecord<'a> {
    pub id: u16,
    pub name: &'a str,
    pub encoding: &'a str,
    pub data: &'a [u8],
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelRecord<'a> {
    pub id: u16,
    pub schema: u16,
    pub topic: &'a str,
    pub encoding: &'a str,
    pub metadata: BTreeMap<String, String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageRecord<'a> {
    pub channel: u16,
    pub sequence: u32,
    pub log_time_ns: u64,
    pub publish_time_ns: u64,
    pub data: &'a [u8],
}

/// Receiver of the contents of a log of any kind of scene, in the order of the log.
pub trait LogSink {
    /// Receives the layout of the samples; called once, before the first sample or event.
    fn layout(&mut self, _: &Layout) -> Result<(), SinkError> {
        Ok(())
    }

    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        Ok(())
    }

    /// Receives an event; its contact is an index into the layout.
    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }

    /// Marks a gap: the data that follows was found after damage, so data may be missing before it. Called only by
    /// [`read_past_damage`](super::read_past_damage).
    fn mark_discontinuity(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    /// Receives every valid record, before its samples and events.
    fn record(&mut self, _: &Record<'_>) -> Result<(), SinkError> {
        Ok(())
    }
}

impl LogSink for () {}

/// Replaces the recording by the contents of the log.
impl LogSink for Recording {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        *self = Recording::new(layout);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        Sink::sample(self, sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        Sink::event(self, event)
    }
}

/// Passes on samples and events only if the layout has exactly one finger.
pub(super) struct SingleFingerSink<'a, S> {
    pub sink: &'a mut S,
    pub is_single_finger: bool,
}

impl<S: Sink> LogSink for SingleFingerSink<'_, S> {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.is_single_finger = layout.fingers.len() == 1;
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if self.is_single_finger { self.sink.sample(sample) } else { Ok(()) }
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if self.is_single_finger { self.sink.event(event) } else { Ok(()) }
    }
}
