//! The page with the moving bodies: what is in the file, read back from its bytes alone.

use base64::prelude::{BASE64_STANDARD, Engine};
use phalanx::drawing::poses;
use phalanx::page::{Film, MOST_SAMPLES, Note, Page, Picture, Reel, film, page};
use phalanx::scene::{self, Scene};
use phalanx::trace::{Model, Sink, Site, run};
use phalanx::validate::{Recording, record};
use serde_json::Value;

fn load(name: &str) -> Scene {
    scene::load(format!("scenes/{name}.toml")).expect("a scene")
}

fn load_discs(name: &str) -> Scene {
    scene::load_any(format!("scenes/{name}.toml")).expect("a scene")
}

fn films(scene: &Scene) -> (Vec<Recording>, Vec<Film>) {
    let recordings: Vec<Recording> =
        [Model::Analytic, Model::Engine].map(|model| record(model, scene).expect("a run")).into();
    let labels = ["analytic", "engine"];
    let film =
        |(recording, label): (&Recording, &str)| film(label, scene, &recording.samples, &recording.events, "a summary");
    let films = recordings.iter().zip(labels).map(film).collect();
    (recordings, films)
}

fn of(title: &str, runs: Vec<Film>) -> Page {
    Page { title: title.to_string(), runs, ..Page::default() }
}

/// The data of a page, from between the tags as a browser would take it.
fn data(html: &str) -> Value {
    let head = "<script type=\"application/json\" id=\"data\">";
    let from = html.find(head).expect("the data") + head.len();
    let length = html[from..].find("</script").expect("the end of the data");
    serde_json::from_str(&html[from..from + length]).expect("JSON")
}

/// A column of a run.
fn column(run: &Value, index: &Value) -> Vec<f64> {
    let text = run["columns"][index.as_u64().expect("an index") as usize].as_str().expect("base64");
    let bytes = BASE64_STANDARD.decode(text).expect("base64");
    let values: Vec<f64> =
        bytes.chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().expect("8 bytes"))).collect();
    let samples = run["samples"].as_u64().expect("a number") as usize;
    // What does not change is there once.
    if values.len() == 1 { vec![values[0]; samples] } else { values }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn bits(values: impl IntoIterator<Item = f64>) -> Vec<u64> {
    values.into_iter().map(f64::to_bits).collect()
}

#[test]
fn every_sample_of_a_closing_is_in_the_page_to_the_bit() {
    let scene = load("experiment-95");
    let (recordings, films) = films(&scene);
    let html = page(&of("closing", films));
    let document = data(&html);
    for (run, recording) in list(&document["runs"]).iter().zip(&recordings) {
        let samples = &recording.samples;
        assert_eq!(run["samples"], samples.len());
        assert_eq!(run["recorded"], samples.len());
        assert_eq!(bits(column(run, &run["time_s"])), bits(samples.iter().map(|s| s.time_s)));
        let poses: Vec<_> = samples.iter().map(|sample| poses(&scene, sample)).collect();
        for (index, body) in list(&run["bodies"]).iter().enumerate() {
            assert_eq!(bits(column(run, &body["x_m"])), bits(poses.iter().map(|all| all[index].position_m[0])));
            assert_eq!(bits(column(run, &body["y_m"])), bits(poses.iter().map(|all| all[index].position_m[1])));
            assert_eq!(bits(column(run, &body["angle_rad"])), bits(poses.iter().map(|all| all[index].angle_rad)));
        }
        let names: Vec<&str> = list(&run["bodies"]).iter().map(|body| body["name"].as_str().expect("a name")).collect();
        for name in ["object", "l11", "l12", "l21", "l22"] {
            assert!(names.contains(&name), "{name}");
        }
        let contacts = list(&run["contacts"]);
        assert_eq!(contacts.len(), 2);
        for contact in contacts {
            let of = |sample: &phalanx::trace::Sample| match contact["name"].as_str() {
                Some("proximal") => *sample.contact(Site::Proximal),
                _ => *sample.contact(Site::Distal),
            };
            let same = |key: &str, value: &dyn Fn(&phalanx::trace::Sample) -> f64| {
                assert_eq!(bits(column(run, &contact[key])), bits(samples.iter().map(value)), "{key}");
            };
            same("gap_m", &|s| of(s).gap_m);
            same("gap_rate_m_s", &|s| of(s).gap_rate_m_s);
            same("normal_n", &|s| of(s).normal_n);
            same("tangential_n", &|s| of(s).tangential_n);
            same("point_x_m", &|s| of(s).point_m[0]);
            same("point_y_m", &|s| of(s).point_m[1]);
            same("normal_x", &|s| of(s).normal[0]);
            same("normal_y", &|s| of(s).normal[1]);
        }
        let series = |panel: &str, name: &str| {
            let panel = list(&run["panels"]).iter().find(|each| each["title"] == panel).expect("a panel");
            let series = list(&panel["series"]).iter().find(|each| each["name"] == name).expect("a series");
            bits(column(run, &series["values"]))
        };
        assert_eq!(series("Normal force", "distal"), bits(samples.iter().map(|s| s.contact(Site::Distal).normal_n)));
        assert_eq!(series("Joint rate", "qd22"), bits(samples.iter().map(|s| s.finger().qd22_rad_s)));
        assert_eq!(series("Energy", "balance"), bits(samples.iter().map(|s| s.energy.balance_j)));
        assert_eq!(series("Torque", "limit"), bits(samples.iter().map(|s| s.contact(Site::Limit).normal_n)));
        let times: Vec<f64> =
            list(&run["events"]).iter().map(|event| event["time_s"].as_f64().expect("a time")).collect();
        assert_eq!(times.len(), recording.events.len());
        for (time, event) in times.iter().zip(&recording.events) {
            // The parser of this test is right to the last bit but one, as it is set.
            assert!((time - event.time_s).abs() <= f64::EPSILON * time);
        }
    }
}

