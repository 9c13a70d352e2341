//! Logs whose messages stand in another order, lack topics, or are compressed otherwise: the same figures, or a reason and exit status 1.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::{Duration, Instant};

use mcap::{Compression, WriteOptions};
use phalanx::trace::Model;
use serde_json::Value;

use crate::support::cli::{directory, json, phalanx, stderr, stdout};
use crate::support::faults::Dice;
use crate::support::replay::{Changes, DISCS, FINGER, Message, Pieces, changed, log, recompressed, taken_apart};

const GRIPPER: &str = "scenes/gripper/hold.toml";

const RUNS: [(&str, Model); 6] = [
    (FINGER, Model::Analytic),
    (FINGER, Model::Engine),
    (GRIPPER, Model::Analytic),
    (GRIPPER, Model::Engine),
    (DISCS, Model::Analytic),
    (DISCS, Model::Engine),
];

fn keep(directory: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = directory.join(name);
    fs::write(&path, bytes).expect("written");
    path
}

fn replay(log: &Path, more: &[&str]) -> Output {
    phalanx(&[&["replay", log.to_str().expect("text")], more].concat())
}

/// What is reported of a log, without its name, its size and channels that have no message.
fn report(log: &Path, status: i32) -> Value {
    let output = replay(log, &["--json"]);
    assert_eq!(output.status.code(), Some(status), "{}", stderr(&output));
    let mut report = json(&output);
    for key in ["log", "bytes"] {
        report.as_object_mut().expect("an object").remove(key);
    }
    report
}

/// Small chunks, so that there are many.
fn options() -> WriteOptions {
    WriteOptions::new().chunk_size(Some(8 << 10))
}

fn shuffled(messages: &[Message], seed: u64) -> Vec<Message> {
    let (mut dice, mut messages) = (Dice::new(seed), messages.to_vec());
    for k in (1..messages.len()).rev() {
        messages.swap(k, dice.below(k + 1));
    }
    messages
}

