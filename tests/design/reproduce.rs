//! Reproduction of the thesis: expected values, and agreement of all report formats.

use std::fs;

use crate::support::cli::{assert_rejected, directory, path_in, run_json, succeed_json};
use phalanx::format::ToReport;
use phalanx::format::report::Block;
use phalanx::page::report_page;
use phalanx::parallel::Monitor;
use phalanx::report::reproduce::{ReproductionReport, reproduce};
use phalanx::thesis::reproduce::{Comparison, Reproduction, Verdict, computed_values, figures};
use serde_json::Value;

/// A single test, because the reproduction takes seconds.
#[test]
fn reproduces_the_thesis() {
    let mut steps = Vec::new();
    let monitor = Monitor::new(|done, total, _| steps.push((done, total)), &|| true);
    let found = reproduce(false, 0, &monitor).unwrap_or_else(|error| panic!("{error}"));
    drop(monitor);
    assert!(steps.into_iter().eq((0..6).map(|done| (done, 6))));
    check_completeness(&found.reproduction);
    check_expected_values(&found.reproduction.comparisons);
    check_variations(&found.reproduction);
    check_grid_influence(&found.reproduction);
    check_formats(&found.reproduction, &ReproductionReport::new(&found));
}

fn check_completeness(reproduction: &Reproduction) {
    let mut values = computed_values(reproduction);
    for figure in figures() {
        assert!(values.remove(&figure.key).is_some_and(f64::is_finite), "{} is not computed", figure.key);
    }
    assert!(values.is_empty(), "computed, but not compared: {values:?}");
}

fn check_expected_values(all: &[Comparison]) {
    let outside = all.iter().filter(|entry| entry.verdict == Verdict::Outside);
    let outside: Vec<_> = outside.map(|entry| (&entry.figure.key, entry.ours_text(), entry.expected_text())).collect();
    // `phalanx thesis reproduce` then exits with status 0.
    assert!(outside.is_empty(), "{outside:?}");
    assert!(all.iter().filter(|entry| entry.verdict == Verdict::Inside).count() >= 40);
    // Values from the specification, independent of the file of figures.
    let computed = |key: &str| all.iter().find(|entry| entry.figure.key == key).expect(key).computed;
    assert_eq!((computed("statics.form_closed"), computed("statics.form_closed_quarters")), (22.0, 13.0));
    assert_eq!((computed("statics.stable_mu_0"), computed("statics.stable_mu_0.8")), (136.0, 160.0));
    assert!(
        (computed("sweep.stable_mu_0") - 53.0).abs() <= 3.0 && (computed("sweep.stable_mu_0.8") - 94.0).abs() <= 3.0
    );
    // One of 8,000 points is 0.0125 %.
    for (quantity, friction, percentages) in [
        ("stable", ".mu_0", [95.82, 87.58, 78.00, 53.08]),
        ("stable", ".mu_0.8", [96.61, 95.28, 87.51, 62.54]),
        ("closed", "", [9.88, 22.44, 1.10, 0.0]),
    ] {
        for (base, percentage) in ["12", "15.5", "19", "22.5"].iter().zip(percentages) {
            let key = format!("volume.{quantity}_percent.base_{base}_mm{friction}");
            assert!((computed(&key) - percentage).abs() <= 0.05, "{key}");
        }
    }
    let degrees = 180.0 / std::f64::consts::PI;
    for (key, scale, expected) in [
        ("design.trajectory_min_rad", degrees, 26.03),
        ("design.trajectory_max_rad", degrees, 74.63),
        ("design.mass_min_kg", 1e3, 20.64),
        ("design.mass_max_kg", 1e3, 27.45),
        ("design.mass_kg", 1e3, 24.64),
    ] {
        assert!((computed(key) * scale - expected).abs() < 5e-3, "{key}");
    }
}

