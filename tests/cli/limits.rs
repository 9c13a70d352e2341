//! How much is taken at most: refusals that say the limit and the way out, a page that is right about them, and interrupts that
//! are heard within a second.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::cli::{ANCHOR, directory, phalanx, stderr, stdout, variant, write};
use phalanx::limits;
use phalanx::units::Dimension;

#[track_caller]
fn refused(args: &[&str], parts: &[&str]) {
    let start = Instant::now();
    let output = phalanx(args);
    let message = stderr(&output);
    assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""), "{args:?}: {message}");
    for part in parts {
        assert!(message.contains(part), "{args:?}: no {part:?} in {message}");
    }
    assert!(message.len() < 20_000, "{args:?}: {} bytes", message.len());
    assert!(start.elapsed() < Duration::from_secs(10), "{args:?}: {:?}", start.elapsed());
}

#[test]
fn the_page_says_what_the_program_has() {
    let page = include_str!("../../src/docs/limits.md");
    let thousands = |count: u64| {
        let digits = count.to_string();
        let groups: Vec<&str> =
            digits.as_bytes().rchunks(3).rev().map(|of| std::str::from_utf8(of).expect("digits")).collect();
        groups.join(",")
    };
    let rows = [
        ("a scene or study file", format!("{} MiB", limits::LARGEST_SCENE_BYTES >> 20)),
        ("the explorer's module", format!("{} MiB", limits::LARGEST_MODULE_BYTES >> 20)),
        ("problems of such", format!("{}, of which {} are shown", limits::MOST_PROBLEMS, limits::SHOWN_PROBLEMS)),
        ("discs of a scene", limits::MOST_DISCS.to_string()),
        ("a table (CSV or Parquet)", format!("{} MiB", limits::LARGEST_TABLE_BYTES >> 20)),
        ("a record of a log", format!("{} MiB", limits::LARGEST_RECORD >> 20)),
        ("each of two logs", format!("{} figures", thousands(limits::MOST_COMPARED_FIGURES as u64))),
        ("time (of a run", format!("{} s", limits::LONGEST_S)),
        ("length", format!("{} m", Dimension::Length.largest_si())),
        ("angle, mass, speed", format!("{:e} rad", Dimension::Angle.largest_si())),
        ("force, torque", format!("{:e} in SI", Dimension::Torque.largest_si())),
        ("pressure, torsional", format!("{:e} in SI", Dimension::Pressure.largest_si())),
        ("samples on the grid of a run", format!("{:e}", limits::MOST_SAMPLES)),
        ("pictures: ", format!("{:e}", limits::MOST_PICTURES)),
        ("samples of a run that is validated", format!("{:e}", limits::MOST_VALIDATED_SAMPLES)),
        ("steps of a run that is checked", thousands(limits::MOST_CHECKED_STEPS)),
        ("clients of a run", limits::MOST_CLIENTS.to_string()),
        ("runs of a sweep", thousands(limits::MOST_RUNS)),
        ("runs of a study", thousands(limits::MOST_SHARDED_RUNS)),
        ("points of a latin-hypercube", thousands(limits::MOST_RUNS)),
        ("points of all volumes", thousands(limits::MOST_POINTS as u64)),
        ("threads", limits::MOST_THREADS.to_string()),
    ];
    for (what, most) in rows {
        let row =
            page.lines().find(|line| line.starts_with(&format!("| {what}"))).unwrap_or_else(|| panic!("no {what}"));
        let cell = row.split('|').nth(2).expect("a second column").trim();
        assert!(cell.starts_with(&most), "{what}: {cell}, but {most}");
    }
    let alike = |list: &[Dimension]| list.windows(2).all(|two| two[0].largest_si() == two[1].largest_si());
    use Dimension::*;
    assert!(
        alike(&[Angle, Mass, Speed, Density]) && alike(&[Pressure, AngularStiffness, LinearDamping, AngularDamping])
    );
    assert!(alike(&[Force, Torque, AngularRate, Acceleration, Inertia, Frequency]));
}

