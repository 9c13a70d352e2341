//! Figures of many runs, two fields varied: for a map.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::figures::{Flat, flat};
use super::given::scene_with;
use super::request::Request;
use super::run::simulated;

/// A column for every figure that is a number, row by row, NaN where a run has none; words by themselves. A point that is no scene has
/// neither.
pub fn criteria(request: &Request, numbers: &mut Vec<f64>) -> Result<Value, Value> {
    let mut rows: Vec<Vec<(String, Flat)>> = Vec::new();
    let mut refused: Vec<Value> = Vec::new();
    for point in &request.points {
        let set: Vec<(String, String)> = request.fields.iter().cloned().zip(point.iter().cloned()).collect();
        let (row, problem) = match scene_with(request, &set) {
            Ok(scene) => (flat(&simulated(&scene, &mut ())), Value::Null),
            Err(problems) => (Vec::new(), problems[0]["message"].clone()),
        };
        rows.push(row);
        refused.push(problem);
    }
    let mut columns: Vec<&str> = Vec::new();
    let mut words: BTreeMap<&str, Vec<Option<&str>>> = BTreeMap::new();
    for (key, value) in rows.iter().flatten() {
        match value {
            Flat::Number(_) if !columns.contains(&key.as_str()) => columns.push(key),
            Flat::Word(_) => {
                words.entry(key).or_default();
            }
            Flat::Number(_) | Flat::None => {}
        }
    }
    for row in &rows {
        let of = |wanted: &str| row.iter().find(|(key, _)| key == wanted).map(|(_, value)| value);
        numbers.extend(columns.iter().map(|column| match of(column) {
            Some(Flat::Number(number)) => *number,
            _ => f64::NAN,
        }));
        for (key, list) in &mut words {
            list.push(match of(key) {
                Some(Flat::Word(word)) => Some(word.as_str()),
                _ => None,
            });
        }
    }
    Ok(json!({ "columns": columns, "words": words, "refused": refused }))
}
