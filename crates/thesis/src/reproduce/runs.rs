//! Sections of the paper on the 384 simulations (thesis §4.2, Table 4.1, Figs. 4.3–4.5, A.15, A.18–A.23) and the
//! selection (thesis §4.3, Fig. 4.6).

use super::simulations::{RankedRun, Run, is_stable};
use super::{CHOSEN_DESIGN, Checks, ClassChange, MAX_TTS_DIFFERENCE_S, Reproduction, Simulations, VARIATIONS};
use crate::criteria::Class;
use crate::format::format_duration;
use crate::format::numbers::format_number;
use crate::format::report::{Cell, Report};
use crate::text::count_and_share;

/// Number of displayed ranked runs.
const MAX_RANKED: usize = 20;

/// Section on the simulations.
pub fn simulations(found: &Reproduction) -> Report {
    let simulations = &found.simulations;
    let section = Report::section("The 384 simulations").with_paragraph(
        "Every design is simulated for 20 ms without friction and with μ_s = 0.8, with its own spring and motor. Stable: at rest \
         on the object within 15 ms without a rebound; semi-stable: the same with a rebound up to 5 %; semi-unstable: at \
         rest within 20 ms; unstable: all others, including statically unstable designs.",
    );
    let section = found.section_table(section, "Dynamic stability.", &["sweep"]);
    let section = incomplete_runs(class_table(section, simulations), simulations);
    let section = section.with_paragraph(describe_checks(&found.checks));
    let section = chaos(friction_table(section, simulations), found);
    let caption = "Dynamic classes, designs sorted by each variable (Figs. 4.4, A.18, A.19).";
    let section = simulations.add_picture(section, "classes.svg", caption);
    let caption = "Final forces of the runs that come to rest, and PFP (Figs. 4.5, A.20–A.23).";
    simulations.add_picture(section, "forces.svg", caption)
}

/// Adds a table of the runs by class.
fn class_table(section: Report, simulations: &Simulations) -> Report {
    let conditions = 0..simulations.conditions.len();
    let row = |name: &str, test: &dyn Fn(&Run) -> bool| -> Vec<Cell> {
        let cell = |condition: usize| {
            let (count, total) = (simulations.count(condition, test), simulations.count(condition, |_| true));
            Cell::new(count_and_share(count, total))
        };
        std::iter::once(Cell::new(name)).chain(conditions.clone().map(cell)).collect()
    };
    let mut rows: Vec<Vec<Cell>> =
        Class::ALL.into_iter().map(|class| row(class.name(), &|run| run.class == Some(class))).collect();
    rows.push(row("stable or semi-stable", &|run| is_stable(run.class)));
    rows.push(row("statically stable", &|run| run.force_positive == Some(true)));
    let header: Vec<&str> = std::iter::once("class").chain(simulations.conditions.iter().map(String::as_str)).collect();
    section.with_table("Runs by class (Table 4.1).", &header, rows)
}

/// Adds a paragraph about the runs that were not completed.
fn incomplete_runs(section: Report, simulations: &Simulations) -> Report {
    let failed = || simulations.runs.iter().filter(|run| run.is_failed);
    match failed().count() {
        0 => section,
        count => section.with_paragraph(format!(
            "{count} runs end at a fold of the linkage and have no class; {} of them are statically stable. They count as not \
             stable.",
            failed().filter(|run| run.force_positive == Some(true)).count()
        )),
    }
}

/// Describes the results of the checks of the runs.
pub(crate) fn describe_checks(checks: &Checks) -> String {
    let Checks { runs, uncertain, chaotic, unknown, worst_rad } = checks;
    let accurate = match runs - uncertain.len() - chaotic.len() - unknown.len() {
        accurate if accurate == *runs => "all".to_string(),
        accurate => accurate.to_string(),
    };
    let mut parts = vec![format!(
        "Of {runs} completed runs, each checked against another integration method, {accurate} are accurate to {} rad over the \
         trajectory",
        format_number(*worst_rad, 2)
    )];
    for (verdict, runs) in [("uncertain", uncertain), ("chaotic", chaotic), ("not checkable", unknown)] {
        if !runs.is_empty() {
            parts.push(format!("{verdict}: runs {}", list_runs(runs)));
        }
    }
    parts.join("; ") + "."
}

/// Returns run numbers as a list.
pub(crate) fn list_runs(runs: &[i64]) -> String {
    let numbers = runs.iter().map(i64::to_string).collect::<Vec<_>>().join(", ");
    if runs.is_empty() { "none".to_string() } else { numbers }
}

/// Adds a table of static and dynamic stability without and with friction.
fn friction_table(section: Report, simulations: &Simulations) -> Report {
    let runs = |condition: usize| simulations.runs.iter().filter(move |run| run.condition == condition);
    // Both conditions list the designs in the same order.
    let count = |stable: [bool; 2], test: fn(&Run) -> bool| {
        let pairs = runs(0).zip(runs(1)).map(|(without, with)| [test(without), test(with)]);
        Cell::new(pairs.filter(|pair| *pair == stable).count().to_string())
    };
    let row = |(name, stable): (&str, [bool; 2])| {
        let statics = count(stable, |run| run.force_positive == Some(true));
        vec![Cell::new(name), statics, count(stable, |run| is_stable(run.class))]
    };
    let rows = [
        ("stable without and with friction", [true, true]),
        ("stable only with friction", [false, true]),
        ("stable only without friction", [true, false]),
        ("unstable without and with friction", [false, false]),
    ];
    section.with_table(
        "Influence of friction on the stability of the designs (Figs. 4.3, A.15).",
        &["designs", "statics", "dynamics"],
        rows.map(row).to_vec(),
    )
}

