//! Runs that are killed, interrupted or fill the disk: older files remain, and the partial log is readable.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::cli::{
    EXPERIMENT_95, assert_rejected, assert_status, directory, json, path_text, signal, start, stderr, stdout, succeed,
    write,
};
use crate::support::faults::{LogItems, XorShift, read_bytes, read_path, write_long_hold_scene};
use phalanx::log::{Loss, LossKind, ReadError};

const KILL_COUNT: usize = 200;
const INTERRUPT_COUNT: usize = 40;
/// Maximum random delay after the log has started to grow.
const MAX_DELAY_MS: usize = 60;
const OLDER_LOG: &[u8] = b"\x89MCAP0\r\nthe header of an older phalanx log";

fn start_run(scene: &str, log: &Path) -> Child {
    start(&["run", scene, "--json", "--log", path_text(log)])
}

fn partial(log: &Path) -> PathBuf {
    log.with_extension("mcap.partial")
}

/// Waits until the log of a run contains its metadata.
fn wait_for_file(path: &Path) {
    let deadline = Instant::now() + Duration::from_secs(20);
    while fs::metadata(path).map_or(0, |metadata| metadata.len()) == 0 {
        assert!(Instant::now() < deadline, "{} does not grow", path.display());
        sleep(Duration::from_micros(200));
    }
}

fn wait_for_exit(child: Child) -> Output {
    child.wait_with_output().expect("ends")
}

/// Bytes and contents of the log of the same run without interruption.
fn uninterrupted_run(scene: &str, directory: &Path) -> (Vec<u8>, LogItems) {
    let log = directory.join("undisturbed.mcap");
    succeed(&["run", scene, "--log", path_text(&log)]);
    let (reading, items) = read_path(&log);
    assert!(reading.is_complete() && reading.chunks > 20, "{} chunks", reading.chunks);
    (fs::read(log).expect("the log"), items)
}

#[test]
fn killed_run_leaves_a_log_readable_up_to_its_last_chunk() {
    let directory = directory("faults_kill");
    let scene = write_long_hold_scene(&directory, "2 s", "50 kHz");
    let (bytes, complete_items) = uninterrupted_run(&scene, &directory);
    let index = mcap::Summary::read(&bytes).expect("readable").expect("indexed").chunk_indexes;
    let log = directory.join("run.mcap");
    fs::write(&log, OLDER_LOG).expect("written");
    let mut rng = XorShift::new(9);
    let (mut read, mut finished) = (0, 0);
    for round in 0..KILL_COUNT {
        let _ = fs::remove_file(partial(&log));
        let mut child = start_run(&scene, &log);
        wait_for_file(&partial(&log));
        sleep(Duration::from_micros(1000 * rng.below(MAX_DELAY_MS) as u64));
        child.kill().expect("killed");
        child.wait().expect("ends");
        if !partial(&log).exists() {
            // The run finished before the kill.
            finished += 1;
            fs::write(&log, OLDER_LOG).expect("written");
            continue;
        }
        assert_eq!(fs::read(&log).expect("the older log"), OLDER_LOG, "round {round}");
        let remaining = fs::read(partial(&log)).expect("the partial log");
        assert!(bytes.starts_with(&remaining), "round {round}: not the beginning of the log");
        match read_bytes(&remaining) {
            (Ok(reading), items) => {
                items.assert_prefix_of(&complete_items, &format!("round {round}"));
                let is_written = |end: u64| end <= remaining.len() as u64;
                let chunks =
                    index.iter().filter(|chunk| is_written(chunk.chunk_start_offset + chunk.chunk_length)).count();
                assert_eq!(reading.chunks as usize, chunks, "round {round}");
                assert!(matches!(reading.losses[..], [Loss { kind: LossKind::Truncated, .. }]), "{:?}", reading.losses);
                read += usize::from(!items.0.is_empty());
            }
            (Err(ReadError::Empty { .. }), _) => {}
            (Err(error), _) => panic!("round {round}: {error}"),
        }
    }
    assert!(finished < KILL_COUNT / 10, "{finished} of {KILL_COUNT} were too late");
    assert!(read > KILL_COUNT / 2, "{read} of {KILL_COUNT} had samples");
    println!("faults: {} kills, {read} of them with samples in the log", KILL_COUNT - finished);

    // `replay` mentions the partial log.
    assert_rejected(&["replay", directory.join("gone.mcap").to_str().expect("text")], &[]);
    fs::write(directory.join("gone.mcap.partial"), &bytes[..bytes.len() / 2]).expect("written");
    assert_rejected(&["replay", directory.join("gone.mcap").to_str().expect("text")], &["gone.mcap.partial"]);
}

