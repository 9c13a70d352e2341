//! Schema names: phalanx' own in the package `phalanx`, Foxglove's in `foxglove`; logs with older names remain
//! readable.

use phalanx::scene::keywords::SceneKind;
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;

use foxglove::Encode;
use phalanx::log::{
    Contact, Disc, Energy, Impact, Limit, LimitImpact, LogSink, Record, State, read_any, read_any_file, read_file,
};
use phalanx::trace::{Layout, Model, Recording, SinkError};

use crate::support::cli::{directory, json, phalanx, stderr};
use crate::support::replay::{DISC_SCENE, FINGER_SCENE, LogEdits, edit_log, log};

/// Schema name of every topic.
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
    let mut collected = Schemas::default();
    assert!(read_any(Cursor::new(bytes), &mut collected).expect("a log").is_complete());
    collected.topics
}

/// Renames phalanx' own schemas to their older names, with one package per message.
fn with_old_schema_names(bytes: &[u8]) -> Vec<u8> {
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
            let old = derived.iter().find(|old| old.name.ends_with(&format!(".{message}"))).expect("a phalanx message");
            (old.name.clone(), old.data.to_vec())
        }
        None => (name.to_string(), data.to_vec()),
    };
    edit_log(bytes, &LogEdits { schema: &schema, ..LogEdits::default() })
}

#[test]
fn schema_names_have_the_expected_package() {
    let actual = schemas(&log(FINGER_SCENE, Model::Analytic, 1e3));
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
        assert_eq!(actual[topic], name);
    }
    assert!(!actual.keys().any(|topic| topic.starts_with("/slip")), "no slip topics without stiction");
    let with_stiction = schemas(&log("scenes/experiment-95-bristle.toml", Model::Analytic, 1e3));
    assert_eq!([&with_stiction["/slip/proximal"], &with_stiction["/slip/distal"]], ["phalanx.Slip"; 2]);
    let discs = schemas(&log(DISC_SCENE, Model::Analytic, 1e3));
    assert_eq!(discs["/disc/hammer"], "phalanx.Disc");
    for name in actual.values().chain(discs.values()) {
        assert!(name.starts_with("phalanx.") || name.starts_with("foxglove."), "{name}");
    }
}

/// This log was written by phalanx 0.1.0 with the older schema names: `run scenes/experiment-95.toml --duration "2 ms"
/// --numeric-rate "2 kHz" --picture-rate "0 Hz" --log`.
#[test]
fn reads_a_log_with_old_schema_names() {
    let path = "tests/log/names-of-old.mcap";
    assert_eq!(schemas(&fs::read(path).expect("the log"))["/state"], "state.State");
    let mut recording = Recording::new(&Layout::from_kind(SceneKind::Finger));
    let reading = read_file(path.as_ref(), &mut recording).expect("a log");
    assert!(reading.is_complete(), "{:?}", reading.losses);
    assert_eq!(reading.run_end.expect("an end").stopped, None);
    assert_eq!((recording.time().len(), recording.events().len()), (27, 1));
    assert_eq!(recording.time().last(), Some(&2e-3));
    assert!(recording.column("q11_rad").expect("a column").iter().all(|angle| (-0.9..-0.7).contains(angle)));
    assert!(recording.column("kinetic_j").expect("a column").last().expect("samples") > &0.0);
}

#[test]
fn old_schema_names_do_not_change_contents_or_verification() {
    let directory = directory("schemas_of_old");
    for (name, scene) in [("finger", FINGER_SCENE), ("discs", DISC_SCENE)] {
        let (current, old) = (directory.join(format!("{name}.mcap")), directory.join(format!("{name}-old.mcap")));
        let bytes = log(scene, Model::Analytic, 1e3);
        fs::write(&current, &bytes).expect("written");
        fs::write(&old, with_old_schema_names(&bytes)).expect("written");
        assert!(schemas(&fs::read(&old).expect("a log")).values().any(|name| name == "energy.Energy"));
        match scene {
            FINGER_SCENE => {
                let [mut a, mut b] = [
                    Recording::new(&Layout::from_kind(SceneKind::Finger)),
                    Recording::new(&Layout::from_kind(SceneKind::Finger)),
                ];
                read_any_file(&current, &mut a).expect("a log");
                read_any_file(&old, &mut b).expect("a log");
                assert!(a.time().len() > 20 && a.column("q21_rad") == b.column("q21_rad"));
                assert_eq!(a.events(), b.events());
            }
            _ => {
                let [mut a, mut b] = [(); 2].map(|()| Recording::new(&Layout::default()));
                read_any_file(&current, &mut a).expect("a log");
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
