//! Text report of a validation: short tables with units.

use std::fmt::Write;

use super::document::{
    CheckReport, CriterionReport, ImpactReport, ModelReport, SettingReport, Status, ValidationReport, ValueReport,
};
use super::invariants::FindingReport;
use super::numbers::number;
use super::side_by_side::{differences, side_by_side};
use super::statistics::statistics_table;
use crate::format::format_duration;
use crate::format::numbers::{format_number, row};
use crate::format::report::{Report, Table, ToReport, table};

impl ToReport for ValidationReport {
    fn report(&self) -> Report {
        Report::join(std::iter::once(self.verdict_report()).chain(self.ladder_report()))
    }
}

impl ValidationReport {
    /// Returns the verdict and the results it is based on.
    pub fn verdict_report(&self) -> Report {
        let mut sections = vec![Report::from(heading(self)), checks(&self.verdict)];
        sections.extend(criteria(&self.criteria, self.reason_not_judged));
        let violated_invariants =
            describe_violations([("analytic", &self.analytic.invariants), ("engine", &self.engine.invariants)]);
        if !violated_invariants.is_empty() {
            sections.push(Report::from(violated_invariants));
        }
        sections.push(side_by_side(self));
        sections.extend(self.impacts.as_deref().filter(|all| !all.is_empty()).map(impacts));
        sections.extend(self.statistics.iter().flatten().map(statistics_table));
        sections.push(differences(&self.differences));
        Report::join(sections)
    }

    /// Returns the ladder and the list of files; `None` without either.
    pub fn ladder_report(&self) -> Option<Report> {
        let omitted = match self.is_single_finger() {
            true => "fixed steps below 1e-5 s, reduced coordinates",
            false => "fixed steps below 1e-5 s",
        };
        let mut sections = Vec::new();
        sections.extend(self.ladder_time_s.map(|time_s| settings(self, time_s, self.quick.then_some(omitted))));
        if let (Some(directory), Some(files)) = (&self.directory, &self.files) {
            sections.push(Report::from(format!("in {directory}: {}\n", files.join(", "))));
        }
        (!sections.is_empty()).then(|| Report::join(sections))
    }
}

/// Returns the criteria of both models side by side; `None` if there are none.
fn criteria(criteria: &[CriterionReport], reason_not_judged: Option<&str>) -> Option<Report> {
    let mut rows = vec![row(["criterion", "analytic", "engine"])];
    for criterion in criteria {
        let (meaning, scale, digits) = match criterion.criterion {
            "stability_time_s" => ("time to stability, ms", 1e3, 8),
            "lost_time" => ("lost for, ms", 1e3, 5),
            "contacts_lost" => ("contacts lost", 1.0, 6),
            "form_closed" => ("form-closed", 1.0, 1),
            other => (other, 1.0, 5),
        };
        let name = match &criterion.subject {
            Some(subject) => format!("{} {meaning}", subject.replace('_', " ")),
            None => meaning.to_string(),
        };
        let cell = |value: ValueReport| match value {
            ValueReport::Label(label) => label.to_string(),
            ValueReport::Number(value) => number(value.map(|value| value * scale), digits),
        };
        rows.push(row([&name, &cell(criterion.analytic), &cell(criterion.engine)]));
    }
    if rows.len() < 2 {
        return None;
    }
    let mut text = table(&rows);
    if let Some(reason) = reason_not_judged {
        text.push_str(&format!("criteria are not judged: {reason}\n"));
    }
    Some(text)
}

/// Setting and number of steps of a model.
fn setting_and_steps(model: &ModelReport) -> String {
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
    let _ = writeln!(text, "analytic: {} (the reference)", setting_and_steps(&report.analytic));
    let _ = writeln!(text, "engine:   {} (the scene's settings)", setting_and_steps(&report.engine));
    // The quantity that is varied within the ensemble.
    let varied = if report.has_discs_only() { "speeds and gravity" } else { "motor torque" };
    let step = report.ensemble_torque_step.or(report.ensemble_speed_step).unwrap_or_default();
    let _ = writeln!(
        text,
        "compared up to {} of {}; differences are the worst of {} runs with {varied} varied in steps of {step:e}",
        format_duration(report.until_s),
        format_duration(report.duration_s),
        report.ensemble_runs,
    );
    if !report.passed {
        let _ = writeln!(text, "{}", advice(report));
    }
    text
}

