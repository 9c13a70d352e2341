//! Replays the saved inputs of the fuzz targets, so that earlier failures stay fixed.

#[path = "../fuzz/bodies/log.rs"]
mod log_body;
#[path = "../fuzz/bodies/scene.rs"]
mod scene_body;

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use phalanx::log::{RunInfo, Severity, Writer, metadata};
use phalanx::scene::{Scene, load};
use phalanx::trace::{Model, run};

/// Longest duration of an input. It is far above that of any input on a slow machine, so that only a hang exceeds it.
const MAX_DURATION: Duration = Duration::from_secs(10);

fn files(directory: &str) -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(directory);
    let entries = fs::read_dir(&directory).unwrap_or_else(|error| panic!("{}: {error}", directory.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.retain(|path| path.is_file());
    paths.sort();
    assert!(!paths.is_empty(), "{} is empty", directory.display());
    paths
}

fn replay(directories: &[&str], body: fn(&[u8])) {
    let mut count = 0;
    for path in directories.iter().flat_map(|directory| files(directory)) {
        let bytes = fs::read(&path).expect("an input");
        let start = Instant::now();
        body(&bytes);
        let duration = start.elapsed();
        assert!(duration < MAX_DURATION, "{}: {duration:?}", path.display());
        count += 1;
    }
    println!("{count} inputs");
}

#[test]
fn saved_scenes_are_handled() {
    replay(&["fuzz/corpus/scene", "fuzz/regressions/scene", "../scenes", "broken"], scene_body::scene);
}

#[test]
fn saved_logs_are_handled() {
    replay(&["fuzz/corpus/log", "fuzz/regressions/log"], log_body::log);
}

/// Writes logs of short runs as seeds for the fuzzer: complete, truncated, and without checksums and compression,
/// because these hide the data behind them from a fuzzer. Run it after a change of the log format: `cargo test --test
/// scene fuzz_corpus -- --ignored`.
#[test]
#[ignore = "writes the seeds of the fuzzer"]
fn writes_seeds() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/seeds/log");
    fs::create_dir_all(&directory).expect("made");
    for (name, model, duration_s) in [
        ("experiment-95", Model::Analytic, 2e-4),
        ("experiment-95", Model::Engine, 5e-4),
        ("free-swing", Model::Analytic, 3e-4),
    ] {
        let mut scene = load(format!("scenes/{name}.toml")).expect("a scene");
        scene.duration_s = duration_s;
        let bytes = record_log(&scene, model);
        let path = directory.join(format!("{name}-{}", model.name()));
        fs::write(&path, &bytes).expect("written");
        fs::write(path.with_extension("cut"), &bytes[..2 * bytes.len() / 3]).expect("written");
        fs::write(path.with_extension("bare"), without_compression_and_checksums(&bytes, &scene, model))
            .expect("written");
    }
}

fn record_log(scene: &Scene, model: Model) -> Vec<u8> {
    let info = RunInfo { scene, scene_file: "seed.toml", model: model.name() };
    let mut writer = Writer::new(Vec::new(), "the seed", &info).expect("started");
    run(model, scene, &mut writer).expect("a run");
    writer.note(scene.duration_s, Severity::Info, "run", "completed").expect("written");
    writer.finish().expect("finished")
}

/// Returns a log with the same messages, without compression and checksums.
fn without_compression_and_checksums(bytes: &[u8], scene: &Scene, model: Model) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().compression(None).calculate_chunk_crcs(false);
    let options = options.calculate_data_section_crc(false).calculate_summary_section_crc(false);
    let mut writer = options.calculate_attachment_crcs(false).chunk_size(Some(4096)).create(&mut out).expect("started");
    let info = RunInfo { scene, scene_file: "seed.toml", model: model.name() };
    let record = mcap::write::Metadata { name: "phalanx".to_string(), metadata: metadata(&info) };
    writer.write_metadata(&record).expect("written");
    for message in mcap::MessageStream::new(bytes).expect("a log") {
        let message = message.expect("readable");
        let schema = message.channel.schema.as_ref().expect("a schema");
        let schema = writer.add_schema(&schema.name, &schema.encoding, b"").expect("added");
        let channel_id =
            writer.add_channel(schema, &message.channel.topic, "protobuf", &BTreeMap::new()).expect("added");
        let (sequence, log_time) = (message.sequence, message.log_time);
        let header = mcap::records::MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &message.data).expect("written");
    }
    writer.finish().expect("finished");
    drop(writer);
    out.into_inner()
}
