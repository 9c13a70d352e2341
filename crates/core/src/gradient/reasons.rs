//! Reasons for which a derivative is refused, or is zero: events that change beside a parameter, differences of runs that
//! contradict it, and rounding.

use std::collections::BTreeMap;

use super::derivatives::Parameter;
use super::observed::{Observed, at_tolerance, observe};
use super::run::TangentRun;
use crate::scene::Scene;
use crate::trace::{Channel, Event, KeepRunning, Sample, Schema};

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

/// What the derivatives by all parameters have in common.
pub(super) struct Context<'a> {
    pub scene: &'a Scene,
    pub schema: &'a Schema,
    pub base: &'a Observed,
    pub run: &'a TangentRun,
    pub coarse: &'a TangentRun,
    pub tts_s: Option<f64>,
}

/// Returns the last samples of the runs at two values beside the parameter.
///
/// # Errors
/// Returns a description if their events or class are others.
pub(super) fn samples_beside(
    parameter: &Parameter<'_>,
    base: &Observed,
    schema: &Schema,
    keep_running: KeepRunning<'_>,
) -> Result<Vec<Sample>, String> {
    let change = NEIGHBOURHOOD * parameter.scale();
    let neighbour = |change: f64| {
        let value = parameter.value + change;
        let scene = match (parameter.scene_at)(value) {
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

/// Number of events of each contact and kind.
fn counts(events: &[Event]) -> BTreeMap<(usize, &'static str), usize> {
    let mut counts = BTreeMap::new();
    events.iter().for_each(|event| *counts.entry((event.contact, event.kind.name())).or_default() += 1);
    counts
}

/// Whether a change by the whole value of a parameter, with its error, counts as 0 for this largest quantity of its unit.
pub(super) fn is_zero(change: f64, error: f64, largest: f64) -> bool {
    change.abs() <= ZERO_CHANGE * largest || change.abs() <= SMALL_CHANGE * largest && change.abs() <= error
}

impl Context<'_> {
    /// Describes how a derivative of a coordinate or a rate contradicts the difference of two runs; `None` if no
    /// derivative does.
    pub fn contradiction(&self, index: usize, parameter: &Parameter<'_>, samples: &[Sample]) -> Option<String> {
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

    /// Largest magnitude, along the run, of all channels with a unit. Moments may all be 0 for geometric reasons; their
    /// scale is then computed from the forces and lengths.
    pub fn largest_of_unit(&self, unit: &str) -> f64 {
        let of_unit = |unit: &str| {
            let channels = self.schema.channels().into_iter().filter(|channel| channel.unit == unit);
            channels.fold(0.0, |largest: f64, channel| largest.max(self.largest(&channel)))
        };
        match unit {
            "N·m" => of_unit("N·m").max(of_unit("N") * of_unit("m")),
            _ => of_unit(unit),
        }
    }
}
