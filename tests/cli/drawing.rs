//! Drawn shapes and poses of a scene agree with the models.

use phalanx::drawing::{self, BodyRole, Drawing, Pose, Shape};
use phalanx::gripper::{Posture, joint_positions};
use phalanx::scene::{self, ContactId, Scene};
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
fn distance_from_surface(shape: &Shape, pose: &Pose, point: [f64; 2]) -> f64 {
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
    assert_eq!(names, ["palm", "object", "l11", "l12", "l21", "l22"]);
    assert_eq!(drawing.contacts, ["proximal", "distal"]);
    let lengths = scene.finger().linkage.lengths;
    let recording = record(Model::Analytic, &scene).unwrap();
    for sample in &recording.samples {
        let poses = drawing::poses(&scene, sample);
        assert_eq!(poses.len(), drawing.bodies.len());
        let FingerState { q11_rad, q21_rad, q12_rad, q22_rad, .. } = sample.finger(0);
        let joints = joint_positions(&lengths, &Posture { q11_rad, q21_rad, q12_rad, q22_rad });
        let [coupler, distal] = [poses[3], poses[5]];
        assert!(distance(coupler.position_m, joints.a12_m) < 1e-12);
        assert!(distance(distal.position_m, joints.a22_m) < 1e-12);
        // The loop is closed: the ends of the coupler and of the arm are one point.
        assert!(distance(coupler.apply([lengths.l12_m, 0.0]), distal.apply([lengths.l22_m, 0.0])) < 1e-9);
        for (body, contact) in
            [(4, sample.finger_contact(FingerContact::Proximal)), (5, sample.finger_contact(FingerContact::Distal))]
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
        for (body, pose) in drawing.bodies.iter().zip(drawing::poses(&scene, sample)) {
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
    let l21_m = load("experiment-95").finger().linkage.lengths.l21_m;
    assert!((drawing.arrow_m(0.48 / 0.015) - 0.5 * l21_m).abs() < 1e-12, "the arrow of a usual force");
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
    let offset = usize::from(scene.system.palm.is_some());
    assert_eq!(drawing.bodies.len(), scene.system.discs.len() + offset);
    for sample in &recording.samples {
        for (index, pose) in drawing::poses(&scene, sample).iter().skip(offset).enumerate() {
            assert_eq!(pose.position_m, sample.body(index).centre_m);
            assert_eq!(pose.angle_rad, sample.body(index).angle_rad);
        }
        let (ContactId::Discs(disc, _) | ContactId::Palm(disc)) = scene.system.pairs()[0] else { panic!("a pair") };
        let (index, contact) = (offset + disc, sample.contact(0));
        let pose = &drawing::poses(&scene, sample)[index];
        let distance_m = distance_from_surface(&drawing.bodies[index].shapes[0], pose, contact.point_m);
        assert!(distance_m < 1e-12, "{distance_m}");
    }
    assert!(drawing.arrow_m_per_n > 0.0 && drawing.arrow_m_per_n.is_finite());
}

#[test]
fn readme_pictures_support_dark_mode() {
    let pictures = std::fs::read_dir("tools/figures").expect("pictures").map(|entry| entry.expect("a file").path());
    let mut count = 0;
    for path in pictures.filter(|path| path.extension().is_some_and(|suffix| suffix == "svg")) {
        let svg = std::fs::read_to_string(&path).expect("a picture");
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
