//! Report of the accelerations that a grasp withstands: text and CSV.

use serde_json::json;

use super::rows_csv;
use crate::format::format_duration;
use crate::format::numbers::{G_M_S2, format_number};
use crate::format::report::{Report, ToReport};
use crate::statics::AccelerationLimit;
use crate::study::hold::{Hold, Limit, LoadCase, LoadResult, LoadSize, Loads, StartReason, axis_name};

impl ToReport for Hold {
    fn report(&self) -> Report {
        let start = match self.start_reason {
            StartReason::Requested => "as requested",
            StartReason::AtRest => "when the object is at rest",
            StartReason::StillMoving { .. } => "at the end of the scene, while the object still moves",
            StartReason::MoveCompleted => "after the first of the scene's moves",
            StartReason::OwnMove => "at the start of the scene's own moves",
        };
        let loads = match self.plan.loads {
            Loads::Pulses { length_s, .. } => format!("pulses of {}", format_duration(length_s)),
            Loads::Vibrations { .. } => "vibrations".to_string(),
            Loads::Move => "moves".to_string(),
        };
        let mut text = Report::from(format!("{}: {} model, {loads}\n", self.scene, self.plan.model.name()));
        text.push(Report::paragraph(&format!(
            "Loads start at {}, {start}. Without a load, the object slips by {} mm in the same time. {} runs.\nResults by load and peak \
             acceleration of the palm:\n\n",
            format_duration(self.setup.start_s),
            millimetres(self.unloaded.slip.displacement_m),
            self.results.iter().map(|load| load.evaluations.len()).sum::<usize>()
        )));
        for load in &self.results {
            text.push_str(&format!("{}: {}\n", load_name(&load.case), describe_load(load, self)));
        }
        text.push_str("\n");
        if self.results.iter().any(|load| load.static_limit.is_some()) {
            text.push(Report::paragraph(
                "Balance at rest refers to the contacts that are active at the start of the loads, in both directions.\n",
            ));
        }
        for line in smallest_limit(self)
            .into_iter()
            .chain(unreached_limits(self))
            .chain(self.results.iter().flat_map(|load| remarks(load, self)))
        {
            text.push(Report::paragraph(&format!("{line}\n")));
        }
        text
    }
}

fn millimetres(metres: f64) -> String {
    format_number(metres * 1e3, 3)
}

/// Describes the limits under one load.
fn describe_load(load: &LoadResult, study: &Hold) -> String {
    let bound = millimetres(study.plan.slip_m);
    let up_to = |limit: &Limit, size: &str| {
        let mark = if limit.held_above.is_none() && limit.unknown == 0 { "" } else { " *" };
        let largest = if limit.failed.is_none() { ", the largest load" } else { "" };
        limit.held.map(|held| format!("up to {}{mark}{largest}", peak(held, size)))
    };
    let size = load.held_size(&load.slips).map_or(String::new(), |size| format!(", {}", format_size(size)));
    let fate = load.ended_by(&load.drops).unwrap_or("dropped");
    let slips = match (up_to(&load.slips, &size), load.slips.failed) {
        (Some(up_to), _) => format!("the object slips less than {bound} mm {up_to}"),
        (None, Some(failed)) => {
            format!("the object slips by more than {bound} mm at {}, the smallest load,", peak(failed, ""))
        }
        (None, None) => return "no run under this load was completed *".to_string(),
    };
    let drops = match (up_to(&load.drops, ""), load.drops.failed) {
        (Some(_), None) if load.slips.failed.is_none() => ", and is held".to_string(),
        (Some(up_to), None) => format!(" and is held {up_to}"),
        (Some(up_to), Some(_)) => format!(" and is held {up_to}, above which it is {fate}"),
        (None, Some(_)) => format!(" and is {fate} there"),
        (None, None) => String::new(),
    };
    let balanced = match &load.static_limit {
        None => return format!("{slips}{drops}"),
        Some(AccelerationLimit::Infeasible) => "nothing".to_string(),
        Some(AccelerationLimit::Limited(limit)) => acceleration(limit.acceleration_m_s2),
        Some(AccelerationLimit::Unlimited) => "any acceleration".to_string(),
    };
    format!("{slips}{drops}; contacts at rest balance {balanced}")
}

/// Formats an acceleration in m/s².
fn acceleration(m_s2: f64) -> String {
    format!("{} m/s²", format_number(m_s2, 4))
}

/// Formats a peak acceleration in m/s² and g.
fn peak(m_s2: f64, size: &str) -> String {
    format!("{} ({} g{size})", acceleration(m_s2), format_number(m_s2 / G_M_S2, 3))
}

