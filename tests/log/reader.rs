//! Logs read back: whole ones to the last bit, cut and damaged ones as far as they go, others with a reason.

use crate::support::faults::{Item, Items, read_bytes};
use crate::support::synthetic::{lift_off, reload, sample, scene, touch_down};
use phalanx::log::{Loss, ReadError, Reading, RunInfo, Severity, Writer};
use phalanx::scene::Scene;
use phalanx::trace::{Sink, Site};

const SAMPLES: usize = 3_000;

/// A log of several chunks, and what was written to it.
fn written(scene: &Scene, samples: usize) -> (Vec<u8>, Items) {
    let run = RunInfo { scene, scene_file: "synthetic.toml", model: "analytic" };
    let mut writer = Writer::new(Vec::new(), "the log", &run).expect("started");
    let mut items = Items::default();
    for i in 0..samples {
        let time_s = 1e-6 * i as f64;
        let sample = sample(time_s);
        writer.sample(&sample).expect("written");
        items.sample(&sample).expect("kept");
        let event = match i % 100 {
            10 => touch_down(time_s, Site::Proximal, 1.25),
            20 => lift_off(time_s, Site::Proximal, 3.5e-3),
            30 => touch_down(time_s, Site::Limit, 12.5),
            40 => reload(time_s, Site::Distal),
            _ => continue,
        };
        writer.event(&event).expect("written");
        items.event(&event).expect("kept");
    }
    writer.note(1e-6 * samples as f64, Severity::Info, "run", "completed").expect("written");
    (writer.finish().expect("finished"), items)
}

fn good(bytes: &[u8]) -> (Reading, Items) {
    let (reading, items) = read_bytes(bytes);
    (reading.expect("a log"), items)
}

#[test]
fn a_whole_log_comes_back_to_the_last_bit() {
    let (bytes, items) = written(&scene(), SAMPLES);
    let (reading, found) = good(&bytes);
    assert_eq!(found.0.len(), items.0.len());
    found.assert_prefix_of(&items, "whole");
    assert!(reading.is_whole());
    assert_eq!(reading.bytes, bytes.len() as u64);
    assert_eq!((reading.samples, reading.events), (SAMPLES as u64, 120));
    assert_eq!((reading.unknown_channels, reading.unknown_messages), (0, 0));
    assert_eq!(reading.metadata["model"], "analytic");
    assert_eq!(reading.metadata["scene"], "synthetic");
    assert_eq!(reading.scene, Some(("synthetic.toml".to_string(), scene().source)));
    let ended = reading.ended.expect("said");
    assert_eq!(ended.stopped, None);
    assert!((ended.time_s - 1e-6 * SAMPLES as f64).abs() < 1e-9);
    assert_eq!((reading.first_s, reading.last_s), (Some(0.0), Some(1e-6 * (SAMPLES - 1) as f64)));
    assert!(reading.chunks > 4, "{} chunks", reading.chunks);
}

#[test]
fn what_a_scene_does_not_have_is_not_there() {
    let mut swing = scene();
    swing.system.discs.clear();
    swing.finger_mut().limit = None;
    let (bytes, _) = written(&swing, 10);
    let (reading, found) = good(&bytes);
    assert!(reading.is_whole());
    let Some(Item::Sample(sample)) = found.0.first() else { panic!("no sample") };
    assert_eq!(sample.contact(Site::Distal).gap_m, f64::INFINITY);
    assert_eq!(sample.contact(Site::Limit).gap_m, f64::INFINITY);
}

#[test]
fn a_log_without_samples_is_a_log() {
    let scene = scene();
    let run = RunInfo { scene: &scene, scene_file: "synthetic.toml", model: "engine" };
    let mut writer = Writer::new(Vec::new(), "the log", &run).expect("started");
    writer.note(0.0, Severity::Error, "run", "stopped: no way").expect("written");
    let (reading, found) = good(&writer.finish().expect("finished"));
    assert!(reading.is_whole() && found.0.is_empty());
    assert_eq!(reading.ended.and_then(|ended| ended.stopped), Some("no way".to_string()));
}

#[test]
fn a_cut_log_says_where_and_reads_up_to_its_last_whole_chunk() {
    let (bytes, items) = written(&scene(), SAMPLES);
    let cut = bytes.len() / 2;
    let (reading, found) = good(&bytes[..cut]);
    found.assert_prefix_of(&items, "cut");
    assert!(found.samples() > SAMPLES / 4, "{} samples", found.samples());
    assert_eq!(reading.ended, None);
    let [Loss::Truncated { at_byte, bytes: size, last_s }] = reading.losses[..] else { panic!("{:?}", reading.losses) };
    assert!(at_byte < size && size == cut as u64);
    assert_eq!(last_s, reading.last_s);
    let said = reading.losses[0].to_string();
    assert!(said.contains("truncated") && said.contains(&format!("byte {at_byte} of {cut}")), "{said}");
    // Nothing but the index is missing.
    let (reading, found) = good(&bytes[..bytes.len() - 1]);
    assert_eq!(found, items);
    assert!(matches!(reading.losses[..], [Loss::Truncated { .. }]), "{:?}", reading.losses);
}

