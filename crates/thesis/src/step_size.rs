//! Force of one impact as a function of the step size, by formulation (thesis §B.1.1.1, Fig. B.3).
//!
//! Every run is compared with the analytic model at its reference preset. The force of the engine's laws is known at
//! the steps and interpolated linearly, as in a plot. rapier's own contact is rigid and has no finite force; it is
//! represented by the impulse divided by the step, constant over the step.

use std::time::Instant;

use serde::Serialize;

use crate::format::format_duration;
use crate::format::numbers::{format_number, row};
use crate::format::report::{Report, Table, ToReport, table};
use crate::numeric::elementary::{ln, pow};
use crate::plot::canvas::{Marker, THIN_LINE};
use crate::plot::chart::{Axis, Series, series_chart};
use crate::plot::theme::{AMBER, Colour, GREEN, ORANGE, SOFT};
use crate::scene::{Integrator, Method, Preset, Response, Scene, Stepping, one_line};
use crate::text::csv;
use crate::trace::{Event, EventKind, Model, Outcome, RequiredData, Sample, Schema, Sink, SinkError, is_grid_point};
use phalanx_parallel::{ComputeError, Monitor};

/// Steps as fractions of the plotted time, from coarse to fine: 1 % to 0.001 %.
const STEP_FRACTIONS: [f64; 7] = [1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5];
/// Number of step sizes in a quick study.
const QUICK_STEP_COUNT: usize = 5;
/// Relative tolerances of the analytic integrator; its absolute tolerances are scaled accordingly.
const TOLERANCES: [f64; 8] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
/// Error levels for which the largest step size is determined.
pub(crate) const ERROR_LEVELS: [f64; 4] = [0.6, 0.1, 0.01, 1e-4];
/// Number of times at which forces are compared.
const COMPARED_TIMES: usize = 20_000;
/// Number of dense-output samples of the analytic model per run.
const SAMPLES_PER_RUN: f64 = 50_000.0;
/// Minimum number of solver iterations for rapier's contact to converge.
const RAPIER_ITERATIONS: u32 = 50;

/// Formulation of the contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Formulation {
    /// The engine with the contact laws of the scene, applied in its contact hook.
    EngineLaws,
    /// The engine with rapier's own rigid contact.
    EngineRapier,
    /// The analytic integrator with a tolerance; its step is the mean step during the contact.
    Analytic,
}

impl Formulation {
    pub const ALL: [Formulation; 3] = [Formulation::EngineLaws, Formulation::EngineRapier, Formulation::Analytic];

    /// Returns the label in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Formulation::EngineLaws => "engine, contact laws",
            Formulation::EngineRapier => "engine, rapier's contact",
            Formulation::Analytic => "analytic, Rodas5P",
        }
    }
}

/// One run. Force errors are relative to the peak force of the reference. The error of the restitution is absolute.
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
    /// Root mean square of the force difference over the duration of the contact in the reference, extended by a
    /// quarter at both ends.
    pub curve_rms_error: f64,
    /// Largest force difference over the same interval.
    pub curve_max_error: f64,
    pub restitution_error: f64,
}

/// Largest step for which the largest error of the force curve is below a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crossing {
    pub formulation: Formulation,
    pub error: f64,
    /// Step as a fraction, interpolated between the evaluated steps; `None` if even the shortest step has a larger
    /// error.
    pub step_fraction: Option<f64>,
    /// Whether the longest step already has a smaller error, so that the actual value is larger.
    pub at_least: bool,
}

/// Results of the study.
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

/// Force curve and impact of one contact pair in a run.
#[derive(Clone, Debug, Default)]
struct Impact {
    pair: usize,
    /// Interval of the grid whose points form the curve; `None` for all samples. Curves on one grid are compared without an
    /// error of interpolation.
    interval_s: Option<f64>,
    points: Vec<(f64, f64)>,
    approach_m_s: f64,
    touchdown_s: Option<f64>,
    liftoff_s: Option<f64>,
    rate_after_m_s: f64,
    peak_n: f64,
    steps: u64,
}

