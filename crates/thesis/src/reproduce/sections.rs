//! Sections of the paper on the 384 simulations (thesis §4.2, Table 4.1, Figs. 4.3–4.5, A.15, A.18–A.23), the selection
//! (§4.3, Fig. 4.6) and grasp-state volumes (§3.4, Tables 3.3–3.5, Fig. 3.4).

use super::chaos::{MAX_TTS_DIFFERENCE_S, VARIATIONS};
use super::designs::CELLS_PER_AXIS;
use super::{CHOSEN_DESIGN, Checks, ClassChange, Comparison, Grid, RankedRun, Reproduction, Run};
use crate::criteria::Class;
use crate::format::format_duration;
use crate::format::numbers::format_number;
use crate::format::report::{Cell, Report};
use crate::text::{count_and_share, rounded_mm};
use crate::volume::{Quantity, Volume, slices};

/// Number of displayed ranked runs.
const MAX_RANKED: usize = 20;

/// Returns cells of plain text.
pub(super) fn cells(texts: impl IntoIterator<Item = String>) -> Vec<Cell> {
    texts.into_iter().map(Cell::new).collect()
}

/// Section on the simulations.
pub fn simulations(found: &Reproduction) -> Report {
    let simulations = &found.simulations;
    let section = Report::section("The 384 simulations").with_paragraph(
        "Every design is simulated for 20 ms without friction and with μ_s = 0.8, with its own spring and motor. Stable: at rest \
         on the object within 15 ms without a rebound; semi-stable: the same with a rebound up to 5 %; semi-unstable: at \
         rest within 20 ms; unstable: all others, including statically unstable designs.",
    );
    let section = found.section_table(section, "Dynamic stability.", &["sweep"]);
    let row = |name: &str, test: &dyn Fn(&Run) -> bool| -> Vec<Cell> {
        let share =
            |condition| count_and_share(simulations.count(condition, test), simulations.count(condition, |_| true));
        cells([name.to_string()].into_iter().chain((0..simulations.conditions.len()).map(share)))
    };
    let mut rows: Vec<Vec<Cell>> =
        Class::ALL.into_iter().map(|class| row(class.name(), &|run| run.class == Some(class))).collect();
    rows.push(row("stable or semi-stable", &Run::is_stable));
    rows.push(row("statically stable", &Run::is_statically_stable));
    let header: Vec<&str> = std::iter::once("class").chain(simulations.conditions.iter().map(String::as_str)).collect();
    let mut section = section.with_table("Runs by class (Table 4.1).", &header, rows);
    let failed: Vec<&Run> = simulations.runs.iter().filter(|run| run.is_failed).collect();
    if !failed.is_empty() {
        section = section.with_paragraph(format!(
            "{} runs end at a fold of the linkage and have no class; {} of them are statically stable. They count as not \
             stable.",
            failed.len(),
            failed.iter().filter(|run| run.is_statically_stable()).count()
        ));
    }
    let section = section.with_paragraph(describe_checks(&found.checks));
    // Both conditions list the designs in the same order.
    let pairs: Vec<[&Run; 2]> = {
        let runs = |condition: usize| simulations.runs.iter().filter(move |run| run.condition == condition);
        runs(0).zip(runs(1)).map(|(without, with)| [without, with]).collect()
    };
    let row = |(name, stable): (&str, [bool; 2])| {
        let count = |test: fn(&Run) -> bool| pairs.iter().filter(|pair| pair.map(test) == stable).count().to_string();
        cells([name.to_string(), count(Run::is_statically_stable), count(Run::is_stable)])
    };
    let rows = [
        ("stable without and with friction", [true, true]),
        ("stable only with friction", [false, true]),
        ("stable only without friction", [true, false]),
        ("unstable without and with friction", [false, false]),
    ];
    let section = section.with_table(
        "Influence of friction on the stability of the designs (Figs. 4.3, A.15).",
        &["designs", "statics", "dynamics"],
        rows.map(row).to_vec(),
    );
    let [_, classes, _, forces, _] = simulations.pictures.clone();
    chaos(section, found)
        .with_figure(
            "classes.svg",
            "Dynamic classes, designs sorted by each variable (Figs. 4.4, A.18, A.19).",
            classes,
        )
        .with_figure(
            "forces.svg",
            "Final forces of the runs that come to rest, and PFP (Figs. 4.5, A.20–A.23).",
            forces,
        )
}

