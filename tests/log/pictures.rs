//! Channels of the 3-D view: frames at body poses, shapes once, forces as arrows, written only on changes.

use std::collections::BTreeMap;

use foxglove::Decode;
use foxglove::messages::{FrameTransforms, SceneUpdate};
use mcap::MessageStream;
use phalanx::drawing::{Drawing, Shape};
use phalanx::log::{RunInfo, Writer};
use phalanx::scene::{self, Scene};
use phalanx::trace::{Decimated, FingerContact, Model, Sample, run};

use super::decimation::decimated_run;

/// A message: topic, log time, payload.
type RawMessage = (String, u64, Vec<u8>);

fn load(name: &str) -> Scene {
    scene::load(format!("scenes/{name}.toml")).expect("a scene")
}

/// Messages in the log of a run, and the samples that the log receives.
fn log_run(scene: &Scene, model: Model) -> (Vec<RawMessage>, Vec<Sample>) {
    let info = RunInfo { scene, scene_file: "scene.toml", model: model.name() };
    let writer = Writer::new(Vec::new(), "the log", &info).expect("started");
    let mut sink = Decimated::new(scene.log.numeric_hz, writer);
    run(model, scene, &mut sink).expect("a run");
    sink.end().expect("written");
    (messages(&sink.sink.finish().expect("finished")), decimated_run(scene, model).1.samples)
}

fn messages(bytes: &[u8]) -> Vec<RawMessage> {
    let all = MessageStream::new(bytes).expect("a log");
    all.map(|message| message.expect("readable"))
        .map(|message| (message.channel.topic.clone(), message.log_time, message.data.to_vec()))
        .collect()
}

fn messages_on_topic<'a>(messages: &'a [RawMessage], topic: &'static str) -> impl Iterator<Item = &'a RawMessage> {
    messages.iter().filter(move |message| message.0 == topic)
}

fn decode_transforms(message: &RawMessage) -> FrameTransforms {
    FrameTransforms::decode(&message.2[..]).expect("transforms")
}

fn update(message: &RawMessage) -> SceneUpdate {
    SceneUpdate::decode(&message.2[..]).expect("a scene update")
}

/// Angle of a rotation in the plane.
fn rotation_angle(rotation: Option<foxglove::messages::Quaternion>) -> f64 {
    let rotation = rotation.expect("a rotation");
    assert!((rotation.x, rotation.y) == (0.0, 0.0));
    2.0 * rotation.z.atan2(rotation.w)
}

#[test]
fn frames_match_body_poses() {
    let scene = load("experiment-95");
    let drawing = Drawing::from_scene(&scene);
    let bodies = &drawing.bodies;
    for model in [Model::Analytic, Model::Engine] {
        let (messages, samples) = log_run(&scene, model);
        let frames: Vec<FrameTransforms> = messages_on_topic(&messages, "/tf").map(decode_transforms).collect();
        assert!(frames.len() > 30, "{} pictures", frames.len());
        for (message, frames) in messages_on_topic(&messages, "/tf").zip(&frames) {
            let sample = samples.iter().find(|sample| (sample.time_s * 1e9).round() as u64 == message.1);
            let poses = drawing.poses(sample.expect("the sample of the picture"));
            let moving: Vec<_> = bodies.iter().zip(&poses).filter(|(body, _)| !body.fixed).collect();
            assert_eq!(moving.len(), frames.transforms.len());
            for ((body, pose), frame) in moving.into_iter().zip(&frames.transforms) {
                assert_eq!((frame.parent_frame_id.as_str(), &frame.child_frame_id), ("world", &body.name));
                let translation = frame.translation.expect("a translation");
                let [x, y] = pose.position_m;
                assert_eq!([translation.x, translation.y, translation.z], [x, y, 0.0]);
                assert!(((rotation_angle(frame.rotation) - pose.angle_rad) * 0.5).sin().abs() < 1e-14, "{}", body.name);
                let timestamp = frame.timestamp.expect("a timestamp");
                assert_eq!(u64::from(timestamp.sec()) * 1_000_000_000 + u64::from(timestamp.nsec()), message.1);
            }
        }
        let fixed = messages_on_topic(&messages, "/tf_static").map(decode_transforms).collect::<Vec<_>>();
        assert_eq!(fixed.len(), 1);
        let names: Vec<&str> = fixed[0].transforms.iter().map(|frame| frame.child_frame_id.as_str()).collect();
        assert_eq!(names, ["object", "palm", "ground"]);
    }
}

