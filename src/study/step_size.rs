//! The force of one impact against the step size, by formulation (thesis §B.1.1.1, Fig. B.3).
//!
//! Every run is compared with the analytic model at its reference preset. The force of the engine's laws is known at its
//! steps and joined by straight lines, as a plot does. rapier's own contact is rigid and has no finite force: impulse over
//! step stands in for it, constant over the step.

use std::time::Instant;

use serde::Serialize;

use crate::integrator::Failure;
use crate::numeric::elementary::{ln, pow};
use crate::scene::words::SceneKind;
use crate::scene::{Integrator, Method, Preset, Response, Scene, Stepping, WrongKind};
use crate::trace::{Event, EventKind, Model, RunError, Sample, Sink, SinkError, run};

/// Steps as fractions of the plotted time, from coarse to fine: 1 % to 0.001 %.
const FRACTIONS: [f64; 7] = [1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5];
/// Where there is no time for more.
const QUICK_FRACTIONS: usize = 5;
/// Relative tolerances of the analytic integrator; its absolute ones follow.
const TOLERANCES: [f64; 8] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
/// Errors whose step sizes are looked up.
pub const LEVELS: [f64; 4] = [0.6, 0.1, 0.01, 1e-4];
/// Instants of the contact at which forces are compared.
const INSTANTS: usize = 20_000;
/// Grid of the analytic model's dense output over the run.
const GRID: f64 = 50_000.0;
/// rapier's contact needs this many sweeps to be converged.
const RAPIER_SWEEPS: u32 = 50;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Formulation {
    /// The engine with the scene's laws through its contact hook.
    EngineLaws,
    /// The engine with rapier's own rigid contact.
    EngineRapier,
    /// The analytic integrator with a tolerance; its step is the mean one within the contact.
    Analytic,
}

impl Formulation {
    pub const ALL: [Formulation; 3] = [Formulation::EngineLaws, Formulation::EngineRapier, Formulation::Analytic];

    /// In tables and pictures.
    pub fn name(self) -> &'static str {
        match self {
            Formulation::EngineLaws => "engine, contact laws",
            Formulation::EngineRapier => "engine, rapier's contact",
            Formulation::Analytic => "analytic, Rodas5P",
        }
    }
}

/// One run. Errors are relative: forces to the reference's peak, restitution absolute.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    pub formulation: Formulation,
    /// Relative tolerance of the analytic model; `None` for fixed steps.
    pub rtol: Option<f64>,
    pub step_s: f64,
    pub step_fraction: f64,
    pub steps: u64,
    pub wall_s: f64,
    pub peak_error: f64,
    /// Root mean square and largest difference over the reference's contact, a quarter of its length more on both sides.
    pub curve_rms_error: f64,
    pub curve_max_error: f64,
    pub restitution_error: f64,
}

/// The largest step from which on the largest error of the force curve stays below a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crossing {
    pub formulation: Formulation,
    pub error: f64,
    /// Interpolated between the steps tried; `None` if even the finest is worse.
    pub step_fraction: Option<f64>,
    /// Whether already the coarsest step tried is better: the true answer is larger.
    pub at_least: bool,
}

/// The whole study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepSize {
    pub scene: String,
    pub pair: String,
    pub plotted_s: f64,
    pub contact_s: f64,
    pub peak_n: f64,
    pub restitution: f64,
    pub rows: Vec<Row>,
    pub crossings: Vec<Crossing>,
}

/// Why there is nothing to study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error("the {model} model stopped {failure}")]
    Simulation { model: &'static str, failure: Failure },
    #[error("nothing touches and parts again in this scene: give one with an impact that rebounds before its end")]
    NoImpact,
}

/// Times and forces of one pair, and what its impact came to.
#[derive(Clone, Debug, Default)]
struct Curve {
    pair: usize,
    points: Vec<(f64, f64)>,
    approach_m_s: f64,
    touch_s: Option<f64>,
    lift_s: Option<f64>,
    rate_after_m_s: f64,
}

impl Sink for Curve {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let contact = &sample.contacts[self.pair];
        self.points.push((sample.time_s, contact.normal_n));
        self.rate_after_m_s = contact.gap_rate_m_s;
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        match event.kind {
            _ if event.contact != self.pair => {}
            EventKind::TouchDown if self.touch_s.is_none() => {
                (self.touch_s, self.approach_m_s) = (Some(event.time_s), event.approach_speed);
            }
            EventKind::LiftOff => self.lift_s = Some(event.time_s),
            EventKind::TouchDown | EventKind::Reload | EventKind::Slips | EventKind::Sticks => {}
        }
        Ok(())
    }
}

/// A sink that ends its run when it may not go on.
struct While<'a, S> {
    sink: S,
    go_on: &'a dyn Fn() -> bool,
}

