//! Drawn shapes and poses of a scene agree with the models; labels of the drawing of a linkage do not overlap.

use std::fs;

use crate::support::cli::{EXPERIMENT_95, assert_rejected, directory, succeed_silently, write};
use phalanx::drawing::{BodyRole, Drawing, FramePose, Shape};
use phalanx::gripper::{Posture, joint_positions};
use phalanx::plot::{Linkage, linkage};
use phalanx::scene::{self, Scene};
use phalanx::shape::max_radius;
use phalanx::trace::{FingerContact, FingerState, Model};
use phalanx::validate::record;

fn load(name: &str) -> Scene {
    scene::load(format!("scenes/{name}.toml")).unwrap()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Distance of a point from the surface of a shape at a pose.
fn distance_from_surface(shape: &Shape, pose: &FramePose, point: [f64; 2]) -> f64 {
    match shape {
        Shape::Capsule { from_m, to_m, radius_m } => {
            let (a, b) = (pose.apply(*from_m), pose.apply(*to_m));
            let (edge, to) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
            let t = ((to[0] * edge[0] + to[1] * edge[1]) / (edge[0].powi(2) + edge[1].powi(2))).clamp(0.0, 1.0);
            (distance(point, [a[0] + t * edge[0], a[1] + t * edge[1]]) - radius_m).abs()
        }
        Shape::Disc { radius_m } => (distance(point, pose.position_m) - radius_m).abs(),
        _ => f64::INFINITY,
    }
}

#[test]
fn joints_and_contact_points_match_the_drawn_bodies() {
    let scene = load("experiment-95");
    let drawing = Drawing::from_scene(&scene);
    let names: Vec<&str> = drawing.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["object", "palm", "ground", "l11", "l12", "l21", "l22"]);
    assert_eq!(drawing.contacts, ["proximal", "distal"]);
    let lengths = scene.finger().linkage.lengths;
    let recording = record(Model::Analytic, &scene).unwrap();
    for sample in &recording.samples {
        let poses = drawing.poses(sample);
        assert_eq!(poses.len(), drawing.bodies.len());
        let FingerState { q11_rad, q21_rad, q12_rad, q22_rad, .. } = sample.finger(0);
        let joints = joint_positions(&lengths, &Posture { q11_rad, q21_rad, q12_rad, q22_rad });
        let [coupler, distal] = [poses[4], poses[6]];
        assert!(distance(coupler.position_m, joints.a12_m) < 1e-12);
        assert!(distance(distal.position_m, joints.a22_m) < 1e-12);
        // The loop is closed: the ends of the coupler and of the arm are one point.
        assert!(distance(coupler.apply([lengths.l12_m, 0.0]), distal.apply([lengths.l22_m, 0.0])) < 1e-9);
        for (body, contact) in
            [(5, sample.finger_contact(FingerContact::Proximal)), (6, sample.finger_contact(FingerContact::Distal))]
        {
            let capsule = drawing.bodies[body].shapes.last().unwrap();
            let distance_m = distance_from_surface(capsule, &poses[body], contact.point_m);
            assert!(distance_m < 1e-12, "{body} at {} s: {distance_m} m from the surface", sample.time_s);
        }
    }
}

#[test]
fn view_contains_start_grasp_and_object() {
    let scene = load("experiment-95");
    let drawing = Drawing::from_scene(&scene);
    let [low, high] = drawing.extent_m;
    let recording = record(Model::Analytic, &scene).unwrap();
    let object = scene.object().unwrap();
    for k in 0..2 {
        let radius_m = max_radius(&object.shape);
        assert!(low[k] < object.centre_m[k] - radius_m && object.centre_m[k] + radius_m < high[k]);
    }
    for sample in [recording.samples.first().unwrap(), recording.samples.last().unwrap()] {
        for (body, pose) in drawing.bodies.iter().zip(drawing.poses(sample)) {
            let corners = body.shapes.iter().filter_map(|shape| match shape {
                Shape::Polygon { corners_m } => Some(corners_m),
                _ => None,
            });
            for corner in corners.flatten().map(|corner| pose.apply(*corner)) {
                assert!((0..2).all(|k| low[k] <= corner[k] && corner[k] <= high[k]), "{} {corner:?}", body.name);
            }
        }
    }
}

#[test]
fn arrows_are_bounded_and_keep_their_sign() {
    let drawing = Drawing::from_scene(&load("experiment-95"));
    assert!((drawing.arrow_m(0.48 / 0.015) - 0.1 * drawing.view_m() / 1.2).abs() < 1e-12, "the arrow of a usual force");
    assert_eq!(drawing.arrow_m(1e6), drawing.longest_arrow_m);
    assert_eq!(drawing.arrow_m(-1e6), -drawing.longest_arrow_m);
}

