//! Selection on small tables: runs removed by each criterion, r_WC, and selections without a result.

use crate::support::cli::{assert_contains, directory};
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

/// Selection by the criteria of the thesis.
fn by_default(runs: &[SweepRun]) -> Selection {
    selected(&results_table(runs), &SelectionCriteria::default())
}

/// (rank, run) of the ranking.
fn ranks(selection: &Selection) -> Vec<(usize, i64)> {
    selection.ranking.iter().map(|ranked| (ranked.rank, selection.runs[ranked.run_index].run)).collect()
}

fn selected_runs(selection: &Selection) -> Vec<i64> {
    let mut runs: Vec<i64> = ranks(selection).iter().map(|ranked| ranked.1).collect();
    runs.sort_unstable();
    runs
}

fn report(selection: &Selection) -> String {
    SelectionReport::new("made.csv", selection, 5).report().to_string()
}

/// The criteria of the thesis with a bound instead of that of the palm force.
fn bound(column: &str, side: Side, value: f64) -> SelectionCriteria {
    SelectionCriteria {
        bounds: vec![Bound { column: column.to_string(), side, value }],
        ..SelectionCriteria::default()
    }
}

/// One run for each criterion that fails only it, one that fails two, and two that meet all.
fn mixed() -> Vec<SweepRun> {
    let typical = |pfp_n, f21_n| successful_run(0, 7e-3, [pfp_n, f21_n, 8.0]);
    let runs = [
        typical(5.0, 20.0),
        typical(5.0, 20.0).with("force_positive", false),
        typical(5.0, 20.0).with("form_closed", false),
        typical(5.0, 20.0).with("class", "semi-unstable"),
        typical(-0.1, 20.0),
        typical(5.0, 20.0).with("class", "unstable").with("tts_s", Value::Missing).with("form_closed", false),
        typical(0.0, 10.0).with("class", "semi-stable"),
        refused_run(0),
    ];
    let numbered =
        |(design, run): (i64, SweepRun)| run.with("design", design).with("mass_kg", 0.02 + 1e-3 * design as f64);
    (1..).zip(runs).map(numbered).collect()
}

#[test]
fn each_criterion_removes_the_runs_that_fail_it() {
    let selection = by_default(&mixed());
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

    // CSV and Parquet give the same selection.
    let directory = directory("select-formats");
    for name in ["made.csv", "made.parquet"] {
        table::write(&directory.join(name), &results_table(&mixed())).expect("the file is writable");
        let read = table::read(&directory.join(name)).expect("read");
        assert_eq!(selected(&read, &SelectionCriteria::default()), selection, "{name}");
    }
}

#[test]
fn criteria_can_be_removed_and_added() {
    let table = results_table(&mixed());
    let base = SelectionCriteria::default;
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
        (bound("mass_kg", Side::AtMost, 0.0215), &[1]),
        (bound("tts_s", Side::AtMost, 1e-3), &[]),
    ] {
        assert_eq!(selected_runs(&selected(&table, &criteria)), expected, "{criteria:?}");
    }
}

