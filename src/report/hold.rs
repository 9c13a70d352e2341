//! How well a gripper holds, as figures: JSON and CSV.

use serde::Serialize;

use crate::criteria::Travel;
use crate::scene::Axis;
use crate::study::hold::{Answer, AtRest, Case, Held, Hold, Limit, Since, Stage, Tried};

/// The accelerations of the palm at which an object slips in the hand or is dropped.
#[derive(Clone, Debug, Serialize)]
pub struct HoldReport {
    /// Name of the scene.
    pub scene: String,
    pub model: &'static str,
    /// When loads begin, and why then: `given`, `at rest`, `still moving`, `moved` or `own move`.
    pub begins_s: f64,
    pub begins: &'static str,
    /// How far the object may slip in the hand.
    pub slip_bound_m: f64,
    /// What was tried: peak accelerations from, to, how many before limits were narrowed, and how finely these are found.
    pub from_m_s2: f64,
    pub to_m_s2: f64,
    pub scan: usize,
    pub tolerance: f64,
    /// In the hand, in the same time, with no load at all.
    pub unloaded_slip: Travel,
    /// All runs under loads, and those of them that could not be finished.
    pub runs: usize,
    pub unfinished: usize,
    pub loads: Vec<LoadReport>,
}

/// One kind of load.
#[derive(Clone, Debug, Serialize)]
pub struct LoadReport {
    /// `pulse`, `vibration` or `move`.
    pub load: &'static str,
    /// Of a pulse: first acceleration, counter-clockwise from +x, and its length.
    pub direction_rad: Option<f64>,
    pub length_s: Option<f64>,
    /// Of a vibration: `x`, `y` or `angle`.
    pub axis: Option<&'static str>,
    pub frequency_hz: Option<f64>,
    /// The largest load of its scan: less than the largest asked for where a table is in the way.
    pub to_m_s2: f64,
    /// What contact forces can balance at rest, there and back: `nothing`, `up to` (the acceleration beside it) or `any`; null of loads
    /// that turn the palm, and where statics has no answer.
    pub quasi_static: Option<&'static str>,
    pub quasi_static_m_s2: Option<f64>,
    /// Where the object slips by more than the bound, or is dropped; and where it is dropped.
    pub slips: LimitReport,
    pub drops: LimitReport,
    /// By their loads.
    pub runs: Vec<TriedReport>,
}

/// Peak accelerations between which it begins to fail.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LimitReport {
    /// Null where it fails at the smallest load tried…
    pub held_m_s2: Option<f64>,
    /// …and where it does not fail at all.
    pub failed_m_s2: Option<f64>,
    /// What that is as a load.
    pub held_size: Option<SizeReport>,
    /// What the failing run came to: `slip`, or the fate of the object.
    pub ended_by: Option<&'static str>,
    /// Whether every load that held is smaller than every load that failed; and the largest one that is not.
    pub monotone: bool,
    pub held_above_m_s2: Option<f64>,
    /// Loads in between whose runs could not be finished.
    pub unfinished: usize,
}

/// How large a load is.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SizeReport {
    /// How far a pulse goes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_m: Option<f64>,
    /// Of a vibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_rad: Option<f64>,
    /// How long a move takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
}

/// One run.
#[derive(Clone, Debug, Serialize)]
pub struct TriedReport {
    pub peak_m_s2: f64,
    #[serde(flatten)]
    pub size: SizeReport,
    /// `held`, `dropped` or `ejected`; null where the run was not finished.
    pub fate: Option<&'static str>,
    /// In the hand since the load began.
    pub slip: Option<Travel>,
    /// Largest turn of the driven links under their brakes.
    pub brake_slip_rad: Option<f64>,
    pub end_s: Option<f64>,
    pub steps: Option<u64>,
    /// Why there is nothing.
    pub reason: Option<String>,
}

