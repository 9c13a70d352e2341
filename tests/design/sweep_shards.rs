//! Sweeps in parts: whatever the parts and their order, together they are the bytes of the sweep in one piece; and what is missing,
//! there twice, damaged or of something else is named, and costs nobody a file.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::support::cli::{directory, json, phalanx, stderr, stdout, write};
use crate::support::faults::Dice;
use crate::support::studies::{cheap, cheap_as};
use phalanx::study::parts::{PartError, Work, merge, write_part};
use phalanx::study::sweep::{Study, load, range, shard, summary};
use phalanx::table;

const ON: &(dyn Fn() -> bool + Sync) = &|| true;

fn text(path: &Path) -> &str {
    path.to_str().expect("a path of plain text")
}

/// `phalanx sweep` with these arguments.
fn sweep(args: &[&str]) -> Output {
    phalanx(&[&["sweep"], args].concat())
}

#[track_caller]
fn done(args: &[&str]) -> Output {
    let output = sweep(args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    output
}

#[track_caller]
fn refused(args: &[&str], words: &[&str]) -> String {
    let output = sweep(args);
    let said = stderr(&output).to_string();
    assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""), "{args:?}: {said}");
    for word in words {
        assert!(said.contains(word), "{args:?}: no {word:?} in {said}");
    }
    said
}

/// A part, made by the library.
fn part(study: &Study, (number, of): (u64, u64), directory: &Path) -> PathBuf {
    let out = directory.join(format!("{number}-of-{of}.parquet"));
    let shard = shard(study, number, of).expect("there is one");
    let work = Work { threads: 1, restart: false };
    write_part(study, shard, &out, work, ON, |_| ()).unwrap_or_else(|error| panic!("{error}"));
    out
}

fn bytes(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Names of all that is in a directory.
fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(directory)
        .expect("a directory")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// The results in one piece and what stands beside them, in both formats.
fn in_one_piece(study: &str, directory: &Path) -> Vec<(&'static str, Vec<u8>, Vec<u8>)> {
    let of = |format: &'static str| {
        let out = directory.join(format!("whole.{format}"));
        done(&[study, "--out", text(&out), "--threads", "2", "--restart"]);
        (format, bytes(&out), bytes(&directory.join(format!("whole.{format}.study.json"))))
    };
    ["csv", "parquet"].map(of).to_vec()
}

#[track_caller]
fn joins_to(study: &Study, parts: &[PathBuf], whole: &[(&str, Vec<u8>, Vec<u8>)], directory: &Path, what: &str) {
    for (format, results, beside) in whole {
        let out = directory.join(format!("joined.{format}"));
        let joined = merge(study, parts, &out, &|| true, &mut |_| ()).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(bytes(&out) == *results, "{what}: {format} differs");
        assert!(
            bytes(&directory.join(format!("joined.{format}.study.json"))) == *beside,
            "{what}: {format}.study.json"
        );
        assert_eq!((joined.found.runs, joined.bytes), (study.runs(), results.len() as u64), "{what}");
        if *format == "parquet" {
            let all = summary(&table::read(&out).expect("a table")).expect("of a sweep");
            assert_eq!(joined.found, all, "{what}: what came out is that of all rows");
        }
    }
}

#[test]
fn parts_of_any_number_in_any_order_are_the_bytes_of_the_whole() {
    let directory = directory("shards_bytes");
    let file = cheap(&directory, 60);
    let whole = in_one_piece(&file, &directory);
    let study = load(&file).expect("a study");
    let mut dice = Dice::new(18);
    // More parts than runs too: some of them are empty.
    for of in [1, 2, 7, 60, 97] {
        let mut parts: Vec<PathBuf> = (1..=of).map(|number| part(&study, (number, of), &directory)).collect();
        for last in (1..parts.len()).rev() {
            parts.swap(last, dice.below(last + 1));
        }
        joins_to(&study, &parts, &whole, &directory, &format!("{of} parts"));
    }
    // A half, a sixth and a third.
    let parts = [(2, 2), (1, 3), (3, 6)].map(|of| part(&study, of, &directory));
    joins_to(&study, &parts, &whole, &directory, "parts of three counts");
}