#[test]
fn shapes_are_written_once_and_match_the_scene() {
    let scene = load("experiment-95");
    let (messages, _) = log_run(&scene, Model::Analytic);
    let scenes: Vec<SceneUpdate> = messages_on_topic(&messages, "/scene").map(update).collect();
    assert_eq!(scenes.len(), 1);
    let bodies = Drawing::from_scene(&scene).bodies;
    assert_eq!(scenes[0].entities.len(), bodies.len());
    for (entity, body) in scenes[0].entities.iter().zip(&bodies) {
        assert_eq!((&entity.id, &entity.frame_id, entity.frame_locked), (&body.name, &body.name, true));
        assert_eq!((entity.lines.len(), entity.triangles.len()), (body.shapes.len(), body.shapes.len()));
        for ((line, fill), shape) in entity.lines.iter().zip(&entity.triangles).zip(&body.shapes) {
            assert_eq!(fill.indices.len(), 3 * (fill.points.len() - 2), "a fan fills a convex outline");
            assert_eq!(line.points, fill.points);
            let corners: Vec<[f64; 2]> = line.points.iter().map(|point| [point.x, point.y]).collect();
            let distances_from = |from: [f64; 2]| corners.iter().map(move |p| (p[0] - from[0]).hypot(p[1] - from[1]));
            match shape {
                Shape::Polygon { corners_m } => assert_eq!(&corners, corners_m),
                Shape::Disc { radius_m } => assert!(distances_from([0.0; 2]).all(|d| (d - radius_m).abs() < 1e-12)),
                Shape::Capsule { from_m, to_m, radius_m } => {
                    let nearest = distances_from(*from_m).zip(distances_from(*to_m)).map(|(a, b)| a.min(b));
                    assert!(nearest.into_iter().all(|d| (d - radius_m).abs() < 1e-12));
                }
                Shape::HalfPlane { level_m } => assert!(corners.iter().all(|corner| corner[1] <= *level_m)),
            }
            // Counter-clockwise.
            let signed_area_term = |k: usize| {
                let (p, q) = (corners[k], corners[(k + 1) % corners.len()]);
                p[0] * q[1] - p[1] * q[0]
            };
            assert!((0..corners.len()).map(signed_area_term).sum::<f64>() > 0.0, "{}", body.name);
        }
    }
}

