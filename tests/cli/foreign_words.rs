//! Names in scenes and logs are others' words: no terminal obeys them, and no picture or page breaks by them.

use std::fs;
use std::path::Path;

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, write};

/// Turns the screen red, moves the cursor, ends a tag, and means something to XML.
const NAME: &str = "\u{1b}[31mred\u{7}\u{9b}2J<b>&\"\u{202e}\u{2028}\u{61c}";

fn scene(place: &Path) -> String {
    let text = fs::read_to_string(ANCHOR).expect("the scene");
    let name = "name = \"\\u001b[31mred\\u0007\\u009b2J<b>&\\\"\\u202e\\u2028\\u061c\"";
    write(place, "\u{1b}[2Jx.toml", &text.replace("name = \"experiment-95\"", name))
}

#[track_caller]
fn harmless(what: &str, text: &str) {
    let obeyed = |c: char| c.is_control() && !matches!(c, '\n' | '\t') || NAME[NAME.len() - 8..].contains(c);
    assert!(!text.contains(obeyed), "{what}: {:?}", text.lines().find(|line| line.contains(obeyed)));
}

#[test]
fn no_terminal_obeys_a_name() {
    let place = directory("foreign_terminal");
    let scene = scene(&place);
    let log = place.join("\u{1b}]0;title\u{7}.mcap");
    let log = log.to_str().expect("text");
    let broken = write(&place, "\u{1b}[1mbroken.toml", "name = \"\\u001b\"\n\"k\\u001by\" = 1\n");
    for args in [
        &["run", &scene, "--log", log][..],
        &["run", &scene, "--json"],
        &["replay", log],
        &["replay", log, "--json"],
        &["scene", "check", &scene],
        &["scene", "show", &scene],
        &["statics", &scene],
        &["size", &scene],
        &["scene", "check", &broken],
        &["run", &broken],
        &["run", log],
        &["replay", &scene],
        &["run", "\u{1b}[1mmissing.toml"],
    ] {
        let output = phalanx(args);
        assert!(matches!(output.status.code(), Some(0 | 2)), "{args:?}: {}", stderr(&output));
        harmless("stdout", stdout(&output));
        harmless("stderr", stderr(&output));
    }
    assert_eq!(json(&phalanx(&["run", &scene, "--json"]))["scene"], NAME);
    assert_eq!(json(&phalanx(&["replay", log, "--json"]))["scene"], NAME);
}

#[test]
fn no_picture_or_page_breaks_by_a_name() {
    let place = directory("foreign_pictures");
    let scene = scene(&place);
    let at = |name: &str| place.join(name).to_str().expect("text").to_string();
    let log = at("\u{1b}x.mcap");
    for args in [
        &["run", &scene, "--log", &log][..],
        &["replay", &log, "--html", &at("page.html")],
        &["replay", &log, "--against", &log, "--out", &at("two")],
        &["statics", &scene, "--svg", &at("grasp.svg")],
        &["size", &scene, "--out", &at("sized")],
        &["validate", &scene, "--quick", "--set", "duration=1 ms", "--out", &at("validated")],
        &["scene", "show", &scene, "--figure", &at("linkage.svg")],
    ] {
        let output = phalanx(args);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    }
    for name in [
        "grasp.svg",
        "linkage.svg",
        "two/overlay.svg",
        "two/difference.svg",
        "sized/springs.svg",
        "sized/trajectory.svg",
    ] {
        let text = fs::read_to_string(place.join(name)).expect(name);
        harmless(name, &text);
        assert!(!text.contains("<b>") && text.contains("&lt;b&gt;&amp;"), "{name}: the name is there as text");
        let picture = roxmltree::Document::parse(&text).expect(name);
        let told = picture.root_element().attribute("aria-label").expect("what it is");
        assert!(told.contains("\u{fffd}[31mred\u{fffd}\u{fffd}2J<b>&\""), "{name}: {told}");
    }
    for name in ["two/report.txt", "two/report.json", "sized/size.txt", "validated/report.txt"] {
        harmless(name, &fs::read_to_string(place.join(name)).expect(name));
    }
    for name in ["page.html", "two/page.html"] {
        let text = fs::read_to_string(place.join(name)).expect(name);
        harmless(name, &text);
        assert!(text.contains("<title>\u{fffd}[31mred\u{fffd}\u{fffd}2J&lt;b&gt;&amp;&quot;"), "{name}");
    }
}

#[test]
fn no_text_in_a_table_is_a_formula() {
    let place = directory("foreign_tables");
    let table = "run,design,=note\n1,1,=1+2\n";
    let results = write(&place, "results.csv", table);
    // What is read from a table goes into the next one as it is, but for what a spreadsheet would compute.
    let read = phalanx::table::read(Path::new(&results)).expect("a table");
    let copy = place.join("copy.csv");
    phalanx::table::write(&copy, &read).expect("written");
    assert_eq!(fs::read_to_string(&copy).expect("there"), "run,design,'=note\n1,1,'=1+2\n");
    let again = phalanx::table::read(&copy).expect("a table");
    assert_eq!((again.columns, again.rows), (read.columns, read.rows));
}