#[test]
fn the_command_makes_and_joins_parts_of_fingers_and_of_grippers() {
    let directory = directory("shards_command");
    let gripper = write(
        &directory,
        "gripper.toml",
        "[scene]\nkind = \"gripper\"\nduration = \"15 ms\"\nsizing = \"rigid\"\npalm_width = \"34 mm\"\npositioning_error = \"3 \
         mm\"\n[scene.design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n[scene.table]\n\
         [[axes]]\nfield = \"object.offset\"\nvalues = [\"0 mm\", \"2 mm\", \"-2 mm\", \"5 mm\"]\n",
    );
    for (name, study, of) in [("finger", cheap(&directory, 90), 3), ("gripper", gripper, 3)] {
        let whole = in_one_piece(&study, &directory);
        let parts = directory.join(name);
        fs::create_dir(&parts).expect("made");
        let mut found = 0;
        for number in [2, 3, 1] {
            let (shard, out) = (format!("{number}/{of}"), parts.join(format!("{number}.parquet")));
            let report = json(&done(&[&study, "--shard", &shard, "--out", text(&out), "--json"]));
            assert_eq!((report["shard"].as_u64(), report["of"].as_u64()), (Some(number), Some(of)), "{report:#}");
            let (first, last) =
                (report["first_run"].as_u64().expect("a run"), report["last_run"].as_u64().expect("one"));
            let counts = report["by_status"].as_object().expect("counts").values();
            assert_eq!(
                counts.map(|count| count.as_u64().expect("a count")).sum::<u64>(),
                last + 1 - first,
                "{report:#}"
            );
            found += last + 1 - first;
            // DuckDB, say, sees it too.
            let groups = table::Groups::open(&out).expect("a table");
            assert_eq!(groups.note("phalanx.shard"), Some(shard.as_str()));
            assert_eq!(groups.note("phalanx.first_run"), Some(first.to_string().as_str()));
            assert_eq!(groups.note("phalanx.runs"), Some(load(&study).expect("a study").runs().to_string().as_str()));
        }
        assert_eq!(names(&parts), ["1.parquet", "2.parquet", "3.parquet"], "nothing is left beside them");
        // As a directory, and as files.
        let files = ["3", "1", "2"].map(|number| parts.join(format!("{number}.parquet")));
        let files: Vec<&str> = files.iter().map(|file| text(file)).collect();
        for (format, results, beside) in &whole {
            let out = directory.join(format!("{name}.{format}"));
            for given in [&[text(&parts)][..], &files] {
                let report =
                    json(&done(&[&["merge", study.as_str()], given, &["--out", text(&out), "--json"]].concat()));
                assert_eq!((report["parts"].as_u64(), report["runs"].as_u64()), (Some(3), Some(found)), "{report:#}");
                assert!(
                    bytes(&out) == *results && bytes(&directory.join(format!("{name}.{format}.study.json"))) == *beside
                );
            }
        }
        // The sweep in one piece takes the joined results for its own.
        let output = done(&[&study, "--out", text(&directory.join(format!("{name}.csv")))]);
        assert!(stderr(&output).contains("has all runs of this study already"), "{}", stderr(&output));
    }
}

#[test]
fn a_part_that_is_there_is_left_alone_and_so_is_all_else() {
    let directory = directory("shards_there");
    let study = cheap(&directory, 40);
    let out = directory.join("part.parquet");
    let make = |study: &str, shard: &str, more: &[&str]| {
        sweep(&[&[study, "--shard", shard, "--out", text(&out), "--json"], more].concat())
    };
    let first = make(&study, "2/4", &[]);
    assert_eq!(json(&first)["now"]["runs"], 10, "{}", stderr(&first));
    let (made, when) = (bytes(&out), fs::metadata(&out).and_then(|found| found.modified()).expect("a time"));
    let again = make(&study, "2/4", &[]);
    assert_eq!((again.status.code(), json(&again)["now"]["runs"].as_u64()), (Some(0), Some(0)));
    assert!(stderr(&again).contains("shard 2/4 of this study already: nothing was run"), "{}", stderr(&again));
    assert_eq!(json(&again)["by_status"], json(&first)["by_status"]);
    assert_eq!(fs::metadata(&out).and_then(|found| found.modified()).expect("a time"), when);

    let left = |output: Output, words: &[&str]| {
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "no {word:?} in {}", stderr(&output));
        }
    };
    left(make(&study, "3/4", &[]), &["shard 2/4", "left alone", "--restart"]);
    left(make(&study, "2/4", &["--check"]), &["without --check", "left alone"]);
    left(make(&study, "2/4", &["--model", "engine"]), &["analytic model", "engine", "left alone"]);
    let other = cheap_as(&directory, "other.toml", 44);
    left(make(&other, "2/4", &[]), &["the study `cheap`", "`other`", "left alone"]);
    assert!(bytes(&out) == made);
    assert_eq!(json(&make(&study, "2/4", &["--restart"]))["now"]["runs"], 10);
    assert!(bytes(&out) == made);

    // A part that was cut short, and one with a bit of it turned, are not taken for done.
    fs::write(&out, &made[..made.len() - 100]).expect("written");
    left(make(&study, "2/4", &[]), &["no part of a sweep", "left alone", "delete it"]);
    let mut damaged = made.clone();
    damaged[made.len() / 3] ^= 4;
    fs::write(&out, &damaged).expect("written");
    left(make(&study, "2/4", &[]), &["damaged", "make that part again"]);
    assert_eq!(make(&study, "2/4", &["--restart"]).status.code(), Some(0));
    assert!(bytes(&out) == made);

    // Somebody's own table, even for --restart.
    fs::write(&out, "somebody's table").expect("written");
    for more in [&[][..], &["--restart"]] {
        left(make(&study, "2/4", more), &["no part of a sweep", "left alone"]);
    }
    assert_eq!(bytes(&out), b"somebody's table");
    assert_eq!(names(&directory), ["cheap.toml", "other.toml", "part.parquet"]);
}