/// Calculated by hand for runs 1 to 3: PFP 10, 0, 5; tts 7, 5, 9 ms; F21 30, 20, 10; F22 4, 2, 6.
/// r_WC = (1 + ½ + 0 + ½)/4, (0 + 1 + ½ + 0)/4, (½ + 0 + 1 + 1)/4. A fourth run that is not form-closed must not widen
/// a range.
#[test]
fn r_wc_is_scaled_over_the_selected_runs_only() {
    let runs = [
        successful_run(1, 7e-3, [10.0, 30.0, 4.0]),
        successful_run(2, 5e-3, [0.0, 20.0, 2.0]),
        successful_run(3, 9e-3, [5.0, 10.0, 6.0]),
        successful_run(4, 1e-3, [1000.0, 1.0, 500.0]).with("form_closed", false),
    ];
    let (table, selection) = (results_table(&runs), by_default(&runs));
    assert_eq!(ranks(&selection), [(1, 3), (2, 1), (3, 2)]);
    let scores: Vec<f64> = selection.ranking.iter().map(|ranked| ranked.r_wc).collect();
    assert!(
        scores.iter().zip([0.625, 0.5, 0.375]).all(|(score, by_hand)| (score - by_hand).abs() < 1e-14),
        "{scores:?}"
    );

    // The order of the rows has no effect.
    let mut shuffled = table.clone();
    shuffled.rows.reverse();
    assert_eq!(ranks(&selected(&shuffled, &SelectionCriteria::default())), ranks(&selection));

    // The ranking as a table has the same content and is a valid table of results.
    let ranking = ranking_table(&table, &selection);
    assert_eq!(ranking.integers("run").expect("runs"), [Some(3), Some(1), Some(2)]);
    assert_eq!(ranking.numbers("r_wc").expect("scores"), scores.iter().map(|&score| Some(score)).collect::<Vec<_>>());
    assert_eq!(ranking.numbers("part_f21").expect("parts"), [Some(1.0), Some(0.0), Some(0.5)]);
    let twice = selected(&ranking, &SelectionCriteria::default());
    assert_eq!(ranks(&twice), ranks(&selection));
    assert_eq!(ranking_table(&ranking, &twice), ranking);

    // Only the ratios of the weights matter: 3 for PFP and 1 for tts give 3.5/4, 1/4 and 1.5/4.
    let weighted = |weights| selected(&table, &SelectionCriteria { weights: PerTerm(weights), ..Default::default() });
    let of_two = weighted([3.0, 1.0, 0.0, 0.0]);
    assert_eq!(ranks(&of_two), [(1, 1), (2, 3), (3, 2)]);
    assert_eq!(of_two.ranking.iter().map(|ranked| ranked.r_wc).collect::<Vec<_>>(), [0.875, 0.375, 0.25]);
    assert_eq!(of_two.ranking, weighted([6.0, 2.0, 0.0, 0.0]).ranking);
    assert_eq!(ranks(&weighted([0.0, 2.0, 0.0, 0.0])), [(1, 2), (2, 1), (3, 3)]);

    let single = by_default(&runs[..1]);
    assert_eq!((ranks(&single), single.ranking[0].r_wc), (vec![(1, 1)], 0.5));
    assert_contains(&report(&single), &["Only one run is left"]);
}

#[test]
fn ties_share_a_rank_and_missing_figures_without_weight_have_no_effect() {
    let run = |design, pfp_n| successful_run(design, 5e-3, [pfp_n, 1.0, 1.0]);
    let ties = by_default(&[run(1, 1.0), run(2, 2.0), run(3, 2.0), run(4, 0.0)]);
    assert_eq!(ranks(&ties), [(1, 2), (1, 3), (3, 1), (4, 4)]);
    assert!(ties.ranking.iter().all(|ranked| ranked.terms.0[1] == 0.5), "equal tts");

    let unsettled = run(1, 1.0).with("class", "unstable").with("tts_s", Value::Missing);
    let weights = PerTerm([1.0, 0.0, 1.0, 1.0]);
    let criteria = SelectionCriteria { worst_class: None, weights, ..SelectionCriteria::default() };
    let selection = selected(&results_table(&[unsettled, run(2, 2.0)]), &criteria);
    assert_eq!(ranks(&selection), [(1, 2), (2, 1)]);
    assert!((selection.ranking[0].r_wc - 2.0 / 3.0).abs() < 1e-14);
}

#[test]
fn an_empty_selection_names_the_criterion_that_removed_the_last_run() {
    let run = |design, pfp_n| successful_run(design, 7e-3, [pfp_n, 20.0, 8.0]);
    let selection = by_default(&[run(1, 5.0).with("form_closed", false), run(2, -5.0), run(3, -1.0)]);
    let last = selection.emptied_by().expect("an empty selection");
    assert_eq!((last.remaining, last.removed_alone), (0, 2));
    assert_eq!((selection.ranking.len(), last.criterion.key()), (0, "pfp_n"));
    let words = ["\"PFP ≥ 0 N\" removed the last", "1 without \"form-closed\", 2 without \"PFP ≥ 0 N\""];
    assert_contains(&report(&selection), &words);
    let selection = by_default(&[run(1, -5.0).with("form_closed", false)]);
    assert_contains(&report(&selection), &["every run fails two or more"]);
}

