//! Report of the accelerations that a grasp withstands: JSON and CSV.

use serde::Serialize;

use crate::criteria::Travel;
use crate::scene::Axis;
use crate::study::hold::{Evaluation, Hold, Limit, LoadCase, LoadResult, LoadSetup, StartReason, StaticLimit, Verdict};

/// Accelerations of the palm at which an object slips in the hand or is dropped.
#[derive(Clone, Debug, Serialize)]
pub struct HoldReport {
    /// Name of the scene.
    pub scene: String,
    pub model: &'static str,
    /// Start time of the loads.
    pub begins_s: f64,
    /// Reason for the start time: `given`, `at rest`, `still moving`, `moved` or `own move`.
    #[serde(rename = "begins")]
    pub start_reason: &'static str,
    /// Largest allowed slip of the object in the hand.
    pub slip_bound_m: f64,
    /// Smallest peak acceleration of the scan.
    pub from_m_s2: f64,
    /// Largest peak acceleration of the scan.
    pub to_m_s2: f64,
    /// Number of loads before the limits are refined by bisection.
    pub scan: usize,
    /// Relative tolerance of the limits.
    pub tolerance: f64,
    /// Slip in the hand over the same time without a load.
    pub unloaded_slip: Travel,
    /// Number of runs under loads.
    pub runs: usize,
    /// Number of these runs that were not completed.
    pub unfinished: usize,
    pub loads: Vec<LoadReport>,
}

/// Results for one kind of load.
#[derive(Clone, Debug, Serialize)]
pub struct LoadReport {
    /// `pulse`, `vibration` or `move`.
    pub load: &'static str,
    /// Direction of the first acceleration of a pulse, counter-clockwise from +x.
    pub direction_rad: Option<f64>,
    /// Duration of a pulse.
    pub length_s: Option<f64>,
    /// Axis of a vibration: `x`, `y` or `angle`.
    pub axis: Option<&'static str>,
    pub frequency_hz: Option<f64>,
    /// Largest load of the scan; smaller than requested if a larger load would press the object against the table.
    pub to_m_s2: f64,
    /// Acceleration that contact forces can balance at rest in both directions: `nothing`, `up to` (see
    /// `quasi_static_m_s2`) or `any`; null for loads that rotate the palm, and where statics has no solution.
    pub quasi_static: Option<&'static str>,
    /// Largest balanced acceleration, if it is finite.
    pub quasi_static_m_s2: Option<f64>,
    /// Limit at which the object slips by more than the bound or is dropped.
    pub slips: LimitReport,
    /// Limit at which the object is dropped.
    pub drops: LimitReport,
    /// Runs, sorted by load.
    pub runs: Vec<LoadRunReport>,
}

/// Peak accelerations that bracket a limit.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LimitReport {
    /// Largest load below the first failure; null if the smallest load fails.
    pub held_m_s2: Option<f64>,
    /// Smallest load that fails; null if no load fails.
    pub failed_m_s2: Option<f64>,
    /// `held_m_s2` as the size of the load.
    pub held_size: Option<SizeReport>,
    /// Outcome of the failing run: `slip`, or the fate of the object.
    pub ended_by: Option<&'static str>,
    /// Whether every load that is withstood is smaller than every load that fails.
    #[serde(rename = "monotone")]
    pub is_monotone: bool,
    /// Largest load above `failed_m_s2` that is withstood.
    pub held_above_m_s2: Option<f64>,
    /// Number of loads in between whose runs were not completed.
    pub unfinished: usize,
}

/// Size of a load.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SizeReport {
    /// Distance of a pulse.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_m: Option<f64>,
    /// Translational amplitude of a vibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_m: Option<f64>,
    /// Angular amplitude of a vibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_rad: Option<f64>,
    /// Duration of a move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
}

/// One run under one load.
#[derive(Clone, Debug, Serialize)]
pub struct LoadRunReport {
    pub peak_m_s2: f64,
    #[serde(flatten)]
    pub size: SizeReport,
    /// `load_result`, `dropped` or `ejected`; null if the run was not completed.
    pub fate: Option<&'static str>,
    /// Slip in the hand since the start of the load.
    pub slip: Option<Travel>,
    /// Largest rotation of the driven links against their brakes.
    pub brake_slip_rad: Option<f64>,
    pub end_s: Option<f64>,
    pub steps: Option<u64>,
    /// Reason why the run was not completed.
    pub reason: Option<String>,
}

impl From<&Hold> for HoldReport {
    fn from(found: &Hold) -> Self {
        let runs = || found.results.iter().flat_map(|load| &load.evaluations);
        HoldReport {
            scene: found.scene.clone(),
            model: found.plan.model.name(),
            begins_s: found.setup.start_s,
            start_reason: match found.start_reason {
                StartReason::Requested => "given",
                StartReason::AtRest => "at rest",
                StartReason::StillMoving { .. } => "still moving",
                StartReason::MoveCompleted => "moved",
                StartReason::OwnMove => "own move",
            },
            slip_bound_m: found.plan.slip_m,
            from_m_s2: found.plan.from_m_s2,
            to_m_s2: found.plan.to_m_s2,
            scan: found.plan.scan,
            tolerance: found.plan.tolerance,
            unloaded_slip: found.unloaded.slip,
            runs: runs().count(),
            unfinished: runs().filter(|run| run.drops() == Verdict::Unknown).count(),
            loads: found.results.iter().map(|load| LoadReport::new(load, found)).collect(),
        }
    }
}

