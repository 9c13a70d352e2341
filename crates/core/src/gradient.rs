//! Derivatives of a run with respect to parameters of its scene: of its last sample, of its events, and of the time to
//! stability. Where one does not exist, or is not computed, there is a reason.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::criteria::{Criteria, EPSILON_RAD, RunCriteriaTracker, static_grasp};
use crate::scene::Scene;
use crate::trace::tangent::{TangentEvent, TangentParameter, TangentRun, run_tangent};
use crate::trace::{
    Channel, Event, EventKind, KeepRunning, Model, RequiredData, RunError, Sample, Schema, Sink, SinkError, run,
};

/// A numeric parameter of a scene.
pub struct Parameter<'a> {
    pub name: String,
    /// SI unit; empty for a plain number.
    pub unit: &'static str,
    pub value: f64,
    /// Returns the scene at a value of the parameter.
    pub scene_at: Box<dyn Fn(f64) -> Result<Scene, String> + 'a>,
}

/// Derivatives of a run by one parameter, by column of a recording, in SI units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gradient {
    pub unit: &'static str,
    pub value: f64,
    /// Derivatives of the last sample.
    pub end: Derivatives,
    /// Derivatives of contact events, in the order of the run.
    pub events: Vec<EventGradient>,
    /// Derivative of the time to stability; `None` if the run has none.
    pub tts_s: Option<Derivative>,
}

/// Derivatives by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Derivatives {
    pub values: BTreeMap<String, f64>,
    /// Estimated errors: the change of the derivative at a ten times larger tolerance.
    pub errors: BTreeMap<String, f64>,
    /// Why there are no derivatives.
    pub reason: Option<String>,
}

/// A derivative with its estimated error, or the reason why there is none.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Derivative {
    pub value: Option<f64>,
    pub error: Option<f64>,
    pub reason: Option<String>,
}

/// Derivatives of an event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventGradient {
    pub time_s: f64,
    pub contact: String,
    pub kind: &'static str,
    /// Derivative of its time.
    pub time: Derivative,
    /// Derivatives of the sample at the event, whose time moves with it.
    pub state: Derivatives,
}

/// Relative tolerance of the runs with derivatives; that of the second one, for the error estimate, is ten times larger.
const RTOL: f64 = 1e-10;
/// Ratio of the tolerances of the two runs.
const COARSE: f64 = 10.0;
/// Largest relative change of a parameter in difference quotients.
const MAX_CHANGE: f64 = 1e-4;
/// Relative change of a parameter that must not change the events of the run or its class.
const NEIGHBOURHOOD: f64 = 1e-6;
/// Relative difference of a derivative and a difference quotient that counts as a contradiction, beyond the error of the
/// quotient: its error in units of the largest value of the quantity along the run per value of the parameter. A quantity
/// that has come to rest is 0 up to such errors.
const DIFFERENCE_TOLERANCE: f64 = 0.05;
const DIFFERENCE_NOISE: f64 = 2e-3;
/// Error of a quantity in the quotient, in changes of the quantity at a ten times larger tolerance. Where the quantity has
/// come to rest, both are rounding errors of about the same size.
const NOISE_MARGIN: f64 = 3.0;
/// Rounding error of a quantity, relative to the largest quantity of its unit along the run, in the same unit: the speed of
/// the centre of a pin on the ground is 0 up to it.
const ROUNDING: f64 = 1e-6;
/// A derivative is 0 if the change by the whole value of the parameter is below this fraction of the largest quantity of its
/// unit along the run: it is rounding error.
const ZERO_CHANGE: f64 = 1e-15;
/// A derivative is also 0 if that change is below this fraction and the error of the derivative is as large as itself: what
/// has come to rest depends on no parameter. It contradicts no difference of the same size if it is below its error with
/// this margin.
const SMALL_CHANGE: f64 = 1e-6;
const NOISE_ERRORS: f64 = 10.0;
/// Times closer than this are equal, s.
const SAME_TIME_S: f64 = 1e-11;
/// Difference of an angle from the tolerance of its position that counts as its crossing, rad.
const SAME_ANGLE_RAD: f64 = 1e-7;