/// The counts differ by at most three from the study in every variation.
fn check_variations(reproduction: &Reproduction) {
    let (chaos, simulations) = (&reproduction.near_chaotic, &reproduction.simulations);
    let computed = computed_values(reproduction);
    for (counts, key) in chaos.conditions.iter().zip(["sweep.stable_mu_0", "sweep.stable_mu_0.8"]) {
        assert_eq!(counts.study as f64, computed[key]);
        for count in counts.by_variation {
            assert!(count.abs_diff(counts.study) <= 3 && counts.in_all <= count && count <= counts.in_any);
        }
    }
    assert_eq!((chaos.conditions.len(), simulations.runs.len()), (2, 384));
    assert!(chaos.class_changes.iter().all(|change| change.classes.iter().any(|class| *class != change.class)));
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

fn check_formats(reproduction: &Reproduction, report: &ReproductionReport<'_>) {
    let paper = reproduction.paper();
    assert_eq!(paper.headings().count(), 9);
    let mut title = "";
    for (index, block) in paper.blocks.iter().enumerate() {
        let is_complete = match block {
            Block::Heading(heading) => {
                title = heading;
                !matches!(paper.blocks.get(index + 1), None | Some(Block::Heading(_)))
            }
            // The header is a row.
            Block::Table(table) => {
                let columns = table.rows[0].len();
                table.rows.len() > 1 && !table.caption.is_empty() && table.rows.iter().all(|row| row.len() == columns)
            }
            Block::Figure(figure) => {
                figure.svg.starts_with("<svg") && !figure.svg.contains("NaN") && !figure.caption.is_empty()
            }
            Block::Notes(notes) => !notes.is_empty() && notes.iter().all(|note| note.len() > 10),
            Block::Lines(text) | Block::Paragraph(text) => text.trim().len() > 20,
        };
        assert!(is_complete, "{title}: {block:?}");
    }

    let document: Value = serde_json::from_str(&report.json()).expect("JSON");
    let listed = document["figures"].as_array().expect("figures");
    assert_eq!((listed.len(), &document["outside"]), (figures().len(), &Value::from(0)));
    let (html, markdown) = (report_page(&paper), paper.markdown());
    for (entry, comparison) in listed.iter().zip(&reproduction.comparisons) {
        let key = comparison.figure.key.as_str();
        let value = entry["ours"].as_f64().expect("a number");
        assert_eq!(entry["figure"], key);
        // The JSON parser may be wrong in the last bit.
        assert!((comparison.computed - value).abs() <= 2.0 * f64::EPSILON * value.abs(), "{key}");
        let mark = format!("data-figure=\"{key}\" data-si=\"");
        assert!(html.contains(&mark), "{key} is not in the page");
        for cell in html.split(&mark).skip(1) {
            let (si, rest) = cell.split_once("\">").expect("a cell");
            assert_eq!(si.parse::<f64>().expect("a number"), comparison.computed, "{key}");
            assert_eq!(rest.split('<').next(), Some(comparison.ours_text().as_str()), "{key}");
        }
        assert!(markdown.contains(&comparison.ours_text()), "{key}");
    }
    // The page loads no external resources: the only addresses are SVG namespaces.
    let addresses = ["http://www.w3.org/2000/svg", "http-equiv"].map(|address| html.matches(address).count());
    assert_eq!(html.matches("http").count(), addresses.iter().sum::<usize>());
    assert_eq!(report_page(&reproduction.paper()), html, "the page is reproducible");
}

/// A quick run does not judge volumes; all judged values are as expected.
#[test]
fn command_writes_its_files() {
    let out = directory("reproduce").join("report");
    let document = run_json(&["thesis", "reproduce", "--quick", "--json", "--out", out.to_str().expect("plain text")]);
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
    let selected = succeed_json(&["thesis", "select", &path_in(&out, "results.csv")]);
    assert_eq!(selected["ranking"], document["selection"]["ranking"]);
    assert_rejected(&["thesis", "reproduce", "--out", "Cargo.toml"], &[]);
}
