//! The scene as a file, and the samples as comma-separated values.

use serde_json::{Value, json};

use super::request::Request;
use crate::report::samples::{csv_head, csv_sample};
use crate::scene::Scene;
use crate::trace::columns::{Column, columns};
use crate::trace::{Event, Layout, RunError, Sample, Sink, SinkError, Thinned, run_analytic};

/// A scene file that says what the scene's own did, with what was set.
pub fn scene_file(request: &Request, scene: &Scene) -> Value {
    let set: Vec<String> = request.set.iter().map(|(field, value)| format!("{field} = {value}")).collect();
    let of = if set.is_empty() { String::new() } else { format!(" with {}", set.join(", ")) };
    // A comment is one line.
    let of: String = of.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let text = &scene.source;
    let text = text.strip_prefix('\n').unwrap_or(text);
    json!({ "text": format!("# {}{of}, from the explorer of phalanx.\n{text}", request.scene.file) })
}

/// As `phalanx replay --csv` writes them.
pub fn samples(scene: &Scene) -> Result<Value, Value> {
    let mut lines = Lines { columns: columns(&Layout::of(&scene.system)), text: Vec::new() };
    csv_head(&mut lines.text, &lines.columns).expect("memory takes all that is written");
    let mut thinned = Thinned::new(scene.log.numeric_hz, lines);
    // Of a run that broke off: the samples up to there.
    let ran = run_analytic(scene, &mut thinned);
    let _ = thinned.end();
    if let Err(RunError::Sink(error)) = ran {
        return Err(json!([{ "message": error.to_string(), "help": "" }]));
    }
    Ok(json!({ "text": String::from_utf8_lossy(&thinned.sink.text) }))
}

struct Lines {
    columns: Vec<Column>,
    text: Vec<u8>,
}

impl Sink for Lines {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        csv_sample(&mut self.text, &self.columns, sample).expect("memory takes all that is written");
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}
