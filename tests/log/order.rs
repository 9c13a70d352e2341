//! Logs with reordered messages, missing topics or other compression: same results, or a reason and exit status 1.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Output;
use std::time::{Duration, Instant};

use mcap::{Compression, WriteOptions};
use phalanx::trace::Model;
use serde_json::Value;

use crate::support::cli::{
    assert_contains, assert_status, directory, json, path_in, path_text, phalanx, stderr, stdout, write_bytes,
};
use crate::support::faults::XorShift;
use crate::support::replay::{
    DISC_SCENE, FINGER_SCENE, LogContents, LogEdits, Message, edit_log, log, read_contents, recompress_chunks,
};

const GRIPPER: &str = "scenes/gripper/hold.toml";

const RUNS: [(&str, Model); 6] = [
    (FINGER_SCENE, Model::Analytic),
    (FINGER_SCENE, Model::Engine),
    (GRIPPER, Model::Analytic),
    (GRIPPER, Model::Engine),
    (DISC_SCENE, Model::Analytic),
    (DISC_SCENE, Model::Engine),
];

/// Replays a log; asserts the exit status, and that standard error contains each of `parts`.
#[track_caller]
fn replay(log: &Path, extra_args: &[&str], status: i32, parts: &[&str]) -> Output {
    assert_status(&[&["replay", path_text(log)], extra_args].concat(), status, parts)
}

/// Report of a log without its name and size.
fn report(log: &Path, status: i32) -> Value {
    report_of(log, &[], status)
}

fn report_of(log: &Path, extra_args: &[&str], status: i32) -> Value {
    let mut report = json(&replay(log, &[&["--json"], extra_args].concat(), status, &[]));
    for key in ["log", "bytes"] {
        report.as_object_mut().expect("an object").remove(key);
    }
    report
}

/// Options for many small chunks.
fn options() -> WriteOptions {
    WriteOptions::new().chunk_size(Some(8 << 10))
}

fn shuffle(messages: &[Message], seed: u64) -> Vec<Message> {
    let (mut rng, mut messages) = (XorShift::new(seed), messages.to_vec());
    for k in (1..messages.len()).rev() {
        messages.swap(k, rng.below(k + 1));
    }
    messages
}

/// The log in many orders, each with a label.
fn reorderings(pieces: &LogContents) -> Vec<(&'static str, Vec<u8>)> {
    let written = &pieces.messages;
    let random = shuffle(written, 7);
    let mut by_time = random.clone();
    by_time.sort_by_key(|message| message.log_time_ns);
    let mut by_topic = written.clone();
    by_topic.sort_by(|a, b| a.topic.cmp(&b.topic));
    let mut topics_at_once = written.clone();
    topics_at_once.sort_by(|a, b| a.log_time_ns.cmp(&b.log_time_ns).then(b.topic.cmp(&a.topic)));
    let mut chunks: Vec<&[Message]> = written.chunks(97).collect();
    chunks.rotate_left(3);
    chunks.reverse();
    let chunks: Vec<Message> = chunks.concat();
    let unnumbered: Vec<Message> = by_time.iter().map(|message| Message { sequence: 0, ..message.clone() }).collect();
    let twice: Vec<Message> = written.iter().flat_map(|message| [message.clone(), message.clone()]).collect();
    vec![
        ("equal times shuffled", pieces.log(&by_time, options())),
        ("sorted by topic", pieces.log(&by_topic, options())),
        ("topics backwards at each time", pieces.log(&topics_at_once, options())),
        ("chunks out of order", pieces.log(&chunks, options())),
        ("any order", pieces.log(&random, options())),
        ("any order without chunks", pieces.log(&random, options().use_chunks(false))),
        ("as written without chunks", pieces.log(written, options().use_chunks(false))),
        ("without numbers", pieces.log(&unnumbered, options())),
        ("every message twice", pieces.log(&twice, options())),
    ]
}

#[test]
fn message_order_does_not_change_the_report() {
    let directory = directory("order_any");
    for (scene, model) in RUNS {
        let bytes = log(scene, model, 1e4);
        let original = write_bytes(&directory, "whole.mcap", &bytes);
        let expected = report(&original, 0);
        let table = replay(&original, &["--csv", "-"], 0, &[]);
        let results = [&expected["criteria"], &expected["grasp"], &expected["contacts"]];
        assert!(results.iter().any(|figures| !figures.is_null()) && expected["samples"].as_u64() > Some(50), "{scene}");
        for (order, bytes) in reorderings(&read_contents(&bytes)) {
            let label = format!("{scene}, {}, {order}", model.name());
            let path = write_bytes(&directory, "reordered.mcap", &bytes);
            let mut document = report(&path, 0);
            if order == "every message twice" {
                document["messages"] = expected["messages"].clone();
            }
            assert_eq!(document, expected, "{label}");
            assert_eq!(stdout(&replay(&path, &["--csv", "-"], 0, &[])), stdout(&table), "{label}");
        }
    }
}