/// Describes the results of the checks of the runs.
pub(super) fn describe_checks(checks: &Checks) -> String {
    let Checks { runs, uncertain_runs, chaotic_runs, unknown_runs, worst_error_rad } = checks;
    let exceptions = [("uncertain", uncertain_runs), ("chaotic", chaotic_runs), ("not checkable", unknown_runs)];
    let accurate = match runs - exceptions.map(|(_, runs)| runs.len()).iter().sum::<usize>() {
        accurate if accurate == *runs => "all".to_string(),
        accurate => accurate.to_string(),
    };
    let mut parts = vec![format!(
        "Of {runs} completed runs, each checked against another integration method, {accurate} are accurate to {} rad over the \
         trajectory",
        format_number(*worst_error_rad, 2)
    )];
    let listed = exceptions.into_iter().filter(|(_, runs)| !runs.is_empty());
    parts.extend(listed.map(|(verdict, runs)| format!("{verdict}: runs {}", list_runs(runs))));
    parts.join("; ") + "."
}

/// Returns run numbers as a list.
pub(super) fn list_runs(runs: &[i64]) -> String {
    let numbers = runs.iter().map(i64::to_string).collect::<Vec<_>>().join(", ");
    if runs.is_empty() { "none".to_string() } else { numbers }
}