impl<S: Sink> Sink for While<'_, S> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.sink.event(event)
    }

    fn proceed(&self) -> bool {
        (self.go_on)()
    }
}

/// Runs the study for as long as it may `go_on`; `show` hears how many of how many runs are done.
pub fn step_size(
    scene: &Scene,
    quick: bool,
    show: &mut dyn FnMut(usize, usize, &str),
    go_on: &dyn Fn() -> bool,
) -> Result<StepSize, StudyError> {
    let mut fine = scene.only(SceneKind::Bodies)?.clone();
    fine.integrate_by(Preset::Reference);
    fine.log.numeric_hz = GRID / scene.duration_s;
    let pair = hit(&fine, go_on)?;
    let (reference, peak_n, _) = simulate(Model::Analytic, &fine, pair, go_on)?;
    let (Some(touch), Some(lift)) = (reference.touch_s, reference.lift_s) else { return Err(StudyError::NoImpact) };
    let restitution = reference.rate_after_m_s / reference.approach_m_s;
    let fractions = &FRACTIONS[..if quick { QUICK_FRACTIONS } else { FRACTIONS.len() }];
    let total = 2 * fractions.len() + TOLERANCES.len();
    let mut rows = Vec::new();
    for formulation in Formulation::ALL {
        let settings = match formulation {
            Formulation::Analytic => &TOLERANCES[..],
            _ => fractions,
        };
        for setting in settings {
            show(rows.len(), total, formulation.name());
            let tried = with_setting(scene, formulation, *setting, restitution);
            let model = if formulation == Formulation::Analytic { Model::Analytic } else { Model::Engine };
            let start = Instant::now();
            let (at_steps, _, steps) = simulate(model, &tried, pair, go_on)?;
            let wall_s = start.elapsed().as_secs_f64();
            // The analytic model's curve is its dense output: not part of the time.
            let mut logged = tried;
            if model == Model::Analytic {
                logged.log.numeric_hz = fine.log.numeric_hz;
            }
            let (curve, peak, _) = simulate(model, &logged, pair, go_on)?;
            let held = formulation == Formulation::EngineRapier;
            let margin = 0.25 * (lift - touch);
            let (rms, max) = curve_errors(&curve, &reference, [touch - margin, lift + margin], held);
            let step_s = match model {
                Model::Analytic => {
                    let within = at_steps.points.iter().filter(|point| point.0 > touch && point.0 <= lift).count();
                    (lift - touch) / within.max(1) as f64
                }
                Model::Engine => setting * scene.duration_s,
            };
            let back = if curve.touch_s.is_some() { curve.rate_after_m_s / reference.approach_m_s } else { -1.0 };
            rows.push(Row {
                formulation,
                rtol: (model == Model::Analytic).then_some(*setting),
                step_s,
                step_fraction: step_s / scene.duration_s,
                steps,
                wall_s,
                peak_error: (peak / peak_n - 1.0).abs(),
                curve_rms_error: rms / peak_n,
                curve_max_error: max / peak_n,
                restitution_error: (back - restitution).abs(),
            });
        }
    }
    let crossings = Formulation::ALL.iter().flat_map(|of| LEVELS.map(|error| crossing(&rows, *of, error))).collect();
    Ok(StepSize {
        scene: scene.name.clone(),
        pair: scene.system.pair_name(scene.system.pairs()[pair]),
        plotted_s: scene.duration_s,
        contact_s: lift - touch,
        peak_n,
        restitution,
        rows,
        crossings,
    })
}

/// The pair with the largest force.
fn hit(scene: &Scene, go_on: &dyn Fn() -> bool) -> Result<usize, StudyError> {
    let outcome =
        run(Model::Analytic, scene, &mut While { sink: (), go_on }).map_err(|error| stopped(Model::Analytic, error))?;
    let touched = outcome.contacts.iter().enumerate().filter(|(_, pair)| pair.touchdowns > 0);
    let hardest = touched.max_by(|a, b| a.1.peak_normal_n.total_cmp(&b.1.peak_normal_n));
    hardest.map(|(pair, _)| pair).ok_or(StudyError::NoImpact)
}

fn simulate(
    model: Model,
    scene: &Scene,
    pair: usize,
    go_on: &dyn Fn() -> bool,
) -> Result<(Curve, f64, u64), StudyError> {
    let mut curve = While { sink: Curve { pair, ..Curve::default() }, go_on };
    let outcome = run(model, scene, &mut curve).map_err(|error| stopped(model, error))?;
    Ok((curve.sink, outcome.contacts[pair].peak_normal_n, outcome.work.steps))
}

fn stopped(model: Model, error: RunError) -> StudyError {
    match error {
        RunError::Simulation { failure, .. } => StudyError::Simulation { model: model.name(), failure },
        RunError::Sink(_) => StudyError::NoImpact,
    }
}

