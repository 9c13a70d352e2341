//! A log is readable while it grows and after a crash, stays small in memory, and refuses paths it cannot have.

use std::cell::RefCell;
use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;
use std::rc::Rc;

use crate::support::synthetic::{sample, scene};
use mcap::{MessageStream, Summary};
use phalanx::log::{CHUNK_BYTES, LogError, RunInfo, Writer, create, partial_name};
use phalanx::scene::Scene;
use phalanx::trace::Sink;

/// What has reached the "disk" of a writer that is still at work.
#[derive(Clone, Default)]
struct Disk(Rc<RefCell<Vec<u8>>>);

impl Write for Disk {
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

/// Times of the `/state` messages that can be read before the log ends or breaks off.
fn states(bytes: &[u8]) -> Vec<u64> {
    match MessageStream::new(bytes) {
        Ok(stream) => stream
            .map_while(Result::ok)
            .filter(|message| message.channel.topic == "/state")
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
fn a_log_cut_anywhere_reads_up_to_its_last_whole_chunk() {
    let bytes = long_log();
    let chunks = Summary::read(&bytes).expect("readable").expect("indexed").chunk_indexes;
    assert!(chunks.len() > 5, "{} chunks", chunks.len());
    assert!(chunks.iter().all(|c| (c.uncompressed_size as usize) < CHUNK_BYTES + 8000));
    let complete = states(&bytes);
    assert_eq!(complete.len(), SAMPLES);
    for cut in (0..bytes.len()).step_by(bytes.len() / 97) {
        // Whole chunks before the cut, by the index of the complete log.
        let last_ns = chunks
            .iter()
            .filter(|chunk| chunk.chunk_start_offset + chunk.chunk_length <= cut as u64)
            .map(|chunk| chunk.message_end_time)
            .max();
        let found = states(&bytes[..cut]);
        match last_ns {
            Some(last_ns) => assert!(found.last().is_some_and(|&end| end >= last_ns), "cut at {cut}"),
            None => assert!(found.len() < SAMPLES / chunks.len() + 1),
        }
        assert_eq!(found, complete[..found.len()], "cut at {cut}");
    }
}

#[test]
fn what_is_written_reaches_the_file_at_chunk_ends_without_finishing() {
    let scene = scene();
    let disk = Disk::default();
    let mut writer = Writer::new(disk.clone(), "the log", &info(&scene)).expect("started");
    // The scene is there before the first sample.
    assert!(disk.0.borrow().windows(9).any(|w| w == b"synthetic"));
    for i in 0..SAMPLES {
        writer.sample(&sample(1e-6 * i as f64)).expect("written");
    }
    let on_disk = disk.0.borrow().clone();
    let readable = states(&on_disk).len();
    // A sample takes five messages of some 100 bytes.
    assert!(readable > SAMPLES - CHUNK_BYTES / 300, "{readable} of {SAMPLES}");
    // Dropping finishes the log.
    drop(writer);
    let on_disk = disk.0.borrow().clone();
    assert_eq!(states(&on_disk).len(), SAMPLES);
    assert!(Summary::read(&on_disk).expect("readable").is_some());
}

/// A disk with room for so many bytes.
struct Full(usize);

impl Write for Full {
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
fn a_full_disk_is_an_error_and_not_a_panic() {
    let scene = scene();
    let mut writer = Writer::new(Full(200_000), "the log run.mcap", &info(&scene)).expect("started");
    let error = (0..SAMPLES).find_map(|i| writer.sample(&sample(1e-6 * i as f64)).err()).expect("the disk is full");
    assert_eq!(error.to_string(), "cannot write the log run.mcap: no space left");
    assert!(writer.finish().is_err());
}

fn directory(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a directory for the test");
    path
}

#[test]
fn paths_that_cannot_be_logged_to_are_refused_with_reason_and_way_out() {
    let scene = scene();
    let dir = directory("log_refusals");
    let refusal = |path: PathBuf| create(&path, &info(&scene)).err().expect("refused");

    let error = refusal(dir.join("nowhere").join("run.mcap"));
    assert!(matches!(error, LogError::NoDirectory { .. }));
    assert!(error.to_string().contains("mkdir -p"), "{error}");

    let error = refusal(dir.clone());
    assert!(matches!(error, LogError::IsDirectory { .. }));
    assert!(error.to_string().contains("run.mcap"), "{error}");

    // A slip of the hand must not cost the scene.
    let scene_file = dir.join("scene.toml");
    fs::write(&scene_file, "name = \"precious\"\n").expect("written");
    let error = refusal(scene_file.clone());
    assert!(matches!(error, LogError::NotALog { .. }));
    assert_eq!(fs::read_to_string(&scene_file).expect("still there"), "name = \"precious\"\n");

    // A parent that is a file.
    let error = refusal(scene_file.join("run.mcap"));
    assert!(matches!(error, LogError::Create { .. }), "{error}");
}

#[test]
fn an_older_log_is_replaced() {
    let scene = scene();
    let path = directory("log_replaced").join("run.mcap");
    let write = |samples: usize| {
        let mut writer = create(&path, &info(&scene)).expect("created");
        for i in 0..samples {
            writer.sample(&sample(1e-4 * i as f64)).expect("written");
        }
        writer
    };
    let there = || states(&fs::read(&path).expect("readable")).len();
    write(100).keep().expect("kept");
    assert_eq!(there(), 100);
    // Until it is kept, and if it never is, the older log stays.
    let partial = partial_name(&path);
    assert_eq!(partial.file_name(), Some("run.mcap.partial".as_ref()));
    let writer = write(10);
    assert!(partial.exists());
    assert_eq!(there(), 100);
    drop(writer);
    assert_eq!(states(&fs::read(&partial).expect("left behind")).len(), 10);
    assert_eq!(there(), 100);
    // What was left behind gives way to the next run.
    write(5).keep().expect("kept");
    assert_eq!(there(), 5);
    assert!(!partial.exists());
}

#[test]
fn two_runs_onto_one_log_are_kept_apart() {
    let scene = scene();
    let path = directory("log_busy").join("run.mcap");
    let mut first = create(&path, &info(&scene)).expect("created");
    let error = create(&path, &info(&scene)).err().expect("refused");
    assert!(matches!(error, LogError::Busy { .. }), "{error}");
    assert!(error.to_string().contains("another run is writing it"), "{error}");
    for i in 0..SAMPLES {
        first.sample(&sample(1e-6 * i as f64)).expect("written");
    }
    first.keep().expect("kept");
    assert_eq!(states(&fs::read(&path).expect("whole")).len(), SAMPLES);
    create(&path, &info(&scene)).expect("free again").keep().expect("kept");
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link() {
    let scene = scene();
    let dir = directory("log_link");
    let (file, link) = (dir.join("real.mcap"), dir.join("link.mcap"));
    create(&file, &info(&scene)).expect("created").keep().expect("kept");
    std::os::unix::fs::symlink("real.mcap", &link).expect("linked");
    let mut writer = create(&link, &info(&scene)).expect("created");
    writer.sample(&sample(0.0)).expect("written");
    writer.keep().expect("kept");
    assert!(link.is_symlink());
    assert_eq!(states(&fs::read(&file).expect("replaced")).len(), 1);
}
