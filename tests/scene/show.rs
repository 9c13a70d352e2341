//! `scene show` gives back what was written, with defaults beside it, and the same scene bit for bit.

use std::fs;
use std::path::{Path, PathBuf};

use phalanx::scene::{Scene, load_any, parse_any, show, show_written};

/// All scene files below a directory.
fn files(directory: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(directory).expect("scenes") {
        let path = entry.expect("entry").path();
        match path.is_dir() {
            true if !path.ends_with("studies") => found.extend(files(&path)),
            false if path.extension().is_some_and(|extension| extension == "toml") => found.push(path),
            _ => {}
        }
    }
    found.sort();
    found
}

fn without_source(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.source.clear();
    scene
}

/// Shows a scene, and checks that what is shown is the scene.
fn shown(scene: &Scene, what: &str) -> String {
    let text = show_written(scene);
    let back = parse_any(&text, "other-name.toml").unwrap_or_else(|error| panic!("{what}: {error}\n{text}"));
    // `{:?}` of an f64 tells any two bits apart.
    assert_eq!(format!("{:?}", without_source(&back)), format!("{:?}", without_source(scene)), "{what}");
    text
}

/// Lines that are no comments.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')).collect()
}

#[test]
fn every_scene_comes_back_as_it_was_written() {
    let files = files(Path::new("scenes"));
    assert!(files.len() > 60, "{}", files.len());
    for file in files {
        let Ok(scene) = load_any(&file) else { panic!("{}", file.display()) };
        let what = file.display().to_string();
        let text = shown(&scene, &what);
        let source = fs::read_to_string(&file).expect("the scene");
        let given = lines(&source);
        for line in &given {
            // Sections stay sections, values stay to the letter; only comments behind them go.
            let line = line.split(" #").next().unwrap_or(line).trim();
            // What it extends is in it.
            if line.starts_with("extends") {
                continue;
            }
            if line.contains('=') && !line.contains('{') && !line.starts_with('"') && !line.ends_with('[') {
                let (key, value) = line.split_once('=').expect("a key");
                let (key, value) = (key.trim().rsplit('.').next().expect("a key"), value.trim());
                let kept = text.lines().any(|shown| shown == format!("{key} = {value}"));
                assert!(kept, "{what}: {line}\n{text}");
            }
        }
        assert!(lines(&text).len() > given.len(), "{what}: defaults are filled in");
        for noise in ["e-16", "e-17", "e-18", "e-19", "e-20", "0000000", "9999999"] {
            let found = text
                .lines()
                .find(|line| line.contains(noise) && !source.contains(noise) && !line.contains("max_steps"));
            assert_eq!(found, None, "{what}");
        }
        // What is shown is a scene of its own, and shows as itself.
        let again = parse_any(&text, "x.toml").expect("a scene");
        assert_eq!(lines(&show_written(&again)), lines(&text), "{what}");
    }
}

#[test]
fn what_is_written_in_other_ways_comes_back_too() {
    for text in [
        "name = \"dotted\"\ndesign.base = \"15.5 mm\"\ndesign.l21_fraction = 1\ndesign.phi22 = \"120 deg\"\ndesign.arm_ratio = 0.5\n\
         motor.torque = \"480 N*mm\"\nspring = { torque = \"132.6 N*mm\", placement = \"q22\" }\n\
         contact.proximal.friction.mu_static = 0.5 # only here\n",
        "# Sized by itself\nsizing = \"rigid\"\n\n[design]\nbase = '15.5 mm'\nl21 = \"24 mm\"\nphi22 = \"120 deg\"\narm_ratio = 0.5\n",
        "\u{feff}[lengths]\r\nl21 = \"24 mm\"\r\nl22 = \"7.5 mm\"\r\nt22 = \"13 mm\"\r\nphi22 = \"120 deg\"\r\n[object]\r\npresent = false\r\n\
         [initial]\r\nq11 = \"-40 deg\"\r\nq21 = \"50 deg\"\r\n[motor]\r\nprofile = \"table\"\r\ntimes = [\"0 ms\",\r\n  \"5 ms\"]\r\n\
         torques = [\"0 N*m\", \"1 N*m\"]\r\n[spring]\r\ntype = \"none\"\r\n[limit]\r\nenabled = false\r\n[engine]\r\nstepping = \"fixed\"\r\nstep = \"1 us\"\r\n",
    ] {
        let scene = parse_any(text, "given.toml").unwrap_or_else(|error| panic!("{error}"));
        let back = shown(&scene, text);
        for part in [
            "placement = \"q22\"",
            "mu_static = 0.5",
            "sizing = \"rigid\"",
            "'15.5 mm'",
            "\"5 ms\"]",
            "step = \"1 us\"",
        ] {
            assert!(back.contains(part) || !text.contains(part), "{part}\n{back}");
        }
    }
}

#[test]
fn a_scene_that_was_changed_is_shown_as_it_is() {
    let mut scene = load_any("scenes/experiment-95.toml").expect("a scene");
    scene.duration_s = 0.5;
    assert_eq!(show_written(&scene), show(&scene));
    shown(&scene, "changed");
}