impl From<&Hold> for HoldReport {
    fn from(found: &Hold) -> Self {
        let tried = || found.held.iter().flat_map(|held| &held.tried);
        HoldReport {
            scene: found.scene.clone(),
            model: found.plan.model.name(),
            begins_s: found.stage.begins_s,
            begins: match found.since {
                Since::Given => "given",
                Since::Rest => "at rest",
                Since::Moving { .. } => "still moving",
                Since::Moved => "moved",
                Since::OwnMove => "own move",
            },
            slip_bound_m: found.plan.slip_m,
            from_m_s2: found.plan.from_m_s2,
            to_m_s2: found.plan.to_m_s2,
            scan: found.plan.scan,
            tolerance: found.plan.tolerance,
            unloaded_slip: found.unloaded.slip,
            runs: tried().count(),
            unfinished: tried().filter(|tried| tried.drops() == Answer::Unknown).count(),
            loads: found.held.iter().map(|held| LoadReport::new(held, found)).collect(),
        }
    }
}

impl LoadReport {
    fn new(held: &Held, all: &Hold) -> Self {
        let (load, direction_rad, length_s, axis, frequency_hz) = match held.case {
            Case::Pulse { direction_rad, length_s } => ("pulse", Some(direction_rad), Some(length_s), None, None),
            Case::Vibration { axis, frequency_hz } => {
                ("vibration", None, None, Some(axis_key(axis)), Some(frequency_hz))
            }
            Case::Move => ("move", None, None, None, None),
        };
        let size = |peak_m_s2: f64| SizeReport::new(&held.case, &all.stage, peak_m_s2);
        let limit = |limit: &Limit| LimitReport {
            held_m_s2: limit.held,
            failed_m_s2: limit.failed,
            held_size: limit.held.map(size),
            ended_by: limit.failed.and_then(|failed| held.at(failed)).and_then(ended_by),
            monotone: limit.held_above.is_none(),
            held_above_m_s2: limit.held_above,
            unfinished: limit.unknown,
        };
        let run = |tried: &Tried| {
            let found = tried.found.as_ref().ok();
            TriedReport {
                peak_m_s2: tried.peak_m_s2,
                size: size(tried.peak_m_s2),
                fate: found.map(|found| found.fate.name()),
                slip: found.map(|found| found.slip),
                brake_slip_rad: found.map(|found| found.brake_slip_rad),
                end_s: found.map(|found| found.end_s),
                steps: found.map(|found| found.steps),
                reason: tried.found.as_ref().err().cloned(),
            }
        };
        let (slips, drops) = (limit(&held.slips), limit(&held.drops));
        let runs = held.tried.iter().map(run).collect();
        let (quasi_static, quasi_static_m_s2) = match held.at_rest {
            None => (None, None),
            Some(AtRest::Nothing) => (Some("nothing"), None),
            Some(AtRest::UpTo { acceleration_m_s2 }) => (Some("up to"), Some(acceleration_m_s2)),
            Some(AtRest::Any) => (Some("any"), None),
        };
        let to_m_s2 = held.to_m_s2;
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
    fn new(case: &Case, stage: &Stage, peak_m_s2: f64) -> Self {
        let size = case.size(stage, peak_m_s2);
        let turns = matches!(case, Case::Vibration { axis: Axis::Angle, .. });
        let shakes = matches!(case, Case::Vibration { .. });
        SizeReport {
            distance_m: matches!(case, Case::Pulse { .. }).then_some(size),
            amplitude_m: (shakes && !turns).then_some(size),
            amplitude_rad: turns.then_some(size),
            time_s: matches!(case, Case::Move).then(|| size * stage.own.arrives_s()),
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

/// What a run that failed came to: its fate, or how far it slipped.
fn ended_by(tried: &Tried) -> Option<&'static str> {
    let found = tried.found.as_ref().ok()?;
    Some(if tried.drops() == Answer::Held { "slip" } else { found.fate.name() })
}

/// All runs, one a line; what is unknown is empty.
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
