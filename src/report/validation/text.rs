//! The report of a validation for people: short tables with units.

use std::fmt::Write;

use super::document::{
    CheckReport, CriterionReport, ImpactReport, ModelReport, SettingReport, Status, ValidationReport, ValueReport,
};
use super::figures::number;
use super::invariants::FindingReport;
use super::side_by_side::{differences, side_by_side};
use super::statistics::statistics_text;
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::report::{Report, Reported, Table, table};

/// The whole report, with a line end.
impl Reported for ValidationReport {
    fn report(&self) -> Report {
        Report::join(std::iter::once(self.of_verdict()).chain(self.of_ladder()))
    }
}

impl ValidationReport {
    /// The verdict and what it is made of.
    pub fn of_verdict(&self) -> Report {
        let mut sections = vec![Report::from(heading(self)), checks(&self.verdict)];
        sections.extend(criteria(&self.criteria, self.criteria_unjudged));
        let broken = broken([("analytic", &self.analytic.invariants), ("engine", &self.engine.invariants)]);
        if !broken.is_empty() {
            sections.push(Report::from(broken));
        }
        sections.push(side_by_side(self));
        sections.extend(self.impacts.as_deref().filter(|all| !all.is_empty()).map(impacts));
        sections.extend(self.statistics.iter().flatten().map(statistics_text));
        sections.push(differences(&self.differences));
        Report::join(sections)
    }

    /// What follows: the ladder, and where the files are; `None` without either.
    pub fn of_ladder(&self) -> Option<Report> {
        let left_out = match self.has_coordinates() {
            true => "fixed steps below 1e-5 s, reduced coordinates",
            false => "fixed steps below 1e-5 s",
        };
        let mut sections = Vec::new();
        sections.extend(self.ladder_time_s.map(|time_s| settings(self, time_s, self.quick.then_some(left_out))));
        if let (Some(directory), Some(files)) = (&self.directory, &self.files) {
            sections.push(Report::from(format!("in {directory}: {}\n", files.join(", "))));
        }
        (!sections.is_empty()).then(|| Report::join(sections))
    }
}

/// Both models' criteria side by side; `None` where there are none.
fn criteria(criteria: &[CriterionReport], unjudged: Option<&str>) -> Option<Report> {
    let mut rows = vec![row(["criterion", "analytic", "engine"])];
    for found in criteria {
        let (meaning, scale, digits) = match found.criterion {
            "stability_time_s" => ("time to stability, ms", 1e3, 8),
            "lost_time" => ("lost for, ms", 1e3, 5),
            "contacts_lost" => ("contacts lost", 1.0, 6),
            "form_closed" => ("form-closed", 1.0, 1),
            other => (other, 1.0, 5),
        };
        let name = match &found.of {
            Some(of) => format!("{} {meaning}", of.replace('_', " ")),
            None => meaning.to_string(),
        };
        let cell = |value: ValueReport| match value {
            ValueReport::Word(word) => word.to_string(),
            ValueReport::Figure(value) => number(value.map(|value| value * scale), digits),
        };
        rows.push(row([&name, &cell(found.analytic), &cell(found.engine)]));
    }
    if rows.len() < 2 {
        return None;
    }
    let mut text = table(&rows);
    if let Some(why) = unjudged {
        text.push_str(&format!("criteria are not judged: {why}\n"));
    }
    Some(text)
}

/// A model's setting and steps.
fn cost_of(model: &ModelReport) -> String {
    format!("{}, {} steps", model.setting, model.steps)
}

fn heading(report: &ValidationReport) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}: engine against analytic model: {}",
        report.scene,
        if report.passed { "within all bounds" } else { "OUT OF BOUNDS" }
    );
    let _ = writeln!(text, "analytic: {} (the reference)", cost_of(&report.analytic));
    let _ = writeln!(text, "engine:   {} (the scene's settings)", cost_of(&report.engine));
    // What differs from one run of the ensemble to the next.
    let apart = if report.is_of_discs() { "speeds and gravity" } else { "motor torque" };
    let step = report.ensemble_torque_step.or(report.ensemble_speed_step).unwrap_or_default();
    let _ = writeln!(
        text,
        "compared up to {} of {}; differences are the worst of {} runs, {apart} {step:e} apart",
        duration(report.until_s),
        duration(report.duration_s),
        report.ensemble_runs,
    );
    if !report.passed {
        let _ = writeln!(text, "{}", advice(report));
    }
    text
}

/// Which model to trust, and which setting of the engine passes.
fn advice(report: &ValidationReport) -> String {
    let unit = if report.is_of_discs() { "m" } else { "rad" };
    let agree = match report.reference_error {
        Some(error) => format!("its own two methods agree to {error:.1e} {unit}"),
        None => "its own two methods could not be compared".to_string(),
    };
    if report.trusted.is_none() {
        return format!("Trust neither model: the analytic one is no reference here, {agree}.");
    }
    let engine = match report.finer.last() {
        Some(finer) if finer.passed => format!("The engine passes with [engine] {}.", finer.setting),
        Some(finer) => format!("The engine does not pass with [engine] {} either.", finer.setting),
        None => "No finer setting of the engine was run.".to_string(),
    };
    format!("Trust the analytic model: {agree}. {engine}")
}

