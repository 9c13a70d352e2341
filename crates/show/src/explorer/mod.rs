//! Requests of the explorer page. Input is a scene with settings; output is playbacks, figures and texts. All results
//! are computed by the same functions as on the command line, with the analytic model.
//!
//! A request is a JSON text. A response is a JSON text and an array of numbers, to which the text refers by offset.
//!
//! | file | job |
//! |---|---|
//! | `fields` | every field of a scene: type, allowed values, current value |
//! | `figures` | the figures of a run by the keys of its JSON document, with labels and texts |

mod fields;
mod figures;

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Value, json};

use crate::check;
use crate::criteria::{LinkOverlap, RunCriteria, RunCriteriaTracker};
use crate::format::ToReport;
use crate::grasp::finger::{GraspOverrides, grasp};
use crate::grasp::gripper::{GripperGraspRequest, PostureRequest, gripper_grasp};
use crate::grasp::mechanism::{MechanismGraspRequest, mechanism_grasp};
use crate::invariants::EnergyAudit;
use crate::playback::{PlaybackRecorder, json as playback_json};
use crate::plot::{self, PictureFormat};
use crate::report::check::{RunCheckReport, summary_line};
use crate::report::document::{Failure, RunData, RunReport};
use crate::report::samples::{csv_head, csv_sample};
use crate::report::statics::{GripperStaticsReport, MechanismStaticsReport, StaticsReport};
use crate::scene::{Layer, Scene, SceneError, parse_layers, setting_from_parts};
use crate::trace::{
    Channel, Decimated, Event, Model, OffGrid, RequiredData, RunError, Sample, Schema, Sink, SinkError, run_analytic,
};
use figures::{figures, leaves, verdict};

/// Number of directions of acceleration in the picture of the grasp at rest of a gripper or a mechanism.
const DIRECTIONS: usize = 72;
/// Stride of the directions in its table, which are 15° apart.
const IN_TABLE: usize = 3;

/// A JSON text, and the numbers to which it refers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    pub text: String,
    pub data: Vec<f64>,
}

/// A request about a scene.
#[derive(Debug, Deserialize)]
struct Request {
    #[serde(rename = "ask")]
    kind: RequestKind,
    #[serde(rename = "scene")]
    file: SceneFile,
    /// Fields and their values, as in `--set FIELD=VALUE`.
    #[serde(default)]
    set: Vec<(String, String)>,
    /// The fields that a map varies, and their values: one row per run.
    #[serde(default)]
    fields: Vec<String>,
    #[serde(default)]
    points: Vec<Vec<String>>,
}

#[derive(Debug, Deserialize)]
struct SceneFile {
    file: String,
    text: String,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RequestKind {
    Fields,
    Run,
    Check,
    Statics,
    Criteria,
    Toml,
    Csv,
}

/// Returns the response to a request. Errors are listed under `problems`, each with its `message` and `help`.
pub fn respond(request: &str) -> Response {
    let mut data = Vec::new();
    let found = match serde_json::from_str::<Request>(request) {
        Ok(request) => request.respond(&mut data),
        Err(error) => {
            Err(json!([{ "message": format!("invalid request: {error}"), "help": "this is an error of the page" }]))
        }
    };
    let text = found.unwrap_or_else(|problems| json!({ "problems": problems }));
    Response { text: text.to_string(), data }
}

impl Request {
    /// Returns the response, or the problems of the scene.
    fn respond(&self, data: &mut Vec<f64>) -> Result<Value, Value> {
        let scene = || self.scene(&[]);
        Ok(match self.kind {
            RequestKind::Criteria => criteria(self, data),
            RequestKind::Fields => fields::fields(&scene()?),
            RequestKind::Run => run(&scene()?, data),
            RequestKind::Check => check(&scene()?),
            RequestKind::Statics => statics(&scene()?)?,
            RequestKind::Toml => self.scene_file(&scene()?),
            RequestKind::Csv => samples(&scene()?)?,
        })
    }

