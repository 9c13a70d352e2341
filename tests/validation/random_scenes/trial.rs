//! Processes one scene text: parses it, runs it, checks the invariants, logs the run and reads the log.

use std::collections::BTreeMap;
use std::fmt;
use std::io::Cursor;
use std::time::{Duration, Instant};

use phalanx::integrator::{Failure, Reason};
use phalanx::invariants::{Finding, Invariant};
use phalanx::log::{self, LogSink, LogSummary, RunInfo, Severity, Writer};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{Scene, parse_any};
use phalanx::trace::{BodyState, Event, Model, RunError, Sample, Schema, Sink, SinkError};
use prost_reflect::{DescriptorPool, DynamicMessage, Value};

use crate::support::checked_run;

/// Longest duration of a run; longer runs count as hanging. The slowest take one or two seconds on an idle machine.
const MAX_DURATION: Duration = Duration::from_secs(120);

/// Allowed ratio of an invariant to its tolerance in random scenes. The tolerances are meant for grippers, but masses,
/// springs and laws of random scenes span decades. Invariants that hold at any accuracy have no such margin: numbers
/// are finite, no normal force is negative, friction stays in its cone, and no penetration exceeds the one that the
/// energy allows.
fn max_ratio(model: Model) -> f64 {
    match model {
        Model::Analytic => 60.0,
        Model::Engine => 40.0,
    }
}

/// Returns the violations beyond `max_ratio`; the others are only counted.
fn remove_tolerated(findings: Vec<Finding>, max_ratio: f64, counts: &mut Counts) -> Vec<Finding> {
    let (tolerated, serious): (Vec<Finding>, Vec<Finding>) = findings.into_iter().partition(|finding| {
        let is_exact = matches!(finding.invariant, Invariant::Finite | Invariant::Penetration | Invariant::JointLimit);
        !is_exact && finding.ratio_to_limit() <= max_ratio
    });
    for finding in tolerated {
        let (count, worst) = counts.exceeded.entry(finding.invariant.name()).or_default();
        (*count, *worst) = (*count + 1, worst.max(finding.ratio_to_limit()));
    }
    serious
}

/// Counts of scenes by result.
#[derive(Debug, Default)]
pub struct Counts {
    completed: u64,
    rejected: BTreeMap<String, u64>,
    ended: BTreeMap<String, u64>,
    slowest: Duration,
    /// Number of runs beyond the tolerance of an invariant by a ratio below [`max_ratio`], and the largest ratio.
    exceeded: BTreeMap<&'static str, (u64, f64)>,
}

impl Counts {
    pub fn completed(&self) -> u64 {
        self.completed
    }

    pub fn rejected(&self) -> u64 {
        self.rejected.values().sum()
    }

    pub fn ended(&self) -> u64 {
        self.ended.values().sum()
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (completed, ended, rejected) = (self.completed, self.ended(), self.rejected());
        write!(f, "{completed} completed, {ended} ended early, {rejected} rejected, slowest {:?}", self.slowest)?;
        for (invariant, (count, worst)) in &self.exceeded {
            write!(f, "\n  exceeded {count:5}: {invariant}, by up to {worst:.1} of its tolerance")?;
        }
        for (outcome, reasons) in [("ended", &self.ended), ("rejected", &self.rejected)] {
            for (reason, count) in reasons {
                write!(f, "\n  {outcome} {count:5}: {reason}")?;
            }
        }
        Ok(())
    }
}

/// Processes one scene and counts its result.
///
/// # Errors
/// A description of the first problem.
pub fn run_trial(model: Model, text: &str, counts: &mut Counts) -> Result<(), String> {
    let scene = match parse_any(text, "random.toml") {
        Ok(scene) => scene,
        Err(error) => {
            let problems = error.problems();
            if problems.is_empty() {
                return Err(format!("rejected without a problem: {error}"));
            }
            for problem in problems {
                if problem.message.is_empty() || problem.help.is_empty() {
                    return Err(format!("rejected without a message or a remedy: {error}"));
                }
                if problem.span.is_some() && !error.to_string().contains("random.toml:") {
                    return Err(format!("rejected without a line: {error}"));
                }
            }
            *counts.rejected.entry(message_kind(&problems[0].message)).or_default() += 1;
            return Ok(());
        }
    };
    let start = Instant::now();
    let ended = run_and_log(model, &scene, counts)?;
    let duration = start.elapsed();
    counts.slowest = counts.slowest.max(duration);
    if duration > MAX_DURATION {
        return Err(format!("took {duration:?}"));
    }
    match ended {
        None => counts.completed += 1,
        Some(failure) => *counts.ended.entry(reason_kind(&failure)?).or_default() += 1,
    }
    Ok(())
}

/// Returns the kind of a reason.
///
/// # Errors
/// The reason is one that must not occur.
fn reason_kind(failure: &Failure) -> Result<String, String> {
    match &failure.reason {
        Reason::NotFinite => Err(format!("ended with values that are not finite: {failure}")),
        Reason::Stopped => Err("stopped without a request".to_string()),
        reason => Ok(message_kind(&reason.to_string())),
    }
}

