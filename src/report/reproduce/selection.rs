//! Selection (thesis §4.3, Fig. 4.6).

use super::Comparison;
use super::parts::{compared, of_section};
use crate::plot;
use crate::study::reproduce::{CHOSEN, Reproduction};
use crate::study::select::{Ranked, Tally};
use crate::wording::figures::figure;
use crate::wording::report::{Cell, Report};
use crate::wording::{Quantity, condition_name, criterion_name};

/// How many of the ranking are shown.
const BEST: usize = 20;

/// The section.
pub fn section(found: &Reproduction, all: &[Comparison]) -> Report {
    let selection = &found.selection;
    let best = selection.ranking.first().map(|ranked| &selection.runs[ranked.run_index]);
    let best = match best {
        Some(run) if run.design == CHOSEN => format!("The best is design {CHOSEN}, as in the thesis."),
        Some(run) => format!("The best is design {}; the thesis's is {CHOSEN}.", run.design),
        None => "None is left.".to_string(),
    };
    let section = Report::section("Selection").words(format!(
        "Selected is what is statically stable, form-closed, stable or semi-stable, and has a palm force PFP ≥ 0 from its \
         final simulated forces. Those are ranked by r_WC, the mean of r(PFP), 1 − r(tts), 1 − r(F21) and r(F22), each scaled \
         over the selected. {best}"
    ));
    let section = compared(section, "Selection.", &of_section(all, "selection"));
    let row = |tally: &Tally| {
        let counts = [tally.holds, tally.removes(), tally.left, tally.only];
        std::iter::once(Cell::new(criterion_name(&tally.criterion)))
            .chain(counts.map(|count| Cell::new(count.to_string())))
            .collect()
    };
    let section = section.table(
        "What each criterion removed: by itself, one after the other, and what it alone removed.",
        &["criterion", "meet it", "do not", "left", "removed by it alone"],
        selection.tallies.iter().map(row).collect(),
    );
    let axes: Vec<(usize, Quantity)> = selection
        .axes
        .iter()
        .enumerate()
        .filter(|(_, axis)| !axis.again)
        .map(|(index, axis)| (index, Quantity::of(&axis.column)))
        .collect();
    let labels: Vec<String> = axes.iter().map(|(_, quantity)| quantity.label()).collect();
    let mut head = vec!["place", "design", "condition"];
    head.extend(labels.iter().map(String::as_str));
    head.extend(["PFP, N", "tts, ms", "F21, N", "F22, N", "r_WC"]);
    let row = |ranked: &Ranked| {
        let run = &selection.runs[ranked.run_index];
        let some =
            |value: Option<f64>, scale: f64| Cell::new(value.map_or("–".to_string(), |value| figure(value * scale, 4)));
        let mut cells = vec![
            Cell::new(ranked.place.to_string()),
            Cell::new(run.design.to_string()),
            Cell::new(condition_name(&selection.conditions[run.condition])),
        ];
        cells.extend(axes.iter().map(|(axis, quantity)| Cell::new(quantity.value(&run.axes[*axis], 4))));
        cells.extend([some(run.pfp_n, 1.0), some(run.tts_s, 1e3), some(run.f21_n, 1.0), some(run.f22_n, 1.0)]);
        cells.push(Cell::new(format!("{:.3}", ranked.r_wc)));
        cells
    };
    let rows: Vec<Vec<Cell>> = selection.ranking.iter().take(BEST).map(row).collect();
    let section = match rows.is_empty() {
        true => section,
        false => section.table("The selected, best first.", &head, rows),
    };
    section.figure(
        "criteria.svg",
        "What each criterion removed, by design, without and with friction (Fig. 4.6).",
        plot::selection_criteria("thesis", selection),
    )
}
