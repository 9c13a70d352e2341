//! Report of the comparison of two logs: JSON and text.

use serde::Serialize;
use serde_json::Value;

use super::{ReplayReport, or_unknown};
use crate::format::format_duration;
use crate::format::numbers::{format_number, or_dash, row};
use crate::format::report::{Report, ToReport, table, table_of};
use crate::scene::one_line;

/// Comparison of two logs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LogComparisonReport {
    /// Kind of scene: `finger` or `bodies`.
    pub kind: &'static str,
    /// Labels of the two logs.
    pub labels: [String; 2],
    pub logs: [ReplayReport; 2],
    /// End of the interval of time that both logs cover, s.
    pub compared_to_s: f64,
    /// Remarks on the comparison.
    pub notes: Vec<String>,
    /// Numbers of both summaries, identified by their path. A number is null if its log does not contain it.
    #[serde(rename = "figures")]
    pub numbers: Vec<NumberComparison>,
    /// Text values of both summaries, such as the class.
    #[serde(rename = "words")]
    pub texts: Vec<TextComparison>,
    /// Differences of joint angles, or of the centres of discs, over the interval of time that both logs cover.
    #[serde(rename = "apart")]
    pub trajectory_differences: Vec<TrajectoryDifference>,
    /// Directory of the pictures, as given by the user; null if none was requested.
    pub directory: Option<String>,
    /// Files in `directory`; null if none were requested.
    pub files: Option<Vec<String>>,
    /// Path of the page, as given by the user; null unless the page was requested separately.
    pub page: Option<String>,
}

/// Values of one number in both summaries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct NumberComparison {
    /// Path of the number, such as `contacts.proximal.first_s`; it ends in the unit.
    #[serde(rename = "figure")]
    pub path: String,
    pub values: [Option<f64>; 2],
    /// Second value minus first value.
    pub difference: Option<f64>,
    /// Absolute difference relative to the larger of the two values.
    pub relative: Option<f64>,
}

/// Values of one text in both summaries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct TextComparison {
    #[serde(rename = "figure")]
    pub path: String,
    pub values: [Option<String>; 2],
}

/// Difference of one quantity over the common time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct TrajectoryDifference {
    /// Name of the quantity with its unit, such as `q11_rad` or `hammer_centre_m`.
    pub quantity: String,
    pub max: f64,
    pub max_at_s: f64,
    pub rms: f64,
    /// Difference at the end of the interval of time that both logs cover.
    pub end: f64,
}

/// Parts of a summary that are compared, in order.
const SECTIONS: [&str; 6] = ["end_s", "final", "bodies", "contacts", "criteria", "energy"];

/// Order of keys within a section, separated by spaces; others follow.
const KEY_ORDER: &str = "\
    q11_rad q21_rad q22_rad q12_rad q13_rad qd11_rad_s qd21_rad_s x_m y_m angle_rad vx_m_s vy_m_s spin_rad_s \
    proximal distal limit first_s touchdowns final_normal_n final_tangential_n final_torque_n_m peak_normal_n \
    peak_torque_n_m max_penetration_m max_penetration_rad impulse_n_s impulse_n_m_s approach_m_s separation_m_s \
    restitution tts_s rebound_percent kinetic_j gravity_j spring_j elastic_j dissipated_j motor_work_j balance_j";

/// Returns the numbers and text values of two summaries side by side.
pub(crate) fn compare_summaries(logs: &[ReplayReport; 2]) -> (Vec<NumberComparison>, Vec<TextComparison>) {
    let [first, second] = logs.each_ref().map(|log| serde_json::to_value(log).unwrap_or(Value::Null));
    let (mut leaves, mut numbers, mut texts) = (Vec::new(), Vec::new(), Vec::new());
    for section in SECTIONS {
        collect_leaves(section.to_string(), [&first[section], &second[section]], &mut leaves);
    }
    for (path, values) in leaves {
        if values.iter().any(|value| value.is_string()) {
            texts.push(TextComparison { path, values: values.map(|value| value.as_str().map(str::to_string)) });
        } else if values.iter().any(|value| value.is_number()) {
            numbers.push(NumberComparison::new(path, values.map(Value::as_f64)));
        }
    }
    (numbers, texts)
}

