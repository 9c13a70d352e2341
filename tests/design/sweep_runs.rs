//! Runs of a study: a row depends only on its run, failed runs are recorded, and the counts of the thesis are
//! reproduced.

use std::collections::HashSet;

use phalanx::scene::{self, Preset};
use phalanx::study::sweep::{Status, load, run_while, summary, table};
use phalanx::table::Value;
use phalanx::trace::{FingerContact, Model, run_analytic};

use crate::support::studies::{parse_study as study, run_rows, run_study as results};

fn count_true(values: impl IntoIterator<Item = Option<bool>>) -> usize {
    values.into_iter().filter(|value| *value == Some(true)).count()
}

/// 2-design.md §2.6, right-hand column.
#[test]
fn reproduces_the_counts_of_the_thesis() {
    let study = load("scenes/studies/thesis.toml").expect("a shipped file");
    let table = results(&study);
    assert_eq!(table.rows.len(), 384);
    let range = |name: &str| {
        let values: Vec<f64> = table.numbers(name).expect(name).into_iter().flatten().collect();
        assert_eq!(values.len(), 384, "{name}");
        values.iter().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)))
    };
    let (low, high) = range("trajectory_rad");
    assert!((low.to_degrees() - 26.03).abs() < 5e-3 && (high.to_degrees() - 74.63).abs() < 5e-3, "{low} {high}");
    let (low, high) = range("mass_kg");
    assert!((low - 20.64e-3).abs() < 5e-6 && (high - 27.45e-3).abs() < 5e-6, "{low} {high}");

    let closed = table.flags("form_closed").expect("flags");
    let positive = table.flags("force_positive").expect("flags");
    let classes = table.texts("class").expect("texts");
    assert_eq!(closed[..192], closed[192..]);
    assert_eq!(count_true(closed[..192].iter().copied()), 22);
    for (runs, statically, dynamically) in [(0..192, 136, 53), (192..384, 160, 94)] {
        assert_eq!(count_true(positive[runs.clone()].iter().copied()), statically);
        let stable = classes[runs].iter().filter(|class| matches!(class, Some("stable" | "semi-stable"))).count();
        assert!(stable.abs_diff(dynamically) <= 3, "{stable} for {dynamically}");
    }
    // A statically unstable grasp is unstable regardless of the simulation.
    for (positive, class) in positive.iter().zip(&classes) {
        assert!(*positive == Some(true) || matches!(class, None | Some("unstable")));
    }

    // Design 95: a single run of the same scene gives the same results.
    let row = &table.rows[287 - 1];
    let number = |name: &str| match row[table.column(name).expect(name)] {
        Value::Number(number) => number,
        ref other => panic!("{name}: {other:?}"),
    };
    assert!((number("motor_n_m") - 0.5165).abs() < 2e-4 && (number("spring_n_m") - 0.11772).abs() < 5e-6);
    let scene = scene::parse(&study.scene_text(287), "95.toml").expect("a scene");
    assert_eq!(scene.integrator.preset, Preset::Engineering);
    let outcome = run_analytic(&scene, &mut ()).expect("completes");
    assert_eq!(number("f21_n"), outcome.last.finger_contact(FingerContact::Proximal).normal_n);
    assert_eq!(number("peak_f22_n"), outcome.finger_contact(FingerContact::Distal).peak_normal_n);
    assert!((number("t22_m") - 12.857e-3).abs() < 5e-7);
    assert_eq!(row[table.column("class").expect("class")], Value::from("stable"));
}

const MIXED: &str = "scene = \"../experiment-95.toml\"\n[set]\nintegrator.max_steps = 120\n[[axes]]\nfield = \
                     \"contact.friction.mu_static\"\nvalues = [-0.5, 0.0, 0.8]\n[[axes]]\nfield = \"design.phi22\"\nfrom = \"60 \
                     deg\"\nto = \"170 deg\"\ncount = 6\n[[axes]]\nfield = \"design.l21_fraction\"\nvalues = [0.0, 1.0, 1.5]\n";

#[test]
fn every_run_has_a_row_with_its_reason() {
    let study = study(MIXED);
    let table = results(&study);
    assert_eq!(table.rows.len(), 54);
    let counts = summary(&table).expect("results of a sweep");
    let [completed, refused, failed] =
        [Status::Completed, Status::Refused, Status::Failed].map(|status| counts.count_with_status(status));
    assert!(refused >= 30 && failed > 0, "{counts:?}");
    assert_eq!(counts.by_status.iter().map(|(_, count)| count).sum::<u64>(), 54);
    assert_eq!(counts.by_class.iter().map(|(_, count)| count).sum::<u64>(), completed);
    assert_eq!(counts.reasons.iter().map(|reason| reason.runs).sum::<u64>(), 54 - completed);

    let (status, reason) = (table.texts("status").expect("texts"), table.texts("reason").expect("texts"));
    let masses = table.numbers("mass_kg").expect("numbers");
    for (index, (status, reason)) in status.iter().zip(&reason).enumerate() {
        match status.expect("every row has a status") {
            "completed" => assert_eq!(*reason, None),
            "refused" => {
                let error = scene::parse(&study.scene_text(index as u64 + 1), "x.toml").expect_err("refused");
                let reason = reason.expect("a reason for the refusal");
                assert!(error.problems().iter().all(|problem| reason.contains(problem.message.trim())), "{reason}");
                assert_eq!(masses[index], None);
            }
            "failed" => {
                let reason = reason.expect("a reason for the failure");
                assert!(reason.starts_with("at ") && reason.contains(" ms: "), "{reason}");
                assert!(masses[index].is_some());
            }
            other => panic!("{other}"),
        }
    }
    assert!(reason.iter().flatten().any(|reason| reason.contains("mu_static` is -0.5")));
    assert!(reason.iter().flatten().any(|reason| reason.contains("l21_fraction` is 1.5")));
    assert!(reason.iter().flatten().any(|reason| reason.contains("budget of 120 steps")));
}

