//! The scene in a log is the simulated scene, including changes made after it was read.

use std::io::Cursor;
use std::path::Path;

use phalanx::log::{RunInfo, Writer, read, scene_text};
use phalanx::mechanism::OutlineShape;
use phalanx::scene::{Preset, Profile, Scene, load, load_any, parse, parse_any};
use phalanx::trace::{Model, run};

fn anchor() -> Scene {
    load(Path::new("scenes/experiment-95.toml")).expect("a scene")
}

/// Scene text in the log of a run.
fn logged_scene_text(scene: &Scene) -> String {
    let info = RunInfo { scene, scene_file: "scene.toml", model: Model::Analytic.name() };
    let mut writer = Writer::new(Vec::new(), "the log", &info).expect("a log in memory");
    run(Model::Analytic, scene, &mut writer).expect("a completed run");
    let bytes = writer.finish().expect("finished");
    read(Cursor::new(&bytes), &mut ()).expect("a log").scene.expect("a scene").1
}

#[test]
fn unmodified_scene_is_logged_verbatim() {
    let scene = anchor();
    assert_eq!(logged_scene_text(&scene), scene.source);
    // These settings are in the metadata record.
    let mut settings = Scene { duration_s: 5e-3, ..scene.clone() };
    settings.apply_preset(Preset::Reference);
    assert_eq!(logged_scene_text(&settings), scene.source);
}

#[test]
fn modified_scene_is_logged_as_simulated() {
    let scene = anchor();
    let changes: [fn(&mut Scene); 4] = [
        |scene| scene.finger_mut().motor.actuation = Profile::Constant { value: 0.5 },
        |scene| scene.hand.gravity_m_s2 = [1.0, -2.0],
        |scene| scene.finger_mut().contact.distal.normal.exponent = 1.5,
        |scene| scene.source = String::new(),
    ];
    for change in changes {
        let mut changed = scene.clone();
        change(&mut changed);
        let text = logged_scene_text(&changed);
        assert_ne!(text, scene.source);
        let read = parse(&text, "scene.toml").expect("a scene");
        assert_eq!(Scene { source: changed.source.clone(), ..read }, changed);
    }
}

/// Scales the radius of the first moving disc.
fn change_radius(scene: &mut Scene, factor: f64) {
    let mechanism = scene.mechanism.as_mut().expect("discs");
    if let OutlineShape::Disc { radius_m, .. } = &mut mechanism.bodies[0].outlines[0].shape {
        *radius_m *= factor;
    }
}

#[test]
fn modified_discs_are_logged_as_simulated() {
    let scene = load_any(Path::new("scenes/laws/impact.toml")).expect("a scene");
    assert_eq!(scene_text(&scene), scene.source);
    let mut changed: Scene = scene.clone();
    change_radius(&mut changed, 1.25);
    let text = scene_text(&changed);
    let read = parse_any(&text, "scene.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(Scene { source: changed.source.clone(), ..read }, changed);
}