/// Adds the spread of the counts over the variations, and the runs that cause it.
fn chaos(section: Report, found: &Reproduction) -> Report {
    let (chaos, conditions) = (&found.near_chaotic, &found.simulations.conditions);
    let header = [&["stable or semi-stable", "study"][..], &VARIATIONS, &["in all", "in any"]].concat();
    let spread = chaos.conditions.iter().zip(conditions).map(|(counts, name)| {
        let counts = [&[counts.study][..], &counts.by_variation, &[counts.in_all, counts.in_any]].concat();
        cells([name.clone()].into_iter().chain(counts.iter().map(usize::to_string)))
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
        cells(run.into_iter().chain(classes))
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
        cells([name.clone()].into_iter().chain(counts.iter().map(usize::to_string)))
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
        cells([&name[..], &ranked.axes, &results, &[format!("{:.3}", ranked.r_wc)]].concat())
    };
    let rows = simulations.ranking.iter().take(MAX_RANKED).map(row).collect();
    section.with_table("Selected runs, best first.", &header, rows).with_figure(
        "criteria.svg",
        "Designs that each criterion removes, without and with friction (Fig. 4.6).",
        simulations.pictures[0].clone(),
    )
}

/// Rows of the tables: label and component of the key.
const ROWS: [(&str, &str); 5] = [
    ("12 mm", "base_12_mm"),
    ("15.5 mm", "base_15.5_mm"),
    ("19 mm", "base_19_mm"),
    ("22.5 mm", "base_22.5_mm"),
    ("intersection", "all"),
];
/// Friction coefficients of Tables 3.3 and 3.4, as in the keys.
const FRICTIONS: [&str; 3] = [".mu_0", ".mu_0.4", ".mu_0.8"];

/// Section on the volumes.
pub fn volumes(found: &Reproduction) -> Report {
    let [l21, phi22, arm] = found.volumes.first().map_or([0; 3], |volume| volume.axes.resolution());
    let points: usize = found.volumes.iter().map(|volume| volume.points.len()).sum();
    let reasons = [
        "volume.stable_percent.base_22.5_mm.mu_0",
        "volume.palm_percent.base_12_mm.mu_0",
        "volume.closed_percent.base_19_mm",
    ];
    let reasons = reasons.iter().filter_map(|key| found.find(key));
    let reasons: Vec<String> = reasons.map(|of| format!("{}: {}", of.figure.source, of.reason)).collect();
    let mut section = Report::section("Grasp-state volumes")
        .with_paragraph(format!(
            "All designs over l21 (0–1 of its range), φ22 (90–120°) and l22/l11 (1/3–2/3) at {l21} × {phi22} × {arm} points, for \
             four bases and three coefficients of friction: {points} points, each sized individually. Percentages refer to all points \
             of a volume."
        ))
        .with_paragraph(format!("Reasons for differences. {}.", reasons.join(". ")));
    for (caption, quantity, frictions) in [
        ("Statically stable fraction of the volume (Table 3.3).", "stable_percent", &FRICTIONS[..]),
        ("Stable fraction with a palm force PFP ≥ 0 (Table 3.4).", "palm_percent", &FRICTIONS),
        ("Largest PFP of the stable region (Table 3.4).", "pfp_max_n", &FRICTIONS),
        // Form closure does not depend on friction.
        ("Fraction that is stable without friction and form-closed (Table 3.5).", "closed_percent", &[""]),
    ] {
        section = base_table(section, caption, quantity, frictions, found);
    }
    let volumes_of = |base_m: f64| found.volumes.iter().filter(move |volume| (volume.base_m - base_m).abs() < 1e-9);
    let all: Vec<Vec<&Volume>> = volumes_of(0.019).map(|volume| vec![volume]).collect();
    let frictionless = volumes_of(0.0155).filter(|volume| volume.mu_static == 0.0);
    grid_table(section, &found.grids)
        .with_figure(
            "volume-19.svg",
            "The volume of base 19 mm with three coefficients of friction: unstable region dark (Fig. 3.4), PFP in the stable region \
             (Fig. A.8).",
            slices(&all, Quantity::Pfp),
        )
        .with_figure(
            "volume-closed.svg",
            "Form closure in the stable region of base 15.5 mm (Fig. A.11).",
            slices(&frictionless.map(|volume| vec![volume]).collect::<Vec<_>>(), Quantity::FormClosed),
        )
}

/// Adds a table with a row for each base and three columns for each friction.
fn base_table(section: Report, caption: &str, quantity: &str, frictions: &[&str], found: &Reproduction) -> Report {
    let mut header = vec!["base".to_string()];
    for friction in frictions {
        let mu = friction.strip_prefix(".mu_").map_or(String::new(), |mu| format!("μ_s = {mu}: "));
        header.extend([format!("{mu}thesis"), "ours".to_string(), "expected".to_string()]);
    }
    let row = |(name, base): &(&str, &str)| {
        let comparisons: Vec<Option<&Comparison>> =
            frictions.iter().map(|friction| found.find(&format!("volume.{quantity}.{base}{friction}"))).collect();
        let values = comparisons.iter().flat_map(|comparison| match comparison {
            Some(of) => [Cell::new(of.thesis_text()), of.cell(), Cell::new(of.expected_text())],
            None => ["–"; 3].map(Cell::new),
        });
        let is_known = comparisons.iter().any(Option::is_some);
        is_known.then(|| std::iter::once(Cell::new(*name)).chain(values).collect())
    };
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    section.with_table(caption, &header, ROWS.iter().filter_map(row).collect())
}

/// Adds a table of the influence of grid points and torques on the stable fractions.
fn grid_table(section: Report, grids: &[Grid]) -> Report {
    let row = |grid: &Grid| {
        let torques = [grid.stable_percent, grid.stronger_spring_percent, grid.both_torques_percent];
        let percentages = [0, 1].into_iter().flat_map(|mu| torques.map(|percent| percent[mu]));
        let percentages = percentages.chain([grid.closed_percent]).map(|percent| format!("{percent:.1} %"));
        cells([format!("{} mm", rounded_mm(grid.base_m))].into_iter().chain(percentages))
    };
    section.with_table(
        &format!(
            "Influence of grid and torques: percentages over {CELLS_PER_AXIS} × {CELLS_PER_AXIS} × {CELLS_PER_AXIS} cell centres, which do not lie on the \
             faces of the space (for comparison with percentages outside tolerance). Columns: our torques; the spring torque \
             scaled by the ratio of the printed one of design 95 to ours; the motor torque scaled by its ratio as well."
        ),
        &[
            "base",
            "stable, μ_s = 0",
            "strong spring",
            "and weak motor",
            "stable, μ_s = 0.8",
            "strong spring",
            "and weak motor",
            "form-closed",
        ],
        grids.iter().map(row).collect(),
    )
}
