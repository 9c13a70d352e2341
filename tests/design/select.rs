//! Selection on small tables: runs removed by each criterion, r_WC, and selections without a result.

use crate::support::cli::assert_contains;
use crate::support::sweep_results::{SweepRun, refused_run, results_table, successful_run, ungraspable_run};
use phalanx::criteria::Class;
use phalanx::format::ToReport;
use phalanx::report::sweep::{SelectionReport, ranking_table};
use phalanx::study::select::{Bound, PerTerm, SelectError, Selection, SelectionCriteria, Side, select};
use phalanx::table::{Table, Value};
use phalanx::{plot, table};

fn selected(table: &Table, criteria: &SelectionCriteria) -> Selection {
    select(table, criteria).unwrap_or_else(|error| panic!("{error}"))
}

/// (rank, run) of the ranking.
fn ranks(selection: &Selection) -> Vec<(usize, i64)> {
    selection.ranking.iter().map(|ranked| (ranked.rank, selection.runs[ranked.run_index].run)).collect()
}

/// One run for each criterion that fails only it, one that fails two, and two that meet all.
fn mixed() -> Vec<SweepRun> {
    let typical_run = || successful_run(0, 7e-3, [5.0, 20.0, 8.0]);
    let mut runs = vec![
        successful_run(1, 7e-3, [5.0, 20.0, 8.0]),
        SweepRun { force_positive: Some(false), ..typical_run() },
        SweepRun { form_closed: Some(false), ..typical_run() },
        SweepRun { class: Some("semi-unstable"), ..typical_run() },
        SweepRun { forces: Some([-0.1, 20.0, 8.0]), ..typical_run() },
        SweepRun { class: Some("unstable"), tts_s: None, form_closed: Some(false), ..typical_run() },
        SweepRun { class: Some("semi-stable"), forces: Some([0.0, 10.0, 8.0]), ..typical_run() },
        refused_run(8),
    ];
    for (index, run) in runs.iter_mut().enumerate() {
        run.design = index as i64 + 1;
    }
    runs
}

#[test]
fn each_criterion_removes_the_runs_that_fail_it() {
    let selection = selected(&results_table(&mixed()), &SelectionCriteria::default());
    let counts: Vec<_> = selection
        .tallies
        .iter()
        .map(|t| (t.holds, t.fails, t.unknown, t.remaining, t.removed_alone, t.removed()))
        .collect();
    // Completed, statically stable, form-closed, class, PFP; the refused run has no figures.
    let expected = [(7, 1, 0, 7, 0, 1), (6, 1, 1, 6, 1, 2), (5, 2, 1, 4, 1, 3), (5, 2, 1, 3, 1, 3), (6, 1, 1, 2, 1, 2)];
    assert_eq!(counts, expected);
    // PFP and tts are 5, 0 and 7, 7; F21 20, 10: run 1 has 1, ½, 0, ½, run 7 has 0, ½, 1, ½.
    assert_eq!(ranks(&selection), [(1, 1), (1, 7)]);
    assert!(selection.ranking.iter().all(|ranked| ranked.r_wc == 0.5));
    assert_eq!(selection.emptied_by(), None);
    let classes = &selection.classes[0];
    assert_eq!((classes.dynamic, classes.statuses), ([4, 1, 1, 1], [7, 0, 1, 0]));
    assert_eq!((classes.statically_stable, classes.statically_unstable, classes.form_closed), (6, 1, 5));
}

