//! Reads logs with the mcap crate and decodes every message by its embedded descriptor, with a protobuf library that
//! the writer does not use.

use std::collections::BTreeSet;

use crate::support::synthetic::{lift_off, reload, sample, scene, touch_down};
use mcap::{MessageStream, Summary};
use phalanx::log::{RunInfo, Severity, Writer, metadata};
use phalanx::scene::Scene;
use phalanx::trace::{Event, FingerContact, Recording, Sample, Schema, Sink};
use prost_reflect::{DescriptorPool, DynamicMessage, ReflectMessage, Value};

enum Record {
    Sample(Box<Sample>),
    Event(Event),
}

/// Records from 0 to 20 ms on a grid of 0.1 ms, with an impact in steps of 0.3 ns around 5 ms.
fn test_records() -> Vec<Record> {
    let mut records = Vec::new();
    for i in 0..=200 {
        records.push(Record::Sample(Box::new(sample(1e-4 * i as f64))));
        if i == 50 {
            records.push(Record::Event(touch_down(5.00001e-3, FingerContact::Proximal, 1.25)));
            for k in 1..=10 {
                records.push(Record::Sample(Box::new(sample(5.00001e-3 + 3e-10 * k as f64))));
            }
            records.push(Record::Event(lift_off(5.00002e-3, FingerContact::Proximal, 3.5e-3)));
            records.push(Record::Event(touch_down(5.00003e-3, FingerContact::Limit, 12.5)));
            records.push(Record::Event(reload(5.00003e-3, FingerContact::Limit)));
            records.push(Record::Event(touch_down(5.00004e-3, FingerContact::Distal, 0.75)));
        }
    }
    records
}

fn write(scene: &Scene, records: &[Record]) -> Vec<u8> {
    let run = RunInfo { scene, scene_file: "synthetic.toml", model: "analytic" };
    let mut writer = Writer::new(Vec::new(), "the log", &run).expect("started");
    for record in records {
        match record {
            Record::Sample(sample) => writer.sample(sample).expect("written"),
            Record::Event(event) => writer.event(event).expect("written"),
        }
    }
    writer.note(scene.duration_s, Severity::Info, "run", "done").expect("written");
    writer.finish().expect("finished")
}

/// A decoded message: topic, log time, publish time, and its fields by name.
struct Decoded {
    topic: String,
    log_time: u64,
    publish_time: u64,
    message: DynamicMessage,
}

impl Decoded {
    fn number(&self, field: &str) -> f64 {
        match self.message.get_field_by_name(field).expect(field).as_ref() {
            Value::F64(value) => *value,
            other => panic!("{field}: {other:?}"),
        }
    }

    fn numbers(&self) -> Vec<(String, f64)> {
        let descriptor = self.message.descriptor();
        let mut fields: Vec<_> = descriptor.fields().collect();
        fields.sort_by_key(|field| field.number());
        fields.iter().map(|f| (f.name().to_string(), self.number(f.name()))).collect()
    }

    fn text(&self, field: &str) -> String {
        self.message.get_field_by_name(field).expect(field).as_str().expect("a string").to_string()
    }
}

fn read(bytes: &[u8]) -> Vec<Decoded> {
    MessageStream::new(bytes)
        .expect("a log")
        .map(|message| {
            let message = message.expect("readable to the end");
            assert_eq!(message.channel.message_encoding, "protobuf");
            let schema = message.channel.schema.as_ref().expect("a schema");
            assert_eq!(schema.encoding, "protobuf");
            let pool = DescriptorPool::decode(&schema.data[..]).expect("a FileDescriptorSet");
            let descriptor = pool.get_message_by_name(&schema.name).expect("the schema's own message");
            Decoded {
                topic: message.channel.topic.clone(),
                log_time: message.log_time,
                publish_time: message.publish_time,
                message: DynamicMessage::decode(descriptor, &message.data[..]).expect("matches its descriptor"),
            }
        })
        .collect()
}