#[test]
fn scene_without_object_draws_only_the_finger() {
    let scene = load("free-swing");
    let drawing = Drawing::from_scene(&scene);
    assert!(drawing.contacts.is_empty());
    assert!(drawing.bodies.iter().all(|body| body.role != BodyRole::Object));
    assert!(drawing.extent_m.iter().flatten().all(|value| value.is_finite()));
}

#[test]
fn disc_poses_match_samples() {
    let scene = scene::load_any("scenes/laws/two-free.toml").unwrap();
    let drawing = Drawing::from_scene(&scene);
    let recording = record(Model::Analytic, &scene).unwrap();
    let mechanism = scene.mechanism.as_ref().expect("discs");
    // The ground is first.
    assert_eq!(drawing.bodies.len(), 1 + mechanism.bodies.len());
    for sample in &recording.samples {
        let poses = drawing.poses(sample);
        for (pose, body) in poses.iter().skip(1).zip(sample.bodies()) {
            assert_eq!((pose.position_m, pose.angle_rad), (body.centre_m, body.angle_rad));
        }
        let index = 1 + mechanism.contacts[0].points.body.expect("a moving disc");
        let point_m = sample.contact(0).point_m;
        let distance_m = distance_from_surface(&drawing.bodies[index].shapes[0], &poses[index], point_m);
        assert!(distance_m < 1e-12, "{distance_m}");
    }
    assert!(drawing.arrow_m_per_n > 0.0 && drawing.arrow_m_per_n.is_finite());
}

#[test]
fn readme_pictures_support_dark_mode() {
    let pictures = fs::read_dir("tools/figures").expect("pictures").map(|entry| entry.expect("a file").path());
    let mut count = 0;
    for path in pictures.filter(|path| path.extension().is_some_and(|suffix| suffix == "svg")) {
        let svg = fs::read_to_string(&path).expect("a picture");
        let compact: String = svg.split_whitespace().collect();
        assert!(compact.contains("@media(prefers-color-scheme:dark){"), "{}", path.display());
        // White fills are replaced in dark mode, by a variable or by a rule.
        let expected_styles = ["[fill=\"#FFFFFF\"]{fill:var(--panel,#FFFFFF)", "--panel:#1b1f26"];
        let dark = [&expected_styles[..], &["[style*=\"fill:#ffffff\"]{fill:#1b1f26"], &[".ground{fill:#1b1f26"]];
        let contains_all = |rules: &&[&str]| rules.iter().all(|rule| compact.contains(rule));
        assert!(dark.iter().any(contains_all), "{}", path.display());
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        roxmltree::Document::parse_with_options(&svg, options).expect("well-formed");
        count += 1;
    }
    assert!(count >= 8, "{count} pictures");
}

const COMMON_LABELS: [&str; 11] = ["l11", "l12", "l21", "l22", "t22", "w", "q11", "q21", "q12", "q22", "φ22"];

fn scenes(directory: &str) -> Vec<Scene> {
    let entries = fs::read_dir(directory).expect("scenes");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    let load = |path| scene::load_any(path).ok().filter(|scene| scene.finger_count() == 1);
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
    let output = succeed_silently(&["scene", "show", EXPERIMENT_95, "--plot", &figure]);
    assert_eq!(output, format!("wrote {figure}: the linkage of experiment-95 with its symbols\n"));
    let readme_picture = fs::read_to_string("tools/figures/linkage.svg").expect("the picture of the README");
    let drawn = fs::read_to_string(&figure).expect("the figure");
    assert_eq!(drawn, readme_picture, "run tools/readme_figures.py scenes to redraw it");
    #[cfg(feature = "png")]
    {
        let figure = directory.join("linkage.png").display().to_string();
        succeed_silently(&["scene", "show", EXPERIMENT_95, "--plot", &figure]);
        assert!(fs::read(&figure).expect("the figure").starts_with(b"\x89PNG"));
    }
}

#[test]
fn figure_errors_leave_files_unchanged() {
    let directory = directory("linkage_refused");
    let text = fs::read_to_string(EXPERIMENT_95).expect("experiment-95");
    let scene = write(&directory, "scene.toml", &text);
    let missing_directory = directory.join("nowhere/figure.svg").display().to_string();
    for (scene, figure, part) in [
        (scene.as_str(), scene.as_str(), "the name must end in .svg"),
        (scene.as_str(), missing_directory.as_str(), "does not exist; create it first (mkdir -p"),
        ("scenes/laws/impact.toml", "figure.svg", "a scene without five-bar finger, but the symbols are those of one"),
    ] {
        assert_rejected(&["scene", "show", scene, "--plot", figure], &[part]);
    }
    assert_eq!(fs::read_to_string(&scene).expect("the scene"), text);
}
