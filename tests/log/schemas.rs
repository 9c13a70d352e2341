//! What the messages in a log are called: ours under `phalanx.`, Foxglove's under `foxglove.`; logs in which ours had other
//! names are read as before.

use phalanx::scene::words::SceneKind;
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;

use foxglove::Encode;
use phalanx::log::{
    Contact, Disc, Energy, Impact, Limit, LimitImpact, LogSink, Record, State, read_any, read_any_file, read_file,
};
use phalanx::trace::{Layout, Model, Recording, SinkError};

use crate::support::cli::{directory, json, phalanx, stderr};
use crate::support::replay::{Changes, DISCS, FINGER, changed, log};

/// The schema of every topic.
#[derive(Default)]
struct Schemas {
    names: BTreeMap<u16, String>,
    topics: BTreeMap<String, String>,
}

impl LogSink for Schemas {
    fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
        match record {
            Record::Schema(schema) => drop(self.names.insert(schema.id, schema.name.to_string())),
            Record::Channel(channel) => {
                drop(self.topics.insert(channel.topic.to_string(), self.names[&channel.schema].clone()));
            }
            _ => {}
        }
        Ok(())
    }
}

fn schemas(bytes: &[u8]) -> BTreeMap<String, String> {
    let mut found = Schemas::default();
    assert!(read_any(Cursor::new(bytes), &mut found).expect("a log").is_whole());
    found.topics
}

/// The log with our messages in packages of their own names, as they once were.
fn of_old(bytes: &[u8]) -> Vec<u8> {
    let derived = [
        State::get_schema(),
        Contact::get_schema(),
        Limit::get_schema(),
        Energy::get_schema(),
        Impact::get_schema(),
        LimitImpact::get_schema(),
        Disc::get_schema(),
    ];
    let derived: Vec<_> = derived.into_iter().flatten().collect();
    assert_eq!(derived.len(), 7);
    let schema = |name: &str, data: &[u8]| match name.strip_prefix("phalanx.") {
        Some(message) => {
            let old = derived.iter().find(|old| old.name.ends_with(&format!(".{message}"))).expect("one of ours");
            (old.name.clone(), old.data.to_vec())
        }
        None => (name.to_string(), data.to_vec()),
    };
    changed(bytes, &Changes { schema: &schema, ..Changes::default() })
}

#[test]
fn our_messages_have_our_name() {
    let found = schemas(&log(FINGER, Model::Analytic, 1e3));
    for (topic, name) in [
        ("/state", "phalanx.State"),
        ("/contact/distal", "phalanx.Contact"),
        ("/limit", "phalanx.Limit"),
        ("/energy", "phalanx.Energy"),
        ("/impact/proximal", "phalanx.Impact"),
        ("/impact/limit", "phalanx.LimitImpact"),
        ("/events", "foxglove.Log"),
        ("/tf", "foxglove.FrameTransforms"),
        ("/forces", "foxglove.SceneUpdate"),
    ] {
        assert_eq!(found[topic], name);
    }
    assert!(!found.keys().any(|topic| topic.starts_with("/slip")), "nothing holds, and nothing says so");
    let held = schemas(&log("scenes/experiment-95-bristle.toml", Model::Analytic, 1e3));
    assert_eq!([&held["/slip/proximal"], &held["/slip/distal"]], ["phalanx.Slip"; 2]);
    let discs = schemas(&log(DISCS, Model::Analytic, 1e3));
    assert_eq!(discs["/disc/hammer"], "phalanx.Disc");
    for name in found.values().chain(discs.values()) {
        assert!(name.starts_with("phalanx.") || name.starts_with("foxglove."), "{name}");
    }
}

/// Written by phalanx 0.1.0 before its messages had its name: `run scenes/experiment-95.toml --duration "2 ms"
/// --numeric-rate "2 kHz" --picture-rate "0 Hz" --log`.
#[test]
fn a_log_of_old_is_read() {
    let path = "tests/log/names-of-old.mcap";
    assert_eq!(schemas(&fs::read(path).expect("the log"))["/state"], "state.State");
    let mut recording = Recording::new(&Layout::of_kind(SceneKind::Finger));
    let reading = read_file(path.as_ref(), &mut recording).expect("a log");
    assert!(reading.is_whole(), "{:?}", reading.losses);
    assert_eq!(reading.ended.expect("an end").stopped, None);
    assert_eq!((recording.time().len(), recording.events().len()), (27, 1));
    assert_eq!(recording.time().last(), Some(&2e-3));
    assert!(recording.column("q11_rad").expect("a column").iter().all(|angle| (-0.9..-0.7).contains(angle)));
    assert!(recording.column("kinetic_j").expect("a column").last().expect("samples") > &0.0);
}

#[test]
fn a_log_of_old_says_the_same_and_is_no_other_run() {
    let directory = directory("schemas_of_old");
    for (name, scene) in [("finger", FINGER), ("discs", DISCS)] {
        let (now, old) = (directory.join(format!("{name}.mcap")), directory.join(format!("{name}-old.mcap")));
        let bytes = log(scene, Model::Analytic, 1e3);
        fs::write(&now, &bytes).expect("written");
        fs::write(&old, of_old(&bytes)).expect("written");
        assert!(schemas(&fs::read(&old).expect("a log")).values().any(|name| name == "energy.Energy"));
        match scene {
            FINGER => {
                let [mut a, mut b] = [
                    Recording::new(&Layout::of_kind(SceneKind::Finger)),
                    Recording::new(&Layout::of_kind(SceneKind::Finger)),
                ];
                read_any_file(&now, &mut a).expect("a log");
                read_any_file(&old, &mut b).expect("a log");
                assert!(a.time().len() > 20 && a.column("q21_rad") == b.column("q21_rad"));
                assert_eq!(a.events(), b.events());
            }
            _ => {
                let [mut a, mut b] = [(); 2].map(|()| Recording::new(&Layout::default()));
                read_any_file(&now, &mut a).expect("a log");
                read_any_file(&old, &mut b).expect("a log");
                assert!(a.time().len() > 15);
                assert_eq!(a, b);
            }
        }
        let output = phalanx(&["replay", old.to_str().expect("text"), "--verify", "--json"]);
        assert!(output.status.success(), "{}", stderr(&output));
        assert_eq!(json(&output)["verification"]["same"], true);
    }
}