#[test]
fn criteria_can_be_removed_and_added() {
    let table = results_table(&mixed());
    let selected_runs = |criteria: SelectionCriteria| {
        let mut runs: Vec<i64> = ranks(&selected(&table, &criteria)).iter().map(|ranked| ranked.1).collect();
        runs.sort_unstable();
        runs
    };
    let base = SelectionCriteria::default;
    let bound = |column: &str, value: f64| SelectionCriteria {
        bounds: vec![Bound { column: column.to_string(), side: Side::AtMost, value }],
        ..base()
    };
    // Without a class criterion, the ranking requires a time to stability.
    let any = SelectionCriteria { worst_class: None, form_closed: false, ..base() };
    for (criteria, expected) in [
        (base(), &[1, 7][..]),
        (SelectionCriteria { force_positive: false, ..base() }, &[1, 2, 7]),
        (SelectionCriteria { form_closed: false, ..base() }, &[1, 3, 7]),
        (SelectionCriteria { bounds: vec![], ..base() }, &[1, 5, 7]),
        (SelectionCriteria { worst_class: Some(Class::SemiUnstable), ..base() }, &[1, 4, 7]),
        (SelectionCriteria { worst_class: Some(Class::Stable), ..base() }, &[1]),
        (any.clone(), &[1, 3, 4, 7]),
        (SelectionCriteria { weights: PerTerm([1.0, 0.0, 1.0, 1.0]), ..any }, &[1, 3, 4, 6, 7]),
        (bound("mass_kg", 0.0215), &[1]),
        (bound("tts_s", 1e-3), &[]),
    ] {
        assert_eq!(selected_runs(criteria.clone()), expected, "{criteria:?}");
    }
}

/// Calculated by hand for runs 1 to 3: PFP 10, 0, 5; tts 7, 5, 9 ms; F21 30, 20, 10; F22 4, 2, 6.
/// r_WC = (1 + ½ + 0 + ½)/4, (0 + 1 + ½ + 0)/4, (½ + 0 + 1 + 1)/4. A fourth run that is not form-closed must not widen
/// a range.
#[test]
fn r_wc_is_scaled_over_the_selected_runs_only() {
    let mut runs = vec![
        successful_run(1, 7e-3, [10.0, 30.0, 4.0]),
        successful_run(2, 5e-3, [0.0, 20.0, 2.0]),
        successful_run(3, 9e-3, [5.0, 10.0, 6.0]),
        SweepRun { form_closed: Some(false), ..successful_run(4, 1e-3, [1000.0, 1.0, 500.0]) },
    ];
    let table = results_table(&runs);
    let selection = selected(&table, &SelectionCriteria::default());
    assert_eq!(ranks(&selection), [(1, 3), (2, 1), (3, 2)]);
    let scores: Vec<f64> = selection.ranking.iter().map(|ranked| ranked.r_wc).collect();
    assert!(
        scores.iter().zip([0.625, 0.5, 0.375]).all(|(score, by_hand)| (score - by_hand).abs() < 1e-14),
        "{scores:?}"
    );

    // The order of the rows has no effect.
    let mut shuffled = table.clone();
    shuffled.rows.reverse();
    let reordered = selected(&shuffled, &SelectionCriteria::default());
    assert_eq!(ranks(&reordered), ranks(&selection));

    // The ranking as a table has the same content and is a valid table of results.
    let ranking = ranking_table(&table, &selection);
    assert_eq!(ranking.integers("run").expect("runs"), [Some(3), Some(1), Some(2)]);
    assert_eq!(ranking.numbers("r_wc").expect("scores"), scores.iter().map(|&score| Some(score)).collect::<Vec<_>>());
    assert_eq!(ranking.numbers("part_f21").expect("parts"), [Some(1.0), Some(0.0), Some(0.5)]);
    let twice = selected(&ranking, &SelectionCriteria::default());
    assert_eq!(ranks(&twice), ranks(&selection));
    assert_eq!(ranking_table(&ranking, &twice), ranking);

    runs.truncate(1);
    let single = selected(&results_table(&runs), &SelectionCriteria::default());
    assert_eq!((ranks(&single), single.ranking[0].r_wc), (vec![(1, 1)], 0.5));
    assert!(SelectionReport::new("one.csv", &single, 5).report().to_string().contains("Only one run is left"));
}

