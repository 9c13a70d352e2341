//! `phalanx sweep` after kills and signals and with existing results: no finished run is lost, and the results are
//! byte-identical to those of an uninterrupted sweep.

#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::support::cli::{
    self, assert_contains, assert_status, directory, json, path_text, run_json, stderr, stdout, succeed, succeed_json,
    write,
};
use crate::support::faults::XorShift;
use crate::support::studies::{write_short_study, write_short_study_as};
use phalanx::table;

/// Sweeps a study, which must succeed; returns the report.
#[track_caller]
fn sweep(study: &str, out: &Path, flags: &[&str]) -> Value {
    succeed_json(&[&["sweep", study, "--out", path_text(out)], flags].concat())
}

#[track_caller]
fn assert_rejected(study: &str, out: &Path, flags: &[&str], words: &[&str]) {
    cli::assert_rejected(&[&["sweep", study, "--out", path_text(out)], flags].concat(), words);
}

fn start(study: &str, out: &Path, threads: &str) -> Child {
    cli::start(&["sweep", study, "--threads", threads, "--out", path_text(out)])
}

fn partial(out: &Path) -> PathBuf {
    PathBuf::from(format!("{}.partial.csv", out.display()))
}

fn lines(path: &Path) -> usize {
    fs::read(path).map_or(0, |bytes| bytes.iter().filter(|byte| **byte == b'\n').count())
}

fn bytes(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn replace(path: &Path, contents: impl AsRef<[u8]>) {
    fs::write(path, contents).expect("the file is writable");
}

fn wait_for_rows(out: &Path, rows: usize) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while lines(&partial(out)) < rows + 2 && partial(out).exists() | !out.exists() {
        assert!(Instant::now() < deadline, "{} does not grow", partial(out).display());
        sleep(Duration::from_millis(1));
    }
}

#[test]
fn repeated_kills_do_not_change_the_results() {
    let directory = directory("sweep_kill");
    let study = write_short_study(&directory, 4000);
    let uninterrupted = directory.join("uninterrupted.csv");
    let document = sweep(&study, &uninterrupted, &["--threads", "2"]);
    for status in ["completed", "refused", "failed"] {
        assert!(document["by_status"][status].as_u64().expect("a count") > 50, "{document:#}");
    }
    let expected = bytes(&uninterrupted);
    assert_eq!(lines(&uninterrupted), 4001);

    let out = directory.join("killed.csv");
    let mut rng = XorShift::new(6);
    let (mut kills, mut before) = (0, 0);
    while !out.exists() && kills < 200 {
        let mut child = start(&study, &out, ["1", "2", "3"][rng.below(3)]);
        // At a random time between the start and a few hundred rows later.
        wait_for_rows(&out, before + rng.below(600));
        sleep(Duration::from_micros(rng.below(3000) as u64));
        child.kill().expect("the process is killed");
        child.wait().expect("the process ends");
        let rows = lines(&partial(&out)).saturating_sub(2);
        assert!(out.exists() || rows >= before, "finished runs are lost: {rows} of {before}");
        before = rows;
        // Simulates a truncated write.
        if !out.exists() && rows > 0 && rng.below(3) == 0 {
            let rows = bytes(&partial(&out));
            let last = rows[..rows.len() - 1].iter().rposition(|byte| *byte == b'\n').expect("lines") + 1;
            replace(&partial(&out), &rows[..last + rng.below(rows.len() - last)]);
            before -= 1;
        }
        kills += 1;
    }
    assert!(kills >= 5, "{kills}");
    sweep(&study, &out, &[]);
    assert!(bytes(&out) == expected, "the results differ after {kills} kills");
    assert!(!partial(&out).exists());
}

