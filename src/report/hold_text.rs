//! Text report of the accelerations that a grasp withstands.

use super::hold::{HoldReport, LimitReport, LoadReport, SizeReport};
use crate::format::format_duration;
use crate::format::numbers::{G_M_S2, format_number};
use crate::format::report::{Report, ToReport};

impl ToReport for HoldReport {
    fn report(&self) -> Report {
        let start = match self.start_reason {
            "at rest" => "when the object is at rest",
            "still moving" => "at the end of the scene, while the object still moves",
            "moved" => "after the first of the scene's moves",
            "own move" => "at the start of the scene's own moves",
            _ => "as requested",
        };
        let mut text = Report::from(format!("{}: {} model{}\n", self.scene, self.model, common_loads(self)));
        text.push(Report::paragraph(&format!(
            "Loads start at {}, {start}. Without a load, the object slips by {} mm in the same time. {} runs.\nResults by load and peak \
             acceleration of the palm:\n\n",
            format_duration(self.begins_s),
            millimetres(self.unloaded_slip.displacement_m),
            self.runs
        )));
        for load in &self.loads {
            text.push_str(&format!("{}: {}\n", load_name(load), describe_load(load, self)));
        }
        text.push_str("\n");
        if self.loads.iter().any(|load| load.quasi_static.is_some()) {
            text.push(Report::paragraph(
                "Balance at rest refers to the contacts that are active at the start of the loads, in both directions.\n",
            ));
        }
        for line in smallest_limit(self)
            .into_iter()
            .chain(unreached_limits(self))
            .chain(self.loads.iter().flat_map(|load| remarks(load, self)))
        {
            text.push(Report::paragraph(&format!("{line}\n")));
        }
        text
    }
}

fn millimetres(metres: f64) -> String {
    format_number(metres * 1e3, 3)
}

/// Describes the kind of loads.
fn common_loads(report: &HoldReport) -> String {
    match report.loads.first() {
        Some(load) if load.load == "pulse" => {
            load.length_s.map_or(String::new(), |length_s| format!(", pulses of {}", format_duration(length_s)))
        }
        Some(load) if load.load == "vibration" => ", vibrations".to_string(),
        _ => ", moves".to_string(),
    }
}

/// Describes the limits under one load.
fn describe_load(load: &LoadReport, report: &HoldReport) -> String {
    let bound = millimetres(report.slip_bound_m);
    let up_to = |limit: &LimitReport, size: &str| {
        let mark = if limit.is_monotone && limit.unfinished == 0 { "" } else { " *" };
        let largest = if limit.failed_m_s2.is_none() { ", the largest load" } else { "" };
        limit.held_m_s2.map(|held| format!("up to {}{mark}{largest}", peak(held, size)))
    };
    let size = load.slips.held_size.map_or(String::new(), |size| format!(", {}", format_size(size)));
    let fate = load.drops.ended_by.unwrap_or("dropped");
    let slips = match (up_to(&load.slips, &size), load.slips.failed_m_s2) {
        (Some(up_to), _) => format!("the object slips less than {bound} mm {up_to}"),
        (None, Some(failed)) => {
            format!("the object slips by more than {bound} mm at {}, the smallest load,", peak(failed, ""))
        }
        (None, None) => return "no run under this load was completed *".to_string(),
    };
    let drops = match (up_to(&load.drops, ""), load.drops.failed_m_s2) {
        (Some(_), None) if load.slips.failed_m_s2.is_none() => ", and is held".to_string(),
        (Some(up_to), None) => format!(" and is held {up_to}"),
        (Some(up_to), Some(_)) => format!(" and is held {up_to}, above which it is {fate}"),
        (None, Some(_)) => format!(" and is {fate} there"),
        (None, None) => String::new(),
    };
    let quasi_static = match (load.quasi_static, load.quasi_static_m_s2) {
        (_, Some(limit)) => format!("; contacts at rest balance {} m/s²", format_number(limit, 4)),
        (Some(range), None) => {
            format!("; contacts at rest balance {range}{}", if range == "any" { " acceleration" } else { "" })
        }
        (None, None) => String::new(),
    };
    format!("{slips}{drops}{quasi_static}")
}

/// Formats a peak acceleration in m/s² and g.
fn peak(m_s2: f64, size: &str) -> String {
    format!("{} m/s² ({} g{size})", format_number(m_s2, 4), format_number(m_s2 / G_M_S2, 3))
}

