//! The 384 simulations (thesis §4.2, Table 4.1, Figs. 4.3–4.5, A.15, A.18–A.23).

use super::Comparison;
use super::comparison_table::{comparison_table, section_comparisons};
use crate::criteria::Class;
use crate::format::numbers::format_number;
use crate::format::report::{Cell, Report};
use crate::format::{condition_name, format_duration, percent_of};
use crate::plot;
use crate::study::reproduce::{Chaos, Checks, MAX_TTS_DIFFERENCE_S, Reproduction, Variation};
use crate::study::select::{CLASSES, ClassCounts, Selection};
use crate::study::sweep::Status;

/// Builds the section on the simulations.
pub fn section(reproduction: &Reproduction, all: &[Comparison]) -> Report {
    let selection = &reproduction.selection;
    let section = Report::section("The 384 simulations").with_paragraph(
        "Every design is simulated for 20 ms without friction and with μ_s = 0.8, with its own spring and motor. Stable: at rest \
         on the object within 15 ms without a rebound; semi-stable: the same with a rebound up to 5 %; semi-unstable: at \
         rest within 20 ms; unstable: all others, including statically unstable designs.",
    );
    let section = comparison_table(section, "Dynamic stability.", &section_comparisons(all, "sweep"));
    let section = incomplete_runs(class_table(section, selection), selection);
    let section = section.with_paragraph(describe_checks(&reproduction.checks));
    let section = friction_table(section, selection);
    let section = chaos(section, &reproduction.chaos, selection);
    section
        .with_figure(
            "classes.svg",
            "Dynamic classes, designs sorted by each variable (Figs. 4.4, A.18, A.19).",
            plot::selection_classes("thesis", selection),
        )
        .with_figure(
            "forces.svg",
            "Final forces of the runs that come to rest, and PFP (Figs. 4.5, A.20–A.23).",
            plot::selection_forces("thesis", selection),
        )
}

/// Adds a table of the runs by class.
fn class_table(section: Report, selection: &Selection) -> Report {
    let names: Vec<String> = selection.conditions.iter().map(condition_name).collect();
    let header: Vec<&str> = std::iter::once("class").chain(names.iter().map(String::as_str)).collect();
    let line = |name: &str, count: &dyn Fn(&ClassCounts) -> usize| {
        let cell =
            |counts: &ClassCounts| Cell::new(format!("{} ({})", count(counts), percent_of(count(counts), counts.runs)));
        std::iter::once(Cell::new(name)).chain(selection.classes.iter().map(cell)).collect::<Vec<_>>()
    };
    let mut rows: Vec<Vec<Cell>> = CLASSES
        .into_iter()
        .enumerate()
        .map(|(index, class)| line(class.name(), &move |counts: &ClassCounts| counts.dynamic[index]))
        .collect();
    rows.push(line("stable or semi-stable", &ClassCounts::dynamically_stable));
    rows.push(line("statically stable", &|counts| counts.statically_stable));
    section.with_table("Runs by class (Table 4.1).", &header, rows)
}

/// Adds a paragraph about the runs that were not completed.
fn incomplete_runs(section: Report, selection: &Selection) -> Report {
    let failed: usize = selection.classes.iter().map(|counts| counts.statuses[Status::Failed as usize]).sum();
    let stable = selection.runs.iter().filter(|run| run.status == Status::Failed && run.force_positive == Some(true));
    match failed {
        0 => section,
        _ => section.with_paragraph(format!(
            "{failed} runs end at a fold of the linkage and have no class; {} of them are statically stable. They count as not \
             stable.",
            stable.count()
        )),
    }
}

/// Describes the results of the checks of the runs.
pub fn describe_checks(checks: &Checks) -> String {
    let Checks { runs, uncertain, chaotic, unknown, worst_rad } = checks;
    let doubtful = [("uncertain", uncertain), ("chaotic", chaotic), ("not checkable", unknown)];
    let list_runs = |(verdict, runs): &(&str, &Vec<i64>)| {
        let numbers: Vec<String> = runs.iter().map(i64::to_string).collect();
        format!("{verdict}: runs {}", numbers.join(", "))
    };
    let doubts: Vec<String> = doubtful.iter().filter(|(_, runs)| !runs.is_empty()).map(list_runs).collect();
    let sure = runs - uncertain.len() - chaotic.len() - unknown.len();
    let count = if sure == *runs { "all".to_string() } else { sure.to_string() };
    let accurate = format!(
        "Of {runs} completed runs, each checked against another integration method, {count} are accurate to {} rad over the trajectory",
        format_number(*worst_rad, 2)
    );
    std::iter::once(accurate).chain(doubts).collect::<Vec<_>>().join("; ") + "."
}

