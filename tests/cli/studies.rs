//! `phalanx size`, `select`, `study` and `volume`: tables, JSON, files and errors.

use std::fs;
use std::path::Path;

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_rejected, assert_status, directory, path_text, stdout, succeed,
    succeed_json, variant, write,
};
use crate::support::sweep_results::{results_table, successful_run};
use phalanx::table::{self, Value as Cell};
use serde_json::Value;

#[test]
fn size_table_compares_both_sizings_with_the_scene() {
    let text = succeed(&["size", EXPERIMENT_95]);
    assert_contains(&text, &["516.60            117.72  <-", "440.88            117.72", "480.00            132.60"]);
    for row in ["q21-q11", "q12", "q22", "q11+q12-(q21+q22)"] {
        assert!(text.lines().any(|line| line.starts_with(row)), "{row}\n{text}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
}

#[test]
fn size_json_agrees_with_self_sizing_scene() {
    let report = succeed_json(&["size", EXPERIMENT_95, "--rule", "whole"]);
    assert_eq!(report["rule"], "whole");
    assert_eq!(report["motor_n_m"], report["whole"]["motor_n_m"]);
    assert_eq!(report["given"]["motor_n_m"], 0.48);
    assert!(report["convergence_relative"].as_f64().unwrap() < 1e-6);

    let design = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";
    let scene = write(&directory("size-scene"), "sized.toml", &format!("sizing = \"whole\"\n{design}"));
    assert_eq!(succeed_json(&["size", &scene])["given"], report["whole"]);
    let torsional = succeed_json(&["size", "scenes/torsional-spring.toml"]);
    assert_eq!(torsional["spring_types"][1]["preload_rad"], 110f64.to_radians(), "preload of the scene");
    // The torque is about inversely proportional to the square of the closing time.
    let fast_sizing = succeed_json(&["size", EXPERIMENT_95, "--closing-time", "5 ms"]);
    let ratio = fast_sizing["motor_n_m"].as_f64().unwrap() / report["rigid"]["motor_n_m"].as_f64().unwrap();
    assert!((3.9..4.1).contains(&ratio), "{ratio}");
}

#[test]
fn size_files_are_complete() {
    let out = directory("size-files");
    succeed(&["size", EXPERIMENT_95, "--out", out.to_str().unwrap()]);
    let read = |file: &str| fs::read_to_string(out.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    for svg in ["trajectory.svg", "springs.svg", "spring-types.svg"].map(read) {
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && !svg.contains("NaN"), "{svg}");
    }
    let csv = read("size.csv");
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().count() > 400 && csv.lines().all(|line| line.split(',').count() == columns));
    assert_eq!(serde_json::from_str::<Value>(&read("size.json")).unwrap()["rule"], "rigid");
    assert_eq!(read("size.txt"), format!("Report by phalanx\n\n{}", succeed(&["size", EXPERIMENT_95])));
}

#[test]
fn unsizable_scenes_are_rejected() {
    for (args, parts) in [
        (&["scenes/free-swing.toml"][..], &["has no object"][..]),
        (&["scenes/other-assembly.toml"], &["no object"]),
        (&["scenes/laws/spring.toml"], &["kind \"finger\""]),
        (&[EXPERIMENT_95, "--closing-time", "0 ms"], &["--closing-time", "more than 0"]),
        (&[EXPERIMENT_95, "--preload=-1 deg"], &["--preload", "more than 0"]),
        (&[EXPERIMENT_95, "--out", "Cargo.toml/x"], &["cannot create the directory"]),
    ] {
        assert_rejected(&[&["size"], args].concat(), parts);
    }
}

/// Writes results with two selected runs and one rejected run.
fn write_results(directory: &Path) -> String {
    let runs = [
        successful_run(1, 7e-3, [10.0, 30.0, 4.0]),
        successful_run(2, 5e-3, [5.0, 20.0, 6.0]),
        successful_run(3, 6e-3, [1.0, 2.0, 3.0]).with("form_closed", false),
    ];
    let path = directory.join("results.parquet");
    table::write(&path, &results_table(&runs)).expect("written");
    path_text(&path).to_string()
}

#[test]
fn selection_tables_json_and_files_agree() {
    let directory = directory("select-files");
    let file = write_results(&directory);
    let (out, best) = (directory.join("out"), directory.join("best.parquet"));
    let output = succeed(&["thesis", "select", &file, "--out", path_text(&out), "--ranking", path_text(&best)]);
    assert_contains(&output, &["2 of 3 runs meet all criteria"]);
    for name in ["criteria.svg", "classes.svg", "static.svg", "forces.svg", "variables.svg"] {
        assert!(fs::read_to_string(out.join(name)).expect(name).starts_with("<svg"), "{name}");
    }
    let document = succeed_json(&["thesis", "select", &file]);
    let mut saved: Value =
        serde_json::from_str(&fs::read_to_string(out.join("selection.json")).expect("readable")).expect("JSON");
    assert_eq!(saved.as_object_mut().expect("an object").remove("generator"), Some("phalanx".into()));
    assert_eq!(document, saved);
    assert_eq!((&document["selected"], &document["ranking"][0]["run"]), (&2.into(), &2.into()));
    // Scaled values of both runs: PFP 0 and 1; tts, F21 and F22 1 and 0.
    assert_eq!(document["ranking"][0]["r_wc"], 0.75);
    let ranking = table::read(&best).expect("the ranking");
    assert_eq!(ranking.integers("run").expect("runs"), [Some(2), Some(1)]);
    assert_eq!(table::read(&out.join("ranking.csv")).expect("the ranking").rows.len(), 2);
}

#[test]
fn empty_selection_is_status_1_and_bad_input_status_2() {
    let directory = directory("select-status");
    let file = write_results(&directory);
    let empty_selection = assert_status(&["thesis", "select", &file, "--min-pfp", "50 N"], 1, &[]);
    assert_contains(stdout(&empty_selection), &["\"PFP ≥ 50 N\" removed the last"]);
    let any = succeed_json(&["thesis", "select", &file, "--no-form-closed", "--min-pfp", "-1 N", "--best", "1"]);
    assert_eq!(any["selected"], 3);
    for (args, message) in [
        (vec!["thesis", "select", "none.csv"], "none.csv"),
        (vec!["thesis", "select", "Cargo.toml"], "Cargo.toml"),
        (vec!["thesis", "select", &file, "--class", "good"], "semi-stable"),
        (vec!["thesis", "select", &file, "--max-tts", "8"], "unit"),
        (vec!["thesis", "select", &file, "--max-tts", "0 s"], "more than 0"),
        (vec!["thesis", "select", &file, "--bound", "weight_kg <= 1"], "weight_kg"),
        (vec!["thesis", "select", &file, "--bound", "mass_kg<0.1"], "such as \"mass_kg <= 0.024\""),
        (vec!["thesis", "select", &file, "--bound", "a>=1<=2"], "such as \"mass_kg <= 0.024\""),
        (vec!["thesis", "select", &file, "--bound", "mass_kg <= nan"], "such as \"mass_kg <= 0.024\""),
        (vec!["thesis", "select", &file, "--weights", "pfp=0"], "all weights are 0"),
        (vec!["thesis", "select", &file, "--weights", "tts"], "such as pfp=2"),
        (vec!["thesis", "select", &file, "--weights", "tts=-1"], "the weight of tts is -1"),
        (vec!["thesis", "select", &file, "--weights", "tts=1,tts=2"], "tts is given twice"),
        (vec!["thesis", "select", &file, "--weights", "mass=1"], "no term `mass`"),
        (vec!["thesis", "select", &file, "--ranking", "best.txt"], ".parquet"),
    ] {
        assert_rejected(&args, &[message]);
    }
}

#[test]
fn stability_study_writes_its_files() {
    let out = directory("study_stability");
    let args = "thesis stability scenes/experiment-95.toml --stiffness 1 --damping 1 --steps";
    let args = [&args.split(' ').collect::<Vec<_>>()[..], &["100 us,1 ms"]].concat();
    let output = succeed(&[&args[..], &["--out", path_text(&out)]].concat());
    let read = |name: &str| fs::read_to_string(out.join(name)).expect(name);
    assert_eq!(read("table.txt"), format!("Report by phalanx\n\n{output}"));
    let document: Value = serde_json::from_str(&read("stability.json")).expect("JSON");
    assert_eq!(document["grid"]["steps_s"], serde_json::json!([1e-3, 1e-4]));
    assert_eq!(read("stability.csv").lines().count(), 3);
    assert!(read("stability.svg").starts_with("<svg"));
    // A stricter bound changes the verdict.
    let strict = succeed_json(&[&args[..], &["--accurate", "1e-6 rad"]].concat());
    assert_eq!(strict["cells"][1]["verdict"], "inaccurate");
    assert_eq!(document["cells"][1]["verdict"], "accurate");
}

#[test]
fn stability_study_rejects_unsuitable_scenes_and_grids() {
    let directory = directory("study_stability_refused");
    let rigid = variant(&directory, "rigid.toml", "[engine]\nlaw = \"rapier\"\nstepping = \"fixed\"\nstep = \"10 us\"");
    let anchor = fs::read_to_string(EXPERIMENT_95).expect("the reference scene");
    let undamped =
        anchor.replace("[contact.friction]", "[contact]\nstiffness_si = 0\nexponent = 2.2\n[contact.friction]");
    let undamped = write(&directory, "undamped.toml", &undamped);
    let cases: [(&[&str], &str); 13] = [
        (&["scenes/laws/step-size.toml"], "scene of a mechanism"),
        (&["scenes/gripper/design-95.toml"], "scene of a gripper"),
        (&["scenes/free-swing.toml"], "has no contacts"),
        (&[&rigid], "rapier's own contact"),
        (&[&undamped, "--damping", "0"], "one of them above 0"),
        (&[EXPERIMENT_95, "--steps", "1e-3"], "no unit"),
        (&[EXPERIMENT_95, "--steps", "20 ms"], "not shorter than the run"),
        (&[EXPERIMENT_95, "--steps", "1e-300 s"], "takes more than 10000000 steps; use longer steps"),
        (&[EXPERIMENT_95, "--stiffness", "0,1"], "above 0"),
        (&[EXPERIMENT_95, "--stiffness", "1e301"], "must be finite"),
        (&[EXPERIMENT_95, "--damping=-1"], "0 or more"),
        (&[EXPERIMENT_95, "--damping", "1,1"], "twice"),
        (&[EXPERIMENT_95, "--accurate", "0 rad"], "more than 0"),
    ];
    for (args, message) in cases {
        assert_rejected(&[&["thesis", "stability"], args].concat(), &[message]);
    }
}

/// A small volume that is computed quickly.
const SMALL: [&str; 8] =
    ["thesis", "volume", "--base", "15.5 mm, 19 mm", "--mu-static", "0,0.8", "--resolution", "4,3,5"];

fn run_small(more: &[&str]) -> String {
    succeed(&[&SMALL[..], more].concat())
}

#[test]
fn volume_tables_and_json_agree() {
    let text = run_small(&[]);
    let parts =
        ["4 x 3 x 5 points", "rule \"rigid\"", "intersection", "PFP", "form-closed", "120 designs sized and closed"];
    assert_contains(&text, &parts);
    let document = succeed_json(&SMALL);
    let volumes = document["volumes"].as_array().unwrap();
    assert_eq!((volumes.len(), document["intersections"].as_array().unwrap().len()), (4, 2));
    assert_eq!(document["axes"]["l21_fraction"]["points"], 4);
    for volume in volumes {
        assert_eq!((&volume["points"], &volume["fingers"]), (&60.into(), &60.into()));
        let stable = volume["stable_percent"].as_f64().unwrap();
        assert!(text.contains(&format!("{stable:.2}")), "{stable}");
        let largest_pfp_n = volume["largest_palm_force"]["static_pfp_n"].as_f64().unwrap();
        assert!(text.contains(&format!("{largest_pfp_n:.2}")), "{largest_pfp_n}");
    }
    assert!(document["wall_s"].as_f64().is_some() && document["threads"].as_u64().is_some());
}

#[test]
fn volume_files_contain_every_point_and_are_reproducible() {
    let out = directory("volume_files");
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let run = |format: &str, threads: &str| {
        let colours = "pfp,form-closed,mass";
        run_small(&["--out", path_text(&out), "--data", format, "--colour-by", colours, "--threads", threads]);
    };
    run("csv", "1");
    let mut names = ["table.txt", "table.json", "points.csv"].map(String::from).to_vec();
    for region in ["15.5mm", "19mm", "intersection"] {
        names.extend(["pfp", "form-closed", "mass"].map(|quantity| format!("slices-{region}-{quantity}.svg")));
    }
    let first: Vec<String> = names.iter().map(|name| read(name)).collect();
    assert!(names.iter().all(|name| first[0].contains(name)), "{}", first[0]);
    run("csv", "2");
    assert!(names.iter().zip(first).all(|(name, first)| read(name) == first), "a file differs");
    run("parquet", "2");
    let [csv, binary] = ["points.csv", "points.parquet"].map(|name| table::read(&out.join(name)).unwrap());
    assert_eq!((csv.rows.len(), csv.columns.len()), (240, binary.columns.len()));
    assert!(csv.rows.iter().flatten().zip(binary.rows.iter().flatten()).all(|(a, b)| a == b));
    // The shares are recomputed from the file.
    let document: Value = serde_json::from_str(&read("table.json")).unwrap();
    let column = |name: &str| csv.columns.iter().position(|column| column.name == name).unwrap();
    for volume in document["volumes"].as_array().unwrap() {
        let value = |name: &str| Cell::Number(volume[name].as_f64().unwrap());
        let (base, mu, stable) = (column("base_m"), column("mu_static"), column("force_positive"));
        let of_volume = |row: &&Vec<Cell>| row[base] == value("base_m") && row[mu] == value("mu_static");
        let stable = csv.rows.iter().filter(of_volume).filter(|row| row[stable] == Cell::Flag(true)).count();
        assert!((volume["stable_percent"].as_f64().unwrap() - 100.0 * stable as f64 / 60.0).abs() < 1e-12);
    }
    assert!(document.get("wall_s").is_none(), "files do not contain the computing time");

    let svg = read("slices-19mm-pfp.svg");
    assert_contains(&svg, &["<svg", "</svg>", "base 19 mm", "φ22 = 90°", "φ22 = 120°", "μ_s = 0.8", "%", "r_l"]);
    assert!(!svg.contains("NaN"));
}

#[test]
fn volume_scene_is_the_template() {
    let directory = directory("volume_scene");
    let scene = variant(&directory, "wide.toml", "[material]\ndensity = \"2140 kg/m^3\"");
    let heavy = succeed_json(&["thesis", "volume", &scene, "--resolution", "3"]);
    let [volume] = &heavy["volumes"].as_array().unwrap()[..] else { panic!("one base, one friction") };
    assert_eq!((&volume["base_m"], &volume["mu_static"]), (&0.0155.into(), &0.8.into()));
    assert_eq!(heavy["scene"], "experiment-95");
    let with_sizing =
        |sizing: &str| succeed_json(&["thesis", "volume", &scene, "--resolution", "3", "--sizing", sizing]);
    assert_eq!((&heavy["sizing"], &with_sizing("whole")["sizing"]), (&"rigid".into(), &"whole".into()));
    assert_ne!(with_sizing("whole")["volumes"], heavy["volumes"]);
}

#[test]
fn missing_designs_are_reported() {
    // A base without designs has shares of 0 and a warning. It is an error if no base has designs.
    let out = directory("volume_none");
    let args = ["thesis", "volume", "--base", "15.5 mm, 30 mm", "--mu-static", "0", "--resolution", "2", "--out"];
    let output = assert_status(
        &[&args[..], &[path_text(&out)]].concat(),
        0,
        &["warning: no design exists at a base of 30 mm: "],
    );
    assert_contains(stdout(&output), &["8 of 8 points have no finger", "must be below"]);
    let points = table::read(&out.join("points.csv")).unwrap();
    let reason = points.columns.iter().position(|column| column.name == "reason").unwrap();
    let missing = |row: &&Vec<Cell>| matches!(&row[reason], Cell::Text(reason) if reason.contains("30.0000 mm"));
    assert_eq!(points.rows.iter().filter(missing).count(), 8);
    let out = directory("volume_nothing").join("out");
    assert_rejected(
        &["thesis", "volume", "--base", "155mm", "--resolution", "3", "--out", path_text(&out)],
        &["error: no design exists at a base of 155 mm", "must be below", "give another --base"],
    );
    assert!(!out.join("points.csv").exists());
}

#[test]
fn volume_errors_say_what_to_do() {
    let directory = directory("volume_wrong");
    let lengths = write(
        &directory,
        "lengths.toml",
        "[lengths]\nl21 = \"24.4 mm\"\nl22 = \"7.5 mm\"\nt22 = \"12.9 mm\"\nphi22 = \"120 deg\"\n[motor]\ntorque = \"480 \
         N*mm\"\n[spring]\ntorque = \"120 N*mm\"\n[object]\ncentre = [\"-15.5 mm\", \"20 mm\"]\n",
    );
    let two_frictions = variant(&directory, "two.toml", "[contact.distal.friction]\nmu_static = 0.3");
    let file = write(&directory, "file", "");
    let path_in_file = Path::new(&file).join("below");
    for (args, parts) in [
        (&["--base", "12"][..], &["no unit", "such as"][..]),
        (&["--base", "0 mm"], &["more than 0", "such as"]),
        (&["--base", "12 mm", "--base", "12 mm"], &["twice"]),
        (&["--mu-static", "0.1,-1"], &["'-1'", "0,0.4,0.8"]),
        (&["--resolution", "0"], &["`0`", "1 or more"]),
        (&["--resolution", "300"], &["324000000 points", "lower the resolution"]),
        (&["--phi22", "120 deg, 90 deg"], &["greater than the second"]),
        (&["--l21", "0,2"], &["between 0 and 1"]),
        (&["--arm-ratio", "0.5"], &["1 value was"]),
        (&["--sizing", "soft"], &["rigid", "whole"]),
        (&["--colour-by", "colour", "--out", "x"], &["pfp", "form-closed"]),
        (&["--colour-by", "pfp"], &["--out"]),
        (&["--data", "parquet"], &["--out"]),
        (&["--threads=-1"], &["from 1"]),
        (&["no-such-scene.toml"], &["no such file"]),
        (&["scenes/laws/spring.toml"], &["\"finger\""]),
        (&[&lengths], &["replace [lengths] by [design]"]),
        (&[&two_frictions], &["0.8", "0.3", "--mu-static"]),
        (&["--resolution", "2", "--out", &file], &["that is a file"]),
        (&["--resolution", "2", "--out", path_text(&path_in_file)], &["cannot create the directory"]),
    ] {
        assert_rejected(&[&["thesis", "volume"], args].concat(), parts);
    }
}
