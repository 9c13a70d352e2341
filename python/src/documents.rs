//! What commands print as JSON, as dictionaries: the same figures, under the same keys.

use phalanx::grasp::finger::{Instead, grasp};
use phalanx::grasp::gripper::{Asked, gripper_grasp};
use phalanx::report::capture::CaptureReport;
use phalanx::report::hold::HoldReport;
use phalanx::report::sizing::SizingReport;
use phalanx::report::statics::{GripperStaticsReport, StaticsReport};
use phalanx::report::validation::ValidationReport;
use phalanx::scene::Axis;
use phalanx::scene::words::SceneKind;
use phalanx::study::capture::{CaptureError, Plan as Places, Source};
use phalanx::study::hold::{HoldError, Loads, Plan};
use phalanx::study::only_gripper;
use phalanx::study::posture::{directions, posture};
use phalanx::study::size::{Asked as Sizing, size as sized};
use phalanx::units::Dimension;
use phalanx::validate::{Climb, LADDER_TIME_S, StudyError, climb, refuse_too_fine};
use phalanx::wording::Reported;
use pyo3::prelude::*;

use super::result::model;
use super::scene::SceneLike;
use super::{errors, watch, words};

/// A quantity above 0, if it is given.
fn given(py: Python<'_>, what: &str, value: Option<&Bound<'_, PyAny>>, of: Dimension) -> PyResult<Option<f64>> {
    let read = value.map(|value| words::positive(what, value, of)).transpose()?;
    read.transpose().map_err(|error| errors::argument(py, error))
}

/// The grasp of a scene at rest (`phalanx statics --json`): forces, form and force closure, what acceleration it bears.
///
/// mu_static: friction coefficients, instead of 0 and those of the scene. motor: torque such as "500 N*mm", or in N·m.
/// Of a gripper: posture "run", "geometric" or angles ("q11=2 deg, q21=65 deg"), at (time of the run, s), within (m), every (angle
/// between directions).
#[pyfunction]
#[pyo3(signature = (scene, mu_static = None, motor = None, *, posture = None, at = None, within = None, every = None))]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn statics<'py>(
    py: Python<'py>,
    scene: SceneLike,
    mu_static: Option<Vec<f64>>,
    motor: Option<&Bound<'_, PyAny>>,
    posture: Option<&str>,
    at: Option<&Bound<'_, PyAny>>,
    within: Option<&Bound<'_, PyAny>>,
    every: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get(py)?;
    let wrong = |error: String| errors::argument(py, error);
    let mu_static = mu_static.unwrap_or_default();
    if let Some(mu) = mu_static.iter().find(|mu| !(mu.is_finite() && **mu >= 0.0)) {
        return Err(wrong(format!("mu_static has {mu}: expected numbers, 0 or more, such as [0, 0.4, 0.8]")));
    }
    let motor_n_m = motor.map(|motor| words::quantity("motor", motor, Dimension::Torque)).transpose()?;
    let motor_n_m = motor_n_m.transpose().map_err(wrong)?;
    let own = [
        ("posture", posture.is_some()),
        ("at", at.is_some()),
        ("within", within.is_some()),
        ("every", every.is_some()),
    ];
    match scene.scene.kind() {
        SceneKind::Finger => {
            if let Some((name, _)) = own.iter().find(|(_, given)| *given) {
                return Err(wrong(format!(
                    "{name} is for a gripper, and {} is a scene of one finger, whose posture is the geometric one: take it out",
                    scene.file()
                )));
            }
            let found = watch::free(py, |_| grasp(&scene.scene, &Instead { mu_static, motor_n_m }))?;
            let found = found.map_err(|error| errors::run(py, error, None))?;
            words::json(py, &StaticsReport::new(&found).json())
        }
        SceneKind::Gripper => {
            let said = posture.map_or(Ok(phalanx::study::posture::Posture::Run), self::posture).map_err(wrong)?;
            let at_s = given(py, "at", at, Dimension::Time)?;
            let within_m = given(py, "within", within, Dimension::Length)?;
            let asked = Asked {
                posture: said.asked(at_s, within_m).map_err(wrong)?,
                mu_static,
                motor_n_m,
                directions: directions(every.unwrap_or("15 deg")).map_err(wrong)?,
            };
            let found = watch::free(py, |go_on| gripper_grasp(&scene.scene, &asked, &|| go_on()))?;
            let found = found.map_err(|error| errors::run(py, error, None))?;
            words::json(py, &GripperStaticsReport::new(&found, 1).json())
        }
        SceneKind::Bodies => Err(wrong(format!(
            "{} is a scene of discs (kind = \"bodies\"), and statics is about the grasp of a finger or a gripper; give a scene like \
             scenes/experiment-95.toml or scenes/gripper/design-95.toml",
            scene.file()
        ))),
    }
}

