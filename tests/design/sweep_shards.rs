//! Sweeps in parts: any parts in any order merge into the bytes of an undivided sweep. Missing, duplicate, damaged and
//! foreign parts are reported, and no file is overwritten.

use std::path::{Path, PathBuf};
use std::process::Output;
use std::{fs, io};

use crate::support::cli::{
    assert_contains, assert_rejected, assert_status, directory, json, path_in, path_text as text, stderr, write,
};
use crate::support::faults::XorShift;
use crate::support::studies::{write_short_study, write_short_study_as};
use phalanx::parallel::{ComputeError, Monitor};
use phalanx::study::parts::{merge, write_part};
use phalanx::study::sweep::{Study, load, shard, summary};
use phalanx::table::{self, Table};

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
    write_part(study, shard, &out, 1, false, KEEP_RUNNING, |_| ()).unwrap_or_else(|error| panic!("{error}"));
    out
}

fn bytes(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Sorted names of the entries of a directory.
fn names(directory: &Path) -> Vec<String> {
    let name = |entry: io::Result<fs::DirEntry>| entry.expect("an entry").file_name().to_string_lossy().into_owned();
    let mut names: Vec<String> = fs::read_dir(directory).expect("a directory").map(name).collect();
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
fn assert_merges_to(study: &Study, parts: &[PathBuf], undivided: &[(&str, [Vec<u8>; 2])], directory: &Path) {
    for (format, expected) in undivided {
        let out = directory.join(format!("joined.{format}"));
        let merged =
            merge(study, parts, &out, &Monitor::silent(KEEP_RUNNING)).unwrap_or_else(|error| panic!("{error}"));
        assert!(results(&out) == *expected, "{} parts: {format} differs", parts.len());
        assert_eq!((merged.summary.runs, merged.bytes), (study.runs(), expected[0].len() as u64));
        let all = summary(&table::read(&out).expect("a table"));
        assert_eq!(merged.summary, all.expect("results of a sweep"), "the summary is that of all rows");
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
        assert_merges_to(&study, &parts, &undivided, &directory);
    }
    // A half, a sixth and a third.
    let parts = [(2, 2), (1, 3), (3, 6)].map(|shard| part(&study, shard, &directory));
    assert_merges_to(&study, &parts, &undivided, &directory);
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
        let total_runs = load(&study).expect("a study").runs();
        for number in [2, 3, 1] {
            let (shard, out) = (format!("{number}/3"), parts.join(format!("{number}.parquet")));
            let report = json(&succeed(&[&study, "--shard", &shard, "--out", text(&out), "--json"]));
            let [first, last] = [number - 1, number].map(|shards| total_runs * shards / 3);
            let counts = report["by_status"].as_object().expect("counts").values();
            assert_eq!(counts.map(|count| count.as_u64().expect("a count")).sum::<u64>(), last - first, "{report:#}");
            // The metadata are readable by other Parquet tools.
            let groups = table::RowGroups::open(&out).expect("a table");
            let metadata = groups.metadata_value("phalanx.part").expect("metadata");
            let metadata: serde_json::Value = serde_json::from_str(metadata).expect("JSON");
            assert_eq!(metadata["runs"], total_runs);
            for (key, value) in [("shard", number), ("of", 3), ("first_run", first + 1), ("last_run", last)] {
                assert_eq!((&metadata[key], &report[key]), (&value.into(), &value.into()), "{key}");
            }
        }
        assert_eq!(names(&parts), ["1.parquet", "2.parquet", "3.parquet"], "no other file is left");
        // The parts as a directory, and as files.
        let files = ["3", "1", "2"].map(|number| path_in(&parts, &format!("{number}.parquet")));
        let [first, second, third] = files.each_ref().map(String::as_str);
        for (format, expected) in &undivided {
            let out = directory.join(format!("{name}.{format}"));
            for arguments in [&[text(&parts)][..], &[first, second, third]] {
                let args = [&["merge", study.as_str()], arguments, &["--out", text(&out), "--json"]].concat();
                let report = json(&succeed(&args));
                let counts = (report["parts"].as_u64(), report["runs"].as_u64());
                assert_eq!(counts, (Some(3), Some(total_runs)), "{report:#}");
                assert!(results(&out) == *expected, "{name}.{format}");
            }
        }
        // The undivided sweep recognises the merged results as its own.
        let output = succeed(&[&study, "--out", text(&directory.join(format!("{name}.csv")))]);
        assert_contains(stderr(&output), &["already contains all runs of this study"]);
    }
}

#[test]
fn existing_parts_and_other_files_are_kept() {
    let directory = directory("shards_there");
    let study = write_short_study(&directory, 40);
    let other = write_short_study_as(&directory, "other.toml", 44);
    let out = directory.join("part.parquet");
    let of = |study, shard, flags: &[&'static str]| {
        [&[study, "--shard", shard, "--out", text(&out), "--json"], flags].concat()
    };
    let with = |flags: &[&'static str]| of(&study, "2/4", flags);
    let make = |flags: &[&'static str]| json(&succeed(&with(flags)));
    let first = make(&[]);
    assert_eq!(first["now"]["runs"], 10);
    let original = bytes(&out);
    let assert_unchanged = || assert!(bytes(&out) == original);
    let replace = |contents: &[u8]| fs::write(&out, contents).expect("the file is writable");
    let repeated = succeed(&with(&[]));
    assert_contains(stderr(&repeated), &["already contains shard 2/4 of this study; nothing was run"]);
    let repeated = json(&repeated);
    assert_eq!((&repeated["now"]["runs"], &repeated["by_status"]), (&0.into(), &first["by_status"]));
    let other_model = "its model is --model analytic, but here it is --model engine";
    for (args, words) in [
        (of(&study, "3/4", &[]), ["2/4", "--restart"]),
        (with(&["--check"]), ["its sweep is without --check", "--restart"]),
        (with(&["--model", "engine"]), [other_model, "--restart"]),
        (of(&other, "2/4", &[]), ["its study is `cheap`, but here it is `other`", "--restart"]),
    ] {
        assert_contains(&assert_failed(&args, &words), &["not replaced"]);
        assert_unchanged();
    }
    assert_eq!(make(&["--restart"])["now"]["runs"], 10);
    assert_unchanged();

    // A truncated part is not recognised. A part with a flipped bit is damaged and can be made again.
    replace(&original[..original.len() - 100]);
    assert_failed(&with(&[]), &["not a table written by phalanx", "not replaced", "--force"]);
    let mut damaged = original.clone();
    damaged[original.len() / 3..original.len() / 2].fill(4);
    replace(&damaged);
    assert_failed(&with(&[]), &["damaged", "run the shard again"]);
    make(&["--restart"]);
    assert_unchanged();

    // A foreign file is kept even with --restart, but not with --force.
    replace(b"foreign table");
    for flags in [&[][..], &["--restart"]] {
        assert_failed(&with(flags), &["not a table written by phalanx", "not replaced"]);
        assert_eq!(bytes(&out), b"foreign table");
    }
    make(&["--force"]);
    assert_unchanged();
    assert_eq!(names(&directory), ["cheap.toml", "other.toml", "part.parquet"]);
}

/// Writes a part with these rows and the metadata of another part, with other values of some keys.
fn forge(forged: &Path, rows: &Table, part: &Path, changes: &[(&str, serde_json::Value)]) {
    let groups = table::RowGroups::open(part).expect("a part");
    let value = |name: &str| groups.metadata_value(name).expect("metadata").to_string();
    let mut info: serde_json::Value = serde_json::from_str(&value("phalanx.part")).expect("JSON");
    changes.iter().for_each(|(key, value)| info[*key] = value.clone());
    let metadata = [("phalanx.part", info.to_string()), ("phalanx.checksum", value("phalanx.checksum"))];
    let metadata = metadata.map(|(key, value)| (key.to_string(), value));
    table::write_with_metadata(forged, rows, &metadata).expect("the file is writable");
}

#[test]
fn invalid_parts_are_reported_and_nothing_is_written() {
    let directory = directory("shards_wrong");
    let [inputs, strange] = ["inputs", "strange"].map(|name| directory.join(name));
    [&inputs, &strange].into_iter().for_each(|directory| fs::create_dir(directory).expect("made"));
    let file = write_short_study(&directory, 100);
    let study = load(&file).expect("a study");
    let (out, none) = (directory.join("out.csv"), directory.join("none.parquet"));
    let parts: Vec<PathBuf> = (1..=5).map(|number| part(&study, (number, 5), &directory)).collect();
    let all: Vec<&Path> = parts.iter().map(PathBuf::as_path).collect();
    let [third, half, whole] = [(1, 3, &directory), (2, 2, &directory), (1, 1, &inputs)]
        .map(|(k, n, directory)| part(&study, (k, n), directory));
    let before = names(&directory);
    let join = |parts: &[&Path], out: &Path, words: &[&str]| {
        let parts: Vec<&str> = parts.iter().map(|part| text(part)).collect();
        assert_failed(&[&["merge", file.as_str()], &parts[..], &["--out", text(out), "--force"]].concat(), words);
    };
    for (parts, words) in [
        // Missing runs are reported with the shards that contain them.
        (
            &[all[4], all[0], all[3]][..],
            &["40 of 100 runs are in no shard", "runs 21 to 60 (--shard 2/5 and 3/5); run these and merge again"][..],
        ),
        // The runs between a third and a half are a sixth.
        (&[&half, &third], &["17 of 100 runs", "runs 34 to 50 (--shard 3/6)"]),
        (&[all[0], all[1], &third], &["overlap", "1-of-3.parquet", "runs 21 to 33", "remove one of each pair"]),
        (&[all[0], all[0]], &["overlap", "runs 1 to 20"]),
        (&[&none], &["none.parquet", "there is no such file"]),
        (&[&strange], &["contains no Parquet file"]),
    ] {
        join(parts, &out, words);
    }

    // The second part is replaced by parts of another study, model or version, and by damaged ones.
    let merge_with = |second: &Path| {
        let files: Vec<PathBuf> = [&[all[0], second], &all[2..]].concat().iter().map(PathBuf::from).collect();
        merge(&study, &files, &out, &Monitor::silent(KEEP_RUNNING)).map_err(|error| error.to_string())
    };
    let with_second = |second: &Path, words: &[&str]| assert_contains(&merge_with(second).expect_err("refused"), words);
    let other = load(write_short_study_as(&strange, "other.toml", 104)).expect("a study");
    with_second(&part(&other, (2, 5), &strange), &["strange", "not a shard of this study", "`other`"]);
    let mut engine = study.clone();
    engine.model = phalanx::trace::Model::Engine;
    fs::remove_file(strange.join("2-of-5.parquet")).expect("removed");
    with_second(&part(&engine, (2, 5), &strange), &["not a shard of this study", "--model engine"]);
    let forged = strange.join("forged.parquet");
    let [own_rows, other_rows] = [1, 2].map(|index| table::read(&parts[index]).expect("a table"));
    forge(&forged, &own_rows, &parts[1], &[("version", "0.0.9".into()), ("fingerprint", "0".repeat(16).into())]);
    with_second(&forged, &["its version of phalanx is 0.0.9", "use the same for all shards"]);
    // Correct metadata with the rows of another part: the rows are verified too.
    forge(&forged, &other_rows, &parts[1], &[]);
    with_second(&forged, &["damaged", "run 21 is missing or misplaced"]);
    for (shard, count, first, last, runs, word) in [
        (1, 1, 1, u64::MAX, u64::MAX, "damaged"),
        (2, 5, 21, 40, 99, "damaged"),
        (1, 1, 1, 20, 20, "overlap"),
        (0, 0, 1, 0, 0, "damaged"),
    ] {
        let values = [("shard", shard), ("of", count), ("first_run", first), ("last_run", last), ("runs", runs)];
        forge(&forged, &other_rows, &parts[1], &values.map(|(key, value)| (key, value.into())));
        with_second(&forged, &[word]);
    }
    let (valid_bytes, mut rng) = (bytes(&parts[1]), XorShift::new(5));
    for _ in 0..20 {
        fs::write(&forged, &valid_bytes[..rng.below(valid_bytes.len())]).expect("the file is writable");
        with_second(&forged, &["forged.parquet is not a shard of a sweep"]);
    }
    assert_eq!(names(&directory), before, "nothing was written");
    // A changed byte is detected, unless it changes no value.
    let mut detected = 0;
    for offset in (4..valid_bytes.len() / 2).step_by(97) {
        let mut changed = valid_bytes.clone();
        changed[offset] ^= 1;
        fs::write(&forged, &changed).expect("the file is writable");
        match merge_with(&forged) {
            Ok(_) => assert!(table::read(&forged).expect("a table") == own_rows, "byte {offset}"),
            Err(error) => {
                assert_contains(&error, &["forged.parquet is damaged"]);
                detected += 1;
            }
        }
    }
    assert!(detected > 20, "{detected}");

    // Output paths. A shard in a directory is an input too.
    join(&all, &directory.join("out.txt"), &["NAME.csv or NAME.parquet"]);
    join(&all, &directory.join("nowhere/out.csv"), &["mkdir -p"]);
    join(&[&inputs], &whole, &["is a shard itself, which must not change"]);
    fs::write(&out, "foreign").expect("the file is writable");
    assert_contains(
        &merge_with(all[1]).expect_err("refused"),
        &["not a table written by phalanx", "not replaced", "--force"],
    );
    assert_eq!(bytes(&out), b"foreign");
    fs::remove_file(&out).expect("removed");

    // An interrupted merge leaves no file, and the parts are still valid.
    let before = names(&directory);
    let interrupted = merge(&study, &parts, &out, &Monitor::silent(&|| false));
    assert_eq!(interrupted, Err(ComputeError::Stopped { done: 0, total: 100 }));
    assert_eq!(names(&directory), before);
    assert_eq!(merge_with(all[1]).map(|merged| merged.summary.runs), Ok(100));
}

#[test]
fn arguments_of_parts_are_checked_before_running() {
    let directory = directory("shards_arguments");
    let study = write_short_study(&directory, 50);
    let [out, csv, nowhere] = ["part.parquet", "part.csv", "no/part.parquet"].map(|name| path_in(&directory, name));
    for shard in ["0/4", "5/4", "1", "1/0", "a/b", "-1/4", "1/ 4", " 1/4", "+1/4", "01/4", "1/04"] {
        assert_failed(&[&study, "--shard", shard, "--out", &out], &["expected K/N"]);
    }
    let shard = [&study, "--shard", "1/4", "--out"];
    assert_failed(&[&shard[..], &[&out, "--limit", "3"]].concat(), &["--limit", "cannot be used with"]);
    assert_failed(&[&shard[..], &[&csv]].concat(), &["a shard is a Parquet file"]);
    assert_failed(&[&shard[..], &[&nowhere]].concat(), &["mkdir -p"]);
    assert_failed(&["merge", &study, "--out", &out], &["<SHARD>..."]);
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
    let out = path_in(&directory, "out.parquet");
    assert_failed(
        &[&file, "--out", &out],
        &["1000000000 runs", "at most 1000000", "--shard 1/1000", "phalanx sweep merge"],
    );
    assert_failed(&[&file, "--shard", "1/999", "--out", &out], &["shard 1/999 has 1001001 runs", "at least 1000"]);
    // The first runs can be made without parts.
    succeed(&[&file, "--limit", "3", "--out", &path_in(&directory, "first.csv")]);

    let study = load(&file).expect("a study");
    let count = 200_000_000;
    let last = part(&study, (count, count), &directory);
    let runs = table::read(&last).expect("a table").integers("run").expect("runs");
    assert_eq!(runs, (999_999_996..=1_000_000_000).map(Some).collect::<Vec<_>>());
    // Missing runs are counted, not listed.
    let words = ["999999995 of 1000000000 runs are in no shard", "--shard 1/200000000 to 199999999/200000000"];
    let message = assert_failed(&["merge", &file, text(&last), "--out", &out], &words);
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
        assert_merges_to(&load(&study).expect("a study"), &[parts], &undivided, &directory);
    }
}
