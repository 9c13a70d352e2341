//! Figures of the thesis, with the values expected from a correct implementation, the reasons for
//! differences, the computed values, and their comparison.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::{CHOSEN_DESIGN, Reproduction, Run};
use crate::format::report::{Cell, CellStyle};
use crate::gripper::{Finger, total_mass};
use crate::text::{UNITS, rounded_mm};
use crate::trace::FingerContact;
use crate::volume::{count_volume, intersections};

/// One figure of the thesis: a row of `thesis.csv`. Its numbers are in the unit of the thesis. The key contains the SI
/// unit of the value, either at its end or before the first `.base`, `.mu` or `.all`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Figure {
    #[serde(rename(serialize = "figure"))]
    pub key: String,
    pub section: String,
    /// Table, figure, section or equation of the thesis that contains the figure.
    pub source: String,
    #[serde(rename = "what")]
    pub quantity: String,
    #[serde(skip_serializing)]
    pub unit: String,
    /// Printed text; it also defines the number of digits. May be empty.
    #[serde(rename = "thesis", skip_serializing)]
    pub printed: String,
    /// Text of the value that a correct implementation gives; may be empty.
    #[serde(skip_serializing)]
    pub expected: String,
    /// Allowed deviation from the expected value.
    #[serde(rename = "within", skip_serializing)]
    pub tolerance: Option<f64>,
    /// Key of a [`Reason`]; empty if the printed and the expected value agree.
    #[serde(skip_serializing)]
    pub reason: String,
}

/// Reason for a difference between the printed and the expected value.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct Reason {
    /// Numbers of the errata that explain the difference.
    pub errata: Vec<u32>,
    pub text: String,
}

/// Returns all figures, in the order of `thesis.csv`.
pub fn figures() -> &'static [Figure] {
    static PARSED: OnceLock<Vec<Figure>> = OnceLock::new();
    PARSED.get_or_init(|| {
        let mut reader = csv::Reader::from_reader(&include_bytes!("thesis.csv")[..]);
        reader.deserialize().map(|figure| figure.expect("the embedded file is valid")).collect()
    })
}

/// Returns the reasons by key.
pub fn reasons() -> &'static BTreeMap<String, Reason> {
    static PARSED: OnceLock<BTreeMap<String, Reason>> = OnceLock::new();
    PARSED.get_or_init(|| toml::from_str(include_str!("reasons.toml")).expect("the embedded file is valid"))
}

impl Figure {
    /// Returns the factor that converts SI units to the unit of the thesis.
    pub fn scale(&self) -> f64 {
        UNITS.iter().find(|(unit, ..)| *unit == self.unit).expect("a unit of the list").1
    }

    /// Returns a printed or expected value in SI units.
    fn si(&self, text: &str) -> Option<f64> {
        (!text.is_empty()).then(|| text.parse::<f64>().expect("a number") / self.scale())
    }
}

/// Returns the number of decimals of a printed number.
fn decimals(text: &str) -> usize {
    text.split_once('.').map_or(0, |(_, fraction)| fraction.len())
}

/// Whether a computed value is as expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    Inside,
    Outside,
    /// There is no expected value, or the computation has a reduced resolution.
    #[serde(rename = "not judged")]
    NotJudged,
}

/// One compared value, in SI units.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    #[serde(flatten)]
    pub figure: &'static Figure,
    pub thesis: Option<f64>,
    /// Computed value; NaN (null in JSON) if there is none.
    #[serde(rename = "ours")]
    pub computed: f64,
    pub expected: Option<f64>,
    pub expected_within: Option<f64>,
    pub verdict: Verdict,
    pub errata: &'static [u32],
    pub reason: &'static str,
}

/// Compares computed values with all figures, in the order of `thesis.csv`. With `quick`, volumes are not judged,
/// because the expected values refer to the full resolution.
pub fn compare(values: &BTreeMap<String, f64>, quick: bool) -> Vec<Comparison> {
    let compare = |figure: &'static Figure| {
        let computed = values.get(&figure.key).copied().unwrap_or(f64::NAN);
        let (errata, reason) =
            reasons().get(&figure.reason).map_or((&[][..], ""), |reason| (&reason.errata, &reason.text));
        let (expected, tolerance) = (figure.si(&figure.expected), figure.tolerance.unwrap_or(0.0) / figure.scale());
        let verdict = match expected.filter(|_| !(quick && figure.section == "volumes")) {
            None => Verdict::NotJudged,
            // The margin accepts values at the edge of the rounding interval.
            Some(expected) if (computed - expected).abs() <= tolerance + 1e-9 * expected.abs() => Verdict::Inside,
            Some(_) => Verdict::Outside,
        };
        let (thesis, expected_within) = (figure.si(&figure.printed), expected.map(|_| tolerance));
        Comparison { figure, thesis, computed, expected, expected_within, verdict, errata, reason }
    };
    figures().iter().map(compare).collect()
}