impl Sink for Impact {
    fn required_data(&self) -> RequiredData {
        RequiredData::EVALUATION
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let contact = sample.contact(self.pair);
        if self.interval_s.is_none_or(|interval_s| is_grid_point(sample.time_s, interval_s)) {
            self.points.push((sample.time_s, contact.normal_n));
        }
        self.rate_after_m_s = contact.gap_rate_m_s;
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        match event.kind {
            _ if event.contact != self.pair => {}
            EventKind::TouchDown if self.touchdown_s.is_none() => {
                (self.touchdown_s, self.approach_m_s) = (Some(event.time_s), event.approach_speed);
            }
            EventKind::LiftOff => self.liftoff_s = Some(event.time_s),
            EventKind::TouchDown | EventKind::Reload | EventKind::Slips | EventKind::Sticks => {}
        }
        Ok(())
    }
}

/// Runs the study. The monitor counts the varied settings as parts of the computation.
///
/// # Errors
/// Returns an error if the scene has no suitable impact, if a run fails, or if the monitor stops the computation.
pub fn step_size(scene: &Scene, quick: bool, monitor: &Monitor) -> Result<StepSize, ComputeError> {
    let scene = scene.require_fingers(0).map_err(|error| ComputeError::Unsuitable(error.to_string()))?;
    let fractions = &STEP_FRACTIONS[..if quick { QUICK_STEP_COUNT } else { STEP_FRACTIONS.len() }];
    let values = |formulation| if formulation == Formulation::Analytic { &TOLERANCES[..] } else { fractions };
    monitor.start(Formulation::ALL.map(|formulation| values(formulation).len()).iter().sum(), "the reference");
    let mut reference_scene = scene.clone();
    reference_scene.apply_preset(Preset::Reference);
    reference_scene.log.numeric_hz = SAMPLES_PER_RUN / scene.duration_s;
    // The contact pair with the largest force.
    let outcome = run(Model::Analytic, &reference_scene, &mut (), monitor)?;
    let impacts = outcome.contacts.iter().enumerate().filter(|(_, pair)| pair.touchdowns > 0);
    let strongest = impacts.max_by(|a, b| a.1.peak_normal_n.total_cmp(&b.1.peak_normal_n)).map(|(pair, _)| pair);
    let no_impact = || {
        ComputeError::Unsuitable(
            "no contact closes and opens again in this scene; use a scene with an impact that rebounds before the end"
                .to_string(),
        )
    };
    let reference = simulate(Model::Analytic, &reference_scene, strongest.ok_or_else(no_impact)?, monitor)?;
    let contact_s = reference.touchdown_s.zip(reference.liftoff_s).ok_or_else(no_impact)?;
    let mut rows = Vec::new();
    for formulation in Formulation::ALL {
        for &setting in values(formulation) {
            monitor.advance(0, formulation.name());
            rows.push(evaluate(scene, formulation, setting, &reference, contact_s, monitor)?);
            monitor.advance(1, formulation.name());
        }
    }
    let crossings = Formulation::ALL
        .iter()
        .flat_map(|formulation| ERROR_LEVELS.map(|error| crossing(&rows, *formulation, error)))
        .collect();
    Ok(StepSize {
        scene: scene.name.clone(),
        pair: Schema::from_scene(scene).contacts[reference.pair].name.clone(),
        plotted_s: scene.duration_s,
        contact_s: contact_s.1 - contact_s.0,
        peak_n: reference.peak_n,
        restitution: reference.rate_after_m_s / reference.approach_m_s,
        rows,
        crossings,
    })
}

