//! Logs are readable while they grow and after a crash, need little memory, and reject invalid paths.

use std::cell::RefCell;
use std::fs;
use std::io::{self, Write};
use std::rc::Rc;

use crate::support::cli::directory;
use crate::support::synthetic::{sample, scene};
use mcap::{MessageStream, Summary};
use phalanx::log::{CHUNK_BYTES, LogError, RunInfo, Writer, create, partial_name};
use phalanx::scene::Scene;
use phalanx::trace::Sink;

/// Bytes written so far by a writer that is still open.
#[derive(Clone, Default)]
struct SharedBuffer(Rc<RefCell<Vec<u8>>>);

impl Write for SharedBuffer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn info(scene: &Scene) -> RunInfo<'_> {
    RunInfo { scene, scene_file: "synthetic.toml", model: "analytic" }
}

/// Log times of the readable `/joint/q11` messages.
fn read_state_times(bytes: &[u8]) -> Vec<u64> {
    match MessageStream::new(bytes) {
        Ok(stream) => stream
            .map_while(Result::ok)
            .filter(|message| message.channel.topic == "/joint/q11")
            .map(|message| message.log_time)
            .collect(),
        Err(_) => Vec::new(),
    }
}

const SAMPLES: usize = 5_000;

fn long_log() -> Vec<u8> {
    let scene = scene();
    let mut writer = Writer::new(Vec::new(), "the log", &info(&scene)).expect("started");
    for i in 0..SAMPLES {
        writer.sample(&sample(1e-6 * i as f64)).expect("written");
    }
    writer.finish().expect("finished")
}

#[test]
fn truncated_log_is_readable_up_to_its_last_complete_chunk() {
    let bytes = long_log();
    let chunks = Summary::read(&bytes).expect("readable").expect("indexed").chunk_indexes;
    assert!(chunks.len() > 5, "{} chunks", chunks.len());
    assert!(chunks.iter().all(|c| (c.uncompressed_size as usize) < CHUNK_BYTES + 8000));
    let complete = read_state_times(&bytes);
    assert_eq!(complete.len(), SAMPLES);
    for length in (0..bytes.len()).step_by(bytes.len() / 97) {
        // Last time in complete chunks before the cut, from the index of the complete log.
        let last_ns = chunks
            .iter()
            .filter(|chunk| chunk.chunk_start_offset + chunk.chunk_length <= length as u64)
            .map(|chunk| chunk.message_end_time)
            .max();
        let times = read_state_times(&bytes[..length]);
        match last_ns {
            Some(last_ns) => assert!(times.last().is_some_and(|&end| end >= last_ns), "cut at {length}"),
            None => assert!(times.len() < SAMPLES / chunks.len() + 1),
        }
        assert_eq!(times, complete[..times.len()], "cut at {length}");
    }
}

#[test]
fn chunks_reach_the_file_before_the_log_is_finished() {
    let scene = scene();
    let shared = SharedBuffer::default();
    let mut writer = Writer::new(shared.clone(), "the log", &info(&scene)).expect("started");
    // The scene is written before the first sample.
    assert!(shared.0.borrow().windows(9).any(|w| w == b"synthetic"));
    for i in 0..SAMPLES {
        writer.sample(&sample(1e-6 * i as f64)).expect("written");
    }
    let on_disk = shared.0.borrow().clone();
    let readable = read_state_times(&on_disk).len();
    // A sample takes ten messages of some 80 bytes.
    assert!(readable > SAMPLES - CHUNK_BYTES / 300, "{readable} of {SAMPLES}");
    // Dropping finishes the log.
    drop(writer);
    let on_disk = shared.0.borrow().clone();
    assert_eq!(read_state_times(&on_disk).len(), SAMPLES);
    assert!(Summary::read(&on_disk).expect("readable").is_some());
}

/// A disk with this many free bytes.
struct FullDisk(usize);

