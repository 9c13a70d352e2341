//! Logs cut and flipped at random: no panic, and what is read is a prefix of what was written.

use std::sync::OnceLock;

use crate::support::faults::{Dice, Items, read_bytes};
use phalanx::log::{Loss, ReadError, RunInfo, Severity, Writer};
use phalanx::scene;
use phalanx::trace::Model;

const FAULTS: usize = 200;

/// The log of a closing on a fine grid: several chunks, events between them.
fn log() -> &'static (Vec<u8>, Items) {
    static LOG: OnceLock<(Vec<u8>, Items)> = OnceLock::new();
    LOG.get_or_init(|| {
        let mut scene = scene::load("scenes/experiment-95.toml").expect("the anchor scene");
        scene.log.numeric_hz = 1e5;
        let run = RunInfo { scene: &scene, scene_file: "experiment-95.toml", model: "analytic" };
        let mut writer = Writer::new(Vec::new(), "the log", &run).expect("started");
        let outcome = crate::support::held::run(Model::Analytic, &scene, &mut writer).expect("a run");
        writer.note(outcome.last.time_s, Severity::Info, "run", "completed").expect("written");
        let bytes = writer.finish().expect("finished");
        let (reading, items) = read_bytes(&bytes);
        assert!(reading.expect("a log").is_whole() && items.samples() > 2000);
        (bytes, items)
    })
}

#[test]
fn cut_anywhere() {
    let (bytes, whole) = log();
    let mut dice = Dice::new(95);
    let mut longest = 0;
    for _ in 0..FAULTS {
        let cut = dice.below(bytes.len());
        let (reading, items) = read_bytes(&bytes[..cut]);
        items.assert_prefix_of(whole, &format!("cut at {cut}"));
        longest = longest.max(items.0.len());
        match reading {
            Ok(reading) => assert!(matches!(reading.losses.last(), Some(Loss::Truncated { .. })), "cut at {cut}"),
            Err(ReadError::Empty { bytes }) => assert_eq!(bytes, cut as u64),
            Err(ReadError::NotMcap) => assert_eq!(cut, 0),
            Err(error) => panic!("cut at {cut}: {error}"),
        }
    }
    assert!(longest > whole.0.len() / 2);
    println!("faults: {FAULTS} cuts");
}

#[test]
fn a_bit_flipped_anywhere() {
    let (bytes, whole) = log();
    let mut dice = Dice::new(2026);
    let mut unseen = Vec::new();
    for _ in 0..FAULTS {
        let (place, bit) = (dice.below(bytes.len()), dice.below(8));
        let mut damaged = bytes.clone();
        damaged[place] ^= 1 << bit;
        let (reading, items) = read_bytes(&damaged);
        items.assert_prefix_of(whole, &format!("bit {bit} of byte {place}"));
        match reading {
            Ok(reading) if reading.is_whole() => unseen.push(place),
            Ok(_) | Err(ReadError::NotPhalanx | ReadError::NotMcap | ReadError::Empty { .. }) => {}
            Err(error) => panic!("bit {bit} of byte {place}: {error}"),
        }
    }
    // Every byte but those of the very end is under some checksum.
    assert!(unseen.is_empty(), "flips that nothing noticed: {unseen:?} of {}", bytes.len());
    println!("faults: {FAULTS} flipped bits");
}

/// Whole bytes overwritten, several at once: lengths, counts and texts that claim anything.
#[test]
fn bytes_overwritten_anywhere() {
    let (bytes, whole) = log();
    let mut dice = Dice::new(7);
    for round in 0..FAULTS {
        let mut damaged = bytes.clone();
        for _ in 0..1 + round % 4 {
            let (place, length) = (dice.below(bytes.len() - 8), 1 + dice.below(8));
            damaged[place..place + length].fill([0, 0xff, 0x7f, 0x80][dice.below(4)]);
        }
        read_bytes(&damaged).1.assert_prefix_of(whole, &format!("round {round}"));
    }
    println!("faults: {FAULTS} overwritten stretches");
}
