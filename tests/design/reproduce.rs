//! Reproduction of the thesis: expected values, and agreement of all report formats.

use std::collections::HashSet;
use std::fs;

use crate::support::cli::{directory, json, phalanx, stderr, stdout};
use phalanx::format::ToReport;
use phalanx::format::report::{Block, Report};
use phalanx::page::report_page;
use phalanx::report::reproduce::{Comparison, ReproductionReport, Verdict, comparisons};
use phalanx::study::reproduce::{Reproduction, Variation, computed_values, figures, reproduce};
use serde_json::Value;

/// A single test, because the reproduction takes seconds.
#[test]
fn reproduces_the_thesis() {
    let mut steps = Vec::new();
    let reproduction =
        reproduce(false, 0, &mut |done, total, name| steps.push((done, total, name.to_string())), &|| true)
            .unwrap_or_else(|error| panic!("{error}"));
    assert!(steps.iter().enumerate().all(|(index, step)| step.0 == index && step.1 == steps.len()), "{steps:?}");

    let all = comparisons(&reproduction);
    check_completeness(&reproduction);
    check_expected_values(&all);
    check_variations(&reproduction);
    check_grid_influence(&reproduction);
    let report = ReproductionReport::new(&reproduction);
    let paper = report.paper();
    check_formats(&report, &all, &paper);
}

fn check_completeness(reproduction: &Reproduction) {
    let values = computed_values(reproduction);
    let keys: HashSet<&str> = figures().iter().map(|figure| figure.key.as_str()).collect();
    for figure in figures() {
        assert!(values.get(&figure.key).is_some_and(|value| value.is_finite()), "{} is not computed", figure.key);
    }
    let unused: Vec<_> = values.keys().filter(|key| !keys.contains(key.as_str())).collect();
    assert!(unused.is_empty(), "computed, but not compared: {unused:?}");
}

fn check_expected_values(all: &[Comparison]) {
    let outside: Vec<_> = all.iter().filter(|entry| entry.verdict == Verdict::Outside).collect();
    let failures: Vec<_> =
        outside.iter().map(|entry| (entry.figure, entry.ours_text(), entry.expected_text())).collect();
    // `phalanx reproduce` then exits with status 0.
    assert!(outside.is_empty(), "{failures:?}");
    assert!(all.iter().filter(|entry| entry.verdict == Verdict::Inside).count() >= 40);
    // Values from the specification, independent of the file of figures.
    let computed = |key: &str| all.iter().find(|entry| entry.figure == key).expect(key).computed;
    assert_eq!((computed("statics.form_closed"), computed("statics.form_closed_quarters")), (22.0, 13.0));
    assert_eq!((computed("statics.stable_mu_0"), computed("statics.stable_mu_0.8")), (136.0, 160.0));
    assert!(
        (computed("sweep.stable_mu_0") - 53.0).abs() <= 3.0 && (computed("sweep.stable_mu_0.8") - 94.0).abs() <= 3.0
    );
    for (base, percentages) in [
        ("12", [95.82, 96.61, 9.88]),
        ("15.5", [87.58, 95.28, 22.44]),
        ("19", [78.00, 87.51, 1.10]),
        ("22.5", [53.08, 62.54, 0.0]),
    ] {
        let keys = [
            format!("volume.stable_percent.base_{base}_mm.mu_0"),
            format!("volume.stable_percent.base_{base}_mm.mu_0.8"),
            format!("volume.closed_percent.base_{base}_mm"),
        ];
        // One of 8,000 points is 0.0125 %.
        assert!(
            keys.iter().zip(percentages).all(|(key, percentage)| (computed(key) - percentage).abs() <= 0.05),
            "base {base} mm"
        );
    }
    assert!((computed("design.trajectory_min_rad").to_degrees() - 26.03).abs() < 5e-3);
    assert!((computed("design.trajectory_max_rad").to_degrees() - 74.63).abs() < 5e-3);
    for (key, grams) in [("design.mass_min_kg", 20.64), ("design.mass_max_kg", 27.45), ("design.mass_kg", 24.64)] {
        assert!((computed(key) * 1e3 - grams).abs() < 5e-3, "{key}");
    }
}

/// The counts differ by at most three from the study in every variation.
fn check_variations(reproduction: &Reproduction) {
    let chaos = &reproduction.chaos;
    for (condition, counts) in chaos.stable.iter().enumerate() {
        assert_eq!(counts[0], reproduction.selection.classes[condition].dynamically_stable());
        let (in_all, in_any) = (chaos.stable_in_all[condition], chaos.stable_in_any[condition]);
        assert!(counts.iter().all(|&count| count.abs_diff(counts[0]) <= 3 && in_all <= count && count <= in_any));
    }
    assert!(chaos.class_changes.iter().all(|change| change.classes.iter().any(|class| *class != change.class)));
    assert!(chaos.class_changes.iter().all(|change| change.classes.len() == Variation::ALL.len()));
}

