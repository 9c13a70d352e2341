//! Input limits: errors that name the limit and what to do, documentation that matches the limits, and interrupts that
//! take effect within a second.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_rejected, directory, path_in, path_text, signal, start, stderr, succeed,
    variant, write,
};
use phalanx::limits;
use phalanx::units::Dimension;

#[test]
fn limits_page_matches_constants() {
    let page = include_str!("../../src/docs/limits.md");
    let thousands = |count: u64| {
        let digits = count.to_string();
        let groups: Vec<&str> =
            digits.as_bytes().rchunks(3).rev().map(|digits| std::str::from_utf8(digits).expect("digits")).collect();
        groups.join(",")
    };
    let rows = [
        ("a scene or study file", format!("{} MiB", limits::MAX_SCENE_BYTES >> 20)),
        ("the explorer's module", format!("{} MiB", limits::MAX_MODULE_BYTES >> 20)),
        ("problems of such", format!("{}, of which {} are shown", limits::MAX_PROBLEMS, limits::MAX_SHOWN_PROBLEMS)),
        ("discs of a scene", limits::MAX_DISCS.to_string()),
        ("bodies of a mechanism", limits::MAX_BODIES.to_string()),
        ("joints of a mechanism", limits::MAX_JOINTS.to_string()),
        ("tendons of a mechanism", limits::MAX_TENDONS.to_string()),
        ("eyelets and pulleys", limits::MAX_PLACES.to_string()),
        ("outlines of a mechanism", limits::MAX_OUTLINES.to_string()),
        ("points of a table over time", thousands(limits::MAX_TABLE_POINTS as u64)),
        ("corners of an outline", limits::MAX_CORNERS.to_string()),
        ("contacts of a mechanism", limits::MAX_CONTACTS.to_string()),
        ("a table (CSV or Parquet)", format!("{} MiB", limits::MAX_TABLE_BYTES >> 20)),
        ("a record of a log", format!("{} MiB", limits::MAX_RECORD_BYTES >> 20)),
        ("each of two logs", format!("{} figures", thousands(limits::MAX_COMPARED_VALUES as u64))),
        ("time (of a run", format!("{} s", limits::MAX_TIME_S)),
        ("length", format!("{} m", Dimension::Length.max_si())),
        ("angle, mass, speed", format!("{:e} rad", Dimension::Angle.max_si())),
        ("force, torque", format!("{:e} in SI", Dimension::Torque.max_si())),
        ("pressure, torsional", format!("{:e} in SI", Dimension::Pressure.max_si())),
        ("samples on the grid of a run", format!("{:e}", limits::MAX_SAMPLES)),
        ("pictures: ", format!("{:e}", limits::MAX_PICTURES)),
        ("samples of a run that is validated", format!("{:e}", limits::MAX_VALIDATED_SAMPLES)),
        ("steps of a run that is checked", thousands(limits::MAX_CHECKED_STEPS)),
        ("runs of a sweep", thousands(limits::MAX_RUNS)),
        ("runs of a study", thousands(limits::MAX_SHARDED_RUNS)),
        ("points of a latin-hypercube", thousands(limits::MAX_RUNS)),
        ("points of all volumes", thousands(limits::MAX_POINTS as u64)),
        ("threads", limits::MAX_THREADS.to_string()),
    ];
    for (item, limit) in rows {
        let row =
            page.lines().find(|line| line.starts_with(&format!("| {item}"))).unwrap_or_else(|| panic!("no {item}"));
        let cell = row.split('|').nth(2).expect("a second column").trim();
        assert!(cell.starts_with(&limit), "{item}: {cell}, but {limit}");
    }
    let have_equal_limits = |list: &[Dimension]| list.windows(2).all(|pair| pair[0].max_si() == pair[1].max_si());
    use Dimension::*;
    assert!(have_equal_limits(&[Angle, Mass, Speed, Density]));
    assert!(have_equal_limits(&[Pressure, AngularStiffness, LinearStiffness, LinearDamping, AngularDamping]));
    assert!(have_equal_limits(&[Force, Torque, AngularRate, Acceleration, Inertia, Frequency, LinearImpactDamping]));
}

