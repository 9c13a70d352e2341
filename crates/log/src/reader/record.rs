//! What a log consists of, as it stands in the file, and who takes it.

use std::collections::BTreeMap;

use phalanx_core::trace::{Event, Layout, Recording, Sample, Sink, SinkError};

/// One record of a log. The bytes are those of the file.
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

/// Takes what a log says, of whichever kind of scene it is, in the order of the log.
pub trait LogSink {
    /// What the samples consist of: once, before the first sample or event.
    fn layout(&mut self, _: &Layout) -> Result<(), SinkError> {
        Ok(())
    }

    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        Ok(())
    }

    /// An event; its contact is one of the layout.
    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }

    /// What follows was found behind a damage: something may be missing in between. Only
    /// [`read_pieces`](super::read_pieces) says so.
    fn piece(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    /// Every record that was understood, before what it comes to.
    fn record(&mut self, _: &Record<'_>) -> Result<(), SinkError> {
        Ok(())
    }
}

impl LogSink for () {}

/// Keeps what a log says, in the place of what was there.
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

/// A sink of samples that have a finger; nothing else is passed on.
pub(super) struct Fingers<'a, S> {
    pub sink: &'a mut S,
    pub are_there: bool,
}

impl<S: Sink> LogSink for Fingers<'_, S> {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.are_there = layout.fingers.len() == 1;
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if self.are_there { self.sink.sample(sample) } else { Ok(()) }
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if self.are_there { self.sink.event(event) } else { Ok(()) }
    }
}
