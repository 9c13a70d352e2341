//! Names in scenes and logs are untrusted: they must not control terminals or break pictures and pages.

use std::fs;
use std::path::Path;

use phalanx::table::{Column, Kind, Table, Value};

use crate::support::cli::{
    EXPERIMENT_95, directory as test_directory, path_in, phalanx, stderr, stdout, succeed, succeed_json, write,
};

/// Contains sequences that colour the terminal and move the cursor, a tag, and special characters of XML.
const NAME: &str = "\u{1b}[31mred\u{7}\u{9b}2J<b>&\"\u{202e}\u{2028}\u{61c}";

fn scene_with_untrusted_name(directory: &Path) -> String {
    let text = fs::read_to_string(EXPERIMENT_95).expect("the scene");
    let name = "name = \"\\u001b[31mred\\u0007\\u009b2J<b>&\\\"\\u202e\\u2028\\u061c\"";
    write(directory, "\u{1b}[2Jx.toml", &text.replace("name = \"experiment-95\"", name))
}

#[track_caller]
fn assert_no_control_chars(source: &str, text: &str) {
    let is_control = |c: char| c.is_control() && !matches!(c, '\n' | '\t') || NAME[NAME.len() - 8..].contains(c);
    assert!(!text.contains(is_control), "{source}: {:?}", text.lines().find(|line| line.contains(is_control)));
}

#[test]
fn terminal_output_escapes_names() {
    let directory = test_directory("foreign_terminal");
    let scene = scene_with_untrusted_name(&directory);
    let log = &path_in(&directory, "\u{1b}]0;title\u{7}.mcap");
    let broken = write(&directory, "\u{1b}[1mbroken.toml", "name = \"\\u001b\"\n\"k\\u001by\" = 1\n");
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
        assert_no_control_chars("stdout", stdout(&output));
        assert_no_control_chars("stderr", stderr(&output));
    }
    assert!(succeed(&["run", &scene]).starts_with("\\u001b[31mred\\u0007\\u009b2J<b>&\"\\u202e\\u2028\\u061c"));
    assert_eq!(succeed_json(&["run", &scene])["scene"], NAME);
    assert_eq!(succeed_json(&["replay", log])["scene"], NAME);
}

#[test]
fn pictures_and_pages_escape_names() {
    let directory = test_directory("foreign_pictures");
    let scene = scene_with_untrusted_name(&directory);
    let path_in = |name: &str| path_in(&directory, name);
    let log = path_in("\u{1b}x.mcap");
    for args in [
        &["run", &scene, "--log", &log][..],
        &["replay", &log, "--plot", &path_in("page.html")],
        &["replay", &log, "--against", &log, "--out", &path_in("two")],
        &["statics", &scene, "--plot", &path_in("grasp.svg")],
        &["size", &scene, "--out", &path_in("sized")],
        &["validate", &scene, "--quick", "--set", "duration=1 ms", "--out", &path_in("validated")],
        &["scene", "show", &scene, "--plot", &path_in("linkage.svg")],
    ] {
        succeed(args);
    }
    let statics = ["grasp.svg", "linkage.svg", "sized/springs.svg", "sized/trajectory.svg"];
    for name in statics.into_iter().chain(["two/overlay.svg", "two/difference.svg", "validated/speed-error.svg"]) {
        let text = fs::read_to_string(directory.join(name)).expect(name);
        assert_no_control_chars(name, &text);
        assert!(!text.contains("<b>") && text.contains("&lt;b&gt;&amp;"), "{name}: the name is there as text");
        let picture = roxmltree::Document::parse(&text).expect(name);
        let label = picture.root_element().attribute("aria-label").expect("what it is");
        assert!(label.contains("\u{fffd}[31mred\u{fffd}\u{fffd}2J<b>&\""), "{name}: {label}");
    }
    for name in ["two/report.txt", "two/report.json", "sized/size.txt", "validated/report.txt"] {
        assert_no_control_chars(name, &fs::read_to_string(directory.join(name)).expect(name));
    }
    for name in ["page.html", "two/page.html"] {
        let text = fs::read_to_string(directory.join(name)).expect(name);
        assert_no_control_chars(name, &text);
        assert!(text.contains("<title>\u{fffd}[31mred\u{fffd}\u{fffd}2J&lt;b&gt;&amp;&quot;"), "{name}");
    }
}