fn format_size(LoadSize { key, value }: LoadSize) -> String {
    match key {
        "distance_m" => format!("over {} mm", millimetres(value)),
        "amplitude_m" => format!("amplitude {} mm", millimetres(value)),
        "amplitude_rad" => format!("amplitude {}°", format_number(value.to_degrees(), 3)),
        _ => format!("in {} ms", millimetres(value)),
    }
}

/// Returns the name of a load.
fn load_name(case: &LoadCase) -> String {
    match *case {
        LoadCase::Pulse { direction_rad, .. } => {
            let degrees = (direction_rad.to_degrees() * 10.0).round() / 10.0;
            let axes = [(0.0, ", +x"), (90.0, ", +y (out of the palm)"), (180.0, ", −x"), (270.0, ", −y (into it)")];
            format!("{degrees}°{}", axes.iter().find(|(angle, _)| *angle == degrees).map_or("", |(_, name)| name))
        }
        LoadCase::Vibration { axis, frequency_hz } => {
            format!("{}, {} Hz", axis_name(axis), format_number(frequency_hz, 4))
        }
        LoadCase::Move => "move".to_string(),
    }
}

/// Reports the load with the smallest limit.
fn smallest_limit(study: &Hold) -> Option<String> {
    let failed = study.results.iter().filter_map(|load| Some((load, load.slips.failed?)));
    let Some((load, failed)) = failed.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Some("No load makes the object slip by more than the bound.".to_string());
    };
    let name = load_name(&load.case);
    match load.slips.held {
        Some(_) if study.results.len() == 1 => None,
        Some(held) => Some(format!("Smallest limit: {}, {name}.", peak(held, ""))),
        None => Some(format!(
            "Smallest limit: below {}, {name}; start at a smaller load with --from.",
            acceleration(failed)
        )),
    }
}

/// Reports limits beyond the largest load.
fn unreached_limits(study: &Hold) -> Option<String> {
    let is_unreached = |load: &&LoadResult| {
        load.to_m_s2 == study.plan.to_m_s2 && (load.slips.failed.is_none() || load.drops.failed.is_none())
    };
    let count = study.results.iter().filter(is_unreached).count();
    let plural = if count == 1 { "" } else { "s" };
    (count > 0).then(|| {
        format!(
            "{count} load{plural} of {}: a limit is not reached at {}, the largest load; raise --to.",
            study.results.len(),
            acceleration(study.plan.to_m_s2)
        )
    })
}

/// Returns notes on the limits of a load.
fn remarks(load: &LoadResult, study: &Hold) -> Vec<String> {
    let (mut notes, name) = (Vec::new(), load_name(&load.case));
    for (limit, fails) in [(&load.slips, "the object slips or is dropped"), (&load.drops, "the object is dropped")] {
        if let Some((failed, above)) = limit.failed.zip(limit.held_above) {
            notes.push(format!(
                "* {name}: not monotone: {fails} at {}, but not at {}; the limit is the first failure of {} loads, refined by \
                 bisection.",
                acceleration(failed),
                acceleration(above),
                study.plan.scan
            ));
        }
        if limit.unknown > 0 {
            let ends: Vec<String> = [limit.held, limit.failed].into_iter().flatten().map(acceleration).collect();
            notes.push(format!(
                "* {name}: runs not completed: {}, next to {}; the limit is not refined there.",
                limit.unknown,
                ends.join(" and ")
            ));
        }
    }
    if load.to_m_s2 < study.plan.to_m_s2 {
        notes.push(format!(
            "{name}: loads end at {}, because a larger load would press the object against the table.",
            acceleration(load.to_m_s2)
        ));
    }
    // Both limits often give the same note.
    notes.dedup();
    let reasons = load.evaluations.iter().filter_map(|run| Some((run.peak_m_s2, run.outcome.as_ref().err()?)));
    notes.extend(reasons.map(|(peak, reason)| format!("{name}, {}: {reason}", acceleration(peak))));
    notes
}

/// Returns all runs as CSV, one per line. Unknown values are empty.
pub(crate) fn hold_csv(study: &Hold) -> String {
    let columns = [
        "load",
        "direction_rad",
        "axis",
        "frequency_hz",
        "peak_m_s2=run/peak_m_s2",
        "distance_m=run/distance_m",
        "amplitude_m=run/amplitude_m",
        "amplitude_rad=run/amplitude_rad",
        "time_s=run/time_s",
        "fate=run/fate",
        "slip_m=run/slip/displacement_m",
        "slip_rad=run/slip/rotation_rad",
        "brake_slip_rad=run/brake_slip_rad",
        "end_s=run/end_s",
        "steps=run/steps",
        "reason=run/reason",
    ];
    let runs = study.results.iter().flat_map(|load| load.evaluations.iter().map(|run| (&load.case, run)));
    let rows = runs.map(|(case, run)| {
        let mut row = json!(case);
        row["run"] = json!(run);
        row
    });
    rows_csv(rows, &columns)
}
