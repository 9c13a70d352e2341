//! A run as arrays: one for each figure, by the name it has in the table of `replay --csv`.

use super::columns::{Column, columns};
use super::{Event, Layout, Model, Outcome, RunError, Sample, Sink, SinkError, Thinned, run};
use crate::scene::Scene;

/// A sink that keeps samples in columns, and events beside them.
///
/// [`record`] fills one with what a log would hold. By itself it takes every step of the model. The sink of a log takes one
/// too: `log::read_file`.
///
/// Where there is nothing to touch (no object, no joint limit) a column holds NaN.
#[derive(Clone, Debug)]
pub struct Recording {
    columns: Vec<Column>,
    values: Vec<Vec<f64>>,
    events: Vec<Event>,
}

/// The same columns with the same values, and the same events.
impl PartialEq for Recording {
    fn eq(&self, other: &Self) -> bool {
        let names = |of: &'_ Self| of.columns.iter().map(|column| column.name.clone()).collect::<Vec<_>>();
        names(self) == names(other) && self.values == other.values && self.events == other.events
    }
}

impl Recording {
    /// Of samples of this layout.
    pub fn new(layout: &Layout) -> Self {
        let columns = columns(layout);
        Recording { values: vec![Vec::new(); columns.len()], columns, events: Vec::new() }
    }

    /// Of the samples of a scene.
    pub fn of(scene: &Scene) -> Self {
        Recording::new(&Layout::of(&scene.system))
    }

    /// All columns: `time_s` first, the energies last.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// A column by its name, such as `q21_rad` or `distal_normal_n`.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.columns.iter().position(|column| column.name == name)?;
        Some(&self.values[index])
    }

    /// All columns by their names, and the events: for whoever keeps them without a copy.
    pub fn into_parts(self) -> (Vec<(String, Vec<f64>)>, Vec<Event>) {
        let names = self.columns.into_iter().map(|column| column.name);
        (names.zip(self.values).collect(), self.events)
    }

    /// The times of the samples, in s; two may share one, before and after an event.
    pub fn time(&self) -> &[f64] {
        &self.values[0]
    }

    /// The events, in order of time.
    pub fn events(&self) -> &[Event] {
        &self.events
    }
}

impl Sink for Recording {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        for (column, values) in self.columns.iter().zip(&mut self.values) {
            values.push(column.value(sample));
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

/// Runs a scene and keeps the samples that its log would hold.
///
/// # Errors
/// Why the run did not get to its end.
pub fn record(model: Model, scene: &Scene) -> Result<(Outcome, Recording), RunError> {
    let mut thinned = Thinned::new(scene.log.numeric_hz, Recording::of(scene));
    let outcome = run(model, scene, &mut thinned)?;
    thinned.end()?;
    Ok((outcome, thinned.sink))
}
