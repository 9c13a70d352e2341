//! The 384 simulations (thesis §4.2, Table 4.1, Figs. 4.3–4.5, A.15, A.18–A.23).

use super::Comparison;
use super::parts::{compared, of_section};
use crate::criteria::Class;
use crate::plot;
use crate::study::reproduce::{Chaos, Checks, DRIFT_S, Reproduction, Variation};
use crate::study::select::{CLASSES, Classes, Selection};
use crate::study::sweep::Status;
use crate::wording::figures::figure;
use crate::wording::report::{Cell, Report};
use crate::wording::{condition_name, duration, percent_of};

/// The section.
pub fn section(found: &Reproduction, all: &[Comparison]) -> Report {
    let selection = &found.selection;
    let section = Report::section("The 384 simulations").words(
        "Every design is simulated for 20 ms without friction and with μ_s = 0.8, with its own spring and motor. Stable: at rest \
         on the object within 15 ms and no rebound; semi-stable: the same with a rebound up to 5 %; semi-unstable: at rest \
         within 20 ms; unstable: the rest, and what is not statically stable.",
    );
    let section = compared(section, "Dynamic stability.", &of_section(all, "sweep"));
    let section = broken(classes(section, selection), selection);
    let section = section.words(checked(&found.checks));
    let section = crossed(section, selection);
    let section = chaos(section, &found.chaos, selection);
    section
        .figure(
            "classes.svg",
            "Dynamic classes, designs sorted by each variable (Figs. 4.4, A.18, A.19).",
            plot::selection_classes("thesis", selection),
        )
        .figure(
            "forces.svg",
            "Final forces of the runs that come to rest, and PFP (Figs. 4.5, A.20–A.23).",
            plot::selection_forces("thesis", selection),
        )
}

/// Runs by class.
fn classes(section: Report, selection: &Selection) -> Report {
    let names: Vec<String> = selection.conditions.iter().map(condition_name).collect();
    let head: Vec<&str> = std::iter::once("class").chain(names.iter().map(String::as_str)).collect();
    let line = |name: &str, count: &dyn Fn(&Classes) -> usize| {
        let cell = |of: &Classes| Cell::new(format!("{} ({})", count(of), percent_of(count(of), of.runs)));
        std::iter::once(Cell::new(name)).chain(selection.classes.iter().map(cell)).collect::<Vec<_>>()
    };
    let mut rows: Vec<Vec<Cell>> = CLASSES
        .into_iter()
        .enumerate()
        .map(|(index, class)| line(class.name(), &move |of: &Classes| of.dynamic[index]))
        .collect();
    rows.push(line("stable or semi-stable", &Classes::dynamically_stable));
    rows.push(line("statically stable", &|of| of.statically_stable));
    section.table("Runs by class (Table 4.1).", &head, rows)
}

/// What became of the runs that did not come to their end.
fn broken(section: Report, selection: &Selection) -> Report {
    let failed: usize = selection.classes.iter().map(|of| of.statuses[Status::Failed as usize]).sum();
    let stable = selection.runs.iter().filter(|run| run.status == Status::Failed && run.force_positive == Some(true));
    match failed {
        0 => section,
        _ => section.words(format!(
            "{failed} runs end where the linkage folds and have no class; {} of them are statically stable. They count as not \
             stable.",
            stable.count()
        )),
    }
}

/// What the checks of the runs say, in words.
pub fn checked(checks: &Checks) -> String {
    let Checks { runs, uncertain, chaotic, unknown, worst_rad } = checks;
    let doubtful = [("uncertain", uncertain), ("chaotic", chaotic), ("not to be checked", unknown)];
    let named = |(what, runs): &(&str, &Vec<i64>)| {
        let numbers: Vec<String> = runs.iter().map(i64::to_string).collect();
        format!("{what}: runs {}", numbers.join(", "))
    };
    let doubts: Vec<String> = doubtful.iter().filter(|(_, runs)| !runs.is_empty()).map(named).collect();
    let sure = runs - uncertain.len() - chaotic.len() - unknown.len();
    let which = if sure == *runs { "all".to_string() } else { sure.to_string() };
    let right = format!(
        "Of {runs} completed runs, each held to another method, {which} are right to {} rad along their path",
        figure(*worst_rad, 2)
    );
    std::iter::once(right).chain(doubts).collect::<Vec<_>>().join("; ") + "."
}

