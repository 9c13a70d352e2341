//! `phalanx replay --recover`: writes the intact part of a log, byte for byte, as a valid log.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use crate::support::cli::{directory, json, phalanx, stderr, stdout, write};
use crate::support::faults::XorShift;
use crate::support::replay::{DISC_SCENE, FINGER_SCENE, log};
use mcap::{MessageStream, Summary};
use phalanx::log::{
    ComparisonOptions, LogComparison, LogSummary, Loss, RECOVERED_NAME, ReadError, Recovery, Verification, gaps,
    read_any, recover,
};
use phalanx::trace::Model;

const FAULT_COUNT: usize = 100;

/// Logs of several chunks: a finger in the analytic model and discs in the engine model.
fn logs() -> [Vec<u8>; 2] {
    let logs = [log(FINGER_SCENE, Model::Analytic, 2e4), log(DISC_SCENE, Model::Engine, 4e4)];
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

/// All messages, read by the mcap crate, which must accept the file.
fn messages(bytes: &[u8]) -> Vec<Message> {
    let all = MessageStream::new(bytes).expect("an MCAP file");
    all.map(|message| owned(&message.expect("readable to the end"))).collect()
}

/// Start, end and messages of every chunk, from the index of a complete log.
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

fn run_recovery(bytes: &[u8]) -> Result<(Vec<u8>, Recovery), ReadError> {
    let mut out = Vec::new();
    let recovery = recover(&mut Cursor::new(bytes), "broken.mcap", &mut out, "the recovered log", &|_| Ok(()))?;
    Ok((out, recovery))
}

/// Reads a recovered log like `phalanx replay`; it must be complete.
fn read_complete(bytes: &[u8]) -> LogSummary {
    let reading = read_any(Cursor::new(bytes), &mut ()).expect("a log");
    assert!(reading.is_complete(), "{:?}", reading.losses);
    reading
}

/// Compares a recovered log with the log of the same run.
fn compare_with_original(bytes: &[u8], reading: &LogSummary, original: &[u8]) -> Verification {
    let gaps = reading.recovered.as_ref().map(gaps).expect("a recovery record");
    let expected = ComparisonOptions { gaps, ..ComparisonOptions::default() };
    let mut comparison = LogComparison::new(Cursor::new(original), expected, &|_| Ok(())).expect("started");
    read_any(Cursor::new(bytes), &mut comparison).expect("a log");
    comparison.finish().expect("finished")
}

#[test]
fn recovers_a_truncated_log_up_to_its_last_complete_chunk() {
    for (original, seed) in logs().iter().zip([51, 52]) {
        let chunks = chunks(original);
        let mut rng = XorShift::new(seed);
        let mut max_messages = 0;
        for _ in 0..FAULT_COUNT {
            let cut = rng.below(original.len());
            let expected: Vec<Message> =
                chunks.iter().filter(|chunk| chunk.1 <= cut).flat_map(|chunk| chunk.2.clone()).collect();
            let (bytes, recovery) = match run_recovery(&original[..cut]) {
                Ok(recovery) => recovery,
                Err(ReadError::Empty { .. } | ReadError::NotMcap) => {
                    assert!(cut < chunks[0].0, "cut at {cut}");
                    continue;
                }
                Err(error) => panic!("cut at {cut}: {error}"),
            };
            assert_eq!(messages(&bytes), expected, "cut at {cut}");
            assert!(matches!(recovery.reading.losses.last(), Some(Loss::Truncated { .. })), "cut at {cut}");
            assert_eq!((recovery.messages, recovery.missing, recovery.gaps.len()), (expected.len() as u64, 0, 0));
            let reading = read_complete(&bytes);
            let entries = reading.recovered.clone().expect("a recovery record");
            assert_eq!((&entries["source"], &entries["source_bytes"]), (&"broken.mcap".into(), &cut.to_string()));
            assert!(entries["lost"].contains("truncated"), "{entries:?}");
            // The recovered log is a prefix of the log of a new run.
            let verified = compare_with_original(&bytes, &reading, original);
            assert!(verified.is_same(), "cut at {cut}: {verified:?}");
            assert_eq!(verified.compared, expected.len() as u64);
            assert_eq!(run_recovery(&original[..cut]).expect("recovered").0, bytes, "recovery is deterministic");
            max_messages = max_messages.max(expected.len());
        }
        assert!(max_messages > chunks.iter().map(|chunk| chunk.2.len()).sum::<usize>() / 2);
    }
    println!("faults: {} cuts", 2 * FAULT_COUNT);
}

#[test]
fn a_flipped_bit_loses_at_most_one_chunk() {
    for (original, seed) in logs().iter().zip([71, 72]) {
        let all = messages(original);
        let chunks = chunks(original);
        let largest = chunks.iter().map(|chunk| chunk.2.len()).max().expect("chunks");
        let mut rng = XorShift::new(seed);
        for _ in 0..FAULT_COUNT {
            let (offset, bit) = (rng.below(original.len()), rng.below(8));
            let mut damaged = original.clone();
            damaged[offset] ^= 1 << bit;
            let label = format!("bit {bit} of byte {offset}");
            let (bytes, recovery) = match run_recovery(&damaged) {
                Ok(recovery) => recovery,
                Err(ReadError::NotMcap | ReadError::NotPhalanx | ReadError::Empty { .. }) => {
                    assert!(offset < chunks[0].0, "{label}");
                    continue;
                }
                Err(error) => panic!("{label}: {error}"),
            };
            let recovered_messages = messages(&bytes);
            // The recovered messages are a subsequence of the original ones.
            let mut rest = all.iter();
            assert!(recovered_messages.iter().all(|message| rest.any(|other| other == message)), "{label}");
            let before_chunks = offset < chunks[0].0;
            if !before_chunks {
                assert!(
                    recovered_messages.len() + largest >= all.len(),
                    "{label}: {} of {}",
                    recovered_messages.len(),
                    all.len()
                );
            }
            let reading = read_complete(&bytes);
            let verified = compare_with_original(&bytes, &reading, original);
            let settings = before_chunks && !verified.metadata.is_empty();
            assert!(verified.is_same() || settings, "{label}: {verified:?}");
            assert_eq!(verified.compared, recovered_messages.len() as u64, "{label}");
            assert!(recovery.gaps.len() <= 1, "{label}: {:?}", recovery.gaps);
        }
    }
    println!("faults: {} flipped bits", 2 * FAULT_COUNT);
}

#[test]
fn recovers_chunks_after_damage_and_counts_missing_messages() {
    for original in logs() {
        let chunks = chunks(&original);
        for lost in [0, 1, chunks.len() - 1] {
            let mut damaged = original.clone();
            damaged[chunks[lost].0 + 100] ^= 1;
            let (bytes, recovery) = run_recovery(&damaged).expect("a log");
            let expected: Vec<Message> =
                chunks.iter().enumerate().filter(|(k, _)| *k != lost).flat_map(|(_, chunk)| chunk.2.clone()).collect();
            assert_eq!(messages(&bytes), expected, "chunk {lost}");
            assert_eq!(recovery.unidentified, 0, "the index names the channels");
            let reading = read_complete(&bytes);
            if lost + 1 == chunks.len() {
                // No later message can reveal a gap at the end.
                assert!(recovery.gaps.is_empty() && recovery.missing == 0);
                continue;
            }
            // All messages of the lost chunk, except on channels without later messages.
            let later: Vec<&String> = chunks[lost + 1..].iter().flat_map(|chunk| &chunk.2).map(|m| &m.0).collect();
            let missing = chunks[lost].2.iter().filter(|message| later.contains(&&message.0)).count();
            assert_eq!(recovery.missing, missing as u64);
            let [gap] = &recovery.gaps[..] else { panic!("{:?}", recovery.gaps) };
            assert_eq!(gaps(reading.recovered.as_ref().expect("a recovery record")), recovery.gaps);
            let before: usize = chunks[..lost].iter().map(|chunk| chunk.2.len()).sum();
            assert_eq!(gap.after_messages, before as u64);
            assert_eq!(gap.to_s, chunks[lost + 1].2[0].2 as f64 * 1e-9);
            let verified = compare_with_original(&bytes, &reading, &original);
            assert!(verified.is_same(), "{verified:?}");
            assert_eq!(verified.in_gaps, chunks[lost].2.len() as u64);
            // A second recovery gives the same messages and gaps.
            let (second, recovery) = run_recovery(&bytes).expect("a log");
            assert_eq!(messages(&second), expected);
            assert_eq!(recovery.gaps, gaps(read_complete(&second).recovered.as_ref().expect("a recovery record")));
            assert_eq!(recovery.gaps, gaps(reading.recovered.as_ref().expect("a recovery record")));
        }
    }
}

#[test]
fn recovered_log_can_be_replayed() {
    let directory = directory("recover_command");
    let bytes = log(FINGER_SCENE, Model::Engine, 1e5);
    let broken = directory.join("run.mcap.partial");
    fs::write(&broken, &bytes[..3 * bytes.len() / 4]).expect("written");
    let target = directory.join("run.mcap");
    let name = |path: &Path| path.to_str().expect("text").to_string();
    let output = phalanx(&["replay", &name(&broken), "--recover", &name(&target)]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("truncated"), "{}", stderr(&output));
    assert!(stdout(&output).contains("run.mcap contains the readable part of"), "{}", stdout(&output));
    assert_eq!(fs::read(&broken).expect("untouched").len(), 3 * bytes.len() / 4);
    let output = phalanx(&["replay", &name(&target), "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!(report["recovered"]["source"], "run.mcap.partial");
    assert_eq!((&report["completed"], &report["criteria"]), (&serde_json::Value::Null, &serde_json::Value::Null));
    let output = phalanx(&["replay", &name(&target), "--verify", "--json"]);
    assert_eq!(output.status.code(), Some(1), "a prefix is not a complete comparison");
    assert_eq!(json(&output)["verification"]["same"], true);
    // An older log is replaced; other files and the source are not.
    let output = phalanx(&["replay", &name(&broken), "--recover", &name(&target), "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(json(&output)["messages"].as_u64() > Some(1000));
    let scene = write(&directory, "scene.toml", "name = \"precious\"\n");
    for (target, part) in [(scene.as_str(), "not a log written by phalanx"), (&name(&broken), "the log itself")] {
        let output = phalanx(&["replay", &name(&broken), "--recover", target]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
    assert_eq!(fs::read_to_string(&scene).expect("the file is unchanged"), "name = \"precious\"\n");
    let output = phalanx(&["replay", &scene, "--recover", &name(&directory.join("new.mcap"))]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(!directory.join("new.mcap").exists());
    let summary = Summary::read(&fs::read(&target).expect("readable")).expect("readable").expect("indexed");
    assert!(summary.metadata_indexes.iter().any(|index| index.name == RECOVERED_NAME));
}
