//! The figures of a run by the keys of its JSON document.

use serde_json::{Value, json};

use super::labels::{format_value, label, unit};
use crate::report::document::RunReport;

/// Value of a leaf of the document.
#[derive(Clone, Debug, PartialEq)]
pub enum Leaf {
    Number(f64),
    Text(String),
    None,
}

/// Beginning and end of the keys listed first; the others follow in the order of the document.
const LEADING_KEYS: [(&str, &str); 15] = [
    ("criteria.", "class"),
    ("grasp.", "fate"),
    ("criteria.", "tts_s"),
    ("grasp.", "tts_s"),
    ("criteria.", "rebound_percent"),
    ("contacts.", "restitution"),
    ("contacts.distal", "peak_normal_n"),
    ("contacts.proximal", "peak_normal_n"),
    ("grasp.", "form_closed"),
    ("grasp.slip", "displacement_m"),
    ("contacts.right_distal", "peak_normal_n"),
    ("contacts.right_proximal", "peak_normal_n"),
    ("contacts.", "final_normal_n"),
    ("contacts.", "first_s"),
    ("contacts.", "peak_normal_n"),
];
/// Parts of the document that are not results, or that have their own request.
const EXCLUDED_KEYS: [&str; 13] = [
    "scene",
    "kind",
    "model",
    "wall_s",
    "integrator",
    "engine",
    "log",
    "page",
    "check",
    "error",
    "work",
    "warnings",
    "no_criteria",
];
/// Suffix of keys with sentences, which are not figures. The page shows the sentence on the class or the fate
/// separately: [`verdict`].
const REASON_SUFFIX: &str = "_reason";

/// All figures with labels and texts, the most important first.
pub fn figures(report: &RunReport) -> Vec<Value> {
    let mut all = leaves(report);
    let rank = |key: &str| {
        let found = LEADING_KEYS.iter().position(|(begin, end)| key.starts_with(begin) && key.ends_with(end));
        found.unwrap_or(LEADING_KEYS.len())
    };
    all.sort_by_key(|(key, _)| rank(key));
    let entry = |(key, value): &(String, Leaf)| {
        let (number, formatted) = match value {
            Leaf::Number(number) => (Some(*number), format_value(key, *number)),
            Leaf::Text(word) => (None, word.clone()),
            Leaf::None => (None, "–".to_string()),
        };
        json!({ "key": key, "label": label(key), "value": number, "text": formatted, "unit": unit(key) })
    };
    all.iter().map(entry).collect()
}

/// Returns the class of a finger with its reason, or the reason why it has none; for a gripper, the reason for the fate
/// of its object.
pub fn verdict(report: &RunReport) -> Option<String> {
    let class = report.criteria.flatten().map(|criteria| criteria.verdict());
    let fate = || report.grasp.iter().flatten().find_map(|grasp| grasp.fate_reason.clone());
    class.or_else(|| report.no_criteria.clone().flatten().map(|reason| format!("no class: {reason}"))).or_else(fate)
}

/// Returns the results in the report's JSON document, with their keys.
pub fn leaves(report: &RunReport) -> Vec<(String, Leaf)> {
    let document = serde_json::to_value(report).expect("a report is plain data with string keys");
    let mut found = Vec::new();
    let parts = document.as_object().into_iter().flatten();
    for (key, part) in parts.filter(|(key, _)| !EXCLUDED_KEYS.contains(&key.as_str())) {
        collect_leaves(key, part, &mut found);
    }
    found
}

fn collect_leaves(key: &str, value: &Value, found: &mut Vec<(String, Leaf)>) {
    let leaf = match value {
        Value::Object(parts) => {
            parts.iter().for_each(|(name, part)| collect_leaves(&format!("{key}.{name}"), part, found));
            return;
        }
        Value::Array(parts) => {
            parts.iter().enumerate().for_each(|(index, part)| collect_leaves(&format!("{key}.{index}"), part, found));
            return;
        }
        _ if key.ends_with(REASON_SUFFIX) => return,
        Value::Number(number) => number.as_f64().map_or(Leaf::None, Leaf::Number),
        Value::String(word) => Leaf::Text(word.clone()),
        Value::Bool(flag) => Leaf::Text(if *flag { "yes" } else { "no" }.to_string()),
        Value::Null => Leaf::None,
    };
    found.push((key.to_string(), leaf));
}
