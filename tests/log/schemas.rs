//! Schema names, phalanx' own in the package `phalanx`, Foxglove's in `foxglove`; logs of older versions are rejected.

use std::collections::BTreeMap;

use phalanx::log::{ReadError, read_file};
use phalanx::trace::Model;

use crate::support::cli::assert_rejected;
use crate::support::replay::{DISC_SCENE, FINGER_SCENE, LogContents, log, read_contents};

/// Returns the schema name of every topic.
fn schemas(bytes: &[u8]) -> BTreeMap<String, String> {
    let LogContents { channels, schemas, .. } = read_contents(bytes);
    let name = |id: u16| schemas.iter().find(|schema| schema.0 == id).expect("announced").1.clone();
    channels.into_iter().map(|channel| (channel.topic, name(channel.schema_id))).collect()
}

#[test]
fn schema_names_have_the_expected_package() {
    let actual = schemas(&log(FINGER_SCENE, Model::Analytic, 1e3));
    for (topic, name) in [
        ("/joint/q11", "phalanx.Joint"),
        ("/joint/loop", "phalanx.Joint"),
        ("/actuator/motor", "phalanx.Actuator"),
        ("/contact/distal", "phalanx.Contact"),
        ("/contact/limit", "phalanx.Limit"),
        ("/energy", "phalanx.Energy"),
        ("/event", "phalanx.Event"),
        ("/events", "foxglove.Log"),
        ("/tf", "foxglove.FrameTransforms"),
        ("/forces", "foxglove.SceneUpdate"),
    ] {
        assert_eq!(actual[topic], name);
    }
    let discs = schemas(&log(DISC_SCENE, Model::Analytic, 1e3));
    assert_eq!(discs["/body/hammer"], "phalanx.Body");
    for name in actual.values().chain(discs.values()) {
        assert!(name.starts_with("phalanx.") || name.starts_with("foxglove."), "{name}");
    }
}

/// This log was written by phalanx 0.1.0: `run scenes/experiment-95.toml --duration "2 ms" --numeric-rate "2 kHz"
/// --picture-rate "0 Hz" --log`.
#[test]
fn rejects_a_log_of_an_older_version() {
    let path = "tests/log/phalanx-0.1.mcap";
    let error = read_file(path.as_ref(), &mut ()).expect_err("rejected");
    assert!(matches!(error, ReadError::OtherVersion { .. }), "{error}");
    for mode in [&["--json"][..], &["--verify"], &["--csv", "-"]] {
        let args = [&["replay", path][..], mode].concat();
        assert_rejected(&args, &["a log of phalanx 0.1.0", "read it with phalanx 0.1.0"]);
    }
}
