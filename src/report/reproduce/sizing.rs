//! Sizing (thesis §3.3.2, Figs. 3.1–3.3).

use super::Comparison;
use super::parts::{compared, of_section};
use crate::plot;
use crate::study::reproduce::Reproduction;
use crate::wording::figures::figure;
use crate::wording::report::{Cell, Report};

const EXAMPLE: &str = "base 12 mm, l21 18.9 mm, φ22 100°, r_l 0.5";

/// The section.
pub fn section(found: &Reproduction, all: &[Comparison]) -> Report {
    let profile = &found.sizing.example;
    let section = Report::section("Sizing of spring and motor").words(
        "The motor link follows a polynomial of the 7th order from start to end in 10 ms. The spring must keep the finger \
         rigid until the proximal phalanx meets the object; the motor has the RMS of the torque that this asks for.",
    );
    let section = compared(section, "Sizing of design 95, and what holds in all designs.", &of_section(all, "sizing"));
    let n_mm = |value: f64| Cell::new(figure(value * 1e3, 5));
    let places = ["q21 − q11", "q12", "q22", "q11 + q12 − (q21 + q22)"];
    let row = |(name, torque): (&&str, f64)| vec![Cell::new(*name), n_mm(torque)];
    let section = section.table(
        &format!("Least spring torque by its place, finger of Fig. 3.2 ({EXAMPLE})."),
        &["spring at", "k_s, N·mm"],
        places.iter().zip(profile.placements_n_m).map(row).collect(),
    );
    // Up to the contact both springs are alike.
    let bent = || profile.points.iter().filter(|point| point.net_n_m.is_none());
    let largest = |of: fn(&crate::sizing::ProfilePoint) -> f64| bent().map(of).fold(f64::NEG_INFINITY, f64::max);
    let section = section.table(
        "Largest closing torque of the motor after the proximal contact by type of the spring, same finger; the torsional spring \
         is turned by 90° where the finger is straight, which the thesis does not say.",
        &["spring", "largest torque, N·mm"],
        vec![
            vec![Cell::new("constant"), n_mm(largest(|point| point.constant_n_m))],
            vec![Cell::new("torsional"), n_mm(largest(|point| point.torsional_n_m))],
        ],
    );
    section
        .figure("trajectory.svg", "Test trajectory (Fig. 3.1).", plot::sizing_trajectory("example", profile))
        .figure(
            "springs.svg",
            "Spring torque needed along the swing, by place (Fig. 3.2).",
            plot::sizing_springs("example", profile),
        )
        .figure(
            "spring-types.svg",
            "Motor torque against a constant and a torsional spring (Fig. 3.3).",
            plot::sizing_spring_types("example", profile),
        )
}
