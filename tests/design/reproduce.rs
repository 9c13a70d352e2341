//! The thesis's figures again: as expected, and told the same in every form.

use std::collections::HashSet;
use std::fs;

use crate::support::cli::{directory, json, phalanx, stderr, stdout};
use phalanx::page::report_page;
use phalanx::report::reproduce::{Comparison, ReproductionReport, Verdict, comparisons};
use phalanx::study::reproduce::{Reproduction, Variation, figures, measured, reproduce};
use phalanx::wording::Reported;
use phalanx::wording::report::{Part, Report};
use serde_json::Value;

/// Everything at once, because everything takes seconds.
#[test]
fn the_thesis_again() {
    let mut parts = Vec::new();
    let found = reproduce(false, 0, &mut |done, total, name| parts.push((done, total, name.to_string())), &|| true)
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(parts.iter().enumerate().all(|(index, part)| part.0 == index && part.1 == parts.len()), "{parts:?}");

    let all = comparisons(&found);
    every_figure_is_found(&found);
    as_expected(&all);
    chaos_is_bounded(&found);
    shares_hang_on_the_grid(&found);
    let report = ReproductionReport::new(&found);
    let paper = report.paper();
    forms_agree(&report, &all, &paper);
}

fn every_figure_is_found(found: &Reproduction) {
    let values = measured(found);
    let keys: HashSet<&str> = figures().iter().map(|figure| figure.key.as_str()).collect();
    for figure in figures() {
        assert!(values.get(&figure.key).is_some_and(|value| value.is_finite()), "{} was not found", figure.key);
    }
    let more: Vec<_> = values.keys().filter(|key| !keys.contains(key.as_str())).collect();
    assert!(more.is_empty(), "found, but compared with nothing: {more:?}");
}

fn as_expected(all: &[Comparison]) {
    let outside: Vec<_> = all.iter().filter(|one| one.verdict == Verdict::Outside).collect();
    let told: Vec<_> = outside.iter().map(|one| (one.figure, one.ours_text(), one.expected_text())).collect();
    // So that `phalanx reproduce` ends with status 0.
    assert!(outside.is_empty(), "{told:?}");
    assert!(all.iter().filter(|one| one.verdict == Verdict::Inside).count() >= 40);
    // The same again from the specification, past the file of figures.
    let ours = |key: &str| all.iter().find(|one| one.figure == key).expect(key).ours;
    assert_eq!((ours("statics.form_closed"), ours("statics.form_closed_quarters")), (22.0, 13.0));
    assert_eq!((ours("statics.stable_mu_0"), ours("statics.stable_mu_0.8")), (136.0, 160.0));
    assert!((ours("sweep.stable_mu_0") - 53.0).abs() <= 3.0 && (ours("sweep.stable_mu_0.8") - 94.0).abs() <= 3.0);
    for (base, shares) in [
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
        assert!(keys.iter().zip(shares).all(|(key, share)| (ours(key) - share).abs() <= 0.05), "base {base} mm");
    }
    assert!((ours("design.trajectory_min_rad").to_degrees() - 26.03).abs() < 5e-3);
    assert!((ours("design.trajectory_max_rad").to_degrees() - 74.63).abs() < 5e-3);
    for (key, grams) in [("design.mass_min_kg", 20.64), ("design.mass_max_kg", 27.45), ("design.mass_kg", 24.64)] {
        assert!((ours(key) * 1e3 - grams).abs() < 5e-3, "{key}");
    }
}

/// Whatever the variation, the counts stay within three of the study's.
fn chaos_is_bounded(found: &Reproduction) {
    let chaos = &found.chaos;
    for (condition, counts) in chaos.stable.iter().enumerate() {
        assert_eq!(counts[0], found.selection.classes[condition].dynamically_stable());
        let (always, ever) = (chaos.always[condition], chaos.ever[condition]);
        assert!(counts.iter().all(|&count| count.abs_diff(counts[0]) <= 3 && always <= count && count <= ever));
    }
    assert!(chaos.flips.iter().all(|flip| flip.classes.iter().any(|class| *class != flip.class)));
    assert!(chaos.flips.iter().all(|flip| flip.classes.len() == Variation::ALL.len()));
}

