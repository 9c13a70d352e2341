//! Labelled drawing of a linkage: every label is drawn, and labels do not overlap.

use std::fs;

use crate::support::cli::{EXPERIMENT_95, assert_rejected, directory, succeed_silently, write};
use phalanx::plot::{Linkage, linkage};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{self, Scene};

const COMMON_LABELS: [&str; 11] = ["l11", "l12", "l21", "l22", "t22", "w", "q11", "q21", "q12", "q22", "φ22"];

fn scenes(directory: &str) -> Vec<Scene> {
    let entries = fs::read_dir(directory).expect("scenes");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    let load = |path| scene::load_any(path).ok().filter(|scene| scene.kind() == SceneKind::Finger);
    paths.into_iter().filter_map(load).collect()
}

/// Labels that overlap or are outside the drawing.
fn label_conflicts(drawn: &Linkage) -> Vec<String> {
    let mut conflicts = Vec::new();
    for (index, (label, bounds)) in drawn.labels.iter().enumerate() {
        if !bounds.is_within(drawn.size) {
            conflicts.push(format!("{label} is outside"));
        }
        for (other, other_bounds) in &drawn.labels[index + 1..] {
            if bounds.overlaps(other_bounds, 0.0) {
                conflicts.push(format!("{label} overlaps {other}"));
            }
        }
    }
    conflicts
}

#[test]
fn every_label_is_drawn_without_overlap() {
    let all = [scenes("scenes"), scenes("scenes/hard")].concat();
    assert!(all.len() > 40, "{}", all.len());
    for scene in all {
        let drawn = linkage(&scene);
        let labels: Vec<&str> = drawn.labels.iter().map(|drawn| drawn.0).collect();
        let with_object: &[&str] = if scene.object().is_some() { &["base", "radius"] } else { &[] };
        for label in COMMON_LABELS.iter().chain(with_object) {
            assert_eq!(labels.iter().filter(|other| *other == label).count(), 1, "{}: {label}", scene.name);
            // Once in the drawing and once in the table below it.
            assert_eq!(drawn.svg.matches(&format!(">{label}</text>")).count(), 2, "{}: {label}", scene.name);
        }
        assert_eq!(label_conflicts(&drawn), [""; 0], "{}", scene.name);
        assert!(!drawn.svg.contains("NaN") && !drawn.svg.contains("inf"), "{}", scene.name);
    }
    let drawing = linkage(&scene::load(EXPERIMENT_95).expect("experiment-95"));
    for force in ["F21", "F22"] {
        assert!(drawing.labels.iter().any(|drawn| drawn.0 == force), "{force}");
    }
    for value in ["15 mm", "22.36 mm", "24.43 mm", "12.86 mm", "120°", "2.5 mm", "15.5 mm", "2.08", "65"] {
        assert!(drawing.svg.contains(&format!(">{value}")), "{value}");
    }
}

#[test]
fn labels_of_random_designs_do_not_overlap() {
    let base = fs::read_to_string(EXPERIMENT_95).expect("experiment-95");
    let mut drawn_count = 0;
    for index in 0..96 {
        let base_mm = [12.0, 16.0, 20.0, 24.0][index % 4];
        let (phi22, arm) = ([80, 100, 120, 140][index / 4 % 4], [0.3, 0.6, 0.9][index / 16 % 3]);
        let text = base
            .replace("15.5 mm", &format!("{base_mm} mm"))
            .replace("120 deg", &format!("{phi22} deg"))
            .replace("arm_ratio = 0.5", &format!("arm_ratio = {arm}"))
            .replace("l21_fraction = 1.0", &format!("l21_fraction = {}", [0.2, 0.8][index / 48]));
        let Ok(scene) = scene::parse(&text, "random.toml") else { continue };
        drawn_count += 1;
        assert_eq!(label_conflicts(&linkage(&scene)), [""; 0], "{text}");
    }
    assert!(drawn_count > 40, "{drawn_count}");
}

#[test]
fn readme_picture_matches_command_output() {
    let directory = directory("linkage");
    let figure = directory.join("linkage.svg").display().to_string();
    let output = succeed_silently(&["scene", "show", EXPERIMENT_95, "--figure", &figure]);
    assert_eq!(output, format!("wrote {figure}: the linkage of experiment-95 with its symbols\n"));
    let readme_picture = fs::read_to_string("tools/figures/linkage.svg").expect("the picture of the README");
    let drawn = fs::read_to_string(&figure).expect("the figure");
    assert_eq!(drawn, readme_picture, "run tools/readme_figures.py scenes to redraw it");
}

#[test]
fn figure_errors_leave_files_unchanged() {
    let directory = directory("linkage_refused");
    let text = fs::read_to_string(EXPERIMENT_95).expect("experiment-95");
    let scene = write(&directory, "scene.toml", &text);
    let missing_directory = directory.join("nowhere/figure.svg").display().to_string();
    for (scene, figure, part) in [
        (scene.as_str(), scene.as_str(), "the scene itself"),
        (scene.as_str(), missing_directory.as_str(), "does not exist; create it first (mkdir -p"),
        ("scenes/laws/impact.toml", "figure.svg", "a scene of discs"),
    ] {
        assert_rejected(&["scene", "show", scene, "--figure", figure], &[part]);
    }
    assert_eq!(fs::read_to_string(&scene).expect("the scene"), text);
}