#[test]
fn a_page_is_small_asks_for_nothing_and_repeats() {
    let scene = load("experiment-95");
    let (_, films) = films(&scene);
    let contents = Page {
        notes: vec![Note { title: "Validation".to_string(), text: "within bounds".into() }],
        ..of("experiment-95", films)
    };
    let html = page(&contents);
    assert!(html.len() < 800_000, "{} bytes", html.len());
    assert_eq!(html, page(&contents.clone()));
    for word in ["http://", "https://", "url(", "@import", "src=", "{{"] {
        let foreign = html.replace("http://www.w3.org/2000/svg", "").contains(word);
        assert!(!foreign, "{word} in the page");
    }
    assert!(html.contains("default-src 'none'"));
    assert!(html.contains("within bounds") && html.contains("a summary"));
}

#[test]
fn what_comes_from_a_scene_is_never_markup() {
    let hostile = "</script><script>alert(1)</script><!--<svg onload='x'>\"&amp;{{data}}\u{2028}";
    let mut scene = load_discs("laws/two-free");
    scene.name = hostile.to_string();
    scene.system.discs[0].name = hostile.to_string();
    let mut recording = Recording::default();
    run(Model::Analytic, &scene, &mut recording).expect("a run");
    let named = film(hostile, &scene, &recording.samples, &recording.events, hostile);
    let plain = film("label", &load_discs("laws/two-free"), &recording.samples, &recording.events, "text");
    let contents = Page {
        title: hostile.to_string(),
        description: hostile.to_string(),
        runs: vec![named],
        notes: vec![Note { title: hostile.to_string(), text: hostile.into() }],
        pictures: vec![Picture { title: hostile.to_string(), svg: "<svg></svg>".to_string() }],
    };
    let html = page(&contents);
    let harmless = page(&Page {
        description: "description".to_string(),
        notes: vec![Note { title: "title".to_string(), text: "text".into() }],
        pictures: vec![Picture { title: "title".to_string(), svg: "<svg></svg>".to_string() }],
        ..of("title", vec![plain])
    });
    // Not one tag or comment more than with harmless words.
    for tag in ["<script", "</script", "<!--", "<svg", "<img"] {
        assert_eq!(html.matches(tag).count(), harmless.matches(tag).count(), "{tag}");
    }
    let document = data(&html);
    let run = &document["runs"][0];
    assert_eq!(run["label"], hostile);
    assert!(list(&run["bodies"]).iter().any(|body| body["name"] == hostile));
}

