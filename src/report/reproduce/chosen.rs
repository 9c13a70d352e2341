//! Design 95 with the printed torques, and its CAD model (thesis §4.3, §4.4, Table 4.2, Fig. 4.8).

use super::Comparison;
use super::parts::{compared, of_section};
use crate::plot;
use crate::study::reproduce::{Closing, Reproduction};
use crate::trace::Site;
use crate::wording::figures::figure;
use crate::wording::report::{Cell, Report};

/// The section.
pub fn section(found: &Reproduction, all: &[Comparison]) -> Report {
    let section = Report::section("Design 95 and its CAD model").words(
        "The chosen design closes with the torques the thesis prints (480 and 132.6 N·mm) and μ_s = 0.8, once with the masses \
         of its planar outlines and once with those of the final parts.",
    );
    let mut of = of_section(all, "design 95");
    of.extend(of_section(all, "CAD model"));
    let section = compared(section, "Design 95 and the final parts.", &of);
    let both = [&found.chosen, &found.cad];
    let line = |name: &str, value: &dyn Fn(&Closing) -> Option<f64>, digits: usize| {
        let cell = |of: &&Closing| Cell::new(value(of).map_or("–".to_string(), |value| figure(value, digits)));
        std::iter::once(Cell::new(name)).chain(both.iter().map(cell)).collect::<Vec<_>>()
    };
    let section = section.table(
        "Both closings.",
        &["", found.chosen.name, found.cad.name],
        vec![
            line("mass, g", &|of| Some(of.mass_kg * 1e3), 4),
            line("proximal contact, ms", &|of| of.outcome.site(Site::Proximal).first_s.map(|s| s * 1e3), 5),
            line("distal contact, ms", &|of| of.outcome.site(Site::Distal).first_s.map(|s| s * 1e3), 5),
            line("time to stability, ms", &|of| of.criteria.tts_s.map(|s| s * 1e3), 5),
            line("rebound, %", &|of| of.criteria.rebound_percent, 4),
            line("F21 at the end, N", &|of| Some(of.outcome.last.contact(Site::Proximal).normal_n), 4),
            line("F22 at the end, N", &|of| Some(of.outcome.last.contact(Site::Distal).normal_n), 4),
            line("PFP, N", &|of| Some(of.pfp_n), 4),
        ],
    );
    section.figure(
        "closing.svg",
        "Angles of both closings (Fig. 4.8): the lighter finger is faster.",
        plot::closings("Design 95 and its CAD model", &both),
    )
}
