//! The figures of a run by the keys of its JSON document, with labels, and texts in common units.

use serde_json::{Value, json};

use crate::format::format_duration;
use crate::format::numbers::{format_number, zero_below_resolution};
use crate::report::document::RunReport;
use crate::report::object::ObjectReport;
use crate::units::Dimension;

/// Beginnings and ends of the keys listed first; the others follow in the order of the document.
const LEADING_KEYS: &str = "criteria.*class grasp.*fate criteria.*tts_s grasp.*tts_s criteria.*rebound_percent contacts.*restitution \
     contacts.distal*peak_normal_n contacts.proximal*peak_normal_n grasp.*form_closed grasp.slip*displacement_m \
     contacts.right_distal*peak_normal_n contacts.right_proximal*peak_normal_n contacts.*final_normal_n \
     contacts.*first_s contacts.*peak_normal_n";
/// The same of a mechanism: how firmly it holds its object, and with which forces.
const LEADING_KEYS_OF_MECHANISM: &str = "grasp.*fate grasp.margin.driven*acceleration_m_s2 grasp.*tts_s grasp.pairs.*normal_n \
     grasp.*friction_used grasp.slip*displacement_m contacts.*peak_normal_n contacts.*first_s";
/// Parts of the document that are not results, or that have their own request.
const EXCLUDED_KEYS: &str =
    "scene kind model wall_s integrator engine log page check error work warnings no_criteria no_grasp";
/// Parts of the grasp that are names, sentences or lists.
const EXCLUDED_PARTS: &str = "grasp.answer grasp.object grasp.base grasp.assumed_hand grasp.states grasp.never_touched";
/// Suffix of keys with sentences, which are not figures. The page shows the sentence on the class or the fate
/// separately: [`verdict`].
const REASON_SUFFIX: &str = "_reason";