    /// Parses the scene with the settings of the request and the `extra` settings, or returns its problems.
    fn scene(&self, extra: &[(String, String)]) -> Result<Scene, Value> {
        let base = Layer { file: self.file.file.clone(), text: self.file.text.clone() };
        // A layer is named after its field, so that its errors refer to the field.
        let layer = |(field, value): &(String, String)| {
            setting_from_parts(field, field, value).map_err(|message| json!([problem(&message, Some(field))]))
        };
        let settings = self.set.iter().chain(extra).map(layer).collect::<Result<Vec<_>, Value>>()?;
        parse_layers(&[base], &settings).map_err(|error| json!(problems(&error)))
    }

    /// Returns the text of the scene file with the settings applied.
    fn scene_file(&self, scene: &Scene) -> Value {
        let set: Vec<String> = self.set.iter().map(|(field, value)| format!("{field} = {value}")).collect();
        let changes = if set.is_empty() { String::new() } else { format!(" with {}", set.join(", ")) };
        // The comment must stay on one line.
        let changes = changes.replace(char::is_control, " ");
        let text = scene.source.strip_prefix('\n').unwrap_or(&scene.source);
        json!({ "text": format!("# {}{changes}, from the explorer of phalanx.\n{text}", self.file.file) })
    }
}

/// A problem with a field, if known, without advice.
fn problem(message: &str, field: Option<&str>) -> Value {
    json!({ "message": message, "help": "", "line": null, "field": field.filter(|field| !field.is_empty()) })
}

/// Problems of a file (with their lines) or of a setting (with its field).
fn problems(error: &SceneError) -> Vec<Value> {
    let (file, text, problems) = match error {
        SceneError::Layers(errors) => return errors.iter().flat_map(problems).collect(),
        SceneError::Invalid { file, text, problems } => (file, text, problems),
        other => return vec![problem(&other.to_string(), None)],
    };
    let is_file = file.ends_with(".toml");
    let line = |offset: usize| text.get(..offset).map_or(1, |before| before.matches('\n').count() + 1);
    let document = problems.iter().map(|problem| {
        json!({
            "message": problem.message,
            "label": problem.label,
            "help": problem.help,
            "line": problem.span.as_ref().filter(|_| is_file).map(|span| line(span.start)),
            "field": (!is_file).then_some(file),
        })
    });
    document.collect()
}

/// Returns tables and a picture of the grasp at rest, as reported by `phalanx statics`.
fn statics(scene: &Scene) -> Result<Value, Value> {
    let problem = |error: &dyn std::fmt::Display| {
        let help = "the run does not depend on this analysis";
        json!([{ "message": error.to_string(), "help": help, "line": null, "field": null }])
    };
    let (report, caption, picture) = match scene.finger_count() {
        0 => {
            let request = MechanismGraspRequest { directions: DIRECTIONS, ..MechanismGraspRequest::default() };
            let result = mechanism_grasp(scene, &request, &|| true).map_err(|error| problem(&error))?;
            let picture = plot::mechanism_balance(scene, &result, PictureFormat::Column);
            let report = MechanismStaticsReport::new(&result, IN_TABLE).report();
            (report, "Accelerations of the base that the grasp withstands", picture)
        }
        1 => {
            let result = grasp(scene, &GraspOverrides::default()).map_err(|error| problem(&error))?;
            let picture = plot::grasp(scene, &result, PictureFormat::Column);
            (StaticsReport::new(&result).report(), "The grasp at rest: forces on the object", picture)
        }
        _ => {
            let posture = PostureRequest::Run { at_s: None, within_m: None };
            let request =
                GripperGraspRequest { posture, mu_static: Vec::new(), motor_n_m: None, directions: DIRECTIONS };
            let result = gripper_grasp(scene, &request, &|| true).map_err(|error| problem(&error))?;
            let picture = plot::balance(scene, &result, PictureFormat::Column);
            let report = GripperStaticsReport::new(&result, IN_TABLE).report();
            (report, "Accelerations of the palm that the grasp withstands", picture)
        }
    };
    Ok(json!({
        "sections": [{ "title": "At rest", "html": report.html("At rest") }],
        "pictures": [{ "title": caption, "svg": picture }],
    }))
}

/// Runs a scene; `sink` also receives the samples. Criteria are evaluated as on the command line.
fn simulate(scene: &Scene, sink: &mut impl Sink) -> RunReport {
    let numeric_hz = scene.log.numeric_hz;
    let listeners = Listeners {
        criteria_tracker: OffGrid::new(numeric_hz, RunCriteriaTracker::for_scene(scene)),
        audit: OffGrid::new(numeric_hz, EnergyAudit::new(Model::Analytic, scene)),
        sink,
    };
    let mut decimated = Decimated::new(numeric_hz, listeners);
    let result = run_analytic(scene, &mut decimated);
    // No sink here returns an error.
    let _ = decimated.end();
    let Listeners { mut criteria_tracker, mut audit, .. } = decimated.sink;
    let _ = criteria_tracker.end().and_then(|()| audit.end());
    let energy = audit.sink.violation().map(|breach| breach.to_string());
    let RunCriteria { criteria, grasp, rebounds, overlaps, cable_events } =
        criteria_tracker.sink.finish(result.is_ok());
    let (outcome, error) = match result {
        Ok(outcome) => (Some(outcome), None),
        Err(RunError::Simulation { failure, partial_outcome }) => {
            (Some(*partial_outcome), Some(Failure { time_s: failure.time_s, reason: failure.reason.to_string() }))
        }
        Err(RunError::Sink(error)) => (None, Some(Failure { time_s: 0.0, reason: error.to_string() })),
    };
    let warnings: Vec<String> = energy.into_iter().chain(overlaps.iter().map(LinkOverlap::sentence)).collect();
    let (outcome, grasp) = (outcome.as_ref(), grasp.as_ref());
    let (rebounds, cable_events, warnings) = (&rebounds[..], &cable_events[..], &warnings[..]);
    let data = RunData { wall_s: 0.0, outcome, criteria, grasp, rebounds, cable_events, warnings };
    RunReport::new(scene, Model::Analytic, &data, error)
}

/// Passes samples and events to the judge, the energy audit and one more sink.
struct Listeners<'a, A> {
    criteria_tracker: OffGrid<RunCriteriaTracker>,
    audit: OffGrid<EnergyAudit>,
    sink: &'a mut A,
}

