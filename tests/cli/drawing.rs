//! Shapes and poses of a scene are those that the models have.

use phalanx::drawing::{self, Drawing, Part, Pose, Shape};
use phalanx::gripper::{Posture, joints};
use phalanx::scene::{self, Scene};
use phalanx::shape::reach;
use phalanx::trace::{Model, Site, run};
use phalanx::validate::Recording;

fn load(name: &str) -> Scene {
    scene::load(format!("scenes/{name}.toml")).unwrap()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Distance of a point from the surface of a shape at a pose.
fn off_surface(shape: &Shape, pose: &Pose, point: [f64; 2]) -> f64 {
    match shape {
        Shape::Capsule { from_m, to_m, radius_m } => {
            let (a, b) = (pose.apply(*from_m), pose.apply(*to_m));
            let (along, to) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
            let t = ((to[0] * along[0] + to[1] * along[1]) / (along[0].powi(2) + along[1].powi(2))).clamp(0.0, 1.0);
            (distance(point, [a[0] + t * along[0], a[1] + t * along[1]]) - radius_m).abs()
        }
        Shape::Disc { radius_m } => (distance(point, pose.position_m) - radius_m).abs(),
        _ => f64::INFINITY,
    }
}

#[test]
fn joints_and_contact_points_lie_where_the_bodies_are_drawn() {
    let scene = load("experiment-95");
    let drawing = Drawing::of(&scene);
    assert_eq!(
        drawing.bodies.iter().map(|body| body.name.as_str()).collect::<Vec<_>>(),
        ["palm", "object", "l11", "l12", "l21", "l22"]
    );
    assert_eq!(drawing.contacts, ["proximal", "distal"]);
    let lengths = scene.finger().linkage.lengths;
    let mut kept = Recording::default();
    run(Model::Analytic, &scene, &mut kept).unwrap();
    for sample in &kept.samples {
        let poses = drawing::poses(&scene, sample);
        assert_eq!(poses.len(), drawing.bodies.len());
        let at = joints(
            &lengths,
            &Posture {
                q11_rad: sample.finger().q11_rad,
                q21_rad: sample.finger().q21_rad,
                q12_rad: sample.finger().q12_rad,
                q22_rad: sample.finger().q22_rad,
            },
        );
        let [coupler, distal] = [poses[3], poses[5]];
        assert!(distance(coupler.position_m, at.a12_m) < 1e-12);
        assert!(distance(distal.position_m, at.a22_m) < 1e-12);
        // The loop is closed: the ends of the coupler and of the arm are one point.
        assert!(distance(coupler.apply([lengths.l12_m, 0.0]), distal.apply([lengths.l22_m, 0.0])) < 1e-9);
        for (body, contact) in [(4, sample.contact(Site::Proximal)), (5, sample.contact(Site::Distal))] {
            let capsule = drawing.bodies[body].shapes.last().unwrap();
            let off = off_surface(capsule, &poses[body], contact.point_m);
            assert!(off < 1e-12, "{} at {} s: {off} m off", drawing.bodies[body].name, sample.time_s);
        }
    }
}

#[test]
fn the_view_has_start_and_grasp_and_the_object() {
    let scene = load("experiment-95");
    let drawing = Drawing::of(&scene);
    let [low, high] = drawing.extent_m;
    let mut kept = Recording::default();
    run(Model::Analytic, &scene, &mut kept).unwrap();
    let object = scene.object().unwrap();
    for k in 0..2 {
        let radius_m = reach(&object.shape);
        assert!(low[k] < object.centre_m[k] - radius_m && object.centre_m[k] + radius_m < high[k]);
    }
    for sample in [kept.samples.first().unwrap(), kept.samples.last().unwrap()] {
        for (body, pose) in drawing.bodies.iter().zip(drawing::poses(&scene, sample)) {
            for shape in &body.shapes {
                if let Shape::Polygon { corners_m } = shape {
                    for corner in corners_m.iter().map(|corner| pose.apply(*corner)) {
                        assert!(
                            (0..2).all(|k| low[k] <= corner[k] && corner[k] <= high[k]),
                            "{} {corner:?}",
                            body.name
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn arrows_are_bounded_and_keep_their_sign() {
    let drawing = Drawing::of(&load("experiment-95"));
    let usual = 0.48 / 0.015;
    assert!((drawing.arrow_m(usual) - 0.5 * load("experiment-95").finger().linkage.lengths.l21_m).abs() < 1e-12);
    assert_eq!(drawing.arrow_m(1e6), drawing.longest_arrow_m);
    assert_eq!(drawing.arrow_m(-1e6), -drawing.longest_arrow_m);
}

#[test]
fn without_object_palm_or_closure_there_is_still_a_finger() {
    let scene = load("free-swing");
    let drawing = Drawing::of(&scene);
    assert!(drawing.contacts.is_empty());
    assert!(drawing.bodies.iter().all(|body| body.part != Part::Object));
    assert!(drawing.extent_m.iter().flatten().all(|at| at.is_finite()));
}

#[test]
fn discs_are_drawn_where_they_are() {
    let scene = scene::load_any("scenes/laws/two-free.toml").unwrap();
    let drawing = Drawing::of(&scene);
    let mut kept = Recording::default();
    run(Model::Analytic, &scene, &mut kept).unwrap();
    let offset = usize::from(scene.system.palm.is_some());
    assert_eq!(drawing.bodies.len(), scene.system.discs.len() + offset);
    for sample in &kept.samples {
        for (index, pose) in drawing::poses(&scene, sample).iter().skip(offset).enumerate() {
            assert_eq!(pose.position_m, sample.bodies[index].centre_m);
            assert_eq!(pose.angle_rad, sample.bodies[index].angle_rad);
        }
        let (pair, contact) = (scene.system.pairs()[0], &sample.contacts[0]);
        let at = offset + pair.disc;
        let off = off_surface(&drawing.bodies[at].shapes[0], &drawing::poses(&scene, sample)[at], contact.point_m);
        assert!(off < 1e-12, "{off}");
    }
    assert!(drawing.arrow_m_per_n > 0.0 && drawing.arrow_m_per_n.is_finite());
}

#[test]
fn every_picture_of_the_readme_reads_on_a_dark_page() {
    let pictures = std::fs::read_dir("tools/figures").expect("pictures").map(|entry| entry.expect("a file").path());
    let mut count = 0;
    for path in pictures.filter(|path| path.extension().is_some_and(|suffix| suffix == "svg")) {
        let svg = std::fs::read_to_string(&path).expect("a picture");
        let compact: String = svg.split_whitespace().collect();
        assert!(compact.contains("@media(prefers-color-scheme:dark){"), "{}", path.display());
        // White stays nowhere: by a variable that is dark there, or by a rule.
        let ours = ["[fill=\"#FFFFFF\"]{fill:var(--panel,#FFFFFF)", "--panel:#1b1f26"];
        let dark = [&ours[..], &["[style*=\"fill:#ffffff\"]{fill:#1b1f26"], &[".ground{fill:#1b1f26"]];
        let all = |rules: &&[&str]| rules.iter().all(|rule| compact.contains(rule));
        assert!(dark.iter().any(all), "{}", path.display());
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        roxmltree::Document::parse_with_options(&svg, options).expect("well-formed");
        count += 1;
    }
    assert!(count >= 8, "{count} pictures");
}