#[test]
fn interrupted_run_finishes_its_log() {
    let directory = directory("faults_interrupt");
    let scene = write_long_hold_scene(&directory, "2 s", "50 kHz");
    let (_, complete_items) = uninterrupted_run(&scene, &directory);
    let log = directory.join("run.mcap");
    let mut rng = XorShift::new(17);
    for round in 0..INTERRUPT_COUNT {
        let _ = fs::remove_file(&log);
        let child = start_run(&scene, &log);
        wait_for_file(&partial(&log));
        sleep(Duration::from_micros(1000 * rng.below(MAX_DELAY_MS) as u64));
        let name = ["INT", "TERM", "HUP"][round % 3];
        signal(&child, name);
        let output = wait_for_exit(child);
        assert_eq!(output.status.code(), Some(3), "round {round}: {}", stderr(&output));
        let message = stderr(&output);
        assert!(message.contains(&format!("interrupted by SIG{name}")) && message.contains("of 2 s"), "{message}");
        let run = json(&output);
        assert_eq!(run["completed"], false);
        assert!(!partial(&log).exists());
        let (reading, mut items) = read_path(&log);
        assert!(reading.is_complete(), "{:?}", reading.losses);
        let run_end = reading.run_end.expect("a run end");
        assert!(run_end.stopped.is_some_and(|reason| reason.contains("interrupted")));
        // The last sample is at the time of the interrupt, not necessarily on the grid.
        items.0.pop();
        items.assert_prefix_of(&complete_items, &format!("round {round}"));
    }
    println!("faults: {INTERRUPT_COUNT} interrupts");
}

#[test]
fn interrupts_a_run_without_log_and_with_rare_samples() {
    let directory = directory("faults_seldom");
    // A free swing never comes to rest, so the run takes small steps for minutes and samples are rare.
    let text = fs::read_to_string("scenes/free-swing.toml").expect("the scene");
    let scene = write(&directory, "seldom.toml", &format!("{text}\n[log]\nnumeric_rate = \"0.01 Hz\"\n"));
    for model in ["engine", "analytic"] {
        let child = start(&["run", &scene, "--duration", "50 s", "--model", model]);
        sleep(Duration::from_millis(300));
        signal(&child, "INT");
        let start = Instant::now();
        let output = wait_for_exit(child);
        assert!(start.elapsed() < Duration::from_secs(3), "{:?}", start.elapsed());
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
        assert!(stdout(&output).contains("NOT COMPLETED"), "{}", stdout(&output));
        assert!(stderr(&output).contains("interrupted by SIGINT"), "{}", stderr(&output));
    }
}

#[test]
fn interrupted_validation_keeps_older_files() {
    let out = directory("faults_validate_interrupt");
    let older = older_validation(&out);
    let child = start(&["validate", EXPERIMENT_95, "--out", path_text(&out)]);
    sleep(Duration::from_millis(250));
    signal(&child, "TERM");
    let output = wait_for_exit(child);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(stderr(&output).contains("interrupted by SIGTERM"), "{}", stderr(&output));
    assert!(read_directory(&out) == older);
}

/// Writes the files of a validation and returns them by name.
fn older_validation(out: &Path) -> BTreeMap<String, Vec<u8>> {
    succeed(&["validate", "scenes/free-swing.toml", "--quick", "--out", path_text(out)]);
    let files = read_directory(out);
    assert_eq!(files.len(), 9);
    files
}

fn read_directory(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let read = |path: PathBuf| (path.display().to_string(), fs::read(&path).expect("a file"));
    fs::read_dir(directory).expect("readable").map(|entry| read(entry.expect("readable").path())).collect()
}

/// Runs the command with a maximum file size in blocks of 512 bytes, to simulate a full disk.
fn run_with_file_size_limit(blocks: usize, args: &[&str]) -> Output {
    let script = format!("ulimit -f {blocks}; exec \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_phalanx")]).args(args);
    command.output().expect("sh is installed")
}

