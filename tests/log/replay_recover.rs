//! `phalanx replay --recover`: the good part of a log, byte for byte, as a log that every reader takes.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use crate::support::cli::{directory, json, phalanx, stderr, stdout, write};
use crate::support::faults::Dice;
use crate::support::replay::{DISCS, FINGER, log};
use mcap::{MessageStream, Summary};
use phalanx::log::{
    Expected, Lockstep, Loss, RECOVERED_NAME, ReadError, Reading, Recovery, Verification, gaps, read_any, recover,
};
use phalanx::trace::Model;

const FAULTS: usize = 100;

/// Logs of several chunks: of both kinds, one by each model.
fn logs() -> [Vec<u8>; 2] {
    let logs = [log(FINGER, Model::Analytic, 2e4), log(DISCS, Model::Engine, 4e4)];
    for bytes in &logs {
        assert!(Summary::read(bytes).expect("readable").expect("indexed").chunk_indexes.len() >= 4);
    }
    logs
}

/// A message: topic, sequence number, times, payload.
type Message = (String, u32, u64, u64, Vec<u8>);

fn owned(message: &mcap::Message<'_>) -> Message {
    let topic = message.channel.topic.clone();
    (topic, message.sequence, message.log_time, message.publish_time, message.data.to_vec())
}

/// All messages by the mcap crate's own reader, which must take the file.
fn messages(bytes: &[u8]) -> Vec<Message> {
    let all = MessageStream::new(bytes).expect("an MCAP file");
    all.map(|message| owned(&message.expect("readable to the end"))).collect()
}

/// Messages of every chunk, by the index of a whole log, with where the chunk begins and ends.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize, Vec<Message>)> {
    let summary = Summary::read(bytes).expect("readable").expect("indexed");
    let mut chunks: Vec<_> = summary
        .chunk_indexes
        .iter()
        .map(|index| {
            let start = index.chunk_start_offset as usize;
            let all = summary.stream_chunk(bytes, index).expect("a chunk");
            let all = all.map(|message| owned(&message.expect("readable"))).collect();
            (start, start + index.chunk_length as usize, all)
        })
        .collect();
    chunks.sort_by_key(|chunk| chunk.0);
    chunks
}

fn recovered(bytes: &[u8]) -> Result<(Vec<u8>, Recovery), ReadError> {
    let mut out = Vec::new();
    let found = recover(&mut Cursor::new(bytes), "broken.mcap", &mut out, "the recovered log", &|_| Ok(()))?;
    Ok((out, found))
}

/// Reads a recovered log as `phalanx replay` does: it must be whole.
fn whole(bytes: &[u8]) -> Reading {
    let reading = read_any(Cursor::new(bytes), &mut ()).expect("a log");
    assert!(reading.is_whole(), "{:?}", reading.losses);
    reading
}

/// Compares a recovered log with the log of the same run.
fn compared(bytes: &[u8], reading: &Reading, undisturbed: &[u8]) -> Verification {
    let gaps = reading.recovered.as_ref().map(gaps).expect("says that it is recovered");
    let expected = Expected { gaps, ..Expected::default() };
    let mut lockstep = Lockstep::new(Cursor::new(undisturbed), expected, &|_| Ok(())).expect("begun");
    read_any(Cursor::new(bytes), &mut lockstep).expect("a log");
    lockstep.finish().expect("finished")
}

