//! Two logs side by side, in the keys of the JSON document and as text.

use std::fmt::Write;

use serde::Serialize;
use serde_json::Value;

use super::document::ReplayReport;
use crate::validate::turned;
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::report::{Report, Reported, table};

/// Two logs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgainstReport {
    /// `finger` or `bodies`.
    pub kind: &'static str,
    /// What each is called here.
    pub labels: [String; 2],
    pub logs: [ReplayReport; 2],
    /// Time up to which both go.
    pub compared_to_s: f64,
    /// What to bear in mind.
    pub notes: Vec<String>,
    /// Figures of both summaries, by their place in these; null where a log has no such figure.
    pub figures: Vec<FigureReport>,
    /// Words of both summaries that can differ, such as the class.
    pub words: Vec<WordReport>,
    /// Largest differences along the common time: of joint angles, or of the centres of discs.
    pub apart: Vec<ApartReport>,
    /// Directory of the pictures as given, and the files in it; null if none were asked for.
    pub directory: Option<String>,
    pub files: Option<Vec<String>>,
    /// Path of the page as given; null if none was asked for by itself.
    pub page: Option<String>,
}

/// One figure of both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FigureReport {
    /// As in `contacts.proximal.first_s`: its unit is that of its name.
    pub figure: String,
    pub values: [Option<f64>; 2],
    /// Second less first; of angles without whole turns.
    pub difference: Option<f64>,
    /// Its size relative to the larger of the two.
    pub relative: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WordReport {
    pub figure: String,
    pub values: [Option<String>; 2],
}

/// Differences of one quantity along the way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ApartReport {
    /// With its unit, as in `q11_rad` or `hammer_centre_m`.
    pub quantity: String,
    pub max: f64,
    pub max_at_s: f64,
    pub rms: f64,
    /// At the end of the common time.
    pub end: f64,
}

/// The sections of a summary that have figures, in order.
const SECTIONS: [&str; 5] = ["final", "discs", "contacts", "criteria", "energy"];

/// Figures within a part of a section come in this order, others behind.
const ORDER: [&str; 39] = [
    "q11_rad",
    "q21_rad",
    "q22_rad",
    "q12_rad",
    "q13_rad",
    "qd11_rad_s",
    "qd21_rad_s",
    "x_m",
    "y_m",
    "angle_rad",
    "vx_m_s",
    "vy_m_s",
    "spin_rad_s",
    "proximal",
    "distal",
    "limit",
    "first_s",
    "touchdowns",
    "final_normal_n",
    "final_tangential_n",
    "final_torque_n_m",
    "peak_normal_n",
    "peak_torque_n_m",
    "max_penetration_m",
    "max_penetration_rad",
    "impulse_n_s",
    "impulse_n_m_s",
    "approach_m_s",
    "separation_m_s",
    "restitution",
    "tts_s",
    "rebound_percent",
    "kinetic_j",
    "gravity_j",
    "spring_j",
    "elastic_j",
    "dissipated_j",
    "motor_work_j",
    "balance_j",
];

/// The figures and words of two summaries, side by side.
pub fn side_by_side(logs: &[ReplayReport; 2]) -> (Vec<FigureReport>, Vec<WordReport>) {
    let documents = logs.each_ref().map(|log| serde_json::to_value(log).unwrap_or(Value::Null));
    let [first, second] = &documents;
    let (mut figures, mut words) = (Vec::new(), Vec::new());
    leaf("end_s", [&first["end_s"], &second["end_s"]], &mut figures, &mut words);
    for section in SECTIONS {
        walk(section, [&first[section], &second[section]], &mut figures, &mut words);
    }
    (figures, words)
}

fn walk(path: &str, values: [&Value; 2], figures: &mut Vec<FigureReport>, words: &mut Vec<WordReport>) {
    let maps = values.map(Value::as_object);
    if maps == [None, None] {
        return leaf(path, values, figures, words);
    }
    let mut keys: Vec<&String> = maps.iter().flatten().flat_map(|map| map.keys()).collect();
    let place = |key: &str| ORDER.iter().position(|known| *known == key).unwrap_or(ORDER.len());
    keys.sort_by(|a, b| place(a).cmp(&place(b)).then(a.cmp(b)));
    keys.dedup();
    for key in keys {
        let of = |map: Option<&'_ serde_json::Map<String, Value>>| map.and_then(|map| map.get(key)).cloned();
        let [first, second] = maps.map(|map| of(map).unwrap_or(Value::Null));
        walk(&format!("{path}.{key}"), [&first, &second], figures, words);
    }
}

fn leaf(path: &str, values: [&Value; 2], figures: &mut Vec<FigureReport>, words: &mut Vec<WordReport>) {
    if values.iter().any(|value| value.is_string()) {
        let values = values.map(|value| value.as_str().map(str::to_string));
        return words.push(WordReport { figure: path.to_string(), values });
    }
    let values = values.map(Value::as_f64);
    if values == [None, None] {
        return;
    }
    let difference = match values {
        [Some(a), Some(b)] if path.starts_with("final.") && path.ends_with("_rad") => Some(turned(b - a)),
        [Some(a), Some(b)] => Some(b - a),
        _ => None,
    };
    let scale = values.iter().flatten().fold(0.0, |scale, value: &f64| value.abs().max(scale));
    let relative = difference.filter(|_| scale > 0.0).map(|difference| difference.abs() / scale);
    figures.push(FigureReport { figure: path.to_string(), values, difference, relative });
}