#[test]
fn what_is_wrong_with_parts_is_named_and_nothing_is_written() {
    let directory = directory("shards_wrong");
    let file = cheap(&directory, 100);
    let study = load(&file).expect("a study");
    let out = directory.join("out.csv");
    let parts: Vec<PathBuf> = (1..=5).map(|number| part(&study, (number, 5), &directory)).collect();
    let joined = |parts: &[&Path], words: &[&str]| {
        let parts: Vec<&str> = parts.iter().map(|part| text(part)).collect();
        let said = refused(&[&["merge", file.as_str()], &parts[..], &["--out", text(&out)]].concat(), words);
        assert!(!out.exists() && !directory.join("out.csv.study.json").exists(), "{said}");
    };
    // Missing, with the commands that make it.
    let command = format!("phalanx sweep {file} --shard 3/5 --out {}", directory.join("part-3-of-5.parquet").display());
    joined(
        &[&parts[4], &parts[0], &parts[3]],
        &["40 of 100 runs are in no part", "runs 21 to 60 (--shard 2/5 and 3/5)", &command],
    );
    // Between a third and a half: the missing runs are a sixth.
    let (third, half) = (part(&study, (1, 3), &directory), part(&study, (2, 2), &directory));
    joined(&[&half, &third], &["17 of 100 runs", "runs 34 to 50 (--shard 3/6)"]);
    // There twice.
    let all: Vec<&Path> = parts.iter().map(PathBuf::as_path).collect();
    let twice = [&all[..], &[&third]].concat();
    joined(&twice, &["overlap", "1-of-3.parquet", "runs 21 to 33", "leave out one of each two"]);
    joined(&[&parts[0], &parts[0]], &["overlap", "runs 1 to 20"]);

    // Of another study, model, or program.
    let other = load(cheap_as(&directory, "other.toml", 104)).expect("a study");
    let strange = directory.join("strange");
    fs::create_dir(&strange).expect("made");
    let foreign = part(&other, (2, 5), &strange);
    let mixed = [&all[..1], &[&foreign], &all[2..]].concat();
    joined(&mixed, &["strange", "no part of this study", "`other`"]);
    let mut engine = study.clone();
    engine.model = phalanx::trace::Model::Engine;
    fs::remove_file(&foreign).expect("removed");
    let foreign = part(&engine, (2, 5), &strange);
    joined(&[&all[..1], &[&foreign], &all[2..]].concat(), &["no part of this study", "--model engine"]);
    let older = strange.join("older.parquet");
    let table = table::read(&parts[1]).expect("a table");
    let note =
        |name: &str| table::Groups::open(&parts[1]).expect("a part").note(&format!("phalanx.{name}")).map(String::from);
    let notes: Vec<(String, String)> = ["study", "model", "checked", "shard", "first_run", "last_run", "runs"]
        .iter()
        .map(|name| (format!("phalanx.{name}"), note(name).expect("a note")))
        .chain([
            ("phalanx.version".to_string(), "0.0.9".to_string()),
            ("phalanx.fingerprint".to_string(), "0".repeat(16)),
        ])
        .collect();
    table::write_noted(&older, &table, &notes).expect("written");
    joined(&[&all[..1], &[&older], &all[2..]].concat(), &["made by phalanx 0.0.9", "one version"]);
    // The same with the rows of another part: what it says of itself is not all that is looked at.
    let rows = table::read(&parts[2]).expect("a table");
    let mut lying = notes.clone();
    lying.retain(|(name, _)| name != "phalanx.version" && name != "phalanx.fingerprint");
    for name in ["version", "fingerprint"] {
        lying.push((format!("phalanx.{name}"), note(name).expect("a note")));
    }
    table::write_noted(&older, &rows, &lying).expect("written");
    joined(&[&all[..1], &[&older], &all[2..]].concat(), &["damaged", "run 21 is not where it should be"]);

    // What it says of itself may be anything.
    for (shard, first, last, runs) in [
        ("1/1", "1", "18446744073709551615", "18446744073709551615"),
        ("2/5", "21", "40", "99"),
        ("1/1", "1", "20", "20"),
        ("0/0", "1", "0", "0"),
    ] {
        let say = [("shard", shard), ("first_run", first), ("last_run", last), ("runs", runs)];
        let mut lying = lying.clone();
        for (name, text) in &mut lying {
            if let Some((_, said)) = say.iter().find(|(of, _)| name == &format!("phalanx.{of}")) {
                *text = said.to_string();
            }
        }
        table::write_noted(&older, &rows, &lying).expect("written");
        let words = if runs == "20" { "overlap" } else { "damaged" };
        joined(&[&all[..1], &[&older], &all[2..]].concat(), &[words]);
    }

    // Torn and changed.
    let torn = strange.join("torn.parquet");
    let whole = bytes(&parts[1]);
    let mut dice = Dice::new(5);
    for _ in 0..20 {
        fs::write(&torn, &whole[..dice.below(whole.len())]).expect("written");
        joined(&[&all[..1], &[&torn], &all[2..]].concat(), &["torn.parquet is not a part of a sweep"]);
    }
    let mut turned = whole.clone();
    turned[whole.len() / 4] ^= 1;
    fs::write(&torn, &turned).expect("written");
    joined(&[&all[..1], &[&torn], &all[2..]].concat(), &["torn.parquet is damaged", "make that part again"]);
    joined(&[&directory.join("none.parquet")], &["none.parquet", "there is no such file"]);
    fs::create_dir(directory.join("empty")).expect("made");
    joined(&[&directory.join("empty")], &["without a file of Parquet"]);

    // The place of the results.
    let file = file.as_str();
    let given: Vec<&str> = all.iter().map(|part| text(part)).collect();
    let at = |out: &Path, words: &[&str]| {
        refused(&[&["merge", file], &given[..], &["--out", text(out)]].concat(), words);
    };
    at(&directory.join("out.txt"), &["NAME.csv or NAME.parquet"]);
    at(&directory.join("nowhere/out.csv"), &["mkdir -p"]);
    fs::write(&out, "somebody's").expect("written");
    at(&out, &["no sweep has left it there", "left alone"]);
    assert_eq!(bytes(&out), b"somebody's");
    fs::remove_file(&out).expect("removed");

    // Told to stop, it leaves nothing; and after all that the parts are as good as before.
    let before = names(&directory);
    let stopped = merge(&study, &parts, &out, &|| false, &mut |_| ());
    assert_eq!(stopped, Err(PartError::Stopped { done: 0, of: 100 }));
    assert_eq!(names(&directory), before);
    assert_eq!(merge(&study, &parts, &out, &|| true, &mut |_| ()).map(|joined| joined.found.runs), Ok(100));
}

