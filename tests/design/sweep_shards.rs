//! Sweeps in parts: any parts in any order merge into the bytes of an undivided sweep. Missing, duplicate, damaged and
//! foreign parts are reported, and no file is overwritten.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::support::cli::{
    assert_contains, assert_rejected, assert_status, directory, json, path_text as text, stderr, write,
};
use crate::support::faults::XorShift;
use crate::support::studies::{write_short_study, write_short_study_as};
use phalanx::study::parts::{PartOptions, merge, write_part};
use phalanx::study::results::ResultsError;
use phalanx::study::sweep::{Study, load, shard, shard_range, summary};
use phalanx::table;

const KEEP_RUNNING: &(dyn Fn() -> bool + Sync) = &|| true;

/// Runs `phalanx sweep` and asserts success.
#[track_caller]
fn succeed(args: &[&str]) -> Output {
    assert_status(&[&["sweep"], args].concat(), 0, &[])
}

/// Asserts that `phalanx sweep` is rejected with these words; returns the message.
#[track_caller]
fn assert_failed(args: &[&str], words: &[&str]) -> String {
    assert_rejected(&[&["sweep"], args].concat(), words)
}

/// Simulates a part with the library and returns its path.
fn part(study: &Study, (number, count): (u64, u64), directory: &Path) -> PathBuf {
    let out = directory.join(format!("{number}-of-{count}.parquet"));
    let shard = shard(study, number, count).expect("a valid part");
    let options = PartOptions { threads: 1, restart: false };
    write_part(study, shard, &out, options, KEEP_RUNNING, |_| ()).unwrap_or_else(|error| panic!("{error}"));
    out
}

