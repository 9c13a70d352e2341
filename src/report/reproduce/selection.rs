//! Selection (thesis §4.3, Fig. 4.6).

use super::Comparison;
use super::comparison_table::{comparison_table, section_comparisons};
use crate::format::numbers::format_number;
use crate::format::report::{Cell, Report};
use crate::format::{Quantity, condition_name, criterion_name};
use crate::plot;
use crate::study::reproduce::{CHOSEN_DESIGN, Reproduction};
use crate::study::select::{Ranked, Tally};

/// Number of displayed ranked runs.
const MAX_RANKED: usize = 20;

/// Builds the section on the selection of designs.
pub fn section(reproduction: &Reproduction, all: &[Comparison]) -> Report {
    let selection = &reproduction.selection;
    let best = selection.ranking.first().map(|ranked| &selection.runs[ranked.run_index]);
    let best = match best {
        Some(run) if run.design == CHOSEN_DESIGN => format!("The best is design {CHOSEN_DESIGN}, as in the thesis."),
        Some(run) => format!("The best is design {}; the thesis's is {CHOSEN_DESIGN}.", run.design),
        None => "No run is left.".to_string(),
    };
    let section = Report::section("Selection").with_paragraph(format!(
        "Selected runs are statically stable, form-closed, stable or semi-stable, and have a palm force PFP ≥ 0 from their \
         final simulated forces. They are ranked by r_WC, the mean of r(PFP), 1 − r(tts), 1 − r(F21) and r(F22), each scaled \
         over the selected runs. {best}"
    ));
    let section = comparison_table(section, "Selection.", &section_comparisons(all, "selection"));
    let row = |tally: &Tally| {
        let counts = [tally.holds, tally.removed(), tally.remaining, tally.removed_alone];
        std::iter::once(Cell::new(criterion_name(&tally.criterion)))
            .chain(counts.map(|count| Cell::new(count.to_string())))
            .collect()
    };
    let section = section.with_table(
        "Runs that each criterion removes: individually, in sequence, and by it alone.",
        &["criterion", "pass", "fail", "left", "removed by it alone"],
        selection.tallies.iter().map(row).collect(),
    );
    let axes: Vec<(usize, Quantity)> = selection
        .axes
        .iter()
        .enumerate()
        .filter(|(_, axis)| !axis.varies_within_design)
        .map(|(index, axis)| (index, Quantity::for_column(&axis.column)))
        .collect();
    let labels: Vec<String> = axes.iter().map(|(_, quantity)| quantity.label()).collect();
    let mut header = vec!["rank", "design", "condition"];
    header.extend(labels.iter().map(String::as_str));
    header.extend(["PFP, N", "tts, ms", "F21, N", "F22, N", "r_WC"]);
    let row = |ranked: &Ranked| {
        let run = &selection.runs[ranked.run_index];
        let cell = |value: Option<f64>, scale: f64| {
            Cell::new(value.map_or("–".to_string(), |value| format_number(value * scale, 4)))
        };
        let mut cells = vec![
            Cell::new(ranked.rank.to_string()),
            Cell::new(run.design.to_string()),
            Cell::new(condition_name(&selection.conditions[run.condition])),
        ];
        cells.extend(axes.iter().map(|(axis, quantity)| Cell::new(quantity.value(&run.axes[*axis], 4))));
        cells.extend([cell(run.pfp_n, 1.0), cell(run.tts_s, 1e3), cell(run.f21_n, 1.0), cell(run.f22_n, 1.0)]);
        cells.push(Cell::new(format!("{:.3}", ranked.r_wc)));
        cells
    };
    let rows: Vec<Vec<Cell>> = selection.ranking.iter().take(MAX_RANKED).map(row).collect();
    let section = match rows.is_empty() {
        true => section,
        false => section.with_table("Selected runs, best first.", &header, rows),
    };
    section.with_figure(
        "criteria.svg",
        "Designs that each criterion removes, without and with friction (Fig. 4.6).",
        plot::selection_criteria("thesis", selection),
    )
}
