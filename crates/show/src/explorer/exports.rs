//! Exports of the scene as a file, and of the samples as comma-separated values.

use serde_json::{Value, json};

use super::request::Request;
use crate::report::samples::{csv_head, csv_sample};
use crate::scene::Scene;
use crate::trace::columns::{Column, columns};
use crate::trace::{Decimated, Event, Layout, RunError, Sample, Sink, SinkError, run_analytic};

/// Returns the text of the scene file with the settings applied.
pub fn scene_file(request: &Request, scene: &Scene) -> Value {
    let set: Vec<String> = request.set.iter().map(|(field, value)| format!("{field} = {value}")).collect();
    let changes = if set.is_empty() { String::new() } else { format!(" with {}", set.join(", ")) };
    // The comment must stay on one line.
    let changes: String = changes.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let text = &scene.source;
    let text = text.strip_prefix('\n').unwrap_or(text);
    json!({ "text": format!("# {}{changes}, from the explorer of phalanx.\n{text}", request.scene.file) })
}

/// Returns the samples in the format of `phalanx replay --csv`.
pub fn samples(scene: &Scene) -> Result<Value, Value> {
    let mut lines = CsvSink { columns: columns(&Layout::from_system(&scene.system)), text: Vec::new() };
    csv_head(&mut lines.text, &lines.columns).expect("writing to memory cannot fail");
    let mut decimated = Decimated::new(scene.log.numeric_hz, lines);
    // A run that fails early has the samples up to its failure.
    let result = run_analytic(scene, &mut decimated);
    let _ = decimated.end();
    if let Err(RunError::Sink(error)) = result {
        return Err(json!([{ "message": error.to_string(), "help": "" }]));
    }
    Ok(json!({ "text": String::from_utf8_lossy(&decimated.sink.text) }))
}

struct CsvSink {
    columns: Vec<Column>,
    text: Vec<u8>,
}

impl Sink for CsvSink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        csv_sample(&mut self.text, &self.columns, sample).expect("writing to memory cannot fail");
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}
