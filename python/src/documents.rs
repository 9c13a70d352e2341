//! Functions for commands with JSON output: each returns the document of the command as a dictionary.

use phalanx::format::ToReport;
use phalanx::grasp::finger::{GraspOverrides, grasp};
use phalanx::grasp::gripper::{GripperGraspRequest, gripper_grasp};
use phalanx::grasp::mechanism::{MechanismGraspRequest, mechanism_grasp};
use phalanx::parallel::Monitor;
use phalanx::report::statics::{GripperStaticsReport, MechanismStaticsReport, StaticsReport};
use phalanx::report::validation::ValidationReport;
use phalanx::scene::Axis;
use phalanx::study::capture::{CaptureError, Plan as CapturePlan, SceneSource};
use phalanx::study::hold::{HoldError, Loads, Plan as HoldPlan};
use phalanx::study::offsets::{OffsetError, OffsetPlan, offsets};
use phalanx::study::posture::{END_OF_RUN, parse_direction_count, parse_posture, with_options};
use phalanx::study::require_grasp;
use phalanx::study::size::{SizingOptions, size_finger};
use phalanx::trace::Model;
use phalanx::units::Dimension;
use phalanx::validate::{LADDER_TIME_S, LadderOptions, ValidationError, check_sample_count, run_ladder};
use pyo3::prelude::*;

use super::result::model;
use super::scene::SceneLike;
use super::{conversion, errors, interruptible};

/// Parses an optional argument that must be greater than 0.
fn optional_positive(
    py: Python<'_>,
    name: &str,
    value: Option<&Bound<'_, PyAny>>,
    dimension: Dimension,
) -> PyResult<Option<f64>> {
    let parsed = value.map(|value| conversion::parse_positive(name, value, dimension)).transpose()?;
    parsed.transpose().map_err(|error| errors::argument(py, error))
}

