//! Logs of both kinds and both models, and logs with something changed in them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::process::Command;

use mcap::records::MessageHeader;
use phalanx::log::{LogSink, MessageRecord, Record, RunInfo, Severity, Writer, read_any};
use phalanx::scene::load_any;
use phalanx::trace::{Event, Model, Sample, Sink, SinkError, Thinned, run};

pub const FINGER: &str = "scenes/experiment-95.toml";
pub const DISCS: &str = "scenes/laws/impact.toml";

/// The log of a scene as the command writes it, with so many samples a second.
pub fn log(scene: &str, model: Model, numeric_hz: f64) -> Vec<u8> {
    // One directory for each call: tests run beside each other.
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join(scene.rsplit('/').next().expect("a name"));
    let text = fs::read_to_string(scene).expect("a scene");
    if text.contains("extends = ") {
        let beside = fs::read_dir(std::path::Path::new(scene).parent().expect("a directory")).expect("readable");
        for other in beside.map(|entry| entry.expect("readable").path()).filter(|path| path.is_file()) {
            fs::copy(&other, directory.path().join(other.file_name().expect("a name"))).expect("copied");
        }
    }
    fs::write(&file, format!("{text}\n[log]\nnumeric_rate = \"{numeric_hz} Hz\"\n")).expect("written");
    let log = directory.path().join("run.mcap");
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    let output = command.arg("run").arg(&file).args(["--model", model.name(), "--log"]).arg(&log).output();
    let output = output.expect("the binary starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read(&log).expect("the log")
}

/// The log of a run that a signal ended after so many samples.
pub fn interrupted(scene: &str, model: Model, samples: usize) -> Vec<u8> {
    struct Until<W> {
        writer: W,
        left: usize,
        last_s: f64,
    }
    impl<W: Sink> Sink for Until<W> {
        fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
            (self.left, self.last_s) = (self.left.saturating_sub(1), sample.time_s);
            self.writer.sample(sample)
        }
        fn event(&mut self, event: &Event) -> Result<(), SinkError> {
            self.writer.event(event)
        }
        fn proceed(&self) -> bool {
            self.left > 0
        }
    }
    let file = scene.rsplit('/').next().expect("a name");
    let reason = "stopped: interrupted by SIGINT (Ctrl-C)";
    let scene = load_any(scene).expect("a scene");
    let scene = &scene;
    let info = RunInfo { scene, scene_file: file, model: model.name() };
    let writer = Writer::new(Vec::new(), "the log", &info).expect("started");
    let until = Until { writer, left: samples, last_s: 0.0 };
    let mut thinned = Thinned::new(scene.log.numeric_hz, until);
    assert!(run(model, scene, &mut thinned).expect_err("stopped").is_stop());
    thinned.end().expect("written");
    let mut sink = thinned.sink;
    sink.writer.note(sink.last_s, Severity::Error, "run", reason).expect("written");
    sink.writer.finish().expect("finished")
}

/// What to do with a message.
pub enum Fate {
    Keep,
    Drop,
    Change(Vec<u8>),
}

/// Name and descriptors.
pub type Schema = (String, Vec<u8>);

/// Changes of a log that keep it a log.
pub struct Changes<'a> {
    pub metadata: &'a dyn Fn(&mut BTreeMap<String, String>),
    pub scene: &'a dyn Fn(&str) -> Option<String>,
    /// By the topic, the number of the message on it, and its payload.
    pub message: &'a dyn Fn(&str, u64, &[u8]) -> Fate,
    /// Name and descriptors of a schema.
    pub schema: &'a dyn Fn(&str, &[u8]) -> Schema,
}

impl Default for Changes<'_> {
    fn default() -> Self {
        Changes {
            metadata: &|_| {},
            scene: &|text| Some(text.to_string()),
            message: &|_, _, _| Fate::Keep,
            schema: &|name, data| (name.to_string(), data.to_vec()),
        }
    }
}