impl<A: Sink> Sink for Listeners<'_, A> {
    fn required_data(&self) -> RequiredData {
        let evaluation = self.criteria_tracker.required_data().or(self.audit.required_data());
        evaluation.or(self.sink.required_data())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.criteria_tracker.sample(sample)?;
        self.audit.sample(sample)?;
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.criteria_tracker.event(event)?;
        self.audit.event(event)?;
        self.sink.event(event)
    }
}

/// Returns the playback and the figures of a run.
fn run(scene: &Scene, numbers: &mut Vec<f64>) -> Value {
    let mut recorder = PlaybackRecorder::default();
    let report = simulate(scene, &mut recorder);
    let playback = recorder.into_playback(Model::Analytic.name(), scene, "").with_grasp(report.played_grasp());
    json!({
        "playback": playback_json::append_run(&playback, numbers),
        "figures": figures(&report, scene.finger_count() > 0),
        "verdict": verdict(&report),
        "failed": report.error.as_ref().map(|error| &error.reason),
        "warnings": report.warnings,
        "steps": report.steps,
    })
}

/// Returns the result of the check of a run.
fn check(scene: &Scene) -> Value {
    let found = check::check(Model::Analytic, scene, &|| true);
    let report = RunCheckReport::new(&found, scene.has_joints());
    json!({
        "verdict": found.verdict.name(),
        "text": summary_line(Some(&report), None),
        "error": found.errors.path,
        "bar": found.max_path_error,
        "report": report,
    })
}

