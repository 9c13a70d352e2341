//! How well a gripper holds, for people.

use super::hold::{HoldReport, LimitReport, LoadReport, SizeReport};
use crate::wording::duration;
use crate::wording::figures::{G_M_S2, figure};
use crate::wording::report::{Report, Reported};

/// A table for people, and what it comes to.
impl Reported for HoldReport {
    fn report(&self) -> Report {
        let begins = match self.begins {
            "at rest" => "where the object is at rest",
            "still moving" => "where the scene ends, and the object still moves",
            "moved" => "where the first of the scene's moves is over",
            "own move" => "where the scene's own moves begin",
            _ => "as was asked",
        };
        let mut text = Report::from(format!("{}: {} model{}\n", self.scene, self.model, what(self)));
        text.push(Report::paragraph(&format!(
            "Loads from {} on, {begins}; without any, the object slips by {} mm in the same time. {} runs.\nUnder each load, by the peak \
             acceleration of the palm:\n\n",
            duration(self.begins_s),
            millimetres(self.unloaded_slip.displacement_m),
            self.runs
        )));
        for load in &self.loads {
            text.push_str(&format!("{}: {}\n", name(load), sentence(load, self)));
        }
        text.push_str("\n");
        if self.loads.iter().any(|load| load.quasi_static.is_some()) {
            text.push(Report::paragraph(
                "Balance at rest is that of the contacts that press when loads begin, there and back.\n",
            ));
        }
        for line in
            least(self).into_iter().chain(beyond(self)).chain(self.loads.iter().flat_map(|load| remarks(load, self)))
        {
            text.push(Report::paragraph(&format!("{line}\n")));
        }
        text
    }
}

fn millimetres(metres: f64) -> String {
    figure(metres * 1e3, 3)
}

/// What all loads have in common.
fn what(report: &HoldReport) -> String {
    match report.loads.first() {
        Some(load) if load.load == "pulse" => {
            load.length_s.map_or(String::new(), |length_s| format!(", pulses of {}", duration(length_s)))
        }
        Some(load) if load.load == "vibration" => ", vibrations".to_string(),
        _ => ", moves".to_string(),
    }
}

/// What comes of the object under one load.
fn sentence(load: &LoadReport, report: &HoldReport) -> String {
    let bound = millimetres(report.slip_bound_m);
    let up_to = |limit: &LimitReport, size: &str| {
        let mark = if limit.monotone && limit.unfinished == 0 { "" } else { " *" };
        let most = if limit.failed_m_s2.is_none() { ", the largest tried" } else { "" };
        limit.held_m_s2.map(|held| format!("up to {}{mark}{most}", peak(held, size)))
    };
    let size = load.slips.held_size.map_or(String::new(), |size| format!(", {}", size_words(size)));
    let fate = load.drops.ended_by.unwrap_or("dropped");
    let slips = match (up_to(&load.slips, &size), load.slips.failed_m_s2) {
        (Some(up_to), _) => format!("the object slips less than {bound} mm {up_to}"),
        (None, Some(failed)) => {
            format!("the object slips by more than {bound} mm at {}, the smallest tried,", peak(failed, ""))
        }
        (None, None) => return "no run under this load could be finished *".to_string(),
    };
    let drops = match (up_to(&load.drops, ""), load.drops.failed_m_s2) {
        (Some(_), None) if load.slips.failed_m_s2.is_none() => ", and is held".to_string(),
        (Some(up_to), None) => format!(" and is held {up_to}"),
        (Some(up_to), Some(_)) => format!(" and is held {up_to}, above which it is {fate}"),
        (None, Some(_)) => format!(" and is {fate} there"),
        (None, None) => String::new(),
    };
    let at_rest = match (load.quasi_static, load.quasi_static_m_s2) {
        (_, Some(most)) => format!("; contacts at rest balance {} m/s²", figure(most, 4)),
        (Some(word), None) => {
            format!("; contacts at rest balance {word}{}", if word == "any" { " acceleration" } else { "" })
        }
        (None, None) => String::new(),
    };
    format!("{slips}{drops}{at_rest}")
}

/// A peak acceleration, also in g.
fn peak(m_s2: f64, size: &str) -> String {
    format!("{} m/s² ({} g{size})", figure(m_s2, 4), figure(m_s2 / G_M_S2, 3))
}