/// Spring and motor of a finger for a test trajectory (`phalanx size --json`).
///
/// rule: "rigid" or "whole". closing_time: length of the trajectory, 10 ms if it is not given. preload: of the torsional spring that
/// the constant one is compared with, that of the scene's own one or 90 deg if it is not given. Texts with units, or numbers in s and rad.
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
    let wrong = |error: String| errors::argument(py, error);
    if scene.scene.kind() != SceneKind::Finger {
        return Err(wrong(format!("{} is not a scene of one finger, whose spring and motor are sized", scene.file())));
    }
    let usual = Sizing::default();
    let asked = Sizing {
        rule: words::word("rule", rule).map_err(wrong)?,
        closing_s: given(py, "closing_time", closing_time, Dimension::Time)?.unwrap_or(usual.closing_s),
        preload_rad: given(py, "preload", preload, Dimension::Angle)?,
    };
    let found = watch::free(py, |_| sized(&scene.scene, asked))?.map_err(|error| errors::argument(py, error))?;
    words::json(py, &SizingReport::from(&found).json())
}

/// How much acceleration a gripper holds its object against (`phalanx hold --json`).
///
/// Pulses of length `pulse` in `directions` directions, or vibrations at these frequencies (a list) along "x", "y", "angle", or the
/// scene's own move. slip: how far the object may slip in the hand. at: when loads begin. from_, to: peak accelerations that are
/// tried, scan of them; tol: how finely limits are found. Texts with units, or numbers in SI.
#[pyfunction]
#[pyo3(signature = (scene, *, pulse = None, directions = None, vibration = None, along = None, r#move = false, slip = None,
                    at = None, from_ = None, to = None, scan = None, tol = None, model = "analytic", threads = 0))]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn hold<'py>(
    py: Python<'py>,
    scene: SceneLike,
    pulse: Option<&Bound<'_, PyAny>>,
    directions: Option<usize>,
    vibration: Option<Vec<Bound<'_, PyAny>>>,
    along: Option<Vec<String>>,
    r#move: bool,
    slip: Option<&Bound<'_, PyAny>>,
    at: Option<&Bound<'_, PyAny>>,
    from_: Option<&Bound<'_, PyAny>>,
    to: Option<&Bound<'_, PyAny>>,
    scan: Option<usize>,
    tol: Option<f64>,
    model: &str,
    threads: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get(py)?;
    let wrong = |error: String| errors::argument(py, error);
    let usual = Plan::default();
    let pulses = pulse.is_some() || directions.is_some();
    if usize::from(pulses) + usize::from(vibration.is_some()) + usize::from(r#move) > 1 {
        return Err(wrong("pulses (pulse, directions), vibration and move exclude each other".to_string()));
    }
    if along.is_some() && vibration.is_none() {
        return Err(wrong("along is of vibrations: give vibration too, such as [\"50 Hz\", \"200 Hz\"]".to_string()));
    }
    let loads = match (vibration, r#move, usual.loads) {
        (Some(frequencies), _, _) => {
            let hz = |of: &Bound<'_, PyAny>| words::positive("vibration", of, Dimension::Frequency);
            let read: PyResult<Vec<Result<f64, String>>> = frequencies.iter().map(hz).collect();
            let mut frequencies_hz = read?.into_iter().collect::<Result<Vec<f64>, String>>().map_err(wrong)?;
            frequencies_hz.sort_by(f64::total_cmp);
            let along = along.unwrap_or_else(|| vec!["x".to_string(), "y".to_string()]);
            let axes = along.iter().map(|word| axis(word)).collect::<Result<Vec<Axis>, String>>().map_err(wrong)?;
            Loads::Vibrations { axes, frequencies_hz }
        }
        (None, true, _) => Loads::Move,
        (None, false, Loads::Pulses { directions: many, length_s }) => Loads::Pulses {
            directions: directions.unwrap_or(many),
            length_s: given(py, "pulse", pulse, Dimension::Time)?.unwrap_or(length_s),
        },
        (None, false, other) => other,
    };
    let plan = Plan {
        model: self::model(py, model)?,
        loads,
        begins_s: given(py, "at", at, Dimension::Time)?,
        slip_m: given(py, "slip", slip, Dimension::Length)?.unwrap_or(usual.slip_m),
        from_m_s2: given(py, "from_", from_, Dimension::Acceleration)?.unwrap_or(usual.from_m_s2),
        to_m_s2: given(py, "to", to, Dimension::Acceleration)?.unwrap_or(usual.to_m_s2),
        scan: scan.unwrap_or(usual.scan),
        tolerance: tol.unwrap_or(usual.tolerance),
        threads,
    };
    plan.check().map_err(wrong)?;
    let gripper = only_gripper(scene.scene.clone(), scene.file(), "scenes/gripper/hold.toml").map_err(wrong)?;
    let found = watch::free(py, |go_on| phalanx::study::hold::hold(&gripper, plan, &mut |_, _| {}, go_on))?;
    let found = found.map_err(|error| match error {
        HoldError::Stopped { .. } | HoldError::Scene { .. } => errors::run(py, error, None),
        error => errors::argument(py, error),
    })?;
    words::json(py, &HoldReport::from(&found).json())
}

