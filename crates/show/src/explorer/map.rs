//! Figures of many runs that vary two fields, for a map.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::figures::{Leaf, leaves};
use super::request::Request;
use super::requested_scene::scene_with_settings;
use super::run::simulate;

/// Runs every point of the map. Appends the numerical figures to `numbers` row by row, NaN if a run lacks a figure;
/// figures in words are returned under `keyword_lists`. A point with an invalid scene has neither.
pub fn criteria(request: &Request, numbers: &mut Vec<f64>) -> Result<Value, Value> {
    let mut rows: Vec<Vec<(String, Leaf)>> = Vec::new();
    let mut refused: Vec<Value> = Vec::new();
    for point in &request.points {
        let set: Vec<(String, String)> = request.fields.iter().cloned().zip(point.iter().cloned()).collect();
        let (row, problem) = match scene_with_settings(request, &set) {
            Ok(scene) => (leaves(&simulate(&scene, &mut ())), Value::Null),
            Err(problems) => (Vec::new(), problems[0]["message"].clone()),
        };
        rows.push(row);
        refused.push(problem);
    }
    let mut columns: Vec<&str> = Vec::new();
    let mut keyword_lists: BTreeMap<&str, Vec<Option<&str>>> = BTreeMap::new();
    for (key, value) in rows.iter().flatten() {
        match value {
            Leaf::Number(_) if !columns.contains(&key.as_str()) => columns.push(key),
            Leaf::Text(_) => {
                keyword_lists.entry(key).or_default();
            }
            Leaf::Number(_) | Leaf::None => {}
        }
    }
    for row in &rows {
        let candidate = |requested: &str| row.iter().find(|(key, _)| key == requested).map(|(_, value)| value);
        numbers.extend(columns.iter().map(|column| match candidate(column) {
            Some(Leaf::Number(number)) => *number,
            _ => f64::NAN,
        }));
        for (key, list) in &mut keyword_lists {
            list.push(match candidate(key) {
                Some(Leaf::Text(word)) => Some(word.as_str()),
                _ => None,
            });
        }
    }
    Ok(json!({ "columns": columns, "words": keyword_lists, "refused": refused }))
}
