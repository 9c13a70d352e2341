//! Files of the user are never overwritten: only files written by phalanx are replaced, and those of a directory only
//! together.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::cli::{EXPERIMENT_95, directory as test_directory, phalanx, stderr, stdout};

const OTHER_FILE_TEXT: &str = "name = \"mine\"\n";

/// Bytes of every file in a directory and its subdirectories.
fn contents(directory: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(directory).expect("readable") {
        let path = entry.expect("readable").path();
        match path.is_dir() {
            true => {
                files.insert(path.clone(), Vec::new());
                files.extend(contents(&path));
            }
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

/// Asserts that a command is rejected with status 2 and a message that contains each of `parts`, and that the directory
/// is unchanged.
#[track_caller]
fn assert_rejected(directory: &Path, args: &[&str], parts: &[&str]) {
    let before = contents(directory);
    let output = phalanx(args);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
    assert_eq!(stdout(&output), "", "{args:?}");
    for part in parts {
        assert!(stderr(&output).contains(part), "{args:?}: no {part:?} in {}", stderr(&output));
    }
    assert!(contents(directory) == before, "{args:?}");
}

fn path_text(path: &Path) -> &str {
    path.to_str().expect("UTF-8 path")
}

#[test]
fn output_replaces_only_files_of_the_same_kind() {
    let directory = test_directory("own_files");
    let log = directory.join("run.mcap");
    run_ok(&["run", EXPERIMENT_95, "--log", path_text(&log)]);
    let results = directory.join("results.csv");
    run_ok(&["sweep", "scenes/studies/thesis.toml", "--limit", "96", "--out", path_text(&results)]);
    let commands: [(&[&str], &str); 5] = [
        (&["run", EXPERIMENT_95, "--log"], "again.mcap"),
        (&["replay", path_text(&log), "--html"], "page.html"),
        (&["replay", path_text(&log), "--csv"], "samples.csv"),
        (&["statics", EXPERIMENT_95, "--svg"], "grasp.svg"),
        (&["select", path_text(&results), "--no-form-closed", "--ranking"], "best.csv"),
    ];
    for (args, name) in commands {
        let target = directory.join(name);
        let args = [args, &[path_text(&target)]].concat();
        run_ok(&args);
        run_ok(&args);
        // A file of another kind is not replaced either, even if phalanx wrote it.
        let extension = |name: &str| name.rsplit('.').next().map(str::to_string);
        for (_, other) in commands.into_iter().filter(|(_, other)| extension(other) != extension(name)) {
            if let Ok(other) = fs::read(directory.join(other)) {
                fs::write(&target, other).expect("written");
                assert_rejected(&directory, &args, &["not replaced"]);
            }
        }
        fs::write(&target, OTHER_FILE_TEXT).expect("written");
        assert_rejected(&directory, &args, &["not replaced"]);
        fs::remove_file(&target).expect("removed");
        run_ok(&args);
    }
    // A ranking does not replace its own results, and a log does not replace a log of another program.
    assert_rejected(
        &directory,
        &["select", path_text(&results), "--ranking", path_text(&results)],
        &["is the table of results itself"],
    );
    // This file contains only a header, with profile "ros2" and library "x".
    let mut other = Vec::from(mcap::MAGIC);
    other.extend(b"\x01\x0d\0\0\0\0\0\0\0\x04\0\0\0ros2\x01\0\0\0x");
    let other_log = directory.join("bag.mcap");
    fs::write(&other_log, other).expect("written");
    assert_rejected(
        &directory,
        &["run", EXPERIMENT_95, "--log", path_text(&other_log)],
        &["not an MCAP log written by phalanx"],
    );
}

#[test]
fn invalid_paths_are_rejected() {
    let directory = test_directory("own_nowhere");
    let log = directory.join("run.mcap");
    run_ok(&["run", EXPERIMENT_95, "--log", path_text(&log)]);
    let page = directory.join("nodir").join("x.html");
    for args in [
        &["replay", path_text(&log), "--html", path_text(&page)][..],
        &["replay", path_text(&log), "--csv", path_text(&page)],
        &["statics", EXPERIMENT_95, "--svg", path_text(&page)],
    ] {
        assert_rejected(&directory, args, &["does not exist; create it first (mkdir -p"]);
        assert!(!stderr(&phalanx(args)).contains(".tmp"), "the message names no temporary file");
    }
    let (directory_path, table_path) =
        (format!("{}/x/", directory.display()), format!("{}/x.csv/", directory.display()));
    for args in [
        &["run", EXPERIMENT_95, "--log", &directory_path][..],
        &["run", EXPERIMENT_95, "--csv", &directory_path],
        &["run", EXPERIMENT_95, "--html", &directory_path],
        &["run", EXPERIMENT_95, "--html", path_text(&directory)],
        &["replay", path_text(&log), "--against", path_text(&log), "--html", &directory_path],
        &["scene", "show", EXPERIMENT_95, "--figure", &directory_path],
        &["hold", "scenes/gripper/cycle.toml", "--svg", &directory_path],
        &["sweep", "scenes/studies/thesis.toml", "--out", &table_path],
        &["select", EXPERIMENT_95, "--ranking", &table_path],
    ] {
        assert_rejected(&directory, args, &["is a directory"]);
    }
}

#[test]
fn outputs_never_overwrite_each_other_or_inputs() {
    let directory = test_directory("own_targets");
    let path_in = |name: &str| directory.join(name).to_str().expect("UTF-8 path").to_string();
    let (a, log, linked, scene) =
        (path_in("a.csv"), path_in("run.mcap"), path_in("linked.html"), path_in("scenes/start.toml"));
    run_ok(&["run", EXPERIMENT_95, "--log", &log]);
    fs::create_dir(directory.join("scenes")).expect("created");
    fs::copy(EXPERIMENT_95, &scene).expect("copied");
    fs::write(directory.join("empty.html"), "").expect("written");
    fs::hard_link(directory.join("empty.html"), &linked).expect("linked");
    #[cfg(unix)]
    std::os::unix::fs::symlink("scenes", directory.join("link")).expect("linked");
    let run =
        |args: &[&str], message: &str| assert_rejected(&directory, &[&["run", &scene], args].concat(), &[message]);
    run(&["--csv", &path_in("empty.html"), "--html", &linked], "the file of --csv");
    run(&["--html", &scene], "the scene itself");
    run(&["--log", &path_in("x.mcap"), "--html", &path_in("x.mcap")], "the file of --log");
    run(&["--log", &path_in("x.mcap"), "--csv", &path_in("x.mcap.partial")], "the file of --log");
    #[cfg(unix)]
    run(&["--csv", &path_in("scenes/x"), "--html", &path_in("link/x")], "the file of --csv");
    let two = ["replay", &log, "--against", &log, "--out", &path_in("two"), "--html", &path_in("two/page.html")];
    assert_rejected(&directory, &two, &["the file of --html"]);
    assert_rejected(&directory, &["replay", &log, "--csv", &a, "--html", &log], &["--html", "is the log itself"]);
    run_ok(&["run", &scene, "--csv", "/dev/null", "--html", "/dev/null"]);
    // An empty file may be replaced.
    run_ok(&["run", &scene, "--html", &linked]);
}

/// Shortens the runs, which are repeated three times; the written files are the same.
const SHORT_RUN: [&str; 2] = ["--set", "duration=1 ms"];

#[test]
fn output_directories_are_replaced_atomically() {
    let directory = test_directory("own_directories");
    let log = directory.join("run.mcap");
    run_ok(&["run", EXPERIMENT_95, "--log", path_text(&log)]);
    let commands: [(&[&str], &str, &str); 6] = [
        (&["validate", "scenes/free-swing.toml", "--quick", SHORT_RUN[0], SHORT_RUN[1]], "report.txt", "page.html"),
        (
            &["validate", "scenes/laws/step-size.toml", "--quick", SHORT_RUN[0], SHORT_RUN[1]],
            "series.csv",
            "engine.mcap",
        ),
        (&["replay", path_text(&log), "--against", path_text(&log)], "report.json", "overlay.svg"),
        (&["volume", "--resolution", "2"], "points.csv", "page.html"),
        (&["size", EXPERIMENT_95], "size.txt", "springs.svg"),
        (
            &["study", "stability", EXPERIMENT_95, "--steps", "1 ms", "--stiffness", "1", "--damping", "1"],
            "table.txt",
            "stability.svg",
        ),
    ];
    // A checksum file with invalid checksums is a foreign file.
    let other_directory = directory.join("foreign");
    fs::create_dir(&other_directory).expect("created");
    let other_commands: [&[&str]; 5] = [
        &["capture", "scenes/gripper/offset.toml", "--out"],
        &["hold", "scenes/gripper/cycle.toml", "--out"],
        &["study", "step-size", "--out"],
        &["reproduce", "--out"],
        &["man"],
    ];
    fs::write(other_directory.join(".phalanx"), "{\"notes.txt\": [\"mine\"]}").expect("written");
    let with_out = commands.map(|(args, ..)| [args, &["--out"]].concat());
    for args in with_out.iter().map(Vec::as_slice).chain(other_commands) {
        assert_rejected(&directory, &[args, &[path_text(&other_directory)]].concat(), &[".phalanx", "not replaced"]);
    }
    for (index, (args, report, picture)) in commands.into_iter().enumerate() {
        let out = directory.join(format!("out-{index}"));
        let args = [args, &["--out", path_text(&out)]].concat();
        run_ok(&args);
        run_ok(&args);
        for name in [report, picture] {
            let before = fs::read(out.join(name)).expect(name);
            fs::write(out.join(name), OTHER_FILE_TEXT).expect("written");
            assert_rejected(&directory, &args, &[name, "not replaced; give another --out, or delete it"]);
            fs::remove_file(out.join(name)).expect("removed");
            fs::create_dir(out.join(name)).expect("created");
            assert_rejected(&directory, &args, &[name, "that is a directory; give another --out"]);
            fs::remove_dir(out.join(name)).expect("removed");
            fs::write(out.join(name), before).expect("written");
        }
        // A report edited by the user is not replaced.
        let mut edited_report = fs::read(out.join(report)).expect(report);
        edited_report.extend(b"remember\n");
        fs::write(out.join(report), edited_report).expect("written");
        assert_rejected(&directory, &args, &[report, "has been changed since"]);
        fs::remove_file(out.join(report)).expect("removed");
        run_ok(&args);
        let names = fs::read_dir(&out).expect("readable").map(|entry| entry.expect("readable").file_name());
        assert!(
            names.into_iter().all(|name| !path_text(Path::new(&name)).ends_with(".tmp")),
            "no temporary files are left"
        );
    }
}
