//! One scene text through everything: read, run, held to the invariants, logged, and its log read back.

use std::collections::BTreeMap;
use std::fmt;
use std::io::Cursor;
use std::time::{Duration, Instant};

use phalanx::integrator::{Failure, Reason};
use phalanx::invariants::{Finding, Invariant};
use phalanx::log::{self, LogSink, Reading, RunInfo, Severity, Writer};
use phalanx::scene::words::SceneKind;
use phalanx::scene::{Scene, parse_any};
use phalanx::trace::{BodyState, Event, Layout, Model, RunError, Sample, Sink, SinkError};
use prost_reflect::{DescriptorPool, DynamicMessage, Value};

use crate::support::held;

/// What takes longer hangs: the slowest take a second or two on an idle machine.
const LONGEST: Duration = Duration::from_secs(120);

/// How far an accuracy may be missed in scenes that nobody would make, in tolerances. Those are for grippers; the masses,
/// springs and laws of random scenes go over decades. What holds at any accuracy has no such slack: numbers are finite,
/// nothing pulls, friction stays in its cone, no surface is deeper in than its energy allows.
fn ceiling(model: Model) -> f64 {
    match model {
        Model::Analytic => 60.0,
        Model::Engine => 40.0,
    }
}

/// What is left of broken invariants; those within the ceiling are only counted.
fn serious(found: Vec<Finding>, ceiling: f64, counts: &mut Counts) -> Vec<Finding> {
    let (near, serious): (Vec<Finding>, Vec<Finding>) = found.into_iter().partition(|one| {
        let exact = matches!(one.invariant, Invariant::Finite | Invariant::Penetration | Invariant::JointLimit);
        !exact && one.share() <= ceiling
    });
    for one in near {
        let (count, worst) = counts.missed.entry(one.invariant.name()).or_default();
        (*count, *worst) = (*count + 1, worst.max(one.share()));
    }
    serious
}

/// How many scenes went which way.
#[derive(Debug, Default)]
pub struct Counts {
    completed: u64,
    refused: BTreeMap<String, u64>,
    ended: BTreeMap<String, u64>,
    slowest: Duration,
    /// Runs that missed the tolerance of an invariant by less than [`ceiling`], and the worst of them.
    missed: BTreeMap<&'static str, (u64, f64)>,
}

impl Counts {
    pub fn completed(&self) -> u64 {
        self.completed
    }

    pub fn refused(&self) -> u64 {
        self.refused.values().sum()
    }

    pub fn ended(&self) -> u64 {
        self.ended.values().sum()
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (completed, ended, refused) = (self.completed, self.ended(), self.refused());
        write!(f, "{completed} completed, {ended} ended early, {refused} refused, slowest {:?}", self.slowest)?;
        for (invariant, (count, worst)) in &self.missed {
            write!(f, "\n  missed  {count:5}: {invariant}, by up to {worst:.1} of its tolerance")?;
        }
        for (what, reasons) in [("ended", &self.ended), ("refused", &self.refused)] {
            for (reason, count) in reasons {
                write!(f, "\n  {what} {count:5}: {reason}")?;
            }
        }
        Ok(())
    }
}

/// Puts one scene through.
///
/// # Errors
/// What is wrong with how it went.
pub fn trial(model: Model, text: &str, counts: &mut Counts) -> Result<(), String> {
    let scene = match parse_any(text, "random.toml") {
        Ok(scene) => scene,
        Err(error) => {
            let problems = error.problems();
            if problems.is_empty() {
                return Err(format!("refused without a problem: {error}"));
            }
            for problem in problems {
                if problem.message.is_empty() || problem.help.is_empty() {
                    return Err(format!("refused without a message or a way out: {error}"));
                }
                if problem.span.is_some() && !error.to_string().contains("random.toml:") {
                    return Err(format!("refused without a line: {error}"));
                }
            }
            *counts.refused.entry(kind(&problems[0].message)).or_default() += 1;
            return Ok(());
        }
    };
    let start = Instant::now();
    let ended = put_through(model, &scene, counts)?;
    let took = start.elapsed();
    counts.slowest = counts.slowest.max(took);
    if took > LONGEST {
        return Err(format!("took {took:?}"));
    }
    match ended {
        None => counts.completed += 1,
        Some(failure) => *counts.ended.entry(named(&failure)?).or_default() += 1,
    }
    Ok(())
}

/// The kind of a reason, which has to be one that says what to do or what happened.
fn named(failure: &Failure) -> Result<String, String> {
    match &failure.reason {
        Reason::NotFinite => Err(format!("ended with numbers that are none: {failure}")),
        Reason::Stopped => Err("stopped by nobody".to_string()),
        reason => Ok(kind(&reason.to_string())),
    }
}

