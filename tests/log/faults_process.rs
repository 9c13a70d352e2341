//! Runs that are killed, interrupted, or given too small a disk: older files stay, and what was logged can be read.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, write};
use crate::support::faults::{Dice, Items, long_hold, read_bytes, read_path};
use phalanx::log::{Loss, ReadError};

const KILLS: usize = 200;
const INTERRUPTS: usize = 40;
/// Moments are chosen within this time from when the log has begun to grow.
const WITHIN_MS: usize = 60;
const OLDER: &[u8] = b"\x89MCAP0\r\nan older log of phalanx, as far as anybody looks";

fn start(scene: &str, log: &Path) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    command.args(["run", scene, "--json", "--log"]).arg(log);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary starts")
}

fn partial(log: &Path) -> PathBuf {
    log.with_extension("mcap.partial")
}

/// Waits until the log of a run is there with its metadata.
fn wait_for(path: &Path) {
    let patience = Instant::now() + Duration::from_secs(20);
    while fs::metadata(path).map_or(0, |found| found.len()) == 0 {
        assert!(Instant::now() < patience, "{} does not grow", path.display());
        sleep(Duration::from_micros(200));
    }
}

fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status();
    assert!(status.expect("kill is there").success());
}

fn ends(mut child: Child) -> Output {
    let mut output = Output { status: child.wait().expect("ends"), stdout: Vec::new(), stderr: Vec::new() };
    child.stdout.take().expect("piped").read_to_end(&mut output.stdout).expect("read");
    child.stderr.take().expect("piped").read_to_end(&mut output.stderr).expect("read");
    output
}

