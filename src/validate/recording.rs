//! A run stored in memory, with the normal impulse of every impact of two surfaces.

use crate::criteria::{RunCriteria, RunCriteriaTracker};
use crate::law::spring_force;
use crate::scene::Scene;
use crate::trace::{Cancellable, Event, EventKind, KeepRunning, Model, Outcome, RunError, Sample};
use crate::trace::{RequiredData, Sink, SinkError, interpolate, run};

/// All samples, events and results of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Samples in order of time. Two samples may have the same time.
    pub samples: Vec<Sample>,
    pub events: Vec<Event>,
    pub impacts: Impacts,
    pub outcome: Outcome,
    /// Criteria of the run.
    pub run_criteria: Option<RunCriteria>,
    /// For each contact of a mechanism, its spring force at its maximum penetration, N.
    pub peak_spring_n: Vec<f64>,
}

impl Sink for Recording {
    fn required_data(&self) -> RequiredData {
        RequiredData::EVALUATION
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.impacts.sample(sample)?;
        self.samples.push(sample.clone());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.impacts.event(event)?;
        self.events.push(*event);
        Ok(())
    }
}

impl Recording {
    /// Returns the state at a time, interpolated between the two adjacent samples; `None` without samples. `cursor`
    /// stores the index of the previous search, which makes access in order of time fast.
    pub fn interpolate(&self, time_s: f64, cursor: &mut usize) -> Option<Sample> {
        let last = self.samples.len().checked_sub(1)?;
        *cursor = (*cursor).min(last);
        if self.samples[*cursor].time_s > time_s {
            *cursor = self.samples.partition_point(|sample| sample.time_s <= time_s).saturating_sub(1);
        }
        while *cursor < last && self.samples[*cursor + 1].time_s <= time_s {
            *cursor += 1;
        }
        let (from, to) = (&self.samples[*cursor], &self.samples[(*cursor + 1).min(last)]);
        Some(interpolate(from, to, time_s.min(to.time_s)))
    }
}

/// Runs the scene and records it.
pub fn record(model: Model, scene: &Scene) -> Result<Recording, RunError> {
    record_cancellable(model, scene, &|| true)
}

/// Runs the scene until it ends or `keep_running` returns false, and records it.
pub(crate) fn record_cancellable(
    model: Model,
    scene: &Scene,
    keep_running: KeepRunning,
) -> Result<Recording, RunError> {
    let mut sink = JudgedRecording(Recording::default(), RunCriteriaTracker::for_scene(scene));
    let outcome = run(model, scene, &mut Cancellable { sink: &mut sink, keep_running })?;
    let JudgedRecording(mut recording, criteria) = sink;
    recording.run_criteria = Some(criteria.finish(true));
    if let Some(mechanism) = &scene.mechanism {
        let points = mechanism.point_contacts();
        let contacts = points.iter().map(|point| &mechanism.contacts[point.pair].law).zip(&outcome.contacts);
        let peaks = contacts.map(|(law, contact)| spring_force(&law.normal, contact.max_penetration_m));
        recording.peak_spring_n = peaks.collect();
    }
    recording.outcome = outcome;
    Ok(recording)
}

/// Records a run and evaluates its criteria.
struct JudgedRecording(Recording, RunCriteriaTracker);

impl Sink for JudgedRecording {
    fn required_data(&self) -> RequiredData {
        RequiredData::EVALUATION
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.1.sample(sample)?;
        self.0.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.1.event(event)?;
        self.0.event(event)
    }
}

/// Time after the touch-down over which the impulse of a lasting contact is measured, s. The impact force of these
/// grippers has decayed after about 10 µs. Over 20 µs, the impulse of the motor and the spring is below a hundredth of
/// that of the impact.
pub const IMPACT_S: f64 = 20e-6;

/// One touch-down, and the normal impulse after it.
///
/// The step that contains the touch-down does not resolve the impact. The impulse within it is therefore taken as
/// instantaneous, minus the contribution of the normal force at the end of the step. In later steps, the impulse is
/// interpolated with the normal forces as slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Index among the contacts of a sample.
    pub contact: usize,
    /// Time of the touch-down, s.
    pub time_s: f64,
    /// Cumulative normal impulse at the last sample before the touch-down; the contact force is zero from then on until
    /// the touch-down.
    before_n_s: f64,
    /// Cumulative normal impulse [`IMPACT_S`] after the touch-down, or at the latest sample if that is earlier.
    after_n_s: f64,
    /// Whether there is a sample after the touch-down.
    has_sample: bool,
    /// Whether [`IMPACT_S`] have passed since the touch-down.
    is_complete: bool,
    /// Time of the lift-off that ends the contact, and the normal impulse of the contact; `None` while it lasts.
    lift_off: Option<(f64, f64)>,
}

impl Impact {
    /// Normal impulse up to the lift-off, N·s. For a lasting contact, it is the impulse within [`IMPACT_S`] after the
    /// touch-down.
    pub fn impulse_n_s(&self) -> f64 {
        self.lift_off.map_or(self.after_n_s - self.before_n_s, |(_, impulse_n_s)| impulse_n_s)
    }

