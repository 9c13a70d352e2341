//! `phalanx volume`: output, files and errors.

use std::fs;
use std::path::Path;

use crate::support::cli::{
    assert_contains, assert_rejected, assert_status, directory, path_text, stdout, succeed, succeed_json, variant,
    write,
};
use phalanx::table::{self, Value};

/// A small volume that is computed quickly.
const SMALL: [&str; 7] = ["volume", "--base", "15.5 mm, 19 mm", "--mu-static", "0,0.8", "--resolution", "4,3,5"];

fn run_small(more: &[&str]) -> String {
    succeed(&[&SMALL[..], more].concat())
}

#[test]
fn tables_and_json_agree() {
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
fn files_contain_every_point_and_are_reproducible() {
    let out = directory("volume_files");
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let run = |format: &str, threads: &str| {
        let colours = "pfp,form-closed,mass";
        run_small(&["--out", path_text(&out), "--data", format, "--colour-by", colours, "--threads", threads]);
    };
    run("csv", "1");
    let mut names = ["table.txt", "table.json", "points.csv", "page.html"].map(String::from).to_vec();
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
    let document: serde_json::Value = serde_json::from_str(&read("table.json")).unwrap();
    let column = |name: &str| csv.columns.iter().position(|column| column.name == name).unwrap();
    for volume in document["volumes"].as_array().unwrap() {
        let value = |name: &str| Value::Number(volume[name].as_f64().unwrap());
        let (base, mu, stable) = (column("base_m"), column("mu_static"), column("force_positive"));
        let of_volume = |row: &&Vec<Value>| row[base] == value("base_m") && row[mu] == value("mu_static");
        let stable = csv.rows.iter().filter(of_volume).filter(|row| row[stable] == Value::Flag(true)).count();
        assert!((volume["stable_percent"].as_f64().unwrap() - 100.0 * stable as f64 / 60.0).abs() < 1e-12);
    }
    assert!(document.get("wall_s").is_none(), "files do not contain the computing time");

    let svg = read("slices-19mm-pfp.svg");
    assert_contains(&svg, &["<svg", "</svg>", "base 19 mm", "φ22 = 90°", "φ22 = 120°", "μ_s = 0.8", "%", "r_l"]);
    assert!(!svg.contains("NaN"));
    // The only URL in the page is the SVG namespace, which is not requested.
    let page = read("page.html").replace("http://www.w3.org/2000/svg", "");
    assert!(["{{", "http://", "https://", path_text(&out)].iter().all(|part| !page.contains(part)));
}

#[test]
fn scene_is_the_template() {
    let directory = directory("volume_scene");
    let scene = variant(&directory, "wide.toml", "[material]\ndensity = \"2140 kg/m^3\"");
    let heavy = succeed_json(&["volume", &scene, "--resolution", "3"]);
    let [volume] = &heavy["volumes"].as_array().unwrap()[..] else { panic!("one base, one friction") };
    assert_eq!((&volume["base_m"], &volume["mu_static"]), (&0.0155.into(), &0.8.into()));
    assert_eq!(heavy["scene"], "experiment-95");
    let with_sizing = |sizing: &str| succeed_json(&["volume", &scene, "--resolution", "3", "--sizing", sizing]);
    assert_eq!((&heavy["sizing"], &with_sizing("whole")["sizing"]), (&"rigid".into(), &"whole".into()));
    assert_ne!(with_sizing("whole")["volumes"], heavy["volumes"]);
}

#[test]
fn missing_designs_are_reported() {
    // A base without designs has shares of 0 and a warning. It is an error if no base has designs.
    let out = directory("volume_none");
    let args = ["volume", "--base", "15.5 mm, 30 mm", "--mu-static", "0", "--resolution", "2", "--out"];
    let output = assert_status(
        &[&args[..], &[path_text(&out)]].concat(),
        0,
        &["warning: no design exists at a base of 30 mm: "],
    );
    assert_contains(stdout(&output), &["8 of 8 points have no finger", "must be below"]);
    let points = table::read(&out.join("points.csv")).unwrap();
    let reason = points.columns.iter().position(|column| column.name == "reason").unwrap();
    let missing = |row: &&Vec<Value>| matches!(&row[reason], Value::Text(reason) if reason.contains("30.0000 mm"));
    assert_eq!(points.rows.iter().filter(missing).count(), 8);
    let out = directory("volume_nothing").join("out");
    assert_rejected(
        &["volume", "--base", "155mm", "--resolution", "3", "--out", path_text(&out)],
        &["error: no design exists at a base of 155 mm", "must be below", "give another --base"],
    );
    assert!(!out.join("points.csv").exists());
}

#[test]
fn errors_say_what_to_do() {
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
        (&["--mu-static", "0.1,-1"], &["`-1`", "0,0.4,0.8"]),
        (&["--resolution", "0"], &["`0`", "1 or more"]),
        (&["--resolution", "300"], &["324000000 points", "lower the resolution"]),
        (&["--phi22", "120 deg, 90 deg"], &["greater than the second"]),
        (&["--l21", "0,2"], &["between 0 and 1"]),
        (&["--arm-ratio", "0.5"], &["1 value was"]),
        (&["--sizing", "soft"], &["rigid", "whole"]),
        (&["--colour-by", "colour", "--out", "x"], &["pfp", "form-closed"]),
        (&["--colour-by", "pfp"], &["--out"]),
        (&["--data", "parquet"], &["--out"]),
        (&["--threads", "0"], &["from 1"]),
        (&["no-such-scene.toml"], &["no such file"]),
        (&["scenes/laws/spring.toml"], &["\"finger\""]),
        (&[&lengths], &["replace [lengths] by [design]"]),
        (&[&two_frictions], &["0.8", "0.3", "--mu-static"]),
        (&["--resolution", "2", "--out", &file], &["that is a file"]),
        (&["--resolution", "2", "--out", path_text(&path_in_file)], &["cannot create the directory"]),
    ] {
        assert_rejected(&[&["volume"], args].concat(), parts);
    }
}