#[test]
fn an_empty_selection_names_the_criterion_that_removed_the_last_run() {
    let runs = vec![
        SweepRun { form_closed: Some(false), ..successful_run(1, 7e-3, [5.0, 20.0, 8.0]) },
        successful_run(2, 7e-3, [-5.0, 20.0, 8.0]),
        successful_run(3, 7e-3, [-1.0, 20.0, 8.0]),
    ];
    let selection = selected(&results_table(&runs), &SelectionCriteria::default());
    let last = selection.emptied_by().expect("an empty selection");
    assert_eq!((last.remaining, last.removed_alone), (0, 2));
    let text = SelectionReport::new("none.csv", &selection, 5).report().to_string();
    assert!(text.contains("\"PFP ≥ 0 N\" removed the last"), "{text}");
    assert!(text.contains("1 without \"form-closed\", 2 without \"PFP ≥ 0 N\""), "{text}");
    assert_eq!((selection.ranking.len(), last.criterion.key()), (0, "pfp_n"));

    let ungraspable = vec![SweepRun { form_closed: Some(false), ..successful_run(1, 7e-3, [-5.0, 20.0, 8.0]) }];
    let selection = selected(&results_table(&ungraspable), &SelectionCriteria::default());
    assert!(
        SelectionReport::new("none.csv", &selection, 5).report().to_string().contains("every run fails two or more")
    );
}

/// Friction varies within a design and is a condition; the base does not vary.
#[test]
fn axes_that_vary_within_a_design_define_conditions() {
    let designs = |mu: f64| {
        [1, 2].map(|design| SweepRun {
            mu,
            base_m: 0.01 + 0.002 * design as f64,
            ..successful_run(design, 7e-3, [1.0, 2.0, 3.0])
        })
    };
    let runs = [designs(0.8), designs(0.0)].concat();
    let selection = selected(&results_table(&runs), &SelectionCriteria::default());
    let axes: Vec<_> = selection.axes.iter().map(|axis| (axis.column.as_str(), axis.varies_within_design)).collect();
    assert_eq!(axes, [("contact.friction.mu_static", true), ("design.base_m", false)]);
    let mu = |value| vec![("contact.friction.mu_static".to_string(), Value::Number(value))];
    assert_eq!(
        selection.conditions.iter().map(|condition| condition.values.clone()).collect::<Vec<_>>(),
        [mu(0.8), mu(0.0)]
    );
    assert_eq!(selection.runs.iter().map(|run| run.condition).collect::<Vec<_>>(), [0, 0, 1, 1]);
    assert_eq!((selection.designs(), selection.classes.len()), (2, 2));

    // A table of a single condition has no condition axes.
    let selection = selected(&results_table(&runs[..2]), &SelectionCriteria::default());
    assert_eq!((selection.conditions.len(), selection.conditions[0].values.len()), (1, 0));
}

