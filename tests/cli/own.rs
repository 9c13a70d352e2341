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
    refused(&place, &["select", text(&results), "--no-form-closed", "--ranking", text(&results)], &["left alone"]);
    let mut other = Vec::from(mcap::MAGIC);
    other.extend([7; 500]);
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