/// The report for people, with a line end.
impl Reported for AgainstReport {
    fn report(&self) -> Report {
        let mut sections = vec![Report::from(heading(self)), figures(self)];
        if !self.apart.is_empty() {
            sections.push(apart(&self.apart));
        }
        Report::join(sections)
    }
}

fn heading(report: &AgainstReport) -> String {
    let mut text = String::new();
    for (label, log) in report.labels.iter().zip(&report.logs) {
        let known = |entry: &Option<String>| entry.clone().unwrap_or_else(|| "unknown".to_string());
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{label}: {}, {} model, {} samples, read from {}",
            known(&log.scene),
            known(&log.model),
            log.samples,
            log.log
        );
    }
    let _ = writeln!(text, "compared up to {}", duration(report.compared_to_s));
    for note in &report.notes {
        let _ = writeln!(text, "{note}");
    }
    if let (Some(directory), Some(files)) = (&report.directory, &report.files) {
        let _ = writeln!(text, "in {directory}: {}", files.join(", "));
    }
    if let Some(page) = &report.page {
        let _ = writeln!(text, "page: {page}");
    }
    text
}

fn figures(report: &AgainstReport) -> Report {
    let [first, second] = &report.labels;
    let mut rows = vec![row(["", first, second, "difference", "relative"])];
    // What is nothing in both is left to the document.
    for found in report.figures.iter().filter(|found| found.values != [Some(0.0); 2]) {
        let (name, unit, scale) = shown(&found.figure);
        let number = |value: Option<f64>, digits| value.map_or("–".to_string(), |value| figure(value, digits));
        let count = |value: Option<f64>| value.map_or("–".to_string(), |value| format!("{value:.0}"));
        let scaled = |value: Option<f64>| match unit {
            "" => count(value),
            _ => number(value.map(|value| value * scale), 7),
        };
        let label = if ["", RATIO].contains(&unit) { name } else { format!("{name}, {unit}") };
        let difference = match unit {
            "" => count(found.difference),
            _ => number(found.difference.map(|difference| difference * scale), 3),
        };
        let [a, b] = found.values.map(scaled);
        rows.push(row([&label, &a, &b, &difference, &number(found.relative, 3)]));
    }
    for found in &report.words {
        let (name, ..) = shown(&found.figure);
        let [a, b] = found.values.each_ref().map(|word| word.as_deref().unwrap_or("–"));
        rows.push(row([&name, a, b, if a == b { "0" } else { "differs" }]));
    }
    table(&rows)
}

/// In place of the unit of a ratio.
const RATIO: &str = "1";

/// A figure for people: its name, its unit, and what to multiply it with.
fn shown(path: &str) -> (String, &'static str, f64) {
    const UNITS: [(&str, &str, f64); 13] = [
        ("_n_m_s", "mN·m·s", 1e3),
        ("_rad_s", "rad/s", 1.0),
        ("_n_m", "N·m", 1.0),
        ("_n_s", "mN·s", 1e3),
        ("_m_s", "m/s", 1.0),
        ("_percent", "%", 1.0),
        ("penetration_rad", "µrad", 1e6),
        ("penetration_m", "µm", 1e6),
        ("_rad", "deg", 180.0 / std::f64::consts::PI),
        ("_n", "N", 1.0),
        ("_m", "mm", 1e3),
        ("_s", "ms", 1e3),
        ("_j", "mJ", 1e3),
    ];
    let name = |path: &str| {
        let parts: Vec<&str> = path.split('.').filter(|part| !["contacts", "discs", "final"].contains(part)).collect();
        parts.join(" ").replace('_', " ")
    };
    match UNITS.iter().find(|(suffix, ..)| path.ends_with(suffix)) {
        Some((suffix @ ("penetration_rad" | "penetration_m"), unit, scale)) => {
            (format!("{}depth", name(path.trim_end_matches(suffix).trim_end_matches("max_"))), unit, *scale)
        }
        Some((suffix, unit, scale)) => (name(path.trim_end_matches(suffix)), unit, *scale),
        None if path.ends_with(".restitution") => (name(path), RATIO, 1.0),
        None => (name(path), "", 1.0),
    }
}

fn apart(all: &[ApartReport]) -> Report {
    let mut rows = vec![row(["difference along the way", "largest", "at, ms", "RMS", "at the end"])];
    for found in all {
        rows.push(row([
            &found.quantity,
            &figure(found.max, 3),
            &figure(found.max_at_s * 1e3, 6),
            &figure(found.rms, 3),
            &figure(found.end, 3),
        ]));
    }
    table(&rows)
}