#[test]
fn endless_and_invalid_files_are_rejected_quickly() {
    let directory = directory("limits_files");
    if Path::new("/dev/zero").exists() {
        for args in [&["run", "/dev/zero"][..], &["scene", "check", "/dev/zero"], &["sweep", "/dev/zero", "--list"]] {
            assert_rejected(args, &["larger than 1 MiB", "check the path"]);
        }
        let link = directory.join("zero.csv");
        std::os::unix::fs::symlink("/dev/zero", &link).expect("linked");
        assert_rejected(
            &["thesis", "select", path_text(&link)],
            &["larger than 256 MiB", "select fewer rows or columns"],
        );
        assert_rejected(
            &["explore", "--module", "/dev/zero"],
            &["/dev/zero", "not a regular file", "tools/explorer.sh"],
        );
        let oversized = directory.join("huge.wasm.gz");
        fs::File::create(&oversized).and_then(|file| file.set_len(1 << 40)).expect("a sparse file");
        assert_rejected(&["explore", "--module", path_text(&oversized)], &["larger than 16 MiB"]);
    }
    let keys: String = (0..70_000).map(|key| format!("k{key} = 1\n")).collect();
    let scene = write(&directory, "keys.toml", &keys);
    assert_rejected(&["run", &scene], &["unknown key `k0`", "100 problems or more; the first 20 are shown"]);
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
        .expect("formatted");
    }
    text
}

#[test]
fn oversized_scenes_are_rejected() {
    let directory = directory("limits_scenes");
    let too_many_discs = write(&directory, "many.toml", &discs(3000));
    assert_rejected(
        &["run", &too_many_discs, "--model", "engine"],
        &["3000 discs, but at most 100", "remove 2900 of them"],
    );
    assert_rejected(
        &["run", EXPERIMENT_95, "--numeric-rate", "1e12 Hz"],
        &["more than the limit of 1e7", "--numeric-rate \"5e8 Hz\""],
    );
    assert_rejected(&["run", EXPERIMENT_95, "--picture-rate", "1e9 Hz"], &["pictures", "--picture-rate \"5e7 Hz\""]);
    assert_rejected(
        &["run", EXPERIMENT_95, "--duration", "3000 s"],
        &["more than the limit of 1e7", "shorter --duration"],
    );
    let high_rate = variant(&directory, "fine.toml", "[log]\nnumeric_rate = \"1e12 Hz\"");
    assert_rejected(&["run", &high_rate], &["fine.toml:", "numeric_rate = \"5e8 Hz\"", "shorten the run"]);
    let high_rate = variant(&directory, "fine.toml", "[log]\nnumeric_rate = \"1e8 Hz\"");
    assert_rejected(
        &["validate", &high_rate, "--quick"],
        &["2000000 samples", "2e5", "lower numeric_rate in [log] to 1e7 Hz"],
    );
    // The suggested value is accepted.
    let high_rate = variant(&directory, "fine.toml", "[log]\nnumeric_rate = \"5e8 Hz\"\npicture_rate = \"5e7 Hz\"");
    succeed(&["scene", "check", &high_rate]);
}

/// A mechanism with one joint and these sections.
fn mechanism(sections: &str) -> String {
    let start = "kind = \"mechanism\"\nduration = \"1 ms\"\n[bodies.a]\nmass = \"10 g\"\ninertia = \"1e-6 kg*m^2\"\n[joints.j]\nbodies = \
                 [\"ground\", \"a\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 deg\"\n";
    format!("{start}{sections}")
}

fn repeated(count: usize, section: impl Fn(usize) -> String) -> String {
    (0..count).map(section).collect()
}