/// The log with something changed, with new checksums and a new index.
pub fn changed(bytes: &[u8], changes: &Changes<'_>) -> Vec<u8> {
    struct Copy<'a> {
        out: mcap::Writer<Cursor<Vec<u8>>>,
        changes: &'a Changes<'a>,
        topics: BTreeMap<u16, (String, u64)>,
    }
    impl LogSink for Copy<'_> {
        fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
            let out = &mut self.out;
            match record {
                Record::Metadata { name, entries } => {
                    let mut metadata = (*entries).clone();
                    (self.changes.metadata)(&mut metadata);
                    let name = name.to_string();
                    out.write_metadata(&mcap::write::Metadata { name, metadata }).expect("written");
                }
                Record::Attachment(found) => {
                    let text = std::str::from_utf8(found.data).expect("text");
                    let Some(text) = (self.changes.scene)(text) else { return Ok(()) };
                    let attachment = mcap::Attachment {
                        log_time: found.log_time_ns,
                        create_time: found.create_time_ns,
                        name: found.name.to_string(),
                        media_type: found.media_type.to_string(),
                        data: Cow::Owned(text.into_bytes()),
                    };
                    out.attach(&attachment).expect("written");
                }
                Record::Schema(found) => {
                    let (name, data) = (self.changes.schema)(found.name, found.data);
                    out.add_schema_with_id(found.id, &name, found.encoding, &data).expect("added");
                }
                Record::Channel(found) => {
                    let (id, schema) = (found.id, found.schema);
                    out.add_channel_with_id(id, schema, found.topic, found.encoding, &found.metadata).expect("added");
                    self.topics.insert(id, (found.topic.to_string(), 0));
                }
                Record::Message(found) => {
                    let MessageRecord { channel, sequence, log_time_ns, publish_time_ns, data } = *found;
                    let (topic, count) = self.topics.get_mut(&channel).expect("announced");
                    let fate = (self.changes.message)(topic, *count, data);
                    *count += 1;
                    let data = match fate {
                        Fate::Keep => data.to_vec(),
                        Fate::Drop => return Ok(()),
                        Fate::Change(data) => data,
                    };
                    let header = MessageHeader {
                        channel_id: channel,
                        sequence,
                        log_time: log_time_ns,
                        publish_time: publish_time_ns,
                    };
                    out.write_to_known_channel(&header, &data).expect("written");
                }
            }
            Ok(())
        }
    }
    let out = mcap::Writer::new(Cursor::new(Vec::new())).expect("started");
    let mut copy = Copy { out, changes, topics: BTreeMap::new() };
    read_any(Cursor::new(bytes), &mut copy).expect("a log");
    copy.out.finish().expect("finished");
    copy.out.into_inner().into_inner()
}

/// The payload with one double field moved by one unit in the last place.
pub fn one_ulp_up(payload: &[u8], field: u8) -> Vec<u8> {
    let mut bytes = payload.to_vec();
    let mut at = 0;
    loop {
        let (number, wire) = (bytes[at] >> 3, bytes[at] & 7);
        at += 1;
        match wire {
            1 if number == field => {
                let place = at..at + 8;
                let value = f64::from_le_bytes(bytes[place.clone()].try_into().expect("eight"));
                bytes[place].copy_from_slice(&value.next_up().to_le_bytes());
                return bytes;
            }
            1 => at += 8,
            0 => at += 1,
            other => panic!("wire type {other}"),
        }
    }
}

/// A message of a log with its topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    pub topic: String,
    pub channel: u16,
    pub sequence: u32,
    pub log_time_ns: u64,
    pub data: Vec<u8>,
}

/// A log taken apart, so that its messages can be written in another way.
#[derive(Default)]
pub struct Pieces {
    metadata: Vec<mcap::write::Metadata>,
    attachments: Vec<mcap::Attachment<'static>>,
    schemas: Vec<(u16, String, String, Vec<u8>)>,
    channels: Vec<(u16, u16, String, String)>,
    pub messages: Vec<Message>,
}