#[test]
fn verifies_messages_in_any_order() {
    let directory = directory("order_verify");
    for (scene, model) in [(FINGER_SCENE, Model::Engine), (GRIPPER, Model::Analytic), (DISC_SCENE, Model::Analytic)] {
        let bytes = log(scene, model, 1e4);
        let samples = &report(&write_bytes(&directory, "whole.mcap", &bytes), 0)["samples"];
        let contents = read_contents(&bytes);
        for (order, bytes) in reorderings(&contents) {
            let path = write_bytes(&directory, "reordered.mcap", &bytes);
            let verification = &report_of(&path, &["--verify"], 0)["verification"];
            assert_eq!((&verification["same"], &verification["complete"]), (&true.into(), &true.into()), "{order}");
            assert_eq!(&verification["samples_compared"], samples, "{scene}, {order}");
        }
        // A modified value is found in any order.
        let mut messages = shuffle(&contents.messages, 9);
        let index = messages.iter().position(|message| message.topic == "/energy").expect("a message");
        *messages[index].data.last_mut().expect("a byte") ^= 1;
        let path = write_bytes(&directory, "planted.mcap", &contents.log(&messages, options()));
        let verification = &report_of(&path, &["--verify"], 1)["verification"];
        assert_eq!((&verification["same"], &verification["samples_differing"]), (&false.into(), &1.into()), "{scene}");
        assert_eq!(verification["first_difference"]["quantity"], "balance_j");
        // So is an event at another log time, because the class depends on the order of events and samples.
        let mut messages = shuffle(&contents.messages, 9);
        let times: Vec<u64> = messages.iter().filter(|m| m.topic == "/event").map(|m| m.log_time_ns).collect();
        let passes_none = |time: u64| !times.iter().any(|other| (time + 1..=time + 200).contains(other));
        let mut events = messages.iter_mut().filter(|message| message.topic == "/event");
        let event = events.find(|event| passes_none(event.log_time_ns)).expect("an event before no other");
        event.log_time_ns += 100;
        let path = write_bytes(&directory, "displaced.mcap", &contents.log(&messages, options()));
        let verification = &report_of(&path, &["--verify"], 1)["verification"];
        assert_eq!(verification["events_differing"], 1, "{scene}: {verification:#}");
    }
}

/// A truncated log without index is readable up to the truncation, in any order.
#[test]
fn reads_a_truncated_log_out_of_order() {
    let directory = directory("order_cut");
    let bytes = log(FINGER_SCENE, Model::Analytic, 1e5);
    let contents = read_contents(&bytes);
    let mut by_time = shuffle(&contents.messages, 3);
    by_time.sort_by_key(|message| message.log_time_ns);
    let bytes = contents.log(&by_time, options());
    let truncated = write_bytes(&directory, "cut.mcap", &bytes[..bytes.len() / 2]);
    let document = report(&truncated, 1);
    assert_eq!((&document["whole"], &document["criteria"]), (&false.into(), &Value::Null));
    assert!(document["samples"].as_u64() > Some(500), "{document}");
    assert!(document["losses"][0]["what"].as_str().expect("a string").contains("truncated"), "{document}");
}

/// Removes the messages of a topic for which `drops` returns true, by their index on the topic.
fn remove_messages(pieces: &LogContents, topic: &str, drops: &dyn Fn(usize) -> bool) -> Vec<u8> {
    let mut count = 0;
    let remaining = pieces.messages.iter().filter(|message| {
        let is_dropped = message.topic == topic && drops(count);
        count += usize::from(message.topic == topic);
        !is_dropped
    });
    pieces.log(&remaining.cloned().collect::<Vec<_>>(), options())
}