#[test]
fn every_value_is_read_back_unchanged() {
    let records = test_records();
    let mut scene = scene();
    let [without_forces, with_forces] = [false, true].map(|joint_forces| {
        scene.log.joint_forces = joint_forces;
        read(&write(&scene, &records))
    });
    let mut recording = Recording::new(&Schema::for_fingers(1));
    for record in &records {
        if let Record::Sample(sample) = record {
            recording.sample(sample).expect("recorded");
        }
    }
    // Fields are columns of the table of samples, without the name of the contact.
    for (messages, topic, prefix, count) in [
        (&without_forces, "/joint/q11", "q11_", 3),
        (&with_forces, "/joint/q11", "q11_", 5),
        (&with_forces, "/joint/q12", "q12_", 5),
        (&without_forces, "/actuator/motor", "motor_", 2),
        (&without_forces, "/contact/proximal", "proximal_", 11),
        (&with_forces, "/contact/distal", "distal_", 11),
        (&without_forces, "/contact/limit", "limit_", 5),
        (&without_forces, "/energy", "", 8),
    ] {
        let on_topic: Vec<_> = messages.iter().filter(|message| message.topic == topic).collect();
        assert_eq!(on_topic.len(), recording.time().len(), "{topic}");
        for (index, message) in on_topic.into_iter().enumerate() {
            let numbers = message.numbers();
            assert_eq!((numbers.len(), numbers[0].0.as_str()), (count, "timestamp"), "{topic}");
            for (name, value) in numbers {
                let column = match name.as_str() {
                    "timestamp" => "time_s".to_string(),
                    // Angle and rate of a joint are its coordinate.
                    "angle_rad" => format!("{prefix}rad"),
                    "rate_rad_s" => format!("{}rad_s", prefix.replace('q', "qd")),
                    _ => format!("{prefix}{name}"),
                };
                let expected = recording.column(&column).unwrap_or_else(|| panic!("no {column}"))[index];
                assert_eq!(value.to_bits(), expected.to_bits(), "{topic} {name}");
            }
        }
    }
}

#[test]
fn log_times_start_at_zero_and_never_decrease() {
    let messages = read(&write(&scene(), &test_records()));
    assert_eq!(messages.first().expect("not empty").log_time, 0);
    let mut last = 0;
    for message in &messages {
        assert_eq!(message.log_time, message.publish_time);
        assert!(message.log_time >= last, "{}", message.topic);
        last = message.log_time;
        if message.message.get_field_by_name("timestamp").is_some_and(|field| field.as_f64().is_some()) {
            let timestamp = message.number("timestamp");
            assert!((timestamp * 1e9 - message.log_time as f64).abs() <= 0.5, "{} {timestamp}", message.topic);
        }
    }
    assert_eq!(last, 20_000_000);
    // Steps of 0.3 ns share log times but differ in `timestamp`.
    let timestamps: Vec<f64> =
        messages.iter().filter(|m| m.topic == "/joint/q11").map(|m| m.number("timestamp")).collect();
    assert!(timestamps.windows(2).all(|pair| pair[0] < pair[1]));
}

#[test]
fn events_are_written_as_text_and_as_messages() {
    let messages = read(&write(&scene(), &test_records()));
    let on_topic = |topic: &'static str| messages.iter().filter(move |m| m.topic == topic);
    let numbers = ["approach_speed_m_s", "impulse_n_s", "approach_speed_rad_s", "impulse_n_m_s"];
    let expected = [
        (5.00001e-3, ["proximal", "contact", "touch_down"], [1.25, 0.0, 0.0, 0.0]),
        (5.00002e-3, ["proximal", "contact", "lift_off"], [0.0, 3.5e-3, 0.0, 0.0]),
        (5.00003e-3, ["limit", "limit", "touch_down"], [0.0, 0.0, 12.5, 0.0]),
        (5.00003e-3, ["limit", "limit", "reload"], [0.0; 4]),
        (5.00004e-3, ["distal", "contact", "touch_down"], [0.75, 0.0, 0.0, 0.0]),
    ];
    let messages_of_events: Vec<_> = on_topic("/event").collect();
    assert_eq!(messages_of_events.len(), expected.len());
    for (message, (time_s, texts, values)) in messages_of_events.into_iter().zip(expected) {
        assert_eq!(message.number("timestamp"), time_s);
        assert_eq!(["subject", "subject_kind", "kind"].map(|field| message.text(field)), texts);
        assert_eq!(numbers.map(|field| message.number(field)), values);
    }

    let events: Vec<_> = on_topic("/events").collect();
    assert_eq!(events.len(), 6);
    assert_eq!(events[0].message.descriptor().full_name(), "foxglove.Log");
    assert_eq!(events[0].text("name"), "proximal");
    assert_eq!(events[0].text("message"), "proximal phalanx: touch-down at 5.000010 ms, approach speed 1.250000 m/s");
    assert!(events[1].text("message").contains("impulse 3.500000e-3 N·s"));
    assert!(events[2].text("message").contains("12.500000 rad/s"));
    let timestamp = events[0].message.get_field_by_name("timestamp").expect("a timestamp");
    let timestamp = timestamp.as_message().expect("google.protobuf.Timestamp");
    assert_eq!(timestamp.get_field_by_name("seconds").expect("seconds").as_i64(), Some(0));
    assert_eq!(timestamp.get_field_by_name("nanos").expect("nanos").as_i32(), Some(5_000_010));
    assert_eq!(events[5].text("name"), "run");
    assert_eq!(events[5].text("message"), "done");
}

