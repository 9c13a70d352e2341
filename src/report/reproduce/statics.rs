//! The designs, and their statics (thesis §4.2.1, Figs. 4.1–4.3, A.16, A.17, A.24).

use super::Comparison;
use super::comparison_table::{comparison_table, section_comparisons};
use crate::format::percent_of;
use crate::format::report::{Cell, Report};
use crate::plot;
use crate::study::reproduce::Reproduction;

/// Returns the section on lengths, masses and trajectories.
pub fn designs(reproduction: &Reproduction, all: &[Comparison]) -> Report {
    let section = Report::section("The 192 designs").with_paragraph(
        "Four bases, four lengths of l21 within the range that each base allows, four angles φ22 and three ratios l22/l11. \
         Everything else follows from them.",
    );
    let section = comparison_table(section, "Lengths, masses and trajectories.", &section_comparisons(all, "designs"));
    section.with_figure(
        "designs.svg",
        "Varied quantities (blue, Fig. 4.1) and derived quantities (green, Fig. 4.2) by design.",
        plot::selection_variables("thesis", &reproduction.results, &reproduction.selection),
    )
}

/// Builds the section on static stability and form closure.
pub fn section(reproduction: &Reproduction, all: &[Comparison]) -> Report {
    let section = Report::section("Statics and form closure").with_paragraph(
        "A grasp is statically stable if no contact force is tensile (thesis, eq. 2.32), and form-closed if the object and the \
         fingers cannot move with the motors blocked (eqs. 1.15–1.19).",
    );
    let section = comparison_table(section, "Static stability and form closure.", &section_comparisons(all, "statics"));
    let designs = reproduction.selection.designs();
    let row = |sizing: &crate::study::reproduce::OtherSizing| {
        let [without, with] = sizing.stable.map(|count| Cell::new(format!("{count} ({})", percent_of(count, designs))));
        vec![Cell::prose(sizing.name), without, with]
    };
    let section = section.with_table(
        "Influence of sizing: statically stable designs with other torques. The printed ratios are the ratios of the thesis's \
         torques for design 95 to ours.",
        &["torques", "μ_s = 0", "μ_s = 0.8"],
        reproduction.designs.other_sizings.iter().map(row).collect(),
    );
    section.with_figure(
        "static.svg",
        "Static stability, designs sorted by each variable (Figs. 4.3, A.16, A.17).",
        plot::selection_static("thesis", &reproduction.selection),
    )
}
