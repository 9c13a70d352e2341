//! Subjects of damaged logs: joints, bodies, contacts and events are read as long as list, scene or channels describe them, and
//! no loss is silent.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::OnceLock;

use mcap::WriteOptions;
use mcap::records::op;
use phalanx::log::{self, LogSink, LogSummary, LossKind, ReadError, RunInfo, Severity, Writer};
use phalanx::scene;
use phalanx::trace::{Channel, Event, Model, Sample, Schema, SinkError};

use crate::support::checked_run;
use crate::support::cli::{assert_contains, assert_status, directory, json, path_text, stdout, write_bytes};
use crate::support::faults::XorShift;
use crate::support::replay::{LogContents, read_contents};

/// A finger, a gripper, sliders with limits, and a mechanism with tendons.
const SCENES: [(&str, f64); 4] = [
    ("scenes/experiment-95.toml", 8e-3),
    ("scenes/gripper/offset.toml", 4e-3),
    ("scenes/mechanisms/jaws.toml", 4e-3),
    ("scenes/mechanisms/tendon-finger.toml", 4e-3),
];

/// Number of random faults of each log; the ignored test has more.
const FAULT_COUNT: usize = 60;
const CAMPAIGN_FAULT_COUNT: usize = 3000;

/// Columns by name, as bits, and events with the name of their contact.
#[derive(Clone, Debug, Default, PartialEq)]
struct Contents {
    schema: Schema,
    channels: Vec<Channel>,
    columns: BTreeMap<String, Vec<u64>>,
    events: Vec<(u64, String, &'static str)>,
}

impl LogSink for Contents {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        (self.schema, self.channels) = (schema.clone(), schema.channels());
        self.columns = self.channels.iter().map(|channel| (channel.name.clone(), Vec::new())).collect();
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        for channel in &self.channels {
            self.columns.get_mut(&channel.name).expect("a column").push(channel.value(sample).to_bits());
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let contact = self.schema.contacts[event.contact].name.clone();
        self.events.push((event.time_s.to_bits(), contact, event.kind.name()));
        Ok(())
    }
}

impl Contents {
    /// Asserts that all columns and events of `whole` are here, up to a time.
    #[track_caller]
    fn assert_prefix_of(&self, whole: &Contents, context: &str) {
        for (name, column) in &whole.columns {
            let read = self.columns.get(name).unwrap_or_else(|| panic!("{context}: no {name}"));
            assert!(column.starts_with(read), "{context}: {name}");
        }
        assert!(whole.events.starts_with(&self.events), "{context}: events");
    }

    #[track_caller]
    fn assert_all_of(&self, whole: &Contents, context: &str) {
        self.assert_prefix_of(whole, context);
        assert_eq!(self.columns["time_s"].len(), whole.columns["time_s"].len(), "{context}");
        assert_eq!(self.events.len(), whole.events.len(), "{context}");
    }
}

fn read(bytes: &[u8]) -> (Result<LogSummary, ReadError>, Contents) {
    let mut contents = Contents::default();
    (log::read(Cursor::new(bytes), &mut contents), contents)
}

/// Whether the summary names a loss.
fn names_loss(reading: &LogSummary) -> bool {
    !reading.losses.is_empty() || !reading.missing.is_empty()
}

/// The logs of all scenes with their contents.
fn logs() -> &'static [(&'static str, Vec<u8>, Contents)] {
    static LOGS: OnceLock<Vec<(&str, Vec<u8>, Contents)>> = OnceLock::new();
    LOGS.get_or_init(|| {
        let log = |(path, duration_s)| {
            let mut scene = scene::load_any(path).expect("a scene");
            scene.duration_s = duration_s;
            let run = RunInfo { scene: &scene, scene_file: "scene.toml", model: "analytic" };
            let mut writer = Writer::new(Vec::new(), "the log", &run).expect("started");
            let outcome = checked_run::run(Model::Analytic, &scene, &mut writer).expect("a run");
            writer.note(outcome.last.time_s, Severity::Info, "run", "completed").expect("written");
            let bytes = writer.finish().expect("finished");
            let (reading, contents) = read(&bytes);
            let reading = reading.expect("a log");
            assert!(!names_loss(&reading), "{path}: {:?} {:?}", reading.losses, reading.missing);
            assert_eq!(contents.schema.joints.len(), Schema::from_scene(&scene).joints.len());
            (path, bytes, contents)
        };
        SCENES.into_iter().map(log).collect()
    })
}