impl Comparison {
    /// Returns the value printed in the thesis, with its unit.
    pub(crate) fn thesis_text(&self) -> String {
        if self.figure.printed.is_empty() { "–".to_string() } else { self.with_unit(&self.figure.printed) }
    }

    /// Returns the computed value with as many digits as in the thesis or in the expected value.
    pub fn ours_text(&self) -> String {
        if self.computed.is_finite() { self.with_unit(&self.rounded(self.computed)) } else { "none".to_string() }
    }

    /// Returns the expected value with its tolerance.
    pub fn expected_text(&self) -> String {
        let Some(expected) = self.expected else { return "–".to_string() };
        let value = self.rounded(expected);
        match self.figure.tolerance {
            None | Some(0.0) => self.with_unit(&value),
            Some(tolerance) => self.with_unit(&format!("{value} ± {tolerance}")),
        }
    }

    /// Returns the reason for the difference with its errata; empty if the computed value rounds to the printed one.
    pub(crate) fn reason_text(&self) -> String {
        let printed = &self.figure.printed;
        let matches_printed = format!("{:.*}", decimals(printed), self.computed * self.figure.scale()) == *printed;
        if self.reason.is_empty() || matches_printed && self.verdict != Verdict::Outside {
            return String::new();
        }
        let errata: Vec<String> = self.errata.iter().map(u32::to_string).collect();
        match errata.is_empty() {
            true => self.reason.to_string(),
            false => format!("{} (errata {})", self.reason, errata.join(", ")),
        }
    }

    /// Returns a cell with the computed value, styled by its verdict.
    pub fn cell(&self) -> Cell {
        let style = match self.verdict {
            Verdict::Inside => CellStyle::Good,
            Verdict::Outside => CellStyle::Bad,
            Verdict::NotJudged => CellStyle::Plain,
        };
        let figure = Some((self.figure.key.clone(), self.computed));
        Cell { text: self.ours_text(), figure, style }
    }

    fn rounded(&self, value: f64) -> String {
        // The digits of the printed or of the expected value, whichever has more.
        let decimals = decimals(&self.figure.printed).max(decimals(&self.figure.expected));
        let text = format!("{:.decimals$}", value * self.figure.scale());
        // Negative zero is shown as zero.
        let is_zero = text.trim_start_matches(['-', '0', '.']).is_empty();
        text.replace('-', if is_zero { "" } else { "−" })
    }

    fn with_unit(&self, text: &str) -> String {
        match self.figure.unit.as_str() {
            "" => text.to_string(),
            "°" => format!("{text}°"),
            unit => format!("{text} {unit}"),
        }
    }
}

