//! What a 3-D view gets of a run: every frame where the body is, shapes once, forces as arrows, each when something changes.

use std::collections::BTreeMap;

use foxglove::Decode;
use foxglove::messages::{FrameTransforms, SceneUpdate};
use mcap::MessageStream;
use phalanx::drawing::{self, Drawing, Shape};
use phalanx::log::{RunInfo, Writer};
use phalanx::scene::{self, Scene};
use phalanx::trace::{Event, Model, Sample, Sink, SinkError, Site, Thinned, run};

/// A message: topic, log time, payload.
type Raw = (String, u64, Vec<u8>);

/// Keeps the samples that the log gets.
struct Both<W: Sink> {
    writer: W,
    samples: Vec<Sample>,
}

impl<W: Sink> Sink for Both<W> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.samples.push(sample.clone());
        self.writer.sample(sample)
    }
    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.writer.event(event)
    }
}

fn load(name: &str) -> Scene {
    scene::load(format!("scenes/{name}.toml")).expect("a scene")
}

fn logged(scene: &Scene, model: Model) -> (Vec<Raw>, Vec<Sample>) {
    let info = RunInfo { scene, scene_file: "scene.toml", model: model.name() };
    let writer = Writer::new(Vec::new(), "the log", &info).expect("started");
    let mut sink = Thinned::new(scene.log.numeric_hz, Both { writer, samples: Vec::new() });
    run(model, scene, &mut sink).expect("a run");
    sink.end().expect("written");
    (messages(&sink.sink.writer.finish().expect("finished")), sink.sink.samples)
}

fn messages(bytes: &[u8]) -> Vec<Raw> {
    let all = MessageStream::new(bytes).expect("a log");
    all.map(|message| message.expect("readable"))
        .map(|message| (message.channel.topic.clone(), message.log_time, message.data.to_vec()))
        .collect()
}

fn of<'a>(messages: &'a [Raw], topic: &'static str) -> impl Iterator<Item = &'a Raw> {
    messages.iter().filter(move |message| message.0 == topic)
}

fn transforms(message: &Raw) -> FrameTransforms {
    FrameTransforms::decode(&message.2[..]).expect("transforms")
}

fn update(message: &Raw) -> SceneUpdate {
    SceneUpdate::decode(&message.2[..]).expect("a scene update")
}

/// Angle of a turn in the plane.
fn angle(rotation: Option<foxglove::messages::Quaternion>) -> f64 {
    let rotation = rotation.expect("a rotation");
    assert!((rotation.x, rotation.y) == (0.0, 0.0));
    2.0 * rotation.z.atan2(rotation.w)
}

#[test]
fn every_frame_is_where_its_body_is() {
    let scene = load("experiment-95");
    let bodies = Drawing::of(&scene).bodies;
    for model in [Model::Analytic, Model::Engine] {
        let (messages, samples) = logged(&scene, model);
        let frames: Vec<FrameTransforms> = of(&messages, "/tf").map(transforms).collect();
        assert!(frames.len() > 30, "{} pictures", frames.len());
        for (message, frames) in of(&messages, "/tf").zip(&frames) {
            let sample = samples.iter().find(|sample| (sample.time_s * 1e9).round() as u64 == message.1);
            let poses = drawing::poses(&scene, sample.expect("a picture is one of a sample"));
            let moving: Vec<_> = bodies.iter().zip(&poses).filter(|(body, _)| !body.fixed).collect();
            assert_eq!(moving.len(), frames.transforms.len());
            for ((body, pose), frame) in moving.into_iter().zip(&frames.transforms) {
                assert_eq!((frame.parent_frame_id.as_str(), &frame.child_frame_id), ("world", &body.name));
                let place = frame.translation.expect("a place");
                assert_eq!([place.x, place.y, place.z], [pose.position_m[0], pose.position_m[1], 0.0]);
                assert!(((angle(frame.rotation) - pose.angle_rad) * 0.5).sin().abs() < 1e-14, "{}", body.name);
                let stamp = frame.timestamp.expect("a stamp");
                assert_eq!(u64::from(stamp.sec()) * 1_000_000_000 + u64::from(stamp.nsec()), message.1);
            }
        }
        let fixed = of(&messages, "/tf_static").map(transforms).collect::<Vec<_>>();
        assert_eq!(fixed.len(), 1);
        let names: Vec<&str> = fixed[0].transforms.iter().map(|frame| frame.child_frame_id.as_str()).collect();
        assert_eq!(names, ["palm", "object"]);
    }
}

