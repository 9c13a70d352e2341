//! A run as arrays, one per column of the table written by `replay --csv`.

use super::{Channel, ContactName, Decimated, Event, Model, Outcome, RunError, Sample, Schema, Sink, SinkError, run};
use crate::scene::Scene;

/// Number of samples for which a recording has memory from the start: more than those of a typical closing motion.
const INITIAL_CAPACITY: usize = 512;

/// A sink that stores samples as columns, and events.
///
/// [`record`] fills it with the samples that a log contains. If it is used directly as a sink, it stores every step of
/// the model; `log::read_file` fills it from a log.
#[derive(Clone, Debug)]
pub struct Recording {
    channels: Vec<Channel>,
    contacts: Vec<ContactName>,
    values: Vec<Vec<f64>>,
    events: Vec<Event>,
}

/// Two recordings are equal if columns, values and events are equal.
impl PartialEq for Recording {
    fn eq(&self, other: &Self) -> bool {
        self.channels == other.channels && self.values == other.values && self.events == other.events
    }
}

impl Recording {
    /// Creates an empty recording for samples of this schema.
    pub fn new(schema: &Schema) -> Self {
        let channels = schema.channels();
        let values = channels.iter().map(|_| Vec::with_capacity(INITIAL_CAPACITY)).collect();
        Recording { channels, contacts: schema.contacts.clone(), values, events: Vec::new() }
    }

    /// Creates an empty recording for the samples of a scene.
    pub fn for_scene(scene: &Scene) -> Self {
        Recording::new(&Schema::from_scene(scene))
    }

    /// Returns the channels of the columns: `time_s` is first, the energies are last.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Returns a column by its name, such as `q21_rad` or `distal_normal_n`.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.channels.iter().position(|channel| channel.name == name)?;
        Some(&self.values[index])
    }

    /// Returns all channels with their numbers, and the events, without copying.
    pub fn into_parts(self) -> (Vec<(Channel, Vec<f64>)>, Vec<Event>) {
        (self.channels.into_iter().zip(self.values).collect(), self.events)
    }

    /// Returns the times of the samples, in s. Two samples can have the same time: one before and one after an event.
    pub fn time(&self) -> &[f64] {
        &self.values[0]
    }

    /// Returns the contacts of the samples; [`Event::contact`] is an index among them.
    pub fn contacts(&self) -> &[ContactName] {
        &self.contacts
    }

    /// Returns the events, in order of time.
    pub fn events(&self) -> &[Event] {
        &self.events
    }
}

impl Sink for Recording {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        for (channel, values) in self.channels.iter().zip(&mut self.values) {
            values.push(channel.value(sample));
        }
        Ok(())
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        Ok(())
    }
}

/// Runs a scene and stores the samples that its log would contain.
///
/// # Errors
/// Returns an error if the run did not complete.
pub fn record(model: Model, scene: &Scene) -> Result<(Outcome, Recording), RunError> {
    let mut decimated = Decimated::new(scene.log.numeric_hz, Recording::for_scene(scene));
    let outcome = run(model, scene, &mut decimated)?;
    decimated.end()?;
    Ok((outcome, decimated.sink))
}