/// The log in many orders, by what each is called.
fn reordered(pieces: &Pieces) -> Vec<(&'static str, Vec<u8>)> {
    let written = &pieces.messages;
    let random = shuffled(written, 7);
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
fn the_order_of_messages_says_nothing() {
    let directory = directory("order_any");
    for (scene, model) in RUNS {
        let bytes = log(scene, model, 1e4);
        let whole = keep(&directory, "whole.mcap", &bytes);
        let expected = report(&whole, 0);
        let table = replay(&whole, &["--csv", "-"]);
        let judged = [&expected["criteria"], &expected["grasp"], &expected["contacts"]];
        assert!(judged.iter().any(|figures| !figures.is_null()) && expected["samples"].as_u64() > Some(50), "{scene}");
        for (order, bytes) in reordered(&taken_apart(&bytes)) {
            let what = format!("{scene}, {}, {order}", model.name());
            let path = keep(&directory, "reordered.mcap", &bytes);
            let mut found = report(&path, 0);
            if order == "every message twice" {
                found["messages"] = expected["messages"].clone();
            }
            assert_eq!(found, expected, "{what}");
            assert_eq!(stdout(&replay(&path, &["--csv", "-"])), stdout(&table), "{what}");
        }
    }
}

#[test]
fn the_same_content_verifies_in_any_order() {
    let directory = directory("order_verify");
    for (scene, model) in [(FINGER, Model::Engine), (GRIPPER, Model::Analytic), (DISCS, Model::Analytic)] {
        let pieces = taken_apart(&log(scene, model, 1e4));
        for (order, bytes) in reordered(&pieces) {
            let path = keep(&directory, "reordered.mcap", &bytes);
            let output = replay(&path, &["--verify", "--json"]);
            if order == "every message twice" {
                assert_eq!(output.status.code(), Some(1), "{scene}, {order}");
                continue;
            }
            assert_eq!(output.status.code(), Some(0), "{scene}, {order}: {}", stderr(&output));
            let found = &json(&output)["verification"];
            assert_eq!((&found["same"], &found["complete"]), (&true.into(), &true.into()), "{scene}, {order}");
            assert_eq!(found["messages_compared"], pieces.messages.len(), "{scene}, {order}");
            let counted = |key: &str| found[key].as_u64().expect("a count") > 0;
            assert_eq!(counted("messages_unnumbered"), order == "without numbers", "{scene}, {order}");
            if order == "topics backwards at each time" {
                assert!(counted("messages_reordered"), "{scene}, {order}");
                let text = replay(&path, &["--verify"]);
                for part in ["sequence number and payload", "not compared: the order of messages of one log time"] {
                    assert!(stdout(&text).contains(part), "{}", stdout(&text));
                }
            }
        }
        // Another value is found in any order.
        let mut messages = shuffled(&pieces.messages, 9);
        let place = messages.iter().position(|message| message.topic == "/energy").expect("there");
        *messages[place].data.last_mut().expect("a byte") ^= 1;
        let path = keep(&directory, "planted.mcap", &pieces.log(&messages, options()));
        let output = replay(&path, &["--verify", "--json"]);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        let found = &json(&output)["verification"];
        assert_eq!((&found["same"], &found["messages_differing"]), (&false.into(), &1.into()), "{scene}");
        assert_eq!(found["first_difference"]["channel"], "/energy");
    }
}

/// A log in any order that is cut off, without its index, is read as far as it is there.
#[test]
fn a_log_out_of_order_that_is_cut_off_is_read_as_far_as_it_goes() {
    let directory = directory("order_cut");
    let bytes = log(FINGER, Model::Analytic, 1e5);
    let pieces = taken_apart(&bytes);
    let mut by_time = shuffled(&pieces.messages, 3);
    by_time.sort_by_key(|message| message.log_time_ns);
    let bytes = pieces.log(&by_time, options());
    let cut = keep(&directory, "cut.mcap", &bytes[..bytes.len() / 2]);
    let found = report(&cut, 1);
    assert_eq!((&found["whole"], &found["criteria"]), (&false.into(), &Value::Null));
    assert!(found["samples"].as_u64() > Some(500), "{found}");
    assert!(found["losses"][0]["what"].as_str().expect("words").contains("truncated"), "{found}");
    // What can be read of it is in order, and whole.
    let recovered = directory.join("recovered.mcap");
    let output = replay(&cut, &["--recover", recovered.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    // The cut may go through the messages of its last sample.
    let read = json(&replay(&recovered, &["--json"]));
    assert_eq!((&read["whole"], &read["samples"]), (&true.into(), &found["samples"]));
    let last = |missing: &Value| missing["what"].as_str().expect("words").starts_with("lacks 1 of ");
    assert!(read["missing"].as_array().expect("a list").iter().all(last), "{read}");
    // Chunks behind a damage are part of a log in any order, for its index lists them.
    let mut damaged = pieces.log(&shuffled(&pieces.messages, 4), options());
    let middle = damaged.len() / 3;
    damaged[middle] ^= 1;
    let damaged = keep(&directory, "damaged.mcap", &damaged);
    let output = replay(&damaged, &["--recover", recovered.to_str().expect("text"), "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(json(&output)["messages"].as_u64() > Some(pieces.messages.len() as u64 * 9 / 10), "{}", stdout(&output));
}

/// The log without the messages of a topic that `drops` takes, by their number on it.
fn without(pieces: &Pieces, topic: &str, drops: &dyn Fn(usize) -> bool) -> Vec<u8> {
    let mut count = 0;
    let kept = pieces.messages.iter().filter(|message| {
        let drop = message.topic == topic && drops(count);
        count += usize::from(message.topic == topic);
        !drop
    });
    pieces.log(&kept.cloned().collect::<Vec<_>>(), options())
}

#[test]
fn a_missing_topic_is_named_and_nothing_that_needs_it_is_said() {
    let directory = directory("order_missing");
    // Topics, and whether the run is judged without them.
    let finger: &[(&str, bool)] = &[
        ("/state", false),
        ("/contact/proximal", false),
        ("/contact/distal", false),
        ("/impact/proximal", false),
        ("/impact/distal", false),
        ("/events", false),
        ("/energy", true),
        ("/limit", true),
    ];
    let gripper: &[(&str, bool)] = &[
        ("/state/right", false),
        ("/state/left", false),
        ("/object", false),
        ("/contact/palm", false),
        ("/contact/left_distal", false),
        ("/impact/right_proximal", false),
        ("/events", false),
        ("/energy", true),
        ("/slip/right_proximal", true),
    ];
    let discs: &[(&str, bool)] = &[
        ("/disc/hammer", false),
        ("/contact/hammer-anvil", false),
        ("/impact/hammer-anvil", false),
        ("/events", false),
        ("/energy", true),
    ];
    let every: &dyn Fn(usize) -> bool = &|_| true;
    let third: &dyn Fn(usize) -> bool = &|count| count % 3 == 1;
    for (scene, model) in RUNS {
        let topics = [(FINGER, finger), (GRIPPER, gripper), (DISCS, discs)].into_iter().find(|of| of.0 == scene);
        let pieces = taken_apart(&log(scene, model, 1e4));
        for &(topic, judged) in topics.expect("one of them").1 {
            for (how, drops) in [("all", every), ("some", third)] {
                let count = pieces.messages.iter().filter(|message| message.topic == topic).count();
                if how == "some" && (count < 2 || topic == "/events") {
                    continue;
                }
                let what = format!("{scene}, {}: {how} of {topic}", model.name());
                let path = keep(&directory, "without.mcap", &without(&pieces, topic, drops));
                let output = replay(&path, &["--json"]);
                assert_eq!(output.status.code(), Some(1), "{what}: {}", stderr(&output));
                assert!(stderr(&output).contains(&format!("missing topic: {topic} ")), "{what}: {}", stderr(&output));
                let found = json(&output);
                let missing = found["missing"].as_array().expect("a list");
                assert!(missing.iter().any(|missing| missing["topic"] == topic), "{what}: {missing:?}");
                assert_eq!(found["whole"], true, "{what}: nothing is damaged");
                let verdicts = [&found["criteria"], &found["grasp"]].iter().any(|verdict| !verdict.is_null());
                assert_eq!(verdicts, judged && scene != DISCS, "{what}");
                assert!(found["samples"].as_u64() > Some(50), "{what}: the rest is there");
                let text = replay(&path, &[]);
                assert_eq!(text.status.code(), Some(1), "{what}");
                assert!(stdout(&text).contains(&format!("MISSING: {topic} ")), "{what}:\n{}", stdout(&text));
                assert!(!stdout(&text).contains("NaN"), "{what}:\n{}", stdout(&text));
                if !judged {
                    let words = ["stable", "not grasped", "held first"];
                    assert!(!words.iter().any(|word| stdout(&text).contains(word)), "{what}:\n{}", stdout(&text));
                }
                // A contact of which a topic is missing has no figures.
                if let Some(name) = ["/contact/", "/impact/"].iter().find_map(|folder| topic.strip_prefix(folder)) {
                    assert_eq!(found["contacts"][name], Value::Null, "{what}");
                }
                if topic == "/energy" && how == "all" {
                    assert_eq!(found["energy"], Value::Null, "{what}");
                }
            }
        }
        // What is only drawn is not needed.
        let shown = |message: &&Message| !["/tf", "/tf_static", "/scene", "/forces"].contains(&message.topic.as_str());
        let kept: Vec<Message> = pieces.messages.iter().filter(shown).cloned().collect();
        let path = keep(&directory, "undrawn.mcap", &pieces.log(&kept, options()));
        assert_eq!(report(&path, 0)["missing"], Value::Array(Vec::new()), "{scene}");
    }
}

#[test]
fn every_mode_says_what_is_missing() {
    let directory = directory("order_modes");
    let bytes = log(FINGER, Model::Analytic, 1e4);
    let whole = keep(&directory, "whole.mcap", &bytes);
    let pieces = taken_apart(&bytes);
    let path = keep(&directory, "without.mcap", &without(&pieces, "/contact/distal", &|_| true));
    let name = |file: &str| directory.join(file).to_str().expect("text").to_string();
    let named = |output: &Output| {
        assert_eq!(output.status.code(), Some(1), "{}", stderr(output));
        assert!(stderr(output).contains("missing topic: /contact/distal "), "{}", stderr(output));
    };
    // Its columns are empty.
    let output = replay(&path, &["--csv", "-"]);
    named(&output);
    let heads: Vec<&str> = stdout(&output).lines().next().expect("names").split(',').collect();
    let last: Vec<&str> = stdout(&output).lines().last().expect("a row").split(',').collect();
    let cell = |column: &str| last[heads.iter().position(|head| *head == column).expect("a column")];
    assert_eq!(cell("distal_normal_n"), "");
    assert!(cell("proximal_normal_n").parse::<f64>().is_ok() && cell("q11_rad").parse::<f64>().is_ok());
    named(&replay(&path, &["--csv", &name("table.csv")]));
    // No page, and none is left.
    named(&replay(&path, &["--html", &name("page.html")]));
    assert!(!directory.join("page.html").exists());
    let output = replay(&path, &["--against", whole.to_str().expect("text"), "--json"]);
    named(&output);
    assert!(stdout(&output).contains("missing in "), "{}", stdout(&output));
    let output = replay(&whole, &["--against", path.to_str().expect("text"), "--out", &name("both")]);
    named(&output);
    assert!(!directory.join("both/page.html").exists() && directory.join("both/overlay.svg").exists());
    named(&replay(&whole, &["--against", path.to_str().expect("text"), "--html", &name("both.html")]));
    let output = replay(&path, &["--verify", "--json"]);
    named(&output);
    let found = &json(&output)["verification"];
    assert_eq!((&found["same"], &found["complete"]), (&false.into(), &false.into()));
    let output = replay(&path, &["--recover", &name("recovered.mcap")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("MISSING: /contact/distal "), "{}", stdout(&output));
}

#[test]
fn a_log_without_samples_has_no_class() {
    let directory = directory("order_empty");
    for (scene, model) in RUNS {
        let pieces = taken_apart(&log(scene, model, 1e4));
        let kept: Vec<Message> = pieces.messages.iter().filter(|message| message.topic == "/events").cloned().collect();
        let path = keep(&directory, "empty.mcap", &pieces.log(&kept, options()));
        let found = report(&path, 1);
        assert_eq!(found["samples"], 0, "{scene}");
        assert!(found["criteria"].is_null() && found["grasp"].is_null(), "{scene}: {found}");
        assert!(found["missing"].as_array().expect("a list").len() > 2, "{scene}: {found}");
    }
    // A part of a run is not judged either.
    let pieces = taken_apart(&log(FINGER, Model::Analytic, 1e4));
    let late: Vec<Message> =
        pieces.messages.iter().filter(|message| message.log_time_ns > 3_000_000).cloned().collect();
    let path = keep(&directory, "late.mcap", &pieces.log(&late, options()));
    let found = report(&path, 1);
    assert_eq!(found["criteria"], Value::Null);
    assert!(found["missing"].to_string().contains("has no message before 3."), "{found}");
}

#[test]
fn lz4_is_read_and_an_unknown_compression_is_named() {
    let directory = directory("order_lz4");
    for (scene, model) in [(FINGER, Model::Analytic), (GRIPPER, Model::Engine), (DISCS, Model::Engine)] {
        let bytes = log(scene, model, 1e4);
        let expected = report(&keep(&directory, "whole.mcap", &bytes), 0);
        let pieces = taken_apart(&bytes);
        let plain = pieces.log(&pieces.messages, options().compression(None::<Compression>));
        assert_eq!(report(&keep(&directory, "plain.mcap", &plain), 0), expected, "{scene}");
        let lz4 = |records: &[u8]| {
            let mut out = lz4_flex::frame::FrameEncoder::new(Vec::new());
            out.write_all(records).expect("compressed");
            out.finish().expect("compressed")
        };
        let compressed = recompressed(&plain, "lz4", &lz4);
        assert!(compressed.len() < plain.len(), "{scene}");
        let path = keep(&directory, "lz4.mcap", &compressed);
        assert_eq!(report(&path, 0), expected, "{scene}");
        // What does not decompress is damaged.
        let broken = recompressed(&plain, "lz4", &|records| lz4(&records[..records.len() / 2]));
        let found = report(&keep(&directory, "broken.mcap", &broken), 1);
        assert!(found["losses"].to_string().contains("not of the size"), "{found}");
        // One that nobody here knows is named, and is no damage.
        let other = recompressed(&plain, "brotli", &|records| records.to_vec());
        let path = keep(&directory, "brotli.mcap", &other);
        let output = replay(&path, &["--json"]);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        for part in ["compressed with \"brotli\"", "not supported", "mcap compress"] {
            assert!(stderr(&output).contains(part), "no {part} in {}", stderr(&output));
        }
        assert!(!stderr(&output).contains("damaged"), "{}", stderr(&output));
        let found = json(&output);
        assert!(found["criteria"].is_null() && found["grasp"].is_null(), "{found}");
    }
}

/// A log of 15 ms whose metadata ask for 1e50 s: both cannot be true, and to simulate that again takes no longer than the log.
#[test]
fn a_log_that_contradicts_itself_says_so_at_once() {
    let directory = directory("order_contradiction");
    for scene in [DISCS, FINGER] {
        let longer = |entries: &mut BTreeMap<String, String>| {
            entries.insert("duration_s".to_string(), "150".to_string());
        };
        let bytes = changed(&log(scene, Model::Analytic, 1e4), &Changes { metadata: &longer, ..Changes::default() });
        let path = keep(&directory, "long.mcap", &bytes);
        let start = Instant::now();
        let output = replay(&path, &["--json"]);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(stderr(&output).contains("contradicts itself"), "{}", stderr(&output));
        let found = json(&output);
        assert_eq!((&found["completed"], &found["criteria"]), (&false.into(), &Value::Null));
        assert!(stdout(&replay(&path, &[])).contains("NOT COMPLETED: stopped at "));
        let output = replay(&path, &["--verify", "--json"]);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        let found = &json(&output)["verification"];
        assert_eq!(found["complete"], false, "{found:#}");
        assert!(found["messages_compared"].as_u64() > Some(100), "{found:#}");
        assert!(start.elapsed() < Duration::from_secs(60));
    }
}