fn assert_no_flip_is_silent(count: usize, seed: u64) {
    for (scene, bytes, whole) in logs() {
        let mut rng = XorShift::new(seed);
        for round in 0..count {
            // Half of the flips are at the start, where metadata, scene and definitions are.
            let offset = if round % 2 == 0 { rng.below(bytes.len().min(6000)) } else { rng.below(bytes.len()) };
            let bit = rng.below(8);
            let mut damaged = bytes.clone();
            damaged[offset] ^= 1 << bit;
            let context = format!("{scene}: bit {bit} of byte {offset}");
            let (reading, contents) = read(&damaged);
            match reading {
                Ok(reading) => {
                    assert!(!reading.is_complete(), "{context}");
                    if reading.samples > 0 {
                        contents.assert_prefix_of(whole, &context);
                    }
                    let outside =
                        reading.losses.iter().all(|loss| matches!(loss.kind, LossKind::Scene | LossKind::Metadata));
                    assert!(!outside || reading.samples as usize == whole.columns["time_s"].len(), "{context}");
                }
                Err(ReadError::NotPhalanx | ReadError::NotMcap | ReadError::OtherVersion { .. }) => {}
                Err(ReadError::Empty { .. }) => {}
                Err(error) => panic!("{context}: {error}"),
            }
        }
    }
}

#[test]
fn no_flipped_bit_hides_a_subject() {
    assert_no_flip_is_silent(FAULT_COUNT, 57);
}

#[test]
#[ignore = "minutes"]
fn no_flipped_bit_hides_a_subject_campaign() {
    assert_no_flip_is_silent(CAMPAIGN_FAULT_COUNT, 1057);
}

#[test]
fn a_truncated_log_keeps_its_subjects() {
    for (scene, bytes, whole) in logs() {
        let mut rng = XorShift::new(7);
        for _ in 0..FAULT_COUNT / 2 {
            let cut = rng.below(bytes.len());
            let (reading, contents) = read(&bytes[..cut]);
            let Ok(reading) = reading else { continue };
            assert!(!reading.is_complete(), "{scene}: cut at {cut}");
            if reading.samples > 0 {
                contents.assert_prefix_of(whole, &format!("{scene}: cut at {cut}"));
            }
        }
    }
}

/// Writes the log again with valid checksums, as tools do.
fn rewritten(contents: &LogContents) -> Vec<u8> {
    contents.log(&contents.messages, WriteOptions::new())
}

#[test]
fn a_log_without_its_scene_has_all_subjects_and_is_not_whole() {
    for (scene, bytes, whole) in logs() {
        let mut contents = read_contents(bytes);
        contents.attachments.clear();
        // As written; without the list of subjects; also without the kinds of channels, as in older logs.
        for description in ["list and channels", "channels", "topics"] {
            match description {
                "channels" => contents.metadata.retain(|record| record.name != "phalanx-subjects"),
                "topics" => contents.channels.iter_mut().for_each(|channel| channel.metadata.clear()),
                _ => {}
            }
            let context = format!("{scene}: without its scene, with {description}");
            let (reading, read) = read(&rewritten(&contents));
            let reading = reading.expect("a log");
            read.assert_all_of(whole, &context);
            assert_eq!(read.schema, whole.schema, "{context}");
            assert_eq!(reading.losses.len(), 1, "{context}: {:?}", reading.losses);
            assert_eq!((reading.losses[0].kind, reading.unknown_channels), (LossKind::Scene, 0), "{context}");
            assert_eq!(reading.missing, [], "{context}");
        }
    }
}

#[test]
fn a_scene_that_does_not_fit_is_named() {
    let (_, bytes, whole) = &logs()[2];
    let other = std::fs::read_to_string("scenes/mechanisms/tendon-finger.toml").expect("a scene");
    for (text, part) in
        [(other, "does not have the joints"), ("kind = 7".to_string(), "cannot read the attached scene")]
    {
        let mut contents = read_contents(bytes);
        contents.attachments[0].data = text.into_bytes().into();
        let (reading, read) = read(&rewritten(&contents));
        let reading = reading.expect("a log");
        read.assert_all_of(whole, part);
        assert_eq!(reading.losses.len(), 1, "{:?}", reading.losses);
        assert_contains(&reading.losses[0].description, &[part]);
    }
}