#[test]
fn log_contains_the_scene_and_the_settings() {
    let scene = scene();
    let bytes = write(&scene, &test_records());
    let summary = Summary::read(&bytes).expect("readable").expect("indexed");
    assert_eq!(summary.attachment_indexes.len(), 1);
    let attachment = mcap::read::attachment(&bytes, &summary.attachment_indexes[0]).expect("readable");
    assert_eq!(attachment.name, "synthetic.toml");
    assert_eq!(attachment.media_type, "application/toml");
    assert_eq!(attachment.data.as_ref(), scene.source.as_bytes());
    assert_eq!((attachment.log_time, attachment.create_time), (0, 0));

    assert_eq!(summary.metadata_indexes.len(), 2);
    let subjects = mcap::read::metadata(&bytes, &summary.metadata_indexes[1]).expect("readable");
    assert_eq!(subjects.name, "phalanx-subjects");
    let expected = "joint q11, joint q12, joint q21, joint q22, joint loop, actuator motor, contact proximal, contact distal, \
                    limit limit, energy energy";
    assert_eq!(subjects.metadata["subjects"], expected);
    let kind = |topic: &str| {
        let channel = summary.channels.values().find(|channel| channel.topic == topic).expect("a channel");
        channel.metadata.get("kind").cloned()
    };
    let kinds = ["/joint/q11", "/contact/limit", "/energy", "/event"].map(kind);
    assert_eq!(kinds, [Some("joint"), Some("limit"), Some("energy"), None].map(|kind| kind.map(String::from)));
    let record = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).expect("readable");
    assert_eq!(record.name, "phalanx");
    let info = RunInfo { scene: &scene, scene_file: "synthetic.toml", model: "analytic" };
    assert_eq!(record.metadata, metadata(&info));
    assert_eq!(record.metadata["model"], "analytic");
    assert_eq!(record.metadata["integrator_rtol"], "0.0001");
    assert_eq!(record.metadata["phalanx_version"], env!("CARGO_PKG_VERSION"));
}

#[test]
fn log_contains_only_topics_of_the_scene() {
    let topics = |scene: &Scene| -> BTreeSet<String> {
        // The test records have the contacts of a closing finger.
        let records = if scene.object().is_some() { test_records() } else { Vec::new() };
        let bytes = write(scene, &records);
        let summary = Summary::read(&bytes).expect("readable").expect("indexed");
        let declared: BTreeSet<String> = summary.channels.values().map(|c| c.topic.clone()).collect();
        let used: BTreeSet<String> = read(&bytes).into_iter().map(|m| m.topic).collect();
        assert!(used.is_subset(&declared));
        declared
    };
    let set = |names: &str| names.split(' ').map(String::from).collect::<BTreeSet<_>>();
    let contacts = "/contact/distal /contact/proximal /contact/limit /forces";
    let joints = "/actuator/motor /joint/q11 /joint/q12 /joint/loop /joint/q21 /joint/q22";
    let drawn = "/energy /event /events /scene /tf /tf_static";
    let drawn = format!("{joints} {drawn}");
    assert_eq!(topics(&scene()), set(&format!("{contacts} {drawn}")));
    let mut swing = scene();
    swing.hand.object = None;
    swing.finger_mut().limit = None;
    assert_eq!(topics(&swing), set(&drawn));
    swing.log.picture_hz = 0.0;
    assert_eq!(topics(&swing), set(&format!("{joints} /energy /event /events")));
}