#[test]
fn a_log_killed_anywhere_is_recovered_up_to_its_last_complete_chunk() {
    for (undisturbed, seed) in logs().iter().zip([51, 52]) {
        let chunks = chunks(undisturbed);
        let mut dice = Dice::new(seed);
        let mut most = 0;
        for _ in 0..FAULTS {
            let cut = dice.below(undisturbed.len());
            let expected: Vec<Message> =
                chunks.iter().filter(|chunk| chunk.1 <= cut).flat_map(|chunk| chunk.2.clone()).collect();
            let (bytes, found) = match recovered(&undisturbed[..cut]) {
                Ok(found) => found,
                Err(ReadError::Empty { .. } | ReadError::NotMcap) => {
                    assert!(cut < chunks[0].0, "cut at {cut}");
                    continue;
                }
                Err(error) => panic!("cut at {cut}: {error}"),
            };
            assert_eq!(messages(&bytes), expected, "cut at {cut}");
            assert!(matches!(found.reading.losses.last(), Some(Loss::Truncated { .. })), "cut at {cut}");
            assert_eq!((found.messages, found.missing, found.gaps.len()), (expected.len() as u64, 0, 0));
            let reading = whole(&bytes);
            let entries = reading.recovered.clone().expect("said");
            assert_eq!((&entries["source"], &entries["source_bytes"]), (&"broken.mcap".into(), &cut.to_string()));
            assert!(entries["lost"].contains("truncated"), "{entries:?}");
            // A prefix of what simulating again gives.
            let verified = compared(&bytes, &reading, undisturbed);
            assert!(verified.is_same(), "cut at {cut}: {verified:?}");
            assert_eq!(verified.compared, expected.len() as u64);
            assert_eq!(recovered(&undisturbed[..cut]).expect("again").0, bytes, "the same bytes again");
            most = most.max(expected.len());
        }
        assert!(most > chunks.iter().map(|chunk| chunk.2.len()).sum::<usize>() / 2);
    }
    println!("faults: {} cuts", 2 * FAULTS);
}

#[test]
fn a_byte_changed_anywhere_costs_no_more_than_its_chunk() {
    for (undisturbed, seed) in logs().iter().zip([71, 72]) {
        let all = messages(undisturbed);
        let chunks = chunks(undisturbed);
        let largest = chunks.iter().map(|chunk| chunk.2.len()).max().expect("chunks");
        let mut dice = Dice::new(seed);
        for _ in 0..FAULTS {
            let (place, bit) = (dice.below(undisturbed.len()), dice.below(8));
            let mut damaged = undisturbed.clone();
            damaged[place] ^= 1 << bit;
            let what = format!("bit {bit} of byte {place}");
            let (bytes, found) = match recovered(&damaged) {
                Ok(found) => found,
                Err(ReadError::NotMcap | ReadError::NotPhalanx | ReadError::Empty { .. }) => {
                    assert!(place < chunks[0].0, "{what}");
                    continue;
                }
                Err(error) => panic!("{what}: {error}"),
            };
            let kept = messages(&bytes);
            // Nothing is made up: what is kept are messages of the log, in its order.
            let mut rest = all.iter();
            assert!(kept.iter().all(|message| rest.any(|other| other == message)), "{what}");
            let before_chunks = place < chunks[0].0;
            if !before_chunks {
                assert!(kept.len() + largest >= all.len(), "{what}: {} of {}", kept.len(), all.len());
            }
            let reading = whole(&bytes);
            let verified = compared(&bytes, &reading, undisturbed);
            let settings = before_chunks && !verified.metadata.is_empty();
            assert!(verified.is_same() || settings, "{what}: {verified:?}");
            assert_eq!(verified.compared, kept.len() as u64, "{what}");
            assert!(found.gaps.len() <= 1, "{what}: {:?}", found.gaps);
        }
    }
    println!("faults: {} flipped bits", 2 * FAULTS);
}

