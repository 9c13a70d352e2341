//! What a validation needs of a scene of discs.

use super::super::Recording;
use super::super::{Check, GoOn, Subject, TORQUE_STEP, Verdict, While, reference};
use super::difference::compare;
use super::{BodiesComparison, BodiesDifferences};
use crate::check;
use crate::invariants::{Finding, Invariants};
use crate::scene::{BodiesBounds, BodiesScene, DiscMotion, Engine, Integrator, LogRates};
use crate::trace::{Model, RunError, Sink, run};

impl Subject for BodiesScene {
    type Bounds = BodiesBounds;
    type Recording = Recording;
    type Differences = BodiesDifferences;
    type Error = RunError;

    const JOINTED: bool = false;

    fn integrator(&self) -> &Integrator {
        &self.integrator
    }

    fn engine(&self) -> &Engine {
        &self.engine
    }

    fn duration_s(&self) -> f64 {
        self.duration_s
    }

    fn bounds(&self) -> BodiesBounds {
        self.bounds
    }

    fn numeric_hz(&self) -> f64 {
        self.log.numeric_hz
    }

    fn with_integrator(&self, integrator: Integrator) -> Self {
        BodiesScene { integrator, ..self.clone() }
    }

    fn with_engine(&self, engine: Engine) -> Self {
        BodiesScene { engine, ..self.clone() }
    }

    fn with_numeric_hz(&self, numeric_hz: f64) -> Self {
        BodiesScene { log: LogRates { numeric_hz, ..self.log }, ..self.clone() }
    }

    /// Everything that moves, and gravity, a little faster.
    fn member(&self, index: usize) -> Self {
        let factor = 1.0 + index as f64 * TORQUE_STEP;
        let scaled = |vector: [f64; 2]| vector.map(|part| factor * part);
        let mut member = self.clone();
        member.gravity_m_s2 = scaled(self.gravity_m_s2);
        for disc in &mut member.discs {
            match &mut disc.motion {
                DiscMotion::Fixed => {}
                DiscMotion::Driven { velocity_m_s, acceleration_m_s2, .. } => {
                    (*velocity_m_s, *acceleration_m_s2) = (scaled(*velocity_m_s), scaled(*acceleration_m_s2));
                }
                DiscMotion::Free { velocity_m_s, .. } => *velocity_m_s = scaled(*velocity_m_s),
            }
        }
        member
    }

    fn compared(&self) -> Self {
        BodiesScene { duration_s: self.bounds.until_s.min(self.duration_s), ..self.clone() }
    }

    fn touching_friction(&self) -> Option<f64> {
        let friction = self.contact.friction.map_or(0.0, |law| law.mu_static);
        (!self.pairs().is_empty()).then_some(friction)
    }

    fn steps(&self, model: Model, go_on: GoOn) -> Result<u64, RunError> {
        Ok(run(model, self, &mut While { sink: &mut (), go_on })?.work.steps)
    }

    fn record(&self, model: Model, go_on: GoOn) -> Result<Recording, RunError> {
        let mut recording = Recording::default();
        recording.outcome = run(model, self, &mut While { sink: &mut recording, go_on })?;
        Ok(recording)
    }

    fn recorded_steps(recording: &Recording) -> u64 {
        recording.outcome.work.steps
    }

    fn differences(&self, model: Model, reference: &Recording, go_on: GoOn) -> Result<BodiesDifferences, RunError> {
        let mut comparison = BodiesComparison::new(reference);
        let outcome = run(model, self, &mut While { sink: &mut comparison, go_on })?;
        Ok(comparison.finish(&outcome))
    }

    fn is_stop(error: &RunError) -> bool {
        error.is_stop()
    }

    fn check_reference(&self, go_on: GoOn) -> check::Check {
        check::check(Model::Analytic, &reference(self), go_on)
    }

    fn path_bound(&self) -> f64 {
        self.bounds.position_m
    }

    fn compare(&self, run: &Recording, reference: &Recording) -> BodiesDifferences {
        compare(run, reference)
    }

    fn worse(a: &BodiesDifferences, b: &BodiesDifferences) -> BodiesDifferences {
        a.worst(b)
    }

    fn judge(&self, found: &BodiesDifferences) -> Verdict {
        let BodiesBounds { position_m, contact_time_s, impulse, peak_force, .. } = self.bounds;
        let check = |bound, meaning, measured, limit| Check { bound, meaning, measured, limit };
        Verdict {
            checks: vec![
                check("position_m", "largest distance of a disc", Some(found.position_m()), position_m),
                check("contact_time_s", "largest difference of a first touch", found.contact_time(), contact_time_s),
                check("impulse", "relative difference of the impulse of a pair", found.impulse(), impulse),
                check("peak_force", "relative difference of a largest normal force", found.peak_force(), peak_force),
            ],
        }
    }

    fn invariants(&self, model: Model, run: &Recording) -> Vec<Finding> {
        let mut invariants = Invariants::new(model, self);
        for sample in &run.samples {
            invariants.sample(sample).expect("measuring writes nothing");
        }
        invariants.findings(0.0)
    }
}