/// Friction varies within a design and is a condition; the base does not vary.
#[test]
fn axes_that_vary_within_a_design_define_conditions() {
    let run = |mu: f64, design: i64| {
        let run = successful_run(design, 7e-3, [1.0, 2.0, 3.0]).with("contact.friction.mu_static", mu);
        run.with("design.base_m", 0.01 + 0.002 * design as f64)
    };
    let mut table = results_table(&[run(0.8, 1), run(0.8, 2), run(0.0, 1), run(0.0, 2)]);
    let selection = selected(&table, &SelectionCriteria::default());
    let axes: Vec<_> = selection.axes.iter().map(|axis| (axis.column.as_str(), axis.varies_within_design)).collect();
    assert_eq!(axes, [("contact.friction.mu_static", true), ("design.base_m", false)]);
    let conditions = selection.conditions.iter().map(|condition| condition.values.clone());
    let mu = |value| vec![("contact.friction.mu_static".to_string(), Value::Number(value))];
    assert!(conditions.eq([mu(0.8), mu(0.0)]));
    assert_eq!(selection.runs.iter().map(|run| run.condition).collect::<Vec<_>>(), [0, 0, 1, 1]);
    assert_eq!((selection.designs(), selection.classes.len()), (2, 2));

    // A missing run is counted.
    table.rows.remove(1);
    let selection = selected(&table, &SelectionCriteria::default());
    assert_eq!(selection.missing_runs, [2]);
    assert_contains(&report(&selection), &["first: run 2"]);
    // A table of a single condition has no condition axes.
    let selection = by_default(&[run(0.8, 1), run(0.8, 2)]);
    assert_eq!((selection.conditions.len(), selection.conditions[0].values.len()), (1, 0));
}

/// Invalid tables are rejected with the row and a remedy.
#[test]
fn rejects_invalid_tables() {
    let valid = results_table(&[successful_run(1, 7e-3, [1.0, 2.0, 3.0]), successful_run(2, 7e-3, [1.0, 2.0, 3.0])]);
    let column = |name: &str| valid.column(name).expect("a column");
    let refusal = |change: &dyn Fn(&mut Table)| {
        let mut table = valid.clone();
        change(&mut table);
        select(&table, &SelectionCriteria::default()).expect_err("refused").to_string()
    };
    for (name, value, words) in [
        ("run", Value::Integer(1), &["run 1 occurs twice", "rows 1 and 2"][..]),
        ("design", Value::Integer(1), &["design 1 occurs twice", "runs 1 and 2"]),
        ("run", Value::Missing, &["row 2", "`run`", "resume"]),
        ("status", Value::Missing, &["row 2", "`status`", "resume"]),
        ("status", Value::from("done"), &["run 2", "`done`", "completed"]),
        ("class", Value::from("good"), &["run 2", "`good`", "semi-stable"]),
        ("class", Value::Missing, &["run 2", "`class`", "not finished"]),
        ("pfp_n", Value::Number(f64::NAN), &["run 2", "`pfp_n`", "NaN", "finite"]),
        ("pfp_n", Value::from("much"), &["row 2", "pfp_n", "much", "a number"]),
    ] {
        assert_contains(&refusal(&|table| table.rows[1][column(name)] = value.clone()), words);
    }
    for (name, words) in [("pfp_n", ["pfp_n", "phalanx sweep"]), ("l12_m", ["l12_m", "phalanx sweep"])] {
        assert_contains(&refusal(&|table| drop(table.columns.remove(column(name)))), &words);
    }
    assert_contains(&refusal(&|table| table.rows.clear()), &["no rows", "phalanx sweep"]);
    assert_contains(&refusal(&|table| table.columns.swap(column("design"), column("l12_m"))), &["l12_m", "before"]);
    for (column, word) in [("mass_k", "did you mean `mass_kg`"), ("status", "a number")] {
        let error = select(&valid, &bound(column, Side::AtLeast, 0.0)).expect_err("refused").to_string();
        assert_contains(&error, &[word]);
    }
    let weights =
        |tts: f64| SelectionCriteria { weights: PerTerm([0.0, tts, 0.0, 0.0]), ..SelectionCriteria::default() };
    assert_eq!(select(&valid, &weights(0.0)), Err(SelectError::NoWeight));
    assert_eq!(select(&valid, &weights(-1.0)), Err(SelectError::Weight { name: "tts", value: -1.0 }));
}