/// Simulates a scene with the analytic model, and returns its derivatives by each parameter.
///
/// # Errors
/// Returns an error if the run does not complete.
pub fn gradient(
    scene: &Scene,
    parameters: &[Parameter<'_>],
    keep_running: KeepRunning<'_>,
) -> Result<Vec<Gradient>, RunError> {
    let fine = at_tolerance(scene, 1.0);
    let base = observe(&fine, keep_running)?;
    let tts_s = base.criteria.as_ref().map(|criteria| criteria.tts_s).unwrap_or_default();
    let times: Vec<f64> = tts_s.into_iter().filter(|tts_s| *tts_s > 0.0).collect();
    let runs = [1.0, COARSE].map(|factor| {
        let scenes = parameters
            .iter()
            .map(|parameter| move |value: f64| (parameter.scene_at)(value).map(|scene| at_tolerance(&scene, factor)));
        let scenes: Vec<_> = scenes.collect();
        let tangents = parameters.iter().zip(&scenes);
        let tangents = tangents.map(|(parameter, scene_at)| TangentParameter {
            scene_at,
            value: parameter.value,
            step: MAX_CHANGE * parameter.scale(),
        });
        let tangents: Vec<TangentParameter<'_>> = tangents.collect();
        let mut sink = Observation { criteria: None, events: Vec::new(), largest: Vec::new(), keep_running };
        run_tangent(&at_tolerance(scene, factor), &tangents, &times, &mut sink)
    });
    let [run, coarse] = runs;
    let (run, coarse) = (run?, coarse?);
    let schema = Schema::from_scene(scene);
    let context = Context { scene: &fine, schema: &schema, base: &base, run: &run, coarse: &coarse, tts_s };
    let gradients = parameters.iter().enumerate().map(|(index, parameter)| {
        let neighbours = parameter.neighbours(&base, &schema, keep_running);
        let changed = match &neighbours {
            Ok(samples) => context.contradiction(index, parameter, samples),
            Err(reason) => Some(reason.clone()),
        };
        context.gradient(index, parameter, changed)
    });
    Ok(gradients.collect())
}

/// The scene at a multiple of the tolerance of runs with derivatives, or of its own if that is smaller.
fn at_tolerance(scene: &Scene, factor: f64) -> Scene {
    let rtol = factor * scene.integrator.rtol.min(RTOL);
    Scene { integrator: scene.integrator.with_rtol(rtol), ..scene.clone() }
}

/// Stores events and the largest magnitudes of all numbers, and computes criteria.
struct Observation<'a> {
    criteria: Option<RunCriteriaTracker>,
    events: Vec<Event>,
    largest: Vec<f64>,
    keep_running: KeepRunning<'a>,
}

impl Sink for Observation<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.largest.resize(sample.values().len(), 0.0);
        for (largest, value) in self.largest.iter_mut().zip(sample.values()).filter(|(_, value)| value.is_finite()) {
            *largest = largest.max(value.abs());
        }
        self.criteria.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        self.criteria.event(event)
    }

    fn required_data(&self) -> RequiredData {
        let of_criteria = self.criteria.as_ref().map_or(RequiredData::NONE, RunCriteriaTracker::required_data);
        RequiredData { passive: true, ..of_criteria }
    }

    fn should_continue(&self) -> bool {
        (self.keep_running)()
    }
}

/// What is compared of two runs.
struct Observed {
    events: Vec<Event>,
    /// Criteria of a finger.
    criteria: Option<Criteria>,
    /// Largest magnitude of each number of the samples.
    largest: Vec<f64>,
    last: Sample,
}

fn observe(scene: &Scene, keep_running: KeepRunning<'_>) -> Result<Observed, RunError> {
    let criteria = Some(RunCriteriaTracker::for_scene(scene));
    let mut observation = Observation { criteria, events: Vec::new(), largest: Vec::new(), keep_running };
    let outcome = run(Model::Analytic, scene, &mut observation)?;
    let Observation { criteria, events, largest, .. } = observation;
    let criteria = criteria.and_then(|tracker| tracker.finish(true).criteria);
    Ok(Observed { events, criteria, largest, last: outcome.last })
}

