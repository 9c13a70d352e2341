//! Design 95 with the printed torques, and its CAD model (thesis §4.3, §4.4, Table 4.2, Fig. 4.8).

use super::Comparison;
use super::comparison_table::{comparison_table, section_comparisons};
use crate::format::numbers::format_number;
use crate::format::report::{Cell, Report};
use crate::plot;
use crate::study::reproduce::{Closing, Reproduction};
use crate::trace::FingerContact;

/// Builds the section on the chosen design.
pub fn section(reproduction: &Reproduction, all: &[Comparison]) -> Report {
    let section = Report::section("Design 95 and its CAD model").with_paragraph(
        "The chosen design closes with the torques printed in the thesis (480 and 132.6 N·mm) and μ_s = 0.8, once with the \
         masses of its planar outlines and once with those of the final parts.",
    );
    let mut comparisons = section_comparisons(all, "design 95");
    comparisons.extend(section_comparisons(all, "CAD model"));
    let section = comparison_table(section, "Design 95 and the final parts.", &comparisons);
    let both = [&reproduction.chosen, &reproduction.cad];
    let line = |name: &str, value: &dyn Fn(&Closing) -> Option<f64>, digits: usize| {
        let cell = |closing: &&Closing| {
            Cell::new(value(closing).map_or("–".to_string(), |value| format_number(value, digits)))
        };
        std::iter::once(Cell::new(name)).chain(both.iter().map(cell)).collect::<Vec<_>>()
    };
    let section = section.with_table(
        "Both closings.",
        &["", reproduction.chosen.name, reproduction.cad.name],
        vec![
            line("mass, g", &|closing| Some(closing.mass_kg * 1e3), 4),
            line(
                "proximal contact, ms",
                &|closing| closing.outcome.finger_contact(FingerContact::Proximal).first_s.map(|s| s * 1e3),
                5,
            ),
            line(
                "distal contact, ms",
                &|closing| closing.outcome.finger_contact(FingerContact::Distal).first_s.map(|s| s * 1e3),
                5,
            ),
            line("time to stability, ms", &|closing| closing.criteria.tts_s.map(|s| s * 1e3), 5),
            line("rebound, %", &|closing| closing.criteria.rebound_percent, 4),
            line(
                "F21 at the end, N",
                &|closing| Some(closing.outcome.last.contact(FingerContact::Proximal).normal_n),
                4,
            ),
            line("F22 at the end, N", &|closing| Some(closing.outcome.last.contact(FingerContact::Distal).normal_n), 4),
            line("PFP, N", &|closing| Some(closing.pfp_n), 4),
        ],
    );
    section.with_figure(
        "closing.svg",
        "Angles of both closings (Fig. 4.8): the lighter finger is faster.",
        plot::closings("Design 95 and its CAD model", &both),
    )
}
