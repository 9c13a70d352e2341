//! A run kept whole.

use super::{GoOn, Impacts, While};
use crate::scene::Scene;
use crate::trace::{Event, Model, Outcome, RunError, Sample, Sink, SinkError, between, run};

/// Everything a run said, in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// In order of time; two may share one.
    pub samples: Vec<Sample>,
    pub events: Vec<Event>,
    pub impacts: Impacts,
    pub outcome: Outcome,
}

impl Sink for Recording {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.impacts.sample(sample)?;
        self.samples.push(*sample);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.impacts.event(event)?;
        self.events.push(*event);
        Ok(())
    }
}

impl Recording {
    /// The state at a time, between the samples around it; `cursor` is where the last search ended, and makes going
    /// through in order cheap. `None` without samples.
    pub fn at(&self, time_s: f64, cursor: &mut usize) -> Option<Sample> {
        let last = self.samples.len().checked_sub(1)?;
        *cursor = (*cursor).min(last);
        if self.samples[*cursor].time_s > time_s {
            *cursor = self.samples.partition_point(|sample| sample.time_s <= time_s).saturating_sub(1);
        }
        while *cursor < last && self.samples[*cursor + 1].time_s <= time_s {
            *cursor += 1;
        }
        let next = self.samples[(*cursor + 1).min(last)];
        Some(between(&self.samples[*cursor], &next, time_s.min(next.time_s)))
    }
}

/// Runs the scene and keeps all of it.
pub fn record(model: Model, scene: &Scene) -> Result<Recording, RunError> {
    record_while(model, scene, &|| true)
}

/// Runs the scene as long as it may and keeps all of it.
pub fn record_while(model: Model, scene: &Scene, go_on: GoOn) -> Result<Recording, RunError> {
    let mut recording = Recording::default();
    recording.outcome = run(model, scene, &mut While { sink: &mut recording, go_on })?;
    Ok(recording)
}
