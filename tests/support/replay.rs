//! Logs of fingers and discs from both models, and tools that edit a log.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::process::Command;

use mcap::read::ChunkFlattener;
use mcap::records::{Channel, MessageHeader, Metadata, Record};
use phalanx::log::{RunInfo, Severity, Writer};
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
        let entries = fs::read_dir(Path::new(scene).parent().expect("a directory")).expect("readable");
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
    let mut contents = read_contents(bytes);
    contents.metadata.iter_mut().for_each(|record| (changes.metadata)(&mut record.metadata));
    contents.attachments.retain_mut(|attachment| {
        let edited = (changes.scene)(std::str::from_utf8(&attachment.data).expect("text"));
        edited.map(|text| attachment.data = text.into_bytes().into()).is_some()
    });
    for (_, name, _, data) in &mut contents.schemas {
        (*name, *data) = (changes.schema)(name, data);
    }
    let mut counts: BTreeMap<String, u64> = BTreeMap::new();
    let mut messages = std::mem::take(&mut contents.messages);
    messages.retain_mut(|message| {
        let count = counts.entry(message.topic.clone()).or_default();
        *count += 1;
        match (changes.message)(&message.topic, *count - 1, &message.data) {
            MessageEdit::Keep => true,
            MessageEdit::Drop => false,
            MessageEdit::Change(data) => {
                message.data = data;
                true
            }
        }
    });
    contents.log(&messages, mcap::WriteOptions::new())
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
            // A text of less than 128 bytes.
            2 => offset += 1 + usize::from(bytes[offset]),
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
    pub metadata: Vec<mcap::write::Metadata>,
    pub attachments: Vec<mcap::Attachment<'static>>,
    /// Id, name, encoding and data.
    pub schemas: Vec<(u16, String, String, Vec<u8>)>,
    pub channels: Vec<Channel>,
    pub messages: Vec<Message>,
}

/// Reads all records of a log with the mcap crate.
pub fn read_contents(bytes: &[u8]) -> LogContents {
    let mut contents = LogContents::default();
    for record in ChunkFlattener::new(bytes).expect("a log") {
        match record.expect("readable to the end") {
            Record::Metadata(Metadata { name, metadata }) => {
                contents.metadata.push(mcap::write::Metadata { name, metadata });
            }
            Record::Attachment { header, data, .. } => contents.attachments.push(mcap::Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                name: header.name,
                media_type: header.media_type,
                data: data.into_owned().into(),
            }),
            Record::Schema { header, data } => {
                contents.schemas.push((header.id, header.name, header.encoding, data.into_owned()));
            }
            Record::Channel(channel) => contents.channels.push(channel),
            Record::Message { header, data } => {
                let channel = contents.channels.iter().find(|channel| channel.id == header.channel_id);
                let topic = channel.expect("announced").topic.clone();
                let (channel, sequence, log_time_ns) = (header.channel_id, header.sequence, header.log_time);
                contents.messages.push(Message { topic, channel, sequence, log_time_ns, data: data.into_owned() });
            }
            // The summary repeats schemas and channels.
            Record::DataEnd(_) => break,
            _ => {}
        }
    }
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
            let channel = self.channels.iter().find(|channel| channel.id == message.channel).expect("known");
            let Channel { id, schema_id, topic, message_encoding, metadata } = channel;
            out.add_channel_with_id(*id, *schema_id, topic, message_encoding, metadata).expect("added");
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
