//! Schema names: phalanx' own in the package `phalanx`, Foxglove's in `foxglove`; logs with older names remain
//! readable.

use phalanx::scene::keywords::SceneKind;
use std::collections::BTreeMap;
use std::fs;

use phalanx::log::read_file;
use phalanx::trace::{Model, Recording, Schema};
use prost_reflect::prost::Message;
use prost_reflect::prost_types::FileDescriptorSet;

use crate::support::cli::{directory, path_text, run_json};
use crate::support::replay::{DISC_SCENE, FINGER_SCENE, LogContents, LogEdits, edit_log, log, read_contents};

/// Returns the schema name of every topic.
fn schemas(bytes: &[u8]) -> BTreeMap<String, String> {
    let LogContents { channels, schemas, .. } = read_contents(bytes);
    let name = |id: u16| schemas.iter().find(|schema| schema.0 == id).expect("announced").1.clone();
    channels.into_iter().map(|channel| (channel.topic, name(channel.schema_id))).collect()
}

/// Renames phalanx' own schemas to their older names, with one package per message.
fn with_old_schema_names(bytes: &[u8]) -> Vec<u8> {
    let schema = |name: &str, data: &[u8]| {
        let Some(message) = name.strip_prefix("phalanx.") else { return (name.to_string(), data.to_vec()) };
        let package = message.to_lowercase();
        let mut set = FileDescriptorSet::decode(data).expect("descriptors");
        for file in &mut set.file {
            (file.name, file.package) = (Some(format!("{message}.proto")), Some(package.clone()));
        }
        (format!("{package}.{message}"), set.encode_to_vec())
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
    let mut recording = Recording::new(&Schema::from_kind(SceneKind::Finger));
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
        let is_finger = scene == FINGER_SCENE;
        let [a, b] = [&current, &old].map(|path| {
            let layout = if is_finger { Schema::from_kind(SceneKind::Finger) } else { Schema::default() };
            let mut recording = Recording::new(&layout);
            read_file(path, &mut recording).expect("a log");
            recording
        });
        assert!(a.time().len() > if is_finger { 20 } else { 15 });
        assert!(if is_finger { a.column("q21_rad") == b.column("q21_rad") } else { a == b });
        assert_eq!(a.events(), b.events());
        let output = run_json(&["replay", path_text(&old), "--verify", "--json"]);
        assert_eq!(output["verification"]["same"], true);
    }
}
