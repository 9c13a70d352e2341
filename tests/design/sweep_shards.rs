//! Sweeps in parts: any parts in any order merge into the bytes of an undivided sweep. Missing, duplicate, damaged and
//! foreign parts are reported, and no file is overwritten.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::support::cli::{directory, json, phalanx, stderr, stdout, write};
use crate::support::faults::XorShift;
use crate::support::studies::{write_short_study, write_short_study_as};
use phalanx::study::parts::{PartError, PartOptions, merge, write_part};
use phalanx::study::sweep::{Study, load, shard, shard_range, summary};
use phalanx::table;

const KEEP_RUNNING: &(dyn Fn() -> bool + Sync) = &|| true;

fn text(path: &Path) -> &str {
    path.to_str().expect("a path of plain text")
}

/// Runs `phalanx sweep` with these arguments.
fn sweep(args: &[&str]) -> Output {
    phalanx(&[&["sweep"], args].concat())
}

/// Runs `phalanx sweep` and asserts success.
#[track_caller]
fn succeed(args: &[&str]) -> Output {
    let output = sweep(args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    output
}

/// Runs `phalanx sweep`, asserts that it is rejected with these words, and returns the message.
#[track_caller]
fn assert_failed(args: &[&str], words: &[&str]) -> String {
    let output = sweep(args);
    let message = stderr(&output).to_string();
    assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""), "{args:?}: {message}");
    for word in words {
        assert!(message.contains(word), "{args:?}: no {word:?} in {message}");
    }
    message
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
    let mut names: Vec<String> = fs::read_dir(directory)
        .expect("a directory")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Results of the undivided sweep and their provenance file, in both formats.
fn run_undivided(study: &str, directory: &Path) -> Vec<(&'static str, Vec<u8>, Vec<u8>)> {
    let run_format = |format: &'static str| {
        let out = directory.join(format!("whole.{format}"));
        succeed(&[study, "--out", text(&out), "--threads", "2", "--restart"]);
        (format, bytes(&out), bytes(&directory.join(format!("whole.{format}.study.json"))))
    };
    ["csv", "parquet"].map(run_format).to_vec()
}

