//! Reading of complete, truncated, damaged and foreign logs.

use crate::support::faults::{LogItem, LogItems, read_bytes};
use crate::support::replay::read_contents;
use crate::support::synthetic::{lift_off, reload, sample, scene, touch_down};
use phalanx::log::{LogSummary, Loss, LossKind, ReadError, RunInfo, Severity, Writer};
use phalanx::scene::Scene;
use phalanx::trace::{FingerContact, Sink};

const SAMPLES: usize = 3_000;

/// Writes a log of several chunks; returns it and the written items.
fn write_test_log(scene: &Scene, samples: usize) -> (Vec<u8>, LogItems) {
    let run = RunInfo { scene, scene_file: "synthetic.toml", model: "analytic" };
    let mut writer = Writer::new(Vec::new(), "the log", &run).expect("started");
    let mut items = LogItems::default();
    for i in 0..samples {
        let time_s = 1e-6 * i as f64;
        let sample = sample(time_s);
        writer.sample(&sample).expect("written");
        items.0.push(LogItem::Sample(Box::new(sample)));
        let event = match i % 100 {
            10 => touch_down(time_s, FingerContact::Proximal, 1.25),
            20 => lift_off(time_s, FingerContact::Proximal, 3.5e-3),
            30 => touch_down(time_s, FingerContact::Limit, 12.5),
            40 => reload(time_s, FingerContact::Distal),
            _ => continue,
        };
        writer.event(&event).expect("written");
        items.0.push(LogItem::Event(event));
    }
    writer.note(1e-6 * samples as f64, Severity::Info, "run", "completed").expect("written");
    (writer.finish().expect("finished"), items)
}

fn read_log(bytes: &[u8]) -> (LogSummary, LogItems) {
    let (reading, items) = read_bytes(bytes);
    (reading.expect("a log"), items)
}

#[test]
fn reads_a_complete_log_bit_for_bit() {
    let (bytes, items) = write_test_log(&scene(), SAMPLES);
    let (reading, items_read) = read_log(&bytes);
    assert_eq!(items_read.0.len(), items.0.len());
    items_read.assert_prefix_of(&items, "whole");
    assert!(reading.is_complete());
    assert_eq!(reading.bytes, bytes.len() as u64);
    assert_eq!((reading.samples, reading.events), (SAMPLES as u64, 120));
    assert_eq!((reading.unknown_channels, reading.unknown_messages), (0, 0));
    assert_eq!(reading.metadata["model"], "analytic");
    assert_eq!(reading.metadata["scene"], "synthetic");
    assert_eq!(reading.scene, Some(("synthetic.toml".to_string(), scene().source)));
    let run_end = reading.run_end.expect("a run end");
    assert_eq!(run_end.stopped, None);
    assert!((run_end.time_s - 1e-6 * SAMPLES as f64).abs() < 1e-9);
    assert_eq!((reading.first_s, reading.last_s), (Some(0.0), Some(1e-6 * (SAMPLES - 1) as f64)));
    assert!(reading.chunks > 4, "{} chunks", reading.chunks);
}

#[test]
fn simultaneous_events_keep_their_order() {
    let scene = scene();
    let run = RunInfo { scene: &scene, scene_file: "synthetic.toml", model: "analytic" };
    let mut writer = Writer::new(Vec::new(), "the log", &run).expect("started");
    let contacts = [FingerContact::Limit, FingerContact::Distal, FingerContact::Proximal];
    writer.sample(&sample(0.0)).expect("written");
    for contact in contacts {
        writer.event(&touch_down(1e-3, contact, 1.0)).expect("written");
    }
    writer.sample(&sample(2e-3)).expect("written");
    writer.note(2e-3, Severity::Info, "run", "completed").expect("written");
    let bytes = writer.finish().expect("finished");
    let mut contents = read_contents(&bytes);
    contents.messages.reverse();
    for bytes in [bytes, contents.log(&contents.messages, mcap::WriteOptions::new())] {
        let (_, LogItems(items)) = read_log(&bytes);
        let events = items.iter().filter_map(|item| match item {
            LogItem::Event(event) => Some(event.contact),
            LogItem::Sample(_) => None,
        });
        assert!(events.eq(contacts.map(|contact| contact as usize)));
    }
}

