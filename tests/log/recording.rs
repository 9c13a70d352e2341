//! A run as arrays: the columns are those of `replay --csv`, and the peaks those of the run.

use phalanx::scene::words::SceneKind;
use std::fs;

use phalanx::log::{read_any_file, read_file, run_to};
use phalanx::scene::{load, load_any};
use phalanx::trace::{Event, EventKind, Layout, Model, Recording, Site, record, run};

use crate::support::cli::{directory, phalanx, stderr};
use crate::support::replay::{DISCS, FINGER};

/// The table of `replay --csv`: names, and columns of numbers, NaN where a cell is empty.
fn table(log: &std::path::Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let file = log.with_extension("csv");
    let output = phalanx(&["replay", log.to_str().expect("text"), "--csv", file.to_str().expect("text")]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = fs::read_to_string(file).expect("a table");
    let mut lines = text.lines();
    let names: Vec<_> = lines.next().expect("names").split(',').map(String::from).collect();
    let mut columns = vec![Vec::new(); names.len()];
    for line in lines {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            column.push(if cell.is_empty() { f64::NAN } else { cell.parse().expect("a number") });
        }
    }
    (names, columns)
}

fn same(recording: &Recording, (names, columns): &(Vec<String>, Vec<Vec<f64>>)) {
    assert!(recording.columns().iter().map(|column| &column.name).eq(names));
    assert_eq!(recording.time(), columns[0]);
    for (name, column) in names.iter().zip(columns) {
        let kept = recording.column(name).expect("a column");
        assert_eq!(kept.len(), column.len(), "{name}");
        assert!(kept.iter().zip(column).all(|(a, b)| a == b || a.is_nan() && b.is_nan()), "{name}");
    }
}

#[test]
fn the_columns_of_a_finger_are_those_of_the_table() {
    let directory = directory("recording_finger");
    let path = directory.join("run.mcap");
    for (scene, model) in
        [(FINGER, Model::Analytic), (FINGER, Model::Engine), ("scenes/free-swing.toml", Model::Analytic)]
    {
        let scene = load(scene).expect("a scene");
        let (outcome, recording) = record(model, &scene).expect("a run");
        let logged = run_to(&scene, model, &path).expect("a run");
        assert_eq!(logged.outcome, outcome);
        same(&recording, &table(&path));
        // A log is read into the same arrays.
        let mut read = Recording::new(&Layout::of_kind(SceneKind::Finger));
        read_file(&path, &mut read).expect("a log");
        same(&read, &table(&path));
        assert_eq!(read.events(), recording.events());
    }
}

#[test]
fn the_columns_of_discs_are_those_of_the_table() {
    let directory = directory("recording_discs");
    let path = directory.join("run.mcap");
    let scene = load_any(DISCS).expect("a scene");
    let (_, recording) = record(Model::Engine, &scene).expect("a run");
    run_to(&scene, Model::Engine, &path).expect("a run");
    same(&recording, &table(&path));
    assert!(recording.column("hammer_x_m").is_some() && recording.column("hammer-anvil_normal_n").is_some());
    let mut read = Recording::new(&Layout::default());
    read_any_file(&path, &mut read).expect("a log");
    assert_eq!(read, recording);
    assert!(recording.events().len() >= 2);
}

#[test]
fn the_largest_of_a_column_is_the_largest_of_the_run() {
    let scene = load(FINGER).expect("a scene");
    let (outcome, recording) = record(Model::Analytic, &scene).expect("a run");
    // Without thinning, too.
    let mut every = Recording::new(&Layout::of_kind(SceneKind::Finger));
    run(Model::Analytic, &scene, &mut every).expect("a run");
    assert!(every.time().len() >= recording.time().len());
    assert!(every.time().is_sorted() && recording.time().is_sorted());
    for (name, site) in [("proximal_normal_n", Site::Proximal), ("distal_normal_n", Site::Distal)] {
        for kept in [&every, &recording] {
            let largest = kept.column(name).expect("a column").iter().copied().fold(0.0, f64::max);
            assert_eq!(largest, outcome.site(site).peak_normal_n, "{name}");
        }
    }
}

#[test]
fn what_is_not_there_is_no_number_and_what_is_unknown_no_column() {
    let mut scene = load(FINGER).expect("a scene");
    scene.system.discs.clear();
    scene.duration_s = 2e-3;
    let (_, recording) = record(Model::Analytic, &scene).expect("a run");
    let forces = recording.column("distal_normal_n").expect("a column");
    assert!(forces.len() > 10 && forces.iter().all(|force| force.is_nan()));
    assert!(recording.column("q21_rad").expect("a column").iter().all(|angle| angle.is_finite()));
    assert_eq!(recording.column("q21"), None);
    assert_eq!(recording.columns().len(), 42);
}

/// Events of friction are told to a log as they are to a recording, of every kind of scene that has bristles, and a run that is done again
/// has the same.
#[test]
fn slipping_and_sticking_come_back_from_a_log() {
    let directory = directory("recording_slips");
    let path = directory.join("run.mcap");
    for scene in
        ["scenes/experiment-95-bristle.toml", "scenes/laws/bristle-stick-slip.toml", "scenes/gripper/hold.toml"]
    {
        let any = load_any(scene).expect("a scene");
        for model in [Model::Analytic, Model::Engine] {
            let (outcome, recording) = record(model, &any).expect("a run");
            let slips = |contact: usize| {
                let of = |event: &&Event| event.contact == contact && event.kind == EventKind::Slips;
                recording.events().iter().filter(of).count() as u32
            };
            assert!((0..outcome.contacts.len()).any(|contact| slips(contact) > 0), "{scene}: something slips");
            assert!(
                outcome.contacts.iter().enumerate().all(|(contact, found)| found.slips == slips(contact)),
                "{scene}"
            );
            run_to(&any, model, &path).expect("a run");
            let layout =
                if any.kind() == SceneKind::Finger { Layout::of_kind(SceneKind::Finger) } else { Layout::default() };
            let mut read = Recording::new(&layout);
            assert!(read_any_file(&path, &mut read).expect("a log").is_whole());
            assert_eq!(read.events(), recording.events(), "{scene}, {}", model.name());
            let output = phalanx(&["replay", path.to_str().expect("text"), "--verify", "--json"]);
            assert!(output.status.success(), "{scene}: {}", stderr(&output));
        }
    }
}