/// The log of the same run left alone: its bytes, and what is read from it.
fn undisturbed(scene: &str, directory: &Path) -> (Vec<u8>, Items) {
    let log = directory.join("undisturbed.mcap");
    let output = phalanx(&["run", scene, "--log", log.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let (reading, items) = read_path(&log);
    assert!(reading.is_whole() && reading.chunks > 20, "{} chunks", reading.chunks);
    (fs::read(log).expect("the log"), items)
}

#[test]
fn killed_at_any_moment_the_log_reads_up_to_its_last_chunk() {
    let directory = directory("faults_kill");
    let scene = long_hold(&directory, "2 s", "50 kHz");
    let (bytes, whole) = undisturbed(&scene, &directory);
    let index = mcap::Summary::read(&bytes).expect("readable").expect("indexed").chunk_indexes;
    let log = directory.join("run.mcap");
    fs::write(&log, OLDER).expect("written");
    let mut dice = Dice::new(9);
    let (mut read, mut finished) = (0, 0);
    for round in 0..KILLS {
        let _ = fs::remove_file(partial(&log));
        let mut child = start(&scene, &log);
        wait_for(&partial(&log));
        sleep(Duration::from_micros(1000 * dice.below(WITHIN_MS) as u64));
        child.kill().expect("killed");
        child.wait().expect("ends");
        if !partial(&log).exists() {
            // The run was over before the kill.
            finished += 1;
            fs::write(&log, OLDER).expect("written");
            continue;
        }
        assert_eq!(fs::read(&log).expect("the older log"), OLDER, "round {round}");
        let left = fs::read(partial(&log)).expect("the partial log");
        assert!(bytes.starts_with(&left), "round {round}: not the beginning of the log");
        match read_bytes(&left) {
            (Ok(reading), items) => {
                items.assert_prefix_of(&whole, &format!("round {round}"));
                let ended = |end: u64| end <= left.len() as u64;
                let chunks = index.iter().filter(|chunk| ended(chunk.chunk_start_offset + chunk.chunk_length)).count();
                assert_eq!(reading.chunks as usize, chunks, "round {round}");
                assert!(matches!(reading.losses[..], [Loss::Truncated { .. }]), "{:?}", reading.losses);
                read += usize::from(!items.0.is_empty());
            }
            (Err(ReadError::Empty { .. }), _) => {}
            (Err(error), _) => panic!("round {round}: {error}"),
        }
    }
    assert!(finished < KILLS / 10, "{finished} of {KILLS} were too late");
    assert!(read > KILLS / 2, "{read} of {KILLS} had samples");
    println!("faults: {} kills, {read} of them with samples in the log", KILLS - finished);

    // The command finds what was left.
    let output = phalanx(&["replay", directory.join("gone.mcap").to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(2));
    fs::write(directory.join("gone.mcap.partial"), &bytes[..bytes.len() / 2]).expect("written");
    let output = phalanx(&["replay", directory.join("gone.mcap").to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("gone.mcap.partial"), "{}", stderr(&output));
}

#[test]
fn interrupted_at_any_moment_the_log_is_finished() {
    let directory = directory("faults_interrupt");
    let scene = long_hold(&directory, "2 s", "50 kHz");
    let (_, whole) = undisturbed(&scene, &directory);
    let log = directory.join("run.mcap");
    let mut dice = Dice::new(17);
    for round in 0..INTERRUPTS {
        let _ = fs::remove_file(&log);
        let child = start(&scene, &log);
        wait_for(&partial(&log));
        sleep(Duration::from_micros(1000 * dice.below(WITHIN_MS) as u64));
        let name = ["INT", "TERM", "HUP"][round % 3];
        signal(&child, name);
        let output = ends(child);
        assert_eq!(output.status.code(), Some(3), "round {round}: {}", stderr(&output));
        let message = stderr(&output);
        assert!(message.contains(&format!("interrupted by SIG{name}")) && message.contains("of 2 s"), "{message}");
        let run = json(&output);
        assert_eq!(run["completed"], false);
        assert!(!partial(&log).exists());
        let (reading, mut items) = read_path(&log);
        assert!(reading.is_whole(), "{:?}", reading.losses);
        let ended = reading.ended.expect("said");
        assert!(ended.stopped.is_some_and(|reason| reason.contains("interrupted")));
        // The last sample is where the run was, on the grid or not.
        items.0.pop();
        items.assert_prefix_of(&whole, &format!("round {round}"));
    }
    println!("faults: {INTERRUPTS} interrupts");
}

#[test]
fn a_run_that_logs_nothing_and_samples_seldom_is_interrupted_too() {
    let directory = directory("faults_seldom");
    // A free swing never comes to rest: minutes of small steps, and not one sample on the way.
    let text = fs::read_to_string("scenes/free-swing.toml").expect("the scene");
    let scene = write(&directory, "seldom.toml", &format!("{text}\n[log]\nnumeric_rate = \"0.01 Hz\"\n"));
    for model in [["--model", "engine"], ["--model", "analytic"]] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        command.args(["run", &scene, "--duration", "50 s"]).args(model).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().expect("the binary starts");
        sleep(Duration::from_millis(300));
        signal(&child, "INT");
        let start = Instant::now();
        let output = ends(child);
        assert!(start.elapsed() < Duration::from_secs(3), "{:?}", start.elapsed());
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
        assert!(stdout(&output).contains("NOT COMPLETED"), "{}", stdout(&output));
        assert!(stderr(&output).contains("interrupted by SIGINT"), "{}", stderr(&output));
    }
}

#[test]
fn an_interrupted_validation_leaves_what_was_there() {
    let out = directory("faults_validate_interrupt");
    let older = older_validation(&out);
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    command.args(["validate", ANCHOR, "--out"]).arg(&out).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().expect("the binary starts");
    sleep(Duration::from_millis(250));
    signal(&child, "TERM");
    let output = ends(child);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(stderr(&output).contains("interrupted by SIGTERM"), "{}", stderr(&output));
    assert!(contents(&out) == older);
}

#[test]
fn what_a_killed_process_left_is_removed_by_the_next_and_no_other() {
    let out = directory("faults_stale");
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    let mut killed =
        command.args(["reproduce", "--threads", "1", "--out"]).arg(&out).spawn().expect("the binary starts");
    wait_for(&out);
    let left = || fs::read_dir(&out).expect("there").map(|entry| entry.expect("readable").path()).collect::<Vec<_>>();
    let patience = Instant::now() + Duration::from_secs(20);
    while left().is_empty() {
        assert!(Instant::now() < patience, "no directory for files until all are there");
    }
    let page = out.join("page.html");
    let [stale, living] = ["abcdef", "ghijkl"].map(|by| out.join(format!(".page.html.phalanx-{by}.tmp")));
    fs::write(&stale, "").expect("written");
    let held = fs::File::create(&living).expect("made");
    held.lock().expect("locked");
    let run = || phalanx(&["run", ANCHOR, "--html", page.to_str().expect("text")]).status.success();
    assert!(run() && living.exists() && !stale.exists());
    drop(held);
    assert!(run());
    let size = || phalanx(&["size", ANCHOR, "--out", out.to_str().expect("text")]);
    assert_eq!((size().status.code(), left().iter().filter(|path| path.is_dir()).count()), (Some(0), 1), "it lives");
    killed.kill().and_then(|()| killed.wait()).expect("killed");
    assert_eq!(size().status.code(), Some(0));
    assert!(left().iter().all(|path| path.extension().is_none_or(|ending| ending != "tmp")), "{:?}", left());
}

/// The files of a validation, by their names.
fn older_validation(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let output = phalanx(&["validate", "scenes/free-swing.toml", "--quick", "--out", out.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let found = contents(out);
    assert_eq!(found.len(), 10, "nine files and their checksums");
    found
}

fn contents(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let read = |path: PathBuf| (path.display().to_string(), fs::read(&path).expect("a file"));
    fs::read_dir(directory).expect("there").map(|entry| read(entry.expect("readable").path())).collect()
}

/// Runs the command where no file may become longer than so many blocks of 512 bytes, as on a full disk.
fn limited(blocks: usize, args: &[&str]) -> Output {
    let script = format!("ulimit -f {blocks}; exec \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_phalanx")]).args(args);
    command.output().expect("sh is there")
}

#[test]
fn a_full_disk_is_said_and_costs_no_older_log() {
    let directory = directory("faults_full");
    let scene = long_hold(&directory, "200 ms", "50 kHz");
    let (bytes, whole) = undisturbed(&scene, &directory);
    let log = directory.join("run.mcap");
    let path = log.to_str().expect("text");
    fs::write(&log, OLDER).expect("written");
    let room = bytes.len() / 512;
    let mut last = 0;
    let quotas = [1, 4, 10, room / 8, room / 4, room / 2, room * 3 / 4, room];
    for quota in quotas {
        let output = limited(quota, &["run", &scene, "--log", path]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(3), "{quota} blocks: {message}");
        assert!(message.contains("cannot write the log") && message.contains("File too large"), "{message}");
        assert_eq!(fs::read(&log).expect("the older log"), OLDER, "{quota} blocks");
        let Ok(left) = fs::read(partial(&log)) else {
            // Not even the beginning of a log: nothing is left lying about.
            assert!(quota < room / 8, "{quota} blocks");
            continue;
        };
        assert!(message.contains("run.mcap.partial"), "{message}");
        assert!(left.len() <= 512 * quota && bytes.starts_with(&left), "{quota} blocks");
        let (reading, items) = read_bytes(&left);
        assert!(!reading.expect("the beginning of a log").is_whole(), "{quota} blocks");
        items.assert_prefix_of(&whole, &format!("{quota} blocks"));
        assert!(items.samples() * 3 > whole.samples() || quota < room / 2, "{quota} blocks");
        last = quota;
    }
    assert_eq!(last, room);
    // Once there is room again, what was left behind is in nobody's way.
    let output = phalanx(&["run", &scene, "--log", path]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(fs::read(&log).expect("the log") == bytes && !partial(&log).exists());
    println!("faults: {} file size limits", quotas.len());
}

#[test]
fn a_device_that_is_full_and_one_that_takes_everything() {
    if !Path::new("/dev/full").exists() {
        println!("not tested: there is no /dev/full");
        return;
    }
    let output = phalanx(&["run", ANCHOR, "--log", "/dev/full"]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot write the log /dev/full: No space left"), "{}", stderr(&output));
    let output = phalanx(&["run", ANCHOR, "--log", "/dev/null"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(Path::new("/dev/null").exists() && !Path::new("/dev/null.partial").exists());
    // A full standard output.
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("there");
    let status = Command::new(env!("CARGO_BIN_EXE_phalanx")).args(["run", ANCHOR]).stdout(full).output();
    assert_eq!(status.expect("runs").status.code(), Some(3));
}

#[test]
fn a_file_system_of_256_kib() {
    let directory = directory("faults_tmpfs");
    let scene = fs::canonicalize(long_hold(&directory, "2 s", "50 kHz")).expect("there");
    let disk = directory.join("disk");
    fs::create_dir(&disk).expect("made");
    let binary = env!("CARGO_BIN_EXE_phalanx");
    let script = format!(
        "mount -t tmpfs -o size=256k tmpfs '{disk}' || exit 77
         printf 'older' > '{disk}/note'
         '{binary}' run '{ANCHOR}' --duration '2 ms' --log '{disk}/run.mcap' > /dev/null || exit 1
         cp '{disk}/run.mcap' '{copy}'
         '{binary}' run '{scene}' --log '{disk}/run.mcap' > /dev/null
         echo \"status $?\"
         cmp '{disk}/run.mcap' '{copy}' && echo 'older log intact'
         cp '{disk}/run.mcap.partial' '{left}'",
        disk = disk.display(),
        scene = scene.display(),
        copy = directory.join("older.mcap").display(),
        left = directory.join("left.mcap").display(),
    );
    let output = Command::new("unshare").args(["-rm", "sh", "-c", &script]).output();
    let output = match output {
        Ok(output) if !stderr(&output).contains("unshare") && output.status.code() != Some(77) => output,
        _ => {
            println!("not tested: a file system cannot be mounted here");
            return;
        }
    };
    let (said, message) = (stdout(&output), stderr(&output));
    assert!(said.contains("status 3") && said.contains("older log intact"), "{said}\n{message}");
    assert!(message.contains("No space left on device") && message.contains("run.mcap.partial"), "{message}");
    let (reading, items) = read_path(&directory.join("left.mcap"));
    assert!(items.samples() > 100 && !reading.is_whole());
    println!("faults: 1 file system that filled up, {} samples read", items.samples());
}

#[test]
fn a_directory_where_nothing_may_be_written() {
    use std::os::unix::fs::PermissionsExt;
    let directory = directory("faults_unwritable");
    fs::set_permissions(&directory, fs::Permissions::from_mode(0o555)).expect("set");
    let probe = fs::write(directory.join("probe"), "");
    let unwritable = if probe.is_err() { directory.clone() } else { PathBuf::from("/sys") };
    if !unwritable.exists() {
        println!("not tested: everything can be written here");
        return;
    }
    let log = unwritable.join("run.mcap");
    let output = phalanx(&["run", ANCHOR, "--log", log.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("give a path where you may write"), "{}", stderr(&output));
    let output = phalanx(&["validate", ANCHOR, "--quick", "--out", unwritable.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    fs::set_permissions(&directory, fs::Permissions::from_mode(0o755)).expect("set");
}

#[test]
fn a_disk_that_fills_up_under_a_validation_costs_no_older_report() {
    let out = directory("faults_validate_full");
    let older = older_validation(&out);
    // No picture fits.
    let path = out.to_str().expect("text");
    let output = limited(4, &["validate", "scenes/free-swing.toml", "--quick", "--out", path]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(stderr(&output).contains("cannot write") && stderr(&output).contains(".svg"), "{}", stderr(&output));
    assert!(contents(&out) == older);
}

#[test]
fn a_second_run_onto_the_same_log_is_refused_and_harms_nothing() {
    let directory = directory("faults_busy");
    let scene = long_hold(&directory, "50 s", "50 kHz");
    let log = directory.join("run.mcap");
    let first = start(&scene, &log);
    wait_for(&partial(&log));
    let output = phalanx(&["run", ANCHOR, "--log", log.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("another run is writing it"), "{}", stderr(&output));
    sleep(Duration::from_millis(100));
    signal(&first, "INT");
    assert_eq!(ends(first).status.code(), Some(3));
    let (reading, items) = read_path(&log);
    assert!(reading.is_whole() && items.samples() > 1000);
    assert_eq!(reading.metadata["duration_s"], "50.0");
}

fn fifo(directory: &Path) -> PathBuf {
    let fifo = directory.join("run.mcap");
    assert!(Command::new("mkfifo").arg(&fifo).status().expect("mkfifo is there").success());
    fifo
}

#[test]
fn a_pipe_takes_a_log_as_it_comes() {
    let directory = directory("faults_pipe");
    let fifo = fifo(&directory);
    let copy = directory.join("copy");
    let out = fs::File::create(&copy).expect("made");
    let mut reader = Command::new("cat").arg(&fifo).stdout(out).spawn().expect("cat is there");
    let output = phalanx(&["run", ANCHOR, "--log", fifo.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(reader.wait().expect("ends").success());
    assert!(read_bytes(&fs::read(copy).expect("there")).0.expect("a log").is_whole());
    assert!(!partial(&fifo).exists());
}

#[test]
fn a_second_interrupt_kills_at_once() {
    use std::os::unix::process::ExitStatusExt;
    let directory = directory("faults_twice");
    // Nobody reads this pipe: the run waits for ever to open it.
    let mut child = start(ANCHOR, &fifo(&directory));
    sleep(Duration::from_millis(300));
    signal(&child, "INT");
    sleep(Duration::from_millis(300));
    assert!(child.try_wait().expect("asked").is_none(), "the first signal asks, and nothing has asked back yet");
    signal(&child, "INT");
    assert_eq!(ends(child).status.signal(), Some(2));
}