impl Write for FullDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if bytes.len() > self.0 {
            return Err(io::Error::new(io::ErrorKind::StorageFull, "no space left"));
        }
        self.0 -= bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn full_disk_is_an_error() {
    let scene = scene();
    let mut writer = Writer::new(FullDisk(200_000), "the log run.mcap", &info(&scene)).expect("started");
    let error = (0..SAMPLES).find_map(|i| writer.sample(&sample(1e-6 * i as f64)).err()).expect("the disk is full");
    assert_eq!(error.to_string(), "cannot write the log run.mcap: no space left");
    assert!(writer.finish().is_err());
}

#[test]
fn rejects_invalid_paths_with_reason_and_remedy() {
    let scene = scene();
    let dir = directory("log_refusals");
    // A mistyped path must not overwrite the scene.
    let scene_file = dir.join("scene.toml");
    fs::write(&scene_file, "name = \"precious\"\n").expect("written");
    for (path, part) in [
        (dir.join("nowhere").join("run.mcap"), "mkdir -p"),
        (dir.clone(), "run.mcap"),
        (scene_file.clone(), "not an MCAP log written by phalanx"),
        (scene_file.join("run.mcap"), "give a writable path"),
    ] {
        let error = create(&path, &info(&scene)).err().expect("rejected").to_string();
        assert!(error.starts_with("cannot write the log ") && error.contains(part), "{error}");
    }
    assert_eq!(fs::read_to_string(&scene_file).expect("the file is unchanged"), "name = \"precious\"\n");
}

#[test]
fn replaces_an_older_log() {
    let scene = scene();
    let path = directory("log_replaced").join("run.mcap");
    let write = |samples: usize| {
        let mut writer = create(&path, &info(&scene)).expect("created");
        for i in 0..samples {
            writer.sample(&sample(1e-4 * i as f64)).expect("written");
        }
        writer
    };
    let stored_samples = || read_state_times(&fs::read(&path).expect("readable")).len();
    write(100).commit().expect("renamed");
    assert_eq!(stored_samples(), 100);
    // The older log remains until the new one is committed.
    let partial = partial_name(&path);
    assert_eq!(partial.file_name(), Some("run.mcap.partial".as_ref()));
    let writer = write(10);
    assert!(partial.exists());
    assert_eq!(stored_samples(), 100);
    drop(writer);
    assert_eq!(read_state_times(&fs::read(&partial).expect("left behind")).len(), 10);
    assert_eq!(stored_samples(), 100);
    // The next run replaces the abandoned partial log.
    write(5).commit().expect("renamed");
    assert_eq!(stored_samples(), 5);
    assert!(!partial.exists());
}

#[test]
fn rejects_concurrent_runs_with_the_same_log() {
    let scene = scene();
    let path = directory("log_busy").join("run.mcap");
    let mut first = create(&path, &info(&scene)).expect("created");
    let error = create(&path, &info(&scene)).err().expect("rejected");
    assert!(matches!(error, LogError::Busy { .. }), "{error}");
    assert!(error.to_string().contains("another run is writing it"), "{error}");
    for i in 0..SAMPLES {
        first.sample(&sample(1e-6 * i as f64)).expect("written");
    }
    first.commit().expect("renamed");
    assert_eq!(read_state_times(&fs::read(&path).expect("whole")).len(), SAMPLES);
    create(&path, &info(&scene)).expect("free again").commit().expect("renamed");
}

#[cfg(unix)]
#[test]
fn symbolic_link_remains_a_link() {
    let scene = scene();
    let dir = directory("log_link");
    let (file, link) = (dir.join("real.mcap"), dir.join("link.mcap"));
    create(&file, &info(&scene)).expect("created").commit().expect("renamed");
    std::os::unix::fs::symlink("real.mcap", &link).expect("linked");
    let mut writer = create(&link, &info(&scene)).expect("created");
    writer.sample(&sample(0.0)).expect("written");
    writer.commit().expect("renamed");
    assert!(link.is_symlink());
    assert_eq!(read_state_times(&fs::read(&file).expect("replaced")).len(), 1);
}
