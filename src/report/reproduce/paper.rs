//! The paper: its sections in order.

use super::parts::{compared, of_key};
use super::{Comparison, ReproductionReport, Verdict, chosen, errata, selection, sizing, statics, sweep, volumes};
use crate::study::reproduce::{DRIFT_S, Reproduction};
use crate::wording::Report;
use crate::wording::duration;

/// The figures that are looked at first.
const FIRST: [&str; 27] = [
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
    /// The paper of a reproduction.
    pub fn paper(&self) -> Report {
        let (found, all) = (self.found, &self.figures);
        let sections = [
            summary(found, all),
            sizing::section(found, all),
            statics::designs(found, all),
            statics::section(found, all),
            volumes::section(found, all),
            sweep::section(found, all),
            selection::section(found, all),
            chosen::section(found, all),
            errata::section(),
        ];
        let all = sections.into_iter().fold(Report::default(), |all, section| all.and(section));
        Report { title: "The thesis again".to_string(), ..all }
    }
}

fn summary(found: &Reproduction, all: &[Comparison]) -> Report {
    let judged = all.iter().filter(|one| one.verdict != Verdict::NotJudged).count();
    let outside: Vec<&Comparison> = all.iter().filter(|one| one.verdict == Verdict::Outside).collect();
    let verdict = match outside.is_empty() {
        true => format!("All {judged} figures that have an expectation are within it."),
        false => format!(
            "{} of {judged} figures that have an expectation are outside of it: {}.",
            outside.len(),
            outside.iter().map(|one| one.what).collect::<Vec<_>>().join("; ")
        ),
    };
    let quick = match found.quick {
        true => " This was a quick run: volumes have fewer points and are not judged.",
        false => "",
    };
    let chaotic = format!(
        "Simulations whose class changes with the method, the tolerance, or a torque nudged by up to 1e-7: {} of {}; whose \
         time to stability moves by more than {}: {}.",
        found.chaos.flips.len(),
        found.selection.runs.len(),
        duration(DRIFT_S),
        found.chaos.drifting.len()
    );
    let section = Report::section("Summary")
        .words(
            "What the thesis prints, what phalanx computes from the corrected equations, and why the two differ where they \
             do. No definition was changed to meet a number. \"Expected\" is what an independent implementation of the same \
             definitions has found.",
        )
        .words(format!("{verdict}{quick} {chaotic}"));
    let first: Vec<&Comparison> = FIRST.iter().filter_map(|key| of_key(all, key)).collect();
    compared(section, "The main figures.", &first)
}