#[test]
fn shapes_come_once_and_are_those_of_the_scene() {
    let scene = load("experiment-95");
    let (messages, _) = logged(&scene, Model::Analytic);
    let scenes: Vec<SceneUpdate> = of(&messages, "/scene").map(update).collect();
    assert_eq!(scenes.len(), 1);
    let bodies = Drawing::of(&scene).bodies;
    assert_eq!(scenes[0].entities.len(), bodies.len());
    for (entity, body) in scenes[0].entities.iter().zip(&bodies) {
        assert_eq!((&entity.id, &entity.frame_id, entity.frame_locked), (&body.name, &body.name, true));
        assert_eq!((entity.lines.len(), entity.triangles.len()), (body.shapes.len(), body.shapes.len()));
        for ((line, fill), shape) in entity.lines.iter().zip(&entity.triangles).zip(&body.shapes) {
            assert_eq!(fill.indices.len(), 3 * (fill.points.len() - 2), "a fan fills a convex outline");
            assert_eq!(line.points, fill.points);
            let corners: Vec<[f64; 2]> = line.points.iter().map(|point| [point.x, point.y]).collect();
            let far = |from: [f64; 2]| corners.iter().map(move |p| (p[0] - from[0]).hypot(p[1] - from[1]));
            match shape {
                Shape::Polygon { corners_m } => assert_eq!(&corners, corners_m),
                Shape::Disc { radius_m } => assert!(far([0.0; 2]).all(|d| (d - radius_m).abs() < 1e-12)),
                Shape::Capsule { from_m, to_m, radius_m } => {
                    let nearest = far(*from_m).zip(far(*to_m)).map(|(a, b)| a.min(b));
                    assert!(nearest.into_iter().all(|d| (d - radius_m).abs() < 1e-12));
                }
                Shape::HalfPlane { level_m } => assert!(corners.iter().all(|corner| corner[1] <= *level_m)),
            }
            // Counter-clockwise.
            let turned = |k: usize| {
                let (p, q) = (corners[k], corners[(k + 1) % corners.len()]);
                p[0] * q[1] - p[1] * q[0]
            };
            assert!((0..corners.len()).map(turned).sum::<f64>() > 0.0, "{}", body.name);
        }
    }
}

#[test]
fn arrows_show_the_forces_and_go_when_they_end() {
    let scene = load("experiment-95");
    let drawing = Drawing::of(&scene);
    let (messages, samples) = logged(&scene, Model::Analytic);
    let mut longest: f64 = 0.0;
    for message in of(&messages, "/forces") {
        let sample =
            samples.iter().rfind(|sample| (sample.time_s * 1e9).round() as u64 == message.1).expect("a sample");
        let update = update(message);
        assert_eq!(update.entities.iter().map(|entity| entity.id.as_str()).collect::<Vec<_>>(), ["proximal", "distal"]);
        for (entity, contact) in
            update.entities.iter().zip([sample.contact(Site::Proximal), sample.contact(Site::Distal)])
        {
            assert_eq!(entity.frame_id, "world");
            let Some(normal) = entity.arrows.first() else {
                assert!(contact.normal_n <= 0.0 && entity.spheres.is_empty());
                continue;
            };
            let length = normal.shaft_length + normal.head_length;
            assert!((length - drawing.arrow_m(contact.normal_n)).abs() < 1e-12);
            longest = longest.max(length);
            let pose = normal.pose.as_ref().expect("a pose");
            let place = pose.position.expect("a place");
            assert_eq!([place.x, place.y], contact.point_m);
            let along = angle(pose.orientation);
            assert!((along.cos() - contact.normal[0]).hypot(along.sin() - contact.normal[1]) < 1e-12);
            if let Some(friction) = entity.arrows.get(1) {
                let along = angle(friction.pose.as_ref().expect("a pose").orientation);
                let force = [along.cos(), along.sin()].map(|part| part * contact.tangential_n.abs());
                let tangent = contact.tangent().map(|part| part * contact.tangential_n);
                assert!((force[0] - tangent[0]).hypot(force[1] - tangent[1]) < 1e-9);
            }
        }
    }
    // The impacts are drawn between the pictures of the grid: their forces are a multiple of those that hold.
    assert!(longest >= 2.0 * drawing.arrow_m(23.6), "{longest}");
}