fn size_words(size: SizeReport) -> String {
    let SizeReport { distance_m, amplitude_m, amplitude_rad, time_s } = size;
    let words = [
        distance_m.map(|si| format!("over {} mm", millimetres(si))),
        amplitude_m.map(|si| format!("amplitude {} mm", millimetres(si))),
        amplitude_rad.map(|si| format!("amplitude {}°", figure(si.to_degrees(), 3))),
        time_s.map(|si| format!("in {} ms", millimetres(si))),
    ];
    words.into_iter().flatten().collect()
}

/// Which load it is.
fn name(load: &LoadReport) -> String {
    match (load.direction_rad, load.axis.zip(load.frequency_hz)) {
        (Some(rad), _) => {
            let degrees = (rad.to_degrees() * 10.0).round() / 10.0;
            let towards = [", +x", ", +y (out of the palm)", ", −x", ", −y (into it)"];
            let quarter = [0.0, 90.0, 180.0, 270.0].iter().position(|of| *of == degrees);
            format!("{degrees}°{}", quarter.map_or("", |quarter| towards[quarter]))
        }
        (None, Some((axis, frequency_hz))) => format!("{axis}, {} Hz", figure(frequency_hz, 4)),
        (None, None) => "move".to_string(),
    }
}

/// The load that it holds least of.
fn least(report: &HoldReport) -> Option<String> {
    let failed = report.loads.iter().filter_map(|load| Some((load, load.slips.failed_m_s2?)));
    let Some((load, failed)) = failed.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Some("Nothing that was tried makes it slip by more.".to_string());
    };
    match load.slips.held_m_s2 {
        Some(_) if report.loads.len() == 1 => None,
        Some(held) => Some(format!("Least: {}, {}.", peak(held, ""), name(load))),
        None => Some(format!("Least: less than {} m/s², {}; ask from less on: --from.", figure(failed, 4), name(load))),
    }
}

/// What to do about limits that lie beyond the largest load.
fn beyond(report: &HoldReport) -> Option<String> {
    let ends = |load: &&LoadReport| {
        load.to_m_s2 == report.to_m_s2 && (load.slips.failed_m_s2.is_none() || load.drops.failed_m_s2.is_none())
    };
    let count = report.loads.iter().filter(ends).count();
    let loads = if count == 1 { "1 load".to_string() } else { format!("{count} loads") };
    (count > 0).then(|| {
        format!(
            "{loads} of {}: a limit is not reached at {} m/s², the largest tried; raise --to.",
            report.loads.len(),
            figure(report.to_m_s2, 4)
        )
    })
}

/// What must be said of a load beside its figures.
fn remarks(load: &LoadReport, report: &HoldReport) -> Vec<String> {
    let mut found = Vec::new();
    for (limit, fails) in [(&load.slips, "slips or is dropped"), (&load.drops, "is dropped")] {
        if let Some((failed, above)) = limit.failed_m_s2.zip(limit.held_above_m_s2) {
            found.push(format!(
                "* {}: not monotone: it {fails} at {} m/s², but not at {} m/s²; the limit is the first failure of {} loads and its \
                 bisection.",
                name(load),
                figure(failed, 4),
                figure(above, 4),
                report.scan
            ));
        }
        if limit.unfinished > 0 {
            let ends: Vec<String> = [limit.held_m_s2, limit.failed_m_s2]
                .into_iter()
                .flatten()
                .map(|end| format!("{} m/s²", figure(end, 4)))
                .collect();
            found.push(format!(
                "* {}: runs that could not be finished: {} next to {}, so that the limit is not narrowed there.",
                name(load),
                limit.unfinished,
                ends.join(" and ")
            ));
        }
    }
    if load.to_m_s2 < report.to_m_s2 {
        found.push(format!(
            "{}: tried up to {} m/s²: a larger load would press the object against the table.",
            name(load),
            figure(load.to_m_s2, 4)
        ));
    }
    let unfinished = load.runs.iter().filter_map(|run| Some((run.peak_m_s2, run.reason.as_ref()?)));
    // Often the same of both limits.
    found.dedup();
    found.extend(unfinished.map(|(peak, reason)| format!("{}, {} m/s²: {reason}", name(load), figure(peak, 4))));
    found
}