#[test]
fn a_signal_stops_the_sweep_cleanly_and_it_can_resume() {
    let directory = directory("sweep_signal");
    let study = write_short_study(&directory, 6000);
    for (name, signal) in [("INT", "SIGINT"), ("TERM", "SIGTERM")] {
        let out = directory.join(format!("{name}.parquet"));
        let child = start(&study, &out, "2");
        wait_for_rows(&out, 20);
        cli::signal(&child, name);
        let output = child.wait_with_output().expect("the process ends");
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
        assert!(!out.exists());
        // Complete lines only, as many as reported.
        let rows = lines(&partial(&out)) - 2;
        let words =
            [&format!("interrupted by {signal}"), "the same command resumes", &format!("{rows} of 6000 runs are in")];
        assert_contains(stderr(&output), &words);
        assert_eq!(sweep(&study, &out, &[])["now"]["runs"].as_u64(), Some(6000 - rows as u64));
    }
    assert!(bytes(&directory.join("INT.parquet")) == bytes(&directory.join("TERM.parquet")));
}

#[test]
fn finished_runs_are_not_repeated() {
    let directory = directory("sweep_complete");
    let study = write_short_study(&directory, 300);
    let out = directory.join("out.csv");
    // Two partial sweeps equal one complete sweep.
    assert_eq!(sweep(&study, &out, &["--limit", "100"])["now"]["runs"], 100);
    assert_eq!(lines(&out), 101);
    assert_eq!(sweep(&study, &out, &[])["now"]["runs"], 200);
    let contents = String::from_utf8(bytes(&out)).expect("text");
    let again = ["sweep", &study, "--out", path_text(&out), "--json"];
    let output = assert_status(&again, 0, &["nothing was run", "--restart"]);
    assert_eq!(json(&output)["now"]["runs"], 0);
    assert_eq!(sweep(&study, &out, &["--restart"])["now"]["runs"], 300);
    assert!(bytes(&out) == contents.as_bytes());

    // CSV and Parquet contain the same rows.
    let other = directory.join("out.parquet");
    sweep(&study, &other, &[]);
    let [csv, parquet] = [&out, &other].map(|path| table::read(path).expect("a table"));
    assert_eq!(csv.rows.len(), 300);
    for name in ["motor.torque_n_m", "mass_kg", "l12_m"] {
        assert_eq!(csv.numbers(name).expect(name), parquet.numbers(name).expect(name));
    }
    assert_eq!(csv.texts("reason").expect("texts"), parquet.texts("reason").expect("texts"));

    let mut rows: Vec<&str> = contents.split_inclusive('\n').collect();
    let (removed, damaged) = (rows[..200].concat(), format!("{}1,2\n", rows[0]));
    rows[7] = rows[6];
    for (changed, flags, runs) in [
        // Rows that were removed are made again, and a repeated row does not hide a missing one.
        (removed, &[][..], 101),
        (rows.concat(), &[], 1),
        // Damaged results are discarded on request only.
        (damaged.clone(), &["--restart"], 300),
        (damaged.clone(), &["--force"], 300),
    ] {
        replace(&out, &changed);
        if changed == damaged {
            assert_rejected(&study, &out, &[], &["out.csv:", "--restart"]);
        }
        assert_eq!(sweep(&study, &out, flags)["now"]["runs"], runs);
        assert!(bytes(&out) == contents.as_bytes());
    }
    assert!(!partial(&out).exists());
}

