//! Logs of fingers and discs from both models, and tools that edit a log.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::process::Command;

use mcap::records::MessageHeader;
use phalanx::log::{LogSink, MessageRecord, Record, RunInfo, Severity, Writer, read_any};
use phalanx::scene::load_any;
use phalanx::trace::{Decimated, Event, Model, Sample, Sink, SinkError, run};

pub const FINGER_SCENE: &str = "scenes/experiment-95.toml";
pub const DISC_SCENE: &str = "scenes/laws/impact.toml";

/// Returns the log that `phalanx run` writes for a scene, with `numeric_hz` samples per second.
pub fn log(scene: &str, model: Model, numeric_hz: f64) -> Vec<u8> {
    // Tests run in parallel, so each call uses its own directory.
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join(scene.rsplit('/').next().expect("a name"));
    let text = fs::read_to_string(scene).expect("a scene");
    if text.contains("extends = ") {
        let entries = fs::read_dir(std::path::Path::new(scene).parent().expect("a directory")).expect("readable");
        for other in entries.map(|entry| entry.expect("readable").path()).filter(|path| path.is_file()) {
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

/// Returns the log of a run that was interrupted by a signal after `samples` samples.
pub fn interrupted_log(scene: &str, model: Model, samples: usize) -> Vec<u8> {
    struct StopAfter<W> {
        writer: W,
        samples_left: usize,
        last_s: f64,
    }
    impl<W: Sink> Sink for StopAfter<W> {
        fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
            (self.samples_left, self.last_s) = (self.samples_left.saturating_sub(1), sample.time_s);
            self.writer.sample(sample)
        }
        fn event(&mut self, event: &Event) -> Result<(), SinkError> {
            self.writer.event(event)
        }
        fn should_continue(&self) -> bool {
            self.samples_left > 0
        }
    }
    let file = scene.rsplit('/').next().expect("a name");
    let reason = "stopped: interrupted by SIGINT (Ctrl-C)";
    let scene = load_any(scene).expect("a scene");
    let scene = &scene;
    let info = RunInfo { scene, scene_file: file, model: model.name() };
    let writer = Writer::new(Vec::new(), "the log", &info).expect("started");
    let stop_after = StopAfter { writer, samples_left: samples, last_s: 0.0 };
    let mut decimated = Decimated::new(scene.log.numeric_hz, stop_after);
    assert!(run(model, scene, &mut decimated).expect_err("stopped").is_stop());
    decimated.end().expect("written");
    let mut sink = decimated.sink;
    sink.writer.note(sink.last_s, Severity::Error, "run", reason).expect("written");
    sink.writer.finish().expect("finished")
}

/// Edit of a message.
pub enum MessageEdit {
    Keep,
    Drop,
    Change(Vec<u8>),
}

/// Name and file descriptor set of a schema.
pub type Schema = (String, Vec<u8>);

/// Edits of a log that leave it readable.
pub struct LogEdits<'a> {
    pub metadata: &'a dyn Fn(&mut BTreeMap<String, String>),
    pub scene: &'a dyn Fn(&str) -> Option<String>,
    /// Arguments: topic, index of the message within the topic, payload.
    pub message: &'a dyn Fn(&str, u64, &[u8]) -> MessageEdit,
    /// Arguments: name and file descriptor set of a schema.
    pub schema: &'a dyn Fn(&str, &[u8]) -> Schema,
}

impl Default for LogEdits<'_> {
    fn default() -> Self {
        LogEdits {
            metadata: &|_| {},
            scene: &|text| Some(text.to_string()),
            message: &|_, _, _| MessageEdit::Keep,
            schema: &|name, data| (name.to_string(), data.to_vec()),
        }
    }
}