/// Returns a value for every key of [`figures`], in SI units.
pub fn computed_values(found: &Reproduction) -> BTreeMap<String, f64> {
    let Reproduction { sizing, simulations, necessary_count: necessary, chosen, cad, .. } = found;
    let count = |condition: usize, property: fn(&Run) -> bool| simulations.count(condition, property) as f64;
    let ranked = simulations.ranking.iter().find(|ranked| simulations.runs[ranked.run].design == CHOSEN_DESIGN);
    let Some(Finger { lengths, bodies, .. }) = simulations.chosen().map(|run| run.scene.finger().linkage) else {
        return BTreeMap::new();
    };
    let final_force_n = |contact| chosen.outcome.last.finger_contact(contact).normal_n;
    let palm_stable = |run: &Run| run.is_stable() && run.pfp_n.is_some_and(|pfp_n| pfp_n >= 0.0);
    let values = [
        ("sizing.motor_rigid_n_m", sizing.rigid.motor_n_m),
        ("sizing.motor_whole_n_m", sizing.whole.motor_n_m),
        ("sizing.spring_n_m", sizing.rigid.spring_n_m),
        ("sizing.best_places", sizing.last_placements_weakest as f64),
        ("sizing.constant_better", sizing.constant_spring_weaker as f64),
        ("design.l21_m", lengths.l21_m),
        ("design.l12_m", lengths.l12_m),
        ("design.l22_m", lengths.l22_m),
        ("design.t22_m", lengths.t22_m),
        ("design.mass_l11_kg", bodies.l11.mass_kg),
        ("design.mass_l21_kg", bodies.l21.mass_kg),
        ("design.mass_l12_kg", bodies.l12.mass_kg),
        ("design.mass_l22_kg", bodies.l22.mass_kg),
        ("design.mass_kg", total_mass(&bodies)),
        ("design.mass_min_kg", simulations.mass_kg[0]),
        ("design.mass_max_kg", simulations.mass_kg[1]),
        ("design.trajectory_min_rad", simulations.trajectory_rad[0]),
        ("design.trajectory_max_rad", simulations.trajectory_rad[1]),
        ("statics.form_closed_quarters", found.form_closed_quarters as f64),
        ("statics.constraints", (necessary.contacts + necessary.motors) as f64),
        ("statics.constraints_needed", (necessary.hand + necessary.object + 1) as f64),
        ("statics.stable_mu_0", count(0, Run::is_statically_stable)),
        ("statics.stable_mu_0.8", count(1, Run::is_statically_stable)),
        ("statics.form_closed", count(0, |run| run.form_closed == Some(true))),
        ("sweep.stable_mu_0", count(0, Run::is_stable)),
        ("sweep.stable_mu_0.8", count(1, Run::is_stable)),
        ("sweep.palm_stable_mu_0", count(0, palm_stable)),
        ("selection.selected", simulations.ranking.len() as f64),
        ("selection.place_95", ranked.map_or(f64::NAN, |ranked| ranked.rank as f64)),
        ("selection.r_wc_95", ranked.map_or(f64::NAN, |ranked| ranked.r_wc)),
        ("design_95.pfp_n", chosen.pfp_n),
        ("design_95.tts_s", chosen.criteria.tts_s.unwrap_or(f64::NAN)),
        ("design_95.f21_n", final_force_n(FingerContact::Proximal)),
        ("design_95.f22_n", final_force_n(FingerContact::Distal)),
        ("cad.mass_kg", cad.mass_kg),
        ("cad.saved_percent", 100.0 * (1.0 - cad.mass_kg / chosen.mass_kg)),
        ("cad.tts_s", cad.criteria.tts_s.unwrap_or(f64::NAN)),
    ];
    values.into_iter().map(|(key, value)| (key.to_string(), value)).chain(volume_values(found)).collect()
}

fn volume_values(found: &Reproduction) -> Vec<(String, f64)> {
    let mut values = Vec::new();
    let bases = found.volumes.iter().map(|volume| {
        let found = count_volume(volume);
        let largest_n = found.largest_palm_force.map_or(f64::NAN, |best| best.static_pfp_n);
        (format!("base_{}_mm", rounded_mm(volume.base_m)), volume.mu_static, found.counts, Some(largest_n))
    });
    let all = intersections(&found.volumes);
    let all = all.iter().map(|found| ("all".to_string(), found.mu_static, found.counts, None));
    for (base, mu, counts, largest_n) in bases.chain(all) {
        values.push((format!("volume.stable_percent.{base}.mu_{mu}"), counts.percent(counts.stable)));
        values.push((format!("volume.palm_percent.{base}.mu_{mu}"), counts.percent(counts.palm_positive)));
        values.extend(largest_n.map(|largest_n| (format!("volume.pfp_max_n.{base}.mu_{mu}"), largest_n)));
        // Table 3.5 counts form-closed points of the stable region without friction.
        if mu == 0.0 {
            values.push((format!("volume.closed_percent.{base}"), counts.percent(counts.form_closed)));
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_unique_and_every_difference_has_a_reason() {
        let figures = figures();
        assert!(figures.len() > 80);
        for (index, figure) in figures.iter().enumerate() {
            let Figure { key, printed, expected, tolerance, reason, .. } = figure;
            assert!(figures[..index].iter().all(|other| other.key != *key), "{key} is not unique");
            let (.., suffix) = UNITS.iter().find(|(unit, ..)| *unit == figure.unit).expect("a unit");
            let quantity =
                [".base_", ".all", ".mu_"].iter().fold(key.as_str(), |key, end| key.split(end).next().unwrap_or(key));
            assert!(quantity.ends_with(suffix), "{key} does not end in the unit {}", figure.unit);
            assert!(!expected.is_empty() || tolerance.is_none(), "{key} has a tolerance without an expected value");
            assert!(reason.is_empty() || reasons().contains_key(reason), "{key}: {reason}");
            // The printed and the expected value may differ only for a reason.
            if let (Some(thesis), Some(expected)) = (figure.si(printed), figure.si(expected)) {
                let rounding = 0.5 * 10f64.powi(-(decimals(printed) as i32)) * (1.0 + 1e-9);
                let agree = (thesis - expected).abs() * figure.scale() <= rounding.max(tolerance.unwrap_or(0.0));
                assert!(agree || !reason.is_empty(), "{key} has no reason");
            }
        }
        let used = |key: &String| figures.iter().any(|figure| figure.reason == *key);
        assert!(reasons().keys().all(used), "an unused reason");
    }
}
