//! Reader of the log of the new run, message by message. This file was just written by phalanx and is trusted.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{self, Read};

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::super::reader::{ChannelRecord, MessageRecord, SchemaRecord, channel, message, metadata, schema};
use crate::schema::{current_data, current_name};
use crate::{MAX_RECORD_BYTES, METADATA_NAME};

/// An owned schema.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schema {
    pub name: String,
    pub encoding: String,
    pub data: Vec<u8>,
}

/// An owned channel with its schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    pub topic: String,
    pub encoding: String,
    pub metadata: BTreeMap<String, String>,
    pub schema: Schema,
}

/// Schemas and channels read so far.
#[derive(Clone, Debug, Default)]
pub struct Definitions {
    schemas: HashMap<u16, Schema>,
    pub channels: HashMap<u16, Channel>,
}

impl Definitions {
    pub fn schema(&mut self, found: &SchemaRecord<'_>) {
        // Older schema names do not count as a difference.
        let (name, data) = (current_name(found.name).into_owned(), current_data(found.name, found.data).into_owned());
        self.schemas.insert(found.id, Schema { name, encoding: found.encoding.to_string(), data });
    }

    pub fn channel(&mut self, found: &ChannelRecord<'_>) {
        let channel = Channel {
            topic: found.topic.to_string(),
            encoding: found.encoding.to_string(),
            metadata: found.metadata.clone(),
            schema: self.schemas.get(&found.schema).cloned().unwrap_or_default(),
        };
        self.channels.insert(found.id, channel);
    }

    pub fn topic(&self, id: u16) -> &str {
        self.channels.get(&id).map_or("", |channel| &channel.topic)
    }

    pub fn by_topic(&self, topic: &str) -> Option<&Channel> {
        self.channels.values().find(|channel| channel.topic == topic)
    }
}

/// An owned message.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Message {
    pub channel: u16,
    pub sequence: u32,
    pub log_time_ns: u64,
    pub publish_time_ns: u64,
    pub data: Vec<u8>,
}

impl From<&MessageRecord<'_>> for Message {
    fn from(found: &MessageRecord<'_>) -> Self {
        let MessageRecord { channel, sequence, log_time_ns, publish_time_ns, data } = *found;
        Message { channel, sequence, log_time_ns, publish_time_ns, data: data.to_vec() }
    }
}

/// The log of the new run.
pub struct RerunLog<R> {
    source: R,
    record_reader: LinearReader,
    pub definitions: Definitions,
    pub metadata: BTreeMap<String, String>,
    /// Channels that have messages.
    pub active_channels: HashSet<u16>,
    /// The next message, already read.
    next: Option<Message>,
}

impl<R: Read> RerunLog<R> {
    /// Opens a log and reads up to the first message.
    pub fn new(source: R) -> io::Result<Self> {
        let mut rerun = RerunLog {
            source,
            record_reader: LinearReader::new_with_options(
                LinearReaderOptions::default().with_record_length_limit(MAX_RECORD_BYTES),
            ),
            definitions: Definitions::default(),
            metadata: BTreeMap::new(),
            active_channels: HashSet::new(),
            next: None,
        };
        rerun.next = rerun.read_message()?;
        Ok(rerun)
    }

    pub fn peek(&self) -> Option<&Message> {
        self.next.as_ref()
    }

    /// Returns the next message.
    pub fn next_message(&mut self) -> io::Result<Option<Message>> {
        let following = if self.next.is_some() { self.read_message()? } else { None };
        Ok(std::mem::replace(&mut self.next, following))
    }

    fn read_message(&mut self) -> io::Result<Option<Message>> {
        let invalid_log =
            |detail: &dyn std::fmt::Display| io::Error::other(format!("the log of the new run: {detail}"));
        while let Some(event) = self.record_reader.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(requested)) => {
                    let count = self.source.read(self.record_reader.insert(requested))?;
                    self.record_reader.notify_read(count);
                }
                Ok(LinearReadEvent::Record { opcode, data }) => match opcode {
                    op::SCHEMA => self.definitions.schema(&schema(data).map_err(|error| invalid_log(&error))?),
                    op::CHANNEL => self.definitions.channel(&channel(data).map_err(|error| invalid_log(&error))?),
                    op::METADATA => {
                        if let Ok((METADATA_NAME, entries)) = metadata(data) {
                            self.metadata = entries;
                        }
                    }
                    op::MESSAGE => {
                        let found = message(data).map_err(|error| invalid_log(&error))?;
                        self.active_channels.insert(found.channel);
                        return Ok(Some(Message::from(&found)));
                    }
                    op::DATA_END => return Ok(None),
                    _ => {}
                },
                Err(McapError::Io(error)) => return Err(error),
                Err(error) => return Err(invalid_log(&error)),
            }
        }
        Ok(None)
    }
}
