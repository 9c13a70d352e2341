//! How well a gripper holds, for people.

use super::hold::{HoldReport, LimitReport, LoadReport, SizeReport};
use crate::wording::duration;
use crate::wording::figures::{G_M_S2, figure, row};
use crate::wording::report::{Report, Reported, Table};

/// A table for people, and what it comes to.
impl Reported for HoldReport {
    fn report(&self) -> Report {
        let bound = millimetres(self.slip_bound_m);
        let begins = match self.begins {
            "at rest" => "where the object is at rest",
            "still moving" => "where the scene ends, and the object still moves",
            "moved" => "where the first of the scene's moves is over",
            "own move" => "where the scene's own moves begin",
            _ => "as was asked",
        };
        let mut text = Report::from(format!("{}: {} model{}\n", self.scene, self.model, what(self)));
        text.push(Report::paragraph(&format!(
            "Loads from {} on, {begins}; without any, the object slips by {} mm in the same time.\nThe largest peak accelerations at which it \
             slips less than {bound} mm and is held, and at which it is held:\n\n",
            duration(self.begins_s),
            millimetres(self.unloaded_slip.displacement_m)
        )));
        let size = size_head(self);
        let mut rows = vec![
            row([load_head(self), "slips less", "", size.0, "then", "is held", "", "then", "at rest", "runs"]),
            row(["", "m/s²", "g", size.1, "", "m/s²", "g", "", "m/s²", ""]),
        ];
        for load in &self.loads {
            let ([slips, slips_g], [drops, drops_g]) = (limit(&load.slips, self), limit(&load.drops, self));
            let then = |limit: &LimitReport| limit.ended_by.unwrap_or("–").to_string();
            let size = load.slips.held_size.map_or("–".to_string(), size_figure);
            let runs = load.runs.len().to_string();
            let at_rest = match (load.quasi_static, load.quasi_static_m_s2) {
                (_, Some(most)) => figure(most, 4),
                (word, None) => word.unwrap_or("–").to_string(),
            };
            let (slips_then, drops_then) = (then(&load.slips), then(&load.drops));
            rows.push(vec![name(load), slips, slips_g, size, slips_then, drops, drops_g, drops_then, at_rest, runs]);
        }
        text.push(Table::new(&rows).heads(2));
        text.push_str("\n");
        if self.loads.iter().any(|load| load.quasi_static.is_some()) {
            text.push(Report::paragraph(
                "at rest: the largest acceleration, there and back, that some forces balance of the contacts that press when loads begin.\n",
            ));
        }
        for line in least(self).into_iter().chain(self.loads.iter().flat_map(|load| remarks(load, self))) {
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

fn load_head(report: &HoldReport) -> &'static str {
    match report.loads.first().map(|load| load.load) {
        Some("pulse") => "pulse to",
        Some("vibration") => "vibration",
        _ => "load",
    }
}

/// What the size of these loads is, and its unit.
fn size_head(report: &HoldReport) -> (&'static str, &'static str) {
    match report.loads.first() {
        Some(load) if load.load == "pulse" => ("going", "mm"),
        Some(load) if load.load == "vibration" => ("amplitude", "mm or deg"),
        _ => ("taking", "ms"),
    }
}

fn size_figure(size: SizeReport) -> String {
    let SizeReport { distance_m, amplitude_m, amplitude_rad, time_s } = size;
    let thousandths = distance_m.or(amplitude_m).or(time_s).map(|si| si * 1e3);
    let text = thousandths.or(amplitude_rad.map(f64::to_degrees)).map_or("–".to_string(), |value| figure(value, 3));
    if amplitude_rad.is_some() { format!("{text}°") } else { text }
}

/// Which load it is.
fn name(load: &LoadReport) -> String {
    let along = |rad: f64| {
        let degrees = rad.to_degrees();
        let towards = match degrees.round() as i64 {
            0 => ", +x",
            90 => ", +y (out of the palm)",
            180 => ", −x",
            270 => ", −y (into it)",
            _ => "",
        };
        format!("{}°{towards}", figure(degrees, 4).trim_end_matches('0').trim_end_matches('.').replace("–", "0"))
    };
    match (load.direction_rad, load.axis.zip(load.frequency_hz)) {
        (Some(0.0), _) => "0°, +x".to_string(),
        (Some(rad), _) => along(rad),
        (None, Some((axis, frequency_hz))) => format!("{axis}, {} Hz", figure(frequency_hz, 4)),
        (None, None) => "move".to_string(),
    }
}

/// The limit as accelerations and as multiples of gravity.
fn limit(limit: &LimitReport, report: &HoldReport) -> [String; 2] {
    let mark = if limit.monotone && limit.unfinished == 0 { "" } else { " *" };
    [1.0, G_M_S2].map(|unit| match (limit.held_m_s2, limit.failed_m_s2) {
        (Some(held), Some(_)) => format!("{}{mark}", figure(held / unit, 4)),
        (Some(held), None) => format!("≥ {}{mark}", figure(held / unit, 4)),
        (None, Some(failed)) => format!("< {}{mark}", figure(failed / unit, 4)),
        (None, None) => format!("?{}", if report.unfinished > 0 { " *" } else { "" }),
    })
}

/// The load that it holds least of.
fn least(report: &HoldReport) -> Option<String> {
    let failed = report.loads.iter().filter_map(|load| Some((load, load.slips.failed_m_s2?)));
    let Some((load, failed)) = failed.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Some("Nothing that was tried makes it slip by more.".to_string());
    };
    match load.slips.held_m_s2 {
        _ if report.loads.len() == 1 => None,
        Some(held) => {
            Some(format!("Least: {} m/s² ({} g), {}.", figure(held, 4), figure(held / G_M_S2, 3), name(load)))
        }
        None => Some(format!("Least: less than {} m/s², {}; ask from less on: --from.", figure(failed, 4), name(load))),
    }
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
