//! Files of the user are never overwritten: only files written by phalanx are replaced, and those of a directory only
//! together.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::cli::{self, EXPERIMENT_95, directory as test_directory, path_text, phalanx, stderr};

const OTHER_FILE_TEXT: &str = "name = \"mine\"\n";
const THESIS: &str = "scenes/studies/thesis.toml";

/// Bytes of every file in a directory and its subdirectories.
fn contents(directory: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(directory).expect("readable") {
        let path = entry.expect("readable").path();
        match path.is_dir() {
            true => files.extend(contents(&path).into_iter().chain([(path, Vec::new())])),
            false => drop(files.insert(path.clone(), fs::read(&path).expect("a file"))),
        }
    }
    files
}

#[track_caller]
fn run_ok(args: &[&str]) {
    let output = phalanx(args);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{args:?}: {}", stderr(&output));
}

/// Asserts that a command is rejected and that the directory is unchanged.
#[track_caller]
fn assert_rejected(directory: &Path, args: &[&str], parts: &[&str]) {
    let before = contents(directory);
    cli::assert_rejected(args, parts);
    assert!(contents(directory) == before, "{args:?}");
}

#[test]
fn output_replaces_only_files_of_phalanx() {
    let directory = test_directory("own_files");
    let [log, results, other_log] = ["run.mcap", "results.csv", "bag.mcap"].map(|name| directory.join(name));
    run_ok(&["run", EXPERIMENT_95, "--log", path_text(&log)]);
    run_ok(&["sweep", THESIS, "--limit", "96", "--out", path_text(&results)]);
    let commands: [(&[&str], &str); 6] = [
        (&["run", EXPERIMENT_95, "--log"], "again.mcap"),
        (&["replay", path_text(&log), "--plot"], "page.html"),
        (&["replay", path_text(&log), "--csv"], "samples.csv"),
        (&["statics", EXPERIMENT_95, "--plot"], "grasp.svg"),
        (&["thesis", "select", path_text(&results), "--no-form-closed", "--ranking"], "best.csv"),
        (&["thesis", "select", path_text(&results), "--no-form-closed", "--ranking"], "best.parquet"),
    ];
    let is_table = |name: &str| name.ends_with(".csv") || name.ends_with(".parquet");
    for (args, name) in commands {
        let target = directory.join(name);
        let args = [args, &[path_text(&target)]].concat();
        run_ok(&args);
        run_ok(&args);
        // A file of another type is not replaced either, even if phalanx wrote it.
        for (_, other) in commands.into_iter().filter(|(_, other)| !is_table(other) && *other != name) {
            if let Ok(other) = fs::read(directory.join(other)) {
                fs::write(&target, other).expect("written");
                assert_rejected(&directory, &args, &["not replaced"]);
            }
        }
        fs::write(&target, OTHER_FILE_TEXT).expect("written");
        assert_rejected(&directory, &args, &["not replaced; give another name, or replace it with --force"]);
        run_ok(&[&args[..], &["--force"]].concat());
        run_ok(&args);
    }
    // A ranking does not replace its own results, and a log does not replace a log of another program.
    let ranking = ["thesis", "select", path_text(&results), "--force", "--ranking", path_text(&results)];
    assert_rejected(&directory, &ranking, &["is the table of results itself"]);
    // This file contains only a header, with profile "ros2" and library "x".
    let mut other = Vec::from(mcap::MAGIC);
    other.extend(b"\x01\x0d\0\0\0\0\0\0\0\x04\0\0\0ros2\x01\0\0\0x");
    fs::write(&other_log, other).expect("written");
    let args = ["run", EXPERIMENT_95, "--log", path_text(&other_log)];
    assert_rejected(&directory, &args, &["not a log written by phalanx"]);
}

#[test]
fn invalid_paths_are_rejected() {
    let directory = test_directory("own_nowhere");
    let log = directory.join("run.mcap");
    let log = path_text(&log);
    run_ok(&["run", EXPERIMENT_95, "--log", log]);
    let page = directory.join("nodir").join("x.html");
    for args in [
        &["run", EXPERIMENT_95, "--log", path_text(&page)][..],
        &["replay", log, "--plot", path_text(&page)],
        &["replay", log, "--csv", path_text(&page)],
        &["statics", EXPERIMENT_95, "--plot", path_text(&page)],
    ] {
        assert_rejected(&directory, args, &["does not exist; create it first (mkdir -p"]);
        assert!(!stderr(&phalanx(args)).contains(".tmp"), "the message names no temporary file");
    }
    let [folder, table] = ["x/", "x.csv/"].map(|name| format!("{}/{name}", directory.display()));
    for args in [
        &["run", EXPERIMENT_95, "--log", &folder][..],
        &["run", EXPERIMENT_95, "--csv", &folder],
        &["run", EXPERIMENT_95, "--plot", &folder],
        &["run", EXPERIMENT_95, "--plot", path_text(&directory), "--force"],
        &["replay", log, "--against", log, "--plot", &folder],
        &["scene", "show", EXPERIMENT_95, "--plot", &folder],
        &["hold", "scenes/gripper/cycle.toml", "--plot", &folder],
        &["sweep", THESIS, "--out", &table],
        &["thesis", "select", EXPERIMENT_95, "--ranking", &table],
    ] {
        assert_rejected(&directory, args, &["is a directory"]);
    }
}