#[test]
fn a_picture_of_ours_escapes_the_name_of_its_scene() {
    let hostile = "</svg><script>alert(1)</script>";
    let mut scene = load_discs("laws/spring");
    scene.name = hostile.to_string();
    let mut found = phalanx::validate::validate(&scene, &|| true).expect("a validation of a scene of discs");
    let plan = phalanx::validate::Climb { quick: true, time_s: 1.0 };
    phalanx::validate::climb(&mut found, &scene, plan, &mut |_| {}, &|| true).expect("its ladder");
    let svg = phalanx::plot::speed_error(&scene.name, &found);
    assert!(!svg.contains("<script") && svg.contains("&lt;script&gt;"));
}

#[test]
fn a_swing_without_an_object_has_no_contacts() {
    let scene = load("free-swing");
    let (_, films) = films(&scene);
    let document = data(&page(&of("swing", films)));
    for run in list(&document["runs"]) {
        assert_eq!(list(&run["contacts"]).len(), 0);
        let titles: Vec<&str> =
            list(&run["panels"]).iter().map(|panel| panel["title"].as_str().expect("a title")).collect();
        assert!(titles.contains(&"Joint angle") && !titles.contains(&"Normal force"), "{titles:?}");
        assert!(!list(&run["bodies"]).iter().any(|body| body["name"] == "object"));
    }
}

#[test]
fn discs_are_in_the_page_to_the_bit() {
    let scene = load_discs("laws/rolling");
    let mut recording = Recording::default();
    run(Model::Analytic, &scene, &mut recording).expect("a run");
    let (count, step) = (recording.samples.len(), recording.samples.len().div_ceil(MOST_SAMPLES));
    let samples: Vec<_> = recording.samples.iter().step_by(step).cloned().collect();
    assert!(count > 100);
    let shown = film("analytic", &scene, &samples, &recording.events, "");
    let document = data(&page(&of("rolling", vec![shown])));
    let run = &document["runs"][0];
    let poses: Vec<_> = samples.iter().map(|sample| poses(&scene, sample)).collect();
    for (index, body) in list(&run["bodies"]).iter().enumerate() {
        assert_eq!(bits(column(run, &body["x_m"])), bits(poses.iter().map(|all| all[index].position_m[0])));
        assert_eq!(bits(column(run, &body["angle_rad"])), bits(poses.iter().map(|all| all[index].angle_rad)));
    }
    let wheel = list(&run["contacts"]).iter().find(|contact| contact["name"] == "wheel-plane").expect("a pair");
    assert_eq!(bits(column(run, &wheel["normal_n"])), bits(samples.iter().map(|s| s.contacts[0].normal_n)));
}

#[test]
fn a_long_run_is_thinned_out_and_keeps_its_extremes() {
    let mut scene = load("experiment-95");
    scene.log.numeric_hz = 4e6;
    let mut reel = Reel::default();
    let mut largest = [0.0_f64; 2];
    let recording = record(Model::Analytic, &scene).expect("a run");
    for sample in &recording.samples {
        reel.sample(sample).expect("a reel takes everything");
        largest = [
            largest[0].max(sample.contact(Site::Proximal).normal_n),
            largest[1].max(sample.contact(Site::Distal).normal_n),
        ];
    }
    assert!(recording.samples.len() > 70_000, "{}", recording.samples.len());
    let film = reel.film("analytic", &scene, "");
    assert_eq!(film.recorded, recording.samples.len());
    assert!(film.times_s.len() <= MOST_SAMPLES && film.times_s.len() > MOST_SAMPLES * 3 / 4, "{}", film.times_s.len());
    assert_eq!(film.times_s[0], 0.0);
    assert_eq!(film.times_s.last(), recording.samples.last().map(|sample| &sample.time_s));
    for (contact, largest) in film.contacts.iter().zip(largest) {
        assert_eq!(contact.normal_n.iter().copied().fold(0.0, f64::max), largest, "{}", contact.name);
    }
    let html = page(&of("long", vec![film]));
    assert_eq!(data(&html)["runs"][0]["recorded"], recording.samples.len());
}

#[test]
fn the_same_run_gives_the_same_page() {
    let scene = load("experiment-95");
    let once = || {
        let mut reel = Reel::default();
        run(Model::Analytic, &scene, &mut reel).expect("a run");
        page(&of("twice", vec![reel.film("analytic", &scene, "summary")]))
    };
    assert_eq!(once(), once());
}