#[test]
fn rates_are_kept_and_nothing_is_drawn_where_nothing_moves() {
    let mut scene = load("experiment-95");
    let count = |scene: &Scene, topic: &'static str| of(&logged(scene, Model::Analytic).0, topic).count();
    scene.log.picture_hz = 1e3;
    let seldom = count(&scene, "/tf");
    scene.log.picture_hz = 5e3;
    let often = count(&scene, "/tf");
    // It moves for 7 ms; the pictures within its impacts are the same.
    assert!((20..=28).contains(&(often - seldom)), "{seldom} of {often}");
    scene.duration_s *= 5.0;
    let held = count(&scene, "/tf");
    assert!(held < often + 60, "{held} of {often}: while the object is held, nothing moves");
    scene.log.picture_hz = 0.0;
    for topic in ["/tf", "/tf_static", "/scene", "/forces"] {
        assert_eq!(count(&scene, topic), 0, "{topic}");
    }
}

#[test]
fn at_each_instant_frames_come_before_what_is_drawn_in_them() {
    let (messages, _) = logged(&load("experiment-95"), Model::Engine);
    let mut frames_at: BTreeMap<u64, usize> = BTreeMap::new();
    for (index, (topic, time, _)) in messages.iter().enumerate() {
        match topic.as_str() {
            "/tf" | "/tf_static" => assert!(frames_at.insert(*time, index).is_none() || *time == 0),
            "/scene" => assert!(frames_at.contains_key(time)),
            "/forces" => assert!(frames_at.get(time).is_none_or(|&frames| frames < index)),
            _ => {}
        }
    }
}

#[test]
fn discs_are_drawn_too() {
    let scene = scene::load_any("scenes/laws/two-free.toml").expect("a scene");
    let info = RunInfo { scene: &scene, scene_file: "two-free.toml", model: "analytic" };
    let writer = Writer::new(Vec::new(), "the log", &info).expect("started");
    let mut sink = Thinned::new(scene.log.numeric_hz, writer);
    run(Model::Analytic, &scene, &mut sink).expect("a run");
    sink.end().expect("written");
    let messages = messages(&sink.sink.finish().expect("finished"));
    let last = of(&messages, "/tf").last().expect("pictures");
    for (frame, disc) in transforms(last).transforms.iter().zip(&scene.system.discs) {
        assert_eq!(frame.child_frame_id, disc.name);
        let topic = format!("/disc/{}", disc.name);
        let state = messages.iter().rfind(|message| message.0 == topic && message.1 == last.1).expect("a sample");
        // Flat messages of doubles: a key of one byte before each.
        let number = |field: usize| f64::from_le_bytes(state.2[9 * field + 1..][..8].try_into().expect("a double"));
        let place = frame.translation.expect("a place");
        assert_eq!((place.x, place.y), (number(1), number(2)));
    }
    assert_eq!(update(of(&messages, "/scene").next().expect("shapes")).entities.len(), scene.system.discs.len());
    assert!(of(&messages, "/forces").any(|message| !update(message).entities[0].arrows.is_empty()));
    let end = update(of(&messages, "/forces").last().expect("forces"));
    assert!(end.entities[0].arrows.is_empty(), "they have parted");
}