#[test]
fn arguments_of_parts_are_checked_before_anything_is_run() {
    let directory = directory("shards_arguments");
    let study = cheap(&directory, 50);
    let out = directory.join("part.parquet");
    for shard in ["0/4", "5/4", "1", "1/0", "a/b", "-1/4", "1/ 4", " 1/4", "+1/4", "01/4", "1/04"] {
        refused(&[&study, "--shard", shard, "--out", text(&out)], &["expected K/N"]);
    }
    refused(&[&study, "--shard", "1/4", "--limit", "3", "--out", text(&out)], &["--limit", "cannot be used with"]);
    refused(&[&study, "--shard", "1/4", "--out", text(&directory.join("part.csv"))], &["a part is a Parquet file"]);
    refused(&[&study, "--shard", "1/4", "--out", text(&directory.join("no/part.parquet"))], &["mkdir -p"]);
    refused(&["merge", &study, "--out", text(&out)], &["<PART>..."]);
    assert_eq!(names(&directory), ["cheap.toml"]);
}

#[test]
fn a_part_of_a_billion_runs_begins_at_once() {
    let directory = directory("shards_billion");
    let axis = |field: &str| format!("[[axes]]\nfield = \"{field}\"\nfrom = 0.1\nto = 0.9\ncount = 1000\n");
    let axes = ["design.arm_ratio", "design.l21_fraction", "contact.friction.mu_static"].map(axis).concat();
    let scene = fs::canonicalize("scenes/free-swing.toml").expect("ships");
    let text_of = format!("scene = \"{}\"\n[set]\nduration = \"1 ms\"\n{axes}", scene.display());
    let file = write(&directory, "large.toml", &text_of);
    let out = directory.join("out.parquet");
    refused(
        &[&file, "--out", text(&out)],
        &["1000000000 runs", "at most 1000000", "--shard 1/1000", "phalanx sweep merge"],
    );
    refused(&[&file, "--shard", "1/999", "--out", text(&out)], &["shard 1/999 has 1001001 runs", "at least 1000"]);
    // As far as it goes, the first runs are made in one piece.
    done(&[&file, "--limit", "3", "--out", text(&directory.join("first.csv"))]);

    let study = load(&file).expect("a study");
    let of = 200_000_000;
    let last = part(&study, (of, of), &directory);
    let runs = table::read(&last).expect("a table").integers("run").expect("runs");
    assert_eq!(runs, (999_999_996..=1_000_000_000).map(Some).collect::<Vec<_>>());
    assert_eq!(range(study.runs(), of, of).map(|shard| shard.first), Some(999_999_996));
    // What is missing is counted, not listed.
    let said =
        refused(&["merge", &file, text(&last), "--out", text(&out)], &["999999995 of 1000000000 runs are in no part"]);
    assert!(said.contains("--shard 1/200000000 to 199999999/200000000") && said.len() < 4000, "{said}");
}

