//! `phalanx volume`: output, files and errors.

use std::fs;
use std::path::Path;

use crate::support::cli::{directory, json, phalanx, stderr, stdout, variant, write};
use phalanx::table::{self, Value};

/// A small volume that is computed quickly.
const SMALL: [&str; 7] = ["volume", "--base", "15.5 mm, 19 mm", "--mu-static", "0,0.8", "--resolution", "4,3,5"];

fn run_small(more: &[&str]) -> std::process::Output {
    phalanx(&[&SMALL[..], more].concat())
}

#[test]
fn tables_and_json_agree() {
    let text = run_small(&[]);
    assert_eq!(text.status.code(), Some(0), "{}", stderr(&text));
    let text = stdout(&text);
    for part in
        ["4 x 3 x 5 points", "rule \"rigid\"", "intersection", "PFP", "form-closed", "120 designs sized and closed"]
    {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let document = json(&run_small(&["--json"]));
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
    let path_in = |name: &str| out.join(name);
    let run = |format: &str, threads: &str| {
        let path = out.to_str().unwrap();
        let output =
            run_small(&["--out", path, "--data", format, "--colour-by", "pfp,form-closed,mass", "--threads", threads]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    };
    run("csv", "1");
    let names = [
        "table.txt",
        "table.json",
        "points.csv",
        "page.html",
        "slices-15.5mm-pfp.svg",
        "slices-19mm-pfp.svg",
        "slices-intersection-pfp.svg",
        "slices-15.5mm-form-closed.svg",
        "slices-19mm-form-closed.svg",
        "slices-intersection-form-closed.svg",
        "slices-15.5mm-mass.svg",
        "slices-19mm-mass.svg",
        "slices-intersection-mass.svg",
    ];
    let first: Vec<Vec<u8>> = names.iter().map(|name| fs::read(path_in(name)).unwrap()).collect();
    let table_text = fs::read_to_string(path_in("table.txt")).unwrap();
    assert!(names.iter().all(|name| table_text.contains(name)), "{table_text}");
    run("csv", "2");
    for (name, first) in names.iter().zip(first) {
        assert!(fs::read(path_in(name)).unwrap() == first, "{name} differs");
    }
    run("parquet", "2");
    let [text, binary] = ["points.csv", "points.parquet"].map(|name| table::read(&path_in(name)).unwrap());
    assert_eq!(text.rows.len(), 240);
    let column = |name: &str| text.columns.iter().position(|column| column.name == name).unwrap();
    assert_eq!(text.columns.len(), binary.columns.len());
    for (a, b) in text.rows.iter().zip(&binary.rows) {
        assert!(a.iter().zip(b).all(|(a, b)| a == b), "{a:?}\n{b:?}");
    }
    // The shares are recomputed from the file.
    let document: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(path_in("table.json")).unwrap()).unwrap();
    for volume in document["volumes"].as_array().unwrap() {
        let is = |row: &Vec<Value>, name: &str, value: &serde_json::Value| matches!(row[column(name)], Value::Number(actual) if Some(actual) == value.as_f64());
        let in_table = text
            .rows
            .iter()
            .filter(|row| is(row, "base_m", &volume["base_m"]) && is(row, "mu_static", &volume["mu_static"]));
        let stable = in_table.filter(|row| row[column("force_positive")] == Value::Flag(true)).count();
        assert!((volume["stable_percent"].as_f64().unwrap() - 100.0 * stable as f64 / 60.0).abs() < 1e-12);
    }
    assert!(document.get("wall_s").is_none(), "files do not contain the computing time");
}

#[test]
fn pictures_are_complete_and_page_is_self_contained() {
    let out = directory("volume_page");
    let output = run_small(&["--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let svg = fs::read_to_string(out.join("slices-19mm-pfp.svg")).unwrap();
    for part in ["<svg", "</svg>", "base 19 mm", "φ22 = 90°", "φ22 = 120°", "μ_s = 0.8", "% ", "r_l"] {
        assert!(svg.contains(part.trim()), "{part}");
    }
    assert!(!svg.contains("NaN"));
    let page = fs::read_to_string(out.join("page.html")).unwrap();
    // The only URL in the page is the SVG namespace, which is not requested.
    let page_without_namespace = page.replace("http://www.w3.org/2000/svg", "");
    assert!(
        !page_without_namespace.contains("{{")
            && !page_without_namespace.contains("http://")
            && !page_without_namespace.contains("https://")
    );
    assert!(!page.contains(out.to_str().unwrap()), "the page does not contain local paths");
}

#[test]
fn scene_is_the_template() {
    let directory = directory("volume_scene");
    let scene = variant(&directory, "wide.toml", "[material]\ndensity = \"2140 kg/m^3\"");
    let heavy = json(&phalanx(&["volume", &scene, "--resolution", "3", "--json"]));
    let [volume] = &heavy["volumes"].as_array().unwrap()[..] else { panic!("one base, one friction") };
    assert_eq!((&volume["base_m"], &volume["mu_static"]), (&0.0155.into(), &0.8.into()));
    assert_eq!(heavy["scene"], "experiment-95");
    let with_sizing =
        |sizing: &str| json(&phalanx(&["volume", &scene, "--resolution", "3", "--sizing", sizing, "--json"]));
    assert_eq!((&heavy["sizing"], &with_sizing("whole")["sizing"]), (&"rigid".into(), &"whole".into()));
    assert_ne!(with_sizing("whole")["volumes"], heavy["volumes"]);
}

#[test]
fn missing_designs_are_reported() {
    let output = phalanx(&["volume", "--base", "22 mm", "--mu-static", "0", "--resolution", "4", "--l21", "0,1"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    // A base without designs has shares of 0 and a warning. It is an error if no base has designs.
    let one_base_without_designs = ["volume", "--base", "15.5 mm, 30 mm", "--mu-static", "0", "--resolution", "2"];
    let output = phalanx(&one_base_without_designs);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    assert!(text.contains("8 of 8 points have no finger") && text.contains("must be below"), "{text}");
    let warning = stderr(&output);
    assert!(
        warning.starts_with("warning: no design exists at a base of 30 mm: ") && warning.contains("below"),
        "{warning}"
    );
    let out = directory("volume_none");
    let path = out.to_str().unwrap();
    assert_eq!(phalanx(&[&one_base_without_designs[..], &["--out", path]].concat()).status.code(), Some(0));
    let points = table::read(&out.join("points.csv")).unwrap();
    let reason = points.columns.iter().position(|column| column.name == "reason").unwrap();
    let missing =
        points.rows.iter().filter(|row| matches!(&row[reason], Value::Text(text) if text.contains("30.0000 mm")));
    assert_eq!(missing.count(), 8);
    let out = directory("volume_nothing").join("out");
    let output = phalanx(&["volume", "--base", "155mm", "--resolution", "3", "--out", out.to_str().unwrap()]);
    assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""));
    let message = stderr(&output);
    for part in ["error: no design exists at a base of 155 mm", "must be below", "give another --base"] {
        assert!(message.contains(part), "{part}: {message}");
    }
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
        (&["--resolution", "2", "--out", path_in_file.to_str().unwrap()], &["cannot create the directory"]),
    ] {
        let output = phalanx(&[&["volume"], args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
        for part in parts {
            assert!(stderr(&output).contains(part), "{args:?}: {}", stderr(&output));
        }
        assert_eq!(stdout(&output), "");
    }
}
