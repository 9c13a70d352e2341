//! A run stored in memory.

use super::Impacts;
use crate::criteria::{RunCriteria, RunCriteriaTracker};
use crate::law::spring_force;
use crate::scene::keywords::SceneKind;
use crate::scene::{ContactId, Scene, System};
use crate::trace::{Cancellable, KeepRunning};
use crate::trace::{ContactSummary, Event, Model, Outcome, RunError, Sample, Sink, SinkError, interpolate, run};

/// All samples, events and results of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Samples in order of time; two samples may have the same time.
    pub samples: Vec<Sample>,
    pub events: Vec<Event>,
    pub impacts: Impacts,
    pub outcome: Outcome,
    /// Criteria of the run.
    pub run_criteria: Option<RunCriteria>,
    /// Spring force of each contact of discs at its maximum penetration, N.
    pub peak_spring_n: Vec<f64>,
}

impl Sink for Recording {
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
    /// stores the index of the previous search, which makes access in order of time cheap.
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
pub fn record_cancellable(model: Model, scene: &Scene, keep_running: KeepRunning) -> Result<Recording, RunError> {
    let mut recording = Recording::default();
    let mut recording_sink =
        RecordingSink { recording: &mut recording, criteria_tracker: RunCriteriaTracker::for_scene(scene) };
    let outcome = run(model, scene, &mut Cancellable { sink: &mut recording_sink, keep_running })?;
    let run_criteria = recording_sink.criteria_tracker.finish(true);
    recording.run_criteria = Some(run_criteria);
    if scene.kind() == SceneKind::Bodies {
        let contacts = scene.system.contact_ids().into_iter().zip(&outcome.contacts);
        recording.peak_spring_n =
            contacts.map(|(contact_id, contact)| peak_spring_n(&scene.system, contact_id, contact)).collect();
    }
    recording.outcome = outcome;
    Ok(recording)
}

/// Spring force of a contact of discs at its maximum penetration, N.
fn peak_spring_n(system: &System, contact_id: ContactId, contact: &ContactSummary) -> f64 {
    let law = match contact_id {
        ContactId::Discs(..) => system.between_discs,
        ContactId::Palm(_) => system.palm.and_then(|palm| palm.contact),
        ContactId::Table(_) => system.table.and_then(|table| table.contact),
        ContactId::Phalanx(..) | ContactId::Stop(_) => None,
    };
    law.map_or(0.0, |law| spring_force(&law.normal, contact.max_penetration_m))
}

/// Records a run and evaluates its criteria.
struct RecordingSink<'a> {
    recording: &'a mut Recording,
    criteria_tracker: RunCriteriaTracker,
}

impl Sink for RecordingSink<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.criteria_tracker.sample(sample)?;
        self.recording.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.criteria_tracker.event(event)?;
        self.recording.event(event)
    }
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
        Sample { time_s, bodies: vec![disc], ..Sample::default() }
    }

    #[test]
    fn projectile_motion_is_interpolated_exactly() {
        let recording = Recording { samples: [0.0, 0.5, 2.0].map(projectile).to_vec(), ..Recording::default() };
        let mut cursor = 0;
        for t in [0.0, 0.2, 0.5, 1.1, 2.0, 0.3] {
            let (found, expected) = (recording.interpolate(t, &mut cursor).expect("samples"), projectile(t));
            let (found, expected) = (found.bodies[0], expected.bodies[0]);
            for k in 0..2 {
                assert!((found.centre_m[k] - expected.centre_m[k]).abs() < 1e-14, "{t}");
                assert!((found.velocity_m_s[k] - expected.velocity_m_s[k]).abs() < 1e-14, "{t}");
            }
            assert!((found.angle_rad - expected.angle_rad).abs() < 1e-14, "{t}");
        }
        assert_eq!(Recording::default().interpolate(0.0, &mut 0), None);
    }
}