/// Runs one setting and compares its force with the reference, whose contact lasts between two times.
fn evaluate(
    scene: &Scene,
    formulation: Formulation,
    setting: f64,
    reference: &Impact,
    (touchdown_s, liftoff_s): (f64, f64),
    monitor: &Monitor,
) -> Result<Row, ComputeError> {
    let restitution = reference.rate_after_m_s / reference.approach_m_s;
    let mut varied = scene_with_setting(scene, formulation, setting, restitution);
    let model = if formulation == Formulation::Analytic { Model::Analytic } else { Model::Engine };
    let start = Instant::now();
    let at_steps = simulate(model, &varied, reference.pair, monitor)?;
    let wall_s = start.elapsed().as_secs_f64();
    let (step_s, found) = match model {
        Model::Analytic => {
            let is_in_contact = |point: &&(f64, f64)| point.0 > touchdown_s && point.0 <= liftoff_s;
            let steps = at_steps.points.iter().filter(is_in_contact).count();
            // The dense output is not part of the measured time.
            varied.log.numeric_hz = SAMPLES_PER_RUN / scene.duration_s;
            let dense = simulate(model, &varied, reference.pair, monitor)?;
            ((liftoff_s - touchdown_s) / steps.max(1) as f64, dense)
        }
        Model::Engine => (setting * scene.duration_s, at_steps.clone()),
    };
    let margin_s = 0.25 * (liftoff_s - touchdown_s);
    let is_stepwise = formulation == Formulation::EngineRapier;
    let (rms, max) = curve_errors(&found, reference, [touchdown_s - margin_s, liftoff_s + margin_s], is_stepwise);
    let run_restitution =
        if found.touchdown_s.is_some() { found.rate_after_m_s / reference.approach_m_s } else { -1.0 };
    Ok(Row {
        formulation,
        rtol: (model == Model::Analytic).then_some(setting),
        step_s,
        step_fraction: step_s / scene.duration_s,
        steps: at_steps.steps,
        wall_s,
        peak_error: (found.peak_n / reference.peak_n - 1.0).abs(),
        curve_rms_error: rms / reference.peak_n,
        curve_max_error: max / reference.peak_n,
        restitution_error: (run_restitution - restitution).abs(),
    })
}

fn simulate(model: Model, scene: &Scene, pair: usize, monitor: &Monitor) -> Result<Impact, ComputeError> {
    // The lowest rate has no grid points within the run.
    let has_grid = scene.log.numeric_hz * scene.duration_s > 1.0;
    let interval_s = has_grid.then_some(1.0 / scene.log.numeric_hz);
    let mut impact = Impact { pair, interval_s, ..Impact::default() };
    let outcome = run(model, scene, &mut impact, monitor)?;
    Ok(Impact { peak_n: outcome.contacts[pair].peak_normal_n, steps: outcome.work.steps, ..impact })
}

fn run(model: Model, scene: &Scene, sink: &mut impl Sink, monitor: &Monitor) -> Result<Outcome, ComputeError> {
    let result = monitor.run(model, scene, sink)?;
    result.map_err(|error| ComputeError::Failed(format!("the {} model: {error}", model.name())))
}