/// Designs that cannot grasp are counted by reason without numbers and are not selected.
#[test]
fn runs_that_cannot_grasp_are_counted_and_not_selected() {
    let semi_stable_reason =
        "rebound 2.1 %, at most 5 %; the distal phalanx touched first and lifted off from 7.1 ms to 8.2 ms";
    let semi_stable = successful_run(6, 8e-3, [6.0, 20.0, 8.0]).with("class", "semi-stable");
    let runs = [
        successful_run(1, 7e-3, [5.0, 20.0, 8.0]),
        ungraspable_run(2, "the distal phalanx does not reach its contact: it is 15.7800 mm long"),
        ungraspable_run(3, "the distal phalanx does not reach its contact: it is 16.0000 mm long"),
        ungraspable_run(4, "the proximal phalanx misses the object: it is 9 mm long"),
        refused_run(5),
        semi_stable.with("class_reason", semi_stable_reason),
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
        assert_eq!(selected_runs(&selection), [1, 6]);
        assert!(selection.ranking.iter().all(|ranked| ranked.r_wc.is_finite()));
        let counts: Vec<_> = selection.cannot_grasp.iter().map(|reason| (reason.runs, reason.first_run)).collect();
        assert_eq!(counts, [(2, 2), (1, 4)]);
        let tally = &selection.tallies[1];
        assert_eq!((tally.holds, tally.fails, tally.unknown), (2, 3, 1));
        let words = [
            "cannot grasp           3 (50.0 %)",
            "2 rows cannot grasp, first run 2: the distal phalanx does not reach its contact: it is 15.7800 mm long",
            "1 row cannot grasp, first run 4: the proximal phalanx misses the object: it is 9 mm long",
            "can grasp its object",
            &format!("1 semi-stable, first run 6: {semi_stable_reason}"),
            &format!("run 6 is semi-stable: {semi_stable_reason}"),
        ];
        assert_contains(&report(&selection), &words);
        let json = SelectionReport::new("made.csv", &selection, 5).json();
        let document: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        assert_eq!(
            (&document["classes"][0]["cannot_grasp"], &document["cannot_grasp"][0]["runs"]),
            (&3.into(), &2.into())
        );
        assert_eq!(document["criteria"][1]["criterion"], "graspable");
        assert_eq!(document["class_reasons"][1]["class_reason"], semi_stable_reason);
    }
    // If every finger can grasp, there is no such criterion.
    let selection = by_default(&mixed());
    assert!(selection.cannot_grasp.is_empty() && selection.tallies.len() == 5);
}

/// Plots of small, large and incomplete tables; their size is bounded.
#[test]
fn plots_any_study_with_bounded_size() {
    let many_runs = (0..5000).map(|index| {
        let run = successful_run(index, 7e-3, [(index % 7) as f64, 2.0, 3.0]).with("force_positive", index % 3 > 0);
        let run = run.with("design.base_m", 0.012 + 1e-6 * index as f64);
        run.with("class", ["stable", "semi-stable", "semi-unstable", "unstable"][index as usize % 4])
    });
    for (runs, max_bytes) in [(mixed(), 100_000), (vec![refused_run(1)], 100_000), (many_runs.collect(), 3_000_000)] {
        let table = results_table(&runs);
        let selection = selected(&table, &SelectionCriteria::default());
        let pictures = plot::selection("made", &table, &selection);
        for svg in &pictures {
            assert!(svg.trim_end().ends_with("</svg>") && svg.len() < max_bytes, "{} bytes", svg.len());
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "a coordinate is not finite");
        }
        assert!(pictures[0].len() < 1_000_000, "{} bytes", pictures[0].len());
    }
}
