//! Sizing (thesis §3.3.2, Figs. 3.1–3.3).

use super::Comparison;
use super::comparison_table::{comparison_table, section_comparisons};
use crate::format::numbers::format_number;
use crate::format::report::{Cell, Report};
use crate::plot;
use crate::study::reproduce::Reproduction;

const EXAMPLE: &str = "base 12 mm, l21 18.9 mm, φ22 100°, r_l 0.5";

/// Builds the section on sizing.
pub fn section(reproduction: &Reproduction, all: &[Comparison]) -> Report {
    let profile = &reproduction.sizing.example;
    let section = Report::section("Sizing of spring and motor").with_paragraph(
        "The motor link follows a 7th-order polynomial from start to end in 10 ms. The spring must keep the finger rigid until \
         the proximal phalanx contacts the object; the motor torque is the RMS of the required torque.",
    );
    let section =
        comparison_table(section, "Sizing of design 95 and of all designs.", &section_comparisons(all, "sizing"));
    let n_mm = |value: f64| Cell::new(format_number(value * 1e3, 5));
    let positions = ["q21 − q11", "q12", "q22", "q11 + q12 − (q21 + q22)"];
    let row = |(name, torque): (&&str, f64)| vec![Cell::new(*name), n_mm(torque)];
    let section = section.with_table(
        &format!("Smallest spring torque by position of the spring, finger of Fig. 3.2 ({EXAMPLE})."),
        &["spring at", "k_s, N·mm"],
        positions.iter().zip(profile.placements_n_m).map(row).collect(),
    );
    // Before the contact, both springs give the same torque.
    let after_contact = || profile.points.iter().filter(|point| point.net_n_m.is_none());
    let largest =
        |torque: fn(&crate::sizing::ProfilePoint) -> f64| after_contact().map(torque).fold(f64::NEG_INFINITY, f64::max);
    let section = section.with_table(
        "Largest closing torque of the motor after the proximal contact by type of spring, same finger. The torsional spring is \
         deflected by 90° when the finger is straight, which the thesis does not specify.",
        &["spring", "largest torque, N·mm"],
        vec![
            vec![Cell::new("constant"), n_mm(largest(|point| point.constant_n_m))],
            vec![Cell::new("torsional"), n_mm(largest(|point| point.torsional_n_m))],
        ],
    );
    section
        .with_figure("trajectory.svg", "Test trajectory (Fig. 3.1).", plot::sizing_trajectory("example", profile))
        .with_figure(
            "springs.svg",
            "Required spring torque during the swing by position of the spring (Fig. 3.2).",
            plot::sizing_springs("example", profile),
        )
        .with_figure(
            "spring-types.svg",
            "Motor torque with a constant and a torsional spring (Fig. 3.3).",
            plot::sizing_spring_types("example", profile),
        )
}