/// Returns the scene with a step (as a fraction of its duration) or a tolerance, logged only at the steps. rapier's
/// contact gets the restitution of the reference as a parameter, unless the scene defines it.
fn scene_with_setting(scene: &Scene, formulation: Formulation, setting: f64, restitution: f64) -> Scene {
    let mut scene = scene.clone();
    scene.log.numeric_hz = 1.0 / scene.duration_s;
    let engine = &mut scene.engine;
    match formulation {
        Formulation::Analytic => {
            let preset = Integrator::preset(Preset::Engineering);
            let factor = setting / preset.rtol;
            scene.integrator = Integrator {
                method: Method::Rodas5p,
                rtol: setting,
                atol_angle_rad: preset.atol_angle_rad * factor,
                atol_rate_rad_s: preset.atol_rate_rad_s * factor,
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
            engine.iterations = engine.iterations.max(RAPIER_ITERATIONS);
            engine.stepping = Stepping::Fixed { step_s: setting * scene.duration_s };
        }
    }
    scene
}

/// Returns the root mean square and the largest difference of two curves between two times.
fn curve_errors(curve: &Impact, reference: &Impact, [from, to]: [f64; 2], is_stepwise: bool) -> (f64, f64) {
    let (mut squares, mut largest): (f64, f64) = (0.0, 0.0);
    for i in 0..=COMPARED_TIMES {
        let t = from + (to - from) * i as f64 / COMPARED_TIMES as f64;
        let error = (force_at(&curve.points, t, is_stepwise) - force_at(&reference.points, t, false)).abs();
        squares += error * error;
        largest = largest.max(error);
    }
    ((squares / (COMPARED_TIMES + 1) as f64).sqrt(), largest)
}

/// Returns the force at a time, interpolated linearly, or, if `is_stepwise`, the value at the end of the step.
fn force_at(points: &[(f64, f64)], t: f64, is_stepwise: bool) -> f64 {
    let after = points.partition_point(|point| point.0 < t).min(points.len() - 1);
    let (t1, f1) = points[after];
    if is_stepwise || after == 0 || t >= t1 {
        return f1;
    }
    let (t0, f0) = points[after - 1];
    if t1 > t0 { f0 + (f1 - f0) * (t - t0) / (t1 - t0) } else { f1 }
}

/// Returns the step size below which the largest error stays below a level, interpolated linearly in the logarithms.
fn crossing(rows: &[Row], formulation: Formulation, error: f64) -> Crossing {
    let selected: Vec<&Row> = rows.iter().filter(|row| row.formulation == formulation).collect();
    let last_above = selected.iter().rposition(|row| row.curve_max_error.is_nan() || row.curve_max_error > error);
    let step_fraction = match last_above {
        None => selected.first().map(|row| row.step_fraction),
        Some(above) => selected.get(above + 1).map(|below| {
            let above = selected[above];
            let fraction = ln(above.curve_max_error / error) / ln(above.curve_max_error / below.curve_max_error);
            above.step_fraction * pow(below.step_fraction / above.step_fraction, fraction.clamp(0.0, 1.0))
        }),
    };
    Crossing { formulation, error, step_fraction, at_least: last_above.is_none() }
}

impl StepSize {
    /// Returns all runs as CSV, one run per line. Unknown values are empty.
    pub fn csv(&self) -> String {
        csv(&self.rows)
    }

    /// Draws errors over the step size. Each formulation has a solid line for the curve and a faint line for the peak;
    /// errors of zero are omitted.
    pub fn picture(&self) -> String {
        let errors = self.rows.iter().flat_map(|row| [row.curve_max_error, row.peak_error]);
        let steps = self.rows.iter().map(|row| row.step_fraction);
        let x = Axis::logarithmic("step, part of the plotted time", steps, 12.0).with_margin();
        let y = Axis::logarithmic("error of the contact force, relative to its peak", errors.chain(ERROR_LEVELS), 12.0);
        let peak_marker = Marker::FaintLine { width: 3.0 };
        let mut series: Vec<Series> =
            ERROR_LEVELS.into_iter().map(|level| Series::horizontal(THIN_LINE, SOFT, level)).collect();
        for formulation in Formulation::ALL {
            let (marker, colour) = style(formulation);
            let error_curve = |marker, error: fn(&Row) -> f64| {
                let rows = self.rows.iter().filter(|row| row.formulation == formulation && error(row) > 0.0);
                Series::new(marker, colour, rows.map(|row| (row.step_fraction, error(row))))
            };
            series.push(error_curve(peak_marker, |row| row.peak_error));
            series.push(error_curve(THIN_LINE, |row| row.curve_max_error));
            series.push(error_curve(marker, |row| row.curve_max_error).named(formulation.name()));
        }
        series.push(Series::key(THIN_LINE, SOFT, "60, 10, 1, 0.01 %"));
        series.push(Series::key(peak_marker, SOFT, "faint: the peak only"));
        series_chart(&format!("{}: contact force against step size", self.scene), 600.0, &x, &y, &series)
    }
}

fn style(formulation: Formulation) -> (Marker, Colour) {
    match formulation {
        Formulation::EngineLaws => (Marker::Square, GREEN),
        Formulation::EngineRapier => (Marker::Cross, AMBER),
        Formulation::Analytic => (Marker::Circle, ORANGE),
    }
}

impl ToReport for StepSize {
    fn report(&self) -> Report {
        let StepSize { scene, pair, peak_n, restitution, .. } = self;
        let mut text = Report::from(format!(
            "{}, {pair}: {} in contact of {} plotted, peak {} N, restitution {}\n\n",
            one_line(scene),
            format_duration(self.contact_s),
            format_duration(self.plotted_s),
            format_number(*peak_n, 5),
            format_number(*restitution, 5)
        ));
        let header = row([
            "",
            "step, %",
            "step, µs",
            "steps",
            "time, ms",
            "peak, %",
            "curve rms, %",
            "curve max, %",
            "restitution",
        ]);
        let percent = |value: f64| format_number(100.0 * value, 3);
        let line = |run: &Row| {
            let tolerance = run.rtol.map_or(String::new(), |rtol| format!(", rtol {rtol:e}"));
            vec![
                format!("{}{tolerance}", run.formulation.name()),
                percent(run.step_fraction),
                format_number(run.step_s * 1e6, 3),
                run.steps.to_string(),
                format_number(run.wall_s * 1e3, 3),
                percent(run.peak_error),
                percent(run.curve_rms_error),
                percent(run.curve_max_error),
                format_number(run.restitution_error, 3),
            ]
        };
        let rows: Vec<_> = std::iter::once(header).chain(self.rows.iter().map(line)).collect();
        text.push(Table::new(&rows).key_columns(2));
        text.push_str("\nlargest step, % of the plotted time, with errors of the whole force curve below\n");
        let levels = ERROR_LEVELS.map(|level| format!("{} %", 100.0 * level));
        let header = std::iter::once(String::new()).chain(levels).collect();
        let line = |formulation: Formulation| {
            let cells = self.crossings.iter().filter(|crossing| crossing.formulation == formulation).map(step_cell);
            std::iter::once(formulation.name().to_string()).chain(cells).collect()
        };
        let rows: Vec<Vec<String>> = std::iter::once(header).chain(Formulation::ALL.map(line)).collect();
        text.push(table(&rows));
        text.push(Report::paragraph(
            "\nErrors are relative to the analytic model at its reference preset; force errors are relative to its peak. Forces of \
             the engine\nare interpolated linearly between its steps. rapier's own contact is rigid and has no finite force, so \
             impulse over step is used\ninstead. Steps of the analytic model are mean steps within the contact.\n",
        ));
        text
    }
}

fn step_cell(crossing: &Crossing) -> String {
    match crossing.step_fraction {
        None => "never".to_string(),
        Some(fraction) if crossing.at_least => format!("≥ {}", format_number(100.0 * fraction, 2)),
        Some(fraction) => format_number(100.0 * fraction, 2),
    }
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
    fn crossing_is_the_last_fall_below_the_level() {
        let rows = [row(1e-1, 1.0), row(1e-2, 1e-2), row(1e-3, 5e-2), row(1e-4, 5e-4)];
        let step_at = |error: f64| crossing(&rows, Formulation::EngineLaws, error).step_fraction;
        assert!((step_at(0.1).unwrap() / 10f64.powf(-1.5) - 1.0).abs() < 1e-12);
        // The error rises above 1e-2 again; only the last fall counts.
        assert!(step_at(1e-2).unwrap() < 1e-3 && step_at(1e-2).unwrap() > 1e-4);
        assert_eq!(step_at(1e-5), None);
        assert!(crossing(&rows, Formulation::EngineLaws, 2.0).at_least);
    }

    #[test]
    fn forces_are_interpolated_or_stepwise_constant() {
        let points = [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0)];
        assert_eq!(force_at(&points, 0.5, false), 1.0);
        assert_eq!(force_at(&points, 0.5, true), 2.0);
        assert_eq!(force_at(&points, 3.0, false), 0.0);
    }
}