/// Returns a message without its figures and names.
fn message_kind(message: &str) -> String {
    let mut kind = String::new();
    for word in message.split(' ').take(12) {
        let is_plain = word.starts_with(|first: char| first.is_alphabetic() || first == '`');
        kind.push_str(if is_plain && !word.contains(|c: char| c.is_ascii_digit()) { word } else { "…" });
        kind.push(' ');
    }
    kind.trim_end().to_string()
}

fn create_writer(model: Model, scene: &Scene) -> Writer<Vec<u8>> {
    let info = RunInfo { scene, scene_file: "random.toml", model: model.name() };
    Writer::new(Vec::new(), "the log", &info).expect("a log in memory")
}

/// Runs a scene, logs it and reads the log. Returns the failure of an incomplete run.
///
/// # Errors
/// A description of the first problem.
fn run_and_log(model: Model, scene: &Scene, counts: &mut Counts) -> Result<Option<Failure>, String> {
    let mut writer = create_writer(model, scene);
    let (result, violations) = checked_run::run_and_check(model, scene, &mut writer);
    let (outcome, failure) = match result {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure, partial_outcome }) => (*partial_outcome, Some(failure)),
        Err(RunError::Sink(error)) => return Err(error.to_string()),
    };
    let violations = remove_tolerated(violations, max_ratio(model), counts);
    if !violations.is_empty() {
        return Err(format!("{}{}", checked_run::format_findings(&violations), failure_suffix(failure.as_ref())));
    }
    let bytes = finish(writer, outcome.last.time_s, failure.as_ref());
    let mut last = LastSample::default();
    let summary = log::read(Cursor::new(&bytes), &mut last).map_err(|error| error.to_string())?;
    check_log_summary(&summary, failure.as_ref())?;
    // A run that did not start has neither a state nor a sample.
    if last.0.as_ref() != Some(&outcome.last) && summary.samples > 0 {
        return Err(format!("the log ends with {:?}, the run with {:?}", last.0, outcome.last));
    }
    if scene.kind() == SceneKind::Bodies {
        check_last_states(&bytes, scene, &outcome.last)?;
    }
    if failure.is_none() && outcome.ejected_s.is_none() && outcome.last.time_s != scene.duration_s {
        return Err(format!("completed at {} s of {} s", outcome.last.time_s, scene.duration_s));
    }
    Ok(failure)
}

fn failure_suffix(failure: Option<&Failure>) -> String {
    failure.map_or(String::new(), |failure| format!("\nin a run that ended {failure}"))
}

/// Ends a log in the same way as the command line does.
fn finish(mut writer: Writer<Vec<u8>>, time_s: f64, failure: Option<&Failure>) -> Vec<u8> {
    let line = failure.map_or("completed".to_string(), |failure| format!("stopped: {failure}"));
    writer.note(time_s, Severity::Info, "run", &line).expect("written");
    writer.finish().expect("finished")
}

fn check_log_summary(summary: &LogSummary, failure: Option<&Failure>) -> Result<(), String> {
    if !summary.is_complete() {
        return Err(format!("the log has losses: {:?}", summary.losses));
    }
    let stopped = summary.run_end.as_ref().ok_or("the log does not say how the run ended")?.stopped.as_deref();
    match stopped == failure.map(Failure::to_string).as_deref() {
        true => Ok(()),
        false => Err(format!("the log says {stopped:?} instead of {failure:?}")),
    }
}

#[derive(Default)]
struct LastSample(Option<Sample>);

impl Sink for LastSample {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0 = Some(sample.clone());
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

impl LogSink for LastSample {
    fn layout(&mut self, _: &Schema) -> Result<(), SinkError> {
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        Sink::sample(self, sample)
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Checks that the last message of every disc is its last state.
fn check_last_states(bytes: &[u8], scene: &Scene, last: &Sample) -> Result<(), String> {
    let mut latest = BTreeMap::new();
    for message in mcap::MessageStream::new(bytes).map_err(|error| error.to_string())? {
        let message = message.map_err(|error| error.to_string())?;
        if message.channel.topic.starts_with("/disc/") {
            latest.insert(message.channel.topic.clone(), message);
        }
    }
    for (disc, state) in scene.system.discs.iter().zip(last.bodies()) {
        let message = latest.get(&format!("/disc/{}", disc.name)).ok_or("a disc without a message")?;
        let schema = message.channel.schema.as_ref().ok_or("a channel without a schema")?;
        let pool = DescriptorPool::decode(&schema.data[..]).map_err(|error| error.to_string())?;
        let descriptor = pool.get_message_by_name(&schema.name).ok_or("a schema without its message")?;
        let decoded = DynamicMessage::decode(descriptor, &message.data[..]).map_err(|error| error.to_string())?;
        let BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s } = state;
        for (field, expected) in [
            ("timestamp", last.time_s),
            ("x_m", x),
            ("y_m", y),
            ("angle_rad", angle_rad),
            ("vx_m_s", vx),
            ("vy_m_s", vy),
            ("spin_rad_s", spin_rad_s),
        ] {
            let value = decoded.get_field_by_name(field).map(|value| value.into_owned());
            if value != Some(Value::F64(expected)) {
                return Err(format!("{}: {field} is {value:?} in the log, {expected} in the run", disc.name));
            }
        }
    }
    Ok(())
}