/// A name with line breaks does not begin a line of a report or of a message.
#[test]
fn line_breaks_of_names_do_not_forge_lines() {
    let directory = test_directory("foreign_lines");
    let text = fs::read_to_string(EXPERIMENT_95).expect("the scene");
    let name = "a\\nforged    accurate\\n# forged\\n\\n- forged";
    let scene =
        &write(&directory, "scene.toml", &text.replace("name = \"experiment-95\"", &format!("name = \"{name}\"")));
    let [log, sized] = ["run.mcap", "sized"].map(|name| path_in(&directory, name));
    let no_object = format!("{}\n[object]\npresent = false\n", fs::read_to_string(scene).expect("the scene"));
    let no_object = &write(&directory, "empty.toml", &no_object);
    let broken = &write(
        &directory,
        "broken.toml",
        "kind = \"mechanism\"\n[bodies.\"a\\nforged\"]\nmass = \"1\\nforged\"\n[joints.\"b\\nforged\"]\nbodies = [\"c\\nforged\", \"ground\"]\n\
         extends = \"d\\nforged.toml\"\n",
    );
    let is_forged = |text: &str| {
        text.lines().any(|line| line.trim_start().trim_start_matches(['#', '-', ' ']).starts_with("forged"))
    };
    for args in [
        &["run", scene, "--log", &log][..],
        &["replay", &log],
        &["replay", &log, "--against", &log],
        &["statics", scene],
        &["size", scene, "--out", &sized],
        &["scene", "check", scene, broken],
        &["validate", scene, "--quick", "--set", "duration=1 ms"],
        &["run", scene, "--set", "log.numeric_rate=\"1\\nforged\""],
        &["statics", no_object],
        &["size", no_object],
        &["run", broken],
    ] {
        let output = phalanx(args);
        for text in [stdout(&output), stderr(&output)] {
            assert!(!is_forged(text), "{args:?}: {text}");
        }
    }
    assert!(succeed(&["run", scene]).starts_with("a\\nforged    accurate\\n# forged"));
    assert!(succeed_json(&["run", scene])["scene"].as_str().expect("a name").starts_with("a\nforged"));
    let report = fs::read_to_string(Path::new(&sized).join("size.txt")).expect("a report");
    assert!(!is_forged(&report), "{report}");
}

#[test]
fn table_text_is_never_a_formula() {
    let directory = test_directory("foreign_tables");
    let table = "run,design,=note\n1,1,=1+2\n";
    let results = write(&directory, "results.csv", table);
    // Text is copied unchanged from one table to the next, except for spreadsheet formulas, which are quoted.
    let read = phalanx::table::read(Path::new(&results)).expect("a table");
    let copy = directory.join("copy.csv");
    phalanx::table::write(&copy, &read).expect("written");
    assert_eq!(fs::read_to_string(&copy).expect("readable"), "run,design,'=note\n1,1,'=1+2\n");
    let reparsed = phalanx::table::read(&copy).expect("a table");
    assert_eq!((reparsed.columns, reparsed.rows), (read.columns, read.rows));
    // Every text is restored.
    let texts = ["=1+2", "+1", "-x", "@SUM(A1)", "\t=1", "'=1", "''", "''=a", "'tis", "'", "a=b", "µ"];
    let rows = texts.map(|text| vec![Value::from(text)]).to_vec();
    let table = Table::new(vec![Column::new("text", Kind::Text)], rows);
    phalanx::table::write(&copy, &table).expect("written");
    let written = fs::read_to_string(&copy).expect("readable");
    assert!(
        !written.lines().any(|line| line.trim_start_matches('"').starts_with(['=', '+', '-', '@', '\t'])),
        "{written}"
    );
    assert_eq!(phalanx::table::read(&copy).expect("a table"), table);
}
