//! A run as arrays: one for each figure, by the name it has in the table of `replay --csv`.

use super::bodies::{BodiesEvent, BodiesOutcome, BodiesRunError, run_bodies};
use super::columns::{of_discs, of_finger};
use super::{Event, Instant, Model, Outcome, RunError, Sink, SinkError, Thinned, run};
use crate::scene::{BodiesScene, Scene};

/// A sink that keeps samples in columns, and events beside them; `E` is [`Event`] of a finger, [`BodiesEvent`] of discs.
///
/// [`record`] and [`record_bodies`] fill one with what a log would hold. By itself it takes every step of the model. The sink
/// of a log takes one too: `log::read_file`, and for discs `log::read_any_file`.
///
/// Where there is nothing to touch (no object, no joint limit) a column holds NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording<E = Event> {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
    events: Vec<E>,
}

impl Recording {
    /// Of a finger.
    pub fn finger() -> Self {
        Recording::new(of_finger())
    }
}

impl Recording<BodiesEvent> {
    /// Of the discs of a scene.
    pub fn discs(scene: &BodiesScene) -> Self {
        let discs: Vec<_> = scene.discs.iter().map(|disc| disc.name.clone()).collect();
        let pairs: Vec<_> = scene.pairs().into_iter().map(|pair| scene.pair_name(pair)).collect();
        Recording::named(&discs, &pairs)
    }

    /// Of discs and pairs of these names.
    pub fn named(discs: &[String], pairs: &[String]) -> Self {
        Recording::new(of_discs(discs, pairs))
    }
}

impl<E> Recording<E> {
    fn new(names: Vec<String>) -> Self {
        Recording { columns: vec![Vec::new(); names.len()], names, events: Vec::new() }
    }

    /// The names of all columns: `time_s` first, the energies last.
    pub fn columns(&self) -> &[String] {
        &self.names
    }

    /// A column by its name, such as `q21_rad` or `distal_normal_n`.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|each| each == name)?;
        Some(&self.columns[index])
    }

    /// The times of the samples, in s; two may share one, before and after an event.
    pub fn time(&self) -> &[f64] {
        &self.columns[0]
    }

    /// The events, in order of time.
    pub fn events(&self) -> &[E] {
        &self.events
    }

    fn push(&mut self, values: impl Iterator<Item = f64>) {
        for (column, value) in self.columns.iter_mut().zip(values) {
            column.push(value);
        }
    }
}

impl<S: Instant> Sink<S> for Recording<S::Event> {
    fn sample(&mut self, sample: &S) -> Result<(), SinkError> {
        self.push(sample.values());
        Ok(())
    }

    fn extreme(&mut self, sample: &S) -> Result<(), SinkError> {
        self.sample(sample)
    }

    fn event(&mut self, event: &S::Event) -> Result<(), SinkError> {
        self.events.push(*event);
        Ok(())
    }
}

/// Runs a scene and keeps the samples that its log would hold.
///
/// # Errors
/// Why the run did not get to its end.
pub fn record(model: Model, scene: &Scene) -> Result<(Outcome, Recording), RunError> {
    let mut thinned = Thinned::new(scene.log.numeric_hz, Recording::finger());
    let outcome = run(model, scene, &mut thinned)?;
    thinned.end()?;
    Ok((outcome, thinned.sink))
}

/// The same of discs.
///
/// # Errors
/// Why the run did not get to its end.
pub fn record_bodies(
    model: Model,
    scene: &BodiesScene,
) -> Result<(BodiesOutcome, Recording<BodiesEvent>), BodiesRunError> {
    let mut thinned = Thinned::new(scene.log.numeric_hz, Recording::discs(scene));
    let outcome = run_bodies(model, scene, &mut thinned)?;
    thinned.end()?;
    Ok((outcome, thinned.sink))
}
