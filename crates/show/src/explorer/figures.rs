//! The figures of a run, by the keys of its JSON document.

use serde_json::{Value, json};

use super::labels::{label, text, unit};
use crate::report::document::RunReport;

/// A leaf of the document.
#[derive(Clone, Debug, PartialEq)]
pub enum Flat {
    Number(f64),
    Word(String),
    None,
}

/// What is first looked at, by what keys begin and end with; the others follow by their keys.
const FIRST: [(&str, &str); 15] = [
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
/// Parts of the document that are no results, or are asked for by themselves.
const NO_FIGURES: [&str; 13] = [
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
/// Sentences, which are no figures; the page has that of the class or the fate in a line of its own: [`verdict`].
const REASON: &str = "_reason";

/// All figures with labels and texts, the most wanted first.
pub fn figures(report: &RunReport) -> Vec<Value> {
    let mut all = flat(report);
    let rank = |key: &str| {
        let found = FIRST.iter().position(|(begin, end)| key.starts_with(begin) && key.ends_with(end));
        found.unwrap_or(FIRST.len())
    };
    all.sort_by_key(|(key, _)| rank(key));
    let one = |(key, value): &(String, Flat)| {
        let (number, said) = match value {
            Flat::Number(number) => (Some(*number), text(key, *number)),
            Flat::Word(word) => (None, word.clone()),
            Flat::None => (None, "–".to_string()),
        };
        json!({ "key": key, "label": label(key), "value": number, "text": said, "unit": unit(key) })
    };
    all.iter().map(one).collect()
}

/// The class of a finger with what decides it, or why it has none; of a gripper what decides the fate of its object.
pub fn verdict(report: &RunReport) -> Option<String> {
    let class = report.criteria.flatten().map(|criteria| criteria.verdict());
    let fate = || report.grasp.iter().flatten().find_map(|grasp| grasp.fate_reason.clone());
    class.or_else(|| report.no_criteria.clone().flatten().map(|reason| format!("no class: {reason}"))).or_else(fate)
}

/// The leaves of the document that are figures or words.
pub fn flat(report: &RunReport) -> Vec<(String, Flat)> {
    let document = serde_json::to_value(report).expect("a report is plain data with string keys");
    let mut found = Vec::new();
    let parts = document.as_object().into_iter().flatten();
    for (key, part) in parts.filter(|(key, _)| !NO_FIGURES.contains(&key.as_str())) {
        leaves(key, part, &mut found);
    }
    found
}

fn leaves(key: &str, value: &Value, found: &mut Vec<(String, Flat)>) {
    let leaf = match value {
        Value::Object(parts) => {
            parts.iter().for_each(|(name, part)| leaves(&format!("{key}.{name}"), part, found));
            return;
        }
        Value::Array(parts) => {
            parts.iter().enumerate().for_each(|(index, part)| leaves(&format!("{key}.{index}"), part, found));
            return;
        }
        _ if key.ends_with(REASON) => return,
        Value::Number(number) => number.as_f64().map_or(Flat::None, Flat::Number),
        Value::String(word) => Flat::Word(word.clone()),
        Value::Bool(flag) => Flat::Word(if *flag { "yes" } else { "no" }.to_string()),
        Value::Null => Flat::None,
    };
    found.push((key.to_string(), leaf));
}