#[test]
fn arrows_match_forces_and_disappear_without_force() {
    let scene = load("experiment-95");
    let drawing = Drawing::from_scene(&scene);
    let (messages, samples) = log_run(&scene, Model::Analytic);
    let mut longest: f64 = 0.0;
    for message in messages_on_topic(&messages, "/forces") {
        let update = update(message);
        // Times of messages are whole nanoseconds; several samples may belong to one.
        let mut at_time = samples.iter().filter(|sample| (sample.time_s * 1e9).round() as u64 == message.1);
        let has_lengths = |sample: &&Sample| {
            let contacts =
                [FingerContact::Proximal, FingerContact::Distal].map(|contact| sample.finger_contact(contact));
            update.entities.iter().zip(contacts).all(|(entity, contact)| {
                let length = entity.arrows.first().map_or(0.0, |arrow| arrow.shaft_length + arrow.head_length);
                (length - if contact.normal_n > 0.0 { drawing.arrow_m(contact.normal_n) } else { 0.0 }).abs() < 1e-12
            })
        };
        let sample = at_time.rfind(has_lengths).expect("a sample with the forces of the picture");
        assert_eq!(update.entities.iter().map(|entity| entity.id.as_str()).collect::<Vec<_>>(), ["proximal", "distal"]);
        for (entity, contact) in update
            .entities
            .iter()
            .zip([sample.finger_contact(FingerContact::Proximal), sample.finger_contact(FingerContact::Distal)])
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
            let point = pose.position.expect("a position");
            assert_eq!([point.x, point.y], contact.point_m);
            let direction_rad = rotation_angle(pose.orientation);
            assert!((direction_rad.cos() - contact.normal[0]).hypot(direction_rad.sin() - contact.normal[1]) < 1e-12);
            if let Some(friction) = entity.arrows.get(1) {
                let direction_rad = rotation_angle(friction.pose.as_ref().expect("a pose").orientation);
                let force = [direction_rad.cos(), direction_rad.sin()].map(|part| part * contact.tangential_n.abs());
                let tangent = contact.tangent().map(|part| part * contact.tangential_n);
                assert!((force[0] - tangent[0]).hypot(force[1] - tangent[1]) < 1e-9);
            }
        }
    }
    // Impacts are drawn between grid pictures: their forces are several times the holding forces.
    assert!(longest >= 2.0 * drawing.arrow_m(23.6), "{longest}");
}

#[test]
fn picture_rate_is_respected_and_a_static_scene_is_not_redrawn() {
    let mut scene = load("experiment-95");
    let count =
        |scene: &Scene, topic: &'static str| messages_on_topic(&log_run(scene, Model::Analytic).0, topic).count();
    scene.log.picture_hz = 1e3;
    let at_1_khz = count(&scene, "/tf");
    scene.log.picture_hz = 5e3;
    let at_5_khz = count(&scene, "/tf");
    // The finger moves for 7 ms; pictures within impacts are the same at both rates.
    assert!((20..=28).contains(&(at_5_khz - at_1_khz)), "{at_1_khz} of {at_5_khz}");
    scene.duration_s *= 5.0;
    let long_run = count(&scene, "/tf");
    assert!(long_run < at_5_khz + 60, "{long_run} of {at_5_khz}: while the object is held, nothing moves");
    scene.log.picture_hz = 0.0;
    for topic in ["/tf", "/tf_static", "/scene", "/forces"] {
        assert_eq!(count(&scene, topic), 0, "{topic}");
    }
}

#[test]
fn frames_precede_shapes_and_forces_at_each_instant() {
    let (messages, _) = log_run(&load("experiment-95"), Model::Engine);
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
fn draws_discs() {
    let scene = scene::load_any("scenes/laws/two-free.toml").expect("a scene");
    let (messages, _) = log_run(&scene, Model::Analytic);
    let last = messages_on_topic(&messages, "/tf").last().expect("pictures");
    let bodies = &scene.mechanism.as_ref().expect("discs").bodies;
    for (frame, disc) in decode_transforms(last).transforms.iter().zip(bodies) {
        assert_eq!(frame.child_frame_id, disc.name);
        let topic = format!("/body/{}", disc.name);
        let state = messages.iter().rfind(|message| message.0 == topic && message.1 == last.1).expect("a sample");
        // Flat messages of doubles, each after a key of one byte.
        let number = |field: usize| f64::from_le_bytes(state.2[9 * field + 1..][..8].try_into().expect("a double"));
        let translation = frame.translation.expect("a translation");
        assert_eq!((translation.x, translation.y), (number(1), number(2)));
    }
    let shapes = update(messages_on_topic(&messages, "/scene").next().expect("shapes"));
    assert_eq!(shapes.entities.len(), 1 + bodies.len());
    assert!(messages_on_topic(&messages, "/forces").any(|message| !update(message).entities[0].arrows.is_empty()));
    let end = update(messages_on_topic(&messages, "/forces").last().expect("forces"));
    assert!(end.entities[0].arrows.is_empty(), "the discs have separated");
}