/// Invalid tables are rejected with the row and a remedy.
#[test]
fn rejects_invalid_tables() {
    let table_of_two =
        || results_table(&[successful_run(1, 7e-3, [1.0, 2.0, 3.0]), successful_run(2, 7e-3, [1.0, 2.0, 3.0])]);
    let refusal = |change: &dyn Fn(&mut Table)| {
        let mut table = table_of_two();
        change(&mut table);
        select(&table, &SelectionCriteria::default()).expect_err("refused").to_string()
    };
    let column_index = |name: &str| table_of_two().column(name).expect("a column");
    let set = |name: &'static str, value: Value| {
        move |table: &mut Table| {
            let column = table.column(name).expect("a column");
            table.rows[1][column] = value.clone();
        }
    };
    let remove = |name: &'static str| {
        move |table: &mut Table| {
            let column = table.column(name).expect("a column");
            table.columns.remove(column);
            table.rows.iter_mut().for_each(|row| drop(row.remove(column)));
        }
    };
    for (message, words) in [
        (refusal(&remove("pfp_n")), vec!["pfp_n", "phalanx sweep"]),
        (refusal(&remove("l12_m")), vec!["l12_m"]),
        (refusal(&set("run", Value::Integer(1))), vec!["run 1 occurs twice", "rows 1 and 2"]),
        (refusal(&set("design", Value::Integer(1))), vec!["design 1 occurs twice", "runs 1 and 2"]),
        (refusal(&set("run", Value::Missing)), vec!["row 2", "`run`", "resume"]),
        (refusal(&set("status", Value::Missing)), vec!["row 2", "`status`", "resume"]),
        (refusal(&set("status", Value::from("done"))), vec!["run 2", "`done`", "completed"]),
        (refusal(&set("class", Value::from("good"))), vec!["run 2", "`good`", "semi-stable"]),
        (refusal(&set("class", Value::Missing)), vec!["run 2", "`class`", "not finished"]),
        (refusal(&set("pfp_n", Value::Number(f64::NAN))), vec!["run 2", "`pfp_n`", "NaN", "finite"]),
        (refusal(&set("pfp_n", Value::from("much"))), vec!["row 2", "pfp_n", "much", "a number"]),
        (refusal(&|table| table.rows.clear()), vec!["no rows", "phalanx sweep"]),
        (refusal(&|table| table.columns.swap(column_index("design"), column_index("l12_m"))), vec!["l12_m", "before"]),
    ] {
        assert!(words.iter().all(|word| message.contains(word)), "{words:?} in {message}");
    }
    let bound = |column: &str| SelectionCriteria {
        bounds: vec![Bound { column: column.to_string(), side: Side::AtLeast, value: 0.0 }],
        ..SelectionCriteria::default()
    };
    for (column, word) in [("mass_k", "did you mean `mass_kg`"), ("status", "a number")] {
        let error = select(&table_of_two(), &bound(column)).expect_err("refused").to_string();
        assert!(error.contains(word), "{error}");
    }
    let weights = |tts: f64| SelectionCriteria { weights: PerTerm([0.0, tts, 0.0, 0.0]), ..bound("mass_kg") };
    assert_eq!(select(&table_of_two(), &weights(0.0)), Err(SelectError::NoWeight));
    assert_eq!(select(&table_of_two(), &weights(-1.0)), Err(SelectError::Weight { name: "tts", value: -1.0 }));
}

/// Designs that cannot grasp are counted by reason without numbers and are not selected.
#[test]
fn runs_that_cannot_grasp_are_counted_and_not_selected() {
    let semi_stable_reason =
        "rebound 2.1 %, at most 5 %; the distal phalanx touched first and lifted off from 7.1 ms to 8.2 ms";
    let runs = [
        successful_run(1, 7e-3, [5.0, 20.0, 8.0]),
        ungraspable_run(2, "the distal phalanx does not reach its contact: it is 15.7800 mm long"),
        ungraspable_run(3, "the distal phalanx does not reach its contact: it is 16.0000 mm long"),
        ungraspable_run(4, "the proximal phalanx misses the object: it is 9 mm long"),
        refused_run(5),
        SweepRun {
            class: Some("semi-stable"),
            class_reason: Some(semi_stable_reason),
            ..successful_run(6, 8e-3, [6.0, 20.0, 8.0])
        },
    ];
    let any = SelectionCriteria {
        force_positive: false,
        form_closed: false,
        worst_class: None,
        bounds: vec![],
        weights: PerTerm([1.0, 0.0, 1.0, 1.0]),
    };
    for criteria in [SelectionCriteria::default(), any] {
        let selection = selected(&results_table(&runs), &criteria);
        let mut ranked_runs: Vec<i64> = ranks(&selection).iter().map(|ranked| ranked.1).collect();
        ranked_runs.sort_unstable();
        assert_eq!(ranked_runs, [1, 6]);
        assert!(selection.ranking.iter().all(|ranked| ranked.r_wc.is_finite()));
        let counts: Vec<_> = selection.cannot_grasp.iter().map(|reason| (reason.runs, reason.first_run)).collect();
        assert_eq!(counts, [(2, 2), (1, 4)]);
        let tally = &selection.tallies[1];
        assert_eq!((tally.holds, tally.fails, tally.unknown), (2, 3, 1));
        let report = SelectionReport::new("made.csv", &selection, 5);
        let text = report.report().to_string();
        assert_contains(
            &text,
            &[
                "cannot grasp           3 (50.0 %)",
                "2 rows cannot grasp, first run 2: the distal phalanx does not reach its contact: it is 15.7800 mm long",
                "1 row cannot grasp, first run 4: the proximal phalanx misses the object: it is 9 mm long",
                "can grasp its object",
                &format!("1 semi-stable, first run 6: {semi_stable_reason}"),
                &format!("run 6 is semi-stable: {semi_stable_reason}"),
            ],
        );
        let document: serde_json::Value = serde_json::from_str(&report.json()).expect("JSON");
        assert_eq!(document["classes"][0]["cannot_grasp"], 3);
        assert_eq!(
            (&document["cannot_grasp"][0]["runs"], &document["criteria"][1]["criterion"]),
            (&2.into(), &"graspable".into())
        );
        assert_eq!(document["class_reasons"][1]["class_reason"], semi_stable_reason);
    }
    // If every finger can grasp, there is no such criterion.
    let selection = selected(&results_table(&mixed()), &SelectionCriteria::default());
    assert!(selection.cannot_grasp.is_empty() && selection.tallies.len() == 5);
}