#[test]
fn full_disk_is_reported_and_keeps_the_older_log() {
    let directory = directory("faults_full");
    let scene = write_long_hold_scene(&directory, "200 ms", "50 kHz");
    let (bytes, complete_items) = uninterrupted_run(&scene, &directory);
    let log = directory.join("run.mcap");
    let path = path_text(&log);
    fs::write(&log, OLDER_LOG).expect("written");
    let required_blocks = bytes.len() / 512;
    let mut last = 0;
    let fractions = [1, 2, 4, 6, 8].map(|eighths| required_blocks * eighths / 8);
    let quotas = [&[1, 4, 10][..], &fractions].concat();
    for &quota in &quotas {
        let output = run_with_file_size_limit(quota, &["run", &scene, "--log", path]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(3), "{quota} blocks: {message}");
        assert!(message.contains("cannot write the log") && message.contains("File too large"), "{message}");
        assert_eq!(fs::read(&log).expect("the older log"), OLDER_LOG, "{quota} blocks");
        let Ok(remaining) = fs::read(partial(&log)) else {
            // Without the head of the log, no partial file remains.
            assert!(quota < required_blocks / 8, "{quota} blocks");
            continue;
        };
        assert!(message.contains("run.mcap.partial"), "{message}");
        assert!(remaining.len() <= 512 * quota && bytes.starts_with(&remaining), "{quota} blocks");
        let (reading, items) = read_bytes(&remaining);
        assert!(!reading.expect("the beginning of a log").is_complete(), "{quota} blocks");
        items.assert_prefix_of(&complete_items, &format!("{quota} blocks"));
        let has_third = items.sample_count() * 3 > complete_items.sample_count();
        assert!(has_third || quota < required_blocks / 2, "{quota} blocks");
        last = quota;
    }
    assert_eq!(last, required_blocks);
    // With enough space, the next run replaces the partial log.
    succeed(&["run", &scene, "--log", path]);
    assert!(fs::read(&log).expect("the log") == bytes && !partial(&log).exists());
    println!("faults: {} file size limits", quotas.len());
}

#[test]
fn writes_to_full_and_null_devices() {
    if !Path::new("/dev/full").exists() {
        println!("not tested: /dev/full does not exist");
        return;
    }
    assert_status(&["run", EXPERIMENT_95, "--log", "/dev/full"], 3, &["cannot write the log /dev/full: No space left"]);
    succeed(&["run", EXPERIMENT_95, "--log", "/dev/null"]);
    assert!(Path::new("/dev/null").exists() && !Path::new("/dev/null.partial").exists());
    // A run fails if the device of its standard output is full.
    let full_device = fs::OpenOptions::new().write(true).open("/dev/full").expect("writable");
    let status = Command::new(env!("CARGO_BIN_EXE_phalanx")).args(["run", EXPERIMENT_95]).stdout(full_device).output();
    assert_eq!(status.expect("runs").status.code(), Some(3));
}

#[test]
fn full_file_system_keeps_the_older_log() {
    let directory = directory("faults_tmpfs");
    let scene = fs::canonicalize(write_long_hold_scene(&directory, "2 s", "50 kHz")).expect("a path");
    let disk = directory.join("disk");
    fs::create_dir(&disk).expect("made");
    let binary = env!("CARGO_BIN_EXE_phalanx");
    let script = format!(
        "mount -t tmpfs -o size=256k tmpfs '{disk}' || exit 77
         printf 'older' > '{disk}/note'
         '{binary}' run '{EXPERIMENT_95}' --duration '2 ms' --log '{disk}/run.mcap' > /dev/null || exit 1
         cp '{disk}/run.mcap' '{copy}'
         '{binary}' run '{scene}' --log '{disk}/run.mcap' > /dev/null
         echo \"status $?\"
         cmp '{disk}/run.mcap' '{copy}' && echo 'older log intact'
         cp '{disk}/run.mcap.partial' '{remaining}'",
        disk = disk.display(),
        scene = scene.display(),
        copy = directory.join("older.mcap").display(),
        remaining = directory.join("left.mcap").display(),
    );
    let output = Command::new("unshare").args(["-rm", "sh", "-c", &script]).output();
    let output = match output {
        Ok(output) if !stderr(&output).contains("unshare") && output.status.code() != Some(77) => output,
        _ => {
            println!("not tested: a file system cannot be mounted here");
            return;
        }
    };
    let (output_text, message) = (stdout(&output), stderr(&output));
    assert!(output_text.contains("status 3") && output_text.contains("older log intact"), "{output_text}\n{message}");
    assert!(message.contains("No space left on device") && message.contains("run.mcap.partial"), "{message}");
    let (reading, items) = read_path(&directory.join("left.mcap"));
    assert!(items.sample_count() > 100 && !reading.is_complete());
    println!("faults: 1 file system that filled up, {} samples read", items.sample_count());
}