fn check_grid_influence(reproduction: &Reproduction) {
    let [shortest, second, _, longest] = &reproduction.grids[..] else { panic!("four bases") };
    assert!((longest.stable_percent[1] - 62.2).abs() < 0.1, "{longest:?}");
    assert!((second.closed_percent - 21.5).abs() < 0.1, "{second:?}");
    // A stronger spring opens the distal contact of some designs, a weaker motor of more.
    for grid in [shortest, longest] {
        for mu in 0..2 {
            assert!(grid.stable_percent[mu] > grid.stronger_spring_percent[mu], "{grid:?}");
            assert!(grid.stronger_spring_percent[mu] > grid.both_torques_percent[mu], "{grid:?}");
        }
    }
}

fn check_formats(report: &ReproductionReport<'_>, all: &[Comparison], paper: &Report) {
    let titles: Vec<&str> = paper.headings().collect();
    assert_eq!(titles.len(), 9, "{titles:?}");
    let mut title = "";
    for (index, block) in paper.blocks.iter().enumerate() {
        match block {
            Block::Heading(heading) => {
                let next = paper.blocks.get(index + 1);
                assert!(next.is_some_and(|block| !matches!(block, Block::Heading(_))), "{heading} is empty");
                title = heading;
            }
            Block::Table(table) => {
                // The header is a row.
                assert!(table.rows.len() > 1 && !table.caption.is_empty(), "{title}: an empty table");
                let columns = table.rows[0].len();
                assert!(
                    table.rows.iter().all(|row| row.len() == columns),
                    "{}: rows of different lengths",
                    table.caption
                );
            }
            Block::Figure(figure) => {
                let complete = figure.svg.starts_with("<svg") && !figure.svg.contains("NaN");
                assert!(complete && !figure.caption.is_empty(), "{}", figure.file);
            }
            Block::Notes(notes) => assert!(!notes.is_empty() && notes.iter().all(|note| note.len() > 10)),
            Block::Lines(text) | Block::Paragraph(text) => assert!(text.trim().len() > 20, "{text:?}"),
            Block::Text(text) => assert!(!text.id.is_empty() && !text.text.is_empty(), "{}", text.title),
        }
    }

    let document: Value = serde_json::from_str(&report.json()).expect("JSON");
    let listed = document["figures"].as_array().expect("figures");
    assert_eq!((listed.len(), &document["outside"]), (all.len(), &Value::from(outside(all))));
    let html = report_page(paper);
    for entry in listed {
        let (key, value) = (entry["figure"].as_str().expect("a key"), entry["ours"].as_f64().expect("a number"));
        let mark = format!("data-figure=\"{key}\" data-si=\"");
        let shown: Vec<&str> = html.split(&mark).skip(1).collect();
        assert!(!shown.is_empty(), "{key} is not in the page");
        let comparison = all.iter().find(|entry| entry.figure == key).expect(key);
        // The JSON parser may be wrong in the last bit.
        assert!((comparison.computed - value).abs() <= 2.0 * f64::EPSILON * value.abs(), "{key}");
        for cell in shown {
            let (si, rest) = cell.split_once("\">").expect("a cell");
            assert_eq!(si.parse::<f64>().expect("a number"), comparison.computed, "{key}");
            assert_eq!(rest.split('<').next(), Some(comparison.ours_text().as_str()), "{key}");
        }
    }
    // The page loads no external resources: the only addresses are SVG namespaces.
    assert_eq!(
        html.matches("http").count(),
        html.matches("http://www.w3.org/2000/svg").count() + html.matches("http-equiv").count()
    );
    let markdown = paper.markdown();
    assert!(all.iter().all(|entry| markdown.contains(&entry.ours_text())));
    assert_eq!(report_page(&report.paper()), html, "the page is reproducible");
}

fn outside(all: &[Comparison]) -> usize {
    all.iter().filter(|entry| entry.verdict == Verdict::Outside).count()
}

/// A quick run does not judge volumes; all judged values are as expected.
#[test]
fn command_writes_its_files() {
    let out = directory("reproduce").join("report");
    let output = phalanx(&["reproduce", "--quick", "--json", "--out", out.to_str().expect("plain text")]);
    assert_eq!(output.status.code(), Some(0), "{}\n{}", stdout(&output), stderr(&output));
    let document = json(&output);
    let mut saved: Value =
        serde_json::from_str(&fs::read_to_string(out.join("report.json")).expect("report.json")).expect("JSON");
    saved.as_object_mut().expect("an object").remove("generator");
    assert_eq!((&document, &document["outside"]), (&saved, &Value::from(0)));
    let volumes = document["figures"].as_array().expect("figures").iter().filter(|entry| entry["section"] == "volumes");
    assert!(volumes.clone().count() > 40 && volumes.clone().all(|entry| entry["verdict"] == "not judged"));
    let markdown = fs::read_to_string(out.join("report.md")).expect("report.md");
    let figures: Vec<&str> =
        markdown.split("](figures/").skip(1).filter_map(|part| part.split_once(')')).map(|part| part.0).collect();
    assert!(figures.len() > 8);
    for figure in figures {
        assert!(out.join("figures").join(figure).is_file(), "{figure}");
    }
    let selected = phalanx(&["select", out.join("results.csv").to_str().expect("plain text"), "--json"]);
    assert_eq!(json(&selected)["ranking"], document["selection"]["ranking"]);
    assert_eq!(phalanx(&["reproduce", "--out", "Cargo.toml"]).status.code(), Some(2));
}
