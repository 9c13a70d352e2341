//! Contents of the page with the moving bodies, read back from its bytes.

use base64::prelude::{BASE64_STANDARD, Engine};
use phalanx::criteria::ObjectTracker;
use phalanx::drawing::{Drawing, FramePose};
use phalanx::page::{MAX_SAMPLES, Note, Page, Picture, Playback, PlaybackRecorder, build_playback, render_page};
use phalanx::report::object::ObjectReport;
use phalanx::scene::{self, Scene};
use phalanx::trace::{ContactSample, FingerContact, Model, Sink, run};
use phalanx::validate::{Recording, record};
use serde_json::Value;

fn load(name: &str) -> Scene {
    scene::load_any(format!("scenes/{name}.toml")).expect("a scene")
}

fn playbacks(scene: &Scene) -> (Vec<Recording>, Vec<Playback>) {
    let recordings: Vec<Recording> =
        [Model::Analytic, Model::Engine].map(|model| record(model, scene).expect("a run")).into();
    let labels = ["analytic", "engine"];
    let playback = |(recording, label): (&Recording, &str)| {
        build_playback(label, scene, &recording.samples, &recording.events, "a summary")
    };
    let playbacks = recordings.iter().zip(labels).map(playback).collect();
    (recordings, playbacks)
}

fn page_with_runs(title: &str, runs: Vec<Playback>) -> Page {
    Page { title: title.to_string(), runs, ..Page::default() }
}

/// Data of a page, extracted from its tags as in a browser.
fn data(html: &str) -> Value {
    let head = "<script type=\"application/json\" id=\"data\">";
    let from = html.find(head).expect("the data") + head.len();
    let length = html[from..].find("</script").expect("the end of the data");
    serde_json::from_str(&html[from..from + length]).expect("JSON")
}

/// Values of a column of a run.
fn column(run: &Value, index: &Value) -> Vec<f64> {
    let text = run["columns"][index.as_u64().expect("an index") as usize].as_str().expect("base64");
    let bytes = BASE64_STANDARD.decode(text).expect("base64");
    let values: Vec<f64> =
        bytes.chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().expect("8 bytes"))).collect();
    let samples = run["samples"].as_u64().expect("a number") as usize;
    // A constant column is stored as one value.
    if values.len() == 1 { vec![values[0]; samples] } else { values }
}

