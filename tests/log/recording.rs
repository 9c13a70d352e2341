//! Recording of a run as arrays: same columns as `replay --csv`, same peaks as the run.

use std::fs;

use phalanx::log::{read_file, run_to};
use phalanx::scene::{load, load_any};
use phalanx::trace::{Event, EventKind, FingerContact, Model, Recording, Schema, record, run};

use crate::support::cli::{directory, path_text, succeed};
use crate::support::replay::{DISC_SCENE, FINGER_SCENE};

/// Table of `replay --csv`: names and columns of numbers, NaN for empty cells.
fn read_csv_table(log: &std::path::Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let file = log.with_extension("csv");
    succeed(&["replay", path_text(log), "--csv", path_text(&file)]);
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

fn assert_same_columns(recording: &Recording, (names, columns): &(Vec<String>, Vec<Vec<f64>>)) {
    assert!(recording.channels().iter().map(|channel| &channel.name).eq(names));
    assert_eq!(recording.time(), columns[0]);
    for (name, column) in names.iter().zip(columns) {
        let values = recording.column(name).expect("a column");
        assert_eq!(values.len(), column.len(), "{name}");
        assert!(values.iter().zip(column).all(|(a, b)| a == b || a.is_nan() && b.is_nan()), "{name}");
    }
}

#[test]
fn recording_matches_the_csv_table() {
    let path = directory("recording_table").join("run.mcap");
    for (scene, model) in [
        (FINGER_SCENE, Model::Analytic),
        (FINGER_SCENE, Model::Engine),
        ("scenes/free-swing.toml", Model::Analytic),
        (DISC_SCENE, Model::Engine),
    ] {
        let mut scene = load_any(scene).expect("a scene");
        scene.log.joint_forces = true;
        let (outcome, recording) = record(model, &scene).expect("a run");
        let logged = run_to(&scene, model, &path).expect("a run");
        assert_eq!(logged.outcome, outcome);
        let table = read_csv_table(&path);
        assert_same_columns(&recording, &table);
        // Reading the log gives the same arrays.
        let mut read = Recording::new(&Schema::for_fingers(scene.finger_count()));
        read_file(&path, &mut read).expect("a log");
        assert_same_columns(&read, &table);
        assert_eq!(read.events(), recording.events());
        if scene.finger_count() != 1 {
            assert!(recording.column("hammer_x_m").is_some() && recording.column("hammer-anvil_normal_n").is_some());
            assert_eq!(read, recording);
            assert!(recording.events().len() >= 2);
        }
    }
}

#[test]
fn maximum_of_a_column_is_the_peak_of_the_run() {
    let scene = load(FINGER_SCENE).expect("a scene");
    let (outcome, recording) = record(Model::Analytic, &scene).expect("a run");
    // A second recording is not decimated.
    let mut all_steps = Recording::new(&Schema::for_fingers(1));
    run(Model::Analytic, &scene, &mut all_steps).expect("a run");
    assert!(all_steps.time().len() >= recording.time().len());
    assert!(all_steps.time().is_sorted() && recording.time().is_sorted());
    for (name, contact) in [("proximal_normal_n", FingerContact::Proximal), ("distal_normal_n", FingerContact::Distal)]
    {
        for recorded in [&all_steps, &recording] {
            let largest = recorded.column(name).expect("a column").iter().copied().fold(0.0, f64::max);
            assert_eq!(largest, outcome.finger_contact(contact).peak_normal_n, "{name}");
        }
    }
}

#[test]
fn absent_contacts_and_unknown_columns_are_none() {
    let mut scene = load(FINGER_SCENE).expect("a scene");
    scene.hand.object = None;
    scene.duration_s = 2e-3;
    let (_, recording) = record(Model::Analytic, &scene).expect("a run");
    assert_eq!(recording.column("distal_normal_n"), None);
    assert!(recording.column("q21_rad").expect("a column").iter().all(|angle| angle.is_finite()));
    assert_eq!(recording.column("q21"), None);
    assert_eq!(recording.channels().len(), 33);
}

/// Log and recording have the same slip events for every kind of scene with bristles, and a new run reproduces them.
#[test]
fn slip_events_are_read_back_from_a_log() {
    let directory = directory("recording_slips");
    let path = directory.join("run.mcap");
    for scene in
        ["scenes/experiment-95-bristle.toml", "scenes/laws/bristle-stick-slip.toml", "scenes/gripper/hold.toml"]
    {
        let loaded = load_any(scene).expect("a scene");
        for model in [Model::Analytic, Model::Engine] {
            let (outcome, recording) = record(model, &loaded).expect("a run");
            let slips = |contact: usize| {
                let is_slip = |event: &&Event| event.contact == contact && event.kind == EventKind::Slips;
                recording.events().iter().filter(is_slip).count() as u32
            };
            assert!((0..outcome.contacts.len()).any(|contact| slips(contact) > 0), "{scene}: something slips");
            let mut contacts = outcome.contacts.iter().enumerate();
            assert!(contacts.all(|(contact, summary)| summary.slips == slips(contact)), "{scene}");
            run_to(&loaded, model, &path).expect("a run");
            let mut read = Recording::new(&Schema::for_fingers(loaded.finger_count()));
            assert!(read_file(&path, &mut read).expect("a log").is_complete());
            assert_eq!(read.events(), recording.events(), "{scene}, {}", model.name());
            succeed(&["replay", path_text(&path), "--verify", "--json"]);
        }
    }
}