/// Offsets of the chunk records.
fn chunks(bytes: &[u8]) -> Vec<usize> {
    let index = mcap::Summary::read(bytes).expect("readable").expect("indexed").chunk_indexes;
    index.iter().map(|chunk| chunk.chunk_start_offset as usize).collect()
}

#[test]
fn a_damaged_chunk_says_where_and_what_lies_behind() {
    let (bytes, items) = written(&scene(), SAMPLES);
    let chunks = chunks(&bytes);
    let mut damaged = bytes.clone();
    damaged[chunks[2] + 200] ^= 1;
    let (reading, found) = good(&damaged);
    found.assert_prefix_of(&items, "damaged");
    let [Loss::Damaged { at_byte, behind, .. }] = &reading.losses[..] else { panic!("{:?}", reading.losses) };
    assert_eq!(*at_byte, chunks[2] as u64);
    assert_eq!(behind.chunks as usize, chunks.len() - 3);
    assert!(behind.messages > 0 && behind.first_s > reading.last_s.expect("samples"));
    // A length that leads nowhere: the chunks behind are found nevertheless.
    for length in [1u64 << 60, 20_000_000, 100_000_000, 3] {
        let mut damaged = bytes.clone();
        damaged[chunks[1] + 1..chunks[1] + 9].copy_from_slice(&length.to_le_bytes());
        let (reading, found) = good(&damaged);
        found.assert_prefix_of(&items, "length");
        let [Loss::Damaged { at_byte, behind, .. }] = &reading.losses[..] else { panic!("{:?}", reading.losses) };
        assert_eq!((*at_byte, behind.chunks as usize), (chunks[1] as u64, chunks.len() - 2), "{length}");
    }
}

#[test]
fn damage_outside_the_chunks_is_said_and_leaves_the_samples() {
    let (bytes, items) = written(&scene(), SAMPLES);
    let place = |needle: &[u8]| bytes.windows(needle.len()).position(|window| window == needle).expect("there");
    // In the attached scene, in the metadata, in the index, behind the end.
    let mut scene_damaged = bytes.clone();
    scene_damaged[place(b"no particular")] ^= 1;
    let (reading, found) = good(&scene_damaged);
    assert!(found == items && reading.scene.is_none());
    assert!(matches!(reading.losses[0], Loss::Scene { .. }), "{:?}", reading.losses);

    let mut metadata_damaged = bytes.clone();
    metadata_damaged[place(b"rodas5p")] ^= 1;
    let (reading, found) = good(&metadata_damaged);
    assert!(found == items && reading.losses[0].to_string().contains("outside the chunks"), "{:?}", reading.losses);

    let mut index_damaged = bytes.clone();
    let index = bytes.len() - 200;
    index_damaged[index] ^= 1;
    let (reading, found) = good(&index_damaged);
    assert!(found == items && !reading.is_whole());

    let (reading, found) = good(&[&bytes[..], b"tail"].concat());
    assert!(found == items && reading.losses[0].to_string().contains("4 more bytes"), "{:?}", reading.losses);
}

#[test]
fn what_is_no_log_of_phalanx_is_refused_with_a_reason() {
    let refusal = |bytes: &[u8]| read_bytes(bytes).0.expect_err("refused");
    assert!(matches!(refusal(b""), ReadError::NotMcap));
    assert!(matches!(refusal(b"name = \"scene\"\n"), ReadError::NotMcap));
    let (bytes, _) = written(&scene(), 10);
    assert!(matches!(refusal(&bytes[..5]), ReadError::Empty { bytes: 5 }));
    assert!(matches!(refusal(&bytes[..30]), ReadError::Empty { .. }));

    let mut other = Vec::new();
    let mut mcap = mcap::Writer::new(std::io::Cursor::new(&mut other)).expect("started");
    let channel = mcap.add_channel(0, "chat", "json", &Default::default()).expect("added");
    let header = mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
    mcap.write_to_known_channel(&header, b"{}").expect("written");
    mcap.finish().expect("finished");
    drop(mcap);
    assert!(matches!(refusal(&other), ReadError::NotPhalanx));
    assert!(refusal(&other).to_string().contains("not a log of phalanx"));
}

#[test]
fn channels_of_others_are_skipped_and_counted() {
    let scene = scene();
    let mut bytes = Vec::new();
    let mut mcap = mcap::Writer::new(std::io::Cursor::new(&mut bytes)).expect("started");
    let run = RunInfo { scene: &scene, scene_file: "synthetic.toml", model: "analytic" };
    let metadata = mcap::write::Metadata { name: "phalanx".to_string(), metadata: phalanx::log::metadata(&run) };
    mcap.write_metadata(&metadata).expect("written");
    // The topic is ours, the schema is not.
    let schema = mcap.add_schema("other.State", "protobuf", b"").expect("added");
    for (topic, schema) in [("/state", schema), ("/chat", 0)] {
        let channel_id = mcap.add_channel(schema, topic, "protobuf", &Default::default()).expect("added");
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
        mcap.write_to_known_channel(&header, &[0xff; 20]).expect("written");
    }
    mcap.finish().expect("finished");
    drop(mcap);
    let (reading, found) = good(&bytes);
    assert!(reading.is_whole() && found.0.is_empty());
    assert_eq!((reading.unknown_channels, reading.unknown_messages, reading.messages), (2, 2, 2));
}