/// Runs every point of a map. Appends the numerical figures to `numbers` row by row, NaN if a run lacks a figure;
/// figures in words are returned under `words`. A point with an invalid scene has neither.
fn criteria(request: &Request, numbers: &mut Vec<f64>) -> Value {
    let run = |point: &Vec<String>| {
        let set: Vec<(String, String)> = request.fields.iter().cloned().zip(point.iter().cloned()).collect();
        match request.scene(&set) {
            Ok(scene) => (leaves(&simulate(&scene, &mut ())), Value::Null),
            Err(problems) => (Vec::new(), problems[0]["message"].clone()),
        }
    };
    let (rows, refused): (Vec<_>, Vec<Value>) = request.points.iter().map(run).unzip();
    let mut columns: Vec<&str> = Vec::new();
    let mut words: BTreeMap<&str, Vec<Option<&str>>> = BTreeMap::new();
    for (key, value) in rows.iter().flatten() {
        if value.is_number() && !columns.contains(&key.as_str()) {
            columns.push(key);
        } else if value.is_string() {
            words.entry(key).or_default();
        }
    }
    for row in &rows {
        let leaf = |key: &str| row.iter().find(|(known, _)| known == key).map(|(_, value)| value);
        numbers.extend(columns.iter().map(|column| leaf(column).and_then(Value::as_f64).unwrap_or(f64::NAN)));
        words.iter_mut().for_each(|(key, list)| list.push(leaf(key).and_then(Value::as_str)));
    }
    json!({ "columns": columns, "words": words, "refused": refused })
}

/// Returns the samples in the format of `phalanx replay --csv`.
fn samples(scene: &Scene) -> Result<Value, Value> {
    let mut lines = CsvSink { channels: Schema::from_scene(scene).channels(), text: Vec::new() };
    csv_head(&mut lines.text, &lines.channels).expect("writing to memory cannot fail");
    let mut decimated = Decimated::new(scene.log.numeric_hz, lines);
    // A run that fails early has the samples up to its failure.
    let result = run_analytic(scene, &mut decimated);
    let _ = decimated.end();
    match result {
        Err(RunError::Sink(error)) => Err(json!([{ "message": error.to_string(), "help": "" }])),
        _ => Ok(json!({ "text": String::from_utf8_lossy(&decimated.sink.text) })),
    }
}

struct CsvSink {
    channels: Vec<Channel>,
    text: Vec<u8>,
}

