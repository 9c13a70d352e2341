//! Grasp-state volumes (thesis §3.4, Tables 3.3–3.5, Fig. 3.4).

use super::Comparison;
use super::parts::{of_key, ours};
use crate::plot;
use crate::study::reproduce::{CELLS, Grid, Reproduction};
use crate::study::volume::{Quantity, Volume};
use crate::wording::report::{Cell, Report};

const ROWS: [(&str, &str); 5] = [
    ("12 mm", "base_12_mm"),
    ("15.5 mm", "base_15.5_mm"),
    ("19 mm", "base_19_mm"),
    ("22.5 mm", "base_22.5_mm"),
    ("intersection", "all"),
];
const FRICTIONS: [&str; 3] = ["0", "0.4", "0.8"];

/// The section.
pub fn section(found: &Reproduction, all: &[Comparison]) -> Report {
    let resolution = found.volumes.first().map_or([0; 3], Volume::resolution);
    let reasons = [
        "volume.stable_percent.base_22.5_mm.mu_0",
        "volume.palm_percent.base_12_mm.mu_0",
        "volume.closed_percent.base_19_mm",
    ]
    .iter()
    .filter_map(|key| of_key(all, key));
    let reasons: Vec<String> = reasons.map(|of| format!("{}: {}", of.source, of.reason)).collect();
    let mut section = Report::section("Grasp-state volumes")
        .words(format!(
            "All designs over l21 (0–1 of its range), φ22 (90–120°) and l22/l11 (1/3–2/3) at {} × {} × {} points, for four \
             bases and three coefficients of friction: {} points, each sized on its own. Shares are of all points of a \
             volume.",
            resolution[0],
            resolution[1],
            resolution[2],
            found.volumes.iter().map(|volume| volume.points.len()).sum::<usize>()
        ))
        .words(format!("Why ours differ. {}.", reasons.join(". ")));
    for (caption, quantity) in [
        ("Statically stable share of the volume (Table 3.3).", "stable_percent"),
        ("Share that is stable and has a palm force PFP ≥ 0 (Table 3.4).", "palm_percent"),
        ("Largest PFP of the stable region (Table 3.4).", "pfp_max_n"),
    ] {
        section = by_friction(section, caption, quantity, all);
    }
    section = grids(closed(section, all), found);
    let of_base = |base_m: f64| -> Vec<&Volume> {
        found.volumes.iter().filter(|volume| (volume.base_m - base_m).abs() < 1e-9).collect()
    };
    let frictionless = |base_m: f64| of_base(base_m).into_iter().filter(|of| of.mu_static == 0.0).collect::<Vec<_>>();
    section
        .figure(
            "volume-19.svg",
            "The volume of base 19 mm with three frictions: unstable where dark (Fig. 3.4), PFP in the stable region (Fig. A.8).",
            plot::volume_slices(&of_base(0.019), Quantity::Pfp),
        )
        .figure(
            "volume-closed.svg",
            "Form closure in the stable region of base 15.5 mm (Fig. A.11).",
            plot::volume_slices(&frictionless(0.0155), Quantity::FormClosed),
        )
}

/// A row for each base, three columns for each friction.
fn by_friction(section: Report, caption: &str, quantity: &str, all: &[Comparison]) -> Report {
    let mut head = vec!["base".to_string()];
    for mu in FRICTIONS {
        head.extend([format!("μ_s = {mu}: thesis"), "ours".to_string(), "expected".to_string()]);
    }
    let row = |(name, base): &(&str, &str)| {
        let of = FRICTIONS.map(|mu| of_key(all, &format!("volume.{quantity}.{base}.mu_{mu}")));
        if of.iter().all(Option::is_none) {
            return None;
        }
        let cells = of.iter().flat_map(|of| match of {
            Some(of) => [Cell::new(of.thesis_text()), ours(of), Cell::new(of.expected_text())],
            None => [Cell::new("–"), Cell::new("–"), Cell::new("–")],
        });
        Some(std::iter::once(Cell::new(*name)).chain(cells).collect())
    };
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    section.table(caption, &head, ROWS.iter().filter_map(row).collect())
}

/// What points and torques do to the shares.
fn grids(section: Report, found: &Reproduction) -> Report {
    let row = |of: &Grid| {
        let share = |value: f64| Cell::new(format!("{value:.1} %"));
        vec![
            Cell::new(format!("{} mm", short(1e3 * of.base_m))),
            share(of.stable_percent[0]),
            share(of.strong_spring_percent[0]),
            share(of.both_percent[0]),
            share(of.stable_percent[1]),
            share(of.strong_spring_percent[1]),
            share(of.both_percent[1]),
            share(of.closed_percent),
        ]
    };
    section.table(
        &format!(
            "How much is a matter of grids and torques: shares over {CELLS} × {CELLS} × {CELLS} points in the middles of cells, \
             where no point lies on a face of the space (compare it where a share is outside of its expectation); by our torques, with the spring stronger by the ratio of the printed \
             one of design 95 to ours, and with the motor weaker by its ratio too."
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
        found.grids.iter().map(row).collect(),
    )
}

/// A length in mm without the noise of its conversion.
fn short(value_mm: f64) -> f64 {
    (value_mm * 1e6).round() / 1e6
}

/// Form closure knows no friction.
fn closed(section: Report, all: &[Comparison]) -> Report {
    let row = |(name, base): &(&str, &str)| {
        let of = of_key(all, &format!("volume.closed_percent.{base}"))?;
        Some(vec![Cell::new(*name), Cell::new(of.thesis_text()), ours(of), Cell::new(of.expected_text())])
    };
    section.table(
        "Share that is stable without friction and form-closed (Table 3.5).",
        &["base", "thesis", "ours", "expected"],
        ROWS.iter().filter_map(row).collect(),
    )
}
