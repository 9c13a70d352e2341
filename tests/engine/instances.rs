//! Fingers, grippers and discs as mechanisms: every shipped scene is built, assembled and simulated.

use std::fs;
use std::path::PathBuf;

use phalanx::mechanism::assemble;
use phalanx::scene::{Scene, load_any};
use phalanx::trace::{Model, run};

/// All shipped scenes of fingers, grippers and discs.
fn shipped_scenes() -> Vec<Scene> {
    let in_directory = |directory: &str| -> Vec<PathBuf> {
        let entries = fs::read_dir(directory).expect("a directory of scenes");
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
        paths.sort();
        paths
    };
    let paths = ["scenes", "scenes/gripper", "scenes/laws", "scenes/hard"].into_iter().flat_map(in_directory);
    let scenes = paths.map(|path| load_any(&path).unwrap_or_else(|error| panic!("{error}")));
    scenes.filter(|scene| scene.mechanism.is_none()).collect()
}

/// The poses and rates of the closed form satisfy all joints, and the engine model runs.
#[test]
fn every_shipped_scene_is_an_assembled_mechanism_that_runs() {
    let scenes = shipped_scenes();
    assert!(scenes.len() > 60, "{}", scenes.len());
    for mut scene in scenes {
        let mechanism = scene.mechanism().unwrap_or_else(|error| panic!("{}: {error}", scene.name));
        let start = assemble(&mechanism).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
        for (body, (pose, rate)) in mechanism.bodies.iter().zip(start.poses.iter().zip(&start.rates)) {
            assert_eq!(body.pose, *pose, "{}: {}", scene.name, body.name);
            for (closed, assembled) in body.rate.iter().zip(rate) {
                let error = (closed - assembled).abs();
                assert!(error <= 1e-11 * (1.0 + closed.abs()), "{}: {} {error:e}", scene.name, body.name);
            }
        }
        let contacts = mechanism.point_contacts().into_iter().map(|point| point.name);
        let contacts: Vec<String> =
            contacts.chain(mechanism.limits().iter().map(|limit| mechanism.limit_name(limit))).collect();
        let of_hand = scene.hand.contacts().map(|contact| contact.name_for(scene.finger_count()));
        assert_eq!(of_hand.collect::<Vec<_>>(), contacts, "{}", scene.name);
        drop(mechanism);
        scene.duration_s = 2e-4;
        let outcome = run(Model::Engine, &scene, &mut ()).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
        assert_eq!(outcome.last.time_s, scene.duration_s, "{}", scene.name);
        assert!(outcome.loop_gap_m <= scene.bounds.loop_gap_m, "{}: {:e}", scene.name, outcome.loop_gap_m);
    }
}

/// A left finger has the coordinates of the right one in the mirrored frame.
#[test]
fn coordinates_of_a_left_finger_are_those_of_its_mirror_image() {
    let scene = load_any("scenes/gripper/seesaw.toml").expect("a scene");
    let mechanism = scene.mechanism().expect("closed loops");
    let angle = |body: Option<usize>| body.map_or(0.0, |body| mechanism.bodies[body].pose[2]);
    let coordinate = |name: &str| {
        let joint = mechanism.joints.iter().find(|joint| joint.name == name).expect(name);
        angle(joint.bodies[1]) - angle(joint.bodies[0]) - joint.offset_rad
    };
    for joint in ["q11", "q12", "q21", "q22", "loop"] {
        let [right, left] = ["right", "left"].map(|side| coordinate(&format!("{side}_{joint}")));
        assert!((right - left).abs() < 1e-14, "{joint}: {right} {left}");
    }
    assert_eq!(mechanism.actuators.len(), 1, "the input of the differential");
}