impl Sink for CsvSink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        csv_sample(&mut self.text, &self.channels, sample).expect("writing to memory cannot fail");
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A gripper that is a mechanism, with two more parameters.
    fn two_pivot() -> Value {
        let text = include_str!("../../../../scenes/mechanisms/two-pivot.toml")
            .replace("start = { at = [\"3 mm\", \"120 mm\"] }", "start = { at = [\"3 mm\", \"= height\"] }")
            .replace("targets = [\"0 rad\", \"0.8 rad\"]", "targets = [\"0 rad\", \"= close\"]")
            .replace("[parameters]\n", "[parameters]\nheight = \"120 mm\"\nclose = \"0.8 rad\"\n");
        json!({ "file": "own.toml", "text": text })
    }

    fn ask(kind: &str, scene: &Value, more: &Value) -> (Value, Vec<f64>) {
        let mut request = json!({ "ask": kind, "scene": scene });
        let more = more.as_object().into_iter().flatten();
        more.for_each(|(key, value)| request[key] = value.clone());
        let Response { text, data } = respond(&request.to_string());
        (serde_json::from_str(&text).expect("a response is JSON"), data)
    }

    fn words(list: &Value) -> Vec<&str> {
        list.as_array().into_iter().flatten().filter_map(Value::as_str).collect()
    }

    #[test]
    fn fields_of_a_mechanism_are_listed_by_its_parts_after_the_parameters() {
        let (found, _) = ask("fields", &two_pivot(), &Value::Null);
        assert_eq!(
            words(&found["design"])[..5],
            ["parameters.close", "parameters.driver", "parameters.height", "actuators.motor.kp", "actuators.motor.kd"]
        );
        let fields = found["fields"].as_array().expect("a list");
        let field = |path: &str| fields.iter().find(|field| field["path"] == path).unwrap_or_else(|| panic!("{path}"));
        // The entries of a pair have sliders; a list with an expression is one text.
        let radius = field("bodies.right_tip.outlines.pad.size[1]");
        assert_eq!(
            [&radius["group"], &radius["value"], &radius["kind"]],
            [&json!(["bodies", "right_tip"]), &json!(36.0), &json!("quantity")]
        );
        assert_eq!(field("actuators.motor.targets")["kind"], "list");
        assert_eq!(field("gravity")["group"], json!([]));
        let set = json!({ "set": [["bodies.right_tip.outlines.pad.size[1]", "30 mm"]] });
        let (changed, _) = ask("fields", &two_pivot(), &set);
        assert!(changed["problems"].is_null(), "{changed}");
    }

    #[test]
    fn a_mechanism_has_every_response() {
        let scene = two_pivot();
        let (found, data) = ask("run", &scene, &Value::Null);
        let keys: Vec<&str> =
            found["figures"].as_array().into_iter().flatten().filter_map(|each| each["key"].as_str()).collect();
        assert_eq!(
            keys[..4],
            [
                "grasp.fate",
                "grasp.margin.driven.acceleration_m_s2",
                "grasp.tts_s",
                "grasp.pairs.left_link.bar/object.rim.normal_n"
            ]
        );
        assert_eq!(found["figures"][3]["label"], "left link bar: end force");
        assert!(
            found["verdict"].as_str().is_some_and(|verdict| verdict.starts_with("held since")),
            "{}",
            found["verdict"]
        );
        assert!(data.len() > 1000);
        let (statics, _) = ask("statics", &scene, &Value::Null);
        assert!(
            statics["sections"][0]["html"].as_str().is_some_and(|html| html.contains("largest acceleration")),
            "{statics}"
        );
        let (file, _) = ask("toml", &scene, &json!({ "set": [["parameters.close", "0.7 rad"]] }));
        let again = json!({ "file": "again.toml", "text": file["text"] });
        let csv = |scene: &Value, more: &Value| ask("csv", scene, more).0["text"].as_str().map(str::to_string);
        let changed = csv(&scene, &json!({ "set": [["parameters.close", "0.7 rad"]] }));
        assert!(changed.is_some() && changed == csv(&again, &Value::Null));
        let (check, _) = ask("check", &scene, &Value::Null);
        assert!(check["verdict"].is_string(), "{check}");
    }

    /// Points of a map have fates and margins, and an invalid one its reason.
    #[test]
    fn maps_of_a_mechanism_have_fates_and_margins() {
        let map = json!({ "fields": ["parameters.height"], "points": [["120 mm"], ["200 mm"], ["70 mm"]] });
        let (found, data) = ask("criteria", &two_pivot(), &map);
        assert_eq!(found["words"]["grasp.fate"], json!(["held", "not grasped", null]));
        let columns = words(&found["columns"]);
        let margin =
            columns.iter().position(|column| *column == "grasp.margin.driven.acceleration_m_s2").expect("a margin");
        assert!(data[margin] > 100.0 && data[columns.len() + margin].is_nan(), "{}", data[margin]);
        assert!(found["refused"][2].as_str().is_some_and(|reason| reason.contains("inside")), "{found}");
    }

    #[test]
    fn a_mechanism_without_object_has_no_statics_and_says_why() {
        let text = include_str!("../../../../scenes/mechanisms/four-bar.toml");
        let scene = json!({ "file": "four-bar.toml", "text": text });
        let (found, _) = ask("statics", &scene, &Value::Null);
        assert!(
            found["problems"][0]["message"].as_str().is_some_and(|reason| reason.contains("no body without joints")),
            "{found}"
        );
        let (run, _) = ask("run", &scene, &Value::Null);
        assert!(run["playback"]["samples"].as_u64().is_some_and(|samples| samples > 10), "{}", run["failed"]);
    }
}