/// Collects the values in two objects, or the values themselves if neither is an object.
fn collect_leaves<'a>(path: String, values: [&'a Value; 2], leaves: &mut Vec<(String, [&'a Value; 2])>) {
    let maps = values.map(Value::as_object);
    if maps == [None, None] {
        return leaves.push((path, values));
    }
    let mut keys: Vec<&String> = maps.into_iter().flatten().flat_map(|map| map.keys()).collect();
    let rank = |key: &str| KEY_ORDER.split(' ').position(|known| known == key).unwrap_or(usize::MAX);
    keys.sort_by(|a, b| rank(a).cmp(&rank(b)).then(a.cmp(b)));
    keys.dedup();
    for key in keys {
        collect_leaves(format!("{path}.{key}"), values.map(|value| &value[key]), leaves);
    }
}

impl NumberComparison {
    fn new(path: String, values: [Option<f64>; 2]) -> Self {
        let difference = values[0].zip(values[1]).map(|(a, b)| b - a);
        let scale = values.iter().flatten().fold(0.0, |scale, value: &f64| value.abs().max(scale));
        let relative = difference.filter(|_| scale > 0.0).map(|difference| difference.abs() / scale);
        NumberComparison { path, values, difference, relative }
    }
}

impl ToReport for LogComparisonReport {
    fn report(&self) -> Report {
        let differences = &self.trajectory_differences;
        let trajectories = (!differences.is_empty()).then(|| trajectory_table(differences));
        Report::join([heading(self).into(), value_table(self), trajectories.into()])
    }
}

fn heading(report: &LogComparisonReport) -> String {
    let logs = report.labels.iter().zip(&report.logs).map(|(label, log)| {
        let [scene, model] = [&log.scene, &log.model].map(or_unknown);
        format!("{label}: {scene}, {model} model, {} samples, read from {}", log.reading.samples, one_line(&log.log))
    });
    let mut lines: Vec<String> = logs.collect();
    lines.push(format!("compared up to {}", format_duration(report.compared_to_s)));
    lines.extend_from_slice(&report.notes);
    let files = report.directory.as_ref().zip(report.files.as_ref());
    lines.extend(files.map(|(directory, files)| format!("in {directory}: {}", files.join(", "))));
    lines.extend(report.page.iter().map(|page| format!("page: {}", one_line(page))));
    lines.join("\n") + "\n"
}

fn value_table(report: &LogComparisonReport) -> Report {
    let [first, second] = &report.labels;
    let mut rows = vec![row(["", first, second, "difference", "relative"])];
    // Values that are zero in both logs appear in the JSON document only.
    for found in report.numbers.iter().filter(|found| found.values != [Some(0.0); 2]) {
        let (name, unit, scale) = format_quantity(&found.path);
        // A number without a unit is a count.
        let number = |value: Option<f64>, digits| {
            or_dash(value, |value| match unit {
                "" => format!("{value:.0}"),
                _ => format_number(value * scale, digits),
            })
        };
        let label = if ["", RATIO].contains(&unit) { name } else { format!("{name}, {unit}") };
        let ([a, b], difference) = (found.values.map(|value| number(value, 7)), number(found.difference, 3));
        rows.push(row([&label, &a, &b, &difference, &or_dash(found.relative, |value| format_number(value, 3))]));
    }
    for found in &report.texts {
        let (name, ..) = format_quantity(&found.path);
        let [a, b] = found.values.each_ref().map(|text| text.as_deref().unwrap_or("–"));
        rows.push(row([&name, a, b, if a == b { "0" } else { "differs" }]));
    }
    table(&rows)
}

/// Placeholder for the unit of a ratio.
const RATIO: &str = "1";

/// Returns the displayed name and unit of a value, and the factor from SI to that unit.
fn format_quantity(path: &str) -> (String, &'static str, f64) {
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
        let components: Vec<&str> =
            path.split('.').filter(|component| !["contacts", "bodies", "final"].contains(component)).collect();
        components.join(" ").replace('_', " ")
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

fn trajectory_table(differences: &[TrajectoryDifference]) -> Report {
    table_of(
        differences,
        &[
            ("difference over the run", &|found| found.quantity.clone()),
            ("largest", &|found| format_number(found.max, 3)),
            ("at, ms", &|found| format_number(found.max_at_s * 1e3, 6)),
            ("RMS", &|found| format_number(found.rms, 3)),
            ("at the end", &|found| format_number(found.end, 3)),
        ],
    )
}