/// Returns which model to trust, and which setting of the engine passes.
fn advice(report: &ValidationReport) -> String {
    let unit = if report.has_discs_only() { "m" } else { "rad" };
    let agreement = match report.reference_error {
        Some(error) => format!("its two integration methods agree to {error:.1e} {unit}"),
        None => "its two integration methods could not be compared".to_string(),
    };
    if report.trusted_model.is_none() {
        return format!("Neither model can be trusted: the analytic model is not a valid reference here; {agreement}.");
    }
    let engine = match report.finer_settings.last() {
        Some(finer) if finer.passed => format!("The engine passes with [engine] {}.", finer.setting),
        Some(finer) => format!("The engine does not pass with [engine] {} either.", finer.setting),
        None => "No finer setting of the engine was run.".to_string(),
    };
    format!("Trust the analytic model: {agreement}. {engine}")
}

fn checks(checks: &[CheckReport]) -> Report {
    let mut rows = vec![row(["bound", "measured", "limit", ""])];
    for check in checks {
        let measured = match check.measured {
            Some(value) if value.is_infinite() => "missing in one".to_string(),
            Some(value) => format_number(value, 3),
            None => "none".to_string(),
        };
        let passed = if check.passed { "pass" } else { "FAIL" };
        rows.push(row([
            &format!("{} ({})", check.bound, check.meaning),
            &measured,
            &format_number(check.limit, 3),
            passed,
        ]));
    }
    table(&rows)
}

/// Lists the invariants that each model violated, one per line.
fn describe_violations(models: [(&str, &[FindingReport]); 2]) -> String {
    let mut text = String::new();
    for (name, invariants) in models {
        for found in invariants.iter().filter(|found| !found.is_satisfied) {
            let _ = writeln!(text, "invariant violated by the {name} model ({}): {}", found.meaning, found.line);
        }
    }
    text
}

/// Maximum number of impacts in the table; the JSON document contains all.
const MAX_IMPACTS: usize = 12;

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
    let or_dash =
        |value: Option<f64>, digits: usize| value.map_or("–".to_string(), |value| format_number(value, digits));
    for impact in impacts.iter().take(MAX_IMPACTS) {
        let difference = match (impact.analytic_n_s, impact.engine_n_s) {
            (Some(analytic), Some(engine)) if analytic != 0.0 => Some(100.0 * (engine / analytic - 1.0)),
            _ => None,
        };
        rows.push(row([
            &impact.contact,
            &or_dash(impact.analytic_s.map(|s| s * 1e3), 7),
            &or_dash(impact.engine_s.map(|s| s * 1e3), 7),
            &format_number(impact.window_s * 1e6, 5),
            &or_dash(impact.analytic_n_s.map(|n_s| n_s * 1e3), 5),
            &or_dash(impact.engine_n_s.map(|n_s| n_s * 1e3), 5),
            &or_dash(difference, 3),
        ]));
    }
    let mut text = table(&rows);
    if impacts.len() > MAX_IMPACTS {
        let _ = writeln!(text, "and {} more", impacts.len() - MAX_IMPACTS);
    }
    text
}

fn settings(report: &ValidationReport, time_s: f64, omitted: Option<&str>) -> Report {
    let settings = &report.settings;
    let mut text = Report::default();
    let mut rows = vec![
        row(["speed against error", "runs", "steps", "wall, ms", "× real", "× everyday"]),
        row(["", "", "", "", "time", "analytic"]),
    ];
    let headers = settings.first().map(|setting| setting.errors.headers()).unwrap_or_default();
    for (line, header) in rows.iter_mut().zip(headers) {
        line.extend(header);
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
                notes.push(format!("{}, {}: omitted, {reason}", family, setting.setting))
            }
        }
    }
    text.push(Table::new(&rows).header_rows(2));
    text.push_str(
        "largest differences from the reference over the runs; * the scene's settings; median wall time without a log\n",
    );
    if let Some(omitted) = omitted {
        let _ = writeln!(text, "omitted by --quick: {omitted}");
    }
    if settings.iter().any(|setting| setting.status == Status::NoTime) {
        let _ = writeln!(
            text,
            "settings were omitted to keep the ladder within {} (--ladder-time)",
            format_duration(time_s)
        );
    }
    for note in notes {
        let _ = writeln!(text, "{note}");
    }
    text
}

fn cells(setting: &SettingReport) -> Vec<String> {
    let mark = if setting.is_from_scene { " *" } else { "" };
    let name = format!("  {}{mark}", setting.setting);
    let (Some(steps), Some(wall_s)) = (setting.steps, setting.wall_s) else {
        let status = if setting.status == Status::Failed { "failed" } else { "omitted" };
        return row([&name, "–", "–", status]);
    };
    let runs = if setting.is_reference { "–".to_string() } else { setting.ensemble_runs.to_string() };
    let mut cells = row([
        &name,
        &runs,
        &steps.to_string(),
        &format_number(wall_s * 1e3, 3),
        &number(setting.real_time_factor, 3),
        &number(setting.analytic_factor, 3),
    ]);
    cells.extend(setting.errors.cells());
    if setting.is_reference {
        cells[0].push_str(" (reference)");
    }
    cells
}
