//! Nothing of a user's is overwritten: only files that phalanx wrote give way, and the files of a directory together.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::cli::{ANCHOR, directory, phalanx, stderr, stdout};

const MINE: &str = "name = \"mine\"\n";

/// Every file of a directory and those below with its bytes.
fn contents(directory: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(directory).expect("there") {
        let path = entry.expect("readable").path();
        match path.is_dir() {
            true => {
                found.insert(path.clone(), Vec::new());
                found.extend(contents(&path));
            }
            false => drop(found.insert(path.clone(), fs::read(&path).expect("a file"))),
        }
    }
    found
}

#[track_caller]
fn done(args: &[&str]) {
    let output = phalanx(args);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{args:?}: {}", stderr(&output));
}

/// Refused with status 2 and a way out; everything in the directory is as it was.
#[track_caller]
fn refused(place: &Path, args: &[&str], parts: &[&str]) {
    let before = contents(place);
    let output = phalanx(args);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
    assert_eq!(stdout(&output), "", "{args:?}");
    for part in parts {
        assert!(stderr(&output).contains(part), "{args:?}: no {part:?} in {}", stderr(&output));
    }
    assert!(contents(place) == before, "{args:?}");
}

fn text(path: &Path) -> &str {
    path.to_str().expect("plain text")
}

#[test]
fn a_file_that_is_asked_for_replaces_its_like_and_nothing_else() {
    let place = directory("own_files");
    let log = place.join("run.mcap");
    done(&["run", ANCHOR, "--log", text(&log)]);
    let results = place.join("results.csv");
    done(&["sweep", "scenes/studies/thesis.toml", "--limit", "96", "--out", text(&results)]);
    let commands: [(&[&str], &str); 6] = [
        (&["run", ANCHOR, "--log"], "again.mcap"),
        (&["replay", text(&log), "--html"], "page.html"),
        (&["replay", text(&log), "--csv"], "samples.csv"),
        (&["replay", text(&log), "--recover"], "whole.mcap"),
        (&["statics", ANCHOR, "--svg"], "grasp.svg"),
        (&["select", text(&results), "--no-form-closed", "--ranking"], "best.csv"),
    ];
    for (args, name) in commands {
        let target = place.join(name);
        let args = [args, &[text(&target)]].concat();
        done(&args);
        done(&args);
        // One of our own files of another form is there by a slip of the hand too.
        let form = |name: &str| name.rsplit('.').next().map(str::to_string);
        for (_, other) in commands.into_iter().filter(|(_, other)| form(other) != form(name)) {
            if let Ok(other) = fs::read(place.join(other)) {
                fs::write(&target, other).expect("written");
                refused(&place, &args, &["left alone"]);
            }
        }
        fs::write(&target, MINE).expect("written");
        refused(&place, &args, &["left alone"]);
        fs::remove_file(&target).expect("removed");
        done(&args);
    }
    // A ranking is not written over the results it is made from, nor a log over one of another program.
    refused(&place, &["select", text(&results), "--ranking", text(&results)], &["is the table of results itself"]);
    // A header alone: profile "ros2", library "x".
    let mut other = Vec::from(mcap::MAGIC);
    other.extend(b"\x01\x0d\0\0\0\0\0\0\0\x04\0\0\0ros2\x01\0\0\0x");
    let bag = place.join("bag.mcap");
    fs::write(&bag, other).expect("written");
    refused(&place, &["run", ANCHOR, "--log", text(&bag)], &["not an MCAP log that phalanx wrote"]);
}

#[test]
fn a_place_that_is_none_is_refused_in_plain_words() {
    let place = directory("own_nowhere");
    let log = place.join("run.mcap");
    done(&["run", ANCHOR, "--log", text(&log)]);
    let page = place.join("nodir").join("x.html");
    for args in [
        &["replay", text(&log), "--html", text(&page)][..],
        &["replay", text(&log), "--csv", text(&page)],
        &["statics", ANCHOR, "--svg", text(&page)],
    ] {
        refused(&place, args, &["does not exist; create it first (mkdir -p"]);
        assert!(!stderr(&phalanx(args)).contains(".tmp"), "no name of a temporary file");
    }
    let (nowhere, table) = (format!("{}/x/", place.display()), format!("{}/x.csv/", place.display()));
    for args in [
        &["run", ANCHOR, "--log", &nowhere][..],
        &["run", ANCHOR, "--csv", &nowhere],
        &["run", ANCHOR, "--html", &nowhere],
        &["run", ANCHOR, "--html", text(&place)],
        &["replay", text(&log), "--recover", &nowhere],
        &["replay", text(&log), "--against", text(&log), "--html", &nowhere],
        &["scene", "show", ANCHOR, "--figure", &nowhere],
        &["hold", "scenes/gripper/cycle.toml", "--svg", &nowhere],
        &["optimize", SEARCH, "--out", &table],
        &["optimize", SEARCH, "--out", "no.csv", "--plot", &nowhere],
        &["sweep", "scenes/studies/thesis.toml", "--out", &table],
        &["select", ANCHOR, "--ranking", &table],
    ] {
        refused(&place, args, &["is a directory"]);
    }
}

const SEARCH: &str = "scenes/studies/optimize-95.toml";

