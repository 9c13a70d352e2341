//! Section of the paper on grasp-state volumes (thesis §3.4, Tables 3.3–3.5, Fig. 3.4).

use super::designs::CELLS_PER_AXIS;
use super::{Comparison, Grid, Reproduction};
use crate::format::report::{Cell, Report};
use crate::text::rounded_mm;
use crate::volume::{Quantity, Volume, slices};

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

/// Builds the section.
pub fn section(found: &Reproduction) -> Report {
    let [l21, phi22, arm] = found.volumes.first().map_or([0; 3], |volume| volume.axes.resolution());
    let points: usize = found.volumes.iter().map(|volume| volume.points.len()).sum();
    let reasons = [
        "volume.stable_percent.base_22.5_mm.mu_0",
        "volume.palm_percent.base_12_mm.mu_0",
        "volume.closed_percent.base_19_mm",
    ];
    let reasons = reasons.iter().filter_map(|key| found.find(key));
    let reasons: Vec<String> = reasons.map(|of| format!("{}: {}", of.source, of.reason)).collect();
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
        let cells = comparisons.iter().flat_map(|comparison| match comparison {
            Some(of) => [Cell::new(of.thesis_text()), of.cell(), Cell::new(of.expected_text())],
            None => ["–"; 3].map(Cell::new),
        });
        let is_known = comparisons.iter().any(Option::is_some);
        is_known.then(|| std::iter::once(Cell::new(*name)).chain(cells).collect())
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
        std::iter::once(format!("{} mm", rounded_mm(grid.base_m))).chain(percentages).map(Cell::new).collect()
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