/// Adds a table of static and dynamic stability without and with friction.
fn friction_table(section: Report, selection: &Selection) -> Report {
    let runs = |condition: usize| selection.runs.iter().filter(move |run| run.condition == condition);
    let is_stable_class = |class: Option<Class>| matches!(class, Some(Class::Stable | Class::SemiStable));
    // Both conditions list the designs in the same order.
    let pairs: Vec<_> = runs(0).zip(runs(1)).collect();
    let count = |without: fn(bool) -> bool, with: fn(bool) -> bool, is_dynamic: bool| {
        let is_stable = |run: &crate::study::select::Candidate| match is_dynamic {
            true => is_stable_class(run.class),
            false => run.force_positive == Some(true),
        };
        let matching = pairs.iter().filter(|(a, b)| without(is_stable(a)) && with(is_stable(b)));
        Cell::new(matching.count().to_string())
    };
    let with_stable: fn(bool) -> bool = |stable| stable;
    let with_unstable: fn(bool) -> bool = |stable| !stable;
    let line =
        |name: &str, without, with| vec![Cell::new(name), count(without, with, false), count(without, with, true)];
    section.with_table(
        "Influence of friction on the stability of the designs (Figs. 4.3, A.15).",
        &["designs", "statics", "dynamics"],
        vec![
            line("stable without and with friction", with_stable, with_stable),
            line("stable only with friction", with_unstable, with_stable),
            line("stable only without friction", with_stable, with_unstable),
            line("unstable without and with friction", with_unstable, with_unstable),
        ],
    )
}

/// Adds the spread of the counts over the variations, and the runs that cause it.
fn chaos(section: Report, chaos: &Chaos, selection: &Selection) -> Report {
    let mut header = vec!["stable or semi-stable", "study"];
    header.extend(Variation::ALL.map(Variation::name));
    header.extend(["in all", "in any"]);
    let line = |condition: usize| {
        let counts =
            chaos.stable[condition].iter().chain([&chaos.stable_in_all[condition], &chaos.stable_in_any[condition]]);
        let name = condition_name(&selection.conditions[condition]);
        std::iter::once(Cell::new(name)).chain(counts.map(|count| Cell::new(count.to_string()))).collect()
    };
    let section = section
        .with_paragraph(
            "A rebound amplifies small differences. Every statically stable run is therefore repeated in three variations: with \
             another method at a hundredth of the tolerance, with that method and a torque larger by 1e-7, and with the \
             original method and a torque larger by 1e-9. If the class changes, it is not a property of the design alone.",
        )
        .with_table(
            "Dynamically stable runs by variation: the spread of the counts.",
            &header,
            (0..selection.conditions.len()).map(line).collect(),
        );
    let edge_cases =
        chaos.class_changes.iter().filter(|class_change| !chaos.drifting.contains(&class_change.run)).count();
    let section = section.with_paragraph(format!(
        "Near-chaotic runs, whose time to stability changes by more than {}: {}. Runs whose class changes: {}; {edge_cases} of \
         them are at the limit of a class, with an unchanged time to stability.",
        format_duration(MAX_TTS_DIFFERENCE_S),
        chaos.drifting.len(),
        chaos.class_changes.len()
    ));
    if chaos.class_changes.is_empty() {
        return section.with_paragraph("No run changes its class.");
    }
    let mut header = vec!["run", "design", "condition", "study"];
    header.extend(Variation::ALL.map(Variation::name));
    let line = |class_change: &crate::study::reproduce::ClassChange| {
        let mut cells = vec![
            Cell::new(class_change.run.to_string()),
            Cell::new(class_change.design.to_string()),
            Cell::new(condition_name(&selection.conditions[class_change.condition])),
            Cell::new(class_change.class.name()),
        ];
        cells.extend(class_change.classes.iter().map(|class| Cell::new(class.name())));
        cells
    };
    section.with_table("Runs whose class changes.", &header, chaos.class_changes.iter().map(line).collect())
}