/// Static against dynamic stability, without against with friction.
fn crossed(section: Report, selection: &Selection) -> Report {
    let runs = |condition: usize| selection.runs.iter().filter(move |run| run.condition == condition);
    let good = |class: Option<Class>| matches!(class, Some(Class::Stable | Class::SemiStable));
    // Both conditions are in the order of the designs.
    let pairs: Vec<_> = runs(0).zip(runs(1)).collect();
    let count = |of: fn(bool) -> bool, with: fn(bool) -> bool, dynamic: bool| {
        let stable = |run: &crate::study::select::Candidate| match dynamic {
            true => good(run.class),
            false => run.force_positive == Some(true),
        };
        Cell::new(pairs.iter().filter(|(without, f)| of(stable(without)) && with(stable(f))).count().to_string())
    };
    let yes: fn(bool) -> bool = |stable| stable;
    let no: fn(bool) -> bool = |stable| !stable;
    let line = |name: &str, of, with| vec![Cell::new(name), count(of, with, false), count(of, with, true)];
    section.table(
        "What friction changes, by design (Figs. 4.3, A.15).",
        &["designs", "statics", "dynamics"],
        vec![
            line("stable without and with friction", yes, yes),
            line("stable with friction alone", no, yes),
            line("stable without friction alone", yes, no),
            line("unstable without and with friction", no, no),
        ],
    )
}

/// Counts with their spread, and the runs that make it.
fn chaos(section: Report, chaos: &Chaos, selection: &Selection) -> Report {
    let mut head = vec!["stable or semi-stable", "study"];
    head.extend(Variation::ALL.map(Variation::name));
    head.extend(["in all", "in any"]);
    let line = |condition: usize| {
        let counts = chaos.stable[condition].iter().chain([&chaos.always[condition], &chaos.ever[condition]]);
        let name = condition_name(&selection.conditions[condition]);
        std::iter::once(Cell::new(name)).chain(counts.map(|count| Cell::new(count.to_string()))).collect()
    };
    let section = section
        .words(
            "A rebound multiplies small differences. Every statically stable run was therefore repeated by another method at a \
             hundredth of the tolerance, by that with a torque larger by 1e-7, and as it was with a torque larger by a \
             billionth; where the class changes, it is not a property of the design alone.",
        )
        .table(
            "Dynamically stable runs by variation: the spread of the counts.",
            &head,
            (0..selection.conditions.len()).map(line).collect(),
        );
    let edge = chaos.flips.iter().filter(|flip| !chaos.drifting.contains(&flip.run)).count();
    let section = section.words(format!(
        "Near-chaotic runs, whose time to stability moves by more than {}: {}. Runs whose class changes: {}, of which {edge} at \
         the edge of a class, without moving in time.",
        duration(DRIFT_S),
        chaos.drifting.len(),
        chaos.flips.len()
    ));
    if chaos.flips.is_empty() {
        return section.words("No run changes its class.");
    }
    let mut head = vec!["run", "design", "condition", "study"];
    head.extend(Variation::ALL.map(Variation::name));
    let line = |flip: &crate::study::reproduce::Flip| {
        let mut cells = vec![
            Cell::new(flip.run.to_string()),
            Cell::new(flip.design.to_string()),
            Cell::new(condition_name(&selection.conditions[flip.condition])),
            Cell::new(flip.class.name()),
        ];
        cells.extend(flip.classes.iter().map(|class| Cell::new(class.name())));
        cells
    };
    section.table("Runs whose class changes.", &head, chaos.flips.iter().map(line).collect())
}