#[test]
fn every_removed_part_is_named() {
    for (scene, bytes, whole) in logs() {
        let contents = read_contents(bytes);
        // A topic, without the scene.
        let mut topics: Vec<String> = contents.messages.iter().map(|message| message.topic.clone()).collect();
        topics.sort();
        topics.dedup();
        let is_view = |topic: &&String| !["/tf", "/tf_static", "/scene", "/forces"].contains(&topic.as_str());
        for topic in topics.iter().filter(is_view).step_by(3) {
            let mut without = read_contents(bytes);
            without.attachments.clear();
            without.messages.retain(|message| message.topic != *topic);
            let (reading, read) = read(&rewritten(&without));
            let missing = reading.expect("a log").missing;
            assert!(missing.iter().any(|missing| missing.topic == *topic), "{scene}: {topic}: {missing:?}");
            assert!(whole.columns.keys().all(|name| read.columns.contains_key(name)), "{scene}: {topic}");
        }
        // Consecutive messages.
        let mut rng = XorShift::new(11);
        for _ in 0..FAULT_COUNT / 6 {
            let first = rng.below(contents.messages.len());
            let count = (1 + rng.below(400)).min(contents.messages.len() - first);
            let removed = &contents.messages[first..first + count];
            let mut messages = contents.messages.clone();
            messages.drain(first..first + count);
            let (reading, _) = read(&contents.log(&messages, WriteOptions::new()));
            let is_needed = removed.iter().any(|message| is_view(&&message.topic));
            let context = format!("{scene}: {count} messages from {first}");
            assert!(!is_needed || names_loss(&reading.expect("a log")), "{context}");
        }
        // Chunks, in a file without a checksum.
        let records = records(bytes);
        for (index, _) in records.iter().enumerate().filter(|(_, (opcode, _))| *opcode == op::CHUNK) {
            let mut damaged = bytes[..mcap::MAGIC.len()].to_vec();
            for (_, (opcode, record)) in records.iter().enumerate().filter(|(other, _)| *other != index) {
                damaged.extend(*record);
                if *opcode == op::DATA_END {
                    let end = damaged.len();
                    damaged[end - 4..].fill(0);
                }
            }
            damaged.extend(mcap::MAGIC);
            let (reading, read) = read(&damaged);
            let reading = reading.expect("a log");
            assert!(names_loss(&reading), "{scene}: without chunk {index}");
            assert!(whole.columns.keys().all(|name| read.columns.contains_key(name)), "{scene}: without chunk {index}");
        }
    }
}

/// Opcode and bytes of every record.
fn records(bytes: &[u8]) -> Vec<(u8, &[u8])> {
    let (mut offset, mut records) = (mcap::MAGIC.len(), Vec::new());
    while offset + 9 < bytes.len() - mcap::MAGIC.len() + 1 {
        let length = u64::from_le_bytes(bytes[offset + 1..offset + 9].try_into().expect("eight")) as usize;
        records.push((bytes[offset], &bytes[offset..offset + 9 + length]));
        offset += 9 + length;
    }
    records
}

#[test]
fn replay_reports_what_is_lost_with_the_scene() {
    let directory = directory("faults_subjects");
    let (_, bytes, whole) = &logs()[2];
    let mut contents = read_contents(bytes);
    contents.attachments.clear();
    let log = write_bytes(&directory, "without.mcap", &rewritten(&contents));
    let report = json(&assert_status(&["replay", path_text(&log), "--json"], 1, &["no attached scene"]));
    assert_eq!(report["whole"], false);
    let contacts = report["contacts"].as_object().expect("contacts");
    assert_eq!(contacts.len(), whole.schema.contacts.len());
    assert_eq!(report["events"].as_u64(), Some(whole.events.len() as u64));
    let text = assert_status(&["replay", path_text(&log)], 1, &[]);
    assert_contains(stdout(&text), &["LOST: the log has no attached scene", "class, criteria, drawings"]);
}