/// Signals and kills need to know when a part is being made.
#[cfg(target_os = "linux")]
mod ended {
    use std::process::{Child, Command, Stdio};
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    use super::*;

    /// A part whose runs have begun: it listens to signals by then.
    fn begun(study: &str, out: &Path) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        command.args(["sweep", study, "--threads", "1", "--shard", "1/2", "--out"]).arg(out);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary starts");
        let patience = Instant::now() + Duration::from_secs(60);
        // Bit 1 of what it catches: SIGINT.
        while caught(child.id()).is_none_or(|mask| mask & 2 == 0) {
            assert!(Instant::now() < patience, "it does not listen to signals");
            sleep(Duration::from_millis(2));
        }
        sleep(Duration::from_millis(50));
        child
    }

    fn caught(process: u32) -> Option<u64> {
        let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
        u64::from_str_radix(line.trim(), 16).ok()
    }

    #[test]
    fn a_part_that_is_killed_or_interrupted_is_not_there() {
        let directory = directory("shards_ended");
        let (study, parts) = (cheap(&directory, 40_000), directory.join("parts"));
        fs::create_dir(&parts).expect("made");
        let out = parts.join("part.parquet");
        for _ in 0..3 {
            let mut child = begun(&study, &out);
            assert!(child.try_wait().expect("a child").is_none(), "it ended before it was killed");
            child.kill().expect("killed");
            child.wait().expect("ended");
            assert_eq!(names(&parts), [""; 0]);
        }
        for (name, signal) in [("INT", "SIGINT"), ("TERM", "SIGTERM")] {
            let child = begun(&study, &out);
            let sent = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status();
            assert!(sent.expect("kill is there").success());
            let output = child.wait_with_output().expect("ends");
            let said = stderr(&output);
            assert_eq!(output.status.code(), Some(3), "{said}");
            for words in [&format!("shard 1/2 was interrupted by {signal}"), "of its 20000 runs", "no file was written"]
            {
                assert!(said.contains(words), "no {words:?} in {said}");
            }
            assert_eq!(names(&parts), [""; 0]);
        }
        // Small enough to be made now, by the same command as ever.
        let study = cheap(&directory, 400);
        let whole = in_one_piece(&study, &directory);
        for number in ["1", "2"] {
            let out = parts.join(format!("{number}.parquet"));
            done(&[&study, "--shard", &format!("{number}/2"), "--out", text(&out)]);
        }
        joins_to(&load(&study).expect("a study"), &[parts], &whole, &directory, "after kills");
    }
}