/// A message without its figures and names.
fn kind(message: &str) -> String {
    let mut kind = String::new();
    for word in message.split(' ').take(12) {
        let plain = word.starts_with(|first: char| first.is_alphabetic() || first == '`');
        kind.push_str(if plain && !word.contains(|c: char| c.is_ascii_digit()) { word } else { "…" });
        kind.push(' ');
    }
    kind.trim_end().to_string()
}

fn writer(model: Model, scene: &Scene) -> Writer<Vec<u8>> {
    let info = RunInfo { scene, scene_file: "random.toml", model: model.name() };
    Writer::new(Vec::new(), "the log", &info).expect("a log in memory")
}

/// Runs a scene, logs it and reads the log; how it ended early, where it did.
fn put_through(model: Model, scene: &Scene, counts: &mut Counts) -> Result<Option<Failure>, String> {
    let mut writer = writer(model, scene);
    let (result, found) = held::judged(model, scene, &mut writer);
    let (outcome, failure) = match result {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure, so_far }) => (*so_far, Some(failure)),
        Err(RunError::Sink(error)) => return Err(error.to_string()),
    };
    let found = serious(found, ceiling(model), counts);
    if !found.is_empty() {
        return Err(format!("{}{}", held::lines(&found), after(failure.as_ref())));
    }
    let bytes = finish(writer, outcome.last.time_s, failure.as_ref());
    let mut last = Last::default();
    let reading = log::read_any(Cursor::new(&bytes), &mut last).map_err(|error| error.to_string())?;
    whole(&reading, failure.as_ref())?;
    // A run that never started has neither a state nor a sample.
    if last.0.as_ref() != Some(&outcome.last) && reading.samples > 0 {
        return Err(format!("the log ends with {:?}, the run with {:?}", last.0, outcome.last));
    }
    if scene.kind() == SceneKind::Bodies {
        last_states(&bytes, scene, &outcome.last)?;
    }
    if failure.is_none() && outcome.ejected_s.is_none() && outcome.last.time_s != scene.duration_s {
        return Err(format!("completed at {} s of {} s", outcome.last.time_s, scene.duration_s));
    }
    Ok(failure)
}

fn after(failure: Option<&Failure>) -> String {
    failure.map_or(String::new(), |failure| format!("\nin a run that ended {failure}"))
}

/// Ends a log as the command line does.
fn finish(mut writer: Writer<Vec<u8>>, time_s: f64, failure: Option<&Failure>) -> Vec<u8> {
    let line = failure.map_or("completed".to_string(), |failure| format!("stopped: {failure}"));
    writer.note(time_s, Severity::Info, "run", &line).expect("written");
    writer.finish().expect("finished")
}

fn whole(reading: &Reading, failure: Option<&Failure>) -> Result<(), String> {
    if !reading.is_whole() {
        return Err(format!("the log has losses: {:?}", reading.losses));
    }
    let stopped = reading.ended.as_ref().ok_or("the log does not say how the run ended")?.stopped.as_deref();
    match stopped == failure.map(Failure::to_string).as_deref() {
        true => Ok(()),
        false => Err(format!("the log says {stopped:?} instead of {failure:?}")),
    }
}

#[derive(Default)]
struct Last(Option<Sample>);

impl Sink for Last {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0 = Some(sample.clone());
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

impl LogSink for Last {
    fn layout(&mut self, _: &Layout) -> Result<(), SinkError> {
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        Sink::sample(self, sample)
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

/// The last message of every disc is its last state.
fn last_states(bytes: &[u8], scene: &Scene, last: &Sample) -> Result<(), String> {
    let mut latest = BTreeMap::new();
    for message in mcap::MessageStream::new(bytes).map_err(|error| error.to_string())? {
        let message = message.map_err(|error| error.to_string())?;
        if message.channel.topic.starts_with("/disc/") {
            latest.insert(message.channel.topic.clone(), message);
        }
    }
    for (disc, state) in scene.system.discs.iter().zip(&last.bodies) {
        let message = latest.get(&format!("/disc/{}", disc.name)).ok_or("a disc without a message")?;
        let schema = message.channel.schema.as_ref().ok_or("a channel without a schema")?;
        let pool = DescriptorPool::decode(&schema.data[..]).map_err(|error| error.to_string())?;
        let descriptor = pool.get_message_by_name(&schema.name).ok_or("a schema without its message")?;
        let found = DynamicMessage::decode(descriptor, &message.data[..]).map_err(|error| error.to_string())?;
        let BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s } = *state;
        for (field, wanted) in [
            ("timestamp", last.time_s),
            ("x_m", x),
            ("y_m", y),
            ("angle_rad", angle_rad),
            ("vx_m_s", vx),
            ("vy_m_s", vy),
            ("spin_rad_s", spin_rad_s),
        ] {
            let value = found.get_field_by_name(field).map(|value| value.into_owned());
            if value != Some(Value::F64(wanted)) {
                return Err(format!("{}: {field} is {value:?} in the log, {wanted} in the run", disc.name));
            }
        }
    }
    Ok(())
}
