//! Processes one scene text: parses it, runs it, checks the invariants, logs the run and reads the log.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use phalanx::check::run_and_record;
use phalanx::integrator::{Failure, Reason};
use phalanx::invariants::{Finding, Invariant};
use phalanx::log::{RunInfo, Severity, Writer};
use phalanx::scene::{Scene, parse_any};
use phalanx::trace::{BodyState, Model, RunError, Sample};
use prost_reflect::{DescriptorPool, DynamicMessage, Value};

use crate::campaign::trial::is_explained;
use crate::support::checked_run;
use crate::support::faults::{LogItem, read_bytes};

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

/// Counts of scenes by result.
#[derive(Debug, Default)]
pub struct Counts {
    pub completed: u64,
    /// Numbers of runs that ended early and of rejected scenes, by reason.
    pub ended: BTreeMap<String, u64>,
    pub rejected: BTreeMap<String, u64>,
    /// Number of runs beyond the tolerance of an invariant by a ratio below [`max_ratio`], and the largest ratio.
    exceeded: BTreeMap<&'static str, (u64, f64)>,
    /// Number of runs with a contact deeper than the roundings of its outlines that do not keep their energy.
    deep_contacts: u64,
    slowest: Duration,
}

/// Processes one scene and counts its result.
///
/// # Errors
/// A description of the first problem.
pub fn run_trial(model: Model, text: &str, counts: &mut Counts) -> Result<(), String> {
    let scene = match parse_any(text, "random.toml") {
        Ok(scene) => scene,
        Err(error) => {
            if !is_explained(&error, "random.toml") {
                return Err(format!("rejected without a problem, message, remedy or line: {error}"));
            }
            *counts.rejected.entry(message_kind(&error.problems()[0].message)).or_default() += 1;
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
    match ended.map(|failure| failure.reason) {
        None => counts.completed += 1,
        Some(reason @ (Reason::NotFinite | Reason::Stopped)) => return Err(format!("ended without a cause: {reason}")),
        Some(reason) => *counts.ended.entry(message_kind(&reason.to_string())).or_default() += 1,
    }
    Ok(())
}

/// Returns a message without its figures and names.
fn message_kind(message: &str) -> String {
    let is_plain = |word: &&str| word.chars().all(|c| c.is_alphabetic() || "`_.,".contains(c));
    message.split(' ').take(12).map(|word| Some(word).filter(is_plain).unwrap_or("…")).collect::<Vec<_>>().join(" ")
}

/// Runs a scene, logs it and reads the log. Returns the failure of an incomplete run.
///
/// # Errors
/// A description of the first problem.
fn run_and_log(model: Model, scene: &Scene, counts: &mut Counts) -> Result<Option<Failure>, String> {
    let mut scene = scene.clone();
    // The log then has all numbers of a sample.
    scene.log.joint_forces = true;
    let scene = &scene;
    let info = RunInfo { scene, scene_file: "random.toml", model: model.name() };
    let mut writer = Writer::new(Vec::new(), "the log", &info).expect("a log in memory");
    let (result, mut violations) = checked_run::run_and_check(model, scene, &mut writer);
    let (outcome, failure) = match result {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure, partial_outcome }) => (*partial_outcome, Some(failure)),
        Err(RunError::Sink(error)) => return Err(error.to_string()),
    };
    violations.retain(|finding| !is_tolerated(finding, max_ratio(model), counts));
    // The check says so too. Inside the core of a face the direction of the force jumps, and with it the energy.
    if !violations.is_empty() && run_and_record(model, scene, &mut ()).1.deep_contact.is_some() {
        let count = violations.len();
        violations.retain(|finding| !matches!(finding.invariant, Invariant::Energy | Invariant::Passivity));
        counts.deep_contacts += (violations.len() < count) as u64;
    }
    if !violations.is_empty() {
        return Err(format!("{}\nin a run that ended {failure:?}", checked_run::format_findings(&violations)));
    }
    // The log ends in the same way as that of the command line.
    let line = failure.as_ref().map_or("completed".to_string(), |failure| format!("stopped: {failure}"));
    writer.note(outcome.last.time_s, Severity::Info, "run", &line).expect("written");
    let bytes = writer.finish().expect("finished");
    let (summary, items) = read_bytes(&bytes);
    let summary = summary.map_err(|error| error.to_string())?;
    if !summary.is_complete() {
        return Err(format!("the log has losses: {:?}", summary.losses));
    }
    let stopped = summary.run_end.ok_or("the log does not say how the run ended")?.stopped;
    if stopped != failure.as_ref().map(Failure::to_string) {
        return Err(format!("the log says {stopped:?} instead of {failure:?}"));
    }
    let last = items.0.iter().rev().find_map(|item| match item {
        LogItem::Sample(sample) => Some(&**sample),
        LogItem::Event(_) => None,
    });
    // A run that did not start has neither a state nor a sample.
    if last.is_some_and(|last| *last != outcome.last) || last.is_none() && summary.samples > 0 {
        return Err(format!("the log ends with {last:?}, the run with {:?}", outcome.last));
    }
    if scene.finger_count() == 0 {
        check_last_states(&bytes, scene, &outcome.last)?;
    }
    if failure.is_none() && outcome.ejected_s.is_none() && outcome.last.time_s != scene.duration_s {
        return Err(format!("completed at {} s of {} s", outcome.last.time_s, scene.duration_s));
    }
    Ok(failure)
}

/// Whether a violation is within `max_ratio`; such violations are only counted.
fn is_tolerated(finding: &Finding, max_ratio: f64, counts: &mut Counts) -> bool {
    let is_exact = matches!(finding.invariant, Invariant::Finite | Invariant::Penetration | Invariant::JointLimit);
    let is_tolerated = !is_exact && finding.ratio_to_limit() <= max_ratio;
    if is_tolerated {
        let (count, worst) = counts.exceeded.entry(finding.invariant.name()).or_default();
        (*count, *worst) = (*count + 1, worst.max(finding.ratio_to_limit()));
    }
    is_tolerated
}

/// Checks that the last message of every disc is its last state.
fn check_last_states(bytes: &[u8], scene: &Scene, last: &Sample) -> Result<(), String> {
    let mut latest = BTreeMap::new();
    for message in mcap::MessageStream::new(bytes).map_err(|error| error.to_string())? {
        let message = message.map_err(|error| error.to_string())?;
        latest.insert(message.channel.topic.clone(), message);
    }
    for (disc, state) in scene.mechanism.iter().flat_map(|mechanism| &mechanism.bodies).zip(last.bodies()) {
        let message = latest.get(&format!("/body/{}", disc.name)).ok_or("a body without a message")?;
        let schema = message.channel.schema.as_ref().ok_or("a channel without a schema")?;
        let pool = DescriptorPool::decode(&schema.data[..]).map_err(|error| error.to_string())?;
        let descriptor = pool.get_message_by_name(&schema.name).ok_or("a schema without its message")?;
        let decoded = DynamicMessage::decode(descriptor, &message.data[..]).map_err(|error| error.to_string())?;
        let BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s } = state;
        let expected = [last.time_s, x, y, angle_rad, vx, vy, spin_rad_s];
        let fields = ["timestamp", "x_m", "y_m", "angle_rad", "vx_m_s", "vy_m_s", "spin_rad_s"];
        for (field, expected) in fields.into_iter().zip(expected) {
            let value = decoded.get_field_by_name(field).map(|value| value.into_owned());
            if value != Some(Value::F64(expected)) {
                return Err(format!("{}: {field} is {value:?} in the log, {expected} in the run", disc.name));
            }
        }
    }
    Ok(())
}
