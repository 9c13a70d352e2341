//! The derivatives of a run by one parameter, with their errors or the reasons why there are none.

use std::collections::BTreeMap;

use super::derivatives::{Derivative, Derivatives, EventGradient, Gradient, Parameter};
use super::reasons::{Context, is_zero};
use super::run::{TangentEvent, TangentRun};
use crate::criteria::{EPSILON_RAD, static_grasp};
use crate::scene::Scene;
use crate::trace::{Channel, EventKind, Sample};

/// Times closer than this are equal, s.
const SAME_TIME_S: f64 = 1e-11;
/// Difference of an angle from the tolerance of its position that counts as its crossing, rad.
const SAME_ANGLE_RAD: f64 = 1e-7;

impl Context<'_> {
    pub fn gradient(&self, index: usize, parameter: &Parameter<'_>, changed: Option<String>) -> Gradient {
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
                (parameter.scene_at)(parameter.value + side * parameter.largest_change())
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
                let target_moved = (above[joint] - below[joint]) / (2.0 * parameter.largest_change());
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