/// Computes the static grasp of a scene (`phalanx statics --json`): forces, closure, and allowable acceleration.
///
/// mu_static: friction coefficients; default: 0 and the coefficient of the scene. motor: motor torque for fingers and
/// grippers, a string such as "500 N*mm" or a number in N·m.
///
/// For grippers and mechanisms: at: time in the run. within: largest gap at which a surface counts as in contact.
/// every: angle between directions, such as "15 deg". For grippers: posture: "run", "geometric", or angles such as
/// "q11=2 deg, q21=65 deg". For mechanisms: object: the held body, if several bodies have no joints. base: the body
/// that is accelerated. Quantities are strings with units, or numbers in SI.
#[pyfunction]
#[pyo3(signature = (scene, mu_static = None, motor = None, *, posture = None, at = None, within = None, object = None, base = None, every = None))]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn statics<'py>(
    py: Python<'py>,
    scene: SceneLike,
    mu_static: Option<Vec<f64>>,
    motor: Option<&Bound<'_, PyAny>>,
    posture: Option<&str>,
    at: Option<&Bound<'_, PyAny>>,
    within: Option<&Bound<'_, PyAny>>,
    object: Option<&str>,
    base: Option<&str>,
    every: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get(py)?;
    let argument_error = |message: String| errors::argument(py, message);
    let mu_static = mu_static.unwrap_or_default();
    if let Some(mu) = mu_static.iter().find(|mu| !(mu.is_finite() && **mu >= 0.0)) {
        return Err(argument_error(format!(
            "mu_static contains {mu}; expected numbers, 0 or more, such as [0, 0.4, 0.8]"
        )));
    }
    let motor_n_m = motor.map(|motor| conversion::parse_quantity("motor", motor, Dimension::Torque)).transpose()?;
    let motor_n_m = motor_n_m.transpose().map_err(argument_error)?;
    let gripper_arguments = [
        ("posture", posture.is_some()),
        ("at", at.is_some()),
        ("within", within.is_some()),
        ("object", object.is_some()),
        ("base", base.is_some()),
        ("every", every.is_some()),
    ];
    let every = every.map(|angle| conversion::quantity_text(angle, Dimension::Angle)).transpose()?;
    let directions = parse_direction_count(every.as_deref().unwrap_or("15 deg")).map_err(argument_error)?;
    let at_s = optional_positive(py, "at", at, Dimension::Time)?;
    let within_m = optional_positive(py, "within", within, Dimension::Length)?;
    match scene.scene.finger_count() {
        0 => {
            if let Some(name) = [("motor", motor_n_m.is_some()), ("posture", posture.is_some())]
                .iter()
                .find_map(|(name, is_given)| is_given.then_some(name))
            {
                return Err(argument_error(format!(
                    "{name} is only allowed for fingers and grippers, and {} is a mechanism; remove it",
                    scene.file()
                )));
            }
            let [object, base] = [object, base].map(|name| name.map(str::to_owned));
            let request = MechanismGraspRequest { at_s, within_m, object, base, mu_static, directions };
            let result =
                interruptible::run(py, |keep_running| mechanism_grasp(&scene.scene, &request, &|| keep_running()))?;
            let result = result.map_err(|error| errors::run(py, error, None))?;
            conversion::parse_json(py, &MechanismStaticsReport::new(&result, 1).json())
        }
        1 => {
            if let Some((name, _)) = gripper_arguments.iter().find(|(_, is_given)| *is_given) {
                return Err(argument_error(format!(
                    "{name} is only allowed for a gripper, and {} is a scene of one finger, whose posture is always geometric; remove it",
                    scene.file()
                )));
            }
            let result = interruptible::run(py, |_| grasp(&scene.scene, &GraspOverrides { mu_static, motor_n_m }))?;
            let result = result.map_err(|error| errors::run(py, error, None))?;
            conversion::parse_json(py, &StaticsReport::new(&result).json())
        }
        _ => {
            if let Some(name) =
                [("object", object), ("base", base)].iter().find_map(|(name, given)| given.map(|_| name))
            {
                return Err(argument_error(format!(
                    "{name} is only allowed for a mechanism, and {} is a gripper",
                    scene.file()
                )));
            }
            let posture = posture.map_or(Ok(END_OF_RUN), parse_posture).map_err(argument_error)?;
            let posture = with_options(posture, at_s, within_m).map_err(argument_error)?;
            let request = GripperGraspRequest { posture, mu_static, motor_n_m, directions };
            let result =
                interruptible::run(py, |keep_running| gripper_grasp(&scene.scene, &request, &|| keep_running()))?;
            let result = result.map_err(|error| errors::run(py, error, None))?;
            conversion::parse_json(py, &GripperStaticsReport::new(&result, 1).json())
        }
    }
}

/// Sizes the spring and the motor of a finger for a test trajectory (`phalanx size --json`).
///
/// rule: "rigid" or "whole". closing_time: duration of the trajectory; default: 10 ms. preload: preload angle of the
/// torsional spring that is compared with the constant spring; default: the preload of the scene, or 90 deg if it has
/// none. Quantities are strings with units, or numbers in s and rad.
#[pyfunction]
#[pyo3(signature = (scene, rule = "rigid", closing_time = None, preload = None))]
pub fn size<'py>(
    py: Python<'py>,
    scene: SceneLike,
    rule: &str,
    closing_time: Option<&Bound<'_, PyAny>>,
    preload: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get(py)?;
    let argument_error = |message: String| errors::argument(py, message);
    if scene.scene.finger_count() != 1 {
        return Err(argument_error(format!(
            "{} is not a scene of one finger; only fingers have a spring and a motor to size",
            scene.file()
        )));
    }
    let defaults = SizingOptions::default();
    let options = SizingOptions {
        rule: conversion::parse_keyword("rule", rule).map_err(argument_error)?,
        closing_s: optional_positive(py, "closing_time", closing_time, Dimension::Time)?.unwrap_or(defaults.closing_s),
        preload_rad: optional_positive(py, "preload", preload, Dimension::Angle)?,
    };
    let sizing = interruptible::run(py, |_| size_finger(&scene.scene, options))?;
    let sizing = sizing.map_err(|error| errors::argument(py, error))?;
    conversion::parse_json(py, &sizing.json())
}