#[test]
fn reports_a_missing_topic_and_omits_dependent_results() {
    let directory = directory("order_missing");
    // Topics without which there is no verdict, and others.
    let finger = ["/joint/q11 /joint/q22 /contact/proximal /contact/distal /event /events", "/energy /contact/limit"];
    let gripper =
        ["/joint/right_q11 /joint/left_q12 /body/object /contact/palm /contact/left_distal /event /events", "/energy"];
    let discs = ["/body/hammer /contact/hammer-anvil /event /events", "/energy"];
    let every: &dyn Fn(usize) -> bool = &|_| true;
    let third: &dyn Fn(usize) -> bool = &|count| count % 3 == 1;
    for (scene, model) in RUNS {
        let of_scene = [(FINGER_SCENE, finger), (GRIPPER, gripper), (DISC_SCENE, discs)];
        let [required, others] = of_scene.into_iter().find(|(name, _)| *name == scene).expect("a known scene").1;
        let contents = read_contents(&log(scene, model, 1e4));
        let required = required.split(' ').map(|topic| (topic, false));
        for (topic, has_verdict) in required.chain(others.split(' ').map(|topic| (topic, true))) {
            for (amount, drops) in [("all", every), ("some", third)] {
                let count = contents.messages.iter().filter(|message| message.topic == topic).count();
                if amount == "some" && (count < 2 || topic == "/events") {
                    continue;
                }
                let label = format!("{scene}, {}: {amount} of {topic}", model.name());
                let path = write_bytes(&directory, "without.mcap", &remove_messages(&contents, topic, drops));
                let document = json(&replay(&path, &["--json"], 1, &[&format!("missing data: {topic} ")]));
                let missing = document["missing"].as_array().expect("a list");
                assert!(missing.iter().any(|missing| missing["topic"] == topic), "{label}: {missing:?}");
                assert_eq!(document["whole"], true, "{label}: nothing is damaged");
                let verdicts = [&document["criteria"], &document["grasp"]].iter().any(|verdict| !verdict.is_null());
                assert_eq!(verdicts, has_verdict && scene != DISC_SCENE, "{label}");
                assert!(document["samples"].as_u64() > Some(50), "{label}: other topics are read");
                let text = replay(&path, &[], 1, &[]);
                assert!(stdout(&text).contains(&format!("MISSING: {topic} ")), "{label}:\n{}", stdout(&text));
                assert!(!stdout(&text).contains("NaN"), "{label}:\n{}", stdout(&text));
                let has_words = ["stable", "not grasped", "held since"].iter().any(|word| stdout(&text).contains(word));
                assert!(has_verdict || !has_words, "{label}:\n{}", stdout(&text));
                // A contact with a missing topic has no results.
                if let Some(name) = topic.strip_prefix("/contact/") {
                    assert_eq!(document["contacts"][name], Value::Null, "{label}");
                }
                if topic == "/energy" && amount == "all" {
                    assert_eq!(document["energy"], Value::Null, "{label}");
                }
            }
        }
        // Topics of the 3-D view are not required.
        let is_required =
            |message: &&Message| !["/tf", "/tf_static", "/scene", "/forces"].contains(&message.topic.as_str());
        let remaining: Vec<Message> = contents.messages.iter().filter(is_required).cloned().collect();
        let path = write_bytes(&directory, "undrawn.mcap", &contents.log(&remaining, options()));
        assert_eq!(report(&path, 0)["missing"], Value::Array(Vec::new()), "{scene}");
    }
}

#[test]
fn every_mode_reports_missing_topics() {
    let directory = directory("order_modes");
    let bytes = log(FINGER_SCENE, Model::Analytic, 1e4);
    let original = write_bytes(&directory, "whole.mcap", &bytes);
    let contents = read_contents(&bytes);
    let path = write_bytes(&directory, "without.mcap", &remove_messages(&contents, "/contact/distal", &|_| true));
    let name = |file: &str| path_in(&directory, file);
    let replay = |log: &Path, args: &[&str]| replay(log, args, 1, &["missing data: /contact/distal "]);
    // Its columns are empty.
    let output = replay(&path, &["--csv", "-"]);
    let heads: Vec<&str> = stdout(&output).lines().next().expect("names").split(',').collect();
    let last: Vec<&str> = stdout(&output).lines().last().expect("a row").split(',').collect();
    let cell = |column: &str| last[heads.iter().position(|head| *head == column).expect("a column")];
    assert_eq!(cell("distal_normal_n"), "");
    assert!(cell("proximal_normal_n").parse::<f64>().is_ok() && cell("q11_rad").parse::<f64>().is_ok());
    replay(&path, &["--csv", &name("table.csv")]);
    // No page is written.
    replay(&path, &["--plot", &name("page.html")]);
    assert!(!directory.join("page.html").exists());
    let output = replay(&path, &["--against", path_text(&original), "--json"]);
    assert_contains(stdout(&output), &["missing in "]);
    replay(&original, &["--against", path_text(&path), "--out", &name("both")]);
    assert!(!directory.join("both/page.html").exists() && directory.join("both/overlay.svg").exists());
    replay(&original, &["--against", path_text(&path), "--plot", &name("both.html")]);
    let verification = &json(&replay(&path, &["--verify", "--json"]))["verification"];
    assert_eq!((&verification["same"], &verification["complete"]), (&false.into(), &false.into()));
}