#[test]
fn outputs_never_overwrite_each_other_or_inputs() {
    let directory = test_directory("own_targets");
    let path_in = |name: &str| directory.join(name).to_str().expect("UTF-8 path").to_string();
    let (log, linked, scene) = (path_in("run.mcap"), path_in("linked.html"), path_in("scenes/start.toml"));
    run_ok(&["run", EXPERIMENT_95, "--log", &log]);
    fs::create_dir(directory.join("scenes")).expect("created");
    fs::copy(EXPERIMENT_95, &scene).expect("copied");
    fs::write(directory.join("empty.html"), "").expect("written");
    fs::hard_link(directory.join("empty.html"), &linked).expect("linked");
    #[cfg(unix)]
    std::os::unix::fs::symlink("scenes", directory.join("link")).expect("linked");
    let study = path_in("study.csv");
    fs::write(&study, "scene = \"scenes/start.toml\"\n").expect("written");
    let sweep =
        |out: &str| assert_rejected(&directory, &["sweep", &study, "--out", out, "--force"], &["the study itself"]);
    sweep(&study);
    fs::hard_link(&study, path_in("study.parquet.study.json")).expect("linked");
    sweep(&path_in("study.parquet"));
    let run = |args: &[&str], message: &str| {
        assert_rejected(&directory, &[&["run", &scene, "--force"], args].concat(), &[message]);
    };
    run(&["--csv", &path_in("empty.html"), "--plot", &linked], "the file of --csv");
    run(&["--plot", &scene], "the name must end in .html");
    run(&["--log", &scene], "the scene itself");
    run(&["--log", &path_in("x.html"), "--plot", &path_in("x.html")], "the file of --log");
    run(&["--log", &path_in("x.mcap"), "--csv", &path_in("x.mcap.partial")], "the file of --log");
    #[cfg(unix)]
    run(&["--csv", &path_in("scenes/x.html"), "--plot", &path_in("link/x.html")], "the file of --csv");
    let two = ["replay", &log, "--against", &log, "--out", &path_in("two"), "--plot", &path_in("two/page.html")];
    assert_rejected(&directory, &two, &["the file of --plot"]);
    let both = ["replay", &log, "--csv", &path_in("a.csv"), "--plot", &log];
    assert_rejected(&directory, &both, &["--plot", "the name must end in .html"]);
    run_ok(&["run", &scene, "--csv", "/dev/null", "--plot", "/dev/null"]);
    // An empty file may be replaced.
    run_ok(&["run", &scene, "--plot", &linked]);
}

/// Shortens the runs, which are repeated three times; the written files are the same.
const SHORT_RUN: [&str; 2] = ["--set", "duration=1 ms"];

#[test]
fn files_of_output_directories_are_recognised() {
    let directory = test_directory("own_directories");
    let log = directory.join("run.mcap");
    run_ok(&["run", EXPERIMENT_95, "--log", path_text(&log)]);
    let stability = ["thesis", "stability", EXPERIMENT_95, "--steps", "1 ms", "--stiffness", "1", "--damping", "1"];
    let commands: [&[&str]; 8] = [
        &["validate", "scenes/free-swing.toml", "--quick", SHORT_RUN[0], SHORT_RUN[1], "--out"],
        &["validate", "scenes/laws/step-size.toml", "--quick", SHORT_RUN[0], SHORT_RUN[1], "--out"],
        &["replay", path_text(&log), "--against", path_text(&log), "--out"],
        &["thesis", "volume", "--resolution", "2", "--out"],
        &["size", EXPERIMENT_95, "--out"],
        &[&stability[..], &["--out"]].concat(),
        &["capture", "scenes/gripper/offset.toml", "--places", "3", "--finely", "3 mm", "--out"],
        &["man"],
    ];
    for (index, args) in commands.into_iter().enumerate() {
        let out = directory.join(format!("out-{index}"));
        let args = [args, &[path_text(&out)]].concat();
        run_ok(&args);
        run_ok(&args);
        // Every file is recognised, and another file in its place is not replaced.
        for path in contents(&out).into_keys() {
            let before = fs::read(&path).expect("a file");
            fs::write(&path, OTHER_FILE_TEXT).expect("written");
            let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
            assert_rejected(&directory, &args, &[name, "not replaced; give another", "--force"]);
            fs::write(&path, before).expect("written");
        }
        let path = contents(&out).into_keys().next_back().expect("a file");
        fs::remove_file(&path).expect("removed");
        fs::create_dir(&path).expect("created");
        assert_rejected(&directory, &[&args[..], &["--force"]].concat(), &["that is a directory; give another"]);
        fs::remove_dir(&path).expect("removed");
        fs::write(&path, OTHER_FILE_TEXT).expect("written");
        run_ok(&[&args[..], &["--force"]].concat());
        assert!(contents(&out).into_keys().all(|path| !path_text(&path).contains(".phalanx-")), "no temporary files");
    }
}
