//! The designs, and their statics (thesis §4.2.1, Figs. 4.1–4.3, A.16, A.17, A.24).

use super::Comparison;
use super::parts::{compared, of_section};
use crate::plot;
use crate::study::reproduce::Reproduction;
use crate::wording::percent_of;
use crate::wording::report::{Cell, Report};

/// Masses, lengths, trajectories.
pub fn designs(found: &Reproduction, all: &[Comparison]) -> Report {
    let section = Report::section("The 192 designs").words(
        "Four bases, four lengths of l21 within the range that each base allows, four angles φ22 and three ratios l22/l11. \
         Everything else follows from them.",
    );
    let section = compared(section, "Lengths, masses and trajectories.", &of_section(all, "designs"));
    section.figure(
        "designs.svg",
        "What was varied (blue, Fig. 4.1) and what follows from it (green, Fig. 4.2), by design.",
        plot::selection_variables("thesis", &found.results, &found.selection),
    )
}

/// Force positiveness and form closure.
pub fn section(found: &Reproduction, all: &[Comparison]) -> Report {
    let section = Report::section("Statics and form closure").words(
        "A grasp is statically stable if neither phalanx would have to pull (thesis, eq. 2.32), and form-closed if no motion of object and \
         fingers is free with the motors blocked (eqs. 1.15–1.19).",
    );
    let section = compared(section, "Static stability and form closure.", &of_section(all, "statics"));
    let designs = found.selection.designs();
    let row = |of: &crate::study::reproduce::OtherSizing| {
        let [without, with] = of.stable.map(|count| Cell::new(format!("{count} ({})", percent_of(count, designs))));
        vec![Cell::words(of.name), without, with]
    };
    let section = section.table(
        "How much of the difference is sizing: statically stable designs by other torques. The printed ratios are those of \
         the thesis's torques for design 95 to ours.",
        &["torques", "μ_s = 0", "μ_s = 0.8"],
        found.designs.other_sizings.iter().map(row).collect(),
    );
    section.figure(
        "static.svg",
        "Static stability, designs sorted by each variable (Figs. 4.3, A.16, A.17).",
        plot::selection_static("thesis", &found.selection),
    )
}