#[test]
fn outputs_of_one_command_spare_each_other_and_its_inputs() {
    let place = directory("own_targets");
    let at = |name: &str| place.join(name).to_str().expect("text").to_string();
    let (a, log, linked, scene) = (at("a.csv"), at("run.mcap"), at("linked.html"), at("scenes/start.toml"));
    done(&["run", ANCHOR, "--log", &log]);
    fs::create_dir(place.join("scenes")).expect("made");
    fs::copy(ANCHOR, &scene).expect("copied");
    fs::write(place.join("empty.html"), "").expect("written");
    fs::hard_link(place.join("empty.html"), &linked).expect("linked");
    #[cfg(unix)]
    std::os::unix::fs::symlink("scenes", place.join("link")).expect("linked");
    let study = fs::read_to_string(SEARCH).expect("a study");
    let (_, variables) = study.split_once("# Within the ends").expect("a comment before the variables");
    fs::write(place.join("study.toml"), format!("scene = \"scenes/start.toml\"\n#{variables}")).expect("written");
    let study = at("study.toml");
    let optimize = |more: [&str; 2], theirs: &str| {
        refused(&place, &["optimize", &study, "--out", &a, more[0], more[1]], &[more[0], theirs]);
    };
    optimize(["--html", &a], "the file of --out");
    optimize(["--plot", &at("./a.runs.csv")], "the file of the runs of --out");
    optimize(["--plot", &at("a.runs.csv.study.json")], "the file of the runs of --out");
    optimize(["--html", &at("scenes/../a.runs.csv.partial.csv")], "the file of the runs of --out");
    optimize(["--scenes", &at("scenes")], "which is the study itself, which must stay as it is");
    optimize(["--plot", &study], "is the study itself");
    let run = |args: &[&str], theirs: &str| refused(&place, &[&["run", &scene], args].concat(), &[theirs]);
    run(&["--csv", &at("empty.html"), "--html", &linked], "the file of --csv");
    run(&["--html", &scene], "the scene itself");
    run(&["--log", &at("x.mcap"), "--html", &at("x.mcap")], "the file of --log");
    run(&["--log", &at("x.mcap"), "--csv", &at("x.mcap.partial")], "the file of --log");
    #[cfg(unix)]
    run(&["--csv", &at("scenes/x"), "--html", &at("link/x")], "the file of --csv");
    let two = ["replay", &log, "--against", &log, "--out", &at("two"), "--html", &at("two/page.html")];
    refused(&place, &two, &["the file of --html"]);
    refused(&place, &["replay", &log, "--csv", &a, "--html", &log], &["--html", "is the log itself"]);
    done(&["run", &scene, "--csv", "/dev/null", "--html", "/dev/null"]);
    // An empty file is nobody's loss.
    done(&["run", &scene, "--html", &linked]);
}

/// What is written is the same, and done thrice.
const SHORT: [&str; 2] = ["--set", "duration=1 ms"];

#[test]
fn directories_of_results_are_replaced_whole_or_not_at_all() {
    let place = directory("own_directories");
    let log = place.join("run.mcap");
    done(&["run", ANCHOR, "--log", text(&log)]);
    let commands: [(&[&str], &str, &str); 6] = [
        (&["validate", "scenes/free-swing.toml", "--quick", SHORT[0], SHORT[1]], "report.txt", "page.html"),
        (&["validate", "scenes/laws/step-size.toml", "--quick", SHORT[0], SHORT[1]], "series.csv", "engine.mcap"),
        (&["replay", text(&log), "--against", text(&log)], "report.json", "overlay.svg"),
        (&["volume", "--resolution", "2"], "points.csv", "page.html"),
        (&["size", ANCHOR], "size.txt", "springs.svg"),
        (
            &["study", "stability", ANCHOR, "--steps", "1 ms", "--stiffness", "1", "--damping", "1"],
            "table.txt",
            "stability.svg",
        ),
    ];
    // Checksums that are none are somebody's file.
    let foreign = place.join("foreign");
    fs::create_dir(&foreign).expect("made");
    let others: [&[&str]; 6] = [
        &["capture", "scenes/gripper/offset.toml", "--out"],
        &["hold", "scenes/gripper/cycle.toml", "--out"],
        &["study", "step-size", "--out"],
        &["reproduce", "--out"],
        &["optimize", SEARCH, "--out", "no.csv", "--scenes"],
        &["man"],
    ];
    fs::write(foreign.join(".phalanx"), "{\"notes.txt\": [\"mine\"]}").expect("written");
    let with_out = commands.map(|(args, ..)| [args, &["--out"]].concat());
    for args in with_out.iter().map(Vec::as_slice).chain(others) {
        refused(&place, &[args, &[text(&foreign)]].concat(), &[".phalanx", "left alone"]);
    }
    for (index, (args, report, picture)) in commands.into_iter().enumerate() {
        let out = place.join(format!("out-{index}"));
        let args = [args, &["--out", text(&out)]].concat();
        done(&args);
        done(&args);
        for name in [report, picture] {
            let before = fs::read(out.join(name)).expect(name);
            fs::write(out.join(name), MINE).expect("written");
            refused(&place, &args, &[name, "left alone; give another --out, or delete it"]);
            fs::remove_file(out.join(name)).expect("removed");
            fs::create_dir(out.join(name)).expect("made");
            refused(&place, &args, &[name, "that is a directory; give another --out"]);
            fs::remove_dir(out.join(name)).expect("removed");
            fs::write(out.join(name), before).expect("written");
        }
        // Notes in a report are somebody's work.
        let mut noted = fs::read(out.join(report)).expect(report);
        noted.extend(b"remember\n");
        fs::write(out.join(report), noted).expect("written");
        refused(&place, &args, &[report, "has been changed since"]);
        fs::remove_file(out.join(report)).expect("removed");
        done(&args);
        let names = fs::read_dir(&out).expect("there").map(|entry| entry.expect("readable").file_name());
        assert!(names.into_iter().all(|name| !text(Path::new(&name)).ends_with(".tmp")), "nothing lies about");
    }
}