/// Number of events of each contact and kind.
fn counts(events: &[Event]) -> BTreeMap<(usize, &'static str), usize> {
    let mut counts = BTreeMap::new();
    events.iter().for_each(|event| *counts.entry((event.contact, event.kind.name())).or_default() += 1);
    counts
}

impl Parameter<'_> {
    /// Size against which changes of the parameter are measured.
    fn scale(&self) -> f64 {
        if self.value == 0.0 { 1.0 } else { self.value.abs() }
    }

    /// Returns the last samples of the runs at two values beside the parameter.
    ///
    /// # Errors
    /// Returns a description if their events or class are others.
    fn neighbours(
        &self,
        base: &Observed,
        schema: &Schema,
        keep_running: KeepRunning<'_>,
    ) -> Result<Vec<Sample>, String> {
        let change = NEIGHBOURHOOD * self.scale();
        let neighbour = |change: f64| {
            let value = self.value + change;
            let scene = match (self.scene_at)(value) {
                Ok(scene) => at_tolerance(&scene, 1.0),
                Err(error) => return Err(format!("there is no scene at {value}: {error}")),
            };
            let moved = observe(&scene, keep_running).map_err(|error| format!("the run at {value} fails: {error}"))?;
            let [before, after] = [base, &moved].map(|run| counts(&run.events));
            let key = |event: &Event| (event.contact, event.kind.name());
            let differs = |event: &&Event| before.get(&key(event)) != after.get(&key(event));
            let first = |events: &[Event]| events.iter().find(differs).copied();
            let found = [first(&base.events), first(&moved.events)].into_iter().flatten();
            if let Some(event) = found.min_by(|a, b| a.time_s.total_cmp(&b.time_s)) {
                let name = schema.contacts.get(event.contact).map_or("", |contact| contact.name.as_str());
                let [n, m] = [&before, &after].map(|counts| counts.get(&key(&event)).copied().unwrap_or(0));
                let (kind, time_s) = (event.kind.name(), event.time_s);
                return Err(format!(
                    "the events change: the contact {name} has {n} events of kind {kind}, but {m} at {value}; the first is at \
                     {time_s} s"
                ));
            }
            let [class, moved_class] = [base, &moved].map(|run| run.criteria.as_ref().map(|criteria| criteria.class));
            match class == moved_class {
                true => Ok(moved.last),
                false => Err(format!("the class of the grasp changes between the value and {value}")),
            }
        };
        [-change, change].into_iter().map(neighbour).collect()
    }
}

/// Whether a change by the whole value of a parameter, with its error, counts as 0 for this largest quantity of its unit.
fn is_zero(change: f64, error: f64, largest: f64) -> bool {
    change.abs() <= ZERO_CHANGE * largest || change.abs() <= SMALL_CHANGE * largest && change.abs() <= error
}

/// What the derivatives by all parameters have in common.
struct Context<'a> {
    scene: &'a Scene,
    schema: &'a Schema,
    base: &'a Observed,
    run: &'a TangentRun,
    coarse: &'a TangentRun,
    tts_s: Option<f64>,
}