#[test]
fn results_are_independent_of_threads_and_order() {
    let study = study(MIXED);
    let single_threaded = table(&study, &run_rows(&study, 1, &HashSet::new()));
    for threads in [2, 3, 8] {
        assert_eq!(table(&study, &run_rows(&study, threads, &HashSet::new())), single_threaded);
    }
    // Odd and even runs separately.
    let odd: HashSet<u64> = (1..=study.runs()).filter(|run| run % 2 == 1).collect();
    let even = run_rows(&study, 2, &odd);
    let done = even.iter().map(|row| row.run).collect();
    assert_eq!(table(&study, &[even, run_rows(&study, 2, &done)].concat()), single_threaded);
}

#[test]
fn stops_on_request() {
    let study = study(MIXED);
    let mut rows = Vec::new();
    let stats = run_while(&study, 2, u64::MAX, &HashSet::new(), &|| true, |row| {
        rows.push(row);
        rows.len() < 10
    });
    assert!(!stats.complete && (10..=12).contains(&stats.runs), "{stats:?}");
    let stats = run_while(&study, 2, 7, &HashSet::new(), &|| true, |_| true);
    assert!(stats.complete && stats.runs == 7);
    let stats = run_while(&study, 1, u64::MAX, &HashSet::new(), &|| false, |_| true);
    assert!(!stats.complete && stats.runs == 0);
}

#[test]
fn a_filter_excludes_designs_from_simulation() {
    let with_filter = |filter: &str| {
        let text = format!(
            "name = \"f\"\n{}\n[filter]\n{filter}\n",
            include_str!("../../scenes/studies/thesis.toml").replace("name = \"thesis\"", "")
        );
        let study = study(&text.replace("from = 0\nto = 1\ncount = 4", "values = [1.0]"));
        results(&study)
    };
    let table = with_filter("force_positive = true\nform_closed = true");
    let (status, reason) = (table.texts("status").expect("texts"), table.texts("reason").expect("texts"));
    let flags = ["force_positive", "form_closed"].map(|name| table.flags(name).expect(name));
    let (steps, classes) = (table.integers("steps").expect("integers"), table.texts("class").expect("texts"));
    let mut filtered = 0;
    for index in 0..table.rows.len() {
        let accepted = flags.iter().all(|flags| flags[index] == Some(true));
        assert_eq!(status[index] == Some("filtered"), !accepted);
        assert_eq!(steps[index].is_none() && classes[index].is_none(), !accepted);
        if !accepted {
            filtered += 1;
            assert!(matches!(reason[index], Some("not force positive" | "not form-closed")));
        }
    }
    assert!(filtered > 20 && filtered < 96, "{filtered}");
    let open_only = with_filter("form_closed = false");
    let closed = open_only.flags("form_closed").expect("flags");
    let status = open_only.texts("status").expect("texts");
    assert!((0..96).all(|index| (status[index] == Some("filtered")) == (closed[index] == Some(true))));
}

#[test]
fn engine_and_analytic_model_agree() {
    let mut study = study(
        "scene = \"../experiment-95.toml\"\n[[axes]]\nfield = \"contact.friction.mu_static\"\nvalues = [0.0, 0.8]\n[[axes]]\nfield = \
         \"design.base\"\nvalues = [\"15.5 mm\", \"15 mm\"]\n",
    );
    let analytic = results(&study);
    study.model = Model::Engine;
    let engine = results(&study);
    assert_eq!(engine, table(&study, &run_rows(&study, 1, &HashSet::new())), "results depend on the number of threads");
    for (name, tolerance) in [("tts_s", 1e-3), ("f21_n", 1e-4), ("f22_n", 1e-4), ("pfp_n", 1e-3), ("static_f21_n", 0.0)]
    {
        let [a, b] = [&analytic, &engine].map(|table| table.numbers(name).expect(name));
        for (a, b) in a.into_iter().zip(b) {
            let (a, b) = (a.expect("a figure"), b.expect("a figure"));
            assert!((a - b).abs() <= tolerance * a.abs(), "{name}: {a} and {b}");
        }
    }
    assert_eq!(analytic.texts("class").expect("texts"), engine.texts("class").expect("texts"));
    assert_ne!(analytic.integers("steps").expect("integers"), engine.integers("steps").expect("integers"));
}

#[test]
fn a_scene_without_an_object_has_a_row_without_a_grasp() {
    let study =
        study("scene = \"../free-swing.toml\"\n[[axes]]\nfield = \"duration\"\nvalues = [\"1 ms\", \"2 ms\"]\n");
    let table = results(&study);
    assert_eq!(table.texts("status").expect("texts"), [Some("completed"); 2]);
    for name in ["static_f21_n", "tts_s", "f21_n", "pfp_n", "trajectory_rad"] {
        assert_eq!(table.numbers(name).expect(name), [None; 2], "{name}");
    }
    assert_eq!(table.texts("class").expect("texts"), [None; 2]);
    assert_eq!(table.texts("reason").expect("texts"), [Some("there is no object"); 2]);
    assert_eq!(summary(&table).expect("results of a sweep").no_class, 2);
    assert!(table.integers("steps").expect("integers").iter().all(|steps| steps.is_some_and(|steps| steps > 0)));
}