#[test]
fn rejects_an_unwritable_directory() {
    use std::os::unix::fs::PermissionsExt;
    let directory = directory("faults_unwritable");
    fs::set_permissions(&directory, fs::Permissions::from_mode(0o555)).expect("set");
    let probe = fs::write(directory.join("probe"), "");
    let unwritable = if probe.is_err() { directory.clone() } else { PathBuf::from("/sys") };
    if !unwritable.exists() {
        println!("not tested: all directories are writable");
        return;
    }
    let log = unwritable.join("run.mcap");
    assert_rejected(
        &["run", EXPERIMENT_95, "--log", path_text(&log)],
        &["give a file in a directory where you may write"],
    );
    assert_rejected(&["validate", EXPERIMENT_95, "--quick", "--out", path_text(&unwritable)], &[]);
    fs::set_permissions(&directory, fs::Permissions::from_mode(0o755)).expect("set");
}

#[test]
fn full_disk_during_validation_keeps_the_older_report() {
    let out = directory("faults_validate_full");
    let older = older_validation(&out);
    // The limit is too small for any picture.
    let path = path_text(&out);
    let output = run_with_file_size_limit(4, &["validate", "scenes/free-swing.toml", "--quick", "--out", path]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot write") && stderr(&output).contains(".svg"), "{}", stderr(&output));
    assert!(read_directory(&out) == older);
}

#[test]
fn rejects_a_second_run_with_the_same_log() {
    let directory = directory("faults_busy");
    let scene = write_long_hold_scene(&directory, "50 s", "50 kHz");
    let log = directory.join("run.mcap");
    let first = start_run(&scene, &log);
    wait_for_file(&partial(&log));
    assert_rejected(&["run", EXPERIMENT_95, "--log", path_text(&log)], &["another run is writing it"]);
    sleep(Duration::from_millis(100));
    signal(&first, "INT");
    assert_eq!(wait_for_exit(first).status.code(), Some(3));
    let (reading, items) = read_path(&log);
    assert!(reading.is_complete() && items.sample_count() > 1000);
    assert_eq!(reading.metadata["duration_s"], "50.0");
}

fn make_fifo(directory: &Path) -> PathBuf {
    let make_fifo = directory.join("run.mcap");
    assert!(Command::new("mkfifo").arg(&make_fifo).status().expect("mkfifo is installed").success());
    make_fifo
}

#[test]
fn writes_a_log_to_a_pipe() {
    let directory = directory("faults_pipe");
    let make_fifo = make_fifo(&directory);
    let copy = directory.join("copy");
    let out = fs::File::create(&copy).expect("made");
    let mut reader = Command::new("cat").arg(&make_fifo).stdout(out).spawn().expect("cat is installed");
    succeed(&["run", EXPERIMENT_95, "--log", path_text(&make_fifo)]);
    assert!(reader.wait().expect("ends").success());
    assert!(read_bytes(&fs::read(copy).expect("readable")).0.expect("a log").is_complete());
    assert!(!partial(&make_fifo).exists());
}

#[test]
fn second_interrupt_kills_immediately() {
    use std::os::unix::process::ExitStatusExt;
    let directory = directory("faults_twice");
    // This pipe has no reader, so the run blocks when opening it.
    let mut child = start_run(EXPERIMENT_95, &make_fifo(&directory));
    sleep(Duration::from_millis(300));
    signal(&child, "INT");
    sleep(Duration::from_millis(300));
    assert!(child.try_wait().expect("status").is_none(), "the first signal only requests a stop");
    signal(&child, "INT");
    assert_eq!(wait_for_exit(child).status.signal(), Some(2));
}