impl LogSink for Pieces {
    fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
        match record {
            Record::Metadata { name, entries } => {
                self.metadata.push(mcap::write::Metadata { name: name.to_string(), metadata: (*entries).clone() });
            }
            Record::Attachment(found) => self.attachments.push(mcap::Attachment {
                log_time: found.log_time_ns,
                create_time: found.create_time_ns,
                name: found.name.to_string(),
                media_type: found.media_type.to_string(),
                data: Cow::Owned(found.data.to_vec()),
            }),
            Record::Schema(found) => {
                let (name, encoding) = (found.name.to_string(), found.encoding.to_string());
                self.schemas.push((found.id, name, encoding, found.data.to_vec()));
            }
            Record::Channel(found) => {
                self.channels.push((found.id, found.schema, found.topic.to_string(), found.encoding.to_string()));
            }
            Record::Message(found) => {
                let topic =
                    self.channels.iter().find(|channel| channel.0 == found.channel).expect("announced").2.clone();
                self.messages.push(Message {
                    topic,
                    channel: found.channel,
                    sequence: found.sequence,
                    log_time_ns: found.log_time_ns,
                    data: found.data.to_vec(),
                });
            }
        }
        Ok(())
    }
}

/// Takes a log apart.
pub fn taken_apart(bytes: &[u8]) -> Pieces {
    let mut pieces = Pieces::default();
    read_any(Cursor::new(bytes), &mut pieces).expect("a log");
    pieces
}

impl Pieces {
    /// The log with these messages in this order, and channels only where there are messages, as a tool that filters or merges writes it.
    pub fn log(&self, messages: &[Message], options: mcap::WriteOptions) -> Vec<u8> {
        let mut out = options.create(Cursor::new(Vec::new())).expect("started");
        for metadata in &self.metadata {
            out.write_metadata(metadata).expect("written");
        }
        for attachment in &self.attachments {
            out.attach(attachment).expect("written");
        }
        for (id, name, encoding, data) in &self.schemas {
            out.add_schema_with_id(*id, name, encoding, data).expect("added");
        }
        for message in messages {
            let channel = self.channels.iter().find(|channel| channel.0 == message.channel).expect("known");
            let (id, schema, topic, encoding) = channel;
            out.add_channel_with_id(*id, *schema, topic, encoding, &BTreeMap::new()).expect("added");
            let header = MessageHeader {
                channel_id: *id,
                sequence: message.sequence,
                log_time: message.log_time_ns,
                publish_time: message.log_time_ns,
            };
            out.write_to_known_channel(&header, &message.data).expect("written");
        }
        out.finish().expect("finished");
        out.into_inner().into_inner()
    }
}

/// A log whose chunks are not compressed, with chunks that say they are compressed in this way; without an index.
pub fn recompressed(bytes: &[u8], compression: &str, compress: &dyn Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut out = bytes[..mcap::MAGIC.len()].to_vec();
    let mut put = |opcode: u8, body: &[u8]| {
        out.push(opcode);
        out.extend((body.len() as u64).to_le_bytes());
        out.extend(body);
    };
    let mut at = mcap::MAGIC.len();
    loop {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight")) as usize;
        let (opcode, body) = (bytes[at], &bytes[at + 9..at + 9 + length]);
        match opcode {
            mcap::records::op::CHUNK => {
                // Two times, size and checksum, then the compression, which is none, and the length of the records.
                assert_eq!(body[28..32], [0; 4], "not compressed");
                let mut chunk = body[..28].to_vec();
                let data = compress(&body[40..]);
                chunk.extend((compression.len() as u32).to_le_bytes());
                chunk.extend(compression.as_bytes());
                chunk.extend((data.len() as u64).to_le_bytes());
                chunk.extend(data);
                put(opcode, &chunk);
            }
            mcap::records::op::DATA_END => break,
            mcap::records::op::MESSAGE_INDEX => {}
            _ => put(opcode, body),
        }
        at += 9 + length;
    }
    put(mcap::records::op::DATA_END, &[0; 4]);
    put(mcap::records::op::FOOTER, &[0; 20]);
    out.extend(mcap::MAGIC);
    out
}