#[test]
fn absent_contacts_have_an_infinite_gap() {
    let mut swing = scene();
    swing.hand.object = None;
    swing.finger_mut().limit = None;
    let (bytes, _) = write_test_log(&swing, 10);
    let (reading, items_read) = read_log(&bytes);
    assert!(reading.is_complete());
    let Some(LogItem::Sample(sample)) = items_read.0.first() else { panic!("no sample") };
    assert_eq!(sample.finger_contact(FingerContact::Distal).gap_m, f64::INFINITY);
    assert_eq!(sample.finger_contact(FingerContact::Limit).gap_m, f64::INFINITY);
}

#[test]
fn reads_a_log_without_samples() {
    let scene = scene();
    let run = RunInfo { scene: &scene, scene_file: "synthetic.toml", model: "engine" };
    let mut writer = Writer::new(Vec::new(), "the log", &run).expect("started");
    writer.note(0.0, Severity::Error, "run", "stopped: no way").expect("written");
    let (reading, items_read) = read_log(&writer.finish().expect("finished"));
    assert!(reading.is_complete() && items_read.0.is_empty());
    assert_eq!(reading.run_end.and_then(|run_end| run_end.stopped), Some("no way".to_string()));
}

#[test]
fn reads_a_truncated_log_up_to_its_last_complete_chunk() {
    let (bytes, items) = write_test_log(&scene(), SAMPLES);
    let cut = bytes.len() / 2;
    let (reading, items_read) = read_log(&bytes[..cut]);
    items_read.assert_prefix_of(&items, "cut");
    assert!(items_read.sample_count() > SAMPLES / 4, "{} samples", items_read.sample_count());
    assert_eq!(reading.run_end, None);
    let [Loss { at_byte, kind: LossKind::Truncated, description }] = &reading.losses[..] else {
        panic!("{:?}", reading.losses)
    };
    let readable = format!("truncated at byte {at_byte} of {cut}; it is readable up to");
    assert!(*at_byte < cut as u64 && description.contains(&readable), "{description}");
    // Only the end of the index is missing.
    let (reading, items_read) = read_log(&bytes[..bytes.len() - 1]);
    assert_eq!(items_read, items);
    assert!(matches!(reading.losses[..], [Loss { kind: LossKind::Truncated, .. }]), "{:?}", reading.losses);
}

/// Offsets of the chunk records.
fn chunks(bytes: &[u8]) -> Vec<usize> {
    let index = mcap::Summary::read(bytes).expect("readable").expect("indexed").chunk_indexes;
    index.iter().map(|chunk| chunk.chunk_start_offset as usize).collect()
}

#[test]
fn reports_a_damaged_chunk_with_position_and_remedy() {
    let (bytes, items) = write_test_log(&scene(), SAMPLES);
    let chunks = chunks(&bytes);
    let read_damaged = |damaged: &[u8], at_byte: usize| {
        let (reading, items_read) = read_log(damaged);
        items_read.assert_prefix_of(&items, "damaged");
        let [Loss { kind: LossKind::Damaged, description, .. }] = &reading.losses[..] else {
            panic!("{:?}", reading.losses)
        };
        assert!(description.contains(&format!("damaged at byte {at_byte} of {}", bytes.len())), "{description}");
        assert!(description.contains("mcap recover"), "{description}");
    };
    let mut damaged = bytes.clone();
    damaged[chunks[2] + 200] ^= 1;
    read_damaged(&damaged, chunks[2]);
    for length in [1u64 << 60, 20_000_000, 100_000_000, 3] {
        let mut damaged = bytes.clone();
        damaged[chunks[1] + 1..chunks[1] + 9].copy_from_slice(&length.to_le_bytes());
        read_damaged(&damaged, chunks[1]);
    }
}