impl Context<'_> {
    /// Describes a derivative of a coordinate or a rate that contradicts the difference of two runs.
    fn contradiction(&self, index: usize, parameter: &Parameter<'_>, samples: &[Sample]) -> Option<String> {
        let [fine, coarse] = [self.run, self.coarse].map(|run| run.end[index].as_ref());
        let (Ok(derivatives), [below, above]) = (fine, samples) else { return None };
        let error = |channel: usize| coarse.map_or(0.0, |coarse| (coarse[channel] - derivatives[channel]).abs());
        let is_motion = |channel: &Channel| ["rad", "m", "rad/s", "m/s"].contains(&channel.unit);
        let channels: Vec<Channel> = self.schema.channels().into_iter().filter(is_motion).collect();
        channels.iter().find_map(|channel| {
            let number = channel.index()?;
            let of_unit = self.largest_of_unit(channel.unit);
            let derivative = derivatives[number];
            let largest = self.largest(channel).max(ROUNDING * of_unit);
            let scale = largest / parameter.scale();
            let difference = (channel.value(above) - channel.value(below)) / (2.0 * NEIGHBOURHOOD * parameter.scale());
            let change = [derivative, error(number), difference].map(|value| value * parameter.scale());
            if is_zero(change[0], NOISE_ERRORS * change[1], of_unit) && change[2].abs() <= SMALL_CHANGE * of_unit {
                return None;
            }
            let error = (channel.value(&self.run.outcome.last) - channel.value(&self.coarse.outcome.last)).abs();
            let noise = NOISE_MARGIN * error / (NEIGHBOURHOOD * parameter.scale());
            let allowed =
                DIFFERENCE_TOLERANCE * (derivative.abs() + difference.abs()) + DIFFERENCE_NOISE * scale + noise;
            let name = &channel.name;
            ((derivative - difference).abs() > allowed)
                .then(|| format!("the derivative of {name}, {derivative:e}, contradicts a difference, {difference:e}"))
        })
    }

    /// Largest magnitude of a channel along the run.
    fn largest(&self, channel: &Channel) -> f64 {
        channel.index().map_or(0.0, |index| self.base.largest[index])
    }

    /// Largest magnitude of all channels of a unit along the run. Moments may all be 0 by geometry; their scale is then that of
    /// the forces and lengths that they are computed from.
    fn largest_of_unit(&self, unit: &str) -> f64 {
        let of_unit = |unit: &str| {
            let channels = self.schema.channels().into_iter().filter(|channel| channel.unit == unit);
            channels.fold(0.0, |largest: f64, channel| largest.max(self.largest(&channel)))
        };
        match unit {
            "N·m" => of_unit("N·m").max(of_unit("N") * of_unit("m")),
            _ => of_unit(unit),
        }
    }

    fn gradient(&self, index: usize, parameter: &Parameter<'_>, changed: Option<String>) -> Gradient {
        let Self { run, coarse, .. } = self;
        let end = match &changed {
            Some(reason) => Derivatives { reason: Some(reason.clone()), ..Derivatives::default() },
            None => {
                let [fine, coarse] = [run, coarse].map(|run| run.end[index].as_ref());
                self.derivatives(&run.outcome.last, parameter, [fine, coarse])
            }
        };
        let has_equal_events = run.events.len() == coarse.events.len()
            && run
                .events
                .iter()
                .zip(&coarse.events)
                .all(|(a, b)| (a.event.contact, a.event.kind) == (b.event.contact, b.event.kind));
        let event = |(position, event): (usize, &TangentEvent)| {
            let coarse = coarse.events.get(position).filter(|_| has_equal_events);
            self.event_gradient((index, parameter), event, coarse)
        };
        Gradient {
            unit: parameter.unit,
            value: parameter.value,
            end,
            events: run.events.iter().enumerate().map(event).collect(),
            tts_s: self.tts_s.map(|tts_s| match changed {
                Some(reason) => Derivative { reason: Some(reason), ..Derivative::default() },
                None => self.time_to_stability(index, parameter, tts_s),
            }),
        }
    }

    /// Derivatives by column; the error is the difference from those of the coarse run.
    fn derivatives(
        &self,
        sample: &Sample,
        parameter: &Parameter<'_>,
        [fine, coarse]: [Result<&Vec<f64>, &String>; 2],
    ) -> Derivatives {
        let fine = match fine {
            Ok(fine) => fine,
            Err(reason) => return Derivatives { reason: Some(reason.clone()), ..Derivatives::default() },
        };
        let mut derivatives = Derivatives::default();
        let exists = |channel: &Channel| channel.value(sample).is_finite();
        let mut scales: BTreeMap<&str, f64> = BTreeMap::new();
        for channel in self.schema.channels().into_iter().filter(exists) {
            let Some(index) = channel.index() else { continue };
            let error = coarse.map_or(f64::NAN, |coarse| (coarse[index] - fine[index]).abs());
            let scale = *scales.entry(channel.unit).or_insert_with(|| self.largest_of_unit(channel.unit));
            derivatives.errors.insert(channel.name.clone(), error);
            let is_zero = is_zero(fine[index] * parameter.scale(), error * parameter.scale(), scale);
            derivatives.values.insert(channel.name, if is_zero { 0.0 } else { fine[index] });
        }
        derivatives
    }

    fn event_gradient(
        &self,
        (index, parameter): (usize, &Parameter<'_>),
        event: &TangentEvent,
        coarse: Option<&TangentEvent>,
    ) -> EventGradient {
        let TangentEvent { event, sample, derivatives } = event;
        let missing = "the events of the run change with its tolerance".to_string();
        let coarse = coarse.map_or(Err(&missing), |event| event.derivatives[index].as_ref());
        let fine = derivatives[index].as_ref();
        let time = match fine {
            Ok((value, _)) => Derivative {
                value: Some(*value),
                error: coarse.ok().map(|(coarse, _)| (coarse - value).abs()),
                reason: None,
            },
            Err(reason) => Derivative { reason: Some(reason.clone()), ..Derivative::default() },
        };
        EventGradient {
            time_s: event.time_s,
            contact: self.schema.contacts.get(event.contact).map_or_else(String::new, |contact| contact.name.clone()),
            kind: event.kind.name(),
            time,
            state: self.derivatives(sample, parameter, [fine, coarse].map(|found| found.map(|(_, state)| state))),
        }
    }

    /// Derivative of the time to stability: of the event at which the last contact closes, or of the time at which an
    /// angle reaches its tolerance.
    fn time_to_stability(&self, index: usize, parameter: &Parameter<'_>, tts_s: f64) -> Derivative {
        let of_run = |run: &TangentRun| -> Result<f64, String> {
            let is_event = |event: &&TangentEvent| (event.event.time_s - tts_s).abs() <= SAME_TIME_S;
            let closes = |event: &&TangentEvent| event.event.kind != EventKind::LiftOff;
            if let Some(event) = run.events.iter().find(|event| is_event(event) && closes(event)) {
                return event.derivatives[index].as_ref().map(|(time, _)| *time).map_err(Clone::clone);
            }
            let (sample, derivatives) = run.at_times.first().ok_or("the run is stable from its start")?;
            let derivatives = derivatives[index].as_ref().map_err(Clone::clone)?;
            let finger = sample.finger(0);
            let target = final_angles(self.scene)?;
            let [below, above] = [-1.0, 1.0].map(|side| {
                (parameter.scene_at)(parameter.value + side * MAX_CHANGE * parameter.scale())
                    .and_then(|scene| final_angles(&scene))
            });
            let (below, above) = (below?, above?);
            let angles =
                [(finger.q11_rad, finger.qd11_rad_s, "q11_rad"), (finger.q21_rad, finger.qd21_rad_s, "q21_rad")];
            for (joint, (angle, rate, column)) in angles.into_iter().enumerate() {
                if ((angle - target[joint]).abs() - EPSILON_RAD).abs() > SAME_ANGLE_RAD {
                    continue;
                }
                let channels = self.schema.channels();
                let channel = channels.iter().find(|channel| channel.name == column).and_then(Channel::index);
                let moved = channel.map_or(f64::NAN, |channel| derivatives[channel]);
                let target_moved = (above[joint] - below[joint]) / (2.0 * MAX_CHANGE * parameter.scale());
                return Ok((target_moved - moved) / rate);
            }
            Err(format!(
                "the time to stability, {tts_s} s, is neither an event nor the time at which an angle is in position"
            ))
        };
        match of_run(self.run) {
            Ok(value) => Derivative {
                value: Some(value),
                error: of_run(self.coarse).ok().map(|coarse| (coarse - value).abs()),
                reason: None,
            },
            Err(reason) => Derivative { reason: Some(reason), ..Derivative::default() },
        }
    }
}

/// Final angles of a finger on its object.
fn final_angles(scene: &Scene) -> Result<[f64; 2], String> {
    let object = scene.object().ok_or("the scene has no object")?;
    let grasp = static_grasp(scene, object).map_err(|error| error.to_string())?;
    let angles = grasp.final_angles();
    Ok([angles.q11_rad, angles.q21_rad])
}