fn bytes(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Sorted names of the entries of a directory.
fn names(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).expect("a directory");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Results with their file of the study.
fn results(out: &Path) -> [Vec<u8>; 2] {
    [bytes(out), bytes(&PathBuf::from(format!("{}.study.json", out.display())))]
}

/// Results of the undivided sweep in both formats.
fn run_undivided(study: &str, directory: &Path) -> [(&'static str, [Vec<u8>; 2]); 2] {
    ["csv", "parquet"].map(|format| {
        let out = directory.join(format!("whole.{format}"));
        succeed(&[study, "--out", text(&out), "--threads", "2", "--restart"]);
        (format, results(&out))
    })
}

/// Asserts that the parts merge into these results.
#[track_caller]
fn assert_merges_to(
    study: &Study,
    parts: &[PathBuf],
    undivided: &[(&str, [Vec<u8>; 2])],
    directory: &Path,
    case: &str,
) {
    for (format, expected) in undivided {
        let out = directory.join(format!("joined.{format}"));
        let merged = merge(study, parts, &out, &|| true, &mut |_| ()).unwrap_or_else(|error| panic!("{case}: {error}"));
        assert!(results(&out) == *expected, "{case}: {format} differs");
        assert_eq!((merged.summary.runs, merged.bytes), (study.runs(), expected[0].len() as u64), "{case}");
        let all = summary(&table::read(&out).expect("a table"));
        assert_eq!(merged.summary, all.expect("results of a sweep"), "{case}: the summary is that of all rows");
    }
}

#[test]
fn any_number_of_parts_in_any_order_merges_to_the_undivided_results() {
    let directory = directory("shards_bytes");
    let file = write_short_study(&directory, 60);
    let undivided = run_undivided(&file, &directory);
    let study = load(&file).expect("a study");
    let mut rng = XorShift::new(18);
    // With more parts than runs, some parts are empty.
    for count in [1, 2, 7, 60, 97] {
        let mut parts: Vec<PathBuf> = (1..=count).map(|number| part(&study, (number, count), &directory)).collect();
        for last in (1..parts.len()).rev() {
            parts.swap(last, rng.below(last + 1));
        }
        assert_merges_to(&study, &parts, &undivided, &directory, &format!("{count} parts"));
    }
    // A half, a sixth and a third.
    let parts = [(2, 2), (1, 3), (3, 6)].map(|shard| part(&study, shard, &directory));
    assert_merges_to(&study, &parts, &undivided, &directory, "parts of three counts");
}

const GRIPPER: &str = r#"
[scene]
kind = "gripper"
duration = "15 ms"
sizing = "rigid"
palm_width = "34 mm"
positioning_error = "3 mm"
[scene.design]
base = "15.5 mm"
l21_fraction = 1.0
phi22 = "120 deg"
arm_ratio = 0.5
[scene.table]
[[axes]]
field = "object.offset"
values = ["0 mm", "2 mm", "-2 mm", "5 mm"]
"#;

#[test]
fn the_command_makes_and_merges_parts_of_fingers_and_grippers() {
    let directory = directory("shards_command");
    let studies =
        [("finger", write_short_study(&directory, 90)), ("gripper", write(&directory, "gripper.toml", GRIPPER))];
    for (name, study) in studies {
        let undivided = run_undivided(&study, &directory);
        let parts = directory.join(name);
        fs::create_dir(&parts).expect("made");
        let mut total_runs = 0;
        for number in [2, 3, 1] {
            let (shard, out) = (format!("{number}/3"), parts.join(format!("{number}.parquet")));
            let report = json(&succeed(&[&study, "--shard", &shard, "--out", text(&out), "--json"]));
            assert_eq!((report["shard"].as_u64(), report["of"].as_u64()), (Some(number), Some(3)), "{report:#}");
            let run = |key: &str| report[key].as_u64().expect("a run");
            let counts = report["by_status"].as_object().expect("counts").values();
            let runs = run("last_run") + 1 - run("first_run");
            assert_eq!(counts.map(|count| count.as_u64().expect("a count")).sum::<u64>(), runs, "{report:#}");
            total_runs += runs;
            // The metadata are readable by other Parquet tools.
            let groups = table::RowGroups::open(&out).expect("a table");
            let metadata = groups.metadata_value("phalanx.part").expect("metadata");
            let metadata: serde_json::Value = serde_json::from_str(metadata).expect("JSON");
            for (key, value) in [("shard", number), ("of", 3), ("first_run", run("first_run"))] {
                assert_eq!(metadata[key], value, "{key}");
            }
            assert_eq!(metadata["runs"], load(&study).expect("a study").runs());
        }
        assert_eq!(names(&parts), ["1.parquet", "2.parquet", "3.parquet"], "no other file is left");
        // The parts as a directory, and as files.
        let files = ["3", "1", "2"].map(|number| parts.join(format!("{number}.parquet")));
        let files: Vec<&str> = files.iter().map(|file| text(file)).collect();
        for (format, expected) in &undivided {
            let out = directory.join(format!("{name}.{format}"));
            for arguments in [&[text(&parts)][..], &files] {
                let report =
                    json(&succeed(&[&["merge", study.as_str()], arguments, &["--out", text(&out), "--json"]].concat()));
                let counts = (report["parts"].as_u64(), report["runs"].as_u64());
                assert_eq!(counts, (Some(3), Some(total_runs)), "{report:#}");
                assert!(results(&out) == *expected, "{name}.{format}");
            }
        }
        // The undivided sweep recognises the merged results as its own.
        let output = succeed(&[&study, "--out", text(&directory.join(format!("{name}.csv")))]);
        assert!(stderr(&output).contains("already contains all runs of this study"), "{}", stderr(&output));
    }
}

#[test]
fn existing_parts_and_other_files_are_kept() {
    let directory = directory("shards_there");
    let study = write_short_study(&directory, 40);
    let other = write_short_study_as(&directory, "other.toml", 44);
    let out = directory.join("part.parquet");
    let arguments = |shard: &'static str| [study.as_str(), "--shard", shard, "--out", text(&out), "--json"];
    let make = |flags: &[&str]| json(&succeed(&[&arguments("2/4")[..], flags].concat()));
    let first = make(&[]);
    assert_eq!(first["now"]["runs"], 10);
    let modified = || fs::metadata(&out).and_then(|metadata| metadata.modified()).expect("a time");
    let (original, time) = (bytes(&out), modified());
    let repeated = succeed(&arguments("2/4"));
    assert!(stderr(&repeated).contains("already contains shard 2/4 of this study; nothing was run"));
    let repeated = json(&repeated);
    assert_eq!((&repeated["now"]["runs"], &repeated["by_status"]), (&0.into(), &first["by_status"]));
    assert_eq!(modified(), time);

    let with = |shard, flags: &[&'static str]| [&arguments(shard)[..], flags].concat();
    let of_other = [&[other.as_str()], &arguments("2/4")[1..]].concat();
    for (args, words) in [
        (with("3/4", &[]), &["2/4", "not replaced", "--restart"][..]),
        (with("2/4", &["--check"]), &["its sweep is without --check", "not replaced"]),
        (
            with("2/4", &["--model", "engine"]),
            &["its model is --model analytic, but here it is --model engine", "not replaced"],
        ),
        (of_other, &["its study is `cheap`, but here it is `other`", "not replaced"]),
    ] {
        assert_failed(&args, words);
    }
    assert!(bytes(&out) == original);
    assert_eq!(make(&["--restart"])["now"]["runs"], 10);
    assert!(bytes(&out) == original);

    // A truncated part is not recognised. A part with a flipped bit is damaged and can be made again.
    fs::write(&out, &original[..original.len() - 100]).expect("the file is writable");
    assert_failed(&arguments("2/4"), &["not a table written by phalanx", "not replaced", "--force"]);
    let mut damaged = original.clone();
    damaged[original.len() / 3..original.len() / 2].fill(4);
    fs::write(&out, &damaged).expect("the file is writable");
    assert_failed(&arguments("2/4"), &["damaged", "run the shard again"]);
    make(&["--restart"]);
    assert!(bytes(&out) == original);

    // A foreign file is kept even with --restart, but not with --force.
    fs::write(&out, "foreign table").expect("the file is writable");
    for flags in [&[][..], &["--restart"]] {
        assert_failed(&with("2/4", flags), &["not a table written by phalanx", "not replaced"]);
    }
    assert_eq!(bytes(&out), b"foreign table");
    make(&["--force"]);
    assert!(bytes(&out) == original);
    assert_eq!(names(&directory), ["cheap.toml", "other.toml", "part.parquet"]);
}

/// Metadata of a part with other values of some keys.
fn forge(part: &Path, changes: &[(&str, serde_json::Value)]) -> Vec<(String, String)> {
    let groups = table::RowGroups::open(part).expect("a part");
    let value = |name: &str| groups.metadata_value(name).expect("metadata").to_string();
    let mut info: serde_json::Value = serde_json::from_str(&value("phalanx.part")).expect("JSON");
    for (key, value) in changes {
        info[*key] = value.clone();
    }
    [("phalanx.part", info.to_string()), ("phalanx.checksum", value("phalanx.checksum"))]
        .map(|(key, value)| (key.to_string(), value))
        .to_vec()
}

#[test]
fn invalid_parts_are_reported_and_nothing_is_written() {
    let directory = directory("shards_wrong");
    let file = write_short_study(&directory, 100);
    let study = load(&file).expect("a study");
    let out = directory.join("out.csv");
    let parts: Vec<PathBuf> = (1..=5).map(|number| part(&study, (number, 5), &directory)).collect();
    let all: Vec<&Path> = parts.iter().map(PathBuf::as_path).collect();
    let assert_rejected = |parts: &[&Path], words: &[&str]| {
        let parts: Vec<&str> = parts.iter().map(|part| text(part)).collect();
        let message = assert_failed(&[&["merge", file.as_str()], &parts[..], &["--out", text(&out)]].concat(), words);
        assert!(!out.exists() && !directory.join("out.csv.study.json").exists(), "{message}");
    };
    // Missing runs are reported with the shards that contain them.
    let words = ["40 of 100 runs are in no shard", "runs 21 to 60 (--shard 2/5 and 3/5); run these and merge again"];
    assert_rejected(&[all[4], all[0], all[3]], &words);
    // The runs between a third and a half are a sixth.
    let (third, half) = (part(&study, (1, 3), &directory), part(&study, (2, 2), &directory));
    assert_rejected(&[&half, &third], &["17 of 100 runs", "runs 34 to 50 (--shard 3/6)"]);
    let twice = [&all[..], &[&third]].concat();
    assert_rejected(&twice, &["overlap", "1-of-3.parquet", "runs 21 to 33", "remove one of each pair"]);
    assert_rejected(&[all[0], all[0]], &["overlap", "runs 1 to 20"]);
    assert_rejected(&[&directory.join("none.parquet")], &["none.parquet", "there is no such file"]);
    let strange = directory.join("strange");
    fs::create_dir(&strange).expect("made");
    assert_rejected(&[&strange], &["contains no Parquet file"]);

    // The second part is replaced by parts of another study, model or version, and by damaged ones.
    let with_second = |second: &Path, words: &[&str]| {
        assert_rejected(&[&[all[0], second], &all[2..]].concat(), words);
    };
    let other = load(write_short_study_as(&directory, "other.toml", 104)).expect("a study");
    let other_part = part(&other, (2, 5), &strange);
    with_second(&other_part, &["strange", "not a shard of this study", "`other`"]);
    let mut engine = study.clone();
    engine.model = phalanx::trace::Model::Engine;
    fs::remove_file(&other_part).expect("removed");
    with_second(&part(&engine, (2, 5), &strange), &["not a shard of this study", "--model engine"]);
    let forged = strange.join("forged.parquet");
    let [own_rows, other_rows] = [1, 2].map(|index| table::read(&parts[index]).expect("a table"));
    let older = forge(&parts[1], &[("version", "0.0.9".into()), ("fingerprint", "0".repeat(16).into())]);
    table::write_with_metadata(&forged, &own_rows, &older).expect("the file is writable");
    with_second(&forged, &["its version of phalanx is 0.0.9", "use the same for all shards"]);
    // Correct metadata with the rows of another part: the rows are verified too.
    table::write_with_metadata(&forged, &other_rows, &forge(&parts[1], &[])).expect("the file is writable");
    with_second(&forged, &["damaged", "run 21 is missing or misplaced"]);
    for (shard, count, first, last, runs, word) in [
        (1, 1, 1, u64::MAX, u64::MAX, "damaged"),
        (2, 5, 21, 40, 99, "damaged"),
        (1, 1, 1, 20, 20, "overlap"),
        (0, 0, 1, 0, 0, "damaged"),
    ] {
        let values = [("shard", shard), ("of", count), ("first_run", first), ("last_run", last), ("runs", runs)];
        let metadata = forge(&parts[1], &values.map(|(key, value)| (key, value.into())));
        table::write_with_metadata(&forged, &other_rows, &metadata).expect("the file is writable");
        with_second(&forged, &[word]);
    }
    let valid_bytes = bytes(&parts[1]);
    let mut rng = XorShift::new(5);
    for _ in 0..20 {
        fs::write(&forged, &valid_bytes[..rng.below(valid_bytes.len())]).expect("the file is writable");
        with_second(&forged, &["forged.parquet is not a shard of a sweep"]);
    }
    // A changed byte is detected, unless it changes no value.
    let mut detected = 0;
    for offset in (4..valid_bytes.len() / 2).step_by(97) {
        let mut changed = valid_bytes.clone();
        changed[offset] ^= 1;
        fs::write(&forged, &changed).expect("the file is writable");
        let files: Vec<PathBuf> = [&[all[0], &forged], &all[2..]].concat().iter().map(PathBuf::from).collect();
        match merge(&study, &files, &out, &|| true, &mut |_| ()) {
            Ok(_) => assert!(table::read(&forged).expect("a table") == own_rows, "byte {offset}"),
            Err(error) => {
                assert!(error.to_string().contains("forged.parquet is damaged"), "{error}");
                detected += 1;
            }
        }
        [&out, &directory.join("out.csv.study.json")].into_iter().for_each(|file| drop(fs::remove_file(file)));
    }
    assert!(detected > 20, "{detected}");

    // Output paths.
    let arguments: Vec<&str> = all.iter().map(|part| text(part)).collect();
    let assert_path_rejected = |out: &Path, words: &[&str]| {
        assert_failed(&[&["merge", file.as_str()], &arguments[..], &["--out", text(out)]].concat(), words);
    };
    assert_path_rejected(&directory.join("out.txt"), &["NAME.csv or NAME.parquet"]);
    assert_path_rejected(&directory.join("nowhere/out.csv"), &["mkdir -p"]);
    fs::write(&out, "foreign").expect("the file is writable");
    assert_path_rejected(&out, &["not a table written by phalanx", "not replaced", "--force"]);
    assert_eq!(bytes(&out), b"foreign");
    fs::remove_file(&out).expect("removed");
    // A shard in a directory is an input too.
    let (inputs, shard) = (directory.join("inputs"), directory.join("inputs/1-of-1.parquet"));
    fs::create_dir(&inputs).expect("made");
    part(&study, (1, 1), &inputs);
    let valid_bytes = bytes(&shard);
    assert_failed(
        &["merge", file.as_str(), text(&inputs), "--out", text(&shard), "--force"],
        &["is a shard itself, which must not change"],
    );
    assert!(bytes(&shard) == valid_bytes);

    // An interrupted merge leaves no file, and the parts are still valid.
    let before = names(&directory);
    let interrupted = merge(&study, &parts, &out, &|| false, &mut |_| ());
    assert_eq!(interrupted, Err(ResultsError::Stopped { done: 0, total: 100 }));
    assert_eq!(names(&directory), before);
    assert_eq!(merge(&study, &parts, &out, &|| true, &mut |_| ()).map(|merged| merged.summary.runs), Ok(100));
}

#[test]
fn arguments_of_parts_are_checked_before_running() {
    let directory = directory("shards_arguments");
    let study = write_short_study(&directory, 50);
    let [out, csv, nowhere] = ["part.parquet", "part.csv", "no/part.parquet"].map(|name| directory.join(name));
    for shard in ["0/4", "5/4", "1", "1/0", "a/b", "-1/4", "1/ 4", " 1/4", "+1/4", "01/4", "1/04"] {
        assert_failed(&[&study, "--shard", shard, "--out", text(&out)], &["expected K/N"]);
    }
    let limited = [&study, "--shard", "1/4", "--limit", "3", "--out", text(&out)];
    assert_failed(&limited, &["--limit", "cannot be used with"]);
    assert_failed(&[&study, "--shard", "1/4", "--out", text(&csv)], &["a shard is a Parquet file"]);
    assert_failed(&[&study, "--shard", "1/4", "--out", text(&nowhere)], &["mkdir -p"]);
    assert_failed(&["merge", &study, "--out", text(&out)], &["<SHARD>..."]);
    assert_eq!(names(&directory), ["cheap.toml"]);
}

#[test]
fn a_part_of_a_billion_runs_starts_immediately() {
    let directory = directory("shards_billion");
    let axis = |field: &str| format!("[[axes]]\nfield = \"{field}\"\nfrom = 0.1\nto = 0.9\ncount = 1000\n");
    let axes = ["design.arm_ratio", "design.l21_fraction", "contact.friction.mu_static"].map(axis).concat();
    let scene = fs::canonicalize("scenes/free-swing.toml").expect("a shipped file");
    let study_text = format!("scene = \"{}\"\n[set]\nduration = \"1 ms\"\n{axes}", scene.display());
    let file = write(&directory, "large.toml", &study_text);
    let out = directory.join("out.parquet");
    let words = ["1000000000 runs", "at most 1000000", "--shard 1/1000", "phalanx sweep merge"];
    assert_failed(&[&file, "--out", text(&out)], &words);
    let words = ["shard 1/999 has 1001001 runs", "at least 1000"];
    assert_failed(&[&file, "--shard", "1/999", "--out", text(&out)], &words);
    // The first runs can be made without parts.
    succeed(&[&file, "--limit", "3", "--out", text(&directory.join("first.csv"))]);

    let study = load(&file).expect("a study");
    let count = 200_000_000;
    let last = part(&study, (count, count), &directory);
    let runs = table::read(&last).expect("a table").integers("run").expect("runs");
    assert_eq!(runs, (999_999_996..=1_000_000_000).map(Some).collect::<Vec<_>>());
    assert_eq!(shard_range(study.runs(), count, count).map(|shard| shard.first), Some(999_999_996));
    // Missing runs are counted, not listed.
    let words = ["999999995 of 1000000000 runs are in no shard", "--shard 1/200000000 to 199999999/200000000"];
    let message = assert_failed(&["merge", &file, text(&last), "--out", text(&out)], &words);
    assert!(message.len() < 4000, "{message}");
}

/// These tests detect from /proc that a part is being made.
#[cfg(target_os = "linux")]
mod interruption {
    use std::process::Child;
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    use super::*;
    use crate::support::cli::{signal as send_signal, start};

    /// Starts a part and waits until the process handles signals and has started its runs.
    fn start_part(study: &str, out: &Path) -> Child {
        let child = start(&["sweep", study, "--threads", "1", "--shard", "1/2", "--out", text(out)]);
        let deadline = Instant::now() + Duration::from_secs(60);
        // Bit 1 of the mask is SIGINT.
        while caught_signals(child.id()).is_none_or(|mask| mask & 2 == 0) {
            assert!(Instant::now() < deadline, "the process does not handle signals");
            sleep(Duration::from_millis(2));
        }
        sleep(Duration::from_millis(50));
        child
    }

    /// Mask of the signals that a process handles.
    fn caught_signals(process: u32) -> Option<u64> {
        let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
        u64::from_str_radix(line.trim(), 16).ok()
    }

    #[test]
    fn a_killed_or_interrupted_part_leaves_no_file() {
        let directory = directory("shards_ended");
        let (study, parts) = (write_short_study(&directory, 40_000), directory.join("parts"));
        fs::create_dir(&parts).expect("made");
        let out = parts.join("part.parquet");
        for _ in 0..3 {
            let mut child = start_part(&study, &out);
            assert!(child.try_wait().expect("a child").is_none(), "the process ended before it was killed");
            child.kill().expect("the process is killed");
            child.wait().expect("the process ends");
            assert_eq!(names(&parts), [""; 0]);
        }
        for (name, signal) in [("INT", "SIGINT"), ("TERM", "SIGTERM")] {
            let child = start_part(&study, &out);
            send_signal(&child, name);
            let output = child.wait_with_output().expect("the process ends");
            let message = stderr(&output);
            assert_eq!(output.status.code(), Some(3), "{message}");
            let interrupted = format!("shard 1/2 was interrupted by {signal}");
            assert_contains(message, &[interrupted.as_str(), "of 20000 runs", "no file was written"]);
            assert_eq!(names(&parts), [""; 0]);
        }
        // A smaller study can be finished with the same commands.
        let study = write_short_study(&directory, 400);
        let undivided = run_undivided(&study, &directory);
        for number in ["1", "2"] {
            let out = parts.join(format!("{number}.parquet"));
            succeed(&[&study, "--shard", &format!("{number}/2"), "--out", text(&out)]);
        }
        assert_merges_to(&load(&study).expect("a study"), &[parts], &undivided, &directory, "after kills");
    }
}