fn axis(word: &str) -> Result<Axis, String> {
    match word {
        "x" => Ok(Axis::X),
        "y" => Ok(Axis::Y),
        "angle" => Ok(Axis::Angle),
        _ => Err(format!("along has \"{word}\", but must be of \"x\", \"y\" and \"angle\"")),
    }
}

/// Which positioning errors a gripper captures (`phalanx capture --json`).
///
/// to: largest error, 3.5 mm if it is not given. places: how many of them, an odd number from 3. finely: how finely edges are found,
/// 0.01 mm if it is not given. Texts with units, or numbers in m.
#[pyfunction]
#[pyo3(signature = (scene, to = None, places = 15, finely = None, model = "analytic"))]
pub fn capture<'py>(
    py: Python<'py>,
    scene: SceneLike,
    to: Option<&Bound<'_, PyAny>>,
    places: usize,
    finely: Option<&Bound<'_, PyAny>>,
    model: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let scene = scene.get(py)?;
    let wrong = |error: String| errors::argument(py, error);
    if !(3..=1001).contains(&places) || places.is_multiple_of(2) {
        return Err(wrong(format!("places is {places}; expected an odd number from 3 to 1001, such as 15")));
    }
    let plan = Places {
        model: self::model(py, model)?,
        error_m: given(py, "to", to, Dimension::Length)?.unwrap_or(3.5e-3),
        places,
        tolerance_m: given(py, "finely", finely, Dimension::Length)?.unwrap_or(1e-5),
    };
    only_gripper(scene.scene.clone(), scene.file(), "scenes/gripper/offset.toml").map_err(wrong)?;
    let source = Source { layers: scene.layers, settings: scene.settings };
    let load = |offset_m: f64| source.placed(plan.error_m, offset_m);
    let found = watch::free(py, |go_on| phalanx::study::capture::capture(plan, &load, &mut |_, _| {}, go_on))?;
    let found = found.map_err(|error| match error {
        CaptureError::Scene(error) => errors::scene(py, &error),
        error => errors::run(py, error, None),
    })?;
    words::json(py, &CaptureReport::from(&found).json())
}

/// The engine compared with the analytic model (`phalanx validate --json`): `passed`, every bound with what was measured. ladder: compare
/// and time other settings as well, speed against error, in at most `ladder_time` ("10 s"). quick: leave those that take long out of it.
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
    refuse_too_fine(&scene.scene).map_err(|error| errors::argument(py, error))?;
    let time_s = given(py, "ladder_time", ladder_time, Dimension::Time)?;
    let plan = (ladder || time_s.is_some()).then(|| Climb { quick, time_s: time_s.unwrap_or(LADDER_TIME_S) });
    let found = watch::free(py, |go_on| {
        let mut found = phalanx::validate::validate(&scene.scene, go_on)?;
        if let Some(plan) = plan {
            climb(&mut found, &scene.scene, plan, &mut |_| {}, go_on)?;
        }
        Ok(found)
    })?;
    let found = found.map_err(|error: StudyError| errors::run(py, error, None))?;
    words::json(py, &ValidationReport::new(&scene.scene, &found, plan).json())
}