/// Finds the accelerations up to which a gripper, or the hand of a mechanism, holds its object (`phalanx hold --json`).
///
/// Loads are pulses of duration `pulse` in `directions` directions; or vibrations with the frequencies `vibration` (a
/// list) along "x", "y" or "angle"; or, with `move`, the motion of the scene. slip: largest allowed slip of the object
/// in the hand. at: time at which the loads begin. from_, to: range of the peak acceleration. scan: number of
/// accelerations in this range. tol: relative tolerance of a limit. Quantities are strings with units, or numbers in
/// SI.
#[pyfunction]
#[pyo3(signature = (scene, *, pulse = None, directions = None, vibration = None, along = None, r#move = false, slip = None,
                    at = None, from_ = None, to = None, scan = None, tol = None, model = "analytic", threads = 0))]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn hold<'py>(
    py: Python<'py>,
    scene: SceneLike,
    pulse: Option<&Bound<'_, PyAny>>,
    directions: Option<i128>,
    vibration: Option<Vec<Bound<'_, PyAny>>>,
    along: Option<Vec<String>>,
    r#move: bool,
    slip: Option<&Bound<'_, PyAny>>,
    at: Option<&Bound<'_, PyAny>>,
    from_: Option<&Bound<'_, PyAny>>,
    to: Option<&Bound<'_, PyAny>>,
    scan: Option<i128>,
    tol: Option<f64>,
    model: &str,
    threads: i128,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get(py)?;
    let argument_error = |message: String| errors::argument(py, message);
    let threads = conversion::threads(py, threads)?;
    let whole_number = |name: &str, value: Option<i128>| -> PyResult<Option<usize>> {
        Ok(value
            .map(|value| conversion::count(py, name, value, 0..=u64::from(u32::MAX)))
            .transpose()?
            .map(|value| value as usize))
    };
    let (directions, scan) = (whole_number("directions", directions)?, whole_number("scan", scan)?);
    let defaults = HoldPlan::default();
    let pulses = pulse.is_some() || directions.is_some();
    if usize::from(pulses) + usize::from(vibration.is_some()) + usize::from(r#move) > 1 {
        return Err(argument_error(
            "pulses (pulse, directions), vibration and move exclude each other; give only one of them".to_string(),
        ));
    }
    if along.is_some() && vibration.is_none() {
        return Err(argument_error(
            "along needs vibration, such as vibration=[\"50 Hz\", \"200 Hz\"]; give both or neither".to_string(),
        ));
    }
    let loads = match (vibration, r#move, defaults.loads) {
        (Some(frequencies), _, _) => {
            let parse_hz =
                |value: &Bound<'_, PyAny>| conversion::parse_positive("vibration", value, Dimension::Frequency);
            let parsed: PyResult<Vec<Result<f64, String>>> = frequencies.iter().map(parse_hz).collect();
            let mut frequencies_hz =
                parsed?.into_iter().collect::<Result<Vec<f64>, String>>().map_err(argument_error)?;
            frequencies_hz.sort_by(f64::total_cmp);
            let along = along.unwrap_or_else(|| vec!["x".to_string(), "y".to_string()]);
            let axes = along.iter().map(|name| parse_axis(name)).collect::<Result<Vec<Axis>, String>>();
            Loads::Vibrations { axes: axes.map_err(argument_error)?, frequencies_hz }
        }
        (None, true, _) => Loads::Move,
        (None, false, Loads::Pulses { directions: default_directions, length_s }) => Loads::Pulses {
            directions: directions.unwrap_or(default_directions),
            length_s: optional_positive(py, "pulse", pulse, Dimension::Time)?.unwrap_or(length_s),
        },
        (None, false, other) => other,
    };
    let plan = HoldPlan {
        model: self::model(py, model)?,
        loads,
        start_s: optional_positive(py, "at", at, Dimension::Time)?,
        slip_m: optional_positive(py, "slip", slip, Dimension::Length)?.unwrap_or(defaults.slip_m),
        from_m_s2: optional_positive(py, "from_", from_, Dimension::Acceleration)?.unwrap_or(defaults.from_m_s2),
        to_m_s2: optional_positive(py, "to", to, Dimension::Acceleration)?.unwrap_or(defaults.to_m_s2),
        scan: scan.unwrap_or(defaults.scan),
        tolerance: tol.unwrap_or(defaults.tolerance),
        threads,
    };
    plan.check().map_err(argument_error)?;
    let held = require_grasp(scene.scene.clone(), scene.file(), "scenes/gripper/hold.toml").map_err(argument_error)?;
    let result =
        interruptible::run(py, |keep_running| phalanx::study::hold::hold(&held, plan, &Monitor::silent(keep_running)))?;
    let result = result.map_err(|error| match error {
        HoldError::Stopped(_) | HoldError::Scene { .. } => errors::run(py, error, None),
        error => errors::argument(py, error),
    })?;
    conversion::parse_json(py, &result.json())
}