#[test]
fn results_of_another_study_are_kept() {
    let directory = directory("sweep_other");
    let (study, out) = (write_short_study(&directory, 50), directory.join("out.csv"));
    replace(&out, "another,table\n1,2\n");
    for flags in [&[][..], &["--restart"]] {
        assert_rejected(&study, &out, flags, &["not replaced", "--force"]);
        assert_eq!(lines(&out), 2);
    }
    sweep(&study, &out, &["--force"]);
    assert_eq!(lines(&out), 51);
    // Results of another study, and a damaged or unreadable file of the study.
    let other = write_short_study_as(&directory, "other.toml", 60);
    assert_rejected(&other, &out, &[], &["results of another study", "--restart"]);
    let provenance = directory.join("out.csv.study.json");
    replace(&provenance, "mine");
    assert_rejected(&study, &out, &[], &["cannot read", "out.csv.study.json", "--force"]);
    fs::remove_file(&provenance).and_then(|()| fs::create_dir(&provenance)).expect("replaced");
    assert_rejected(&study, &out, &["--restart"], &["cannot read", "out.csv.study.json"]);
    fs::remove_dir(&provenance).and_then(|()| fs::remove_file(&out)).expect("removed");

    // Unfinished results of a study that was changed since.
    replace(&partial(&out), "# phalanx sweep 0123456789abcdef of 50, unfinished\nrun\n1\n");
    assert_rejected(&study, &out, &[], &["another study", "--restart discards them", "another --out"]);
    assert_eq!(lines(&partial(&out)), 3);
    sweep(&study, &out, &["--restart"]);
    assert_eq!(lines(&out), 51);

    // Another file with the name of the partial file is kept even with --restart.
    let other = directory.join("other.csv");
    replace(&partial(&other), "another file\n");
    assert_rejected(&study, &other, &["--restart"], &["contains other data"]);
    assert_eq!(bytes(&partial(&other)), b"another file\n");
    sweep(&study, &other, &["--force"]);
}

#[test]
fn concurrent_sweeps_of_one_table_are_rejected() {
    let directory = directory("sweep_two");
    let (study, out) = (write_short_study(&directory, 6000), directory.join("out.csv"));
    let mut first = start(&study, &out, "1");
    wait_for_rows(&out, 5);
    assert_rejected(&study, &out, &["--restart"], &["another command is writing"]);
    assert!(first.wait().expect("the process ends").success());
    assert_eq!(lines(&out), 6001);
}

#[test]
fn results_name_their_preset() {
    let directory = directory("sweep_preset");
    let (study, out) = (write_short_study(&directory, 20), directory.join("out.csv"));
    let report = succeed(&["sweep", &study, "--out", path_text(&out), "--preset", "draft"]);
    assert_contains(&report, &["analytic model (draft preset), 20 runs"]);
    let provenance = fs::read_to_string(directory.join("out.csv.study.json")).expect("written");
    assert_eq!(serde_json::from_str::<Value>(&provenance).expect("JSON")["preset"], "draft");
    assert_rejected(&study, &out, &[], &["results of another study", "--restart"]);
    assert_eq!(sweep(&study, &directory.join("other.csv"), &[])["preset"], Value::Null);
}

#[test]
fn arguments_are_checked_before_running() {
    let directory = directory("sweep_arguments");
    let study = write_short_study(&directory, 50);
    let path = |name: &str| directory.join(name);
    for (out, words) in
        [("out.txt", "neither CSV nor Parquet"), ("none/out.csv", "mkdir -p"), ("dir.csv", "is a directory")]
    {
        fs::create_dir_all(path("dir.csv")).expect("made");
        assert_rejected(&study, &path(out), &[], &[words]);
    }
    cli::assert_rejected(&["sweep", &study], &["--out"]);
    let output = succeed(&["sweep", &study, "--list"]);
    assert_contains(&output, &["50 runs", "motor.torque_n_m", "and 38 more"]);
    assert_eq!(run_json(&["schema", "study"])["title"], "phalanx study");
    assert_eq!(fs::read_dir(&directory).expect("read").count(), 2, "only the study and the directory of this test");
}

#[test]
fn reports_that_no_run_could_be_simulated() {
    let directory = directory("sweep_nothing");
    let text = "[scene]\ndesign.base = \"15 mm\"\n[[axes]]\nfield = \"design.arm_ratio\"\nvalues = [0.4, 0.5]\n";
    let (study, out) = (write(&directory, "study.toml", text), directory.join("out.csv"));
    let output = assert_status(&["sweep", &study, "--out", path_text(&out)], 3, &["no run could be completed"]);
    assert_contains(stdout(&output), &["2 refused, first run 1: `design.l21_fraction` is missing"]);
    assert_eq!(lines(&out), 3);
}