type Quantity = (&'static str, fn(&ContactSample) -> f64);

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn bits(values: impl IntoIterator<Item = f64>) -> Vec<u64> {
    values.into_iter().map(f64::to_bits).collect()
}

/// Asserts that the bodies of a run have these poses, bit for bit.
#[track_caller]
fn assert_poses(run: &Value, poses: &[Vec<FramePose>]) {
    for (index, body) in list(&run["bodies"]).iter().enumerate() {
        assert_eq!(bits(column(run, &body["x_m"])), bits(poses.iter().map(|all| all[index].position_m[0])));
        assert_eq!(bits(column(run, &body["y_m"])), bits(poses.iter().map(|all| all[index].position_m[1])));
        assert_eq!(bits(column(run, &body["angle_rad"])), bits(poses.iter().map(|all| all[index].angle_rad)));
    }
}

#[test]
fn page_contains_every_sample_bit_for_bit() {
    let scene = load("experiment-95");
    let (recordings, playbacks) = playbacks(&scene);
    let html = render_page(&page_with_runs("closing", playbacks));
    let document = data(&html);
    for (run, recording) in list(&document["runs"]).iter().zip(&recordings) {
        let samples = &recording.samples;
        assert_eq!(run["samples"], samples.len());
        assert_eq!(run["recorded"], samples.len());
        assert_eq!(bits(column(run, &run["time_s"])), bits(samples.iter().map(|s| s.time_s)));
        let poses: Vec<_> = samples.iter().map(|sample| Drawing::from_scene(&scene).poses(sample)).collect();
        assert_poses(run, &poses);
        let names: Vec<&str> = list(&run["bodies"]).iter().map(|body| body["name"].as_str().expect("a name")).collect();
        for name in ["object", "l11", "l12", "l21", "l22"] {
            assert!(names.contains(&name), "{name}");
        }
        let quantities: [Quantity; 8] = [
            ("gap_m", |contact| contact.gap_m),
            ("gap_rate_m_s", |contact| contact.gap_rate_m_s),
            ("normal_n", |contact| contact.normal_n),
            ("tangential_n", |contact| contact.tangential_n),
            ("point_x_m", |contact| contact.point_m[0]),
            ("point_y_m", |contact| contact.point_m[1]),
            ("normal_x", |contact| contact.normal[0]),
            ("normal_y", |contact| contact.normal[1]),
        ];
        assert_eq!(list(&run["contacts"]).len(), 2);
        for contact in list(&run["contacts"]) {
            let is_proximal = contact["name"] == "proximal";
            let of = if is_proximal { FingerContact::Proximal } else { FingerContact::Distal };
            for (key, value) in quantities {
                let expected = samples.iter().map(|sample| value(&sample.finger_contact(of)));
                assert_eq!(bits(column(run, &contact[key])), bits(expected), "{key}");
            }
        }
        let series = |panel: &str, name: &str| {
            let panel = list(&run["panels"]).iter().find(|each| each["title"] == panel).expect("a panel");
            let series = list(&panel["series"]).iter().find(|each| each["name"] == name).expect("a series");
            bits(column(run, &series["values"]))
        };
        let distal_n = samples.iter().map(|s| s.finger_contact(FingerContact::Distal).normal_n);
        assert_eq!(series("Normal force", "distal"), bits(distal_n));
        assert_eq!(series("Joint rate", "q22"), bits(samples.iter().map(|s| s.finger(0).qd22_rad_s)));
        assert_eq!(series("Energy", "balance"), bits(samples.iter().map(|s| s.energy().balance_j)));
        assert_eq!(
            series("Torque", "limit"),
            bits(samples.iter().map(|s| s.finger_contact(FingerContact::Limit).normal_n))
        );
        let times: Vec<f64> =
            list(&run["events"]).iter().map(|event| event["time_s"].as_f64().expect("a time")).collect();
        assert_eq!(times.len(), recording.events.len());
        for (time, event) in times.iter().zip(&recording.events) {
            // With its settings here, the JSON parser of this test may be off by the last bit.
            assert!((time - event.time_s).abs() <= f64::EPSILON * time);
        }
    }
}

/// Corners of a box against a jaw are one contact with the sum of their forces, which act on the jaw.
#[test]
fn points_of_two_outlines_are_one_contact() {
    let scene = load("mechanisms/jaws");
    let recording = record(Model::Analytic, &scene).expect("a run");
    let playback = build_playback("analytic", &scene, &recording.samples, &recording.events, "");
    let names: Vec<&str> = playback.contacts.iter().map(|contact| contact.name.as_str()).collect();
    assert_eq!(names, ["box / ground.floor", "left / box", "right / box"]);
    let last = recording.samples.last().expect("a sample");
    let points = scene.mechanism.as_ref().expect("a mechanism").point_contacts();
    let touching = points.iter().enumerate().filter(|(index, _)| last.contact(*index).normal_n > 0.0);
    let at_right: Vec<ContactSample> =
        touching.filter(|(_, point)| point.name.contains("right.skin")).map(|(index, _)| last.contact(index)).collect();
    assert!(at_right.len() > 1 && at_right.iter().any(|point| point.normal[0] < 0.0), "{at_right:?}");
    let column = |name: &str, key: &str| {
        let contact = playback.contacts.iter().find(|contact| contact.name == name).expect("a contact");
        let (_, column) = contact.columns.iter().find(|(other, _)| other == key).expect("a quantity");
        *playback.columns[*column].last().expect("a value")
    };
    let sum = |value: fn(&ContactSample) -> f64| at_right.iter().map(value).sum::<f64>();
    assert!((column("right / box", "normal_n") - sum(|point| point.normal_n)).abs() < 1e-12);
    assert!((column("right / box", "tangential_n") - sum(|point| point.tangential_n)).abs() < 1e-12);
    let moment = sum(|point| point.normal_n * point.point_m[1]);
    assert!((column("right / box", "point_y_m") - moment / sum(|point| point.normal_n)).abs() < 1e-12);
    assert!(column("right / box", "normal_x") > 0.99 && column("left / box", "normal_x") < -0.99);
    assert!(column("box / ground.floor", "normal_y") > 0.99);
    let gap = at_right.iter().map(|point| point.gap_m).fold(f64::INFINITY, f64::min);
    assert_eq!(column("right / box", "gap_m"), gap);
    // An event is at the pair, and names its point.
    let event = playback.event_markers.iter().find(|event| event.location == "right / box").expect("an event");
    assert!(event.point.as_ref().expect("a point").contains('['), "{event:?}");
}

#[test]
fn page_is_small_self_contained_and_reproducible() {
    let scene = load("experiment-95");
    let render = || {
        let notes = vec![Note { title: "Validation".to_string(), text: "within bounds".into() }];
        render_page(&Page { notes, ..page_with_runs("experiment-95", playbacks(&scene).1) })
    };
    let html = render();
    assert!(html.len() < 800_000, "{} bytes", html.len());
    assert_eq!(html, render(), "the same runs give the same page");
    for word in ["http://", "https://", "url(", "@import", "src=", "{{"] {
        let is_external = html.replace("http://www.w3.org/2000/svg", "").contains(word);
        assert!(!is_external, "{word} in the page");
    }
    assert!(html.contains("default-src 'none'"));
    assert!(html.contains("within bounds") && html.contains("a summary"));
}

#[test]
fn scene_text_is_never_markup() {
    let untrusted_text = "</script><script>alert(1)</script><!--<svg onload='x'>\"&amp;{{data}}\u{2028}";
    let mut scene = load("laws/two-free");
    scene.name = untrusted_text.to_string();
    scene.mechanism.as_mut().expect("discs").bodies[0].name = untrusted_text.to_string();
    let recording = record(Model::Analytic, &scene).expect("a run");
    let named = build_playback(untrusted_text, &scene, &recording.samples, &recording.events, untrusted_text);
    let plain = build_playback("label", &load("laws/two-free"), &recording.samples, &recording.events, "text");
    let contents = Page {
        title: untrusted_text.to_string(),
        description: untrusted_text.to_string(),
        runs: vec![named],
        notes: vec![Note { title: untrusted_text.to_string(), text: untrusted_text.into() }],
        pictures: vec![Picture { title: untrusted_text.to_string(), svg: "<svg></svg>".to_string() }],
    };
    let html = render_page(&contents);
    let expected = render_page(&Page {
        description: "description".to_string(),
        notes: vec![Note { title: "title".to_string(), text: "text".into() }],
        pictures: vec![Picture { title: "title".to_string(), svg: "<svg></svg>".to_string() }],
        ..page_with_runs("title", vec![plain])
    });
    // The page has exactly as many tags and comments as with harmless text.
    for tag in ["<script", "</script", "<!--", "<svg", "<img"] {
        assert_eq!(html.matches(tag).count(), expected.matches(tag).count(), "{tag}");
    }
    let document = data(&html);
    let run = &document["runs"][0];
    assert_eq!(run["label"], untrusted_text);
    assert!(list(&run["bodies"]).iter().any(|body| body["name"] == untrusted_text));
}

#[test]
fn a_swing_without_an_object_has_no_contacts() {
    let scene = load("free-swing");
    let (_, playbacks) = playbacks(&scene);
    let document = data(&render_page(&page_with_runs("swing", playbacks)));
    for run in list(&document["runs"]) {
        assert_eq!(list(&run["contacts"]).len(), 0);
        let titles: Vec<&str> =
            list(&run["panels"]).iter().map(|panel| panel["title"].as_str().expect("a title")).collect();
        assert!(titles.contains(&"Joint angle") && !titles.contains(&"Normal force"), "{titles:?}");
        assert!(!list(&run["bodies"]).iter().any(|body| body["name"] == "object"));
    }
}

#[test]
fn page_contains_discs_bit_for_bit() {
    let scene = load("laws/rolling");
    let recording = record(Model::Analytic, &scene).expect("a run");
    let (count, step) = (recording.samples.len(), recording.samples.len().div_ceil(MAX_SAMPLES));
    let samples: Vec<_> = recording.samples.iter().step_by(step).cloned().collect();
    assert!(count > 100);
    let playback = build_playback("analytic", &scene, &samples, &recording.events, "");
    let document = data(&render_page(&page_with_runs("rolling", vec![playback])));
    let run = &document["runs"][0];
    let poses: Vec<_> = samples.iter().map(|sample| Drawing::from_scene(&scene).poses(sample)).collect();
    assert_poses(run, &poses);
    let wheel = list(&run["contacts"]).iter().find(|contact| contact["name"] == "wheel-plane").expect("a pair");
    assert_eq!(bits(column(run, &wheel["normal_n"])), bits(samples.iter().map(|s| s.contact(0).normal_n)));
}

#[test]
fn long_run_is_decimated_and_keeps_its_extremes() {
    let mut scene = load("experiment-95");
    scene.log.numeric_hz = 4e6;
    let mut recorder = PlaybackRecorder::default();
    let mut largest = [0.0_f64; 2];
    let recording = record(Model::Analytic, &scene).expect("a run");
    for sample in &recording.samples {
        recorder.sample(sample).expect("recorded");
        largest = [
            largest[0].max(sample.finger_contact(FingerContact::Proximal).normal_n),
            largest[1].max(sample.finger_contact(FingerContact::Distal).normal_n),
        ];
    }
    assert!(recording.samples.len() > 70_000, "{}", recording.samples.len());
    let playback = recorder.into_playback("analytic", &scene, "");
    assert_eq!(playback.recorded, recording.samples.len());
    let times = &playback.columns[playback.time_s];
    assert!((MAX_SAMPLES * 3 / 4..=MAX_SAMPLES).contains(&times.len()), "{}", times.len());
    assert_eq!((times[0], times.last()), (0.0, recording.samples.last().map(|sample| &sample.time_s)));
    for (contact, largest) in playback.contacts.iter().zip(largest) {
        let forces = &playback.columns[*contact.columns.get("normal_n").expect("a column")];
        assert_eq!(forces.iter().copied().fold(0.0, f64::max), largest, "{}", contact.name);
    }
    let html = render_page(&page_with_runs("long", vec![playback]));
    assert_eq!(data(&html)["runs"][0]["recorded"], recording.samples.len());
}

/// The answer is text of the page, which needs no script; the states are in its data, and drawn with names.
#[test]
fn page_begins_with_the_answer_and_has_the_states_of_the_object() {
    let scene = load("gripper/cycle");
    let reports = [Model::Analytic, Model::Engine].map(|model| {
        let mut tracker = ObjectTracker::for_scene(&scene).expect("a grasp");
        run(model, &scene, &mut tracker).expect("a completed run");
        ObjectReport::new(&tracker.criteria().expect("a run"), Some(&scene))
    });
    let (_, playbacks) = playbacks(&scene);
    let runs: Vec<Playback> = playbacks
        .into_iter()
        .zip(&reports)
        .map(|(playback, report)| playback.with_grasp(Some(report.played())))
        .collect();
    let html = render_page(&page_with_runs("cycle", runs));
    let heading = &html[html.find("<h1>").expect("a heading")..html.find("<main").expect("the playback")];
    for report in &reports {
        assert!(report.answer().starts_with("held since 4.501 ms: "), "{}", report.answer());
        assert!(heading.contains(&report.answer()), "{heading}");
    }
    for run in list(&data(&html)["runs"]) {
        let states: Vec<(f64, &str)> = list(&run["grasp"]["states"])
            .iter()
            .map(|state| (state["from_s"].as_f64().expect("a time"), state["name"].as_str().expect("a name")))
            .collect();
        assert!(states.is_sorted_by(|a, b| a.0 < b.0), "{states:?}");
        let names: Vec<&str> = states.iter().map(|(_, name)| *name).collect();
        assert_eq!((states[0].0, names[0], names[names.len() - 1]), (0.0, "resting", "released"), "{states:?}");
        assert_eq!(states[names.len() - 1].0, 0.35);
        for name in names {
            assert!(html.contains(&format!(".states .{name} {{")) && html.contains(&format!("\n  {name}: ")), "{name}");
        }
    }
    // Without a grasp there is neither.
    let (_, playbacks) = self::playbacks(&load("laws/two-free"));
    assert!(!render_page(&page_with_runs("discs", playbacks)).contains("class=\"answer\""));
}