#[test]
fn reports_damage_outside_chunks_and_keeps_all_samples() {
    let (bytes, items) = write_test_log(&scene(), SAMPLES);
    let find =
        |needle: &[u8]| bytes.windows(needle.len()).position(|window| window == needle).expect("the needle occurs");
    // Damage in the attached scene, in the metadata, in the index and after the end.
    let mut scene_damaged = bytes.clone();
    scene_damaged[find(b"no particular")] ^= 1;
    let (reading, items_read) = read_log(&scene_damaged);
    assert!(items_read == items && reading.scene.is_none());
    assert!(reading.losses[0].kind == LossKind::Scene, "{:?}", reading.losses);

    // The length of the profile in the header, a setting, and the length of an index of messages.
    let index = mcap::Summary::read(&bytes).expect("readable").expect("indexed");
    let message_index = *index.chunk_indexes[1].message_index_offsets.values().next().expect("an index") as usize;
    for at_byte in [mcap::MAGIC.len() + 9, find(b"rodas5p"), message_index + 9 + 2] {
        let mut metadata_damaged = bytes.clone();
        metadata_damaged[at_byte] ^= 1;
        let (reading, items_read) = read_log(&metadata_damaged);
        let description = &reading.losses[0].description;
        assert!(items_read == items && description.contains("outside the chunks"), "{at_byte}: {description}");
        assert!(reading.losses[0].kind == LossKind::Metadata && !description.contains("recover"), "{description}");
    }

    let mut index_damaged = bytes.clone();
    let index = bytes.len() - 200;
    index_damaged[index] ^= 1;
    let (reading, items_read) = read_log(&index_damaged);
    assert!(items_read == items && !reading.is_complete());

    let (reading, items_read) = read_log(&[&bytes[..], b"tail"].concat());
    assert!(items_read == items && reading.losses[0].description.contains("4 more bytes"), "{:?}", reading.losses);
}

#[test]
fn rejects_other_files_with_a_reason() {
    let read_error = |bytes: &[u8]| read_bytes(bytes).0.expect_err("rejected");
    assert!(matches!(read_error(b""), ReadError::NotMcap));
    assert!(matches!(read_error(b"name = \"scene\"\n"), ReadError::NotMcap));
    let (bytes, _) = write_test_log(&scene(), 10);
    assert!(matches!(read_error(&bytes[..5]), ReadError::Empty { bytes: 5 }));
    assert!(matches!(read_error(&bytes[..30]), ReadError::Empty { .. }));

    let mut other = Vec::new();
    let mut mcap = mcap::Writer::new(std::io::Cursor::new(&mut other)).expect("started");
    let channel = mcap.add_channel(0, "chat", "json", &Default::default()).expect("added");
    let header = mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
    mcap.write_to_known_channel(&header, b"{}").expect("written");
    mcap.finish().expect("finished");
    drop(mcap);
    assert!(matches!(read_error(&other), ReadError::NotPhalanx));
    assert!(read_error(&other).to_string().contains("not a log of phalanx"));
}

#[test]
fn unknown_channels_are_skipped_and_counted() {
    let scene = scene();
    let mut bytes = Vec::new();
    let mut mcap = mcap::Writer::new(std::io::Cursor::new(&mut bytes)).expect("started");
    let run = RunInfo { scene: &scene, scene_file: "synthetic.toml", model: "analytic" };
    let metadata = mcap::write::Metadata { name: "phalanx".to_string(), metadata: phalanx::log::metadata(&run) };
    mcap.write_metadata(&metadata).expect("written");
    let (name, media_type) = ("synthetic.toml".to_string(), "application/toml".to_string());
    let data = scene.source.as_bytes().into();
    mcap.attach(&mcap::Attachment { log_time: 0, create_time: 0, name, media_type, data }).expect("written");
    // The topic is known, but the schema is not.
    let schema = mcap.add_schema("other.State", "protobuf", b"").expect("added");
    for (topic, schema) in [("/joint/q11", schema), ("/chat", 0)] {
        let channel_id = mcap.add_channel(schema, topic, "protobuf", &Default::default()).expect("added");
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
        mcap.write_to_known_channel(&header, &[0xff; 20]).expect("written");
    }
    mcap.finish().expect("finished");
    drop(mcap);
    let (reading, items_read) = read_log(&bytes);
    assert!(reading.is_complete() && items_read.0.is_empty());
    assert_eq!((reading.unknown_channels, reading.unknown_messages, reading.messages), (2, 2, 2));
}