/// Returns the edited log, with new checksums and a new index.
pub fn edit_log(bytes: &[u8], changes: &LogEdits<'_>) -> Vec<u8> {
    struct LogEditor<'a> {
        out: mcap::Writer<Cursor<Vec<u8>>>,
        changes: &'a LogEdits<'a>,
        topics: BTreeMap<u16, (String, u64)>,
    }
    impl LogSink for LogEditor<'_> {
        fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
            let out = &mut self.out;
            match record {
                Record::Metadata { name, entries } => {
                    let mut metadata = (*entries).clone();
                    (self.changes.metadata)(&mut metadata);
                    let name = name.to_string();
                    out.write_metadata(&mcap::write::Metadata { name, metadata }).expect("written");
                }
                Record::Attachment(record) => {
                    let text = std::str::from_utf8(record.data).expect("text");
                    let Some(text) = (self.changes.scene)(text) else { return Ok(()) };
                    let attachment = mcap::Attachment {
                        log_time: record.log_time_ns,
                        create_time: record.create_time_ns,
                        name: record.name.to_string(),
                        media_type: record.media_type.to_string(),
                        data: Cow::Owned(text.into_bytes()),
                    };
                    out.attach(&attachment).expect("written");
                }
                Record::Schema(schema_record) => {
                    let (name, data) = (self.changes.schema)(schema_record.name, schema_record.data);
                    out.add_schema_with_id(schema_record.id, &name, schema_record.encoding, &data).expect("added");
                }
                Record::Channel(channel_record) => {
                    let (id, schema) = (channel_record.id, channel_record.schema);
                    out.add_channel_with_id(
                        id,
                        schema,
                        channel_record.topic,
                        channel_record.encoding,
                        &channel_record.metadata,
                    )
                    .expect("added");
                    self.topics.insert(id, (channel_record.topic.to_string(), 0));
                }
                Record::Message(message) => {
                    let MessageRecord { channel, sequence, log_time_ns, publish_time_ns, data } = *message;
                    let (topic, count) = self.topics.get_mut(&channel).expect("announced");
                    let edit = (self.changes.message)(topic, *count, data);
                    *count += 1;
                    let data = match edit {
                        MessageEdit::Keep => data.to_vec(),
                        MessageEdit::Drop => return Ok(()),
                        MessageEdit::Change(data) => data,
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
    let mut editor = LogEditor { out, changes, topics: BTreeMap::new() };
    read_any(Cursor::new(bytes), &mut editor).expect("a log");
    editor.out.finish().expect("finished");
    editor.out.into_inner().into_inner()
}

/// Returns the payload with one field of type double increased by one unit in the last place.
pub fn one_ulp_up(payload: &[u8], field: u8) -> Vec<u8> {
    let mut bytes = payload.to_vec();
    let mut offset = 0;
    loop {
        let (number, wire) = (bytes[offset] >> 3, bytes[offset] & 7);
        offset += 1;
        match wire {
            1 if number == field => {
                let value_bytes = offset..offset + 8;
                let value = f64::from_le_bytes(bytes[value_bytes.clone()].try_into().expect("eight"));
                bytes[value_bytes].copy_from_slice(&value.next_up().to_le_bytes());
                return bytes;
            }
            1 => offset += 8,
            0 => offset += 1,
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

/// The records of a log, from which its messages can be written in another order or with other options.
#[derive(Default)]
pub struct LogContents {
    metadata: Vec<mcap::write::Metadata>,
    attachments: Vec<mcap::Attachment<'static>>,
    schemas: Vec<(u16, String, String, Vec<u8>)>,
    channels: Vec<(u16, u16, String, String)>,
    pub messages: Vec<Message>,
}

impl LogSink for LogContents {
    fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
        match record {
            Record::Metadata { name, entries } => {
                self.metadata.push(mcap::write::Metadata { name: name.to_string(), metadata: (*entries).clone() });
            }
            Record::Attachment(attachment) => self.attachments.push(mcap::Attachment {
                log_time: attachment.log_time_ns,
                create_time: attachment.create_time_ns,
                name: attachment.name.to_string(),
                media_type: attachment.media_type.to_string(),
                data: Cow::Owned(attachment.data.to_vec()),
            }),
            Record::Schema(schema) => {
                let (name, encoding) = (schema.name.to_string(), schema.encoding.to_string());
                self.schemas.push((schema.id, name, encoding, schema.data.to_vec()));
            }
            Record::Channel(channel) => {
                self.channels.push((
                    channel.id,
                    channel.schema,
                    channel.topic.to_string(),
                    channel.encoding.to_string(),
                ));
            }
            Record::Message(message) => {
                let topic =
                    self.channels.iter().find(|channel| channel.0 == message.channel).expect("announced").2.clone();
                self.messages.push(Message {
                    topic,
                    channel: message.channel,
                    sequence: message.sequence,
                    log_time_ns: message.log_time_ns,
                    data: message.data.to_vec(),
                });
            }
        }
        Ok(())
    }
}

/// Reads all records of a log.
pub fn read_contents(bytes: &[u8]) -> LogContents {
    let mut contents = LogContents::default();
    read_any(Cursor::new(bytes), &mut contents).expect("a log");
    contents
}

impl LogContents {
    /// Writes a log with the given messages in the given order. Only channels with messages are written, as by tools
    /// that filter or merge logs.
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

/// Returns an uncompressed log with its chunks compressed by `compress` and labelled `compression`, without an index.
pub fn recompress_chunks(bytes: &[u8], compression: &str, compress: &dyn Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut out = bytes[..mcap::MAGIC.len()].to_vec();
    let mut append_record = |opcode: u8, body: &[u8]| {
        out.push(opcode);
        out.extend((body.len() as u64).to_le_bytes());
        out.extend(body);
    };
    let mut offset = mcap::MAGIC.len();
    loop {
        let length = u64::from_le_bytes(bytes[offset + 1..offset + 9].try_into().expect("eight")) as usize;
        let (opcode, body) = (bytes[offset], &bytes[offset + 9..offset + 9 + length]);
        match opcode {
            mcap::records::op::CHUNK => {
                // Chunk header: two times, size, checksum, name of the compression (empty), length of the records.
                assert_eq!(body[28..32], [0; 4], "the chunk is compressed");
                let mut chunk = body[..28].to_vec();
                let data = compress(&body[40..]);
                chunk.extend((compression.len() as u32).to_le_bytes());
                chunk.extend(compression.as_bytes());
                chunk.extend((data.len() as u64).to_le_bytes());
                chunk.extend(data);
                append_record(opcode, &chunk);
            }
            mcap::records::op::DATA_END => break,
            mcap::records::op::MESSAGE_INDEX => {}
            _ => append_record(opcode, body),
        }
        offset += 9 + length;
    }
    append_record(mcap::records::op::DATA_END, &[0; 4]);
    append_record(mcap::records::op::FOOTER, &[0; 20]);
    out.extend(mcap::MAGIC);
    out
}
