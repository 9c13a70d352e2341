//! The labelled drawing of a linkage: every letter is there, and none lies over another.

use std::fs;

use crate::support::cli::{ANCHOR, directory, phalanx, stderr, stdout, write};
use phalanx::plot::{Linkage, linkage};
use phalanx::scene::words::SceneKind;
use phalanx::scene::{self, Scene};

const ALWAYS: [&str; 11] = ["l11", "l12", "l21", "l22", "t22", "w", "q11", "q21", "q12", "q22", "φ22"];

fn scenes(directory: &str) -> Vec<Scene> {
    let entries = fs::read_dir(directory).expect("scenes");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    let load = |path| scene::load_any(path).ok().filter(|scene| scene.kind() == SceneKind::Finger);
    paths.into_iter().filter_map(load).collect()
}

/// Letters that lie over each other or outside of the drawing.
fn faults(drawn: &Linkage) -> Vec<String> {
    let mut found = Vec::new();
    for (index, (letter, spot)) in drawn.labels.iter().enumerate() {
        if !spot.within(drawn.size) {
            found.push(format!("{letter} is outside"));
        }
        for (other, there) in &drawn.labels[index + 1..] {
            if spot.overlaps(there, 0.0) {
                found.push(format!("{letter} lies over {other}"));
            }
        }
    }
    found
}

#[test]
fn every_letter_is_on_the_drawing_and_none_over_another() {
    let all = [scenes("scenes"), scenes("scenes/hard")].concat();
    assert!(all.len() > 40, "{}", all.len());
    for scene in all {
        let drawn = linkage(&scene);
        let letters: Vec<&str> = drawn.labels.iter().map(|label| label.0).collect();
        let with_object: &[&str] = if scene.object().is_some() { &["base", "radius"] } else { &[] };
        for letter in ALWAYS.iter().chain(with_object) {
            assert_eq!(letters.iter().filter(|other| *other == letter).count(), 1, "{}: {letter}", scene.name);
            // Once in the drawing, once in the table below.
            assert_eq!(drawn.svg.matches(&format!(">{letter}</text>")).count(), 2, "{}: {letter}", scene.name);
        }
        assert_eq!(faults(&drawn), [""; 0], "{}", scene.name);
        assert!(!drawn.svg.contains("NaN") && !drawn.svg.contains("inf"), "{}", scene.name);
    }
    let anchor = linkage(&scene::load(ANCHOR).expect("the anchor"));
    for force in ["F21", "F22"] {
        assert!(anchor.labels.iter().any(|label| label.0 == force), "{force}");
    }
    for value in ["15 mm", "22.36 mm", "24.43 mm", "12.86 mm", "120°", "2.5 mm", "15.5 mm", "2.08", "65"] {
        assert!(anchor.svg.contains(&format!(">{value}")), "{value}");
    }
}

#[test]
fn random_designs_have_room_for_their_letters() {
    let base = fs::read_to_string(ANCHOR).expect("the anchor");
    let mut drawn = 0;
    for base_mm in [12.0, 16.0, 20.0, 24.0] {
        for phi22 in [80, 100, 120, 140] {
            for arm in [0.3, 0.6, 0.9] {
                for fraction in [0.2, 0.8] {
                    let text = base
                        .replace("15.5 mm", &format!("{base_mm} mm"))
                        .replace("120 deg", &format!("{phi22} deg"))
                        .replace("arm_ratio = 0.5", &format!("arm_ratio = {arm}"))
                        .replace("l21_fraction = 1.0", &format!("l21_fraction = {fraction}"));
                    let Ok(scene) = scene::parse(&text, "random.toml") else { continue };
                    drawn += 1;
                    assert_eq!(faults(&linkage(&scene)), [""; 0], "{text}");
                }
            }
        }
    }
    assert!(drawn > 40, "{drawn}");
}

#[test]
fn the_picture_of_the_readme_is_what_the_command_draws() {
    let directory = directory("linkage");
    let figure = directory.join("linkage.svg").display().to_string();
    let output = phalanx(&["scene", "show", ANCHOR, "--figure", &figure]);
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
    assert_eq!(stdout(&output), format!("wrote {figure}: the linkage of experiment-95 with its letters\n"));
    let kept = fs::read_to_string("tools/figures/linkage.svg").expect("the picture of the README");
    assert_eq!(fs::read_to_string(&figure).expect("the figure"), kept, "tools/readme_figures.py scenes draws it anew");
}

#[test]
fn what_cannot_be_drawn_is_said_and_costs_nothing() {
    let directory = directory("linkage_refused");
    let text = fs::read_to_string(ANCHOR).expect("the anchor");
    let scene = write(&directory, "scene.toml", &text);
    let nowhere = directory.join("nowhere/figure.svg").display().to_string();
    for (scene, figure, part) in [
        (scene.as_str(), scene.as_str(), "the scene itself"),
        (scene.as_str(), nowhere.as_str(), "does not exist; create it first (mkdir -p"),
        ("scenes/laws/impact.toml", "figure.svg", "a scene of discs"),
    ] {
        let output = phalanx(&["scene", "show", scene, "--figure", figure]);
        assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""), "{figure}");
        assert!(stderr(&output).starts_with("error: ") && stderr(&output).contains(part), "{}", stderr(&output));
    }
    assert_eq!(fs::read_to_string(&scene).expect("the scene"), text);
}

#[test]
fn a_hostile_name_stays_a_name() {
    let text = fs::read_to_string(ANCHOR).expect("the anchor");
    let name = "</title><script>alert(1)</script>\\u001b[31m";
    let scene = scene::parse(&text.replace("experiment-95\"\n", &format!("{name}\"\n")), "x.toml").expect("a scene");
    let svg = linkage(&scene).svg;
    assert!(!svg.contains("<script") && svg.contains("&lt;script&gt;"));
    assert!(!svg.contains('\u{1b}'));
}
