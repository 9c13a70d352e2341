//! A run kept whole, and the grids of time that make runs fit to be compared.

use super::Impacts;
use crate::scene::{LogRates, Preset, Scene};
use crate::trace::{Event, Model, Outcome, RunError, Sample, Sink, SinkError, between, run};

/// Samples that the grid of a reference has at most: five references of 350 bytes a sample stay below 200 MB.
const MOST_SAMPLES: f64 = 1e5;
/// Finest grid; beyond, interpolation is exact to rounding.
const FINEST_HZ: f64 = 1e6;

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
    let mut recording = Recording::default();
    recording.outcome = run(model, scene, &mut recording)?;
    Ok(recording)
}

/// The scene as the reference runs it: the tightest settings, on a dense grid.
pub fn reference(scene: &Scene) -> Scene {
    let integrator = scene.integrator.with_preset(Preset::Reference);
    sampled(Model::Analytic, &Scene { integrator, ..scene.clone() })
}

/// The scene with the samples that a comparison needs. The analytic model is exact between its steps, so a dense grid
/// is read off; of the engine every step is taken, and nothing that is interpolated.
pub fn sampled(model: Model, scene: &Scene) -> Scene {
    let numeric_hz = (MOST_SAMPLES / scene.duration_s).min(FINEST_HZ).max(scene.log.numeric_hz);
    match model {
        Model::Analytic => Scene { log: LogRates { numeric_hz }, ..scene.clone() },
        Model::Engine => steps_only(scene),
    }
}

/// The scene with a sample at every step and at no other time.
pub fn steps_only(scene: &Scene) -> Scene {
    Scene { log: LogRates { numeric_hz: 1.0 / scene.duration_s }, ..scene.clone() }
}