#[test]
fn files_without_an_end_or_sense_are_refused_soon() {
    let directory = directory("limits_files");
    if Path::new("/dev/zero").exists() {
        for args in [&["run", "/dev/zero"][..], &["scene", "check", "/dev/zero"], &["sweep", "/dev/zero", "--list"]] {
            refused(args, &["larger than 1 MiB", "check the path"]);
        }
        let link = directory.join("zero.csv");
        std::os::unix::fs::symlink("/dev/zero", &link).expect("linked");
        refused(&["select", link.to_str().expect("text")], &["larger than 256 MiB", "some of its rows"]);
        refused(&["explore", "--module", "/dev/zero"], &["/dev/zero", "not a regular file", "tools/explorer.sh"]);
        let huge = directory.join("huge.wasm.gz");
        fs::File::create(&huge).and_then(|file| file.set_len(1 << 40)).expect("a file with a hole");
        refused(&["explore", "--module", huge.to_str().expect("text")], &["larger than 16 MiB"]);
    }
    let mut keys = String::new();
    for key in 0..70_000 {
        writeln!(keys, "k{key} = 1").expect("memory takes it");
    }
    let scene = write(&directory, "keys.toml", &keys);
    refused(&["run", &scene], &["unknown key `k0`", "100 problems or more, of which these are the first 20"]);
}

fn discs(count: usize) -> String {
    let mut text = "kind = \"bodies\"\nduration = \"2 ms\"\n[contact]\nstiffness_si = 1e8\n".to_string();
    for disc in 0..count {
        let (x, y) = (disc % 10 * 10, disc / 10 * 10);
        let speed = if y % 20 == 0 { 1 } else { -1 };
        write!(
            text,
            "[discs.d{disc}]\nradius = \"4.999 mm\"\ncentre = [\"{x} mm\", \"{y} mm\"]\nmass = \"4 g\"\nvelocity = [\"0 \
             m/s\", \"{speed} m/s\"]\n"
        )
        .expect("memory takes it");
    }
    text
}

#[test]
fn scenes_that_could_not_be_run_or_logged_are_refused() {
    let directory = directory("limits_scenes");
    let many = write(&directory, "many.toml", &discs(3000));
    refused(&["run", &many, "--model", "engine"], &["3000 discs, but at most 100", "leave 2900 of them out"]);
    refused(&["run", ANCHOR, "--numeric-rate", "1e12 Hz"], &["more than the 1e7", "--numeric-rate \"5e8 Hz\""]);
    refused(&["run", ANCHOR, "--picture-rate", "1e9 Hz"], &["pictures", "--picture-rate \"5e7 Hz\""]);
    refused(&["run", ANCHOR, "--duration", "3000 s"], &["more than the 1e7", "shorter --duration"]);
    let fine = variant(&directory, "fine.toml", "[log]\nnumeric_rate = \"1e12 Hz\"");
    refused(&["run", &fine], &["fine.toml:", "numeric_rate = \"5e8 Hz\"", "shorten the run"]);
    let fine = variant(&directory, "fine.toml", "[log]\nnumeric_rate = \"1e8 Hz\"");
    refused(&["validate", &fine, "--quick"], &["2000000 samples", "2e5", "lower numeric_rate in [log] to 1e7 Hz"]);
    // The way out is one.
    let fine = variant(&directory, "fine.toml", "[log]\nnumeric_rate = \"5e8 Hz\"\npicture_rate = \"5e7 Hz\"");
    let output = phalanx(&["scene", "check", &fine]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[cfg(unix)]
#[test]
fn interrupts_are_heard_within_a_second_by_every_long_command() {
    let directory = directory("limits_interrupts");
    let crowd = write(&directory, "crowd.toml", &discs(100));
    let out = directory.join("out");
    let out = out.to_str().expect("text");
    let commands: [(&[&str], &str); 6] = [
        (&["reproduce", "--threads", "1", "--out", out], "the reproduction was interrupted by SIGINT"),
        (&["study", "step-size", "--out", out], "the study was interrupted by SIGINT"),
        (&["study", "stability", ANCHOR, "--out", out], "the study was interrupted by SIGINT"),
        (&["validate", ANCHOR, "--out", out], "the validation was interrupted by SIGINT"),
        (&["volume", "--resolution", "40", "--threads", "1", "--out", out], "interrupted by SIGINT"),
        (&["run", &crowd, "--model", "engine", "--no-check"], "interrupted by SIGINT"),
    ];
    for (args, said) in commands {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        let child =
            command.args(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary starts");
        std::thread::sleep(Duration::from_millis(400));
        let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill is there");
        assert!(status.success(), "{args:?} has ended before it could be interrupted");
        let start = Instant::now();
        let output = child.wait_with_output().expect("ends");
        // A busy machine takes its time too.
        assert!(start.elapsed() < Duration::from_secs(3), "{args:?}: {:?}", start.elapsed());
        assert_eq!(output.status.code(), Some(3), "{args:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(said), "{args:?}: {}", stderr(&output));
        if args.contains(&"--out") {
            assert!(stderr(&output).contains("no file was written"), "{args:?}: {}", stderr(&output));
            let left = fs::read_dir(out).map_or(0, |found| found.count());
            assert_eq!(left, 0, "{args:?} leaves nothing lying about");
        }
    }
}