/// Suffixes of keys and their units; a suffix that ends with another one comes before it.
const UNITS: [(&str, &str); 13] = [
    ("_n_m_s", "N·m·s"),
    ("_rad_s", "rad/s"),
    ("_m_s", "m/s"),
    ("_n_m", "N·m"),
    ("_n_s", "N·s"),
    ("_m_s2", "m/s²"),
    ("_percent", "%"),
    ("_rad", "rad"),
    ("_hz", "Hz"),
    ("_s", "s"),
    ("_n", "N"),
    ("_m", "m"),
    ("_j", "J"),
];
/// Labels of some figures.
const NAMES: [(&str, &str); 20] = [
    ("margin.driven.acceleration", "margin"),
    ("margin.blocked.acceleration", "margin with blocked actuators"),
    ("normal", "end force"),
    ("tts", "time to stability"),
    ("t_geo", "in position"),
    ("lost", "lost to rebounds"),
    ("first", "first contact"),
    ("touchdowns", "touch-downs"),
    ("final_normal", "end force"),
    ("final_tangential", "end friction"),
    ("final_torque", "end torque"),
    ("peak_normal", "peak force"),
    ("peak_torque", "peak torque"),
    ("max_penetration", "deepest"),
    ("statically_stable", "statically stable"),
    ("end", "end of the run"),
    ("motor_work", "motor work"),
    ("grasped", "grasped"),
    ("force_closure", "force closure"),
    ("form_closed", "form-closed"),
];
/// SI prefixes, largest first.
const PREFIXES: [(f64, &str); 5] = [(1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")];
/// Units with SI prefixes.
const PREFIXED: [&str; 6] = ["N", "m", "J", "N·m", "N·s", "N·m·s"];
/// Significant digits of a figure.
const DIGITS: usize = 4;

/// Returns all figures with labels and texts, the most important ones first. `has_fingers` states whether the scene has
/// five-bar fingers.
pub fn figures(report: &RunReport, has_fingers: bool) -> Vec<Value> {
    let mut all = leaves(report);
    let leading_keys = if has_fingers { LEADING_KEYS } else { LEADING_KEYS_OF_MECHANISM };
    let object = report.object().map(|object| object.criteria.object.as_str());
    let leads = |key: &str, pattern: &str| {
        pattern.split_once('*').is_some_and(|(begin, end)| key.starts_with(begin) && key.ends_with(end))
    };
    let rank = |key: &str| leading_keys.split(' ').position(|pattern| leads(key, pattern)).unwrap_or(usize::MAX);
    // Bodies of the hand come before the ground, which few hands press against.
    all.sort_by_cached_key(|(key, _)| (rank(key), rank(key) < usize::MAX && key.contains("ground.")));
    let entry = |(key, value): &(String, Value)| {
        let text = match value.as_f64() {
            Some(number) => format_value(key, number),
            None => value.as_str().unwrap_or("–").to_string(),
        };
        json!({ "key": key, "label": label(key, object), "value": value.as_f64(), "text": text, "unit": unit(key).1 })
    };
    all.iter().map(entry).collect()
}

/// Returns the class of a finger with its reason, or the reason why it has no class. For a grasp, returns its answer.
pub fn verdict(report: &RunReport) -> Option<String> {
    let class = report.criteria.flatten().map(|criteria| criteria.verdict());
    let fate = || report.object().map(ObjectReport::answer);
    let no_class = || report.no_criteria.clone().flatten().map(|reason| format!("no class: {reason}"));
    let no_fate = || report.no_grasp.clone();
    class.or_else(no_class).or_else(fate).or_else(no_fate)
}

/// Returns the results in the report's JSON document, each with its key: numbers, words or null.
pub fn leaves(report: &RunReport) -> Vec<(String, Value)> {
    let document = serde_json::to_value(report).expect("a report is plain data with string keys");
    let mut found = Vec::new();
    let parts = document.as_object().into_iter().flatten();
    for (key, part) in parts.filter(|(key, _)| !EXCLUDED_KEYS.split(' ').any(|excluded| excluded == key.as_str())) {
        collect_leaves(key, part, &mut found);
    }
    found
}

fn collect_leaves(key: &str, value: &Value, found: &mut Vec<(String, Value)>) {
    match value {
        _ if EXCLUDED_PARTS.split(' ').any(|excluded| excluded == key) => {}
        Value::Object(parts) => {
            parts.iter().for_each(|(name, part)| collect_leaves(&format!("{key}.{name}"), part, found));
        }
        Value::Array(parts) => {
            parts.iter().enumerate().for_each(|(index, part)| collect_leaves(&format!("{key}.{index}"), part, found));
        }
        _ if key.ends_with(REASON_SUFFIX) => {}
        Value::Bool(flag) => found.push((key.to_string(), json!(if *flag { "yes" } else { "no" }))),
        leaf => found.push((key.to_string(), leaf.clone())),
    }
}

/// Returns the suffix of a key and the unit that it stands for; empty for a key without a unit.
fn unit(key: &str) -> (&'static str, &'static str) {
    UNITS.iter().find(|(ending, _)| key.ends_with(ending)).copied().unwrap_or_default()
}

/// Label of a key: `contacts.distal.peak_normal_n` becomes `distal: peak force`. The name of a pair is that of the body
/// that touches the object.
fn label(key: &str, object: Option<&str>) -> String {
    let stem = key.strip_suffix(unit(key).0).unwrap_or(key);
    let named = |part: &str| NAMES.iter().find(|(name, _)| *name == part).map(|(_, label)| label.to_string());
    if let Some(label) = stem.strip_prefix("grasp.").and_then(named) {
        return label;
    }
    let pair = object.and_then(|object| {
        let (start, end) = (stem.find('.')? + 1, stem.rfind('.')?);
        let (first, second) = stem.get(start..end)?.trim_start_matches("pairs.").split_once('/')?;
        let is_object = |name: &str| name.split('.').next() == Some(object);
        let other = if is_object(second) { first } else { second };
        (is_object(first) || is_object(second)).then(|| format!("pair.{other}{}", &stem[end..]))
    });
    let parts: Vec<String> = pair
        .as_deref()
        .unwrap_or(stem)
        .split('.')
        .filter(|part| !["contacts", "criteria", "grasp", "fingers", "pair", "pairs"].contains(part))
        .map(|part| named(part).unwrap_or_else(|| part.replace('_', " ")))
        .collect();
    match parts.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{}: {last}", before.join(" ")),
        _ => parts.concat(),
    }
}

/// Formats a value with its unit.
fn format_value(key: &str, value: f64) -> String {
    let unit = unit(key).1;
    let dimension = Dimension::ALL.into_iter().find(|candidate| candidate.units()[0].name.replace('*', "·") == unit);
    let value = dimension.map_or(value, |dimension| zero_below_resolution(value, dimension));
    match unit {
        "" if value.fract() == 0.0 && value.abs() < 1e6 => format!("{value:.0}"),
        "" => format_number(value, DIGITS),
        "s" if value >= 0.0 => format_duration(value),
        "rad" => format!("{}°", format_number(value.to_degrees(), DIGITS)),
        unit if PREFIXED.contains(&unit) => {
            let size = value.abs();
            let fits = PREFIXES.iter().find(|(factor, _)| size >= *factor);
            let (factor, prefix) = fits.copied().unwrap_or(if size == 0.0 { (1.0, "") } else { (1e-9, "n") });
            format!("{} {prefix}{unit}", format_number(value / factor, DIGITS))
        }
        unit => format!("{} {unit}", format_number(value, DIGITS)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keys_and_formats_values_with_units() {
        for (key, value, expected_label, expected_text) in [
            ("contacts.distal.peak_normal_n", 170_075.2, "distal: peak force", "170.1 kN"),
            ("contacts.object.rim/left_tip.pad.peak_normal_n", 8.0, "left tip pad: peak force", "8.000 N"),
            ("grasp.pairs.left_tip.pad/object.rim.normal_n", 4.5, "left tip pad: end force", "4.500 N"),
            ("grasp.pairs.lid/cup.normal_n", 4.5, "lid/cup: end force", "4.500 N"),
            ("grasp.margin.driven.acceleration_m_s2", 638.37, "margin", "638.4 m/s²"),
            ("criteria.tts_s", 0.006_883_746, "time to stability", "6.88375 ms"),
            ("contacts.limit.impulse_n_m_s", 0.000_244_1, "limit: impulse", "244.1 µN·m·s"),
            ("criteria.rebound_percent", 1.234_56, "rebound", "1.235 %"),
            ("final.q11_rad", 0.017_453_292_519_943_295, "final: q11", "1.000°"),
            ("energy.balance_j", 0.0, "energy: balance", "0 J"),
            ("contacts.palm.final_tangential_n", 8.2036e-11, "palm: end friction", "0 N"),
            ("contacts.distal.touchdowns", 2.0, "distal: touch-downs", "2"),
        ] {
            assert_eq!(
                (label(key, Some("object")).as_str(), format_value(key, value).as_str()),
                (expected_label, expected_text),
                "{key}"
            );
        }
    }
}
