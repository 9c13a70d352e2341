//! What a log consists of, as it stands in the file, and who takes it.

use std::collections::BTreeMap;

use crate::trace::bodies::{BodiesEvent, BodiesSample};
use crate::trace::{Event, Recording, Sample, Sink, SinkError};

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

/// The discs and pairs of a log, in the order of its samples.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    pub discs: Vec<String>,
    pub pairs: Vec<String>,
}

/// Takes what a log says, of whichever kind of scene it is, in the order of the log.
pub trait LogSink {
    /// A sample of a finger.
    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        Ok(())
    }

    /// An event of a finger.
    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }

    /// What the discs and pairs are called: once, before the first sample or event of discs.
    fn names(&mut self, _: &Names) -> Result<(), SinkError> {
        Ok(())
    }

    fn discs(&mut self, _: &BodiesSample) -> Result<(), SinkError> {
        Ok(())
    }

    /// An event of discs; its pair is one of [`Names::pairs`].
    fn discs_event(&mut self, _: &BodiesEvent) -> Result<(), SinkError> {
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

/// Keeps what a log of a finger says; one of discs leaves it as it is.
impl LogSink for Recording {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        Sink::sample(self, sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        Sink::<Sample>::event(self, event)
    }
}

/// Keeps what a log of discs says, under the names that the log has for them.
impl LogSink for Recording<BodiesEvent> {
    fn names(&mut self, names: &Names) -> Result<(), SinkError> {
        *self = Recording::named(&names.discs, &names.pairs);
        Ok(())
    }

    fn discs(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        Sink::sample(self, sample)
    }

    fn discs_event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        Sink::<BodiesSample>::event(self, event)
    }
}

/// A sink of samples of fingers only.
pub(super) struct Fingers<'a, S>(pub &'a mut S);

impl<S: Sink> LogSink for Fingers<'_, S> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.0.event(event)
    }
}