#[test]
fn missing_runs_are_counted() {
    let mut table = results_table(&[1, 2, 3, 4].map(|design| successful_run(design, 7e-3, [1.0, 2.0, 3.0])));
    table.rows.remove(1);
    let selection = selected(&table, &SelectionCriteria::default());
    assert_eq!(selection.missing_runs, [2]);
    assert!(SelectionReport::new("part.csv", &selection, 1).report().to_string().contains("first: run 2"));
}

/// Plots of small, large and incomplete tables; their size is bounded.
#[test]
fn plots_any_study_with_bounded_size() {
    let many_runs: Vec<SweepRun> = (0..5000)
        .map(|index| SweepRun {
            base_m: 0.012 + 1e-6 * f64::from(index),
            force_positive: Some(index % 3 > 0),
            class: Some(["stable", "semi-stable", "semi-unstable", "unstable"][index as usize % 4]),
            ..successful_run(i64::from(index), 7e-3, [f64::from(index % 7), 2.0, 3.0])
        })
        .collect();
    for (runs, max_bytes) in [(mixed(), 100_000), (vec![refused_run(1)], 100_000), (many_runs, 3_000_000)] {
        let table = results_table(&runs);
        let selection = selected(&table, &SelectionCriteria::default());
        for svg in [
            plot::selection_criteria("made", &selection),
            plot::selection_classes("made", &selection),
            plot::selection_static("made", &selection),
            plot::selection_forces("made", &selection),
            plot::selection_variables("made", &table, &selection),
        ] {
            assert!(svg.trim_end().ends_with("</svg>") && svg.len() < max_bytes, "{} bytes", svg.len());
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "a coordinate is not finite");
        }
        let picture = plot::selection_criteria("made", &selection);
        assert!(picture.len() < 1_000_000, "{} bytes", picture.len());
    }
}

/// CSV and Parquet give the same selection.
#[test]
fn csv_and_parquet_give_the_same_selection() {
    let directory = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("select-formats");
    std::fs::create_dir_all(&directory).expect("a directory");
    let generated = results_table(&mixed());
    let select_from = |name: &str| {
        let path = directory.join(name);
        table::write(&path, &generated).expect("the file is writable");
        selected(&table::read(&path).expect("read"), &SelectionCriteria::default())
    };
    assert_eq!(select_from("made.csv"), select_from("made.parquet"));
    assert_eq!(select_from("made.csv"), selected(&generated, &SelectionCriteria::default()));
}