/// The scene with a step (as a fraction of its duration) or a tolerance, logged at the steps alone. rapier's contact is
/// told the restitution, which it cannot know, unless the scene says it.
fn with_setting(scene: &Scene, formulation: Formulation, setting: f64, restitution: f64) -> Scene {
    let mut scene = scene.clone();
    scene.log.numeric_hz = 1.0 / scene.duration_s;
    let engine = &mut scene.engine;
    match formulation {
        Formulation::Analytic => {
            let everyday = Integrator::preset(Preset::Engineering);
            let looser = setting / everyday.rtol;
            scene.integrator = Integrator {
                method: Method::Rodas5p,
                rtol: setting,
                atol_angle_rad: everyday.atol_angle_rad * looser,
                atol_rate_rad_s: everyday.atol_rate_rad_s * looser,
                ..scene.integrator
            };
        }
        Formulation::EngineLaws => {
            engine.response = Response::Laws;
            engine.stepping = Stepping::Fixed { step_s: setting * scene.duration_s };
        }
        Formulation::EngineRapier => {
            if engine.response == Response::Laws {
                engine.response = Response::Rapier { friction: 0.0, restitution: restitution.clamp(0.0, 1.0) };
            }
            engine.iterations = engine.iterations.max(RAPIER_SWEEPS);
            engine.stepping = Stepping::Fixed { step_s: setting * scene.duration_s };
        }
    }
    scene
}

/// Root mean square and largest difference of two curves between two times.
fn curve_errors(curve: &Curve, reference: &Curve, [from, to]: [f64; 2], held: bool) -> (f64, f64) {
    let (mut squares, mut largest): (f64, f64) = (0.0, 0.0);
    for i in 0..=INSTANTS {
        let t = from + (to - from) * i as f64 / INSTANTS as f64;
        let error = (force_at(&curve.points, t, held) - force_at(&reference.points, t, false)).abs();
        squares += error * error;
        largest = largest.max(error);
    }
    ((squares / (INSTANTS + 1) as f64).sqrt(), largest)
}

/// The force at a time: on the straight line between two samples, or, if `held`, that of the step's end.
fn force_at(points: &[(f64, f64)], t: f64, held: bool) -> f64 {
    let after = points.partition_point(|point| point.0 < t).min(points.len() - 1);
    let (t1, f1) = points[after];
    if held || after == 0 || t >= t1 {
        return f1;
    }
    let (t0, f0) = points[after - 1];
    if t1 > t0 { f0 + (f1 - f0) * (t - t0) / (t1 - t0) } else { f1 }
}

/// Where the largest error of the curve falls below a level for good, on straight lines between the logarithms.
fn crossing(rows: &[Row], formulation: Formulation, error: f64) -> Crossing {
    let of: Vec<&Row> = rows.iter().filter(|row| row.formulation == formulation).collect();
    let last_above = of.iter().rposition(|row| row.curve_max_error.is_nan() || row.curve_max_error > error);
    let step_fraction = match last_above {
        None => of.first().map(|row| row.step_fraction),
        Some(above) => of.get(above + 1).map(|below| {
            let above = of[above];
            let share = ln(above.curve_max_error / error) / ln(above.curve_max_error / below.curve_max_error);
            above.step_fraction * pow(below.step_fraction / above.step_fraction, share.clamp(0.0, 1.0))
        }),
    };
    Crossing { formulation, error, step_fraction, at_least: last_above.is_none() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(step_fraction: f64, curve_max_error: f64) -> Row {
        Row {
            formulation: Formulation::EngineLaws,
            rtol: None,
            step_s: step_fraction,
            step_fraction,
            steps: 1,
            wall_s: 0.0,
            peak_error: 0.0,
            curve_rms_error: 0.0,
            curve_max_error,
            restitution_error: 0.0,
        }
    }

    #[test]
    fn crossings_are_interpolated_and_final() {
        let rows = [row(1e-1, 1.0), row(1e-2, 1e-2), row(1e-3, 5e-2), row(1e-4, 5e-4)];
        let at = |error: f64| crossing(&rows, Formulation::EngineLaws, error).step_fraction;
        assert!((at(0.1).unwrap() / 10f64.powf(-1.5) - 1.0).abs() < 1e-12);
        // It rises above 1e-2 again: only the last fall counts.
        assert!(at(1e-2).unwrap() < 1e-3 && at(1e-2).unwrap() > 1e-4);
        assert_eq!(at(1e-5), None);
        assert!(crossing(&rows, Formulation::EngineLaws, 2.0).at_least);
    }

    #[test]
    fn forces_are_joined_or_held() {
        let points = [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0)];
        assert_eq!(force_at(&points, 0.5, false), 1.0);
        assert_eq!(force_at(&points, 0.5, true), 2.0);
        assert_eq!(force_at(&points, 3.0, false), 0.0);
    }
}