#[test]
fn chunks_behind_a_damage_are_kept_and_what_is_missing_is_counted() {
    for undisturbed in logs() {
        let chunks = chunks(&undisturbed);
        for lost in [0, 1, chunks.len() - 1] {
            let mut damaged = undisturbed.clone();
            damaged[chunks[lost].0 + 100] ^= 1;
            let (bytes, found) = recovered(&damaged).expect("a log");
            let expected: Vec<Message> =
                chunks.iter().enumerate().filter(|(k, _)| *k != lost).flat_map(|(_, chunk)| chunk.2.clone()).collect();
            assert_eq!(messages(&bytes), expected, "chunk {lost}");
            assert_eq!(found.nameless, 0, "the index names the channels");
            let reading = whole(&bytes);
            if lost + 1 == chunks.len() {
                // At the end nothing follows that could tell.
                assert!(found.gaps.is_empty() && found.missing == 0);
                continue;
            }
            // Every message of the chunk but those of channels of which no more comes.
            let later: Vec<&String> = chunks[lost + 1..].iter().flat_map(|chunk| &chunk.2).map(|m| &m.0).collect();
            let missing = chunks[lost].2.iter().filter(|message| later.contains(&&message.0)).count();
            assert_eq!(found.missing, missing as u64);
            let [gap] = &found.gaps[..] else { panic!("{:?}", found.gaps) };
            assert_eq!(gaps(reading.recovered.as_ref().expect("said")), found.gaps);
            let before: usize = chunks[..lost].iter().map(|chunk| chunk.2.len()).sum();
            assert_eq!(gap.after_messages, before as u64);
            assert_eq!(gap.to_s, chunks[lost + 1].2[0].2 as f64 * 1e-9);
            let verified = compared(&bytes, &reading, &undisturbed);
            assert!(verified.is_same(), "{verified:?}");
            assert_eq!(verified.in_gaps, chunks[lost].2.len() as u64);
            // Recovered once more it is the same, and still says what is missing.
            let (again, found) = recovered(&bytes).expect("a log");
            assert_eq!(messages(&again), expected);
            assert_eq!(found.gaps, gaps(whole(&again).recovered.as_ref().expect("said")));
            assert_eq!(found.gaps, gaps(reading.recovered.as_ref().expect("said")));
        }
    }
}

#[test]
fn the_command_writes_a_log_that_replays() {
    let directory = directory("recover_command");
    let bytes = log(FINGER, Model::Engine, 1e5);
    let broken = directory.join("run.mcap.partial");
    fs::write(&broken, &bytes[..3 * bytes.len() / 4]).expect("written");
    let target = directory.join("run.mcap");
    let name = |path: &Path| path.to_str().expect("text").to_string();
    let output = phalanx(&["replay", &name(&broken), "--recover", &name(&target)]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("truncated"), "{}", stderr(&output));
    assert!(stdout(&output).contains("run.mcap is what can be read of"), "{}", stdout(&output));
    assert_eq!(fs::read(&broken).expect("untouched").len(), 3 * bytes.len() / 4);
    let output = phalanx(&["replay", &name(&target), "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!(report["recovered"]["source"], "run.mcap.partial");
    assert_eq!((&report["completed"], &report["criteria"]), (&serde_json::Value::Null, &serde_json::Value::Null));
    let output = phalanx(&["replay", &name(&target), "--verify", "--json"]);
    assert_eq!(output.status.code(), Some(1), "a prefix is not the whole");
    assert_eq!(json(&output)["verification"]["same"], true);
    // An older log gives way, another file and the source do not.
    let output = phalanx(&["replay", &name(&broken), "--recover", &name(&target), "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(json(&output)["messages"].as_u64() > Some(1000));
    let scene = write(&directory, "scene.toml", "name = \"precious\"\n");
    for (target, part) in [(scene.as_str(), "not a log that phalanx wrote"), (&name(&broken), "the log itself")] {
        let output = phalanx(&["replay", &name(&broken), "--recover", target]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
    assert_eq!(fs::read_to_string(&scene).expect("still there"), "name = \"precious\"\n");
    let output = phalanx(&["replay", &scene, "--recover", &name(&directory.join("new.mcap"))]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(!directory.join("new.mcap").exists());
    let summary = Summary::read(&fs::read(&target).expect("there")).expect("readable").expect("indexed");
    assert!(summary.metadata_indexes.iter().any(|found| found.name == RECOVERED_NAME));
}
