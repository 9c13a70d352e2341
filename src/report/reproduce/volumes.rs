//! Grasp-state volumes (thesis §3.4, Tables 3.3–3.5, Fig. 3.4).

use super::Comparison;
use super::comparison_table::{computed_cell, find_comparison};
use crate::format::report::{Cell, Report};
use crate::plot;
use crate::study::reproduce::{CELLS_PER_AXIS, Grid, Reproduction};
use crate::study::volume::{Quantity, Volume};

/// Rows of the tables: label and component of the key.
const ROWS: [(&str, &str); 5] = [
    ("12 mm", "base_12_mm"),
    ("15.5 mm", "base_15.5_mm"),
    ("19 mm", "base_19_mm"),
    ("22.5 mm", "base_22.5_mm"),
    ("intersection", "all"),
];
const FRICTIONS: [&str; 3] = ["0", "0.4", "0.8"];

/// Builds the section on grasp-state volumes.
pub fn section(reproduction: &Reproduction, all: &[Comparison]) -> Report {
    let resolution = reproduction.volumes.first().map_or([0; 3], Volume::resolution);
    let reasons = [
        "volume.stable_percent.base_22.5_mm.mu_0",
        "volume.palm_percent.base_12_mm.mu_0",
        "volume.closed_percent.base_19_mm",
    ]
    .iter()
    .filter_map(|key| find_comparison(all, key));
    let reasons: Vec<String> =
        reasons.map(|comparison| format!("{}: {}", comparison.source, comparison.reason)).collect();
    let mut section = Report::section("Grasp-state volumes")
        .with_paragraph(format!(
            "All designs over l21 (0–1 of its range), φ22 (90–120°) and l22/l11 (1/3–2/3) at {} × {} × {} points, for four \
             bases and three coefficients of friction: {} points, each sized individually. Percentages refer to all points \
             of a volume.",
            resolution[0],
            resolution[1],
            resolution[2],
            reproduction.volumes.iter().map(|volume| volume.points.len()).sum::<usize>()
        ))
        .with_paragraph(format!("Reasons for differences. {}.", reasons.join(". ")));
    for (caption, quantity) in [
        ("Statically stable fraction of the volume (Table 3.3).", "stable_percent"),
        ("Stable fraction with a palm force PFP ≥ 0 (Table 3.4).", "palm_percent"),
        ("Largest PFP of the stable region (Table 3.4).", "pfp_max_n"),
    ] {
        section = friction_table(section, caption, quantity, all);
    }
    section = grid_table(form_closure_table(section, all), reproduction);
    let volumes_of_base = |base_m: f64| -> Vec<&Volume> {
        reproduction.volumes.iter().filter(|volume| (volume.base_m - base_m).abs() < 1e-9).collect()
    };
    let frictionless =
        |base_m: f64| volumes_of_base(base_m).into_iter().filter(|volume| volume.mu_static == 0.0).collect::<Vec<_>>();
    section
        .with_figure(
            "volume-19.svg",
            "The volume of base 19 mm with three coefficients of friction: unstable region dark (Fig. 3.4), PFP in the stable region \
             (Fig. A.8).",
            plot::volume_slices(&volumes_of_base(0.019), Quantity::Pfp),
        )
        .with_figure(
            "volume-closed.svg",
            "Form closure in the stable region of base 15.5 mm (Fig. A.11).",
            plot::volume_slices(&frictionless(0.0155), Quantity::FormClosed),
        )
}

/// Adds a table with a row for each base and three columns for each friction.
fn friction_table(section: Report, caption: &str, quantity: &str, all: &[Comparison]) -> Report {
    let mut header = vec!["base".to_string()];
    for mu in FRICTIONS {
        header.extend([format!("μ_s = {mu}: thesis"), "ours".to_string(), "expected".to_string()]);
    }
    let row = |(name, base): &(&str, &str)| {
        let comparisons = FRICTIONS.map(|mu| find_comparison(all, &format!("volume.{quantity}.{base}.mu_{mu}")));
        if comparisons.iter().all(Option::is_none) {
            return None;
        }
        let cells = comparisons.iter().flat_map(|comparison| match comparison {
            Some(comparison) => {
                [Cell::new(comparison.thesis_text()), computed_cell(comparison), Cell::new(comparison.expected_text())]
            }
            None => [Cell::new("–"), Cell::new("–"), Cell::new("–")],
        });
        Some(std::iter::once(Cell::new(*name)).chain(cells).collect())
    };
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    section.with_table(caption, &header, ROWS.iter().filter_map(row).collect())
}

/// Adds a table of the influence of grid points and torques on the stable fractions.
fn grid_table(section: Report, reproduction: &Reproduction) -> Report {
    let row = |grid: &Grid| {
        let percent = |value: f64| Cell::new(format!("{value:.1} %"));
        vec![
            Cell::new(format!("{} mm", without_rounding_error(1e3 * grid.base_m))),
            percent(grid.stable_percent[0]),
            percent(grid.stronger_spring_percent[0]),
            percent(grid.both_torques_percent[0]),
            percent(grid.stable_percent[1]),
            percent(grid.stronger_spring_percent[1]),
            percent(grid.both_torques_percent[1]),
            percent(grid.closed_percent),
        ]
    };
    section.with_table(
        &format!(
            "Influence of grid and torques: percentages over {CELLS_PER_AXIS} × {CELLS_PER_AXIS} × {CELLS_PER_AXIS} cell centres, none of which lies on a \
             face of the space (for comparison with percentages outside tolerance). Columns: our torques; the spring torque \
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
        reproduction.grids.iter().map(row).collect(),
    )
}

/// Rounds a length in mm to remove the rounding error of its conversion.
fn without_rounding_error(value_mm: f64) -> f64 {
    (value_mm * 1e6).round() / 1e6
}

/// Adds a table of form closure, which does not depend on friction.
fn form_closure_table(section: Report, all: &[Comparison]) -> Report {
    let row = |(name, base): &(&str, &str)| {
        let comparison = find_comparison(all, &format!("volume.closed_percent.{base}"))?;
        Some(vec![
            Cell::new(*name),
            Cell::new(comparison.thesis_text()),
            computed_cell(comparison),
            Cell::new(comparison.expected_text()),
        ])
    };
    section.with_table(
        "Fraction that is stable without friction and form-closed (Table 3.5).",
        &["base", "thesis", "ours", "expected"],
        ROWS.iter().filter_map(row).collect(),
    )
}