/// Adds the spread of the counts over the variations, and the runs that cause it.
fn chaos(section: Report, found: &Reproduction) -> Report {
    let (chaos, conditions) = (&found.near_chaotic, &found.simulations.conditions);
    let header = [&["stable or semi-stable", "study"][..], &VARIATIONS, &["in all", "in any"]].concat();
    let spread = chaos.conditions.iter().zip(conditions).map(|(counts, name)| {
        let counts = [&[counts.study][..], &counts.by_variation, &[counts.in_all, counts.in_any]].concat();
        std::iter::once(Cell::new(name)).chain(counts.iter().map(|count| Cell::new(count.to_string()))).collect()
    });
    let edge_cases =
        chaos.class_changes.iter().filter(|class_change| !chaos.drifting_runs.contains(&class_change.run)).count();
    let section = section
        .with_paragraph(
            "A rebound amplifies small differences. Every statically stable run is therefore repeated in three variations: with \
             another method at a hundredth of the tolerance, with that method and a torque larger by 1e-7, and with the \
             original method and a torque larger by 1e-9. If the class changes, it is not a property of the design alone.",
        )
        .with_table("Dynamically stable runs by variation: the spread of the counts.", &header, spread.collect())
        .with_paragraph(format!(
            "Near-chaotic runs, whose time to stability changes by more than {}: {}. Runs whose class changes: {}; {edge_cases} of \
             them are at the limit of a class, with an unchanged time to stability.",
            format_duration(MAX_TTS_DIFFERENCE_S),
            chaos.drifting_runs.len(),
            chaos.class_changes.len()
        ));
    if chaos.class_changes.is_empty() {
        return section.with_paragraph("No run changes its class.");
    }
    let header = [&["run", "design", "condition", "study"][..], &VARIATIONS].concat();
    let row = |change: &ClassChange| {
        let run = [change.run.to_string(), change.design.to_string(), conditions[change.condition].clone()];
        let classes = std::iter::once(&change.class).chain(&change.classes).map(|class| class.name().to_string());
        run.into_iter().chain(classes).map(Cell::new).collect()
    };
    section.with_table("Runs whose class changes.", &header, chaos.class_changes.iter().map(row).collect())
}

/// Section on the selection of designs.
pub fn selection(found: &Reproduction) -> Report {
    let simulations = &found.simulations;
    let best = match simulations.ranking.first().map(|ranked| simulations.runs[ranked.run].design) {
        Some(CHOSEN_DESIGN) => format!("The best is design {CHOSEN_DESIGN}, as in the thesis."),
        Some(design) => format!("The best is design {design}; the thesis's is {CHOSEN_DESIGN}."),
        None => "No run is left.".to_string(),
    };
    let section = Report::section("Selection").with_paragraph(format!(
        "Selected runs are statically stable, form-closed, stable or semi-stable, and have a palm force PFP ≥ 0 from their \
         final simulated forces. They are ranked by r_WC, the mean of r(PFP), 1 − r(tts), 1 − r(F21) and r(F22), each scaled \
         over the selected runs. {best}"
    ));
    let row = |(name, counts): &(String, [usize; 4])| {
        std::iter::once(Cell::new(name)).chain(counts.map(|count| Cell::new(count.to_string()))).collect()
    };
    let section = found.section_table(section, "Selection.", &["selection"]).with_table(
        "Runs that each criterion removes: individually, in sequence, and by it alone.",
        &["criterion", "pass", "fail", "left", "removed by it alone"],
        simulations.criteria.iter().map(row).collect(),
    );
    let axes: Vec<&str> = simulations.axes.iter().map(String::as_str).collect();
    let results = ["PFP, N", "tts, ms", "F21, N", "F22, N", "r_WC"];
    let header = [&["rank", "design", "condition"][..], &axes, &results].concat();
    let row = |ranked: &RankedRun| {
        let run = &simulations.runs[ranked.run];
        let number = |value: Option<f64>| value.map_or("–".to_string(), |value| format_number(value, 4));
        let name = [ranked.rank.to_string(), run.design.to_string(), simulations.conditions[run.condition].clone()];
        let results = [run.pfp_n, run.tts_s.map(|tts_s| tts_s * 1e3), run.f21_n, run.f22_n].map(number);
        let cells = name.iter().chain(&ranked.axes).chain(&results).map(Cell::new);
        cells.chain([Cell::new(format!("{:.3}", ranked.r_wc))]).collect()
    };
    let rows = simulations.ranking.iter().take(MAX_RANKED).map(row).collect();
    let section = section.with_table("Selected runs, best first.", &header, rows);
    let caption = "Designs that each criterion removes, without and with friction (Fig. 4.6).";
    simulations.add_picture(section, "criteria.svg", caption)
}
