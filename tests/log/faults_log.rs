//! Randomly truncated and corrupted logs: no panic, and the decoded items are a prefix of the written ones.

use std::sync::OnceLock;

use crate::support::faults::{LogItems, XorShift, read_bytes};
use phalanx::log::{Loss, LossKind, ReadError, RunInfo, Severity, Writer};
use phalanx::scene;
use phalanx::trace::Model;

const FAULT_COUNT: usize = 200;

/// Log of a closing finger on a fine time grid: several chunks, with events.
fn log() -> &'static (Vec<u8>, LogItems) {
    static LOG: OnceLock<(Vec<u8>, LogItems)> = OnceLock::new();
    LOG.get_or_init(|| {
        let mut scene = scene::load("scenes/experiment-95.toml").expect("the anchor scene");
        scene.log.numeric_hz = 1e5;
        let run = RunInfo { scene: &scene, scene_file: "experiment-95.toml", model: "analytic" };
        let mut writer = Writer::new(Vec::new(), "the log", &run).expect("started");
        let outcome = crate::support::checked_run::run(Model::Analytic, &scene, &mut writer).expect("a run");
        writer.note(outcome.last.time_s, Severity::Info, "run", "completed").expect("written");
        let bytes = writer.finish().expect("finished");
        let (reading, items) = read_bytes(&bytes);
        assert!(reading.expect("a log").is_complete() && items.sample_count() > 2000);
        (bytes, items)
    })
}

#[test]
fn reads_a_prefix_of_a_truncated_log() {
    let (bytes, complete_items) = log();
    let mut rng = XorShift::new(95);
    let mut longest = 0;
    for _ in 0..FAULT_COUNT {
        let cut = rng.below(bytes.len());
        let (reading, items) = read_bytes(&bytes[..cut]);
        items.assert_prefix_of(complete_items, &format!("cut at {cut}"));
        longest = longest.max(items.0.len());
        match reading {
            Ok(reading) => {
                assert!(matches!(reading.losses.last(), Some(Loss { kind: LossKind::Truncated, .. })), "cut at {cut}")
            }
            Err(ReadError::Empty { bytes }) => assert_eq!(bytes, cut as u64),
            Err(ReadError::NotMcap) => assert_eq!(cut, 0),
            Err(error) => panic!("cut at {cut}: {error}"),
        }
    }
    assert!(longest > complete_items.0.len() / 2);
    println!("faults: {FAULT_COUNT} cuts");
}

#[test]
fn detects_any_flipped_bit() {
    let (bytes, complete_items) = log();
    let mut rng = XorShift::new(2026);
    let mut undetected = Vec::new();
    for _ in 0..FAULT_COUNT {
        let (offset, bit) = (rng.below(bytes.len()), rng.below(8));
        let mut damaged = bytes.clone();
        damaged[offset] ^= 1 << bit;
        let (reading, items) = read_bytes(&damaged);
        items.assert_prefix_of(complete_items, &format!("bit {bit} of byte {offset}"));
        match reading {
            Ok(reading) if reading.is_complete() => undetected.push(offset),
            Ok(_) | Err(ReadError::NotPhalanx | ReadError::NotMcap | ReadError::Empty { .. }) => {}
            Err(error) => panic!("bit {bit} of byte {offset}: {error}"),
        }
    }
    // A checksum or magic number covers every byte.
    assert!(undetected.is_empty(), "undetected flips: {undetected:?} of {}", bytes.len());
    println!("faults: {FAULT_COUNT} flipped bits");
}

/// Overwrites several ranges at once, to produce arbitrary lengths, counts and strings.
#[test]
fn reads_a_prefix_of_an_overwritten_log() {
    let (bytes, complete_items) = log();
    let mut rng = XorShift::new(7);
    for round in 0..FAULT_COUNT {
        let mut damaged = bytes.clone();
        for _ in 0..1 + round % 4 {
            let (offset, length) = (rng.below(bytes.len() - 8), 1 + rng.below(8));
            damaged[offset..offset + length].fill([0, 0xff, 0x7f, 0x80][rng.below(4)]);
        }
        read_bytes(&damaged).1.assert_prefix_of(complete_items, &format!("round {round}"));
    }
    println!("faults: {FAULT_COUNT} overwritten ranges");
}