fn parse_axis(name: &str) -> Result<Axis, String> {
    match name {
        "x" => Ok(Axis::X),
        "y" => Ok(Axis::Y),
        "angle" => Ok(Axis::Angle),
        _ => Err(format!("along contains \"{name}\"; expected \"x\", \"y\" or \"angle\"")),
    }
}

/// Finds the positioning errors that a gripper, or the hand of a mechanism, captures (`phalanx capture --json`).
///
/// along: directions of the offsets of the object of a mechanism: a list of one or two of "x", "y" and "angle";
/// default: x. to: largest error, or a list with one value for each of `along`; default: 3.5 mm, 10 deg. places: number
/// of object positions, odd and at least 3. finely: tolerance of the edges of the captured range; default: 0.01 mm,
/// 0.01 deg. Sizes are strings with units, or numbers in m or rad.
#[pyfunction]
#[pyo3(signature = (scene, to = None, places = 15, finely = None, model = "analytic", *, along = None))]
pub fn capture<'py>(
    py: Python<'py>,
    scene: SceneLike,
    to: Option<&Bound<'_, PyAny>>,
    places: i128,
    finely: Option<&Bound<'_, PyAny>>,
    model: &str,
    along: Option<Vec<String>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get(py)?;
    let argument_error = |message: String| errors::argument(py, message);
    if !(3..=1001).contains(&places) || places % 2 == 0 {
        return Err(argument_error(format!("places is {places}; expected an odd number from 3 to 1001, such as 15")));
    }
    let model = self::model(py, model)?;
    let found =
        require_grasp(scene.scene.clone(), scene.file(), "scenes/gripper/offset.toml").map_err(argument_error)?;
    if found.finger_count() == 0 {
        let axes = along.unwrap_or_else(|| vec!["x".to_string()]);
        let axes = axes.iter().map(|name| parse_axis(name)).collect::<Result<Vec<Axis>, String>>();
        let plan = offset_plan(py, (axes.map_err(argument_error)?, to, finely), places as usize, model)?;
        let result = interruptible::run(py, |keep_running| offsets(plan, &found, &Monitor::silent(keep_running)))?;
        let result = result.map_err(|error| match error {
            OffsetError::Stopped(_) => errors::run(py, error, None),
            error => errors::argument(py, error),
        })?;
        return conversion::parse_json(py, &result.json());
    }
    if along.is_some() {
        let reason = "along is for mechanisms, but the object of fingers is offset along x; remove it";
        return Err(argument_error(reason.to_string()));
    }
    let plan = CapturePlan {
        model,
        error_m: optional_positive(py, "to", to, Dimension::Length)?.unwrap_or(3.5e-3),
        position_count: places as usize,
        tolerance_m: optional_positive(py, "finely", finely, Dimension::Length)?.unwrap_or(1e-5),
    };
    let source = SceneSource { layers: scene.layers, settings: scene.settings };
    let result = interruptible::run(py, |keep_running| {
        phalanx::study::capture::capture(plan, &source, &Monitor::silent(keep_running))
    })?;
    let result = result.map_err(|error| match error {
        CaptureError::Scene(error) => errors::scene(py, &error),
        error => errors::run(py, error, None),
    })?;
    conversion::parse_json(py, &result.json())
}