fn checks(checks: &[CheckReport]) -> Report {
    let mut rows = vec![row(["bound", "measured", "limit", ""])];
    for check in checks {
        let measured = match check.measured {
            Some(value) if value.is_infinite() => "missing in one".to_string(),
            Some(value) => figure(value, 3),
            None => "nothing there".to_string(),
        };
        let passed = if check.passed { "pass" } else { "FAIL" };
        rows.push(row([&format!("{} ({})", check.bound, check.meaning), &measured, &figure(check.limit, 3), passed]));
    }
    table(&rows)
}

/// The invariants that each model broke, a line each.
fn broken(models: [(&str, &[FindingReport]); 2]) -> String {
    let mut text = String::new();
    for (name, invariants) in models {
        for found in invariants.iter().filter(|found| !found.held) {
            let _ = writeln!(text, "broken by the {name} model ({}): {}", found.meaning, found.line);
        }
    }
    text
}

/// More impacts than this make no table for people; the JSON document has them all.
const MOST_IMPACTS: usize = 12;

fn impacts(impacts: &[ImpactReport]) -> Report {
    let mut rows = vec![row([
        "impact",
        "analytic, ms",
        "engine, ms",
        "for, µs",
        "impulse: analytic, mN·s",
        "engine, mN·s",
        "difference, %",
    ])];
    let or_dash = |value: Option<f64>, digits: usize| value.map_or("–".to_string(), |value| figure(value, digits));
    for impact in impacts.iter().take(MOST_IMPACTS) {
        let relative = match (impact.analytic_n_s, impact.engine_n_s) {
            (Some(ours), Some(theirs)) if ours != 0.0 => Some(100.0 * (theirs / ours - 1.0)),
            _ => None,
        };
        rows.push(row([
            &impact.site,
            &or_dash(impact.analytic_s.map(|s| s * 1e3), 7),
            &or_dash(impact.engine_s.map(|s| s * 1e3), 7),
            &figure(impact.window_s * 1e6, 5),
            &or_dash(impact.analytic_n_s.map(|n_s| n_s * 1e3), 5),
            &or_dash(impact.engine_n_s.map(|n_s| n_s * 1e3), 5),
            &or_dash(relative, 3),
        ]));
    }
    let mut text = table(&rows);
    if impacts.len() > MOST_IMPACTS {
        let _ = writeln!(text, "and {} more", impacts.len() - MOST_IMPACTS);
    }
    text
}

fn settings(report: &ValidationReport, time_s: f64, left_out: Option<&str>) -> Report {
    let settings = &report.settings;
    let mut text = Report::default();
    let mut rows = vec![
        row(["speed against error", "runs", "steps", "wall, ms", "× real", "× everyday"]),
        row(["", "", "", "", "time", "analytic"]),
    ];
    let heads = settings.first().map(|setting| setting.errors.heads()).unwrap_or_default();
    for (line, heads) in rows.iter_mut().zip(heads) {
        line.extend(heads);
    }
    let mut notes = Vec::new();
    let mut family = "";
    for setting in settings {
        if setting.family != family {
            family = setting.family;
            rows.push(row([family]));
        }
        rows.push(cells(setting));
        match (setting.status, &setting.reason) {
            (Status::Done, _) | (_, None) => {}
            (Status::Failed, Some(reason)) => notes.push(format!("{}, {}: {reason}", family, setting.setting)),
            (Status::TooLong | Status::NoTime, Some(reason)) => {
                notes.push(format!("{}, {}: left out, {reason}", family, setting.setting))
            }
        }
    }
    text.push(Table::new(&rows).heads(2));
    text.push_str(
        "largest differences from the reference over so many runs; * the scene's settings; median wall time, no log\n",
    );
    if let Some(left_out) = left_out {
        let _ = writeln!(text, "left out by --quick: {left_out}");
    }
    if settings.iter().any(|setting| setting.status == Status::NoTime) {
        let _ = writeln!(text, "the ladder took as many settings as {} allow (--ladder-time)", duration(time_s));
    }
    for note in notes {
        let _ = writeln!(text, "{note}");
    }
    text
}

fn cells(setting: &SettingReport) -> Vec<String> {
    let mark = if setting.own { " *" } else { "" };
    let name = format!("  {}{mark}", setting.setting);
    let (Some(steps), Some(wall_s)) = (setting.steps, setting.wall_s) else {
        let word = if setting.status == Status::Failed { "failed" } else { "left out" };
        return row([&name, "–", "–", word]);
    };
    let runs = if setting.reference { "–".to_string() } else { setting.ensemble_runs.to_string() };
    let mut cells = row([
        &name,
        &runs,
        &steps.to_string(),
        &figure(wall_s * 1e3, 3),
        &number(setting.real_time_factor, 3),
        &number(setting.analytic_factor, 3),
    ]);
    cells.extend(setting.errors.cells());
    if setting.reference {
        cells[0].push_str(" (reference)");
    }
    cells
}