#[test]
fn oversized_mechanisms_are_rejected_quickly() {
    let directory = directory("limits_mechanisms");
    let eyelet =
        |k: usize| format!("{{ eyelet = \"{}\", at = [\"{k} mm\", \"{} mm\"] }}", ["ground", "a"][k % 2], k % 7 + 1);
    let cable = |places: usize| {
        let path: Vec<String> = (0..places).map(eyelet).collect();
        format!("stiffness = \"1e3 N/m\"\npath = [{}]\n", path.join(", "))
    };
    let table = |points: usize| {
        let times: Vec<String> = (0..points).map(|point| format!("\"{point} us\"")).collect();
        let torques = vec!["\"0 N*m\""; points];
        format!("[actuators.m]\njoint = \"j\"\ntimes = [{}]\ntorques = [{}]\n", times.join(", "), torques.join(", "))
    };
    let disc = "type = \"disc\"\nradius = \"1 mm\"\n";
    let outlines = |of: &str, count: usize| {
        repeated(count, |k| format!("[bodies.{of}.outlines.o{k}]\n{disc}center = [\"{k} mm\", \"0 mm\"]\n"))
    };
    let law = "[laws.l]\ntype = \"spring_damper\"\nstiffness = 1e6\nexponent = 1.0\ndamping = \"1 N*s/m\"\n[[contacts]]\nbetween = \
               [\"a\", \"b\"]\nlaw = \"l\"\n[bodies.b]\nmass = \"10 g\"\ninertia = \"1e-6 kg*m^2\"\n";
    for (sections, parts) in [
        (repeated(101, |k| format!("[tendons.t{k}]\n{}", cable(2))), ["101 tendons", "at most 100", "remove 1"]),
        (repeated(5000, |k| format!("[tendons.t{k}]\n{}", cable(2))), ["5000 tendons", "at most 100", "remove 4900"]),
        (format!("[tendons.t]\n{}", cable(101)), ["`tendons.t.path` has 101", "at most 100", "remove 1"]),
        (format!("[tendons.t]\n{}", cable(10_000)), ["`tendons.t.path` has 10000", "at most 100", "remove 9900"]),
        (table(10_001), ["`actuators.m.times` has 10001", "at most 10000", "fewer points"]),
        (
            repeated(301, |k| format!("[springs.s{k}]\njoint = \"j\"\nstiffness = \"1 N*m/rad\"\n")),
            ["301 springs", "at most 300", "remove 1"],
        ),
        (
            repeated(9000, |k| format!("[rotors.r{k}]\njoints = [\"j\"]\ninertia = \"1e-6 kg*m^2\"\n")),
            ["9000 rotors", "at most 300", "remove 8700"],
        ),
        (outlines("a", 1001), ["1001 outlines", "at most 1000", "remove 1"]),
        // A quarter of a million pairs.
        (
            format!("{}{law}{}", outlines("a", 500), outlines("b", 500)),
            ["more than 1000 contacts", "at most 1000", "fewer pairs"],
        ),
    ] {
        let scene = write(&directory, "large.toml", &mechanism(&sections));
        let start = Instant::now();
        assert_rejected(&["scene", "check", &scene], &parts);
        assert!(start.elapsed() < Duration::from_secs(20), "{parts:?}: {:?}", start.elapsed());
    }
    // The largest accepted ones are checked and simulated.
    let largest = [
        repeated(100, |k| format!("[tendons.t{k}]\n{}", cable(2))),
        format!("[tendons.t]\n{}", cable(100)),
        table(10_000),
    ];
    for sections in largest {
        let scene = write(&directory, "largest.toml", &mechanism(&sections));
        succeed(&["run", &scene, "--model", "engine", "--duration", "20 us", "--no-check"]);
    }
}

#[cfg(unix)]
#[test]
fn long_commands_stop_soon_after_an_interrupt() {
    let directory = directory("limits_interrupts");
    let hundred_discs = write(&directory, "crowd.toml", &discs(100));
    let out = &path_in(&directory, "out");
    let commands: [(&[&str], &str); 6] = [
        (&["thesis", "reproduce", "--threads", "1", "--out", out], "the reproduction was interrupted by SIGINT"),
        (&["thesis", "step-size", "--out", out], "the study was interrupted by SIGINT"),
        (&["thesis", "stability", EXPERIMENT_95, "--out", out], "the study was interrupted by SIGINT"),
        (&["validate", EXPERIMENT_95, "--out", out], "the validation was interrupted by SIGINT"),
        (&["thesis", "volume", "--resolution", "40", "--threads", "1", "--out", out], "interrupted by SIGINT"),
        (&["run", &hundred_discs, "--model", "engine", "--no-check"], "interrupted by SIGINT"),
    ];
    for (args, message) in commands {
        let child = start(args);
        std::thread::sleep(Duration::from_millis(400));
        signal(&child, "INT");
        let start = Instant::now();
        let output = child.wait_with_output().expect("exit status");
        // The tolerance allows for a busy machine.
        assert!(start.elapsed() < Duration::from_secs(3), "{args:?}: {:?}", start.elapsed());
        assert_eq!(output.status.code(), Some(3), "{args:?}: {}", stderr(&output));
        assert_contains(stderr(&output), &[message]);
        if args.contains(&"--out") {
            assert_contains(stderr(&output), &["no file was written"]);
            let file_count = fs::read_dir(out).map_or(0, |entries| entries.count());
            assert_eq!(file_count, 0, "{args:?} leaves no files");
        }
    }
}