#[test]
fn incomplete_logs_have_no_class() {
    let directory = directory("order_empty");
    for (scene, model) in RUNS {
        let contents = read_contents(&log(scene, model, 1e4));
        let remaining: Vec<Message> =
            contents.messages.iter().filter(|message| message.topic == "/events").cloned().collect();
        let path = write_bytes(&directory, "empty.mcap", &contents.log(&remaining, options()));
        let document = report(&path, 1);
        assert_eq!(document["samples"], 0, "{scene}");
        assert!(document["criteria"].is_null() && document["grasp"].is_null(), "{scene}: {document}");
        assert!(document["missing"].as_array().expect("a list").len() > 2, "{scene}: {document}");
    }
    // An excerpt of a run has no verdict either.
    let contents = read_contents(&log(FINGER_SCENE, Model::Analytic, 1e4));
    let delayed: Vec<Message> =
        contents.messages.iter().filter(|message| message.log_time_ns > 3_000_000).cloned().collect();
    let path = write_bytes(&directory, "late.mcap", &contents.log(&delayed, options()));
    let document = report(&path, 1);
    assert_eq!(document["criteria"], Value::Null);
    assert!(document["missing"].to_string().contains("has no message before 3."), "{document}");
}

#[test]
fn reads_lz4_and_reports_unknown_compression() {
    let directory = directory("order_lz4");
    for (scene, model) in [(FINGER_SCENE, Model::Analytic), (GRIPPER, Model::Engine), (DISC_SCENE, Model::Engine)] {
        let bytes = log(scene, model, 1e4);
        let expected = report(&write_bytes(&directory, "whole.mcap", &bytes), 0);
        let contents = read_contents(&bytes);
        let uncompressed = contents.log(&contents.messages, options().compression(None::<Compression>));
        assert_eq!(report(&write_bytes(&directory, "plain.mcap", &uncompressed), 0), expected, "{scene}");
        let compressed = contents.log(&contents.messages, options().compression(Some(Compression::Lz4)));
        assert!(compressed.len() < uncompressed.len(), "{scene}");
        assert_eq!(report(&write_bytes(&directory, "lz4.mcap", &compressed), 0), expected, "{scene}");
        // A chunk that cannot be decompressed counts as damaged.
        let broken = recompress_chunks(&uncompressed, "lz4", &|records| records.to_vec());
        let document = report(&write_bytes(&directory, "broken.mcap", &broken), 1);
        assert!(document["losses"].to_string().contains("cannot be decompressed"), "{document}");
        // An unknown compression is reported, but not as damage.
        let unknown = recompress_chunks(&uncompressed, "brotli", &|records| records.to_vec());
        let path = write_bytes(&directory, "brotli.mcap", &unknown);
        let parts = ["compressed with \"brotli\"", "not supported", "mcap compress"];
        let output = replay(&path, &["--json"], 1, &parts);
        assert!(!stderr(&output).contains("damaged"), "{}", stderr(&output));
        let document = json(&output);
        assert!(document["criteria"].is_null() && document["grasp"].is_null(), "{document}");
    }
}

/// A log of 15 ms whose metadata request 150 s is inconsistent; simulating it again stops at the end of the log.
#[test]
fn reports_an_inconsistent_log_immediately() {
    let directory = directory("order_contradiction");
    for scene in [DISC_SCENE, FINGER_SCENE] {
        let longer = |entries: &mut BTreeMap<String, String>| {
            entries.insert("duration_s".to_string(), "150".to_string());
        };
        let bytes = edit_log(&log(scene, Model::Analytic, 1e4), &LogEdits { metadata: &longer, ..LogEdits::default() });
        let path = write_bytes(&directory, "long.mcap", &bytes);
        let start = Instant::now();
        let report = json(&replay(&path, &["--json"], 1, &["the log is inconsistent"]));
        assert_eq!((&report["completed"], &report["criteria"]), (&false.into(), &Value::Null));
        assert_contains(stdout(&phalanx(&["replay", path_text(&path)])), &["NOT COMPLETED: stopped at "]);
        let report = &report_of(&path, &["--verify"], 1)["verification"];
        assert_eq!(report["complete"], false, "{report:#}");
        assert!(report["samples_compared"].as_u64() > Some(50), "{report:#}");
        assert!(start.elapsed() < Duration::from_secs(60));
    }
}