/// Offsets along axes; `to` is one size, or a list of one for each axis.
fn offset_plan(
    py: Python<'_>,
    (axes, to, finely): (Vec<Axis>, Option<&Bound<'_, PyAny>>, Option<&Bound<'_, PyAny>>),
    count: usize,
    model: Model,
) -> PyResult<OffsetPlan> {
    let dimension = |axis: Axis| if axis == Axis::Angle { Dimension::Angle } else { Dimension::Length };
    let default = |axis: Axis| if axis == Axis::Angle { 10f64.to_radians() } else { 3.5e-3 };
    let given: Vec<Bound<'_, PyAny>> = match to {
        None => Vec::new(),
        Some(to) => to.extract::<Vec<Bound<'_, PyAny>>>().unwrap_or_else(|_| vec![to.clone()]),
    };
    if !given.is_empty() && given.len() != axes.len() {
        let (sizes, axes) = (given.len(), axes.len());
        return Err(errors::argument(
            py,
            format!("to has {sizes} sizes, but along has {axes} axes; give one for each"),
        ));
    }
    let size = |(index, axis): (usize, &Axis)| {
        let size = optional_positive(py, "to", given.get(index), dimension(*axis))?;
        Ok((*axis, size.unwrap_or_else(|| default(*axis))))
    };
    let all = axes.iter().enumerate().map(size).collect::<PyResult<Vec<(Axis, f64)>>>()?;
    let first = axes.first().copied().unwrap_or(Axis::X);
    let finest = if first == Axis::Angle { 0.01f64.to_radians() } else { 1e-5 };
    let tolerance = optional_positive(py, "finely", finely, dimension(first))?.unwrap_or(finest);
    let plan = OffsetPlan { model, axes: all, count, tolerance };
    plan.check().map_err(|message| errors::argument(py, message))?;
    Ok(plan)
}

/// Compares the engine with the analytic model (`phalanx validate --json`). Returns `passed`, and each bound with its
/// value.
///
/// ladder: also compare and time other settings (speed against error), for at most `ladder_time`, by default 10 s.
/// quick: omit the slow settings of the ladder.
#[pyfunction]
#[pyo3(signature = (scene, quick = false, ladder = false, ladder_time = None))]
pub fn validate<'py>(
    py: Python<'py>,
    scene: SceneLike,
    quick: bool,
    ladder: bool,
    ladder_time: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get(py)?;
    check_sample_count(&scene.scene).map_err(|error| errors::argument(py, error))?;
    let time_s = optional_positive(py, "ladder_time", ladder_time, Dimension::Time)?;
    let ladder_options =
        (ladder || time_s.is_some()).then(|| LadderOptions { quick, time_s: time_s.unwrap_or(LADDER_TIME_S) });
    let validation = interruptible::run(py, |keep_running| {
        let mut validation = phalanx::validate::validate(&scene.scene, keep_running)?;
        if let Some(options) = ladder_options {
            run_ladder(&mut validation, &scene.scene, options, &Monitor::silent(keep_running))?;
        }
        Ok(validation)
    })?;
    let validation = validation.map_err(|error: ValidationError| errors::run(py, error, None))?;
    conversion::parse_json(py, &ValidationReport::new(&scene.scene, &validation, ladder_options).json())
}