fn shares_hang_on_the_grid(found: &Reproduction) {
    let [near, second, _, far] = &found.grids[..] else { panic!("four bases") };
    assert!((far.stable_percent[1] - 62.2).abs() < 0.1, "{far:?}");
    assert!((second.closed_percent - 21.5).abs() < 0.1, "{second:?}");
    // A stronger spring lifts tips off, a weaker motor more of them.
    for of in [near, far] {
        for mu in 0..2 {
            assert!(of.stable_percent[mu] > of.strong_spring_percent[mu], "{of:?}");
            assert!(of.strong_spring_percent[mu] > of.both_percent[mu], "{of:?}");
        }
    }
}

fn forms_agree(report: &ReproductionReport<'_>, all: &[Comparison], paper: &Report) {
    let titles: Vec<&str> = paper.headings().collect();
    assert_eq!(titles.len(), 9, "{titles:?}");
    let mut title = "";
    for (index, part) in paper.parts.iter().enumerate() {
        match part {
            Part::Heading(heading) => {
                let next = paper.parts.get(index + 1);
                assert!(next.is_some_and(|part| !matches!(part, Part::Heading(_))), "{heading} is empty");
                title = heading;
            }
            Part::Table(table) => {
                // The head is a row.
                assert!(table.rows.len() > 1 && !table.caption.is_empty(), "{title}: an empty table");
                let wide = table.rows[0].len();
                assert!(table.rows.iter().all(|row| row.len() == wide), "{}: a ragged table", table.caption);
            }
            Part::Figure(figure) => {
                let complete = figure.svg.starts_with("<svg") && !figure.svg.contains("NaN");
                assert!(complete && !figure.caption.is_empty(), "{}", figure.file);
            }
            Part::Notes(notes) => assert!(!notes.is_empty() && notes.iter().all(|note| note.len() > 10)),
            Part::Words(words) | Part::Paragraph(words) => assert!(words.trim().len() > 20, "{words:?}"),
            Part::Text(text) => assert!(!text.id.is_empty() && !text.text.is_empty(), "{}", text.title),
        }
    }

    let document: Value = serde_json::from_str(&report.json()).expect("JSON");
    let listed = document["figures"].as_array().expect("figures");
    assert_eq!((listed.len(), &document["outside"]), (all.len(), &Value::from(outside(all))));
    let html = report_page(paper);
    for of in listed {
        let (key, value) = (of["figure"].as_str().expect("a key"), of["ours"].as_f64().expect("a number"));
        let mark = format!("data-figure=\"{key}\" data-si=\"");
        let shown: Vec<&str> = html.split(&mark).skip(1).collect();
        assert!(!shown.is_empty(), "{key} is not in the page");
        let one = all.iter().find(|one| one.figure == key).expect(key);
        // This reader of JSON may miss the last bit.
        assert!((one.ours - value).abs() <= 2.0 * f64::EPSILON * value.abs(), "{key}");
        for part in shown {
            let (si, rest) = part.split_once("\">").expect("a cell");
            assert_eq!(si.parse::<f64>().expect("a number"), one.ours, "{key}");
            assert_eq!(rest.split('<').next(), Some(one.ours_text().as_str()), "{key}");
        }
    }
    // Nothing from elsewhere: the only addresses are names of the SVG language.
    assert_eq!(
        html.matches("http").count(),
        html.matches("http://www.w3.org/2000/svg").count() + html.matches("http-equiv").count()
    );
    let markdown = paper.markdown();
    assert!(all.iter().all(|one| markdown.contains(&one.ours_text())));
    assert_eq!(report_page(&report.paper()), html, "the same bytes again");
}

fn outside(all: &[Comparison]) -> usize {
    all.iter().filter(|one| one.verdict == Verdict::Outside).count()
}

/// A quick run does not judge volumes, so that everything it judges is as expected.
#[test]
fn the_command_writes_its_files() {
    let out = directory("reproduce").join("report");
    let output = phalanx(&["reproduce", "--quick", "--json", "--out", out.to_str().expect("plain text")]);
    assert_eq!(output.status.code(), Some(0), "{}\n{}", stdout(&output), stderr(&output));
    let document = json(&output);
    let saved: Value =
        serde_json::from_str(&fs::read_to_string(out.join("report.json")).expect("report.json")).expect("JSON");
    assert_eq!((&document, &document["outside"]), (&saved, &Value::from(0)));
    let volumes = document["figures"].as_array().expect("figures").iter().filter(|of| of["section"] == "volumes");
    assert!(volumes.clone().count() > 40 && volumes.clone().all(|of| of["verdict"] == "not judged"));
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
