//! `scene show` prints the scene as written, with its defaults, and the result parses to the same scene bit for bit.

use std::fs;
use std::path::{Path, PathBuf};

use phalanx::scene::{Scene, load_any, parse_any, show, show_written};

/// Returns all scene files below a directory.
fn files(directory: &Path) -> Vec<PathBuf> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(directory).expect("scenes") {
        let path = entry.expect("entry").path();
        match path.is_dir() {
            true if !path.ends_with("studies") => paths.extend(files(&path)),
            false if path.extension().is_some_and(|extension| extension == "toml") => paths.push(path),
            _ => {}
        }
    }
    paths.sort();
    paths
}

/// Shows a scene and asserts that the result parses to the same scene.
fn show_and_check(scene: &Scene, label: &str) -> String {
    let text = show_written(scene);
    let mut back = parse_any(&text, "other-name.toml").unwrap_or_else(|error| panic!("{label}: {error}\n{text}"));
    back.source.clone_from(&scene.source);
    // `{:?}` of different `f64` values differs.
    assert_eq!(format!("{back:?}"), format!("{scene:?}"), "{label}");
    text
}

/// Returns the lines that are not empty and not comments.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')).collect()
}

#[test]
fn every_scene_is_shown_as_it_was_written() {
    let files = files(Path::new("scenes"));
    assert!(files.len() > 60, "{}", files.len());
    for file in files {
        let Ok(scene) = load_any(&file) else { panic!("{}", file.display()) };
        let label = file.display().to_string();
        let text = show_and_check(&scene, &label);
        let source = fs::read_to_string(&file).expect("the scene");
        let given_lines = lines(&source);
        for line in &given_lines {
            // Sections and values are shown as written; only trailing comments are removed.
            let line = line.split(" #").next().unwrap_or(line).trim();
            // The extended scene is included.
            let is_value = !line.contains('{') && !line.starts_with('"') && !line.ends_with('[');
            if let Some((key, value)) = line.split_once('=').filter(|_| is_value && !line.starts_with("extends")) {
                let (key, value) = (key.trim().rsplit('.').next().expect("a key"), value.trim());
                let is_shown = text.lines().any(|shown| shown == format!("{key} = {value}"));
                assert!(is_shown, "{label}: {line}\n{text}");
            }
        }
        assert!(lines(&text).len() > given_lines.len(), "{label}: defaults are filled in");
        for noise in ["e-16", "e-17", "e-18", "e-19", "e-20", "0000000", "9999999"] {
            let noisy_line = text
                .lines()
                .find(|line| line.contains(noise) && !source.contains(noise) && !line.contains("max_steps"));
            assert_eq!(noisy_line, None, "{label}");
        }
        // Showing the result again gives the same lines.
        let reparsed = parse_any(&text, "x.toml").expect("a scene");
        assert_eq!(lines(&show_written(&reparsed)), lines(&text), "{label}");
    }
}

#[test]
fn other_toml_notations_are_shown_as_written() {
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
        let back = show_and_check(&scene, text);
        let (placement, sizing, step) = ("placement = \"q22\"", "sizing = \"rigid\"", "step = \"1 us\"");
        for part in [placement, "mu_static = 0.5", sizing, "'15.5 mm'", "\"5 ms\"]", step] {
            assert!(back.contains(part) || !text.contains(part), "{part}\n{back}");
        }
    }
}

#[test]
fn derived_friction_is_shown_for_its_contact() {
    // The simulated scene is written with another common section than the file has.
    let finger = "[lengths]\nbase = \"15.3 mm\"\nl21 = \"24 mm\"\nl22 = \"7.5 mm\"\nt22 = \"13 mm\"\nphi22 = \"120 deg\"\n[motor]\ntorque = \"1 N*m\"\n\
        [spring]\ntype = \"none\"\n[contact.friction]\nmu_static = 0.8\n[contact.proximal.friction]\nmu_static = 0.5\n";
    let scene = parse_any(finger, "given.toml").unwrap_or_else(|error| panic!("{error}"));
    let text = show_and_check(&scene, "finger");
    for part in
        ["# [contact.proximal.friction]\n# mu_dynamic = 0.35", "# [contact.distal.friction]\n# mu_dynamic = 0.56"]
    {
        assert!(text.contains(part) && !text.contains("# [contact.friction]"), "{part}\n{text}");
    }
    let text = show_and_check(&load_any("scenes/gripper/different.toml").expect("a scene"), "gripper");
    assert!(text.contains("# [left.contact.friction]\n# mu_dynamic = 0.0"), "{text}");
    assert!(!text.contains("# [contact.friction]"), "{text}");
}

#[test]
fn a_modified_scene_is_shown_as_modified() {
    let mut scene = load_any("scenes/experiment-95.toml").expect("a scene");
    scene.duration_s = 0.5;
    assert_eq!(show_written(&scene), show(&scene));
    show_and_check(&scene, "changed");
}