impl LoadReport {
    fn new(result: &LoadResult, study: &Hold) -> Self {
        let (load, direction_rad, length_s, axis, frequency_hz) = match result.case {
            LoadCase::Pulse { direction_rad, length_s } => ("pulse", Some(direction_rad), Some(length_s), None, None),
            LoadCase::Vibration { axis, frequency_hz } => {
                ("vibration", None, None, Some(axis_key(axis)), Some(frequency_hz))
            }
            LoadCase::Move => ("move", None, None, None, None),
        };
        let size = |peak_m_s2: f64| SizeReport::new(&result.case, &study.setup, peak_m_s2);
        let limit = |limit: &Limit| LimitReport {
            held_m_s2: limit.held,
            failed_m_s2: limit.failed,
            held_size: limit.held.map(size),
            ended_by: limit.failed.and_then(|failed| result.evaluation_at(failed)).and_then(ended_by),
            is_monotone: limit.held_above.is_none(),
            held_above_m_s2: limit.held_above,
            unfinished: limit.unknown,
        };
        let run_report = |run: &Evaluation| {
            let found = run.outcome.as_ref().ok();
            LoadRunReport {
                peak_m_s2: run.peak_m_s2,
                size: size(run.peak_m_s2),
                fate: found.map(|found| found.fate.name()),
                slip: found.map(|found| found.slip),
                brake_slip_rad: found.map(|found| found.brake_slip_rad),
                end_s: found.map(|found| found.end_s),
                steps: found.map(|found| found.steps),
                reason: run.outcome.as_ref().err().cloned(),
            }
        };
        let (slips, drops) = (limit(&result.slips), limit(&result.drops));
        let runs = result.evaluations.iter().map(run_report).collect();
        let (quasi_static, quasi_static_m_s2) = match result.static_limit {
            None => (None, None),
            Some(StaticLimit::Infeasible) => (Some("nothing"), None),
            Some(StaticLimit::UpTo { acceleration_m_s2 }) => (Some("up to"), Some(acceleration_m_s2)),
            Some(StaticLimit::Unlimited) => (Some("any"), None),
        };
        let to_m_s2 = result.to_m_s2;
        LoadReport {
            load,
            direction_rad,
            length_s,
            axis,
            frequency_hz,
            to_m_s2,
            quasi_static,
            quasi_static_m_s2,
            slips,
            drops,
            runs,
        }
    }
}

impl SizeReport {
    fn new(case: &LoadCase, setup: &LoadSetup, peak_m_s2: f64) -> Self {
        let size = case.size(setup, peak_m_s2);
        let is_angular = matches!(case, LoadCase::Vibration { axis: Axis::Angle, .. });
        let is_vibration = matches!(case, LoadCase::Vibration { .. });
        SizeReport {
            distance_m: matches!(case, LoadCase::Pulse { .. }).then_some(size),
            amplitude_m: (is_vibration && !is_angular).then_some(size),
            amplitude_rad: is_angular.then_some(size),
            time_s: matches!(case, LoadCase::Move).then(|| size * setup.scene_motion.moves_end_s()),
        }
    }
}

pub(super) fn axis_key(axis: Axis) -> &'static str {
    match axis {
        Axis::X => "x",
        Axis::Y => "y",
        Axis::Angle => "angle",
    }
}

/// Returns the outcome of a failed run: `slip` or the fate of the object.
fn ended_by(run: &Evaluation) -> Option<&'static str> {
    let found = run.outcome.as_ref().ok()?;
    Some(if run.drops() == Verdict::Held { "slip" } else { found.fate.name() })
}

/// Returns all runs as CSV, one per line. Unknown values are empty.
pub fn hold_csv(report: &HoldReport) -> String {
    let mut text = "load,direction_rad,axis,frequency_hz,peak_m_s2,distance_m,amplitude_m,amplitude_rad,time_s,fate,slip_m,slip_rad,\
                    brake_slip_rad,end_s,steps,reason\n"
        .to_string();
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
    for load in &report.loads {
        for run in &load.runs {
            let SizeReport { distance_m, amplitude_m, amplitude_rad, time_s } = run.size;
            let cells = [
                load.load.to_string(),
                number(load.direction_rad),
                load.axis.unwrap_or_default().to_string(),
                number(load.frequency_hz),
                number(Some(run.peak_m_s2)),
                number(distance_m),
                number(amplitude_m),
                number(amplitude_rad),
                number(time_s),
                run.fate.unwrap_or_default().to_string(),
                number(run.slip.map(|slip| slip.displacement_m)),
                number(run.slip.map(|slip| slip.rotation_rad)),
                number(run.brake_slip_rad),
                number(run.end_s),
                run.steps.map_or(String::new(), |steps| steps.to_string()),
                run.reason.as_ref().map_or(String::new(), |reason| format!("\"{}\"", reason.replace('"', "\"\""))),
            ];
            text.push_str(&cells.join(","));
            text.push('\n');
        }
    }
    text
}
