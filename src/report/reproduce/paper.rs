//! The paper: its sections in order.

use super::comparison_table::{comparison_table, find_comparison};
use super::{
    Comparison, ReproductionReport, Verdict, chosen_design, errata, selection, sizing, statics, sweep, volumes,
};
use crate::format::Report;
use crate::format::format_duration;
use crate::study::reproduce::{MAX_TTS_DIFFERENCE_S, Reproduction};

/// Keys of the main values, which the summary shows.
const MAIN_VALUES: [&str; 27] = [
    "design.trajectory_min_rad",
    "design.trajectory_max_rad",
    "design.mass_min_kg",
    "design.mass_max_kg",
    "design.mass_kg",
    "statics.stable_mu_0",
    "statics.stable_mu_0.8",
    "sweep.stable_mu_0",
    "sweep.stable_mu_0.8",
    "statics.form_closed",
    "sweep.palm_stable_mu_0",
    "selection.selected",
    "volume.stable_percent.base_12_mm.mu_0",
    "volume.stable_percent.base_15.5_mm.mu_0",
    "volume.stable_percent.base_19_mm.mu_0",
    "volume.stable_percent.base_22.5_mm.mu_0",
    "volume.stable_percent.base_12_mm.mu_0.8",
    "volume.stable_percent.base_15.5_mm.mu_0.8",
    "volume.stable_percent.base_19_mm.mu_0.8",
    "volume.stable_percent.base_22.5_mm.mu_0.8",
    "volume.closed_percent.base_12_mm",
    "volume.closed_percent.base_15.5_mm",
    "volume.closed_percent.base_19_mm",
    "volume.closed_percent.base_22.5_mm",
    "design_95.pfp_n",
    "sizing.motor_rigid_n_m",
    "sizing.spring_n_m",
];

impl ReproductionReport<'_> {
    /// Creates the paper.
    pub fn paper(&self) -> Report {
        let (reproduction, all) = (self.reproduction, &self.comparisons);
        let sections = [
            summary(reproduction, all),
            sizing::section(reproduction, all),
            statics::designs(reproduction, all),
            statics::section(reproduction, all),
            volumes::section(reproduction, all),
            sweep::section(reproduction, all),
            selection::section(reproduction, all),
            chosen_design::section(reproduction, all),
            errata::section(),
        ];
        let paper = sections.into_iter().fold(Report::default(), |paper, section| paper.with(section));
        Report { title: "Reproduction of the thesis".to_string(), ..paper }
    }
}

fn summary(reproduction: &Reproduction, all: &[Comparison]) -> Report {
    let judged = all.iter().filter(|comparison| comparison.verdict != Verdict::NotJudged).count();
    let outside: Vec<&Comparison> = all.iter().filter(|comparison| comparison.verdict == Verdict::Outside).collect();
    let verdict = match outside.is_empty() {
        true => format!("All {judged} values with an expected value are within tolerance."),
        false => format!(
            "{} of {judged} values with an expected value are outside tolerance: {}.",
            outside.len(),
            outside.iter().map(|comparison| comparison.quantity).collect::<Vec<_>>().join("; ")
        ),
    };
    let quick = match reproduction.quick {
        true => " This is a quick run: volumes have fewer points and are not judged.",
        false => "",
    };
    let chaotic = format!(
        "Simulations whose class changes with the method, the tolerance or a torque perturbed by up to 1e-7: {} of {}. \
         Simulations whose time to stability changes by more than {}: {}.",
        reproduction.chaos.class_changes.len(),
        reproduction.selection.runs.len(),
        format_duration(MAX_TTS_DIFFERENCE_S),
        reproduction.chaos.drifting.len()
    );
    let section = Report::section("Summary")
        .with_paragraph(
            "This report compares the values printed in the thesis with the values that phalanx computes from the corrected \
             equations, and explains the differences. No definition was changed to match a number. \"Expected\" values \
             come from an independent implementation of the same definitions.",
        )
        .with_paragraph(format!("{verdict}{quick} {chaotic}"));
    let main: Vec<&Comparison> = MAIN_VALUES.iter().filter_map(|key| find_comparison(all, key)).collect();
    comparison_table(section, "Main values.", &main)
}