fn format_size(size: SizeReport) -> String {
    let SizeReport { distance_m, amplitude_m, amplitude_rad, time_s } = size;
    let parts = [
        distance_m.map(|si| format!("over {} mm", millimetres(si))),
        amplitude_m.map(|si| format!("amplitude {} mm", millimetres(si))),
        amplitude_rad.map(|si| format!("amplitude {}°", format_number(si.to_degrees(), 3))),
        time_s.map(|si| format!("in {} ms", millimetres(si))),
    ];
    parts.into_iter().flatten().collect()
}

/// Returns the name of a load.
fn load_name(load: &LoadReport) -> String {
    match (load.direction_rad, load.axis.zip(load.frequency_hz)) {
        (Some(rad), _) => {
            let degrees = (rad.to_degrees() * 10.0).round() / 10.0;
            let directions = [", +x", ", +y (out of the palm)", ", −x", ", −y (into it)"];
            let quarter = [0.0, 90.0, 180.0, 270.0].iter().position(|angle| *angle == degrees);
            format!("{degrees}°{}", quarter.map_or("", |quarter| directions[quarter]))
        }
        (None, Some((axis, frequency_hz))) => format!("{axis}, {} Hz", format_number(frequency_hz, 4)),
        (None, None) => "move".to_string(),
    }
}

/// Reports the load with the smallest limit.
fn smallest_limit(report: &HoldReport) -> Option<String> {
    let failed = report.loads.iter().filter_map(|load| Some((load, load.slips.failed_m_s2?)));
    let Some((load, failed)) = failed.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Some("No load makes the object slip by more than the bound.".to_string());
    };
    match load.slips.held_m_s2 {
        Some(_) if report.loads.len() == 1 => None,
        Some(held) => Some(format!("Smallest limit: {}, {}.", peak(held, ""), load_name(load))),
        None => Some(format!(
            "Smallest limit: below {} m/s², {}; start at a smaller load with --from.",
            format_number(failed, 4),
            load_name(load)
        )),
    }
}

/// Reports limits beyond the largest load.
fn unreached_limits(report: &HoldReport) -> Option<String> {
    let is_unreached = |load: &&LoadReport| {
        load.to_m_s2 == report.to_m_s2 && (load.slips.failed_m_s2.is_none() || load.drops.failed_m_s2.is_none())
    };
    let count = report.loads.iter().filter(is_unreached).count();
    let loads = if count == 1 { "1 load".to_string() } else { format!("{count} loads") };
    (count > 0).then(|| {
        format!(
            "{loads} of {}: a limit is not reached at {} m/s², the largest load; raise --to.",
            report.loads.len(),
            format_number(report.to_m_s2, 4)
        )
    })
}

/// Returns notes on the limits of a load.
fn remarks(load: &LoadReport, report: &HoldReport) -> Vec<String> {
    let mut notes = Vec::new();
    for (limit, fails) in [(&load.slips, "the object slips or is dropped"), (&load.drops, "the object is dropped")] {
        if let Some((failed, above)) = limit.failed_m_s2.zip(limit.held_above_m_s2) {
            notes.push(format!(
                "* {}: not monotone: {fails} at {} m/s², but not at {} m/s²; the limit is the first failure of {} loads, refined by \
                 bisection.",
                load_name(load),
                format_number(failed, 4),
                format_number(above, 4),
                report.scan
            ));
        }
        if limit.unfinished > 0 {
            let ends: Vec<String> = [limit.held_m_s2, limit.failed_m_s2]
                .into_iter()
                .flatten()
                .map(|end| format!("{} m/s²", format_number(end, 4)))
                .collect();
            notes.push(format!(
                "* {}: runs not completed: {}, next to {}; the limit is not refined there.",
                load_name(load),
                limit.unfinished,
                ends.join(" and ")
            ));
        }
    }
    if load.to_m_s2 < report.to_m_s2 {
        notes.push(format!(
            "{}: loads end at {} m/s², because a larger load would press the object against the table.",
            load_name(load),
            format_number(load.to_m_s2, 4)
        ));
    }
    let unfinished = load.runs.iter().filter_map(|run| Some((run.peak_m_s2, run.reason.as_ref()?)));
    // Both limits often give the same note.
    notes.dedup();
    notes.extend(
        unfinished.map(|(peak, reason)| format!("{}, {} m/s²: {reason}", load_name(load), format_number(peak, 4))),
    );
    notes
}
