//! The log of the run that was simulated again, message by message: a file of our own, which is taken at its word.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{self, Read};

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::super::reader::{ChannelRecord, MessageRecord, SchemaRecord, channel, message, metadata, schema};
use crate::schema::{current_data, current_name};
use crate::{LARGEST_RECORD, METADATA_NAME};

/// A schema, owned.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schema {
    pub name: String,
    pub encoding: String,
    pub data: Vec<u8>,
}

/// A channel with its schema, owned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    pub topic: String,
    pub encoding: String,
    pub metadata: BTreeMap<String, String>,
    pub schema: Schema,
}

/// Schemas and channels that have been announced.
#[derive(Clone, Debug, Default)]
pub struct Announced {
    schemas: HashMap<u16, Schema>,
    pub channels: HashMap<u16, Channel>,
}

impl Announced {
    pub fn schema(&mut self, found: &SchemaRecord<'_>) {
        // What a schema was once called is no difference of two runs.
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

/// A message, owned.
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

/// Goes through a log of our own.
pub struct Again<R> {
    source: R,
    framing: LinearReader,
    pub announced: Announced,
    pub metadata: BTreeMap<String, String>,
    /// Channels that have messages.
    pub spoken: HashSet<u16>,
    /// The next message, looked at already.
    next: Option<Message>,
}

impl<R: Read> Again<R> {
    /// Reads up to the first message.
    pub fn new(source: R) -> io::Result<Self> {
        let mut again = Again {
            source,
            framing: LinearReader::new_with_options(
                LinearReaderOptions::default().with_record_length_limit(LARGEST_RECORD),
            ),
            announced: Announced::default(),
            metadata: BTreeMap::new(),
            spoken: HashSet::new(),
            next: None,
        };
        again.next = again.read()?;
        Ok(again)
    }

    pub fn peek(&self) -> Option<&Message> {
        self.next.as_ref()
    }

    /// The next message.
    pub fn take(&mut self) -> io::Result<Option<Message>> {
        let following = if self.next.is_some() { self.read()? } else { None };
        Ok(std::mem::replace(&mut self.next, following))
    }

    fn read(&mut self) -> io::Result<Option<Message>> {
        let broken = |what: &dyn std::fmt::Display| io::Error::other(format!("the log of the new run: {what}"));
        while let Some(event) = self.framing.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(need)) => {
                    let count = self.source.read(self.framing.insert(need))?;
                    self.framing.notify_read(count);
                }
                Ok(LinearReadEvent::Record { opcode, data }) => match opcode {
                    op::SCHEMA => self.announced.schema(&schema(data).map_err(|error| broken(&error))?),
                    op::CHANNEL => self.announced.channel(&channel(data).map_err(|error| broken(&error))?),
                    op::METADATA => {
                        if let Ok((METADATA_NAME, entries)) = metadata(data) {
                            self.metadata = entries;
                        }
                    }
                    op::MESSAGE => {
                        let found = message(data).map_err(|error| broken(&error))?;
                        self.spoken.insert(found.channel);
                        return Ok(Some(Message::from(&found)));
                    }
                    op::DATA_END => return Ok(None),
                    _ => {}
                },
                Err(McapError::Io(error)) => return Err(error),
                Err(error) => return Err(broken(&error)),
            }
        }
        Ok(None)
    }
}