    /// End of the interval over which [`Impact::impulse_n_s`] is measured, s.
    pub fn end_s(&self) -> f64 {
        self.lift_off.map_or(self.time_s + IMPACT_S, |(end_s, _)| end_s)
    }

    /// Updates the impulse up to the sample `to`, which follows `from`.
    fn update(&mut self, from: &Sample, to: &Sample) {
        let end_s = self.time_s + IMPACT_S;
        if self.is_complete || to.time_s <= self.time_s {
            return;
        }
        let contact = to.contact(self.contact);
        self.after_n_s = match self.has_sample {
            true => impulse(from, to, self.contact, end_s),
            false => (contact.impulse_n_s - contact.normal_n * (to.time_s - end_s).max(0.0)).max(self.before_n_s),
        };
        (self.has_sample, self.is_complete) = (true, to.time_s >= end_s);
    }
}

/// A [`Sink`] that measures impacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Impacts {
    /// Impacts in the order of their touch-downs.
    pub all: Vec<Impact>,
    last: Option<Sample>,
    /// Impacts before this index are complete.
    first_open: usize,
}

impl Impacts {
    /// Iterates over the impacts of one contact.
    pub(crate) fn of_contact(&self, contact: usize) -> impl Iterator<Item = &Impact> {
        self.all.iter().filter(move |impact| impact.contact == contact)
    }
}

impl Sink for Impacts {
    fn required_data(&self) -> RequiredData {
        RequiredData::EVALUATION
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let from = self.last.as_ref().unwrap_or(sample);
        self.all[self.first_open..].iter_mut().for_each(|impact| impact.update(from, sample));
        while self.all.get(self.first_open).is_some_and(|impact| impact.is_complete) {
            self.first_open += 1;
        }
        match &mut self.last {
            Some(last) => last.clone_from(sample),
            None => self.last = Some(sample.clone()),
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let contact = event.contact;
        let is_stop = self.last.as_ref().is_some_and(|last| last.is_stop(contact));
        if event.kind == EventKind::TouchDown && !is_stop {
            let before_n_s = self.last.as_ref().map_or(0.0, |last| last.contact(contact).impulse_n_s);
            let (after_n_s, time_s, lift_off) = (before_n_s, event.time_s, None);
            self.all.push(Impact {
                contact,
                time_s,
                before_n_s,
                after_n_s,
                has_sample: false,
                is_complete: false,
                lift_off,
            });
        }
        if let Some(impact) = self.all.iter_mut().rfind(|impact| impact.contact == contact) {
            match event.kind {
                EventKind::LiftOff => impact.lift_off = Some((event.time_s, event.impulse)),
                EventKind::TouchDown | EventKind::Reload => impact.lift_off = None,
                EventKind::Slips | EventKind::Sticks => {}
            }
        }
        Ok(())
    }
}

/// Cumulative normal impulse at a time between two samples: cubic Hermite interpolation with the normal forces as
/// slopes. The slopes are limited to three times the mean slope to keep it monotone (Fritsch and Carlson 1980).
fn impulse(from: &Sample, to: &Sample, contact: usize, time_s: f64) -> f64 {
    let (a, b) = (from.contact(contact), to.contact(contact));
    let length = to.time_s - from.time_s;
    if length <= 0.0 || time_s >= to.time_s {
        return b.impulse_n_s;
    }
    let x = ((time_s - from.time_s) / length).clamp(0.0, 1.0);
    let rise = b.impulse_n_s - a.impulse_n_s;
    let slope = |normal_n: f64| (normal_n * length).min(3.0 * rise);
    let (x2, x3) = (x * x, x * x * x);
    a.impulse_n_s
        + rise * (3.0 * x2 - 2.0 * x3)
        + slope(a.normal_n) * (x3 - 2.0 * x2 + x)
        + slope(b.normal_n) * (x3 - x2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::BodyState;

    fn projectile(time_s: f64) -> Sample {
        let disc = BodyState {
            centre_m: [3.0 * time_s, 1.0 - 5.0 * time_s * time_s],
            angle_rad: 7.0 * time_s,
            velocity_m_s: [3.0, -10.0 * time_s],
            spin_rad_s: 7.0,
        };
        Sample::of(time_s, &[], &[disc], &[])
    }

    #[test]
    fn projectile_motion_is_interpolated_exactly() {
        let recording = Recording { samples: [0.0, 0.5, 2.0].map(projectile).to_vec(), ..Recording::default() };
        let mut cursor = 0;
        for t in [0.0, 0.2, 0.5, 1.1, 2.0, 0.3] {
            let (found, expected) = (recording.interpolate(t, &mut cursor).expect("samples"), projectile(t));
            let (found, expected) = (found.body(0), expected.body(0));
            for k in 0..2 {
                assert!((found.centre_m[k] - expected.centre_m[k]).abs() < 1e-14, "{t}");
                assert!((found.velocity_m_s[k] - expected.velocity_m_s[k]).abs() < 1e-14, "{t}");
            }
            assert!((found.angle_rad - expected.angle_rad).abs() < 1e-14, "{t}");
        }
        assert_eq!(Recording::default().interpolate(0.0, &mut 0), None);
    }
}