/// Asserts that the parts merge into these results.
#[track_caller]
fn assert_merges_to(
    study: &Study,
    parts: &[PathBuf],
    undivided: &[(&str, Vec<u8>, Vec<u8>)],
    directory: &Path,
    case: &str,
) {
    for (format, results, provenance) in undivided {
        let out = directory.join(format!("joined.{format}"));
        let merged = merge(study, parts, &out, &|| true, &mut |_| ()).unwrap_or_else(|error| panic!("{case}: {error}"));
        assert!(bytes(&out) == *results, "{case}: {format} differs");
        assert!(
            bytes(&directory.join(format!("joined.{format}.study.json"))) == *provenance,
            "{case}: {format}.study.json"
        );
        assert_eq!((merged.summary.runs, merged.bytes), (study.runs(), results.len() as u64), "{case}");
        if *format == "parquet" {
            let all = summary(&table::read(&out).expect("a table")).expect("results of a sweep");
            assert_eq!(merged.summary, all, "{case}: the summary is that of all rows");
        }
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

#[test]
fn the_command_makes_and_merges_parts_of_fingers_and_grippers() {
    let directory = directory("shards_command");
    let gripper = write(
        &directory,
        "gripper.toml",
        "[scene]\nkind = \"gripper\"\nduration = \"15 ms\"\nsizing = \"rigid\"\npalm_width = \"34 mm\"\npositioning_error = \"3 \
         mm\"\n[scene.design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n[scene.table]\n\
         [[axes]]\nfield = \"object.offset\"\nvalues = [\"0 mm\", \"2 mm\", \"-2 mm\", \"5 mm\"]\n",
    );
    for (name, study, count) in [("finger", write_short_study(&directory, 90), 3), ("gripper", gripper, 3)] {
        let undivided = run_undivided(&study, &directory);
        let parts = directory.join(name);
        fs::create_dir(&parts).expect("made");
        let mut total_runs = 0;
        for number in [2, 3, 1] {
            let (shard, out) = (format!("{number}/{count}"), parts.join(format!("{number}.parquet")));
            let report = json(&succeed(&[&study, "--shard", &shard, "--out", text(&out), "--json"]));
            assert_eq!((report["shard"].as_u64(), report["of"].as_u64()), (Some(number), Some(count)), "{report:#}");
            let (first, last) =
                (report["first_run"].as_u64().expect("a run"), report["last_run"].as_u64().expect("a run"));
            let counts = report["by_status"].as_object().expect("counts").values();
            assert_eq!(
                counts.map(|count| count.as_u64().expect("a count")).sum::<u64>(),
                last + 1 - first,
                "{report:#}"
            );
            total_runs += last + 1 - first;
            // The metadata are readable by other Parquet tools.
            let groups = table::RowGroupReader::open(&out).expect("a table");
            assert_eq!(groups.metadata_value("phalanx.shard"), Some(shard.as_str()));
            assert_eq!(groups.metadata_value("phalanx.first_run"), Some(first.to_string().as_str()));
            assert_eq!(
                groups.metadata_value("phalanx.runs"),
                Some(load(&study).expect("a study").runs().to_string().as_str())
            );
        }
        assert_eq!(names(&parts), ["1.parquet", "2.parquet", "3.parquet"], "no other file is left");
        // The parts as a directory, and as files.
        let files = ["3", "1", "2"].map(|number| parts.join(format!("{number}.parquet")));
        let files: Vec<&str> = files.iter().map(|file| text(file)).collect();
        for (format, results, provenance) in &undivided {
            let out = directory.join(format!("{name}.{format}"));
            for arguments in [&[text(&parts)][..], &files] {
                let report =
                    json(&succeed(&[&["merge", study.as_str()], arguments, &["--out", text(&out), "--json"]].concat()));
                assert_eq!(
                    (report["parts"].as_u64(), report["runs"].as_u64()),
                    (Some(3), Some(total_runs)),
                    "{report:#}"
                );
                assert!(
                    bytes(&out) == *results
                        && bytes(&directory.join(format!("{name}.{format}.study.json"))) == *provenance
                );
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
    let out = directory.join("part.parquet");
    let make = |study: &str, shard: &str, flags: &[&str]| {
        sweep(&[&[study, "--shard", shard, "--out", text(&out), "--json"], flags].concat())
    };
    let first = make(&study, "2/4", &[]);
    assert_eq!(json(&first)["now"]["runs"], 10, "{}", stderr(&first));
    let (original, modified) =
        (bytes(&out), fs::metadata(&out).and_then(|metadata| metadata.modified()).expect("a time"));
    let repeated = make(&study, "2/4", &[]);
    assert_eq!((repeated.status.code(), json(&repeated)["now"]["runs"].as_u64()), (Some(0), Some(0)));
    assert!(
        stderr(&repeated).contains("already contains shard 2/4 of this study; nothing was run"),
        "{}",
        stderr(&repeated)
    );
    assert_eq!(json(&repeated)["by_status"], json(&first)["by_status"]);
    assert_eq!(fs::metadata(&out).and_then(|metadata| metadata.modified()).expect("a time"), modified);

    let assert_unchanged = |output: Output, words: &[&str]| {
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "no {word:?} in {}", stderr(&output));
        }
    };
    assert_unchanged(make(&study, "3/4", &[]), &["2/4", "not replaced", "--restart"]);
    assert_unchanged(make(&study, "2/4", &["--check"]), &["without --check", "not replaced"]);
    assert_unchanged(make(&study, "2/4", &["--model", "engine"]), &["analytic model", "engine", "not replaced"]);
    let other = write_short_study_as(&directory, "other.toml", 44);
    assert_unchanged(make(&other, "2/4", &[]), &["the study `cheap`", "`other`", "not replaced"]);
    assert!(bytes(&out) == original);
    assert_eq!(json(&make(&study, "2/4", &["--restart"]))["now"]["runs"], 10);
    assert!(bytes(&out) == original);

    // A truncated part and a part with a flipped bit are not accepted.
    fs::write(&out, &original[..original.len() - 100]).expect("the file is writable");
    assert_unchanged(make(&study, "2/4", &[]), &["not a shard of a sweep", "not replaced", "delete it"]);
    let mut damaged = original.clone();
    damaged[original.len() / 3] ^= 4;
    fs::write(&out, &damaged).expect("the file is writable");
    assert_unchanged(make(&study, "2/4", &[]), &["damaged", "run the shard again"]);
    assert_eq!(make(&study, "2/4", &["--restart"]).status.code(), Some(0));
    assert!(bytes(&out) == original);

    // A foreign file is kept even with --restart.
    fs::write(&out, "foreign table").expect("the file is writable");
    for flags in [&[][..], &["--restart"]] {
        assert_unchanged(make(&study, "2/4", flags), &["not a shard of a sweep", "not replaced"]);
    }
    assert_eq!(bytes(&out), b"foreign table");
    assert_eq!(names(&directory), ["cheap.toml", "other.toml", "part.parquet"]);
}

#[test]
fn invalid_parts_are_reported_and_nothing_is_written() {
    let directory = directory("shards_wrong");
    let file = write_short_study(&directory, 100);
    let study = load(&file).expect("a study");
    let out = directory.join("out.csv");
    let parts: Vec<PathBuf> = (1..=5).map(|number| part(&study, (number, 5), &directory)).collect();
    let assert_rejected = |parts: &[&Path], words: &[&str]| {
        let parts: Vec<&str> = parts.iter().map(|part| text(part)).collect();
        let message = assert_failed(&[&["merge", file.as_str()], &parts[..], &["--out", text(&out)]].concat(), words);
        assert!(!out.exists() && !directory.join("out.csv.study.json").exists(), "{message}");
    };
    // Missing runs are reported with the commands that make them.
    let command = format!("phalanx sweep {file} --shard 3/5 --out {}", directory.join("part-3-of-5.parquet").display());
    assert_rejected(
        &[&parts[4], &parts[0], &parts[3]],
        &["40 of 100 runs are in no shard", "runs 21 to 60 (--shard 2/5 and 3/5)", &command],
    );
    // The runs between a third and a half are a sixth.
    let (third, half) = (part(&study, (1, 3), &directory), part(&study, (2, 2), &directory));
    assert_rejected(&[&half, &third], &["17 of 100 runs", "runs 34 to 50 (--shard 3/6)"]);
    // Duplicate runs.
    let all: Vec<&Path> = parts.iter().map(PathBuf::as_path).collect();
    let twice = [&all[..], &[&third]].concat();
    assert_rejected(&twice, &["overlap", "1-of-3.parquet", "runs 21 to 33", "remove one of each pair"]);
    assert_rejected(&[&parts[0], &parts[0]], &["overlap", "runs 1 to 20"]);

    // Parts of another study, model or version.
    let other = load(write_short_study_as(&directory, "other.toml", 104)).expect("a study");
    let foreign_directory = directory.join("strange");
    fs::create_dir(&foreign_directory).expect("made");
    let other_part = part(&other, (2, 5), &foreign_directory);
    let mixed = [&all[..1], &[&other_part], &all[2..]].concat();
    assert_rejected(&mixed, &["strange", "not a shard of this study", "`other`"]);
    let mut engine = study.clone();
    engine.model = phalanx::trace::Model::Engine;
    fs::remove_file(&other_part).expect("removed");
    let other_part = part(&engine, (2, 5), &foreign_directory);
    assert_rejected(&[&all[..1], &[&other_part], &all[2..]].concat(), &["not a shard of this study", "--model engine"]);
    let older = foreign_directory.join("older.parquet");
    let table = table::read(&parts[1]).expect("a table");
    let note = |name: &str| {
        table::RowGroupReader::open(&parts[1])
            .expect("a part")
            .metadata_value(&format!("phalanx.{name}"))
            .map(String::from)
    };
    let notes: Vec<(String, String)> = ["study", "model", "checked", "shard", "first_run", "last_run", "runs"]
        .iter()
        .map(|name| (format!("phalanx.{name}"), note(name).expect("a note")))
        .chain([
            ("phalanx.version".to_string(), "0.0.9".to_string()),
            ("phalanx.fingerprint".to_string(), "0".repeat(16)),
        ])
        .collect();
    table::write_with_metadata(&older, &table, &notes).expect("the file is writable");
    assert_rejected(&[&all[..1], &[&older], &all[2..]].concat(), &["written by phalanx 0.0.9", "one version"]);
    // Correct metadata with the rows of another part: the rows are verified too.
    let rows = table::read(&parts[2]).expect("a table");
    let mut forged = notes.clone();
    forged.retain(|(name, _)| name != "phalanx.version" && name != "phalanx.fingerprint");
    for name in ["version", "fingerprint"] {
        forged.push((format!("phalanx.{name}"), note(name).expect("a note")));
    }
    table::write_with_metadata(&older, &rows, &forged).expect("the file is writable");
    assert_rejected(&[&all[..1], &[&older], &all[2..]].concat(), &["damaged", "run 21 is missing or misplaced"]);

    // Inconsistent metadata.
    for (shard, first, last, runs) in [
        ("1/1", "1", "18446744073709551615", "18446744073709551615"),
        ("2/5", "21", "40", "99"),
        ("1/1", "1", "20", "20"),
        ("0/0", "1", "0", "0"),
    ] {
        let values = [("shard", shard), ("first_run", first), ("last_run", last), ("runs", runs)];
        let mut forged = forged.clone();
        for (name, text) in &mut forged {
            if let Some((_, value)) = values.iter().find(|(key, _)| name == &format!("phalanx.{key}")) {
                *text = value.to_string();
            }
        }
        table::write_with_metadata(&older, &rows, &forged).expect("the file is writable");
        let words = if runs == "20" { "overlap" } else { "damaged" };
        assert_rejected(&[&all[..1], &[&older], &all[2..]].concat(), &[words]);
    }

    // Truncated and modified parts.
    let truncated = foreign_directory.join("truncated.parquet");
    let valid_bytes = bytes(&parts[1]);
    let mut rng = XorShift::new(5);
    for _ in 0..20 {
        fs::write(&truncated, &valid_bytes[..rng.below(valid_bytes.len())]).expect("the file is writable");
        assert_rejected(
            &[&all[..1], &[&truncated], &all[2..]].concat(),
            &["truncated.parquet is not a shard of a sweep"],
        );
    }
    let mut flipped = valid_bytes.clone();
    flipped[valid_bytes.len() / 4] ^= 1;
    fs::write(&truncated, &flipped).expect("the file is writable");
    assert_rejected(
        &[&all[..1], &[&truncated], &all[2..]].concat(),
        &["truncated.parquet is damaged", "run the shard again"],
    );
    assert_rejected(&[&directory.join("none.parquet")], &["none.parquet", "there is no such file"]);
    fs::create_dir(directory.join("empty")).expect("made");
    assert_rejected(&[&directory.join("empty")], &["contains no Parquet file"]);

    // Output paths.
    let file = file.as_str();
    let arguments: Vec<&str> = all.iter().map(|part| text(part)).collect();
    let assert_path_rejected = |out: &Path, words: &[&str]| {
        assert_failed(&[&["merge", file], &arguments[..], &["--out", text(out)]].concat(), words);
    };
    assert_path_rejected(&directory.join("out.txt"), &["NAME.csv or NAME.parquet"]);
    assert_path_rejected(&directory.join("nowhere/out.csv"), &["mkdir -p"]);
    fs::write(&out, "foreign").expect("the file is writable");
    assert_path_rejected(&out, &["it was not written by a sweep", "not replaced"]);
    assert_eq!(bytes(&out), b"foreign");
    fs::remove_file(&out).expect("removed");

    // An interrupted merge leaves no file, and the parts are still valid.
    let before = names(&directory);
    let interrupted = merge(&study, &parts, &out, &|| false, &mut |_| ());
    assert_eq!(interrupted, Err(PartError::Stopped { done: 0, total: 100 }));
    assert_eq!(names(&directory), before);
    assert_eq!(merge(&study, &parts, &out, &|| true, &mut |_| ()).map(|merged| merged.summary.runs), Ok(100));
}

#[test]
fn arguments_of_parts_are_checked_before_running() {
    let directory = directory("shards_arguments");
    let study = write_short_study(&directory, 50);
    let out = directory.join("part.parquet");
    for shard in ["0/4", "5/4", "1", "1/0", "a/b", "-1/4", "1/ 4", " 1/4", "+1/4", "01/4", "1/04"] {
        assert_failed(&[&study, "--shard", shard, "--out", text(&out)], &["expected K/N"]);
    }
    assert_failed(
        &[&study, "--shard", "1/4", "--limit", "3", "--out", text(&out)],
        &["--limit", "cannot be used with"],
    );
    assert_failed(
        &[&study, "--shard", "1/4", "--out", text(&directory.join("part.csv"))],
        &["a shard is a Parquet file"],
    );
    assert_failed(&[&study, "--shard", "1/4", "--out", text(&directory.join("no/part.parquet"))], &["mkdir -p"]);
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
    assert_failed(
        &[&file, "--out", text(&out)],
        &["1000000000 runs", "at most 1000000", "--shard 1/1000", "phalanx sweep merge"],
    );
    assert_failed(
        &[&file, "--shard", "1/999", "--out", text(&out)],
        &["shard 1/999 has 1001001 runs", "at least 1000"],
    );
    // The first runs can be made without parts.
    succeed(&[&file, "--limit", "3", "--out", text(&directory.join("first.csv"))]);

    let study = load(&file).expect("a study");
    let count = 200_000_000;
    let last = part(&study, (count, count), &directory);
    let runs = table::read(&last).expect("a table").integers("run").expect("runs");
    assert_eq!(runs, (999_999_996..=1_000_000_000).map(Some).collect::<Vec<_>>());
    assert_eq!(shard_range(study.runs(), count, count).map(|shard| shard.first), Some(999_999_996));
    // Missing runs are counted, not listed.
    let message = assert_failed(
        &["merge", &file, text(&last), "--out", text(&out)],
        &["999999995 of 1000000000 runs are in no shard"],
    );
    assert!(message.contains("--shard 1/200000000 to 199999999/200000000") && message.len() < 4000, "{message}");
}

/// These tests detect from /proc that a part is being made.
#[cfg(target_os = "linux")]
mod interruption {
    use std::process::{Child, Command, Stdio};
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    use super::*;

    /// Starts a part and waits until the process handles signals and has started its runs.
    fn start_part(study: &str, out: &Path) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        command.args(["sweep", study, "--threads", "1", "--shard", "1/2", "--out"]).arg(out);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary starts");
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
            let sent = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status();
            assert!(sent.expect("kill is available").success());
            let output = child.wait_with_output().expect("the process ends");
            let message = stderr(&output);
            assert_eq!(output.status.code(), Some(3), "{message}");
            for words in [&format!("shard 1/2 was interrupted by {signal}"), "of its 20000 runs", "no file was written"]
            {
                assert!(message.contains(words), "no {words:?} in {message}");
            }
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
