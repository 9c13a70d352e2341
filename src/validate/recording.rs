//! A run kept whole.

use super::Impacts;
use crate::criteria::{Judge, Judged};
use crate::law::spring_force;
use crate::scene::words::SceneKind;
use crate::scene::{Scene, System, Touching};
use crate::trace::{ContactSummary, Event, Model, Outcome, RunError, Sample, Sink, SinkError, between, run};
use crate::trace::{GoOn, While};

/// Everything a run said, in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// In order of time; two may share one.
    pub samples: Vec<Sample>,
    pub events: Vec<Event>,
    pub impacts: Impacts,
    pub outcome: Outcome,
    /// What the run is judged by.
    pub judged: Option<Judged>,
    /// Of pairs of discs: the force of the spring of the contact at its largest depth, N.
    pub spring_n: Vec<f64>,
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
        let (from, to) = (&self.samples[*cursor], &self.samples[(*cursor + 1).min(last)]);
        Some(between(from, to, time_s.min(to.time_s)))
    }
}

/// Runs the scene and keeps all of it.
pub fn record(model: Model, scene: &Scene) -> Result<Recording, RunError> {
    record_while(model, scene, &|| true)
}

/// Runs the scene as long as it may and keeps all of it.
pub fn record_while(model: Model, scene: &Scene, go_on: GoOn) -> Result<Recording, RunError> {
    let mut recording = Recording::default();
    let mut heard = Heard { recording: &mut recording, judge: Judge::of(scene) };
    let outcome = run(model, scene, &mut While { sink: &mut heard, go_on })?;
    let judged = heard.judge.judged(true);
    recording.judged = Some(judged);
    if scene.kind() == SceneKind::Bodies {
        let contacts = scene.system.touching().into_iter().zip(&outcome.contacts);
        recording.spring_n = contacts.map(|(touching, contact)| spring_n(&scene.system, touching, contact)).collect();
    }
    recording.outcome = outcome;
    Ok(recording)
}

/// Force of the spring of a contact of discs at its largest depth, N.
fn spring_n(system: &System, touching: Touching, contact: &ContactSummary) -> f64 {
    let law = match touching {
        Touching::Discs(..) => system.between_discs,
        Touching::Palm(_) => system.palm.and_then(|palm| palm.contact),
        Touching::Table(_) => system.table.and_then(|table| table.contact),
        Touching::Phalanx(..) | Touching::Stop(_) => None,
    };
    law.map_or(0.0, |law| spring_force(&law.normal, contact.max_penetration_m))
}

/// A recording that is judged as it is made.
struct Heard<'a> {
    recording: &'a mut Recording,
    judge: Judge,
}

impl Sink for Heard<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.judge.sample(sample)?;
        self.recording.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.judge.event(event)?;
        self.recording.event(event)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::BodyState;

    fn thrown(time_s: f64) -> Sample {
        let disc = BodyState {
            centre_m: [3.0 * time_s, 1.0 - 5.0 * time_s * time_s],
            angle_rad: 7.0 * time_s,
            velocity_m_s: [3.0, -10.0 * time_s],
            spin_rad_s: 7.0,
        };
        Sample { time_s, bodies: vec![disc], ..Sample::default() }
    }

    #[test]
    fn a_throw_between_two_samples_is_exact() {
        let recording = Recording { samples: [0.0, 0.5, 2.0].map(thrown).to_vec(), ..Recording::default() };
        let mut cursor = 0;
        for t in [0.0, 0.2, 0.5, 1.1, 2.0, 0.3] {
            let (found, expected) = (recording.at(t, &mut cursor).expect("samples"), thrown(t));
            let (found, expected) = (found.bodies[0], expected.bodies[0]);
            for k in 0..2 {
                assert!((found.centre_m[k] - expected.centre_m[k]).abs() < 1e-14, "{t}");
                assert!((found.velocity_m_s[k] - expected.velocity_m_s[k]).abs() < 1e-14, "{t}");
            }
            assert!((found.angle_rad - expected.angle_rad).abs() < 1e-14, "{t}");
        }
        assert_eq!(Recording::default().at(0.0, &mut 0), None);
    }
}
